"""What is wrong with the reading: clocks, scales, stands, frames, robots that had not yet come to rest."""

from __future__ import annotations

import numpy as np

from .robots import nudge
from .stages import Cause, Truth

__all__ = ["creeping_stand", "late_clock", "not_at_rest", "wrong_scale"]

BODY = "encoder_to_tcp"


def late_clock(mm: float, alike=()) -> Cause:
    """The instrument's stamps are behind."""

    def act(truth: Truth, s: float) -> None:
        truth.late += s

    return Cause(
        "latency",
        (),
        BODY,
        ("speed",),
        act,
        0.02,
        mm,
        "two clocks",
        "bring the clocks together (trigger, or shift by the figure found); nothing at the machine",
        "tuning drives",
        ("servo_lag", *alike),
    )


def not_at_rest(mm: float, alike=()) -> Cause:
    """Read while it still swings in: a share of the last move is left, more of the longer ones' ringing."""

    def act(truth: Truth, s: float) -> None:
        way = truth.run.way
        left = np.exp(-(0.7 + 0.35 * np.sin(np.arange(truth.n) * 2.4)))[:, None]
        share = 1.0 / (1.0 + np.abs(way) / 1.2)
        truth.link -= s * left * way * share

    return Cause(
        "early_reading",
        (),
        BODY,
        ("direction", "time"),
        act,
        2e-3,
        mm,
        "read before the arm was at rest",
        "wait longer at each point before reading; nothing at the machine",
        "opening gears",
        ("backlash", *alike),
    )


def wrong_scale(mm: float, alike=()) -> Cause:
    """The instrument's metre is long: about its own stand."""

    def act(truth: Truth, s: float) -> None:
        def read(T, t, setup):
            T = T.copy()
            T[:, :3, 3] += s * (T[:, :3, 3] - setup["eye"])
            return T

        truth.reading.append(read)

    return Cause(
        "measurement_scale",
        (),
        BODY,
        ("position",),
        act,
        1e-4,
        mm,
        "the instrument's metre (weather station, scale bar) is off",
        "check the instrument on a bar of known length, correct its scale, measure again",
        "calibrating the robot by these readings",
        alike,
    )


def creeping_stand(mm: float, hours: float = 0.7, alike=()) -> Cause:
    """The instrument's stand settles and turns, fast at first."""

    def act(truth: Truth, s: float) -> None:
        def read(T, t, setup):
            u = (1 - np.exp(-t / (3600 * hours)))[:, None] * np.ones(3)
            off = nudge(s * u * np.array([0.6, -0.3, -0.5]), 4e-4 * s * u * np.array([0.5, -0.4, 0.8]))
            out = T.copy()
            rel = T[:, :3, 3] - setup["eye"]
            out[:, :3, 3] = setup["eye"] + np.einsum("nij,nj->ni", off[:, :3, :3], rel) + off[:, :3, 3]
            return out

        truth.reading.append(read)

    return Cause(
        "measurement_drift",
        (),
        BODY,
        ("time",),
        act,
        0.3,
        mm,
        "the instrument's stand settles",
        "fix the stand, let it warm, measure a reference point again and again",
        "calibrating the robot by these readings",
        ("thermal_drift", *alike),
    )
