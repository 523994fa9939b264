"""G-code: ISO 6983 as Fanuc and LinuxCNC (RS274/NGC) have it, with tool centre point on where it turns axes.

Programs that compute are read in the order in which they are run (`running`).
"""

from __future__ import annotations

import math
import re

import numpy as np
from numpy.typing import NDArray

from camrob.witness.cl.circles import Wanted, centre_by_offsets, centre_by_radius, normal_of, twofold
from camrob.witness.cl.customs import COMPUTED, SKIPPED, astray, corner_of, plain_words, shown
from camrob.witness.cl.drilling import CYCLES, Cycle, Out, drill
from camrob.witness.cl.offsets import TCP, Offsets
from camrob.witness.cl.own_frames import OwnFrames, Polar
from camrob.witness.cl.running.beginning import Beginning
from camrob.witness.cl.running.machined import Machined
from camrob.witness.cl.running.program_run import run_of
from camrob.witness.cl.running.unread import UnreadError
from camrob.witness.cl.source import COMMENT, tape
from camrob.witness.cl.standing import Standing, Words
from camrob.witness.cl.teller import UNREAD, Teller
from camrob.witness.cl.turning import on_the_way
from camrob.witness.happenings import Kind, Pecks, Way
from camrob.witness.machine_tool import MachineTool
from camrob.witness.units import INCH_MM, mm_to_m

__all__ = ["GcodeReader"]

Array = NDArray[np.float64]
_WORD = re.compile(r"([A-Z])([-+]?(?:\d+\.?\d*|\.\d+))")
_Z = np.array([0.0, 0.0, 1.0])
_FRAMES = frozenset(["53 alone", *"54 54.1 55 56 57 58 59 59.1 59.2 59.3".split()])
_HIDING = {
    "68": "69", "68.2": "69", "51": "50", "51.1": "50.1", "16": "15", "7": "8", "52": "", "92": "92.1",
}  # fmt: skip  # until
_CYCLES, _PLANES, _LINES = (*CYCLES, "76", "87", "88"), ("17", "18", "19"), frozenset("0123")
_MODES = frozenset("17 18 19 20 21 90 91 90.1 91.1 93 94 95 98 99 43 44 49 8".split()).union(TCP)
_ALIGNING = frozenset({"53.1", "53.3", "53.6"})
_KNOWN = frozenset().union(_MODES, SKIPPED, _FRAMES, _HIDING, _ALIGNING, _CYCLES, "0 1 2 3 4 10 28 30 53".split())
_LAST_ENDS, _LAST_FEED = range(5001, 5004), 4109  # system variables of Fanuc's
_SAME, _MOVED = 1e-12, "points behind it are in another frame"  # _SAME: of two factors
_UNTURNED = "a tilted plane other than by three angles, or beside G52 or TCP"


class GcodeReader(Machined):
    """Tells what a file asks for. by_tool: rotary words turn the tool (ISO 841), not the table. machine: whose axes they are."""

    def __init__(
        self,
        tell: Teller,
        units: str | None,
        offsets: Offsets,
        by_tool: bool = False,
        machine: MachineTool | None = None,
    ) -> None:
        super().__init__(tell, Standing(-1.0 if by_tool else 1.0, machine))
        self._rolls = by_tool and type(self) is GcodeReader  # rotary axes may roll over at 360 degrees
        self._offsets, self._fixed, self.units = offsets, units is not None, units or "mm"
        self._motion, self._plane, self._feed_mode = "", "17", "94"
        self._bent: Wanted | None = None  # the corner at the end of the block
        self._absolute, self._centre_absolute, self._to_initial = True, False, True
        self._frame, self._beside = "54", ""  # _beside: of G0 to G3, the last one
        self._vectors = False  # I, J, K name the tool's axis (G43.5)
        self._last_feed: float | None = None
        self._own, self._polar, self._begins = OwnFrames(self._stand), Polar(), Beginning(tell, self._stand)
        self._heights: dict[str, float] = {}  # of the cycle in force: R, Z, initial (m), P (s)

    def read(self, text: str) -> None:
        """Reads up to M2, M30 or the second %."""
        bare = COMMENT.sub("", text).upper()
        self._whose(bare)
        self._clamps = bool(re.search(r"M\s*0*1[0-2](?![\d.])", bare) and re.search(r"M\s*0*[34](?![\d.])", bare))
        rows = tape(text, self.beside)
        line, run = rows[0][0] if rows else 1, None
        try:
            run = run_of(rows, self._asked, own=self.ngc)
            for line, block in run or rows:
                if run is not None or not self._another(block, line):
                    self._read(block, line)
                if self._ended:
                    return
        except UnreadError as error:
            line = run.line if run is not None else line
            self._gap(line, f"{UNREAD}{COMPUTED} ({error})", last=text.rstrip().count("\n") + 1)

    def _asked(self, number: int) -> float | None:
        """What the control holds in #5001 to #5003, where the last block ended, and in #4109, the last F. None: not known."""
        stand = self._stand
        if number == _LAST_FEED:
            return self._last_feed
        framed = bool(self._tell.hidden or stand.odd) or stand.tilted or stand.preset or stand.own is not None
        if number not in _LAST_ENDS or framed or any(stand.shift.values()) or self._motion in _CYCLES:
            return None
        at = stand.at["XYZ"[number - _LAST_ENDS[0]]]
        return None if at is None else at / self._scale

    def _another(self, block: str, line: int) -> bool:
        """True where a program's name or number stands; behind motions it is another program's."""
        if not re.fullmatch(r"[O:]\d+|O?<[\w.-]*>", block):
            return False
        if self._tell.n:
            self._gap(line, "another program in the same file")
        return True

    def _read(self, block: str, line: int) -> None:
        if block.startswith("/"):
            self._tell.note("blocks that may be skipped (/) are taken as executed")
            block = re.sub(r"^/\d?", "", block)
        block = block.replace("TRAORI", "M128").replace("TRAFOOF", "M129")  # Siemens
        if shown(block):  # a message to the operator
            return
        block, corner = corner_of(block, self._scale)
        said = _WORD.findall(block)
        if odd := _WORD.sub("", block)[:20] or astray(said, self._motion, self._vectors, self._numbered):
            self._gap(line, f"{odd}: not known")
            return
        pairs, ready = plain_words([(letter, value) for letter, value in said if letter != "N"])
        g, m = ([f"{float(v):g}" for letter, v in pairs if letter == kind] for kind in "GM")
        words = {letter: v for letter, v in pairs if letter not in "GM"}
        strange = [f"G{code}" for code in g if code not in _KNOWN]
        if strange or len(words) + len(g) + len(m) != len(pairs) or {"U", "V", "W"} & set(words):
            self._gap(line, f"{', '.join(strange) or 'a word said twice, or U, V, W'}: not known")
            g, words = [], {k: v for k, v in words.items() if k in "FST"}
        moves = bool(set(words) & set("XYZABCIJK")) and not {"4", "10"} & set(g)
        self._process(g, m, words, line, moves)
        self._next_tool = self._next_tool if ready is None else ready
        self._offsets.block(g, m, words, line)
        self._modes(g, words, line)
        words = self._unrolled(g, words, line)
        self._go(g, words, line)
        if want := corner or self._bent:
            if self._stand.stretch != (1.0, 1.0):
                self._gap(line, "a corner in a scaled frame")
            self._tell.corner(want, self._stand.about(normal_of(self._plane, False)), line)
            self._bent = None
        self._process_after(m, line, moves)

    def _cuts(self, words: Words) -> bool:
        return bool({*"XYZABCIJKR"} & set(words)) and self._motion in (*_CYCLES, "1", "2", "3")

    def _unrolled(self, g: list[str], words: Words, line: int) -> Words:
        """X and Y for the radius and angle of a block under G16."""
        x, y, _ = self._stand.named(self._stand.at) / self._scale
        if (plain := self._polar.plain(g, words, (float(x), float(y)), self._absolute)) is None:
            self._gap(line, "polar coordinates (G16) whose radius, angle or pole is not known")
        return words if plain is None else plain

    def _modes(self, g: list[str], words: Words, line: int) -> None:
        for code in g:
            if code in _PLANES:
                self._plane = code
            elif code in ("20", "21") and not self._fixed:
                self.units = "inch" if code == "20" else "mm"
            elif code in ("90", "91"):
                self._absolute = code == "90"
            elif code in ("90.1", "91.1"):
                self._centre_absolute = code == "90.1"
            elif code in ("93", "94", "95") and code != self._feed_mode:
                self._feed_mode = code
                self._tell.set_feed(0.0, "min")
            elif code in ("98", "99"):
                self._to_initial = code == "98"
            elif code in (*TCP, "49"):
                self._stand.switch("G", code != "49")
                self._vectors = code == "43.5"
        for code in ["53 alone"] if g == ["53"] and not words else g:  # an offset of its own on some
            self._frames(code, words, line)
        if "F" in words and "4" not in g:
            self._last_feed = float(words["F"])
        if "F" in words and "4" not in g and self._feed_mode != "93":
            value = float(words["F"]) * self._scale
            self._tell.set_feed(*((value / 60.0, "min") if self._feed_mode == "94" else (value, "rev")))

    @property
    def _scale(self) -> float:
        return mm_to_m(INCH_MM if self.units == "inch" else 1.0)

    def _frames(self, code: str, words: Words, line: int) -> None:
        """What hides the motions behind it, because it moves the frame that they are in, and what ends that."""
        hidden = self._tell.hidden
        ended = [k for k in hidden if _HIDING.get(k) == code or (k == "92" and code == "92.2")]
        if code in _FRAMES or (code == "15" and "H" in words):  # Okuma's G15 H is a datum
            name = code + words.get({"54.1": "P", "54": "P", "15": "H"}.get(code, ""), "")
            if name == self._frame:
                ended += ["frame"] if "frame" in hidden else []
            elif not self._tell.n:
                self._frame = name
                self._forget()
            elif "frame" not in hidden:
                hidden["frame"] = (line, f"G{name}: another work frame than G{self._frame}")
                self._forget()
        stand = self._stand
        odd = not self._absolute or self._plane != "17" or bool(hidden) or bool(stand.odd)
        if self._polar.take(code, odd=self._plane != "17" or bool(hidden) or stand.tilted or stand.own is not None):
            return
        if self._own.take(code, words, self._scale, odd=odd):
            self._heights = {}
            if code in ("68", "51", "51.1"):
                return
        if code == "69" and stand.tilted:
            stand.untilt()
            self._heights = {}
        rotary = any(float(words.get(axis, "0")) for axis in "ABC")
        if code == "52" and not (hidden or stand.preset or stand.own is not None or rotary):
            shift = stand.shift | {axis: float(words[axis]) * self._scale for axis in "XYZ" if axis in words}
            if stand.tilted and shift != stand.shift:
                hidden["52"] = (line, "G52 in a tilted plane: whether it is that frame's isn't known")
                self._forget()
            stand.shift = shift
        elif code in ("68.2", "92") and stand.set_frame(code, words, self._scale, begun=bool(self._tell.n)):
            self._heights = {}
        elif code in ("92.1", "92.2") and any(stand.shift.values()):  # LinuxCNC drops G52 with them, Fanuc doesn't
            hidden["52"] = (line, f"G{code}: whether G52 holds behind it isn't known")
            self._forget()
        elif code in _HIDING or (code == "10" and self._tell.n):
            hidden.setdefault(code, (line, f"G{code}: {_UNTURNED if code == '68.2' else _MOVED}"))
            self._forget()
        for key in ended:
            del hidden[key]
            self._forget()

    # -- motions

    def _go(self, g: list[str], words: Words, line: int) -> None:
        motions = [code for code in g if code in (*_LINES, *_CYCLES)] or [code for code in g if code == "80"]
        motion = motions[-1] if motions else None
        if len(_LINES & set(motions)) > 1:
            self._gap(line, "two ways of moving in one block")
        if motion and not (motion in _CYCLES and self._motion in _CYCLES):
            self._heights = {}
        if motion in _LINES:
            self._beside = motion
        elif motion == "80" and self._beside in ("0", "1"):  # cycles are of a modal group of their own
            motion = self._beside
        self._motion = motion or self._motion
        axes = set(words) & set("XYZABC")
        if "4" in g:
            said = words.get("P") or words.get("X") or words.get("F")
            if said is None:
                self._tell.gap(line, "G4 of a time that is not known", lost=False)
            if time := self._seconds(said, line) if said else math.nan:
                self._tell.event(Kind.DWELL, line, time)
        elif {"10", "92", "52", "68", "68.2", "51", "51.1", "50.1"} & set(g):
            return
        elif _ALIGNING & set(g):
            self._align(axes, words, line, moves="53.3" in g)
        elif "28" in g or "30" in g:
            self._home(axes, words, line, second="30" in g)
        elif "53" in g:
            if axes and self._motion not in ("0", "", "80"):
                self._tell.gap(line, "a cut to a machine position")
            if axes:
                self._stand.leave(axes, words)
                self._tell.lose()
        elif self._vectors and {*"IJKQ"} & set(words):
            self._aimed(axes, words, line)
        elif why := self._offsets.way(words, self._motion, self._absolute, self._stand.at["Z"], cuts=self._cuts(words)):
            self._gap(line, why)
        elif self._motion in _CYCLES:
            self._cycle(axes, words, line)
        elif axes or (self._motion in ("2", "3") and {"I", "J", "K", "R"} & set(words)):
            self._line_or_arc(axes, words, line)

    def _aimed(self, axes: set[str], words: Words, line: int) -> None:
        """G43.5: the tool's axis by a vector from its tip, where the block ends (Fanuc B-63944: type 2)."""
        vector, odd = np.array([float(words.get(letter, "0")) for letter in "IJK"]), {*"ABCQ"} & set(words)
        if odd or self._motion not in ("0", "1") or not self._absolute or not self._stand.aim(vector):
            self._gap(line, "G43.5 with Q, rotary words, an arc, or without a vector")
        else:
            self._line_or_arc(axes, words, line)

    def _target(self, axes: set[str], words: Words) -> dict[str, float | None]:
        return self._stand.target(axes, words, self._scale, self._absolute)

    def _align(self, axes: set[str], words: Words, line: int, moves: bool) -> None:
        """The tool onto the tilted plane; moves: and in rapid to X, Y, Z of it."""
        self._heights = {}
        if axes - set("XYZ" if moves else "") or not self._stand.align():
            self._gap(line, "the tool turned onto a tilted plane that is not known, or with axes of its own")
            return
        self._tell.lose()
        self._stand.go(self._target(axes, words))
        if pose := self._stand.pose():
            self._move(*pose, Way.RAPID, line)

    def _home(self, axes: set[str], words: Words, line: int, second: bool) -> None:
        """G28, G30: in rapid through the point that is named, then to the machine's own position."""
        self._stand.go(self._target(axes, words))
        if axes and (pose := self._stand.pose()):
            self._move(*pose, Way.RAPID, line)
        self._stand.leave(axes, dict.fromkeys(axes, "1") if second else None)  # only the first one is the zeros
        self._tell.lose()

    def _line_or_arc(self, axes: set[str], words: Words, line: int) -> None:
        if self._motion in ("", "80") and not self._beside and self._last_feed is None:
            self._motion = self._beside = "0"  # no feed stands yet: nothing can be cut
        if self._motion not in _LINES:
            self._gap(line, "axes without a motion")
            return
        stand, before = self._stand, self._stand.at
        stand.go(self._target(axes, words))
        self._begins.moved(line, rapid=self._motion == "0", straight=self._motion == "1")
        pose, way = stand.pose(), Way.RAPID if self._motion == "0" else Way.FEED
        if pose is None:
            if way == Way.FEED:
                self._begins.cut(line, axes, straight=(self._motion, self._feed_mode, self._plane) == ("1", "94", "17"))
            self._tell.lose()
            return
        time = 0.0
        if self._feed_mode == "93" and way == Way.FEED:
            rate = float(words.get("F", "0"))
            time = 60.0 / rate if rate > 0.0 else math.nan
            if not rate > 0.0:
                self._tell.gap(line, "G93 without F in the block", lost=False)
        if self._motion in ("2", "3"):
            return self._arc(before, pose, words, line, time)
        if self._turning(before, way, line, time / 60.0, self._scale):
            return
        feed = None
        if time:
            length = float(np.linalg.norm(pose[0] - np.array([before[letter] for letter in "XYZ"], float)))  # None: NaN
            if math.isnan(length):
                self._tell.gap(line, "G93 from where the tool isn't known to be", lost=False)
            feed = length / time if length else math.nan  # a turn on the spot has no speed of the tip
        ends = [np.array([at[letter] for letter in "XYZABC"], float) for at in (before, stand.at)]
        exact = not stand.odd and way == Way.FEED  # in rapid each axis goes as fast as it can
        if exact and self._rolls and abs(float(ends[1][5] - ends[0][5])) > 180.0:
            self._tell.gap(line, "C by more than half a turn, which an axis that rolls over goes the other way round")
        for place in [*(on_the_way(ends[0], ends[1], "B" in stand.used) if exact else []), pose]:
            self._move(*place, way, line, feed)

    def _arc(
        self, before: dict[str, float | None], pose: tuple[Array, Array], words: Words, line: int, time: float
    ) -> None:
        stand, (tip, axis), scale = self._stand, pose, self._scale
        start, end = stand.named(before), stand.named(stand.at)
        normal = normal_of(self._plane, self._motion == "2")
        if "R" in words:
            found = centre_by_radius(start, end, normal, float(words["R"]) * scale)
            if found is None:
                return self._tell.gap(line, "an arc with R that doesn't reach its end, or has no length")
            center = found
        else:
            offset = np.array([float(words.get(letter, "0")) * scale for letter in "IJK"])
            if self._numbered and twofold(start, end, offset, normal):
                return self._gap(line, "an arc both from its start and from the zero by I, J, K: of two controls")
            center = centre_by_offsets(start, offset, normal, np.zeros(3) if self._centre_absolute else None)
        across, up = stand.stretch
        oval = self._plane != "17" and abs(across - up) > _SAME
        if stand.odd or math.isnan(start.sum()) or oval:
            self._tell.gap(
                line, stand.odd or ("an arc in an uneven frame" if oval else "an arc whose start is not known")
            )
            return
        tip, center, normal = stand.point(tip), stand.point(stand.outward(center)), stand.about(normal)
        self._tell.arc(tip, axis, center, normal, Way.FEED, line, int(float(words.get("P", "1"))) - 1, time)

    def _cycle(self, axes: set[str], words: Words, line: int) -> None:
        """G73 to G89: R, Z, P, Q are kept; every block with axes is a hole (or L, K holes)."""
        heights, code, stand = self._heights, self._motion, self._stand
        initial = stand.at["Z"]
        if "initial" not in heights and initial is not None:
            heights["initial"] = initial
        zero = stand.floor
        base = zero if self._absolute else heights.get("initial", math.nan)
        if "R" in words:
            heights["R"] = float(words["R"]) * self._scale + base
        if "Z" in words:
            heights["Z"] = float(words["Z"]) * self._scale + (zero if self._absolute else heights.get("R", math.nan))
        heights |= {f"{letter}90": float(self._absolute) for letter in ("R", "Z") if letter in words}
        if "P" in words:
            heights["P"] = self._seconds(words["P"], line)
        if "Q" in words:
            heights["Q"] = abs(float(words["Q"])) * self._scale
        if not axes and (code != "73" or "Q" not in words or {"R", "Z"} & heights.keys()):
            return  # but Fagor's G73 Q turns the path
        if self._own.by == "51":
            self._gap(line, "a drilling cycle in a scaled frame")
            return
        bottom, low, first = heights.get("Z", math.nan), heights.get("R", math.nan), heights.get("initial", math.nan)
        level = max(first, low) if self._to_initial else low
        mixed = heights.get("R90") != heights.get("Z90")  # one is of G90, one of G91: which stays is the control's
        for _ in range(int(float(words.get("L", words.get("K", "1"))))):
            stand.go(self._target(axes - {"Z"}, words) | {"Z": low})
            pose = stand.pose()
            upright = pose is not None and bool(np.allclose(pose[1], stand.direction(_Z))) and self._plane == "17"
            if pose is None or not upright or code not in CYCLES or not bottom <= low <= level or stand.odd or mixed:
                return self._gap(line, f"G{code} whose place, heights or way are not known")
            if CYCLES[code] is Out.REVERSED and self._tell.sense != ("CLW" if code == "84" else "CCLW"):
                self._tell.gap(line, f"G{code} with the spindle turning the other way", lost=False)
            dwell = 0.0 if code in ("81", "85") else heights.get("P", 0.0)
            bite = heights.get("Q", 0.0) if code in ("73", "83") else 0.0
            pecks = Pecks(bite, bite, code == "83") if bite else None
            cycle = Cycle(CYCLES[code], low - bottom, 0.0, level - low, dwell=dwell, pecks=pecks)
            drill(self._tell, cycle, stand.point(pose[0]), pose[1], line)
            stand.at["Z"] = level
