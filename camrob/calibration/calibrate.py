"""Calibration of a cell from measured poses: what can be identified, the fit, and what it is worth on poses that took no
part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.calibration import Calibration, ErrorSize, Held, robot_digest
from camrob.calibration.cautions import carries_badly, cautions, check_moved, far_off, moved_while_measured, stand_still
from camrob.calibration.error_model import ErrorModel
from camrob.calibration.fit import Fit, fit_parameters
from camrob.calibration.folds import FEW, fit_few, left_in_folds
from camrob.calibration.identify import Identifiability
from camrob.calibration.measurements import Measurements, postures_of, sampled_rows, withheld_rows
from camrob.calibration.parameters import ParameterSet
from camrob.calibration.pose_by_pose import CalibrationEvidence, PoseErrors
from camrob.calibration.sets import (
    Prepared,
    fit_frames,
    frames_of_all,
    identifiability,
    named_parameter,
    nuisance_of,
    prepare_sets,
)
from camrob.calibration.stages import Stages, carried_over, pose_errors_of, sizes
from camrob.calibration.stands import LEAST_POSES, Stand, owner_of, with_others_known
from camrob.calibration.terms import FRAMES, SIDES, is_one_sets, side_of, standard_names
from camrob.cell.cell import Cell
from camrob.errors import JobError, LogError, SingularError
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["CalibrationFit", "fit_cell"]

Array = NDArray[np.float64]

_SAMPLE = 2000  # rows that suffice for a first look
_MOST_POSITION, _MOST_ANGLE = 0.03, 0.06  # m and rad an axis: no robot that works is so far off
_MOST_SHIFT, _MOST_TURN = 0.2, 0.3  # m and rad: what base and tool are off by more is no error but another frame
_EXPLAINED = 0.2  # of what base and tool leave, a calibration is expected to leave so much
_CLEARER = (0.1, 0.03, 0.01)  # .. or, where more parameters say more of poses left out, so little
_BETTER = 0.9  # of what fewer parameters leave there, at the most: chance makes a few percent
# times that which parameters of ordinary size may leave where the instrument's frame is unknown: sizes part what both share
_AS_GOOD = 1.02
_FOLDED = 1000  # poses that it is tried with


@dataclass(frozen=True, slots=True)
class CalibrationFit:
    """A calibration and what it rests on."""

    calibration: Calibration
    evidence: CalibrationEvidence


def fit_cell(
    cell: Cell,
    data: Measurements | Sequence[Measurements],
    *,
    names: Sequence[str] | None = None,
    candidates: Sequence[str] | None = None,
    withheld: Measurements | Sequence[Measurements] | None = None,
    share: float = 0.2,
) -> CalibrationFit:
    """Calibrate a cell from one or several sets of measured poses.

    Sets of an unknown instrument get a base and a reflector of their own, or those of the set that they name. names: the
    parameters asked for; those are required, and a set of them that the poses can't tell apart is refused. Without,
    `candidates` (by default the standard ones) are tried, and what the poses don't tell is left out and said. withheld: sets
    that take no part, else a share of the poses (0: none). Where the instrument of a withheld set is unknown, only the robot's
    parameters carry over: base and reflector are refitted on half of it, and the other half judges; what it says to be a
    fitted set's is taken from there. Raises LogError for data that can't be used, SingularError for parameters that can't be
    told apart, JobError for a fit that ends where no robot is.
    """
    sets = [data] if isinstance(data, Measurements) else list(data)
    others = [withheld] if isinstance(withheld, Measurements) else list(withheld or ())
    _check_postures(sets)
    parts: list[Measurements | None] = [None] * len(sets)
    if withheld is None and share > 0.0:
        # where an instrument can then no longer be placed, no pose is withheld
        masks = [m if (~m).sum() >= LEAST_POSES else np.zeros_like(m) for m in withheld_rows(sets, share)]
        parts = [part.select(mask) for part, mask in zip(sets, masks, strict=True)]
        sets = [part.select(~mask) for part, mask in zip(sets, masks, strict=True)]
    prepared = prepare_sets(cell, sets, _asked(cell, sets, names, candidates))
    firsts = [fit_frames(cell, part.select(sampled_rows(len(part), _SAMPLE)), ParameterSet.of(())) for part in sets]
    for part, (model, first) in zip(sets, firsts, strict=True):
        _believable(cell, first, part)
        placed = model.poses(first.parameters.values_array, part.q)
        check_moved(part, (part.frames - placed)[:, :3, 3])
    kept, fit, seen = _fitted_as_far_as_seen(cell, prepared, [first for _, first in firsts], names)
    frames = frames_of_all(cell, sets, [(model, first.parameters.values_array) for model, first in firsts])
    stages = [_stages(part, stage, fit) for part, stage in zip(kept, frames, strict=True)]
    poses = [pose_errors_of(part, s, withheld=False) for part, s in zip(sets, stages, strict=True)]
    poses += [
        pose_errors_of(part, s, withheld=True)
        for part, s in zip(parts, stages, strict=True)
        if part is not None and len(part)
    ]
    moved = moved_while_measured(
        list(zip([*sets, *(p for p in parts if p is not None and len(p))], poses, strict=True))
    )
    for other in others:
        poses.append(_predicted(cell, other, stages, fit, kept))
    calibration = _result(cell, sets, kept[0], fit, seen, poses, (*moved, *stand_still(cell, sets)))
    return CalibrationFit(calibration, CalibrationEvidence(tuple(poses), fit.names, fit.correlation, seen.singular))


def _check_postures(sets: Sequence[Measurements]) -> None:
    """Raise LogError for poses that are few, though they were measured many times."""
    rows = sum(len(part) for part in sets)
    found = sum(int(postures_of(part).max(initial=-1)) + 1 for part in sets)
    if found < LEAST_POSES <= rows:
        hint = (
            f"a posture tells once what it tells, however often it is measured: give at least {LEAST_POSES}, better 50"
        )
        raise LogError(f"holds {rows} rows of {found} postures", hint=hint, path=sets[0].name)


def _asked(
    cell: Cell, sets: Sequence[Measurements], names: Sequence[str] | None, candidates: Sequence[str] | None
) -> tuple[str, ...]:
    """The names to try: those asked for and, always, those of unknown instruments; else the candidates."""
    if names is None:
        table = any(part.in_base for part in sets)
        return standard_names(cell, table=table) if candidates is None else tuple(candidates)
    unknown = {n for part in sets for n in nuisance_of(part)}
    return (*(n for n in FRAMES if n in unknown and n not in names), *names)


def _fitted_as_far_as_seen(
    cell: Cell, prepared: Sequence[Prepared], firsts: Sequence[Fit], names: Sequence[str] | None
) -> tuple[tuple[Prepared, ...], Fit, Identifiability]:
    """The sets with the parameters that the poses determine, and their fit."""
    scales = np.array([named_parameter(cell, n).scale for n in prepared[0].names])
    noise = [(_EXPLAINED * f.scatter_position, _EXPLAINED * f.scatter_angle) for f in firsts]
    for _ in range(2):
        seen = _identifiability(prepared, scales, noise, cell)
        if names is not None:
            _refuse(cell, seen, names, prepared[0].data)
        if names is None and not _many_enough(prepared, seen.kept):
            if (held := _held_to_sizes(prepared, cell, scales, firsts)) is not None:
                return held[1:]
        _enough(prepared, seen.kept)
        kept, fit = _fitted(cell, prepared, seen.kept)
        hoped_p, hoped_a = (max(n[k] for n in noise) for k in (0, 1))
        if names is not None:
            return kept, fit, seen
        if fit.scatter_position <= 1.2 * hoped_p and fit.scatter_angle <= 1.2 * hoped_a:
            break
        # more remains than was hoped: what is weak in it goes
        noise = [(fit.scatter_position, fit.scatter_angle)] * len(prepared)
    found = kept, fit, seen
    best = left_in_folds(kept, cell, seen.kept)
    for part in _CLEARER:
        # what remains may be the lack of what was taken to be weak, as much as noise
        clear = [(part * f.scatter_position, part * f.scatter_angle) for f in firsts]
        wider = _identifiability(prepared, scales, clear, cell)
        if wider.kept == found[2].kept or not _many_enough(prepared, wider.kept):
            continue
        try:
            left = left_in_folds(prepared, cell, wider.kept)
            if left < _BETTER * best:
                found, best = (*_fitted(cell, prepared, wider.kept), wider), left
        except (JobError, SingularError):
            continue  # so many can't be fitted to these poses
    poses = sum(len(part.data) for part in prepared)
    shifts = any(n.startswith("base.") for part in prepared for n in part.nuisance)
    if poses < FEW or (shifts and poses <= _FOLDED):
        held = _held_to_sizes(prepared, cell, scales, firsts)
        if held is not None and held[0] < (_AS_GOOD if shifts else _BETTER) * best:
            return held[1:]
    return found


def _held_to_sizes(
    prepared: Sequence[Prepared], cell: Cell, scales: Array, firsts: Sequence[Fit]
) -> tuple[float, tuple[Prepared, ...], Fit, Identifiability] | None:
    """All parameters that show, held to their ordinary sizes, as `fit_few` gives them."""
    clear = [(_CLEARER[-1] * f.scatter_position, _CLEARER[-1] * f.scatter_angle) for f in firsts]
    seen = _identifiability(prepared, scales, clear, cell)
    return fit_few(prepared, cell, seen, max(f.scatter_position for f in firsts))


def _fitted(cell: Cell, prepared: Sequence[Prepared], names: Sequence[str]) -> tuple[tuple[Prepared, ...], Fit]:
    """The sets with some of their parameters, and the fit of these."""
    kept = tuple(part.with_names(names) for part in prepared)
    pairs = [(part.model, part.data) for part in kept]
    return kept, fit_parameters(pairs, ParameterSet.of(named_parameter(cell, n) for n in names))


def _many_enough(prepared: Sequence[Prepared], names: tuple[str, ...]) -> bool:
    """Whether there are twice as many equations as parameters."""
    return _equations(prepared) >= 2 * len(names)


def _equations(prepared: Sequence[Prepared]) -> int:
    return sum(len(p.data) * (3 * p.data.oriented + round(3 * p.data.share)) for p in prepared)


def _enough(prepared: Sequence[Prepared], names: tuple[str, ...]) -> None:
    """Raise LogError where the poses are too few for the parameters."""
    if _many_enough(prepared, names):
        return
    poses = sum(len(part.data) for part in prepared)
    hint = f"{len(names)} parameters need at least {-(-2 * len(names) * poses // _equations(prepared))}"
    raise LogError(f"holds {poses} poses to fit", hint=hint, path=prepared[0].data.name)


def _believable(cell: Cell, frames: Fit, data: Measurements) -> None:
    """What base and tool leave can be a robot's errors, and they are errors themselves. Raises LogError and JobError."""
    known = [p for p in frames.parameters.items_ if p.name not in nuisance_of(data)]
    farthest = [max((abs(p.value) for p in known if p.unit == unit), default=0.0) for unit in ("m", "rad")]
    scattered = frames.scatter_position > _MOST_POSITION or frames.scatter_angle > _MOST_ANGLE
    if not scattered and farthest[0] <= _MOST_SHIFT and farthest[1] <= _MOST_TURN:
        return
    seen = f'"{"base" if data.in_base else "world"}"'
    if known and (not scattered or _fits_elsewhere(cell, data)):
        hint = 'say measured_frame = "unknown" and target = "unknown" in LOG.toml, or give the poses of the tip'
        raise LogError(f"holds poses of another frame or target than {seen} and the tool", hint=hint, path=data.name)
    place, turn = m_to_mm(frames.scatter_position), rad_to_deg(frames.scatter_angle)
    what = f"{data.name or 'the poses'} can't be this cell's: with base and tool fitted, {place:.1f} mm"
    hint = "check the cell, the axes' signs, the units, measured_frame, and that rows and readings belong together"
    raise JobError(f"{what} and {turn:.2f} degrees an axis remain; {hint}")


def _fits_elsewhere(cell: Cell, data: Measurements) -> bool:
    """Whether the poses are the robot's, seen from some other place."""
    free = replace(data.select(sampled_rows(len(data), _SAMPLE)), frame_known=False, target_known=False)
    try:
        fit = fit_frames(cell, free, ParameterSet.of(()))[1]
    except SingularError:
        return False
    return fit.scatter_position <= _MOST_POSITION and fit.scatter_angle <= _MOST_ANGLE


def _identifiability(
    prepared: Sequence[Prepared], scales: Array, noise: Sequence[tuple[float, float]], cell: Cell
) -> Identifiability:
    try:
        return identifiability(prepared, scales, noise)
    except ValueError as error:
        raise SingularError(f"cell {cell.name} can't be calibrated from these poses: {error}") from None


def _refuse(cell: Cell, seen: Identifiability, names: Sequence[str], data: Measurements) -> None:
    """A set that was asked for by name is fitted whole or not at all."""
    lost = [n for n in names if n in seen.left_out]
    if lost:
        first = lost[0]
        others = seen.merged.get(first, ())
        why = f"it can't be told from {', '.join(others[:6])}" if others else "the poses say too little about it"
        if first.endswith(".compliance") and not cell.masses:
            why = f"cell {cell.name} states no masses, so that gravity's torques aren't known"
        what = f"{', '.join(lost[:8])} can't be fitted to {data.name or 'these poses'}: {first}: {why}"
        raise SingularError(f"{what}; leave parameters out or measure other poses")


def _stages(part: Prepared, frames: tuple[ErrorModel, Array], fit: Fit) -> Stages:
    """The models of a fitted set, from the nominal robot to the calibrated one."""
    values = fit.parameters.values_array
    found = Stages(
        frames=frames,
        calibrated=(part.model.model, values[np.asarray(part.model.columns)]),
        spread=(fit.scatter_position, fit.scatter_angle),
    )
    if nuisance_of(part.data):  # with an unknown instrument nothing can be said without fitting its frame
        return found
    plain = ErrorModel.of(part.model.model.cell, (), in_base=part.data.in_base)
    return found.with_nominal((plain, np.zeros(0)))


def _predicted(
    cell: Cell, data: Measurements, stages: Sequence[Stages], fit: Fit, kept: Sequence[Prepared]
) -> PoseErrors:
    """The errors of a set that took no part. Its instrument and its reflector are those of the fitted sets that it names."""
    sets = with_others_known([*(part.data for part in kept), data])
    data = sets[-1]
    if not kept[0].nuisance and not nuisance_of(data):
        return pose_errors_of(data, stages[0].seen_from(cell, data.in_base), withheld=True)
    robot = fit.parameters.only(n for n in fit.names if n not in FRAMES and not is_one_sets(n))
    owners = [owner_of(sets, len(kept), side) for side in SIDES]

    def known(stage: str) -> tuple[Stand | None, Stand | None]:
        base, tool = (
            _stand(getattr(stages[k], stage), side) if k < len(kept) else None
            for side, k in zip(SIDES, owners, strict=True)
        )
        return base, tool

    stands = (known("frames"), known("calibrated"))
    judging, refitted = carried_over(cell, data, robot, stages[0].spread, stands)
    return pose_errors_of(judging, refitted, withheld=True, refitted=len(judging) < len(data))


def _stand(stage: tuple[ErrorModel, Array], side: str) -> Stand:
    """Where a set's instrument stands, or its reflector sits, at a stage of its fit."""
    model, values = stage
    place = model.arrays.left if side == "base" else model.arrays.right
    named = zip(model.names, values.tolist(), strict=True)
    return Stand(np.asarray(place), {n: v for n, v in named if n in FRAMES and side_of(n) == side})


def _result(
    cell: Cell,
    sets: Sequence[Measurements],
    kept: Prepared,
    fit: Fit,
    seen: Identifiability,
    poses: Sequence[PoseErrors],
    said: Sequence[str],
) -> Calibration:
    """What was found, as it is written. Bases and reflectors of later sets end here: they are nobody's but the fit's.

    said: what is to be said of the poses themselves.
    """
    oriented = any(part.oriented for part in sets)
    own = [n for n in seen.kept if not is_one_sets(n)]
    return Calibration(
        cell_name=cell.name,
        cell_digest=robot_digest(cell),
        parameters=fit.parameters.only(own),
        nuisance=tuple(n for n in own if n in kept.nuisance),
        held=_held(seen),
        errors=_errors(poses),
        correlations=tuple((a, b, r) for a, b, r in fit.strongest(60) if not is_one_sets(a) and not is_one_sets(b))[
            :10
        ],
        condition=seen.condition,
        observability=tuple(getattr(seen.observability, f"o{k}") for k in range(1, 6)),
        scatter_position=fit.scatter_position,
        scatter_angle=fit.scatter_angle if oriented else float("nan"),
        logs=tuple((part.name, part.digest) for part in sets),
        rows=sum(len(part) for part in sets),
        outliers=fit.outliers,
        left_out=sum(part.left_out for part in sets),
        oriented=oriented,
        warnings=(*said, *far_off(poses), *cautions(fit, sets), *carries_badly(poses)),
    )


def _held(seen: Identifiability) -> tuple[Held, ...]:
    merged = [Held(n, "merged", others[:8]) for n, others in seen.merged.items()]
    every = (*merged, *(Held(n, "unseen") for n in seen.unseen), *(Held(n, "weak") for n in seen.weak))
    return tuple(h for h in every if not is_one_sets(h.name))


def _errors(poses: Sequence[PoseErrors]) -> dict[str, ErrorSize]:
    """Errors by stage and set."""
    return {
        f"{stage}/{name}": size
        for stage in ("nominal", "frames", "calibrated")
        for name, withheld in (("fitted", False), ("withheld", True))
        if (size := sizes([p for p in poses if p.withheld is withheld], stage)) is not None
    }
