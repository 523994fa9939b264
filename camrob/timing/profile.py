"""A speed profile along a spline: planned under jerk bounds, sampled, and checked on a finer grid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel
from camrob.frozen import locked
from camrob.timing.barrier import RAMP, centre, merit, squares_of_span
from camrob.timing.path_spline import MotionBounds, axis_terms, speed_caps, spline_at
from camrob.timing.reachability import fastest_squares

__all__ = ["FEWEST_SPANS", "FineGrid", "Profile", "fastest_profile", "fine_grid", "worst_use"]

Array = NDArray[np.float64]

FEWEST_SPANS = 24  # fewer would not tell start, cruise and end apart
_GAP = 1e-7  # of the time: about how far from the optimum the plan may end
_EASINGS = 4


@dataclass(frozen=True, slots=True)
class Profile:
    """Square speed along K spans of length `spacing`: control values c of its quadratic spline over the inner spans.

    start, end: True where the motion comes from rest, or ends at rest; the outermost span is then run with constant jerk.
    `reachable` (K + 1,) is the square speed at the knots that speed and acceleration alone would allow.
    """

    c: Array
    spacing: float
    start: bool
    end: bool
    reachable: Array

    def __post_init__(self) -> None:
        for name in ("c", "reachable"):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(None,), name=name))

    @property
    def shortest_time(self) -> float:
        """Seconds at the speed that speed and acceleration alone would allow."""
        v = np.sqrt(self.reachable)
        return float(np.sum(2.0 * self.spacing / np.maximum(v[1:] + v[:-1], 1e-12)))


class FineGrid(NamedTuple):
    """A profile at F points: s (m), v (m/s), u (m/s2) and jerk (m/s3) along the path, at (s)."""

    s: Array
    v: Array
    u: Array
    jerk: Array
    at: Array


def fastest_profile(
    control: Array,
    spacing: float,
    feed: Array,
    bounds: MotionBounds,
    *,
    start: bool = True,
    end: bool = True,
    gap: float = _GAP,
) -> Profile:
    """The fastest profile along a spline (`control` (K + 3, 6 + n)) under the programmed feed (K,), m/s, and all bounds.

    start, end: True to come from rest and end at rest; else speed and acceleration are free there. gap: about the share
    of the time that may be missing to the optimum, a local one where jerk binds; a tenfold smaller one costs a tenth
    more. K is at least `FEWEST_SPANS`. Cost: linear in K, about a tenth of a millisecond a span and axis.
    """
    tops = speed_caps(control, spacing, feed, bounds)
    fast = fastest_squares(control, spacing, tops, bounds, 0.0 if start else np.inf, 0.0 if end else np.inf)
    first, last = (1 if start else 0), len(tops) - (1 if end else 0)
    inner = np.ascontiguousarray(control[first : last + 3])
    around = np.concatenate([[np.inf, np.inf], tops[first:last], [np.inf, np.inf]])
    caps = np.minimum(np.minimum(around[:-2], around[1:-1]), around[2:])
    weight = np.full(len(caps), spacing)
    weight[[0, -1]] = 0.5 * spacing
    for stops, outer, near, span in ((start, 0, 1, 0), (end, -1, -2, len(tops) - 1)):
        if stops:
            caps[outer], weight[outer] = np.inf, 0.0
            ramp = min(_ramp_square(control, span, spacing, bounds), float(tops[span]))
            caps[near] = min(caps[near], 2.0 * ramp / (1.0 + RAMP))
            weight[near] += 3.0 * spacing / np.sqrt(0.5 * (1.0 + RAMP))
    ease = np.ones(len(inner) - 3)
    c = _begin(fast, first, last, caps, start, end)
    _shrink(c, weight, caps, ease, inner, spacing, bounds)
    v = np.sqrt(fast)
    seconds = float(np.sum(2.0 * spacing / np.maximum(v[1:] + v[:-1], 1e-9)))
    left = 0.3
    while left > gap:
        centre(c, len(c) / (left * seconds), weight, caps, ease, inner, spacing, bounds, start, end, 60)
        left /= 6.0
    # bounds on jerk hold at each Bernstein coefficient by itself; where the finer grid finds more, the span gets less
    for _round in range(_EASINGS):
        profile = Profile(c, spacing, start, end, fast)
        use = worst_use(control, profile, bounds, feed, 10)[0]
        over = use[first:last, 2]
        if over.max() <= 1.0:
            break
        ease[over > 1.0] /= 1.002 * over[over > 1.0]
        _shrink(c, weight, caps, ease, inner, spacing, bounds)
        centre(c, len(c) / (left * 6.0 * seconds), weight, caps, ease, inner, spacing, bounds, start, end, 60)
    profile = Profile(c, spacing, start, end, fast)
    most = worst_use(control, profile, bounds, feed, 10)[0].max(axis=0)
    excess = max(most[0], np.sqrt(most[1]), np.cbrt(most[2]))
    return Profile(c / excess**2, spacing, start, end, fast) if excess > 1.0 else profile


def _shrink(c: Array, weight: Array, caps: Array, ease: Array, control: Array, h: float, bounds: MotionBounds) -> None:
    """Slow control values down, in place, until they lie strictly within all bounds: time scaling always gets there."""
    for _ in range(400):
        if np.isfinite(merit(c, 1.0, weight, caps, ease, control, h, bounds)):
            return
        c *= 0.9


def _begin(fast: Array, first: int, last: int, caps: Array, start: bool, end: bool) -> Array:
    """Smooth control values below the fastest ones without jerk: the least around, averaged; narrow near a stop."""
    least = _inner(fast, first, last)
    n = len(least)
    distance = np.full(n, n)
    if start:
        distance = np.minimum(distance, np.arange(n))
    if end:
        distance = np.minimum(distance, np.arange(n)[::-1])
    from scipy.ndimage import minimum_filter1d, uniform_filter1d

    c = least.copy()
    for reach in (1, 2, 4, 8, 16):
        size = 2 * reach + 1
        smooth = uniform_filter1d(minimum_filter1d(least, size, mode="nearest"), size, mode="nearest")
        c = np.where(distance >= 2 * reach, smooth, c)
    c = 0.5 * np.minimum(np.maximum(c, 1e-12), caps)
    if start:
        c[0] = RAMP * c[1]
    if end:
        c[-1] = RAMP * c[-2]
    return np.asarray(c)


def _inner(fast: Array, first: int, last: int) -> Array:
    """Square speeds of the knots, the lesser of each span, for the control values of the spans first .. last."""
    least = np.minimum(fast[:-1], fast[1:])
    return np.concatenate([least[first : first + 1], least[first:last], least[last - 1 : last]])


def _ramp_square(control: Array, span: int, h: float, bounds: MotionBounds) -> float:
    """The largest square speed at the end of a start from rest with constant jerk over one span (or a stop's mirror)."""
    top = np.inf
    vector = np.zeros((2, 2))
    for d in range(control.shape[1]):
        a0, a1, a2, e0, e1, f = axis_terms(control, span, d, h)
        a, e = max(abs(a0), abs(a1), abs(a2)), max(abs(e0), abs(e1))
        if d < 6:
            vector[d // 3] += (a * a, e * e)
            continue
        push = a * 2.0 / (3.0 * h) + e
        top = min(top, bounds.acceleration[d - 6] / max(push, 1e-300))
        twitch = a * 2.0 / (9.0 * h * h) + 2.0 * e / h + abs(f)
        top = min(top, (bounds.jerk[d - 6] / max(twitch, 1e-300)) ** (2.0 / 3.0))
    for limit, (a, e) in zip((bounds.tool_acceleration, bounds.turn_acceleration), np.sqrt(vector), strict=True):
        top = min(top, limit / max(a * 2.0 / (3.0 * h) + e, 1e-300))
    return float(top)


@kernel(nogil=True)
def _sample(c: Array, h: float, start: bool, end: bool, parts: int, v: Array, u: Array, jerk: Array, at: Array) -> None:
    """Fill speed, acceleration, jerk and time at every `parts`-th part of all spans; ends are kept, so F = K parts + 1."""
    first = 1 if start else 0
    spans = c.shape[0] - 2 + first + (1 if end else 0)
    inner_last = spans - (1 if end else 0)
    for i in range(spans):
        for k in range(parts + (1 if i == spans - 1 else 0)):
            w, f = k / parts, i * parts + k
            if i < first or i >= inner_last:  # constant jerk from or to rest
                begins = i < first
                x_end = 0.5 * (c[0] + c[1]) if begins else 0.5 * (c[-1] + c[-2])
                share = w if begins else 1.0 - w
                root = share ** (1.0 / 3.0)
                v[f] = np.sqrt(x_end) * root * root
                u[f] = (2.0 / 3.0) * x_end / h * root * (1.0 if begins else -1.0)
                jerk[f] = (2.0 / 9.0) * x_end**1.5 / (h * h)
                at[f] = 3.0 * h / np.sqrt(x_end) * (root if begins else 1.0 - root)
            else:
                j = i - first
                x0, x1, x2 = squares_of_span(c[j], c[j + 1], c[j + 2])
                x = (1.0 - w) ** 2 * x0 + 2.0 * w * (1.0 - w) * x1 + w * w * x2
                u0, u1 = (c[j + 1] - c[j]) / (2.0 * h), (c[j + 2] - c[j + 1]) / (2.0 * h)
                v[f] = np.sqrt(x)
                u[f] = (1.0 - w) * u0 + w * u1
                jerk[f] = v[f] * (u1 - u0) / h
                at[f] = 0.0
                for g in range(3):  # Gauss-Legendre within each part
                    for p in range(k):
                        z = (p + 0.5 + (g - 1) * 0.3872983346207417) / parts
                        x = (1.0 - z) ** 2 * x0 + 2.0 * z * (1.0 - z) * x1 + z * z * x2
                        at[f] += (8.0 if g == 1 else 5.0) / 18.0 * h / parts / np.sqrt(x)
    # times within spans become times from the start
    total = 0.0
    for i in range(spans):
        if i < first or i >= inner_last:
            x_end = 0.5 * (c[0] + c[1]) if i < first else 0.5 * (c[-1] + c[-2])
            whole = 3.0 * h / np.sqrt(x_end)
        else:
            j = i - first
            x0, x1, x2 = squares_of_span(c[j], c[j + 1], c[j + 2])
            whole = 0.0
            for p in range(parts):
                for g in range(3):
                    z = (p + 0.5 + (g - 1) * 0.3872983346207417) / parts
                    x = (1.0 - z) ** 2 * x0 + 2.0 * z * (1.0 - z) * x1 + z * z * x2
                    whole += (8.0 if g == 1 else 5.0) / 18.0 * h / parts / np.sqrt(x)
        for k in range(parts):
            at[i * parts + k] += total
        total += whole
    at[spans * parts] = total


def fine_grid(profile: Profile, parts: int) -> FineGrid:
    """The profile at `parts` points a span and at its end."""
    spans = len(profile.c) - 2 + profile.start + profile.end
    v, u, jerk, at = (np.empty(spans * parts + 1) for _ in range(4))
    _sample(np.asarray(profile.c), profile.spacing, profile.start, profile.end, parts, v, u, jerk, at)
    return FineGrid(np.asarray(np.arange(len(v)) * (profile.spacing / parts), float), v, u, jerk, at)


def worst_use(
    control: Array, profile: Profile, bounds: MotionBounds, feed: Array, parts: int
) -> tuple[Array, NDArray[np.int64]]:
    """How far each span uses the bounds of speed, acceleration and jerk (K, 3) at `parts` points, 1 being all of it.

    Also (K,) what is used most: 0 feed, 1 tool acceleration, 2 rotation speed, 3 rotation acceleration, then 4 + 3 k + 0, 1, 2
    speed, acceleration, jerk of axis k.
    """
    grid = fine_grid(profile, parts)
    use, which = _use(
        control, profile.spacing, feed, bounds, grid.v, grid.u, grid.jerk, parts, profile.start, profile.end
    )
    return use, which


@kernel(nogil=True)
def _use(
    control: Array,
    h: float,
    feed: Array,
    bounds: MotionBounds,
    v: Array,
    u: Array,
    jerk: Array,
    parts: int,
    start: bool,
    end: bool,
) -> tuple[Array, NDArray[np.int64]]:
    """The work of `worst_use`."""
    spans, width = control.shape[0] - 3, control.shape[1]
    use, which = np.zeros((spans, 3)), np.zeros(spans, np.int64)
    d1, d2, d3 = np.empty(width), np.empty(width), np.empty(width)
    for i in range(spans):
        worst = 0.0
        ramp = (start and i == 0) or (end and i == spans - 1)
        inside = i * parts + 1
        for k in range(parts + 1):
            f = i * parts + k
            for order, out in ((1, d1), (2, d2), (3, d3)):
                spline_at(control, h, i, k / parts, order, out)
            speed, push = v[f], u[f]
            # jerk jumps between spans: at both ends take this span's own
            twitch = jerk[inside] if ramp else speed * jerk[inside] / v[inside]
            ratio = speed / feed[i]
            use[i, 0] = max(use[i, 0], ratio)
            if ratio > worst:
                worst, which[i] = ratio, 0
            for group in range(2):
                turning, accelerating = 0.0, 0.0
                for d in range(3 * group, 3 * group + 3):
                    turning += (d1[d] * speed) ** 2
                    accelerating += (d1[d] * push + d2[d] * speed * speed) ** 2
                limit = bounds.tool_acceleration if group == 0 else bounds.turn_acceleration
                ratio = np.sqrt(accelerating) / limit
                use[i, 1] = max(use[i, 1], ratio)
                if ratio > worst:
                    worst, which[i] = ratio, 1 if group == 0 else 3
                if group == 1:
                    ratio = np.sqrt(turning) / bounds.turn_speed
                    use[i, 0] = max(use[i, 0], ratio)
                    if ratio > worst:
                        worst, which[i] = ratio, 2
            for d in range(6, width):
                a = d - 6
                rates = (
                    abs(d1[d] * speed) / bounds.speed[a],
                    abs(d1[d] * push + d2[d] * speed * speed) / bounds.acceleration[a],
                    abs(d1[d] * twitch + 3.0 * d2[d] * speed * push + d3[d] * speed**3) / bounds.jerk[a],
                )
                for r in range(3):
                    use[i, r] = max(use[i, r], rates[r])
                    if rates[r] > worst:
                        worst, which[i] = rates[r], 4 + 3 * a + r
    return use, which
