"""A run of a robot: set-points on a fine clock, what causes add stage by stage, and what the tool does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

DRIVE, BODY = "setpoint_to_encoder", "encoder_to_tcp"


@dataclass
class Run:
    """Set-points `c` (SI, controller's sign) at `t`; `rest`: single poses, whose last moves are `came`."""

    robot: object
    t: np.ndarray
    c: np.ndarray
    rest: bool = False
    table: np.ndarray | None = None
    force: np.ndarray | None = None
    temp: np.ndarray | None = None
    begins: float = 0.0

    @cached_property
    def dt(self):
        """The clock's step."""
        return float(self.t[1] - self.t[0])

    @cached_property
    def v(self):
        """Axis speeds; none at rest."""
        return np.zeros_like(self.c) if self.rest else np.gradient(self.c, self.dt, axis=0)

    @cached_property
    def a(self):
        """Axis accelerations."""
        return np.zeros_like(self.c) if self.rest else np.gradient(self.v, self.dt, axis=0)

    @cached_property
    def came(self):
        """The last move before each row."""
        return np.vstack([self.c[1] - self.c[0], np.diff(self.c, axis=0)])

    @cached_property
    def tip(self):
        """The nominal tool."""
        return self.robot.pose(self.c)

    @cached_property
    def bones(self):
        """Nominal frames of axes and ends of rows."""
        return self.robot.frames(self.c)[:2]

    @cached_property
    def jacobian(self):
        """Of position and of rotation."""
        return self.robot.jacobian(self.c)

    @cached_property
    def moments(self):
        """Gravity on the axes."""
        return self.robot.moments(self.c)

    @cached_property
    def load(self):
        """Gravity's torque on each axis in the controller's sign (N, n)."""
        return self.moments[:, :, 2] * self.robot.signs

    @cached_property
    def clock(self):
        """Seconds since the machine was switched on, which earlier runs used up."""
        return self.t + self.begins

    def thin(self, most):
        """Rows for patterns: at most so many, evenly."""
        return np.unique(np.linspace(0, len(self.t) - 1, min(most, len(self.t))).astype(int))


Hook = Callable[[Run], np.ndarray]


@dataclass
class Cause:
    """One cause: what it adds to the set-points (`drive`), to the links (`link`), between frames, and to what is measured."""

    name: str
    stage: str
    axes: list[str] = field(default_factory=list)
    params: dict = field(default_factory=dict)
    follows: list[str] = field(default_factory=list)
    drive: Hook | None = None
    link: Hook | None = None
    between: Callable[[Run], dict] | None = None
    measured: Callable[[Run, np.ndarray], np.ndarray] | None = None
    late: Hook | None = None
    on_table: Callable[[Run, np.ndarray], np.ndarray] | None = None


def played(run, causes, rows=None):
    """What happens: encoders (N, n), and the tool as the instrument sees it (N, 4, 4) in the measured frame, at `rows`."""
    rows = np.arange(len(run.t)) if rows is None else rows
    encoders = run.c + sum((k.drive(run) for k in causes if k.drive), np.zeros_like(run.c))
    links = encoders + sum((k.link(run) for k in causes if k.link), np.zeros_like(run.c))
    between = {}
    for cause in causes:
        for where, twist in (cause.between(run) if cause.between else {}).items():
            between[where] = between.get(where, 0.0) + np.broadcast_to(twist, (len(run.t), 6))
    delay = sum((k.late(run) for k in causes if k.late), np.zeros(len(run.t)))
    if np.any(delay):
        when = run.t - delay
        links = np.stack([np.interp(when, run.t, links[:, i]) for i in range(links.shape[1])], axis=1)
    tool = run.robot.pose(links[rows], {k: w[rows] for k, w in between.items()})
    if run.table is not None:
        tool = on_table(run, tool, rows)
        for cause in causes:
            if cause.on_table:
                tool = (
                    cause.on_table(run, tool)[rows]
                    if len(tool) == len(run.t)
                    else cause.on_table(_part(run, rows), tool)
                )
    for cause in causes:
        if cause.measured:
            tool = cause.measured(_part(run, rows), tool)
    return encoders[rows], tool


def _part(run, rows):
    """The same run at some rows, for hooks that look at a row alone."""
    if len(rows) == len(run.t):
        return run
    part = Run(run.robot, run.t[rows], run.c[rows], run.rest, begins=run.begins)
    part.table = None if run.table is None else run.table[rows]
    part.temp = None if run.temp is None else run.temp[rows]
    part.force = None if run.force is None else run.force[rows]
    return part


def on_table(run, tool, rows):
    """The tool seen from the turning table, whose positive angle turns about -z of world."""
    out = np.zeros_like(tool)
    out[:, :3, :3] = Rotation.from_rotvec(np.outer(run.table[rows], [0, 0, 1.0])).as_matrix()
    out[:, 3, 3] = 1.0
    return out @ tool


def gap(run, causes, rows):
    """The gap by stage, mm (R, 3): of set-points to encoders through the nominal chain, and of encoders to the measured tool."""
    encoders, tool = played(run, causes, rows)
    table = run.table is not None
    seen, zero = run.robot.pose(encoders), run.robot.pose(run.c[rows])
    if table:
        seen, zero = on_table(run, seen, rows), on_table(run, zero, rows)
    return (seen[:, :3, 3] - zero[:, :3, 3]) * 1e3, (tool[:, :3, 3] - seen[:, :3, 3]) * 1e3
