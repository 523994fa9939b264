"""The stages of a job: which one runs, and how long each took."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

from camrob.progress import Progress

__all__ = ["Watch"]


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
        self.seconds[name] = round(time.perf_counter() - start, 3)

    def share(self, done: float) -> None:
        """How much of the stage is done, 0 to 1."""
        if self._progress is not None:
            self._progress(self._name, done)
