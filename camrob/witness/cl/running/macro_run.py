"""Custom macros of Fanuc's and controls alike, and their subprograms (B-63014, 13 to 15; Haas's M97).

Local variables belong to a level of G65; M98 and M97 leave the level. What a program hasn't set is not known, but for what a G65
doesn't hand over, which holds nothing: a word of it is left out.
"""

from __future__ import annotations

import re
from itertools import pairwise
from typing import NamedTuple

from camrob.witness.cl.running.bracket_values import Style, whole
from camrob.witness.cl.running.ordered import Row
from camrob.witness.cl.running.running_blocks import Ask, Running, bracketed
from camrob.witness.cl.running.unread import NOWHERE, UnreadError

__all__ = ["MacroRun"]

_NAMED = re.compile(r"[O:](\d+)(?=$|[^\dA-Z<\[])")
_CALL = re.compile(r"M0*(97|98)(?![\d.])")
_BACK = re.compile(r"(?:N\d+)?M0*99(?:P(\d+))?")
_END = re.compile(r"M0*(?:2|30)(?![\d.])")
_LOOP = re.compile(r"(?:(WHILE)(?=\[)|DO([1-9])|END([1-9]))")
_BESIDE = re.compile(r"(?:G0*[01](?![\d.])|G9[01](?![\d.])|[XYZF][-+]?[\d.]+)*")
# the variables of G65's letters (argument specification I)
_ARGUMENTS = dict(zip("ABCIJKDEFHMQRSTUVWXYZ", (1, 2, 3, 4, 5, 6, 7, 8, 9, 11, 13, *range(17, 27)), strict=True))
_POINTLESS = frozenset("DHMST")  # whose numbers are counts: the others' stand for least increments without a point
_LOCAL = range(1, 34)
_COMMON = (*range(100, 200), *range(500, 1000))
_NESTED = 10  # calls in one another: older controls take four, and stop


class _Frame(NamedTuple):
    back: int  # of the call
    first: int
    times: int  # runs that are left, this one too
    local: dict[str, float | None] | None  # the caller's, for G65
    given: dict[str, float | None]
    is_macro: bool


class MacroRun(Running):
    """rows: without blanks and comments, upper case."""

    def __init__(self, rows: list[Row], styles: tuple[Style, ...], ask: Ask) -> None:
        super().__init__(rows, styles, ask)
        self._frames: list[_Frame] = []
        self._programs: dict[int, tuple[int, int]] = {}
        self._twice: set[int] = set()
        self._segments: list[tuple[int, int]] = []
        self._find_programs()
        self._sequence: dict[tuple[int, int], int] = {}  # by the program's first block and N: the block, -1 for several
        self._loops: dict[int, int] = {}  # from a loop's head to its end, and back
        for first, last in self._segments:
            self._find_places(first, last)

    # -- what stands where

    def _find_programs(self) -> None:
        starts = [i for i, (_, block) in enumerate(self.rows) if _NAMED.match(block)]
        edges = sorted({0, *starts, len(self.rows)})
        for first, last in pairwise(edges):
            self._segments.append((first, last))
            if found := _NAMED.match(self.rows[first][1]):
                number = int(found[1])
                if number in self._programs:
                    self._twice.add(number)
                self._programs[number] = (first, last)

    def _find_places(self, first: int, last: int) -> None:
        heads: list[tuple[str, int]] = []
        for i in range(first, last):
            block = self.rows[i][1]
            body = block
            if found := re.match(r"N(\d+)", block):
                key = (first, int(found[1]))
                self._sequence[key] = -1 if key in self._sequence else i
                body = block[found.end() :]
            loop = _LOOP.match(body)
            if loop is None:
                continue
            if loop[3]:
                if heads and heads[-1][0] == loop[3]:
                    self._loops[i] = heads[-1][1]
                    self._loops[heads.pop()[1]] = i
                continue
            number = loop[2] or body.rpartition("DO")[2]
            heads.append((number, i))

    def _start(self) -> int:
        """The main program: the only one, or the only one with an end (M2, M30) that nothing calls."""
        ended = [s for s in self._segments if any(_END.search(self.rows[i][1]) for i in range(*s))]
        called = {int(n) for _, block in self.rows for n in re.findall(r"(?:G0*65|M0*98)\D*?P(\d+)", block)}
        called |= {n % 10_000 for n in called}
        free = [s for s in self._segments if not (m := _NAMED.match(self.rows[s[0]][1])) or int(m[1]) not in called]
        mains = [s for s in ended if s in free] or (free if not ended else [])
        if len(mains) != 1 or len(ended) > 1:
            raise UnreadError("several programs in the file, or none that nothing calls")
        self._main = mains[0]
        return self._main[0]

    def _segment(self) -> tuple[int, int]:
        if not self._frames:
            return self._main
        first = self._frames[-1].first
        return next(s for s in self._segments if s[0] <= first < s[1])

    def _called(self) -> bool:
        return bool(self._frames)

    # -- variables

    def _is_local(self, name: str) -> bool:
        number = int(name) if name.isdigit() else 0
        if number in _LOCAL:
            return True
        if number not in _COMMON:
            raise UnreadError(f"#{name}, which the control keeps")
        return False

    def _null(self, name: str) -> bool:
        return int(name) in _LOCAL and any(frame.is_macro for frame in self._frames)

    # -- blocks

    def _step(self, at: int, block: str) -> tuple[int, str]:
        first, last = self._segment()
        if not first <= at < last:
            if self._frames:
                raise UnreadError("a subprogram without M99")
            return -1, ""
        if found := _NAMED.match(block):
            block = block[found.end() :]
            if not block:
                return at + 1, ""
        bare = re.sub(r"^/\d?", "", block)
        body = re.sub(r"^N\d+", "", bare)
        if not (set(bare) & set("#[=<")) and not re.search(r"GOTO|^DO|^END\d|^IF|G0*6[567]|M0*9[789]", body):
            return at + 1, block
        if bare != block:
            raise UnreadError(f"{block[:24]}, a block that may be skipped")
        return self._flow(at, body)

    def _flow(self, at: int, body: str) -> tuple[int, str]:
        if body.startswith("IF["):
            end = bracketed(body, 2)
            held, rest = self._formulas.truth(body[2:end]), body[end:]
            if rest.startswith("GOTO"):
                return (self._to(at, rest[4:]) if held else at + 1), ""
            if not rest.startswith("THEN#"):
                raise UnreadError(f"{body[:24]}, a condition")
            if held:
                self._set(rest[4:])
            return at + 1, ""
        if body.startswith("GOTO"):
            return self._to(at, body[4:]), ""
        if loop := _LOOP.match(body):
            return self._loop(at, body, loop), ""
        if body.startswith("#"):
            self._set(body)
            return at + 1, ""
        if re.search(r"G0*6[67](?![\d.])", body):
            raise UnreadError("a modal macro call")
        if re.match(r"G0*65(?![\d.])", body):
            return self._macro(at, body), ""
        if _CALL.search(body):
            return self._subprogram(at, body)
        if back := _BACK.fullmatch(body):
            return self._return(at, back[1])
        if re.search(r"M0*99(?![\d.])", body):
            if set(body) & set("#[") or re.search(r"[PL]", body):
                raise UnreadError(f"{body[:24]}, an end with other words")
            if not self._frames:
                return -1, body
            return self._return(at, None)[0], re.sub(r"M0*99", "", body)
        if re.search(r"G0*65(?![\d.])|GOTO|[=<]", body):
            raise UnreadError(f"{body[:24]}, computed")
        return at + 1, self._words(body)

    def _set(self, text: str) -> None:
        name, at = self._assigned(text, 0)
        self._is_local(name)
        self._keep(name, self._formulas.value(text[at:]))

    def _to(self, at: int, text: str) -> int:
        """The block of a sequence number; a jump into a loop is none."""
        number = whole(self._formulas.value(text), "a jump")
        return self._at_number(number, at)

    def _at_number(self, number: int, origin: int) -> int:
        found = self._numbered(number)
        for head, end in self._loops.items():
            if head < found <= end and not head <= origin <= end:
                raise UnreadError(f"N{number}, a jump into a loop")
        return found

    def _numbered(self, number: int) -> int:
        found = self._sequence.get((self._segment()[0], number))
        if found is None:
            raise UnreadError(f"N{number}: {NOWHERE}")
        if found < 0:
            raise UnreadError(f"N{number}, more than once")
        return found

    def _loop(self, at: int, body: str, found: re.Match[str]) -> int:
        other = self._loops.get(at)
        if other is None:
            raise UnreadError(f"{body[:24]}, a loop without its end or head")
        if found[3]:
            if body != found[0]:
                raise UnreadError(f"{body[:24]}, a loop")
            return other
        if found[2]:
            if body != found[0]:
                raise UnreadError(f"{body[:24]}, a loop")
            return at + 1
        end = bracketed(body, len("WHILE"))
        if not re.fullmatch(r"DO[1-9]", body[end:]):
            raise UnreadError(f"{body[:24]}, a loop")
        return at + 1 if self._formulas.truth(body[len("WHILE") : end]) else other + 1

    # -- calls

    def _enter(self, at: int, target: int, times: int, given: dict[str, float | None] | None) -> int:
        if times < 1 or len(self._frames) >= _NESTED:
            raise UnreadError("a call that is none, or nested too deep")
        is_macro = given is not None or (bool(self._frames) and self._frames[-1].is_macro)
        self._frames.append(
            _Frame(at, target, times, self._local if given is not None else None, dict(given or {}), is_macro)
        )
        if given is not None:
            self._local = dict(given)
        return target

    def _program(self, number: int) -> int:
        if number not in self._programs:
            raise UnreadError(f"O{number}: {NOWHERE}")
        if number in self._twice:
            raise UnreadError(f"O{number}, more than once")
        return self._programs[number][0]

    def _subprogram(self, at: int, body: str) -> tuple[int, str]:
        """M98 P L and M97 P L, behind the motion of their block."""
        found, body = _CALL.search(body), self._counted(body)
        p, times = re.findall(r"P(\d+)(?![\d.])", body), re.findall(r"L(\d+)(?![\d.])", body)
        rest = re.sub(r"[PL]\d+", "", _CALL.sub("", body))
        if found is None or len(p) != 1 or len(times) > 1 or not _BESIDE.fullmatch(rest):
            raise UnreadError(f"{body[:24]}, a call")
        number, runs = int(p[0]), int(times[0]) if times else 1
        if found[1] == "97":
            return self._enter(at, self._numbered(number), runs, None), rest
        if len(p[0]) > 4 and not times:  # P00020100: twice O100
            short = int(p[0][-4:])
            if number in self._programs and short != number:
                raise UnreadError(f"P{p[0]}, a number, or runs and a number")
            number, runs = short, int(p[0][:-4]) or 1
        return self._enter(at, self._program(number), runs, None), rest

    def _counted(self, body: str) -> str:
        """The block with numbers for what is computed behind P and L."""
        while computed := re.search(r"[PL](?=[#\[])", body):
            value, end = self._formulas.part(body, computed.end(), single=True)
            body = f"{body[: computed.end()]}{whole(None if isinstance(value, bool) else value, body[:24])}{body[end:]}"
        return body

    def _macro(self, at: int, body: str) -> int:
        """G65 P L with its arguments."""
        words = self._arguments(re.sub(r"^G0*65", "", body))
        number = whole(words.pop("P", (None, True))[0], "G65")
        times = whole(words.pop("L", (1.0, True))[0], "G65")
        letters = [k for k in words if k in "IJK"]
        if set(words) - _ARGUMENTS.keys() or letters != sorted(letters):
            raise UnreadError(f"{body[:24]}, arguments")
        given: dict[str, float | None] = {}
        for letter, (value, exact) in words.items():
            if value and not exact and letter not in _POINTLESS:
                raise UnreadError(f"{letter} without a point, which counts in what the control does")
            given[str(_ARGUMENTS[letter])] = value
        return self._enter(at, self._program(number), times, given)

    def _arguments(self, text: str) -> dict[str, tuple[float | None, bool]]:
        """Values by their letters, and whether they are exact: with a point, or computed."""
        found: dict[str, tuple[float | None, bool]] = {}
        at = 0
        while at < len(text):
            letter = text[at]
            value, end = self._formulas.part(text, at + 1, single=True)
            if letter in found or not "A" <= letter <= "Z" or isinstance(value, bool):
                raise UnreadError(f"{text[:24]}, arguments")
            found[letter] = (value, bool(set(text[at + 1 : end]) & set(".#[")))
            at = end
        return found

    def _return(self, at: int, to: str | None) -> tuple[int, str]:
        """M99: to the block behind the call, to block P of the caller, or again; in the main program it is the end."""
        if not self._frames:
            if to:
                raise UnreadError(f"M99 P{to} in a main program")
            return -1, "M99"
        frame = self._frames[-1]
        if frame.times > 1:
            if to or (frame.local is not None and self._local != frame.given):
                raise UnreadError("a call that is repeated, and jumps or changes its arguments")
            self._frames[-1] = frame._replace(times=frame.times - 1)
            return frame.first, ""
        self._frames.pop()
        if frame.local is not None:
            self._local = frame.local
        return (frame.back + 1 if to is None else self._at_number(int(to), frame.back)), ""
