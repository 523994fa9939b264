"""Arrays for a page's data blocks: base64 of little-endian numbers, in the form that plotly.js reads by itself."""

from __future__ import annotations

import base64

import numpy as np
from numpy.typing import ArrayLike

__all__ = ["packed_floats", "packed_integers", "packed_shorts"]


def _packed(values: ArrayLike, dtype: str, name: str) -> dict[str, str]:
    array = np.ascontiguousarray(values, dtype=dtype)
    return {"dtype": name, "bdata": base64.b64encode(array.tobytes()).decode("ascii")}


def packed_floats(values: ArrayLike) -> dict[str, str]:
    """Single-precision numbers, flattened; NaN is a gap."""
    return _packed(values, "<f4", "f4")


def packed_integers(values: ArrayLike) -> dict[str, str]:
    """Signed 32-bit numbers, flattened."""
    return _packed(values, "<i4", "i4")


def packed_shorts(values: ArrayLike) -> dict[str, str]:
    """Unsigned 16-bit numbers, flattened."""
    return _packed(values, "<u2", "u2")
