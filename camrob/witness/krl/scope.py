"""Names of a KRL program with their values, by where they are declared."""

from __future__ import annotations

import copy

from camrob.witness.krl.functions import Value, rounded

__all__ = ["Scope"]


class Scope(dict[str, Value]):
    """Names with their values, and the types that they were declared with."""

    def __init__(self) -> None:
        self.kinds: dict[str, str] = {}
        self.lost: set[str] = set()  # whose values were, and aren't known any more

    def put(self, name: str, value: Value) -> None:
        """Sets X or X[3]: an INT takes a REAL rounded, half away from zero, and a REAL an INT as it is."""
        kind = self.kinds.get(name.split("[")[0], "")
        if kind == "INT" and isinstance(value, float):
            whole = rounded(value)
            if whole is None:
                self.lost.add(name)
                self.pop(name, None)
                return
            value = whole
        elif kind == "REAL" and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)
        self.lost.discard(name)
        self[name] = copy.deepcopy(value) if isinstance(value, dict) else value  # a copy: P.X may change in one alone
