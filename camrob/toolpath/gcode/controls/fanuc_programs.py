"""The programs of one file for Fanuc: each begins with its O number; the main one is run, the others are called."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.language.called_files import Wanted, calls
from camrob.toolpath.gcode.language.flow import Line

__all__ = ["PROGRAM", "REPEATS", "spelled", "split_programs", "wanted_programs"]

PROGRAM = re.compile(r"[O:]([0-9]+)(.*)")
REPEATS = 10_000
"""M98 P51002: five times O1002."""
_CALLED = re.compile(r"(?:M0*98|G0*65)[^(;]*?P *([0-9]+)")
_END = re.compile(r"M0*(?:30|2)(?![0-9.])")
_HEAD = re.compile(r"[ \t]*[O:][ \t]*0*([0-9]+)")
_CALLS = re.compile(r"(?:M[ \t]*0*98|G[ \t]*0*65)(?![0-9.])[^P]*?P[ \t]*0*([0-9]+)(?![0-9.])")
_SUFFIXES = frozenset(("", ".nc", ".cnc", ".eia", ".tap", ".txt", ".ncp", ".prg", ".sub"))
_SHORT = {
    word[:2]: word for word in "WHILE ROUND FIX FUP SIN COS TAN ASIN ACOS ATAN SQRT ABS EXP".split()
}  # as the control lets them be cut short (Fanuc B-63944EN/03, 15.2)
_SHORTENED = re.compile(rf"(?<![A-Z])({'|'.join(_SHORT)})(?=\[)")
_Part = tuple[int, int, int]  # first line, before which line it ends, its number


def spelled(text: str) -> str:
    """A statement with the words in full that stand there by their first two letters: WH[...]DO1, EN1, IF[...]GO5, IF[...]TH."""
    if "[" in text:
        text = _SHORTENED.sub(lambda match: _SHORT[match[1]], text)
        text = re.sub(
            r"(?<=\])(?:GO(?=[0-9#\[])|TH(?!EN)(?=[A-Z#]))", lambda m: {"GO": "GOTO", "TH": "THEN"}[m[0]], text
        )
    return re.sub(r"^EN(?=[0-9]+$)", "END", text)


def split_programs(
    raw: list[str], line: Callable[[int], Line], path: Path
) -> tuple[dict[int, tuple[int, int]], tuple[int, int]]:
    """The programs of a file by their numbers, and the main one: each from its first line to before the next.

    `line` prepares one by its index. Raises ToolpathError where a number stands twice, or more than one could be the main one.
    """
    real = [p for p in _parts(raw, line) if any(line(i).text.strip("%") for i in range(p[0], p[1]))]
    programs: dict[int, tuple[int, int]] = {}
    for first, end, number in real:
        if number in programs:
            raise ToolpathError(f"O{number} appears twice in the file", hint="keep one", path=path, line=first + 1)
        programs[number] = (first, end)
    called = {int(n) % REPEATS for text in raw for n in _CALLED.findall(text.upper())}
    free = [p for p in real if p[2] not in called]
    main = [p for p in free if any(_END.search(line(i).text) for i in range(p[0], p[1]))] or free[:1] or real[:1]
    if len(main) > 1:
        raise ToolpathError(
            f"{len(main)} programs with an M30 of their own in one file: which one is meant is not known",
            hint="give each program a file of its own",
            path=path,
            line=main[1][0] + 1,
        )
    if not main:
        raise ToolpathError("no G-code in the file", hint="export it again", path=path)
    return programs, main[0][:2]


def _parts(raw: list[str], line: Callable[[int], Line]) -> list[_Part]:
    starts = [(0, -1)]
    for index, text in enumerate(raw):
        if text.lstrip()[:1] in (*"Oo:", "("):
            match = PROGRAM.fullmatch(line(index).text)
            if match:
                starts.append((index, int(match[1])))
    ends = [start for start, _ in starts[1:]] + [len(raw)]
    return [(first, end, number) for (first, number), end in zip(starts, ends, strict=True)]


def wanted_programs(lines: list[str]) -> list[Wanted]:
    """The programs that M98 and G65 call by numbers which no program of the text has: O5001 lies in 5001.nc, O5001 or alike."""
    own = {int(match[1]) for line in lines if (match := _HEAD.match(line.upper()))}
    called = [int(number) for number in calls(_CALLS, lines)]
    numbers = {n if n < REPEATS else n % REPEATS: None for n in called if n not in own and n % REPEATS not in own}
    return [
        Wanted(
            name=f"O{n}",
            stems=frozenset(f"{letter}{n:0{width}d}" for letter in ("", "o") for width in range(1, 9)),
            suffixes=_SUFFIXES,
            head=f"O{n}",
            named=_HEAD,
        )
        for n in numbers
    ]
