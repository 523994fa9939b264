"""Every golden program is KRL, by a judge of form that shares nothing with reader, writer and witness."""

from __future__ import annotations

from pathlib import Path

import pytest
from krl_sample import small_program, written
from krl_syntax import faults

GOLDEN = Path(__file__).parents[1] / "golden"
SOURCES = sorted(GOLDEN.rglob("*.src"))


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.name)
def test_a_golden_program_is_krl(path: Path) -> None:
    assert faults(path.read_bytes().decode("ascii")) == []


def test_the_judge_sees_what_is_no_krl() -> None:
    text = written(small_program())["Fluegel_3.src"].decode("ascii")
    assert SOURCES and faults(text) == []
    for old, new in (
        ("LIN {", "LIM {"),
        ("LIN {E6POS: X ", "LIN {E6POS: X,"),
        ("} C_DIS", "} C_SPL"),
        ("PTP {", "PTP ({"),
        (";ENDFOLD", ";"),
        ("BAS (#INITMOV,0 )", "BAS #INITMOV,0"),
        ("$ADVANCE = 3", "$ADVANCE == 3"),
        ("\r\nEND\r\n", "\r\n"),
        ("DEF Fluegel_3 ( )", "DEF Fluegel_3"),
        ("&REL 1", "REL 1"),
        ("$VEL.CP = ", "$VEL.CP "),
    ):
        assert old in text and faults(text.replace(old, new, 1)), old
