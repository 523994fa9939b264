"""A controller takes a least time for a motion: hand calculations of what short motions cost, and who is told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from feed_paths import CELL, track_path

from camrob.jobs.solving.short_motions import short_motions
from camrob.timing.as_it_stands import program_as_it_stands
from camrob.timing.block_time import BLOCK_TIME
from camrob.timing.optimal import optimal_feed
from camrob.timing.timing import program_time

SLOW = replace(CELL, controller_section=replace(CELL.controller, block_ms=12.0))
FEED, STEP, COUNT, PUSH = 0.2, 0.0006, 1001, 1.5  # m/s, m: 3 ms a motion; the track's m/s2
LEFT = STEP / 0.012  # m/s that 12 ms leave of it


def straight():
    path, q = track_path(STEP * np.arange(COUNT), feed=FEED)
    return path, q, np.full(COUNT, FEED)


def test_short_motions_run_at_their_length_in_a_block() -> None:
    path, q, speed = straight()
    assert program_time(CELL, path, q, speed=speed).total == pytest.approx(0.6 / FEED + FEED / PUSH, rel=1e-9)
    timing = program_time(SLOW, path, q, speed=speed)
    assert timing.total == pytest.approx(0.6 / LEFT + LEFT / PUSH, rel=1e-9)
    assert {timing.causes[k] for k in timing.cause[100:900]} == {BLOCK_TIME}
    assert [loss.cause for loss in timing.losses if loss.lost > 1.0] == [BLOCK_TIME]
    assert sum(loss.lost for loss in timing.losses if loss.cause == BLOCK_TIME) == pytest.approx(
        0.6 / LEFT - 3.0, rel=0.02
    )


def test_a_motion_over_several_points_is_one_block() -> None:
    path, q, speed = straight()
    ends = np.arange(COUNT) % 4 == 0  # 12 ms, as told
    assert program_time(SLOW, path, q, speed=speed, motion_ends=ends).total == pytest.approx(
        program_time(CELL, path, q, speed=speed).total, rel=1e-9
    )
    ends = np.arange(COUNT) % 2 == 0
    assert program_time(SLOW, path, q, speed=speed, motion_ends=ends).total == pytest.approx(
        0.3 / LEFT + 2.0 * LEFT / PUSH, rel=1e-9
    )


def test_a_turn_on_the_spot_takes_a_block_too() -> None:
    path, q = track_path(np.zeros(41), feed=FEED)
    q[:, CELL.index("A6")] += 1e-5 * np.arange(41)
    assert program_time(SLOW, path, q, speed=np.full(41, FEED)).total >= 40 * 0.012


def test_planned_and_slowed_programs_keep_to_it() -> None:
    path, q, speed = straight()
    plan = optimal_feed(SLOW, path, q, rapid_speed=0.2)
    assert plan.planned.max() <= LEFT * (1.0 + 1e-9) and plan.speed[1:].max() <= LEFT
    assert max(plan.losses, key=lambda loss: loss.lost).cause == BLOCK_TIME
    timing = program_time(SLOW, path, q, speed=speed)
    stands = program_as_it_stands(SLOW, path, q, timing, speed=speed)
    assert stands.speed[:, CELL.index("E1")].max() <= LEFT * (1.0 + 1e-5)
    assert stands.total >= timing.total - 1e-9


def test_what_is_short_is_counted() -> None:
    path, q, speed = straight()
    every = np.ones(COUNT, bool)
    assert short_motions(CELL, path, q, speed, every) is None
    found = short_motions(SLOW, path, q, speed, every)
    assert (found.count, found.short, found.shortest) == (1000, 1000, pytest.approx(0.003))
    found = short_motions(SLOW, path, q, speed, np.arange(COUNT) % 5 == 0)
    assert (found.count, found.short) == (200, 0)
