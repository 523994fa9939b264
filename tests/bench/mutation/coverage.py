"""Which lines and functions of the package a job runs through, and from these which jobs can show a mutant."""

from __future__ import annotations

import hashlib
import pickle
import sys
import threading
import types
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mutation.apply import PACKAGE, Package, forget_caches, python_callers, readers, touched_kernels
from mutation.draw import Mutant
from mutation.jobs import Job


@dataclass
class Coverage:
    """lines: (file, line); functions: (file, qualified name)."""

    lines: set[tuple[str, int]] = field(default_factory=set)
    functions: set[tuple[str, str]] = field(default_factory=set)


class Kept:
    """Coverage kept in a file from one run of the bench to the next, for the very same sources and jobs."""

    def __init__(self, package: Package, file: Path | None) -> None:
        self._file = file
        digest = hashlib.sha256()
        for name in sorted(package.sources):
            digest.update(package.sources[name].path.read_bytes())
        self._sources = digest.hexdigest()
        self._package = package
        self._all: dict[str, Coverage] = {}
        if file is not None and file.is_file():
            held = pickle.loads(file.read_bytes())
            if held["sources"] == self._sources:
                self._all = held["coverage"]
                package.remembered |= held["remembered"]

    def get(self, job: Job) -> Coverage | None:
        """What a job went through the last time."""
        return self._all.get(_key(job))

    def put(self, job: Job, coverage: Coverage) -> Coverage:
        """Take in what a job went through."""
        self._all[_key(job)] = coverage
        return coverage

    def save(self) -> None:
        """Write the file."""
        if self._file is not None:
            held = {"sources": self._sources, "coverage": self._all, "remembered": self._package.remembered}
            self._file.write_bytes(pickle.dumps(held))


def _key(job: Job) -> str:
    return repr((job.name, job.file, job.text, job.setup, job.cell, job.before, sorted(job.options.items())))


def traced(package: Package, work: Callable[[], Any]) -> Coverage:
    """Run something, its threads too, and note what it goes through; caches are emptied first."""
    found = Coverage()
    lines = found.lines
    cached = {id(c.__wrapped__.__code__) for c in package.caches}
    beneath = [0]
    forget_caches(package)

    def local(frame: types.FrameType, event: str, arg: Any) -> Any:
        if event == "line":
            lines.add((frame.f_code.co_filename, frame.f_lineno))
        elif event == "return" and id(frame.f_code) in cached:
            beneath[0] -= 1
        return local

    def called(frame: types.FrameType, event: str, arg: Any) -> Any:
        code = frame.f_code
        if f"/{PACKAGE}/" not in code.co_filename:
            return None
        place = (code.co_filename, code.co_qualname)
        found.functions.add(place)
        beneath[0] += id(code) in cached
        if beneath[0]:
            package.remembered.add(place)
        lines.add((code.co_filename, frame.f_lineno))
        return local

    threading.settrace(called)
    sys.settrace(called)
    try:
        work()
    finally:
        sys.settrace(None)
        threading.settrace(None)  # type: ignore[arg-type]
    return found


def reach(package: Package, mutant: Mutant, coverage: Mapping[str, Coverage]) -> list[str]:
    """The jobs that run through what a mutant changes."""
    path = str(package.sources[mutant.module].path)
    kernels = touched_kernels(package, mutant)
    if mutant.kind == "code" and not kernels:
        lines = {(path, line) for line in range(mutant.lines[0], mutant.lines[1] + 1)}
        return [name for name, c in coverage.items() if not lines.isdisjoint(c.lines)]
    if kernels:
        places = python_callers(package, kernels)
    else:
        places = {(path, mutant.name)} if mutant.kind == "default" else readers(package, mutant)
    return [name for name, c in coverage.items() if not places.isdisjoint(c.functions)]
