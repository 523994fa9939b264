"""Which axis values take the tool along a path, and what stands against it on the way.

A path is a row of poses of the tool in `base`, joined by lines or circles; the external axes move evenly from each pose to the
next, the arm stays on the branch on which it begins, and every axis turns without a jump.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from camrob.witness.arm import Branch, Pose, wrapped
from camrob.witness.frames import inverse, rotation_vector, rotations_about
from camrob.witness.machine import Machine
from camrob.witness.units import deg_to_rad

__all__ = ["Finding", "Leg", "follow", "foot_T_wrist"]

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

# a motion is looked at between its ends from these on: so far apart A1..A6 may turn and turn back unseen by a degree or so
_LONG = 0.02  # m
_TURNED = deg_to_rad(5.0)
_EXTERNAL = 10.0  # degrees or mm of an external axis
_STEP = 10.0  # degrees of an axis from one place to the next; more is looked at more closely
_FINEST = 4096  # places on one motion; an axis that still steps by more than _STEP jumps
# nearer than this an arm is singular: KUKA's own bound for A5 is 0.01812 degrees; 0.2 degrees of the elbow are 2 micrometres of
# reach of an arm of this size; above the foot a tenth of a millimetre
WRIST_DEG, ELBOW_DEG, FOOT = 0.02, 0.2, 1e-4


@dataclass(slots=True)
class Leg:
    """M motions in a row with one tool. `turn` (M + 1, 3, 3), `place` (M + 1, 3): the tool in base, where it begins put first;
    `external` (M + 1, n - 6) likewise. center, normal (M, 3), angle (M,): circles, NaN of lines. `fixed` (M,): the line or circle
    stands still in the world, not in base.
    """

    turn: Array
    place: Array
    external: Array
    center: Array
    normal: Array
    angle: Array
    fixed: Flags
    flange_T_tip: Array


@dataclass(slots=True)
class Finding:
    """What stands against motions (rows of the leg): code, axis (-1: none) and the worst value of each row."""

    code: str
    rows: NDArray[np.int64]
    axis: int = -1
    values: Array = field(default_factory=lambda: np.empty(0))
    limit: float = float("nan")


def foot_T_wrist(machine: Machine, tool: Pose, axes: Array, flange_T_tip: Array) -> Pose:
    """What the arm's six rows have to reach (M): the tool in base, external axes (M, n), `$TOOL`."""
    base_T_foot = machine.carrier(axes)
    tip_T_wrist = inverse(flange_T_tip) @ inverse(machine.wrist_T_flange)
    turn, place = tool
    back = np.swapaxes(base_T_foot[0], 1, 2)
    reach = place + turn @ tip_T_wrist[:3, 3] - base_T_foot[1]
    return back @ (turn @ tip_T_wrist[:3, :3]), (back @ reach[..., None])[..., 0]


@dataclass(slots=True)
class _Postures:
    """Raw axis values (M, 6) of a row of poses, NaN where out of reach, and what is near singular."""

    axes: Array
    wrist: Flags
    elbow: Flags
    foot: Flags


def _solve(
    machine: Machine, tool: Pose, external: Array, flange_T_tip: Array, branch: Branch, near: Array
) -> _Postures:
    """The arm's axis values for a row of poses on one branch; of arms without a closed form from one pose to the next."""
    arm = machine.arm
    axes = np.concatenate([np.zeros((len(external), 6)), external], axis=1)
    wanted = foot_T_wrist(machine, tool, axes, flange_T_tip)
    if arm.spherical:
        theta, _, along = arm.solve(wanted, branch)
    else:
        theta, last = np.full((len(axes), 6), np.nan), arm.theta(near[None])[0]
        for i in np.flatnonzero(np.isfinite(wanted[1]).all(axis=1)):
            found = arm.newton((wanted[0][i : i + 1], wanted[1][i : i + 1]), last)
            if found is not None:
                theta[i] = last = found
        along = arm.bends(arm.axes(theta))[2]
    small_wrist, small_elbow = np.sin(deg_to_rad(WRIST_DEG)), np.sin(deg_to_rad(ELBOW_DEG))
    with np.errstate(invalid="ignore"):
        wrist = np.abs(np.sin(theta[:, 4])) < small_wrist
        elbow = np.abs(np.sin(theta[:, 2] + arm.lean)) < small_elbow
        return _Postures(arm.axes(theta), wrist, elbow, np.abs(along) < FOOT)


def _kept(axes: Array, first: Array) -> Array:
    """Axis values (M, 6) in which a pose out of reach keeps the values before it."""
    known = ~np.isnan(axes[:, 0])
    last = np.maximum.accumulate(np.where(known, np.arange(len(axes)), -1))
    return np.where((last < 0)[:, None], first, axes[np.maximum(last, 0)])


@dataclass(slots=True)
class _Between:
    """What the looks between the ends of some motions showed, (K, 6) or (K,)."""

    net: Array
    most: Array
    least: Array
    jump: Array
    lost: Flags
    wrist: Flags
    elbow: Flags
    foot: Flags


def _along(
    machine: Machine, leg: Leg, rows: NDArray[np.int64], which: NDArray[np.int64], share: Array
) -> tuple[Pose, Array]:
    """The tool in base and the external axes at shares (S,) of motions rows[which]."""
    motion = rows[which]
    start, end = leg.external[rows], leg.external[rows + 1]
    external = start[which] + share[:, None] * (end - start)[which]
    turn0, turn1, place0, place1 = leg.turn[rows], leg.turn[rows + 1], leg.place[rows], leg.place[rows + 1]
    center, normal = leg.center[rows], leg.normal[rows]
    fixed = leg.fixed[rows]
    if fixed.any():
        for turn, place, values in ((turn0, place0, start), (turn1, place1, end)):
            world_T_base = inverse(_world(machine, values[fixed]))
            turn[fixed] = world_T_base[:, :3, :3] @ turn[fixed]
            place[fixed] = (world_T_base[:, :3, :3] @ place[fixed][..., None])[..., 0] + world_T_base[:, :3, 3]
    vector = rotation_vector(np.swapaxes(turn0, 1, 2) @ turn1)
    turn = turn0[which] @ rotations_about(share[:, None] * vector[which])
    place = place0[which] + share[:, None] * (place1 - place0)[which]
    arc = np.isfinite(leg.angle[motion])
    if arc.any():
        swing = rotations_about((share * leg.angle[motion])[arc, None] * normal[which][arc])
        radius = (place0 - center)[which][arc]
        place[arc] = center[which][arc] + (swing @ radius[..., None])[..., 0]
    moved = fixed[which]
    if moved.any():
        base_T_world = _world(machine, external[moved])
        turn[moved] = base_T_world[:, :3, :3] @ turn[moved]
        place[moved] = (base_T_world[:, :3, :3] @ place[moved][..., None])[..., 0] + base_T_world[:, :3, 3]
    return (turn, place), external


def _world(machine: Machine, external: Array) -> Array:
    return machine.base_T_world(np.concatenate([np.zeros((len(external), 6)), external], axis=1))


def _look(
    machine: Machine, leg: Leg, rows: NDArray[np.int64], counts: NDArray[np.int64], begin: Array, branch: Branch
) -> _Between:
    """Motions `rows` at `counts` even places each, the last at their end; `begin` (K, 6) raw axis values at their start."""
    which = np.repeat(np.arange(len(rows)), counts)
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    share = (np.arange(len(which)) - starts[which] + 1.0) / counts[which]
    tool, external = _along(machine, leg, rows, which, share)
    found = _solve(machine, tool, external, leg.flange_T_tip, branch, begin[0])
    lost = np.isnan(found.axes[:, 0])
    axes = _kept(found.axes, begin[0])
    before = np.concatenate([axes[:1], axes[:-1]])
    before[starts] = begin
    step = wrapped(axes - before)
    total = np.cumsum(step, axis=0)
    since = total - (total[starts] - step[starts])[which]
    return _Between(
        net=np.add.reduceat(step, starts),
        most=np.maximum.reduceat(since, starts),
        least=np.minimum.reduceat(since, starts),
        jump=np.maximum.reduceat(np.abs(step), starts),
        lost=np.logical_or.reduceat(lost, starts),
        wrist=np.logical_or.reduceat(found.wrist, starts),
        elbow=np.logical_or.reduceat(found.elbow, starts),
        foot=np.logical_or.reduceat(found.foot, starts),
    )


def _counts(leg: Leg, net: Array) -> NDArray[np.int64]:
    """At how many places each motion is looked at (M,): 1 where its end is enough."""
    length = np.linalg.norm(np.diff(leg.place, axis=0), axis=1)
    arc = np.isfinite(leg.angle)
    if arc.any():
        length[arc] = leg.angle[arc] * np.linalg.norm(leg.place[:-1][arc] - leg.center[arc], axis=1)
    chord = np.linalg.norm((leg.turn[1:] - leg.turn[:-1]).reshape(-1, 9), axis=1)  # 2 sqrt(2) sin(angle / 2)
    turned = 2.0 * np.arcsin(np.clip(chord / np.sqrt(8.0), 0.0, 1.0))
    need = np.maximum(length / _LONG, turned / _TURNED)
    if leg.external.shape[1]:
        need = np.maximum(need, np.abs(np.diff(leg.external, axis=0)).max(axis=1) / _EXTERNAL)
    need = np.maximum(need, np.abs(net).max(axis=1) / _STEP)
    return np.asarray(np.ceil(np.clip(np.nan_to_num(need, nan=1.0), 1.0, _FINEST)), dtype=np.int64)


def _refined(
    machine: Machine, leg: Leg, rows: NDArray[np.int64], counts: NDArray[np.int64], begin: Array, branch: Branch
) -> _Between:
    """`_look`, ever closer at those motions on which an axis steps far; few at a time, to bound the memory."""
    parts: list[_Between] = []
    limit, first = 200_000, 0
    ends = np.cumsum(counts)
    while first < len(rows):
        base = int(ends[first - 1]) if first else 0
        last = max(first + 1, int(np.searchsorted(ends, base + limit)))
        parts.append(_look(machine, leg, rows[first:last], counts[first:last], begin[first:last], branch))
        first = last
    names = _Between.__dataclass_fields__
    seen = _Between(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))
    far = (seen.jump.max(axis=1) > _STEP) & ~seen.lost & (counts < _FINEST)
    if far.any():
        closer = _refined(machine, leg, rows[far], np.minimum(counts[far] * 8, _FINEST), begin[far], branch)
        for name in names:
            getattr(seen, name)[far] = getattr(closer, name)
    return seen


def follow(machine: Machine, leg: Leg, begin: Array) -> tuple[Array, list[Finding]]:
    """Axis values (M, n) at the ends of a leg's motions, and what stands against them.

    begin: (n,) axis values where the leg begins. Rows that can't be reached are NaN; what follows goes on from before them.
    """
    count = len(leg.angle)
    branch = machine.arm.branch(machine.arm.theta(begin[None, :6])[0])
    found = _solve(machine, (leg.turn[1:], leg.place[1:]), leg.external[1:], leg.flange_T_tip, branch, begin[:6])
    known = np.isfinite(leg.place[1:]).all(axis=1) & bool(np.isfinite(leg.flange_T_tip).all())
    lost = np.isnan(found.axes[:, 0])
    raw = np.concatenate([begin[None, :6], _kept(found.axes, begin[:6])])
    net = wrapped(np.diff(raw, axis=0))
    most, least = np.maximum(net, 0.0), np.minimum(net, 0.0)
    jump = np.zeros(count)
    counts = _counts(leg, net)
    rows = np.flatnonzero((counts > 1) & ~lost & np.isfinite(leg.place[:-1]).all(axis=1))
    seen_lost, near = lost & known, {name: getattr(found, name) & ~lost for name in ("wrist", "elbow", "foot")}
    jump_axis = np.zeros(count, dtype=np.int64)
    if len(rows):
        seen = _refined(machine, leg, rows, counts[rows], raw[rows], branch)
        net[rows], most[rows], least[rows] = seen.net, seen.most, seen.least
        jump_axis[rows] = seen.jump.argmax(axis=1)
        jump[rows] = seen.jump.max(axis=1)
        seen_lost[rows] |= seen.lost
        for name in near:
            near[name][rows] |= getattr(seen, name)
    turns = np.cumsum(np.round((net - np.diff(raw, axis=0)) / 360.0), axis=0)
    values = raw[1:] + 360.0 * turns
    before = np.concatenate([begin[None, :6], values[:-1]])
    findings = _limits(machine, before + most, before + least, leg.external[1:], ~lost)
    singular = {"wrist": "singular-wrist", "elbow": "singular-elbow", "foot": "singular-foot"}
    findings += [Finding(code, np.flatnonzero(near[name])) for name, code in singular.items()]
    findings.append(Finding("unreachable", np.flatnonzero(seen_lost)))
    jumped = (jump > _STEP) & ~seen_lost
    for axis in np.unique(jump_axis[jumped]):
        at = np.flatnonzero(jumped & (jump_axis == axis))
        findings.append(Finding("axis-jump", at, int(axis), jump[at], _STEP))
    axes = np.concatenate([values, leg.external[1:]], axis=1)
    axes[lost] = np.nan
    return axes, [finding for finding in findings if len(finding.rows)]


def _limits(
    machine: Machine, most: Array, least: Array, external: Array, known: Flags, slack: float = 1e-3
) -> list[Finding]:
    """Axes (M, 6) and (M, n - 6) past their limits by more than `slack`, degrees or mm."""
    findings = []
    for k, (low, high) in enumerate(zip(machine.low, machine.high, strict=True)):
        upper, lower = (most[:, k], least[:, k]) if k < 6 else (external[:, k - 6], external[:, k - 6])
        for values, past, limit in ((upper, upper > high + slack, high), (lower, lower < low - slack, low)):
            at = np.flatnonzero(past & known)
            if len(at):
                findings.append(Finding("limit", at, k, values[at], float(limit)))
    return findings
