"""Small jobs of our own making, posted once: their programs are what the faults are drawn on.

Lengths in mm, angles in degrees, as in the files. `part` lies in `base` as each job's `place` says.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
CELL = ROOT / "cells" / "kr15_track_table"
PLACE = "part_in_base = [0, 0, 198, 0, 0, 0]\n"
LONG = [0, -41.763657, 415.577926, 0, 0, -159.579784]
SHORT = [0, -41.763657, 390.577926, 0, 0, -159.579784]


@dataclass(frozen=True)
class Job:
    """A CL file with its set-up. options: of `post`. top: Z of the file's highest point in `base`, mm."""

    name: str
    file: str
    text: str
    top: float
    setup: str = PLACE
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def program(self) -> str:
        """Name of the program that comes out."""
        return self.file.split(".")[0]


@dataclass(frozen=True)
class Posted:
    """A job's program as it was posted: names to texts, and where its CL file lies."""

    job: Job
    clfile: Path
    files: Mapping[str, str]


def post_all(folder: Path, names: list[str] | None = None) -> dict[str, Posted]:
    """Post the jobs (those named, else all) into a folder. Raises what `post` raises."""
    from camrob import post

    posted = {}
    for job in JOBS:
        if names is not None and job.name not in names:
            continue
        here = folder / "jobs" / job.name
        here.mkdir(parents=True, exist_ok=True)
        clfile = here / job.file
        clfile.write_text(job.text, encoding="utf-8")
        (here / "setup.toml").write_text(job.setup, encoding="utf-8")
        out = folder / "posted" / job.name
        post(clfile, cell=CELL, out=out, report=False, **job.options)
        files = {f.name: f.read_bytes().decode("ascii") for f in sorted(out.iterdir()) if f.suffix in (".src", ".dat")}
        posted[job.name] = Posted(job, clfile, files)
    return posted


def _operation(name: str, body: str) -> str:
    head = f"TOOL PATH/{name},TOOL,EM_8\nTLDATA/MILL,8.0,0.0,75.0,0.0,0.0\n"
    msys = "MSYS/0.0,0.0,0.0,1.0,0.0,0.0,0.0,1.0,0.0\nPAINT/PATH\n"
    return f"{head}{msys}{body}PAINT/TOOL,NOMORE\nEND-OF-PATH\n"


def _arcs() -> Job:
    """Two operations in the plane: lines and arcs at two feeds, coolant, a dwell in the cut."""
    contour = (
        "LOAD/TOOL,1\nSPINDL/RPM,8000,CLW\nCOOLNT/ON\nRAPID\nGOTO/-25.0,-10.0,45.0,0.0,0.0,1.0\nRAPID\nGOTO/-25.0,-10.0,6.0\n"
        "FEDRAT/MMPM,300.0\nGOTO/-25.0,-10.0,2.0\nFEDRAT/MMPM,900.0\nGOTO/13.5,-10.0,2.0\n"
        "CIRCLE/13.5,1.5,2.0,0.0,0.0,-1.0,11.5,0.06,0.5,8.0,0.0\nGOTO/25.0,1.5,2.0\nGOTO/25.0,14.0,2.0\n"
        "DELAY/0.8\nGOTO/3.25,17.5,2.0\nGOTO/-12.5,12.25,2.0\nCOOLNT/OFF\nRAPID\nGOTO/-12.5,12.25,45.0\n"
    )
    slot = (
        "RAPID\nGOTO/-20.0,-24.0,45.0,0.0,0.0,1.0\nRAPID\nGOTO/-20.0,-24.0,5.0\nFEDRAT/MMPM,250.0\nGOTO/-20.0,-24.0,1.0\n"
        "FEDRAT/MMPM,600.0\nGOTO/-2.5,-31.0,1.0\nCIRCLE/6.0,-31.0,1.0,0.0,0.0,1.0,8.5,0.06,0.5,8.0,0.0\n"
        "GOTO/14.5,-31.0,1.0\nGOTO/30.0,-22.5,1.5\nRAPID\nGOTO/30.0,-22.5,45.0\nSPINDL/OFF\n"
    )
    return Job("arcs", "contour.cls", _operation("CONTOUR", contour) + _operation("SLOT", slot), 243.0)


def _two_tools() -> Job:
    """Two tools in G-code, each with its own `$TOOL`."""
    text = (
        "%\nG21 G90 G17\nT1 M6\nS5000 M3\nG0 X-18 Y4 Z45\nZ6\nG1 Z2 F300\nX11 Y7.5 F700\nG3 X17 Y13.5 I0 J6\nG1 Y22\nG0 Z50\nM5\n"
        "T2 M6\nS9000 M3\nM8\nG0 X30 Y-9\nZ5\nG1 Z1.5 F240\nX42.5 F520\nG4 P0.5\nX42.5 Y-20\nG0 Z50\nM9\nM5\nM30\n%\n"
    )
    tools = "".join(
        f'[[tool]]\nnumber = {number}\nname = "tool {number}"\nflange_to_tool = {frame}\ndiameter_mm = 8\nlength_mm = {length}\n'
        for number, frame, length in ((1, LONG, 75), (2, SHORT, 60))
    )
    return Job("tools", "twotools.nc", text, 248.0, PLACE + tools)


def _drilling() -> Job:
    """Drilling with a dwell in the holes, coolant, a stop, and a second spindle speed."""
    text = (
        "PARTNO HOLES\nUNITS/MM\nLOADTL/3\nSPINDL/2400,RPM,CLW\nCOOLNT/FLOOD\nRAPID\nGOTO/-30.0,-12.0,45.0\n"
        "CYCLE/DRILL,16.0,MMPM,180.0,3.0,DWELL,0.4\nGOTO/-30.0,-12.0,20.0\nGOTO/-3.5,-16.0,20.0\nGOTO/21.0,5.5,22.0\nCYCLE/OFF\n"
        "RAPID\nGOTO/21.0,5.5,45.0\nCOOLNT/OFF\nSTOP\nSPINDL/3600,RPM,CLW\nRAPID\nGOTO/-8.0,24.0,45.0\nFEDRAT/420.0,MMPM\n"
        "GOTO/-8.0,24.0,14.0\nGOTO/12.0,28.0,14.0\nRAPID\nGOTO/12.0,28.0,45.0\nSPINDL/OFF\nFINI\n"
    )
    return Job("holes", "holes.apt", text, 243.0)


def _tilted() -> Job:
    """Five axes at once: the tool leans while it cuts. The file never stops the spindle, the cell's footer does."""
    body = "LOAD/TOOL,4\nSPINDL/RPM,12000,CLW\nRAPID\nGOTO/-24.0,3.0,50.0,0.0,0.0,1.0\nFEDRAT/MMPM,800.0\n"
    for k, (about_y, about_x) in enumerate(((0, 0), (5, 3), (9, 7), (14, 8), (19, 4), (15, -5), (8, -9), (2, -4))):
        i, j = math.sin(math.radians(about_y)), math.sin(math.radians(about_x))
        axis = f"{i:.9f},{j:.9f},{math.sqrt(1 - i * i - j * j):.9f}"
        body += f"GOTO/{-24 + 6.5 * k:.4f},{3 + 2.2 * math.sin(k):.4f},{4 + 0.8 * k:.4f},{axis}\n"
    body += "GOTO/26.0,6.0,9.6,0.0,0.173648178,0.984807753\nCIRCLE/26.0,14.0,9.6,0.0,0.0,-1.0,8.0,0.06,0.5,8.0,0.0\n"
    body += "GOTO/34.0,14.0,9.6\nRAPID\nGOTO/34.0,14.0,55.0\n"
    return Job("tilted", "tilted.cls", _operation("LEAN", body), 253.0)


def _turning() -> Job:
    """A cut around an upright wall: the tool leans by 80 degrees and goes round, so that the table turns; planned."""
    c, s = math.cos(math.radians(80)), math.sin(math.radians(80))

    def at(turn: float, away: float) -> str:
        x, y = math.cos(math.radians(turn)), math.sin(math.radians(turn))
        return f"GOTO/{(40 + away * s) * x:.4f},{(40 + away * s) * y:.4f},{30 + away * c:.4f},{s * x:.9f},{s * y:.9f},{c:.9f}\n"

    body = "LOAD/TOOL,5\nSPINDL/RPM,10000,CLW\nRAPID\n" + at(-90, 60) + "FEDRAT/MMPM,1500.0\n"
    body += "".join(at(20 * k - 90, 0) for k in range(13)) + "RAPID\n" + at(150, 60) + "SPINDL/OFF\n"
    place = "part_in_base = [0, 0, 398, 0, 0, 0]\n"
    return Job("turning", "around.cls", _operation("AROUND", body), 438.5, place, {"method": "planned"})


def _split() -> Job:
    """Grooves, too many motions for one file."""
    text = "G21 G90\nT6 M6\nS7000 M3\n"
    for k in range(4):
        text += f"G0 X{-15 + k} Y{9 * k - 12} Z35\n" + ("M8\n" if k == 1 else "")
        text += f"Z5\nG1 Z{1 + 0.25 * k} F350\nX12 Y{9 * k - 10} F800\nX{24 + k} Y{9 * k - 12.5}\nG0 Z35\n"
    return Job("split", "grooves.nc", text + "M9\nM5\nM30\n", 233.0, options={"max_lines": 9})


JOBS: tuple[Job, ...] = (_arcs(), _two_tools(), _drilling(), _tilted(), _turning(), _split())
