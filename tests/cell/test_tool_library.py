"""A tool library beside the set-up: titles as CAM systems write them, units, holders, what a set-up says over it, mistakes.

Both readers, camrob's and the witness's, are held to numbers worked out by hand.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from process_story import KR15
from scipy.spatial.transform import Rotation

from camrob.cell.read_cell import read_cell
from camrob.cell.read_setup import read_setup
from camrob.errors import SetupError
from camrob.witness.job import read_job

CELL = read_cell(KR15)
GAUGE = "flange_to_gauge_line = [10, -40, 260, 0, 0, 200]\n"
FUSION = (
    '"Tool Index (tool_index)","Preset Name (preset_name)","Type (tool_type)","Description (tool_description)",'
    '"Diameter (tool_diameter)","Number (tool_number)","Unit (tool_unit)","Corner Radius (tool_cornerRadius)",'
    '"Body Length (tool_bodyLength)","Overall Length (tool_overallLength)",'
    '"Tool Assembly Gauge Length (tool_assemblyGaugeLength)","Holder Description (holder_description)",'
    '"Holder Segments (holder_segments)"\n'
    '1,Steel,ball end mill,"Ball, 1/2""",0.5,3,inches,0,2.25,4,6.125,BT40,"[{""height"":1,""upper"":1.5,""lower"":1.25}]"\n'
    '1,Alu,ball end mill,"Ball, 1/2""",0.5,3,inches,0,2.25,4,6.125,BT40,"[{""height"":1,""upper"":1.5,""lower"":1.25}]"\n'
    "2,,flat end mill,FLAT10,10,12,millimeters,0,35.5,72,140.25,HSK63,\n"
    "3,,bull nose end mill,Spare,20,0,millimeters,2,60,100,,,\n"
)


def both(folder: Path, library: str, setup: str = "", name: str = "tools.csv"):
    """The tools by number in both readings, the witness's held to camrob's."""
    (folder / name).write_text(library)
    (folder / "setup.toml").write_text(f'tool_library = "{name}"\n{setup}')
    tools = {tool.number: tool for tool in read_setup(folder / "setup.toml", CELL).tools}
    seen = read_job(folder / "setup.toml").tools
    assert tools.keys() == seen.keys()
    for number, tool in tools.items():
        held = seen[number].flange_T_tool
        np.testing.assert_allclose(CELL.flange_T_tool if held is None else held, tool.flange_T_tool, atol=1e-12)
        assert seen[number].diameter or 0.0 == pytest.approx(tool.diameter)
        assert seen[number].length or 0.0 == pytest.approx(tool.length)
        assert seen[number].name == tool.name
    return tools


def test_an_export_of_fusion(tmp_path: Path) -> None:
    """Inches row by row, one row a preset, JSON of the holder; a tool without a number is in no magazine."""
    tools = both(tmp_path, FUSION, GAUGE)
    assert set(tools) == {3, 12}
    ball, flat = tools[3], tools[12]
    assert (ball.name, flat.name) == ('Ball, 1/2"', "FLAT10")
    assert ball.diameter == pytest.approx(0.0127)
    assert ball.corner == pytest.approx(0.00635)
    assert ball.length == pytest.approx(0.05715)
    assert ball.holder == (pytest.approx((0.0381, 0.0254)),)
    assert (flat.diameter, flat.corner, flat.length) == pytest.approx((0.01, 0.0, 0.0355))
    turn = Rotation.from_euler("ZYX", [0, 0, 200], degrees=True).as_matrix()
    for tool, out in ((ball, 155.575), (flat, 140.25)):
        want = np.array([10, -40, 260]) - out * turn[:, 2]
        np.testing.assert_allclose(tool.flange_T_tool[:3, 3] * 1e3, want, atol=1e-9)
        np.testing.assert_allclose(tool.flange_T_tool[:3, :3], turn, atol=1e-12)


@pytest.mark.parametrize(
    "library",
    [
        "number,name,diameter_mm,length_mm,gauge_length_mm,corner_radius_mm,holder_mm\n4,B6,6,30,120.5,3,40x30 63x60\n",
        "T;Name;D [mm];Stick-out [mm];Gauge length [mm];R2 [mm];holder_mm\n4;B6;6,0;30,0;120,5;3,0;40x30 63 x 60\n",
        "# from the presetter\nTool No.\tTool name\tDC\tLB\tGauge length\tRE\tUnit\tholder_mm\n"
        "4\tB6\t6\t30\t120.5\t3\tmm\t40x30 63x60\n",
        "Tool Number,Tool Name,Type,Diameter,Body Length,Gauge Length,holder_mm\n4,B6,Ballnose,6 mm,30 mm,120.5mm,40x30 63x60\n",
        "\ufeffnumber,name,diameter_in,length_in,gauge_length_in,corner_radius_in,holder_mm\r\n"
        "4,B6,.2362204724,1.181102362,4.744094488,.1181102362,40x30 63x60\r\n",
    ],
    ids=["own keys", "semicolons and commas", "tabs", "units behind", "inches"],
)
def test_columns_by_other_names(tmp_path: Path, library: str) -> None:
    (tool,) = both(tmp_path, library, GAUGE).values()
    assert (tool.number, tool.name) == (4, "B6")
    assert (tool.diameter, tool.length, tool.corner) == pytest.approx((0.006, 0.030, 0.003))
    np.testing.assert_allclose(tool.holder, [[0.040, 0.030], [0.063, 0.060]])
    want = np.array([10, -40, 260]) - 120.5 * Rotation.from_euler("x", 200, degrees=True).as_matrix()[:, 2]
    np.testing.assert_allclose(tool.flange_T_tool[:3, 3] * 1e3, want, atol=1e-6)


def test_a_tool_of_the_set_up_stands_over_the_library(tmp_path: Path) -> None:
    own = '[[tool]]\nnumber = 12\nflange_to_tool = [1, 2, 300, 0, 0, 180]\nname = "F10"\n'
    own += "[[tool]]\nnumber = 20\ngauge_length_mm = 99\n"
    tools = both(tmp_path, FUSION, GAUGE + own)
    assert set(tools) == {3, 12, 20}
    assert (tools[12].name, tools[12].diameter) == ("F10", pytest.approx(0.01))
    np.testing.assert_allclose(tools[12].flange_T_tool[:3, 3], [0.001, 0.002, 0.300])
    np.testing.assert_allclose(tools[20].flange_T_tool[2, 3], 0.260 - 0.099 * np.cos(np.radians(200)))


def test_without_a_gauge_line_the_tool_is_where_the_cell_has_it(tmp_path: Path) -> None:
    np.testing.assert_array_equal(both(tmp_path, FUSION)[3].flange_T_tool, CELL.flange_T_tool)


HEAD = "number,diameter_mm,length_mm,gauge_length_mm,holder_mm,corner_radius_mm\n"


@pytest.mark.parametrize(
    ("library", "setup", "match"),
    [
        ("Name,D\nA,3\n", "", r"tools.csv:1: has no column of the tools' numbers"),
        ("", "", "no column"),
        ("number,Diameter\n1,6\n", "", r"tools.csv:2: Diameter names no unit"),
        ("number,Diameter,Unit\n1,6,mm\n2,8,furlong\n", "", r"tools.csv:3: unit is 'furlong'"),
        (HEAD + "1,six\n", "", r"tools.csv:2: diameter_mm is 'six', no number"),
        (HEAD + "1,6 ft\n", "", r"tools.csv:2: diameter_mm is in 'ft'"),
        (HEAD + "1,6\n\n1,8\n", "", r"tools.csv:4: tool 1 is another one than in line 2"),
        (HEAD + "1.5,6\n", "", r"tools.csv:2: number is 1.5"),
        (HEAD + "A1,6\n", "", r"tools.csv:2: number is 'A1'"),
        (HEAD + "1,6,30,100,BT40\n", "", r"tools.csv:2: holder is 'BT40'"),
        (HEAD + "1,6000\n", "", r"tools.csv:2: diameter_mm: is 6000"),
        (HEAD + "1,6,,,,4\n", "", r"tools.csv:2: corner_radius_mm: is 4, more than half"),
        (HEAD + "1,6\n", "[tool]\ndiameter_mm = 3\n", "stands for all numbers"),
        (HEAD + "1,6\n", "[[tool]]\nnumber = 2\ngauge_length_mm = 3\n", "gauge line, which isn't told"),
    ],
)
def test_mistakes_are_named_by_line(tmp_path: Path, library: str, setup: str, match: str) -> None:
    (tmp_path / "tools.csv").write_text(library)
    (tmp_path / "setup.toml").write_text(f'tool_library = "tools.csv"\n{setup}')
    with pytest.raises(SetupError, match=match):
        read_setup(tmp_path / "setup.toml", CELL)


@pytest.mark.parametrize("name", ["away/tools.csv", "none.csv"])
def test_a_library_lies_beside_the_set_up(tmp_path: Path, name: str) -> None:
    (tmp_path / "setup.toml").write_text(f'tool_library = "{name}"\n')
    with pytest.raises(SetupError, match="not a file beside this one"):
        read_setup(tmp_path / "setup.toml", CELL)
