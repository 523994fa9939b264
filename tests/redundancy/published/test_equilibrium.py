"""Weights along a path, and where its posture stands off the published equilibrium: worked out anew from the postures."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from follower_twins import CELL, bilinear

from camrob.jobs.files.inputs import read_inputs
from camrob.redundancy.published.equilibrium import equilibrium, weights_along
from camrob.redundancy.published.virtual_joint import PathFollower, resolve_vjm
from camrob.redundancy.published.weighting import engine_weighting
from camrob.redundancy.solution import Solution

ROOT = Path(__file__).resolve().parents[3]


@lru_cache(maxsize=1)
def engraved():
    inputs = read_inputs(ROOT / "toolpaths" / "engraving" / "engraving.cls", CELL, None)
    return inputs.cell, inputs.path, resolve_vjm(inputs.cell, inputs.path)


def test_the_weights_are_the_compiled_engines() -> None:
    cell, _path, solution = engraved()
    q = np.asarray(solution.q)
    for table in ("even", "corners"):
        engine = replace(cell.resolve.joint_engine, table=table)
        surface = engine_weighting(replace(cell, resolve_section=replace(cell.resolve, joint_engine=engine))).joint
        expected = np.stack([bilinear(surface, posture) for posture in q[::40]])
        np.testing.assert_allclose(weights_along(surface, q[::40]), expected, atol=1e-14)


def test_a_path_that_is_never_bounded_stands_at_the_equilibrium_but_where_the_arm_goes_alone() -> None:
    cell, path, solution = engraved()
    found = equilibrium(cell, path, solution)
    assert (
        (path.cutting & path.along_axis).sum() > 40 and not found.bounded[path.cutting].any() and not found.acting.any()
    )


def test_a_posture_moved_off_it_is_reported() -> None:
    cell, path, solution = engraved()
    q = np.array(solution.q)
    moved = np.array([200, 500])
    q[moved, cell.index("E1")] += 0.01
    off = Solution("vjm", q, solution.inv_kf, cell.digest, path.digest, solution.revisions)
    found = equilibrium(cell, path, off)
    np.testing.assert_array_equal(np.flatnonzero(found.bounded & path.cutting), moved)


def test_bounds_on_self_motion_leave_the_posture_behind() -> None:
    """The same piece followed with next to no self-motion: nearly all of it is reported to lag."""
    cell, path, _solution = engraved()
    follower = PathFollower(cell, path)
    follower._limits = lambda *_args: np.full((len(_args[0]) - 1, len(cell)), 1e-9)  # type: ignore[method-assign]
    attempt = follower.follow(follower.home(), cell.q_reference, 0, 150)
    part = path.part(slice(0, 150))
    lagging = Solution("vjm", attempt.q, attempt.inv_kf, cell.digest, part.digest)
    assert equilibrium(cell, part, lagging).bounded[5:].mean() > 0.9
