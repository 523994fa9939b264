"""What recorders, controllers and metrology programs call the columns of a log, and the units that such a name tells."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

from camrob.measurement.log import COLUMNS, POSITION

__all__ = ["Meaning", "meanings_of", "unit_of"]

# how units are written, the format's spelling first
_UNITS = {
    "deg": ("deg", "degs", "degree", "degrees", "grad", "°", "º"),
    "rad": ("rad", "rads", "radian", "radians"),
    "mm": ("mm", "millimeter", "millimeters", "millimetre", "millimetres"),
    "cm": ("cm",),
    "m": ("m", "meter", "meters", "metre", "metres"),
    "inch": ("in", "inch", "inches", '"'),
    "s": ("s", "sec", "secs", "second", "seconds", "sekunden"),
    "ms": ("ms", "msec", "milliseconds"),
    "us": ("us", "µs", "usec", "microseconds"),
    "ns": ("ns",),
    "Nm": ("nm", "n·m", "n*m"),
    "N": ("n", "newton"),
    "A": ("a", "amp", "amps", "ampere"),
    "C": ("°c", "degc", "deg c", "c", "celsius"),
}
_SPELT = {spelling: unit for unit, spellings in _UNITS.items() for spelling in spellings}
_TAILS = (
    "deg",
    "degrees",
    "rad",
    "mm",
    "sec",
    "ms",
    "us",
    "ns",
    "inch",
    "Nm",
    "N",
    "A",
    "m",
    "s",
)  # behind an underscore
_BRACKETED = re.compile(r"^(.*?)\s*[\[(<{]\s*([^\])>}]*)\s*[\])>}]\s*$")

_TOLD = {
    "target",
    "cmd",
    "command",
    "commanded",
    "set",
    "setpoint",
    "sollwert",
    "soll",
    "desired",
    "des",
    "ref",
    "aspos",
}
_IS = {"actual", "act", "ist", "istwert", "measured", "meas", "fbk", "feedback", "enc", "encoder", "real", "aipos"}
_AXIS_WORDS = {
    "axis",
    "joint",
    "achse",
    "pos",
    "position",
    "angle",
    "winkel",
    "value",
    "robot",
    "state",
    "states",
    "axisact",
}
_NUMBERED = re.compile(r"(a|j|q|ax|axis|joint|achse|position|pos|e|torque|tau|moment|current|axisact)_?(\d+)$")
_IN_DEGREES = {"aipos", "aspos", "axisact"}  # KUKA's own, which know no other unit
_TORQUE, _CURRENT = {"torque", "tau", "moment"}, {"current", "strom"}
_SEEN = {"meas", "measured", "tracker", "lt", "smr", "reflector", "point", "pos", "position", "coord", "coordinate"}
# the tool as the controller reckons it from its own axes, which measures nothing
_RECKONED = {"tcp", "rist", "rsol", "pose", "actual", "act", "ist", "robot", "flange", "posact"}
_TIMES = {"t", "time", "timestamp", "zeit", "seconds", "elapsed", "elapsed_time", "date_time", "datetime", "time_stamp"}
_TURNS = ("qw", "qx", "qy", "qz", "rx", "ry", "rz", "w", "p", "r", "yaw", "pitch", "roll")
_RTDE = re.compile(r"(actual|target)_(q|current|tcp_pose)_(\d)$")


_PLAIN = {name.lower(): name for name in COLUMNS}


@dataclass(frozen=True, slots=True)
class Meaning:
    """What a column is. column: the format's name; "" where it is nothing of a log. unit: as the name tells it, "" where it
    doesn't; own: the name is the format's but for its letters' case, and so is its unit. reckoned: the tool's pose as the
    controller reckons it.
    """

    column: str = ""
    unit: str = ""
    own: bool = False
    reckoned: bool = False


def unit_of(text: str) -> str:
    """The unit that a text is, in this program's spelling; "" where it is none."""
    plain = text.strip().strip("[](){}<>").strip().lower().rstrip(".")
    return _SPELT.get(plain, "")


def meanings_of(names: Sequence[str]) -> list[Meaning]:
    """What the columns of a header are, name by name; numbers of axes from 0 on, as computers count, are taken as such."""
    parted = [_parted(name) for name in names]
    rtde = any(_RTDE.match(base) for base, _ in parted)
    found = [_meaning(base, unit, rtde=rtde) for base, unit in parted]
    numbers = {kind: {m.column[2:] for m in found if m.column.startswith(f"#{kind}")} for kind in "=cTI"}
    from_0 = {kind for kind, own in numbers.items() if "0" in own or (kind == "c" and "0" in numbers["="])}
    return [replace(m, column=_axis_name(m.column, from_0)) if m.column.startswith("#") else m for m in found]


def _axis_name(marked: str, from_0: set[str]) -> str:
    """The format's name of an axis's column that is marked "#", kind, and the number that its header gives it."""
    kind = marked[1]
    number = int(marked[2:]) + (kind in from_0)
    return f"{kind.replace('=', '')}{'A' if kind in '=c' else ''}{number}"


def _meaning(base: str, unit: str, *, rtde: bool) -> Meaning:
    plain = _PLAIN.get(base)
    if plain is not None:
        return Meaning(plain, unit, own=True)
    if rtde and (told := _RTDE.match(base)) is not None:
        if told[2] == "tcp_pose":
            return Meaning(reckoned=told[1] == "actual" and int(told[3]) < len(POSITION))
        kinds = {"q": ("=", "rad"), "current": ("I", "A")}
        kind, unit = kinds[told[2]]
        if told[1] == "target":
            return Meaning(f"#c{told[3]}", unit) if told[2] == "q" else Meaning()
        return Meaning(f"#{kind}{told[3]}", unit)
    if base in _TIMES:
        return Meaning("t", unit or ("s" if rtde else ""))
    if base in _TURNS:
        return Meaning(base, unit)
    return _of_axis(base, unit) or _of_place(base, unit)


def _of_axis(base: str, unit: str) -> Meaning | None:
    """An axis's column: its number, whether it was told or is, of its place, torque or current; None for others."""
    words = re.sub(r"^axis_act", "axisact", base).split("_")
    for k in range(len(words)):
        for n in (2, 1):
            numbered = _NUMBERED.match("_".join(words[k : k + n])) if k + n <= len(words) else None
            if numbered is None:
                continue
            others = set(words[:k] + words[k + n :])
            word, number = numbered[1], numbered[2]
            effort = (
                "T" if word in _TORQUE or others & _TORQUE else "I" if word in _CURRENT or others & _CURRENT else ""
            )
            if others - _TOLD - _IS - _AXIS_WORDS - _TORQUE - _CURRENT:
                return None  # a speed, a temperature, a status
            told = bool(others & _TOLD)
            unit = unit or ("deg" if (others | {word}) & _IN_DEGREES else "")
            if effort:
                return None if told or word == "e" else Meaning(f"#{effort}{number}", unit)
            if word == "e":
                return Meaning(f"{'c' if told else ''}E{number}", unit)
            return Meaning(f"#{'c' if told else '='}{number}", unit)
    return None


def _of_place(base: str, unit: str) -> Meaning:
    """A coordinate: measured, reckoned by the controller, or none of a log."""
    words = base.split("_")
    if words[-1] not in POSITION or len(words) == 1:
        return Meaning()
    others = set(words[:-1])
    if others <= _SEEN:
        return Meaning(words[-1], unit)
    return Meaning(reckoned=bool(others & _RECKONED) and others <= _RECKONED | _SEEN)


def _parted(name: str) -> tuple[str, str]:
    """A name in small letters, its words parted by underscores, and the unit that stands in it."""
    text = name.strip().strip('"').strip()
    unit = ""
    if (bracketed := _BRACKETED.match(text)) is not None and unit_of(bracketed[2]):
        text, unit = bracketed[1], unit_of(bracketed[2])
    if text.lower() in _PLAIN:
        return text.lower(), unit
    text = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", text)  # ActPos is two words
    text = re.sub(r"[^0-9a-zA-Zäöüß]+", "_", text).strip("_").lower()
    if not unit:
        for tail in _TAILS:
            if text.endswith("_" + tail.lower()):
                return text[: -len(tail) - 1], unit_of(tail)
    return text, unit
