"""What a technician reads first: what it is, where, and the one step to begin with, with what is to be left alone."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot, sqrt

from camrob.report.diagnosis.grown_friction import friction_first, friction_what, friction_where
from camrob.report.diagnosis.numbers import beyond_ordinary, fitted, mm, share, sure, to_mm
from camrob.report.diagnosis.sentences import between, only_first, plain_name
from camrob.report.diagnosis.to_do import hardly_likelier, in_doubt
from camrob.summaries.diagnosis_summary import LIKELY, DiagnosisSummary, EffectFound
from camrob.text import printable

__all__ = ["head_lines", "too_large"]

_RIVAL = 0.1  # of a cause that is not claimed, from which it is named where none is
_MOST = 3  # causes, axes, quantities that are named
_SURE = 0.9  # of a name, from which a value that is seldom seen is believed
_SEVERAL = 6.0  # times an ordinary value, from which it is held against the name
_MORE = 1.05  # times the gap, from which a cause moves the tool by more than is there to be explained
_MOST_OF = 0.75  # of the gap's energy that a stage has, where it is the place
_SOUND = ("noise", "tolerance")
_STAGE_SOUND = {
    "setpoint_to_encoder": "the drives, which follow their set-points",
    "encoder_to_tcp": "gears, zeros and frames, as the tool is where the encoders say",
}
_SILENT = 1.2  # times the noise, within which the tool is where the set-points say
_BENT = 0.01  # of how far encoders are off, what levers that are others by then make of it
_ALL_ALIKE = "all axes alike"
_LONG = 160  # letters that a step may have
_NO_DEED = "nothing to adjust"  # how a remedy begins that is none
_UNKNOWN = "unknown"
_NAMELESS = "Something that has no name here: "
_AS_MUCH = 0.5  # of the energy that the causes take, from which what stays unknown is asked before one that is in doubt
_NOTHING = 0.98  # of the gap, from which causes that leave so much of it together take none
_TRIFLE = 0.2  # of what the largest cause moves the tool by


def head_lines(summary: DiagnosisSummary) -> list[tuple[str, str]]:
    """Up to four lines, each with its heading: what has changed, what it is, where, what to do first."""
    what, where = _with_local(summary) + friction_what(summary), _where(summary) + friction_where(summary)
    lines = [("What", what), ("Where", where.strip()), ("Do first", _and_friction(summary, _first(summary)))]
    return [(name, printable(text)) for name, text in (("Changed", summary.changed), *lines) if text]


def too_large(entry: EffectFound, summary: DiagnosisSummary) -> bool:
    """Whether a cause moves the tool by more than there is of a gap: it works against another one, and its size is theirs."""
    return entry.moves_mm > _MORE * max(summary.gap.rms_mm, summary.together.rms_before_mm)


def _inside(summary: DiagnosisSummary) -> list[EffectFound]:
    """What is claimed of the gap, the largest first."""
    return sorted((e for e in summary.claimed if not only_first(e)), key=lambda e: -e.moves_mm)


def _what(summary: DiagnosisSummary) -> str:
    """The cause and how sure, the gap before and after, what stays, and what is hard to believe."""
    if summary.status == "no gap" or (summary.where.local and not summary.claimed and _all_sound(summary)):
        size = f"{mm(summary.gap.rms_mm)} rms, the noise {mm(summary.gap.noise_mm)}"
        within = "what the log tolerates" if "tolerance" in summary.within.values() else "its noise"
        return f"No gap: all that was logged is within {within} ({size})."
    t, noise = summary.together, mm(summary.gap.noise_mm)
    inside, first = _inside(summary), [e for e in summary.claimed if only_first(e)]
    if not inside:
        return _nothing_claimed(summary, first)
    named = "; ".join(_called(e) for e in inside[:_MOST])
    more = f"; and {len(inside) - _MOST} more" if len(inside) > _MOST else ""
    text = f"{_capital(named)}{more}. {to_mm(t.rms_before_mm, t.rms_after_mm)} rms {_on(summary)}; noise {noise}"
    if summary.unknown.likely:
        text += f"; {mm(summary.unknown.rms_mm)} stay that have no known cause"
    return f"{text}.{_doubts(inside, summary)}"


def _all_sound(summary: DiagnosisSummary) -> bool:
    return all(found in _SOUND for found in summary.within.values())


def _with_local(summary: DiagnosisSummary) -> str:
    """What it is; poses that are far off and share a place come first."""
    if not summary.where.local:
        return _what(summary)
    one = summary.where.local[0]
    return (
        f"{one.poses} of {one.of} poses are off by up to {mm(one.worst_mm)} ({mm(one.rms_mm)} rms), all with {one.place}, where "
        f"hardly any other is: that has no name here. Beside these: {_what(summary).removeprefix(_NAMELESS)}"
    )


def _on(summary: DiagnosisSummary) -> str:
    """Which samples that is reckoned on."""
    return f"on {'stretches' if summary.together.withheld == 'blocks of the logs' else 'a run'} that took no part"


def _called(entry: EffectFound) -> str:
    """A cause with how sure it is, and what it can't be told from where it is no surer than that."""
    others = [plain_name(n) for n in entry.indistinguishable_from] if entry.like_others else []
    more = f" or {len(others) - 2} more" if len(others) > 2 else ""
    like = f", or {' or '.join(others[:2])}{more}" if others else ""
    return f"{plain_name(entry.called)}{_of(entry)} ({sure(entry.probability)} sure{like})"


def _of(entry: EffectFound) -> str:
    return f" of {_listed(entry.axes[:_MOST])}{' and others' if len(entry.axes) > _MOST else ''}" if entry.axes else ""


def _nothing_claimed(summary: DiagnosisSummary, first: Sequence[EffectFound]) -> str:
    """That no cause is sure, which are likeliest, and how large the gap is."""
    if _record_alone(summary):
        size = f"{mm(summary.together.rms_before_mm)} rms {_on(summary)}; noise {mm(summary.gap.noise_mm)}"
        return f"The record of the encoders, and not the machine: the tool is where the set-points say ({size})."
    size = f"the gap is {mm(summary.together.rms_before_mm)} rms {_on(summary)}; noise {mm(summary.gap.noise_mm)}"
    if first and not summary.unknown.likely:
        names = "; ".join(f"{_called(e)}, {to_mm(e.rms_before_mm, e.rms_after_mm)}" for e in first)
        return f"{_capital(names)}, in the program and not in the machine; {size}."
    likely = [e for e in summary.effects if e.probability >= _RIVAL and not only_first(e) and not e.implausible]
    nothing = sum(a.probability for a in summary.alternatives if not a.effects)
    if not likely or (nothing >= LIKELY and summary.unknown.likely):
        return f"{_NAMELESS}{size}.{_impossible(summary)}"
    names = ", ".join(f"{plain_name(e.called)} ({sure(e.probability)})" for e in likely[:_MOST])
    if sum(e.probability for e in likely) < LIKELY and summary.unknown.likely:
        return f"Most likely something that has no name here, else {names}: {size}.{_impossible(summary)}"
    text = f"Not sure; {'the likeliest is' if len(likely) == 1 else 'likeliest are'} {names}: {size}."
    return f"{text}{_doubts(likely[:1], summary)}{_impossible(summary)}"


def _record_alone(summary: DiagnosisSummary) -> bool:
    """Whether encoders are off the set-points, and the tool is not."""
    at_drives = summary.unknown.where.stage == "setpoint_to_encoder" and summary.status == "unexplained"
    tracked = summary.within.get("encoder_to_tcp") is not None
    off = summary.where.stages.get("setpoint_to_encoder") or 0.0
    silent = summary.together.rms_before_mm <= hypot(_SILENT * summary.gap.noise_mm, _BENT * off)
    return at_drives and tracked and silent and not summary.claimed


def _impossible(summary: DiagnosisSummary) -> str:
    """Names that would fit with values that no machine has: then they stand in for another cause."""
    names = [plain_name(n) for n in summary.unknown.implausible]
    if not names:
        return ""
    verb = "fits" if len(names) == 1 else "fit"
    return f" {_capital(_listed(names[:_MOST]))} {verb} with values alone that no machine has: it looks alike."


def _doubts(entries: Sequence[EffectFound], summary: DiagnosisSummary) -> str:
    """What is hard to believe of values, and of sizes that are larger than the gap."""
    words = [w for e in entries if (w := _hard_to_believe(e))]
    large = [e for e in entries if too_large(e, summary)]
    if large:
        names = _listed([f"{plain_name(e.called)} ({mm(e.moves_mm)})" for e in large])
        works = "they work against each other" if len(large) > 1 else "it works against another cause"
        words.append(
            f"{_capital(names)} would move the tool by more than the gap: {works}, so don't take sizes at their word"
        )
    return "".join(f" {w}." for w in words)


def _hard_to_believe(entry: EffectFound) -> str:
    """A value that such machines seldom have, and what it means: another cause, or something that has happened."""
    found = beyond_ordinary(entry.parameters, _SEVERAL)
    if found is None:
        return ""
    (words, unit), value, times = found
    size = f"{words} {fitted(value.value, value.std, unit)}, {times:.0f} times the ordinary,"
    if entry.probability >= _SURE and not entry.like_others:
        return f"{_capital(plain_name(entry.called))}: {size} is seldom so much"
    others = [plain_name(n) for n in entry.indistinguishable_from[:2]]
    if others and entry.regimes == ("direction",):
        why = f"is more than a gear does so: rather {' or '.join(others)}"
    elif others:
        why = f"is no true value: what looks alike in these logs ({' or '.join(others)}) has a part in it or stands behind it"
    else:
        why = "is not ordinary wear: something is broken there, or another cause stands behind it"
    return f"{_capital(plain_name(entry.called))}: {size} {why}"


def _where(summary: DiagnosisSummary) -> str:
    """Stage, axis, what it follows: of the largest claim, then of what stays unknown."""
    if summary.status == "no gap":
        return ""
    inside = _inside(summary)
    if not inside:
        at = _unknown_at(summary)
        return f"{_capital(at)}." if at else f"{_capital(_stage(summary))}; {_no_axis(summary)}."
    largest = inside[0]
    if not largest.of_machine:
        text = "In the reading, not in the machine"
    else:
        stage = largest.stages[0] if len(largest.stages) == 1 else ""
        text = _capital(between(stage, summary) if stage else _stage(summary))
    axes = _which_axis(largest)
    text += f"; {axes}" if axes else ""
    follows = [r for r in largest.regimes if r in summary.where.regimes][:1] or list(largest.regimes[:1])
    text += f"; follows the {follows[0]}" if follows else ""
    rest = _unknown_at(summary) if summary.unknown.likely else ""
    return f"{text}.{f' What stays: {rest}.' if rest else ''}"


def _stage(summary: DiagnosisSummary) -> str:
    """Where most of the gap sits, with its share of the energy where that is not all."""
    stages = {k: v for k, v in summary.where.stages.items() if v is not None and k != "program_to_setpoint"}
    if not stages:
        return between("program_to_setpoint", summary)
    most = max(stages, key=lambda k: stages[k])
    part = stages[most] ** 2 / max(sum(v * v for v in stages.values()), 1e-12)
    return between(most, summary) + ("" if part >= _MOST_OF else f" ({share(part)})")


def _no_axis(summary: DiagnosisSummary) -> str:
    return "no axis stands out" if summary.unknown.likely else "which axis, these logs don't tell"


def _which_axis(entry: EffectFound) -> str:
    """Whether one axis stands out of its like, by the evidence."""
    moves = entry.axis_moves_mm or {}
    odd, shared = entry.stands_out, any("_beyond_" in n or n in ("tau_s", "arm_s2") for n in entry.parameters)
    shared |= entry.of_machine and "delay_s" in entry.parameters
    if not moves or not entry.axes:
        return _ALL_ALIKE if shared else ""
    if shared:
        return f"all axes, and {_listed(odd)} otherwise than the rest" if odd else _ALL_ALIKE
    if len(moves) == 1:
        return f"{next(iter(moves))} alone"
    if odd:
        (first, size), (second, next_size), *_ = moves.items()
        return f"{first} stands out ({mm(size)}; {second}, the next, {mm(next_size)})"
    if sqrt(sum(v * v for v in moves.values())) > _MORE * max(entry.moves_mm, 1e-12) * sqrt(2.0):
        return f"which of {_listed(list(moves)[:_MOST])}, these logs don't tell: they cancel in part"
    return f"{_listed(list(moves)[:_MOST])} about alike"


def _unknown_at(summary: DiagnosisSummary) -> str:
    """Where what is unknown sits, in a few words; "" where nothing is known of it."""
    at = summary.unknown.where
    if not summary.unknown.likely or at.stage is None:
        return ""
    parts = [between(at.stage, summary)]
    parts.append(_listed(at.axes[:_MOST]) if at.axes else "no axis stands out")
    follows = f"follows {_listed(at.regimes[:2])}" if at.regimes else "follows nothing that was logged"
    parts.append(f"comes back {at.comes_back}" if at.comes_back else follows)
    return "; ".join(parts)


def _first(summary: DiagnosisSummary) -> str:
    """One step, and what is to be left alone until then."""
    if summary.status == "no gap":
        return "Nothing."
    inside, alike = _inside(summary), in_doubt(summary)
    t = summary.together
    idle = t.rms_after_mm >= _NOTHING * t.rms_before_mm and summary.unknown.likely
    doubtful = [*alike, *(e for e in inside if (idle or hardly_likelier(e)) and e not in alike)]
    program = [e for e in summary.claimed if only_first(e)]
    left = _left_alone(summary, doubtful)
    most_unknown = summary.unknown.rms_mm**2 > _AS_MUCH * (t.rms_before_mm**2 - t.rms_after_mm**2)
    if _record_alone(summary):
        return "Have the recorder's filter and clock looked at, and log again. Leave alone: the robot."
    if not inside:
        step = program[0].remedy if program and program[0].remedy else _for_unknown(summary)
    elif inside[0] not in doubtful and inside[0].remedy:
        step = _of_these([e for e in inside if e not in doubtful])
    elif inside[0].isolated_by and not most_unknown:
        step = _short(inside[0].isolated_by)
    else:
        step = _for_unknown(summary)
    deeds = [e for e in inside if e not in doubtful and e.remedy and not e.remedy.startswith(_NO_DEED)]
    clear = [e for e in deeds if e.probability >= _SURE or not _hard_to_believe(e)]
    if inside and inside[0] in doubtful and clear and clear[0].moves_mm >= _TRIFLE * inside[0].moves_mm:
        step = f"{step}. {_capital(plain_name(clear[0].called))}{_of(clear[0])}, which is clear: {_deed(clear[0])}"
    return " ".join([f"{_capital(step)}.", *left])


def _and_friction(summary: DiagnosisSummary, step: str) -> str:
    """The step, and what to do about grown friction: alone where there is no gap, ahead of what is to be left alone else."""
    more = friction_first(summary)
    if not more:
        return step
    if summary.status == "no gap":
        return f"{_capital(more)}."
    return f"{step} And {more}."


def _of_these(clear: Sequence[EffectFound]) -> str:
    """The first step of the largest cause's remedy; where there is nothing to adjust, also that of the first one that there is
    something to do about, where that is no trifle beside it.
    """
    first, more = clear[0], (e for e in clear[1:] if e.remedy and not e.remedy.startswith(_NO_DEED))
    other = next(more, None) if first.remedy.startswith(_NO_DEED) else None
    if other is None or other.moves_mm < _TRIFLE * first.moves_mm:
        return _deed(first)
    idle = f"{plain_name(first.called)}{_of(first)}: {_NO_DEED} at the machine"
    return f"{idle}. {_capital(plain_name(other.called))}{_of(other)}: {_deed(other)}"


def _deed(entry: EffectFound) -> str:
    """The first step of a remedy, with the axes' names where they are few."""
    step = entry.remedy.partition("; ")[0]
    return step.replace("these axes", _listed(entry.axes)) if 0 < len(entry.axes) <= _MOST else step


def _for_unknown(summary: DiagnosisSummary) -> str:
    """The next experiment, or of one that is about what is unexplained what takes minutes and comes first."""
    about = summary.next_experiment_for
    if summary.unknown.isolated_by and (not about or _UNKNOWN in about):
        return _short(summary.unknown.isolated_by)
    return _next(summary)


def _next(summary: DiagnosisSummary) -> str:
    """The next experiment, without what it is about and what is expected."""
    text = summary.next_experiment.partition(". Expected is")[0]
    for start in ("Isolate what is unexplained: ", "To tell: "):
        text = text.rpartition(start)[2] if start in text else text
    return _short(text)


def _short(text: str) -> str:
    """A step; of a long one, without what is to be seen then, which stands below."""
    text = (
        text.partition(". Then ")[0]
        .partition("; look for")[0]
        .partition(": the paths that the two expect")[0]
        .rstrip(".")
    )
    if len(text) <= _LONG:
        return text
    about, joined, run = text.partition(": ") if text.startswith("To tell ") else ("", "", text)
    return f"{about}{joined}{run.partition(': ')[0]}"


def _left_alone(summary: DiagnosisSummary, doubtful: Sequence[EffectFound]) -> list[str]:
    """What the log shows to be sound, and what is not sure enough for anything to be changed for it, a sentence each."""
    inside = _inside(summary)
    sound = next((words for stage, words in _STAGE_SOUND.items() if summary.within.get(stage) in _SOUND), "")
    if not inside:
        return [f"Leave alone: all of the machine until that run has told{f', above all {sound}' if sound else ''}."]
    if not inside[0].of_machine:
        return ["Leave alone: the robot, as it is the reading that is off."]
    said = [f"Leave alone: {sound}."] if sound else []
    if doubtful:
        names = _listed([f"{plain_name(e.called)}{_of(e)}" for e in doubtful[:_MOST]])
        said.append(f"Change nothing for {names} before that is clear.")
    return said


def _listed(words: Sequence[str]) -> str:
    return f"{', '.join(words[:-1])} and {words[-1]}" if len(words) > 1 else "".join(words)


def _capital(words: str) -> str:
    return words[:1].upper() + words[1:]
