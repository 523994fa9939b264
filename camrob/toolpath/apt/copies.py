"""INDEX and COPY: a stretch of a CL file once more, or several times, each shifted or turned on from the one before.

As the CL editor of APT does it (APT-IV, subroutine APT335): COPY/n,TRANSL,x,y,z,m and its kin make m copies beside the stretch
itself, the k-th with the k-th power of the transformation.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError
from camrob.toolpath.apt.coordinates import rigid, set_frame, set_transformed
from camrob.toolpath.apt.lexer import Rows, Statement
from camrob.toolpath.apt.policy import is_off
from camrob.toolpath.apt.state import Machine
from camrob.units import deg_to_rad

__all__ = ["Copies", "Stretch"]

_MOST = 1000  # copies of a stretch: more is a slip
_FRAMES = frozenset(("MSYS", "CSYS", "TRNTYP", "TRACUT", "COPY", "INDEX", "TOOL PATH", "FINI", "END"))
# how many numbers each kind of copy takes (XYROT: an angle; MODIFY: a matrix of three rows)
_NUMBERS = {"SAME": 0, "TRANSL": 3, "XYROT": 1, "MODIFY": 12}


@dataclass(slots=True)
class Stretch:
    """What stands behind an INDEX: runs of GOTO, statements with the RAPID open before them; the axis at its start,
    and whether a COPY has had it.
    """

    axis: NDArray[np.float64]
    copied: bool = False
    items: list[tuple[Rows | Statement, bool]] = field(default_factory=list)


class Copies:
    """The stretches that are open, by their numbers."""

    def __init__(self) -> None:
        self._open: dict[int, Stretch] = {}
        self._again = False  # a copy is being made

    def keep(self, item: Rows | Statement, rapid: bool) -> None:
        """An item behind every INDEX so far."""
        if self._again or not self._open:
            return
        if isinstance(item, Rows):  # the lexer fills its rows again
            item = Rows(item.values.copy(), item.counts.copy(), item.rapids.copy(), item.lines.copy())
        for stretch in self._open.values():
            stretch.items.append((item, rapid))

    def index(self, s: Statement, axis: NDArray[np.float64]) -> None:
        """INDEX/n: a stretch begins. Raises ToolpathError for another form."""
        if len(s.numbers) != 1 or s.words or s.numbers[0] != int(s.numbers[0]):
            raise ToolpathError("INDEX in another form than INDEX/n", hint="output the copies as points", line=s.line)
        self._open[int(s.numbers[0])] = Stretch(axis.copy())

    def run(self, s: Statement, m: Machine, take: Callable[[Statement], None], rows: Callable[[Rows], None]) -> None:
        """COPY: the stretch again, each time shifted or turned on; `take` and `rows` carry its items out."""
        if is_off(s):
            return
        stretch = self._stretch(s)
        turn, shift, count = _transformation(s, m.scale)
        base_R, base_p = m.part_R_cl, m.part_p_cl
        R, p = np.eye(3), np.zeros(3)
        self._again = True
        for _ in range(count):
            R, p = turn @ R, turn @ p + shift
            m.axis_raw = stretch.axis
            set_transformed(m, base_R @ R, base_R @ p + base_p, s.line)
            for item, rapid in stretch.items:
                m.rapid = rapid
                if isinstance(item, Statement):
                    take(item)
                else:
                    rows(item)
                    m.rapid = False
        self._again = False
        set_frame(m, base_R, base_p, s.line)

    def _stretch(self, s: Statement) -> Stretch:
        """The stretch of COPY/n. Raises ToolpathError where there is none, or one whose frame changes within it."""
        number = s.args[0] if s.args else ""
        found = self._open.get(int(number)) if isinstance(number, float) else None
        if found is None:
            raise ToolpathError("COPY without its INDEX", hint="output the copies as points", line=s.line)
        if found.copied:
            what = f"COPY/{int(number)} a second time: whether the first copies belong to its stretch nobody says"
            raise ToolpathError(what, hint="output the copies as points", line=s.line)
        found.copied = True
        inner = next((i for i, _ in found.items if isinstance(i, Statement) and i.word in _FRAMES), None)
        if inner is not None:
            raise ToolpathError(f"COPY of a stretch with {inner.word} in it", hint="output its points", line=s.line)
        return found


def _transformation(s: Statement, scale: float) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """What COPY/n,SAME,m | TRANSL,x,y,z,m | XYROT,degrees,m | MODIFY,matrix,m asks for: turn (3, 3), shift (3,) m, copies m.

    Raises ToolpathError for another form.
    """
    kind = s.words[0] if s.words else ""
    numbers = s.numbers[1:]
    if kind == "MIRROR":
        hint = "write the mirror as a matrix: COPY/n,MODIFY,-1,0,0,0, 0,1,0,0, 0,0,1,0, m mirrors X"
        raise ToolpathError("COPY with MIRROR, which APT's own CL editor refuses, too", hint=hint, line=s.line)
    if kind not in _NUMBERS or len(s.words) != 1 or len(numbers) != _NUMBERS[kind] + 1 or s.args[1] != kind:
        hint = "COPY/n,SAME,m or TRANSL,x,y,z,m or XYROT,degrees,m or MODIFY,matrix,m, or output the copies as points"
        raise ToolpathError(f"COPY/{s.text.strip()[:40]} is not read", hint=hint, line=s.line)
    count = numbers[-1]
    if count != int(count) or not 1 <= count <= _MOST:
        raise ToolpathError(f"COPY makes {count:g} copies", hint=f"a whole number up to {_MOST}", line=s.line)
    turn, shift = np.eye(3), np.zeros(3)
    if kind == "TRANSL":
        shift = np.array(numbers[:3]) * scale
    elif kind == "XYROT":
        c, sn = math.cos(deg_to_rad(numbers[0])), math.sin(deg_to_rad(numbers[0]))
        turn = np.array([[c, -sn, 0.0], [sn, c, 0.0], [0.0, 0.0, 1.0]])
    elif kind == "MODIFY":
        rows = np.array(numbers[:12]).reshape(3, 4)
        turn, shift = rigid(rows[:, :3], s.line), rows[:, 3] * scale
    return turn, shift, int(count)
