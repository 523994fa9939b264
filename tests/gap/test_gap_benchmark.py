"""The gap benchmark: labels stay away from the logs, nuisances stay small, groups are what the path can't separate."""

from __future__ import annotations

import argparse
import json
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "bench"))

from gap import benchmark as gap_benchmark
from gap import maker as gap_maker
from gap import places as gap_places
from gap.draws import shift
from gap.motions import read_motion
from gap.score import Row, calibration, placed, score, share, upper_bound
from gap.separable import Separation


@pytest.mark.slow
def test_a_case_is_two_logs_and_the_label_is_not_among_them(tmp_path: Path) -> None:
    label = gap_maker.write_case(tmp_path, 31, "two")
    assert {p.name for p in tmp_path.iterdir()} == {"31.csv", "31.toml", "31_withheld.csv", "31_withheld.toml"}
    for file in tmp_path.glob("*.toml"):
        assert set(line.split(" = ")[0] for line in file.read_text().splitlines()) <= {
            "sigma_mm",
            "sigma_deg",
            "measured_frame",
            "poses",
        }
    assert len(label["effects"]) == 2
    assert gap_maker.write_case(tmp_path, 31, "two") == label


@pytest.mark.parametrize("seed", [41, 42])
def test_effects_have_the_size_of_the_label_and_nuisances_stay_under_a_tenth_of_the_noise(seed: int) -> None:
    _, rig, runs, chosen, label = gap_maker.drawn(seed, "one")
    world, at = runs[0]
    ((name, apply, s),) = chosen
    assert gap_maker.moved(world, [(apply, s)], at) == pytest.approx(
        label["effects"][name]["size"] * rig.noise, rel=0.1
    )
    clean, whole = gap_maker.clone(world), gap_maker.clone(world)
    apply(clean, s)
    nothing = np.sqrt(
        np.mean(np.sum((gap_maker.show(world, at)[2] - gap_maker.show(clean, at)[2])[:, :3, 3] ** 2, axis=1))
    )
    assert nothing <= 1.05 * gap_maker.NUISANCE * rig.noise
    assert gap_maker.moved(whole, [(apply, 0.0)], at) == 0.0


def test_the_mix_is_drawn_in_the_stated_shares() -> None:
    kinds = [gap_maker.drawn_kind(seed) for seed in range(4000)]
    for kind, part in {"none": 0.15, "one": 0.35, "two": 0.25, "three": 0.10, "outside": 0.15}.items():
        assert kinds.count(kind) / len(kinds) == pytest.approx(part, abs=0.025)


def test_a_zero_of_the_last_axis_and_a_turned_tool_are_one_group_and_a_track_is_none_of_it() -> None:
    case = Separation(5, only="joint_offset", sizes=(2.0, 3.0))
    case.true = {"joint_offset": case._pattern(lambda w: shift(w, 5, 1e-3))}
    case.spans.clear()
    assert case.same({"joint_offset"})
    assert case.same({"frame_tool"})
    assert not case.same({"track"})
    assert not case.same({"frame_tool", "track"})
    assert not case.same({"joint_offset", "frame_tool"})


def test_groups_of_tasks_go_on_side_by_side_and_no_case_comes_twice() -> None:
    tasks = gap_benchmark.tasks_of(argparse.Namespace(first=0, cases=100, nothing=20, each=1, left_out=2))
    assert len({t["key"] for t in tasks}) == len(tasks) == 100 + 20 + 20 + 40
    half = [t["key"].rpartition(" ")[0] for t in tasks[: len(tasks) // 2]]
    assert abs(half.count("mix") - 50) <= 1
    assert abs(half.count("left out") - 20) <= 1


def read_table(file: Path) -> dict[str, np.ndarray]:
    header = file.open().readline().strip().split(",")
    return dict(zip(header, np.loadtxt(file, delimiter=",", skiprows=1).T, strict=True))


def test_a_case_on_a_given_motion_has_its_set_points_clock_columns_and_instrument(tmp_path: Path) -> None:
    given, made = tmp_path / "given", tmp_path / "made"
    given.mkdir()
    made.mkdir()
    gap_maker.write_case(given, 77, "none")
    motion, other = given / "77.csv", given / "77_withheld.csv"
    label = gap_maker.write_case(made, 5, only="backlash", sizes=(6.0, 6.5), motions=(motion, other))
    for old, new in ((motion, made / "5.csv"), (other, made / "5_withheld.csv")):
        a, b = read_table(old), read_table(new)
        assert list(a) == list(b)
        assert np.array_equal(a["t"], b["t"])
        for n in ("cA1", "cA5", "cE1", "cE2"):
            assert np.abs(a[n] - b[n]).max() < 1e-3
        assert tomllib.loads(new.with_suffix(".toml").read_text()) == pytest.approx(
            tomllib.loads(old.with_suffix(".toml").read_text())
        )
        moved = np.sqrt(np.mean(sum((a[n] - b[n]) ** 2 for n in "xyz")))
        if new.stem == "5":
            assert moved / label["noise_mm"] == pytest.approx(label["effects"]["backlash"]["size"], rel=0.25)
    case = Separation(5, only="backlash", sizes=(6.0, 6.5), motions=(motion, other))
    assert case.label["effects"] == label["effects"]
    assert len(case.world.t) > 4 * len(case.at)


def test_motions_that_lack_an_axis_or_are_poses_are_refused_and_what_they_can_not_show_is_not_drawn(
    tmp_path: Path,
) -> None:
    gap_maker.write_case(tmp_path, 77, "none")
    motion = tmp_path / "77.csv"
    names = gap_maker.names_on(motion)
    assert {"servo_lag", "backlash", "cutting_force", "latency"} <= set(names)
    assert not {"early_reading", "frame_table", "measurement_frame"} & set(names)
    tasks = gap_benchmark.tasks_of(
        argparse.Namespace(first=0, cases=3, nothing=1, each=1, left_out=0, on=motion, on_withheld=None)
    )
    assert len(tasks) == 4 + len(names)
    assert all(t["on"] == [str(motion)] * 2 for t in tasks)
    lame = tmp_path / "lame.csv"
    lame.write_text(motion.read_text().replace("A4", "B4"))
    with pytest.raises(ValueError, match=r"lame\.csv lacks the column c?A4"):
        read_motion(lame)
    motion.with_suffix(".toml").write_text("poses = true\n")
    with pytest.raises(ValueError, match="single poses"):
        read_motion(motion)


def said(**more):
    return {
        "effects": [],
        "status": "no gap",
        "alternatives": [{"effects": [], "probability": 1.0}],
        "seconds": 1.0,
        "rows": 9,
        "unknown": {"probability": 0.0},
        "together": {"removable_removed": None, "shrink": 0.0, "predicted_shrink": 0.0},
        "rungs": {},
        "regimes": {"position": 1.0},
        "noise_mm": 0.03,
        **more,
    }


def test_the_scorer_counts_alarms_hits_and_unknowns() -> None:
    rig = {"noise_mm": 0.03, "lacks": "", "poses": True, "in_base": False, "position_only": False}
    nothing = {"kind": "none", "effects": {}, **rig}
    one = {"kind": "one", "effects": {"latency": {"size": 3.0}}, **rig}
    hit = said(
        status="explained",
        effects=[{"effect": "latency", "probability": 0.9, "axes": []}],
        alternatives=[{"effects": ["latency"], "probability": 1.0}],
    )
    alarm = said(status="unexplained")
    rows = [
        Row("mix", {"seed": 1}, nothing, said()),
        Row("nothing", {"seed": 2}, nothing, alarm),
        Row("mix", {"seed": 3}, one, hit),
    ]
    figures = score(rows)
    assert figures["false alarms"]["hits"] == 1
    assert figures["false alarms"]["count"] == 2
    assert figures["one effect at >= 2x noise"]["right first"]["share"] == 1.0
    assert figures["truth in the reported set"]["share"] == 1.0
    assert figures["size of the reported set"]["groups"] == 1.0
    assert figures["false unknowns"]["hits"] == 0
    json.dumps(figures, default=float)


def test_the_scorer_judges_the_place_of_what_is_foreign() -> None:
    """Stage, first axis, and what it follows first; an axis named where none is to blame is wrong."""
    rig = {"noise_mm": 0.03, "lacks": "", "poses": False, "in_base": False, "position_only": False}

    def judged(kind, said_axes, regimes, rung="encoder_to_tcp", **facts):
        label = {"kind": "outside", "effects": {kind: {"size": 3.0, **facts}}, **rig}
        where = {"rung": rung, "axes": said_axes, "regimes": regimes}
        return placed(Row("mix", {"seed": 1}, label, said(unknown={"probability": 1.0, "where": where})))

    assert all(judged("bent_axis", ["A1"], ["position"], axes=["A1"]).values())
    assert not judged("bent_axis", ["A2", "A1"], ["position"], axes=["A1"])["axis"]
    assert not judged("bent_axis", [], ["position"], axes=["A1"])["axis"]
    assert all(judged("slip", [], ["time", "position"]).values())
    assert not judged("slip", ["E1"], ["time"])["axis"]
    assert not judged("slip", [], ["position", "time"])["what it follows"]
    assert not judged("vibration", [], [], rung="setpoint_to_encoder")["stage"]
    assert all(judged("loose_tool", ["A6"], ["position"]).values())


def test_intervals_and_calibration_against_known_numbers() -> None:
    assert share(5, 10)["interval"] == pytest.approx([0.2366, 0.7634], abs=1e-4)
    assert upper_bound(0, 300) == pytest.approx(0.00994, abs=1e-4)
    assert calibration([(0.95, True)] * 19 + [(0.95, False)])["error"] == pytest.approx(0.0, abs=1e-12)
    assert calibration([(0.9, False)])["error"] == pytest.approx(0.9)


@pytest.mark.slow
def test_a_shape_that_stands_out_beside_a_smooth_rest_has_the_place_and_no_field_over_the_rest() -> None:
    """A counterweight's spring at A2, beside a smooth rest that is as large: a field over all postures takes more of both."""
    cause = gap_places.causes(gap_places.UR)["a counterweight's spring at A2"]
    said = gap_places.asked(gap_places.UR, cause, 3)
    assert said["claims"] == {}
    assert gap_places.judged(cause, said)["place"]
