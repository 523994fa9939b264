"""What a reader gathers its points, arcs and events in until a region is complete."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camrob.toolpath.region import Arc, Event, EventKind, Move, Region

__all__ = ["RegionBuilder", "clean_text"]


def clean_text(text: str) -> str:
    """Text from a file for a name: control characters out, runs of white space as one blank, nothing else touched."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


class RegionBuilder:
    """Points in the part's frame, in metres, one after the other; `finish` makes the region and empties the builder.

    Single points go in cheaply, and so do whole arrays. Events attach to the point that comes next.
    """

    __slots__ = ("_arcs", "_before", "_chunks", "_count", "_events", "_last", "_loose")

    def __init__(self) -> None:
        self._clear()

    def _clear(self) -> None:
        self._chunks: list[tuple[NDArray[np.float64], NDArray[np.int8], NDArray[np.int64]]] = []
        self._loose: tuple[list[float], list[int], list[int]] = ([], [], [])
        self._arcs: list[Arc] = []
        self._events: list[Event] = []
        self._count = 0
        self._last: tuple[float, ...] = ()
        self._before: tuple[float, ...] = ()  # the newest point but one

    def __len__(self) -> int:
        """Number of points so far."""
        return self._count

    @property
    def events(self) -> int:
        """Number of events so far."""
        return len(self._events)

    @property
    def last_move(self) -> Move | None:
        """How the tool came to the newest point, None where there is none yet."""
        return Move(int(self._last[6])) if self._count else None

    @property
    def last_way(self) -> NDArray[np.float64] | None:
        """From the newest point but one to the newest (3,), None where there are no two."""
        return np.array(self._last[:3]) - self._before[:3] if self._before else None

    @property
    def last_feed(self) -> float:
        """The feed (m/s) with which the tool came to the newest point, NaN for a rapid or where there is none yet."""
        return self._last[7] if self._count else math.nan

    def point(self, position: ArrayLike, axis: ArrayLike, feed: float, move: Move, line: int) -> None:
        """Add one point: `position` (3,) m, unit `axis` (3,), `feed` m/s (of no meaning for RAPID), source `line`."""
        x, y, z = map(float, position)  # type: ignore[arg-type, union-attr]
        i, j, k = map(float, axis)  # type: ignore[arg-type, union-attr]
        reals, moves, lines = self._loose
        reals.extend((x, y, z, i, j, k, math.nan if move == Move.RAPID else feed))
        moves.append(int(move))
        lines.append(line)
        self._before, self._last = self._last, (x, y, z, i, j, k, float(move), reals[-1])
        self._count += 1

    def points(self, position: ArrayLike, axis: ArrayLike, feed: ArrayLike, move: ArrayLike, line: ArrayLike) -> None:
        """Add many: `position` (N, 3); `axis` (N, 3) or (3,); `feed`, `move` and `line` (N,) or one for all."""
        xyz = np.asarray(position, dtype=np.float64)
        n = len(xyz)
        if n == 0:
            return
        self._flush()
        reals = np.empty((n, 7))
        reals[:, :3], reals[:, 3:6], reals[:, 6] = xyz, axis, feed
        moves = np.empty(n, dtype=np.int8)
        moves[:] = move
        lines = np.empty(n, dtype=np.int64)
        lines[:] = line
        reals[moves == Move.RAPID, 6] = math.nan
        self._chunks.append((reals, moves, lines))
        self._before = self._last if n == 1 else tuple(reals[-2, :3].tolist())
        self._last = (*reals[-1, :6].tolist(), float(moves[-1]), float(reals[-1, 6]))
        self._count += n

    def arc(
        self,
        points: ArrayLike,
        center: ArrayLike,
        arc_axis: ArrayLike,
        radius: float,
        angle: float,
        axis: ArrayLike,
        feed: float,
        line: int,
    ) -> None:
        """Add the points of a flat arc, as `sample_arc` gives them (its start is the newest point), and keep the arc.

        `arc_axis` is the right-handed axis of the motion, `axis` the tool's. The builder must hold the arc's start.
        """
        first = self._count - 1
        if first < 0:
            raise ValueError("an arc needs its start in the same region")
        self.points(points, axis, feed, Move.CUT, line)
        self._arcs.append(
            Arc(first, self._count - 1, np.asarray(center, np.float64), np.asarray(arc_axis, np.float64), radius, angle)
        )

    def event(self, kind: EventKind, value: float = 0.0, text: str = "", line: int = 0) -> None:
        """Add an event that happens before the move to the next point."""
        self._events.append(Event(self._count, kind, value, clean_text(text), line))

    def finish(self, name: str, *, tool: int = 0, operation: str = "", detached: bool = False) -> Region:
        """The region of all that was gathered; the builder is empty afterwards."""
        self._flush()
        reals = np.concatenate([c[0] for c in self._chunks]) if self._chunks else np.empty((0, 7))
        moves = np.concatenate([c[1] for c in self._chunks]) if self._chunks else np.empty(0, np.int8)
        lines = np.concatenate([c[2] for c in self._chunks]) if self._chunks else np.empty(0, np.int64)
        arcs, events = tuple(self._arcs), tuple(self._events)
        self._clear()
        return Region(
            name=clean_text(name),
            position=reals[:, :3],
            axis=reals[:, 3:6],
            feed=reals[:, 6],
            move=moves,
            line=lines,
            tool=tool,
            operation=clean_text(operation),
            arcs=arcs,
            events=events,
            detached=detached,
        )

    def _flush(self) -> None:
        """Turn the single points gathered so far into one chunk of arrays."""
        reals, moves, lines = self._loose
        if not moves:
            return
        self._chunks.append(
            (np.array(reals).reshape(-1, 7), np.array(moves, dtype=np.int8), np.array(lines, dtype=np.int64))
        )
        self._loose = ([], [], [])
