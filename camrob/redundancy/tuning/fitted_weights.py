"""Weights of h_jnt or h_cond fitted to paths: the best constant vector and the best engine, by one search, budget and merit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.redundancy_settings import TABLES
from camrob.frozen import locked
from camrob.progress import Share
from camrob.redundancy.fuzzy.fis import FuzzySystem, read_fis
from camrob.redundancy.fuzzy.surfaces import WeightSurface, constant_surface, engine_surface
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.published.virtual_joint import PathFollower
from camrob.redundancy.published.weighting import Weighting, engine_weighting
from camrob.redundancy.tuning.engine_parameters import EngineParameters, as_sugeno
from camrob.redundancy.tuning.evolution import Found, minimise
from camrob.redundancy.tuning.merit import Merit, followed_merit

__all__ = ["ENGINES", "FittedConstant", "FittedEngine", "Judge", "fit_constant", "fit_engine"]

Array = NDArray[np.float64]

ENGINES = {"joint": "joint_engine", "condition": "condition_engine"}
"""The engines by what they weigh, h_jnt or h_cond, with their names in the cell's settings."""

_MIDDLE = 0.1  # the weight that a search begins with: the geometric middle of the engines' 0.01 to 1, about
_WEIGHT_SPREAD = 1.0  # of a weight's logarithm: a factor of e either way
_GAP_SPREAD = 0.4  # of a gap's logarithm: a term half as wide again
_LEAST, _MOST = np.log(1e-3), np.log(10.0)  # the weights that are looked at


class Judge:
    """Weights judged on paths: the mean price of `Merit`, followers kept between calls.

    cell: whose engines are fitted; paths: each with the cell that holds its tool.
    """

    def __init__(self, cell: Cell, paths: Sequence[tuple[Cell, ToolPathInBase]]) -> None:
        self.cell = cell
        own = engine_weighting(cell)
        self.followers = [PathFollower(mounted, path, weighting=own) for mounted, path in paths]

    def merits(self, weighting: Weighting, *, revise: bool = True) -> list[Merit]:
        """The merit of each path with these weights."""
        out = []
        for follower in self.followers:
            follower.weigh(weighting)
            out.append(followed_merit(follower, revise=revise))
        return out

    def price(self, weighting: Weighting) -> float:
        """The mean price over the paths, m a metre cut."""
        return float(np.mean([m.price for m in self.merits(weighting)]))


@dataclass(frozen=True, slots=True)
class FittedConstant:
    """Weights (outputs,) of an engine's outputs that don't depend on the posture, and how they were found.

    system: the engine with all terms of an output alike.
    """

    outputs: tuple[str, ...]
    weights: Array
    system: FuzzySystem
    weighting: Weighting
    found: Found

    def __post_init__(self) -> None:
        object.__setattr__(self, "weights", locked(self.weights, shape=(len(self.outputs),), name="weights"))


@dataclass(frozen=True, slots=True)
class FittedEngine:
    """A Sugeno engine that stands for the cell's, and how it was found."""

    system: FuzzySystem
    weighting: Weighting
    found: Found


def fit_constant(
    judge: Judge, *, budget: int, seed: int, of: str = "joint", progress: Share | None = None
) -> FittedConstant:
    """The best constant weights for the outputs of one of the cell's engines; joints that it doesn't weigh keep the default.

    `of` names the engine, by ENGINES. Raises CellError for one that can't be read.
    """
    cell, engine = judge.cell, getattr(judge.cell.resolve, ENGINES[of])
    parameters = EngineParameters(as_sugeno(read_fis(cell.folder / engine.file)))
    names = tuple(o.name for o in parameters.system.outputs)
    own = engine_weighting(cell)

    def weighting(vector: Array) -> Weighting:
        weights = np.full(len(cell), engine.default_weight)
        for joint, output in engine.weights.items():
            weights[cell.index(joint)] = np.exp(np.clip(vector[names.index(output)], _LEAST, _MOST))
        return _with(own, of, constant_surface(weights))

    start = np.full(len(names), np.log(_MIDDLE))
    found = minimise(
        lambda x: judge.price(weighting(x)),
        [start],
        spread=np.full(len(names), _WEIGHT_SPREAD),
        budget=budget,
        seed=seed,
        progress=progress,
    )
    weights = np.exp(np.clip(found.vector, _LEAST, _MOST))
    return FittedConstant(names, weights, parameters.engine(parameters.alike(weights)), weighting(found.vector), found)


def fit_engine(
    judge: Judge, *, budget: int, seed: int, of: str = "joint", progress: Share | None = None
) -> FittedEngine:
    """One of the cell's engines with its terms moved, begun at the cell's own or at all weights alike, whichever is better.

    `of` names the engine, by ENGINES. Raises CellError for one that can't be read.
    """
    cell, engine = judge.cell, getattr(judge.cell.resolve, ENGINES[of])
    own = engine_weighting(cell)
    parameters = EngineParameters(as_sugeno(read_fis(cell.folder / engine.file)))
    finer = replace(engine, table=TABLES[0])

    def weighting(vector: Array) -> Weighting:
        return _with(own, of, engine_surface(cell, finer, parameters.engine(vector)))

    begin = parameters.start
    constants = sum(len(o.terms) for o in parameters.system.outputs)
    spread = np.full(len(begin), _GAP_SPREAD)
    spread[len(begin) - constants :] = _WEIGHT_SPREAD
    alike = parameters.alike(np.full(len(parameters.system.outputs), _MIDDLE))
    found = minimise(
        lambda x: judge.price(weighting(x)), [begin, alike], spread=spread, budget=budget, seed=seed, progress=progress
    )
    return FittedEngine(parameters.engine(found.vector), weighting(found.vector), found)


def _with(own: Weighting, of: str, surface: WeightSurface) -> Weighting:
    """The cell's weighting with another surface for h_jnt or h_cond."""
    return replace(own, joint=surface) if of == "joint" else replace(own, condition=surface)
