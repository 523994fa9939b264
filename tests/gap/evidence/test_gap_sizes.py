"""Before and after on withheld samples, effect by effect: alone, added last and together, with tails and intervals."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from gap_cases import generator, kr15, simulated
from test_gap_effects import plant_play
from test_gap_program import measured, raster

from camrob.gap.diagnose import diagnose
from camrob.gap.evidence.shrink import Shrinkage, figures

SIGMA = 0.02
FIGURES = {
    "rms_before_mm",
    "rms_after_mm",
    "p95_before_mm",
    "p95_after_mm",
    "max_before_mm",
    "max_after_mm",
    "shrink",
    "shrink_interval",
}


def plant_two(world) -> None:
    plant_play(world)
    world.tool = generator.rigid(4e-4 * np.eye(6)[0])


@cache
def summary() -> dict[str, Any]:
    return diagnose([simulated(plant_two, sigma_mm=SIGMA)], kr15()).summary.to_json()


def test_figures_are_those_of_the_vectors() -> None:
    rng = np.random.default_rng(0)
    before, block = rng.normal(size=(4000, 3)), np.arange(4000) // 400
    found = figures(Shrinkage(1e-3 * before, 0.25e-3 * before, block)).to_json()
    sizes = np.linalg.norm(before, axis=1)
    assert found["rms_before_mm"] == pytest.approx(np.sqrt(np.mean(sizes**2)))
    assert found["p95_before_mm"] == pytest.approx(np.quantile(sizes, 0.95))
    assert found["max_after_mm"] == pytest.approx(0.25 * sizes.max())
    assert found["shrink"] == pytest.approx(0.75)
    assert found["shrink_interval"] == pytest.approx([0.75, 0.75])
    # paired: what is common to before and after does not widen the interval, what differs does
    uneven = figures(Shrinkage(before, before * np.where(block % 2, 0.9, 0.1)[:, None], block))
    low, high = uneven.shrink_interval
    assert low < uneven.shrink < high
    assert high - low > 0.1


@pytest.mark.slow
def test_every_effect_has_its_figures_alone_added_last_and_together() -> None:
    diagnosis = summary()
    claimed = [e for e in diagnosis["effects"] if e["probability"] >= 0.5]
    assert {e["effect"] for e in claimed} == {"backlash", "frame_tool"}
    floor = diagnosis["gap"]["noise_mm"]
    for e in claimed:
        for part in (e, e["alone"], e["added_last"]):
            assert set(part) >= FIGURES
            for when in ("before", "after"):
                assert 0.0 < part[f"rms_{when}_mm"] < part[f"p95_{when}_mm"] < part[f"max_{when}_mm"]
            low, high = part["shrink_interval"]
            assert low <= part["shrink"] <= high
            assert part["shrink"] == pytest.approx(1.0 - part["rms_after_mm"] / part["rms_before_mm"])
        # one alone leaves the other; added last, it takes what the other left down to the noise
        assert e["alone"]["rms_after_mm"] > 2.0 * floor
        assert e["added_last"]["rms_before_mm"] == pytest.approx(e["alone"]["rms_before_mm"], rel=0.9)
        assert e["added_last"]["rms_after_mm"] == pytest.approx(floor, rel=0.08)
        assert e["added_last"]["shrink_interval"][0] > 0.5
    together = diagnosis["together"]
    assert set(together) >= FIGURES
    assert together["left_aside"] < 60
    assert together["rms_after_mm"] == pytest.approx(claimed[0]["added_last"]["rms_after_mm"])


def test_rounded_corners_have_the_same_figures() -> None:
    entry = diagnose([measured(raster(4.0))], kr15(), programs=[raster(4.0)]).summary.to_json()["effects"][0]
    assert entry["effect"] == "corner_rounding"
    assert set(entry["alone"]) == set(entry["added_last"]) == FIGURES
    assert entry["max_before_mm"] == pytest.approx(4.0 / 4, rel=0.05)  # a parabola over 4 mm to both sides
