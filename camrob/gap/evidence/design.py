"""The whitened regression that every question of the diagnosis is put to, and its Gram matrices block by block."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.evidence.discrepancy import FieldGram, SmoothBasis
from camrob.gap.evidence.neighbourhoods import neighbourhoods
from camrob.gap.nuisances import NUISANCE, first_nuisances, nuisance_columns, nuisance_units
from camrob.gap.observation.noise import Noise
from camrob.gap.observation.scene import Scene

__all__ = [
    "LEVER",
    "Design",
    "Panel",
    "Pooled",
    "Remembered",
    "Sums",
    "build_units",
    "make_panel",
    "pool",
    "sums_of",
]

Array = NDArray[np.float64]

_Key = tuple[int, Unit, tuple[tuple[str, float], ...]]

_ALL = slice(None)
_FEW = 12  # columns that are added one after the other
_SOME = 600  # samples of a log that tell well enough how far effects move the TCP
LEVER = 0.5  # m: what a turn counts as, where it hardly moves the TCP


@dataclass(frozen=True)
class Panel:
    """One log's rows. tcp: (N, 6, K) columns at the TCP, SI; servo: (N, k, K') of the columns `servo_columns`, or None.

    Columns lie apart in memory, as (K, 6, N) and (K', k, N): most questions are put to a few of them.

    y_tcp (N, 6), y_servo (N, k); w_tcp, w_servo their weights, 0 where not seen or an outlier. block: (N,) the block that a
    sample is withheld with. doubt: (N,) by column, see `Column`. smooth: (N, M) functions of the discrepancy, behind the
    encoders alone, or None.
    """

    scene: Scene
    tcp: Array
    y_tcp: Array
    w_tcp: Array
    servo: Array | None
    servo_columns: NDArray[np.int64]
    y_servo: Array | None
    w_servo: Array | None
    block: NDArray[np.int64]
    doubt: Mapping[int, Array] = field(default_factory=dict)
    smooth: Array | None = None

    @property
    def apart(self) -> Array:
        """(K, 6 N): the columns at the TCP as they lie in memory, a row of the twist after the other."""
        return np.asarray(self.tcp.transpose(2, 1, 0).reshape(self.tcp.shape[2], 6 * len(self.tcp)))

    def unknown_rows(self, columns: NDArray[np.int64]) -> NDArray[np.bool_]:
        """(N,) True where nothing is known of any of some columns: what they predict there says nothing for or against them."""
        out = np.zeros(len(self.scene), np.bool_)
        for k in columns.tolist():
            if k in self.doubt:
                out |= self.doubt[k] >= 1.0
        return out

    def doubted(self, columns: NDArray[np.int64], accuracy: float) -> Array:
        """(N, 1) by what share of itself the description of some columns may be wrong: by `accuracy`, here and there by more."""
        own: Array = np.full((len(self.scene), 1), accuracy)
        for k in columns.tolist():
            if k in self.doubt:
                own = np.maximum(own, self.doubt[k][:, None])
        return own

    def twists(self, values: Array, rows: NDArray[np.bool_] | slice = _ALL) -> Array:
        """(M, 6) twists at the TCP behind the encoders, that parameters (K,) cause at some rows."""
        return _product(self.tcp, values, rows)

    def errors(self, values: Array, rows: NDArray[np.bool_] | slice = _ALL) -> Array:
        """(M, k) errors of the drives that parameters (K,) cause at some rows, of a log that tells them."""
        if self.servo is None:
            raise ValueError("a log without set-points or encoders tells no drive's error")
        return _product(self.servo, values[self.servo_columns], rows)

    def moves(self, values: Array, rows: NDArray[np.bool_] | slice = _ALL) -> Array:
        """(M, 3) m that parameters (K,) move the TCP by at some rows, both stages together."""
        total = _product(self.tcp[:, :3], values, rows)
        if self.servo is not None and values[self.servo_columns].any():
            total = total + self.carried(self.errors(values, rows), rows)
        return np.asarray(total)

    def moved_by(self, columns: NDArray[np.int64], rows: NDArray[np.bool_] | slice = _ALL) -> Array:
        """(M, 3, C) m that a unit of each of some columns moves the TCP by at some rows, both stages together."""
        X = self.tcp[:, :3, columns][rows]
        if self.servo is not None:
            for j, k in enumerate(columns.tolist()):
                for own in np.flatnonzero(self.servo_columns == k).tolist():
                    X[:, :, j] += self.carried(self.servo[:, :, own][rows], rows)
        return X

    def carried(self, axis: Array, rows: NDArray[np.bool_] | slice = _ALL) -> Array:
        """(M, 3) m at the TCP of shifts (M, k) of the axes at some rows."""
        scene = self.scene
        total = np.zeros((len(axis), 3))
        for k, name in enumerate(scene.axes):
            if f"{name}.zero" in scene.places and axis[:, k].any():
                total += scene.place(f"{name}.zero")[rows, :3] * axis[:, k : k + 1]
        return total


def _product(X: Array, values: Array, rows: NDArray[np.bool_] | slice) -> Array:
    """(M, d) of columns X (N, d, K), which lie apart in memory, times values (K,), at some rows."""
    apart, used = X.transpose(2, 1, 0), np.flatnonzero(values)
    if apart.flags.c_contiguous and len(used) > _FEW:
        # without a copy of any column
        return np.asarray((values @ apart.reshape(len(apart), -1)).reshape(apart.shape[1:])[:, rows].T)
    out = np.zeros(apart.shape[1:])
    for k in used.tolist():
        out += values[k] * apart[k]
    return np.asarray(out[:, rows].T)


def _at(X: Array, rows: NDArray[np.int64]) -> Array:
    """(K, d, M): columns X (N, d, K), which lie apart in memory, at M ascending rows; no copy where these are a stretch."""
    apart = X.transpose(2, 1, 0)
    if len(rows) and rows[-1] - rows[0] + 1 == len(rows):
        return np.asarray(apart[:, :, rows[0] : rows[-1] + 1])
    return np.take(apart, rows, axis=2)


@dataclass(frozen=True)
class Design:
    """Units, and Gram matrices of all logs by block. A: (B, K, K), b: (B, K), yy and rows: (B,); owner: (K,) each column's unit.

    size: (K,) m that a unit of the parameter moves the TCP by (rms); usual: (K,) ordinary sizes; moves: (K, K) mean products
    of what units of two parameters move the TCP by, m2. field: the discrepancy's part of the Gram matrices, or None.
    """

    units: tuple[Unit, ...]
    owner: NDArray[np.int64]
    A: Array
    b: Array
    yy: Array
    rows: Array
    size: Array
    usual: Array
    moves: Array
    field: FieldGram | None = None

    @property
    def parameters(self) -> tuple[EffectParameter, ...]:
        """One a column."""
        return tuple(p for u in self.units for p in u.parameters)


def build_units(scenes: Sequence[Scene], effects: Sequence[Effect], states: Mapping[str, State]) -> tuple[Unit, ...]:
    """All units that these logs could show, nuisances first."""
    units = nuisance_units(scenes)
    for effect in effects:
        units += effect.units(scenes, states[effect.name])
    return tuple(units)


@dataclass(frozen=True)
class Remembered:
    """What columns of effects in their states, and functions of a discrepancy, were on some logs: most are asked for again.
    columns: asked for since the last turn, or (`before`) in the one before it.
    """

    columns: dict[_Key, tuple[Column, ...]] = field(default_factory=dict)
    before: dict[_Key, tuple[Column, ...]] = field(default_factory=dict)
    smooth: dict[int, Array] = field(default_factory=dict)

    def turn(self) -> None:
        """Forget what was not asked for since the last turn."""
        self.before.clear()
        self.before.update(self.columns)
        self.columns.clear()

    def of_unit(self, effect: Effect, scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
        """A unit's columns on a log that lives as long as this."""
        key = id(scene), unit, tuple(sorted(state.items()))
        if key not in self.columns:
            self.columns[key] = self.before[key] if key in self.before else effect.columns(scene, unit, state)
        return self.columns[key]

    def of_basis(self, basis: SmoothBasis, scene: Scene) -> Array:
        """The functions of the one basis on a log that lives as long as this."""
        if id(scene) not in self.smooth:
            self.smooth[id(scene)] = basis.columns(scene)
        return self.smooth[id(scene)]


def make_panel(
    scene: Scene,
    number: int,
    units: Sequence[Unit],
    effects: Sequence[Effect],
    states: Mapping[str, State],
    noise: Noise,
    kept: NDArray[np.bool_],
    blocks: int,
    first_block: int,
    basis: SmoothBasis | None = None,
    remembered: Remembered | None = None,
    wanted: frozenset[int] | None = None,
) -> Panel:
    """Columns and weights of one log. number: which of the fitted logs it is, or WITHHELD. kept: (N,) False for outliers; wanted:
    the units of which columns are asked for, all by default: others' are 0.
    """
    known = remembered or Remembered()
    by_name = {e.name: e for e in effects}
    first = first_nuisances(units)
    columns: list[Column] = []
    for i, unit in enumerate(units):
        if wanted is not None and i not in wanted:
            columns += (Column() for _ in unit.parameters)
        elif unit.effect == NUISANCE:
            columns += nuisance_columns(scene, unit, number, first)
        else:
            columns += known.of_unit(by_name[unit.effect], scene, unit, states[unit.effect])
    N, K = len(scene), len(columns)
    tcp = np.zeros((K, 6, N)).transpose(2, 1, 0)
    split = scene.servo_gap is not None
    of_drives = np.array([k for k, c in enumerate(columns) if c.servo], np.int64)
    servo = np.zeros((len(of_drives), len(scene.axes), N)).transpose(2, 1, 0) if split else None
    for k, column in enumerate(columns):
        if column.tcp is not None:
            tcp[:, :, k] = scene.told(column.tcp)
        for axis, signal in column.servo.items():
            if servo is not None:
                servo[:, scene.index(axis), int(np.searchsorted(of_drives, k))] = signal
            elif f"{axis}.zero" in scene.places:
                tcp[:, :, k] += scene.shift(axis, signal)
    w_tcp = np.where(scene.seen & kept[:, None], 1.0 / noise.tcp, 0.0)
    w_servo = None
    if split:
        w_servo = np.where(kept[:, None], 1.0 / noise.servo, 0.0)
    block = first_block + neighbourhoods(scene, blocks)
    doubt = {k: c.doubt for k, c in enumerate(columns) if c.doubt is not None}
    smooth = None if basis is None else known.of_basis(basis, scene)
    return Panel(scene, tcp, scene.tcp_gap, w_tcp, servo, of_drives, scene.servo_gap, w_servo, block, doubt, smooth)


def _field_sums(p: Panel, rows: NDArray[np.int64], weighed: Mapping[int, Array]) -> tuple[Array, Array, Array]:
    """C (6, K, M), D (6, M, M) and d (6, M) of some rows of a panel, as in `FieldGram`. weighed: (K, 3, m) columns, by the first
    of three rows of the twist of which any weighs.
    """
    smooth = np.zeros((len(rows), 0)) if p.smooth is None else p.smooth[rows]
    M, K = smooth.shape[1], p.tcp.shape[2]
    C, D, d = np.zeros((6, K, M)), np.zeros((6, M, M)), np.zeros((6, M))
    held: dict[bytes, tuple[Array, Array]] = {}  # rows of the twist often weigh alike
    for row in range(6) if M else ():
        w = p.w_tcp[rows, row]
        if w.any() and (row > 2 or p.scene.sees[row]):
            key = w.tobytes()
            if key not in held:
                F = smooth * w[:, None]
                held[key] = F, F.T @ F
            F, D[row] = held[key]
            C[row], d[row] = weighed[row - row % 3][:, row % 3] @ F, F.T @ (p.y_tcp[rows, row] * w)
    return C, D, d


class Sums(NamedTuple):
    """Of some rows of a panel, of shifts, turns and drives apart: A (3, K, K), b (3, K), the squared right-hand sides (3,); how
    many equations; smooth: see `FieldGram`.
    """

    A: Array
    b: Array
    yy: Array
    rows: float
    smooth: tuple[Array, Array, Array] | None


def sums_of(p: Panel, rows: NDArray[np.int64], *, smooth: bool) -> Sums:
    """Gram sums of some rows of a panel. smooth: those of the discrepancy, too."""
    K, columns = p.tcp.shape[2], _at(p.tcp, rows)
    A, b, yy, weighed = np.zeros((3, K, K)), np.zeros((3, K)), np.zeros(3), {}
    for k, first in enumerate((0, 3)):
        three = slice(first, first + 3)
        w = p.w_tcp[rows, three]
        if w.any():
            weighed[first] = columns[:, three] * w.T
            X, y = weighed[first].reshape(K, -1), (p.y_tcp[rows, three] * w).T.ravel()
            A[k], b[k], yy[k] = X @ X.T, X @ y, float(y @ y)
    count = float(np.count_nonzero(p.w_tcp[rows]) - (1.0 - p.scene.share) * np.count_nonzero(p.w_tcp[rows, :3]))
    if p.servo is not None and p.y_servo is not None and p.w_servo is not None:
        w = p.w_servo[rows]
        # of no columns, too: then numpy can't tell by itself how long they are
        S, s = (_at(p.servo, rows) * w.T).reshape(p.servo.shape[2], w.size), (p.y_servo[rows] * w).T.ravel()
        A[2][np.ix_(p.servo_columns, p.servo_columns)] = S @ S.T
        b[2, p.servo_columns], yy[2] = S @ s, float(s @ s)
        count += float(np.count_nonzero(w))
    return Sums(A, b, yy, count, _field_sums(p, rows, weighed) if smooth else None)


@dataclass(frozen=True)
class Pooled:
    """Gram matrices of all panels by block, of shifts, turns and drives apart: A (3, B, K, K), b (3, B, K), yy (3, B); the others
    as in `Design`.
    """

    units: tuple[Unit, ...]
    A: Array
    b: Array
    yy: Array
    rows: Array
    size: Array
    moves: Array
    field: FieldGram | None

    def design(self, turned: float = 1.0, servo: float = 1.0) -> Design:
        """The whole, with the weights of turns and of drives' errors lowered by factors."""
        factors = np.array([1.0, turned**2, servo**2])
        A, b, yy = (np.tensordot(factors, x, axes=1) for x in (self.A, self.b, self.yy))
        owner = np.array([i for i, u in enumerate(self.units) for _ in u.parameters], np.int64)
        usual = np.array([q.usual for u in self.units for q in u.parameters])
        field = None if self.field is None else self.field.turns_lowered(turned**2)
        return Design(self.units, owner, A, b, yy, self.rows, self.size, usual, self.moves, field)


def pool(panels: Sequence[Panel], units: Sequence[Unit], basis: SmoothBasis | None = None) -> Pooled:
    """Gram matrices of all panels, by block. basis: of the discrepancy, as in the panels."""
    K, B = sum(len(u.parameters) for u in units), max(int(p.block.max()) for p in panels) + 1
    A, b, yy, rows = np.zeros((3, B, K, K)), np.zeros((3, B, K)), np.zeros((3, B)), np.zeros(B)
    energy, count, moves, some = np.zeros(K), 0, np.zeros((K, K)), 0
    M = 0 if basis is None else len(basis.part)
    C, D, d = np.zeros((B, 6, K, M)), np.zeros((B, 6, M, M)), np.zeros((B, 6, M))
    for p in panels:
        for block in np.unique(p.block):
            sums = sums_of(p, np.flatnonzero(p.block == block), smooth=M > 0)
            A[:, block] += sums.A
            b[:, block] += sums.b
            yy[:, block] += sums.yy
            rows[block] += sums.rows
            if sums.smooth is not None:  # added: logs of the same postures share their blocks
                C[block], D[block], d[block] = (x[block] + y for x, y in zip((C, D, d), sums.smooth, strict=True))
        squares = np.einsum("krn,krn->rk", *[p.tcp.transpose(2, 1, 0)] * 2)
        energy += np.maximum(squares[:3].sum(axis=0), LEVER**2 * squares[3:].sum(axis=0))
        if p.servo is not None:
            for j, k in enumerate(p.servo_columns):
                energy[k] += float(np.sum(p.carried(p.servo[:, :, j]) ** 2))
        count += len(p.scene)
        X = p.moved_by(np.arange(K), slice(None, None, max(1, len(p.scene) // _SOME)))
        apart = X.transpose(2, 1, 0).reshape(K, -1)
        moves += apart @ apart.T
        some += X.shape[0]
    gram = None if basis is None else FieldGram(C, D, d, basis.part)
    return Pooled(tuple(units), A, b, yy, rows, np.sqrt(energy / count), moves / some, gram)
