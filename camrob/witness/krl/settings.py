"""What assignments to system variables do to the state: frames, speeds, how the tool turns, outputs."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

from camrob.witness.frames import angle_of, frame, inverse
from camrob.witness.happenings import Objection
from camrob.witness.krl.conduct import unlike
from camrob.witness.krl.state import Base, State
from camrob.witness.krl.text import Line
from camrob.witness.krl.values import UnknownError, split_top

__all__ = [
    "SETTINGS",
    "note_conduct",
    "number_or_nan",
    "numbered_frame",
    "put_circling",
    "put_output",
    "put_speed",
    "put_turning",
]

_EK = re.compile(r"EK ?\((?P<inputs>.+)\)")
_ROOT = re.compile(r"MACHINE_DEF ?\[(?P<number>.+)\]\.(?:ROOT|MECH_TYPE)")
_SAME_FRAME = (1e-6, 1e-6)  # m, rad: what rounding to six digits leaves


def put_output(state: State, line: Line, name: str, value: str) -> None:
    """An output by number or name; what a variable on the right stands for is put in where it is a plain one or a truth."""
    plain = re.fullmatch(r"[A-Z_]\w*", value) and value not in ("TRUE", "FALSE")
    try:
        known = state.variables.value(value)
        if isinstance(known, bool):
            value = "TRUE" if known else "FALSE"
        elif plain:
            value = str(known)
    except UnknownError as reason:
        if plain:
            state.gap(line, f"the value isn't known ({reason})")
    state.step(line, "output", f"{state.signals.get(name, name)}={value}", number_or_nan(state, value))


def number_or_nan(state: State, text: str) -> float:
    """The number that an expression stands for, NaN where the program doesn't hold it."""
    try:
        return state.variables.number(text)
    except UnknownError:
        return float("nan")


def put_speed(state: State, speed: float, line: Line) -> None:
    """The tip's speed from here on, m/s."""
    state.speed = speed
    if speed <= 0.0:
        state.object("speed", f"$VEL.CP is set to {speed:g} m/s, and has to be above 0", line)


def _switch(state: State, match: re.Match[str], line: Line, value: str) -> None:
    put_output(state, line, match.string, value)


def _setting(state: State, match: re.Match[str], line: Line, value: str) -> None:
    state.step(line, "other")


def _conduct(state: State, match: re.Match[str], line: Line, value: str) -> None:
    """A setting of how it moves, or an aggregate of some."""
    note_conduct(state, match.string, value)
    state.step(line, "other")


def note_conduct(state: State, name: str, text: str) -> None:
    """Puts a setting, or each component of an aggregate of settings, in force; NaN where the text doesn't say the value."""
    try:
        value = state.variables.value(text)
    except UnknownError:
        value = float("nan")
    for part, item in value.items() if isinstance(value, dict) else (("", value),):
        if part or not isinstance(value, dict):
            plain = isinstance(item, int | float) and not isinstance(item, bool)
            state.conduct.set(f"{name}.{part}" if part else name, float(item) if plain else float("nan"))  # type: ignore[arg-type]


def _changed(state: State, old: tuple[float, ...] | None, part: str, value: str) -> tuple[float, ...] | None:
    """A frame with one component set, X..C."""
    number = state.variables.number(value)
    if old is None:
        raise UnknownError("the frame that it is part of isn't known")
    return tuple(number if name == part else kept for name, kept in zip("XYZABC", old, strict=True))


def _base(state: State, match: re.Match[str], line: Line, value: str) -> None:
    """`$BASE`, whole or one component."""
    old = state.bases[state.base]
    try:
        if match["part"]:
            fault = (
                None
                if old.fault is None
                else Objection(old.fault.code, old.fault.text, line=line.number, file=state.file)
            )
            state.set_base(Base(_changed(state, old.values, match["part"], value), old.follows, fault))
            return
        coupled = _EK.fullmatch(value)
        if coupled is not None:
            state.set_base(_coupled(state, coupled, line))
        else:
            state.set_base(Base(state.frame_of(state.variables.value(value)), False, _fixed_base(state, line)))
    except UnknownError as reason:
        state.gap(line, f"$BASE isn't known from here on ({reason})")
        state.set_base(Base(None, False))


def _fixed_base(state: State, line: Line) -> Objection | None:
    """What is wrong with a base that stands still, where the cell has it turn."""
    if not state.machine.follows or not any(joint.role == "workpiece" for joint in state.machine.joints):
        return None
    text = f"{line.raw[:60]}: $BASE is set without EK(), so it does not turn with the table as the cell says it does"
    return Objection("base-stands-still", text, line=line.number, file=state.file)


def numbered_frame(state: State, line: Line, name: str, number: float) -> None:
    """`$TOOL` or `$BASE` from the controller's list; number 0 is the plate, or the world. A tool brings its own load data."""
    state.conduct.set_row(f"$ACT_{name}", number)
    if name == "TOOL":
        state.set_load(line.number, None)
    text = "$NULLFRAME" if number == 0 else f"{name}_DATA[{int(number)}]"
    try:
        values = state.frame_of(state.variables.value(text))
    except UnknownError as reason:  # no harm where the program sets the frame itself before it moves
        state.unknown_row(name, line, f"${name} isn't known from here on ({reason})")
        return
    if name == "TOOL":
        state.set_tool(values)
    else:
        state.set_base(_of_table(state, values, int(number), line))


def _of_table(state: State, values: tuple[float, ...], number: int, line: Line) -> Base:
    """A base by its row: BAS couples it to the mechanism that MACHINE_FRAME_DAT names for the row (KUKA's BAS.SRC)."""
    fixed = _fixed_base(state, line)
    if fixed is None or not number:
        return Base(values, False, fixed)
    row, wanted = f"MACHINE_FRAME_DAT[{number}]", state.machine.controller.mechanism
    try:
        index = state.variables.number(f"{row}.MACH_DEF_INDEX")
    except UnknownError:
        text = f"{line.raw[:60]}: whether this base turns with the table stands in the controller's {row}, and not in the program"
        return Base(values, True, None, text)
    if index <= 0.0:
        return Base(values, False, fixed)
    if index == wanted:
        return Base(values, True)
    text = f"{line.raw[:60]}: {row} hangs the base on MACHINE_DEF[{index:g}], another mechanism than the cell's"
    return Base(values, True, Objection("base-other-mechanism", text, line=line.number, file=state.file))


def _coupled(state: State, match: re.Match[str], line: Line) -> Base:
    """`$BASE = EK(root, mechanism, frame)`: the base turns with that mechanism."""
    inputs = split_top(match["inputs"])
    if len(inputs) != 3:
        raise UnknownError("EK() takes three values")
    numbers = [state.variables.number(found["number"]) for text in inputs[:2] if (found := _ROOT.fullmatch(text))]
    if len(numbers) != 2:
        raise UnknownError(f"{inputs[0]} and {inputs[1]} are not MACHINE_DEF[n].ROOT and .MECH_TYPE")
    values = state.frame_of(state.variables.value(inputs[2]))
    wanted = state.machine.controller.mechanism
    if wanted is None:
        raise UnknownError("the cell doesn't say which mechanism carries the part")
    if numbers == [wanted, wanted]:
        return Base(values, True)
    text = f"{line.raw[:60]}: the base hangs on another mechanism than the cell's, which is MACHINE_DEF[{wanted}]"
    return Base(values, True, Objection("base-other-mechanism", text, line=line.number, file=state.file))


def _tool(state: State, match: re.Match[str], line: Line, value: str) -> None:
    """`$TOOL`, whole or one component."""
    try:
        if match["part"]:
            state.set_tool(_changed(state, state.tools[state.tool], match["part"], value))
        else:
            state.set_tool(state.frame_of(state.variables.value(value)))
    except UnknownError as reason:
        state.gap(line, f"$TOOL isn't known from here on ({reason})")
        state.set_tool(None)


def _load(state: State, match: re.Match[str], line: Line, value: str) -> None:
    """`$LOAD`, whole or a component of it."""
    try:
        given = state.variables.value(value)
    except UnknownError:
        given = {}
    state.change_load(line.number, match["part"] or "", given)
    state.step(line, "other")


def _speed(state: State, match: re.Match[str] | None, line: Line, value: str) -> None:
    """`$VEL.CP`."""
    try:
        put_speed(state, state.variables.number(value), line)
    except UnknownError as reason:
        state.gap(line, f"the speed isn't known from here on ({reason})")
        state.speed = float("nan")
    state.step(line, "other")


def _speeds(state: State, match: re.Match[str], line: Line, value: str) -> None:
    """`$VEL = {CP .., ORI1 .., ORI2 ..}`."""
    try:
        given = state.variables.value(value)
        if not isinstance(given, dict) or "CP" not in given:
            raise UnknownError("CP isn't among them")
        _speed(state, None, line, str(given["CP"]))
    except UnknownError as reason:
        state.gap(line, f"the speed isn't known from here on ({reason})")
        state.speed = float("nan")
    note_conduct(state, "$VEL", value)
    state.conduct.values.pop("$VEL.CP", None)  # the feed's rule has it


def _advance(state: State, match: re.Match[str], line: Line, value: str) -> None:
    try:
        state.rounds = state.variables.number(value) > 0.0
        if not state.rounds and state.machine.controller.own.get("advance"):
            state.object(
                "no-advance", "$ADVANCE = 0: the robot stops at every point of a cut, as the cell does not", line
            )
    except UnknownError:
        state.rounds = True  # the safer reading: corners may be rounded
    state.step(line, "other")


def put_turning(state: State, value: str) -> None:
    """`$ORI_TYPE` from here on."""
    state.constant = value == "#CONSTANT"
    state.unlike_line = "" if value in ("#VAR", "#CONSTANT") else f"$ORI_TYPE = {value}"


def put_circling(state: State, value: str) -> None:
    """`$CIRC_TYPE` from here on."""
    state.unlike_arc = "" if value == "#BASE" else f"$CIRC_TYPE = {value}"


def _ori_type(state: State, match: re.Match[str], line: Line, value: str) -> None:
    put_turning(state, _word(state, value))
    state.step(line, "other")


def _circ_type(state: State, match: re.Match[str], line: Line, value: str) -> None:
    put_circling(state, _word(state, value))
    state.step(line, "other")


def _word(state: State, text: str) -> str:
    """The word of an enumeration that a text stands for; the text itself where that isn't known."""
    try:
        value = state.variables.value(text)
    except UnknownError:
        return text
    return value if isinstance(value, str) else text


def _ipo_mode(state: State, match: re.Match[str], line: Line, value: str) -> None:
    if value != "#BASE":
        state.object("external-tool", f"$IPO_MODE = {value}: the cell's tool is on the arm, not in the cell", line)
    state.step(line, "other")


def _moved_frame(state: State, match: re.Match[str], line: Line, value: str) -> None:
    """`$ROBROOT`, `$WORLD`: right only where nothing changes."""
    name = match["which"]
    zero = np.zeros((1, len(state.machine.axis_names)))
    expected = np.eye(4)
    if name == "ROBROOT":
        expected = inverse(state.machine.base_T_controller) @ state.machine.base_T_root(zero)[0]
    try:
        given = frame(np.array(state.frame_of(state.variables.value(value))))
        gone = float(np.linalg.norm(given[:3, 3] - expected[:3, 3]))
        turned = float(angle_of((expected[:3, :3].T @ given[:3, :3])[None])[0])
        same = match.string == f"${name}" and gone < _SAME_FRAME[0] and turned < _SAME_FRAME[1]
    except UnknownError:
        same = False
    if not same:
        text = f"{line.raw[:60]}: ${name} is set to another place than the cell has it; every pose would be elsewhere"
        state.object("robroot" if name == "ROBROOT" else "world", text, line)


def _act_ex_ax(state: State, match: re.Match[str], line: Line, value: str) -> None:
    wanted = state.machine.controller.act_ex_ax
    try:
        given = state.variables.number(value)
    except UnknownError as reason:
        state.gap(line, f"how many external axes take part isn't known ({reason})")
        return
    state.conduct.set("$ACT_EX_AX", given)
    if wanted is not None and given != wanted:
        state.object("external-axes", f"$ACT_EX_AX = {given:g}, where the cell has {wanted}", line)
    state.step(line, "other")


def _async_axis(state: State, match: re.Match[str], line: Line, value: str) -> None:
    try:
        given = state.variables.number(value)
    except UnknownError:
        given = -1.0
    if given != 0.0:
        state.object("async-axis", f"{line.raw[:60]}: external axes no longer follow the motions", line)


def _bounded(state: State, match: re.Match[str], line: Line, value: str) -> None:
    """A setting that the cell names."""
    name, own = match.string, state.machine.controller.settings.get(match.string)
    note_conduct(state, name, value)
    state.step(line, "other")
    try:
        given = state.variables.number(value)
    except UnknownError as reason:
        state.gap(line, f"its value isn't known ({reason})")
        return
    found = None if own is None else unlike(name, given, own)
    if found is None:
        return
    code, text, grave = found
    state.object(code, text, line, "error" if grave else "warning")
    if grave:
        state.conduct.said.add(text)


def _row(state: State, match: re.Match[str], line: Line, value: str) -> None:
    """`$ACT_TOOL`, `$ACT_BASE`."""
    state.conduct.set_row(match.string, number_or_nan(state, value))
    state.step(line, "other")


def _override(state: State, match: re.Match[str], line: Line, value: str) -> None:
    if not re.fullmatch(r"100(?:\.0*)?", value):
        state.object("override", f"{line.raw[:60]}: all speeds are other than $VEL.CP says", line)


SETTINGS: dict[str, Callable[[State, re.Match[str], Line, str], None]] = {
    "nothing": _setting,
    "conduct": _conduct,
    "base": _base,
    "tool": _tool,
    "load": _load,
    "speed": _speed,
    "speeds": _speeds,
    "advance": _advance,
    "ori_type": _ori_type,
    "circ_type": _circ_type,
    "ipo_mode": _ipo_mode,
    "moved_frame": _moved_frame,
    "act_ex_ax": _act_ex_ax,
    "async_axis": _async_axis,
    "switch": _switch,
    "bounded": _bounded,
    "override": _override,
    "row": _row,
}
