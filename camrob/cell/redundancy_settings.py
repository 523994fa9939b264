"""What a cell says about how its redundancy is to be resolved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

__all__ = ["CONDITION_TERMS", "EVEN", "TABLES", "FuzzyEngine", "ResolveSettings"]

CONDITION_TERMS = ("recorded", "gradient", "off")
EVEN = "even"
TABLES = ("corners", EVEN)


@dataclass(frozen=True, slots=True)
class FuzzyEngine:
    """A fuzzy inference engine: its file in the cell's folder, and which of its outputs weighs which joint.

    The engine's inputs are named after axes and take their values as programs print them. A joint that `weights` doesn't
    name gets `default_weight` (Table 2 of the paper: 0.01), and all do where there is no file (""). `table` says where the nodes
    of the compiled engine lie: at the corners of its terms and crowded about them, or evenly.
    """

    file: str
    weights: Mapping[str, str]
    default_weight: float = 0.01
    table: str = TABLES[0]

    def __post_init__(self) -> None:
        object.__setattr__(self, "weights", MappingProxyType(dict(self.weights)))


@dataclass(frozen=True, slots=True)
class ResolveSettings:
    """Settings of the published method.

    `threshold` on 1/k_F below which the condition term acts; `joint_engine` weighs h_jnt, `condition_engine` h_cond.
    `condition_term`: "recorded" draws the posture back to the one in which the threshold was crossed (eq. 18), "gradient"
    leads down the gradient of k_F itself, "off" leaves the term out.
    `planned` holds the weights of the planner's objective under the names that its documentation gives.
    """

    threshold: float
    joint_engine: FuzzyEngine
    condition_engine: FuzzyEngine
    planned: Mapping[str, float] = field(default_factory=dict)
    condition_term: str = CONDITION_TERMS[0]

    def __post_init__(self) -> None:
        object.__setattr__(self, "planned", MappingProxyType(dict(self.planned)))
