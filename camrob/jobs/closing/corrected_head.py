"""What the head of a corrected program says: that it is one, of which program, for which machine, and until when."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from camrob.witness.manifest import digests

__all__ = ["corrected_head"]


def corrected_head(source: Path, known: Iterable[Path]) -> tuple[str, ...]:
    """Lines of comment for the program that is made of `source` (a program's main file, or a solved path).

    known: the files that say what is wrong with the machine. No dates: the same input gives the same program.
    """
    return (
        "CORRECTED by camrob compensate: its targets are moved for one robot as it was",
        "measured. HOME and the pose for tool changes are as they were.",
        *_named("original", source),
        *(line for file in known for line in _named("corrected for", file)),
        "Void as soon as an axis is mastered again, or these errors are put right",
        "in the controller: both together correct twice. Then run the original,",
        "measure again, and correct by what that says.",
        "The original's own head (of its decimals, too):",
    )


def _named(what: str, file: Path) -> Iterable[str]:
    """A file with its digest, on a line each."""
    for name, digest in digests([file]).items():
        yield f"{what} {name}"
        yield f"sha256 {digest}"
