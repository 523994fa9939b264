"""Programs in a machine's own axes: the path in the part is the one that they were made of, by kinematics of the test's own."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from camrob.cell.read_setup import read_machine_tool
from camrob.errors import SetupError, ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.witness.cl import read_story
from camrob.witness.machine_tool import read_machine_tool as witness_machine

TRUNNION = """
feed = "linear"
[[table]]
word = "A"
direction = [-1, 0, 0]
point_mm = [12.0, -30.0, -85.0]
[[table]]
word = "C"
direction = [0, 0, -1]
point_mm = [5.0, 8.0, 0.0]
"""
FORK = """
feed = "all"
lengths_mm = [[1, 110.0]]
[[head]]
word = "C"
direction = [0, 0, 1]
point_mm = [0.0, 0.0, 0.0]
[[head]]
word = "A"
direction = [1, 0, 0]
point_mm = [0.0, 1.5, 160.0]
"""
NUTATING = """
lengths_mm = [[0, 90.0]]
[[head]]
word = "B"
direction = [0, 1, 1]
point_mm = [0.0, -20.0, 140.0]
[[table]]
word = "C"
direction = [0, 0, -1]
point_mm = [40.0, 0.0, 0.0]
"""
MACHINES = {"trunnion": TRUNNION, "fork": FORK, "nutating": NUTATING}


def axis(direction, point, degrees):
    """A rigid motion (4, 4): a turn about a line."""
    out = np.eye(4)
    size = np.linalg.norm(direction)
    out[:3, :3] = Rotation.from_rotvec(np.radians(degrees) * np.array(direction) / size).as_matrix()
    out[:3, 3] = np.array(point) - out[:3, :3] @ point
    return out


def in_part(name, xyz, a, b, c):
    """Tip (mm) and tool axis in the part, worked out machine by machine."""
    tip = np.array([*xyz, 1.0])
    if name == "trunnion":
        carried = axis([-1, 0, 0], [12, -30, -85], a) @ axis([0, 0, -1], [5, 8, 0], c)
        return (np.linalg.inv(carried) @ tip)[:3], np.linalg.inv(carried)[:3, 2]
    if name == "fork":  # the points of its axes, counted from the tip, move along with it
        head = axis([0, 0, 1], [0, 0, 110], c) @ axis([1, 0, 0], [0, 1.5, 270], a)
        return tip[:3] + head[:3, 3], head[:3, 2]
    head = axis([0, 1, 1], [0, -20, 230], b)
    carried = axis([0, 0, -1], [40, 0, 0], c)
    moved = np.array([*(tip[:3] + head[:3, 3]), 1.0])
    return (np.linalg.inv(carried) @ moved)[:3], np.linalg.inv(carried)[:3, :3] @ head[:3, 2]


def blocks(name):
    """A program of the machine's axes (mm, degrees): X, Y, Z, A, B, C row by row."""
    s = np.linspace(0.0, 1.0, 9)
    tilt = {"trunnion": "A", "fork": "A", "nutating": "B"}[name]
    rows = np.zeros((9, 6))
    rows[:, 0], rows[:, 1], rows[:, 2] = 20 + 30 * s, 10 * np.sin(3 * s), 15 - 4 * s
    rows[:, 3 if tilt == "A" else 4] = 5 + 25 * s
    rows[:, 5] = 10 + 70 * s**2
    return tilt, rows


def program(name, feed="G93"):
    """The blocks as a G-code file: down in rapid, then the cuts."""
    tilt, rows = blocks(name)
    at = 3 if tilt == "A" else 4
    words = [f"X{r[0]:.6f} Y{r[1]:.6f} Z{r[2]:.6f} {tilt}{r[at]:.6f} C{r[5]:.6f}" for r in rows]
    lines = ["%", "G21 G90 G94", "T1 M6", "S9000 M3", f"G0 {words[0]}"]
    lines += [f"{'G93 ' if feed == 'G93' else ''}G1 {w} F{60.0 if feed == 'G93' else 600.0}" for w in words[1:]]
    return "\n".join([*lines, "G94", "M30", "%"]) + "\n"


def beside(points, tool, tips, axes):
    """How far points lie off the way through `tips` (m), and their axes off those there (rad)."""
    leg = np.diff(tips, axis=0)
    along = np.einsum("nkj,kj->nk", points[:, None] - tips[None, :-1], leg) / np.sum(leg * leg, axis=1)
    along = np.clip(along, 0.0, 1.0)
    foot = tips[None, :-1] + along[..., None] * leg
    off = np.linalg.norm(points[:, None] - foot, axis=2)
    k, n = off.argmin(axis=1), np.arange(len(points))
    there = axes[k] + along[n, k, None] * (axes[k + 1] - axes[k])
    return off[n, k], np.linalg.norm(tool - there, axis=1)


@pytest.fixture(params=MACHINES)
def case(request, tmp_path):
    """A machine's name, its file, and a program of it."""
    (tmp_path / "mill.toml").write_text(MACHINES[request.param])
    (tmp_path / "a.nc").write_text(program(request.param))
    return request.param, tmp_path / "mill.toml", tmp_path / "a.nc"


def test_reader_and_witness_find_the_way_of_the_machine(case) -> None:
    name, machine, file = case
    toolpath = read_toolpath(file, machine_tool=read_machine_tool(machine), chord_tolerance=1e-6)
    story = read_story(file, machine=witness_machine(machine))
    assert story.complete, [gap.text for gap in story.gaps]
    (region,) = toolpath.regions
    _, rows = blocks(name)
    dense = np.concatenate([*(np.linspace(p, q, 100, endpoint=False) for p, q in pairwise(rows)), rows[-1:]])
    way = [in_part(name, r[:3], *r[3:]) for r in dense]
    tips, axes = np.array([t for t, _ in way]) / 1e3, np.array([u for _, u in way])
    ends = [in_part(name, r[:3], *r[3:]) for r in rows]
    for points, tool in ((region.position, region.axis), (story.path.tip, story.path.axis)):
        points, tool = np.asarray(points), np.asarray(tool)
        off, askew = beside(points, tool, tips, axes)
        assert off.max() < 1e-6 and askew.max() < 1e-4
        assert np.all(np.diff([np.linalg.norm(points - tip / 1e3, axis=1).argmin() for tip, _ in ends]) > 0)
        for tip, up in ends:  # exact where a block ends
            k = np.linalg.norm(points - tip / 1e3, axis=1).argmin()
            assert np.linalg.norm(points[k] - tip / 1e3) < 1e-9
            assert np.linalg.norm(tool[k] - up) < 1e-9
    assert toolpath.points > 40


def test_inverse_time_is_kept(case) -> None:
    _, machine, file = case
    (region,) = read_toolpath(file, machine_tool=read_machine_tool(machine)).regions
    story = read_story(file, machine=witness_machine(machine))
    for points, feed in ((region.position, region.feed), (story.path.tip, story.feed)):
        ways = np.linalg.norm(np.diff(np.asarray(points), axis=0), axis=1)
        seconds = np.nansum(ways / np.asarray(feed)[1:])
        assert seconds == pytest.approx(8.0, rel=2e-4)  # eight blocks of 1/60 minute each


def test_f_counts_what_the_machine_says(tmp_path) -> None:
    for name, machine in MACHINES.items():
        (tmp_path / "mill.toml").write_text(machine)
        (tmp_path / "a.nc").write_text(program(name, "G94"))
        tool = read_machine_tool(tmp_path / "mill.toml")
        if name == "nutating":
            with pytest.raises(ToolpathError, match="what F counts"):
                read_toolpath(tmp_path / "a.nc", machine_tool=tool)
            story = read_story(tmp_path / "a.nc", machine=witness_machine(tmp_path / "mill.toml"))
            assert any("what F counts" in gap.text for gap in story.gaps)
            continue
        _, rows = blocks(name)
        goes = np.diff(rows, axis=0)
        counted = np.linalg.norm(goes[:, :3] if name == "trunnion" else goes, axis=1)
        (region,) = read_toolpath(tmp_path / "a.nc", machine_tool=tool).regions
        story = read_story(tmp_path / "a.nc", machine=witness_machine(tmp_path / "mill.toml"))
        for points, feed in ((region.position, region.feed), (story.path.tip, story.feed)):
            ways = np.linalg.norm(np.diff(np.asarray(points), axis=0), axis=1)
            assert np.nansum(ways / np.asarray(feed)[1:]) == pytest.approx(counted.sum() / 10.0, rel=2e-4)


def test_a_hole_is_drilled_across_a_turned_table_and_not_askew_of_a_head(tmp_path) -> None:
    (tmp_path / "mill.toml").write_text(TRUNNION)
    text = "G21 G90\nT1 M6\nS900 M3\nG0 X10 Y0 Z60 A90 C0\nG81 X10 Y0 Z-5 R2 F100\nG80\nM30\n"
    (tmp_path / "a.nc").write_text(text)
    toolpath = read_toolpath(tmp_path / "a.nc", machine_tool=read_machine_tool(tmp_path / "mill.toml"))
    points = np.concatenate([np.asarray(r.position) for r in toolpath.regions])
    bottom, up = in_part("trunnion", [10, 0, -5], 90, 0, 0)
    assert np.linalg.norm(points - bottom / 1e3, axis=1).min() < 1e-9
    assert np.allclose(up, [0, -1, 0]) or np.allclose(up, [0, 1, 0])
    story = read_story(tmp_path / "a.nc", machine=witness_machine(tmp_path / "mill.toml"))
    assert story.complete, [gap.text for gap in story.gaps]
    assert np.linalg.norm(np.asarray(story.path.tip) - bottom / 1e3, axis=1).min() < 1e-9
    (tmp_path / "mill.toml").write_text(FORK)
    with pytest.raises(ToolpathError):
        read_toolpath(tmp_path / "a.nc", machine_tool=read_machine_tool(tmp_path / "mill.toml"))
    assert read_story(tmp_path / "a.nc", machine=witness_machine(tmp_path / "mill.toml")).gaps


@pytest.mark.parametrize(
    ("block", "said"),
    [
        ("G1 X20 B10 F100", "has no such axis"),
        ("G1 C200 F100", "180 degrees"),
        ("G2 X20 Y0 I5 J0 C20 F100", "turns the machine's rotary axes"),
        ("G68.2 X0 Y0 Z0 I0 J30 K0\nG1 X20 F100", "tilted plane"),
    ],
)
def test_what_it_can_t_tell_is_refused_and_a_gap_of_the_witness(tmp_path, block: str, said: str) -> None:
    (tmp_path / "mill.toml").write_text(TRUNNION)
    (tmp_path / "a.nc").write_text(f"G21 G90 G17\nT1 M6\nS900 M3\nG0 X10 Y0 Z20 A0 C0\nG1 Z5 F100\n{block}\nM30\n")
    with pytest.raises(ToolpathError, match=said):
        read_toolpath(tmp_path / "a.nc", machine_tool=read_machine_tool(tmp_path / "mill.toml"))
    assert read_story(tmp_path / "a.nc", machine=witness_machine(tmp_path / "mill.toml")).gaps


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("lengths_mm = [[1, 110.0]]\n", "", "lengths_mm"),
        ("[[1, 110.0]]", "[[1, 110.0], [1, 90.0]]", "lengths_mm"),
        ("[[1, 110.0]]", "[[1, -3.0]]", "lengths_mm"),
        ('word = "C"', 'word = "A"', "twice"),
        ('word = "C"', 'word = "U"', "word"),
        ("direction = [0, 0, 1]", "direction = [0, 0, 0]", "direction"),
        ('feed = "all"', 'feed = "some"', "feed"),
        ("point_mm = [0.0, 0.0, 0.0]", "point_mm = [0.0, 0.0, nan]", "point_mm"),
        ("point_mm = [0.0, 0.0, 0.0]", "point_mm = [0.0, 0.0, 1e6]", "point_mm"),
        ('feed = "all"', 'feet = "all"', "feet"),
    ],
)
def test_a_machine_that_is_described_wrongly_is_refused_by_key(tmp_path: Path, old: str, new: str, said: str) -> None:
    (tmp_path / "mill.toml").write_text(FORK.replace(old, new))
    with pytest.raises(SetupError, match=said):
        read_machine_tool(tmp_path / "mill.toml")
