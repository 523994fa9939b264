"""Numbers between CSV text and arrays, compiled: a comma-separated table of plain decimals, cell by cell."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel, part

__all__ = ["BAD_COUNT", "BAD_NUMBER", "BLANK_LINE", "GOOD", "format_table", "parse_table"]

Array = NDArray[np.float64]
Bytes = NDArray[np.uint8]

GOOD, BAD_NUMBER, BAD_COUNT, BLANK_LINE = 0, 1, 2, 3
_COMMA, _NEWLINE, _RETURN, _SPACE, _TAB = 44, 10, 13, 32, 9  # ASCII
_POWERS = np.array([10.0**k for k in range(23)])


@part
def _number(text: Bytes, begin: int, end: int) -> tuple[float, int]:
    """The decimal in text[begin:end] and 0; 1 where a slower reader has to look, 2 where the cell is empty.

    Exact: at most 15 significant digits and 22 decimals, an integer divided by a power of ten that float64 holds.
    """
    while begin < end and (text[begin] == _SPACE or text[begin] == _TAB):
        begin += 1
    while end > begin and (text[end - 1] == _SPACE or text[end - 1] == _TAB or text[end - 1] == _RETURN):
        end -= 1
    if begin == end:
        return np.nan, 2
    negative = text[begin] == 45
    if negative or text[begin] == 43:
        begin += 1
    mantissa, digits, seen, decimals, point = 0, 0, 0, 0, False
    for i in range(begin, end):
        c = text[i]
        if 48 <= c <= 57:
            seen += 1
            digits += digits > 0 or c != 48
            decimals += point
            if digits > 15 or decimals > 22:
                return np.nan, 1
            mantissa = 10 * mantissa + (c - 48)
        elif c == 46 and not point:
            point = True
        else:
            return np.nan, 1
    if seen == 0:
        return np.nan, 1
    value = mantissa / _POWERS[decimals]
    return (-value if negative else value), 0


@kernel(nogil=True)
def parse_table(text: Bytes, start: int, out: Array, slow: NDArray[np.int64]) -> tuple[int, int, int, int]:
    """Read the table in text[start:] into out (rows, columns), NaN where a cell is empty.

    Gives (rows read, code, column of the fault, cells left in `slow`). `slow` (capacity, 4) receives row, column, begin
    and end of the cells that are no plain decimals, for a slower reader. Blank lines may only stand at the end.
    """
    width = out.shape[1]
    row, column, left = 0, 0, 0
    begin, size = start, text.shape[0]
    blank = False
    line_begin = start
    for i in range(start, size + 1):
        c = text[i] if i < size else _NEWLINE
        if c != _COMMA and c != _NEWLINE:
            continue
        if c == _NEWLINE and column == 0:
            empty = True
            for k in range(line_begin, i):
                if text[k] != _SPACE and text[k] != _TAB and text[k] != _RETURN:
                    empty = False
            # a table of one column can't tell an empty cell from an empty line
            if empty:
                blank = blank or i < size
                begin = line_begin = i + 1
                continue
        if blank:
            return row, BLANK_LINE, 0, left
        if column >= width or row >= out.shape[0]:
            return row, BAD_COUNT, column, left
        value, why = _number(text, begin, i)
        out[row, column] = value
        if why == 1:
            if left >= slow.shape[0]:
                return row, BAD_NUMBER, column, left
            slow[left, 0], slow[left, 1], slow[left, 2], slow[left, 3] = row, column, begin, i
            left += 1
        begin = i + 1
        column += 1
        if c == _NEWLINE:
            if column != width:
                return row, BAD_COUNT, column, left
            row, column, line_begin = row + 1, 0, i + 1
    return row, GOOD, 0, left


@kernel(nogil=True)
def format_table(table: Array, decimals: NDArray[np.int64], out: Bytes) -> int:
    """Write a table (rows, columns) into `out` as comma-separated lines with so many decimals a column; NaN is empty.

    Gives the number of bytes written. A row takes 26 bytes a cell at most, for values below 1e15 / 10^decimals.
    """
    at = 0
    for row in range(table.shape[0]):
        for column in range(table.shape[1]):
            value = table[row, column]
            if value == value:
                at = _format(value, decimals[column], out, at)
            out[at] = _NEWLINE if column == table.shape[1] - 1 else _COMMA
            at += 1
    return at


@part
def _format(value: float, decimals: int, out: Bytes, at: int) -> int:
    """One number, rounded to its decimals; -0 is 0."""
    scaled = np.int64(np.floor(abs(value) * _POWERS[decimals] + 0.5))
    if value < 0.0 and scaled > 0:
        out[at] = 45
        at += 1
    digits = 1
    rest = scaled // 10
    while rest > 0:
        digits += 1
        rest //= 10
    digits = max(digits, decimals + 1)
    stop = at + digits + (decimals > 0)
    k = stop - 1
    for i in range(digits):
        if decimals > 0 and i == decimals:
            out[k] = 46
            k -= 1
        out[k] = 48 + scaled % 10
        scaled //= 10
        k -= 1
    return stop
