"""CL files by hand: how the dialects begin, and what the witness's reader made of one, to be compared."""

from __future__ import annotations

from camrob.witness.happenings import Story

__all__ = ["CAMWORKS", "CATIA", "CLT", "CREO", "MAKINO", "NX", "happened", "mm", "ways"]

NX = "TOOL PATH/A,TOOL,T\nMSYS/0,0,0,1,0,0,0,1,0\n"
CREO = "$$*  Pro/CLfile Version 8.0\n"
CATIA = "$$     CATIA APT VERSION 1.0\n"
CAMWORKS = "CSI_SET_FLUTE_LENGTH/8.\n"
CLT = "OPFEATSTART/A\n"
MAKINO = "PPRINT/APTCL-SPEC,MAKINO-FF,1\n"


def mm(story: Story) -> list[list[float]]:
    return (story.path.tip * 1000.0).round(6).tolist()


def ways(story: Story) -> str:
    return "".join("RFH"[w] for w in story.way)


def happened(story: Story) -> list[tuple]:
    return [(e.before, e.kind.name, round(e.value, 6), e.text) for e in story.events]
