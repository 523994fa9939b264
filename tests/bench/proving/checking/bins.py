"""Planes below the price of every posture in boxes of tools seen alike, and whether a certificate's planes are below them."""

from __future__ import annotations

import numpy as np

from proving.checking.forms import (
    LEFT,
    PAD,
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
from proving.checking.machine import NEAR

ROLLS, DEPTH, CHUNK = 8, 40, 4000


def angle_misses(c, s, zero, sense, low, high):
    """Whether sense * (angle of (c, s) + zero) misses [low, high], turns apart."""
    rho = np.hypot(c[:, 0], s[:, 0])
    far = np.hypot(spread(c), spread(s))
    half = np.where(far < 0.7 * rho, np.arcsin(np.minimum(far / np.maximum(rho, 1e-300), 1.0)) + PAD, np.pi)
    return misses(sense * (np.arctan2(s[:, 0], c[:, 0]) + zero), half, low, high)


def misses(middle, half, low, high):
    d = middle - 0.5 * (low + high)
    d = d - 2.0 * np.pi * np.round(d / (2.0 * np.pi))
    return np.abs(d) > 0.5 * (high - low) + half + PAD


def below(m, frame3, box, power, threshold):
    """Planes (N, 4, 6) below (threshold k_F)^power, middle and five slopes, of the four ways of the arm in boxes (N, 2, 5); inf
    where there is no posture.
    """
    N = len(box)
    sym = [constant(box[:, 0, i]) for i in range(5)]
    for i in range(5):
        sym[i][:, 1 + i] = box[:, 1, i]
    a, b, roll, radius, height = sym
    out = np.full((N, 4, 6), 0.0)
    out[:, :, 0] = threshold**power  # k_F is 1 at least
    flat = plus(times(a, a), times(b, b))
    c = root(
        shifted(scaled(flat, -1.0), 1.0), 1.0 - np.minimum(bounds(flat)[1], 0.9), 1.0 - np.maximum(bounds(flat)[0], 0.0)
    )
    wide = (bounds(flat)[1] > 0.9) | (box[:, 1, 2] > 0.6)
    share = inverse(shifted(c, 1.0), *bounds(shifted(c, 1.0)))
    aa, ab, bb = (times(times(u, v), share) for u, v in ((a, a), (a, b), (b, b)))
    f = frame3[:, :, :, None]  # rows x, y, z
    one = constant(np.ones(N))
    cols = (
        (minus(one, aa), scaled(ab, -1.0), scaled(a, -1.0)),
        (scaled(ab, -1.0), minus(one, bb), scaled(b, -1.0)),
        (a, b, c),
    )
    X, Y, Z = ([sum(scaled(k, f[:, r, i, 0]) for r, k in enumerate(col)) for i in range(3)] for col in cols)
    co, si = turned(roll)

    def of_tool(k):
        p, q = minus(scaled(co, k[0]), scaled(si, k[1])), plus(scaled(si, k[0]), scaled(co, k[1]))
        return [plus(plus(times(p, X[i]), times(q, Y[i])), scaled(Z[i], k[2])) for i in range(3)]

    w, h6, lever = of_tool(m.wrist), of_tool(m.sixth), of_tool(m.plate)
    w = [plus(w[0], radius), w[1], plus(w[2], height)]
    away = plus(times(w[0], w[0]), times(w[1], w[1]))
    low, high = bounds(away)
    near = low < NEAR * high
    low = np.where(near, 0.5 * high, low)
    dist = root(away, low, high)
    over = inverse(dist, np.sqrt(low), np.sqrt(high))
    c1, s1 = times(w[0], over), times(w[1], over)
    la2, lb2 = m.fore @ m.fore, m.up @ m.up
    for side in range(2):
        sign = 1.0 - 2.0 * side
        cc, ss, x = scaled(c1, sign), scaled(s1, sign), scaled(dist, sign)
        g6, r = (
            [plus(times(cc, v[0]), times(ss, v[1])), minus(times(cc, v[1]), times(ss, v[0])), v[2]] for v in (h6, lever)
        )
        vx, vz = shifted(x, -m.x2), w[2]
        D = plus(times(vx, vx), times(vz, vz))
        G = minus(scaled(D, lb2), scaled(times(shifted(D, lb2 - la2), shifted(D, lb2 - la2)), 0.25))
        none = bounds(G)[1] <= 0.0
        Dlow, Dhigh = np.maximum(bounds(D)[0], 1e-4), np.maximum(bounds(D)[1], 2e-4)
        Glow, Ghigh = np.maximum(bounds(G)[0], 0.0), np.maximum(bounds(G)[1], 1e-12)
        area, invD = root(G, Glow, Ghigh), inverse(D, Dlow, Dhigh)
        alpha = shifted(scaled(invD, 0.5 * (lb2 - la2)), 0.5)
        cosine = scaled(shifted(D, -la2 - lb2), 0.5)
        for elbow in range(2):
            turn = 1.0 - 2.0 * elbow
            beta = scaled(times(area, invD), turn)
            bx, bz = plus(times(alpha, vx), times(beta, vz)), minus(times(alpha, vz), times(beta, vx))
            fx, fz = minus(vx, bx), minus(vz, bz)
            way = 2 * side + elbow
            # the elbow's angle and the upper arm's, about +y: from (x, z) to (x cos + z sin, z cos - x sin)
            fold = np.arctan2(m.up[1] * m.fore[0] - m.up[0] * m.fore[1], m.up @ m.fore)
            gone = none | angle_misses(cosine, scaled(area, -turn), -fold, m.sense[1], m.lower[2], m.upper[2])
            ahead = plus(scaled(bx, m.up[0]), scaled(bz, m.up[1])), minus(scaled(bx, m.up[1]), scaled(bz, m.up[0]))
            gone |= angle_misses(*ahead, 0.0, m.sense[0], m.lower[1], m.upper[1])
            k = 1.0 / np.sqrt(la2)
            h4 = [
                plus(scaled(fx, k * m.h4[0]), scaled(fz, -k * m.h4[1])),
                constant(np.zeros(N)),
                plus(scaled(fz, k * m.h4[0]), scaled(fx, k * m.h4[1])),
            ]
            n = cross(h4, g6)
            kappa = dot(h4, g6)
            bends = np.arccos(np.clip(np.stack(bounds(kappa)), -1.0, 1.0))
            middle, half = bends.mean(0), 0.5 * (bends[0] - bends[1])
            gone |= misses(m.zero5 + middle, half, m.lower[4], m.upper[4]) & misses(
                m.zero5 - middle, half, m.lower[4], m.upper[4]
            )
            bend2 = shifted(scaled(times(kappa, kappa), -1.0), 1.0)
            low, high = bounds(bend2)
            flat_wrist = low < NEAR
            invn = inverse(
                root(bend2, np.maximum(low, NEAR), np.maximum(high, 2 * NEAR)),
                np.sqrt(np.maximum(low, NEAR)),
                np.sqrt(np.maximum(high, 2 * NEAR)),
            )
            h5 = [times(v, invn) for v in n]
            J = np.zeros((N, 6, 6, 7))
            px, py, pz = plus(x, r[0]), r[1], plus(w[2], r[2])
            y, zero = constant(np.ones(N)), constant(np.zeros(N))
            columns = [
                ([scaled(py, -1.0), px, zero], [zero, zero, y]),
                ([pz, zero, scaled(shifted(px, -m.x2), -1.0)], [zero, y, zero]),
                ([plus(fz, r[2]), zero, scaled(plus(fx, r[0]), -1.0)], [zero, y, zero]),
                *((cross(h, r), h) for h in (h4, h5, g6)),
            ]
            for i, (v, omega) in enumerate(columns):
                for d in range(3):
                    J[:, d, i], J[:, 3 + d, i] = v[d] / m.L, omega[d]
            plane = tangent(J, power, threshold)
            # near singular: ||inv J|| >= |y| / ||J^T y|| for a force across axis 1, or along the arm; |u| / ||J u|| at the wrist
            force = np.maximum(m.L / np.sqrt(bounds(away)[1]), m.L / np.sqrt(Ghigh / np.maximum(Dlow, 1e-12)))
            straight = np.sqrt(2.0 - 2.0 * np.clip(np.abs(kappa[:, 0]) - spread(kappa), 0.0, 1.0))
            force = np.maximum(force, np.sqrt(2.0 / (1.0 + (m.plate @ m.plate) / m.L**2)) / np.maximum(straight, 1e-9))
            rough = (threshold * np.maximum(1.0, force * np.sqrt(6.0) / 6.0)) ** power
            bad = (
                near | wide | flat_wrist | (bounds(G)[0] <= 0.0) | (bounds(D)[0] <= 1e-4) | ~np.isfinite(plane).all(-1)
            )
            least = plane[:, 0] - np.abs(plane[:, 1:]).sum(-1)
            bad |= least < rough
            plane[bad] = 0.0
            plane[bad, 0] = np.where(wide | near, threshold**power, rough)[bad]
            plane[gone & ~near & ~wide] = np.inf
            out[:, way] = plane
    return out


def tangent(J, power, threshold):
    """Planes (N, 6) below (threshold k_F)^power for forms (N, 6, 6, 7) of the homogeneous Jacobian."""
    J0 = J[..., 0]
    with np.errstate(all="ignore"):
        good = np.isfinite(J).all((1, 2, 3))
        good[good] = np.linalg.cond(J0[good]) < 1e4
        safe = np.where(good[:, None, None], J0, np.eye(6))
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
    return out


def prove_bins(m, level, power, threshold):
    """Show that every bin's planes are below the price, and return how many boxes it took. Raises ValueError where it can't."""
    frames, boxes, cap = level["frame"], level["box"], level["cap"]
    offset, planes = level["offset"], level["planes"]
    B = len(boxes)
    work = np.repeat(boxes, ROLLS, axis=0)
    work[:, 0, 2] = np.tile((2 * np.arange(ROLLS) + 1) * np.pi / ROLLS - np.pi, B)
    work[:, 1, 2] = np.pi / ROLLS * (1.0 + PAD)
    owner, deep, used = np.repeat(np.arange(B), ROLLS), np.zeros(B * ROLLS, int), 0
    weigh = np.array([0.6, 0.6, 0.6, 1.2, 1.2])
    while len(work):
        now, owner_now, deep_now = work[-CHUNK:], owner[-CHUNK:], deep[-CHUNK:]
        work, owner, deep = work[:-CHUNK], owner[:-CHUNK], deep[:-CHUNK]
        used += len(now)
        price = below(m, frames[owner_now], now, power, threshold)
        most = (threshold / cap[owner_now]) ** power
        # a bin's plane, in the sub-box's symbols: its own four are axis, axis, radius, height in halves of the bin
        open_ = np.zeros(len(now), bool)
        at = [0, 1, 3, 4]
        whole = boxes[owner_now]
        middle = (now[:, 0, at] - whole[:, 0, at]) / whole[:, 1, at]
        ratio = now[:, 1, at] / whole[:, 1, at]
        for i in range(len(now)):
            P = planes[offset[owner_now[i]] : offset[owner_now[i] + 1]]
            for way in range(4):
                own = price[i, way]
                if not np.isfinite(own[0]) or own[0] - np.abs(own[1:]).sum() >= most[i]:
                    continue
                slopes = P[:, 1:] * ratio[i]
                room = own[0] - P[:, 0] - P[:, 1:] @ middle[i] - abs(own[3])
                room = room - np.abs(own[[1, 2, 4, 5]] - slopes).sum(1)
                if not len(P) or room.max() < 0.0:
                    open_[i] = True
                    break
        if not open_.any():
            continue
        if deep_now[open_].max() >= DEPTH:
            raise ValueError("a plane is not below the price")
        split, o, d = now[open_], owner_now[open_], deep_now[open_] + 1
        wide = np.argmax(weigh * split[:, 1], axis=1)
        rows = np.arange(len(split))
        for side in (-1.0, 1.0):
            part = split.copy()
            part[rows, 0, wide] += side * 0.5 * split[rows, 1, wide]
            part[rows, 1, wide] *= 0.5 * (1.0 + PAD)
            work, owner, deep = np.concatenate([work, part]), np.concatenate([owner, o]), np.concatenate([deep, d])
    return used
