"""The KR15 cell, the one that both families have."""

from __future__ import annotations

import numpy as np

from gap.second_author.chain import Body, Robot, Row, place, turned


def kr15():
    """The KR15 on its track, in world: the table does not carry the tool. Numbers of the paper's Table 1."""
    rows = [
        Row("E1", 90, 0, kind="P", low=-1500, high=1500, speed=800),
        Row("A1", 90, 300, d=-675, offset=-180),
        Row("A2", 0, 650, low=-145, high=25),
        Row("A3", 90, 155, offset=90, low=-120, high=160),
        Row("A4", 90, 0, d=-600, low=-350, high=350, speed=280),
        Row("A5", 90, 0, sign=-1, offset=180, low=-135, high=135, speed=290),
        Row("A6", 0, 0, d=-140, low=-350, high=350, speed=600),
    ]
    bodies = [
        Body("A2", 42, (-390, 0, 0)),
        Body("A3", 48, (-60, 40, 20)),
        Body("A4", 22, (0, 180, 0)),
        Body("A6", 4, (0, 0.043, 60.482)),
        Body("A6", 12, (0, -45.357, -181.569)),
    ]
    table = turned(2, np.pi) @ place(x=803, z=-305) @ turned(0, np.pi / 2)
    return Robot(
        "kr15_track_table", "the KR15 cell", rows, [0, 0, -90, 90, 0, 80, 0], bodies, base=table,
        flange=place(c=180), tool=(0, -41.763657, 415.577926, 0, 0, -159.579784),
        known=True, payload=12, copied="kr15_track_table", table="E2",
    )  # fmt: skip
