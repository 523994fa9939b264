"""Jobs of polar coordinates, Haas's mirrors, subprograms behind `%`, Heidenhain's tools by name, taps, bites and parameters."""

from __future__ import annotations

import math

from mutation.jobs import PLACE, Job
from mutation.jobs_ways import TOOLS, two
from mutation.story import Story, Triple


def jobs() -> list[Job]:
    """All jobs of this file."""
    return [
        _polar(),
        _mirrored(),
        _behind(),
        _klartext_named(),
        _taps(),
        _decreasing(),
        _parameters(),
        _vectors(),
        *_refused(),
    ]


_HEAD = "%\nO5\nG21 G90 G17 G94\nT1 M6\nS5000 M3\nG0 X0. Y0. Z30.\n"


def _begun(speed: float = 5000) -> Story:
    return Story().event("change", 1).event("cw", speed)


def _ray(radius: float, angle: float, z: float) -> Triple:
    return radius * math.cos(math.radians(angle)), radius * math.sin(math.radians(angle)), z


def _polar() -> Job:
    text = _HEAD + (
        "G16 G0 X20. Y30.\nG1 Z-1. F500.\nY60.\nG91 Y15.\nY-5. Z-1.\nG90 X10.\nG3 X10. Y160. R10.\nG15\nG1 X3. Y4.\nG0 Z30.\n"
        "G16\nG99 G81 X15. Y90. Z-3. R2. F120.\nG91 Y90.\nG90 G80 G15\nG0 X0. Y0. Z30.\nM5\nM30\n%\n"
    )
    story = _begun().rapid(0, 0, 30).rapid(*_ray(20, 30, 30)).cut(500, *_ray(20, 30, -1)).cut(500, *_ray(20, 60, -1))
    story.cut(500, *_ray(20, 75, -1)).cut(500, *_ray(20, 70, -2)).cut(500, *_ray(10, 70, -2))
    story.arc(500, (0, 0, -2), (0, 0, 1), 90).cut(500, 3, 4, -2).rapid(3, 4, 30)
    story.rapid(0, 15, 30).rapid(0, 15, 2).cut(120, 0, 15, -3).rapid(0, 15, 2)
    story.rapid(-15, 0, 2).cut(120, -15, 0, -3).rapid(-15, 0, 2).rapid(0, 0, 30)
    return Job("gc-polar", "polar.nc", text, story.event("off"))


def _vectors() -> Job:
    """Between two vectors the tool takes the great arc."""
    text = _HEAD + (
        "G43.5 H1\nG0 X0. Y0. Z30. I0 J0 K1.\nG1 Z0. F500.\nX10. I0.3 J0. K0.4\nX14. Y5.\nX14. Y9. I0. J0. K1.\nG0 Z30.\nG49\n"
        "M5\nM30\n%\n"
    )
    lean = math.acos(0.8)
    story = _begun().rapid(0, 0, 30).cut(500, 0, 0, 0)
    story.swing(500, (10, 0, 0), lambda s: (math.sin(s * lean), 0.0, math.cos(s * lean)), slack=0.001)
    story.cut(500, 14, 5, 0, axis=(0.6, 0.0, 0.8))
    story.swing(500, (14, 9, 0), lambda s: (math.sin((1 - s) * lean), 0.0, math.cos((1 - s) * lean)), slack=0.001)
    return Job("gc-vectors", "vectors.nc", text, story.rapid(14, 9, 30).event("off"))


def _mirrored() -> Job:
    text = _HEAD + (
        "G101 X0\nG0 X5. Y0. Z30.\nG1 Z-1. F500.\nX9. Y2.\nG3 X7. Y4. I-2.\nG100 X0\nG1 X1. Y1.\nG0 Z30.\n"
        "G101 Y0\nG0 X3. Y4. Z30.\nG1 Z0.\nX6. Y4.\nG0 Z30.\nG100 Y0\nG0 X0. Y0. Z30.\nM5\nM30\n%\n"
    )
    story = _begun().rapid(0, 0, 30).rapid(-5, 0, 30).cut(500, -5, 0, -1).cut(500, -9, 2, -1)
    story.arc(500, (-7, 2, -1), (0, 0, 1), -90).cut(500, 1, 1, -1).rapid(1, 1, 30).rapid(3, -4, 30)
    story.cut(500, 3, -4, 0).cut(500, 6, -4, 0).rapid(6, -4, 30).rapid(0, 0, 30).event("off")
    return Job("gc-mirrored", "mirrored.nc", text, story)


def _behind() -> Job:
    text = _HEAD + "G1 Z-1. F500.\nM98 P2 L2\nG0 Z30.\nM5\nM30\n%\nO2\nG91 G1 X5.\nY2.\nG90\nM99\n%\n"
    story = _begun().rapid(0, 0, 30).cut(500, 0, 0, -1).cut(500, 5, 0, -1).cut(500, 5, 2, -1).cut(500, 10, 2, -1)
    return Job("gc-behind", "behind.nc", text, story.cut(500, 10, 4, -1).rapid(10, 4, 30).event("off"))


def _klartext_named() -> Job:
    text = (
        'BEGIN PGM A MM\nTOOL CALL "one" Z S3000\nL X+0 Y+0 Z+45 R0 FMAX M3\nL Z+2 F300\nL X+20\nL Z+50 FMAX M5\n'
        'TOOL CALL "TWO" Z S4000\nL X+26 Y+0 R0 FMAX M3\nL Z+5 FMAX\nL Z+2 F280\nL X+40\nL Z+50 FMAX M5\nM30\nEND PGM A MM\n'
    )
    story = two().rapid(26, 0, 5).cut(280, 26, 0, 2).cut(280, 40, 0, 2).rapid(40, 0, 50)
    return Job("hh-named", "named.h", text, story.event("off"), PLACE + TOOLS)


def _taps() -> Job:
    text = (
        "N10 G90 G17 G71 G94\nT1 M6\nS800 M3\nG0 X5 Y0 Z30\nF120\nCYCLE84(20,0,2,-6,,0.2,3,,1.25,0,800)\nG0 X15\n"
        "CYCLE840(20,0,2,-5,,0,4,3,0,,1)\nG0 X25\nCYCLE89(20,0,2,-4,,0.5)\nG0 Z30\nM5\nM30\n"
    )
    story = _begun(800).rapid(5, 0, 30)
    for x, low, feed, wait in ((5, -6, 1000, 0.2), (15, -5, 800, 0.0)):
        story.rapid(x, 0, 2).cut(feed, x, 0, low)
        if wait:
            story.event("dwell", wait)
        story.event("ccw", 800).cut(feed, x, 0, 2).event("cw", 800).rapid(x, 0, 20).rapid(x + 10, 0, 20)
    story.rapid(25, 0, 2).cut(120, 25, 0, -4).event("dwell", 0.5).cut(120, 25, 0, 2).rapid(25, 0, 20).rapid(25, 0, 30)
    return Job("sie-taps", "taps.mpf", text, story.event("off"))


def _decreasing() -> Job:
    """CYCL DEF 203: bites of 4, 3 and 2 mm, out in rapid between them, back to the clearance above the last one."""
    text = (
        "0 BEGIN PGM D MM\n1 TOOL CALL 1 Z S1500\n2 L X+0 Y+0 Z+30 R0 FMAX M3\n"
        "3 CYCL DEF 203 DRILL Q200=2 Q201=-9 Q206=120 Q202=4 Q210=0 Q203=+0 Q204=20 Q212=1 Q213=0 ~\n"
        "Q205=2 Q211=0.2 Q208=99999 Q256=0.5\n4 L X+5 FMAX M99\n5 L Z+30 FMAX\n6 M5\n7 M30\n8 END PGM D MM\n"
    )
    story = _begun(1500).rapid(0, 0, 30).rapid(5, 0, 30)
    for above, low in ((2.0, -4), (-2.0, -7), (-5.0, -9)):
        story.rapid(5, 0, 2).rapid(5, 0, above).cut(120, 5, 0, low, open=0.0 if above > 0 else 2.0)
    return Job("hh-decreasing", "d.h", text, story.event("dwell", 0.2).rapid(5, 0, 20).rapid(5, 0, 30).event("off"))


def _parameters() -> Job:
    """Q1600 and up are the user's as Q0 to Q99 are."""
    text = (
        "0 BEGIN PGM P MM\n1 TOOL CALL 1 Z S5000\n2 L X+0 Y+0 Z+30 R0 FMAX M3\n3 Q1600 = -1\n4 Q1999 = Q1600 * -8\n"
        "5 L Z+Q1600 F500\n6 L X+Q1999\n7 L Z+30 FMAX\n8 M5\n9 M30\n10 END PGM P MM\n"
    )
    story = _begun().rapid(0, 0, 30).cut(500, 0, 0, -1).cut(500, 8, 0, -1).rapid(8, 0, 30)
    return Job("hh-parameters", "p.h", text, story.event("off"))


def _refused() -> list[Job]:
    """Programs of which none may come."""
    ends = "G0 X0. Y0. Z40.\nM5\nM30\n%\n"
    siemens = "N10 G90 G71 G94\nT1 M6\nS5000 M3\nG0 X5 Y40 Z60\nF100\n"
    rows = [
        ("polar-step", "never.nc", _HEAD + "G16 G0 X20. Y30.\nG1 Z-1. F500.\nG91 X2.\nG90 G15\n" + ends),
        ("polar-plane", "never.nc", _HEAD + "G18 G16 G0 X20. Z30.\nG1 Y-1. F500.\nG15 G17\n" + ends),
        ("mirror-aside", "never.nc", _HEAD + "G101 X5.\nG1 X9. Y2. F500.\nG100 X0\n" + ends),
        ("two-datums", "never.nc", "$A.MIN%\n" + _HEAD[2:] + "G15 H1\nG1 Z-1. F500.\nX5.\nG15 H2\nX9.\n" + ends),
        ("cycle-across", "never.mpf", siemens + "G18\nCYCLE81(60,40,3,35)\nG17\nG0 Z70\nM5\nM30\n"),
        ("modal-across", "never.mpf", siemens + "G18\nMCALL CYCLE82(60,40,3,35)\nX9\nMCALL\nG0 Z70\nM5\nM30\n"),
        ("spindle-zero", "never.nc", _HEAD.replace("S5000", "S0") + "G1 Z-1. F500.\nX5.\n" + ends),
        (
            "half-around",
            "never.mpf",
            "G90 G17 G710 G94\nT1 M6\nS5000 M3\nTRAORI\nF500\nG0 X0 Y0 Z50 A=5 C=0\nG1 Z0\nX9 C=DC(180)\nM30\n",
        ),
    ]
    more = {"spindle-zero": "spindle_rpm = 5000\n", "half-around": 'dialect = "gcode-xyzac-iso"\n'}
    return [Job(f"no-{name}", file, text, setup=PLACE + more.get(name, ""), refuse=True) for name, file, text in rows]
