"""The text of one KRL file: its statements, and its long rows of like motions read as columns.

A line of which nothing but numbers differs from another's has the same skeleton: what is left without digits and minus signs.
Where the first line of a skeleton is a LIN of plain decimals, or sets `$VEL.CP`, all lines of that skeleton are read at once.
What is read so is proven to be that form (see `_columns`); whatever isn't, is read statement by statement.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.errors import KrlError

__all__ = ["HOW", "Line", "Source", "read_source", "split_comment"]

Array = NDArray[np.float64]

_NUMBER = rb" -?[0-9]+\.[0-9]+"
_LIN = re.compile(
    rb"S?LIN \{(?:(?:E6POS|POS|E3POS): )?([XYZABC]|E[1-6])"
    + _NUMBER
    + rb"(?:,(?: ?)([XYZABC]|E[1-6])"
    + _NUMBER
    + rb")*\}( C_DIS| C_VEL| C_ORI| C_SPL)?"
)
_PART = re.compile(rb"([XYZABC]|E[1-6])" + _NUMBER)
_SPEED = re.compile(rb"\$VEL\.CP ?= ?[0-9]+\.[0-9]+")
_DROPPED = b"0123456789-"
_PLAIN = bytes(code for code in range(256) if code >= 32 or code in b"\t\n")
# 32: a blank, 48: a zero
_BLANKED = bytes(code if chr(code) in "0123456789-" else 32 for code in range(256))
_ZEROED = bytes(48 if chr(code) in "0123456789" else code for code in range(256))
_PIECE = 1 << 24  # bytes read at once: bounds the memory that splitting into lines takes
_DECIMALS = 6  # with more, the number behind the next label might end where this one is looked for
_LARGEST = 10**15  # integers above it may not be exact
_BEHIND = np.frombuffer(b",}\n", dtype=np.uint8)  # what ends a number
_FEW = 8  # lines of a skeleton in a piece below which columns aren't worth it
_ABOVE = 4  # comments kept above a statement
POSE = ("X", "Y", "Z", "A", "B", "C")
HOW = tuple((kind, word) for kind in ("", "S") for word in ("", "C_DIS", "C_VEL", "C_ORI", "C_SPL"))
"""A straight motion's kind, LIN or SLIN ("S"), and the word behind it, in the order of `Source.rounded`."""


@dataclass(frozen=True, slots=True)
class Line:
    """One statement: `code` in capitals (strings kept), single blanks, no comment; `raw` as written.

    above: comments on the lines right above it, which some hooks carry a value in.
    """

    number: int
    code: str
    comment: str
    raw: str
    above: tuple[str, ...] = ()


@dataclass(slots=True)
class Source:
    """One file. `lines`: statements, without comments and rows. Rows by line: LIN with `pose` (K, 6) mm, degrees and
    `external` (K, 6) E1..E6, NaN where not written, `rounded` (K,) as HOW names them; `$VEL.CP` with `speed`.
    odd: line of the first control character that systems read differently, 0 where there is none. longest: line and characters.
    """

    path: Path
    count: int
    lines: list[Line]
    row_line: NDArray[np.int64]
    pose: Array
    external: Array
    rounded: NDArray[np.int8]
    speed_line: NDArray[np.int64]
    speed: Array
    odd: int = 0
    longest: tuple[int, int] = (0, 0)


@dataclass(slots=True)
class _Pieces:
    """What has been read so far."""

    lines: list[Line] = field(default_factory=list)
    rows: list[tuple[NDArray[np.int64], Array, Array, int]] = field(default_factory=list)
    speeds: list[tuple[NDArray[np.int64], Array]] = field(default_factory=list)
    longest: tuple[int, int] = (0, 0)  # line, characters


def split_comment(text: str) -> tuple[str, str]:
    """A line's code and its comment: a semicolon outside quotes begins it."""
    if ";" not in text:
        return text, ""
    if '"' not in text:
        code, _, comment = text.partition(";")
        return code, comment
    quoted = False
    for i, letter in enumerate(text):
        if letter == '"':
            quoted = not quoted
        elif letter == ";" and not quoted:
            return text[:i], text[i + 1 :]
    return text, ""


def _statement(number: int, raw: bytes, above: tuple[str, ...], *, opening: bool) -> Line:
    """The statement on a line; its code is empty for blank lines, comments and, in a file's opening, the editor's header lines
    (&ACCESS), which no controller takes anywhere else.
    """
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    code, comment = split_comment(text)
    parts = code.split('"')
    known = all(part.isascii() for part in parts[::2])
    parts[::2] = [" ".join(part.upper().split()) if i else part.upper() for i, part in enumerate(parts[::2])]
    code = " ".join(parts[0].split()) if len(parts) == 1 else '"'.join(parts).strip()
    if not known:  # Python takes more for a blank than a controller does, and other letters for capitals of ASCII
        code = f"? {code}"
    return Line(number, "" if opening and code.startswith("&") else code, comment.strip(), text.strip(), above)


def _columns(block: bytes, count: int) -> Array | None:
    """The numbers (count, K) of lines that share a skeleton; None unless each is `-?digits.digits` in its place.

    The skeleton shows every character but digits and minus signs, one point a number. So it is enough that each minus stands
    between a blank and a digit, each number's point between digits, as many behind it as on the first line, and that the digits
    of labels (E6POS, E1) are the first line's: one digit more anywhere makes another number, or another label. The digits are
    then read as integers, which is quicker, and an integer below 2^53 over a power of ten is the decimal's own double.
    """
    first = block.partition(b"\n")[0]
    labels = [match[1] or b"" for match in re.finditer(rb"(?<=[A-Z$_])([0-9]+)|-?[0-9]+\.[0-9]+", first)]
    decimals = [len(text) for text in re.findall(rb"(?<=[0-9]\.)[0-9]+", first)]
    points = [match[1] is not None for match in re.finditer(rb"([0-9]\.)|\.", first)]
    flat = block.translate(_ZEROED)
    if flat.count(b" -0") != block.count(b"-") or flat.count(b"0.0") != count * len(decimals):
        return None
    codes = np.frombuffer(block + b"\n", dtype=np.uint8)
    at = np.flatnonzero(codes == ord(".")).reshape(count, -1)[:, points]
    behind = at + np.array(decimals) + 1
    if max(decimals) > _DECIMALS or behind.max() >= len(codes) or not np.isin(codes[behind], _BEHIND).all():
        return None
    try:
        numbers = np.fromstring(block.translate(_BLANKED, b"."), dtype=np.int64, sep=" ")
    except ValueError:
        return None
    if len(numbers) != count * len(labels) or np.abs(numbers).max() >= _LARGEST:
        return None
    table = numbers.reshape(count, -1)
    fixed = [k for k, text in enumerate(labels) if text]
    if (table[:, fixed] != np.array([int(labels[k]) for k in fixed], dtype=np.int64)).any():
        return None
    return np.asarray(table[:, [k for k, text in enumerate(labels) if not text]] / 10.0 ** np.array(decimals))


def _read_rows(numbers: NDArray[np.int64], texts: list[bytes], pieces: _Pieces) -> bool:
    """Reads lines of one skeleton as columns; False where they have to be read one by one."""
    first = texts[0]
    is_speed = _SPEED.fullmatch(first)
    if not is_speed and not _LIN.fullmatch(first):
        return False
    table = _columns(b"\n".join(texts), len(texts))
    if table is None:
        return False
    if is_speed:
        pieces.speeds.append((numbers, table[:, 0]))
        return True
    names = [name.decode() for name in _PART.findall(first)]
    kind = first.partition(b"{")[2].partition(b": ")[0]
    held = {b"POS": POSE, b"E3POS": (*POSE, "E1", "E2", "E3")}.get(kind, names)
    if len(set(names)) != len(names) or not set(POSE) <= set(names) <= set(held):
        return False
    external = np.full((len(texts), 6), np.nan)
    for k in range(6):
        if f"E{k + 1}" in names:
            external[:, k] = table[:, names.index(f"E{k + 1}")]
    pieces.rows.append((numbers, table[:, [names.index(name) for name in POSE]], external, _how_round(first)))
    return True


def _how_round(text: bytes) -> int:
    """How a LIN's or SLIN's end is rounded, by its place in HOW."""
    word = text.rpartition(b"}")[2].strip().decode()
    return HOW.index(("S" if text.startswith(b"S") else "", word))


def _read_piece(piece: bytes, start: int, pieces: _Pieces) -> int:
    """Reads whole lines of text, the first of them line `start`; returns how many there were."""
    raw = piece.split(b"\n")
    most = max(map(len, raw))
    if most > pieces.longest[1]:
        pieces.longest = (start + next(i for i, line in enumerate(raw) if len(line) == most), most)
    kinds: dict[bytes, int] = {}
    kind_of = np.array(
        [kinds.setdefault(skeleton, len(kinds)) for skeleton in piece.translate(None, _DROPPED).split(b"\n")]
    )
    size = np.bincount(kind_of)
    order = np.argsort(kind_of, kind="stable")
    slow = []
    for kind, members in enumerate(np.split(order, np.cumsum(size)[:-1])):
        texts = [raw[i] for i in members]
        if size[kind] < _FEW or not _read_rows(members + start, texts, pieces):
            slow.append(members)
    above: tuple[str, ...] = ()
    last = -1
    for i in np.sort(np.concatenate(slow)).tolist() if slow else ():
        line = _statement(i + start, raw[i], above if i == last + 1 else (), opening=not pieces.lines)
        if line.code:
            pieces.lines.append(line)
        above = () if line.code else (*line.above[-_ABOVE:], line.comment)
        last = i
    return len(raw)


def read_source(path: Path) -> Source:
    """Reads one .src or .dat file. Raises KrlError where it can't be read, is no text, or has a header line where none may be."""
    try:
        text = path.read_bytes()
    except OSError as failure:
        raise KrlError(f"can't be read ({failure.strerror or failure})", path=path) from failure
    if b"\0" in text:
        raise KrlError("is not text: it holds bytes that are 0", hint="export the program as text", path=path)
    if b"\r" in text:
        text = text.replace(b"\r\n", b"\n")
        if b"\n\r" in text:
            what = "has line ends of two kinds, some the wrong way round (LF, CR)"
            raise KrlError(what, hint="write CR, LF behind each line", path=path)
    text = text.removesuffix(b"\x1a")  # old systems end a file so
    odd = text.translate(None, _PLAIN)
    odd_line = text.partition(odd[:1])[0].count(b"\n") + 1 if odd else 0
    if b"\r" in text:
        text = text.replace(b"\r", b"\n")
    pieces, at, count = _Pieces(), 0, 0
    while at < len(text):
        end = text.find(b"\n", at + _PIECE) if at + _PIECE < len(text) else -1
        end = len(text) if end < 0 else end
        count += _read_piece(text[at:end], count + 1, pieces)
        at = end + 1
    late = next((line for line in pieces.lines if line.code.startswith("&")), None)
    if late is not None:
        what = f"has a header line ({late.code[:40]}) behind its first statement"
        raise KrlError(what, hint="move it to the top of the file", path=path, line=late.number)
    empty = (np.empty(0, dtype=np.int64), np.empty((0, 6)), np.empty((0, 6)), 0)
    rows = pieces.rows or [empty]
    line = np.concatenate([row[0] for row in rows])
    order = np.argsort(line)
    speeds = pieces.speeds or [(empty[0], np.empty(0))]
    speed_line = np.concatenate([row[0] for row in speeds])
    by_line = np.argsort(speed_line)
    return Source(
        path=path,
        count=count,
        lines=pieces.lines,
        row_line=line[order],
        pose=np.concatenate([row[1] for row in rows])[order],
        external=np.concatenate([row[2] for row in rows])[order],
        rounded=np.concatenate([np.full(len(row[0]), row[3], dtype=np.int8) for row in rows])[order],
        speed_line=speed_line[by_line],
        speed=np.concatenate([row[1] for row in speeds])[by_line],
        odd=odd_line,
        longest=pieces.longest,
    )
