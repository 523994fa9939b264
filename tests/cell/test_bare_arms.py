"""Cells that are only measured: short, of either convention or a URDF, and all that is wrong in one reported at once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from camrob.cell.read_cell import read_cell
from camrob.cell.urdf import cell_urdf
from camrob.errors import CellError
from camrob.kinematics.frames import base_T_tool

ROOT = Path(__file__).resolve().parents[2]
UR10 = ROOT / "tests" / "data" / "ur10"
SHORT = """schema = 1
name = "bare_ur10"
standing = "datasheet"

[arm]
dh = [
  [90, 0, 0, 127.3],
  [0, -612, 0, 0],
  [0, -572.3, 0, 0],
  [90, 0, 0, 163.941],
  [-90, 0, 0, 115.7],
  [0, 0, 0, 92.2],
]

[load]
payload_kg = 10
"""
CRAIG = [  # of a Puma 560 in Craig's form: alpha, a, theta, d (degrees, mm)
    [0, 0, 0, 0],
    [-90, 0, 0, 0],
    [0, 431.8, 0, 149.09],
    [-90, 20.32, 0, 433.07],
    [90, 0, 0, 0],
    [-90, 0, 0, 0],
]


def written(folder: Path, text: str) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "cell.toml").write_text(text)
    return folder


def postures(count: int = 12, axes: int = 6) -> np.ndarray:
    return np.random.default_rng(0).uniform(-2.0, 2.0, (count, axes))


def test_a_bare_arm_is_under_forty_lines_and_is_the_long_ones_arm(tmp_path: Path) -> None:
    assert len(SHORT.splitlines()) < 40
    short, long = read_cell(written(tmp_path / "ur10", SHORT)), read_cell(UR10)
    q = postures()
    assert np.allclose(base_T_tool(short, q), base_T_tool(long, q), atol=1e-12)
    assert short.axis_names == ("A1", "A2", "A3", "A4", "A5", "A6")
    assert short.payload == 10.0
    with pytest.raises(CellError, match=r"has no \[controller\], which post needs"):
        short.checked_for("post", controller=True)


def craig(rows, q: np.ndarray) -> np.ndarray:
    """The book's transforms, multiplied out: Rx(alpha) Dx(a) Rz(theta) Dz(d)."""
    T = np.eye(4)
    for (alpha, a, theta, d), turn in zip(rows, q, strict=True):
        ca, sa = np.cos(np.deg2rad(alpha)), np.sin(np.deg2rad(alpha))
        ct, st = np.cos(np.deg2rad(theta) + turn), np.sin(np.deg2rad(theta) + turn)
        T = T @ np.array(
            [
                [ct, -st, 0, 1e-3 * a],
                [st * ca, ct * ca, -sa, -1e-3 * d * sa],
                [st * sa, ct * sa, ca, 1e-3 * d * ca],
                [0, 0, 0, 1.0],
            ]
        )
    return T


def test_rows_of_the_modified_convention(tmp_path: Path) -> None:
    text = f'schema = 1\nname = "puma"\nstanding = "paper"\n[arm]\nconvention = "modified"\ndh = {CRAIG}\n'
    cell = read_cell(written(tmp_path / "puma", text))
    for q in postures():
        assert np.allclose(base_T_tool(cell, q[None])[0], craig(CRAIG, q), atol=1e-12)


def test_signs_offsets_and_an_axis_that_slides(tmp_path: Path) -> None:
    text = SHORT.replace(
        "[load]", 'signs = [1, -1, 1, 1, 1, 1]\noffsets_deg = [0, 30, 0, 0, 0, 0]\nkinds = "RRPRRR"\n[load]'
    )
    cell = read_cell(written(tmp_path / "slides", text))
    q = cell.to_q(np.array([10.0, 50.0, 200.0, 0.0, 0.0, 0.0]))
    assert q[:3] == pytest.approx([np.deg2rad(10.0), -np.deg2rad(20.0), 0.2])


def test_a_urdf_gives_the_chain_and_its_masses(tmp_path: Path) -> None:
    """Against the cell that the URDF was written from, and Pinocchio's reading of the same file."""
    import pinocchio as pin

    long = read_cell(UR10)
    folder = written(tmp_path / "urdf", 'schema = 1\nname = "urdf"\nstanding = "measured"\n[arm]\nurdf = "arm.urdf"\n')
    (folder / "arm.urdf").write_text(cell_urdf(long))
    cell = read_cell(folder)
    model = pin.buildModelFromUrdf(str(folder / "arm.urdf"))
    data = model.createData()
    for q in postures():
        pin.framesForwardKinematics(model, data, pin.neutral(model) if model.nq != 6 else q)
        placed = data.oMf[model.getFrameId("tool")]
        assert np.allclose(base_T_tool(cell, q[None])[0], placed.homogeneous, atol=1e-9)
    assert sum(m.mass for m in cell.masses) == pytest.approx(sum(m.mass for m in long.masses))
    assert [m.after for m in cell.masses] == ["A1", "A2", "A3", "A4", "A5", "A6"]
    assert cell.joints[1].upper == pytest.approx(2 * np.pi)


def test_a_urdf_with_an_axis_that_is_not_z(tmp_path: Path) -> None:
    text = """<robot name="two"><link name="base"/><link name="one"/><link name="two"><inertial><origin xyz="0.1 0 0"/>
    <mass value="2.5"/></inertial></link><link name="tip"/>
    <joint name="a" type="revolute"><parent link="base"/><child link="one"/><origin xyz="0 0 0.3" rpy="0 0 0.5"/>
    <axis xyz="0 1 0"/><limit lower="-1" upper="2" effort="0" velocity="1"/></joint>
    <joint name="b" type="prismatic"><parent link="one"/><child link="two"/><origin xyz="0.2 0 0"/>
    <axis xyz="0 0 -1"/></joint>
    <joint name="c" type="fixed"><parent link="two"/><child link="tip"/><origin xyz="0 0.05 0"/></joint></robot>"""
    folder = written(tmp_path / "two", 'schema = 1\nname = "two"\nstanding = "measured"\n[arm]\nurdf = "two.urdf"\n')
    (folder / "two.urdf").write_text(text)
    cell = read_cell(folder)
    q = np.array([[0.4, 0.07]])
    c, s, C, S = np.cos(0.5), np.sin(0.5), np.cos(0.4), np.sin(0.4)
    turned = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]]) @ np.array([[C, 0, S], [0, 1, 0], [-S, 0, C]])
    assert np.allclose(base_T_tool(cell, q)[0, :3, 3], [0, 0, 0.3] + turned @ [0.2, 0.05, -0.07], atol=1e-12)
    assert np.allclose(base_T_tool(cell, q)[0, :3, :3], turned, atol=1e-12)
    assert (cell.joints[0].lower, cell.joints[0].upper) == (-1.0, 2.0)
    assert cell.masses[0].mass == 2.5


BAD = {
    "no rows": ("[arm]\n", "one of the two is needed"),
    "eight rows": (f"[arm]\ndh = {[[0, 0, 0, 0]] * 8}\n", "has 8 rows"),
    "short rows": ("[arm]\ndh = [[0, 0, 0]]\n", "rows of 4 finite numbers"),
    "a convention of its own": ('[arm]\nconvention = "mine"\ndh = [[0, 0, 0, 0]]\n', "use one of standard, modified"),
    "a file elsewhere": ('[arm]\nurdf = "../arm.urdf"\n', "is not a file in the cell's folder"),
    "signs": ("[arm]\ndh = [[0, 0, 0, 0]]\nsigns = [2]\n", "holds others than 1 and -1"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_wrong_is_reported(tmp_path: Path, name: str) -> None:
    part, words = BAD[name]
    with pytest.raises(CellError, match=words):
        read_cell(written(tmp_path / "bad", f'schema = 1\nname = "bad"\nstanding = "assumed"\n{part}'))


def test_a_urdf_that_would_read_other_files_is_refused(tmp_path: Path) -> None:
    folder = written(tmp_path / "evil", 'schema = 1\nname = "evil"\nstanding = "assumed"\n[arm]\nurdf = "arm.urdf"\n')
    (folder / "arm.urdf").write_text(
        '<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot name="r">&x;</robot>'
    )
    with pytest.raises(CellError, match="declares entities"):
        read_cell(folder)


def test_all_that_is_wrong_is_reported_at_once_in_one_line(tmp_path: Path) -> None:
    text = SHORT.replace("payload_kg = 10", 'payload_kg = "ten"') + "[tool]\nflange_to_tool = [1, 2]\n"
    text += '[[mass]]\nname = "m"\nafter = "A9"\nmass_kg = 1\ncenter_mm = [0, 0, 0]\n[poses]\nposition_mm = -1\n'
    with pytest.raises(CellError) as caught:
        read_cell(written(tmp_path / "many", text))
    message = str(caught.value)
    assert "\n" not in message
    assert "3 things are wrong" in message
    for words in ("tool.flange_to_tool", "load.payload_kg", "poses.position_mm"):
        assert words in message
    text = (
        text.replace('"ten"', "10")
        .replace("[1, 2]", "[0, 0, 0, 0, 0, 0]")
        .replace("position_mm = -1", "position_mm = 1")
    )
    with pytest.raises(CellError, match="use one of A1, A2"):
        read_cell(written(tmp_path / "many", text))


@pytest.mark.parametrize("key", ["home_deg", "axis", "limits", "characteristic_length_mm"])
def test_a_cell_that_programs_are_made_for_still_needs_all_of_it(tmp_path: Path, key: str) -> None:
    text = (ROOT / "cells" / "kr15_track_table" / "cell.toml").read_text()
    lines = text.splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith(f"{key} ="))
    folder = written(tmp_path / "kr15", "\n".join(lines[:first] + lines[first + 1 :]) + "\n")
    for name in ("weights_jnt.fis", "weights_cond.fis"):
        (folder / name).write_bytes((ROOT / "cells" / "kr15_track_table" / name).read_bytes())
    with pytest.raises(CellError, match=f"{key}: is missing"):
        read_cell(folder)


@pytest.mark.parametrize("rows", [["[0, 800, 0, 300]"], ["[90, 0, 0, 340]", "[-90, 0, 0, 0]"] * 3 + ["[0, 0, 0, 126]"]])
def test_poses_of_an_arm_that_has_not_six_axes(tmp_path: Path, rows: list[str]) -> None:
    """k_F is asked of six axes: the poses are checked without it, and one that states it is refused."""
    text = (
        'schema = 1\nname = "other"\nstanding = "datasheet"\n\n[arm]\nconvention = "standard"\ndh = ['
        + ", ".join(rows)
        + "]\n"
    )
    folder = written(tmp_path / "cell", text)
    axes = [f"A{i + 1}_deg" for i in range(len(rows))]
    tip = [800.0, 0.0, 300.0] if len(rows) == 1 else [0.0, 0.0, 3 * 340.0 + 126.0]
    numbers = ",".join(str(x) for x in [*[0.0] * len(rows), *tip, 0.0, 0.0, 0.0])
    head = f"name,{','.join(axes)},x_mm,y_mm,z_mm,a_deg,b_deg,c_deg,inv_kf,source"
    (folder / "poses.csv").write_text(f"{head}\nzero,{numbers},,hand\n", encoding="utf-8")
    assert len(read_cell(folder).joints) == len(rows)
    (folder / "poses.csv").write_text(f"{head}\nzero,{numbers},0.5,hand\n", encoding="utf-8")
    with pytest.raises(CellError, match="six axes"):
        read_cell(folder)
