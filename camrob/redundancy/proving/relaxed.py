"""The cheapest way through a lattice of the external axes, and what the cheapest through each cell costs, compiled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel, part

__all__ = ["cheapest_through"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@part
def _stepped(D: Array, E: Array, price: float, axis: int, endless: bool) -> None:
    """D (n, m) <- the cheaper of itself and of what one step from a neighbour along an axis comes to; E (n, m): room."""
    n, m = D.shape
    E[:] = D
    for i in range(n):
        for j in range(m):
            a, b = (i - 1, i + 1) if axis == 0 else (j - 1, j + 1)
            if endless:
                a, b = (a % n, b % n) if axis == 0 else (a % m, b % m)
            if a >= 0:
                D[i, j] = min(D[i, j], (E[a, j] if axis == 0 else E[i, a]) + price)
            if b < (n if axis == 0 else m):
                D[i, j] = min(D[i, j], (E[b, j] if axis == 0 else E[i, b]) + price)


@part
def _swept(D: Array, price: float, axis: int, endless: bool) -> None:
    """D (n, m) <- the cheapest of all its nodes along an axis and the steps from there."""
    n, m = D.shape
    for _turn in range(2 if endless else 1):
        if axis == 0:
            for i in range(0 if endless else 1, n):
                for j in range(m):
                    D[i, j] = min(D[i, j], D[i - 1, j] + price)
            for i in range(n - 1 if endless else n - 2, -1, -1):
                for j in range(m):
                    D[i, j] = min(D[i, j], D[(i + 1) % n, j] + price)
        else:
            for i in range(n):
                for j in range(0 if endless else 1, m):
                    D[i, j] = min(D[i, j], D[i, j - 1] + price)
                for j in range(m - 1 if endless else m - 2, -1, -1):
                    D[i, j] = min(D[i, j], D[i, (j + 1) % m] + price)


@part
def _spread(D: Array, E: Array, steps: Array, endless: NDArray[np.bool_]) -> None:
    """D (n, m) <- the cheapest of all its nodes and the way from there, steps (2, K): price of the first step along each axis, of
    the second, and so on, none cheaper than the one before; the last one's holds for all further ones.
    """
    K = steps.shape[1]
    for axis in range(2):
        for k in range(K - 1):
            if steps[axis, k] < steps[axis, K - 1]:
                _stepped(D, E, steps[axis, k], axis, endless[axis])
        _swept(D, steps[axis, K - 1], axis, endless[axis])


@part
def _fill(P: Array, k: int, most: Array, offset: Ints, cell: Ints, corner: Array, endless: NDArray[np.bool_]) -> None:
    """P (n, m) <- prices of layer k's nodes, the most where no cell is beside."""
    n, m = P.shape
    P[:] = most[k]
    for e in range(offset[k], offset[k + 1]):
        for c in range(4):
            i, j = cell[e, 0] + c // 2, cell[e, 1] + c % 2
            if endless[0]:
                i %= n
            if endless[1]:
                j %= m
            P[i, j] = min(P[i, j], corner[e, c])


@part
def _leap(D: Array, price: float) -> None:
    """A re-posture from the cheapest node to any."""
    least = np.min(D)
    for i in range(D.shape[0]):
        for j in range(D.shape[1]):
            D[i, j] = min(D[i, j], least + price)


@part
def _pay(D: Array, P: Array, half: float) -> None:
    """D (n, m) <- what it is with half of what the nodes cost."""
    for i in range(D.shape[0]):
        for j in range(D.shape[1]):
            D[i, j] += half * P[i, j]


@part
def _to_corners(D: Array, begin: int, end: int, cell: Ints, out: Array) -> None:
    """out (M, 4) <- what D (n, m) is at the corners of cells `begin` to before `end`."""
    for e in range(begin, end):
        for c in range(4):
            out[e, c] = D[(cell[e, 0] + c // 2) % D.shape[0], (cell[e, 1] + c % 2) % D.shape[1]]


@kernel(nogil=True)
def cheapest_through(
    nodes: Ints,
    endless: NDArray[np.bool_],
    most: Array,
    offset: Ints,
    cell: Ints,
    corner: Array,
    weight: Array,
    steps: Array,
    leap: Array,
) -> tuple[float, Array]:
    """The price of the cheapest way through all layers, and what the cheapest through each cell (M,) costs at least.

    nodes (2,): of the lattice; layer k's cells are offset[k] .. offset[k + 1], cell (M, 2), corner (M, 4) a metre; weight (W,);
    steps (W, 2, K): of steps on the way to a layer (`_spread`); leap (W,): price of a re-posture there, inf where there is none.
    """
    W = weight.shape[0]
    P, D = np.empty((nodes[0], nodes[1])), np.zeros((nodes[0], nodes[1]))
    E = np.empty((nodes[0], nodes[1]))
    there, ahead, onward = (np.empty((cell.shape[0], 4)), np.empty((cell.shape[0], 4)), np.empty((cell.shape[0], 4)))
    for k in range(W):
        if k > 0:
            _spread(D, E, steps[k], endless)
        _fill(P, k, most, offset, cell, corner, endless)
        _pay(D, P, 0.5 * weight[k])
        _to_corners(D, offset[k], offset[k + 1], cell, there)
        if leap[k] < np.inf:
            _leap(D, leap[k])
        _pay(D, P, 0.5 * weight[k])
    price = np.min(D)
    D[:] = 0.0
    through = np.full(cell.shape[0], np.inf)
    for k in range(W - 1, -1, -1):
        _fill(P, k, most, offset, cell, corner, endless)
        _pay(D, P, 0.5 * weight[k])
        # arriving at a node (there) and leaving it or leaping first; or leapt to from the cheapest
        least = np.inf
        _to_corners(D, offset[k], offset[k + 1], cell, onward)
        if leap[k] < np.inf:
            for e in range(offset[k], offset[k + 1]):
                for c in range(4):
                    least = min(least, there[e, c])
            _leap(D, leap[k])
        _to_corners(D, offset[k], offset[k + 1], cell, ahead)
        for e in range(offset[k], offset[k + 1]):
            for c in range(4):
                through[e] = min(through[e], there[e, c] + ahead[e, c], least + leap[k] + onward[e, c])
        _pay(D, P, 0.5 * weight[k])
        if k > 0:
            _spread(D, E, steps[k], endless)
    return price, through
