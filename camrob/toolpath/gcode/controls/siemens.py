"""Siemens 840D (Sinumerik): R parameters, named variables, jumps and loops, X=..., A3 B3 C3, TRAORI, CYCLE800, SUPA.

Siemens, "Programming Manual Fundamentals" and "Job planning" (840D sl, 4.8); CYCLE800's parameters: "Job planning", 20.4.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.controls.control import Control, State
from camrob.toolpath.gcode.controls.siemens_sections import Sections, wanted_programs
from camrob.toolpath.gcode.controls.siemens_words import SiemensWords
from camrob.toolpath.gcode.language.flow import DEEPEST, StepCount, unset
from camrob.toolpath.gcode.language.formulas import NOTHING, Reader, Value, whole
from camrob.toolpath.gcode.lexer import Block

__all__ = ["SIEMENS"]

_MARKS = tuple(
    re.compile(pattern, re.M)
    for pattern in (
        r"\b(?:TRAORI|TRAFOOF|CYCLE8[0-9]{1,2}|ORIWKS|ORIMKS|ORIVECT|ORIAXES|SUPA|COMPCAD|COMPOF|FFWON|G64[0-5]|G7[01]0|STOPRE|MCALL)\b",
        r"^%_N_|^;\$PATH=|^[ \t]*(?:N[0-9]+[ \t]*)?(?:PROC|EXTERN|CASE)\b",
        r"^[ \t]*(?:N[0-9]+[ \t]*)?[A-Z]{2,}_[A-Z0-9_]+[ \t]*$",  # a subprogram's name: ISO's words have no underscore
        r"\bMSG[ \t]*\(",
        r"\bA?(?:TRANS|ROT|MIRROR|SCALE)[ \t]+[XYZ]|\b(?:RND|CH[RF]|AP|RP)[ \t]*=|^[ \t]*(?:N[0-9]+[ \t]+)?REPEATB?[ \t]+[A-Z_]",
        r"\b(?:POCKET[0-9]?|LONGHOLE|SLOT[12]|HOLES[12]|CIP|WORKPIECE|CYCLE[67][0-9])\b",
        r"^[ \t]*(?:N[0-9]+[ \t]+)?(?:DEF[ \t]+(?:REAL|INT)|R[0-9]+[ \t]*=|GOTO[FB][ \t]|A3[ \t]*=)",
        r"\b(?:[XYZABC]|A3|B3|C3|CR|TURN)[ \t]*=[ \t]*[-+(0-9R]|\bT[ \t]*=[ \t]*\"",
    )
)
_REMARK = re.compile(r"\"[^\"]*\"|;.*")  # a text in quotes may hold a semicolon
_LABEL = re.compile(r"([A-Z_][A-Z0-9_]+):(?!=)")
_JUMP = re.compile(r"(?:IF(.*?))? ?(GOTOF|GOTOB|GOTOC|GOTO) ?([A-Z_][A-Z0-9_]*|[0-9]+)$")
_SET = re.compile(r"(R[0-9]+|R\(.*?\)|[A-Z_][A-Z0-9_]*)=(?!=)(.*)$")
_FOR = re.compile(r"FOR (\w+)=(.*?) ?TO ?(.*)$")
_REPEAT = re.compile(r"REPEAT ([A-Z_][A-Z0-9_]*)(?: ([A-Z_][A-Z0-9_]*))?(?: P=?(.+))?")
_BACK = re.compile(r"\b(?:M0*17(?![0-9.])|RET\b)")
_MOST_REPEATS = 9_999  # P has four digits
_OPENS = {"ENDIF": "IF", "ENDWHILE": "WHILE", "ENDFOR": "FOR", "ENDLOOP": "LOOP", "UNTIL": "REPEAT"}
_ADDRESSES = frozenset(
    "X Y Z A B C I J K F S T D A3 B3 C3 CR TURN AP RP AR RND RNDM CHF CHR A2 B2 C2 A4 B4 C4 A5 B5 C5 LEAD TILT OFFN FA FRC "
    "I1 J1 K1 S1 M1 S2 M2 U V W E H P L N G M ANG PW SD AX H1 THETA MEAS SPOS DL TOFFL CTOL OTOL FGREF ADIS ADISPOS".split()
)


class _Program:
    """One file that is being run."""

    def __init__(self, lines: list[str], path: Path, state: State) -> None:
        self._path = path
        self._count = StepCount()
        self._values: dict[str, float] = {}
        self._declared: set[str] = set()
        self._words = SiemensWords(self.reader, state)
        self._texts: list[str] = []
        self._labels: list[tuple[str, int]] = []
        self._comments: list[str] = []
        for raw in lines:
            text, label, comment = _split(raw)
            self._texts.append(text)
            self._comments.append(comment)
            if label:
                self._labels.append((label, len(self._texts) - 1))
            number = re.match(r"\s*/?[0-9]?\s*(N[0-9]+)", raw, re.I)
            if number:
                self._labels.append((number[1].upper(), len(self._texts) - 1))
        self._optional = [raw.lstrip().startswith("/") for raw in lines]
        self._ends: dict[int, int] = {}
        self._begins: dict[int, int] = {}
        self._else: dict[int, int] = {}
        self._sections = Sections(self._texts)
        self._structure()
        self._tools(lines)
        self._at = self._sections.main
        self._repeats: list[tuple[int, int, int, int]] = []  # first and last line of a part, passes left, and back
        # of each subprogram that is being run: what the names that it has declared hold outside of it
        self._outer: list[dict[str, float | None]] = []

    def _tools(self, lines: list[str]) -> None:
        """Whether tools are named by one name only: it is then the one that the set-up describes."""
        names = {
            name.upper() for raw in lines for name in re.findall(r'\bT\s*=\s*"([^"]*)"', raw.partition(";")[0], re.I)
        }
        strange = not any(name.isdigit() or self._words.number_of(name) for name in names)
        self._words.one_name = len(names) == 1 and strange

    def _structure(self) -> None:
        opened: list[tuple[str, int]] = []
        for index, text in enumerate(self._texts):
            word = _keyword(text)
            if word in ("WHILE", "FOR", "LOOP", "REPEAT") or (word == "IF" and not _JUMP.match(text)):
                if word == "REPEAT" and text != "REPEAT":
                    continue  # refused where it is run: a part between labels
                opened.append((word, index))
            elif word == "ELSE" and opened and opened[-1][0] == "IF":
                self._else[opened[-1][1]] = index
            elif word in _OPENS:
                if not opened or opened[-1][0] != _OPENS[word]:
                    raise ToolpathError(
                        f"{word} without its {_OPENS[word]}", hint="check the loops", path=self._path, line=index + 1
                    )
                begin = opened.pop()[1]
                self._ends[begin], self._begins[index] = index, begin
        if opened:
            word, index = opened[-1]
            raise ToolpathError(f"{word} without its end", hint="close it", path=self._path, line=index + 1)

    # -- running -----------------------------------------------------------------------------------------------

    def run(self) -> Iterator[Block]:
        """The blocks, one after the other."""
        while self._at < len(self._texts):
            index = self._at
            if self._repeated(index):
                continue
            text = self._texts[index]
            self._at += 1
            try:
                if self._comments[index]:
                    yield Block(index + 1, {}, comment=self._comments[index])
                if text:
                    self._count.one(index + 1)
                    yield from self._one(text, index)
            except ToolpathError as error:
                raise error.at(self._path, index + 1) from None

    def _one(self, text: str, index: int) -> Iterator[Block]:
        word = _keyword(text)
        if text.startswith("%_N_") and index != self._sections.main:
            yield from self._end(index)
        elif re.match(r"PROC \w+\(.", text) and not self._sections.called:
            raise ToolpathError(
                "a subprogram that is called with values (PROC), which only its caller has",
                hint="give the program that calls it, with this one behind it",
            )
        elif text.startswith(("%_N_", "PROC")) or re.fullmatch(r"%\w*", text):
            if index and self._words.moved and not self._sections.called:
                raise ToolpathError("a further program in the same file", hint="give each program a file of its own")
        elif self._sections.called and _BACK.search(text):
            if rest := _BACK.sub("", text).strip():
                yield from self._one(rest, index)
            self._back()
        elif place := self._sections.call(text, self._at):
            self._at = place
            self._outer.append({})
        elif word == "REPEAT" and text != "REPEAT":
            self._repeat(text)
        elif match := _JUMP.match(text):
            if match[1] is None or self.true(match[1]):
                self._go_to(match[3], match[2])
        elif word in (
            "IF",
            "ELSE",
            "ENDIF",
            "WHILE",
            "ENDWHILE",
            "FOR",
            "ENDFOR",
            "LOOP",
            "ENDLOOP",
            "REPEAT",
            "UNTIL",
        ):
            self._flow(word, text, index)
        elif text.startswith("DEF") and re.match(r"DEF (?:REAL|INT|BOOL)\b", text):
            self._declare(re.sub(r"DEF (?:REAL|INT|BOOL) ", "", text))
        elif (match := _SET.match(text)) and self._is_variable(match[1]):
            reader = self.reader(match[2])
            value = reader.expression()
            if value is None or (reader.rest and not reader.rest.startswith(" ")):
                raise reader.fail()
            self._store(match[1], value)
            if reader.rest:  # a further one behind it
                yield from self._one(reader.rest.strip(), index)
        else:
            yield from self._words.blocks(text, index + 1, optional=self._optional[index])

    def _flow(self, word: str, text: str, index: int) -> None:
        if word == "IF":
            if not self.true(text[2:]):
                self._at = self._else.get(index, self._ends[index]) + 1
        elif word == "ELSE":
            self._at = self._ends[next(begin for begin, at in self._else.items() if at == index)] + 1
        elif word == "WHILE":
            if not self.true(text[5:]):
                self._at = self._ends[index] + 1
        elif word in ("ENDWHILE", "ENDLOOP"):
            self._at = self._begins[index]
        elif word == "UNTIL":
            if not self.true(text[5:]):
                self._at = self._begins[index] + 1
        elif word in ("FOR", "ENDFOR"):
            self._for(word, index)

    def _end(self, index: int) -> Iterator[Block]:
        """The heading of another program, which the one before it runs into: its end."""
        if self._sections.called:
            self._back()
            return
        yield Block(index + 1, {}, m=(300,))

    def _back(self) -> None:
        """A subprogram ends: the names that it has declared are what they were outside of it."""
        deep = self._sections.depth
        self._at = self._sections.back()
        for name, value in self._outer[-1].items():
            if value is None:
                self._declared.discard(name)
                self._values.pop(name, None)
            else:
                self._values[name] = value
        self._outer[-1] = {}
        if self._sections.depth < deep:
            self._outer.pop()

    def _repeat(self, text: str) -> None:
        """REPEAT LABEL [P=n]: from the label to here once more, or n times; REPEAT FIRST LAST [P=n]: what stands between them."""
        match = _REPEAT.fullmatch(text)
        if match is None:
            raise ToolpathError(f"{text[:24]} can't be read", hint="REPEAT LABEL or REPEAT FIRST LAST, with P=n")
        here = self._at - 1
        low, high = self._sections.bounds
        places = {name: at for name, at in self._labels if low <= at < high}
        missing = [name for name in (match[1], match[2]) if name and name not in places]
        if missing:
            raise ToolpathError(f"{missing[0]} is repeated, and there is no such label", hint="check the label")
        first, last = places[match[1]], places[match[2]] if match[2] else here - 1
        times = 1 if match[3] is None else whole(self.value(match[3]), "P")
        if first > last or first <= here <= last or not 1 <= times <= _MOST_REPEATS:
            raise ToolpathError(f"{text[:24]} of a part that holds itself, or too often", hint="unroll the loop")
        if len(self._repeats) > DEEPEST:
            raise ToolpathError(f"REPEAT nested more than {DEEPEST} deep", hint="unroll the loops")
        self._repeats.append((first, last, times - 1, self._at))
        self._at = first

    def _repeated(self, index: int) -> bool:
        """Whether a part that is being repeated ends before this line; it begins anew, or goes on behind its REPEAT."""
        if not self._repeats or index != self._repeats[-1][1] + 1:
            return False
        first, last, left, back = self._repeats.pop()
        if left:
            self._repeats.append((first, last, left - 1, back))
        self._at = first if left else back
        return True

    def _for(self, word: str, index: int) -> None:
        begin = index if word == "FOR" else self._begins[index]
        match = _FOR.match(self._texts[begin])
        if match is None:
            raise ToolpathError("a FOR that can't be read", hint="FOR variable = start TO end")
        count = self.value(match[2]) if word == "FOR" else self._values[match[1]] + 1.0
        self._store(match[1], count)
        self._at = begin + 1 if count <= self.value(match[3]) else self._ends[begin] + 1

    def _go_to(self, label: str, how: str) -> None:
        label = f"N{label}" if label.isdigit() else label
        here = self._at - 1
        low, high = self._sections.bounds
        places = [at for name, at in self._labels if name == label and low <= at < high]
        ahead, behind = [p for p in places if p > here], [p for p in places if p <= here]
        found = ahead if how == "GOTOF" else behind[::-1] if how == "GOTOB" else ahead or behind
        if not found:
            raise ToolpathError(f"{label} is jumped to by {how}, and it is not there", hint="check the label")
        self._at = found[0]

    # -- values ------------------------------------------------------------------------------------------------

    def _declare(self, text: str) -> None:
        for part in text.split(","):
            name, _, value = part.partition("=")
            if "[" in name:
                raise ToolpathError("an array of variables", hint="use single variables or R parameters")
            if self._outer:
                self._outer[-1].setdefault(name, self._values[name] if name in self._declared else None)
            self._declared.add(name)
            self._values[name] = self.value(value) if value else 0.0  # DEF gives 0, as the control does

    def _is_variable(self, name: str) -> bool:
        if re.fullmatch(r"R[0-9]+|R\(.*\)", name):
            return True
        if name.startswith("$"):
            return False
        return name in self._declared or name not in _ADDRESSES

    def _store(self, name: str, value: float) -> None:
        if name.startswith("R("):
            name = f"R{whole(self.value(name[2:-1]), 'R')}"
        if not re.fullmatch(r"R[0-9]+", name) and name not in self._declared:
            raise ToolpathError(f"{name} is set, which the program has not declared", hint="DEF REAL before it")
        self._values[name] = value

    def reader(self, text: str) -> Reader:
        """A reader of expressions."""
        return Reader(text, self._words.grammar, self._variable)

    def value(self, text: str) -> float:
        """The value of a whole expression."""
        reader = self.reader(text.strip())
        value = reader.expression()
        if reader.rest or value is None:
            raise reader.fail()
        return value

    def true(self, text: str) -> bool:
        """Whether a condition holds."""
        return bool(self.value(text))

    def _variable(self, reader: Reader) -> Value:
        match = re.match(r"\$[A-Z_]+|R[0-9]+|[A-Z_][A-Z0-9_]*", reader.rest)
        if match is None:
            return NOTHING
        name = match[0]
        if name.startswith("$"):
            raise ToolpathError(
                f"{name} is read, a system variable: what it holds is the machine's state",
                hint="have the path written out as plain blocks",
            )
        if name in reader.grammar.functions:
            return NOTHING
        if name not in self._values:
            raise unset(name)
        reader.at += len(name)
        return self._values[name]


def _split(raw: str) -> tuple[str, str, str]:
    """A line without blanks outside of strings: its text without N word and label, the label, the comment."""
    cut = next((match.start() for match in _REMARK.finditer(raw) if match[0][0] == ";"), len(raw))
    code, comment = raw[:cut], raw[cut + 1 :]
    message = re.match(r"\s*(?:N[0-9]+\s*)?MSG\s*\((.*)\)\s*$", code, re.I)
    if message:
        return "", "", "MSG," + message[1].strip().strip('"')
    parts = re.split(r'("[^"]*")', code)
    text = "".join(part if i % 2 else _tight(part) for i, part in enumerate(parts)).strip()
    text = re.sub(r"^/[0-9]? ?", "", text)
    text = re.sub(r"^[N:][0-9]+ ?", "", text)
    match = _LABEL.match(text)
    return (text[match.end() :].strip(), match[1], comment.strip()) if match else (text, "", comment.strip())


def _tight(part: str) -> str:
    """Upper case, blanks only where they part two words, and a sign for each operator that is a word."""
    part = re.sub(r"\s+", " ", part.upper())
    for word, sign in (("AND", "&"), ("OR", "|"), ("XOR", "~"), ("DIV", "!"), ("MOD", "%")):
        part = re.sub(rf"(?<=[ )0-9]){word}(?=[ (])", sign, part)
    part = re.sub(r" ?([-=+*/(),<>&|~!%]) ?", r"\1", part)
    return re.sub(r"\)(?=[A-Z])", ") ", part)


def _keyword(text: str) -> str:
    """The word of flow that a text begins with."""
    match = re.match(r"(?:ENDWHILE|ENDLOOP|ENDFOR|ENDIF|WHILE|LOOP|FOR|ELSE|IF|REPEAT|UNTIL)(?![A-Z0-9_])", text)
    return match[0] if match else ""


def _recognise(text: str) -> int:
    """More than ISO and LinuxCNC where two kinds of its own words stand."""
    return 5 if sum(bool(mark.search(text)) for mark in _MARKS) >= 1 else 0


SIEMENS = Control(
    "siemens",
    "Siemens 840D",
    _recognise,
    lambda lines, path, state: _Program(lines, path, state).run(),
    "gcode-siemens",
    edges=True,
    metric=True,
    suffixes=frozenset({".mpf", ".spf"}),
    wanted=wanted_programs,
)
