"""Arrays that can't be changed behind one's back, and digests that say what a result was made from."""

from __future__ import annotations

import hashlib
import weakref
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

__all__ = ["digest", "leaves", "locked", "sealed"]

_OWN: weakref.WeakValueDictionary[int, NDArray[Any]] = weakref.WeakValueDictionary()
"""Arrays that were locked here, by their id: nobody else holds one that could be written to."""


def locked(
    values: ArrayLike, *, shape: Sequence[int | None] | None = None, dtype: DTypeLike = np.float64, name: str = "array"
) -> NDArray[Any]:
    """A read-only private copy of `values`; `shape` (None for any length) is checked.

    The lock sits on the base of a view, so that `setflags(write=True)` on the result fails too. What is locked already is not
    copied. Raises ValueError when the shape is another one.
    """
    known = _known(values, dtype)
    base = np.array(values, dtype=dtype, order="C", copy=True) if known is None else known
    if shape is not None:
        fits = base.ndim == len(shape) and all(
            want is None or want == got for want, got in zip(shape, base.shape, strict=True)
        )
        if not fits:
            raise ValueError(f"{name} has shape {base.shape}, expected {tuple(shape)}")
    return base.view() if base is known else sealed(base)


def sealed(base: NDArray[Any]) -> NDArray[Any]:
    """A fresh array that its maker gives away, read-only from now on and never copied by `locked`.

    Its memory has to be its own, and no view of it may be left that can be written to.
    """
    base.setflags(write=False)
    _OWN[id(base)] = base
    return base.view()


def _known(values: ArrayLike, dtype: DTypeLike) -> NDArray[Any] | None:
    """The locked array that `values` is all of, as it lies in memory; None where it has to be copied."""
    base = values.base if isinstance(values, np.ndarray) else None
    if not isinstance(values, np.ndarray) or not isinstance(base, np.ndarray) or _OWN.get(id(base)) is not base:
        return None
    same = (
        values.dtype == np.dtype(dtype) == base.dtype and values.shape == base.shape and values.strides == base.strides
    )
    return base if same and base.flags.c_contiguous and not base.flags.writeable else None


def digest(*parts: Any) -> str:
    """Hexadecimal SHA-256 over arrays (bytes, shape and type), strings, numbers and None, in their order."""
    h = hashlib.sha256()
    for part in parts:
        if isinstance(part, np.ndarray):
            h.update(f"array{part.dtype}{part.shape}".encode())
            h.update(np.ascontiguousarray(part).reshape(-1).view(np.uint8).data)  # its bytes, without a copy
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
