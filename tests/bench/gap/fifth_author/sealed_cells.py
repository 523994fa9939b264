"""SEALED's machines, after public data sheets: another cobot, a press tender, an arm on a rail, one under a rail, a column."""

from __future__ import annotations

from gap.fifth_author.machine import Machine, arm
from gap.second_author.chain import Body, Row, place

__all__ = ["CELLS"]


def collaborator():
    """TM5-900 on a sloping bracket; no masses told."""
    numbers = [
        (-90, 0, 0, 145.2), (0, 429, -90, 0), (0, 411.5, 0, 0), (90, 0, 90, -122.2), (90, 0, 0, 106), (0, 0, 0, 114.4),
    ]  # fmt: skip
    ranges = [(-270, 270), (-180, 180), (-155, 155), (-180, 180), (-180, 180), (-270, 270)]
    bodies = [
        Body("A1", 4.2, (0, 20, -10)), Body("A2", 8.4, (-215, 0, -120)), Body("A3", 3.9, (-160, 0, -30)),
        Body("A4", 1.6, (0, 0, 15)), Body("A5", 1.6, (0, 0, 15)), Body("A6", 2.2, (15, 0, 60)),
    ]  # fmt: skip
    return Machine(
        "cobot_bracket", "a cobot on a sloping bracket", arm(numbers, ranges, (180, 180, 180, 225, 225, 225)),
        [15, 20, 85, -15, 85, 0], bodies, base=place(x=-200, z=900, b=30), tool=(40, 0, 110, 0, 0, 0), payload=2.2, ratio=101,
        stiffness=(4.0e4, 4.0e4, 2.4e4, 6e3, 6e3, 6e3), size=0.12, rated=4, metal=23e-6, foot=3e5,
    )  # fmt: skip


def tender():
    """R-2000iC/165F, bolted to the floor."""
    numbers = [
        (-90, 312, 0, 670),
        (0, 1075, -90, 0),
        (-90, 225, 0, 0),
        (90, 0, 0, 1280),
        (-90, 0, 0, 0),
        (0, 0, 0, 215),
    ]
    ranges = [(-185, 185), (-60, 76), (-132, 100), (-360, 360), (-125, 125), (-360, 360)]
    bodies = [
        Body("A1", 300, (-150, 80, 20)), Body("A2", 230, (-540, 0, -60)), Body("A3", 210, (-80, -10, 150)),
        Body("A4", 80, (0, 20, -380)), Body("A5", 40, (0, 0, 20)), Body("A6", 95, (-40, 60, 180)),
    ]  # fmt: skip
    return Machine(
        "press_tender", "a tender of 165 kg at a press",
        arm(numbers, ranges, (130, 115, 125, 180, 180, 260), (1, 1, -1, 1, -1, 1)),
        [-20, 10, -5, 10, -65, 0], bodies, tool=(0, 180, 360, 0, 0, 0), known=True, payload=95.0, ratio=144,
        stiffness=(2.6e6, 3.0e6, 2.2e6, 5e5, 4e5, 3e5), size=0.35, rated=165, foot=4e7,
    )  # fmt: skip


def railed():
    """GP25 on a rail of 5 m across its view."""
    numbers = [(-90, 150, 0, 505), (0, 760, -90, 0), (-90, 200, 0, 0), (90, 0, 0, 1082), (-90, 0, 0, 0), (0, 0, 0, 100)]
    ranges = [(-180, 180), (-105, 155), (-86, 160), (-200, 200), (-150, 150), (-455, 455)]
    rail = Row("E1", 90, 0, kind="P", low=-2500, high=2500, speed=1000)
    bodies = [
        Body("A1", 75, (-60, 50, 20)), Body("A2", 55, (-380, 0, -90)), Body("A3", 60, (-60, -20, 100)),
        Body("A4", 26, (0, 10, -320)), Body("A5", 7, (0, 0, 10)), Body("A6", 14, (20, -30, 110)),
    ]  # fmt: skip
    return Machine(
        "arm_25_rail", "an arm of 25 kg on a rail", [rail, *arm(numbers, ranges, (210, 210, 265, 420, 420, 885))],
        [0, 10, 5, 5, -10, 55, 10], bodies, base=place(x=-900, z=380, c=-90), tool=(0, -60, 240, 0, 0, 0), payload=14.0,
        known=True, ratio=129, stiffness=(8e5, 9e5, 5e5, 8e4, 7e4, 5e4), size=0.25, rated=25, foot=6e6,
    )  # fmt: skip


def under_rail():
    """TX2-90 under a rail of 3 m over the work."""
    numbers = [(-90, 50, 0, 478), (0, 425, -90, 0), (90, 0, 90, 50), (-90, 0, 0, 425), (90, 0, 0, 0), (0, 0, 0, 100)]
    ranges = [(-180, 180), (-130, 147), (-145, 145), (-270, 270), (-115, 140), (-270, 270)]
    rail = Row("E1", 90, 0, kind="P", low=-1500, high=1500, speed=1500)
    bodies = [
        Body("A1", 30, (-20, 40, 10)), Body("A2", 27, (-210, 0, 90)), Body("A3", 16, (0, -40, 20)),
        Body("A4", 9, (0, -60, 0)), Body("A5", 3, (0, 0, 20)), Body("A6", 5, (0, 30, 80)),
    ]  # fmt: skip
    return Machine(
        "arm_under_rail", "an arm under a rail", [rail, *arm(numbers, ranges, (400, 400, 430, 540, 475, 760))],
        [0, 10, 30, 60, 10, -60, 0], bodies, base=place(z=2900, a=180, c=90), tool=(30, 0, 150, 0, 0, 0), payload=5.0,
        ratio=97, stiffness=(2.2e5, 2.0e5, 1.1e5, 2e4, 1.6e4, 1e4), size=0.14, rated=11, foot=1.2e6,
    )  # fmt: skip


def column():
    """A bench robot on a post: a lift and three axes that turn level, as a PreciseFlex 400 has them."""
    lift = Row("E1", 0, 0, kind="P", low=0, high=400, speed=500)
    level = [(0, 225, 0, 120), (0, 210, 0, 30), (180, 0, 0, 40)]
    bodies = [
        Body("E1", 9, (30, 0, 40)),
        Body("A1", 4, (-110, 0, 10)),
        Body("A2", 3, (-90, 0, 0)),
        Body("A3", 1.0, (0, 20, 30)),
    ]
    return Machine(
        "column_400", "a lift that carries three level axes",
        [lift, *arm(level, [(-95, 95), (10, 170), (-350, 350)], (360, 500, 720))],
        [180, -20, 70, 30], bodies, base=place(z=80), tool=(0, 45, 60, 0, 0, 0), payload=1.0, ratio=60,
        stiffness=(6e3, 4e3, 2e3), size=0.1, rated=1, metal=23e-6, foot=8e4,
    )  # fmt: skip


CELLS = {"collaborator": collaborator, "tender": tender, "railed": railed, "under_rail": under_rail, "column": column}
