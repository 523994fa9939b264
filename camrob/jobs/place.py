"""`camrob place`: where on the table a part is worked best."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.table_plate import TablePlate, table_plate
from camrob.errors import InputError
from camrob.jobs.files.cell_for import cell_for, language_of
from camrob.jobs.files.inputs import program_name, read_inputs
from camrob.jobs.files.output import check_folder, staged_output
from camrob.jobs.files.summary_file import write_summary
from camrob.jobs.files.takes_paths import takes_paths
from camrob.jobs.solving.place_trial import FREE, UNTRIED, Trial, off_table, try_placements
from camrob.product_grid import product_grid
from camrob.progress import Progress, stage_of
from camrob.redundancy.planning.placement import Placements, place_stretches
from camrob.report.place.page import place_report
from camrob.report.place.place_map import place_map
from camrob.se3 import mm_deg_from_frame
from camrob.summaries.place_summary import Placement, PlaceSummary, PlaceTrial
from camrob.units import m_to_mm, mm_to_m

__all__ = ["PlaceResult", "place"]

Array = NDArray[np.float64]

STEPS = 9  # placements along X and Y
_FARTHEST = 1e4  # mm to either side
HEIGHTS = 5  # and along Z
_NEAR = 1e-9  # m


@dataclass(frozen=True, slots=True)
class PlaceResult:
    """What a placement found: the summary, and `files` in `out`."""

    summary: PlaceSummary
    out: Path
    files: tuple[str, ...]


@takes_paths
def place(
    clfile: Path,
    *,
    cell: Path,
    out: Path,
    setup: Path | None = None,
    x_mm: float = 200.0,
    y_mm: float = 200.0,
    z_mm: float = 0.0,
    progress: Progress | None = None,
) -> PlaceResult:
    """Propose `part_in_base`, and draw a map: NAME.place.json, .svg and .html appear in `out`.

    A proposal lies on the table's plate with part and stock (or else with all that is cut), can be followed by the published
    method with no axis faster than it can run, and touches nothing then. The certificate ranks the placements; the one as it is
    and five others of the best, apart from each other, are tried on a thinned path, and the best of these by its own trial is
    proposed: a part stays where no trial is better. What was refused is counted by reason.

    Args:
        clfile: the CL file.
        cell: the cell's folder.
        out: the folder to write into.
        setup: setup.toml; None: the one beside the CL file.
        x_mm: mm along X to either side of the set-up's own placement.
        y_mm: mm along Y to either side of it.
        z_mm: mm upwards of it.
        progress: called with a stage and the share of it that is done, 0 to 1.

    Raises:
        InputError: input that is wrong, or a freedom below 0.
        UnreachableError: no placement has the whole path in reach or lies on the table.
        CollisionError: all that are left touch something.

    Example:
        >>> part, cell = Path("toolpaths/engraving/engraving.cls"), Path("cells/kr15_track_table")
        >>> result = camrob.place(part, cell=cell, out=Path("out/place"), x_mm=0.0, y_mm=0.0)
        >>> result.summary.best.standing, result.files
        ('free', ('engraving.place.json', 'engraving.place.svg', 'engraving.place.html'))
    """
    check_folder(out)
    freedom = (x_mm, y_mm, z_mm)
    for axis, far in zip("xyz", freedom, strict=True):
        if not (np.isfinite(far) and 0.0 <= far <= _FARTHEST):
            raise InputError(f"--{axis} is {far:g}", hint=f"give millimetres from 0 to {_FARTHEST:g}")
    machine = cell_for("place", cell)
    name = program_name(Path(clfile), None, language_of(machine))
    inputs = read_inputs(Path(clfile), machine, setup)
    axes = [np.linspace(-v, v, STEPS) if v > 0.0 else np.zeros(1) for v in freedom[:2]] + [
        np.linspace(0.0, z_mm, HEIGHTS) if z_mm > 0.0 else np.zeros(1)
    ]
    shifts = mm_to_m(product_grid(axes))
    shifts = shifts[np.any(shifts != 0.0, axis=1)]  # the set-up's own placement is looked at first
    base_T_part = np.asarray(inputs.setup.base_T_part)
    found = place_stretches(inputs.by_stretch(), base_T_part, shifts, progress=stage_of(progress, "place"))
    plate = table_plate(inputs.cell)
    verdicts = off_table(inputs, plate, np.asarray(found.base_T_part))
    trial = try_placements(inputs, found, verdicts, stage_of(progress, "collisions"))
    summary = _summary(found, trial, plate, inputs.cell.name, name)
    with staged_output(out) as folder:
        xyz_mm = m_to_mm(np.asarray(found.base_T_part)[:, :3, 3])
        refused = [why if why not in (FREE, UNTRIED) else "" for why in trial.verdicts]
        picture = place_map(name, xyz_mm, found.value, trial.best, found.here, refused)
        (folder / f"{name}.place.svg").write_text(picture, encoding="utf-8")
        (folder / f"{name}.place.html").write_text(place_report(summary, picture), encoding="utf-8")
        write_summary(folder / f"{name}.place.json", summary, indent=1)
    return PlaceResult(summary, out, summary.files)


def _summary(found: Placements, trial: Trial, plate: TablePlate | None, cell: str, name: str) -> PlaceSummary:
    """What was found, in the units of the trade."""

    def entry(k: int) -> Placement:
        values = mm_deg_from_frame(np.asarray(found.base_T_part[k]))
        printed = [*values[:3].round(3).tolist(), *values[3:].round(4).tolist()]
        return Placement(
            part_in_base=tuple(printed),
            inv_kf_bound_mean=float(found.mean[k]) or None,
            inv_kf_bound_min=float(found.worst[k]) or None,
            standing=trial.verdicts[k] or "not tried",
            trial=figures(k),
        )

    def figures(k: int) -> PlaceTrial | None:
        made = trial.free.get(k)
        if made is None:
            return None
        clearance, inv_kf = made.collisions.clearance_min, np.asarray(made.solution.inv_kf)
        return PlaceTrial(
            method=made.solution.method,
            points=len(made.solution),
            inv_kf_mean=float(inv_kf.mean()),
            inv_kf_min=float(inv_kf.min()),
            collisions_checked=made.collisions.checked,
            clearance_min_mm=None if clearance is None else round(m_to_mm(clearance), 2),
        )

    others = sorted((k for k in trial.free if k not in (trial.best, found.here)), key=lambda k: -trial.free[k].value)
    return PlaceSummary(
        program=name,
        cell=cell,
        now=entry(found.here),
        best=entry(trial.best),
        others=tuple(entry(k) for k in others),
        stays=trial.best == found.here,
        placements=len(found.mean),
        in_reach=int(np.sum(found.mean > 0.0)),
        table="the cell has no plate that a part may stand on: no edge was checked" if plate is None else plate.name,
        tried=trial.tried,
        refused=trial.refused,
        files=(f"{name}.place.json", f"{name}.place.svg", f"{name}.place.html"),
        border=_border(found, trial.best),
    )


def _border(found: Placements, best: int) -> tuple[str, ...]:
    """Along which of X, Y, Z the search goes no further than to the proposal; upwards alone along Z."""
    place = np.asarray(found.base_T_part)[:, :3, 3]
    low, high, own = place.min(axis=0), place.max(axis=0), place[best]
    at = (own > high - _NEAR) | ((own < low + _NEAR) & np.array([True, True, False]))
    at &= high - low > _NEAR
    return tuple(axis for axis, there in zip("XYZ", at.tolist(), strict=True) if there)
