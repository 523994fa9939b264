"""Motion statements: where they lead, component by component, and how."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from camrob.witness.frames import euler
from camrob.witness.krl.columns import AXES, CIRC, LIN, POSE
from camrob.witness.krl.state import Here, State
from camrob.witness.krl.text import HOW, Line, Source
from camrob.witness.krl.text import POSE as PARTS
from camrob.witness.krl.values import UnknownError, Value, split_top
from camrob.witness.krl.with_part import with_words

__all__ = ["add_rows", "motion", "relative"]

_ROUND = r"(?:(?:[ ,]+|(?<=\}))C_(?:DIS|PTP|VEL|ORI|SPL)\b)*"
_OPTIONS = re.compile(
    rf"(?P<target>.*?)(?P<round>{_ROUND})(?: (?P<frame>#BASE|#TOOL))?(?: ?WITH (?P<extra>.+?)(?P<behind>{_ROUND}))?"
)
_NO_MOTION = re.compile(r"\$(?:POS_ACT|AXIS_ACT|AXIS_ACT_MEAS|POS_INT|AXIS_INT)")
_EXTERNALS = [f"E{k}" for k in range(1, 7)]
_ARM = tuple(f"A{k}" for k in range(1, 7))
_TYPES = {
    kind: frozenset(("", *own, *_EXTERNALS[:count]))
    for kind, own, count in (
        ("FRAME", PARTS, 0),
        ("POS", (*PARTS, "S", "T"), 0),
        ("E3POS", (*PARTS, "S", "T"), 3),
        ("E6POS", (*PARTS, "S", "T"), 6),
        ("AXIS", _ARM, 6),  # RoboDK's posts write external axes in it
        ("E3AXIS", _ARM, 3),
        ("E6AXIS", _ARM, 6),
    )
}
"""What the types of a point hold; one that is given without its type is of the widest."""
_NAN = float("nan")


def _components(state: State, text: str) -> dict[str, Value]:
    """The aggregate that a motion leads to; raises UnknownError."""
    value = state.variables.value(text)
    if not isinstance(value, dict):
        raise UnknownError(f"{text} is not a point")
    kind = str(value.get("", ""))
    if kind and not value.keys() <= _TYPES.get(kind, frozenset()):
        raise UnknownError(f"it has components that no {kind} has")
    if not value.keys() <= _TYPES["E6POS"] and not value.keys() <= _TYPES["E6AXIS"]:
        raise UnknownError(f"it has components that are no {'pose' if 'X' in value else 'point'}'s")
    return value


def _given(value: dict[str, Value], name: str) -> float | None:
    """One component, None where it is left out; raises UnknownError where it is no number."""
    given = value.get(name)
    if given is None:
        return None
    if isinstance(given, bool) or not isinstance(given, int | float) or not np.isfinite(given):
        raise UnknownError(f"{name} is not a number")
    return float(given)


def _pose(state: State, value: dict[str, Value]) -> list[float]:
    """X..C, a component that is left out being where the robot was sent last; raises UnknownError."""
    given = [_given(value, name) for name in PARTS]
    if None not in given:
        return [float(number) for number in given if number is not None]
    kept = state.pose_here()
    return [old if number is None else number for number, old in zip(given, kept, strict=True)]


def _externals(state: State, value: dict[str, Value], add: bool = False) -> list[float]:
    """The external axes after the motion; one that is left out, or that the cell hasn't, keeps its value."""
    out = list(state.external)
    for k, name in enumerate(state.machine.axis_names[6:]):
        number = _given(value, name)
        if number is not None:
            out[k] = number + (out[k] if add else 0.0)
    return out


def _whole(value: dict[str, Value], name: str) -> int:
    """S or T, -1 where left out."""
    number = _given(value, name)
    return -1 if number is None else int(number)


def _lost_motion(state: State, line: Line, reason: UnknownError) -> None:
    state.gap(line, f"where it leads isn't known ({reason})")
    state.here = Here()


def _check(state: State, line: Line, arc: bool, straight: bool) -> None:
    """What stands against reading a pose here, or leaves a motion's way unjudged."""
    base = state.bases[state.base]
    if base.fault is not None and base.fault not in state.objections:
        state.objections.append(base.fault)
    if base.doubt:
        state.unsure(line.number, base.doubt)
    if base.values is None or state.tools[state.tool] is None:
        name = "$BASE" if base.values is None else "$TOOL"
        state.gap(line, f"the text doesn't say which {name} holds here, so where the tool goes isn't judged")
    for name in state.reset:
        state.unsure(
            line.number, f"BAS(#INITMOV) comes after {name} was set: which one holds from there on isn't in the text"
        )
    unlike = state.unlike_line or (state.unlike_arc if arc else "")
    if unlike and (arc or straight):
        state.gap(line, f"how the tool turns on its way isn't judged ({unlike})")


def _add(state: State, how: int, pose: list[float], axes: list[float], line: Line, **more: object) -> None:
    """One more motion. `more`: middle, sweep, status, turn, rounds, of which any may be left out."""
    state.room(1)
    state.settle()
    state.close_steps()
    rounds = bool(more.get("rounds", False)) and state.rounds
    state.moves(line.number, how < LIN, rounds)
    middle, sweep = more.get("middle", [_NAN] * 3), more.get("sweep", _NAN)
    status, turn = more.get("status", -1), more.get("turn", -1)
    speed = state.speed if how in (LIN, CIRC) else _NAN
    constant = state.constant and how in (LIN, CIRC)
    single = (how, pose, middle, sweep, axes, status, turn, state.base, state.tool, constant, speed, not rounds)
    state.columns.add((*single, line.number, state.file))  # type: ignore[arg-type]
    state.external = axes[6:]
    state.here = Here(None if how == AXES else pose, axes if how == AXES else None, state.base, state.tool)
    state.arrived()


def motion(state: State, match: re.Match[str], line: Line) -> None:
    """PTP, LIN, CIRC, their spline twins, and SPL."""
    options = _OPTIONS.fullmatch(match["rest"])
    word, text = match["word"], options["target"].strip() if options is not None else match["rest"]
    if _NO_MOTION.fullmatch(text):
        if state.here.pose is not None:
            state.unsure(line.number, f"{line.raw[:80]}: it stops on the way, or brings the robot back to where it is")
        return  # where the robot is already
    if word == "SPL":
        state.gap(line, "a spline's curve between its points isn't judged")
    if word.startswith("S"):
        state.needs_splines(line)
    rounds = _rounds(state, word, options, line)
    with with_words(state, "" if options is None else options["extra"] or "", line):
        try:
            _move(state, word.removeprefix("S") if word != "SPL" else "LIN", split_top(text), rounds, line)
        except UnknownError as reason:
            state.close_steps()
            _lost_motion(state, line, reason)


def _rounds(state: State, word: str, options: re.Match[str] | None, line: Line) -> bool:
    """Whether the corner behind a motion is rounded, noted where the cell doesn't say how far."""
    said = "" if options is None else (options["round"] + " " + (options["behind"] or "")).strip(" ,")
    rounds = bool(said) or word == "SPL"
    if rounds and (word in ("SPTP", "PTP", "SPL") or not _settled(state, "S" if word.startswith("S") else "", said)):
        state.vague.append((state.count, line.number, state.file))
    return rounds


def _settled(state: State, kind: str, word: str) -> bool:
    """Whether the cell states how far a motion of a path is rounded by a word behind it. SLIN ("S") and its kin are rounded by
    distance, whichever word says so (KSS 8.3, approximation of single spline motions).
    """
    if kind:
        return word in ("C_SPL", "C_DIS")
    return word == "C_DIS" or (
        word in ("C_VEL", "C_ORI") and f"$APO.{word.replace('_', '')}" in state.machine.controller.settings
    )


def _move(state: State, word: str, targets: list[str], rounds: bool, line: Line) -> None:
    """PTP, LIN or CIRC to what the targets say; raises UnknownError."""
    if word == "CIRC":
        _circle(state, targets, rounds, line)
        return
    if len(targets) != 1:
        raise UnknownError("it names more than one point")
    value = _components(state, targets[0])
    arm = [_given(value, f"A{k + 1}") for k in range(6)]
    if any(number is not None for number in arm) or "AXIS" in str(value.get("", "")):
        if word != "PTP":
            raise UnknownError("a path is given by axes")
        kept = [_NAN] * 6 if state.here.axes is None else state.here.axes[:6]
        axes = [old if number is None else number for number, old in zip(arm, kept, strict=True)]
        _add(state, AXES, [_NAN] * 6, axes + _externals(state, value), line, rounds=rounds)
        return
    if word == "PTP" and "" not in value and not any(name in value for name in PARTS):
        raise UnknownError("whether it gives a pose or axes can't be told")
    pose = _pose(state, value)
    _check(state, line, arc=False, straight=word == "LIN")
    axes = [_NAN] * 6 + _externals(state, value)
    how = LIN if word == "LIN" else POSE
    _add(state, how, pose, axes, line, rounds=rounds, status=_whole(value, "S"), turn=_whole(value, "T"))


def _circle(state: State, targets: list[str], rounds: bool, line: Line) -> None:
    """CIRC middle, end[, CA angle]; raises UnknownError."""
    sweep = _NAN
    if len(targets) == 3 and targets[2].startswith("CA "):
        sweep = state.variables.number(targets[2][3:])
    elif len(targets) != 2:
        raise UnknownError("a circle takes an auxiliary point, an end and at most CA")
    value = _components(state, targets[1])
    middle = _pose(state, _components(state, targets[0]))
    pose = _pose(state, value)
    _check(state, line, arc=True, straight=False)
    axes = [_NAN] * 6 + _externals(state, value)
    _add(state, CIRC, pose, axes, line, rounds=rounds, middle=middle[:3], sweep=sweep)
    if not np.isnan(sweep):
        state.here = Here()  # CA ends elsewhere than at the point given


def relative(state: State, match: re.Match[str], line: Line) -> None:
    """LIN_REL, PTP_REL and their spline twins."""
    options = _OPTIONS.fullmatch(match["rest"])
    word = match["word"]
    if word.startswith("S"):
        state.needs_splines(line)
    rounds = _rounds(state, word, options, line)
    extra = "" if options is None else options["extra"] or ""
    with with_words(state, extra if word.startswith("S") else "", line):
        try:
            if options is None or (extra and not word.startswith("S")):
                raise UnknownError("it has more to it than a step")
            _step(state, word.removeprefix("S"), options, rounds, line)
        except UnknownError as reason:
            state.close_steps()
            _lost_motion(state, line, reason)


def _step(state: State, word: str, options: re.Match[str], rounds: bool, line: Line) -> None:
    """LIN or PTP by so much; raises UnknownError."""
    value = _components(state, options["target"])
    if any(_given(value, name) for name in "ABC"):
        raise UnknownError("it turns the tool by angles")
    arm = [_given(value, f"A{k + 1}") for k in range(6)]
    if any(number is not None for number in arm):
        if word != "PTP" or state.here.axes is None or options["frame"] == "#TOOL":
            raise UnknownError("the axes that it begins at aren't in the text")
        sums = [old + (number or 0.0) for old, number in zip(state.here.axes[:6], arm, strict=True)]
        _add(state, AXES, [_NAN] * 6, sums + _externals(state, value, add=True), line, rounds=rounds)
        return
    kept = state.pose_here()
    step = np.array([_given(value, name) or 0.0 for name in PARTS])
    if options["frame"] == "#TOOL":
        step[:3] = euler(np.array(kept[3:])) @ step[:3]
    pose = [old + float(more) for more, old in zip(step, kept, strict=True)]
    _check(state, line, arc=False, straight=word == "LIN")
    axes = [_NAN] * 6 + _externals(state, value, add=True)
    _add(state, LIN if word == "LIN" else POSE, pose, axes, line, rounds=rounds)


def _kept(column: NDArray[np.float64], first: float) -> NDArray[np.float64]:
    """A column in which NaN keeps the value before it, `first` at the beginning."""
    known = ~np.isnan(column)
    last = np.maximum.accumulate(np.where(known, np.arange(len(column)), -1))
    return np.where(last < 0, first, column[np.maximum(last, 0)])


def add_rows(state: State, source: Source, first: int, last: int) -> None:
    """LIN and `$VEL.CP` lines first to last of a source, which were read as columns."""
    low, high = np.searchsorted(source.row_line, [first, last + 1])
    start, stop = np.searchsorted(source.speed_line, [first, last + 1])
    if state.after_next and high - low > 1:  # something happens at the end of the first
        split = int(source.row_line[low])
        add_rows(state, source, first, split)
        add_rows(state, source, split + 1, last)
        return
    count = int(high - low)
    lines, speeds = source.row_line[low:high], np.append(source.speed[start:stop], state.speed)
    at = np.searchsorted(source.speed_line[start:stop], lines) - 1  # -1: the speed of before, put last
    if count:
        line = Line(int(lines[0]), "LIN", "", "LIN ..")
        state.room(count)
        state.settle()
        state.close_steps()
        _check(state, line, arc=False, straight=True)
        pose, external = source.pose[low:high], source.external[low:high]
        axes = np.full((count, len(state.machine.axis_names)), np.nan)
        for k, name in enumerate(state.machine.axis_names[6:]):
            axes[:, 6 + k] = _kept(external[:, int(name[1]) - 1], state.external[k])
        rounded = source.rounded[low:high]
        exact = np.array([not word for _, word in HOW])[rounded] | (not state.rounds)
        state.moves(int(lines[0]), False, not exact.all())
        vague = np.flatnonzero(~exact & ~np.array([_settled(state, *how) for how in HOW])[rounded])
        splines = np.flatnonzero(np.array([bool(kind) for kind, _ in HOW])[rounded])
        if len(splines):
            state.needs_splines(Line(int(lines[splines[0]]), "SLIN", "", "SLIN .."))
        state.vague += [
            (state.count + k, int(lines[k]), state.file) for k in vague[:1].tolist() + vague[1:][-1:].tolist()
        ]
        state.external = [float(value) for value in axes[-1, 6:]]
        state.add_lines(pose, axes, speeds[at], exact, lines)
    if stop > start:
        state.speed = float(source.speed[stop - 1])
        wrong = np.flatnonzero(source.speed[start:stop] <= 0.0)
        if len(wrong):
            state.object(
                "speed", "$VEL.CP is set to 0 m/s, and has to be above 0", int(source.speed_line[start + wrong[0]])
            )
