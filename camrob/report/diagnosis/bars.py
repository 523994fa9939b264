"""Bars of a diagnosis: the gap by stage, axis and regime with intervals, and how far it shrinks on withheld samples."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from camrob.report.diagnosis.charts import AFTER, BEFORE, NOISE, noise_trace
from camrob.report.diagnosis.numbers import mm
from camrob.report.diagnosis.sentences import between, only_first, plain_name
from camrob.report.page.html import plot_text
from camrob.summaries.diagnosis_summary import DiagnosisSummary

__all__ = ["axes_read", "place_charts", "rest_charts", "shrink_charts"]

Chart = dict[str, Any]
_GREEN = "#2f9e77"
_PALE = "rgba(125, 135, 148, 0.35)"  # what the verdict doesn't name
_MEANT = 0.05  # p-value below which the rest is said to follow a regime
# px that titles and ticks take; the legend stands below the chart, as above it the tools of a narrow one do
_MARGIN = {"t": 34, "r": 14, "l": 56, "b": 46}
_LEGEND = {"orientation": "h", "x": 0, "y": -0.2, "yanchor": "top"}
_ROW = 27  # px of a bar that lies, with its name beside it


def place_charts(summary: DiagnosisSummary) -> list[Chart]:
    """The gap by stage (mm) and, where any is claimed, by cause (mm); at last by axis and by regime (%). With their 90 %
    intervals, but for causes.
    """
    where = summary.where
    stages = {_arrow(k, summary): (v, where.stage_intervals[k]) for k, v in where.stages.items()}
    blamed = [a for a in summary.blamed_axes if a in where.axes]
    order = [*blamed, *(a for a in where.axes if a not in blamed)]
    read, rms = axes_read(summary), summary.gap.rms_mm
    names = {
        k: f"{k}: {mm(read[k]) if k in read else f'as {mm(rms * math.sqrt(max(where.axes[k], 0.0)))}'}" for k in order
    }
    axes = {names[k]: (where.axes[k], where.axis_intervals[k]) for k in order}
    # a shift of an axis that nothing is blamed on may mimic the gap too: that is no cause
    colors = [AFTER if a in blamed else _PALE for a in order]
    unit = "share of the whole gap's energy [%]"
    title = f"By axis, of the whole gap{': those blamed first' if blamed else ''}"
    shares = {**where.regimes, **{k: v for k, v in where.further_regimes.items() if v}}
    follow = [r for r in summary.blamed_regimes if r in shares]
    kinds = [*follow, *(r for r in shares if r not in follow)]
    regimes = {k: (shares[k], where.regime_intervals[k]) for k in kinds}
    shades = [_GREEN if k in follow else _PALE for k in kinds]
    by_axis = _laid(_bars("by-axis", title, unit, axes, colors, 100.0, rms))
    title = f"By regime, of the whole gap{': what is blamed first' if follow else ''}"
    return [
        _bars("by-stage", "By stage", "rms [mm]", stages, BEFORE, 1.0),
        *_by_cause(summary),
        by_axis,
        _laid(_bars("by-regime", title, unit, regimes, shades, 100.0, rms)),
    ]


def axes_read(summary: DiagnosisSummary) -> dict[str, float]:
    """mm rms at the tool that each axis is off by as its drive's log shows; empty where most of the gap is elsewhere."""
    stages = {k: v or 0.0 for k, v in summary.where.stages.items()}
    if max(stages, key=lambda k: stages[k], default="") != "setpoint_to_encoder":
        return {}
    return {axis: r.drive.rms_mm for axis, r in summary.axes_report.items() if r.drive is not None}


def rest_charts(summary: DiagnosisSummary) -> list[Chart]:
    """What stays once all that is claimed is taken away, by regime, as shares of its own energy; none where that is the gap."""
    unknown = summary.unknown
    if not unknown.likely or not any(not only_first(e) for e in summary.claimed):
        return []
    left = sorted(summary.residual.structure, key=lambda s: s.regime not in unknown.where.regimes)
    if not any(s.share > 0.0 for s in left):
        return []
    values = {s.regime: (s.share, (s.share, s.share)) for s in left}
    shades = [BEFORE if s.p_value < _MEANT and s.regime in unknown.where.regimes else _PALE for s in left]
    unit = "share of the rest's energy [%]"
    chart = _laid(_bars("rest-by-regime", "By regime, of the unexplained rest alone", unit, values, shades, 100.0))
    del chart["traces"][0]["error_x"]
    return [chart]


def _by_cause(summary: DiagnosisSummary) -> list[Chart]:
    """How far each claim moves the tool, and what stays unexplained where that is likely."""
    sizes: dict[str, float] = {plain_name(e.called): e.moves_mm for e in summary.claimed if not only_first(e)}
    if not sizes:
        return []
    shades = [_GREEN] * len(sizes)
    if summary.unknown.likely:
        sizes["unexplained"] = summary.unknown.rms_mm
        shades.append(BEFORE)
    known = {name: (size, (size, size)) for name, size in sizes.items()}
    chart = _bars("by-cause", "By cause, at the tool", "rms [mm]", known, shades, 1.0)
    for trace in chart["traces"]:
        del trace["error_y"]  # of a fitted size nobody has resampled
    return [chart]


def _arrow(stage: str, summary: DiagnosisSummary) -> str:
    return between(stage, summary).removeprefix("between ").replace(" and ", " to ")


def _bars(
    name: str,
    title: str,
    unit: str,
    values: Mapping[str, tuple[float | None, Sequence[float] | None]],
    color: str | Sequence[str],
    factor: float,
    whole_mm: float = 0.0,
) -> Chart:
    """Bars with intervals; where there is no value, words say so. whole_mm: rms that all is, for shares to say theirs in mm."""
    known = {k: (v, i) for k, (v, i) in values.items() if v is not None and i is not None}
    trace = {
        "type": "bar",
        "x": [_broken(k) for k in known],
        "y": [factor * v for v, _ in known.values()],
        "marker": {"color": color},
        "hovertemplate": "%{x}: %{y:.3g}<extra></extra>",
        "error_y": {
            "type": "data",
            "symmetric": False,
            "color": NOISE,
            "thickness": 1.5,
            "width": 4,
            "array": [factor * max(i[1] - v, 0.0) for v, i in known.values()],
            "arrayminus": [factor * max(v - i[0], 0.0) for v, i in known.values()],
        },
    }
    if whole_mm > 0.0:  # energies: the rms goes with a share's root
        trace["customdata"] = [mm(whole_mm * math.sqrt(max(v, 0.0))) for v, _ in known.values()]
        trace["hovertemplate"] = "%{x}: %{y:.3g} %, as much as %{customdata} rms<extra></extra>"
    missing = [
        {"text": "not<br>logged", "x": _broken(k), "y": 0, "yref": "y", "yanchor": "bottom", "showarrow": False}
        for k, (v, _) in values.items()
        if v is None
    ]
    axis: Chart = {"title": {"text": unit}, "rangemode": "tozero"}
    if factor == 100.0:
        axis["range"] = [0.0, 104.0]
    order = {
        "type": "category",
        "categoryorder": "array",
        "categoryarray": [_broken(k) for k in values],
        "automargin": True,
        "range": [-0.5, len(values) - 0.5],
    }
    layout = {
        "height": 320,
        "showlegend": False,
        "margin": _MARGIN,
        "annotations": missing,
        "xaxis": order,
        "yaxis": axis,
    }
    return {"id": name, "title": title, "traces": [trace], "layout": layout}


def _laid(chart: Chart) -> Chart:
    """The same bars lying, the first on top: many names, or long ones, stand beside bars and not beneath them."""
    trace, layout = chart["traces"][0], chart["layout"]
    names = [name.replace("<br>", " ") for name in layout["xaxis"]["categoryarray"]]
    laid = {**trace, "orientation": "h", "x": trace["y"], "y": [name.replace("<br>", " ") for name in trace["x"]]}
    laid["hovertemplate"] = trace["hovertemplate"].replace("%{x}", "%{label}").replace("%{y:", "%{value:")
    if "error_y" in laid:
        laid["error_x"] = laid.pop("error_y")
    order = {**layout["xaxis"], "categoryarray": names, "range": [len(names) - 0.5, -0.5]}
    missing = [
        {**note, "text": "not logged", "x": 0, "xref": "x", "y": note["x"].replace("<br>", " "), "xanchor": "left"}
        for note in layout["annotations"]
    ]
    height = 34 + 50 + _ROW * max(len(names), 3)
    new = {**layout, "height": height, "annotations": missing, "xaxis": layout["yaxis"], "yaxis": order}
    return {**chart, "traces": [laid], "layout": new}


def _broken(words: str) -> str:
    """A bar's name, over several lines where it is long."""
    return "<br>".join(
        plot_text(part) for line in words.splitlines() for part in textwrap.wrap(line.replace(" to ", " to\u00a0"), 12)
    )


def shrink_charts(summary: DiagnosisSummary) -> list[Chart]:
    """Before and after on withheld samples: rms, 95 % and worst; and the rms with each effect alone, and together."""
    t, noise = summary.together, summary.gap.noise_mm
    traces = [
        {
            "type": "bar",
            "name": when,
            "x": ["rms", "95 %", "worst"],
            "y": sizes,
            "marker": {"color": color},
            "hovertemplate": "%{y:.3f} mm",
        }
        for when, sizes, color in (
            ("before", [t.rms_before_mm, t.p95_before_mm, t.max_before_mm], BEFORE),
            ("after", [t.rms_after_mm, t.p95_after_mm, t.max_after_mm], AFTER),
        )
    ]
    traces.append(noise_trace(noise, ["rms", "worst"]))
    layout = {
        "height": 320,
        "barmode": "group",
        "margin": _MARGIN,
        "legend": _LEGEND,
        "xaxis": {"type": "category"},
        "yaxis": {"title": {"text": "error [mm]"}, "rangemode": "tozero"},
    }
    pair = {"id": "shrunk", "title": "Together", "traces": traces, "layout": layout}
    return [pair, _steps(summary, noise)]


def _steps(summary: DiagnosisSummary, noise: float) -> Chart:
    """rms on withheld samples: before, with each claimed effect alone, with all of them, with what compensate corrects."""
    t, compensable = summary.together, summary.compensable
    claimed = [e for e in summary.claimed if not only_first(e)]
    bars = [("before", t.rms_before_mm, BEFORE)]
    bars += [(f"{plain_name(e.called)} alone", e.alone.rms_after_mm, _GREEN) for e in claimed if len(claimed) > 1]
    if compensable.effects and compensable.shrink_interval[0] > 0.0:
        bars.append(("what compensate corrects", compensable.rms_after_mm, _GREEN))
    bars.append(("all that is claimed", t.rms_after_mm, AFTER))
    names = [plot_text(name) for name, _, _ in bars]
    trace = {
        "type": "bar",
        "orientation": "h",
        "showlegend": False,
        "x": [v for _, v, _ in bars],
        "y": names,
        "marker": {"color": [c for _, _, c in bars]},
        "hovertemplate": "%{label}: %{value:.3f} mm<extra></extra>",
    }
    line = noise_trace(noise, names)
    line["x"], line["y"] = line["y"], line["x"]
    layout = {
        "height": max(320, 34 + 110 + _ROW * len(bars)),
        "margin": _MARGIN,
        "legend": {**_LEGEND, "y": -0.34},
        "xaxis": {"title": {"text": "rms [mm]"}, "rangemode": "tozero"},
        "yaxis": {"type": "category", "automargin": True, "autorange": "reversed"},
    }
    return {"id": "steps", "title": "Step by step", "traces": [trace, line], "layout": layout}
