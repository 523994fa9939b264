"""A cause that the library lacks: what is named in its place is named with the doubt that it deserves."""

from __future__ import annotations

import pytest
from gap_cases import kr15, simulated
from test_gap_effects import plant_link
from test_gap_experiment import sagging

from camrob.gap.diagnose import diagnose


def beliefs(apply, *without: str) -> dict[str, float]:
    found = diagnose([simulated(apply, sigma_mm=0.02, rate=12.5)], kr15(), without=without).summary
    return {e["effect"]: e["probability"] for e in found["effects"]}


def test_compliance_taken_out_makes_no_other_name_sure() -> None:
    """Payload and the part of a ripple that the path shows of A2 explain it to the noise together: neither is above 0.8."""
    said = beliefs(sagging, "joint_compliance")
    assert said["payload"] >= 0.5
    assert said["gear_ripple"] >= 0.5
    assert max(said.values()) < 0.8


@pytest.mark.slow
def test_where_no_part_of_a_cycle_is_needed_a_name_is_as_sure_as_ever() -> None:
    assert beliefs(sagging)["joint_compliance"] > 0.95
    assert beliefs(plant_link(2, lambda w: 1.5e-3))["joint_offset"] > 0.95
