"""A program entered at any of its operations, by the interpreter of the text faults' bench, which is no part of camrob: it has to
do what the whole program does from there on, with the tool, base, spindle and coolant of the list here.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from process_story import TOOL_FRAMES, TWO_TOOLS, cell_with, posted

from camrob import PostResult

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "bench"))

from text_faults.deeds import Deed, deeds
from text_faults.tree import Tree

# tool, rev/min, whether wet, where along Y it cuts
OPERATIONS = (
    (1, 3000, True, 0.0),
    (1, 3000, True, 6.0),
    (2, 4000, False, 12.0),
    (2, 5000, True, 18.0),
    (1, 3500, False, 24.0),
)


def part() -> str:
    """The CL file: what an operation doesn't change is said once, by the one in which it begins."""
    text, before = "UNITS/MM\n", (0, 0, False)
    for number, (tool, rpm, wet, y) in enumerate(OPERATIONS):
        text += f"TOOL PATH/OP{number},TOOL,MILL_{tool}\n"
        text += f"LOADTL/{tool}\n" if tool != before[0] else "STOP\n" if rpm == before[1] else ""
        text += f"SPINDL/{rpm},RPM,CLW\n" if (tool, rpm) != before[:2] else ""
        text += f"COOLNT/{'ON' if wet else 'OFF'}\n" if wet != before[2] else ""
        text += (
            f"RAPID\nGOTO/0,{y},30\nFEDRAT/300,MMPM\nGOTO/0,{y},2\nGOTO/15,{y},2\nRAPID\nGOTO/15,{y},30\nEND-OF-PATH\n"
        )
        before = tool, rpm, wet
    return text + "SPINDL/OFF\nCOOLNT/OFF\nFINI\n"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> PostResult:
    folder = tmp_path_factory.mktemp("entered")
    cell = cell_with(folder, (r"^spindle_rpm = ", "entries = true\nspindle_rpm = "))
    return posted(folder, "part.cls", part(), setup=TWO_TOOLS, cell=cell)


def done(made: PostResult, name: str, old: str = "", new: str = "") -> list[Deed]:
    """What the program does, with one of its texts changed."""
    texts = {file: (made.out / file).read_text() for file in (f"{name}.src", f"{name}.dat")}
    assert old in texts[f"{name}.src"]
    texts[f"{name}.src"] = texts[f"{name}.src"].replace(old, new, 1)
    found, left = deeds(Tree.of(f"{name}.src", texts))
    assert left == (), "an output that is left on"
    return found


def at_feed(deed: Deed) -> bool:
    return deed.kind == "lin" and abs(deed.speed - 0.005) < 1e-6


def told(found: list[Deed]) -> list[tuple[object, ...]]:
    """All of it but the posture, which each program chooses for itself."""
    out: list[tuple[object, ...]] = []
    for deed in found:
        place = tuple(deed.target.get(letter) for letter in "XYZ")
        out.append((deed.kind, place, deed.speed, deed.seconds, deed.state, deed.settings))
    return out


def cuts(found: list[Deed]) -> list[tuple[float, dict[str, str], dict[str, str]]]:
    """Y, settings and outputs of each motion at the feed."""
    slow = [deed for deed in found if at_feed(deed)]
    return [(deed.target["Y"], dict(deed.settings), dict(deed.state)) for deed in slow]


def test_every_entry_does_what_the_whole_program_does_from_there(made: PostResult) -> None:
    whole = done(made, "part")
    names = [Path(file).stem for file in made.files if file.endswith(".src")]
    assert len(names) == len(OPERATIONS)
    for number, name in enumerate(names):
        entered = done(made, name)
        rest = entered[next(k for k, deed in enumerate(entered) if at_feed(deed)) :]
        assert told(rest) == told(whole[-len(rest) :]), name
        assert {y for y, _, _ in cuts(entered)} == {y for _, _, _, y in OPERATIONS[number:]}


def test_each_cut_has_its_tool_spindle_and_coolant(made: PostResult) -> None:
    wanted = {y: (tool, rpm, wet) for tool, rpm, wet, y in OPERATIONS}
    for name in [Path(file).stem for file in made.files if file.endswith(".src")]:
        found = cuts(done(made, name))
        bases = {settings["$BASE"] for _, settings, _ in found}
        assert len(bases) == 1
        for y, settings, outputs in found:
            tool, rpm, wet = wanted[y]
            assert (
                f"X {TOOL_FRAMES[tool - 1][0]:.4f}" in settings["$TOOL"]
                and f"{TOOL_FRAMES[tool - 1][2]:.4f}" in settings["$TOOL"]
            )
            assert outputs["$OUT[1]"] == "TRUE" and float(outputs["$ANOUT[1]"]) == pytest.approx(rpm / 24000, abs=1e-5)
            assert ("$OUT[2]" in outputs) == wet


def test_the_interpreter_would_see_it(made: PostResult) -> None:
    name = Path([file for file in made.files if file.endswith(".src")][3]).stem
    plain = cuts(done(made, name))
    assert cuts(done(made, name, "$OUT[2] = TRUE", ";")) != plain
    assert cuts(done(made, name, "$ANOUT[1] = 5000", "$ANOUT[1] = 4000")) != plain
