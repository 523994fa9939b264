"""A program at its own feed: limits that it passes, the time with all of them kept, and the torques of its motion."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest
from feed_paths import CELL, path_of, track_path, wave
from summary_samples import POST, post_summary

from camrob.cli.app import run
from camrob.dynamics.motion_torques import motion_torques
from camrob.dynamics.torques import joint_torques
from camrob.report.post.feed_sections import feed_section, torque_section
from camrob.report.post.feed_sentences import feed_rows
from camrob.timing.as_it_stands import program_as_it_stands
from camrob.timing.optimal import optimal_feed
from camrob.timing.timing import program_time

SAMPLE = CELL.folder.parents[1] / "toolpaths" / "engraving" / "engraving.cls"


def stands(path, q, speed, **more):
    speed = np.full(len(path), speed)
    return program_as_it_stands(CELL, path, q, program_time(CELL, path, q, speed=speed), speed=speed, **more)


def test_a_straight_line_at_a_moderate_feed_passes_nothing():
    path, q = track_path(np.linspace(0.0, 0.8, 81), feed=0.1)
    found = stands(path, q, 0.1)
    speed, acceleration, _jerk = found.worst
    assert speed.times == pytest.approx(0.1 / CELL.limits_of("speed")[CELL.index("E1")], rel=1e-3)
    assert acceleration.times == pytest.approx(1.0, rel=0.02)  # its ramps take the track's whole acceleration
    assert found.past < 0.02 and found.override == pytest.approx(1.0, abs=0.02)


def test_a_turn_on_the_spot_breaks_the_tracks_jerk_there_and_costs_time_once_it_is_kept():
    y = np.concatenate([np.linspace(0.0, 0.1, 11), np.linspace(0.1, 0.0, 11)[1:]])
    path, q = track_path(y, feed=0.2)
    timing = program_time(CELL, path, q, speed=np.full(21, 0.2))
    found = stands(path, q, 0.2)
    jerk = found.worst[2]
    assert jerk.times > 2.0 and jerk.cause == "E1 jerk" and jerk.axis == "E1"
    assert abs(jerk.point - 10) <= 1 and jerk.line == path.line[jerk.point]
    share = min(1.0 / max(1.0, w.times) ** (1.0 / n) for n, w in enumerate(found.worst, start=1))
    assert found.override == pytest.approx(share) and found.total == pytest.approx(timing.total / share)
    # slowed evenly it keeps what it broke, and the plan, under the same limits, is faster
    plan = optimal_feed(CELL, path, q, rapid_speed=0.2)
    assert max(plan.use.values()) <= 1.0 + 1e-9 and plan.total < found.total


def test_the_axes_motion_is_that_of_differences_over_time():
    path, q = path_of(wave(4000), feed=0.1)
    plan = optimal_feed(CELL, path, q, rapid_speed=0.2)
    found = stands(path, q, 0.1, plan=plan)
    inner = slice(300, -300)
    speed = np.gradient(q, plan.at, axis=0)
    assert np.abs(found.speed - speed)[inner, :8].max() < 0.05 * np.abs(speed).max()  # the smooth curve rounds a little
    assert np.abs(found.speed - speed)[inner, :8].mean() < 0.001 * np.abs(speed).max()
    acceleration = np.gradient(speed, plan.at, axis=0)
    off = np.abs(found.acceleration - acceleration)[inner, :8]
    assert np.median(off) < 1e-4 and off.mean() < 0.1 * np.abs(acceleration[inner, :8]).mean()


def test_a_long_cut_judged_in_stretches_is_judged_alike(monkeypatch):
    """Each stretch has a grid of its own, so that figures differ by what a grid does: some percent."""
    path, q = path_of(wave(3000, turns=4.0), feed=0.1)
    whole = stands(path, q, 0.1)
    monkeypatch.setattr("camrob.timing.as_it_stands._STRETCH", 700)
    parts = stands(path, q, 0.1)
    for one, other in zip(whole.worst, parts.worst, strict=True):
        assert one.times == pytest.approx(other.times, rel=0.1) and one.cause == other.cause
    assert parts.past == pytest.approx(whole.past, abs=0.01) and parts.total == pytest.approx(whole.total, rel=0.03)
    for name in ("speed", "acceleration"):
        a, b = getattr(whole, name), getattr(parts, name)
        assert np.abs(a - b).mean() < 0.005 * np.abs(a).max()


def test_torques_of_many_postures_are_pinocchios():
    rng = np.random.default_rng(7)
    q = wave(60)
    v, a = rng.standard_normal((2, *q.shape))
    ours, theirs = motion_torques(CELL, q, v, a), joint_torques(CELL, q, v, a)
    assert np.allclose(ours.total, theirs.total, atol=1e-9) and np.allclose(ours.gravity, theirs.gravity, atol=1e-9)
    assert np.abs(ours.total - ours.gravity).max() > 1.0
    with pytest.raises(ValueError, match="must be"):
        motion_torques(CELL, q, v[:5], a)
    massless = dataclasses.replace(CELL, masses=())
    assert np.all(motion_torques(massless, q, v, a).total == 0.0)


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("mode", ["program", "optimal"])
def test_a_post_says_where_feed_is_lost_and_its_program_passes_verify(mode, tmp_path, capsys):
    cell = str(CELL.folder)
    assert run(["post", str(SAMPLE), "--cell", cell, "--out", str(tmp_path), "--feed", mode, "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    feed, torques = summary["feed"], summary["torques"]
    assert feed["mode"] == mode and feed["losses_count"] >= len(feed["losses"]) > 0
    assert sum(feed["lost_by_axis_s"].values()) == pytest.approx(feed["lost_s"], rel=1e-3)
    # from the plunge's feed to that of the cut: what isn't reached holds nothing back
    assert "programmed feed" not in {one["cause"] for one in feed["losses"]}
    loss = feed["losses"][0]
    assert loss["cause"] and loss["reached_mm_min"] < loss["feed_mm_min"] and loss["lost_s"] > 0.0
    lines = SAMPLE.read_text(encoding="utf-8").count("\n")
    assert 0 < loss["first_line"] <= loss["last_line"] <= lines
    plain, jerked = feed["compared"]
    assert plain["program_s"] == pytest.approx(summary["time_s"]["program"], rel=1e-4)
    assert jerked["program_s"] >= plain["program_s"]
    if mode == "optimal":
        assert jerked["planned_s"] == pytest.approx(summary["time_s"]["optimal"], rel=1e-4)
        assert plain["planned_s"] <= jerked["planned_s"] <= jerked["program_s"]
        assert plain["planned_s"] == pytest.approx(plain["program_s"], rel=0.02)
        assert max(feed["planned_uses"].values()) <= 1.0
        assert feed["written"]["percent_of_cutting"] <= feed["program_breaks"]["percent_of_cutting"]
        # what is written keeps the limits in the controller's model, and is faster than the program slowed evenly
        assert feed["written"]["percent_of_cutting"] < 0.01 and feed["written"]["points_added"] > 0
        assert plain["program_s"] <= feed["written"]["model_s"] < 0.85 * jerked["program_s"]
        assert any(loss["axis"] for loss in feed["losses"])
    assert torques["standing"] == "assumed masses" and torques["axes"]["A2"]["max_nm"] > 100.0
    with np.load(tmp_path / "engraving.path.npz") as data:
        assert data["torque"].shape == (len(data["torque_row"]), 9) and data["torque_row"].max() == len(data["q"]) - 1
        assert np.abs(data["torque"]).max(axis=0)[2] <= torques["axes"]["A2"]["max_nm"] * 1.0001
    page = (tmp_path / "engraving.html").read_text(encoding="utf-8")
    assert "Feed: time, limits and losses" in page and "Largest torques" in page and loss["cause"] in page
    program = str(tmp_path / "engraving.src")
    assert run(["verify", program, "--cell", cell, "--against", str(SAMPLE), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["ok"] is True
    if mode == "program":  # the derivatives of a program and of the path that it was made from are alike
        solved = str(tmp_path / "engraving.path.npz")
        both = ["--solution", program, "--compensated", solved, "--cell", cell, "--out", str(tmp_path / "feed")]
        assert run(["feed", *both, "--json"]) == 0
        found = [a for a in json.loads(capsys.readouterr().out)["analyses"] if a["interpolation"] == "smooth"]
        rates = [a["rate_admitted"]["speed"] for a in found]
        assert rates[0] == pytest.approx(rates[1], rel=0.5) and rates[0] > 0.2


def test_hostile_words_in_a_summary_stay_words():
    loss = POST["feed"]["losses"][0] | {"cause": "<script>x</script>"}
    made = post_summary(
        feed={"losses": [loss], "lost_by_axis_s": {"<b>": 1.0}},
        torques={"axes": {"<i>": POST["torques"]["axes"]["A2"]}, "masses": ["<u>"]},
    )
    page = feed_section(made.feed) + torque_section(made.torques)
    assert "&lt;script&gt;" in page and "&lt;i&gt;" in page
    assert not any(tag in page for tag in ("<script>", "<b>", "<i>", "<u>"))
    assert any("<script>" in text for _label, text in feed_rows(made.feed, made.torques))  # plain text in the terminal
    assert torque_section(None) == "" and "Torques" not in dict(feed_rows(made.feed, None))
