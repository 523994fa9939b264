"""A claim takes something, is constant where its description says so, and is no surer than what it works against."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from camrob.gap.effects.registry import library
from camrob.gap.evidence.shrink import Shrinkage
from camrob.gap.verdict import withdrawn
from camrob.gap.verdict.alike import partners
from camrob.gap.verdict.alike.unsteady import unsteady

ROWS, NOISE = 240, 1e-4


def model_of(gap: np.ndarray, turn: np.ndarray) -> Any:
    """A fitted log of one axis, whose tool is bent by 1 mm along x as the axis stands (N,): the gap (N,) along it is told."""
    rng = np.random.default_rng(0)
    tcp = np.zeros((ROWS, 6, 2))
    tcp[:, 0, 0], tcp[:, 1, 1] = np.cos(turn), np.sin(turn)
    y = np.zeros((ROWS, 6))
    y[:, :3] = rng.normal(0.0, NOISE, (ROWS, 3))
    y[:, 0] += gap
    w = np.zeros((ROWS, 6))
    w[:, :3] = 1.0 / NOISE
    mean = np.zeros(2)
    A = tcp[:, :3].reshape(-1, 2)
    mean[:] = np.linalg.lstsq(A, y[:, :3].ravel())[0]
    scene = SimpleNamespace(t=np.linspace(0.0, 60.0, ROWS), link=turn[:, None], axes=("A1",), index=lambda _: 0)
    panel = SimpleNamespace(scene=range(ROWS), tcp=tcp, y_tcp=y, w_tcp=w, twists=lambda v: tcp @ v)
    units = [SimpleNamespace(effect="frame_tool"), SimpleNamespace(effect="geometry")]
    return SimpleNamespace(
        panels=(panel,),
        scenes=(scene,),
        units=units,
        best=SimpleNamespace(members=frozenset({0, 1}), mean=mean),
        design=SimpleNamespace(owner=np.array([0, 1])),
        evidence=SimpleNamespace(
            effects_of=lambda members: frozenset(units[i].effect for i in members), temperature=1.0
        ),
        values=lambda members, fitted: np.where(np.isin([0, 1], list(members)), fitted.mean, 0.0),
    )


@pytest.mark.parametrize(
    ("grows", "found"),
    [(0.0, {}), (0.8, {"frame_tool": "time"})],
)
def test_a_tool_that_grows_while_it_is_measured_is_not_a_bent_one(grows: float, found: dict[str, str]) -> None:
    turn = np.random.default_rng(1).uniform(-1.0, 1.0, ROWS)
    course = 1.0 + grows * np.linspace(-1.0, 1.0, ROWS)
    model = model_of(1e-3 * course * np.cos(turn), turn)
    assert unsteady(model, library(), ["frame_tool", "geometry"], ()) == found


def test_what_an_arm_leaves_beside_a_bent_tool_is_no_other_course_of_it() -> None:
    turn = np.random.default_rng(1).uniform(-1.0, 1.0, ROWS)
    model = model_of(1e-3 * np.cos(turn), turn)
    model.panels[0].y_tcp[:, 2] += 1e-3 * np.sin(9.0 * turn)
    assert unsteady(model, library(), ["frame_tool"], ()) == {}


def test_a_name_of_twice_the_gap_is_no_surer_than_what_takes_it_back(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes = {"joint_offset": 2.0, "gear_ripple": 1.4, "payload": 0.2}
    monkeypatch.setattr(partners, "settled_rms", lambda _model, _panels, names: sizes[names[0]])
    model: Any = SimpleNamespace(gap=1.0, panels=())
    said = {"joint_offset": 0.97, "gear_ripple": 0.6, "payload": 0.3}
    assert partners.no_surer_than_partners(model, said) == {**said, "joint_offset": 0.6}
    alone = {"joint_offset": 0.97, "payload": 0.3}
    assert partners.no_surer_than_partners(model, alone) == alone


@pytest.mark.parametrize("lag_alone", [1.3, 0.99])
def test_claims_that_take_nothing_where_they_were_not_fitted_are_withdrawn(
    lag_alone: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    left = {frozenset({0, 1}): 1.01, frozenset({0}): 0.6, frozenset({1}): lag_alone, frozenset(): 1.0}

    def shrunk(_model: Any, _trial: Any, _all: Any, kept: frozenset[int], *, at_drives: bool) -> Shrinkage:
        rows = np.ones((40, 3))
        return Shrinkage(rows, left[kept] * rows, np.arange(40) // 4)

    monkeypatch.setattr(withdrawn, "shrinkage", shrunk)
    monkeypatch.setattr(withdrawn, "without_drives_rest", lambda _model, trial: trial)
    units = (SimpleNamespace(effect="friction"), SimpleNamespace(effect="servo_lag"))
    model: Any = SimpleNamespace(units=units, best=SimpleNamespace(members=frozenset({0, 1})))
    trial: Any = None
    assert withdrawn.take_nothing(model, trial, {"friction": 0.97, "servo_lag": 0.97}, ()) == ["servo_lag"]
    assert withdrawn.take_nothing(model, trial, {"friction": 0.2, "servo_lag": 0.97}, ()) == ["servo_lag"]
    assert withdrawn.take_nothing(model, trial, {"friction": 0.97, "servo_lag": 0.2}, ()) == []
    assert withdrawn.take_nothing(model, trial, {"friction": 0.97, "servo_lag": 0.97}, ("servo_lag",)) == [
        "friction",
        "servo_lag",
    ]


@pytest.mark.parametrize(("steps", "alike"), [((1.0, -1.0, 1.0, 0.0, 1.0), ("backlash",)), ((1.0, -0.2, 2.0, 0.5), ())])
def test_of_even_steps_a_share_of_the_last_one_is_what_play_leaves(
    steps: tuple[float, ...], alike: tuple[str, ...]
) -> None:
    early = next(e for e in library() if e.name == "early_reading")
    link = np.cumsum([0.0, *steps])[:, None]
    scene: Any = SimpleNamespace(axes=("A1",), link=link, encoder=link, command=link, index=lambda _: 0)
    assert early.likewise([scene]) == alike
