"""Runs mutants: a warm process forks a child for each, the child posts the jobs that go through the changed line."""

from __future__ import annotations

import fcntl
import gc
import hashlib
import json
import os
import pickle
import resource
import select
import shutil
import signal
import struct
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mutation.apply import CannotApplyError, Package, apply, beneath_cache, forget_caches, interpret, touched_kernels
from mutation.classify import Baseline, Result, classify
from mutation.coverage import Coverage, Kept, reach, traced
from mutation.draw import Mutant, short
from mutation.posting import Bench, Outcome

CPU_SECONDS, WALL_SECONDS = 4, 90  # of one job in a child
MEMORY = 4 << 30
COSTLY = 0.9  # s: a job that takes longer runs only where few others do
FEW = 2
AFTERWARDS = ("camrob.jobs.files.output",)  # what may change a program after it was written
QUICK = 0.1  # s: a job that is refused while it is read


@dataclass
class Warm:
    """All that a forked child needs."""

    package: Package
    bench: Bench
    baselines: dict[str, Baseline]
    coverage: dict[str, Coverage]
    seed: int
    most: int
    only: dict[str, list[str]] = field(
        default_factory=dict
    )  # of a mutant's key: the jobs it runs on, where they are given
    does: dict[str, str] = field(default_factory=dict)  # of a mutant's key: what it has to do, where that is given
    interpreted: dict[frozenset[str], dict[str, Baseline]] = field(default_factory=dict)


def warm_up(
    package: Package, bench: Bench, say: Callable[[str], None], *, trace: bool = True, kept: Path | None = None
) -> tuple[dict[str, Baseline], dict[str, Coverage], dict[str, str]]:
    """Every job once to warm up and once more traced: baselines, coverage, and why a job can't be used.

    kept: a file for the coverage, which serves as long as the sources are the same.
    """
    baselines, coverage, unfit = {}, {}, {}
    known = Kept(package, kept)
    for name in bench.jobs:
        out = bench.root / "warm" / name
        bench.run(name, out)
        found: list[Outcome] = []
        second = bench.run(name, out)

        def again(out: Path = out, name: str = name, found: list[Outcome] = found) -> None:
            found.append(bench.run(name, out))

        if trace:
            coverage[name] = known.get(bench.jobs[name]) or known.put(bench.jobs[name], traced(package, again))
        else:
            again()
        baseline = Baseline.of(bench.jobs[name], second)
        if found and (found[0].files != second.files or found[0].status != second.status):
            unfit[name] = "comes out in two ways"
        elif baseline.unfit:
            unfit[name] = baseline.unfit
        else:
            baselines[name] = baseline
        say(f"{name:22s} {second.status} {second.seconds:.2f} s {unfit.get(name, '')}")
        shutil.rmtree(out, ignore_errors=True)
    known.save()
    for name in baselines if trace else ():  # tracing emptied the caches
        bench.run(name, bench.root / "warm" / name)
    return baselines, coverage, unfit


def jobs_for(warm: Warm, mutant: Mutant) -> list[str]:
    """The jobs that a mutant runs on: some that must come out, some that must not, turned about by its key."""
    if mutant.key in warm.only:
        return [n for n in warm.only[mutant.key] if n in warm.baselines]
    fit = [n for n in reach(warm.package, mutant, warm.coverage) if n in warm.baselines]
    kernels = touched_kernels(warm.package, mutant)  # what runs uncompiled runs on the same jobs each time
    by = ",".join(sorted(kernels)) or mutant.key
    turn = int(hashlib.sha256(f"{warm.seed}:{by}".encode()).hexdigest(), 16)

    def turned(names: list[str]) -> list[str]:
        k = turn % len(names) if names else 0
        return names[k:] + names[:k]

    made = turned([n for n in fit if not warm.bench.jobs[n].refuse])
    cheap = [n for n in made if warm.baselines[n].seconds <= COSTLY]
    if len(cheap) >= FEW or len(cheap) == len(made):
        made = cheap
    else:
        made = cheap + [n for n in made if n not in cheap][: FEW - len(cheap)]
    never = turned([n for n in fit if warm.bench.jobs[n].refuse])
    quick = [n for n in never if warm.baselines[n].seconds <= QUICK]
    slow = [n for n in never if n not in quick]
    return (
        made[: min(warm.most, FEW) if kernels else warm.most]
        + quick[: warm.most]
        + slow[: warm.most if _of_checks(mutant) else _others(mutant)]
    )


def _of_checks(mutant: Mutant) -> bool:
    """Whether a mutant may blind what refuses an unsafe job late."""
    return any(part in mutant.module for part in (".check", ".release", ".judge", ".failure", ".margins", ".replay"))


def _others(mutant: Mutant) -> int:
    """Of how many slow jobs that must be refused a mutant elsewhere is tried: the witness knows nothing of bodies."""
    return 1 if any(part in mutant.module for part in (".cell.", ".kinematics.", ".jobs.", ".se3")) else 0


def run_mutant(warm: Warm, mutant: Mutant) -> Result:
    """What becomes of a mutant."""
    started = time.perf_counter()
    names = jobs_for(warm, mutant)
    result = Result(mutant.key, mutant.module, mutant.name, mutant.operator, mutant.lines[0])
    if not names:
        result.outcome = "unreached"
        return result
    kernels = touched_kernels(warm.package, mutant)
    baselines = _uncompiled(warm, kernels, names, mutant) if kernels else warm.baselines
    names = [n for n in names if n in baselines]
    if kernels and not names:
        result.outcome = "inapplicable"
        return result

    def work(send: Callable[[Any], None]) -> None:
        try:
            send(("what", apply(warm.package, mutant)))
        except CannotApplyError as error:
            send(("cannot", str(error)))
            return
        _post_all(warm, names, send, {} if mutant.module in AFTERWARDS else baselines)

    first = sum(not warm.bench.jobs[n].refuse for n in names[:FEW])
    done = 0
    for message in _forked(work, len(names)):
        if message[0] == "what":
            result.what = message[1]
            if warm.does.get(mutant.key, "") not in ("", short(f"{mutant.operator}: {result.what}")):
                result.outcome = "gone"
                break
        elif message[0] == "cannot":
            result.outcome, result.what = "inapplicable", message[1]
        elif message[0] == "lost":
            result.note("hang", "", message[1])
        else:
            _, name, outcome = message
            if classify(result, warm.bench.jobs[name], baselines[name], outcome):
                break
            done += 1
            rest = [n for n in names[done:] if not warm.bench.jobs[n].refuse]
            if done >= first and not result.shown and len(rest) == len(names) - done:
                break  # it shows on none of the first: more of them are tried only where it does
    result.seconds = round(time.perf_counter() - started, 2)
    result.settle()
    return result


def _post_all(
    warm: Warm, names: Iterable[str], send: Callable[[Any], None], known: Mapping[str, Baseline] | None = None
) -> None:
    """Jobs one after the other; those of `known` baselines only as far as they differ from these."""
    for name in names:
        expected = known[name].files or None if known and name in known else None
        most = CPU_SECONDS + int(10.0 * known[name].seconds) if known and name in known else 3 * CPU_SECONDS
        soft = int(resource.getrusage(resource.RUSAGE_SELF).ru_utime) + most
        resource.setrlimit(resource.RLIMIT_CPU, (soft, resource.RLIM_INFINITY))
        send(("job", name, warm.bench.run(name, warm.bench.root / "out" / str(os.getpid()), expected)))


def _uncompiled(warm: Warm, kernels: frozenset[str], names: list[str], mutant: Mutant) -> Mapping[str, Baseline]:
    """Baselines with those kernels uncompiled: their last digits may differ."""
    known = warm.interpreted.setdefault(kernels, {})
    missing = [n for n in names if n not in known]
    if missing:
        from mutation.apply import COMPILED

        def work(send: Callable[[Any], None]) -> None:
            interpret(warm.package, kernels, compiled=mutant.module.rsplit(".", 1)[-1] in COMPILED)
            if beneath_cache(warm.package, mutant, kernels):
                forget_caches(warm.package)
            _post_all(warm, missing, send)

        for message in _forked(work, len(missing)):
            if message[0] == "job":
                baseline = Baseline.of(warm.bench.jobs[message[1]], message[2])
                if not baseline.unfit:
                    known[message[1]] = baseline
    return known


def _forked(work: Callable[[Callable[[Any], None]], None], jobs: int) -> Iterable[Any]:
    """Runs `work` in a child and yields what it sends; closing the iteration ends the child."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(read)
        _child(work, write)
    os.close(write)
    try:
        while True:
            header = _read(read, 4)
            if header is None:
                yield ("lost", "the job did not end in its time, or the process died")
                return
            if not header:
                yield ("lost", "the process died, or ran for too long")
                return
            body = _read(read, struct.unpack("<I", header)[0])
            if not body:
                yield ("lost", "the process died")
                return
            message = pickle.loads(body)
            if message[0] == "end":
                return
            yield message
    finally:
        os.close(read)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)


def _child(work: Callable[[Callable[[Any], None]], None], write: int) -> None:
    """The child's whole life."""
    code = 1
    try:
        null = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(null, stream)
        gc.disable()
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))

        def send(message: Any) -> None:
            body = pickle.dumps(message)
            data = struct.pack("<I", len(body)) + body
            while data:
                data = data[os.write(write, data) :]

        work(send)
        send(("end",))
        code = 0
    finally:
        os._exit(code)


def _read(pipe: int, count: int) -> bytes | None:
    """Exactly so many bytes; b"" at the end, None where nothing came in time or the child was cut short."""
    data = b""
    while len(data) < count:
        ready, _, _ = select.select([pipe], [], [], WALL_SECONDS)
        if not ready:
            return None
        piece = os.read(pipe, count - len(data))
        if not piece:
            return b"" if not data else None
        data += piece
    return data


def run_all(
    warm: Warm, mutants: list[Mutant], results: Path, processes: int, until: float, say: Callable[[str], None]
) -> None:
    """Every mutant, shared among processes; results are appended line by line."""
    gc.collect()
    gc.freeze()  # a collection in a child would copy every page that it looks at
    children = []
    for share in range(processes):
        child = os.fork()
        if child == 0:
            code = 1
            try:
                _share(warm, mutants[share::processes], results, until, say if share == 0 else None)
                code = 0
            finally:
                os._exit(code)
        children.append(child)
    failed = [child for child in children if os.waitpid(child, 0)[1] != 0]
    if failed:
        raise RuntimeError("a process of the bench ended with an error; its results so far are kept")


def _share(warm: Warm, mutants: list[Mutant], results: Path, until: float, say: Callable[[str], None] | None) -> None:
    for k, mutant in enumerate(mutants):
        if time.time() > until:
            return
        result = run_mutant(warm, mutant)
        with results.open("a", encoding="utf-8") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            file.write(json.dumps(result.row()) + "\n")
        if say is not None and k % 25 == 0:
            say(f"{k} of {len(mutants)}: {mutant.key} {result.outcome}")
