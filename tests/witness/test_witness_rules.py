"""The witness's rules, each on both sides: what it lets pass, and what it is there for."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from witness_stories import (
    FEED,
    OFF,
    ON,
    OTHER_TOOL,
    RAPID,
    TOOL,
    circ,
    feed,
    file,
    hole,
    judged,
    lin,
    load,
    program,
    ptp,
    rapid,
)

from camrob.units import deg_to_rad
from camrob.witness.happenings import Kind
from camrob.witness.rules.rules_geometry import Clear

# a groove from (0, 0) to (20, 0) at Z 2, and the program for it
GROOVE = (ON, rapid(0, 0, 25), feed(0, 0, 2), feed(20, 0, 2), rapid(20, 0, 25), OFF)
START = (ptp(), ON, ptp(0, 0, 60), lin(0, 0, 25, at=RAPID))
CUT = (lin(0, 0, 2), lin(20, 0, 2))
END = (lin(20, 0, 25, at=RAPID), OFF, lin(20, 0, 60, at=RAPID), ptp())


def codes(story, run, **terms) -> list[str]:
    return sorted({o.code for o in judged(story, run, **terms).objections})


def groove(*cut, start=START, end=END, **terms) -> list[str]:
    """What is said of a program that makes the groove with `cut`."""
    return codes(file(*GROOVE), program(*start, *cut, *end), **terms)


def test_the_groove_is_right_and_all_of_it_is_judged() -> None:
    found = judged(file(*GROOVE), program(*START, *CUT, *END))
    assert found.objections == [] and found.unjudged == []
    assert (found.met, found.met_events) == (4, 2)


def test_the_part_stands_where_the_setup_says() -> None:
    """Placed by base_T_part: the same program is wrong for a part that lies elsewhere, and right where it is shifted along."""
    moved = np.eye(4)
    moved[:3, 3] = 0.01, 0.0, 0.003
    assert groove(*CUT, base_T_part=moved) != []
    shifted = [
        {**m, "tip": (m["tip"][0] + 10, m["tip"][1], m["tip"][2] + 3)}
        if isinstance(m, dict) and not m.get("home")
        else m
        for m in (*START, *CUT, *END)
    ]
    assert codes(file(*GROOVE), program(*shifted), base_T_part=moved) == []


# --- the path ---------------------------------------------------------------------------------------------------------

TILTED = (0.0, math.sin(deg_to_rad(0.02)), math.cos(deg_to_rad(0.02)))


@pytest.mark.parametrize("begins", [False, True])
def test_a_rapid_to_another_side_of_the_part_is_taken_at_its_word_within_an_operation_only(begins: bool) -> None:
    """Between two operations the straight line from a groove's end to a groove on the side goes through the part."""
    side, tilted = (1.0, 0.0, 0.0), (0.7071, 0.0, 0.7071)
    both = file(
        *GROOVE[:-2],
        rapid(50, 0, -10, axis=side, begins=begins),
        feed(20, 0, -10, axis=side),
        feed(20, 9, -10, axis=side),
        rapid(50, 9, -10, axis=side),
        OFF,
    )
    cut = (
        lin(20, 0, -10, axis=side),
        lin(20, 9, -10, axis=side),
        lin(50, 9, -10, axis=side, at=RAPID),
        OFF,
        lin(90, 9, -10, axis=side, at=RAPID),
        ptp(),
    )
    straight = (lin(50, 0, -10, axis=side, at=RAPID),)
    around = (
        lin(20, 0, 60, at=RAPID),
        lin(120, 0, 120, axis=tilted, at=RAPID),
        lin(120, 0, -10, axis=side, at=RAPID),
        lin(50, 0, -10, axis=side, at=RAPID),
    )
    assert codes(both, program(*START, *CUT, *around, *cut)) == []
    assert codes(both, program(*START, *CUT, *straight, *cut)) == (["off-path"] if begins else [])


PATHS_RIGHT = {
    "in two pieces": (lin(0, 0, 2), lin(7, 0, 2), lin(20, 0, 2)),
    "a rounding off": (lin(0, 0, 2), lin(20, 0.009, 2)),
    "tool turned about itself on the way": (lin(0, 0, 2), lin(0, 0, 2), lin(20, 0, 2)),
    "left along the axis and re-entered": (
        lin(0, 0, 2),
        lin(7, 0, 2),
        lin(7, 0, 60, at=RAPID),
        ptp(9, 9, 70),
        lin(7, 0, 60, at=RAPID),
        lin(7, 0, 5, at=RAPID),
        lin(7, 0, 2),
        lin(20, 0, 2),
    ),
    "out and back on the spot": (lin(0, 0, 2), lin(7, 0, 2), lin(7, 0, 12, at=RAPID), lin(7, 0, 2), lin(20, 0, 2)),
}
PATHS_WRONG = {
    "off the line at the end": (lin(0, 0, 2), lin(20, 0.012, 2)),
    "off the line between": (lin(0, 0, 2), lin(7, 0.012, 2), lin(20, 0, 2)),
    "a point left out": (lin(20, 0, 2),),
    "a point moved": (lin(0, 0, 2), lin(20, 0, 1.9)),
    "an arc for a line": (lin(0, 0, 2), circ(20, 0, 2, center=(10, 0, 2), turn=180)),
    "backwards on the way": (lin(0, 0, 2), lin(9, 0, 2), lin(7, 0, 2), lin(20, 0, 2)),
    "the tool tilted": (lin(0, 0, 2, axis=TILTED), lin(20, 0, 2, axis=TILTED)),
    "beyond and back": (lin(0, 0, 2), lin(21, 0, 2), lin(20, 0, 2)),
    "sideways out of the part": (
        lin(0, 0, 2),
        lin(7, 0, 2),
        lin(9, 0, 60, at=RAPID),
        lin(7, 0, 60, at=RAPID),
        lin(7, 0, 2),
        lin(20, 0, 2),
    ),
    "sideways into the part": (
        lin(0, 0, 2),
        lin(7, 0, 2),
        lin(7, 0, 60, at=RAPID),
        lin(9, 0, 60, at=RAPID),
        lin(7, 0, 2),
        lin(20, 0, 2),
    ),
    "not far enough out": (
        lin(0, 0, 2),
        lin(7, 0, 2),
        lin(7, 0, 12, at=RAPID),
        lin(7, 5, 12, at=RAPID),
        lin(7, 0, 12, at=RAPID),
        lin(7, 0, 2),
        lin(20, 0, 2),
    ),
    "point to point in the part": (lin(0, 0, 2), ptp(20, 0, 2)),
    "doubled": (lin(0, 0, 2), lin(20, 0, 2), lin(0, 0, 2), lin(20, 0, 2)),
}
PATH = {"off-path", "motion-lost", "motion-extra"}


@pytest.mark.parametrize("case", PATHS_RIGHT)
def test_paths_that_pass(case: str) -> None:
    assert groove(*PATHS_RIGHT[case]) == []


@pytest.mark.parametrize("case", PATHS_WRONG)
def test_paths_that_do_not(case: str) -> None:
    assert PATH & set(groove(*PATHS_WRONG[case]))


def test_the_way_to_the_first_point_is_down_its_axis_from_the_clear() -> None:
    """With a stock of 30 mm the first point at Z 25 is no longer clear of it."""
    stock = np.array([[0.0, 0.0, 0.03]])
    assert groove(*CUT, corners=stock) == []
    for way in (
        (ptp(0, 9, 60),),
        (ptp(0, 0, 28),),
        (ptp(0, 0, 60), ptp(0, 0, 25)),
        (ptp(9, 0, 60), lin(0, 0, 29, at=RAPID)),
    ):
        assert PATH & set(groove(*CUT, start=(ptp(), ON, *way, START[-1]), corners=stock))


def test_the_clear_is_above_part_and_stock() -> None:
    """A stock of 80 mm height makes the way at Z 60 one through it."""
    assert groove(*CUT, corners=np.array([[0.0, 0.0, 0.08]])) != []
    assert groove(*CUT, corners=np.array([[0.0, 0.0, 0.059]])) == []


def test_a_place_that_is_not_known_is_no_match() -> None:
    """A posture that can't be worked out has NaN for its tip: that is neither a match nor a tool that stands still."""
    nowhere = (math.nan, math.nan, math.nan)
    for cut in ((lin(*nowhere), CUT[1]), (CUT[0], lin(*nowhere)), (CUT[0], lin(*nowhere), CUT[1])):
        assert groove(*cut) != []
    assert groove(*CUT, start=(ptp(), ON, ptp(*nowhere), START[-1])) != []


def test_a_rapid_of_the_file_is_straight_or_by_way_of_the_clear() -> None:
    story = file(
        ON, rapid(0, 0, 25), feed(0, 0, 2), rapid(0, 0, 5), rapid(20, 0, 5), feed(20, 0, 2), rapid(20, 0, 25), OFF
    )
    before, after = (*START, lin(0, 0, 2), lin(0, 0, 5, at=RAPID)), (lin(20, 0, 2), *END)
    straight = (lin(20, 0, 5, at=RAPID),)
    by_air = (lin(0, 0, 60, at=RAPID), ptp(20, 0, 60), lin(20, 0, 5, at=RAPID))
    through = (lin(0, 0, 8, at=RAPID), lin(20, 0, 8, at=RAPID), lin(20, 0, 5, at=RAPID))
    assert codes(story, program(*before, *straight, *after)) == []
    assert codes(story, program(*before, *by_air, *after)) == []
    assert codes(story, program(*before, *through, *after)) != []


def test_a_way_through_the_clear_may_take_the_place_of_several_rapids() -> None:
    """But only through the clear, to one of their ends, and never of the last before a cut."""
    story = file(
        ON,
        rapid(0, 0, 25),
        feed(0, 0, 2),
        rapid(0, 0, 25),
        rapid(9, 9, 25),
        rapid(20, 0, 5),
        feed(20, 0, 2),
        rapid(20, 0, 25),
        rapid(0, 0, 25),
        OFF,
    )
    before, after = (*START, lin(0, 0, 2)), (lin(20, 0, 2), lin(20, 0, 60, at=RAPID), OFF, ptp())
    over = (lin(0, 0, 60, at=RAPID), ptp(20, 0, 60))
    assert codes(story, program(*before, *over, lin(20, 0, 5, at=RAPID), *after)) == []
    assert codes(story, program(*before, *over, lin(9, 9, 25, at=RAPID), lin(20, 0, 5, at=RAPID), *after)) == []
    assert codes(story, program(*before, over[0], ptp(26, 0, 60), *after)) != []
    assert codes(story, program(*before, lin(0, 0, 25, at=RAPID), lin(20, 0, 5, at=RAPID), *after)) != []


def test_events_between_rapids_that_a_way_through_the_clear_replaces() -> None:
    """They happen in the air, in their order; never before the way out."""
    story = file(*TWO[:5], OFF, rapid(5, 0, 40), TOOL_2, ON, rapid(5, 0, 30), *TWO[8:])
    out, over = lin(0, 0, 60, at=RAPID), lin(20, 0, 60, at=RAPID)
    assert codes(story, program(*FIRST, out, OFF, TOOL_2, ON, over, *SECOND), tools=TOOLS) == []
    assert "event-extra" in codes(story, program(*FIRST, OFF, out, TOOL_2, ON, over, *SECOND), tools=TOOLS)
    assert "event-extra" in codes(story, program(*FIRST, out, OFF, ON, TOOL_2, over, *SECOND), tools=TOOLS)


def test_where_the_file_says_no_way_the_program_goes_through_the_clear() -> None:
    """After G28 the file's own straight line isn't known: the next point is reached down its axis from the clear."""
    story = file(
        ON, rapid(0, 0, 25), feed(0, 0, 2), rapid(26, 0, 5, joined=False), feed(26, 0, 2), rapid(26, 0, 25), OFF
    )
    before = (*START, lin(0, 0, 2))
    after = (lin(26, 0, 2), lin(26, 0, 25, at=RAPID), OFF, lin(26, 0, 60, at=RAPID), ptp())
    by_air = (lin(0, 0, 60, at=RAPID), lin(26, 0, 60, at=RAPID), lin(26, 0, 5, at=RAPID))
    assert codes(story, program(*before, *by_air, *after)) == []
    assert codes(story, program(*before, lin(26, 0, 5, at=RAPID), *after)) != []


def test_a_repeated_point_is_one_point() -> None:
    twice = file(
        ON, rapid(0, 0, 25), rapid(0, 0, 25), feed(0, 0, 2), feed(0, 0, 2), feed(20, 0, 2), rapid(20, 0, 25), OFF
    )
    assert codes(twice, program(*START, *CUT, *END)) == []


def quarter(k: int, of: int, radius: float = 10.0) -> tuple[float, float, float]:
    angle = 0.5 * math.pi * k / of
    return (radius * math.sin(angle), radius - radius * math.cos(angle), 2.0)


ARC = (ON, rapid(0, 0, 25), feed(0, 0, 2), feed(10, 10, 2, center=(0, 10, 2), turn=90), rapid(10, 10, 25), OFF)
ARC_END = (lin(10, 10, 25, at=RAPID), OFF, lin(10, 10, 60, at=RAPID), ptp())
ARCS = {
    "one arc": ((circ(10, 10, 2, center=(0, 10, 2), turn=90),), True),
    "two arcs": (
        (circ(*quarter(1, 3), center=(0, 10, 2), turn=30), circ(10, 10, 2, center=(0, 10, 2), turn=60)),
        True,
    ),
    "chords within the tolerance": (tuple(lin(*quarter(k, 36)) for k in range(1, 37)), True),
    "chords too long": (tuple(lin(*quarter(k, 6)) for k in range(1, 7)), False),
    "straight": ((lin(10, 10, 2),), False),
    "the other way round": ((circ(10, 10, 2, center=(0, 10, 2), turn=270, normal=(0, 0, -1)),), False),
    "once more about": ((circ(10, 10, 2, center=(0, 10, 2), turn=450),), False),
    "chords with a step back": (tuple(lin(*quarter(k, 36)) for k in (*range(1, 20), 18, *range(19, 37))), False),
    "not quite to its end": ((circ(9.99, 9.985, 2, center=(0, 10, 2), turn=89.91),), False),
    "another radius": ((circ(10, 10, 2, center=(-5, 15, 2), turn=53.1301, normal=(0, 0, 1)),), False),
}


@pytest.mark.parametrize("case", ARCS)
def test_arcs(case: str) -> None:
    way, passes = ARCS[case]
    said = codes(file(*ARC), program(*START, lin(0, 0, 2), *way, *ARC_END))
    assert (said == []) is passes, said


def test_thousands_of_chords_of_one_arc() -> None:
    """They go by in blocks: one that is off, turned or a step back among them is found as in a short arc."""
    count = 3000
    right = [lin(*quarter(k, count, 500.0)) for k in range(1, count + 1)]
    story = file(
        ON, rapid(0, 0, 25), feed(0, 0, 2), feed(500, 500, 2, center=(0, 500, 2), turn=90), rapid(500, 500, 25), OFF
    )
    after = (lin(500, 500, 25, at=RAPID), OFF, lin(500, 500, 60, at=RAPID), ptp())

    def said(lins) -> list[str]:
        return codes(story, program(*START, lin(0, 0, 2), *lins, *after))

    assert said(right) == []
    x, y, z = right[1500]["tip"]
    for off in ({"tip": (x, y, z + 0.02)}, {"axis": TILTED}, {"speed": 700.0}, {"tip": right[1490]["tip"]}):
        assert said([*right[:1500], {**right[1500], **off}, *right[1501:]]) != []
    assert said([*right[:1500], *right[1501:]]) == [] and said([*right[:1400], *right[1500:]]) != []


def test_a_full_circle_is_run_all_round() -> None:
    story = file(ON, rapid(0, 0, 25), feed(0, 0, 2), feed(0, 0, 2, center=(0, 10, 2), turn=360), rapid(0, 0, 25), OFF)
    halves = (circ(0, 20, 2, center=(0, 10, 2), turn=180), circ(0, 0, 2, center=(0, 10, 2), turn=180))
    after = (lin(0, 0, 25, at=RAPID), OFF, lin(0, 0, 60, at=RAPID), ptp())
    assert codes(story, program(*START, lin(0, 0, 2), *halves, *after)) == []
    assert codes(story, program(*START, lin(0, 0, 2), *after)) != []
    assert codes(story, program(*START, lin(0, 0, 2), halves[0], lin(0, 0, 2), *after)) != []
    assert codes(story, program(*START, lin(0, 0, 2), *halves, *halves, *after)) != []


def test_points_nearer_together_than_the_tolerance_are_all_met() -> None:
    """Spaced 4 micrometres: one more or less can't be told by place alone, but a hundred that are missing can."""
    fine = [feed(0.004 * k, 0.004 * (k % 2), 2) for k in range(1, 400)]
    story = file(ON, rapid(0, 0, 25), feed(0, 0, 2), *fine, rapid(*fine[-1]["tip"][:2], 25), OFF)
    x, y, _ = fine[-1]["tip"]
    after = (lin(x, y, 25, at=RAPID), OFF, lin(x, y, 60, at=RAPID), ptp())
    lins = [lin(*m["tip"]) for m in fine]
    assert codes(story, program(*START, lin(0, 0, 2), *lins, *after)) == []
    assert codes(story, program(*START, lin(0, 0, 2), *lins[::3], lins[-1], *after)) == []
    assert codes(story, program(*START, lin(0, 0, 2), *lins[:100], *after)) != []
    fast = [{**m, "speed": RAPID} for m in lins]
    assert "feed-higher" in codes(story, program(*START, lin(0, 0, 2), *fast, *after))


HOLE = (ON, rapid(0, 0, 25), rapid(0, 0, 5), hole(0, 0, -10), rapid(0, 0, 5), rapid(0, 0, 25), OFF)
PECKS = (lin(0, 0, -3), lin(0, 0, 5, at=RAPID), lin(0, 0, -2.5, at=RAPID), lin(0, 0, -10))
HOLES = {
    "at once": ((lin(0, 0, -10),), True),
    "in pecks": (PECKS, True),
    "a last peck of 4 micrometres": (
        (*PECKS[:3], lin(0, 0, -9.996), lin(0, 0, 5, at=RAPID), lin(0, 0, -9, at=RAPID), lin(0, 0, -10)),
        True,
    ),
    "once more": ((*PECKS, lin(0, 0, 5, at=RAPID), lin(0, 0, -10)), False),
    "not to the bottom": (PECKS[:3], False),
    "deeper": ((lin(0, 0, -10.02),), False),
    "rapid below what was reached": ((*PECKS[:2], lin(0, 0, -3.5, at=RAPID), PECKS[3]), False),
    "at another place": ((lin(0.1, 0, -10),), False),
    "at rapid": ((lin(0, 0, -10, at=RAPID),), False),
    "rounded off at the bottom": (({**lin(0, 0, -10), "exact": False},), False),
    "rounded off between pecks": (({**PECKS[0], "exact": False}, *PECKS[1:]), False),
    "rounded off at the last peck": ((*PECKS[:3], {**PECKS[3], "exact": False}), False),
}


@pytest.mark.parametrize("case", HOLES)
def test_holes(case: str) -> None:
    way, passes = HOLES[case]
    after = (lin(0, 0, 5, at=RAPID), lin(0, 0, 25, at=RAPID), OFF, lin(0, 0, 60, at=RAPID), ptp())
    said = codes(file(*HOLE), program(*START, lin(0, 0, 5, at=RAPID), *way, *after))
    assert (said == []) is passes, said


DEEP = (lin(0, 0, -3), lin(0, 0, 5, at=RAPID), lin(0, 0, -2.5, at=RAPID), lin(0, 0, -7))
OUT = (lin(0, 0, 5, at=RAPID), lin(0, 0, -6.5, at=RAPID), lin(0, 0, -10))
PECKED = {
    "as the file says": ((*DEEP, *OUT), True),
    "smaller ones": ((lin(0, 0, -1), lin(0, 0, 5, at=RAPID), lin(0, 0, -0.5, at=RAPID), *DEEP, *OUT), True),
    "a sliver more at the bottom": ((*DEEP[:3], lin(0, 0, -6.97), OUT[0], lin(0, 0, -6, at=RAPID), OUT[2]), True),
    "the chip is only broken": ((DEEP[0], lin(0, 0, -2.5, at=RAPID), DEEP[3], lin(0, 0, -6.5, at=RAPID), OUT[2]), True),
    "in one, in parts": ((DEEP[0], lin(0, 0, -5), *DEEP[1:], *OUT), False),
    "at once": ((lin(0, 0, -10),), False),
    "one is left out": ((*DEEP[:3], lin(0, 0, -10)), False),
    "the first is too deep": ((lin(0, 0, -3.5), *DEEP[1:], *OUT), False),
    "the second is too deep": ((*DEEP[:3], lin(0, 0, -7.2), *OUT), False),
    "the last is too deep": ((*DEEP[:3], lin(0, 0, -5.5), *OUT[:1], lin(0, 0, -5, at=RAPID), OUT[2]), False),
}


LEFT_IN = {
    "as the file says": ((*DEEP, *OUT), True),
    "not quite out": ((DEEP[0], lin(0, 0, 4.9, at=RAPID), *DEEP[2:], *OUT), False),
    "the chip is only broken": (PECKED["the chip is only broken"][0], False),
    "the second chip is only broken": ((*DEEP, *OUT[1:]), False),
    "farther out": ((*DEEP[:1], lin(0, 0, 9, at=RAPID), *DEEP[2:], *OUT), True),
}


@pytest.mark.parametrize("case", LEFT_IN)
def test_a_deep_hole_is_cleared_between_pecks(case: str) -> None:
    way, passes = LEFT_IN[case]
    wanted = (*HOLE[:3], hole(0, 0, -10, pecks=(8.0, 4.0, True)), *HOLE[4:])
    after = (lin(0, 0, 5, at=RAPID), lin(0, 0, 25, at=RAPID), OFF, lin(0, 0, 60, at=RAPID), ptp())
    said = codes(file(*wanted), program(*START, lin(0, 0, 5, at=RAPID), *way, *after))
    assert said == ([] if passes else ["peck-left-in"])


@pytest.mark.parametrize("case", PECKED)
def test_no_peck_goes_deeper_than_the_file_s(case: str) -> None:
    way, passes = PECKED[case]
    pecks = (8.0, 4.0, False)  # 3 below 0, which is 5 below where it starts
    wanted = (*HOLE[:3], hole(0, 0, -10, pecks=pecks), *HOLE[4:])
    after = (lin(0, 0, 5, at=RAPID), lin(0, 0, 25, at=RAPID), OFF, lin(0, 0, 60, at=RAPID), ptp())
    run = program(*START, lin(0, 0, 5, at=RAPID), *way, *after)
    assert codes(file(*HOLE), run) == [] and codes(file(*wanted), run) == ([] if passes else ["peck-deeper"])


BITES = {
    "as the file says": ((*DEEP[:3], lin(0, 0, -7), OUT[0], OUT[1], lin(0, 0, -10)), []),
    "all are shorter, and more": (
        (
            lin(0, 0, -3),
            lin(0, 0, 5, at=RAPID),
            lin(0, 0, -2.5, at=RAPID),
            lin(0, 0, -6),
            OUT[0],
            lin(0, 0, -5, at=RAPID),
            lin(0, 0, -9),
            OUT[0],
            lin(0, 0, -8, at=RAPID),
            lin(0, 0, -10),
        ),
        ["peck-ends"],
    ),
    "the second stops short": (
        (*DEEP[:3], lin(0, 0, -6.9), OUT[0], OUT[1], lin(0, 0, -9.9), OUT[0], OUT[1], lin(0, 0, -10)),
        ["peck-ends"],
    ),
    "one is left out": ((*DEEP[:3], lin(0, 0, -10)), ["peck-deeper"]),
    "the second is as the third is not": ((*DEEP[:3], lin(0, 0, -7.1), *OUT), ["peck-deeper"]),
    "a short one, and then too much": (
        (
            lin(0, 0, -0.5),
            lin(0, 0, 5, at=RAPID),
            lin(0, 0, 0, at=RAPID),
            lin(0, 0, -4.6),
            OUT[0],
            lin(0, 0, -4, at=RAPID),
            lin(0, 0, -7.6),
            *OUT,
        ),
        ["peck-deeper"],
    ),
    "the first is too deep": ((lin(0, 0, -3.1), *DEEP[1:], *OUT), ["peck-deeper"]),
}


@pytest.mark.parametrize("case", BITES)
def test_bites_that_differ_end_each_where_the_file_s_does(case: str) -> None:
    """Bites to -3, -7 and -10: 8, 4 and 3 mm from where the hole's motion starts, at 5."""
    way, said = BITES[case]
    wanted = (*HOLE[:3], hole(0, 0, -10, pecks=(8.0, 8.0, True)), *HOLE[4:])
    after = (lin(0, 0, 5, at=RAPID), lin(0, 0, 25, at=RAPID), OFF, lin(0, 0, 60, at=RAPID), ptp())
    story = file(*wanted)
    bitten = {k: pecks._replace(lows=(0.008, 0.012, 0.015)) for k, pecks in story.pecks.items()}
    found = codes(replace(story, pecks=bitten), program(*START, lin(0, 0, 5, at=RAPID), *way, *after))
    assert found == said


def test_decimation_takes_as_much_as_the_setup_allows() -> None:
    cut = [feed(k, 0.005 * (k % 2), 2) for k in range(1, 21)]
    story = file(ON, rapid(0, 0, 25), feed(0, 0, 2), *cut, rapid(20, 0, 25), OFF)
    wide = file(
        ON,
        rapid(0, 0, 25),
        feed(0, 0, 2),
        *[{**m, "tip": (m["tip"][0], 4 * m["tip"][1], 2)} for m in cut],
        rapid(20, 0, 25),
        OFF,
    )
    run = program(*START, *CUT, *END)
    assert codes(story, run) == []
    assert codes(wide, run) != [] and codes(wide, run, decimated=1.5e-5) == []
    turned = [{**m, "axis": (0.0, 0.003 * (k == 9), 1.0)} for k, m in enumerate(cut)]
    slower = [{**m, "feed": FEED / 2 if k == 9 else FEED} for k, m in enumerate(cut)]
    for odd, said in ((turned, "off-path"), (slower, "feed-higher")):
        story = file(ON, rapid(0, 0, 25), feed(0, 0, 2), *odd, rapid(20, 0, 25), OFF)
        assert codes(story, run, decimated=1.5e-5) == [said]


def test_a_tilting_cut_turns_along_the_great_arc() -> None:
    def leaning(degrees: float):
        return (0.0, math.sin(deg_to_rad(degrees)), math.cos(deg_to_rad(degrees)))

    story = file(
        ON, rapid(0, 0, 25), feed(0, 0, 2), feed(20, 0, 2, axis=leaning(10)), rapid(20, 5, 30, axis=leaning(10)), OFF
    )
    after = (lin(20, 5, 30, axis=leaning(10), at=RAPID), OFF, lin(20, 20, 115, axis=leaning(10), at=RAPID), ptp())
    for half, passes in ((5.0, True), (6.0, False)):
        cut = (lin(0, 0, 2), lin(10, 0, 2, axis=leaning(half)), lin(20, 0, 2, axis=leaning(10)))
        assert (codes(story, program(*START, *cut, *after)) == []) is passes


def turned_table(share: float, turn: float = 40.0):
    """The axis of a tool that leans by 12 degrees over a table that has turned by a share of some degrees."""
    lean = math.sin(deg_to_rad(12))
    return (
        lean * math.sin(deg_to_rad(turn * share)),
        lean * math.cos(deg_to_rad(turn * share)),
        math.cos(deg_to_rad(12)),
    )


def over_a_table(cut: list, turn: float) -> list[str]:
    """What stands against a program that goes 20 mm while a table turns evenly by some degrees."""
    begin, end = turned_table(0, turn), turned_table(1, turn)
    pieces = (feed(20 * k / 40, 0, 2, axis=turned_table(k / 40, turn)) for k in range(1, 41))
    story = file(ON, rapid(0, 0, 25, axis=begin), feed(0, 0, 2, axis=begin), *pieces, rapid(20, 0, 25, axis=end), OFF)
    story.path.line[2:42] = 4
    into = (ptp(), ON, ptp(0, 0, 60, axis=begin), lin(0, 0, 25, at=RAPID, axis=begin), lin(0, 0, 2, axis=begin))
    out = (lin(20, 0, 25, at=RAPID, axis=end), OFF, lin(20, 0, 60, at=RAPID, axis=end), ptp())
    return codes(story, program(*into, *cut, *out))


@pytest.mark.parametrize(("pieces", "passes"), [(1, False), (2, True), (4, True)])
def test_a_table_that_turns_evenly_is_followed_in_pieces_of_half_a_degree(pieces: int, passes: bool) -> None:
    """C turns by 40 degrees below a tool that leans by 12: one great arc is off by 0.7 degrees of the axis, two by 0.18."""
    cut = [lin(20 * k / pieces, 0, 2, axis=turned_table(k / pieces)) for k in range(1, pieces + 1)]
    assert over_a_table(cut, 40.0) == ([] if passes else ["off-path"])


@pytest.mark.parametrize(("turn", "aside", "passes"), [(20, 0.0, True), (20, 0.03, False), (40, 0.0, False)])
def test_a_cut_over_a_turning_table_may_be_parted_on_its_own_great_arc(turn: float, aside: float, passes: bool) -> None:
    """A cut that may go as one may be parted where it went (for its feed); of 20 degrees it is 0.18 off, of 40 0.7."""
    begin, end = np.array(turned_table(0, turn)), np.array(turned_table(1, turn))
    across = np.cross(begin, end) / np.linalg.norm(np.cross(begin, end))
    cut = []
    for share in (0.26, 0.54, 1.0):
        axis = Rotation.from_rotvec(share * math.acos(begin @ end) * across).apply(begin)
        axis = axis + deg_to_rad(aside) * across * (share < 1.0)
        cut.append(lin(20 * share, 0, 2, axis=tuple(axis)))
    assert over_a_table(cut, turn) == ([] if passes else ["off-path"])


def test_a_gap_of_the_file_is_left_unjudged_and_no_more() -> None:
    story = file(ON, rapid(0, 0, 25), feed(0, 0, 2), "gap", feed(20, 0, 2), feed(30, 0, 2), rapid(30, 0, 25), OFF)
    unread = (lin(5, 3, 2), lin(12, -3, 2), lin(20, 0, 2))
    after = (lin(30, 0, 2), lin(30, 0, 25, at=RAPID), OFF, lin(30, 0, 60, at=RAPID), ptp())
    found = judged(story, program(*START, lin(0, 0, 2), *unread, *after))
    assert found.objections == [] and [gap.text for gap in found.unjudged] == ["NURBS"]
    late = judged(story, program(*START, lin(0, 0, 2), *unread, lin(30, 1, 2), *after))
    assert {o.code for o in late.objections} & PATH
    early = judged(story, program(*START, lin(0, 1, 2), *unread, *after))
    assert {o.code for o in early.objections} & PATH


def test_a_corner_beside_a_gap_is_not_a_border_of_the_cut() -> None:
    """What the reader left out may be a cut: the program need not stop where it begins."""
    story = file(ON, rapid(0, 0, 25), feed(0, 0, 2), "gap", feed(20, 0, 2), feed(30, 0, 2), rapid(30, 0, 25), OFF)
    cut = [{**lin(0, 0, 2), "exact": False}, {**lin(20, 0, 2), "exact": False}, lin(30, 0, 2)]
    way = (*START, *cut, lin(30, 0, 25, at=RAPID), OFF, lin(30, 0, 60, at=RAPID), ptp())
    assert judged(story, program(*way)).objections == []
    rounded = program(*START, cut[0], cut[1], {**cut[2], "exact": False}, *way[-4:])
    assert [o.code for o in judged(story, rounded).objections] == ["rounded-cut"]


def test_a_way_in_at_the_feed_that_the_file_leaves_open_goes_on_as_a_cut() -> None:
    """Behind G52 the file's way to the first cut isn't known; its corner with the next cut may be rounded off."""
    story = file(ON, rapid(0, 0, 25), feed(0, 0, 2, joined=False), feed(20, 0, 2), rapid(20, 0, 25), OFF)
    plunge = {**lin(0, 0, 2), "exact": False}
    assert codes(story, program(*START, plunge, CUT[1], *END)) == []
    assert codes(story, program(*START, plunge, {**CUT[1], "exact": False}, *END)) == ["rounded-cut"]


def test_an_objection_says_where_and_the_comparison_goes_on() -> None:
    cut = [feed(k, 0, 2) for k in range(1, 21)]
    story = file(ON, rapid(0, 0, 25), feed(0, 0, 2), *cut, rapid(20, 0, 25), OFF)
    lins = [lin(*m["tip"]) for m in cut]
    lins[4]["tip"], lins[12]["tip"] = (5, 0.5, 2), (13, 0, 2.5)
    found = judged(story, program(*START, lin(0, 0, 2), *lins, *END)).objections
    assert [o.code for o in found] == ["off-path", "off-path"]
    assert (found[0].cl_line, found[0].line) == (8, 10) and "0.500 mm" in found[0].text


# --- the feed -----------------------------------------------------------------------------------------------------------

FEEDS = {
    "higher": ((lin(0, 0, 2), lin(20, 0, 2, at=601)), ["feed-higher"]),
    "lower": ((lin(0, 0, 2), lin(20, 0, 2, at=599)), ["feed-lower"]),
    "as printed": ((lin(0, 0, 2), lin(20, 0, 2, at=600.03)), []),
    "as printed, lower": ((lin(0, 0, 2), lin(20, 0, 2, at=599.97)), []),
    "printed with a decimal less": ((lin(0, 0, 2), lin(20, 0, 2, at=600.2)), ["feed-higher"]),
    "lower by a decimal less": ((lin(0, 0, 2), lin(20, 0, 2, at=599.8)), ["feed-lower"]),
    "none": ((lin(0, 0, 2), lin(20, 0, 2, at=math.nan)), ["no-speed"]),
    "in a piece of a cut": ((lin(0, 0, 2), lin(7, 0, 2), lin(9, 0, 2, at=RAPID), lin(20, 0, 2)), ["feed-higher"]),
    "back into the part": (
        (lin(0, 0, 2), lin(7, 0, 2), lin(7, 0, 60, at=RAPID), lin(7, 0, 2, at=RAPID), lin(20, 0, 2)),
        ["entry-faster"],
    ),
    "out of the part faster than rapid": (
        (lin(0, 0, 2), lin(7, 0, 2), lin(7, 0, 60, at=9000), lin(7, 0, 2), lin(20, 0, 2)),
        ["rapid-higher"],
    ),
}


@pytest.mark.parametrize(("last", "passes"), [(rapid(7, 0, 9), True), (feed(7, 0, 9), False)])
def test_the_way_back_is_as_fast_as_the_file_itself_came_there(last, passes: bool) -> None:
    """Low over the part a file that came in rapid is gone on with in rapid; one that cut is gone on with at its feed."""
    story = file(ON, rapid(0, 0, 25), feed(0, 0, 2), feed(7, 0, 2), last, feed(20, 0, 2), rapid(20, 0, 25), OFF)
    speed = RAPID if passes else 600
    cut = (
        lin(0, 0, 2),
        lin(7, 0, 2),
        lin(7, 0, 9, at=speed),
        lin(7, 0, 60, at=RAPID),
        lin(7, 0, 9, at=RAPID),
        lin(20, 0, 2),
    )
    assert codes(story, program(*START, *cut, *END)) == ([] if passes else ["entry-faster"])


@pytest.mark.parametrize("case", FEEDS)
def test_feeds(case: str) -> None:
    way, wanted = FEEDS[case]
    assert groove(*way) == wanted


def test_a_reason_lets_a_cut_be_slower_and_no_rapid_feed_judges_no_rapid() -> None:
    assert groove(lin(0, 0, 2), lin(20, 0, 2, at=300), slower_allowed="--feed optimal") == []
    assert groove(lin(0, 0, 2), lin(20, 0, 2, at=700), slower_allowed="--feed optimal") == ["feed-higher"]
    fast = (*START[:3], lin(0, 0, 25, at=9000))
    assert groove(*CUT, start=fast) == ["rapid-higher"] and groove(*CUT, start=fast, rapid=None) == []


def test_a_cut_without_a_feed_is_named() -> None:
    story = file(ON, rapid(0, 0, 25), feed(0, 0, 2, at=math.nan), feed(20, 0, 2, at=math.nan), rapid(20, 0, 25), OFF)
    assert codes(story, program(*START, *CUT, *END)) == ["no-feed"]


def test_a_turn_on_the_spot_needs_no_feed() -> None:
    """Inverse-time feed states none for it: the tip does not move."""
    lean = (0.0, math.sin(0.1), math.cos(0.1))
    turn, out = feed(0, 0, 2, axis=lean, at=math.nan), rapid(0, 2, 25, axis=lean)
    run = program(*START, lin(0, 0, 2), lin(0, 0, 2, axis=lean), lin(0, 2, 25, axis=lean, at=RAPID), OFF, ptp())
    assert codes(file(ON, rapid(0, 0, 25), feed(0, 0, 2), turn, out, OFF), run) == []


# --- events and state -----------------------------------------------------------------------------------------------------

TOOL_1, TOOL_2 = (Kind.TOOL, 1.0, ""), (Kind.TOOL, 2.0, "")
WATER, DRY = (Kind.COOLANT_ON, 0.0, "FLOOD"), (Kind.COOLANT_OFF, 0.0, "")
DWELL, STOP, OUTPUT = (Kind.DWELL, 2.0, ""), (Kind.STOP, 0.0, ""), (Kind.OUTPUT, 0.0, "$OUT[9] = TRUE")
EVENTS = {
    # between (0, 0, 2) and (20, 0, 2) of the file; of the program there, before the cut, after it; said
    "coolant": ([WATER, DRY], [WATER, DRY], []),
    "lost": ([WATER], [], ["coolant-differs", "event-lost"]),
    "dwell lost": ([DWELL], [], ["event-lost"]),
    "dwell": ([DWELL], [DWELL], []),
    "dwell of another length": ([DWELL], [(Kind.DWELL, 1.0, "")], ["event-extra", "event-lost"]),
    "a wait of its own": ([], [DWELL], ["event-extra"]),
    "stop": ([STOP], [STOP], []),
    "a stop of its own": ([], [STOP], ["event-extra"]),
    "doubled": ([STOP], [STOP, STOP], ["event-extra"]),
    "order": ([DWELL, STOP], [STOP, DWELL], ["event-extra", "event-lost"]),
    "another speed": (
        [(Kind.SPINDLE_ON, 5000.0, "CLW")],
        [(Kind.SPINDLE_ON, 4000.0, "CLW")],
        ["event-extra", "event-lost", "spindle-differs"],
    ),
    "another sense": (
        [(Kind.SPINDLE_ON, 5000.0, "CCLW")],
        [(Kind.SPINDLE_ON, 5000.0, "CLW")],
        ["event-extra", "event-lost", "spindle-differs"],
    ),
    "off before it turns the other way": (
        [(Kind.SPINDLE_ON, 3000.0, "CCLW")],
        [OFF, (Kind.SPINDLE_ON, 3000.0, "CCLW")],
        [],
    ),
    "what changes nothing": ([ON], [], []),
    "off in a cut": ([], [OFF], ["event-extra", "spindle-differs"]),
    "off and on": ([], [OFF, ON], ["event-extra", "spindle-starts-in-part"]),
    "undone before anything moves": ([WATER, DRY], [], []),
    "an output": ([], [OUTPUT], ["output-unknown"]),
    "the file's own stop and start": ([OFF, STOP, ON], [OFF, STOP, ON], ["spindle-starts-in-part"]),
    "running where the file measures": (
        [OFF, STOP, ON],
        [STOP, OFF, ON],
        ["event-extra", "event-lost", "spindle-starts-in-part"],
    ),
}


@pytest.mark.parametrize("case", EVENTS)
def test_events(case: str) -> None:
    wanted, given, said = EVENTS[case]
    story = file(*GROOVE[:3], *wanted, *GROOVE[3:5], DRY, OFF)
    run = program(*START, CUT[0], *given, CUT[1], *END[:2], DRY, *END[2:])
    found = [o for o in judged(story, run).objections if o.code != "event-extra" or "coolant off" not in o.text]
    assert sorted({o.code for o in found}) == said


def test_an_event_overtakes_no_motion() -> None:
    story = file(*GROOVE[:3], WATER, *GROOVE[3:5], DRY, OFF)
    late = program(*START, *CUT, WATER, *END[:2], DRY, *END[2:])
    assert codes(story, late) == ["coolant-differs", "event-extra", "event-lost"]
    within = program(*START, CUT[0], lin(7, 0, 2), WATER, CUT[1], *END[:2], DRY, *END[2:])
    assert "event-extra" in codes(story, within)


TWO = (
    TOOL_1,
    ON,
    rapid(0, 0, 25),
    feed(0, 0, 2),
    rapid(0, 0, 25),
    OFF,
    TOOL_2,
    ON,
    rapid(20, 0, 25),
    feed(20, 0, 2),
    rapid(20, 0, 25),
    OFF,
)
FIRST = (ptp(), TOOL_1, ON, ptp(0, 0, 60), lin(0, 0, 25, at=RAPID), lin(0, 0, 2))
SECOND = tuple({**m, "tool": 1} if isinstance(m, dict) else m for m in (lin(20, 0, 25, at=RAPID), lin(20, 0, 2), *END))
TOOLS = {1: TOOL, 2: OTHER_TOOL}


def changed(*between, first=FIRST, second=SECOND, story=TWO, tools=TOOLS, **terms) -> list[str]:
    """What is said of a program with a change of tools that goes so."""
    return codes(file(*story), program(*first, *between, *second), tools=tools, **terms)


def test_a_tool_change_in_the_clear_with_the_spindle_off() -> None:
    out, over = lin(0, 0, 60, at=RAPID), lin(20, 0, 60, at=RAPID)
    up = lin(0, 0, 25, at=RAPID)
    assert changed(up, out, OFF, ptp(), TOOL_2, ON, ptp(20, 0, 60)) == []
    assert changed(up, OFF, out, TOOL_2, ON, over) == []
    assert changed(up, OFF, TOOL_2, ON, out, over) == []  # the retract plane is clear already
    assert changed(up, out, TOOL_2, OFF, ON, over) == ["change-running", "event-extra"]
    assert changed(up, out, OFF, ON, TOOL_2, over)[0] == "change-running"
    assert "event-lost" in changed(up, out, OFF, ON, over)
    assert "spindle-differs" in changed(up, out, OFF, TOOL_2, over)


def test_the_spindle_is_not_turned_round_while_it_runs_and_no_tool_changed_in_the_wet() -> None:
    out, over = lin(0, 0, 60, at=RAPID), lin(20, 0, 60, at=RAPID)
    up, other = lin(0, 0, 25, at=RAPID), (Kind.SPINDLE_ON, 3000.0, "CCLW")
    assert "spindle-reversed" in changed(up, OFF, out, TOOL_2, other, ON, over)
    assert "spindle-reversed" not in changed(up, OFF, out, TOOL_2, other, OFF, ON, over)
    assert "change-wet" in changed(up, OFF, out, WATER, TOOL_2, ON, over)
    assert "change-wet" not in changed(up, OFF, out, WATER, DRY, TOOL_2, ON, over)


def test_the_spindle_stands_until_the_robot_is_where_the_program_begins() -> None:
    assert "spindle-starts-early" in codes(file(*GROOVE), program(ON, START[0], *START[2:], *CUT, *END))
    assert codes(file(*GROOVE), program(*START, *CUT, *END)) == []


def test_a_cell_with_a_place_for_it_changes_tools_there() -> None:
    rack, (up, over) = {**ptp(400, 0, 900), "a1": 30.0}, (lin(0, 0, 60, at=RAPID), ptp(20, 0, 60))
    pose, first = np.array([30.0, 0.0]), (FIRST[0], rack, *FIRST[1:])
    assert changed(up, OFF, rack, TOOL_2, ON, over, first=first, change=pose) == []
    assert changed(up, OFF, TOOL_2, ON, over, first=first, change=pose) == ["change-in-part"]
    assert changed(up, OFF, ptp(), TOOL_2, ON, over, first=first, change=pose) == ["change-in-part"]
    assert changed(up, OFF, rack, TOOL_2, ON, over, change=pose) == ["change-in-part"]  # the first one at HOME
    assert changed(up, OFF, rack, TOOL_2, ON, over, first=first, change=pose + 1.0) == ["change-in-part"]


def test_a_tool_change_at_depth() -> None:
    """The old fault: everything is there, but ordered before the way out of the part."""
    said = changed(OFF, TOOL_2, ON, lin(0, 0, 25, at=RAPID), lin(0, 0, 60, at=RAPID), lin(20, 0, 60, at=RAPID))
    assert "change-in-part" in said and "event-lost" in said


def test_a_change_that_the_file_says_at_depth_is_made_in_the_clear() -> None:
    story = (TOOL_1, ON, rapid(0, 0, 25), feed(0, 0, 2), TOOL_2, ON, rapid(20, 0, 25, joined=False), *TWO[9:])
    out, over = lin(0, 0, 60, at=RAPID), lin(20, 0, 60, at=RAPID)
    assert changed(out, OFF, TOOL_2, ON, over, story=story) == []
    assert "change-in-part" in changed(OFF, TOOL_2, ON, out, over, story=story)


def test_each_tool_has_its_own_frame() -> None:
    way = (lin(0, 0, 25, at=RAPID), OFF, lin(0, 0, 60, at=RAPID), TOOL_2, ON, lin(20, 0, 60, at=RAPID))
    same = tuple({**m, "tool": 0} if isinstance(m, dict) else m for m in SECOND)
    assert changed(*way, second=same) == ["tool-frame"]
    assert changed(*way, second=same, tools={0: TOOL}) == []
    assert changed(*way, tools={1: TOOL}) == ["tool-unknown"]


LOADS = {1: (20.0, 0.0, -0.04, 0.3), 2: (25.0, 0.0, 0.0, 0.2)}
ONE, OTHER = load(20.0, 0.0, -40.0, 300.0), load(25.0, 0.0, 0.0, 200.0)


def weighed(*between, first=(ONE, *FIRST), loads=LOADS) -> list[str]:
    """What is said of a program with a change of tools whose masses the set-up states."""
    way = (lin(0, 0, 25, at=RAPID), lin(0, 0, 60, at=RAPID), OFF, ptp(), TOOL_2, *between, ON, ptp(20, 0, 60))
    return changed(*way, first=first, loads=loads)


def test_the_load_is_that_of_the_mounted_tool() -> None:
    assert weighed(OTHER) == []
    assert weighed(load(25.0004, 0.0004, 0.0, 200.0)) == []  # as three decimals may print it
    assert weighed() == ["load-differs"]  # still the first tool's
    assert weighed(OTHER, first=FIRST) == ["load-differs"]  # the first one's is never set
    assert weighed(load(None)) == ["load-differs"]
    assert weighed(load(25.01, 0.0, 0.0, 200.0)) == ["load-differs"]
    assert weighed(load(25.0, 0.0, 0.1, 200.0)) == ["load-differs"]
    assert weighed(ONE) == ["load-differs"]


def test_the_load_is_set_before_the_first_motion_with_the_tool() -> None:
    way = (lin(0, 0, 25, at=RAPID), lin(0, 0, 60, at=RAPID), OFF, ptp(), TOOL_2, ON)
    over = ptp(20, 0, 60)
    assert changed(*way, OTHER, over, first=(ONE, *FIRST), loads=LOADS) == []
    assert changed(*way, over, OTHER, first=(ONE, *FIRST), loads=LOADS) == ["load-differs"]
    early = (lin(0, 0, 25, at=RAPID), OTHER, *way[1:])
    assert changed(*early, over, first=(ONE, *FIRST), loads=LOADS) == ["load-differs"]


def test_of_tools_whose_mass_the_set_up_does_not_state_no_load_is_asked() -> None:
    assert weighed(OTHER, loads={}) == [] and weighed(first=FIRST, loads={}) == []
    assert weighed(load(None), loads={1: LOADS[1]}) == []


@pytest.mark.parametrize(
    "second",
    [
        load(math.nan, 0.0, 0.0, 200.0),
        load(25.0, 0.0, 0.0, math.nan),
        load(25.0, 0.0, 0.0, 200.0, more=(0, 0, 0, 0.5, 0, 0)),
    ],
)
def test_a_load_that_nobody_knows_is_not_judged(second) -> None:
    up = (lin(0, 0, 25, at=RAPID), lin(0, 0, 60, at=RAPID), OFF, ptp(), TOOL_2, second, ON, ptp(20, 0, 60))
    found = judged(file(*TWO), program(ONE, *FIRST, *up, *SECOND), tools=TOOLS, loads=LOADS)
    assert not found.objections and len(found.unjudged) == 1 and "the load holds" in found.unjudged[0].text


def test_starts_and_ends() -> None:
    assert groove(*CUT, start=(ptp(), ptp(0, 0, 60), START[-1])) == ["event-extra", "event-lost", "spindle-differs"][1:]
    assert groove(*CUT, end=(END[0], *END[2:])) == ["ends-running", "event-lost"]
    assert groove(*CUT) == []
    in_the_clear = judged(file(*GROOVE), program(*START, *CUT, *END[:2])).objections  # the retract plane is clear
    assert [(o.code, o.severity) for o in in_the_clear] == [("ends-elsewhere", "warning")]
    assert "ends-in-part" in codes(file(*GROOVE[:4], OFF), program(*START, *CUT, OFF))
    assert groove(*CUT, spindle_rpm=(1000.0, 2000.0)) == ["spindle-range"]
    assert groove(*CUT, spindle_rpm=(1000.0, 3000.0)) == []


def test_a_path_that_leaves_home_is_said() -> None:
    entered = program(START[0], ON, lin(0, 0, 60, at=RAPID), *START[3:], *CUT, *END)
    found = judged(file(*GROOVE), entered).objections
    assert [(o.code, o.severity) for o in found] == [("path-from-home", "warning")]


def test_a_program_that_does_not_begin_at_home_is_refused() -> None:
    found = judged(file(*GROOVE), program(START[2], ON, *START[3:], *CUT, *END)).objections
    assert [(o.code, o.severity) for o in found] == [("starts-elsewhere", "error")]


def test_a_table_that_turns_without_end_begins_on_home_s_own_turn_and_may_end_on_another() -> None:
    run = program(*START, *CUT, *END)

    def said(*turns: tuple[int, float]) -> list[str]:
        axes = run.axes.copy()
        for row, value in turns:
            axes[row, 1] = value
        return codes(file(*GROOVE), replace(run, axes=axes), endless=np.array([False, True]))

    assert said() == said((-1, 360.0)) == said((-1, -720.0)) == []
    assert said((0, 360.0)) == ["starts-elsewhere"]
    assert said((-1, 180.0)) == ["ends-elsewhere"]


def test_a_cut_with_no_spindle_ever_on_is_a_warning() -> None:
    found = judged(file(*GROOVE[1:5]), program(ptp(), *START[2:], *CUT, END[0], *END[2:])).objections
    assert [(o.code, o.severity) for o in found] == [("cut-without-spindle", "warning")]


def test_what_the_cell_has_no_hook_for_is_not_asked_of_the_program() -> None:
    story = file(ON, WATER, *GROOVE[1:5], DRY, OFF)
    run = program(*START, *CUT, *END)
    assert codes(story, run) == ["coolant-differs", "event-lost"]
    found = judged(story, run, hooks=frozenset({"spindle_on"})).objections
    assert [(o.code, o.severity) for o in found] == [("no-hook", "warning")]


def test_outputs_before_and_after_the_file_are_not_judged() -> None:
    found = judged(file(*GROOVE), program(OUTPUT, *START, *CUT, *END))
    assert found.objections == [] and "no hook" in found.unjudged[0].text


def test_events_in_a_gap_are_taken_for_the_files() -> None:
    story = file(ON, rapid(0, 0, 25), feed(0, 0, 2), "gap", feed(20, 0, 2), rapid(20, 0, 25), DRY, OFF)
    run = program(*START, CUT[0], WATER, lin(5, 3, 2), CUT[1], *END[:1], DRY, *END[1:])
    assert judged(story, run).objections == []


def test_no_controller_runs_a_line_faster_than_three_metres_a_second() -> None:
    quick = [{**m, "feed": 200_000.0} for m in (feed(20, 0, 2),)]
    story = file(ON, rapid(0, 0, 25), feed(0, 0, 2), *quick, rapid(20, 0, 25), OFF)
    run = program(*START, lin(0, 0, 2), {**lin(20, 0, 2), "speed": 200_000.0}, *END)
    assert "speed-limit" in codes(story, run)


def _turned(rows, degrees):
    return tuple({**m, "a1": 50.0 + degrees} if isinstance(m, dict) and not m.get("home") else m for m in rows)


def test_no_axis_is_asked_for_more_than_it_can() -> None:
    """A1 turns by 60 degrees along the 20 mm of the groove, or in the air above it, where the controller may brake."""
    needed = 60.0 / (20.0 / (FEED / 60.0))
    for most, said in ((needed, []), (0.9 * needed, ["axis-speed"])):
        cut = (CUT[0], *_turned((CUT[1],), 60.0))
        assert groove(*cut, end=_turned(END, 60.0), axis_speed=np.array([most, math.inf])) == said
    needed = 60.0 / (23.0 / (RAPID / 60.0))
    for most, said in ((needed / 3.0, []), (needed / 5.0, ["axis-speed"])):
        assert groove(*CUT, end=_turned(END, 60.0), axis_speed=np.array([most, math.inf])) == said


@pytest.mark.parametrize(
    ("cut", "end", "row"), [((CUT[0], *_turned((CUT[1],), 60.0)), END, 2), (CUT, _turned(END, 60.0), 3)]
)
def test_what_is_said_of_a_motion_names_the_files_line_that_it_is_made_for(cut, end, row: int) -> None:
    """The cut's of an axis that is too slow in it, the rapid's of one that is too slow in the air behind it."""
    story = file(*GROOVE)
    (objection,) = judged(
        story, program(*START, *cut, *_turned(end, 60.0)), axis_speed=np.array([10.0, math.inf])
    ).objections
    assert objection.code == "axis-speed"
    assert objection.cl_line == story.path.line[row] > 0


def test_cuts_in_the_air_that_the_file_lacks_are_not_judged() -> None:
    """Another program's region high above the part, at its feed; a way at half the rapid feed is one."""
    for share, expected in ((1.0, 0), (0.5, 0), (0.25, 1)):
        over = [lin(x, y, 80, at=share * RAPID) for x, y in ((20, 0), (40, 0), (40, 40), (20, 0))]
        found = judged(file(*GROOVE), program(*START, *CUT, *END[:-1], *over, END[-1]))
        assert found.objections == [] and len(found.unjudged) == expected


def test_what_is_clear_is_the_same_by_all_points_and_by_their_hull() -> None:
    """Of a cloud with points inside: a tip 1 mm above the highest along an axis is clear, 0.1 mm lower it isn't, asked along
    a thousand axes (all points are gone through) and along three thousand (their hull's corners are, from some axis on)."""
    draw = np.random.default_rng(16)
    solid, axes = draw.uniform(-0.05, 0.05, (4000, 3)), draw.normal(size=(3000, 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    clear = Clear(np.zeros((0, 3)), solid)
    for axis in map(tuple, axes.tolist()):
        top = (solid @ axis).max() + 1e-3
        over, under = (tuple(float(h * a) for a in axis) for h in (top + 2e-5, top - 1e-4))
        assert clear.above(over, axis) and not clear.above(under, axis)
