"""CAM toolpaths into verified programs for redundant robot machining cells.

The names below are loaded when they are first asked for, so that `import camrob` costs next to nothing.
"""

from __future__ import annotations

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


def __getattr__(name: str) -> object:
    """A public name, from the module that it lives in; the rest of `__all__` is the tree of errors."""
    if name not in __all__:
        raise AttributeError(f"module 'camrob' has no attribute {name!r}")
    value = getattr(import_module(_HOME.get(name, "camrob.errors")), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
