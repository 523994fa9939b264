"""Tables as recorders leave them, without a description: read by what their headers say, or asked for what these leave open."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from camrob.errors import LogError
from camrob.measurement.read_log import read_log

ANGLES = np.array([[10.0, -80.0, 95.0], [11.0, -81.0, 94.0], [12.5, -79.25, 93.0]])
PLACE = np.array([[900.25, 10.5, 700.0], [901.0, 11.0, 701.0], [902.0, 12.0, 702.125]])
ROWS = np.column_stack([[0.0, 0.01, 0.02], PLACE, ANGLES])


def table(
    names: str, rows: np.ndarray = ROWS, separator: str = ",", decimal: str = ".", above: str = "", below: str = ""
) -> str:
    """A table of some rows under names that `separator` parts, with lines above and below."""
    body = "\n".join(separator.join(f"{v:.12g}".replace(".", decimal) for v in row) for row in rows)
    return f"{above}{names}\n{body}\n{below}"


def read(folder: Path, text: str, toml: str = "", encoding: str = "utf-8"):
    (folder / "log.csv").write_bytes(text.encode(encoding))
    (folder / "log.toml").write_text(toml, encoding="utf-8")
    return read_log(folder / "log.csv")


SI = ROWS * np.array([1.0, *[1e-3] * 3, *[np.pi / 180.0] * 3])
MS = ROWS * np.array([1e3, *[1.0] * 6])
FOUND = {
    "units beneath": (table("t,x,y,z,A1,A2,A3\ns,m,m,m,rad,rad,rad", SI), "utf-8"),
    "remarks above": (table("T,X,Y,Z,a1,a2,a3", above="// SA 2023\n// Frame: World\n"), "utf-8"),
    "lines above": (table("t,X,Y,Z,A1,A2,A3", above="Robot KR 210\nOperator; Meier, shift 2\n\n"), "utf-8"),
    "German": (
        table("Zeit [s];X [mm];Y [mm];Z [mm];Achse 1 Ist [Grad];Achse 2 Ist [Grad];Achse 3 Ist [Grad]", ROWS, ";", ","),
        "cp1252",
    ),
    "Unicode text of Windows": (
        table("Time [ms]\tX/mm\tY/mm\tZ/mm\tJoint 1 (°)\tJoint 2 (°)\tJoint 3 (°)", MS, "\t"),
        "utf-16",
    ),
    "a summary behind": (table("t,x,y,z,A1,A2,A3", below="Mean,1,2,3,4,5,6\nMax,1,2,3,4,5,6\n"), "utf-8"),
    "UR's own": (table("timestamp,tracker_x_m,tracker_y_m,tracker_z_m,actual_q_0,actual_q_1,actual_q_2", SI), "utf-8"),
    "KUKA's own": (table("t x_mm y_mm z_mm AIPos.A1 AIPos.A2 AIPos.A3", ROWS, " "), "utf-8"),
    "counted from 0": (table("t,Meas X [mm],Meas Y [mm],Meas Z [mm],joint_0,joint_1,joint_2"), "utf-8"),
}


@pytest.mark.parametrize("how", FOUND)
def test_a_table_is_read_as_its_header_says(tmp_path: Path, how: str) -> None:
    log = read(tmp_path, *FOUND[how][:1], encoding=FOUND[how][1])
    assert log.t == pytest.approx(ROWS[:, 0]) and log.matrix("xyz") == pytest.approx(PLACE)
    assert log.matrix(["A1", "A2", "A3"]) == pytest.approx(ANGLES)


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("10:59:59.99", "11:00:00.00"),
        ("28.11.2026 10:00:00,25", "28.11.2026 10:00:00,26"),
        ("11/28/2026 12:59:59.99 PM", "11/28/2026 1:00:00.00 PM"),
        ("2026-11-28T23:59:59.99Z", "2026-11-29T00:00:00Z"),
    ],
)
def test_clocks_are_read(tmp_path: Path, first: str, second: str) -> None:
    log = read(tmp_path, f"Time;X;A1\n{first};1;2\n{second};3;4\n")
    assert np.diff(log.t) == pytest.approx([0.01], abs=1e-6)


def test_quaternions_are_read_by_their_names_in_any_order(tmp_path: Path) -> None:
    turn = Rotation.from_euler("ZYX", [[30.0, 20.0, 10.0]], degrees=True).as_quat()  # x y z w
    for names, order in (("qx,qy,qz,qw", [0, 1, 2, 3]), ("qw,qx,qy,qz", [3, 0, 1, 2])):
        cells = ",".join(f"{v:.12f}" for v in turn[0, order])
        log = read(tmp_path, f"t,X,Y,Z,{names},A1\n0,1,2,3,{cells},10\n")
        assert log.matrix("abc")[0] == pytest.approx([30.0, 20.0, 10.0])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            table("t,X [mm],Y [mm],Z [mm],j1,j2,j3", SI * [1, 1e3, 1e3, 1e3, 1, 1, 1]),
            "'j1' is A1, in a unit that isn't said",
        ),
        (
            table("t,Meas X,Meas Y,Meas Z,A1,A2,A3"),
            "'Meas X' is x, in a unit that isn't said; write it behind the name",
        ),
        (table("Time,X,Y,Z,A1,A2,A3", ROWS * [1e3, *[1] * 6]), "'Time' is t, in a unit that isn't said"),
        (
            table("t,X,Y,Z,Rx,Ry,Rz,A1,A2,A3", np.column_stack([ROWS, ANGLES])),
            "Rx, Ry, Rz may be a rotation vector, or angles",
        ),
        (table("t,X,Meas X,A1,A2,A3,B", ROWS), "'X' and 'Meas X' may both be x"),
        (
            table("timestamp,actual_TCP_pose_0,actual_TCP_pose_1,q,actual_q_0,actual_q_1,actual_q_2", SI),
            "holds no measured position: actual_TCP_pose_0 is what the controller reckons",
        ),
        (table("t,x,y,z,A1,A2,fooo"), "has a column 'fooo'; leave it out"),
    ],
)
def test_what_a_header_leaves_open_is_asked_for(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(LogError) as refused:
        read(tmp_path, text)
    assert f"log.csv:1: {said}" in str(refused.value) and ";" in str(refused.value)


def test_what_table_tells_need_no_header_tell(tmp_path: Path) -> None:
    log = read(tmp_path, table("t,Meas X,Meas Y,Meas Z,j1,j2,j3", SI), '[table]\nlengths = "m"\nangles = "rad"\n')
    assert log.matrix("xyz") == pytest.approx(PLACE) and log.matrix(["A1", "A2", "A3"]) == pytest.approx(ANGLES)
