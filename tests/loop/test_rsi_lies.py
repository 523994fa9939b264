"""An instrument that lies about its time, its pose or its units: each lie is held, then stops the robot, and is named."""

from __future__ import annotations

import numpy as np
import pytest
from rsi_bench import LAW, POSE, Bench, Telling
from rsi_world import Plant, kuka_rotation, line

from camrob.errors import InputError
from camrob.loop.law import CorrectionLaw
from camrob.loop.rsi.link import LinkSettings
from camrob.loop.rsi.setpoints import SetpointHistory, turn_between
from camrob.loop.rsi.stamps import StampClock

USED, STALE, IMPLAUSIBLE = 0, 1, 3
HELD = LAW.stop_after_cycles
SOFT = CorrectionLaw(gain=0.02, limit_m=3e-3, limit_rad=1e-2, stop_after_cycles=5, step_m=2e-5, step_rad=1e-4)

IDLE = CorrectionLaw(1e-6, 3e-3, 1e-2, stop_after_cycles=5)  # corrects next to nothing


def moving(t: float):
    """12 mm/s along X, 6 along -Y, 2 degrees a second about Z."""
    return (500 + 12 * t, -6 * t, 300, 10 + 2 * t, 20, 30)


def exact() -> Plant:
    """A robot without errors of its own."""
    return Plant("absolute", off_mm=np.zeros(3), off_deg=(0.0, 0.0, 0.0))


# ---- the age, by the instrument's own stamps ----


@pytest.mark.parametrize("clock", ["own", "shared"])
def test_data_that_fall_behind_by_their_stamps_are_not_followed(clock) -> None:
    """Without a look at the stamps, data 200 ms behind at 12 mm/s drive the correction to its limit, every frame answered."""
    bench = Telling(SOFT, program=moving, plant=exact(), late=lambda k: 0.001 + min(0.001 * k, 0.2), clock=clock)
    sources = bench.turns(600)
    assert len(sources) < 20 and sources[-HELD:] == [STALE] * HELD
    assert np.abs(bench.session.state.total[:3]).max() < 1e-5
    code, text = bench.why
    assert code == "stale" and "stamps" in text


@pytest.mark.parametrize(("late_s", "used"), [(0.0065, True), (0.0075, False)])
def test_a_delay_that_grows_counts_from_the_least_one_seen(late_s, used) -> None:
    """Two cycles of 4 ms are allowed, one of them goes by until the answer: 1 + 6.5 ms late is 6.5 ms late."""
    bench = Telling(program=moving, plant=exact(), late=lambda k: 0.001 + (late_s if k >= 10 else 0.0))
    assert set(bench.turns(30)) == ({USED} if used else {USED, STALE})
    assert (bench.session.stopped is None) == used


@pytest.mark.parametrize(("clock", "used"), [("own", True), ("shared", False)])
def test_a_constant_delay_shows_on_a_shared_clock_alone(clock, used) -> None:
    """And the loop says so, for nobody can see it (test_rsi_settings)."""
    bench = Telling(program=moving, plant=exact(), late=lambda k: 0.2, clock=clock)
    assert set(bench.turns(40)) == ({USED} if used else {STALE})
    if not used:
        assert bench.why[0] == "stale" and "200 ms old" in bench.why[1]


@pytest.mark.parametrize(("late_s", "used"), [(0.0068, True), (0.0072, False)])
def test_on_a_shared_clock_the_age_is_absolute(late_s, used) -> None:
    bench = Telling(program=moving, plant=exact(), late=lambda k: late_s, clock="shared")
    assert set(bench.turns(30)) == ({USED} if used else {STALE})
    if used:  # and it is compared with the set-point of the measured instant
        assert np.abs(bench.turn().error[:3]).max() < 1e-6


def test_a_shared_clock_that_is_another_one_is_said() -> None:
    """37 s, atomic time for UTC: before this machine's, and behind it."""
    for offset, code, word in ((-37.0, "stale", "the clocks aren't the same one"), (37.0, "stale", "runs ahead")):
        bench = Telling(lie=lambda k, t, p, R, by=offset: line(t + by, p, R), clock="shared")
        assert bench.turns(30) == [STALE] * HELD and bench.why[0] == code and word in bench.why[1]


@pytest.mark.parametrize(("ahead_s", "used"), [(0.0039, True), (0.0041, False)])
def test_a_stamp_in_the_future_is_refused_from_a_cycle_on(ahead_s, used) -> None:
    bench = Telling(late=lambda k: -ahead_s, clock="shared")
    assert set(bench.turns(20)) == ({USED} if used else {STALE})


def test_a_clock_of_its_own_may_drift_as_clocks_do() -> None:
    """Half an hour, a sample a second: 90 ppm slow is let pass and reported, 200 ppm is too old after 80 s."""
    for ppm, oldest_s in ((90.0, 0.0), (200.0, 0.18)):
        clock = StampClock(shared=False, drift=1e-4, slack_s=0.008)
        ages = [clock.age_on_arrival(k * (1.0 - ppm * 1e-6), float(k), float(k)) for k in range(1800)]
        assert ages[-1] == pytest.approx(oldest_s, abs=2e-3)
        assert (max(ages[:81]) <= 0.0081) and (max(ages) > 0.008) == (ppm > 100)
        assert clock.forgiven_s == pytest.approx(1799 * min(ppm, 100.0) * 1e-6, rel=1e-6)


@pytest.mark.parametrize(("ppm", "good"), [(90.0, True), (200.0, False)])
def test_a_clock_that_gains_is_found_out_once_it_is_relied_on(ppm, good) -> None:
    clock = StampClock(shared=False, drift=1e-4, slack_s=0.008)
    refused = 0
    for k in range(200):
        try:
            assert clock.age_on_arrival(k * (1.0 + ppm * 1e-6), float(k), float(k)) == 0.0
        except InputError:
            refused += 1
        clock.hold_to(float(k))
    assert (refused == 0) == good and (good or refused == 200 - 81)


def test_before_it_is_relied_on_the_least_delay_is_learnt() -> None:
    """The first datagrams came late: no fault. The same fall in a running loop is one: all before was older than it seemed."""
    bench = Telling(late=lambda k: 0.2 if k < 3 else 0.001)
    for _ in range(3):
        bench.lie(bench.k, 0.0, *bench.plant.actual(POSE))
        bench.session.measure(line(bench.now - 0.2, *bench.plant.actual(POSE)), ("127.0.0.1", 50002), bench.now)
        bench.now += 0.004
    bench.k = 3
    bench.lie = lambda k, t, p, R: line(t - 1000.0, p, R)
    assert set(bench.turns(20)) == {USED}
    bench = Telling(late=lambda k: 0.2 if k < 3 else 0.001)
    sources = bench.turns(30)
    assert sources[:3] == [USED] * 3 and sources[-HELD:] == [STALE] * HELD
    assert bench.why[0] == "clock" and "ahead" in bench.why[1]


# ---- stamps that are none ----

STAMPS = {
    "stand still": (lambda k, t: 1050.0 if k >= 8 else t, "doesn't grow"),
    "run backwards": (lambda k, t: t if k < 8 else 2100.06 - t, "doesn't grow"),
    "are set back": (lambda k, t: t if k < 8 else t - 0.5, "doesn't grow"),
    "are set forward": (lambda k, t: t if k < 8 else t + 0.5, "ahead"),
    "are milliseconds": (lambda k, t: t * 1000.0, "ahead"),
    "run twice as fast": (lambda k, t: 2.0 * t, "ahead"),
    "count samples": (lambda k, t: float(k), "ahead"),
}


@pytest.mark.parametrize("what", STAMPS)
@pytest.mark.parametrize("clock", ["own", "shared"])
def test_stamps_that_are_none_hold_and_then_stop(what, clock) -> None:
    stamp, word = STAMPS[what]
    bench = Telling(lie=lambda k, t, p, R: line(stamp(k, t), p, R), clock=clock)
    sources = bench.turns(60)
    assert len(sources) < 30 and sources[-HELD:] == [STALE] * HELD
    code, text = bench.why
    if clock == "own":
        assert code == "clock" and word in text
    assert "\n" not in text and len(text) < 300


@pytest.mark.parametrize("ppm", [-50.0, 50.0])
def test_stamps_that_are_sound_are_left_in_peace(ppm) -> None:
    """Jitter of a cycle, a clock that runs as clocks do, datagrams lost and doubled: all used or at most held for a cycle."""
    rng = np.random.default_rng(2)
    jitter = rng.uniform(0.0, 0.003, 1000)

    def lie(k, t, p, R):
        sent = line(1000.0 + (t - 1000.0) * (1.0 + ppm * 1e-6), p, R)
        return None if k % 50 == 7 else [sent, sent] if k % 10 == 0 else sent

    bench = Telling(SOFT, lie=lie, late=lambda k: 0.001 + jitter[k])
    assert set(bench.turns(1000)) == {USED} and bench.k == 1000
    assert bench.session.counts.measurements_refused == {"a measurement's time doesn't grow": 100}


def test_one_glitch_of_a_stamp_does_no_harm() -> None:
    """A single line from the future isn't believed, and doesn't make all that come after it too old."""
    bench = Telling(lie=lambda k, t, p, R: [line(t + 5.0, p, R), line(t, p, R)] if k == 10 else line(t, p, R))
    assert set(bench.turns(40)) == {USED}
    assert sum(bench.session.counts.measurements_refused.values()) == 1


# ---- a pose that stands still under running stamps ----


def frozen_from(k0: int):
    kept = {}

    def lie(k, t, p, R):
        if k <= k0:
            kept["pose"] = (p.copy(), R.copy())
        return line(t, *kept["pose"])

    return lie


def test_a_frozen_pose_of_a_moving_robot_holds_and_stops() -> None:
    bench = Telling(SOFT, program=moving, plant=exact(), lie=frozen_from(10))
    sources = bench.turns(60)
    assert sources[-HELD:] == [STALE] * HELD and len(sources) < 25
    assert bench.why[0] == "frozen" and "stands still though the robot is moved" in bench.why[1]
    assert np.abs(bench.session.state.total[:3]).max() < 2e-5  # of 0.1 mm that it is off by then


def test_a_frozen_pose_is_found_out_by_the_correction_itself() -> None:
    """The program rests, and an error of 0.4 mm is corrected that never gets less: 0.05 mm of correction, no more."""
    bench = Telling(SOFT, lie=frozen_from(0))
    sources = bench.turns(60)
    assert sources[-HELD:] == [STALE] * HELD and bench.why[0] == "frozen"
    assert 5e-5 < np.abs(np.linalg.norm(bench.session.state.total[:3])) < 9e-5


@pytest.mark.parametrize(("speed_mm_s", "found"), [(0.19, False), (0.26, True)])
def test_a_pose_may_stand_still_for_as_long_as_the_robot_does(speed_mm_s, found) -> None:
    """0.05 mm are where it becomes a fault: 50 cycles of 4 ms bring 0.038 and 0.052 mm."""
    bench = Telling(
        program=lambda t: (500 + speed_mm_s * t, 0, 300, 10, 20, 30), plant=exact(), lie=frozen_from(0), law=IDLE
    )
    bench.turns(50)
    assert bool(bench.session.counts.measurements_refused) == found


def test_only_the_orientation_frozen_is_frozen() -> None:
    turning = lambda t: (500, 0, 300, 10 + 2 * t, 20, 30)  # noqa: E731
    first = kuka_rotation(10, 20, 30)
    rng = np.random.default_rng(0)
    bench = Telling(
        SOFT, program=turning, plant=exact(), lie=lambda k, t, p, R: line(t, p + rng.normal(scale=0.002, size=3), first)
    )
    assert bench.turns(60)[-HELD:] == [STALE] * HELD and bench.why[0] == "frozen"


@pytest.mark.parametrize(("noisy", "repeats", "found"), [(True, 2, False), (True, 3, True), (False, 60, False)])
def test_where_noise_is_known_no_three_poses_are_equal(noisy, repeats, found) -> None:
    rng = np.random.default_rng(1)
    noise = rng.normal(scale=0.01, size=(60, 3))
    bench = Telling(
        IDLE, plant=exact(), noisy=noisy, lie=lambda k, t, p, R: line(t, np.round(p + noise[k // repeats], 3), R)
    )
    bench.turns(60)
    refused = bench.session.counts.measurements_refused
    assert (refused == {"a measurement's place stands still to the last digit": 20}) == found and bool(refused) == found


def test_a_resting_robot_without_noise_may_rest() -> None:
    bench = Telling(SOFT, plant=exact())
    assert set(bench.turns(400)) == {USED} and bench.session.stopped is None


def test_a_pose_that_moves_again_is_followed_again() -> None:
    lies = frozen_from(20)
    bench = Telling(
        SOFT, program=moving, plant=exact(), lie=lambda k, t, p, R: lies(k, t, p, R) if k < 28 else line(t, p, R)
    )
    sources = bench.turns(80)
    assert STALE in sources and sources[-40:] == [USED] * 40


# ---- a pose that isn't the tool's ----


@pytest.mark.parametrize(("jump_mm", "used"), [(0.49, True), (0.51, False)])
def test_a_jump_that_the_robot_cannot_have_made_holds_and_stops(jump_mm, used) -> None:
    step = np.array([0.0, 0.0, jump_mm])
    bench = Telling(IDLE, plant=exact(), lie=lambda k, t, p, R: line(t, p + step * (k >= 10), R))
    sources = bench.turns(40)
    assert set(sources) == ({USED} if used else {USED, IMPLAUSIBLE})
    if not used:
        assert (
            len(sources) == 10 + HELD
            and bench.why[0] == "stale"
            and "jumped farther than the robot was moved" in bench.why[1]
        )


@pytest.mark.parametrize(("jump_deg", "used"), [(0.11, True), (0.12, False)])
def test_so_does_a_jump_of_the_orientation(jump_deg, used) -> None:
    bench = Telling(
        IDLE,
        plant=exact(),
        jump_rad=2e-3,
        lie=lambda k, t, p, R: line(t, p, R @ kuka_rotation(jump_deg * (k >= 10), 0, 0)),
    )
    assert set(bench.turns(40)) == ({USED} if used else {USED, IMPLAUSIBLE})


def test_one_spike_is_left_out_and_a_moving_robot_jumps_nowhere() -> None:
    spike = np.array([0.0, 0.0, 4.0])
    bench = Telling(SOFT, program=moving, lie=lambda k, t, p, R: line(t, p + spike * (k == 50), R))
    sources = bench.turns(200)
    assert sources.count(IMPLAUSIBLE) == 1 and sources.count(USED) == 199
    fast = Telling(SOFT, program=lambda t: (500 + 250 * t, 0, 300, 10, 20, 30), plant=exact())
    assert set(fast.turns(200)) == {USED}


def test_a_pose_and_its_other_quaternion_are_one() -> None:
    """q and -q turn alike: an instrument may change between them as it likes, and nothing comes of it."""

    def flipped(k, t, p, R):
        words = line(t, p, R).split()
        return b" ".join(words[:4] + ([str(-float(w)).encode() for w in words[4:]] if k % 2 else words[4:]))

    plain, other = Telling(SOFT, program=moving), Telling(SOFT, program=moving, lie=flipped)
    assert plain.turns(100) == other.turns(100) == [USED] * 100
    assert (plain.session.state.total == other.session.state.total).all() and plain.session.state.total.any()


def words(k, t, p, R) -> list[bytes]:
    return line(t, p, R).split()


def scaled(factor: float):
    return lambda k, t, p, R: line(t, np.asarray(p) * factor, R)


def put(at: int, value: bytes):
    def lie(k, t, p, R):
        sent = words(k, t, p, R)
        sent[at] = value
        return b" ".join(sent)

    return lie


POSES = {
    "metres": (scaled(1e-3), "metres"),
    "inches": (scaled(1 / 25.4), "inches"),
    "micrometres": (scaled(1e3), "micrometres"),
    "x is NaN": (put(1, b"nan"), "finite"),
    "z is infinite": (put(3, b"inf"), "finite"),
    "the quaternion is NaN": (put(5, b"NaN"), "finite"),
    "the quaternion is not unit": (put(4, b"0.5"), "length 1"),
    "the quaternion is zero": (
        lambda k, t, p, R: b" ".join([*words(k, t, p, R)[:4], b"0", b"0", b"0", b"0"]),
        "length 1",
    ),
    "the real part comes last": (
        lambda k, t, p, R: b" ".join(words(k, t, p, R)[i] for i in (0, 1, 2, 3, 5, 6, 7, 4)),
        "real part comes last",
    ),
    "the sense of turning is the other one": (lambda k, t, p, R: line(t, p, R.T), "sense of turning"),
    "the hand is the other one": (lambda k, t, p, R: line(t, p * [1, -1, 1], R), "too far"),
    "x and y change places": (lambda k, t, p, R: line(t, p[[1, 0, 2]], R), "too far"),
    "another target": (lambda k, t, p, R: line(t, p + 30.0, R), "wrong target"),
    "beyond everything": (scaled(1e5), "range"),
    "degrees are missing": (lambda k, t, p, R: b" ".join(words(k, t, p, R)[:4]), "eight"),
    "nothing": (lambda k, t, p, R: None, "no measurement has come"),
}


@pytest.mark.parametrize("what", POSES)
@pytest.mark.parametrize("from_cycle", [0, 12])
def test_a_lie_about_the_pose_holds_and_then_stops_with_a_reason(what, from_cycle) -> None:
    lie, word = POSES[what]
    bench = Telling(
        SOFT,
        program=lambda t: (500, -300, 800, 10, 20, 30),
        lie=lambda k, t, p, R: lie(k, t, p, R) if k >= from_cycle else line(t, p, R),
    )
    sources = bench.turns(60)
    assert len(sources) <= from_cycle + 2 + HELD and not set(sources[-HELD:]) & {USED}
    total = bench.session.state.total
    assert np.abs(total[:3]).max() <= 2e-5 * (from_cycle + 2) and np.abs(total[3:]).max() <= 1e-4 * (from_cycle + 2)
    code, text = bench.why
    assert code == "stale" and "\n" not in text and len(text) < 400
    if what != "nothing" or from_cycle == 0:
        assert word in text
    assert bench.turn() is None  # for good


@pytest.mark.parametrize("wrong_way", [True, False])
def test_a_frame_given_the_wrong_way_round_is_named(wrong_way) -> None:
    base_T_tracker = np.eye(4)
    base_T_tracker[:3, :3], base_T_tracker[:3, 3] = kuka_rotation(70, 5, -8), [2.0, -1.0, 0.5]
    R0, p0 = base_T_tracker[:3, :3], 1000.0 * base_T_tracker[:3, 3]
    given = np.linalg.inv(base_T_tracker) if wrong_way else base_T_tracker
    bench = Telling(SOFT, base_T_tracker=given, lie=lambda k, t, p, R: line(t, R0.T @ (p - p0), R0.T @ R))
    sources = bench.turns(30)
    assert (set(sources) == {USED}) != wrong_way
    if wrong_way:
        assert "the wrong way round, base in tracker" in bench.why[1]


# ---- the parts ----


def test_the_way_counts_there_and_back_and_the_correction_with_it() -> None:
    history = SetpointHistory()
    assert history.commanded(1.0) == (0.0, 0.0)
    for k, (x, a, c) in enumerate([(0.0, 0.0, 0.0), (0.003, 0.1, 0.0), (0.001, 0.1, 0.0005)]):
        history.add(0.004 * k, np.array([x, 0, 0, a, 0.2, 0.3]), np.array([0, c, 0, 0, 0, 0]))
    assert history.programmed == pytest.approx((0.005, 0.1))
    assert history.commanded(1.0) == pytest.approx((0.0055, 0.1))
    assert history.commanded(0.002) == pytest.approx((0.0015, 0.05))


def test_at_a_steep_pitch_the_way_is_the_turn_and_not_its_angles() -> None:
    """At B = 90 degrees A and C run away from each other without any motion."""
    history = SetpointHistory()
    for k, spin in enumerate((0.0, 1.0, -1.0)):
        history.add(0.004 * k, np.array([0, 0, 0, spin, np.pi / 2, spin]))
    assert history.programmed.angle < 1e-9
    assert turn_between(np.eye(3), kuka_rotation(1e-4, 0, 0)) == pytest.approx(np.radians(1e-4), rel=1e-6)
    assert turn_between(np.eye(3), kuka_rotation(180, 0, 0)) == pytest.approx(np.pi)


def test_settings_that_make_no_sense_are_refused() -> None:
    for wrong in (
        {"clock": "gps"},
        {"clock": "shared", "latency_s": 0.005},
        {"drift": -1e-6},
        {"drift": np.nan},
        {"jump_m": 0.0},
        {"jump_rad": np.nan},
        {"saturated_cycles": 0},
    ):
        with pytest.raises(InputError):
            LinkSettings(LAW, **wrong)
    assert Bench().session.settings.clock == "own"


@pytest.mark.parametrize(
    ("cycles", "latency_s", "kept"), [(255, 0.0, True), (256, 0.0, False), (206, 0.2, False), (205, 0.2, True)]
)
def test_a_measurement_may_be_as_old_as_the_set_points_that_are_kept(cycles, latency_s, kept) -> None:
    law = CorrectionLaw(0.1, 1e-3, 1e-2, stale_after_cycles=cycles)
    if kept:
        assert LinkSettings(law, latency_s=latency_s).law == law
    else:
        with pytest.raises(InputError, match="kept for 256"):
            LinkSettings(law, latency_s=latency_s)


def test_a_robot_that_still_catches_up_has_not_jumped() -> None:
    """80 ms behind at 40 mm/s, the program stops, and for 8 cycles nothing is seen: 1.3 mm that nobody commanded meanwhile."""
    law = CorrectionLaw(1e-6, 3e-3, 1e-2, stop_after_cycles=25)
    bench = Telling(
        law,
        program=lambda t: (500 + 40 * min(t, 0.4), 0, 300, 10, 20, 30),
        plant=exact(),
        lie=lambda k, t, p, R: None if 101 <= k < 109 else line(t, p, R),
    )
    bench.behind_s = 0.08
    sources = bench.turns(200)
    assert STALE in sources and IMPLAUSIBLE not in sources and sources[-80:] == [USED] * 80


def test_what_was_refused_before_the_last_good_one_is_not_blamed() -> None:
    bench = Telling(lie=lambda k, t, p, R: [b"noise", line(t, p, R)] if k < 20 else None)
    bench.turns(60)
    assert bench.why[0] == "stale" and bench.why[1].endswith("(20 came, 20 were refused)")
