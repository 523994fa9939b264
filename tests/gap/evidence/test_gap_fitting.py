"""Which values are reported, and what is predicted with them, where far more than noise stays on an arm and follows posture."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from gap_cells import log_of, ur10
from test_gap_pose_sets import postures

from camrob.calibration.terms import parameter_of
from camrob.errors import CamrobError
from camrob.gap.effects.registry import library
from camrob.gap.evidence.comparison import compare
from camrob.gap.evidence.discrepancy import smooth_basis
from camrob.gap.evidence.fitting import with_fitting
from camrob.gap.evidence.predicted import expected
from camrob.gap.evidence.shrink import shrinkage, trial_of
from camrob.gap.fitted_units import fitted_model
from camrob.gap.observation.scene import make_scene
from camrob.measurement.log import MeasurementLog

CALLED = {"geometry", "joint_offset", "joint_compliance"}
SEED, COSINES = 4, 14
SIZE = 0.3  # mm of what changes slowly with posture, and of what changes fast, an axis


def links() -> list[str]:
    """All constants of the first five links."""
    found = []
    for name in (f"A{k}.{part}" for k in range(1, 6) for part in ("zero", "x", "y", "z", "rx", "ry", "rz")):
        try:
            parameter_of(ur10(), name)
        except CamrobError:
            continue
        found.append(name)
    return found


def poses_of(axis: np.ndarray, size: float) -> MeasurementLog:
    """Positions of a UR10 whose links are all a little wrong, with beside it what no effect of the library is: cosines over
    pairs of axes of `size` mm, half of them slow, half of them fast.
    """
    rng = np.random.default_rng(SEED)
    wrong = {n: 0.3 * rng.normal() * (5e-4 if n[-2:] in (".x", ".y", ".z") else 1e-3) for n in links()}
    log = log_of(ur10(), np.arange(float(len(axis))), axis, wrong, sigma_mm=0.02, seed=SEED, poses=True)
    rest = np.zeros((len(axis), 3))
    for low, high in ((0.6, 2.0), (4.0, 9.0)):
        pairs = np.array([rng.choice(6, 2, replace=False) for _ in range(COSINES)])
        rates = rng.uniform(low, high, (COSINES, 2))
        turned = np.stack([axis[:, p] @ r for p, r in zip(pairs, rates, strict=True)], axis=1)
        rest += (
            np.cos(turned + rng.uniform(0, 2 * np.pi, COSINES)) @ rng.normal(0, 1, (COSINES, 3)) * np.sqrt(2 / COSINES)
        )
    columns = {**log.columns, **{n: log.columns[n] + size * rest[:, k] for k, n in enumerate("xyz")}}
    return replace(log, columns={n: v for n, v in columns.items() if n not in "abc"})


@cache
def compared(size: float):
    """The comparison on 120 poses, with a rest of some size, beside the values as its discrepancy leaves them."""
    scene = make_scene(poses_of(postures(120, SEED), size), ur10())
    return compare([scene], [e for e in library() if e.name in CALLED])


def test_values_that_the_discrepancy_keeps_small_are_fitted_without_it() -> None:
    """On neighbourhoods that a fit left out, and on other postures, more is taken away; who is at work is what it was."""
    model = compared(SIZE)
    found = with_fitting(model, trial_of(model, ()))
    assert found.heat_alone is not None
    assert found.best.members == model.best.members
    assert found.sets == model.sets
    other = make_scene(poses_of(postures(200, SEED + 1), SIZE), ur10())
    for trial in (trial_of(model, ()), trial_of(model, [other])):
        beside, alone = (shrinkage(m, trial, m.best.members) for m in (model, found))
        assert beside.rms_before == pytest.approx(alone.rms_before)
        assert alone.rms_after < 0.95 * beside.rms_after
    # a value may be off by no less, as the discrepancy is there whether it takes part or not
    assert found.best.cov == pytest.approx(model.best.cov)
    # but what is handed on may also be off by as much as the two ways to fit differ
    members = found.best.members - found.evidence.always
    columns = np.flatnonzero(np.isin(found.design.owner, sorted(members)))
    apart = (found.best.mean - model.best.mean)[columns]
    said = np.array(fitted_model(found, members).covariance)
    assert said == pytest.approx(model.best.cov[np.ix_(columns, columns)] + np.outer(apart, apart))
    assert np.any(apart**2 > np.diag(model.best.cov)[columns])


def test_they_stay_as_they_are_where_nothing_but_noise_stays() -> None:
    model = compared(0.0)
    found = with_fitting(model, trial_of(model, ()))
    assert found.heat_alone is None
    assert found.best.mean == pytest.approx(model.best.mean)


def test_far_from_the_logs_a_discrepancy_is_predicted_that_nobody_has_seen() -> None:
    """Two radians away the functions of the logs' postures are silent, and as much may stay as the discrepancy's prior allows."""
    model = compared(SIZE)
    model = with_fitting(model, trial_of(model, ()))
    away = postures(200, SEED + 2) + np.deg2rad([100.0, 0.0, -100.0, 100.0, 100.0, 100.0])
    trials = [trial_of(model, [make_scene(poses_of(q, SIZE), ur10())]) for q in (model.scenes[0].link, away)]
    after = [expected(model, trial, model.best.members)[1] for trial in trials]
    reached = [shrinkage(model, trial, model.best.members).rms_after for trial in trials]
    unseen = np.sqrt(3.0 / model.basis.unit) * model.evidence.sizes[0, 0]
    assert after[1] == pytest.approx(np.hypot(after[0], unseen), rel=0.2)
    assert after == pytest.approx(reached, rel=0.5)


def test_the_discrepancy_is_as_unsure_as_its_kernel_says() -> None:
    """At fitted rows against the dense Gaussian; of what its functions don't hold nothing where the logs were, all far away."""
    scene = make_scene(poses_of(postures(120, SEED), SIZE), ur10())
    basis = smooth_basis([scene])
    model = compared(SIZE)
    field, sizes = model.evidence.field, model.evidence.sizes
    assert field is not None
    assert sizes is not None
    F = model.panels[0].smooth
    w = model.panels[0].w_tcp[:, 0]
    K = sizes[0, 0] ** 2 * F @ F.T
    dense = K - K @ np.linalg.solve(K + np.diag(model.evidence.temperature / w**2), K)
    V = field.scatter(F, sizes)[0]
    assert V.T @ V == pytest.approx(dense, abs=1e-3 * np.abs(dense).max())
    rows = np.arange(50)
    assert np.diag(basis.beyond(scene, rows)).max() < 0.02 / basis.unit
    far = make_scene(poses_of(postures(120, SEED) + np.deg2rad(300.0), SIZE), ur10())
    assert np.diag(basis.beyond(far, rows)) == pytest.approx(1.0 / basis.unit, rel=0.02)
