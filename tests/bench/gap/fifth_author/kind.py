"""What a family of this author's is made of, and which case is about what."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

__all__ = ["THEMES", "Kind", "theme"]

# fifty cases: what each is about first; others may be at work beside it
THEMES = {
    "payload": 8, "track": 8, "thermal_drift": 7, "measurement_drift": 2, "joint_offset": 4, "geometry": 4, "servo_lag": 2,
    "friction": 1, "backlash": 2, "joint_compliance": 1, "none": 5, "foreign": 6,
}  # fmt: skip


@dataclass(frozen=True)
class Kind:
    """A family.

    first: its first seed, from which fifty count. warm: the procedure of hours. on_track: those that need a carriage.
    six: those that need six axes. mornings: each log of hours begins
    with a cold machine; else it goes on where the last ended. sigma: mm.
    """

    name: str
    first: int
    cells: dict[str, Callable]
    known: dict
    foreign: list
    leftover: Callable
    drive_leftover: Callable
    poses: dict[str, Callable]
    paths: dict[str, Callable]
    warm: str
    on_track: tuple[str, ...]
    six: tuple[str, ...]
    mornings: bool
    sigma: tuple[float, float]


def theme(kind, seed):
    """What a seed's case is about: every fifty seeds hold each theme as often as `THEMES` says."""
    names = np.repeat(list(THEMES), list(THEMES.values()))
    block, place = divmod(seed - kind.first, len(names))
    return str(np.random.default_rng([kind.first, block % 2**31]).permutation(names)[place])
