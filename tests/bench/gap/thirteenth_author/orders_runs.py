"""Orders that are recorded as the machine goes: with an instrument (paths) and without one (drives)."""

from __future__ import annotations

from .orders import MASTER, Cause, Order


def _path(*args, **kwargs):
    return Order("paths", *args, **kwargs)


def _drive(title, machine, moves, causes, step, wrong_step="", **kwargs):
    return Order("drives", title, machine, moves, None, causes, step, wrong_step, **kwargs)


PATHS = (
    _path(
        "before and after: drives exchanged, two axes hang back",
        *("kr16", "test_part", "tracker"),
        (Cause("servo_lag", ("A2", "A3"), 8.0, since="after"), Cause("backlash", ("A1",), 2.0)),
        "read the drives' parameters of A2 and A3 back and compare them with the machine's file",
        "open a gear",
        before=True,
        left=1,
        form="semicolon",
    ),
    _path(
        "before and after: play of A2 that has grown",
        *("r2000", "ball_bar", "tracker"),
        (Cause("backlash", ("A2",), 5.0, since="after", alike=("hysteresis",)),),
        "dial gauge at A2 (swing the arm by hand), then its gear",
        "master",
        before=True,
        wander=0.5,
        form="fanuc",
        how={"radius": 0.25, "feed": 0.2, "hz": 40.0, "upright": True},
    ),
    _path(
        "strain wave gear that lost its grease",
        *("iiwa14", "tour", "tracker"),
        (Cause("hysteresis", ("A4",), 2.5, {"length": 0.06}, alike=("backlash",)),),
        "run A4 alone to and fro: its gear",
        "master",
        left=2,
        wander=0.6,
        form="lists",
        how={"seconds": 45.0},
    ),
    _path(
        "a length of rack and rail renewed, pinion set too wide",
        *("kr120_rail", "rail_run", "tracker"),
        (Cause("track", ("E1",), 6.0), Cause("backlash", ("E1",), 4.0, alike=("hysteresis",))),
        "measure the joint of the rails by level and laser; set the pinion",
        "master an arm's axis",
        form="semicolon",
    ),
    _path(
        "camera on another clock, and a zero",
        *("m1013", "tour", "stereo"),
        (Cause("latency", (), 10.0), Cause("joint_offset", ("A2",), 4.0)),
        "set the camera's clock; " + MASTER.format("A2"),
        "exchange drives",
        left=2,
        form="quoted",
    ),
    _path(
        "tool's inertia never told",
        *("ur10e", "tour", "tracker"),
        (Cause("acceleration_error", ("A1", "A2"), 6.0), Cause("backlash", ("A3",), 0.8)),
        "enter load and inertia of the tool",
        "open a gear",
        left=1,
        form="rtde",
        how={"brisk": 1.5},
    ),
    _path(
        "belt wheel of a hollow wrist off its centre",
        *("paint", "slow_sweeps", "tracker_six"),
        (Cause("gear_ripple", ("A5",), 2.5, {"waves": 26.0}),),
        "turn A5 alone: its belt wheels and its gear",
        "master",
        wander=0.7,
        form="rotvec",
        how={"axes": (3, 4), "span": 40.0},
    ),
    _path(
        "deburring: a wheel that presses on a small arm",
        *("kr10_ceiling", "deburring", "tracker_cell"),
        (Cause("cutting_force", ("A1", "A2", "A3"), 3.0),),
        "nothing is broken: less force or correction in the program",
        "master",
        form="plain",
    ),
    _path(
        "a beam's loop softer than its runway's",
        *("portal", "ball_bar", "tracker"),
        (Cause("servo_lag", ("A2",), 3.0, alike=("setpoint_delay",)),),
        "compare the loops' gains of A1 and A2",
        "square the bridge",
        left=1,
        form="tabs",
        how={"radius": 0.3, "feed": 0.3},
    ),
    _path(
        "second axis worn where it always works",
        *("irb2400", "ball_bar", "tracker_cell"),
        (
            Cause("backlash", ("A2",), 3.0, {"worn": (5.0, 9.0)}, alike=("hysteresis",)),
            Cause("measurement_frame", (), 0.8),
        ),
        "dial gauge at A2 in the worn place: its gear",
        "master",
        wander=0.5,
        form="plain",
        how={"radius": 0.2, "feed": 0.1, "hz": 25.0, "upright": True},
    ),
)

DRIVES = (
    _drive(
        "before and after: a brake that drags",
        *("kr16", "warm_up"),
        (Cause("friction", ("A3",), 10.0, since="after"),),
        "let A3's brake click and measure its release voltage; current of A3 by hand guide",
        "open the gear of A3",
        before=True,
        left=1,
        columns="I",
        form="semicolon",
    ),
    _drive(
        "parameters of two drives exchanged: one hangs back, one leads",
        *("r2000", "tour"),
        (Cause("servo_lag", ("A4", "A5"), 12.0, {"shares": (1.0, -0.6)}, alike=("setpoint_delay",)),),
        "read the parameters of A4 and A5 back: they are exchanged",
        "open the wrist",
        form="fanuc",
    ),
    _drive(
        "new grease: a joint that is stiff until it is warm",
        *("iiwa14", "warm_up"),
        (Cause("friction", ("A2",), 8.0, {"fades": 0.5}),),
        "run A2 warm and measure its friction again",
        "open the gear at once",
        columns="T",
        form="lists",
    ),
    _drive(
        "before and after: ball screw without preload, a scale on the beam",
        *("portal", "warm_up"),
        (Cause("backlash", ("A2",), 8.0, since="after", alike=("hysteresis",)),),
        "nut and bearings of the beam's screw: dial gauge, preload",
        "change the loop's gains",
        before=True,
        left=0.5,
        columns="M",
        form="plain",
    ),
    _drive(
        "a carriage's new drive without feed-forward of inertia",
        *("kr120_rail", "warm_up"),
        (Cause("acceleration_error", ("E1",), 12.0), Cause("friction", ("A1",), 0.6)),
        "set the feed-forward of the carriage's drive",
        "open the rail's gear",
        left=2,
        form="tabs",
    ),
    _drive(
        "motor exchanged, its angle not measured in",
        *("ur10e", "slow_sweeps"),
        (Cause("motor_commutation", ("A2",), 4.0, {"waves": 40.0}, alike=("gear_ripple",)),),
        "have the drive of A2 measure its commutation angle",
        "master",
        left=1,
        form="rtde",
        how={"axes": (0, 1, 2), "span": 30.0},
    ),
    _drive(
        "another firmware in one drive, a sticky first axis",
        *("kr10_ceiling", "tour"),
        (Cause("setpoint_delay", ("A5",), 6.0, alike=("servo_lag",)), Cause("friction", ("A1",), 3.0)),
        "compare firmware and bus cycle of A5's drive",
        "open the wrist",
        form="counts",
        how={"share": 0.6},
    ),
    _drive(
        "chain of cables that drags beyond 20 degrees",
        *("ts60", "warm_up"),
        (Cause("friction", ("A1",), 10.0, {"beyond": 20.0}),),
        "look at the cables of A1 beyond 20 degrees",
        "exchange the drive",
        form="plain",
    ),
)
