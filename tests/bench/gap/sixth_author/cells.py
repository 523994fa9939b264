"""Machines of either family: lengths by data sheets from memory, masses and stiffness usual for the class."""

from __future__ import annotations

from gap.sixth_author.chain import Body, Joint, Machine

STIFF = (2.4e6, 2.1e6, 1.5e6, 3.2e5, 2.6e5, 1.1e5)
GEARS = (171.0, 153.0, 141.0, 81.0, 75.0, 51.0)


def _arm(rows, signs=(1,) * 6, offsets=(0.0,) * 6, speeds=(100, 90, 90, 170, 120, 190)):
    return tuple(
        Joint(f"A{k + 1}", *row, sign=signs[k], offset=offsets[k], speed=speeds[k]) for k, row in enumerate(rows)
    )


def _elbow(a1, d1, a2, a3, d4, d6):
    """Six axes with an elbow, upright at zero."""
    return [(-90, a1, 0, d1), (0, a2, -90, 0), (-90, a3, 0, 0), (90, 0, 0, d4), (-90, 0, 0, 0), (0, 0, 0, d6)]


def _bodies(a1, a2, d4, masses, tool):
    """Of such an arm: carousel, upper arm, forearm, wrist, tool (mass, centre before the plate)."""
    m1, m2, m3, m5 = masses
    return (
        Body("A1", m1, (-a1 * 0.5, 60.0, 0.0)),
        Body("A2", m2, (-0.55 * a2, 0.0, 20.0)),
        Body("A3", m3, (-40.0, 0.0, 0.24 * d4)),
        Body("A5", m5, (0.0, 0.0, 35.0)),
        Body("A6", *tool),
    )


def big_arm():
    """Milling arm of 150 kg and 3.2 m, on the floor."""
    return Machine(
        "big_arm",
        "arm of 150 kg and 3.2 m with a milling spindle",
        _arm(_elbow(320, 780, 1280, 200, 1592.5, 200)),
        (8, 12, 18, 12, 48, -20),
        (28, 18, 16, 35, 30, 50),
        (0, -60, 310, 30, 0, 90),
        _bodies(320, 1280, 1592.5, (420, 260, 310, 55), (46, (0, -40, 160))),
        STIFF,
        GEARS,
        payload=46,
        reach=3.2,
    )


def cobot():
    """UR10-like."""
    rows = [
        (90, 0, 0, 127.3),
        (0, -612, 0, 0),
        (0, -572.3, 0, 0),
        (90, 0, 0, 163.941),
        (-90, 0, 0, 115.7),
        (0, 0, 0, 92.2),
    ]
    bodies = (Body("A1", 7.8, (0, 0, 10)), Body("A2", 12.9, (230, 0, 158)), Body("A3", 3.9, (210, 0, 68)))
    bodies += (Body("A4", 2.0, (0, 7, 18)), Body("A5", 2.0, (0, 7, 18)), Body("A6", 5.2, (0, 0, 70)))
    return Machine(
        "cobot",
        "cobot of 10 kg",
        _arm(rows, speeds=(120, 120, 180, 180, 180, 180)),
        (15, -75, 95, -105, -80, 10),
        (35, 22, 25, 35, 30, 50),
        (25, 0, 145, 0, 0, 0),
        bodies,
        (4.2e4, 4.2e4, 2.6e4, 9e3, 9e3, 9e3),
        (101.0,) * 6,
        payload=5.2,
        reach=1.3,
        play=0.004,
    )


def kr15():
    """Arm on a track before a table, by its published rows."""
    table = Joint("E2", 90, 803, 0, -305, offset=-180, speed=60, role="workpiece")
    track = Joint("E1", 90, 0, 0, 0, slides=True, speed=900, role="carriage")
    rows = [(90, 300, 0, -675), (0, 650, 0, 0), (90, 155, 0, 0), (90, 0, 0, -600), (90, 0, 0, 0), (0, 0, 0, -140)]
    arm = _arm(rows, (1, 1, 1, 1, -1, 1), (-180, 0, 90, 0, 180, 0), (152, 152, 152, 284, 293, 604))
    bodies = (Body("A2", 42, (-390, 0, 0)), Body("A3", 48, (-60, 40, 20)), Body("A4", 22, (0, 180, 0)))
    bodies += (Body("A6", 4, (0, 0.0, 60)), Body("A6", 12, (0, -45, -181)))
    return Machine(
        "kr15",
        "arm of 15 kg on a track before a table",
        (table, track, *arm),
        (0, 0, 0, -80, 85, 5, 70, 10),
        (70, 700, 25, 16, 18, 25, 20, 40),
        (0, -41.763657, 415.577926, 0, 0, -159.579784),
        bodies,
        (1e6, 4e7, 4.5e5, 4e5, 2.6e5, 6e4, 5e4, 3e4),
        (120, 0.02, 125, 125, 106, 60, 60, 50),
        payload=16,
        reach=1.6,
    )


def lift_arm():
    """Small fast arm on a column that lifts it."""
    lift = Joint("E1", 0, 0, 0, 250, slides=True, speed=250, role="carriage")
    rows = [(-90, 50, 0, 478), (0, 425, -90, 0), (90, 0, 90, 50), (-90, 0, 0, 425), (90, 0, 0, 0), (0, 0, 0, 100)]
    bodies = (Body("A1", 34, (-25, 40, 0)), Body("A2", 21, (-210, 0, 80)), Body("A3", 14, (0, 0, 60)))
    bodies += (Body("A5", 5, (0, 0, 20)), Body("A6", 3.1, (0, 10, 65)))
    return Machine(
        "lift_arm",
        "small arm on a lifting column",
        (lift, *_arm(rows, speeds=(230, 200, 250, 300, 300, 400))),
        (400, -20, 20, 70, 15, 55, 30),
        (300, 35, 22, 22, 40, 30, 60),
        (0, 30, 140, 0, 20, 0),
        bodies,
        (6e6, 1.6e5, 1.4e5, 8e4, 2.2e4, 1.8e4, 9e3),
        (0.01, 110, 110, 90, 70, 60, 45),
        base=(300, -200, 120, 35, 0, 0),
        payload=3.1,
        reach=1.0,
        play=0.006,
    )


def round_table():
    """One axis: a rotary table with a target on it."""
    return Machine(
        "round_table",
        "rotary table with a target",
        (Joint("A1", 0, 0, 0, 180, speed=90),),
        (0,),
        (170,),
        (450, 0, 120, 0, 0, 0),
        (Body("A1", 60, (40, 0, 30)),),
        (9e5,),
        (180,),
        payload=60,
        reach=0.45,
        play=0.012,
    )


def rail_arm():
    """Handling arm of 210 kg on a rail of five metres."""
    rail = Joint("E1", -90, 0, 90, 0, slides=True, speed=1200, role="carriage")
    rows = [(-90, 350, 0, 675), (0, 1150, 0, 0), (-90, -41, -90, 0), (90, 0, 0, 1200), (-90, 0, 0, 0), (0, 0, 0, 215)]
    bodies = _bodies(350, 1150, 1200, (390, 230, 270, 48), (95, (30, 0, 140)))
    return Machine(
        "rail_arm",
        "arm of 210 kg on a rail",
        (rail, *_arm(rows, (-1, 1, 1, -1, 1, -1), (0, 0, 0, 0, 0, 0), (123, 115, 120, 179, 172, 219))),
        (200, 10, -75, 80, -15, 50, 25),
        (1900, 30, 15, 18, 35, 28, 55),
        (0, 120, 260, 0, 35, 0),
        bodies,
        (5e7, *STIFF),
        (0.03, *GEARS),
        base=(0, -1200, -300, 0, 90, 0),
        payload=95,
        reach=2.7,
    )


def seven():
    """Light arm of seven axes, on a bracket that leans."""
    rows = [
        (-90, 0, 0, 360),
        (90, 0, 0, 0),
        (90, 0, 0, 420),
        (-90, 0, 0, 0),
        (-90, 0, 0, 400),
        (90, 0, 0, 0),
        (0, 0, 0, 152),
    ]
    bodies = (Body("A1", 4, (0, -30, 40)), Body("A2", 4, (0, 0, 60)), Body("A3", 3, (0, 30, 0)))
    bodies += (Body("A4", 2.7, (0, 0, 60)), Body("A5", 1.7, (0, 20, 40)), Body("A6", 1.8, (0, 0, 10)))
    bodies += (Body("A7", 6.4, (10, 0, 60)),)
    return Machine(
        "seven",
        "light arm of seven axes on a leaning bracket",
        _arm(rows, (1, 1, 1, -1, 1, 1, 1), (0,) * 7, (85, 85, 100, 75, 130, 135, 135)),
        (10, 35, -15, 75, 20, 60, 0),
        (35, 20, 35, 20, 40, 22, 60),
        (0, 0, 180, 0, 0, 0),
        bodies,
        (2.6e4, 2.6e4, 2e4, 2e4, 1.2e4, 1e4, 8e3),
        (160,) * 7,
        base=(100, 0, 700, 0, 25, 0),
        payload=6.4,
        reach=0.9,
        play=0.003,
    )


def table_arm():
    """Arm of 60 kg before a turntable."""
    table = Joint("E2", 0, -1500, 0, -550, sign=-1, speed=90, role="workpiece")
    arm = _arm(_elbow(175, 495, 900, 175, 960, 135), (1, 1, 1, 1, 1, 1), (0,) * 6, (175, 175, 175, 250, 250, 360))
    return Machine(
        "table_arm",
        "arm of 60 kg before a turntable",
        (table, *arm),
        (10, 0, 20, 12, 0, 55, 0),
        (110, 22, 16, 16, 30, 28, 60),
        (0, 40, 230, 0, 0, 180),
        _bodies(175, 900, 960, (150, 90, 110, 22), (27, (0, 20, 110))),
        (1.2e6, 9e5, 8e5, 5e5, 1.1e5, 9e4, 4e4),
        (160, *GEARS),
        payload=27,
        reach=2.05,
    )


def scara():
    """Four axes: two that turn level, a quill, its turn."""
    joints = (Joint("A1", 0, 325, 0, 220, speed=300), Joint("A2", 180, 275, 0, 0, speed=400))
    joints += (Joint("A3", 0, 0, 0, 30, slides=True, speed=500), Joint("A4", 0, 0, 0, 60, speed=600))
    bodies = (Body("A1", 9, (-160, 0, 0)), Body("A2", 7, (-120, 0, -60)), Body("A3", 2.5, (0, 0, -40)))
    return Machine(
        "scara",
        "four axes for assembly",
        joints,
        (20, 55, 80, 0),
        (60, 50, 60, 120),
        (20, 0, 60, 0, 0, 180),
        (*bodies, Body("A4", 2, (15, 0, 30))),
        (3.5e4, 2.2e4, 4e6, 5e3),
        (80, 80, 0.016, 30),
        payload=2,
        reach=0.6,
        play=0.004,
    )


def gantry():
    """Three axes that slide, of which the last hangs, and a fork head of two."""
    joints = (
        Joint("A1", -90, 0, 0, 0, slides=True, speed=1000),
        Joint("A2", 90, 0, 90, 0, slides=True, speed=1000),
        Joint("A3", 0, 0, 0, 300, slides=True, speed=600),
        Joint("A4", 90, 0, 0, 900, speed=90),
        Joint("A5", 0, 0, 0, 0, speed=90),
    )
    bodies = (Body("A2", 600, (0, 0, 0)), Body("A3", 180, (0, 0, 300)), Body("A4", 60, (0, 30, 0)))
    return Machine(
        "gantry",
        "gantry with a fork head",
        joints,
        (0, 0, 200, 20, 25),
        (1200, 700, 300, 80, 50),
        (0, -320, 0, 0, 0, 90),
        (*bodies, Body("A5", 35, (0, -120, 15))),
        (6e7, 5e7, 3e7, 4e5, 4e5),
        (0.02, 0.02, 0.01, 90, 90),
        base=(0, 0, 2100, 0, 90, 0),
        payload=35,
        reach=2.5,
        play=0.005,
    )


def level_axis():
    """One axis that lies level and carries a load that is off its centre."""
    return Machine(
        "level_axis",
        "positioner with a level axis",
        (Joint("A1", 0, 0, 0, 220, speed=60, sign=-1, offset=15),),
        (0,),
        (150,),
        (380, 0, 300, 0, 0, 0),
        (Body("A1", 240, (110, 30, 200)),),
        (6e5,),
        (145,),
        base=(0, 0, 900, 0, 90, 0),
        payload=240,
        reach=0.5,
        play=0.02,
    )


DEV = (big_arm, cobot, kr15, lift_arm, round_table)
SEALED = (rail_arm, seven, table_arm, scara, gantry, level_axis)
