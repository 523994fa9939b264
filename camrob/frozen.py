"""Arrays that can't be changed behind one's back, and digests that say what a result was made from."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

__all__ = ["digest", "leaves", "locked"]


def locked(
    values: ArrayLike, *, shape: Sequence[int | None] | None = None, dtype: DTypeLike = np.float64, name: str = "array"
) -> NDArray[Any]:
    """A read-only private copy of `values`; `shape` (None for any length) is checked.

    The lock sits on the base of a view, so that `setflags(write=True)` on the result fails too.
    Raises ValueError when the shape is another one.
    """
    base = np.array(values, dtype=dtype, order="C", copy=True)
    if shape is not None:
        fits = base.ndim == len(shape) and all(
            want is None or want == got for want, got in zip(shape, base.shape, strict=True)
        )
        if not fits:
            raise ValueError(f"{name} has shape {base.shape}, expected {tuple(shape)}")
    base.setflags(write=False)
    return base.view()


def digest(*parts: Any) -> str:
    """Hexadecimal SHA-256 over arrays (bytes, shape and type), strings, numbers and None, in their order."""
    h = hashlib.sha256()
    for part in parts:
        if isinstance(part, np.ndarray):
            h.update(f"array{part.dtype}{part.shape}".encode())
            h.update(np.ascontiguousarray(part).tobytes())
        else:
            h.update(f"{type(part).__name__}:{part!r};".encode())
    return h.hexdigest()


def leaves(value: Any) -> Iterator[Any]:
    """What `digest` takes, of a value made of dataclasses, mappings (in their keys' order) and sequences.

    Each of these yields its kind and length first, so that no two structures have the same leaves.
    """
    if is_dataclass(value) and not isinstance(value, type):
        yield type(value).__name__
        for f in fields(value):
            yield from leaves(getattr(value, f.name))
    elif isinstance(value, Mapping):
        yield f"mapping{len(value)}"
        for key in sorted(value):
            yield key
            yield from leaves(value[key])
    elif isinstance(value, tuple | list):
        yield f"sequence{len(value)}"
        for entry in value:
            yield from leaves(entry)
    else:
        yield value
