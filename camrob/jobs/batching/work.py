"""One job of a batch, done where it was sent to: files laid out, the verb's function called, its outcome reported."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from camrob.jobs.batching.parcel import Parcel, Place, sandbox_path, unpack_parcel
from camrob.jobs.batching.verbs import job_function
from camrob.jobs.exit_status import CHECK_FAILED, DONE, NOT_SAFE, failure_line, failure_status
from camrob.progress import Progress

__all__ = ["Outcome", "lost_job", "work"]


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of a job: its status as the contract has it, the error's line, the summary, and names of files."""

    index: int
    status: int
    error: str | None
    summary: Mapping[str, Any] | None
    files: tuple[str, ...]
    seconds: float


def lost_job(index: int, why: str) -> Outcome:
    """The outcome of a job that could not be brought to an end."""
    return Outcome(index, NOT_SAFE, why, None, (), 0.0)


def work(
    parcel: Parcel,
    sandbox: Path,
    progress: Progress,
    contents: Mapping[Place, bytes] | None = None,
) -> Outcome:
    """Do a parcel's job in an empty folder; the files that it makes lie at `sandbox_path(sandbox, parcel.out)`.

    Never raises for what is wrong with the job: that is its outcome.
    """
    start = time.perf_counter()
    try:
        arguments = unpack_parcel(parcel, sandbox, contents)
        before = _files(parcel, sandbox)
        result = job_function(parcel.verb)(**arguments, progress=progress)
        summary = json.loads(json.dumps(result.summary.to_json(), allow_nan=False))
        made = tuple(sorted(n for n, mark in _files(parcel, sandbox).items() if before.get(n) != mark))
        status = DONE if getattr(result, "ok", True) else CHECK_FAILED
        return Outcome(parcel.index, status, None, summary, made, round(time.perf_counter() - start, 3))
    except Exception as error:
        line = _at_home(failure_line(error), parcel, sandbox)
        seconds = round(time.perf_counter() - start, 3)
        return Outcome(parcel.index, failure_status(error), line, None, (), seconds)


def _files(parcel: Parcel, sandbox: Path) -> dict[str, tuple[int, int]]:
    """The files in the job's output folder, each with a mark that tells a new one."""
    folder = None if parcel.out is None else sandbox_path(sandbox, parcel.out)
    if folder is None or not folder.is_dir():
        return {}
    return {f.name: (f.stat().st_ino, f.stat().st_mtime_ns) for f in folder.iterdir() if f.is_file()}


def _at_home(line: str, parcel: Parcel, sandbox: Path) -> str:
    """A line that names files as the user does, not as they are called in the sandbox."""
    for place, name in sorted(parcel.shown, key=lambda known: -len(known[0].parts)):
        line = line.replace(str(sandbox_path(sandbox, place)), name)
    return line.replace(str(sandbox / "root"), "").replace(str(sandbox), "")
