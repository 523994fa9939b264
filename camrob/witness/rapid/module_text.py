"""The text of a RAPID module: its data, its procedures, and long rows of like motions read as numbers."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from camrob.errors import ProgramError
from camrob.witness.krl.text import Line

__all__ = ["MoveRow", "Procedure", "RapidModule", "listed_modules", "read_rapid_module"]

_LIST = rb"\[([-0-9.E,]+)\]"
_ROW = re.compile(
    rb"[ \t]*MoveL \["
    + _LIST
    + rb","
    + _LIST
    + rb","
    + _LIST
    + rb","
    + _LIST
    + rb"\],"
    + _LIST
    + rb",(\w+),(\w+)\\WObj:=(\w+);[ \t]*"
)
_SIZES = (3, 4, 4, 6, 4)  # how many numbers place, quaternion, configuration, external axes and speed have
_STRUCTURE = re.compile(
    r"(?:LOCAL )?(?:PROC|TRAP|FUNC|RECORD)\b.*|MODULE\b.*|SYSMODULE\b.*|END[A-Z]+|ELSE|ERROR|UNDO|BACKWARD"
    r"|%%%|(?:VERSION|LANGUAGE) ?: ?\w+"  # the head that controllers and posts write above the module
    r"|(?:IF|ELSEIF)\b.*\bTHEN|(?:FOR|WHILE)\b.*\bDO|TEST\b.*|CASE\b.*:|DEFAULT:"
)
_ROUTINE = re.compile(r"(?:LOCAL )?(?:PROC|FUNC)\b")
_HEAD = re.compile(r"(?:LOCAL )?(?:PROC|FUNC \w+) (\w+) ?\((.*)\)")
_MODULE = re.compile(r"(?:SYS)?MODULE (\w+)(?: ?\(.*\))?")
_LISTED = re.compile(r"<MODULE>([^<]+)</MODULE>", re.IGNORECASE)
_LONGEST = 20_000  # characters of one statement


@dataclass(frozen=True, slots=True)
class MoveRow:
    """A MoveL that is all plain numbers and names, on one line: numbers by group, then zone, tool and work object."""

    number: int
    place: tuple[float, ...]
    turn: tuple[float, ...]
    conf: tuple[float, ...]
    external: tuple[float, ...]
    speed: tuple[float, ...]
    names: tuple[str, str, str]


@dataclass(slots=True)
class Procedure:
    """A PROC. `inputs`: type and name of what it is handed by value, or by reference where none of its statements sets anything;
    None where it takes something in another way.
    """

    name: str
    head: Line
    inputs: list[tuple[str, str]] | None
    nodes: list[Line | MoveRow] = field(default_factory=list)


@dataclass(slots=True)
class RapidModule:
    """A file: what it declares, its procedures by name, and what stands outside of both."""

    path: Path
    count: int
    longest: tuple[int, int]  # line and characters
    data: list[Line] = field(default_factory=list)
    procedures: dict[str, Procedure] = field(default_factory=dict)
    outside: list[Line] = field(default_factory=list)
    functions: dict[str, Procedure] = field(default_factory=dict)


# statements that only move, wait, switch or branch: what they name they leave as it was
_READING = re.compile(
    r"(?:MOVEABSJ|MOVEJ|MOVEL|MOVEC|WAITTIME|SETDO|SETAO|SETGO|SET|RESET|TPWRITE|CONFJ|CONFL|SINGAREA) .*|TPERASE|RETURN"
    r"|(?:IF|ELSEIF) .* THEN|ELSE|ENDIF|TEST .*|CASE .*:|DEFAULT:|ENDTEST"
)


def _only_reads(procedure: Procedure) -> bool:
    """Whether it sets nothing, by itself or by what it calls."""
    return all(isinstance(node, MoveRow) or _READING.fullmatch(node.code) for node in procedure.nodes)


def _inputs(text: str) -> list[tuple[str, str]] | None:
    """Parameters that are handed by value: TYPE NAME, TYPE NAME."""
    found = [re.fullmatch(r"(\w+) (\w+)", part.strip()) for part in text.split(",")] if text.strip() else []
    return [(match[1], match[2]) for match in found if match] if all(found) else None


def _code(raw: str) -> str:
    """A line without its comment, in capitals outside of texts, single blanks; a question mark before what isn't of 7 bits there,
    as Python takes more for a blank than a controller does, and other letters for capitals of ASCII.
    """
    parts = raw.split('"')
    for k in range(0, len(parts), 2):  # every other part is a text
        parts[k], mark, _ = parts[k].partition("!")
        if mark:
            del parts[k + 1 :]
            break
    known = all(part.isascii() for part in parts[::2])
    parts[::2] = [part.upper() for part in parts[::2]]
    code = '"'.join(parts).strip() if '"' in raw else " ".join(parts[0].split())
    return code if known else f"? {code}"


def _row(number: int, raw: bytes) -> MoveRow | None:
    found = _ROW.fullmatch(raw)
    if found is None:
        return None
    try:
        groups = [tuple(float(text) for text in found[k].split(b",")) for k in range(1, 6)]  # five lists
    except ValueError:
        return None
    if tuple(len(group) for group in groups) != _SIZES:
        return None
    zone, tool, wobj = (found[k].decode("latin-1").upper() for k in (6, 7, 8))  # the names behind them
    place, turn, conf, external, speed = groups
    return MoveRow(number, place, turn, conf, external, speed, (zone, tool, wobj))


def _nodes(lines: list[bytes]) -> Iterator[Line | MoveRow]:
    """Statements as they end by a semicolon, lines of structure as they stand alone, rows."""
    held, begun, raw_held = "", 0, ""
    for number, raw in enumerate(lines, 1):
        if not held and (row := _row(number, raw)) is not None:
            yield row
            continue
        text = raw.decode("latin-1")
        code = _code(text)
        if not held and _STRUCTURE.fullmatch(code) and not code.endswith(";"):
            if code.count("(") <= code.count(")") or not _ROUTINE.match(code):
                yield Line(number, code, "", text.strip())
                continue
            held, begun, raw_held = code, number, text.strip()  # its parameters stand on lines of their own
            continue
        if held and _ROUTINE.match(held):
            held = f"{held} {code}".strip()
            if held.count("(") <= held.count(")"):
                yield Line(begun, held.replace(" )", ")").replace("( ", "("), "", raw_held)
                held = ""
            elif len(held) > _LONGEST:
                raise ProgramError("a head without an end", line=begun)
            continue
        for k, piece in enumerate(_pieces(code)):
            if k:
                if held:
                    yield Line(begun, held, "", raw_held)
                held = ""
            if piece.strip():
                begun, raw_held = (number, text.strip()) if not held else (begun, raw_held)
                held = f"{held} {piece.strip()}".strip()
        if len(held) > _LONGEST:
            raise ProgramError("a statement without an end", line=begun)
    if held:
        yield Line(begun, held, "", raw_held)


def _pieces(code: str) -> list[str]:
    """What stands between semicolons outside of texts."""
    if '"' not in code:
        return code.split(";")
    out, quoted = [""], False
    for letter in code:
        quoted ^= letter == '"'
        if letter == ";" and not quoted:
            out.append("")
        else:
            out[-1] += letter
    return out


def read_rapid_module(path: Path) -> RapidModule:
    """Reads one module. Raises ProgramError where it can't be read, is no text, or does not close."""
    try:
        content = path.read_bytes()
    except OSError as failure:
        raise ProgramError(f"can't be read ({failure.strerror or failure})", path=path) from failure
    content = content.replace(b"\r\n", b"\n")
    if b"\0" in content or b"\r" in content:
        raise ProgramError("is not text, or ends lines in two ways (a CR without its LF)", path=path)
    lines = content.split(b"\n")
    longest = max((len(line), -number) for number, line in enumerate(lines, 1))
    module = RapidModule(path, len(lines), (-longest[1], longest[0]))
    open_: Procedure | None = None
    until, closed, begun = "", False, False
    for node in _nodes(lines):
        code = node.code if isinstance(node, Line) else ""
        if open_ is not None and code != until:
            open_.nodes.append(node)
        elif open_ is not None:
            referring = re.search(r"[(,] ?(?:VAR|INOUT|PERS) .*", open_.head.code)
            if referring and _only_reads(open_) and (given := _HEAD.fullmatch(open_.head.code)) is not None:
                open_.inputs = _inputs(re.sub(r"(^|,) ?(?:VAR|INOUT|PERS) ", r"\1", given[2]))
            open_, until = None, ""
        elif until:
            until = "" if code == until else until
        elif isinstance(node, MoveRow):
            module.outside.append(Line(node.number, "MOVEL", "", "MoveL .."))
        elif (head := _HEAD.fullmatch(code)) is not None:
            routines = module.functions if "FUNC " in code else module.procedures
            if head[1] in routines:
                raise ProgramError(f"has two routines {head[1]}", path=path, line=node.number)
            open_ = routines.setdefault(head[1], Procedure(head[1], node, _inputs(head[2])))
            until = "ENDPROC" if routines is module.procedures else "ENDFUNC"
        elif _MODULE.fullmatch(code):
            begun = True
        elif code == "ENDMODULE":
            closed = True
        elif (word := re.match(r"(?:LOCAL )?(FUNC|TRAP|RECORD)\b", code)) is not None:
            until = f"END{word[1]}"
        elif re.match(r"(?:LOCAL |TASK )?(?:CONST|VAR|PERS) ", code):
            module.data.append(node)
        elif not code.startswith("%%%") and not re.fullmatch(r"VERSION ?:.*|LANGUAGE ?:.*", code):
            module.outside.append(node)
    if open_ is not None or until or not closed or not begun:
        raise ProgramError("does not close what it opens, or is no module", path=path)
    return module


def listed_modules(main: Path) -> list[Path]:
    """The other modules that NAME.pgf beside NAME.mod lists. Raises ProgramError for one that isn't there."""
    beside = {file.name.lower(): file for file in main.parent.iterdir() if file.is_file()}
    listing = beside.get(f"{main.stem.lower()}.pgf")
    if listing is None:
        return []
    names = [name.strip() for name in _LISTED.findall(listing.read_bytes().decode("latin-1"))]
    missing = [name for name in names if name.lower() not in beside]
    if missing:
        raise ProgramError(f"lists {missing[0][:60]!r}, which isn't beside it", path=listing)
    return [beside[name.lower()] for name in names if name.lower() != main.name.lower()]
