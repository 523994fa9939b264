"""Programs of controls drawn at random (tests/bench/drawn), read by camrob and by the witness, held to the reckoned path."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "bench"))

from control_programs import outcome
from drawn import CONTROLS


@pytest.mark.slow(after=2 * len(CONTROLS))
@pytest.mark.parametrize("control", sorted(CONTROLS))
@pytest.mark.parametrize("seed", range(6))
def test_a_drawn_program_is_read_as_it_was_reckoned(tmp_path: Path, control: str, seed: int) -> None:
    kind, text, found = outcome(control, seed, tmp_path)
    assert kind == "read alike", "\n".join([*found, text])
