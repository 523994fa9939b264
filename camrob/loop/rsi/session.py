"""What the tracker server decides, frame by frame, without a socket or a clock of its own.

Frames of the controller and datagrams of the instrument go in with the time at which they arrived; answers come out. A
frame gets an answer, or it gets none; the controller counts unanswered frames and stops the robot by itself, so not answering
is the safe state. A stop is for good: whoever goes on starts a new session with the controller's correction at zero.

Frames of anyone who isn't allowed or isn't the first controller heard, frames that can't be read, and frames whose IPOC isn't
above the last one's are counted and not answered. A frame that is read more than a cycle after it came is answered by holding:
nothing is accumulated for it.

The instrument isn't taken at its word. Its stamps say how old its data are (`stamps`); a pose that stands still while the robot
is moved, is too far from the set-point, or jumped farther than the robot can have moved isn't used
(`plausible_pose`). Each of these
holds the correction where it is, and stops the session when the law's row of cycles without a usable measurement is full. What
no later measurement can put right is held as long and stops the session in any case: a correction that stays at its limit, an
error that doesn't answer to the correction (`response`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.errors import InputError
from camrob.loop.law import LawState, hold, step
from camrob.loop.rsi.intake import Intake, Measured
from camrob.loop.rsi.link import Address, LinkSettings
from camrob.loop.rsi.outcome import SessionCounts, Stop, tally
from camrob.loop.rsi.plausible_pose import JumpBound, likely_cause
from camrob.loop.rsi.response import ResponseWatch
from camrob.loop.rsi.setpoints import SetpointHistory, rkorr_error, without_correction
from camrob.loop.rsi.xml_frames import RobFrame, read_rob, write_sen
from camrob.units import m_to_mm, ms_to_s, rad_to_deg, s_to_ms

__all__ = ["Answer", "TrackerSession"]

Array = NDArray[np.float64]

USED, STALE, BEHIND, IMPLAUSIBLE, FAULTY = 0, 1, 2, 3, 4  # what a frame's answer was made from
_LATE_ARRIVAL = 1.5  # cycles between two frames, from which on the later one counts as late
_FAR = "is too far from the set-point (wrong frame, wrong target, or a lost beam)"
_JUMPED = (
    "jumped farther than the robot was moved (another target or a reflection was caught, the target slipped on its mount, or the "
    "instrument was pushed)"
)
_AT_LIMIT = 0.99  # of its limit: so near, that noise doesn't take a component away from it


class Answer(NamedTuple):
    """One answered frame: the datagram, its IPOC, what it was made from, and its numbers.

    `source` is 0 for a measurement that was used, 1 for a stale, 2 for a late frame, 3 for a measurement not believed, 4 where
    the loop itself is at fault. `setpoint`, `error` (eq. 3), `total` and `sent` are (6,), m and rad; `age_s` is the
    measurement's age, as far as its stamps show it, and `interval_s` the time since the frame before (NaN where there is none).
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


class TrackerSession:
    """One run of the loop between one controller and one instrument. Not for several threads at once."""

    def __init__(self, settings: LinkSettings) -> None:
        self.settings = settings
        self.counts = SessionCounts()
        self.intake = Intake(settings, self.counts)
        self.state = LawState()
        self.stopped: Stop | None = None
        self.controller: Address | None = None
        self._history = SetpointHistory()
        self._jump = JumpBound(settings.jump_m, settings.jump_rad)
        self._response = ResponseWatch(settings.law.gain, settings.law.cycle_s)
        self._doubt = ""  # why the last measurement isn't believed
        self._fault: Stop | None = None  # what the session is held for until it stops
        self._ticks = -1
        self._last_s = np.nan
        self._behind = 0
        self._at_limit = 0

    @property
    def instrument(self) -> Address | None:
        """Who measures: the first allowed sender of a good measurement."""
        return self.intake.sender

    def stop(self, code: str, text: str) -> None:
        """Answer no more, for good; the first reason stays."""
        if self.stopped is None:
            self.stopped = Stop(code, text)

    def measure(self, data: bytes, sender: Address, at_s: float, wall_s: float | None = None) -> None:
        """A datagram that arrived on the instrument's port `at_s`, on the system clock `wall_s` (None: it is the same clock)."""
        self.intake.take(data, sender, at_s, at_s if wall_s is None else wall_s, self._history)

    def answer(self, data: bytes, sender: Address, at_s: float, now_s: float) -> Answer | None:
        """The answer to a frame that arrived at `at_s` and is looked at `now_s` (one clock), or None where it gets none."""
        counts = self.counts
        counts.frames += 1
        if self.stopped is not None:
            counts.unanswered_after_stop += 1
            return None
        if self.silent(at_s):
            return None
        if not self._hears(sender):
            return None
        try:
            frame = read_rob(data)
        except InputError as error:
            tally(counts.refused, error.what)
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

    def _hears(self, sender: Address) -> bool:
        counts = self.counts
        allowed = self.settings.hears(sender)
        if allowed and sender == (self.controller or sender):
            return True
        counts.not_allowed += not allowed
        counts.other_sender += allowed
        counts.note_stranger(sender)
        return False

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
        self._history.add(at_s, setpoint, total)
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
            outcome = step(law, self.state, error)
            self.state = outcome.state
            if not outcome.answers:
                self.stop(*(self._fault or self._why_held(source)))
                return None
            counts.held_stale += source == STALE
            counts.held_implausible += source == IMPLAUSIBLE
            counts.held_faulty += source == FAULTY
            counts.saturated += bool(outcome.saturated.any())
            sent = outcome.sent
            self._watch(at_s, error, total, setpoint)
        counts.answered += 1
        reply = write_sen(frame.ipoc, sent, settings.sen_type)
        return Answer(reply, frame.ticks, source, setpoint, shown, self.state.total, sent, age, interval_s)

    def _judge(self, at_s: float, waited_s: float) -> tuple[int, float, Array | None, Array]:
        """What there is to answer with: its kind, the measurement's age, the error for the law, and eq. 3's error to show."""
        settings, measured = self.settings, self.intake.newest
        if measured is None:
            return STALE, np.nan, None, np.full(6, np.nan)
        age = max(at_s + waited_s - measured.at_s, 0.0)
        error, shown = rkorr_error(self._history.at(measured.at_s - settings.latency_s), measured.base_T_tcp)
        if waited_s > settings.law.cycle_s:
            return BEHIND, age, None, shown
        if self._fault is not None:
            return FAULTY, age, None, shown
        if settings.law.is_stale(age):
            return STALE, age, None, shown
        self._doubt = self._why_doubted(measured, error)
        return (IMPLAUSIBLE, age, None, shown) if self._doubt else (USED, age, error, shown)

    def _why_doubted(self, measured: Measured, error: Array) -> str:
        """Why a fresh measurement isn't believed, or ""; the next one is compared with one that is."""
        settings = self.settings
        if np.abs(error[:3]).max() > settings.error_m or np.abs(error[3:]).max() > settings.error_rad:
            return _FAR
        true_s = measured.at_s - settings.latency_s
        if self._jump.too_far(true_s, measured.base_T_tcp, self._history):
            return _JUMPED
        self._jump.believe(true_s, measured.base_T_tcp)
        return ""

    def _watch(self, at_s: float, error: Array | None, total: Array, setpoint: Array) -> None:
        """Look at the correction that is sent now, and at what the measurement that was used, if any, says of the one before."""
        law, limit = self.settings.law, self.settings.saturated_cycles
        share = np.abs(self.state.total) / law.limit
        self._at_limit = self._at_limit + 1 if share.max() >= _AT_LIMIT else 0
        reason, code = "", "response"
        if error is not None:
            self.intake.clock.hold_to(at_s)
            reason = self._response.add(at_s, error, total, setpoint, self._history.programmed)
        if self._at_limit > limit:
            worst, code = int(np.argmax(share)), "saturated"
            value, unit = self.state.total[worst], "mm" if worst < 3 else "degrees"
            shown = m_to_mm(value) if worst < 3 else rad_to_deg(value)
            reason = (
                f"the correction stayed at its limit for more than {limit} cycles ({'XYZABC'[worst]} at {shown:.3f} {unit}): the "
                "robot is farther off than it may be corrected, or what is measured isn't what is moved"
            )
        if reason and self._fault is None:
            self._fault = Stop(code, reason)

    def _why_held(self, source: int) -> Stop:
        """Why the row of cycles without a usable measurement, the last of them of this kind, became too long."""
        cycles, newest, settings = self.state.stale_cycles, self.intake.newest, self.settings
        if source != IMPLAUSIBLE or newest is None:
            return self.intake.why_stale(cycles)
        reason = self._doubt
        if reason == _FAR:
            setpoint = self._history.at(newest.at_s - settings.latency_s)
            bounds = settings.error_m, settings.error_rad
            cause = likely_cause(settings.base_T_tracker, newest.tracker_T_tcp, setpoint, bounds)
            reason += f"; most likely {cause}" if cause else ""
        return Stop("stale", f"{cycles} cycles without a measurement that can be believed: the last one {reason}")
