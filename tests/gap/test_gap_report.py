"""What a person reads of a diagnosis: the sentence, the terminal's summary, the page."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import pytest
from gap_cases import kr15, simulated
from rich.console import Console
from test_gap_effects import plant_play
from test_gap_program import measured, raster

from camrob.gap.diagnose import diagnose
from camrob.gap.diagnosis import Diagnosis
from camrob.measurement.log import MeasurementLog
from camrob.report.diagnosis.page import diagnosis_report
from camrob.report.diagnosis.sentences import sentence
from camrob.report.diagnosis.terminal_text import render_diagnosis
from camrob.summaries.base import Summary
from camrob.summaries.diagnosis_summary import DiagnosisSummary

SIGMA = 0.02


@cache
def play() -> Diagnosis:
    return diagnose([simulated(plant_play, sigma_mm=SIGMA)], kr15())


@pytest.mark.slow
def test_the_sentence_says_where_what_and_how_far_it_shrinks() -> None:
    said = sentence(play().summary)
    assert re.match(
        r"All of the gap \(0\.\d+ mm rms in the logs diagnosed\) sits between encoder and TCP "
        r"and reverses with A2's direction: backlash of A2, ",
        said,
    )
    assert re.search(r"backlash of A2, 0\.0(3|29\d|30\d) degrees \(9\d % sure\)", said)
    assert re.search(
        r"On stretches that took no part, adding it takes the gap from 0\.\d+ mm to 0\.03\d mm; "
        r"the instrument's noise is 0\.03\d mm\.$",
        said,
    )


@pytest.mark.slow
def test_the_sentence_of_a_rounding_and_of_no_gap() -> None:
    rounded = sentence(diagnose([measured(raster(4.0))], kr15(), programs=[raster(4.0)]).summary)
    assert "sits between program and set-point" in rounded
    assert re.search(r"Between program and set-point: corner rounding, (4\.00|3\.99|4\.01) mm \(9\d % sure\)", rounded)
    none = sentence(diagnose([simulated(sigma_mm=SIGMA)], kr15()).summary)
    assert re.match(r"There is no gap: .*encoder and TCP .* within the noise \(0\.0\d+ mm, as (reported|found)\)", none)


def test_the_terminal_s_summary_fits_and_says_the_same() -> None:
    console = Console(width=80, record=True)
    with console.capture() as captured:
        console.print(render_diagnosis(play().summary))
    text = captured.get()
    assert max(len(line) for line in text.splitlines()) <= 80
    for words in ("backlash", "by stage", "run next", "has no constant", "to do", "reverses with A2's direction"):
        assert words in " ".join(text.split())


def test_the_page_holds_every_part_and_begins_with_what_where_and_what_to_do() -> None:
    page = diagnosis_report(play().summary, play().paths)
    assert (
        '<div class="verdict lines good"><strong>Explained</strong><dl><div><dt>What</dt><dd>Backlash of A2 (9' in page
    )
    heads = (
        "What to do",
        "Next experiment",
        "In full",
        "The path, coloured by the error",
        "Where the gap lies",
        "What the logs lack, and what that costs",
        "Causes",
        "How far it shrinks, on data that took no part",
        "Error along",
        "What remains, besides the noise",
        "Worst stretches",
        "Where, in numbers",
    )
    at = [page.index(f"<h2>{head}") for head in heads]
    assert at == sorted(at)
    for name in (
        "space-before",
        "space-after",
        "by-stage",
        "by-axis",
        "by-regime",
        "shrunk",
        "steps",
        "along-0",
        "residual",
    ):
        assert f'id="{name}"' in page
    assert page.index("sits between encoder and TCP") < page.index("space-before")
    assert "Together" in page
    assert not re.search(r'<(script|link|img)[^>]*(src|href)="http', page)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["<script>alert(1)</script>.csv", "a\x1b[31mred.csv"])
def test_a_log_s_name_never_becomes_part_of_the_page_or_the_terminal(name: str) -> None:
    log = simulated(plant_play, sigma_mm=SIGMA)
    found = diagnose([MeasurementLog(log.columns, log.info, Path(name))], kr15())
    page = diagnosis_report(found.summary, found.paths)
    assert "<script>alert" not in page
    console = Console(width=80)
    with console.capture() as captured:
        console.print(render_diagnosis(found.summary))
    assert "\x1b[31mred" not in captured.get()


def without_field(value: object, path: str = "") -> list[str]:
    """Keys of a summary, within and below it, that no field is there for."""
    if isinstance(value, Summary):
        own = [f"{path}.{key}" for key in getattr(value, "further", ())]
        return own + [f for n in value.__dataclass_fields__ for f in without_field(getattr(value, n), f"{path}.{n}")]
    inside = value.values() if isinstance(value, Mapping) else value if isinstance(value, tuple) else ()
    return [f for one in inside for f in without_field(one, path)]


@pytest.mark.slow
def test_every_key_of_a_diagnosis_has_a_field_and_stands_where_it_stood() -> None:
    rounded = diagnose([measured(raster(4.0))], kr15(), programs=[raster(4.0)])
    nothing = diagnose([simulated(sigma_mm=SIGMA)], kr15())
    for found in (play(), rounded, nothing):
        summary = found.summary.to_json()
        read = DiagnosisSummary.from_json(summary)
        assert without_field(read) == [], "give these keys fields in camrob/summaries/diagnosis_summary.py"
        assert json.dumps(read.to_json()) == json.dumps(summary)
