"""CAM toolpaths into verified programs for redundant robot machining cells.

The names below are loaded when they are first asked for, so that `import camrob` costs next to nothing.
"""

from __future__ import annotations

import os
import sys
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from camrob.cell.cell import Cell
    from camrob.cell.read_cell import read_cell
    from camrob.errors import (
        CamrobError,
        CellError,
        CollisionError,
        InputError,
        JobError,
        KrlError,
        LimitError,
        LogError,
        SetupError,
        SingularError,
        StaleInputError,
        ToolpathError,
        UnreachableError,
        VerificationError,
    )
    from camrob.issues import Finding, Severity
    from camrob.post.program import Program
    from camrob.toolpath.region import Region
    from camrob.toolpath.toolpath import Toolpath

__all__ = [
    "CamrobError",
    "Cell",
    "CellError",
    "CollisionError",
    "Finding",
    "InputError",
    "JobError",
    "KrlError",
    "LimitError",
    "LogError",
    "Program",
    "Region",
    "SetupError",
    "Severity",
    "SingularError",
    "StaleInputError",
    "Toolpath",
    "ToolpathError",
    "UnreachableError",
    "VerificationError",
    "read_cell",
]

_HOME = {
    "Cell": "camrob.cell.cell",
    "Finding": "camrob.issues",
    "Program": "camrob.post.program",
    "Region": "camrob.toolpath.region",
    "Severity": "camrob.issues",
    "Toolpath": "camrob.toolpath.toolpath",
    "read_cell": "camrob.cell.read_cell",
}


def _keep_kernels_fresh() -> None:
    """Give the compiled kernels a cache folder of their own for every state of the sources.

    Numba recompiles a function when its own file changes, not when one that it calls lies in another file and changes.
    Stale kernels would drive a robot, so the folder is named after the contents of all files that hold kernels. A folder that
    the user set (NUMBA_CACHE_DIR) is left alone, and so is a process that has loaded Numba already.
    """
    if "numba" in sys.modules or "NUMBA_CACHE_DIR" in os.environ:
        return
    import hashlib

    sources = hashlib.sha256()
    for folder, below, files in os.walk(os.path.dirname(__file__)):
        below.sort()
        for file in sorted(files):
            if file.endswith(".py"):
                with open(os.path.join(folder, file), "rb") as source:
                    text = source.read()
                if b"numba" in text:
                    sources.update(file.encode() + b"\0" + text)
    root = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    place = os.path.join(root, "camrob", "kernels-" + sources.hexdigest()[:16])
    try:
        os.makedirs(place, exist_ok=True)
    except OSError:
        return  # nowhere to write: Numba's own places serve
    if os.access(place, os.W_OK):
        os.environ["NUMBA_CACHE_DIR"] = place


_keep_kernels_fresh()


def __getattr__(name: str) -> object:
    """A public name, from the module that it lives in; the rest of `__all__` is the tree of errors."""
    if name not in __all__:
        raise AttributeError(f"module 'camrob' has no attribute {name!r}")
    value = getattr(import_module(_HOME.get(name, "camrob.errors")), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
