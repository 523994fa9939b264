"""`camrob cell check`: how a cell meets the poses of its poses.csv, and where its numbers come from."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from camrob.bodies.bare_links import bare_links
from camrob.cell.cell import Cell
from camrob.cell.poses import POSES_FILE, coupled_axes, pose_errors
from camrob.cell.read_cell import unchecked_cell
from camrob.jobs.files.cell_for import check_controller
from camrob.jobs.files.home import touches_at_home
from camrob.kinematics.best_condition import best_condition
from camrob.redundancy.published.weighting import engine_weighting
from camrob.summaries.shipped_summary import CellCheckSummary, CheckedPose
from camrob.toml.table_reader import PROVENANCES
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["CellCheckResult", "cell_check"]

_FAR = 4.0 / 3.0  # between a stated characteristic length and the arm's own: lengths rounded by hand stay below


@dataclass(frozen=True, slots=True)
class CellCheckResult:
    """What was found."""

    summary: CellCheckSummary


def cell_check(cell: Path) -> CellCheckResult:
    """Hold a cell's forward kinematics against every row of its poses.csv. Raises CellError for files that can't be read, its
    fuzzy engines among them, and for settings that its controller's language doesn't take.
    """
    machine, bounds = unchecked_cell(Path(cell))
    check_controller(machine, Path(cell))
    if machine.resolve_section is not None:
        engine_weighting(machine)
    errors = pose_errors(machine, machine.folder / POSES_FILE, bounds)
    poses = tuple(
        CheckedPose(
            name=e.name,
            line=e.line,
            position_error_mm=round(float(m_to_mm(e.position)), 6),
            orientation_error_deg=round(float(rad_to_deg(e.angle)), 6),
            ok=not (e.disagrees or e.missed),
            text="; ".join(text for text in (e.disagrees, e.missed) if text),
        )
        for e in errors
    )
    counts = Counter(machine.provenance.values())
    summary = CellCheckSummary(
        cell=machine.name,
        ok=all(pose.ok for pose in poses) if poses else None,
        position_bound_mm=float(m_to_mm(bounds.position)),
        orientation_bound_deg=float(rad_to_deg(bounds.angle)),
        position_error_mm_max=max((p.position_error_mm for p in poses), default=None),
        orientation_error_deg_max=max((p.orientation_error_deg for p in poses), default=None),
        poses=poses,
        provenance={kind: counts[kind] for kind in PROVENANCES},
        assumed=tuple(key for key, kind in machine.provenance.items() if kind == "assumed"),
        bare=tuple(bare.text for bare in bare_links(machine)),
        home=touches_at_home(machine),
        length=_other_length(machine),
        coupled="" if all(pose.ok for pose in poses) else coupled_axes(machine, machine.folder / POSES_FILE, bounds),
    )
    return CellCheckResult(summary)


def _other_length(cell: Cell) -> str:
    """What is wrong with the characteristic length, as where it is another robot's, of a cell that 1/k_F decides in."""
    if cell.resolve_section is None:
        return ""
    stated, own = (float(m_to_mm(v)) for v in (cell.condition_length, best_condition(cell).length))
    if max(stated / own, own / stated) <= _FAR:
        return ""
    return (
        f"characteristic_length_mm = {stated:.4g} of cell.toml is another arm's by the look of it: {own:.4g} suits this one, and "
        "1/k_F is measured by it; correct it (camrob cell condition says it to the tenth of a millimetre)"
    )
