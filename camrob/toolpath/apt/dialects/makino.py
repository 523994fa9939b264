"""Makino FF/CAM: APT-CL whose PPRINT texts tell where each section begins and ends."""

from __future__ import annotations

from camrob.toolpath.apt.dialects.dialect import Dialect, score
from camrob.toolpath.apt.dialects.plain_apt import apt_cycle

__all__ = ["MAKINO"]

_STRUCTURE = ("APTCL-SPEC", "TOOL-POSITION", "END-SECTION", "PART-LEAST", "MOTION", "STEP", "ESCAPE-HEIGHT")


def _recognise(head: str) -> int:
    return score(head, {r"^PPRINT/APTCL-SPEC,MAKINO": 30, r"^PPRINT/BEGIN-SECTION,": 6, r"^PPRINT/MOTION,": 4})


def _pprint(text: str) -> tuple[str, str] | None:
    head, _, tail = text.partition(",")
    if head.strip() == "BEGIN-SECTION":
        return ("operation", "machining") if tail.strip() == "MACHINING" else None
    return None if head.strip() in _STRUCTURE else ("message", text)


MAKINO = Dialect("makino-cldata", _recognise, apt_cycle, _pprint, left_handed_arcs=True)
