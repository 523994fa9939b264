"""`camrob tracker --listen`: answer a controller's RSI frames until something ends it, then say what happened."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from camrob.controller.tracker.case import read_tracker_case
from camrob.controller.tracker.cycle_log import CycleLog, percentiles
from camrob.controller.tracker.law import CorrectionLaw
from camrob.controller.tracker.rsi_server import RsiServer
from camrob.controller.tracker.session import FAULTS, Address, LinkSettings, SessionCounts, TrackerSession
from camrob.errors import InputError
from camrob.jobs.failure import DONE, NOT_SAFE
from camrob.jobs.files import staged_output
from camrob.se3 import frame_from_xyzabc, xyzabc_from_frame
from camrob.units import deg_to_rad, m_to_mm, mm_to_m, ms_to_s, rad_to_deg, s_to_ms

__all__ = ["LiveOptions", "TrackLiveResult", "track_live"]

_CYCLES_MS = (4.0, 12.0)
_BOUNDS: dict[str, Callable[[str], float]] = {
    **dict.fromkeys(("limit_mm", "limit_deg", "step_mm", "step_deg", "far_mm", "far_deg"), float),
    **dict.fromkeys(("stale_after", "stop_after", "late_stop"), int),
}


@dataclass(frozen=True, slots=True)
class LiveOptions:
    """What the server is asked for, in the units of the command line.

    `tracker_in_base` is the instrument's frame in `$BASE` (X, Y, Z, A, B, C; mm and degrees), the limits bound the total, the
    steps a cycle's increment; `far_mm`, `far_deg` is how far from the set-point a measurement is still believed. `corrected`
    says that RSol holds the correction already.
    """

    mode: Literal["absolute", "relative"] = "absolute"
    gain: float = 0.01
    cycle_ms: float = 4.0
    limit_mm: float = 3.0
    limit_deg: float = 0.5
    step_mm: float = 0.02
    step_deg: float = 0.005
    stale_after: int = 2
    stop_after: int = 25
    late_stop: int = 25
    far_mm: float = 5.0
    far_deg: float = 1.0
    latency_ms: float = 0.0
    corrected: bool = False
    tracker_in_base: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    sen_type: str = "ImFree"

    def settings(self) -> LinkSettings:
        """The same in SI. Raises InputError for a value that makes no sense."""
        if self.cycle_ms not in _CYCLES_MS:
            raise InputError(f"the cycle is {self.cycle_ms:g} ms", cure="RSI knows 4 (#IPO_FAST) and 12 (#IPO)")
        frame = np.array(self.tracker_in_base, dtype=float)
        if frame.shape != (6,) or not np.isfinite(frame).all():
            raise InputError("the tracker's frame isn't six numbers", cure="give X,Y,Z,A,B,C in mm and degrees")
        law = CorrectionLaw(
            gain=self.gain,
            limit_m=mm_to_m(self.limit_mm),
            limit_rad=deg_to_rad(self.limit_deg),
            mode=self.mode,
            stale_after_cycles=self.stale_after,
            stop_after_cycles=self.stop_after,
            cycle_s=ms_to_s(self.cycle_ms),
            step_m=mm_to_m(self.step_mm),
            step_rad=deg_to_rad(self.step_deg),
        )
        return LinkSettings(
            law,
            base_T_tracker=frame_from_xyzabc(np.concatenate([mm_to_m(frame[:3]), deg_to_rad(frame[3:])])),
            sen_type=self.sen_type,
            latency_s=ms_to_s(self.latency_ms),
            corrected=self.corrected,
            error_m=mm_to_m(self.far_mm),
            error_rad=deg_to_rad(self.far_deg),
            late_stop_cycles=self.late_stop,
        )


@dataclass(frozen=True, slots=True)
class TrackLiveResult:
    """The summary as JSON, and what it was made from."""

    summary: Mapping[str, Any]
    session: TrackerSession
    log: CycleLog

    @property
    def status(self) -> int:
        """What the command ends with: 3 after a fault, 0 otherwise."""
        return NOT_SAFE if self.fault else DONE

    @property
    def fault(self) -> bool:
        """True where a fault ended it, so that the robot was stopped."""
        return bool(self.summary["stopped"]["fault"])


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
    progress: Callable[[str, float], None] | None = None,
) -> TrackLiveResult:
    """Serve a controller on `listen` from an instrument on `instrument` until a fault, an interruption, or `duration_s`.

    `options` are the cell's (those of its tracker.toml) where there is one; `said` overrides them by name, its "bounds" being
    texts NAME=VALUE. Whatever ends it, the answers end with it, and the summary says why. With `out`, `tracker.csv` (a row
    for each answer) and `tracker.json` appear there afterwards. `realtime` asks for real-time priority; `ready` is told when
    both ports are open.
    Raises InputError for an address or an option that is wrong.
    """
    options = _overridden(options or (LiveOptions() if cell is None else _of_cell(Path(cell))), said or {})
    settings = options.settings()
    if duration_s is not None and not 0.0 < duration_s < float("inf"):
        raise InputError(f"the duration is {duration_s} s", cure="give a positive number of seconds")
    start = time.monotonic()
    with RsiServer(settings, listen=_address(listen), instrument=_address(instrument)) as server:
        where = "waiting on {}:{}".format(*server.controller_address)
        if progress is not None:
            progress(where, 0.0)
        ready(server)
        session = server.serve(duration_s=duration_s, should_stop=should_stop, realtime=realtime)
    summary = _summary(options, server, session, time.monotonic() - start)
    if out is not None:
        with staged_output(Path(out)) as folder:
            server.log.write(folder / "tracker.csv")
            (folder / "tracker.json").write_text(
                json.dumps(summary, indent=2, allow_nan=False) + "\n", encoding="utf-8"
            )
    return TrackLiveResult(summary, session, server.log)


def _of_cell(cell: Path) -> LiveOptions:
    """The loop's values and the tracker's frame of a cell's tracker.toml."""
    case = read_tracker_case(cell.parent if cell.suffix == ".toml" and not cell.is_dir() else cell)
    law, frame = case.law, xyzabc_from_frame(case.base_T_tracker)
    return LiveOptions(
        gain=law.gain,
        cycle_ms=round(s_to_ms(law.cycle_s), 6),
        limit_mm=m_to_mm(law.limit_m),
        limit_deg=rad_to_deg(law.limit_rad),
        step_mm=m_to_mm(law.step_m),
        step_deg=rad_to_deg(law.step_rad),
        tracker_in_base=(*m_to_mm(frame[:3]).tolist(), *rad_to_deg(frame[3:]).tolist()),
    )


def _overridden(options: LiveOptions, said: Mapping[str, Any]) -> LiveOptions:
    """The options with what was said put in. Raises InputError for a name or a value that is none."""
    values = dict(said)
    for pair in values.pop("bounds", ()):
        name, equals, text = pair.partition("=")
        if not equals or name not in _BOUNDS:
            raise InputError(f"{pair!r} sets nothing", cure="give NAME=VALUE, NAME one of " + ", ".join(_BOUNDS))
        try:
            values[name] = _BOUNDS[name](text)
        except ValueError:
            kind = "whole number" if _BOUNDS[name] is int else "number"
            raise InputError(f"{pair!r} gives no {kind}", cure=f"give NAME=VALUE, VALUE a {kind}") from None
    if "tracker_in_base" in values and isinstance(values["tracker_in_base"], str):
        try:
            values["tracker_in_base"] = tuple(float(v) for v in values["tracker_in_base"].split(","))
        except ValueError:
            raise InputError(
                "the tracker's frame isn't six numbers", cure="give X,Y,Z,A,B,C in mm and degrees"
            ) from None
    return replace(options, **values)


def _address(text: str) -> Address:
    """HOST:PORT, an IPv4 address or a name."""
    match = re.fullmatch(r"([A-Za-z0-9_.\-]{1,253}):([0-9]{1,5})", text)
    if match is None or int(match[2]) > 65535:
        raise InputError(f"{text!r} is no address", cure="give HOST:PORT, such as 127.0.0.1:59152")
    return match[1], int(match[2])


def _summary(options: LiveOptions, server: RsiServer, session: TrackerSession, seconds: float) -> dict[str, Any]:
    log, counts, stop = server.log, session.counts, session.stopped
    rows = log.rows
    cycle = ms_to_s(options.cycle_ms)
    total = session.state.total
    largest = np.abs(rows[:, 16:22]).max(axis=0, initial=0.0)
    code, text = ("internal", "it ended without a reason") if stop is None else stop
    return {
        "mode": options.mode,
        "gain": options.gain,
        "cycle_ms": options.cycle_ms,
        "controller": None if session.controller is None else "{}:{}".format(*session.controller),
        "instrument": None if session.instrument is None else "{}:{}".format(*session.instrument),
        "stopped": {"code": code, "text": text, "fault": code in FAULTS},
        "frames": _frames(counts),
        "measurements": {
            "received": counts.measurements,
            "kept": counts.measurements_kept,
            "other_sender": counts.measurements_other_sender,
            "refused": dict(counts.measurements_refused),
        },
        "correction": {
            "total_mm": _rounded(m_to_mm(total[:3])),
            "total_deg": _rounded(rad_to_deg(total[3:])),
            "largest_mm": _rounded(m_to_mm(largest[:3])),
            "largest_deg": _rounded(rad_to_deg(largest[3:])),
            "saturated_cycles": counts.saturated,
        },
        "latency_ms": {**percentiles(rows[:, 1]), "from": "kernel" if server.kernel_stamps else "process"},
        "within_cycle": None if not len(rows) else round(float(np.mean(rows[:, 1] <= cycle)), 6),
        "interval_ms": percentiles(rows[:, 3]),
        "measurement_age_ms": percentiles(rows[:, 2]),
        "rows": len(log),
        "rows_dropped": log.dropped,
        "seconds": round(seconds, 3),
    }


def _frames(counts: SessionCounts) -> dict[str, Any]:
    names = (
        "answered", "unanswered_after_stop", "answered_late", "late_arrivals", "missed", "duplicate", "out_of_order",
        "other_sender", "held_stale", "held_implausible",
    )  # fmt: skip
    return {
        "received": counts.frames,
        **{name: getattr(counts, name) for name in names},
        "refused": dict(counts.refused),
    }


def _rounded(values: Any) -> list[float]:
    return [round(float(v), 6) for v in values]
