"""What a drawn program has to do, noted down while it is written, as the story that a reading is held to."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.witness.happenings import Event, Kind, Path, Pecks, Stand, Story, Way

__all__ = ["Reckoned"]

Array = NDArray[np.float64]
_MM = 1e-3  # m
_NOWHERE = (math.nan,) * 6


class Reckoned:
    """Motions and events in their order. Tips in mm in the part, feeds in mm/min, angles in degrees."""

    def __init__(self) -> None:
        self._rows: list[tuple[float, ...]] = []
        self._events: list[Event] = []
        self._stands: list[Stand] = []
        self._pecks: dict[int, Pecks] = {}
        self._linked = False
        self._here: Array | None = None
        self.axis = np.array([0.0, 0.0, 1.0])

    @property
    def here(self) -> Array | None:
        """Where the tip is in the part, mm; None where nobody knows."""
        return None if self._here is None else self._here.copy()

    def lose(self) -> None:
        """To a place of the machine's own."""
        self._linked, self._here = False, None

    def event(self, kind: Kind, value: float = 0.0, text: str = "") -> None:
        """Something happens here."""
        self._events.append(Event(len(self._rows), kind, value, text))

    def rapid(self, tip: Sequence[float]) -> None:
        """In rapid, straight."""
        self._row(tip, Way.RAPID, math.nan)

    def cut(self, tip: Sequence[float], feed: float, axis: Sequence[float] | None = None) -> None:
        """A straight cut; axis: of the tool at its end."""
        if axis is not None:
            self.axis = np.array(axis, float) / float(np.linalg.norm(axis))
        self._row(tip, Way.FEED, feed)

    def arc(
        self, tip: Sequence[float], center: Sequence[float], normal: Sequence[float], turn: float, feed: float
    ) -> None:
        """A circle or helix about `normal`, right-handed for turn > 0."""
        sense = math.copysign(1.0, turn)
        around = (*np.array(center, float) * _MM, *np.array(normal, float) * sense, math.radians(abs(turn)))
        self._row(tip, Way.FEED, feed, around)

    def hole(self, tip: Sequence[float], feed: float, bite: float = 0.0, out: bool = True) -> None:
        """Down to the bottom, from where the tool is; bite: of pecks, 0 in one go."""
        if bite:
            self._pecks[len(self._rows)] = Pecks(bite * _MM, bite * _MM, out)
        self._row(tip, Way.HOLE, feed)

    def _row(
        self, tip: Sequence[float], way: Way, feed: float, around: tuple[float, ...] = (*_NOWHERE, math.nan)
    ) -> None:
        at = np.array(tip, float)
        if self._here is not None and float(np.abs(at - self._here).max()) < 1e-9 and math.isnan(around[-1]):
            last = self._rows[-1] if self._rows else None
            if last is None or float(np.abs(self.axis - np.array(last[3:6])).max()) < 1e-9:
                return
        self._rows.append((*at * _MM, *self.axis, *around, float(way), feed * _MM / 60.0, float(self._linked)))
        self._linked, self._here = True, at

    def story(self) -> Story:
        """All of it."""
        table = np.array(self._rows, float)
        n = len(table)
        return Story(
            path=Path(table[:, 0:3], table[:, 3:6], table[:, 6:9], table[:, 9:12], table[:, 12], np.arange(1, n + 1)),
            way=table[:, 13].astype(np.int8),
            feed=table[:, 14],
            joined=table[:, 15].astype(np.bool_),
            operation=np.zeros(n, np.int32),
            events=tuple(self._events),
            gaps=(),
            stands=tuple(self._stands),
            pecks=self._pecks,
        )
