"""The band on a real arm: a UR10 learnt on one night, and where it truly stood on others, some 50 to 90 degrees of posture off.

Nothing of it is simulated: poses at rest under a laser tracker, published by others (Landgraf et al., IEEE CASE 2021). The
tracker's frame and the reflector's place are known of no night: what they can take of a deviation is taken out of it, and out of
what was said of it alike.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from camrob.cell.read_cell import read_cell
from camrob.gap.diagnose import diagnose
from camrob.gap.effects.registry import library
from camrob.gap.fitted_units import FittedUnits, fitted_units
from camrob.gap.observation.scene import make_scene
from camrob.measurement.log import MeasurementLog
from camrob.measurement.read_log import read_log
from camrob.prediction.band import band_within
from camrob.prediction.true_path import true_path
from camrob.se3 import inverse

ROOT = Path(__file__).resolve().parents[2]
UR10 = ROOT.parent / "shared" / "real" / "ur10_tmac"
CELL = read_cell(ROOT / "tests" / "data" / "ur10")
ASKED = 250  # poses of a night that tell a share well enough


def night(name: str, every: int = 1) -> MeasurementLog:
    log = read_log(UR10 / f"{name}.csv")
    return MeasurementLog({k: np.asarray(v)[::every] for k, v in log.columns.items()}, log.info)


def learnt(log: MeasurementLog) -> tuple[FittedUnits, float]:
    """What a diagnosis of one night finds, and m in one direction that stays."""
    said = diagnose([log], CELL).summary
    assert said.compensable.fitted is not None
    found = fitted_units(said.compensable.fitted, library())
    rest = 1e-3 * said.unexplained_mm / np.sqrt(3.0) if found.unexplained is None else found.unexplained.rest
    return found, rest


def held(found: FittedUnits, rest: float, log: MeasurementLog) -> float:
    """The share of a night's coordinates that lie within the stated 95 % band."""
    scene, q = make_scene(log, CELL), log.axes(CELL.axis_names)
    columns = {"t": np.asarray(scene.t), "line": np.zeros(len(scene), int)}
    columns |= {f"c{a}": q[:, k] for k, a in enumerate(CELL.axis_names)}
    path = true_path(MeasurementLog(columns, replace(log.info)), CELL, None, found, rest=rest, drawn=True)
    some = np.linspace(0, len(scene) - 1, min(ASKED, len(scene))).astype(int)
    there = inverse(scene.frames.left) @ np.asarray(scene.measured) @ inverse(scene.frames.right)
    true = path.true[some]
    off = (there[some] - true)[:, :3, 3].ravel()
    frames = np.zeros((len(some), 3, 9))  # the tracker's shift and turn, and the reflector's place on the flange
    frames[:, :, :3], frames[:, :, 6:] = np.eye(3), true[:, :3, :3]
    for k in range(3):
        frames[:, :, 3 + k] = np.cross(np.eye(3)[k], true[:, :3, 3] - true[:, :3, 3].mean(axis=0))
    basis, _ = np.linalg.qr(frames.reshape(len(off), 9))
    less = np.eye(len(off)) - basis @ basis.T
    assert path.together is not None
    field = np.kron(path.together[some], np.eye(3))
    apart = np.maximum(path.rest[some] ** 2 - np.sum(path.together[some] ** 2, axis=1), 0.0)
    fitted, unsized = (
        np.sum((less @ part) ** 2, axis=1) for part in (path.spread[some][:, :3].reshape(len(off), -1), field)
    )
    variance = fitted + unsized + less**2 @ np.repeat(apart, 3)
    return float(np.mean(np.abs(less @ off) <= band_within(variance, unsized)))


@pytest.mark.slow
@pytest.mark.skipif(not UR10.is_dir(), reason="../shared is not here: real/ur10_tmac")
@pytest.mark.parametrize(
    ("first", "every", "others"),
    [("D", 1, ("B", "A")), ("B", 1, ("D", "A")), ("A", 20, ("D", "B"))],
    ids=["D", "B", "A"],
)
def test_one_night_s_band_holds_where_the_arm_stood_on_another(first: str, every: int, others: tuple[str, ...]) -> None:
    """Six pairs hold 93.9 to 99.5 %, 96.3 in the mean (2026-11-28; 92.1 to 99.1 with the field's size taken as known)."""
    found, rest = learnt(night(first, every))
    for name in others:
        assert 0.93 < held(found, rest, night(name, 12 if name == "A" else 1)) <= 1.0, name
