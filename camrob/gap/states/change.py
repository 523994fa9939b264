"""Since when a part of the machine is another: from a log on, from a row of one on, or in one log alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from camrob.gap.observation.scene import Scene
from camrob.summaries.fitted.since import Since

__all__ = ["Change"]


@dataclass(frozen=True, slots=True)
class Change:
    """log: the first log of the later state, or the one in which it begins; at: s of that log behind which it does, None for all
    of it; row: the first row behind that moment, from 1; later: further logs of the later state; earlier: the other fitted ones;
    states: what LOG.toml calls the later state; before: the last log of the earlier one; now: the machine is in the later state
    when the last log ends; recorded: when the first log of the later state was, None where it doesn't say so.
    """

    log: str
    later: frozenset[str]
    earlier: frozenset[str]
    at: float | None = None
    row: int = 0
    states: frozenset[str] = frozenset()
    before: str = ""
    now: bool = True
    recorded: datetime | None = None

    @property
    def said(self) -> Since:
        """As it stands in the summary."""
        row = None if self.at is None else self.row
        return Since(log=self.log, after=self.before or None, row=row, t_s=self.at, lasting=self.now)

    def course(self, scene: Scene) -> NDArray[np.float64]:
        """(N,) 1 in the later state, 0 before. A log that takes no part in the fit is of the state that its LOG.toml names, else
        of that of its day, or of the machine's last one.
        """
        name, told, day = scene.name, scene.log.info.state, scene.log.info.recorded
        if name == self.log and self.at is not None:
            return np.asarray(scene.t > self.at, np.float64)
        fitted = name == self.log or name in self.later or name in self.earlier
        there = name == self.log or name in self.later
        if not fitted:
            sooner = day is not None and self.recorded is not None and day < self.recorded
            there = told in self.states if told and self.states else self.now and not sooner
        return np.full(len(scene), float(there))

    def shown_in(self, scenes: Sequence[Scene]) -> tuple[Scene, ...]:
        """The logs that have rows of the later state."""
        return tuple(s for s in scenes if self.course(s).any())
