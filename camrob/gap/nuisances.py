"""What is fitted beside all effects and never claimed: frames, targets and lengths that nobody knows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from camrob.gap.effects.effect import Column, EffectParameter, Unit
from camrob.gap.observation.scene import Scene
from camrob.gap.observation.unknown_frames import left_twists, right_twists
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["NUISANCE", "WITHHELD", "first_nuisances", "nuisance_columns", "nuisance_units"]

NUISANCE = "nuisance"
"""The effect's name of units that are fitted and never claimed: frames that are not known."""
WITHHELD = -1
"""The number of a log that takes no part in the fit."""

_SIDES = ("left", "right", "zero")
_FAR, _TURNED = mm_to_m(5.0), deg_to_rad(1.0)  # ordinary sizes


def nuisance_units(scenes: Sequence[Scene]) -> list[Unit]:
    """A unit for each log and each of its frame, its target and the zero of its distances that is to be fitted."""
    units = []
    for side in _SIDES[:2]:
        for k, scene in enumerate(scenes):
            named = {f"{side}{k}_{p}": _FAR if p in "xyz" else _TURNED for p in ("x", "y", "z", "rx", "ry", "rz")}
            if getattr(scene.frames, f"fitted_{side}"):
                units.append(_unit(named, f"{side}{k}|{scene.name}"))
    units += [_unit({f"zero{k}": _FAR}, f"zero{k}|{s.name}") for k, s in enumerate(scenes) if s.zero_open]
    return units


def _unit(sizes: Mapping[str, float], key: str) -> Unit:
    parameters = tuple(EffectParameter(n, "", usual, -np.inf, np.inf) for n, usual in sizes.items())
    return Unit(NUISANCE, "", parameters, key=key)


def first_nuisances(units: Sequence[Unit]) -> dict[str, str]:
    """By side the key of the first nuisance: it stands for a withheld log, which has a frame of its own and no unit."""
    keys = [u.key for u in reversed(units) if u.effect == NUISANCE]
    return {side: key for side in _SIDES for key in keys if key.startswith(side)}


def nuisance_columns(scene: Scene, unit: Unit, number: int, first: Mapping[str, str]) -> tuple[Column, ...]:
    """The twists of what is not known, nothing where it is another log's. number: which of the fitted logs it is, or WITHHELD;
    first: as `first_nuisances` gives it.
    """
    owner, _, name = unit.key.partition("|")
    side = next(s for s in _SIDES if owner.startswith(s))
    info = scene.log.info
    shared = {"left": info.same_frame_as, "right": info.same_target_as}.get(side, "")
    is_open = scene.zero_open if side == "zero" else bool(getattr(scene.frames, f"fitted_{side}"))
    own = is_open and first[side] == unit.key if number == WITHHELD else owner == f"{side}{number}"
    if not own and not (shared and shared == name):
        return tuple(Column() for _ in unit.parameters)
    if side == "zero":
        return (Column(tcp=scene.longer),)
    twists = scene.told(left_twists(scene.nominal) if side == "left" else right_twists(scene.nominal))
    return tuple(Column(tcp=twists[:, :, k]) for k in range(6))
