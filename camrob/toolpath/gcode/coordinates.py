"""Where the tool is: program coordinates, rotary angles and tilted planes of a G-code program as tip and tool axis."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError
from camrob.machine_tool import TURNED, MachineTool, placed, reach, rotary_axes, unknown_axes
from camrob.toolpath.gcode.program_frame import PLAIN, ProgramFrame
from camrob.units import deg_to_rad, rad_to_deg

__all__ = ["Stance", "ToolFrame", "Triple"]

_LINEAR = {"X": 0, "Y": 1, "Z": 2}
_ROTARY = {"A": 0, "B": 1, "C": 2}
_HALF = 1e-6  # degrees: nearer to half a turn than this either way round may be the shorter one
_SHORTEST = 1e-3  # of a vector: a component is printed with three decimals at least
_ALIGNED = math.cos(deg_to_rad(0.1))  # a tool within 0.1 degrees of a tilted plane's normal stands on it

Triple = tuple[float, float, float]


class Stance:
    """A place of the tool: tip (m) and axis in the part, rotary angles (rad), and whether angles define the axis, or a vector."""

    __slots__ = ("angles", "axis", "rotary", "tip", "vector")

    def __init__(self, tip: Triple, axis: Triple, angles: Triple, rotary: bool, vector: bool = False) -> None:
        self.tip = tip
        self.axis = axis
        self.angles = angles
        self.rotary = rotary
        self.vector = vector


class ToolFrame:
    """The tool's place as the program has named it so far; a coordinate that it hasn't named is NaN.

    `xyz` (3 floats, m) are program coordinates: tip in the part while the tool centre point is on, the tool stands on
    a tilted plane, or the rotary axes are at zero; otherwise they are the machine's own, from which the tip can't be
    known without the machine's geometry. `angles` (A, B, C) in rad. `program`: a frame that the program has set within
    these, in which `xyz` then are; `unsettled`: its axes that no block has named together since. `machine`: whose axes these are.
    """

    __slots__ = (
        "angles",
        "kinematics",
        "machine",
        "on_plane",
        "plane",
        "program",
        "sense",
        "shift",
        "tcp_g",
        "tcp_m",
        "tool",
        "unsettled",
        "vector",
        "xyz",
    )

    def __init__(self, kinematics: str, machine: MachineTool | None = None) -> None:
        self.machine = machine
        self.tool = 0
        self.kinematics = "unknown" if kinematics == "3axis" else kinematics.removesuffix("-iso")
        self.sense = -1.0 if kinematics.endswith("-iso") else 1.0  # of rotary words beside LinuxCNC's
        self.xyz = [math.nan] * 3
        self.angles = [0.0, 0.0, 0.0]
        self.shift = [0.0, 0.0, 0.0]  # G52
        self.plane: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None  # part_R_plane, part_p_plane
        self.program = PLAIN
        self.unsettled = frozenset[str]()
        self.on_plane = False
        self.vector: Triple | None = None  # the tool's axis in the program's frame, where a vector names it
        self.tcp_g = False  # G43.4, until G49
        self.tcp_m = False  # M128, M428, TRAORI, until M129, M429, TRAFOOF

    @property
    def tcp(self) -> bool:
        """Whether the control keeps the tool centre point on the programmed path."""
        return self.tcp_g or self.tcp_m

    @property
    def turned(self) -> bool:
        """Whether a rotary axis is away from zero, or nobody knows."""
        a, b, c = self.angles
        if a == 0.0 and b == 0.0 and c == 0.0:
            return False
        return any(not (math.isfinite(v) and abs(math.remainder(v, math.tau)) < TURNED) for v in (a, b, c))

    @property
    def placeable(self) -> bool:
        """Whether program coordinates say where the tip is in the part."""
        if self.plane is not None:
            return self.on_plane
        return self.oriented if self.tcp else not self.turned or self.by_machine

    @property
    def by_machine(self) -> bool:
        """Whether the tip is where the machine's turned axes take it: no tool centre point, plane or frame beside them."""
        if self.machine is None or self.tcp or self.plane is not None or self.program is not PLAIN:
            return False
        return self.turned and all(map(math.isfinite, self.angles))

    @property
    def oriented(self) -> bool:
        """Whether angles or a vector say how the tool stands (a control that finds the angles itself, G53.1, names none)."""
        return self.vector is not None or all(map(math.isfinite, self.angles))

    @property
    def known(self) -> bool:
        """Whether X, Y and Z have all been named."""
        x, y, z = self.xyz
        return x == x and y == y and z == z

    def axis(self) -> tuple[float, float, float]:
        """The tool's unit axis in the part, tip to holder."""
        if self.plane is not None and self.on_plane:
            x, y, z = self.plane[0][:, 2].tolist()
            return x, y, z
        if self.vector is not None:
            return self.vector
        if self.machine is not None:
            x, y, z = self._machined(self.machine)[1]
            return x, y, z
        a, b, c = self.angles
        if self.kinematics == "unknown" and self.turned:
            raise unknown_axes()
        if self.kinematics == "xyzac":
            return math.sin(a) * math.sin(c), math.sin(a) * math.cos(c), math.cos(a)
        if self.kinematics == "xyzbc":
            return -math.sin(b) * math.cos(c), math.sin(b) * math.sin(c), math.cos(b)
        return 0.0, 0.0, 1.0

    def tip(self) -> tuple[float, float, float]:
        """The tip in the part's frame, m."""
        if self.machine is not None and self.by_machine:
            x, y, z = self._machined(self.machine)[0]
            return x, y, z
        x, y, z = self.xyz if self.program is PLAIN else self.program.out(np.array(self.xyz)).tolist()
        if self.plane is not None:
            rotation, origin = self.plane
            x, y, z = (rotation @ np.array((x, y, z)) + origin).tolist()
        return x + self.shift[0], y + self.shift[1], z + self.shift[2]

    def stance(self) -> Stance:
        """Where the tool stands, as a place of the tool in the part."""
        if self.plane is not None:
            return Stance(self.tip(), self.axis(), (0.0, 0.0, 0.0), False)
        if self.vector is not None:
            return Stance(self.tip(), self.vector, (0.0, 0.0, 0.0), False, True)
        if self.machine is not None:
            return Stance(self.tip(), self.axis(), (0.0, 0.0, 0.0), False, True)
        a, b, c = self.angles
        return Stance(self.tip(), self.axis(), (a, b, c), True)

    def normal(self, vector: NDArray[np.float64]) -> NDArray[np.float64]:
        """What an arc turns about right-handedly in the part that turns about `vector` in the program's frame."""
        if self.machine is not None and self.by_machine:
            return np.asarray(self._machined(self.machine)[2] @ vector)
        inner = vector if self.program is PLAIN else self.program.normal(vector)
        return inner if self.plane is None else self.plane[0] @ inner

    def up(self) -> NDArray[np.float64]:
        """The program's Z axis in the part."""
        if self.machine is not None and self.by_machine:
            return self._machined(self.machine)[2][:, 2]
        return np.array([0.0, 0.0, 1.0]) if self.plane is None else self.plane[0][:, 2]

    def point(self, xyz: NDArray[np.float64]) -> NDArray[np.float64]:
        """A point of the program's frame in the part's."""
        if self.machine is not None and self.by_machine:
            tip, _, turn = self._machined(self.machine)
            return np.asarray(turn @ (xyz - np.array(self.xyz)) + tip)
        xyz = xyz if self.program is PLAIN else self.program.out(xyz)
        inner = xyz if self.plane is None else self.plane[0] @ xyz + self.plane[1]
        return np.asarray(inner + np.array(self.shift))

    def _machined(self, machine: MachineTool) -> tuple[list[float], list[float], NDArray[np.float64]]:
        """Tip (m) and tool axis in the part, and part_R_program, as the machine's axes carry part and tool."""
        length = reach(machine, self.tool) if self.by_machine else 0.0  # an axis alone needs none
        xyz = np.array([self.xyz]) + np.array(self.shift)
        tips, axes, turns = placed(machine, length, xyz, np.array([self.angles]))
        return tips[0].tolist(), axes[0].tolist(), turns[0]

    def move(self, words: dict[str, float], scale: float, degree: float, incremental: bool) -> None:
        """Take the coordinates of a block: X, Y, Z times `scale` (m), A, B, C times `degree` (rad)."""
        xyz, angles, turned = self.xyz, self.angles, False
        if self.unsettled and not self.unsettled.isdisjoint(words):
            self._settle(words, incremental)
        for letter, value in words.items():
            i = _LINEAR.get(letter)
            if i is not None:
                xyz[i] = xyz[i] + value * scale if incremental else value * scale
                continue
            i = _ROTARY.get(letter)
            if i is not None:
                angle = self.sense * value * degree
                angles[i] = angles[i] + angle if incremental else angle
                turned = True
        if turned:
            self.vector = None
            if self.machine is not None:  # what it has no axis for stands still
                for letter in _ROTARY.keys() - self.machine.words:
                    angles[_ROTARY[letter]] = 0.0
            open_ = [i for i, angle in enumerate(angles) if math.isnan(angle)]
            if self.kinematics == "unknown" and len(open_) == 1:  # a machine has two rotary axes: both are named
                angles[open_[0]] = 0.0
            if odd := self._strangers(words):
                raise ToolpathError(
                    f"{min(odd)} turns, and the machine's file has no such axis",
                    hint="add it there as [[table]] or [[head]]",
                )
            stranger = {"xyzac": 1, "xyzbc": 0}.get(self.kinematics)
            if stranger is not None and abs(math.sin(0.5 * angles[stranger])) > TURNED:
                raise ToolpathError(
                    f"{'AB'[stranger]} turns in a program for {self.kinematics}: a kinematics that is not known here",
                    hint="post tool vectors, or for a machine with A and C or B and C",
                )
        if turned and self.plane is not None and self.on_plane != self._stands():
            self.on_plane = not self.on_plane
            self.forget()

    def _strangers(self, words: dict[str, float]) -> set[str]:
        """Rotary words that turn, of axes that the machine doesn't have."""
        own = _ROTARY.keys() if self.machine is None else self.machine.words
        return {letter for letter in words if letter in _ROTARY and words[letter] != 0.0} - own

    def _settle(self, words: dict[str, float], incremental: bool) -> None:
        """The first block behind a frame that turns, mirrors or scales: what an axis alone would do, controls disagree on."""
        if incremental or not self.unsettled.issubset(words):
            names = " and ".join(sorted(self.unsettled))
            raise ToolpathError(
                f"the first block behind a turned, mirrored or scaled frame, or its end, has not {names} in it, absolute",
                hint=f"name {names} together: where the others go controls disagree on",
            )
        self.unsettled = frozenset()

    def set_program(self, program: ProgramFrame, *, together: str = "") -> None:
        """Another frame of the program's (lengths in m), or `PLAIN`; the tool stays where it is.

        together: of these axes, the next block that names one has to name all. Raises ToolpathError where the tool centre point
        is on and the frame turns.
        """
        if program.plain:
            program = PLAIN
        if self.tcp and not (program.shifts_only and self.program.shifts_only):
            raise ToolpathError(
                "a turned, mirrored or scaled frame while the tool centre point is on",
                hint="let the CAM system turn the path",
            )
        if not self.placeable or (self.by_machine and program is not PLAIN):
            raise ToolpathError("a frame set with turned axes and the tool centre point off", hint="post with TCP on")
        self.xyz = program.into(self.program.out(np.array(self.xyz))).tolist()
        self.program = program
        self.unsettled = self.unsettled | frozenset(together)

    def turn(self, letter: str) -> float | None:
        """A, B or C in degrees as the program would write it; None where only the control knows."""
        angle = self.angles[_ROTARY[letter]]
        return None if self.vector is not None or math.isnan(angle) else self.sense * rad_to_deg(angle)

    def rewound(self, letter: str, to: float, how: str) -> float | None:
        """Name a rotary axis by whole turns otherwise (the shift, rad), so that it goes to `to` (degrees) as `how` says.

        DC: the shortest way, ACP upwards, ACN downwards. None where that isn't certain: half a turn, or an unknown angle.
        """
        stands = self.turn(letter)
        if stands is None:
            return None
        way = math.remainder(to - stands, 360.0)
        if how == "DC" and abs(abs(way) - 180.0) < _HALF:
            return None
        if how != "DC" and way * (1.0 if how == "ACP" else -1.0) < 0.0:
            way += 360.0 if how == "ACP" else -360.0
        shift = self.sense * deg_to_rad(to - way - stands)
        self.angles[_ROTARY[letter]] += shift
        return shift

    def aim(self, vector: tuple[float, float, float]) -> None:
        """Name the tool's axis by a vector, tip to holder, of any length: the rotary angles are the control's own from here on.

        Raises ToolpathError without the tool centre point, in a tilted plane, and for a vector without a length.
        """
        length = math.hypot(*vector)
        if not self.tcp or self.plane is not None:
            raise ToolpathError(
                "a tool axis by a vector with the tool centre point off, or in a tilted plane",
                hint="switch TCP on in the part's frame before it",
            )
        if not length > _SHORTEST:
            raise ToolpathError("a tool axis without a length", hint="name all three components")
        x, y, z = (v / length for v in vector)
        self.vector = (x, y, z)
        self.angles = [math.nan] * 3

    def _stands(self) -> bool:
        """Whether the named rotary angles put the tool on the tilted plane's normal."""
        if self.plane is None or not self.oriented:
            return False
        if self.kinematics == "unknown" and self.turned:
            return False
        if self.machine is None:
            axis = rotary_axes(self.kinematics, np.array([self.angles]))[0]
        else:
            axis = placed(self.machine, 0.0, np.zeros((1, 3)), np.array([self.angles]))[1][0]
        return float(axis @ self.plane[0][:, 2]) > _ALIGNED

    def forget(self, letters: str = "XYZ") -> None:
        """The named coordinates are no longer known; rotary axes are at the machine's zero."""
        for letter in letters:
            if letter in _LINEAR:
                self.xyz[_LINEAR[letter]] = math.nan
            elif letter in _ROTARY:
                self.angles[_ROTARY[letter]] = 0.0

    def switch_tcp(self, on: bool, *, by_m: bool) -> None:
        """Tool centre point on or off; with turned axes the other kind of coordinates is not known."""
        if on and not self.program.shifts_only:
            raise ToolpathError(
                "the tool centre point switched on in a turned, mirrored or scaled frame",
                hint="end the frame before it",
            )
        before = self.tcp
        if by_m:
            self.tcp_m = on
        else:
            self.tcp_g = on
        if self.tcp != before and self.turned:
            self.forget()
        if not self.tcp:
            self.vector = None

    def tilt(self, rotation: NDArray[np.float64], origin: NDArray[np.float64]) -> None:
        """Set a tilted plane (G68.2): program coordinates are its own from here on."""
        if self.tcp:
            raise ToolpathError(
                "a tilted plane (G68.2) while the tool centre point is on", hint="use one of the two, or switch TCP off"
            )
        if self.program is not PLAIN:
            raise ToolpathError("a tilted plane inside another frame of the program's", hint="end that frame before it")
        self._leave_plane()
        if self.by_machine:
            self.forget()
        self.plane = (rotation, origin)
        self.on_plane = self._stands()
        self._reframe()

    def untilt(self) -> None:
        """Back to the work frame (G69); the tool stays turned until the rotary axes are named."""
        self._leave_plane()

    def orient(self) -> None:
        """Turn the tool onto the tilted plane's normal (G53.1): where the tip goes meanwhile isn't known."""
        if self.plane is None:
            raise ToolpathError("G53.1 without a tilted plane", hint="set the plane with G68.2 first")
        self.on_plane = True
        if not self._stands():
            tilting = "B" if self.kinematics == "xyzbc" else "A"
            self.angles[_ROTARY[tilting]] = self.angles[_ROTARY["C"]] = math.nan
            if self.kinematics in ("unknown", "machine"):
                self.angles = [math.nan] * 3
        self.forget()

    def set_shift(self, shift: list[float]) -> None:
        """Set a local shift (G52); the tool stays where it is."""
        if self.plane is not None:
            raise ToolpathError("G52 in a tilted plane is not read", hint="put the shift into G68.2's origin")
        if self.program is not PLAIN:
            raise ToolpathError(
                "G52 in a turned, mirrored or scaled frame is not read", hint="put it before that frame"
            )
        self.xyz = [v + old - new for v, old, new in zip(self.xyz, self.shift, shift, strict=True)]
        self.shift = shift

    def _leave_plane(self) -> None:
        """Drop a tilted plane: coordinates are the machine's again, and unknown if it was turned for the plane."""
        if self.plane is None:
            return
        if self.program is not PLAIN:
            raise ToolpathError("a tilted plane ends while another frame is set within it", hint="end that frame first")
        if self.on_plane and not self.turned:
            self.xyz = [v - s for v, s in zip(self.tip(), self.shift, strict=True)]
        else:
            self.forget()
        self.plane = None
        self.on_plane = False

    def _reframe(self) -> None:
        """Express the known place in the new plane's coordinates."""
        if self.plane is None or not self.known or not self.on_plane:
            self.forget()
            return
        rotation, origin = self.plane
        self.xyz = (rotation.T @ (np.array(self.xyz) - origin)).tolist()
