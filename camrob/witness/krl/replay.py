"""What the robot does with a program's motions: tip, axis, circles, axis values, and what stands against them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from camrob.witness.arm import Pose, wrapped
from camrob.witness.follow import ELBOW_DEG, FOOT, WRIST_DEG, Finding, Leg, follow, foot_T_wrist
from camrob.witness.frames import angle_of, euler, frame, rotations_about
from camrob.witness.happenings import Gap, Load, Objection, Path, Run
from camrob.witness.krl.columns import AXES, CIRC, LIN, POSE, Motions
from camrob.witness.krl.state import State
from camrob.witness.units import deg_to_rad, m_to_mm, mm_to_m

__all__ = ["replay"]

Array = NDArray[np.float64]

_CHUNK = 50_000  # motions worked out at once: bounds the memory
_NEAR_ZERO = 1e-3  # degrees about 0 within which rounding alone decides an axis's sign
_PRINTED = 1e-4  # degrees or mm: what axis values that stand in the text may be past a limit, for their rounding
_QUARTERED = (0, 3, 5)  # the axes whose quarter turns a configuration names: cf1, cf4, cf6
_QUARTER = 90.0  # degrees
_STRETCHES = 20  # objections of one kind about one axis; the rest are counted in one more
_SAME_TURN = deg_to_rad(0.01)
_TEXTS = {
    "unreachable": "the arm can't reach the pose",
    "axis-jump": "{axis} would have to jump by {value:.1f} degrees on a step too small for it",
    "singular-wrist": f"A5 is stretched to within {WRIST_DEG} degrees: A4 and A6 turn about one line",
    "singular-elbow": f"the arm is stretched to within {ELBOW_DEG} degrees",
    "singular-foot": f"the wrist is above the arm's foot, within {m_to_mm(FOOT)} mm of axis 1",
    "limit": "{axis} would go to {value:.3f}, past its limit of {limit:g}",
}


@dataclass(slots=True)
class _Replay:
    """The walk through the motions; outputs by row."""

    state: State
    motions: Motions
    bases: list[Array] = field(init=False)
    tools: list[Array] = field(init=False)
    tip: Array = field(init=False)
    axis: Array = field(init=False)
    center: Array = field(init=False)
    normal: Array = field(init=False)
    angle: Array = field(init=False)
    axes: Array = field(init=False)
    bent: NDArray[np.bool_] = field(init=False)  # a LIN or CIRC that is no line or circle in base
    now: Array = field(init=False)  # axis values where the robot stands
    begun: bool = False
    blind: bool = False  # a PTP before leads to where the text doesn't say, which is a gap
    findings: list[Finding] = field(default_factory=list)
    notes: list[Objection] = field(default_factory=list)

    def __post_init__(self) -> None:
        count, state = len(self.motions), self.state
        nowhere = np.full((4, 4), np.nan)
        origin = state.machine.base_T_controller
        self.bases = [nowhere if base.values is None else origin @ frame(np.array(base.values)) for base in state.bases]
        self.tools = [nowhere if values is None else frame(np.array(values)) for values in state.tools]
        self.tip, self.axis, self.center, self.normal = (np.full((count, 3), np.nan) for _ in range(4))
        self.angle, self.axes = np.full(count, np.nan), self.motions.axes
        self.bent, self.now = np.zeros(count, dtype=bool), state.machine.home

    def walk(self) -> None:
        """All motions: PTP one by one, the LIN and CIRC between them a leg at a time."""
        motions = self.motions
        path = motions.how >= LIN
        changes = np.flatnonzero(~path[1:] | ~path[:-1] | (np.diff(motions.tool) != 0)) + 1
        for first, last in zip([0, *changes], [*changes, len(motions)], strict=True):
            if not path[first]:
                (self.by_axes if motions.how[first] == AXES else self.by_pose)(int(first))
                continue
            if not self.begun:
                before = "no PTP before it leads to a place that is known" if first else "the first motion is not a PTP"
                text = f"{before}: where it begins, and in which posture, isn't known"
                self.notes += [] if self.blind else [self.objection(int(first), "start-unknown", text)]
                self.by_pose(int(first))
                first += 1
            for low in range(int(first), int(last), _CHUNK):
                self.leg(low, min(low + _CHUNK, int(last)))

    def objection(self, row: int, code: str, text: str, severity: str = "error", **more: object) -> Objection:
        line, file = int(self.motions.line[row]), int(self.motions.file[row])
        return Objection(code, text, line=line, file=file, severity=severity, **more)  # type: ignore[arg-type]

    def by_axes(self, row: int) -> None:
        """A PTP by axes: an axis that is left out keeps its value."""
        given = self.motions.axes[row]
        if np.isnan(given).any() and not self.begun:
            text = "axes that this motion leaves out have no value yet: HOME's are taken"
            self.notes.append(self.objection(row, "start-unknown", text))
        self.now = np.where(np.isnan(given), self.now, given)
        self.axes[row], self.begun = self.now, True
        self.check_limits(row, _PRINTED)

    def check_limits(self, row: int, slack: float) -> None:
        machine = self.state.machine
        for k, (low, high) in enumerate(zip(machine.low, machine.high, strict=True)):
            value = self.now[k]
            if value < low - slack or value > high + slack:
                limit = low if value < low else high
                self.findings.append(Finding("limit", np.array([row]), k, np.array([value]), float(limit)))

    def targets(self, rows: slice) -> tuple[Pose, NDArray[np.bool_]]:
        """The tool in base at the ends of poses, and which of them stand still in the world instead."""
        motions, machine = self.motions, self.state.machine
        pose, base = motions.pose[rows], motions.base[rows]
        turn, place = euler(pose[:, 3:]), mm_to_m(pose[:, :3])
        table = any(joint.role == "workpiece" for joint in machine.joints)
        fixed = np.zeros(len(base), dtype=bool)
        for k in np.unique(base):
            at = np.flatnonzero(base == k) if len(np.unique(base)) > 1 else slice(None)
            base_T_krl = self.bases[k]
            if not np.array_equal(base_T_krl, np.eye(4)):
                turn[at] = base_T_krl[:3, :3] @ turn[at]
                place[at] = place[at] @ base_T_krl[:3, :3].T + base_T_krl[:3, 3]
            if table and not self.state.bases[k].follows:
                base_T_world = machine.base_T_world(motions.axes[rows][at])
                turn[at] = base_T_world[:, :3, :3] @ turn[at]
                place[at] = (base_T_world[:, :3, :3] @ place[at][..., None])[..., 0] + base_T_world[:, :3, 3]
                fixed[at] = True
        return (turn, place), fixed

    def by_pose(self, row: int) -> None:
        """A PTP by pose: Status picks the branch, Turn the turns."""
        motions, machine = self.motions, self.state.machine
        (turn, place), _ = self.targets(slice(row, row + 1))
        self.tip[row], self.axis[row] = place[0], turn[0, :, 2]
        external = motions.axes[row, 6:]
        flange_T_tip = self.tools[motions.tool[row]]
        if not np.isfinite(place).all() or not np.isfinite(flange_T_tip).all():
            self.axes[row], self.blind = np.nan, True
            return
        wanted = foot_T_wrist(machine, (turn, place), motions.axes[row : row + 1], flange_T_tip)
        found = machine.arm.all_postures(wanted, machine.arm.theta(self.now[None, :6])[0])
        if not found:
            self.axes[row] = np.nan
            self.findings.append(Finding("unreachable", np.array([row])))
            return
        self.now = np.concatenate([self.pick(row, machine.arm.axes(np.array(found))), external])
        self.axes[row], self.begun = self.now, True
        self.check_limits(row, _NEAR_ZERO)

    def pick(self, row: int, postures: Array) -> Array:
        """The posture (6,) that Status and Turn name among those found (K, 6); the nearest where they are left out or wrong."""
        motions, arm = self.motions, self.state.machine.arm
        status, turn = int(motions.status[row]), int(motions.turn[row])
        is_ptp = motions.how[row] == POSE
        if is_ptp and (status < 0 or turn < 0):
            text = "Status or Turn is left out: the controller takes the shortest way, and so the nearest posture is judged"
            self.notes.append(self.objection(row, "no-status-turn", text, "warning"))
        low, high = self.state.machine.low[:6, None], self.state.machine.high[:6, None]
        options = wrapped(postures)[..., None] + 360.0 * np.arange(-4, 5)  # (K, 6, 9): each axis on each of its turns
        inside = (options >= low - _NEAR_ZERO) & (options <= high + _NEAR_ZERO)
        signed = _turned(turn, options, self.state.quarters)
        fits = inside & signed if is_ptp and turn >= 0 else inside
        usable = np.where(fits.any(axis=2, keepdims=True), fits, inside | ~inside.any(axis=2, keepdims=True))
        away = np.where(usable, np.abs(options - self.now[:6, None]), np.inf)
        found = np.take_along_axis(options, away.argmin(axis=2)[..., None], axis=2)[..., 0]
        others = (arm.status(found) ^ status) & 7 if is_ptp and status >= 0 else np.zeros(len(found), dtype=np.int64)
        misses, outsides = (~fits.any(axis=2)).sum(axis=1), (~inside.any(axis=2)).sum(axis=1)
        best = np.lexsort((away.min(axis=2).max(axis=1), misses, outsides, others != 0))[0]
        axes, other, wrong, outside = found[best], others[best] != 0, misses[best] > 0, outsides[best] > 0
        if other or (wrong and not outside):
            own = int(arm.status(axes[None])[0])
            if self.state.quarters:
                told = ", ".join(f"{q:.0f}" for q in _quarters(turn))
                fit = ", ".join(f"{q:.0f}" for q in np.floor(axes[list(_QUARTERED)] / _QUARTER))
                text = f"configuration {told} in branch {status} is of no posture of this pose; {fit} in branch {own} would be"
            else:
                fit = f"S {own}, T {int(arm.turn(axes[None])[0])}"
                text = f"S {status}, T {turn} name no posture of this pose within the limits; {fit} would"
            self.notes.append(self.objection(row, "status-turn", text))
        return np.asarray(axes)

    def start(self, row: int) -> tuple[Array, Array]:
        """The tool in base where motion `row` begins."""
        base_T_tip = self.state.machine.base_T_flange(self.now[None])[0] @ self.tools[self.motions.tool[row]]
        return base_T_tip[:3, :3], base_T_tip[:3, 3]

    def leg(self, low: int, high: int) -> None:
        """LIN and CIRC low to high - 1: ends, circles, axis values."""
        motions, rows = self.motions, slice(low, high)
        (turn, place), fixed = self.targets(rows)
        turn0, place0 = self.start(low)
        if motions.constant[rows].any():
            kept = np.maximum.accumulate(np.where(motions.constant[rows], -1, np.arange(high - low)))
            turn = np.where((kept < 0)[:, None, None], turn0, turn[np.maximum(kept, 0)])
        external = np.concatenate([self.now[None, 6:], motions.axes[rows, 6:]])
        tables = [k for k, joint in enumerate(self.state.machine.in_order[6:]) if joint.role == "workpiece"]
        self.bent[rows] = fixed & (np.diff(external[:, tables], axis=0) != 0.0).any(axis=1)
        place, turn = np.concatenate([place0[None], place]), np.concatenate([turn0[None], turn])
        if (motions.how[rows] == CIRC).any():
            self.circles(rows, place, turn)
        self.tip[rows], self.axis[rows] = place[1:], turn[1:, :, 2]
        leg = Leg(
            turn=turn,
            place=place,
            external=external,
            center=self.center[rows],
            normal=self.normal[rows],
            angle=self.angle[rows],
            fixed=self.bent[rows],
            flange_T_tip=self.tools[motions.tool[low]],
        )
        self.axes[rows], findings = follow(self.state.machine, leg, self.now)
        for finding in findings:
            finding.rows = finding.rows + low
        self.findings += findings
        reached = np.flatnonzero(np.isfinite(self.axes[rows, 0]))
        if len(reached):
            self.now = self.axes[low + reached[-1]].copy()

    def circles(self, rows: slice, place: Array, turn: Array) -> None:
        """Centre, normal and angle of each CIRC; with CA, its end moves along the circle, so these go one after another."""
        motions, low = self.motions, rows.start
        at = np.flatnonzero(motions.how[rows] == CIRC)
        middle = motions.pose[rows].copy()
        kept, motions.pose[low + at, :3] = motions.pose[low + at, :3].copy(), motions.middle[low + at]
        middle = self.targets(rows)[0][1]
        motions.pose[low + at, :3] = kept
        for i in at:
            row, sweep = low + int(i), float(motions.sweep[low + i])
            u, v = middle[i] - place[i], place[i + 1] - place[i]
            across = np.cross(u, v)
            area, size = float(across @ across), max(float(u @ u), float(v @ v))
            if self.bent[row] or not np.isfinite(area):
                continue
            if area <= 1e-12 * size * size or size == 0.0:
                text = "start, auxiliary point and end of the circle lie on one line, or two of them are the same"
                self.notes.append(self.objection(row, "circle", text))
                continue
            center = place[i] + np.cross((u @ u) * v - (v @ v) * u, across) / (2.0 * area)
            normal = across / np.sqrt(area)
            begin, end = place[i] - center, place[i + 1] - center
            angle = float(np.arctan2(normal @ np.cross(begin, end), begin @ end)) % (2.0 * np.pi)
            if not np.isnan(sweep):
                normal, angle = (normal if sweep >= 0.0 else -normal), abs(deg_to_rad(sweep))
                place[i + 1] = center + rotations_about((angle * normal)[None])[0] @ begin
                if float(angle_of((turn[i].T @ turn[i + 1])[None])[0]) > _SAME_TURN:
                    why = "CIRC with CA: how the tool stands where it ends isn't judged"
                    line = int(motions.line[row])
                    self.state.gaps.append(Gap(row, line, line, why, int(motions.file[row])))
            self.center[row], self.normal[row], self.angle[row] = center, normal, angle

    def finish(self) -> None:
        """Tip and axis of PTP by axes, by forward kinematics."""
        motions = self.motions
        at = np.flatnonzero(motions.how == AXES)
        for low in range(0, len(at), _CHUNK):
            rows = at[low : low + _CHUNK]
            base_T_tip = self.state.machine.base_T_flange(self.axes[rows]) @ np.array(self.tools)[motions.tool[rows]]
            self.tip[rows], self.axis[rows] = base_T_tip[:, :3, 3], base_T_tip[:, :3, 2]

    def objections(self) -> list[Objection]:
        """Everything found, motions in a row in one objection each."""
        out, counts = list(self.notes), dict[tuple[str, int, float], int]()
        names = self.state.machine.axis_names
        for finding in self.findings:
            axis = names[finding.axis] if finding.axis >= 0 else ""
            key = (finding.code, finding.axis, finding.limit)
            for run in np.split(np.arange(len(finding.rows)), np.flatnonzero(np.diff(finding.rows) > 1) + 1):
                counts[key] = counts.get(key, 0) + 1
                if counts[key] > _STRETCHES:
                    continue
                row = int(finding.rows[run[0]])
                worst, limit, unit = None, None, ""
                if finding.code in ("limit", "axis-jump"):
                    values = finding.values[run]
                    worst, limit = float(values[np.argmax(np.abs(values - finding.limit))]), finding.limit
                    unit = "deg" if self.state.machine.in_order[finding.axis].turning else "mm"
                text = _TEXTS[finding.code].format(axis=axis, value=worst or 0.0, limit=limit or 0.0)
                if len(run) > 1:
                    text += f"; {len(run)} motions, to line {int(self.motions.line[finding.rows[run[-1]]])}"
                code = finding.code.split("-")[0] if finding.code.startswith("singular") else finding.code
                out.append(self.objection(row, code, text, axis=axis, value=worst, limit=limit, unit=unit))
        for (code, axis_index, _), number in counts.items():
            if number > _STRETCHES:
                axis = names[axis_index] if axis_index >= 0 else ""
                text = f"{code} {axis}".strip() + f": {number - _STRETCHES} stretches more like those reported"
                out.append(Objection(code.split("-")[0] if code.startswith("singular") else code, text, axis=axis))
        return out


def _quarters(turn: int) -> Array:
    """The quarters (3,) that a packed configuration names."""
    return np.array([turn >> 8 & 15, turn >> 4 & 15, turn & 15], dtype=float) - 8.0  # as `State.quarters` says


def _turned(turn: int, options: Array, quarters: bool) -> NDArray[np.bool_]:
    """Which of the axis values (K, 6, n) are on the turn that a motion names: by sign, or by quarters of axes 1, 4 and 6."""
    if not quarters:
        below = (turn >> np.arange(6)[:, None] & 1) == 1
        return np.asarray(np.where(below, options < _NEAR_ZERO, options >= -_NEAR_ZERO))
    out = np.ones(options.shape, dtype=bool)
    for axis, quarter in zip(_QUARTERED, _quarters(turn), strict=True):
        past = options[:, axis] - _QUARTER * quarter
        out[:, axis] = (past >= -_NEAR_ZERO) & (past <= _QUARTER + _NEAR_ZERO)
    return out


def _unsettled_loads(loads: tuple[Load, ...]) -> list[Gap]:
    """What isn't judged without a set-up that states the tools' masses."""
    text = "whether the tool weighs what the program's load says isn't judged without a set-up that states its mass"
    return [Gap(e.before, e.line, e.line, text, e.file, of_load=True) for e in loads if e.values is not None]


def replay(state: State, motions: Motions) -> Run:
    """The run that a program's motions make."""
    walk = _Replay(state, motions)
    if len(motions):
        walk.walk()
        walk.finish()
    loads = tuple({load.before: load for load in state.loads if load.before < len(motions)}.values())
    objections = sorted([*state.objections, *walk.objections()], key=lambda item: (item.file, item.line))
    return Run(
        path=Path(walk.tip, walk.axis, walk.center, walk.normal, walk.angle, motions.line),
        ptp=(motions.how < LIN) | walk.bent,
        speed=motions.speed,
        exact=motions.exact,
        tool=motions.tool,
        tools=tuple(walk.tools),
        axes=walk.axes,
        axis_names=state.machine.axis_names,
        file=motions.file,
        files=tuple(state.files),
        events=tuple(state.events),
        gaps=tuple(sorted(state.gaps, key=lambda gap: gap.before)),
        objections=tuple(objections),
        conduct=tuple(state.ruled),
        unsettled=(*state.unsettled, *_unsettled_loads(loads)),
        loads=loads,
    )
