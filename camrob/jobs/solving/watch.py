"""The stages of a job: which one runs, and how long each took."""

from __future__ import annotations

import gc
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from camrob.progress import Progress

__all__ = ["Watch"]


_LARGE_KB = 500_000  # of memory that this process has held at most: a small job's stages leave nothing worth the call


def _give_back() -> None:
    """Give the system back the memory that a large job's stage leaves free between what stays (glibc alone can)."""
    if sys.platform != "linux":
        return
    from resource import RUSAGE_SELF, getrusage

    if getrusage(RUSAGE_SELF).ru_maxrss > _LARGE_KB:
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
        self.seconds: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time one stage."""
        self._name = name
        self.share(0.0)
        start = time.perf_counter()
        yield
        _give_back()
        self.seconds[name] = round(time.perf_counter() - start, 3)

    def share(self, done: float) -> None:
        """How much of the stage is done, 0 to 1."""
        if self._progress is not None:
            self._progress(self._name, done)
