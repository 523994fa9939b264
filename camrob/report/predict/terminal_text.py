"""What `predict` shows a person in the terminal: what to look at first, in a few lines."""

from __future__ import annotations

from rich.console import Group, RenderableType
from rich.text import Text

from camrob.report.terminal.tables import columns
from camrob.report.words import shown_text
from camrob.summaries.predict_summary import HolderMeets, PredictSummary

__all__ = ["render_prediction"]

_PLACES, _CAUSES = 3, 4  # the rest stands on the page


def render_prediction(summary: PredictSummary) -> RenderableType:
    """The size of the error and how sure, what makes it, the worst places; gouges and the holder first where there are any."""
    parts: list[RenderableType] = [shown_text(f"! {line}") for line in _alarms(summary)]
    likely = summary.likely
    size = f"off what was programmed, likely: rms {likely.rms_mm:.3f} mm, 95 % within {likely.p95_mm:.3f}"
    between = f"between {likely.p95_low_mm:.3f} and {likely.p95_high_mm:.3f} on 95 of 100 machines as this may be"
    parts.append(Text(f"{size} ({between})"))
    expected = f"expected, where all that is in doubt is 0: rms {summary.rms_mm:.3f}, 95 % within {summary.p95_mm:.3f}"
    parts.append(
        Text(f"{expected}, worst {summary.worst_mm:.3f}; a place may be off from that by {summary.band_mm:.3f}")
    )
    if summary.part is not None:
        p, off = summary.part, summary.part.size
        held = (
            f"off {p.mesh}: rms {off.rms_mm:.3f} mm, 95 % within {off.p95_mm:.3f}; {p.left_mm3:.0f} mm³ stand beyond it"
        )
        parts.append(shown_text(held))
    named = [f"{name.replace('_', ' ')} {rms:.3f}" for name, rms in list(summary.causes.items())[:_CAUSES]]
    parts.append(shown_text(f"causes, rms mm: {', '.join(named)}"))
    table = columns("largest cause", "line", "error mm", "x mm", "y mm", "z mm", left=("largest cause",))
    for place in summary.places[:_PLACES]:
        at = (f"{v:.1f}" for v in (place.x_mm, place.y_mm, place.z_mm))
        table.add_row(place.cause.replace("_", " "), str(place.line), f"{place.deviation_mm:+.3f}", *at)
    parts += [table, shown_text(f"not judged: {', '.join(summary.not_judged)}")]
    return Group(*parts, shown_text(f"written: {', '.join(summary.files)}"))


def _alarms(summary: PredictSummary) -> list[str]:
    """What would damage part or tool."""
    found = [w.text + (f" (line {w.line})" if w.line else "") for w in summary.warnings]
    if summary.holder:
        worst = max(summary.holder, key=lambda m: m.taken_mm3)
        found.append(
            f"the holder goes through the stock at {len(summary.holder)} places, most of all in {_lines(worst)} "
            f"({worst.taken_mm3:.0f} mm³): a longer cutter, or another approach"
        )
    if summary.part is not None and summary.part.gouges:
        deepest = summary.part.gouges[0]
        found.append(
            f"{-deepest.deviation_mm:.3f} mm deep into {summary.part.mesh} in line {deepest.line}; "
            f"{summary.part.gouged_mm3:.0f} mm³ in all"
        )
    return found


def _lines(meets: HolderMeets) -> str:
    first, last = meets.first_line, meets.last_line
    return f"line {first}" if first == last else f"lines {first} to {last}"
