"""What a file asks for and the cell has no hook for: refused by the hook's name, or left out and said; never called a fault."""

from __future__ import annotations

from pathlib import Path

import pytest
from process_story import cell_with, posted

from camrob.errors import CellError, JobError

FILE = (
    "UNITS/MM\nLOADTL/1\nSPINDL/3000,RPM,CLW\nCOOLNT/ON\nFEDRAT/500,MMPM\nRAPID\nGOTO/0,0,50\nGOTO/0,0,2\nGOTO/20,0,2\n"
    "RAPID\nGOTO/20,0,50\nSTOP\nRAPID\nGOTO/0,0,50\nGOTO/0,0,1\nGOTO/20,0,1\nRAPID\nGOTO/20,0,50\nSPINDL/OFF\nFINI\n"
)
GONE = {
    "stop": (
        r"stops for the operator, for which cell kr15_track_table has no hook; add stop to \[controller.hooks\]",
        12,
    ),
    "spindle_off": ("no hook that ends it; add spindle_off", 3),
    "coolant_off": ("no hook that ends it; add coolant_off", 4),
    "coolant_on": ("switches the coolant on, for which cell kr15_track_table has no hook; add coolant_on", 4),
}


@pytest.mark.parametrize("hook", GONE)
def test_what_could_only_half_be_done_is_refused_by_the_hook(tmp_path: Path, hook: str) -> None:
    said, line = GONE[hook]
    with pytest.raises(JobError, match=said) as refused:
        posted(tmp_path, "part.apt", FILE, cell=cell_with(tmp_path, (rf"^{hook} = .*\n", "")))
    assert refused.value.line == line


def test_coolant_that_a_cell_does_not_have_is_left_out_and_said(tmp_path: Path) -> None:
    cell = cell_with(tmp_path, (r"^coolant_on = .*\n", ""), (r"^coolant_off = .*\n", ""))
    made = posted(tmp_path, "part.apt", FILE, cell=cell)
    assert "no-hook" in [w.code for w in made.summary.warnings]


@pytest.mark.parametrize("lines", ["[]", '[""]', '["  "]'])
def test_a_hook_that_holds_no_line_is_a_mistake_of_the_cell(tmp_path: Path, lines: str) -> None:
    with pytest.raises(CellError, match=r"cell\.toml:\d+: controller: hook stop holds no line"):
        posted(tmp_path, "part.apt", FILE, cell=cell_with(tmp_path, (r"^stop = .*", f"stop = {lines}")))
