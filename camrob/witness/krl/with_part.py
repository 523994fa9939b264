"""What WITH sets for one motion of the spline kind, or for a block of them, and what holds again behind it.

Besides plain values stand there the functions of KUKA's inline forms (BASISTECH of KSS 8: SVEL_CP, STOOL2, SBASE and their kin),
which read the form's FDAT, LDAT or PDAT.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from camrob.witness.krl.conduct import ACC_PTP, PTP
from camrob.witness.krl.settings import SETTINGS, number_or_nan, numbered_frame, put_speed
from camrob.witness.krl.state import State
from camrob.witness.krl.statements import variable
from camrob.witness.krl.text import Line
from camrob.witness.krl.values import UnknownError, split_top

__all__ = ["FORM_FUNCTIONS", "with_words"]

_CALL = re.compile(r"(?P<name>[A-Z_]\w*) ?\((?P<inputs>.*)\)")
_TURNING = ("$VEL.ORI1", "$VEL.ORI2")
_PLAIN = frozenset(
    ("base", "tool", "load", "speed", "speeds", "ori_type", "circ_type", "ipo_mode", "bounded", "conduct", "nothing")
)
_NAN = float("nan")
_Act = Callable[[State, str, Line], None]


@contextmanager
def with_words(state: State, text: str, line: Line) -> Iterator[None]:
    """Within it holds what `text`, the part behind WITH, sets; what isn't understood of it is a gap."""
    if not text:
        yield
        return
    frames, turning = (state.base, state.tool, list(state.reset)), (state.constant, state.unlike_line, state.unlike_arc)
    speed, conduct = state.speed, dict(state.conduct.values)
    load = state.loads[-1].values if state.loads else None
    for item in split_top(text):
        name, _, value = (part.strip() for part in item.partition("="))
        try:
            _take(state, name, value, line)
        except UnknownError as reason:
            state.gap(line, f"what WITH changes isn't judged ({reason})")
    yield
    state.base, state.tool, state.reset = frames
    state.constant, state.unlike_line, state.unlike_arc = turning
    state.speed, state.conduct.values = speed, conduct
    state.conduct.judged.clear()
    if state.loads and state.loads[-1].values != load:
        state.set_load(line.number, load)


def _take(state: State, name: str, value: str, line: Line) -> None:
    """One of the settings; raises UnknownError."""
    call = _CALL.fullmatch(value)
    if call is not None and call["name"] in FORM_FUNCTIONS:
        of, part, act = FORM_FUNCTIONS[call["name"]]
        if name.split("[")[0] != of:
            raise UnknownError(f"{call['name']}() isn't for {name}")
        given = split_top(call["inputs"])[0]
        act(state, f"{given}.{part}" if part else given, line)
        return
    found = variable(state.variables.indexed(name))
    if found is None or found[0].act not in _PLAIN:
        raise UnknownError(f"{name or 'nothing'} isn't on the list of what is understood")
    SETTINGS[found[0].act](state, found[1], line, value)


def _speed(state: State, value: str, line: Line) -> None:
    """SVEL_CP(speed, , LDAT): the tip's speed; the tool turns as fast as the controller has it."""
    put_speed(state, state.variables.number(value), line)
    for name in _TURNING:
        state.conduct.set(name, _NAN)


def _setting(name: str) -> _Act:
    """A setting that is the function's input."""

    def act(state: State, value: str, line: Line) -> None:
        state.conduct.set(name, number_or_nan(state, value))

    return act


def _frame(name: str) -> _Act:
    """A frame by its number in the controller's list."""

    def act(state: State, value: str, line: Line) -> None:
        numbered_frame(state, line, name, state.variables.number(value))

    return act


def _word(name: str) -> _Act:
    """A setting that is a word such as #VAR."""

    def act(state: State, value: str, line: Line) -> None:
        word = str(state.variables.value(value))
        found = variable(name)
        if found is not None:
            SETTINGS[found[0].act](state, found[1], line, word)

    return act


def _load(state: State, value: str, line: Line) -> None:
    """SLOAD(number): the tool's own load data."""
    state.set_load(line.number, None)


def _ramp(state: State, value: str, line: Line) -> None:
    """SACC_CP(LDAT): a share of the controller's largest, which isn't in the text."""
    state.conduct.set("$ACC.CP", _NAN)


def _nothing(state: State, value: str, line: Line) -> None:
    """How a PTP is rounded, which is known to nobody here (`State.vague`); the collision detection."""


FORM_FUNCTIONS: dict[str, tuple[str, str, _Act]] = {
    "SVEL_CP": ("$VEL", "", _speed),
    "SVEL_JOINT": ("$VEL_AXIS", "", _setting(PTP)),
    "STOOL": ("$TOOL", "", _frame("TOOL")),
    "STOOL2": ("$TOOL", "TOOL_NO", _frame("TOOL")),
    "SBASE": ("$BASE", "", _frame("BASE")),
    "SIPO_MODE": ("$IPO_MODE", "", _word("$IPO_MODE")),
    "SLOAD": ("$LOAD", "", _load),
    "SACC_CP": ("$ACC", "", _ramp),
    "SACC_JOINT": ("$ACC_AXIS", "ACC", _setting(ACC_PTP)),
    "SORI_TYP": ("$ORI_TYPE", "ORI_TYP", _word("$ORI_TYPE")),
    "SCIRC_TYP": ("$CIRC_TYPE", "CIRC_TYP", _word("$CIRC_TYPE")),
    "SAPO": ("$APO", "APO_DIST", _setting("$APO.CDIS")),
    "SAPO_PTP": ("$APO", "", _nothing),
    "SJERK": ("$JERK", "", _nothing),
    "SGEAR_JERK": ("$GEAR_JERK", "GEAR_JERK", _setting("$GEAR_JERK")),
    "USE_CM_PRO_VALUES": ("$COLLMON_TOL_PRO", "", _nothing),
}
"""By name: which variable a function is for, the part of its first input that it reads, and what it does with that."""
