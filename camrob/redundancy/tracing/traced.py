"""Tracing: postures along a path whose every pose is given whole, for arms with axes to spare; shortest in the joints, and clear.

The freedoms (a seventh axis, a lift, external axes) are laid out in a lattice at poses some way apart; with them given, closed
forms have all postures of the others (`freed_chain`). What passes a limit or has no room is no candidate, so that what comes
out keeps both by construction. The shortest way through is found by dynamic programming; then over all poses and a finer
lattice about it, again and again, each half as wide as the one before, with each joint's largest step held throughout.

Where no way is found, it is said what is known: at a pose without candidates how many freedoms' values were tried, and what
was in the way of the others; else between which poses the ways end.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.room import Room, rooms
from camrob.cell.cell import Cell
from camrob.errors import UnreachableError
from camrob.frozen import locked
from camrob.kinematics.freed_chain import FreedChain, freed_chains
from camrob.kinematics.screw_arm import OFFSET
from camrob.product_grid import product_grid
from camrob.redundancy.planning.dynamic_programming import Layers, cheapest_way
from camrob.redundancy.tracing.lattice import lattice_postures
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["Trace", "TraceSettings", "trace_poses"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class TraceSettings:
    """step_revolute, step_prismatic: the farthest that a joint may go from one pose to the next, rad and m. wanted: the room that
    is wanted, m; less has its price, and `least` is asked of each posture. lattice_revolute, lattice_prismatic: spacing of the
    freedoms' first lattice. apart: poses from one layer of the first search to the next. finest: rad, where refining ends.
    """

    step_revolute: float = deg_to_rad(7.0)
    step_prismatic: float = mm_to_m(20.0)
    wanted: float = mm_to_m(20.0)
    least: float = mm_to_m(1.0)
    lattice_revolute: float = 0.1
    lattice_prismatic: float = mm_to_m(50.0)
    apart: int = 4
    finest: float = 1e-4


@dataclass(frozen=True, slots=True)
class Trace:
    """q (T, n): postures; length_rad, length_m: all that the joints turn and slide; step_rad, step_m: their largest steps; room:
    the least distance of two bodies, up to what was wanted, m; given: names of the axes that the lattice is laid over.
    """

    q: Array
    length_rad: float
    length_m: float
    step_rad: float
    step_m: float
    room: float
    given: tuple[str, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "q", locked(self.q, shape=(None, None), name="q"))


@dataclass(frozen=True, slots=True)
class _Task:
    """What one search needs."""

    cell: Cell
    chain: FreedChain
    poses: Array
    room: Room | None
    settings: TraceSettings

    @property
    def steps(self) -> Array:
        """(n,) the farthest that each joint may go from pose to pose."""
        return np.where(self.chain.prismatic, self.settings.step_prismatic, self.settings.step_revolute)

    @property
    def spacing(self) -> Array:
        """(k,) of the first lattice."""
        slides = self.chain.prismatic[self.chain.given]
        return np.where(slides, self.settings.lattice_prismatic, self.settings.lattice_revolute)


_LENGTH_OF_SLIDE = 2.0  # rad that a metre of sliding counts for in the length that is made short
_EVEN = 0.5  # what a step at its limit costs beside its length, as a share of it: even steps are better than one leap
_CRAMPED = 0.2  # rad a pose: the price of having no room to spare
_HELD = 0.999  # of the largest step, so that rounding can't pass it
_TURNS = 4  # rows kept a candidate, for whole turns
_BRANCHES = 8
# neighbours of a freedom's value in a refining lattice, to each side: where one is given, and where more are
_SIDES = (5, 2)
_LOOSE = 1.2  # rad that a joint may go between neighbours of the draft: between its lattice's values there are others
_SOFTENED = 100.0  # times the lattice's spacing, what it may go while refining
_BAND = 1.2  # rad from the posture that is refined
_EASY, _HASTE = 0.9, 100.0  # share of the largest step beyond which a step has its price; of once more than that
_ROUNDS = ((1.0, 4), (0.5, 2), (0.2, 1), (0.05, 1))
"""Lattices that are tried one after another: their spacing's share of the first one's, and poses from one layer to the next. In
the last one each choice of given axes has its turn where one is given: by a singular posture one will do where another leaps.
"""


def trace_poses(
    cell: Cell, base_T_tool: Array, *, room: Room | None = None, settings: TraceSettings | None = None
) -> Trace:
    """Postures for poses (T, 4, 4) of the tool in `base`, in order.

    room: the bodies that may not touch (`cell_room`); None: nothing is in the way. Raises CellError for a chain without closed
    form, UnreachableError where the search finds no way, which says what it has tried.
    """
    poses = np.ascontiguousarray(base_T_tool, float)
    settings = settings or TraceSettings()
    chains = freed_chains(cell)
    error: UnreachableError | None = None
    for fine, apart in _ROUNDS:
        finer = replace(
            settings,
            lattice_revolute=fine * settings.lattice_revolute,
            lattice_prismatic=fine * settings.lattice_prismatic,
            apart=min(apart, settings.apart),
        )
        for chain in chains if fine == _ROUNDS[-1][0] and len(chains[0].given) == 1 else chains[:1]:
            task = _Task(cell, chain, poses, room, finer)
            try:
                return _as_trace(task, _refined(task, _draft(task)))
            except UnreachableError as failure:
                error = error if error is not None and "has no posture" in error.what else failure
    raise error or UnreachableError("no rounds were searched")


def _draft(task: _Task) -> Array:
    """Postures (T, n) along the path: searched over a lattice at poses `apart`, straight between them."""
    chain, settings = task.chain, task.settings
    T = len(task.poses)
    at = np.unique(np.append(np.arange(0, T, settings.apart), T - 1))
    axes = []
    for i, spacing in zip(chain.given, task.spacing, strict=True):
        if chain.endless[i]:
            axes.append(np.linspace(-np.pi, np.pi, int(np.ceil(2.0 * np.pi / spacing)), endpoint=False))
        else:
            span = chain.upper[i] - chain.lower[i]
            axes.append(np.linspace(chain.lower[i], chain.upper[i], int(np.ceil(span / spacing)) + 1))
    grid = product_grid(axes)
    lattice = _Lattice(at, np.tile(grid, (len(at), 1)), np.tile(chain.center, (len(at), 1)), np.inf, _LOOSE)
    q = _unwound(chain, _searched(task, lattice))
    return np.stack([np.interp(np.arange(T), at, column) for column in q.T], axis=1)


def _refined(task: _Task, q: Array) -> Array:
    """Postures (T, n): lattices about those of the draft, each half as wide as the one before; the last keep the steps."""
    chain, T = task.chain, len(task.poses)
    k = len(chain.given)
    sides = _SIDES[0] if k == 1 else _SIDES[1]
    offset = np.arange(-sides, sides + 1) / sides
    cube = product_grid([offset] * k)
    wide = 1.0
    while True:
        u = (q[:, None, chain.given] + cube * wide * task.spacing).reshape(-1, k)
        u = np.clip(u, chain.lower[chain.given], chain.upper[chain.given])
        width = wide * task.settings.lattice_revolute
        q = _unwound(chain, _searched(task, _Lattice(np.arange(T), u, q, _BAND, min(_LOOSE, _SOFTENED * width))))
        if k == 0 or width < task.settings.finest:
            return q
        wide *= 0.5


def _unwound(chain: FreedChain, q: Array) -> Array:
    """Postures with the turns of endless axes counted on."""
    for i in np.flatnonzero(chain.endless):
        q[:, i] = np.unwrap(q[:, i])
    return q


@dataclass(frozen=True, slots=True)
class _Lattice:
    """Values u (L G, k) of the freedoms at poses at (L,), G of each; near (L, n): about which angles are counted; band: rad,
    farther from there nothing is looked at; loose: rad, how far a joint may go between neighbours at the least, at its price.
    """

    at: Ints
    u: Array
    near: Array
    band: float
    loose: float


def _searched(task: _Task, lattice: _Lattice) -> Array:
    """Postures (L, n), the shortest way through the candidates of a lattice."""
    chain, settings, at = task.chain, task.settings, lattice.at
    L, tried = len(at), len(lattice.u) // len(at)
    start = tried * np.arange(L + 1)
    most = _BRANCHES * _TURNS * len(lattice.u)
    q, clear, count, lost = lattice_postures(
        chain,
        task.room,
        np.ascontiguousarray(task.poses[at]),
        start,
        np.ascontiguousarray(lattice.u),
        np.ascontiguousarray(lattice.near),
        lattice.band,
        settings.wanted,
        most,
    )
    keep = clear >= settings.least
    layer = np.repeat(np.arange(L), count)
    lost[:, 2] += np.bincount(layer[~keep], minlength=L)
    q, clear, layer = np.ascontiguousarray(q[keep]), clear[keep], layer[keep]
    count = np.bincount(layer, minlength=L)
    if np.any(count == 0):
        raise _nowhere(task, int(at[np.argmin(count)]), lost[np.argmin(count)], tried)
    rate = np.where(chain.prismatic, _LENGTH_OF_SLIDE, 1.0)
    poses = np.maximum(np.diff(at, prepend=at[0]), 1)
    steps = poses[:, None] * task.steps
    share = lattice.loose / settings.step_revolute
    way = cheapest_way(
        Layers(
            np.concatenate([[0], np.cumsum(count)]),
            q,
            _CRAMPED * (1.0 - clear / settings.wanted) ** 2 * poses[layer],
            np.maximum(_HELD * steps, share * task.steps),
            np.tile(rate, (L, 1)),
            _EVEN * rate / steps,
            _EASY * steps,
            np.full(L, _HASTE),
            np.asarray(chain.endless),
            np.full(L, np.inf),
        )
    )
    if way.reached < L:
        raise _torn(task, int(at[max(0, way.reached - 1)]), int(at[way.reached]), tried)
    return np.asarray(q[way.leave])


def _axes(task: _Task) -> str:
    return ", ".join(task.cell.names[i] for i in task.chain.given) or "none"


def _nowhere(task: _Task, point: int, lost: Array, tried: int) -> UnreachableError:
    """No candidate at a pose."""
    past, cramped = int(lost[1]), int(lost[2])
    searched = task.chain.family == OFFSET
    branches = f"{'those' if searched else 'all'} of closed form's branches{' that were found' if searched else ''}"
    what = f"pose {point} has no posture with {branches} at each of {tried} values of {_axes(task)}"
    if past + cramped:
        what += f": {past} pass a joint's limit, {cramped} have no room"
    hint = "clear the way for the arm" if cramped else "place the part elsewhere, or widen the limits"
    return UnreachableError(f"{what}; {hint}")


def _torn(task: _Task, before: int, after: int, tried: int) -> UnreachableError:
    """Candidates everywhere, but no way through."""
    what = (
        f"no posture of pose {after} can be come to from pose {before} within the joints' largest step "
        f"(searched over {tried} values of {_axes(task)} at each pose); allow larger steps, or give poses nearer to each other"
    )
    return UnreachableError(what)


def _as_trace(task: _Task, q: Array) -> Trace:
    """The trace of postures, turns without end counted on."""
    chain = task.chain
    step = np.abs(np.diff(q, axis=0))
    turns, slides = step[:, ~chain.prismatic], step[:, chain.prismatic]
    clear = task.settings.wanted
    if task.room is not None:
        clear = float(np.min(rooms(task.room, np.ascontiguousarray(q), task.settings.wanted)))
    return Trace(
        q=q,
        length_rad=float(turns.sum()),
        length_m=float(slides.sum()),
        step_rad=float(turns.max(initial=0.0)),
        step_m=float(slides.max(initial=0.0)),
        room=clear,
        given=tuple(task.cell.names[i] for i in chain.given),
    )
