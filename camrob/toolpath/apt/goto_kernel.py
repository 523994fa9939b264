"""Runs of plain GOTO and RAPID statements, read byte by byte in compiled code, bit for bit as float() reads them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel, part

__all__ = ["ROWS", "scan_gotos"]

ROWS = 8192  # of one call: long files are read in pieces, so that progress can be reported

_EXACT = 1 << 53  # integers up to here, and powers of ten up to 1e22, are exact in float64: their quotient rounds right
_POWERS = 10.0 ** np.arange(23)


@part
def _skip_blanks(data: NDArray[np.uint8], pos: int, end: int) -> int:
    while pos < end and (data[pos] == 32 or data[pos] == 9):
        pos += 1
    return pos


@part
def _matches(data: NDArray[np.uint8], pos: int, end: int, word: NDArray[np.uint8]) -> bool:
    """Whether the upper-case `word` stands at `pos`, in any case."""
    if pos + len(word) > end:
        return False
    for n in range(len(word)):
        c = data[pos + n]
        if 97 <= c <= 122:
            c -= 32
        if c != word[n]:
            return False
    return True


@part
def _line_end(data: NDArray[np.uint8], pos: int, end: int) -> int:
    """Where the next line starts when only blanks are left on this one, -1 otherwise."""
    pos = _skip_blanks(data, pos, end)
    if pos < end and data[pos] == 13:
        pos += 1
    return pos + 1 if pos < end and data[pos] == 10 else -1


@part
def _number(data: NDArray[np.uint8], pos: int, end: int) -> tuple[float, int]:
    """The plain decimal at `pos` and where it ends; -1 where there is none that can be read exactly here."""
    negative = False
    if pos < end and (data[pos] == 45 or data[pos] == 43):
        negative = data[pos] == 45
        pos += 1
    mantissa = 0
    digits = 0
    places = 0
    point = False
    while pos < end:
        c = data[pos]
        if 48 <= c <= 57:
            mantissa = mantissa * 10 + (c - 48)
            digits += 1
            places += point
            if mantissa > _EXACT or places > 22:
                return 0.0, -1
        elif c == 46 and not point:
            point = True
        else:
            break
        pos += 1
    if digits == 0:
        return 0.0, -1
    value = float(mantissa) / _POWERS[places]
    return (-value if negative else value), pos


@part
def _goto_numbers(data: NDArray[np.uint8], pos: int, end: int, row: NDArray[np.float64]) -> tuple[int, int, int]:
    """The numbers after the slash of a GOTO: how many (0 where this is no plain one), the next line, lines passed."""
    count = 0
    lines = 0
    while count < 6:
        pos = _skip_blanks(data, pos, end)
        if pos < end and data[pos] == 36 and count > 0:  # a dollar after a comma: on to the next line
            if pos + 1 < end and data[pos + 1] == 36:
                return 0, pos, 0
            pos = _line_end(data, pos + 1, end)
            if pos < 0:
                return 0, pos, 0
            lines += 1
            continue
        value, pos = _number(data, pos, end)
        if pos < 0:
            return 0, pos, 0
        row[count] = value
        count += 1
        pos = _skip_blanks(data, pos, end)
        if pos < end and data[pos] == 44:
            pos += 1
        else:
            break
    pos = _line_end(data, pos, end)
    if pos < 0 or (count != 3 and count != 6):
        return 0, pos, 0
    return count, pos, lines + 1


_GOTO = np.frombuffer(b"GOTO", dtype=np.uint8)
_RAPID = np.frombuffer(b"RAPID", dtype=np.uint8)


@kernel
def scan_gotos(
    data: NDArray[np.uint8],
    pos: int,
    line: int,
    rapid: bool,
    values: NDArray[np.float64],
    counts: NDArray[np.int8],
    rapids: NDArray[np.bool_],
    lines: NDArray[np.int64],
) -> tuple[int, int, int, bool]:
    """Read GOTO and RAPID statements from the line that starts at `pos` on, until anything else comes.

    Fills `values` (ROWS, 6), `counts` (3 or 6 numbers), `rapids` (a RAPID stood before it) and `lines` (where the
    statement begins). A statement that needs more than plain decimals is left for the general lexer.
    Returns the number of rows, the position and line where reading stopped, and whether a RAPID is still open.
    """
    end = len(data)
    rows = 0
    while rows < len(counts):
        at = _skip_blanks(data, pos, end)
        if _matches(data, at, end, _RAPID):
            at = _skip_blanks(data, at + 5, end)
            if at < end and data[at] == 47:
                at += 1
            after = _line_end(data, at, end)
            if after < 0:
                break
            rapid = True
            pos = after
            line += 1
            continue
        if not _matches(data, at, end, _GOTO):
            break
        at = _skip_blanks(data, at + 4, end)
        if at >= end or data[at] != 47:
            break
        count, after, passed = _goto_numbers(data, at + 1, end, values[rows])
        if count == 0:
            break
        counts[rows] = count
        rapids[rows] = rapid
        lines[rows] = line
        rapid = False
        rows += 1
        pos = after
        line += passed
    return rows, pos, line, rapid
