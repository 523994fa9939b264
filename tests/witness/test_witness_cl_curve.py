"""The witness's reading of NX's NURBS, held to SciPy's B-splines and to curves that are known otherwise."""

from __future__ import annotations

import numpy as np
import pytest
from cl_stories import NX, ways
from scipy.interpolate import BSpline
from witness_stories import feed, file, judged, lin, program, ptp, rapid

from camrob.witness.happenings import Kind, Story, Way

HEAD = NX + "SPINDL/RPM,3000,CLW\nFEDRAT/MMPM,600\nRAPID\nGOTO/0,0,30,0,0,1\nGOTO/0,0,0\n"
CONTROL = np.array([[0, 0, 0], [5, 10, 0], [15, 12, -2], [20, 0, -1], [26, -3, 0], [30, 4, 1]], float)
INNER = [0.3, 0.55]
WHOLE = [0.0, 0.0, 0.0, 0.0, *INNER, 1.0, 1.0, 1.0, 1.0]


@pytest.fixture
def tell(tell):
    """Reads the text of an operation, which ends here."""
    return lambda text: tell(text + "END-OF-PATH\n")


def nurbs(control=CONTROL, knots=INNER, word: str = "NURBS/\n") -> str:
    lines = "".join(f"CNTRL/{x},{y},{z}\n" for x, y, z in np.asarray(control).tolist())
    return word + (f"KNOT/{','.join(map(str, knots))}\n" if len(knots) else "") + lines


def off(points: np.ndarray, curve: np.ndarray) -> float:
    """The farthest of points (N, 3) from a polyline (M, 3)."""
    a, way = curve[:-1], np.diff(curve, axis=0)
    f = np.clip(np.einsum("nmi,mi->nm", points[:, None] - a, way) / np.einsum("mi,mi->m", way, way), 0.0, 1.0)
    return float(np.linalg.norm(points[:, None] - a - f[..., None] * way, axis=2).min(axis=1).max())


def cut(story: Story) -> np.ndarray:
    """The points of the curve with its start, mm."""
    rows = np.flatnonzero(story.path.angle == 0.0)
    return story.path.tip[np.insert(rows, 0, rows[0] - 1)] * 1000.0


@pytest.mark.parametrize("knots", [INNER, [*INNER, 1.0], WHOLE], ids=["inner knots", "and the last one", "all knots"])
@pytest.mark.parametrize("again", [True, False], ids=["start said again", "start where the tool is"])
def test_a_curve_is_scipys(tell, knots, again):
    story = tell(HEAD + nurbs(CONTROL if again else CONTROL[1:], knots) + "RAPID\nGOTO/30,4,30\n")
    points = cut(story)
    wanted = BSpline(WHOLE, CONTROL, 3)(np.linspace(0.0, 1.0, 4001))
    assert story.complete and ways(story).rstrip("F").count("R") == 2 and ways(story).endswith("R")
    assert (
        off(points, wanted) < 1e-5 and off(wanted, points) < 6e-4
    )  # mm; chords of 4001 points, and of the story's own
    assert points[-1] == pytest.approx([30, 4, 1], abs=1e-12)
    assert (story.feed[story.way == Way.FEED] == 0.01).all() and set(story.path.axis[:, 2]) == {1.0}


def test_the_degree_is_what_the_counts_leave(tell):
    """Three points without knots are a parabola, two a line; five with one knot a cubic in two pieces."""
    story = tell(HEAD + nurbs([[0, 0, 0], [10, 20, 0], [20, 0, 0]], []))
    points = cut(story)
    np.testing.assert_allclose(points[:, 1], points[:, 0] * (20.0 - points[:, 0]) / 10.0, atol=1e-9)
    assert np.all(np.diff(points[:, 0]) > 0.0)
    line = cut(tell(HEAD + nurbs([[0, 0, 0], [8, 4, 2]], [])))
    np.testing.assert_allclose(line[:, 1:], line[:, :1] * [0.5, 0.25], atol=1e-12)
    two = cut(tell(HEAD + nurbs(CONTROL[:5], [0.4])))
    wanted = BSpline([0, 0, 0, 0, 0.4, 1, 1, 1, 1], CONTROL[:5], 3)(np.linspace(0, 1, 4001))
    assert off(two, wanted) < 1e-5


def test_a_curve_in_another_frame_and_in_inches(tell):
    """MSYS turns it by 90 degrees about Z and shifts it; its points are in inches."""
    text = HEAD.replace("MSYS/0,0,0,1,0,0,0,1,0", "UNITS/INCHES\nMSYS/1,2,3,0,1,0,-1,0,0") + nurbs()
    story = tell(text)
    wanted = BSpline(WHOLE, CONTROL, 3)(np.linspace(0.0, 1.0, 4001)) @ np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    assert off(cut(story), (wanted + np.array([1, 2, 3])) * 25.4) < 2e-4


@pytest.mark.parametrize(
    "text",
    [
        nurbs(knots=[0.5, 0.4]),
        nurbs(knots=[0.0, 0.4]),
        nurbs(knots=[0.1] * 5),
        nurbs(knots=[*WHOLE[:-1], 1.1]),
        nurbs(knots=[0.1, *WHOLE[1:]]),
        nurbs(CONTROL[:0]),
        nurbs() + "CNTRL/1,2\n",
        nurbs() + "CNTRL/1,2,3,W,1\n",
        "RAPID\n" + nurbs(),
        "CIRCLE/0,5,0,0,0,1,5\n" + nurbs(),
        "CYCLE/DRILL,RAPTO,3.,FEDTO,-9.,MMPM,90.\n" + nurbs(),
        "CNTRL/1,2,3\n",
        "GOHOME\n" + nurbs(),
    ],
)
def test_what_is_no_curve_is_a_gap(tell, text):
    story = tell(HEAD + text + "GOTO/40,0,0\nGOTO/41,0,0\n")
    assert len(story.gaps) == 1 and not (story.path.angle == 0.0).any() and not story.joined[story.gaps[0].before]


# -- a program beside it


def _story(tell) -> Story:
    text = nurbs([[0, 0, 0], [10, 20, 0], [20, 0, 0]], [])  # y = x (20 - x) / 10
    return tell(HEAD + text + "RAPID\nGOTO/20,0,30\nSPINDL/OFF\n")


ON, OFF = (Kind.SPINDLE_ON, 3000.0, "CLW"), (Kind.SPINDLE_OFF, 0.0, "")


def _program(xs, lift=(), swap=()):
    """Chords of the parabola; lift: {index: (dx, dy, dz)}; swap: two that change places."""
    points = [[x, x * (20.0 - x) / 10.0, 0.0] for x in xs]
    for k, shift in dict(lift).items():
        points[k] = [a + b for a, b in zip(points[k], shift, strict=True)]
    for a, b in swap:
        points[a], points[b] = points[b], points[a]
    cuts = [lin(*point) for point in points]
    return program(ptp(), ON, ptp(0, 0, 30), lin(0, 0, 0), *cuts, lin(20, 0, 30, at=6000.0), OFF, ptp())


EVEN = np.linspace(0.0, 20.0, 41)[1:]  # chords of half a millimetre: 6.25 micrometres off at most


def test_chords_of_a_curve_pass(tell):
    found = judged(_story(tell), _program(EVEN), chord=1e-5)
    assert found.objections == [] and found.unjudged == []
    uneven = np.sort(np.concatenate([EVEN, EVEN[3:9] + 0.1]))[:-1]
    assert judged(_story(tell), _program([*uneven, 20.0]), chord=1e-5).objections == []


@pytest.mark.parametrize(
    "fault",
    [
        {"lift": {7: (0, 0, 0.02)}},
        {"lift": {7: (0, 0.03, 0)}},
        {"lift": {39: (0, 0, 0.012)}},
        {"lift": {20: (0, 0.012, 0)}},
        {"swap": [(7, 8)]},
        {"lift": {7: (0.0, 0.0, -0.02), 8: (0.0, 0.0, -0.02)}},
    ],
)
def test_points_off_the_curve_or_out_of_order_do_not(tell, fault):
    assert "off-path" in {o.code for o in judged(_story(tell), _program(EVEN, **fault), chord=1e-5).objections}


def test_a_curve_cut_in_chords_too_long_does_not_pass(tell):
    """Two millimetres: 0.1 mm off, with a chord tolerance of 0.01; with one of 0.2, it does."""
    coarse = np.linspace(0.0, 20.0, 11)[1:]
    assert judged(_story(tell), _program(coarse), chord=1e-5).objections
    assert judged(_story(tell), _program(coarse), chord=2e-4).objections == []
    half = [*EVEN[:9], *EVEN[30:]]  # a part of it left out
    assert judged(_story(tell), _program(half), chord=2e-4).objections


def test_straight_motions_have_no_chord_tolerance():
    """The same way in small steps, of points instead of a curve: their corners are held to 0.01 mm whatever the tolerance."""
    steps = [feed(x, x * (20.0 - x) / 10.0, 0.0) for x in EVEN]
    points = file(ON, rapid(0, 0, 30), feed(0, 0, 0), *steps, rapid(20, 0, 30), OFF)
    assert judged(points, _program(EVEN), chord=2e-4).objections == []
    assert judged(points, _program(np.linspace(0.0, 20.0, 11)[1:]), chord=2e-4).objections


@pytest.mark.parametrize(
    ("chord", "decimated", "good"), [(5e-6, 1.2e-5, True), (5e-6, 8e-6, False), (2.4e-5, 0.0, False)]
)
def test_where_points_are_left_out_a_chord_goes_on_past_the_end(tell, chord, decimated, good):
    """From x = 19 past the parabola's end at 20 to 21 on its tangent: 0.0228 mm off the curve."""
    text = nurbs([[0, 0, 0], [10, 20, 0], [20, 0, 0]], [])
    story = tell(HEAD + text + "GOTO/21,-2,0\nRAPID\nGOTO/21,-2,30\nSPINDL/OFF\n")
    cuts = [lin(x, x * (20.0 - x) / 10.0, 0.0) for x in EVEN[:38]]
    run = program(ptp(), ON, ptp(0, 0, 30), lin(0, 0, 0), *cuts, lin(21, -2, 0), lin(21, -2, 30, at=6000.0), OFF, ptp())
    assert (judged(story, run, chord=chord, decimated=decimated).objections == []) == good
