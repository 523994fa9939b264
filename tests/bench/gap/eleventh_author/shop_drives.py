"""Cases of what controllers record, without an instrument.

Who works on the diagnosis does not read this before the family is opened."""

from __future__ import annotations

from .drives import late_setpoints, magnets, no_inertia_term, proportional_loop, sticking, wound_gear_two_encoders
from .moves import ptp, raster, sweeps
from .plan import Plan
from .strangers import current_limit

__all__ = ["DRIVES"]

BOTH = ("set", "enc")
DRIVES = [
    Plan(
        "cobot after a winter in the yard",
        "cobot",
        (ptp(26, 0.15, step=4),),
        (sticking({"A1": 1, "A2": 0.7}, 0.4),),
        ptp(12, 0.15, step=4),
        see="",
        logged=(*BOTH, "current"),
        sheet="rtde",
    ),
    Plan(
        "loops left as delivered, a motor exchanged",
        "big",
        (ptp(16, 0.3, step=3),),
        (
            proportional_loop({"A1": 1, "A2": 0.4, "A3": 0.4, "A4": 0.3, "A5": 0.3, "A6": 0.3}, 1.5),
            magnets("A4", 60.0, 0.06),
        ),
        see="",
        logged=BOTH,
        left=0.03,
        sheet="karel",
    ),
    Plan(
        "painter's motor exchanged",
        "painter",
        (sweeps(("A4", "A5", "A4"), 2, 0.5, 0.15, step=2),),
        (magnets("A4", 50.0, 0.3),),
        see="",
        logged=BOTH,
        sheet="val3",
    ),
    Plan(
        "seven axes with torques, quick",
        "seven",
        (ptp(26, 0.5, step=4),),
        (no_inertia_term({"A1": 1, "A2": 1}, 0.4),),
        ptp(12, 0.4, step=4),
        see="",
        logged=(*BOTH, "torque"),
        left=0.04,
        sheet="plain",
    ),
    Plan(
        "cross axis behind the others",
        "gantry",
        (raster(800, 600, 8, 220, step=5, rise=100),),
        (late_setpoints({"A2": 1}, 1.0),),
        see="",
        logged=BOTH,
        sheet="trace",
    ),
    Plan(
        "two encoders on a press's arm",
        "scara",
        (ptp(36, 0.06, step=5),),
        (wound_gear_two_encoders("A1", 0.25),),
        ptp(16, 0.06, step=5),
        see="",
        logged=(*BOTH, "motor"),
        sheet="rapid",
    ),
    Plan(
        "a limit left from commissioning",
        "big",
        (ptp(26, 0.45, step=3),),
        (current_limit("A2", 0.6),),
        see="",
        logged=(*BOTH, "torque"),
        sheet="counts",
    ),
    Plan(
        "nothing wrong, drives within what was asked",
        "hanging",
        (ptp(20, 0.25, step=5),),
        (),
        see="",
        logged=BOTH,
        left=0.05,
        tolerance=0.3,
        sheet="plain",
    ),
    Plan(
        "small arm, sticking and late",
        "desktop",
        (ptp(30, 0.12, step=4),),
        (sticking({"A2": 1}, 0.018), late_setpoints({"A5": 1}, 0.2)),
        ptp(14, 0.12, step=4),
        see="",
        logged=BOTH,
        left=0.012,
        sheet="counts",
    ),
    Plan(
        "carriage far behind, first axis without its share",
        "weld",
        (ptp(22, 0.35, step=4),),
        (proportional_loop({"E1": 1}, 2.0), no_inertia_term({"A1": 1}, 0.4)),
        ptp(10, 0.35, step=4),
        see="",
        logged=BOTH,
        left=0.05,
        sheet="inch",
    ),
    Plan(
        "nothing wrong, drives of a cobot",
        "cobot",
        (ptp(18, 0.2, step=5),),
        (),
        see="",
        logged=(*BOTH, "current"),
        sheet="ros",
    ),
]
