"""Programs for lathes, which look like milling in X and Z: known by their words, and refused by that name."""

from __future__ import annotations

import re
from pathlib import Path

from camrob.errors import ToolpathError

__all__ = ["refuse_turning"]

_Y = re.compile(r"Y[ \t]*[-+=]?[ \t]*[0-9.#\[]")
# surface speed and its bound, roughing and threading cycles, a tool with its offset in one number, lathe increments, LinuxCNC's
# threads and the radius or diameter of G18 that X is there
_MARKS = re.compile(
    r"(?<![A-Z0-9.])(?:G[ \t]*0*96(?![0-9.])|G[ \t]*0*50[ \t]*S|G[ \t]*0*7[0-6][ \t]*[PUXR]|T[ \t]*[0-9]{4}(?![0-9])"
    r"|G[ \t]*0*(?:32|33|92)[ \t]*[XZ][^\n]*F|[UW][ \t]*[-+]?[0-9.]"
    r"|G[ \t]*0*33(?:\.1)?[ \t]*Z[^\n]*K|G[ \t]*18[ \t]*G[ \t]*0*[78](?![0-9.]))"
)


def refuse_turning(bare: str, path: Path) -> None:
    """`bare`: the program, upper case, without comments. Raises ToolpathError with the first line that only a lathe has."""
    mark = _MARKS.search(bare)
    if mark is None or _Y.search(bare) or "X" not in bare or "Z" not in bare:
        return
    raise ToolpathError(
        f"a turning program ({mark[0].strip()}, and no Y in the whole file): no part turns against a tool at rest here",
        hint="give the milling operations a program of their own",
        path=path,
        line=bare.count("\n", 0, mark.start()) + 1,
    )
