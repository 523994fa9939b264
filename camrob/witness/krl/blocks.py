"""What stands in a block of KRL, as far as its meaning hangs on that."""

from __future__ import annotations

import re

from camrob.witness.krl.program import Block, Module, Node, Rows
from camrob.witness.krl.statements import statement, variable
from camrob.witness.krl.text import HOW, Line

__all__ = ["begins", "curved", "idle", "in_spline", "leaves"]

_OF_SPLINE = re.compile(r"(?:SLIN|SCIRC|SPL)\b(?:(?! C_).)+|TRIGGER\b.+")
_INITIAL = re.compile(
    r"BAS ?\( ?#INITMOV ?, ?0 ?\)|GLOBAL INTERRUPT DECL 3 WHEN \$STOPMESS ?== ?TRUE DO IR_STOPM ?\( ?\)|INTERRUPT ON 3"
)
_NO_MOTION = re.compile(r"S?(?:PTP|LIN) ?\$(?:POS_ACT|AXIS_ACT|AXIS_ACT_MEAS)(?: C_\w+)*")


def leaves(nodes: list[Node]) -> bool:
    """Whether a loop's body holds an EXIT or a RETURN at all."""
    for node in nodes:
        if isinstance(node, Block):
            if any(leaves(part) for _, part in node.parts):
                return True
        elif isinstance(node, Line) and node.code.partition(" ")[0] in ("EXIT", "RETURN", "GOTO"):
            return True
    return False


def in_spline(node: Node, module: Module | None) -> bool:
    """Whether a controller takes a node within SPLINE."""
    if isinstance(node, Rows):
        if module is None:
            return False
        source = module.source
        here = source.rounded[(source.row_line >= node.first) & (source.row_line <= node.last)]
        speeds = (source.speed_line >= node.first) & (source.speed_line <= node.last)
        return not speeds.any() and all(HOW[k] == ("S", "") for k in here)
    return isinstance(node, Line) and _OF_SPLINE.fullmatch(node.code) is not None


def begins(block: Block) -> bool:
    """Whether a block is the shop's initialisation, passed over on the path: IF NOT $ON_PATH round BAS(#INITMOV,0) and the
    template's interrupt, and nothing else.
    """
    inside = block.parts[0][1]
    usual = block.head.code == "IF NOT $ON_PATH THEN" and len(block.parts) == 1
    return usual and all(isinstance(node, Line) and _INITIAL.fullmatch(node.code) is not None for node in inside)


def curved(node: Node) -> bool:
    """Whether a spline's motion bends what comes before or after it: lines and circles keep to themselves."""
    return not isinstance(node, Line) or re.match(r"SPL\b", node.code) is not None


def idle(nodes: list[Node]) -> bool:
    """Whether nodes change nothing that is judged."""
    for node in nodes:
        if isinstance(node, Rows):
            return False
        if isinstance(node, Block):
            if not all(idle(part) for _, part in node.parts):
                return False
        elif not _idle(node.code):
            return False
    return True


def _idle(code: str) -> bool:
    """Whether a statement changes nothing that is judged, wherever it stands."""
    found = statement(code)
    if found is None:
        return False
    row, match = found
    if row.act == "assign":
        set_to = variable(match["name"].replace(" ", ""))
        return set_to is not None and set_to[0].act == "nothing"
    return row.act in ("nothing", "declare", "wait_for") or bool(_NO_MOTION.fullmatch(code))
