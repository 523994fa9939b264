"""First look at a KRL file, compiled: its lines, and the numbers of the lines that are written the usual way.

Usual are `LIN {[E6POS:] X n,Y n,...} [C_DIS|C_VEL|C_ORI]`, `SLIN {...} [C_SPL|C_DIS]`, `$VEL.CP = n`, blank lines and
comments. All else is left to the general reader, which gives the same numbers for these lines too (a test holds the two
together).
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel, part

__all__ = ["COMPONENTS", "Scan", "scan_lines"]

COMPONENTS = ("X", "Y", "Z", "A", "B", "C", "E1", "E2", "E3", "E4", "E5", "E6")
"""Columns of `Scan.values`."""

_GENERAL, _LIN, _SPEED, _NOTHING = 0, 1, 2, 3
_LETTERS = np.frombuffer(b"XYZABC", dtype=np.uint8)
_POWERS = 10.0 ** np.arange(17)  # all that a number of 16 digits, as many as a double holds, may be divided by
# a whole number of 15 digits over a power of ten is rounded once: exactly what float() of the text gives
_MOST_DIGITS = 15
# SLIN goes as LIN does, and is rounded off by distance, whichever of the two words says so
_SPLINE = re.compile(rb"^([ \t]*)SLIN([ \t]*\{[^{};\r\n]*\})([ \t]*)(C_SPL|C_DIS)?(?=[ \t]*(?:;|\r?$))", re.MULTILINE)


def _as_lin(found: re.Match[bytes]) -> bytes:
    """A line of SLIN as one of LIN, every character in its place."""
    return b"".join((found[1], b" LIN", found[2], found[3], b"C_DIS" if found[4] else b""))


@dataclass(frozen=True, slots=True)
class Scan:
    """Lines of a file, counted from 0. starts: (L + 1,) where each begins, the last one the end of the data.

    general: lines for the general reader, sorted. lin_line: (R,) lines of the usual LINs, lin_values: (R, 12) their
    COMPONENTS, NaN where absent, lin_approximation: (R,) 0 exact, 2 C_DIS, 3 C_VEL, 4 C_ORI. speed_line, speed_value:
    lines and values of the usual `$VEL.CP`.
    """

    starts: NDArray[np.int64]
    general: NDArray[np.int64]
    lin_line: NDArray[np.int64]
    lin_values: NDArray[np.float64]
    lin_approximation: NDArray[np.int8]
    speed_line: NDArray[np.int64]
    speed_value: NDArray[np.float64]


def scan_lines(data: bytes) -> Scan:
    """Scans a file's bytes (line ends are LF or CRLF). O(bytes), about 2 ns a byte."""
    text = np.frombuffer(_SPLINE.sub(_as_lin, data) if b"SLIN" in data else data, dtype=np.uint8)
    newlines = np.flatnonzero(text == 10) + 1
    ends = newlines if len(newlines) and newlines[-1] == len(text) else np.append(newlines, len(text))
    starts = np.concatenate(([0], ends)).astype(np.int64)
    lines = len(starts) - 1
    kind = np.empty(lines, dtype=np.int8)
    values = np.empty((lines, len(COMPONENTS)))
    approximation = np.empty(lines, dtype=np.int8)
    speed = np.empty(lines)
    rows, speeds = _scan(text, starts, kind, values, approximation, speed)
    return Scan(
        starts=starts,
        general=np.flatnonzero(kind == _GENERAL),
        lin_line=np.flatnonzero(kind == _LIN),
        lin_values=values[:rows],
        lin_approximation=approximation[:rows],
        speed_line=np.flatnonzero(kind == _SPEED),
        speed_value=speed[:speeds],
    )


@part
def _blanks(text, at, end):  # type: ignore[no-untyped-def]
    """The first place from `at` that is no blank."""
    while at < end and (text[at] == 32 or text[at] == 9):
        at += 1
    return at


@part
def _number(text, at, end):  # type: ignore[no-untyped-def]
    """The number at `at`: (place behind it, value); place -1 where it is not written the usual way."""
    negative = False
    if at < end and (text[at] == 45 or text[at] == 43):
        negative = text[at] == 45
        at += 1
    whole = np.int64(0)
    digits = 0
    decimals = 0
    point = False
    while at < end:
        c = text[at]
        if 48 <= c <= 57:
            whole = whole * 10 + (c - 48)
            digits += 1
            if point:
                decimals += 1
            if digits > _MOST_DIGITS:
                return -1, 0.0
        elif c == 46 and not point:
            point = True
        else:
            break
        at += 1
    if digits == 0:
        return -1, 0.0
    if at < end and not (text[at] == 32 or text[at] == 9 or text[at] == 44 or text[at] == 125 or text[at] == 59):
        return -1, 0.0
    value = np.float64(whole) / _POWERS[decimals]
    return at, -value if negative and (point or whole > 0) else value  # the integer -0 is 0


@part
def _component(text, at, end):  # type: ignore[no-untyped-def]
    """The component named at `at`: (place behind its name and a blank, column); place -1 for any other name."""
    column = -1
    if at + 2 < end and text[at] == 69 and 49 <= text[at + 1] <= 54:
        column = 6 + text[at + 1] - 49
        at += 2
    else:
        for k in range(6):
            if at < end and text[at] == _LETTERS[k]:
                column = k
        at += 1
    if column < 0 or at >= end or not (text[at] == 32 or text[at] == 9):
        return -1, 0
    return _blanks(text, at, end), column


@part
def _is(text, at, end, word):  # type: ignore[no-untyped-def]
    """Whether `word` stands at `at`."""
    if at + len(word) > end:
        return False
    for k in range(len(word)):
        if text[at + k] != word[k]:
            return False
    return True


_WORD_LIN = np.frombuffer(b"LIN", dtype=np.uint8)
_WORD_TYPE = np.frombuffer(b"E6POS:", dtype=np.uint8)
_WORD_SPEED = np.frombuffer(b"$VEL.CP", dtype=np.uint8)
_WORDS_C = np.frombuffer(b"C_DISC_VELC_ORI", dtype=np.uint8).reshape(3, 5)  # three words of five letters


@part
def _lin(text, at, end, row):  # type: ignore[no-untyped-def]
    """Reads the aggregate and the approximation behind LIN into `row`: the approximation, -1 where it is not usual."""
    at = _blanks(text, at, end)
    if at >= end or text[at] != 123:
        return -1
    at = _blanks(text, at + 1, end)
    if _is(text, at, end, _WORD_TYPE):
        at = _blanks(text, at + 6, end)
    row[:] = np.nan
    while True:
        at, column = _component(text, at, end)
        if at < 0 or not np.isnan(row[column]):
            return -1
        at, value = _number(text, at, end)
        if at < 0:
            return -1
        row[column] = value
        at = _blanks(text, at, end)
        if at >= end or (text[at] != 44 and text[at] != 125):
            return -1
        closed = text[at] == 125
        at = _blanks(text, at + 1, end)
        if closed:
            break
    approximation = 0
    for k in range(3):
        if _is(text, at, end, _WORDS_C[k]):
            approximation = 2 + k
    if approximation > 0:
        at = _blanks(text, at + 5, end)
    return approximation if at >= end or text[at] == 59 else -1


@kernel
def _scan(text, starts, kind, values, approximation, speed):  # type: ignore[no-untyped-def]
    """Sorts all lines; the counts of usual LINs and of usual speeds."""
    rows = 0
    speeds = 0
    for line in range(len(starts) - 1):
        end = starts[line + 1]
        while end > starts[line] and (text[end - 1] == 10 or text[end - 1] == 13):
            end -= 1
        at = _blanks(text, starts[line], end)
        kind[line] = _GENERAL
        if at >= end or text[at] == 59:
            kind[line] = _NOTHING
        elif text[at] == 76 and _is(text, at, end, _WORD_LIN):
            found = _lin(text, at + 3, end, values[rows])
            if found >= 0:
                kind[line] = _LIN
                approximation[rows] = found
                rows += 1
        elif text[at] == 36 and _is(text, at, end, _WORD_SPEED):
            at = _blanks(text, at + 7, end)
            if at < end and text[at] == 61:
                at, value = _number(text, _blanks(text, at + 1, end), end)
                if at >= 0:
                    at = _blanks(text, at, end)
                    if at >= end or text[at] == 59:
                        kind[line] = _SPEED
                        speed[speeds] = value
                        speeds += 1
    return rows, speeds
