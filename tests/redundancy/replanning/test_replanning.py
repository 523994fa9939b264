"""Plans that touch something are made anew there and nowhere else; and plans that get no time are valid, and say their gap."""

from __future__ import annotations

import json
from dataclasses import replace
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console
from test_planned import CELL, OBJECTIVE, ROOT, raster

from camrob import post
from camrob.checks.rooms import job_room
from camrob.errors import InputError, LimitError, VerificationError
from camrob.findings import Severity
from camrob.redundancy.clock import Clock
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planned import resolve_planned
from camrob.redundancy.planning import followed
from camrob.redundancy.planning.forbidding import FEATURES, forbidden, forbidden_price, marks
from camrob.redundancy.planning.objective import BLOCKED_PRICE, BLOCKED_REACH, posture_features
from camrob.redundancy.planning.waypoints import waypoints
from camrob.redundancy.published.virtual_joint import PathFollower, resolve_vjm
from camrob.redundancy.replanning import clearing, hurried
from camrob.redundancy.solution import ALL_TOUCH, Solution
from camrob.report.terminal.summaries import render_post

ARM = CELL.arm_slice
SAMPLE = ROOT / "toolpaths" / "engraving" / "engraving.cls"
FIRST, LAST = 84, 90  # points at which the obstacle stands, in the middle of the path
WIDE = 0.12  # rad about a posture's shoulder and elbow that the obstacle fills


@pytest.fixture(scope="module")
def free() -> tuple[ToolPathInBase, Solution]:
    """A path and its plan where nothing stands in the way."""
    path = raster(15)
    return path, resolve_planned(CELL, path, mode="flowing")


class Planted:
    """An obstacle that a solution touches at the points where its shoulder and elbow stand as another's do."""

    def __init__(self, other: Solution, always: bool = False) -> None:
        self.q, self.always, self.asked = np.asarray(other.q), always, 0

    def __call__(self, path: ToolPathInBase, solution: Solution) -> np.ndarray:
        self.asked += 1
        here = slice(FIRST, LAST)
        out = np.zeros(len(path), bool)
        apart = np.abs(np.asarray(solution.q)[here, ARM] - self.q[here, ARM])[:, 1:3].max(axis=1)
        out[here] = self.always | (apart < WIDE)
        return out


def test_a_planted_touch_is_gone_round_there_and_the_rest_stands(free: tuple[ToolPathInBase, Solution]) -> None:
    path, plain = free
    obstacle = Planted(plain)
    assert obstacle(path, plain).sum() == LAST - FIRST
    solution = resolve_planned(CELL, path, mode="flowing", obstacles=obstacle)
    assert not obstacle(path, solution).any()
    assert solution.method == "planned" and solution.plan is not None and solution.plan.mended >= 1
    assert solution.residual(CELL, path)[0].max() < 1e-9
    expected = [f for f in solution.findings if f.code == "plan-mended"]
    assert len(expected) == 1 and expected[0].line == 10 + FIRST - 1 and "the rest of it stands" in expected[0].text
    moved = np.abs(np.asarray(solution.q) - np.asarray(plain.q)).max(axis=1)
    place = waypoints(path, 0.1).place
    far = (place < place[FIRST] - 0.9) | (place > place[LAST] + 0.9)
    assert far.sum() > 40 and moved[far].max() < 0.05 * moved[FIRST:LAST].max()
    assert solution.plan.gap >= plain.plan.gap - 1e-3  # what is forbidden makes nothing better


def test_what_can_not_be_gone_round_is_handed_over_as_it_is(free: tuple[ToolPathInBase, Solution]) -> None:
    """A touch whatever the posture: a few plans, the other points of the curve, and no end of trying."""
    path, plain = free
    obstacle = Planted(plain, always=True)
    solution = resolve_planned(CELL, path, mode="still", obstacles=obstacle)
    assert solution.method == "planned" and obstacle(path, solution).any()
    assert obstacle.asked <= clearing._ROUNDS + 3


def test_where_every_posture_touches_nothing_is_made_anew_and_it_is_said(free: tuple[ToolPathInBase, Solution]) -> None:
    """A plate of 6 m just above the tips, which no arm gets through, and the same far beneath the floor."""
    path, plain = free
    height = float(np.asarray(path.base_T_tip)[:, 2, 3].max())
    plate = np.array([[[-3, -3, 0], [3, -3, 0], [3, 3, 0]], [[-3, -3, 0], [3, 3, 0], [-3, 3, 0]]], float)
    asked, said = [], []
    for z in (height + 0.15, -9.0):
        obstacle, room = Planted(plain, always=True), job_room(CELL, stock_mesh=plate + np.array([0.0, 0.0, z]))
        solution = resolve_planned(CELL, path, mode="still", obstacles=obstacle, room=room)
        asked.append(obstacle.asked)
        said.append([f.count for f in solution.findings if f.code == ALL_TOUCH])
    assert asked[0] == 1 < asked[1]
    assert not said[1] and len(said[0]) == 1 and said[0][0] > 50


def test_a_plan_that_can_not_be_followed_is_made_anew_there(
    free: tuple[ToolPathInBase, Solution], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The follower refuses the first plan at one point, as it would for a hundredth of a degree of A6: no plan is thrown away."""
    path, _plain = free
    calls = []

    class Refusing(PathFollower):
        def follow(self, state, reference, start, stop, **how):
            attempt = super().follow(state, reference, start, stop, **how)
            calls.append(np.array(reference))
            if len(calls) == 1:
                failure = followed_failure(self, state, FIRST)
                return replace(attempt, failure=failure)
            return attempt

        def explain(self, failure):
            return LimitError("A6 is 0.0554 degrees past its limit", line=40, axis="A6")

    def followed_failure(follower, state, point):
        from camrob.redundancy.published.virtual_joint import Failure

        return Failure(point, np.eye(4), 1, state)

    monkeypatch.setattr(followed, "PathFollower", Refusing)
    solution = resolve_planned(CELL, path, mode="flowing")
    assert solution.method == "planned" and solution.plan is not None and solution.plan.mended == 1
    feature = [posture_features(OBJECTIVE.wrist_zero, np.ascontiguousarray(c[FIRST, ARM])) for c in calls]
    assert len(calls) == 2 and np.linalg.norm(feature[0] - feature[1]) > 0.05
    assert not any(f.code == "plan-fell-back" for f in solution.findings)


def test_touches_that_look_alike_are_one_mark_for_as_long_as_they_last() -> None:
    q = np.tile(CELL.q_home[ARM], (5, 1))
    q[3:, 2] += 1.0
    found = marks(0.0, q, np.array([1.0, 1.05, 3.0, 3.0, 3.05]), 0.1)
    np.testing.assert_allclose(found[:, FEATURES:], [[0.9, 1.15], [2.9, 3.1], [2.9, 3.15]])


def test_a_mark_shuts_the_lattice_about_it_and_holds_where_it_was_found() -> None:
    q = np.tile(CELL.q_home[ARM], (4, 1))
    q[1, 1] += 0.4 * BLOCKED_REACH
    q[2, 1] += 0.75 * BLOCKED_REACH
    q[3, 1] += 1.01 * BLOCKED_REACH
    mark = marks(OBJECTIVE.wrist_zero, q[:1], np.array([2.0]), 0.1)
    objective = OBJECTIVE._replace(blocked=mark)
    place = np.array([1.85, 2.0, 2.15])
    np.testing.assert_array_equal(forbidden(objective, place), [[False], [True], [False]])
    price = forbidden_price(objective, np.array([0, 4, 8, 12]), np.tile(q, (3, 1)), place).reshape(3, 4)
    assert not price[[0, 2]].any()
    np.testing.assert_allclose(price[1], [np.inf, np.inf, BLOCKED_PRICE / 16.0, 0.0])


def test_no_time_gives_a_valid_plan_with_an_honest_gap(free: tuple[ToolPathInBase, Solution]) -> None:
    path, _plain = free
    hurried = resolve_planned(CELL, path, seconds=0.0)
    whole = resolve_planned(CELL, path)
    assert hurried.plan is not None and whole.plan is not None
    assert hurried.residual(CELL, path)[0].max() < 1e-9
    assert hurried.plan.seconds == 0.0 and hurried.plan.missed > 0 and len(hurried.plan.curve) == 1
    assert whole.plan.seconds is None and whole.plan.missed == 0
    assert len(whole.plan.curve) >= hurried.plan.missed
    for solution in (hurried, whole):  # the gap is what forward kinematics and the bound say, by length of what is cut
        length = np.diff(path.length, prepend=0.0) * path.cutting
        reached = np.average(np.asarray(solution.inv_kf), weights=length)
        bound = np.average(np.asarray(solution.plan.bound), weights=length)
        assert solution.plan.gap == pytest.approx(1.0 - reached / bound, abs=1e-12) and 0.0 <= solution.plan.gap < 0.2
    np.testing.assert_allclose(np.asarray(hurried.plan.bound), np.asarray(whole.plan.bound), rtol=5e-3)


def test_a_plan_that_is_not_fit_when_its_time_is_over_gives_way_to_the_published_method(
    free: tuple[ToolPathInBase, Solution],
) -> None:
    """It is not made anew; it says what stood against it, what to do, and how far the published postures are from its bound."""
    path, plain = free
    obstacle = Planted(plain)
    solution = resolve_planned(CELL, path, mode="flowing", obstacles=obstacle, seconds=0.0)
    assert obstacle.asked == 1 and solution.method == "vjm" and solution.plan is None
    np.testing.assert_array_equal(solution.q, resolve_vjm(CELL, path).q)
    said = {f.code: f for f in solution.findings}
    assert f"touched something at {LAST - FIRST} points" in said["plan-fell-back"].text
    assert "--seconds" in said["plan-fell-back"].text and said["plan-fell-back"].severity is Severity.WARNING
    length = np.diff(path.length, prepend=0.0) * path.cutting
    reached = np.average(np.asarray(solution.inv_kf), weights=length)
    bound = np.average(np.asarray(plain.plan.bound), weights=length)
    assert said["plan-fell-back"].value == pytest.approx(100.0 * (1.0 - reached / bound), abs=0.2)


def test_within_a_time_a_plan_is_made_fit_first_and_bettered_in_what_is_left(
    free: tuple[ToolPathInBase, Solution],
) -> None:
    path, _plain = free
    obstacle = Planted(resolve_planned(CELL, path, mode="still"))
    whole = resolve_planned(CELL, path, obstacles=obstacle)
    timed = resolve_planned(CELL, path, obstacles=obstacle, seconds=1e6)
    for solution in (whole, timed):
        assert solution.method == "planned" and not obstacle(path, solution).any() and solution.plan.mended >= 1
        assert solution.plan.missed == 0 and len(solution.plan.curve) > 5
        assert solution.residual(CELL, path)[0].max() < 1e-9
        assert solution.plan.chosen in [point.name for point in solution.plan.curve]
    assert timed.plan.gap < whole.plan.gap + 0.005


@pytest.mark.slow
def test_a_hurried_plan_that_is_worse_than_the_published_method_says_so(
    free: tuple[ToolPathInBase, Solution], monkeypatch: pytest.MonkeyPatch
) -> None:
    path, _plain = free
    hurried_plan = resolve_planned(CELL, path, seconds=0.0)
    mean = hurried_plan.plan.reached_mean
    for better in (False, True):
        other = replace(hurried_plan, inv_kf=np.full(len(path), mean + (0.01 if better else -0.01)))
        monkeypatch.setattr(hurried, "resolve_published", lambda *_cell_and_path, other=other: other)
        said = [f for f in resolve_planned(CELL, path, seconds=0.0).findings if f.code == "plan-hurried"]
        assert len(said) == better
        whole = resolve_planned(CELL, path, mode="still")
        assert whole.plan.missed == 0 and "plan-hurried" not in [f.code for f in whole.findings]
    assert f"{mean:.3f}" in said[0].text and f"{mean + 0.01:.3f}" in said[0].text and "--seconds" in said[0].text


def test_a_clock_without_an_end_is_never_up() -> None:
    assert not Clock().up and Clock().left is None
    assert Clock(0.0).up and Clock(0.0).left == 0.0
    assert not Clock(3600.0).up and 3590.0 < (Clock(3600.0).left or 0.0) <= 3600.0


@pytest.mark.parametrize(("method", "seconds"), [("vjm", 1.0), ("planned", -1.0), ("planned", float("nan"))])
def test_seconds_that_mean_nothing_are_refused(tmp_path: Path, method: str, seconds: float) -> None:
    with pytest.raises(InputError, match="--seconds"):
        post(SAMPLE, cell=CELL.folder, out=tmp_path / "out", method=method, seconds=seconds)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("seconds", "said"), [(0.0, True), (1e6, False), (None, False)])
def test_a_refusal_of_a_hurried_plan_says_that_its_time_was_over(tmp_path: Path, monkeypatch, seconds, said) -> None:
    """It sent the reader to move the part, where 10 s of planning would have found a program."""

    def unfit(*_: object) -> None:
        raise VerificationError(
            "A5 passes its limit; place the part elsewhere (camrob place) or post with --method planned"
        )

    monkeypatch.setattr("camrob.jobs.release.first_free._fit_within_limits", unfit)
    with pytest.raises(VerificationError) as refused:
        post(SAMPLE, cell=CELL.folder, out=tmp_path / "out", method="planned", seconds=seconds)
    what = str(refused.value)
    assert ("give --seconds more or leave it out, for the 0 s ended" in what) is said
    assert "place the part elsewhere" in what and "--method planned" not in what


def test_a_hurried_post_is_verified_and_says_its_gap_everywhere(tmp_path: Path) -> None:
    made = post(SAMPLE, cell=CELL.folder, out=tmp_path / "out", method="planned", seconds=0.0)
    plan = made.summary.plan
    assert made.summary.verified.points == 899 and made.summary.collisions.count == 0
    assert plan is not None and plan.seconds == 0.0 and plan.missed > 0 and 0.0 < plan.gap_percent < 10.0
    expected = f"{plan.gap_percent:.2f} % below its bound"
    console = Console(width=400, file=StringIO())
    console.print(render_post(made.summary))
    assert expected in console.file.getvalue() and f"{plan.missed} steps of that" in console.file.getvalue()
    assert expected in (made.out / "engraving.html").read_text()
    assert json.loads((made.out / "engraving.json").read_text())["plan"]["gap_percent"] == plan.gap_percent


def test_of_plans_that_all_touch_the_one_that_touches_least_is_handed_on(
    free: tuple[ToolPathInBase, Solution], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The refusal names what stands in the way of the nearest to a plan, not of the last that was tried."""
    path, _plain = free
    touches = dict[bytes, int]()

    def obstacle(there: ToolPathInBase, solution: Solution) -> np.ndarray:
        out = np.zeros(len(there), bool)
        count = touches.setdefault(np.asarray(solution.q).tobytes(), 9 - 4 * (len(touches) == 2) + len(touches))
        out[FIRST : FIRST + count] = True
        return out

    monkeypatch.setattr(clearing, "_ROUNDS", 0)
    handed_on = resolve_planned(CELL, path, obstacles=obstacle)
    assert len(touches) > 3 and touches[np.asarray(handed_on.q).tobytes()] == min(touches.values()) == 7
