"""What the tracker server decides, frame by frame, without a socket or a clock of its own.

Frames of the controller and datagrams of the instrument go in with the time at which they arrived; answers come out. A
frame gets an answer, or it gets none; the controller counts unanswered frames and stops the robot by itself, so not answering
is the safe state. A stop is for good: whoever goes on starts a new session with the controller's correction at zero.

Frames of anyone but the first controller heard, frames that can't be read, and frames whose IPOC isn't above the last one's
are counted and not answered. A frame that is read more than a cycle after it came is answered by holding: nothing is
accumulated for it.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.controller.tracker.instrument import read_instrument
from camrob.controller.tracker.law import CorrectionLaw, LawState, hold, step
from camrob.controller.tracker.measurement import base_pose
from camrob.controller.tracker.rsi_xml import RobFrame, check_sen_type, read_rob, write_sen
from camrob.controller.tracker.setpoints import SetpointHistory, rkorr_error, without_correction
from camrob.errors import InputError
from camrob.frozen import locked
from camrob.units import ms_to_s, s_to_ms

__all__ = ["FAULTS", "Address", "Answer", "LinkSettings", "SessionCounts", "Stop", "TrackerSession"]

Array = NDArray[np.float64]
Address = tuple[str, int]
"""Host and port of a UDP socket."""

FAULTS = frozenset({"stale", "silent", "late", "socket", "internal"})
"""Codes of a `Stop` that is a fault; the others are `operator` and `duration`."""

USED, STALE, BEHIND, IMPLAUSIBLE = 0, 1, 2, 3  # what a frame's answer was made from
_LATE_ARRIVAL = 1.5  # cycles between two frames, from which on the later one counts as late
_MOST_TEXTS = 32  # kinds of refusal counted apart


@dataclass(frozen=True, slots=True)
class LinkSettings:
    """How a session works.

    `base_T_tracker` (4, 4) is the instrument's frame in `$BASE`; `latency_s` how much later than it was true a measurement
    arrives. `corrected` says that the controller's RSol already holds the correction (it is taken off then). A measurement
    farther than `error_m` or `error_rad` from the set-point isn't believed. `late_stop_cycles`: cycles of silence, or frames
    in a row answered late, that stop the session. Raises InputError for values that make no sense.
    """

    law: CorrectionLaw
    base_T_tracker: Array = field(default_factory=lambda: np.eye(4))
    sen_type: str = "ImFree"
    latency_s: float = 0.0
    corrected: bool = False
    error_m: float = 0.005
    error_rad: float = 0.02
    late_stop_cycles: int = 25

    def __post_init__(self) -> None:
        object.__setattr__(self, "base_T_tracker", locked(self.base_T_tracker, shape=(4, 4), name="base_T_tracker"))
        check_sen_type(self.sen_type)
        if not -0.2 <= self.latency_s <= 0.2:
            raise InputError(f"the instrument's latency is {self.latency_s} s", cure="give up to 200 ms")
        if not (self.error_m > 0.0 and self.error_rad > 0.0 and self.late_stop_cycles >= 1):
            raise InputError("a bound of the tracker's session isn't above 0", cure="give positive numbers")


class Stop(NamedTuple):
    """Why a session answers no more: a `code` (see FAULTS) and a sentence."""

    code: str
    text: str


class Answer(NamedTuple):
    """One answered frame: the datagram, its IPOC, what it was made from, and its numbers.

    `source` is 0 for a measurement that was used, 1 for a stale, 2 for a late frame, 3 for a measurement not believed.
    `setpoint`, `error` (eq. 3), `total` and `sent` are (6,), m and rad; `age_s` is the measurement's age and `interval_s` the
    time since the frame before (NaN where there is none).
    """

    data: bytes
    ticks: int
    source: int
    setpoint: Array
    error: Array
    total: Array
    sent: Array
    age_s: float
    interval_s: float


@dataclass(slots=True)
class SessionCounts:
    """Everything that a session counts; frames first, then measurements."""

    frames: int = 0
    answered: int = 0
    unanswered_after_stop: int = 0
    other_sender: int = 0
    duplicate: int = 0
    out_of_order: int = 0
    missed: int = 0
    late_arrivals: int = 0
    answered_late: int = 0
    held_stale: int = 0
    held_implausible: int = 0
    saturated: int = 0
    refused: Counter[str] = field(default_factory=Counter)
    measurements: int = 0
    measurements_kept: int = 0
    measurements_other_sender: int = 0
    measurements_refused: Counter[str] = field(default_factory=Counter)


class TrackerSession:
    """One run of the loop between one controller and one instrument. Not for several threads at once."""

    def __init__(self, settings: LinkSettings) -> None:
        self.settings = settings
        self.counts = SessionCounts()
        self.state = LawState()
        self.stopped: Stop | None = None
        self.controller: Address | None = None
        self.instrument: Address | None = None
        self._history = SetpointHistory()
        self._measured: tuple[float, Array] | None = None
        self._clock_s = -np.inf
        self._ticks = -1
        self._last_s = np.nan
        self._behind = 0

    def stop(self, code: str, text: str) -> None:
        """Answer no more, for good; the first reason stays."""
        if self.stopped is None:
            self.stopped = Stop(code, text)

    def measure(self, data: bytes, sender: Address, at_s: float) -> None:
        """A datagram that arrived on the instrument's port."""
        counts = self.counts
        counts.measurements += 1
        if self.instrument is not None and sender != self.instrument:
            counts.measurements_other_sender += 1
            return
        try:
            pose = read_instrument(data)
            if not pose.t_s > self._clock_s:
                raise InputError("a measurement's time doesn't grow")
        except InputError as error:
            _tally(counts.measurements_refused, error)
            return
        self.instrument, self._clock_s = sender, pose.t_s
        self._measured = (at_s, base_pose(self.settings.base_T_tracker, pose.tracker_T_tcp))
        counts.measurements_kept += 1

    def answer(self, data: bytes, sender: Address, at_s: float, now_s: float) -> Answer | None:
        """The answer to a frame that arrived at `at_s` and is looked at `now_s` (one clock), or None where it gets none."""
        counts = self.counts
        counts.frames += 1
        if self.stopped is not None:
            counts.unanswered_after_stop += 1
            return None
        if self.silent(at_s):
            return None
        if self.controller is not None and sender != self.controller:
            counts.other_sender += 1
            return None
        try:
            frame = read_rob(data)
        except InputError as error:
            _tally(counts.refused, error)
            return None
        if not self._in_order(frame):
            return None
        self.controller = sender
        interval, self._last_s, self._ticks = at_s - self._last_s, at_s, frame.ticks
        counts.late_arrivals += bool(interval > _LATE_ARRIVAL * self.settings.law.cycle_s)
        return self._correct(frame, at_s, now_s - at_s, interval)

    def silent(self, now_s: float) -> bool:
        """Whether the controller has been silent for too long, or the session has stopped; the first stops it."""
        allowed = self.settings.late_stop_cycles * self.settings.law.cycle_s
        if self.stopped is None and now_s - self._last_s > allowed:
            self.stop(
                "silent",
                f"no good frame of the controller for {s_to_ms(now_s - self._last_s):.0f} ms: "
                "RSI was switched off, or its packets are late or lost",
            )
        return self.stopped is not None

    def _in_order(self, frame: RobFrame) -> bool:
        counts = self.counts
        ahead = frame.ticks - self._ticks
        if self._ticks >= 0 and ahead <= 0:
            counts.duplicate += ahead == 0
            counts.out_of_order += ahead < 0
            return False
        if self._ticks >= 0:
            counts.missed += max(round(ms_to_s(float(ahead)) / self.settings.law.cycle_s) - 1, 0)
        return True

    def _correct(self, frame: RobFrame, at_s: float, waited_s: float, interval_s: float) -> Answer | None:
        settings, counts, law = self.settings, self.counts, self.settings.law
        total = self.state.total
        setpoint = without_correction(frame.setpoint, total) if settings.corrected else frame.setpoint
        self._history.add(at_s, setpoint)
        source, age, error, shown = self._judge(at_s, waited_s)
        if source == BEHIND:
            counts.answered_late += 1
            self._behind += 1
            if self._behind > settings.late_stop_cycles:
                self.stop("late", f"{self._behind} frames in a row were answered more than a cycle late")
                return None
            sent = hold(law, self.state)
        else:
            self._behind = 0
            counts.held_stale += source == STALE
            counts.held_implausible += source == IMPLAUSIBLE
            outcome = step(law, self.state, error)
            self.state = outcome.state
            if not outcome.answers:
                self.stop("stale", self._why_stale(source))
                return None
            counts.saturated += bool(outcome.saturated.any())
            sent = outcome.sent
        counts.answered += 1
        reply = write_sen(frame.ipoc, sent, settings.sen_type)
        return Answer(reply, frame.ticks, source, setpoint, shown, self.state.total, sent, age, interval_s)

    def _judge(self, at_s: float, waited_s: float) -> tuple[int, float, Array | None, Array]:
        """What there is to answer with: its kind, the measurement's age, the error for the law, and eq. 3's error to show."""
        nothing = np.full(6, np.nan)
        if self._measured is None:
            return STALE, np.nan, None, nothing
        measured_s, base_T_tcp = self._measured
        age = max(at_s + waited_s - measured_s, 0.0)
        error, shown = rkorr_error(self._history.at(measured_s - self.settings.latency_s), base_T_tcp)
        if waited_s > self.settings.law.cycle_s:
            return BEHIND, age, None, shown
        if self.settings.law.is_stale(age):
            return STALE, age, None, shown
        if np.abs(error[:3]).max() > self.settings.error_m or np.abs(error[3:]).max() > self.settings.error_rad:
            return IMPLAUSIBLE, age, None, shown
        return USED, age, error, shown

    def _why_stale(self, source: int) -> str:
        cycles, counts = self.state.stale_cycles, self.counts
        if source == IMPLAUSIBLE:
            return (
                f"{cycles} cycles without a measurement that can be believed: the last one is too far from the set-point "
                "(wrong frame, wrong target, or a lost beam)"
            )
        if counts.measurements_kept == 0:
            return f"{cycles} cycles, and no measurement has come that could be read ({counts.measurements} datagrams came)"
        refused = sum(counts.measurements_refused.values())
        return f"{cycles} cycles without a fresh measurement ({counts.measurements_kept} came, {refused} were refused)"


def _tally(counter: Counter[str], error: InputError) -> None:
    counter[error.what if error.what in counter or len(counter) < _MOST_TEXTS else "other"] += 1
