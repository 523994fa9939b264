"""Effects that a cell brings: `effects/NAME.toml` in its folder, one file an effect, formulas instead of code.

A cell's folder is data that people pass on, and reading one must not run anything; so its effects are written as formulas
on signals (see `expression`), not as Python. What formulas can't say belongs into camrob's own library.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.terms import PARTS, term_of
from camrob.cell.cell import Cell
from camrob.errors import CellError, LogError
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.effects.registry import library
from camrob.gap.expression import Expression, parse_expression
from camrob.gap.observation.scene import Scene
from camrob.gap.observation.signals import first_order, play
from camrob.toml.read_toml import read_toml
from camrob.toml.table_reader import TableReader
from camrob.units import deg_to_rad, m_to_mm, mm_to_m, rad_to_deg

__all__ = ["cell_effects", "signal_names"]

Array = NDArray[np.float64]

FOLDER = "effects"
_NAME = re.compile(r"[a-z][a-z0-9_]{2,31}")
_VALUE = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,31}")
_TAKEN = ("unknown", "nuisance")
_STAGES = ("setpoint_to_encoder", "encoder_to_tcp")
_REGIMES = ("position", "direction", "speed", "acceleration", "load", "force", "time")
_MOST_FILES, _MOST_PARAMETERS, _MOST_TRIALS = 32, 12, 12  # a cell's own, before a search takes minutes
_STILL = 1e-9  # in its own unit: a formula that gives no more than that does not show


@dataclass(frozen=True, slots=True)
class _Part:
    """One parameter: what it moves (a twist of the error model, or "drive AXIS"), and by which formula."""

    parameter: EffectParameter
    moves: str
    formula: Expression


def signal_names(cell: Cell) -> tuple[str, ...]:
    """What formulas may name: axis values (degrees, mm), dAXIS and ddAXIS their rates a second, T_AXIS gravity's torques (Nm),
    t (s), temp (degrees C), x, y, z of the TCP in the measured frame (mm), fx, fy, fz (N).
    """
    axes = cell.axis_names
    rates = [f"{d}{a}" for d in ("", "d", "dd") for a in axes]
    return (*rates, *(f"T_{a}" for a in axes), "t", "temp", "x", "y", "z", "fx", "fy", "fz")


def cell_effects(folder: Path, cell: Cell) -> tuple[Effect, ...]:
    """The effects in a cell's folder, by file name; () where it has none. Raises CellError for one that can't be read."""
    home = folder / FOLDER if folder.is_dir() else folder.parent / FOLDER
    files = sorted(home.glob("*.toml")) if home.is_dir() else []
    if len(files) > _MOST_FILES:
        raise CellError(f"{FOLDER} holds {len(files)} effects", hint=f"keep {_MOST_FILES}", path=home)
    return tuple(_read(path, cell) for path in files)


def _read(path: Path, cell: Cell) -> Effect:
    table = TableReader(read_toml(path), path)
    name = table.text("name")
    known = {e.name for e in library()}
    if not _NAME.fullmatch(name) or name in known or name in _TAKEN:
        raise table.fail(
            "name", f"{name[:40]!r} can't be an effect's name", "use a new one: small letters, digits and _"
        )
    if name != path.stem:
        raise table.fail("name", f"is {name!r} in a file {path.name[:40]}", "give both the same name")
    state = _state(table, signal_names(cell))
    allowed = {*signal_names(cell), *state}
    parts = tuple(_part(one, cell, allowed) for one in table.tables("parameter"))
    if not 0 < len(parts) <= _MOST_PARAMETERS:
        raise table.fail("parameter", f"is given {len(parts)} times", f"give 1 to {_MOST_PARAMETERS}")
    if len({p.parameter.name for p in parts}) < len(parts):
        raise table.fail("parameter", "has one name twice", "give each its own")
    regimes = table.texts("regimes")
    for one in regimes:
        if one not in _REGIMES:
            raise table.fail("regimes", f"names {one[:30]!r}", f"use {', '.join(_REGIMES)}")
    drives = {p.moves.startswith("drive ") for p in parts}
    effect = Effect(
        name=name,
        physics=table.text("physics").rstrip(".") + ".",
        stages=tuple(r for r, used in zip(_STAGES, (True in drives, False in drives), strict=True) if used),
        regimes=regimes,
        experiment=table.text("experiment"),
        remedy=table.text("remedy") if "remedy" in table else "",
        units=_units_of(name, parts),
        columns=_columns_of(parts),
        start={k: v[0] for k, v in state.items()},
        trials=tuple({k: v} for k, values in state.items() for v in values) if len(state) == 1 else (),
        accuracy=table.number("accuracy", lower=0.0, upper=0.2) if "accuracy" in table else 0.02,
    )
    table.finish()
    return effect


def _state(table: TableReader, signals: Sequence[str]) -> dict[str, tuple[float, ...]]:
    """A value in which the effect is not linear: its name, with those to choose from; empty without one."""
    if "try" not in table:
        return {}
    one = table.table("try")
    name = one.text("name")
    if not _VALUE.fullmatch(name) or name in signals:
        raise one.fail(
            "name", f"{name[:30]!r} can't be a value's name", "use letters, digits and _, and no signal's name"
        )
    low, high = one.number("from", lower=1e-9, upper=1e9), one.number("to", lower=1e-9, upper=1e9)
    values = np.geomspace(low, high, one.integer("count", lower=1, upper=_MOST_TRIALS))
    one.finish()
    return {name: tuple(values.tolist())}


def _part(table: TableReader, cell: Cell, names: set[str]) -> _Part:
    name = table.text("name")
    if not _VALUE.fullmatch(name):
        raise table.fail("name", f"{name[:40]!r} can't be a parameter's name", "use letters, digits and _")
    moves = table.text("moves")
    linear = _is_linear(moves, cell)
    if linear is None:
        hint = "name an axis, drive AXIS, or a place such as root.z, tool.rx, A3.ry"
        raise table.fail("moves", f"{moves[:40]!r} is nothing that moves", hint)
    usual = table.number("usual", lower=1e-12, upper=1e6)
    low, high = table.number("lower", lower=-1e6, upper=0.0), table.number("upper", lower=0.0, upper=1e6)
    unit = table.text("unit", choices=("mm",) if linear else ("deg",))
    try:
        formula = parse_expression(table.text("by"), names)
    except ValueError as error:
        raise table.fail("by", str(error), "see camrob/gap/README.md for what a formula may hold") from None
    table.finish()
    inner: Callable[[float], float] = mm_to_m if linear else deg_to_rad
    parameter = EffectParameter(
        f"{name}_{unit}", unit, inner(usual), min(inner(low), -1e-9 * inner(usual)), max(inner(high), inner(usual))
    )
    return _Part(parameter, moves, formula)


def _is_linear(moves: str, cell: Cell) -> bool | None:
    """True for what moves in mm, False for what turns, None for a name that says nothing on this cell."""
    axis = moves.removeprefix("drive ")
    if axis in cell.axis_names:
        return bool(cell.joints[cell.index(axis)].prismatic)
    owner, _, part = moves.partition(".")
    if part not in PARTS or owner not in ("base", "root", "tool", *cell.axis_names):
        return None
    if owner in cell.axis_names:
        try:
            term_of(cell, moves)
        except LogError:
            return None
    return not part.startswith("r")


def _term(moves: str) -> str:
    """The error model's name of a twist."""
    return moves if "." in moves else f"{moves}.zero"


def _units_of(name: str, parts: Sequence[_Part]) -> Callable[[Sequence[Scene], State], tuple[Unit, ...]]:
    def units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
        """One unit of all parameters, where every log has the signals and what moves, and something shows."""
        for scene in scenes:
            for part in parts:
                drive = part.moves.startswith("drive ")
                if (drive and (scene.poses or scene.setpoint is None)) or (
                    not drive and _term(part.moves) not in scene.places
                ):
                    return ()
                signals = _signals(scene)
                if not part.formula.names <= {*signals, *state}:
                    return ()
        shown = [float(np.abs(_shape(s, p, state)).max(initial=0.0)) for s in scenes for p in parts]
        if all(np.isfinite(shown)) and max(shown) < _STILL:
            return ()
        return (Unit(name, _axis(parts), tuple(p.parameter for p in parts)),)

    return units


def _axis(parts: Sequence[_Part]) -> str:
    """The axis that all parameters move; "" for several, or a place."""
    axes = {p.moves.removeprefix("drive ").partition(".")[0] for p in parts}
    one = axes.pop() if len(axes) == 1 else ""
    return "" if one in ("base", "root", "tool") else one


def _columns_of(parts: Sequence[_Part]) -> Callable[[Scene, Unit, State], tuple[Column, ...]]:
    def columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
        """One column a parameter."""
        found = []
        for part in parts:
            shape = _shape(scene, part, state)
            if part.moves.startswith("drive "):
                found.append(Column(servo={part.moves.removeprefix("drive "): shape}))
            else:
                with np.errstate(invalid="ignore"):  # what is not finite is refused by the conformance check
                    found.append(Column(tcp=scene.place(_term(part.moves)) * shape[:, None]))
        return tuple(found)

    return columns


def _shape(scene: Scene, part: _Part, state: State) -> Array:
    """(N,) what a parameter is multiplied by; a signal that a withheld log lacks counts as 0 there."""
    given: dict[str, Array | float] = {name: 0.0 for name in part.formula.names}
    of_time: Mapping[str, Callable[[Array, float], Array]] = {
        "play": lambda u, width: u - max(width, 0.0) / 2.0 * play(u, scene.t, scene.pieces, max(width, 1e-9)),
        "lag": lambda u, tau: first_order(u[:, None], scene.t, scene.pieces, tau)[:, 0],
    }
    return part.formula.value({**given, **_signals(scene, part.formula.names), **state}, of_time, len(scene))


def _signals(scene: Scene, wanted: frozenset[str] | None = None) -> dict[str, Array]:
    """The signals that a log has, in the units of the trade; all names (with what is dear left empty) where none is asked for."""
    cell, out = scene.cell, {}
    ask = (lambda name: True) if wanted is None else wanted.__contains__
    for k, axis in enumerate(scene.axes):
        edge = m_to_mm if cell.joints[cell.index(axis)].prismatic else rad_to_deg
        for order, name in enumerate((axis, f"d{axis}", f"dd{axis}")):
            if ask(name) and not (order and scene.poses):
                values = scene.link[:, [k]]
                found = values if order == 0 or wanted is None else scene.velocity(values, order)
                out[name] = edge(found[:, 0])
        if ask(f"T_{axis}"):
            out[f"T_{axis}"] = scene.torque[:, k]
    out["t"] = scene.t
    for k, name in enumerate("xyz"):
        out[name] = m_to_mm(scene.nominal[:, k, 3])
    if ask("temp") and scene.temperature is not None:
        out["temp"] = scene.temperature
    if scene.force is not None:
        out |= {f"f{n}": scene.force[:, k] for k, n in enumerate("xyz")}
    return out
