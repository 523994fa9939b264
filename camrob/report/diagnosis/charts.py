"""The pictures of a diagnosis: the path coloured by error, the error over time, what remains besides the noise."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.gap.diagnosis import PathError
from camrob.report.diagnosis.numbers import mm
from camrob.report.page.cloud import Cloud
from camrob.report.page.pack import packed_floats
from camrob.summaries.diagnosis_summary import GapFigures
from camrob.units import m_to_mm

__all__ = ["AFTER", "BEFORE", "NOISE", "error_charts", "noise_trace", "residual_chart", "space_clouds"]

Chart = dict[str, Any]
Array = NDArray[np.float64]

BEFORE, AFTER, NOISE = "#e08a1e", "#2f7fd1", "#7d8794"

_POINTS = 2500  # as many as a screen is wide
_MOST_LOGS = 6  # as many as one tells apart by colour
_SCALE = ((0.0, "#2f7fd1"), (0.25, "#6cc3c0"), (0.5, "#f3d04f"), (0.75, "#ec7f2c"), (1.0, "#b3151c"))
_EYE = (0.6, -0.8, 0.6)  # from the front and above
_LONG = 7200.0  # s: from here on in hours
_BINS = 60


def space_clouds(paths: Sequence[PathError], *, claimed: bool) -> list[Cloud]:
    """The path in 3D coloured by the error before, and after where something is claimed, on one scale."""
    picks = [_thin(len(p.t)) for p in paths]
    known = bool(paths) and any(p.line.any() for p in paths)
    points = _joined([m_to_mm(p.position[pick]) for p, pick in zip(paths, picks, strict=True)], (0, 3))
    line = _joined([p.line[pick].astype(float) for p, pick in zip(paths, picks, strict=True)], (0,)).astype(np.int64)
    source = np.repeat(np.arange(len(paths)), [len(pick) for pick in picks])
    before = [m_to_mm(np.linalg.norm(p.before, axis=1)) for p in paths]
    highest = max((float(np.quantile(b, 0.99)) for b in before), default=1.0)
    named = (("before", "Before"), ("after", "After, with the effects found taken away"))[: 2 if claimed else 1]
    return [
        Cloud(
            f"space-{which}",
            title,
            points,
            _joined([_size(getattr(p, which)[pick]) for p, pick in zip(paths, picks, strict=True)], (0,)),
            0.0,
            highest,
            _SCALE,
            "error",
            _EYE,
            line=line if known else None,
            source=source,
            sources=[p.log for p in paths],
            height=440,
        )
        for which, title in named
    ]


def _size(error: Array) -> Array:
    return m_to_mm(np.linalg.norm(error, axis=1))


def _joined(parts: Sequence[Array], empty: tuple[int, ...]) -> Array:
    return np.concatenate(parts) if parts else np.zeros(empty)


def _thin(count: int) -> NDArray[np.int64]:
    return np.unique(np.linspace(0, count - 1, min(count, _POINTS)).astype(np.int64))


def noise_trace(noise_mm: float, x: Sequence[Any]) -> Chart:
    """A dashed line at the noise from one end of a chart to the other, with its name for the legend."""
    return {
        "type": "scatter",
        "mode": "lines",
        "name": f"noise {mm(noise_mm)}",
        "x": [x[0], x[-1]],
        "y": [noise_mm, noise_mm],
        "line": {"color": NOISE, "dash": "dash", "width": 2},
        "hoverinfo": "skip",
        "showlegend": True,
    }


def error_charts(gap: GapFigures, paths: Sequence[PathError], *, claimed: bool) -> list[Chart]:
    """Error over time, before and after, log by log; of single poses pose by pose."""
    out = []
    for k, p in enumerate(paths[:_MOST_LOGS]):
        pick = _thin(len(p.t))
        hours = not p.poses and float(np.ptp(p.t)) > _LONG
        x = pick.astype(float) + 1.0 if p.poses else p.t[pick] / (3600.0 if hours else 1.0)
        mode = "markers" if p.poses else "lines"
        traces = []
        for name, error, color in (("before", p.before, BEFORE), ("after", p.after, AFTER))[: 2 if claimed else 1]:
            size = m_to_mm(np.linalg.norm(error[pick], axis=1))
            look = {"marker": {"size": 4, "color": color}} if p.poses else {"line": {"color": color, "width": 1.2}}
            traces.append(
                {
                    "type": "scatter",
                    "mode": mode,
                    **look,
                    "name": name,
                    "x": packed_floats(x),
                    "y": packed_floats(size),
                    "hovertemplate": "%{y:.3f} mm",
                }
            )
        traces.append(noise_trace(gap.noise_mm, [float(x[0]), float(x[-1])]))
        layout = {
            "height": 300,
            "hovermode": "x unified",
            "margin": {"t": 34, "r": 20, "l": 64, "b": 46},
            "legend": {"orientation": "h", "x": 0, "y": 1.14},
            "xaxis": {"title": {"text": "pose" if p.poses else f"time [{'h' if hours else 's'}]"}, "zeroline": False},
            "yaxis": {"title": {"text": "error [mm]"}, "rangemode": "tozero"},
        }
        out.append({"id": f"along-{k}", "title": f"Error along {p.log}", "traces": traces, "layout": layout})
    return out


def residual_chart(gap: GapFigures, paths: Sequence[PathError]) -> Chart:
    """How large the errors that stay are, and how large the noise alone would make them."""
    left = m_to_mm(np.linalg.norm(np.concatenate([p.after for p in paths]), axis=1)) if paths else np.zeros(1)
    noise = max(gap.noise_mm, 1e-6)
    highest = max(3.0 * noise, float(np.quantile(left, 0.995)))
    bins = int(np.clip(len(left) / 8, 12, _BINS))
    counts, edges = np.histogram(left, bins=bins, range=(0.0, highest))
    width = highest / bins
    one = noise / np.sqrt(3.0)  # of one direction
    x = np.linspace(0.0, highest, 240)
    alone = np.sqrt(2.0 / np.pi) * x**2 / one**3 * np.exp(-0.5 * (x / one) ** 2)
    share = 100.0 * width
    tallest, peak = 100.0 * float(counts.max()) / max(len(left), 1), share * float(alone.max())
    traces = [
        {
            "type": "bar",
            "name": "what stays",
            "x": packed_floats(edges[:-1] + 0.5 * width),
            "width": width,
            "y": packed_floats(100.0 * counts / max(len(left), 1)),
            "marker": {"color": AFTER},
            "hovertemplate": "%{y:.1f} % near %{x:.3f} mm<extra></extra>",
        },
        {
            "type": "scatter",
            "mode": "lines",
            "name": "the noise alone",
            "x": packed_floats(x),
            "y": packed_floats(share * alone),
            "line": {"color": NOISE, "width": 2.5},
            "hoverinfo": "skip",
        },
    ]
    layout = {
        "height": 300,
        "bargap": 0,
        "margin": {"t": 34, "r": 20, "l": 64, "b": 46},
        "legend": {"orientation": "h", "x": 0, "y": 1.14},
        "xaxis": {"title": {"text": "error [mm]"}, "range": [0.0, highest]},
        "yaxis": {"title": {"text": "samples [%]"}, "range": [0.0, 1.15 * max(tallest, min(peak, 2.0 * tallest))]},
    }
    return {"id": "residual", "title": "What remains, besides the noise", "traces": traces, "layout": layout}
