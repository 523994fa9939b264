"""Siemens' polar coordinates, CIP, CT, AR= and ANG=, by both readings, against paths worked out by hand.

840D sl, "Programming Manual Fundamentals": a pole by G110 counts from where the tool is, by G111 from the frame's zero, by G112
from the pole before; AP counts from the plane's first axis; CIP goes through I1, J1; CT goes on without a corner; AR is the angle
of the arc.
"""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from two_readings import differences

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import Move, Region
from camrob.witness.cl import read_story

HEAD = "N1 G17 G71 G90 G94\nN2 T1 M6\nN3 D1 S2000 M3\nN4 G54 G0 X0 Y0 Z5\nG1 Z-1 F300\n"
LINE = 6  # of the first block behind it
R2 = math.sqrt(0.5)


def region_of(folder: Path, body: str) -> Region:
    """The one region of a program; both readings understand all of it, and agree."""
    file = folder / "a.mpf"
    file.write_text(f"{HEAD}{body}\nG0 Z20\nM30\n", encoding="utf-8")
    toolpath, story = read_toolpath(file), read_story(file)
    assert story.complete, [gap.text for gap in story.gaps]
    assert not list(differences(toolpath, story))
    (region,) = toolpath.regions
    return region


def ends(region: Region) -> NDArray[np.float64]:
    """X, Y (mm) where the cut of each block ends."""
    last = (region.move == Move.CUT) & np.append(region.line[1:] != region.line[:-1], True) & (region.line >= LINE)
    return region.position[last][:, :2] * 1e3


@pytest.mark.parametrize(
    ("body", "wanted"),
    [
        ("G111 X20 Y20\nG1 AP=0 RP=10\nAP=90\nRP=5", [[30, 20], [20, 30]]),  # RP alone has no angle: below
        ("G1 X10 Y10\nG110 X5 Y0\nG1 AP=90 RP=5\nG112 AP=0 RP=3\nAP=180 RP=1", [[10, 10], [15, 15], [17, 10]]),
        ("G111 AP=45 RP=10\nG1 AP=225 RP=10\nAP=-45", [[0, 0], [20 * R2, 0]]),
        ("G1 AP=30 RP=20", [[20 * math.cos(math.pi / 6), 10]]),  # without a pole, about the zero
        ("G1 ANG=45 X10\nANG=180 X4\nANG=-90 Y0", [[10, 10], [4, 10], [4, 0]]),
        ("R1=8\nG111 X=R1\nG1 AP=R1*0 RP=2*R1", [[24, 0]]),
        ("G1 X10 Y5\nG1 X=IC(10) ANG=0", [[10, 5], [20, 5]]),
    ],
)
def test_straight_lines(tmp_path: Path, body: str, wanted: list[list[float]]) -> None:
    if body.endswith("RP=5"):
        with pytest.raises(ToolpathError, match=r"angle \(AP=\) or radius"):
            region_of(tmp_path, body)
        body = body.removesuffix("\nRP=5")
    assert ends(region_of(tmp_path, body)) == pytest.approx(np.array(wanted, float), abs=1e-9)


@pytest.mark.parametrize(
    ("body", "end", "centre", "angle", "left"),
    [
        ("CIP X30 Y0 I1=15 J1=15", [30, 0], [15, 0], 180, False),
        ("CIP X30 Y0 I1=15 J1=-15", [30, 0], [15, 0], 180, True),
        ("G1 X10 Y10\nG91\nCIP X0 Y20 I1=10 J1=10\nG90", [10, 30], [10, 20], 180, True),
        ("G2 AR=90 I10 J0", [10, 10], [10, 0], 90, False),
        ("G3 X20 Y0 AR=180", [20, 0], [10, 0], 180, True),
        ("G3 X20 Y0 AR=90", [20, 0], [10, 10], 90, True),
        ("G3 X20 Y0 AR=270", [20, 0], [10, -10], 270, True),
        ("G2 X20 Y0 AR=270", [20, 0], [10, 10], 270, False),
        ("G1 X5\nG2 AR=90 I=AC(15) J=AC(0)", [15, 10], [15, 0], 90, False),
        ("G111 X20 Y0\nG1 AP=180 RP=10\nG3 AP=-90", [20, -10], [20, 0], 90, True),
        ("G111 X20 Y0\nG1 AP=180 RP=10\nG2 AP=-90", [20, -10], [20, 0], 270, False),
        ("G1 X10\nCT X20 Y10", [20, 10], [10, 10], 90, True),
        ("G1 X10\nCT X20 Y10\nX30 Y20", [30, 20], [30, 10], 90, False),  # CT stays, and goes on the S
        ("G3 X20 Y0 I10 J0\nCT X40 Y0", [40, 0], [30, 0], 180, False),
    ],
)
def test_arcs(tmp_path: Path, body: str, end: list[float], centre: list[float], angle: float, left: bool) -> None:
    region = region_of(tmp_path, body)
    arc = region.arcs[-1]
    assert ends(region)[-1] == pytest.approx(end, abs=1e-9)
    assert arc.center[:2] * 1e3 == pytest.approx(centre, abs=1e-9)
    assert math.degrees(arc.angle) == pytest.approx(angle)
    assert arc.axis[2] == pytest.approx(1.0 if left else -1.0)


def test_a_circle_through_any_point(tmp_path: Path) -> None:
    """The arc begins where the tool is, passes the point between its ends, and keeps its distance from its middle."""
    rng = np.random.default_rng(0)
    for point, end in rng.uniform(-40.0, 40.0, (12, 2, 2)).round(3):
        region = region_of(tmp_path, f"CIP X{end[0]:g} Y{end[1]:g} I1={point[0]:g} J1={point[1]:g}")
        (arc,) = region.arcs
        away = [math.dist(place, arc.center[:2] * 1e3) for place in ([0.0, 0.0], point, end)]
        assert away == pytest.approx([arc.radius * 1e3] * 3)
        way = region.position[arc.first : arc.last + 1, :2] * 1e3
        off = min(
            abs((b - a)[0] * (point - a)[1] - (b - a)[1] * (point - a)[0]) / float(np.linalg.norm(b - a))
            for a, b in itertools.pairwise(way)
            if 0.0 <= (point - a) @ (b - a) <= (b - a) @ (b - a)
        )
        assert off < 0.02  # the chord tolerance


def test_holes_on_a_circle_by_polar_places(tmp_path: Path) -> None:
    body = "G0 Z5\nG111 X20 Y10\nMCALL CYCLE81(10,0,2,-5)\nG0 AP=0 RP=8\nAP=90\nAP=180\nMCALL"
    region = region_of(tmp_path, body)
    bottoms = region.position[np.isclose(region.position[:, 2], -5e-3)][:, :2] * 1e3
    assert bottoms == pytest.approx(np.array([[28, 10], [20, 18], [12, 10]], float), abs=1e-9)


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        ("CIP X30 Y0 I1=15 J1=0", "lie on a line"),
        ("CIP X30 Y0 Z-2 I1=15 J1=15", "out of its plane"),
        ("CIP X30 Y0", "out of its plane, or without its point"),
        ("CT X20 Y10", "whose direction is known"),
        ("G1 X10\nG0 X12\nCT X20 Y10", "whose direction is known"),
        ("G1 X10\nCT X20 Y0", "straight ahead"),
        ("G1 X10\nTRANS X5\nCT X20 Y10", "whose direction is known"),
        ("G1 ANG=45", "without one coordinate"),
        ("G1 ANG=210 X10", "doesn't lead to its end"),
        ("G1 ANG=90 X10", "doesn't lead to its end"),
        ("G2 AR=400 I10 J0", "AR= without a centre"),
        ("G2 AR=90", "AR= without a centre"),
        ("G2 AR=90 I10 J0 X10", "AR= without a centre"),
        ("G1 AP=10", "is not known"),
        ("G91\nG1 AP=10 RP=5", "in G91"),
        ("G111 X5\nTRANS X5\nG1 AP=0 RP=3", "another frame"),
        ("G111 X5 Y5\nG18\nG1 AP=0 RP=3", "frame or plane"),
        ("G111 X5 G1 Y5 F200", "beside other words"),
        ("G1 X10 AP=10 RP=5", "beside an end"),
    ],
)
def test_what_stays_open_is_refused(tmp_path: Path, body: str, reason: str) -> None:
    file = tmp_path / "a.mpf"
    file.write_text(f"{HEAD}{body}\nG0 Z20\nM30\n", encoding="utf-8")
    with pytest.raises(ToolpathError, match=reason):
        read_toolpath(file)
    assert read_story(file).gaps
