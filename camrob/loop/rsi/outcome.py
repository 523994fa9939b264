"""What comes of a session: how it ended, and what it counted on the way."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import NamedTuple

from camrob.loop.rsi.link import Address

__all__ = ["FAULTS", "SessionCounts", "Stop", "tally"]

FAULTS = frozenset({"stale", "clock", "frozen", "saturated", "response", "silent", "late", "socket", "internal"})
"""Codes of a `Stop` that is a fault; the others are `operator` and `duration`."""

_MOST_KEYS = 32  # kinds that are told apart, so that a flood of texts fills no memory


class Stop(NamedTuple):
    """Why a session answers no more: a `code` (see FAULTS) and a sentence."""

    code: str
    text: str


@dataclass(slots=True)
class SessionCounts:
    """Everything that a session counts: frames, then measurements, then by sender whatever came from anybody else."""

    frames: int = 0
    answered: int = 0
    unanswered_after_stop: int = 0
    other_sender: int = 0
    not_allowed: int = 0
    duplicate: int = 0
    out_of_order: int = 0
    missed: int = 0
    late_arrivals: int = 0
    answered_late: int = 0
    held_stale: int = 0
    held_implausible: int = 0
    held_faulty: int = 0
    saturated: int = 0
    refused: Counter[str] = field(default_factory=Counter)
    measurements: int = 0
    measurements_kept: int = 0
    measurements_other_sender: int = 0
    measurements_not_allowed: int = 0
    measurements_refused: Counter[str] = field(default_factory=Counter)
    strangers: Counter[str] = field(default_factory=Counter)

    def note_stranger(self, sender: Address) -> None:
        """One more datagram of a sender that isn't heard."""
        tally(self.strangers, "{}:{}".format(*sender))


def tally(counter: Counter[str], text: str) -> None:
    """Count a text, all beyond the first few kinds as "other": whoever sends can't fill the memory."""
    counter[text if text in counter or len(counter) < _MOST_KEYS else "other"] += 1
