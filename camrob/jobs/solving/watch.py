"""The stages of a job: which one runs, and how long each took."""

from __future__ import annotations

import gc
import mmap
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from camrob.progress import Progress

__all__ = ["Watch"]


_LARGE = 500_000_000  # bytes that a job has taken so far: a small job's stages leave nothing worth the call


def _held() -> int:
    """Bytes of memory that this process holds now; 0 where the system doesn't tell."""
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    except (OSError, ValueError, IndexError):
        return 0
    return pages * mmap.PAGESIZE


def _give_back() -> None:
    """Give the system back the memory that a large job's stage leaves free between what stays (glibc alone can)."""
    from ctypes import CDLL

    gc.collect()  # what objects hold in rings
    trim = getattr(CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)


class Watch:
    """Names the stage that runs to whoever shows progress, and keeps how long each took."""

    def __init__(self, progress: Progress | None) -> None:
        self._progress = progress
        self._name = ""
        self._begun = _held()
        self.seconds: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time one stage."""
        self._name = name
        self.share(0.0)
        start = time.perf_counter()
        yield
        if _held() - self._begun > _LARGE:
            _give_back()
        self.seconds[name] = round(time.perf_counter() - start, 3)

    def share(self, done: float) -> None:
        """How much of the stage is done, 0 to 1."""
        if self._progress is not None:
            self._progress(self._name, done)
