"""SOLIDWORKS CAM and CAMWorks: APT output, and the native .clt."""

from __future__ import annotations

import re

from camrob.errors import ToolpathError
from camrob.toolpath.apt.cycles import Cycle, cycle_fields, keyed_cycle
from camrob.toolpath.apt.dialects.dialect import Dialect, message, score
from camrob.toolpath.apt.lexer import Statement, number_of

__all__ = ["CAMWORKS", "CAMWORKS_CLT"]


def _recognise(head: str) -> int:
    weights = {r"^CSI_SET_": 12, r"^TRNTYP/": 10, r"^INSERT/\[HOLDER": 5, r"^INSERT/Stock Size": 5, r"^RAPID/": 1}
    return score(head, weights)


def _recognise_clt(head: str) -> int:
    return score(head, {r"^OPFEATSTART/": 20, r"^MOVE_ATTRIB/": 8, r"^OPFEATEND/": 5, r"^BOX/": 2})


def _cycle(statement: Statement) -> Cycle:
    """FEDTO is positive into the part, from the GOTO's point; RAPTO and RTRCTO lie above it."""
    name, fields, loose = cycle_fields(statement.args)
    return keyed_cycle(name, fields, fields.get("FEDTO"), statement.line, loose)


def _cycle_clt(statement: Statement) -> Cycle:
    """Positional, with commas or blanks: name, G98, depth[, PECKING, first, next], MMPM, feed, clearance, retract."""
    args: list[float | str] = []
    for token in re.split(r"[,\s]+", statement.text.strip()):
        value = number_of(token)
        args.append(token.upper() if value is None else value)
    numbers: dict[str, list[float]] = {"": []}
    word = ""
    for arg in args:
        if isinstance(arg, str):
            word = arg
            numbers.setdefault(word, [])
        else:
            numbers[word].append(arg)
    name = str(args[0])
    plane = next((numbers[g] for g in ("G98", "G99") if g in numbers), numbers.get(name, []))
    feed = next((word for word in ("MMPM", "IPM", "MMPR", "IPR") if word in numbers), "")
    behind = numbers[feed] if feed else []
    if not plane or len(behind) < 3:
        raise ToolpathError(
            f"cycle {name} lacks its depth, feed, clearance or retract", hint="output it again", line=statement.line
        )
    fields = {feed: behind[0], "CLEAR": behind[1], "RTRCTO": behind[2]}
    pecks = numbers.get("PECKING", [])
    if pecks:
        name = "DEEP" if name == "DRILL" else name
        fields["1STPECK"], fields["SUBPECK"] = pecks[0], pecks[-1]
    if numbers.get("DWELL"):
        fields["DWELL"] = numbers["DWELL"][0]
    return keyed_cycle(name, fields, plane[0], statement.line)


CAMWORKS = Dialect(
    "camworks-apt", _recognise, _cycle, message, csys_sets_axis=True, insert_names_tool=True, must_end=True
)
CAMWORKS_CLT = Dialect(
    "camworks-clt", _recognise_clt, _cycle_clt, message, on="heading", table_radians=True, cutter_is_tool=True
)
