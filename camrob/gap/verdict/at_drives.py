"""Names of the drives where logs hold both ends: what an encoder shows, nothing behind it can be the likeness of, however much
stays there.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.effect import Effect
from camrob.gap.evidence.design import Panel
from camrob.gap.evidence.model import Model
from camrob.gap.evidence.scan import DRIVE
from camrob.gap.evidence.shrink import Shrinkage, drives_gap
from camrob.gap.verdict.remains import claims

__all__ = ["at_drives", "moved_at_drives", "shaped_at_drives", "stays_at_drives"]

Array = NDArray[np.float64]


def at_drives(model: Model, library: Sequence[Effect]) -> frozenset[str]:
    """Effects that work between set-point and encoder alone, where every log tells both."""
    both = all(p.servo is not None for p in model.panels)
    return frozenset(e.name for e in library if both and e.stages == ("setpoint_to_encoder",))


def shaped_at_drives(model: Model) -> bool:
    """Whether the best set holds a shape of the unknown at a drive."""
    units = (model.units[i] for i in model.best.members)
    return any(u.effect == "unknown" and u.key.startswith(DRIVE) for u in units)


def moved_at_drives(model: Model, names: Collection[str]) -> float:
    """How far effects of the best set together move the drives of the fitted logs, carried to the TCP, m (rms)."""
    values = model.values(frozenset(i for i in model.best.members if model.units[i].effect in names), model.best)
    return _rms([p.carried(p.errors(values))[_told(p)] for p in model.panels])


def stays_at_drives(model: Model, withheld: Shrinkage, probability: Mapping[str, float]) -> float:
    """m (rms, carried to the TCP) that the claims leave between set-points and encoders beyond these' noise, on withheld samples
    or on the fitted ones, whichever is more.
    """
    values = model.values(claims(model, probability), model.best)
    fitted = _rms([(drives_gap(p, _told(p)) - p.carried(p.errors(values))[_told(p)]) for p in model.panels])
    noise = _rms([_noise(p) for p in model.panels])
    return float(np.sqrt(max(max(fitted, withheld.rms_after) ** 2 - noise**2, 0.0)))


def _told(panel: Panel) -> NDArray[np.bool_]:
    return np.asarray(panel.w_tcp[:, 0] > 0.0)


def _noise(panel: Panel) -> Array:
    """(M, k) m that the noise of each encoder moves the TCP by."""
    if panel.w_servo is None:
        raise ValueError("a log without set-points or encoders tells no encoder's noise")
    sigma = np.divide(1.0, panel.w_servo, out=np.zeros_like(panel.w_servo), where=panel.w_servo > 0.0)
    one = np.eye(sigma.shape[1])
    sizes = [np.linalg.norm(panel.carried(sigma * axis), axis=1) for axis in one]
    return np.asarray(np.stack(sizes, axis=1)[_told(panel)])


def _rms(parts: Sequence[Array]) -> float:
    return float(np.sqrt(np.mean(np.sum(np.concatenate(parts) ** 2, axis=1))))
