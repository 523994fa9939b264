"""What nobody has explained, on other runs: held to a Gaussian process in plain numpy, and to a field of other code."""

from __future__ import annotations

import json
import sys
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm
from test_predict import CELL, ROOT

from camrob.cell.read_cell import read_cell
from camrob.gap.diagnose import diagnose
from camrob.gap.effects.registry import library
from camrob.gap.fitted_units import FittedUnits, fitted_units
from camrob.gap.observation.scene import make_scene
from camrob.gap.unexplained import SIZE_DOUBT, UnexplainedField
from camrob.jobs.solving.machine_errors import unexplained_rest
from camrob.kinematics.frames import base_T_tool, world_T_base
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo, MeasuredFrame
from camrob.prediction.deflection import granted_compliance
from camrob.prediction.true_path import UNEXPLAINED, true_path
from camrob.redundancy.accuracy.part_error import error_numbers, expected_squares
from camrob.redundancy.accuracy.posture_errors import PostureErrors
from camrob.summaries.fitted.diagnosis_fitted import UnexplainedSaid

sys.path.insert(0, str(ROOT / "tests" / "bench"))

from gap import generator
from gap.field import draw_field

AXES = ("A1", "A2", "A3", "E1")
SAME, VARIANCE = 3e-9, 2e-8
HOME = np.deg2rad([0.0, -80.0, 100.0, 0.0, 60.0, 0.0])


def prior(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The kernel by its definition: single axes and pairs of them, each a mean of three squared exponentials."""
    one = np.stack(
        [
            np.mean(
                [np.exp(-((a[:, None, k] - b[None, :, k]) ** 2) / (2 * length**2)) for length in (0.28, 0.56, 1.12)],
                axis=0,
            )
            for k in range(a.shape[1])
        ]
    )
    pairs = [one[i] * one[j] for i in range(len(one)) for j in range(i)]
    return SAME + VARIANCE * (one.sum(axis=0) + np.sum(pairs, axis=0)) / (len(one) + len(pairs))


def run(values: np.ndarray, frame: MeasuredFrame = MeasuredFrame.BASE) -> MeasurementLog:
    """The log of a run through axis values (N, 8), rad and m, that stands where it should."""
    edge = values * np.array([1 / generator.DEG] * 6 + [1e3, 1 / generator.DEG])
    columns = {"t": np.arange(len(edge)) * 0.012, "line": np.ones(len(edge))}
    for k, name in enumerate(generator.AXES):
        columns[name] = columns[f"c{name}"] = edge[:, k]
    return MeasurementLog(columns, LogInfo(measured_frame=frame))


def postures(seed: int, count: int, wide: float) -> np.ndarray:
    """Axis values (N, 8) about HOME."""
    rng = np.random.default_rng(seed)
    return np.r_[HOME, 0.5, 0.0] + wide * rng.uniform(-1, 1, (count, 8)) * np.r_[np.ones(3), np.zeros(3), 0.5, 0.0]


def measured(seed: int = 1, count: int = 25) -> tuple[UnexplainedField, np.ndarray, np.ndarray]:
    """The posterior of such a field at some postures, and what it was made of: the postures and noisy shifts (M, 3)."""
    rng = np.random.default_rng(seed)
    at = (postures(seed, count, 0.4) / np.r_[np.ones(6), 0.5, 1.0])[:, (0, 1, 2, 6)]
    K = prior(at, at)
    told = np.linalg.cholesky(K) @ rng.normal(size=(count, 3)) + 3e-5 * rng.normal(size=(count, 3))
    gain, none = K @ np.linalg.inv(K + 9e-10 * np.eye(count)), np.zeros((count, 3, 0))
    field = UnexplainedField(AXES, (), True, at, gain @ told, K - gain @ K, none, VARIANCE, SAME, 1e-5, none)
    return field, at, told


def test_it_is_the_posterior_of_a_gaussian_process_wherever_it_is_asked() -> None:
    field, at, told = measured()
    asked = np.concatenate([postures(2, 30, 0.3), postures(3, 30, 1.5)])
    scene = make_scene(run(asked), read_cell(CELL))
    got = field.at(scene)
    x = (asked / np.r_[np.ones(6), 0.5, 1.0])[:, (0, 1, 2, 6)]
    gain = prior(x, at) @ np.linalg.inv(prior(at, at) + 9e-10 * np.eye(len(at)))
    np.testing.assert_allclose(got.mean, gain @ told, atol=2e-8)
    variance = np.diag(prior(x, x) - gain @ prior(at, x))
    np.testing.assert_allclose(np.hypot(got.known, got.beyond), np.sqrt(variance), rtol=1e-3)
    assert np.median(got.beyond[30:]) > 2 * np.median(got.beyond[:30]) and got.known.max() < 1.2e-4


def test_what_is_not_known_goes_together_along_a_run() -> None:
    field, at, _ = measured()
    asked = np.concatenate([postures(2, 60, 0.3), np.linspace(*postures(3, 2, 1.5), 60)])
    parts = field.together(make_scene(run(asked), read_cell(CELL)))
    x = (asked / np.r_[np.ones(6), 0.5, 1.0])[:, (0, 1, 2, 6)]
    gain = prior(x, at) @ np.linalg.inv(prior(at, at) + 9e-10 * np.eye(len(at)))
    whole = prior(x, x) - gain @ prior(at, x)
    left = whole - parts @ parts.T
    assert parts.shape[1] < 60 and np.abs(left).max() < 0.011 * (VARIANCE + SAME)
    assert np.linalg.eigvalsh(left).min() > -1e-5 * VARIANCE  # no more than there is
    assert np.diag(whole).max() > 0.3 * VARIANCE


def test_it_comes_back_from_the_file() -> None:
    field, _, _ = measured()
    again = UnexplainedField.of(UnexplainedSaid.from_json(json.loads(json.dumps(field.said().to_json()))))
    scene = make_scene(run(postures(2, 20, 0.6)), read_cell(CELL))
    np.testing.assert_allclose(again.at(scene).mean, field.at(scene).mean, rtol=1e-3, atol=1e-7)
    np.testing.assert_allclose(again.at(scene).beyond, field.at(scene).beyond, rtol=1e-2)


@pytest.mark.parametrize("in_base", [True, False])
def test_a_plan_pays_what_the_prediction_says(in_base: bool) -> None:
    """E e^2 of a tool that cuts nothing away but across one direction: the field's square there, and its variance, in the
    mean over the sizes that it may have; whichever frame it is seen from.
    """
    cell, field = read_cell(CELL), replace(measured()[0], in_base=in_base)
    asked = postures(4, 40, 0.8) + np.r_[np.zeros(7), 0.7]
    scene = make_scene(run(asked), cell)
    got = field.at(scene)
    found = FittedUnits((), (), (), np.zeros(0), np.zeros((0, 0)), field)
    q = cell.to_q(asked * np.array([1 / generator.DEG] * 6 + [1e3, 1 / generator.DEG])[None])
    free = [k for k in range(len(cell)) if not cell.arm_slice.start <= k < cell.arm_slice.stop]
    nothing = np.zeros(6)
    along = np.asarray(base_T_tool(cell, q))[:, :3, 2]
    if not in_base:
        along = np.einsum("nij,nj->ni", world_T_base(cell, q)[:, :3, :3], along)
    push = np.tile([0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], (len(q), 1))
    for corrected in (False, True):
        errors = PostureErrors(
            nothing,
            nothing,
            nothing,
            nothing,
            nothing,
            np.zeros((12, 0)),
            np.zeros(2),
            unexplained=unexplained_rest(cell, found, np.zeros((75, 0))),
            corrected=corrected,
        )
        numbers = error_numbers(cell, len(free) - cell.arm_slice.start, errors)
        square, _ = expected_squares(
            numbers, np.ascontiguousarray(q[:, free]), np.ascontiguousarray(q[:, cell.arm_slice]), push
        )
        beyond = np.mean(np.exp(2.0 * SIZE_DOUBT * norm.ppf((np.arange(10_000) + 0.5) / 10_000))) * got.beyond**2
        expected = got.known**2 + beyond + (0.0 if corrected else np.sum(got.mean * along, axis=1) ** 2)
        np.testing.assert_allclose(square, expected, rtol=2e-3, atol=1e-13)


def test_staying_costs_little_where_the_rest_makes_up_for_a_constant() -> None:
    """A compliance that is doubtful and a field fitted beside it: where they were measured together nothing of the doubt shows,
    far from there most of it. How the compliance moves the tool is another code's.
    """
    cell, doubt = read_cell(CELL), 5e-7
    field, _, _ = measured(count=12)
    at = np.tile(np.r_[HOME, 0.5, 0.0], (12, 1))
    at[:, (0, 1, 2, 6)] = field.postures * np.array([1.0, 1.0, 1.0, 0.5])
    far = postures(6, 12, 0.3) + np.r_[0.0, -0.9, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    q = {
        k: cell.to_q(v * np.array([1 / generator.DEG] * 6 + [1e3, 1 / generator.DEG])) for k, v in enumerate((at, far))
    }
    moved = []
    for axis in (at, far):
        bent = axis.copy()
        bent[:, 1] += doubt * generator.torques(axis)[:, 1]
        moved.append(generator.pose(bent)[:, :3, 3] - generator.pose(axis)[:, :3, 3])
    found = FittedUnits((), (), (), np.zeros(0), np.zeros((0, 0)), replace(field, in_base=False, cov=0.0 * field.cov))
    nothing, root = np.zeros(6), np.zeros((12, 1))
    root[1] = doubt
    free = [k for k in range(len(cell)) if not cell.arm_slice.start <= k < cell.arm_slice.stop]
    push = np.tile([0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], (12, 1))
    got = {}
    for beside in (np.zeros((36, 1)), moved[0].reshape(-1, 1)):
        unexplained = unexplained_rest(cell, found, beside)
        errors = PostureErrors(
            nothing, nothing, nothing, nothing, nothing, root, np.zeros(2), unexplained=unexplained, corrected=True
        )
        numbers = error_numbers(cell, len(free) - cell.arm_slice.start, errors)
        for k, values in q.items():
            square, _ = expected_squares(
                numbers, np.ascontiguousarray(values[:, free]), np.ascontiguousarray(values[:, cell.arm_slice]), push
            )
            got[not beside.any(), k] = square
    along = np.einsum("nij,nj->ni", world_T_base(cell, q[0])[:, :3, :3], np.asarray(base_T_tool(cell, q[0]))[:, :3, 2])
    alone = np.sum(moved[0] * along, axis=1) ** 2
    np.testing.assert_allclose(got[True, 0], alone, rtol=1e-2, atol=1e-13)
    assert np.all(got[False, 0] < 1e-3 * np.median(alone))
    assert np.median(got[False, 1]) > np.median(alone)


def test_only_axes_that_gravity_told_of_are_known() -> None:
    """A1 of an arm that stands upright carries nothing; an A6 of 0.1 +- 2 was not seen either: both as beside A2, A3 and A5."""
    cell = read_cell(CELL)
    cov = np.diag([1e-7, 1e-7, 5e-7, 5e-7, 2e-6]) ** 2
    found = FittedUnits((), (), (), np.zeros(5), cov)
    known = {"A2": (2e-6, 0), "A3": (3e-6, 1), "A4": (8e-6, 2), "A5": (1.2e-5, 3), "A6": (1e-7, 4)}
    mean = np.mean([2e-6, 3e-6, 2e-6, 3e-6])
    got = granted_compliance(cell, known, found)
    assert got.by_axis == pytest.approx({"A1": mean, "A6": 4 * mean}) and got.alike == 0.0
    # where none was seen all are as is ordinary, and may all be half or twice as much
    for nothing in ({}, {"A6": known["A6"]}):
        got = granted_compliance(cell, nothing, found)
        assert list(got.by_axis.values()) == pytest.approx([4e-6] * 3 + [1.6e-5] * 3, rel=0.1)
        assert 0.5 < got.alike < 1.0


@pytest.fixture(scope="module")
def machine() -> tuple[FittedUnits, object]:
    """What a diagnosis says of a cell of other code, on which A2 yields and a smooth field of 0.15 mm is; and the field."""
    rng = np.random.default_rng(5)
    t = np.arange(0.0, 24.0, 0.004)
    w = rng.uniform(0.3, 1.2, 8)
    shape = np.r_[0.35, 0.25, 0.25, 0.5, 0.3, 0.5, 0.3, 0.0]
    command = (
        np.r_[HOME, 0.5, 0.0] + shape * np.sin(t[:, None] * w + rng.uniform(0, 6, 8)) * np.minimum(t / 2, 1.0)[:, None]
    )
    world = generator.World(t, command)
    apply = draw_field(77, world, 1.5e-4)
    torque = np.stack([np.interp(t, t[::25], c) for c in generator.torques(command[::25]).T], 1)
    world.link[:, 1] += 2.5e-6 * torque[:, 1]
    apply(world)
    at = t[500::5]
    setpoint, encoder, world_T_tool = generator.show(world, at)
    edge = np.array([1 / generator.DEG] * 6 + [1e3, 1 / generator.DEG])
    columns = {"t": at, "line": np.ones(len(at))}
    columns |= {n: world_T_tool[:, k, 3] * 1e3 + rng.normal(0, 0.02, len(at)) for k, n in enumerate("xyz")}
    columns |= {n: encoder[:, k] * edge[k] for k, n in enumerate(generator.AXES)}
    columns |= {f"c{n}": setpoint[:, k] * edge[k] for k, n in enumerate(generator.AXES)}
    said = diagnose([MeasurementLog(columns, LogInfo(sigma_position=2e-5))], read_cell(CELL)).summary
    assert said.compensable.fitted is not None and said.compensable.fitted.unexplained is not None
    return fitted_units(said.compensable.fitted, library()), apply


def shown(apply: object, command: np.ndarray) -> np.ndarray:
    """(N, 3) m in `world`, where a machine of other code goes beyond its set-points at axis values (N, 8)."""
    t = 0.004 * np.arange(len(command))
    world, plain = generator.World(t, command), generator.World(t, command)
    world.link[:, 1] += 2.5e-6 * generator.torques(command)[:, 1]
    apply(world)  # type: ignore[operator]
    poses = [generator.show(w, t)[2][:, :3, 3] for w in (world, plain)]
    return np.asarray(poses[0] - poses[1])


@pytest.mark.slow
def test_near_what_was_measured_it_is_known_and_far_from_there_its_size_is(machine: tuple[FittedUnits, object]) -> None:
    found, apply = machine
    cell = read_cell(CELL)
    assert found.unexplained is not None
    near, far = (
        np.r_[HOME, 0.5, 0.0] + wide * np.sin(np.arange(400)[:, None] * np.linspace(0.01, 0.05, 8))
        for wide in (np.r_[0.25, 0.2, 0.2, 0.4, 0.2, 0.4, 0.2, 0.0], np.r_[1.2, 0.5, 0.5, 1.2, 0.6, 1.2, 0.4, 0.0])
    )
    left, band = [], []
    for command in (near, far):
        path = true_path(run(command), cell, None, found, rest=found.unexplained.rest)
        truth = shown(apply, command)
        moved = path.true[:, :3, 3] - path.ideal[:, :3, 3]  # the table stands at 0: `base` is turned as `world` is
        assert path.causes[-1].name == UNEXPLAINED
        variance = path.rest**2 + np.sum(path.spread[:, :3] ** 2, axis=2).mean(axis=1)
        left.append(float(np.sqrt(np.mean((moved - truth) ** 2))))
        band.append(float(np.sqrt(np.mean(variance))))
        without = true_path(run(command), cell, None, replace(found, unexplained=None), rest=1e-4)
        assert np.allclose(without.rest, 1e-4) and without.causes[-1].name != UNEXPLAINED
        if command is near:
            off = without.true[:, :3, 3] - without.ideal[:, :3, 3] - truth
            assert left[0] < 0.5 * np.sqrt(np.mean(off**2)), "what is known of the field is no better than nothing"
    assert band[1] > 2.0 * band[0]
    assert 0.4 < left[0] / band[0] < 2.5 and 0.4 < left[1] / band[1] < 2.5
