"""What the engine asks of an effect's own record instead of its name, and what it makes of the answer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gap_cases import kr15, simulated
from gap_cells import log_of, ur10
from summary_samples import diagnosis_summary
from test_gap_pose_sets import TARGET, postures, seen_from

from camrob.gap.effects.effect import Unit
from camrob.gap.effects.registry import library
from camrob.gap.evidence.design import build_units
from camrob.gap.evidence.shrink import Shrinkage
from camrob.gap.evidence.unknown import quantities
from camrob.gap.observation.scene import make_scene
from camrob.gap.pose_sets import fitted_scenes
from camrob.gap.verdict import verdict, withdrawn
from camrob.gap.verdict.belief import BELIEF
from camrob.gap.verdict.within import BEYOND
from camrob.report.diagnosis.bars import place_charts

UNITS = tuple(Unit(n, "", ()) for n in ("one", "other"))


def passing(degrees: float):
    """A log of a UR10 whose A1 passes so many degrees."""
    axis = np.deg2rad([20.0, -90, 60, -60, -90, 10]) + np.zeros((40, 6))
    axis[:, 0] += np.deg2rad(np.linspace(0.0, degrees, 40))
    return make_scene(log_of(ur10(), np.arange(40.0), axis, {}, poses=True), ur10())


@pytest.mark.parametrize(
    ("degrees", "order", "whole"), [(190, 1, False), (361, 1, True), (22, 17, False), (42, 17, False), (43, 17, True)]
)
def test_a_ripple_is_whole_where_its_axis_passes_its_turn_or_two_cycles(
    degrees: float, order: float, *, whole: bool
) -> None:
    effect = next(e for e in library() if e.orders)
    state = {"A1_order": float(order)} if order != 1 else {}
    units = [
        u for u in effect.units([passing(degrees)], state) if u.axis == "A1" and ("order" in u.key) == (order != 1)
    ]
    assert [effect.whole([passing(degrees)], u, state) for u in units] == [whole]


def test_of_less_than_half_a_turn_no_ripple_is_offered() -> None:
    """A counterweight's stop, and a carriage's waves, were a ripple of A2 at 62 to 78 %, which passed 120 degrees."""
    effect = next(e for e in library() if e.orders)
    assert [u.axis for u in effect.units([passing(170.0)], {})] == []
    assert [u.key for u in effect.units([passing(170.0)], {"A1_order": 50.0})] == ["A1_order"]


def test_effects_without_a_period_are_always_seen_whole() -> None:
    scene = passing(90.0)
    for effect in (e for e in library() if not e.orders):
        assert all(effect.whole([scene], u, effect.start) for u in effect.units([scene], effect.start))


class Held:
    """A model of two units, the first of which makes the gap worse where the second is not taken away with it."""

    units = UNITS
    best = type("Best", (), {"members": frozenset({0, 1})})


def shrunk(_model, _trial, _all, members) -> Shrinkage:
    after = {frozenset({0}): 3.0, frozenset({1}): 0.9, frozenset({0, 1}): 0.5, frozenset(): 1.0}[frozenset(members)]
    rows = np.ones((40, 3)) * np.linspace(0.9, 1.1, 40)[:, None]
    return Shrinkage(rows, after * rows, np.arange(40) // 4)


def test_a_claim_whose_share_another_cancels_that_is_not_claimed_is_withdrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(withdrawn, "shrinkage", shrunk)
    assert withdrawn.worse_together(Held, None, {"one": 0.9, "other": 0.9}) == []
    assert withdrawn.worse_together(Held, None, {"one": 0.9, "other": 0.2}) == ["one"]
    assert withdrawn.worse_together(Held, None, {"one": 0.2, "other": 0.9}) == []


def test_what_the_user_lives_with_is_no_gap_beside_an_unknown_too() -> None:
    unknown = replace(diagnosis_summary().unknown, probability=0.9, share=0.5, rms_mm=0.1)
    assert verdict._status({"encoder_to_tcp": "tolerance"}, (), unknown) == "no gap"
    assert verdict._status({"encoder_to_tcp": "noise"}, (), unknown) == "unexplained"
    beyond = {"encoder_to_tcp": "tolerance", "setpoint_to_encoder": BEYOND}
    assert verdict._status(beyond, (), unknown) == "unexplained"


@pytest.mark.parametrize(
    ("rms_mm", "share", "status"),
    [
        (0.37, 0.093, "partly explained"),  # of a UR10's 1.21 mm, 21 times the noise
        (0.015, 0.093, "explained"),  # less than the noise, and than a tenth
        (0.015, 0.2, "partly explained"),
        (0.008, 0.2, "explained"),  # a fifth of a gap that is next to nothing
        (0.055, 0.0018, "partly explained"),  # 4 % of what is claimed: three times the noise
        (0.30, 0.0005, "explained"),  # 2 % of it: no description is better, however small the noise
    ],
)
def test_an_unknown_beside_claims_is_likely_only_where_it_matters_and_the_status_says_the_same(
    rms_mm: float, share: float, status: str
) -> None:
    likely = BELIEF.matters(rms_mm, share, 0.0173)
    unknown = replace(diagnosis_summary().unknown, probability=min(1.0, likely), share=share, rms_mm=rms_mm)
    assert verdict._status({"encoder_to_tcp": BEYOND}, ("geometry",), unknown) == status
    assert (likely >= 0.5) == (status == "partly explained")


def test_the_unknown_may_follow_the_last_move_s_direction_at_single_poses() -> None:
    axis = postures(30, 3)
    found = quantities(make_scene(log_of(ur10(), np.arange(30.0), axis, {}, poses=True), ur10()))
    side = found["direction of A2"]
    assert np.array_equal(np.sign(side[1:]), np.sign(np.diff(axis[:, 1])))
    assert not any("speed" in name for name in found)


def test_two_fitted_logs_with_one_instrument_have_one_frame() -> None:
    first = seen_from(postures(40, 1))
    other = seen_from(postures(40, 2), seed=7, same_frame_as="set.csv", target=[-0.05, *TARGET[1:]])
    other = replace(other, path=other.path.with_name("other.csv"))
    scenes = fitted_scenes([first, other], [ur10(), ur10()])
    assert np.array_equal(scenes[0].frames.left, scenes[1].frames.left)
    effects = library()
    units = build_units(scenes, effects, {e.name: e.start for e in effects})
    frames = [u for u in units if u.key.startswith(("left", "right"))]
    # one place of the instrument, and each target's own
    assert sorted(u.key.partition("|")[0] for u in frames) == ["left0", "right0", "right1"]


def test_the_axes_that_are_blamed_come_first_and_the_others_in_grey() -> None:
    plain = diagnosis_summary()
    assert plain.blamed_axes == ()
    shares = {"A1": 0.9, "A2": 0.2, "E1": 0.5}
    where = replace(plain.where, axes=shares, axis_intervals={k: (v, v) for k, v in shares.items()})
    at = replace(plain.unknown, where=replace(plain.unknown.where, axes=("E1",)))
    summary = replace(plain, where=where, unknown=at)
    assert summary.blamed_axes == ("E1",)
    chart = next(c for c in place_charts(summary) if c["id"] == "by-axis")
    shown, colors = chart["traces"][0]["y"], chart["traces"][0]["marker"]["color"]
    assert [name.partition(":")[0] for name in shown] == ["E1", "A1", "A2"]
    assert colors[1] == colors[2] != colors[0]


@pytest.mark.slow
def test_a_plan_to_isolate_the_unknown_says_what_answer_it_expects() -> None:
    from camrob.gap.evidence.comparison import compare
    from camrob.gap.experiment.experiment import plan_experiment

    def bent(world) -> None:
        """A1 is off by a bump in A2's angle: nothing of the library."""
        angle = world.command[:, 1]
        x = (angle - angle.mean()) / angle.std()
        world.after = world.after + 0.3e-3 * np.exp(-4.0 * x**2)[:, None] * np.array([0.0, 1.0, 0.0])

    model = compare([make_scene(simulated(bent, sigma_mm=0.02), kr15())], library())
    planned = plan_experiment(model, (), ["A1", "A2"], unknown=True)
    assert planned is not None
    assert planned.figures.to_json()["separation_mm"] > 0.0
    assert f"{planned.figures.to_json()['separation_mm']:.3f} mm rms about its mean if it sits there" in planned.text
    # what follows A2 shows where A2 moves, whatever it moves itself
    assert planned.motions[0].axis == "A2"
    shown = {c["motion"]: c["separation_mm"] for c in planned.figures.to_json()["considered"]}
    assert shown["one axis A2"] > 3.0 * shown["one axis A1"]
