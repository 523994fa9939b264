"""A reader of the KRL that the bench's jobs lead to, by regular expressions: statements in the order of execution."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_PTP = re.compile(r"PTP \{(E6AXIS|E6POS): ([^{}]*)\}")
_LIN = re.compile(r"LIN \{E6POS: ([^{}]*)\}( C_DIS)?")
_CIRC = re.compile(r"CIRC \{E6POS: ([^{}]*)\},\{E6POS: ([^{}]*)\}( C_DIS)?")
_SPEED = re.compile(rf"\$VEL\.CP = ({NUMBER})")
_FRAME = re.compile(r"\$(BASE|TOOL) = (.*)")
_CALL = re.compile(r"(\w+) \( \)")
_FIELD = re.compile(rf"([A-Z]\d?) ({NUMBER})")
_LONGEST = 255


class UnreadableError(Exception):
    """The files are no program."""


@dataclass(frozen=True)
class Statement:
    """One statement or comment: kind is `ptp-axes`, `ptp`, `lin`, `circ`, `frame`, `comment` or `other`.

    target, via: the fields of the aggregates. speed: `$VEL.CP` in m/s in force, None where none was set.
    """

    kind: str
    text: str
    file: str
    line: int
    target: Mapping[str, float] = field(default_factory=dict)
    via: Mapping[str, float] = field(default_factory=dict)
    speed: float | None = None
    rounded: bool = False

    @property
    def moves(self) -> bool:
        return self.kind in ("ptp", "ptp-axes", "lin", "circ")

    @property
    def place(self) -> str:
        return f"{self.file}:{self.line}"


def read(files: Mapping[str, bytes], name: str) -> list[Statement]:
    """Every statement of NAME.src, those of the parts that it calls in their place. Raises UnreadableError.

    Parts that nothing calls, such as those of an older program in the same folder, are none of this one.
    """
    if f"{name}.src" not in files:
        raise UnreadableError(f"there is no {name}.src, but {sorted(files)}")
    out: list[Statement] = []
    called: list[str] = []
    _routine(files, name, out, [None], called)
    if len(set(called)) != len(called):
        raise UnreadableError("a part is called twice")
    return out


def _routine(
    files: Mapping[str, bytes], name: str, out: list[Statement], speed: list[float | None], called: list[str]
) -> None:
    file = f"{name}.src"
    if file not in files:
        raise UnreadableError(f"{file} is called and is not there")
    text = files[file].decode("ascii")
    if text.count("\n") != text.count("\r\n") or not text.endswith("END\r\n"):
        raise UnreadableError(f"{file} is cut off or has foreign line ends")
    lines = [line.strip(" ") for line in text.split("\r\n")[:-1]]
    start = next((k for k, line in enumerate(lines) if not line.startswith("&")), 0)
    if lines[start] != f"DEF {name} ( )" or lines.count("END") != 1:
        raise UnreadableError(f"{file} does not define {name}, or more than that")
    declared = set()
    for number, line in enumerate(lines[start + 1 : -1], start=start + 2):
        if len(line) > _LONGEST:
            raise UnreadableError(f"{file}:{number} is longer than a line may be")
        if line.startswith("EXT "):
            declared.add(line[4:])
        elif (call := _CALL.fullmatch(line)) is not None:
            if line not in declared:
                raise UnreadableError(f"{file}:{number} calls what is not declared")
            called.append(call[1])
            _routine(files, call[1], out, speed, called)
        else:
            _statement(line, file, number, out, speed)


def _statement(line: str, file: str, number: int, out: list[Statement], speed: list[float | None]) -> None:
    if line.startswith(";"):
        out.append(Statement("comment", line, file, number))
    elif found := _PTP.fullmatch(line):
        kind = "ptp-axes" if found[1] == "E6AXIS" else "ptp"
        out.append(Statement(kind, line, file, number, _fields(found[2])))
    elif found := _LIN.fullmatch(line):
        out.append(Statement("lin", line, file, number, _fields(found[1]), {}, speed[0], found[2] is not None))
    elif found := _CIRC.fullmatch(line):
        via, end = _fields(found[1]), _fields(found[2])
        out.append(Statement("circ", line, file, number, end, via, speed[0], found[3] is not None))
    elif found := _SPEED.fullmatch(line):
        speed[0] = float(found[1])
    elif _FRAME.fullmatch(line):
        out.append(Statement("frame", line, file, number))
    else:
        out.append(Statement("other", line, file, number))


def _fields(text: str) -> dict[str, float]:
    """`X 1.0,Y 2.0` as numbers. Raises UnreadableError for anything else."""
    out: dict[str, float] = {}
    for part in text.split(","):
        found = _FIELD.fullmatch(part)
        if found is None or found[1] in out:
            raise UnreadableError(f"{part!r} in an aggregate")
        out[found[1]] = float(found[2])
    return out


def aggregate(text: str) -> tuple[float, ...]:
    """X, Y, Z, A, B, C of the one frame in a text. Raises UnreadableError."""
    found = re.findall(r"\{([^{}]*)\}", text)
    values = _fields(found[0]) if len(found) == 1 else {}
    if list(values) != list("XYZABC"):
        raise UnreadableError(f"{text!r} holds no frame")
    return tuple(values.values())
