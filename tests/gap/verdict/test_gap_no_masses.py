"""An arm whose masses nobody knows gives way under gravity all the same: no name of another kind stands for it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from stranger_arms import UR, Faults, placed, pulled, scattered
from stranger_logs import set_of
from test_gap_strangers import diagnosed

from camrob.cell.read_cell import read_cell
from camrob.gap.effects.common import under_even_kilogram, under_flange_kilogram
from camrob.gap.observation.scene import Scene, make_scene
from camrob.measurement.read_log import read_log


def scene_of(folder: Path) -> tuple[Scene, np.ndarray]:
    """A bare arm's set, and its postures (N, 6), rad."""
    case = set_of(UR, count=12, known=True)
    (folder / "cell.toml").write_text(UR.cell)
    for name, csv, toml in case.logs:
        (folder / name).write_text(csv)
        (folder / name).with_suffix(".toml").write_text(toml)
    log = read_log(folder / "set.csv")
    return make_scene(log, read_cell(folder)), scattered(UR, 12, 1)


def bent(scene: Scene, columns) -> np.ndarray:
    """(N, 6) rad that the columns turn the axes by, read off how far they move the TCP."""
    unit = [scene.place(f"A{k}.zero") for k in range(1, 7)]
    return np.stack(
        [np.sum(c.tcp * u, axis=1) / np.sum(u * u, axis=1) for c, u in zip(columns, unit, strict=True)], axis=1
    )


def test_a_kilogram_on_the_plate_pulls_as_the_slope_of_its_height(tmp_path: Path) -> None:
    scene, axis = scene_of(tmp_path)
    at, h = lambda q: placed(UR, q)[:, 2, 3], 1e-6
    slope = np.stack([(at(axis + h * e) - at(axis - h * e)) / (2 * h) for e in np.eye(6)], axis=1)
    assert bent(scene, under_flange_kilogram(scene)) == pytest.approx(-9.81 * slope, abs=0.01)


def test_a_kilogram_spread_over_the_links_weighs_by_their_lengths(tmp_path: Path) -> None:
    """A link goes from its axis, along its own length a, to where the next row's d ends; the first row's d stands still."""
    scene, axis = scene_of(tmp_path)
    ds = [d for _, _, d in UR.rows[1:]] + [0.0]
    long = [float(np.hypot(a, d)) for (_, a, _), d in zip(UR.rows, ds, strict=True)]
    rods = [(k, m / sum(long), (-UR.rows[k][1] / 2, 0.0, ds[k] / 2)) for k, m in enumerate(long)]
    expected = pulled(replace(UR, masses=tuple(rods)), axis)
    assert bent(scene, under_even_kilogram(scene)) == pytest.approx(expected, abs=0.01)
    assert np.abs(expected[:, 1]).max() > 1.0


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("give", [{1: 2.0e-5, 2: 2.5e-5}, {2: 4e-5}])
def test_what_gives_way_on_an_arm_of_unknown_masses_follows_the_load(give, tmp_path: Path) -> None:
    """Geometry or an axis's zero was 86 to 96 % sure."""
    assert diagnosed(set_of(UR, count=60, faults=Faults(give=give, rest=5e-5)), tmp_path) == 0
    found = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert max((e["probability"] for e in found["effects"]), default=0.0) < 0.8
    assert found["unknown"]["probability"] > 0.95
    assert found["unknown"]["where"]["regimes"][:1] == ["load"]
    assert {f"A{k + 1}" for k in give} & set(found["unknown"]["where"]["axes"])
