"""Set-points and encoders of one log that can't belong together: units, signs, zeros, columns, one that stands still."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from camrob.gap.observation.scene import Scene
from camrob.units import deg_to_rad, mm_to_m, rad_to_deg

__all__ = ["check_drives", "made_of_encoders"]

Array = NDArray[np.float64]

_FAR_TURNED, _FAR_MOVED = deg_to_rad(5.0), mm_to_m(50.0)  # no drive stays so far behind its set-point (rms)
_LEFT = 0.1  # of it that is left where a mistake is corrected, at the most
_STILL, _MOVES = 1e-9, deg_to_rad(1.0)  # rad and m: stays the same to the last digit; moves
_ZEROS = (90.0, -90.0, 180.0)  # degrees by which makers and textbooks count axes differently
# of how it moves: so near only where one was reckoned from the other; a factor so near 1 is one
_EXACT, _NO_COPY = 1e-7, 1e-6
_LENGTHS = {"metres": 1000.0, "inches": 25.4, "centimetres": 10.0}  # mm


def check_drives(scene: Scene) -> None:
    """Raises LogError for a log of which one mistake, of those that are tried, makes its set-points and encoder values the same
    motion, naming it; they lie degrees apart without. Logs without both pass, as do those that nothing tried mends.
    """
    if scene.setpoint is None or scene.encoder is None:
        return
    told, is_ = np.asarray(scene.setpoint), np.asarray(scene.encoder)
    for k, axis in enumerate(scene.axes):
        for names, still, moving in ((("", "c"), is_, told), (("c", ""), told, is_)):
            if np.ptp(still[:, k]) < _STILL and np.ptp(moving[:, k]) > _MOVES and not scene.poses:
                one, other = (f"{n}{axis}" for n in names)
                what = f"its {one} stays the same to the last digit while {other} moves"
                raise scene.log.error(what, hint=f"log {one} itself, or leave its column out in all rows")
        if not scene.poses and (words := made_of_encoders(told[:, k], is_[:, k], axis)):
            raise scene.log.error(words, hint="log what the drive gets in every cycle, or leave set-points out")
    far = np.array([_FAR_MOVED if s else _FAR_TURNED for s in _slides(scene)])
    size = _apart(scene, is_ - told) / far
    if not (size > 1.0).any():
        return
    left = [(float(np.linalg.norm(_apart(scene, is_ - c) / far)), words) for words, c in _corrected(scene, told)]
    best, words = min(left)
    if best <= _LEFT * float(np.linalg.norm(size)):
        raise scene.log.error(words, hint="correct the log (or [table] in its .toml), and diagnose it again")


def made_of_encoders(told: Array, is_: Array, axis: str) -> str:
    """In words, where a program reckons each set-point from the place of a row before (a part of the way to the goal, say): the
    drive's error is no part of what lies between, however well it follows. "" where it isn't so to the last digit.
    """
    left = [np.inf, np.inf]
    share = 1.0
    for n, before in enumerate((told[:-1], is_[:-1])):
        A = np.stack([before, np.ones_like(before)], axis=1)
        found = np.linalg.lstsq(A, told[1:], rcond=None)[0]
        left[n], share = float(np.abs(told[1:] - A @ found).max(initial=0.0)), float(found[0])
    tiny = _EXACT * float(np.ptp(told))
    if np.ptp(told) < _STILL or not left[1] <= tiny < left[0] or abs(share - 1.0) < _NO_COPY:
        return ""
    return f"its c{axis} is reckoned from {axis} a row before ({share:.4g} of it and a constant), to the last digit"


def _apart(scene: Scene, gap: Array) -> Array:
    """(k,) rms of what axes (N, k) are apart, but for whole turns."""
    turned = gap - 2.0 * np.pi * np.round(gap / (2.0 * np.pi))
    return np.asarray(np.sqrt(np.mean(np.where(_slides(scene), gap, turned) ** 2, axis=0)))


def _slides(scene: Scene) -> list[bool]:
    return [scene.cell.joints[scene.cell.index(a)].prismatic for a in scene.axes]


def _corrected(scene: Scene, told: Array) -> Iterator[tuple[str, Array]]:
    """Each mistake in words, and the set-points (N, k), SI, as if it had not been made."""
    slides = np.array(_slides(scene))

    def made(columns: NDArray[np.bool_] | int, values: Array) -> Array:
        out = told.copy()
        out[:, columns] = values
        return out

    turning = ~slides
    yield "its set-points are in radians, its encoder values in degrees", made(turning, rad_to_deg(told[:, turning]))
    yield "its set-points are in degrees, its encoder values in radians", made(turning, deg_to_rad(told[:, turning]))
    for k, axis in enumerate(scene.axes):
        own = told[:, k]
        yield f"its c{axis} counts the other way than {axis}", made(k, -own)
        if slides[k]:
            for unit, factor in _LENGTHS.items():
                yield f"its c{axis} is in {unit}", made(k, factor * own)
                yield f"its {axis} is in {unit}", made(k, own / factor)
            continue
        yield f"its c{axis} is in radians", made(k, rad_to_deg(own))
        yield f"its {axis} is in radians", made(k, deg_to_rad(own))
        for zero in _ZEROS:
            yield f"its c{axis} is counted from {zero:g} degrees off {axis}'s zero", made(k, own + deg_to_rad(zero))
    for a, b in combinations(range(len(scene.axes)), 2):
        swapped = told.copy()
        swapped[:, [a, b]] = told[:, [b, a]]
        yield f"its c{scene.axes[a]} and c{scene.axes[b]} are exchanged", swapped
