"""The gate for a language that camrob does not ship: its folder, a line of the registry, and its file of the witness."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from process_story import TWO_TOOLS
from rapid_job import CELL as IRB6700
from rapid_job import PART

import camrob.controller
import camrob.gap
import camrob.jobs
import camrob.program
from camrob import PostResult, post
from camrob.controller.replay import replay
from camrob.errors import CellError, InputError
from camrob.jobs.simulate import simulate
from camrob.jobs.verify import verify
from camrob.languages import LANGUAGES, Registered, language_named, language_of_file
from camrob.program.builder import build_program
from camrob.program.program import ProgramEvent, ProgramEventKind
from camrob.witness.happenings import Kind
from camrob.witness.machine import read_machine
from camrob.witness.programs import PROGRAMS, run_program

ROOT = Path(__file__).resolve().parents[2]
KR15 = ROOT / "cells" / "kr15_track_table"
CONTROLLER = """[controller]
language = "lines"
acc_cp_m_s2 = 2
vel_ori_deg_s = 200
acc_ori_deg_s2 = 400
apo_cdis_mm = 0.5
advance = 5
ptp_velocity_percent = 10
max_lines = 20000
max_bytes = 4000000
max_line_length = 255
spindle_rpm = [1000, 24000]
tool_change_pose = [20, -80, 100, 10, 60, 5, 300, 30]
standing = "assumed"

[controller.hooks]
spindle_on = ["do spindle on {speed}"]
spindle_off = ["do spindle = off"]
coolant_on = ["do coolant on"]
coolant_off = ["do coolant = off"]
tool_change = ["do change {number}"]
stop = ["do stop"]
footer = ["do spindle = off", "do coolant = off"]

"""


@pytest.fixture(autouse=True)
def registered(monkeypatch):
    """All that a language's owner adds."""
    monkeypatch.setitem(LANGUAGES, "lines", Registered("second_language", (".lines",)))
    monkeypatch.setitem(PROGRAMS, ".lines", "second_language.witness")


def cell(folder: Path, *changes: tuple[str, str]) -> Path:
    """The KR15 cell with a controller that takes the second language."""
    made = shutil.copytree(KR15, folder / "cell", dirs_exist_ok=True)
    text = (made / "cell.toml").read_text()
    begin, end = text.index("[controller]"), text.index("# The published method's settings")
    section = CONTROLLER
    for old, new in changes:
        assert old in section
        section = section.replace(old, new)
    (made / "cell.toml").write_text(text[:begin] + section + text[end:])
    return made


@pytest.fixture
def made(tmp_path) -> PostResult:
    (tmp_path / "part.nc").write_text(PART)
    (tmp_path / "setup.toml").write_text(TWO_TOOLS)
    return post(tmp_path / "part.nc", cell=cell(tmp_path), out=tmp_path / "out")


def test_the_gate_releases_it_and_its_faults_are_found(made: PostResult, tmp_path) -> None:
    main = made.out / "part.lines"
    text = main.read_text()
    assert {f for f in made.files} == {f"part.{x}" for x in ("lines", "json", "path.npz", "html")}
    assert made.summary.witness.complete and made.summary.witness.judged_events == 8
    assert "the Lines reader" in made.summary.verified.by
    assert made.summary.manifest.program.keys() == {"part.lines"}
    assert text.count("\ntool ") == 2 and text.count("do change") == 2 and text.count("arc ") >= 1
    again = verify(main, cell=tmp_path / "cell", against=tmp_path / "part.nc", collisions=False)
    assert again.ok, again.summary.errors
    faults = {
        "an event less": ("do coolant on\n", "", "coolant"),
        "another speed of the spindle": ("do spindle on 4000", "do spindle on 3000", "spindle-differs"),
        "a shorter dwell": ("wait 1.5000", "wait 0.5000", "event-lost"),
        "another tool": ("tool 12.00000", "tool 12.50000", "tool"),
        "faster": ("speed 0.0050000", "speed 0.0500000", "feed-higher"),
        "what nobody knows": ("do coolant on", "shout coolant on", "not-judged"),
    }
    for fault, (old, new, code) in faults.items():
        assert old in text, fault
        main.write_text(text.replace(old, new))
        found = verify(main, cell=tmp_path / "cell", against=tmp_path / "part.nc", collisions=False, manifest=False)
        assert not found.ok and any(code in f.code for f in found.findings), (fault, found.summary.errors[:3])
    lines = text.split("\n")
    at = next(k for k, line in enumerate(lines) if line.startswith("line"))
    lines[at] = re.sub(r"^line (\S+)", lambda m: f"line {float(m[1]) + 0.05:.5f}", lines[at])
    main.write_text("\n".join(lines))
    assert (
        verify(main, cell=tmp_path / "cell", against=tmp_path / "part.nc", collisions=False, manifest=False).ok is False
    )


def test_the_same_job_goes_the_same_way_in_either_language(made: PostResult, tmp_path) -> None:
    text = (KR15 / "cell.toml").read_text()
    kr15 = shutil.copytree(KR15, tmp_path / "kr15")
    pose = "tool_change_pose = [20, -80, 100, 10, 60, 5, 300, 30]\nspindle_rpm = "
    (kr15 / "cell.toml").write_text(text.replace("\nspindle_rpm = ", "\n" + pose))
    other = post(tmp_path / "part.nc", cell=kr15, out=tmp_path / "krl")
    assert len(other.program) == len(made.program) and np.array_equal(other.program.kind, made.program.kind)
    places = (np.asarray(result.program.pose)[:, :3] for result in (other, made))
    assert np.abs(np.subtract(*places)).max() < 6e-4  # KRL prints micrometres
    ends = [
        replay(language_of_file(file).read(file), result.path and one).q
        for file, result, one in (
            (tmp_path / "krl" / "part.src", other, _cell(kr15)),
            (made.out / "part.lines", made, _cell(tmp_path / "cell")),
        )
    ]
    assert np.abs(np.asarray(ends[0]) - np.asarray(ends[1])).max() < 1e-4


def _cell(folder: Path):
    from camrob.jobs.files.cell_for import cell_for

    return cell_for("verify", folder)


def test_other_verbs_take_it_by_its_suffix(tmp_path) -> None:
    source = ROOT / "toolpaths" / "engraving"
    made = post(source / "engraving.cls", cell=cell(tmp_path), out=tmp_path / "out", max_lines=100, report=False)
    assert len([f for f in made.files if f.endswith(".lines")]) > 2
    run = simulate(made.out / "engraving.lines", cell=tmp_path / "cell", out=tmp_path / "log.csv")
    assert run.summary.motions == len(made.program) and run.summary.approximation.corners > 0


def test_a_language_that_nobody_knows_is_refused_with_the_known_ones(tmp_path) -> None:
    with pytest.raises(CellError, match="'other'; the languages are krl, lines"):
        _cell(cell(tmp_path, ('"lines"', '"other"')))
    with pytest.raises(InputError, match=r"ends with \.src or (.* or )?\.lines"):
        language_of_file(tmp_path / "program.txt")


def test_what_a_cell_says_of_its_controller_is_the_languages_business(tmp_path) -> None:
    with pytest.raises(CellError, match="ori_type is nothing that Lines takes"):
        _cell(cell(tmp_path, ("advance = 5", 'advance = 5\nori_type = "#VAR"')))
    with pytest.raises(CellError, match="hook stop"):
        _cell(cell(tmp_path, ('"do stop"', '"HALT"')))
    assert language_named("lines").title == "Lines"


# messages that name the frame as the cell's owner knows it, and the tracker's options
_SAID_TO_PEOPLE = {"granted.py", "mounting.py", "track_options.py"}
_EXAMPLE = re.compile(r"\n    Example:\n(?:        .*\n)+")  # of a docstring: with files that a user has
# words that only a language's own folder says
_OF_A_LANGUAGE = re.compile(
    r"\bkrl|KRL|Krl|\$(?:APO|VEL|ACC|TOOL|BASE|ADVANCE|ORI_TYPE)\b|\.(?:src|dat)\b|\bC_(?:DIS|PTP|VEL|ORI)\b"
)


@pytest.mark.parametrize(
    "room", [camrob.controller, camrob.gap, camrob.jobs, camrob.program], ids=lambda room: room.__name__
)
def test_programs_controller_gap_and_jobs_name_no_language(room) -> None:
    """Identifiers, imports, suffixes and system variables; the loop with the laser tracker speaks RSI, which is KUKA's own."""
    folder = Path(room.__file__).parent
    faults = []
    for file in sorted(folder.rglob("*.py")):
        if "tracker" in file.parent.name or file.name in _SAID_TO_PEOPLE:
            continue
        text = _EXAMPLE.sub(lambda example: "\n" * example[0].count("\n"), file.read_text(encoding="utf-8"))
        for number, line in enumerate(text.splitlines(), start=1):
            if _OF_A_LANGUAGE.search(line):
                faults.append(f"{file.name}:{number}: {line.strip()[:100]}")
    assert not faults, "\n".join(faults)


@pytest.mark.parametrize("name", ["krl", "rapid", "lines"])
def test_the_witness_hears_each_event_where_the_program_has_it(name: str, tmp_path) -> None:
    """From the program's events to the witness's, by a text that neither shares: kinds, numbers and places."""
    folder = {"krl": KR15, "rapid": IRB6700}.get(name) or cell(tmp_path)
    machine = _cell(folder)
    language = language_named(name)
    kinds = ProgramEventKind
    events = (
        ProgramEvent(1, kinds.HOOK, "tool_change", 7.0),
        ProgramEvent(2, kinds.HOOK, "spindle_on", 12000.0),
        ProgramEvent(2, kinds.HOOK, "coolant_on"),
        ProgramEvent(3, kinds.DWELL, value=1.25),
        ProgramEvent(3, kinds.COMMENT, "do spindle on 5\n$OUT[1] = FALSE\nSetDO doSpindle,0;"),
        ProgramEvent(4, kinds.HOOK, "stop"),
        ProgramEvent(5, kinds.HOOK, "coolant_off"),
        ProgramEvent(5, kinds.HOOK, "spindle_off"),
    )
    values = machine.to_axis_values(np.tile(machine.q_home, (6, 1)))
    values[1:5, 0] += np.arange(1.0, 5.0)
    program = build_program("sample", machine, language.round, kind=np.zeros(6), axis_values=values, events=events)
    for file, data in language.write(program, machine.controller, max_lines=None):
        (tmp_path / file).write_bytes(data)
    run = run_program(tmp_path / f"sample{language.suffixes[0]}", read_machine(folder))
    assert not run.gaps and len(run) == 6
    meant = [
        (1, Kind.TOOL, 7.0),
        (2, Kind.SPINDLE_ON, 12000.0),
        (2, Kind.COOLANT_ON, 0.0),
        (3, Kind.DWELL, 1.25),
        (4, Kind.STOP, 0.0),
        (5, Kind.COOLANT_OFF, 0.0),
        (5, Kind.SPINDLE_OFF, 0.0),
    ]
    assert [(e.before, e.kind, e.value) for e in run.events if e.before < 6] == meant
    assert {e.kind for e in run.events if e.before == 6} == {Kind.SPINDLE_OFF, Kind.COOLANT_OFF}  # the cell's footer
