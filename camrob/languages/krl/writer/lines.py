"""Bulk printing of LIN and CIRC lines, compiled: numbers from integers, so that what is printed is exact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel, part
from camrob.program.motion import Motion

__all__ = ["LineBlock", "format_lines", "speed_line"]

Bytes = NDArray[np.uint8]
Integers = NDArray[np.int64]

_SPEED = "$VEL.CP = "
_NUMBER_WIDTH = 22  # characters of the longest number that is printed
_LIN, _VIA, _END, _CLOSE, _APPROXIMATE, _NEWLINE, _VELOCITY, _LABELS = range(8)
_KIND_LIN, _KIND_VIA = int(Motion.LIN), int(Motion.CIRC_VIA)


@dataclass(frozen=True, slots=True)
class LineBlock:
    """CP motions, ready to be printed.

    kind: (M,) `Motion`, without PTP; a CIRC_VIA is followed by its CIRC_END. values: (M, K) whole numbers, the value
    times 10 ** decimals of its column. labels: K names. speed: (M,) whole numbers, printed before the motion where
    `speak` is set. approximate: (M,) bool. spline: SLIN and SCIRC; rounding: behind a target that is rounded off.
    """

    kind: NDArray[np.int8]
    values: Integers
    labels: tuple[str, ...]
    decimals: tuple[int, ...]
    speed: Integers
    speed_decimals: int
    speak: NDArray[np.bool_]
    approximate: NDArray[np.bool_]
    spline: bool = False
    rounding: str = "C_DIS"


def speed_line(speed: float, decimals: int) -> str:
    """The line that sets the speed of the TCP, m/s."""
    return f"{_SPEED}{speed:.{decimals}f}"


def format_lines(block: LineBlock) -> tuple[bytes, Integers, int]:
    """Text of the block, the place behind each motion in it (M,), and the length of its longest line, in characters.

    O(M), about 0.2 microseconds a motion of eight numbers.
    """
    labels = [("," if k else "") + label + " " for k, label in enumerate(block.labels)]
    of = "S" * block.spline
    fixed = (f"{of}LIN {{E6POS: ", f"{of}CIRC {{E6POS: ", ",{E6POS: ", "}", f" {block.rounding}", "\r\n", _SPEED)
    pieces, bounds = _pieces((*fixed, *labels))
    room = (len(pieces) + _NUMBER_WIDTH * (len(labels) + 1)) * len(block.kind)
    out = np.empty(room, dtype=np.uint8)
    ends = np.empty(len(block.kind), dtype=np.int64)
    longest = _format(
        np.array(block.kind),
        block.values,
        np.array(block.decimals, dtype=np.int64),
        block.speed,
        block.speed_decimals,
        block.speak,
        np.array(block.approximate),
        pieces,
        bounds,
        out,
        ends,
    )  # copies: frozen arrays would be compiled for separately
    return (out[: ends[-1]].tobytes() if len(ends) else b""), ends, int(longest)


def _pieces(texts: Sequence[str]) -> tuple[Bytes, Integers]:
    """The texts behind each other, and where each begins and ends."""
    joined = np.frombuffer("".join(texts).encode("ascii"), dtype=np.uint8)
    return joined, np.concatenate(([0], np.cumsum([len(t) for t in texts]))).astype(np.int64)


@part
def _put(out: Bytes, at: int, pieces: Bytes, bounds: Integers, piece: int) -> int:
    """Copies a piece; the place behind it."""
    for i in range(bounds[piece], bounds[piece + 1]):
        out[at] = pieces[i]
        at += 1
    return at


@part
def _put_number(out: Bytes, at: int, scaled: int, decimals: int) -> int:
    """Prints scaled / 10 ** decimals; the place behind it. Zero has no sign, since an integer zero has none."""
    if scaled < 0:
        out[at] = 45
        at += 1
        scaled = -scaled
    digits = 1
    rest = scaled // 10
    while rest > 0:
        digits += 1
        rest //= 10
    if digits <= decimals:
        digits = decimals + 1
    width = digits + (1 if decimals > 0 else 0)
    place = at + width - 1
    for k in range(digits):
        if k == decimals and decimals > 0:
            out[place] = 46
            place -= 1
        out[place] = 48 + scaled % 10
        scaled //= 10
        place -= 1
    return at + width


@kernel
def _format(kind, values, decimals, speed, speed_decimals, speak, approximate, pieces, bounds, out, ends):  # type: ignore[no-untyped-def]
    """Prints all motions into `out`; the length of the longest line without its line end."""
    at = 0
    longest = 0
    start = 0
    columns = values.shape[1]
    for i in range(len(kind)):
        if speak[i]:
            at = _put(out, at, pieces, bounds, _VELOCITY)
            at = _put_number(out, at, speed[i], speed_decimals)
            at = _put(out, at, pieces, bounds, _NEWLINE)
        if kind[i] == _KIND_LIN:
            start = at
            at = _put(out, at, pieces, bounds, _LIN)
        elif kind[i] == _KIND_VIA:
            start = at
            at = _put(out, at, pieces, bounds, _VIA)
        else:
            at = _put(out, at, pieces, bounds, _END)
        for k in range(columns):
            at = _put(out, at, pieces, bounds, _LABELS + k)
            at = _put_number(out, at, values[i, k], decimals[k])
        at = _put(out, at, pieces, bounds, _CLOSE)
        if kind[i] != _KIND_VIA:
            if approximate[i]:
                at = _put(out, at, pieces, bounds, _APPROXIMATE)
            longest = max(longest, at - start)
            at = _put(out, at, pieces, bounds, _NEWLINE)
        ends[i] = at
    return longest
