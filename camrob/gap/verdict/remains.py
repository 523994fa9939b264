"""What stays once the claimed effects are taken away: how large, at which stage, of which axis, and what it follows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from camrob.gap.evidence.design import Panel
from camrob.gap.evidence.model import Model
from camrob.gap.evidence.shrink import Shrinkage
from camrob.gap.locate.localise import axes_of, regimes_of
from camrob.gap.verdict.plausible import unknown_text
from camrob.units import m_to_mm

__all__ = ["left_panels", "remains", "residual_regimes"]

Set = frozenset[int]

_CLEAR = 0.05  # p value under which what stays follows something
_WORTH = 0.1  # share of its energy from which that is worth a word
_OF_AXIS = 0.5  # share of its energy that one axis has to explain to be named


def left_panels(model: Model, members: Set) -> list[Panel]:
    """The logs without what some units, and frames that nobody told, explain."""
    values = model.values(members | model.evidence.always, model.best)
    left = []
    for p in model.panels:
        y_servo = None if p.y_servo is None or p.servo is None else p.y_servo - p.servo @ values[p.servo_columns]
        known = ~p.unknown_rows(np.flatnonzero(values))
        left.append(replace(p, y_tcp=p.y_tcp - p.tcp @ values, y_servo=y_servo, w_tcp=p.w_tcp * known[:, None]))
    return left


def residual_regimes(model: Model, panels: Sequence[Panel]) -> list[dict[str, Any]]:
    """What the residual still depends on."""
    found = regimes_of(panels, model.noise)
    return [{"regime": k, "p_value": v["p_value"], "share": v["share"]} for k, v in found.items()]


def remains(
    model: Model,
    panels: Sequence[Panel],
    together: Shrinkage,
    probability: float,
    shapes: Sequence[Mapping[str, Any]],
    regimes: Sequence[Mapping[str, Any]],
) -> dict[str, Any]:
    """The JSON object `unknown`, but for what is implausible. panels: without the claimed effects; together: by how much these
    shrink the gap; shapes: of the unexplained, where its place has one; regimes: of the residual.
    """
    rms = float(np.sqrt(max(0.0, together.rms_after**2 - model.noise**2)))
    share = min(1.0, (rms / max(together.rms_before, 1e-12)) ** 2)
    told = {"probability": probability, "rms_mm": m_to_mm(rms), "share": share}
    if probability < 0.5:
        return {**told, "where": {"rung": None, "axes": [], "regimes": []}, "text": "", "shapes": []}
    follows = sorted((r for r in regimes if r["p_value"] < _CLEAR and r["share"] > _WORTH), key=lambda r: -r["share"])
    names = [str(r["regime"]) for r in follows]
    where: dict[str, Any] = {"rung": _rung(panels, model), "axes": _axis(panels), "regimes": names}
    text = f"{m_to_mm(rms):.3f} mm rms, {rms / model.noise:.1f} times the noise, stays unexplained"
    text += f", and follows {' and '.join(names[:2])}" if names else ""
    if shapes:
        axes = model.scenes[0].axes
        moved = dict.fromkeys(str(s["moves"]) for s in shapes)
        where |= {"rung": shapes[0]["rung"], "axes": [a for a in moved if a in axes]}
        text = unknown_text(model, shapes)
    return {**told, "where": where, "text": text, "shapes": list(shapes)}


def _rung(panels: Sequence[Panel], model: Model) -> str:
    """Where most of what stays sits."""
    drives, arm = 0.0, 0.0
    for p in panels:
        good = p.w_tcp[:, 0] > 0.0
        if p.y_servo is not None:
            drives += float(np.sum(p.carried(p.y_servo)[good] ** 2))
        arm += float(np.sum(p.y_tcp[good, :3] ** 2) - good.sum() * model.noise**2)
    return "setpoint_to_encoder" if drives > max(arm, 0.0) else "encoder_to_tcp"


def _axis(panels: Sequence[Panel]) -> list[str]:
    """The axis whose shift explains most of what stays, [] where that is not the most part."""
    shares = axes_of(panels)
    best = max(shares, key=lambda a: shares[a].value, default="")
    return [best] if best and shares[best].value > _OF_AXIS else []
