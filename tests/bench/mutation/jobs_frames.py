"""Jobs whose programs set frames of their own (Fanuc's, Siemens', Heidenhain's, TRANS of CL data), and CYCLE83 in bites."""

from __future__ import annotations

from mutation.jobs import PLACE, Job
from mutation.story import Story


def jobs() -> list[Job]:
    """All jobs of this file."""
    return [_fanuc(), _scaled(), _siemens(), _klartext(), _staying(), _trans(), _bites(), *_refused()]


def _begun(tool: int = 1) -> Story:
    return Story().event("change", tool).event("cw", 5000)


def _fanuc() -> Job:
    text = (
        "%\nO7\nG21 G90 G17 G94\nT1 M6\nS5000 M3\nG0 X0. Y0. Z30.\nG68 X10. Y5. R90.\nG0 X14. Y5. Z30.\nG1 Z-1. F500.\n"
        "G3 X10. Y9. I-4.\nG69\nG1 X0. Y0.\nG51.1 X10.\nG1 X6. Y0.\nG3 X2. Y4. I-4.\nG50.1 X0.\nG1 X0. Y0.\n"
        "G68 R-90.\nG1 X3. Y0.\nG99 G81 X9. Y0. Z-3. R2. F120.\nG80\nG69\nG0 X0. Y0. Z30.\nM5\nM30\n%\n"
    ).replace("G99 G81", "G0 Z10.\nG99 G81")
    story = _begun().rapid(0, 0, 30).rapid(10, 9, 30).cut(500, 10, 9, -1).arc(500, (10, 5, -1), (0, 0, 1), 90)
    story.cut(500, 0, 0, -1).cut(500, 14, 0, -1).arc(500, (18, 0, -1), (0, 0, 1), -90)
    story.cut(500, 0, 0, -1).cut(500, 0, -3, -1).rapid(0, -3, 10).rapid(0, -9, 10).rapid(0, -9, 2)
    story.cut(120, 0, -9, -3).rapid(0, -9, 2).rapid(0, 0, 30).event("off")
    return Job("gc-frames", "frames.nc", text, story)


def _scaled() -> Job:
    text = (
        "%\nO8\nG21 G90 G17 G94\nT1 M6\nS5000 M3\nG0 X10. Y0. Z30.\nG51 X10. Y0. Z0. P2.\nG0 X12. Y1. Z15.\nG1 Z-1. F500.\n"
        "G2 X14. Y-1. R2.\nG50\nG1 X0. Y0. Z0.\nG0 X0. Y0. Z30.\nM5\nM30\n%\n"
    )
    story = _begun().rapid(10, 0, 30).rapid(14, 2, 30).cut(500, 14, 2, -2).arc(500, (14, -2, -2), (0, 0, 1), -90)
    return Job("gc-scaled", "scaled.nc", text, story.cut(500, 0, 0, 0).rapid(0, 0, 30).event("off"))


def _siemens() -> Job:
    text = (
        "%_N_FR_MPF\nN10 G90 G17 G71 G94\nT1 M6\nS5000 M3\nG0 X0 Y0 Z30\nF500\nTRANS X20 Z1\nAMIRROR X0\nG0 X5 Y0\nG1 Z-1\n"
        "G3 X0 Y5 I-5 J0\nROT RPL=30\nATRANS X2\nG1 X3 Y0 Z0\nMIRROR Y0\nASCALE X2 Y2 Z2\nX3 Y4 Z0\nG3 X1 Y4 I-1 J0\nSCALE\n"
        'G1 X1 Y1\nG0 Z60\nCYCLE800(0,"T",100000,57,20,0,30,0,20,0,0,0,0,-1)\nATRANS X2\nAROT RPL=90\nG0 X0 Y0 Z20\nG1 Z0\n'
        "X4 Y0\nX=IC(1) Y=IC(1)\nG0 Z30\nATRANS X0\nM5\nM30\n"
    )
    root = 0.75**0.5
    story = _begun().rapid(0, 0, 30).rapid(15, 0, 30).cut(500, 15, 0, 0).arc(500, (20, 0, 0), (0, 0, 1), -90)
    story.cut(500, 5 * root, 2.5, 0).cut(500, 6, -8, 0).arc(500, (4, -8, 0), (0, 0, 1), -180)
    story.cut(500, 1, 1, 0).rapid(1, 1, 60)
    story.use((20, 0, 30, 0, 20, 0)).rapid(2, 0, 20, axis=(0, 0, 1)).cut(500, 2, 0, 0).cut(500, 2, 4, 0)
    return Job("sie-frames", "frames.mpf", text, story.cut(500, 1, 5, 0).rapid(1, 5, 30).event("off"))


def _klartext() -> Job:
    text = (
        "0 BEGIN PGM FR MM\n1 TOOL CALL 1 Z S5000 F500\n2 L X+0 Y+0 Z+30 R0 FMAX M3\n3 CYCL DEF 7.0\n4 CYCL DEF 7.1 X+20\n"
        "5 CYCL DEF 7.2 Y+10\n6 CYCL DEF 8.0\n7 CYCL DEF 8.1 X\n8 L X+5 Y+0 FMAX\n9 L Z-1\n10 CC X+0 Y+0\n11 C X+0 Y+5 DR+\n"
        "12 CYCL DEF 8.0\n13 CYCL DEF 8.1\n14 CYCL DEF 10.0\n15 CYCL DEF 10.1 ROT+90\n16 L X+8 Y+0\n17 CYCL DEF 10.1 IROT+90\n"
        "18 L X+5 Y+0\n19 CYCL DEF 10.1 ROT+0\n20 CYCL DEF 7.1 X+0\n21 CYCL DEF 7.2 Y+0\n22 L X+1 Y+2\n23 L Z+30 FMAX\n"
        "24 M5\n25 M30\n26 END PGM FR MM\n"
    )
    story = _begun().rapid(0, 0, 30).rapid(15, 10, 30).cut(500, 15, 10, -1).arc(500, (20, 10, -1), (0, 0, 1), -90)
    story.cut(500, 20, 18, -1).cut(500, 15, 10, -1).cut(500, 1, 2, -1).rapid(1, 2, 30)
    return Job("hh-frames", "frames.h", text, story.event("off"))


def _staying() -> Job:
    text = (
        "0 BEGIN PGM ST MM\n1 TOOL CALL 1 Z S5000\n2 CYCL DEF 247 Q339=1\n3 L X+0 Y+0 Z+60 R0 FMAX M3\n4 CYCL DEF 7.0\n"
        "5 CYCL DEF 7.1 X+20\n6 CYCL DEF 7.2 Z+30\n7 PLANE SPATIAL SPA+0 SPB+20 SPC+0 STAY\n8 L B+Q121 C+Q122 FMAX\n"
        "9 L X+0 Y+0 Z+30 FMAX\n10 L Z+0 F300\n11 L X+10\n12 L Z+30 FMAX\n13 PLANE RESET STAY\n14 L Z-1 FMAX M91\n"
        "15 L B+0 C+0 FMAX\n16 CYCL DEF 7.0\n17 CYCL DEF 7.1 X+0\n18 CYCL DEF 7.2 Z+0\n19 CYCL DEF 247 Q339=1\n"
        "20 L X+0 Y+10 Z+60 FMAX\n21 L Z+40 F300\n22 L X+5\n23 L Z+60 FMAX\n24 M5\n25 M30\n26 END PGM ST MM\n"
    )
    story = _begun().rapid(0, 0, 60).use((20, 0, 30, 0, 20, 0)).rapid(0, 0, 30, axis=(0, 0, 1)).cut(300, 0, 0, 0)
    story.cut(300, 10, 0, 0).rapid(10, 0, 30).use().rapid(0, 10, 60, axis=(0, 0, 1)).cut(300, 0, 10, 40)
    return Job("hh-staying", "staying.h", text, story.cut(300, 5, 10, 40).rapid(5, 10, 60).event("off"))


def _trans() -> Job:
    text = (
        "PARTNO TR\nUNITS/MM\nLOADTL/1\nSPINDL/5000,RPM,CLW\nRAPID\nGOTO/0,0,30\nFEDRAT/300,MMPM\nGOTO/0,0,0\nGOTO/5,2,0\nRAPID\n"
        "GOTO/5,2,30\nTRANS/10,-4,1\nRAPID\nGOTO/0,0,30\nGOTO/0,0,0\nGOTO/5,2,0\nRAPID\nGOTO/5,2,30\nTRANS/OFF\nRAPID\n"
        "GOTO/0,0,40\nSPINDL/OFF\nFINI\n"
    )
    story = _begun().rapid(0, 0, 30).cut(300, 0, 0, 0).cut(300, 5, 2, 0).rapid(5, 2, 30).rapid(10, -4, 31)
    story.cut(300, 10, -4, 1).cut(300, 15, -2, 1).rapid(15, -2, 31).rapid(0, 0, 40)
    return Job("apt-trans", "trans.apt", text, story.event("off"))


def _bites() -> Job:
    """Bites that are alike: back in to 0.6 mm above the last one, as nothing else is said."""
    text = (
        "%_N_BITES_MPF\nN10 G90 G17 G71 G94\nT1 M6\nS5000 M3\nG0 X5 Y0 Z30\nF120\nCYCLE83(20,0,2,-8,,-3,,0,0,0,1,1)\n"
        "G0 Z30\nM5\nM30\n"
    )
    story = _begun().rapid(5, 0, 30).rapid(5, 0, 2)
    for above, low in ((2.0, -3), (-2.4, -6), (-5.4, -8)):
        story.rapid(5, 0, above).cut(120, 5, 0, low, open=0.0 if above > 0 else 0.6).rapid(5, 0, 2)
    return Job("sie-bites", "bites.mpf", text, story.rapid(5, 0, 20).rapid(5, 0, 30).event("off"))


def _refused() -> list[Job]:
    """Programs of which none may come."""
    head = "%\nO9\nG21 G90 G17\nT1 M6\nS6000 M3\nG0 X0. Y0. Z40.\nG1 Z0. F300.\n"
    ends = "G0 X0. Y0. Z40.\nM5\nM30\n%\n"
    klartext = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S6000\n2 L X+0 Y+0 Z+40 R0 FMAX M3\n3 L Z+0 F300\n"
    last = "20 L X+1 Y+1 Z+40 FMAX\n21 M5\n22 M30\n23 END PGM A MM\n"
    cl = "PARTNO TR\nUNITS/MM\nLOADTL/1\nSPINDL/5000,RPM,CLW\nFEDRAT/300,MMPM\n"
    up = "RAPID\nGOTO/0,0,30\nFINI\n"
    down = "RAPID\nGOTO/0,0,30\nGOTO/0,0,0\n"
    rows = [
        ("g68-alone", "never.nc", head + "G68 X0. Y0. R30.\nG1 X10.\nG69\n" + ends),
        ("g68-g91", "never.nc", head + "G68 X0. Y0. R30.\nG91 G1 X10. Y0.\nG90 G69\n" + ends),
        ("g68-twice", "never.nc", head + "G51.1 X5.\nG68 X0. Y0. R30.\nG1 X10. Y0.\nG69\nG50.1 X0.\n" + ends),
        ("g51-unit", "never.nc", head + "G51 X0. Y0. Z0. P2\nG1 X10. Y0. Z0.\nG50\n" + ends),
        (
            "g51-hole",
            "never.nc",
            head + "G51 X0. Y0. Z0. P2.\nG0 X9. Y0. Z9.\nG99 G81 X9. Y0. Z-3. R2.\nG80\nG50\n" + ends,
        ),
        ("hh-both", "never.h", klartext + "4 CYCL DEF 8.1 X\n5 CYCL DEF 10.1 ROT+30\n6 L X+9 Y+1\n" + last),
        ("hh-alone", "never.h", klartext + "4 CYCL DEF 10.1 ROT+30\n6 L X+9\n" + last),
        ("hh-scale", "never.h", klartext + "4 CYCL DEF 11.1 SCL 0.5\n6 L X+9 Y+1\n" + last),
        ("hh-preset", "never.h", klartext + "4 CYCL DEF 247 Q339=2\n6 L X+9 Y+1\n" + last),
        (
            "apt-trans-first",
            "never.apt",
            cl + "TRANS/1,2,3\nRAPID\nGOTO/0,0,30\nGOTO/0,0,0\nRAPID\nGOTO/0,0,30\nFINI\n",
        ),
        ("apt-trans-twice", "never.apt", cl + down + "TRANS/1,2,3\n" + down + "TRANS/1,0,0\n" + down + up),
    ]
    return [Job(f"no-{name}", file, text, setup=PLACE, refuse=True) for name, file, text in rows]
