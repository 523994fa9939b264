"""How a session with a controller and an instrument is set up: whom it hears, what it believes, when it stops."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from camrob.errors import InputError
from camrob.frozen import locked
from camrob.loop.law import CorrectionLaw
from camrob.loop.rsi.setpoints import HISTORY_CYCLES
from camrob.loop.rsi.xml_frames import check_sen_type

__all__ = ["Address", "Clock", "LinkSettings", "Sender", "read_sender"]

Array = NDArray[np.float64]
Address = tuple[str, int]
"""Host and port of a UDP socket."""
Sender = tuple[str, int | None]
"""Who may send: an IPv4 address and a port; None for any port."""
Clock = Literal["own", "shared"]

_SENDER = re.compile(r"((?:[0-9]{1,3}\.){3}[0-9]{1,3}):([0-9]{1,5}|\*)")


@dataclass(frozen=True, slots=True)
class LinkSettings:
    """How a session works.

    `base_T_tracker` (4, 4) is the instrument's frame in `$BASE`. `clock` "shared": the instrument's stamps are this machine's
    system clock; "own": a clock of its own, apart by an unknown constant and `drift`, s a second. `latency_s`, with an own
    clock, is that constant part of a measurement's age, as far as somebody knows it. `noisy`: the instrument is known to be.
    `corrected` says that the controller's RSol already holds the correction (it is taken off then). A measurement farther
    than `error_m` or `error_rad` from the set-point isn't believed, nor one that moved by more than `jump_m` or `jump_rad`
    beyond what was commanded. `late_stop_cycles`: cycles of silence, or frames in a row answered late, that stop the session;
    `saturated_cycles`: cycles in a row with the total at its limit. `allow`: who is heard (empty: whoever sends first).
    Raises InputError for values that make no sense.
    """

    law: CorrectionLaw
    base_T_tracker: Array = field(default_factory=lambda: np.eye(4))
    sen_type: str = "ImFree"
    latency_s: float = 0.0
    corrected: bool = False
    error_m: float = 0.005
    error_rad: float = 0.02
    late_stop_cycles: int = 25
    clock: Clock = "own"
    drift: float = 1e-4
    noisy: bool = False
    jump_m: float = 5e-4
    jump_rad: float = 2e-3
    saturated_cycles: int = 250
    allow: tuple[Sender, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "base_T_tracker", locked(self.base_T_tracker, shape=(4, 4), name="base_T_tracker"))
        check_sen_type(self.sen_type)
        if not -0.2 <= self.latency_s <= 0.2:
            raise InputError(f"the instrument's latency is {self.latency_s} s", hint="give up to 200 ms")
        oldest = self.law.stale_after_cycles + max(self.latency_s, 0.0) / self.law.cycle_s
        if oldest >= HISTORY_CYCLES:
            raise InputError(
                f"measurements may be {oldest:.0f} cycles old, and set-points are kept for {HISTORY_CYCLES}",
                hint="give fewer cycles for which a measurement counts, or less latency",
            )
        if self.clock not in ("own", "shared"):
            raise InputError(f"the instrument's clock is {self.clock!r}", hint="give own or shared")
        if self.clock == "shared" and self.latency_s != 0.0:
            raise InputError(
                "a latency is given for an instrument that shares the clock",
                hint="leave it out (its stamps say it), or give clock = own",
            )
        if not 0.0 <= self.drift <= 0.01:
            raise InputError(f"the clock's drift is {self.drift * 1e6:g} ppm", hint="give 0 to 10000")
        bounds = (self.error_m, self.error_rad, self.jump_m, self.jump_rad)
        if not (
            all(0.0 < bound < np.inf for bound in bounds) and min(self.late_stop_cycles, self.saturated_cycles) >= 1
        ):
            raise InputError("a bound of the tracker's session isn't above 0", hint="give positive numbers")

    def hears(self, sender: Address) -> bool:
        """Whether anything from there is looked at."""
        return not self.allow or (sender[0], None) in self.allow or sender in self.allow


def read_sender(text: str) -> Sender:
    """ADDRESS:PORT, numbers alone (a name would ask somebody else who is meant), * for any port. Raises InputError."""
    match = _SENDER.fullmatch(text)
    parts = [] if match is None else [int(part) for part in match[1].split(".")]
    port = None if match is None or match[2] == "*" else int(match[2])
    if not parts or max(parts) > 255 or (port is not None and not 0 < port < 65536):
        hint = "give ADDRESS:PORT in numbers, such as 192.168.1.15:49152, or ADDRESS:*"
        raise InputError(f"{text!r} is not a sender's address", hint=hint)
    return ".".join(map(str, parts)), port
