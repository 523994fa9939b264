"""What G-code blocks mean: modal state, motion, feed, spindle and coolant, one block after the other."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError
from camrob.issues import Severity
from camrob.toolpath.gcode_arc import circle
from camrob.toolpath.gcode_cycle import CYCLES, Step, hole
from camrob.toolpath.gcode_frame import ToolFrame
from camrob.toolpath.gcode_lexer import Block
from camrob.toolpath.gcode_path import PathGrower, Stance
from camrob.toolpath.gcode_setup import apply_setup
from camrob.toolpath.gcode_state import Modal
from camrob.toolpath.region import EventKind
from camrob.toolpath.sampling import arc_angle, arc_radius
from camrob.units import deg_to_rad, m_to_mm, mm_min_to_m_s

__all__ = ["Interpreter"]

_MOTION = frozenset((0, 10, 20, 30)) | CYCLES
_AXES = frozenset("XYZABC")
_ARC_WORDS = frozenset("XYZABCIJKR")
_DEGREE = deg_to_rad(1.0)
_LONG_WAY = math.pi * (1.0 + 1e-6)
_FASTEST = 1.0  # m/s: a programmed cutting feed above this is said
_MOST_HOLES = 10_000  # of one block
_SPINDLE = {30: "CLW", 40: "CCLW"}
_COOLANT = {70: "MIST", 80: "FLOOD"}
_SUBPROGRAM = frozenset((960, 970, 980, 990))


class Interpreter:
    """Runs blocks into a `PathGrower`; `ended` is true after M2 or M30."""

    def __init__(self, path: PathGrower, frame: ToolFrame, modal: Modal) -> None:
        self.path = path
        self.frame = frame
        self.modal = modal
        self.ended = False
        self._last_feed = 0.0

    def run(self, block: Block) -> None:
        """Carry one block out. Raises ToolpathError (without its place) for what can't be read honestly."""
        line, words, modal = block.line, block.words, self.modal
        if block.comment:
            self.path.comment(block.comment, line)
        if block.optional:
            self.path.note("block-delete", "blocks behind a slash are taken as switched on", line)
        motion = modal.motion
        consumed = False
        if block.g:
            motion, consumed = self._codes(block, motion)
        self._values(block)
        if block.m or "S" in words:
            self._before(block)
        if words and not consumed and not (_ARC_WORDS if motion in (20, 30) else _AXES).isdisjoint(words):
            self._motion(block, motion)
        elif motion in CYCLES and "R" in words and not consumed:
            self._cycle(block, motion)
        if block.m:
            self._after(block)

    def _codes(self, block: Block, motion: int | None) -> tuple[int | None, bool]:
        """Carry the G codes of a block out, except for motion: the motion code now, whether axis words are used up."""
        setup = []
        named: int | None = None
        for code in block.g:
            if code in _MOTION or code == 800:
                if named is not None and named != code and 800 not in (named, code):
                    raise ToolpathError(
                        f"G{named / 10:g} and G{code / 10:g} in one block", cure="keep one motion code a block"
                    )
                named = code if named in (None, 800) else named
            else:
                setup.append(code)
        if named is not None:
            if named in CYCLES and (motion not in CYCLES):
                self.modal.cycle_start = self.frame.xyz[2]
            if named not in CYCLES:
                self.modal.cycle.clear()
            motion = self.modal.motion = None if named == 800 else named
        consumed = apply_setup(setup, block, self.modal, self.frame, self.path) if setup else False
        if 533 in setup:
            motion = 0
        return motion, consumed

    def _values(self, block: Block) -> None:
        """F, T, S and letters that have no meaning here."""
        words, modal = block.words, self.modal
        if "F" in words and 40 not in block.g:
            modal.feed = words["F"]
            modal.feed_scale = modal.scale
        if "T" in words:
            modal.next_tool = self._tool(words["T"])
            if modal.tool_by_t and modal.next_tool != self.path.tool:
                self.path.change_tool(modal.next_tool, block.line)
        for letter in ("U", "V", "W"):
            if letter in words and 40 not in block.g:
                raise ToolpathError(
                    f"a {letter} word: secondary axes and lathe increments are not read", cure="export X, Y, Z, A, B, C"
                )
        if "O" in words:
            if len(words) > 1 or block.g or block.m or modal.named or modal.moved:
                raise ToolpathError(
                    "O-words (subprograms, or several programs in one file) are not read",
                    cure="have the CAM system write one program with plain blocks",
                )
            modal.named = True

    @staticmethod
    def _tool(value: float) -> int:
        """A tool number."""
        if value != int(value) or not 0 <= value < 1e8:
            raise ToolpathError(f"T{value:g} is no tool number", cure="a whole number")
        return int(value)

    def _before(self, block: Block) -> None:
        """M codes that act before the motion: tool change, spindle and coolant on."""
        modal, path, line = self.modal, self.path, block.line
        if 60 in block.m:
            if modal.next_tool is None:
                raise ToolpathError("M6 without a T word before it", cure="name the tool, for example T1 M6")
            if modal.next_tool != path.tool:
                path.change_tool(modal.next_tool, line)
        turning = [code for code in block.m if code in _SPINDLE]
        if "S" in block.words and 40 not in block.g:
            if block.words["S"] < 0.0:
                raise ToolpathError("a negative spindle speed", cure="use M4 for the other direction")
            changed = block.words["S"] != modal.speed
            modal.speed = block.words["S"]
            if changed and modal.spindle and not turning:
                path.event(EventKind.SPINDLE_ON, modal.speed, modal.spindle, line)
        for code in turning:
            modal.spindle = _SPINDLE[code]
            path.event(EventKind.SPINDLE_ON, modal.speed, modal.spindle, line)
        for code in block.m:
            if code in _COOLANT:
                modal.coolant = True
                path.event(EventKind.COOLANT_ON, 0.0, _COOLANT[code], line)
            elif code in (1280, 4280):
                self.frame.switch_tcp(True, by_m=True)
            elif code in _SUBPROGRAM:
                raise ToolpathError(
                    f"M{code / 10:g} calls or ends a subprogram, which is not read",
                    cure="have the CAM system write one program without subprograms",
                )
            elif code == 4300:
                raise ToolpathError("M430 selects a kinematics of the user's own", cure="use M428 with XYZAC or XYZBC")

    def _after(self, block: Block) -> None:
        """M codes that act after the motion: spindle and coolant off, TCP off, stop, end."""
        for code in block.m:
            if code == 50:
                self._spindle_off(block.line)
            elif code == 90:
                self._coolant_off(block.line)
            elif code in (0, 10, 600):
                self.path.event(EventKind.STOP, 0.0, f"M{code // 10}", block.line)
            elif code in (1290, 4290):
                self.frame.switch_tcp(False, by_m=True)
            elif code in (20, 300):
                self._spindle_off(block.line)
                self._coolant_off(block.line)
                self.ended = True
            elif code not in _SPINDLE and code not in _COOLANT and code not in (60, 1280, 4280):
                self.path.note("unknown-m-code", f"M{code / 10:g} has no meaning here and is left out", block.line)

    def _spindle_off(self, line: int) -> None:
        if self.modal.spindle:
            self.path.event(EventKind.SPINDLE_OFF, 0.0, "", line)
        self.modal.spindle = ""

    def _coolant_off(self, line: int) -> None:
        if self.modal.coolant:
            self.path.event(EventKind.COOLANT_OFF, 0.0, "", line)
        self.modal.coolant = False

    # -- motion ------------------------------------------------------------------------------------------------

    def _motion(self, block: Block, motion: int | None) -> None:
        """Move as the modal motion code says."""
        if motion is None:
            raise ToolpathError(
                "coordinates before any of G0, G1, G2, G3 (or after G80)", cure="name the kind of motion in the block"
            )
        modal, frame, words = self.modal, self.frame, block.words
        modal.first_move(self.path, block.line)
        if motion in CYCLES:
            self._cycle(block, motion)
            return
        before, turned_before = frame.xyz.copy(), frame.angles[2]
        frame.move(words, modal.scale, _DEGREE, modal.incremental)
        if motion == 0:
            self._rapid(block.line)
            return
        self._cuttable()
        if "C" in words and abs(frame.angles[2] - turned_before) > _LONG_WAY and self.path.place is not None:
            self.path.note(
                "rotary-long-way",
                "C turns by more than 180 degrees within one cut; read as the numbers say, without rollover",
                block.line,
            )
        to = self._stance()
        if motion == 10:
            place = self.path.place
            length = math.nan if place is None else math.dist(place.tip, to.tip)
            self.path.cut(to, self._feed(block, length, to), block.line)
        else:
            self._arc(block, motion, np.array(before), to)

    def _rapid(self, line: int) -> None:
        """A rapid move to where the frame stands now, or the loss of the place."""
        frame = self.frame
        if frame.placeable and frame.known:
            self.path.rapid(self._stance(), line)
            return
        self.path.lose()
        if not frame.placeable:
            self.path.note(
                "unplaced-rapid",
                "rapid moves with turned axes and the tool centre point off are left out:"
                " where the tip goes depends on the machine",
                line,
                Severity.INFO,
            )

    def _cuttable(self) -> None:
        """Refuse a cut whose tip can't be told."""
        frame = self.frame
        if not frame.placeable:
            if frame.plane is not None:
                raise ToolpathError(
                    "a cut in a tilted plane (G68.2) with the tool not turned onto it", cure="put G53.1 behind G68.2"
                )
            if frame.tcp:
                raise ToolpathError(
                    "a cut with rotary angles that only the control knows (G53.1, G69)",
                    cure="name both rotary axes in a rapid move before the cut",
                )
            raise ToolpathError(
                "a cut with turned rotary axes while the tool centre point is off",
                cure="post with TCP on (G43.4, M128, M428 or TRAORI): without it X Y Z are machine axes, not the tip",
            )
        if not frame.known:
            missing = " and ".join(a for a, v in zip("XYZ", frame.xyz, strict=True) if v != v)
            raise ToolpathError(
                f"a cut while {missing} has no known value", cure=f"name {missing} in a rapid move before the cut"
            )

    def _stance(self) -> Stance:
        frame = self.frame
        if frame.plane is not None:
            return Stance(frame.tip(), frame.axis(), (0.0, 0.0, 0.0), False)
        a, b, c = frame.angles
        return Stance(frame.tip(), frame.axis(), (a, b, c), True)

    def _arc(self, block: Block, motion: int, before: NDArray[np.float64], to: Stance) -> None:
        """A circle or helix of a G2 or G3 block."""
        modal, frame = self.modal, self.frame
        if not np.isfinite(before).all() or self.path.place is None:
            raise ToolpathError("an arc from an unknown place", cure="name X, Y and Z in a move before the arc")
        center, normal, turns = circle(
            block.words,
            before,
            np.array(frame.xyz),
            plane=modal.plane,
            clockwise=motion == 20,
            absolute_center=modal.absolute_center,
            scale=modal.scale,
        )
        center, normal = frame.point(center), frame.direction(normal)
        start, end = np.array(self.path.place.tip), np.array(to.tip)
        sweep = arc_angle(start, end, center, normal, turns) * arc_radius(start, center, normal)
        length = math.hypot(sweep, float((end - start) @ normal))
        self.path.arc(to, center, normal, turns, self._feed(block, length, to), block.line)

    def _feed(self, block: Block, length: float, to: Stance) -> float:
        """Speed (m/s) of the tip on a move of `length` (m)."""
        modal = self.modal
        if modal.feed_mode == 930:
            feed = self._inverse_time(block, length, to)
        else:
            if modal.feed is None or not modal.feed > 0.0:
                raise ToolpathError("a cut without a feed", cure="program F above zero before the first cut")
            feed = mm_min_to_m_s(m_to_mm(modal.feed * modal.feed_scale))
            if modal.feed_mode == 950:
                if not modal.speed > 0.0:
                    raise ToolpathError("feed per revolution (G95) without a spindle speed", cure="program S before it")
                feed *= modal.speed
        if feed > _FASTEST:
            self.path.note(
                "feed-implausible", "a cutting feed of more than 60 m/min: check G93, G94 and units", block.line
            )
        self._last_feed = feed
        return feed

    def _inverse_time(self, block: Block, length: float, to: Stance) -> float:
        """Speed (m/s) of a block that takes 1/F minutes (G93)."""
        rate = block.words.get("F", 0.0)
        if not rate > 0.0:
            raise ToolpathError("a cut in inverse-time feed (G93) without its own F", cure="every such block needs F")
        if math.isnan(length):
            raise ToolpathError(
                "an inverse-time cut from an unknown place has no speed", cure="name X, Y and Z in a move before it"
            )
        if length > 0.0:
            return mm_min_to_m_s(m_to_mm(length) * rate)
        place = self.path.place
        if place is not None and place.axis != to.axis:
            self.path.note(
                "turn-on-the-spot",
                "inverse-time blocks that only turn the tool get the feed of the cut before them",
                block.line,
                Severity.INFO,
            )
            if not self._last_feed > 0.0:
                raise ToolpathError(
                    "the first cut only turns the tool, so it has no path speed", cure="turn in a rapid"
                )
        return self._last_feed

    # -- canned cycles -----------------------------------------------------------------------------------------

    def _cycle(self, block: Block, code: int) -> None:
        """Drill where a block of a canned cycle says."""
        modal, frame, words = self.modal, self.frame, block.words
        self._cycle_allowed(words)
        modal.cycle.update({k: words[k] for k in "ZRQP" if k in words})
        if "P" in words:
            modal.cycle["dwell"] = modal.seconds(block, self.path)
        count = words.get("L", words.get("K", 1.0))
        if count != int(count) or not 0 <= count <= _MOST_HOLES:
            raise ToolpathError(f"{count:g} repeats of a cycle", cure="a whole number up to 10000")
        if "Z" not in modal.cycle or "R" not in modal.cycle:
            raise ToolpathError("a cycle without depth Z or retract height R", cure="name both in its first block")
        lateral = {k: words[k] for k in "XY" if k in words}
        for _ in range(int(count) if modal.incremental else min(int(count), 1)):
            height = frame.xyz[2]
            retract, bottom = modal.cycle["R"] * modal.scale, modal.cycle["Z"] * modal.scale
            if modal.incremental:
                retract += height
                bottom += retract
            if height < retract:
                self._to_height(retract, block, cut=False)
            frame.move(lateral, modal.scale, _DEGREE, modal.incremental)
            self._to_height(frame.xyz[2], block, cut=False)
            self._to_height(retract, block, cut=False)
            end = retract if modal.return_to_r else max(retract, modal.cycle_start)
            peck = modal.cycle.get("Q", 0.0) * modal.scale
            for step, value in hole(code, retract, bottom, end, peck, modal.cycle.get("dwell", 0.0)):
                if step in (Step.RAPID, Step.CUT):
                    self._to_height(value, block, cut=step == Step.CUT)
                elif step == Step.DWELL:
                    self.path.event(EventKind.DWELL, value, "", block.line)
                elif step == Step.SPINDLE_STOP and modal.spindle:
                    self.path.event(EventKind.SPINDLE_OFF, 0.0, "", block.line)
                elif modal.spindle:
                    self.path.event(EventKind.SPINDLE_ON, modal.speed, modal.spindle, block.line)

    def _cycle_allowed(self, words: dict[str, float]) -> None:
        """Refuse a cycle that isn't along the tool, in an unknown place or in inverse time."""
        modal, frame = self.modal, self.frame
        if any(letter in words for letter in "ABC"):
            raise ToolpathError("rotary words in a drilling cycle's block", cure="turn the tool in a block before it")
        if not frame.known and any(v != v and a not in words for a, v in zip("XY", frame.xyz, strict=False)):
            raise ToolpathError("a drilling cycle in an unknown place", cure="name X, Y and Z in a rapid before it")
        if frame.xyz[2] != frame.xyz[2] or modal.cycle_start != modal.cycle_start:
            raise ToolpathError("a drilling cycle from an unknown height", cure="name Z in a rapid move before it")
        tool_axis = np.array(frame.axis())
        if modal.plane != 170 or float(tool_axis @ frame.direction(np.array([0.0, 0.0, 1.0]))) < 1.0 - 1e-7:
            raise ToolpathError(
                "a drilling cycle that isn't along the tool", cure="use G17, and a tilted plane (G68.2, G53.1) for it"
            )
        if modal.feed_mode == 930:
            raise ToolpathError("a drilling cycle in inverse-time feed (G93)", cure="switch to G94 before it")

    def _to_height(self, height: float, block: Block, *, cut: bool) -> None:
        """Move along the cycle's normal."""
        self.frame.xyz[2] = height
        if not cut:
            self._rapid(block.line)
            return
        self._cuttable()
        to = self._stance()
        self.path.cut(to, self._feed(block, math.nan, to), block.line)
