"""The surface that a path cuts into stock, beside the one that the program asks for: deviation, band, causes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cutting.cutter import Cutter
from camrob.cutting.dexels import CutSurface, Dexels, Moves, deviation
from camrob.prediction.true_path import TruePath
from camrob.se3 import inverse

__all__ = ["PredictedSurface", "predict_surface"]

Array = NDArray[np.float64]

_CHUNK = 100_000  # points at once
_FARTHEST = 2e-3  # m: what a ray meets farther off is another wall
# of the distance that causes make to first order, and besides: by so much the cutter's curvature may change it (2 % were found at
# errors of a fifth of the cutter's radius, and errors here are no larger than it); another wall is farther off
_CURVED, _CURVED_ANYWAY = 0.5, 5e-5  # m
_NORMAL = 1.959963984540054  # standard deviations that hold 95 % of a normal distribution, either way


@dataclass(frozen=True)
class PredictedSurface:
    """P points of the surface, in `part`. point, normal: (P, 3), out of the material; deviation: (P,) m by which the material
    stands beyond what was programmed (below 0: cut too deep); band: (P,) m, 95 % of the deviation lie within it, either way.

    row: (P,) row of the run that cut there, at: (P,) which share of the way to the next; shares: (P, C) m of the deviation by
    cause, `rounding` (P,) that of the controller's rounded corners. not_met: points whose rays meet no other surface.
    """

    point: Array
    normal: Array
    deviation: Array
    band: Array
    row: NDArray[np.int64]
    at: Array
    shares: Array
    rounding: Array
    not_met: int


def predict_surface(
    stock: Dexels, cutter: Cutter, base_T_part: Array, path: TruePath, programmed: Array
) -> PredictedSurface:
    """Cut the stock three times: as programmed, as the simulated controller goes, and as the machine goes.

    stock: in `part`, left as it is. programmed: (M, 4, 4) tool in `base` on the path without any rounding.
    """
    part_T_base = inverse(base_T_part)
    asked, meant, real = (_moves(part_T_base, x, cutter) for x in (programmed, path.ideal, path.true))
    carved = []
    for moves in (asked, meant, real):
        left = stock.copy()
        left.carve(moves)
        carved.append(left)
    surface = carved[1].surface(meant)
    rounding = -deviation(surface, asked, carved[0], farthest=_FARTHEST)
    moved = deviation(surface, real, carved[2], farthest=_FARTHEST)
    met = np.isfinite(rounding) & np.isfinite(moved)
    keep = np.flatnonzero(met)
    twists = np.stack([c.twist for c in path.causes], axis=2) if path.causes else np.zeros((len(path.t), 6, 0))
    shares, band = _reckoned(surface, keep, path, twists, part_T_base)
    own = _own_wall(moved[keep], shares.sum(axis=1))
    keep, shares, band = keep[own], shares[own], band[own]
    return PredictedSurface(
        point=surface.point[keep],
        normal=surface.normal[keep],
        deviation=(rounding + moved)[keep],
        band=band,
        row=surface.move[keep],
        at=surface.at[keep],
        shares=shares,
        rounding=rounding[keep],
        not_met=int(len(met) - len(keep)),
    )


def _own_wall(moved: Array, reckoned: Array) -> NDArray[np.bool_]:
    """(P,) whether a ray has met the wall that its point was on: where grooves cross, it may run on to another's, and its length
    says nothing of the error. reckoned: (P,) m by which the causes move the wall, to first order.
    """
    return np.asarray(np.abs(moved - reckoned) <= _CURVED * np.abs(reckoned) + _CURVED_ANYWAY)


def _moves(part_T_base: Array, base_T_tool: Array, cutter: Cutter) -> Moves:
    part_T_tool = part_T_base @ base_T_tool
    return Moves.along(part_T_tool[:, :3, 3], part_T_tool[:, :3, 2], cutter)


def _reckoned(
    surface: CutSurface, keep: NDArray[np.int64], path: TruePath, twists: Array, part_T_base: Array
) -> tuple[Array, Array]:
    """Shares (P, C) of the causes in the deviation, and the band (P,)."""
    shares, band = np.zeros((len(keep), twists.shape[2])), np.zeros(len(keep))
    part_p_tip = (part_T_base @ path.ideal)[:, :3, 3]
    for start in range(0, len(keep), _CHUNK):
        some = keep[start : start + _CHUNK]
        row, at = surface.move[some], surface.at[some][:, None]
        n = surface.normal[some]
        arm = surface.point[some] - (part_p_tip[row] * (1.0 - at) + part_p_tip[row + 1] * at)
        # n . (v + w x r), seen from `base`
        wrench = np.concatenate([n, np.cross(arm, n)], axis=1)
        wrench = np.concatenate([wrench[:, :3] @ part_T_base[:3, :3], wrench[:, 3:] @ part_T_base[:3, :3]], axis=1)
        here = slice(start, start + len(some))

        shares[here] = np.einsum("pi,pik->pk", wrench, _between(twists, row, at))
        variance = np.sum(np.einsum("pi,pik->pk", wrench, _between(path.spread, row, at)) ** 2, axis=1) + path.rest**2
        variance += np.sum((wrench * _between(path.doubt, row, at)) ** 2, axis=1)
        band[here] = _NORMAL * np.sqrt(variance)
    return shares, band


def _between(values: Array, row: NDArray[np.int64], at: Array) -> Array:
    """Values (N, ...) of the run between its rows: (P, ...) at shares (P, 1) of the way to the next."""
    share = at.reshape(-1, *[1] * (values.ndim - 1))
    return np.asarray(values[row] * (1.0 - share) + values[row + 1] * share)
