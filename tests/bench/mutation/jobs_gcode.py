"""Jobs in G-code: three axes, cycles, planes, five axes, tilted planes."""

from __future__ import annotations

import math
from collections.abc import Callable

from mutation.jobs import PLACE, Job
from mutation.story import Story, Triple


def jobs() -> list[Job]:
    """All jobs of this file."""
    return [
        _pocket(),
        _planes(),
        _cycles(),
        _more_cycles(),
        _inch(),
        _table("xyzac"),
        _table("xyzbc"),
        _tilted(),
        _machine_axes(),
        _inverse_time(),
        _shifted(),
    ]


def _pocket() -> Job:
    text = (
        "%\nO0001 (POCKET)\nG21 G90 G17 G94\nT3 M6\nS8000 M3\nG0 X0 Y0 Z40\nM8\nZ5\nG1 Z-1 F240\nX20 F600\n"
        "G3 X25 Y5 I0 J5\nG1 Y15\nG2 X35 Y25 R10\nG4 P0.8\nG91 G1 X5 Y-2\nG90 X30\nM9\n"
        "(MSG, look at the chips)\nG0 Z40\nM5\nM30\n%\n"
    )
    story = Story().event("change", 3).event("cw", 8000).rapid(0, 0, 40).event("wet").rapid(0, 0, 5)
    story.cut(240, 0, 0, -1).cut(600, 20, 0, -1).arc(600, (20, 5, -1), (0, 0, 1), 90).cut(600, 25, 15, -1)
    story.arc(600, (35, 15, -1), (0, 0, 1), -90).event("dwell", 0.8).cut(600, 40, 23, -1).cut(600, 30, 23, -1)
    story.event("dry").rapid(30, 23, 40).event("off")
    return Job("gc-pocket", "pocket.nc", text, story)


def _planes() -> Job:
    """Arcs across G18 and G19, a helix, and a full circle."""
    text = (
        "G21 G90 G17\nT1 M6\nS5000 M3\nG0 X0 Y0 Z30\nG1 Z0 F400\nG18 G2 X10 Z0 I5 K0\n"
        "G19 G3 Y10 Z0 J5 K0\nG17 G3 X0 Y20 I-10 J0 Z-1\n"
        "G2 I5\nG0 Z30\nM5\nM2\n"
    )
    story = Story(part_in_base=(10, 5, 210, 20, 0, 0)).event("change", 1).event("cw", 5000).rapid(0, 0, 30)
    # G18 is the plane Z-X seen from +Y: G2 is clockwise there, which takes the arc through -Z
    story.cut(400, 0, 0, 0).arc(400, (5, 0, 0), (0, 1, 0), -180).arc(400, (10, 5, 0), (1, 0, 0), 180)
    story.arc(400, (0, 10, 0), (0, 0, 1), 90, rise=-1, slack=0.02)
    story.arc(400, (5, 20, -1), (0, 0, 1), -360).rapid(0, 20, 30).event("off")
    setup = "part_in_base = [10, 5, 210, 20, 0, 0]\nchord_tolerance_mm = 0.02\n"
    return Job("gc-planes", "planes.nc", text, story, setup)


def _drilled(story: Story, x: float, y: float, back: float, feed: float = 120, bottom: float = -6) -> Story:
    return story.rapid(x, y, 2).cut(feed, x, y, bottom).rapid(x, y, back)


def _cycles() -> Job:
    text = (
        "G21 G90 G17 G94\nT5 M6\nS1500 M3\nG0 X0 Y0 Z25\nG98 G81 X5 Y0 Z-6 R2 F120\nX15\n"
        "G99 G83 Y8 Z-8 Q4 F100\nG82 X5 Z-6 P0.4 F120\nG80\n"
        "G0 Z25\nM5\nM30\n"
    )
    story = Story().event("change", 5).event("cw", 1500).rapid(0, 0, 25).rapid(5, 0, 25)
    _drilled(story, 5, 0, 25).rapid(15, 0, 25)
    _drilled(story, 15, 0, 25).rapid(15, 8, 25).rapid(15, 8, 2).cut(100, 15, 8, -2).rapid(15, 8, 2)
    story.rapid(15, 8, -1.746).cut(100, 15, 8, -6, open=0.254).rapid(15, 8, 2).rapid(15, 8, -5.746)
    story.cut(100, 15, 8, -8, open=0.254).rapid(15, 8, 2)
    story.rapid(5, 8, 2).cut(120, 5, 8, -6).event("dwell", 0.4).rapid(5, 8, 2).rapid(5, 8, 25).event("off")
    return Job("gc-cycles", "cycles.nc", text, story)


def _more_cycles() -> Job:
    text = (
        "G21 G90 G17\nT5 M6\nS1500 M3\nG0 X0 Y0 Z25\nG99 G73 X0 Y0 Z-5 R2 Q3 F90\n"
        "G80\nG91 G81 X6 Z-7 R0 L2 F80\nG90\nG85 X20 Z-4 R2 F70\n"
        "G98 G86 X20 Y10 Z-4 R2 P0.3\nG80 G0 Z25\nM5\nM30\n"
    )
    story = Story().event("change", 5).event("cw", 1500).rapid(0, 0, 25).rapid(0, 0, 2).cut(90, 0, 0, -1)
    story.rapid(0, 0, -0.746).cut(90, 0, 0, -4, open=0.254).rapid(0, 0, -3.746).cut(90, 0, 0, -5, open=0.254).rapid(
        0, 0, 2
    )
    for x in (6, 12):
        story.rapid(x, 0, 2).cut(80, x, 0, -5).rapid(x, 0, 2)
    story.rapid(20, 0, 2).cut(70, 20, 0, -4).cut(70, 20, 0, 2)
    story.rapid(20, 10, 2).cut(70, 20, 10, -4).event("dwell", 0.3).event("off").rapid(20, 10, 2).event("cw", 1500)
    story.rapid(20, 10, 25).event("off")
    return Job("gc-more-cycles", "more.nc", text, story)


def _inch() -> Job:
    text = (
        "G20 G90 G17 G95\nT2 M6\nS2000 M3\nG0 X0 Y0 Z1.2\nG1 Z-0.05 F0.004\nX0.6\nG94 Y0.4 F9\nS2400\n"
        "X0 Y0.2\nG0 Z1.2\nM5\nM30\n"
    )
    i = 25.4
    story = Story().event("change", 2).event("cw", 2000).rapid(0, 0, 1.2 * i)
    story.cut(8 * i, 0, 0, -0.05 * i).cut(8 * i, 0.6 * i, 0, -0.05 * i).cut(9 * i, 0.6 * i, 0.4 * i, -0.05 * i)
    story.event("cw", 2400).cut(9 * i, 0, 0.2 * i, -0.05 * i).rapid(0, 0.2 * i, 1.2 * i).event("off")
    return Job("gc-inch", "inch.nc", text, story)


def _leaning(kind: str, tilt: float, turn: float) -> Triple:
    """The tool in the part on a table that tilts about x (or y) and turns about z."""
    t, c = math.radians(tilt), math.radians(turn)
    if kind == "xyzac":
        return (math.sin(t) * math.sin(c), math.sin(t) * math.cos(c), math.cos(t))
    return (-math.sin(t) * math.cos(c), math.sin(t) * math.sin(c), math.cos(t))


def _swung(kind: str, start: tuple[float, float], end: tuple[float, float]) -> Callable[[float], Triple]:
    return lambda s: _leaning(kind, start[0] + s * (end[0] - start[0]), start[1] + s * (end[1] - start[1]))


def _table(kind: str) -> Job:
    """Five axes with the tool centre point on: rotary words in proportion to the way of the tip."""
    letter = kind[3].upper()
    on, off = ("M428", "M429") if kind == "xyzac" else ("G43.4 H1", "G49")
    text = (
        f"G21 G90 G94\nT1 M6\nS7000 M3\n{on}\nG0 X0 Y0 Z30 {letter}0 C0\nG1 Z1 F500\n"
        f"X12 Y3 Z2 {letter}12 C20\nX20 {letter}12 C60\n"
        f"Y10 {letter}20 C60\nG0 Z40\n{off}\nM5\nM30\n"
    )
    story = (
        Story(part_in_base=(-20, 10, 195, 15, 0, 0))
        .event("change", 1)
        .event("cw", 7000)
        .rapid(0, 0, 30)
        .cut(500, 0, 0, 1)
    )
    stops = [
        ((0.0, 0.0), (12.0, 20.0), (12, 3, 2)),
        ((12, 20), (12, 60), (20, 3, 2)),
        ((12, 60), (20, 60), (20, 10, 2)),
    ]
    for before, after, tip in stops:
        story.swing(500, tip, _swung(kind, before, after), slack=0.001)
    story.rapid(20, 10, 40).event("off")
    setup = f'part_in_base = [-20, 10, 195, 15, 0, 0]\ndialect = "gcode-{kind}"\n'
    return Job(f"gc-{kind}", f"{kind}.nc", text, story, setup)


def _tilted() -> Job:
    """A plane turned by Euler angles 313 (Z, X', Z''), a pocket and a hole in it."""
    text = (
        "G21 G90 G94 G17\nT1 M6\nS6000 M3\nG0 X0 Y0 Z60\nG1 Z40 F500\nX8\nG0 Z60\n"
        "G68.2 X20 Y0 Z30 I90 J20 K0\nG53.1\nG0 X0 Y0 Z30\n"
        "G1 Z0 F300\nX10\nG2 X15 Y5 I0 J5\nG0 Z30\nG81 X0 Y10 Z-3 R2 F100\nG80\nG0 Z40\nG69\nM5\nM30\n"
    )
    story = Story().event("change", 1).event("cw", 6000).rapid(0, 0, 60).cut(500, 0, 0, 40).cut(500, 8, 0, 40)
    story.rapid(8, 0, 60).use((20, 0, 30, 90, 0, 20)).rapid(0, 0, 30, axis=(0, 0, 1)).cut(300, 0, 0, 0)
    # the chord from (10, 0) to (15, 5) about (10, 5): clockwise the long way round
    story.cut(300, 10, 0, 0).arc(300, (10, 5, 0), (0, 0, 1), -270).rapid(15, 5, 30)
    story.rapid(0, 10, 30).rapid(0, 10, 2).cut(100, 0, 10, -3).rapid(0, 10, 30).rapid(0, 10, 40).event("off")
    return Job("gc-tilted", "tilted.nc", text, story)


def _machine_axes() -> Job:
    """A machine's own axes: a table that stands turned about a line 20 mm below the program's zero."""
    text = (
        "G21 G90 G94 G17\nT1 M6\nS6000 M3\nG0 X0 Y0 Z40 A30.\nG1 Z0 F500\nX12\nG2 X17 Y5 I0 J5\nG0 Z30\n"
        "G81 X0 Y10 Z-3 R2 F100\nG80\nG0 Z40\nM5\nM30\n"
    )
    t = math.radians(30.0)  # the part sees the program's frame turned by it about X, through (0, 0, -20)
    story = Story().event("change", 1).event("cw", 6000)
    story.use((0, -20 * math.sin(t), -20 + 20 * math.cos(t), 0, 0, 30)).rapid(0, 0, 40, axis=(0, 0, 1)).cut(
        500, 0, 0, 0
    )
    story.cut(500, 12, 0, 0).arc(500, (12, 5, 0), (0, 0, 1), -270).rapid(17, 5, 30)
    story.rapid(0, 10, 30).rapid(0, 10, 2).cut(100, 0, 10, -3).rapid(0, 10, 30).rapid(0, 10, 40).event("off")
    mill = '[[table]]\nword = "A"\ndirection = [-1, 0, 0]\npoint_mm = [0, 0, -20]\n'
    return Job("gc-machine", "machine.nc", text, story, 'machine = "mill.toml"\n' + PLACE, beside={"mill.toml": mill})


def _inverse_time() -> Job:
    """G93: a block takes 1/F minutes."""
    text = (
        "G21 G90 G17\nT1 M6\nS5000 M3\nG0 X0 Y0 Z30\nG93 G1 Z0 F10\nX20 F20\nG2 X30 Y10 I10 J0 F25\nG94\n"
        "G1 X40 F333\nG0 Z30\nM5\nM30\n"
    )
    story = Story().event("change", 1).event("cw", 5000).rapid(0, 0, 30).cut(300, 0, 0, 0).cut(400, 20, 0, 0)
    # from (20, 0) about (30, 0) clockwise to (30, 10): a quarter, 15.708 mm
    story.arc(25 * 10 * math.pi / 2, (30, 0, 0), (0, 0, 1), -90).cut(333, 40, 10, 0).rapid(40, 10, 30).event("off")
    return Job("gc-g93", "inverse.nc", text, story)


def _shifted() -> Job:
    """G52, G54, block skip, optional stop, S before M3, and a rapid feed of the set-up's."""
    text = (
        "G21 G90 G17 G54\nT1 M6\nS4000\nM3\nG0 X0 Y0 Z30\nG1 Z0 F350\nX10\nG0 Z30\nM1\nG52 X5 Y20\n"
        "G0 X0 Y0\nG1 Z0\n/X10\nG0 Z30\nG52 X0 Y0\n"
        "M0\nG0 X0 Y0\nG1 Z-1\nY5\nG0 Z30\nM30\n"
    )
    story = Story().event("change", 1).event("cw", 4000).rapid(0, 0, 30).cut(350, 0, 0, 0).cut(350, 10, 0, 0)
    story.rapid(10, 0, 30).event("halt").rapid(5, 20, 30).cut(350, 5, 20, 0).cut(350, 15, 20, 0).rapid(15, 20, 30)
    story.event("halt").rapid(0, 0, 30).cut(350, 0, 0, -1).cut(350, 0, 5, -1).rapid(0, 5, 30).event("off")
    setup = "part_in_base = [0, 0, 200, 0, 0, 0]\nrapid_feed_mm_min = 4800\n"
    return Job("gc-shifted", "shifted.nc", text, story, setup, rapid=4800.0)
