"""What the instrument's datagrams become: the newest measurement that can be used, and why there is none where there is none."""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.errors import InputError
from camrob.loop.rsi.instrument import read_instrument
from camrob.loop.rsi.link import Address, LinkSettings
from camrob.loop.rsi.outcome import SessionCounts, Stop, tally
from camrob.loop.rsi.plausible_pose import FROZEN_REFUSALS, StillPose
from camrob.loop.rsi.setpoints import SetpointHistory
from camrob.loop.rsi.stamps import CLOCK_REFUSALS, StampClock
from camrob.loop.tracker_error import base_pose
from camrob.units import s_to_ms

__all__ = ["Intake", "Measured"]

Array = NDArray[np.float64]

_OTHER_CLOCK_S = 1.0  # an age beyond this is no delay: the clocks aren't the same one


class Measured(NamedTuple):
    """A measurement: when it was true, and how old it was on arrival, as far as its stamps show it, s; the pose in the base and
    as it was sent, (4, 4).
    """

    at_s: float
    late_s: float
    base_T_tcp: Array
    tracker_T_tcp: Array


class Intake:
    """Takes the datagrams of one instrument, the first of those allowed that sends a good one; counts the rest."""

    def __init__(self, settings: LinkSettings, counts: SessionCounts) -> None:
        self.settings = settings
        self.counts = counts
        self.sender: Address | None = None
        self.newest: Measured | None = None
        shared, law = settings.clock == "shared", settings.law
        # a delay that was learnt from a late datagram may prove smaller by what data may be old; shared clocks agree better
        slack_s = law.cycle_s * (1 if shared else law.stale_after_cycles)
        self.clock = StampClock(shared=shared, drift=settings.drift, slack_s=slack_s)
        self._still = StillPose(noisy=settings.noisy)
        self._refused: Counter[str] = Counter()  # since the newest

    def take(self, data: bytes, sender: Address, at_s: float, wall_s: float, history: SetpointHistory) -> None:
        """A datagram that arrived `at_s` on the steady clock and `wall_s` on the system clock."""
        counts = self.counts
        counts.measurements += 1
        if not self.settings.hears(sender):
            counts.measurements_not_allowed += 1
            counts.note_stranger(sender)
            return
        if self.sender is not None and sender != self.sender:
            counts.measurements_other_sender += 1
            counts.note_stranger(sender)
            return
        try:
            stamp_s, pose = read_instrument(data)
            late_s = self.clock.age_on_arrival(stamp_s, at_s, wall_s)
            self._still.check(pose, history.commanded(at_s - late_s))
        except InputError as error:
            tally(counts.measurements_refused, error.what)
            tally(self._refused, error.what)
            return
        counts.measurements_kept += 1
        self.sender = sender
        self.newest = Measured(at_s - late_s, late_s, base_pose(self.settings.base_T_tracker, pose), pose)
        self._refused.clear()

    def why_stale(self, cycles: int) -> Stop:
        """Why there was nothing fresh for so many cycles."""
        counts, refused = self.counts, self._refused.most_common(1)
        if self.newest is None:
            came = f"{counts.measurements} datagrams came"
            if counts.measurements_not_allowed:
                came += f", {counts.measurements_not_allowed} of them not from an allowed sender"
            last = f"; most often: {refused[0][0]}" if refused else ""
            return Stop("stale", f"{cycles} cycles, and no measurement has come that could be read ({came}{last})")
        start = f"{cycles} cycles without a fresh measurement"
        if self._refused.total() >= cycles / 2.0:
            text, times = refused[0]
            code = "clock" if text in CLOCK_REFUSALS else "frozen" if text in FROZEN_REFUSALS else "stale"
            return Stop(code, f"{start}: {self._refused.total()} in a row were refused, {text} ({times} times)")
        late_s, law = self.newest.late_s, self.settings.law
        if law.is_stale(late_s):
            shared = self.clock.shared
            what = "old" if shared else "later than the least late one"
            clocks = " (the clocks aren't the same one)" if shared and late_s > _OTHER_CLOCK_S else ""
            return Stop(
                "stale",
                f"{start}: by the instrument's stamps the last one came {s_to_ms(late_s):.0f} ms {what}{clocks}",
            )
        total = sum(counts.measurements_refused.values())
        return Stop("stale", f"{start} ({counts.measurements_kept} came, {total} were refused)")
