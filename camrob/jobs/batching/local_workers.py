"""The jobs of a batch on this machine: worker processes, each with one job at a time.

Not a pool of the standard library: there, one process that dies takes all other jobs with it, and nobody can tell
which job it was.
"""

from __future__ import annotations

import multiprocessing
import os
import shutil
import signal
import time
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from pathlib import Path

from camrob.jobs.batching.parcel import Parcel, sandbox_path
from camrob.jobs.batching.work import Outcome, lost_job, work
from camrob.progress import Progress

__all__ = ["cores", "run_local"]

_ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
_ATTEMPTS = 2
_REPORT_EVERY = 0.1  # s, between two reports of progress
_PATIENCE = 5.0  # s that a worker gets to end


def cores() -> int:
    """The cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@dataclass(slots=True)
class _Worker:
    """A process, our end of its pipe, and what it does."""

    process: SpawnProcess
    pipe: Connection
    parcel: Parcel | None = None
    sandbox: Path = field(default_factory=Path)


def run_local(
    parcels: Sequence[Parcel], *, workers: int, scratch: Path, tell: Callable[[int, str, float], None]
) -> Generator[tuple[Outcome, Path | None, int]]:
    """Do parcels' jobs; gives the outcome, the folder with its files, and how often it was begun, as they come.

    A job whose worker dies is done once more, in a new worker; should that die as well, the job is lost. The folder
    lasts until the next outcome is asked for. Whoever closes the iterator ends the workers, whatever they do.
    """
    waiting = deque(parcels)
    begun = dict.fromkeys((p.index for p in parcels), 0)
    crew: list[_Worker] = []
    try:
        while waiting or any(w.parcel is not None for w in crew):
            _hand_out(waiting, crew, begun, min(workers, len(parcels)), scratch)
            ready = wait([w.pipe for w in crew if w.parcel is not None])
            for worker in [w for w in crew if w.pipe in ready]:
                outcome = _heard(worker, crew, waiting, begun, tell)
                if outcome is None:
                    continue
                parcel, sandbox, worker.parcel = worker.parcel, worker.sandbox, None
                folder = None if parcel is None or parcel.out is None else sandbox_path(sandbox, parcel.out)
                yield outcome, folder, begun[outcome.index]
                shutil.rmtree(sandbox, ignore_errors=True)
    finally:
        _end(crew)


def _hand_out(waiting: deque[Parcel], crew: list[_Worker], begun: dict[int, int], workers: int, scratch: Path) -> None:
    """Give waiting jobs to idle workers, new ones where there may be more."""
    while waiting:
        worker = next((w for w in crew if w.parcel is None), None)
        if worker is None:
            if len(crew) >= workers:
                return
            worker = _start()
            crew.append(worker)
        parcel = waiting.popleft()
        sandbox = scratch / f"{parcel.index}-{begun[parcel.index]}"
        sandbox.mkdir()
        begun[parcel.index] += 1
        worker.parcel, worker.sandbox = parcel, sandbox
        with suppress(OSError):  # a worker that died while it was idle: its silence is heard like any other's
            worker.pipe.send((parcel, sandbox))


def _heard(
    worker: _Worker,
    crew: list[_Worker],
    waiting: deque[Parcel],
    begun: dict[int, int],
    tell: Callable[[int, str, float], None],
) -> Outcome | None:
    """What a worker says, where it is the outcome; progress is passed on, a dead worker's job queued again."""
    parcel = worker.parcel
    if parcel is None:
        return None
    try:
        said = worker.pipe.recv()
    except (EOFError, OSError):
        crew.remove(worker)
        _end([worker])
        if begun[parcel.index] >= _ATTEMPTS:
            code = worker.process.exitcode
            how = f"signal {-code}" if code is not None and code < 0 else f"status {code}"
            why = f"its worker died {_ATTEMPTS} times ({how}); is there too little memory? try --workers 1"
            return lost_job(parcel.index, why)
        shutil.rmtree(worker.sandbox, ignore_errors=True)
        waiting.appendleft(parcel)
        return None
    if isinstance(said, Outcome):
        return said
    tell(parcel.index, *said)
    return None


def _start() -> _Worker:
    """A new worker."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_work_for, args=(theirs,), daemon=True)
    with _one_thread(), _deaf():
        process.start()
    theirs.close()
    return _Worker(process, ours)


def _end(crew: list[_Worker]) -> None:
    """End workers, whatever they do: what they write lies in sandboxes."""
    for worker in crew:
        worker.process.terminate()
        worker.pipe.close()
    for worker in crew:
        worker.process.join(_PATIENCE)
        if worker.process.exitcode is None:
            worker.process.kill()
            worker.process.join(_PATIENCE)


@contextmanager
def _one_thread() -> Iterator[None]:
    """While it lasts, new processes start with one thread each: the cores are all taken by jobs."""
    before = {key: os.environ.get(key) for key in _ONE_THREAD}
    os.environ.update(dict.fromkeys(_ONE_THREAD, "1"))
    try:
        yield
    finally:
        for key, value in before.items():
            if value is None:
                os.environ.pop(key, None)
            else:
                os.environ[key] = value


@contextmanager
def _deaf() -> Iterator[None]:
    """While it lasts, new processes are born deaf to an interruption from the keyboard: it is ours to end them."""
    try:
        before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    except ValueError:  # not the main thread, which alone may do this
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _work_for(pipe: Connection) -> None:
    """A worker's life: jobs from a pipe until it closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    with suppress(EOFError, OSError):  # the other end is gone: nobody waits for us any more
        while True:
            parcel, sandbox = pipe.recv()
            pipe.send(work(parcel, sandbox, _reporter(pipe)))


def _reporter(pipe: Connection) -> Progress:
    """A progress hook that speaks through a pipe, not too often."""
    last_stage, last = "", 0.0

    def report(stage: str, share: float) -> None:
        nonlocal last_stage, last
        now = time.monotonic()
        if stage != last_stage or now - last >= _REPORT_EVERY:
            last_stage, last = stage, now
            pipe.send((stage, share))

    return report
