"""How custom macro B writes expressions (Fanuc B-63944EN/03, 15.4): ranks of operators, functions, variables without a value."""

from __future__ import annotations

import math

from camrob.toolpath.gcode.language.formulas import ARITHMETIC, BITS, COMPARISONS, FUNCTIONS, Grammar, Value, fup
from camrob.units import rad_to_deg

__all__ = ["FANUC"]


def _compared(name: str, a: Value, b: Value) -> float | None:
    """EQ and NE of a variable without a value, which is no zero."""
    if name in ("EQ", "NE") and (a is None or b is None):
        return float((a is b) == (name == "EQ"))
    return None


FANUC = Grammar(
    levels=(
        COMPARISONS,
        {k: {**ARITHMETIC, **BITS}[k] for k in ("+", "-", "OR", "XOR")},
        {k: {**ARITHMETIC, **BITS}[k] for k in ("*", "/", "MOD", "AND")},
    ),
    functions={**FUNCTIONS, "FIX": lambda x: float(math.trunc(x)), "FUP": fup, "SQR": FUNCTIONS["SQRT"]},
    atan=lambda y, x: rad_to_deg(math.atan2(y, x)) % 360.0,
    compares=_compared,
)
