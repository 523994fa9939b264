"""Where the gap lies: planted errors found in their direction, axis, stretch and regime, with intervals that hold them."""

from __future__ import annotations

import numpy as np
import pytest
from gap_cases import generator, kr15, simulated

from camrob.gap.design import Panel, build_units, make_panel
from camrob.gap.diagnose import diagnose
from camrob.gap.localise import axes_of, directions_of, regimes_of, segments_of
from camrob.gap.noise import noise_of
from camrob.gap.rungs import RUNGS, ladder
from camrob.gap.scene import make_scene
from camrob.measure.log import MeasurementLog

SIGMA = 0.02


def panel(log: MeasurementLog) -> Panel:
    scene = make_scene(log, kr15())
    noise = noise_of(scene)
    return make_panel(scene, 0, build_units([scene], [], {}), [], {}, noise, np.ones(len(scene), bool), 10, 0)


def shifted(direction: str):
    """0.3 mm at the tool, along an axis of world or of the tool."""

    def apply(world) -> None:
        if direction.startswith("tool"):
            part = {"tool_x": 0, "tool_y": 1, "tool_axis": 2}[direction]
            world.tool = generator.rigid(3e-4 * np.eye(6)[part])
        else:
            world.after[:, "xyz".index(direction)] += 3e-4

    return apply


@pytest.mark.parametrize("direction", ["x", "y", "z", "tool_x", "tool_y", "tool_axis"])
def test_a_shift_is_told_in_its_direction(direction: str) -> None:
    told = directions_of([panel(simulated(shifted(direction), sigma_mm=SIGMA))])
    same = ("tool_x", "tool_y", "tool_axis") if direction.startswith("tool") else ("x", "y", "z")
    assert max(same, key=lambda n: told[n].value) == direction
    assert told[direction].value == pytest.approx(3e-4, rel=0.02)
    assert told[direction].low <= told[direction].value <= told[direction].high
    assert told["along"].value ** 2 + told["across"].value ** 2 == pytest.approx(
        9e-8 + 3 * (SIGMA * 1e-3) ** 2, rel=0.05
    )


def test_an_error_of_one_axis_is_told_at_that_axis() -> None:
    def apply(world) -> None:
        world.link[:, 0] += 3e-4 * np.sin(0.7 * world.t)

    told = axes_of([panel(simulated(apply, sigma_mm=SIGMA))])
    assert told["A1"].value > 0.9
    assert 0.8 < told["A1"].low <= told["A1"].high <= 1.0
    assert told["E2"].value == 0.0  # measured in world, the table can't be seen


def test_a_step_is_a_change_point_and_its_stretch_is_told() -> None:
    def apply(world) -> None:
        world.after[:, 2] += 4e-4 * (world.t > 25.0)

    one = panel(simulated(apply, sigma_mm=SIGMA))
    parts = segments_of([one])
    large = [s for s in parts if s.rms > 2e-4]
    rows = np.flatnonzero(one.scene.t > 25.0)
    assert min(s.from_line for s in large) == pytest.approx(rows[0] + 2, abs=3)
    assert all(s.rms < 6e-5 for s in parts if s not in large)
    assert all(s.contour**2 + s.tangential**2 == pytest.approx(s.rms**2, rel=1e-6) for s in parts)


@pytest.mark.parametrize(
    ("regime", "apply"),
    [
        ("time", lambda w: w.after.__setitem__((slice(None), 0), w.after[:, 0] + 1e-5 * w.t)),
        ("track", lambda w: w.after.__setitem__((slice(None), 1), w.after[:, 1] + 2e-3 * w.command[:, 6])),
        ("table", lambda w: w.after.__setitem__((slice(None), 2), w.after[:, 2] + 2e-3 * w.command[:, 7])),
        ("speed", lambda w: setattr(w, "delay", 0.01)),
    ],
)
def test_what_follows_a_regime_is_told_there(regime: str, apply) -> None:
    one = panel(simulated(apply, sigma_mm=SIGMA))
    told = regimes_of([one], SIGMA * 1e-3 * np.sqrt(3), [regime])[regime]
    assert told["share"] > 0.8
    low, high = told["interval"]
    assert 0.7 < low <= told["share"] <= high + 1e-9


def test_the_summary_says_what_is_missing_and_what_that_costs() -> None:
    log = simulated(shifted("x"), sigma_mm=SIGMA)
    for drop, words in (("c", "no set-points: what the drives do"), ("", "no encoders: drives and arm")):
        columns = {n: v for n, v in log.columns.items() if n not in {f"{drop}{a}" for a in generator.AXES}}
        where = diagnose([MeasurementLog(columns, log.info, log.path)], kr15()).summary["where"]
        assert any(m.startswith(words) for m in where["missing"])
        assert any(m.startswith("no program: corner rounding") for m in where["missing"])
        assert where["rungs"]["setpoint_to_encoder"] is None
        assert where["rung_intervals"]["setpoint_to_encoder"] is None
        low, high = where["rung_intervals"]["encoder_to_tcp"]
        assert low <= where["rungs"]["encoder_to_tcp"] <= high
        assert set(where["further_regimes"]) == {"force", "temperature", "track", "table"}


@pytest.mark.parametrize("drop", ["", "encoders", "setpoints"])
def test_the_rungs_add_up_whatever_is_missing(drop: str) -> None:
    def apply(world) -> None:
        world.drive[:, 1] += 1e-4 * np.sin(world.t)
        world.link[:, 2] += 2e-4

    log = simulated(apply, sigma_mm=SIGMA)
    lost = {"": set(), "encoders": set(generator.AXES), "setpoints": {f"c{a}" for a in generator.AXES}}[drop]
    scene = make_scene(
        MeasurementLog({n: v for n, v in log.columns.items() if n not in lost}, log.info, log.path), kr15()
    )
    rungs = ladder(scene, None)
    parts = [getattr(rungs, n) for n in RUNGS if getattr(rungs, n) is not None]
    assert np.abs(np.sum(parts, axis=0) - rungs.whole).max() < 1e-15
    if drop != "setpoints":
        commanded = make_scene(simulated(), kr15()).nominal[:, :3, 3]
        assert np.abs(rungs.whole - (scene.measured[:, :3, 3] - commanded)).max() < 1e-9
