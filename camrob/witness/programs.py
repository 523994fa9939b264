"""Programs by the language that they are written in: which list of statements reads them."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import cast

from camrob.errors import ProgramError
from camrob.witness.happenings import Run
from camrob.witness.machine import Machine

__all__ = ["PROGRAMS", "run_program"]

PROGRAMS: dict[str, str] = {
    ".src": "camrob.witness.krl.run",
    ".mod": "camrob.witness.rapid.run_module",
}
"""Suffix of a program's main file to the module whose `run_program` runs it: one line a language."""


def run_program(program: Path, machine: Machine) -> Run:
    """What a controller would do with a program. Raises ProgramError for one that can't be read, or is in no known language."""
    module = PROGRAMS.get(program.suffix.lower())
    if module is None:
        raise ProgramError(
            "is not a robot program", hint="name a file that ends with " + " or ".join(PROGRAMS), path=program
        )
    return cast(Run, import_module(module).run_program(program, machine))
