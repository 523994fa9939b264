"""Proves again what a certificate says of a plan's price, from cell.toml and the certificate alone.

`python tests/bench/proving/checking/check_plan.py FILE.npz CELL.toml`

Nothing of the prover or of camrob is used. The certificate states waypoints (the tool's tip and axis in `base`, the metres that
each counts for, what a radian or a metre of table or track costs on the way there, where a re-posture is allowed and what it
costs) and gives, level by level, cells of a lattice of the external axes, the bin of tools seen alike that each lies in, and
planes below the price all over each bin. Checked is, in this order: that the first level has all cells and each further one the
parts of all that the one before kept; that every posture in every bin is dearer than the lowest of its planes there, or has a
1/k_F no higher than the bin's cap, so that it costs what the waypoint's `most` says (`bins.below`, boxes halved until they show
it); that the cells lie in their bins; and the cheapest way through each level's nodes. The bound is the least of the last
level's cheapest way and of the cheapest ways through cells that were dropped.

Why one plane suffices: with the homogeneous Jacobian J and any constant Y, ||inv J|| >= tr Y / ||Y J||, equal at Y = inv(J
J^T), and ||J|| >= <V, J> for any V of length 1. So (threshold k_F)^p is above c (n / m)^p with n = <V, J> and m^2 = ||Y J||^2,
which is convex in n and m^2 for p >= 2: its tangent lies below. J itself comes from the closed form of the arm in affine forms,
arrays (.., 7): the middle, what five symbols of [-1, 1] (axis along x and y, roll, radius, height) change it by, and what is
left. Rounding is not followed step by step: every bound is lowered by 1e-9 of itself, thousands of times what some hundred
operations in double precision amount to.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from proving.checking.bins import CHUNK, prove_bins
from proving.checking.forms import PAD, scaled
from proving.checking.machine import Machine

WITHIN, STEPS = 1e-5, 10


def corner_prices(m, state, level, low, step):
    """Prices (M, 4) at the corners of a level's cells, below which no posture of the cell is. Raises ValueError."""
    k, where, own = level["k"], level["where"], level["own"]
    free = state["conditioning"] * state["threshold"] ** state["power"]
    out = np.minimum(free, state["most"][k])[:, None] * np.ones((1, 4))
    for begin in range(0, len(k), 20 * CHUNK):
        some = begin + np.flatnonzero(own[begin : begin + 20 * CHUNK] >= 0)
        seen, near = m.seen(
            state["tip"][k[some]], state["axis"][k[some]], low + (where[some] + 0.5) * step, 0.5 * step * (1.0 + PAD)
        )
        some, seen = some[~near], seen[~near]
        b = own[some]
        form = np.empty(
            (len(some), 4, 4)
        )  # middle, two slopes, the rest; of axis along x and y, radius, height, in halves of the bin
        for i in range(4):
            if i < 2:
                x = sum(scaled(seen[:, 2 + r], level["frame"][b, i, r]) for r in range(3))
            else:
                x = seen[:, i - 2]
            at = [0, 1, 3, 4][i]
            form[:, i] = np.stack([x[:, 0] - level["box"][b, 0, at], x[:, 1], x[:, 2], np.abs(x[:, 3:]).sum(1)], 1)
            form[:, i] /= level["box"][b, 1, at][:, None]
        if np.any(np.abs(form[:, :, 0]) + np.abs(form[:, :, 1:]).sum(2) > 1.0 + WITHIN):
            raise ValueError("a cell leaves its bin")
        price = np.repeat(state["most"][k[some]][:, None], 4, axis=1)
        count = np.diff(level["offset"])[b]
        for p in range(int(count.max(initial=0))):
            has = count > p
            P = state["conditioning"] * level["planes"][level["offset"][b[has]] + p]
            f = form[has]
            mid = (
                P[:, 0]
                + np.einsum("ni,ni->n", P[:, 1:], f[:, :, 0])
                - np.einsum("ni,ni->n", np.abs(P[:, 1:]), f[:, :, 3] + PAD)
            )
            one, two = (np.einsum("ni,ni->n", P[:, 1:], f[:, :, j]) for j in (1, 2))
            each = np.stack([mid - one - two, mid - one + two, mid + one - two, mid + one + two], 1)
            price[has] = np.minimum(price[has], each)
        out[some] = np.maximum(np.minimum(price, state["most"][k[some]][:, None]), 0.0)
    return out


def step_prices(state, step):
    """(W, 2, STEPS) what the first step along each axis costs at least, the second, and so on, the last one all further ones.

    The price is convex in the way: as steep as it is where a step begins, it stays below itself.
    """
    way = step[:, None] * np.arange(STEPS)
    over = np.maximum(way / state["top"][..., None] - 1.0, 0.0) / state["top"][..., None]
    slope = (
        state["rate"][..., None] + 2.0 * state["square"][..., None] * way + 2.0 * state["haste"][:, None, None] * over
    )
    return slope * step[:, None] * (1.0 - PAD)


def moved(D, steps, endless):
    """The cheapest of all nodes and the way from there, steps (2, STEPS)."""
    for axis in range(2):
        n = D.shape[axis]
        if n == 1:
            continue
        E = np.moveaxis(np.concatenate([D] * 3, axis=axis) if endless[axis] else D, axis, 0)
        for price in steps[axis, :-1]:
            if price >= steps[axis, -1]:
                break
            new = E.copy()
            np.minimum(new[1:], E[:-1] + price, out=new[1:])
            np.minimum(new[:-1], E[1:] + price, out=new[:-1])
            E = new
        ramp = (steps[axis, -1] * np.arange(len(E)))[:, None]
        up = np.minimum.accumulate(E - ramp) + ramp
        down = np.minimum.accumulate((E + ramp)[::-1])[::-1] - ramp
        E = np.minimum(up, down)
        D = np.moveaxis(E[n : 2 * n] if endless[axis] else E, 0, axis)
    return D


def cheapest(state, nodes, k, where, corner, steps):
    """The price of the cheapest way through the nodes, and of the cheapest through each cell (M,)."""
    W, endless = len(state["weight"]), state["endless"]
    order = np.searchsorted(k, np.arange(W + 1))
    index = np.stack(
        [((where[:, 0] + i) % nodes[0]) * nodes[1] + (where[:, 1] + j) % nodes[1] for i in (0, 1) for j in (0, 1)], 1
    )

    def price(t):
        own = slice(order[t], order[t + 1])
        P = np.full(nodes[0] * nodes[1], state["most"][t])
        np.minimum.at(P, index[own].ravel(), corner[own].ravel())
        return 0.5 * state["weight"][t] * P.reshape(nodes), own

    D, there, least = np.zeros(nodes), np.empty((len(k), 4)), np.empty(W)
    for t in range(W):
        if t:
            D = moved(D, steps[t], endless)
        P, own = price(t)
        D = D + P
        there[own], least[t] = D.ravel()[index[own]], D.min()
        D = np.minimum(D, least[t] + state["leap"][t]) + P
    total, through = D.min(), np.empty(len(k))
    D = np.zeros(nodes)
    for t in range(W - 1, -1, -1):
        P, own = price(t)
        D = D + P
        after = np.minimum(D, D.min() + state["leap"][t])
        leapt = least[t] + state["leap"][t] + D.ravel()[index[own]]
        through[own] = np.minimum(there[own] + after.ravel()[index[own]], leapt).min(axis=1)
        D = after + P
        if t:
            D = moved(D, steps[t], endless)
    return total, through


def check(file, cell):
    """The bound, m, that a certificate proves. Raises ValueError where it doesn't prove any."""
    data = np.load(file)
    state = {
        n: data[n]
        for n in ("tip", "axis", "weight", "leap", "most", "rate", "square", "top", "haste", "low", "high", "endless")
    }
    state |= {n: float(data[n]) for n in ("conditioning", "threshold", "power")}
    m, bound = Machine(cell), np.inf
    if state["power"] < 2.0 or np.any(
        state["most"] > state["conditioning"] * (state["threshold"] / 0.02) ** state["power"] * (1.0 + PAD)
    ):
        raise ValueError("prices that are not covered")
    W, E = len(state["weight"]), len(m.outer)
    kept, before = None, np.zeros(2)
    for n in range(int(data["levels"])):
        level = {
            x: data[f"{x}{n}"]
            for x in ("count", "k", "where", "own", "frame", "box", "cap", "offset", "planes", "rest")
        }
        count, k, where = level["count"], level["k"], level["where"]
        parts = np.array([[0, 0], [0, 1], [1, 0], [1, 1]])[:: {2: 1, 1: 2}[E]]
        if kept is None:
            every = np.stack(np.meshgrid(np.arange(count[0]), np.arange(count[1]), indexing="ij"), -1).reshape(-1, 2)
            wanted = np.repeat(np.arange(W), len(every)), np.tile(every, (W, 1))
        else:
            wanted = (
                np.repeat(kept[0], len(parts)),
                2 * np.repeat(kept[1], len(parts), 0) + np.tile(parts, (len(kept[0]), 1)),
            )
            if np.any(count != np.where(np.arange(2) < E, 2 * before, before)):
                raise ValueError("a level does not halve the one before")
        if len(k) != len(wanted[0]) or np.any(k != wanted[0]) or np.any(where != wanted[1]):
            raise ValueError("a level lacks cells")
        step = (state["high"] - state["low"]) / count
        # the price of a bin's cap is what any of its cells' waypoints may cost at the most, or more
        some = level["own"] >= 0
        if np.any(
            state["conditioning"] * (state["threshold"] / level["cap"][level["own"][some]]) ** state["power"]
            < state["most"][k[some]]
        ):
            raise ValueError("a bin's cap is too high")
        boxes = prove_bins(m, level, state["power"], state["threshold"])
        corner = corner_prices(m, state, level, state["low"], step)
        total, through = cheapest(state, tuple(count + ~state["endless"]), k, where, corner, step_prices(state, step))
        last = n + 1 == int(data["levels"])
        gone = (
            corner.min(axis=1) < state["most"][k]
        )  # the others may be left out: a waypoint's price at the most is said anyway
        gone[level["rest"]] = False
        bound = min(bound, total) if last else min(bound, through[gone].min(initial=np.inf))
        kept, before = (k[level["rest"]], where[level["rest"]]), count
        print(
            f"level {n}: {len(k)} cells, {len(level['box'])} bins, {len(level['planes'])} planes shown with {boxes} boxes; "
            f"{total:.4f} m",
            flush=True,
        )
    return float(bound) * (1.0 - PAD)


if __name__ == "__main__":
    print(f"proved: no plan through these waypoints costs less than {check(*sys.argv[1:3]):.4f} m")
