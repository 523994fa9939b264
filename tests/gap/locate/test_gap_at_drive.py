"""A drive that is beyond its noise is the place unless far more of the gap lies behind the encoders."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from camrob.gap.verdict.remains import at_drive
from camrob.summaries.diagnosis_summary import Unknown, UnknownPlace

WORDS = "between set-point and encoder, A2 is off its set-point"


def log(drives: float, arm: float) -> Any:
    """A log of which all drives, and the arm behind them, are off by so much."""
    rows = np.ones((50, 6))
    scene = SimpleNamespace(torque=np.zeros((50, 6)), index=lambda axis: int(axis[1:]) - 1, servo_gap=None)
    return SimpleNamespace(
        scene=scene, w_tcp=rows, y_tcp=arm * rows, y_servo=drives * rows, carried=lambda shifts: shifts[:, :3]
    )


@pytest.mark.parametrize(
    ("drives", "arm", "stage"),
    [
        (2.8e-5, 1e-3, "encoder_to_tcp"),
        (6e-4, 1e-3, "encoder_to_tcp"),
        (8e-4, 1e-3, "setpoint_to_encoder"),
        (1e-3, 2.8e-5, "setpoint_to_encoder"),
    ],
)
def test_the_place_is_at_a_drive_unless_far_more_lies_behind_the_encoders(
    drives: float, arm: float, stage: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    behind = UnknownPlace(stage="encoder_to_tcp", axes=("A5",), regimes=("position",), comes_back="")
    stays = Unknown(
        probability=0.95, rms_mm=1.0, share=1.0, where=behind, text="A5 follows A5", shapes=(), implausible={}
    )
    panel = log(drives, arm)
    monkeypatch.setattr("camrob.gap.verdict.remains.axes_report", lambda scenes: {"A2": SimpleNamespace(drive=None)})
    monkeypatch.setattr("camrob.gap.verdict.remains.late_together", lambda scenes: False)
    model = cast(Any, SimpleNamespace(noise=1e-5, scenes=[panel.scene]))
    found = at_drive(stays, model, [panel], "A2", WORDS)
    assert found.where.stage == stage
    assert found.where.axes == (("A5",) if stage == "encoder_to_tcp" else ("A2",))
    assert WORDS in found.text
    assert "A5 follows A5" in found.text
