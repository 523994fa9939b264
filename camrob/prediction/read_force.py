"""FORCE.toml: what pushes on the tool while it cuts; docs/reference/files.md is its contract."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.errors import InputError
from camrob.prediction.force_model import CuttingForce, CuttingForces, Milling, Stated
from camrob.prediction.materials import MATERIAL_DOUBT, MATERIALS
from camrob.toml.read_toml import read_toml
from camrob.toml.table_reader import TableReader
from camrob.units import mm_min_to_m_s, mm_to_m, um_to_m

__all__ = ["read_forces"]

_LAST_NUMBER = 10**6  # of a tool, as in set-ups
_MOST = 1e5  # N, and N/mm2 or N/mm of coefficients: beyond any cut
_SECONDS = 60.0  # a minute
_DOUBT = 0.25  # of a force: what coefficients of one alloy in several handbooks differ by
_SIDES = {"left": 1, "right": -1, "both": 0}
_SENSES = {"clockwise": 1, "counterclockwise": -1}
_KINDS = ("tangential", "radial", "axial")


def read_forces(path: Path) -> CuttingForces:
    """The forces of a file. Raises InputError with file and key for what is wrong."""
    path = Path(path)
    data = read_toml(path, InputError)
    table = TableReader(data, path, error=InputError)
    doubt = _doubt(table)
    fastest = float("inf")
    if "fastest_cut_mm_min" in table:
        fastest = mm_min_to_m_s(table.number("fastest_cut_mm_min", lower=1e-3, upper=1e6))
    by_number: dict[int | None, CuttingForce] = {}
    if isinstance(data.get("tool"), list):
        for tool in table.tables("tool"):
            number = tool.integer("number", lower=1, upper=_LAST_NUMBER)
            if number in by_number:
                raise tool.fail("number", f"{number} appears twice", "give what pushes on each tool once")
            own = _doubt(tool)
            by_number[number] = _force(tool, doubt if own is None else own, _give(tool))
            tool.finish()
    else:
        give = np.zeros(2)
        if "tool" in table:
            tool = table.table("tool")
            give = _give(tool)
            tool.finish()
        by_number[None] = _force(table, doubt, give)
    table.finish()
    return CuttingForces(path, by_number, fastest)


def _doubt(table: TableReader) -> float | None:
    return table.number("doubt", lower=0.0, upper=2.0) if "doubt" in table else None


def _give(table: TableReader) -> NDArray[np.float64]:
    """(2,) m/N that tool and holder yield across and along the tool."""
    keys = [f"{k}_um_n" for k in ("across", "along")]
    return um_to_m(np.array([table.number(k, lower=0.0, upper=1e3) if k in table else 0.0 for k in keys]))


def _force(table: TableReader, doubt: float | None, give: NDArray[np.float64]) -> CuttingForce:
    """What pushes on one tool, of the table that holds [mean] or [milling]."""
    if ("mean" in table) == ("milling" in table):
        what = "is given with [milling]" if "mean" in table else "is missing, and [milling] too: this is no force file"
        raise table.fail("mean", what, "give [mean] or [milling]")
    if "mean" in table:
        mean = table.table("mean")
        along = [mean.number(f"{k}_n", lower=-_MOST, upper=_MOST) for k in ("along", "across", "axial")]
        model: Stated | Milling = Stated(np.array(along))
        usual = _DOUBT
        mean.finish()
    else:
        milling = table.table("milling")
        usual = MATERIAL_DOUBT if "material" in milling else _DOUBT
        model = _milling(milling)
    return CuttingForce(table.path, model, usual if doubt is None else doubt, give)


def _milling(table: TableReader) -> Milling:
    named = [f"{k}_edge_n_mm" for k in _KINDS]
    name = table.text("material", choices=tuple(MATERIALS)) if "material" in table else ""
    if name:
        material = MATERIALS[name]
        for key in (*(f"{k}_n_mm2" for k in _KINDS), *named):
            if key in table:
                raise table.fail(key, "is given beside material", "give the material, or all coefficients")
        chip, edge = np.array(material.chip), np.array(material.edge)
    else:
        chip = np.array([table.number(f"{k}_n_mm2", lower=-_MOST, upper=_MOST) for k in _KINDS])
        edge = np.array([table.number(k, lower=-_MOST, upper=_MOST) if k in table else 0.0 for k in named])
    diameter = mm_to_m(table.number("diameter_mm", lower=1e-3, upper=1e3))
    depth, width = (
        mm_to_m(table.number(k, lower=1e-4, upper=1e3)) if k in table else float("nan")
        for k in ("depth_mm", "width_mm")
    )
    if width > diameter:
        raise table.fail("width_mm", "is more than the tool's diameter", "give what the tool takes of it in one pass")
    side = _SIDES[table.text("side", choices=tuple(_SIDES))] if "side" in table else 0
    sense = _SENSES[table.text("turns", choices=tuple(_SENSES))] if "turns" in table else 1
    made = Milling(
        chip=chip / mm_to_m(1.0) ** 2,
        edge=edge / mm_to_m(1.0),
        teeth=table.integer("teeth", lower=1, upper=64),
        diameter=diameter,
        rate=table.number("spindle_rpm", lower=1.0, upper=1e6) / _SECONDS,
        side=side,
        sense=sense,
        depth=depth,
        width=width,
        material=name,
    )
    table.finish()
    return made
