"""Autodesk's posts for APT ("Common ISO 4343 APT", "Generative Machining APT", of Fusion, HSM and Inventor)."""

from __future__ import annotations

import math
import re

import numpy as np

from camrob.errors import ToolpathError
from camrob.toolpath.apt.curves import arc_of, turned_by
from camrob.toolpath.apt.cycles import Cycle
from camrob.toolpath.apt.dialects.dialect import Dialect, score
from camrob.toolpath.apt.lexer import Statement
from camrob.toolpath.apt.state import Machine

__all__ = ["FUSION", "milling", "nothing", "quoted_message", "unclear_cycle"]

_NEAR = 0.5  # degrees: between the angle that MOVARC names and the arc's own


def _recognise(head: str) -> int:
    return score(head, {r"^PARTNO/ ?'": 8, r"^PPRINT/ ?'": 4, r"^MOVARC/": 15, r"^LOADTL/\d+, \d+, [\d.]+, \d+": 8})


def unclear_cycle(statement: Statement) -> Cycle:
    """Raises ToolpathError: what its heights count from differs between editions."""
    raise ToolpathError(
        "CYCLE of Autodesk's APT posts: their GOTO is the hole's bottom or its top, and the clearance a height or a distance,"
        " as the post's edition has it",
        hint="have the drilling written as moves (a post for G-code, or cycles expanded)",
        line=statement.line,
    )


def quoted_message(text: str) -> tuple[str, str] | None:
    """Operator text without the quotes round it."""
    return ("message", text.strip().strip("'"))


def _movarc(m: Machine, s: Statement) -> None:
    """MOVARC/centre, normal, radius, ANGLE, degrees: an arc to the next GOTO, right-handed about its normal.

    Old editions name the plane's normal for both senses: the angle tells them apart, but for half circles.
    """
    if len(s.numbers) != 8 or s.words != ["ANGLE"] or m.curve is not None:
        raise ToolpathError("MOVARC without centre, normal, radius and ANGLE", hint="output it again", line=s.line)
    angle = abs(s.numbers[7])
    signed = all(
        "." in part for part in s.text.split(",")[:6]
    )  # numbers with a point each: the edition that signs them
    plain = Statement("CIRCLE", ",".join(s.text.split(",")[:7]), s.line)
    along, center = arc_of(m, plain), m.to_part(np.array(s.numbers[:3]))
    normal = m.handed * m.part_R_cl @ np.array(s.numbers[3:6])

    def arc(end: np.ndarray, tool: np.ndarray, line: int) -> None:
        turned = turned_by(m, end, center, normal / float(np.linalg.norm(normal)), line)
        other = 360.0 - turned  # degrees of a turn
        half = abs(turned - other) < _NEAR
        if abs(math.remainder(turned - angle, 360.0)) < _NEAR and (signed or not half):
            along(end, tool, line)
            return
        if abs(other - angle) < _NEAR and not half and not signed:
            arc_of(m, Statement("CIRCLE", f"{plain.text},CLW", s.line))(end, tool, line)
            return
        raise ToolpathError(
            "MOVARC whose angle does not say which way round it goes",
            hint="output the arcs as lines, or post with a newer edition of the APT post",
            line=s.line,
        )

    m.curve = arc


def milling(m: Machine, s: Statement) -> None:
    """MODE/ or APPLY/: MILL, or TURN, which is refused."""
    del m
    if re.search(r"\bTURN\b", s.text, re.IGNORECASE):
        raise ToolpathError(
            f"a turning operation ({s.word}/TURN): no part turns against a tool at rest here",
            hint="give the milling operations a CL file of their own",
            line=s.line,
        )


def nothing(m: Machine, s: Statement) -> None:
    """A word of the machine's own that moves nothing."""


FUSION = Dialect(
    "fusion-apt",
    _recognise,
    unclear_cycle,
    quoted_message,
    must_end=True,
    contour_behind_cutcom=True,
    words={"MOVARC": _movarc, "MODE": milling},
)
