"""How much more stays the farther postures lie from every fitted one, measured on halves of the logs that a fit leaves out.

What a fit's own covariance says of far postures holds where the description is right up to a smooth discrepancy. On a real arm
it is not: values are off by ten of their standard errors. So the logs are asked themselves: fitted on one side of an axis's
travel, how much stays on the other, beside what stays where small neighbourhoods are left out.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from camrob.gap.evidence.discrepancy import normalised
from camrob.gap.evidence.model import Model, whole_gap
from camrob.gap.evidence.shrink import Trial, settled
from camrob.gap.observation.scene import Scene

__all__ = ["distance_of", "stays_far_off"]

Array = NDArray[np.float64]
Set = frozenset[int]

_FITTED, _ASKED = 2000, 300  # rows that tell well enough how far off others are
_NEVER = 8.0  # times the largest value of a sliding axis: so far apart are values that are not the same a period on


def stays_far_off(model: Model, trial: Trial, keep: Set) -> float:
    """m2 (mean square of the position) that stay on named withheld samples beyond what stays near what was fitted, once `keep`
    is taken away; 0 for blocks of the logs themselves, and where one half tells the other as well as neighbourhoods.

    In proportion to the median distance to the nearest fitted posture, from that of neighbourhoods up to that of halves.
    """
    blocks = sorted({(k, int(b)) for k, p in enumerate(model.panels) for b in np.unique(p.block)})
    if not trial.named or len(blocks) < 2:
        return 0.0
    near = [_left_out(model, keep, [b]) for b in blocks]
    far = [_left_out(model, keep, half) for half in _halves(model, blocks)]
    (d_near, m_near), (d_far, m_far) = (
        np.average([x[:2] for x in s], axis=0, weights=[x[2] for x in s]) for s in (near, far)
    )
    if d_far <= d_near or m_far <= m_near:
        return 0.0
    share = np.clip((distance_of(model, trial) - d_near) / (d_far - d_near), 0.0, 1.0)
    return float(share * (m_far - m_near))


def distance_of(model: Model, trial: Trial) -> float:
    """The median distance from postures of withheld logs to the nearest fitted one, rad, or what counts as such of slides."""
    fitted = _postures(model, [(p.scene, np.ones(len(p.scene), np.bool_)) for p in model.panels])
    asked = _postures(model, [(trial.panels[k].scene, rows) for k, rows, _ in trial.asked])
    return _apart(model, asked, fitted)


def _halves(model: Model, blocks: Sequence[tuple[int, int]]) -> tuple[list[tuple[int, int]], list[tuple[int, int]]]:
    """Blocks to either side of the axis along which their middles lie farthest apart."""
    middles = [_postures(model, [(model.panels[k].scene, model.panels[k].block == b)]).mean(axis=0) for k, b in blocks]
    along = np.array(middles)[:, int(np.argmax(np.ptp(middles, axis=0)))]
    order = [blocks[i] for i in np.argsort(along, kind="stable")]
    return order[: len(order) // 2], order[len(order) // 2 :]


def _left_out(model: Model, keep: Set, blocks: Sequence[tuple[int, int]]) -> tuple[float, float, int]:
    """Distance, m2 that stay once `keep` is taken away, and rows, of some blocks, which the fit leaves out."""
    own = {k: np.isin(p.block, [b for j, b in blocks if j == k]) for k, p in enumerate(model.panels)}
    fitted = model.fit(model.best.members | model.evidence.always, tuple(b for _, b in blocks))
    values, left = model.values(keep, fitted), []
    for k, rows in own.items():
        p = model.panels[k]
        good = rows & (p.w_tcp[:, 0] > 0.0)
        if good.any():
            left.append(settled(model, p, good, (whole_gap(p) - p.moves(values))[good]))
    asked = _postures(model, [(model.panels[k].scene, rows) for k, rows in own.items()])
    others = _postures(model, [(model.panels[k].scene, ~rows) for k, rows in own.items()])
    gone = np.concatenate(left) if left else np.zeros((0, 3))
    return _apart(model, asked, others), float(np.sum(gone**2)) / max(len(gone), 1), len(gone)


def _postures(model: Model, parts: Sequence[tuple[Scene, NDArray[np.bool_]]]) -> Array:
    """(N, k) of some rows of some logs, rad of turning axes and what counts as such of sliding ones."""
    return np.concatenate([normalised(scene, model.basis.axes)[rows] for scene, rows in parts])


def _apart(model: Model, asked: Array, fitted: Array) -> float:
    """The median distance from postures to the nearest others; a whole turn of an axis is none."""
    cell = model.scenes[0].cell
    turns = np.array([not cell.joints[cell.index(a)].prismatic for a in model.basis.axes])
    asked, fitted = (
        v[np.unique(np.linspace(0, len(v) - 1, min(len(v), n)).astype(int))]
        for v, n in ((asked, _ASKED), (fitted, _FITTED))
    )
    # sliding axes never come round: a period in which none of them reaches half way counts as none
    period = np.where(turns, 2.0 * np.pi, _NEVER * (1.0 + np.abs(np.concatenate([asked, fitted])).max(axis=0)))
    within = [np.where(np.mod(v, period) < period, np.mod(v, period), 0.0) for v in (fitted, asked)]
    nearest, _ = cKDTree(within[0], boxsize=period).query(within[1])
    return float(np.median(nearest))
