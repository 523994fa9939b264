"""Heidenhain's labels: subprograms, repeats of program sections, and jumps (TNC 640, "Klartext Programming", 8 and 9).

CALL LBL n runs what stands between LBL n and LBL 0. CALL LBL n REP r runs from LBL n to itself r times more. FN 9 to FN 12 jump.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import NamedTuple

from camrob.witness.cl.running.ordered import Ordered, Row, less
from camrob.witness.cl.running.unread import NOWHERE, UnreadError

__all__ = ["LabelRun"]

_NAME = r"(\d+|\"[^\"]*\")"
_VALUE = r"([-+]?(?:Q[LR]?\d+|\d+\.?\d*|\.\d+))"
_LABEL = re.compile(rf"LBL ?{_NAME}")
_CALL = re.compile(rf"CALL LBL ?{_NAME}(?: ?REP ?(\d+|Q[LR]?\d+)(?: ?/ ?(\d+|Q[LR]?\d+))?)?")
_JUMP = re.compile(rf"FN ?(9|10|11|12) ?: ?IF ?{_VALUE} ?(EQU|NE|GT|LT) ?{_VALUE} ?GOTO LBL ?{_NAME}")
_SIGNS = {"9": "EQU", "10": "NE", "11": "GT", "12": "LT"}
_LAST = re.compile(r"\bM0*(?:2|30)(?!\d)|^(?:END|BEGIN) PGM|^STOP\b")
_NESTED = 8  # subprograms in one another, as older controls have it


class _Frame(NamedTuple):
    back: int
    first: int
    last: int
    counts: dict[int, int | None]


class LabelRun(Ordered):
    """value: what a parameter or number comes to; raises UnreadError where nobody knows."""

    def __init__(self, rows: list[Row], value: Callable[[str], float]) -> None:
        super().__init__(rows)
        self._value = value
        self._frames: list[_Frame] = []
        self._counts: dict[int, int | None] = {}  # repeats that are left, by their calls; None: left by a jump
        self._begins: dict[int, int] = {}  # of sections that are repeated, by their calls
        self._labels: dict[str, int] = {}
        for i, (_, row) in enumerate(rows):
            if (found := _LABEL.fullmatch(row)) and found[1] != "0":
                name = self._name(found[1])
                self._labels[name] = -1 if name in self._labels else i

    @staticmethod
    def _name(text: str) -> str:
        return text if text.startswith('"') else str(int(text))

    def _place(self, text: str) -> int:
        found = self._labels.get(self._name(text))
        if found is None:
            raise UnreadError(f"LBL {text}: {NOWHERE}")
        if found < 0:
            raise UnreadError(f"LBL {text}, more than once")
        return found

    def _called(self) -> bool:
        return bool(self._frames)

    def _step(self, at: int, row: str) -> tuple[int, str]:
        if found := _LABEL.fullmatch(row):
            ends = self._name(found[1]) == "0" and self._frames  # one that isn't called is run through
            return (self._return() if ends else at + 1), ""
        if call := _CALL.fullmatch(row):
            return (self._call(at, call[1]) if call[2] is None else self._repeat(at, call)), ""
        if jump := _JUMP.fullmatch(row):
            return self._jump(at, jump), ""
        return at + 1, row

    def _return(self) -> int:
        frame = self._frames.pop()
        self._counts = frame.counts
        return frame.back + 1

    def _call(self, at: int, name: str) -> int:
        first = self._place(name)
        ends = [i for i in range(first, len(self.rows)) if re.fullmatch(r"LBL ?0+", self.rows[i][1])]
        if not ends or len(self._frames) >= _NESTED:
            raise UnreadError(f"CALL LBL {name} without LBL 0, or nested too deep")
        self._frames.append(_Frame(at, first, ends[0], self._counts))
        self._counts = {}
        return first + 1

    def _repeat(self, at: int, call: re.Match[str]) -> int:
        first, times = self._place(call[1]), self._value(call[2])
        if first > at or call[3] not in (None, call[2]) or times % 1.0 or times < 0.0:
            raise UnreadError("a repeat of what stands behind it, or that has begun")
        if self._frames and not self._frames[-1].first <= first:
            raise UnreadError("a repeat of what stands outside of its subprogram")
        self._begins[at] = first
        left = self._counts.get(at, int(times))
        if left is None:
            raise UnreadError("a repeat that a jump has left")
        if left > 0:
            self._counts[at] = left - 1
            return first + 1
        self._counts.pop(at, None)
        return at + 1

    def _leave(self, target: int) -> None:
        """On at a label elsewhere: the LBL 0 behind that ends the call. Raises UnreadError where the program ends before it."""
        ends = (i for i in range(target, len(self.rows)) if re.fullmatch(r"LBL ?0+", self.rows[i][1]))
        last = next(ends, -1)
        if last < 0 or any(_LAST.search(row) for _, row in self.rows[target:last]):
            raise UnreadError("a jump out of a subprogram")
        self._frames[-1] = self._frames[-1]._replace(first=target, last=last)

    def _jump(self, at: int, found: re.Match[str]) -> int:
        if _SIGNS[found[1]] != found[3]:
            raise UnreadError(f"FN {found[1]} with {found[3]}")
        off = less(self._value(found[2]), self._value(found[4]))
        if not {"EQU": off == 0.0, "NE": off != 0.0, "GT": off > 0.0, "LT": off < 0.0}[found[3]]:
            return at + 1
        target = self._place(found[5])
        if self._frames and not self._frames[-1].first <= target <= self._frames[-1].last:
            self._leave(target)
        for call in self._counts:
            if not self._begins[call] <= target <= call:
                self._counts[call] = None
        return target + 1
