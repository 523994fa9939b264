"""What a refusal by the witness says to the person who posted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from camrob.errors import VerificationError
from camrob.jobs.release.opinion import hold_to_witness
from camrob.witness.cl.customs import ASIDE, COMPUTED
from camrob.witness.cl.drilling import UPWARD
from camrob.witness.cl.foreign.foreign_cycles import ACROSS
from camrob.witness.cl.gcode import GcodeReader
from camrob.witness.cl.offsets import Offsets
from camrob.witness.cl.running.unread import NOWHERE
from camrob.witness.cl.standing import TURNED, UNNAMED
from camrob.witness.cl.teller import NO_CIRCLE, UNREAD, Teller
from camrob.witness.cl.words import NO_AXIS, STRANGE
from camrob.witness.happenings import Objection, Way
from camrob.witness.judge import Verdict

LIN = "LIN {X 10.000,Y 0.000,Z 0.000,A 0.0000,B 0.0000,C 0.0000}"


def _verdict(*objections: Objection) -> Verdict:
    return Verdict(objections, (), {}, 0, 0, True, files=("part.src", "part_2.src"))


def test_the_statement_is_quoted_and_the_rest_counted(tmp_path: Path) -> None:
    (tmp_path / "part.src").write_text("DEF part()\nPART_2()\nEND\n")
    (tmp_path / "part_2.src").write_text(f"DEF part_2()\n {LIN}\nEND\n")
    off = Objection("motion-extra", "line 2 of the program does not run along line 6 of the file", 6, 2, file=1)
    with pytest.raises(VerificationError) as refused:
        hold_to_witness(_verdict(off, off), tmp_path)
    assert f"'{LIN}' does not run along line 6 of the file (1 more such objection)" in str(refused.value)
    assert refused.value.line == 6


def test_a_long_statement_is_cut_and_a_file_that_is_gone_leaves_the_text(tmp_path: Path) -> None:
    (tmp_path / "part.src").write_text("; " + 200 * "x" + "\n")
    said = Objection("a", "line 1 of the program is odd", 1, 1, file=0)
    with pytest.raises(VerificationError, match=r"x{88}\.\.\.' is odd; "):
        hold_to_witness(_verdict(said), tmp_path)
    with pytest.raises(VerificationError, match="line 1 of the program is odd"):
        hold_to_witness(_verdict(said), tmp_path / "gone")


@pytest.mark.parametrize(
    ("code", "released"),
    [
        ("no-status-turn", False),
        ("ends-elsewhere", False),
        ("path-from-home", False),
        ("peck-top-rounded", False),
        ("spline-unasked", False),
        ("axis-absent", False),
        ("no-hook", True),
    ],
)
def test_what_is_a_warning_in_anothers_program_is_none_in_our_own(tmp_path: Path, code: str, released: bool) -> None:
    said = _verdict(Objection(code, "something odd", severity="warning"))
    if released:
        assert [f.code for f in hold_to_witness(said, tmp_path)] == [code]
    else:
        with pytest.raises(VerificationError, match="something odd"):
            hold_to_witness(said, tmp_path)


@pytest.mark.parametrize("gap", [ACROSS, ASIDE, NOWHERE, NO_AXIS, NO_CIRCLE, STRANGE, TURNED, UNNAMED, UPWARD])
def test_no_program_of_a_file_that_camrob_refuses_is_released(tmp_path: Path, gap: str) -> None:
    """Camrob's own reader refuses such arcs and axes: where one got past it, the gap is no reason to release in part."""
    with pytest.raises(VerificationError, match=gap):
        hold_to_witness(
            Verdict((), (f"lines 4 to 9 of the file: {gap}",), {}, 0, 0, False, files=("part.src",)), tmp_path
        )
    nurbs = Verdict((), ("line 7 of the file: NURBS",), {}, 0, 0, False, files=("part.src",))
    assert [f.code for f in hold_to_witness(nurbs, tmp_path)] == ["verified-in-part"]


@pytest.mark.parametrize(
    ("radius", "gaps"), [(10.0, []), (10.03, ["an arc whose centre doesn't fit its ends"]), (13.0, [NO_CIRCLE])]
)
def test_arcs_whose_ends_lie_on_no_circle(radius: float, gaps: list[str]) -> None:
    tell = Teller(0.01, None)
    up = np.array([0.0, 0.0, 1.0])
    tell.move(np.array([0.01, 0.0, 0.0]), up, Way.FEED, 1)
    tell.arc(np.array([0.0, radius / 1000.0, 0.0]), up, np.zeros(3), up, Way.FEED, 2)
    assert [gap.text for gap in tell.gaps] == gaps


def test_the_reader_of_the_second_opinion_calls_macros_by_that_name() -> None:
    tell = Teller(None, None)
    GcodeReader(tell, None, Offsets(tell, wear=False)).read("G21 G90\n#100=#500\nG0 X0 Y0 Z9\nG1 X#100 F100\nX7\n")
    assert next((gap.first_line, gap.text[: len(UNREAD + COMPUTED)]) for gap in tell.gaps) == (2, UNREAD + COMPUTED)
