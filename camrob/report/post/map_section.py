"""The map of the redundancy in the page: path against each spare freedom, what is forbidden, and the chosen line."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.redundancy.redundancy_map import BEYOND_LIMIT, ELSEWHERE, OUT_OF_REACH, TOUCHES, FreedomMap, RedundancyMap
from camrob.redundancy.solution import Solution
from camrob.report.page.pack import packed_integers
from camrob.report.page.path_charts import Along, Chart

__all__ = ["map_chart"]

Array = NDArray[np.float64]

_STEPS = 250  # of 1/k_F from 0 to its highest
_CODES = {OUT_OF_REACH: 301, BEYOND_LIMIT: 302, ELSEWHERE: 303, TOUCHES: 304}  # as page.js paints them
_ROW, _TOP, _BOTTOM, _GAP = 210, 40, 56, 46  # pixels

_SHADES = ("#67001f", "#d6302b", "#f5a623", "#35a883", "#2166ac")  # of 1/k_F, as page.js has them
_SEEN = {
    OUT_OF_REACH: ("map-reach", "out of reach"),
    BEYOND_LIMIT: ("map-limit", "an axis of the arm beyond its limit"),
    ELSEWHERE: ("map-elsewhere", "only in another posture of the arm"),
    TOUCHES: ("map-touch", "something touches"),
}


def map_chart(
    cell: Cell, along: Along, solution: Solution, found: RedundancyMap, *, threshold: float
) -> tuple[Chart, str]:
    """One picture a freedom, one below the other, with its legend, and the caption."""
    count = len(found.freedoms)
    height = count * _ROW + (count - 1) * _GAP + _TOP + _BOTTOM
    whole = height - _TOP - _BOTTOM
    highest = max(0.7, max(float(f.look.max()) for f in found.freedoms))
    layout: Chart = {
        "height": height,
        "hovermode": "x",
        "showlegend": False,
        "shapes": [],
        "annotations": [],
        "margin": {"t": _TOP, "r": 20, "l": 70, "b": _BOTTOM},
    }
    traces, maps = [], []
    for k, freedom in enumerate(found.freedoms):
        axes = str(k + 1) if k else ""
        name, (unit, values, chosen) = _name(cell, freedom), _axis(cell, freedom, solution)
        top = 1.0 - k * (_ROW + _GAP) / whole
        layout[f"xaxis{axes}"] = {
            "range": [0.0, float(along.s_mm[-1])],
            "anchor": f"y{axes}",
            "tickformat": ",~f",
            "hoverformat": ",.1f",
            "zeroline": False,
            "showgrid": False,
            **({"title": {"text": "path length of the tool tip [mm]", "standoff": 6}} if k == count - 1 else {}),
            **({"matches": "x"} if k else {}),
        }
        layout[f"yaxis{axes}"] = {
            "domain": [top - _ROW / whole, top],
            "anchor": f"x{axes}",
            "range": [float(values.min()), float(values.max())],
            "title": {"text": f"{name} [{unit}]"},
            "tickformat": ",~f",
            "zeroline": False,
            "showgrid": False,
        }
        others = [_name(cell, f) for f in found.freedoms if f is not freedom]
        rest = f" varied, {' and '.join(others)} as chosen" if others else " varied"
        layout["annotations"].append(
            {"x": 0, "xref": f"x{axes} domain", "xanchor": "left", "y": 1, "yref": f"y{axes} domain", "yanchor": "bottom",
             "text": f"{name}{rest}", "showarrow": False, "font": {"size": 12}}
        )  # fmt: skip
        mark = " mm" if unit == "mm" else "°"
        template = f"{name} %{{y:.2f}}{mark}<extra>%{{text}}</extra>"
        traces.append(
            along.curve(chosen, "", template="", color="#111", axes=axes, hoverinfo="skip", line={"width": 4})
        )
        traces.append(along.curve(chosen, name, template=template, color="#fff", axes=axes, line={"width": 1.8}))
        maps.append(_map(freedom, values, axes, highest, threshold))
    legend = _legend(found, highest, threshold)
    return {"traces": traces, "layout": layout, "maps": maps, "legend": legend}, _caption(found, count)


def _legend(found: RedundancyMap, highest: float, threshold: float) -> str:
    """What the colours mean, as HTML: those that are there."""
    t = min(0.95, max(0.05, threshold / highest))  # as page.js has it
    stops = zip((0.0, 0.7 * t, t, t + 0.3 * (1.0 - t), 1.0), _SHADES, strict=True)
    bar = ",".join(f"{color} {100.0 * at:.0f}%" for at, color in stops)
    items = [
        f'1/k<sub>F</sub> 0 <i style="background:linear-gradient(90deg,{bar});width:120px;margin-left:5px"></i>{highest:.2f}, '
        f"amber at the threshold {threshold:g}",
        *(f'<i class="{name}"></i>{text}' for code, (name, text) in _SEEN.items() if _shows(found, code)),
        '<i style="background:#fff;border:2px solid #111;height:6px;width:22px;vertical-align:2px"></i>chosen',
    ]
    return f'<div class="legend">{"".join(f"<span>{item}</span>" for item in items)}</div>'


def _shows(found: RedundancyMap, code: float) -> bool:
    return any(bool((f.look == code).any()) for f in found.freedoms)


def _name(cell: Cell, freedom: FreedomMap) -> str:
    name = cell.joints[freedom.joint].name
    return name if name in cell.axis_names else "roll"


def _axis(cell: Cell, freedom: FreedomMap, solution: Solution) -> tuple[str, Array, Array]:
    """A freedom's unit, values (M,) and chosen values (N,) as the controller counts them."""
    joint = cell.joints[freedom.joint]
    q = np.asarray(solution.q)[:, freedom.joint]
    named = joint.name in cell.axis_names
    values, chosen = (np.asarray(joint.to_edge(joint.axis_value(x) if named else x)) for x in (freedom.values, q))
    return joint.unit, values, chosen


def _map(freedom: FreedomMap, values: Array, axes: str, highest: float, threshold: float) -> dict[str, Any]:
    """What page.js paints: `look` row by row from the highest value down, as steps of 1/k_F or a code."""
    look = freedom.look if values[0] > values[-1] else freedom.look[:, ::-1]
    codes = np.rint(np.clip(look, 0.0, None) / highest * _STEPS).astype(np.int64)
    for what, code in _CODES.items():
        codes[look == what] = code
    return {
        "axes": axes,
        "columns": look.shape[0],
        "rows": look.shape[1],
        "low": float(values.min()),
        "high": float(values.max()),
        "steps": _STEPS,
        "threshold": threshold / highest,
        "codes": packed_integers(codes.T),
    }


def _caption(found: RedundancyMap, count: int) -> str:
    asked = (
        "What touches was asked at one place in 160, so that black blocks have coarse edges."
        if found.touched
        else "What would touch something is only asked with --method planned."
    )
    each = "each of them is moved by itself while the others stay on their lines" if count > 1 else "it is moved"
    return (
        f"Every picture shows what one spare freedom could have been at each place of the path: {each}; the colour is the "
        "1/k<sub>F</sub> "
        "that the arm would have there, and the white line is what was chosen. Look for a line that runs along an edge, and for "
        f"better colours beside it: there a posture can be gained. {asked} Click to bring the player there."
    )
