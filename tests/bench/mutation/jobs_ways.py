"""Jobs that take other ways through camrob: tools, set-ups, cells, methods, files in parts."""

from __future__ import annotations

import math
from dataclasses import replace

from mutation import cells
from mutation.arm import TOOL
from mutation.jobs import PLACE, Job
from mutation.jobs_apt import nx, started
from mutation.story import Story

SHORTER = (0.0, -41.763657, 393.577926, 0.0, 0.0, -159.579784)
ASIDE = (3.0, -40.0, 405.5, 10.0, 0.0, -150.0)
_CUT = "SPINDL/RPM,6000,CLW\nRAPID\n"
TOOLS = (
    f'[[tool]]\nnumber = 1\nname = "one"\nflange_to_tool = {list(TOOL)}\ndiameter_mm = 10\nlength_mm = 80\n'
    f'[[tool]]\nnumber = 2\nname = "two"\nflange_to_tool = {list(SHORTER)}\ndiameter_mm = 8\nlength_mm = 60\n'
)


def jobs() -> list[Job]:
    """All jobs of this file."""
    return [
        *_two_tools(),
        *_cell_ways(),
        _decimated(),
        _planned(),
        _split(),
        _again(),
        _no_setup(),
        _silent(),
        _optimal(),
        _tool_aside(),
        _repeated(),
        _retreat(),
        _counter(),
        _sense(),
        *_with_part(),
    ]


def two() -> Story:
    """The story of the two-tool jobs: one pocket a tool, everything off for the change."""
    story = Story(tools={1: TOOL, 2: SHORTER}, tool=1).event("change", 1).event("cw", 3000)
    story.rapid(0, 0, 45).cut(300, 0, 0, 2).cut(300, 20, 0, 2).rapid(20, 0, 50).event("off")
    story.event("change", 2).event("cw", 4000).rapid(26, 0, 50)
    return story


def _two_tools() -> list[Job]:
    gcode = (
        "%\nG21 G90 G17\nT1 M6\nS3000 M3\nG0 X0 Y0 Z45\nG1 Z2 F300\nX20\nG0 Z50\nM5\nT2 M6\nS4000 M3\n"
        "G0 X26 Y0\nZ5\nG1 Z2 F280\nX40\nG0 Z50\nM5\nM30\n%\n"
    )
    story = two().rapid(26, 0, 5).cut(280, 26, 0, 2).cut(280, 40, 0, 2).rapid(40, 0, 50).event("off")
    text = nx(
        "A",
        "SPINDL/RPM,3000,CLW\nRAPID\nGOTO/0,0,45,0,0,1\nFEDRAT/MMPM,300.0\nGOTO/0,0,2\nGOTO/20,0,2\nRAPID\nGOTO/20,0,50\n"
        "LOAD/TOOL,2\nSPINDL/RPM,4000,CLW\nRAPID\nGOTO/26,0,50\nFEDRAT/MMPM,280.0\nGOTO/26,0,2\n"
        "GOTO/40,0,2\nRAPID\nGOTO/40,0,50\n",
    )
    plain = two().cut(280, 26, 0, 2).cut(280, 40, 0, 2).rapid(40, 0, 50)
    apt = (
        "PARTNO T\nUNIT/MM\nLOAD/TOOL,1\nSPINDL/3000,RPM,CLW\nRAPID/\nGOTO/0,0,45.\n"
        "FEDRAT/300.,MMPM\nGOTO/0,0,2.\nGOTO/20.,0,2.\n"
        "RAPID/\nGOTO/20.,0,50.\nLOAD/TOOL,2\nSPINDL/4000,RPM,CLW\nRAPID/\nGOTO/26.,0,50.\n"
        "FEDRAT/280.,MMPM\nGOTO/26.,0,2.\nGOTO/40.,0,2.\n"
        "RAPID/\nGOTO/40.,0,50.\nFINI\n"
    )
    setup = PLACE + TOOLS
    return [
        Job("two-gcode", "two.nc", gcode, story, setup),
        Job("two-nx", "two.cls", text, plain, setup),
        Job("two-apt", "two.apt", apt, plain, setup),
    ]


def _cell_ways() -> list[Job]:
    """The same pocket where the table stands still, where there is none, and on the arm alone."""
    text = nx(
        "P",
        _CUT + "GOTO/0,0,40,0.0871557427,0,0.9961946981\nFEDRAT/MMPM,420\nGOTO/0,0,0\nGOTO/25,0,1\n"
        "CIRCLE/25,12,1,0,0,-1,12,0.06,0.5,24,0\nGOTO/25,24,1\n"
        "GOTO/0,20,0,0,0.0871557427,0.9961946981\nRAPID\nGOTO/0,20,45\nSPINDL/OFF\n",
    )
    made = []
    for cell in ("still", "no-table", "fixed-arm"):
        place = (40.0, 20.0, 330.0, 25.0, 5.0, 0.0)
        story = started(part_in_base=place).rapid(0, 0, 40, axis=(0.0871557427, 0, 0.9961946981)).cut(420, 0, 0, 0)
        story.cut(420, 25, 0, 1).arc(420, (25, 12, 1), (0, 0, 1), 180)
        story.cut(420, 0, 20, 0, axis=(0, 0.0871557427, 0.9961946981)).rapid(0, 20, 45).event("off")
        made.append(Job(f"cell-{cell}", "cellway.cls", text, story, f"part_in_base = {list(place)}\n", cell=cell))
    return made


def _wave() -> list[tuple[float, float, float]]:
    return [(2.0 * k, round(6 * math.sin(k / 5), 4), round(0.3 * math.cos(k / 3), 4)) for k in range(24)]


def _decimated() -> Job:
    points = _wave()
    body = "".join(f"X{x} Y{y} Z{z}\n" for x, y, z in points[1:])
    text = f"G21 G90\nT1 M6\nS6000 M3\nG0 X0 Y0 Z30\nG1 X0 Y0 Z0.3 F500\n{body}G0 Z30\nM5\nM30\n"
    story = started().rapid(0, 0, 30).follow(500, *points).rapid(points[-1][0], points[-1][1], 30).event("off")
    return Job("decimated", "wave.nc", text, story, PLACE + "decimate_mm = 0.05\n", decimate=0.05)


def _planned() -> Job:
    text = nx(
        "PLAN", _CUT + "GOTO/0,0,40,0,0,1\nFEDRAT/MMPM,500\nGOTO/0,0,0\nGOTO/20,0,0\nRAPID\nGOTO/20,0,40\nSPINDL/OFF\n"
    )
    story = started().rapid(0, 0, 40).cut(500, 0, 0, 0).cut(500, 20, 0, 0).rapid(20, 0, 40).event("off")
    return Job("planned", "plan.cls", text, story, options={"method": "planned"})


def _rows(rows: int) -> tuple[str, Story]:
    """Grooves side by side, the tool drawn back between them."""
    text, story = "G21 G90\nT1 M6\nS6000 M3\n", started()
    for k in range(rows):
        text += f"G0 X0 Y{8 * k} Z30\n" + ("M8\n" if k == 1 else "") + "G1 Z0 F500\nX15\nG4 P0.2\nX30\nG0 Z30\n"
        story.rapid(0, 8 * k, 30)
        if k == 1:
            story.event("wet")
        story.cut(500, 0, 8 * k, 0).cut(500, 15, 8 * k, 0).event("dwell", 0.2).cut(500, 30, 8 * k, 0).rapid(
            30, 8 * k, 30
        )
    story.event("off")
    return text + "M5\nM9\nM30\n", story.event("dry")


def _split() -> Job:
    text, story = _rows(3)
    return Job("split", "grooves.nc", text, story, options={"max_lines": 7})


def _again() -> Job:
    """Posted where a program of the same name in more files lies already."""
    text, story = _rows(2)
    return Job("again", "grooves.nc", text, story, options={}, before="split")


def _no_setup() -> Job:
    text = "G21 G90\nT1 M6\nS6000 M3\nG0 X0 Y0 Z240\nG1 Z210 F500\nX12 Y9\nG0 Z240\nM5\nM30\n"
    story = started(part_in_base=(0, 0, 0, 0, 0, 0)).rapid(0, 0, 240).cut(500, 0, 0, 210).cut(500, 12, 9, 210)
    return Job("no-setup", "bare.nc", text, story.rapid(12, 9, 240).event("off"), None)


def _silent() -> Job:
    """The set-up says what the file does not: units, dialect, feed, spindle speed."""
    text = "PARTNO S\nLOADTL/1\nRAPID\nGOTO/0,0,1.2\nGOTO/0,0,0.1\nGOTO/0.7,0,0.1\nRAPID\nGOTO/0.7,0,1.2\nFINI\n"
    i = 25.4
    story = (
        started(2600)
        .rapid(0, 0, 1.2 * i)
        .cut(330, 0, 0, 0.1 * i)
        .cut(330, 0.7 * i, 0, 0.1 * i)
        .rapid(0.7 * i, 0, 1.2 * i)
    )
    setup = PLACE + 'units = "inch"\ndialect = "apt"\nfeed_mm_min = 330\nspindle_rpm = 2600\nclearance_mm = 30\n'
    return Job("silent-file", "silent.apt", text, story, setup)


def _optimal() -> Job:
    text = nx(
        "FAST",
        _CUT + "GOTO/0,0,40,0,0,1\nFEDRAT/MMPM,9000\nGOTO/0,0,0\nGOTO/60,0,0,0.139173101,0,0.990268069\n"
        "GOTO/60,4,0,0,0,1\nGOTO/0,4,0,0.139173101,0,0.990268069\nRAPID\nGOTO/0,4,40\nSPINDL/OFF\n",
    )
    a = (0.139173101, 0.0, 0.990268069)
    story = started().rapid(0, 0, 40).cut(9000, 0, 0, 0).cut(9000, 60, 0, 0, axis=a).cut(9000, 60, 4, 0, axis=(0, 0, 1))
    story.cut(9000, 0, 4, 0, axis=a).rapid(0, 4, 40).event("off")
    setup = PLACE + "rapid_feed_mm_min = 12000\n"
    return Job("optimal", "fast.cls", text, story, setup, options={"feed": "optimal"}, rapid=12000.0, slower=True)


def _tool_aside() -> Job:
    """One tool of the set-up's own, mounted askew."""
    text = "G21 G90\nT9 M6\nS6000 M3\nG0 X0 Y0 Z40\nG1 Z0 F500\nX14\nY6\nG0 Z40\nM5\nM30\n"
    story = Story(tools={0: ASIDE}).event("change", 9).event("cw", 6000).rapid(0, 0, 40)
    story.follow(500, (0, 0, 0), (14, 0, 0), (14, 6, 0)).rapid(14, 6, 40).event("off")
    return Job(
        "tool-aside", "aside.nc", text, story, PLACE + f'[tool]\nname = "askew"\nflange_to_tool = {list(ASIDE)}\n'
    )


def _repeated() -> Job:
    """Two operations that share a retract point, and points said twice where something changes."""
    text = (
        "PARTNO X\nUNIT/MM\nCUTTER/8.,0,4.,0,0,0,64.\nLOAD/TOOL,17\nSPINDL/4208,RPM,CLW\nTRNTYP/WORLD,0,0,0\n"
        "CSYS/1.,0,0,0,0,1.,0,0,0,0,1.,0\nRAPID/\nGOTO/0,0,25.\nFEDRAT/288.,MMPM\nGOTO/0,0,-2.\n"
        "GOTO/20.,0,-2.\nDELAY/0.5\n"
        "GOTO/20.,0,-2.\nFEDRAT/200.,MMPM\nGOTO/20.,0,-2.\nGOTO/20.,5,-2.\nRAPID/\nGOTO/20.,5,25.\n"
        "SPINDL/4300,RPM,CLW\n"
        "TRNTYP/WORLD,0,0,0\nCSYS/1.,0,0,0,0,1.,0,0,0,0,1.,0\nRAPID/\nGOTO/20.,5,25.\n"
        "FEDRAT/288.,MMPM\nGOTO/20.,5,-3.\n"
        "GOTO/0,0,-3.\nRAPID/\nGOTO/0,0,25.\nFINI\n"
    )
    story = Story().event("change", 17).event("cw", 4208).rapid(0, 0, 25).cut(288, 0, 0, -2).cut(288, 20, 0, -2)
    story.event("dwell", 0.5).cut(200, 20, 5, -2).rapid(20, 5, 25).event("cw", 4300)
    story.cut(288, 20, 5, -3).cut(288, 0, 0, -3).rapid(0, 0, 25)
    return Job("repeated", "twice.apt", text, story)


def _retreat() -> Job:
    """G28: the way goes out of the part where the file left it."""
    text = (
        "%\nG21 G90 G17\nT1 M6\nS3000 M3\nG0 X0 Y0 Z45\nG1 Z2 F300\nX20\nG91 G28 Z0\nG90 G0 X26 Y0\nZ5\n"
        "G1 Z2 F300\nX40\nG91 G28 Z0\nM30\n%\n"
    )
    story = Story().event("change", 1).event("cw", 3000).rapid(0, 0, 45).cut(300, 0, 0, 2).cut(300, 20, 0, 2)
    story.rapid(26, 0, 5).cut(300, 26, 0, 2).cut(300, 40, 0, 2).event("off")
    return Job("retreat", "retreat.nc", text, story)


def _counter() -> Job:
    text = "G21 G90\nT1 M6\nS6000 M4\nG0 X0 Y0 Z40\nG1 Z0 F500\nX14\nG0 Z40\nM5\nM30\n"
    story = Story().event("change", 1).event("ccw", 6000).rapid(0, 0, 40).cut(500, 0, 0, 0).cut(500, 14, 0, 0)
    return Job("counter-clockwise", "counter.nc", text, story.rapid(14, 0, 40).event("off"))


def _sense() -> Job:
    """A tap that begins counter-clockwise."""
    text = nx(
        "TAP",
        "SPINDL/RPM,300,CCLW\nRAPID\nGOTO/0,0,40,0,0,1\nCYCLE/TAP,RAPTO,3.,FEDTO,-10.,MMPM,300.\nGOTO/0,0,0\nCYCLE/OFF\n"
        "RAPID\nGOTO/0,0,40\nSPINDL/OFF\n",
    )
    story = (
        Story().event("change", 1).event("ccw", 300).rapid(0, 0, 40).rapid(0, 0, 3).cut(300, 0, 0, -10).event("cw", 300)
    )
    story.cut(300, 0, 0, 3).event("ccw", 300).rapid(0, 0, 40).event("off")
    return Job("tap-reversed", "reversed.cls", text, story)


def _with_part() -> list[Job]:
    """A part and a stock as boxes: the tool goes about them, collisions are looked for."""
    low, high = (-25.0, -20.0, 0.0), (25.0, 20.0, 30.0)
    setup = PLACE + (
        'clearance_mm = 20\n[tool]\nname = "ball 6"\ndiameter_mm = 6\nlength_mm = 70\n'
        "[part]\nbox_mm = [-25, -20, 0, 25, 20, 30]\n[stock]\nbox_mm = [-26, -21, 0, 26, 21, 31]\n"
    )
    text = (
        "G21 G90\nT1 M6\nS6000 M3\nG0 X-20 Y0 Z60\nG1 Z30.5 F500\nX0\nX20 Y5\nG0 Z60\nG0 X30 Y0\n"
        "G1 Z20 F400\nY10\nG0 Z60\nM5\nM30\n"
    )
    story = started().rapid(-20, 0, 60).follow(500, (-20, 0, 30.5), (0, 0, 30.5), (20, 5, 30.5)).rapid(20, 5, 60)
    story.rapid(30, 0, 60).cut(400, 30, 0, 20).cut(400, 30, 10, 20).rapid(30, 10, 60).event("off")
    part = cells.box(low, high, (0, 0, 200, 0, 0, 0))
    job = Job("with-part", "part.nc", text, story, setup, tool=(6.0, 70.0), part=part)
    return [job, replace(job, name="narrow", cell="narrow")]
