"""What sits in no axis, or follows several quantities, is placed at the tool, the instrument or the axis that holds it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from gap_cases import kr15, poses, simulated
from stranger_arms import UR, Faults, columns_of, driven, scattered, true_poses

from camrob.cell.read_cell import read_cell
from camrob.gap.evidence.design import Panel, build_units, make_panel
from camrob.gap.locate.late_together import late_together
from camrob.gap.locate.likely_part import FOOT, INSTRUMENT, TOOL, _fastest, likely_part
from camrob.gap.locate.sits_at import sits_at
from camrob.gap.observation.noise import noise_of
from camrob.gap.observation.scene import Scene, make_scene
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo, MeasuredFrame

NOISE = 1e-5 * np.sqrt(3.0)


def panel(folder: Path, *, beyond: Callable | None = None, seen: Callable | None = None, poses: bool = False) -> Panel:
    """A log of a UR5 beside a smooth rest: its links `beyond` (t, axes) the encoders, its tip elsewhere by `seen`."""
    (folder / "cell.toml").write_text(UR.cell)
    if poses:
        axis = scattered(UR, 90, 4)
        t = np.cumsum(np.random.default_rng(5).uniform(5.0, 13.0, len(axis)))
    else:
        t, axis = driven(UR, 30.0, 4)
    T = true_poses(UR, axis if beyond is None else axis + beyond(t, axis), Faults(rest=2e-5), 6)
    if seen is not None:
        T[:, :3, 3] += seen(t, axis, T.copy())
    rows = np.arange(0, len(t), 1 if poses else 5)
    columns = columns_of(UR, t[rows], axis[rows], T[rows], turned=False)
    scene = make_scene(
        MeasurementLog(columns, LogInfo(sigma_position=1e-5, poses=poses), Path("log.csv")), read_cell(folder)
    )
    return make_panel(scene, 0, build_units([scene], [], {}), [], {}, noise_of(scene), np.ones(len(scene), bool), 10, 0)


def only(k: int, values: np.ndarray, axis: np.ndarray) -> np.ndarray:
    out = np.zeros_like(axis)
    out[:, k] = values
    return out


def running_out(t: np.ndarray, axis: np.ndarray, T: np.ndarray) -> np.ndarray:
    """A spindle that creeps round, 0.7 turns a second, and does not run true."""
    w = 2.0 * np.pi * 0.7
    return 1.5e-4 * np.einsum("nij,nj->ni", T[:, :3, :3], np.stack([np.cos(w * t), np.sin(w * t), 0.0 * t], 1))


@pytest.mark.parametrize("poses", [True, False])
def test_a_spindle_that_creeps_round_is_the_tool_s_and_comes_back_with_the_time(poses: bool, tmp_path: Path) -> None:
    """Of single poses, too, some ten seconds apart: they stand at uneven times."""
    found = likely_part([panel(tmp_path, seen=running_out, poses=poses)], NOISE)
    assert found is not None
    assert (found.moves, found.follows) == (TOOL, "time")
    assert found.period == pytest.approx(1.0 / 0.7, rel=0.01)
    assert found.share > 0.7
    assert found.size == pytest.approx(1.5e-4, rel=0.1)


def test_an_angle_disc_off_its_pivot_is_the_instrument_s(tmp_path: Path) -> None:
    def off(t: np.ndarray, axis: np.ndarray, T: np.ndarray) -> np.ndarray:
        away = T[:, :2, 3] - [2.0, 0.5]
        bearing = np.arctan2(away[:, 1], away[:, 0])
        return 2e-4 * np.sin(2.0 * bearing)[:, None] * np.c_[-away[:, 1], away[:, 0], 0.0 * t]

    found = likely_part([panel(tmp_path, seen=off)], NOISE)
    assert found is not None
    assert (found.moves, found.follows, found.period) == (INSTRUMENT, "position", None)


@pytest.mark.parametrize("poses", [True, False])
def test_an_axis_that_follows_two_is_that_axis(poses: bool, tmp_path: Path) -> None:
    rods = lambda t, q: only(2, 1.5e-3 * np.sin(q[:, 2] - 2.0 * q[:, 1] + 0.6), q)  # noqa: E731
    found = likely_part([panel(tmp_path, beyond=rods, poses=poses)], NOISE)
    assert found is not None
    assert (found.moves, found.follows) == ("A3", "position")
    assert found.share > 0.8


def test_a_key_that_rolls_over_follows_the_acceleration_with_its_size(tmp_path: Path) -> None:
    def key(t: np.ndarray, q: np.ndarray) -> np.ndarray:
        a = np.gradient(np.gradient(q[:, 0], t), t)
        push, side, out = 0.5 * np.quantile(np.abs(a), 0.8), 0.0, []
        for now in a:
            side = float(np.sign(now)) if abs(now) > push else side
            out.append(side)
        return only(0, 4e-4 * np.array(out), q)

    found = likely_part([panel(tmp_path, beyond=key)], NOISE)
    assert found is not None
    assert (found.moves, found.follows) == ("A1", "acceleration")
    assert found.size == pytest.approx(4e-4, rel=0.15)  # a little less, as it stands longer at one side


def test_a_floor_that_dips_and_comes_back_is_no_axis(tmp_path: Path) -> None:
    dip = lambda t, q, T: 4e-4 / (1.0 + ((t - 14.0) / 5.0) ** 2)[:, None] ** 2 * [0.3, 0.0, -1.0]  # noqa: E731
    found = likely_part([panel(tmp_path, seen=dip)], NOISE)
    assert found is not None
    assert found.moves in (FOOT, INSTRUMENT)
    assert found.follows == "time"


def test_worn_rollers_tip_what_their_axis_carries_by_its_place(tmp_path: Path) -> None:
    """Of one direction at a time that is A2 by A1's angle."""

    def tips(t: np.ndarray, q: np.ndarray, T: np.ndarray) -> np.ndarray:
        waves = np.cos(3.0 * q[:, 0]), np.sin(3.0 * q[:, 0] + 0.3) + 0.5 * np.sin(5.0 * q[:, 0])
        return np.cross(3e-4 * np.stack([*waves, 0.0 * t], axis=1), T[:, :3, 3])

    found = likely_part([panel(tmp_path, seen=tips, poses=True)], NOISE)
    assert found is not None
    assert (found.moves, found.follows) == ("A1", "position")
    assert found.share > 0.7


def test_a_tool_that_is_loose_hangs_by_its_weight(tmp_path: Path) -> None:
    side = lambda t, q, T: 3e-4 * np.tanh(T[:, 2, :1] / 0.2) * T[:, :3, 0]  # noqa: E731
    found = likely_part([panel(tmp_path, seen=side, poses=True)], NOISE)
    assert found is not None
    assert (found.moves, found.follows) == (TOOL, "load")


@pytest.mark.parametrize("moves", [TOOL, INSTRUMENT])
def test_what_was_bumped_is_elsewhere_from_then_on(moves: str, tmp_path: Path) -> None:
    def bump(t: np.ndarray, q: np.ndarray, T: np.ndarray) -> np.ndarray:
        way = np.array([2e-4, -3e-4, 1e-4])
        return (t > 0.4 * t[-1])[:, None] * (T[:, :3, :3] @ way if moves == TOOL else way)

    found = likely_part([panel(tmp_path, seen=bump, poses=True)], NOISE)
    assert found is not None
    assert (found.moves, found.follows) == (moves, "time")
    assert found.share > 0.8


@pytest.mark.parametrize("poses", [True, False])
def test_noise_beside_a_smooth_rest_has_no_clear_part(poses: bool, tmp_path: Path) -> None:
    """Though twenty thousand rates are tried of poses."""
    found = likely_part([panel(tmp_path, poses=poses)], np.hypot(NOISE, 2e-5))
    assert found is None or found.period is None or found.share < 0.15


def scene(folder: Path, lateness: Callable) -> Scene:
    """Drives that are behind by the lateness (N, k) s of (t, axes) times their speed, encoders known to 5e-6 rad."""
    (folder / "cell.toml").write_text(UR.cell)
    t, command = driven(UR, 20.0, 3)
    speed = np.gradient(command, t, axis=0)
    encoder = command - lateness(t, command) * speed + 5e-6 * np.random.default_rng(1).normal(size=command.shape)
    columns = columns_of(UR, t, encoder, None, setpoint=command)
    return make_scene(MeasurementLog(columns, LogInfo(sigma_axis=5e-6), Path("log.csv")), read_cell(folder))


def test_drives_that_fall_behind_at_the_same_times_are_late_together(tmp_path: Path) -> None:
    stalls = lambda t, q: np.tile(0.004 * ((t % 2.5) < 0.3)[:, None], (1, q.shape[1]))  # noqa: E731
    assert late_together([scene(tmp_path, stalls)])


def test_drives_that_are_late_at_times_of_their_own_are_not(tmp_path: Path) -> None:
    own = lambda t, q: 0.004 * ((t[:, None] % np.linspace(2.0, 3.0, q.shape[1])) < 0.3)  # noqa: E731
    alone = lambda t, q: only(2, np.full(len(t), 0.004), q)  # noqa: E731
    assert not late_together([scene(tmp_path, own)])
    assert not late_together([scene(tmp_path, alone)])


def test_a_spindle_that_turns_four_times_a_second_is_found_in_half_a_minute(tmp_path: Path) -> None:
    """120 cycles within the log: more than a thinned log could tell."""
    w = 2.0 * np.pi * 4.0

    def fast(t: np.ndarray, axis: np.ndarray, T: np.ndarray) -> np.ndarray:
        off = np.stack([np.cos(w * t), np.sin(w * t), 0.0 * t], 1)
        return 1.5e-4 * np.einsum("nij,nj->ni", T[:, :3, :3], off)

    found = likely_part([panel(tmp_path, seen=fast)], NOISE)
    assert found is not None
    assert (found.moves, found.follows) == (TOOL, "time")
    assert found.period == pytest.approx(0.25, rel=0.01)


def test_poses_every_twelve_seconds_tell_no_wave_from_what_each_second_pose_does(tmp_path: Path) -> None:
    """A log whose every second pose is elsewhere comes back every 24 s; not with 12 s, nor with any shorter period."""
    each = np.arange(48)
    found = _fastest(12.0 * each)
    assert found == pytest.approx(1.0 / 24.0)
    assert _fastest(12.0 * each + np.random.default_rng(1).uniform(0.0, 3.0, 48)) == np.inf


def of_kr15(after: Callable, *, in_base: bool) -> Panel:
    """Poses of an arm on a track beside a table; the tool is elsewhere by after(track, table), m in the world."""

    def apply(world) -> None:
        world.in_base = in_base
        world.after += after(world.command[:, 6], world.command[:, 7])

    frame = MeasuredFrame.BASE if in_base else MeasuredFrame.WORLD
    log = simulated(apply, sigma_mm=0.01, run=poses(160), poses=True, measured_frame=frame)
    scene = make_scene(log, kr15())
    return make_panel(scene, 0, build_units([scene], [], {}), [], {}, noise_of(scene), np.ones(len(scene), bool), 10, 0)


def rocking(track: np.ndarray, table: np.ndarray) -> np.ndarray:
    """A plate that rocks and runs out as its table turns."""
    return 2e-4 * np.stack([np.cos(table), np.sin(2.0 * table), 0.5 * np.cos(2.0 * table)], axis=1)


def bowed(track: np.ndarray, table: np.ndarray) -> np.ndarray:
    """A carriage that leaves the line of its rail to the side and upwards."""
    return 3e-4 * np.stack([0.0 * track, np.sin(3.0 * track), np.cos(2.0 * track)], axis=1)


@pytest.mark.parametrize(("after", "in_base", "axis"), [(rocking, True, "E2"), (bowed, False, "E1")])
def test_what_goes_with_a_table_or_a_carriage_is_theirs_and_no_axis_s_of_the_arm(
    after: Callable, in_base: bool, axis: str
) -> None:
    found = likely_part([of_kr15(after, in_base=in_base)], NOISE)
    assert found is not None
    assert (found.moves, found.follows, found.period, found.along) == (axis, "position", None, False)
    assert found.share > 0.8


def test_an_axis_that_moves_as_the_table_turns_stands_for_the_table() -> None:
    """An arm knows nothing of how far a table has turned."""
    model = SimpleNamespace(scenes=[of_kr15(bowed, in_base=False).scene])
    assert sits_at("A3", "E2", model) == "E2"
    assert sits_at("A1", "speed of E1", model) == "E1"
    assert sits_at("A4", "speed of A1", model) == "A1" and sits_at("A4", "direction of A4", model) == "A4"
    assert sits_at("A3", "A2", model) == "A3" and sits_at("E2", "A2", model) == "E2"
    # hoses that the last axis winds pull at those before it; an arm's own weight does through the others
    assert sits_at("A5", "A6", model) == "A6" and sits_at("A2", "A3", model) == "A2"
    assert sits_at("foot z", "A2", model) == "A2" and sits_at("foot z", "time", model) == "time"


def test_an_axis_that_comes_and_goes_with_the_time_is_named_with_its_period(tmp_path: Path) -> None:
    """A balancer whose pressure falls and is pumped up again: seen from outside the arm it comes back, and A2 alone shows it."""

    def pumped(t: np.ndarray, axis: np.ndarray) -> np.ndarray:
        return only(1, 4e-4 * np.sin(2.0 * np.pi * t / 1.7), axis)

    found = likely_part([panel(tmp_path, beyond=pumped)], NOISE)
    assert found is not None
    assert (found.moves, found.follows, found.along) == ("A2", "time", True)
    assert found.period == pytest.approx(1.7, rel=0.02)
