"""A finding on valid data: a typed remark with its place, which a report can print and a script can count."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import StrEnum

from camrob.text import one_line

__all__ = ["Finding", "Severity", "collapse", "first_error"]


_LONGEST = 700  # characters of a finding: it can be read on a terminal


class Severity(StrEnum):
    """How bad a finding is: an `ERROR` stops the release of a program."""

    INFO = "info"
    WARNING = "warning"
    ERROR = "error"


@dataclass(frozen=True, slots=True)
class Finding:
    """One finding: `code` (stable, kebab-case), where it is, and how far a value lies from its limit.

    `line` is the CL line, or the program's where a program is judged: then `cl_line` is the CL file's; 0 for none. `file` is
    the program's where it is not the main one. `region` and `point` are indices, -1 for none; `value` and `limit`
    are in `unit` (units of the trade). `count` says how many times the same thing was met (see `collapse`). `text` is
    one printable line, whatever of a file it quotes.
    """

    code: str
    text: str
    severity: Severity = Severity.WARNING
    line: int = 0
    region: int = -1
    point: int = -1
    axis: str = ""
    value: float | None = None
    limit: float | None = None
    unit: str = ""
    count: int = 1
    cl_line: int = 0
    file: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "text", one_line(self.text, _LONGEST))


def first_error(findings: Iterable[Finding]) -> Finding | None:
    """The first finding that stops the release of a program; None where none does."""
    return next((f for f in findings if f.severity is Severity.ERROR), None)


def collapse(findings: Iterable[Finding]) -> list[Finding]:
    """One finding a kind (same code, axis and text): the first met, with the count of all of them, in order of meeting."""
    first: dict[tuple[str, str, str], Finding] = {}
    counts: dict[tuple[str, str, str], int] = {}
    for f in findings:
        key = (f.code, f.axis, f.text)
        first.setdefault(key, f)
        counts[key] = counts.get(key, 0) + f.count
    return [replace(f, count=counts[key]) for key, f in first.items()]
