"""What a diagnosis says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.calibration import Calibration
from camrob.frozen import locked
from camrob.gap.experiment.motions import TrialMotion

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
    """`summary` is the contract's JSON object; `claimed` the effects found; `paths` what pictures are drawn from; `motions`
    what would tell most if it were run next, the best first; `calibration` what `compensate` can correct, None for nothing.
    """

    summary: Mapping[str, Any]
    claimed: tuple[str, ...]
    paths: tuple[PathError, ...]
    motions: tuple[TrialMotion, ...] = ()
    calibration: Calibration | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "summary", MappingProxyType(dict(self.summary)))
