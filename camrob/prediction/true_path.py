"""Where the tool of the machine as diagnosed would truly go on a program's run, why, and how sure that is.

The effects' own code is evaluated on the run of the simulated controller: first what happens between set-points and encoders,
then, on the encoders that this gives, what happens behind them. Constants of the chain are the calibration's.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.calibration import Calibration, calibrated_chain
from camrob.calibration.error_model import ErrorModel
from camrob.cell.cell import Cell
from camrob.errors import InputError
from camrob.gap.effects.effect import Column
from camrob.gap.fitted_units import FittedUnits, OpenUnits
from camrob.gap.observation.scene import Scene, axis_values, make_scene
from camrob.kinematics.frames import world_T_base
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo, MeasuredFrame
from camrob.prediction.deflection import CAUSE, Granted, deflection, granted_compliance, known_compliance
from camrob.prediction.force_model import CuttingForce
from camrob.se3 import rotation_exp
from camrob.units import m_to_mm

__all__ = ["UNEXPLAINED", "Cause", "TruePath", "claimed_constants", "joined_paths", "true_path", "unit_name"]

Array = NDArray[np.float64]

_FARTHEST_BENT = 5e-3  # m: a hundred times what cuts bend an arm by, and too far for what is reckoned to first order

UNEXPLAINED = "unexplained, as measured near by"
"""The name of what no cause explains, as far as it was measured at like postures."""


@dataclass(frozen=True)
class Cause:
    """What moves the tool: its name, and the twist (N, 6) in `base` by which it does, m and rad."""

    name: str
    twist: Array


@dataclass(frozen=True)
class TruePath:
    """The run, a row a cycle. ideal, true: (N, 4, 4) tool in `base`, as the simulated controller and as the machine goes.

    causes: what lies between the two. spread: (N, 6, K) twists of a standard deviation in K independent directions, each of
    which is one thing that may be wrong along the whole path: a value as fitted, a description, the force; rest: (N,) m, the
    standard deviation in any one direction of what no cause explains, beside what is expected of it (`UNEXPLAINED` among the
    causes); unsized: (N,) m, the part of it whose size is itself in doubt by `SIZE_DOUBT`, None for nothing; together: (N, L) m,
    L independent parts of it that go along the whole path, in any one direction, None where that was not asked for.
    not_reckoned: what was found and moves the tool by what this run doesn't tell. yields: axes that give way under the cutting
    force, as far as anybody knows; granted: those taken to, as such axes do beside these, or as is ordinary for the arm where
    nobody knows of any.
    """

    t: Array
    line: NDArray[np.int64]
    ideal: Array
    true: Array
    causes: tuple[Cause, ...]
    spread: Array
    rest: Array
    not_reckoned: tuple[str, ...]
    yields: tuple[str, ...] = ()
    granted: tuple[str, ...] = ()
    unsized: Array | None = None
    together: Array | None = None


def true_path(
    run: MeasurementLog,
    cell: Cell,
    calibration: Calibration | None,
    found: FittedUnits | None,
    *,
    rest: float,
    force: CuttingForce | None = None,
    area: Array | None = None,
    cuts: NDArray[np.bool_] | None = None,
    assumed: bool = True,
    drawn: bool = False,
) -> TruePath:
    """The machine's path on a run of the simulated controller.

    cell: with the tool that the program sets. calibration: None for a chain that is as it should be, or as `found` claims that it
    is. found: what the diagnosis claims, None for the calibration's constants alone. rest: m (one direction) that stays
    unexplained. force: what pushes on the tool, area: (N,) m2 that it cuts; cuts: (N,) where it does, None for everywhere.
    assumed: see `granted_compliance`; drawn: whether `together` is asked for. Raises InputError where the calibration is not that
    of the diagnosis.
    """
    scene = _scene(run, cell)
    model, constants = calibrated_chain(calibration, cell)
    if calibration is None and found is not None:
        model, constants = _claimed_chain(found, cell)
    known = known_compliance(found, model, constants)
    granted = granted_compliance(scene.cell, known, found, assumed=assumed)
    if found is None:
        path = _calibrated(run, scene, model, constants, rest)
        return _bent(path, scene, known, np.zeros((0, 0)), force, area, cuts, granted)
    _same_constants(found, model)
    first = _columns(scene, found)
    moved = np.zeros_like(scene.command)
    for value, column in zip(found.values, first, strict=True):
        for axis, signal in ({} if column is None else column.servo).items():
            moved[:, scene.index(axis)] += value * signal
    behind = _scene(run, cell, moved) if moved.any() else scene
    second = _columns(behind, found) if moved.any() else first
    twists = _twists(scene, first, second, [found.effects[own].of_machine for own in found.owner.tolist()])
    states = [
        found.values[k] * twists[:, :, k] * np.clip(b.doubt, 0.0, 1.0)[:, None]
        for k, b in enumerate(second)
        if b is not None and b.doubt is not None and twists[:, :, k].any()
    ]
    constant = np.array([bool(e.terms(u, s)) for u, e, s in zip(found.units, found.effects, found.states, strict=True)])
    further = np.zeros((len(scene), 6))
    for k, (column, own) in enumerate(zip(second, found.owner.tolist(), strict=True)):
        if column is not None and column.tcp is not None and not constant[own] and found.effects[own].of_machine:
            further += found.values[k] * column.tcp
    root = _root(_covariance(found))
    moving = twists
    if found.open is not None:
        # claimed and open values together: their further doubt beside that of the claimed ones
        moving = np.concatenate([twists, _open_twists(scene, behind, found.open)], axis=2)
        root = np.hstack([np.pad(root, ((0, len(found.open.root) - len(root)), (0, 0))), found.open.root])
    path = TruePath(
        t=np.asarray(run.t),
        line=run.line,
        ideal=np.asarray(scene.nominal),
        true=_moved(model.poses(constants, behind.postures(behind.link)), further),
        causes=_causes(found, twists),
        spread=np.einsum("nik,kl->nil", moving, root, optimize=True),
        rest=np.full(len(scene), rest),
        not_reckoned=_left(found, first),
    )
    path = _bent(_with_unexplained(path, behind, found, root, drawn), scene, known, root, force, area, cuts, granted)
    return replace(path, spread=np.concatenate([path.spread, *(s[:, :, None] for s in states)], axis=2))


def _twists(
    scene: Scene, first: Sequence[Column | None], second: Sequence[Column | None], of_machine: Sequence[bool]
) -> Array:
    """(N, 6, K) twists of a unit of each parameter: what it does to the drives on the run, and what behind them."""
    twists = np.zeros((len(scene), 6, len(first)))
    for k, (a, b, counts) in enumerate(zip(first, second, of_machine, strict=True)):
        if a is None or b is None or not counts:
            continue
        for axis, signal in a.servo.items():
            twists[:, :, k] += scene.shift(axis, signal)
        if b.tcp is not None:
            twists[:, :, k] += b.tcp
    return twists


def _open_twists(scene: Scene, behind: Scene, found: OpenUnits) -> Array:
    """(N, 6, L) likewise, of units that were not claimed; zeros of those that this run does not determine."""
    of_machine = [e.of_machine for u, e in zip(found.units, found.effects, strict=True) for _ in u.parameters]
    return _twists(scene, _columns(scene, found), _columns(behind, found), of_machine)


def joined_paths(paths: Sequence[TruePath]) -> TruePath:
    """Paths of one machine one behind another, as they follow from the same diagnosis: of a run that changes its tool."""
    if len(paths) == 1:
        return paths[0]
    drawn = [p.together for p in paths if p.together is not None]
    unsized = [p.unsized for p in paths if p.unsized is not None]
    return replace(
        paths[0],
        t=np.concatenate([p.t for p in paths]),
        line=np.concatenate([p.line for p in paths]),
        ideal=np.concatenate([p.ideal for p in paths]),
        true=np.concatenate([p.true for p in paths]),
        causes=tuple(
            Cause(c.name, np.concatenate([p.causes[k].twist for p in paths])) for k, c in enumerate(paths[0].causes)
        ),
        spread=_below([p.spread for p in paths]),  # a side that is not known yet is one thing more on some of them
        rest=np.concatenate([p.rest for p in paths]),
        not_reckoned=tuple(dict.fromkeys(name for p in paths for name in p.not_reckoned)),
        unsized=np.concatenate(unsized) if unsized else None,
        together=_below(drawn) if drawn else None,
    )


def _below(parts: Sequence[Array]) -> Array:
    """Arrays (N, ..., K) of different K, one below another, zeros where one has fewer columns."""
    most = max(p.shape[-1] for p in parts)
    return np.concatenate([np.pad(p, (*[(0, 0)] * (p.ndim - 1), (0, most - p.shape[-1]))) for p in parts])


def _with_unexplained(path: TruePath, scene: Scene, found: FittedUnits, root: Array, drawn: bool) -> TruePath:
    """The path with what the diagnosis' field over posture expects beside the causes; scene: seen from `base`."""
    if found.unexplained is None:
        return path
    got, turn = found.unexplained.at(scene), np.eye(3)[None]
    if not found.unexplained.in_base:
        turn = world_T_base(scene.cell, scene.postures(scene.link))[:, :3, :3]
    twist, spread = np.zeros((len(scene), 6)), path.spread.copy()
    twist[:, :3] = np.einsum("nji,nj->ni", turn, got.mean)
    # where an effect is larger than fitted, less is left unexplained where that was measured
    spread[:, :3] -= np.einsum("nji,njk,kl->nil", turn, got.by_value, root, optimize=True)
    return replace(
        path,
        true=_moved(path.true, twist),
        causes=(*path.causes, Cause(UNEXPLAINED, twist)),
        spread=spread,
        rest=np.sqrt(path.rest**2 + got.known**2 + got.beyond**2),
        unsized=got.beyond,
        together=found.unexplained.together(scene) if drawn else None,
    )


def _bent(
    path: TruePath,
    scene: Scene,
    known: Mapping[str, tuple[float, int]],
    root: Array,
    force: CuttingForce | None,
    area: Array | None,
    cuts: NDArray[np.bool_] | None,
    granted: Granted,
) -> TruePath:
    """The path with the deflection under the cutting force in it; root: (K, L), its square is the covariance of what was fitted.

    A compliance that is wrong is wrong for gravity and for the force alike; the force is one more thing that may be wrong.
    """
    if force is None:
        return path
    pushed = force.in_base(path.ideal, path.t, area)
    bent = deflection(scene, pushed if cuts is None else pushed * cuts[:, None], known, granted, force.give)
    aside = float(np.linalg.norm(bent.twist[:, :3], axis=1).max(initial=0.0))
    if aside > _FARTHEST_BENT:
        what = f"pushes the tool aside by up to {m_to_mm(aside):.0f} mm, which no cut does"
        raise InputError(what, hint="check the force in N, and coefficients and engagement", path=force.path)
    spread = path.spread.copy()
    for k, unit in bent.sensitivity.items():
        spread += unit[:, :, None] * root[k]
    return replace(
        path,
        true=_moved(path.true, bent.twist),
        causes=(*path.causes, Cause(CAUSE, bent.twist)),
        spread=np.concatenate([spread, force.doubt * bent.twist[:, :, None], bent.granted], axis=2),
        yields=tuple(a for a in known if a not in granted.by_axis),
        granted=tuple(granted.by_axis),
    )


def _scene(run: MeasurementLog, cell: Cell, moved: Array | None = None) -> Scene:
    """The run as the diagnosis lays logs out, seen from `base`; moved: (N, k) by which encoders are beyond their set-points."""
    columns = {name: run.columns[name] for name in ("t", "line")}
    setpoints = run.setpoints(cell.axis_names)
    columns |= {f"c{a}": setpoints[:, k] for k, a in enumerate(cell.axis_names)}
    beyond = 0.0 if moved is None else axis_values(cell, cell.axis_names, moved)
    columns |= {a: (setpoints + beyond)[:, k] for k, a in enumerate(cell.axis_names)}
    return make_scene(MeasurementLog(columns, LogInfo(measured_frame=MeasuredFrame.BASE)), cell)


def _columns(scene: Scene, found: FittedUnits | OpenUnits) -> list[Column | None]:
    """A column a parameter; None of units that a run without temperature, force or masses does not determine."""
    out: list[Column | None] = []
    for unit, effect, state in zip(found.units, found.effects, found.states, strict=True):
        own = effect.columns(scene, unit, state)
        out += own if len(own) == len(unit.parameters) else [None] * len(unit.parameters)
    return out


def _left(found: FittedUnits, columns: Sequence[Column | None]) -> tuple[str, ...]:
    lacking = {int(o) for o, c in zip(found.owner, columns, strict=True) if c is None}
    return tuple(unit_name(found, i) for i in sorted(lacking))


def unit_name(found: FittedUnits, i: int) -> str:
    """What a unit is called among causes: its effect, and its axis where it has one."""
    unit = found.units[i]
    return f"{unit.effect} of {unit.axis}" if unit.axis else unit.effect


def _claimed_chain(found: FittedUnits, cell: Cell) -> tuple[ErrorModel, Array]:
    """The chain with the constants that a diagnosis claims, and their values: it writes no calibration where correcting these
    alone would not shrink the gap.
    """
    values = claimed_constants(found)
    return ErrorModel.of(cell, tuple(values), in_base=True), np.array(list(values.values()))


def claimed_constants(found: FittedUnits) -> dict[str, float]:
    """The chain's constants that a diagnosis claims, and their values."""
    values: dict[str, float] = {}
    for i, (unit, effect, state) in enumerate(zip(found.units, found.effects, found.states, strict=True)):
        named = effect.terms(unit, state)
        for name, value in zip(named, found.values[found.owner == i] if named else (), strict=True):
            values[name] = values.get(name, 0.0) + float(value)
    return values


def _same_constants(found: FittedUnits, model: ErrorModel) -> None:
    """Raise InputError where calibration and diagnosis don't hold the same constants of the chain."""
    terms = {
        name
        for unit, effect, state in zip(found.units, found.effects, found.states, strict=True)
        for name in effect.terms(unit, state)
    }
    if terms != set(model.names):
        other = sorted(terms ^ set(model.names))[0]
        hint = "give the file that `camrob diagnose --calibration` wrote with that diagnosis"
        raise InputError(f"the calibration is not that of the diagnosis: {other} is in one of them only", hint=hint)


def _causes(found: FittedUnits, twists: Array) -> tuple[Cause, ...]:
    sums: dict[str, Array] = {}
    for k, own in enumerate(found.owner.tolist()):
        if found.effects[own].of_machine:
            name = unit_name(found, own)
            sums[name] = sums.get(name, 0.0) + found.values[k] * twists[:, :, k]
    return tuple(Cause(name, twist) for name, twist in sums.items())


def _covariance(found: FittedUnits) -> Array:
    """(K, K) of how far values may be off. A description that is wrong by a share of itself is a value that is wrong by as much:
    it moves the tool along its own effect, and what is unexplained was fitted beside it, too, and makes up for it where the logs
    were.
    """
    accuracy = np.array([found.effects[own].accuracy for own in found.owner.tolist()])
    return np.asarray(found.cov + np.diag((accuracy * found.values) ** 2))


def _root(cov: Array) -> Array:
    """L with L L' = cov, of a matrix that may be singular."""
    values, vectors = np.linalg.eigh(0.5 * (cov + cov.T))
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


def _moved(poses: Array, twist: Array) -> Array:
    out = poses.copy()
    out[:, :3, 3] += twist[:, :3]
    out[:, :3, :3] = rotation_exp(twist[:, 3:]) @ poses[:, :3, :3]
    return out


def _calibrated(run: MeasurementLog, scene: Scene, model: ErrorModel, constants: Array, rest: float) -> TruePath:
    """The path of a calibrated chain; what is left on withheld poses holds all doubt, as a file keeps no covariance."""
    q = scene.postures(scene.link)
    ideal, J = model.poses_and_jacobian(np.zeros(len(constants)), q)
    causes = tuple(Cause(n, v * J[:, :, k]) for k, (n, v) in enumerate(zip(model.names, constants, strict=True)))
    none = np.zeros((len(q), 6))
    true = model.poses(constants, q)
    return TruePath(np.asarray(run.t), run.line, ideal, true, causes, none[:, :, None], np.full(len(q), rest), ())
