"""What a source file imports, for tests that hold makers apart from what is judged by their cases."""

from __future__ import annotations

import ast
from pathlib import Path

__all__ = ["imported_names", "taken_names"]


def _imports(path: Path) -> list[ast.Import | ast.ImportFrom]:
    nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    return [node for node in nodes if isinstance(node, ast.Import | ast.ImportFrom)]


def taken_names(path: Path) -> set[str]:
    """By their dotted names, modules that are imported as such, and what is taken out of others."""
    return {
        alias.name if isinstance(node, ast.Import) else f"{node.module}.{alias.name}"
        for node in _imports(path)
        for alias in node.names
    }


def imported_names(path: Path) -> set[str]:
    """`taken_names`, and the modules that something is taken out of."""
    return taken_names(path) | {str(node.module) for node in _imports(path) if isinstance(node, ast.ImportFrom)}
