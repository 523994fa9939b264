"""RAPID's targets that a function moves: Offs along the work object's axes, RelTool along the tool's."""

from __future__ import annotations

import pytest

from camrob.witness.rapid.expressions import NotSaidError
from camrob.witness.rapid.records import Records

DOWN = "[[10,20,30],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"  # half a turn about x: the tool points down
TURNED = "[[0,0,0],[0.70710678,0,0,0.70710678],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"  # a quarter about z


@pytest.fixture
def records() -> Records:
    out = Records()
    out.declare("ROBTARGET", "P", DOWN)
    out.declare("ROBTARGET", "Q", TURNED)
    out.declare("NUM", "UP", "7")
    return out


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("OFFS(P,1,-2,3)", [11, 18, 33]),
        ("OFFS(P, 0, 0, UP)", [10, 20, 37]),
        ("RELTOOL(P,1,2,-50)", [11, 18, 80]),
        ("RELTOOL(Q,1,0,5)", [0, 1, 5]),
        ("OFFS(RELTOOL(P,0,0,5),1,0,0)", [11, 20, 25]),
        (f"OFFS({DOWN},0,0,1)", [10, 20, 31]),
    ],
)
def test_a_moved_target(records: Records, text: str, place: list[float]) -> None:
    value = records.value(text)
    assert isinstance(value, list) and value[0] == pytest.approx(place, abs=1e-9)
    source = records.value("Q" if "Q" in text else "P")
    assert isinstance(source, list) and value[1:] == source[1:]  # turned and configured as before


@pytest.mark.parametrize(
    "text",
    [
        "OFFS(P,1,2)",
        "OFFS(P,1,2,X)",
        "RELTOOL(P,1,2,3\\RX:=X)",
        "RELTOOL(P,1,2,3\\RX:=5\\RX:=5)",
        "OFFS(P,1,2,3\\RX:=5)",
        "OFFS(5,1,2,3)",
        "OFFS",
        "OFFS(P,1,2,3",
        "OFFS[P,1,2,3]",
    ],
)
def test_what_is_no_moved_target_is_not_said(records: Records, text: str) -> None:
    with pytest.raises(NotSaidError):
        records.value(text)
