"""A dwell by either of its names is one of the program's, between the two points where the file has it."""

from __future__ import annotations

from pathlib import Path

import pytest

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import EventKind
from camrob.witness.cl import read_story
from camrob.witness.happenings import Kind

FILE = "UNITS/MM\nLOADTL/1\nSPINDL/1200,RPM,CLW\nFEDRAT/100,MMPM\nGOTO/0,0,10\nGOTO/0,0,0\n{}\nGOTO/10,0,0\nSPINDL/OFF\nFINI\n"


@pytest.mark.parametrize(
    ("word", "seconds"), [("DELAY/2.5", 2.5), ("DWELL/2.5", 2.5), ("DWELL/REV,10", 0.5), ("DWELL / 10, REV", 0.5)]
)
def test_a_dwell_is_read_alike_by_both(tmp_path: Path, word: str, seconds: float) -> None:
    (tmp_path / "a.apt").write_text(FILE.format(word))
    toolpath = read_toolpath(tmp_path / "a.apt")
    (event,) = [e for r in toolpath.regions for e in r.events if e.kind is EventKind.DWELL]
    assert event.value == pytest.approx(seconds, abs=1e-12) and event.line == 7
    assert not [f for f in toolpath.findings if f.code == "unknown-word"]
    (told,) = [e for e in read_story(tmp_path / "a.apt").events if e.kind == Kind.DWELL]
    assert told.value == pytest.approx(seconds, abs=1e-12)


def test_a_dwell_without_a_time_is_refused_by_its_name(tmp_path: Path) -> None:
    (tmp_path / "a.apt").write_text(FILE.format("DWELL/OFF"))
    with pytest.raises(ToolpathError, match="DWELL/OFF is no time"):
        read_toolpath(tmp_path / "a.apt")
    assert read_story(tmp_path / "a.apt").gaps
