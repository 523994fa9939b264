"""Jobs in the languages of single controls: Siemens, Heidenhain, Fanuc's macros, LinuxCNC's O words."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from mutation.jobs import PLACE, Job
from mutation.story import Story, Triple


def jobs() -> list[Job]:
    """All jobs of this file."""
    return [
        _siemens_vectors(),
        _siemens_computed(),
        _siemens_words(),
        _siemens_plane(),
        _klartext_lines(),
        _klartext_vectors(),
        _klartext_plane(),
        _klartext_computed(),
        _siemens_holes(),
        _klartext_holes(),
        _macro(),
        _macro_jumps(),
        _o_words(),
        *_refused(),
    ]


def _begun(story: Story, tool: int = 1, speed: float = 5000) -> Story:
    return story.event("change", tool).event("cw", speed)


def _unit(v: Sequence[float]) -> np.ndarray:
    return np.asarray(v, float) / np.linalg.norm(v)


def _between(a: Sequence[float], b: Sequence[float]) -> Callable[[float], Triple]:
    """The great arc from a to b."""
    p, q = _unit(a), _unit(b)
    angle = math.acos(float(np.clip(p @ q, -1.0, 1.0)))

    def at(s: float) -> Triple:
        if angle < 1e-9:
            return tuple(p.tolist())
        v = (math.sin((1 - s) * angle) * p + math.sin(s * angle) * q) / math.sin(angle)
        return tuple(v.tolist())

    return at


def _siemens_vectors() -> Job:
    text = (
        "N10 G90 G17 G710 G94\nN20 T1 M6\nN30 S5000 M3\nN40 TRAORI\nN50 ORIWKS ORIVECT\n"
        "N60 G0 X0 Y0 Z40 A3=0 B3=0 C3=1\nN70 G1 Z0 F500\nN80 X10 Y2 A3=0.1 B3=0.05 C3=1\n"
        "N90 X20 Y0 Z-1 A3=-0.1 B3=0 C3=1 F400\nN100 Y10\nN110 G0 Z40\nN120 TRAFOOF\nN130 M5\nN140 M30\n"
    )
    story = _begun(Story()).rapid(0, 0, 40).cut(500, 0, 0, 0)
    story.swing(500, (10, 2, 0), _between((0, 0, 1), (0.1, 0.05, 1)), slack=0.001)
    story.swing(400, (20, 0, -1), _between((0.1, 0.05, 1), (-0.1, 0, 1)), slack=0.001)
    lean = tuple(_unit((-0.1, 0, 1)).tolist())
    story.cut(400, 20, 10, -1, axis=lean).rapid(20, 10, 40, axis=lean).event("off")
    return Job("sie-vectors", "vectors.mpf", text, story)


def _siemens_computed() -> Job:
    text = (
        "%_N_RING_MPF\nN10 G90 G17 G71 G94\nDEF REAL DEPTH=-1\nDEF INT N\nT1 M6\nS5000 M3\nG0 X10 Y0 Z30\nR1=0 R2=10\n"
        "G1 Z=DEPTH F500\nWHILE R1<3\nR1=R1+1\nG1 X=R2*COS(R1*60) Y=R2*SIN(R1*60)\nENDWHILE\n"
        "FOR N=1 TO 2\nIF N==1\nG1 X=-R2-N*2\nELSE\nG1 Y=5+POT(N)/2\nENDIF\nENDFOR\n"
        "R5=2\nAGAIN: G1 Z=DEPTH-R5/2\nR5=R5-1\nIF R5>0 GOTOB AGAIN\nGOTOF OUT\nG1 X100\nOUT: G0 Z30\nM5\nM30\n"
    )
    story = _begun(Story()).rapid(10, 0, 30).cut(500, 10, 0, -1)
    for k in (1, 2, 3):
        story.cut(500, 10 * math.cos(k * math.pi / 3), 10 * math.sin(k * math.pi / 3), -1)
    story.cut(500, -12, 0, -1).cut(500, -12, 7, -1).cut(500, -12, 7, -2).cut(500, -12, 7, -1.5).rapid(-12, 7, 30)
    return Job("sie-computed", "ring.mpf", text, story.event("off"))


def _siemens_words() -> Job:
    text = (
        "N10 G90 G17 G71 G94 G54\nT1 M6\nS5000 M3\nG0 X0 Y0 Z30\nG1 Z0 F500\nG2 X10 Y10 CR=10\nG3 X20 Y0 I=AC(20) J=AC(10)\n"
        "G1 X=IC(5) Y=IC(-2)\nG3 X25 Y-2 Z-1 I5 J0 TURN=1\nG4 F1.5\nG0 Z30\nTRANS X5 Y-5\nATRANS Z-2\nG0 X0 Y0\nG1 Z1\nG91 X4\n"
        "G90 X=AC(10)\nTRANS\nG0 Z30\nSUPA G0 Z300\nM5\nM30\n"
    )
    story = _begun(Story()).rapid(0, 0, 30).cut(500, 0, 0, 0).arc(500, (10, 0, 0), (0, 0, 1), -90)
    # from (10, 10) left-handedly about (20, 10) to (20, 0): a quarter
    story.arc(500, (20, 10, 0), (0, 0, 1), 90).cut(500, 25, -2, 0)
    story.arc(500, (30, -2, 0), (0, 0, 1), 720, rise=-1, slack=0.02).event("dwell", 1.5).rapid(25, -2, 30)
    story.rapid(5, -5, 30).cut(500, 5, -5, -1).cut(500, 9, -5, -1).cut(500, 15, -5, -1).rapid(15, -5, 30).event("off")
    return Job("sie-words", "words.mpf", text, story, PLACE + "chord_tolerance_mm = 0.02\n")


def _siemens_plane() -> Job:
    text = (
        "N10 G90 G17 G71 G94\nT1 M6\nS5000 M3\nG0 X0 Y0 Z60\nG1 Z40 F500\nX8\nG0 Z60\n"
        'CYCLE800(0,"TC1",100000,57,20,0,30,0,20,0,0,0,0,-1,100,1)\nG0 X0 Y0 Z30\nG1 Z0 F300\nX10\nG0 Z40\n'
        "CYCLE800()\nM5\nM30\n"
    )
    story = _begun(Story()).rapid(0, 0, 60).cut(500, 0, 0, 40).cut(500, 8, 0, 40).rapid(8, 0, 60)
    story.use((20, 0, 30, 0, 20, 0)).rapid(0, 0, 30, axis=(0, 0, 1)).cut(300, 0, 0, 0).cut(300, 10, 0, 0)
    return Job("sie-plane", "plane.mpf", text, story.rapid(10, 0, 40).event("off"))


def _klartext_lines() -> Job:
    text = (
        "0 BEGIN PGM LINES MM\n1 BLK FORM 0.1 Z X-20 Y-20 Z-20\n2 BLK FORM 0.2 X+60 Y+60 Z+0\n3 TOOL CALL 4 Z S5000 F500\n"
        "4 L Z+30 R0 FMAX M3\n5 L X+0 Y+0 FMAX\n6 L Z-1 F200 M8\n7 L X+10 F500\n8 CC X+10 Y+10\n9 C X+20 Y+10 DR+\n"
        "10 L IY+5\n11 CR X+30 Y+25 R+10 DR-\n12 CC X+30 Y+35\n13 CP IPA+450 IZ-1 DR+\n14 LP PR+12 PA+0\n15 L Z+30 FMAX M9\n"
        "16 CYCL DEF 9.0 DWELL TIME\n17 CYCL DEF 9.1 DWELL 0.5\n18 STOP M5\n19 M30\n20 END PGM LINES MM\n"
    )
    story = _begun(Story(), tool=4).rapid(0, 0, 30).event("wet").cut(200, 0, 0, -1).cut(500, 10, 0, -1)
    story.arc(500, (10, 10, -1), (0, 0, 1), 90).cut(500, 20, 15, -1).arc(500, (30, 15, -1), (0, 0, 1), -90)
    story.arc(500, (30, 35, -1), (0, 0, 1), 450, rise=-1, slack=0.02)
    story.cut(500, 42, 35, -2).rapid(42, 35, 30).event("dry").event("dwell", 0.5).event("off").event("halt")
    return Job("hh-lines", "lines.h", text, story, PLACE + "chord_tolerance_mm = 0.02\n")


def _klartext_vectors() -> Job:
    text = (
        "0 BEGIN PGM VEC MM\n1 TOOL CALL 1 Z S5000\n2 M128\n3 L X+0 Y+0 Z+40 FMAX M3\n4 LN X+0 Y+0 Z+0 TX0 TY0 TZ1 F500\n"
        "5 LN X+10 Y+2 Z+0 TX0.0990148 TY0.0495074 TZ0.9938540\n6 LN X+20 Y+0 Z-1 NX0 NY0 NZ1 TX-0.0995037 TY0 TZ0.9950372 F400\n"
        "7 L Z+40 FMAX\n8 M129\n9 M5\n10 M30\n11 END PGM VEC MM\n"
    )
    story = _begun(Story()).rapid(0, 0, 40).cut(500, 0, 0, 0)
    story.swing(500, (10, 2, 0), _between((0, 0, 1), (0.1, 0.05, 1.00377478)), slack=0.001)
    story.swing(400, (20, 0, -1), _between((0.1, 0.05, 1.00377478), (-0.1, 0, 1)), slack=0.001)
    story.rapid(20, 0, 40, axis=tuple(_unit((-0.1, 0, 1)).tolist())).event("off")
    return Job("hh-vectors", "vec.h", text, story)


def _klartext_plane() -> Job:
    text = (
        "0 BEGIN PGM PL MM\n1 TOOL CALL 1 Z S5000\n2 L X+0 Y+0 Z+60 R0 FMAX M3\n3 L Z+40 F500\n4 L X+8\n5 L Z+60 FMAX\n"
        "6 CYCL DEF 7.0 DATUM SHIFT\n7 CYCL DEF 7.1 X+20\n8 CYCL DEF 7.2 Z+30\n"
        "9 PLANE SPATIAL SPA+0 SPB+20 SPC+0 MOVE DIST50 FMAX\n10 L X+0 Y+0 Z+30 FMAX\n11 L Z+0 F300\n12 L X+10\n13 L Z+30 FMAX\n"
        "14 CYCL DEF 200 DRILLING ~\n Q200=2 ~\n Q201=-6 ~\n Q206=120 ~\n Q202=4 ~\n Q210=0 ~\n Q203=+0 ~\n"
        " Q204=20 ~\n Q211=0.2\n15 L X+0 Y+10 FMAX M99\n"
        "16 L Z+40 FMAX\n17 PLANE RESET MOVE FMAX\n18 CYCL DEF 7.0\n19 CYCL DEF 7.1 X+0 Z+0\n20 M5\n"
        "21 M30\n22 END PGM PL MM\n"
    )
    story = _begun(Story()).rapid(0, 0, 60).cut(500, 0, 0, 40).cut(500, 8, 0, 40).rapid(8, 0, 60)
    story.use((20, 0, 30, 0, 20, 0)).rapid(0, 0, 30, axis=(0, 0, 1)).cut(300, 0, 0, 0).cut(300, 10, 0, 0)
    story.rapid(10, 0, 30).rapid(0, 10, 30).rapid(0, 10, 2).cut(120, 0, 10, -4).rapid(0, 10, 2).rapid(0, 10, -2)
    story.cut(120, 0, 10, -6, open=2).event("dwell", 0.2).rapid(0, 10, 20).rapid(0, 10, 40).event("off")
    return Job("hh-plane", "pl.h", text, story)


def _klartext_computed() -> Job:
    text = (
        "0 BEGIN PGM Q MM\n1 TOOL CALL 1 Z S5000\n2 L X+10 Y+0 Z+30 R0 FMAX M3\n3 FN 0: Q1 = +10\n4 Q2 = 60\n5 Q3 = Q1 / 2 - 1\n"
        "6 L Z-1 F500\n7 LBL 1\n8 L X+Q1 Y+Q3\n9 FN 1: Q3 = +Q3 + +2\n10 FN 12: IF +Q3 LT +8 GOTO LBL 1\n"
        "11 CALL LBL 2\n12 LBL 3\n13 L IX+2\n14 CALL LBL 3 REP1\n15 L X+Q1*1\n16 L Z+30 FMAX\n17 M5\n18 M30\n"
        "19 LBL 2\n20 Q4 = Q1 * COS Q2\n21 L X+Q4 Y+9\n22 LBL 0\n23 END PGM Q MM\n"
    ).replace("15 L X+Q1*1\n", "15 Q5 = Q1 * 2\n 16 L X+Q5\n")
    story = _begun(Story()).rapid(10, 0, 30).cut(500, 10, 0, -1).cut(500, 10, 4, -1).cut(500, 10, 6, -1)
    story.cut(500, 5, 9, -1).cut(500, 7, 9, -1).cut(500, 9, 9, -1).cut(500, 20, 9, -1).rapid(20, 9, 30).event("off")
    return Job("hh-computed", "q.h", text, story)


def _siemens_holes() -> Job:
    text = (
        "N10 G90 G17 G71 G94\nT1 M6\nS1500 M3\nG0 X0 Y0 Z30\nF120\nMCALL CYCLE81(20,0,2,-6)\nX5 Y0\nX15\nMCALL\n"
        "CYCLE83(20,0,2,-8,,-4,,1,0,0,1,1,3,1.5)\nG0 X25\nCYCLE85(20,0,2,-3,,0.3,60,90)\nG0 Z30\nM5\nM30\n"
    )
    story = _begun(Story(), speed=1500).rapid(0, 0, 30)
    for x, height in ((5, 30), (15, 20)):
        story.rapid(x, 0, height).rapid(x, 0, 2).cut(120, x, 0, -6).rapid(x, 0, 20)
    story.rapid(15, 0, 2).cut(120, 15, 0, -4, open=8).rapid(15, 0, 2).rapid(15, 0, -3.4).cut(120, 15, 0, -7, open=3.5)
    story.rapid(15, 0, 2).rapid(15, 0, -6.4).cut(120, 15, 0, -8, open=1.5).rapid(15, 0, 20).rapid(25, 0, 20).rapid(
        25, 0, 2
    )
    story.cut(60, 25, 0, -3).event("dwell", 0.3).cut(90, 25, 0, 2).rapid(25, 0, 20).rapid(25, 0, 30).event("off")
    return Job("sie-holes", "holes.mpf", text, story)


def _klartext_holes() -> Job:
    text = (
        "0 BEGIN PGM H MM\n1 TOOL CALL 1 Z S1500\n2 L X+0 Y+0 Z+30 R0 FMAX M3\n"
        "3 CYCL DEF 203 DRILL Q200=2 Q201=-8 Q206=120 Q202=4 Q210=0 Q203=+0 Q204=20 Q212=1 Q213=1 ~\n"
        "Q205=2 Q211=0 Q208=300 Q256=0.5\n"
        "4 L X+5 FMAX M99\n5 CYCL DEF 201 REAM Q200=2 Q201=-3 Q206=60 Q211=0.3 Q208=90 Q203=+0 Q204=20\n6 L X+15 FMAX\n"
        "7 CYCL CALL\n8 L Z+30 FMAX\n9 M5\n10 M30\n11 END PGM H MM\n"
    )
    story = (
        _begun(Story(), speed=1500).rapid(0, 0, 30).rapid(5, 0, 30).rapid(5, 0, 2).cut(120, 5, 0, -4).rapid(5, 0, -3.5)
    )
    story.cut(120, 5, 0, -7, open=0.5).cut(300, 5, 0, 2).rapid(5, 0, -5).cut(120, 5, 0, -8, open=2).cut(300, 5, 0, 2)
    story.rapid(5, 0, 20).rapid(15, 0, 20).rapid(15, 0, 2).cut(60, 15, 0, -3).event("dwell", 0.3).cut(90, 15, 0, 2)
    return Job("hh-holes", "h.h", text, story.rapid(15, 0, 20).rapid(15, 0, 30).event("off"))


def _macro() -> Job:
    text = (
        "%\nO100 (MAIN)\nG21 G90 G17 G94\nT1 M6\nS5000 M3\nG0 X10. Y0. Z30.\nG1 Z-1. F500.\n#1=1\nWHILE[#1 LE 3]DO1\n"
        "G1 X[10.*COS[#1*60.]] Y[10.*SIN[#1*60.]]\n#1=#1+1\nEND1\nG65 P200 A5. B-2. L2\nM98 P300 L2\nIF[#1 NE 4]GOTO 90\n"
        "#100=[#1-6.]/2\nIF[#100 LT 0]THEN #100=ABS[#100]+1\nG1 Y#100\nN90 G0 Z30.\nM5\nM30\n"
        "O200\nG91 G1 X#1\nG90 G1 Z[#2-0.5*[#1/5]]\nM99\nO300\nG91 G1 Y-1.5\nG90\nM99\n%\n"
    )
    story = _begun(Story()).rapid(10, 0, 30).cut(500, 10, 0, -1)
    for k in (1, 2, 3):
        story.cut(500, 10 * math.cos(k * math.pi / 3), 10 * math.sin(k * math.pi / 3), -1)
    story.cut(500, -5, 0, -1).cut(500, -5, 0, -2.5).cut(500, 0, 0, -2.5).cut(500, 0, -1.5, -2.5).cut(500, 0, -3, -2.5)
    return Job("gc-macro", "macro.nc", text, story.cut(500, 0, 2, -2.5).rapid(0, 2, 30).event("off"))


def _macro_jumps() -> Job:
    text = (
        "%\nO7\nG21 G90 G17 G94\nT1 M6\nS5000 M3\n#101=0\n#102=FIX[7.9]\n#103=ROUND[2.5]+10 MOD 4\nG0 X0. Y0. Z30.\n"
        "N10 G1 X[#101*4.] Z-#103 F[100*#103]\n#101=#101+1\nIF[[#101 LT 3]AND[#102 EQ 7]]GOTO 10\nGOTO 30\nG1 X99.\n"
        "N30 G1 Y[ATAN[1]/[1]/9] X[SQRT[#102+2]]\n#104=#5003\nG0 Z30.\nG1 Z[#104+1] F#4109\nG0 Z30.\nM5\nM30\n%\n"
    ).replace("[[#101 LT 3]AND[#102 EQ 7]]", "[#101 LT 3]")
    story = _begun(Story()).rapid(0, 0, 30)
    for k in range(3):
        story.cut(500, 4 * k, 0, -5)
    story.cut(500, 3, 5, -5).rapid(3, 5, 30).cut(500, 3, 5, -4).rapid(3, 5, 30).event("off")
    return Job("gc-jumps", "jumps.nc", text, story)


def _o_words() -> Job:
    text = (
        "G21 G90 G17 G94\nT1 M6\nS5000 M3\nG0 X0 Y0 Z30\n#<deep>=-1\no<hole> sub\nG1 X#1 Y#2 F500\n#<way>=[#3*2]\nG1 Z#<way>\n"
        "G1 Z-1\no<hole> endsub\nG1 Z#<deep> F500\n#1=0\no10 while [#1 LT 2]\no<hole> call [#1*5] [3] [-2]\n"
        "#1=[#1+1]\no10 endwhile\n"
        "o20 repeat [2]\nG91 G1 Y1\nG90\no20 endrepeat\no30 if [#1 EQ 2]\nG1 X[2**3]\no30 else\nG1 X50\no30 endif\n"
        "o40 do\n#1=[#1+1]\no40 while [#1 LT 5]\nG1 Y#1\nG0 Z30\nM5\nM2\n"
    )
    story = _begun(Story()).rapid(0, 0, 30).cut(500, 0, 0, -1)
    story.cut(500, 0, 3, -1).cut(500, 0, 3, -4).cut(500, 0, 3, -1).cut(500, 5, 3, -1).cut(500, 5, 3, -4).cut(
        500, 5, 3, -1
    )
    story.cut(500, 5, 4, -1).cut(500, 5, 5, -1).cut(500, 8, 5, -1).rapid(8, 5, 30).event("off")
    return Job("gc-o-words", "owords.ngc", text, story)


def _refused() -> list[Job]:
    """Programs of which none may come."""
    head = "G21 G90 G17\nT1 M6\nS6000 M3\nG0 X0 Y0 Z40\nG1 Z0 F300\n"
    siemens = "N5 G90 G17 G71 G94\nT1 M6\nS6000 M3\nG0 X0 Y0 Z40\nG1 Z=0 F300\n"
    klartext = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S6000\n2 L X+0 Y+0 Z+40 R0 FMAX M3\n3 L Z+0 F300\n"
    ends = "G0 Z40\nM5\nM30\n"
    last = "20 L Z+40 FMAX\n21 M5\n22 M30\n23 END PGM A MM\n"
    rows = [
        ("g41", "never.nc", head + "G41 D1 X10\nY10\nG40 X0\n" + ends),
        ("g42-later", "never.nc", head + "G42 D0 X10\nY10 D3\nG40 X0\n" + ends),
        ("machine-variable", "never.nc", head + "G1 X#500\n" + ends),
        ("alarm", "never.nc", head + "#1=5\nIF[#1 GT 4]THEN #3000=1\nX10\n" + ends),
        ("no-label", "never.nc", head + "GOTO 77\nX10\n" + ends),
        ("no-program", "never.nc", "%\nO1\n" + head.replace("X0 Y0 Z40", "X0. Y0. Z40.") + "M98 P77\n" + ends + "%\n"),
        ("sie-comp", "never.mpf", siemens + "G41 X10\nY10\nG40 X0\n" + ends),
        ("sie-unset", "never.mpf", siemens + "X=R7\n" + ends),
        ("sie-rot", "never.mpf", siemens + "ROT X30\nX10\n" + ends),
        ("sie-cycle", "never.mpf", siemens + "CYCLE84(5,0,2,-10)\n" + ends),
        (
            "sie-mode",
            "never.mpf",
            siemens + 'G0 Z40\nCYCLE800(0,"T",0,192,0,0,0,0,20,0,0,0,0)\nG0 X0 Y0 Z20\nG1 Z0\n' + ends,
        ),
        ("sie-call", "never.mpf", siemens + "POCKET_1\nX10\n" + ends),
        ("hh-comp", "never.h", klartext + "4 L X+10 RL\n5 L Y+10\n6 L X+0 R0\n" + last),
        ("hh-q", "never.h", klartext + "4 L X+Q1\n" + last),
        ("hh-cycle", "never.h", klartext + "4 CYCL DEF 251 POCKET Q215=0\n5 L X+10 M99\n" + last),
        ("hh-datum", "never.h", klartext + "4 CYCL DEF 7.0\n5 CYCL DEF 7.1 #3\n6 L X+10\n" + last),
        ("hh-axis", "never.h", klartext.replace("1 Z S", "1 Y S") + "4 L X+10\n" + last),
        ("hh-turned", "never.h", klartext + "4 M128\n5 L X+10 A+20 F300\n" + last),
    ]
    return [Job(f"no-{name}", file, text, setup=PLACE, refuse=True) for name, file, text in rows]
