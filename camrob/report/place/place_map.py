"""A picture of what placements of a part are worth: a map over X and Y for each height, as SVG."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

__all__ = ["place_map"]

Array = NDArray[np.float64]

_DRAWN = 1.6  # times its own pixels, so that it fills a page's width with three heights beside each other
_CELL = 26.0  # pixels: room for a number of two decimals
_LEFT, _TOP, _GAP = 64.0, 54.0, 40.0  # pixels: margins for labels, and between two panels
_WIDTH = 560.0  # that the words below need
_SHADES = 10  # of the scale beside the words
_STOPS = ("#440154", "#3b528b", "#21918c", "#5ec962", "#fde725")
"""From the least to the most: told apart by everyone, in print too. Red stands for a bad posture on other pages, and the least
of a search need be none.
"""


def place_map(title: str, xyz_mm: Array, value: Array, best: int, here: int, refused: Sequence[str]) -> str:
    """SVG of placements xyz_mm (P, 3) coloured by `value` (P,), 0 for out of reach; one panel a height.

    refused: (P) why a placement can't be had, "" where nothing is known against it: these are hatched. The proposal is ringed,
    the present one crossed; every cell says its numbers and the reason when pointed at.
    """
    grid = np.round(xyz_mm, 3)
    xs, ys, zs = (np.unique(grid[:, k]) for k in range(3))
    reached = value[value > 0.0]
    low, high = (float(reached.min()), float(reached.max())) if len(reached) else (0.0, 1.0)
    panel = len(xs) * _CELL + _GAP
    width = max(_LEFT + panel * len(zs), _WIDTH)
    tally = Counter(why for why in refused if why).most_common()
    height = _TOP + len(ys) * _CELL + 76.0 + 16.0 * len(tally)
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_DRAWN * width:.0f}" viewBox="0 0 {width:.0f} {height:.0f}" '
        f'style="max-width:100%;height:auto" font-family="sans-serif" font-size="11" role="img" aria-label="{escape(title)}: '
        'what each placement is worth, over X and Y">',
        f'<rect class="ground" width="100%" height="100%" fill="#fff"/>'
        f'<g fill="currentColor"><text x="10" y="20" font-size="14">{escape(title)}</text>',  # in a page, of its colours
    ]
    for k, z in enumerate(zs):
        left = _LEFT + k * panel
        out.append(f'<text x="{left:.1f}" y="{_TOP - 10:.1f}">Z {z:g} mm</text>')
        for i, x in enumerate(xs):
            out.append(_label(left + (i + 0.5) * _CELL, _TOP + len(ys) * _CELL + 16.0, f"{x:g}", "middle"))
        for p in np.flatnonzero(grid[:, 2] == z):
            i, j = int(np.searchsorted(xs, grid[p, 0])), len(ys) - 1 - int(np.searchsorted(ys, grid[p, 1]))
            out += _cell(left + i * _CELL, _TOP + j * _CELL, grid[p], float(value[p]), low, high, refused[int(p)])
            out += _marks(left + i * _CELL, _TOP + j * _CELL, p == best, p == here)
    for j, y in enumerate(ys[::-1]):
        out.append(_label(_LEFT - 6.0, _TOP + (j + 0.65) * _CELL, f"{y:g}", "end"))
    below = _TOP + len(ys) * _CELL + 40.0
    out += _scale(10.0, below, low, high)
    marks = "X across, Y up, mm in base. Ring: proposal, cross: now, grey: out of reach, hatched: refused"
    out.append(_label(10.0, below + 16.0, marks, "start"))
    for k, (reason, count) in enumerate(tally):
        out.append(_label(10.0, below + 16.0 * (k + 2), f"{count} refused: {reason}", "start"))
    return "\n".join([*out, "</g></svg>", ""])


def _label(x: float, y: float, text: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(text)}</text>'


def _scale(x: float, y: float, low: float, high: float) -> Sequence[str]:
    """What the colours say: a bar from the least to the most that a placement is worth."""
    side = 12.0
    bars = [
        f'<rect x="{x + 36.0 + k * side:.1f}" y="{y - 10.0:.1f}" width="{side:.1f}" height="{side:.1f}" '
        f'fill="{_color(k / (_SHADES - 1))}"/>'
        for k in range(_SHADES)
    ]
    right = x + 40.0 + _SHADES * side
    return [
        _label(x, y, f"{low:.3f}", "start"),
        *bars,
        _label(right, y, f"{high:.3f}: mean and lowest 1/k_F that the arm can have there, added up", "start"),
    ]


def _color(share: float) -> str:
    """The colour at a share of the way through _STOPS."""
    at = min(max(share, 0.0), 1.0) * (len(_STOPS) - 1)
    k = min(int(at), len(_STOPS) - 2)
    low, high = (np.array([int(stop[i : i + 2], 16) for i in (1, 3, 5)]) for stop in _STOPS[k : k + 2])
    return "#" + "".join(f"{round(v):02x}" for v in (low + (at - k) * (high - low)).tolist())


def _cell(x: float, y: float, place: Array, value: float, low: float, high: float, refused: str) -> Sequence[str]:
    """One placement."""
    share = (value - low) / max(high - low, 1e-9)
    color = "#ddd" if value <= 0.0 else _color(share)
    said = "out of reach" if value <= 0.0 else f"{value:.4f}" + (f"; refused: {refused}" if refused else "")
    hint = f"<title>{escape(f'X {place[0]:g} Y {place[1]:g} Z {place[2]:g}: {said}')}</title>"
    side = _CELL - 1.0
    out = [f'<rect x="{x:.1f}" y="{y:.1f}" width="{side:.1f}" height="{side:.1f}" fill="{color}">{hint}</rect>']
    if refused and value > 0.0:
        lines = "".join(
            f"M{x + max(0.0, c - side):.1f} {y + min(c, side):.1f}L{x + min(c, side):.1f} {y + max(0.0, c - side):.1f}"
            for c in np.arange(0.25, 2.0, 0.25) * side
        )
        strokes = "".join(
            f'<path d="{lines}" stroke="{c}" stroke-width="{w}"/>' for c, w in (("#fff", 3), ("#000", 1))
        )  # seen on light and dark
        out.append(f'<g class="refused">{strokes}{hint}</g>')
    return out


def _marks(x: float, y: float, best: bool, here: bool) -> Sequence[str]:
    """The ring and the cross."""
    center = 0.5 * (_CELL - 1)
    out = []
    if best:
        out += [
            f'<circle cx="{x + center:.1f}" cy="{y + center:.1f}" r="8" fill="none" stroke="{color}" stroke-width="{width}"/>'
            for color, width in (("#fff", 4), ("#000", 2))
        ]
    if here:
        a, b = x + center - 5.0, y + center - 5.0
        out += [
            f'<path d="M{a:.1f} {b:.1f}l10 10m0 -10l-10 10" stroke="{color}" stroke-width="{width}"/>'
            for color, width in (("#fff", 4), ("#000", 2))  # seen on light and dark
        ]
    return out
