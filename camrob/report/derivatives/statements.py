"""What section III of Samak and others states, beside what was found on the same use case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.report.page.statements import Statement
from camrob.timing.derivative_analysis import DerivativeAnalysis
from camrob.units import rad_to_deg

__all__ = ["derivative_statements"]

Array = NDArray[np.float64]

_ALIKE = 0.05  # of a derivative's size: compensated peaks that differ by less are not significantly larger
_EQUATIONS = (("q_s", "speed", "21"), ("q_ss", "acceleration", "27"), ("q_sss", "jerk", "28"))


def derivative_statements(
    analyses: Mapping[str, Sequence[DerivativeAnalysis]], *, rate: float, points: int, length_mm: float
) -> tuple[Statement, ...]:
    """The statements for nominal and compensated coordinates (two analyses an interpolation, "linear" and "smooth")."""
    nominal, compensated = analyses["smooth"]
    return (
        Statement(
            "A straight line of approximately 1500 mm, 297 points 5 mm apart; s divided evenly into 2900 parts.",
            f"{points} points over {length_mm:.0f} mm; s runs to {nominal.s[-1]:.3f} rad, compensated to "
            f"{compensated.s[-1]:.3f} rad, in {len(nominal.s) - 1} parts (the paper shows s from 0.4 to 1.5 rad).",
            "holds",
        ),
        _violations(analyses, rate),
        _shift(nominal, compensated),
        _linear(analyses["linear"], analyses["smooth"]),
        _signs(nominal),
        Statement(
            "Eq. 22, 23 and 25: q_s / a_max, q_s / j_max and q_ss / j_max are constraints.",
            "They are where the rate's own derivatives are taken as 1 rad/s² and 1 rad/s³, and the rate as 1 rad/s: q'' = q_ss "
            "s'² + q_s s''. The dotted lines of Figure 1 are drawn so.",
            "unclear",
        ),
    )


def _violations(analyses: Mapping[str, Sequence[DerivativeAnalysis]], rate: float) -> Statement:
    counts = {kind: [len(one.violations(rate)) for one in both] for kind, both in analyses.items()}
    smooth, linear = counts["smooth"], counts["linear"]
    least = [
        min(float(np.min(r)) for r in (a.rate_speed, a.rate_acceleration, a.rate_jerk)) for a in analyses["smooth"]
    ]
    found = max(analyses["smooth"][1].violations(rate), key=lambda v: v.worst, default=None)
    where = (
        ""
        if found is None
        else f", {found.axis} {found.quantity} at point {found.line} by {found.worst:.2f} times the limit"
    )
    return Statement(
        "There are no violations of speed, acceleration or jerk limits of any axis, before or after compensation.",
        f"At ds/dt = {rate:g} rad/s with the smooth curve {smooth[0]} stretch(es) pass a limit before and {smooth[1]} after "
        f"compensation{where}; all limits admit {least[0]:.3f} rad/s before and {least[1]:.3f} after, so that compensation adds "
        f"none. With the published linear interpolation it is {linear[0]} and {linear[1]}, for there each point is a corner. "
        "The paper prints neither limits nor the line's place; the limits of jerk are assumed here.",
        "holds" if sum(smooth) == 0 else "does not hold" if smooth[1] > smooth[0] else "unclear",
    )


def _shift(nominal: DerivativeAnalysis, compensated: DerivativeAnalysis) -> Statement:
    """How far compensation moves the coordinates and their derivatives' peaks."""
    same = np.linspace(0.0, 1.0, len(nominal.s))
    share = np.asarray(compensated.s) / compensated.s[-1]
    q = np.column_stack([np.interp(same, share, c) for c in np.asarray(compensated.q).T])
    moved = float(rad_to_deg(float(np.abs(q - nominal.q).max())))
    peaks = []
    for name in ("q_s", "q_ss", "q_sss"):
        before, after = (np.abs(np.asarray(getattr(one, name))).max(axis=0) for one in (nominal, compensated))
        peaks.append(float(np.max(np.abs(after - before)) / np.max(before)))
    return Statement(
        "The compensated curves are slightly shifted, without significant increase of their extremes.",
        f"Axes are moved by {moved:.3f} degrees at most; the extremes of q_s, q_ss and q_sss change by "
        f"{100 * peaks[0]:.2f} %, {100 * peaks[1]:.1f} % and {100 * peaks[2]:.1f} % of the largest (smooth curve).",
        "holds" if max(peaks) < _ALIKE else "does not hold" if peaks[0] > _ALIKE else "unclear",
    )


def _linear(linear: Sequence[DerivativeAnalysis], smooth: Sequence[DerivativeAnalysis]) -> Statement:
    second, third = (
        float(np.abs(np.asarray(getattr(linear[0], name))).max() / np.abs(np.asarray(getattr(smooth[0], name))).max())
        for name in ("q_ss", "q_sss")
    )
    return Statement(
        "Coordinates between points by linear interpolation, then differentiated three times (eq. 10, 14 to 19).",
        f"The second derivative then is {second:.0f} times and the third {third:,.0f} times that of a smooth curve within the "
        "coordinates' resolution, and both grow with the number of parts: they measure the sampling, not the machine.",
        "does not hold",
    )


def _signs(one: DerivativeAnalysis) -> Statement:
    """Eq. 21, 27 and 28 as printed take the greatest signed derivative."""
    parts = []
    for power, (name, limit, _eq) in enumerate(_EQUATIONS, start=1):
        shares = np.asarray(getattr(one, name)) / getattr(one.bounds, limit)
        signed, true = np.max(shares, axis=1), np.max(np.abs(shares), axis=1)
        more = (true / np.maximum(signed, 1e-12)) ** (1.0 / power)
        parts.append(f"{limit} on {100.0 * float(np.mean(more > 1.001)):.0f} %")
    return Statement(
        "Eq. 21, 27 and 28: the admitted rate is 1 / max(q_i,s / v_max), its square and third root likewise.",
        f"The sizes have to be taken: the greatest signed value lets axes that move backwards go free ({', '.join(parts)} of "
        "the way). Here sizes count.",
        "does not hold",
    )
