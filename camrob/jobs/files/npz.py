"""Arrays out of a .npz file of whatever origin: never an object, never more than a path needs."""

from __future__ import annotations

import struct
import warnings
import zlib
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, ZipFile

import numpy as np
from numpy.typing import NDArray

from camrob.errors import InputError

__all__ = ["read_arrays"]

_LARGEST_BYTES = 1 << 30  # unpacked: a path of ten million points

_DAMAGED = (
    OSError,
    ValueError,
    KeyError,
    EOFError,
    TypeError,
    IndexError,
    SyntaxError,
    OverflowError,
    MemoryError,
    RecursionError,
    BadZipFile,
    zlib.error,
    struct.error,
    RuntimeError,  # locked by a password, or packed by a method that is not known
)


def read_arrays(path: Path, *names: str, hint: str) -> list[NDArray[Any]]:
    """The arrays of those names. Raises InputError, naming the file, where it isn't a .npz that holds them plainly."""
    try:
        with ZipFile(path) as packed:
            if sum(member.file_size for member in packed.infolist()) > _LARGEST_BYTES:
                raise InputError("would unpack to more than 1024 MiB", hint=hint, path=path)
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # a header of a kind that only old programs wrote
            with np.load(path, allow_pickle=False) as data:
                return [np.asarray(data[name]) for name in names]
    except (*_DAMAGED, Warning):
        raise InputError("is not a solved path", hint=hint, path=path) from None
