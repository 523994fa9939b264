"""Faults put into the code by hand: each still fits its source, and of none a wrong program is released."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BENCH = ROOT / "tests" / "bench"


def test_each_fault_fits_one_place_of_its_source() -> None:
    rows = tomllib.loads((BENCH / "mutation" / "by_hand.toml").read_text(encoding="utf-8"))["fault"]
    texts = {row["file"]: (ROOT / "camrob" / row["file"]).read_text(encoding="utf-8") for row in rows}
    assert [row["name"] for row in rows if texts[row["file"]].count(row["old"]) != 1] == []
    assert len({row["name"] for row in rows}) == len(rows) > 150


@pytest.mark.slow
def test_no_wrong_program_comes_of_any() -> None:
    done = subprocess.run([sys.executable, str(BENCH / "code_faults.py")], capture_output=True, text=True, check=False)
    assert done.returncode == 0, "\n".join(line for line in done.stdout.splitlines() if "!!" in line)
