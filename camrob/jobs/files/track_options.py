"""What `camrob tracker --listen` is asked for: from a cell's tracker.toml, then from the command line, in the units of both."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from camrob.errors import InputError
from camrob.loop.case import read_tracker_case
from camrob.loop.law import CorrectionLaw
from camrob.loop.rsi.link import Clock, LinkSettings, read_sender
from camrob.se3 import frame_from_mm_deg, mm_deg_from_frame
from camrob.units import deg_to_rad, m_to_mm, mm_to_m, ms_to_s, rad_to_deg, s_to_ms

__all__ = ["LiveOptions", "live_options"]

_CYCLES_MS = (4.0, 12.0)  # the two that RSI knows
_PPM = 1e-6  # one in a million
_SET: dict[str, Callable[[str], Any]] = {
    **dict.fromkeys(("limit_mm", "limit_deg", "step_mm", "step_deg"), float),
    **dict.fromkeys(("far_mm", "far_deg", "jump_mm", "jump_deg", "drift_ppm", "noise_mm"), float),
    **dict.fromkeys(("stale_after", "stop_after", "late_stop", "saturated_cycles"), int),
    "clock": str,
    "allow": lambda text: tuple(text.split(",")),
}


@dataclass(frozen=True, slots=True)
class LiveOptions:
    """What the server is asked for, in the units of the command line.

    `tracker_in_base` is the instrument's frame in `$BASE` (X, Y, Z, A, B, C; mm and degrees), the limits bound the total, the
    steps a cycle's increment; `far_mm`, `far_deg` is how far from the set-point a measurement is still believed, `jump_mm`,
    `jump_deg` how much farther it may have moved than the robot was. `corrected` says that RSol holds the correction already.
    `clock`, `drift_ppm`, `latency_ms`, `noise_mm` (0: not known) tell of the instrument. Cycles: a measurement counts for
    `stale_after`, is done without for `stop_after`; `late_stop` of silence or of late answers, and more than
    `saturated_cycles` with the correction at its limit stop it. `allow`: senders that are heard, ADDRESS:PORT.
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
    saturated_cycles: int = 250
    far_mm: float = 5.0
    far_deg: float = 1.0
    jump_mm: float = 0.5
    jump_deg: float = 0.1
    latency_ms: float = 0.0
    clock: Clock = "own"
    drift_ppm: float = 100.0
    noise_mm: float = 0.0
    allow: tuple[str, ...] = ()
    corrected: bool = False
    tracker_in_base: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    sen_type: str = "ImFree"

    def settings(self) -> LinkSettings:
        """The same in SI. Raises InputError for a value that makes no sense."""
        if self.cycle_ms not in _CYCLES_MS:
            raise InputError(f"the cycle is {self.cycle_ms:g} ms", hint="RSI knows 4 (#IPO_FAST) and 12 (#IPO)")
        frame = np.array(self.tracker_in_base, dtype=float)
        if frame.shape != (6,) or not np.isfinite(frame).all():
            raise InputError("the tracker's frame isn't six numbers", hint="give X,Y,Z,A,B,C in mm and degrees")
        if not 0.0 <= self.noise_mm < np.inf:
            raise InputError(f"the instrument's noise is {self.noise_mm} mm", hint="give 0 where it isn't known")
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
            base_T_tracker=frame_from_mm_deg(frame),
            sen_type=self.sen_type,
            latency_s=ms_to_s(self.latency_ms),
            corrected=self.corrected,
            error_m=mm_to_m(self.far_mm),
            error_rad=deg_to_rad(self.far_deg),
            late_stop_cycles=self.late_stop,
            clock=self.clock,
            drift=self.drift_ppm * _PPM,
            noisy=self.noise_mm > 0.0,
            jump_m=mm_to_m(self.jump_mm),
            jump_rad=deg_to_rad(self.jump_deg),
            saturated_cycles=self.saturated_cycles,
            allow=tuple(read_sender(text) for text in self.allow),
        )


def live_options(options: LiveOptions | None, cell: Path | None, said: Mapping[str, Any]) -> LiveOptions:
    """The options given, else the cell's, else the usual ones, with what was `said` put in by name, its "bounds" being texts
    NAME=VALUE. Raises InputError for a name or a value that is none, and CellError for a tracker.toml that is wrong.
    """
    options = options or (LiveOptions() if cell is None else _of_cell(Path(cell)))
    values = dict(said)
    for pair in values.pop("bounds", ()):
        name, equals, text = pair.partition("=")
        if not equals or name not in _SET:
            raise InputError(f"{pair!r} sets nothing", hint="give NAME=VALUE, NAME one of " + ", ".join(_SET))
        try:
            values[name] = _SET[name](text)
        except ValueError:
            kind = "whole number" if _SET[name] is int else "number"
            raise InputError(f"{pair!r} gives no {kind}", hint=f"give NAME=VALUE, VALUE a {kind}") from None
    if isinstance(frame := values.get("tracker_in_base"), str):
        try:
            values["tracker_in_base"] = tuple(float(v) for v in frame.split(","))
        except ValueError:
            raise InputError(
                "the tracker's frame isn't six numbers", hint="give X,Y,Z,A,B,C in mm and degrees"
            ) from None
    return replace(options, **values)


def _of_cell(cell: Path) -> LiveOptions:
    """What a cell's tracker.toml says of the loop, the instrument and RSI."""
    case = read_tracker_case(cell.parent if cell.suffix == ".toml" and not cell.is_dir() else cell)
    law, frame = case.law, mm_deg_from_frame(case.base_T_tracker)
    options = LiveOptions(
        gain=law.gain,
        cycle_ms=round(s_to_ms(law.cycle_s), 6),
        limit_mm=m_to_mm(law.limit_m),
        limit_deg=rad_to_deg(law.limit_rad),
        step_mm=m_to_mm(law.step_m),
        step_deg=rad_to_deg(law.step_rad),
        noise_mm=m_to_mm(case.noise.position),
        tracker_in_base=tuple(frame.tolist()),
    )
    return replace(options, **case.link)
