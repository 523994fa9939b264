"""The witness's reading of tilted planes (G68.2, G53.1, G69), held to SciPy's rotations and to hand-made numbers."""

from __future__ import annotations

import numpy as np
import pytest
from cl_stories import mm, ways
from scipy.spatial.transform import Rotation

from camrob.witness.cl.standing import TURNED, UNNAMED
from camrob.witness.happenings import Story, Way

START = "G21 G90 G17 F600\nG0 X0 Y0 Z50\n"
TILT = "G68.2 X20 Y-5 Z30 I40 J25 K-70\nG53.1\n"
ORIGIN, TURN = np.array([20.0, -5.0, 30.0]), Rotation.from_euler("ZXZ", [40, 25, -70], degrees=True)


def inside(*points, turn: Rotation = TURN, origin=ORIGIN) -> np.ndarray:
    """Points of the plane in the part, mm."""
    return turn.apply(np.array(points, float)) + origin


def held(story: Story, first: int, *points, **plane) -> None:
    """The story's points from one on are these of the plane, along its normal."""
    wanted = inside(*points, **plane)
    np.testing.assert_allclose(story.path.tip[first : first + len(points)] * 1000.0, wanted, atol=1e-9)
    normal = plane.get("turn", TURN).apply([0.0, 0.0, 1.0])
    assert np.abs(story.path.axis[first : first + len(points)] - normal).max() < 1e-12
    assert len(story) == first + len(points)


def test_points_in_a_plane(tell):
    story = tell(START + TILT + "G0 X0 Y0 Z30\nG1 Z-2\nG91 X10 Y3\nG90 X1 Y2 Z3\n", name="a.nc")
    assert story.complete and ways(story) == "RRFFF" and story.joined.tolist() == [False, False, True, True, True]
    held(story, 1, [0, 0, 30], [0, 0, -2], [10, 3, -2], [1, 2, 3])


def test_an_angle_by_hand(tell):
    """A quarter turn about X: the plane's Y is the part's Z, its Z the part's -Y; a quarter about Z first: X along Y."""
    story = tell(START + "G68.2 J90\nG53.1\nG0 X1 Y2 Z3\n", name="a.nc")
    assert mm(story)[1] == [1, -3, 2] and story.path.axis[1] == pytest.approx([0, -1, 0])
    story = tell(START + "G68.2 X100 I90 J90\nG53.1\nG0 X1 Y2 Z3\n", name="a.nc")
    assert mm(story)[1] == [103, 1, 2] and story.path.axis[1] == pytest.approx([1, 0, 0])


@pytest.mark.parametrize("order", ["121", "131", "212", "232", "313", "323"])
def test_orders_of_the_turns(tell, order):
    story = tell(START + f"G68.2 P0 Q{order} X20 Y-5 Z30 I40 J25 K-70\nG53.6\nG0 X7 Y8 Z9\nG1 X0\n", name="a.nc")
    letters = "".join("XYZ"[int(digit) - 1] for digit in order)
    turn = Rotation.from_euler(letters, [40, 25, -70], degrees=True)  # capitals: about the turned axes
    assert story.complete
    held(story, 1, [7, 8, 9], [0, 8, 9], turn=turn)


def test_inches(tell):
    story = tell("G0 X0 Y0 Z5\nG20 G68.2 X1 Y2 Z3 I40 J25 K-70\nG53.1\nG0 X1 Y0 Z1\nG1 X0 F5\n", name="a.nc")
    held(story, 1, [25.4, 0, 25.4], [0, 0, 25.4], origin=np.array([25.4, 50.8, 76.2]))


@pytest.mark.parametrize("plane", ["G17", "G18", "G19"])
@pytest.mark.parametrize("code", ["G2", "G3"])
def test_arcs_are_those_of_the_part_turned(tell, plane, code):
    """What the same blocks give without a plane, turned and shifted: centre, normal, angle, end."""
    arcs = {"G17": "X10 Y0 I5 J0", "G18": "X10 Z0 I5 K0", "G19": "Y10 Z0 J5 K0"}
    body = f"G0 X0 Y0 Z0\n{plane} {code} {arcs[plane]}\n{code} X10 Y10 Z10 R20\n"
    flat, tilted = tell(START + body, name="a.nc"), tell(START + TILT + body, name="a.nc")
    assert flat.complete and tilted.complete
    for name in ("tip", "center"):
        wanted = inside(*(getattr(flat.path, name)[2:] * 1000.0))
        np.testing.assert_allclose(getattr(tilted.path, name)[2:] * 1000.0, wanted, atol=1e-9)
    np.testing.assert_allclose(tilted.path.normal[2:], TURN.apply(flat.path.normal[2:]), atol=1e-12)
    np.testing.assert_allclose(tilted.path.angle[2:], flat.path.angle[2:], atol=1e-9)


def test_inverse_time_takes_the_length_in_the_plane(tell):
    story = tell(START + TILT + "G0 X0 Y0 Z0\nG93 G1 X30 F2\n", name="a.nc")
    assert story.feed[2] == pytest.approx(0.001)


@pytest.mark.parametrize("cycle", ["G98 G81 X5 Y6 Z-5 R2", "G99 G81 X5 Y6 Z-5 R2", "G91 G99 G81 X5 Y6 Z-7 R-28"])
def test_cycles_go_along_the_normal(tell, cycle):
    end = 30 if "G98" in cycle else 2
    story = tell(START + TILT + f"G0 X0 Y0 Z30\n{cycle}\nG80\n", name="a.nc")
    assert story.complete and ways(story) == "RRRRHR"
    held(story, 1, [0, 0, 30], [5, 6, 30], [5, 6, 2], [5, 6, -5], [5, 6, end])


def test_a_cycle_does_not_outlive_its_plane(tell):
    story = tell(START + TILT + "G0 X0 Y0 Z30\nG99 G81 X5 Y6 Z-5 R2\nG69\nX9\n", name="a.nc")
    assert [g.first_line for g in story.gaps] == [8]


def test_the_tool_is_turned_before_anything_is_cut(tell):
    """Before G53.1 the tip is nowhere known, and behind it, until X, Y and Z are named."""
    story = tell(START + "G68.2 X20 J30\nG0 X1 Y1 Z1\nG53.1\nG0 X0 Y0\nZ9\n", name="a.nc")
    assert story.complete and len(story) == 2 and story.joined.tolist() == [False, False]
    for cut in ("G68.2 X20 J30\nG1 X1 Y1 Z1\n", TILT + "G0 X0 Y0\nG1 X5\n", TILT + "G0 X0 Y0 Z9\nG1 C5\n"):
        story = tell(START + cut, name="a.nc")
        assert len(story.gaps) == 1 and not (story.way == Way.FEED).any()


def test_g53_3_goes_to_its_place(tell):
    story = tell(START + TILT.replace("G53.1", "G53.3 X1 Y2 Z3") + "G1 Z0\n", name="a.nc")
    assert story.complete and ways(story) == "RRF"
    held(story, 1, [1, 2, 3], [1, 2, 0])


def test_rotary_words_turn_the_tool_too(tell):
    """The normal of I90 J20 is (sin 20, 0, cos 20): A20 C90 on a table that tilts about A and turns about C."""
    tilt = "G68.2 X20 Y0 Z30 I90 J20\n"
    story = tell(START + tilt + "G0 A20 C90\nG0 X0 Y0 Z9\nG1 X5\n", name="a.nc")
    turn = Rotation.from_euler("ZX", [90, 20], degrees=True)
    assert story.complete
    held(story, 1, [0, 0, 9], [5, 0, 9], turn=turn, origin=np.array([20.0, 0, 30]))
    off = tell(START + tilt + "G0 A20.1 C90\nG0 X0 Y0 Z9\nG1 X5\n", name="a.nc")
    assert len(off.gaps) == 1 and len(off) == 1
    turned = tell("G0 A20 C90\n" + tilt + "G0 X0 Y0 Z9\nG1 X5 F9\n", name="a.nc")  # named before the plane
    assert turned.complete and mm(turned)[0] == mm(story)[1]


def test_behind_g69_the_tool_is_turned_till_it_is_named(tell):
    plane = TILT + "G0 X0 Y0 Z30\nG1 Z-2\nG0 Z30\nG69\n"
    story = tell(START + plane + "G0 X1 Y2 Z60\nA0 C0\nX1 Y2 Z60\nG1 Z50\n", name="a.nc")
    assert story.complete and mm(story)[4:] == [[1, 2, 60], [1, 2, 50]] and not story.joined[4]
    assert story.path.axis[5].tolist() == [0, 0, 1]
    assert [g.first_line for g in tell(START + plane + "G0 X1 Y2 Z60\nG1 Z50\n", name="a.nc").gaps] == [10]
    by_b = tell(START + plane + "G0 B0 C0\nX1 Y2 Z60\nG1 Z50\n", name="a.nc")
    assert by_b.complete and len(by_b) == 6


def test_a_plane_that_does_not_lean_keeps_the_place(tell):
    """Turned about Z alone, the tool stands on it: no G53.1, and coordinates that are not named stay what they are."""
    story = tell(START + "G68.2 X10 Y20 Z30 K90\nG1 X5\nG69\nX1\n", name="a.nc")
    assert story.complete and story.joined.tolist() == [False, True, True]
    # (0, 0, 50) is (-20, 10, 20) of the plane; X5 there is (0, 25, 50) of the part
    assert mm(story) == [[0, 0, 50], [0, 25, 50], [1, 25, 50]]


@pytest.mark.parametrize("leave", ["G28 Z9", "G53 G0 Z0", "G30", "G91 G28 X0"])
def test_machine_positions_are_none_of_the_planes(tell, leave):
    """Which of the plane's coordinates a machine axis changes depends on the machine."""
    story = tell(START + TILT + f"G0 X0 Y0 Z30\n{leave}\nG90 G0 Z30\nG1 X5\n", name="a.nc")
    assert [g.first_line for g in story.gaps] == [8]
    if leave != "G30":  # named again, it goes on; the rotary axes have not moved
        story = tell(START + TILT + f"G0 X0 Y0 Z30\n{leave}\nG90 G0 X0 Y0 Z30\nG1 X5\n", name="a.nc")
        assert story.complete and mm(story)[-1] == inside([5, 0, 30])[0].round(6).tolist()


def test_a_second_plane_is_in_the_work_frame_too(tell):
    other = Rotation.from_euler("ZX", [10, 20], degrees=True)
    story = tell(START + TILT + "G0 X0 Y0 Z9\nG68.2 X1 I10 J20\nG53.1\nG0 X3 Y4 Z5\n", name="a.nc")
    assert story.complete
    np.testing.assert_allclose(story.path.tip[2] * 1000.0, other.apply([3, 4, 5]) + np.array([1, 0, 0]), atol=1e-9)


@pytest.mark.parametrize(
    "blocks",
    [
        "G68.2 P1 X1 I5",
        "G68.2 Q123 I5",
        "G68.2 I5 R3",
        "G68.2 X1 A5",
        "G52 X5\nG68.2 X1",
        "M128\nG68.2 X1",
        "G68.2 X1 J5\nG53.1 A5",
        "G68.2 J5\nG53.1 X5",
        "G68.2 X1 J5\nG53.1\nM128",
        "G68.2 X1\nG52 X1",
    ],
)
def test_what_no_plane_is_read_from(tell, blocks):
    story = tell(START + f"{blocks}\nG0 X3 Y3 Z3\nG1 X4\n", name="a.nc")
    assert not story.complete and not (story.way == Way.FEED).any()


def test_a_tool_turned_onto_no_plane_is_a_gap(tell):
    story = tell(START + "G53.1\nG0 X3 Y3 Z3\nG1 X4\n", name="a.nc")
    assert [g.first_line for g in story.gaps] == [3] and story.joined.tolist() == [False, False, True]


def test_switching_the_tool_centre_point_with_turned_axes_forgets_the_place(tell):
    """Without it X is the machine's: with it again, it has to be named."""
    head = "M128\nG0 X1 Y2 Z3 A20 C0\n"
    story = tell(head + "M129\nG0 X50\nM128\nG1 Y3 F60\n", name="a.nc")
    assert len(story.gaps) == 1 and len(story) == 1
    story = tell(head + "M129\nG0 X50\nM128\nG0 X1 Y2 Z3\nG1 Y3 F60\n", name="a.nc")
    assert story.complete and mm(story) == [[1, 2, 3], [1, 2, 3], [1, 3, 3]]


@pytest.mark.parametrize(
    ("head", "off"), [("M128", "G49"), ("G43.4 H1", "M129"), ("TRAORI", "G49"), ("N5 TRAORI(1)", "M5")]
)
def test_what_switches_the_tool_centre_point_on_switches_it_off(tell, head, off):
    story = tell(f"{head}\nG0 X1 Y2 Z3 A20 C0\n{off}\nG1 X4 F60\n", name="a.nc")
    assert story.complete and mm(story) == [[1, 2, 3], [4, 2, 3]]
    for other in ("TRAFOOF", "M129", "M429"):
        turned = tell(f"TRAORI\nG0 X1 Y2 Z3 A20 C0\n{other}\nG1 X1 Y2 Z3 F60\n", name="a.nc")
        assert [g.text for g in turned.gaps] == [TURNED]


def test_a_message_is_no_motion(tell):
    assert tell(START + 'N7 MSG ("ROUGH")\nMSG(FINISH)\nG1 X1\n', name="a.nc").complete


@pytest.mark.parametrize(
    ("blocks", "unnamed"),
    [
        ("G0 X0 Y0\nG1 Z0", False),
        ("G28 Z60\nG1 X5", True),
        ("G53 G0 Z0\nG1 X5", True),
        ("G53 G0 Z0\nG1 Z5", False),
        ("G38.2 Z1\nG1 X5", False),
        ("G55\nG1 X5", False),
        (TILT + "G28 Z60\nG1 X5", False),
        ("G28 A0\nG1 X5", False),
    ],
)
def test_a_cut_without_named_coordinates_is_told_from_one_whose_place_is_lost(tell, blocks, unnamed):
    """What no reader could place, from what only this one can't."""
    texts = [g.text for g in tell(START + blocks + "\n", name="a.nc").gaps]
    assert (UNNAMED in texts) == unnamed
    assert UNNAMED in [g.text for g in tell("G0 X0 Y0\nG1 X5 F60\nG0 X0 Y0 Z0\n", name="a.nc").gaps]
