"""Kinds of motion of a robot's program, and ways to round off a target: one vocabulary for what is meant and what is read."""

from __future__ import annotations

from enum import IntEnum

__all__ = ["Blend", "Motion"]


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
