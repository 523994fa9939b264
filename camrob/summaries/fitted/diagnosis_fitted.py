"""What of a diagnosis can be reckoned on other paths: the claimed units, and what stays beside them as a field over posture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from camrob.summaries.base import OpenSummary, left_out

__all__ = ["FittedModel", "FittedUnit", "UnexplainedSaid", "UnitParameter"]

Rows = tuple[tuple[float, ...], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class UnitParameter(OpenSummary):
    """A parameter as `camrob predict` needs it: its ordinary size and fitted value in SI; unit: that of the trade."""

    name: str
    unit: str
    usual: float
    value: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedUnit(OpenSummary):
    """A claimed unit: its effect, axis and kind, its parameters, and the state in which it was fitted."""

    effect: str
    axis: str
    key: str
    parameters: tuple[UnitParameter, ...]
    state: Mapping[str, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class UnexplainedSaid(OpenSummary):
    """What no claimed unit explains, as a Gaussian process over posture, SI; frame: `world` or `base`, in which it moves it.

    axes: that it follows; tables: which of them turn the part; postures: (m, k) rad, and of sliding axes units of 0.5 m, at
    which it is known: mean (m, 3), covariance (m, m) of each direction, by_value (m, 3 K) by how much less the mean is for a unit
    more of each of the K fitted parameters, direction by direction; by_open (m, 3 L) likewise of the L that are open. variance:
    of its prior, same: of a constant beside it, m2. rest: m in one direction, what is neither.
    """

    axes: tuple[str, ...]
    tables: tuple[int, ...]
    frame: str
    postures: Rows
    mean: Rows
    covariance: Rows
    by_value: Rows
    variance: float
    same: float
    rest: float
    by_open: Rows = left_out(())


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedModel(OpenSummary):
    """What is claimed, to be reckoned on other paths; covariance: (K, K) of all parameters in order, SI, as if nothing else were
    there. unexplained: what stays beside it, None where no field was found, and in files of before 2026-11-24. open_units: what
    was not claimed and may be there; open_root: (K + L, R), whose square is by how much more the covariance of claimed and open
    parameters is for that; neither is in files of before 2026-11-28.
    """

    units: tuple[FittedUnit, ...]
    covariance: Rows
    unexplained: UnexplainedSaid | None = left_out()
    open_units: tuple[FittedUnit, ...] = left_out(())
    open_root: Rows = left_out(())
