"""Planes below the price of every posture in boxes of tools seen alike, and whether a certificate's planes are below them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.witness.proof_check.dh_machine import NEAR, Machine
from camrob.witness.proof_check.forms import (
    LEFT,
    PAD,
    Array,
    bounds,
    constant,
    cross,
    dot,
    inverse,
    minus,
    plus,
    root,
    scaled,
    shifted,
    spread,
    times,
    turned,
)

__all__ = ["CHUNK", "below", "prove_bins"]

Bools = NDArray[np.bool_]
Ints = NDArray[np.int64]
Arm = list[Array]

CHUNK = 4000
"""Boxes at once: some 0.3 GB."""
_ROLLS, _DEPTH = 8, 40  # pieces of a turn to begin with; halvings of a box at most
_WAYS = 4  # of an arm to reach a pose, the wrist's two apart: 2 * (axis 1) + elbow
_TINY = 1e-300  # a divisor at least
_LEAST_D, _LEAST_G = (
    1e-4,
    1e-12,
)  # m2, m4: wrist from shoulder, and their triangle's area, below which a box says little
_WIDE_AXIS, _WIDE_ROLL = 0.9, 0.6  # squared sine, rad: wider boxes say nothing
_SHARP = 0.7  # share of an angle's radius that it may be uncertain by
_CONDITION = 1e4  # of a Jacobian, up to which its inverse is trusted
_WEIGH = np.array([0.6, 0.6, 0.6, 1.2, 1.2])  # what widths of axis, roll and tip cost a bound: which side is halved


def _angle_misses(c: Array, s: Array, zero: float, sense: float, low: float, high: float) -> Bools:
    """Whether sense * (angle of (c, s) + zero) misses [low, high], turns apart."""
    rho = np.hypot(c[:, 0], s[:, 0])
    far = np.hypot(spread(c), spread(s))
    half = np.where(far < _SHARP * rho, np.arcsin(np.minimum(far / np.maximum(rho, _TINY), 1.0)) + PAD, np.pi)
    return _misses(sense * (np.arctan2(s[:, 0], c[:, 0]) + zero), half, low, high)


def _misses(middle: Array, half: Array, low: float, high: float) -> Bools:
    """Whether [middle - half, middle + half] misses [low, high], turns apart."""
    d = middle - 0.5 * (low + high)
    d = d - 2.0 * np.pi * np.round(d / (2.0 * np.pi))
    return np.asarray(np.abs(d) > 0.5 * (high - low) + half + PAD)


class _Tools(NamedTuple):
    """Tools of boxes seen from the arm: wrist, axis six, lever to the plate; where the box is too wide to say anything."""

    wrist: Arm
    sixth: Arm
    lever: Arm
    wide: Bools


def _tools(m: Machine, frame3: Array, box: Array) -> _Tools:
    sym = [constant(box[:, 0, i]) for i in range(box.shape[2])]
    for i, form in enumerate(sym):
        form[:, 1 + i] = box[:, 1, i]
    a, b, roll, radius, height = sym
    flat = plus(times(a, a), times(b, b))
    low, high = bounds(flat)
    c = root(shifted(scaled(flat, -1.0), 1.0), 1.0 - np.minimum(high, _WIDE_AXIS), 1.0 - np.maximum(low, 0.0))
    share = inverse(shifted(c, 1.0), *bounds(shifted(c, 1.0)))
    aa, ab, bb = (times(times(u, v), share) for u, v in ((a, a), (a, b), (b, b)))
    one = constant(np.ones(len(box)))
    columns = (
        (minus(one, aa), scaled(ab, -1.0), scaled(a, -1.0)),
        (scaled(ab, -1.0), minus(one, bb), scaled(b, -1.0)),
        (a, b, c),
    )
    # rows of frame3: x, y, z
    x, y, z = (
        [sum((scaled(k, frame3[:, r, i]) for r, k in enumerate(col)), start=np.zeros_like(a)) for i in range(3)]
        for col in columns
    )
    co, si = turned(roll)

    def of_tool(k: Array) -> Arm:
        p, q = minus(scaled(co, k[0]), scaled(si, k[1])), plus(scaled(si, k[0]), scaled(co, k[1]))
        return [plus(plus(times(p, x[i]), times(q, y[i])), scaled(z[i], k[2])) for i in range(3)]

    w = of_tool(m.wrist)
    wide = (high > _WIDE_AXIS) | (box[:, 1, 2] > _WIDE_ROLL)
    return _Tools([plus(w[0], radius), w[1], plus(w[2], height)], of_tool(m.sixth), of_tool(m.plate), wide)


def below(m: Machine, frame3: Array, box: Array, power: float, threshold: float) -> Array:
    """Planes (N, 4, 6) below (threshold k_F)^power, middle and five slopes, of the four ways of the arm in boxes (N, 2, 5); inf
    where there is no posture. frame3 (N, 3, 3): the box's axes.
    """
    tools = _tools(m, frame3, box)
    w = tools.wrist
    out = np.zeros((len(box), _WAYS, LEFT))
    away = plus(times(w[0], w[0]), times(w[1], w[1]))
    low, high = bounds(away)
    near = low < NEAR * high
    low = np.where(near, 0.5 * high, low)
    dist = root(away, low, high)
    over = inverse(dist, np.sqrt(low), np.sqrt(high))
    c1, s1 = times(w[0], over), times(w[1], over)
    silent = tools.wide | near
    for side in range(2):
        sign = 1.0 - 2.0 * side
        cc, ss = scaled(c1, sign), scaled(s1, sign)
        g6, r = (
            [plus(times(cc, v[0]), times(ss, v[1])), minus(times(cc, v[1]), times(ss, v[0])), v[2]]
            for v in (tools.sixth, tools.lever)
        )
        reach = _Reach.of(m, scaled(dist, sign), w[2])
        for elbow in range(2):
            plane, gone = _way(m, reach, elbow, g6, r, np.sqrt(bounds(away)[1]), power, threshold)
            plane[silent] = 0.0
            plane[silent, 0] = threshold**power  # k_F is 1 at least
            plane[gone & ~silent] = np.inf
            out[:, 2 * side + elbow] = plane
    return out


class _Reach(NamedTuple):
    """Shoulder and wrist in the arm's plane: x, z of the wrist from axis 1, the way v there from axis 2, its square D, the
    triangle's area and its square's bounds, and where there is no triangle.
    """

    x: Array
    z: Array
    v: tuple[Array, Array]
    D: Array
    area: Array
    over: Array
    none: Bools
    flat: Bools
    most: Array

    @classmethod
    def of(cls, m: Machine, x: Array, z: Array) -> _Reach:
        la2, lb2 = m.fore @ m.fore, m.up @ m.up
        v = shifted(x, -m.x2), z
        D = plus(times(v[0], v[0]), times(v[1], v[1]))
        G = minus(scaled(D, lb2), scaled(times(shifted(D, lb2 - la2), shifted(D, lb2 - la2)), 0.25))
        (Glow, Ghigh), (Dlow, Dhigh) = bounds(G), bounds(D)
        least, most = np.maximum(Dlow, _LEAST_D), np.maximum(Dhigh, 2.0 * _LEAST_D)
        area = root(G, np.maximum(Glow, 0.0), np.maximum(Ghigh, _LEAST_G))
        shape = np.sqrt(np.maximum(Ghigh, _LEAST_G) / np.maximum(least, _LEAST_G))
        return cls(x, z, v, D, area, inverse(D, least, most), Ghigh <= 0.0, (Glow <= 0.0) | (Dlow <= _LEAST_D), shape)


def _way(
    m: Machine, a: _Reach, elbow: int, g6: Arm, r: Arm, far: Array, power: float, threshold: float
) -> tuple[Array, Bools]:
    """The planes (N, 6) of a way, and where (N,) no posture of it keeps the limits; far (N,): the wrist's from axis 1 at most."""
    la2, lb2 = m.fore @ m.fore, m.up @ m.up
    turn = 1.0 - 2.0 * elbow
    alpha = shifted(scaled(a.over, 0.5 * (lb2 - la2)), 0.5)
    beta = scaled(times(a.area, a.over), turn)
    bx, bz = plus(times(alpha, a.v[0]), times(beta, a.v[1])), minus(times(alpha, a.v[1]), times(beta, a.v[0]))
    fx, fz = minus(a.v[0], bx), minus(a.v[1], bz)
    # the elbow's angle and the upper arm's, about +y: from (x, z) to (x cos + z sin, z cos - x sin)
    fold = np.arctan2(m.up[1] * m.fore[0] - m.up[0] * m.fore[1], m.up @ m.fore)
    cosine = scaled(shifted(a.D, -la2 - lb2), 0.5)
    gone = a.none | _angle_misses(cosine, scaled(a.area, -turn), -fold, m.sense[1], m.lower[2], m.upper[2])
    ahead = plus(scaled(bx, m.up[0]), scaled(bz, m.up[1])), minus(scaled(bx, m.up[1]), scaled(bz, m.up[0]))
    gone |= _angle_misses(*ahead, 0.0, m.sense[0], m.lower[1], m.upper[1])
    k = 1.0 / np.sqrt(la2)
    h4 = [
        plus(scaled(fx, k * m.h4[0]), scaled(fz, -k * m.h4[1])),
        np.zeros_like(fx),
        plus(scaled(fz, k * m.h4[0]), scaled(fx, k * m.h4[1])),
    ]
    kappa = dot(h4, g6)
    bends = np.arccos(np.clip(np.stack(bounds(kappa)), -1.0, 1.0))
    middle, half = bends.mean(0), 0.5 * (bends[0] - bends[1])
    flips = [_misses(m.zero5 + sign * middle, half, m.lower[4], m.upper[4]) for sign in (1.0, -1.0)]
    gone |= flips[0] & flips[1]
    bend2 = shifted(scaled(times(kappa, kappa), -1.0), 1.0)
    low, high = bounds(bend2)
    least, most = np.maximum(low, NEAR), np.maximum(high, 2 * NEAR)
    over = inverse(root(bend2, least, most), np.sqrt(least), np.sqrt(most))
    h5 = [times(v, over) for v in cross(h4, g6)]
    plane = _tangent(_jacobian(m, a, (fx, fz), r, (h4, h5, g6)), power, threshold)
    # near singular: ||inv J|| >= |y| / ||J^T y|| for a force across axis 1, or along the arm; |u| / ||J u|| at the wrist
    force = np.maximum(m.L / far, m.L / a.most)
    straight = np.sqrt(2.0 - 2.0 * np.clip(np.abs(kappa[:, 0]) - spread(kappa), 0.0, 1.0))
    force = np.maximum(force, np.sqrt(2.0 / (1.0 + (m.plate @ m.plate) / m.L**2)) / np.maximum(straight, PAD))
    rough = (threshold * np.maximum(1.0, force * np.sqrt(6.0) / 6.0)) ** power
    bad = (low < NEAR) | a.flat | ~np.isfinite(plane).all(-1)
    bad |= plane[:, 0] - np.abs(plane[:, 1:]).sum(-1) < rough
    plane[bad] = 0.0
    plane[bad, 0] = rough[bad]
    return plane, gone


def _jacobian(m: Machine, a: _Reach, fore: tuple[Array, Array], r: Arm, wrist: tuple[Arm, Arm, Arm]) -> Array:
    """The homogeneous Jacobian at the plate, forms (N, 6, 6, 7); fore: the forearm, wrist: axes four to six."""
    N = len(a.x)
    J = np.zeros((N, 6, 6, 1 + LEFT))
    px, py, pz = plus(a.x, r[0]), r[1], plus(a.z, r[2])
    y, zero = constant(np.ones(N)), constant(np.zeros(N))
    columns = [
        ([scaled(py, -1.0), px, zero], [zero, zero, y]),
        ([pz, zero, scaled(shifted(px, -m.x2), -1.0)], [zero, y, zero]),
        ([plus(fore[1], r[2]), zero, scaled(plus(fore[0], r[0]), -1.0)], [zero, y, zero]),
        *((cross(h, r), h) for h in wrist),
    ]
    for i, (v, omega) in enumerate(columns):
        for d in range(3):
            J[:, d, i], J[:, 3 + d, i] = v[d] / m.L, omega[d]
    return J


def _tangent(J: Array, power: float, threshold: float) -> Array:
    """Planes (N, 6) below (threshold k_F)^power for forms (N, 6, 6, 7) of the homogeneous Jacobian."""
    J0 = J[..., 0]
    with np.errstate(all="ignore"):
        good = np.asarray(np.isfinite(J).all((1, 2, 3)))
        good[good] = np.linalg.cond(J0[good]) < _CONDITION
        safe = np.where(good[:, None, None], J0, np.eye(J0.shape[1]))
        Y = np.linalg.inv(safe @ np.swapaxes(safe, 1, 2))
        size = np.linalg.norm(safe, axis=(1, 2))
        V = safe / size[:, None, None]
        n = np.einsum("nij,nijs->ns", V, J)
        n[:, LEFT] = np.einsum("nij,nij->n", np.abs(V), J[..., LEFT])
        K = np.einsum("nij,njks->niks", Y, J[..., :LEFT])
        e = np.einsum("nij,njk->nik", np.abs(Y), J[..., LEFT])
        c, lin = K[..., 0], K[..., 1:]
        m0, slope = (c**2).sum((1, 2)), 2.0 * np.einsum("nik,niks->ns", c, lin)
        q = np.abs(np.einsum("niks,nikt->nst", lin, lin)).sum((1, 2))
        q = q + (2.0 * np.abs(c) * e + 2.0 * np.abs(lin).sum(-1) * e + e * e).sum((1, 2))
        t = np.trace(Y, axis1=1, axis2=2)
        g = (threshold * size * t / 6.0 / np.sqrt(m0)) ** power
        gn, gm = power * g / size, -0.5 * power * g / m0
        out = gn[:, None] * n[:, :LEFT] + np.concatenate([np.zeros((len(g), 1)), gm[:, None] * slope], axis=1)
        out[:, 0] = g * (1.0 - PAD) - gn * n[:, LEFT] + gm * q
        out[~good] = np.nan
    return np.asarray(out)


def prove_bins(
    m: Machine, level: Mapping[str, NDArray[Any]], power: float, threshold: float, look: Callable[[], None]
) -> int:
    """Show that every bin's planes are below the price, and return how many boxes it took.

    look: called again and again; it raises where there is no time left. Raises ValueError where a plane isn't below.
    """
    boxes, cap = np.asarray(level["box"]), np.asarray(level["cap"])
    B = len(boxes)
    work = np.repeat(boxes, _ROLLS, axis=0)
    work[:, 0, 2] = np.tile((2 * np.arange(_ROLLS) + 1) * np.pi / _ROLLS - np.pi, B)
    work[:, 1, 2] = np.pi / _ROLLS * (1.0 + PAD)
    owner, deep, used = np.repeat(np.arange(B), _ROLLS), np.zeros(B * _ROLLS, np.int64), 0
    while len(work):
        look()
        now, bin_now, deep_now = work[-CHUNK:], owner[-CHUNK:], deep[-CHUNK:]
        work, owner, deep = work[:-CHUNK], owner[:-CHUNK], deep[:-CHUNK]
        used += len(now)
        price = below(m, np.asarray(level["frame"])[bin_now], now, power, threshold)
        most = (threshold / cap[bin_now]) ** power
        open_ = _still_open(level, bin_now, now, price, most)
        if not open_.any():
            continue
        if deep_now[open_].max() >= _DEPTH:
            raise ValueError("a plane is not below the price")
        split, o, d = now[open_], bin_now[open_], deep_now[open_] + 1
        rows, wide = np.arange(len(split)), np.argmax(_WEIGH * split[:, 1], axis=1)
        for side in (-1.0, 1.0):
            half = split.copy()
            half[rows, 0, wide] += side * 0.5 * split[rows, 1, wide]
            half[rows, 1, wide] *= 0.5 * (1.0 + PAD)
            work, owner, deep = np.concatenate([work, half]), np.concatenate([owner, o]), np.concatenate([deep, d])
    return used


def _still_open(level: Mapping[str, NDArray[Any]], owner: Ints, now: Array, price: Array, most: Array) -> Bools:
    """Which boxes (N,) have a way that none of its bin's planes is shown to be below, and that may be cheaper than `most`."""
    offset, planes, whole = np.asarray(level["offset"]), np.asarray(level["planes"]), np.asarray(level["box"])[owner]
    # a bin's plane, in the sub-box's symbols: its own four are axis, axis, radius, height in halves of the bin
    at = [0, 1, 3, 4]
    middle = (now[:, 0, at] - whole[:, 0, at]) / whole[:, 1, at]
    ratio = now[:, 1, at] / whole[:, 1, at]
    out = np.zeros(len(now), np.bool_)
    for way in range(_WAYS):
        own = price[:, way]
        with np.errstate(invalid="ignore"):  # of ways that there aren't
            cheap = np.isfinite(own[:, 0]) & (own[:, 0] - np.abs(own[:, 1:]).sum(1) < most) & ~out
        asked = np.flatnonzero(cheap)
        count = (offset[owner[asked] + 1] - offset[owner[asked]]).astype(np.int64)
        out[asked[count == 0]] = True
        asked, count = asked[count > 0], count[count > 0]
        if not len(asked):
            continue
        begin = np.cumsum(count) - count
        row = np.repeat(asked, count)
        P = planes[np.repeat(offset[owner[asked]], count) + np.arange(len(row)) - np.repeat(begin, count)]
        o = own[row]
        room = o[:, 0] - P[:, 0] - np.einsum("ni,ni->n", P[:, 1:], middle[row]) - np.abs(o[:, 3])
        room = room - np.abs(o[:, [1, 2, 4, 5]] - P[:, 1:] * ratio[row]).sum(1)
        out[asked[np.maximum.reduceat(room, begin) < 0.0]] = True
    return out
