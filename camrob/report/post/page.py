"""The report of a post: one HTML page that needs nothing but itself."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.dynamics.torques import JointTorques
from camrob.findings import Finding
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.published.equilibrium import Equilibrium
from camrob.redundancy.redundancy_map import RedundancyMap
from camrob.redundancy.solution import Solution
from camrob.report.page.html import escape, page, plot_text
from camrob.report.page.parts import chart_place, page_body
from camrob.report.page.path_charts import (
    Along,
    Chart,
    axis_chart,
    conditioning_chart,
    external_chart,
    feed_chart,
    shown_charts,
)
from camrob.report.page.statements import Statement, statements_section
from camrob.report.page.stock import StockOnPage
from camrob.report.page.timeline import Run
from camrob.report.page.viewer import scene_data
from camrob.report.post.feed_sections import feed_section, torque_chart, torque_section
from camrob.report.post.map_section import map_chart
from camrob.report.post.paper_section import paper_statements
from camrob.report.post.plan_section import plan_section
from camrob.report.post.player_section import player_section
from camrob.report.post.sections import cards, made_from, regions_table, verdict, warnings_table
from camrob.report.post.weights_section import weights_along, weights_chart
from camrob.summaries.post_summary import PostSummary

__all__ = ["post_report"]

Array = NDArray[np.float64]

_BANDS = "Tinted stretches are the regions; what lies between them is travel through air."
_NO_BANDS = "There are too many regions to tint: hover over a curve to see where it is."
_NOTE = (
    "k<sub>F</sub> is the condition number of the bare arm's Jacobian at the mounting plate (Frobenius norm, "
    "lengths divided by the characteristic length): 1/k<sub>F</sub> is 0 in a singular posture."
)
_LINKED = "Zoom in one chart and all follow; click in a chart to bring the robot of the 3D view there."


class _Posted(NamedTuple):
    """What a section of the page may show."""

    summary: PostSummary
    cell: Cell
    path: ToolPathInBase
    solution: Solution
    findings: tuple[Finding, ...]
    names: Mapping[int, str]  # of the regions, by their index
    charts: tuple[Chart, ...]
    scene: Mapping[str, Any]  # of the player
    with_part: bool
    statements: tuple[Statement, ...]  # of the published method's paper


def _chart_places(posted: _Posted, *names: str) -> str:
    """The places of those of the named charts that have something to show."""
    return "\n".join(chart_place(chart) for chart in posted.charts if chart["id"] in names)


# the page from top to bottom: each entry gives its HTML, "" where it has nothing to show
_SECTIONS: tuple[Callable[[_Posted], str], ...] = (
    lambda p: verdict(p.summary, p.findings),
    lambda p: warnings_table(p.findings, p.names),
    lambda p: cards(p.summary, p.cell, p.path, threshold=p.cell.resolve.threshold),
    lambda p: player_section(p.cell, p.scene, with_part=p.with_part),
    lambda p: _chart_places(p, "conditioning", "map", "axes", "external"),
    lambda p: _chart_places(p, "feed"),
    lambda p: feed_section(p.summary.feed),
    lambda p: _chart_places(p, "torques"),
    lambda p: torque_section(p.summary.torques),
    lambda p: plan_section(p.summary.plan),
    lambda p: _chart_places(p, "weights"),
    lambda p: statements_section(p.statements) if p.statements else "",
    lambda p: regions_table(p.summary, p.path, p.solution, threshold=p.cell.resolve.threshold),
)


def post_report(
    summary: PostSummary,
    cell: Cell,
    path: ToolPathInBase,
    solution: Solution,
    *,
    run: Run,
    findings: Iterable[Finding],
    stock: StockOnPage | None = None,
    redundancy: RedundancyMap | None = None,
    part_mesh: Array | None = None,
    base_T_part: Array | None = None,
    comparison: Mapping[str, Array] | None = None,
    bound: Array | None = None,
    reached: Array | None = None,
    torques: tuple[NDArray[np.int64], JointTorques] | None = None,
) -> str:
    """The page for a posted program, as text.

    run: when the program is where, and what it says there. stock: as it is cut. redundancy: the map of the freedoms. part_mesh:
    the part's triangles (T, 3, 3), m, placed by base_T_part (4, 4). comparison: 1/k_F (N,) of other solutions of the same path
    by their names (the paper's Figure 10), NaN where they have none. bound: (N,) the highest 1/k_F that any posture reaches.
    reached: (N,) m/s while cutting; torques: points and what the axes need there. The same arguments give the same text. Raises
    ValueError where an array doesn't have the path's length.
    """
    others = {name: np.asarray(kf, float) for name, kf in (comparison or {}).items()}
    best = None if bound is None else np.asarray(bound, float)
    _demand_length(len(path), {"solution": solution.inv_kf, **others, **({} if best is None else {"bound": best})})
    names = {r.index: r.name or f"region {r.index}" for r in summary.regions}
    weighed = weights_along(cell, path, solution)
    charts = _charts(cell, path, solution, names, others, best) + _weights(cell, path, names, weighed)
    charts[1:1] = _map(cell, path, solution, names, redundancy)
    charts += _motion_charts(cell, path, names, reached, torques)
    scene = scene_data(
        cell,
        path,
        solution,
        names,
        run,
        stock=stock,
        part_mesh=part_mesh,
        threshold=cell.resolve.threshold,
        base_T_part=np.eye(4) if base_T_part is None else base_T_part,
    )
    posted = _Posted(
        summary,
        cell,
        path,
        solution,
        tuple(findings),
        names,
        tuple(charts),
        scene,
        with_part=part_mesh is not None,
        statements=paper_statements(cell, path, solution, weighed, others),
    )
    data = {
        "names": {str(index): plot_text(name) for index, name in names.items()},
        "charts": [{key: c[key] for key in ("id", "traces", "layout", "maps") if key in c} for c in charts],
        "scene": scene,
    }
    parts = (section(posted) for section in _SECTIONS)
    body = page_body(escape(summary.program), made_from(summary, cell), *parts, note=_NOTE)
    return page(f"{summary.program}: report", body, data)


def _demand_length(points: int, given: Mapping[str, Array]) -> None:
    for name, kf in given.items():
        if kf.shape != (points,):
            raise ValueError(f"1/k_F of {name!r} has shape {kf.shape}, the path has {points} points")


def _charts(
    cell: Cell,
    path: ToolPathInBase,
    solution: Solution,
    names: Mapping[int, str],
    comparison: Mapping[str, Array],
    bound: Array | None,
) -> list[Chart]:
    """The charts that have something to show, each with its id, title and caption."""
    along = Along.of(path, names)
    axis_values = cell.to_axis_values(solution.q)
    threshold = cell.resolve.threshold
    bands = _BANDS if along.banded else _NO_BANDS
    compared = " Dotted: the same path resolved in other ways, for comparison." if comparison else ""
    limited = "" if bound is None else " Dashed green: the best that any posture reaches at each point."
    return shown_charts(
        (
            "conditioning",
            "How well conditioned the arm is: 1/k<sub>F</sub>",
            conditioning_chart(along, solution, threshold=threshold, comparison=comparison, bound=bound),
            "The higher, the more evenly the arm moves and pushes in all directions. Look for stretches below the red line "
            f"({threshold:g}): there the arm is close to a singular posture.{limited}{compared} {bands} {_LINKED}",
        ),
        (
            "axes",
            "Axes of the arm against their limits",
            axis_chart(cell, along, axis_values),
            "Each chart spans the axis's whole range of travel; the red ends are beyond its limits. Look for a curve "
            f"that comes near the red, and for steps: a step while cutting would be a jump of the robot. {bands} The ways from "
            "and to HOME, which the card above counts too, are not shown.",
        ),
        (
            "external",
            f"External axes: {', '.join(escape(n) for n in cell.external_names)}",
            external_chart(cell, along, axis_values),
            "Look for smooth curves while cutting. A step between regions is a posture revision: table and track move "
            f"while the cutter keeps its pose in the part. {bands}",
        ),
    )


def _map(
    cell: Cell, path: ToolPathInBase, solution: Solution, names: Mapping[int, str], found: RedundancyMap | None
) -> list[Chart]:
    if found is None:
        return []
    chart, caption = map_chart(cell, Along.of(path, names), solution, found, threshold=cell.resolve.threshold)
    title = "The map of the redundancy: what the spare freedoms could have been"
    return shown_charts(("map", title, chart, caption))


def _weights(cell: Cell, path: ToolPathInBase, names: Mapping[int, str], found: Equilibrium | None) -> list[Chart]:
    """What weighed the joints, where the published method made the postures and an engine weighs any of them."""
    if found is None or not cell.resolve.joint_engine.weights:
        return []
    chart, caption = weights_chart(cell, Along.of(path, names), path, found)
    title = f"How strongly each axis is held to its reference posture ({escape(cell.resolve.joint_engine.file)})"
    return shown_charts(("weights", title, chart, caption))


def _motion_charts(
    cell: Cell,
    path: ToolPathInBase,
    names: Mapping[int, str],
    reached: Array | None,
    torques: tuple[NDArray[np.int64], JointTorques] | None,
) -> list[Chart]:
    """Feed and torques."""
    along = Along.of(path, names)
    bands = _BANDS if along.banded else _NO_BANDS
    return shown_charts(
        (
            "feed",
            "Feed along the path",
            feed_chart(along, path, reached),
            "Feed at the tool tip while cutting, as programmed and as it is reached on the way to each point; gaps are moves "
            f"through air, which run at the cell's speed. Where time is lost, and to what, stands below. {bands}",
        ),
        (
            "torques",
            "Torques of the arm along the path",
            None if torques is None else torque_chart(cell, along, *torques),
            f"Solid: with the motion while cutting; dotted: gravity alone, as in air. {bands}",
        ),
    )
