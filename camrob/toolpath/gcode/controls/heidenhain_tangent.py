"""Heidenhain's CT: an arc that goes on from the contour element before it without a corner (TNC 640, Klartext, 6.4)."""

from __future__ import annotations

import math

from camrob.errors import ToolpathError

__all__ = ["Heading"]

_LEAST = 1e-6  # of a chord's length: a centre further off to the side makes a straight line


class Heading:
    """Which way the tool goes, in X and Y, where the last cut has ended."""

    def __init__(self) -> None:
        self._way: tuple[float, float] | None = None

    def lost(self) -> None:
        """Nobody knows."""
        self._way = None

    def straight(self, at: dict[str, float | None], to: dict[str, float], *, sure: bool) -> None:
        """A straight motion from `at`; sure: it is a cut that ends as it is written."""
        begun = (at["X"], at["Y"])
        self._way = None
        if not sure or begun[0] is None or begun[1] is None:
            return
        u, v = to.get("X", begun[0]) - begun[0], to.get("Y", begun[1]) - begun[1]
        if length := math.hypot(u, v):
            self._way = (u / length, v / length)

    def round(
        self, begin: tuple[float, float], end: tuple[float, float], words: dict[str, float], *, left: bool
    ) -> None:
        """An arc, anticlockwise where it goes to the left; words: I and J of its centre, else it isn't of this plane."""
        self._way = None
        if words.keys() != {"I", "J"}:
            return
        u, v = end[0] - begin[0] - words["I"], end[1] - begin[1] - words["J"]
        if length := math.hypot(u, v):
            self._way = (-v / length, u / length) if left else (v / length, -u / length)

    def arc(self, begin: tuple[float, float], end: tuple[float, float]) -> tuple[tuple[float, float], bool]:
        """CT: from the beginning to the centre, and whether it goes to the left.

        Raises ToolpathError where the element before isn't a cut whose end shows the direction, and where no arc leads there.
        """
        if self._way is None:
            raise ToolpathError(
                "CT behind something else than a cut whose direction is known (L, C, CP or CT)",
                hint="have the CAM system write the arc with its centre",
            )
        u, v = end[0] - begin[0], end[1] - begin[1]
        chord = math.hypot(u, v)
        aside = self._way[0] * v - self._way[1] * u  # how far the end lies to the left
        if not chord or abs(aside) < _LEAST * chord:
            raise ToolpathError("CT to a place straight ahead, or where it begins", hint="write L, or check the block")
        radius = 0.5 * chord * chord / aside
        return (-self._way[1] * radius, self._way[0] * radius), aside > 0.0
