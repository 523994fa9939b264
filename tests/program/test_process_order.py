"""What happens beside moving stands where the file has it: nothing overtakes a motion, and tools are changed in the clear."""

from __future__ import annotations

from pathlib import Path

import pytest
from process_story import GCODE, KR15, PLACE, ROOT, cell_with, posted, story, text_of

import camrob.languages.krl.writer.write_krl as krl_writer
from camrob.cell.read_cell import read_cell
from camrob.errors import CamrobError, JobError, VerificationError
from camrob.jobs.post import PostResult
from camrob.jobs.verify import verify
from camrob.program.process import plan_process
from camrob.summaries.remarks import Remark
from camrob.toolpath.read import read_toolpath

NX = """TOOL PATH/A,TOOL,T1
TLDATA/MILL,10.0,0.0,75.0,0.0,0.0
MSYS/0.0,0.0,0.0,1.0,0.0,0.0,0.0,1.0,0.0
LOAD/TOOL,1
SPINDL/RPM,3000,CLW
COOLNT/ON
RAPID
GOTO/0.0,0.0,25.0,0.0,0.0,1.0
FEDRAT/MMPM,300.0
GOTO/0.0,0.0,2.0
GOTO/20.0,0.0,2.0
RAPID
GOTO/20.0,0.0,25.0
LOAD/TOOL,2
SPINDL/RPM,4000,CLW
COOLNT/ON
RAPID
GOTO/30.0,0.0,25.0
GOTO/30.0,0.0,2.0
GOTO/40.0,0.0,2.0
RAPID
GOTO/40.0,0.0,25.0
END-OF-PATH
"""
CAMWORKS = """PARTNO T
UNIT/MM
CUTTER/8.,0,4.,0,0,0,64.
LOAD/TOOL,1
SPINDL/3000,RPM,CLW
RAPID/
GOTO/0,0,25.
FEDRAT/300.,MMPM
GOTO/0,0,2.
GOTO/20.,0,2.
RAPID/
GOTO/20.,0,25.
CUTTER/6.,0,3.,0,0,0,64.
LOAD/TOOL,2
SPINDL/4000,RPM,CLW
RAPID/
GOTO/30.,0,25.
FEDRAT/300.,MMPM
GOTO/30.,0,2.
GOTO/40.,0,2.
RAPID/
GOTO/40.,0,25.
FINI
"""
START = ["home", "tool 1", "speed 3000", "on"]
END = ["home", "off", "dry"]
TURNS_BOTH_WAYS = (
    r"^spindle_off = ",
    'spindle_on_ccw = ["$ANOUT[1] = {speed} / 24000.0", "$OUT[3] = TRUE"]\nspindle_off = ',
)
SLOW = (r"^spindle_rpm = .*", "spindle_rpm = [100, 24000]")


def plain(made: PostResult) -> list[str]:
    return story(text_of(made))


def test_two_tools_in_g_code(tmp_path: Path) -> None:
    made = posted(tmp_path, "part.nc", GCODE)
    assert plain(made) == [
        *START,
        "0 100",
        "0 45",
        "0 2",
        "20 2",
        "20 50",
        "20 100",
        "off",
        "home",
        "tool 2",
        "speed 4000",
        "on",
        "26 100",
        "26 50",
        "26 5",
        "26 2",
        "40 2",
        "40 50",
        "40 100",
        "off",
        *END,
    ]
    process = made.summary.process
    assert process.events_in_file == process.events_in_program == 6
    assert process.spindle == ((4, 3000.0, "CLW"), (11, 4000.0, "CLW"))
    assert [(c.line, c.number) for c in process.tool_changes] == [(10, 2)]
    assert verify(made.out / "part.src", cell=KR15, against=tmp_path / "in" / "part.nc").ok


def test_two_tools_in_nx_clsf(tmp_path: Path) -> None:
    """The file says nothing of spindle and coolant before the change: both are stopped for it."""
    assert plain(posted(tmp_path, "part.cls", NX)) == [
        *START,
        "wet",
        "0 75",
        "0 25",
        "0 2",
        "20 2",
        "20 25",
        "20 75",
        "off",
        "dry",
        "home",
        "tool 2",
        "speed 4000",
        "on",
        "wet",
        "30 75",
        "30 25",
        "30 2",
        "40 2",
        "40 25",
        "40 75",
        *END,
    ]


def test_two_tools_in_camworks(tmp_path: Path) -> None:
    made = posted(tmp_path, "part.apt", CAMWORKS)
    assert plain(made) == [
        *START,
        "0 75",
        "0 25",
        "0 2",
        "20 2",
        "20 25",
        "20 75",
        "off",
        "home",
        "tool 2",
        "speed 4000",
        "on",
        "30 75",
        "30 25",
        "30 2",
        "40 2",
        "40 25",
        "40 75",
        *END,
    ]
    assert [w.code for w in made.summary.warnings].count("one-tool-for-several") == 1


def test_coolant_that_the_file_leaves_on_is_on_behind_the_change(tmp_path: Path) -> None:
    second = NX.rindex("COOLNT/ON\n")
    made = posted(tmp_path, "part.cls", NX[:second] + NX[second + len("COOLNT/ON\n") :])
    lines = plain(made)
    assert lines[lines.index("dry") :][:6] == ["dry", "home", "tool 2", "speed 4000", "on", "wet"]


@pytest.mark.parametrize("kind", ["M7", "M8"])
def test_so_is_coolant_of_a_kind_that_the_program_does_not_tell_apart(tmp_path: Path, kind: str) -> None:
    lines = (
        f"G21 G90 G17\nT1 M6\nS3000 M3\nG0 X0 Y0 Z50\n{kind}\nG1 Z2 F300\nX20\nG0 Z50\nM5\nT2 M6\nS4000 M3\nG0 X30 Y0\n"
    )
    steps = plain(posted(tmp_path, "part.nc", f"{lines}G1 Z2 F280\nX40\nG0 Z50\nM5\nM30\n"))
    assert steps[steps.index("dry") :][:6] == ["dry", "home", "tool 2", "speed 4000", "on", "wet"]


def test_coolant_that_the_file_switches_again_behind_the_change_is_switched_once(tmp_path: Path) -> None:
    """It is left on at the change, and the next operation speaks of it on its way to the first cut."""
    lines = "G21 G90 G17\nT1 M6\nS3000 M3\nG0 X0 Y0 Z50\nM8\nG1 Z2 F300\nX20\nG0 Z50\nM5\nT2 M6\nS4000 M3\nG0 X30 Y0\nZ25\nM8\n"
    steps = plain(posted(tmp_path, "part.nc", f"{lines}G1 Z2 F280\nX40\nG0 Z50\nM5\nM9\nM30\n"))
    assert steps.count("wet") == 2 and steps[steps.index("tool 2") :].index("30 25") < steps[
        steps.index("tool 2") :
    ].index("wet")


def test_a_machine_position_is_left_by_way_of_the_cells_own_retract(tmp_path: Path) -> None:
    """G28 in the middle of an operation, and nothing is changed: the straight way would go through the wall between."""
    content = GCODE.replace("G0 Z50\nM5\nT2 M6\nS4000 M3\n", "G91 G28 Z0\nG90\n").replace("X26 Y0\nZ5", "X26 Y0 Z5")
    lines = plain(posted(tmp_path, "part.nc", content))
    assert lines[lines.index("20 2") :][:5] == ["20 2", "20 100", "26 100", "26 5", "26 2"]


def test_what_stands_at_depth_behind_the_last_cut_waits_for_the_clear(tmp_path: Path) -> None:
    """A dwell stays where the file has it; the spindle stops above the part."""
    content = NX[: NX.index("RAPID\nGOTO/20.0,0.0,25.0")] + "DELAY/1.5\nSPINDL/OFF\nEND-OF-PATH\n"
    assert plain(posted(tmp_path, "part.cls", content)) == [
        *START,
        "wet",
        "0 75",
        "0 25",
        "0 2",
        "20 2",
        "wait 1.5",
        "20 75",
        "off",
        *END,
    ]


def test_events_on_the_way_stand_between_their_motions(tmp_path: Path) -> None:
    content = CAMWORKS[: CAMWORKS.index("CUTTER/6.")] + "FINI\n"
    content = content.replace(
        "GOTO/20.,0,2.\n", "GOTO/10.,0,2.\nCOOLNT/ON\nDELAY/2\nGOTO/20.,0,2.\nSPINDL/3500,RPM,CLW\n"
    )
    content = content.replace("FINI\n", "STOP\nRAPID/\nGOTO/0,0,25.\nGOTO/0,0,2.\nRAPID/\nGOTO/0,0,25.\nFINI\n")
    assert plain(posted(tmp_path, "part.apt", content)) == [
        *START,
        "0 75",
        "0 25",
        "0 2",
        "10 2",
        "wet",
        "wait 2",
        "20 2",
        "speed 3500",
        "on",
        "20 25",
        "stop",
        "0 25",
        "0 2",
        "0 25",
        "0 75",
        *END,
    ]


@pytest.mark.parametrize("decimate", [0.0, 0.05])
def test_an_event_keeps_its_point_when_points_are_thinned_out(tmp_path: Path, decimate: float) -> None:
    points = "".join(f"GOTO/{x / 2:g},0,2.\n" for x in range(1, 21))
    content = CAMWORKS[: CAMWORKS.index("CUTTER/6.")] + "FINI\n"
    content = content.replace(
        "GOTO/20.,0,2.\n", f"{points}COOLNT/ON\n{points.replace('GOTO/', 'GOTO/1')}GOTO/20.,0,2.\n"
    )
    lines = plain(posted(tmp_path, "part.apt", content, setup=f"{PLACE}decimate_mm = {decimate}\n"))
    at = lines.index("wet")
    assert lines[at - 1] == "10 2" and (len(lines) < 30 if decimate else len(lines) > 40)


def test_a_drilling_cycle_that_names_a_step_pecks(tmp_path: Path) -> None:
    """Without the word DEEP; what is released is what the witness reads too."""
    cycle = "CYCLE/DRILL,RAPTO,3.0,FEDTO,-10.0,STEP,4.0,RTRCTO,20.0,MMPM,300.0\nGOTO/0.0,0.0,0.0\nCYCLE/OFF\n"
    content = NX[: NX.index("FEDRAT")] + cycle + "RAPID\nGOTO/0.0,0.0,25.0\nEND-OF-PATH\n"
    made = posted(tmp_path, "part.cls", content)
    lines = plain(made)
    assert lines[lines.index("0 3") :][:9] == ["0 3", "0 -4", "0 3", "0 -3.5", "0 -8", "0 3", "0 -7.5", "0 -10", "0 20"]
    assert verify(made.out / "part.src", cell=KR15, against=tmp_path / "in" / "part.cls").ok


# ---- sense and speed of the spindle

TAP = """TOOL PATH/TAPPING,TOOL,M6
TLDATA/MILL,6.0,0.0,60.0,0.0,0.0
MSYS/0.0,0.0,0.0,1.0,0.0,0.0,0.0,1.0,0.0
LOAD/TOOL,1
SPINDL/RPM,300.0,CCLW
RAPID
GOTO/0.0,0.0,50.0,0.0,0.0,1.0
CYCLE/TAP,RAPTO,3.0,FEDTO,-10.0,RTRCTO,AUTO,MMPM,300.0
GOTO/0.0,0.0,0.0
CYCLE/OFF
RAPID
GOTO/0.0,0.0,50.0
END-OF-PATH
"""


def refused(tmp_path: Path, content: str, *, name: str = "part.apt", **options) -> JobError:
    """What stands against a job; nothing is left behind."""
    with pytest.raises(JobError) as caught:
        posted(tmp_path, name, content, **options)
    assert not (tmp_path / "out").exists()
    return caught.value


def test_a_tap_comes_out_turning_the_other_way(tmp_path: Path) -> None:
    """Always by way of off; the cell's spindle turns both ways."""
    cell = cell_with(tmp_path, TURNS_BOTH_WAYS, SLOW)
    lines = plain(posted(tmp_path, "part.cls", TAP, cell=cell))
    assert lines == [
        "home",
        "tool 1",
        "speed 300",
        "on, reversed",
        "0 100",
        "0 50",
        "0 3",
        "0 -10",
        "off",
        "speed 300",
        "on",
        "0 3",
        "off",
        "speed 300",
        "on, reversed",
        "0 50",
        "0 100",
        *END,
    ]


def test_a_sense_that_the_spindle_lacks_is_refused(tmp_path: Path) -> None:
    error = refused(tmp_path, CAMWORKS.replace("CLW", "CCLW", 1))
    assert error.line == 5 and "counter-clockwise" in error.what and "spindle_on_ccw" in error.what


@pytest.mark.parametrize(("speed", "limit"), [(30000, 24000.0), (999, 1000.0)])
def test_a_speed_that_the_spindle_lacks_is_refused(tmp_path: Path, speed: int, limit: float) -> None:
    error = refused(tmp_path, CAMWORKS.replace("4000", str(speed)))
    assert (error.line, error.value, error.limit, error.unit) == (15, speed, limit, "rev/min")
    assert "CAM system" in error.what


@pytest.mark.parametrize("speed", [1000, 24000])
def test_the_ends_of_the_spindles_range_are_in_it(tmp_path: Path, speed: int) -> None:
    assert f"speed {speed}" in plain(posted(tmp_path, "part.apt", CAMWORKS.replace("4000", str(speed))))


def test_a_cell_that_does_not_say_its_spindles_range_warns(tmp_path: Path) -> None:
    cell = cell_with(tmp_path, (r"^spindle_rpm = .*\n", ""))
    made = posted(tmp_path, "part.apt", CAMWORKS.replace("4000", "90000"), cell=cell)
    warning = next(w for w in made.summary.warnings if w.code == "spindle-range-unknown")
    assert "3000 to 90000" in warning.text and warning.line == 5


def urgent(made: PostResult, code: str) -> Remark:
    """A warning before which there is none on anything but the spindle (the witness has its own)."""
    warnings = made.summary.warnings
    at = next(k for k, w in enumerate(warnings) if w.code == code)
    assert all("spindle" in w.code for w in warnings[:at])
    return warnings[at]


def test_a_cut_with_no_spindle_ever_on_warns_first_of_all(tmp_path: Path) -> None:
    content = "".join(line for line in CAMWORKS.splitlines(keepends=True) if not line.startswith("SPINDL"))
    made = posted(tmp_path, "part.apt", content)
    first = urgent(made, "spindle-never-on")
    assert first.line == 8 and "spindle_rpm in setup.toml" in first.text
    assert "on" not in plain(made)
    served = posted(tmp_path, "part.apt", content, setup=PLACE + "spindle_rpm = 5000\n")
    assert plain(served).count("speed 5000") == 2 and "spindle-never-on" not in str(served.summary.warnings)


def test_a_cut_behind_a_change_that_nothing_starts_the_spindle_for_is_refused(tmp_path: Path) -> None:
    error = refused(tmp_path, CAMWORKS.replace("SPINDL/4000,RPM,CLW\n", ""))
    assert error.line == 18 and "tool 2" in error.what and "line 14" in error.what


def test_a_cut_that_the_file_itself_makes_with_the_spindle_off_is_said(tmp_path: Path) -> None:
    made = posted(tmp_path, "part.apt", CAMWORKS.replace("SPINDL/4000,RPM,CLW", "SPINDL/OFF"))
    assert urgent(made, "spindle-off").line == 19


@pytest.mark.parametrize(("before", "said"), [("", [13]), ("SPINDL/OFF\n", [])])
def test_a_stop_with_the_spindle_running_is_said(tmp_path: Path, before: str, said: list[int]) -> None:
    made = posted(tmp_path, "part.apt", CAMWORKS.replace("CUTTER/6.,0", f"{before}STOP\nCUTTER/6.,0"))
    assert [w.line for w in made.summary.warnings if w.code == "stop-running"] == said


def test_a_cell_without_a_hook_for_changes_can_t_change(tmp_path: Path) -> None:
    cell = cell_with(tmp_path, (r"^tool_change = .*\n", ""))
    error = refused(tmp_path, CAMWORKS, cell=cell)
    assert error.line == 14 and "tool_change" in error.what


def test_a_tool_without_a_number_needs_a_hook_that_prints_none(tmp_path: Path) -> None:
    content = NX.replace("LOAD/TOOL,1\n", "").replace("LOAD/TOOL,2\n", "END-OF-PATH\nTOOL PATH/B,TOOL,T2\n")
    made = posted(tmp_path, "part.cls", content)  # the hook's number stands in a comment
    text = text_of(made)
    assert text.index("; tool T1") < text.index("; tool T2") < text.index("HALT ;change to tool 0")
    assert made.summary.process.tool_changes[0].name == "T2"
    cell = cell_with(tmp_path, (r"^tool_change = .*", 'tool_change = ["CHANGE_TOOL ({number})"]'))
    shown = tmp_path / "again"
    shown.mkdir()
    assert "T2" in refused(shown, content, name="part.cls", cell=cell).what


# ---- every real file


def test_nothing_is_lost_between_file_and_steps() -> None:
    """Each event of a file is a step, in the file's order; what camrob adds says so."""
    shared = ROOT.parent / "shared" / "corpus" / "cldata"
    if not shared.is_dir():
        pytest.skip("../shared/corpus is not here")
    cell = read_cell(KR15)
    seen = 0
    for file in sorted(shared.iterdir()):
        try:
            regions = read_toolpath(file).regions
            steps = plan_process(regions, cell).steps
        except CamrobError:  # what can't be read, or done on this cell, is not the matter here
            continue
        wanted = [(e.kind, e.line) for region in regions for e in region.events]
        assert [(s.kind, s.line) for s in steps if not s.added] == wanted, file.name
        seen += 1
    assert seen >= 8


# ---- refusals


def test_a_refusal_names_the_cl_line_and_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A fault in a text that nobody keeps: its own line numbers would mean nothing."""
    written = krl_writer.iter_krl

    def faulty(*arguments, **options):
        for file, data in written(*arguments, **options):
            yield file, data.replace(b"LIN {E6POS: X 40.000", b"LIN {E6POS: X 40.500", 1)

    monkeypatch.setattr(krl_writer, "iter_krl", faulty)
    error = refused(tmp_path, CAMWORKS)
    assert isinstance(error, VerificationError) and 20 <= error.line <= 22 and error.region == "T"
    assert "report this file" in error.what


def test_a_text_that_does_not_read_back_is_placed_in_the_cl_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written = krl_writer.iter_krl

    def faulty(*arguments, **options):
        for file, data in written(*arguments, **options):
            yield file, data.replace(b"LIN {E6POS: X 40.000", b"LIN {E6POS: X 4O.000", 1)

    monkeypatch.setattr(krl_writer, "iter_krl", faulty)
    error = refused(tmp_path, CAMWORKS)
    assert error.line == 20 and error.region == "T" and "reads back wrong" in error.what and "4O.000" in error.what


@pytest.mark.slow
def test_out_of_reach_is_said_with_line_region_and_what_to_do(tmp_path: Path) -> None:
    error = refused(tmp_path, CAMWORKS.replace("GOTO/40.,0,2.", "GOTO/4000.,0,2."))
    assert error.line == 20 and error.region == "T" and "part_in_base" in error.what
