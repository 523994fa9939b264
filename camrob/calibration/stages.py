"""A cell's models from the nominal robot to the calibrated one, and the errors that each leaves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.calibration import ErrorSize
from camrob.calibration.error_model import ErrorModel
from camrob.calibration.fit import residuals
from camrob.calibration.measurements import Measurements
from camrob.calibration.parameters import ParameterSet
from camrob.calibration.pose_by_pose import PoseErrors
from camrob.calibration.sets import fit_frames
from camrob.calibration.stands import Stand
from camrob.calibration.terms import FRAMES
from camrob.cell.cell import Cell
from camrob.errors import LogError

__all__ = ["Stages", "carried_over", "pose_errors_of", "sizes"]

Array = NDArray[np.float64]
Stage = tuple[ErrorModel, Array]

_OUTLIER = 5.0  # deviations, as in the fit
_FEWEST = 16  # poses of a withheld log whose instrument has to be placed on half of them


@dataclass(frozen=True, slots=True)
class Stages:
    """Models with their parameters' values: base and tool fitted alone, calibrated, and, where the instrument is known,
    nominal. spread: the fit's deviations an axis, m and rad.
    """

    frames: Stage
    calibrated: Stage
    spread: tuple[float, float]
    nominal: Stage | None = None

    def with_nominal(self, nominal: Stage) -> Stages:
        """The same with the nominal robot."""
        return replace(self, nominal=nominal)

    def seen_from(self, cell: Cell, in_base: bool) -> Stages:
        """The same models for poses that another known instrument sees from `world` or from `base`."""

        def turned(stage: Stage) -> Stage:
            return ErrorModel.of(cell, stage[0].names, in_base=in_base), stage[1]

        nominal = None if self.nominal is None else turned(self.nominal)
        return replace(self, frames=turned(self.frames), calibrated=turned(self.calibrated), nominal=nominal)


def carried_over(
    cell: Cell,
    data: Measurements,
    robot: ParameterSet,
    spread: tuple[float, float],
    stands: Sequence[tuple[Stand | None, Stand | None]] = ((None, None), (None, None)),
) -> tuple[Measurements, Stages]:
    """The poses of another set that judge a robot's parameters: all where base and tool are known by fitted sets, else the half
    on whose other half what is unknown is refitted. stands: base and tool, as known without and with these parameters.

    Raises LogError for too few poses.
    """
    known = all(side is not None for side in stands[0])
    if not known and len(data) < _FEWEST:
        hint = f"{_FEWEST} are needed, since its instrument is placed on half of them"
        raise LogError(f"holds {len(data)} whole poses", hint=hint, path=data.name)
    half = np.random.default_rng(1).permutation(len(data)) < (0 if known else len(data) // 2)
    models: list[Stage] = []
    for given, (base, tool) in zip((ParameterSet.of(()), robot), stands, strict=True):
        if base is not None and tool is not None:
            names = (*FRAMES, *given)
            model = ErrorModel.of(cell, names, in_base=data.in_base, left=base.place, right=tool.place)
            values = {**base.moved, **tool.moved, **{p.name: p.value for p in given.items_}}
            models.append((model, np.array([values.get(n, 0.0) for n in names])))
        else:
            model, fit = fit_frames(cell, data.select(half), given, base, tool)
            models.append((model, fit.parameters.values_array))
    return data.select(~half), Stages(models[0], models[1], spread)


def pose_errors_of(data: Measurements, stages: Stages, *, withheld: bool, refitted: bool = False) -> PoseErrors:
    """What each stage leaves of some poses."""
    models = {"nominal": stages.nominal, "frames": stages.frames, "calibrated": stages.calibrated}
    left = {name: residuals(stage[0], stage[1], data) for name, stage in models.items() if stage is not None}
    e = left["calibrated"] / np.repeat([max(stages.spread[0], 1e-12), max(stages.spread[1], 1e-12)], 3)
    e = e if data.oriented else e[:, :3]
    cell = stages.calibrated[0].cell
    return PoseErrors(
        log=data.name,
        withheld=withheld,
        rows=np.asarray(data.rows),
        axis_values=cell.to_axis_values(np.asarray(data.q)),
        oriented=data.oriented,
        residuals=left,
        outlier=np.linalg.norm(e, axis=1) > _OUTLIER * np.sqrt(e.shape[1] - 3.0 * (1.0 - data.share)),
        sigma=data.sigma_position,
        refitted=refitted,
    )


def sizes(poses: Sequence[PoseErrors], stage: str) -> ErrorSize | None:
    """The sizes of the errors of some sets at a stage; None where a set lacks it, or there are none."""
    if not poses or any(stage not in p.residuals for p in poses):
        return None
    place = np.concatenate([p.distance(stage) for p in poses])
    turns = [p.angle(stage) for p in poses if p.oriented]
    turn = np.concatenate(turns) if turns else np.zeros(1)
    return ErrorSize.of(place, turn, oriented=bool(turns))
