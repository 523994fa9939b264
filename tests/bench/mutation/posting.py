"""One job posted in this process: what came of it, as bytes or as the error that stood against it."""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mutation import cells
from mutation.jobs import Job


@dataclass(frozen=True)
class Outcome:
    """status: `released`, `refused`, `crashed`, or `same`: the bytes that were expected were written, and nothing was asked
    of them any more. files: what was released; written: what the writer had written at last.

    left: names of program files that lie in the folder after a refusal. solved: degrees of A1 .. A6 (N, 6) at the file's points.
    """

    status: str
    files: Mapping[str, bytes] = field(default_factory=dict)
    written: Mapping[str, bytes] = field(default_factory=dict)
    error: str = ""
    left: tuple[str, ...] = ()
    seconds: float = 0.0
    said: str = ""
    solved: NDArray[np.float64] | None = None


class Bench:
    """Folders of cells and jobs, and where programs come out."""

    def __init__(self, root: Path, jobs: Mapping[str, Job]) -> None:
        self.root = root
        self.jobs = dict(jobs)
        self.cell: dict[str, Path] = {}
        self.files: dict[str, Path] = {}
        for job in self.jobs.values():
            if job.cell not in self.cell:
                self.cell[job.cell] = cells.write_cell(job.cell, root / "cells" / job.cell)
            self.files[job.name] = job.write(root / "in" / job.name)

    def run(self, name: str, out: Path, expected: Mapping[str, bytes] | None = None) -> Outcome:
        """Post a job into a folder of its own, which is gone afterwards.

        expected: it ends as `same` as soon as these bytes have been written: released or refused, no wrong program comes of them.
        """
        from camrob import post
        from camrob.errors import CamrobError

        job = self.jobs[name]
        started = time.perf_counter()
        written: dict[str, bytes] = {}
        before: set[str] = set()
        shutil.rmtree(out, ignore_errors=True)
        try:
            if job.before:
                first = self.jobs[job.before]
                post(self.files[job.before], cell=self.cell[first.cell], out=out, report=False, **first.options)
                before = {f.name for f in out.iterdir()}
            with _noted(written, expected):
                made = post(self.files[name], cell=self.cell[job.cell], out=out, report=False, **job.options)
            files = {f.name: f.read_bytes() for f in sorted(out.iterdir()) if f.suffix in (".src", ".dat")}
            said = ",".join(w.code for w in made.summary.warnings)
            path = next(name for name in made.files if name.endswith(".path.npz"))
            solved = np.load(out / path)["axis_values"][:, :6]
            return Outcome("released", files, written, seconds=time.perf_counter() - started, said=said, solved=solved)
        except _SameBytes:
            return Outcome("same", seconds=time.perf_counter() - started)
        except CamrobError as error:
            status, text = "refused", f"{type(error).__name__}: {error}"
        except MemoryError:
            status, text = "refused", "MemoryError"
        except Exception as error:
            status, text = "crashed", f"{type(error).__name__}: {error}"
        left = (
            tuple(f.name for f in out.iterdir() if f.suffix == ".src" and f.name not in before) if out.is_dir() else ()
        )
        return Outcome(status, {}, written, text[:300], left, time.perf_counter() - started)


class _SameBytes(BaseException):
    """A job has come as far as it need to; nothing of camrob's catches it."""


@contextmanager
def _noted(written: dict[str, bytes], expected: Mapping[str, bytes] | None) -> Iterator[None]:
    """Keep what is written into program files, also where it is taken away again.

    Raises _SameBytes where all of a program has been written, it is `expected`, and its checks would begin.
    """
    from camrob.jobs.release import attempt

    real, checks = Path.write_bytes, attempt.read_back

    def write_bytes(self: Path, data: Any) -> int:
        if self.suffix in (".src", ".dat"):
            if self.suffix == ".dat" or self.name in written:
                written.pop(self.name, None)
            written[self.name] = bytes(data)
        return real(self, data)

    def read_back(*arguments: Any, **named: Any) -> Any:
        if written == expected:
            raise _SameBytes
        return checks(*arguments, **named)

    Path.write_bytes = write_bytes  # type: ignore[method-assign]
    attempt.read_back = read_back
    try:
        yield
    finally:
        Path.write_bytes = real  # type: ignore[method-assign]
        attempt.read_back = checks
