"""Blocks of G-code that compute, jump or call: what lies behind them is not read."""

from __future__ import annotations

import re

__all__ = ["COMPUTED", "computes"]

COMPUTED = "loops, branches, subprograms and variables"  # what stands in a gap of such blocks
_FLOW = re.compile(r"(?:O(\d+|<[^>]*>|\[.*?\])([A-Z]+)|(WHILE).*DO(\d+)|(END)(\d+)|(IF|GOTO)\b|(IF|GOTO)[\[\d#])")
_CALLS = re.compile(r"M0*9[78](?![0-9.])|G0*6[56](?![0-9.])")


def computes(block: str, *, begun: bool) -> bool:
    """Whether the block (upper case, no blanks) is one of these; begun: something has moved before it.

    M99 in front of the first motion ends a subprogram that stands before the main program.
    """
    if re.fullmatch(r"O?<[\w.-]*>", block):
        return False
    calls = _CALLS.search(block) or (block.endswith("M99") and not begun)
    return bool(_FLOW.match(block) or calls or any(c in block for c in "#[=<"))
