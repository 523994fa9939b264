"""The bench that puts camrob's readers of programs and the witness's against each other, on its seeds and a few mutants."""

from __future__ import annotations

import random
import shutil
import sys
from pathlib import Path

import pytest

from camrob.witness.krl.functions import FUNCTIONS

BENCH = Path(__file__).resolve().parents[1] / "bench"


@pytest.fixture
def bench(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCH))
    import two_program_readers

    yield two_program_readers
    sys.modules.pop("two_program_readers", None)


@pytest.mark.parametrize("language", ["krl", "rapid"])
def test_its_programs_are_read_whole_and_alike_and_a_few_mutants_not_otherwise(bench, tmp_path, language):
    readings, rng = bench.Readings(language), random.Random(5)
    seeds = {path.name: path.read_text() for path in sorted((BENCH / "program_seeds" / language).iterdir())}
    assert len(seeds) > 1
    for name, text in seeds.items():
        (tmp_path / name).write_text(text)
        assert readings.compared(tmp_path / name) == ""
        for _ in range(8):
            (tmp_path / name).write_text(bench.mutated(text, rng, list(seeds.values())))
            assert readings.compared(tmp_path / name) in ("", "told")


def test_it_sees_where_they_differ(bench, tmp_path, monkeypatch):
    shutil.copy(BENCH / "program_seeds" / "krl" / "numbers.src", tmp_path)
    monkeypatch.setitem(FUNCTIONS, "SIN", (1, lambda x: 0.49))
    said = bench.Readings("krl").compared(tmp_path / "numbers.src")
    assert said.startswith("line ") and "tip differs by 2e-05" in said
