"""Poses that take no part as they are far off, and share a place: said as what is unknown there, with what to do about it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from camrob.gap.observation.noise import local_of
from camrob.gap.observation.scene import Scene
from camrob.gap.verdict.belief import BELIEF
from camrob.summaries.diagnosis_places import LocalPoses
from camrob.summaries.diagnosis_summary import DiagnosisSummary, UnknownPlace, UnknownShape
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["with_local_poses"]

_STAGE = "encoder_to_tcp"
_OF_AXIS = (
    "look at what {axis} meets with {place}: its encoder (dirt on the disc, the cable), and what touches, clamps or pulls there; "
    "look for the same error on three poses there, measured again with the other axes elsewhere: then it is {axis}'s"
)
_OF_ROOM = (
    "measure three of these poses again, and then with the instrument elsewhere, clear of hot air, draughts, reflections and "
    "edges in its beam; look for an error that goes: it was the beam's; what stays is what the arm or its hoses touch there"
)


def with_local_poses(summary: DiagnosisSummary, scenes: Sequence[Scene]) -> DiagnosisSummary:
    """The summary with the place that poses share which are far off: `gap` and `together` stay as they are, of all other rows."""
    found = [one for s in scenes if (one := _said(s)) is not None]
    if not found:
        return summary
    most = max(found, key=lambda one: one.rms_mm**2 * one.poses)
    here = most.rms_mm**2 * most.poses / most.of  # of their energy, over all poses
    taken = max(summary.together.rms_before_mm**2 - summary.together.rms_after_mm**2, 0.0)
    unknown, first = summary.unknown, here > summary.unknown.rms_mm**2
    axes = (most.axis,) if most.axis else ()
    where = UnknownPlace(stage=_STAGE, axes=axes, regimes=("position",), comes_back="") if first else unknown.where
    step = (_OF_AXIS if most.axis else _OF_ROOM).format(place=most.place, axis=most.axis)
    shape = UnknownShape(stage=_STAGE, moves="tool", follows=most.place, swing=most.worst_mm, unit="mm")
    asked = here > taken
    return replace(
        summary,
        where=replace(summary.where, local=tuple(found)),
        unknown=replace(
            unknown,
            probability=max(unknown.probability, BELIEF.surest),
            where=where,
            text="; ".join(w for w in (_text(most), unknown.text) if w),
            shapes=(shape, *unknown.shapes),
            isolated_by=step if first else unknown.isolated_by,
        ),
        status="partly explained" if summary.status in ("explained", "partly explained") else "unexplained",
        next_experiment=f"Isolate what is unexplained: {step}." if asked else summary.next_experiment,
        next_experiment_for=("unknown",) if asked else summary.next_experiment_for,
        experiment=None if asked else summary.experiment,
    )


def _text(one: LocalPoses) -> str:
    return (
        f"{one.poses} of {one.of} poses of {one.log} are {one.rms_mm:.2g} mm rms off, and up to {one.worst_mm:.2g} mm, all with "
        f"{one.place}, where hardly any other is: they take no part in what else is said"
    )


def _said(scene: Scene) -> LocalPoses | None:
    """What shares a place on one log; None for nothing."""
    found = local_of(scene)
    if found is None:
        return None
    joint = None if not found.axis else scene.cell.joints[scene.cell.index(found.axis)]
    turns = joint is not None and not joint.prismatic
    edge = rad_to_deg if turns else m_to_mm
    off = found.off[found.rows]
    return LocalPoses(
        log=scene.name,
        poses=len(off),
        of=len(scene),
        axis=found.axis,
        low=tuple(edge(float(v)) for v in found.low),
        high=tuple(edge(float(v)) for v in found.high),
        unit="degrees" if turns else "mm",
        rms_mm=m_to_mm(float(np.sqrt(np.mean(off**2)))),
        worst_mm=m_to_mm(float(off.max())),
    )
