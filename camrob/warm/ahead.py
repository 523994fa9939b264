"""Compile all kernels into the cache, on as many cores as there are, and say how far it is."""

from __future__ import annotations

import hashlib
import multiprocessing
import os
import platform
import signal
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path

from camrob.warm.signatures import Known, known_kernels

__all__ = ["compile_kernel", "left", "main"]

REPORT_EVERY = 5.0  # s between two lines where there is no terminal: often enough to show that it is alive
INTERRUPTED = 130  # as shells have it: 128 and the signal's number


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
    """The file that says that all kernels were compiled, and what it says; None where the cache's folder isn't camrob's own.

    That folder is one for each state of the sources (`camrob.__init__`), so that nothing else can make it untrue than another
    Numba or another machine.
    """
    folder = Path(os.environ.get("NUMBA_CACHE_DIR", ""))
    if not folder.name.startswith("kernels-"):
        return None
    known = hashlib.sha256(repr(known_kernels()).encode()).hexdigest()
    return folder / "ready", f"{known} numba {version('numba')} {platform.node()} {platform.machine()}\n"


def main() -> int:
    """Compile what is not in the cache yet; the dearest kernels first. Returns the exit status."""
    mark = _mark()
    if mark is not None and mark[0].is_file() and mark[0].read_text(encoding="utf-8") == mark[1]:
        print("camrob: the kernels are ready", file=sys.stderr)
        return 0
    kernels = sorted(known_kernels(), key=lambda kernel: -kernel.seconds)
    whole, done, compiled, start = sum(kernel.seconds for kernel in kernels), 0.0, 0, time.monotonic()
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    pool = ProcessPoolExecutor(
        cores, multiprocessing.get_context("spawn"), initializer=signal.signal, initargs=(signal.SIGINT, signal.SIG_IGN)
    )
    try:
        with _reporter() as report:
            running = {pool.submit(compile_kernel, kernel): kernel for kernel in kernels}
            report(f"compiling kernels, once on this machine: {len(kernels)} on {cores} cores", 0.0)
            for number, future in enumerate(as_completed(running), 1):
                compiled += future.result()
                done += running[future].seconds
                rest = left(done, whole, time.monotonic() - start)
                report(f"kernel {number} of {len(kernels)}{rest}", done / whole)
    except KeyboardInterrupt:
        print("camrob: interrupted; what was compiled is kept", file=sys.stderr)
        pool.shutdown(wait=False, cancel_futures=True)
        return INTERRUPTED
    except BrokenProcessPool:
        print("camrob: a compiling process died; what is missing will be compiled when it is used", file=sys.stderr)
        return 1
    pool.shutdown()
    took = time.monotonic() - start
    if mark is not None:
        mark[0].write_text(mark[1], encoding="utf-8")
    print(f"camrob: {len(kernels)} kernels are ready ({compiled} compiled, {took:.0f} s)", file=sys.stderr)
    return 0
