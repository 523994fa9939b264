"""Jobs of Heidenhain's M99 wherever it stands and its feeds, Siemens' fixed points, a first move without G0, CATIA's lathes."""

from __future__ import annotations

import math

from mutation.jobs import PLACE, Job
from mutation.story import Story


def jobs() -> list[Job]:
    """All jobs of this file."""
    return [_called(), _fixed(), _first(), *_refused()]


_KLARTEXT = "0 BEGIN PGM M MM\n1 TOOL CALL 1 Z S2000 F400\n2 L X+0 Y+0 Z+30 R0 FMAX M3\n"
_REAM = "CYCL DEF 201 REAM Q200=2 Q201=-4 Q206=FAUTO Q211=0 Q208=FMAX Q203=+0 Q204=20\n"
_END = "L Z+30 FMAX\nM5\nM30\nEND PGM M MM\n"


def _begun(speed: float = 5000) -> Story:
    return Story().event("change", 1).event("cw", speed)


def _called() -> Job:
    """Holes behind a polar block, behind an arc and by M99 alone; FU0.1 at 2000 rev/min are 200 mm/min."""
    text = _KLARTEXT + _REAM + (
        "CC X+0 Y+0\nLP PR+10 PA+0 FMAX M99\nL Z+2 FMAX\nC X+0 Y+10 DR+ FU0.1 M99\nL X-10 Y+0 FMAX\nM99\nL Z+1 F AUTO\nL X-15\n"
    ) + _END  # fmt: skip
    story = _begun(2000).rapid(0, 0, 30).rapid(10, 0, 30)
    hole = lambda x, y, to: story.rapid(x, y, 2).cut(400, x, y, -4).rapid(x, y, 2).rapid(x, y, to)  # noqa: E731
    hole(10, 0, 20)
    story.rapid(10, 0, 2).arc(200, (0, 0, 2), (0, 0, 1), 90)
    hole(0, 10, 20)
    story.rapid(-10, 0, 20)
    hole(-10, 0, 20)
    story.cut(400, -10, 0, 1).cut(400, -15, 0, 1).rapid(-15, 0, 30)
    return Job("hh-called", "m.h", text, story.event("off"))


def _fixed() -> Job:
    """G74, G75: in rapid to the machine's own places; the swivel of 30 about X ends by CYCLE800 alone."""
    text = (
        'N10 G90 G17 G710 G94\nG75 Z0 FP=1\nT1 M6\nS5000 M3\nCYCLE800(1,"T",0,57,5,0,0,30,0,0,0,0,0,-1)\nG0 X0 Y0 Z30\n'
        "G1 Z-2 F300\nX4\nG0 Z60\nCYCLE800\nG74 Z1=0\nG0 A0 C0\nG0 X1 Y2 Z60\nG1 Z3\nX9\nG75 POS=1 Z1=0\nM5\nM30\n"
    )
    s, c = math.sin(math.radians(30.0)), math.cos(math.radians(30.0))
    tilted = (0.0, -s, c)

    def place(x: float, z: float) -> tuple[float, float, float]:
        return 5.0 + x, -s * z, c * z

    story = _begun().rapid(*place(0, 30), axis=tilted).cut(300, *place(0, -2), axis=tilted)
    story.cut(300, *place(4, -2), axis=tilted).rapid(*place(4, 60), axis=tilted)
    story.rapid(1, 2, 60, axis=(0, 0, 1)).cut(300, 1, 2, 3).cut(300, 9, 2, 3)
    return Job("sie-fixed", "fixed.mpf", text, story.event("off"))


def _first() -> Job:
    text = (
        "O1\nG21 G17 G40 G49 G80 G90 G94\nT1 M6\nS3000 M3\nG43 H1 Z30.\nG0 X0 Y0\nG1 Z-1. F200\nX7.\nG0 Z30.\nM5\nM30\n"
    )
    story = _begun(3000).rapid(0, 0, 30).cut(200, 0, 0, -1).cut(200, 7, 0, -1).rapid(7, 0, 30)
    return Job("gc-first", "first.nc", text, story.event("off"))


def _refused() -> list[Job]:
    """Programs of which none may come."""
    lathe = "FEDRAT/ 400.0,MMPM\nSPINDL/ 2000.0,RPM,CLW\nRAPID\nGOTO / 30, 0, 45\nGOTO / 28, 0, 2\nFINI\n"
    siemens = "N10 G90 G17 G710 G94\nT1 M6\nS5000 M3\nG0 X0 Y0 Z30\nG1 Z0 F300\n"
    iso = "O1\nG21 G17 G40 G49 G80 G90 G94\nT1 M6\nS3000 M3 F200.\nG43 H1 Z30.\nX0 Y0\nG1 Z0\nX5.\nG0 Z30.\nM5\nM30\n"
    rows = [
        ("catia-lathe", "never.aptsource", f"$$ CATIA APT VERSION 1.0\nTOOLNO/1,TURN\nLOADTL/1,1\n{lathe}"),
        ("turn-speed", "never.h", _KLARTEXT + "L Z+0 FU0.1\nTOOL CALL S3000\nL X+5\n" + _END),
        ("tooth-feed", "never.h", _KLARTEXT + "L Z+0 F300\nL X+5 FZ0.05\n" + _END),
        ("call-tooth", "never.h", _KLARTEXT.replace("F400", "FZ0.1") + "L Z+0 F300\nL X+5\n" + _END),
        ("polar-machine", "never.h", _KLARTEXT + "L Z+0 F300\nCC X+0 Y+0\nLP PR+5 PA+0 M91\n" + _END),
        ("polar-modal", "never.h", _KLARTEXT + _REAM + "CC X+0 Y+0\nLP PR+5 PA+0 FMAX M89\nL Z+1 F300\nL X+3\n" + _END),
        ("fixed-then", "never.mpf", siemens + "G75 X0 FP=1\nG1 Y5\nG0 Z30\nM5\nM30\n"),
        ("opening-angle", "never.mpf", siemens + "G2 AR=90 I5 J0\nG0 Z30\nM5\nM30\n"),
        ("first-with-feed", "never.nc", iso),
    ]
    return [Job(f"no-{name}", file, text, setup=PLACE, refuse=True) for name, file, text in rows]
