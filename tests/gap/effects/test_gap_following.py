"""How long drives trail their set-points, and what of that is delay, against drives integrated exactly by other code: point to
point on ramps of a fifth degree, set-points straight between ticks of 0.25 ms, a lag of the first order, dry friction that holds
an axis back, an encoder with steps and noise.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from gap_cells import axis_columns, ur10

from camrob.gap.diagnose import diagnose
from camrob.gap.effects.following import following
from camrob.gap.observation.scene import make_scene
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo

TICK = 2.5e-4
NOISE, DIGIT = np.deg2rad(4e-4), np.deg2rad(1e-5)


def way(seed: int, seconds: float = 20.0) -> np.ndarray:
    """(N, 6) rad: six axes from place to place, at rest between."""
    rng = np.random.default_rng(seed)
    parts, at, length = [], np.deg2rad([0.0, -80.0, 70.0, 0.0, 60.0, 0.0]), 0
    while length * TICK < seconds:
        to = np.deg2rad(rng.uniform([-60, -120, 40, -90, 20, -120], [60, -50, 110, 90, 100, 120]))
        count = round(np.rad2deg(np.abs(to - at).max()) / 45.0 / TICK) + 400
        s = np.linspace(0.0, 1.0, count)
        parts += [at + (to - at) * (s**3 * (10.0 - 15.0 * s + 6.0 * s * s))[:, None], np.repeat(to[None], 900, 0)]
        at, length = to, length + count + 900
    return np.concatenate(parts)


def driven(u: np.ndarray, tau: np.ndarray, delay: float, cycle: float = TICK) -> np.ndarray:
    """(N, 6): dy/dt = (u(t - delay) - y) / tau exactly, u straight between the ticks of the drive's cycle."""
    t = TICK * np.arange(len(u))
    ticks = np.arange(0.0, t[-1] + cycle, cycle)
    late = np.stack([np.interp(t - delay, ticks, np.interp(ticks, t, v)) for v in u.T], axis=1)
    y, share = np.empty_like(u), np.exp(-TICK / tau)
    y[0] = u[0]
    for i in range(1, len(u)):
        slope = (late[i] - late[i - 1]) / TICK
        y[i] = late[i] - tau * slope + (y[i - 1] - late[i - 1] + tau * slope) * share
    return y


def scene(u, y, rate: float, friction: float = 0.0):
    return make_scene(log(u, y, rate, friction), ur10())


def log(u, y, rate: float, friction: float = 0.0) -> MeasurementLog:
    every = round(1.0 / rate / TICK)
    held = y - friction * np.sign(np.gradient(y, axis=0)) * (np.abs(np.gradient(y, axis=0)) > 1e-9)
    rng = np.random.default_rng(2)
    seen = np.round((held + rng.normal(0.0, NOISE, y.shape)) / DIGIT) * DIGIT
    columns = {"t": TICK * np.arange(len(u))} | axis_columns(ur10(), seen) | axis_columns(ur10(), u, "c")
    info = LogInfo(sigma_axis=float(np.deg2rad(5e-4)))
    return MeasurementLog({n: v[::every] for n, v in columns.items()}, info, Path("drives.csv"))


@pytest.mark.slow(after=10)
@pytest.mark.parametrize("rate", [100.0, 250.0, 500.0, 1000.0])
@pytest.mark.parametrize("tau", [0.003, 0.006, 0.0125, 0.03, 0.06])
def test_a_lag_is_as_long_as_it_is_at_any_rate_of_the_log(tau: float, rate: float) -> None:
    """0.1 ms or 1 %, and none of it is called a delay: what a stranger's regression on the speed says."""
    u = way(3)
    found = following([scene(u, driven(u, np.full(6, tau), 0.0), rate)])
    assert set(found.delay.values()) == {0.0}
    assert found.sum == pytest.approx(tau, rel=0.01, abs=1e-4)


@pytest.mark.slow(after=6)
@pytest.mark.parametrize(("cycle", "friction"), [(TICK, 0.0), (0.004, 0.0), (TICK, np.deg2rad(0.004))])
@pytest.mark.parametrize(("tau", "delay"), [(0.006, 0.012), (0.03, 0.012), (0.02, 0.008), (0.006, 0.03)])
def test_a_delay_of_all_is_told_from_a_lag_where_axes_speed_up(
    tau: float, delay: float, cycle: float, friction: float
) -> None:
    """Where friction or the interpolation between a drive's cycles is at work too, the sum still holds."""
    u = way(4)
    found = following([scene(u, driven(u, np.full(6, tau), delay, cycle), 250.0, friction)])
    assert found.sum == pytest.approx(tau + delay, rel=0.02)
    if not friction:
        assert found.common_delay == pytest.approx(delay, abs=0.0015)
        assert found.common_lag == pytest.approx(tau, abs=0.0015)


def values(told, name: str) -> dict[str, float]:
    found = next(e for e in told.summary.effects if e.effect == name and e.claimed)
    return {n: v.value for n, v in found.parameters.items()}


@pytest.mark.parametrize("delay", [0.0, 0.012])
def test_one_slow_drive_among_quick_ones_is_a_lag_of_its_own_and_a_delay_is_everybodys(delay: float) -> None:
    """A5 at 30 ms among 6 ms: no lag is below 0, and no delay of A5 is made up."""
    u, tau = way(5, 30.0), np.array([0.006, 0.006, 0.006, 0.006, 0.03, 0.006])
    told = diagnose([log(u, driven(u, tau, delay), 250.0)], ur10())
    lag = values(told, "servo_lag")
    assert lag["tau_s"] == pytest.approx(0.006, abs=0.0006)
    assert lag["tau_s"] + lag["A5_beyond_s"] == pytest.approx(0.03, abs=0.001)
    claimed = {e.effect for e in told.summary.effects if e.claimed}
    assert claimed == ({"servo_lag", "setpoint_delay"} if delay else {"servo_lag"})
    if delay:
        late = values(told, "setpoint_delay")
        assert late["delay_s"] == pytest.approx(delay, abs=0.0008)
        assert not any(n.startswith("A") for n in late)


def test_a_drive_of_six_milliseconds_is_not_said_to_lag_by_a_cycle_more() -> None:
    """The values were divided by a cycle longer than the lag, which ran away: 18 ms for 6."""
    u = way(6)
    told = diagnose([log(u, driven(u, np.full(6, 0.006), 0.0), 250.0)], ur10())
    assert values(told, "servo_lag")["tau_s"] == pytest.approx(0.006, abs=1e-4)


def test_all_set_points_late_and_followed_at_once_are_a_delay_and_no_lag() -> None:
    u = way(7)
    told = diagnose([log(u, driven(u, np.full(6, 1e-4), 0.03), 250.0)], ur10())
    assert values(told, "setpoint_delay")["delay_s"] == pytest.approx(0.03, rel=0.03)
    assert not any(e.claimed and e.effect == "servo_lag" and e.probability > 0.8 for e in told.summary.effects)
