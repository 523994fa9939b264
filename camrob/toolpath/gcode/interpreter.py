"""What G-code blocks mean: modal state, motion, feed, spindle and coolant, one block after the other."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError
from camrob.findings import Severity
from camrob.toolpath.defaults import Defaults
from camrob.toolpath.gcode.arc import circle, refuse_second_circle
from camrob.toolpath.gcode.coming import Coming
from camrob.toolpath.gcode.coordinates import Stance, ToolFrame
from camrob.toolpath.gcode.cornering import Open, closes, no_second_cut
from camrob.toolpath.gcode.cut_path import PathGrower
from camrob.toolpath.gcode.cycles import CYCLES
from camrob.toolpath.gcode.drill import Drill
from camrob.toolpath.gcode.lexer import Block, Plane
from camrob.toolpath.gcode.modes import aim, apply_setup, compensate
from camrob.toolpath.gcode.moves import Motions
from camrob.toolpath.gcode.program_frame import ProgramFrame
from camrob.toolpath.gcode.state import SCALES, Modal
from camrob.toolpath.gcode.strays import refuse_strays
from camrob.toolpath.gcode.tools import Process, name_height, take_length
from camrob.toolpath.gcode.transforms import cartesian
from camrob.toolpath.sampling import arc_angle, arc_radius
from camrob.units import deg_to_rad, m_to_mm, mm_min_to_m_s

__all__ = ["Interpreter"]

_PLAIN = frozenset((0, 10, 20, 30))  # G0 to G3, in tenths
_MOTION = _PLAIN | CYCLES
_AXES = frozenset("XYZABC")
_ARC_WORDS = frozenset("XYZABCIJKR")
_CORNER = frozenset("IJKR")
_CUT_TO = frozenset("XYZ")
_ROTARY = frozenset("ABC")
_VECTOR = frozenset("IJK")
_DEGREE = deg_to_rad(1.0)
_DWELLS = frozenset("PXU")  # a dwell's time; F only where it has none of them
_CLAMPS = frozenset((130, 140))
_PART = ((1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0))  # the plane that is the part's own
_OVAL = "an arc in a plane whose axes are scaled by two factors"
_LONG_WAY = math.pi * (1.0 + 1e-6)  # a half circle whose ends were rounded is none

_NO_MOTION_YET = (
    "coordinates before any of G0, G1, G2, G3, and before any feed: a control goes there in rapid, or stops; read as G0"
)


class Interpreter:
    """Runs blocks into a `PathGrower`; `process` and `motions` do what their words say."""

    def __init__(self, path: PathGrower, frame: ToolFrame, modal: Modal, defaults: Defaults) -> None:
        self.path = path
        self.frame = frame
        self.modal = modal
        self.process = Process(path, frame, modal, defaults)
        self.motions = Motions(path, frame, modal, self.process, defaults)
        self._drill = Drill(self.motions)
        self._open: Open | None = None
        self._coming = Coming(path, frame, modal)

    @property
    def ended(self) -> bool:
        """Whether M2 or M30 has been read."""
        return self.process.ended

    def finish(self) -> None:
        """The program is over. Raises ToolpathError where it has left a cut open."""
        if self._open is not None:
            raise no_second_cut(self._open.line)
        self._coming.ends()

    def state(self, name: str) -> float | None:
        """What the program has set so far: "motion", "plane", "distance", "feed mode", "units", "return" as G numbers, "F", "S",
        "X", "Y", "Z" as it would write them, but with turned axes; "at X", "at Y", "at Z" in whatever frame is in force, "at A",
        "at B", "at C" in degrees; "tool NAME": the number of the set-up's tool of that name. None where it doesn't say, or for
        another name.
        """
        modal, frame = self.modal, self.frame
        codes = {
            "motion": modal.motion,
            "plane": modal.plane,
            "distance": 910 if modal.incremental else 900,
            "feed mode": modal.feed_mode,
            "units": (200 if modal.scale == SCALES["inch"] else 210) if modal.stated else None,
            "return": 990 if modal.return_to_r else 980,
        }
        if name in codes:
            code = codes[name]
            return None if code is None else code / 10.0
        if name.startswith("tool "):
            return self.process.defaults.number(name[5:])
        if name.startswith("at ") and name[-1:] in _ROTARY:
            return self.frame.turn(name[-1:])
        if name[-1:] in _CUT_TO:
            place = frame.xyz["XYZ".index(name[-1])]
            known = frame.placeable if name.startswith("at ") else not frame.turned
            return place / modal.scale if math.isfinite(place) and known else None
        return {"F": modal.feed, "S": modal.speed}.get(name)

    def run(self, block: Block) -> None:
        """Carry one block out. Raises ToolpathError (without its place) for what can't be read honestly."""
        line, words, modal = block.line, block.words, self.modal
        if self._open is not None and not closes(block):
            raise no_second_cut(self._open.line)
        if block.corner is not None and _CUT_TO.isdisjoint(words):
            raise no_second_cut(line)
        if modal.clamps and not _CLAMPS.isdisjoint(block.m):
            text = (
                "M13 and M14 are taken for clamps of rotary axes, as M10 to M12 of this file are, not for the spindle"
            )
            self.path.note("axis-clamp", text, line, Severity.INFO)
            block = block._replace(m=tuple(code for code in block.m if code not in _CLAMPS))
        if block.comment:
            self.path.comment(block.comment, line)
        if block.again:
            self.path.note(
                "again-and-again", "M99 ends the main program, which would begin again: it is read once", line
            )
        if block.note:
            self.path.note("control-word", block.note, line)
        if block.plane is not False:
            self._plane(block.plane, aligned=block.aligned)
        if block.frame is not None:
            matrix, place = block.frame
            self.frame.set_program(ProgramFrame(matrix, place * modal.scale), together=block.together)
        if block.optional:
            self.path.note("block-delete", "blocks behind a slash are carried out, as where block skip is off", line)
        motion = modal.motion
        consumed = False
        if block.g:
            motion, consumed = self._codes(block, motion)
        refuse_strays(block, motion, vectors=modal.vectors, numbered=modal.numbered)
        if modal.polar is not None and not consumed:
            block = cartesian(block, modal, self.frame)
            words = block.words
        if block.vector is not None:
            self._aim(block)
        self._values(block)
        if block.m or "S" in words:
            self.process.before(block)
        if block.ready is not None:
            self.modal.next_tool = int(block.ready)
        if 40 in block.g:
            self.process.dwell(block)
            consumed = True
        if block.vector is not None and not consumed:
            self._motion(block, motion)
        elif (
            words
            and not consumed
            and not (_ARC_WORDS if motion in (20, 30) or modal.vectors else _AXES).isdisjoint(words)
        ):
            self._motion(block, motion)
        elif motion in CYCLES and "R" in words and not consumed:
            self._drill.run(block, motion)
        if block.m:
            self.process.after(block)

    def _plane(self, plane: Plane, *, aligned: bool) -> None:
        """A tilted plane of a control's own cycle, or none any more; `aligned`: its tool stands on it, wherever its tip went."""
        frame = self.frame
        frame.untilt()
        part = plane == _PART  # a swivelling head or table that goes to zero
        if plane is not None and not part:
            rotation, origin = plane
            frame.tilt(np.array(rotation).reshape(3, 3), np.array(origin) * self.modal.scale)
        if aligned:
            self.path.lose()
            if plane is None or part:
                frame.forget()
                frame.angles = [0.0 if part or angle == 0.0 else math.nan for angle in frame.angles]
                frame.vector = None
            else:
                frame.orient()

    def _aim(self, block: Block) -> None:
        """The tool's axis by a vector of the block, with or without a move."""
        if 1280 in block.m:  # TRAORI in the same block
            self.frame.switch_tcp(True, by_m=True)
        x, y, z = block.vector or (0.0, 0.0, 0.0)
        if not _AXES.isdisjoint(block.words) and not {"A", "B", "C"}.isdisjoint(block.words):
            raise ToolpathError("a tool axis by a vector and by angles in one block", hint="keep one of them")
        self.frame.aim((x, y, z))

    def _codes(self, block: Block, motion: int | None) -> tuple[int | None, bool]:
        """Carry the G codes of a block out, except for motion: the motion code now, whether axis words are used up."""
        setup = []
        named: int | None = None
        for code in block.g:
            if code in _MOTION or code == 800:
                if named is not None and named != code and 800 not in (named, code):
                    raise ToolpathError(
                        f"G{named / 10:g} and G{code / 10:g} in one block", hint="keep one motion code a block"
                    )
                named = code if named in (None, 800) else named
            elif code != 40:
                setup.append(code)
        if named is not None:
            if named in CYCLES and (motion not in CYCLES):
                self.modal.cycle_start = self.frame.xyz[2]
            if named not in CYCLES:
                self.modal.cycle.clear()
            self._drill.begun(block, named)
            if named in _PLAIN:
                self.modal.beside = named
            motion = self.modal.motion = self._uncycled() if named == 800 else named
        consumed = apply_setup(setup, block, self.modal, self.frame, self.path) if setup else False
        if 533 in setup:
            motion = 0
        return motion, consumed

    def _uncycled(self) -> int | None:
        """The motion behind G80: Fanuc has its cycles beside G0 and G1, which go on; other controls forget it."""
        return self.modal.beside if self.modal.keeps_motion and self.modal.beside in (0, 10) else None

    def _values(self, block: Block) -> None:
        """F, T, S and letters that have no meaning here."""
        words, modal = block.words, self.modal
        if "F" in words and (40 not in block.g or not _DWELLS.isdisjoint(words)):
            modal.feed = words["F"]
            modal.feed_scale = modal.scale
        compensate(block, modal, self.path)
        take_length(block, modal)
        if "T" in words:
            self.process.tool_word(words["T"], block.line)
        for letter in ("U", "V", "W"):
            if letter in words and 40 not in block.g:
                raise ToolpathError(
                    f"a {letter} word: secondary axes and lathe increments are not read", hint="export X, Y, Z, A, B, C"
                )
        if "O" in words:
            if len(words) > 1 or block.g or block.m or modal.named or modal.moved:
                raise ToolpathError(
                    "O-words (subprograms, or several programs in one file) are not read",
                    hint="have the CAM system write one program with plain blocks",
                )
            modal.named = True

    # -- motion ------------------------------------------------------------------------------------------------

    def _motion(self, block: Block, motion: int | None) -> None:
        """Move as the modal motion code says."""
        if motion is None and self.modal.beside is None and self.modal.feed is None:
            self.path.note("rapid-by-default", _NO_MOTION_YET, block.line, Severity.INFO)
            motion = self.modal.motion = self.modal.beside = 0
        if motion is None:
            raise ToolpathError(
                "coordinates before any of G0, G1, G2, G3 (or after G80)", hint="name the kind of motion in the block"
            )
        if block.corner is not None and motion != 10:
            raise no_second_cut(block.line)
        modal, frame, words = self.modal, self.frame, block.words
        if modal.vectors and not _VECTOR.isdisjoint(words):
            if motion not in (0, 10):
                raise ToolpathError("I, J, K of an arc while they are the tool's axis (G43.5)", hint="export lines")
            aim(block, modal, frame)
        elif motion == 10 and not _CORNER.isdisjoint(words):
            raise ToolpathError(
                "a straight cut with R, I, J or K (a rounded or chamfered corner)", hint="write the corner out as moves"
            )
        modal.first_move(block.line)
        name_height(block, motion, modal, self.path.tool, known=frame.known)
        self.process.settle()
        if motion in CYCLES:
            self._coming.ends()
            self._drill.run(block, motion)
            return
        if block.ways:
            self._rewind(block, cut=motion != 0)
        before, turned_before = frame.xyz.copy(), frame.angles.copy()
        frame.tool = self.path.tool
        frame.move(words, modal.scale, _DEGREE, modal.incremental)
        self._coming.moved(rapid=motion == 0)
        if motion == 0:
            if frame.machine is not None and not frame.tcp and frame.angles != turned_before:
                self.path.lose()  # the tip goes by a way of the machine's own, of which the end alone counts
            return self.motions.rapid(block.line)
        if self._coming.takes(block, motion):
            return
        self.motions.cuttable()
        if frame.machine is not None and frame.vector is None and frame.angles != turned_before:
            return self._cut_turning(block, motion, [*before, *turned_before])
        if "C" in words and abs(frame.angles[2] - turned_before[2]) > _LONG_WAY and self.path.place is not None:
            self._long_way(block.line)
        to = frame.stance()
        if block.corner is not None or self._open is not None:
            self._open = self._cornered(block, motion, np.array(before), to)
            return
        if motion == 10:
            place = self.path.place
            length = math.nan if place is None else math.dist(place.tip, to.tip)
            self.path.cut(to, self.motions.feed(block, length, to), block.line)
        else:
            self._arc(block, motion, np.array(before), to)

    def _cut_turning(self, block: Block, motion: int, begin: list[float]) -> None:
        """A cut that turns the axes of a known machine; `begin` as of `Motions.turning`."""
        straight = motion == 10 and block.corner is None and self._open is None
        if not (straight and self.motions.turning(block, begin)):
            raise ToolpathError(
                "an arc, a corner or a cut from an unknown place that turns the machine's rotary axes",
                hint="turn them in straight moves, from a known place",
            )

    def _long_way(self, line: int) -> None:
        """A cut in which C turns by more than half a turn. Raises ToolpathError where the control may go the other way round."""
        text = "C turns by more than 180 degrees within one cut"
        if self.modal.rolls:
            raise ToolpathError(
                f"{text}: an axis that rolls over at 360 goes the shorter way, one that doesn't the longer",
                hint="post angles that go on beyond 360, or that cut in shorter moves",
            )
        self.path.note("rotary-long-way", f"{text}; read as the numbers say, without rollover", line)

    def _rewind(self, block: Block, *, cut: bool) -> None:
        """Name rotary axes by whole turns otherwise, so that each goes to its word as the word says: the shortest way, or on.

        Raises ToolpathError for a cut that may go either way round.
        """
        for letter, how in block.ways:
            shift = self.frame.rewound(letter, block.words[letter], how)
            if shift is None and cut:
                raise ToolpathError(
                    f"{letter} by {how} (M126 is DC, the shorter way) in a cut half a turn wide, or from an angle not known",
                    hint=f"write {letter} as a plain value",
                )
            place = self.path.place
            if shift and place is not None:
                i = "ABC".index(letter)
                a, b, c = (v + shift * (k == i) for k, v in enumerate(place.angles))
                place.angles = (a, b, c)

    def _cornered(self, block: Block, motion: int, before: NDArray[np.float64], to: Stance) -> Open | None:
        """A straight cut with a corner before it or at its end; what it leaves open waits for the next one."""
        modal, frame = self.modal, self.frame
        if modal.plane != 170 and not frame.program.even:
            raise ToolpathError(_OVAL, hint="scale all axes alike, or export lines")
        if motion != 10 or modal.feed_mode == 930 or not np.isfinite(before).all() or self.path.place is None:
            raise no_second_cut(block.line)
        feed, at = self.motions.feed(block, math.nan, to), np.array(frame.xyz)
        if self._open is not None:
            before = self._open.cut(self.path, frame, at, to)
        if block.corner is None:
            self.path.cut(to, feed, block.line)
            return None
        own = block.corner.feed
        slow = feed if own is None else mm_min_to_m_s(m_to_mm(own * modal.scale))
        return Open(block.corner, block.corner.size * modal.scale, before, at, feed, slow, modal.plane, block.line)

    def _arc(self, block: Block, motion: int, before: NDArray[np.float64], to: Stance) -> None:
        """A circle or helix of a G2 or G3 block."""
        modal, frame = self.modal, self.frame
        if not np.isfinite(before).all() or self.path.place is None:
            raise ToolpathError("an arc from an unknown place", hint="name X, Y and Z in a move before the arc")
        center, normal, turns = circle(
            block.words,
            before,
            np.array(frame.xyz),
            plane=modal.plane,
            clockwise=motion == 20,
            absolute_center=modal.absolute_center,
            scale=modal.scale,
        )
        if modal.numbered and "R" not in block.words and not modal.absolute_center:
            refuse_second_circle(block.words, before, np.array(frame.xyz), center, modal.plane, modal.scale)
        if modal.plane != 170 and not frame.program.even:
            raise ToolpathError(_OVAL, hint="scale all axes alike, or export lines")
        center, normal = frame.point(center), frame.normal(normal)
        start, end = np.array(self.path.place.tip), np.array(to.tip)
        sweep = arc_angle(start, end, center, normal, turns) * arc_radius(start, center, normal)
        length = math.hypot(sweep, float((end - start) @ normal))
        self.path.arc(to, center, normal, turns, self.motions.feed(block, length, to), block.line)
