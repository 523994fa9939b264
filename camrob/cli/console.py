"""What every verb of the command line shares: exit status, one-line errors, JSON, progress, interruption.

The contract: status 0 done, 1 a check failed, 2 the command line or an input is wrong, 3 the job can't be done safely.
An interruption ends with 130, a request to terminate with 143, a terminal that goes away with 129, as shells expect.
"""

from __future__ import annotations

import importlib
import json
import os
import signal
import sys
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from camrob.compiling import reporting_compiles
from camrob.errors import CellError, InputError
from camrob.jobs.exit_status import CHECK_FAILED, DONE, INPUT_WRONG, disk_full, failure_line, failure_status
from camrob.progress import Progress, silent
from camrob.summaries.base import Summary

if TYPE_CHECKING:
    from rich.console import RenderableType

__all__ = [
    "JobResult",
    "Terminated",
    "error_line",
    "exit_status",
    "job_of",
    "perform",
    "renderer",
    "terminable",
]

COMPILING = "compiling what was not made ahead (`python -m camrob.warm` makes the usual kernels), once on this machine"
INTERRUPTED = 130  # as shells have it: 128 and the signal's number
ENDED_BY_SIGNAL = 128  # and the signal's number
ASKED_TO_END = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name))


class JobResult(Protocol):
    """What a job returns: its `summary`."""

    @property
    def summary(self) -> Summary:
        """What the command says of it."""
        ...


R = TypeVar("R", bound=JobResult)


class Terminated(KeyboardInterrupt):
    """Another program asked this one to end (SIGTERM), or its terminal went away (SIGHUP)."""

    def __init__(self, number: int = signal.SIGTERM) -> None:
        super().__init__(number)
        self.number = number


def exit_status(error: BaseException) -> int:
    """The status that an error ends a command with; the only place that knows."""
    if isinstance(error, Terminated):
        return ENDED_BY_SIGNAL + error.number
    if isinstance(error, KeyboardInterrupt):
        return INTERRUPTED
    return failure_status(error)


def error_line(error: BaseException) -> str:
    """What the user reads, in one line of printable characters."""
    if isinstance(error, KeyboardInterrupt):
        return "interrupted; no unfinished file was left"
    return failure_line(error)


def perform(
    job: Callable[[Progress], R],
    *,
    as_json: bool,
    quiet: bool,
    render: Callable[[Any], RenderableType],
    holds: Callable[[R], bool] = lambda result: True,
    status: Callable[[R], int] | None = None,
) -> int:
    """Run a job, print its result, and give the exit status.

    `render` makes the result readable for a person; `holds` says whether what the command checks came true,
    or `status` what the command ends with.
    With CAMROB_DEBUG set in the environment, an error shows its traceback first.
    """
    try:
        with terminable(), _progress(quiet) as hook:
            result = job(hook)
        text = json.dumps(result.summary.to_json(), indent=2, allow_nan=False) if as_json else None
    except (Exception, KeyboardInterrupt) as error:
        if os.environ.get("CAMROB_DEBUG"):
            traceback.print_exc()
        print(f"camrob: {error_line(error)}" if _placeless(error) else error_line(error), file=sys.stderr)
        return exit_status(error)
    try:
        if text is not None:
            _write(text)
        elif not quiet:
            _show(render(result.summary))
    except OSError as error:
        why = "disk full" if disk_full(error) else error.strerror or "input or output failed"
        line = f"the job is done, but its summary can't be printed ({why}); send standard output elsewhere"
        print(f"camrob: {line}", file=sys.stderr)
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return INPUT_WRONG
    if status is not None:
        return status(result)
    return DONE if holds(result) else CHECK_FAILED


def _placeless(error: BaseException) -> bool:
    """True where the line doesn't begin with the file that it is about."""
    return not (isinstance(error, InputError) and error.path is not None)


@contextmanager
def terminable() -> Iterator[None]:
    """While it lasts, SIGTERM and SIGHUP raise `Terminated`, so that cleaning up happens as for an interruption."""

    def stop(number: int, frame: FrameType | None) -> None:
        raise Terminated(number)

    try:
        before = {number: signal.signal(number, stop) for number in ASKED_TO_END}
    except ValueError:  # not the main thread: whoever runs it there looks after signals
        yield
        return
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def _progress(quiet: bool) -> Iterator[Progress]:
    """A hook `(what, share of the whole)` that moves a bar on standard error; idle where nobody would see the bar.

    That kernels compile is said anywhere but under --quiet: in the bar, or else in one line at the first of them.
    """
    if quiet:
        yield silent
        return
    if not sys.stderr.isatty():
        with reporting_compiles(_Once()):
            yield silent
        return
    from rich.console import Console
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar

    columns = (TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn())
    with Bar(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("starting", total=1.0)

        def compiling(kernel: str) -> None:
            bar.update(task, description=f"compiling {kernel}, once on this machine")

        with reporting_compiles(compiling):
            yield lambda what, share: bar.update(task, description=what, completed=min(max(share, 0.0), 1.0))


class _Once:
    """Says once that kernels compile."""

    def __init__(self) -> None:
        self._said = False

    def __call__(self, kernel: str) -> None:
        if not self._said:
            self._said = True
            print(f"camrob: {COMPILING}", file=sys.stderr, flush=True)


def _show(what: RenderableType) -> None:
    """A renderable on standard output."""
    from rich.console import Console

    console = Console(highlight=False)
    with console.capture() as capture:
        console.print(what, crop=False)
    _write("\n".join(line.rstrip() for line in capture.get().rstrip("\n").split("\n")))


def _write(text: str) -> None:
    """Text on standard output; a reader that has gone away (`| head`) is no error, for the job is done."""
    try:
        print(text, flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def job_of(verb: str) -> Callable[..., Any]:
    """The job behind a verb: the function of the verb's name in `camrob/jobs/<verb>.py`, imported when it
    is called ("studies.weld" stands a folder deeper).

    Paths of inputs that don't exist are refused before that: to import a job takes ten times as long.
    """
    module = f"camrob.jobs.{verb}"

    def job(*inputs: Any, **options: Any) -> Any:
        if module not in sys.modules:
            _refuse_missing(inputs, options)
        return getattr(importlib.import_module(module), verb.rpartition(".")[2])(*inputs, **options)

    return job


def _refuse_missing(inputs: tuple[Any, ...], options: Mapping[str, Any]) -> None:
    """Raise CellError or InputError for the first input that is not there."""
    cell = options.get("cell")
    if isinstance(cell, Path) and not cell.exists():
        raise CellError("can't be read: no such file or directory", hint="check the path", path=cell)
    for given in (*inputs, *(options.get(name) for name in ("setup", "against", "log"))):
        for path in given if isinstance(given, list | tuple) else (given,):
            if isinstance(path, Path) and not path.exists():
                windows = "\\" in str(path) and os.sep == "/"
                hint = "write its folders with /, as this system does" if windows else "check the path"
                raise InputError("can't be read: no such file or directory", hint=hint, path=path)


def renderer(module: str, name: str) -> Callable[[Any], Any]:
    """What a verb shows a person; what draws it is imported when it is needed."""
    return lambda summary: getattr(importlib.import_module(f"camrob.report.{module}"), name)(summary)
