"""Frames in CL text: MSYS, CSYS, CATIA's matrix in comments, and tables that have turned the part."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError
from camrob.findings import Severity
from camrob.toolpath.apt.lexer import Statement
from camrob.toolpath.apt.state import Machine, unit_axis

__all__ = [
    "Table",
    "by_two",
    "camera",
    "csys",
    "matrix_rows",
    "msys",
    "rigid",
    "rotation",
    "set_frame",
    "set_operation_frame",
    "set_transformed",
    "tracut",
    "trans",
    "trntyp",
]

_SLACK = 1e-3  # of a printed rotation: five decimals are common
_HINT = "output the frame again from the CAM system"


def rotation(R: NDArray[np.float64], line: int) -> NDArray[np.float64]:
    """The rotation nearest to a printed one. Raises ToolpathError when that is no rotation (mirrored, skew, scaled)."""
    nearest = rigid(R, line)
    if np.linalg.det(R) < 0.0:
        raise ToolpathError("a frame is mirrored (left-handed)", hint=_HINT, line=line)
    return nearest


def rigid(R: NDArray[np.float64], line: int) -> NDArray[np.float64]:
    """The rotation, or rotation and mirror, nearest to a printed one. Raises ToolpathError where it scales or skews."""
    if not np.all(np.isfinite(R)) or np.max(np.abs(R.T @ R - np.eye(3))) > _SLACK:
        raise ToolpathError("a frame's axes are not unit vectors at right angles", hint=_HINT, line=line)
    if np.array_equal(R.T @ R, np.eye(3)):
        return R
    u, _, vt = np.linalg.svd(R)
    nearest: NDArray[np.float64] = u @ vt
    return nearest


def set_frame(m: Machine, part_R_cl: NDArray[np.float64], part_p_cl: NDArray[np.float64], line: int) -> None:
    """From here on the file's points are in this frame; a tilted tool axis must be stated again."""
    if np.allclose(part_R_cl, m.part_R_cl, atol=1e-12) and np.allclose(part_p_cl, m.part_p_cl, atol=1e-12):
        return
    turned = not np.allclose(part_R_cl, m.part_R_cl, atol=1e-9)
    m.part_R_cl, m.part_p_cl = part_R_cl, part_p_cl
    m.plain_frame = bool(np.array_equal(part_R_cl, np.eye(3)) and not part_p_cl.any())
    if turned and m.axis_raw[2] < 1.0 - 1e-12:
        m.axis_lost = True
    m.announce("")


def set_operation_frame(m: Machine, R: NDArray[np.float64], origin: NDArray[np.float64], line: int) -> None:
    """An operation begins in a frame of its own, printed as R (3, 3) and origin (3,) in the file's unit; the tool stands along
    its z until a GOTO tilts it. Raises ToolpathError where R is no rotation.
    """
    set_frame(m, rotation(R, line), origin * m.scale, line)
    m.set_axis(np.array([0.0, 0.0, 1.0]), line)


def by_two(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """(3, 3) a frame's axes as columns, of its x and y axis (3,)."""
    return np.column_stack([x, y, np.cross(x, y)])


def set_transformed(m: Machine, part_R_cl: NDArray[np.float64], part_p_cl: NDArray[np.float64], line: int) -> None:
    """As `set_frame`, of a matrix of APT's: it takes the points along, and the tool axes that are printed (MULTAX).

    An axis that none of its points prints stays upright there, so that points tilted out of their plane must print theirs.
    """
    set_frame(m, part_R_cl, part_p_cl, line)
    m.axis_lost |= bool(part_R_cl[2, 2] < 1.0 - 1e-9)
    if m.handed < 0.0:
        m.find("mirrored", "the path is mirrored from here on: what climbed cuts the conventional way", line)


def msys(m: Machine, s: Statement) -> None:
    """NX: origin, X axis and Y axis of the machining frame in the part's; the points are in that frame."""
    v = np.array(s.numbers)
    if m.shifted:
        raise ToolpathError("MSYS behind TRANS", hint="end TRANS before it", line=s.line)
    if len(v) != 9:
        raise ToolpathError(f"MSYS has {len(v)} numbers, not 9", hint=_HINT, line=s.line)
    set_frame(m, rotation(by_two(v[3:6], v[6:9]), s.line), v[:3] * m.scale, s.line)


def tracut(m: Machine, s: Statement) -> None:
    """TRACUT/matrix: the points behind it, transformed by three rows of four, are the part's; TRACUT/NOMORE ends it."""
    if not (m.plain_frame or m.transformed) or m.shifted:
        raise ToolpathError("TRACUT in a frame of the file's own", hint="output the points transformed", line=s.line)
    rows = np.eye(3, 4) if {"NOMORE", "OFF"} & set(s.words) else _rows(s.numbers, "TRACUT", s.line)
    set_transformed(m, rigid(rows[:, :3], s.line), rows[:, 3] * m.scale, s.line)
    m.transformed = not m.plain_frame


def trans(m: Machine, s: Statement) -> None:
    """TRANS/x,y,z behind motions: the points behind it are moved by that, till TRANS/OFF or NOMORE.

    Raises ToolpathError before the first motion, where the machine's zero may be meant as well; for a second one, which replaces
    the first or adds to it, as the post is set up (ICAM, "The TRANS Command"); and for other forms.
    """
    off = bool({"NOMORE", "OFF"} & set(s.words))
    if (s.words and not off) or (not off and len(s.numbers) != 3):
        raise ToolpathError("TRANS other than by x, y, z", hint="output the points moved", line=s.line)
    shift = np.zeros(3) if off else np.array(s.numbers)
    if m.position is None and not m.regions:
        if shift.any():
            raise ToolpathError(
                "TRANS before the first motion: whether the part or the machine's zero lies there, the file doesn't say",
                hint="output without it; the set-up's part_in_base places the part",
                line=s.line,
            )
        return
    if m.shifted and not off:
        raise ToolpathError(
            "TRANS behind TRANS: posts differ in whether it adds to the first",
            hint="end the first by TRANS/OFF",
            line=s.line,
        )
    if m.transformed or not (m.plain_frame or m.shifted):
        raise ToolpathError("TRANS in a frame of the file's own", hint="output the points moved", line=s.line)
    m.shifted = bool(shift.any())
    set_frame(m, np.eye(3), shift * m.scale, s.line)


def _rows(numbers: list[float], word: str, line: int) -> NDArray[np.float64]:
    """Three rows of four, file's unit."""
    if len(numbers) != 12:
        raise ToolpathError(f"{word} has {len(numbers)} numbers, not 12", hint=_HINT, line=line)
    return np.array(numbers).reshape(3, 4)


def _matrix(numbers: list[float], word: str, line: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Rotation and translation (file's unit) of a frame printed as three rows of four."""
    rows = _rows(numbers, word, line)
    return rotation(rows[:, :3], line), rows[:, 3]


def trntyp(m: Machine, s: Statement) -> None:
    """CAMWorks: which frame the points are in. Only the world's is known, with no shift."""
    if "WORLD" not in s.words or any(s.numbers):
        raise ToolpathError(
            f"TRNTYP/{s.text.strip()} is not known: only points in WORLD are", hint="output in world frame", line=s.line
        )
    m.world_points = True


def csys(m: Machine, s: Statement) -> None:
    """CAMWorks: the operation's frame. The points are in the world frame already; only the tool axis is taken from it.

    Its third column equals the axis that GOTO prints in every 3+2 file seen.
    """
    R, _ = _matrix(s.numbers, "CSYS", s.line)
    if not m.dialect.csys_sets_axis and not np.allclose(s.numbers, np.eye(3, 4).ravel(), atol=1e-9):
        raise ToolpathError(
            "CSYS turns or shifts the frame, and this dialect does not say in which frame the points are",
            hint="force the dialect (camworks-apt has world points), or output without CSYS",
            line=s.line,
        )
    if m.dialect.csys_sets_axis and not m.world_points:
        raise ToolpathError(
            "CSYS stands without TRNTYP/WORLD, so it is unknown in which frame the points are",
            hint="output TRNTYP/WORLD",
            line=s.line,
        )
    m.announce("")
    m.set_axis(R[:, 2], s.line)


def camera(m: Machine, s: Statement) -> None:
    """Creo by way of GPOST: the points have been shifted by it already, so it is only reported."""
    _matrix(s.numbers, "CAMERA", s.line)
    if not np.allclose(s.numbers, np.eye(3, 4).ravel(), atol=1e-9):
        m.find("camera-frame", "CAMERA is not applied: the points hold it already", s.line, Severity.INFO)


def matrix_rows(m: Machine, rows: list[list[float]], line: int) -> None:
    """CATIA: the part operation's frame, three rows of four in comments; the points are in that frame."""
    if m.shifted:
        raise ToolpathError("CATIA0 behind TRANS", hint="end TRANS before it", line=line)
    R, shift = _matrix([v for row in rows for v in row], "CATIA0", line)
    before = m.part_R_cl, m.part_p_cl
    set_frame(m, R, shift * m.scale, line)
    if not m.plain_frame and not (before[0] is m.part_R_cl and before[1] is m.part_p_cl):
        m.find(
            "catia-frame", "the points are moved from the part operation's frame into the part's", line, Severity.INFO
        )


class Table:
    """An indexing table (ROTABL) as CAMWorks' .clt has it: angles in radians, points in the frame of the turned part.

    With the table indexed, TLAXIS is the tool axis in the part's frame, and the tool stands along z in the points' own.
    So the points are turned back by the angle, in the sense that brings z to TLAXIS, about the file's origin.
    """

    __slots__ = ("angles", "machine", "part_axis", "used")

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self.angles = {"A": 0.0, "B": 0.0, "C": 0.0}
        self.part_axis = np.array([0.0, 0.0, 1.0])
        self.used: NDArray[np.float64] | None = None
        machine.settle = self.settle

    def reset(self) -> None:
        """A feature begins: its ROTABL count from zero (the file does not always turn the table back before)."""
        self.angles = dict.fromkeys(self.angles, 0.0)
        self.machine.settle = self.settle

    def turn(self, s: Statement) -> None:
        """One ROTABL: the angle is added to what the table has turned."""
        name = next((w[0] for w in s.words if w in ("AAXIS", "BAXIS", "CAXIS")), "")
        if not name or not s.numbers:
            raise ToolpathError(f"ROTABL/{s.text.strip()} names no axis or angle", hint="output it again", line=s.line)
        self.angles[name] += s.numbers[0]
        self.machine.settle = self.settle

    def axis(self, s: Statement) -> None:
        """One TLAXIS: the tool axis in the part's frame."""
        if len(s.numbers) != 3:
            raise ToolpathError("TLAXIS needs three numbers", hint="output it again", line=s.line)
        self.part_axis = unit_axis(np.array(s.numbers), s.line)
        self.machine.settle = self.settle

    def settle(self, line: int) -> None:
        """Before a motion: the frame that the table's angles and TLAXIS make; ToolpathError where they disagree."""
        m = self.machine
        turned = {name: angle for name, angle in self.angles.items() if abs(math.remainder(angle, math.tau)) > 1e-4}
        if not turned:
            R = np.eye(3)
            m.axis_raw, m.axis_lost = self.part_axis, False
        else:
            R = self._turned(turned, line)
            m.axis_raw, m.axis_lost = np.array([0.0, 0.0, 1.0]), False
            m.find(
                "indexed-table",
                "the table was to turn the part: the points are turned about the file's origin, and the tool tilts",
                line,
            )
        if self.used is None:
            self.used = R
        elif not np.allclose(self.used, R, atol=1e-4):
            raise ToolpathError(
                "the table turns between operations, and the file does not say where its centre is",
                hint="output one file for each position of the table",
                line=line,
            )
        if not np.allclose(R, m.part_R_cl, atol=1e-12):
            set_frame(m, R, np.zeros(3), line)
            m.axis_lost = False
        m.settle = None

    def _turned(self, turned: dict[str, float], line: int) -> NDArray[np.float64]:
        """The rotation about the one turned axis that takes z to TLAXIS."""
        if len(turned) == 1 and "C" not in turned:
            ((name, angle),) = turned.items()
            for sign in (1.0, -1.0):
                c, s = math.cos(angle), math.sin(sign * angle)
                R = np.array([[1, 0, 0], [0, c, -s], [0, s, c]] if name == "A" else [[c, 0, s], [0, 1, 0], [-s, 0, c]])
                if np.allclose(R[:, 2], self.part_axis, atol=1e-3):
                    exact: NDArray[np.float64] = rotation(np.where(np.abs(R) < 1e-6, 0.0, R), line)
                    return exact
        raise ToolpathError(
            "the table's turns (ROTABL) and the tool axis (TLAXIS) do not fit each other",
            hint="output the path in the part's frame, with i, j, k in each GOTO",
            line=line,
        )
