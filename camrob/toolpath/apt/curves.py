"""Curves of CL text as points: CIRCLE before a GOTO, CATIA's TLON,GOFWD, NX's NURBS blocks."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError
from camrob.toolpath.apt.bspline import clamped_spline, sample_spline
from camrob.toolpath.apt.lexer import Statement, number_of
from camrob.toolpath.apt.state import Curve, Machine
from camrob.toolpath.region import Move
from camrob.toolpath.sampling import arc_angle, arc_radius, sample_arc
from camrob.units import m_to_mm, mm_to_m, rad_to_deg

__all__ = ["Nurbs", "arc_of", "arc_to", "circle", "indirv", "tlon", "turned_by"]

_MISFIT_MM = 0.05  # start and end may differ in radius by rounding, not by more than this
_FLAT_MM = 0.001  # an axial rise below this is rounding: the arc stays an arc
_STRAIGHT_BACK = 0.94  # cosine: within 20 degrees of it
_MOST_TURNS = 1000
_LEFT_HANDED = 11  # numbers of CIRCLE where its axis points against the sense of turning
_TLON = re.compile(r"\(\s*CIRCLE\s*/([^()]*)\)\s*,\s*ON\s*,.*\(\s*LINE\s*/([^()]*)\)", re.I | re.S)


def circle(m: Machine, s: Statement) -> None:
    """CIRCLE/centre, axis[, radius, ...][, TIMES, n]: the way to the next GOTO's point is this arc."""
    m.curve = arc_of(m, s)


def arc_of(m: Machine, s: Statement) -> Curve:
    """The arc that a CIRCLE asks for, to be taken to the next GOTO's point. Raises ToolpathError for a damaged one."""
    v = s.numbers
    turns = 0
    if "TIMES" in s.words:
        turns = round(v.pop())
    if len(v) < 6 or not 0 <= turns <= _MOST_TURNS or isinstance(s.args[0], str):
        raise ToolpathError("CIRCLE needs centre, axis and at most 1000 turns", hint="output it again", line=s.line)
    if m.settle is not None:
        m.settle(s.line)
    center = m.to_part(np.array(v[:3]))
    normal = np.array(v[3:6])
    length = float(np.linalg.norm(normal))
    if not abs(length - 1.0) <= 1e-3:
        raise ToolpathError(f"CIRCLE's axis has the length {length:.4f}", hint="output it again", line=s.line)
    axis = m.handed * m.part_R_cl @ normal / length
    left_handed = m.dialect.left_handed_arcs
    if left_handed is None:  # eleven numbers are NX's and Makino's way of writing it
        left_handed = len(v) >= _LEFT_HANDED
        hand = "left" if left_handed else "right"
        m.find(
            "arc-sense", f"the file does not say whose CIRCLE this is; taken as {hand}-handed about its axis", s.line
        )
    # CAMWorks' .clt prints 0,0,1 for both senses and tells them by a word
    if left_handed or "CLOCKWISE" in s.words or "CLW" in s.words:
        axis = -axis
    radius = v[6] * m.scale if len(v) > 6 else 0.0
    m.curve_line = s.line
    _check_sense(m, center, axis, s.line)
    return lambda end, tool, line: arc_to(m, end, center, axis, turns, tool, line, radius)


def turned_by(
    m: Machine, end: NDArray[np.float64], center: NDArray[np.float64], axis: NDArray[np.float64], line: int
) -> float:
    """Degrees by which an arc turns from where the tool is to `end`, right-handed about a unit axis, all in the part's frame."""
    return rad_to_deg(arc_angle(_start(m, line), end, center, axis))


def _start(m: Machine, line: int) -> NDArray[np.float64]:
    """Where an arc begins. Raises ToolpathError where nobody knows."""
    if m.position is None:
        raise ToolpathError("an arc has no start: no point stands before it", hint="start with a GOTO", line=line)
    return m.position


def _check_sense(m: Machine, center: NDArray[np.float64], axis: NDArray[np.float64], line: int) -> None:
    """An arc that turns straight back, which the other sense would not: a warning; ToolpathError where the sense is assumed."""
    way = m.builder.last_way
    if way is None or m.position is None or m.builder.last_move != Move.CUT or m.rapid:
        return
    leaves = np.cross(axis, m.position - center)
    size = float(np.linalg.norm(way) * np.linalg.norm(leaves))
    if not size > 0.0 or float(way @ leaves) >= -_STRAIGHT_BACK * size:
        return
    if m.dialect.left_handed_arcs is None:
        raise ToolpathError(
            "CIRCLE about its axis would turn straight back where it begins, and the other way round go on smoothly: "
            "the file does not say whose it is",
            hint="name its dialect (nx-clsf and makino-cldata mean the axis the other way), or output points",
            line=line,
        )
    hand = "clockwise" if m.dialect.left_handed_arcs else "counter-clockwise"
    text = (
        f"CIRCLE turns straight back where it begins, and the other way round it would go on smoothly: {m.dialect.name} means it "
        f"{hand} about the axis that it prints; look at this arc before it is cut"
    )
    m.find("arc-turns-back", text, line)


def arc_to(
    m: Machine,
    end: NDArray[np.float64],
    center: NDArray[np.float64],
    axis: NDArray[np.float64],
    turns: int,
    tool: NDArray[np.float64],
    line: int,
    radius: float = 0.0,
) -> None:
    """The arc from where the tool is to `end`, right-handed about `axis`, all in the part's frame.

    In rapid where RAPID stands before it. Raises ToolpathError where there is no start, or where start and end don't lie on
    one circle.
    """
    start = _start(m, line)
    rapid, m.rapid = m.rapid, False
    feed = 0.0 if rapid else m.cut_feed(line)
    r0, r1 = arc_radius(start, center, axis), arc_radius(end, center, axis)
    slack = max(mm_to_m(_MISFIT_MM), 1e-4 * r0)
    if abs(r0 - r1) > slack or (radius > 0.0 and abs(r0 - radius) > slack):
        said = ", ".join(f"{m_to_mm(r):.3f}" for r in (r0, r1, radius) if r > 0.0)
        raise ToolpathError(
            f"an arc's start, end and radius do not lie on one circle (radii {said} mm)",
            hint="a point before it is missing, or the centre is wrong; output the path again",
            line=line,
        )
    rise = float((end - start) @ axis)
    points = sample_arc(start, end, center, axis, rise, turns, m.chord, m.angle)
    m.begin_curve(rapid)
    same = float(np.max(np.abs(tool - m.position_axis))) < 1e-9
    if not rapid and same and abs(rise) <= mm_to_m(_FLAT_MM) and turns == 0:
        lifted = center + axis * float((start - center) @ axis)
        m.builder.arc(points, lifted, axis, r0, arc_angle(start, end, center, axis), tool, feed, line)
    else:
        share = (np.arange(len(points)) + 1.0)[:, None] / len(points)
        tools = m.position_axis + share * (tool - m.position_axis)
        length = np.linalg.norm(tools, axis=1, keepdims=True)
        if length.min() < 1e-6:
            raise ToolpathError(
                "the tool turns upside down along an arc, and which way is not said",
                hint="output points between",
                line=line,
            )
        m.builder.points(points, tools / length, feed, Move.RAPID if rapid else Move.CUT, line)
    m.position, m.position_axis, m.position_line = end, tool, line


def indirv(m: Machine, s: Statement) -> None:
    """CATIA: the direction in which the following TLON,GOFWD leaves its start."""
    if len(s.numbers) != 3:
        raise ToolpathError("INDIRV needs three numbers", hint="output it again", line=s.line)
    m.direction = m.part_R_cl @ np.array(s.numbers)


def tlon(m: Machine, s: Statement) -> None:
    """CATIA: along a circle in the plane across the tool, as INDIRV points, to the end of the line from its centre."""
    match = _TLON.search(s.text)
    fields = [] if match is None else [number_of(t.strip()) for t in f"{match[1]},{match[2]}".split(",") if t.strip()]
    numbers = [f for f in fields if f is not None]
    if len(fields) != 10 or len(numbers) != 10 or m.direction is None:
        raise ToolpathError(
            "TLON,GOFWD is known only as (CIRCLE/x,y,z,r),ON,(LINE/...) after INDIRV",
            hint="switch circular output off in the CAM system",
            line=s.line,
        )
    start = _start(m, s.line)
    center, end = m.to_part(np.array(numbers[:3])), m.to_part(np.array(numbers[7:]))
    normal = m.position_axis
    ahead = float(np.cross(normal, start - center) @ m.direction)
    arc_to(m, end, center, normal if ahead > 0.0 else -normal, 0, normal, s.line, numbers[3] * m.scale)
    m.direction = None


class Nurbs:
    """One NX NURBS block: KNOT and CNTRL statements gather in it until another word comes."""

    __slots__ = ("control", "knots", "line")

    def __init__(self, line: int) -> None:
        self.line = line
        self.control: list[float] = []
        self.knots: list[float] = []

    def add(self, s: Statement) -> None:
        """A KNOT or CNTRL statement."""
        if s.words or not s.numbers:
            raise ToolpathError(f"{s.word}/ holds something else than numbers", hint="output it again", line=s.line)
        if s.word == "KNOT":
            self.knots += s.numbers
        elif len(s.numbers) % 3:
            raise ToolpathError(
                "CNTRL needs three numbers a point (weights are not known)",
                hint="export the curve without weights, or as GOTO",
                line=s.line,
            )
        else:
            self.control += s.numbers

    def finish(self, m: Machine) -> None:
        """The curve as cutting points from where the tool is; its end is the last control point."""
        if m.position is None or not self.control:
            raise ToolpathError("a NURBS has no start or no control points", hint="output it again", line=self.line)
        if m.settle is not None:
            m.settle(self.line)
        control = m.to_part(np.array(self.control).reshape(-1, 3))
        if float(np.linalg.norm(control[0] - m.position)) > mm_to_m(_FLAT_MM):
            control = np.vstack([m.position, control])
        try:
            curve = clamped_spline(control, np.array(self.knots))
        except ToolpathError as error:
            raise ToolpathError(error.what, hint=error.hint, line=self.line) from None
        points = sample_spline(curve, m.chord, m.angle)
        feed = m.cut_feed(self.line)
        m.begin_curve(False)
        m.builder.points(points, m.position_axis, feed, Move.CUT, self.line)
        m.position, m.position_line = points[-1], self.line
