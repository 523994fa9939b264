"""What one moving part explains of a gap, on an arm multiplied out by hand."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from stranger_arms import UR, Faults, columns_of, driven, scattered, true_poses

from camrob.cell.read_cell import read_cell
from camrob.gap.evidence.design import Panel, build_units, make_panel
from camrob.gap.locate.single_shape import single_shape
from camrob.gap.observation.noise import noise_of
from camrob.gap.observation.scene import make_scene
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo

NOISE = 1e-5 * np.sqrt(3.0)


def panel(folder: Path, link: Callable, *, poses: bool, rest: float = 2e-5, name: str = "log.csv") -> Panel:
    """A log whose links are at link(t, axes), the encoders at the axes, beside a smooth rest of twice the noise."""
    (folder / "cell.toml").write_text(UR.cell)
    t, axis = (np.arange(80) * 12.0, scattered(UR, 80, 4)) if poses else driven(UR, 30.0, 4)
    T = true_poses(UR, link(t, axis), Faults(rest=rest), 6)
    rows = np.arange(0, len(t), 1 if poses else 10)
    columns = columns_of(UR, t[rows], axis[rows], T[rows], turned=False)
    info = LogInfo(sigma_position=1e-5, poses=poses)
    scene = make_scene(MeasurementLog(columns, info, Path(name)), read_cell(folder))
    units = build_units([scene], [], {})
    return make_panel(scene, 0, units, [], {}, noise_of(scene), np.ones(len(scene), bool), 10, 0)


def beyond(k: int, value: Callable) -> Callable:
    def link(t, axis):
        out = axis.copy()
        out[:, k] += value(t, axis)
        return out

    return link


@pytest.mark.parametrize("poses", [True, False])
@pytest.mark.parametrize(
    ("k", "value", "follows"),
    [
        (1, lambda t, q: 8e-3 * np.maximum(q[:, 1] + 1.6, 0.0) ** 2, {"A2"}),
        (2, lambda t, q: 6e-4 * np.tanh((t - t.mean()) / (0.2 * np.ptp(t))), {"time"}),
        (3, lambda t, q: 8e-4 * np.sin(2.0 * q[:, 4]), {"A5"}),
    ],
)
def test_the_part_that_moves_and_what_it_follows_are_found(
    poses: bool, k: int, value: Callable, follows: set[str], tmp_path: Path
) -> None:
    found = single_shape([panel(tmp_path, beyond(k, value), poses=poses)], NOISE)
    assert found is not None
    assert found.moves == f"A{k + 1}"
    assert found.follows in follows
    assert found.share > 0.8


def test_what_an_axis_does_in_its_gear_follows_its_speed(tmp_path: Path) -> None:
    late = beyond(0, lambda t, q: -1.5e-3 * np.gradient(q[:, 0], t))
    found = single_shape([panel(tmp_path, late, poses=False)], NOISE)
    assert found is not None
    assert (found.moves, found.follows) == ("A1", "speed of A1")


def test_noise_alone_has_no_part(tmp_path: Path) -> None:
    found = single_shape([panel(tmp_path, lambda t, q: q, poses=False, rest=0.0)], NOISE)
    assert found is None or found.share < 0.5


def test_of_an_axis_alone_what_it_follows_is_told(tmp_path: Path) -> None:
    late = beyond(0, lambda t, q: -1.5e-3 * np.gradient(q[:, 0], t))
    logs = [panel(tmp_path, late, poses=False)]
    found, best = single_shape(logs, NOISE, moves="A4"), single_shape(logs, NOISE)
    assert found is not None and best is not None
    assert found.moves == "A4"
    assert found.share < best.share
    again = single_shape(logs, NOISE, moves="A1")
    assert again is not None
    assert (again.moves, again.follows) == (best.moves, best.follows)
    assert again.share == pytest.approx(best.share)
