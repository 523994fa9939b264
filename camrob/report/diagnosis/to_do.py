"""What a person does about a diagnosis: at the machine, at the instrument, in the program, and what to wait with."""

from __future__ import annotations

import re
from collections.abc import Sequence

from camrob.report.diagnosis.numbers import fitted, mm
from camrob.report.diagnosis.sentences import only_first, plain_name
from camrob.summaries.diagnosis_summary import DiagnosisSummary, EffectFound, FittedValue
from camrob.summaries.fitted.parameter_words import parameter_words
from camrob.text import printable
from camrob.units import m_to_mm

__all__ = ["compensate_command", "hardly_likelier", "in_doubt", "to_do"]

_AXES = 4  # of an effect that are named
_LIKELIER = 0.7  # sure, below which a cause is hardly likelier than none, and nothing is opened for it
_ENTERED = re.compile(r"[A-Z]\d+_(?:deg|scale|by_\w+)")  # values of an axis that a controller takes
_WORTH = 2.0  # standard deviations from which a value is one to enter
_UNKNOWN = "unknown"
_RIVALS = 3  # names that are not claimed and may be it as well, that are worth being read


def to_do(summary: DiagnosisSummary) -> list[tuple[str, str]]:
    """What to do, and about what, in the order in which it is worth doing; nothing where there is no gap."""
    if summary.status == "no gap":
        return []
    claimed, alike = sorted(summary.claimed, key=lambda e: -e.moves_mm), in_doubt(summary)
    steps = [
        (_about(e), f"{_before(e)}{e.remedy or 'what to do is not said in its description'}{_to_enter(e)}")
        for e in claimed
        if e not in alike
    ]
    steps += _alike(alike, summary.next_experiment_for)
    if not claimed:
        steps.append(
            ("nothing yet", "no cause is sure enough for anything to be changed: run the next experiment first")
        )
    elif summary.unknown.likely:
        text = f"{mm(summary.unknown.rms_mm)} stay that none of this takes away: {_run_for_rest(summary)}"
        steps.append(("what is unexplained", text))
    if any(e.of_machine and not only_first(e) for e in claimed):
        steps.append(("in the program", _in_program(summary)))
    return [(printable(what), printable(text)) for what, text in steps]


def hardly_likelier(entry: EffectFound) -> bool:
    """Whether a claim is hardly likelier than that nothing of the library is at work, and a run shows which it is."""
    return entry.probability < _LIKELIER and bool(entry.isolated_by)


def _before(entry: EffectFound) -> str:
    """What comes before a remedy that is not sure to be one."""
    return f"not surely, so first run this: {entry.isolated_by}. If it stays: " if hardly_likelier(entry) else ""


def in_doubt(summary: DiagnosisSummary) -> list[EffectFound]:
    """Claims that may be another cause as well, so that nothing is to be changed for them yet, the largest first."""
    claimed = sorted(summary.claimed, key=lambda e: -e.moves_mm)
    return [e for e in claimed if e.like_others or _no_surer_than_its_like(e, claimed)]


def _no_surer_than_its_like(entry: EffectFound, claimed: Sequence[EffectFound]) -> bool:
    """Whether a claim that is no surer may be this one as well: what can't be told apart can't be told from either side."""
    rivals = (o for o in claimed if o.like_others and entry.effect in o.indistinguishable_from)
    return any(entry.probability <= o.probability for o in rivals)


def _about(entry: EffectFound) -> str:
    """An effect, where, and by how much it moves the tool."""
    axes = f" of {', '.join(entry.axes[:_AXES])}" if entry.axes else ""
    more = " and others" if len(entry.axes) > _AXES else ""
    return f"{plain_name(entry.called)}{axes}{more} ({mm(entry.moves_mm)})"


def _run_for_rest(summary: DiagnosisSummary) -> str:
    """The run that is about what stays: the next experiment, or another where that is about something else."""
    if _UNKNOWN in summary.next_experiment_for or not (summary.next_experiment_for or summary.unknown.isolated_by):
        return "run the next experiment to learn of what"
    if not summary.unknown.isolated_by:
        return "nothing in these logs says what run would show it"
    return f"once the above is done, to learn of what, {summary.unknown.isolated_by}"


def _to_enter(entry: EffectFound) -> str:
    """The values that a remedy says to enter, as found; that there is none where none was found."""
    if "enter the " not in entry.remedy:
        return ""
    known = {n: v for n, v in entry.parameters.items() if _ENTERED.fullmatch(n) and abs(v.value) > _WORTH * v.std}
    if not known:
        return " (none to enter was found here)"
    return f" (found here, real less shown: {'; '.join(_value(n, v) for n, v in known.items())})"


def _value(name: str, value: FittedValue) -> str:
    """A fitted value in words; a scale by the metre."""
    if name.endswith("_scale"):
        return f"{name.removesuffix('_scale')} {fitted(m_to_mm(value.value), m_to_mm(value.std), 'mm a metre')}"
    words, unit = parameter_words(name)
    return f"{words} {fitted(value.value, value.std, unit)}"


def _alike(entries: Sequence[EffectFound], asked: Sequence[str]) -> list[tuple[str, str]]:
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
    run = f"First run this: {largest.isolated_by}" if largest.isolated_by else "First run the next experiment"
    run = "First run the next experiment" if largest.effect in asked else run
    only = f". If it stays: {largest.remedy}" if len(entries) == 1 and largest.remedy else ""
    text = f"change nothing for it yet, as these logs can't tell {what}. {run}{only}"
    return [(", ".join(map(_about, entries)), text)]


def _in_program(summary: DiagnosisSummary) -> str:
    """How what comes back from run to run is taken off."""
    written = summary.compensable.written
    void = f", and {written} is void" if written else ""
    return (
        "what is not put right at the machine and comes back from run to run is taken off in the program, by the command below. "
        "Do one or the other: whoever masters an axis, or enters a value in the controller, makes the logs again first, or an "
        f"error comes back the other way round{void}"
    )


def compensate_command(summary: DiagnosisSummary) -> tuple[str, str] | None:
    """The command that takes off in the program what comes back, and before it what to replace; None where nothing does."""
    if summary.status == "no gap" or not any(e.of_machine and not only_first(e) for e in summary.claimed):
        return None
    written = summary.compensable.written
    calibration = f" --calibration {written}" if written else ""
    path = f", {written} by its path" if written else ""
    return (
        f"To correct the program (PROGRAM.src is the one that ran, DIR this page's folder, OUT a new one{path})",
        f"camrob compensate PROGRAM.src --cell {summary.cell}{calibration} --diagnosis DIR --out OUT",
    )
