"""What friction takes of each drive's torque or current, and how likely it is that one axis's has grown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.cell.joint import Role
from camrob.cell.load import PointMass
from camrob.dynamics.gravity import gravity_arrays, gravity_torques
from camrob.gap.observation.scene import Scene
from camrob.gap.verdict.belief import BELIEF
from camrob.summaries.diagnosis_places import AxisFriction, AxisReport
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["drive_friction", "with_friction"]

Array = NDArray[np.float64]

_UNITS = {"T": ("Nm", "N"), "I": ("A", "A")}  # what may be logged, of turning and of sliding axes; the better first
_NAMES = {"T": "torques", "I": "currents"}
_REST = 0.05  # of an axis's ordinary speed: slower is at rest
_MOVES = 0.02  # rad or m that an axis travels at the least, and both ways
_EACH_WAY = 0.1  # of the moving samples, that go the rarer way
_FEWEST, _MOST_ROWS = 40, 4000  # rows that tell it, and that are enough
_RANK = 1e-6
_STRETCHES = 10  # of a log, that are left out in turn
_FALLS, _RISES = 0.5, 3.0  # times the dry part, by which friction is less and more at the usual speed
_UNTOLD = 0.7  # of the energy beside weights and accelerations, from which what stays is no friction's
_CLEAR = 3.0  # standard errors of what friction takes, from which it is compared
_ROUGH = 0.05  # of it, by which any model of friction is wrong
_FEW_AXES = 3  # others that tell what all axes share: warmth, oil, speed
_PRIOR = 0.05  # of an axis, that its friction has grown where nobody knows
_GROWN, _GROWN_SPREAD = float(np.log(2.0)), 0.5  # by how much it then has, and how far that differs (logarithms)
_AGAIN, _AGAIN_ALONE = 0.12, 0.35  # how far a sound axis's differs from log to log, beside the others and without them
_BY_LOAD = 0.5  # of the logarithm of the load, that a gear's friction may grow by
# how far sound axes' differs by what their motors do else, and how sure one log can be: hardly
_OF_LOAD, _ALONE = 1.0, 0.3


@dataclass(frozen=True)
class _Found:
    """Friction of one axis in one log: dry part and slope by speed, with their covariance (2, 2), in the log's unit; its usual
    speed; `bears`: what its motor does beside friction; share: of the motor's energy that friction is.
    """

    dry: float
    slope: float
    cov: Array
    usual: float
    bears: float
    share: float

    def at(self, speed: float) -> tuple[float, float]:
        """What friction takes at a speed, and its standard error."""
        way = np.array([1.0, speed])
        size = abs(self.dry + self.slope * speed)
        return size, float(np.hypot(np.sqrt(max(way @ self.cov @ way, 0.0)), _ROUGH * size))


def with_friction(report: Mapping[str, AxisReport], scenes: Sequence[Scene]) -> dict[str, AxisReport]:
    """A report by axis, with what friction takes of the drives on some logs."""
    out = dict(report)
    for axis, friction in drive_friction(scenes).items():
        out[axis] = replace(out.get(axis, AxisReport()), friction=friction)
    return out


def drive_friction(scenes: Sequence[Scene]) -> dict[str, AxisFriction]:
    """By axis what friction takes of the torques T1 .. (else the currents I1 ..) at its usual speed, by log, and the probability
    that it has grown: against the log where it is least, where there are several, beside what the other axes have done from
    one to the other; of a single log against the other axes, each by what its motor does else, which hardly tells. {} where no
    log tells it.

    What an axis's motor does is gravity of all masses behind it, whatever they are, the axes' accelerations, a constant, and what
    changes sign with the direction: that is friction.
    """
    quiet = [s for s in scenes if not s.poses and s.force is None]  # a push at the tool turns with the direction, too
    for kind in _UNITS:
        logs = {s.name: found for s in quiet if (found := _of_log(s, kind))}
        if logs:
            break
    else:
        return {}
    axes = list(dict.fromkeys(a for found in logs.values() for a in found))
    least: dict[str, str] = {}
    chances, times = _from_log_to_log(logs, axes, least)
    if not chances:
        chances, times = _beside_others(next(iter(logs.values())))
    joints = scenes[0].cell.joints
    out = {}
    for a in axes:
        linear = joints[scenes[0].cell.index(a)].prismatic
        speed = min(found[a].usual for found in logs.values() if a in found)
        sizes = {name: found[a].at(speed) for name, found in logs.items() if a in found}
        name = max(sizes, key=lambda n: sizes[n][0])
        out[a] = AxisFriction(
            source=_NAMES[kind],
            unit=_UNITS[kind][linear],
            linear=linear,
            speed=m_to_mm(speed) if linear else rad_to_deg(speed),
            size=sizes[name][0],
            std=sizes[name][1],
            share=logs[name][a].share,
            by_log={n: size for n, (size, _) in sizes.items()},
            grown=chances.get(a, 0.0),
            times=times.get(a),
            against=least.get(a, ""),
            log=name,
        )
    return out


def _of_log(scene: Scene, kind: str) -> dict[str, _Found]:
    """Friction of each axis of one log that tells it."""
    logged = {a: v[:, 0] for a in scene.axes if (v := scene.log.beside(kind, [a])) is not None}
    if not logged or len(scene) < _FEWEST:
        return {}
    step = max(1, len(scene) // _MOST_ROWS)
    v, a = (scene.velocity(scene.command, order) for order in (1, 2))
    weighs = _weighed(scene, step)
    out = {}
    for axis, values in logged.items():
        k = scene.index(axis)
        own = _one(scene, k, values[::step], v[::step, k], a[::step], weighs[axis])
        if own is not None:
            out[axis] = own
    return out


def _weighed(scene: Scene, step: int) -> dict[str, Array]:
    """By axis (N, m): what a kilogram in the origin of each link, and a kilogram metre along each of its axes, puts on it."""
    cell = scene.cell
    q = cell.to_q(scene.log.axes(scene.axes) if scene.encoder is not None else scene.log.setpoints(scene.axes))[::step]
    parts = []
    for joint in cell.joints:
        if joint.role is Role.WORKPIECE:
            continue
        there = [
            gravity_torques(gravity_arrays(cell, [PointMass("one", joint.name, 1.0, c)]), q)
            for c in np.vstack([np.zeros(3), np.eye(3)])
        ]
        parts += [there[0], *(one - there[0] for one in there[1:])]
    return {a: np.stack([p[:, cell.index(a)] for p in parts], axis=1) for a in scene.axes}


def _one(scene: Scene, k: int, y: Array, v: Array, a: Array, weighs: Array) -> _Found | None:
    """One axis: what was logged (N,), its speed (N,), all axes' accelerations (N, n), its weights (N, m)."""
    speed = np.abs(v)
    moving = speed > _REST * float(np.quantile(speed, 0.9))
    known = np.isfinite(y)
    if moving.sum() < _FEWEST or np.ptp(scene.command[:, k]) < _MOVES or known.sum() < _FEWEST:
        return None
    usual = float(np.median(speed[moving]))
    if min((v[moving] > 0.0).mean(), (v[moving] < 0.0).mean()) < _EACH_WAY:
        return None
    way = np.stack([np.tanh(v / (_REST * usual)), v], axis=1)[known]
    rest = np.concatenate([weighs, a, np.ones((len(v), 1))], axis=1)[known]
    y = y[known]
    size = np.maximum(np.linalg.norm(rest, axis=0), 1e-12)
    U, s, _ = np.linalg.svd(rest / size, full_matrices=False)
    U = U[:, s > _RANK * s[0]]
    X = way - U @ (U.T @ way)
    left = y - U @ (U.T @ y)
    solved, *_ = np.linalg.lstsq(X, left, rcond=_RANK)
    off = left - X @ solved
    dry, slope = (float(v) for v in solved)
    rises = slope * usual * float(np.sign(dry))  # beside the dry part
    if float(off @ off) > _UNTOLD * float(left @ left) or not -_FALLS * abs(dry) < rises < _RISES * abs(dry):
        return None  # no friction does so: a force on the tool, or what no model of the arm says
    cov = _scatter(X, left, solved)
    taken = way @ solved
    else_done = y - taken
    return _Found(
        dry=dry,
        slope=slope,
        cov=cov,
        usual=usual,
        bears=float(np.quantile(np.abs(else_done - np.median(else_done)), 0.98)),
        share=float(np.clip(taken @ taken / max(float(y @ y), 1e-300), 0.0, 1.0)),
    )


def _scatter(X: Array, left: Array, solved: Array) -> Array:
    """(2, 2) covariance of what friction takes, `solved` of X (N, 2) and `left` (N,): by leaving out stretches of the log in
    turn, as what no model of an arm says hangs together over seconds.
    """
    edges = np.linspace(0, len(left), _STRETCHES + 1).astype(int)
    others = [np.r_[: edges[i], edges[i + 1] : len(left)] for i in range(_STRETCHES)]
    each = np.stack([np.linalg.lstsq(X[o], left[o], rcond=_RANK)[0] for o in others]) - solved
    return np.asarray((_STRETCHES - 1.0) / _STRETCHES * each.T @ each)


def _from_log_to_log(
    logs: Mapping[str, Mapping[str, _Found]], axes: Sequence[str], least: dict[str, str]
) -> tuple[dict[str, float], dict[str, float]]:
    """By axis how likely its friction has grown between the two logs in which it differs most from what the others' did, and how
    many times as large it is; `least` is told the log in which it is less. {} of a single log.
    """
    names = list(logs)
    chances: dict[str, float] = {}
    times: dict[str, float] = {}
    for i, one in enumerate(names):
        for other in names[i + 1 :]:
            grown = {a: g for a in axes if (g := _growth(logs[one].get(a), logs[other].get(a))) is not None}
            for a, (ratio, std) in grown.items():
                shared, differs = _of_others([r for b, (r, _) in grown.items() if b != a])
                beyond = _beside_load(ratio - shared, logs[one][a], logs[other][a])
                chance = _chance(abs(beyond), float(np.hypot(std, differs)))
                if chance >= chances.get(a, 0.0):
                    chances[a], times[a], least[a] = chance, float(np.exp(abs(beyond))), one if beyond > 0.0 else other
    return chances, times


def _of_others(ratios: Sequence[float]) -> tuple[float, float]:
    """What the other axes' friction has done from log to log (logarithm), and how far sound axes differ by that."""
    if len(ratios) < _FEW_AXES:
        return 0.0, _AGAIN_ALONE
    shared = float(np.median(ratios))
    return shared, max(_AGAIN, 1.4826 * float(np.median(np.abs(np.array(ratios) - shared))))


def _beside_load(ratio: float, one: _Found, other: _Found) -> float:
    """What is left of a logarithm of friction's growth where what the motor does else has grown, too: a gear's friction is more
    under load.
    """
    load = _BY_LOAD * float(np.log(max(other.bears, 1e-12) / max(one.bears, 1e-12)))
    return ratio - float(np.clip(load, min(ratio, 0.0), max(ratio, 0.0)))


def _growth(one: _Found | None, other: _Found | None) -> tuple[float, float] | None:
    """Logarithm of how many times as large friction is in another log, at one speed, and its standard error."""
    if one is None or other is None:
        return None
    speed = min(one.usual, other.usual)
    (a, std_a), (b, std_b) = one.at(speed), other.at(speed)
    if max(a / std_a, b / std_b) < _CLEAR or min(a, b) <= 0.0:
        return None
    return float(np.log(b / a)), float(np.hypot(min(std_a / a, 1.0), min(std_b / b, 1.0)))


def _beside_others(found: Mapping[str, _Found]) -> tuple[dict[str, float], dict[str, float]]:
    """By axis how likely its friction is more than those of the others, each by what its motor does else, let expect."""
    relative = {}
    for a, one in found.items():
        size, std = one.at(one.usual)
        if size >= _CLEAR * std and one.bears > 0.0:
            relative[a] = float(np.log(size / one.bears)), std / size
    chances: dict[str, float] = {}
    times: dict[str, float] = {}
    for a, (ratio, std) in relative.items():
        others = [r for b, (r, _) in relative.items() if b != a]
        if len(others) < _FEW_AXES:
            continue
        beyond = ratio - float(np.median(others))
        times[a] = float(np.exp(beyond))
        chances[a] = min(_ALONE, _chance(beyond, float(np.hypot(std, _OF_LOAD)))) if beyond > 0.0 else 0.0
    return chances, times


def _chance(beyond: float, spread: float) -> float:
    """Probability of grown friction where its logarithm is `beyond` what is expected, which differs by `spread` of sound axes."""
    wide = float(np.hypot(spread, _GROWN_SPREAD))
    sound = float(np.exp(-0.5 * (beyond / spread) ** 2)) / spread
    grown = float(np.exp(-0.5 * ((beyond - _GROWN) / wide) ** 2)) / wide if beyond < _GROWN else 1.0 / wide
    return min(BELIEF.surest, _PRIOR * grown / max(_PRIOR * grown + (1.0 - _PRIOR) * sound, 1e-300))
