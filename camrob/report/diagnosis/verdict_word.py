"""The verdict's word: what a person may do upon it, and whose the gap is, the machine's or the measurement's."""

from __future__ import annotations

from math import hypot

from camrob.report.diagnosis.numbers import mm
from camrob.report.diagnosis.sentences import only_first, plain_name
from camrob.summaries.diagnosis_summary import DiagnosisSummary
from camrob.text import printable

__all__ = ["reading_text", "verdict"]

_LEVEL = {"explained": "good", "no gap": "good", "partly explained": "warn", "unexplained": "bad"}
_HALF = 0.5  # of the energy of all that is claimed, from which the reading's part is said first


def verdict(summary: DiagnosisSummary) -> tuple[str, str]:
    """The word that stands before the sentence, and how the page marks it: "good" only where it can be acted on."""
    status, claimed = summary.status, summary.claimed
    word, level = status.capitalize(), _LEVEL.get(status, "warn")
    if status in ("explained", "partly explained"):
        if not claimed:
            return f"{word}, not by which cause", "warn"
        if max(claimed, key=lambda e: e.moves_mm).like_others:
            return f"{word}, not surely", "warn"
    if status == "explained" and reading_text(summary):
        return f"{word}, mostly misreading", "warn"
    return word, level


def reading_text(summary: DiagnosisSummary) -> str:
    """That most of what is claimed is the reading's and no error of the part, and how large the part's own is; else ""."""
    inside = [e for e in summary.claimed if not only_first(e)]
    read, moved = ([e for e in inside if e.of_machine is own] for own in (False, True))
    reading = hypot(*(e.moves_mm for e in read))
    part = hypot(*(e.moves_mm for e in moved))
    if not read or reading**2 <= _HALF * (reading**2 + part**2):
        return ""
    names = ", ".join(plain_name(e.called) for e in read)
    own = (
        f"of what is claimed, about {mm(part)} rms moves the tool itself" if moved else "no claim moves the tool itself"
    )
    return printable(
        f"Most of it, {mm(reading)} rms, is an error of the measurement ({names}), not of the part: with it put right the parts "
        f"are as before; {own}."
    )
