"""The scripts of `examples/` do what they say."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def example(name: str) -> ModuleType:
    """One of the scripts, loaded without being run."""
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_each_example_is_run_here() -> None:
    assert {f.stem for f in EXAMPLES.glob("*.py")} == {"post_a_part", "diagnose_a_log"}


def test_post_a_part(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    example("post_a_part").main(tmp_path)
    said = capsys.readouterr().out
    assert "1/k_F: mean 0.628, lowest 0.580" in said
    assert "every motion judged by the witness: yes" in said
    assert (tmp_path / "engraving.src").is_file() and (tmp_path / "engraving.html").is_file()


def test_diagnose_a_log(tmp_path: Path) -> None:
    script = example("diagnose_a_log")
    found = script.diagnosed(tmp_path)
    named = {effect.effect: effect.parameters for effect in found.effects}
    assert named.keys() == {"latency", "corner_rounding"}  # what was planted, and what the controller always does
    assert named["latency"]["delay_s"].value == pytest.approx(script.CYCLE / 1e3, rel=0.01)
    assert found.together.rms_after_mm < 1.1 * script.NOISE * 3**0.5 < found.gap.rms_mm
