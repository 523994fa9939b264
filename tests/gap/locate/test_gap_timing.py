"""Timing of a run along its program: the virtual controller's own run, a slower one, pauses, a part, logs that lack something."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from gap_cases import kr15
from test_gap_program import HEAD, HOME, SIGMA, measured, parsed, raster, start

from camrob.controller.replay import replay
from camrob.controller.simulate import simulate, timetable
from camrob.gap.diagnose import diagnose
from camrob.gap.locate.passing_times import timing_of
from camrob.gap.observation.program_track import track_of
from camrob.gap.observation.scene import make_scene
from camrob.measurement.log import MeasurementLog
from camrob.program.program_text import ProgramText

STEP = 0.012


@cache
def program() -> ProgramText:
    return raster(4.0)


@cache
def run() -> MeasurementLog:
    return measured(program())


def timing(log: MeasurementLog, what: ProgramText | None = None) -> dict[str, Any]:
    scene = make_scene(log, kr15())
    return timing_of(scene, track_of(scene, program() if what is None else what), "").to_json()


def rows(log: MeasurementLog, chosen: np.ndarray, t: np.ndarray) -> MeasurementLog:
    """Some rows, at other times."""
    return MeasurementLog({**{n: v[chosen] for n, v in log.columns.items()}, "t": t}, log.info, log.path)


def held(at: int, seconds: float) -> MeasurementLog:
    """The run with a rest after a row, measured all the while."""
    log = run()
    more = round(seconds / STEP)
    chosen = np.concatenate([np.arange(at), np.full(more, at), np.arange(at, len(log))])
    out = rows(simulate(program(), kr15()).log, chosen, STEP * np.arange(len(chosen)))
    rng = np.random.default_rng(1)
    noisy = {n: out.columns[n] + rng.normal(0, SIGMA, len(out)) for n in "xyz"}
    noisy |= {n: out.columns[n] + rng.normal(0, 1e-3, len(out)) for n in "abc"}
    return MeasurementLog({**out.columns, **noisy}, log.info, log.path)


def test_the_virtual_controller_s_own_run_takes_the_time_that_it_says() -> None:
    found = timing(run())
    duration = found["duration"]
    assert duration["predicted_s"] == pytest.approx(simulate(program(), kr15()).duration, abs=STEP)
    assert duration["logged_s"] == pytest.approx(duration["predicted_s"], abs=2 * STEP)
    assert duration["at_programmed_speed_s"] < duration["predicted_s"] - 0.3
    assert found["stops"] == []
    assert found["speed"]["programmed_mm_s"]["median"] == pytest.approx(200.0)
    assert found["speed"]["logged_mm_s"]["median"] == pytest.approx(
        found["speed"]["predicted_mm_s"]["median"], rel=0.02
    )
    assert found["lost"][0]["limit"]
    for one in found["lost"]:
        assert one["logged_s"] == pytest.approx(one["predicted_s"], abs=3 * STEP)


def test_the_timetable_is_the_simulation_s() -> None:
    table = timetable(program(), replay(program(), kr15()))
    simulated = simulate(program(), kr15())
    log = simulated.log
    assert table.leave[-1] == simulated.duration
    assert (np.diff(table.place) >= 0.0).all()
    assert table.place[-1] == len(table.row)
    # the row of the log at each time belongs to the motion that the timetable has then
    at = np.interp(log.t, table.arrive, table.place)
    inside = np.abs(at - np.round(at)) > 0.02
    motion = np.searchsorted(table.row, simulated.motion)
    assert (np.floor(at[inside]) == motion[inside]).all()
    position = log.position
    assert table.way[-1] == pytest.approx(np.linalg.norm(np.diff(position, axis=0), axis=1).sum(), rel=1e-3)


@pytest.mark.parametrize("at", [150, 230])
def test_a_pause_is_found_with_its_line_and_length(at: int) -> None:
    found = timing(held(at, 3.0))
    (stop,) = found["stops"]
    assert stop["what"] == "pause"
    assert stop["line"] == int(run().line[at])
    assert stop["seconds"] == pytest.approx(3.0, abs=0.1)
    assert stop["t_s"] == pytest.approx(at * STEP, abs=0.1)
    assert found["duration"]["paused_s"] == pytest.approx(3.0, abs=0.1)
    assert found["duration"]["difference_s"] == pytest.approx(3.0, abs=0.1)
    assert found["lost"][0]["from_line"] <= stop["line"] <= found["lost"][0]["to_line"]
    assert found["lost"][0]["paused_s"] == pytest.approx(3.0, abs=0.1)


def test_a_wait_that_the_program_asks_for_is_no_pause() -> None:
    x, y, z, a, b, c = start()
    corners = [(60.0 * ((k + 1) // 2 % 2), 15.0 * (k // 2)) for k in range(8)]
    lines = [f"LIN {{X {x + u},Y {y + v},Z {z - 20},A {a},B {b},C {c},E1 0,E2 0}}" for u, v in corners]
    lines.insert(5, "WAIT SEC 1.5")
    waiting = parsed(HEAD + "\n".join([HOME, *lines]) + "\nEND\n")
    found = timing(measured(waiting), waiting)
    (stop,) = [s for s in found["stops"] if s["seconds"] > 1.0]
    assert stop["what"] == "as programmed"
    assert stop["programmed_s"] == pytest.approx(1.5)
    assert found["duration"]["paused_s"] == 0
    assert found["duration"]["difference_s"] == pytest.approx(0.0, abs=2 * STEP)


def test_a_wait_before_the_first_motion_is_no_part_of_the_run() -> None:
    x, y, z, a, b, c = start()
    target = f"LIN {{X {x},Y {y + 80},Z {z},A {a},B {b},C {c},E1 0,E2 0}}"
    late = parsed(HEAD + "\n".join([HOME, "WAIT SEC 2", target]) + "\nEND\n")
    found = timing(measured(late), late)["duration"]
    assert found["logged_s"] == pytest.approx(found["predicted_s"], abs=0.1)
    assert found["predicted_s"] == pytest.approx(simulate(late, kr15()).duration - 2.0)


def test_a_program_that_moves_nothing_is_said_to() -> None:
    still = parsed(HEAD + HOME + "\nEND\n")
    scene = make_scene(run(), kr15())
    log = rows(run(), np.zeros(200, int), STEP * np.arange(200))
    found = timing_of(scene, track_of(make_scene(log, kr15()), still), "").to_json()
    assert found["duration"] is None
    assert found["reason"] == "the program moves nothing"


def test_a_run_at_a_lower_override_is_reported_by_its_speed() -> None:
    log = run()
    found = timing(rows(log, np.arange(len(log)), 2.0 * log.t))
    assert found["speed"]["steady_percent"] == pytest.approx(50.0, abs=1.5)
    assert not found["speed"]["matches"]
    assert found["duration"]["difference_percent"] == pytest.approx(100.0, abs=3.0)
    assert found["stops"] == []


def test_rest_before_and_behind_the_run_does_not_count_and_a_part_is_held_against_that_part() -> None:
    log = run()
    whole = timing(log)["duration"]
    chosen = np.concatenate([np.zeros(200, int), np.arange(len(log)), np.full(300, len(log) - 1)])
    still = timing(rows(log, chosen, STEP * np.arange(len(chosen))))
    assert still["duration"]["logged_s"] == pytest.approx(whole["logged_s"], abs=0.2)
    assert still["stops"] == []
    part = np.arange(100, 250)
    found = timing(rows(log, part, log.t[part]))["duration"]
    assert found["logged_s"] == pytest.approx(149 * STEP)
    assert found["predicted_s"] == pytest.approx(found["logged_s"], abs=2 * STEP)
    assert found["from_line"] == log.line[100]


@pytest.mark.slow
def test_what_a_log_lacks_is_said() -> None:
    log = run()
    blank = timing_of(make_scene(log, kr15()), None, "no program").to_json()
    assert blank["duration"] is None
    assert blank["reason"] == "no program"
    bare = MeasurementLog({n: v for n, v in log.columns.items() if not n.startswith("cA")}, log.info, log.path)
    timing = diagnose([bare], kr15(), programs=[program()]).summary.to_json()["where"]["timing"]
    assert "no set-points" in timing[0]["reason"]
    assert (
        diagnose([log], kr15(), programs=[program()]).summary.to_json()["where"]["timing"][0]["duration"]["logged_s"]
        > 1.0
    )


def test_samples_out_of_order_are_refused_not_guessed() -> None:
    log = run()
    rng = np.random.default_rng(0)
    shuffled = np.array(rng.permutation(len(log)))
    scene = make_scene(rows(log, shuffled, log.t), kr15())
    found = timing_of(scene, track_of(scene, program()), "").to_json()
    assert found["duration"] is None
    assert "in order" in found["reason"]
