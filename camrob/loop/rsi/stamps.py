"""How old a measurement is when it arrives, by the instrument's own stamps.

Where both sides share a clock, the age is simply arrival minus stamp. Where the instrument counts by a clock of its own, nobody
knows how far the two clocks are apart: the difference of arrival and stamp is that plus the delay. What can be seen is how much
the difference *grows*, so the age is counted from the least difference so far. A constant part of the delay can't be seen.

Two clocks also run at slightly different rates. The least difference may therefore rise by `drift` (seconds a second; 1e-4 is
what two ordinary quartz clocks differ by), or an instrument whose clock loses would look older by the minute. The price: data
that fall behind by less than that, 6 ms a minute, can't be told from a slow clock; `forgiven_s` says how much was let pass.
"""

from __future__ import annotations

import math

from camrob.errors import InputError

__all__ = ["CLOCK_REFUSALS", "StampClock"]

_AHEAD = "a measurement's time runs ahead of its arrival"
_NOT_GROWING = "a measurement's time doesn't grow"
CLOCK_REFUSALS = frozenset({_AHEAD, _NOT_GROWING})

_HINT = "send the instrument's own time in seconds, of the instant that was measured"


class StampClock:
    """The stamps of one instrument.

    `shared`: stamps are the system clock of this machine; else they are a clock of the instrument's own, which gains or loses
    at most `drift` against this machine's. `slack_s`: how far a stamp may lie ahead of what it can be.
    """

    def __init__(self, *, shared: bool, drift: float, slack_s: float) -> None:
        self.shared = shared
        self._drift, self._slack_s = drift, slack_s
        self._stamp_s = -math.inf
        self._least_s = math.inf  # the least arrival minus stamp, by drift
        self._bottom_s = math.inf  # the same without drift
        self._seen_s = math.nan
        self._held_to: tuple[float, float] | None = None

    @property
    def forgiven_s(self) -> float:
        """How far the least difference has risen so far: drift of the clocks, or data that fell behind very slowly."""
        return 0.0 if self.shared or math.isinf(self._least_s) else max(self._least_s - self._bottom_s, 0.0)

    def age_on_arrival(self, stamp_s: float, at_s: float, wall_s: float) -> float:
        """The age, s, of a measurement that arrived `at_s` (this machine's steady clock), `wall_s` on its system clock.

        Raises InputError, and remembers nothing of it, where the stamp isn't later than the one before, or later than it can be.
        """
        if not stamp_s > self._stamp_s:
            raise InputError(_NOT_GROWING, hint=_HINT)
        age = wall_s - stamp_s if self.shared else self._growth(at_s - stamp_s, at_s)
        if age < -self._slack_s:
            raise InputError(_AHEAD, hint=_HINT)
        self._stamp_s = stamp_s
        return max(age, 0.0)

    def hold_to(self, at_s: float) -> None:
        """From now on somebody relies on the least difference seen: a stamp that undercuts it is no better measurement any more,
        but a clock that was set or runs too fast. Before, it may fall freely: that is how the delay is learnt.
        """
        if self._held_to is None:
            self._held_to = (self._least_s, at_s)

    def _growth(self, difference_s: float, at_s: float) -> float:
        """The difference above the least one so far; below 0 where it undercuts what a sound clock can show."""
        if self._held_to is not None:
            least, since = self._held_to
            undercut = difference_s - (least - self._drift * max(at_s - since, 0.0))
            if undercut < -self._slack_s:
                return undercut
        if not math.isinf(self._least_s):
            self._least_s += self._drift * max(at_s - self._seen_s, 0.0)
        self._seen_s = at_s
        self._least_s = min(self._least_s, difference_s)
        self._bottom_s = min(self._bottom_s, difference_s)
        return difference_s - self._least_s
