"""What is ordinary comes from the robot: its masses, reach and payload; unusual is not impossible."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from gap_cases import kr15, simulated
from gap_cells import ur10
from test_gap_effects import DEG, plant_link

from camrob.cell.read_cell import read_cell
from camrob.gap.diagnose import diagnose
from camrob.gap.effects.registry import library
from camrob.gap.effects.robot_size import ordinary_compliance, rated_payload, reach_of
from camrob.gap.observation.believable import check_believable, lost_zero
from camrob.gap.observation.scene import make_scene

KR500 = Path(__file__).resolve().parents[3] / "cells" / "kr500_afp"


def parameters(name: str, cell, scene) -> dict[str, object]:
    effect = next(e for e in library() if e.name == name)
    return {p.name: p for u in effect.units([scene], {}) for p in u.parameters}


@pytest.mark.parametrize(
    ("cell", "least", "most"),
    [
        # KR15 and KR500: of the order of data sheets' gears; UR10: 0.9e-5 (A2) and 1.3e-5 (A3) fitted to ../shared/real
        (kr15, 2e-6, 8e-6),
        (ur10, 0.9e-5, 4e-5),
        (lambda: read_cell(KR500), 1e-7, 5e-7),
    ],
    ids=["kr15", "ur10", "kr500"],
)
def test_large_arms_are_stiff_and_small_ones_soft(cell, least: float, most: float) -> None:
    assert least < ordinary_compliance(cell()) < most


def test_reach_and_payload_are_the_data_sheets() -> None:
    # from A2: what the makers tell, less A1's 0.3 m and on to the plate; the UR10's wrist offset is walked along
    assert reach_of(kr15()) == pytest.approx(1.57 - 0.3 + 0.14, abs=0.03)
    assert reach_of(ur10()) == pytest.approx(1.3 + 0.116, abs=0.03)
    assert (rated_payload(kr15()), rated_payload(ur10())) == (15.0, 10.0)


def test_a_small_arm_is_no_bearer_of_146_kg() -> None:
    scene = make_scene(simulated(), kr15())
    mass = parameters("payload", kr15(), scene)["mass_kg"]
    assert mass.upper == 30.0
    assert mass.common == 15.0


def crashed(world) -> None:
    plant_link(1, lambda w: 2.8 * DEG)(world)


def test_a_zero_that_a_crash_moved_by_degrees_is_found_and_is_no_reason_to_refuse() -> None:
    """33 mm at the tool. The other posture counts: a straight line from the nominal one is wrong by a millimetre."""
    scene = make_scene(simulated(crashed, sigma_mm=0.02), kr15())
    assert np.median(np.linalg.norm(scene.tcp_gap[:, :3], axis=1)) > 0.03
    axis, value = lost_zero(scene) or ("", 0.0)
    assert axis == "A2"
    assert value == pytest.approx(2.8 * DEG, rel=1e-3)
    assert check_believable([scene]) == {"A2": value}
    effect = next(e for e in library() if e.name == "joint_offset")
    unit = next(u for u in effect.units([scene], {}) if u.axis == "A2")
    exact = effect.columns(scene, unit, effect.refine({}, {"A2_deg": 2.8 * DEG}))[0].tcp * 2.8 * DEG
    straight = effect.columns(scene, unit, {})[0].tcp * 2.8 * DEG
    assert np.abs(scene.tcp_gap - exact)[:, :3].max() < 1.5e-4  # the noise
    assert np.abs(scene.tcp_gap - straight)[:, :3].max() > 5e-4


@pytest.mark.slow
def test_it_is_named_with_its_size_and_called_neither_impossible_nor_unusual() -> None:
    found = diagnose([simulated(crashed, sigma_mm=0.02)], kr15())
    assert found.claimed == ("joint_offset",)
    entry = found.summary.to_json()["effects"][0]
    assert entry["implausible"] == entry["unusual"] == ""
    assert entry["axes"] == ["A2"]
    assert entry["parameters"]["A2_deg"]["value"] == pytest.approx(2.8, abs=2e-3)
    assert entry["rms_after_mm"] < 0.05
    assert found.summary.to_json()["status"] == "explained"
