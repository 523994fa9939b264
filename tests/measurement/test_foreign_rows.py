"""Tables of recorders whose rows are of several runs or files, without a time, in counts, lists, dates, matrices, or Parquet."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet
from scipy.spatial.transform import Rotation

from camrob.errors import LogError
from camrob.measurement.read_log import read_log


def log_of(folder: Path, text: str, toml: str, **beside: str):
    (folder / "log.csv").write_text(text, encoding="utf-8")
    (folder / "log.toml").write_text(toml, encoding="utf-8")
    for name, more in beside.items():
        (folder / f"{name}.txt").write_text(more, encoding="utf-8")
    return read_log(folder / "log.csv")


def refusal(folder: Path, text: str, toml: str, **beside: str) -> str:
    with pytest.raises(LogError) as error:
        log_of(folder, text, toml, **beside)
    return str(error.value)


def test_joints_in_one_file_and_the_trackers_points_of_three_targets_in_another(tmp_path: Path) -> None:
    """Row by row; the target's number stands behind the joints, and each log takes its own."""
    joints, points = "10, 20, 3\n11, 21, 1\n12, 22, 3\n", "# tracker\n1  2 3\n\n4 5 6\n7 8 9\n"
    toml = (
        "poses = true\n[table]\nheader = 0\nlengths = 'cm'\nbeside = { file = 'points.txt', separator = ' ' }\n"
        "rows = { column = 3, is = 3 }\n[table.columns]\nA1 = 1\nA2 = 2\nx = 4\ny = 5\nz = 6\n"
    )
    log = log_of(tmp_path, joints, toml, points=points)
    assert log.axes(["A1", "A2"]).tolist() == [[10.0, 20.0], [12.0, 22.0]]
    assert log.position[1] == pytest.approx([0.07, 0.08, 0.09])
    assert log.file_lines is not None and log.file_lines.tolist() == [1, 3]
    assert "has no row whose 3 is 4; it holds 3, 1" in refusal(tmp_path, joints, toml.replace("is = 3", "is = 4"))
    short = points.replace("7 8 9\n", "")
    assert "has 3 rows, points.txt beside it 2; their rows belong" in refusal(tmp_path, joints, toml, points=short)
    assert "log.csv:2: has 2 cells, its first row 3" in refusal(
        tmp_path, joints.replace(", 1", ""), toml, points=points
    )
    assert "nowhere.txt: can't be read" in refusal(tmp_path, joints, toml.replace("points", "nowhere"))


def test_names_of_the_table_beside_it_and_rows_named_by_a_word(tmp_path: Path) -> None:
    toml = (
        "[table]\nbeside = 'more.txt'\nrows = { column = 'phase', is = ['cut', 'lift'] }\n"
        "[table.columns]\nt = 't'\nA1 = 'q'\ncA1 = 'q_d'\n"
    )
    log = log_of(tmp_path, "t,q,phase\n0,1,cut\n1,2,rest\n2,3,lift\n", toml, more="q_d\n1.5\n2.5\n3.5\n")
    assert log.t.tolist() == [0.0, 2.0]
    assert log.setpoints(["A1"]).tolist() == [[1.5], [3.5]]


def test_rows_at_a_known_step_in_counts_of_the_motors_and_milliamperes(tmp_path: Path) -> None:
    toml = (
        "[table]\nseparator = '|'\nstep_s = 0.1\nrows = { column = 'run', is = 2 }\n[table.columns]\n"
        "A1 = { column = 'n', scale = -0.01, offset = 90 }\ncA1 = { column = 'set', unit = 'rad' }\n"
        "I1 = { column = 'mA', scale = 0.001 }\n"
    )
    log = log_of(tmp_path, "run|n|set|mA\n1|0|0|0\n2|9000|0|250\n2|9100|0.1|260\n", toml)
    assert log.t == pytest.approx([0.1, 0.2])
    assert log.axes(["A1"])[:, 0] == pytest.approx([0.0, -1.0])
    assert log.setpoints(["A1"])[1] == pytest.approx([np.rad2deg(0.1)])
    assert log.columns["I1"].tolist() == [0.25, 0.26]


def test_an_axis_that_stood_still_and_a_gauge_that_sees_one_direction(tmp_path: Path) -> None:
    """A length gauge along a stage: x and y are where they were commanded; A2 was clamped at 0.5 rad and not logged."""
    toml = (
        "poses = true\n[table]\n[table.columns]\nA1 = 'set'\nA2 = { value = 0.5, unit = 'rad' }\nx = { value = 0 }\n"
        "y = { value = 12.5 }\nz = 'seen'\n"
    )
    text = "set,seen\n0,0.001\n10,10.002\n"
    log = log_of(tmp_path, text, toml)
    assert log.axes(["A2"])[:, 0] == pytest.approx(np.rad2deg([0.5, 0.5]))
    assert log.position[1] == pytest.approx([0.0, 0.0125, 0.010002])
    said = refusal(tmp_path, text, toml.replace("{ value = 0 }", "{ value = 'none' }"))
    assert "x: is not understood; { value = 0 } is of an axis that stood still" in said
    assert "x: is not understood" in refusal(tmp_path, text, toml.replace("value = 0 ", "value = 0, scale = 2 "))


@pytest.mark.parametrize(
    ("stamps", "seconds"),
    [
        (["2026-02-24T11:52:23.435+01:00", "2026-02-24T11:52:23.485+01:00"], [0.0, 0.05]),
        (["2022-10-19 15:57:53.342698", "2022-10-19 15:58:00"], [0.0, 6.657302]),
        (["15:57:53.25", "15:57:54"], [57473.25, 57474.0]),
    ],
)
def test_stamps_of_clocks(tmp_path: Path, stamps: list[str], seconds: list[float]) -> None:
    toml = "[table]\ntime = 'ms'\n[table.columns]\nt = 'at'\nA1 = 'q'\n"
    log = log_of(tmp_path, f"at,q\n{stamps[0]},1\n{stamps[1]},2\n", toml)
    assert log.t == pytest.approx(seconds, abs=1e-6)
    said = refusal(tmp_path, f"at,q\n{stamps[0]},1\nyesterday,2\n", toml)
    assert "log.csv:3: t is 'yesterday'; give seconds, or dates and times as" in said
    assert "step_s there takes the place of stamps" in refusal(tmp_path, f"at,q\n{stamps[0]},1\n{stamps[0]},2\n", toml)


def test_lists_within_quotes(tmp_path: Path) -> None:
    text = 't,arm,position\n0,left,"[1.5, -2, 3]"\n1,left,"[1.6, -2.5, 3]"\n'
    toml = (
        "[table]\nlengths = 'm'\n[table.columns]\nt = 't'\nA1 = { column = 'position', item = 1 }\n"
        "A2 = { column = 'position', item = 2 }\n"
    )
    assert log_of(tmp_path, text, toml).axes(["A1", "A2"]).tolist() == [[1.5, -2.0], [1.6, -2.5]]
    said = refusal(tmp_path, text, toml.replace("item = 2", "item = 4"))
    assert "log.csv:2: has no item 4 of A2 in this row; the cell is [1.5, -2, 3]" in said


def test_orientations_as_matrices(tmp_path: Path) -> None:
    true = Rotation.from_rotvec([0.3, -0.8, 1.1]).as_matrix()
    header = "t,q,x,y,z," + ",".join(f"m{r}{c}" for r in range(3) for c in range(3))
    row = ",".join(f"{v:.4f}" for v in true.ravel())
    columns = [f"m{r}{c}" for r in range(3) for c in range(3)]
    named = "[table.columns]\nt = 't'\nA1 = 'q'\nx = 'x'\ny = 'y'\nz = 'z'\n"
    text = f"{header}\n0,1,10,20,30,{row}\n1,2,11,20,30,{',' * 8}\n2,3,11,20,30,{row}\n"
    log = log_of(tmp_path, text, f"[table]\norientation = {{ as = 'matrix', columns = {columns} }}\n{named}")
    assert log.rotation[2] == pytest.approx(true, abs=2e-4)
    assert np.linalg.det(log.rotation[2]) == pytest.approx(1.0, abs=1e-12)
    assert np.isnan(log.rotation[1]).all()
    wrong = [*columns[:6], "x", "y", "z"]
    said = refusal(tmp_path, text, f"[table]\norientation = {{ as = 'matrix', columns = {wrong} }}\n{named}")
    assert "log.csv:2: is no rotation; name its nine cells row by row" in said


def test_parquet_of_lists_with_a_picture_and_a_column_of_single_numbers(tmp_path: Path) -> None:
    parquet.write_table(
        pa.table(
            {
                "observation.state": [[1.0, 2.0], [1.5, 2.5]],
                "action": [[1.1, 2.1], [1.6, None]],
                "timestamp": [0.0, 0.033],
                "picture": [b"\x00", b"\x01"],
                "episode_index": [0, 0],
            }
        ),
        tmp_path / "log.parquet",
    )
    lists = {"A": "observation.state", "cA": "action"}
    named = "".join(f"{a}{k} = {{ column = '{c}', item = {k} }}\n" for a, c in lists.items() for k in (1, 2))
    toml = "[table]\nrows = { column = 'episode_index', is = 0 }\n[table.columns]\nt = 'timestamp'\n" + named
    (tmp_path / "log.toml").write_text(toml, encoding="utf-8")
    log = read_log(tmp_path / "log.parquet")
    assert log.axes(["A1", "A2"]).tolist() == [[1.0, 2.0], [1.5, 2.5]]
    assert np.isnan(log.setpoints(["A2"])[1, 0])
    (tmp_path / "log.toml").write_text(toml.replace("'action'", "'acton'"), encoding="utf-8")
    with pytest.raises(LogError, match=r"log\.parquet:1: has no column 'acton'; its header has action"):
        read_log(tmp_path / "log.parquet")
    (tmp_path / "log.parquet").write_bytes(b"no such thing")
    with pytest.raises(LogError, match="is not a Parquet file"):
        read_log(tmp_path / "log.parquet")


@pytest.mark.parametrize(
    ("toml", "said"),
    [
        ("[table]\nstep_s = 0\n", "step_s: is 0; give the seconds from row to row"),
        ("[table]\nstep_s = 0.1\n[table.columns]\nt = 't'\n", "step_s: stands beside a column t"),
        ("[table]\nrows = 3\n", "rows: is not understood; write rows = { column = "),
        ("[table]\nrows = { column = 'n', is = [] }\n", "rows: is not understood"),
        ("[table]\nrows = { column = 'n', is = 'x' }\n", "has the column 'n' twice; give it by number: 3 or 4"),
        ("[table]\nbeside = '../poses.txt'\n", "beside: is not understood; write beside = "),
        ("[table]\nbeside = { file = 'a', separator = 'x' }\n", "separator: is 'x'"),
        ("[table.columns]\nA1 = { column = 'q', scale = 0 }\n", "A1: is not understood"),
        ("[table.columns]\nA1 = { column = 'q', offset = nan }\n", "A1: is not understood"),
        ("[table.columns]\nA1 = { column = 'q', item = 1.5 }\n", "A1: item is 1.5"),
        ("[table]\norientation = { as = ['abc'], columns = [1, 2, 3] }\n", "orientation: is not understood"),
    ],
)
def test_what_can_not_be_meant_is_refused(tmp_path: Path, toml: str, said: str) -> None:
    assert said in refusal(tmp_path, "t,q,n,n\n0,1,a,b\n1,2,a,b\n", toml)


def test_a_table_of_which_nothing_is_named(tmp_path: Path) -> None:
    said = refusal(tmp_path, "time,joint\n0,1\n", "[table]\nangles = 'rad'\n")
    assert "no column of it is named; say in [table.columns]" in said


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("t foo A2\n0 1 2\n", "log.csv:1: separates columns by blanks; separate columns by commas"),
        ("t|A1\n0|1\n", "log.csv:1: separates columns by bars"),
        ("0.5,1.25,-3e-1\n0.6,1.5,-2\n", "log.csv:1: holds numbers where its names should be; name its columns"),
    ],
)
def test_a_table_that_needs_a_description_says_which(tmp_path: Path, text: str, said: str) -> None:
    assert said in refusal(tmp_path, text, "")
