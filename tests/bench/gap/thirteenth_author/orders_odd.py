"""Orders whose fault has no usual name, and those where nothing is wrong."""

from __future__ import annotations

from .orders import MASTER, Cause, Order

TCP, SERVO = "encoder_to_tcp", "setpoint_to_encoder"


def _odd(*args, **kwargs):
    return Order("foreign", *args, **kwargs)


def _sound(title, machine, moves, sees, **kwargs):
    return Order("sound", title, machine, moves, sees, (), "nothing: release the machine", "adjust anything", **kwargs)


FOREIGN = (
    _odd(
        "before and after: balancer that has lost gas",
        *("r2000", "tracker_poses", "tracker_cell"),
        (Cause("counterbalance_leaks", ("A2",), 7.0, since="after", where=(TCP, ("A2",), ("load", "position"))),),
        "pressure of the balancer at A2",
        "master A2",
        before=True,
        left=2,
        form="fanuc",
        how={"n": 60},
    ),
    _odd(
        "bolts of the flange hardly tight",
        *("kr16", "tour", "tracker"),
        (Cause("flange_creeps", ("A6",), 6.0, where=(TCP, ("A6",), ("load", "direction", "position", "time"))),),
        "torque the bolts of the flange",
        "open the wrist",
        form="semicolon",
    ),
    _odd(
        "bearing of the forearm without preload",
        *("kr120_rail", "tracker_poses", "tracker"),
        (Cause("bearing_clears", ("A4",), 7.0, where=(TCP, ("A4",), ("load", "position", "direction"))),),
        "dial gauge across the forearm at A4, lifted by hand: its bearing",
        "master A4",
        left=2,
        form="plain",
        how={"n": 70},
    ),
    _odd(
        "limit of current left from setting up",
        *("irb2400", "tour", None),
        (Cause("current_limit", ("A2",), 9.0, where=(SERVO, ("A2",), ("acceleration", "load"))),),
        "limits of A2's drive against the machine's file",
        "open the gear of A2",
        form="fanuc_free",
        how={"brisk": 1.6},
    ),
    _odd(
        "motor on loose screws",
        *("ur10e", "tour", "tracker"),
        (Cause("motor_rattles", ("A1",), 3.0, where=(TCP, ("A1",), ("speed", "time"))),),
        "screws and mounting of A1's motor",
        "master A1",
        wander=0.6,
        form="rtde",
    ),
    _odd(
        "chips in the changer: another seat at every docking",
        *("m1013", "check_days", "gauges"),
        (Cause("docks_anew", (), 7.0, alike=("frame_tool",), where=(TCP, (), ("time",))),),
        "clean the tool changer and look at its cams",
        "master an axis",
        withheld=False,
        form="quoted",
        how={"n": 10, "days": 9},
    ),
    _odd(
        "a cartridge that empties, arm calibrated with it full",
        *("iiwa14", "tracker_poses", "tracker_six"),
        (
            Cause(
                "cartridge_empties",
                ("A2", "A4"),
                6.0,
                alike=("payload", "joint_compliance"),
                where=(TCP, ("A2", "A4"), ("load", "time")),
            ),
        ),
        "tell the controller the load as it is; nothing at the gears",
        "open a gear",
        withheld=False,
        left=1,
        wander=0.5,
        form="rotvec",
        how={"n": 90},
    ),
    _odd(
        "one side of the bridge hangs back",
        *("portal", "grid", "tracker_cell"),
        (Cause("bridge_racks", ("A1",), 6.0, where=(TCP, ("A1", "A2"), ("direction",))),),
        "drive shaft and pinion of the far side: dial gauge at both ends of the beam",
        "square the bridge",
        left=1,
        form="plain",
        how={"n": (6, 5, 2)},
    ),
    _odd(
        "a screen not earthed",
        *("kr10_ceiling", "warm_up", None),
        (Cause("cables_couple", ("A5", "A2"), 4.0, where=(SERVO, ("A5",), ("speed", "time"))),),
        "screen and plug of A5's resolver",
        "open the wrist",
        form="counts",
    ),
    _odd(
        "a clamp of hoses that touches the casting",
        *("irb2400", "tracker_poses", "tracker"),
        (
            Cause("clamp_touches", ("A1",), 6.0, where=(TCP, ("A1",), ("position",))),
            Cause("joint_offset", ("A5",), 4.0),
        ),
        "turn A1 beyond 35 degrees and look what touches; " + MASTER.format("A5"),
        "master A1",
        left=2,
        form="tabs",
        how={"n": 70},
    ),
    _odd(
        "a part off the middle tips over on a worm with play",
        *("ta_headstock", "stations", "plate_arm"),
        (
            Cause(
                "plate_tips_over",
                ("E2",),
                6.0,
                alike=("backlash", "turntable"),
                where=(TCP, ("E2",), ("position", "load")),
            ),
            Cause("joint_offset", ("A3",), 4.0),
        ),
        "play of the headstock's worm, with the part on it; " + MASTER.format("A3"),
        "measure the headstock's axis anew",
        left=1,
        form="plain",
        how={"along": 13, "each": 6},
    ),
)

SOUND = (
    _sound(
        "before and after a service: nothing has changed",
        "kr16",
        "tracker_poses",
        "tracker",
        before=True,
        form="workbook",
        how={"n": 40},
    ),
    _sound(
        "check poses of ten days",
        "ur10e",
        "check_days",
        "gauges",
        withheld=False,
        form="rtde",
        how={"n": 9, "days": 10},
    ),
    _sound("a bridge after its yearly check", "portal", "grid", "tracker_cell", form="plain", how={"n": (6, 5, 2)}),
    _sound(
        "tilting table, positions",
        "trunnion",
        "single_turns",
        "cheap_arm",
        wander=0.5,
        form="inch",
        how={"axes": (0, 1), "n": 25},
    ),
    _sound(
        "circles after new drives",
        "r2000",
        "ball_bar",
        "tracker",
        form="fanuc",
        how={"radius": 0.25, "feed": 0.2, "hz": 40.0},
    ),
    _sound("recorder alone, torques", "iiwa14", "warm_up", None, columns="T", form="lists"),
    _sound(
        "within what was asked of a paint arm",
        "paint",
        "tracker_poses",
        "tracker",
        left=3,
        tolerance_mm=0.3,
        form="iso_clock",
        how={"n": 60},
    ),
    _sound("drives within what was asked", "kr10_ceiling", "tour", None, left=6, tolerance_mm=0.6, form="counts"),
)
