"""Cells of the sealed family: the KR15, a heavy arm on a track, masses told, seven axes, an offset wrist, a column alone."""

from __future__ import annotations

from gap.second_author.chain import Body, Robot, Row, place
from gap.second_author.kr15 import kr15


def heavy():
    """An arm for 300 kg on a track of 6 m along y, masses told."""
    rows = [
        Row("E1", 90, 0, kind="P", low=-3000, high=3000, speed=1500),
        Row("A1", -90, 500, d=860, high=185, low=-185, speed=70),
        Row("A2", 0, 1250, theta=-90, low=-40, high=110, speed=60),
        Row("A3", -90, 150, low=-150, high=70, speed=65),
        Row("A4", 90, 0, d=1039.5, low=-350, high=350, speed=90),
        Row("A5", -90, 0, low=-120, high=120, speed=90),
        Row("A6", 0, 0, theta=180, d=286, low=-350, high=350, speed=140),
    ]
    bodies = [
        Body("A1", 588, (-330, 120, 60)),
        Body("A2", 318, (-640, 0, -180)),
        Body("A3", 288, (-40, -20, 230)),
        Body("A4", 92, (0, 60, 20)),
        Body("A6", 70, (0, 10, -40)),
        Body("A6", 160, (40, 0, 220)),
    ]
    return Robot(
        "heavy_on_track", "a heavy arm on a track", rows, [0, 0, 20, 0, 0, 60, 0], bodies, base=place(-1500, 200, 350, 0, 0, -90),
        tool=(120, 0, 480, 0, 35, 0), known=True, payload=160, ratio=220,
    )  # fmt: skip


def told():
    """An arm of the 1.7 m class in Craig's rows, masses told, a sign turned."""
    rows = [
        Row("A1", 0, 0, d=550, high=160, low=-160, speed=190),
        Row("A2", -90, 150, theta=-90, low=-100, high=130, speed=190, sign=-1),
        Row("A3", 0, 825, theta=90, low=-140, high=140, speed=240),
        Row("A4", 90, 0, d=625, low=-265, high=265, speed=300),
        Row("A5", -90, 0, low=-105, high=115, speed=340),
        Row("A6", 90, 0, d=110, low=-265, high=265, speed=500),
    ]
    bodies = [
        Body("A2", 71, (380, 10, 60)),
        Body("A3", 27, (10, -60, 0)),
        Body("A4", 38, (0, 0, -190)),
        Body("A5", 3, (0, -20, 0)),
        Body("A6", 11, (15, 0, 95)),
    ]
    return Robot(
        "told_masses", "an arm with its masses", rows, [10, -25, 75, 0, 60, 0], bodies, modified=True, known=True, payload=10,
        tool=(0, 90, 210, 0, -20, 0), ratio=130,
    )  # fmt: skip


def seven():
    """Seven axes with strain wave gears."""
    rows = [
        Row("A1", 0, 0, d=340, low=-165, high=165, speed=90),
        Row("A2", -90, 0, low=-115, high=115, speed=90),
        Row("A3", 90, 0, d=400, low=-165, high=165, speed=95),
        Row("A4", 90, 0, low=-115, high=115, speed=125),
        Row("A5", -90, 0, d=400, low=-165, high=165, speed=135),
        Row("A6", -90, 0, low=-115, high=115, speed=130),
        Row("A7", 90, 0, d=152, low=-170, high=170, speed=130),
    ]
    bodies = [
        Body("A2", 6.5, (0, -60, 60)),
        Body("A3", 3.5, (0, 30, -130)),
        Body("A4", 3.5, (0, 60, 30)),
        Body("A5", 3.0, (0, 20, -110)),
        Body("A6", 2.0, (0, 0, 10)),
        Body("A7", 4.5, (20, 0, 60)),
    ]
    return Robot(
        "seven_axes", "an arm of seven axes", rows, [10, 35, -5, -75, 10, 55, 20], bodies, modified=True, known=True, payload=4,
        tool=(25, 0, 140, 0, 0, 0), ratio=160,
    )  # fmt: skip


def offset_wrist():
    """A collaborative arm whose hand has its axes 150 mm apart, no masses told."""
    rows = [
        Row("A1", 0, 0, d=245, low=-180, high=180, speed=110),
        Row("A2", -90, 0, theta=-90, low=-150, high=150, speed=110),
        Row("A3", 0, 540, low=-160, high=160, speed=150),
        Row("A4", -90, 0, d=540, low=-180, high=180, speed=170),
        Row("A5", 90, 0, d=150, low=-170, high=170, speed=170),
        Row("A6", -90, 0, d=160, low=-180, high=180, speed=170),
    ]
    bodies = [
        Body("A2", 11, (240, 0, -130)),
        Body("A3", 6, (20, -60, -20)),
        Body("A4", 4, (0, 0, -80)),
        Body("A5", 3, (0, 10, -20)),
        Body("A6", 6, (0, 25, 60)),
    ]
    return Robot(
        "offset_wrist", "an arm with an offset wrist", rows, [0, 25, 20, 10, 60, 15], bodies, modified=True, payload=5,
        tool=(-30, 0, 120, 0, 0, 0), ratio=101,
    )  # fmt: skip


def lone_column():
    """A lift column that turns a boom: no arm."""
    rows = [
        Row("E1", 0, 0, kind="P", low=0, high=1600, speed=400),
        Row("A1", 0, 0, d=300, low=-175, high=175, speed=60),
    ]
    bodies = [Body("E1", 140, (-90, 0, 150)), Body("A1", 35, (260, 0, 20))]
    return Robot(
        "lone_column", "a lift column with a boom", rows, [800, 0], bodies, tool=(640, 30, -80, 0, 70, 0), known=True, payload=8,
    )  # fmt: skip


CELLS = {
    "kr15": (kr15, 0.4),
    "heavy": (heavy, 0.13),
    "told": (told, 0.15),
    "seven": (seven, 0.12),
    "offset_wrist": (offset_wrist, 0.12),
    "column": (lone_column, 0.08),
}
