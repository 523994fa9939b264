"""What scikit-fuzzy said of an engine, kept in the user's cache: to import it takes longer than to post a small part."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import tempfile
import zipfile
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.machine_code import cache_folder

__all__ = ["kept"]

MOST_FILES = 32  # of half a megabyte each, or so: more engines than somebody works with


def kept(
    what: str, system: object, make: Callable[[], tuple[NDArray[np.float64], ...]]
) -> tuple[NDArray[np.float64], ...]:
    """The arrays that `make` gives for a fuzzy system, whose repr holds all of it; made anew only where they aren't kept.

    They are kept for the same system, question (`what`), code of this folder and scikit-fuzzy alone. Raises what `make` raises,
    and then keeps nothing.
    """
    key = hashlib.sha256(f"{what}\0{_judges()}\0{system!r}".encode()).hexdigest()
    file = cache_folder() / "fuzzy" / f"{key[:32]}.npz"
    try:
        with np.load(file, allow_pickle=False) as arrays:
            return tuple(arrays[name] for name in arrays.files)
    except (OSError, ValueError, EOFError, zipfile.BadZipFile):
        made = make()  # it isn't there, or was cut off
    with contextlib.suppress(OSError):  # nowhere to write: made again next time
        _keep(file, made)
    return made


def _keep(file: Path, arrays: tuple[NDArray[np.float64], ...]) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=file.parent, suffix=".part", delete=False) as scratch:
        try:
            np.savez(scratch, *arrays)
            scratch.flush()
            os.replace(scratch.name, file)
        finally:
            Path(scratch.name).unlink(missing_ok=True)
    files = sorted(file.parent.glob("*.npz"), key=lambda other: other.stat().st_mtime)
    for old in files[:-MOST_FILES]:
        old.unlink(missing_ok=True)


@functools.cache
def _judges() -> str:
    """Who judges: the code of this folder, and scikit-fuzzy's version."""
    code = hashlib.sha256()
    for file in sorted(Path(__file__).parent.glob("*.py")):
        code.update(file.read_bytes())
    return f"{code.hexdigest()} {version('scikit-fuzzy')}"
