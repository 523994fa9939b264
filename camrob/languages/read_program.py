"""A robot's program, in whichever language it is written."""

from __future__ import annotations

from pathlib import Path

from camrob.languages import language_of_file
from camrob.program.program_text import ProgramText

__all__ = ["read_program"]


def read_program(path: str | Path) -> ProgramText:
    """A robot's program as its own text says it, in the language of its suffix.

    Args:
        path: the program's main file.

    Returns:
        The program, in SI: its motions, settings and events, each with its line.

    Raises:
        ProgramError: what can't be read, by file, line and cause.
        InputError: a suffix that no language has.

    Example:
        >>> program = camrob.read_program(Path("out/engraving.src"))
        >>> len(program) > 100
        True
    """
    return language_of_file(Path(path)).read(Path(path))
