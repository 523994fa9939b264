"""The pictures of a diagnosis: the path coloured by error, and bars of where the gap lies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from camrob.gap.diagnosis import PathError
from camrob.report.html import plot_text
from camrob.report.pack import packed_floats
from camrob.units import m_to_mm

__all__ = ["charts_of"]

Chart = dict[str, Any]

_POINTS = 2500
_LEAST_EXTENT = 0.25  # of the largest extent
_BEFORE, _AFTER, _NOISE = "#e08a1e", "#2f7fd1", "#8a93a0"


def charts_of(summary: Mapping[str, Any], paths: Sequence[PathError]) -> list[Chart]:
    """All charts, each with id, title, caption, traces and layout."""
    return [*_spatial(paths), *_along(summary, paths), _bars(summary)]


def _thin(count: int) -> np.ndarray[Any, np.dtype[np.int64]]:
    return np.unique(np.linspace(0, count - 1, min(count, _POINTS)).astype(np.int64))


def _spatial(paths: Sequence[PathError]) -> list[Chart]:
    """The path in 3D, coloured by the error before and after, on one scale."""
    out = []
    highest = max((float(np.quantile(m_to_mm(np.linalg.norm(p.before, axis=1)), 0.99)) for p in paths), default=1.0)
    scene = _box(np.concatenate([m_to_mm(p.position) for p in paths]) if paths else np.zeros((1, 3)))
    for which, title in (
        ("before", "The path, coloured by the error before"),
        ("after", "and after the effects found"),
    ):
        traces: list[Chart] = []
        for p in paths:
            pick = _thin(len(p.t))
            xyz = m_to_mm(p.position[pick])
            error = m_to_mm(np.linalg.norm(getattr(p, which)[pick], axis=1))
            traces.append({
                "type": "scatter3d", "mode": "markers", "name": plot_text(p.log),
                "x": packed_floats(xyz[:, 0]), "y": packed_floats(xyz[:, 1]), "z": packed_floats(xyz[:, 2]),
                "marker": {
                    "size": 2.5, "color": packed_floats(error), "colorscale": "Turbo", "cmin": 0.0, "cmax": highest,
                    "showscale": not traces, "colorbar": {"title": {"text": "mm"}},
                },
                "hovertemplate": "%{marker.color:.3f} mm<extra></extra>",
            })  # fmt: skip
        layout = {"height": 460, "showlegend": False, "margin": {"t": 10, "r": 10, "l": 10, "b": 10},
                  "scene": scene}  # fmt: skip
        caption = "Nominal TCP in the measured frame. Both pictures share one scale, so that they can be compared."
        out.append({"id": f"space-{which}", "title": title, "caption": caption, "traces": traces, "layout": layout})
    return out


def _box(xyz: np.ndarray[Any, np.dtype[np.float64]]) -> Chart:
    """The room around points (N, 3), mm, to scale; a flat path gets some height, or the camera would sit within it."""
    lower, upper = xyz.min(axis=0), xyz.max(axis=0)
    longest = max(float((upper - lower).max()), 1.0)
    half = 0.55 * np.maximum(upper - lower, 0.2 * longest)
    middle = 0.5 * (lower + upper)
    axes = {
        f"{name}axis": {"title": {"text": f"{name} mm"}, "range": [float(m - h), float(m + h)]}
        for name, m, h in zip("xyz", middle, half, strict=True)
    }
    ratio = dict(zip("xyz", (1.6 * half / half.max()).tolist(), strict=True))
    return {"aspectmode": "manual", "aspectratio": ratio, **axes}


def _ranges(paths: Sequence[PathError]) -> list[list[float]]:
    """Ranges in mm of x, y, z, none much smaller than the largest: a flat path would leave the picture empty."""
    points = m_to_mm(np.concatenate([p.position for p in paths])) if paths else np.zeros((1, 3))
    low, high = points.min(axis=0), points.max(axis=0)
    half = 0.52 * np.maximum(high - low, max(_LEAST_EXTENT * float((high - low).max()), 1.0))
    middle = 0.5 * (low + high)
    return [[float(a), float(b)] for a, b in zip(middle - half, middle + half, strict=True)]


def _along(summary: Mapping[str, Any], paths: Sequence[PathError]) -> list[Chart]:
    """Error over time, before and after, log by log."""
    out = []
    for k, p in enumerate(paths[:6]):
        pick = _thin(len(p.t))
        traces = [
            {
                "type": "scatter", "mode": "lines", "name": name, "x": packed_floats(p.t[pick]),
                "y": packed_floats(m_to_mm(np.linalg.norm(error[pick], axis=1))), "line": {"color": color, "width": 1.2},
                "hovertemplate": "%{y:.3f} mm",
            }
            for name, error, color in (("before", p.before, _BEFORE), ("after", p.after, _AFTER))
        ]  # fmt: skip
        noise = float(summary["gap"]["noise_mm"])
        line = {"type": "line", "xref": "x domain", "yref": "y", "x0": 0, "x1": 1, "y0": noise, "y1": noise,
                "line": {"color": _NOISE, "dash": "dash", "width": 1.2}}  # fmt: skip
        layout = {"height": 320, "hovermode": "x unified", "shapes": [line], "margin": {"t": 20, "r": 20, "l": 70, "b": 50},
                  "xaxis": {"title": {"text": "time [s]"}}, "yaxis": {"title": {"text": "error [mm]"}, "rangemode": "tozero"},
                  "legend": {"orientation": "h", "y": -0.25}}  # fmt: skip
        out.append({"id": f"along-{k}", "title": f"Error along {p.log}", "traces": traces, "layout": layout,
                    "caption": "Dashed: the instrument's noise, below which nothing can be seen."})  # fmt: skip
    return out


def _bars(summary: Mapping[str, Any]) -> Chart:
    """Gap by rung, axis and regime."""
    where = summary["where"]
    rungs = {k.replace("_", " "): v for k, v in where["rungs"].items() if v is not None}
    groups = (("rung, mm", rungs), ("axis, share", where["axes"]), ("regime, share", where["regimes"]))
    traces, layout = [], {"height": 330, "showlegend": False, "margin": {"t": 30, "r": 20, "l": 50, "b": 110}}
    for k, (name, values) in enumerate(groups):
        axes = str(k + 1) if k else ""
        traces.append({
            "type": "bar", "name": name, "x": [plot_text(n) for n in values], "y": [float(v) for v in values.values()],
            "xaxis": f"x{axes}", "yaxis": f"y{axes}", "marker": {"color": (_BEFORE, _AFTER, "#2f9e77")[k]},
            "hovertemplate": "%{x}: %{y:.3f}<extra></extra>",
        })  # fmt: skip
        layout[f"xaxis{axes}"] = {"domain": [0.35 * k, 0.35 * k + 0.28], "anchor": f"y{axes}"}
        layout[f"yaxis{axes}"] = {"anchor": f"x{axes}", "rangemode": "tozero", "title": {"text": name}}
    caption = ("Rungs in mm rms; axes and regimes as the share of the gap's energy that each would explain alone, "
               "on withheld stretches. The shares overlap and need not add up.")  # fmt: skip
    return {"id": "where", "title": "Where the gap lies", "caption": caption, "traces": traces, "layout": layout}
