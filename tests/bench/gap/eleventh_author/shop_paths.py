"""Cases of dense logs with an instrument. Who works on the diagnosis does not read this before the family is opened."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from .bodies import belt_wheel, play, slip_inside
from .drives import late_setpoints, no_inertia_term, proportional_loop
from .loads import cutter_pushes, give, warming
from .moves import circles, ptp, raster, sweeps
from .plan import Plan
from .readings import late_clock
from .strangers import bent_beam, hose, shaft_key

__all__ = ["PATHS"]

STAND = {"frame": "unknown"}
TRACKER, FINE = (0.014, 0.018, 0.018), (0.007, 0.009, 0.009)


def _cutting(make, newton: float):
    """A path under a cutter: force against the feed and away from the part, by how deep it is in."""

    def more(robot, rng):
        run = make(robot, rng)
        p = robot.tip(run.q)[:, :3, 3]
        v = np.gradient(p, run.t, axis=0)
        speed = np.linalg.norm(v, axis=1, keepdims=True)
        keep = np.exp(-(run.t[1] - run.t[0]) / 0.9)
        deep = lfilter([np.sqrt(1 - keep**2)], [1, -keep], rng.normal(0, 0.5, len(run.t)))
        size = newton * np.clip(1 + deep, 0, 3)[:, None]
        run.push = size * (-v / np.maximum(speed, 1.0) + np.array([0.0, 0.0, 0.6]) * (speed > 1.0))
        return run

    return more


BOTH = ("set", "enc")
PATHS = [
    Plan(
        "soft loops and a worn first axis",
        "big",
        (ptp(22, 0.35),),
        (proportional_loop({"A1": 1, "A2": 0.7, "A3": 0.6}, 1.5), play({"A1": 1}, 0.7)),
        ptp(10, 0.25),
        **STAND,
        sigma=TRACKER,
        logged=BOTH,
        left=0.3,
        sheet="karel",
    ),
    Plan(
        "strain wave gears, messages of a bus",
        "seven",
        (ptp(24, 0.12, step=20),),
        (slip_inside({"A2": 1, "A4": 0.8}, 0.4),),
        ptp(12, 0.12, step=20),
        **STAND,
        sigma=TRACKER,
        left=0.08,
        lost=0.03,
        sheet="ros",
    ),
    Plan(
        "pins of a gear, slow sweeps",
        "big",
        (sweeps(("A1", "A2", "A1"), 2, 0.5, 0.06, step=12),),
        (belt_wheel("A1", ((39, 1, 0.3), (78, 0.3, 1.0)), 0.15, told="a gear whose pins are worn"),),
        **STAND,
        sigma=FINE,
        wander=0.008,
        forget=2.0,
        sheet="plain",
    ),
    Plan(
        "milling from the roof, play in its first axis",
        "hanging",
        (
            _cutting(raster(420, 300, 9, 60, rise=60, step=15), 110.0),
            _cutting(raster(300, 420, 8, 60, rise=40, step=15), 60.0),
        ),
        (cutter_pushes({"A1": 1, "A2": 1.1, "A3": 1.5}, 0.5), play({"A1": 1}, 0.08)),
        **STAND,
        sigma=TRACKER,
        logged=("enc", "force"),
        left=0.05,
        sheet="rapid",
    ),
    Plan(
        "a tracker with its own clock",
        "cobot",
        (ptp(20, 0.25),),
        (late_clock(2.0),),
        **STAND,
        sigma=TRACKER,
        logged=BOTH,
        sheet="rtde",
    ),
    Plan(
        "ball bar on a gantry",
        "gantry",
        (circles(150, 40, step=6), circles(150, 120, step=3)),
        (play({"A1": 1}, 0.02), proportional_loop({"A2": 1}, 0.05)),
        see="ball",
        sigma=(0.0015,) * 3,
        logged=BOTH,
        left=0.004,
        sheet="beside",
    ),
    Plan(
        "quick raster of a gantry",
        "gantry",
        (raster(700, 500, 10, 300, rise=80, step=6),),
        (no_inertia_term({"A1": 1, "A2": 0.8}, 0.25), play({"A2": 1}, 0.035)),
        raster(500, 800, 8, 250, plane="xy", step=6),
        **STAND,
        sigma=FINE,
        logged=BOTH,
        wander=0.01,
        forget=3.0,
        sheet="counts",
    ),
    Plan(
        "turning axis on a second bus, under a camera",
        "scara",
        (ptp(40, 0.12, rest=0.1, step=5),),
        (late_setpoints({"A4": 1}, 0.5),),
        **STAND,
        sigma=(0.02, 0.02, 0.06),
        logged=BOTH,
        sheet="val3",
    ),
    Plan(
        "painting from cold on",
        "painter",
        (ptp(60, 0.003, rest=5.0, dt=0.25, step=10),),
        (warming(0.3),),
        **STAND,
        sigma=TRACKER,
        logged=("enc", "temp"),
        left=0.1,
        wander=0.015,
        forget=200.0,
        sheet="trace",
    ),
    Plan(
        "lag, play and a late clock",
        "weld",
        (ptp(26, 0.3),),
        (proportional_loop({"A1": 1, "A2": 1, "A3": 1}, 1.2), play({"A1": 1}, 0.4), late_clock(1.0)),
        ptp(12, 0.4),
        sigma=TRACKER,
        logged=BOTH,
        wander=0.02,
        forget=4.0,
        sheet="inch",
    ),
    Plan(
        "hose over a wrist",
        "hanging",
        (ptp(26, 0.15, step=20),),
        (hose(0.6),),
        ptp(12, 0.15, step=20),
        **STAND,
        sigma=TRACKER,
        left=0.15,
        sheet="rtde",
    ),
    Plan(
        "beam between two posts",
        "gantry",
        (raster(1300, 900, 9, 250, step=15, rise=150), raster(900, 1300, 12, 250, step=15)),
        (bent_beam(0.12),),
        sigma=FINE,
        **STAND,
        left=0.015,
        sheet="plain",
    ),
    Plan(
        "nothing wrong, within what was asked",
        "service",
        (ptp(24, 0.2),),
        (),
        ptp(10, 0.2),
        **STAND,
        sigma=TRACKER,
        logged=BOTH,
        left=0.06,
        tolerance=0.3,
        sheet="trace",
    ),
    Plan(
        "a wrist slips on its shaft",
        "cobot",
        (ptp(26, 0.2),),
        (shaft_key("A5", 0.6),),
        **STAND,
        sigma=TRACKER,
        wander=0.015,
        forget=5.0,
        sheet="karel",
    ),
    Plan(
        "light arm for help at home, soft and slipping",
        "service",
        (ptp(26, 0.12, step=20),),
        (slip_inside({"A2": 1, "A4": 1}, 0.5), give({"A2": 1, "A4": 1.3}, 0.075)),
        ptp(14, 0.12, step=20),
        **STAND,
        sigma=TRACKER,
        wander=0.02,
        forget=6.0,
        lost=0.02,
        gross=0.008,
        sheet="beside",
    ),
    Plan(
        "ball bar before a cobot",
        "cobot",
        (circles(100, 30, step=6), circles(100, 30, plane="xz", step=6)),
        (play({"A1": 1}, 0.015),),
        see="ball",
        sigma=(0.002,) * 3,
        left=0.008,
        sheet="val3",
    ),
]
