"""The programs of one Siemens file, each behind its line %_N_NAME_MPF or %_N_NAME_SPF: the main one, and calls of the others."""

from __future__ import annotations

import re
from collections.abc import Sequence

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.language.called_files import Wanted, calls
from camrob.toolpath.gcode.language.flow import DEEPEST

__all__ = ["Sections", "wanted_programs"]

_HEAD = re.compile(r"%_N_(\w+)_(MPF|SPF)$")
_CALL = re.compile(r"([A-Z_][A-Z0-9_]*)(?:\(\))?(?: ?P=?([0-9]+))?$")
_MOST_PASSES = 9_999  # P has four digits
_NAMED = re.compile(r"\s*%_N_(\w+)_(?:MPF|SPF)")
_ALONE = re.compile(
    r"^[ \t]*(?:/[0-9]?[ \t]*)?(?:N[0-9]+[ \t]*)?([A-Z_][A-Z_]\w*|L[0-9]+)[ \t]*(?:\([ \t]*\))?"
    r"(?:[ \t]*P[ \t]*=?[ \t]*[0-9]+)?[ \t]*$"
)
_SUFFIXES = frozenset((".spf",))


def wanted_programs(lines: list[str]) -> list[Wanted]:
    """The subprograms that blocks call by their names alone and that the text doesn't hold: NAME lies in NAME.SPF."""
    own = {match[1] for line in lines if (match := _NAMED.match(line.upper()))}
    return [
        Wanted(name, frozenset((name.lower(), f"_n_{name.lower()}_spf")), _SUFFIXES, f"%_N_{name}_SPF", _NAMED)
        for name in calls(_ALONE, lines)
        if name not in own
    ]


class Sections:
    """Where each program of the lines `texts` (upper case, without comments) begins and ends, and who has called whom."""

    def __init__(self, texts: Sequence[str]) -> None:
        heads = [(i, match) for i, text in enumerate(texts) if (match := _HEAD.match(text))]
        ends = [i for i, _ in heads[1:]] + [len(texts)] * bool(heads)
        self._places = {match[1]: (i, end) for (i, match), end in zip(heads, ends, strict=True)}
        mains = [match[1] for _, match in heads if match[2] == "MPF"]
        if len(mains) > 1 or len(self._places) < len(heads):
            line = heads[-1][0] + 1
            raise ToolpathError("several main programs in one file", hint="give each a file of its own", line=line)
        alone = (0, len(texts)) if len(heads) < 2 else (0, ends[0])
        if heads and not mains and any(re.sub(r"^%\w*$", "", text) for text in texts[: heads[0][0]]):
            alone = (0, heads[0][0])  # the main program has no head of its own
        self._bounds = self._places[mains[0]] if mains and len(heads) > 1 else alone
        self.main = self._bounds[0]
        self._stack: list[tuple[int, tuple[int, int], int]] = []  # where to go on, the caller's bounds, passes left

    @property
    def called(self) -> bool:
        """Whether a subprogram is being run."""
        return bool(self._stack)

    @property
    def depth(self) -> int:
        """How many subprograms are being run, one called by another."""
        return len(self._stack)

    @property
    def bounds(self) -> tuple[int, int]:
        """The lines, from the first to before the last, of the program that is being run."""
        return self._bounds

    def call(self, text: str, at: int) -> int:
        """The line at which the subprogram that `text` calls begins, 0 where it calls none of this file; `at` comes behind it."""
        match = _CALL.match(text)
        place = self._places.get(match[1]) if match else None
        if match is None or place is None:
            return 0
        passes = int(match[2] or 1)
        if len(self._stack) > DEEPEST or not 1 <= passes <= _MOST_PASSES:
            raise ToolpathError(
                f"{match[1]} is called too deeply, or too often", hint="check for one that calls itself"
            )
        self._stack.append((at, self._bounds, passes - 1))
        self._bounds = place
        return place[0] + 1

    def back(self) -> int:
        """Where a subprogram that ends goes on: at its beginning for another pass, or behind its call."""
        back, bounds, left = self._stack.pop()
        if left:
            self._stack.append((back, bounds, left - 1))
            return self._bounds[0] + 1
        self._bounds = bounds
        return back
