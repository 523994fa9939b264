"""G-code beside motion: machine positions, tools, spindle, taps, and what is used where the program is silent.

Each case was read wrongly once; points in mm, events as they stand between the motions.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from test_cl_process import codes, course, courses, once

from camrob.errors import ToolpathError
from camrob.toolpath.defaults import Defaults
from camrob.toolpath.gcode.read_gcode import read_gcode
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import EventKind
from camrob.toolpath.toolpath import Toolpath
from camrob.units import mm_min_to_m_s

REPRO = Path(__file__).resolve().parents[4] / "shared" / "repro"
HEAD = "G21 G90\nM3 S3000\n"
DOWN = "G0 X0 Y0 Z5\nG1 Z-3 F60\n"


def read(text: str, **defaults: float) -> Toolpath:
    return read_gcode(
        Path("part.nc"),
        text.encode(),
        units=None,
        chord_tolerance=1e-5,
        angle_tolerance=math.radians(5.0),
        defaults=Defaults(**defaults),
    )


def refused(text: str, line: int, match: str, **defaults: float) -> None:
    with pytest.raises(ToolpathError, match=match) as error:
        read(text, **defaults)
    assert (error.value.line, error.value.path) == (line, Path("part.nc"))
    assert error.value.hint and "\n" not in str(error.value)


# ---- machine positions


def test_a_machine_position_ends_the_region_and_the_next_is_detached() -> None:
    t = read(HEAD + DOWN + "X20\nG91 G28 Z0\nM5\nT2 M6\nM3\nG90 G0 X26 Y0\nZ5\nG1 Z-3\nX40\nG91 G28 Z0\nM30\n")
    assert courses(t) == [
        (0, ["spindle_on 3000 CLW", "0 0 5", "*0 0 -3", "*20 0 -3"]),
        (
            2,
            [
                "detached",
                "spindle_off",
                "tool_change 2",
                "spindle_on 3000 CLW",
                "26 0 5",
                "*26 0 -3",
                "*40 0 -3",
                "spindle_off (retracted)",
            ],
        ),
    ]
    assert codes(t) == [("machine-position", 6, 2)]


@pytest.mark.parametrize(
    ("block", "point"),
    [
        ("G90 G28 Z20", "0 0 20"),
        ("G91 G28 Z8", "0 0 5"),
        ("G91 G28 X10 Z8", "10 0 5"),
        ("G30 P2 Z20", "0 0 20"),
        ("G20 G28 Z1", "0 0 25.4"),
    ],
)
def test_g28_goes_by_way_of_the_point_that_it_names(block: str, point: str) -> None:
    t = read(HEAD + DOWN + block + "\nG21 G90 G0 X50 Y50\nG0 X50 Y50 Z5\nG1 Z-3\nM30\n")
    assert course(t.regions[0])[-1] == point
    assert course(t.regions[1])[:2] == ["detached", "50 50 5"]


def test_only_the_named_axes_are_lost() -> None:
    t = read(HEAD + DOWN + "G91 G28 X0 Y0\nG90 G0 X7\nG0 Z40\nY3\nG1 Z1\nM30\n")
    assert course(t.regions[1])[1:3] == ["7 3 40", "*7 3 1"]
    refused(HEAD + DOWN + "G91 G28 X0 Y0\nG90 G1 X7 Z1\nM30\n", 6, "Y has no known value")
    refused(HEAD + DOWN + "G28\nG90 G1 X7 Y7\nM30\n", 6, "Z has no known value")
    refused(HEAD + DOWN + "G91 G28 Z0\nG0 Z-10\nG1 X1\nM30\n", 7, "Z has no known value")  # still incremental


def test_g53_is_a_machine_position() -> None:
    t = read(HEAD + DOWN + "G53 G0 Z0\nG0 X9 Y9\nG0 Z5\nG1 Z-3\nG53 G0 X-500\nG0 X1\nG1 Z-2\nG53 Z0\nM5\nM30\n")
    assert [course(r)[:2] for r in t.regions[1:]] == [["detached", "9 9 5"], ["detached", "1 9 -3"]]
    assert course(t.regions[-1])[-1] == "spindle_off (retracted)"
    refused(HEAD + DOWN + "G53 G2 X0 Y5 I1\nM30\n", 5, "an arc to a machine position")


def test_nothing_is_detached_where_nothing_was_before() -> None:
    t = read("G21 G90\nG91 G28 Z0\nG90\nM3 S9\n" + DOWN + "G0 Z9\nG0 X3\nG1 Z1\nG0 Z50\nM30\n")
    assert [r.detached for r in t.regions] == [False] and course(t.regions[0])[-1] == "spindle_off"


def test_rapids_that_are_left_out_detach_what_follows() -> None:
    head = "G21 G90 G94\nM428\nM3 S9\nG0 X0 Y0 Z9 A0 C0\nF600\nG1 Z0\nG0 Z50\n"
    t = read(head + "G0 A40\nG0 X100\nG0 A0\nG1 Z0\nM30\n")
    assert [r.detached for r in t.regions] == [False, True]
    assert [r.detached for r in read(head + "G0 A40\nG0 X100\nG1 Z0\nM30\n").regions] == [False, False]


# ---- tools


def test_the_boundary_lies_at_the_change() -> None:
    t = read(
        "G21 G90\nT1 M6\nS3000 M3\nM8\n" + DOWN + "G0 Z50\nM9\nM5\nT2 M6\nS2000 M4\nM7\nG0 X26 Y0\nG1 Z2\nG0 Z50\nM30\n"
    )
    assert courses(t) == [
        (
            1,
            [
                "tool_change 1",
                "spindle_on 3000 CLW",
                "coolant_on",
                "0 0 5",
                "*0 0 -3",
                "0 0 50",
                "coolant_off",
                "spindle_off",
            ],
        ),
        (
            2,
            [
                "tool_change 2",
                "spindle_on 2000 CCLW",
                "coolant_on",
                "26 0 50",
                "*26 0 2",
                "26 0 50",
                "spindle_off",
                "coolant_off",
            ],
        ),
    ]


@pytest.mark.parametrize(
    "change", ["T2 M6", "M6 T2", "T2\nM6", "T2\nM06\nT3", "T2 M6\nM6\nT2 M6", "T9\nT2\nM6", "M5 M9 T2 M6"]
)
def test_a_change_in_all_its_spellings_is_one(change: str) -> None:
    t = read("G21 G90\nT1 M6\nS3000 M3\n" + DOWN + f"G0 Z50\n{change}\nM3\nG0 X1\nG1 Z2\nM30\n")
    last = ["spindle_off"] if "M5" in change else []
    assert courses(t)[0] == (1, ["tool_change 1", "spindle_on 3000 CLW", "0 0 5", "*0 0 -3", "0 0 50", *last])
    assert courses(t)[1] == (2, ["tool_change 2", "spindle_on 3000 CLW", "1 0 50", "*1 0 2", "spindle_off"])


def test_a_change_out_of_a_cut_leaves_the_height_unknown() -> None:
    t = read(HEAD + DOWN + "T2 M6\nM3\nG0 X26 Y0\nZ5\nG1 Z2\nM30\n")
    assert courses(t)[1] == (
        2,
        ["detached", "tool_change 2", "spindle_on 3000 CLW", "26 0 5", "*26 0 2", "spindle_off"],
    )
    refused(HEAD + DOWN + "T2 M6\nM3\nG1 X5\nM30\n", 7, "Z has no known value")


def test_a_change_stops_the_spindle_and_a_speed_alone_does_not_start_it() -> None:
    t = read(HEAD + DOWN + "G0 Z50\nT2 M6\nS4000\nG1 Z2\nM3\nG1 Z1\nM30\n")
    assert courses(t)[1][1] == ["tool_change 2", "0 0 50", "*0 0 2", "spindle_on 4000 CLW", "*0 0 1", "spindle_off"]


def test_t0_puts_the_tool_away() -> None:
    t = read("G21 G90\nT1 M6\nM3 S9\n" + DOWN + "G0 Z50\nM5\nT0 M6\nM30\n")
    assert courses(t)[-1][1][-2:] == ["0 0 50", "spindle_off"] and codes(t) == [("tool-unloaded", 8, 1)]
    refused("G21 G90\nT1 M6\nM3 S9\n" + DOWN + "G0 Z50\nT0 M6\nM3\nG1 Z0\nM30\n", 9, "without a tool.*line 7")
    refused(HEAD + "M61 Q2\n" + DOWN + "M30\n", 3, "M61")


# ---- the spindle


def test_senses_speeds_and_stops() -> None:
    t = read("G21 G90\nM4\nS500\n" + DOWN + "S600\nX1\nM5\nX2\nM3\nX3\nS0\nX4\nS700\nX5\nM13\nX6\nM19 S90\nM30\n")
    assert course(t.regions[0]) == [
        "spindle_on 500 CCLW",
        "0 0 5",
        "*0 0 -3",
        "spindle_on 600 CCLW",
        "*1 0 -3",
        "spindle_off",
        "*2 0 -3",
        "spindle_on 600 CLW",
        "*3 0 -3",
        "spindle_off",
        "*4 0 -3",
        "spindle_on 700 CLW",
        "*5 0 -3",
        "spindle_on 700 CLW",
        "coolant_on",
        "*6 0 -3",
        "spindle_off",
        "coolant_off",
    ]
    refused("G21 G90\nM3 M4 S5\n" + DOWN, 2, "M3 and M4")


def test_a_spindle_without_a_speed() -> None:
    refused("G21 G90\nM3\n" + DOWN + "M30\n", 2, "no S names its speed")
    t = read("G21 G90\nM4\n" + DOWN + "M30\n", spindle_rpm=9000.0)
    assert course(t.regions[0])[0] == "spindle_on 9000 CCLW" and codes(t) == [("spindle-speed-from-setup", 2, 1)]


def test_a_dwell_comes_after_the_spindle_of_its_block() -> None:
    t = read("G21 G90\nG4 P2 M3 S500\n" + DOWN + "G4 X1 F90\nX5\nM30\n")
    assert course(t.regions[0])[:2] == ["spindle_on 500 CLW", "dwell"]
    np.testing.assert_allclose(t.regions[0].feed[1:], [mm_min_to_m_s(60.0), mm_min_to_m_s(90.0)])


@pytest.mark.parametrize(
    ("on", "code", "sense", "other"),
    [("M3", "G84", "CLW", "CCLW"), ("M4", "G74", "CCLW", "CLW"), ("", "G84", "CLW", "CCLW")],
)
def test_taps_reverse_at_the_bottom_and_go_on_forward_at_the_top(on: str, code: str, sense: str, other: str) -> None:
    t = read(f"G21 G90\nS400 {on}\nG0 X0 Y0 Z20\nG98 {code} X1 Y0 Z-10 R2 P1.5 F500\nX2\nG80\nM30\n")
    hole = ["*{} 0 -10", "dwell", f"spindle_on 400 {other}", "*{} 0 2", f"spindle_on 400 {sense}", "{} 0 20"]
    if not on:  # rigid tapping: the cycle starts and stops the spindle by itself
        hole = [f"spindle_on 400 {sense}", *hole[:4], "spindle_off", "{} 0 20"]
    lines = course(t.regions[0])
    assert lines[1 + bool(on) :] == (
        ["1 0 20", "1 0 2", *(h.format(1) for h in hole), "2 0 20", "2 0 2", *(h.format(2) for h in hole)]
        + (["spindle_off"] if on else [])
    )
    assert codes(t) == [("tap-cycle", 4, 2)]


@pytest.mark.parametrize(
    ("on", "block", "match"),
    [
        ("S400 M4", "G84 Z-9 R2", "turning CCLW"),
        ("S400 M3", "G74 Z-9 R2", "turning CLW"),
        ("M5", "G84 Z-9 R2", "without a spindle speed"),
        ("S400 M3", "G84 Z-9 R2 Q1", "by pecks"),
        ("S400 M3", "G84.2 Z-9 R2", "rigid tapping"),
        ("S400 M3", "G33.1 Z-9 K1", "rigid tapping"),
        ("S400 M3", "G63 Z-9", "G63"),
    ],
)
def test_taps_that_can_not_be_done(on: str, block: str, match: str) -> None:
    refused(f"G21 G90\n{on}\nG0 X0 Y0 Z20\nF500 {block}\nM30\n", 4, match)


# ---- what is used where the program is silent


def test_feed_and_spindle_of_the_setup_are_used_and_said_once() -> None:
    t = read("G21 G90\nT1 M6\nG0 X0 Y0 Z5\nG1 Z-3\nX9\nG0 Z50\nT2 M6\nG1 Z2\nM30\n", feed=0.004, spindle_rpm=8000.0)
    assert courses(t) == [
        (1, ["tool_change 1", "spindle_on 8000 CLW", "0 0 5", "*0 0 -3", "*9 0 -3", "9 0 50"]),
        (2, ["tool_change 2", "spindle_on 8000 CLW", "9 0 50", "*9 0 2", "spindle_off"]),
    ]
    assert codes(t) == [("feed-from-setup", 4, 1), ("spindle-from-setup", 4, 1)]
    assert np.nanmin(t.regions[0].feed) == 0.004
    refused("G21 G90\nM3 S9\nG0 X0 Y0 Z5\nG1 Z-3\nM30\n", 4, "without a feed", spindle_rpm=8000.0)


def test_the_setup_overrides_nothing_that_the_program_states() -> None:
    t = read(HEAD + DOWN + "M5\nX1\nM30\n", feed=0.004, spindle_rpm=8000.0)
    assert (
        course(t.regions[0]) == ["spindle_on 3000 CLW", "0 0 5", "*0 0 -3", "spindle_off", "*1 0 -3"] and codes(t) == []
    )
    assert t.regions[0].feed[1] == pytest.approx(0.001)
    t = read("G21 G90\nS700\n" + DOWN + "S800\nX1\nM30\n", spindle_rpm=8000.0)  # S without M3: the speed is its own
    assert course(t.regions[0]) == [
        "spindle_on 700 CLW",
        "0 0 5",
        "*0 0 -3",
        "spindle_on 800 CLW",
        "*1 0 -3",
        "spindle_off",
    ]
    refused(HEAD + "G0 X0 Y0 Z5\nG1 Z0 F0\nM30\n", 4, "without a feed", feed=0.004)
    t = read("G21 G90\nG95\nG0 X0 Y0 Z5\nG1 Z0 F0.1\nM30\n", spindle_rpm=600.0)
    assert t.regions[0].feed[1] == pytest.approx(0.001)


def test_units_that_nobody_named_are_said_first_with_the_width_in_both() -> None:
    t = read("G90\nM3 S9\nM77\nG0 X0 Y0 Z5\nG1 Z-3\nX100\nM30\n", feed=0.001)
    assert codes(t)[:2] == [("units-not-stated", 4, 1), ("feed-from-setup", 5, 1)]
    assert "100.0 mm wide" in t.findings[0].text and "2540.0 mm" in t.findings[0].text


@pytest.mark.parametrize(("feed", "match"), [("0.05", "too slow"), ("0.000001", "too slow"), ("180001", "faster than")])
def test_feeds_that_nothing_moves_with(feed: str, match: str) -> None:
    refused(HEAD + f"G0 X0 Y0 Z5\nG1 Z0 F{feed}\nM30\n", 4, match)
    refused(HEAD + "G0 X0 Y0 Z5\nG93 G1 Z0 F100000\nM30\n", 4, "faster than")


# ---- codes that may not be skipped


@pytest.mark.parametrize(
    "block",
    [
        "M21",
        "M22",
        "M23",
        "G112",
        "G12.1",
        "G107 A0 R9",
        "G7.1 C9",
        "G54.2 P1",
        "G54.4 P1",
        "G43.1 Z9",
        "G50 X0 Z0",
        "G1 X5 R2",
        "G1 X5 K1",
    ],
)
def test_codes_that_would_make_another_part(block: str) -> None:
    refused(HEAD + DOWN + block + "\nX7\nM30\n", 5, "is not read|not done|straight cut")


def test_the_end_of_a_mirror_is_no_move() -> None:
    assert course(read(HEAD + DOWN + "G50.1 X0 Y0\nX7\nM30\n").regions[0])[2:4] == ["*0 0 -3", "*7 0 -3"]


# ---- a point that is repeated, and the files that came out wrong


SAMPLE = (
    "G21 G90 G54\nT1 M6\nS3000 M3\nG0 X0 Y0 Z45\nG1 Z2 F300\nM8\nX20\nF500\nY5\nG4 P1\nG3 X25 Y10 I5 J0\nG0 Z50\nS4000\n"
    "G0 X26 Y0\nG91 G28 Z0\nM5\nG90\nT2 M6\nM4\nG0 X26 Y0\nZ5\nG1 Z2\nG53 G0 Z0\nG0 X1 Y1 Z9\nG1 Z1\nM9\nX40\nG53 G0 Z0\nM30\n"
)


def test_a_repeated_block_changes_no_motion_and_moves_no_event() -> None:
    lines = SAMPLE.splitlines(keepends=True)
    want = [once(r) for r in read(SAMPLE).regions]
    assert len(want) == 3
    for n, line in enumerate(lines):
        if line[0] in "XYZG" and set("XYZ") & set(line) and not line.startswith(("G3", "G91")):
            text = "".join([*lines[: n + 1], line, *lines[n + 1 :]])
            assert [once(r) for r in read(text).regions] == want, line


def test_the_pockets_with_a_wall_between_them() -> None:
    if not REPRO.is_dir():
        pytest.skip("../shared is not here: the small files that came out wrong")
    first, second = read_toolpath(REPRO / "g1.nc").regions
    assert course(first)[-2:] == ["*20 0 2", "20.5 0 2"]
    assert course(second)[:4] == ["detached", "tool_change 2", "spindle_on 3000 CLW", "26 0 5"]
    assert course(second)[-1] == "spindle_off (retracted)"


def test_a_dwell_of_no_time_is_none(tmp_path: Path) -> None:
    """G4 P0 keeps a control from rounding the corner (LinuxCNC, G64): nothing waits."""
    file = tmp_path / "dwell.ngc"
    file.write_text("G21 G90\nS900 M3\nG0 X0 Y0 Z5\nG1 Z0 F100\nG4 P0\nX5\nG4 P0.5\nX9\nG0 Z5\nM2\n")
    events = [event for region in read_toolpath(file).regions for event in region.events]
    assert [event.value for event in events if event.kind is EventKind.DWELL] == [0.5]
