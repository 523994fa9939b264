"""What a family of cases is made of: cells, descriptions of causes, foreign causes, a leftover."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np


@dataclass
class Setting:
    """What a description may look at: the robot, its runs, what the log shows."""

    robot: object
    runs: list
    log: dict

    @property
    def names(self):
        """Axes."""
        return self.robot.names

    def arm(self, rng, most=1, among=None):
        """Some of the arm's axes, indices."""
        pool = self.robot.arm if among is None else among
        count = int(rng.integers(1, min(most, len(pool)) + 1))
        return sorted(int(i) for i in rng.choice(pool, count, replace=False))

    def moving(self):
        """Axes that move in every run by more than a degree or 5 mm."""
        least = np.where(self.robot.slides, 5e-3, np.radians(1.0))
        return [i for i in range(len(self.names)) if all(np.ptp(r.c[:, i]) > least[i] for r in self.runs)]

    def key(self, i, what=""):
        """A parameter's name: axis, then unit."""
        return f"{self.names[i]}{what}_{'mm' if self.robot.slides[i] else 'deg'}"

    def told(self, i, value):
        """A value of axis i in its own unit, signed as the controller counts."""
        return float(value / self.robot.unit[i])


@dataclass
class Description:
    """One way for a cause to come about: `make(setting, rng, strength)`; `most` the largest strength that a machine has."""

    name: str
    make: Callable
    needs: frozenset = frozenset()
    most: float = 10.0
    foreign: bool = False


@dataclass
class Family:
    """Cells with their shares, descriptions, foreign causes, leftovers of a body and of drives, motions."""

    name: str
    cells: dict
    known: list[Description]
    foreign: list[Description]
    leftover: Callable
    drive_leftover: Callable
    motion: Callable
    single_poses: Callable
    extra: dict = field(default_factory=dict)


def axis_delta(run, deltas):
    """(N, n) out of {axis: (N,)}."""
    out = np.zeros_like(run.c)
    for i, values in deltas.items():
        out[:, i] = values
    return out
