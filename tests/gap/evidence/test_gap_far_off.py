"""What is predicted of postures far from all that were fitted, learnt from halves of the log that a fit leaves out."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from gap_cells import ur10
from stranger_arms import UR, Faults, Machine, columns_of, scattered, true_poses

from camrob.gap.effects.registry import library
from camrob.gap.evidence import leads, predicted
from camrob.gap.evidence.comparison import compare
from camrob.gap.evidence.far_off import distance_of, stays_far_off
from camrob.gap.evidence.model import Model
from camrob.gap.evidence.shrink import shrinkage, trial_of
from camrob.gap.observation.scene import make_scene
from camrob.gap.verdict.carried_over import carried_over
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo

# the UR10 of tests/data: longer than the stranger's own arm
ARM = replace(
    UR,
    rows=tuple(
        (a[0], b, d)
        for a, (b, d) in zip(
            UR.rows, ((0, 0.1273), (-0.612, 0), (-0.5723, 0), (0, 0.163941), (0, 0.1157), (0, 0.0922)), strict=True
        )
    ),
)
TRAVEL = np.array([0.3, 0.6, 1.2, 0.3, 0.3, 0.3])  # rad; A3 goes farthest
LENGTHS = np.random.default_rng(2).normal(0, 1, (6, 3)) * (2e-4, 3e-4, 3e-4)


def measured(machine: Machine, count: int, seed: int):
    """Poses of one arm whose lengths are off and whose joints give way, which the library lacks here: near by that looks like
    zeros.
    """
    axis = scattered(machine, count, seed)
    # drawn over both regions, so that the two logs are of one arm
    T = true_poses(
        ARM,
        np.concatenate([axis, scattered(ARM, 400, 50)]),
        Faults(lengths=LENGTHS, give={1: 8e-6, 2: 1e-5}, rest=5e-5),
        5,
    )
    info = LogInfo(sigma_position=1e-5, sigma_angle=3e-5, poses=True)
    columns = columns_of(machine, np.arange(float(count)), axis, T[:count], seed=seed)
    return make_scene(MeasurementLog(columns, info, Path(f"{seed}.csv")), ur10())


# where the log was made, and where nobody has been: the arm lower and farther out
NEAR = replace(ARM, home=ARM.home - 0.5 * TRAVEL, swing=0.5 * TRAVEL)
FAR = replace(ARM, home=ARM.home + 0.7 * TRAVEL, swing=0.3 * TRAVEL)


@pytest.fixture(scope="module")
def model() -> Model:
    return compare([measured(NEAR, 300, 1)], [e for e in library() if e.name in ("joint_offset", "geometry")])


def found(model: Model) -> frozenset[int]:
    return frozenset(i for i in model.best.members if model.units[i].effect in ("joint_offset", "geometry"))


def test_where_postures_were_fitted_nothing_is_added(model: Model) -> None:
    beside = trial_of(model, [measured(replace(NEAR, swing=0.45 * TRAVEL), 100, 2)])
    far = trial_of(model, [measured(FAR, 100, 3)])
    assert stays_far_off(model, trial_of(model, ()), found(model)) == 0.0
    assert 0.0 <= stays_far_off(model, beside, found(model)) < 0.5 * stays_far_off(model, far, found(model))


@pytest.mark.parametrize("known", [0.0, 1.0])
def test_what_is_predicted_counts_the_larger_of_the_two(
    model: Model, known: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the fit is sure of itself (0 m2), what the halves tell brings it nearer to what is reached; else nothing is added."""
    monkeypatch.setattr(predicted, "_variance", lambda *_: known)
    far = trial_of(model, [measured(FAR, 100, 3)])
    reached = shrinkage(model, far, model.best.members, found(model)).rms_after
    whole, plain = (predicted.expected(model, far, found(model), far=f)[1] for f in (True, False))
    more = stays_far_off(model, far, found(model)) if known == 0.0 else 0.0
    assert whole**2 - plain**2 == pytest.approx(more, abs=1e-12)
    assert whole == plain or plain < whole <= reached


def only(monkeypatch: pytest.MonkeyPatch, lengths: np.ndarray, *names: str) -> Model:
    """Compared with these effects alone, on an arm of some lengths' errors."""
    monkeypatch.setattr(sys.modules[__name__], "LENGTHS", lengths)
    return compare([measured(NEAR, 300, 1)], [e for e in library() if e.name in names])


def test_a_cause_carries_over_to_where_nobody_has_been(model: Model) -> None:
    """Lengths are off, and take all there that they should; beside what was fitted, any likeness would."""
    beside = trial_of(model, [measured(replace(NEAR, swing=0.45 * TRAVEL), 100, 2)])
    far = trial_of(model, [measured(FAR, 100, 3)])
    assert distance_of(model, beside) < 0.2 < 1.0 < distance_of(model, far)
    assert carried_over(model, far, ["geometry"]) == {"geometry"}
    assert carried_over(model, beside, ["geometry"]) == frozenset()
    assert carried_over(model, trial_of(model, ()), ["geometry"]) == frozenset()


def test_a_likeness_does_not_carry_over(monkeypatch: pytest.MonkeyPatch) -> None:
    """Joints give way, and what alone is known, free forms included, looks like it near by: a mass."""
    monkeypatch.setattr(leads, "uncovered_forms", lambda _: {})
    model = only(monkeypatch, np.zeros((6, 3)), "payload")
    assert "payload" in model.evidence.effects_of(model.best.members)
    assert carried_over(model, trial_of(model, [measured(FAR, 100, 3)]), ["payload"]) == frozenset()
