"""How much of the gap is the instrument's noise, and which samples are outliers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.errors import LogError
from camrob.gap.observation.few_decimals import rounding_of_drives
from camrob.gap.observation.local_rows import LocalRows, local_rows
from camrob.gap.observation.scene import Scene
from camrob.gap.observation.signals import robust_sigma
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["Noise", "find_outliers", "local_of", "noise_left", "noise_of", "plain_gap"]

Array = NDArray[np.float64]

SERVO_SHARE = 0.2  # encoders against set-points are held to this share of the instrument's noise
_FLOOR_LENGTH, _FLOOR_ANGLE = mm_to_m(0.002), deg_to_rad(0.0001)
_FLOOR_DRIVE = 1e-7  # rad and m: finer than any encoder
_ROUGH_LENGTH, _ROUGH_ANGLE = mm_to_m(0.05), deg_to_rad(0.005)  # what the search for an untold noise starts from
_TURNS, _RANK, _LEAST_FREEDOM = 4, 1e-7, 0.2
_LEVER = 0.5  # m, where a log has no orientation to say
_OUTLIER = 7.0  # sigmas from the median of the neighbours
_POSES_A_CONSTANT = 2.0  # coordinates to a constant of the chain, for gross poses to be found
_SAME = deg_to_rad(0.05)  # and m / 1000: postures that differ by less are one
_WIDE = mm_to_m(5.0)  # that a constant may move the tool by
_LOCAL = ("local rows",)
_ROBUST_TURNS, _TUKEY, _GROSS = 12, 6.0, 8.0  # times the median of what is left: no weight; a gross pose


@dataclass(frozen=True, slots=True)
class Noise:
    """tcp: (6,) 1-sigma at the TCP, m and rad; servo: (k,) of encoders against set-points. stated: whether LOG.toml gave it.
    share: of the three coordinates of a place, what a row tells.
    """

    tcp: Array
    servo: Array
    stated: bool
    share: float = 1.0

    @property
    def rms(self) -> float:
        """3-D rms of the position, m; of what is told of it."""
        return float(np.sqrt(self.share * np.sum(self.tcp[:3] ** 2)))


def noise_of(scene: Scene) -> Noise:
    """The noise of one log: what LOG.toml states; what second differences show, where that is clearly more or none is stated."""
    shown = np.zeros(6)
    if not scene.poses:
        shown[:3] = float(np.sqrt(np.mean(robust_sigma(scene.tcp_gap[:, :3], scene.pieces) ** 2) / scene.share))
        if scene.seen[:, 3:].all():
            shown[3:] = float(np.sqrt(np.mean(robust_sigma(scene.tcp_gap[:, 3:], scene.pieces) ** 2)))
    stated = np.nan_to_num(scene.sigma)
    floor = np.array([_FLOOR_LENGTH] * 3 + [_FLOOR_ANGLE] * 3)
    sigma = np.where((stated <= 0.0) | (shown > 1.3 * stated), np.maximum(shown, floor), stated)
    levers = np.array(
        [
            float(np.sqrt(np.mean(np.sum(scene.places[f"{a}.zero"][:, :3] ** 2, axis=1))))
            if f"{a}.zero" in scene.places
            else 0.0
            for a in scene.axes
        ]
    )
    servo = SERVO_SHARE * sigma[0] / np.maximum(levers, 0.1)
    linear = [scene.cell.joints[scene.cell.index(a)].prismatic for a in scene.axes]
    drives = np.where(linear, scene.log.info.sigma_axis_length, scene.log.info.sigma_axis)
    least = np.full(len(linear), _FLOOR_DRIVE) if not scene.tracked else servo
    if scene.servo_gap is not None:
        least = np.maximum(least, rounding_of_drives(scene))
    servo = np.where(np.nan_to_num(drives) > 0.0, drives, least)
    if scene.servo_gap is not None:
        servo = np.maximum(servo, robust_sigma(scene.servo_gap, scene.pieces))
    if not scene.tracked:
        # nothing was measured at the tool: its place is known as well as the drives' own noise allows, carried there
        sigma[:3] = max(float(np.sqrt(np.sum((levers * servo) ** 2) / 3.0)), _FLOOR_LENGTH)
    return Noise(sigma, servo, bool(stated[0] > 0.0), scene.share)


def noise_left(
    columns: Array, gap: Array, seen: NDArray[np.bool_], servo: Array, path: Path | None, share: float = 1.0
) -> Noise:
    """The noise of single poses where it is not stated: what the whole library together can't explain, so at most this.

    columns: (N, 6, K), gap: (N, 6), seen: (N, 6), all SI; servo: as in `Noise`. Positions and turns weigh as they scatter, found
    in rounds. path: the log's, for messages; share: what a row tells of three coordinates. Raises LogError where there are too
    few poses to tell.
    """
    rows = seen.ravel()
    X, y = columns.reshape(rows.size, -1)[rows], gap.ravel()[rows]
    turned = np.broadcast_to(np.arange(6) >= 3, seen.shape).ravel()[rows]
    told = float(np.sum(np.where(turned, 1.0, share)))  # equations
    sigma = np.array([_ROUGH_LENGTH, _ROUGH_ANGLE])
    for _ in range(_TURNS):
        w = 1.0 / sigma[turned.astype(int)]
        Z = X * w[:, None]
        U, s, _vt = np.linalg.svd(Z / np.maximum(np.linalg.norm(Z, axis=0), 1e-30), full_matrices=False)
        U = U[:, s > _RANK * s[0]]
        freedom = 1.0 - U.shape[1] / told
        if freedom < _LEAST_FREEDOM:
            what = f"the noise of its {len(seen)} single poses is not stated, and they are too few to show it"
            raise LogError(what, hint="write sigma_mm (and sigma_deg) of the instrument into its .toml", path=path)
        left = (y * w - U @ (U.T @ (y * w))) / w
        parts = [left[~turned] / np.sqrt(share), left[turned]]
        sigma = np.array(
            [np.sqrt(np.mean(r**2) / freedom) if len(r) else old for r, old in zip(parts, sigma, strict=True)]
        )
    sigma = np.maximum(sigma, [_FLOOR_LENGTH, _FLOOR_ANGLE])
    return Noise(np.repeat(sigma, 3), servo, stated=False, share=share)


def find_outliers(scene: Scene, noise: Noise) -> NDArray[np.bool_]:
    """(N,) True where a measured position stands far from the median of its neighbours in time; of single poses, where it
    stands far from what wrong constants of the chain make of all of them together.
    """
    if scene.poses:
        return _gross_poses(scene, noise)
    out = np.zeros(len(scene), bool)
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


def plain_gap(scene: Scene) -> Array:
    """(N, 6) the gap, that of gross rows what lies between their neighbours': for sums that weigh all rows alike."""
    key = ("plain gap",)
    if key not in scene.found:
        gap, kept = scene.tcp_gap, ~find_outliers(scene, noise_of(scene))
        if not kept.all() and kept.any():
            rows = np.arange(len(scene))
            gap = np.stack([np.interp(rows, rows[kept], g[kept]) for g in gap.T], axis=1)
        scene.found[key] = gap
    return np.asarray(scene.found[key])


def local_of(scene: Scene) -> LocalRows | None:
    """What of the poses that take no part shares a place, and is no gross reading; None for nothing, and of a path."""
    if not scene.poses:
        return None
    if _LOCAL not in scene.found:
        find_outliers(scene, noise_of(scene))
    return scene.found.get(_LOCAL)


def _gross_poses(scene: Scene, noise: Noise) -> NDArray[np.bool_]:
    """(N,) True for single poses that no constant error of the chain explains, as it explains the others.

    Every constant of the chain is fitted robustly (Tukey's weights, from the median over distinct postures on); where there are
    too few of these for that, the frames at both ends alone, beside which only what is far larger than all else is gross.
    """
    once = np.unique(np.round(scene.link / _SAME), axis=0, return_index=True)[1]
    few = len(once) < _POSES_A_CONSTANT * len(scene.places) / 3.0
    names = [n for n in scene.places if not few or n.partition(".")[0] in ("base", "tool")]
    X = np.moveaxis(np.stack([scene.place(n)[:, :3] for n in names]), 0, 2)
    gap = scene.tcp_gap[:, :3]
    if len(once) < _POSES_A_CONSTANT * len(names) / 3.0:
        return np.zeros(len(scene), bool)
    size = np.maximum(np.sqrt(np.mean(np.sum(X**2, axis=1), axis=0)), 1e-12)
    # no constant is thought to move the tool by more than some millimetres: else it would follow what is gross
    held = np.diag(noise.tcp[0] / _WIDE * np.ones(len(size)))
    weight = np.ones(len(scene))
    left = gap - np.median(gap[once], axis=0)
    for _ in range(_ROBUST_TURNS):
        off = np.linalg.norm(left, axis=1)
        scale = max(float(np.median(off[once])), float(noise.rms))
        weight = np.clip(1.0 - (off / (_TUKEY * scale)) ** 2, 0.0, None)
        A = np.concatenate([(X / size * weight[:, None, None]).reshape(-1, len(size)), held])
        b = np.concatenate([(gap * weight[:, None]).ravel(), np.zeros(len(size))])
        left = gap - X @ (np.linalg.lstsq(A, b, rcond=_RANK)[0] / size)
    off = np.linalg.norm(left, axis=1)
    far = np.asarray(off > _GROSS * max(float(np.median(off[once])), float(noise.rms)))
    scene.found[_LOCAL] = local_rows(scene, far, off)
    return far
