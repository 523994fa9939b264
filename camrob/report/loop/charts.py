"""The paper's figures our way, and those of what does better, for the report on the tracker loop."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from camrob.loop.loop import LoopLog
from camrob.loop.measures import across
from camrob.report.page.line_charts import Curve, LineChart, chart_data
from camrob.studies.loop_study import TrackerStudy
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["tracker_charts"]

Array = NDArray[np.float64]

_AMPLIFIED = 200.0  # times, on the circle
_RING = 0.0002  # m between rings, as printed
_CIRCLE_POINTS = 1400
_SAMPLES = 16
_WINDOW = (-0.6, 2.4)  # s about a corner or reversal
_SHORT = {
    "none": "no correction",
    "published": "published law",
    "gain": "better gain",
    "ahead": "joints sent ahead",
    "learned_ahead": "and learned",
}
# which of the page's colours: a variant keeps its own in every chart
_COLOR = {
    "none": 3,
    "published": 0,
    "gain": 1,
    "aligned": 4,
    "averaged": 7,
    "ahead": 2,
    "learned_ahead": 5,
    "learned_published": 6,
}


def tracker_charts(study: TrackerStudy) -> list[tuple[LineChart, dict[str, Any]]]:
    """Charts with what page.js draws them from, in the page's order."""
    charts: list[tuple[LineChart, dict[str, Any]]] = []
    for chart in _figure_5(study):
        charts.append((chart, chart_data([chart])[0]))
    others: tuple[tuple[LineChart, dict[str, Any]], ...] = (
        (_figure_6(study), {"equal": True, "height": 620}),
        (_figure_7(study), {}),
        (_gain(study), {"logarithmic_x": True}),
        (_laps(study), {"marks": True}),
        *((c, {}) for c in _close(study)),
    )
    for chart, own in others:
        charts.append((chart, _alone(chart_data([chart])[0], **own)))
    return charts


def _alone(
    data: dict[str, Any], *, equal: bool = False, logarithmic_x: bool = False, marks: bool = False, height: int = 0
) -> dict[str, Any]:
    """A chart whose x is its own: it doesn't zoom with the others."""
    data["own"] = True
    data["layout"]["hovermode"] = "closest"
    if equal:
        data["layout"]["yaxis"]["scaleanchor"] = "x"
        data["layout"]["xaxis"]["constrain"] = "domain"
    if logarithmic_x:
        data["layout"]["xaxis"]["type"] = "log"
    if marks:
        for trace in data["traces"]:
            trace["mode"] = "lines+markers"
    if height:
        data["layout"]["height"] = height
    return data


def _figure_5(study: TrackerStudy) -> tuple[LineChart, ...]:
    t, plain, switched = study.paths[0].time, study.variant("none").square.seen, study.switched.seen
    mm, deg = [f"e_{a}" for a in "xyz"], [f"e_{a}" for a in ("yaw A", "pitch B", "roll C")]

    def curves(values: Array, names: list[str], first: int) -> tuple[Curve, ...]:
        change = m_to_mm if first == 0 else rad_to_deg
        return tuple(Curve(n, t, change(values[:, first + k])) for k, n in enumerate(names))

    on = f"The correction is switched on at {study.case.switched_on:g} s."
    seen = "As the tracker sees it, its noise included; peaks stand at the corners."
    return (
        LineChart(
            "five-a",
            "Square, linear errors without correction (Figure 5 a)",
            seen,
            "time [s]",
            "error [mm]",
            curves(plain, mm, 0),
        ),
        LineChart(
            "five-b",
            "Square, linear errors with correction (Figure 5 b)",
            on,
            "time [s]",
            "error [mm]",
            curves(switched, mm, 0),
        ),
        LineChart(
            "five-c",
            "Square, errors of rotation without correction (Figure 5 c)",
            seen,
            "time [s]",
            "error [deg]",
            curves(plain, deg, 3),
        ),
        LineChart(
            "five-d",
            "Square, errors of rotation with correction (Figure 5 d)",
            on,
            "time [s]",
            "error [deg]",
            curves(switched, deg, 3),
        ),
    )


def _figure_6(study: TrackerStudy) -> LineChart:
    path = study.paths[1]
    moving = np.flatnonzero(path.moving)
    pick = moving[np.linspace(0, len(moving) - 1, _CIRCLE_POINTS).astype(int)]
    place = np.asarray(path.wanted)[pick, :2] - path.center[:2]
    around = place / np.linalg.norm(place, axis=1, keepdims=True)

    def ring(name: str, deviation: Array | float, dash: str, color: int) -> Curve:
        xy = m_to_mm(around * (path.radius + _AMPLIFIED * np.asarray(deviation, float))[..., None])
        return Curve(name, xy[:, 0], xy[:, 1], dash, color)

    def run(name: str, log: LoopLog, color: int) -> Curve:
        even = uniform_filter1d(across(path, np.asarray(log.seen)), _SAMPLES, mode="nearest")
        return ring(name, even[pick], "solid", color)

    flat = np.zeros(len(pick))
    curves = (
        ring("programmed", flat, "dot", 5),
        ring("0.2 mm outside", flat + _RING, "dot", 5),
        ring("0.2 mm inside", flat - _RING, "dot", 5),
        run("no correction (a)", study.variant("none").circle, 3),
        run("published law (b)", study.variant("published").circle, 0),
        run("all that does better", study.variants[-1].circle, 2),
    )
    return LineChart(
        "six",
        "Circle with amplified errors (Figure 6)",
        f"Deviations {_AMPLIFIED:.0f} times as large; dotted rings are 0.2 mm apart. As the tracker sees it, "
        f"averaged over {_SAMPLES} cycles.",
        "x [mm]",
        "y [mm]",
        curves,
    )


def _figure_7(study: TrackerStudy) -> LineChart:
    path = study.paths[1]
    way = m_to_mm(path.radius * np.unwrap(np.arctan2(*(np.asarray(path.wanted)[:, :2] - path.center[:2]).T[::-1])))
    curves = []
    for key in ("none", "published", "ahead"):
        v = study.variant(key)
        off = np.abs(across(path, np.asarray(v.circle.error)))[path.moving]
        curves.append(Curve(_SHORT[key], way[path.moving], m_to_mm(off), "solid", _COLOR[key]))
    return LineChart(
        "seven",
        "Circle, absolute path errors (Figure 7)",
        "In truth, without the tracker's noise. With the published law an even deviation is left: the lag's direction turns with "
        f"the path, and the loop follows {study.case.law.cycle_s / study.case.law.gain:g} s (cycle / K) behind it.",
        "way along the circle [mm]",
        "deviation [mm]",
        tuple(curves),
    )


def _gain(study: TrackerStudy) -> LineChart:
    c = study.choice
    fine = np.isfinite(c.expected).all(axis=1)
    tried = np.array(study.tried)
    curves = (
        Curve("square, expected", c.gains[fine], m_to_mm(c.expected[fine, 0]), "solid", 0),
        Curve("circle, expected", c.gains[fine], m_to_mm(c.expected[fine, 1]), "solid", 2),
        Curve("circle, simulated", tried[:, 0], m_to_mm(tried[:, 1]), "dash", 3),
        Curve("part of the noise", c.gains[fine], m_to_mm(np.sqrt(3.0) * c.noise[fine]), "dot", 5),
    )
    return LineChart(
        "gain",
        "What each gain lets one expect",
        "Root mean square of the tool's distance to its set-point, from the runs without correction alone. Chosen: "
        f"{c.chosen:g}, the least within the bounds on peak and margin.",
        "gain K",
        "distance, rms [mm]",
        curves,
        True,
    )


def _laps(study: TrackerStudy) -> LineChart:
    curves = []
    for k, learning in enumerate(study.learning):
        lap = np.arange(len(learning.laps), dtype=float)
        for j, test in enumerate(("square", "circle")):
            rms = np.array([both[j].tool.rms for both in learning.laps])
            curves.append(Curve(f"{learning.name}, {test}", lap, m_to_mm(rms), ("solid", "dash")[j], 3 * k))
    return LineChart(
        "laps",
        "Learning over repeated laps",
        "Root mean square of the tool's distance to its set-point. Lap 0 has learned nothing yet. The published law learns "
        "down to its own bias: the measurement is compared with a later set-point.",
        "lap",
        "distance, rms [mm]",
        tuple(curves),
        True,
    )


def _close(study: TrackerStudy) -> tuple[LineChart, ...]:
    """A corner of the square and a reversal on the circle, looked at closely."""
    square = study.paths[0]
    corner = int(square.corners[1])
    turns = study.variant("none").of_circle.reversals
    cycle = study.case.law.cycle_s

    def curves(at: int, which: str) -> tuple[Curve, ...]:
        part = slice(at + round(_WINDOW[0] / cycle), at + round(_WINDOW[1] / cycle))
        out = []
        for v in study.variants:
            if v.key not in _SHORT:
                continue
            log = v.square if which == "square" else v.circle
            error = np.asarray(log.error)[part]
            y = np.linalg.norm(error[:, :3], axis=1)
            if which == "circle":
                y = across(log.run.path, np.asarray(log.error))[part]
            t = np.asarray(cycle * np.arange(len(error)) + _WINDOW[0], float)
            out.append(Curve(_SHORT[v.key], t, m_to_mm(y), "solid", _COLOR[v.key]))
        return tuple(out)

    at_corner = LineChart(
        "corner",
        "At the square's first corner",
        "Distance from the set-point, in truth.",
        "time from the corner [s]",
        "distance [mm]",
        curves(corner, "square"),
    )
    if not turns:
        return (at_corner,)
    turn = turns[len(turns) // 2]
    joints = " and ".join(f"A{i + 1}" for i in sorted(turn.axes))
    return (
        at_corner,
        LineChart(
            "reversal",
            f"Where {joints} turn round on the circle",
            "Deviation from the circle, outwards up, in truth.",
            "time from the reversal [s]",
            "error [mm]",
            curves(turn.cycle, "circle"),
        ),
    )
