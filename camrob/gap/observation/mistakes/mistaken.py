"""A log that can't be this cell's, tried for what is wrong: frames, columns, rows, units, axes' signs or zeros, the cell."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.gap.observation.mistakes.mistaken_cells import corrected_cells
from camrob.gap.observation.mistakes.stale_axis import stale_axis
from camrob.gap.observation.scene import Scene, make_scene
from camrob.measurement.log import DISTANCE, POSITION, MeasurementLog
from camrob.measurement.log_info import MeasuredFrame, Target
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["mistaken"]

Array = NDArray[np.float64]

_SOME = 600  # rows that tell well enough
_LEFT = 0.1  # of the gap that is left where a mistake is corrected, at the most
_CLEARER = 0.5  # times the next best mending: then it is this one
_ALIKE = 3.0  # times what rows in mm are, that rows in another unit are at the most once they are converted
_FIT = 0.02  # of how far apart the readings lie, that is left at the most where frames are left open, which fit to much
_LENGTHS = {"inches": 25.4, "metres": 1000.0, "centimetres": 10.0}  # mm
_OPEN: dict[str, dict[str, Any]] = {
    "measured_frame": {"measured_frame": MeasuredFrame.UNKNOWN},
    "d_from_mm": {"distance_from": None, "distance_from_unknown": True, "measured_frame": MeasuredFrame.UNKNOWN},
    "target": {"target": Target.UNKNOWN},
}
_ZEROS = (90.0, -90.0, 180.0)  # degrees by which makers and textbooks count axes differently


def mistaken(scene: Scene) -> str:
    """What was mixed up in a log, in words, "" where nothing that was tried mends it. Each is tried once, alone.

    scene: a log whose gap is incredible as it stands.
    """
    turning = [a for a in scene.axes if not scene.cell.joints[scene.cell.index(a)].prismatic]
    sliding = [a for a in scene.axes if a not in turning]
    log, told = scene.log, (*_corrected(scene.log), *_recounted(scene.log, turning, sliding))
    plain = [(words, other, scene.cell) for words, other in (*told, *_on_the_other_side(log, scene.cell))]
    cells = [(words, scene.log, cell) for words, cell in corrected_cells(scene.cell)]
    one, two = ([(w, log, scene.cell) for w, log in _opened(scene.log, count)] for count in (1, 2))
    units = list(_in_other_units(scene.log, turning))
    with_frames = [(f"{w}, and {m}", o, scene.cell) for w, log in units for n in (1, 2) for m, o in _opened(log, n)]
    # the fewest mistakes first, and those that leave no frame open
    return (
        _best(scene, [*plain, *cells])
        or stale_axis(scene)
        or _best(scene, [(w, log, scene.cell) for w, log in units])
        or _best(scene, one, opened=True)
        or _best(scene, two, opened=True)
        or _best(scene, with_frames, opened=True)
    )


def _best(scene: Scene, tried: Sequence[tuple[str, MeasurementLog, Cell]], *, opened: bool = False) -> str:
    """Of mistakes, each with log and cell as if it had not been made, what the best one leaves, in words; "" for too much.

    opened: they leave a frame open.
    """
    rows = np.unique(np.linspace(0, len(scene) - 1, min(len(scene), _SOME)).astype(int))
    found = []
    for words, log, cell in tried:
        # neighbours belong together where rows are one off, so these are thinned only after
        part = make_scene(log if scene.poses else log.select(rows[rows < len(log)]), cell)
        place = part.measured[:, :3, 3]
        apart = float(np.linalg.norm(place - place.mean(axis=0), axis=1).mean())
        if not opened or _size(part) <= _FIT * apart:
            found.append((_size(part), words))
    found.sort(key=lambda f: f[0])
    if not found or found[0][0] > _LEFT * _size(scene):
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
    here = [n for n in POSITION if n in plain]
    for axis in here[:1] if own_frame else here:
        # in a frame of its own, which axis is mirrored can't be known: all three differ by a rotation
        name = "its frame is mirrored (left-handed)" if own_frame else f"its {axis} is mirrored"
        yield name, made(**{axis: -np.asarray(plain[axis])})
    if not own_frame:
        for first, second in combinations(here, 2):
            yield (
                f"its columns {first} and {second} are exchanged",
                made(**{first: plain[second], second: plain[first]}),
            )
    if log.info.poses and len(log) > 1:
        for off, word in ((1, "after"), (-1, "before")):
            kept = slice(0, -1) if off > 0 else slice(1, None)
            moved = {n: np.roll(plain[n], -off) for n in (*here, DISTANCE) if n in plain}
            yield f"its readings stand one row {word} the poses that they belong to", made(**moved).select(kept)


def _opened(log: MeasurementLog, count: int) -> Iterator[tuple[str, MeasurementLog]]:
    """A log whose frame, or whose target, or both (count 2), are not what its facts say, or mean by silence."""
    plain = {n: v for n, v in log.columns.items() if n not in ("a", "b", "c")}
    told = {}
    if log.info.distance_from is not None:
        told['d_from_mm = "unknown"'] = "its distances are from another place"
    elif log.info.measured_frame is not MeasuredFrame.UNKNOWN and DISTANCE not in plain:
        told['measured_frame = "unknown"'] = f"{_places(log)} are in a frame of the instrument's own"
    if log.info.target is not Target.UNKNOWN:
        told['target = "unknown"'] = "the target that was measured is not the tool's tip"
    for keys in combinations(told, count):
        info = log.info
        for key in keys:
            info = replace(info, **_OPEN[key.partition(" ")[0]])
        words = " and ".join(told[k] for k in keys)
        yield f"{words} ({', '.join(keys)} in its .toml)", MeasurementLog(plain, info, log.path)


def _on_the_other_side(log: MeasurementLog, cell: Cell) -> Iterator[tuple[str, MeasurementLog]]:
    """Of a cell with a turning table: places on the table that are said to be in the room, and the other way round."""
    other = {MeasuredFrame.WORLD: MeasuredFrame.BASE, MeasuredFrame.BASE: MeasuredFrame.WORLD}.get(
        log.info.measured_frame
    )
    if other is not None and any(j.role is Role.WORKPIECE for j in cell.joints):
        plain = {n: v for n, v in log.columns.items() if n not in ("a", "b", "c")}
        where = "on the turning table" if other is MeasuredFrame.BASE else "in the room, not on the table"
        words = f'{_places(log)} are {where} (measured_frame = "{other}" in its .toml)'
        yield words, MeasurementLog(plain, replace(log.info, measured_frame=other), log.path)


def _in_other_units(log: MeasurementLog, turning: Sequence[str]) -> Iterator[tuple[str, MeasurementLog]]:
    """Units of angles, of lengths, and of both mistaken at once, as by whoever writes SI into all columns."""
    plain = {n: np.asarray(v) for n, v in log.columns.items() if n not in ("a", "b", "c")}
    turned = {n: rad_to_deg(plain[n]) for a in turning for n in (a, f"c{a}") if n in plain}
    yield "its axis values are in radians", MeasurementLog(plain | turned, log.info, log.path)
    for unit, factor in _LENGTHS.items():
        longer = {n: factor * plain[n] for n in _measured(log)}
        yield f"its {_places(log)} are in {unit}", MeasurementLog(plain | longer, log.info, log.path)
        words = f"its axis values are in radians and its {_places(log)} in {unit}"
        yield words, MeasurementLog(plain | turned | longer, log.info, log.path)
    yield from _in_two_units(log, plain)


def _in_two_units(log: MeasurementLog, plain: dict[str, Array]) -> Iterator[tuple[str, MeasurementLog]]:
    """Some rows in another unit than the others: files of two instruments, or of two settings, one behind the other."""
    names = _measured(log)
    size = np.linalg.norm([plain[n] for n in names], axis=0)
    for unit, factor in _LENGTHS.items():
        small = size * factor < _ALIKE * np.median(size[size > size.max() / factor])
        if not small.any() or small.all():
            continue
        longer = {n: np.where(small, factor * plain[n], plain[n]) for n in names}
        words = f"its {_places(log)} are in {unit} in {small.sum()} rows ({_lines(log, small)}), in mm in the others"
        yield words, MeasurementLog(plain | longer, log.info, log.path)


def _lines(log: MeasurementLog, rows: NDArray[np.bool_]) -> str:
    """Where in its file some of a log's rows stand, in words."""
    where = np.flatnonzero(rows)
    lines = where + 1 if log.file_lines is None else np.asarray(log.file_lines)[where]
    return f"line {lines[0]} to {lines[-1]}"


def _measured(log: MeasurementLog) -> list[str]:
    """The columns of lengths that were measured."""
    return [n for n in (*POSITION, DISTANCE) if n in log.columns]


def _places(log: MeasurementLog) -> str:
    return ", ".join(_measured(log))


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
    for a, v in value.items():
        yield f"its {a} is in radians", made(**{a: rad_to_deg(v)})
        yield f"its {a} counts the other way", made(**{a: -v})
        for zero in _ZEROS:
            yield f"its {a} is counted from {zero:g} degrees off the cell's zero", made(**{a: v + zero})
    yield "all its axes count the other way", made(**{a: -v for a, v in value.items()})
    for a, b in combinations(value, 2):
        yield f"its {a} and {b} count the other way", made(**{a: -value[a], b: -value[b]})
    small = [a for a, v in value.items() if float(np.abs(v).max()) <= 2.0 * np.pi]
    if 1 < len(small) < len(value):
        yield f"its {', '.join(small)} are in radians", made(**{a: rad_to_deg(value[a]) for a in small})
    for a, b in combinations(value, 2):
        yield f"its {a} and {b} are exchanged", made(**{a: value[b], b: value[a]})
    for a, b in pairwise(value):
        for sign, word in ((1.0, "added"), (-1.0, "taken off")):
            words = f"its {b} counts from the horizontal, not from the link before it (Fanuc's J3 does): {a} has to be {word}"
            yield words, made(**{b: value[b] + sign * value[a]})
