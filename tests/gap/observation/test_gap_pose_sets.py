"""Sets of single poses: frames stay where the fitted poses put them, and postures are withheld whole."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from gap_cells import log_of, ur10
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from camrob.calibration.error_model import ErrorModel
from camrob.errors import LogError
from camrob.gap.diagnose import diagnose
from camrob.gap.effects.registry import library
from camrob.gap.evidence.comparison import compare
from camrob.gap.evidence.model import seen_moves, seen_rms, whole_gap
from camrob.gap.evidence.shrink import shrinkage, trial_of
from camrob.gap.observation.scene import make_scene
from camrob.gap.pose_sets import fitted_scenes, frozen_frames, with_whole_postures, withheld_scene
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import MeasuredFrame, Target
from camrob.report.diagnosis.charts import space_clouds

UNKNOWN = {"measured_frame": MeasuredFrame.UNKNOWN, "target": Target.UNKNOWN, "poses": True}
ZEROS = {"A2.zero": 1.2e-3, "A3.zero": -0.8e-3, "A4.zero": 1e-3}
FRAME = [0.4, -0.3, 0.2, 0.3, -1.1, 2.0]  # the instrument in the hall: m, rotation vector
TARGET = [0.03, 0.05, 0.08, 0.0, 0.0, 0.0]


def rigid(x) -> np.ndarray:
    T = np.eye(4)
    T[:3, 3], T[:3, :3] = x[:3], Rotation.from_rotvec(x[3:]).as_matrix()
    return T


def postures(count: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return np.deg2rad([20, -90, 60, -60, -90, 10.0]) + rng.uniform(-1, 1, (count, 6)) * np.deg2rad(
        [80, 30, 45, 60, 50, 90]
    )


def seen_from(axis, *, frame=FRAME, target=TARGET, seed=0, **facts) -> MeasurementLog:
    """Poses of a UR10 with wrong zeros, positions alone, seen from an instrument at `frame`, of a reflector at `target`."""
    cell = ur10()
    edge = np.rad2deg(axis)
    poses = ErrorModel.of(cell, list(ZEROS)).poses(np.array(list(ZEROS.values())), cell.to_q(edge))
    place = (rigid(frame) @ poses @ rigid(target))[:, :3, 3]
    place = 1e3 * place + np.random.default_rng(seed).normal(0.0, 0.01, place.shape)
    plain = log_of(cell, np.arange(float(len(axis))), axis, {}, **{**UNKNOWN, **facts}).info
    columns = {"t": np.arange(float(len(axis))), **dict(zip("xyz", place.T, strict=True))}
    columns |= {f"A{k + 1}": edge[:, k] for k in range(6)}
    return MeasurementLog(columns, replace(plain, sigma_position=1e-5), Path("set.csv"))


def test_the_direction_of_the_last_move_shows_play_at_single_poses() -> None:
    """Play of A2, 0.05 degrees: the link stops short by half of it on the way to each pose, and keeps it where A2 stays."""
    axis = postures(60, 4)
    axis[10:13, 1] = axis[9, 1]
    half = 0.5 * np.deg2rad(0.05)
    link, real = axis[0, 1] - half, []
    for value in axis[:, 1]:
        # pushed along by whichever flank touches
        link = value - half if value - half > link else value + half if value + half < link else link
        real.append(link)
    turned = np.array(axis)
    turned[:, 1] = real
    log = log_of(ur10(), np.arange(60.0), turned, {}, sigma_mm=0.0, poses=True)
    columns = {**log.columns, "A2": np.rad2deg(axis[:, 1]), "cA2": np.rad2deg(axis[:, 1])}
    scene = make_scene(MeasurementLog(columns, log.info), ur10())
    effect = next(e for e in library() if e.name == "backlash")
    unit = next(u for u in effect.units([scene], {}) if u.axis == "A2")
    column = effect.columns(scene, unit, {"A2_deg": 2.0 * half})[0]
    sure = column.doubt < 1.0 if column.doubt is not None else np.ones(60, bool)
    assert sure.sum() > 50
    assert np.abs(scene.tcp_gap - 2.0 * half * column.tcp)[sure, :3].max() < 1e-6


def model_of(logs):
    names = {"joint_offset", "geometry", "early_reading"}
    return compare([make_scene(log, ur10()) for log in logs], [e for e in library() if e.name in names])


def errors_by_hand(fitted: MeasurementLog, asked: MeasurementLog) -> tuple[float, float]:
    """rms in m at the asked poses, frames (and then zeros with them) fitted to the other log by SciPy alone."""
    cell = ur10()

    def residual(x, log, zeros):
        q = np.deg2rad(np.stack([log.columns[f"A{k}"] for k in range(1, 7)], axis=1)).copy()
        q[:, 1:4] += zeros
        T = ErrorModel.of(cell, []).poses(np.zeros(0), q)
        return (
            (rigid(x[:6]) @ T)[:, :3, :3] @ x[6:9] + (rigid(x[:6]) @ T)[:, :3, 3] - 1e-3 * log.matrix("xyz")
        ).ravel()

    start = np.r_[FRAME, TARGET[:3]]
    plain = least_squares(lambda x: residual(x, fitted, np.zeros(3)), start, x_scale=1e-3).x
    whole = least_squares(lambda x: residual(x[:9], fitted, x[9:]), np.r_[start, np.zeros(3)], x_scale=1e-3).x
    before, after = residual(plain, asked, np.zeros(3)), residual(whole[:9], asked, whole[9:])
    return tuple(float(np.sqrt(np.mean(np.sum(r.reshape(-1, 3) ** 2, axis=1)))) for r in (before, after))


@pytest.mark.parametrize("count", [5, 30])
def test_a_withheld_set_is_judged_in_the_frames_of_the_fitted_poses(count: int) -> None:
    """Against frames and zeros that SciPy fits to the training poses: with five poses as with thirty."""
    fitted = seen_from(postures(60, 1))
    asked = seen_from(postures(count, 2), seed=5, same_frame_as="set.csv", same_target_as="set.csv")
    model = model_of([fitted])
    trial = frozen_frames(model, trial_of(model, [withheld_scene(asked, ur10(), model.scenes)]))
    zeros = frozenset(i for i in model.best.members if model.units[i].effect == "joint_offset")
    shrunk = shrinkage(model, trial, model.best.members, zeros)
    before, after = errors_by_hand(fitted, asked)
    assert shrunk.rms_before == pytest.approx(before, rel=0.02)
    assert shrunk.rms_after == pytest.approx(after, rel=0.1)
    assert shrunk.shrink > 0.9


def test_blocks_of_a_set_are_judged_in_the_frames_of_the_others() -> None:
    """21 poses: frames fitted to the two that are asked eat their gap; fitted to the other 19 they show it."""
    model = with_whole_postures(model_of([seen_from(postures(21, 3))]))
    trial = frozen_frames(model, trial_of(model, ()))
    zeros = frozenset(i for i in model.best.members if model.units[i].effect == "joint_offset")
    shrunk = shrinkage(model, trial, model.best.members, zeros)
    log = model.scenes[0].log
    parts = []
    for _, rows, _ in trial.asked:
        before, after = errors_by_hand(log.select(~rows), log.select(rows))
        parts.append((before**2 * rows.sum(), after**2 * rows.sum()))
    before, after = np.sqrt(np.sum(parts, axis=0) / 21)
    assert shrunk.rms_before == pytest.approx(before, rel=0.05)
    assert shrunk.rms_after == pytest.approx(after, rel=0.35)
    assert shrunk.rms_after < 0.2 * shrunk.rms_before


def test_four_poses_do_where_frame_and_target_are_known_and_eleven_do_not_where_they_are_not() -> None:
    scenes = [make_scene(seen_from(postures(40, 1)), ur10())]
    known = seen_from(postures(4, 2), same_frame_as="set.csv", same_target_as="set.csv")
    assert len(withheld_scene(known, ur10(), scenes)) == 4
    with pytest.raises(LogError, match="holds 3 whole samples; give at least 4"):
        withheld_scene(known.select(slice(0, 3)), ur10(), scenes)
    for facts in ({}, {"same_frame_as": "set.csv"}, {"same_frame_as": "other.csv", "same_target_as": "other.csv"}):
        with pytest.raises(LogError, match="give at least 12"):
            withheld_scene(seen_from(postures(11, 2), **facts), ur10(), scenes)


def three_targets(counts=(8, 12, 10), **facts) -> list[MeasurementLog]:
    """One instrument, three reflectors on the flange, each measured on postures of its own: a log a reflector."""
    logs, seeds = [], (21, 22, 23)
    for k, (count, seed) in enumerate(zip(counts, seeds, strict=True)):
        own = {"same_frame_as": "set0.csv"} if k and "same_frame_as" not in facts else {}
        seen = seen_from(
            postures(count, seed), target=[0.05 * k - 0.04, 0.05, 0.06 + 0.02 * k, 0, 0, 0], seed=seed, **own, **facts
        )
        logs.append(MeasurementLog(seen.columns, seen.info, Path(f"set{k}.csv")))
    return logs


def test_every_set_that_is_fitted_needs_poses_for_its_own_frames_alone() -> None:
    """Eight where frame and target are open, four where one is or none: every value is held to its ordinary size beside them."""
    assert [len(s) for s in fitted_scenes(three_targets(), [ur10()] * 3)] == [8, 12, 10]
    assert [len(s) for s in fitted_scenes(three_targets()[:1], [ur10()])] == [8]
    with pytest.raises(LogError, match="holds 7 whole samples; give at least 8"):
        fitted_scenes(three_targets((7, 12, 10)), [ur10()] * 3)
    known = seen_from(postures(5, 2), measured_frame=MeasuredFrame.WORLD, target=TARGET, poses=True)
    known = MeasurementLog(known.columns, replace(known.info, target=Target.TOOL), known.path)
    assert len(fitted_scenes([known.select(slice(0, 4))], [ur10()])[0]) == 4
    with pytest.raises(LogError, match="holds 3 whole samples; give at least 4"):
        fitted_scenes([known.select(slice(0, 3))], [ur10()])


def test_ten_poses_show_the_zeros_and_no_more_is_said_than_they_tell() -> None:
    """They were refused: 12 were needed. Judged on 40 poses in the same frames, beside what was predicted."""
    asked = seen_from(postures(40, 2), seed=5, same_frame_as="set.csv", same_target_as="set.csv")
    asked = MeasurementLog(asked.columns, asked.info, Path("asked.csv"))
    told = diagnose([seen_from(postures(10, 1))], ur10(), withheld=[asked]).summary.to_json()
    assert "joint_offset" in [e["effect"] for e in told["effects"] if e["probability"] >= 0.5]
    together = told["together"]
    assert together["rms_after_mm"] < 0.25 * together["rms_before_mm"]
    assert together["predicted_shrink"] == pytest.approx(together["shrink"], abs=0.15)


def test_three_targets_of_few_poses_show_the_zeros() -> None:
    found = diagnose(three_targets((10, 16, 14)), ur10())
    assert "joint_offset" in found.claimed
    assert found.summary.to_json()["together"]["rms_after_mm"] < 0.03  # the noise is 0.017 mm


def test_the_size_of_an_effect_is_what_open_frames_leave_of_it() -> None:
    """Open frames take up a part of how zeros move the reflector: against both frames fitted by hand."""
    logs = [seen_from(postures(60, 31))]
    model = model_of(logs)
    zeros = frozenset(i for i in model.best.members if model.units[i].effect == "joint_offset")
    (moved,) = [p.moves(model.values(zeros, model.best)) for p in model.panels]
    (left,) = seen_moves(model, model.panels, model.values(zeros, model.best))
    nominal = model.scenes[0].nominal

    def residual(x) -> np.ndarray:
        T = rigid(x[:6]) @ nominal
        return (T[:, :3, 3] + np.einsum("nij,j->ni", T[:, :3, :3], x[6:9]) - nominal[:, :3, 3] - moved).ravel()

    by_hand = least_squares(residual, np.zeros(9), x_scale=1e-3).fun.reshape(-1, 3)
    rms = [float(np.sqrt(np.mean(np.sum(m**2, axis=1)))) for m in (moved, left, by_hand)]
    assert rms[1] == pytest.approx(rms[2], rel=0.02)
    assert rms[1] < 0.7 * rms[0]
    assert seen_rms(model, model.panels, "joint_offset") == pytest.approx(rms[1])


def test_a_withheld_set_in_inches_is_refused_as_a_fitted_one_is() -> None:
    """It was judged: a gap of a metre, of which nothing is known."""
    asked = seen_from(postures(20, 2), seed=5, same_frame_as="set.csv", same_target_as="set.csv")
    inches = {n: v / 25.4 if n in ("x", "y", "z") else v for n, v in asked.columns.items()}
    with pytest.raises(LogError, match=r"asked\.csv.*in inches"):
        diagnose([seen_from(postures(20, 1))], ur10(), withheld=[MeasurementLog(inches, asked.info, Path("asked.csv"))])


def test_every_withheld_set_has_frames_of_its_own() -> None:
    """Two nights, each with the instrument and the reflector elsewhere: the second is judged as the first is."""
    other, moved = [1.1, 0.2, -0.3, -0.2, 0.9, 1.0], [-0.06, 0.02, 0.11, 0.0, 0.0, 0.0]
    nights = [seen_from(postures(60, 8), seed=8), seen_from(postures(60, 9), frame=other, target=moved, seed=9)]
    fitted = seen_from(postures(120, 7), frame=[0.1, 0.5, 0.4, 1.3, 0.1, -2.0], seed=7)
    left = []
    for withheld in (nights, nights[::-1]):
        found = diagnose([fitted], ur10(), withheld=withheld)
        assert "joint_offset" in found.claimed
        left.append(found.summary.to_json()["together"]["rms_after_mm"])
    assert max(left) < 0.025  # the noise is 0.017 mm


def test_targets_on_the_same_postures_are_withheld_together() -> None:
    """Two reflectors, the second log without some of the postures; and a log that measures each posture twice over."""
    axis = postures(60, 1)
    second = seen_from(
        np.delete(axis, [3, 17, 18, 40], axis=0), target=[-0.04, 0.02, 0.1, 0, 0, 0], same_poses_as="set.csv"
    )
    second = MeasurementLog(second.columns, second.info, Path("second.csv"))
    model = with_whole_postures(model_of([seen_from(axis), second]))
    for k, scene in enumerate(model.scenes):
        for row in range(len(scene)):
            same = np.flatnonzero((np.abs(model.scenes[0].link - scene.link[row]) < 1e-9).all(axis=1))
            assert model.panels[k].block[row] == model.panels[0].block[same[0]]
    # logs that share their blocks are all in the discrepancy's sums, as they are in the others
    gram = model.design.field
    assert gram is not None
    for row in range(3):
        own = [p.smooth * p.w_tcp[:, row, None] for p in model.panels]
        whole = sum(F.T @ F for F in own)
        assert np.abs(gram.D[:, row].sum(axis=0) - whole).max() < 1e-9 * np.abs(whole).max()
    twice = with_whole_postures(model_of([seen_from(np.repeat(axis[:25], 2, axis=0))]))
    block = twice.panels[0].block
    assert (block[::2] == block[1::2]).all()
    # what is summed by block is what stands there
    assert twice.design.yy.sum() == pytest.approx(float(np.sum((twice.panels[0].y_tcp * twice.panels[0].w_tcp) ** 2)))
    assert np.isfinite(whole_gap(twice.panels[0])).all()


def sizes_drawn(found, which: str) -> np.ndarray:
    """mm: the errors that the page's picture is coloured by."""
    (cloud,) = [c for c in space_clouds(found.paths, claimed=True) if c.id == f"space-{which}"]
    return np.asarray(cloud.values)


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("named", [False, True])
def test_the_pictures_show_the_errors_that_the_sentence_tells(named: bool) -> None:
    """Frames that are not known are fitted with the claimed zeros; a picture without that shows errors that are not there."""
    asked = seen_from(postures(30, 2), seed=5, same_frame_as="set.csv", same_target_as="set.csv")
    found = diagnose([seen_from(postures(60, 1))], ur10(), withheld=[asked] if named else [])
    assert "joint_offset" in found.claimed
    together = found.summary.to_json()["together"]
    assert together["rms_after_mm"] < 0.1 * together["rms_before_mm"]
    for which in ("before", "after"):
        drawn = sizes_drawn(found, which)
        assert len(drawn) == (30 if named else 60)
        assert np.sqrt(np.mean(drawn**2)) == pytest.approx(together[f"rms_{which}_mm"], rel=1e-3)
        assert drawn.max() == pytest.approx(together[f"max_{which}_mm"], rel=1e-3)
