"""Cells of the development family: the KR15's, a bare arm off a data sheet, a UR10-like arm, a small arm on a lift column."""

from __future__ import annotations

from gap.second_author.chain import Body, Robot, Row
from gap.second_author.kr15 import kr15


def bare():
    """A six-axis arm of 1.45 m reach off a data sheet: no masses told."""
    rows = [
        Row("A1", -90, 150, d=486.5, high=170, speed=170),
        Row("A2", 0, 700, theta=-90, low=-70, high=120),
        Row("A3", -90, 115, low=-120, high=60),
        Row("A4", 90, 0, d=600, low=-180, high=180, speed=280),
        Row("A5", -90, 0, low=-112, high=112, speed=280),
        Row("A6", 0, 0, theta=180, d=65, low=-350, high=350, speed=400),
    ]
    bodies = [
        Body("A2", 60, (-380, 0, 40)),
        Body("A3", 45, (-20, 0, 90)),
        Body("A4", 14, (0, 0, 0)),
        Body("A6", 7, (20, 0, 90)),
    ]
    return Robot(
        "bare_sheet", "a bare arm off a data sheet", rows, [0, 20, 10, 0, 50, 0], bodies, tool=(60, 0, 150, 0, 0, 0)
    )


def ur10_like():
    """An arm whose wrist is not spherical; harmonic gears, no masses told."""
    rows = [
        Row("A1", 90, 0, d=127.3, low=-180, high=180, speed=100),
        Row("A2", 0, -612, low=-180, high=0, speed=100),
        Row("A3", 0, -572.3, low=-150, high=150, speed=120),
        Row("A4", 90, 0, d=163.941, low=-180, high=180, speed=160),
        Row("A5", -90, 0, d=115.7, low=-180, high=180, speed=160),
        Row("A6", 0, 0, d=92.2, low=-180, high=180, speed=160),
    ]
    bodies = [
        Body("A2", 12.5, (230, 0, 158)),
        Body("A3", 3.9, (180, 0, 68)),
        Body("A4", 2.0, (0, 7, 0)),
        Body("A5", 2.0, (0, -7, 0)),
        Body("A6", 3.4, (0, 0, 40)),
    ]
    return Robot(
        "ur10_like", "an arm with an offset wrist", rows, [20, -80, 95, -100, -85, 10], bodies,
        tool=(0, 40, 110, 0, 0, 0), payload=3,
    )  # fmt: skip


def column():
    """A small arm on a lift column (E1 along z), masses told."""
    rows = [
        Row("E1", 0, 120, kind="P", low=0, high=900, speed=250),
        Row("A1", -90, 25, d=400, high=170, speed=300),
        Row("A2", 0, 315, theta=-90, low=-100, high=110, speed=260),
        Row("A3", -90, 35, low=-120, high=90, speed=300),
        Row("A4", 90, 0, d=365, low=-185, high=185, speed=380),
        Row("A5", -90, 0, low=-120, high=120, speed=380),
        Row("A6", 0, 0, theta=180, d=80, low=-350, high=350, speed=460),
    ]
    bodies = [
        Body("E1", 60, (-60, 0, 0)),
        Body("A2", 9.5, (-170, 0, 30)),
        Body("A3", 8.0, (-10, 0, 60)),
        Body("A4", 3.0, (0, 0, -20)),
        Body("A6", 2.5, (0, 15, 70)),
    ]
    return Robot(
        "column_arm", "a small arm on a lift column", rows, [400, 0, 15, 15, 0, 55, 0], bodies, tool=(0, 30, 120, 0, 0, 0),
        known=True, payload=2.5,
    )  # fmt: skip


CELLS = {"kr15": (kr15, 0.42), "bare": (bare, 0.2), "ur10": (ur10_like, 0.2), "column": (column, 0.18)}
