"""Axes with an encoder on either side of their gear: what lies between the two, and that the drive did none of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from camrob.gap.observation.scene import Scene

__all__ = ["as_by_motors", "between_encoders", "motors_follow"]

_BEHIND = 0.2  # of the energy between set-point and link, that the motor's own encoder may show to be in the drive at the most


def between_encoders(scene: Scene, axis: str) -> bool:
    """Whether a log tells an axis's set-points, its motor's encoder and its link's: what its gear does shows between these."""
    return scene.servo_gap is not None and scene.motor(axis) is not None


def as_by_motors(scene: Scene) -> Scene:
    """A log as it would be with its motors' encoders alone, where it has both: what a gear does lies behind these."""
    key = ("by motors",)
    if key not in scene.found:
        motors = {
            k: m for k, a in enumerate(scene.axes) if between_encoders(scene, a) and (m := scene.motor(a)) is not None
        }
        encoder, gap = scene.link.copy(), scene.tcp_gap.copy()
        for k, motor in motors.items():
            if f"{scene.axes[k]}.zero" in scene.places:
                gap += np.where(scene.seen, scene.shift(scene.axes[k], encoder[:, k] - motor), 0.0)
            encoder[:, k] = motor
        scene.found[key] = replace(scene, encoder=encoder, tcp_gap=gap) if motors else scene
    found: Scene = scene.found[key]
    return found


def motors_follow(scenes: Sequence[Scene]) -> frozenset[str]:
    """Axes of which most of what lies between set-point and link lies behind the motor, whose own encoder every log has: no drive
    did that.
    """
    found = []
    for k, axis in enumerate(scenes[0].axes):
        drive, whole = 0.0, 0.0
        for scene in scenes:
            motor = scene.motor(axis)
            if motor is None or scene.setpoint is None or scene.servo_gap is None:
                break
            off, all_of = motor - scene.setpoint[:, k], scene.servo_gap[:, k]
            drive += float(np.sum((off - off.mean()) ** 2))
            whole += float(np.sum((all_of - all_of.mean()) ** 2))
        else:
            if drive < _BEHIND * whole:
                found.append(axis)
    return frozenset(found)
