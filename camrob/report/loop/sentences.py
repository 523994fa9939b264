"""The tracker study in words: each figure of the paper beside what the simulation gave, and what kind of agreement that is."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.loop.gain import joint_loops, worst_margins
from camrob.loop.measures import RunMeasure
from camrob.studies.loop_study import TrackerStudy
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["Comparison", "circle_places", "reduction", "tracker_comparisons"]

Array = NDArray[np.float64]

TUNED, RESULT, CHECKED = "tuned", "result", "checked"


class Comparison(NamedTuple):
    """`what` is compared, as `published` and as `found`; `kind`: the simulated robot was `tuned` to it (consistency, no
    proof), it is a `result` of the simulation, or an equation was `checked`.
    """

    what: str
    published: str
    found: str
    kind: str


def _mm(value: float, decimals: int = 2) -> str:
    return f"{float(m_to_mm(value)):.{decimals}f}"


def reduction(before: float, after: float) -> float:
    """By what share of itself something shrank: 0.9 where a tenth is left."""
    return 1.0 - after / before


def _shrunk(before: float, after: float) -> str:
    return f"{100.0 * reduction(before, after):.0f} %"


def circle_places(study: TrackerStudy) -> tuple[tuple[float, tuple[int, ...]], ...]:
    """Where on the circle joints turn round: degrees from +X, and the joints (0 to 5)."""
    path = study.paths[1]
    out = []
    for turn in study.variant("none").of_circle.reversals:
        x, y = np.asarray(path.wanted)[turn.cycle, :2] - path.center[:2]
        out.append((float(rad_to_deg(float(np.arctan2(y, x)))) % 360.0, turn.axes))
    return tuple(out)


def tracker_comparisons(study: TrackerStudy) -> tuple[Comparison, ...]:
    """The paper's figures beside ours, as plain text."""
    return (*_without(study), *_with(study), *_equations(study))


def _without(study: TrackerStudy) -> tuple[Comparison, ...]:
    none = study.variant("none")
    static = np.abs(none.of_square.static)
    wave = [float(rad_to_deg(float(np.ptp(none.square.error[none.square.run.path.moving, k])))) for k in (3, 4, 5)]
    circle = none.of_circle
    return (
        Comparison(
            "square, static errors of x, y, z",
            "0.1 to 0.4 mm",
            f"{', '.join(_mm(float(v)) for v in static[:3])} mm",
            TUNED,
        ),
        Comparison(
            "square, static errors of the three angles",
            "0.1 to 0.15 deg",
            f"{', '.join(f'{float(rad_to_deg(float(v))):.2f}' for v in static[3:])} deg",
            TUNED,
        ),
        Comparison(
            "square, linear errors in motion",
            "above 1 mm",
            f"up to {', '.join(_mm(a.most) for a in none.of_square.axes[:3])} mm in x, y, z",
            TUNED,
        ),
        Comparison(
            "square, rotations in motion",
            "fluctuate by more than 0.05 deg",
            f"by {', '.join(f'{w:.2f}' for w in wave)} deg from end to end",
            TUNED,
        ),
        Comparison(
            "circle, path errors",
            "large parts up to 0.2 mm, some sections more",
            f"95 % within {_mm(circle.seen_path.p95)} mm, up to {_mm(circle.seen_path.most)} mm as the tracker sees it",
            TUNED,
        ),
    )


def _axes(measure: RunMeasure, *, seen: bool) -> str:
    return ", ".join(f"{float(m_to_mm(a.mean)):.3f}" for a in (measure.seen_axes if seen else measure.axes)[:3])


def _with(study: TrackerStudy) -> tuple[Comparison, ...]:
    before, after = study.before, study.of_switched
    none, published = study.variant("none").of_circle, study.variant("published").of_circle
    axes = [_shrunk(b.rms, a.rms) for b, a in zip(before.axes[:3], after.axes[:3], strict=True)]
    angles = [_shrunk(b.rms, a.rms) for b, a in zip(before.axes[3:], after.axes[3:], strict=True)]
    seconds, law = study.case.switched_on, study.case.law
    places = ", ".join(
        f"{at:.0f} deg ({' and '.join(f'A{i + 1}' for i in sorted(axes_))})" for at, axes_ in circle_places(study)
    )
    margins = worst_margins(joint_loops(study.case, np.asarray(study.case.robot.lag)), law.gain)
    return (
        Comparison(
            f"square, linear errors with the correction (on at {seconds:g} s)",
            "close to the tracker's 0.025 mm, peaks at corners and reversals",
            f"mean {_axes(after, seen=True)} mm in x, y, z as seen, {_axes(after, seen=False)} mm in truth; up to "
            f"{_mm(after.corners.max())} mm at corners",
            RESULT,
        ),
        Comparison(
            "path errors, by how much they shrink (conclusion, taken as the square's)",
            "80 to 90 %",
            f"tool to set-point {_shrunk(before.tool.rms, after.tool.rms)} (rms), "
            f"{_shrunk(before.tool.mean, after.tool.mean)} (mean); off the path "
            f"{_shrunk(before.path.mean, after.path.mean)} (mean), {_shrunk(before.seen_path.mean, after.seen_path.mean)} "
            f"as the tracker sees it, its noise included; x, y, z {', '.join(axes)}; "
            f"A, B, C {', '.join(angles)} (rms)",
            RESULT,
        ),
        Comparison(
            "circle, by how much path errors shrink (Figure 7)",
            "66 %",
            f"{_shrunk(none.path.mean, published.path.mean)} (mean), "
            f"{_shrunk(none.seen_path.mean, published.seen_path.mean)} as the tracker sees it: "
            f"{_mm(none.path.mean, 3)} to {_mm(published.path.mean, 3)} mm",
            RESULT,
        ),
        Comparison(
            "reversals on the circle",
            "peaks in arbitrary places, as the joints' posture has it",
            f"at {places}",
            RESULT,
        ),
        Comparison(
            "the increment's bound acts",
            "when the correction is switched on, not later",
            f"later in {100.0 * after.late_cuts:.2f} % of the cycles, at corners (the bound is assumed)",
            RESULT,
        ),
        Comparison(
            f"K = {law.gain:g}",
            "by trial and error",
            f"stable with room to {margins.gain:.0f} times the gain, {float(rad_to_deg(margins.phase)):.0f} deg of phase, "
            f"{margins.delay:.0f} cycles of latency; {study.choice.chosen:g} by analysis",
            RESULT,
        ),
    )


def _equations(study: TrackerStudy) -> tuple[Comparison, ...]:
    return (
        Comparison(
            "eq. 1, pose from distance, two angles and quaternion",
            "as printed",
            f"holds: poses there and back agree to {study.eq1_off:.0e}; alpha counts from the tracker's vertical axis",
            CHECKED,
        ),
        Comparison(
            "eq. 2, T(TCP in tracker) T(tracker in base)",
            "as printed",
            f"the order is the other one: as printed the tool is {study.order_off:.2f} m off; "
            "used: T(tracker in base) T(TCP in tracker)",
            CHECKED,
        ),
        Comparison(
            "eq. 3, XYZ extrinsic angles",
            "as printed",
            "holds: R = Rz(yaw) Ry(pitch) Rx(roll); differences within half a turn, refused where pitch nears 90 deg",
            CHECKED,
        ),
    )
