"""Effects that a cell brings, one file each: found like built-in ones, held to the same promises, never executed."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from gap_cases import KR15, kr15, simulated

from camrob.errors import CellError, InputError
from camrob.gap.cell_effects import cell_effects
from camrob.gap.conformance import effect_faults
from camrob.gap.diagnose import diagnose
from camrob.gap.effects.registry import library
from camrob.gap.expression import parse_expression
from camrob.gap.observation.scene import make_scene

SIGMA = 0.02
PITCH = 90.0
RACK = f"""
name = "rack_pitch"
physics = "The rack's teeth are cut in sections of {PITCH} mm, and every section is a little too long or too short."
experiment = "drive the track alone, slowly, from end to end and back"
remedy = "set the sections of the rack by a gauge"
regimes = ["position"]
[[parameter]]
name = "cos"
moves = "E1"
by = "cos(360 * E1 / {PITCH})"
unit = "mm"
usual = 0.05
lower = -0.5
upper = 0.5
[[parameter]]
name = "sin"
moves = "E1"
by = "sin(360 * E1 / {PITCH})"
unit = "mm"
usual = 0.05
lower = -0.5
upper = 0.5
"""


def folder(tmp_path: Path, name: str, text: str) -> Path:
    home = tmp_path / "cell"
    (home / "effects").mkdir(parents=True)
    shutil.copy(KR15 / "cell.toml", home)
    (home / "effects" / f"{name}.toml").write_text(text)
    return home


def plant_rack(world) -> None:
    world.after[:, 1] += 1e-4 * np.sin(2 * np.pi * world.command[:, 6] * 1e3 / PITCH)


def test_an_effect_of_the_cell_is_found_under_its_own_name_with_its_size(tmp_path: Path) -> None:
    own = cell_effects(folder(tmp_path, "rack_pitch", RACK), kr15())
    log = simulated(plant_rack, sigma_mm=SIGMA)
    scene = make_scene(log, kr15())
    assert effect_faults(own[0], [scene]) == []
    found = diagnose([log], kr15(), extra=own)
    assert found.claimed == ("rack_pitch",)
    entry = found.summary.to_json()["effects"][0]
    assert entry["axes"] == ["E1"] and entry["remedy"] == "set the sections of the rack by a gauge"
    assert entry["parameters"]["sin_mm"]["value"] == pytest.approx(0.1, rel=0.05)
    assert entry["parameters"]["cos_mm"]["value"] == pytest.approx(0.0, abs=0.01)
    without = diagnose([log], kr15(), extra=own, without=["rack_pitch"])
    assert "rack_pitch" not in without.claimed
    assert without.summary.to_json()["status"] != "explained"


def test_an_effect_of_the_cell_invents_nothing(tmp_path: Path) -> None:
    own = cell_effects(folder(tmp_path, "rack_pitch", RACK), kr15())
    assert diagnose([simulated(sigma_mm=SIGMA)], kr15(), extra=own).claimed == ()


def test_formulas_know_lags_plays_speeds_and_values_to_choose_from(tmp_path: Path) -> None:
    text = """
name = "hose"
physics = "The hose pulls the wrist over, and gives way slowly."
experiment = "turn A4 alone"
regimes = ["position", "time"]
[try]
name = "tau_s"
from = 0.1
to = 3.2
count = 6
[[parameter]]
name = "pull"
moves = "A5"
by = "lag(max(0, A4) + 0.1 * play(A6, 2.0), tau_s) / 10 + 0 * (dA4 + ddA5 + T_A2 + t + x)"
unit = "deg"
usual = 0.01
lower = -0.2
upper = 0.2
[[parameter]]
name = "drag"
moves = "drive A4"
by = "-dA4"
unit = "deg"
usual = 0.01
lower = -0.2
upper = 0.2
"""
    effect = cell_effects(folder(tmp_path, "hose", text), kr15())[0]
    assert effect.stages == ("setpoint_to_encoder", "encoder_to_tcp")
    assert [round(t["tau_s"], 3) for t in effect.trials] == [0.1, 0.2, 0.4, 0.8, 1.6, 3.2]
    scene = make_scene(simulated(), kr15())
    assert effect_faults(effect, [scene]) == []
    unit = effect.units([scene], effect.start)[0]
    pull, drag = effect.columns(scene, unit, effect.start)
    assert pull.tcp is not None
    assert np.allclose(drag.servo["A4"], -np.rad2deg(scene.velocity(scene.link)[:, 3]))


HOSTILE = [
    "__import__('os').system('true')",
    "A1.__class__",
    "(lambda: 1)()",
    "[1][0]",
    "A1 if A2 else A3",
    "A1 ** A2",
    "2 ** 9999",
    "open('x')",
    "exp(A1, A2)",
    "'a'",
    "True",
    "1e999",
    "9" * 500,
    "abs(" * 30 + "A1" + ")" * 30,
    "A9",
    "A1;A2",
    "A1 := 2",
    "",
    "-" * 90 + "A1",
    "A1 @ A2",
    "f'{A1}'",
    "sin(*A1)",
    "sin(x=A1)",
    "A1\nA2",
    "not A1",
    "1j",
]


@pytest.mark.parametrize("text", HOSTILE)
def test_a_formula_is_arithmetic_and_nothing_else(text: str) -> None:
    with pytest.raises(ValueError, match=r"\S") as refused:
        parse_expression(text, ["A1", "A2", "A3"])
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (('name = "rack_pitch"', 'name = "backlash"'), "can't be an effect's name"),
        (('name = "rack_pitch"', 'name = "another"'), "give both the same name"),
        (('moves = "E1"', 'moves = "E7"'), "is nothing that moves"),
        (('unit = "mm"', 'unit = "deg"'), "use one of mm"),
        (("cos(360", "os.system(360"), "by:"),
        (('regimes = ["position"]', 'regimes = ["moon"]'), "names 'moon'"),
        (("usual = 0.05", "usual = -1"), "usual"),
        (("experiment", "experience"), "experiment: is missing"),
        (("lower = -0.5", "lower = -0.5\nmore = 1"), "more"),
    ],
)
def test_a_wrong_file_is_refused_in_one_line(tmp_path: Path, change, words: str) -> None:
    home = folder(tmp_path, "rack_pitch", RACK.replace(*change))
    with pytest.raises(CellError, match=words) as refused:
        cell_effects(home, kr15())
    assert "\n" not in str(refused.value)
    assert "rack_pitch.toml" in str(refused.value)


def test_a_formula_without_finite_values_is_refused_before_anything_is_fitted(tmp_path: Path) -> None:
    own = cell_effects(folder(tmp_path, "rack_pitch", RACK.replace("cos(360", "1 / (E1 - E1) * cos(360")), kr15())
    with pytest.raises(CellError, match="rack_pitch gives numbers at the TCP that are not finite"):
        diagnose([simulated(sigma_mm=SIGMA)], kr15(), extra=own)


def test_names_are_known_to_without(tmp_path: Path) -> None:
    own = cell_effects(folder(tmp_path, "rack_pitch", RACK), kr15())
    assert len(library(["rack_pitch"], own)) == len(library())
    with pytest.raises(InputError, match="rack_pitch"):
        library(["no_such"], own)


@pytest.mark.parametrize("cell", sorted(p.parent for p in KR15.parent.glob("*/cell.toml")), ids=lambda p: p.name)
def test_cells_that_come_with_camrob_bring_readable_effects(cell: Path) -> None:
    from camrob.cell.read_cell import read_cell

    assert isinstance(cell_effects(cell, read_cell(cell)), tuple)


def test_the_page_s_example_is_an_effect_that_can_be_read(tmp_path: Path) -> None:
    page = (KR15.parents[1] / "camrob" / "gap" / "README.md").read_text()
    example = page.partition("```toml\n")[2].partition("```")[0]
    effect = cell_effects(folder(tmp_path, "rack_pitch", example), kr15())[0]
    assert effect_faults(effect, [make_scene(simulated(), kr15())]) == []
