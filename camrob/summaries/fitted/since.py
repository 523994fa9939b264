"""When a part of the machine became another."""

from __future__ import annotations

from dataclasses import dataclass

from camrob.summaries.base import OpenSummary, left_out

__all__ = ["Since"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Since(OpenSummary):
    """When something changed: between the logs `after` and `log`, or at a row of `log` (from 1), t_s of it; lasting: it is so
    still when the last log ends.
    """

    log: str
    after: str | None = left_out()
    row: int | None = left_out()
    t_s: float | None = left_out()
    lasting: bool

    @property
    def words(self) -> str:
        """As it is said behind a name."""
        if self.row is not None:
            return f"since row {self.row} of {self.log}"
        return f"since {self.log}" if self.lasting else f"in {self.log} alone"
