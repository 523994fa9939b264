"""Tables of a report's page: numbers stay whole, words in a number's place run on in lines."""

from __future__ import annotations

import re

from camrob.report.page.parts import table
from camrob.report.place.page import place_report
from camrob.summaries.place_summary import Placement, PlaceSummary

LONG = "the work of the tool is out of reach at line 361, A2 lacks 3.2 degrees"


def _sort_of(cell: str, html: str) -> str:
    found = re.search(r'<td class="(\w+)">' + re.escape(cell) + "</td>", html)
    assert found is not None, html
    return found[1]


def test_words_in_a_number_s_place_may_break_and_numbers_may_not() -> None:
    html = table(("what", "value", "allowed"), [["a", LONG, "-1,234.567 ± 0.123 mm/s"]])
    assert _sort_of(LONG, html) == "text"
    assert _sort_of("-1,234.567 ± 0.123 mm/s", html) == "n"


def test_a_cell_is_as_long_as_it_is_read() -> None:
    marked = '<a href="a_long_way_to_some_place/diagnosis.html">0.12&nbsp;mm</a>'
    assert _sort_of(marked, table(("what", "value"), [["a", marked]])) == "n"


def test_what_stands_against_a_placement_runs_on_in_lines() -> None:
    place = (0.0, 0.0, 200.0, 0.0, 0.0, 0.0)
    now = Placement(part_in_base=place, inv_kf_bound_mean=0.7, inv_kf_bound_min=0.6, standing=LONG, trial=None)
    summary = PlaceSummary(
        program="p",
        cell="c",
        placements=81,
        in_reach=60,
        table="plate",
        tried=3,
        files=("p.place.json",),
        now=now,
        best=now,
        stays=True,
        others=(),
        refused={},
    )
    html = place_report(summary, "")
    assert _sort_of(LONG, html) == "text"
    assert _sort_of("200.0", html) == "n"
