"""Still pictures of bodies and a path without a graphics card: a depth buffer, one sun with soft shadows, outlines.

Orthographic throughout, so that camera and sun are both one linear map of `world`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel

__all__ = ["Facets", "fill", "render", "screen_R_world"]

Array = NDArray[np.float64]

_SAMPLES = 2  # a pixel's samples along each side
_SUNS = 12
_SUN = (0.45, -0.5, 1.0)
_SUN_SPREAD = 0.05
_SHADOW_PIXELS = 1400
_SHARP = 0.7  # cosine between two facets' normals below which their edge is drawn
_SHADOW_BIAS = 0.008  # m


@dataclass(frozen=True, slots=True)
class Facets:
    """Triangles (M, 3, 3) in `world`, m; colour (M, 3) of 0..1; body (M,), for outlines; lit (M,), False for a path;
    fades (M,), True for what runs out into the background (a floor).
    """

    corners: Array
    color: Array
    body: NDArray[np.int64]
    lit: NDArray[np.bool_]
    fades: NDArray[np.bool_]

    @classmethod
    def joined(cls, parts: list[Facets]) -> Facets:
        """All of them in one."""
        return cls(
            np.concatenate([p.corners for p in parts]),
            np.concatenate([p.color for p in parts]),
            np.concatenate([p.body for p in parts]),
            np.concatenate([p.lit for p in parts]),
            np.concatenate([p.fades for p in parts]),
        )


def screen_R_world(towards_eye: Array) -> Array:
    """Rows: to the right, up, and towards the eye, for a view with `world`'s z upright."""
    back = towards_eye / np.linalg.norm(towards_eye)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back])


@kernel
def fill(corners: Array, depth: Array, owner: NDArray[np.int32]) -> None:
    """Draws triangles (M, 3, 3) of (column, row, nearness) into depth (H, W) and owner (H, W), the nearest one wins.

    A pixel belongs to a triangle where its centre does. depth starts at -inf, owner at -1.
    """
    height, width = depth.shape
    for k in range(corners.shape[0]):
        x0, y0, z0 = corners[k, 0]
        x1, y1, z1 = corners[k, 1]
        x2, y2, z2 = corners[k, 2]
        area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        if abs(area) < 1e-12:
            continue
        left = max(0, int(np.floor(min(x0, x1, x2))))
        right = min(width - 1, int(np.ceil(max(x0, x1, x2))))
        top = max(0, int(np.floor(min(y0, y1, y2))))
        bottom = min(height - 1, int(np.ceil(max(y0, y1, y2))))
        for row in range(top, bottom + 1):
            for column in range(left, right + 1):
                px, py = column + 0.5, row + 0.5
                w1 = ((px - x0) * (y2 - y0) - (x2 - x0) * (py - y0)) / area
                w2 = ((x1 - x0) * (py - y0) - (px - x0) * (y1 - y0)) / area
                if w1 >= 0.0 and w2 >= 0.0 and w1 + w2 <= 1.0:
                    z = z0 + w1 * (z1 - z0) + w2 * (z2 - z0)
                    if z > depth[row, column]:
                        depth[row, column] = z
                        owner[row, column] = k


def _project(p: Array, screen_R: Array, center: Array, scale: float, width: int, height: int) -> Array:
    """Points (..., 3) as (column, row, nearness)."""
    out = (p - center) @ screen_R.T
    out[..., 0] = 0.5 * width + scale * out[..., 0]
    out[..., 1] = 0.5 * height - scale * out[..., 1]
    return np.ascontiguousarray(out)


def _sunlight(facets: Facets, p: Array) -> Array:
    """Share 0..1 of the sun that reaches points p (K, 3)."""
    solid = np.ascontiguousarray(facets.corners[facets.lit])
    every = solid.reshape(-1, 3)
    center = 0.5 * (every.min(axis=0) + every.max(axis=0))
    size = float(np.linalg.norm(every.max(axis=0) - every.min(axis=0)))
    scale, n = _SHADOW_PIXELS / size, _SHADOW_PIXELS
    share = np.zeros(len(p))
    for k in range(_SUNS):
        turn = 2.399963 * k  # golden angle: suns spread evenly over a disc
        offset = _SUN_SPREAD * np.sqrt((k + 0.5) / _SUNS)
        sun_R = screen_R_world(np.array(_SUN) + offset * np.array([np.cos(turn), np.sin(turn), 0.0]))
        depth, owner = np.full((n, n), -np.inf), np.full((n, n), -1, np.int32)
        fill(_project(solid, sun_R, center, scale, n, n), depth, owner)
        at = _project(p, sun_R, center, scale, n, n)
        column, row = at[:, 0].astype(int).clip(0, n - 1), at[:, 1].astype(int).clip(0, n - 1)
        share += at[:, 2] > depth[row, column] - _SHADOW_BIAS
    return share / _SUNS


def render(
    facets: Facets,
    *,
    towards_eye: Array,
    center: Array,
    width_m: float,
    pixels: tuple[int, int],
    fade: tuple[float, float],
) -> Array:
    """A picture (height, width, 3) of 0..1 on white, `width_m` metres wide round `center`; pixels: (width, height).

    fade: distances from the upright through `center`, m, where what fades begins to and is gone.
    """
    width, height = pixels[0] * _SAMPLES, pixels[1] * _SAMPLES
    view_R, scale = screen_R_world(towards_eye), width / width_m
    depth, owner = np.full((height, width), -np.inf), np.full((height, width), -1, np.int32)
    fill(_project(facets.corners, view_R, center, scale, width, height), depth, owner)
    image = np.ones((height, width, 3))
    rows, columns = np.nonzero(owner >= 0)
    k = owner[rows, columns]
    side = facets.corners[:, 1:] - facets.corners[:, :1]
    normal = np.cross(side[:, 0], side[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-15)
    normal *= np.where(normal @ view_R[2] < 0.0, -1.0, 1.0)[:, None]
    seen = np.stack(
        [(columns + 0.5 - 0.5 * width) / scale, (0.5 * height - rows - 0.5) / scale, depth[rows, columns]], 1
    )
    p = center + seen @ view_R
    facing = np.maximum(normal[k] @ (np.array(_SUN) / np.linalg.norm(_SUN)), 0.0)
    light = 0.55 + 0.1 * normal[k, 2] + 0.5 * facing * _sunlight(facets, p + 0.004 * normal[k])
    color = facets.color[k] * np.where(facets.lit[k], light, 1.0)[:, None]
    color *= np.where(_outline(owner, facets, normal)[rows, columns] & facets.lit[k], 0.62, 1.0)[:, None]
    away = (np.linalg.norm(p[:, :2] - center[:2], axis=1) - fade[0]) / (fade[1] - fade[0])
    gone = np.where(facets.fades[k], away.clip(0.0, 1.0), 0.0)[:, None]
    image[rows, columns] = color.clip(0.0, 1.0) * (1.0 - gone) + gone
    return np.asarray(image.reshape(pixels[1], _SAMPLES, pixels[0], _SAMPLES, 3).mean(axis=(1, 3)))


def _outline(owner: NDArray[np.int32], facets: Facets, normal: Array) -> NDArray[np.bool_]:
    """(H, W) True where the body changes from a sample to the next, or its surface turns by more than 45 degrees."""
    out = np.zeros(owner.shape, dtype=bool)
    for down, right in ((0, 1), (1, 0)):
        here, there = owner[down:, right:], owner[: owner.shape[0] - down, : owner.shape[1] - right]
        rows, columns = np.nonzero((here != there) & (here >= 0))
        a, b = here[rows, columns], there[rows, columns]
        turned = (facets.body[a] != facets.body[b]) | (np.einsum("ij,ij->i", normal[a], normal[b]) < _SHARP)
        out[rows + down, columns + right] |= (b < 0) | (turned & facets.lit[a] & facets.lit[b])
    return out
