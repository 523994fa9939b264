"""Distances and angles that the judge asks for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mutation.story import Story, between

Array = NDArray[np.float64]


def apart(a: Array, b: Array) -> float:
    """Degrees between two unit vectors."""
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)))


def passed(poses: Array, point: Array) -> tuple[float, Array]:
    """How far a motion passes a point, and the tool's axis where it does."""
    tips = poses[:, :3, 3]
    a, way = tips[:-1], np.diff(tips, axis=0)
    square = np.maximum(np.sum(way * way, axis=1), 1e-18)
    share = np.clip(np.sum((point - a) * way, axis=1) / square, 0.0, 1.0)
    off = np.linalg.norm(a + share[:, None] * way - point, axis=1)
    k = int(np.argmin(off))
    return float(off[k]), between(poses[k, :3, 2], poses[k + 1, :3, 2], float(share[k]))


def off_pose(pose: Array, story: Story, k: int) -> float:
    return float(np.linalg.norm(story.point(k) - pose[:3, 3]))
