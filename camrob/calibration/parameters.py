"""Named parameters of a fit, as lmfit has them: a value, whether it may vary, between which bounds, how well it is
known.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

__all__ = ["Parameter", "ParameterSet"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter, SI. `scale` is its ordinary size, in which fits are conditioned; `std` is NaN until it was
    fitted.
    """

    name: str
    unit: str
    scale: float
    value: float = 0.0
    vary: bool = True
    lower: float = -math.inf
    upper: float = math.inf
    std: float = math.nan

    @property
    def at_bound(self) -> bool:
        """True where a varying value lies on one of its bounds."""
        near = 1e-9 * self.scale
        return self.vary and (self.value <= self.lower + near or self.value >= self.upper - near)


@dataclass(frozen=True, slots=True)
class ParameterSet(Mapping[str, Parameter]):
    """Parameters by name, in their order."""

    items_: tuple[Parameter, ...]

    @classmethod
    def of(cls, parameters: Iterable[Parameter]) -> ParameterSet:
        """A set of some parameters."""
        return cls(tuple(parameters))

    def __getitem__(self, name: str) -> Parameter:
        for parameter in self.items_:
            if parameter.name == name:
                return parameter
        raise KeyError(name)

    def __iter__(self) -> Iterator[str]:
        return (p.name for p in self.items_)

    def __len__(self) -> int:
        return len(self.items_)

    @property
    def values_array(self) -> Array:
        """(P,) values."""
        return np.array([p.value for p in self.items_])

    @property
    def varying(self) -> NDArray[np.bool_]:
        """(P,) True where a parameter may vary."""
        return np.array([p.vary for p in self.items_], bool)

    @property
    def scales(self) -> Array:
        """(P,) ordinary sizes."""
        return np.array([p.scale for p in self.items_])

    def with_values(self, values: Array, stds: Array | None = None) -> ParameterSet:
        """The same parameters with other values (P,), and their standard errors."""
        errors = np.array([p.std for p in self.items_]) if stds is None else stds
        together = zip(self.items_, values, errors, strict=True)
        return ParameterSet(tuple(replace(p, value=float(v), std=float(s)) for p, v, s in together))

    def fixed(self, names: Iterable[str]) -> ParameterSet:
        """The same parameters, those of these names held where they are."""
        held = set(names)
        return ParameterSet(tuple(replace(p, vary=False) if p.name in held else p for p in self.items_))

    def only(self, names: Iterable[str]) -> ParameterSet:
        """Those of these names, in the set's order."""
        kept = set(names)
        return ParameterSet(tuple(p for p in self.items_ if p.name in kept))
