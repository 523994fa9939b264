"""`camrob place`: where on the table a part is worked best."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.errors import InputError
from camrob.jobs.files import staged_output
from camrob.jobs.inputs import program_name, read_inputs
from camrob.report.place_map import place_map
from camrob.resolve.placement import Placements, place_part
from camrob.se3 import xyzabc_from_frame
from camrob.units import m_to_mm, mm_to_m, rad_to_deg

__all__ = ["PlaceResult", "place"]

Array = NDArray[np.float64]

STEPS = 9  # placements along X and Y
HEIGHTS = 5  # and along Z


@dataclass(frozen=True, slots=True)
class PlaceResult:
    """What a placement found: the summary, and `files` in `out`."""

    summary: Mapping[str, Any]
    out: Path
    files: tuple[str, ...]


def place(
    clfile: Path,
    *,
    cell: Path,
    out: Path,
    setup: Path | None = None,
    x_mm: float = 200.0,
    y_mm: float = 200.0,
    z_mm: float = 0.0,
    progress: Callable[[str, float], None] | None = None,
) -> PlaceResult:
    """Propose `part_in_base` within x_mm, y_mm, z_mm to either side (Z: upwards only) of the set-up's own.

    Writes NAME.place.json and NAME.place.svg, a map, into `out`. Raises InputError for a freedom
    below 0, and UnreachableError where no placement has the whole path in reach.
    """
    freedom = (x_mm, y_mm, z_mm)
    if not all(np.isfinite(v) and 0.0 <= v <= 1e4 for v in freedom):
        raise InputError(f"a freedom of {freedom} mm makes no sense", cure="give numbers of millimetres from 0 up")
    name = program_name(Path(clfile), None)
    inputs = read_inputs(Path(clfile), Path(cell), setup)
    axes = [
        np.linspace(-v, v, STEPS) if v > 0.0 else np.zeros(1) for v in freedom[:2]
    ] + [np.linspace(0.0, z_mm, HEIGHTS) if z_mm > 0.0 else np.zeros(1)]  # fmt: skip
    shifts = mm_to_m(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3))
    base_T_part = np.asarray(inputs.setup.base_T_part)
    tell = (lambda share: progress("place", share)) if progress is not None else None
    found = place_part(inputs.cell, inputs.path, base_T_part, shifts, progress=tell)
    summary = _summary(found, inputs.cell.name, name)
    with staged_output(Path(out)) as folder:
        value = np.asarray(found.mean + found.worst)
        picture = place_map(name, m_to_mm(np.asarray(found.base_T_part)[:, :3, 3]), value, found.best, found.here)
        (folder / f"{name}.place.svg").write_text(picture, encoding="utf-8")
        (folder / f"{name}.place.json").write_text(json.dumps(summary, indent=1) + "\n", encoding="utf-8")
    return PlaceResult(summary, Path(out), tuple(summary["files"]))


def _summary(found: Placements, cell: str, name: str) -> dict[str, Any]:
    """What was found, in the units of the trade."""

    def entry(k: int) -> dict[str, Any]:
        values = xyzabc_from_frame(np.asarray(found.base_T_part[k]))
        printed = [*m_to_mm(values[:3]).round(3).tolist(), *rad_to_deg(values[3:]).round(4).tolist()]
        return {
            "part_in_base": printed,
            "inv_kf_bound_mean": float(found.mean[k]) or None,
            "inv_kf_bound_min": float(found.worst[k]) or None,
        }

    return {
        "program": name,
        "cell": cell,
        "now": entry(found.here),
        "best": entry(found.best),
        "placements": len(found.mean),
        "in_reach": int(np.sum(found.mean > 0.0)),
        "files": [f"{name}.place.json", f"{name}.place.svg"],
    }
