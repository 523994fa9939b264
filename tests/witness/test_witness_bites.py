"""Bites of CYCL DEF 203 that get shorter, Okuma's datums, and the rapid where a set-up names none, as the witness judges them."""

from __future__ import annotations

from pathlib import Path

import pytest
from process_story import KR15, posted

from camrob.errors import VerificationError
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


@pytest.mark.parametrize("values", [(1, 0.5, 2), (1, 0, 0), (1, 0, 5)])
def test_what_of_cycle_203_it_does_not_judge(tmp_path: Path, values: tuple[float, int, int]) -> None:
    """Chips that are broken half a time; no least bite; one above the first."""
    (tmp_path / "a.h").write_text(KLARTEXT.format(*values), encoding="utf-8")
    (gap,) = read_story(tmp_path / "a.h").gaps
    assert "CYCL DEF 203" in gap.text


def _program_of_breaks(tmp_path: Path) -> tuple[Path, list[str]]:
    """Bites of 2 mm, of which one breaks the chip before the tool comes out at 500 mm/min: the program's lines."""
    text = KLARTEXT.format(0, 1, 2).replace("Q202=4", "Q202=2").replace("Q208=99999", "Q208=500")
    made = posted(tmp_path, "a.h", text, setup="part_in_base = [0, 0, 200, 0, 0, 0]\n")
    assert not any("part" in warning.code for warning in made.summary.warnings)  # all of it is judged
    program = next(made.out.glob("*.src"))
    return program, program.read_text(encoding="ascii").split("\n")


def _objections(tmp_path: Path, program: Path, lines: list[str]) -> set[str]:
    program.write_text("\n".join(lines), encoding="ascii")
    return {o.code for o in judge(program, KR15, clfile=tmp_path / "in" / "a.h").objections}


def test_chips_are_broken_as_often_as_the_cycle_says_and_no_oftener(tmp_path: Path) -> None:
    program, lines = _program_of_breaks(tmp_path)
    heights = [float(row.split("Z ")[1].split(",")[0]) - 200.0 if row.startswith("LIN") else 99.0 for row in lines]
    lows = [z for z in heights if z < 2.5]
    assert lows == pytest.approx([2, -2, -1.8, -4, 2, -2, -6, -5.8, -8, 2, -6, -9, 2], abs=1e-3)
    out = [k for k, z in enumerate(heights) if z == pytest.approx(2.0)]
    assert _objections(tmp_path, program, lines) == set()
    stays = lines.copy()  # where the tool has to come out the chip is broken again: three bites in a row
    stays[out[1]] = lines[next(k for k, z in enumerate(heights) if z == pytest.approx(-1.8, abs=1e-3))]
    assert "peck-left-in" in _objections(tmp_path, program, stays)


@pytest.mark.parametrize("lift", [0.0, 0.1, 0.5])
def test_a_chip_is_broken_by_the_way_back_that_the_cycle_says(tmp_path: Path, lift: float) -> None:
    program, lines = _program_of_breaks(tmp_path)
    broken = next(k for k, row in enumerate(lines) if row.startswith("LIN") and "Z 198.200" in row)
    lines[broken] = lines[broken].replace("Z 198.200", f"Z {198.0 + lift:.3f}")
    assert ("chip-break" if lift else "peck-deeper") in _objections(tmp_path, program, lines)


def test_out_of_the_hole_no_faster_than_the_cycle_says(tmp_path: Path) -> None:
    program, lines = _program_of_breaks(tmp_path)
    feeds = [k for k, row in enumerate(lines) if row == "$VEL.CP = 0.008333"]
    assert feeds
    lines[feeds[0]] = "$VEL.CP = 0.050000"
    assert "entry-faster" in _objections(tmp_path, program, lines)


def test_a_datum_of_okumas_is_a_work_frame(tmp_path: Path) -> None:
    file = tmp_path / "a.nc"
    file.write_text(OKUMA.format("G15 H1\n", "G15 H1\n"), encoding="utf-8")
    assert read_story(file).complete
    file.write_text(OKUMA.format("G15 H1\n", "G15 H2\n"), encoding="utf-8")
    (gap,) = read_story(file).gaps
    assert "place in the part is not known" in gap.text and gap.first_line == 9


@pytest.mark.parametrize("up", [0.5, 5.0])
def test_between_bites_the_tool_comes_no_higher_than_the_cycle_says(tmp_path: Path, up: float) -> None:
    program, lines = _program_of_breaks(tmp_path)
    out = [k for k, row in enumerate(lines) if row.startswith("LIN") and "Z 202.000" in row]
    lines[out[1]] = lines[out[1]].replace("Z 202.000", f"Z {202.0 + up:.3f}")
    assert "peck-higher" in _objections(tmp_path, program, lines)


def test_out_of_the_hole_no_slower_and_not_rounded_off(tmp_path: Path) -> None:
    program, lines = _program_of_breaks(tmp_path)
    slow = lines.copy()
    feeds = [k for k, row in enumerate(lines) if row == "$VEL.CP = 0.008333"]
    slow[feeds[0]] = "$VEL.CP = 0.004000"
    assert "feed-lower" in _objections(tmp_path, program, slow)
    out = [k for k, row in enumerate(lines) if row.startswith("LIN") and "Z 202.000" in row]
    lines[out[1]] += " C_DIS"
    assert "hole-rounded" in _objections(tmp_path, program, lines)


def test_air_is_held_to_the_usual_rapid_where_the_set_up_names_none(tmp_path: Path) -> None:
    made = posted(tmp_path, "a.h", KLARTEXT.format(1, 0, 2), setup="part_in_base = [0, 0, 200, 0, 0, 0]\n")
    program = next(made.out.glob("*.src"))
    for speed, usual, codes in (("0.1", True, set()), ("0.102", True, {"rapid-higher"}), ("0.102", False, set())):
        program.write_text(program.read_text().replace("$VEL.CP = 0.100000", f"$VEL.CP = {speed}"))
        verdict = judge(program, KR15, clfile=tmp_path / "in" / "a.h", usual_rapid=usual)
        assert {o.code for o in verdict.objections} == codes
        program.write_text(program.read_text().replace(f"$VEL.CP = {speed}", "$VEL.CP = 0.100000"))


def test_the_gates_usual_rapid_is_not_the_writers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The writer's own number was handed to what judges it: ten times as much was released."""
    monkeypatch.setattr("camrob.jobs.files.inputs.RAPID_SPEED", 1.0)
    with pytest.raises(VerificationError, match="rapid"):
        posted(tmp_path, "a.h", KLARTEXT.format(1, 0, 2), setup="part_in_base = [0, 0, 200, 0, 0, 0]\n")


DEEP = (
    "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S6000\n2 L X+0 Y+0 Z+40 R0 FMAX M3\n3 CYCL DEF 200 Q200=2 Q201=-9 Q206=120 "
    "Q202=4 Q210=0 Q203=+0 Q204=20 Q211=0\n4 L X+5 FMAX M99\n5 L Z+40 FMAX\n6 M5\n7 M30\n8 END PGM A MM\n"
)


def _rows(tmp_path: Path) -> tuple[Path, list[str], dict[float, list[int]]]:
    """A posted deep hole, its lines, and which of them go to which height above the part's zero."""
    made = posted(tmp_path, "a.h", DEEP, setup="part_in_base = [0, 0, 200, 0, 0, 0]\n")
    program = next(made.out.glob("*.src"))
    lines = program.read_text(encoding="ascii").split("\n")
    heights: dict[float, list[int]] = {}
    for k, row in enumerate(lines):
        if row.startswith("LIN"):
            heights.setdefault(round(float(row.split("Z ")[1].split(",")[0]) - 200.0, 3), []).append(k)
    return program, lines, heights


def test_a_turn_between_two_bites_is_exact_in_what_camrob_writes(tmp_path: Path) -> None:
    """Rounded off, the tool turns before it is out: a warning of somebody else's program, and no excuse for our own."""
    program, lines, heights = _rows(tmp_path)
    tops = heights[2.0][1:]
    assert len(tops) == 2 and not any("C_DIS" in lines[k] for k in tops)
    assert _objections(tmp_path, program, lines) == set()
    lines[tops[0]] = lines[tops[0]].rstrip() + " C_DIS"
    assert _objections(tmp_path, program, lines) == {"peck-top-rounded"}


@pytest.mark.parametrize(("above", "passes"), [(0.0, False), (0.05, False), (0.15, True), (1.0, True)])
def test_no_rapid_ends_on_what_is_drilled(tmp_path: Path, above: float, passes: bool) -> None:
    program, lines, heights = _rows(tmp_path)
    (back,) = heights[-2.0]  # 2 mm above the first bite's end at -4
    lines[back] = lines[back].replace("Z 198.000", f"Z {196.0 + above:.3f}")
    assert _objections(tmp_path, program, lines) == (set() if passes else {"hole-onto-bottom"})
