"""The search for weights: CMA-ES (the library `cma`) over a constant vector or over an engine's parameters, with one budget."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.frozen import locked
from camrob.progress import Share

__all__ = ["Found", "minimise"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Found:
    """The best vector that a search has met, its price, how many were tried, and the best price after each of them."""

    vector: Array
    price: float
    tried: int
    course: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "vector", locked(self.vector, shape=(None,), name="vector"))
        object.__setattr__(self, "course", locked(self.course, shape=(None,), name="course"))


def minimise(
    price: Callable[[Array], float],
    starts: Sequence[Array],
    *,
    spread: Array,
    budget: int,
    seed: int,
    progress: Share | None = None,
) -> Found:
    """The vector of least `price` met with `budget` evaluations, begun at the best of `starts` (n,).

    spread (n,): how far a parameter is thought to move. The same seed finds the same vector. CMA-ES of N. Hansen, never
    restarted: what is left of the budget when it has converged is not used.
    """
    import cma

    best, least = np.asarray(starts[0], float), np.inf
    course: list[float] = []

    def look(x: Array) -> float:
        nonlocal best, least
        value = float(price(x))
        if value < least:
            best, least = np.array(x), value
        course.append(least)
        if progress is not None:
            progress(min(1.0, len(course) / budget))
        return value

    for start in starts[: max(1, budget)]:
        look(np.asarray(start, float))
    options = {
        "seed": seed + 1,
        "verbose": -9,
        "verb_disp": 0,
        "verb_log": 0,
        "CMA_stds": list(spread),
    }  # 0: by the clock
    search = cma.CMAEvolutionStrategy(list(best), 1.0, options)
    while not search.stop() and len(course) + search.popsize <= budget:
        tried = search.ask()
        search.tell(tried, [look(np.asarray(x)) for x in tried])
    return Found(best, least, len(course), np.array(course))
