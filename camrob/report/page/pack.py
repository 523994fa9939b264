"""Arrays for a page's data blocks: whole steps, each less the one before, in as few bytes as it needs.

What stands close together differs little, so that most numbers take a byte or two, and what is alike packs to nothing. page.js
(`camrobArray`) reads them.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["PackedArray", "packed_floats", "packed_integers", "packed_lines"]

_LEVELS = 5_000  # steps at the least between the smallest and the largest number: more than a picture shows
_MOST = 2.0**50  # steps from zero: JavaScript counts exactly to 2^53
_DIGITS = 12  # of a number that JavaScript prints again as it was
_NUMBER = re.compile(r"(-?)(?<![0-9.])([0-9]+)(?:\.([0-9]+))?(?![0-9.])")


@dataclass(frozen=True, slots=True)
class PackedArray:
    """Numbers (count, columns) in `data`, column by column, seven bits a byte, the lowest first; all of a number's bytes but
    the last have the eighth bit set.

    A number is 0 for a gap (NaN); else 1 + 2d or, where d is below zero, -2d: by so many steps of `step` it is more than the
    number before it in its column, the first more than 0. whole: the numbers are integers.
    """

    data: bytes
    count: int
    columns: int
    step: float
    whole: bool

    def place(self, at: int) -> dict[str, list[float]]:
        """What the page's JSON holds in its place: where its bytes begin in the block's, and how to read them."""
        return {"$": [at, len(self.data), self.count, self.columns, self.step, int(self.whole)]}


def packed_floats(values: ArrayLike, step: float | None = None) -> PackedArray:
    """Numbers (N,) or (N, columns), to the nearest multiple of step; anything that isn't finite is a gap.

    step: by default a power of ten, at least 5 000 of which lie between the smallest and the largest number.
    """
    array = np.asarray(values, dtype=np.float64)
    finite = np.isfinite(array)
    largest = float(np.max(np.abs(array), where=finite, initial=0.0))
    if step is None:
        span = float(np.max(array, where=finite, initial=-np.inf) - np.min(array, where=finite, initial=np.inf))
        span = span if span > 0.0 else largest or 1.0
        step = 10.0 ** np.floor(np.log10(span / _LEVELS))
    step = max(float(step), largest / _MOST)
    steps = np.rint(np.where(finite, array, 0.0) / step).astype(np.int64)
    return _packed(steps, finite, step, whole=False)


def packed_integers(values: ArrayLike) -> PackedArray:
    """Integers (N,) or (N, columns)."""
    steps = np.asarray(values).astype(np.int64)
    return _packed(steps, np.ones(steps.shape, np.bool_), 1.0, whole=True)


def _packed(steps: NDArray[np.int64], there: NDArray[np.bool_], step: float, *, whole: bool) -> PackedArray:
    columns = steps.shape[1] if steps.ndim == 2 else 1
    table, kept = steps.reshape(-1, columns).T, there.reshape(-1, columns).T
    codes = np.zeros(table.shape, np.uint64)
    for code, column, known in zip(codes, table, kept, strict=True):
        more = np.diff(column[known], prepend=0)
        code[known] = np.where(more >= 0, 2 * more + 1, -2 * more).astype(np.uint64)
    return PackedArray(_in_sevens(codes.ravel()), table.shape[1], columns, step, whole)


def _in_sevens(codes: NDArray[np.uint64]) -> bytes:
    """Whole numbers one behind the other, seven bits a byte."""
    sizes = np.ones(len(codes), np.int64)
    left = codes >> np.uint64(7)
    while left.any():
        sizes += left > 0
        left >>= np.uint64(7)
    begin = np.cumsum(sizes) - sizes
    out = np.zeros(int(sizes.sum()), np.uint8)
    for k in range(int(sizes.max(initial=0))):
        long = sizes > k
        seven = (codes[long] >> np.uint64(7 * k)) & np.uint64(0x7F)
        out[begin[long] + k] = seven.astype(np.uint8) | np.where(sizes[long] > k + 1, 0x80, 0).astype(np.uint8)
    return out.tobytes()


def packed_lines(lines: Sequence[str]) -> dict[str, Any]:
    """Lines of programs for page.js (`camrobLines`): what they say but for its numbers, once, and the numbers as integers.

    forms: the text with a NUL in each number's place; decimals: of each number of a form; form: of each line (N,); numbers: of
    each form, (its lines, its numbers), None where it has none. A number that isn't written as it would be printed
    again (a plus, a leading zero) stays in the text.
    """
    known: dict[tuple[str, tuple[int, ...]], int] = {}
    rows: list[list[list[int]]] = []
    form = []
    for line in lines:
        text, decimals, values = _parted(line)
        k = known.setdefault((text, decimals), len(known))
        if k == len(rows):
            rows.append([])
        rows[k].append(values)
        form.append(k)
    return {
        "forms": [text for text, _ in known],
        "decimals": [list(decimals) for _, decimals in known],
        "form": packed_integers(form),
        "numbers": [packed_integers(np.array(values)) if values[0] else None for values in rows],
    }


def _parted(line: str) -> tuple[str, tuple[int, ...], list[int]]:
    """A line with a NUL for each number; of each number its decimals, and its digits as an integer."""
    decimals: list[int] = []
    values: list[int] = []

    def taken(match: re.Match[str]) -> str:
        minus, before, after = match[1], match[2], match[3] or ""
        value = int(before + after)
        if (minus and not value) or (len(before) > 1 and before[0] == "0") or len(before + after) > _DIGITS:
            return match[0]
        decimals.append(len(after))
        values.append(-value if minus else value)
        return "\0"

    return _NUMBER.sub(taken, line), tuple(decimals), values
