"""A dialect brings words of its own: they do what it says, in its files alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from camrob.errors import ToolpathError
from camrob.toolpath.apt.dialects.plain_apt import APT
from camrob.toolpath.apt.dialects.registry import DIALECTS
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import EventKind

FILE = "UNITS/MM\nLOADTL/1\nSPINDL/1000,RPM,CLW\nFEDRAT/100,MMPM\nGOTO/0,0,10\nBREATHE/2.5\nGOTO/10,0,10\nSPINDL/OFF\nFINI\n"


def breathe(machine, statement) -> None:
    """BREATHE/seconds: the tool rests."""
    if not statement.numbers:
        raise ToolpathError("BREATHE needs a time", hint="give it in seconds")
    machine.event(EventKind.DWELL, statement.numbers[0], "", statement.line)


@pytest.fixture
def breathing(monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setitem(DIALECTS, "breathing", replace(APT, name="breathing", words={"BREATHE": breathe}))
    return "breathing"


def read(folder: Path, text: str, dialect: str):
    file = folder / "part.apt"
    file.write_text(text)
    return read_toolpath(file, dialect=dialect)


def test_the_word_does_what_its_dialect_says(tmp_path: Path, breathing: str) -> None:
    toolpath = read(tmp_path, FILE, breathing)
    assert [e.value for r in toolpath.regions for e in r.events if e.kind is EventKind.DWELL] == [2.5]
    assert not [f for f in toolpath.findings if f.code == "unknown-word"]


def test_other_dialects_do_not_know_it(tmp_path: Path) -> None:
    toolpath = read(tmp_path, FILE, "apt")
    assert not [e for r in toolpath.regions for e in r.events if e.kind is EventKind.DWELL]
    assert [f.line for f in toolpath.findings if f.code == "unknown-word"] == [6]


def test_what_can_not_be_read_is_refused_where_it_stands(tmp_path: Path, breathing: str) -> None:
    with pytest.raises(ToolpathError, match="needs a time") as refused:
        read(tmp_path, FILE.replace("BREATHE/2.5", "BREATHE"), breathing)
    assert refused.value.line == 6


def test_a_dialect_may_mean_something_else_by_a_word_that_all_have(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(DIALECTS, "other", replace(APT, name="other", words={"DELAY": lambda machine, statement: None}))
    text = FILE.replace("BREATHE", "DELAY")
    assert not [e for r in read(tmp_path, text, "other").regions for e in r.events if e.kind is EventKind.DWELL]
    assert [e for r in read(tmp_path, text, "apt").regions for e in r.events if e.kind is EventKind.DWELL]
