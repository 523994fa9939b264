"""Jobs of the APT family: NX, CAMWorks, CATIA, Creo, Makino, and plain APT."""

from __future__ import annotations

import math

import numpy as np

from mutation.jobs import Job
from mutation.story import Story

_NX = "TOOL PATH/{name},TOOL,T1\nTLDATA/MILL,10.0,0.0,75.0,0.0,0.0\nMSYS/{msys}\nPAINT/PATH\nLOAD/TOOL,1\n"
_MSYS = "0.0,0.0,0.0,1.0,0.0,0.0,0.0,1.0,0.0"
_CUT = "SPINDL/RPM,6000,CLW\nRAPID\n"


def nx(name: str, body: str, msys: str = _MSYS) -> str:
    """One operation of a CLSF."""
    return _NX.format(name=name, msys=msys) + body + "PAINT/TOOL,NOMORE\nEND-OF-PATH\n"


def started(rpm: float = 6000, **story: object) -> Story:
    """A story whose first tool is called for and whose spindle turns."""
    return Story(**story).event("change", 1).event("cw", rpm)  # type: ignore[arg-type]


def jobs() -> list[Job]:
    """All jobs of this file."""
    return [
        _pocket(),
        _arcs(),
        _helix(),
        _msys(),
        _five_axes(),
        _drill(),
        _pecks(),
        _tap(),
        _sides(),
        _nurbs(),
        _camworks(),
        _clt(),
        _creo(),
        _catia(),
        _makino(),
        _plain(),
    ]


def _pocket() -> Job:
    text = nx(
        "POCKET",
        "SPINDL/RPM,9000,CLW\nCOOLNT/ON\nRAPID\nGOTO/-30,-20,50,0.0871557427,0,0.9961946981\nFEDRAT/MMPM,600\n"
        "GOTO/-30,-20,0\nGOTO/30,-20,0\nGOTO/30,20,1\nGOTO/0,25,2\nDELAY/1.5\nFEDRAT/250\nGOTO/-30,20,1\n"
        "GOTO/-30,-19,0\nCOOLNT/OFF\nRAPID\nGOTO/-30,-20,50\nSPINDL/OFF\n",
    )
    story = started(9000, part_in_base=(60, -40, 200, 30, 0, 0))
    story.event("wet").rapid(-30, -20, 50, axis=(0.0871557427, 0.0, 0.9961946981))
    story.follow(600, (-30, -20, 0), (30, -20, 0), (30, 20, 1), (0, 25, 2)).event("dwell", 1.5)
    story.follow(250, (-30, 20, 1), (-30, -19, 0)).event("dry").rapid(-30, -20, 50).event("off")
    return Job("nx-pocket", "pocket.cls", text, story, "part_in_base = [60, -40, 200, 30, 0, 0]\n")


def _arcs() -> Job:
    """NX prints arcs left-handed about their axis: 0,0,-1 runs counter-clockwise seen from above."""
    text = nx(
        "ARCS",
        _CUT + "GOTO/10,0,30,0,0,1\nFEDRAT/MMPM,500\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,-1,10,0.06,0.5,20,0\nGOTO/0,10,0\n"
        "GOTO/-10,10,0\nFEDRAT/MMPM,400\nCIRCLE/-10,0,0,0,0,1,10,0.06,0.5,20,0\nGOTO/0,0,0\nGOTO/10,0,0\n"
        "CIRCLE/0,0,0,0,0,-1,10,0.06,0.5,20,0\nGOTO/10,0,0\nRAPID\nGOTO/10,0,30\nSPINDL/OFF\n",
    )
    story = started().rapid(10, 0, 30).cut(500, 10, 0, 0)
    story.arc(500, (0, 0, 0), (0, 0, 1), 90).cut(500, -10, 10, 0).arc(400, (-10, 0, 0), (0, 0, 1), -90)
    story.cut(400, 10, 0, 0).arc(400, (0, 0, 0), (0, 0, 1), 360).rapid(10, 0, 30).event("off")
    return Job("nx-arcs", "arcs.cls", text, story)


def _helix() -> Job:
    text = nx(
        "HELIX",
        _CUT + "GOTO/12,0,30,0,0,1\nFEDRAT/MMPM,500\nGOTO/12,0,3\nCIRCLE/0,0,3,0,0,-1,12,0.06,0.5,24,0\nGOTO/0,12,1\n"
        "CIRCLE/0,0,1,1,0,0,12,0.06,0.5,24,0\nGOTO/0,0,-11\nRAPID\nGOTO/0,0,30\nSPINDL/OFF\n",
    )
    story = started(part_in_base=(0, 0, 220, 0, 0, 0)).rapid(12, 0, 30).cut(500, 12, 0, 3)
    story.arc(500, (0, 0, 3), (0, 0, 1), 90, rise=-2, slack=0.02)
    story.arc(500, (0, 0, 1), (1, 0, 0), -90, slack=0.02).rapid(0, 0, 30).event("off")
    return Job("nx-helix", "helix.cls", text, story, "part_in_base = [0, 0, 220, 0, 0, 0]\nchord_tolerance_mm = 0.02\n")


def _msys() -> Job:
    c, s = math.cos(math.radians(30.0)), math.sin(math.radians(30.0))
    cut = "FEDRAT/MMPM,480\nGOTO/0,0,5\nGOTO/10,0,5\nGOTO/10,5,5\nRAPID\nGOTO/10,5,30\n"
    text = nx("FLAT", _CUT + "GOTO/0,0,30,0,0,1\n" + cut)
    text += nx("TURNED", "RAPID\nGOTO/0,0,30,0,0,1\n" + cut, "20.0,10.0,0.0,0.0,1.0,0.0,-1.0,0.0,0.0")
    text += nx(
        "TILTED", "RAPID\nGOTO/0,0,30,0,0,1\n" + cut + "SPINDL/OFF\n", f"0.0,0.0,10.0,{c:.9f},0.0,{-s:.9f},0.0,1.0,0.0"
    )
    story = started()
    for at in ((0, 0, 0, 0, 0, 0), (20, 10, 0, 90, 0, 0), (0, 0, 10, 0, 30, 0)):
        story.use(at).rapid(0, 0, 30, axis=(0, 0, 1)).follow(480, (0, 0, 5), (10, 0, 5), (10, 5, 5)).rapid(10, 5, 30)
    story.event("off")
    return Job("nx-msys", "msys.cls", text, story)


def _five_axes() -> Job:
    axes = [(math.sin(math.radians(t)), math.sin(math.radians(t / 3)), 1.0) for t in (0, 6, 12, 18, 24, 18, 6, -4, -10)]
    axes = [tuple((np.array(a) / np.linalg.norm(a)).round(9)) for a in axes]
    points = [(-20 + 5 * k, 2.0 * k, 0.5 * k) for k in range(9)]
    body = _CUT + "GOTO/-20,0,40,0,0,1\nFEDRAT/MMPM,900\n"
    body += "".join(f"GOTO/{p[0]},{p[1]},{p[2]},{a[0]},{a[1]},{a[2]}\n" for p, a in zip(points, axes, strict=True))
    text = nx("FIVE", body + "RAPID\nGOTO/20,16,50\nSPINDL/OFF\n")
    story = started(part_in_base=(30, 20, 190, -50, 10, 0)).rapid(-20, 0, 40)
    for p, a in zip(points, axes, strict=True):
        story.cut(900, *p, axis=a)
    story.rapid(20, 16, 50).event("off")
    setup = "part_in_base = [30, 20, 190, -50, 10, 0]\nrapid_feed_mm_min = 7200\n"
    return Job("nx-five-axes", "five.cls", text, story, setup, rapid=7200.0)


def _hole(story: Story, x: float, y: float, z: float, bottom: float, feed: float, clear: float, out: float) -> Story:
    """Down from the height `out` above the point to its clearance and its bottom."""
    return story.rapid(x, y, z + out).rapid(x, y, z + clear).cut(feed, x, y, z + bottom)


def _drill() -> Job:
    text = nx(
        "DRILL",
        "SPINDL/RPM,1200,CLW\nRAPID\nGOTO/0,0,40,0,0,1\n"
        "CYCLE/DRILL,RAPTO,3.,FEDTO,-12.,MMPM,150.,RTRCTO,10.,DWELL,0.5\n"
        "GOTO/5,0,1\nGOTO/15,0,1\nCYCLE/OFF\nCYCLE/BORE,RAPTO,2.,FEDTO,-8.,MMPM,120.,RTRCTO,AUTO\nGOTO/15,10,0\n"
        "CYCLE/OFF\nRAPID\nGOTO/15,10,40\nSPINDL/OFF\n",
    )
    story = started(1200).rapid(0, 0, 40).rapid(5, 0, 40)
    _hole(story, 5, 0, 1, -12, 150, 3, 10).event("dwell", 0.5).rapid(5, 0, 11)
    _hole(story, 15, 0, 1, -12, 150, 3, 10).event("dwell", 0.5).rapid(15, 0, 11)
    story.rapid(15, 10, 11).rapid(15, 10, 2).cut(120, 15, 10, -8).cut(120, 15, 10, 2).rapid(15, 10, 40).event("off")
    return Job("nx-drill", "drill.cls", text, story)


def _pecks() -> Job:
    text = nx(
        "PECKS",
        "SPINDL/RPM,1200,CLW\nRAPID\nGOTO/0,0,40,0,0,1\n"
        "CYCLE/DRILL,DEEP,RAPTO,3.,FEDTO,-9.,STEP,4.,MMPM,150.\nGOTO/0,0,0\n"
        "CYCLE/OFF\nCYCLE/BRKCHP,RAPTO,3.,FEDTO,-6.,STEP,4.,MMPM,150.\nGOTO/10,0,0\nCYCLE/OFF\n"
        "RAPID\nGOTO/10,0,40\nSPINDL/OFF\n",
    )
    story = started(1200).rapid(0, 0, 40).rapid(0, 0, 3).cut(150, 0, 0, -4).rapid(0, 0, 3).rapid(0, 0, -3.5)
    story.cut(150, 0, 0, -8, open=0.5).rapid(0, 0, 3).rapid(0, 0, -7.5).cut(150, 0, 0, -9, open=0.5).rapid(0, 0, 3)
    story.rapid(10, 0, 3).cut(150, 10, 0, -4).rapid(10, 0, -3.5).cut(150, 10, 0, -6, open=0.5).rapid(10, 0, 3)
    story.rapid(10, 0, 40).event("off")
    return Job("nx-pecks", "pecks.cls", text, story)


def _tap() -> Job:
    text = nx(
        "TAP",
        "SPINDL/RPM,300,CLW\nRAPID\nGOTO/0,0,40,0,0,1\nCYCLE/TAP,RAPTO,3.,FEDTO,-10.,MMPM,300.\n"
        "GOTO/0,0,0\nGOTO/20,0,0\n"
        "CYCLE/OFF\nRAPID\nGOTO/20,0,40\nSPINDL/OFF\n",
    )
    story = started(300).rapid(0, 0, 40)
    for x in (0, 20):
        story.rapid(x, 0, 3).cut(300, x, 0, -10).event("ccw", 300).cut(300, x, 0, 3).event("cw", 300)
    story.rapid(20, 0, 40).event("off")
    return Job("nx-tap", "tap.cls", text, story)


def _sides() -> Job:
    """Two sides of a block: the tool leans over between them, the table turns."""
    text = nx("TOP", _CUT + "GOTO/0,0,80,0,0,1\nFEDRAT/MMPM,700\nGOTO/0,0,58\nGOTO/12,0,58\nRAPID\nGOTO/12,0,80\n")
    text += nx(
        "SIDE",
        "RAPID\nGOTO/60,0,40,0.866025404,0,0.5\nFEDRAT/MMPM,300\nGOTO/38,0,30,0.866025404,0,0.5\n"
        "GOTO/38,10,30\nRAPID\n"
        "GOTO/60,10,44\nSPINDL/OFF\n",
    )
    lean = (0.866025404, 0.0, 0.5)
    story = started(part_in_base=(0, 0, 200, 0, 0, 0)).rapid(0, 0, 80).cut(700, 0, 0, 58).cut(700, 12, 0, 58)
    story.rapid(12, 0, 80).rapid(60, 0, 40, axis=lean).cut(300, 38, 0, 30).cut(300, 38, 10, 30)
    story.rapid(60, 10, 44).event("off")
    setup = (
        'part_in_base = [0, 0, 200, 0, 0, 0]\nclearance_mm = 35\n[tool]\nname = "end mill 6"\ndiameter_mm = 6\n'
        "length_mm = 75\n[stock]\nbox_mm = [-40, -30, 0, 40, 30, 60]\n"
    )
    return Job("nx-sides", "sides.cls", text, story, setup, tool=(6.0, 75.0))


def _nurbs() -> Job:
    """One cubic segment between clamped knots is a Bezier curve."""
    control = [(0.0, 0.0, 0.0), (5.0, 10.0, 0.0), (15.0, 10.0, -2.0), (20.0, 0.0, -1.0)]
    text = nx(
        "CURVE",
        _CUT
        + "GOTO/0,0,30,0,0,1\nFEDRAT/MMPM,450\nGOTO/0,0,0\nNURBS/\nKNOT/0,0,0,0,1,1,1,1\n"
        + "".join(f"CNTRL/{x},{y},{z}\n" for x, y, z in control)
        + "RAPID\nGOTO/20,0,30\nSPINDL/OFF\n",
    )
    story = started().rapid(0, 0, 30).cut(450, 0, 0, 0).bezier(450, control, slack=0.02).rapid(20, 0, 30).event("off")
    return Job("nx-nurbs", "curve.cls", text, story, "part_in_base = [0, 0, 200, 0, 0, 0]\nchord_tolerance_mm = 0.02\n")


def _camworks() -> Job:
    text = (
        "PARTNO PLATE\nUNIT/INCH\nCUTTER/0.25,0,0.125,0,0,0,2.5\nLOAD/TOOL,17\nSPINDL/4208,RPM,CLW\nCOOLNT/FLOOD\n"
        "TRNTYP/WORLD,0,0,0\nCSYS/1.,0,0,0,0,1.,0,0,0,0,1.,0\nRAPID/\nGOTO/0,0,1.5\nFEDRAT/12.,IPM\nGOTO/0,0,-0.1\n"
        "GOTO/0.8,0,-0.1\nCIRCLE/0.8,0.25,-0.1,0,0,1,0.25\nGOTO/0.8,0.5,-0.1\nRAPID/\nGOTO/0.8,0.5,1.5\nCYCLE/INIT\n"
        "CYCLE/DRILL,FEDTO,0.4,IPM,8.,RAPTO,0.1,RTRCTO,0.5,DWELL,0\nGOTO/0.2,0.2,0.\nCYCLE/OFF\n"
        "RAPID/\nGOTO/0.2,0.2,1.5\n"
        "COOLNT/OFF\nSPINDL/OFF\nFINI\n"
    )
    i = 25.4
    story = Story().event("change", 17).event("cw", 4208).event("wet").rapid(0, 0, 1.5 * i)
    story.cut(12 * i, 0, 0, -0.1 * i).cut(12 * i, 0.8 * i, 0, -0.1 * i)
    story.arc(12 * i, (0.8 * i, 0.25 * i, -0.1 * i), (0, 0, 1), 180).rapid(0.8 * i, 0.5 * i, 1.5 * i)
    story.rapid(0.2 * i, 0.2 * i, 1.5 * i).rapid(0.2 * i, 0.2 * i, 0.5 * i).rapid(0.2 * i, 0.2 * i, 0.1 * i)
    story.cut(8 * i, 0.2 * i, 0.2 * i, -0.4 * i).rapid(0.2 * i, 0.2 * i, 0.5 * i).rapid(0.2 * i, 0.2 * i, 1.5 * i)
    story.event("dry").event("off")
    return Job("camworks-inch", "plate.apt", text, story)


def _clt() -> Job:
    """The table has turned the part by 0.3 rad about x: the points are in the turned part's frame."""
    c, s = math.cos(0.3), math.sin(0.3)
    text = (
        "PARTNO/P\nUNITS/MM\nCUTTER/8.0,0,0,0,0,0,50\nOPFEATSTART/Mill1\nSPINDL/3000,RPM,CLW\nCOOLNT/ON\n"
        f"ROTABL/0.3,AAXIS,TABLE,CCLW\nTLAXIS/0,{-s:.9f},{c:.9f}\nRAPID\nGOTO/0,0,40\nFEDRAT/350,MMPM\nGOTO/0,0,2\n"
        "GOTO/14,0,2\nCIRCLE/14,5,2,0,0,1,5,CLOCKWISE\nGOTO/9,5,2\nRAPID\nGOTO/9,5,40\nCOOLNT/OFF\n"
        "SPINDL/OFF\nOPFEATEND/Mill1\nFINI\n"
    )
    story = Story(part_in_base=(0, 0, 215, 0, 0, 0)).use((0, 0, 0, 0, 0, math.degrees(0.3)))
    story.event("cw", 3000).event("wet").rapid(0, 0, 40, axis=(0, 0, 1)).cut(350, 0, 0, 2).cut(350, 14, 0, 2)
    story.arc(350, (14, 5, 2), (0, 0, 1), -90).rapid(9, 5, 40).event("dry").event("off")
    return Job("clt-table", "clt.clt", text, story, 'part_in_base = [0, 0, 215, 0, 0, 0]\ndialect = "camworks-clt"\n')


def _creo() -> Job:
    text = (
        "$$*         Pro/CLfile  Version Wildfire 5.0 - M150\n$$-> MFGNO / T\nPARTNO / T\n"
        "$$-> FEATNO / 25\nMACHIN / UNCX01, 1\n"
        "UNITS / MM\nLOADTL / 1\n$$-> CUTTER / 10.000000\nSPINDL / RPM, 3000.000000,  CLW\nRAPID\n"
        "GOTO / 0.0, 0.0, 35.0\n"
        "FEDRAT / 0.1,  MMPR\nGOTO / 0.0, 0.0, 2.0\nGOTO / 20.0000000000, 0.0, $\n    2.0\n"
        "CIRCLE / 20.0, 10.0, 2.0, $\n"
        "  0.0, 0.0, 1.0, 10.0\nGOTO / 30.0, 10.0, 2.0\nRAPID\nGOTO / 30.0, 10.0, 35.0\n"
        "$$-> FEATNO / 31\nCOOLNT / FLOOD\nRAPID\n"
        "GOTO / 0.0, 30.0, 35.0\nCYCLE / DEEP, DEPTH, 3.5, STEP, 2.0, MMPM, 50., CLEAR, 1.0\nGOTO / 0.0, 30.0, 0.5\n"
        "CYCLE / OFF\nRAPID\nGOTO / 0.0, 30.0, 35.0\nSTOP\nRAPID\nGOTO / 5.0, 30.0, 35.0\nFEDRAT / 100.0,  MMPM\n"
        "GOTO / 5.0, 30.0, 0.0\nRAPID\nGOTO / 5.0, 30.0, 35.0\nCOOLNT / OFF\nSPINDL / OFF\n$$-> END /\nFINI\n"
    )
    story = started(3000).rapid(0, 0, 35).cut(300, 0, 0, 2).cut(300, 20, 0, 2).arc(300, (20, 10, 2), (0, 0, 1), 90)
    story.rapid(30, 10, 35).event("wet").rapid(0, 30, 35).rapid(0, 30, 1.5).cut(50, 0, 30, -1.5)
    story.rapid(0, 30, 1.5).rapid(0, 30, -1.0).cut(50, 0, 30, -3, open=0.5).rapid(0, 30, 1.5).rapid(0, 30, 35).event(
        "halt"
    )
    story.rapid(5, 30, 35).cut(100, 5, 30, 0).rapid(5, 30, 35).event("dry").event("off")
    return Job("creo", "creo.ncl", text, story)


def _catia() -> Job:
    text = (
        "$$ CATIA APT VERSION 1.0\n$$*CATIA0\n$$ Manufacturing Program.1\n"
        "$$    0.00000   -1.00000    0.00000   15.00000\n"
        "$$    1.00000    0.00000    0.00000    5.00000\n"
        "$$    0.00000    0.00000    1.00000    0.00000\nPARTNO Op.1\n"
        "PPRINT OPERATION NAME : Tool Change.1\nLOADTL/1,1\n$$ OPERATION NAME : Contour.1\n"
        "SPINDL/ 4000.0000,RPM,CLW\nRAPID\n"
        "GOTO  /    0.00000,   10.00000,   35.00000\nFEDRAT/  260.0000,MMPM\n"
        "GOTO  /    0.00000,   10.00000,    0.00000\n"
        "INTOL / 0.0\nOUTTOL/ 0.1\nAUTOPS\nINDIRV/  -1.00000,    0.00000,    0.00000\n"
        "TLON,GOFWD/ (CIRCLE/    0.00000,    0.00000,    0.00000,$\n"
        "   10.00000),ON,(LINE/    0.00000,    0.00000,    0.00000,$\n"
        "     -10.00000,    0.00000,    0.00000)\nGOTO  /  -10.00000,  -12.00000,    0.00000\nDELAY/ 0.75\nRAPID\n"
        "GOTO  /  -10.00000,  -12.00000,   35.00000\nCYCLE/DRILL,6.,90.,MMPM,5.\n"
        "GOTO  /    4.00000,  -12.00000,    0.00000\n"
        "CYCLE/OFF\nSPINDL/OFF\n$$ End of generation of : Contour.1\nFINI\n"
    )
    story = started(4000).use((15, 5, 0, 90, 0, 0)).rapid(0, 10, 35, axis=(0, 0, 1)).cut(260, 0, 10, 0)
    story.arc(260, (0, 0, 0), (0, 0, 1), 90).cut(260, -10, -12, 0).event("dwell", 0.75).rapid(-10, -12, 35)
    story.rapid(4, -12, 35).rapid(4, -12, 5).cut(90, 4, -12, -6).rapid(4, -12, 5).event("off")
    return Job("catia", "catia.aptsource", text, story)


def _makino() -> Job:
    text = (
        "PPRINT/APTCL-SPEC,MAKINO\nUNITS/MM\nPPRINT/BEGIN-SECTION,MACHINING\nLOADTL/4\n"
        "SPINDL/5000,RPM,CLW\nCOOLNT/ON\n"
        "RAPID\nGOTO/8,0,30,0,0,1\nFEDRAT/310,MMPM\nGOTO/8,0,1\nCIRCLE/0,0,1,0,0,1,8\nGOTO/0,-8,1\n"
        "PPRINT/MOTION,CUT\n"
        "GOTO/-8,-8,1\nRAPID\nGOTO/-8,-8,30\nCOOLNT/OFF\nSPINDL/OFF\nPPRINT/END-SECTION,MACHINING\nFINI\n"
    )
    story = Story().event("change", 4).event("cw", 5000).event("wet").rapid(8, 0, 30).cut(310, 8, 0, 1)
    story.arc(310, (0, 0, 1), (0, 0, 1), -90).cut(310, -8, -8, 1).rapid(-8, -8, 30).event("dry").event("off")
    return Job("makino", "makino.apt", text, story)


def _plain() -> Job:
    """FROM, GODLTA, GOHOME, and a set-up that brings feed and spindle speed of its own."""
    text = (
        "PARTNO PLAIN\nUNITS/MM\nLOADTL/1\nSPINDL/2500,RPM,CLW\nFROM/0,0,60\nRAPID\nGOTO/6,0,30\n"
        "FEDRAT/240,MMPM\nGODLTA/0,0,-29\n"
        "GODLTA/0,18,0\nGODLTA/4,2,1\nRAPID\nGODLTA/0,0,30\nRAPID\nGOTO/-6,0,32\nGOTO/-6,0,1\n"
        "GOTO/-6,12,1\nGOHOME/-6,12,60\n"
        "SPINDL/OFF\nFINI\n"
    )
    story = started(2500).rapid(6, 0, 30).follow(240, (6, 0, 1), (6, 18, 1), (10, 20, 2)).rapid(10, 20, 32)
    story.rapid(-6, 0, 32).cut(240, -6, 0, 1).cut(240, -6, 12, 1).rapid(-6, 12, 60).event("off")
    return Job("apt-plain", "plain.apt", text, story)
