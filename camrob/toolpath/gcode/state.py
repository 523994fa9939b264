"""The modal state of a G-code program, apart from where the tool is."""

from __future__ import annotations

from dataclasses import dataclass, field

from camrob.errors import ToolpathError
from camrob.findings import Severity
from camrob.toolpath.gcode.cut_path import PathGrower
from camrob.toolpath.gcode.lexer import Block
from camrob.units import INCH_MM, mm_to_m, ms_to_s

__all__ = ["SCALES", "Modal"]

SCALES = {"mm": mm_to_m(1.0), "inch": mm_to_m(INCH_MM)}
_NO_OFFSET = (530, 5000)  # G53 alone in its block (Fagor: an offset of its own), Siemens' G500
_MILLISECONDS_FROM = 100.0  # a whole P of this size is a time in milliseconds (Fanuc), a smaller one in seconds


@dataclass(slots=True)
class Modal:
    """Modal state; codes in tenths (G17 is 170). `scale` is m per programmed unit, `forced`: the user set it."""

    scale: float = SCALES["mm"]
    forced: bool = False
    stated: bool = False  # a G20 or G21 was read
    metric: bool = False  # the control is shipped so that it begins with millimetres
    motion: int | None = None
    beside: int | None = None  # of G0 to G3, the last one
    rolls: bool = False  # rotary axes may roll over at 360 degrees, by a parameter of the machine's (Fanuc and alike)
    clamps: bool = False  # M13 and M14 are clamps of rotary axes (Haas), as M10 to M12 are, and no spindle
    keeps_motion: bool = False  # G80 leaves that one in force
    plane: int = 170
    incremental: bool = False
    absolute_center: bool = False
    feed_mode: int = 940
    feed: float | None = None
    feed_scale: float = SCALES["mm"]
    speed: float | None = None  # S, rev/min
    spindle: str = ""  # CLW, CCLW or off
    stopped: bool = False  # a tool change has stopped the spindle since
    oriented: int = 0  # the line in which M19 has the spindle stand at an angle, 0 while it does not
    unloaded: int = 0  # the line in which the tool was put away, 0 while there is one
    coolant: bool = False
    next_tool: int | None = None
    tool_by_t: bool = False  # the program has no M6: T itself changes the tool
    framed: str = ""  # what the frame in force has been set by: G68, G51.1, G51
    polar: tuple[float, float] | None = None  # G16: radius and angle as written, NaN as long as no block has named them
    mirror: dict[str, float] = field(default_factory=dict)  # of G51.1: where the axes are mirrored, m
    vectors: bool = False  # G43.5: I, J, K of a straight move are the tool's axis
    measured: bool = False  # G43 has named a tool's length
    unmeasured: bool = False  # and G49 has put it out of force
    edges: bool = False  # D names an edge of the tool, with its length and radius (Siemens)
    length: float | None = None  # the number of the tool's length in force: H, or the edge
    sized: bool = False  # G43 stands in force since the tool was changed
    heightless: bool = False  # Z has not been named since another length is in force
    lengths: dict[int, float | None] = field(default_factory=dict)  # by tool, with which it has cut
    offset: tuple[int, float] | None = None  # the work offset: code and P
    suspended: bool = False  # G500 has put the work offset out of force
    moved: bool = False
    cut: bool = False  # and has cut
    unit_line: int = 0  # of the first coordinate, where nobody had named the units by then
    numbered: bool = False  # the file begins with % and a number, as NUM's and Siemens' older ones do
    named: bool = False  # a program number (O1234) was read
    return_to_r: bool = False  # G99
    side: str = ""  # the word of the cutter radius compensation in force
    edge: float | None = None  # the D word in force
    wear: bool = False  # the set-up says that compensated paths are the tool centre's
    zero_edge: bool = True  # D0 means no radius; LinuxCNC's may mean the tool in the spindle
    cycle_start: float = 0.0  # height (m) at which a cycle began
    cycle: dict[str, float] = field(default_factory=dict)  # its sticky words
    cycle_by: dict[str, bool] = field(default_factory=dict)  # whether its R and Z have been named in G91
    rereads: bool = False  # LinuxCNC takes a cycle's R and Z anew where G90 and G91 change

    def first_move(self, line: int) -> None:
        """Remember at the first coordinate that nobody has named the units."""
        if not self.moved and not (self.stated or self.forced):
            self.unit_line = line
        self.moved = True

    def take_offset(self, code: int, block: Block) -> bool:
        """The work offset that a block names, or none (G500, G53 alone); whether what is known of the place ends by that.

        Raises ToolpathError for another offset than that of the motions before it.
        """
        if code in _NO_OFFSET:
            if self.offset is None and not self.moved:
                self.offset = (code, 0.0)  # the program begins without one
            self.suspended = self.offset != (code, 0.0)
            return self.suspended
        self.suspended = False
        further = code == 540 and "P" in block.words and 40 not in block.g and not block.m  # Fanuc's G54 P2 is G54.1 P2
        key = (541, block.words["P"]) if further else (code, block.words.get("P", 0.0) if code in (541, 1540) else 0.0)
        usual = self.offset or (540, 0.0)  # where none is named, controls begin with G54
        if usual == key or not self.moved:
            self.offset = key
            return False
        if self.cut or usual[0] not in _NO_OFFSET:
            raise ToolpathError(
                "several work offsets (G54 ... G59, G500 or G53 for none): how they lie to each other only the machine knows",
                hint="give what belongs to each offset a program of its own",
            )
        self.offset = key  # nothing but ways through the air before it
        return True

    def seconds(self, block: Block, path: PathGrower) -> float:
        """A dwell's P in seconds."""
        value = block.words["P"]
        if not (block.whole_p and value >= _MILLISECONDS_FROM):
            return value
        path.note(
            "dwell-in-milliseconds",
            "a dwell P of 100 or more without a point is read as milliseconds",
            block.line,
            Severity.INFO,
        )
        return ms_to_s(value)
