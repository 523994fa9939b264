"""Other targets in the text of a RAPID module, everything else left byte for byte."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from camrob.errors import ProgramError
from camrob.languages.rapid.rapid_numbers import (
    ANGLE_DECIMALS,
    EXTERNAL_DECIMALS,
    LENGTH_DECIMALS,
    QUATERNION_DECIMALS,
    quaternions,
)
from camrob.languages.rapid.rapid_text import comment_text
from camrob.program.axis_turns import quarters_of
from camrob.program.language import AddedTarget, NewTarget
from camrob.program.printed import fixed_decimals

__all__ = ["divide_module", "headed_module", "literal_targets", "patch_module"]

_MOTION = re.compile(r"\s*Move(?:AbsJ|J|L|C)\b", re.IGNORECASE)
_MODULE = re.compile(r"\s*MODULE\s", re.IGNORECASE)
_COMMENT = 76  # characters
_LINE = re.compile(r"\s*MoveL\b", re.IGNORECASE)
_VALUE = r"\s*[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?\s*"


def _list(count: int) -> str:
    return rf"\[({_VALUE}(?:,{_VALUE}){{{count - 1}}})\]"


_TARGET = re.compile(
    rf"\[\s*{_list(3)}\s*,\s*{_list(4)}\s*,\s*{_list(4)}\s*,\s*{_list(6)}\s*\]|\[\s*{_list(6)}\s*,\s*{_list(6)}\s*\]"
)
"""A robtarget (groups 1 to 4) or a jointtarget (groups 5 and 6), of plain numbers."""
_HINT = "give a program with literal targets"
_ABSENT = 8.9e9  # from here on an external axis is 9E9: none


def patch_module(text: str, targets: Mapping[int, Sequence[NewTarget]]) -> str:
    """The module's text with the targets of some lines (from 1) replaced; a MoveC has two.

    Numbers get the decimals that camrob prints, or those that they have where these are more. Raises ProgramError, with the
    line, where a target is not written in the line as plain numbers.
    """
    lines = text.split("\n")
    for number, wanted in targets.items():
        line = lines[number - 1]
        found = _targets(line)
        if len(found) != len(wanted) or any(
            (m[5] is not None) != t.by_axes for m, t in zip(found, wanted, strict=True)
        ):
            raise ProgramError("the motion's target is not written in the statement", hint=_HINT, line=number)
        for match, target in reversed(list(zip(found, wanted, strict=True))):
            new = _joints(match, target.values) if target.by_axes else _pose(match, target.values, {}, target.turn)
            line = line[: match.start()] + new + line[match.end() :]
        lines[number - 1] = line
    return "\n".join(lines)


def headed_module(text: str, comments: Sequence[str]) -> str:
    """The module's text with lines of comment behind its first line MODULE; as it is where it has none."""
    lines = text.split("\n")
    at = next((k for k, line in enumerate(lines) if _MODULE.match(line)), None)
    if at is not None:
        end = "\r" if lines[at].endswith("\r") else ""
        lines[at + 1 : at + 1] = [f"  ! {comment_text(said, _COMMENT)}{end}" for said in comments]
    return "\n".join(lines)


def divide_module(text: str, targets: Mapping[int, Sequence[AddedTarget]]) -> str:
    """The module's text with a copy of some MoveLs (lines from 1) before them for each target, with its numbers.

    Of the external axes those that the line names; the others stand still along it. Raises ProgramError as `patch_module` does.
    """
    out = []
    for number, line in enumerate(text.split("\n"), 1):
        for target in targets.get(number, ()):
            found = _targets(line)
            if len(found) != 1 or not _LINE.match(line) or found[0][1] is None:
                raise ProgramError("the motion's target is not written in the statement", hint=_HINT, line=number)
            match = found[0]
            out.append(line[: match.start()] + _pose(match, target.values, target.external) + line[match.end() :])
        out.append(line)
    return "\n".join(out)


def literal_targets(statement: str) -> int:
    """How many targets of plain numbers are written in a motion's line, 0 for a named one or another statement."""
    return len(_targets(statement))


def _targets(line: str) -> list[re.Match[str]]:
    """The targets of a line that is one motion; a comment behind it doesn't count."""
    code = re.sub(r'!.*|"[^"]*"', lambda m: " " * len(m[0]), line)
    return list(_TARGET.finditer(code)) if _MOTION.match(code) else []


def _joints(match: re.Match[str], values: Sequence[float]) -> str:
    return f"[[{_printed(values, match[5], ANGLE_DECIMALS)}],[{match[6]}]]"


def _pose(
    match: re.Match[str], values: Sequence[float], external: Mapping[str, float], turns: int | None = None
) -> str:
    """A robtarget with its new numbers; `turns` as of `Turning.QUARTERS`, None where the confdata stays."""
    place, turn = values[:3], quaternions(values[3:]).tolist()
    old = match[4].split(",")
    carried = [
        f"{fixed_decimals(external[f'E{k + 1}'], EXTERNAL_DECIMALS)}"
        if f"E{k + 1}" in external and float(text) < _ABSENT
        else text
        for k, text in enumerate(old)
    ]
    first = f"[{_printed(place, match[1], LENGTH_DECIMALS + 1)}],[{_printed(turn, match[2], QUATERNION_DECIMALS)}]"
    branch = match[3].rpartition(",")[2]
    conf = match[3] if turns is None else ",".join([*map(str, quarters_of(turns).tolist()), branch])
    return f"[{first},[{conf}],[{','.join(carried)}]]"


def _printed(values: Sequence[float], old: str, least: int) -> str:
    """Numbers with the decimals of those that they replace, and no fewer than `least`."""
    kept = [len(text.strip().partition(".")[2]) if "e" not in text.lower() else 0 for text in old.split(",")]
    return ",".join(fixed_decimals(v, max(least, d)) for v, d in zip(values, kept, strict=True))
