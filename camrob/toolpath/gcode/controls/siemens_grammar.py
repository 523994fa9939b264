"""How Siemens' expressions are read."""

from __future__ import annotations

import math

from camrob.toolpath.gcode.language.formulas import ARITHMETIC, COMPARISONS, FUNCTIONS, LOGIC, Grammar, Reader

__all__ = ["GRAMMAR", "signed"]


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


def signed(reader: Reader) -> float:
    """A plain number with or without its sign."""
    negative = False
    while reader.rest[:1] and reader.rest[0] in "+-":
        negative ^= reader.rest[0] == "-"
        reader.at += 1
    number = reader.number()
    if number is None:
        raise reader.fail()
    return -number if negative else number
