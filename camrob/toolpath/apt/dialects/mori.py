"""Autodesk's post for DMG MORI's MfgSuite ("Mori APT"): each operation's points lie in the frame that its MCSYS/ prints."""

from __future__ import annotations

import numpy as np

from camrob.errors import ToolpathError
from camrob.toolpath.apt.coordinates import by_two, set_operation_frame
from camrob.toolpath.apt.curves import circle
from camrob.toolpath.apt.dialects.dialect import Dialect, score
from camrob.toolpath.apt.dialects.fusion import milling, nothing, quoted_message, unclear_cycle
from camrob.toolpath.apt.lexer import Statement
from camrob.toolpath.apt.state import Machine

__all__ = ["MORI"]

_MCSYS = ("NUM", 1, "POINT", 3, "VECTOR", 3, "VECTOR", 3)  # its words, and how many numbers stand behind each
_MOVARC = ("CENTER", 3, "AXIS", 3, "RADIUS", 1)


def _recognise(head: str) -> int:
    return score(head, {r"^MCSYS/ ?NUM": 20, r"^APPLY/ ?(MILL|TURN)": 10, r"^MATERL/": 5, r"^OPNAME/": 5})


def _keyed(s: Statement, form: tuple[str | int, ...]) -> list[float]:
    """The numbers of a statement of this form. Raises ToolpathError for another."""
    want = [kind for w, n in zip(form[::2], form[1::2], strict=True) for kind in (w, *[float] * int(n))]
    fits = len(s.args) == len(want) and all(
        arg == kind if isinstance(kind, str) else isinstance(arg, float) for arg, kind in zip(s.args, want, strict=True)
    )
    if not fits:
        words = ", ".join(w for w in form if isinstance(w, str))
        raise ToolpathError(f"{s.word} in another form than {words}", hint="output it again", line=s.line)
    return s.numbers


def _mcsys(m: Machine, s: Statement) -> None:
    """MCSYS/NUM, n, POINT, origin, VECTOR, x, VECTOR, y: the frame of the points, in the part's; n is the work offset."""
    number, *v = _keyed(s, _MCSYS)
    m.take_work_offset("MCSYS", number, s.line)
    set_operation_frame(m, by_two(np.array(v[3:6]), np.array(v[6:9])), np.array(v[:3]), s.line)


def _movarc(m: Machine, s: Statement) -> None:
    """MOVARC/CENTER, ..., AXIS, ..., RADIUS, r: an arc to the next GOTO, right-handed about its axis, less than one turn."""
    v = _keyed(s, _MOVARC)
    circle(m, Statement("CIRCLE", ",".join(map(repr, v)), s.line))


MORI = Dialect(
    "mori-apt",
    _recognise,
    unclear_cycle,
    quoted_message,
    must_end=False,
    contour_behind_cutcom=True,
    words={
        "MCSYS": _mcsys,
        "MOVARC": _movarc,
        "MODE": milling,
        "APPLY": milling,
        "OPNAME": lambda m, s: m.announce(s.text.strip().strip("'")),
        **dict.fromkeys(
            ("BEGIN", "MATERL", "CLAMP", "TCP", "ARCSLP"), nothing
        ),  # stock, clamps, tool centre point; the rise that an arc's end has anyway
    },
)
