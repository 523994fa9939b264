"""Siemens' control structures, jumps, repeats and subprograms ("Job planning", 840D sl, 1.9 to 1.26).

IF ELSE ENDIF, WHILE, FOR, LOOP, REPEAT UNTIL; GOTOF and GOTOB to labels and block numbers; REPEAT and REPEATB of labelled
sections; subprograms behind %_N_NAME_SPF in the same file, whose declared names are their own.
"""

from __future__ import annotations

import re
from typing import NamedTuple, Protocol

from camrob.witness.cl.running.ordered import Ordered, Row, less
from camrob.witness.cl.running.unread import NOWHERE, UnreadError

__all__ = ["StructureRun"]

_HEAD = re.compile(r"%_N_(\w+)_(MPF|SPF)")
_PROC = re.compile(r"PROC (\w+)(?: ?\( ?\))?(?: (?:DISPLOF|SBLOF))*")
_LABEL = re.compile(r"([A-Z_][A-Z_]\w*) ?:(?!=) ?")
_TARGET = r"([A-Z_]\w*)"
_IF_GOTO = re.compile(rf"IF\b ?(.+?) ?(GOTO[FB]?) {_TARGET}")
_GOTO = re.compile(rf"(GOTO[FB]?) {_TARGET}")
_FOR = re.compile(r"FOR (\w+) ?= ?(.+?) TO (.+)")
_AGAIN = re.compile(rf"(REPEATB?) {_TARGET}(?: ([A-Z_][A-Z_]\w*))?(?: P ?= ?(\d+))?")
_CALL = re.compile(r"([A-Z_]\w+)(?: ?\( ?\))?(?: P ?=? ?(\d+))?")
_WORD = re.compile(r"(IF|ELSE|ENDIF|WHILE|ENDWHILE|FOR|ENDFOR|LOOP|ENDLOOP|REPEAT|UNTIL)\b")
_CLOSES = {"ENDIF": "IF", "ENDWHILE": "WHILE", "ENDFOR": "FOR", "ENDLOOP": "LOOP", "UNTIL": "REPEAT"}
_SIGN = re.compile(r"==|<>|<=|>=|<|>")
_DEEPEST = 20  # brackets in one another
_NESTED = 8  # subprograms in one another: controls take eleven and more


class _Holder(Protocol):
    """What holds the values of names."""

    def of(self, text: str) -> float: ...
    def put(self, name: str, value: float) -> None: ...
    def forget(self, name: str) -> None: ...
    def __contains__(self, name: str) -> bool: ...
    def enter(self) -> dict[str, float]: ...
    def leave(self, before: dict[str, float]) -> None: ...


class _Frame(NamedTuple):
    back: int
    first: int
    last: int
    times: int
    names: dict[str, float]


class _Again(NamedTuple):
    """A section that is run again: up to `after`, then on at `back`; deep: the calls that it stands in."""

    first: int
    after: int
    left: int
    back: int
    deep: int


class StructureRun(Ordered):
    """rows: without comments and N numbers' blanks, upper case, one blank between words."""

    def __init__(self, rows: list[Row], held: _Holder) -> None:
        self._numbers: dict[tuple[int, str], int] = {}  # by the program's first row and name: the row, -1 for several
        super().__init__(rows)
        self._values = held
        self._frames: list[_Frame] = []
        self._again: list[_Again] = []
        self._segments: list[tuple[int, int]] = []
        self._named: dict[str, int] = {}
        self._next: dict[int, int] = {}
        self._last: dict[int, int] = {}
        self._ends: dict[int, float] = {}  # of a for, by its head

    # -- what stands where

    def _start(self) -> int:
        heads = [i for i, (_, row) in enumerate(self.rows) if _HEAD.fullmatch(row)]
        edges = sorted({0, *heads, len(self.rows)})
        self._segments = [(first, last) for first, last in zip(edges, [*edges[1:], 0], strict=True) if last]
        mains = []
        for segment in self._segments:
            head = _HEAD.fullmatch(self.rows[segment[0]][1])
            if head is None or head[2] == "MPF":
                mains.append(segment)
            else:
                self._named[head[1]] = -1 if head[1] in self._named else segment[0]
            self._find(*segment)
        self._main = (mains or self._segments or [(0, 0)])[0]
        return self._main[0]

    def _find(self, first: int, last: int) -> None:
        """Names of rows, and what belongs together; a row that belongs nowhere is left out, and ends what is read."""
        opened: list[tuple[str, list[int]]] = []
        for i in range(first, last):
            line, row = self.rows[i]
            for name in (re.match(r"(N\d+)", row), _LABEL.match(re.sub(r"^N\d+ ?", "", row))):
                if name:
                    key = (first, _plain(name[1]))
                    self._numbers[key] = -1 if key in self._numbers else i
            row = self._bare(row)
            word = _WORD.match(row)
            if word is None or _IF_GOTO.fullmatch(row) or (word[1] == "REPEAT" and row != "REPEAT"):
                continue
            if word[1] in ("IF", "WHILE", "FOR", "LOOP", "REPEAT"):
                opened.append((word[1], [i]))
            elif word[1] == "ELSE" and opened and opened[-1][0] == "IF":
                opened[-1][1].append(i)
            elif opened and _CLOSES.get(word[1]) == opened[-1][0]:
                places = [*opened.pop()[1], i]
                for place, after in zip(places, [*places[1:], places[0]], strict=True):
                    self._next[place], self._last[place] = after, i
            else:
                self.line = line
                raise UnreadError(f"{word[1]} without its beginning")

    @staticmethod
    def _bare(row: str) -> str:
        row = re.sub(r"^[N:]\d+ ?", "", row)
        return row[found.end() :] if (found := _LABEL.match(row)) else row

    def _segment(self) -> tuple[int, int]:
        if not self._frames:
            return self._main
        return self._frames[-1].first, self._frames[-1].last

    def _called(self) -> bool:
        return bool(self._frames or self._again)

    # -- statements

    def _step(self, at: int, row: str) -> tuple[int, str]:
        if self._again and self._again[-1].deep == len(self._frames) and at == self._again[-1].after:
            again = self._again.pop()
            if again.left > 1:
                self._again.append(again._replace(left=again.left - 1))
                return again.first, ""
            return again.back, ""
        first, last = self._segment()
        if not first <= at < last:
            raise UnreadError("another program in the same file, or a subprogram without M17")
        if _HEAD.fullmatch(row):
            return at + 1, ("" if self._frames else row)
        body = self._bare(row)
        if not body:
            return at + 1, ""
        if row.startswith("/"):
            skipped = re.sub(r"^/\d? ?", "", row)
            if _WORD.match(self._bare(skipped)) or "GOTO" in skipped or ":" in skipped:
                raise UnreadError(f"{row[:24]}, a block that may be skipped")
            return at + 1, row
        if self._frames and (body in ("M17", "RET")):
            return self._return(), ""
        if self._frames and (_PROC.fullmatch(body)):
            return at + 1, ""
        if self._frames and re.search(r"\bM ?0*(17|2|30)\b|\bRET\b|\bPROC\b", body):
            raise UnreadError(f"{body[:24]}, in a subprogram")
        if (target := self._flow(at, body)) is not None:
            return target, ""
        if (call := _CALL.fullmatch(body)) and call[1] in self._named:
            return self._call(at, call), ""
        return at + 1, body

    def _flow(self, at: int, body: str) -> int | None:
        if found := _IF_GOTO.fullmatch(body):
            return self._to(at, found[2], found[3]) if self._truth(found[1]) else at + 1
        if found := _GOTO.fullmatch(body):
            return self._to(at, found[1], found[2])
        if "GOTO" in body:
            raise UnreadError(f"{body[:24]}, a jump")
        if found := _AGAIN.fullmatch(body):
            return self._repeat(at, found)
        word = _WORD.match(body)
        if word is None:
            return None
        if at not in self._last:
            raise UnreadError(f"{word[1]} without its end")
        rest, after = body[word.end() :].strip(), self._last[at] + 1
        if word[1] in ("IF", "WHILE"):
            if self._truth(rest):
                return at + 1
            return self._next[at] + 1
        if word[1] == "UNTIL":
            return at + 1 if self._truth(rest) else self._next[at] + 1
        if word[1] == "FOR":
            return self._for(at, body)
        if rest:
            raise UnreadError(f"{body[:24]}, words beside a structure")
        if word[1] == "ENDFOR":
            return self._for(self._next[at], self._bare(self.rows[self._next[at]][1]), again=True)
        if word[1] in ("ENDWHILE", "ENDLOOP"):
            return self._next[at]
        return after if word[1] == "ELSE" else at + 1

    def _for(self, at: int, body: str, *, again: bool = False) -> int:
        """FOR counts up by one as long as the end isn't passed; what the name holds behind it isn't known."""
        found = _FOR.fullmatch(body)
        if found is None or not (found[1] in self._values or re.fullmatch(r"R\d+", found[1])):
            raise UnreadError(f"{body[:24]}, a loop")
        name, end = found[1], self._values.of(found[3])
        value = self._values.of(name) + 1.0 if again else self._values.of(found[2])
        if again and end != self._ends[at]:
            raise UnreadError(f"{body[:24]}, whose end has moved")
        self._ends[at] = end
        self._values.put(name, value)
        if less(value, end) <= 0.0:
            return at + 1
        self._values.forget(name)
        return self._last[at] + 1

    # -- conditions

    def _truth(self, text: str, deep: int = 0) -> bool:
        """A comparison, or several in brackets with AND or OR between them."""
        if deep > _DEEPEST:
            raise UnreadError(f"{text[:24]}, brackets too deep")
        parts, signs = _split(text)
        if signs:
            if len(set(signs)) > 1 or not all(_enclosed(part) for part in parts):
                raise UnreadError(f"{text[:24]}, a condition")
            held = [self._truth(part, deep + 1) for part in parts]
            return all(held) if signs[0] == "AND" else any(held)
        text = parts[0]
        if _enclosed(text):
            return self._truth(text[1:-1], deep + 1)
        found = _SIGN.findall(text)
        if len(found) != 1:
            raise UnreadError(f"{text[:24]}, a condition")
        left, right = text.split(found[0])
        off = less(self._values.of(left), self._values.of(right))
        return {"==": off == 0, "<>": off != 0, "<": off < 0, ">": off > 0, "<=": off <= 0, ">=": off >= 0}[found[0]]

    # -- jumps, repeats, calls

    def _place(self, name: str) -> int:
        found = self._numbers.get((self._segment()[0], _plain(name)))
        if found is None and not re.match(r"N\d+$|[A-Z_]{2}", name):
            raise UnreadError(f"{name}, which is no label")
        if found is None:
            raise UnreadError(f"{name}: {NOWHERE}")
        if found < 0:
            raise UnreadError(f"{name}, more than once")
        return found

    def _to(self, at: int, way: str, name: str) -> int:
        target = self._place(name)
        if (way == "GOTOF" and target <= at) or (way == "GOTOB" and target > at):
            raise UnreadError(f"{way} {name}, which stands on the other side")
        for head, end in self._last.items():
            if head < target <= end and not head <= at <= end:
                raise UnreadError(f"{name}, a jump into a structure")
        again = self._again[-1] if self._again else None
        if again and again.deep == len(self._frames) and not again.first <= target < again.after:
            raise UnreadError(f"{name}, a jump out of a repeat")
        return target

    def _repeat(self, at: int, found: re.Match[str]) -> int:
        """REPEATB of one block; REPEAT of what stands between two labels, or between one and itself."""
        first, last = self._segment()
        if any(re.search(r"\bENDLABEL\b", self.rows[i][1]) for i in range(first, last)) or len(self._again) > _NESTED:
            raise UnreadError("a repeat up to ENDLABEL, or nested too deep")
        begin, times = self._place(found[2]), int(found[4] or "1")
        after = begin + 1 if found[1] == "REPEATB" else at
        if found[3]:
            after = self._place(found[3]) + 1
        if not begin < after or begin <= at < after or times < 1 or (found[1] == "REPEATB" and found[3]):
            raise UnreadError(f"REPEAT {found[2]}, of nothing, or of itself")
        self._again.append(_Again(begin, after, times, at + 1, len(self._frames)))
        return begin

    def _call(self, at: int, call: re.Match[str]) -> int:
        first, times = self._named[call[1]], int(call[2] or "1")
        if first < 0 or times < 1 or len(self._frames) >= _NESTED:
            raise UnreadError(f"{call[1]}, which stands there more than once, or nested too deep")
        last = next(s[1] for s in self._segments if s[0] == first)
        self._frames.append(_Frame(at, first, last, times, self._values.enter()))
        return first

    def _return(self) -> int:
        frame = self._frames[-1]
        if any(again.deep == len(self._frames) for again in self._again):
            raise UnreadError("an end of a subprogram in a repeat")
        self._values.leave(frame.names)
        if frame.times > 1:
            self._frames[-1] = frame._replace(times=frame.times - 1, names=self._values.enter())
            return frame.first
        self._frames.pop()
        return frame.back + 1


def _plain(name: str) -> str:
    """A block number without leading zeros; a label as it is."""
    return f"N{int(name[1:])}" if re.fullmatch(r"N\d+", name) else name


def _enclosed(text: str) -> bool:
    """Whether one pair of brackets stands round all of a text."""
    deep = 0
    for i, letter in enumerate(text):
        deep += (letter == "(") - (letter == ")")
        if deep == 0:
            return i > 0 and i == len(text) - 1
    return False


def _split(text: str) -> tuple[list[str], list[str]]:
    """The parts of a condition between the AND and OR that stand in no brackets, and those words."""
    parts, signs, deep = [""], list[str](), 0
    for token in re.findall(r"[()]|\bAND\b|\bOR\b|.", text.strip()):
        deep += (token == "(") - (token == ")")
        if deep == 0 and token in ("AND", "OR"):
            signs.append(token)
            parts.append("")
        else:
            parts[-1] += token
    return [part.strip() for part in parts], signs
