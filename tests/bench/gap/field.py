"""What a real arm leaves beside every named effect, for the gap benchmark: a smooth field over posture, the same on both runs.

On thirteen real sets 5 to 30 times the instrument's noise stayed after the best fits known (issue 14), and it followed posture.
Nothing here comes from camrob.
"""

from __future__ import annotations

import numpy as np

COSINES = 14
SLOWEST, FASTEST = 0.6, 3.0  # per rad of an axis
TRACK = 0.5  # m of the track that count as a rad


def draw_field(seed, world, size):
    """apply(world): x, y, z of the tool displaced by `size` m (rms on `world`'s run), a sum of cosines over pairs of axes."""
    rng = np.random.default_rng([seed, 2])
    pairs = np.array([rng.choice(7, 2, replace=False) for _ in range(COSINES)])
    rates = rng.uniform(SLOWEST, FASTEST, (COSINES, 2)) * rng.choice([-1, 1], (COSINES, 2))
    phases, vectors = rng.uniform(0, 2 * np.pi, COSINES), rng.normal(0, 1, (COSINES, 3))

    def shown(w):
        q = w.command[:, :7] / np.r_[np.ones(6), TRACK]
        turned = np.stack([q[:, p] @ r for p, r in zip(pairs, rates, strict=True)], 1)
        return np.cos(turned + phases) @ vectors

    first = shown(world)
    middle = first.mean(axis=0)
    scale = size / np.sqrt(np.mean(np.sum((first - middle) ** 2, axis=1)))

    def apply(w):
        w.after = w.after + scale * (shown(w) - middle)

    return apply
