"""Which case is about what: the table. Everything else is drawn from the seed."""

from __future__ import annotations

__all__ = ["KINDS", "PLAN", "planned"]

# machine, log, frame, causes with their class of size, leftover or none, correlated noise or none.
# Sizes by the floor (the larger of leftover and noise): L 3 to 10, M 2 to 3, S 0.5 to 2; l a tenth to a half of the first.
# Frames: world (frame and target known), base (on the turning table), own (neither), foot (frame known, target not).
PLAN = (
    ("kr15", "pocket", "world", {"cutting_force": "L"}, "left", ""),
    ("kr15", "trim", "own", {"servo_lag": "L", "cutting_force": "l"}, "left", "corr"),
    ("kr15", "trim", "base", {"turntable": "M"}, "left", ""),
    ("kr15", "pocket", "base", {"frame_table": "L", "backlash": "l"}, "", ""),
    ("kr15", "polish", "world", {"track": "L"}, "left", "corr"),
    ("kr500", "pocket", "world", {"cutting_force": "M", "joint_compliance": "M"}, "left", "corr"),
    ("kr500", "trim", "own", {"friction": "L"}, "left", ""),
    ("kr500", "pocket", "own", {"backlash": "M"}, "left", "corr"),
    ("long", "trim", "own", {"gear_ripple": "M"}, "", ""),
    ("long", "handle", "foot", {"joint_compliance": "L"}, "left", ""),
    ("long", "pocket", "own", {"lean": "M", "thermal_drift": "l"}, "left", "corr"),
    ("long", "handle", "foot", {"payload": "L"}, "left", ""),
    ("ur10e", "polish", "own", {"cutting_force": "L"}, "", "corr"),
    ("ur10e", "handle", "world", {"acceleration_error": "L", "servo_lag": "S"}, "", ""),
    ("ur10e", "handle", "foot", {"payload": "M", "hysteresis": "l"}, "left", "corr"),
    ("ur10e", "polish", "own", {"setpoint_delay": "L"}, "left", ""),
    ("scara", "handle", "own", {"latency": "L"}, "left", ""),
    ("scara", "handle", "foot", {"backlash": "M", "joint_offset": "S"}, "", "corr"),
    ("rx160", "poses", "own", {"geometry": "L"}, "left", ""),
    ("rx160", "poses", "own", {"joint_offset": "L", "geometry": "l"}, "left", ""),
    ("ur10e", "poses", "own", {"geometry": "M", "joint_offset": "L", "joint_compliance": "S"}, "left", ""),
    ("long", "poses", "own", {"joint_compliance": "L", "backlash": "l"}, "", ""),
    ("kr500", "poses", "foot", {"thermal_drift": "L"}, "left", ""),
    ("kr500", "poses", "foot", {"measurement_drift": "M", "geometry": "S"}, "", ""),
    ("rx160", "poses", "foot", {"measurement_scale": "M"}, "left", ""),
    ("ur10e", "poses", "own", {"early_reading": "M"}, "", ""),
    ("rx160", "poses", "world", {"frame_tool": "L", "frame_base": "M"}, "", ""),
    ("kr15", "poses", "own", {"wrist_coupling": "M"}, "left", ""),
    ("kr500", "drives", "", {"friction": "L", "servo_lag": "l"}, "left", ""),
    ("ur10e", "drives", "", {"motor_commutation": "L"}, "", ""),
    ("long", "pocket", "foot", {"air_balancer": "L"}, "left", ""),
    ("kr15", "trim", "base", {"table_clamp": "L"}, "", ""),
    ("ur10e", "trim", "own", {"float_head": "L"}, "left", "corr"),
    ("rx160", "poses", "foot", {"adm_cyclic": "L"}, "", ""),
    ("kr500", "drives", "", {"late_brake": "L"}, "left", ""),
    ("scara", "handle", "own", {"encoder_filter": "L"}, "", ""),
    ("kr15", "pocket", "world", {"block_ends": "L"}, "", ""),
    ("kr15", "pocket", "world", {}, "", "corr"),
    ("long", "trim", "own", {}, "", "corr"),
    ("ur10e", "poses", "own", {}, "", ""),
    ("kr500", "drives", "", {}, "", ""),
)
KINDS = ("none", "one", "two", "three", "foreign")
FIRST_FOREIGN, FIRST_NONE = 30, 37


def planned(number) -> dict:
    """What a case is about, by words."""
    machine, log, frame, causes, left, corr = PLAN[number]
    if number >= FIRST_NONE:
        kind = "none"
    elif number >= FIRST_FOREIGN:
        kind = "foreign"
    else:
        kind = KINDS[len(causes)]
    return {
        "kind": kind,
        "machine": machine,
        "log": log,
        "frame": frame,
        "causes": dict(causes),
        "left": bool(left),
        "correlated": bool(corr),
    }
