"""What is said of a machine that became another: names as the library has them, and first what is new, then what always was."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from camrob.gap.states.later_effect import base_name
from camrob.summaries.diagnosis_summary import DiagnosisSummary, EffectFound
from camrob.summaries.fitted.parameter_words import parameter_words
from camrob.summaries.fitted.since import Since

__all__ = ["told"]

_VALUES = 3  # that are said
_CLEAR = 2.0  # standard deviations from which a value is said


def told(summary: DiagnosisSummary) -> DiagnosisSummary:
    """The summary with effects by their names in the library, and what changed in words."""
    changed = _changed([e for e in summary.claimed if e.since is not None], summary)
    effects = tuple(
        replace(
            e,
            effect=base_name(e.effect),
            indistinguishable_from=_names(e.indistinguishable_from),
            alike=tuple(sorted(_names(e.alike))),
        )
        for e in summary.effects
    )
    return replace(
        summary,
        effects=effects,
        alternatives=tuple(replace(a, effects=_names(a.effects)) for a in summary.alternatives),
        aliases=tuple(names for group in summary.aliases if len(names := _names(group)) > 1),
        next_experiment_for=_names(summary.next_experiment_for),
        changed=changed,
    )


def _names(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(base_name(n) for n in names))


def _changed(new: Sequence[EffectFound], summary: DiagnosisSummary) -> str:
    """What is new and since when, then what was so all along."""
    when = new[0].since if new else None
    if when is None:
        return ""
    always = [_called(e) for e in summary.claimed if e.since is None]
    rest = f"As it was in all logs: {', '.join(always)}" if always else "Nothing else is claimed of these logs"
    return f"{_when(when)}: {'; '.join(_what(e) for e in new)}. {rest}."


def _when(since: Since) -> str:
    if since.row is not None:
        return f"New from row {since.row} of {since.log} on (t = {since.t_s:.6g} s)"
    if not since.lasting:
        return f"In {since.log} alone"
    return f"New between {since.after} and {since.log}" if since.after else f"New since {since.log}"


def _what(entry: EffectFound) -> str:
    """An effect that came, by how much where that is clear."""
    clear = {n: v for n, v in entry.parameters.items() if abs(v.value) > _CLEAR * v.std}
    first = sorted(clear, key=lambda n: -abs(clear[n].value) / max(clear[n].std, 1e-30))[:_VALUES]
    by = "; ".join([*(_value(n, clear[n].value) for n in first), f"{entry.moves_mm:.2g} mm at the tool"])
    no_axis = "" if entry.of_machine else ", no axis of the robot"
    return f"{_called(entry)} ({by}{no_axis})"


def _called(entry: EffectFound) -> str:
    name = base_name(entry.effect).replace("_", " ")
    return f"{name} of {', '.join(entry.axes[:_VALUES])}" if entry.axes else name


def _value(name: str, value: float) -> str:
    words, unit = parameter_words(name)
    return f"{words} {value:.3g} {unit}".rstrip()
