"""Where RAPID's branches and loops end, and the parts that they fall into."""

from __future__ import annotations

import re
from collections.abc import Sequence

from camrob.witness.krl.text import Line
from camrob.witness.rapid.module_text import MoveRow

__all__ = ["parts_of"]

_Nodes = Sequence[Line | MoveRow]
_OPENS = re.compile(r"(?:IF\b.*\bTHEN|FOR\b.*\bDO|WHILE\b.*\bDO|TEST\b.*)")
_ENDS = ("ENDIF", "ENDFOR", "ENDWHILE", "ENDTEST")
_PARTS = re.compile(r"ELSEIF\b.*\bTHEN|ELSE|CASE\b.*:|DEFAULT:")


def parts_of(nodes: _Nodes, at: int) -> tuple[list[tuple[str, _Nodes]], int]:
    """The parts of the block that begins at `at`, each with its head, and where it ends; none where it ends as another one."""
    parts: list[tuple[str, _Nodes]] = []
    depth, begun = 0, at
    for k in range(at, len(nodes)):
        node = nodes[k]
        code = node.code if isinstance(node, Line) else ""
        depth += (_OPENS.fullmatch(code) is not None) - (code in _ENDS)
        if (depth == 1 and k > at and _PARTS.fullmatch(code)) or depth == 0:
            head = nodes[begun]
            parts.append((head.code if isinstance(head, Line) else "", nodes[begun + 1 : k]))
            begun = k
        if depth == 0:
            first = nodes[at]
            word = first.code.split(" ")[0].split("(")[0] if isinstance(first, Line) else ""
            return (parts if code == f"END{word}" else []), k
    return [], len(nodes)
