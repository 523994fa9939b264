"""The dialects of CL text that camrob reads: a new one is a file and a line here."""

from __future__ import annotations

from camrob.errors import ToolpathError
from camrob.toolpath.dialect import Dialect
from camrob.toolpath.dialect_apt import APT
from camrob.toolpath.dialect_camworks import CAMWORKS, CAMWORKS_CLT
from camrob.toolpath.dialect_catia import CATIA
from camrob.toolpath.dialect_creo import CREO
from camrob.toolpath.dialect_makino import MAKINO
from camrob.toolpath.dialect_nx import NX

__all__ = ["DIALECTS", "choose_dialect"]

DIALECTS: dict[str, Dialect] = {d.name: d for d in (NX, CREO, CATIA, CAMWORKS, CAMWORKS_CLT, MAKINO, APT)}


def choose_dialect(head: str, forced: str | None = None) -> Dialect:
    """The dialect named `forced`, or the one that the beginning of the file scores highest for.

    Raises ToolpathError for an unknown name, or for a text that is no CL data of any dialect.
    """
    if forced is not None:
        if forced not in DIALECTS:
            raise ToolpathError(f"there is no dialect {forced!r}", cure="choose one of " + ", ".join(DIALECTS))
        return DIALECTS[forced]
    best = max(DIALECTS.values(), key=lambda d: d.recognise(head))
    if best.recognise(head) == 0:
        raise ToolpathError(
            "this is no CL data of a kind that camrob knows",
            cure="give a CL file, or force a dialect: " + ", ".join(DIALECTS),
        )
    return best
