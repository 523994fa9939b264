"""The third author's generator: apart from what it judges, and each cause alone does what it states."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from imported_names import taken_names
from scipy.spatial.transform import Rotation

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "bench"))
FOLDER = ROOT / "tests" / "bench" / "gap" / "third_author"
# what the second author's plumbing is: no cell of a family, no description, no motion of one
PLUMBING = ("case", "chain", "design", "family", "kr15", "logs", "motion.limits", "run")

from gap.second_author import case as plumbing  # noqa: E402
from gap.second_author import design  # noqa: E402
from gap.second_author.family import Setting  # noqa: E402
from gap.second_author.run import Run  # noqa: E402
from gap.second_author.run import played as played_run  # noqa: E402
from gap.third_author import drives, gears, instrument, moves, structure, tools  # noqa: E402
from gap.third_author.case import case, cuts, flags  # noqa: E402
from gap.third_author.cells import CELLS, gantry, painter, palletiser, scara  # noqa: E402
from gap.third_author.family import FAMILY  # noqa: E402

ROBOTS = [make() for make, _ in CELLS.values()]
LOG = {
    "show": "path",
    "tracker": True,
    "setpoints": True,
    "encoders": True,
    "frame": "world",
    "target": "tool",
    "sixd": True,
}


def _ramp(robot, axis, speed, seconds=12.0, dt=0.004):
    """One axis at constant speed behind a gentle start (N,), the others at home."""
    t = np.arange(0.0, seconds, dt)
    c = np.repeat((np.array(robot.home) * robot.unit)[None], len(t), 0)
    c[:, axis] += speed * np.where(t < 1, 0.5 * t * t, t - 0.5)
    return Run(robot, t, c)


def _wave(robot, axis, size, period=4.0, cycles=5, dt=0.004):
    """One axis to and fro, the others at home."""
    t = np.arange(0.0, period * cycles, dt)
    c = np.repeat((np.array(robot.home) * robot.unit)[None], len(t), 0)
    c[:, axis] += size * (1 - np.cos(2 * np.pi * t / period))
    return Run(robot, t, c)


def _setting(run):
    return Setting(run.robot, [run], dict(LOG))


def test_makers_import_numpy_scipy_and_plumbing_alone() -> None:
    allowed, bad = set(sys.stdlib_module_names) | {"numpy", "scipy"}, []
    for path in FOLDER.glob("*.py"):
        for name in taken_names(path):
            own = name.startswith("gap.third_author")
            lent = any(name.startswith(f"gap.second_author.{p}") or name == f"gap.second_author.{p}" for p in PLUMBING)
            if not own and not lent and name.split(".")[0] not in allowed:
                bad.append(f"{path.name}: {name}")
    assert len(list(FOLDER.glob("*.py"))) >= 12 and not bad


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda r: r.name)
def test_chains_and_gravity_are_those_of_pinocchio(robot) -> None:
    import pinocchio as pin

    model, joint, offset, (pre, post), joints = pin.Model(), 0, robot.base, robot._fixed, {}
    for i, row in enumerate(robot.rows):
        kind = pin.JointModelPZ() if robot.slides[i] else pin.JointModelRZ()
        joint = model.addJoint(joint, kind, pin.SE3(offset @ pre[i]), row.name)
        joints[row.name], offset = joint, post[i]
    tip = model.addFrame(pin.Frame("tip", joint, pin.SE3(offset @ robot.tip), pin.FrameType.OP_FRAME))
    for body in robot.bodies:
        at = pin.SE3(post[robot.names.index(body.after)])
        model.appendBodyToJoint(
            joints[body.after], pin.Inertia(body.mass, np.array(body.centre) / 1e3, np.zeros((3, 3))), at
        )
    data, rng = model.createData(), np.random.default_rng(8)
    for _ in range(4):
        values = (np.array(robot.home) + rng.uniform(-25, 25, len(robot.rows))) * robot.unit
        q = robot.q(values)
        pin.framesForwardKinematics(model, data, q)
        assert np.abs(data.oMf[tip].homogeneous - robot.pose(values)[0]).max() < 1e-12
        gravity = pin.computeGeneralizedGravity(model, data, q)
        assert np.abs(-robot.moments(values)[0, :, 2] - gravity).max() < 1e-9 * max(1.0, np.abs(gravity).max())
        run = Run(robot, np.arange(2.0), np.stack([values, values]))
        mass = np.diag(pin.crba(model, data, q))
        for i in range(len(robot.rows)):  # motors add the same to both: half of the mean
            assert tools.inertia(run, i)[0] - 1e-4 == pytest.approx(1.5 * mass[i], rel=1e-9, abs=1e-9)


def test_scara_is_the_plane_formula() -> None:
    robot = scara()
    one, two = np.radians([33.0, -71.0])
    tool = robot.pose(np.array([33.0, -71.0, 60.0, 12.0]) * robot.unit)[0]
    tip = np.array([45.0, 10.0])  # in the flange, whose z looks down: the other way round
    turn = one + two - np.radians(12.0)
    x = 350 * np.cos(one) + 300 * np.cos(one + two) + tip[0] * np.cos(turn) + tip[1] * np.sin(turn)
    y = 350 * np.sin(one) + 300 * np.sin(one + two) + tip[0] * np.sin(turn) - tip[1] * np.cos(turn)
    assert np.allclose(tool[:3, 3] * 1e3, [x, y, 415 - 60 - 40 - 90], atol=1e-9)


def test_gantry_axes_run_along_world_and_its_arm_hangs() -> None:
    robot = gantry()
    home = np.array(robot.home) * robot.unit
    step = robot.pose(home + np.array([0.1, 0.2, 0, 0, 0, 0, 0, 0]))[0] - robot.pose(home)[0]
    assert np.allclose(step[:3, 3], [0.1, 0.2, 0.0], atol=1e-12)
    assert np.allclose(robot.frames(home)[0][2][0, :3, 2], [0, 0, -1], atol=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_a_palletisers_hand_stays_level_on_every_motion(seed) -> None:
    robot, rng = palletiser(), np.random.default_rng(seed)
    _, c = moves.paths(robot, rng, 12.0, 0.02) if seed % 2 else moves.postures(robot, rng, 40)
    total = c[:, 1:4].sum(axis=1)
    assert np.ptp(total) < 1e-3 or np.ptp(c[:, 3]) == 0.0
    assert np.ptp(c[:, 1]) > 0 or np.ptp(c[:, 0]) > 0 or np.ptp(c[:, 4]) > 0


def test_a_steady_axis_lags_by_its_time_constant_and_a_late_one_by_its_delay() -> None:
    run = _ramp(painter(), 0, 0.2)
    for make in (drives.servo_lag, drives.setpoint_delay):
        cause = make(_setting(run), np.random.default_rng(2), 1.3)
        behind = -cause.drive(run)[-1000:, 0].mean() / 0.2
        assert behind == pytest.approx(cause.params["A1_s"], rel=0.02)


def test_inertia_errors_follow_acceleration_and_have_no_mean_over_a_cycle() -> None:
    run = _wave(painter(), 1, 0.2)
    for make, hook in ((drives.inertia_fed_forward, "drive"), (drives.inertia_behind, "link")):
        added = getattr(make(_setting(run), np.random.default_rng(1), 1.0), hook)(run)[1000:, 1]
        assert abs(np.corrcoef(added, run.a[1000:, 1])[0, 1]) > 0.9
        assert abs(added.mean()) < 0.1 * np.abs(added).max()


def test_friction_changes_its_sign_with_direction_and_fades_in_a_loop_with_an_integrator() -> None:
    run = _wave(painter(), 0, 0.2, period=8.0, cycles=3)
    added = drives.friction(_setting(run), np.random.default_rng(1), 1.0).drive(run)[:, 0]
    back, forth = added[2000:3000], added[3000:4000]
    assert np.abs(back + forth).max() < 0.05 * np.abs(back).max()
    assert np.abs(forth[500:700]).mean() < 0.5 * np.abs(forth).max() and forth[:500].mean() * run.v[3200, 0] < 0


def test_slip_elements_keep_their_laws() -> None:
    """Stiff at first, at most Coulomb's force, the same on every closed cycle."""
    dt, v = 1e-3, np.tile(np.concatenate([np.full(500, 0.1), np.full(500, -0.1)]), 4)
    limits, stiff = np.array([0.5, 0.3, 0.2]), np.array([100.0, 40.0, 10.0])
    force = drives.slip_force(v, dt, limits.tolist(), stiff.tolist(), 10.0, np.ones(len(v)))
    assert force[0] == pytest.approx(150 * 0.1 * dt) and force.max() <= 1.0 + 1e-9
    assert np.allclose(force[2000:3000], force[3000:4000], atol=1e-6)


def test_play_is_as_wide_as_stated_and_lags() -> None:
    run = _wave(painter(), 0, 0.2)
    setting = _setting(run)
    cause = gears.backlash(setting, np.random.default_rng(3), 2.0)
    added, width = cause.link(run)[:, 0], np.radians(cause.params["A1_deg"])
    assert 0.75 * width < np.ptp(added[500:]) <= width
    fast = np.abs(run.v[:, 0]) > 0.5 * np.abs(run.v[:, 0]).max()
    assert np.all(added[fast] * run.v[fast, 0] < 0)


def test_boucs_and_wens_state_saturates_at_one_and_its_loop_closes() -> None:
    x = np.concatenate([[0.0], np.tile(np.concatenate([np.linspace(0, 1, 400), np.linspace(1, 0, 400)]), 3)])
    z = gears.bouc_wen(x, 0.05, 0.7, 1.5)
    assert z.max() == pytest.approx(1.0, abs=0.02) and z.min() < -0.9
    assert np.allclose(z[801:1601], z[1601:2401], atol=1e-3)
    assert gears.bouc_wen(np.array([0.0, 5.0]), 0.05, 0.7, 1.5)[1] == pytest.approx(1.0, abs=0.03)


def test_ripple_has_its_order_and_no_mean() -> None:
    run = _ramp(painter(), 0, 0.5, seconds=16.0)
    cause = gears.gear_ripple(_setting(run), np.random.default_rng(4), 1.0)
    q, added = run.c[400:, 0], cause.link(run)[400:, 0]
    even = np.linspace(q[0], q[0] + 2 * np.pi, 20000, endpoint=False)
    orders = np.abs(np.fft.rfft(np.interp(even, q, added)))
    assert np.argmax(orders) == round(cause.params["orders_a_turn"]) and orders[0] < 0.02 * orders.max()


def test_a_crash_bends_no_joint_about_its_own_axis() -> None:
    robot = painter()
    posture = np.array(robot.home) * robot.unit
    _, ends, _ = robot.frames(posture)
    axes = robot.frames(posture)[0]
    for i, twist in structure.crashed(robot, posture, np.random.default_rng(1)).items():
        world = ends[i][0, :3, :3] @ twist[3:]
        assert abs(world @ axes[i][0, :3, 2]) < 1e-9 and abs(twist[5]) < 1e-9


def test_gears_give_by_load_and_their_loop_is_within_its_share() -> None:
    robot = painter()
    run = _wave(robot, 1, 0.3)
    cause = structure.joint_compliance(_setting(run), np.random.default_rng(5), 1.0)
    added = cause.link(run)
    for name in cause.axes:
        i = robot.names.index(name)
        straight = cause.params[f"{name}_rad_Nm"] * run.load[:, i]
        assert np.abs(added[:, i] - straight).max() < 0.1 * np.abs(straight).max()


def test_links_grow_along_themselves_by_the_same_share() -> None:
    """All rows longer by a share: the tip goes from the foot by that share, whichever convention the rows have."""
    for name in ("painter", "cobot", "rotary_base"):
        robot = CELLS[name][0]()
        robot.tool = (0.0,) * 6
        values = (np.array(robot.home) * robot.unit)[None]
        between = {}
        for i in range(len(robot.rows)):
            for place, more in structure.longer(robot, i, np.array([1e-4])).items():
                between[place] = between.get(place, 0.0) + more
        foot, tip = robot.base[:3, 3], robot.pose(values)[0, :3, 3]
        assert np.allclose(robot.pose(values, between)[0, :3, 3] - tip, 1e-4 * (tip - foot), atol=1e-8)


def test_heat_rises_to_the_power_over_the_time_constant_and_goes_on_between_runs() -> None:
    t = np.arange(0.0, 50.0, 0.05)
    robot = painter()
    first, later = (Run(robot, t, np.zeros((len(t), 6)), begins=b) for b in (0.0, 600.0))
    assert structure.heated(first, np.ones(len(t)), 20.0)[-1] == pytest.approx(1 - np.exp(-2.5), rel=1e-2)
    assert np.allclose(structure.heated(later, None, 200.0), 1 - np.exp(-later.clock / 200.0))


def test_a_camera_pair_scales_by_what_it_states_across_its_sight() -> None:
    run = Run(painter(), np.arange(3.0), np.zeros((3, 6)), True)
    cause = instrument.measurement_scale(_setting(run), np.random.default_rng(6), 1.0)
    tool = np.repeat(np.eye(4)[None], 3, 0)
    tool[1, 0, 3], tool[2, 1, 3] = 1.0, 1.0
    moved = cause.measured(run, tool) - tool
    gain = np.linalg.norm((moved[1:] - moved[0])[:, :3, 3], axis=1) * 1e6 / abs(cause.params["ppm"])
    assert np.all(gain > 0.69) and np.all(gain < 1.51)


def test_a_table_that_stands_off_is_one_small_frame_in_world() -> None:
    robot = CELLS["lathe"][0]()
    run = _wave(robot, 0, 0.2, cycles=1)
    run.table = np.linspace(0, 5, len(run.t))
    cause = instrument.frame_table(_setting(run), np.random.default_rng(7), 1.0)
    rows = np.arange(0, len(run.t), 50)
    seen, plain = played_run(run, [cause], rows)[1], played_run(run, [], rows)[1]
    back = Rotation.from_rotvec(np.outer(-run.table[rows], [0, 0, 1.0]))
    off, at = back.apply((seen - plain)[:, :3, 3]), back.apply(plain[:, :3, 3])
    tilt, shift = np.array(cause.params["tilt_rad"]), np.array(cause.params["off_mm"]) / 1e3
    assert np.allclose(off, np.cross(tilt, at) + shift, atol=1e-3 * np.abs(off).max())


def test_ripple_of_current_sensors_has_the_orders_of_pole_pairs() -> None:
    run = _ramp(painter(), 0, 0.05, seconds=40.0)
    cause = drives.motor_commutation(_setting(run), np.random.default_rng(4), 1.0)
    q, added = run.c[2000:, 0], cause.drive(run)[2000:, 0]
    even = np.linspace(q[0], q[0] + 1.5, 30000, endpoint=False)
    waves = np.abs(np.fft.rfft(np.interp(even, q, added) * np.hanning(len(even))))
    order = cause.params["orders_a_turn"]
    assert np.argmax(waves) * 2 * np.pi / 1.5 == pytest.approx(order, abs=5) or np.argmax(
        waves
    ) * 2 * np.pi / 1.5 == pytest.approx(2 * order, abs=5)


@pytest.mark.parametrize("make", [structure.frame_base, instrument.measurement_frame])
def test_frames_that_are_off_keep_distances(make) -> None:
    run = Run(painter(), *moves.postures(painter(), np.random.default_rng(1), 20), True)
    plain, moved = (
        played_run(run, causes)[1][:, :3, 3] for causes in ([], [make(_setting(run), np.random.default_rng(2), 1.0)])
    )
    first, then = (np.linalg.norm(p[:, None] - p, axis=2) for p in (plain, moved))
    assert np.abs(first - then).max() < 1e-9 and np.linalg.norm(plain - moved, axis=1).max() > 1e-5


def test_a_tracker_jumps_from_nothing_and_stays_between() -> None:
    t = np.arange(0.0, 600.0, 0.5)
    run = Run(painter(), t, np.repeat((np.array(painter().home) * painter().unit)[None], len(t), 0))
    cause = instrument.measurement_drift(_setting(run), np.random.default_rng(3), 1.0)
    moved = np.linalg.norm(cause.measured(run, run.tip)[:, :3, 3] - run.tip[:, :3, 3], axis=1)
    jumps = int((np.abs(np.diff(moved)) > 1e-12).sum())
    assert moved[0] == 0.0 and 3 <= jumps <= 60 and moved.max() > 2e-5


def test_early_readings_are_odd_in_the_move_and_worse_behind_long_ones() -> None:
    robot = painter()
    c = np.repeat((np.array(robot.home) * robot.unit)[None], 5, 0)
    c[1:, 0] += [1.0, 0.0, 0.5, 0.5]
    run = Run(robot, np.arange(5.0), c, True)
    setting = Setting(robot, [run], {**LOG, "show": "poses"})
    for seed in range(20):
        cause = gears.early_reading(setting, np.random.default_rng(seed), 1.0)
        if "A1" in cause.axes:
            break
    added = (cause.drive or cause.link)(run)[:, 0]
    assert added[1] == pytest.approx(-added[2]) and added[1] < 0 and added[4] == 0
    assert abs(added[3]) <= 0.5 * abs(added[1]) + 1e-15


def test_a_foot_leans_by_its_load_and_not_about_the_vertical() -> None:
    robot = painter()
    run = Run(robot, *moves.postures(robot, np.random.default_rng(1), 30), True)
    cause = structure.lean(_setting(run), np.random.default_rng(5), 1.0)
    tilt = cause.between(run)[robot.root]
    assert np.all(tilt[:, [0, 1, 2, 5]] == 0)
    moment = run.moments[:, 0, :2]
    soft = np.array(cause.params["rad_Nm"])
    stated = np.linalg.norm(moment, axis=1)
    size = np.linalg.norm(tilt[:, 3:5], axis=1)
    assert np.all(size >= soft.min() * stated - 1e-15) and np.all(size <= 2 * soft.max() * stated + 1e-15)


@pytest.mark.parametrize("cell", CELLS)
def test_every_cause_that_a_cell_has_moves_the_tool_or_the_encoders_where_it_says(cell) -> None:
    """On a path on which all axes move: a size above nothing, finite, in the stage that the cause names."""
    robot, rng = CELLS[cell][0](), np.random.default_rng(11)
    t, c = moves.fourier(robot, rng, 20.0, 0.02)
    log = {**LOG, "frame": "base" if robot.table else "world"}
    run = Run(robot, t, c, begins=2000.0)  # behind the first jumps of a tracker
    run.table = np.linspace(0, 2, len(t)) if robot.table else None
    run.force = cuts(run, rng)
    setting, have = Setting(robot, [plumbing._in_frame(run, log)], log), flags(robot, log, [run])
    one = design.Design(run, log, 60)
    for description in [*FAMILY.known, *FAMILY.foreign]:
        if not description.needs <= have:
            continue
        try:
            cause = description.make(setting, np.random.default_rng(3), 3.0)
        except ValueError:  # no axis that carries weight
            assert cell == "scara"
            continue
        drive, body = np.split(design.pattern(one, [cause]), 2)
        there, elsewhere = (drive, body) if cause.stage == "setpoint_to_encoder" else (body, drive)
        assert np.isfinite(there).all() and np.abs(elsewhere).max() < 1e-5 + 0.02 * np.abs(there).max(), cause.name
        assert np.abs(there).max() > 1e-5 or (cell == "scara" and cause.name == "payload"), cause.name


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("seed", [1, 9])
def test_a_case_is_the_same_from_the_same_seed_and_its_label_is_not_beside_it(seed, tmp_path) -> None:
    first, again = (case(FAMILY, seed, tmp_path / name) for name in ("a", "b"))
    assert json.dumps(first) == json.dumps(again)
    assert (tmp_path / "a" / "withheld.csv").read_bytes() == (tmp_path / "b" / "withheld.csv").read_bytes()
    assert not list((tmp_path / "a").rglob("*label*"))


def test_the_stated_size_is_what_a_log_shows(tmp_path) -> None:
    """Seed 111: single poses of the cobot, its base off, nothing else but noise: the log's gap is size and noise together."""
    label = case(FAMILY, 111, tmp_path)
    (cause,) = label["causes"]
    assert label["leftover_mm"] == 0 and label["log"]["frame"] == "world"
    robot = CELLS[label["robot"]][0]()
    table = np.genfromtxt(tmp_path / "withheld.csv", delimiter=",", names=True)
    values = np.stack([table["c" + n] for n in robot.names], axis=1) * robot.unit
    off = np.stack([table[k] for k in "xyz"], axis=1) - robot.pose(values)[:, :3, 3] * 1e3
    far = np.linalg.norm(off, axis=1)
    shown = np.sqrt((far[far < 0.4] ** 2).mean())  # a gross row is off by 0.6 mm and more
    assert cause["size_mm"] > 2 * label["noise_mm"]
    assert shown == pytest.approx(np.hypot(cause["size_mm"], label["noise_mm"]), rel=0.1)


def test_every_cell_is_read_with_its_own_poses(tmp_path) -> None:
    import camrob

    for make, _ in CELLS.values():
        robot = make()
        if robot.copied:
            continue
        robot.write(tmp_path / robot.name)
        assert [j for j in camrob.read_cell(tmp_path / robot.name).axis_names if j.startswith("A")] == [
            robot.names[i] for i in robot.arm
        ]
