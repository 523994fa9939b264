"""Whether a G-code program computes, whose rules it follows, and its blocks in the order in which they are run."""

from __future__ import annotations

import re

from camrob.witness.cl.running.bracket_values import Style
from camrob.witness.cl.running.macro_run import MacroRun
from camrob.witness.cl.running.o_word_run import O_WORD, OWordRun
from camrob.witness.cl.running.ordered import Row
from camrob.witness.cl.running.running_blocks import Ask, Running
from camrob.witness.cl.running.unread import UnreadError

__all__ = ["run_of"]

_COMPUTED = re.compile(r"[#\[=]|^(/\d?)?(N\d+)?(IF|GOTO|WHILE|DO\d|END\d)|M0*9[789](?![\d.])|G0*6[567](?![\d.])")
_MACRO = re.compile(r"^(/\d?)?(N\d+)?(IF\[|WHILE\[|GOTO|DO\d|END\d)|M0*9[789](?![\d.])|G0*6[567](?![\d.])")
_O_WORDS = re.compile(r"#<|\*\*|EXISTS\[")
_CUT_SHORT = "WHILE ROUND FIX FUP SIN COS TAN ASIN ACOS ATAN SQRT ABS EXP".split()
_SUM = re.compile(r"^(N\d+)?#[^=]*=(.*)")


def run_of(rows: list[Row], ask: Ask, *, own: bool = False) -> Running | None:
    """How the blocks (without blanks and comments, upper case) of a program that computes are run; None for one that doesn't.

    own: the file's suffix is LinuxCNC's.
    Raises UnreadError for a program of two controls.
    """
    rows = [(line, _in_full(block)) for line, block in rows]
    if not any(_COMPUTED.search(block) or O_WORD.match(block) for _, block in rows):
        return None
    words = any(O_WORD.match(block) for _, block in rows)
    linuxcnc = words or any(_O_WORDS.search(block) for _, block in rows)
    fanuc = any(_MACRO.search(block) or _summed(block) for _, block in rows)
    linuxcnc = linuxcnc or (own and not fanuc)
    styles = (Style.MACRO,) if fanuc else (Style.O_WORDS,) if linuxcnc else tuple(Style)
    if fanuc and linuxcnc:
        raise UnreadError("words of Fanuc's and of LinuxCNC's")
    return OWordRun(rows, styles, ask) if linuxcnc else MacroRun(rows, styles, ask)


def _in_full(block: str) -> str:
    """Fanuc's words that stand there by two letters (B-63944, 15.2): WH[ for WHILE[, RO[ for ROUND[ and so on."""
    for word in _CUT_SHORT if "[" in block else ():
        block = re.sub(rf"(?<![A-Z]){word[:2]}(?=\[)", word, block)
    block = re.sub(r"\]TH(?!EN)(?=[A-Z#])", "]THEN", re.sub(r"\]GO(?=[\d#\[])", "]GOTO", block))
    return re.sub(r"^((?:N\d+)?)EN(?=\d+$)", r"\1END", block)


def _summed(block: str) -> bool:
    """Whether a variable is set to a sum that stands in no brackets, which LinuxCNC doesn't read."""
    found = _SUM.match(block)
    if found is None:
        return False
    deep, bare = 0, ""
    for letter in found[2]:
        deep -= letter == "]"
        bare += letter if deep <= 0 else ""
        deep += letter == "["
    bare = bare.replace("[]", "0").replace("ATAN0/0", "0")
    return bool(re.match(r"[-+]?#*(?:[A-Z]{2,5})?[\d.]+(?:[-+*/]|MOD|AND|X?OR)", bare))
