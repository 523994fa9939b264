"""Friction grown in torques and currents: by point masses and finite differences, with a friction of their own making."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from gap_cells import edge, ur10

from camrob.gap.diagnose import diagnose
from camrob.gap.locate.drive_friction import drive_friction
from camrob.gap.observation.scene import make_scene
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo
from camrob.report.diagnosis.head import head_lines
from camrob.summaries.diagnosis_summary import DiagnosisSummary

Array = np.ndarray
AXES = tuple(f"A{k}" for k in range(1, 7))
MIDDLE = np.deg2rad([20, -90, 60, -60, -90, 10.0])
RATED = np.array([90.0, 150.0, 70.0, 20.0, 16.0, 12.0])  # Nm
STEP = 0.012  # s


def masses_at(q: Array, load_kg: float) -> tuple[Array, Array]:
    """Where the masses are (N, M, 3), by the cell's transforms one after the other, and how heavy."""
    cell = ur10()
    loads = [(m.after, m.mass, m.center) for m in cell.masses] + [("A6", load_kg, np.array([0.0, 0.03, 0.1]))]
    frames, T = {}, np.tile(np.eye(4), (len(q), 1, 1))
    for k, joint in enumerate(j for j in cell.joints if j.name in AXES):
        turned = np.tile(np.eye(4), (len(q), 1, 1))
        c, s = np.cos(q[:, k]), np.sin(q[:, k])
        turned[:, 0, 0], turned[:, 0, 1], turned[:, 1, 0], turned[:, 1, 1] = c, -s, s, c
        T = T @ joint.before @ turned @ joint.after
        frames[joint.name] = T
    places = [frames[a][:, :3, :3] @ c + frames[a][:, :3, 3] for a, _, c in loads]
    return np.stack(places, axis=1), np.array([m for _, m, _ in loads])


def torques(q: Array, load_kg: float) -> Array:
    """(N, 6) Nm, of masses that are accelerated and lifted."""
    place, mass = masses_at(q, load_kg)
    pushed = np.gradient(np.gradient(place, STEP, axis=0), STEP, axis=0) + np.array([0.0, 0.0, 9.81])
    columns = []
    for k in range(6):
        aside = q.copy()
        aside[:, k] += 1e-5
        lever = (masses_at(aside, load_kg)[0] - place) / 1e-5
        columns.append(np.einsum("nmi,nmi,m->n", lever, pushed, mass))
    return np.stack(columns, axis=1)


def log(
    name: str, seed: int, *, grown: str = "", times: float = 1.0, warm: float = 1.0, kg: float = 1.0, kind: str = "T"
) -> MeasurementLog:
    """Half a minute of all axes, with sticking, Coulomb, a slope by speed that warmth lowers, waves of the teeth, and noise."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 36.0, STEP)
    waves = rng.uniform(0.05, 0.25, (6, 3, 1)), rng.uniform(0.0, 6.0, (6, 3, 1)), rng.uniform(0.1, 0.3, (6, 3, 1))
    q = MIDDLE + np.sum(waves[2] * np.sin(2.0 * np.pi * waves[0] * t + waves[1]), axis=1).T
    v, a = np.gradient(q, STEP, axis=0), np.gradient(np.gradient(q, STEP, axis=0), STEP, axis=0)
    factor = np.where(np.array(AXES) == grown, times, 1.0) * np.exp(rng.normal(0.0, 0.04, 6))
    stick = 0.06 * (1.0 + 0.2 * np.exp(-((v / 0.03) ** 2)) + 0.1 * np.sin(7.0 * q)) * np.tanh(v / 0.004)
    slope = 0.05 * warm * np.sign(v) * np.abs(v) ** 0.8
    y = torques(q, kg) + RATED * (factor * (stick + slope) + 0.01 * a + 0.01 * np.sin(30.0 * q))
    y += RATED * rng.normal(0.0, 0.02, y.shape)
    if kind == "I":
        y = y * np.array([0.02, -0.015, 0.03, 0.05, -0.06, 0.08])
    degrees = edge(ur10(), q)
    columns = {"t": t} | {f"c{n}": x for n, x in zip(AXES, degrees.T, strict=True)}
    columns |= {n: x + rng.normal(0.0, 0.002, len(t)) for n, x in zip(AXES, degrees.T, strict=True)}
    columns |= {f"{kind}{k + 1}": x for k, x in enumerate(y.T)}
    return MeasurementLog(columns, LogInfo(sigma_axis=np.deg2rad(0.002)), Path(f"{name}.csv"))


@pytest.mark.parametrize(("kind", "masses"), [("T", True), ("I", False)])
def test_friction_of_one_axis_that_doubled_is_grown_and_no_others_is(kind: str, masses: bool) -> None:
    """Beside another load, other warmth, other motions; whether the cell knows any masses or not."""
    cell = ur10() if masses else replace(ur10(), masses=())
    for seed, axis in enumerate(("A1", "A6")):
        old, new = (
            log("old", seed, kind=kind),
            log("new", seed + 50, grown=axis, times=2.0, warm=0.7, kg=4.0, kind=kind),
        )
        found = drive_friction([make_scene(one, cell) for one in (new, old)])
        assert list(found) == list(AXES)
        assert found[axis].grown > 0.8
        assert found[axis].times == pytest.approx(2.0, rel=0.2)
        assert (found[axis].log, found[axis].against) == ("new.csv", "old.csv")
        assert max(f.grown for a, f in found.items() if a != axis) < 0.2


def test_a_cold_robot_has_no_grown_friction() -> None:
    cold = [make_scene(log("cold", 3, warm=1.8), ur10()), make_scene(log("warm", 4, warm=0.8), ur10())]
    assert max(f.grown for f in drive_friction(cold).values()) < 0.2


def test_what_friction_takes_is_what_it_was_made_of() -> None:
    for axis, f in drive_friction([make_scene(log("one", 7), ur10())]).items():
        speed = np.deg2rad(f.speed)
        made = RATED[AXES.index(axis)] * (0.06 + 0.05 * speed**0.8)
        assert f.size == pytest.approx(made, rel=0.15)
        assert f.unit == "Nm"
        assert f.grown < 0.5  # one log hardly tells
        assert f.against == ""


@pytest.mark.slow(after=1)
def test_the_page_says_that_friction_has_grown_where_and_what_to_do_though_there_is_no_gap() -> None:
    said = diagnose([log("old", 1, kind="I"), log("new", 2, grown="A4", times=2.5, kind="I")], ur10()).summary
    assert said.status == "no gap"
    lines = dict(head_lines(said))
    assert "Friction of A4 takes 2." in lines["What"]
    assert "times the current in new.csv that it does in old.csv" in lines["What"]
    assert lines["Where"] == "Friction: motor, brake or gear of A4."
    assert lines["Do first"].startswith("For friction of A4: whether the brake drags")
    assert DiagnosisSummary.from_json(said.to_json()) == said
    alone = diagnose([log("new", 2, grown="A4", times=2.5, kind="I")], ur10()).summary
    assert "Friction" not in dict(head_lines(alone))["What"]
