"""What a cell says of its controller for KRL alone, and the base that a program of it stands in."""

from __future__ import annotations

import re
from dataclasses import dataclass, fields

from camrob.cell.controller_settings import ControllerSettings, check_line
from camrob.errors import CellError
from camrob.languages.krl.krl_analog import check_analog
from camrob.languages.krl.krl_customs import Customs, take_customs
from camrob.languages.krl.krl_hooks import check_statement

__all__ = ["KrlSettings", "krl_settings"]

_ORI_TYPES = ("#VAR", "#CONSTANT", "#JOINT")
_CIRC_TYPES = ("#BASE", "#PATH")
_MECHANISMS = 6  # that a KR C2 can have beside the robot
_TABLE = 64  # rows that TOOL_DATA and BASE_DATA may have, row 0 being the flange or the world
_FOLDER = re.compile(r"[A-Za-z0-9_$-]{1,24}(?:/[A-Za-z0-9_$-]{1,24})*")  # as the controller's Explorer takes them
_EK = re.compile(r"\s*EK\s*\([^()]*,[^()]*,\s*\{base\}\s*\)\s*$", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class KrlSettings:
    """ori_type, circ_type: `$ORI_TYPE`, `$CIRC_TYPE`. base_template: how a base that follows the table is printed, `{base}`
    standing for the frame, as in `EK(MACHINE_DEF[2].ROOT, MACHINE_DEF[2].MECH_TYPE, {base})`; empty prints the frame.
    act_ex_ax: `$ACT_EX_AX`, 0 leaves it alone. tool_number, base_number: entries of the controller's tables that are made active
    (for load data and the pendant) before the frames are written, None leaves them alone. base_measured: the base is the row
    base_number of BASE_DATA as the controller has it, which is never written; load_measured: the load likewise, LOAD_DATA's row
    tool_number. stop_message: whether a program
    declares the usual interrupt for stop messages, IR_STOPM, which shows them. upload_folder: the controller's folder that
    programs are copied into, each into one of its own name, as in `R1/Program`; a list of what goes there comes with each
    program then. Empty: no list. customs: what the shop's programs look like otherwise.
    """

    ori_type: str
    circ_type: str
    base_template: str
    act_ex_ax: int
    tool_number: int | None
    base_number: int | None
    base_measured: bool
    load_measured: bool
    stop_message: bool
    upload_folder: str
    customs: Customs

    def check_base(self, *, follows_table: bool) -> None:
        """Raise CellError where `$BASE` would not be printed as what `base_follows_table` makes of it.

        A base that follows the table is written by EK, of the mechanism that `$ACT_EX_AX` names; one that stands is not.
        """
        found = _EK.match(self.base_template)
        if not follows_table:
            if found:
                hint = "take base_template away, or set base_follows_table"
                raise CellError(
                    "base_template writes a base that follows the table, and base_follows_table is false", hint=hint
                )
            if self.act_ex_ax:
                what = f"act_ex_ax is {self.act_ex_ax}, which couples the base to that mechanism, and base_follows_table is false"
                raise CellError(what, hint="take act_ex_ax away, or set base_follows_table")
            return
        if not found:
            shown = repr(self.base_template) if self.base_template else "missing"
            hint = "write EK(MACHINE_DEF[n].ROOT, MACHINE_DEF[n].MECH_TYPE, {base})"
            raise CellError(f"base_follows_table is true, but base_template is {shown}, which stands still", hint=hint)
        numbers = {int(n) for n in re.findall(r"MACHINE_DEF\s*\[\s*(\d+)\s*\]", self.base_template, re.IGNORECASE)}
        if len(numbers | ({self.act_ex_ax} if self.act_ex_ax else set())) > 1 and numbers:
            named = " and ".join(f"MACHINE_DEF[{n}]" for n in sorted(numbers))
            what = f"base_template names {named} where act_ex_ax is {self.act_ex_ax}"
            raise CellError(what, hint="name the mechanism that carries the part in all places")


def krl_settings(controller: ControllerSettings) -> KrlSettings:
    """The settings of a controller that takes KRL.

    Raises CellError for one that is missing, unknown or no such value, and for a hook that sets frames or moves.
    """
    own = dict(controller.own)
    template = own.pop("base_template", "")
    if template != "":
        check_line("base_template", template, ("base",), controller.max_line_length)
        if str(template).count("{base}") != 1:
            raise CellError("base_template does not name {base} once", hint="write EK(..., ..., {base})")
    tool_number, base_number = (_number(own, f"{name}_number", _TABLE) for name in ("tool", "base"))
    settings = KrlSettings(
        ori_type=_one_of(own, "ori_type", _ORI_TYPES),
        circ_type=_one_of(own, "circ_type", _CIRC_TYPES),
        base_template=str(template),
        act_ex_ax=_number(own, "act_ex_ax", _MECHANISMS) or 0,
        tool_number=tool_number,
        base_number=base_number,
        base_measured=_measured(own, "base", base_number),
        load_measured=_measured(own, "load", tool_number),
        stop_message=_flag(own, "stop_message"),
        upload_folder=_folder(own, "upload_folder"),
        customs=take_customs(own, tool_number=tool_number, base_number=base_number),
    )
    if own:
        known = ", ".join(f.name for of in (KrlSettings, Customs) for f in fields(of) if f.name != "customs")
        raise CellError(f"{min(own)} is not a key that camrob knows here", hint=f"for KRL alone there are {known}")
    check_analog(controller.hooks)
    for name, lines in controller.hooks.items():
        if lines and name not in ("header", "footer") and all(line.lstrip()[:1] in ("", ";") for line in lines):
            hint = "write what it switches, calls or waits for, or leave the hook out"
            raise CellError(f"hook {name} holds comments alone, so that nothing happens there", hint=hint)
        for line in lines:
            check_statement(name, line)
    return settings


def _one_of(own: dict[str, object], key: str, words: tuple[str, ...]) -> str:
    """A word of the language, taken out of `own`."""
    value = own.pop(key, None)
    if value not in words:
        what = "missing" if value is None else f"{value!r}"[:80]
        raise CellError(f"{key} is {what}", hint="write one of " + ", ".join(words))
    return str(value)


def _number(own: dict[str, object], key: str, most: int) -> int | None:
    """A whole number from 0 up that may be left out, taken out of `own`."""
    if key not in own:
        return None
    value = own.pop(key)
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value <= most:
        raise CellError(f"{key} is {value!r}"[:80], hint=f"write a whole number from 0 to {most}")
    return value


def _folder(own: dict[str, object], key: str) -> str:
    """Folders of the controller that may be left out, taken out of `own`."""
    value = own.pop(key, "")
    if not isinstance(value, str) or (value and _FOLDER.fullmatch(value) is None):
        raise CellError(f"{key} is {value!r}"[:80], hint='write folders of the controller, as in "R1/Program"')
    return value


def _measured(own: dict[str, object], what: str, number: int | None) -> bool:
    """`base_measured` or `load_measured`, which need their row."""
    measured = _flag(own, f"{what}_measured")
    if measured and not number:
        hint = f"add {'base' if what == 'base' else 'tool'}_number, from 1"
        raise CellError(f"{what}_measured is true without a row of {what.upper()}_DATA", hint=hint)
    if measured and what == "load" and own.get("numbering", "bas") != "bas":
        hint = "leave numbering out, or load_measured"
        raise CellError("load_measured is true, but numbering does not activate the load with the tool", hint=hint)
    return measured


def _flag(own: dict[str, object], key: str) -> bool:
    """A true or false that may be left out, taken out of `own`."""
    value = own.pop(key, False)
    if not isinstance(value, bool):
        raise CellError(f"{key} is {value!r}"[:80], hint="write true or false")
    return value
