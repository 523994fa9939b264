"""Sets of poses that say in LOG.toml whose instrument or reflector they had: several targets in one frame, and withheld logs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from calibration_sample import CELL, axis_values, drawn, log_of, measure

from camrob.calibration.calibrate import fit_cell
from camrob.calibration.measurements import Measurements, measurements_of
from camrob.calibration.parameters import ParameterSet
from camrob.calibration.sets import fit_frames, frames_of_all, prepare_sets
from camrob.calibration.stands import owner_of, placed_together, with_others_known
from camrob.measurement.log_info import LogInfo
from camrob.measurement.read_log import read_log
from camrob.measurement.write_log import write_log
from camrob.se3 import frame_from_xyzabc

TRUE = drawn(CELL)
STAND = frame_from_xyzabc([2.0, -3.0, 0.4, 2.5, 0.3, -1.0])
REFLECTORS = ([0.05, 0.1, -0.08, 1.0, 0.5, 2.0], [0.02, -0.1, 0.06, 0.4, -0.5, 1.0], [-0.07, 0.02, 0.12, 0.0, 0.9, 0.1])


def target(k: int, count: int, *, seed: int = 0, **facts) -> Measurements:
    """Places of the k-th reflector, seen from the one stand."""
    right = frame_from_xyzabc(REFLECTORS[k])
    data = measure(
        CELL, TRUE, axis_values(CELL, count, seed=40 + k + seed), seed=50 + k + seed, left=STAND, right=right
    )
    data = replace(data.without_orientation(), frame_known=False, target_known=False, name=f"target{k}.csv")
    return replace(data, **facts)


def test_targets_in_one_frame_have_one_base_and_reflectors_of_their_own() -> None:
    sets = [target(0, 20), target(1, 20, same_frame_as="target0.csv"), target(2, 20, same_frame_as="target1.csv")]
    assert [owner_of(sets, k, "base") for k in range(3)] == [0, 0, 0]
    assert [owner_of(sets, k, "tool") for k in range(3)] == [0, 1, 2]
    lefts = [left for left, _ in placed_together(CELL, sets)]
    assert np.array_equal(lefts[0], lefts[1]) and np.array_equal(lefts[0], lefts[2])
    prepared = prepare_sets(CELL, sets, ("A2.zero", "base.x", "tool.x"))
    assert prepared[0].names == ("base.x", "tool.x", "tool.x@2", "tool.x@3", "A2.zero")
    columns = [[part.names[c] for c in part.model.columns] for part in prepared]
    assert columns == [["A2.zero", "base.x", f"tool.x{n}"] for n in ("", "@2", "@3")]


def test_who_names_nobody_or_itself_or_goes_round_stands_alone() -> None:
    lone = [target(0, 9, same_frame_as="elsewhere.csv"), target(1, 9, same_frame_as="target1.csv")]
    assert [owner_of(lone, k, "base") for k in range(2)] == [0, 1]
    ring = [target(0, 9, same_frame_as="target1.csv"), target(1, 9, same_frame_as="target0.csv")]
    assert [owner_of(ring, k, "base") for k in range(2)] == [1, 0]
    known = [replace(target(0, 9), frame_known=True, in_base=True), target(1, 9, same_frame_as="target0.csv")]
    assert [(d.frame_known, d.in_base) for d in with_others_known(known)] == [(True, True), (True, True)]


def nearby(k: int, count: int, **facts) -> Measurements:
    """The k-th reflector where it is seen: in a part of the work space of its own."""
    middle = axis_values(CELL, 3, seed=99)[k]
    around = middle + 0.2 * (axis_values(CELL, count, seed=40 + k) - middle)
    right = frame_from_xyzabc(REFLECTORS[k])
    data = measure(CELL, TRUE, around, seed=50 + k, left=STAND, right=right).without_orientation()
    return replace(data, frame_known=False, target_known=False, name=f"target{k}.csv", **facts)


def test_one_frame_for_several_targets_predicts_better_than_one_each() -> None:
    """Where each target is seen in its own part of the work space, a base for each takes what the robot's parameters should."""
    others = [target(k, 24, seed=7, same_frame_as="target0.csv", same_target_as=f"target{k}.csv") for k in range(3)]
    others = [replace(data, name=f"again{k}.csv") for k, data in enumerate(others)]
    together = [nearby(0, 20), *(nearby(k, 20, same_frame_as="target0.csv") for k in (1, 2))]
    told = fit_cell(CELL, together, withheld=others)
    assert [(p.log, len(p.rows), p.refitted) for p in told.evidence.poses if p.withheld] == [
        (f"again{k}.csv", 24, False) for k in range(3)
    ]
    apart = [replace(data, same_frame_as="", same_target_as="") for data in (*together, *others)]
    untold = fit_cell(CELL, apart[:3], withheld=apart[3:])
    assert all(p.refitted for p in untold.evidence.poses if p.withheld)
    errors = [study.calibration.errors["calibrated/withheld"].mean for study in (told, untold)]
    assert errors[0] < 0.65 * errors[1]


def test_a_withheld_log_of_four_poses_is_judged_where_frame_and_target_are_a_fitted_log_s() -> None:
    few = replace(target(0, 4, seed=9), name="few.csv", same_frame_as="target0.csv", same_target_as="target0.csv")
    study = fit_cell(CELL, target(0, 90), withheld=few)
    (judged,) = [p for p in study.evidence.poses if p.withheld]
    assert (len(judged.rows), judged.refitted) == (4, False)
    assert float(judged.distance("calibrated").mean()) < 2e-4 < float(judged.distance("frames").mean())


def test_a_withheld_log_of_another_target_in_the_same_frame_refits_the_target_alone() -> None:
    other = target(1, 40, same_frame_as="target0.csv")
    study = fit_cell(CELL, target(0, 90), withheld=other)
    (judged,) = [p for p in study.evidence.poses if p.withheld]
    assert (len(judged.rows), judged.refitted) == (20, True)
    assert float(judged.distance("calibrated").mean()) < 2e-4


@pytest.mark.parametrize("said", ["target0.csv", ""])
def test_a_log_says_it_in_its_toml(said: str, tmp_path: Path) -> None:
    info = LogInfo(poses=True, same_frame_as=said, same_target_as=said)
    write_log(log_of(CELL, target(1, 9), info), tmp_path / "other.csv")
    data = measurements_of(read_log(tmp_path / "other.csv"), CELL)
    assert (data.same_frame_as, data.same_target_as) == (said, said)


@pytest.mark.slow
def test_base_and_tool_alone_have_one_frame_too_where_the_logs_say_so() -> None:
    """The second reflector's readings are 3 mm off every other time; what is shared is fitted once, and leaves no less."""
    first, second = target(0, 20), target(1, 20)
    shifted = np.array(second.frames)
    shifted[:, :3, 3] += np.array([0.003, 0.0, 0.0]) * np.where(np.arange(20) % 2, 1.0, 0.0)[:, None]
    second = replace(second, frames=shifted)
    alone = [fit_frames(CELL, part, ParameterSet.of(())) for part in (first, second)]
    each = [(model, fit.parameters.values_array) for model, fit in alone]
    assert frames_of_all(CELL, [first, second], each) is each
    told = [first, replace(second, same_frame_as="target0.csv", same_target_as="target0.csv")]
    one, other = (stage[0].arrays for stage in frames_of_all(CELL, told, each))
    assert np.array_equal(one.left, other.left) and np.array_equal(one.right, other.right)
    shared = replace(second, same_frame_as="target0.csv")
    errors = [fit_cell(CELL, [first, b], share=0.0).calibration.errors["frames/fitted"].mean for b in (second, shared)]
    assert errors[1] >= errors[0]
    assert fit_cell(CELL, [first, shared], share=0.0).calibration.errors["calibrated/fitted"].mean <= errors[1]
