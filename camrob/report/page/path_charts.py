"""Charts along the path: 1/k_F, axis values against their limits, external axes, feed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.solution import Solution
from camrob.report.page.html import plot_text
from camrob.report.page.pack import packed_floats, packed_integers
from camrob.report.page.thinning import curve_indices
from camrob.units import m_s_to_mm_min, m_to_mm

__all__ = [
    "Along",
    "Chart",
    "axis_chart",
    "axis_limits",
    "conditioning_chart",
    "external_chart",
    "feed_chart",
    "shown_charts",
]

Array = NDArray[np.float64]
Chart = dict[str, Any]

_WAY = 0.05  # mm: what the way is rounded to
POINTS = 4000
"""The most points of a curve."""

_MAIN, _BOUND, _LIMIT = "#2f7fd1", "#2f9e77", "#d64545"
_OTHERS = ("#e08a1e", "#8a63d2", "#8a93a0", "#b5651d")
_TINTS = ("rgba(47,127,209,0.09)", "rgba(224,138,30,0.09)")
_MOST_BANDS = 60  # narrower ones are no longer seen
_MOST_BAND_NAMES = 12  # more names lie upon each other
_MOST_MARKS = 200  # more marks are a wall
_ALIKE = 5e-4  # of 1/k_F: curves that near are one line


@dataclass(frozen=True, slots=True)
class Along:
    """What every chart shares: the way along the path in mm (N,), CL line (N,), region (N,), the regions' names, and which
    points are the CL file's own (N,).
    """

    s_mm: Array
    line: NDArray[np.int64]
    region: NDArray[np.int32]
    names: Mapping[int, str]
    own: NDArray[np.bool_]

    @classmethod
    def of(cls, path: ToolPathInBase, names: Mapping[int, str]) -> Along:
        """The shared part of a path's charts."""
        return cls(m_to_mm(path.length), path.line, path.region, names, path.of_toolpath)

    def at(self, points: NDArray[np.int64]) -> Along:
        """The same at some of the points."""
        return Along(self.s_mm[points], self.line[points], self.region[points], self.names, self.own[points])

    def runs(self) -> list[tuple[int, int, int]]:
        """Runs of points of one region, travel between regions left out: (region, first, last)."""
        if not len(self.region):
            return []
        cuts = np.flatnonzero(np.diff(self.region)) + 1
        first = np.concatenate([[0], cuts])
        last = np.concatenate([cuts - 1, [len(self.region) - 1]])
        return [(int(self.region[a]), int(a), int(b)) for a, b in zip(first, last, strict=True) if self.region[a] >= 0]

    @property
    def banded(self) -> bool:
        """True where the regions are few enough to be tinted."""
        return len(self.runs()) <= _MOST_BANDS

    def curve(self, y: Array, name: str, *, template: str, color: str, axes: str = "", **more: Any) -> Chart:
        """A line of the chart, thinned to `POINTS`; `axes` is the number of its subplot, '' for the first."""
        picked = curve_indices(y, POINTS)
        line = {"color": color, "width": 1.6, **more.pop("line", {})}
        return {
            "type": "scatter",
            "mode": "lines" if len(picked) > 1 else "markers",
            "name": name,
            "x": packed_floats(self.s_mm[picked], _WAY),
            "y": packed_floats(y[picked]),
            "xaxis": f"x{axes}",
            "yaxis": f"y{axes}",
            "line": line,
            "marker": {"color": color, "size": 7},
            "connectgaps": False,
            "hovertemplate": template,
            "cl": {"line": packed_integers(self.line[picked]), "region": packed_integers(self.region[picked])},
            **more,
        }

    def bands(self, subplots: Sequence[str]) -> list[Chart]:
        """Tinted stretches of x where a region lies, in every subplot; none where there are too many to tell apart."""
        if not self.banded:
            return []
        return [
            {
                "type": "rect",
                "xref": f"x{axes}",
                "yref": f"y{axes} domain",
                "x0": float(self.s_mm[first]),
                "x1": float(self.s_mm[last]),
                "y0": 0,
                "y1": 1,
                "line": {"width": 0},
                "fillcolor": _TINTS[region % 2],
                "layer": "below",
            }
            for axes in subplots
            for region, first, last in self.runs()
        ]

    def band_names(self) -> list[Chart]:
        """Names of the regions above the first subplot, where they are few."""
        runs = self.runs()
        if len(runs) > _MOST_BAND_NAMES:
            return []
        return [
            {
                "x": float(0.5 * (self.s_mm[first] + self.s_mm[last])),
                "xref": "x",
                "y": 1,
                "yref": "y domain",
                "yanchor": "bottom",
                "text": plot_text(_short(self.names.get(region, f"region {region}"))),
                "showarrow": False,
                "font": {"size": 11},
            }
            for region, first, last in runs
        ]


def shown_charts(*candidates: tuple[str, str, Chart | None, str]) -> list[Chart]:
    """Those that have something to show, of charts with an id, a title and a caption (HTML) each: (id, title, chart, caption)."""
    return [
        {"id": name, "title": title, "caption": caption, **chart} for name, title, chart, caption in candidates if chart
    ]


def _short(name: str, most: int = 22) -> str:
    return name if len(name) <= most else name[: most - 1] + "…"


def _x_axis(along: Along, title: bool = True, **more: Any) -> Chart:
    end = float(along.s_mm[-1]) if len(along.s_mm) else 0.0
    axis = {"range": [0.0, end or 1.0], "hoverformat": ",.1f", "tickformat": ",~f", "zeroline": False, **more}
    if title:
        axis["title"] = {"text": "path length of the tool tip [mm]", "standoff": 6}
    return axis


def _level(y: float, axes: str, color: str, dash: str) -> Chart:
    """A horizontal line through a whole subplot."""
    return {
        "type": "line",
        "xref": f"x{axes} domain",
        "yref": f"y{axes}",
        "x0": 0,
        "x1": 1,
        "y0": y,
        "y1": y,
        "line": {"color": color, "width": 1.2, "dash": dash},
    }


def conditioning_chart(
    along: Along, solution: Solution, *, threshold: float, comparison: Mapping[str, Array], bound: Array | None
) -> Chart:
    """1/k_F along the path with its threshold, other solutions to compare with, and the bound where one is known."""
    hover = "%{y:.3f}"
    alike = [name for name, kf in comparison.items() if np.allclose(kf, solution.inv_kf, rtol=0.0, atol=_ALIKE)]
    others = enumerate((name, kf) for name, kf in comparison.items() if name not in alike)
    traces = [
        along.curve(
            kf, plot_text(name), template=hover, color=_OTHERS[k % len(_OTHERS)], line={"width": 1.2, "dash": "dot"}
        )
        for k, (name, kf) in others
    ]
    if bound is not None:
        name = "upper bound (best posture at each point)"
        traces.append(along.curve(bound, name, template=hover, color=_BOUND, line={"width": 1.2, "dash": "dash"}))
    name = "this program" + "".join(
        f"; the same {plot_text(other)}" for other in alike
    )  # a line beneath it is not seen
    traces.append(along.curve(solution.inv_kf, name, template=f"{hover} · %{{text}}", color=_MAIN, line={"width": 2.2}))
    revised = [r for r in solution.revisions if r.kept][:_MOST_MARKS]
    if revised:
        points = np.array([r.point for r in revised])
        traces.append(
            {
                "type": "scatter",
                "mode": "markers",
                "name": "posture revised (table, then track)",
                "x": packed_floats(along.s_mm[points], _WAY),
                "y": packed_floats(solution.inv_kf[points]),
                "marker": {
                    "symbol": "triangle-up",
                    "size": 11,
                    "color": _OTHERS[0],
                    "line": {"width": 1, "color": "#fff"},
                },
                "hovertemplate": "posture revised here<extra></extra>",
            }
        )
    known = np.concatenate([solution.inv_kf, *comparison.values(), *([] if bound is None else [bound])])
    highest = float(np.max(known, where=np.isfinite(known), initial=max(0.6, threshold)))
    layout = {
        "height": 430,
        "hovermode": "x unified",
        "xaxis": _x_axis(along),
        "yaxis": {"title": {"text": "1/k<sub>F</sub> [–]"}, "range": [0.0, 1.1 * highest], "zeroline": False},
        "shapes": [*along.bands([""]), _level(threshold, "", _LIMIT, "dash")],
        "annotations": [*along.band_names(), _threshold_note(threshold), *_minimum_note(along, solution)],
        "legend": {"orientation": "h", "y": -0.2, "yanchor": "top", "x": 0},
        "margin": {"t": 54, "r": 92, "l": 70, "b": 60},
    }
    return {"traces": traces, "layout": layout}


def _threshold_note(threshold: float) -> Chart:
    return {
        "x": 1,
        "xref": "x domain",
        "xanchor": "left",
        "y": threshold,
        "yref": "y",
        "yanchor": "middle",
        "text": f" threshold {threshold:g}",
        "showarrow": False,
        "font": {"size": 11},
    }


def _minimum_note(along: Along, solution: Solution) -> list[Chart]:
    if not len(solution):
        return []
    counted = along.own if along.own.any() else np.ones(len(solution), np.bool_)
    worst = int(np.argmin(np.where(counted, solution.inv_kf, np.inf)))
    share = float(along.s_mm[worst]) / max(float(along.s_mm[-1]), 1e-9)
    where = f", CL line {along.line[worst]}" if along.line[worst] > 0 else ""
    return [
        {
            "x": float(along.s_mm[worst]),
            "y": float(solution.inv_kf[worst]),
            "text": f"lowest {solution.inv_kf[worst]:.3f}{where}",
            "ax": 0,
            "ay": 46,
            "xanchor": "left" if share < 0.15 else "right" if share > 0.85 else "center",
            "arrowhead": 2,
            "arrowwidth": 1.2,
            "arrowcolor": _OTHERS[2],
            "font": {"size": 12},
        }
    ]


def axis_limits(cell: Cell) -> dict[str, tuple[float, float]]:
    """Limits of every real axis as the controller counts it, degrees or mm; infinite where endless."""
    limits = {}
    for name in cell.axis_names:
        joint = cell.joints[cell.index(name)]
        limits[name] = (joint.to_edge(joint.lower), joint.to_edge(joint.upper))
    return limits


def _subplots(cell: Cell, along: Along, values: Mapping[str, Array], *, columns: int, row_height: int) -> Chart:
    """One small chart an axis, over its whole range of travel, the forbidden ends tinted."""
    names, limits = list(values), axis_limits(cell)
    rows = -(-len(names) // columns)
    height = rows * row_height + 90
    gap_x, gap_y = 0.09, min(0.3, 52.0 / height)
    wide, tall = (1 - gap_x * (columns - 1)) / columns, (1 - gap_y * (rows - 1)) / rows
    traces: list[Chart] = []
    notes: list[Chart] = []
    ids = [str(k + 1) if k else "" for k in range(len(names))]
    layout: Chart = {"height": height, "hovermode": "x", "showlegend": False, "shapes": along.bands(ids)}
    for k, name in enumerate(names):
        axes, row, column = ids[k], k // columns, k % columns
        unit = cell.joints[cell.index(name)].unit
        mark = " mm" if unit == "mm" else "°"
        y, (lower, upper) = values[name], limits[name]
        template = f"{name} %{{y:.2f}}{mark}<extra>%{{text}}</extra>"
        traces.append(along.curve(y, name, template=template, color=_MAIN, axes=axes))
        top = 1 - row * (tall + gap_y)
        x_domain = [column * (wide + gap_x), column * (wide + gap_x) + wide]
        bottom = row == rows - 1 or k + columns >= len(names)
        layout[f"xaxis{axes}"] = _x_axis(
            along, bottom, domain=x_domain, anchor=f"y{axes}", **({"matches": "x"} if k else {})
        )
        y_axis = {
            "domain": [top - tall, top],
            "anchor": f"x{axes}",
            "title": {"text": f"{name} [{unit}]"},
            "tickformat": ",~f",
            "zeroline": False,
        }
        layout[f"yaxis{axes}"] = y_axis
        text = f"{name}: endless, no limit"
        if np.isfinite(lower) and np.isfinite(upper):
            pad = 0.07 * (upper - lower)
            y_axis["range"] = [lower - pad, upper + pad]
            layout["shapes"] += _forbidden(lower, upper, pad, axes)
            margin = float(np.min(np.minimum(y - lower, upper - y))) if len(y) else 0.0
            text = f"{name}: {lower:,g} to {upper:,g}{mark}, here at least {margin:,.1f}{mark} from a limit"
        notes.append(_heading(text.replace("-", "−"), axes))
    layout["annotations"] = notes
    layout["margin"] = {"t": 48, "r": 20, "l": 70, "b": 50}
    return {"traces": traces, "layout": layout}


def _forbidden(lower: float, upper: float, pad: float, axes: str) -> list[Chart]:
    """Lines at an axis's limits, and the ranges beyond them tinted."""
    tinted = [
        {
            "type": "rect",
            "xref": f"x{axes} domain",
            "yref": f"y{axes}",
            "x0": 0,
            "x1": 1,
            "y0": y0,
            "y1": y1,
            "line": {"width": 0},
            "fillcolor": "rgba(214,69,69,0.22)",
            "layer": "below",
        }
        for y0, y1 in ((lower - pad, lower), (upper, upper + pad))
    ]
    return [*tinted, _level(lower, axes, _LIMIT, "solid"), _level(upper, axes, _LIMIT, "solid")]


def _heading(text: str, axes: str) -> Chart:
    return {
        "x": 0,
        "xref": f"x{axes} domain",
        "xanchor": "left",
        "y": 1,
        "yref": f"y{axes} domain",
        "yanchor": "bottom",
        "text": text,
        "showarrow": False,
        "font": {"size": 12},
    }


def axis_chart(cell: Cell, along: Along, axis_values: Array) -> Chart:
    """The arm's axes of axis values (N, axes), degrees, two charts a row."""
    names = [n for n in cell.axis_names if n not in cell.external_names]
    values = {n: axis_values[:, cell.axis_names.index(n)] for n in names}
    return _subplots(cell, along, values, columns=2, row_height=190)


def external_chart(cell: Cell, along: Along, axis_values: Array) -> Chart | None:
    """The external axes of axis values (N, axes), degrees or mm, one below the other; None where the cell has none."""
    values = {n: axis_values[:, cell.axis_names.index(n)] for n in cell.external_names}
    return _subplots(cell, along, values, columns=1, row_height=210) if values else None


def feed_chart(along: Along, path: ToolPathInBase, reached: Array | None = None) -> Chart | None:
    """The programmed feed while cutting, mm/min, and the speed reached (N,), m/s; None where no point carries a feed."""
    feed = np.where(path.cutting, m_s_to_mm_min(path.feed), np.nan)
    if not np.isfinite(feed).any():
        return None
    template = "%{y:,.0f} mm/min<extra>%{text}</extra>"
    highest = float(np.nanmax(feed))
    layout = {
        "height": 310 if reached is None else 350,
        "hovermode": "x",
        "showlegend": reached is not None,
        "legend": {"orientation": "h", "y": -0.22, "yanchor": "top", "x": 0},
        "xaxis": _x_axis(along),
        "yaxis": {
            "title": {"text": "feed [mm/min]"},
            "range": [0.0, 1.1 * highest],
            "tickformat": ",~f",
            "zeroline": False,
        },
        "shapes": along.bands([""]),
        "annotations": along.band_names(),
        "margin": {"t": 54, "r": 20, "l": 70, "b": 50},
    }
    curves = [along.curve(feed, "programmed", template=template, color=_MAIN, line={"shape": "vh"})]
    if reached is not None:
        color = _OTHERS[0]
        curves.append(
            along.curve(
                m_s_to_mm_min(reached), "reached", template=template, color=color, line={"width": 1.1, "shape": "vh"}
            )
        )
    return {"traces": curves, "layout": layout}
