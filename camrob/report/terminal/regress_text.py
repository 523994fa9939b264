"""The summary of `camrob regress` for a terminal: every sample, and for those that differ what moved."""

from __future__ import annotations

from rich.console import Group, RenderableType
from rich.text import Text

from camrob.report.words import shown_text
from camrob.summaries.regress_summary import RegressSummary
from camrob.text import printable

__all__ = ["render_regress"]

_MOST = 25  # differences of a sample that are shown


def render_regress(summary: RegressSummary) -> RenderableType:
    """The samples, one after the other."""
    parts: list[RenderableType] = []
    for sample in summary.samples:
        differences = sample.differences
        points = f"{sample.points} points" if sample.points is not None else "no program"
        verdict = "written" if summary.updated else "as before" if sample.ok else "DIFFERS"
        rounding = f", {sample.rounded} numbers rounded the other way" if sample.rounded else ""
        parts.append(shown_text(f"{sample.part}: {verdict} ({points}{rounding}, {sample.seconds:.1f} s)"))
        parts += [Text(printable(f"  {line}"), overflow="fold") for line in differences[:_MOST]]
        if len(differences) > _MOST:
            parts.append(Text(f"  ... and {len(differences) - _MOST} more differences (--json shows all)"))
    count = sum(not sample.ok for sample in summary.samples)
    if summary.updated:
        end = "the golden files are what came out now: look at the difference before you commit it"
    elif count:
        end = f"{count} of {len(summary.samples)} samples differ; where that is meant, make it golden with --update"
    else:
        end = f"all {len(summary.samples)} samples come out as before"
    return Group(*parts, Text(end))
