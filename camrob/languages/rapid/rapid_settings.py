"""What a cell says of its controller for RAPID alone, and what its hooks may say."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from camrob.cell.controller_settings import ControllerSettings
from camrob.errors import CellError

__all__ = ["RapidSettings", "check_hooks", "rapid_settings"]

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,31}")
# what camrob itself writes or takes for granted, and what leaves the program's course
_OWN = re.compile(
    r"(Move|Trigg|Search|PDisp|EOffs|Conf[JL]|SingArea|CirPathMode|AccSet|VelSet|PathAccLim|WorldAccLim|PathResol"
    r"|SpeedRefresh|ActUnit|DeactUnit|GripLoad|SoftAct|IndA|IndC|IndR|IndD|CorrCon|CorrWrite|EGM|StartMove|StopMove|SyncMove"
    r"|StorePath|RestoPath|ClearPath|WaitSyncTask|PROC|ENDPROC|FUNC|ENDFUNC|TRAP|ENDTRAP|MODULE|ENDMODULE|RETURN|GOTO|Exit"
    r"|ExitCycle|RAISE|IF|ELSEIF|ELSE|ENDIF|FOR|ENDFOR|WHILE|ENDWHILE|TEST|CASE|DEFAULT|ENDTEST|VAR|PERS|CONST|LOCAL|TASK"
    r"|ERROR|UNDO|BACKWARD|CONNECT|Load|UnLoad|StartLoad|WaitLoad|MechUnitLoad|ArcL|ArcC|ConfL)",
    re.IGNORECASE,
)
_STEMS = re.compile(r"(Move|Trigg|Search|PDisp|EOffs|Ind[ACRD]|Corr|EGM|StartMove|StopMove|SyncMove)", re.IGNORECASE)
_STRING = re.compile(r'"(?:[^"]|"")*"')
_SETS_FRAME = re.compile(r"\b[tw]\d*_\w+\s*(\.\s*\w+\s*)*:=|\.\s*(tframe|tload|uframe|oframe)\b[^=]*:=", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class RapidSettings:
    """mechanical_unit: what carries and turns the work object, "" where it stands. active_units: units that a program
    activates. tool_data: the controller's tooldata whose load holds where the set-up states none, "" for none. ptp_speed: the
    speeddata of MoveAbsJ and MoveJ: mm/s, degrees/s, mm/s and degrees/s of external axes.
    """

    mechanical_unit: str
    active_units: tuple[str, ...]
    tool_data: str
    ptp_speed: tuple[float, float, float, float]


def rapid_settings(controller: ControllerSettings) -> RapidSettings:
    """The settings of a controller that takes RAPID. Raises CellError for one that is missing, unknown or no such value."""
    own = dict(controller.own)
    unit, tool = (_word(own.pop(key, ""), key) for key in ("mechanical_unit", "tool_data"))
    units = own.pop("active_units", [])
    if not isinstance(units, list | tuple):
        raise CellError("active_units is no list", hint='write ["STN1"]')
    speed = own.pop("ptp_speed", None)
    if not isinstance(speed, list | tuple) or len(speed) != 4 or not all(_positive(v) for v in speed):  # a speeddata
        hint = "write [mm/s, degrees/s, mm/s, degrees/s] of tool, turning and external axes"
        raise CellError(f"ptp_speed is {speed!r}"[:80], hint=hint)
    if own:
        raise CellError(f"{min(own)} is nothing that RAPID takes", hint="leave it out")
    tcp, ori, leax, reax = (float(v) for v in speed)
    return RapidSettings(unit, tuple(_word(u, "active_units") for u in units), tool, (tcp, ori, leax, reax))


def check_hooks(controller: ControllerSettings) -> None:
    """Raise CellError for a line of a hook that is no single statement, or does what camrob has to know of."""
    for name, lines in controller.hooks.items():
        for line in lines:
            statement = _STRING.sub('""', line).strip()
            what = ""
            if not statement.endswith(";") or ";" in statement[:-1] or "!" in statement:
                what = "is not one statement that ends in ;, without a comment"
            elif (word := re.match(r"\w+", statement)) and (_OWN.fullmatch(word[0]) or _STEMS.match(word[0])):
                what = f"says {word[0]}"
            elif _SETS_FRAME.search(statement):
                what = "sets a frame or a load"
            elif not re.match(r"[A-Za-z]", statement):
                what = "begins with no word"
            if what:
                hint = "leave it to camrob, or to a procedure that puts back what it changes"
                raise CellError(f"hook {name} {what}: {line.strip()[:60]!r}", hint=hint)


def _word(value: object, key: str) -> str:
    """An identifier of RAPID, or nothing."""
    if value == "" and key != "active_units":
        return ""
    if not isinstance(value, str) or not _NAME.fullmatch(value):
        raise CellError(f"{key} is {value!r}"[:80], hint="write a name of RAPID: letters, digits and _")
    return value


def _positive(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value) and value > 0
