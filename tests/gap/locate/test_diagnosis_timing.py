"""What a person reads of timing, of regimes withheld, and of each effect's before and after."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gap_cases import kr15
from rich.console import Console
from summary_samples import diagnosis_summary
from test_gap_program import raster
from test_gap_sizes import summary as two_effects
from test_gap_timing import held, rows, run

from camrob.gap.diagnose import diagnose
from camrob.gap.diagnosis import Diagnosis
from camrob.measurement.log import MeasurementLog
from camrob.report.diagnosis.page import diagnosis_report
from camrob.report.diagnosis.terminal_text import render_diagnosis
from camrob.report.diagnosis.times import timing_section, timing_texts
from camrob.report.diagnosis.withheld import careful_text, regimes_table, regimes_text, sizes_table


@cache
def paused() -> Diagnosis:
    return diagnose([held(150, 3.0)], kr15(), programs=[raster(4.0)])


def regime(what: str, before: float, after: float, *, worse: bool = False) -> dict[str, Any]:
    shrink = 1.0 - after / before
    return {
        "regime": "track",
        "what": what,
        "samples": 500,
        "rms_before_mm": before,
        "rms_after_mm": after,
        "shrink": shrink,
        "shrink_interval": [shrink - 0.05, shrink + 0.05],
        "doubt_mm": 0.004,
        "worse": worse,
    }


def test_a_pause_is_reported_in_the_terminal_and_on_the_page() -> None:
    (line,) = timing_texts(paused().summary)
    assert "a pause of 3.0 s at line" in line
    assert "more than the virtual controller" in line
    console = Console(width=80, record=True)
    with console.capture() as captured:
        console.print(render_diagnosis(paused().summary))
    assert "a pause of 3.0 s at line" in " ".join(captured.get().split())
    page = diagnosis_report(paused().summary, paused().paths)
    assert "<h2>Timing along the program</h2>" in page
    assert "a pause of 3.0 s at line" in page
    assert '<td class="n">pause</td>' in page


@pytest.mark.slow
def test_a_run_as_the_virtual_controller_has_it_is_called_so_and_a_slower_one_not() -> None:
    log = run()
    (same,) = timing_texts(diagnose([log], kr15(), programs=[raster(4.0)]).summary)
    assert "as the virtual controller does" in same
    slow = rows(log, np.arange(len(log)), 2.0 * log.t)
    (line,) = timing_texts(diagnose([slow], kr15(), programs=[raster(4.0)]).summary)
    assert "100 % more than the virtual controller" in line or "101 % more" in line or "99 % more" in line
    assert "the programmed speed is not what was run" in line
    assert "mostly 50 % of it" in line or "mostly 49 % of it" in line


@pytest.mark.slow
def test_a_log_without_a_program_has_no_section_on_timing() -> None:
    summary = diagnosis_summary(two_effects())
    assert timing_texts(summary) == []
    assert timing_section(summary) == ""


def test_regimes_are_told_from_the_least_to_the_most_and_harm_plainly() -> None:
    regimes = [regime("E1 below 3 mm", 0.4, 0.1), regime("E1 above 9 mm", 0.4, 0.04)]
    text = regimes_text(diagnosis_summary(together={"regimes_withheld": regimes}))
    assert "shrinks by 75 % (E1 below 3 mm) to 90 % (E1 above 9 mm)" in text
    assert "worse" not in text
    harmful = regime("speed above <b>9</b> mm/s", 0.3, 0.6, worse=True)
    summary = diagnosis_summary(together={"regimes_withheld": [*regimes, harmful]})
    assert "predicts worse than nothing on speed above <b>9</b> mm/s, 0.300 → 0.600 mm" in regimes_text(summary)
    table = regimes_table(summary)
    assert table.count("worse than nothing") == 1
    assert "<b>9</b>" not in table
    assert regimes_text(diagnosis_summary()) == regimes_table(diagnosis_summary()) == ""


@pytest.mark.slow
def test_what_makes_it_worse_on_withheld_samples_is_said() -> None:
    figures = dict(two_effects())
    assert careful_text(diagnosis_summary(figures)) == ""
    entry = dict(figures["effects"][0])
    worse = {
        **entry["added_last"],
        "rms_before_mm": 0.08,
        "rms_after_mm": 0.11,
        "shrink": -0.375,
        "shrink_interval": [-0.5, -0.2],
    }
    figures["effects"] = [{**entry, "added_last": worse}]
    figures["together"] = {**figures["together"], "left_aside": 250}
    said = careful_text(diagnosis_summary(figures))
    assert f"adding {entry['effect'].replace('_', ' ')} last makes it worse there, 0.080 → 0.110 mm" in said
    assert "250 samples are left out" in said
    figures["together"] = {**figures["together"], "shrink": -0.2, "rms_before_mm": 0.1, "rms_after_mm": 0.12}
    assert "all together leave more than there was" in careful_text(diagnosis_summary(figures))
    figures["effects"] = []
    assert careful_text(diagnosis_summary(figures)) == ""


def test_the_page_holds_every_effect_alone_and_added_last_with_tails() -> None:
    table = sizes_table(diagnosis_summary(two_effects()))
    assert table.count("alone") == table.count("added last") == 2
    assert "<b>backlash</b>" in table
    assert "<b>together</b>" in table
    for heading in ("rms", "95 %", "worst", "shrinks by (90 % interval)"):
        assert heading in table
    assert "the instrument" in table


def test_a_log_s_name_stays_text() -> None:
    log = held(150, 3.0)
    named = MeasurementLog(log.columns, log.info, Path("<script>x</script>\x1b[31m.csv"))
    found = diagnose([named], kr15(), programs=[raster(4.0)])
    assert "<script>x" not in timing_section(found.summary)
    console = Console(width=80)
    with console.capture() as captured:
        console.print(render_diagnosis(found.summary))
    assert "\x1b[31m.csv" not in captured.get()
