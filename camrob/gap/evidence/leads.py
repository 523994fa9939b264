"""What a residual's shape suggests to try in the next round: orders of gears, and shapes that the library has no physics for."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.effect import State
from camrob.gap.evidence.beside_frames import beside_frames
from camrob.gap.evidence.model import Model, effect_rms
from camrob.gap.evidence.scan import DRIVE, Shape, covered, gear_orders, shapes, uncovered_forms
from camrob.gap.evidence.unknown import UNKNOWN

__all__ = ["look"]

Array = NDArray[np.float64]

_MOST_SHAPES = 4  # at a time: a person looks at no more
_SAME_ORDER = 2e-3  # share by which an order differs where it is another one
_OTHER_ORDER = 0.1  # share by which a second order of an axis differs from its first
_RAW_SHARE = 0.3  # of what an axis would have to do for the whole gap: what a single order must show of it
_LEAST_NOISE, _LEAST_GAP = 0.5, 0.012  # of the noise and of the gap: what is unknown and less isn't worth a word


def look(model: Model, states: dict[str, State], left: Sequence[Array], *, raw: bool = False) -> bool:
    """Offer what the residual's shape suggests (raw: the whole gap's, before anything explains it); True where something was."""
    offered = False
    heat = 1.0 if raw else model.evidence.temperature
    for effect in model.effects:
        if effect.orders:
            offered |= _look_for_orders(model, effect.name, states, left, heat, raw=raw)
    explained = np.zeros_like(model.best.mean) if raw else model.best.mean
    servo = [None if p.servo is None or p.y_servo is None else p.y_servo - p.errors(explained) for p in model.panels]
    inside = {u.key for i, u in enumerate(model.units) if u.effect == "unknown" and i in model.best.members}
    tried = {u.key for u in model.units if u.effect == "unknown"}
    kept = {
        k: v
        for k, v in states["unknown"].items()
        if k.rpartition("|")[0] in inside or k.rpartition("|")[0] not in tried
    }
    room = 2 if raw else _MOST_SHAPES - len(kept) // 2
    inexact = [
        model.accuracy[n] * effect_rms(model, model.panels, n)
        for n in model.evidence.effects_of(model.best.members)
        if n != UNKNOWN.name
    ]
    least = max(_LEAST_NOISE * model.noise, _LEAST_GAP * model.gap, 0.0 if raw else 2.0 * max(inexact, default=0.0))
    found = shapes(model.panels, left, servo, heat, least, 2 * _MOST_SHAPES)
    for shape in _uncovered(beside_frames(model, found) if raw else found, model, max(room, 0)):
        key = f"{shape.target}|{shape.quantity}"
        if key in inside:
            continue  # as it is: a second step is no better moment for the first
        if f"{key}|lower" not in states["unknown"]:
            offered = True
        kept[f"{key}|lower"], kept[f"{key}|upper"] = shape.lower, shape.upper
    for form, size in uncovered_forms(model).items() if raw else ():
        kept[f"{form}|lower"], kept[f"{form}|upper"] = 0.0, size
        offered = True
    states["unknown"] = kept
    return offered


def _uncovered(found: Sequence[Shape], model: Model, room: int) -> list[Shape]:
    """The best shapes that the library does not have, so many at the drives and so many behind the encoders: what stays at the
    one stage is no reason to overlook the other.
    """
    new = [s for s, known in zip(found, covered(found, model), strict=True) if not known]
    drives = [s for s in new if s.target.startswith(DRIVE)]
    return [*drives[:room], *[s for s in new if not s.target.startswith(DRIVE)][:room]]


def _look_for_orders(
    model: Model, name: str, states: dict[str, State], left: Sequence[Array], heat: float, *, raw: bool
) -> bool:
    """Offer the gears' orders that the residual shows, what is unknown and ripples themselves put back, then further ones of
    the same axes; True where any is new.
    """
    own = {i: u for i, u in enumerate(model.units) if u.effect == name}
    inside = {u.key for i, u in own.items() if i in model.best.members}
    tried = {u.key for u in own.values()}
    orders = {k: v for k, v in states[name].items() if k in inside or k not in tried}
    smooth = frozenset([*own, *(i for i, u in enumerate(model.units) if u.effect == UNKNOWN.name)])
    back = [
        r if raw else r + p.twists(model.values(smooth & model.best.members, model.best))
        for r, p in zip(left, model.panels, strict=True)
    ]
    found = gear_orders(model.panels, back, heat, _RAW_SHARE if raw else 0.0)
    if not raw:
        for key, order in gear_orders(model.panels, left, heat).items():
            if key in inside and abs(found.get(key, order) - order) > _OTHER_ORDER * order:
                found[f"{key}_2"] = order
    offered = False
    for key, order in found.items():
        if key not in orders or abs(orders[key] - order) > _SAME_ORDER * order:
            orders[key] = order
            offered = True
    states[name] = orders
    return offered
