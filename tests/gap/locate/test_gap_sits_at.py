"""At which axis a shape sits, and where what stays beside a claim that is not sure."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from camrob.cell.joint import Role
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
