"""At which axis a shape sits, and where what stays beside a claim that is not sure."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from stranger_arms import UR, driven
from test_gap_likely_part import NOISE, only, panel

from camrob.cell.joint import Role
from camrob.gap.locate.again import not_by_posture
from camrob.gap.locate.sits_at import sits_at
from camrob.gap.verdict.remains import _at_unsure
from camrob.summaries.diagnosis_summary import EffectFound, UnknownPlace


def test_what_a_slide_does_by_another_s_place_is_that_one_s_guide(monkeypatch: pytest.MonkeyPatch) -> None:
    joints = [SimpleNamespace(prismatic=k < 3, role=Role.ARM) for k in range(4)]
    cell = SimpleNamespace(joints=joints, index=lambda axis: int(axis[1:]) - 1)
    scene = SimpleNamespace(cell=cell, axes=("A1", "A2", "A3", "A4"))
    model = cast(Any, SimpleNamespace(scenes=[scene]))
    monkeypatch.setattr("camrob.gap.locate.sits_at.arm_axes", lambda cell: scene.axes)
    assert sits_at("A3", "A2", model) == "A2"
    assert sits_at("A3", "torque on A2", model) == "A3"
    assert sits_at("A4", "A2", model) == "A4"


def test_what_stays_beside_a_claim_that_is_not_sure_is_at_its_place_where_nothing_else_tells_one() -> None:
    nothing = UnknownPlace(stage="encoder_to_tcp", axes=(), regimes=(), comes_back="")
    claim = cast(
        EffectFound, SimpleNamespace(effect="track", axes=("E1",), stands_out=("E1",), regimes=("position", "speed"))
    )
    where, text = _at_unsure(nothing, "0.150 mm rms stays unexplained", claim)
    assert (where.stage, where.axes, where.regimes) == ("encoder_to_tcp", ("E1",), ("position", "speed"))
    assert text.startswith("0.150 mm rms stays unexplained; ")
    assert "track" in text and "E1" in text and "not sure" in text


def to_and_fro(t: np.ndarray) -> np.ndarray:
    """A place that a run of 30 s comes back to six times."""
    return np.sin(2.0 * np.pi * t / 5.0)


@pytest.mark.parametrize("gust", [True, False])
def test_what_is_another_one_at_the_same_posture_does_not_follow_it(
    gust: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A gust comes and goes with the time, a bent link with the posture: both are smooth along a path."""

    def repeated(machine: Any, seconds: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
        t, _ = driven(UR, seconds, seed)
        ways = np.stack([to_and_fro(t + 0.3 * k) for k in range(6)], axis=1)
        return t, UR.home + 0.3 * UR.swing * ways

    def beyond(t: np.ndarray, axis: np.ndarray) -> np.ndarray:
        blown = np.sin(2.0 * np.pi * t / 7.3) * np.sin(2.0 * np.pi * t / 11.9)
        return only(0, 4e-4 * (blown if gust else np.sin(2.0 * (axis[:, 1] - UR.home[1]) / UR.swing[1])), axis)

    monkeypatch.setattr("test_gap_likely_part.driven", repeated)
    log = panel(tmp_path, beyond=beyond)
    assert not_by_posture([log], NOISE, [f"A{k}" for k in range(1, 7)]) is gust
    assert not not_by_posture([panel(tmp_path, beyond=beyond, poses=True)], NOISE, [f"A{k}" for k in range(1, 7)])
