"""RAPID's statements that are understood, and what each does."""

from __future__ import annotations

import re
from typing import NamedTuple

__all__ = ["STATEMENTS", "RapidRow"]

_REAL = r"\d+\.?\d*(?:E[-+]?\d+)?"


class RapidRow(NamedTuple):
    """A statement of RAPID: what it looks like, what is done about it, and what it does, for the docs."""

    pattern: re.Pattern[str]
    act: str
    does: str


def _row(pattern: str, act: str, does: str) -> RapidRow:
    return RapidRow(re.compile(pattern), act, does)


STATEMENTS = (
    _row(
        r"(?P<word>MOVEABSJ|MOVEJ|MOVEL|MOVEC) ?(?P<rest>.+)", "move", "moves: axes, a pose by axes, a line, a circle"
    ),
    _row(r"(?P<word>MOVE|TRIGG|SEARCH|ARC[LC])\w*(?: .*)?", "unread_move", "other motions: not judged"),
    _row(rf"WAITTIME(?P<still> ?\\INPOS ?,)? ?(?P<value>{_REAL})", "wait", "stands still for seconds"),
    _row(r"(?:SETDO|SETAO|SETGO) ?(?:\\\w+(?: ?:= ?[^,]+)? ?,)? ?(?P<rest>.+)", "output", "an output"),
    _row(r"(?:SET|RESET|PULSEDO|INVERTDO)\b ?(?:(?:\\\w+(?: ?:= ?[^,\\]+)? ?)+,)? ?\w+", "output", "an output"),
    _row(r"(?:STOP|BREAK)(?: ?\\\w+)?", "halt", "waits for the operator"),
    _row(r"(?:WAITDI|WAITDO|WAITUNTIL|WAITAI|WAITGI|WAITSYNCTASK) .+", "wait_for", "waits for something outside"),
    _row(r"(?:TPWRITE|TPERASE|CLKRESET|CLKSTART|CLKSTOP|ERRWRITE)(?:[ (\\].*)?", "nothing", "the pendant, clocks"),
    _row(r"PATHACCLIM (?P<on>TRUE|FALSE) ?(?P<rest>.*)", "acceleration", "acceleration along the path"),
    _row(
        rf"ACCSET (?P<a>{_REAL}) ?, ?(?P<b>{_REAL})",
        "ramps",
        "acceleration and its rise in percent: 100 is the default",
    ),
    _row(rf"VELSET (?P<a>{_REAL}) ?, ?(?P<b>{_REAL})", "override", "all speeds in percent, and the tip's most"),
    _row(r"CONFJ ?\\(?P<on>ON|OFF)", "configuration", "whether MoveJ keeps to its target's configuration"),
    _row(r"CONFL ?\\(?:ON|OFF)", "nothing", "whether a line that ends in another configuration is refused"),
    _row(r"SINGAREA ?\\(?P<on>\w+)", "singular", "Off: the tool turns as programmed"),
    _row(r"CIRPATHMODE ?\\(?P<how>\w+)", "circle", "ObjectFrame: the tool turns as along a line"),
    _row(r"(?:PDISPOFF|EOFFSOFF)", "nothing", "no displaced frames, as by default"),
    _row(r"ACTUNIT (?P<unit>\w+)", "unit", "a mechanical unit takes part"),
    _row(
        r"(?P<path>[A-Z_]\w*(?: ?\{[^{}]*\}| ?\. ?[A-Z_]\w*)*) ?:= ?(?P<value>.+)",
        "assign",
        "a datum, or a part of it, is set",
    ),
    _row(r"(?P<how>INCR|DECR|CLEAR) (?P<path>[A-Z_]\w*)", "count", "a num is one more, one less, 0"),
    _row(r"ADD (?P<path>[A-Z_]\w*) ?, ?(?P<value>[^,]+)", "add", "a num is so much more"),
    _row(r"EXIT", "end", "the program ends here, whatever called"),
    _row(r"RETURN", "leave", "back to the caller"),
    _row(r"(?P<name>[A-Z_]\w*)(?: (?P<inputs>[^\\].*))?", "call", "another procedure"),
)
"""Statements, in capitals; what is on no row isn't judged."""
