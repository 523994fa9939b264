"""Motions that a next experiment may consist of: what was run, changed in one respect."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.cell.load import PointMass
from camrob.errors import LogError
from camrob.frozen import locked
from camrob.gap.observation.scene import Scene, make_scene
from camrob.kinematics.arm import FOLLOWED, Arm
from camrob.kinematics.frames import base_T_tool
from camrob.measurement.log import FORCE, MeasurementLog
from camrob.measurement.log_info import MeasuredFrame, Target
from camrob.units import deg_to_rad, m_to_mm, rad_to_deg

__all__ = ["TrialMotion", "single_axis", "standing_still", "trial_motions"]

Array = NDArray[np.float64]

_MOST = 600  # samples that a motion is judged with
_SLOWER = 2.0
_HOUR = 3600.0  # s
_WARMER = 12.0  # kelvin
_LOAD = 5.0  # kg
_JUMP = 0.35  # rad between samples
_SHIFTS = (0.5, -0.5, 0.3, -0.3, 0.15, -0.15)  # m of the track
_TURNS = tuple(deg_to_rad(a) for a in (90.0, -90.0, 45.0, -45.0, 20.0, -20.0))
_SWEEP_SPEED = 0.2  # rad/s and, of a track, m/s tenfold less
_SWEEP_ROWS = 300


@dataclass(frozen=True)
class TrialMotion:
    """key: a short name; text: what to run, in words; advice: what a person has to do first, "" for nothing. q: (N, n)
    postures in their order, seconds: how long they take; scene: the motion, thinned, as if it had been measured. axis: the
    one that moves alone, "" for a path.
    """

    key: str
    text: str
    advice: str
    q: Array
    seconds: float
    scene: Scene
    axis: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "q", locked(self.q, shape=(None, None), name="q"))


def trial_motions(scene: Scene) -> tuple[TrialMotion, ...]:
    """What a log's own run can be changed into; first, to compare with, the same "again"."""
    step = max(1, -(-len(scene) // _MOST))
    thin = scene.log.select(np.arange(0, len(scene), step))
    cell, t = scene.cell, scene.t - scene.t[0]
    q = scene.postures(np.asarray(scene.command))
    found = []

    def add(
        key: str,
        text: str,
        advice: str,
        q: Array,
        t: Array,
        *,
        of: Cell = cell,
        warmer: float = 0.0,
        force: bool = True,
    ) -> None:
        try:
            made = make_scene(_log(thin, scene, of, q[::step], t[::step], warmer, force), of, fitted=True)
        except LogError:
            return  # too little of the run is left
        found.append(TrialMotion(key, text, advice, q, float(np.ptp(t)), made))

    add("again", "the same again", "", q, t)
    if not scene.poses:
        add("reversed", "the same program backwards", "", q[::-1].copy(), t[-1] - t[::-1])
        add("half speed", "the same program at half speed", "", q, t * _SLOWER)
    for key, text, moved in _elsewhere(cell, q):
        add(key, text, "move the part's clamping along, or run it in air", moved, t)
    mass = _heavier(cell)
    if mass is not None:
        same = "the same poses" if scene.poses else "the same program"
        what = f"with {_LOAD:g} kg more at the tool"
        add(
            "payload",
            f"{same} {what}",
            f"fasten {_LOAD:g} kg at the tool and tell the controller",
            q,
            t,
            of=mass,
        )
    if scene.force is not None:
        add("air", "the same program in air", "take the part away, spindle off", q, t, force=False)
    if not scene.poses:
        hot = "after an hour of warming up"
        add("warm", f"the same program {hot}", "run the arm for an hour first", q, t + _HOUR, warmer=_WARMER)
    return tuple(found)


def single_axis(scene: Scene, axis: str) -> TrialMotion:
    """One axis through the range that the run used, both ways, the others at rest in the run's middle."""
    cell, k = scene.cell, scene.index(axis)
    values = np.asarray(scene.command)
    low, high = float(values[:, k].min()), float(values[:, k].max())
    middle = values[int(np.argmin(np.abs(values[:, k] - 0.5 * (low + high))))]
    linear = cell.joints[cell.index(axis)].prismatic
    pace = _SWEEP_SPEED * (0.1 if linear else 1.0)
    half = np.linspace(low, high, _SWEEP_ROWS // 2)
    path = np.tile(middle, (_SWEEP_ROWS, 1))
    path[:, k] = np.concatenate([half, half[::-1]])
    q = scene.postures(path)
    t = np.concatenate([[0.0], np.cumsum(np.full(_SWEEP_ROWS - 1, (high - low) / (_SWEEP_ROWS // 2) / pace))])
    made = make_scene(_log(scene.log, scene, cell, q, t, 0.0, False, even=True), cell)
    text = f"{axis} alone through its range, both ways, the others at rest"
    return TrialMotion("one axis", text, "", q, float(t[-1]), made, axis)


def standing_still(scene: Scene) -> TrialMotion:
    """The arm at rest in the middle posture of a run, for as long as that took."""
    cell = scene.cell
    middle = np.asarray(scene.command)[len(scene) // 2]
    q = scene.postures(np.tile(middle, (_SWEEP_ROWS, 1)))
    t = np.linspace(0.0, float(np.ptp(scene.t)), _SWEEP_ROWS)
    text = f"the arm at rest in one posture for {t[-1]:.0f} s"
    return TrialMotion(
        "at rest", text, "", q, float(t[-1]), make_scene(_log(scene.log, scene, cell, q, t, 0.0, False), cell)
    )


def _log(
    thin: MeasurementLog,
    scene: Scene,
    cell: Cell,
    q: Array,
    t: Array,
    warmer: float,
    force: bool,
    *,
    even: bool = False,
) -> MeasurementLog:
    """A log of postures q (N, n) at times t (N,) on a cell without errors. even: at the one temperature of the run's middle."""
    count = len(q)
    columns = {"t": t, **{n: np.zeros(count) for n in ("x", "y", "z", "a", "b", "c")}}
    if not bool(scene.seen[:, 3:].any()):
        columns = {n: v for n, v in columns.items() if n not in "abc"}
    values = cell.to_axis_values(q)
    for k, axis in enumerate(cell.axis_names):
        if scene.encoder is not None:
            columns[axis] = values[:, k]
        if scene.setpoint is not None:
            columns[f"c{axis}"] = values[:, k]
    if scene.temperature is not None:
        kept = scene.temperature[np.linspace(0, len(scene) - 1, count).astype(int)]
        columns["temp"] = np.full(count, np.median(kept)) if even else kept + warmer
    if scene.force is not None:
        kept_force = scene.force[np.linspace(0, len(scene) - 1, count).astype(int)]
        for k, name in enumerate(FORCE):
            columns[name] = kept_force[:, k] if force else np.zeros(count)
    info = thin.info
    in_base = info.measured_frame is MeasuredFrame.BASE
    info = replace(
        info, measured_frame=MeasuredFrame.BASE if in_base else MeasuredFrame.WORLD, target=Target.TOOL, program=""
    )
    return MeasurementLog(columns, info, thin.path)


def _heavier(cell: Cell) -> Cell | None:
    """The cell with more at its tool; None where its masses are not known."""
    if not cell.masses:
        return None
    tool = cell.masses[-1]
    return replace(cell, masses=(*cell.masses, PointMass("trial", tool.after, _LOAD, tool.center)))


def _elsewhere(cell: Cell, q: Array) -> list[tuple[str, str, Array]]:
    """The same poses in `base` with the track, and with the table, somewhere else: the first of each that can be run."""
    out = []
    for role, steps, key in ((Role.CARRIAGE, _SHIFTS, "track"), (Role.WORKPIECE, _TURNS, "table")):
        joints = [i for i in cell.indices(role) if cell.joints[i].prismatic == (role is Role.CARRIAGE)]
        for i in joints[:1]:
            for step in steps:
                moved = _followed(cell, q, i, step)
                if moved is not None:
                    name = cell.joints[i].name
                    size = f"{m_to_mm(step):+.0f} mm" if role is Role.CARRIAGE else f"{rad_to_deg(step):+.0f} degrees"
                    out.append((key, f"the same part with the {key} elsewhere ({name} {size})", moved))
                    break
    return out


def _followed(cell: Cell, q: Array, joint: int, step: float) -> Array | None:
    """Postures with a joint moved and the tool as before; None where a limit, the reach or a flip forbids it."""
    moved = q.copy()
    moved[:, joint] += cell.joints[joint].sign * step
    if np.any(moved[:, joint] < cell.q_lower[joint]) or np.any(moved[:, joint] > cell.q_upper[joint]):
        return None
    part, arm = cell.arm_slice, Arm.of(cell)
    wanted = arm.foot_T_tool(base_T_tool(cell, q), moved)
    starts = arm.branches(wanted[0], q[0, part])
    if not starts:
        return None
    start = min(starts, key=lambda x: float(np.max(np.abs(x - q[0, part]))))
    followed, code, _ = arm.follow(wanted, start, step=_JUMP)
    if code != FOLLOWED:
        return None
    moved[:, part] = followed
    return moved
