"""What each statement of the table does to the state: declarations, outputs, BAS. System variables are in
`settings`, motions in `motion`, flow in `run`.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from camrob.witness.krl.conduct import ACC_PTP, PTP
from camrob.witness.krl.motion import motion, relative
from camrob.witness.krl.settings import (
    SETTINGS,
    note_conduct,
    number_or_nan,
    numbered_frame,
    put_circling,
    put_output,
    put_turning,
)
from camrob.witness.krl.state import Base, State
from camrob.witness.krl.statements import BAS, variable
from camrob.witness.krl.text import Line
from camrob.witness.krl.values import UnknownError, split_top

__all__ = ["ACTS", "STANDARD", "Act"]

Act = Callable[[State, re.Match[str], Line], None]

STANDARD = (
    "PDAT_ACT",
    "LDAT_ACT",
    "FDAT_ACT",
    "BASE_DATA",
    "TOOL_DATA",
    "LOAD_DATA",
    "MACHINE_FRAME_DAT",
)  # of every controller's $config.dat
_TABLES = {"BASE_DATA": "base_number", "TOOL_DATA": "tool_number", "LOAD_DATA": ""}  # and the cell's key for its row


def _nothing(state: State, match: re.Match[str], line: Line) -> None:
    """Neither frames nor outputs nor motions."""
    state.step(line, "other")


def _declare(state: State, match: re.Match[str], line: Line) -> None:
    """Names become known, with their values where they have some."""
    common = "GLOBAL" in line.code.split("=")[0].split(" ")
    place = state.variables.common if common else state.variables.own
    for item in split_top(match["items"]):
        name, _, text = item.partition("=")
        name = name.strip()
        bare = name.split("[")[0]
        state.variables.known.add(bare)
        place.kinds[bare] = match["type"]
        if not text:
            if name in place and place is state.variables.own:  # a parameter
                place.put(name, place[name])
            else:
                place.pop(name, None)
            continue
        try:
            value = state.variables.value(text)
        except UnknownError:
            continue
        place.put(name, {"": match["type"], **value} if isinstance(value, dict) and "" not in value else value)


def _structure(state: State, match: re.Match[str], line: Line) -> None:
    """Which components of a structure are whole numbers: STRUC NAME TYPE A,B, TYPE C."""
    kind = ""
    for item in split_top(match["parts"]):
        *types, name = item.split(" ")
        if len(types) > 1:
            state.gap(line, "what it declares can't be told")
        kind = types[-1] if types else kind
        if kind == "INT":
            state.variables.whole.add(name.split("[")[0])
    state.step(line, "other")


def _signal(state: State, match: re.Match[str], line: Line) -> None:
    """A name for an output."""
    state.signals[match["name"]] = match["what"].replace(" ", "")


def _interrupt(state: State, match: re.Match[str], line: Line) -> None:
    """Remembered until it is switched on."""
    state.interrupts[match["number"].strip()] = (match["when"], match["what"])


def _interrupt_on(state: State, match: re.Match[str], line: Line) -> None:
    """From here on a routine may run at any time. KUKA's own for stop messages, switched on before anything moves, reports."""
    number = match["number"].strip()
    when, what = state.interrupts.get(number, ("", "what an earlier program has declared"))
    template = re.fullmatch(r"\$STOPMESS ?== ?TRUE", when) and re.fullmatch(r"IR_STOPM ?\( ?\)", what)
    if number != "3" or not template or state.here.pose is not None:
        state.gap(line, f"{what} may run at any time from here on, and what it does isn't judged")


def _borrow(state: State, match: re.Match[str], line: Line) -> None:
    """EXT with a module in front of the routine."""
    state.gap(line, f"it takes {match['name']} from {match['place']}, and what that does isn't judged")


def _trigger(state: State, match: re.Match[str], line: Line) -> None:
    """The statement behind DO, where the next motion begins or ends: DISTANCE 0 or 1, or PATH 0, and no DELAY."""
    what = Line(line.number, match["what"], line.comment, line.raw)
    assigned = re.fullmatch(r"(?P<name>\$(?:OUT|ANOUT) ?\[.+?\]|[A-Z_]\w*) ?= ?(?P<value>.+)", what.code)
    if assigned is None or (not assigned["name"].startswith("$") and assigned["name"] not in state.signals):
        state.gap(line, "a trigger that does more than set an output isn't judged")
        return
    try:
        where, delay = state.variables.number(match["where"]), state.variables.number(match["delay"])
    except UnknownError as reason:
        state.gap(line, f"where it switches isn't known ({reason})")
        return
    if delay != 0.0 or where not in ((0.0, 1.0) if match["by"] == "DISTANCE" else (0.0,)):
        state.gap(line, "it switches before or behind a point of the path, and where that is isn't judged")
        return
    before = len(state.steps)
    put_output(state, what, assigned["name"], assigned["value"])
    if match["by"] == "PATH" or where == 1.0:
        state.after_next += state.steps[before:]
        del state.steps[before:]


def _wait(state: State, match: re.Match[str], line: Line) -> None:
    """WAIT SEC."""
    try:
        seconds = state.variables.number(match["value"])
    except UnknownError as reason:
        state.gap(line, f"how long it waits isn't known ({reason})")
        seconds = float("nan")
    state.step(line, "wait", value=seconds)


def _wait_for(state: State, match: re.Match[str], line: Line) -> None:
    """WAIT FOR: how long depends on what isn't in the program, unless it is a hook's."""
    state.unknown(line, "it stands still until something outside the program happens")


def _halt(state: State, match: re.Match[str], line: Line) -> None:
    """HALT."""
    state.step(line, "halt")


def _output(state: State, match: re.Match[str], line: Line) -> None:
    """An output switched in a form of its own."""
    state.step(line, "output")


def _assign(state: State, match: re.Match[str], line: Line) -> None:
    """A system variable, an output by its name, or a variable."""
    try:
        name = state.variables.indexed(match["name"].replace(" ", ""))
    except UnknownError as reason:
        state.gap(line, f"what is set isn't known ({reason})")
        return
    bare = name.split("[")[0].split(".")[0]
    if name.startswith("$"):
        found = variable(name)
        if found is None:
            state.unknown(line, "what this system variable does isn't on the list of what is understood")
            return
        row, fit = found
        if row.stops:
            state.waits(line)
        SETTINGS[row.act](state, fit, line, match["value"])
    elif name in state.signals:
        state.waits(line)
        put_output(state, line, name, match["value"])
    elif state.variables.knows(name) or bare in STANDARD:
        _hold_tables(state, name.split(".")[0], line)
        if bare in STANDARD and not state.variables.declared(bare):
            state.variables.common.kinds[bare] = ""  # of $config.dat: one for all files
        try:
            state.variables.put(name, state.variables.value(match["value"]))
        except UnknownError:
            state.variables.forget(name)
        state.step(line, "other")
    else:
        state.unknown(line, "the name isn't declared here, and may be that of an output")


def _hold_tables(state: State, row: str, line: Line) -> None:
    """A row of the controller's tables that is written outlives the program: only the cell's own row may be, by its custom."""
    table = row.split("[")[0]
    if table not in _TABLES or state.files[state.file].lower().endswith(".dat"):
        return
    own = state.machine.controller.own
    measured = table == "BASE_DATA" and own.get("base_measured") is True
    if measured or own.get("numbering") != "tables" or row != f"{table}[{own.get(_TABLES[table])}]":
        text = f"{row} is written over, which the cell doesn't ask for, and which other programs of the controller may rely on"
        state.object("table-row", text, line, "warning")


def _bas(state: State, match: re.Match[str], line: Line) -> None:
    """BAS(#..): frames and speeds by the controller's own library."""
    act, _ = BAS.get(match["what"], ("", ""))
    value = match["value"] or ""
    if not act:
        state.unknown(line, f"BAS(#{match['what']}) isn't on the list of what is understood")
        return
    if match["what"] == "INITMOV":
        state.waits(line)
        state.begin()
    try:
        _bas_conduct(state, act, match["what"], value)
        if act in ("bas_speed", "bas_params"):
            state.speed = state.variables.number(value)
            if state.speed <= 0.0:
                state.speed = float("nan")
        if act == "bas_tool":
            numbered_frame(state, line, "TOOL", state.variables.number(value))
        if act == "bas_base":
            numbered_frame(state, line, "BASE", state.variables.number(value))
    except UnknownError as reason:
        state.gap(line, f"its value isn't known ({reason})")
    if act in ("bas_frames", "bas_params"):
        _held_tool(state, line)
        for name in ("TOOL", "BASE"):
            try:
                numbered_frame(state, line, name, state.variables.number(f"FDAT_ACT.{name}_NO"))
            except UnknownError as reason:
                state.gap(line, f"${name} isn't known from here on ({reason})")
                if name == "TOOL":
                    state.set_tool(None)
                else:
                    state.set_base(Base(None, False))
    state.step(line, "other")


def _held_tool(state: State, line: Line) -> None:
    """IPO_FRAME of FDAT_ACT, which $IPO_MODE takes over: #TCP where the tool stands in the cell and the robot holds the part."""
    try:
        mode = state.variables.value("FDAT_ACT.IPO_FRAME")
    except UnknownError as reason:
        state.gap(line, f"whether the robot holds the tool isn't known ({reason})")
        return
    if mode != "#BASE":
        text = f"IPO_FRAME {mode}: the cell's tool is on the arm, not in the cell"
        state.object("external-tool", text, line)


def _bas_conduct(state: State, act: str, what: str, value: str) -> None:
    """What a BAS command does to speeds, ramps and roundings; raises UnknownError for a percentage that isn't known."""
    put = state.conduct.set
    if act == "bas_acc":
        note_conduct(state, "$ACC.CP", value)
    elif act == "bas_load":
        state.change_load(state.line, "", {})
    elif act == "bas_acc_ptp":
        put(ACC_PTP, state.variables.number(value))
    elif act == "bas_ptp" or what == "PTP_PARAMS":
        put(PTP, state.variables.number(value))
    if what in ("PTP_DAT", "PTP_PARAMS"):
        put(ACC_PTP, number_or_nan(state, "PDAT_ACT.ACC"))
        if what == "PTP_DAT":
            put(PTP, number_or_nan(state, "PDAT_ACT.VEL"))
        if _of_form(state, "PDAT_ACT", "APO_MODE") in (
            None,
            "#CDIS",
        ):  # else C_PTP's size, which the cell doesn't state
            put("$APO.CDIS", number_or_nan(state, "PDAT_ACT.APO_DIST"))
    elif what in ("CP_DAT", "CP_PARAMS"):
        put("$APO.CDIS", number_or_nan(state, "LDAT_ACT.APO_DIST"))
        if number_or_nan(state, "LDAT_ACT.ACC") != 100.0:  # else as it has been
            put("$ACC.CP", float("nan"))
        if what == "CP_DAT":
            speed = number_or_nan(state, "LDAT_ACT.VEL")
            state.speed = speed if speed > 0.0 else float("nan")
        turns, circles = _of_form(state, "LDAT_ACT", "ORI_TYP"), _of_form(state, "LDAT_ACT", "CIRC_TYP")
        put_turning(state, "a LDAT_ACT that isn't known" if turns is None else turns or "#VAR")
        put_circling(state, circles or "#BASE")


def _of_form(state: State, name: str, part: str) -> str | None:
    """A word among the data of an inline form: "" where they leave it out, and BAS.SRC takes its default; None where they aren't
    known.
    """
    try:
        data = state.variables.value(name)
    except UnknownError:
        return None
    if not isinstance(data, dict):
        return None
    word = data.get(part, "")
    return word if isinstance(word, str) else None


def _carry_on(state: State, match: re.Match[str], line: Line) -> None:
    """CONTINUE: the statement after it doesn't wait for the robot."""
    state.early = line


ACTS: dict[str, Act] = {
    "nothing": _nothing,
    "declare": _declare,
    "signal": _signal,
    "structure": _structure,
    "interrupt": _interrupt,
    "interrupt_on": _interrupt_on,
    "borrow": _borrow,
    "trigger": _trigger,
    "motion": motion,
    "relative": relative,
    "wait": _wait,
    "wait_for": _wait_for,
    "halt": _halt,
    "output": _output,
    "bas": _bas,
    "continue": _carry_on,
    "assign": _assign,
}
