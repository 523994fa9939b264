"""What of an engine a search may move: the corners of its inputs' terms, and what its rules conclude.

A Mamdani engine is written as a Sugeno engine first, each term of an output the constant that it stands for alone (its
centroid): a weight is then what the file says, and an engine whose terms are all alike is a constant vector. An input's corners
move as one warp of its axis, so that their order, and that some rule fires everywhere, are kept; a conclusion moves by a factor.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.redundancy.fuzzy.fis import SAMPLES, FuzzySystem, FuzzyVariable, Membership

__all__ = ["EngineParameters", "as_sugeno"]

Array = NDArray[np.float64]

_CORNERED = ("trimf", "trapmf", "zmf", "smf")  # kinds whose parameters are corners in their order
_LEAST, _MOST = 1e-3, 10.0  # weights that a conclusion may have; the default of Table 2 is 0.01


def as_sugeno(system: FuzzySystem) -> FuzzySystem:
    """A Mamdani system's rules with constants for conclusions; a Sugeno system as it is."""
    if system.kind == "sugeno":
        return system
    outputs = []
    for output in system.outputs:
        x = np.linspace(output.lower, output.upper, SAMPLES)
        terms = tuple(
            Membership(t.name, "constant", (float(np.trapezoid(x * t(x), x) / np.trapezoid(t(x), x)),))
            for t in output.terms
        )
        outputs.append(replace(output, terms=terms))
    return replace(system, outputs=tuple(outputs), kind="sugeno", defuzzification="wtaver")


@dataclass(frozen=True, slots=True)
class EngineParameters:
    """The vector of a Sugeno system: for each input the logarithms of the gaps between its corners, over what they were, then for
    each output the logarithms of its constants. The zero vector with `start`'s constants is the system itself.
    """

    system: FuzzySystem

    @property
    def inner(self) -> tuple[Array, ...]:
        """For each input its corners from end to end, the ends of its range first and last."""
        return tuple(_knots(variable) for variable in self.system.inputs)

    @property
    def start(self) -> Array:
        """The vector of the system itself."""
        gaps = np.zeros(sum(len(k) - 1 for k in self.inner))
        return np.concatenate([gaps, np.log(self._constants())])

    def _constants(self) -> Array:
        return np.array([t.parameters[-1] for o in self.system.outputs for t in o.terms])

    def alike(self, weights: Array) -> Array:
        """The vector of the engine whose outputs are constants (outputs,)."""
        each = [np.full(len(o.terms), np.log(w)) for o, w in zip(self.system.outputs, weights, strict=True)]
        return np.concatenate([np.zeros(len(self.start) - len(self._constants())), *each])

    def engine(self, vector: Array) -> FuzzySystem:
        """The system that a vector stands for."""
        at, inputs = 0, []
        for variable, knots in zip(self.system.inputs, self.inner, strict=True):
            gaps = np.diff(knots) * np.exp(np.clip(vector[at : at + len(knots) - 1], -3.0, 3.0))
            at += len(knots) - 1
            moved = knots[0] + np.concatenate([[0.0], np.cumsum(gaps)]) * (knots[-1] - knots[0]) / gaps.sum()
            moved[-1] = knots[-1]
            inputs.append(_warped(variable, knots, moved))
        outputs = []
        for output in self.system.outputs:
            values = np.clip(np.exp(vector[at : at + len(output.terms)]), _LEAST, _MOST)
            at += len(output.terms)
            terms = tuple(
                replace(t, parameters=(*(p * v / t.parameters[-1] for p in t.parameters[:-1]), float(v)))
                for t, v in zip(output.terms, values, strict=True)
            )
            outputs.append(replace(output, terms=terms, lower=0.0, upper=float(max(values.max(), output.upper))))
        return replace(self.system, inputs=tuple(inputs), outputs=tuple(outputs))


def _knots(variable: FuzzyVariable) -> Array:
    corners = {c for t in variable.terms if t.kind in _CORNERED for c in t.parameters}
    return np.array(
        [variable.lower, *sorted(c for c in corners if variable.lower < c < variable.upper), variable.upper]
    )


def _warped(variable: FuzzyVariable, knots: Array, moved: Array) -> FuzzyVariable:
    """The variable with its corners moved as the knots are; corners beyond the range stay where they are."""

    def to(corner: float) -> float:
        return float(np.interp(corner, knots, moved)) if knots[0] <= corner <= knots[-1] else corner

    terms = tuple(
        replace(t, parameters=tuple(to(c) for c in t.parameters)) if t.kind in _CORNERED else t for t in variable.terms
    )
    return replace(variable, terms=terms)
