"""A cell's known truths: poses.csv beside cell.toml, held against the chain whenever the cell is read."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.cell.status_turn import StatusTurn
from camrob.cell.world import segments
from camrob.errors import CellError
from camrob.se3 import abc_to_rotation, angle_between
from camrob.text import bytes_of
from camrob.units import deg_to_rad, m_to_mm, mm_to_m, rad_to_deg

__all__ = ["POSES_FILE", "PoseBounds", "PoseError", "check_poses", "coupled_axes", "pose_errors"]

Array = NDArray[np.float64]

POSES_FILE = "poses.csv"
_LARGEST = 10_000_000  # bytes; a file of truths has some dozen rows
_PLACE = ("x_mm", "y_mm", "z_mm")
_TURN = ("a_deg", "b_deg", "c_deg")
_AXIS = ("tool_z_x", "tool_z_y", "tool_z_z")
_TEXTS = ("name", "source", "note")
_ARM = 6  # axes
_COUPLED = ((2, 1), (4, 3), (5, 4), (5, 3))  # arm axes, and those that some controllers count them with
# poses in which the other axis has to be turned by so many degrees, so that they say anything of it
_TELLING, _TURNED = 2, 1.0


@dataclass(frozen=True, slots=True)
class PoseBounds:
    """By how much a cell may miss its poses: the tool and each axis in m and rad, 1/k_F (given with four digits)."""

    position: float
    angle: float
    inv_kf: float


@dataclass(frozen=True, slots=True)
class PoseError:
    """How a cell meets one pose: position error m, angle rad, of the tool from forward kinematics of the row's axis values.

    disagrees: how the row's axis values and its q contradict each other by the cell; missed: what is beyond the bounds, or is
    another 1/k_F, S or T. Both "" where the cell meets the row. line: of the file.
    """

    line: int
    name: str
    position: float
    angle: float
    disagrees: str
    missed: str


@dataclass(frozen=True, slots=True)
class _Row:
    """One row: its line, its name, and the numbers of the columns that are not empty."""

    line: int
    name: str
    numbers: dict[str, float]

    def some(self, columns: tuple[str, ...], path: Path) -> Array | None:
        """The numbers of columns that belong together, None where all are empty. Raises CellError for a part of them."""
        given = [c for c in columns if c in self.numbers]
        if given and len(given) < len(columns):
            missing = next(c for c in columns if c not in self.numbers)
            raise self.fail(f"gives {given[0]} without {missing}", "fill in both, or neither", path)
        return np.array([self.numbers[c] for c in columns]) if given else None

    def fail(self, what: str, hint: str, path: Path) -> CellError:
        return CellError(f"pose {self.name[:40]!r} {what}", hint=hint, path=path, line=self.line)


def check_poses(cell: Cell, path: Path, bounds: PoseBounds) -> None:
    """Hold a cell against its poses.csv at `path`; nothing happens where there is no such file.

    Raises CellError that names file and line for a file that can't be read, and pose and error for one that the cell
    misses.
    """
    errors = pose_errors(cell, path, bounds)
    hint = "correct cell.toml or the row"
    for error in errors:
        if error.disagrees:
            raise CellError(f"pose {error.name[:40]!r} {error.disagrees}", hint=hint, path=path, line=error.line)
    missed = [error for error in errors if error.missed]
    if missed:
        others = f" (and {len(missed) - 1} more of the {len(errors)} poses)" if len(missed) > 1 else ""
        what = f"pose {missed[0].name[:40]!r} is not where cell.toml puts it: {missed[0].missed}{others}"
        raise CellError(what, hint=coupled_axes(cell, path, bounds) or hint, path=path, line=missed[0].line)


def pose_errors(cell: Cell, path: Path, bounds: PoseBounds) -> tuple[PoseError, ...]:
    """How a cell meets each pose of its poses.csv at `path`, in the file's order; none where there is no such file.

    Raises CellError that names file and line for a file that can't be read.
    """
    if not path.exists():
        return ()
    rows = list(_rows(cell, path))
    if not rows:
        raise CellError("holds no pose", hint="write a row for each, or remove the file", path=path)
    found_of = [_posture(cell, row, path, bounds) for row in rows]
    q = np.stack([posture for posture, _ in found_of])
    base_T_tool, inverse_kf = _walk(cell, q)
    status, turn = _status_of(cell, q)
    errors = []
    for k, row in enumerate(rows):
        if status is None and "S" in row.numbers:
            raise row.fail("has S, for which the wrist must be spherical", "leave S empty", path)
        if np.isnan(inverse_kf[k]) and "inv_kf" in row.numbers:
            raise row.fail("has inv_kf, for which the arm must have six axes", "leave inv_kf empty", path)
        off, turned = _off(row, base_T_tool[k])
        found = _missed(row, base_T_tool[k], off, turned, path, bounds)
        given = {"S": 0 if status is None else status[k], "T": turn[k], "inv_kf": inverse_kf[k]}
        for key, value in given.items():
            stated = row.numbers.get(key, value)
            if not found and abs(stated - value) > (bounds.inv_kf if key == "inv_kf" else 0.0):
                found = f"{key} is {value:.4g}, not {stated:g}"
        errors.append(PoseError(row.line, row.name, off, turned, found_of[k][1], found))
    return tuple(errors)


def coupled_axes(cell: Cell, path: Path, bounds: PoseBounds) -> str:
    """That a cell which misses its poses would meet all that give axis values if one arm axis were counted with another, as
    controllers of parallel-link arms count A3 and as some wrists do; "" where no such two axes explain them.
    """
    names = cell.axis_names
    arm = [k for k, name in enumerate(names) if cell.joints[cell.index(name)].role is Role.ARM]
    rows = [row for row in _rows(cell, path) if row.some(_axis_columns(cell), path) is not None]
    if not rows or len(arm) < _ARM:
        return ""
    values = np.stack([np.asarray(row.some(_axis_columns(cell), path)) for row in rows])
    for turned, by in _COUPLED:
        one, other = arm[turned], arm[by]
        if np.sum(np.abs(values[:, other]) > _TURNED) < _TELLING:
            continue
        for sign, word in ((1.0, "+"), (-1.0, "-")):
            counted = values.copy()
            counted[:, one] += sign * values[:, other]
            q = np.stack(
                [cell.to_q(v, roll=r.numbers.get("q_roll_rad", 0.0)) for v, r in zip(counted, rows, strict=True)]
            )
            tools = _walk(cell, q)[0]
            if not any(_missed(row, T, *_off(row, T), path, bounds) for row, T in zip(rows, tools, strict=True)):
                return (
                    f"all poses are met with {names[one]} {word} {names[other]} in {names[one]}'s place: the controller counts "
                    f"{names[one]} with {names[other]} (a parallel-link arm, or a coupled wrist), and no cell can say so: "
                    "a program written for it would run at other angles"
                )
    return ""


def _rows(cell: Cell, path: Path) -> Iterator[_Row]:
    """The file's rows, checked."""
    try:
        data = bytes_of(path, _LARGEST)
        text = data[:_LARGEST].decode("utf-8-sig")
    except OSError as e:
        raise CellError(f"can't be read ({e.strerror})", hint="check the file", path=path) from None
    except UnicodeDecodeError:
        raise CellError("is not UTF-8 text", hint="save it as UTF-8", path=path) from None
    if len(data) > _LARGEST:
        raise CellError(f"is larger than {_LARGEST // 10**6} MB", hint="keep some dozen poses", path=path)
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    header: list[str] | None = None
    seen: set[str] = set()
    try:
        for cells in reader:
            if not any(c.strip() for c in cells):
                continue
            if header is None:
                header = _header(cell, [c.strip() for c in cells], path, reader.line_num)
                continue
            row = _row(header, cells, path, reader.line_num)
            if row.name in seen:
                raise row.fail("appears twice", "give every pose a name of its own", path)
            seen.add(row.name)
            yield row
    except csv.Error as e:
        raise CellError(f"is not CSV: {e}", hint="correct that line", path=path, line=reader.line_num) from None


def _axis_columns(cell: Cell) -> tuple[str, ...]:
    """Columns of the axis values, in the order of `Cell.axis_names`."""
    return tuple(f"{n}_{cell.joints[cell.index(n)].unit}" for n in cell.axis_names)


def _q_columns(cell: Cell) -> tuple[str, ...]:
    """Columns of the chain's q of the real joints, in the chain's order."""
    return tuple(f"q_{j.name}_{'m' if j.prismatic else 'rad'}" for j in cell.joints if j.role is not Role.ROLL)


def _header(cell: Cell, names: list[str], path: Path, line: int) -> list[str]:
    """The header row, each name known and there once."""
    roll = ("q_roll_rad",) if cell.indices(Role.ROLL) else ()
    known = (*_TEXTS, *_axis_columns(cell), *_q_columns(cell), *roll, *_PLACE, *_TURN, *_AXIS, "inv_kf", "S", "T")
    for k, name in enumerate(names):
        for other, word in ((";", "semicolons"), ("\t", "tabs")):
            if len(names) == 1 and other in name:
                hint = "separate columns by commas, and write decimals with a point"
                raise CellError(f"separates columns by {word}", hint=hint, path=path, line=line)
        if name not in known:
            raise CellError(
                f"{name[:40]!r} is not a column for this cell", hint=f"use {', '.join(known)}", path=path, line=line
            )
        if name in names[:k]:
            raise CellError(f"the column {name} appears twice", hint="leave one", path=path, line=line)
    for name in ("name", *_PLACE, *_TURN):
        if name not in names:
            raise CellError(
                f"the column {name} is missing", hint=f"give name, {', '.join((*_PLACE, *_TURN))}", path=path, line=line
            )
    return names


def _row(header: list[str], cells: list[str], path: Path, line: int) -> _Row:
    """One row's numbers."""
    if len(cells) != len(header):
        what = f"has {len(cells)} columns where the first line has {len(header)}"
        commas = len(cells) > len(header)
        hint = "where decimals are written with commas, write points" if commas else "correct that line"
        raise CellError(what, hint=hint, path=path, line=line)
    entries = {name: entry.strip() for name, entry in zip(header, cells, strict=True)}
    row = _Row(line, entries["name"], {})
    if not row.name:
        raise CellError("a pose has no name", hint="give it one", path=path, line=line)
    for name, entry in entries.items():
        if name in _TEXTS or not entry:
            continue
        try:
            row.numbers[name] = float(entry)
        except ValueError:
            row.numbers[name] = math.nan
        if not math.isfinite(row.numbers[name]):
            raise row.fail(f"has {entry[:40]!r} as {name}", "give a finite number, or leave it empty", path)
    if row.some((*_PLACE, *_TURN), path) is None:
        raise row.fail("says nothing about the tool", f"fill in {', '.join((*_PLACE, *_TURN))}", path)
    return row


def _posture(cell: Cell, row: _Row, path: Path, bounds: PoseBounds) -> tuple[Array, str]:
    """The row's posture (n,), and how its axis values and q disagree where both are given: then it is that of the axis values."""
    axes, stated = row.some(_axis_columns(cell), path), row.some(_q_columns(cell), path)
    roll = row.numbers.get("q_roll_rad", 0.0)
    if axes is None and stated is None:
        raise row.fail("says nothing about the axes", f"fill in {', '.join(_axis_columns(cell))}", path)
    real = [i for i, j in enumerate(cell.joints) if j.role is not Role.ROLL]
    q = np.full(len(cell), roll)
    if axes is not None:
        q = cell.to_q(axes, roll=roll)
    if stated is None:
        return q, ""
    if axes is not None:
        for i, value in zip(real, stated, strict=True):
            joint, off = cell.joints[i], abs(float(q[i] - value))
            if off > (bounds.position if joint.prismatic else bounds.angle):
                by = f"{joint.to_edge(off):.3f} {joint.unit_word}"
                return q, (
                    f"has axis values whose {joint.name} is {by} off its q: sign or offset of the axis is not the file's"
                )
    q[real] = stated
    return q, ""


def _walk(cell: Cell, q: Array) -> tuple[Array, Array]:
    """Poses of the tool in `base` (N, 4, 4) and 1/k_F of the bare arm at the mounting plate (N,), of postures (N, n).

    NaN where the arm's Jacobian is not square: k_F is asked of six axes.
    """
    base_T_next = np.broadcast_to(np.eye(4), (len(q), 4, 4))
    axes: list[tuple[Array, Array]] = []
    plate = np.zeros((len(q), 3))
    for segment in segments(cell):
        base_T_next = base_T_next @ segment.parent_T_joint
        if segment.link == "flange":
            plate = base_T_next[:, :3, 3]
        if segment.joint is None:
            continue
        if segment.joint.role is Role.ARM:
            axes.append((base_T_next[:, :3, 2], base_T_next[:, :3, 3]))
        base_T_next = base_T_next @ segment.joint.motion(q[:, cell.index(segment.joint.name)])
    columns = [np.concatenate([np.cross(z, plate - p) / cell.condition_length, z], axis=1) for z, p in axes]
    H = np.stack(columns, axis=2)
    if H.shape[2] != H.shape[1]:
        return np.asarray(base_T_next), np.full(len(q), np.nan)
    least = np.linalg.svd(H, compute_uv=False)[:, -1]
    regular = least > 1e-12
    inverse_kf = np.zeros(len(q))
    norms = np.linalg.norm(H[regular], axis=(1, 2)) * np.linalg.norm(np.linalg.inv(H[regular]), axis=(1, 2))
    inverse_kf[regular] = 6.0 / norms
    return np.asarray(base_T_next), inverse_kf


def _off(row: _Row, base_T_tool: Array) -> tuple[float, float]:
    """How far the tool is from the row's pose, m and rad."""
    place, turn = (np.array([row.numbers[c] for c in columns]) for columns in (_PLACE, _TURN))
    off = float(np.linalg.norm(base_T_tool[:3, 3] - mm_to_m(place)))
    return off, float(angle_between(abc_to_rotation(deg_to_rad(turn)), base_T_tool[:3, :3]))


def _missed(row: _Row, base_T_tool: Array, off: float, turned: float, path: Path, bounds: PoseBounds) -> str:
    """How the tool, `off` m and `turned` rad away, misses the row's pose, "" where it does not."""
    if off > bounds.position or turned > bounds.angle:
        x, y, z = (f"{v:.3f}" for v in m_to_mm(base_T_tool[:3, 3]))
        return f"the tool is {m_to_mm(off):.3f} mm and {rad_to_deg(turned):.3f} degrees off, at X {x}, Y {y}, Z {z}"
    along = row.some(_AXIS, path)
    if along is not None:
        tilt = float(np.linalg.norm(np.cross(along, base_T_tool[:3, 2])))
        if tilt > bounds.angle or along @ base_T_tool[:3, 2] <= 0.0 or abs(np.linalg.norm(along) - 1.0) > bounds.angle:
            return f"its tool_z is {rad_to_deg(tilt):.3f} degrees off, or no unit vector"
    return ""


def _status_of(cell: Cell, q: Array) -> tuple[list[int] | None, list[int]]:
    """Status and Turn of postures (N, n); no Status where the wrist is not spherical."""
    axes = np.round(cell.to_axis_values(q)[:, :6], 9) + 0.0
    turn = StatusTurn.turn(axes).tolist()
    try:
        return StatusTurn.of(cell).status(axes).tolist(), turn
    except CellError:
        return None, turn
