"""CALIBRATION.toml: written for people and programs, read back strictly."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np

from camrob.calibration.calibration import Calibration, ErrorSize, Held
from camrob.calibration.parameters import ParameterSet
from camrob.calibration.terms import parameter_of
from camrob.cell.cell import Cell
from camrob.errors import LogError, StaleInputError
from camrob.summaries.calibration_summary import (
    CalibrationFigures,
    Correlation,
    ErrorFigures,
    FittedParameter,
    HeldParameter,
    Observability,
    UsedLog,
)
from camrob.summaries.remarks import Remark
from camrob.text import one_line
from camrob.toml.read_toml import read_toml
from camrob.toml.table_reader import TableReader
from camrob.units import deg_to_rad, m_to_mm, mm_to_m, rad_to_deg

__all__ = ["calibration_figures", "calibration_text", "edge_value", "read_calibration"]

SCHEMA = 1
_EDGE = {"m": "mm", "rad": "deg"}


def edge_value(value: float, unit: str) -> float:
    """A parameter's value in the unit of the trade: mm and degrees, else as it is."""
    return m_to_mm(value) if unit == "m" else rad_to_deg(value) if unit == "rad" else value


def _inner_value(value: float, unit: str) -> float:
    return mm_to_m(value) if unit == "m" else deg_to_rad(value) if unit == "rad" else value


def _number(value: float) -> str:
    return repr(float(value)) if math.isfinite(value) else "nan"


def _size(size: ErrorSize) -> ErrorFigures:
    """An error's sizes in mm and degrees, None for what was not measured."""

    def degrees(angle: float) -> float | None:
        return None if math.isnan(angle) else rad_to_deg(angle)

    return ErrorFigures(
        poses=size.rows,
        mean_mm=m_to_mm(size.mean),
        rms_mm=m_to_mm(size.rms),
        p95_mm=m_to_mm(size.p95),
        max_mm=m_to_mm(size.worst),
        mean_deg=degrees(size.mean_angle),
        max_deg=degrees(size.worst_angle),
    )


def calibration_figures(calibration: Calibration) -> CalibrationFigures:
    """The calibration in the units of the trade."""
    c = calibration
    o1, o2, o3, o4, o5 = c.observability
    return CalibrationFigures(
        cell=c.cell_name,
        logs=tuple(UsedLog(file=name, digest=digest) for name, digest in c.logs),
        poses=c.rows,
        left_out=c.left_out,
        outliers=c.outliers,
        oriented=c.oriented,
        errors={stage: _size(size) for stage, size in c.errors.items()},
        scatter_mm=m_to_mm(c.scatter_position),
        scatter_deg=None if math.isnan(c.scatter_angle) else rad_to_deg(c.scatter_angle),
        parameters=tuple(
            FittedParameter(
                name=p.name,
                value=edge_value(p.value, p.unit),
                std=edge_value(p.std, p.unit),
                unit=_EDGE.get(p.unit, p.unit),
                nuisance=p.name in c.nuisance,
            )
            for p in c.parameters.items_
        ),
        held=tuple(HeldParameter(name=h.name, why=h.why, others=h.others) for h in c.held),
        correlations=tuple(Correlation(pair=(a, b), value=r) for a, b, r in c.correlations),
        condition=c.condition,
        observability=Observability(o1=o1, o2=o2, o3=o3, o4=o4, o5=o5),
        warnings=tuple(Remark(line=0, code="calibration", text=text) for text in c.warnings),
    )


def calibration_text(calibration: Calibration) -> str:
    """CALIBRATION.toml. Values carry all their digits, so that what is read back is what was fitted."""
    c = calibration
    lines = [
        "# A calibration made by camrob: error parameters of a cell. mm, degrees, rad/Nm; names: README.",
        "# Void as soon as an axis is mastered again, or an error of these is put right in the controller: measure and calibrate",
        "# again then. To compensate with it as well would correct twice, and bring the error back the other way round.",
        f"schema = {SCHEMA}",
        f"cell = {json.dumps(c.cell_name)}",
        f"cell_digest = {json.dumps(c.cell_digest)}",
        f"poses = {c.rows}",
        f"left_out = {c.left_out}",
        f"outliers = {c.outliers}",
        f"oriented = {str(c.oriented).lower()}",
        f"scatter_mm = {_number(m_to_mm(c.scatter_position))}",
        f"condition = {_number(c.condition)}",
        f"observability = [{', '.join(_number(v) for v in c.observability)}]",
        f"warnings = {json.dumps(list(c.warnings))}",
    ]
    for name, digest in c.logs:
        lines += ["", "[[log]]", f"file = {json.dumps(name)}", f"digest = {json.dumps(digest)}"]
    for stage, size in c.errors.items():
        stated = ", ".join(f"{k} = {v:.6g}" for k, v in _size(size).to_json().items() if v is not None)
        lines += ["", "[[error]]", f"stage = {json.dumps(stage)}", f"size = {{ {stated} }}"]
    for p in c.parameters.items_:
        lines += [
            "",
            "[[parameter]]",
            f"name = {json.dumps(p.name)}",
            f"value = {_number(edge_value(p.value, p.unit))}",
        ]
        lines += [f"std = {_number(edge_value(p.std, p.unit))}", f"unit = {json.dumps(_EDGE.get(p.unit, p.unit))}"]
        lines += [f"nuisance = {str(p.name in c.nuisance).lower()}", 'standing = "measured"']
    for h in c.held:
        lines += ["", "[[held]]", f"name = {json.dumps(h.name)}", f"why = {json.dumps(h.why)}"]
        lines += [f"with = {json.dumps(list(h.others))}"]
    for a, b, r in c.correlations:
        lines += ["", "[[correlation]]", f"pair = {json.dumps([a, b])}", f"value = {r:.6f}"]
    return "\n".join(lines) + "\n"


def read_calibration(path: str | Path, cell: Cell) -> Calibration:
    """The calibration in a file, for a cell. Raises LogError naming file, key and hint, StaleInputError for another
    cell.
    """
    path = Path(path)
    data = read_toml(path, LogError)
    if "schema" not in data and "parameter" not in data:
        raise LogError("is no calibration", hint="give the .toml that camrob calibrate or diagnose wrote", path=path)
    table = TableReader(data, path, error=LogError)
    table.integer("schema", lower=SCHEMA, upper=SCHEMA)
    parameters, nuisance = [], []
    for part in table.tables("parameter"):
        name = part.text("name")
        try:
            plain = parameter_of(cell, name)
        except LogError as error:
            if data.get("cell") == cell.name:
                raise error.at(path) from None
            hint = f"give that cell, or calibrate {cell.name}"
            raise LogError(f"is for cell {str(data.get('cell'))[:40]}", hint=hint, path=path) from None
        unit = part.text("unit")
        if unit != _EDGE.get(plain.unit, plain.unit):
            raise part.fail(
                "unit", f"is {unit[:20]!r}", f"{name} is in {_EDGE.get(plain.unit, plain.unit) or 'no unit'}"
            )
        value = _inner_value(part.number("value"), plain.unit)
        if not plain.lower <= value <= plain.upper:
            raise part.fail("value", "lies beyond what a calibration may say", "calibrate again")
        parameters.append((plain, value, _inner_value(part.number("std", lower=0.0), plain.unit)))
        if part.flag("nuisance"):
            nuisance.append(name)
    names = [plain.name for plain, _, _ in parameters]
    if not names:
        raise table.fail("parameter", "is missing: this is no calibration", "give a file that camrob calibrate wrote")
    if len(set(names)) < len(names):
        raise table.fail("parameter", "holds a name twice", "calibrate again")
    found = ParameterSet.of(plain for plain, _, _ in parameters)
    calibration = Calibration(
        cell_name=table.text("cell"),
        cell_digest=table.text("cell_digest"),
        parameters=found.with_values(np.array([v for _, v, _ in parameters]), np.array([s for _, _, s in parameters])),
        nuisance=tuple(nuisance),
        held=tuple(Held(t.text("name"), t.text("why"), t.texts("with")) for t in table.tables("held")),
        logs=tuple((t.text("file"), t.text("digest")) for t in table.tables("log")),
        rows=table.integer("poses", lower=0, upper=10**9),
        outliers=table.integer("outliers", lower=0, upper=10**9),
        left_out=table.integer("left_out", lower=0, upper=10**9),
        oriented=table.flag("oriented"),
        scatter_position=mm_to_m(table.number("scatter_mm", lower=0.0)),
        condition=table.number("condition", lower=0.0),
        observability=tuple(table.vector("observability", 5).tolist()),
        warnings=table.texts("warnings"),
        errors={t.text("stage"): _read_size(t.table("size")) for t in table.tables("error")},
        correlations=tuple((*_pair(t), t.number("value")) for t in table.tables("correlation")),
    )
    table.finish()
    try:
        calibration.check(cell)
    except StaleInputError as error:
        raise StaleInputError(f"{one_line(str(path), 4200)}: {error}") from None
    return calibration


def _pair(table: TableReader) -> tuple[str, str]:
    pair = table.texts("pair")
    if len(pair) != 2:
        raise table.fail("pair", "is not a pair of names", "give two")
    return pair[0], pair[1]


def _read_size(table: TableReader) -> ErrorSize:
    """An error's sizes."""

    def angle(key: str) -> float:
        return deg_to_rad(table.number(key, lower=0.0)) if key in table else math.nan

    mean, rms, p95, worst = (mm_to_m(table.number(f"{key}_mm", lower=0.0)) for key in ("mean", "rms", "p95", "max"))
    poses = table.integer("poses", lower=0, upper=10**9)
    return ErrorSize(poses, mean, rms, p95, worst, angle("mean_deg"), angle("max_deg"))
