"""The scripts and notebooks of `examples/` do what they say."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from matplotlib import pyplot

from camrob.kinematics.kernels import chain_arrays, inverse_kf_many

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
NOTEBOOKS = ("post_a_part", "free_axes", "diagnose_a_log")


def example(name: str) -> ModuleType:
    """One of the scripts, loaded without being run."""
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def cells(name: str) -> list[dict[str, Any]]:
    return json.loads((EXAMPLES / f"{name}.ipynb").read_text(encoding="utf-8"))["cells"]


def test_each_example_is_run_here() -> None:
    assert {f.stem for f in EXAMPLES.glob("*.py")} == {"post_a_part", "diagnose_a_log"}
    assert {f.stem for f in EXAMPLES.glob("*.ipynb")} == set(NOTEBOOKS)


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_a_notebook_is_kept_without_what_it_printed(name: str) -> None:
    data = json.loads((EXAMPLES / f"{name}.ipynb").read_text(encoding="utf-8"))
    assert (data["nbformat"], data["nbformat_minor"]) == (4, 5)
    assert len({cell["id"] for cell in data["cells"]}) == len(data["cells"])
    for cell in data["cells"]:
        code = {"execution_count", "outputs"} if cell["cell_type"] == "code" else set()
        assert cell.keys() == {"cell_type", "id", "metadata", "source"} | code
        assert not cell.get("outputs") and cell.get("execution_count") is None
        assert cell["cell_type"] in ("code", "markdown")


@pytest.fixture
def shown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Runs a notebook's cells in one namespace, in a folder that looks like the repository: what its names then are."""
    for name in ("cells", "toolpaths"):
        (tmp_path / name).symlink_to(ROOT / name)
    (tmp_path / "examples").mkdir()
    monkeypatch.chdir(tmp_path / "examples")
    pyplot.switch_backend("Agg")
    monkeypatch.setattr(pyplot, "show", lambda: pyplot.close("all"))

    def run(name: str) -> dict[str, Any]:
        names: dict[str, Any] = {}
        for cell in cells(name):
            if cell["cell_type"] == "code":
                exec(compile("".join(cell["source"]), f"{name}.ipynb, {cell['id']}", "exec"), names)
        return names

    return run


def test_post_a_part(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    example("post_a_part").main(tmp_path)
    said = capsys.readouterr().out
    assert "1/k_F: mean 0.628, lowest 0.580" in said
    assert "every motion judged by the witness: yes" in said
    assert (tmp_path / "engraving.src").is_file() and (tmp_path / "engraving.html").is_file()


@pytest.mark.slow
def test_diagnose_a_log(tmp_path: Path) -> None:
    script = example("diagnose_a_log")
    found = script.diagnosed(tmp_path)
    named = {effect.effect: effect.parameters for effect in found.effects}
    assert named.keys() == {"latency", "corner_rounding"}  # what was planted, and what the controller always does
    assert named["latency"]["delay_s"].value == pytest.approx(script.CYCLE / 1e3, rel=0.01)
    assert found.together.rms_after_mm < 1.1 * script.NOISE * 3**0.5 < found.gap.rms_mm


def test_the_notebook_that_posts(shown, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    names = shown("post_a_part")
    said = capsys.readouterr().out
    assert names["OUT"].is_relative_to(tmp_path)
    assert "lowest 0.580, mean 0.628" in said and "judged by the witness: True" in said
    assert min(names["inv_kf"]) == pytest.approx(names["summary"].conditioning.inv_kf_min, abs=1e-3)
    assert "part_in_base = [" in str(names["refused"]) and "left behind: False" in said


def test_the_notebook_of_free_axes(shown) -> None:
    names = shown("free_axes")
    assert names["tip_off"] < 1e-12 and names["axis_off"] < 1e-12  # m, and sine of an angle
    best, cell = names["best"], names["cell"]
    assert 0.0 < np.nanmin(best) and np.isnan(best).any()
    # its best place, asked of the forward kinematics alone, is as well conditioned as it says
    q, possible = names["postures"](names["track"][names["column"]])
    branches = q[names["row"]][possible[names["row"]]]
    assert np.max(inverse_kf_many(chain_arrays(cell), branches)) == pytest.approx(np.nanmax(best), abs=1e-12)
    assert 0.628 < np.nanmax(best) < 1.0  # what is chosen along the whole path has a lower mean than a point's best


@pytest.mark.slow
def test_the_notebook_that_diagnoses(shown) -> None:
    names = shown("diagnose_a_log")
    found = {effect.effect: effect.parameters for effect in names["found"].effects}
    assert found.keys() == {"latency", "corner_rounding"}
    assert found["latency"]["delay_s"].value == pytest.approx(0.04, rel=0.01)
    assert names["found"].together.rms_after_mm < 1.1 * names["NOISE"] * 3**0.5 < names["found"].gap.rms_mm
