"""Kinds of motion of a program, ways to round off a target and to count turns: one vocabulary for what is meant and is read."""

from __future__ import annotations

from enum import IntEnum, StrEnum

__all__ = ["AT_SPEED", "Blend", "Motion", "Turning"]

AT_SPEED = 1.0 + 1e-6
"""Times a speed, that one as printed may be: no faster."""


class Motion(IntEnum):
    """The motion that ends at a row."""

    PTP_AXES = 0  # all axes together, to axis values
    PTP_POSE = 1  # all axes together, to a pose, in the branch that status and turn say
    LIN = 2
    CIRC_VIA = 3  # auxiliary point of the arc that ends at the next row
    CIRC_END = 4


class Blend(IntEnum):
    """How the row's target is rounded off."""

    EXACT = 0
    AXES = 1  # from a share of the axes' way on
    DISTANCE = 2  # from a distance on
    SPEED = 3  # from where braking would begin, down to a share of the speed
    TURN = 4  # from an angle of the tool on


class Turning(StrEnum):
    """How `turn` says where the axes are."""

    SIGNS = "signs"  # one bit an axis, set where its value is negative
    QUARTERS = "quarters"  # four bits each of axes 1, 4 and 6: the quarter of a turn that the axis is in, 0 from 0 to 90 degrees
