"""The way of an arm without a closed wrist: the same places as the kernels', and on a UR10e where the log's tool is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from camrob.cell.read_cell import read_cell
from camrob.controller import walk
from camrob.controller.simulate import Simulation, simulate
from camrob.errors import UnreachableError
from camrob.kinematics.arm import Arm
from camrob.languages.krl.reader.read_krl import read_krl
from tests.controller.test_simulate import CELL, HEAD, HOME, lin

WAY = (
    HOME,
    "PTP {A1 5,A2 -85,A3 95,A4 3,A5 85,A6 0,E1 40,E2 4} C_PTP",
    HOME,
    lin(after="C_DIS"),
    lin(x=140, z=560, a=175, e1=30, e2=6, after="C_DIS"),
    "CIRC {X 150,Y -20,Z 560},{X 120,Y 10,Z 565,A 170,B 4,C 18,E1 60,E2 -3} C_DIS",
    lin(x=90, y=30, z=580, a=178, b=2, e1=-20, e2=2),
    HOME,
)


def run(tmp_path: Path, *lines: str, follows: bool = True) -> Simulation:
    path = tmp_path / "p.src"
    path.write_text("\n".join(["DEF p()", *HEAD.split("\n"), *lines, "END"]) + "\n")
    return simulate(read_krl(path), replace(read_cell(CELL), base_follows_table=follows))


@pytest.mark.parametrize("follows", [True, False])
def test_newtons_way_is_the_kernels_way(tmp_path, monkeypatch, follows) -> None:
    """An arm that has a closed wrist, walked as if it had none: lines, arcs, axes, roundings, track and table."""
    by_kernel = run(tmp_path, *WAY, follows=follows)
    monkeypatch.setattr(walk, "Arm", SimpleNamespace(of=lambda cell: replace(Arm.of(cell), closed=None)))
    by_newton = run(tmp_path, *WAY, follows=follows)
    assert by_newton.duration == pytest.approx(by_kernel.duration, abs=1e-6)
    assert by_newton.approximation == by_kernel.approximation and by_kernel.approximation.corners >= 4
    for name, values in by_kernel.log.columns.items():
        assert np.abs(np.asarray(by_newton.log.columns[name]) - values).max() < 2e-5, name


def test_a_ur10e_is_simulated_and_a_pose_out_of_its_reach_is_refused_by_its_line(tmp_path) -> None:
    """Its tool at every row is where Denavit and Hartenberg's published numbers put it; on the line it is on the line."""
    cell = _ur10e(tmp_path)
    head = "$BASE={X 0,Y 0,Z 0,A 0,B 0,C 0}\n$TOOL={X 0,Y 0,Z 0,A 0,B 0,C 0}\n$VEL.CP=0.1\n$ACC.CP=2\n$ADVANCE=3\n$APO.CDIS=2"
    at = np.radians([10, -100, 110, -100, -90, 20])
    begins = _published(at)
    a, b, c = Rotation.from_matrix(begins[:3, :3]).as_euler("ZYX", degrees=True)

    def to(x, y, z, turned):
        place = begins[:3, 3] + [x, y, z]
        return f"LIN {{X {place[0]:.6f},Y {place[1]:.6f},Z {place[2]:.6f},A {a + turned:.6f},B {b:.6f},C {c:.6f}}}"

    start = "PTP {A1 10,A2 -100,A3 110,A4 -100,A5 -90,A6 20}"
    path = tmp_path / "u.src"
    path.write_text("\n".join(["DEF u()", *head.split("\n"), start, to(50, 80, -40, 5), "END"]) + "\n")
    log = simulate(read_krl(path), cell).log.columns
    q = np.radians(np.stack([log[f"A{i}"] for i in range(1, 7)], axis=1))
    places = np.array([_published(row)[:3, 3] for row in q])
    measured = np.stack([log["x"], log["y"], log["z"]], axis=1)
    assert np.abs(places - measured).max() < 1e-3  # mm
    way = measured - measured[0]
    along = np.array([50, 80, -40]) / np.linalg.norm([50, 80, -40])
    assert np.linalg.norm(way[-1] - [50, 80, -40]) < 1e-3
    assert np.linalg.norm(way - np.outer(way @ along, along), axis=1).max() < 1e-3
    path.write_text("\n".join(["DEF u()", *head.split("\n"), start, to(5000, 0, 0, 0), "END"]) + "\n")
    with pytest.raises(UnreachableError):
        simulate(read_krl(path), cell)


def _ur10e(folder: Path):
    """Universal Robots' published rows, as a cell."""
    rows = zip(
        (90, 0, 0, 90, -90, 0), (0, -612.7, -571.55, 0, 0, 0), (180.7, 0, 0, 174.15, 119.85, 116.55), strict=True
    )
    joints = "".join(
        f'[[joint]]\nname = "A{i}"\nrole = "arm"\ntype = "revolute"\n'
        f"dh = {{ alpha_deg = {alpha}, a_mm = {a}, theta_deg = 0, d_mm = {d} }}\naxis = {{ sign = 1, offset_deg = 0 }}\n"
        "home_deg = 0\nreference_deg = 0\nlimits = { range_deg = [-360, 360], speed_deg_s = 120,"
        ' acceleration_deg_s2 = 300, jerk_deg_s3 = 3000 }\nstanding = "datasheet"\n'
        for i, (alpha, a, d) in enumerate(rows, 1)
    )
    (folder / "cell.toml").write_text(
        'schema = 1\nname = "ur"\ntitle = "UR10e"\n[kinematics]\nbase_follows_table = false\ncharacteristic_length_mm = 300\n'
        "base_to_first = [0, 0, 0, 0, 0, 0]\nfoot_to_root = [0, 0, 0, 0, 0, 0]\nwrist_to_flange = [0, 0, 0, 0, 0, 0]\n"
        f'standing = "datasheet"\n{joints}[tool]\nflange_to_tool = [0, 0, 0, 0, 0, 0]\nstanding = "assumed"\n'
        '[load]\npayload_kg = 12\nstanding = "datasheet"\n[controller]\nacc_cp_m_s2 = 2\nvel_ori_deg_s = 200\n'
        'acc_ori_deg_s2 = 400\nori_type = "#VAR"\ncirc_type = "#BASE"\napo_cdis_mm = 0.5\nadvance = 5\n'
        'ptp_velocity_percent = 10\nmax_lines = 20000\nmax_bytes = 4000000\nmax_line_length = 255\nstanding = "assumed"\n'
    )
    return read_cell(folder)


def _published(q) -> np.ndarray:
    """The flange by the maker's own rows, mm."""
    T = np.eye(4)
    for angle, alpha, a, d in zip(
        q,
        np.radians([90, 0, 0, 90, -90, 0]),
        (0, -612.7, -571.55, 0, 0, 0),
        (180.7, 0, 0, 174.15, 119.85, 116.55),
        strict=True,
    ):
        c, s, ca, sa = np.cos(angle), np.sin(angle), np.cos(alpha), np.sin(alpha)
        T = T @ np.array([[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]])
    return T
