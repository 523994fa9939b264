"""Logs that tell several payloads: what gives way changes with them, on an arm of other code, with and without known masses."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from gap_cases import kr15
from stranger_arms import KR, SEVEN, Faults, columns_of, placed, pulled, scattered, true_poses

from camrob.cell.read_cell import read_cell
from camrob.gap.diagnose import diagnose
from camrob.gap.effects.joint_compliance import EFFECT
from camrob.gap.observation.scene import make_scene
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo

ARM = replace(SEVEN, masses=((1, 4.0, (0.0, 0.0, 0.1)), (3, 3.0, (0.0, 0.0, 0.05)), (6, 1.5, (0.0, 0.0, 0.0))))
GIVE = {1: 7.3e-5}  # rad/Nm, of A2, as a public set has


def log_of(folder: Path, payload: float, seed: int, *, told: bool) -> MeasurementLog:
    """40 poses with a load at the plate, A2 giving way under it and the arm's own weight."""
    axis = scattered(SEVEN, 40, seed)
    loaded = replace(ARM, masses=(*ARM.masses, (6, payload, (0.0, 0.0, 0.0))))
    T = true_poses(loaded, axis, Faults(give=GIVE), seed)
    columns = columns_of(SEVEN, np.arange(40.0), axis, T, turned=False, sigma=2e-5, seed=seed)
    info = LogInfo(sigma_position=2e-5, poses=True, **({"payload": payload} if told else {}))
    return MeasurementLog(columns, info, folder / f"load{payload:g}.csv")


@pytest.mark.parametrize("told", [True, False])
def test_two_payloads_that_logs_tell_are_one_spring_of_an_arm_of_unknown_masses(told: bool, tmp_path: Path) -> None:
    (tmp_path / "cell.toml").write_text(SEVEN.cell)
    logs = [log_of(tmp_path, load, seed, told=told) for load, seed in ((0.0, 3), (5.0, 4))]
    said = diagnose(logs, read_cell(tmp_path)).summary
    left = said.together.rms_after_mm
    if not told:
        # a load that nobody told came between the logs, and is seen as that or as what gives way more under it
        came = [e for e in said.claimed if e.since is not None]
        assert not said.claimed or left > 0.2 or [e for e in came if "payload" in e.alike]
        return
    assert [e.effect for e in said.claimed] == ["joint_compliance"] and said.claimed[0].axes[:1] == ("A2",)
    assert left < 0.06
    assert said.unknown.probability < 0.5


def test_of_known_masses_the_load_beyond_the_least_weighs_at_the_tool() -> None:
    """Nm by the slope of the potential energy, of the heaviest mass at the flange, which is the tool's."""
    axis = scattered(KR, 12, 5)
    columns = columns_of(KR, np.arange(12.0), axis, placed(KR, axis))
    infos = [LogInfo(sigma_position=1e-5, poses=True, payload=load) for load in (2.0, 7.0)]
    scenes = [make_scene(MeasurementLog(columns, info, Path(f"{k}.csv")), kr15()) for k, info in enumerate(infos)]
    (unit,) = (u for u in EFFECT.units(scenes, {}) if u.axis == "A2")
    least, most = (EFFECT.columns(s, unit, {})[0].tcp for s in scenes)
    lever = scenes[0].place("A2.zero")
    turned = np.sum((most - least) * lever, axis=1) / np.sum(lever**2, axis=1)
    load = replace(KR, masses=((5, 5.0, (0.0, 0.0, 0.13)),))
    assert turned == pytest.approx(pulled(load, axis)[:, 1], abs=0.05)
    assert np.abs(turned).max() > 20.0


@pytest.mark.parametrize("told", [True, False])
def test_one_payload_that_is_told_is_no_load_that_nobody_counted(told: bool, tmp_path: Path) -> None:
    """A2 gives way under the arm's own masses, which the cell tells, and under 5 kg at the plate, of which the log alone does."""
    masses = "\n".join(
        f'[[mass]]\nname = "m{k}"\nafter = "A{k}"\nmass_kg = {kg}\ncenter_mm = {[1e3 * v for v in at]}'
        for k, kg, at in ((k + 1, kg, at) for k, kg, at in ARM.masses)
    )
    (tmp_path / "cell.toml").write_text(f"{SEVEN.cell}\n{masses}\n")
    log = log_of(tmp_path, 5.0, 3, told=told)
    said = diagnose([log], read_cell(tmp_path)).summary
    found = {e.effect: e for e in said.claimed}
    if not told:
        assert set(found) != {"joint_compliance"} or said.together.rms_after_mm > 0.06
        return
    assert set(found) == {"joint_compliance"} and said.unknown.probability < 0.5
    assert found["joint_compliance"].parameters["A2_rad_nm"].value == pytest.approx(GIVE[1], rel=0.05)
