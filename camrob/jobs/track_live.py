"""`camrob tracker --listen`: answer a controller's RSI frames until something ends it, then say what happened."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.errors import InputError
from camrob.jobs.exit_status import DONE, NOT_SAFE
from camrob.jobs.files.output import staged_output
from camrob.jobs.files.summary_file import write_summary
from camrob.jobs.files.takes_paths import takes_paths
from camrob.jobs.files.track_options import LiveOptions, live_options
from camrob.loop.rsi.cycle_log import CycleLog, percentiles
from camrob.loop.rsi.link import Address
from camrob.loop.rsi.outcome import FAULTS, SessionCounts
from camrob.loop.rsi.server import RsiServer
from camrob.loop.rsi.session import TrackerSession
from camrob.progress import Progress, silent
from camrob.summaries.live_summary import (
    AnswerTimes,
    CorrectionFigures,
    FrameCounts,
    InstrumentClock,
    MeasurementCounts,
    Percentiles,
    Stopped,
    TrackLiveSummary,
)
from camrob.summaries.remarks import Remark
from camrob.units import m_to_mm, ms_to_s, rad_to_deg, s_to_ms

__all__ = ["LiveOptions", "TrackLiveResult", "track_live"]


@dataclass(frozen=True, slots=True)
class TrackLiveResult:
    """The summary, and what it was made from."""

    summary: TrackLiveSummary
    session: TrackerSession
    log: CycleLog

    @property
    def status(self) -> int:
        """What the command ends with: 3 after a fault, 0 otherwise."""
        return NOT_SAFE if self.fault else DONE

    @property
    def fault(self) -> bool:
        """True where a fault ended it, so that the robot was stopped."""
        return self.summary.stopped.fault


@takes_paths
def track_live(
    *,
    listen: str = "127.0.0.1:59152",
    instrument: str = "127.0.0.1:59153",
    options: LiveOptions | None = None,
    cell: Path | None = None,
    said: Mapping[str, Any] | None = None,
    duration_s: float | None = None,
    realtime: bool = False,
    out: Path | None = None,
    ready: Callable[[RsiServer], None] = lambda server: None,
    should_stop: Callable[[], bool] = lambda: False,
    progress: Progress | None = None,
) -> TrackLiveResult:
    """Serve a controller on `listen` from an instrument on `instrument` until a fault, an interruption, or `duration_s`.

    Whatever ends it, the answers end with it, and the summary says why.

    Args:
        listen: HOST:PORT for the controller.
        instrument: HOST:PORT for the instrument.
        options: None: those of the cell's tracker.toml, where there is one.
        cell: the cell's folder.
        said: overrides options by name, its "bounds" being texts NAME=VALUE.
        duration_s: s; None: without end.
        realtime: asks for real-time priority.
        out: a folder where tracker.csv (a row for each answer) and tracker.json appear afterwards.
        ready: called when both ports are open.
        should_stop: is asked whether to end.
        progress: called where the job waits.

    Raises:
        InputError: an address or an option that is wrong.

    Example:
        >>> result = camrob.track_live(listen="127.0.0.1:0", instrument="127.0.0.1:0", duration_s=0.1)
        >>> result.summary.stopped.code, result.summary.frames.received
        ('duration', 0)
    """
    options = live_options(options, cell, said or {})
    settings = options.settings()
    if duration_s is not None and not 0.0 < duration_s < float("inf"):
        raise InputError(f"the duration is {duration_s} s", hint="give a positive number of seconds")
    start = time.monotonic()
    with RsiServer(settings, listen=_address(listen), instrument=_address(instrument)) as server:
        heard = ", ".join(options.allow) or "whoever sends first"
        where = "waiting on {}:{} for {}".format(*server.controller_address, heard)
        (progress or silent)(where, 0.0)
        ready(server)
        session = server.serve(duration_s=duration_s, should_stop=should_stop, realtime=realtime)
    summary = _summary(options, server, session, time.monotonic() - start)
    if out is not None:
        with staged_output(out) as folder:
            server.log.write(folder / "tracker.csv")
            write_summary(folder / "tracker.json", summary)
    return TrackLiveResult(summary, session, server.log)


def _address(text: str) -> Address:
    """HOST:PORT, an IPv4 address or a name."""
    match = re.fullmatch(r"([A-Za-z0-9_.\-]{1,253}):([0-9]{1,5})", text)
    if match is None or int(match[2]) > 65535:
        raise InputError(f"{text!r} is not an address", hint="give HOST:PORT, such as 127.0.0.1:59152")
    return match[1], int(match[2])


def _summary(options: LiveOptions, server: RsiServer, session: TrackerSession, seconds: float) -> TrackLiveSummary:
    log, counts, stop = server.log, session.counts, session.stopped
    rows = log.rows
    cycle = ms_to_s(options.cycle_ms)
    total = session.state.total
    largest = np.abs(rows[:, 16:22]).max(axis=0, initial=0.0)
    code, text = ("internal", "it ended without a reason") if stop is None else stop
    return TrackLiveSummary(
        mode=options.mode,
        gain=options.gain,
        cycle_ms=options.cycle_ms,
        controller=None if session.controller is None else "{}:{}".format(*session.controller),
        instrument=None if session.instrument is None else "{}:{}".format(*session.instrument),
        strangers=counts.strangers,
        stopped=Stopped(code=code, text=text, fault=code in FAULTS),
        frames=_frames(counts),
        measurements=MeasurementCounts(
            received=counts.measurements,
            kept=counts.measurements_kept,
            other_sender=counts.measurements_other_sender,
            not_allowed=counts.measurements_not_allowed,
            refused=counts.measurements_refused,
        ),
        correction=CorrectionFigures(
            total_mm=_rounded(m_to_mm(total[:3])),
            total_deg=_rounded(rad_to_deg(total[3:])),
            largest_mm=_rounded(m_to_mm(largest[:3])),
            largest_deg=_rounded(rad_to_deg(largest[3:])),
            saturated_cycles=counts.saturated,
        ),
        latency_ms=AnswerTimes(**percentiles(rows[:, 1]), source="kernel" if server.kernel_stamps else "process"),
        within_cycle=None if not len(rows) else round(float(np.mean(rows[:, 1] <= cycle)), 6),
        interval_ms=Percentiles(**percentiles(rows[:, 3])),
        measurement_age_ms=Percentiles(**percentiles(rows[:, 2])),
        instrument_clock=InstrumentClock(
            kind=options.clock, drift_forgiven_ms=round(s_to_ms(session.intake.clock.forgiven_s), 3)
        ),
        rows=len(log),
        rows_dropped=log.dropped,
        seconds=round(seconds, 3),
        warnings=tuple(Remark(line=0, code=code, text=text) for code, text in _warnings(options)),
    )


def _warnings(options: LiveOptions) -> Iterator[tuple[str, str]]:
    """What nobody can see from here, and how it could be: codes and texts."""
    if not options.allow:
        yield (
            "any-sender",
            "nobody is named in [rsi] allow: the first sender of a good frame was taken for the controller, the first of a "
            "good measurement for the instrument",
        )
    if options.clock == "own":
        yield (
            "own-clock",
            "the instrument keeps a clock of its own: ages count from the least delay seen, so its constant part can't "
            f'be seen, nor data that fall behind by less than {options.drift_ppm:g} ppm; [instrument] clock = "shared" says that '
            "its stamps are this machine's system clock",
        )


def _frames(counts: SessionCounts) -> FrameCounts:
    return FrameCounts(
        received=counts.frames,
        answered=counts.answered,
        unanswered_after_stop=counts.unanswered_after_stop,
        answered_late=counts.answered_late,
        late_arrivals=counts.late_arrivals,
        missed=counts.missed,
        duplicate=counts.duplicate,
        out_of_order=counts.out_of_order,
        other_sender=counts.other_sender,
        not_allowed=counts.not_allowed,
        held_stale=counts.held_stale,
        held_implausible=counts.held_implausible,
        held_faulty=counts.held_faulty,
        refused=counts.refused,
    )


def _rounded(values: NDArray[np.float64]) -> tuple[float, ...]:
    return tuple(round(float(v), 6) for v in values)
