"""Statements in the order in which a control runs them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator

from camrob.witness.cl.running.unread import UnreadError

__all__ = ["Ordered", "Row", "less"]

Row = tuple[int, str]  # a line's number, and what stands there

MOST_STEPS = 200_000  # statements that one program runs: what goes on longer has no end that is waited for
_SAME = 1e-7  # of a value: two that are nearer to each other rounding alone tells apart


class Ordered(ABC):
    """`line` is that of the statement that is run just now. Iterated once: (line, statement) for what a reader reads."""

    def __init__(self, rows: list[Row]) -> None:
        self.rows = rows
        self.line = rows[0][0] if rows else 1

    def __iter__(self) -> Iterator[Row]:
        at = self._start()
        for _ in range(MOST_STEPS):
            if at >= len(self.rows) and self._called():
                raise UnreadError("a subprogram without its end")
            if at >= len(self.rows) or at < 0:
                return
            self.line, row = self.rows[at]
            at, told = self._step(at, row)
            if told:
                yield self.line, told
        raise UnreadError(f"a program without an end within {MOST_STEPS} statements")

    def _start(self) -> int:
        """The first statement that is run."""
        return 0

    @abstractmethod
    def _called(self) -> bool:
        """Whether a subprogram or a repeated section is running."""

    @abstractmethod
    def _step(self, at: int, row: str) -> tuple[int, str]:
        """Runs a statement: the next one, -1 for none, and what a reader is told. Raises UnreadError where nobody knows."""


def less(a: float, b: float) -> float:
    """Below 0, 0 or above 0 as a is less than b, equal or more. Raises UnreadError where rounding decides."""
    if 0.0 < abs(a - b) <= _SAME * max(1.0, abs(a), abs(b)):
        raise UnreadError("a comparison that rounding decides")
    return a - b
