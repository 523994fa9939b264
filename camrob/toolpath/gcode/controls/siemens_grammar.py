"""How Siemens' expressions are read."""

from __future__ import annotations

import math

from camrob.toolpath.gcode.language.formulas import ARITHMETIC, COMPARISONS, FUNCTIONS, LOGIC, Grammar

__all__ = ["GRAMMAR"]


def _ends(a: float, b: float) -> float:
    return float(math.trunc(a / b)) if b else ARITHMETIC["/"](a, b)


GRAMMAR = Grammar(
    levels=(
        {"|": LOGIC["OR"], "~": LOGIC["XOR"]},
        {"&": LOGIC["AND"]},
        {
            "==": COMPARISONS["EQ"],
            "<>": COMPARISONS["NE"],
            ">=": COMPARISONS["GE"],
            "<=": COMPARISONS["LE"],
            ">": COMPARISONS["GT"],
            "<": COMPARISONS["LT"],
        },
        {"+": ARITHMETIC["+"], "-": ARITHMETIC["-"]},
        {"*": ARITHMETIC["*"], "/": ARITHMETIC["/"], "!": _ends, "%": ARITHMETIC["MOD"]},
    ),
    functions={
        **{k: v for k, v in FUNCTIONS.items() if k not in ("ATAN",)},
        "POT": lambda x: x * x,
        "TRUNC": lambda x: float(math.trunc(x)),
    },
    opens="(",
    closes=")",
)
"""Of the 840D: comparisons with two signs, DIV and MOD as `!` and `%`."""
