"""The proved bound: enclosures hold what they say, against exact fractions and random postures; planted cases."""

from __future__ import annotations

import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from camrob.cell.read_cell import read_cell
from camrob.errors import CellError
from camrob.kinematics.arm import reach
from camrob.redundancy.free_frames import rotation_minimising
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planning.certificate import certify
from camrob.redundancy.planning.freedoms import conditioning, plan_space, plan_work, pose_in_foot
from camrob.se3 import pose
from camrob.toolpath.region import Move

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from proving.branch_and_bound import Bundles, bound_of_box, refute
from proving.bundles import bundled, pieces_of
from proving.proof import prove_path

from camrob.redundancy.proving.affine import cosine_sine, highest, inverse, lowest, minus, plus, root, times
from camrob.redundancy.proving.arm_shape import arm_shape

ROOT = Path(__file__).resolve().parents[3]
pytestmark = pytest.mark.slow  # its kernels compile for minutes, and no program rests on them yet
CELL = read_cell(ROOT / "cells" / "kr15_track_table")
UP = np.array([0.0, 0.0, 1.0])


def value(form, symbols, share):
    """What a form stands for at given symbols, exactly; share: of what is left, -1 to 1."""
    return (
        Fraction(form[0])
        + sum(Fraction(a) * s for a, s in zip(form[1:6], symbols, strict=True))
        + Fraction(form[6]) * share
    )


def holds(form, symbols, exact):
    """Whether a form holds a number for given symbols."""
    return abs(exact - value(form, symbols, 0)) <= Fraction(form[6])


def test_sums_and_products_of_forms_hold_those_of_what_they_stand_for_in_exact_fractions():
    rng = np.random.default_rng(1)
    for _ in range(300):
        scale = 10.0 ** rng.uniform(-6, 3, 2)
        x, y = (tuple(float(v) for v in rng.normal(size=7) * s) for s in scale)
        x, y = (*x[:6], abs(x[6])), (*y[:6], abs(y[6]))
        symbols = [Fraction(float(v)) for v in rng.choice([-1.0, 1.0, rng.uniform(-1, 1)], 5)]
        a, b = (value(f, symbols, Fraction(float(rng.choice([-1.0, 1.0])))) for f in (x, y))
        assert holds(plus(x, y), symbols, a + b)
        assert holds(minus(x, y), symbols, a - b)
        assert holds(times(x, y), symbols, a * b)
        assert lowest(x) <= a <= highest(x)


def test_bent_functions_of_forms_hold_theirs_in_fifty_digits():
    import mpmath

    rng = np.random.default_rng(2)
    with mpmath.workdps(50):
        for _ in range(300):
            x = (
                float(rng.uniform(1.0, 3.0)),
                *(float(v) for v in rng.uniform(-0.15, 0.15, 5)),
                float(rng.uniform(0.0, 0.1)),
            )
            symbols = [Fraction(float(v)) for v in rng.choice([-1.0, 1.0, rng.uniform(-1, 1)], 5)]
            a = value(x, symbols, Fraction(float(rng.uniform(-1, 1))))
            number = mpmath.mpf(a.numerator) / a.denominator
            cosine, sine = cosine_sine(x)
            for form, exact in (
                (inverse(x, lowest(x), highest(x)), 1 / number),
                (root(x, lowest(x), highest(x)), mpmath.sqrt(number)),
                (cosine, mpmath.cos(number)),
                (sine, mpmath.sin(number)),
            ):
                near = value(form, symbols, 0)
                assert abs(exact - mpmath.mpf(near.numerator) / near.denominator) <= form[6]


def postures(space, base_T_tip, u):
    """1/k_F (4,) of the ways to a pose, the wrist's two flips apart; 0 where none keeps the limits."""
    work, best = plan_work(), np.zeros(4)
    pose_in_foot(space, base_T_tip, u, work)
    reach(space.arm, space.screws, work.Rt, work.pt, space.center, work.Q, work.why)
    for b in range(8):
        q = work.Q[b].copy()
        if work.why[b] == 0 and np.all(q >= space.lower) and np.all(q <= space.upper):
            best[b // 2] = max(best[b // 2], conditioning(space, q, work))
    return best


def bundle(T, ways=0.0, rng=None):
    """A bundle about a pose (4, 4), its symbols worth `ways` m and rad."""
    out = np.zeros((9, 3))
    out[:3], out[3] = T[:3, :3].T, T[:3, 3]
    if rng is not None:
        for k in (4, 6):
            d = rng.normal(size=3) * ways
            out[k] = d - (d @ out[2]) * out[2]  # an axis changes across itself
            out[k + 1] = rng.normal(size=3) * ways
    return out


def frame(position, axis):
    z = np.asarray(axis) / np.linalg.norm(axis)
    x = np.cross([0.3, 0.9, 0.1], z)
    x /= np.linalg.norm(x)
    return pose(np.stack([x, np.cross(z, x), z], axis=1), np.asarray(position, float))


@pytest.mark.parametrize("name", ["kr15_track_table", "kr500_afp", "rx160_tracker", "ta1400_weld"])
def test_no_posture_of_a_box_and_a_bundle_beats_its_bound_and_a_point_is_met(name):
    cell = read_cell(ROOT / "cells" / name)
    try:
        shape = arm_shape(cell, UP)
    except CellError as error:
        assert "does not cover" in str(error)
        assert name != "kr15_track_table"
        return
    space, rng, met = plan_space(cell), np.random.default_rng(3), 0
    F = len(shape.lower)
    for trial in range(600):
        center = [rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3), rng.uniform(0.0, 0.4)]
        if F == 1:  # nothing carries the arm: the pose has to be in its reach
            center = rng.uniform([0.4, -1.0, 0.2], [2.2, 1.0, 1.8])
        axis = rng.normal(size=3) * 0.4 + UP * rng.choice([-1.0, 1.0])
        T = frame(center, axis)
        half, ways = (0.0, 0.0) if trial % 3 == 0 else 10.0 ** rng.uniform(-4, -0.9, 2)
        box = np.zeros((2, 3))
        box[0, :F], box[1, :F] = rng.uniform(shape.lower, shape.upper), half
        poses = bundle(T, ways if ways else 0.0, rng if ways else None)
        best = bound_of_box(shape, poses, box)
        for _ in range(1 if half == 0.0 else 8):
            free = box[0, :F] + half * rng.uniform(-1, 1, F)
            u = free.copy()
            u[-1] = -free[-1] - (shape.mix * free[shape.turning] if shape.turning >= 0 else 0.0)
            a, b = rng.uniform(-1, 1, 2)
            z = T[:3, 2] + a * poses[4] + b * poses[6]
            off = np.linalg.norm(z / np.linalg.norm(z) - z)  # an axis has length one: what that is off is in the bundle
            turned = turned_to(T, z / np.linalg.norm(z), T[:3, 3] + a * poses[5] + b * poses[7])
            wide = poses.copy()
            wide[8, 0] = off + 1e-12
            bound = best if off < 1e-15 else bound_of_box(shape, wide, box)
            reached = np.max(postures(space, turned, u))
            assert reached <= np.max(bound)
            if half == 0.0 and reached > 0.0:
                met += 1
                assert np.max(bound) - reached < 1e-6 or np.sum(bound > 0) > np.sum(postures(space, turned, u) > 0)
    assert met > 20


def turned_to(T, z, position):
    """The pose (4, 4) with axis z, x and y carried along by the least rotation."""
    v, c = np.cross(T[:3, 2], z), T[:3, 2] @ z
    K = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return pose((np.eye(3) + K + K @ K / (1.0 + c)) @ T[:3, :3], position)


def path_of(tips, axes):
    n = len(tips)
    R = rotation_minimising(np.ascontiguousarray(axes), np.array([0.3, 0.5, 0.8]))
    return ToolPathInBase(
        pose(R, np.asarray(tips, float)),
        np.full(n, int(Move.CUT), np.int8),
        np.full(n, 0.02),
        np.arange(1, n + 1),
        np.zeros(n, np.int32),
        np.arange(n),
        np.zeros(n, bool),
    )


def test_every_pose_between_a_path_s_points_lies_in_its_bundles_but_for_the_table_s_turn():
    rng, space = np.random.default_rng(4), plan_space(CELL)
    tips = np.cumsum(rng.normal(size=(8, 3)) * 0.01, axis=0) + np.array([0.2, -0.1, 0.1])
    tips[-2:, :2] = [[0.003, 0.002], [-0.004, 0.001]]  # close by the table's axis
    tips[-3, :2] = [0.004, 0.006]
    axes = np.cumsum(rng.normal(size=(8, 3)) * 0.05, axis=0) + UP
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    path = path_of(tips, axes)
    pieces = pieces_of(space, path)
    bundles, own = bundled(pieces, np.ones(len(pieces.point)))
    assert np.allclose(space.first[:2, :2], np.eye(2))  # azimuths in `base` are those about the table's axis
    inside = [own.tolist()]
    parent = {int(c): k for k, parts in enumerate(bundles.parts) for c in parts if c >= 0}
    while any(k in parent for k in inside[-1]):
        inside.append([parent.get(k, k) for k in inside[-1]])
    for m, point in enumerate(pieces.point):
        n = np.sum(pieces.point == point)
        for share in pieces.share[m] + np.array([-0.5, -0.2, 0.1, 0.5]) / n:
            p = tips[point - 1] + share * (tips[point] - tips[point - 1])
            a = np.arccos(np.clip(axes[point - 1] @ axes[point], -1.0, 1.0))
            z = (np.sin((1 - share) * a) * axes[point - 1] + np.sin(share * a) * axes[point]) / np.sin(a)
            middle = tips[point - 1] + pieces.share[m] * (tips[point] - tips[point - 1])
            turns = [np.arctan2(v[1], v[0]) for v in (p, middle)]  # near the axis a piece is turned as its middle is
            assert all(any(lies_in(bundles.poses[level[m]], p, z, turn) for turn in turns) for level in inside)


def lies_in(poses, p, z, azimuth):
    """Whether a pose, turned back about the table's axis (z of `base`) by an azimuth, lies in a bundle."""
    c, s = np.cos(azimuth), np.sin(azimuth)
    back = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    dp, dz = back @ p - poses[3], back @ z - poses[2]
    ways = np.array([[*poses[5], *poses[4]], [*poses[7], *poses[6]]])
    share = np.clip(np.linalg.lstsq(ways.T, np.concatenate([dp, dz]), rcond=None)[0], -1.0, 1.0)
    left = np.concatenate([dp, dz]) - share @ ways
    return np.linalg.norm(left) <= poses[8, 0] + poses[8, 1] + 1e-9  # the share that suits both is not looked for


def test_a_value_that_a_posture_has_is_never_refuted_and_one_above_the_best_is():
    space, shape = plan_space(CELL), arm_shape(CELL, UP)
    T = frame([0.1, 0.05, 0.1], [0.0, 0.0, 1.0])
    best = float(certify(space, T[None]).inv_kf[0])
    weight = np.array([0.3, 1.2, 0.6])
    for target, whole in ((0.9 * best, False), (1.3 * best, True)):
        tree = Bundles(bundle(T)[None], np.array([[-1, -1]]), np.zeros(1), np.array([target]))
        shown, _used = refute(shape, tree, weight, 1e-2, 2_000_000 if whole else 20_000)
        assert shown[0] >= best
        assert (shown[0] == target) == whole


def test_a_path_is_proved_as_a_whole_and_says_how_much_it_could_not_prove():
    space = plan_space(CELL)
    tips = np.array([[0.10, 0.0, 0.1], [0.11, 0.0, 0.1], [0.12, 0.002, 0.1]])
    path = path_of(tips, np.tile(UP, (3, 1)))
    searched = np.asarray(certify(space, path.base_T_tip.copy()).inv_kf)
    whole = prove_path(CELL, path, searched, epsilon=0.3)
    assert whole.share == 1.0
    assert np.isnan(whole.bound[0])
    assert np.all(whole.bound[1:] <= 1.3001 * searched.max())
    short = prove_path(CELL, path, searched, epsilon=0.3, boxes=100)
    assert short.share == 0.0
    assert np.all(short.bound[1:] >= whole.bound[1:])
