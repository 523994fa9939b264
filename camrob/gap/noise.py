"""How much of the gap is the instrument's noise, and which samples are outliers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.gap.scene import Scene
from camrob.gap.signals import robust_sigma
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["Noise", "find_outliers", "noise_of"]

Array = NDArray[np.float64]

SERVO_SHARE = 0.2  # encoders against set-points are held to this share of the instrument's noise
_FLOOR_LENGTH, _FLOOR_ANGLE = mm_to_m(0.002), deg_to_rad(0.0001)
_LEVER = 0.5  # m, where a log has no orientation to say
_OUTLIER = 7.0  # sigmas from the median of the neighbours


@dataclass(frozen=True, slots=True)
class Noise:
    """tcp: (6,) 1-sigma at the TCP, m and rad; servo: (k,) of encoders against set-points. told: True where LOG.toml gave it."""

    tcp: Array
    servo: Array
    told: bool

    @property
    def rms(self) -> float:
        """3-D rms of the position, m."""
        return float(np.sqrt(np.sum(self.tcp[:3] ** 2)))


def noise_of(scene: Scene) -> Noise:
    """The noise of one log: what LOG.toml tells; what second differences show, where that is clearly more or nothing is told."""
    shown = np.zeros(6)
    if not scene.poses:
        shown[:3] = float(np.sqrt(np.mean(robust_sigma(scene.tcp_gap[:, :3], scene.pieces) ** 2)))
        if scene.seen[:, 3:].all():
            shown[3:] = float(np.sqrt(np.mean(robust_sigma(scene.tcp_gap[:, 3:], scene.pieces) ** 2)))
    told = np.nan_to_num(scene.sigma)
    floor = np.array([_FLOOR_LENGTH] * 3 + [_FLOOR_ANGLE] * 3)
    sigma = np.where((told <= 0.0) | (shown > 1.3 * told), np.maximum(shown, floor), told)
    levers = np.array([
        float(np.sqrt(np.mean(np.sum(scene.places[f"{a}.zero"][:, :3] ** 2, axis=1)))) if f"{a}.zero" in scene.places else 0.0
        for a in scene.axes
    ])  # fmt: skip
    servo = SERVO_SHARE * sigma[0] / np.maximum(levers, 0.1)
    if scene.servo_gap is not None:
        servo = np.maximum(servo, robust_sigma(scene.servo_gap, scene.pieces))
    return Noise(sigma, servo, bool(told[0] > 0.0))


def find_outliers(scene: Scene, noise: Noise) -> NDArray[np.bool_]:
    """(N,) True where a measured position stands far from the median of its neighbours in time; none for single poses."""
    out = np.zeros(len(scene), bool)
    if scene.poses:
        return out
    for run in scene.pieces:
        r = scene.tcp_gap[run, :3]
        if len(r) < 7:
            continue
        # mirrored, not repeated: an outlier that comes first would be its own median
        padded = np.pad(r, ((3, 3), (0, 0)), mode="reflect")
        near = np.median(np.lib.stride_tricks.sliding_window_view(padded, 7, axis=0), axis=-1)
        off = np.abs(r - near)
        spread = np.maximum(1.4826 * np.median(off, axis=0), noise.tcp[:3])
        out[run] = (off > _OUTLIER * spread).any(axis=1)
    return out
