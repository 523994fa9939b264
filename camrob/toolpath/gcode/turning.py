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
# Siemens' X by diameters, bound of a surface speed, cycles that turn and cut threads; Heidenhain's turning mode
_MARKS_OF_OTHERS = re.compile(
    r"(?<![A-Z0-9_])(?:FUNCTION MODE TURN|DIAM(?:ON|90)|LIMS[ \t]*=|CYCLE(?:9[3-9]|93[01]|940|95[0-2])(?![0-9]))"
)
_SURFACE_SPEED = re.compile(r"(?<![A-Z0-9.])G[ \t]*0*9(?:6|61|62)(?![0-9.])")


def refuse_turning(bare: str, path: Path, *, plain: bool) -> None:
    """`bare`: the program, upper case, without comments; `plain`: in ISO's words, not in Siemens' or Heidenhain's.

    Raises ToolpathError with the first line that only a lathe has.
    """
    if plain:
        mark = None if _Y.search(bare) or "X" not in bare or "Z" not in bare else _MARKS.search(bare)
        beside = ", and no Y in the whole file"
    else:
        mark = _MARKS_OF_OTHERS.search(bare) or (None if _Y.search(bare) else _SURFACE_SPEED.search(bare))
        beside = ""
    if mark is None:
        return
    raise ToolpathError(
        f"a turning program ({mark[0].strip(' (')}{beside}): no part turns against a tool at rest here",
        hint="give the milling operations a program of their own",
        path=path,
        line=bare.count("\n", 0, mark.start()) + 1,
    )
