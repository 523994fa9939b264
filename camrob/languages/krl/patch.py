"""Other targets in the text of a KRL program, everything else left byte for byte."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from camrob.errors import KrlError
from camrob.languages.krl.krl_text import comment_text
from camrob.program.language import AddedTarget, NewTarget

__all__ = ["divide_source", "headed_source", "literal_targets", "patch_source"]

_STATEMENT = re.compile(r"\s*S?(?:PTP|LIN|CIRC)\b", re.IGNORECASE)
_DEF = re.compile(r"\s*(?:GLOBAL\s+)?DEF\s", re.IGNORECASE)
_COMMENT = 78  # characters: what every controller takes
_AGGREGATE = re.compile(r"\{[^{};\"]*\}")
_COMPONENT = re.compile(
    r"(?<![A-Za-z0-9_])([A-Za-z]\d?)(\s+|\s*(?=[-+.]))([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(?=[,}])"
)
_POSE, _AXES = ("X", "Y", "Z", "A", "B", "C"), tuple(f"A{k}" for k in range(1, 7))
_LEAST_EXTERNAL = 4  # decimals, mm or degrees
_LEAST = {**dict.fromkeys(_POSE[:3], 4), **dict.fromkeys((*_POSE[3:], *_AXES), 5), "T": 0}


def patch_source(text: str, targets: Mapping[int, Sequence[NewTarget]]) -> str:
    """The program text with the targets of some lines (from 1) replaced; a CIRC has two.

    Every number keeps its place and at least its decimals (4 for mm, 5 for degrees at the least); components that a
    target leaves out are added to it. Raises KrlError, with the line, where a target is not written in the statement
    as plain numbers, so that there is nothing to replace.
    """
    lines = text.split("\n")  # as the reader counts them; a form feed or an odd byte in a comment ends no line
    for number, wanted in targets.items():
        numbers = [
            dict(zip(_AXES if t.by_axes else _POSE, t.values, strict=True)) | ({} if t.turn is None else {"T": t.turn})
            for t in wanted
        ]
        lines[number - 1] = _line(lines[number - 1], numbers, number)
    return "\n".join(lines)


def headed_source(text: str, comments: Sequence[str]) -> str:
    """The program text with lines of comment behind its first DEF; as it is where it has none."""
    lines = text.split("\n")
    at = next((k for k, line in enumerate(lines) if _DEF.match(line)), None)
    if at is not None:
        end = "\r" if lines[at].endswith("\r") else ""
        lines[at + 1 : at + 1] = [f"; {comment_text(said, _COMMENT)}{end}" for said in comments]
    return "\n".join(lines)


def divide_source(text: str, targets: Mapping[int, Sequence[AddedTarget]]) -> str:
    """The program text with a copy of some lines (from 1) before them for each target, with its numbers.

    Of the external axes those that the line names; the others stand still along it. Raises KrlError as `patch_source` does.
    """
    lines = text.split("\n")
    copies = {
        number: [
            _line(lines[number - 1], [dict(zip(_POSE, t.values, strict=True))], number, external=t.external)
            for t in wanted
        ]
        for number, wanted in targets.items()
    }
    return "\n".join(line for k, one in enumerate(lines, 1) for line in (*copies.get(k, ()), one))


def _line(
    line: str, targets: Sequence[Mapping[str, float]], number: int, external: Mapping[str, float] | None = None
) -> str:
    """One statement with its new targets, numbers by component."""
    code, semicolon, comment = line.partition(";")
    found = list(_AGGREGATE.finditer(code)) if _STATEMENT.match(code) else []
    if len(found) != len(targets):
        what = "the motion's target is not written in the statement"
        raise KrlError(what, hint="give a program with literal targets", line=number)
    out, at = [], 0
    for match, target in zip(found, targets, strict=True):
        out += [code[at : match.start()], _aggregate(match[0], target, number, external or {})]
        at = match.end()
    return "".join([*out, code[at:], semicolon, comment])


def _aggregate(text: str, values: Mapping[str, float], number: int, external: Mapping[str, float]) -> str:
    """One {...} with its new numbers; those of external axes where it names them."""
    names = tuple(values)
    seen: set[str] = set()

    def replaced(match: re.Match[str]) -> str:
        name = match[1].upper()
        if name not in values and name not in external:
            return match[0]
        seen.add(name)
        decimals = len(match[3].partition(".")[2]) if "e" not in match[3].lower() else 0
        value = values[name] if name in values else external[name]
        return f"{match[1]}{match[2] or ' '}{_printed(value, max(decimals, _LEAST.get(name, _LEAST_EXTERNAL)))}"

    body = _COMPONENT.sub(replaced, text)
    named = {m.upper() for m in re.findall(r"(?<![A-Za-z0-9_])([A-Za-z]\d?)(?=[\s+\-.])", text)} & {*names, *external}
    if named != seen:
        what = f"{', '.join(sorted(named - seen))} is not a plain number"
        raise KrlError(what, hint="give a program with literal targets", line=number)
    missing = [n for n in names if n not in seen]
    if len(missing) == len(names):
        raise KrlError("the target holds no pose", hint="give a program with literal targets", line=number)
    added = "".join(f",{n} {_printed(values[n], _LEAST[n])}" for n in missing)
    return f"{body[:-1].rstrip()}{added}}}" if added else body


def _printed(value: float, decimals: int) -> str:
    """A number with its decimals, never -0."""
    text = f"{value:.{decimals}f}"
    return text[1:] if text[0] == "-" and not text.strip("-0.") else text


def literal_targets(statement: str) -> int:
    """How many targets {...} are written in a motion statement, 0 for a named one or another statement."""
    code = statement.partition(";")[0]
    return len(_AGGREGATE.findall(code)) if _STATEMENT.match(code) else 0
