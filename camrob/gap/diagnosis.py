"""What a diagnosis says."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.calibration import Calibration
from camrob.frozen import locked
from camrob.gap.experiment.motions import TrialMotion
from camrob.summaries.diagnosis_summary import DiagnosisSummary

__all__ = ["Diagnosis", "PathError"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class PathError:
    """For pictures: nominal TCP positions (M, 3) m, error before and after (M, 3) m, time (M,), program line (M,), zeros without
    one; poses: single poses instead of a path.
    """

    log: str
    position: Array
    before: Array
    after: Array
    t: Array
    line: NDArray[np.int64]
    poses: bool = False

    def __post_init__(self) -> None:
        for name in ("position", "before", "after", "t"):
            object.__setattr__(self, name, locked(getattr(self, name), name=name))
        object.__setattr__(self, "line", locked(self.line, dtype=np.int64, name="line"))


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """`summary` is what the contract's file holds; `claimed` the effects found; `paths` what pictures are drawn from; `motions`
    what would tell most if it were run next, the best first; `calibration` what `compensate` can correct, None for nothing.
    """

    summary: DiagnosisSummary
    claimed: tuple[str, ...]
    paths: tuple[PathError, ...]
    motions: tuple[TrialMotion, ...] = ()
    calibration: Calibration | None = None
