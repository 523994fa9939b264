"""What WITH sets for one motion of the spline kind, or for a block of them: values, and the functions of KUKA's inline forms.

The functions are those of BASISTECH (KSS 8, "Programming, expert": SVEL_CP, STOOL2, SBASE and their kin): they read the FDAT,
PDAT and LDAT of the form.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace

from camrob.errors import KrlError
from camrob.findings import Severity
from camrob.languages.krl.reader.expressions import Aggregate, Enumerated, Expression, Unknown, Value
from camrob.languages.krl.reader.machine import KrlMachine
from camrob.languages.krl.reader.tokens import Token, shown

__all__ = ["take_with", "with_words"]

_LEFT_OUT = frozenset(
    """$VEL_AXIS $ACC_AXIS $VEL_EXTAX $ACC_EXTAX $GEAR_JERK $JERK $LOAD $COLLMON_TOL_PRO $CIRC_TYPE""".split()
)
"""Which change no place: how axes get up to speed, what hangs on the flange."""


@contextmanager
def with_words(machine: KrlMachine) -> Iterator[None]:
    """Within it WITH may set what is modal; behind it all is as before."""
    kept = replace(machine.rows.modal)
    yield
    modal = machine.rows.modal
    machine.rows.modal = replace(kept, wait=modal.wait)


def take_with(machine: KrlMachine, tokens: tuple[Token, ...], line: int) -> None:
    """`NAME = value, NAME = FUNCTION(...)`, an `end` behind them. Raises KrlError for what is not read."""
    expression = Expression(tokens, machine.variables)
    left: list[str] = []
    while True:
        path = expression.path()
        root = path.split(".", 1)[0].split("[", 1)[0]
        expression.expect("=")
        function, arguments = _function(expression)
        value: Value = Unknown(function or path) if function else expression.value()
        if root in _TAKEN:
            _TAKEN[root](machine, path, function, arguments, value, line)
        elif root == "$ACC" and not function:
            machine.set_modal(root, path, value, line)
        elif root in _LEFT_OUT or root == "$ACC":
            left.append(root)
        else:
            raise KrlError(f"WITH {shown(path)} is not read", hint="set what it changes before the motion")
        if expression.next.kind == "end":
            break
        expression.expect(",")
    if left:
        text = f"WITH {', '.join(left)}: what it says of axes, accelerations and loads is left out"
        machine.find("with-left-out", text, line, Severity.INFO)


def _function(expression: Expression) -> tuple[str, list[Value]]:
    """The form's function that is called next and its arguments; none where a value stands, EK(...) among them."""
    called = expression.next.kind == "name" and expression.tokens[expression.at + 1].text == "("
    if not called or expression.next.text == "EK":
        return "", []
    return expression.path(), expression.arguments()


def _field(arguments: list[Value], name: str) -> Value:
    """A component of the form's data, Unknown where the program doesn't hold it."""
    data = arguments[0] if arguments else Unknown(name)
    return data.fields.get(name, Unknown(name)) if isinstance(data, Aggregate) else Unknown(name)


def _velocity(machine: KrlMachine, path: str, function: str, arguments: list[Value], value: Value, line: int) -> None:
    if function == "SVEL_CP" and arguments:
        value = arguments[0]
    elif isinstance(value, Aggregate) and path == "$VEL" and "CP" in value.fields:
        value = value.fields["CP"]
    elif path != "$VEL.CP":
        value = Unknown(path)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not value > 0:
        raise KrlError(f"WITH {path} without a speed that is in the program", hint="write $VEL.CP and a number")
    machine.rows.modal.speed = float(value)


def _tool(machine: KrlMachine, path: str, function: str, arguments: list[Value], value: Value, line: int) -> None:
    if function in ("STOOL", "STOOL2"):
        machine.activate("tool", _field(arguments, "TOOL_NO"), line)
    else:
        machine.set_frame("tool", value, path, line)


def _base(machine: KrlMachine, path: str, function: str, arguments: list[Value], value: Value, line: int) -> None:
    if function == "SBASE" and arguments:
        machine.activate("base", arguments[0], line)
    else:
        machine.set_frame("base", value, path, line)


def _frames(machine: KrlMachine, path: str, function: str, arguments: list[Value], value: Value, line: int) -> None:
    """$IPO_MODE: whether the robot holds the tool."""
    said = arguments[0] if function == "SIPO_MODE" and arguments else value
    if said == Enumerated("#TCP"):
        raise KrlError("WITH $IPO_MODE #TCP: a tool that stands by itself is not read", hint="post with #BASE")


def _turning(machine: KrlMachine, path: str, function: str, arguments: list[Value], value: Value, line: int) -> None:
    """$ORI_TYPE: the tool turns evenly from target to target, which nothing else is read as."""
    said = _field(arguments, "ORI_TYP") if function == "SORI_TYP" else value
    if isinstance(said, Enumerated) and said.text != "#VAR":
        raise KrlError(f"WITH $ORI_TYPE {said.text}: only #VAR is read", hint="post with #VAR")


def _distance(machine: KrlMachine, path: str, function: str, arguments: list[Value], value: Value, line: int) -> None:
    if function in ("SAPO", "SAPO_PTP"):
        path, value = "$APO.CDIS", _field(arguments, "APO_DIST")
    machine.set_modal("$APO", path, value, line)


_Taken = Callable[[KrlMachine, str, str, list[Value], Value, int], None]
_TAKEN: dict[str, _Taken] = {
    "$VEL": _velocity,
    "$TOOL": _tool,
    "$BASE": _base,
    "$IPO_MODE": _frames,
    "$ORI_TYPE": _turning,
    "$APO": _distance,
}
