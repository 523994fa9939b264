"""Machines that became another between logs or at a row of one, drawn by a generator that shares nothing with the diagnosis."""

from __future__ import annotations

import sys
from dataclasses import replace
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from gap.before_after import run
from gap.before_after.draw import case

from camrob.gap.diagnose import diagnose
from camrob.gap.effects.registry import library
from camrob.gap.states.change import Change
from camrob.gap.states.later_effect import base_name, can_change, since


def _said(c, **told):
    return _said_of(_logs(c, "state", told), c)


def _logs(c, key, told):
    logs = [run.log_of(x) for x in (*c["logs"], *c["withheld"])]
    for name, value in told.items():
        at = int(name.removeprefix("log"))
        logs[at] = replace(logs[at], info=replace(logs[at].info, **{key: value}))
    return logs


def _said_of(logs, c):
    return diagnose(logs[: len(c["logs"])], run.cell_of(c["arm"]), withheld=logs[len(c["logs"]) :]).summary


@pytest.fixture(scope="module")
def lost_zero():
    """A zero of A3 that was lost between two logs, 45 poses a log."""
    return case(3, "zero", nothing=False, within=False, plain=True)


def test_a_zero_lost_between_two_logs_is_new_and_nothing_else(lost_zero):
    said = _said(lost_zero)
    (found,) = said.claimed
    assert (found.effect, found.axes) == ("joint_offset", (lost_zero["label"]["axis"],))
    assert (found.since.after, found.since.log, found.since.lasting) == ("log0.csv", "log1.csv", True)
    assert said.changed.startswith("New between log0.csv and log1.csv: joint offset")
    assert said.together.shrink > 0.5
    assert said.compensable.fitted.units[0].effect == "joint_offset"  # for `predict`, by its name in the library


def test_a_withheld_log_of_the_state_before_says_nothing_of_the_change(lost_zero):
    said = _said(lost_zero, log0="sound", log1="crashed", log2="sound")
    assert said.claimed[0].since is not None
    assert said.together.withheld == "blocks of the logs"


def test_logs_with_days_are_taken_in_their_order_and_one_withheld_is_of_the_machine_of_its_day(lost_zero):
    days = {"log0": datetime(2026, 11, 2), "log1": datetime(2026, 11, 9, 14), "log2": datetime(2026, 11, 9, 8)}
    before, after, kept = _logs(lost_zero, "recorded", days)
    said = _said_of([after, before, kept], lost_zero)
    assert said.changed.startswith("New between log0.csv and log1.csv: joint offset")
    assert said.together.withheld == "blocks of the logs"


def test_a_zero_lost_within_a_log_is_said_with_its_row():
    c = case(8, "zero", nothing=False, within=True, plain=True)
    assert c["label"]["axis"] != "A6"  # which is a target that slipped
    (found,) = _said(c).claimed
    assert (found.effect, found.axes) == ("joint_offset", (c["label"]["axis"],))
    assert abs(found.since.row - 1 - c["label"]["row"]) <= 1


def test_the_same_machine_twice_has_not_changed():
    said = _said(case(7, "zero", nothing=True, within=False, plain=True))
    assert not any(e.since for e in said.claimed)
    assert said.changed == ""


def test_what_came_is_at_work_in_the_later_rows_alone(lost_zero):
    from camrob.gap.pose_sets import fitted_scenes

    logs = [run.log_of(x) for x in lost_zero["logs"]]
    scenes = fitted_scenes(logs, [run.cell_of(lost_zero["arm"])] * 2)
    change = Change("log1.csv", frozenset(), frozenset({"log0.csv"}), at=float(scenes[1].t[9] + 0.5), row=11)
    zero = next(e for e in library() if e.name == "joint_offset")
    came = since(zero, change, {}, 1)
    unit = came.units(scenes, {})[0]
    (whole,) = zero.columns(scenes[1], zero.units(scenes, {})[0], {})
    before, after = (came.columns(s, unit, {})[0].tcp for s in scenes)
    assert before is None
    assert not after[:10].any() and np.array_equal(after[10:], whole.tcp[10:])
    assert base_name(came.name) == "joint_offset"
    assert not can_change(next(e for e in library() if e.name == "thermal_drift"))
