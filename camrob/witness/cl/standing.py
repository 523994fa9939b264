"""Where the axes of a G-code program stand, and what that is in the part: G52's shift, G68.2's plane, turned axes.

G68.2 X Y Z I J K sets a frame in the work frame: its origin, and three turns in degrees, each about an axis of the frame as it
has been turned so far: about Z, X', Z'', or, where Q names them, as its digits say (1: X, 2: Y, 3: Z). The points behind it are
in that frame, till G69. G53.1 turns the tool along its z axis, and so do rotary words that say the same; where the tip goes
meanwhile depends on the machine. (Fanuc B-63942, 5.44, for G68.2 and G53.1; LinuxCNC's tilted work plane for Q, G53.3, G53.6.)
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from camrob.witness.cl.framing import in_plane, spin, stretch
from camrob.witness.cl.turning import tool_axis
from camrob.witness.frames import rotations_about
from camrob.witness.machine_tool import MachineTool
from camrob.witness.units import deg_to_rad

__all__ = ["TURNED", "UNNAMED", "Standing", "Words"]

Array = NDArray[np.float64]
Words = dict[str, str]  # of a block, but G and M, as printed

TURNED = "a cut with turned axes without tool centre point"
UNNAMED = "a cut without X, Y or Z named since the start or a machine position"
_UNKNOWN = "a cut whose place in the part is not known"
_BOTH = "turned axes A and B: a kinematics that is not known"
_ELSE = "a turned axis that the machine's file doesn't have"
_NO_LENGTH = "a tool that the head turns, and whose length the machine's file doesn't give"
_WITHIN = "the tool centre point in a turned, mirrored or scaled frame"
_TWICE = "a tilted plane and the tool centre point at once"
_ORDERS = frozenset("121 131 212 232 313 323".split())
_OF_PLANE = frozenset("XYZIJKPQFST")
_LINEAR = frozenset("XYZ")
_ALONG = deg_to_rad(0.01)  # a tool nearer to the plane's z axis than this stands along it
_SHORT = 1e-3  # of a vector that names an axis: three decimals are printed at least
_AS_FAR = 1e-6  # degrees: nearer to half a turn than this, neither way is the shorter one
_ZERO = 1e-9  # degrees: nearer to whole turns than this is at zero


class Standing:
    """at: X, Y, Z in m, in the frame of the program's points, and A, B, C in degrees; None where not known.

    shift: m, of G52 or G92: `at` is where the tool is without it. preset: some of it is G92's. used: the rotary letters that the
    program has named. own: (4, 4), the frame that the program has set for its points within `shift`, None: none. loose: its axes
    that no block has named together since: what one of them alone means, controls differ on. unnamed: what is not known has not
    been named, since the start or a machine position. risen: the tool went up out of a cut, nobody knows how far.
    """

    def __init__(self, sense: float = 1.0, machine: MachineTool | None = None) -> None:
        self.machine, self.length = machine, 0.0  # length: m, the tool's, as the machine's head turns it
        self._sense = sense  # of rotary words: -1 where they turn the tool (ISO 841), 1 where they turn the table
        self.at: dict[str, float | None] = {**dict.fromkeys("XYZ"), **dict.fromkeys("ABC", 0.0)}
        self.shift = dict.fromkeys("XYZ", 0.0)
        self.preset = False
        self.own: Array | None = None
        self.loose: set[str] = set()
        self.used: set[str] = set()
        self.unnamed = True
        self.risen = False
        self._tcp: set[str] = set()  # what holds the tool centre point: "G" (G43.4), "M" (M128, M428)
        self._plane: tuple[Array, Array] | None = None  # part_R_plane, part_p_plane (m)
        self._along = False  # the tool stands along the plane's z axis
        self._vector: Array | None = None  # the tool's axis, where a vector names it

    @property
    def tilted(self) -> bool:
        """Whether points are in a tilted plane."""
        return self._plane is not None

    @property
    def odd(self) -> str:
        """Why the tip in the part doesn't follow from where the axes stand; "" where it does."""
        if self._plane is not None and self._tcp:
            return _TWICE
        if self.own is not None and self._tcp and not in_plane(self.own):
            return _WITHIN
        if not self.used:
            return ""
        if self.machine is None and {"A", "B"} <= self.used:
            return _BOTH
        if self._plane is not None:
            return ""
        turned = {letter for letter in "ABC" if abs(math.remainder(self.at[letter] or 0.0, 360.0)) > _ZERO}
        if self.machine is not None and self.own is None:
            if turned - self.machine.letters:
                return _ELSE
            return _NO_LENGTH if turned and not self._tcp and math.isnan(self.length) else ""
        return TURNED if turned and not self._tcp else ""

    @property
    def tcp(self) -> bool:
        """Whether X, Y and Z are the tip's, however the axes are turned."""
        return bool(self._tcp)

    @property
    def by_axes(self) -> bool:
        """Whether rotary angles alone say how the tool stands: no plane and no vector does."""
        return self._plane is None and self._vector is None

    @property
    def _angles(self) -> dict[str, float]:
        """A, B, C in degrees, as far as they are known, else NaN."""
        return {letter: math.nan if (at := self.at[letter]) is None else at for letter in "ABC"}

    def _of_machine(self, xyz: Array) -> Array | None:
        """part_T_tip (4, 4) of X, Y, Z (m) in a known machine's axes; None where they are none."""
        if self.machine is None or not self.by_axes or self._tcp or self.own is not None:
            return None
        return self.machine.seen({**dict(zip("XYZ", xyz.tolist(), strict=True)), **self._angles}, self.length)

    @property
    def nowhere(self) -> str:
        """Of a cut that has no `pose`, why."""
        return UNNAMED if self.unnamed and any(self.at[letter] is None for letter in "XYZ") else _UNKNOWN

    def forget(self) -> None:
        """Where the tool stands is not known."""
        self.at.update(X=None, Y=None, Z=None)
        self.unnamed = False

    def rise(self) -> None:
        """The machine takes the tool up along Z, out of a cut; with turned axes nobody knows in which direction."""
        if self.tilted or any(self.at[letter] != 0.0 for letter in self.used):
            self.forget()
        else:
            self.at["Z"], self.unnamed, self.risen = None, False, True

    def switch(self, by: str, on: bool) -> None:
        """The tool centre point on or off, by "G" or "M": with turned axes, X, Y and Z mean another thing behind it."""
        before, tcp = self.odd, bool(self._tcp)
        self._tcp = self._tcp | {by} if on else self._tcp - {by}
        other = bool(self._tcp) != tcp
        if self.odd != before or (
            other and (self._vector is not None or (self.machine and any(self._angles.values())))
        ):
            self.forget()
        self._vector = self._vector if self._tcp else None

    def aim(self, vector: Array) -> bool:
        """The tool's axis by a vector (3,) of any length: the control finds the angles. False for none, or without TCP."""
        length = float(np.linalg.norm(vector))
        if not self._tcp or self.tilted or not length > _SHORT:
            return False
        self._vector = vector / length
        self.at.update(A=None, B=None, C=None)
        return True

    def leave(self, axes: set[str], words: Words | None = None) -> None:
        """These axes, or all where none is named, go to a position of the machine's own; X, Y and Z of a tilted plane are none of
        the machine's. words: which positions; None: the reference points. Those of rotary axes are their zeros, where they stand
        upright; whether they go there is only sure where they are named, or stood there.
        """
        every = set("XYZABC") if self.tilted else set("XYZ") | self.used
        for letter in axes or every:
            upright = not float(words[letter]) if words and axes else bool(axes) or self.at[letter] == 0.0
            self.at[letter] = 0.0 if letter in "ABC" and upright else None
        if not axes or "Z" in axes:
            self.unnamed, self.risen = True, False  # up there
        if self.tilted:
            self.forget()
            self._along = self._along and bool(axes) and not axes & set("ABC")

    def set_frame(self, code: str, words: Words, scale: float, *, begun: bool) -> bool:
        """G68.2 or G92; begun: the tool has been in the part. False where it is not understood, and nothing has changed."""
        return self._tilt(words, scale) if code == "68.2" else self._renumber(words, scale, begun)

    def _renumber(self, words: Words, scale: float, begun: bool) -> bool:
        """G92: the point where the tool stands has these coordinates from here on (LinuxCNC, G92; Fanuc alike). Where nothing has
        moved yet, they are the part's own.
        """
        axes = set(words) & set("XYZABC")
        lost = begun and any(self.at[letter] is None for letter in axes)
        if self.tilted or self.own is not None or lost or not axes <= _LINEAR:
            return False
        for letter in axes:
            value, stands = float(words[letter]) * scale, self.at[letter]
            if stands is None:
                self.at[letter] = value
            else:
                self.shift[letter], self.preset = stands - value, True
        return True

    def target(self, axes: set[str], words: Words, scale: float, absolute: bool) -> dict[str, float | None]:
        """Where a block with these axes ends; scale: metres in one of its units."""
        at = dict(self.at)
        axes = {letter for letter in axes if absolute or float(words[letter])}  # a step of nothing goes nowhere
        if self.own is not None or self.loose & axes:
            at.update(self._within(axes, words, scale, absolute))
            axes = axes - _LINEAR
        for letter in axes:
            value = float(words[letter]) * (scale if letter in "XYZ" else self._sense)
            before = at[letter]
            start = self.shift.get(letter, 0.0) if absolute else before
            at[letter] = None if start is None else start + value
        if not axes <= _LINEAR:
            self._vector = None
            self.used |= axes - _LINEAR
            for letter, other in () if self.machine else ("AB", "BA"):  # a machine has one of the two
                if letter in axes and other not in self.used:
                    at[other] = 0.0
        return at

    def turn(self, letter: str) -> float:
        """A rotary axis as the program writes it, degrees; NaN where it isn't known."""
        at = self.at[letter]
        return math.nan if at is None or self._vector is not None else self._sense * at

    def wind(self, letter: str, to: float, how: str) -> bool:
        """A rotary axis is at the same angle, counted from another turn, so that it goes to `to` (degrees) the way that DC (the
        shorter one), ACP (up) or ACN (down) says. False where that is either one, or the angle isn't known.
        """
        up = (to - self.turn(letter)) % 360.0
        if math.isnan(up):
            return False
        if how == "DC" and abs(up - 180.0) < _AS_FAR:
            return False
        down = how == "ACN" or (how == "DC" and up > 180.0)
        self.at[letter] = self._sense * (to - (up - 360.0 if down and up else up))
        return True

    def _within(self, axes: set[str], words: Words, scale: float, absolute: bool) -> dict[str, float | None]:
        """Where X, Y and Z of a block lead in a frame of the program's own, or in the first block behind one."""
        if self.loose & axes:
            if not (absolute and self.loose <= axes):
                return dict.fromkeys("XYZ")
            self.loose = set()
        named = self.named(self.at)
        for i, letter in enumerate("XYZ"):
            if letter in axes:
                named[i] = float(words[letter]) * scale + (0.0 if absolute else named[i])
        out = self.outward(named).tolist()
        return {letter: None if math.isnan(v) else v for letter, v in zip("XYZ", out, strict=True)}

    def frame(self, own: Array | None, loose: str = "") -> None:
        """Another frame of the program's own: the tool stays where it is. loose: as above."""
        self.own = own
        self.loose |= set(loose)

    def named(self, at: dict[str, float | None]) -> Array:
        """(3,) m: a place as the program writes it; NaN where it isn't known."""
        xyz = np.array([at[k] for k in "XYZ"], float) - np.array([self.shift[k] for k in "XYZ"])
        if self.own is None:
            return np.asarray(xyz)
        back = np.linalg.inv(self.own)
        return np.array([*(back[:2, :2] @ xyz[:2] + back[:2, 3]), back[2, 2] * xyz[2] + back[2, 3]])

    def outward(self, xyz: Array) -> Array:
        """(3,) m: a place that the program writes so, as `at` has it."""
        shift = np.array([self.shift[k] for k in "XYZ"])
        if self.own is None:
            return np.asarray(xyz + shift)
        own = self.own
        return np.asarray(np.array([*(own[:2, :2] @ xyz[:2] + own[:2, 3]), own[2, 2] * xyz[2] + own[2, 3]]) + shift)

    def about(self, normal: Array) -> Array:
        """In the part, about what an arc turns that the program has turn about `normal`, one of its axes."""
        return self.direction(normal if self.own is None else spin(self.own, normal))

    @property
    def stretch(self) -> tuple[float, float]:
        """By how much the program's own frame scales X and Y, and Z."""
        return (1.0, 1.0) if self.own is None else stretch(self.own)

    @property
    def floor(self) -> float:
        """Where the program's height 0 lies, m."""
        return float(self.outward(np.zeros(3))[2])

    def go(self, to: dict[str, float | None]) -> None:
        """The axes stand there now. Axes that turn in a tilted plane take the tip to where only the machine knows."""
        before, self.at = self.at, dict(to)
        self.unnamed = self.unnamed or all(to[letter] is not None for letter in "XYZ")
        if self.tilted and any(to[letter] != before[letter] for letter in "ABC"):
            self.forget()
            self._along = self._stands()

    def pose(self) -> tuple[Array, Array] | None:
        """The tip in the program's frame (m), the axis in the part; None where one of them is not known."""
        x, y, z, a, b, c = (self.at[letter] for letter in "XYZABC")
        if x is None or y is None or z is None:
            return None
        if self._plane is not None:
            return (np.array([x, y, z]), self._plane[0][:, 2]) if self._along else None
        if self._vector is not None:
            return np.array([x, y, z]), self._vector
        if a is None or b is None or c is None:
            return None
        return np.array([x, y, z]), self._axis(a, b, c)

    def _axis(self, a: float, b: float, c: float) -> Array:
        """The tool's axis in the part, of rotary axes in degrees."""
        if self.machine is None:
            return tool_axis(a, b, c, "B" in self.used)
        return np.asarray(self.machine.seen({**dict.fromkeys("XYZ", 0.0), "A": a, "B": b, "C": c}, 0.0)[:3, 2])

    def point(self, xyz: Array) -> Array:
        """A point (m) of the program's frame in the part."""
        if (pose := self._of_machine(xyz)) is not None:
            return np.asarray(pose[:3, 3])
        return xyz if self._plane is None else self._plane[1] + self._plane[0] @ xyz

    def direction(self, vector: Array) -> Array:
        """A direction of the program's frame in the part."""
        if self._of_machine(vector) is not None:
            return self.point(vector) - self.point(np.zeros(3))
        return vector if self._plane is None else self._plane[0] @ vector

    # -- tilted planes

    def _tilt(self, words: Words, scale: float) -> bool:
        """G68.2."""
        order = f"{float(words.get('Q', '313')):g}"
        if self._tcp or self.own is not None or any(self.shift.values()) or set(words) - _OF_PLANE:
            return False
        if float(words.get("P", "0")) or order not in _ORDERS:
            return False
        angles = np.array([deg_to_rad(float(words.get(letter, "0"))) for letter in "IJK"])
        about = np.eye(3)[[int(digit) - 1 for digit in order]]
        first, second, third = rotations_about(angles[:, None] * about)
        origin = np.array([float(words.get(letter, "0")) * scale for letter in "XYZ"])
        self._change((first @ second @ third, origin))
        return True

    def untilt(self) -> None:
        """G69: points are in the work frame again; the tool stays as it is turned."""
        if self.tilted:
            self._change(None)

    def swivel(self, turned: Array, origin: Array) -> bool:
        """A plane (3, 3) and its origin (3,), m, with the tool along its z axis; False beside the tool centre point."""
        if self._tcp or self.own is not None:
            return False
        self._change((turned, origin))
        return self.align()

    def lay(self, turned: Array, origin: Array) -> None:
        """A plane (3, 3) and its origin (3,), m, whose tool stays as it is."""
        if self._tcp or self.own is not None:
            self.forget()
        self._change((turned, origin))

    def align(self) -> bool:
        """G53.1: the tool is turned along the plane's z axis, by angles that nobody names; False where there is no plane."""
        if not self.tilted:
            return False
        if not self._stands():
            self.at.update(A=None, B=None, C=None)
        self._along = True
        self.forget()
        return True

    def _stands(self) -> bool:
        """Whether the rotary axes, as they are known, hold the tool along the plane's z axis."""
        a, b, c = (self.at[letter] for letter in "ABC")
        if self._plane is None or a is None or b is None or c is None:
            return False
        return float(np.linalg.norm(self._axis(a, b, c) - self._plane[0][:, 2])) < _ALONG

    def _change(self, plane: tuple[Array, Array] | None) -> None:
        """Another plane, or none: the tool doesn't move, and where it stands is known where both frames say it."""
        pose = None if self.odd or (self.machine and any(self._angles.values())) else self.pose()
        tip = None if pose is None else self.point(pose[0])
        self._plane = plane
        self._along = self._stands()
        if tip is None or not (self._along if self.tilted else self.pose() is not None and not self.odd):
            self.forget()
        else:
            x, y, z = (tip if plane is None else plane[0].T @ (tip - plane[1])).tolist()
            self.at.update(X=x, Y=y, Z=z)
