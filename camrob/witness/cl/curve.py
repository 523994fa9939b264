"""NX's NURBS: a B-spline without weights from where the tool stands, by the KNOT and CNTRL statements behind the word.

With n control points (the place where the tool stands is the first of them, said again or not) and k knots, the counts say the
degree: n - 1 - k where only the knots between the ends are listed (the ends are 0 and 1 then), k - 1 - n where all of them are.
The curve begins at its first control point and ends at its last. (de Boor, A Practical Guide to Splines, chapter IX.)
"""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError
from camrob.witness.cl.placing import Placing
from camrob.witness.cl.source import Statement, number
from camrob.witness.cl.teller import Teller
from camrob.witness.happenings import Way
from camrob.witness.units import mm_to_m

__all__ = ["Curve", "spline_points", "tlon"]

Array = NDArray[np.float64]
_SAME = mm_to_m(0.001)  # nearer to the tool than this, the first control point is where it stands
_FLAT = mm_to_m(0.0005)  # what the steps in which a curve is given may leave it by
_DOUBLINGS = 10  # of the steps of one piece, 4 to begin with for each of its degrees


class Curve:
    """One curve as its statements come."""

    def __init__(self, line: int) -> None:
        self._line = self._last = line
        self._problem = ""
        self._knots: list[float] = []
        self._control: list[list[float]] = []

    def add(self, s: Statement) -> None:
        """A KNOT or CNTRL statement."""
        self._last = s.last
        numbers = s.numbers
        if s.words or not numbers or (s.major == "CNTRL" and len(numbers) % 3):
            self._problem = f"NURBS with a {s.major} that has not its numbers"
        elif s.major == "KNOT":
            self._knots += numbers
        else:
            self._control += [numbers[i : i + 3] for i in range(0, len(numbers), 3)]

    def tell(self, tell: Teller, place: Placing, free: bool) -> None:
        """Tells the curve as a cut, or a gap. free: no cycle, no arc and no rapid is in force."""
        points = None
        if not self._problem and free and tell.here is not None and self._control:
            control = np.array([place.point(point) for point in self._control])
            again = np.linalg.norm(control[0] - tell.here) <= _SAME
            points = spline_points(np.vstack([tell.here, control[1:] if again else control]), np.array(self._knots))
            self._problem = "NURBS whose knots don't fit its control points"
        if points is None:
            text = self._problem or "NURBS from where the tool isn't known to be, or in a cycle, an arc or rapid"
            tell.gap(self._line, text, last=self._last)
        else:
            tell.curve(points[1:], place.along(), self._line)


def spline_points(control: Array, knots: Array) -> Array | None:
    """Points (N, 3) along the curve, its start first, so near together that its chords leave it by half a micrometre at most.

    control: (n, 3) m. None where the numbers make no such curve.
    """
    found = _clamped(len(control), knots)
    if found is None:
        return None
    every, degree = found
    pieces = [_piece(control, every, degree, a, b) for a, b in pairwise(np.unique(every))]
    return np.vstack([control[:1], *pieces])


def _clamped(n: int, knots: Array) -> tuple[Array, int] | None:
    """All knots and the degree; None where there is no clamped curve of n control points."""
    if 0 < len(knots) <= n and knots[-1] == 1.0:  # the inner ones and, as NX writes them, the last one
        knots = knots[:-1]
    k = len(knots)
    degree = k - n - 1 if k > n else n - k - 1
    if degree < 1 or (np.diff(knots) < 0.0).any():
        return None
    if k <= n:
        if k and not (knots[0] > 0.0 and knots[-1] < 1.0):
            return None
        return np.concatenate([np.zeros(degree + 1), knots, np.ones(degree + 1)]), degree
    ends = knots[: degree + 1], knots[-degree - 1 :]
    if any(np.ptp(end) > 0.0 for end in ends) or not knots[0] < knots[-1]:
        return None
    return knots, degree


def _on_curve(control: Array, knots: Array, degree: int, u: Array, span: int) -> Array:
    """Points (N, 3) at parameters between the knots span and span + 1: de Boor's algorithm, all of them at once."""
    d = [np.broadcast_to(control[span - degree + j], (len(u), 3)) for j in range(degree + 1)]
    for r in range(1, degree + 1):
        for j in range(degree, r - 1, -1):
            low, high = knots[span - degree + j], knots[span + 1 + j - r]
            share = ((u - low) / (high - low))[:, None]
            d[j] = (1.0 - share) * d[j - 1] + share * d[j]
    return np.asarray(d[degree])


def _piece(control: Array, knots: Array, degree: int, a: float, b: float) -> Array:
    """Points on the piece between two neighbouring knots, the first left out."""
    span = int(np.searchsorted(knots, a, side="right")) - 1
    count = 4 * degree
    for _ in range(_DOUBLINGS):
        fine = _on_curve(control, knots, degree, np.linspace(a, b, 2 * count + 1), span)
        off = fine[1::2] - 0.5 * (fine[:-1:2] + fine[2::2])
        if np.linalg.norm(off, axis=1).max() <= _FLAT:
            break
        count *= 2
    return fine[2::2]


def tlon(tell: Teller, place: Placing, s: Statement, direction: Array | None, way: Way) -> None:
    """CATIA's arc: (CIRCLE/centre, radius),ON,[2,INTOF,](LINE/centre, end), which sets out along INDIRV."""
    found = re.fullmatch(r"\(CIRCLE/([^()]*)\),ON,(?:2,INTOF,)?\(LINE/([^()]*)\)", re.sub(r"\s", "", s.rest.upper()))
    parts = [[number(f) for f in text.split(",")] for text in found.groups()] if found else []
    circle, ends = ([v for v in part if v is not None] for part in parts or ([], []))
    if len(circle) != 4 or len(ends) != 6 or [len(p) for p in parts] != [4, 6]:
        what = "TLON,GOFWD with other curves than a circle and a line of numbers: an APT part program"
        raise ToolpathError(what, hint="run it through the APT processor first")
    here, side = tell.here, 0.0
    center, axis = place.point(circle[:3]), place.along()
    spoke = place.point(ends[3:]) - center
    end = center + spoke * (circle[3] * place.scale / max(float(np.linalg.norm(spoke)), 1e-12))
    if here is not None and direction is not None:
        side = float(np.cross(here - center, direction) @ axis)
    if not side:
        tell.gap(s.line, "an arc whose start or INDIRV is not known", last=s.last)
    else:
        tell.arc(end, axis, center, axis if side > 0.0 else -axis, way, s.line)
