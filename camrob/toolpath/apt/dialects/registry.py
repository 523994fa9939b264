"""The dialects of CL text that camrob reads: a new one is a file and a line here."""

from __future__ import annotations

from camrob.errors import ToolpathError
from camrob.toolpath.apt.dialects.camplete import CAMPLETE
from camrob.toolpath.apt.dialects.camworks import CAMWORKS, CAMWORKS_CLT
from camrob.toolpath.apt.dialects.catia import CATIA
from camrob.toolpath.apt.dialects.creo import CREO
from camrob.toolpath.apt.dialects.dialect import Dialect
from camrob.toolpath.apt.dialects.freecad import FREECAD
from camrob.toolpath.apt.dialects.fusion import FUSION
from camrob.toolpath.apt.dialects.makino import MAKINO
from camrob.toolpath.apt.dialects.mori import MORI
from camrob.toolpath.apt.dialects.nx import NX
from camrob.toolpath.apt.dialects.plain_apt import APT

__all__ = ["DIALECTS", "choose_dialect"]

DIALECTS: dict[str, Dialect] = {
    d.name: d for d in (NX, CREO, CATIA, CAMWORKS, CAMWORKS_CLT, FREECAD, FUSION, CAMPLETE, MORI, MAKINO, APT)
}


def choose_dialect(head: str, forced: str | None = None) -> Dialect:
    """The dialect named `forced`, or the one that the beginning of the file scores highest for.

    Raises ToolpathError for an unknown name, or for a text that is no CL data of any dialect.
    """
    if forced is not None:
        if forced not in DIALECTS:
            raise ToolpathError(f"there is no dialect {forced!r}", hint="choose one of " + ", ".join(DIALECTS))
        return DIALECTS[forced]
    best = max(DIALECTS.values(), key=lambda d: d.recognise(head))
    if best.recognise(head) == 0:
        raise ToolpathError(
            "this is not CL data of a kind that camrob knows",
            hint="output CL data as text (NX: CLSF; Creo: ncl; CATIA: aptsource; others: APT); if it is, name its dialect: "
            + ", ".join(DIALECTS),
        )
    return best
