"""Bites of CYCL DEF 203 that get shorter, Okuma's datums, and the rapid where a set-up names none, as the witness judges them."""

from __future__ import annotations

from pathlib import Path

import pytest
from process_story import KR15, posted

from camrob.witness.cl import read_story
from camrob.witness.judge import judge

KLARTEXT = (
    "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S6000\n2 L X+0 Y+0 Z+40 R0 FMAX M3\n3 CYCL DEF 203 D Q200=2 Q201=-9 Q206=120 "
    "Q202=4 Q210=0 Q203=+0 Q204=20 Q212={} Q213={} Q205={} Q211=0 Q208=99999 Q256=0.2\n4 L X+5 FMAX M99\n"
    "5 L Z+40 FMAX\n6 M5\n7 M30\n8 END PGM A MM\n"
)
OKUMA = "G21 G90 G17 G94\nT1 M6\nS5000 M3\n{}G0 X0 Y0 Z9\nG1 Z0 F100\nX5\n{}X9\nM30\n"


def test_each_bite_is_shorter_by_q212_down_to_q205(tmp_path: Path) -> None:
    (tmp_path / "a.h").write_text(KLARTEXT.format(1, 0, 2), encoding="utf-8")
    story = read_story(tmp_path / "a.h")
    assert story.complete
    (pecks,) = story.pecks.values()
    # 4, 3 and 2 mm from the surface, which lies 2 mm below the clearance
    assert pecks.lows == pytest.approx((0.006, 0.009, 0.011)) and pecks.out


@pytest.mark.parametrize("values", [(1, 2, 2), (1, 0, 0), (1, 0, 5)])
def test_what_of_cycle_203_it_does_not_judge(tmp_path: Path, values: tuple[int, int, int]) -> None:
    """Chips that are broken; no least bite; one above the first."""
    (tmp_path / "a.h").write_text(KLARTEXT.format(*values), encoding="utf-8")
    (gap,) = read_story(tmp_path / "a.h").gaps
    assert "CYCL DEF 203" in gap.text


def test_a_datum_of_okumas_is_a_work_frame(tmp_path: Path) -> None:
    file = tmp_path / "a.nc"
    file.write_text(OKUMA.format("G15 H1\n", "G15 H1\n"), encoding="utf-8")
    assert read_story(file).complete
    file.write_text(OKUMA.format("G15 H1\n", "G15 H2\n"), encoding="utf-8")
    (gap,) = read_story(file).gaps
    assert "place in the part is not known" in gap.text and gap.first_line == 9


def test_air_is_held_to_the_usual_rapid_where_the_set_up_names_none(tmp_path: Path) -> None:
    made = posted(tmp_path, "a.h", KLARTEXT.format(1, 0, 2), setup="part_in_base = [0, 0, 200, 0, 0, 0]\n")
    program = next(made.out.glob("*.src"))
    for usual, codes in ((0.1, set()), (0.09, {"rapid-higher"}), (None, set())):
        verdict = judge(program, KR15, clfile=tmp_path / "in" / "a.h", usual_rapid=usual)
        assert {o.code for o in verdict.objections} == codes
