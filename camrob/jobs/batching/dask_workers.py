"""The jobs of a batch on a Dask cluster: files travel with the job and back, so that workers need no shared folder."""

from __future__ import annotations

import hashlib
import importlib.util
import logging
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from uuid import uuid4

from camrob.errors import InputError, JobError
from camrob.jobs.batching.parcel import Parcel, Place, load_parcel, sandbox_path
from camrob.jobs.batching.work import Outcome, lost_job, work
from camrob.jobs.exit_status import failure_line, failure_status
from camrob.jobs.files.output import check_file_name
from camrob.text import printable

__all__ = ["camrob_digest", "do_on_worker", "run_cluster"]

_PATIENCE = 30.0  # s that a scheduler, or a first worker, gets to answer
_REPORT_EVERY = 0.5  # s, between two reports of progress
_AHEAD = 2  # jobs that lie at the scheduler for each that is being done


def run_cluster(
    parcels: Sequence[Parcel], *, address: str, scratch: Path, tell: Callable[[int, str, float], None]
) -> Generator[tuple[Outcome, Path | None, int]]:
    """Do parcels' jobs on the cluster of a scheduler; gives the same as `run_local`, and loses no less.

    A job whose worker is lost is done again by the scheduler, as often as it allows (three times by default). The
    scheduler and its workers are trusted: Dask runs any code that its members send each other. Raises InputError where
    there is no scheduler, no worker within half a minute, or a worker without the same camrob.
    """
    if importlib.util.find_spec("distributed") is None:
        raise InputError("--scheduler needs dask.distributed", hint='install it with: pip install "camrob[cluster]"')
    from distributed import as_completed

    topic = f"camrob-batch-{uuid4().hex}"
    begun = dict.fromkeys((p.index for p in parcels), 0)

    def hear(event: tuple[float, Any]) -> None:
        index, stage, share = event[1]
        if stage:
            tell(index, stage, share)
        else:
            begun[index] += 1

    with _silence(), _connected(address) as client:
        client.subscribe_topic(topic, hear)
        waiting = iter(parcels)
        pending: dict[Any, Parcel] = {}
        done = as_completed(loop=client.loop)
        try:
            room = _AHEAD * sum(client.nthreads().values())
            while True:
                while len(pending) < max(room, 1) and (parcel := next(waiting, None)) is not None:
                    try:
                        contents = load_parcel(parcel)
                    except OSError as error:
                        yield Outcome(parcel.index, failure_status(error), failure_line(error), None, (), 0.0), None, 1
                        continue
                    future = client.submit(do_on_worker, parcel, contents, topic, pure=False)
                    pending[future] = parcel
                    done.add(future)
                if not pending:
                    return
                future = next(done)
                parcel = pending.pop(future)
                outcome, folder = _received(future, parcel, scratch)
                future.release()
                yield outcome, folder, max(begun[parcel.index], 1)
        finally:
            with suppress(Exception):  # a scheduler that is gone has nothing to cancel
                client.cancel(list(pending), force=True)


def camrob_digest() -> str:
    """SHA-256 of the camrob that runs here: its sources, and Python's version."""
    digest = hashlib.sha256(sys.version.encode())
    package = Path(__file__).resolve().parents[2]
    for file in sorted(package.rglob("*.py")):
        digest.update(file.relative_to(package).as_posix().encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()


def do_on_worker(parcel: Parcel, contents: Mapping[Place, bytes], topic: str) -> tuple[Outcome, dict[str, bytes]]:
    """A parcel's job on a Dask worker: the outcome, and its files by name."""
    from distributed import get_worker

    worker = get_worker()
    key = worker.get_current_task()
    last_stage, last = "", 0.0

    def speak(stage: str, share: float) -> None:
        nonlocal last_stage, last
        now = time.monotonic()
        if stage != last_stage or now - last >= _REPORT_EVERY:
            last_stage, last = stage, now
            worker.log_event(topic, (parcel.index, stage, share))
            task = worker.state.tasks.get(key)
            if task is None or task.state == "cancelled":  # Dask itself would let it run to its end
                raise JobError("the batch was interrupted")

    worker.log_event(topic, (parcel.index, "", 0.0))
    # in the worker's own folder: what a killed worker leaves there, Dask clears when the next one starts
    with tempfile.TemporaryDirectory(dir=worker.local_directory, prefix="camrob-") as folder:
        sandbox = Path(folder)
        outcome = work(parcel, sandbox, speak, contents)
        out = sandbox if parcel.out is None else sandbox_path(sandbox, parcel.out)
        return outcome, {name: (out / name).read_bytes() for name in outcome.files}


def _received(future: Any, parcel: Parcel, scratch: Path) -> tuple[Outcome, Path | None]:
    """The outcome of a finished job, and its files laid into a folder here."""
    from distributed import KilledWorker

    try:
        outcome, files = future.result()
    except KilledWorker:
        return lost_job(parcel.index, "its workers were lost, one after the other; is there too little memory?"), None
    except CancelledError:
        return lost_job(parcel.index, "the connection to the scheduler was lost; do this job again"), None
    except Exception as error:
        return lost_job(parcel.index, f"the cluster could not do it ({type(error).__name__}: {_short(error)})"), None
    folder = scratch / str(parcel.index)
    folder.mkdir()
    for name in outcome.files:
        (folder / check_file_name(name)).write_bytes(files[name])
    return outcome, folder


def _short(error: Exception) -> str:
    """What another library says, in one line of printable characters."""
    return " ".join(printable(error).split())[:200]


@contextmanager
def _connected(address: str) -> Iterator[Any]:
    """A client of the scheduler, its workers found fit. Raises InputError."""
    from distributed import Client

    try:
        client = Client(address, timeout=_PATIENCE, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        what = f"--scheduler {address!r} does not answer ({type(error).__name__})"
        raise InputError(what, hint="give an address such as tcp://host:8786, and see that it runs") from None
    try:
        try:
            client.wait_for_workers(1, timeout=_PATIENCE)
        except OSError:  # TimeoutError is one
            hint = f"start one with: dask worker {address} --nthreads 1"
            raise InputError(f"--scheduler {address!r} has no worker", hint=hint) from None
        mine = camrob_digest()
        for worker, theirs in client.run(camrob_digest, on_error="return").items():
            if theirs != mine:
                has = "another camrob or Python than this" if isinstance(theirs, str) else "no camrob that runs"
                raise InputError(f"worker {worker} has {has}", hint="install the same there, or stop that worker")
        yield client
    finally:
        with suppress(Exception):  # closing what is broken
            client.close(timeout=_PATIENCE / 10.0)


@contextmanager
def _silence() -> Iterator[None]:
    """While it lasts, Dask's own log and warnings are kept off the terminal: what matters comes back as an outcome."""
    names = ["distributed", *(n for n in logging.root.manager.loggerDict if n.startswith("distributed."))]
    before = {name: logging.getLogger(name).level for name in names}
    for name in names:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            yield
        finally:
            for name, level in before.items():
                logging.getLogger(name).setLevel(level)
