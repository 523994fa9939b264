"""setup.toml: what it says, what it leaves open, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from camrob.cell.read_cell import read_cell
from camrob.cell.read_setup import read_setup
from camrob.errors import SetupError
from camrob.se3 import xyzabc_from_frame
from camrob.units import m_to_mm, rad_to_deg

CELL = read_cell(Path(__file__).resolve().parents[2] / "cells" / "kr15_track_table")

FULL = """
part_in_base = [100, -20, 30.5, 90, 0, 180]
units = "inch"
dialect = "nx-clsf"
rapid_feed_mm_min = 6000
feed_mm_min = 900
spindle_rpm = 12000
clearance_mm = 50
chord_tolerance_mm = 0.01
decimate_mm = 0.002

[[tool]]
number = 1
name = "ball 6"
flange_to_tool = [0, -41.764, 415.578, 0, 0, -159.58]
diameter_mm = 6
length_mm = 45

[[tool]]
number = 7

[part]
mesh = "part.STL"
unit = "inch"

[stock]
box_mm = [0, 0, -10, 200, 100, 40]
"""


def write(folder, text):
    (folder / "part.STL").write_bytes(b"")
    file = folder / "setup.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_without_a_file_the_part_is_the_base():
    setup = read_setup(None, CELL)
    np.testing.assert_array_equal(setup.base_T_part, np.eye(4))
    np.testing.assert_array_equal(setup.tool(5).flange_T_tool, CELL.flange_T_tool)
    assert (setup.units, setup.dialect, setup.decimate) == ("", "", 0.0)
    assert {setup.rapid_feed, setup.feed, setup.spindle_rpm, setup.clearance, setup.part, setup.stock} == {None}


def test_an_empty_file_is_no_file(tmp_path):
    assert read_setup(write(tmp_path, ""), CELL).digest == read_setup(None, CELL).digest


def test_a_full_one(tmp_path):
    setup = read_setup(str(write(tmp_path, FULL)), CELL)
    xyzabc = xyzabc_from_frame(setup.base_T_part)
    np.testing.assert_allclose(m_to_mm(xyzabc[:3]), [100, -20, 30.5])
    np.testing.assert_allclose(rad_to_deg(xyzabc[3:]), [90, 0, 180], atol=1e-12)
    np.testing.assert_allclose(setup.base_T_part[:3, 0], [0, 1, 0], atol=1e-15)  # A = 90: the part's x along base's y
    assert (setup.units, setup.dialect) == ("inch", "nx-clsf")
    assert (setup.rapid_feed, setup.feed, setup.spindle_rpm) == pytest.approx((0.1, 0.015, 12000.0))
    assert (setup.clearance, setup.chord_tolerance, setup.decimate) == pytest.approx((0.05, 1e-5, 2e-6))
    assert (setup.tool(1).diameter, setup.tool(1).length, setup.tool(1).name) == (0.006, 0.045, "ball 6")
    np.testing.assert_array_equal(setup.tool(7).flange_T_tool, CELL.flange_T_tool)
    assert setup.part.mesh == tmp_path / "part.STL"
    assert setup.part.scale == pytest.approx(0.0254)
    np.testing.assert_allclose(setup.stock.upper - setup.stock.lower, [0.2, 0.1, 0.05])
    with pytest.raises(SetupError, match=r"tool 2 is not set up; add it as \[\[tool\]\]; there are: 1, 7"):
        setup.tool(2)
    with pytest.raises(SetupError, match="names no tool"):
        setup.tool()


def test_one_tool_serves_every_number(tmp_path):
    setup = read_setup(write(tmp_path, "[tool]\nflange_to_tool = [0, 0, 200, 0, 0, 0]\n"), CELL)
    assert setup.tool(3) is setup.tool()
    assert setup.tool(3).flange_T_tool[2, 3] == pytest.approx(0.2)


def test_the_digest_sees_every_choice(tmp_path):
    digest = read_setup(write(tmp_path, FULL), CELL).digest
    for old, new in (
        ("30.5", "30.6"),
        ('"inch"\nd', '"mm"\nd'),
        ("= 900", "= 901"),
        ("= 45", "= 46"),
        ("200, 100", "200, 101"),
    ):
        assert old in FULL
        assert read_setup(write(tmp_path, FULL.replace(old, new)), CELL).digest != digest


def test_a_tools_mass_and_its_centre(tmp_path):
    setup = read_setup(write(tmp_path, "[tool]\nmass_kg = 38.5\ncenter_of_mass_mm = [1, -20.5, 300]\n"), CELL)
    assert setup.tool().mass == 38.5
    np.testing.assert_allclose(setup.tool().center_of_mass, [0.001, -0.0205, 0.3])
    other = read_setup(write(tmp_path, "[tool]\nmass_kg = 38.5\ncenter_of_mass_mm = [1, -20.5, 301]\n"), CELL)
    silent = read_setup(write(tmp_path, "[tool]\n"), CELL)
    assert silent.tool().mass is None and len({setup.digest, other.digest, silent.digest}) == 3


BROKEN = [
    ("part_in_base = [1, 2, 3]", "part_in_base: is [1, 2, 3]; give a list of 6 finite numbers"),
    ("part_in_base = [1, 2, 3, 4, 5, nan]", "part_in_base"),
    ("part_in_base = [1e9, 0, 0, 0, 0, 0]", "part_in_base: lies more than 100000 mm off; give X, Y, Z in mm"),
    ("part_in_base = [0, 0, 0, 720, 0, 0]", "part_in_base: has an angle beyond 360"),
    (
        "[tool]\ndiameter_mm = 3\ncorner_radius_mm = 15",
        "tool.corner_radius_mm: is 15, more than half of diameter_mm = 3",
    ),
    ('units = "furlong"', "units: is 'furlong'; use one of mm, inch"),
    ('dialect = "NX; rm"', "dialect: is 'NX; rm'; give a name such as nx-clsf"),
    ("rapid_feed_mm_min = 0", "rapid_feed_mm_min: is 0"),
    ("rapid_feed_mm_min = true", "rapid_feed_mm_min: is True"),
    ("feed_mm_min = -3", "feed_mm_min: is -3"),
    ("spindle_rpm = inf", "spindle_rpm: is inf"),
    ("clearance_mm = -1", "clearance_mm: is -1"),
    ("chord_tolerance_mm = 0", "chord_tolerance_mm: is 0"),
    ("decimate_mm = 100", "decimate_mm: is 100"),
    ("part_in_bas = [0, 0, 0, 0, 0, 0]", "part_in_bas: is not a key that camrob knows here; is it part_in_base?"),
    ("place = [0, 0, 0]", "place: is not a key that camrob knows here; use chord_tolerance_mm, clearance_mm, "),
    ("schema = 1\n[kinematics]\n", "is a cell, not a set-up; name it behind --cell"),
    ("tool = 3", "tool: is 3; give a table"),
    ("tool = [1, 2]", "tool: is not an array of tables"),
    ("[tool]\nnumber = 1", "tool: stands for all numbers, and has one; make it [[tool]]"),
    ("[tool]\nmass_kg = 0\ncenter_of_mass_mm = [0, 0, 0]", "tool.mass_kg: is 0; give a number from 0.001 to 1000"),
    ("[tool]\nmass_kg = -3\ncenter_of_mass_mm = [0, 0, 0]", "tool.mass_kg: is -3"),
    ("[tool]\nmass_kg = nan\ncenter_of_mass_mm = [0, 0, 0]", "tool.mass_kg: is nan; give a finite number"),
    ("[tool]\nmass_kg = 1000.5\ncenter_of_mass_mm = [0, 0, 0]", "tool.mass_kg: is 1000.5"),
    ("[tool]\nmass_kg = 20", "tool.center_of_mass_mm: is missing"),
    ("[tool]\ncenter_of_mass_mm = [0, 0, 0]", "tool.mass_kg: is missing"),
    ("[tool]\nmass_kg = 20\ncenter_of_mass_mm = [0, inf, 0]", "tool.center_of_mass_mm: is [0, inf, 0]"),
    ("[tool]\nmass_kg = 20\ncenter_of_mass_mm = [0, 0, 9e4]", "tool.center_of_mass_mm: lies more than 5000 mm off"),
    ("[[tool]]\nname = 'x'", "tool[x].number: is missing"),
    ("[[tool]]\nnumber = 1.5", "tool 1.number: is 1.5; give a whole number"),
    ("[[tool]]\nnumber = 0", "tool 1.number: is 0"),
    ("[[tool]]\nnumber = 1\n[[tool]]\nnumber = 1", "tool 2.number: 1 appears twice"),
    ("[tool]\ndiameter_mm = 0", "tool.diameter_mm: is 0"),
    ('[tool]\nname = "a\\nHALT"', "tool.name: is 'a\\nHALT'"),
    ("[part]", "part.mesh: and box_mm are both given or both missing"),
    ('[part]\nmesh = "part.STL"\nbox_mm = [0, 0, 0, 1, 1, 1]', "part.mesh: and box_mm are both given"),
    ('[part]\nmesh = "other.stl"', "part.mesh: 'other.stl' is not a file beside this one"),
    ('[part]\nmesh = "../part.STL"', "part.mesh: '../part.STL' is not a file beside this one"),
    ('[part]\nmesh = "/etc/passwd"', "part.mesh: '/etc/passwd' is not a file beside this one"),
    (f'[part]\nmesh = "{"x" * 5000}.stl"', "is not a file beside this one"),
    ('[part]\nmesh = "setup.toml"', "part.mesh: 'setup.toml' is not a mesh; use one of .stl"),
    ('[part]\nmesh = "part.STL"\nunit = "cm"', "part.unit: is 'cm'"),
    ("[stock]\nbox_mm = [0, 0, 0, 1, 1, 0]", "stock.box_mm: has no volume"),
    ("[stock]\nbox_mm = [0, 0, 0, 1, 1]", "stock.box_mm: is [0, 0, 0, 1, 1]"),
    ("stock = 5", "stock: is 5; give a table"),
    ('"a\\nb" = 1', "is not a key that camrob knows here"),
    ("part_in_base = [", "is not valid TOML"),
]


@pytest.mark.parametrize(("text", "message"), BROKEN, ids=range(len(BROKEN)))
def test_broken_ones_are_refused_by_name(tmp_path, text, message):
    file = write(tmp_path, text)
    with pytest.raises(SetupError) as caught:
        read_setup(file, CELL)
    shown = str(caught.value)
    assert shown.startswith(str(file))
    assert message in shown
    assert shown.isprintable()
    assert len(shown) < 400 + len(str(file))


@pytest.mark.parametrize("content", [b"\xff\xfe", b"\x00\x01", b"a = " + b"[" * 100_000])
def test_binary_ones(tmp_path, content):
    (tmp_path / "setup.toml").write_bytes(content)
    with pytest.raises(SetupError):
        read_setup(tmp_path / "setup.toml", CELL)


def test_missing_ones(tmp_path):
    with pytest.raises(SetupError, match="can't be read"):
        read_setup(tmp_path / "setup.toml", CELL)
