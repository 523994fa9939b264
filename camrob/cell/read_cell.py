"""Reading a cell's folder: cell.toml, checked key by key, edge units to SI, the provenance of every number kept."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.cell.bare_arm import BareArm, read_bare_arm
from camrob.cell.cell import Cell
from camrob.cell.cell_file import cell_file, without_schema
from camrob.cell.controller_settings import ControllerSettings
from camrob.cell.joint import Joint, Role
from camrob.cell.load import PointMass
from camrob.cell.poses import POSES_FILE, PoseBounds, check_poses
from camrob.cell.read_controller import read_controller
from camrob.cell.read_joint import check_chain, read_joint
from camrob.cell.redundancy_settings import CONDITION_TERMS, TABLES, FuzzyEngine, ResolveSettings
from camrob.cell.shape import Shape, ShapeKind
from camrob.se3 import frame_from_mm_deg
from camrob.toml.read_toml import read_toml
from camrob.toml.table_reader import Faults, TableReader
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["read_cell", "unchecked_cell"]

Array = NDArray[np.float64]

SCHEMA = 1
_LENGTH = 0.4  # m, the characteristic length of a cell that doesn't say
SHAPE_FRAMES = ("world", "base", "root", "flange", "tool")
JOB_GROUPS = ("part", "stock")  # bodies that a job brings, not the cell
MOST_ARM = 7  # axes of an arm that a log names
_SIZES = {ShapeKind.BOX: 3, ShapeKind.CYLINDER: 2, ShapeKind.CAPSULE: 2, ShapeKind.SPHERE: 1}


def read_cell(path: str | Path) -> Cell:
    """The cell in a folder (or of a cell.toml), held against the poses.csv beside it.

    Args:
        path: the folder, or its cell.toml.

    Returns:
        The cell, in SI.

    Raises:
        CellError: what the file lacks or has wrong, by key, or the pose of poses.csv that the cell misses.

    Example:
        >>> cell = camrob.read_cell(Path("cells/kr15_track_table"))
        >>> cell.name, cell.axis_names[-2:]
        ('kr15_track_table', ('E1', 'E2'))
    """
    cell, bounds = unchecked_cell(path)
    check_poses(cell, cell.folder / POSES_FILE, bounds)
    return cell


def unchecked_cell(path: str | Path) -> tuple[Cell, PoseBounds]:
    """The cell of a cell.toml by itself, and how well it has to meet its poses. Raises CellError."""
    path = Path(path)
    file = cell_file(path)
    table = TableReader(read_toml(file), file, needs_provenance=True)
    if "schema" not in table:
        raise without_schema(table, SCHEMA)
    table.integer("schema", lower=SCHEMA, upper=SCHEMA)
    return _assembled(table, file.parent)


def _assembled(table: TableReader, folder: Path) -> tuple[Cell, PoseBounds]:
    """The cell of a file, and how well it has to meet its poses; what is wrong in each table is reported together.

    A cell without [controller] and [resolve] is measured, not programmed: of it, the chain is enough.
    """
    wrong = Faults()
    measured = "controller" not in table and "resolve" not in table
    listed = wrong.each(table.tables("joint"), lambda t: read_joint(t, measured=measured))
    none: list[BareArm] = []
    no_shapes: tuple[Shape, ...] = ()
    bare = wrong.of(lambda: [read_bare_arm(table.table("arm"), folder)], none) if "arm" in table else none
    if bare and not measured:
        wrong.of(lambda: _refuse_in_short(table), None)
    joints = tuple(j for j in listed if j.role is not Role.ROLL) + tuple(j for b in bare for j in b.joints)
    joints += tuple(j for j in listed if j.role is Role.ROLL)
    if not wrong.found:  # a joint that is wrong is one that is missing
        wrong.of(lambda: check_chain(joints, table), None)
    frames = wrong.of(lambda: _frames(table, measured=measured), _Frames())
    tool = wrong.of(lambda: _tool(table, measured=measured), np.eye(4))
    payload = wrong.of(lambda: _payload(table, measured=measured), 0.0)
    bounds = wrong.of(lambda: _pose_bounds(table), PoseBounds(0.0, 0.0, 0.0))
    name = wrong.of(lambda: _name(table), "")
    title = wrong.of(lambda: table.text("title") if "title" in table or not measured else name, "")
    wrong.raise_any()  # what follows speaks of joints
    names = tuple(j.name for j in joints)
    controller = wrong.of(lambda: _controller(table, joints), None)
    resolve = wrong.of(lambda: _resolve(table.table("resolve"), names) if "resolve" in table else None, None)
    shapes = wrong.of(lambda: _shapes(table, folder, names), no_shapes)
    masses = wrong.each(table.tables("mass"), lambda t: _mass(t, names))
    wrong.of(table.finish, None)
    wrong.raise_any()
    last = np.linalg.multi_dot([np.eye(4), *(b.wrist_T_flange for b in bare), frames.wrist_T_flange])
    cell = Cell(
        name=name,
        title=title,
        folder=folder,
        joints=joints,
        base_T_first=frames.base_T_first,
        foot_T_root=frames.foot_T_root,
        wrist_T_flange=last,
        flange_T_tool=tool,
        condition_length=frames.length,
        base_follows_table=frames.follows_table,
        controller_section=controller,
        resolve_section=resolve,
        shapes=shapes,
        masses=(*(m for b in bare for m in b.masses), *masses),
        payload=payload,
        provenance=table.provenance,
    )
    return cell, bounds


@dataclass(frozen=True)
class _Frames:
    """[kinematics]; each at its ordinary value."""

    base_T_first: Array = field(default_factory=lambda: np.eye(4))
    foot_T_root: Array = field(default_factory=lambda: np.eye(4))
    wrist_T_flange: Array = field(default_factory=lambda: np.eye(4))
    length: float = _LENGTH
    follows_table: bool = False


def _frames(table: TableReader, *, measured: bool) -> _Frames:
    """[kinematics]. measured: every key may be left out."""
    if measured and "kinematics" not in table:
        return _Frames()
    part = table.table("kinematics")

    def frame(key: str) -> Array:
        return np.eye(4) if measured and key not in part else frame_from_mm_deg(part.vector(key, 6))

    follows = False if measured and "base_follows_table" not in part else part.flag("base_follows_table")
    placed = frame("base_to_first"), frame("foot_to_root"), frame("wrist_to_flange")
    plain = measured and "characteristic_length_mm" not in part
    length = _LENGTH if plain else mm_to_m(part.number("characteristic_length_mm", lower=1.0, upper=1e5))
    part.finish()
    return _Frames(*placed, length, follows)


def _refuse_in_short(table: TableReader) -> None:
    """Raise CellError: an arm in short has no limits and no HOME, which whoever makes programs needs."""
    what = "is for a cell that is only measured: programs need each axis's limits and HOME, which it doesn't have"
    hint = 'write each axis as a [[joint]] of role arm (dh takes convention = "modified", too), '
    hint += "or leave [controller] and [resolve] out"
    raise table.fail("arm", what, hint)


def _name(table: TableReader) -> str:
    """The cell's name."""
    name = table.text("name")
    if not name.strip():
        raise table.fail("name", "is empty", "give a short name")
    return name


def _tool(table: TableReader, *, measured: bool) -> Array:
    """[tool]."""
    if measured and "tool" not in table:
        return np.eye(4)
    part = table.table("tool")
    frame = frame_from_mm_deg(part.vector("flange_to_tool", 6))
    part.finish()
    return frame


def _payload(table: TableReader, *, measured: bool) -> float:
    """[load], kg."""
    if measured and "load" not in table:
        return 0.0
    part = table.table("load")
    payload = part.number("payload_kg", lower=0.0, upper=1e5)
    part.finish()
    return payload


def _controller(table: TableReader, joints: tuple[Joint, ...]) -> ControllerSettings | None:
    """[controller], where there is one."""
    if "controller" not in table:
        return None
    return read_controller(table.table("controller"), joints)


def _pose_bounds(table: TableReader) -> PoseBounds:
    """[poses], which may be left out."""
    found = {"position_mm": 0.5, "angle_deg": 0.05, "inv_kf": 1e-4}
    if "poses" in table:
        part = table.table("poses", needs_provenance=False)
        for key, most in (("position_mm", 10.0), ("angle_deg", 1.0), ("inv_kf", 0.01)):  # more finds no slip any more
            found[key] = part.number(key, lower=1e-6, upper=most) if key in part else found[key]
        part.finish()
    return PoseBounds(mm_to_m(found["position_mm"]), deg_to_rad(found["angle_deg"]), found["inv_kf"])


def _mass(table: TableReader, names: tuple[str, ...]) -> PointMass:
    """One [[mass]]."""
    mass = PointMass(
        table.text("name"),
        table.text("after", choices=names),
        table.number("mass_kg", lower=0.0, upper=1e5),
        mm_to_m(table.vector("center_mm", 3)),
    )
    table.finish()
    return mass


def _shapes(table: TableReader, folder: Path, names: tuple[str, ...]) -> tuple[Shape, ...]:
    """All [[shape]]s; names are unique, and `ignore` names groups that there are."""
    tables = table.tables("shape")
    shapes = tuple(_shape(t, folder, names) for t in tables)
    for part, shape in zip(tables, shapes, strict=True):
        if shape.group in JOB_GROUPS:
            raise part.fail("group", f"is {shape.group!r}, which stands for the job's own bodies", "use another word")
    groups = sorted({s.group for s in shapes} | set(JOB_GROUPS))
    for i, (part, shape) in enumerate(zip(tables, shapes, strict=True)):
        if any(shape.name == s.name for s in shapes[:i]):
            raise part.fail("name", "appears twice", "give every shape a name of its own")
        for group in shape.ignore:
            if group not in groups:
                raise part.fail("ignore", f"{group[:40]!r} is not a group of this cell", f"use {', '.join(groups)}")
    return shapes


def _shape(table: TableReader, folder: Path, names: tuple[str, ...]) -> Shape:
    """One [[shape]]."""
    kind = ShapeKind(table.text("kind", choices=tuple(k.value for k in ShapeKind)))
    file = ""
    if kind is ShapeKind.MESH:
        file = table.text("file")
        if not os.path.isfile(folder / file) or ".." in Path(file).parts or Path(file).is_absolute():
            raise table.fail("file", f"{file[:60]!r} is not a file in the cell's folder", "put the mesh there")
        size = np.array([table.number("scale", lower=1e-6, upper=1e6)])
    else:
        size = mm_to_m(table.vector("size_mm", _SIZES[kind]))
        if np.any(size <= 0.0):
            raise table.fail("size_mm", "is not above 0", "give the body's real size")
    shape = Shape(
        name=table.text("name"),
        group=table.text("group"),
        frame=table.text("frame", choices=(*SHAPE_FRAMES, *names)),
        kind=kind,
        size=size,
        frame_T_shape=frame_from_mm_deg(table.vector("at", 6)),
        file=file,
        ignore=table.texts("ignore") if "ignore" in table else (),
    )
    table.finish()
    return shape


def _resolve(table: TableReader, names: tuple[str, ...]) -> ResolveSettings:
    """[resolve] with its two engines."""
    engines = []
    for key in ("joint_engine", "condition_engine"):
        if key not in table:
            engines.append(FuzzyEngine("", {}))
            continue
        part = table.table(key)
        weights = part.text_map("weights")
        for joint in weights:
            if joint not in names:
                raise part.fail(f"weights.{joint}", "is not a joint of this cell", f"use {', '.join(names)}")
        nodes = part.text("table", choices=TABLES) if "table" in part else TABLES[0]
        engines.append(
            FuzzyEngine(part.text("file"), weights, part.number("default_weight", lower=1e-6, upper=1e3), nodes)
        )
        part.finish()
    planned: dict[str, float] = {}
    if "planned" in table:
        part = table.table("planned")
        planned = {key: part.number(key, lower=0.0) for key in part.keys()}
    term = table.text("condition_term", choices=CONDITION_TERMS) if "condition_term" in table else CONDITION_TERMS[0]
    settings = ResolveSettings(table.number("threshold", lower=0.0, upper=1.0), engines[0], engines[1], planned, term)
    table.finish()
    return settings
