"""An arm calibrated, and laid out for its diagnosis, by less than places: heights, faces, a wire from somewhere."""

from __future__ import annotations

import numpy as np
import pytest

from camrob.calibration.calibrate import fit_cell
from camrob.calibration.measurements import measurements_of
from camrob.cell.read_cell import read_cell
from camrob.gap.observation.scene import make_scene
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo, MeasuredFrame

ROWS = [(-90, 40, 0, 330), (0, 345, -90, 0), (-90, 40, 0, 0), (90, 0, 0, 340), (-90, 0, 0, 0), (0, 0, 0, 200)]
PLANTED = {"A2.zero": 0.08, "A3.zero": -0.05, "A5.zero": 0.1}  # degrees
RNG = np.random.default_rng(11)
POSES = RNG.uniform(-1.0, 1.0, (80, 6)) * [80, 45, 45, 120, 90, 150] + [0, 0, 0, 0, 20, 0]
NORMALS = np.eye(3)[RNG.integers(0, 3, len(POSES))]
ANCHOR = np.array([1200.0, -900.0, 1500.0])  # mm


def tip(values) -> np.ndarray:
    """(N, 3) mm, by a product of matrices that shares nothing with the project's chain."""
    out = np.tile(np.eye(4), (len(values), 1, 1))
    for (alpha, a, theta, d), angle in zip(ROWS, values.T, strict=True):
        c, s = np.cos(np.radians(angle + theta)), np.sin(np.radians(angle + theta))
        ca, sa = np.cos(np.radians(alpha)), np.sin(np.radians(alpha))
        one, none = np.ones_like(c), np.zeros_like(c)
        rows = [
            [c, -s * ca, s * sa, a * c],
            [s, c * ca, -c * sa, a * s],
            [none, sa * one, ca * one, d * one],
            [none, none, none, one],
        ]
        out = out @ np.moveaxis(np.array(rows), 2, 0)
    return out[:, :3, 3]


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    rows = ",\n".join(str(list(r)) for r in ROWS)
    folder = tmp_path_factory.mktemp("arm")
    (folder / "cell.toml").write_text(
        f'schema = 1\nname = "arm"\nstanding = "datasheet"\n[arm]\ndh = [\n{rows}\n]\n[[mass]]\nname = "fore"\nafter = "A4"\n'
        "mass_kg = 8\ncenter_mm = [0, 60, 0]\n"
    )
    return read_cell(folder)


def measured(what: str, sigma: float = 0.01) -> MeasurementLog:
    rng = np.random.default_rng(5)
    real = tip(POSES + [PLANTED.get(f"A{k}.zero", 0.0) for k in range(1, 7)])
    seen = real + sigma * rng.standard_normal(real.shape)
    facts: dict = {"poses": True, "sigma_position": 1e-3 * sigma}
    if what == "height":
        columns = {"z": seen[:, 2]}
    elif what == "height, somewhere":
        columns, facts = {"z": seen @ [0.1, -0.2, 0.97468] + 77.0}, facts | {"measured_frame": MeasuredFrame.UNKNOWN}
    elif what == "faces":
        slid = 5.0 * rng.standard_normal(real.shape)
        seen = seen + slid - NORMALS * np.sum(slid * NORMALS, axis=1, keepdims=True)
        columns = dict(zip(("x", "y", "z", "nx", "ny", "nz"), (*seen.T, *NORMALS.T), strict=True))
    else:
        columns = {"d": np.linalg.norm(seen - ANCHOR, axis=1)}
        facts |= {"distance_from_unknown": True, "measured_frame": MeasuredFrame.UNKNOWN}
    axes = {f"A{k}": v for k, v in enumerate(POSES.T, 1)}
    return MeasurementLog({"t": np.arange(len(POSES), dtype=float), **columns, **axes}, LogInfo(**facts))


@pytest.mark.parametrize("what", ["height", "height, somewhere", "faces", "wire"])
def test_zeros_come_out_of_less_than_places(arm, what) -> None:
    found = fit_cell(arm, measurements_of(measured(what), arm), names=tuple(PLANTED), share=0.0).calibration
    for name, degrees in PLANTED.items():
        parameter = found.parameters[name]
        assert abs(np.degrees(parameter.value) - degrees) < 4.0 * np.degrees(parameter.std), name
        assert np.degrees(parameter.std) < 0.01


def test_a_height_is_a_face_whose_normal_is_up(arm) -> None:
    height = measured("height")
    up = dict(zip(("nx", "ny", "nz"), np.tile([[0.0], [0.0], [1.0]], len(POSES)), strict=True))
    beside = {"x": np.full(len(POSES), 17.0), "y": -3.0 * np.arange(len(POSES))}
    face = MeasurementLog({**height.columns, **beside, **up}, height.info)
    one, other = make_scene(height, arm), make_scene(face, arm)
    np.testing.assert_allclose(other.tcp_gap, one.tcp_gap, atol=1e-12)
    for name, column in one.places.items():
        np.testing.assert_allclose(other.places[name], column, atol=1e-12, err_msg=name)
    assert one.sees == (False, False, True)


def test_a_wire_s_end_moves_what_it_tells_as_its_frame_does(arm) -> None:
    scene = make_scene(measured("wire"), arm)
    assert scene.frames.fitted_left
    assert float(np.sqrt(np.mean(np.sum(scene.tcp_gap[:, :3] ** 2, axis=1)))) < 1e-3
    np.testing.assert_allclose(scene.told(scene.tcp_gap), scene.tcp_gap, atol=1e-6)
