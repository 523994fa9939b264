"""Names of the drives that work against each other, and together do no more than any smooth function of the axis's speed would.

A drive short of voltage falls behind with the square of its speed: so does a delay, less a friction that pushes. Each stands far
out, and all that both leave is noise.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.gap.evidence.design import Panel
from camrob.gap.evidence.model import Model, members_of
from camrob.gap.evidence.unknown import DEGREE
from camrob.gap.verdict.belief import BELIEF

__all__ = ["any_course"]

Array = NDArray[np.float64]

_MOST = 0.5  # of what a name does at the drives
_TINY = 1e-12


def any_course(model: Model, names: Collection[str]) -> frozenset[str]:
    """Those of some names of the drives that do most of what they do on axes where they mostly cancel, and where a smooth
    function of the speed in their place leaves more by fewer squares than a name has to stand out by to be nearly sure. Of logs
    that tell both ends.
    """
    asked = sorted(model.evidence.effects_of(model.best.members).intersection(names))
    if len(asked) < 2:
        return frozenset()
    done = {n: [p.errors(model.values(members_of(model, n), model.best)) for p in model.panels] for n in asked}
    whole, there = dict.fromkeys(asked, 0.0), dict.fromkeys(asked, 0.0)
    for k in range(len(model.scenes[0].axes)):
        w = _joined([_weights(p) for p in model.panels], k)
        own = {n: _joined(parts, k) * w for n, parts in done.items()}
        shared = _cancel(list(own.values())) and _shown(model, k, w, np.sum(list(own.values()), axis=0))
        for n, moved in own.items():
            energy = float(moved @ moved)
            whole[n] += energy
            there[n] += energy if shared else 0.0
    return frozenset(n for n in asked if there[n] > _MOST * whole[n])


def _cancel(parts: Sequence[Array]) -> bool:
    """Whether parts (N,) do far less together than each for itself."""
    both = np.sum(parts, axis=0)
    return sum(float(d @ d) for d in parts) > BELIEF.cancels * float(both @ both)


def _shown(model: Model, k: int, w: Array, together: Array) -> bool:
    """Whether a smooth function of an axis's speed leaves nearly as little as names do that move its drive by `together` (N,), in
    sigmas, as weights w (N,) say.
    """
    mean = model.values(model.best.members, model.best)
    left = _joined([_told(p) - p.errors(mean) for p in model.panels], k) * w
    speed = _joined([p.scene.speed for p in model.panels], k)
    X = np.polynomial.legendre.legvander(2.0 * (speed - speed.min()) / max(np.ptp(speed), _TINY) - 1.0, DEGREE)
    X, y = X * w[:, None], left + together
    rest = y - X @ np.linalg.lstsq(X, y)[0]
    return float(rest @ rest - left @ left) < BELIEF.stands_out * model.evidence.temperature


def _joined(parts: Sequence[Array], k: int) -> Array:
    """(N,) an axis's column of all logs; 0 where nothing is told."""
    return np.nan_to_num(np.concatenate([p[:, k] for p in parts]))


def _told(panel: Panel) -> Array:
    if panel.y_servo is None:
        raise ValueError("a log without set-points or encoders tells no drive's error")
    return panel.y_servo


def _weights(panel: Panel) -> Array:
    if panel.w_servo is None:
        raise ValueError("a log without set-points or encoders tells no encoder's noise")
    return panel.w_servo
