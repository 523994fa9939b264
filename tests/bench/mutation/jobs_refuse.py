"""Jobs of which no program may come: what is released nevertheless is wrong, whatever it is."""

from __future__ import annotations

from mutation.jobs import PLACE, Job
from mutation.jobs_apt import nx

_HEAD = "G21 G90 G17\nT1 M6\nS6000 M3\n"
_CUT = "SPINDL/RPM,6000,CLW\nRAPID\nGOTO/0,0,40,0,0,1\nFEDRAT/MMPM,500\nGOTO/0,0,0\nGOTO/20,0,0\n"
_TOOL = '[tool]\nname = "ball 6"\ndiameter_mm = 6\nlength_mm = 40\n'


def _gcode(name: str, body: str, setup: str | None = PLACE, cell: str = "kr15") -> Job:
    return Job(f"no-{name}", "never.nc", body, setup=setup, cell=cell, refuse=True)


def _cls(name: str, text: str, setup: str | None = PLACE, cell: str = "kr15") -> Job:
    return Job(f"no-{name}", "never.cls", text, setup=setup, cell=cell, refuse=True)


def jobs() -> list[Job]:
    """All jobs of this file."""
    return [*_collisions(), *_reach(), *_process(), *_files()]


def _collisions() -> list[Job]:
    into_table = _HEAD + "G0 X150 Y0 Z20\nG1 Z-45 F300\nX170\nG0 Z20\nM5\nM30\n"
    wall = _HEAD + "G0 X0 Y0 Z90\nG1 Z5 F300\nX10\nG0 Z90\nM5\nM30\n"
    part = PLACE + _TOOL + "[part]\nbox_mm = [-60, -60, 0, 60, 60, 70]\n"
    through = _HEAD + "G0 X-40 Y0 Z60\nG1 Z30.5 F300\nX-38\nG0 X40\nG1 X42 F300\nG0 Z60\nM5\nM30\n"
    ridge = PLACE + _TOOL + "[part]\nbox_mm = [-8, -50, 0, 8, 50, 45]\n"
    floor = nx(
        "LOW",
        "SPINDL/RPM,6000,CLW\nRAPID\nGOTO/420,0,-600,1,0,0\nFEDRAT/MMPM,500\nGOTO/330,0,-600\nRAPID\nGOTO/420,0,-600\n",
    )
    return [
        _gcode("table", into_table, "part_in_base = [0, 0, 0, 0, 0, 0]\n"),  # the tip in the table's disc
        _gcode("wall", wall, part),  # spindle and holder in the block that the tip is deep in
        _gcode("ridge", through, ridge),  # a rapid through a ridge of the part, both ends free
        _gcode("ridge-swept", _HEAD + "G0 X-60 Y0 Z30\nG0 X60\nG1 X62 F300\nG0 Z60\nM30\n", ridge),
        _cls(
            "low", floor, "part_in_base = [0, 0, 0, 0, 0, 0]\n"
        ),  # the arm would have to lie in the floor or the pedestal
    ]


def _reach() -> list[Job]:
    far = _HEAD + "G0 X0 Y0 Z40\nG1 Z0 F300\nX10\nG0 Z40\nM5\nM30\n"
    turn = "SPINDL/RPM,6000,CLW\nRAPID\nGOTO/0,0,60,0,0,1\nFEDRAT/MMPM,500\nGOTO/0,0,0\nGOTO/10,0,0,0,0,-1\nRAPID\nGOTO/10,0,60\n"
    return [
        _gcode("reach", far, "part_in_base = [1500, 4000, 200, 0, 0, 0]\n"),
        _gcode("high", far, "part_in_base = [0, 0, 2600, 0, 0, 0]\n"),
        _gcode("limit", far, "part_in_base = [0, 1100, 200, 0, 0, 0]\n", "narrow-arm"),
        _cls("upside-down", nx("OVER", turn)),
        _cls(
            "singular",
            nx("THROUGH", turn.replace("0,0,-1", "1,0,0")),
            "part_in_base = [350, 0, 800, 0, 0, 0]\n",
            "fixed-arm",
        ),
    ]


def _process() -> list[Job]:
    path = "G0 X0 Y0 Z40\nG1 Z0 F300\nX10\nG0 Z40\nM5\nM30\n"
    plain = "G21 G90 G17\nT1 M6\n"
    setup = PLACE + "[[tool]]\nnumber = 2\n[[tool]]\nnumber = 3\n"
    return [
        _gcode("speed", plain + "S30000 M3\n" + path),
        _gcode("slow", plain + "S20 M3\n" + path),
        _gcode("counter", plain + "S6000 M4\n" + path, cell="one-way"),
        _cls("counter-cls", nx("C", _CUT.replace("CLW", "CCLW") + "RAPID\nGOTO/20,0,40\nSPINDL/OFF\n"), cell="one-way"),
        _cls(
            "tap-one-way",
            nx(
                "T",
                "SPINDL/RPM,300,CLW\nRAPID\nGOTO/0,0,40,0,0,1\nCYCLE/TAP,RAPTO,3.,FEDTO,-10.,MMPM,300.\n"
                "GOTO/0,0,0\nCYCLE/OFF\nRAPID\nGOTO/0,0,40\n",
            ),
            cell="one-way",
        ),
        _gcode("unknown-tool", _HEAD + path, setup),
        _gcode("fast", _HEAD + path.replace("F300", "F30000000")),
        _gcode("still-feed", _HEAD + path.replace("F300", "F0.00001")),
        _gcode("negative-dwell", _HEAD + path.replace("X10\n", "X10\nG4 P-1\n")),
    ]


def _files() -> list[Job]:
    """Files that are cut off, contradict themselves, or ask for what is not read."""
    body = _CUT + "RAPID\nGOTO/20,0,40\nSPINDL/OFF\n"
    whole = nx("F", body)
    path = "G0 X0 Y0 Z40\nG1 Z0 F300\nX10\nG0 Z40\nM5\nM30\n"
    return [
        _cls("cut-off", whole.rsplit("RAPID", 1)[0]),
        _cls("no-feed", whole.replace("FEDRAT/MMPM,500\n", "")),
        _cls(
            "mirrored", nx("F", body, "0,0,0,1,0,0,0,1,0").replace("MSYS/0,0,0,1,0,0,0,1,0", "MSYS/0,0,0,1,0,0,0,2,0")
        ),
        _cls("skew", whole.replace("MSYS/0.0,0.0,0.0,1.0,0.0,0.0,0.0,1.0,0.0", "MSYS/0,0,0,1,0,0,0.5,0.9,0")),
        _cls("short-axis", whole.replace("GOTO/0,0,40,0,0,1", "GOTO/0,0,40,0,0,0.5")),
        _cls(
            "arc-radius", nx("F", _CUT + "CIRCLE/20,10,0,0,0,-1,10,0.06,0.5,20,0\nGOTO/33,10,0\nRAPID\nGOTO/33,10,40\n")
        ),
        _cls("strange", nx("F", _CUT + "MOVETO/25,0,5\nRAPID\nGOTO/20,0,40\n")),
        _cls("bad-number", whole.replace("GOTO/20,0,0", "GOTO/20,0,1e9")),
        _cls(
            "cycle-up",
            nx(
                "F",
                "SPINDL/RPM,900,CLW\nRAPID\nGOTO/0,0,40,0,0,1\nCYCLE/DRILL,RAPTO,3.,FEDTO,9.,MMPM,90.\nGOTO/0,0,0\n"
                "CYCLE/OFF\nRAPID\nGOTO/0,0,40\n",
            ),
        ),
        _gcode("macro", _HEAD + "#100=5\n" + path.replace("X10", "X#101")),
        _gcode("g43-5", _HEAD + "G43.5 I0 J0 K0\n" + path),
        _gcode("two-motions", _HEAD + path.replace("G1 Z0", "G1 G0 Z0")),
        _gcode("no-f", _HEAD + path.replace(" F300", "")),
        _gcode("arc-off", _HEAD + path.replace("X10\n", "G2 X10 Y0 I3 J0\n")),
        _gcode("offset-midway", _HEAD + path.replace("X10\n", "X10\nG92 X0\nX5\n")),
        _gcode("unknown-place", _HEAD + "G0 X0 Y0\nG1 Z0 F300\nX10\nG91 G28 Z0\nG90 G1 X20 F300\nX30 Y5\nM30\n"),
        _gcode("turned", _HEAD + path.replace("X10\n", "X10 A20\n")),
        _gcode("setup-unit", _HEAD + path, "part_in_base = [0, 0, 200000, 0, 0, 0]\n"),
        _gcode("setup-key", _HEAD + path, PLACE + "rapid_mm_min = 500\n"),
        _gcode("setup-box", _HEAD + path, PLACE + "[part]\nbox_mm = [10, 0, 0, 0, 10, 10]\n"),
    ]
