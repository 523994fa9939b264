"""The text of a CL file: its lines, its statements, and the runs of plain GOTO lines that make up most of it."""

from __future__ import annotations

import math
import re
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError

__all__ = ["COMMENT", "Run", "Source", "Statement", "number", "read_text", "tape"]

COMMENT = re.compile(r"\([^)]*\)?|;.*")  # of G-code

_FREE = re.compile(r"\s*(PARTNO|PPRINT|REMARK|INSERT|TPRINT|LETTER)\b", re.I)
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[DE][-+]?\d+)?", re.I)
_NUMBERS_ONLY = re.compile(r"[-+.\d\sEe,$]*\$?\s*")
_DEFINITION = re.compile(r"\s*\w+\s*=")

_CONTROL = bytes([*range(9), *range(14, 32)])  # characters that no text holds

# what a character adds to the sum of its line: a plain GOTO has 4 letters, 1 slash, 2 or 5 commas and nothing else
_LETTER, _SLASH, _COMMA, _OTHER = 1, 1 << 8, 1 << 14, 1 << 22
_THREE, _SIX = 4 * _LETTER + _SLASH + 2 * _COMMA, 4 * _LETTER + _SLASH + 5 * _COMMA
_BLOCK = 1 << 22  # characters classified at a time, so that a large file takes little memory


def _weights() -> NDArray[np.int32]:
    weights = np.full(256, _OTHER, np.int32)
    for characters, weight in (("0123456789+-.eE \t\n", 0), ("GOTgot", _LETTER), ("/", _SLASH), (",", _COMMA)):
        weights[[ord(c) for c in characters]] = weight
    return weights


_WEIGHTS = _weights()
_TO_NUMBERS = str.maketrans("GOTgot/\n", "       ,")


def number(field: str) -> float | None:
    """The number that a field holds, or None."""
    value = float(field.upper().replace("D", "E")) if _NUMBER.fullmatch(field) else math.nan
    return value if math.isfinite(value) else None


def read_text(path: Path) -> str:
    """The file's text with plain line ends, UTF-8 or Latin-1. Raises ToolpathError where it is no text."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise ToolpathError(f"can't be read: {error.strerror or error}", hint="name a CL file", path=path) from error
    data = data.strip(b"\0").rstrip(b"\x1a\r\n\t \0")  # tapes and DNC fill up with zeros
    if not data:
        raise ToolpathError("the file is empty", hint="post it again from the CAM system", path=path)
    if len(data.translate(None, _CONTROL)) != len(data):
        raise ToolpathError("binary, not text", hint="have the CAM system write the CL data as text", path=path)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    return text.replace("\r\n", "\n").replace("\r", "\n") + "\n"


@dataclass(frozen=True, slots=True)
class Statement:
    """One statement of APT text, continuation lines joined. major: upper case, "$$" for a comment; rest: behind the slash."""

    major: str
    rest: str
    line: int
    last: int

    @property
    def fields(self) -> list[str]:
        """What stands between the commas, upper case, trailing commas aside."""
        fields = [f.strip().upper() for f in self.rest.split(",")]
        while fields and not fields[-1]:
            fields.pop()
        return fields

    @property
    def numbers(self) -> list[float]:
        """The numbers among the fields."""
        return [value for value in map(number, self.fields) if value is not None]

    @property
    def words(self) -> list[str]:
        """The fields that are no numbers."""
        return [f for f in self.fields if f and number(f) is None]


@dataclass(frozen=True, slots=True)
class Run:
    """Plain GOTO lines in a row, as printed. points: (N, 3); axes: (N, 3), NaN until one is printed; line: of the first."""

    points: NDArray[np.float64]
    axes: NDArray[np.float64]
    line: int


class _Lines:
    """The lines of a text, each cut out when it is asked for: most of a long file is read as columns."""

    def __init__(self, text: str, starts: NDArray[np.int64]) -> None:
        self._text, self._starts = text, starts

    def __len__(self) -> int:
        return len(self._starts)

    def __getitem__(self, k: int) -> str:
        stop = self._starts[k + 1] if k + 1 < len(self._starts) else len(self._text)
        return self._text[self._starts[k] : stop - 1]

    def stretch(self, first: int, stop: int) -> str:
        """Lines first to stop - 1 with their ends."""
        return "".join(f"{self[k]}\n" for k in range(first, stop))


class Source:
    """Reads the lines of APT text one statement, or one run of GOTO lines, at a time."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.at = 0  # index of the next line
        self._behind: list[Statement] = []  # what semicolons part from the statement that was given
        self._starts, self._sums = _sums(text)
        self.lines = _Lines(text, self._starts)
        self._plain = (self._sums == _THREE) | (self._sums == _SIX)
        self._breaks = np.append(np.flatnonzero(~self._plain), len(self.lines))

    @property
    def done(self) -> bool:
        """True behind the last line."""
        return self.at >= len(self.lines) and not self._behind

    def run(self) -> Run | None:
        """The run of plain GOTO lines that begins here, or None where there is none worth the trouble."""
        if self._behind or not self._plain[self.at]:
            return None
        stop = int(self._breaks[np.searchsorted(self._breaks, self.at)])
        if stop - self.at < 8:
            return None
        first = self.at
        counts = np.where(self._sums[first:stop] == _SIX, 6, 3)
        end = self._starts[stop] - 1 if stop < len(self._starts) else len(self.text) - 1
        flat = _numbers(self.text[self._starts[first] : end].translate(_TO_NUMBERS))
        if flat.size != counts.sum() or not np.isfinite(flat).all():
            self._plain[first:stop] = False  # read line by line, so that the fault is named with its line
            return None
        begin = np.cumsum(counts) - counts
        points = flat[begin[:, None] + np.arange(3)]
        printed = np.maximum.accumulate(np.where(counts == 6, np.arange(len(counts)), -1))
        axes = flat[np.minimum(begin[printed][:, None] + np.arange(3, 6), flat.size - 1)]
        axes[printed < 0] = np.nan
        if (np.abs(np.linalg.norm(axes, axis=1) - 1.0) > 0.01).any():
            self._plain[first:stop] = False
            return None
        self.at = stop
        return Run(points, axes, first + 1)

    def statement(self) -> Statement | None:
        """The next statement or comment; None for an empty line. Raises ToolpathError at a definition of an APT program."""
        if self._behind:
            return self._behind.pop(0)
        first = self.at
        line = self.lines[self.at]
        self.at += 1
        bare = line.strip()
        if not bare:
            return None
        if bare.startswith("$$"):
            if bare.startswith("$$->") and re.search(
                r"[^$]\$$", bare
            ):  # Creo goes on with a comment like with a statement
                while bare.endswith("$") and not self.done and _NUMBERS_ONLY.fullmatch(self.lines[self.at]):
                    bare = bare[:-1] + self.lines[self.at].strip()
                    self.at += 1
            return Statement("$$", bare, first + 1, self.at)
        free = _FREE.match(line)
        text = self._joined(line, free=free is not None)
        if free:
            return Statement(free[1].upper(), text[free.end() :].lstrip(" /"), first + 1, self.at)
        text, *behind = text.split(";") if "'" not in text else [text]
        while behind:
            piece = behind.pop(0)
            if free := _FREE.match(piece):
                rest = ";".join([piece[free.end() :].lstrip(" /"), *behind])
                self._behind.append(Statement(free[1].upper(), rest, first + 1, self.at))
                break
            if piece.strip():
                major, _, rest = piece.partition("/")
                self._behind.append(Statement(" ".join(major.upper().split()), rest, first + 1, self.at))
        if _DEFINITION.match(text):
            raise ToolpathError(
                "a definition: this is an APT part program, not CL data",
                hint="run it through the APT processor first",
                line=first + 1,
            )
        major, _, rest = text.partition("/")
        major = ",".join(" ".join(part.split()) for part in major.upper().split(","))
        return Statement(major, rest, first + 1, self.at) if major or rest else None

    def _joined(self, line: str, free: bool) -> str:
        """The statement that begins with `line`, without comments; moves on behind its continuation lines."""
        text = ""
        while True:
            tail = line.rstrip()
            if free:  # a text may hold a $: only the last character of the line continues it
                cut = len(tail) - 1 if tail.endswith("$") and not tail.endswith("$$") else -1
            else:
                cut = line.find("$")
            if cut < 0:
                return text + line
            text += line[:cut]
            if line.startswith("$$", cut):
                return text
            while not self.done and self.lines[self.at].lstrip().startswith("$$"):
                self.at += 1
            if self.done:
                return text
            line = self.lines[self.at]
            self.at += 1


def _numbers(text: str) -> NDArray[np.float64]:
    """Numbers between commas; none where the text holds anything else."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # what older numpy says instead of ValueError
        try:
            return np.fromstring(text, sep=" , ")
        except (ValueError, DeprecationWarning):
            return np.empty(0)


def _sums(text: str) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Where each line starts, and the sum of its characters' weights; lines that don't start with GOTO are given 0."""
    codes = np.frombuffer(text.encode("ascii", "replace"), np.uint8)
    ends = np.flatnonzero(codes == ord("\n"))
    starts = np.concatenate(([0], ends[:-1] + 1))
    sums = np.zeros(len(starts), np.int64)
    first = 0
    while first < len(starts):
        stop = max(int(np.searchsorted(ends, starts[first] + _BLOCK)), first + 1)
        low, high = starts[first], ends[stop - 1] + 1
        sums[first:stop] = np.add.reduceat(_WEIGHTS[codes[low:high]], starts[first:stop] - low, dtype=np.int64)
        first = stop
    head = np.ones(len(starts), np.bool_)
    for i, letter in enumerate("GOTO"):
        head &= (codes[np.minimum(starts + i, len(codes) - 1)] & 0xDF) == ord(letter)
    return starts, np.where(head, sums, 0)


def tape(text: str, beside: str = "") -> list[tuple[int, str]]:
    """Blocks of G-code without blanks and comments, with their lines, up to the second %; what M98 or G65 calls stands behind it.

    beside: of other files, whose lines are counted on from those of the text; subroutines of LinuxCNC's stand before their call.
    """
    if beside:
        lines = text.count("\n") + 1
        more = [(i + lines, row) for i, row in _rows(beside) if not row.startswith("%")]
        return [*more, *tape(text)] if re.match(r"O(<[^>]*>|\d+)SUB", more[0][1]) else [*tape(text), *more]
    rows = _rows(text)
    last = next((k for k, (_, block) in enumerate(rows) if k and block.startswith("%")), len(rows))
    behind = [row for row in rows[last:] if not row[1].startswith("%")]
    called = re.search(r"(?:M\s*0*98|G\s*0*65)(?![\d.])", COMMENT.sub("", text).upper())
    if not (behind and re.match(r"[O:]\d", behind[0][1]) and called):
        behind = []
    return [*(row for row in rows[:last] if not row[1].startswith("%")), *behind]


def _rows(text: str) -> list[tuple[int, str]]:
    """Blocks of G-code without blanks and comments, with their lines."""
    rows = [(i, "".join(COMMENT.sub("", line).upper().split())) for i, line in enumerate(text.split("\n"), 1)]
    return [(i, block) for i, block in rows if block.strip(")")]  # ")" alone closes a comment that holds another
