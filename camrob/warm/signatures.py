"""Which kernels there are and what they are called with: kernels.json, as data, since only a call would tell otherwise.

Types are spelled as JSON: a scalar by its name, an array as an object with its element, dimensions and layout, a tuple as
{"tuple": [..]}, and a named one with its class beside it.
"""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass
from importlib import import_module
from importlib.resources import files
from typing import Any

from numba import types

__all__ = ["Known", "known_kernels", "numba_type", "spelled"]


@dataclass(frozen=True, slots=True)
class Known:
    """A kernel, module:name, for one kind of arguments: which of its kinds that is, from 0, their types as JSON spells them, and
    s of processor that compiling it took somewhere.
    """

    kernel: str
    way: int
    seconds: float
    arguments: tuple[Any, ...]

    def dispatcher(self) -> Any:
        """Numba's object for it. Imports its module."""
        module, _, name = self.kernel.partition(":")
        return getattr(import_module(module), name).dispatcher

    def types(self) -> tuple[Any, ...]:
        """Its arguments' types as Numba has them."""
        return tuple(map(numba_type, self.arguments))


def known_kernels() -> tuple[Known, ...]:
    """The kernels of kernels.json, each as often as there are kinds of arguments for it."""
    rows = json.loads(files(__package__).joinpath("kernels.json").read_text("utf-8"))
    ways: Counter[str] = Counter()
    kernels = []
    for row in rows:
        kernels.append(Known(row["kernel"], ways[row["kernel"]], row["seconds"], tuple(row["arguments"])))
        ways[row["kernel"]] += 1
    return tuple(kernels)


def spelled(kind: Any) -> Any:
    """A type of Numba's as JSON spells it. Raises TypeError for one that no kernel has taken so far."""
    if isinstance(kind, types.Array):
        return {"array": str(kind.dtype), "dimensions": kind.ndim, "layout": kind.layout, "mutable": kind.mutable}
    if isinstance(kind, types.BaseNamedTuple):
        home = kind.instance_class
        return {"tuple": list(map(spelled, kind.types)), "class": f"{home.__module__}:{home.__qualname__}"}
    if isinstance(kind, types.BaseTuple):
        return {"tuple": list(map(spelled, kind.types))}
    kind = types.unliteral(kind)
    if getattr(types, str(kind), None) is kind:
        return str(kind)
    raise TypeError(f"no spelling for {kind}")


def numba_type(spelling: Any) -> Any:
    """The type of Numba's that JSON spells so."""
    if isinstance(spelling, str):
        return getattr(types, spelling)
    if "array" in spelling:
        element, n, layout = getattr(types, spelling["array"]), spelling["dimensions"], spelling["layout"]
        return types.Array(element, n, layout, readonly=not spelling["mutable"])
    members = [numba_type(member) for member in spelling["tuple"]]
    if "class" not in spelling:
        return types.Tuple(members)
    module, _, name = spelling["class"].partition(":")
    return types.NamedTuple(members, getattr(import_module(module), name))
