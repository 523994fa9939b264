"""The three lines that a technician reads first, from summaries made up for them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from summary_samples import diagnosis_summary, effect_found

from camrob.report.diagnosis.head import head_lines, too_large
from camrob.report.diagnosis.next_section import next_words
from camrob.report.diagnosis.to_do import to_do
from camrob.summaries.diagnosis_summary import DiagnosisSummary

UNKNOWN: dict[str, Any] = {
    "probability": 0.99,
    "rms_mm": 0.198,
    "share": 0.436,
    "text": "",
    "where": {"rung": "encoder_to_tcp", "axes": ["A1"], "regimes": ["position", "load", "time"], "comes_back": ""},
    "shapes": [],
    "implausible": {},
}
PLAY = effect_found(
    "backlash",
    ["A2"],
    {"A2_deg": 0.031},
    remedy="have the play of these axes taken up (gear, and the belt); until then come to what matters from one side",
    isolated_by="move A2 alone",
    axis_moves_mm={"A2": 0.29},
    stands_out=["A2"],
)


def said(*effects: dict[str, Any], **other: Any) -> dict[str, str]:
    return dict(head_lines(diagnosis_summary(effects=list(effects), **other)))


def test_a_sure_cause_is_what_where_and_one_step() -> None:
    lines = said(PLAY, within={"setpoint_to_encoder": "noise", "encoder_to_tcp": "beyond"})
    assert list(lines) == ["What", "Where", "Do first"]
    assert (
        lines["What"] == "Backlash of A2 (97 % sure). 0.300 → 0.070 mm rms on a run that took no part; noise 0.030 mm."
    )
    assert lines["Where"] == "Between encoder and TCP; A2 alone; follows the direction."
    assert lines["Do first"] == (
        "Have the play of A2 taken up (gear, and the belt). Leave alone: the drives, which follow their set-points."
    )


def test_what_may_be_another_is_asked_before_anything_is_changed() -> None:
    doubtful = PLAY | {"probability": 0.78, "indistinguishable_from": ["hysteresis"]}
    lines = said(doubtful)
    assert "Backlash of A2 (78 % sure, or hysteresis)" in lines["What"]
    assert lines["Do first"].startswith("Move A2 alone. ") and "Change nothing for backlash" in lines["Do first"]


def test_what_is_clear_beside_a_doubtful_cause_is_in_the_first_step_too() -> None:
    """Lost motion of A4 by two names, and A5 dragged along by it: the technician was told of the one alone."""
    loops = effect_found(
        "hysteresis",
        ["A4"],
        {"A4_dahl_deg": 0.067},
        probability=0.78,
        indistinguishable_from=["backlash"],
        isolated_by="move A4 alone to and fro",
        moves_mm=0.3,
    )
    loops["parameters"]["A4_dahl_deg"]["usual"] = 0.01
    dragged = effect_found(
        "wrist_coupling",
        ["A5"],
        {"A5_by_A4": 5e-4},
        remedy="enter the coupling factors of the wrist, or correct it",
        moves_mm=0.2,
    )
    lines = said(loops, dragged)
    assert "is more than a gear does so: rather backlash" in lines["What"]
    first = lines["Do first"]
    assert first.startswith(
        "Move A4 alone to and fro. Wrist coupling of A5, which is clear: enter the coupling factors"
    )
    assert "Change nothing for hysteresis of A4" in first
    assert "which is clear" not in said(loops, dragged | {"moves_mm": 0.02})["Do first"]


def test_of_what_is_unknown_the_look_of_minutes_is_the_first_step() -> None:
    run = "drive to one pose ten times and measure it each time: if it scatters. Then run A2 alone; look for a step"
    lines = said(unknown=UNKNOWN | {"isolated_by": run}, status="unexplained", next_experiment="Isolate: run A2.")
    assert lines["Do first"].startswith("Drive to one pose ten times and measure it each time")
    assert "run A2" not in lines["Do first"]


def test_what_stays_is_said_with_its_place_and_asked_first_where_it_is_most_of_the_gap() -> None:
    doubtful = PLAY | {"probability": 0.78, "indistinguishable_from": ["hysteresis"]}
    lines = said(doubtful, unknown=UNKNOWN)
    assert "0.198 mm stay that have no known cause" in lines["What"]
    assert lines["Where"].endswith("What stays: between encoder and TCP; A1; follows position and load.")
    lines = said(
        doubtful,
        unknown=UNKNOWN | {"rms_mm": 0.297},
        next_experiment="Isolate what is unexplained: run A1; look for it.",
    )
    assert lines["Do first"].startswith("Run A1. ")


@pytest.mark.parametrize(
    ("other", "words"),
    [
        ({"indistinguishable_from": ["geometry"], "probability": 0.6}, "what looks alike in these logs (geometry)"),
        ({"probability": 0.6}, "something is broken there, or another cause stands behind it"),
        ({}, "is seldom so much"),
    ],
)
def test_a_value_that_no_such_machine_has_is_said_to_be_none(other: dict[str, Any], words: str) -> None:
    load = effect_found("payload", [], {"mass_kg": 312.0}, regimes=["load", "position"]) | other
    load["parameters"]["mass_kg"] |= {"usual": 49.5}
    assert "mass 312 ± 6 kg, 6 times the ordinary," in said(load)["What"] and words in said(load)["What"]
    load["parameters"]["mass_kg"] |= {"usual": 60.0}
    assert words not in said(load)["What"]


def test_causes_that_move_the_tool_by_more_than_the_gap_are_said_to_cancel() -> None:
    lag, late = (effect_found(name, [], {"tau_s": 0.02}, moves_mm=5.5) for name in ("servo_lag", "latency"))
    words = said(lag, late)["What"]
    assert (
        "Servo lag (5.50 mm) and latency (5.50 mm) would move the tool by more than the gap: they work against" in words
    )
    one = diagnosis_summary(effects=[lag, PLAY])
    assert [too_large(e, one) for e in one.effects] == [True, False]
    assert "it works against another cause" in dict(head_lines(one))["What"]


@pytest.mark.parametrize(
    ("moves", "odd", "words"),
    [
        ({"A3": 0.2, "A2": 0.05}, ["A3"], "A3 stands out (0.200 mm; A2, the next, 0.050 mm)"),
        ({"A3": 0.2, "A2": 0.19}, [], "A3 and A2 about alike"),
        ({"A3": 0.9, "A2": 0.9}, [], "which of A3 and A2, these logs don't tell: they cancel in part"),
    ],
)
def test_whether_one_axis_stands_out_is_said(moves: dict[str, float], odd: list[str], words: str) -> None:
    several = effect_found("backlash", list(moves), {"A2_deg": 0.1}, axis_moves_mm=moves, stands_out=odd)
    assert words in said(several)["Where"]


def test_what_all_axes_share_is_said_apart_from_the_one_that_differs() -> None:
    lag = effect_found("servo_lag", [], {"tau_s": 0.02}, rungs=["setpoint_to_encoder"])
    assert said(lag)["Where"].startswith("Between set-point and encoder; all axes alike; ")
    odd = lag | {"axes": ["A1"], "axis_moves_mm": {"A1": 0.1}, "stands_out": ["A1"]}
    odd["parameters"] = lag["parameters"] | {"A1_beyond_s": {"value": 0.01, "std": 0.001}}
    assert "all axes, and A1 otherwise than the rest" in said(odd)["Where"]


def test_nothing_claimed_is_said_as_that_and_nothing_is_touched() -> None:
    lines = said(
        status="unexplained",
        unknown=UNKNOWN,
        within={"setpoint_to_encoder": "noise", "encoder_to_tcp": "beyond"},
        next_experiment="Isolate what is unexplained: run A1 alone; look for a wave. Expected is at least 0.1 mm.",
    )
    assert lines["What"].startswith("Something that has no name here: the gap is 0.300 mm rms")
    assert lines["Where"] == "Between encoder and TCP; A1; follows position and load."
    assert lines["Do first"].startswith("Run A1 alone. Leave alone: all of the machine until that run has told")
    impossible = UNKNOWN | {"implausible": {"lean": "9 degrees where 5 is"}}
    assert "Lean fits with values alone that no machine has" in said(status="unexplained", unknown=impossible)["What"]


def test_a_reading_s_error_leaves_the_robot_alone() -> None:
    late = effect_found("latency", [], {"delay_s": 0.02}, of_machine=False, remedy="nothing at the robot: one clock")
    lines = said(late)
    assert lines["Where"].startswith("In the reading, not in the machine")
    assert (
        lines["Do first"]
        == "Nothing at the robot: one clock. Leave alone: the robot, as it is the reading that is off."
    )


def test_no_gap_is_two_lines_and_asks_for_nothing() -> None:
    lines = said(status="no gap", within={"encoder_to_tcp": "noise"})
    assert list(lines) == ["What", "Do first"] and lines["Do first"].startswith("Nothing")


def test_files_of_before_say_no_more_than_they_know() -> None:
    summary = diagnosis_summary(effects=[PLAY])
    old = {k: v for k, v in PLAY.items() if k not in ("axis_moves_mm", "stands_out", "remedy")}
    assert "alone" not in said(old)["Where"] and said(old)["Do first"]
    assert DiagnosisSummary.from_json(summary.to_json()) == summary


def test_where_there_is_nothing_to_adjust_the_next_deed_is_said_too() -> None:
    soft = effect_found(
        "joint_compliance", ["A2"], {"A2_rad_nm": 1e-6}, moves_mm=0.5, remedy="nothing to adjust: so it is"
    )
    assert said(soft, PLAY)["Do first"].startswith(
        "Joint compliance of A2: nothing to adjust at the machine. Backlash of A2: have the play of A2 taken up"
    )
    assert said(soft | {"moves_mm": 2.0}, PLAY)["Do first"].startswith("Nothing to adjust: so it is.")


def test_encoders_that_are_off_while_the_tool_is_not_are_the_recorder_s() -> None:
    place = {"rung": "setpoint_to_encoder", "axes": [], "regimes": ["speed"], "comes_back": ""}
    silent = {"rms_before_mm": 0.03, "rms_after_mm": 0.03}
    lines = said(
        status="unexplained",
        unknown=UNKNOWN | {"where": place},
        together=diagnosis_summary().together.to_json() | silent,
        within={"setpoint_to_encoder": "beyond", "encoder_to_tcp": "beyond"},
    )
    assert lines["What"].startswith(
        "The record of the encoders, and not the machine: the tool is where the set-points say"
    )
    assert lines["Do first"] == "Have the recorder's filter and clock looked at, and log again. Leave alone: the robot."


def test_a_long_step_goes_without_what_is_to_be_seen_then() -> None:
    run = f"run the same path with and without {'the load and ' * 12}the tool"
    lines = said(status="unexplained", unknown=UNKNOWN, next_experiment=f"To tell payload from lean: {run}: it grows.")
    assert lines["Do first"].startswith(f"To tell payload from lean: {run}. ")


def test_a_name_that_is_hardly_likely_comes_behind_what_has_none() -> None:
    hardly = effect_found("lean", [], {"x_mm": 0.1}, probability=0.2)
    alternatives = [{"effects": [], "probability": 0.4}, {"effects": ["lean"], "probability": 0.2}]
    lines = said(hardly, status="unexplained", unknown=UNKNOWN, alternatives=alternatives)
    assert lines["What"].startswith(
        "Most likely something that has no name here, else lean (20 %): the gap is 0.300 mm"
    )


def test_warmth_that_has_no_axis_is_placed_at_none() -> None:
    warm = effect_found("thermal_drift", [], {"expansion": 0.1}, axis_moves_mm={"A4": 0.2}, stands_out=["A4"])
    assert "A4" not in said(warm)["Where"]


def test_where_there_is_no_gap_nothing_is_to_be_run() -> None:
    """A technician read "no gap", "nothing" and a run that isolates what is unexplained on one page."""
    summary = diagnosis_summary(
        effects=[], status="no gap", unknown=UNKNOWN, within={"encoder_to_tcp": "tolerance"}, next_experiment="Run A2."
    )
    assert dict(head_lines(summary))["Do first"] == "Nothing."
    assert (
        next_words(summary)
        == "None is needed. Who wants to know where what is within the tolerance comes from: run A2."
    )
    assert next_words(replace(summary, status="unexplained")) == "Run A2."


def test_a_cause_that_is_hardly_likelier_than_none_is_asked_before_a_gear_is_opened() -> None:
    """At 60 % a technician would run the axis by itself first; the page sent him to grease and bearings."""
    hardly = PLAY | {"probability": 0.6}
    summary = diagnosis_summary(effects=[hardly])
    first = dict(head_lines(summary))["Do first"]
    assert first.startswith("Move A2 alone. ") and first.endswith(
        "Change nothing for backlash of A2 before that is clear."
    )
    said = dict(to_do(summary))["backlash of A2 (0.290 mm)"]
    assert said.startswith("not surely, so first run this: move A2 alone. If it stays: have the play")
    assert "not surely" not in dict(to_do(diagnosis_summary(effects=[PLAY])))["backlash of A2 (0.290 mm)"]
