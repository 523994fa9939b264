"""FreeCAD: CL data by `examples/freecad/camrob_post.py`."""

from __future__ import annotations

from camrob.toolpath.apt.dialects.dialect import Dialect, message, score
from camrob.toolpath.apt.dialects.plain_apt import apt_cycle

__all__ = ["FREECAD"]


def _recognise(head: str) -> int:
    return score(head, {r"^\$\$ CL data of FreeCAD, written by camrob_post": 40})


FREECAD = Dialect("freecad-apt", _recognise, apt_cycle, message, must_end=True)
