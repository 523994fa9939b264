"""The package's source as syntax trees, for the tests of its structure."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

__all__ = ["ROOT", "Import", "Module", "functions", "imports", "modules", "public_definitions"]


@dataclass(frozen=True)
class Module:
    """One source file: its dotted name, its text and its tree."""

    name: str
    path: Path
    text: str
    tree: ast.Module

    @cached_property
    def nodes(self) -> tuple[ast.AST, ...]:
        """All nodes of the tree: walked once for all tests."""
        return tuple(ast.walk(self.tree))

    @property
    def is_package(self) -> bool:
        return self.path.name == "__init__.py"

    @property
    def file(self) -> str:
        """The path from the project's root."""
        return str(self.path.relative_to(ROOT) if self.path.is_relative_to(ROOT) else self.path)

    def at(self, node: ast.AST) -> str:
        """A place as editors understand it."""
        return f"{self.file}:{getattr(node, 'lineno', 1)}"


@dataclass(frozen=True)
class Import:
    """One imported module; `early` where it happens as soon as the importing module is imported."""

    target: str
    node: ast.stmt
    early: bool


def parse(name: str, text: str, path: Path | None = None) -> Module:
    """A module of a text, for tests that plant mistakes."""
    return Module(name, path or Path(name.replace(".", "/") + ".py"), text, ast.parse(text))


@cache
def modules(package: str = "camrob") -> tuple[Module, ...]:
    """Every module of the package."""
    found = []
    for path in sorted((ROOT / package).rglob("*.py")):
        parts = path.relative_to(ROOT).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        found.append(parse(name, path.read_text(encoding="utf-8"), path))
    return tuple(found)


def imports(module: Module, known: frozenset[str] | set[str] = frozenset()) -> tuple[Import, ...]:
    """All imports of a module as dotted names; `from a import b` gives a.b where that is a module among `known`."""
    return _imports(module, frozenset(known))


@cache
def _imports(module: Module, known: frozenset[str]) -> tuple[Import, ...]:
    found: list[Import] = []

    def walk(node: ast.AST, early: bool) -> None:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.Import):
                found.extend(Import(alias.name, child, early) for alias in child.names)
            elif isinstance(child, ast.ImportFrom):
                base = child.module or ""
                if child.level:
                    anchor = module.name.split(".")
                    anchor = anchor[: len(anchor) - child.level + (1 if module.is_package else 0)]
                    base = ".".join([*anchor, base]) if base else ".".join(anchor)
                for alias in child.names:
                    deeper = f"{base}.{alias.name}"
                    found.append(Import(deeper if deeper in known else base, child, early))
            elif isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
                walk(child, False)
            elif isinstance(child, ast.If) and "TYPE_CHECKING" in ast.dump(child.test):
                for statement in child.body:
                    walk(ast.Module([statement], []), False)
                for statement in child.orelse:
                    walk(ast.Module([statement], []), early)
            else:
                walk(child, early)

    walk(module.tree, True)
    return tuple(found)


def functions(module: Module) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    """Every function and method, nested ones too."""
    for node in module.nodes:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node


def public_definitions(module: Module) -> list[ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef]:
    """Functions and classes at the module's top that bear no leading underscore."""
    return [
        node
        for node in module.tree.body
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef) and not node.name.startswith("_")
    ]
