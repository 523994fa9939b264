"""Where the points and axes that an APT file prints lie in the part: MSYS, CSYS and TRNTYP, CATIA's matrix, TLAXIS, ROTABL."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from camrob.witness.cl.source import Statement, number
from camrob.witness.cl.teller import Teller, unit
from camrob.witness.units import INCH_MM, deg_to_rad, mm_to_m

__all__ = ["Placing"]

Array = NDArray[np.float64]

_Z = np.array([0.0, 0.0, 1.0])


class Placing:
    """The frame of the points and the modal axis. What it can't place it hides: `Teller.hidden`.

    axis: (3,) unit, as printed, in the frame of the points. part_R_points (3, 3) and part_p_points (m): that frame in the part.
    """

    def __init__(self, tell: Teller, dialect: str, units: str) -> None:
        self.units = units
        self.axis = _Z
        self.part_R_points, self.part_p_points = np.eye(3), np.zeros(3)
        self._tell, self._dialect = tell, dialect
        self._csys: tuple[Array, Array] = (np.eye(3), np.zeros(3))
        self._world: bool | None = None  # TRNTYP/WORLD
        self._rows: list[list[float]] | None = None  # of CATIA's matrix
        self._camera: list[float] | None = None
        self._offset: float | None = None
        self._angles: dict[str, float] = {}  # of ROTABL and ROTHED
        self._clt_angles: dict[str, float] = {}  # of ROTABL in .clt, rad
        self._clt_axis = _Z

    def words(self) -> dict[str, Callable[[Statement], None]]:
        """What each word does that places points."""
        return {
            "MSYS": self.msys, "CSYS": self.csys, "TRNTYP": self.trntyp, "TLAXIS": self.tlaxis, "ROTABL": self.rotabl,
            "ROTHED": self.rotabl, "CAMERA": self.camera, "MCS": self.mcs, "MCS2": self.mcs, "MCSYS": self.mcsys,
            "ZERO": self.zero,
        }  # fmt: skip

    @property
    def scale(self) -> float:
        """Metres in one of the file's units."""
        return mm_to_m(INCH_MM if self.units == "inch" else 1.0)

    def point(self, values: list[float]) -> Array:
        """A printed point in the part, m."""
        return self.part_p_points + self.part_R_points @ (np.array(values) * self.scale)

    def points(self, values: Array, printed: Array) -> tuple[Array, Array]:
        """Printed points (N, 3) and their axes, those behind none NaN, in the part."""
        axes = np.where(np.isnan(printed), self.axis, printed)
        if not np.isnan(printed[0]).any():
            self.prints(axes[0])
        self.axis = axes[-1] / np.linalg.norm(axes[-1])
        axes = axes @ self.part_R_points.T
        tips = self.part_p_points + (values * self.scale) @ self.part_R_points.T
        return tips, axes / np.linalg.norm(axes, axis=1, keepdims=True)

    @property
    def hand(self) -> float:
        """-1 where the points are mirrored, so that what turned right-handedly turns left-handedly; else 1."""
        return math.copysign(1.0, float(np.linalg.det(self.part_R_points)))

    def prints(self, axis: Array) -> None:
        """A point prints its axis."""
        self.axis = axis
        self._tell.hidden.pop("upright", None)

    def by_matrix(self, frame: tuple[Array, Array], line: int) -> None:
        """A matrix of TRACUT's or COPY's: of axes it takes those along that are printed, and leaves the others upright."""
        self.part_R_points, self.part_p_points = frame
        self._tell.hidden.pop("upright", None)
        if abs(frame[0][2, 2] - 1.0) > 1e-9:
            self._tell.hidden["upright"] = (line, "points that a matrix tilts, and no tool axis printed behind it")

    def along(self) -> Array:
        """The tool's axis in the part."""
        axis = self.part_R_points @ self.axis
        return np.asarray(axis / np.linalg.norm(axis))

    def _frame(self, part_R_points: Array, part_p_points: Array, line: int) -> bool:
        """Takes the frame, or hides its points and returns False."""
        self._tell.hidden.pop("frame", None)
        off = np.abs(part_R_points.T @ part_R_points - np.eye(3)).max()
        if off > 1e-3 or np.linalg.det(part_R_points) < 0.0:
            self._tell.hidden["frame"] = (line, "points in a frame whose matrix is not a rotation")
            return False
        self.part_R_points, self.part_p_points = part_R_points, part_p_points
        return True

    def msys(self, s: Statement) -> None:
        """NX: origin, X axis, Y axis of the frame that the points are in."""
        values = np.array(s.numbers)
        if len(values) != 9:
            self._tell.hidden["frame"] = (s.line, "MSYS that has not nine numbers")
            return
        self._frame(_axes(values[3:6], values[6:9]), values[:3] * self.scale, s.line)

    def mcs(self, s: Statement) -> None:
        """Autodesk's for CAMplete: the three axes of the points' frame, then its origin. MCS2: the axes again."""
        values, again = np.array(s.numbers), s.major == "MCS2"
        if len(values) != (9 if again else 12):
            self._tell.hidden["frame"] = (s.line, f"{s.major} of another length than a frame's")
            return
        turn = values[:9].reshape(3, 3).T
        if again and not np.allclose(turn, self.part_R_points, atol=1e-6):
            self._tell.hidden["frame"] = (s.line, "MCS2 with other axes than MCS")
        elif not again and self._frame(turn, values[9:] * self.scale, s.line):
            self.axis = _Z

    def mcsys(self, s: Statement) -> None:
        """Autodesk's for MfgSuite: the work offset, the origin, x and y axis of the points' frame."""
        values = np.array(s.numbers)
        if s.words != ["NUM", "POINT", "VECTOR", "VECTOR"] or len(values) != 10:
            self._tell.hidden["frame"] = (s.line, "MCSYS that is not NUM, POINT, VECTOR, VECTOR")
            return
        self._work_offset(values[0], s.line)
        if self._frame(_axes(values[4:7], values[7:10]), values[1:4] * self.scale, s.line):
            self.axis = _Z

    def zero(self, s: Statement) -> None:
        """ZERO/n, in Autodesk's for CAMplete: a work offset by its number."""
        named = self._dialect == "camplete-apt" and len(s.numbers) == 1
        self._work_offset(s.numbers[0] if named else math.nan, s.line)

    def _work_offset(self, number: float, line: int) -> None:
        """The first one is the part's zero; where another lies nobody knows."""
        self._offset = number if self._offset is None else self._offset
        if number != self._offset:
            self._tell.hidden["offset"] = (line, "points behind another work offset than before")

    def csys(self, s: Statement) -> None:
        """CAMWorks: three rows of four."""
        understood = len(s.numbers) == 12
        if understood:
            matrix = np.array(s.numbers).reshape(3, 4)
            self._csys = (matrix[:, :3], matrix[:, 3] * self.scale)
        self._camworks(s, understood)

    def trntyp(self, s: Statement) -> None:
        """CAMWorks: says whether points are in the world (and CSYS is not applied) or in CSYS."""
        self._tell.mark()
        self._world = s.words[:1] == ["WORLD"]
        self._camworks(s, not any(s.numbers))

    def _camworks(self, s: Statement, understood: bool) -> None:
        turn, shift = self._csys
        plain = bool(np.allclose(turn, np.eye(3)) and np.allclose(shift, 0.0))
        if not understood or (self._world is None and not plain):
            self._tell.hidden["frame"] = (s.line, "points in a frame of CSYS or TRNTYP that is not known")
            return
        if self._frame(turn, shift, s.line):
            self.axis = turn[:, 2] if self._world else _Z  # until an axis is printed
            if self._world:
                self.part_R_points, self.part_p_points = np.eye(3), np.zeros(3)

    def comment(self, s: Statement) -> None:
        """CATIA: three rows of four in the comments behind $$*CATIA0. Creo: CSYS in a comment, which moves nothing."""
        if s.rest.startswith("$$-> CSYS"):
            self.camera(Statement("CSYS", s.rest.partition("/")[2], s.line, s.last))
        elif s.rest.startswith("$$*CATIA0"):
            self._rows = []
        elif self._rows is not None:
            row = [v for v in map(number, s.rest[2:].split()) if v is not None]
            if len(row) == len(s.rest[2:].split()) == 4:
                self._rows.append(row)
            if len(self._rows) == 3:
                matrix, self._rows = np.array(self._rows), None
                self._frame(matrix[:, :3], matrix[:, 3] * self.scale, s.line)

    def camera(self, s: Statement) -> None:
        """GPOST, Creo: the points are in this frame already; another one says that they are in two."""
        self._camera = self._camera or s.numbers
        self._tell.hidden.pop("frame", None)
        if s.numbers != self._camera:
            self._tell.hidden["frame"] = (
                s.line,
                f"{s.major}: another frame than the first, and where it lies is not said",
            )

    def tlaxis(self, s: Statement) -> None:
        """The axis of points that print none."""
        axis = unit(np.array(s.numbers[:3])) if len(s.numbers) >= 3 else None
        if axis is None:
            self._tell.hidden["axis"] = (s.line, "TLAXIS that has no unit vector")
            return
        self._tell.hidden.pop("axis", None)
        if self._dialect == "camworks-clt":
            self._clt_axis = axis
            self._clt(s.line)
        else:
            self.axis = axis

    def rotabl(self, s: Statement) -> None:
        """A table turned: understood in .clt alone (radians, absolute, one axis away from 0)."""
        fields = s.fields
        angle = number(fields[0]) if fields else None
        about = next((f[0] for f in fields if f[1:] == "AXIS"), "?")
        if self._dialect == "camworks-clt" and s.major == "ROTABL" and angle is not None and about in "ABC":
            self._clt_angles[about] = -angle if "CLW" in fields else angle
            self._clt(s.line)
            return
        self._angles[s.major + about] = math.nan if angle is None else deg_to_rad(angle)
        self._tell.hidden.pop("table", None)
        if any(self._angles.values()):
            self._tell.hidden["table"] = (s.line, f"{s.major}: where the points lie on the turned table is not said")

    def _clt(self, line: int) -> None:
        """.clt prints points on the turned table: right where that brings the table's Z to TLAXIS."""
        turned = [(about, angle) for about, angle in self._clt_angles.items() if angle]
        table = np.eye(3)
        for about, angle in turned:
            i = "ABC".index(about)
            j, k = (i + 1) % 3, (i + 2) % 3
            table[j, j] = table[k, k] = math.cos(angle)
            table[k, j], table[j, k] = math.sin(angle), -math.sin(angle)
            self._tell.note("ROTABL: the part's frame is that of the table before it turns")
        self._tell.hidden.pop("table", None)
        if len(turned) > 1 or np.abs(table @ _Z - self._clt_axis).max() > 1e-3:
            self._tell.hidden["table"] = (line, "ROTABL turns the table to where TLAXIS is not")
            return
        self._frame(table, np.zeros(3), line)


def _axes(x: Array, y: Array) -> Array:
    """(3, 3) the axes of a frame as columns."""
    return np.column_stack([x, y, np.cross(x, y)])
