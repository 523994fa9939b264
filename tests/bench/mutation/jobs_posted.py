"""Jobs in the words of controls that post-processors write: ways round, tools by names, bites, circles across the plane."""

from __future__ import annotations

import math

from mutation.jobs import PLACE, Job
from mutation.jobs_ways import TOOLS, two
from mutation.story import Story, Triple


def jobs() -> list[Job]:
    """All jobs of this file."""
    return [_turns(), _named_tools(), _bites(), _poles(), _ended_shift()]


def _begun(speed: float = 5000) -> Story:
    return Story().event("change", 1).event("cw", speed)


def _leaning(a: float, c: float) -> Triple:
    """ISO 841's tool axis at A and C, degrees."""
    a, c = math.radians(a), math.radians(c)
    return (math.sin(a) * math.sin(c), -math.sin(a) * math.cos(c), math.cos(a))


def _turns() -> Job:
    text = (
        "N10 G90 G17 G710 G94\nT1 M6\nS5000 M3\nTRAORI\nG0 X0 Y0 Z40 A=10 C=350\nG1 Z0 F500\nX10 C=DC(20)\n"
        "X20 A=12 C=IC(-15)\nX30 C=ACN(340)\nG0 Z40\nTRAFOOF\nM5\nM30\n"
    )
    story = _begun().rapid(0, 0, 40, axis=_leaning(10, 350)).cut(500, 0, 0, 0, axis=_leaning(10, 350))
    story.swing(500, (10, 0, 0), lambda s: _leaning(10, 350 + 30 * s), slack=0.001)
    story.swing(500, (20, 0, 0), lambda s: _leaning(10 + 2 * s, 20 - 15 * s), slack=0.001)
    story.swing(500, (30, 0, 0), lambda s: _leaning(12, 5 - 25 * s), slack=0.001)
    story.rapid(30, 0, 40, axis=_leaning(12, 340)).event("off")
    return Job("sie-ways-round", "turns.mpf", text, story, PLACE + 'dialect = "gcode-xyzac-iso"\n')


def _named_tools() -> Job:
    text = (
        'G90 G17 G710 G94\nT="One"\nM6\nS3000 M3\nG0 X0 Y0 Z45\nG1 Z2 F300\nX20\nG0 Z50\nM5\nT="TWO"\nM6\nS4000 M3\n'
        "G0 X26 Y0\nZ5\nG1 Z2 F280\nX40\nG0 Z50\nM5\nM30\n"
    )
    story = two().rapid(26, 0, 5).cut(280, 26, 0, 2).cut(280, 40, 0, 2).rapid(40, 0, 50).event("off")
    return Job("sie-named", "named.mpf", text, story, PLACE + TOOLS)


def _bites() -> Job:
    """Bites of 5, 3, 1.8 and 1.5 and what is left, by a factor of 0.6; CYCLE89 comes out as it went in."""
    text = (
        "N10 G90 G17 G71 G94\nT1 M6\nS1500 M3\nG0 X0 Y0 Z30\nF120\nCYCLE83(20,0,2,-12,,-5,,-0.6,0,0,1,1,3,1.5)\n"
        "G0 X12\nCYCLE89(20,0,2,-3,,0.4)\nG0 Z30\nM5\nM30\n"
    )
    story = _begun(1500).rapid(0, 0, 30).rapid(0, 0, 2).cut(120, 0, 0, -5)
    for last, low in ((-5, -8), (-8, -9.8), (-9.8, -11.3), (-11.3, -12)):
        story.rapid(0, 0, 2).rapid(0, 0, last + 0.6).cut(120, 0, 0, low, open=last - low + 0.6)
    story.rapid(0, 0, 20).rapid(12, 0, 20).rapid(12, 0, 2).cut(120, 12, 0, -3).event("dwell", 0.4)
    story.cut(120, 12, 0, 2).rapid(12, 0, 20).rapid(12, 0, 30).event("off")
    return Job("sie-shorter-bites", "bites.mpf", text, story)


def _poles() -> Job:
    text = (
        "0 BEGIN PGM P MM\n1 TOOL CALL 1 Z S5000\n2 L X+0 Y-10 Z+30 R0 FMAX M3\n3 L Z+0 F500\n4 CC Y+0 Z+0\n"
        "5 CP IPA+60 DR+\n6 L X+8 Y-10 Z+0\n7 CC Z+0 X+0\n8 CP IPA-45 DR-\n9 CC X+0 Y-2\n10 CP IPA+30 DR+\n"
        "11 L Z+30 FMAX\n12 M5\n13 M30\n14 END PGM P MM\n"
    )
    story = _begun().rapid(0, -10, 30).cut(500, 0, -10, 0).arc(500, (0, 0, 0), (1, 0, 0), 60)
    story.cut(500, 8, -10, 0).arc(500, (0, -10, 0), (0, 1, 0), -45)
    story.arc(500, (0, -2, 8 * math.sin(math.radians(45))), (0, 0, 1), 30)
    x, y = 8 * math.cos(math.radians(45)), -8.0
    turn = math.radians(30)
    end = (x * math.cos(turn) - y * math.sin(turn), -2 + x * math.sin(turn) + y * math.cos(turn))
    return Job("hh-poles", "poles.h", text, story.rapid(*end, 30).event("off"))


def _ended_shift() -> Job:
    text = (
        "0 BEGIN PGM D MM\n1 TOOL CALL 1 Z S5000\n2 L X+0 Y+0 Z+40 R0 FMAX M3\n3 CYCL DEF 7.0 DATUM\n4 CYCL DEF 7.1 X+10\n"
        "5 CYCL DEF 7.2 Z-5\n6 PLANE SPATIAL SPA+0 SPB+10 SPC+0 TURN FMAX\n7 L X+0 Y+0 Z+30 FMAX\n8 L Z+0 F500\n"
        "9 L Y+8\n10 L Z+30 FMAX\n11 CYCL DEF 7.0 DATUM\n12 CYCL DEF 7.1 X0\n13 CYCL DEF 7.2 Z0\n14 PLANE RESET TURN FMAX\n"
        "15 L X+20 Y+0 Z+30 FMAX\n16 L Z+1 F500\n17 L X+25\n18 L Z+30 FMAX\n19 M5\n20 M30\n21 END PGM D MM\n"
    )
    s, c = math.sin(math.radians(10)), math.cos(math.radians(10))
    axis = (s, 0.0, c)
    story = _begun().rapid(0, 0, 40).rapid(10 + 30 * s, 0, -5 + 30 * c, axis=axis).cut(500, 10, 0, -5, axis=axis)
    story.cut(500, 10, 8, -5, axis=axis).rapid(10 + 30 * s, 8, -5 + 30 * c, axis=axis).rapid(20, 0, 30, axis=(0, 0, 1))
    story.cut(500, 20, 0, 1).cut(500, 25, 0, 1).rapid(25, 0, 30).event("off")
    return Job("hh-ended-shift", "d.h", text, story)
