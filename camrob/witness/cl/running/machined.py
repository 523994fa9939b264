"""Blocks that turn the rotary axes of a machine whose kinematics is told: the way that the tool takes past the part."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from camrob.witness.cl.standing import TURNED, Words
from camrob.witness.cl.switching import Switching
from camrob.witness.happenings import Kind, Way
from camrob.witness.machine_tool import MachineTool

__all__ = ["Machined"]

Array = NDArray[np.float64]
At = dict[str, float | None]
_STEP = 0.25  # degrees: on a radius of 300 mm the way bows by 1 micrometre between such steps
_STILL = 1e-6  # m


class Machined(Switching):
    """Tells straight blocks; those that turn a known machine's axes piece by piece. beside: text of other files."""

    beside = ""
    ngc = False  # the file's suffix is LinuxCNC's

    def _process(self, g: list[str], m: list[str], words: Words, line: int, moves: bool) -> None:
        """What comes before the block's motion; the head of a known machine turns the tool that is in it then."""
        super()._process(g, m, words, line, moves)
        machine = self._stand.machine
        if machine is not None and machine.head:
            tool = next((event.value for event in reversed(self._tell.events) if event.kind is Kind.TOOL), 0.0)
            self._stand.length = machine.length(int(tool))

    def _move(self, tip: Array, axis: Array, way: Way, line: int, feed: float | None = None) -> None:
        """To a tip in the program's frame. In rapid with turned axes, X, Y, Z are a machine position."""
        odd = self._stand.odd
        if odd == TURNED and way == Way.RAPID:
            self._tell.lose()
        elif odd:
            self._tell.gap(line, odd)
        else:
            self._tell.move(self._stand.point(tip), axis, way, line, feed)

    def _turning(self, before: At, way: Way, line: int, minutes: float, scale: float) -> bool:
        """Tells a straight block that goes from `before` to where the axes stand; minutes: what it takes (G93), 0 where F is a
        speed; scale: metres in a unit of F. False where it turns no known axes of a machine.
        """
        stand, after = self._stand, self._stand.at
        machine = stand.machine
        if machine is None or not stand.by_axes:
            return False
        ends = np.array([[at[letter] for letter in "XYZABC"] for at in (before, after)], float)  # None: NaN
        turns = ends[1, 3:] - ends[0, 3:]
        if not np.isfinite(ends).all() or not np.any(turns):
            return False
        if stand.odd:
            self._tell.gap(line, stand.odd)
            return True
        count = 2 * math.ceil(float(np.abs(turns).max()) / (2.0 * _STEP))
        places = [self._seen(machine, *row) for row in np.linspace(ends[0], ends[1], count + 1)]
        if way == Way.RAPID:  # each axis goes as fast as it can
            self._tell.lose()
            self._tell.move(*places[-1], way, line)
            return True
        if float(np.abs(turns).max()) > 180.0:
            self._tell.gap(
                line, "a rotary axis by more than half a turn, which one that rolls over goes the other way round"
            )
        tips = np.array([tip for tip, _ in places])
        chords, double = (np.linalg.norm(np.diff(tips[::n], axis=0), axis=1).sum() for n in (1, 2))
        length = float(4.0 * chords - double) / 3.0  # of the curve: what chords lack falls with their square
        feed = self._tip_speed(machine, length, ends[1] - ends[0], line, minutes, scale)
        for tip, axis in places[1:]:
            self._tell.move(tip, axis, way, line, feed)
        return True

    def _seen(self, machine: MachineTool, *row: float) -> tuple[Array, Array]:
        """Tip (m) and tool axis in the part, of X, Y, Z (m), A, B, C (degrees)."""
        stand = self._stand
        pose = machine.seen(dict(zip("XYZABC", map(float, row), strict=True)), 0.0 if stand.tcp else stand.length)
        return np.array(row[:3]) if stand.tcp else pose[:3, 3], pose[:3, 2]

    def _tip_speed(
        self, machine: MachineTool, length: float, goes: Array, line: int, minutes: float, scale: float
    ) -> float:
        """m/s of the tip, which goes `length` (m) while the axes go X, Y, Z (m), A, B, C (degrees); NaN where nobody says."""
        if length < _STILL:
            return math.nan
        if minutes:
            return length / (60.0 * minutes)
        speed = self._tell.speed(line)
        if self._stand.tcp:
            return speed
        if not machine.counts:
            self._tell.gap(line, "a cut that turns axes, and what F counts there isn't told", lost=False)
            return math.nan
        linear = float(np.linalg.norm(goes[:3]))
        counted = linear if machine.counts == "linear" else math.hypot(linear, float(np.linalg.norm(goes[3:])) * scale)
        if linear < _STILL:
            counted = float(np.linalg.norm(goes[3:])) * scale
        return speed * length / counted
