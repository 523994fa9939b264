"""What withheld samples should show before and after effects are taken away, predicted without their measured poses."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.gap.evidence.design import Panel
from camrob.gap.evidence.far_off import stays_far_off
from camrob.gap.evidence.model import Model, whole_gap
from camrob.gap.evidence.shrink import RANK, Trial, frame_columns, settled

__all__ = ["expected", "field_at", "foretold", "stays_where_fitted"]

Array = NDArray[np.float64]
Set = frozenset[int]

_FEWEST_BLOCKS = 4  # of fitted logs, that tell what stays where some are left out
_SOME = 300  # rows of a log that tell the variance well enough


def expected(
    model: Model, trial: Trial, keep: Set, *, far: bool = True, stays: float | None = None
) -> tuple[float, float]:
    """m (rms) on withheld samples before and after `keep` is taken away. far: what parts of the logs that a fit left out show of
    far postures counts too; a name is held to what its own fit says. stays: m2 that nothing takes, None for what stays where
    the logs were fitted.

    What `keep` moves the TCP by there, beside what else was found, the discrepancy at these postures as far as it is known, by
    how much these may be off (as the fit says, or as parts of the logs that it left out show, whichever is more), and what
    stays where it was fitted.
    """
    values, rest = model.values(keep, model.best), model.values(model.best.members - keep, model.best)
    before, after, spread, count = [], [], [], []
    for k, rows, _ in trial.asked:
        p = trial.panels[k]
        left = p.moves(rest, rows) + field_at(model, p, rows)
        before.append(settled(model, p, rows, left + p.moves(values, rows)))
        after.append(settled(model, p, rows, left))
        spread.append(_variance(model, p, trial.unfrozen[k], rows))
        count.append(int(rows.sum()))
    known = float(np.average(spread, weights=count))
    chance = max(known, stays_far_off(model, trial, keep) if far else 0.0)
    chance += stays_where_fitted(model) if stays is None else stays
    first, last = (float(np.sqrt(np.mean(np.sum(np.concatenate(x) ** 2, axis=1)) + chance)) for x in (before, after))
    return first, last


def foretold(model: Model, trial: Trial, blocks: Trial, keep: Set) -> tuple[float, float]:
    """m (rms) on withheld samples before and after `keep` is taken away, as the fitted logs show it on `blocks` of them that a
    fit leaves out, and farther off; where these are too few, as `expected`.

    What stays where it was fitted, with what the fit's covariance leaves open, is too little: values are off by more, as
    descriptions are, and what nothing describes was fitted there too. Of what `keep` moves the TCP by, the share of the energy
    that it takes on such blocks is taken on the withheld samples. Where blocks themselves are withheld in turn, what one is to
    show is read off another that the same fit leaves out too (nested, Varma and Simon, BMC Bioinformatics 7, 2006, 91).
    """
    if len(blocks.asked) < _FEWEST_BLOCKS:
        return expected(model, trial, keep)
    before, after = _left_out(model, blocks, keep, paired=not trial.named)
    here, there = (_moved(model, t, keep) for t in (blocks, trial))
    taken = (before - after) / max(here, 1e-30)
    stays = after + stays_far_off(model, trial, keep)
    return float(np.sqrt(max(stays + taken * there, 0.0))), float(np.sqrt(stays))


def _left_out(model: Model, blocks: Trial, keep: Set, *, paired: bool) -> tuple[float, float]:
    """m2 (mean square) on blocks of the fitted logs without and with `keep` taken away, as a fit without them has it; paired: two
    at a time.
    """
    count, half = len(blocks.asked), len(blocks.asked) // 2
    groups = [(i, (i + half) % count) for i in range(count - half)] if paired else [(i,) for i in range(count)]
    before, after, rows = 0.0, 0.0, 0
    for group in groups:
        parts = [blocks.asked[i] for i in group]
        fitted = model.fit(model.best.members | model.evidence.always, tuple(b for _, _, b in parts if b is not None))
        values = model.values(keep, fitted)
        for k, own, _ in parts:
            p = blocks.panels[k]
            gap = whole_gap(p)[own]
            before += float(np.sum(settled(model, p, own, gap) ** 2))
            after += float(np.sum(settled(model, p, own, gap - p.moves(values, own)) ** 2))
            rows += len(gap)
    return before / max(rows, 1), after / max(rows, 1)


def _moved(model: Model, trial: Trial, keep: Set) -> float:
    """m2 (mean square) by which `keep` moves the TCP on withheld samples, but for what frames fitted to these take up."""
    values = model.values(keep, model.best)
    moved = [settled(model, trial.panels[k], rows, trial.panels[k].moves(values, rows)) for k, rows, _ in trial.asked]
    return float(np.mean(np.sum(np.concatenate(moved) ** 2, axis=1)))


def stays_where_fitted(model: Model) -> float:
    """m2 (mean square) of the whole gap of the fitted logs that neither the best set nor the discrepancy takes, at the drives
    too, and never less than the noise. Where a log tells both ends of the drives, what its encoders scatter is in both stages,
    with opposite signs, and in no gap.
    """
    values, total, least, count = model.values(model.best.members, model.best), 0.0, 0.0, 0
    found = np.flatnonzero(np.isin(model.design.owner, list(model.best.members)))
    for p, noise in zip(model.panels, model.noises, strict=True):
        told = (p.w_tcp[:, 0] > 0.0) & ~p.unknown_rows(found)
        rest = whole_gap(p)[told] - p.moves(values, told) - field_at(model, p, told)
        encoders = 0.0 if p.servo is None else _carried_noise(p, noise.servo, told)
        total += float(np.sum(rest**2))
        least += len(rest) * max(noise.rms**2 - encoders, 0.0)
        count += len(rest)
    return max(total, least) / max(count, 1)


def _carried_noise(panel: Panel, sigma: Array, rows: NDArray[np.bool_]) -> float:
    """m2 (mean square) that the scatter of encoders, sigma (k,), moves the tool by at some rows."""
    count = int(rows.sum())
    alone = [panel.carried(np.tile(one, (count, 1)), rows) for one in np.diag(sigma)]
    return float(np.mean(np.sum(np.square(alone), axis=(0, 2)))) if count else 0.0


def field_at(model: Model, panel: Panel, rows: NDArray[np.bool_]) -> Array:
    """(M, 3) m the discrepancy at some rows of a log as it is expected there."""
    field, sizes = model.evidence.field, model.evidence.sizes
    if field is None or sizes is None or panel.smooth is None:
        return np.zeros((int(rows.sum()), 3))
    return np.asarray(panel.smooth[rows] @ field.fitted(model.best.mean, sizes)[:, :3])


def _variance(model: Model, panel: Panel, unfrozen: Panel, rows: NDArray[np.bool_]) -> float:
    """m2 in all three directions, the mean over some rows: how far what the best set and the discrepancy tell there may be off,
    but for what frames that are fitted to these rows take up of that.

    Where an effect is larger than fitted, the discrepancy beside it is smaller, where the logs were; elsewhere nothing makes up
    for either, and the discrepancy is as large as its prior.
    """
    own = np.flatnonzero(rows)
    own = own[np.linspace(0, len(own) - 1, min(len(own), _SOME)).astype(int)] if len(own) else own
    if len(own) == 0:
        return 0.0
    some = np.isin(np.arange(len(rows)), own)
    columns = np.flatnonzero(np.isin(model.design.owner, list(model.best.members)))
    X, parts = unfrozen.moved_by(columns, some), []
    field, sizes = model.evidence.field, model.evidence.sizes
    if field is not None and sizes is not None and panel.smooth is not None:
        F = panel.smooth[some]
        X = X - np.einsum("nm,mdc->ndc", F, field.response(sizes)[:, :, columns], optimize=True)
        for d, V in enumerate(field.scatter(F, sizes)):
            parts.append(_in_direction(V.T, d))
        if sizes[0, 0] > 0.0:
            half = sizes[0, 0] * _half(model.basis.beyond(panel.scene, own))
            parts += [_in_direction(half, d) for d in range(3)]
    parts.append(X @ _half(model.best.spread.block(columns)))
    E = np.concatenate(parts, axis=2).reshape(3 * len(own), -1)
    taken = _orthonormal(frame_columns(model, panel, some)).T @ E
    return float(np.sum(E**2) - np.sum(taken**2)) / len(own)


def _in_direction(half: Array, direction: int) -> Array:
    """(N, 3, k) of a root of a covariance (N, k) in one direction."""
    out = np.zeros((len(half), 3, half.shape[1]))
    out[:, direction] = half
    return out


def _half(covariance: Array) -> Array:
    """(N, N): a root H of a covariance, H H.T, without what rounding makes negative of it."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


def _orthonormal(X: Array) -> Array:
    """(N, r) orthonormal columns that span those of X."""
    if X.shape[1] == 0:
        return X
    U, s, _ = np.linalg.svd(X, full_matrices=False)
    return np.asarray(U[:, s > RANK * s[0]])
