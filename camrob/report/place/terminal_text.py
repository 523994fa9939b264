"""What `camrob place` shows a person in the terminal: where to, what its trial gave, and what it was chosen from."""

from __future__ import annotations

from rich.console import Group, RenderableType
from rich.text import Text

from camrob.report.terminal.tables import columns
from camrob.report.words import shown_number, shown_text
from camrob.summaries.place_summary import Placement, PlaceSummary

__all__ = ["remarks", "render_place"]


def remarks(summary: PlaceSummary) -> list[str]:
    """What a proposal does not say of itself: that the search ended there, and that nobody knows a table's edge."""
    said = []
    if summary.border:
        options = " and ".join(f"--{axis.lower()}" for axis in summary.border)
        along = " and ".join(summary.border)
        said.append(
            f"It lies at the border of the search along {along}: a better place may lie beyond, widen {options}"
        )
    if summary.table.startswith("the cell has no plate"):
        said.append(summary.table)
    return said


def render_place(summary: PlaceSummary) -> RenderableType:
    """The proposal as a line for the set-up, and its trial beside that of the placement as it is."""
    if summary.stays:
        head = Text("The part lies best where it is, of what was tried.", style="bold green")
    else:
        values = ", ".join(f"{value:g}" for value in summary.best.part_in_base)
        head = Text(f"Better here: part_in_base = [{values}]", style="bold green")
    headings = ("followed", "1/k_F mean", "lowest", "clearance mm", "part_in_base")
    table = columns(*headings, left=("followed", "part_in_base"))
    rows = [("as it is", summary.now)]
    rows += [] if summary.stays else [("proposed", summary.best)]
    for name, placement in [*rows, *(("another", other) for other in summary.others)]:
        table.add_row(name, *_figures(placement))
    why = ", ".join(f"{text} {count}" for text, count in summary.refused.items())
    of = f"{summary.placements:,} placements looked at, {summary.in_reach:,} in reach, {summary.tried:,} of the best tried"
    return Group(
        head,
        table,
        shown_text(of + (f"; refused: {why}" if why else "")),
        *(shown_text(text) for text in remarks(summary)),
        shown_text(f"Written: {', '.join(summary.files)}"),
    )


def _figures(placement: Placement) -> tuple[str, str, str, Text]:
    trial = placement.trial
    place = shown_text(" ".join(f"{value:g}" for value in placement.part_in_base))
    if trial is None:
        return "-", "-", "-", Text.assemble(place, f"  ({placement.standing})")
    clearance = shown_number(trial.clearance_min_mm) if trial.collisions_checked else "not checked"
    return shown_number(trial.inv_kf_mean, 3), shown_number(trial.inv_kf_min, 3), clearance, place
