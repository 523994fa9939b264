"""Ordinary six-axis arms in four classes of payload, one on a track, one with a rotary table; and the shipped KR15 cell."""

from __future__ import annotations

from dataclasses import dataclass

from gap.second_author.chain import Body, Robot, Row, place
from gap.second_author.kr15 import kr15

__all__ = ["MACHINES", "STIFFNESS", "Tabled", "heavy", "light", "middle", "strong"]

TABLE = ("E2", -1250.0, -250.0)  # the table's name, and the foot seen from its axis: x and z in mm
# Nm/rad of A1 to A6, by class: round numbers about those that clamping tests of such arms find
STIFFNESS = {
    "light": (2e5, 2e5, 1.2e5, 2e4, 1.5e4, 1e4),
    "middle": (6e5, 6e5, 4e5, 6e4, 5e4, 3e4),
    "kr15": (6e5, 6e5, 4e5, 6e4, 5e4, 3e4),
    "strong": (1.5e6, 1.6e6, 1.1e6, 2.5e5, 2e5, 1.2e5),
    "heavy": (3.5e6, 4e6, 3e6, 7e5, 6e5, 4e5),
}


@dataclass
class Tabled(Robot):
    """An arm beside a rotary table on whose axis world stands; the table is the first joint of the chain."""

    def _toml(self):
        name, x, z = TABLE
        head = ["[kinematics]", "base_follows_table = true", "characteristic_length_mm = 500"]
        head += ["base_to_first = [0, 0, 0, 0, 0, 0]", "foot_to_root = [0, 0, 0, 0, 0, 0]"]
        head += ["wrist_to_flange = [0, 0, 0, 0, 0, 0]", 'standing = "datasheet"', ""]
        head += ["[[joint]]", f'name = "{name}"', 'role = "workpiece"', 'type = "revolute"']
        head += [f"dh = {{ alpha_deg = 0, a_mm = {x}, theta_deg = 0, d_mm = {z} }}"]
        head += ["axis = { sign = 1, offset_deg = 0 }", "limits = { endless = true }", 'standing = "datasheet"', ""]
        return super()._toml().replace("[arm]", "\n".join(head) + "\n[arm]", 1)

    def write(self, folder):
        """The cell's folder; its poses are those of the table at zero."""
        super().write(folder)
        path = folder / "poses.csv"
        first, *rest = path.read_text().splitlines()
        rows = [first.replace("name,", f"name,{TABLE[0]}_deg,", 1)]
        rows += [r.replace(",", ",0.000000,", 1) for r in rest]
        path.write_text("\n".join(rows) + "\n")


def _rows(rise, shoulder, upper, elbow, fore, hand, speed, signs=(1, 1, 1, 1, 1, 1)):
    """An arm with a spherical wrist; at zero the upper arm stands up and the forearm points ahead (mm, degrees a second)."""
    numbers = [(-90, shoulder, 0, rise), (0, upper, -90, 0), (-90, elbow, 0, 0), (90, 0, 0, fore), (-90, 0, 0, 0)]
    numbers.append((0, 0, 0, hand))
    low, high = (-170, -80, -70, -180, -115, -350), (170, 100, 140, 180, 115, 350)
    rows = []
    for k, (alpha, a, theta, d) in enumerate(numbers):
        fast = speed * (1 if k < 3 else 1.5)
        rows.append(Row(f"A{k + 1}", alpha, a, theta, d, sign=signs[k], low=low[k], high=high[k], speed=fast))
    return rows


def _bodies(masses, upper, fore, tool):
    """Masses of upper arm, forearm, wrist and tool with centres where castings have them (kg, mm)."""
    turn, reach, wrist = masses
    return [
        Body("A2", turn, (-0.55 * upper, 0.0, 0.0)),
        Body("A3", reach, (0.0, 0.0, 0.2 * fore)),
        Body("A5", wrist, (0.0, 0.0, 0.0)),
        Body("A6", tool, (20.0, 0.0, 90.0)),
    ]


HOME = [0.0, 10.0, 15.0, 0.0, 50.0, 0.0]


def light():
    """6 kg class."""
    rows = _rows(450, 80, 600, 40, 620, 90, 220)
    return Robot(
        "arm_6", "an arm of 6 kg", rows, HOME, _bodies((9, 7, 2.5), 600, 620, 4), tool=(15, 0, 120, 0, 0, 0), payload=4
    )


def middle():
    """20 kg class, beside a rotary table."""
    rows = _rows(500, 150, 800, 120, 850, 110, 170)
    return Tabled(
        "arm_20", "an arm of 20 kg and a table", rows, HOME, _bodies((40, 35, 10), 800, 850, 15),
        base=place(x=TABLE[1], z=TABLE[2]), tool=(0, 30, 210, 0, 0, 0), known=True, payload=15, table=TABLE[0],
    )  # fmt: skip


def strong():
    """60 kg class; two of its axes count backwards."""
    rows = _rows(600, 300, 1000, 200, 1150, 180, 130, signs=(-1, 1, 1, -1, 1, -1))
    return Robot(
        "arm_60", "an arm of 60 kg", rows, HOME, _bodies((110, 95, 30), 1000, 1150, 40),
        tool=(60, 0, 280, 0, 30, 0), known=True, payload=40,
    )  # fmt: skip


def heavy():
    """200 kg class on a track of 5 m."""
    track = Row("E1", 90, 0, kind="P", low=-2500, high=2500, speed=1000)
    rows = [track, *_rows(750, 350, 1150, -50, 1300, 240, 100)]
    # A track along x of world; the turn of its row puts the z axis of the foot up again.
    base = place(z=300, a=-90, c=-90)
    return Robot(
        "arm_200", "an arm of 200 kg on a track", rows, [0.0, *HOME], _bodies((280, 240, 80), 1150, 1300, 140),
        base=base, tool=(120, 0, 350, 0, 45, 0), payload=140,
    )  # fmt: skip


MACHINES = {"light": light, "middle": middle, "strong": strong, "heavy": heavy, "kr15": kr15}
