"""Logs without a tracker: what set-points, encoders, motors and currents alone tell of the drives, axis by axis."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from gap_cells import axis_columns, not_finite, seven, single, ur10

from camrob.cell.load import PointMass
from camrob.dynamics.gravity import pinocchio_torques
from camrob.errors import LogError
from camrob.gap.diagnose import diagnose
from camrob.gap.locate.axes_report import axes_report
from camrob.gap.locate.load_from_drives import load_from_drives
from camrob.gap.observation.scene import make_scene
from camrob.jobs.diagnose import diagnose as diagnose_job
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo
from camrob.measurement.write_log import write_log

STEP = 0.004
T = np.arange(0.0, 24.0, STEP)
QUIET = 2e-7  # rad of noise of an encoder


def path(axes: int) -> np.ndarray:
    """Smooth motions back and forth, each axis at its own pace."""
    k = np.arange(axes)
    swing = (
        0.5 * np.sin((0.31 + 0.07 * k) * 2 * np.pi * T[:, None] / 2.0 + k) * np.sin(0.11 * T[:, None] + 0.4 * k) ** 2
    )
    return np.asarray(np.resize(np.deg2rad([10.0, -80.0, 70.0, -60.0, -80.0, 15.0, 5.0]), axes) + swing)


def log(cell, setpoint, encoder, more=None, every=3, **facts) -> MeasurementLog:
    rng = np.random.default_rng(0)
    encoder = encoder + rng.normal(0.0, QUIET, encoder.shape)
    columns = {"t": T} | axis_columns(cell, encoder) | axis_columns(cell, setpoint, "c") | dict(more or {})
    return MeasurementLog({n: v[::every] for n, v in columns.items()}, LogInfo(**facts), Path("drives.csv"))


def lagged(u: np.ndarray, tau: float) -> np.ndarray:
    """dy/dt = (u - y) / tau, by the trapezoidal rule."""
    y, r = np.empty_like(u), 0.5 * STEP / tau
    y[0] = u[0] - tau * (u[1] - u[0]) / STEP
    for i in range(1, len(u)):
        y[i] = ((1.0 - r) * y[i - 1] + r * (u[i] + u[i - 1])) / (1.0 + r)
    return y


def coulomb(u: np.ndarray, size: float) -> np.ndarray:
    """A drive that stands back by `size` on the side that it comes from."""
    return u - size * np.sign(np.gradient(u))


PLANTED = {
    # what lies between set-point and encoder, what it follows, its coefficient and unit
    "lag": (lambda u: lagged(u, 0.02), "speed", -0.02, "s"),
    "acceleration": (lambda u: u - 4e-4 * np.gradient(np.gradient(u, STEP), STEP), "acceleration", -4e-4, "s2"),
    "friction": (lambda u: coulomb(u, 1e-4), "direction", np.rad2deg(1e-4), "deg"),
    "commutation": (lambda u: u + 5e-5 * np.cos(60.0 * u + 0.3), "position", np.rad2deg(5e-5), "deg"),
    "drift": (lambda u: u + 1e-5 * T, "time", np.rad2deg(0.5e-5 * 24.0), "deg"),
}


@pytest.mark.parametrize("name", PLANTED)
def test_an_axis_tells_what_its_error_follows_and_how_much(name: str) -> None:
    plant, follows, coefficient, unit = PLANTED[name]
    u = path(6)
    encoder = u.copy()
    encoder[:, 1] = plant(u[:, 1])
    report = {a: r.to_json() for a, r in axes_report([make_scene(log(ur10(), u, encoder), ur10())]).items()}
    found = report["A2"]["pattern"]
    assert (found["follows"], found["unit"]) == (follows, unit)
    assert found["coefficient"] == pytest.approx(coefficient, rel=0.1)
    assert found["share"] > 0.8
    error = np.rad2deg(encoder[:, 1] - u[:, 1])[::3]
    assert report["A2"]["rms"] == pytest.approx(np.sqrt(np.mean(error**2)), rel=0.01)
    assert report["A2"]["worst"] == pytest.approx(np.abs(error).max(), rel=0.02)
    assert report["A1"]["pattern"]["follows"] == "constant"  # nothing but noise there
    if name == "commutation":
        assert found["period"] == pytest.approx(np.rad2deg(2 * np.pi / 60.0), rel=0.02)


def test_an_axis_that_rings_at_a_speed_follows_it_to_whichever_side_it_is_off() -> None:
    """A belt sings, an amplifier runs short: what swings to both sides follows nothing by its sign."""
    u = path(6)
    speed = np.abs(np.gradient(u[:, 2], STEP))
    at = np.exp(-(((speed - np.quantile(speed, 0.7)) / (0.15 * speed.max())) ** 2))
    encoder = u.copy()
    encoder[:, 2] += 2e-4 * at * np.sin(2.0 * np.pi * 11.3 * T)
    report = axes_report([make_scene(log(ur10(), u, encoder), ur10())])
    found, quiet = (report[a].to_json()["pattern"] for a in ("A3", "A1"))
    assert (found["follows"], found["coefficient"], found["period"]) == ("speed", None, None)
    assert 0.25 < found["share"] <= 1.0
    assert quiet["follows"] == "constant"


def test_the_error_of_an_axis_is_reported_at_the_tool_too_and_against_noise_and_tolerance() -> None:
    u = path(1)
    encoder = u + 1e-4
    scene = make_scene(log(single(), u, encoder), single())
    lever = float(np.linalg.norm(scene.nominal[0, :2, 3]))  # of the tip, from the one axis, which is z of the foot
    report = axes_report([scene])["A1"].to_json()
    assert report["rms_mm"] == pytest.approx(0.1 * lever, rel=1e-3)
    assert report["within"] == ""
    for facts, word in (
        ({"sigma_axis": 1.1e-4}, "noise"),
        ({"tolerance": 6e-5}, "tolerance"),
        ({"tolerance": 4e-5}, ""),
    ):
        assert axes_report([make_scene(log(single(), u, encoder, **facts), single())])["A1"].to_json()["within"] == word


def test_play_between_two_encoders_is_the_links() -> None:
    """M1: the motor, as A1 counts; the link is pushed along by the flanks of a play of 0.02 degrees."""
    motor, half, link = path(1)[:, 0], 0.5 * np.deg2rad(0.02), []
    at = motor[0]
    for value in motor:
        at = min(max(at, value - half), value + half)
        link.append(at)
    real = np.array(link)[:, None]
    scene = make_scene(log(single(), real, real, {"M1": np.rad2deg(motor)}), single())
    found = axes_report([scene])["A1"].to_json()["motor_to_link"]
    assert found["pattern"]["follows"] == "direction"
    assert found["pattern"]["coefficient"] == pytest.approx(0.01, rel=0.1)  # half the play, to either side
    assert found["worst"] == pytest.approx(0.01, rel=0.05)


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("cell", [single, seven], ids=["one axis", "seven axes"])
def test_a_log_of_drives_alone_is_diagnosed_for_its_stage(cell) -> None:
    u = path(len(cell().axis_names))
    encoder = np.stack([lagged(column, 0.015) for column in u.T], axis=1)
    found = diagnose([log(cell(), u, encoder, every=10)], cell())
    summary = found.summary.to_json()
    assert found.claimed == ("servo_lag",)
    assert summary["effects"][0]["parameters"]["tau_s"]["value"] == pytest.approx(0.015, rel=0.03)
    assert summary["where"]["rungs"]["encoder_to_tcp"] is None
    assert summary["where"]["rungs"]["setpoint_to_encoder"] > 0.0
    assert any("no measured pose" in m for m in summary["where"]["missing"])
    assert summary["latency_s"]["value"] is None
    assert summary["axes_report"]["A1"]["pattern"]["follows"] == "speed"
    assert not_finite(summary) == []


@pytest.mark.parametrize("kind", ["T", "I"])
def test_torques_and_currents_tell_a_load_that_nobody_counted(kind: str) -> None:
    """3 kg more at the plate, by Pinocchio; friction, inertia and a motor's factor that the fit does not know."""
    u = path(6)
    loaded = replace(ur10(), masses=(*ur10().masses, PointMass("more", "A6", 3.0, np.zeros(3))))
    rows = slice(None, None, 10)
    gravity = pinocchio_torques(loaded, ur10().to_q(np.rad2deg(u[rows])))
    v, a = np.gradient(u, STEP, axis=0)[rows], np.gradient(np.gradient(u, STEP, axis=0), STEP, axis=0)[rows]
    friction = np.array([8.0, 9.0, 6.0, 2.0, 2.0, 1.5])
    torque = -gravity + friction * np.sign(v) + 4.0 * v + 1.3 * a  # the drive holds against gravity
    torque = torque + np.random.default_rng(1).normal(0.0, 0.3, torque.shape)
    factor = 1.0 if kind == "T" else 1.0 / np.array([11.0, 12.0, 9.0, 6.0, 5.0, 5.5])
    columns = {n: v[rows] for n, v in ({"t": T} | axis_columns(ur10(), u) | axis_columns(ur10(), u, "c")).items()}
    columns |= {f"{kind}{k + 1}": (torque * factor)[:, k] for k in range(6)}
    load = load_from_drives([make_scene(MeasurementLog(columns, LogInfo(), Path("drives.csv")), ur10())])
    assert load is not None
    report = load.to_json()
    assert report["mass_kg"] == pytest.approx(3.0, abs=max(3.0 * report["std"], 0.1))
    assert report["std"] < 0.3
    assert report["axes"]["A2"]["friction"] == pytest.approx(9.0 if kind == "T" else 9.0 / 12.0, rel=0.1)
    assert "A1" not in report["axes"]  # upright: gravity does not load it


COLUMN = """schema = 1
name = "column"
standing = "measured"
[[joint]]
name = "E1"
role = "arm"
type = "prismatic"
dh = { alpha_deg = 0, a_mm = 0, theta_deg = 0, d_mm = 0 }
"""


def test_a_column_alone_is_diagnosed_by_the_command_and_its_page_is_written(tmp_path: Path) -> None:
    (tmp_path / "cell").mkdir()
    (tmp_path / "cell" / "cell.toml").write_text(COLUMN)
    u = 0.3 * np.sin(0.9 * T) * np.sin(0.21 * T)
    y = lagged(u, 0.03) + np.random.default_rng(0).normal(0.0, QUIET, len(u))
    columns = {"t": T[::8], "E1": 1e3 * y[::8], "cE1": 1e3 * u[::8]}
    write_log(MeasurementLog(columns, LogInfo()), tmp_path / "run.csv")
    diagnose_job(cell=tmp_path / "cell", log=[tmp_path / "run.csv"], out=tmp_path / "out")
    summary = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert summary["effects"][0]["effect"] == "servo_lag"
    assert summary["effects"][0]["probability"] > 0.5
    assert summary["effects"][0]["parameters"]["tau_s"]["value"] == pytest.approx(0.03, rel=0.01)
    assert summary["axes_report"]["E1"]["unit"] == "mm"
    assert "set-point" in (tmp_path / "out" / "diagnosis.html").read_text()


def test_what_can_not_be_told_apart_is_refused_in_one_line() -> None:
    u = path(6)
    drives = log(ur10(), u, u)
    poses = replace(drives.info, poses=True)
    for bad in (
        MeasurementLog({n: v for n, v in drives.columns.items() if n[0] != "c"}, drives.info, drives.path),
        MeasurementLog({n: v for n, v in drives.columns.items() if n[0] != "A"}, drives.info, drives.path),
        MeasurementLog(drives.columns, poses, drives.path),
    ):
        with pytest.raises(
            LogError, match=r"has no measured position; give x, y, z .* or distances d, or a run's set-points"
        ):
            make_scene(bad, ur10())
    tracked = MeasurementLog(
        {**drives.columns, **{n: np.full(len(drives), 500.0) for n in "xyz"}}, drives.info, drives.path
    )
    with pytest.raises(LogError, match="another log has none"):
        diagnose([tracked, drives], ur10())


@pytest.mark.parametrize(("cell", "noise"), [(single, 4e-4), (seven, 2e-3)], ids=["one axis", "seven axes"])
def test_a_lag_that_late_set_points_show_as_well_is_one_of_a_class(cell, noise: float) -> None:
    """Clearly a lag it is one; where the encoder is too coarse to tell, a class."""
    u = path(len(cell().axis_names))
    coarse = np.random.default_rng(1).normal(0.0, noise, u.shape)
    for encoder, alike in ((lagged(u, 0.03), False), (lagged(u, 0.01) + coarse, True)):
        told = diagnose([log(cell(), u, encoder, every=5)], cell()).summary.to_json()["effects"]
        found = next(e for e in told if e["effect"] == "servo_lag")
        assert ("setpoint_delay" in found["class"]) == alike
        assert (found["probability"] < 0.8) == alike
        assert found["class_probability"] > 0.9
