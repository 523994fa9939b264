"""What `camrob close-loop` says: ledger.json."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from camrob.summaries.base import Summary, keyed, left_out
from camrob.summaries.compensate_summary import OffPathSize

__all__ = ["CloseLoopSummary", "LoopTurn"]


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopTurn(Summary):
    """A turn: its program and how that was made, what it was predicted to do, what its log shows, and what was found from all
    logs so far.

    program, log, diagnosis: files as the ledger's folder has them; log "" while it is awaited. predicted: off the intended path
    on the machine as diagnosed, without noise and what is unexplained; None of the first program. measured: as logged, the
    instrument's noise in it. found: the claimed effects; rest_mm: what stays unexplained (3-D rms), None without a diagnosis.
    experiment: the program that would tell two sets of causes apart, "" where none is needed.
    """

    turn: int
    program: str
    made: str
    log: str = ""
    log_digest: str = ""
    predicted: OffPathSize | None = keyed("foretold", None)
    measured: OffPathSize | None = None
    noise_mm: float | None = None
    diagnosis: str = ""
    found: tuple[str, ...] = ()
    rest_mm: float | None = None
    experiment: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class CloseLoopSummary(Summary):
    """The loop so far. outcome: "awaiting a log", "within tolerance", "nothing more helps", "nothing to correct" or "turns used
    up"; next: what to do, in words; best: the turn whose log is nearest to the path, 0 before the first. made_from: digest of
    what the loop was begun with.
    """

    toolpath: str
    cell: str
    tolerance_mm: float
    outcome: str
    next: str
    best: int
    turns: tuple[LoopTurn, ...]
    made_from: Mapping[str, str]
    files: tuple[str, ...]
    seconds: float | None = left_out()

    @property
    def kept(self) -> bool:
        """Whether the tolerance is kept, or nobody can say yet."""
        return self.outcome in ("awaiting a log", "within tolerance")
