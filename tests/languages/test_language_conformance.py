"""What every robot language has to keep: a program written in it, read back by its own reader, is the program that was meant."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from krl_sample import make_program

from camrob.cell.controller_settings import ControllerSettings
from camrob.findings import Finding
from camrob.languages import LANGUAGES, Registered, language_named
from camrob.program.axis_turns import turn_of
from camrob.program.motion import Blend, Motion
from camrob.program.program import Program, ProgramEvent, ProgramEventKind

HOOKS = {
    "krl": {
        "spindle_on": ("$ANOUT[1] = {speed} / 24000.0", "$OUT[5] = TRUE"),
        "spindle_on_ccw": ("$ANOUT[1] = {speed} / 24000.0", "$OUT[6] = TRUE"),
        "spindle_off": ("$OUT[5] = FALSE",),
        "coolant_on": ("$OUT[7] = TRUE",),
        "coolant_off": ("$OUT[7] = FALSE",),
        "tool_change": ("TOOL_CHANGE ({number})",),
        "stop": ("HALT",),
        "header": ("$OUT[1] = TRUE",),
        "footer": ("$OUT[1] = FALSE",),
    },
    "rapid": {
        "spindle_on": ("SetAO aoSpindle,{speed}/2400;", "SetDO doSpindle,1;", "WaitTime\\InPos,3;"),
        "spindle_on_ccw": ("SetAO aoSpindle,{speed}/2400;", "SetDO doSpindleLeft,1;"),
        "spindle_off": ("SetDO doSpindle,0;",),
        "coolant_on": ("SetDO doCoolant,1;",),
        "coolant_off": ("SetDO doCoolant,0;",),
        "tool_change": ("ToolChange {number};",),
        "stop": ("Stop;",),
        "header": ("SetDO doRunning,1;",),
        "footer": ("SetDO doRunning,0;",),
    },
    "lines": {
        "spindle_on": ("do spindle {speed}",),
        "spindle_on_ccw": ("do spindle left {speed}",),
        "spindle_off": ("do spindle off",),
        "coolant_on": ("do coolant on",),
        "coolant_off": ("do coolant off",),
        "tool_change": ("do change {number}",),
        "stop": ("do stop",),
        "header": ("do begin",),
        "footer": ("do finish",),
    },
}
SECOND = Registered("second_language", (".lines",))
PTP, POSE, LIN, VIA, END = Motion
KIND = ProgramEventKind
PRINTED = 1e-9  # mm, degrees: A, B, C of a language that prints quaternions are worked out, and not read


@pytest.fixture(params=[*LANGUAGES, "lines"])
def spoken(request, monkeypatch):
    """A language with a controller that takes it."""
    monkeypatch.setitem(LANGUAGES, "lines", SECOND)
    words = {
        "krl": {"own": {"ori_type": "#VAR", "circ_type": "#BASE"}},
        "rapid": {
            "own": {"mechanical_unit": "STN1", "tool_data": "tSpindle", "ptp_speed": [500, 50, 500, 20]},
            "max_line_length": 400,
        },
    }
    controller = ControllerSettings(
        acc_cp=2.0,
        vel_ori_deg_s=200.0,
        acc_ori_deg_s2=400.0,
        apo_cdis_mm=0.5,
        advance=3,
        ptp_velocity_percent=30.0,
        max_lines=10_000,
        max_bytes=1_000_000,
        hooks=HOOKS[request.param],
        language=request.param,
        **{"max_line_length": 255, **words.get(request.param, {})},
    )
    return language_named(request.param), controller


def rounded(language, program: Program, **changes) -> Program:
    """A program in the language's own decimals, its axes in all quarters and branches, told as the language counts them."""
    pose, external = language.round.pose(program.pose, program.external)
    rows = np.arange(len(program))
    axes = language.round.axes(
        program.axes + 61.0 * (rows[:, None] % 7 - 3) * np.array([0.9, 0.1, 0.3, 1.5, 0.4, -2.0])
    )
    return dataclasses.replace(
        program,
        name=language.program_name("sample"),
        pose=pose,
        external=external,
        axes=axes,
        status=rows % 8,
        turn=turn_of(language.turning, axes),
        speed=language.round.speed(program.speed),
        tool=language.round.frame(program.tool),
        base=language.round.frame(program.base),
        **changes,
    )


def with_events(language, program: Program, events: tuple[ProgramEvent, ...]) -> Program:
    """The program with events; where the language's own statements don't stop the robot, it stops before them."""
    approximate = np.array(program.approximate)
    if not language.stops:
        approximate[[e.motion - 1 for e in events if e.motion and e.kind in (KIND.HOOK, KIND.DWELL)]] = False
    return dataclasses.replace(program, events=events, approximate=approximate)


def back(spoken, program: Program, folder: Path, max_lines: int | None = None, findings: list[Finding] | None = None):
    """The program written, and read back from its text."""
    language, controller = spoken
    language.check(program, controller)
    files = dict(language.write(program, controller, max_lines=max_lines, findings=findings))
    for name, data in files.items():
        assert Path(name).suffix in language.suffixes
        (folder / name).write_bytes(data)
    main = folder / f"{program.name}{language.suffixes[0]}"
    return language.read(main), files


def actions(spoken, program: Program):
    meant = spoken[0].meant(program, spoken[1])
    return [*sorted((0, s) for s in meant.opening), *((a.motion, a.text) for a in meant.rest)], len(meant.opening)


def held(spoken, text, program: Program) -> None:
    """All of what was meant stands in the text."""
    kind = np.asarray(program.kind)
    assert np.array_equal(text.kind, kind) and text.language == spoken[0].name
    posed = kind != PTP
    assert np.abs(np.asarray(text.pose) - np.asarray(program.pose))[posed].max() <= PRINTED
    assert np.array_equal(np.asarray(text.axes)[~posed], np.asarray(program.axes)[~posed])
    columns = [text.external_names.index(name) for name in program.external_names]
    assert np.array_equal(np.asarray(text.external)[:, columns], program.external)
    ptp = kind == POSE
    assert np.array_equal(np.asarray(text.status)[ptp], np.asarray(program.status)[ptp])
    assert np.array_equal(np.asarray(text.turn)[ptp], np.asarray(program.turn)[ptp])
    moving = kind >= LIN
    assert np.array_equal(np.asarray(text.speed)[moving], np.asarray(program.speed)[moving])
    wanted = np.where(program.approximate, int(Blend.DISTANCE), int(Blend.EXACT))
    assert np.array_equal(text.blend, wanted)
    tools = np.stack([np.asarray(f.xyzabc) for f in text.tools])[text.tool]
    assert np.abs(tools - program.mounted)[posed].max() <= PRINTED
    bases = np.stack([np.asarray(f.xyzabc) for f in text.bases])[text.base]
    assert np.abs(bases - program.base)[posed].max() <= PRINTED
    wanted_actions, opening = actions(spoken, program)
    read = [(a.motion, a.text) for a in text.actions]
    assert [*sorted(read[:opening]), *read[opening:]] == wanted_actions
    assert not text.findings or {f.code for f in text.findings} <= {
        "call-unknown"
    }  # a hook may call what is not at hand


def test_motions_blends_speeds_arcs_and_external_axes_come_back(spoken, tmp_path) -> None:
    program = rounded(spoken[0], make_program([PTP, POSE, LIN, LIN, VIA, END, LIN, LIN, POSE, LIN, PTP]))
    held(spoken, back(spoken, program, tmp_path)[0], program)


def test_a_program_without_external_axes_comes_back(spoken, tmp_path) -> None:
    made = make_program([PTP, LIN, LIN, PTP])
    program = rounded(spoken[0], dataclasses.replace(made, external=np.zeros((4, 0)), external_names=()))
    held(spoken, back(spoken, program, tmp_path)[0], program)


EVENTS = {
    "spindle": ProgramEvent(2, KIND.HOOK, "spindle_on", 12000.0),
    "spindle, fractions": ProgramEvent(2, KIND.HOOK, "spindle_on", 8000.125),
    "spindle the other way": ProgramEvent(2, KIND.HOOK, "spindle_on_ccw", 900.0),
    "spindle off": ProgramEvent(2, KIND.HOOK, "spindle_off"),
    "coolant": ProgramEvent(2, KIND.HOOK, "coolant_on"),
    "coolant off": ProgramEvent(2, KIND.HOOK, "coolant_off"),
    "another tool": ProgramEvent(3, KIND.HOOK, "tool_change", 7.0),
    "a stop": ProgramEvent(4, KIND.HOOK, "stop"),
    "a dwell": ProgramEvent(3, KIND.DWELL, value=1.25),
    "a short dwell": ProgramEvent(3, KIND.DWELL, value=0.001),
    "behind the last motion": ProgramEvent(5, KIND.HOOK, "coolant_off"),
    "before the first": ProgramEvent(0, KIND.HOOK, "coolant_off"),
}


@pytest.mark.parametrize("event", EVENTS)
def test_each_event_comes_back_where_it_stands_and_nowhere_else(spoken, tmp_path, event: str) -> None:
    silent = rounded(spoken[0], make_program([PTP, POSE, LIN, LIN, PTP]))
    program = with_events(spoken[0], silent, (EVENTS[event],))
    held(spoken, back(spoken, program, tmp_path)[0], program)
    assert actions(spoken, program) != actions(spoken, silent), "the event does nothing"
    at = EVENTS[event].motion
    other = dataclasses.replace(EVENTS[event], motion=at - 1 if at else 1)
    moved, dear = (dataclasses.replace(program, events=(one,)) for one in (other, _dearer(EVENTS[event])))
    assert actions(spoken, moved) != actions(spoken, program), "it may stand elsewhere"
    assert not EVENTS[event].value or actions(spoken, dear) != actions(spoken, program), "its number is lost"


def _dearer(event: ProgramEvent) -> ProgramEvent:
    return dataclasses.replace(event, value=event.value * 2.0)


def test_a_dwell_is_waited_for(spoken, tmp_path) -> None:
    events = (ProgramEvent(2, KIND.DWELL, value=1.5), ProgramEvent(4, KIND.DWELL, value=0.25))
    program = with_events(spoken[0], rounded(spoken[0], make_program([PTP, LIN, LIN, PTP])), events)
    text = back(spoken, program, tmp_path)[0]
    assert text.wait.tolist() == [0.0, 0.0, 1.5, 0.0] and text.final_wait == 0.25


def test_several_tools_are_mounted_where_they_are_meant(spoken, tmp_path) -> None:
    tools = spoken[0].round.frame(np.array([[0.0, 1.5, 200.123456, 10.0, 20.0, -30.0], [1.0, 2.0, 3.0, 0.0, 0.0, 0.0]]))
    events = tuple(ProgramEvent(row, KIND.TOOL, value=float(k)) for row, k in ((3, 1), (6, 0)))
    kinds = [PTP, POSE, LIN, PTP, POSE, LIN, PTP, POSE, LIN, PTP]
    program = rounded(spoken[0], make_program(kinds), events=events, tools=tools)
    text = back(spoken, program, tmp_path)[0]
    held(spoken, text, program)
    assert len({tuple(text.tools[k].xyzabc) for k in np.asarray(text.tool)[np.asarray(text.kind) != PTP]}) == 3


def test_loads_are_set_where_they_are_meant(spoken, tmp_path) -> None:
    language, _ = spoken
    loads = language.round.load(
        np.array([[38.51234567, 1.5, -20.25, 300.0, 1.25, 1.2, 0.0612], [21.0, 0, 0, 150.123456, 0, 0, 0]])
    )
    events = tuple(ProgramEvent(row, KIND.LOAD, value=float(k)) for row, k in ((0, 0), (3, 1)))
    silent = rounded(language, make_program([PTP, POSE, LIN, PTP, POSE, LIN, PTP]))
    program = dataclasses.replace(silent, events=events, loads=loads)
    held(spoken, back(spoken, program, tmp_path)[0], program)
    assert actions(spoken, program) != actions(spoken, silent), "the load is not held to the text"
    for change in ({"loads": loads + 0.5}, {"events": (events[0], dataclasses.replace(events[1], motion=4))}):
        assert actions(spoken, dataclasses.replace(program, **change)) != actions(spoken, program)


@pytest.mark.parametrize("cut", ["at retracts", "in a cut"])
def test_a_program_in_parts_is_the_same_program(spoken, tmp_path, cut: str) -> None:
    kinds = [PTP, POSE, *[LIN] * 7, VIA, END, *[LIN] * 9, PTP]
    safe = [0, 1, 4, 8, 12, 15, 19, 20] if cut == "at retracts" else []
    events = (ProgramEvent(5, KIND.HOOK, "coolant_on"), ProgramEvent(9, KIND.DWELL, value=2.0))
    program = with_events(spoken[0], rounded(spoken[0], make_program(kinds, safe=safe)), events)
    findings: list[Finding] = []
    text, files = back(spoken, program, tmp_path, max_lines=5, findings=findings)
    assert len([name for name in files if name.endswith(spoken[0].suffixes[0])]) > 3
    held(spoken, text, program)
    assert bool(findings) == (cut == "in a cut")


ESCAPES = (
    "done\nPTP HOME",
    "done\r\nLIN {X 0}",
    "a;b",
    "}{",
    '"quote',
    "\x00\x07",
    "&ACCESS",
    "%{PE}",
    "FOLD",
    "ENDFOLD",
    "line\u2028do spindle 9",
    "\u00fcml\u00e4ut",
    "\u202eover",
    "do spindle 24000",
    "end",
    "axes 0 0 0 0 0 0 | 0 0",
    "x" * 400,
)


@pytest.mark.parametrize("text", ESCAPES)
def test_no_text_of_a_file_does_anything(spoken, tmp_path, text: str) -> None:
    """Names, remarks and titles of any origin leave motions and actions as they are."""
    language, controller = spoken
    events = (ProgramEvent(2, KIND.REGION, text), ProgramEvent(3, KIND.COMMENT, text))
    plain = rounded(language, make_program([PTP, POSE, LIN, LIN, PTP]))
    program = dataclasses.replace(plain, events=events, comment=(text,), name=language.program_name(text))
    assert language.program_name(program.name) == program.name
    read, files = back(spoken, program, tmp_path)
    held(spoken, read, dataclasses.replace(plain, name=program.name))
    assert all(data.isascii() for data in files.values())
    assert max(len(line) for data in files.values() for line in data.split(b"\n")) <= controller.max_line_length + 1


def test_what_is_no_program_is_refused(spoken) -> None:
    language, controller = spoken
    good = rounded(language, make_program([PTP, LIN, VIA, END, LIN, PTP]))
    rows = np.arange(len(good))
    faults = {
        "no number": {"pose": np.where(rows[:, None] == 1, np.nan, good.pose)},
        "unrounded": {"pose": np.asarray(good.pose) + 1e-7},
        "no speed": {"speed": np.where(rows == 1, 0.0, good.speed)},
        "half an arc": {"kind": np.where(rows == 3, int(LIN), good.kind)},
        "an event in an arc": {"events": (ProgramEvent(3, KIND.DWELL, value=1.0),)},
        "an event behind everything": {"events": (ProgramEvent(7, KIND.DWELL, value=1.0),)},
        "no time": {"events": (ProgramEvent(1, KIND.DWELL, value=float("nan")),)},
        "an unknown hook": {"events": (ProgramEvent(1, KIND.HOOK, "explode"),)},
        "a load that it lacks": {"events": (ProgramEvent(1, KIND.LOAD, value=0.0),)},
        "a tool that it lacks": {"events": (ProgramEvent(1, KIND.TOOL, value=0.0),)},
    }
    for fault, change in faults.items():
        with pytest.raises(ValueError):
            list(language.write(dataclasses.replace(good, **change), controller, max_lines=None))
            pytest.fail(fault)


def test_rounding_says_what_the_text_will(spoken, tmp_path) -> None:
    """Rounding twice changes nothing, and no value is moved by more than the fourth decimal's half."""
    generator = np.random.default_rng(3)
    round_ = spoken[0].round
    for values, rounding in (
        (generator.uniform(-170, 170, (50, 6)), round_.axes),
        (generator.uniform(-170, 170, (50, 6)) * [1, 1, 1, 1, 0.5, 1], round_.frame),
        (generator.uniform(0.001, 1.0, 50), round_.speed),
        (generator.uniform(-5000, 5000, (50, 2)), round_.external),
    ):
        once = rounding(values)
        assert np.array_equal(rounding(once), once) and np.abs(once - values).max() <= 5.1e-5
    pose, external = round_.pose(generator.uniform(-170, 170, (50, 6)), generator.uniform(-900, 900, (50, 2)))
    again = round_.pose(pose, external)
    assert np.array_equal(again[0], pose) and np.array_equal(again[1], external)


def test_targets_can_be_replaced_and_nothing_else(spoken, tmp_path) -> None:
    from camrob.program.language import NewTarget

    language, _ = spoken
    events = (ProgramEvent(2, KIND.HOOK, "coolant_on"), ProgramEvent(3, KIND.COMMENT, "a remark"))
    program = with_events(language, rounded(language, make_program([PTP, LIN, LIN, VIA, END, PTP])), events)
    text, _ = back(spoken, program, tmp_path)
    main = tmp_path / f"{program.name}{language.suffixes[0]}"
    source = main.read_bytes().decode("latin-1")
    rows = {int(line): np.flatnonzero(text.line == line) for line in text.line}
    new = {
        line: [
            NewTarget(
                tuple(np.asarray(text.axes if text.kind[k] == PTP else text.pose)[k] + 0.25), bool(text.kind[k] == PTP)
            )
            for k in at
        ]
        for line, at in rows.items()
    }
    assert [language.targets(s) for s in source.split("\n")] == [
        len(new.get(k + 1, ())) for k in range(len(source.split("\n")))
    ]
    main.write_bytes(language.patch(source, new).encode("latin-1"))
    moved = language.read(main)
    by = np.asarray(moved.pose) - np.asarray(text.pose)
    by[:, 3:] -= 360.0 * np.round(by[:, 3:] / 360.0)  # 180.1 degrees may be written as -179.9
    posed = np.asarray(text.kind) != PTP
    assert np.abs(by[posed] - 0.25).max() <= 2e-4 and np.isnan(by[~posed]).all()
    assert np.abs(np.asarray(moved.axes - text.axes)[~posed] - 0.25).max() <= 2e-4
    for name in ("kind", "external", "speed", "blend", "line", "tool", "base"):
        assert np.array_equal(getattr(moved, name), getattr(text, name)), name
    assert moved.actions == text.actions


def test_a_line_can_be_divided_and_nothing_else(spoken, tmp_path) -> None:
    """Copies with other numbers stand before it, and share its speed, its rounding and what was set before."""
    from camrob.program.language import AddedTarget

    language, _ = spoken
    events = (ProgramEvent(2, KIND.HOOK, "coolant_on"), ProgramEvent(4, KIND.COMMENT, "a remark"))
    program = with_events(language, rounded(language, make_program([PTP, LIN, LIN, LIN, PTP])), events)
    text, _ = back(spoken, program, tmp_path)
    main = tmp_path / f"{program.name}{language.suffixes[0]}"
    source = main.read_bytes().decode("latin-1")
    row = 3
    pose, external = np.asarray(text.pose)[row], np.asarray(text.external)[row]
    added = [
        AddedTarget(tuple(pose - d), dict(zip(text.external_names, (external - d).tolist(), strict=True)))
        for d in (0.5, 0.25)
    ]
    main.write_bytes(language.divide(source, {int(text.line[row]): added}).encode("latin-1"))
    divided = language.read(main)
    assert len(divided) == len(text) + 2
    kept = np.delete(np.arange(len(divided)), [row, row + 1])
    for name in ("kind", "pose", "axes", "external", "speed", "blend", "tool", "base"):
        assert np.array_equal(getattr(divided, name)[kept], getattr(text, name), equal_nan=True), name
    for k, d in ((row, 0.5), (row + 1, 0.25)):
        assert np.allclose(divided.pose[k], pose - d, atol=2e-4, rtol=0)
        assert np.allclose(divided.external[k], external - d, atol=2e-4, rtol=0)
        for name in ("kind", "speed", "blend", "tool", "base"):
            assert getattr(divided, name)[k] == getattr(text, name)[row], name
    assert [action.text for action in divided.actions] == [action.text for action in text.actions]
