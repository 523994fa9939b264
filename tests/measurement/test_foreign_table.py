"""Tables of other people's recorders, taken as [table] in LOG.toml says: names, separators, units, orientations, sums."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from camrob.errors import LogError
from camrob.measurement.read_log import read_log

AXES = "A1 = 'j1'\nA2 = 'j2'\n"


def log_of(folder: Path, text: str, toml: str, encoding: str = "utf-8"):
    (folder / "log.csv").write_bytes(text.encode(encoding))
    (folder / "log.toml").write_text(toml, encoding="utf-8")
    return read_log(folder / "log.csv")


def test_a_table_of_a_german_recorder(tmp_path: Path) -> None:
    """Semicolons, decimal commas, a header further down in an older code page, cells that hold no number."""
    text = "Messung 3\nLänge in m\nZeit;Winkel 1;Winkel 2 [°];X;Y;Z;Bemerkung\n"
    text += "0,5;10,25;-3;1,5;2;0,001;gut\n\n0,6;10,5;-4;NaN;;-;\n"
    toml = (
        "[table]\nseparator = ';'\ndecimal = ','\nheader = 3\nlengths = 'm'\n[table.columns]\nt = 'Zeit'\n"
        "A1 = 'Winkel 1'\nA2 = 'Winkel 2 [°]'\nx = 'X'\ny = 'Y'\nz = 'Z'\n"
    )
    log = log_of(tmp_path, text, toml, "cp1252")
    assert log.t.tolist() == [0.5, 0.6]
    assert log.axes(["A1", "A2"]).tolist() == [[10.25, -3.0], [10.5, -4.0]]
    assert log.position[0] == pytest.approx([1.5, 2.0, 0.001])
    assert np.isnan(log.position[1]).all()
    assert log.file_lines is not None and log.file_lines.tolist() == [4, 6]


def test_radians_metres_and_milliseconds_of_a_robot_whose_stamps_count_from_1970(tmp_path: Path) -> None:
    text = "stamp,j1,j2,c1,c2,lift,px,py,pz\n1700000000000,1.0,-0.5,1.1,-0.4,0.25,0.1,0.2,0.3\n"
    text += "1700000000008,1.1,-0.4,1.2,-0.3,0.26,0.2,0.2,0.3\n"
    toml = (
        "[table]\nangles = 'rad'\nlengths = 'm'\ntime = 'ms'\n[table.columns]\nt = 'stamp'\n" + AXES + "cA1 = 'c1'\n"
        "cA2 = 'c2'\nE1 = { column = 'lift', unit = 'm' }\ncE1 = { column = 'lift', unit = 'm' }\nx = 'px'\ny = 'py'\nz = 'pz'\n"
    )
    log = log_of(tmp_path, text, toml)
    assert log.t == pytest.approx([0.0, 0.008], abs=1e-6)
    assert log.axes(["A1", "A2", "E1"])[0] == pytest.approx([np.rad2deg(1.0), np.rad2deg(-0.5), 250.0])
    assert log.setpoints(["A2", "E1"])[1] == pytest.approx([np.rad2deg(-0.3), 260.0])
    assert log.position[1] == pytest.approx([0.2, 0.2, 0.3])


def test_an_external_axis_of_a_table_in_the_formats_own_units_needs_none(tmp_path: Path) -> None:
    log = log_of(
        tmp_path, "t,lift,j1\n0,250,1\n1,260,2\n", "[table]\n[table.columns]\nt = 't'\nA1 = 'j1'\nE1 = 'lift'\n"
    )
    assert log.axes(["E1"]).tolist() == [[250.0], [260.0]]


@pytest.mark.parametrize("kind", ["wxyz", "xyzw", "rotvec", "xyz", "abc"])
def test_orientations_of_makers(tmp_path: Path, kind: str) -> None:
    true = Rotation.from_rotvec([0.3, -0.8, 1.1])
    numbers = {
        "wxyz": np.roll(true.as_quat(), 1),
        "xyzw": true.as_quat(),
        "rotvec": true.as_rotvec(),
        "xyz": true.as_euler("XYZ", degrees=True),
        "abc": true.as_euler("ZYX", degrees=True),
    }[kind]
    columns = [f"r{k}" for k in range(len(numbers))]
    header = ",".join(["t", "j1", "j2", "x", "y", "z", *columns])
    rows = [f"{t},{t},{2 * t},10,20,30," + ",".join(f"{v:.12f}" for v in numbers) for t in (1, 2)]
    toml = "[table]\norientation = { as = '" + kind + f"', columns = {columns} }}\n[table.columns]\nt = 't'\n" + AXES
    log = log_of(tmp_path, "\n".join([header, *rows]), toml + "x = 'x'\ny = 'y'\nz = 'z'\n")
    assert log.rotation[1] == pytest.approx(true.as_matrix(), abs=1e-9)


def test_a_table_without_header_or_time_whose_third_axis_counts_from_the_horizontal(tmp_path: Path) -> None:
    toml = (
        "poses = true\n[table]\nseparator = ' '\nheader = 0\nadd = { A3 = 'A2' }\n[table.columns]\n"
        "A1 = 4\nA2 = 5\nA3 = 6\nx = 1\ny = 2\nz = 3\n"
    )
    log = log_of(tmp_path, "# a note\n1e2  200 300\t10 20 30\n101 201 301 11 22 33\n", toml)
    assert log.t.tolist() == [0.0, 1.0]
    assert log.axes(["A1", "A2", "A3"]).tolist() == [[10.0, 20.0, 50.0], [11.0, 22.0, 55.0]]
    assert log.position[0] == pytest.approx([0.1, 0.2, 0.3])


def test_the_formats_own_names_need_no_columns_and_poses_no_time(tmp_path: Path) -> None:
    log = log_of(
        tmp_path, "A1;A2;x;y;z;b;c;a\n1;2;3;4;5;0;0;90\n2;3;4;5;6;0;0;80\n", "poses = true\n[table]\nseparator = ';'\n"
    )
    assert log.t.tolist() == [0.0, 1.0]
    assert log.rotation[0] == pytest.approx(Rotation.from_euler("z", 90, degrees=True).as_matrix(), abs=1e-12)
    plain = log_of(tmp_path, "A1,A2,x,y,z\n1,2,3,4,5\n2,3,4,5,6\n", "poses = true\n")
    assert plain.t.tolist() == [0.0, 1.0]
    with pytest.raises(LogError, match=r"has no column t.+single poses need none"):
        log_of(tmp_path, "A1,A2,x,y,z\n1,2,3,4,5\n2,3,4,5,6\n", "")


def test_rows_that_a_recorder_wrote_twice_count_once(tmp_path: Path) -> None:
    twice, plain = "t;A1\n0.1;1\n0.2;2\n0.2;2\n0.3;\n0.3;\n0.4;5\n", "[table]\nseparator = ';'\n"
    log = log_of(tmp_path, twice, plain)
    assert log.t.tolist() == [0.1, 0.2, 0.3, 0.4]
    assert log.file_lines is not None and log.file_lines.tolist() == [2, 3, 5, 7]
    with pytest.raises(LogError, match=r"log\.csv:4: t is 0\.2 after 0\.2"):
        log_of(tmp_path, twice.replace("0.2;2\n0.3", "0.2;2.5\n0.3"), plain)


@pytest.mark.parametrize(
    ("toml", "said"),
    [
        ("[table]\nangels = 'rad'\n", "angels: is not a key of [table]"),
        ("[table]\nangles = 'grad'\n", "angles: is 'grad'; use one of 'deg', 'rad'"),
        ("[table]\nseparator = ','\ndecimal = ','\n", "the same sign between cells and decimals"),
        ("[table]\nheader = true\n", "header: is True"),
        ("[table]\nadd = { A3 = 'E1' }\n", "add: A3 = 'E1'"),
        ("[table.columns]\nq1 = 'j1'\n", "q1: is not a column of a log"),
        ("[table.columns]\nt = 'time'\nA1 = 'jj'\n", "has no column 'time'; its header has note, t"),
        ("[table.columns]\nt = 't'\nA1 = 'xyz'\n", "has no column 'xyz'; its header has t, j1, note"),
        ("[table.columns]\nt = 1\nA1 = 9\n", "has no column 9; its first row has 3 cells"),
        ("[table.columns]\nt = 't'\nA1 = 'note'\n", "log.csv:2: A1 is 'ab'"),
        ("[table.columns]\nt = 't'\nA1 = { column = 'j1', unit = 'furlong' }\n", "A1: is not understood"),
        (
            "[table]\nangles = 'rad'\n[table.columns]\nt = 't'\nE1 = 'j1'\n",
            "E1: whether it turns or slides is not said",
        ),
        (
            "[table]\nangles = 'rad'\nlengths = 'm'\n[table.columns]\nt = 't'\nE1 = 'j1'\n",
            "E1: whether it turns or slides is not said",
        ),
        ("[table]\norientation = { as = 'wxyz', columns = ['j1'] }\n", "orientation: wxyz has 4 columns"),
        ("table = 3\n", "table: is no table"),
    ],
)
def test_what_can_not_be_meant_is_refused_with_the_place(tmp_path: Path, toml: str, said: str) -> None:
    with pytest.raises(LogError) as error:
        log_of(tmp_path, "t,j1,note\n0,1,ab\n1,2,cd\n", toml)
    assert said in str(error.value)
