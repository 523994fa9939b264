"""Bars of a diagnosis: the gap by stage, axis and regime with intervals, and how far it shrinks on withheld samples."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from camrob.report.diagnosis.charts import AFTER, BEFORE, NOISE, noise_trace
from camrob.report.diagnosis.sentences import between, only_first, plain_name
from camrob.report.page.html import plot_text
from camrob.summaries.diagnosis_summary import DiagnosisSummary

__all__ = ["place_charts", "shrink_charts"]

Chart = dict[str, Any]
_GREEN = "#2f9e77"
_LIKELY = 0.5
# px that titles and ticks take; the legend stands above the bars
_MARGIN = {"t": 34, "r": 10, "l": 56, "b": 46}
_LEGEND = {"orientation": "h", "x": 0, "y": 1.16}


def place_charts(summary: DiagnosisSummary) -> list[Chart]:
    """The gap by stage (mm) and, where any is claimed, by cause (mm); at last by axis and by regime (%). With their 90 %
    intervals, but for causes.
    """
    where = summary.where
    stages = {_arrow(k, summary): (v, where.stage_intervals[k]) for k, v in where.stages.items()}
    blamed = [a for a in summary.blamed_axes if a in where.axes]
    order = [*blamed, *(a for a in where.axes if a not in blamed)]
    axes = {k: (where.axes[k], where.axis_intervals[k]) for k in order}
    # a shift of an axis that nothing is blamed on may mimic the gap too: that is no cause
    colors = [AFTER if a in blamed or not blamed else NOISE for a in order]
    unit = "share of the gap's energy [%]"
    title = "By axis, those that are blamed first" if blamed else "By axis"
    shares = {**where.regimes, **{k: v for k, v in where.further_regimes.items() if v}}
    follow = [r for r in summary.blamed_regimes if r in shares]
    kinds = [*follow, *(r for r in shares if r not in follow)]
    regimes = {k: (shares[k], where.regime_intervals[k]) for k in kinds}
    shades = [_GREEN if k in follow or not follow else NOISE for k in kinds]
    return [
        _bars("by-stage", "By stage", "rms [mm]", stages, BEFORE, 1.0),
        *_by_cause(summary),
        _bars("by-axis", title, unit, axes, colors, 100.0),
        _bars("by-regime", "By regime, what is blamed first" if follow else "By regime", unit, regimes, shades, 100.0),
    ]


def _by_cause(summary: DiagnosisSummary) -> list[Chart]:
    """How far each claim moves the tool, and what stays unexplained where that is likely."""
    sizes: dict[str, float] = {plain_name(e.effect): e.moves_mm for e in summary.claimed if not only_first(e)}
    if not sizes:
        return []
    shades = [_GREEN] * len(sizes)
    if summary.unknown.probability >= _LIKELY:
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
) -> Chart:
    """Bars with intervals; where there is no value, words say so."""
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


def _broken(words: str) -> str:
    """A bar's name, over several lines where it is long."""
    return "<br>".join(plot_text(part) for part in textwrap.wrap(words.replace(" to ", " to\u00a0"), 12))


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
    bars += [(f"{plain_name(e.effect)} alone", e.alone.rms_after_mm, _GREEN) for e in claimed if len(claimed) > 1]
    if compensable.effects and compensable.shrink_interval[0] > 0.0:
        bars.append(("what compensate corrects", compensable.rms_after_mm, _GREEN))
    bars.append(("all that is claimed", t.rms_after_mm, AFTER))
    trace = {
        "type": "bar",
        "showlegend": False,
        "x": [_broken(n) for n, _, _ in bars],
        "y": [v for _, v, _ in bars],
        "marker": {"color": [c for _, _, c in bars]},
        "hovertemplate": "%{x}: %{y:.3f} mm<extra></extra>",
    }
    line = noise_trace(noise, [_broken(n) for n, _, _ in bars])
    layout = {
        "height": 320,
        "margin": _MARGIN,
        "legend": _LEGEND,
        "xaxis": {"type": "category", "automargin": True},
        "yaxis": {"title": {"text": "rms [mm]"}, "rangemode": "tozero"},
    }
    return {"id": "steps", "title": "Step by step", "traces": [trace, line], "layout": layout}
