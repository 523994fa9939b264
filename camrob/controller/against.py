"""Is every CL point met, in order, and does the program go nowhere else between?"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel, part
from camrob.controller.pose_kernel import circle
from camrob.findings import Finding, Severity, first_error
from camrob.program.motion import Motion
from camrob.triples import between, cross, dot, gap2
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["AXIS_TOLERANCE", "POSITION_TOLERANCE", "Coverage", "cover"]

Array = NDArray[np.float64]

POSITION_TOLERANCE = 1e-5  # m: the contract's 0.01 mm, to which stated chord tolerances are added
AXIS_TOLERANCE = 1.7453292519943296e-4  # rad: the contract's 0.01 degrees

CLEARLY = 2e-6  # m: more than what rounding to three decimals can make of a point


@dataclass(frozen=True, slots=True)
class Coverage:
    """How a program covers CL points: motion (N,) that passes each point (-1: none), and the errors there, m and rad.

    leaves: (N,) motion from whose end the way on from each point begins: `motion`, but where the program retracts at the point
    and comes back. deviation: m, the farthest that the program's motions between two neighbouring points of one region leave the
    line between, such retracts apart. joined: (N,) True where a point lies in one region with the point before it.
    """

    motion: NDArray[np.int64]
    leaves: NDArray[np.int64]
    position_error: Array
    axis_error: Array
    deviation: float
    joined: NDArray[np.bool_]
    findings: tuple[Finding, ...]

    @property
    def good(self) -> bool:
        """True where no finding is an error."""
        return first_error(self.findings) is None


@part
def _at(
    s: float,
    p0: Array,
    z0: Array,
    p1: Array,
    z1: Array,
    center: Array,
    u: Array,
    v: Array,
    angle: float,
    p: Array,
    z: Array,
) -> None:
    """Tip and tool axis at the share s of a motion; axes go along the great arc."""
    if angle > 0.0:
        co, si = np.cos(s * angle), np.sin(s * angle)
        for r in range(3):
            p[r] = center[r] + co * u[r] + si * v[r]
    else:
        for r in range(3):
            p[r] = p0[r] + s * (p1[r] - p0[r])
    n2 = 0.0
    for r in range(3):
        z[r] = z0[r] + s * (z1[r] - z0[r])
        n2 += z[r] * z[r]
    n = np.sqrt(max(n2, 1e-30))
    for r in range(3):
        z[r] /= n


@part
def _nearest(x: Array, p0: Array, p1: Array, center: Array, u: Array, v: Array, angle: float, least: float) -> float:
    """Share of the motion, not before `least`, that lies nearest to point x."""
    if angle > 0.0:
        d = between(center, x)
        a = np.arctan2(dot(d, v), dot(d, u))
        if a < 0.0:
            a += 2.0 * np.pi
        s = a / angle
        if s > 1.0:  # behind the end: the nearer end of the two
            s = 1.0 if (a - angle) < (2.0 * np.pi - a) else 0.0
    else:
        d1 = between(p0, p1)
        n2 = dot(d1, d1)
        s = dot(between(p0, x), d1) / n2 if n2 > 0.0 else 1.0
    return float(min(1.0, max(least, s)))


class _Match(NamedTuple):
    """Scratch for matching: centre and axes of an arc, a tip and an axis; found: position and axis error, share."""

    center: Array
    u: Array
    v: Array
    tip: Array
    axis: Array
    found: Array


@part
def _last_row(kind: NDArray[np.int8], k: int) -> int:
    """The row that the motion beginning with row k ends at."""
    return k + 1 if kind[k] == Motion.CIRC_VIA and k + 1 < kind.shape[0] else k


@part
def _match(
    x: Array, zx: Array, p: Array, z: Array, kind: NDArray[np.int8], k: int, least: float, tolerance: float, m: _Match
) -> None:
    """m.found <- how near the motion that begins with row k, from its share `least` on, comes to a point and its axis."""
    end = _last_row(kind, k)
    start = max(k - 1, 0)
    angle = 0.0
    if end > k:
        angle = circle(p[start], p[k], p[end], m.center, m.u, m.v)
    elif kind[k] == Motion.PTP_AXES or kind[k] == Motion.PTP_POSE:
        start = k  # only its end is known to be met
    s = _nearest(x, p[start], p[end], m.center, m.u, m.v, angle, least)
    _at(s, p[start], z[start], p[end], z[end], m.center, m.u, m.v, angle, m.tip, m.axis)
    d = np.sqrt(gap2(x, m.tip))
    c = cross(m.axis, zx)
    t = np.arctan2(np.sqrt(dot(c, c)), dot(m.axis, zx))
    if d <= tolerance and t > AXIS_TOLERANCE and gap2(p[end], p[start]) < tolerance * tolerance:
        s = 1.0  # a turn on the spot: its end counts
        c = cross(z[end], zx)
        t = np.arctan2(np.sqrt(dot(c, c)), dot(z[end], zx))
    m.found[0], m.found[1], m.found[2] = d, t, s


@part
def _deviation(
    before: Array, x: Array, first: int, end: int, share: float, p: Array, kind: NDArray[np.int8], m: _Match
) -> float:
    """How far rows first .. end - 1, which the program passes between two points, lie from the line between these."""
    worst = 0.0
    for r in range(first, end):
        if kind[r] == Motion.CIRC_VIA and r + 1 == end and share < 1.0 - 1e-9:
            continue  # the arc has not been passed yet
        s = _nearest(p[r], before, x, m.center, m.u, m.v, 0.0, 0.0)
        way = between(before, x)
        along = before[0] + s * way[0], before[1] + s * way[1], before[2] + s * way[2]
        worst = max(worst, np.sqrt(gap2(p[r], along)))
    return float(worst)


@part
def _on_ray(p: Array, z: Array, o: Array, axis: Array, tolerance: float) -> bool:
    """Whether a tip p with tool axis z lies on the ray from o along the tool axis there, the tool not tilted."""
    d = between(o, p)
    t = max(0.0, dot(d, axis))
    c = cross(z, axis)
    return bool(
        gap2((t * axis[0], t * axis[1], t * axis[2]), d) <= tolerance * tolerance
        and dot(c, c) <= AXIS_TOLERANCE**2
        and dot(z, axis) > 0.0
    )


@part
def _retracts(
    x: Array, zx: Array, i: int, first: int, last: int, p: Array, z: Array, kind: NDArray[np.int8], tolerance: float
) -> bool:
    """Whether rows first + 1 .. last lead from point i, where row `first` ends, clear of the part and back.

    Out and in by LIN along the tool axis; clear is above all points x (N, 3) along that axis, where LIN and CIRC have to
    stay. A PTP in between begins and ends there.
    """
    o, axis = x[i], zx[i]
    if last - first < 2 or gap2(o, p[first]) > tolerance * tolerance:
        return False
    clear = -np.inf
    for k in range(x.shape[0]):
        clear = max(clear, dot(x[k], axis))
    out = first
    while dot(p[out], axis) < clear + tolerance:
        out += 1
        if out >= last or kind[out] != Motion.LIN or not _on_ray(p[out], z[out], o, axis, tolerance):
            return False
    back = last
    while dot(p[back], axis) < clear + tolerance:
        if kind[back] != Motion.LIN or not _on_ray(p[back], z[back], o, axis, tolerance):
            return False
        back -= 1
    if back < out or not _on_ray(p[back], z[back], o, axis, tolerance):
        return False
    for k in range(out + 1, back + 1):
        if kind[k] == Motion.PTP_AXES or kind[k] == Motion.PTP_POSE:
            continue
        if min(dot(p[k], axis), dot(p[k - 1], axis)) < clear:
            return False
    return True


@part
def _earliest(
    x: Array, zx: Array, p: Array, z: Array, kind: NDArray[np.int8], tolerance: float,
    row: NDArray[np.int64], share: Array, error: Array, axis_error: Array, m: _Match,
) -> int:  # fmt: skip
    """Give each point the first motion that meets it behind the point before; returns how many points are met.

    Only the earliest leaves room for all that follow, where a path runs back along itself. The errors of the first point
    that is missed are the least ones found.
    """
    k, least = 0, 0.0
    for i in range(x.shape[0]):
        error[i], axis_error[i] = np.inf, np.inf
        found = False
        while k < p.shape[0]:
            _match(x[i], zx[i], p, z, kind, k, least, tolerance, m)
            found = m.found[0] <= tolerance and m.found[1] <= AXIS_TOLERANCE
            if found or m.found[0] < error[i]:
                error[i], axis_error[i] = m.found[0], m.found[1]
            if found:
                row[i], share[i], least = k, m.found[2], m.found[2]
                break
            k, least = _last_row(kind, k) + 1, 0.0
        if not found:
            return i
    return int(x.shape[0])


@part
def _bettered(
    x: Array, zx: Array, p: Array, z: Array, kind: NDArray[np.int8], tolerance: float, met: int,
    row: NDArray[np.int64], share: Array, error: Array, axis_error: Array, m: _Match,
) -> None:  # fmt: skip
    """Give each of the first `met` points to motions behind its own that meet it better, none behind the next point's."""
    for i in range(met - 1, -1, -1):
        k = _last_row(kind, row[i]) + 1
        last = row[i + 1] if i + 1 < met else p.shape[0] - 1
        while k <= last:
            _match(x[i], zx[i], p, z, kind, k, 0.0, tolerance, m)
            # where the next motion begins is where this one ends: it must come clearly nearer, or end there
            nearer = error[i] - (1e-9 if m.found[2] > 0.5 else CLEARLY)
            passed = i + 1 < met and k == last and m.found[2] > share[i + 1]
            if passed or m.found[1] > AXIS_TOLERANCE or not m.found[0] < nearer:
                break
            row[i], share[i], error[i], axis_error[i] = k, m.found[2], m.found[0], m.found[1]
            k = _last_row(kind, k) + 1


@kernel
def _cover(
    x: Array, zx: Array, region: NDArray[np.int64], p: Array, z: Array, kind: NDArray[np.int8], tolerance: float,
    motion: NDArray[np.int64], leaves: NDArray[np.int64], error: Array, axis_error: Array, deviation: Array,
) -> None:  # fmt: skip
    """Match points x (N, 3) with axes zx (N, 3) to motions between p (M, 3), z (M, 3), in order.

    Each point goes to the first motion that meets it, or to one directly behind that meets it better. deviation (N,): how far
    the motions between point i - 1 and i leave their chord; where a link leads back to the same place, the point before
    is taken behind the link, or, where that link is a retract within a region, left from there (`leaves`).
    """
    m = _Match(np.zeros(3), np.zeros(3), np.zeros(3), np.empty(3), np.empty(3), np.empty(3))
    row, share = np.zeros(x.shape[0], np.int64), np.zeros(x.shape[0])
    met = _earliest(x, zx, p, z, kind, tolerance, row, share, error, axis_error, m)
    _bettered(x, zx, p, z, kind, tolerance, met, row, share, error, axis_error, m)
    for i in range(met):
        motion[i] = leaves[i] = _last_row(kind, row[i])
        if i > 0 and region[i] == region[i - 1]:
            deviation[i] = _deviation(x[i - 1], x[i], motion[i - 1], motion[i], share[i], p, kind, m)
            if deviation[i] > 2.0 * tolerance:
                for other in range(motion[i], motion[i - 1], -1):
                    if kind[other] != Motion.CIRC_VIA and kind[other] != Motion.CIRC_END:
                        _match(x[i - 1], zx[i - 1], p, z, kind, other, 0.0, tolerance, m)
                        if m.found[0] <= tolerance and m.found[1] <= AXIS_TOLERANCE:
                            at = m.found[2]
                            deviation[i] = _deviation(x[i - 1], x[i], other, motion[i], share[i], p, kind, m)
                            begins = gap2(x[i - 1], p[other - 1]) <= tolerance * tolerance
                            leaves[i - 1] = other - 1 if begins else other
                            if _retracts(x, zx, i - 1, motion[i - 1], leaves[i - 1], p, z, kind, tolerance):
                                break
                            motion[i - 1], leaves[i - 1] = other, other
                            if i > 1 and region[i - 1] == region[i - 2]:  # the way back counts before the point, then
                                deviation[i - 1] = _deviation(x[i - 2], x[i - 1], leaves[i - 2], other, at, p, kind, m)
                            break


def cover(
    base_T_tip: Array, line: NDArray[np.int64], region: NDArray[np.int64], targets: Array, kind: NDArray[np.int8],
    *, chord_tolerance: float = 0.0,
) -> Coverage:  # fmt: skip
    """Match CL points (N, 4, 4) in `base` with a program's targets (M, 4, 4); `line`, `region`: (N,) of the CL points.

    Findings: "cl-point-missed" (with line and distance) where a point lies on no motion from the one before on, and "strays"
    where the program leaves the way between two points of one region by more than the tolerances.
    """
    n = len(base_T_tip)
    motion, error, axis_error, deviation = np.full(n, -1), np.full(n, np.inf), np.full(n, np.inf), np.zeros(n)
    leaves = np.full(n, -1)
    tolerance = POSITION_TOLERANCE + chord_tolerance
    _cover(
        np.ascontiguousarray(base_T_tip[:, :3, 3]), np.ascontiguousarray(base_T_tip[:, :3, 2]), region.astype(np.int64),
        np.ascontiguousarray(targets[:, :3, 3]), np.ascontiguousarray(targets[:, :3, 2]), np.array(kind), tolerance,
        motion, leaves, error, axis_error, deviation,
    )  # fmt: skip
    findings = []
    missed = np.flatnonzero(motion < 0)
    if len(missed):
        i = int(missed[0])
        text = (
            f"the program does not pass this CL point in order: it comes as near as {m_to_mm(float(error[i])):.4f} mm "
            f"and {rad_to_deg(float(axis_error[i])):.4f} degrees"
        )
        findings.append(Finding("cl-point-missed", text, Severity.ERROR, line=int(line[i]), point=i,
                                value=m_to_mm(float(error[i])), limit=m_to_mm(tolerance), unit="mm"))  # fmt: skip
    off = float(deviation.max(initial=0.0))
    if off > 2.0 * tolerance + chord_tolerance:
        i = int(np.argmax(deviation))
        findings.append(Finding("strays", "the program leaves the way between two CL points", Severity.ERROR,
                                line=int(line[i]), point=i, value=m_to_mm(off), limit=m_to_mm(tolerance), unit="mm"))  # fmt: skip
    met = motion >= 0
    joined = np.concatenate([[False], region[1:] == region[:-1]])[:n]
    return Coverage(
        motion, leaves, np.where(met, error, 0.0), np.where(met, axis_error, 0.0), off, joined, tuple(findings)
    )
