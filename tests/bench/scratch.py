"""What benches that try many small jobs run in: one thread a process, and a folder in memory that goes away."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

__all__ = ["one_thread", "scratch_folder"]

_MEMORY = Path("/dev/shm")


def one_thread() -> None:
    """Before numerical libraries are imported: one thread, unless the caller's environment says otherwise."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")


@contextmanager
def scratch_folder(prefix: str) -> Iterator[Path]:
    """A folder, in memory where that can be written."""
    folder = Path(tempfile.mkdtemp(prefix=prefix, dir=_MEMORY if os.access(_MEMORY, os.W_OK) else None))
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
