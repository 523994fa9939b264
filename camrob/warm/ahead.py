"""Compile all kernels on as many cores as there are, and say how far it is.

Into the library that needs no Numba where the platform has a C compiler, else into Numba's cache.
"""

from __future__ import annotations

import hashlib
import multiprocessing
import os
import platform
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from camrob.machine_code import home, module_name, ready_library
from camrob.text import one_line
from camrob.warm.signatures import Known, known_kernels

__all__ = ["compile_kernel", "left", "main"]

REPORT_EVERY = 5.0  # s between two lines where there is no terminal: often enough to show that it is alive
INTERRUPTED = 130  # as shells have it: 128 and the signal's number
LONGEST = 200  # letters of what a platform's compiler says: its command alone fills a screen
HALF = 0.5  # of each that runs is done, by and large: the dearest begin, and little else ends for long
SHARED_SECONDS = 5.0  # of processor that the C compiler took for what all kernels share


@dataclass(frozen=True, slots=True)
class _Task:
    """A call for another process, and s of processor that it took somewhere."""

    seconds: float
    function: Callable[..., Any]
    arguments: tuple[Any, ...]


def compile_kernel(kernel: Known) -> bool:
    """Compile a kernel, or find it in the cache; returns whether it had to be compiled."""
    dispatcher = kernel.dispatcher()
    dispatcher.compile(kernel.types())
    return bool(dispatcher.stats.cache_misses)


def left(done: float, whole: float, elapsed: float) -> str:
    """How long it will take still, by the share of the work that is done after `elapsed` s; nothing before there is any."""
    return f", about {elapsed * (whole - done) / done:.0f} s left" if done > 0.0 else ""


@contextmanager
def _reporter() -> Iterator[Callable[[str, float], None]]:
    """A hook (what, share of the whole): a bar that moves on a terminal, else a line now and then."""
    if not sys.stderr.isatty():
        last = -REPORT_EVERY

        def line(what: str, share: float) -> None:
            nonlocal last
            if time.monotonic() - last >= REPORT_EVERY or share >= 1.0:
                print(f"camrob: {what}", file=sys.stderr, flush=True)
                last = time.monotonic()

        yield line
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn

    with Progress(BarColumn(), TextColumn("{task.description}"), console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("starting", total=1.0)
        yield lambda what, share: bar.update(task, description=what, completed=share)


def _mark() -> tuple[Path, str] | None:
    """The file that says that Numba's cache holds all kernels, and what it says; None where that folder isn't camrob's own.

    That folder is one for each state of the sources (`camrob.__init__`), so that nothing else can make it untrue than another
    Numba or another machine.
    """
    folder = Path(os.environ.get("NUMBA_CACHE_DIR", ""))
    if not folder.name.startswith("kernels-"):
        return None
    known = hashlib.sha256(repr(known_kernels()).encode()).hexdigest()
    return folder / "ready", f"{known} numba {version('numba')} {platform.node()} {platform.machine()}\n"


def _all_done(tasks: Sequence[_Task]) -> list[Any]:
    """What each task gives, in as many processes as there are cores; the dearest begin."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    whole, done, start = sum(task.seconds for task in tasks), 0.0, time.monotonic()
    pool = ProcessPoolExecutor(
        cores, multiprocessing.get_context("spawn"), initializer=signal.signal, initargs=(signal.SIGINT, signal.SIG_IGN)
    )
    try:
        with _reporter() as report:
            order = sorted(tasks, key=lambda task: -task.seconds)
            running = {pool.submit(task.function, *task.arguments): task for task in order}
            report(f"compiling kernels, once on this machine: {len(tasks)} parts on {cores} cores", 0.0)
            ended: set[int] = set()
            for number, future in enumerate(as_completed(running), 1):
                future.result()
                done += running[future].seconds
                ended.add(id(running[future]))
                begun = sum(task.seconds for task in [t for t in order if id(t) not in ended][:cores])
                gone = left(done + HALF * begun, whole, time.monotonic() - start)
                report(f"part {number} of {len(tasks)}{gone}", done / whole)
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    pool.shutdown()
    given = {id(task): future.result() for future, task in running.items()}
    return [given[id(task)] for task in tasks]


def _library_made(folder: Path) -> bool:
    """Compile all kernels into the library in `folder`; returns whether that could be done."""
    try:
        from camrob.warm.library import compile_object, compile_shared_part, link

        kernels = known_kernels()
        with tempfile.TemporaryDirectory() as scratch:
            place = Path(scratch)
            tasks = [_Task(SHARED_SECONDS, compile_shared_part, (place,))]
            tasks += [_Task(kernel.seconds, compile_object, (kernel, place)) for kernel in kernels]
            shared, *objects = _all_done(tasks)
            link([*shared, *map(str, objects)], [module_name(kernel.kernel, kernel.way) for kernel in kernels], folder)
    except BrokenProcessPool:
        raise
    except Exception as error:  # whatever a platform's compiler raises, or that it has none
        print(
            f"camrob: no library of kernels can be made here ({one_line(str(error), LONGEST)}); Numba's cache will do",
            file=sys.stderr,
        )
        return False
    return True


def main() -> int:
    """Compile what is not there yet. Returns the exit status."""
    mark = _mark()
    if ready_library() is not None or (
        mark is not None and mark[0].is_file() and mark[0].read_text(encoding="utf-8") == mark[1]
    ):
        print("camrob: the kernels are ready", file=sys.stderr)
        return 0
    start, kernels, folder = time.monotonic(), known_kernels(), home()
    try:
        if folder is None or not _library_made(folder):
            _all_done([_Task(kernel.seconds, compile_kernel, (kernel,)) for kernel in kernels])
            if mark is not None:
                mark[0].write_text(mark[1], encoding="utf-8")
    except KeyboardInterrupt:
        print("camrob: interrupted; what is missing will be compiled when it is used", file=sys.stderr)
        return INTERRUPTED
    except BrokenProcessPool:
        print("camrob: a compiling process died; what is missing will be compiled when it is used", file=sys.stderr)
        return 1
    print(f"camrob: {len(kernels)} kernels are ready ({time.monotonic() - start:.0f} s)", file=sys.stderr)
    return 0
