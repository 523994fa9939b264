"""What moves of a cutter take off rays of material, and where on which move a point of the surface was cut. Compiled."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel, part
from camrob.cutting.cutter_kernel import RIM, off_envelope, outward, outward_at_rim, stretch_inside

__all__ = ["carve", "contacts", "crossings_of_mesh", "overlap"]

Array = NDArray[np.float64]
Owners = NDArray[np.int32]

_HALVINGS = 12  # of a step, at the rim of what has a flat: to a quarter of a thousandth of it
_GOLDEN = 0.6180339887498949  # (sqrt(5) - 1) / 2
_SEARCHED = 40  # golden sections: to 4e-9 of a move
# of the radius, from a place of the cutter to the next: a ray that only what lies between them meets is grazed
_STEP = 0.2
_SHARP = 0.05  # likewise of a flat one, whose edge cuts where it grazes
_CUTS = 24  # cutting planes at the most
_NEAR = 2e-8  # m within which the least is known then


@part
def _take(edge: Array, owner: Owners, count: int, low: float, high: float, who: int) -> tuple[int, float]:
    """Take low to high off a ray's stretches; returns how many are left, -1 where there is no room for another, and what was
    taken.
    """
    k, taken = 0, 0.0
    while k < count:
        first, last = edge[2 * k], edge[2 * k + 1]
        if high <= first:
            break
        if low >= last:
            k += 1
        elif low <= first and high >= last:
            taken += last - first
            for j in range(2 * k, 2 * count - 2):
                edge[j], owner[j] = edge[j + 2], owner[j + 2]
            count -= 1
        elif low <= first:
            taken += high - first
            edge[2 * k], owner[2 * k] = high, who
            break
        elif high >= last:
            taken += last - low
            edge[2 * k + 1], owner[2 * k + 1] = low, who
            k += 1
        else:
            if 2 * count + 2 > len(edge):
                return -1, 0.0
            taken += high - low
            for j in range(2 * count - 1, 2 * k, -1):
                edge[j + 2], owner[j + 2] = edge[j], owner[j]
            edge[2 * k + 1], owner[2 * k + 1] = low, who
            edge[2 * k + 2], owner[2 * k + 2] = high, who
            count += 1
            break
    return count, taken


@part
def _slope(
    xu: float,
    xv: float,
    xw: float,
    nu: float,
    nv: float,
    nw: float,
    turn: Array,
    way: Array,
    R: float,
    c: float,
    L: float,
) -> float:
    """How fast an end of a ray's stretch moves along the ray, a unit of the step: the envelope's point x moves by v."""
    Nu, Nv, Nw = outward(xu, xv, xw, nu, nv, nw, R, c, L)
    if abs(Nw) < 1e-6:
        return 0.0
    vu = way[0] + turn[1] * xw - turn[2] * xv
    vv = way[1] + turn[2] * xu - turn[0] * xw
    vw = way[2] + turn[0] * xv - turn[1] * xu
    speed: float = (vu * Nu + vv * Nv + vw * Nw) / Nw
    return speed


@part
def _until(u: float, v: float, ends: Array, shape: Array, hit: float) -> tuple[float, float]:
    """The stretch at the last moment at which a ray is still hit, that is hit at `hit`, one end of a step, and not at the other.

    ends: (2, 6) tips and axes.
    """
    miss = 1.0 - hit
    lo, hi = 1.0, -1.0
    for _ in range(_HALVINGS):
        t = 0.5 * (hit + miss)
        s = 1.0 - t
        au, av, aw = s * ends[0, 0] + t * ends[1, 0], s * ends[0, 1] + t * ends[1, 1], s * ends[0, 2] + t * ends[1, 2]
        nu, nv, nw = s * ends[0, 3] + t * ends[1, 3], s * ends[0, 4] + t * ends[1, 4], s * ends[0, 5] + t * ends[1, 5]
        one = 1.0 / math.sqrt(nu * nu + nv * nv + nw * nw)
        lo2, hi2 = stretch_inside(u - au, v - av, -aw, one * nu, one * nv, one * nw, shape[0], shape[1], shape[2])
        if lo2 > hi2:
            miss = t
        else:
            hit, lo, hi = t, lo2, hi2
    return lo, hi


@part
def _bulge(
    u: float,
    v: float,
    side: float,
    f0: float,
    d0: float,
    f1: float,
    d1: float,
    far: float,
    ends: Array,
    way: Array,
    turn: Array,
    shape: Array,
) -> float:
    """The least end of a ray's stretch within a step, from values and slopes at its ends: a convex function, by cutting planes.

    side: 1 of the lower ends, -1 of the upper ones, whose sign is turned; far: beyond what nothing is left to take.
    """
    t0, t1 = 0.0, 1.0
    R, c, L = shape[0], shape[1], shape[2]
    for _ in range(_CUTS):
        # where the two tangents meet, which lie below the curve
        t = t0 + (f1 - f0 - d1 * (t1 - t0)) / (d0 - d1)
        below = f0 + d0 * (t - t0)
        if below >= far or min(f0, f1) - below < _NEAR or not t0 < t < t1:
            break
        s = 1.0 - t
        au, av, aw = s * ends[0, 0] + t * ends[1, 0], s * ends[0, 1] + t * ends[1, 1], s * ends[0, 2] + t * ends[1, 2]
        nu, nv, nw = s * ends[0, 3] + t * ends[1, 3], s * ends[0, 4] + t * ends[1, 4], s * ends[0, 5] + t * ends[1, 5]
        one = 1.0 / math.sqrt(nu * nu + nv * nv + nw * nw)
        nu, nv, nw = one * nu, one * nv, one * nw
        lo, hi = stretch_inside(u - au, v - av, -aw, nu, nv, nw, R, c, L)
        if lo > hi:
            break
        f = lo if side > 0.0 else -hi
        d = side * _slope(u - au, v - av, side * f - aw, nu, nv, nw, turn, way, R, c, L)
        if d < 0.0:
            t0, f0, d0 = t, f, d
        elif d > 0.0:
            t1, f1, d1 = t, f, d
        else:
            f0 = f
            break
    least: float = min(f0, f1)
    return least


@part
def _swept(
    u: float, v: float, near: float, far: float, ends: Array, way: Array, turn: Array, shape: Array
) -> tuple[float, float]:
    """The stretch of a ray at (u, v) that a cutter takes between two near places, `ends` (2, 6) their tips and axes.

    The places of a convex body along a straight way take one stretch of a ray, whose lower end is a convex function of the way.
    near, far: where the ray's material begins and ends; beyond, it doesn't matter how far a stretch reaches.
    """
    R, c, L = shape[0], shape[1], shape[2]
    au, av, aw, bu, bv, bw = ends[0, 0], ends[0, 1], ends[0, 2], ends[1, 0], ends[1, 1], ends[1, 2]
    nu, nv, nw, mu, mv, mw = ends[0, 3], ends[0, 4], ends[0, 5], ends[1, 3], ends[1, 4], ends[1, 5]
    lo, hi = stretch_inside(u - au, v - av, -aw, nu, nv, nw, R, c, L)
    lo2, hi2 = stretch_inside(u - bu, v - bv, -bw, mu, mv, mw, R, c, L)
    if lo > hi and lo2 > hi2:
        return lo, hi
    if lo > hi or lo2 > hi2:
        hit = 0.0 if lo <= hi else 1.0
        if hit == 1.0:
            lo, hi = lo2, hi2
        if c < R:  # a ball's rim is steep; what has a flat may cut with its edge
            lo2, hi2 = _until(u, v, ends, shape, hit)
            if lo2 <= hi2:
                return min(lo, lo2), max(hi, hi2)
        return lo, hi
    first, last = min(lo, lo2), max(hi, hi2)
    if first >= far or last <= near:
        # what bulges beyond both ends is less than the way between them
        room = abs(way[0]) + abs(way[1]) + abs(way[2])
        if first - room >= far or last + room <= near:
            return 1.0, -1.0
    if first > near:
        d0 = _slope(u - au, v - av, lo - aw, nu, nv, nw, turn, way, R, c, L)
        if d0 < 0.0:
            d1 = _slope(u - bu, v - bv, lo2 - bw, mu, mv, mw, turn, way, R, c, L)
            if d1 > 0.0:
                first = _bulge(u, v, 1.0, lo, d0, lo2, d1, far, ends, way, turn, shape)
    if last < far:
        e0 = _slope(u - au, v - av, hi - aw, nu, nv, nw, turn, way, R, c, L)
        if e0 > 0.0:
            e1 = _slope(u - bu, v - bv, hi2 - bw, mu, mv, mw, turn, way, R, c, L)
            if e1 < 0.0:
                last = -_bulge(u, v, -1.0, -hi, -e0, -hi2, -e1, -near, ends, way, turn, shape)
    return first, last


@part
def _span(a: float, b: float, n: float, m: float, R: float, L: float) -> tuple[float, float]:
    """Least and greatest coordinate that a cutter reaches at two places: of its two ends, by its radius."""
    low = min(min(a, a + L * n), min(b, b + L * m))
    high = max(max(a, a + L * n), max(b, b + L * m))
    return low - R, high + R


@part
def _within(a: Array, n: Array, R: float, L: float, box: Array) -> float:
    """The height up to which a cutter with its tip at a can reach into a box (2, 3); below 0 where it can't at all."""
    low, high = 0.0, L
    for k in range(3):
        first, last = box[0, k] - R - a[k], box[1, k] + R - a[k]
        if abs(n[k]) < 1e-12:
            if first > 0.0 or last < 0.0:
                return -1.0
        else:
            s, t = first / n[k], last / n[k]
            low, high = max(low, min(s, t)), min(high, max(s, t))
    return high if low <= high else -1.0


@kernel(nogil=True)
def carve(
    edge: Array,
    owner: Owners,
    count: NDArray[np.int32],
    box: Array,
    first: int,
    grid: Array,
    tip: Array,
    axis: Array,
    shape: Array,
    begin: int,
    taken: Array,
) -> int:
    """Carve a slab of rays (U, V, 2 M) by moves (N, 2, 3) of tips and axes from number `begin` on.

    box: (2, 3) corners of the slab; first: number of its first row of rays; grid: (u0, v0, pitch); shape: (N, 3) radius, corner,
    length, radius 0 for what doesn't cut; taken: (N,) m of rays, to which is added what each move takes. Returns N, or the number
    of the move at which a ray had no room left: with more room it can be done again from there.
    """
    U, V = edge.shape[0], edge.shape[1]
    u0, v0, pitch = grid[0] + first * grid[2], grid[1], grid[2]
    for k in range(begin, len(tip)):
        R, L = shape[k, 0], shape[k, 2]
        if R <= 0.0:
            continue
        a0, b0, n, m = tip[k, 0], tip[k, 1], axis[k, 0], axis[k, 1]
        long = math.sqrt(np.sum((b0 - a0) ** 2)) + L * math.sqrt(np.sum((m - n) ** 2))
        parts = max(1, math.ceil(long / ((_STEP if shape[k, 1] > 0.0 else _SHARP) * R)))
        turn, way, own = np.cross(n, m) / parts, (b0 - a0) / parts, shape[k].copy()
        ends = np.empty((2, 6))
        for p in range(parts):
            for e in range(2):
                t = (p + e) / parts
                ends[e, :3], ends[e, 3:] = a0 + t * (b0 - a0), n + t * (m - n)
                ends[e, 3:] /= math.sqrt(np.sum(ends[e, 3:] ** 2))
            a1, n1, b1, m1 = ends[0, :3], ends[0, 3:], ends[1, :3], ends[1, 3:]
            H = max(_within(a1, n1, R, L, box), _within(b1, m1, R, L, box))
            if H < 0.0:
                continue
            low, high = _span(a1[0], b1[0], n1[0], m1[0], R, H)
            i2, i3 = max(0, math.ceil((low - u0) / pitch)), min(U - 1, math.floor((high - u0) / pitch))
            low, high = _span(a1[1], b1[1], n1[1], m1[1], R, H)
            j2, j3 = max(0, math.ceil((low - v0) / pitch)), min(V - 1, math.floor((high - v0) / pitch))
            low, high = _span(a1[2], b1[2], n1[2], m1[2], R, H)
            for i in range(i2, i3 + 1):
                for j in range(j2, j3 + 1):
                    c = count[i, j]
                    # of the ray's stretches only those count that reach between low and high: from number `a` to `z`
                    a, z = 0, c - 1
                    while a < c and edge[i, j, 2 * a + 1] <= low:
                        a += 1
                    while z >= a and edge[i, j, 2 * z] >= high:
                        z -= 1
                    if z < a:
                        continue
                    near, far = edge[i, j, 2 * a], edge[i, j, 2 * z + 1]
                    w0, w1 = _swept(u0 + i * pitch, v0 + j * pitch, near, far, ends, way, turn, own)
                    if w0 < w1:
                        left, length = _take(edge[i, j], owner[i, j], c, w0, w1, k)
                        if left < 0:
                            return k
                        count[i, j] = left
                        taken[k] += length
    return len(tip)


@part
def _off(x: Array, tip: Array, axis: Array, shape: Array, t: float) -> float:
    n = axis[0] + t * (axis[1] - axis[0])
    n = n / math.sqrt(np.sum(n * n))
    r = x - tip[0] - t * (tip[1] - tip[0])
    off: float = off_envelope(r[0], r[1], r[2], n[0], n[1], n[2], shape[0], shape[1], shape[2])
    return off


@kernel
def contacts(x: Array, who: Owners, tip: Array, axis: Array, shape: Array) -> tuple[Array, Array]:
    """Where on their moves points (P, 3) of a surface were cut, 0 to 1 (P,), and the cutter's outward normals there (P, 3).

    A point on a swept envelope is nearest to the cutter where it touches it; the distance is convex along a move.
    """
    at, normal = np.zeros(len(x)), np.zeros((len(x), 3))
    for k in range(len(x)):
        o = who[k]
        low, high = 0.0, 1.0
        t1, t2 = high - _GOLDEN, _GOLDEN
        f1, f2 = _off(x[k], tip[o], axis[o], shape[o], t1), _off(x[k], tip[o], axis[o], shape[o], t2)
        for _ in range(_SEARCHED):
            if f1 <= f2:
                high, t2, f2 = t2, t1, f1
                t1 = high - _GOLDEN * (high - low)
                f1 = _off(x[k], tip[o], axis[o], shape[o], t1)
            else:
                low, t1, f1 = t1, t2, f2
                t2 = low + _GOLDEN * (high - low)
                f2 = _off(x[k], tip[o], axis[o], shape[o], t2)
        t = 0.5 * (low + high)
        n = axis[o, 0] + t * (axis[o, 1] - axis[o, 0])
        n = n / math.sqrt(np.sum(n * n))
        r = x[k] - tip[o, 0] - t * (tip[o, 1] - tip[o, 0])
        at[k] = t
        h = r[0] * n[0] + r[1] * n[1] + r[2] * n[2]
        e = r - h * n
        if shape[o, 1] == 0.0 and abs(h) < RIM and abs(math.sqrt(np.sum(e * e)) - shape[o, 0]) < RIM:
            # the rim goes with the tip, and about it with the axis's turn
            change = axis[o, 1] - axis[o, 0]
            v = tip[o, 1] - tip[o, 0] + (change[0] * e[0] + change[1] * e[1] + change[2] * e[2]) * -n
            normal[k] = outward_at_rim(e[0], e[1], e[2], n[0], n[1], n[2], v[0], v[1], v[2])
        else:
            normal[k] = outward(r[0], r[1], r[2], n[0], n[1], n[2], shape[o, 0], shape[o, 1], shape[o, 2])
    return at, normal


@kernel
def crossings_of_mesh(triangles: Array, grid: Array, U: int, V: int, room: int) -> tuple[Array, NDArray[np.int32]]:
    """Where rays (U, V) cross triangles (T, 3, 3) given in (u, v, w): crossings (U, V, room), sorted, and how many (U, V).

    A count above `room` says that there was too little of it.
    """
    out, count = np.full((U, V, room), np.inf), np.zeros((U, V), np.int32)
    u0, v0, pitch = grid[0], grid[1], grid[2]
    for k in range(len(triangles)):
        T = triangles[k]
        i0 = max(0, math.ceil((T[:, 0].min() - u0) / pitch))
        i1 = min(U - 1, math.floor((T[:, 0].max() - u0) / pitch))
        j0 = max(0, math.ceil((T[:, 1].min() - v0) / pitch))
        j1 = min(V - 1, math.floor((T[:, 1].max() - v0) / pitch))
        eu, ev, fu, fv = T[1, 0] - T[0, 0], T[1, 1] - T[0, 1], T[2, 0] - T[0, 0], T[2, 1] - T[0, 1]
        area = eu * fv - ev * fu
        if area == 0.0:
            continue
        for i in range(i0, i1 + 1):
            for j in range(j0, j1 + 1):
                pu, pv = u0 + i * pitch - T[0, 0], v0 + j * pitch - T[0, 1]
                s, t = (pu * fv - pv * fu) / area, (eu * pv - ev * pu) / area
                if s >= 0.0 and t >= 0.0 and s + t <= 1.0:
                    if count[i, j] < room:
                        out[i, j, count[i, j]] = T[0, 2] + s * (T[1, 2] - T[0, 2]) + t * (T[2, 2] - T[0, 2])
                    count[i, j] += 1
    for i in range(U):
        for j in range(V):
            out[i, j].sort()
    return out, count


@kernel
def overlap(edge: Array, count: NDArray[np.int32], other: Array, others: NDArray[np.int32]) -> float:
    """The length, summed over all rays (U, V), along which two bodies' stretches (U, V, 2 M) and (U, V, 2 K) lie together."""
    together = 0.0
    for i in range(edge.shape[0]):
        for j in range(edge.shape[1]):
            a, b = 0, 0
            while a < count[i, j] and b < others[i, j]:
                low = max(edge[i, j, 2 * a], other[i, j, 2 * b])
                high = min(edge[i, j, 2 * a + 1], other[i, j, 2 * b + 1])
                together += max(0.0, high - low)
                if edge[i, j, 2 * a + 1] < other[i, j, 2 * b + 1]:
                    a += 1
                else:
                    b += 1
    return together
