"""A diagnosis in words: the first sentence, and what else is said of causes, of the unknown, of standards."""

from __future__ import annotations

import re
from collections.abc import Sequence

from camrob.report.diagnosis.drives import drive_follows, drive_text
from camrob.report.diagnosis.numbers import measure, mm, share, sure, waves
from camrob.summaries.diagnosis_places import RunStandard, StageWithin, Standard
from camrob.summaries.diagnosis_summary import DiagnosisSummary, EffectFound, UnknownShape
from camrob.summaries.fitted.parameter_words import parameter_words
from camrob.text import printable

__all__ = [
    "between",
    "by_size",
    "compensable_text",
    "noise_name",
    "only_first",
    "plain_name",
    "sentence",
    "standards_text",
    "unexplained",
    "withheld_text",
]

_FIRST = "program_to_setpoint"
_STAGE = {
    _FIRST: "between program and set-point",
    "setpoint_to_encoder": "between set-point and encoder",
    "encoder_to_tcp": "between encoder and TCP",
}
_FOLLOWS = {
    "position": "follows the position",
    "direction": "reverses with the direction of motion",
    "speed": "grows with speed",
    "acceleration": "grows with acceleration",
    "load": "follows the load",
    "time": "drifts with time",
}
_READ_OFF = (_STAGE[_FIRST], "between set-point and encoder, E", "between set-point and encoder, A")
_TIMES = 1.5  # the noise, from which what stays is held against it in words
_MAIN = ("tau_s", "delay_s", "cdis_mm")  # the value that tells such an effect's size, whatever stands beside it
_ODD = 0.2  # of what all axes share, by which one has to differ to be named
_MOST_VALUES = 3  # axes of an effect that the sentence gives values of
_RIVAL = 0.1  # probability from which a cause is named among several that none is claimed of
_NOTHING = 0.5  # probability that no effect of the library is at work, from which none of them is worth a word
_FROM = "from "  # how what it follows begins where it is a moment
_CONSTANT = "constant"  # what the unexplained is said to follow where it follows nothing
_WITH = "compensate --diagnosis corrects what of it comes back from run to run"
_WORTH = 0.05  # share of the gap's energy that is worth a word where it stays unexplained
_NAMED = 0.005  # share of the rest from which it is named beside what the rest follows


def by_size(effects: Sequence[EffectFound]) -> list[EffectFound]:
    """Effects as they are read: what is claimed of the gap, the largest first, then of the program; then the rest."""
    return sorted(effects, key=lambda e: (not e.claimed, only_first(e), -e.moves_mm if e.claimed else 0.0))


def plain_name(effect: str) -> str:
    """An effect's name in words; behind it stands when it came, where it was not always there."""
    name, *rest = effect.split(" ", 1)
    return " ".join([name.replace("_", " "), *rest])


def between(stage: str, summary: DiagnosisSummary) -> str:
    """A stage in words; without encoders the last one begins at the set-point."""
    blind = any(m.startswith("no encoders") for m in summary.where.missing)
    return "between set-point and TCP" if stage == "encoder_to_tcp" and blind else _STAGE[stage]


def noise_name(summary: DiagnosisSummary) -> str:
    """Whose noise it is."""
    blind = any(m.startswith("no measured pose") for m in summary.where.missing)
    return "the noise of what is logged" if blind else "the instrument's noise"


def withheld_text(summary: DiagnosisSummary) -> str:
    """Which samples the shrinkage is measured on."""
    name = summary.together.withheld
    if name == "blocks of the logs":
        return "on stretches that took no part"
    return f"on {'runs' if ', ' in name else 'a run'} that took no part ({printable(name)})"


def sentence(summary: DiagnosisSummary) -> str:
    """What a person has to know, in a few sentences."""
    gap, together, claimed = summary.gap, summary.together, summary.claimed
    noise = mm(gap.noise_mm)
    inside, first = [e for e in claimed if not only_first(e)], [e for e in claimed if only_first(e)]
    if summary.status == "no gap":
        return _no_gap(summary)
    text, joint = _place(summary)
    follows = _follows(summary, inside)
    text += f"{joint} {follows}" if follows and (inside or not first) else ""
    if inside:
        text += f": {_listed([_named(e, drive_text(summary, e)) for e in inside], '; ')}"
        text += (
            f". {_capital(withheld_text(summary))}, adding {'it' if len(inside) == 1 else 'them'} takes the gap from "
            f"{mm(together.rms_before_mm)} to {mm(together.rms_after_mm)}; {noise_name(summary)} is {noise}."
        )
    elif first:
        text += "."
    elif summary.status == "explained":
        rivals = [e for e in summary.effects if e.probability >= _RIVAL]
        text += f", and several causes would explain it equally well, so none is claimed: {_with_chances(rivals)}."
    else:
        text += f", and {_none_sure(summary)}{_best_single(summary)}."
    for e in first:
        sizes = f"{mm(e.rms_before_mm)} to {mm(e.rms_after_mm)}"
        text += f" Between program and set-point: {_named(e)}; adding it takes {sizes}."
    return printable(text + _unknown_words(summary, claimed=bool(claimed)))


def _none_sure(summary: DiagnosisSummary) -> str:
    """That nothing is claimed: because the library has nothing for it, or because several of its causes may be it."""
    likely = [e for e in summary.effects if e.probability >= _RIVAL and not only_first(e) and not e.implausible]
    nothing = sum(a.probability for a in summary.alternatives if not a.effects)
    if not likely or nothing >= _NOTHING:
        return "nothing in the library explains it"
    first = "the likeliest is" if len(likely) == 1 else "likeliest are"
    return f"no cause is sure enough to be named; {first} {_with_chances(likely)}"


def _with_chances(effects: Sequence[EffectFound]) -> str:
    """Causes, each with how sure it is."""
    return _listed([f"{plain_name(e.called)} ({sure(e.probability)} sure)" for e in effects])


def _no_gap(summary: DiagnosisSummary) -> str:
    """That there is none, and by which value of noise or of the user's tolerance, stage by stage."""
    stages = [f"{between(name, summary)} {_stage_within(stage)}" for name, stage in summary.within_values.items()]
    return printable(f"There is no gap: {'; '.join(stages)}.")


def _stage_within(stage: StageWithin) -> str:
    """A stage's size and what it is within, with the value."""
    size = (
        f"{stage.axis}, the farthest off, is {mm(stage.rms_mm)} rms over the work"
        if stage.axis
        else f"{mm(stage.rms_mm)} rms"
    )
    if stage.within == "tolerance":
        most = "" if stage.axis else f", 95 % {mm(stage.p95_mm)}"
        return f"{size}{most}, within the tolerance that the log names (tolerance_mm = {stage.tolerance_mm:g}), not within noise"
    whose = "reported" if stage.noise_told else "found"
    return f"{size}, within the noise ({mm(stage.noise_mm)}, as {whose})"


def unexplained(summary: DiagnosisSummary) -> list[str]:
    """Each shape of what is unexplained, in words; none where nothing is."""
    unknown = summary.unknown
    if not unknown.likely:
        return []
    sentences = [f"{_capital(between(s.stage, summary))}: {_shape(s)}{_shape_size(summary)}" for s in unknown.shapes]
    words = unknown.text.replace("stays unexplained", f"stays unexplained {withheld_text(summary)}").split("; ")
    sentences += [
        f"{_capital(w)}{_read_off(summary, w)}" for w in words if w and (not unknown.shapes or w.startswith(_READ_OFF))
    ]
    sentences += [
        f"{plain_name(name)} would fit, with a value that no such machine has: {why}"
        for name, why in unknown.implausible.items()
    ]
    return [printable(t) for t in sentences]


def _capital(words: str) -> str:
    return words[:1].upper() + words[1:]


def _shape_size(summary: DiagnosisSummary) -> str:
    """How far a single shape moves the tool, as the diagnosis's own text ends; "" where there are several, or no such end."""
    found = re.search(r"\((\S+ mm) rms at the TCP\)$", summary.unknown.text)
    return f", {found[1]} rms at the tool" if found and len(summary.unknown.shapes) == 1 else ""


def _read_off(summary: DiagnosisSummary, words: str) -> str:
    """What the axis's error that a text was read off from follows; "" where it is no such text, or the error follows nothing."""
    axis = words.removeprefix(f"{_STAGE['setpoint_to_encoder']}, ").split(" ")[0] if words.startswith(_READ_OFF) else ""
    return drive_follows(summary, axis)


def _shape(shape: UnknownShape) -> str:
    """A shape of the unexplained."""
    size = measure(shape.swing, shape.unit)
    if shape.follows == _CONSTANT:
        return f"{shape.moves} is off by {size}, whatever the posture"
    at_once = "at once" if shape.follows.startswith(_FROM) else "smoothly"
    return f"{shape.moves} deviates by {size} over the logs, {at_once} {_followed(shape)}"


def _followed(shape: UnknownShape) -> str:
    """With what a shape goes, or from when on it is there."""
    if shape.follows.startswith(_FROM) or shape.follows == _CONSTANT:
        return shape.follows
    return "with its own position" if shape.follows == shape.moves else f"with {shape.follows}"


def compensable_text(summary: DiagnosisSummary) -> str:
    """What `compensate` can make of it; "" where nothing is claimed."""
    compensable = summary.compensable
    if not (compensable.effects or compensable.left):
        return ""
    readings = {e.effect for e in summary.claimed if not e.of_machine}
    left = ", ".join(n for n in compensable.left if n.partition(" of ")[0] not in readings)
    if not compensable.effects:
        return printable(f"compensate has no constant for {plain_name(left)}: {_WITH}." if left else "")
    sizes = f"{mm(compensable.rms_before_mm)} to {mm(compensable.rms_after_mm)}"
    split = {n.partition(" of ")[0] for n in compensable.left}
    names = ", ".join(f"a part of {n}" if n in split else n for n in compensable.effects)
    rest = f"the rest of {left}" if split & {*compensable.effects} else left
    names, rest = plain_name(names), plain_name(rest)
    if compensable.shrink_interval[0] <= 0.0:
        why = (
            f"constants of the arm for {names} alone would not surely shrink the gap ({sizes}), so none are handed over"
        )
        return printable(f"{why[0].upper()}{why[1:]}{f'; for {rest}, too, {_WITH}' if rest else ''}.")
    return printable(f"compensate can correct {names} by constants: {sizes}{f'; for {rest} {_WITH}' if rest else ''}.")


def standards_text(one: Standard) -> str:
    """One line on a run that is a line or a circle."""
    parts = [f"{when}: {_deviations(run)}" for when, run in (("before", one.before), ("after", one.after))]
    size = f"circle of radius {one.radius_mm:.1f} mm" if one.length_mm is None else f"line of {one.length_mm:.0f} mm"
    return printable(f"{one.standard}, {one.log}, {size}; {'; '.join(parts)}")


def _deviations(run: RunStandard) -> str:
    """The figures of a line in both directions, or of a circle in both senses."""
    ways, turns = {"forward": run.forward, "back": run.back}, {"ccw": run.ccw, "cw": run.cw}
    values = [
        f"{name} AT {mm(way.AT_mm)}" + ("" if way.RT_mm is None else f", RT {mm(way.RT_mm)}")
        for name, way in ways.items()
        if way is not None
    ]
    values += [f"{name} G {mm(turn.G_mm)}" for name, turn in turns.items() if turn is not None]
    if run.circle is not None:
        both = {"G b": run.circle.G_b_mm, "H": run.circle.H_mm}
        values += [f"{name} {mm(value)}" for name, value in both.items() if value is not None]
    return ", ".join(values)


def only_first(entry: EffectFound) -> bool:
    """Whether an effect lies between program and set-point alone, apart from the gap."""
    return entry.stages == (_FIRST,)


def _listed(words: Sequence[str], by: str = ", ") -> str:
    """Words as a list that is read aloud."""
    return by.join(words) if by != ", " or len(words) < 2 else f"{', '.join(words[:-1])} and {words[-1]}"


def _place(summary: DiagnosisSummary) -> tuple[str, str]:
    """Where most of the gap sits, and what joins that to the next words."""
    stages = {k: v for k, v in summary.where.stages.items() if v is not None}
    whole = f"gap ({mm(summary.gap.rms_mm)} rms in the logs diagnosed)"
    most = max(stages, key=lambda k: stages[k])
    if most == _FIRST:
        part = stages[most] ** 2 / max(sum(v * v for v in stages.values()), 1e-12)
        return f"{_part(part)} what separates the measured TCP from the program sits {_STAGE[most]}", " and"
    inside = {k: v for k, v in stages.items() if k != _FIRST}
    if len(inside) == 1:
        return f"The {whole} lies {between(most, summary)}, the only stage that is logged", "; it"
    part = inside[most] ** 2 / max(sum(v * v for v in inside.values()), 1e-12)
    return f"{_part(part)} the {whole} sits {between(most, summary)}", " and"


def _part(value: float) -> str:
    return "All of" if value >= 0.995 else f"{share(value)} of"


def _follows(summary: DiagnosisSummary, claimed: Sequence[EffectFound]) -> str:
    """What the gap depends on most, of what its causes follow where any are claimed; "" where that is not clear."""
    shares, blamed = summary.where.regimes, summary.blamed_regimes
    shares = {k: v for k, v in shares.items() if k in blamed} or shares
    most = max(shares, key=lambda k: shares[k], default="")
    if most not in _FOLLOWS or shares[most] <= 0.5:
        return ""
    if most == "direction" and len(claimed) == 1 and len(claimed[0].axes) == 1:
        return f"reverses with {claimed[0].axes[0]}'s direction"
    return _FOLLOWS[most]


def _named(entry: EffectFound, read: str = "") -> str:
    """An effect with its axes, its values where they are few, else by how much it moves the TCP; how sure it is, and
    what its drive's log shows (read).
    """
    name, chance = plain_name(entry.called), f"{sure(entry.probability)} sure{read}"
    values = {k: v.value for k, v in entry.parameters.items()}
    axes = [a for a in entry.axes if f"{a}_deg" in values or f"{a}_mm" in values or f"{a}_rad_nm" in values]
    if len(axes) == len(entry.axes) and 0 < len(axes) <= _MOST_VALUES:
        own = [next((k, v) for k, v in values.items() if parameter_words(k)[0] == a) for a in axes]
        each = [f"{a}, {measure(v, parameter_words(k)[1])}" for a, (k, v) in zip(axes, own, strict=True)]
        return f"{name} of {_listed(each) if len(each) == 1 else ' and of '.join(each)} ({chance})"
    ripples = waves(entry.parameters)
    if ripples:
        axis, order = max(ripples, key=lambda k: ripples[k])
        return f"{name} of {axis}, {measure(ripples[axis, order], 'degrees')} {order} times a turn ({chance})"
    where = f" of {_listed(entry.axes[:4])}" if entry.axes else ""
    values = {k: v for k, v in values.items() if k in _MAIN} or values
    if len(values) == 1:
        ((key, value),) = values.items()
        words, unit = parameter_words(key)
        odd = _odd_axes(entry, key, value)
        if odd:
            each = [f"of {axis} {measure(own, unit)}" for axis, own in odd.items()]
            return f"{name}, {measure(value, unit)}, {_listed(each)} ({chance})"
        place = f" of {words.replace(' by ', ' to ')}" if "_by_" in key else where
        return f"{name}{place}, {measure(value, unit)} ({chance})"
    return f"{name}{where}, {mm(entry.moves_mm)} rms at the TCP ({chance})"


def _odd_axes(entry: EffectFound, key: str, common: float) -> dict[str, float]:
    """Axes whose value is far from the one that all others share, with their own."""
    unit = key.rpartition("_")[2]
    beyond = {k.removesuffix(f"_beyond_{unit}"): v.value for k, v in entry.parameters.items() if "_beyond_" in k}
    return {axis: common + own for axis, own in beyond.items() if abs(own) > _ODD * abs(common)}


def _best_single(summary: DiagnosisSummary) -> str:
    """What the best single effect would leave, where it is some help."""
    before = summary.together.rms_before_mm
    able = [e for e in summary.effects if not e.implausible and not only_first(e)]
    best = min(able, key=lambda e: e.alone.rms_after_mm, default=None)
    if best is None or best.alone.rms_after_mm > 0.9 * before:
        return ""
    left, noise = mm(best.alone.rms_after_mm), mm(summary.gap.noise_mm)
    return (
        f": {withheld_text(summary)}, the best single effect, {plain_name(best.called)}, would take {mm(before)} to {left}, "
        f"with a noise of {noise}, and is {sure(best.probability)} sure"
    )


def _unknown_words(summary: DiagnosisSummary, *, claimed: bool) -> str:
    """The second statement: how much stays that nothing explains, where that is likely, and at which axes."""
    unknown = summary.unknown
    if not unknown.likely:
        return ""
    sentences = unexplained(summary)
    at: dict[str, list[str]] = {}
    for s in unknown.shapes:
        at.setdefault(s.moves, []).append(_followed(s))
    text = f" {_stays(summary)}" if claimed else " Something unknown is at work"
    if at:
        parts = []
        for place, what in at.items():
            moving = [w for w in what if w != _CONSTANT]
            parts += [f"{place} is off by a constant"] if len(moving) < len(what) else []
            parts += [f"{place} deviates {_listed(moving)}"] if moving else []
        text += ": " + "; ".join(parts)
    elif sentences and (sentences[0].startswith("Between") or unknown.implausible):
        text += f": {sentences[0][0].lower()}{sentences[0][1:]}"
    elif unknown.where.comes_back:
        text += f"{'; it' if claimed else ', and'} comes back {unknown.where.comes_back}"
    elif unknown.where.regimes:
        text += f"{'; it' if claimed else ', and'} follows {_listed(_of_rest(summary, unknown.where.regimes[:2]))}"
    elif not claimed:
        text += ": what remains is correlated, beyond the noise"
    if claimed:
        text += f". It is {sure(unknown.probability)} sure that a cause that the library lacks has a part in that rest"
    return text + "."


def _of_rest(summary: DiagnosisSummary, regimes: Sequence[str]) -> list[str]:
    """Regimes that the rest follows, each with its share of the rest where that was found."""
    shares = {s.regime: s.share for s in summary.residual.structure if s.share >= _NAMED}
    return [f"{r} ({share(shares[r])} of that rest)" if r in shares and summary.claimed else r for r in regimes]


def _stays(summary: DiagnosisSummary) -> str:
    """How much remains unexplained, besides the noise, on the same samples as the sizes before."""
    unknown, noise = summary.unknown, summary.gap.noise_mm
    times = unknown.rms_mm / noise if noise > 0.0 else 0.0
    beside = f", {times:.{1 if times < 10.0 else 0}f} times the noise," if times >= _TIMES else ""
    part = f", {share(unknown.share)} of the energy that the gap has there" if unknown.share > _WORTH else ""
    return f"Besides, {mm(unknown.rms_mm)}{beside} remains unexplained there{part}"
