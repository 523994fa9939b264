"""Calibration of a cell from measured poses: what can be told, the fit, and what it is worth on poses that took no
part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.calibrate.align import align
from camrob.calibrate.calibration import Calibration, ErrorSize, Held, robot_digest
from camrob.calibrate.error_model import ErrorModel
from camrob.calibrate.fit import Fit, fit_parameters, pose_errors
from camrob.calibrate.identify import Identifiability, identify
from camrob.calibrate.measurements import Measurements, sampled_rows, withheld_rows
from camrob.calibrate.parameters import ParameterSet
from camrob.calibrate.terms import PARTS, parameter_of, standard_names
from camrob.cell.cell import Cell
from camrob.errors import JobError, LogError, SingularError
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["FRAMES", "Prepared", "calibrate_cell", "fit_frames", "identifiability", "prepare"]

Array = NDArray[np.float64]

FRAMES = tuple(f"{owner}.{part}" for owner in ("base", "tool") for part in PARTS)
_SAMPLE = 2000  # rows that suffice to see what the data tell
_SIGMA_POSITION, _SIGMA_ANGLE = 5e-5, 1e-4  # m and rad an axis, where LOG.toml is silent
_FEWEST = 8
_MOST_POSITION, _MOST_ANGLE = 0.03, 0.06  # m and rad an axis: no robot that works is so far off
_EXPLAINED = 0.2  # of what base and tool leave, a calibration is expected to leave so much


@dataclass(frozen=True, slots=True)
class Prepared:
    """Measured poses with the model of their instrument; nuisance: parameters that are the instrument's alone."""

    model: ErrorModel
    data: Measurements
    nuisance: tuple[str, ...]


def prepare(cell: Cell, data: Measurements, names: Sequence[str]) -> Prepared:
    """The model of some parameters for measured poses; an unknown instrument and reflector are placed first.

    Raises LogError for too few poses and SingularError where the instrument can't be placed.
    """
    if len(data) < _FEWEST:
        raise LogError(
            f"holds {len(data)} whole poses", cure=f"measure {_FEWEST} at the least, better 50", path=data.name
        )
    nuisance = tuple(
        name
        for owner, known in (("base", data.frame_known), ("tool", data.target_known))
        for name in FRAMES
        if name.startswith(owner) and not known
    )
    plain = ErrorModel.of(cell, (), in_base=data.in_base)
    index = sampled_rows(len(data), _SAMPLE)
    left, right = align(
        plain.poses(np.zeros(0), data.q[index]),
        np.asarray(data.frames[index]),
        oriented=data.oriented,
        frame_known=data.frame_known,
        target_known=data.target_known,
    )
    return Prepared(ErrorModel.of(cell, names, in_base=data.in_base, left=left, right=right), data, nuisance)


def identifiability(prepared: Prepared, scales: Array, noise: tuple[float, float] = (0.0, 0.0)) -> Identifiability:
    """What the poses tell of the model's parameters, at their nominal values.

    noise: deviations an axis, m and rad, where they are larger than the instrument's: what no model explains blurs as
    noise does.
    """
    data, model = prepared.data, prepared.model
    index = sampled_rows(len(data), _SAMPLE)
    J = model.poses_and_jacobian(np.zeros(len(model.names)), data.q[index])[1]
    sigma_p = data.sigma_position if data.sigma_position > 0.0 else _SIGMA_POSITION
    sigma_a = data.sigma_angle if data.sigma_angle > 0.0 else _SIGMA_ANGLE
    J[:, :3] /= max(sigma_p, noise[0])
    J[:, 3:] /= max(sigma_a, noise[1])
    rows = 6 if data.oriented else 3
    gain = float(np.sqrt(len(data) / len(index)))
    return identify(model.names, J[:, :rows].reshape(-1, J.shape[2]), scales, gain=gain)


def fit_frames(cell: Cell, data: Measurements, robot: ParameterSet) -> tuple[ErrorModel, Fit]:
    """Base and tool fitted with the robot's own parameters held; the model has both.

    For a first look (no robot parameters), and to carry a robot's parameters over to another instrument.
    """
    own = [p.name for p in robot.items_ if p.name not in FRAMES]
    prepared = prepare(cell, data, (*FRAMES, *own))
    seen = identifiability(prepare(cell, data, FRAMES), np.full(len(FRAMES), 1e-3))
    parameters = [parameter_of(cell, n) for n in FRAMES] + [robot[n] for n in own]
    held = [*own, *(n for n in FRAMES if n not in seen.kept)]
    fit = fit_parameters([(prepared.model, data)], ParameterSet.of(parameters).fixed(held))
    return prepared.model, fit


def calibrate_cell(
    cell: Cell,
    data: Measurements,
    *,
    names: Sequence[str] | None = None,
    candidates: Sequence[str] | None = None,
    withheld: Measurements | None = None,
    share: float = 0.2,
) -> Calibration:
    """Calibrate a cell from measured poses.

    names: the parameters asked for; those are required, and a set of them that the poses can't tell apart is refused.
    Without, `candidates` (by default the standard ones) are tried, and what the poses don't tell is left out and
    said. withheld: poses that take no part, else a share of the poses (0: none). Raises LogError for data that can't
    serve, SingularError for parameters that can't be told apart, JobError for a fit that ends where no robot is.
    """
    tried = standard_names(cell, table=data.in_base) if candidates is None else tuple(candidates)
    asked = tried if names is None else tuple(names)
    if names is not None:  # an unknown instrument is always fitted
        always = [n for n in FRAMES if not (data.frame_known if n[0] == "b" else data.target_known)]
        asked = (*(n for n in always if n not in asked), *asked)
    if withheld is None and share > 0.0:
        mask = withheld_rows([data], share)[0]
        data, withheld = data.select(~mask), data.select(mask)
    prepared = prepare(cell, data, asked)
    scales = np.array([parameter_of(cell, n).scale for n in asked])
    frames = fit_frames(cell, data.select(sampled_rows(len(data), _SAMPLE)), ParameterSet.of(()))
    _believable(frames[1], data)
    noise = (_EXPLAINED * frames[1].scatter_position, _EXPLAINED * frames[1].scatter_angle)
    for _ in range(2):
        seen = _told(prepared, scales, noise, cell)
        if names is not None:
            _refuse(seen, names, data)
        kept, fit = _fitted(cell, prepared, seen.kept)
        as_hoped = fit.scatter_position <= 1.2 * noise[0] and fit.scatter_angle <= 1.2 * noise[1]
        if as_hoped or names is not None:
            break
        noise = fit.scatter_position, fit.scatter_angle  # more remains than was hoped: what is weak in it goes
    sets = {"fitted": data} | ({"withheld": withheld} if withheld is not None and len(withheld) else {})
    return Calibration(
        cell_name=cell.name,
        cell_digest=robot_digest(cell),
        parameters=fit.parameters,
        nuisance=tuple(n for n in seen.kept if n in prepared.nuisance),
        held=_held(seen),
        errors=_errors(prepared, frames, (kept, fit), sets),
        correlations=tuple(fit.strongest()),
        condition=seen.condition,
        observability=tuple(getattr(seen.observability, f"o{k}") for k in range(1, 6)),
        scatter_position=fit.scatter_position,
        scatter_angle=fit.scatter_angle if data.oriented else float("nan"),
        logs=((data.name, data.digest),),
        rows=len(data),
        outliers=fit.outliers,
        left_out=data.left_out,
        oriented=data.oriented,
        warnings=_warnings(fit, seen, data),
    )


def _fitted(cell: Cell, prepared: Prepared, names: tuple[str, ...]) -> tuple[ErrorModel, Fit]:
    """The model of the parameters that the poses tell, and their fit."""
    data, arrays = prepared.data, prepared.model.arrays
    rows = 6 if data.oriented else 3
    if len(data) * rows < 2 * len(names):
        cure = f"{len(names)} parameters need {-(-2 * len(names) // rows)} at the least"
        raise LogError(f"holds {len(data)} poses to fit", cure=cure, path=data.name)
    model = ErrorModel.of(cell, names, in_base=data.in_base, left=arrays.left, right=arrays.right)
    return model, fit_parameters([(model, data)], ParameterSet.of(parameter_of(cell, n) for n in names))


def _believable(frames: Fit, data: Measurements) -> None:
    """What base and tool leave can be a robot's errors. Raises JobError."""
    if frames.scatter_position > _MOST_POSITION or frames.scatter_angle > _MOST_ANGLE:
        place, turn = m_to_mm(frames.scatter_position), rad_to_deg(frames.scatter_angle)
        what = f"{data.name or 'the poses'} can't be this cell's: with base and tool fitted, {place:.1f} mm"
        raise JobError(f"{what} and {turn:.2f} degrees an axis remain; check the cell, the axes' signs and the units")


def _told(prepared: Prepared, scales: Array, noise: tuple[float, float], cell: Cell) -> Identifiability:
    try:
        return identifiability(prepared, scales, noise)
    except ValueError as error:
        raise SingularError(f"cell {cell.name} can't be calibrated from these poses: {error}") from None


def _refuse(seen: Identifiability, names: Sequence[str], data: Measurements) -> None:
    """A set that was asked for by name is fitted whole or not at all."""
    lost = [n for n in names if n in seen.left_out]
    if lost:
        first = lost[0]
        others = seen.merged.get(first, ())
        why = f"it can't be told from {', '.join(others[:6])}" if others else "the poses say too little of it"
        what = f"{', '.join(lost[:8])} can't be fitted to {data.name or 'these poses'}: {first}: {why}"
        raise SingularError(f"{what}; leave parameters out or measure other poses")


def _held(seen: Identifiability) -> tuple[Held, ...]:
    merged = [Held(n, "merged", others[:8]) for n, others in seen.merged.items()]
    return (*merged, *(Held(n, "unseen") for n in seen.unseen), *(Held(n, "weak") for n in seen.weak))


def _errors(
    prepared: Prepared,
    frames: tuple[ErrorModel, Fit],
    fitted: tuple[ErrorModel, Fit],
    sets: dict[str, Measurements],
) -> dict[str, ErrorSize]:
    """Errors by stage and set."""
    stages = [("frames", frames[0], frames[1].parameters.values_array)]
    if not prepared.nuisance:  # with an unknown instrument nothing can be said without fitting its frame
        plain = ErrorModel.of(prepared.model.cell, (), in_base=prepared.data.in_base)
        stages.insert(0, ("nominal", plain, np.zeros(0)))
    stages.append(("calibrated", fitted[0], fitted[1].parameters.values_array))
    return {
        f"{stage}/{name}": ErrorSize.of(*pose_errors(model, values, data), oriented=data.oriented)
        for stage, model, values in stages
        for name, data in sets.items()
    }


def _warnings(fit: Fit, seen: Identifiability, data: Measurements) -> tuple[str, ...]:
    """What a person should know before trusting the numbers."""
    said = []
    if fit.outliers > 0.02 * fit.rows:
        said.append(f"{fit.outliers} of {fit.rows} poses lie far off; look at the measurement")
    if fit.strongest(1) and abs(fit.strongest(1)[0][2]) > 0.98:
        a, b, r = fit.strongest(1)[0]
        said.append(f"{a} and {b} are nearly one parameter in these poses (correlation {r:.3f})")
    if data.sigma_position > 0.0 and fit.scatter_position > 3.0 * data.sigma_position:
        ratio = fit.scatter_position / data.sigma_position
        said.append(
            f"what remains is {ratio:.0f} times the instrument's noise: something else is at work that was not fitted"
        )
    return tuple(said)
