"""Slips of a command line that were silent, or answered at length: one short line says what and what to do."""

from __future__ import annotations

from pathlib import Path

import pytest

from camrob.cli.app import run

ROOT = Path(__file__).resolve().parents[3]
ENGRAVING = ROOT / "toolpaths" / "engraving" / "engraving.cls"
PROGRAM = ROOT / "toolpaths" / "engraving" / "golden" / "engraving.src"
CELL = ["--cell", str(ROOT / "cells" / "kr15_track_table")]


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (["batch", str(ENGRAVING)], "is no list of jobs; give a JOBS.toml"),
        (["post", str(ENGRAVING), *CELL, "--name", 3000 * "x"], "xxx...' can't be a KRL module"),
        (["verify", str(PROGRAM), *CELL, "--clamping", "top"], "--clamping says what of a CL file the program does"),
        (["verify", str(PROGRAM), *CELL, "--begin", "9"], "--begin says what of a CL file the program does"),
        (["cell", "from-urdf", str(ENGRAVING)], "is no URDF: it is not well-formed XML"),
        (["post", str(ENGRAVING), *CELL, "--method", "fast"], "'fast' is not one of 'vjm', 'planned'"),
        (["diagnose", *CELL, "--log", str(ENGRAVING)], "or name it as here: t, x y z,"),
    ],
)
def test_a_slip_is_one_short_line(
    command: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    out = [] if command[0] in ("verify", "cell") else ["--out", str(tmp_path / "out")]
    assert run([*command, *out]) == 2
    shown = capsys.readouterr().err.strip().splitlines()[-1]
    assert said in shown and "Value error" not in shown and len(shown) < 500
    assert not (tmp_path / "out").exists()
