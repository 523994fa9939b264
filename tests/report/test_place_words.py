"""What `camrob place` says in the terminal."""

from __future__ import annotations

import io
import re
from dataclasses import replace

import numpy as np
from rich.console import Console

from camrob.report.place.page import place_report
from camrob.report.place.place_map import place_map
from camrob.report.place.terminal_text import render_place
from camrob.summaries.place_summary import Placement, PlaceSummary, PlaceTrial


def _placement(x: float, mean: float | None, standing: str = "followed") -> Placement:
    trial = None
    if mean is not None:
        trial = PlaceTrial(
            method="vjm",
            points=90,
            inv_kf_mean=mean,
            inv_kf_min=mean - 0.05,
            collisions_checked=x < 50.0,
            clearance_min_mm=12.5,
        )
    place = (x, 0.0, 200.0, 0.0, 0.0, 0.0)
    return Placement(part_in_base=place, inv_kf_bound_mean=0.7, inv_kf_bound_min=0.6, standing=standing, trial=trial)


def _said(**given: object) -> str:
    now = _placement(0.0, 0.628)
    of = {"now": now, "best": now, "stays": True, "others": (), "refused": {}} | given
    summary = PlaceSummary(
        program="p", cell="c", placements=81, in_reach=60, table="plate", tried=3, files=("p.place.json",), **of
    )
    said = io.StringIO()
    Console(file=said, width=120).print(render_place(summary))
    return said.getvalue()


def test_a_proposal_is_a_line_for_the_set_up_beside_the_place_as_it_is() -> None:
    others = (_placement(60.0, 0.61), _placement(-20.0, None, "touches the table"))
    text = _said(best=_placement(-30.0, 0.674), stays=False, others=others, refused={"hangs over": 21})
    assert "Better here: part_in_base = [-30, 0, 200, 0, 0, 0]" in text
    lines = [line.split() for line in text.splitlines()]
    assert ["as", "it", "is", "0.628", "0.578", "12.5", "0", "0", "200", "0", "0", "0"] in lines
    assert any(line[:2] == ["proposed", "0.674"] for line in lines) and "not checked" in text
    assert "(touches the table)" in text and "refused: hangs over 21" in text


def test_the_border_of_the_search_and_a_table_without_edge_are_said() -> None:
    text = _said(best=_placement(-30.0, 0.674), stays=False, border=("X", "Y"))
    assert "at the border of the search along X and Y: a better place may lie beyond, widen --x and --y" in text
    assert "border" not in _said()


def test_a_part_that_stays_is_said_to() -> None:
    text = _said()
    assert "best where it is" in text and "proposed" not in text and "refused" not in text


def test_the_page_says_what_room_a_better_place_costs() -> None:
    now, near = _placement(0.0, 0.628), _placement(-30.0, 0.674)
    closer = replace(near, trial=replace(near.trial, clearance_min_mm=3.0))
    common = {
        "program": "p",
        "cell": "c",
        "placements": 81,
        "in_reach": 60,
        "table": "plate",
        "tried": 3,
        "files": ("p.place.json",),
    }
    for best, said in ((closer, True), (near, False)):
        summary = PlaceSummary(now=now, best=best, stays=False, others=(), refused={}, **common)
        assert ("The least clearance falls from 12.5 to 3.0 mm." in place_report(summary, "<svg></svg>")) is said


def test_a_map_grows_lighter_from_the_least_to_the_most_and_calls_none_bad() -> None:
    """By lightness alone, which print and every eye tells; red means a bad posture elsewhere, and the least here need be none."""
    xyz = np.array([[10.0 * k, 0.0, 200.0] for k in range(5)])
    drawn = place_map("t", xyz, np.array([0.4, 0.5, 0.0, 0.6, 0.7]), 4, 0, [""] * 5)
    colors = [[int(c[i : i + 2], 16) for i in (0, 2, 4)] for c in re.findall(r'fill="#(\w{6})"><title>', drawn)]
    light = np.array(colors) @ [0.2126, 0.7152, 0.0722]
    assert len(light) == 4 and np.all(np.diff(light) > 20.0) and not any(r > 1.5 * max(g, b) for r, g, b in colors)
    assert re.search(r">0\.400<.*>0\.700: mean and lowest", drawn, re.DOTALL)
