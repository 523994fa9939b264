"""What the statements of a program do to the arm and the tip: each motion sampled, in `base` and in the axes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mutation import arm
from mutation.krl import Statement, UnreadableError, aggregate

Array = NDArray[np.float64]

STEP_MM, STEP_DEG, MOST = 12.0, 6.0, 60
JUMP = 60.0  # degrees of an axis between two samples: the arm turns over
NEAR_SINGULAR = 0.5  # degrees of A5
SLACK = 2e-3  # degrees, mm beyond a limit that rounding may cause


@dataclass(frozen=True)
class Machine:
    """The cell of a job as the judge knows it. lines: statements of the opening, `$BASE` and `$TOOL` left out.

    base: the text of `$BASE` with {frame} in it. externals: names of the external axes in E6POS. follows: `$BASE` turns
    with the table. lower, upper: (8,) limits. shop: whose customs its programs have.
    """

    lines: tuple[str, ...]
    base: str
    follows: bool = True
    externals: tuple[str, ...] = ("E1", "E2")
    lower: Array = field(default_factory=lambda: arm.LOWER)
    upper: Array = field(default_factory=lambda: arm.UPPER)
    shop: str = ""


@dataclass(frozen=True)
class Move:
    """A motion: base_T_tip (S, 4, 4) and axes (S, 8) at samples from its start to its end."""

    at: Statement
    base_T_tip: Array
    axes: Array
    tool: int

    @property
    def ptp(self) -> bool:
        return self.at.kind.startswith("ptp")

    @property
    def still(self) -> bool:
        """The tip stays where it is."""
        tip = self.base_T_tip
        flat = np.ptp(tip[:, :3, 3], axis=0).max() <= 2e-3
        return bool(flat and np.min(tip[:, :3, 2] @ tip[0, :3, 2]) > np.cos(np.radians(0.005)))


def slerp(a: Array, b: Array, shares: Array) -> Array:
    """Rotations (S, 3, 3) from a to b."""
    turn = a.T @ b
    angle = float(np.arccos(np.clip((np.trace(turn) - 1.0) / 2.0, -1.0, 1.0)))
    if angle < 1e-12:
        return np.broadcast_to(a, (len(shares), 3, 3)).copy()
    w = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    size = float(np.linalg.norm(w))
    if size < 1e-9:  # a half turn: any axis of it
        values, vectors = np.linalg.eigh(turn)
        w = vectors[:, int(np.argmax(values))]
        size = 1.0
    k = w / size
    cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    out = [a @ (np.eye(3) + np.sin(s * angle) * cross + (1 - np.cos(s * angle)) * cross @ cross) for s in shares]
    return np.array(out)


class Replay:
    """Runs motions one after the other; `faults` gathers what the arm can't do as (class, text)."""

    def __init__(self, machine: Machine, tools: Mapping[int, Sequence[float]], tool: int) -> None:
        self.machine = machine
        self.tools = tools
        self.tool = tool
        self.faults: list[tuple[str, str]] = []
        self.axes: Array | None = None
        self.turn_values: list[tuple[int, int]] = []

    @property
    def flange_T_tool(self) -> Array:
        return arm.frame(tuple(self.tools[self.tool]))

    def frame_set(self, at: Statement) -> None:
        """A `$BASE` or `$TOOL`: the set-up's, or a fault. `$TOOL` tells which tool serves from here."""
        name, _, value = at.text.partition(" = ")
        printed = aggregate(value)
        if name == "$BASE":
            if value != self.machine.base.replace("{frame}", value[value.index("{") : value.index("}") + 1]):
                self.faults.append(("$BASE", f"{at.text} at {at.place}"))
            elif np.abs(printed).max() > 1e-9:
                self.faults.append(("$BASE", f"{at.text} at {at.place}"))
            return
        near = 1e-4  # a tenth of a micrometre; as many degrees are less than that at any tool's tip
        off = [number for number, tool in self.tools.items() if np.abs(np.array(tool) - printed).max() < near]
        if not off:
            self.faults.append(("$TOOL", f"{at.text} at {at.place} is no tool of the set-up's"))
        elif self.tool not in off:
            self.tool = off[0]

    def move(self, at: Statement) -> Move:
        """The motion of a statement. Raises UnreadableError for one that can't be run."""
        if at.kind == "ptp-axes":
            end = np.array([self._field(at.target, n) for n in arm.NAMES])
        elif at.kind == "ptp":
            end = self._posed(at)
        else:
            return self._path(at)
        self._within(end, at)
        start = end if self.axes is None else self.axes
        count = int(np.clip(np.abs(end - start).max() / 4.0, 1, MOST)) + 1
        axes = start + np.linspace(0.0, 1.0, count)[:, None] * (end - start)
        self.axes = end
        return Move(at, self._tip(axes), axes, self.tool)

    def _field(self, target: Mapping[str, float], name: str) -> float:
        if name.startswith("E") and name not in self.machine.externals:
            if name in target:
                raise UnreadableError(f"{name} in a cell without it")
            return 0.0
        if name not in target:
            raise UnreadableError(f"{name} is missing in {dict(target)}")
        return target[name]

    def _tip(self, axes: Array) -> Array:
        return arm.base_T_flange(axes) @ self.flange_T_tool

    def _target(self, target: Mapping[str, float], status: bool) -> tuple[Array, float, float]:
        """base_T_tip as printed, and E1, E2."""
        fields = {*"XYZABC", *self.machine.externals, *(("S", "T") if status else ())}
        if set(target) != fields:
            raise UnreadableError(f"fields {sorted(target)} in an E6POS")
        printed = arm.frame(tuple(target[n] for n in "XYZABC"))
        return printed, self._field(target, "E1"), self._field(target, "E2")

    def _from_printed(self, printed: Array, e2: Array) -> Array:
        """Poses (S, 4, 4) as `$BASE` has them, in the table's own frame."""
        if self.machine.follows:
            return printed
        zero = np.zeros(len(e2))
        base_T_world = arm.base_T_root(zero, e2) @ arm.inverse(arm.base_T_root(zero, zero))
        return np.asarray(base_T_world @ printed)

    def _posed(self, at: Statement) -> Array:
        printed, e1, e2 = self._target(at.target, True)
        tip = self._from_printed(printed[None], np.array([e2]))
        root = arm.inverse(arm.base_T_root(np.array([e1]), np.array([e2]))) @ tip @ arm.inverse(self.flange_T_tool)
        status, turn = int(at.target["S"]), int(at.target["T"])
        self.turn_values.append((status, turn))
        found = arm.postures(root, status)[0]
        if not np.isfinite(found).all():
            raise UnreadableError(f"{at.place} is out of the arm's reach")
        if arm.status_of(found) != status & 7 or status > 7 or turn > 255:
            self.faults.append(("status-turn", f"S {status} names no posture at {at.place}"))
        axes = arm.on_turn(found, turn)
        if axes is None:
            self.faults.append(("status-turn", f"T {turn} names no turn within the limits at {at.place}"))
            axes = found
        return np.array([*axes, e1, e2])

    def _path(self, at: Statement) -> Move:
        if self.axes is None:
            raise UnreadableError(f"{at.place} is a path motion without a start")
        printed, e1, e2 = self._target(at.target, False)
        start = self._tip(self.axes[None])[0]
        if not self.machine.follows:
            start = arm.inverse(self._from_printed(np.eye(4)[None], self.axes[7:8]))[0] @ start
        length = float(np.linalg.norm(printed[:3, 3] - start[:3, 3])) + abs(e1 - self.axes[6])
        turned = float(np.degrees(np.arccos(np.clip((np.trace(start[:3, :3].T @ printed[:3, :3]) - 1) / 2, -1, 1))))
        count = int(np.clip(max(length / STEP_MM, turned / STEP_DEG, abs(e2 - self.axes[7]) / STEP_DEG), 2, MOST)) + 1
        shares = np.linspace(0.0, 1.0, count)
        poses = np.broadcast_to(np.eye(4), (count, 4, 4)).copy()
        poses[:, :3, :3] = slerp(start[:3, :3], printed[:3, :3], shares)
        if at.kind == "lin":
            poses[:, :3, 3] = start[:3, 3] + shares[:, None] * (printed[:3, 3] - start[:3, 3])
        else:
            via = self._target(at.via, False)[0][:3, 3]
            poses[:, :3, 3] = _circle(start[:3, 3], via, printed[:3, 3], shares)
        external = self.axes[6:8] + shares[:, None] * (np.array([e1, e2]) - self.axes[6:8])
        tips = self._from_printed(poses, external[:, 1])
        axes = self._followed(tips, external, at)
        self.axes = axes[-1]
        return Move(at, tips, axes, self.tool)

    def _followed(self, tips: Array, external: Array, at: Statement) -> Array:
        """Axes (S, 8) along a path: the arm that the start stands in, each axis on the turn that goes on."""
        if self.axes is None:
            raise UnreadableError("no start")
        roots = arm.inverse(arm.base_T_root(external[:, 0], external[:, 1])) @ tips @ arm.inverse(self.flange_T_tool)
        found = arm.postures(roots, arm.status_of(self.axes[:6]))
        if not np.isfinite(found).all():
            raise UnreadableError(f"{at.place} leads out of the arm's reach")
        here = self.axes[:6]
        for k in range(len(found)):
            found[k] += 360.0 * np.round((here - found[k]) / 360.0)
            if np.abs(found[k] - here).max() > JUMP:
                self.faults.append(("singular", f"an axis turns over on the way to {at.place}"))
            here = found[k]
        axes = np.concatenate([found, external], axis=1)
        if np.abs(axes[:, 4]).min() < NEAR_SINGULAR:
            self.faults.append(("singular", f"A5 passes zero on the way to {at.place}"))
        self._within(axes, at)
        return axes

    def _within(self, axes: Array, at: Statement) -> None:
        over = np.maximum(self.machine.lower - axes, axes - self.machine.upper)
        over = np.atleast_2d(over).max(axis=0)
        for k in np.flatnonzero(over > SLACK):
            self.faults.append(("limit", f"{arm.NAMES[k]} is {over[k]:.3f} beyond its limit at {at.place}"))


def _circle(start: Array, via: Array, end: Array, shares: Array) -> Array:
    """Points (S, 3) of the circle from start through via to end."""
    a, b = via - start, end - start
    n = np.cross(a, b)
    if float(n @ n) < 1e-9:
        raise UnreadableError("a CIRC through three points in line")
    center = start + (np.cross(n, a) * (b @ b) + np.cross(b, n) * (a @ a)) / (2.0 * float(n @ n))
    n = n / np.linalg.norm(n)
    u = start - center
    v = np.cross(n, u)
    reach = end - center
    angle = float(np.arctan2(reach @ v, reach @ u))
    if angle <= 0.0:
        angle += 2.0 * np.pi
    return np.asarray(center + np.cos(shares * angle)[:, None] * u + np.sin(shares * angle)[:, None] * v)
