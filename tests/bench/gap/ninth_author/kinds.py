"""The causes by name: how each is drawn, what else of the same name may look like it, and what a person does about it.

`draw(rng, arm, kind)` gives a key and the axes that it sits on; `keys(arm, kind)` gives keys whose patterns span what
somebody could explain by that name.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from gap.ninth_author import body_causes as body
from gap.ninth_author import draws, looks
from gap.ninth_author import drive_causes as drive

__all__ = ["FOREIGN", "MOST", "NAMED", "Kind"]

DRIVE, LINK, LOOK = "setpoint_to_encoder", "encoder_to_tcp", "instrument"


@dataclass(frozen=True)
class Kind:
    """One name: what it does, how it is drawn, at which stage it shows, what it follows, what a technician should do."""

    make: Callable
    draw: Callable
    keys: Callable
    stage: str
    follows: tuple[str, ...]
    deed: str
    logs: tuple[str, ...] = ("path", "poses")
    fixed: bool = False  # its size is what it is


_BODY = ("path", "poses")
MOST = {  # what one of them comes to at the most, on a machine that is still in use; of a payload in shares of what it may carry
    "servo_lag": 0.02,
    "acceleration_error": 0.002,
    "friction": 0.0015,
    "setpoint_delay": 0.05,
    "motor_commutation": 0.001,
    "early_reading": 0.1,
    "backlash": 0.002,
    "hysteresis": 0.0015,
    "gear_ripple": 0.0008,
    "wrist_coupling": 0.01,
    "joint_compliance": 1.5,
    "payload": 1,
    "cutting_force": 6,
    "lean": 1.5e-07,
    "joint_offset": 0.01,
    "geometry": 3,
    "frame_base": 0.003,
    "frame_tool": 0.003,
    "frame_table": 0.003,
    "turntable": 0.002,
    "track": 0.0015,
    "thermal_drift": 4,
    "latency": 0.04,
    "measurement_scale": 0.0003,
    "measurement_drift": 0.0004,
    "air_balancer": 0.002,
    "table_clamp": 0.0015,
    "float_head": 0.003,
    "adm_cyclic": 0.0003,
    "late_brake": 0.35,
    "encoder_filter": 0.03,
    "block_ends": 1,
}

NAMED = {
    "servo_lag": Kind(
        drive.servo_lag,
        draws.lag,
        lambda arm, kind: [("follower", draws.unit(arm.n, i)) for i in draws.axes(arm)],
        DRIVE,
        ("speed",),
        "tune the position loops (gain, feed-forward of speed), the odd axis first",
        ("path", "drives"),
    ),
    "acceleration_error": Kind(
        drive.acceleration_error,
        draws.one(lambda rng, arm, i: (i,)),
        lambda arm, kind: [(i,) for i in draws.axes(arm)],
        DRIVE,
        ("acceleration",),
        "enter the inertia (load data), feed acceleration forward, or drive it more gently",
        ("path", "drives"),
    ),
    "friction": Kind(
        drive.friction,
        draws.one(draws.friction),
        draws.friction_keys,
        DRIVE,
        ("direction",),
        "look at the axis's grease, seals and belt, then set friction compensation",
        ("path", "drives"),
    ),
    "setpoint_delay": Kind(
        drive.setpoint_delay,
        draws.one(lambda rng, arm, i: (i, float(rng.uniform(3, 9)))),
        lambda arm, kind: [(i, 5.0) for i in draws.axes(arm)],
        DRIVE,
        ("speed",),
        "look at the bus to this axis's drive: its cycle and its dead-time setting",
        ("path", "drives"),
    ),
    "motor_commutation": Kind(
        drive.motor_commutation,
        draws.one(draws.poles),
        lambda arm, kind: [],
        DRIVE,
        ("position",),
        "have the motor's commutation angle and current sensors set anew",
        ("drives",),
    ),
    "early_reading": Kind(
        drive.early_reading,
        draws.one(lambda rng, arm, i: (i, float(rng.uniform(0.25, 0.5)))),
        lambda arm, kind: [(i, 0.35) for i in draws.axes(arm)],
        DRIVE,
        ("direction", "time"),
        "wait longer before reading, until the axis is in its window",
        ("poses",),
    ),
    "backlash": Kind(
        body.backlash,
        draws.one(lambda rng, arm, i: (i,)),
        lambda arm, kind: [(i,) for i in draws.axes(arm)],
        LINK,
        ("direction",),
        "measure the play at the axis by a dial gauge, then have its gear set or changed",
        _BODY,
    ),
    "hysteresis": Kind(
        body.hysteresis,
        draws.one(lambda rng, arm, i: (i, float(rng.uniform(0.015, 0.05)))),
        lambda arm, kind: [(i, r) for i in draws.axes(arm) for r in (0.015, 0.05)],
        LINK,
        ("direction",),
        "measure the lost motion at the axis under load both ways; its gear or bearing is worn",
        _BODY,
    ),
    "gear_ripple": Kind(
        body.gear_ripple,
        draws.one(draws.ripple),
        lambda arm, kind: [],
        LINK,
        ("position",),
        "check the gear: a wave so many times a turn",
    ),
    "wrist_coupling": Kind(
        body.wrist_coupling,
        draws.hand,
        draws.hand_keys,
        LINK,
        ("position",),
        "set the hand's coupling factors in the machine data, master the wrist anew",
        _BODY,
    ),
    "joint_compliance": Kind(
        body.joint_compliance,
        draws.compliance,
        lambda arm, kind: [(draws.unit(arm.n, i), 0.0) for i in draws.axes(arm)],
        LINK,
        ("load", "position"),
        "take the sag off (stiffness in the controller's model), or support it",
        _BODY,
    ),
    "payload": Kind(
        body.payload,
        draws.payload,
        draws.payload_keys,
        LINK,
        ("load", "position"),
        "weigh the tool and enter its load data: mass and centre",
        _BODY,
    ),
    "cutting_force": Kind(
        body.cutting_force,
        lambda rng, arm, kind: ((1.0, float(rng.uniform(1e-8, 6e-8)), float(rng.uniform(0.2, 0.8))), []),
        lambda arm, kind: [(1.0, 0.0, 0.0), (1.0, 0.0, 1.0), (0.0, 4e-8, 0.0)],
        LINK,
        ("force",),
        "cut less deep or slower, look at the spindle's bearing and its mount, or take the push off beforehand",
        ("path",),
    ),
    "lean": Kind(
        body.lean,
        lambda rng, arm, kind: ((float(rng.uniform(0, 3)), float(rng.uniform(0.2, 0.8))), []),
        lambda arm, kind: [(a, 0.0) for a in (0.0, 1.57)],
        LINK,
        ("load", "position"),
        "tighten the anchors, grout or stiffen the foot",
        _BODY,
    ),
    "joint_offset": Kind(
        body.joint_offset,
        draws.zeros,
        lambda arm, kind: [draws.unit(arm.n, i) for i in draws.axes(arm)],
        LINK,
        ("position",),
        "master the axes anew",
        _BODY,
    ),
    "geometry": Kind(
        body.geometry,
        draws.rows,
        draws.row_keys,
        LINK,
        ("position",),
        "calibrate the arm, enter the lengths and angles",
        _BODY,
    ),
    "frame_base": Kind(
        body.frame_base,
        draws.six([1, 1, 1, 0.4, 0.4, 0.4]),
        draws.six_keys([1, 1, 1, 1, 1, 1]),
        LINK,
        ("position",),
        "measure where the foot stands and enter it",
    ),
    "frame_tool": Kind(
        body.frame_tool,
        draws.six([1, 1, 1, 0.0, 0.0, 0.0]),
        draws.six_keys([1, 1, 1, 0, 0, 0]),
        LINK,
        ("position",),
        "measure the tool anew and enter it",
    ),
    "frame_table": Kind(
        body.frame_table,
        draws.six([1, 1, 0, 0.6, 0.6, 0]),
        draws.six_keys([1, 1, 0, 1, 1, 0]),
        LINK,
        ("position",),
        "measure the table's axis anew and enter it",
    ),
    "turntable": Kind(
        body.turntable,
        draws.wobble,
        draws.wobble_keys,
        LINK,
        ("position",),
        "level and centre the plate; check the table's bearing",
    ),
    "track": Kind(body.track, draws.rail, draws.rail_keys, LINK, ("position",), "line up the rail, enter its scale"),
    "thermal_drift": Kind(
        body.thermal_drift,
        draws.warm,
        draws.warm_keys,
        LINK,
        ("temperature", "time"),
        "warm the arm up before work, or measure anew when warm",
        _BODY,
    ),
    "latency": Kind(
        looks.latency,
        draws.nothing,
        lambda arm, kind: [()],
        LOOK,
        ("speed",),
        "bring the clocks together; the machine is right",
        ("path",),
    ),
    "measurement_scale": Kind(
        looks.measurement_scale,
        draws.nothing,
        lambda arm, kind: [()],
        LOOK,
        ("position",),
        "check the instrument against a known length (its air temperature and pressure)",
        _BODY,
    ),
    "measurement_drift": Kind(
        looks.measurement_drift,
        draws.drift,
        draws.drift_keys,
        LOOK,
        ("time",),
        "let the stand settle, check it by fixed points",
        ("poses",),
    ),
}

FOREIGN = {
    "air_balancer": Kind(
        body.air_balancer,
        lambda rng, arm, kind: (
            (arm.first + 1, float(rng.uniform(7, 11)), float(rng.uniform(0, 5))),
            draws.name(arm, arm.first + 1),
        ),
        None,
        LINK,
        ("time",),
        "look at the balancer's air: pressure over time, valve, compressor",
        ("path",),
    ),
    "table_clamp": Kind(
        body.table_clamp,
        lambda rng, arm, kind: ((0.05, float(rng.uniform(-0.5, 0.5))), ["E2"]),
        None,
        LINK,
        ("speed", "position"),
        "look at the table's clamp: it shifts the plate as it closes",
        ("path",),
    ),
    "float_head": Kind(
        body.float_head,
        lambda rng, arm, kind: ((float(rng.uniform(0.45, 0.6)), float(rng.uniform(0.6, 0.85))), []),
        None,
        LINK,
        ("force",),
        "raise the head's air pressure or lock it; it gives way beyond its preload",
        ("path",),
    ),
    "adm_cyclic": Kind(
        looks.adm_cyclic,
        lambda rng, arm, kind: (((2.6, -2.2, 0.9), float(rng.uniform(0.35, 0.6)), float(rng.uniform(0, 6))), []),
        None,
        LOOK,
        ("position",),
        "check the tracker's distance meter on a bar of several lengths",
    ),
    "late_brake": Kind(
        drive.late_brake,
        lambda rng, arm, kind: ((arm.first + 2,), draws.name(arm, arm.first + 2)),
        None,
        DRIVE,
        ("time", "speed"),
        "look at the brake's release time and its supply",
        ("drives",),
    ),
    "encoder_filter": Kind(
        looks.encoder_filter,
        lambda rng, arm, kind: ((float(rng.uniform(0.7, 1.6)),), []),
        None,
        DRIVE,
        ("speed",),
        "switch off the recorder's filter; the machine is right",
        ("path",),
        True,
    ),
    "block_ends": Kind(
        looks.block_ends,
        draws.nothing,
        None,
        DRIVE,
        ("position", "time"),
        "record the interpolated set-points, not the blocks' ends; the machine is right",
        ("path",),
        True,
    ),
}
