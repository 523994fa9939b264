"""Jobs on which faults put in by hand show that show on none of the others: coolant at a change, holes at other heights."""

from __future__ import annotations

import math

import numpy as np

from mutation.arm import TOOL
from mutation.jobs import PLACE, Job
from mutation.jobs_apt import nx, started
from mutation.jobs_ways import SHORTER, TOOLS
from mutation.story import Story

__all__ = ["jobs"]


def jobs() -> list[Job]:
    """All jobs of this file."""
    return [_wet_change(), _stepped(), _raised(), _relative(), _swivelled(), *_beginnings()]


def _wet_change() -> Job:
    """The file changes the tool with spindle and coolant on, and goes on with both."""
    text = (
        "%\nG21 G90 G17\nT1 M6\nS3000 M3\nM8\nG0 X0 Y0 Z45\nG1 Z2 F300\nX20\nG0 Z50\nT2 M6\nS4000 M3\n"
        "G0 X26 Y0\nZ5\nG1 Z2 F280\nX40\nG0 Z50\nM5\nM9\nM30\n%\n"
    )
    story = Story(tools={1: TOOL, 2: SHORTER}, tool=1).event("change", 1).event("cw", 3000).event("wet")
    story.rapid(0, 0, 45).cut(300, 0, 0, 2).cut(300, 20, 0, 2).rapid(20, 0, 50).event("off").event("dry")
    story.event("change", 2).event("cw", 4000).event("wet").rapid(26, 0, 50).rapid(26, 0, 5).cut(280, 26, 0, 2)
    story.cut(280, 40, 0, 2).rapid(40, 0, 50).event("off").event("dry")
    return Job("two-wet", "wet.nc", text, story, PLACE + TOOLS)


def _stepped() -> Job:
    """From one hole up to another, whose retract height is above that of the first."""
    text = nx(
        "STEP",
        "SPINDL/RPM,1200,CLW\nRAPID\nGOTO/0,0,40,0,0,1\nCYCLE/DRILL,RAPTO,3.,FEDTO,-6.,MMPM,150.,RTRCTO,10.\nGOTO/5,0,0\n"
        "GOTO/15,0,20\nCYCLE/OFF\nRAPID\nGOTO/15,0,40\nSPINDL/OFF\n",
    )
    story = started(1200).rapid(0, 0, 40).rapid(5, 0, 40).rapid(5, 0, 10).rapid(5, 0, 3).cut(150, 5, 0, -6)
    story.rapid(5, 0, 10).rapid(5, 0, 30).rapid(15, 0, 30).rapid(15, 0, 23).cut(150, 15, 0, 14).rapid(15, 0, 30)
    return Job("nx-stepped", "stepped.cls", text, story.rapid(15, 0, 40).event("off"))


def _raised() -> Job:
    text = (
        "0 BEGIN PGM R MM\n1 TOOL CALL 1 Z S1500\n2 L X+0 Y+0 Z+30 R0 FMAX M3\n"
        "3 CYCL DEF 200 DRILL Q200=2 Q201=-6 Q206=120 Q202=4 Q210=0 Q203=+5 Q204=20 Q211=0\n"
        "4 L X+5 FMAX M99\n5 L Z+30 FMAX\n6 M5\n7 M30\n8 END PGM R MM\n"
    )
    story = Story().event("change", 1).event("cw", 1500).rapid(0, 0, 30).rapid(5, 0, 30).rapid(5, 0, 7)
    story.cut(120, 5, 0, 1).rapid(5, 0, 7).rapid(5, 0, 3).cut(120, 5, 0, -1, open=2).rapid(5, 0, 25).rapid(5, 0, 30)
    return Job("hh-raised", "r.h", text, story.event("off"))


def _relative() -> Job:
    """Depths from the surface, bites that get shorter."""
    text = (
        "%_N_DEEP_MPF\nN10 G90 G17 G71 G94\nT1 M6\nS1500 M3\nG0 X5 Y0 Z30\nF120\nCYCLE83(20,5,2,,8,,4,1,0,0,1,1)\n"
        "G0 Z30\nM5\nM30\n"
    )
    story = Story().event("change", 1).event("cw", 1500).rapid(5, 0, 30).rapid(5, 0, 7).cut(120, 5, 0, 1).rapid(5, 0, 7)
    story.rapid(5, 0, 1.6).cut(120, 5, 0, -2, open=0.6).rapid(5, 0, 7).rapid(5, 0, -1.4).cut(120, 5, 0, -3, open=0.6)
    return Job("sie-relative", "deep.mpf", text, story.rapid(5, 0, 20).rapid(5, 0, 30).event("off"))


def _swivelled() -> Job:
    """A plane by two angles, with a zero of its own behind them."""
    text = (
        "N10 G90 G17 G71 G94\nT1 M6\nS5000 M3\nG0 X0 Y0 Z60\nG1 Z40 F500\nX8\nG0 Z60\n"
        'CYCLE800(0,"TC1",100000,57,20,0,30,15,20,0,0,3,2,-1,100,1)\nG0 X0 Y0 Z30\nG1 Z0 F300\nX10 Y2\nG0 Z40\n'
        "CYCLE800()\nM5\nM30\n"
    )
    a, b = math.radians(15), math.radians(20)
    about_x = np.array([[1, 0, 0], [0, math.cos(a), -math.sin(a)], [0, math.sin(a), math.cos(a)]])
    about_y = np.array([[math.cos(b), 0, math.sin(b)], [0, 1, 0], [-math.sin(b), 0, math.cos(b)]])
    turn = about_x @ about_y
    place = np.array([20, 0, 30]) + turn @ np.array([0, 3, 2])
    abc = (math.atan2(turn[1, 0], turn[0, 0]), math.asin(-turn[2, 0]), math.atan2(turn[2, 1], turn[2, 2]))
    story = Story().event("change", 1).event("cw", 5000).rapid(0, 0, 60).cut(500, 0, 0, 40).cut(500, 8, 0, 40)
    story.rapid(8, 0, 60).use((*place.tolist(), *np.degrees(abc).tolist())).rapid(0, 0, 30, axis=(0, 0, 1))
    story.cut(300, 0, 0, 0).cut(300, 10, 2, 0).rapid(10, 2, 40).event("off")
    return Job("sie-swivelled", "swivelled.mpf", text, story)


def _beginnings() -> list[Job]:
    """From wherever the machine stands, at a feed; and a hole there, of which no program may come."""
    head, end = "BEGIN PGM B MM\nTOOL CALL 1 Z S5000\n", "L X+20 F100\nL Z+50 FMAX\nM5\nM30\nEND PGM B MM\n"
    text = head + "L Z+5 R0 F9000 M3\nL X+10 Y+10\nL Z-1 F100\n" + end
    story = Story().event("change", 1).event("cw", 5000).rapid(10, 10, 5).cut(100, 10, 10, -1)
    story.cut(100, 20, 10, -1).rapid(20, 10, 50).event("off")
    hole = head + "L Z-5 R0 F100 M3\nL Z+5\nL X+10 Y+10 FMAX\nL Z-1\n" + end
    slot = head + "L Z-1 R0 F100 M3\nL X+10 Y+10\n" + end
    return [
        Job("hh-begins", "b.h", text, story),
        Job("no-hole-somewhere", "never.h", hole, setup=PLACE, refuse=True),
        Job("no-slot-from-somewhere", "never.h", slot, setup=PLACE, refuse=True),
    ]
