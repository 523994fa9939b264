"""Points in space coloured by a value, as page data (cloud.js draws them) and their place in the page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.report.page.html import escape, number
from camrob.report.page.pack import packed_floats, packed_integers

__all__ = ["Cloud"]

Array = NDArray[np.float64]

_PLACE = 0.01  # mm: what places are rounded to


@dataclass(frozen=True, slots=True)
class Cloud:
    """One picture.

    title: text, what it is called to those who don't see it. points: (N, 3) mm; values: (N,) mm, coloured from low to high by
    scale: (share, "#rrggbb"), rising from 0 to 1. label: what a value is. eye: the direction (3,) that it is first looked
    from. line: (N,) the program's line, 0 where none; source: (N,) which of sources a point is from.
    """

    id: str
    title: str
    points: Array
    values: Array
    low: float
    high: float
    scale: Sequence[tuple[float, str]]
    label: str
    eye: tuple[float, float, float]
    line: NDArray[np.int64] | None = None
    source: NDArray[np.int64] | None = None
    sources: Sequence[str] = ()
    height: int = 560

    def data(self) -> dict[str, Any]:
        """What cloud.js reads."""
        return {
            "id": self.id,
            "points": packed_floats(self.points, _PLACE),
            "values": packed_floats(self.values),
            "low": self.low,
            "high": self.high,
            "scale": [list(stop) for stop in self.scale],
            "label": self.label,
            "eye": list(self.eye),
            "line": None if self.line is None else packed_integers(self.line),
            "source": None if self.source is None else packed_integers(self.source),
            "sources": list(self.sources),
        }

    def html(self) -> str:
        """Its place, and the scale of its colours."""
        colors = ", ".join(f"{color} {100 * at:g}%" for at, color in self.scale)
        return (
            f'<div class="cloud" id="{escape(self.id)}" role="figure" aria-label="picture: {escape(self.title)}" '
            f'style="height:{self.height}px"></div><p class="scalebar">{escape(self.label)} {number(self.low, 3, "mm")}'
            f'<i style="background:linear-gradient(to right, {colors})"></i>{number(self.high, 3, "mm")}</p>'
        )
