"""A tool's mass in the set-up: the program sets the controller's load data with it, and the witness holds them to it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from process_story import GCODE, KR15, PLACE, posted, text_of

from camrob.errors import SetupError
from camrob.jobs.verify import verify
from camrob.witness.job import read_job

FRAME = "flange_to_tool = [0.0, -41.763657, 415.577926, 0.0, 0.0, -159.579784]\n"
HEAVY = "mass_kg = 38.51\ncenter_of_mass_mm = [0, -20.5, 180]\n"
LIGHT = "mass_kg = 36\ncenter_of_mass_mm = [0, -20.5, 175.25]\n"
HEAVY_SAID = "$LOAD = {M 38.510,CM {X 0.000,Y -20.500,Z 180.000,A 0.0,B 0.0,C 0.0},J {X 0.0,Y 0.0,Z 0.0}}"
LIGHT_SAID = "$LOAD = {M 36.000,CM {X 0.000,Y -20.500,Z 175.250,A 0.0,B 0.0,C 0.0},J {X 0.0,Y 0.0,Z 0.0}}"


def tools(first: str, second: str) -> str:
    """A set-up of two tools."""
    return f"{PLACE}[[tool]]\nnumber = 1\n{FRAME}{first}[[tool]]\nnumber = 2\n{FRAME}{second}"


def loads(text: str) -> list[str]:
    return re.findall(r"^\$LOAD.*?\r?$", text, re.M)


def codes(made) -> list[str]:
    return [w.code for w in made.summary.warnings]


def test_each_tools_load_is_set_where_it_is_mounted(tmp_path: Path) -> None:
    made = posted(tmp_path, "part.nc", GCODE, setup=tools(HEAVY, LIGHT))
    text = text_of(made)
    assert [line.strip() for line in loads(text)] == [HEAVY_SAID, LIGHT_SAID]
    assert text.index("$TOOL = ") < text.index(HEAVY_SAID) < text.index("PTP {")
    change = text.index("to tool 2") if "to tool 2" in text else text.index("tool 2")
    assert change < text.index(LIGHT_SAID) < text.index("PTP {", change)
    assert "load-not-switched" not in codes(made)
    assert verify(made.out / "part.src", cell=KR15, against=tmp_path / "in" / "part.nc").ok


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (HEAVY_SAID + "\n", ""),
        (LIGHT_SAID + "\n", ""),
        ("M 36.000", "M 38.510"),
        ("M 38.510", "M 38.52"),
        ("Z 175.250", "Z 175.3"),
        (LIGHT_SAID, "BAS (#TOOL,2 )\n$TOOL = {X 0.0,Y -41.76366,Z 415.57793,A 0.0,B 0.0,C -159.57978}"),
        (LIGHT_SAID, LIGHT_SAID + "\n$LOAD.CM.X = 5"),
        (LIGHT_SAID, LIGHT_SAID + "\n$LOAD = LOAD_DATA[4]"),
        (LIGHT_SAID, LIGHT_SAID + "\n$LOAD.J.X = 0.5"),
    ],
)
def test_another_load_or_none_does_not_pass(tmp_path: Path, old: str, new: str) -> None:
    made = posted(tmp_path, "part.nc", GCODE, setup=tools(HEAVY, LIGHT))
    source = made.out / "part.src"
    text = source.read_bytes().decode().replace("\r\n", "\n")
    assert text.count(old) == 1
    source.write_bytes(text.replace(old, new).replace("\n", "\r\n").encode())
    assert not verify(source, cell=KR15, against=tmp_path / "in" / "part.nc", manifest=False).ok


TURNING = HEAVY + "inertia_kg_m2 = [1.25, 1.2, 0.06]\n"
TURNING_SAID = HEAVY_SAID.replace("J {X 0.0,Y 0.0,Z 0.0}", "J {X 1.250,Y 1.200,Z 0.060}")


def test_moments_of_inertia_stand_in_the_load(tmp_path: Path) -> None:
    """The numbers of the set-up, and the witness holds each of them to it."""
    made = posted(tmp_path, "part.nc", GCODE, setup=tools(TURNING, LIGHT))
    assert [line.strip() for line in loads(text_of(made))] == [TURNING_SAID, LIGHT_SAID]
    source = made.out / "part.src"
    text = source.read_bytes()
    assert verify(source, cell=KR15, against=tmp_path / "in" / "part.nc").ok
    source.write_bytes(text.replace(b"Y 1.200,Z 0.060", b"Y 1.210,Z 0.060"))
    assert not verify(source, cell=KR15, against=tmp_path / "in" / "part.nc", manifest=False).ok


@pytest.mark.parametrize(
    ("given", "match"),
    [
        (LIGHT + "inertia_kg_m2 = [-1, 1, 1]\n", "no moments of a body"),
        (LIGHT + "inertia_kg_m2 = [3, 1, 1]\n", "no moments of a body"),
        ("inertia_kg_m2 = [1, 1, 1]\n", "without mass_kg"),
    ],
)
def test_moments_that_no_body_has(tmp_path: Path, given: str, match: str) -> None:
    with pytest.raises(SetupError, match=match):
        posted(tmp_path, "part.nc", GCODE, setup=tools(HEAVY, given))


def test_a_load_of_the_same_tool_in_other_words_passes(tmp_path: Path) -> None:
    made = posted(tmp_path, "part.nc", GCODE, setup=tools(HEAVY, LIGHT))
    source = made.out / "part.src"
    parts = "$LOAD.M = 36\r\n$LOAD.CM.Z = 170.25+5"
    text = source.read_bytes().decode().replace(LIGHT_SAID, parts)
    source.write_bytes(text.encode())
    assert verify(source, cell=KR15, against=tmp_path / "in" / "part.nc", manifest=False).ok


def test_tools_of_one_mass_need_one_load(tmp_path: Path) -> None:
    assert len(loads(text_of(posted(tmp_path, "part.nc", GCODE, setup=tools(HEAVY, HEAVY))))) == 1


def test_some_with_a_mass_and_some_without_are_refused(tmp_path: Path) -> None:
    for setup in (tools(HEAVY, ""), tools("", LIGHT)):
        with pytest.raises(SetupError, match="mass_kg and center_of_mass_mm for every") as caught:
            posted(tmp_path, "part.nc", GCODE, setup=setup)
        assert "\n" not in str(caught.value) and not (tmp_path / "out").exists()


def test_without_any_mass_the_text_sets_no_load_and_several_tools_warn(tmp_path: Path) -> None:
    made = posted(tmp_path, "part.nc", GCODE, setup=tools("", ""))
    assert not loads(text_of(made)) and codes(made).count("load-not-switched") == 1
    one = GCODE[: GCODE.index("T2 M6")] + "M30\n%\n"
    (tmp_path / "one").mkdir()
    made = posted(tmp_path / "one", "part.nc", one, setup=tools("", LIGHT))
    assert not loads(text_of(made)) and "load-not-switched" not in codes(made)


@pytest.mark.parametrize("mass", ["0", "-3", "nan", "inf", "1000.5", "true", '"20"'])
def test_the_witness_takes_no_such_mass(tmp_path: Path, mass: str) -> None:
    (tmp_path / "setup.toml").write_text(f"[tool]\nmass_kg = {mass}\ncenter_of_mass_mm = [0, 0, 0]\n")
    with pytest.raises(SetupError, match="mass_kg"):
        read_job(tmp_path / "setup.toml")


@pytest.mark.parametrize(
    "half", ["mass_kg = 3", "center_of_mass_mm = [0, 0, 0]", "mass_kg = 3\ncenter_of_mass_mm = [0, 0, 9e9]"]
)
def test_the_witness_wants_both(tmp_path: Path, half: str) -> None:
    (tmp_path / "setup.toml").write_text(f"[tool]\n{half}\n")
    with pytest.raises(SetupError, match="mass"):
        read_job(tmp_path / "setup.toml")
