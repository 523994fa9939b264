"""Seven machines and the KR15: a palletiser, a SCARA, an arm on a rotary base, a gantry, a cobot, a lathe's arm, a painter."""

from __future__ import annotations

from gap.second_author.chain import Body, Row, place
from gap.second_author.kr15 import kr15
from gap.third_author.machines import Machine


def palletiser():
    """Four driven axes for 150 kg; rods hold the hand level, which a serial chain says by a fifth that follows two others."""
    rows = [
        Row("A1", -90, 270, d=880, low=-160, high=160, speed=110),
        Row("A2", 0, 1050, theta=-90, low=-60, high=80, speed=100),
        Row("A3", 0, 1200, theta=90, low=-80, high=70, speed=110),
        Row("A4", -90, 230, low=-110, high=110, speed=130),
        Row("A5", 0, 0, d=260, low=-300, high=300, speed=250),
    ]
    bodies = [
        Body("A1", 420, (-180, 60, 30)),
        Body("A2", 190, (-560, 0, -90)),
        Body("A3", 160, (-700, -40, 70)),
        Body("A4", 45, (-70, 0, 20)),
        Body("A5", 85, (30, -20, 120)),
    ]
    return Machine(
        "palletiser_150", "a palletiser whose rods keep the hand level", rows, [8, 12, 4, -16, 20], bodies,
        tool=(180, -60, 310, 0, 0, 15), known=True, payload=85, ratio=171, level=(0, 1, 1, 1, 0),
    )  # fmt: skip


def scara():
    """A SCARA with its ball screw spindle, which slides and turns; no masses told."""
    rows = [
        Row("A1", 0, 350, d=415, low=-140, high=140, speed=400),
        Row("A2", 180, 300, low=-145, high=145, speed=650),
        Row("A3", 0, 0, kind="P", low=0, high=240, speed=1000),
        Row("A4", 0, 0, d=40, low=-350, high=350, speed=1500),
    ]
    bodies = [
        Body("A1", 11, (-160, 10, 20)),
        Body("A2", 9, (-140, 0, 60)),
        Body("A3", 2.5, (0, 0, -60)),
        Body("A4", 3, (12, 0, 40)),
    ]
    return Machine(
        "scara_650", "a SCARA of 650 mm", rows, [20, 70, 110, -30], bodies, tool=(45, 10, 90, 0, 0, 0), payload=3, ratio=80
    )  # fmt: skip


def rotary_base():
    """A small arm that rides half a metre off the middle of a turning base, masses told."""
    rows = [
        Row("E2", 0, 520, d=240, low=-180, high=180, speed=60),
        Row("A1", 90, 30, d=345, low=-170, high=170, speed=250),
        Row("A2", 0, 340, theta=90, low=-110, high=100, speed=250, sign=-1),
        Row("A3", 90, 40, low=-80, high=130, speed=280),
        Row("A4", -90, 0, d=338, low=-190, high=190, speed=380),
        Row("A5", 90, 0, low=-120, high=120, speed=380),
        Row("A6", 0, 0, d=86.5, low=-350, high=350, speed=500),
    ]
    bodies = [
        Body("E2", 140, (-380, 0, -120)),
        Body("A2", 8.5, (-190, 0, 25)),
        Body("A3", 7, (-20, 10, 40)),
        Body("A4", 2.6, (0, 10, -90)),
        Body("A6", 4.2, (15, 0, 60)),
    ]
    return Machine(
        "arm_on_rotary_base", "a small arm on a rotary base", rows, [10, -15, 20, 10, 15, 50, 0], bodies,
        tool=(0, -70, 130, 0, 20, 0), known=True, payload=4, ratio=121,
    )  # fmt: skip


def gantry():
    """Two rails over the hall and an arm that hangs from them; no masses told."""
    rows = [
        Row("E1", -90, 0, kind="P", low=-2500, high=2500, speed=900),
        Row("E2", 90, 0, theta=90, kind="P", low=-1200, high=1200, speed=900),
        Row("A1", -90, 180, d=430, low=-170, high=170, speed=170),
        Row("A2", 0, 610, theta=-90, low=-80, high=130, speed=160),
        Row("A3", -90, 130, low=-150, high=80, speed=170),
        Row("A4", 90, 0, d=640, low=-200, high=200, speed=300),
        Row("A5", -90, 0, low=-130, high=130, speed=300),
        Row("A6", 0, 0, d=110, low=-350, high=350, speed=420),
    ]
    bodies = [
        Body("E1", 900, (-200, 100, 0)),
        Body("E2", 260, (0, -100, 0)),
        Body("A2", 52, (-330, 0, 30)),
        Body("A3", 41, (-40, 20, 60)),
        Body("A4", 16, (0, 10, -200)),
        Body("A6", 9, (0, 20, 80)),
    ]
    return Machine(
        "gantry_arm", "an arm that hangs from a gantry", rows, [150, -80, 15, 25, -10, 20, 60, 0], bodies,
        base=place(z=3100, b=90), tool=(50, 0, 190, 0, -25, 0), payload=9, ratio=141,
    )  # fmt: skip


def cobot():
    """Seven axes whose elbow and wrist stand aside of their lines, with torque sensors, masses told."""
    rows = [
        Row("A1", 0, 0, d=333, low=-160, high=160, speed=110),
        Row("A2", -90, 0, low=-100, high=100, speed=110),
        Row("A3", 90, 0, d=316, low=-160, high=160, speed=110),
        Row("A4", 90, 82.5, low=-172, high=-6, speed=110),
        Row("A5", -90, -82.5, d=384, low=-160, high=160, speed=150),
        Row("A6", 90, 0, low=-1, high=212, speed=150),
        Row("A7", 90, 88, d=107, low=-165, high=165, speed=150),
    ]
    bodies = [
        Body("A2", 4.6, (0, -70, 40)),
        Body("A3", 3.3, (30, 35, -70)),
        Body("A4", 3.4, (-40, 60, 25)),
        Body("A5", 1.9, (0, 35, -140)),
        Body("A6", 1.6, (50, -10, -10)),
        Body("A7", 2.4, (10, 0, 30)),
    ]
    return Machine(
        "cobot_sensors", "seven axes with torque sensors", rows, [5, 10, -5, -110, 8, 115, 30], bodies, modified=True,
        tool=(0, 35, 105, 45, 0, 0), known=True, payload=2, ratio=100, sensors=True,
    )  # fmt: skip


def lathe_arm():
    """An arm that works on what a face plate turns before it: masses told, the table carries the part."""
    rows = [
        Row("A1", -90, 175, theta=180, d=495, low=-165, high=165, speed=175),
        Row("A2", 0, 900, theta=-90, low=-85, high=145, speed=170),
        Row("A3", -90, 175, low=-170, high=70, speed=175),
        Row("A4", 90, 0, d=960, low=-280, high=280, speed=250),
        Row("A5", -90, 0, low=-125, high=125, speed=250),
        Row("A6", 0, 0, theta=180, d=135, low=-390, high=390, speed=360),
    ]
    bodies = [
        Body("A2", 74, (-420, 10, -110)),
        Body("A3", 63, (-50, -15, 120)),
        Body("A4", 24, (0, 20, -180)),
        Body("A6", 21, (0, -30, 150)),
    ]
    return Machine(
        "lathe_arm", "an arm before a face plate", rows, [-6, 10, 12, 5, 50, -10], bodies, base=place(x=1450, z=-280),
        tool=(-90, 0, 260, 0, 0, 25), known=True, payload=20, ratio=153, table="E2", table_row=(1450, -280),
    )  # fmt: skip


def painter():
    """A long arm whose three wrist axes cross at 55 degrees, a hollow hand for hoses; no masses told."""
    rows = [
        Row("A1", 90, 300, d=760, low=-150, high=150, speed=120),
        Row("A2", 0, 1100, theta=90, low=-80, high=100, speed=120),
        Row("A3", 90, 60, low=-90, high=100, speed=120),
        Row("A4", 55, 0, d=1180, low=-400, high=400, speed=370),
        Row("A5", -55, 0, d=95, low=-400, high=400, speed=370),
        Row("A6", 0, 0, d=120, low=-400, high=400, speed=480),
    ]
    bodies = [
        Body("A2", 96, (-520, 0, 60)),
        Body("A3", 70, (-30, 10, 90)),
        Body("A4", 31, (0, -10, -320)),
        Body("A5", 8, (0, 0, 20)),
        Body("A6", 7, (20, 10, 70)),
    ]
    return Machine(
        "painter", "a long arm with a hollow skew wrist", rows, [0, -10, -15, 20, 70, 10], bodies,
        tool=(70, 0, 240, 0, 40, 0), payload=7, ratio=128,
    )  # fmt: skip


CELLS = {
    "kr15": (kr15, 0.12),
    "palletiser": (palletiser, 0.14),
    "scara": (scara, 0.1),
    "rotary_base": (rotary_base, 0.13),
    "gantry": (gantry, 0.12),
    "cobot": (cobot, 0.14),
    "lathe": (lathe_arm, 0.13),
    "painter": (painter, 0.12),
}
