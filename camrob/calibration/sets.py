"""Sets of measured poses, each with the model of its own instrument, within one list of parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.error_model import ErrorModel
from camrob.calibration.fit import Fit, fit_parameters
from camrob.calibration.identify import Identifiability, identify
from camrob.calibration.measurements import Measurements, sampled_rows
from camrob.calibration.parameters import Parameter, ParameterSet
from camrob.calibration.stands import Stand, owner_of, placed, placed_together, with_others_known
from camrob.calibration.terms import FRAMES, SIDES, parameter_of, plain_name, set_name, side_of
from camrob.cell.cell import Cell
from camrob.frozen import locked

__all__ = [
    "Prepared",
    "SetModel",
    "fit_frames",
    "frames_of_all",
    "identifiability",
    "named_parameter",
    "nuisance_of",
    "prepare_sets",
]

Array = NDArray[np.float64]

_SAMPLE = 2000  # rows that suffice to see what the data tell
_SIGMA_POSITION, _SIGMA_ANGLE = 5e-5, 1e-4  # m and rad an axis, where LOG.toml is silent


@dataclass(frozen=True, slots=True)
class SetModel:
    """The model of one set among parameters of several: `columns` say where its own stand in the `count` of all."""

    model: ErrorModel
    columns: NDArray[np.int64]
    count: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "columns", locked(self.columns, shape=(None,), dtype=np.int64, name="columns"))

    def poses(self, values: Array, q: Array) -> Array:
        """Target poses (N, 4, 4) of postures q (N, n); values: (count,)."""
        return self.model.poses(np.asarray(values)[self.columns], q)

    def poses_and_jacobian(self, values: Array, q: Array) -> tuple[Array, Array]:
        """Poses (N, 4, 4) and their derivatives (N, 6, count) by all parameters, 0 by other sets' own."""
        poses, J = self.model.poses_and_jacobian(np.asarray(values)[self.columns], q)
        if np.array_equal(self.columns, np.arange(self.count)):
            return poses, J
        wide = np.zeros((*J.shape[:2], self.count))
        wide[:, :, self.columns] = J
        return poses, wide


@dataclass(frozen=True, slots=True)
class Prepared:
    """Measured poses with the model of their instrument, its parameters among `names`, those of all sets.

    nuisance: names that are the instruments' alone.
    """

    model: SetModel
    data: Measurements
    names: tuple[str, ...]
    nuisance: tuple[str, ...]

    def with_names(self, names: Sequence[str]) -> Prepared:
        """The same set with fewer parameters; the instrument stays where it was placed."""
        kept = tuple(names)
        model = self.model.model
        own = [(k, self.names[c]) for k, c in enumerate(self.model.columns) if self.names[c] in kept]
        plain = [model.names[k] for k, _ in own]
        less = ErrorModel.of(model.cell, plain, in_base=model.in_base, left=model.arrays.left, right=model.arrays.right)
        columns = np.array([kept.index(name) for _, name in own], np.int64)
        return Prepared(SetModel(less, columns, len(kept)), self.data, kept, self.nuisance)


def nuisance_of(data: Measurements) -> tuple[str, ...]:
    """Names of base and tool that are the instrument's, since its frame or its reflector is unknown."""
    known = {"base": data.frame_known, "tool": data.target_known}
    return tuple(n for n in FRAMES if not known[side_of(n)])


def named_parameter(cell: Cell, name: str) -> Parameter:
    """The free parameter of a name, `base.x@2` being the base of the second set's instrument."""
    plain = parameter_of(cell, plain_name(name))
    return Parameter(name, plain.unit, plain.scale, lower=plain.lower, upper=plain.upper)


def prepare_sets(cell: Cell, sets: Sequence[Measurements], names: Sequence[str]) -> tuple[Prepared, ...]:
    """Every set with its model; unknown instruments and reflectors are placed first and get parameters of their own.

    Those of the first set bear the plain names where all sets are alike unknown, those of set k are `base.x@k`; sets that name
    another one's instrument or reflector as theirs have that one's. Raises LogError for too few poses and SingularError where an
    instrument can't be placed.
    """
    sets = with_others_known(sets)
    own = [nuisance_of(data) for data in sets]
    shared = {n for n in FRAMES if all(n in part for part in own)}
    owners = [{side: owner_of(sets, k, side) for side in SIDES} for k in range(len(sets))]
    called = [
        {n: n if (n in shared and k == 0) else set_name(n, k + 1) for n in part for k in [owned[side_of(n)]]}
        for owned, part in zip(owners, own, strict=True)
    ]
    frames = [n for n in names if n in FRAMES]
    everything: list[str] = []
    for renamed in called:
        everything += [renamed.get(n, n) for n in frames]
    everything = list(dict.fromkeys([*everything, *(n for n in names if n not in FRAMES)]))
    nuisance = tuple(n for n in everything if any(n in renamed.values() for renamed in called))
    prepared = []
    for data, renamed, (left, right) in zip(sets, called, placed_together(cell, sets), strict=True):
        model = ErrorModel.of(cell, tuple(names), in_base=data.in_base, left=left, right=right)
        columns = np.array([everything.index(renamed.get(n, n)) for n in names], np.int64)
        prepared.append(Prepared(SetModel(model, columns, len(everything)), data, tuple(everything), nuisance))
    return tuple(prepared)


def identifiability(
    sets: Sequence[Prepared], scales: Array, noise: Sequence[tuple[float, float]] | None = None
) -> Identifiability:
    """What the poses of some sets tell of their parameters, at the nominal values.

    noise: deviations an axis of each set, m and rad, where they are larger than the instrument's: what no model
    explains blurs as noise does. Raises ValueError where nothing can be fitted.
    """
    rows = []
    for part, (blur_p, blur_a) in zip(sets, noise or [(0.0, 0.0)] * len(sets), strict=True):
        data = part.data
        index = sampled_rows(len(data), _SAMPLE)
        J = part.model.poses_and_jacobian(np.zeros(len(part.names)), data.q[index])[1]
        sigma_p = data.sigma_position if data.sigma_position > 0.0 else _SIGMA_POSITION
        sigma_a = data.sigma_angle if data.sigma_angle > 0.0 else _SIGMA_ANGLE
        J = data.told(J, index)
        J[:, :3] /= max(sigma_p, blur_p)
        J[:, 3:] /= max(sigma_a, blur_a)
        gain = float(np.sqrt(len(data) / len(index)))
        rows.append(gain * J[:, : 6 if data.oriented else 3].reshape(-1, J.shape[2]))
    return identify(sets[0].names, np.concatenate(rows), scales)


def fit_frames(
    cell: Cell, data: Measurements, robot: ParameterSet, base: Stand | None = None, tool: Stand | None = None
) -> tuple[ErrorModel, Fit]:
    """Base and tool fitted with the robot's own parameters held; the model has both. base, tool: known by another set; not both.

    For a first look (no robot parameters), and to carry a robot's parameters over to another instrument.
    """
    own = [p.name for p in robot.items_ if p.name not in FRAMES]
    left, right = placed(cell, data, base, tool)

    def seen_from(names: Sequence[str]) -> ErrorModel:
        return ErrorModel.of(cell, tuple(names), in_base=data.in_base, left=left, right=right)

    model = seen_from((*FRAMES, *own))
    free = [n for n in FRAMES if (base, tool)[SIDES.index(side_of(n))] is None]
    alone = Prepared(SetModel(seen_from(free), np.arange(len(free)), len(free)), data, tuple(free), ())
    seen = identifiability([alone], np.full(len(free), 1e-3))
    moved = {**(base.moved if base else {}), **(tool.moved if tool else {})}
    parameters = [replace(parameter_of(cell, n), value=moved.get(n, 0.0)) for n in FRAMES] + [robot[n] for n in own]
    held = [*own, *(n for n in FRAMES if n not in seen.kept)]
    return model, fit_parameters([(model, data)], ParameterSet.of(parameters).fixed(held))


def frames_of_all(
    cell: Cell, sets: Sequence[Measurements], alone: Sequence[tuple[ErrorModel, Array]]
) -> Sequence[tuple[ErrorModel, Array]]:
    """Base and tool of each set, the robot being nominal: as fitted to it alone, or, where sets name others' as theirs, to all
    together, so that each has what the calibrated fit has. alone: model and values of each set's own fit.
    """
    if all(owner_of(sets, k, side) == k for k in range(len(sets)) for side in SIDES):
        return alone
    prepared = prepare_sets(cell, sets, FRAMES)
    seen = identifiability(prepared, np.full(len(prepared[0].names), 1e-3))
    kept = [part.with_names(seen.kept) for part in prepared]
    free = ParameterSet.of(named_parameter(cell, n) for n in seen.kept)
    values = fit_parameters([(part.model, part.data) for part in kept], free).parameters.values_array
    return [(part.model.model, values[part.model.columns]) for part in kept]
