"""What the report shows of a program beside its figures: times, lines, the stock as it is cut, and other ways to resolve it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.checks.nearest import nearest_bodies
from camrob.controller.against import Coverage
from camrob.cutting.seen import seen_stock
from camrob.cutting.way import Way
from camrob.errors import InputError, JobError, SetupError
from camrob.jobs.files.inputs import JobInputs
from camrob.jobs.files.mounting import cutter_of
from camrob.jobs.files.said_lines import said_lines
from camrob.jobs.solving.plan_obstacles import collisions_at
from camrob.program.program_text import ProgramText
from camrob.redundancy.published.beginnings import resolve_published
from camrob.redundancy.published.weighting import even_weights
from camrob.redundancy.redundancy_map import RedundancyMap, redundancy_map
from camrob.redundancy.solution import Solution
from camrob.report.page.stock import StockOnPage
from camrob.report.page.timeline import Run
from camrob.report.post.paper_section import ALIKE, UNREVISED
from camrob.se3 import inverse

__all__ = ["map_shown", "other_ways", "run_shown", "stock_shown"]

Array = NDArray[np.float64]

COMPARED = 20_000  # points up to which the path is resolved in other ways, too
_SAID = 20_000  # points up to which the page carries the program's lines
_CARVED = 60_000  # points up to which the stock is cut for the picture: 7 500 take a second of processor
_LOOKED = 600  # places at which the nearest bodies are looked for
_OFF = 2e-5  # m that a move of the picture's cut may leave out of a path


def run_shown(
    folder: Path, text: ProgramText, coverage: Coverage, inputs: JobInputs, solution: Solution, at: Array
) -> Run:
    """The run of a program whose files lie in `folder`; `at` (N,): s at each point of the path."""
    path, lines = inputs.path, None
    if len(path) <= _SAID:
        motion = np.full(len(path), -1, np.int64)
        motion[path.of_toolpath] = coverage.motion
        lines = said_lines(folder, text, motion)
    if len(inputs.mounted) != 1:  # each tool has bodies of its own
        return Run(at, lines)
    looked = np.unique(np.linspace(0, len(path) - 1, _LOOKED).astype(np.int64))
    nearest = nearest_bodies(
        inputs.mounted[0].cell,
        np.asarray(solution.q)[looked],
        **inputs.bodies,
        tool=inputs.tool,
    )
    return Run(at, lines, nearest=nearest, nearest_at=looked)


def stock_shown(inputs: JobInputs, at: Array) -> StockOnPage | None:
    """The set-up's stock as the path cuts it, at times `at` (N,), or why it is shown uncut; None where the set-up has none."""
    if inputs.stock is None:
        return None
    path = inputs.path
    if len(inputs.mounted) != 1:
        return StockOnPage(inputs.stock, "the program changes its tool")
    try:
        cutter = cutter_of(inputs.tool, inputs.setup)
    except SetupError:
        return StockOnPage(
            inputs.stock, "no cutter has the shape that the set-up gives, a corner above half the diameter"
        )
    if cutter is None:
        return StockOnPage(inputs.stock, "the set-up does not give the cutter's diameter, length and corner")
    if len(path) > _CARVED:
        return StockOnPage(inputs.stock, f"the path has more than {_CARVED:,} points")
    part_T_tip = inverse(np.asarray(inputs.setup.base_T_part)) @ np.asarray(path.base_T_tip)
    way = Way.of(part_T_tip[:, :3, 3].copy(), part_T_tip[:, :3, 2].copy(), cutter, tolerance=_OFF)
    try:
        seen = seen_stock(inputs.stock, way.moves, at[way.kept[1:]])
    except InputError:  # it has no inside to cut
        return StockOnPage(inputs.stock, "its mesh is not closed")
    return StockOnPage(inputs.stock, "the program cuts none of it" if seen is None else seen)


def map_shown(inputs: JobInputs, solution: Solution) -> RedundancyMap | None:
    """The map of the freedoms; None where tools are changed, as each of them has its own. What touches is asked of planned
    postures alone: it takes as long as a whole post by the published method.
    """
    if len(inputs.mounted) != 1:
        return None
    path = inputs.path

    bodies = inputs if inputs.stock is None else replace(inputs, part=None)  # the part lies in its stock

    def touches(q: Array, point: NDArray[np.int64]) -> NDArray[np.bool_]:
        return np.asarray(collisions_at(bodies, path, q, point, path.cutting[point]).hit)

    return redundancy_map(inputs.cell, path, solution, touches if solution.method == "planned" else None)


def other_ways(inputs: JobInputs, solution: Solution) -> dict[str, Array]:
    """1/k_F (N,) of the same path resolved in other ways; a way that fails, and all of them for long paths, are left out."""
    if len(inputs.path) > COMPARED:
        return {}
    even = even_weights(inputs.cell)
    ways: dict[str, Callable[..., Solution]] = {"published method": resolve_published}
    if solution.method == "vjm":
        ways = {
            ALIKE: partial(resolve_published, weighting=even),
            UNREVISED: partial(resolve_published, revise=False),
        }
    others = {}
    for name, way in ways.items():
        with suppress(JobError):
            others[name] = np.concatenate(
                [
                    np.asarray(way(here.cell, here.path).inv_kf)
                    for here in (inputs.of_stretch(k, None) for k in range(len(inputs.path.stretches)))
                ]
            )
    return others
