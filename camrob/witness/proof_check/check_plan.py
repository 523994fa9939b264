"""Proves again what a certificate says of a plan's price, from cell.toml and the certificate alone.

    python -m camrob.witness.proof_check NAME.proof.npz CELL/cell.toml

Nothing of the prover or of the rest of camrob is used. The certificate falls into pieces of the path, whose bounds add up. For
each it states waypoints (the tool's tip and axis in `base`, the metres that each counts for, what a radian or a metre of table
or track costs on the way there, where a re-posture is allowed and what it costs) and gives, level by level, cells of a lattice
of the external axes, the bin of tools seen alike that each lies in, and planes below the price all over each bin. Checked is,
in this order: that the lattice spans all that the axes may go; that the first level has all cells and each further one the
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

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.witness.proof_check.bins import CHUNK, prove_bins
from camrob.witness.proof_check.dh_machine import Machine
from camrob.witness.proof_check.forms import PAD, Array, scaled

__all__ = ["check"]

Ints = NDArray[np.int64]
Level = Mapping[str, NDArray[Any]]
Late = Callable[[], bool]
State = dict[str, Any]

_WITHIN, _STEPS = 1e-5, 10  # of a bin, for rounding; prices of steps that are told apart
_LEAST_VALUE = 0.02  # 1/k_F below which no posture gets dearer
_FLAT, _CORNERS = 1e-6, 4  # that a range may be narrower by, m and rad; of a cell
_LEVEL = ("count", "k", "where", "own", "frame", "box", "cap", "offset", "planes", "rest")
_STATED = ("tip", "axis", "weight", "leap", "most", "rate", "square", "top", "haste", "low", "high", "endless")


def _demand_time(late: Late) -> None:
    if late():
        raise TimeoutError("no time left to check the certificate")


def _corner_prices(m: Machine, state: State, level: Level, low: Array, step: Array, late: Late) -> Array:
    """Prices (M, 4) at the corners of a level's cells, below which no posture of the cell is. Raises ValueError."""
    k, where, own = level["k"], level["where"], level["own"]
    free = state["conditioning"] * state["threshold"] ** state["power"]
    out: Array = np.minimum(free, state["most"][k])[:, None] * np.ones((1, _CORNERS))
    for begin in range(0, len(k), 20 * CHUNK):
        _demand_time(late)
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
                x = np.zeros_like(seen[:, 0])
                for r in range(3):
                    x = x + scaled(seen[:, 2 + r], level["frame"][b, i, r])
            else:
                x = seen[:, i - 2]
            at = [0, 1, 3, 4][i]
            form[:, i] = np.stack([x[:, 0] - level["box"][b, 0, at], x[:, 1], x[:, 2], np.abs(x[:, 3:]).sum(1)], 1)
            form[:, i] /= level["box"][b, 1, at][:, None]
        if np.any(np.abs(form[:, :, 0]) + np.abs(form[:, :, 1:]).sum(2) > 1.0 + _WITHIN):
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


def _step_prices(state: State, step: Array) -> Array:
    """(W, 2, K) what the first step along each axis costs at least, the second, and so on, the last one all further ones.

    The price is convex in the way: as steep as it is where a step begins, it stays below itself.
    """
    way = step[:, None] * np.arange(_STEPS)
    over = np.maximum(way / state["top"][..., None] - 1.0, 0.0) / state["top"][..., None]
    slope = (
        state["rate"][..., None] + 2.0 * state["square"][..., None] * way + 2.0 * state["haste"][:, None, None] * over
    )
    return np.asarray(slope * step[:, None] * (1.0 - PAD))


def _moved(D: Array, steps: Array, endless: NDArray[np.bool_]) -> Array:
    """The cheapest of all nodes and the way from there, steps (2, K)."""
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


def _cheapest(
    state: State, nodes: tuple[int, int], k: Ints, where: Ints, corner: Array, steps: Array, late: Late
) -> tuple[float, Array]:
    """The price of the cheapest way through the nodes, and of the cheapest through each cell (M,)."""
    W, endless = len(state["weight"]), state["endless"]
    order = np.searchsorted(k, np.arange(W + 1))
    index = np.stack(
        [((where[:, 0] + i) % nodes[0]) * nodes[1] + (where[:, 1] + j) % nodes[1] for i in (0, 1) for j in (0, 1)], 1
    )

    def price(t: int) -> tuple[Array, slice]:
        own = slice(order[t], order[t + 1])
        P = np.full(nodes[0] * nodes[1], state["most"][t])
        np.minimum.at(P, index[own].ravel(), corner[own].ravel())
        return 0.5 * state["weight"][t] * P.reshape(nodes), own

    D, there, least = np.zeros(nodes), np.empty((len(k), _CORNERS)), np.empty(W)
    for t in range(W):
        _demand_time(late)
        if t:
            D = _moved(D, steps[t], endless)
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
            D = _moved(D, steps[t], endless)
    return float(total), through


def check(
    file: Path,
    cell: Path,
    *,
    late: Late = lambda: False,
    say: Callable[[str], None] | None = None,
) -> float:
    """The bound, m, that a certificate proves for the machine of a cell.toml.

    late: whether there is no time left; say: called with what each level came to. Raises ValueError where it doesn't prove any,
    TimeoutError.
    """
    with np.load(file) as data:
        machine = Machine(cell, np.asarray(data["tool"], np.float64))
        common = {n: float(data[n]) for n in ("conditioning", "threshold", "power")}
        return sum(_piece(machine, data, f"{p}.", common, late, say) for p in range(int(data["pieces"])))


def _piece(
    m: Machine,
    data: Mapping[str, NDArray[Any]],
    own: str,
    common: State,
    late: Late,
    say: Callable[[str], None] | None,
) -> float:
    """The bound of one piece of the path, m."""
    state: State = {n: data[own + n] for n in _STATED} | common
    _check_statement(m, state)
    bound, levels = np.inf, int(data[own + "levels"])
    kept: tuple[Ints, Ints] | None = None
    before, proved = np.zeros(2), set[bytes]()
    for n in range(levels):
        level = {x: data[f"{own}{x}{n}"] for x in _LEVEL}
        count, k, where = level["count"], level["k"], level["where"]
        _check_cells(m, state, level, kept, before)
        step = (state["high"] - state["low"]) / count
        new = _not_among(proved, level)
        boxes = prove_bins(m, new, state["power"], state["threshold"], lambda: _demand_time(late))
        corner = _corner_prices(m, state, level, state["low"], step, late)
        nodes = tuple((count + ~state["endless"]).tolist())
        total, through = _cheapest(state, nodes, k, where, corner, _step_prices(state, step), late)
        # dearer cells may be left out: a waypoint's price at the most is said anyway
        gone = corner.min(axis=1) < state["most"][k]
        gone[level["rest"]] = False
        bound = min(bound, total if n + 1 == levels else float(through[gone].min(initial=np.inf)))
        kept, before = (k[level["rest"]], where[level["rest"]]), count
        if say is not None:
            say(f"piece {own[:-1]}, level {n}: {len(k)} cells, {len(level['box'])} bins, {boxes} boxes; {total:.4f} m")
    if not np.isfinite(bound):
        raise ValueError("a piece without levels")
    return float(bound) * (1.0 - PAD)


def _not_among(proved: set[bytes], level: Level) -> Level:
    """The bins of a level that the levels before, `proved`, didn't have, to which they are added."""
    offset, rows = level["offset"], [level[name] for name in ("frame", "box", "cap")]
    new = list[int]()
    for b in range(len(level["box"])):
        key = b"".join([*(row[b].tobytes() for row in rows), level["planes"][offset[b] : offset[b + 1]].tobytes()])
        if key not in proved:
            proved.add(key)
            new.append(b)
    count = np.diff(offset)[new]
    planes = np.concatenate([np.arange(offset[b], offset[b + 1]) for b in new] or [np.zeros(0, np.int64)])
    own = {name: level[name][new] for name in ("frame", "box", "cap")}
    return own | {"offset": np.append(0, np.cumsum(count)), "planes": level["planes"][planes]}


def _check_statement(m: Machine, state: State) -> None:
    """Raise ValueError for prices that are not covered and for axes that may go further than the lattice."""
    if state["power"] < 2.0 or np.any(
        state["most"] > state["conditioning"] * (state["threshold"] / _LEAST_VALUE) ** state["power"] * (1.0 + PAD)
    ):
        raise ValueError("prices that are not covered")
    for i in range(len(m.outer)):
        low, high = m.range_of(i)
        whole = bool(m.outer[i]["limits"].get("endless", False))
        if state["low"][i] > low + _FLAT or state["high"][i] < high - _FLAT or bool(state["endless"][i]) != whole:
            raise ValueError("an axis may go further than its lattice")


def _check_cells(m: Machine, state: State, level: Level, kept: tuple[Ints, Ints] | None, before: Array) -> None:
    """Raise ValueError for a level that lacks cells, or whose bins pass over postures that are not too dear."""
    count, k, where, E = level["count"], level["k"], level["where"], len(m.outer)
    if kept is None:
        every = np.stack(np.meshgrid(np.arange(count[0]), np.arange(count[1]), indexing="ij"), -1).reshape(-1, 2)
        W = len(state["weight"])
        wanted = np.repeat(np.arange(W), len(every)), np.tile(every, (W, 1))
    else:
        parts = np.array([[0, 0], [0, 1], [1, 0], [1, 1]])[:: 2 if E == 1 else 1]
        wanted = (
            np.repeat(kept[0], len(parts)),
            2 * np.repeat(kept[1], len(parts), 0) + np.tile(parts, (len(kept[0]), 1)),
        )
        if np.any(count != np.where(np.arange(2) < E, 2 * before, before)):
            raise ValueError("a level does not halve the one before")
    if len(k) != len(wanted[0]) or np.any(k != wanted[0]) or np.any(where != wanted[1]):
        raise ValueError("a level lacks cells")
    # the price of a bin's cap is what any of its cells' waypoints may cost at the most, or more
    some = level["own"] >= 0
    price = state["conditioning"] * (state["threshold"] / level["cap"][level["own"][some]]) ** state["power"]
    if np.any(price < state["most"][k[some]]):
        raise ValueError("a bin's cap is too high")
