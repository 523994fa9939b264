"""A log that can't be this cell's, tried as what may have been mixed up: frame, columns, rows, units, an axis's sign or zero."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations, pairwise

import numpy as np
from numpy.typing import NDArray

from camrob.gap.observation.scene import Scene, make_scene
from camrob.measurement.log import POSITION, MeasurementLog
from camrob.measurement.log_info import MeasuredFrame
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["mistaken"]

Array = NDArray[np.float64]

_SOME = 600  # rows that tell well enough
_LEFT = 0.1  # of the gap that is left where a mistake is corrected, at the most
_CLEARER = 0.5  # times the next best mending: then it is this one
_LENGTHS = {"inches": 25.4, "metres": 1000.0, "centimetres": 10.0}  # mm
_ZEROS = (90.0, -90.0, 180.0)  # degrees by which makers and textbooks count axes differently


def mistaken(scene: Scene) -> str:
    """What was mixed up in a log, in words, "" where nothing that was tried mends it. Each is tried once, alone.

    scene: a log whose gap is incredible as it stands.
    """
    rows = np.unique(np.linspace(0, len(scene) - 1, min(len(scene), _SOME)).astype(int))
    found = []
    turning = [a for a in scene.axes if not scene.cell.joints[scene.cell.index(a)].prismatic]
    sliding = [a for a in scene.axes if a not in turning]
    for words, log in (*_corrected(scene.log), *_recounted(scene.log, turning, sliding)):
        # neighbours belong together where rows are one off, so these are thinned only after
        part = log if scene.poses else log.select(rows[rows < len(log)])
        found.append((_size(make_scene(part, scene.cell)), words))
    found.sort(key=lambda f: f[0])
    size = _size(scene)
    if not found or found[0][0] > _LEFT * size:
        return ""
    best, words = found[0]
    rivals = [w for other, w in found[1:] if best > _CLEARER * other]
    causes = " or ".join([words, *rivals])
    return f"{causes}: corrected so, the measured TCP lies {m_to_mm(best):.2g} mm (median) from where the axis values put it"


def _size(scene: Scene) -> float:
    """m, the median gap."""
    return float(np.median(np.linalg.norm(scene.tcp_gap[:, :3], axis=1)))


def _corrected(log: MeasurementLog) -> Iterator[tuple[str, MeasurementLog]]:
    """Each mistake in words, and the log as if it had not been made; judged by positions alone."""
    plain = {n: v for n, v in log.columns.items() if n not in ("a", "b", "c")}

    def made(**changed: Array) -> MeasurementLog:
        return MeasurementLog(plain | changed, log.info, log.path)

    own_frame = log.info.measured_frame is MeasuredFrame.UNKNOWN
    for axis in POSITION[:1] if own_frame else POSITION:
        # in a frame of its own, which axis is mirrored can't be known: all three differ by a rotation
        name = "its frame is mirrored (left-handed)" if own_frame else f"its {axis} is mirrored"
        yield name, made(**{axis: -np.asarray(plain[axis])})
    if not own_frame:
        for first, second in (("x", "y"), ("y", "z"), ("x", "z")):
            yield (
                f"its columns {first} and {second} are exchanged",
                made(**{first: plain[second], second: plain[first]}),
            )
    if log.info.poses and len(log) > 1:
        for off, word in ((1, "after"), (-1, "before")):
            kept = slice(0, -1) if off > 0 else slice(1, None)
            moved = {n: np.roll(plain[n], -off) for n in POSITION}
            yield f"its readings stand one row {word} the poses that they belong to", made(**moved).select(kept)
    for unit, factor in _LENGTHS.items():
        yield f"its x, y, z are in {unit}", made(**{n: factor * np.asarray(plain[n]) for n in POSITION})


def _recounted(
    log: MeasurementLog, turning: Sequence[str], sliding: Sequence[str]
) -> Iterator[tuple[str, MeasurementLog]]:
    """Mistakes in axis values, as `_corrected`: units, an axis's sign or zero, two axes exchanged or added up."""
    plain = {n: np.asarray(v) for n, v in log.columns.items() if n not in ("a", "b", "c")}

    def made(**changed: Array) -> MeasurementLog:
        signed = {f"{kind}{n}": v for n, v in changed.items() for kind in ("", "c")}
        return MeasurementLog(plain | {n: v for n, v in signed.items() if n in plain}, log.info, log.path)

    def of(axes: Sequence[str]) -> dict[str, Array]:
        return {a: plain[a] if a in plain else plain[f"c{a}"] for a in axes}

    for a, v in of(sliding).items():
        yield f"its {a} counts the other way", made(**{a: -v})
        for unit, factor in _LENGTHS.items():
            yield f"its {a} is in {unit}", made(**{a: factor * v})
    value = of(turning)
    yield "its axis values are in radians", made(**{a: rad_to_deg(v) for a, v in value.items()})
    for a, v in value.items():
        yield f"its {a} is in radians", made(**{a: rad_to_deg(v)})
        yield f"its {a} counts the other way", made(**{a: -v})
        for zero in _ZEROS:
            yield f"its {a} is counted from {zero:g} degrees off the cell's zero", made(**{a: v + zero})
    for a, b in combinations(value, 2):
        yield f"its {a} and {b} are exchanged", made(**{a: value[b], b: value[a]})
    for a, b in pairwise(value):
        for sign, word in ((1.0, "added"), (-1.0, "taken off")):
            words = f"its {b} counts from the horizontal, not from the link before it (Fanuc's J3 does): {a} has to be {word}"
            yield words, made(**{b: value[b] + sign * value[a]})
