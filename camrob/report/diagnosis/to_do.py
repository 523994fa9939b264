"""What a person does about a diagnosis: at the machine, at the instrument, in the program, and what to wait with."""

from __future__ import annotations

from collections.abc import Sequence

from camrob.report.diagnosis.numbers import mm
from camrob.report.diagnosis.sentences import only_first, plain_name
from camrob.summaries.diagnosis_summary import DiagnosisSummary, EffectFound
from camrob.text import printable

__all__ = ["to_do"]

_AXES = 4  # of an effect that are named
_SURE = 0.9  # of a name, from which it is acted on, whatever would show nearly the same
_RIVALS = 3  # names that are not claimed and may be it as well, that are worth being read


def to_do(summary: DiagnosisSummary) -> list[tuple[str, str]]:
    """What to do, and about what, in the order in which it is worth doing; nothing where there is no gap."""
    if summary.status == "no gap":
        return []
    claimed = sorted(summary.claimed, key=lambda e: -e.moves_mm)
    alike = [e for e in claimed if e.indistinguishable_from and e.probability < _SURE]
    steps = [(_about(e), e.remedy or "what to do is not said in its description") for e in claimed if e not in alike]
    steps += _alike(alike)
    if not claimed:
        steps.append(
            ("nothing yet", "no cause is sure enough for anything to be changed: run the next experiment first")
        )
    elif summary.unknown.probability >= 0.5:
        text = (
            f"{mm(summary.unknown.rms_mm)} stay that none of this takes away: run the next experiment to learn of what"
        )
        steps.append(("what is unexplained", text))
    if any(e.of_machine and not only_first(e) for e in claimed):
        steps.append(("in the program", _in_program(summary)))
    return [(printable(what), printable(text)) for what, text in steps]


def _about(entry: EffectFound) -> str:
    """An effect, where, and by how much it moves the tool."""
    axes = f" of {', '.join(entry.axes[:_AXES])}" if entry.axes else ""
    more = " and others" if len(entry.axes) > _AXES else ""
    return f"{plain_name(entry.effect)}{axes}{more} ({mm(entry.moves_mm)})"


def _alike(entries: Sequence[EffectFound]) -> list[tuple[str, str]]:
    """Effects that these logs can't tell from others: what to do about one of them would be wrong if it is another."""
    if not entries:
        return []
    named, largest = {e.effect for e in entries}, entries[0]
    others = [n for n in dict.fromkeys(n for e in entries for n in e.indistinguishable_from) if n not in named]
    rivals = ", ".join(map(plain_name, others[:_RIVALS]))
    rivals += f" and {len(others) - _RIVALS} more" if len(others) > _RIVALS else ""
    if len(entries) > 1:
        what = f"these from each other{f' or from {rivals}' if rivals else ''}"
    else:
        what = f"it from {rivals}"
    run = largest.isolated_by or "the next experiment"
    only = f". If it stays: {largest.remedy}" if len(entries) == 1 and largest.remedy else ""
    text = f"change nothing for it yet, as these logs can't tell {what}. First run this: {run}{only}"
    return [(", ".join(map(_about, entries)), text)]


def _in_program(summary: DiagnosisSummary) -> str:
    """How what comes back from run to run is taken off."""
    written = summary.compensable.written
    calibration = f" --calibration {written}" if written else ""
    return (
        "what is not put right at the machine and comes back from run to run is taken off by "
        f"camrob compensate PROGRAM.src --cell {summary.cell}{calibration} --diagnosis DIR --out OUT (DIR: where this page lies)"
    )
