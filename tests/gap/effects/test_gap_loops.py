"""Springs that slip one after the other, play, and rails in pieces, planted by physics that shares nothing with the effects."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gap_cases import kr15, simulated
from scipy.interpolate import CubicSpline

from camrob.gap.effects.effect import Column, Unit
from camrob.gap.effects.rail_joints import rail_joints
from camrob.gap.effects.registry import library
from camrob.gap.observation.scene import Scene, make_scene

DEG = np.pi / 180.0
WIDER = 20.0  # times the way of the carriage: that of a rail of 3 m


def of(name: str):
    return next(e for e in library() if e.name == name)


def springs(u: np.ndarray, slips: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """What springs in parallel pull with, each slipping at its own stretch, of 1 when all slip."""
    stretch, out = np.zeros(len(slips)), np.zeros(len(u))
    for k in range(1, len(u)):
        stretch = np.clip(stretch + u[k] - u[k - 1], -slips, slips)
        out[k] = np.sum(shares * stretch / slips)
    return out


def pushed(u: np.ndarray, width: float) -> np.ndarray:
    """Where a body is that a pin in a slot takes along."""
    at, out = u[0], np.empty(len(u))
    for k, x in enumerate(u):
        at = min(max(at, x - 0.5 * width), x + 0.5 * width)
        out[k] = at
    return out


def left_of(scene: Scene, columns: list[Column]) -> float:
    """Share of the gap's energy that columns leave, the first seconds aside."""
    y = scene.tcp_gap[200:, :3].ravel()
    X = np.stack([c.tcp[200:, :3].ravel() for c in columns if c.tcp is not None], axis=1)
    return float(np.sum((y - X @ np.linalg.lstsq(X, y, rcond=None)[0]) ** 2) / (y @ y))


def shown(scene: Scene, name: str, *, key: str = "", state=None) -> list[Column]:
    own = [u for u in of(name).units([scene], {}) if u.axis == "A2" and u.key.startswith(key)]
    return [c for u in own for c in of(name).columns(scene, u, state or {})]


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_whatever_springs_slip_three_show_it_and_play_does_not(seed: int) -> None:
    rng = np.random.default_rng(seed)
    slips, shares = np.sort(rng.uniform(0.1, 2.0, 6)) * DEG, rng.dirichlet(np.full(6, 2.0))

    def plant(world) -> None:
        world.link[:, 1] -= 1e-4 * springs(world.command[:, 1], slips, shares)

    scene = make_scene(simulated(plant), kr15())
    loops = left_of(scene, shown(scene, "hysteresis", key="maxwell"))
    played = min(left_of(scene, shown(scene, "backlash", state={"A2_deg": w * DEG})) for w in (0.005, 0.02, 0.1, 0.3))
    assert loops < 0.04
    assert played > 3.0 * loops


@pytest.mark.parametrize("width", [0.03, 0.15])
def test_plays_shape_begins_as_wide_as_its_sides_stand_apart(width: float) -> None:
    def plant(world) -> None:
        world.link[:, 1] += pushed(world.command[:, 1], width * DEG) - world.command[:, 1]

    scene = make_scene(simulated(plant), kr15())
    (unit,) = (u for u in of("backlash").units([scene], {}) if u.axis == "A2")
    assert float(unit.key) == pytest.approx(width * DEG, rel=0.15)
    (other,) = (u for u in of("backlash").units([scene], {}) if u.axis == "A3")
    assert float(other.key) < 0.025 * DEG


def pieces(at: float, step: float, slope: float):
    """A rail whose second piece lies `step` higher at its joint, and climbs."""

    def plant(world) -> None:
        way = world.command[:, 6] - at
        world.after[:, 2] += np.where(way > 0.0, step + slope * way, 0.0)

    return plant


@pytest.mark.parametrize(("step", "slope"), [(2e-4, 0.0), (1e-4, 4e-4), (0.0, 4e-3)])
def test_a_joint_of_the_rail_is_found_with_its_step_and_slope(step: float, slope: float) -> None:
    base = make_scene(simulated(), kr15())
    travel = base.link[:, base.index("E1")]
    at = float(np.quantile(travel, 0.55))
    scene = make_scene(simulated(pieces(at, step, slope), sigma_mm=0.01), kr15())
    joints = rail_joints([scene], "E1")
    assert joints[0] == pytest.approx(at, abs=0.03 * float(np.ptp(travel)))
    units = [u for u in of("track").units([scene], {}) if u.key.startswith(f"beyond {joints[0]:.6f}")]
    values = _fitted(scene, units)
    assert values["E1_joint1_z_mm"] == pytest.approx(step, abs=3e-5)
    assert values["E1_joint1_slope_z"] == pytest.approx(slope, abs=1.5e-4, rel=0.1)


def _fitted(scene: Scene, units: list[Unit]) -> dict[str, float]:
    """Values of some units of the track beside the foot's place."""
    columns = [c.tcp for u in units for c in of("track").columns(scene, u, {})]
    columns += [scene.place(f"root.{p}") for p in ("x", "y", "z", "rx", "ry", "rz")]
    X = np.stack([c[:, :3].ravel() for c in columns if c is not None], axis=1)
    values = np.linalg.lstsq(X, scene.tcp_gap[:, :3].ravel(), rcond=1e-9)[0]
    return dict(zip([p.name for u in units for p in u.parameters], values.tolist(), strict=False))


def test_a_rail_that_is_smooth_has_no_joints() -> None:
    def sag(world) -> None:
        world.after[:, 2] += 1e-3 * (np.cos(np.pi * world.command[:, 6] / 1.6) - 1.0)

    assert rail_joints([make_scene(simulated(sag, sigma_mm=0.01), kr15())], "E1") == ()


def test_nothing_else_is_taken_for_a_joint() -> None:
    def others(world) -> None:
        world.link[:, 1] += pushed(world.command[:, 1], 0.03 * DEG) - world.command[:, 1] + 2e-4
        world.link[:, 2] += 1e-4 * np.sin(36.0 * world.command[:, 2])

    assert rail_joints([make_scene(simulated(others, sigma_mm=0.01), kr15())], "E1") == ()


def test_a_long_rail_goes_from_point_to_point_of_its_alignment() -> None:
    """Points 0.6 m apart, off by 0.1 mm: 98 % of its energy are a course in half waves, and no cubic's."""

    def plant(world) -> None:
        knots = np.arange(-3.0, 3.0, 0.6)
        off = np.random.default_rng(6).normal(0.0, 1e-4, (2, len(knots)))
        for k, side in enumerate((1, 2)):
            world.after[:, side] += CubicSpline(knots, off[k])(
                WIDER * (world.command[:, 6] - world.command[:, 6].mean())
            )

    scene = make_scene(simulated(plant), kr15())
    place = scene.link[:, scene.index("E1")]
    wide = np.where(np.arange(len(scene.axes)) == scene.index("E1"), WIDER, 1.0)
    long = replace(scene, encoder=wide * scene.link, setpoint=None)
    units = [u for u in of("track").units([long], {}) if u.axis == "E1"]
    assert float(np.ptp(WIDER * place)) > 1.8
    assert {u.key.partition(" ")[0] for u in units} >= {"straightness", "waves", "rolls"}
    assert not {"waves", "rolls"} & {u.key.partition(" ")[0] for u in of("track").units([scene], {})}

    def left(kind: str) -> float:
        columns = [c.tcp for u in units if u.key.startswith(kind) for c in of("track").columns(long, u, {})]
        X = np.stack([c[:, :3].ravel() for c in columns if c is not None], axis=1)
        y = scene.tcp_gap[:, :3].ravel()
        return float(np.sum((y - X @ np.linalg.lstsq(X, y, rcond=1e-9)[0]) ** 2) / np.sum(y**2))

    assert left("waves") < 0.02 < 0.05 < left("straightness")
