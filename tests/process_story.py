"""What a program's text does, as a short story to be compared: motions by their targets, and what stands between them."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from camrob import PostResult, post

ROOT = Path(__file__).resolve().parents[1]
KR15 = ROOT / "cells" / "kr15_track_table"
PLACE = "part_in_base = [0, 0, 198, 0, 0, 0]\n"
PLACED_Z = 198.0
# the second tool is 60 mm shorter, stands askew and turned about its axis
TOOL_FRAMES = ([0.0, -41.763657, 415.577926, 0.0, 0.0, -159.579784], [12.0, -30.0, 355.0, 25.0, 4.0, -150.0])
TWO_TOOLS = """part_in_base = [0, 0, 198, 0, 0, 0]
[[tool]]
number = 1
name = "mill 10"
flange_to_tool = {}
diameter_mm = 10
length_mm = 80
[[tool]]
number = 2
name = "ball 6"
flange_to_tool = {}
diameter_mm = 6
length_mm = 40
""".format(*TOOL_FRAMES)
# two tools; the retract and the stop of the first stand before the change to the second
GCODE = """%
G21 G90 G17
T1 M6
S3000 M3
G0 X0 Y0 Z45
G1 Z2 F300
X20
G0 Z50
M5
T2 M6
S4000 M3
G0 X26 Y0
Z5
G1 Z2 F300
X40
G0 Z50
M5
M30
%
"""

# the first tool, the second, and the first again; a line and an arc
PART = """%
G21 G90 G17
T1 M6
S3000 M3
G0 X0 Y0 Z45
G1 Z2 F300
X20
G2 X20 Y20 I0 J10
G0 Z50
T2 M6
S4000 M3
G0 X26 Y0
Z5
G1 Z2 F300
X40
G0 Z50
T1 M6
S3500 M3
G0 X-26 Y0
G1 Z1 F200
X-40
G0 Z50
M5
M30
%
"""

_TARGET = re.compile(r"X (-?[\d.]+),Y (-?[\d.]+),Z (-?[\d.]+)")


def cell_with(folder: Path, *changes: tuple[str, str], keep_poses: bool = True) -> Path:
    """A copy of the KR15 cell whose cell.toml has some of its lines changed: (pattern, replacement)."""
    cell = folder / "cell"
    shutil.copytree(KR15, cell)
    text = (cell / "cell.toml").read_text()
    for pattern, replacement in changes:
        text, count = re.subn(pattern, replacement, text, count=1, flags=re.M)
        assert count == 1, pattern
    (cell / "cell.toml").write_text(text)
    if not keep_poses:
        (cell / "poses.csv").unlink()
    return cell


def posted(folder: Path, name: str, content: str, *, cell: Path = KR15, setup: str = PLACE, **options) -> PostResult:
    """A small file, posted."""
    source = folder / "in"
    source.mkdir(exist_ok=True)
    (source / name).write_text(content)
    (source / "setup.toml").write_text(setup)
    return post(source / name, cell=cell, out=folder / "out", report=False, **options)


def text_of(made: PostResult) -> str:
    """The text of its main program."""
    return next(made.out.glob("*.src")).read_text()


def story(text: str) -> list[str]:
    """Motions as "X Z" in the part's own frame ("home" for PTP to axes), and hooks of the KR15 cell between them."""
    lines: list[str] = []
    for line in text[text.index(";ENDFOLD (INI)") :].splitlines():
        said = _said(line)
        if said and (not lines or lines[-1] != said or said[0] not in "-0123456789"):
            lines.append(said)
    return lines


def _said(line: str) -> str:
    if line.startswith("PTP {E6AXIS"):
        return "home"
    if line.startswith(("PTP", "LIN")):
        match = _TARGET.search(line)
        assert match is not None
        return f"{float(match[1]):g} {float(match[3]) - PLACED_Z:g}"
    if line.startswith("HALT"):
        return line.partition("to ")[2] or "stop"
    if line.startswith("$ANOUT[1]"):
        return f"speed {line.split()[2]}"
    if line.startswith("WAIT SEC 3.0"):
        return ""
    plain = {
        "$OUT[1] = TRUE": "on",
        "$OUT[1] = FALSE": "off",
        "$OUT[2] = TRUE": "wet",
        "$OUT[2] = FALSE": "dry",
        "$OUT[3] = TRUE": "on, reversed",
    }
    for statement, said in plain.items():
        if line.startswith(statement):
            return said
    if line.startswith("WAIT SEC"):
        return f"wait {float(line.split()[2]):g}"
    return "mount" if line.startswith("$TOOL") else ""
