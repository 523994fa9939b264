"""From one hole to the next a program goes as the file says: the retract height of a cycle is part of what was asked for."""

from __future__ import annotations

import pytest
from witness_stories import OFF, ON, RAPID, feed, file, hole, judged, lin, program, ptp, rapid

HOLES = (ON, rapid(0, 0, 25), rapid(0, 0, 5), hole(0, 0, -10), rapid(0, 0, 5), rapid(0, 0, 20), rapid(30, 0, 20))
LAST = (rapid(30, 0, 5), hole(30, 0, -10), rapid(30, 0, 5), rapid(30, 0, 20), OFF)
BEGIN = (ptp(), ON, ptp(0, 0, 60), lin(0, 0, 5, at=RAPID), lin(0, 0, -10), lin(0, 0, 5, at=RAPID))
OVER = (lin(30, 0, 5, at=RAPID), lin(30, 0, -10), lin(30, 0, 5, at=RAPID))
END = (lin(30, 0, 20, at=RAPID), OFF, lin(30, 0, 60, at=RAPID), ptp())
WAYS = {
    "as the file says": ((lin(0, 0, 20, at=RAPID), lin(30, 0, 20, at=RAPID)), []),
    "twenty higher": ((lin(0, 0, 40, at=RAPID), lin(30, 0, 40, at=RAPID)), ["retract-elsewhere"]),
    "higher over the next hole": (
        (lin(0, 0, 20, at=RAPID), lin(0, 0, 40, at=RAPID), lin(30, 0, 40, at=RAPID), lin(30, 0, 20, at=RAPID)),
        ["retract-elsewhere"],
    ),
    "up and back down on the spot": (
        (lin(0, 0, 40, at=RAPID), lin(0, 0, 20, at=RAPID), lin(30, 0, 20, at=RAPID)),
        ["retract-elsewhere"],
    ),
    "the arm changes its posture": ((lin(0, 0, 60, at=RAPID), ptp(30, 0, 60)), []),
    "the external axes move beneath the tool": (
        (lin(0, 0, 60, at=RAPID), lin(0, 0, 60, at=RAPID), lin(30, 0, 60, at=RAPID)),
        [],
    ),
}


@pytest.mark.parametrize("case", WAYS)
def test_from_hole_to_hole(case: str) -> None:
    way, wanted = WAYS[case]
    found = judged(file(*HOLES, *LAST), program(*BEGIN, *way, *OVER, *END)).objections
    assert sorted({o.code for o in found}) == wanted


def test_a_hole_that_is_left_at_the_feed() -> None:
    """A reamer's: its way out is a cut, and the rapids behind it are the cycle's all the same."""
    holes = (*HOLES[:4], feed(0, 0, 5), *HOLES[5:])
    begin = (*BEGIN[:-1], lin(0, 0, 5))
    for height, wanted in ((20, []), (40, ["retract-elsewhere"])):
        way = (lin(0, 0, height, at=RAPID), lin(30, 0, height, at=RAPID))
        found = judged(file(*holes, *LAST), program(*begin, *way, *OVER, *END)).objections
        assert sorted({o.code for o in found}) == wanted


def test_another_operation_is_come_to_as_the_cell_does() -> None:
    """Between two operations camrob links above everything: that is not the cycle's way."""
    story = file(*HOLES[:-1], rapid(30, 0, 20, begins=True), *LAST)
    way = (lin(0, 0, 60, at=RAPID), lin(30, 0, 60, at=RAPID))
    assert judged(story, program(*BEGIN, *way, *OVER, *END)).objections == []


def test_where_the_file_turns_the_tool_the_way_is_the_arms() -> None:
    """Behind a hole the tool is swung to another side in rapid: what that sweeps the file doesn't know."""
    leaning = (0.3, 0.0, 0.9539392)
    tilted = (rapid(30, 0, 60, axis=leaning), rapid(30, 0, 5, axis=leaning), feed(30, 0, -1, axis=leaning))
    story = file(*HOLES[:-1], *tilted, rapid(30, 0, 60, axis=leaning), OFF)
    swing = (lin(0, 0, 80, at=RAPID), lin(30, 0, 80, axis=leaning, at=RAPID), lin(30, 0, 60, axis=leaning, at=RAPID))
    end = (
        lin(30, 0, 5, axis=leaning, at=RAPID),
        lin(30, 0, -1, axis=leaning),
        lin(30, 0, 60, axis=leaning, at=RAPID),
        OFF,
        ptp(),
    )
    assert judged(story, program(*BEGIN, lin(0, 0, 20, at=RAPID), *swing, *end)).objections == []
