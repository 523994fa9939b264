"""What a page of camrob's holds: its blocks of data, plain or packed, read from what pack.py says of its form alone."""

from __future__ import annotations

import base64
import gzip
import json
import re
from typing import Any

import numpy as np

__all__ = ["array_of", "block_of", "data_of", "library_of", "lines_of"]


def library_of(text: str) -> str:
    """The text of a packed library."""
    return gzip.decompress(base64.b64decode(text)).decode()


def block_of(page: str, name: str) -> Any:
    """The data of the block with this id, its arrays flattened."""
    kind, text = re.search(rf'<script type="([^"]+)" id="{name}">([^<]*)</script>', page).groups()
    return data_of(text, packed=kind == "application/gzip")


def data_of(text: str, *, packed: bool) -> Any:
    """The data of a block's text."""
    if not packed:
        return json.loads(text)
    said, _, arrays = gzip.decompress(base64.b64decode(text)).partition(b"\0")
    return json.loads(said, object_hook=lambda found: _array(arrays, *found["$"]) if "$" in found else found)


def array_of(packed: Any) -> np.ndarray:
    """A PackedArray, flattened, as a page would read it."""
    return _array(packed.data, *packed.place(0)["$"])


def lines_of(said: Any) -> list[str]:
    """The lines of a program that were parted into words and numbers."""
    left = [iter(numbers) if numbers is not None else iter(()) for numbers in said["numbers"]]
    lines = []
    for form in said["form"]:
        words, *more = said["forms"][form].split("\0")
        for places, word in zip(said["decimals"][form], more, strict=True):
            words += f"{int(next(left[form])) / 10**places:.{places}f}" + word
        lines.append(words)
    return lines


def _array(arrays: bytes, at: int, size: int, count: int, columns: int, step: float, whole: int) -> np.ndarray:
    numbers, number, place = [], 0, 0
    for byte in arrays[at : at + size]:
        number |= (byte & 127) << place
        place += 7
        if byte < 128:
            numbers.append(number)
            number, place = 0, 0
    out = np.full((columns, count), np.nan)
    for column, codes in zip(out, np.array(numbers, object).reshape(columns, count), strict=True):
        steps = 0
        for row, code in enumerate(codes):
            if code:
                steps += (code - 1) // 2 if code % 2 else -(code // 2)
                column[row] = steps * step
    flat = out.T.ravel()
    return flat.astype(np.int64) if whole else flat
