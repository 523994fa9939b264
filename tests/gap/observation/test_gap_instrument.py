"""The instrument as a suspect: logs mixed up are named for what they are, gross rows are found, a wrong scale is reported."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from gap_cases import kr15, poses, simulated
from gap_cells import ur10
from summary_samples import diagnosis_summary, effect_found
from test_gap_pose_sets import postures, seen_from

from camrob.errors import LogError
from camrob.gap.effects.registry import library
from camrob.gap.evidence.comparison import compare
from camrob.gap.observation.believable import check_believable, check_reading
from camrob.gap.observation.noise import find_outliers, noise_of
from camrob.gap.observation.scene import make_scene
from camrob.gap.verdict.instrument_suspect import instrument_suspect
from camrob.measurement.log import MeasurementLog
from camrob.summaries.diagnosis_summary import FittedValue


def mixed_up(log: MeasurementLog, how: str) -> MeasurementLog:
    columns = {n: np.array(v) for n, v in log.columns.items() if n not in "abc"}
    if how.endswith("mirrored"):
        columns[how[0]] *= -1.0
    elif how.startswith("rows"):
        for n in "xyz":
            columns[n] = np.roll(columns[n], 1 if "after" in how else -1)
        return MeasurementLog(columns, log.info, log.path).select(slice(1, -1))
    else:
        columns[how[0]], columns[how[1]] = columns[how[1]], columns[how[0]]
    return MeasurementLog(columns, log.info, log.path)


MIXED_UP = {
    "y mirrored": "its y is mirrored: corrected so, the measured TCP lies 0.0",
    "z mirrored": "its z is mirrored",
    "xy exchanged": "its columns x and y are exchanged",
    "yz exchanged": "its columns y and z are exchanged",
    "rows after": "its readings stand one row after the poses that they belong to",
    "rows before": "its readings stand one row before the poses that they belong to",
}


@pytest.mark.parametrize("how", MIXED_UP)
def test_a_log_that_was_mixed_up_is_reported_what_it_is(how: str) -> None:
    log = simulated(sigma_mm=0.02, run=poses() if how.startswith("rows") else None, poses=how.startswith("rows"))
    with pytest.raises(LogError, match=MIXED_UP[how]) as refused:
        check_believable([make_scene(mixed_up(log, how), kr15())])
    assert "\n" not in str(refused.value)
    assert "; correct the log" in str(refused.value)


@pytest.mark.slow(after=1)
@pytest.mark.parametrize(
    ("how", "words"), [("z mirrored", "its frame is mirrored"), ("rows after", "one row after the poses")]
)
def test_it_is_reported_in_a_frame_that_nobody_knows_too(how: str, words: str) -> None:
    with pytest.raises(LogError, match=words):
        check_believable([make_scene(mixed_up(seen_from(postures(80, 1)), how), ur10())])


def test_an_axis_that_counts_from_the_horizontal_is_reported_with_what_to_add() -> None:
    log = seen_from(postures(80, 1))
    fanuc = MeasurementLog(dict(log.columns) | {"A3": log.columns["A3"] - log.columns["A2"]}, log.info, log.path)
    with pytest.raises(LogError, match=r"its A3 counts from the horizontal.+A2 has to be added.+\[table\]"):
        check_believable([make_scene(fanuc, ur10())])


def test_a_ball_in_sockets_stays_where_it_is_and_an_instrument_that_hangs_does_not_pass() -> None:
    """Two places, read again and again: a ball on A6's axis that A6 alone turns stays there, under other motions nothing does."""
    log = seen_from(postures(80, 1))
    second = np.arange(80) >= 40
    places = {n: np.where(second, 50.0 * (n == "x"), 0.0) for n in "xyz"}
    still = {f"A{k}": np.where(second, 20.0 - 10.0 * k, -10.0 + 15.0 * k) for k in range(1, 6)}
    aside = np.eye(4)
    aside[:3, 3] = [0.1, 0.0, 0.05]
    held = MeasurementLog(dict(log.columns) | places | still, log.info, log.path)
    check_reading(make_scene(held, ur10().with_tool(aside)))
    hung = dict(log.columns) | {n: np.where(second, log.columns[n], log.columns[n][0]) for n in "xyz"}
    for columns in (hung, dict(log.columns) | places):
        with pytest.raises(LogError, match="stay the same to the last digit"):
            check_reading(make_scene(MeasurementLog(columns, log.info, log.path), ur10()))


def test_what_no_mistake_mends_is_called_none() -> None:
    """Another robot's poses: refused, and no mistake is made up for it."""
    log = seen_from(postures(80, 1))
    other = seen_from(postures(80, 9))
    columns = dict(log.columns) | {n: other.columns[n] for n in "xyz"}
    with pytest.raises(LogError, match="check the cell, the order and units"):
        check_believable([make_scene(MeasurementLog(columns, log.info, log.path), ur10())])


def spoilt(log: MeasurementLog, share: float, size_mm: float) -> tuple[MeasurementLog, np.ndarray]:
    """The log with a share of its positions off by so much, each its own way."""
    rng = np.random.default_rng(4)
    rows = np.zeros(len(log), bool)
    rows[rng.choice(len(log), max(1, round(share * len(log))), replace=False)] = True
    away = rng.normal(size=(len(log), 3))
    away *= size_mm * rng.uniform(1.0, 10.0, (len(log), 1)) / np.linalg.norm(away, axis=1, keepdims=True)
    columns = dict(log.columns) | {n: log.columns[n] + rows * away[:, k] for k, n in enumerate("xyz")}
    return MeasurementLog(columns, log.info, log.path), rows


@pytest.mark.parametrize("share", [0.01, 0.1])
@pytest.mark.parametrize("kind", ["poses", "path"])
def test_gross_rows_are_found_and_no_others(kind: str, share: float) -> None:
    """A centimetre and more, beside wrong zeros that move poses by a millimetre or two; 2 mm and more on a path."""
    if kind == "poses":
        log, rows = spoilt(seen_from(postures(150, 1)), share, 10.0)
        scene = make_scene(log, ur10())
    else:
        log, rows = spoilt(simulated(sigma_mm=0.02), share, 2.0)
        scene = make_scene(log, kr15())
    found = find_outliers(scene, noise_of(scene))
    assert found[rows].mean() > 0.98
    assert found[~rows].mean() < 0.002


def test_a_wrong_scale_is_reported_in_ppm_with_what_looks_alike_and_gross_rows_are_counted() -> None:
    log, rows = spoilt(seen_from(postures(120, 1)), 0.02, 10.0)
    columns = dict(log.columns) | {n: log.columns[n] * (1.0 + 4e-4) for n in "xyz"}
    scene = make_scene(MeasurementLog(columns, log.info, Path("set.csv")), ur10())
    model = compare([scene], [e for e in library() if e.name in ("measurement_scale", "joint_offset")])
    own = frozenset(i for i in model.best.members if model.units[i].effect == "measurement_scale")
    values = model.values(own, model.best)
    fitted = {
        p.name: FittedValue(value=float(values[k]), std=0.0) for k, p in enumerate(model.design.parameters) if values[k]
    }
    entry = replace(
        diagnosis_summary(effects=[effect_found("measurement_scale", [], {"scale": 4e-4})]).effects[0],
        probability=0.9,
        parameters=fitted,
        indistinguishable_from=("geometry",),
    )
    found = instrument_suspect(model, [entry]).to_json()
    assert found["suspect"] == 0.9
    assert found["scale_ppm"] == pytest.approx(400.0, rel=0.03)
    assert found["drift_mm"] is None
    assert "+" in found["text"] and "ppm off; a track's scale and longer links would look alike" in found["text"]
    assert found["gross"][0]["rows"] == rows.sum() == 2
    assert sorted(r["sample"] - 1 for r in found["gross"][0]["first"]) == np.flatnonzero(rows).tolist()
    assert "2 rows of set.csv are gross" in found["text"]
