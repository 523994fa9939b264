"""The benchmark's smooth field over posture: as large as told, a function of posture alone, nothing else of a case changed."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from gap_cases import motion

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from gap import maker as gap_maker
from gap.field import FASTEST, draw_field
from gap.generator import World


def displaced(seed: int, command, size: float = 1e-4, first=None):
    """(M, 3) m by which the field of a seed moves the tool at some axis values."""
    t = 0.004 * np.arange(len(command))
    world = World(t, command)
    draw_field(seed, World(t, command if first is None else first), size)(world)
    return world.after


def test_a_field_is_as_large_as_told_and_follows_posture_alone() -> None:
    _, command = motion()
    moved = displaced(3, command)
    assert np.sqrt(np.mean(np.sum(moved**2, axis=1))) == pytest.approx(1e-4, rel=1e-9)
    back = displaced(3, command[::-1], first=command)
    assert np.allclose(back[::-1], moved, atol=1e-15)
    table = command.copy()
    table[:, 7] += 1.0
    assert np.allclose(displaced(3, table, first=command), moved, atol=1e-15)
    assert np.abs(displaced(4, command) - moved).max() > 1e-5


def test_a_field_is_smooth() -> None:
    _, command = motion()
    way = np.linalg.norm(np.diff(command[:, :7] / np.r_[np.ones(6), 0.5], axis=0), axis=1)
    step = np.linalg.norm(np.diff(displaced(3, command), axis=0), axis=1)
    # no cosine turns faster than its two rates together, and fourteen share the size
    assert np.all(step <= np.sqrt(2.0) * FASTEST * way * 1e-4 * 14)


@pytest.mark.slow
def test_a_case_with_a_field_is_the_same_case_beside_it(tmp_path: Path) -> None:
    (tmp_path / "plain").mkdir()
    plain = gap_maker.write_case(tmp_path / "plain", 31, "two")
    label = gap_maker.write_case(tmp_path, 31, "two", field=5.0)
    assert label == {**plain, "field": 5.0}
    for name, size in (("31", 5.0), ("31_withheld", None)):
        tables = [np.genfromtxt(d / f"{name}.csv", delimiter=",", names=True) for d in (tmp_path / "plain", tmp_path)]
        one, other = (np.stack([t[n] for n in "xyz"], axis=1) for t in tables)
        assert all(np.array_equal(tables[0][n], tables[1][n]) for n in tables[0].dtype.names if n not in "xyz")
        rms = np.sqrt(np.mean(np.sum((other - one) ** 2, axis=1)))
        assert rms > label["noise_mm"]
        if size is not None:
            assert rms == pytest.approx(size * label["noise_mm"], rel=0.05)
