"""Coverage: every CL point met in order, nothing else between, on lines and arcs, to the contract's tolerances."""

from __future__ import annotations

import numpy as np
import pytest

from camrob.controller.against import cover
from camrob.program.motion import Motion
from camrob.se3 import pose, rotation_exp

LIN, PTP, VIA, END = (int(k) for k in (Motion.LIN, Motion.PTP_POSE, Motion.CIRC_VIA, Motion.CIRC_END))


def frames(tips: np.ndarray, tilt: np.ndarray | float = 0.0) -> np.ndarray:
    """Poses (N, 4, 4), mm, the tool tilted about y by degrees."""
    angles = np.radians(np.broadcast_to(tilt, len(tips)))
    return pose(rotation_exp(np.stack([0 * angles, angles, 0 * angles], axis=1)), np.asarray(tips, float) / 1e3)


def line(count: int = 6) -> np.ndarray:
    return np.stack([np.arange(count) * 10.0, np.zeros(count), np.zeros(count)], axis=1)


def covered(cl: np.ndarray, program: np.ndarray, kind=None, region=None, **options):
    n = len(cl)
    region = np.zeros(n, np.int64) if region is None else np.asarray(region, np.int64)
    kind = np.full(len(program), LIN) if kind is None else np.asarray(kind)
    kind = np.append([PTP], kind[1:]).astype(np.int8)
    return cover(cl, np.arange(n, dtype=np.int64) + 100, region, program, kind, **options)


def test_point_for_point() -> None:
    found = covered(frames(line()), frames(line()))
    assert found.good and found.motion.tolist() == [0, 1, 2, 3, 4, 5]
    assert found.position_error.max() < 1e-12 and found.deviation == 0.0


def test_points_between_the_ends_count() -> None:
    found = covered(frames(line()), frames(line()[[0, 5]], 0.0))
    assert found.good and found.motion.tolist() == [0, 1, 1, 1, 1, 1]
    found = covered(frames(line(), np.linspace(0, 5, 6)), frames(line()[[0, 5]], np.array([0.0, 5.0])))
    assert found.good  # the axis goes along with the way


def test_a_path_back_along_itself_keeps_its_order() -> None:
    """The way back comes nearer to a point of the way out than that does: it counts on the way out, before what follows."""
    tips = np.array([[0.0, 0.0, 0.0], [9.0, 0.003, 0.0], [10.0, 0.0, 0.0], [8.5, 0.006, 0.0]])
    found = covered(frames(tips), frames(tips[[0, 2, 3]]))
    assert found.good and found.motion.tolist() == [0, 1, 1, 2]
    assert found.position_error[1] == pytest.approx(3e-6, abs=1e-9)
    assert not covered(frames(tips[[0, 1, 3, 2]]), frames(tips[[0, 2, 3]])).good


@pytest.mark.parametrize(("off_mm", "good"), [(0.0099, True), (0.0101, False)])
def test_a_hundredth_of_a_millimetre(off_mm: float, good: bool) -> None:
    tips = line()
    tips[3, 1] = off_mm
    found = covered(frames(line()), frames(tips))
    assert found.good is good
    if not good:
        finding = found.findings[0]
        assert (finding.code, finding.line, finding.point) == ("cl-point-missed", 103, 3)
        assert finding.value == pytest.approx(0.0101, abs=1e-6) and finding.unit == "mm"
        assert covered(frames(line()), frames(tips), chord_tolerance=1e-5).good


@pytest.mark.parametrize(("off_deg", "good"), [(0.0099, True), (0.0101, False)])
def test_a_hundredth_of_a_degree(off_deg: float, good: bool) -> None:
    tilt = np.zeros(6)
    tilt[3] = off_deg
    assert covered(frames(line()), frames(line(), tilt)).good is good


def test_the_roll_about_the_tool_does_not_count() -> None:
    program = frames(line())
    program[:, :3, :3] = program[:, :3, :3] @ rotation_exp(np.array([0.0, 0.0, 1.2]))
    assert covered(frames(line()), program).good


@pytest.mark.parametrize(
    "order", [[0, 1, 3, 2, 4, 5], [5, 4, 3, 2, 1, 0], [0, 1, 2, 3, 4]], ids=["swapped", "backwards", "cut short"]
)
def test_order_counts(order: list[int]) -> None:
    corner = line()
    corner[3:, 1] = [5.0, 20.0, 40.0]  # not on one straight line, where other orders pass the points too
    assert not covered(frames(corner), frames(corner[order])).good


def test_a_detour_between_two_points_is_seen() -> None:
    tips = np.insert(line(), 3, [25.0, 8.0, 0.0], axis=0)
    found = covered(frames(line()), frames(tips))
    assert not found.good and found.deviation == pytest.approx(0.008, abs=1e-6)
    assert [f.code for f in found.findings] == ["strays"]
    assert covered(frames(line()), frames(tips), region=[0, 0, 0, 1, 1, 1]).good  # between regions the way is free


def test_back_and_forth_is_seen() -> None:
    tips = line()[[0, 1, 2, 0, 3, 4, 5]]
    assert not covered(frames(line()), frames(tips)).good


def arc_points(count: int, end: float = np.pi) -> np.ndarray:
    a = np.linspace(0.0, end, count)
    return np.stack([20 * np.cos(a), 20 * np.sin(a), 0 * a], axis=1)


@pytest.mark.parametrize("end", [0.5, np.pi, 3.4, 5.0])
def test_points_on_an_arc(end: float) -> None:
    cl = arc_points(21, end)
    found = covered(frames(cl), frames(cl[[0, 10, 20]]), kind=[PTP, VIA, END])
    assert found.good and found.motion.tolist() == [0] + [2] * 20
    straight = covered(frames(cl), frames(cl[[0, 20]]), kind=[PTP, LIN])
    assert not straight.good
    other_way = cl[[0, 10, 20]].copy()
    other_way[1] = [20 * np.cos(end / 2 + np.pi), 20 * np.sin(end / 2 + np.pi), 0.0]
    assert not covered(frames(cl), frames(other_way), kind=[PTP, VIA, END]).good


def test_a_full_circle_in_two() -> None:
    cl = arc_points(41, 2 * np.pi)
    program = cl[[0, 10, 20, 30, 40]]
    assert covered(frames(cl), frames(program), kind=[PTP, VIA, END, VIA, END]).good
    assert not covered(frames(cl), frames(program[:3]), kind=[PTP, VIA, END]).good


def test_of_a_ptp_only_the_end_is_known() -> None:
    kind = [PTP, LIN, LIN, PTP, LIN, LIN]
    found = covered(frames(line()), frames(line()), kind=kind)
    assert found.good and found.joined.tolist() == [False, True, True, True, True, True]
    assert not covered(frames(line()), frames(line()[[0, 1, 5]]), kind=[PTP, LIN, PTP]).good


def test_a_turn_on_the_spot() -> None:
    tips = line()[[0, 1, 1, 2]]
    tilt = np.array([0.0, 0.0, 30.0, 30.0])
    assert covered(frames(tips, tilt), frames(tips, tilt)).good
    assert not covered(frames(tips, tilt), frames(line()[:3], np.array([0.0, 0.0, 30.0]))).good


def test_random_programs_cover_themselves_and_no_others() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        tips = np.cumsum(rng.normal(0, 3, (60, 3)), axis=0)
        tilt = np.cumsum(rng.normal(0, 1, 60))
        assert covered(frames(tips, tilt), frames(tips, tilt)).good
        k = rng.integers(1, 59)
        moved = tips.copy()
        moved[k] += rng.normal(0, 1, 3)
        assert not covered(frames(tips, tilt), frames(moved, tilt)).good
        assert not covered(frames(tips, tilt), frames(np.delete(tips, k, 0), np.delete(tilt, k))).good


def retracting(*between: tuple[float, float, float], kinds: tuple[int, ...] = (), tilt: float = 0.0):
    """A line of six points, the fourth of which is left by way of `between`, mm, and come back to."""
    cl = line()
    cl[5, 2] = 20.0  # the highest point of the part
    tips = np.concatenate([cl[:4], np.array(between, float).reshape(-1, 3), cl[3:]])
    tilts = np.zeros(len(tips))
    tilts[4] = tilt
    kind = np.full(len(tips), LIN)
    kind[4 : 4 + len(kinds)] = kinds
    return covered(frames(cl), frames(tips, tilts), kind)


UP, AWAY = (30.0, 0.0, 25.0), (400.0, 100.0, -300.0)


@pytest.mark.parametrize(
    ("between", "kinds", "tilt", "good"),
    [
        ((UP,), (), 0.0, True),
        ((UP, UP), (LIN, PTP), 0.0, True),
        (((30, 0, 5), UP, UP, (30, 0, 5)), (LIN, LIN, PTP, LIN), 0.0, True),
        ((UP, (80, 0, 25), UP), (LIN, LIN, LIN), 0.0, True),  # about in the clear
        (
            (UP, AWAY, UP),
            (LIN, PTP, PTP),
            0.0,
            True,
        ),  # by way of HOME, wherever that is: collisions are looked for elsewhere
        (((30, 0, 15),), (), 0.0, False),  # below the part's highest point
        (((30.5, 0, 25),), (), 0.0, False),  # not along the tool axis
        ((UP,), (), 3.0, False),  # the tool tilts in the cut
        ((UP, UP), (PTP, PTP), 0.0, False),  # nobody knows the way out of the cut
        ((UP, AWAY, UP), (LIN, LIN, LIN), 0.0, False),  # a line through the part
        ((UP, AWAY), (LIN, PTP), 0.0, False),  # nor the way back in
    ],
)
def test_within_a_region_only_a_retract_clear_of_the_part_is_no_stray(between, kinds, tilt, good) -> None:
    found = retracting(*between, kinds=kinds, tilt=tilt)
    assert found.good is good
    if good:
        assert found.motion.tolist()[:4] == [0, 1, 2, 3] and found.leaves[3] == 4 + len(between)
        assert found.deviation < 1e-12
    else:
        assert {f.code for f in found.findings} == {"strays"} and found.deviation > 4e-4
