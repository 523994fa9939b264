"""published.toml: a published calibration, and the simulated robot that it is repeated with."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.errors import InputError
from camrob.frozen import locked
from camrob.toml.read_toml import read_toml
from camrob.toml.table_reader import TableReader
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["PUBLISHED", "PublishedCase", "own_case", "read_published"]

Array = NDArray[np.float64]

PUBLISHED = "published.toml"
"""The file of a cell's folder that has the case."""

SCHEMA = 1


@dataclass(frozen=True, slots=True)
class PublishedCase:
    """A published case, SI but for what the paper prints.

    before, after: published mean errors, mm and degrees; iterations: those of the published compensation, from and to.
    place, angle, ripple, last_ripple: deviations of the drawn errors, m and rad; ripple_orders of all axes, another size on
    the last; compliance: an axis's mean, rad/Nm, with a relative spread. poses, withheld: how many are measured, with sigma
    (m, rad), between lower and upper axis values (degrees). line: middle posture (degrees), direction, points, step (m).
    """

    title: str
    source: str
    before: tuple[float, float]
    after: tuple[float, float]
    iterations: tuple[int, int]
    seed: int
    place: float
    angle: float
    ripple_orders: int
    ripple: float
    last_ripple: float
    compliance: dict[str, float]
    compliance_spread: float
    poses: int
    withheld: int
    sigma: tuple[float, float]
    lower_deg: Array
    upper_deg: Array
    middle_deg: Array
    direction: Array
    points: int
    step: float

    def __post_init__(self) -> None:
        count = len(self.lower_deg)
        for name, length in (("lower_deg", count), ("upper_deg", count), ("middle_deg", count), ("direction", 3)):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(length,), name=name))


def own_case(cell: Cell) -> PublishedCase:
    """The case in the cell's own folder. Raises InputError, also where it has none."""
    if not (cell.folder / PUBLISHED).is_file():
        raise InputError(
            f"this cell has no {PUBLISHED}, the published case that the study repeats",
            hint="add it, as in cells/kr500_afp, or take that cell",
            path=cell.folder,
        )
    return read_published(cell.folder / PUBLISHED, cell)


def read_published(path: Path, cell: Cell) -> PublishedCase:
    """The case in a file, for a cell without external axes. Raises InputError naming file, key and hint."""
    if cell.external_names:
        hint = "give a cell without external axes"
        raise InputError(f"is of an arm alone, and {cell.name} has external axes", hint=hint, path=path)
    table = TableReader(read_toml(path, InputError), path, error=InputError)
    table.integer("schema", lower=SCHEMA, upper=SCHEMA)
    title, source = table.text("title"), table.text("source")
    published, robot = table.table("published"), table.table("robot")
    measured, line = table.table("measured"), table.table("line")
    stiff = robot.table("compliance_rad_nm")
    axes = [j.name for j in cell.joints if j.role is Role.ARM]
    iterations = published.vector("iterations", 2)
    direction = line.vector("direction", 3)
    if not np.linalg.norm(direction) > 0.0:
        raise line.fail("direction", "has no length", "give a vector")
    lower, upper = measured.vector("lower_deg", len(axes)), measured.vector("upper_deg", len(axes))
    if not np.all(lower < upper):
        raise measured.fail("upper_deg", "isn't above lower_deg for every axis", "give an axis's lower value first")
    case = PublishedCase(
        title=title,
        source=source,
        before=_means(published.table("before")),
        after=_means(published.table("after")),
        iterations=(int(iterations[0]), int(iterations[1])),
        seed=robot.integer("seed", lower=0, upper=2**31),
        place=mm_to_m(robot.number("place_mm", lower=0.0)),
        angle=deg_to_rad(robot.number("angle_deg", lower=0.0)),
        ripple_orders=robot.integer("ripple_orders", lower=1, upper=12),
        ripple=deg_to_rad(robot.number("ripple_deg", lower=0.0)),
        last_ripple=deg_to_rad(robot.number("last_ripple_deg", lower=0.0)),
        compliance={axis: stiff.number(axis, lower=0.0) for axis in axes[1:]},
        compliance_spread=robot.number("compliance_spread", lower=0.0, upper=1.0),
        poses=measured.integer("poses", lower=20, upper=100_000),
        withheld=measured.integer("withheld", lower=20, upper=100_000),
        sigma=(
            mm_to_m(measured.number("sigma_mm", lower=1e-6)),
            deg_to_rad(measured.number("sigma_deg", lower=1e-7)),
        ),
        lower_deg=lower,
        upper_deg=upper,
        middle_deg=line.vector("middle_deg", len(axes)),
        direction=direction / np.linalg.norm(direction),
        points=line.integer("points", lower=9, upper=100_000),
        step=mm_to_m(line.number("step_mm", lower=1e-3)),
    )
    for part in (table, published, robot, stiff, measured, line):
        part.finish()
    return case


def _means(table: TableReader) -> tuple[float, float]:
    """Mean errors as they are printed, mm and degrees."""
    return table.number("mm", lower=0.0), table.number("deg", lower=0.0)
