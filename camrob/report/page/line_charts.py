"""Plain charts of curves over one length, for reports without a program."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.report.page.html import plot_text
from camrob.report.page.parts import chart_box

__all__ = ["Curve", "LineChart", "chart_data", "chart_pair", "chart_section"]

Array = NDArray[np.float64]

_POINTS = 1500  # as many as a screen is wide, as least and greatest of each stretch
_HEIGHT = 380  # pixels
_COLORS = ("#2b7de9", "#e08a1e", "#1a9c6b", "#d1495b", "#8a63d2", "#6b7785", "#b5651d", "#0aa3a3")


class Curve(NamedTuple):
    """One curve: name, x, y; dash as Plotly names it; color as an index, -1 for the next; shown: else only in the legend."""

    name: str
    x: Array
    y: Array
    dash: str = "solid"
    color: int = -1
    shown: bool = True


class LineChart(NamedTuple):
    """A chart: its id, title (HTML), caption (HTML), titles of its axes, curves; whether y is logarithmic; whether x counts."""

    id: str
    title: str
    caption: str
    x_title: str
    y_title: str
    curves: tuple[Curve, ...]
    logarithmic: bool = False
    counted: bool = False


def chart_data(charts: Sequence[LineChart]) -> list[dict[str, Any]]:
    """The charts as the page's script reads them."""
    return [_data(chart) for chart in charts]


def chart_section(chart: LineChart, height: int = _HEIGHT) -> str:
    """The chart's place in the page, as high as it is drawn, pixels."""
    return (
        f"<section><h2>{chart.title}</h2>{chart_box(chart.id, chart.title, height)}"
        f'<p class="caption">{chart.caption}</p></section>'
    )


def chart_pair(charts: Sequence[LineChart]) -> str:
    """Charts side by side, below each other where there is no room."""
    parts = "".join(f"<div><h3>{c.title}</h3>{chart_box(c.id, c.title, _HEIGHT)}</div>" for c in charts)
    return f'<div class="pair wide">{parts}</div>'


def _data(chart: LineChart) -> dict[str, Any]:
    traces = []
    for k, curve in enumerate(chart.curves):
        x, y = _thinned(np.asarray(curve.x, float), np.asarray(curve.y, float))
        color = _COLORS[(k if curve.color < 0 else curve.color) % len(_COLORS)]
        traces.append(
            {
                "type": "scatter",
                "mode": "lines+markers" if chart.counted else "lines",  # one count alone is no line
                "name": plot_text(curve.name),
                "x": _short(x),
                "y": _short(y),
                "line": {"width": 1.6, "dash": curve.dash, "color": color},
                "visible": curve.shown or "legendonly",
            }
        )
    layout = {
        "height": _HEIGHT,
        "margin": {"l": 64, "r": 16, "t": 34, "b": 80},
        "shapes": [],
        "hovermode": "x unified",
        "xaxis": {
            "title": {"text": plot_text(chart.x_title)},
            "tickformat": ",~f",
            **({"dtick": 1} if chart.counted else {}),
        },
        "yaxis": {"title": {"text": plot_text(chart.y_title)}, "type": "log" if chart.logarithmic else "linear"},
        "legend": {"orientation": "h", "y": -0.2, "yanchor": "top"},  # above lie the buttons
    }
    return {"id": chart.id, "traces": traces, "layout": layout}


def _thinned(x: Array, y: Array) -> tuple[Array, Array]:
    """No more points than a screen shows: of each bucket its least and greatest, so that no peak is lost."""
    if len(x) <= _POINTS:
        return x, y
    edges = np.linspace(0, len(x), _POINTS // 2 + 1).astype(int)
    keep = set()
    for a, b in pairwise(edges):
        keep |= {int(a + np.argmin(y[a:b])), int(a + np.argmax(y[a:b]))}
    kept = np.array(sorted(keep | {0, len(x) - 1}))
    return x[kept], y[kept]


def _short(values: Array) -> list[float]:
    return [float(f"{v:.5g}") for v in values]
