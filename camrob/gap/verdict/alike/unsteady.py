"""Names held to what they are described as: alike at all times and in all places. Where most of what stays beside a claim is
its own pattern, that grows with the time or with an axis, it is not what its description says, or not at work.

A spindle that grows as it warms up is a tool that is bent by its mean; the rest of it is the same shift once more, less before
and more after. What an arm leaves beside a true cause has another pattern.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.effect import Effect
from camrob.gap.evidence.design import Panel
from camrob.gap.evidence.model import Model, members_of, some_rows

__all__ = ["TIME", "unsteady"]

Array = NDArray[np.float64]

TIME = "time"
"""What a pattern may grow with beside the axes."""
_DEGREE = 4  # of polynomials that a pattern is multiplied by
_ROWS = 250  # of a log that tell it
_OF_REST = 0.5  # of the energy beyond the noise that stays, which a name's own pattern with another course has to show
_OF_NAME = 0.05  # of a name's energy, that this has to be at the least: what is constant but for a fifth is
_GAIN = 40.0  # squares, a unit of temperature, from which another course is shown
_BEYOND = 0.5  # times the noise's energy, that has to stay beyond it
_STILL, _RANK = 1e-3, 1e-9  # rad or m: an axis that does not move; of the largest singular value


def unsteady(
    model: Model, library: Sequence[Effect], claimed: Collection[str], drives: Collection[str]
) -> dict[str, str]:
    """Claimed effects that are constant by their description, and the time or the axis with which they change, where that
    change is most of what stays. drives: effects that work between set-point and encoder alone, where logs tell both ends.
    """
    found: dict[str, str] = {}
    rest: dict[bool, _Rest] = {}
    for effect in library:
        if effect.name not in claimed or TIME in effect.regimes or effect.name not in _inside(model):
            continue
        at_drives = effect.name in drives
        if at_drives not in rest:
            rest[at_drives] = _Rest(model, at_drives=at_drives)
        grows_with = rest[at_drives].course_of(effect.name)
        if grows_with:
            found[effect.name] = grows_with
    return found


def _inside(model: Model) -> frozenset[str]:
    return model.evidence.effects_of(model.best.members)


class _Rest:
    """What stays of some rows of the fitted logs beside the best set, weighed, behind the encoders or at the drives."""

    def __init__(self, model: Model, *, at_drives: bool) -> None:
        self.model, self.at_drives = model, at_drives
        self.rows = [some_rows(p, _ROWS) for p in model.panels]
        fitted = np.flatnonzero(np.isin(model.design.owner, sorted(model.best.members)))
        self.ways = _span(np.concatenate([self._columns(p, r, fitted) for p, r in self._panels()]))
        gap = np.concatenate([self._gap(p, r) for p, r in self._panels()])
        self.left = self._beside(gap)
        told = int(np.count_nonzero(gap)) - self.ways.shape[1]
        self.beyond = float(self.left @ self.left) - told
        self.enough = self.beyond > _BEYOND * max(told, 1)
        self.thinned = sum(len(p.scene) for p in model.panels) / max(sum(len(r) for r in self.rows), 1)

    def course_of(self, name: str) -> str:
        """What the name's pattern grows with, "" where that is not most of what stays."""
        if not self.enough:
            return ""
        values = self.model.values(members_of(self.model, name), self.model.best)
        moved = [self._moved(p, r, values) for p, r in self._panels()]
        energy = float(sum(np.sum(m**2) for m in moved))
        least = max(_OF_REST * self.beyond, _OF_NAME * energy, _GAIN * self.model.evidence.temperature / self.thinned)
        best, most = "", least
        for quantity, course in self._courses():
            grown = [m[:, :, None] * P[:, None, 1:] for m, P in zip(moved, course, strict=True)]
            X = self._beside(np.concatenate([g.reshape(-1, _DEGREE) for g in grown]))
            gain = float(np.sum((_span(X).T @ self.left) ** 2))
            if gain > most:
                best, most = quantity, gain
        return best

    def _panels(self) -> Iterator[tuple[Panel, NDArray[np.int64]]]:
        return zip(self.model.panels, self.rows, strict=True)

    def _beside(self, x: Array) -> Array:
        """What the best set doesn't show of x (M,) or (M, d)."""
        return np.asarray(x - self.ways @ (self.ways.T @ x))

    def _courses(self) -> Iterator[tuple[str, list[Array]]]:
        """Quantities, and by log (N, _DEGREE + 1) polynomials of each."""
        scenes = self.model.scenes
        told = {TIME: [s.t[r] for s, r in zip(scenes, self.rows, strict=True)]}
        told |= {a: [s.link[r, s.index(a)] for s, r in zip(scenes, self.rows, strict=True)] for a in scenes[0].axes}
        for quantity, values in told.items():
            low, high = (float(f(np.concatenate(values))) for f in (np.min, np.max))
            if high - low > _STILL:
                at = [2.0 * (v - low) / (high - low) - 1.0 for v in values]
                yield quantity, [np.asarray(np.polynomial.legendre.legvander(x, _DEGREE), np.float64) for x in at]

    def _weights(self, p: Panel, rows: NDArray[np.int64]) -> Array:
        if not self.at_drives:
            return p.w_tcp[rows, :3]
        return np.zeros((len(rows), len(p.scene.axes))) if p.w_servo is None else p.w_servo[rows]

    def _gap(self, p: Panel, rows: NDArray[np.int64]) -> Array:
        gap = p.y_servo if self.at_drives else p.y_tcp[:, :3]
        return np.zeros(0) if gap is None else np.nan_to_num(gap[rows] * self._weights(p, rows)).ravel()

    def _moved(self, p: Panel, rows: NDArray[np.int64], values: Array) -> Array:
        moved = p.errors(values) if self.at_drives else p.twists(values)[:, :3]
        return np.nan_to_num(moved[rows] * self._weights(p, rows))

    def _columns(self, p: Panel, rows: NDArray[np.int64], fitted: NDArray[np.int64]) -> Array:
        X = np.zeros((len(rows), self._weights(p, rows).shape[1], len(fitted)))
        if not self.at_drives:
            X = p.tcp[rows][:, :3, fitted]
        elif p.servo is not None:
            mine = np.searchsorted(p.servo_columns, fitted)
            told = np.isin(fitted, p.servo_columns)
            X[:, :, told] = p.servo[rows][:, :, mine[told]]
        return np.nan_to_num(X * self._weights(p, rows)[..., None]).reshape(-1, len(fitted))


def _span(X: Array) -> Array:
    """(M, r) orthonormal combinations of columns (M, d)."""
    sizes = np.linalg.norm(X, axis=0)
    if not sizes.any():
        return np.zeros((len(X), 0))
    U, singular, _ = np.linalg.svd(X[:, sizes > 0.0] / sizes[sizes > 0.0], full_matrices=False)
    return np.asarray(U[:, singular > _RANK * singular[0]])
