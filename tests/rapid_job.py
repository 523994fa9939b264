"""A job for the RAPID cell with everything that a program of two tools has: an arc, a dwell, coolant, changes, loads."""

from __future__ import annotations

from pathlib import Path

CELL = Path(__file__).resolve().parents[1] / "cells" / "irb6700_table"
PART = """%
G21 G90 G17
T1 M6
S3000 M3
M8
G0 X0 Y0 Z45
G1 Z2 F300
X20
G2 X20 Y20 I0 J10
G4 P1.5
G1 X0
M9
G0 Z50
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
SETUP = """part_in_base = [-100, -50, 200, 0, 0, 0]
[[tool]]
number = 1
name = "mill 10"
flange_to_tool = [165, 0, 405.788, 0, 30, 180]
diameter_mm = 10
length_mm = 80
mass_kg = 38.5
center_of_mass_mm = [40, 0, 180]
[[tool]]
number = 2
name = "ball 6"
flange_to_tool = [152.5, 4, 380, 25, 34, 178]
diameter_mm = 6
length_mm = 40
mass_kg = 37.25
center_of_mass_mm = [38, 0, 172]
"""


def write_job(folder: Path) -> Path:
    """The CL file with its set-up, in a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "setup.toml").write_text(SETUP)
    (folder / "part.nc").write_text(PART)
    return folder / "part.nc"
