"""A loop that is closed the wrong way round, or not at all, and a correction that stays at its limit: held, then stopped."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rsi_bench import POSE, Robot, Telling
from rsi_world import turn

from camrob.loop.law import CorrectionLaw
from camrob.loop.rsi.response import ResponseWatch
from camrob.loop.rsi.setpoints import Way

USED, FAULTY = 0, 4
LAW = CorrectionLaw(gain=0.01, limit_m=3e-3, limit_rad=8e-3, step_m=2e-5, step_rad=9e-5, stop_after_cycles=5)
WIDE = replace(LAW, limit_m=2e-2, limit_rad=0.1, step_m=1e-3, step_rad=1e-2)


def corners(t: float):
    """12 mm/s along X for 3 s, rest for 1 s, along Y, rest, turning by 3 degrees a second about Z, at once from rest to speed."""
    x, y, a = (12.0 * min(max(t - start, 0.0), 3.0) for start in (1.0, 5.0, 9.0))
    return (700 + x, y, 400, 10 + a / 4, 20, 30)


# ---- saturation that lasts ----


@pytest.mark.parametrize(("cycles", "lasts"), [(20, False), (21, True)])
def test_a_correction_at_its_limit_is_held_and_stops_after_so_many_cycles(cycles, lasts) -> None:
    law = CorrectionLaw(0.1, limit_m=1e-4, limit_rad=1e-2, stop_after_cycles=5)
    bench = Telling(law, saturated_cycles=20, jump_m=5e-3)
    while not np.abs(bench.session.state.total[:3]).max() >= 0.99 * law.limit_m:
        assert bench.turn().source == USED
    for _ in range(cycles - 1):
        assert bench.turn().source == USED
    bench.plant.off_mm = -bench.plant.off_mm  # from here on the error pushes the other way
    sources = bench.turns(20)
    assert sources == ([FAULTY] * 5 if lasts else [USED] * 20)
    if lasts:
        code, text = bench.why
        assert code == "saturated" and "more than 20 cycles" in text and "X at -0.100 mm" in text and "\n" not in text
        assert bench.session.counts.held_faulty == 5
        assert np.abs(bench.session.state.total[:3]).max() == pytest.approx(1e-4)
        assert bench.turn() is None


def test_noise_at_the_limit_does_not_hide_that_it_lasts() -> None:
    """The error is as large as the correction may be, so that noise takes the correction off its limit again and again."""
    plant = Robot("absolute", off_mm=np.array([0.0, 0.0, 0.5]), off_deg=(0.0, 0.0, 0.0), lag_s=0.0)
    bench = Telling(
        CorrectionLaw(0.01, limit_m=5e-4, limit_rad=1e-2, stop_after_cycles=5), plant=plant, saturated_cycles=50
    )
    bench.session.state = replace(bench.session.state, total=np.array([0, 0, -5e-4, 0, 0, 0]))
    bench.plant.correction = np.array([0, 0, -0.5, 0, 0, 0])
    below = 0
    for _ in range(50):
        bench.turn()
        below += abs(bench.session.state.total[2]) < 5e-4
    assert below > 5 and bench.turns(20)[-5:] == [FAULTY] * 5 and bench.why[0] == "saturated"


def test_an_angle_at_its_limit_is_named_in_degrees() -> None:
    bench = Telling(
        CorrectionLaw(0.1, limit_m=1e-2, limit_rad=np.radians(0.05), stop_after_cycles=5), saturated_cycles=10
    )
    bench.turns(100)
    assert (bench.why[0] == "saturated" and "at 0.050 degrees" in bench.why[1]) or "at -0.050 degrees" in bench.why[1]


# ---- an error that grows under correction ----


@pytest.mark.slow
@pytest.mark.parametrize("gain", [0.01, 0.03])
def test_a_sound_loop_is_left_in_peace(gain) -> None:
    """Noise, lag, delay, corners taken at once: every measurement of 14 s is used."""
    bench = Telling(replace(LAW, gain=gain), plant=Robot("absolute"), program=corners)
    bench.behind_s = 0.08
    assert set(bench.turns(3500)) == {USED} and bench.k == 3500
    assert np.linalg.norm(bench.turn().error[:3]) < 2e-4


WRONG = {
    "the sign": -np.eye(3),
    "the tool's axes, which look down": turn("x", 180),
    "the sign of X": np.diag([-1.0, 1.0, 1.0]),
    "axes turned by 120 degrees": turn("z", 120),
    "axes turned by 150 degrees": turn("z", 150),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_correction_in_a_wrong_frame_is_found_out(what) -> None:
    """Before the limit of 3 mm is reached, in X, Y or Z; the robot rests, or starts to move."""
    for program in (lambda t: POSE, lambda t: corners(t + 0.9)):
        bench = Telling(LAW, plant=Robot("absolute", frame=WRONG[what]), program=program)
        sources = bench.turns(500)
        assert sources[-5:] == [FAULTY] * 5 and set(sources[:-5]) == {USED} and len(sources) < 320
        code, text = bench.why
        assert code == "response" and "grew" in text and "RefCorrSys" in text and "\n" not in text
        assert np.linalg.norm(bench.session.state.total[:3]) < 2.4e-3


@pytest.mark.parametrize(("share", "found"), [(0.45, False), (0.6, True)])
def test_growth_is_by_more_than_half_of_what_was_pushed(share, found) -> None:
    plant = Robot("absolute", frame=-share * np.eye(3), lag_s=0.0, noise_mm=0.0, noise_deg=0.0)
    bench = Telling(replace(WIDE, gain=0.02), plant=plant, error_m=1.0, error_rad=1.0)
    bench.turns(125 + 5 + 1)  # five blocks of 25 cycles, and the cycles of holding
    assert (bench.session.stopped is not None) == found


@pytest.mark.parametrize(("share", "found"), [(0.03, True), (0.07, False)])
def test_an_error_that_does_not_shrink_is_found_out(share, found) -> None:
    """Over eight time constants a sound loop leaves nothing of an error. Exp(-16 x 0.03) leaves 62 % of it, 0.07 a third."""
    plant = Robot("absolute", frame=share * np.eye(3), lag_s=0.0, noise_mm=0.0, noise_deg=0.0)
    bench = Telling(replace(WIDE, gain=0.02), plant=plant)
    sources = bench.turns(900)
    assert (bench.session.stopped is not None) == found
    if found:
        assert len(sources) == 825 + 5 and bench.why[0] == "response" and "didn't shrink" in bench.why[1]


def test_a_set_point_that_holds_the_correction_already_is_found_out() -> None:
    """Without --corrected the error stays as it was however much is added: stopped, and the option is named."""
    bench = Telling(WIDE, plant=Robot("absolute"))
    for _ in range(900):
        p = np.array(POSE[:3]) + bench.plant.correction[:3]
        bench.program = lambda t, p=p: (*p, *POSE[3:])
        bench.plant.off_mm = np.array([0.3, -0.2, 0.4]) - bench.plant.correction[:3]
        if bench.turn() is None:
            break
    assert bench.session.stopped is not None and bench.session.stopped.code == "response"
    assert "--corrected" in bench.session.stopped.text


# ---- the watch by itself: what it allows for ----


def watched(speed_m_s, error_m, push_m, *, noise_m=0.0, cycles=125):
    """What the watch says of an error along X that grows by `error_m` while the total grows by `push_m`, at a speed along Y."""
    watch, rng = ResponseWatch(0.01, 0.004), np.random.default_rng(0)
    for k in range(cycles):
        x = k / cycles
        error, total, setpoint = np.zeros(6), np.zeros(6), np.zeros(6)
        error[0], total[0] = 1e-4 + error_m * x + noise_m * rng.standard_normal(), push_m * x
        setpoint[1] = speed_m_s(0.004 * k)
        if said := watch.add(0.004 * k, error, total, setpoint, Way(setpoint[1], 0.0)):
            return said
    return ""


def test_growth_that_the_motion_explains_is_none() -> None:
    rest, even, off = lambda t: 0.0, lambda t: 0.1 * t, lambda t: 0.02 * max(t - 0.25, 0.0)
    assert "grew" in watched(rest, 4e-4, 2e-4)
    assert watched(even, 4e-4, 2e-4) == ""  # 40 mm of way may bring 0.4 mm
    assert "grew" in watched(even, 1e-3, 2e-4)
    assert watched(off, 2e-3, 2e-4) == ""  # 20 mm/s from rest may bring 3 mm at 150 ms of lag
    assert "grew" in watched(rest, 4e-4, 2e-4, noise_m=2.5e-5)
    assert watched(rest, 4e-4, 2e-4, noise_m=3e-4) == ""  # nobody could say
    assert watched(rest, 4e-4, 4e-5) == ""  # nothing was pushed worth speaking of
    assert watched(rest, -1e-3, 2e-4) == ""
