"""Whole regimes withheld: sums without them are the sums of the rest, what fails there is said, laps are found."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from gap_cases import generator, kr15, motion, poses, simulated
from test_gap_effects import plant_play

from camrob.gap.diagnose import diagnose
from camrob.gap.effects.registry import library
from camrob.gap.evidence.comparison import compare
from camrob.gap.evidence.design import pool
from camrob.gap.evidence.discrepancy import smooth_basis
from camrob.gap.evidence.model import Model
from camrob.gap.evidence.regimes_withheld import _rest, regimes_of_logs, regimes_withheld
from camrob.gap.evidence.temperature import cooled
from camrob.gap.observation.laps import laps_of
from camrob.gap.observation.scene import make_scene
from camrob.measurement.log import MeasurementLog

SIGMA = 0.02


def reversing(world) -> None:
    """0.3 mm in z, which turns over where the track is far out."""
    far = world.command[:, 6] > np.quantile(world.command[:, 6], 2 / 3)
    world.after[:, 2] += np.where(far, -3e-4, 3e-4)


@cache
def model_of(kind: str) -> Model:
    apply = {"play": plant_play, "reversing": reversing}[kind]
    logs = [simulated(apply, sigma_mm=SIGMA), simulated(apply, sigma_mm=SIGMA, seed=7, rng_seed=1)]
    return compare([make_scene(log, kr15()) for log in logs], library((), ()))


def units_of(model: Model, name: str) -> frozenset[int]:
    return frozenset(i for i, u in enumerate(model.units) if u.effect == name)


@pytest.mark.slow
def test_the_sums_without_a_regime_are_those_of_the_rest() -> None:
    model = model_of("play")
    asked = [p.w_tcp[:, 0] > 0.0 for p in model.panels]
    basis = smooth_basis(model.scenes)
    regimes = list(regimes_of_logs(model.panels, asked))
    assert {"track", "speed", "place", "log"} <= {r.kind for r in regimes}
    for regime, design in zip(regimes, _rest(model, regimes), strict=True):
        left = [
            replace(
                p,
                w_tcp=np.where(r[:, None], 0.0, p.w_tcp),
                w_servo=None if p.w_servo is None else np.where(r[:, None], 0.0, p.w_servo),
            )
            for p, r in zip(model.panels, regime.rows, strict=True)
        ]
        direct = pool(left, model.units, basis).design()
        assert design.field is not None
        assert direct.field is not None
        for one, other in ((design.field.C, direct.field.C), (design.field.D, direct.field.D)):
            assert np.abs(one[0] - other.sum(axis=0)).max() < 1e-9 * np.abs(other.sum(axis=0)).max()
        scale = np.sqrt(np.maximum(np.diag(model.design.A.sum(axis=0)), 1e-30))
        off = (design.A[0] - direct.A.sum(axis=0)) / np.outer(scale, scale)
        assert np.abs(off).max() < 1e-9
        assert np.abs((design.b[0] - direct.b.sum(axis=0)) / scale).max() < 1e-6 * np.sqrt(model.design.yy.sum())
        assert design.yy[0] == pytest.approx(direct.yy.sum(), rel=1e-9)
        assert design.rows[0] == direct.rows.sum()


@pytest.mark.slow
def test_lowered_weights_of_turns_and_drives_are_no_second_pooling() -> None:
    model = model_of("play")
    basis, factors = smooth_basis(model.scenes), (0.3, 0.6)
    found = pool(model.panels, model.units, basis).design(*factors)
    direct = pool(cooled(model.panels, *factors), model.units, basis).design()
    assert found.field is not None
    assert direct.field is not None
    pairs = [(getattr(found, n), getattr(direct, n)) for n in ("A", "b", "yy", "rows")]
    for one, other in (*pairs, *((getattr(found.field, n), getattr(direct.field, n)) for n in ("C", "D", "d"))):
        assert np.abs(one - other).max() < 1e-12 * np.abs(other).max()


@pytest.mark.slow
def test_what_holds_everywhere_holds_in_regimes_that_took_no_part() -> None:
    found = diagnose([simulated(plant_play, sigma_mm=SIGMA)], kr15())
    regimes = found.summary.to_json()["together"]["regimes_withheld"]
    assert {"track", "speed"} <= {r["regime"] for r in regimes}
    for r in regimes:
        low, high = r["shrink_interval"]
        assert low <= r["shrink"] <= high
        assert r["shrink"] == pytest.approx(1.0 - r["rms_after_mm"] / r["rms_before_mm"])
        assert r["rms_after_mm"] < 1.15 * SIGMA * np.sqrt(3)
        assert not r["worse"]
        assert r["what"].split()[-1] in ("mm", "mm/s", "degrees")
        assert r["samples"] > 90


@pytest.mark.slow
def test_without_a_claim_nothing_is_withheld() -> None:
    assert diagnose([simulated(sigma_mm=SIGMA)], kr15()).summary.to_json()["together"]["regimes_withheld"] == []


@pytest.mark.slow
def test_a_set_that_predicts_the_wrong_way_in_a_regime_is_called_worse_there() -> None:
    model = model_of("reversing")
    members = units_of(model, "frame_base")
    # as if nothing else could be there: beside a discrepancy so wrong a set would be all but 0
    evidence = replace(model.evidence, sizes=None)
    model = replace(model, evidence=evidence, best=evidence.fit(members | model.evidence.always))
    found = {r.what: r for r in regimes_withheld(model, members)}
    far = next(r for what, r in found.items() if what.startswith("E1 above"))
    assert far.worse
    assert far.shrink < -0.3
    assert far.shrink_interval[1] < 0.0
    near = next(r for what, r in found.items() if what.startswith("E1 below"))
    assert not near.worse


@pytest.mark.slow
def test_what_the_rest_does_not_tell_is_doubt_and_not_called_worse() -> None:
    """E1 moves in the second log alone: without that log, its scale is anything within the prior."""

    def scaled(world) -> None:
        world.after[:, 1] += 2e-3 * world.command[:, 6]

    t, command = motion(5)
    still = command.copy()
    still[:, 6] = command[0, 6]
    logs = [
        simulated(scaled, sigma_mm=SIGMA, run=(t[::10], c[::10]), rng_seed=k) for k, c in enumerate((still, command))
    ]
    model = compare([make_scene(log, kr15()) for log in logs], library((), ()))
    members = units_of(model, "track")
    model = replace(model, best=model.evidence.fit(members | model.evidence.always))
    found = [r for r in regimes_withheld(model, members) if r.regime == "log"]
    assert found[1].doubt_mm > 10.0 * found[0].doubt_mm
    assert not found[1].worse


@pytest.mark.parametrize("speeds", [(1.0, 1.0, 1.0), (1.0, 0.5, 2.0), (1.0, 1.0)])
def test_laps_are_found_whatever_their_speed(speeds: tuple[float, ...]) -> None:
    rate = np.concatenate([np.full(int(300 / v), 2 * np.pi * v / 300) for v in speeds])
    angle = np.concatenate([[0.0], np.cumsum(rate)])
    axis = np.deg2rad([0, -90, 90, 0, 60, 0, 0, 0.0]) + np.zeros((len(angle), 8))
    axis[:, 0] += 0.2 * np.cos(angle)
    axis[:, 1] += 0.15 * np.sin(angle)
    axis[:, 2] += 0.1 * np.sin(2 * angle)
    laps = laps_of(make_scene(simulated(run=(0.04 * np.arange(len(axis)), axis)), kr15()))
    assert [int(lap.sum()) for lap in laps] == pytest.approx([300 / v for v in speeds], abs=6)
    assert (np.sum(laps, axis=0) == 1).all()


def test_no_laps_where_nothing_repeats() -> None:
    for seed in (5, 7, 8):
        assert laps_of(make_scene(simulated(seed=seed), kr15())) == []
    t, axis = poses()
    assert laps_of(make_scene(simulated(run=(t, axis), poses=True), kr15())) == []


@pytest.mark.slow
def test_single_poses_have_regimes_of_place_but_none_of_speed() -> None:
    t, axis = poses()
    log = simulated(
        lambda w: setattr(w, "tool", generator.rigid(3e-4 * np.eye(6)[2])), sigma_mm=SIGMA, run=(t, axis), poses=True
    )
    assert isinstance(log, MeasurementLog)
    found = diagnose([log], kr15()).summary.to_json()["together"]["regimes_withheld"]
    kinds = {r["regime"] for r in found}
    assert kinds <= {"track", "table", "place"}
    assert len(kinds) >= 2
