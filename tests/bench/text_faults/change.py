"""Whether two programs do the same: path, feed and events by place on the path; postures apart.

The judgement by which a drawn fault counts: what the machine does differs by more than 0.01 mm, 0.01 degrees, in a feed, in an
event or in what is in force. The tool turns on its own axis, so that the roll about it, and how track and table share the
way with the arm, are `posture`: another one is no fault while it is within reach and limits.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from mutation import arm
from numpy.typing import NDArray

from text_faults.context import RAPID
from text_faults.deeds import Deed, OpaqueError, deeds
from text_faults.tree import Tree

Array = NDArray[np.float64]
_MM, _DEG, _RATIO = 0.01, 0.01, 2e-4
_TURN = 0.1
"""mm of path that a degree of turning on the spot counts for."""
_PIECES = 24


@dataclass(frozen=True)
class _Run:
    """CP motions between two PTPs: the way s (N,), place (N, 3), axis (N, 3), and per piece (N-1) what is in force."""

    s: Array
    place: Array
    axis: Array
    force: list[tuple[object, ...]]
    stops: list[tuple[float, tuple[object, ...]]]


def differences(old: Tree, new: Tree) -> set[str]:
    """In what the new program differs: any of `path`, `feed`, `rapid`, `events`, `settings`, `ptp`, `posture`, `limits`.

    feed: of motions at a cutting feed; rapid: of the others. ptp: where a PTP leads. settings: `$TOOL`, `$BASE` and the rest
    that is in force. Raises OpaqueError.
    """
    a, last_a, runs_a = _done(old)
    b, last_b, runs_b = _done(new)
    found = set()
    if last_a != last_b:
        found.add("events")
    if len(runs_a) != len(runs_b):
        return found | {"path"}
    for (head_a, run_a), (head_b, run_b) in zip(runs_a, runs_b, strict=True):
        found |= _heads(head_a, head_b) | _compare(run_a, run_b)
    if found <= {"posture", "ptp"}:
        found |= _postures(a, b)
    return found


@lru_cache(maxsize=16)
def _done(tree: Tree) -> tuple[list[Deed], object, list[tuple[Deed | None, _Run]]]:
    """Deeds, outputs that remain, and the deeds as runs. Raises OpaqueError."""
    steps, last = deeds(tree)
    return steps, last, _runs(steps)


def _runs(steps: Sequence[Deed]) -> list[tuple[Deed | None, _Run]]:
    """The program cut up at its PTPs, each with the CP motions behind it; without PTPs to where it stands, waits of 0 s."""
    parts: list[tuple[Deed | None, list[Deed]]] = [(None, [])]
    for deed in steps:
        head, tail = parts[-1]
        if deed.kind == "ptp":
            stands = head is not None and head.target == deed.target and all(d.kind in ("wait", "halt") for d in tail)
            if not stands:
                parts.append((deed, []))
        elif deed.kind != "wait" or deed.seconds:
            tail.append(deed)
    return [(head, _run(head, tail)) for head, tail in parts]


def _run(head: Deed | None, tail: Sequence[Deed]) -> _Run:
    start = None if head is None or "A1" in head.target else head.target
    s, place, axis = [0.0], [np.zeros(3)], [np.zeros(3)]
    if start is not None:
        place, axis = [_place(start)], [_axis(start)]
    force: list[tuple[object, ...]] = []
    stops: list[tuple[float, tuple[object, ...]]] = []
    for deed in tail:
        if deed.kind in ("wait", "halt"):
            stops.append((s[-1], (deed.kind, round(deed.seconds, 4), deed.state)))
            continue
        for p, a in _pieces(place[-1], axis[-1], deed):
            step = math.dist(p, place[-1]) + _TURN * _angle(axis[-1], a)
            if step > 1e-6:
                s.append(s[-1] + step)
                place.append(p)
                axis.append(a)
                force.append((deed.speed, deed.state, deed.settings))
    return _Run(np.array(s), np.array(place), np.array(axis), force, stops)


def _pieces(p0: Array, a0: Array, deed: Deed) -> list[tuple[Array, Array]]:
    end, axis = _place(deed.target), _axis(deed.target)
    if deed.kind != "circ":
        return [(end, axis)]
    via = _place(deed.via)
    u, v = via - p0, end - p0
    normal = np.cross(u, v)
    if np.linalg.norm(normal) < 1e-6:
        return [(via, axis), (end, axis)]
    n2 = float(normal @ normal)
    centre = p0 + (float(u @ u) * np.cross(v, normal) + float(v @ v) * np.cross(normal, u)) / (2.0 * n2)
    x = p0 - centre
    y = np.cross(normal / np.sqrt(n2), x)
    angle = float(np.arctan2((end - centre) @ y, (end - centre) @ x)) % (2.0 * np.pi)
    out = []
    for k in range(1, _PIECES + 1):
        t = angle * k / _PIECES
        turned = a0 + (axis - a0) * k / _PIECES
        out.append((centre + x * np.cos(t) + y * np.sin(t), turned / np.linalg.norm(turned)))
    return out


def _place(pose: Mapping[str, float]) -> Array:
    return np.array([pose["X"], pose["Y"], pose["Z"]])


def _axis(pose: Mapping[str, float]) -> Array:
    """The tool's z, the last column of Rz(A) Ry(B) Rx(C)."""
    a, b, c = (math.radians(pose[k]) for k in "ABC")
    up = math.sin(b) * math.cos(c)
    x = math.cos(a) * up + math.sin(a) * math.sin(c)
    y = math.sin(a) * up - math.cos(a) * math.sin(c)
    return np.array([x, y, math.cos(b) * math.cos(c)])


def _angle(a: Array, b: Array) -> float:
    """Degrees between two axes; 0 where one is not known."""
    if not a.any() or not b.any():
        return 0.0
    return math.degrees(2.0 * math.atan2(math.dist(a, b), math.dist(a, -b)))


def _heads(a: Deed | None, b: Deed | None) -> set[str]:
    """How two PTPs differ."""
    if a is None or b is None:
        return set() if a is b else {"path"}
    found = set()
    if a.state != b.state:
        found.add("events")
    if a.settings != b.settings:
        found.add("settings")
    if ("A1" in a.target) != ("A1" in b.target):
        found.add("ptp")
    elif "A1" in a.target:
        found |= {"ptp" for k in arm.NAMES if abs(a.target.get(k, 0.0) - b.target.get(k, 0.0)) > _DEG}
    else:
        if np.linalg.norm(_place(a.target) - _place(b.target)) > _MM or _angle(_axis(a.target), _axis(b.target)) > _DEG:
            found.add("ptp")
        found |= {"posture" for k in ("S", "T") if a.target.get(k) != b.target.get(k)}
    return found


def _compare(a: _Run, b: _Run) -> set[str]:
    if len(a.s) < 2 or len(b.s) < 2:
        found = set() if len(a.s) == len(b.s) else {"path"}
        return found if [x for _, x in a.stops] == [x for _, x in b.stops] else found | {"events"}
    if abs(a.s[-1] - b.s[-1]) > 2.0 * _MM:
        return {"path"}
    found = set()
    at = np.union1d(a.s, b.s)
    at = at[np.concatenate([[True], np.diff(at) > 1e-4])]
    (place_a, axis_a), (place_b, axis_b) = _at(a, at), _at(b, at)
    if np.linalg.norm(place_a - place_b, axis=1).max() > _MM:
        return {"path"}
    if max(_angle(x, y) for x, y in zip(axis_a, axis_b, strict=True)) > _DEG:
        return {"path"}
    for s in 0.5 * (at[1:] + at[:-1])[np.diff(at) > 2.0 * _MM]:
        found |= _forces(_force(a, s), _force(b, s))
    stops_a, stops_b = [x for _, x in a.stops], [x for _, x in b.stops]
    apart = [abs(x - y) for (x, _), (y, _) in zip(a.stops, b.stops, strict=False)]
    if stops_a != stops_b or max(apart, default=0.0) > 2.0 * _MM:
        found.add("events")
    return found


def _at(run: _Run, s: Array) -> tuple[Array, Array]:
    place = np.stack([np.interp(s, run.s, run.place[:, k]) for k in range(3)], axis=1)
    axis = np.stack([np.interp(s, run.s, run.axis[:, k]) for k in range(3)], axis=1)
    return place, axis


def _force(run: _Run, s: float) -> tuple[object, ...]:
    k = int(np.clip(np.searchsorted(run.s, s) - 1, 0, len(run.force) - 1))
    return run.force[k]


def _forces(a: tuple[object, ...], b: tuple[object, ...]) -> set[str]:
    found = set()
    if abs(float(a[0]) - float(b[0])) > _RATIO * float(a[0]):  # type: ignore[arg-type]
        found.add("feed" if float(a[0]) < 0.999 * RAPID else "rapid")  # type: ignore[arg-type]
    if a[1] != b[1]:
        found.add("events")
    if a[2] != b[2]:
        found.add("settings")
    return found


def _postures(a: Sequence[Deed], b: Sequence[Deed]) -> set[str]:
    """`posture` where the axes' way differs, `limits` where the new one leaves them or the arm does not reach."""
    names = ("A", "A1", "A2", "A3", "A4", "A5", "A6", "E1", "E2")
    poses_a = [tuple(d.target.get(k, 0.0) for k in names) for d in a if d.kind != "wait" and d.kind != "halt"]
    poses_b = [tuple(d.target.get(k, 0.0) for k in names) for d in b if d.kind != "wait" and d.kind != "halt"]
    turned = [tuple(d.target.get(k, 0.0) for k in ("S", "T")) for d in b if d.kind == "ptp"]
    same = len(poses_a) == len(poses_b) and bool(np.allclose(poses_a, poses_b, atol=1e-3))
    same = same and turned == [tuple(d.target.get(k, 0.0) for k in ("S", "T")) for d in a if d.kind == "ptp"]
    if same:
        return set()
    return {"posture"} | ({"limits"} if leaves_limits(b) else set())


def leaves_limits(steps: Sequence[Deed]) -> bool:
    """Whether the arm does not reach a pose, or an axis leaves its range; between points as the controller goes."""
    axes, status, at = arm.HOME[:6], 2, None  # type: Array, int, Mapping[str, float] | None
    for deed in steps:
        if deed.kind in ("wait", "halt"):
            continue
        end = deed.target
        if "A1" in end:
            given = np.array([end[k] for k in arm.NAMES])
            if np.any(given < arm.LOWER) or np.any(given > arm.UPPER):
                return True
            axes, status, at = given[:6], arm.status_of(given), None
            continue
        if not arm.LOWER[6] <= end["E1"] <= arm.UPPER[6]:
            return True
        if deed.kind == "ptp":
            status = int(end.get("S", status))
            solved = arm.on_turn(_solve([end], status, deed)[0], int(end.get("T", 0)))
            if solved is None or np.isnan(solved).any():
                return True
            axes, at = solved, end
            continue
        way = _solve([_between(at, end, share) for share in (0.25, 0.5, 0.75)] if at else [], status, deed)
        for found in np.concatenate([way, _solve([end], status, deed)]):
            axes = found + 360.0 * np.round((axes - found) / 360.0)
            if not (np.all(axes >= arm.LOWER[:6]) and np.all(axes <= arm.UPPER[:6])):
                return True
        at = end
    return False


def _between(start: Mapping[str, float], end: Mapping[str, float], share: float) -> dict[str, float]:
    """A pose on a motion's way; its angles are those of the nearer end."""
    pose = {k: start[k] + share * (end[k] - start[k]) for k in ("X", "Y", "Z", "E1", "E2")}
    return {**pose, **{k: (start if share < 0.5 else end)[k] for k in "ABC"}}


def _solve(poses: Sequence[Mapping[str, float]], status: int, deed: Deed) -> Array:
    """A1 .. A6 (N, 6) of poses in `base`, with the `$TOOL` in force; NaN out of reach."""
    tool = dict(deed.settings).get("$TOOL")
    if tool is None:
        raise OpaqueError("no tool")
    if not poses:
        return np.zeros((0, 6))
    flange_T_tool = arm.frame(np.array([float(part.split()[1]) for part in tool.split(",")]))
    base_T_tool = arm.frame(np.array([[p[k] for k in "XYZABC"] for p in poses], float))
    base_T_root = arm.base_T_root(np.array([p["E1"] for p in poses]), np.array([p["E2"] for p in poses]))
    return np.asarray(arm.postures(arm.inverse(base_T_root) @ base_T_tool @ arm.inverse(flange_T_tool), status))
