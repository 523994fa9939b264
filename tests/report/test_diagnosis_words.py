"""Figures and sentences of a diagnosis, from summaries made up for it."""

from __future__ import annotations

from typing import Any

import pytest
from summary_samples import diagnosis_summary, effect_found, shrunk

from camrob.report.diagnosis.bars import place_charts
from camrob.report.diagnosis.numbers import fitted, measure, mm, share, sure, values_of
from camrob.report.diagnosis.sentences import compensable_text, sentence, unexplained
from camrob.report.diagnosis.to_do import compensate_command, to_do
from camrob.report.diagnosis.verdict_word import reading_text, verdict
from camrob.summaries.diagnosis_summary import DiagnosisSummary, FittedValue
from camrob.summaries.fitted.parameter_words import parameter_words


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (0.0, "0.000 mm"),
        (1e-5, "under 0.001 mm"),
        (0.0345, "0.035 mm"),
        (3.607, "3.61 mm"),
        (31.24, "31.2 mm"),
        (412.3, "412 mm"),
        (-0.12, "−0.120 mm"),
        (None, "–"),
        (float("nan"), "–"),
    ],
)
def test_distances_have_a_micrometre_or_three_digits(value: float | None, words: str) -> None:
    assert mm(value) == words


def test_neither_none_nor_all_of_a_chance_is_ever_claimed() -> None:
    assert [sure(p) for p in (0.0, 0.004, 0.034, 0.975, 0.999, 1.0)] == [
        "under 1 %",
        "under 1 %",
        "3 %",
        "98 %",
        "over 99 %",
        "over 99 %",
    ]
    assert [share(x) for x in (0.0, 0.001, 0.62, 1.0, -0.06)] == ["0 %", "under 1 %", "62 %", "100 %", "−6 %"]


@pytest.mark.parametrize(
    ("value", "std", "unit", "words"),
    [
        (0.0291287, 0.000105, "degrees", "0.02913 ± 0.00011 degrees"),
        (4.309e-4, 4.5e-6, "s²", "(4.31 ± 0.04) × 10⁻⁴ s²"),
        (0.0102, 0.4146, "mm", "0.0 ± 0.4 mm"),
        (-134.2, 7.6, "kg", "−134 ± 8 kg"),
        (0.0, 0.0, "", "0"),
    ],
)
def test_a_fitted_value_has_the_digits_that_are_known(value: float, std: float, unit: str, words: str) -> None:
    assert fitted(value, std, unit) == words


def test_parameters_in_words() -> None:
    assert parameter_words("A3_deg") == ("A3", "degrees")
    assert parameter_words("about_x_rad_nm") == ("about x", "rad/Nm")
    assert parameter_words("A5_by_A4") == ("A5 by A4", "degrees a degree")
    assert parameter_words("arm_s2") == ("arm", "s²")
    assert parameter_words("moment_x_kg_m") == ("moment x", "kg m")
    assert measure(0.0048, "degrees") == "0.00480 degrees"


def fits(**values: tuple[float, float]) -> dict[str, FittedValue]:
    return {name: FittedValue(value=value, std=std) for name, (value, std) in values.items()}


def test_of_many_values_those_that_are_known_best_come_first() -> None:
    texts, more = values_of(fits(a_mm=(0.1, 1.0), b_mm=(0.1, 0.001), c_mm=(9.0, 1.0)), 2)
    assert [t.split()[0] for t in texts] == ["b", "c"]
    assert more == 1
    waves = {"A1_cos16.6_deg": (0.003, 0.0001), "A1_sin16.6_deg": (-0.004, 0.0001), "A2_cos16.6_deg": (0.00001, 0.0001)}
    assert values_of(fits(**waves), 6) == (["A1, 16.6 times a turn, 0.00500 ± 0.00010 degrees"], 1)


def summary(effects: list[dict[str, Any]], **other: Any) -> DiagnosisSummary:
    """A made-up diagnosis: 0.3 mm, most of it behind the encoders, that reverses with the direction of motion."""
    return diagnosis_summary(effects=effects, **other)


BACKLASH = effect_found("backlash", ["A2"], {"A2_deg": 0.031})


def test_the_sentence_reads_as_one_would_say_it() -> None:
    assert sentence(summary([BACKLASH])) == (
        "62 % of the gap (0.310 mm rms in the logs diagnosed) sits between encoder and TCP and reverses with A2's direction: "
        "backlash of A2, 0.0310 degrees (97 % sure). On a run that took no part (lap2.csv), adding it takes the gap from "
        "0.300 mm to 0.070 mm; the instrument's noise is 0.030 mm."
    )


def test_where_one_rung_is_logged_no_share_is_made_up() -> None:
    where = {
        "rungs": {"program_to_setpoint": None, "setpoint_to_encoder": None, "encoder_to_tcp": 0.31},
        "regimes": {"position": 0.9},
        "missing": ["no encoders: drives and arm can't be told apart"],
    }
    said = sentence(summary([BACKLASH], where=where))
    assert said.startswith(
        "The gap (0.310 mm rms in the logs diagnosed) lies between set-point and TCP, the only stage that is logged; it follows"
    )


def test_effects_of_several_axes_waves_and_couplings_say_their_values() -> None:
    offsets = effect_found("joint_offset", ["A3", "A5"], {"A3_deg": 0.0548, "A5_deg": -0.0327})
    assert "joint offset of A3, 0.0548 degrees and of A5, −0.0327 degrees (97 % sure)" in sentence(summary([offsets]))
    ripple = effect_found(
        "gear_ripple", ["A1"], {"A1_cos28.04_deg": 0.003, "A1_sin28.04_deg": 0.004, "A1_cos56.08_deg": 0.001}
    )
    assert "gear ripple of A1, 0.00500 degrees 28.04 times a turn" in sentence(summary([ripple]))
    coupled = effect_found("wrist_coupling", ["A5"], {"A5_by_A4": 0.0012})
    assert "wrist coupling of A5 to A4, 0.00120 degrees a degree" in sentence(summary([coupled]))
    lag = effect_found("servo_lag", ["A1"], {"tau_s": 0.0409, "A1_beyond_s": 0.001})
    assert "servo lag of A1, 0.0409 s (97 % sure)" in sentence(summary([lag]))
    drift = effect_found("thermal_drift", [], {"A1_x_mm": 0.07, "A1_y_mm": 0.03})
    assert "thermal drift, 0.290 mm rms at the TCP" in sentence(summary([drift]))


SHAPE = {"rung": "encoder_to_tcp", "moves": "A1", "follows": "A1", "swing": 0.0684, "unit": "degrees"}


def test_the_unknown_is_named_with_its_place_and_with_what_stays() -> None:
    unknown = {
        "probability": 0.99,
        "rms_mm": 0.198,
        "share": 0.436,
        "text": "between encoder and TCP, A1 …",
        "where": {"rung": "encoder_to_tcp", "axes": ["A1"], "regimes": ["position"], "comes_back": ""},
        "shapes": [SHAPE],
        "implausible": {"lean": "9 where 5 is"},
    }
    alone = summary(
        [effect_found("geometry", [], {"A1_x_mm": 1.0, "A1_y_mm": 0.1}, probability=0.15, alone=shrunk(0.3, 0.2))],
        status="unexplained",
        unknown=unknown,
    )
    said = sentence(alone)
    assert "the best single effect, geometry, would take 0.300 mm to 0.200 mm" in said
    assert said.endswith("Something unknown is at work: A1 deviates with its own position.")
    assert unexplained(alone) == [
        "Between encoder and TCP: A1 deviates by 0.0684 degrees over the logs, smoothly with its own position",
        "lean would fit, with a value that no such machine has: 9 where 5 is",
    ]
    beside = summary([BACKLASH], unknown=unknown, together=shrunk(0.3, 0.2, withheld="a.csv, b.csv"))
    assert "On runs that took no part (a.csv, b.csv)" in sentence(beside)
    assert sentence(beside).endswith(
        "Besides, 0.198 mm, 6.6 times the noise, remains unexplained there, 44 % of the energy that the gap has there: A1 "
        "deviates with its own position. It is 99 % sure that a cause that the library lacks has a part in that rest."
    )


def test_what_stays_without_a_shape_is_the_second_statement() -> None:
    unknown = {
        "probability": 0.99,
        "rms_mm": 0.198,
        "share": 0.436,
        "text": "0.198 mm rms, 6.6 times the noise, stays unexplained",
        "where": {"rung": "encoder_to_tcp", "axes": [], "regimes": ["position"], "comes_back": ""},
    }
    assert sentence(summary([BACKLASH], unknown=unknown)).endswith(
        "Besides, 0.198 mm, 6.6 times the noise, remains unexplained there, 44 % of the energy that the gap has there; it "
        "follows position. It is 99 % sure that a cause that the library lacks has a part in that rest."
    )
    assert sentence(summary([], status="unexplained", unknown=unknown)).endswith(
        "Something unknown is at work, and follows position."
    )


def test_no_gap_says_of_each_stage_whether_noise_or_the_tolerance_says_so_and_by_which_value() -> None:
    arm = {"rms_mm": 0.031, "p95_mm": 0.05, "noise_mm": 0.03, "noise_told": True, "tolerance_mm": None, "axis": ""}
    drives = arm | {"rms_mm": 0.01, "axis": "A3", "noise_told": False}

    def said(first: str, second: str, **values: float) -> str:
        stages = {
            "setpoint_to_encoder": drives | values | {"within": first},
            "encoder_to_tcp": arm | values | {"within": second},
        }
        return sentence(summary([], status="no gap", within_values=stages))

    assert said("noise", "noise") == (
        "There is no gap: between set-point and encoder A3, the farthest off, is 0.010 mm rms over the work, within the noise "
        "(0.030 mm, as found); between encoder and TCP 0.031 mm rms, within the noise (0.030 mm, as reported)."
    )
    loose = said("tolerance", "noise", tolerance_mm=0.05)
    assert "over the work, within the tolerance that the log names (tolerance_mm = 0.05), not within noise;" in loose
    assert loose.endswith("between encoder and TCP 0.031 mm rms, within the noise (0.030 mm, as reported).")
    assert said("noise", "tolerance", tolerance_mm=0.06).endswith(
        "0.031 mm rms, 95 % 0.050 mm, within the tolerance that the log names (tolerance_mm = 0.06), not within noise."
    )


def test_what_compensate_can_do_is_never_promised_too_much() -> None:
    compensable = {
        "effects": ["track"],
        "left": ["track of E1"],
        "rms_before_mm": 0.2,
        "rms_after_mm": 0.19,
        "shrink_interval": [0.01, 0.1],
    }
    assert compensable_text(summary([], compensable=compensable)).startswith(
        "compensate can correct a part of track by constants: 0.200 mm to 0.190 mm; for the rest of track of E1 compensate --"
    )
    worse = compensable | {
        "effects": ["frame_base"],
        "left": ["lean"],
        "rms_after_mm": 0.24,
        "shrink_interval": [-0.3, 0.1],
    }
    assert "so none are handed over; for lean, too, compensate --diagnosis corrects" in compensable_text(
        summary([], compensable=worse)
    )
    assert compensable_text(summary([], compensable=compensable | {"effects": []})) == (
        "compensate has no constant for track of E1: compensate --diagnosis corrects what of it comes back from run to run."
    )
    read = effect_found("measurement_scale", [], {}, of_machine=False)
    assert compensable_text(summary([read], compensable={"effects": [], "left": ["measurement_scale"]})) == ""


def _found(name: str, moves: float, **other: Any) -> dict[str, Any]:
    """An effect with a remedy, 97 % sure unless it says otherwise."""
    return effect_found(name, [], {"x_mm": 0.1}, moves_mm=moves, remedy=f"mend {name}", isolated_by="run it", **other)


def test_what_is_clear_is_done_first_and_the_largest_before_the_others() -> None:
    small, large = _found("backlash", 0.1), _found("lean", 0.3)
    steps = dict(to_do(summary([small, large], unknown={"probability": 0.01})))
    assert list(steps) == ["lean (0.300 mm)", "backlash (0.100 mm)", "in the program"]
    assert steps["lean (0.300 mm)"] == "mend lean"
    said = steps["in the program"]  # done at the machine and here, it would be corrected twice
    assert "Do one or the other: " in said and "makes the logs again first" in said
    command = compensate_command(summary([small, large], unknown={"probability": 0.01}))
    assert command is not None and command[1].endswith("--diagnosis DIR --out OUT")
    left = to_do(summary([small], unknown={"probability": 0.9, "rms_mm": 0.2}))
    assert left[1] == (
        "what is unexplained",
        "0.200 mm stay that none of this takes away: run the next experiment to learn of what",
    )


def test_nothing_is_touched_for_a_cause_that_may_be_another() -> None:
    twins = [
        _found("payload", 0.3, probability=0.7, indistinguishable_from=["lean", "geometry"]),
        _found("lean", 0.2, probability=0.6, indistinguishable_from=["payload"]),
    ]
    ((what, text), *_) = to_do(summary(twins, unknown={"probability": 0.01}))
    assert what == "payload (0.300 mm), lean (0.200 mm)" and "mend" not in text
    assert (
        text
        == "change nothing for it yet, as these logs can't tell these from each other or from geometry. First run this: run it"
    )
    ((_, alone), *_) = to_do(summary(twins[:1], unknown={"probability": 0.01}))
    assert alone.endswith("can't tell it from lean, geometry. First run this: run it. If it stays: mend payload")
    sure = _found("payload", 0.3, indistinguishable_from=["lean"])
    assert to_do(summary([sure], unknown={"probability": 0.01}))[0] == ("payload (0.300 mm)", "mend payload")


def test_a_cause_that_another_may_be_is_not_mended_either_unless_it_is_surer() -> None:
    doubtful = _found("payload", 0.3, probability=0.6, indistinguishable_from=["lean"])
    for probability, held_back in ((0.6, True), (0.97, False)):
        other = _found("lean", 0.2, probability=probability, indistinguishable_from=[])
        steps = to_do(summary([doubtful, other], unknown={"probability": 0.01}))
        assert ("mend lean" not in dict(steps).values()) == held_back, probability


def test_one_run_is_named_for_a_cause_in_doubt_and_one_for_what_is_unexplained() -> None:
    """A reader was told two experiments for one doubt, and sent to one of them for what it says nothing about."""
    twin = _found("payload", 0.3, probability=0.7, indistinguishable_from=["lean"])
    rest = {"probability": 0.9, "rms_mm": 0.2, "isolated_by": "run A1 alone"}
    for about, cause, stays in (
        ("payload", "First run the next experiment.", "to learn of what, run A1 alone"),
        ("unknown", "First run this: run it.", "run the next experiment to learn of what"),
    ):
        texts = [text for _, text in to_do(summary([twin], unknown=rest, next_experiment_for=[about]))]
        assert cause in texts[0] and texts[1].endswith(stays)


def test_a_value_that_is_to_be_entered_is_printed() -> None:
    remedy = "survey it and enter the value"
    for values, said in (
        ({"A3_deg": 0.0548, "A5_deg": 0.0}, "A3 0.0548"),
        ({"E1_scale": 2.1e-4, "E1_bow2_y_mm": 0.8}, "E1 0.210"),
        ({"E1_bow2_y_mm": 0.8, "x_mm": 0.1}, "none to enter was found"),
    ):
        found = effect_found("some", [], values, moves_mm=0.3, remedy=remedy)
        text = to_do(summary([found], unknown={"probability": 0.01}))[0][1]
        assert said in text and "bow" not in text and "A5" not in text


def test_nothing_is_to_do_without_a_gap_and_nothing_in_the_program_where_only_readings_are_off() -> None:
    assert to_do(summary([], status="no gap")) == []
    assert [what for what, _ in to_do(summary([], status="unexplained"))] == ["nothing yet"]
    read = _found("measurement_drift", 0.2, of_machine=False)
    assert [what for what, _ in to_do(summary([read], unknown={"probability": 0.01}))] == [
        "measurement drift (0.200 mm)"
    ]


def test_an_axis_whose_lag_is_its_own_is_named_with_all_of_it() -> None:
    """A reader was told that A2 lags by what all other axes do."""
    values = {"tau_s": 0.00375, "A2_beyond_s": 0.00413, "A3_beyond_s": 0.0001}
    said = sentence(summary([effect_found("servo_lag", ["A2"], values)]))
    assert "servo lag, 0.00375 s, of A2 0.00788 s (97 % sure)" in said
    blind = summary([effect_found("servo_lag", [], values)], where={"missing": ["no measured pose: what the arm does"]})
    assert "; the noise of what is logged is 0.030 mm" in sentence(blind)


def test_of_several_causes_alike_none_is_claimed_and_all_are_named() -> None:
    rivals = [
        effect_found(n, [], {"x_mm": 0.1, "y_mm": 0.1}, probability=p)
        for n, p in (("track", 0.49), ("frame_base", 0.4))
    ]
    said = sentence(summary([*rivals, effect_found("lean", [], {"x_mm": 0.1}, probability=0.04)]))
    assert said.endswith(
        "several causes would explain it equally well, so none is claimed: track (49 % sure) and frame base (40 % sure)."
    )


def test_a_constant_that_nobody_knows_is_said_as_one() -> None:
    shape = {"rung": "encoder_to_tcp", "moves": "the tool", "follows": "constant", "swing": 0.17, "unit": "mm"}
    unknown = {"probability": 0.99, "text": "between encoder and TCP, …", "shapes": [shape], "implausible": {}}
    alone = summary([], status="unexplained", unknown=unknown)
    assert sentence(alone).endswith("Something unknown is at work: the tool is off by a constant.")
    assert unexplained(alone) == ["Between encoder and TCP: the tool is off by 0.170 mm, whatever the posture"]


def test_the_verdict_is_green_only_where_it_can_be_acted_on_and_the_part_gains_by_it() -> None:
    assert verdict(summary([BACKLASH], unknown={"probability": 0.01})) == ("Explained", "good")
    twin = _found("lean", 0.3, probability=0.6, indistinguishable_from=["geometry"])
    assert verdict(summary([twin])) == ("Explained, not surely", "warn")
    late = _found("latency", 0.96, of_machine=False)
    read = summary([late, _found("backlash", 0.18)])
    assert verdict(read)[1] == "warn"
    assert "0.960 mm rms, is an error of the measurement (latency), not of the part" in reading_text(read)
    assert "about 0.180 mm rms moves the tool itself" in reading_text(read)
    assert reading_text(summary([_found("latency", 0.1, of_machine=False), _found("backlash", 0.18)])) == ""


def test_of_the_axes_what_is_blamed_stands_first_and_all_others_are_pale() -> None:
    where = {"axes": {"A1": 0.71, "A2": 0.15}, "axis_intervals": {"A1": [0.7, 0.8], "A2": [0.1, 0.2]}}
    chart = next(c for c in place_charts(summary([BACKLASH], where=where)) if c["id"] == "by-axis")
    (bars,) = chart["traces"]
    assert [name.split(":")[0] for name in bars["y"]] == ["A2", "A1"]
    assert bars["marker"]["color"][0].startswith("#") and bars["marker"]["color"][1].startswith("rgba")


@pytest.mark.parametrize(
    ("nothing", "probability", "words"),
    [
        (0.1, 0.4, "no cause is sure enough to be named; the likeliest is payload (40 % sure)"),
        (0.6, 0.3, "nothing in the library explains it"),
        (0.1, 0.05, "nothing in the library explains it"),
    ],
)
def test_that_nothing_explains_a_gap_is_said_only_where_nothing_is_likely(
    nothing: float, probability: float, words: str
) -> None:
    left = [{"effects": [], "probability": nothing}, {"effects": ["payload"], "probability": 1.0 - nothing}]
    found = _found("payload", 0.3, probability=probability)
    said = sentence(
        summary([found], status="unexplained", alternatives=left, unknown={"probability": 0.9, "rms_mm": 0.2})
    )
    assert words in said
