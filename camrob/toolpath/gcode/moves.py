"""Moves of a G-code program: rapids and cuts from where the frame stands, and the feed of a cut."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError
from camrob.findings import Severity
from camrob.machine_tool import pieces, reach
from camrob.toolpath.defaults import Defaults, check_feed
from camrob.toolpath.gcode.coordinates import Stance, ToolFrame
from camrob.toolpath.gcode.cut_path import PathGrower
from camrob.toolpath.gcode.lexer import Block
from camrob.toolpath.gcode.state import Modal
from camrob.toolpath.gcode.tools import Process, refuse_other_length
from camrob.units import m_to_mm, mm_min_to_m_s, rad_to_deg

__all__ = ["Motions"]

_FASTEST = 1.0  # m/s: a programmed cutting feed above this is said
_HALF_TURN = math.pi * (1.0 + 1e-6)
_RESTING = 1e-6  # m: a tip that goes less far while the tool turns only turns on the spot


class Motions:
    """Takes the tool to where the frame stands; `defaulted` is the line of the first cut that took the set-up's feed."""

    def __init__(self, path: PathGrower, frame: ToolFrame, modal: Modal, process: Process, defaults: Defaults) -> None:
        self.path = path
        self.frame = frame
        self.modal = modal
        self.process = process
        self.defaults = defaults
        self.defaulted = 0
        self._last_feed = 0.0

    def rapid(self, line: int) -> None:
        """A rapid move to where the frame stands now, or the loss of the place."""
        frame = self.frame
        if frame.placeable and frame.known:
            to = frame.stance()
            if self.modal.oriented and self.path.place is not None:
                self._not_askew(self.path.place, to)
            self.path.rapid(to, line)
            return
        self.path.lose(home=not self.path.adrift)
        if not frame.placeable:
            self.path.note(
                "unplaced-rapid",
                "rapid moves with turned axes and the tool centre point off are left out:"
                " where the tip goes depends on the machine",
                line,
                Severity.INFO,
            )

    def _not_askew(self, place: Stance, to: Stance) -> None:
        """Raises ToolpathError for a way down with the spindle at an angle: a tool that has to pass a wall beside its edge."""
        down = sum((a - b) * c for a, b, c in zip(to.tip, place.tip, to.axis, strict=True))
        if down < -_RESTING:
            raise ToolpathError(
                f"the tool goes down with the spindle held at an angle (M19 in line {self.modal.oriented}: back boring), which a "
                "robot's spindle doesn't do",
                hint="bore from the front, or start the spindle before the way down",
            )

    def turning(self, block: Block, begin: list[float]) -> bool:
        """A straight cut that turns the axes of a machine whose kinematics is told, piece by piece.

        begin: X, Y, Z (m), A, B, C (rad) where it begins. False where it is no such cut, or its beginning isn't known.
        Raises ToolpathError for more than half a turn, which may go either way round.
        """
        frame, machine = self.frame, self.frame.machine
        start, end = np.array(begin), np.array((*frame.xyz, *frame.angles))
        turn = float(np.abs(end[3:] - start[3:]).max())
        if machine is None or frame.plane is not None or turn == 0.0 or not np.isfinite(end - start).all():
            return False
        if frame.vector is not None or self.path.place is None or not frame.placeable:
            return False
        if turn > _HALF_TURN:
            raise ToolpathError(
                "a rotary axis turns by more than 180 degrees within one cut: an axis that rolls over goes the shorter way",
                hint="post cuts in shorter moves",
            )
        shift = np.array((*frame.shift, 0.0, 0.0, 0.0))
        if frame.tcp:
            start[:3], end[:3] = frame.program.out(start[:3]), frame.program.out(end[:3])
        length = 0.0 if frame.tcp else reach(machine, frame.tool)
        ends = (start + shift, end + shift)
        tips, axes, way = pieces(machine, length, ends, tcp=frame.tcp, chord=self.path.chord, angle=self.path.angle)
        feed = self._turning_feed(block, end - start, way)
        for tip, axis in zip(tips.tolist(), axes.tolist(), strict=True):
            self.path.cut(Stance(tuple(tip), tuple(axis), (0.0, 0.0, 0.0), False, True), feed, block.line)
        return True

    def _turning_feed(self, block: Block, goes: NDArray[np.float64], length: float) -> float:
        """Speed (m/s) of the tip, which goes `length` (m) while the axes go X, Y, Z (m), A, B, C (rad)."""
        frame, modal, to = self.frame, self.modal, self.frame.stance()
        if frame.tcp or modal.feed_mode == 930 or length <= _RESTING:
            return self.feed(block, length, to)
        counts = "" if frame.machine is None else frame.machine.feed
        if not counts:
            raise ToolpathError(
                "a cut that turns rotary axes at F (G94): what F counts there is the machine's own",
                hint='write feed = "linear" (X, Y and Z alone) or "all" (degrees as lengths) into its file, or post G93',
            )
        linear, degrees = float(np.linalg.norm(goes[:3])) / modal.scale, rad_to_deg(goes[3:])
        if counts == "all" or not linear > _RESTING / modal.scale:
            linear = math.hypot(linear, float(np.linalg.norm(degrees)))
        return self.feed(block, length, to, share=length / (linear * modal.scale))

    def to_height(self, height: float, block: Block, *, cut: bool) -> None:
        """Move along a cycle's normal, in the program's frame."""
        self.frame.xyz[2] = height
        if not cut:
            self.rapid(block.line)
            return
        self.cuttable()
        to = self.frame.stance()
        self.path.cut(to, self.feed(block, math.nan, to), block.line)

    def cuttable(self) -> None:
        """Before a cut: refuse one whose tip can't be told, or that has no tool."""
        self.process.settle_cut()
        self.modal.cut = True
        frame = self.frame
        if self.modal.suspended:
            raise ToolpathError(
                "a cut without the work offset (G500, G53 alone) behind others with it", hint="name G54 before it"
            )
        if self.modal.unmeasured:
            raise ToolpathError(
                "a cut without the tool's length (G49) behind G43: Z is the spindle's there, and the length the machine's",
                hint="name G43 H before it, or take G49 out",
            )
        refuse_other_length(self.modal, self.path.tool)
        if not frame.placeable:
            if frame.plane is not None:
                raise ToolpathError(
                    "a cut in a tilted plane (G68.2) with the tool not turned onto it", hint="put G53.1 behind G68.2"
                )
            if frame.tcp:
                raise ToolpathError(
                    "a cut with rotary angles that only the control knows (G53.1, G69)",
                    hint="name both rotary axes in a rapid move before the cut",
                )
            if not frame.oriented:
                raise ToolpathError(
                    "a cut with rotary axes at angles that only the control knows (behind a plane or tool centre point that has "
                    "ended, or at a machine position)",
                    hint="name both rotary axes in a rapid move before the cut, or swivel to a plane with angles 0",
                )
            raise ToolpathError(
                "a cut with turned rotary axes while the tool centre point is off",
                hint="post with TCP on (G43.4, M128, M428 or TRAORI), or describe the machine in a file that setup.toml names "
                'as machine = "FILE.toml": without it X Y Z are machine axes, not the tip',
            )
        if not frame.known:
            missing = " and ".join(a for a, v in zip("XYZ", frame.xyz, strict=True) if v != v)
            raise ToolpathError(
                f"a cut while {missing} has no known value", hint=f"name {missing} in a rapid move before the cut"
            )

    def feed(self, block: Block, length: float, to: Stance, *, share: float = 1.0) -> float:
        """Speed (m/s) of the tip on a move of `length` (m); share: what it goes of a unit that F counts."""
        modal = self.modal
        if modal.feed_mode == 930:
            feed = self._inverse_time(block, length, to)
        else:
            feed = share * self._modal_feed(block.line)
        check_feed(feed, block.line, 0)
        if feed > _FASTEST:
            self.path.note(
                "feed-implausible", "a cutting feed of more than 60 m/min: check G93, G94 and units", block.line
            )
        self._last_feed = feed
        return feed

    def _modal_feed(self, line: int) -> float:
        """Speed (m/s) of F, or of the set-up where the program has stated no F."""
        modal = self.modal
        if modal.feed is None and self.defaults.feed is not None:
            self.defaulted = self.defaulted or line
            return self.defaults.feed
        if modal.feed is None or not modal.feed > 0.0:
            raise ToolpathError(
                "a cut without a feed",
                hint="program F above zero before the first cut, or put feed_mm_min into setup.toml",
            )
        feed = mm_min_to_m_s(m_to_mm(modal.feed * modal.feed_scale))
        if modal.feed_mode != 950:
            return feed
        rpm = self.process.rpm()
        if not rpm > 0.0:
            raise ToolpathError("feed per revolution (G95) without a spindle speed", hint="program S before it")
        return feed * rpm

    def _inverse_time(self, block: Block, length: float, to: Stance) -> float:
        """Speed (m/s) of a block that takes 1/F minutes (G93)."""
        rate = block.words.get("F", 0.0)
        if not rate > 0.0:
            raise ToolpathError("a cut in inverse-time feed (G93) without its own F", hint="every such block needs F")
        if math.isnan(length):
            raise ToolpathError(
                "an inverse-time cut from an unknown place has no speed", hint="name X, Y and Z in a move before it"
            )
        place = self.path.place
        turns = place is not None and place.axis != to.axis
        if length > _RESTING or (length > 0.0 and not turns):
            return mm_min_to_m_s(m_to_mm(length) * rate)
        if turns:
            self.path.note(
                "turn-on-the-spot",
                "inverse-time blocks that only turn the tool get the feed of the cut before them",
                block.line,
                Severity.INFO,
            )
            if not self._last_feed > 0.0:
                raise ToolpathError(
                    "the first cut only turns the tool, so it has no path speed", hint="turn in a rapid"
                )
        return self._last_feed
