"""G-code: the tool axis by hand, feeds, arcs, cycles, planes, and everything that must be refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from camrob.errors import ToolpathError
from camrob.machine_tool import rotary_axes
from camrob.toolpath.gcode.program_frame import euler
from camrob.toolpath.gcode.read_gcode import read_gcode
from camrob.toolpath.recognise import looks_like_gcode
from camrob.toolpath.region import EventKind, Move
from camrob.toolpath.toolpath import Toolpath


@pytest.mark.parametrize("seed", range(8))
def test_between_two_points_a_great_arc_is_near_what_the_rotary_axes_do(seed: int) -> None:
    """Against scipy: the rotary axes of a table-table machine in proportion, beside the great arc that a robot takes."""
    rng = np.random.default_rng(seed)
    (a0, c0), (a1, c1) = np.round(rng.uniform((-15, -180), (15, 180), (2, 2)) * (1.0, 0.3 if seed % 2 else 1.0), 4)
    region = read(TCP + f"G1 X0 Y0 Z0 A{a0:.4f} C{c0:.4f}\nX9 A{a1:.4f} C{c1:.4f}\nM30\n").regions[0]
    rows = np.flatnonzero(region.line == 6)
    share = np.concatenate([[0.0], region.position[rows, 0] / 0.009])
    axis = region.axis[[rows[0] - 1, *rows]]

    def as_turned(s: float) -> np.ndarray:
        a, c = a0 + s * (a1 - a0), c0 + s * (c1 - c0)
        return Rotation.from_euler("XZ", [a, c], degrees=True).inv().apply([0.0, 0.0, 1.0])

    for k in range(len(rows)):
        np.testing.assert_allclose(axis[k + 1], as_turned(share[k + 1]), atol=1e-9)
        turn = math.degrees(math.acos(min(1.0, float(axis[k] @ axis[k + 1]))))
        v = np.cross(axis[k], axis[k + 1])
        sine = float(np.linalg.norm(v))
        way = math.atan2(sine, float(axis[k] @ axis[k + 1]))
        for f in (0.25, 0.5, 0.75):
            on_arc = Rotation.from_rotvec(f * way * v / max(sine, 1e-15)).apply(axis[k])
            off = math.degrees(float(np.linalg.norm(on_arc - as_turned(share[k] + f * (share[k + 1] - share[k])))))
            assert off <= 0.06 * turn + 0.005


CORPUS = Path(__file__).resolve().parents[4] / "shared" / "corpus" / "gcode"
HEAD = "G21 G90 G17 G94\nG0 X0 Y0 Z10\n"
TCP = "G21 G90 G94\nM428\nG0 X0 Y0 Z10 A0 C0\nF600\n"


def read(text: str | bytes, **options: object) -> Toolpath:
    settings_ = {"units": None, "chord_tolerance": 1e-5, "angle_tolerance": math.radians(5.0)} | options
    data = text if isinstance(text, bytes) else text.encode()
    return read_gcode(Path("part.nc"), data, **settings_)  # type: ignore[arg-type]


def refused(text: str | bytes, *, line: int, match: str, **options: object) -> ToolpathError:
    with pytest.raises(ToolpathError, match=match) as caught:
        read(text, **options)
    assert caught.value.line == line, str(caught.value)
    assert caught.value.path == Path("part.nc")
    assert caught.value.hint
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 300
    return caught.value


def codes(path: Toolpath) -> set[str]:
    return {finding.code for finding in path.findings}


def cuts(path: Toolpath, region: int = 0) -> np.ndarray:
    r = path.regions[region]
    return r.position[r.move == Move.CUT] * 1e3


# -- words ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "block",
    [
        "G1 X10.5 Y-2 Z.25 F600",
        "g1x10.5y-2z.25f600",
        "N10 G01 X  10.5   Y -2.  Z +.25 F 600.0",
        "G1 (feed in (slowly)) X10.5 Y-2 Z0.25 F600 ; towards the part",
        "\tg1\tX10.5\tY-2\tZ.25\tF600",
        "F600 Z0.25 Y-2 X10.5 G1",
    ],
)
def test_one_block_in_many_spellings(block: str) -> None:
    path = read(HEAD + block + "\nM30\n")
    region = path.regions[0]
    np.testing.assert_allclose(region.position * 1e3, [[0, 0, 10], [10.5, -2, 0.25]], atol=1e-12)
    np.testing.assert_array_equal(region.move, [Move.RAPID, Move.CUT])
    assert math.isnan(region.feed[0])
    assert region.feed[1] == pytest.approx(0.01)
    np.testing.assert_array_equal(region.line, [2, 3])
    np.testing.assert_array_equal(region.axis, [[0, 0, 1], [0, 0, 1]])
    assert path.dialect == "gcode-3axis"
    assert path.findings == ()


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
def test_line_ends_and_percent(newline: str) -> None:
    text = newline.join(["%", "O1234 (PART)", "G21 G0 X0 Y0 Z5", "G1 Z-1 F100", "%", "rubbish behind the end ["])
    assert cuts(read(text)).tolist() == [[0, 0, -1]]


def test_modal_words_incremental_and_inches() -> None:
    path = read("G20 G0 X1 Y0 Z0\nG1 Y1 F10\nX2\nG91 X1 Y-.5\nG90 G21 X0 F254\nM2\n")
    np.testing.assert_allclose(cuts(path), np.array([[1, 1, 0], [2, 1, 0], [3, 0.5, 0], [0, 0.5, 0]]) * 25.4)
    np.testing.assert_allclose(path.regions[0].feed[1:], 254.0 / 60000.0)


def test_units_are_overruled_and_said() -> None:
    path = read("G20 G0 X1 Y0 Z0\nG1 X2 F60\nM2\n", units="mm")
    assert cuts(path).tolist() == [[2, 0, 0]]
    assert path.units == "mm"
    assert "units-overridden" in codes(path)
    path = read("G0 X1 Y0 Z0\nG1 X2 F60\nM2\n", units="inch")
    assert cuts(path)[0, 0] == pytest.approx(50.8)
    assert (path.units, codes(path)) == ("inch", set())
    assert "units-not-stated" in codes(read("G0 X1 Y0 Z0\nG1 X42 F60\nM2\n"))
    for to, match in ((5, r"4\.0 mm wide in millimetres, 101\.6 mm"), (37, r"36\.0 mm wide in millimetres, 914\.4 mm")):
        with pytest.raises(ToolpathError, match=match + " in inches; say which by --units"):
            read(f"G0 X1 Y0 Z0\nG1 X{to} F60\nM2\n")
    assert "size-implausible" in codes(read("G20 G0 X0 Y0 Z0\nG1 X200 F60\nM2\n"))


# -- rotary axes ----------------------------------------------------------------------------------------------------


def test_axis_formulas_by_hand() -> None:
    angles = np.radians([[90.0, 90.0, 90.0], [30.0, 30.0, 0.0], [-90.0, -90.0, 180.0]])
    s, c = 0.5, math.sqrt(3.0) / 2.0
    np.testing.assert_allclose(rotary_axes("xyzac", angles), [[1, 0, 0], [0, s, c], [0, 1, 0]], atol=1e-15)
    np.testing.assert_allclose(rotary_axes("xyzbc", angles), [[0, 1, 0], [-s, 0, c], [-1, 0, 0]], atol=1e-15)


@pytest.mark.parametrize(
    ("letter", "dialect", "want"), [("A", "gcode-xyzac", [0.5, 0.0]), ("B", "gcode-xyzbc", [0.0, 0.5])]
)
def test_kinematics_is_recognised(letter: str, dialect: str, want: list[float]) -> None:
    path = read(f"G21 M428\nG0 X0 Y0 Z0 {letter}30 C90\nG1 X1 F60\nM30\n")
    assert path.dialect == dialect
    np.testing.assert_allclose(path.regions[0].axis[-1], [*want, math.sqrt(0.75)], atol=1e-15)


def test_wrong_kinematics() -> None:
    refused("M428\nG0 X0 Y0 Z0 A10 B10\nM30\n", line=0, match="A and B both turn")
    refused("M428\nG0 X0 Y0 Z0 A10\nM30\n", line=0, match="A words in a program for xyzbc", kinematics="xyzbc")
    refused("G0 X0\n", line=0, match="kinematics 'abc'", kinematics="abc")


def test_turning_cut_follows_the_rotary_axes_with_the_tip_on_the_line() -> None:
    path = read(TCP + "G1 X0 Y0 Z0 A30 C0\nX10 A30 C60\nM30\n", angle_tolerance=math.radians(2.0))
    region = path.regions[0]
    step = np.arccos(np.clip(np.sum(region.axis[1:] * region.axis[:-1], axis=1), -1, 1))
    assert step.max() <= math.radians(2.0) + 1e-9
    second = region.line == 6
    assert second.sum() == 15  # sin 30 degrees times 60 degrees are 30 degrees on the cone: fifteen steps of two
    np.testing.assert_allclose(region.axis[second, 2], math.cos(math.radians(30.0)), atol=1e-15)
    share = np.arange(1, 16) / 15
    np.testing.assert_allclose(region.position[second] * 1e3, np.outer(share * 10.0, [1, 0, 0]), atol=1e-12)
    turn = np.radians(60.0) * share
    np.testing.assert_allclose(region.axis[second, :2], 0.5 * np.stack((np.sin(turn), np.cos(turn)), 1), atol=1e-15)


def test_a_full_turn_of_c_is_a_cone_and_is_said() -> None:
    path = read(TCP + "G1 A45 F600\nX10 C360\nM30\n")
    last = path.regions[0].axis[path.regions[0].line == 6]
    assert len(last) >= 50
    np.testing.assert_allclose(last.mean(axis=0), [0, 0, math.cos(math.pi / 4)], atol=1e-12)
    assert "rotary-long-way" in codes(path)
    assert "rotary-long-way" not in codes(read(TCP + "G1 A45 F600\nX10 C180\nM30\n"))


def test_radians_are_suspected() -> None:
    fine = "".join(f"G1 X{i} A{0.1 * i + 0.012345678901:.12f} C{0.2 * i + 0.012345678901:.12f}\n" for i in range(6))
    assert "rotary-in-radians" in codes(read(TCP + fine + "M30\n"))
    assert "rotary-in-radians" not in codes(read(TCP + fine + "G1 A30.5\nM30\n"))
    assert "rotary-in-radians" not in codes(read(TCP + "G1 A0.5 C1.25\nA1.5 C0.5\nA2.5\nM30\n"))


@pytest.mark.parametrize("on", ["M428", "M128", "G43.4 H1", "TRAORI", "N5 TRAORI(1)", "G234"])
def test_tcp_on(on: str) -> None:
    path = read(f"G21\n{on}\nG0 X1 Y2 Z3 A-90 C0\nG1 X4 F60\nM30\n", kinematics="xyzac")
    np.testing.assert_allclose(path.regions[0].axis, [[0, -1, 0]] * 2, atol=1e-15)


@pytest.mark.parametrize(("on", "off"), [("M428", "M429"), ("M128", "M129"), ("G43.4", "G49"), ("TRAORI", "TRAFOOF")])
def test_cut_with_tcp_off_and_turned_axes_is_refused(on: str, off: str) -> None:
    refused("G21 G0 X0 Y0 Z0\nG0 A10\nG1 X1 F60\nM30\n", line=3, match="tool centre point is off")
    text = f"G21\n{on}\nG0 X0 Y0 Z0 A10 C0\nG1 X1 F60\n{off}\nG1 X2\nM30\n"
    refused(text, line=6, match="tool centre point is off", kinematics="xyzac")
    assert len(read(text.replace("A10", "A0")).regions) == 1
    assert len(read(text.replace("A10", "A360"), kinematics="xyzac").regions) == 1


def test_after_tcp_is_switched_on_at_turned_axes_all_three_coordinates_must_come() -> None:
    head = "G21 G0 X50 Y60 Z70 A30 C10\nG43.4 H1 Z5\n"
    refused(head + "G1 X1 F60\nM30\n", line=3, match="Y has no known value")
    path = read(head + "G0 X1 Y1\nG1 X2 F60\nM30\n", kinematics="xyzac")
    np.testing.assert_allclose(path.regions[0].position * 1e3, [[1, 1, 5], [2, 1, 5]])
    assert "unplaced-rapid" in codes(path)


# -- feed -----------------------------------------------------------------------------------------------------------


def test_inverse_time() -> None:
    path = read(HEAD + "G93\nG1 X30 Z50 F2\nG1 X30 Z60 F0.5\nG3 X10 Z60 I-10 J0 F1\nM30\n")  # 50 mm in half a minute
    region = path.regions[0]
    assert region.feed[1] == pytest.approx(0.1 / 60.0)
    assert region.feed[2] == pytest.approx(0.005 / 60.0)
    np.testing.assert_allclose(region.feed[3:], math.pi * 0.01 / 60.0)


def test_inverse_time_needs_f_in_each_block_and_forgets_it() -> None:
    refused(HEAD + "G93 G1 X10 F2\nX20\nM30\n", line=4, match="own F")
    refused(HEAD + "G93 G1 X10 F2\nG94 X20\nM30\n", line=4, match="without a feed")
    refused("G21 G93\nG1 X1 Y1 Z1 F2\nM30\n", line=2, match="unknown place")


def test_inverse_time_turn_on_the_spot_takes_the_feed_before_it() -> None:
    path = read(TCP + "G93 G1 X10 F6\nA3 F10\nM30\n")
    np.testing.assert_allclose(path.regions[0].feed[1:], [math.hypot(0.01, 0.0) * 0.1, 0.001])
    assert "turn-on-the-spot" in codes(path)
    refused(TCP + "G93 G1 A3 F10\nM30\n", line=5, match="no path speed")


def test_feed_per_revolution() -> None:
    path = read(HEAD + "G95 S1200 M3\nG1 X10 F0.1\nM30\n")
    assert path.regions[0].feed[1] == pytest.approx(0.12 / 60.0)
    refused(HEAD + "G95\nG1 X10 F0.1\nM30\n", line=4, match="without a spindle speed")


@pytest.mark.parametrize("word", ["", "F0", "F-100"])
def test_feed_is_missing(word: str) -> None:
    refused(HEAD + f"G1 X10 {word}\nM30\n", line=3, match="without a feed")


def test_absurd_feed_is_said() -> None:
    assert "feed-implausible" in codes(read(HEAD + "G1 X10 F78989\nM30\n"))


# -- arcs -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("plane", "code", "end", "center", "middle"),
    [
        ("G17", "G3", "X0 Y10 I-10 J0", (0, 0), (1, 1)),
        ("G17", "G3", "X0 Y10 R10", (0, 0), (1, 1)),
        ("G17", "G2", "X0 Y10 R10", (10, 10), (-1, -1)),
        ("G17", "G2", "X0 Y10 I-10", (0, 0), (-1, -1)),
        ("G17", "G3", "X0 Y10 R-10", (10, 10), (1, 1)),
        ("G17", "G90.1 G3", "X0 Y10 I0 J0", (0, 0), (1, 1)),
    ],
)
def test_arc_of_the_xy_plane(
    plane: str, code: str, end: str, center: tuple[float, float], middle: tuple[float, float]
) -> None:
    path = read(f"G21 {plane} G0 X10 Y0 Z0\n{code} {end} F60\nM30\n")
    points, (arc,) = cuts(path), path.regions[0].arcs
    np.testing.assert_allclose(arc.center * 1e3, [*center, 0], atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(points[:, :2] - center, axis=1), 10.0)
    np.testing.assert_array_equal(points[-1], [0, 10, 0])
    towards = np.array(middle) / math.sqrt(2.0)
    assert np.linalg.norm(points[:, :2] - center - 10.0 * towards, axis=1).min() < 0.5
    assert arc.axis[2] == (1.0 if "G3" in code else -1.0)
    assert (arc.first, arc.last) == (0, len(points))
    chord = np.linalg.norm(0.5 * (points[1:] + points[:-1])[:, :2] - center, axis=1)
    assert (10.0 - chord).max() <= 0.01 + 1e-9


def test_planes_and_directions() -> None:
    # Seen from the plane's positive normal G2 is clockwise: in ZX (G18) from +Z towards -X, in YZ from +Y towards -Z.
    path = read("G21 G18 G0 X0 Y0 Z10\nG2 X-10 Z0 K-10 F60\nM30\n")
    np.testing.assert_allclose(path.regions[0].arcs[0].angle, math.pi / 2)
    np.testing.assert_allclose(path.regions[0].arcs[0].axis, [0, -1, 0])
    path = read("G21 G19 G0 X0 Y10 Z0\nG2 Y0 Z-10 J-10 F60\nM30\n")
    np.testing.assert_allclose(path.regions[0].arcs[0].angle, math.pi / 2)
    np.testing.assert_allclose(path.regions[0].arcs[0].axis, [-1, 0, 0])


def test_full_circle_helix_and_turns() -> None:
    path = read("G21 G0 X10 Y0 Z0\nG2 I-10 F60\nM30\n")
    assert path.regions[0].arcs[0].angle == pytest.approx(2 * math.pi)
    np.testing.assert_allclose(cuts(path).mean(axis=0), 0.0, atol=1e-9)
    path = read("G21 G0 X10 Y0 Z0\nG3 X-10 I-10 Z5 P3 F60\nM30\n")  # two turns and a half
    assert path.regions[0].arcs == ()
    turned = np.unwrap(np.arctan2(cuts(path)[:, 1], cuts(path)[:, 0]))
    assert turned[-1] == pytest.approx(5 * math.pi)
    np.testing.assert_allclose(cuts(path)[:, 2], turned / math.pi, atol=1e-9)


def test_arc_while_the_tool_turns() -> None:
    path = read(TCP + "G1 X10 Y0\nG3 X0 Y10 I-10 A45\nM30\n")
    region = path.regions[0]
    on = region.line == 6
    assert region.arcs == ()
    np.testing.assert_allclose(region.axis[on, 2], np.cos(np.arange(1, on.sum() + 1) / on.sum() * math.pi / 4))


@pytest.mark.parametrize(
    ("block", "match"),
    [
        ("G2 X0 Y10 F60", "without centre"),
        ("G2 X0 Y10 I-10 R10 F60", "both R and a centre"),
        ("G2 X0 Y11 I-10 F60", "apart in radius"),
        ("G2 X10 Y0 R10 F60", "full circle"),
        ("G2 X-30 Y0 R10 F60", "smaller than half"),
        ("G2 X0 Y10 I-10 P1.5 F60", "number of turns"),
        ("G18 G2 X0 Y10 J-10 F60", "without centre"),
        ("G2 I-10 P100000 F60", "points"),
    ],
)
def test_arcs_that_are_none(block: str, match: str) -> None:
    refused(f"G21 G0 X10 Y0 Z0\n{block}\nM30\n", line=2, match=match, chord_tolerance=1e-7)


# -- cycles and planes ----------------------------------------------------------------------------------------------


def heights(body: str) -> list[tuple[float, bool]]:
    region = read("G21 G90\nG0 X0 Y0 Z20\nF100\n" + body + "\nG80\nM30\n").regions[0]
    z = region.position[:, 2] * 1e3
    return [(round(float(h), 3), m == Move.CUT) for h, m in zip(z, region.move, strict=True)]


def test_drilling_cycles() -> None:
    out = heights("G98 G81 X10 Y0 Z-5 R2\nX20")
    assert [h for h, _ in out] == [20, 20, 2, -5, 20, 20, 2, -5, 20]
    assert [n for n, (_, cut) in enumerate(out) if cut] == [3, 7]
    assert heights("G99 G81 X10 Y0 Z-5 R2\nX20")[4:] == [(2, False), (2, False), (-5, True), (2, False)]
    pecks = heights("G99 G83 X10 Z-5 R1 Q2.5")
    assert [h for h, cut in pecks if cut] == [-1.5, -4.0, -5.0]
    assert pecks[4:6] == [(1, False), (-1.246, False)]
    assert [h for h, cut in heights("G99 G73 X10 Z-5 R1 Q4") if not cut][-2:] == [-2.746, 1]
    assert heights("G99 G85 X10 Z-5 R1")[-1] == (1, True)
    steps = heights("G91 G99 G81 X5 Z-3 R-18 L2")
    assert [h for h, cut in steps if cut] == [-1, -1], "R counts from where the cycles began, for every repeat"


@pytest.mark.parametrize(("code", "dwells"), [("G73", 1), ("G83", 1), ("G82", 1), ("G81", 0), ("G85", 0), ("G89", 1)])
def test_a_cycle_rests_at_its_bottom_once_where_it_names_a_time(code: str, dwells: int) -> None:
    path = read(f"G21 G0 X0 Y0 Z20\nF100 S500 M3\n{code} X1 Z-4 R1 Q2 P0.5\nG80\nM30\n")
    region = path.regions[0]
    events = [e for e in region.events if e.kind is EventKind.DWELL]
    assert len(events) == dwells
    for event in events:
        assert event.value == 0.5 and region.position[event.point - 1][2] == pytest.approx(-0.004)


def test_cycle_dwell_is_an_event() -> None:
    path = read("G21 G0 X0 Y0 Z20\nF100 S500 M3\nG82 X1 Z-1 R1 P0.5\nX2 P250\nG86 X3 Z-1 R1\nG80\nM30\n")
    kinds = [(e.kind, e.value) for e in path.regions[0].events]
    assert kinds[1:3] == [(EventKind.DWELL, 0.5), (EventKind.DWELL, 0.25)]
    assert kinds[3][0] == EventKind.DWELL  # P stays
    assert [k for k, _ in kinds[4:]] == [EventKind.SPINDLE_OFF, EventKind.SPINDLE_ON, EventKind.SPINDLE_OFF]
    assert "dwell-in-milliseconds" in codes(path)


@pytest.mark.parametrize(
    ("block", "match"),
    [
        ("G81 X1 Z-5", "without depth Z or retract"),
        ("G83 X1 Z-5 R1", "bite Q"),
        ("G83 X1 Z-5 R1 Q0.0001", "bite Q"),
        ("G81 X1 Z5 R1", "above its retract"),
        ("G84 X1 Z-5 R1", "tapping"),
        ("G81 X1 Z-5 R1 L1000000", "repeats"),
        ("G18 G81 X1 Z-5 R1", "along the tool"),
        ("G2 X0 Y0 I1\nG81 X1 Z-5 R1\nG80\nX5", "coordinates before"),
        ("G0 G81 X1 Z-5 R1", "in one block"),
    ],
)
def test_cycles_that_are_refused(block: str, match: str) -> None:
    line = 3 + block.count("\n")
    refused(f"G21 G0 X0 Y0 Z20\nF100\n{block}\nM30\n", line=line, match=match)


def test_euler_angles_by_hand() -> None:
    x, z = np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    np.testing.assert_allclose(euler("313", (math.pi / 2, math.pi / 6, 0.0)) @ z, [0.5, 0, math.sqrt(0.75)], atol=1e-15)
    np.testing.assert_allclose(euler("313", (math.pi / 2, math.pi / 6, 0.0)) @ x, [0, 1, 0], atol=1e-15)
    np.testing.assert_allclose(euler("323", (0.0, math.pi / 2, 0.0)) @ z, [1, 0, 0], atol=1e-15)


def test_tilted_plane() -> None:
    text = "G21 G0 X0 Y0 Z50\nG68.2 X100 Y0 Z10 I90 J30 K0\nG53.1\nG0 X0 Y0 Z5\nG1 X10 F60\nG3 X20 Y10 J10\n{}M30\n"
    path = read(text.format(""))
    region = path.regions[0]
    s, c = 0.5, math.sqrt(0.75)
    np.testing.assert_allclose(region.axis, [[s, 0, c]] * len(region), atol=1e-12)
    np.testing.assert_allclose(region.position[0] * 1e3, [100 + 5 * s, 0, 10 + 5 * c], atol=1e-9)
    np.testing.assert_allclose(region.position[1] * 1e3, [100 + 5 * s, 10, 10 + 5 * c], atol=1e-9)
    np.testing.assert_allclose(region.arcs[0].axis, [s, 0, c], atol=1e-12)
    np.testing.assert_allclose(region.position[-1] * 1e3, [100 + 5 * s - 10 * c, 20, 10 + 5 * c + 10 * s])
    drilled = read(text.format("G81 X0 Y0 Z-5 R2\nG80\n")).regions[0]
    np.testing.assert_allclose(drilled.position[-2] * 1e3, [100 - 5 * s, 0, 10 - 5 * c], atol=1e-9)


def test_tilted_planes_that_are_refused() -> None:
    head = "G21 G0 X0 Y0 Z50\nG68.2 X0 Y0 Z0 I90 J30 K0\n"
    refused(head + "G0 X0 Y0 Z5\nG1 X10 F60\nM30\n", line=4, match="not turned onto it")
    refused(head + "G53.1\nG1 X10 F60\nM30\n", line=4, match="Y and Z has no known value")
    refused(head + "G53.1\nG0 X0 Y0 Z5\nG69\nG0 X0 Y0 Z50\nG1 X10 F60\nM30\n", line=7, match="only the control knows")
    refused(head + "G43.4\nM30\n", line=3, match="in a tilted plane")
    refused("G68.2 P1 X0 Y0 Z0 I1 J1 K1\n", line=1, match="Euler")
    refused("G68.2 X0 Y0 Z0 I1 J1 K1 R5\n", line=1, match="Euler")  # LinuxCNC's further turn
    refused("G68.2 X0 Y0 Z0 A1\n", line=1, match="Euler")
    refused("G53.1\n", line=1, match="without a tilted plane")


# -- events, regions, offsets ---------------------------------------------------------------------------------------


def test_events() -> None:
    text = (
        "G21 G0 X0 Y0 Z5\nT3 M6\nS8000 M3\nM8\n(MSG, look at the clamp)\nG0 X1\nG1 Z0 F60\nG4 P0.5\nX5 S9000\n"
        "M0\nG0 Z5 M9\nM30\n"
    )
    path = read(text)
    (region,) = path.regions
    got = [(e.point, e.kind, e.value, e.text, e.line) for e in region.events]
    assert got == [
        (0, EventKind.TOOL_CHANGE, 3.0, "", 2),
        (0, EventKind.SPINDLE_ON, 8000.0, "CLW", 3),
        (0, EventKind.COOLANT_ON, 0.0, "FLOOD", 4),
        (0, EventKind.MESSAGE, 0.0, "look at the clamp", 5),
        (2, EventKind.DWELL, 0.5, "", 8),
        (2, EventKind.SPINDLE_ON, 9000.0, "CLW", 9),
        (3, EventKind.STOP, 0.0, "M0", 10),
        (4, EventKind.COOLANT_OFF, 0.0, "", 11),
        (4, EventKind.SPINDLE_OFF, 0.0, "", 12),
    ]
    assert (region.tool, [t.number for t in path.tools]) == (3, [3])


def test_regions_by_tool_and_by_turn_but_not_by_retract() -> None:
    body = "T1 M6\nG0 X0 Y0 Z5\nG1 Z0 F60\nG0 Z5\nG0 X9\nG1 Z0\nG0 Z5\nT2 M6\nG0 X0\nG1 Z0\nG0 Z9\nM30\n"
    path = read("G21\n" + body)
    assert [(r.tool, len(r)) for r in path.regions] == [(1, 6), (2, 3)]
    assert len({r.name for r in path.regions}) == 2
    turning = "G1 Z0\nG0 Z5\n" + "".join(f"G0 A{a} C0\n" for a in range(4, 44, 4)) + "G1 Z0\nG0 Z5\nM5\nG0 A0\nM30\n"
    path = read(TCP + turning)
    first, second = path.regions
    assert first.line.tolist() == [3, 5, 6, 7, 8]
    assert second.line[-1] == 18
    assert [e.kind for e in second.events] == []
    assert math.acos(second.axis[0, 2]) == pytest.approx(math.radians(12.0))
    assert len(read(TCP + "G1 Z0\nG0 Z5\nG0 A8\nG1 Z0\nM30\n").regions) == 1
    alone = read(TCP + "G0 A40 C0\nG1 Z0\nM30\n").regions  # the upright place before it is not part of the path
    assert [r.line.tolist() for r in alone] == [[5, 6]]


def test_machine_positions_end_a_region() -> None:
    path = read("G21 G0 X0 Y0 Z5\nG1 Z-3 F60\nG91 G28 Z0\nG90 G0 X50 Y50\nG0 Z5\nG1 Z-3\nG53 G0 Z0\nM30\n")
    assert [r.position.shape[0] for r in path.regions] == [2, 2]
    np.testing.assert_allclose(
        path.regions[1].position[0] * 1e3, [50, 50, 5]
    )  # never from -3 sideways through the part
    assert "machine-position" in codes(path)
    refused("G21 G0 X0 Y0 Z5\nG28 Z0\nG1 X5 F60\nM30\n", line=3, match="Z has no known value")


def test_offsets() -> None:
    assert codes(read("G21 G55 G0 X0 Y0 Z5\nG55 G1 X1 F60\nM30\n")) == set()
    refused("G21 G54 G0 X0 Y0 Z5\nG1 X1 F60\nG55 G0 X0 Y0 Z5\nG1 X1\nM30\n", line=3, match="several work offsets")
    path = read("G21 G0 X0 Y0 Z5\nG52 X100 Y0\nG1 X1 F60\nG52 X0\nG1 X2\nM30\n")
    np.testing.assert_allclose(cuts(path)[:, 0], [101, 2])
    assert "origin-set" in codes(read("G21 G92 X0 Y0 Z5\nG0 X0 Y0\nG1 X1 F60\nM30\n"))
    refused("G21 G0 X0 Y0 Z5\nG92 X9\nM30\n", line=2, match="middle of the program")
    refused("G21 G0 X0 Y0 Z5\nG10 L2 P1 X9\nM30\n", line=2, match="middle of the program")


def test_what_is_said() -> None:
    path = read(HEAD + "G41 D0 F60\nG1 X1\nG40\nG42 G1 X2\nM77\n/G1 X3\nG187 P3\n")
    counts = {f.code: (f.count, f.line) for f in path.findings}
    assert counts == {
        "cutter-compensation": (2, 3),
        "unknown-m-code": (1, 7),
        "block-delete": (1, 8),
        "no-program-end": (1, 10),
    }


def test_t_changes_the_tool_where_there_is_no_m6() -> None:
    path = read(HEAD + "T1\nF60\nG1 X1\nG0 Z5\nT2\nG1 X2\nM30\n")
    assert [r.tool for r in path.regions] == [1, 2]


# -- refused --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("block", "match"),
    [
        ("G1 X#1", "machine's state"),
        ("o<square> call", "not in this file"),
        ("o100 while [1 lt 2]", "without its end"),
        ("WHILE", "can't be read"),
        ("IF", "can't be read"),
        ("G71 Z50", "words of its own"),
        ("G13 I5 D1 F100", "circular pocket"),
        ("G150 X1 Z-2 R1 Q1 D1", "a pocket"),
        ("O200", "O-words"),
        ("M98 P100", "not in this file"),
        ("H=5", "assignment"),
        ("G1 X1,5", "comma"),
        ("G1 X1.5E3", "exponent"),
        ("G1 X1e-5", "exponent"),
        ("G1 XNAN", "no number follows X"),
        ("G1 XINF", "no number follows X"),
        ("G1 X", "no number follows X"),
        ("G1 X--5", "no number|not a G-code word"),
        ("G1 X1.2.3", "not a G-code word"),
        ("G1 X1 2", "not a G-code word"),
        ("G1 X1 X2", "twice"),
        ("G1 X99999999999", "proportion"),
        ("G1 X9999999", "kilometre"),
        ("G1 X" + "9" * 4000, "proportion"),
        ("G1.23 X1", "not a G code"),
        ("G-1 X1", "not a G code"),
        ("G0 G1 X1", "in one block"),
        ("G5 X1 Y1 I1 J1", "not known here"),
        ("G123 X1", "not known here"),
        ("G5.1 X1 Y1 I1 J1", "not known here"),
        ("G51 P2", "scaling"),
        ("G96 S100", "surface speed"),
        ("G43.5 I0 J0 K0", "without a length"),
        ("G1 W5", "secondary axes"),
        ("M6", "without a T"),
        ("T1.5", "tool number"),
        ("G1 X1 (open", "parenthesis"),
        ("G1 X1 ) Y2", "parenthesis|no G-code word"),
        ("G1 Xſ5", "character"),
        ("ＧX1", "character"),
        ("M430", "user's own"),
        ("G4", "without its time"),
        ("S-100 M3", "negative"),
        ("hello world", "no number follows"),
    ],
)
def test_a_block_that_is_refused(block: str, match: str) -> None:
    refused(f"G21 G0 X0 Y0 Z5\nG94 F100\n{block}\nM30\n", line=3, match=match)


def test_files_that_are_refused() -> None:
    refused(b"", line=0, match="empty")
    refused(b" \r\n \t\n", line=0, match="empty")
    refused(b"G1 X1\n\x00\x01\x02", line=2, match="binary")
    for wide in ("utf-16", "utf-16-le", "utf-16-be"):  # with its mark, and without
        refused("G21\nG0 X1\n".encode(wide), line=0, match="UTF-16")
    refused(b"%\n(nothing)\n%\n", line=0, match="no G-code")
    refused("G21\nG0 X1 Y1 Z1\nM30\n", line=4, match="nothing is cut")
    refused(HEAD + "G1 X10 F100\nG1 X2", line=4, match="no end")
    refused("%\n" + HEAD + "G1 X10 F100\n", line=5, match="no end")
    refused("F100\nX1 Y1 Z1\nM30\n", line=2, match="coordinates before")
    refused("G1 X1 F60\nM30\n", line=1, match="Y and Z has no known value")
    refused(HEAD, line=0, match="units 'furlong'", units="furlong")


def test_every_cut_of_a_real_program_at_any_byte_is_refused_or_said() -> None:
    whole = TCP + "T1 M6\nG1 X1 A5 C5\nG2 X3 I1 J0\nG93 G1 X5 F20\nM30\n"
    for stop in range(len(whole) - 5):
        try:
            path = read(whole[:stop])
        except ToolpathError as error:
            assert error.what
        else:
            assert "no-program-end" in codes(path), whole[:stop]


@pytest.mark.parametrize(
    "data",
    [
        b"G1 X" + b"1" * 100_000_000,
        b"(" + b"a" * 50_000_000,
        b" " * 50_000_000,
        (b"(" * 9000 + b"\n") * 1000,
        (b"G1 A" + b" " * 9000 + b"\n") * 1000,
        b"\0" * 50_000_000,
    ],
    ids=["digits", "comment", "blanks", "parentheses", "gaps", "zeros"],
)
def test_huge_input_is_refused(data: bytes) -> None:
    looks_like_gcode(data)
    with pytest.raises(ToolpathError):
        read(data)


@pytest.mark.slow
def test_forty_thousand_blocks_are_all_read() -> None:
    blocks = 40_000
    text = TCP + "".join(f"G1 X{i % 97}.5 Y{i % 31} A{i % 3} C{i % 5}\n" for i in range(blocks)) + "M30\n"
    assert read(text).points >= blocks


def test_message_text_can_not_leave_its_line() -> None:
    path = read(HEAD + "(MSG, a\x85b\u2028c)\nG1 X1 F60\nM30\n")
    (event,) = path.regions[0].events
    assert event.text == "a b c"
    assert event.text.isprintable()


# -- fuzz -----------------------------------------------------------------------------------------------------------

_WORD = st.builds(
    lambda letter, value: f"{letter}{value}",
    st.sampled_from("XYZABCIJKRFPQLSTHDO"),
    st.one_of(st.integers(-50, 50), st.floats(-400, 400).map(lambda v: f"{v:.3f}")),
)
_CODE = st.sampled_from(
    "G0 G1 G2 G3 G4 G17 G18 G19 G20 G21 G28 G40 G41 G43 G43.4 G49 G52 G53 G53.1 G54 G55 G68.2 G69 G73 G80 G81 G82 G83 "
    "G85 G86 G89 G90 G90.1 G91 G92 G93 G94 G95 G98 G99 M0 M3 M5 M6 M8 M9 M30 M128 M129 M428 M429 M77 TRAORI".split()
)
_BLOCK = st.lists(st.one_of(_WORD, _CODE), max_size=6).map(" ".join)


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.lists(_BLOCK, max_size=25), st.sampled_from([None, "xyzac", "xyzbc"]))
def test_any_program_is_read_or_refused(blocks: list[str], kinematics: str | None) -> None:
    text = "G21 F100 G0 X0 Y0 Z5\n" + "\n".join(blocks) + "\nG1 X1\nM30\n"
    try:
        path = read(text, kinematics=kinematics, chord_tolerance=1e-3)
    except ToolpathError as error:
        assert error.path == Path("part.nc")
        return
    for region in path.regions:
        assert np.isfinite(region.position).all()
        np.testing.assert_allclose(np.linalg.norm(region.axis, axis=1), 1.0, atol=1e-9)
        cutting = region.move == Move.CUT
        assert cutting.any()
        assert (region.feed[cutting] > 0.0).all()
        assert (np.diff(region.line) >= 0).all()
        assert all(0 <= event.point <= len(region) for event in region.events)
        for arc in region.arcs:
            points = region.position[arc.first : arc.last + 1]
            np.testing.assert_allclose(np.linalg.norm(points - arc.center, axis=1), arc.radius, atol=2e-3)


@settings(max_examples=300, deadline=None)
@given(st.one_of(st.binary(max_size=200), st.text(alphabet="GMXYZ0123456789.-+ \n%()/;#[]=NOE", max_size=200)))
def test_any_bytes_are_read_or_refused(data: bytes | str) -> None:
    looks_like_gcode(data if isinstance(data, bytes) else data.encode())
    try:
        read(data)
    except ToolpathError as error:
        assert error.path == Path("part.nc")


# -- recognition and real files -------------------------------------------------------------------------------------


def test_what_looks_like_gcode() -> None:
    assert looks_like_gcode(b"%\nO100\nN10 G90 G21\nX1\n")
    assert looks_like_gcode(b"(header)\r\n  g0x1y2\r\n")
    for other in (
        b"",
        b"TOOL PATH/MILL,TOOL,T1\nTLDATA/MILL,10.0\nGOTO/1.0,2.0,3.0\n",
        b"$$ comment\nPARTNO G1 X\nGOTO / 0, 0, 0\n",
        b"&ACCESS RVP\nDEF main()\nPTP {A1 0}\nLIN {X 1}\n",
        b"M1=PLANE/P1,P2\n",
        b"\0\1\2G1 X1\n",
    ):
        assert not looks_like_gcode(other), other


def corpus(name: str) -> tuple[Toolpath, list[str]]:
    file = CORPUS / name
    if not file.exists():
        pytest.skip("../shared is not here: the G-code corpus")
    data = file.read_bytes()
    assert looks_like_gcode(data)
    return read(data), data.decode().splitlines()


def test_impeller_of_seven_blades() -> None:
    path, lines = corpus("linuxcnc_impeller-7bl-xyzac.ngc")
    assert path.dialect == "gcode-xyzac"
    assert codes(path) == {"units-not-stated"}
    assert len(path.regions) == 15  # one run over all blades, then two operations of seven blades each
    for name in ("operation 2", "operation 3"):
        blades = [r for r in path.regions if r.operation == name]
        middle = [np.mean(r.position[r.move == Move.CUT], axis=0) for r in blades]
        turn = np.unwrap([math.atan2(m[1], m[0]) for m in middle])
        np.testing.assert_allclose(np.abs(np.diff(turn)), 2.0 * math.pi / 7.0, atol=2e-3)
    programmed = [i for i, text in enumerate(lines, 1) if text.startswith("G1")]
    got = {int(n) for r in path.regions for n in r.line[r.move == Move.CUT]}
    assert got == set(programmed)
    feed = np.concatenate([r.feed[r.move == Move.CUT] for r in path.regions]) * 60000.0
    assert 100.0 < np.median(feed) < 300.0
    assert feed.min() > 5.0
    assert feed.max() < 10_000.0


def test_impeller_axis_points_outwards() -> None:
    path, _ = corpus("linuxcnc_impeller-7bl-xyzac.ngc")
    first = path.regions[0]
    a, c = np.radians([-71.841, -35.930])
    np.testing.assert_allclose(first.axis[0], [np.sin(a) * np.sin(c), np.sin(a) * np.cos(c), np.cos(a)], atol=1e-15)
    position = np.concatenate([r.position for r in path.regions])[:, :2]
    axis = np.concatenate([r.axis for r in path.regions])[:, :2]
    cosine = np.sum(position * axis, axis=1) / np.linalg.norm(position, axis=1) / np.linalg.norm(axis, axis=1)
    assert cosine.mean() == pytest.approx(0.46, abs=0.015)


def test_boat() -> None:
    path, _ = corpus("linuxcnc_boat-xyzac.ngc")
    assert path.dialect == "gcode-xyzac"
    assert codes(path) == {"units-not-stated"}
    assert [r.tool for r in path.regions] == [1] * 6
    feed = np.concatenate([r.feed[r.move == Move.CUT] for r in path.regions]) * 60000.0
    assert feed.max() < 1200.0
    assert np.median(feed) > 300.0
    assert len(path.regions[0].arcs) == 4
    assert {e.kind for r in path.regions for e in r.events} == {
        EventKind.TOOL_CHANGE,
        EventKind.SPINDLE_ON,
        EventKind.SPINDLE_OFF,
        EventKind.COOLANT_ON,
        EventKind.COOLANT_OFF,
    }


def test_freecad_helix() -> None:
    path, _ = corpus("freecad_platteyz-pass-3-helix.nc")
    assert path.dialect == "gcode-3axis"
    (region,) = path.regions
    assert region.operation == "Helix"
    depth = region.position[:, 2] * 1e3
    assert depth.min() == pytest.approx(-3.0)
    assert len(region.arcs) == 2 * 16
    np.testing.assert_allclose([arc.radius for arc in region.arcs], 1.1e-3, rtol=1e-9)
    np.testing.assert_allclose([arc.angle for arc in region.arcs], math.pi, rtol=1e-9)


@pytest.mark.parametrize(
    ("name", "line", "match"),
    [
        ("linuxcnc_5axisgui.ngc", 18, "W word"),
        ("linuxcnc_circular_pocket.ngc", 16, "nothing is cut"),
        ("linuxcnc_simple_example.ngc", 9, "not in this file"),
        ("upm_spiral_xzc.nc", 14, "coordinates before"),
    ],
)
def test_programs_of_the_corpus_that_can_not_be_posted_say_why(name: str, line: int, match: str) -> None:
    file = CORPUS / name
    if not file.exists():
        pytest.skip("../shared is not here: the G-code corpus")
    assert looks_like_gcode(file.read_bytes())
    refused(file.read_bytes(), line=line, match=match)


@pytest.mark.parametrize(("before", "move"), [("G0", Move.RAPID), ("G1", Move.CUT)])
def test_behind_g80_the_motion_beside_the_cycles_goes_on(before: str, move: Move) -> None:
    """Fanuc B-63944EN: cycles and G80 are of modal group 09, G0 to G3 of group 01."""
    path = read(f"G21 G0 X0 Y0 Z20\nF100\n{before} X1\nG81 X2 Z-5 R1\nG80\nX5\nM30\n".encode())
    region = path.regions[-1]
    assert region.move[-1] == move and region.position[-1] == pytest.approx([0.005, 0.0, 0.02])


def test_m13_is_a_clamp_where_m10_to_m12_are_and_a_spindle_elsewhere() -> None:
    text = "G21 G90\nT1 M6\nS900 M3\nM11\nM13\nG0 X0 Y0 Z20\nM12\nG1 X1 Z1 F100\nG0 Z20\nM30\n"
    kinds = [e.kind for e in read(text.encode()).regions[0].events]
    assert kinds.count(EventKind.SPINDLE_ON) == 1 and EventKind.COOLANT_ON not in kinds
    kinds = [e.kind for e in read(text.replace("M11\n", "").replace("M12\n", "").encode()).regions[0].events]
    assert EventKind.COOLANT_ON in kinds


def test_words_that_controls_write_in_their_own_way() -> None:
    path = read(b"G71 G90\nT01 T02 M6\nG187 P2 E0.05\nG0 X0 Y0 Z20\nG1 X1 Z1 F100\nG0 Z20\nM6\nG0 X2\nG1 X3 Z1\nM30\n")
    assert [r.tool for r in path.regions if r.move.max() == Move.CUT] == [1, 2] and path.units == "mm"


def test_what_rounding_leaves_of_a_bite_is_none_of_its_own() -> None:
    assert [h for h, cut in heights("G99 G83 X10 Z-11.003 R1 Q4") if cut] == [-3, -7, -11.003]
