"""Autodesk's posts for CAMplete TruePath and for MANUSpost: each operation's points lie in the frame that its MCS/ prints."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError
from camrob.toolpath.apt.coordinates import set_operation_frame
from camrob.toolpath.apt.curves import arc_of, turned_by
from camrob.toolpath.apt.cycles import Cycle, cycle_fields, keyed_cycle
from camrob.toolpath.apt.dialects.dialect import Dialect, score
from camrob.toolpath.apt.dialects.fusion import milling, nothing, quoted_message
from camrob.toolpath.apt.lexer import Statement
from camrob.toolpath.apt.state import Machine

__all__ = ["CAMPLETE"]

_NEAR = 0.5  # degrees: between the sweep that CIRCLE names and the arc's own
_SAME = 1e-6  # of two prints of one rotation


def _recognise(head: str) -> int:
    return score(head, {r"^MCS/": 20, r"^MCS2/": 10, r"^CSI_TOOL_PATH/": 10, r"^PARTNO/ ?'": 4, r"^PPRINT/ ?'": 4})


def _cycle(s: Statement) -> Cycle:
    """FEDTO or DEPTH into the part, RAPTO, and RTRCTO out of it, from the GOTO's point, which is the hole's top.

    CLEAR is a height in the frame of the points; it counts where no RTRCTO stands. What RETURN counts from depends on the post.
    """
    name, fields, loose = cycle_fields(s.args)
    if name == "RIGID" and "PITCH" in fields:
        name, fields["PERREV"] = "TAP", fields.pop("PITCH")
    height = fields.pop("CLEAR", None)
    fields.pop("RETURN", None)
    if "RTRCTO" not in fields and height is None:
        hint = "output it again, or its moves as GOTO"
        raise ToolpathError(f"cycle {name} names no height to go back to", hint=hint, line=s.line)
    cycle = keyed_cycle(name, fields, fields.get("FEDTO", fields.get("DEPTH")), s.line, loose)
    return cycle if "RTRCTO" in fields else replace(cycle, height=height)


def _mcs(m: Machine, s: Statement) -> None:
    """MCS/: axes and origin of the frame of the points, in the part's."""
    if len(s.numbers) != 12:
        raise ToolpathError(f"MCS has {len(s.numbers)} numbers, not 12", hint="output it again", line=s.line)
    rows = np.array(s.numbers).reshape(4, 3)
    set_operation_frame(m, rows[:3].T, rows[3], s.line)


def _mcs2(m: Machine, s: Statement) -> None:
    """MCS2/ says the axes of MCS/ once more."""
    if len(s.numbers) != 9 or np.max(np.abs(np.array(s.numbers).reshape(3, 3).T - m.part_R_cl)) > _SAME:
        raise ToolpathError("MCS2 names other axes than MCS", hint="output it again", line=s.line)


def _circle(m: Machine, s: Statement) -> None:
    """CIRCLE/centre, axis, radius, sweep, 0, 0, 0: left-handed about its axis; the sweep says the same once more."""
    if len(s.numbers) != 11:
        raise ToolpathError("CIRCLE without centre, axis, radius and sweep", hint="output it again", line=s.line)
    along, center = arc_of(m, s), m.to_part(np.array(s.numbers[:3]))
    normal = m.handed * m.part_R_cl @ np.array(s.numbers[3:6])

    def arc(end: NDArray[np.float64], tool: NDArray[np.float64], line: int) -> None:
        turned = turned_by(m, end, center, -normal / np.linalg.norm(normal), line)
        if abs(math.remainder(turned - s.numbers[7], 360.0)) > _NEAR:
            what = f"CIRCLE names a sweep of {s.numbers[7]:g} degrees, and to its end the arc turns {turned:.3f}"
            raise ToolpathError(what, hint="output the arcs as lines", line=s.line)
        along(end, tool, line)

    m.curve = arc


def _zero(m: Machine, s: Statement) -> None:
    """ZERO/n: the work offset."""
    m.take_work_offset("ZERO", s.numbers[0] if len(s.numbers) == 1 else None, s.line)


CAMPLETE = Dialect(
    "camplete-apt",
    _recognise,
    _cycle,
    quoted_message,
    left_handed_arcs=True,
    must_end=True,
    contour_behind_cutcom=True,
    words={
        "MCS": _mcs,
        "MCS2": _mcs2,
        "CIRCLE": _circle,
        "MODE": milling,
        "ZERO": _zero,
        "CSI_TOOL_PATH": lambda m, s: m.announce(s.text),
        **dict.fromkeys(("START", "OPERATION", "CSI_PATH_TOLERANCE"), nothing),
    },
)
