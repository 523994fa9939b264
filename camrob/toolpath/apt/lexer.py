"""APT-like text as logical statements: continuation joined, comments kept, every one with its first physical line."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError
from camrob.text import utf_16
from camrob.toolpath.apt.goto_kernel import ROWS, scan_gotos

__all__ = ["Lexer", "Rows", "Statement", "number_of"]

_LONGEST_LINE = 65_536  # bytes: no CAM system writes longer ones, and a file without line ends is no CL data
_LONGEST_STATEMENT = 1_000_000  # characters after joining
_TEXT_WORD = re.compile(r"\s*(PARTNO|PPRINT|REMARK|INSERT|TPRINT|LETTER)(?![A-Z0-9_=])[ \t]*/?(.*)", re.I | re.S)
_NUMBER = re.compile(r"[+-]?[ \t]*(?:\d+\.?\d*|\.\d+)(?:[ED][+-]?\d+)?", re.I | re.A)
_CONTROL = re.compile(rb"[\x00-\x06\x0e-\x19\x1b-\x1f\x7f]")


def number_of(token: str) -> float | None:
    """The value of a token that is an APT number (a blank after the sign and a D exponent are allowed), else None."""
    if not _NUMBER.fullmatch(token):
        return None
    value = float(token.replace(" ", "").replace("\t", "").upper().replace("D", "E"))
    return value if math.isfinite(value) else None


@dataclass(slots=True)
class Statement:
    """One statement: major `word` (upper case, single blanks), minor `text` as written, first physical `line`.

    A comment has the word "$$" and its text without the dollars.
    """

    word: str
    text: str
    line: int
    slash: bool = True
    _args: list[float | str] | None = field(default=None, repr=False)

    @property
    def args(self) -> list[float | str]:
        """The minor part at its commas: numbers as floats, words in upper case, empty fields as ""."""
        if self._args is None:
            self._args = []
            for token in self.text.split(",") if self.text.strip() else []:
                token = token.strip()
                value = number_of(token)
                self._args.append(token.upper() if value is None else value)
        return self._args

    @property
    def numbers(self) -> list[float]:
        """The numbers among the arguments, in their order."""
        return [a for a in self.args if isinstance(a, float)]

    @property
    def words(self) -> list[str]:
        """The words among the arguments, in their order."""
        return [a for a in self.args if isinstance(a, str) and a]


@dataclass(slots=True)
class Rows:
    """A run of GOTO: `values` (N, 6), `counts` (N,) of 3 or 6 numbers, `rapids` (N,), `lines` (N,)."""

    values: NDArray[np.float64]
    counts: NDArray[np.int8]
    rapids: NDArray[np.bool_]
    lines: NDArray[np.int64]

    def part(self, first: int, stop: int) -> Rows:
        """Rows `first` to `stop` (excluded)."""
        s = slice(first, stop)
        return Rows(self.values[s], self.counts[s], self.rapids[s], self.lines[s])


class Lexer:
    """Walks over the bytes of a file: `next` gives the next statement, `gotos` a whole run of plain ones at once.

    Raises ToolpathError for what is no text: empty, binary, or without line ends.
    """

    __slots__ = ("_array", "_counts", "_encoding", "_lines", "_rapids", "_same_line", "_values", "data", "line", "pos")

    def __init__(self, data: bytes) -> None:
        if data.startswith(b"\xef\xbb\xbf"):
            data = data[3:]
        if b"\r" in data[:_LONGEST_LINE] and b"\n" not in data:
            data = data.replace(b"\r", b"\n")
        _check_text(data)
        self.data = data
        self.pos = 0
        self.line = 1
        self._encoding = _encoding(data)
        self._same_line: list[Statement] = []  # behind a semicolon, and not given yet
        self._array = np.frombuffer(data, dtype=np.uint8)
        self._values = np.empty((ROWS, 6))
        self._counts = np.empty(ROWS, dtype=np.int8)
        self._rapids = np.empty(ROWS, dtype=np.bool_)
        self._lines = np.empty(ROWS, dtype=np.int64)

    def gotos(self, rapid: bool) -> tuple[Rows | None, bool]:
        """A run of plain GOTO and RAPID statements from here, None when there is none; and the RAPID still open."""
        if self._same_line:
            return None, rapid
        n, self.pos, self.line, rapid = scan_gotos(
            self._array, self.pos, self.line, rapid, self._values, self._counts, self._rapids, self._lines
        )
        if n == 0:
            return None, rapid
        return Rows(self._values[:n], self._counts[:n], self._rapids[:n], self._lines[:n]), rapid

    def next(self) -> Statement | None:
        """The next statement, or None at the end of the file."""
        if self._same_line:
            return self._same_line.pop(0)
        while self.pos < len(self.data):
            line = self.line
            text = self._physical_line()
            if text.strip():
                return self._statement(text, line)
        return None

    def _physical_line(self) -> str:
        """The line that starts here, without its end."""
        start = self.pos
        stop = self.data.find(b"\n", start, start + _LONGEST_LINE + 1)
        if stop < 0:
            if len(self.data) - start > _LONGEST_LINE:
                raise ToolpathError(
                    f"a line of more than {_LONGEST_LINE} bytes is not CL data",
                    hint="give the CL file itself, as text",
                    line=self.line,
                )
            stop = len(self.data)
        self.pos = stop + 1
        self.line += 1
        return self.data[start:stop].rstrip(b"\r\x1a").decode(self._encoding)

    def _statement(self, text: str, line: int) -> Statement:
        """The statement that begins with this physical line; the lines that continue it are taken in."""
        if text.lstrip().startswith("$$"):
            return self._comment(text.lstrip()[2:], line)
        verbatim = _TEXT_WORD.match(text)
        parts: list[str] = []
        size = 0
        while True:
            body, more = _cut(text, verbatim is not None)
            parts.append(body)
            size += len(body)
            if size > _LONGEST_STATEMENT:
                raise ToolpathError("a statement goes on over too many lines", hint="look for a stray $", line=line)
            if not more:
                break
            text = self._continued(line)
        joined = "".join(parts)
        if verbatim is not None or ";" not in joined:
            return _plain(joined, line)
        first, *others = [_plain(piece, line) for piece in _pieces(joined)] or [_plain("", line)]
        self._same_line = others
        return first

    def _continued(self, line: int) -> str:
        """The next physical line that is no comment; refused where the file ends instead."""
        while self.pos < len(self.data):
            text = self._physical_line()
            if not text.lstrip().startswith("$$"):
                return text
        raise ToolpathError(
            "the file ends in the middle of a statement", hint="it was cut off; get it again from the CAM", line=line
        )

    def _comment(self, text: str, line: int) -> Statement:
        """A comment; Creo's `$$->` statements go on over lines like others."""
        if not text.startswith("->"):
            return Statement("$$", text.rstrip(), line)
        parts: list[str] = []
        while True:
            body, more = _cut(text, False)
            parts.append(body)
            if not more or len(parts) > _LONGEST_LINE:
                return Statement("$$", "".join(parts).rstrip(), line)
            text = self._continued(line)


def _plain(text: str, line: int) -> Statement:
    """A statement without continuation and comment."""
    verbatim = _TEXT_WORD.match(text)
    if verbatim is not None:
        return Statement(verbatim[1].upper(), verbatim[2].rstrip(), line)
    word, slash, minor = text.partition("/")
    return Statement(" ".join(word.upper().split()), minor, line, bool(slash))


def _pieces(text: str) -> list[str]:
    """The statements that semicolons part; those in quotes part nothing, nor do those of a free text."""
    pieces = [""]
    quoted = False
    for n, c in enumerate(text):
        quoted ^= c == "'"
        if c == ";" and not quoted:
            pieces.append("")
            if _TEXT_WORD.match(text, n + 1):
                pieces[-1] = text[n + 1 :]
                break
        else:
            pieces[-1] += c
    return [piece for piece in pieces if piece.strip()]


def _cut(text: str, verbatim: bool) -> tuple[str, bool]:
    """A physical line without its comment, and whether a lone dollar says that the next line goes on with it."""
    if "$" not in text:
        return text, False
    if verbatim:
        bare = text.rstrip()
        return (bare[:-1], True) if bare.endswith("$") and not bare.endswith("$$") else (text, False)
    quoted = False
    for n, c in enumerate(text):
        if c == "'":
            quoted = not quoted
        elif c == "$" and not quoted:
            return text[:n], text[n + 1 : n + 2] != "$"
    return text, False


def _check_text(data: bytes) -> None:
    """Refuse what is no text at all, from a look at its first bytes."""
    head = data[:_LONGEST_LINE]
    if not head.strip():
        raise ToolpathError("the file is empty", hint="write the CL data again from the CAM system")
    if utf_16(head):
        raise ToolpathError("the file is in UTF-16", hint="save it as plain text (ASCII or UTF-8)")
    if b"\x00" in head or len(_CONTROL.findall(head)) > 8 + len(head) // 100:
        raise ToolpathError("the file is binary, not text", hint="write the CL data as text (APT), not in binary form")


def _encoding(data: bytes) -> str:
    """UTF-8 where the bytes are, Latin-1 otherwise (which takes any bytes)."""
    if data.isascii():
        return "ascii"
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8"
