"""DEV's machines, after public data sheets: a cobot of 5 kg, a welder on a rail, a small arm that hangs, a handler on a track."""

from __future__ import annotations

from gap.fifth_author.machine import Machine, arm
from gap.second_author.chain import Body, Row, place

__all__ = ["CELLS"]


def cobot():
    """UR5e: its maker's table of rows and masses; strain waves of sizes 25 and 14."""
    numbers = [
        (90, 0, 0, 162.5),
        (0, -425, 0, 0),
        (0, -392.2, 0, 0),
        (90, 0, 0, 133.3),
        (-90, 0, 0, 99.7),
        (0, 0, 0, 99.6),
    ]
    bodies = [
        Body("A1", 3.761, (0, -25.6, 1.9)), Body("A2", 8.058, (212.5, 0, 113.4)), Body("A3", 2.846, (150, 0, 26.5)),
        Body("A4", 1.37, (0, -1.8, 16.3)), Body("A5", 1.3, (0, 1.8, 16.3)), Body("A6", 3.0, (0, 20, 70)),
    ]  # fmt: skip
    return Machine(
        "cobot_5", "a cobot of 5 kg", arm(numbers, [(-360, 360)] * 6, [180] * 6), [10, -80, 95, -105, -90, 20], bodies,
        tool=(0, 0, 140, 0, 0, 0), known=True, payload=3.0, ratio=100, stiffness=(4.4e4, 4.4e4, 3.5e4, 7e3, 7e3, 7e3),
        size=0.13, rated=5, metal=23e-6, foot=4e5,
    )  # fmt: skip


def welder():
    """IRB 1600-10/1.45 on a rail of 4 m."""
    numbers = [(-90, 150, 0, 486.5), (0, 700, -90, 0), (-90, 0, 0, 0), (90, 0, 0, 600), (-90, 0, 0, 0), (0, 0, 180, 65)]
    ranges = [(-180, 180), (-90, 150), (-245, 65), (-200, 200), (-115, 115), (-400, 400)]
    rail = Row("E1", 90, 0, kind="P", low=-2000, high=2000, speed=1200)
    bodies = [
        Body("A1", 90, (-60, 40, 20)), Body("A2", 48, (-360, 0, -80)), Body("A3", 36, (-10, -20, 90)),
        Body("A4", 15, (0, 0, -150)), Body("A5", 4, (0, 0, 20)), Body("A6", 6, (30, 0, 90)),
    ]  # fmt: skip
    return Machine(
        "welder_rail", "a welding arm of 10 kg on a rail", [rail, *arm(numbers, ranges, (180, 180, 185, 385, 400, 460))],
        [0, 5, 10, 15, 10, 60, 0], bodies, base=place(z=420, a=-90, c=-90), tool=(25, 0, 330, 0, 35, 0), known=True,
        payload=6.0, ratio=81, stiffness=(3.5e5, 3.5e5, 2.2e5, 3e4, 2.5e4, 1.5e4), size=0.22, rated=10, foot=2.5e6,
    )  # fmt: skip


def hung():
    """KR 10 R1100 under a frame, its foot up; no masses told."""
    numbers = [(-90, 25, 0, 400), (0, 560, 0, 0), (-90, 35, -90, 0), (90, 0, 0, 515), (-90, 0, 0, 0), (0, 0, 0, 80)]
    ranges = [(-170, 170), (-190, 45), (-120, 156), (-185, 185), (-120, 120), (-350, 350)]
    bodies = [
        Body("A1", 17, (-10, 60, 10)), Body("A2", 13, (-290, 0, -60)), Body("A3", 9, (-10, 0, 60)),
        Body("A4", 3.5, (0, 10, -90)), Body("A5", 1.5, (0, 0, 10)), Body("A6", 4.5, (0, 25, 60)),
    ]  # fmt: skip
    return Machine(
        "hung_10", "a small arm under a frame", arm(numbers, ranges, (300, 225, 225, 380, 310, 490), (-1, 1, 1, -1, 1, -1)),
        [10, -70, 100, 5, -50, 0], bodies, base=place(x=300, z=2400, c=180), tool=(0, 40, 160, 0, 0, 0), payload=4.5, ratio=101,
        stiffness=(1.2e5, 1.3e5, 7e4, 1e4, 9e3, 6e3), size=0.14, rated=10, metal=20e-6, foot=6e5,
    )  # fmt: skip


def handler():
    """KR 210 R2700 on a linear unit of 6 m."""
    numbers = [
        (-90, 350, 0, 675),
        (0, 1150, 0, 0),
        (-90, -41, -90, 0),
        (90, 0, 0, 1200),
        (-90, 0, 0, 0),
        (0, 0, 0, 215),
    ]
    ranges = [(-185, 185), (-140, -5), (-120, 155), (-350, 350), (-122, 122), (-350, 350)]
    unit = Row("E1", 90, 0, kind="P", low=-3000, high=3000, speed=1500)
    bodies = [
        Body("A1", 380, (-180, 90, 20)), Body("A2", 210, (-570, 0, -200)), Body("A3", 190, (-30, -40, 190)),
        Body("A4", 95, (0, 30, -350)), Body("A5", 35, (0, 0, 30)), Body("A6", 130, (90, 0, 210)),
    ]  # fmt: skip
    return Machine(
        "handler_210", "a handler of 210 kg on a track", [unit, *arm(numbers, ranges, (123, 115, 112, 179, 172, 219))],
        [0, -5, -75, 80, 0, 55, 0], bodies, base=place(z=550, a=-90, c=-90), tool=(150, 0, 420, 0, 0, 0), known=True,
        payload=130.0, ratio=120, stiffness=(3.0e6, 3.3e6, 2.6e6, 5.5e5, 4.8e5, 3.9e5), size=0.4, rated=210, foot=3.5e7,
    )  # fmt: skip


CELLS = {"cobot": cobot, "welder": welder, "hung": hung, "handler": handler}
