"""Names and numbers: what a plug-in is called is said at its home alone, and a number in the code has a reason beside it."""

from __future__ import annotations

import ast
import io
import tokenize
from collections.abc import Iterable, Iterator

from structure_tree import Module

__all__ = ["number_faults", "registered_faults"]

# what registers plug-ins: the folder of their files, the call that makes one, and the rooms that may know their names. The
# witness is a house of its own: it has its own lists of dialects and controls.
_HOMES = {
    "camrob.gap.effects": ("Effect", ("camrob.gap.effects",)),
    "camrob.toolpath.apt.dialects": ("Dialect", ("camrob.toolpath.apt.dialects", "camrob.witness")),
    "camrob.toolpath.gcode.controls": ("Control", ("camrob.toolpath.gcode.controls", "camrob.witness")),
}
PLAIN = {-1, 0, 1, 2, 0.5}  # numbers that need no reason


def registered_faults(tree: Iterable[Module]) -> list[str]:
    """Comparisons and look-ups with the name of a registered effect, dialect or control outside its home."""
    tree = tuple(tree)
    faults = []
    for folder, (maker, homes) in _HOMES.items():
        names = {name for m in tree if m.name.startswith(f"{folder}.") for name in _registered(m, maker)}
        for module in tree:
            if not module.name.startswith(homes):
                faults += [f"{module.at(node)}: {node.value!r} is known by name" for node in _asked(module, names)]
    return faults


def _registered(module: Module, maker: str) -> Iterator[str]:
    """The names under which a module of a registry registers itself: the first argument of the call, or `name=`."""
    for node in module.tree.body:
        call = node.value if isinstance(node, ast.Assign | ast.AnnAssign) else None
        if isinstance(call, ast.Call) and ast.unparse(call.func).rpartition(".")[2] == maker:
            said = [*call.args[:1], *(k.value for k in call.keywords if k.arg == "name")]
            yield from (s.value for s in said if isinstance(s, ast.Constant) and isinstance(s.value, str))


def _asked(module: Module, names: set[str]) -> Iterator[ast.Constant]:
    """Constants that are compared with, looked up, or listed to be compared with or looked up."""
    for node in module.nodes:
        asked: list[ast.AST] = []
        if isinstance(node, ast.Compare):
            asked = [node.left, *node.comparators]
        elif isinstance(node, ast.Subscript):
            asked = [node.slice]
        elif isinstance(node, ast.MatchValue):
            asked = [node.value]
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in ("get", "index"):
            asked = list(node.args[:1])
        elif (
            isinstance(node, ast.Assign) and module.tree.body.count(node) and isinstance(node.value, ast.Dict | ast.Set)
        ):
            asked = list(node.value.keys) if isinstance(node.value, ast.Dict) else list(node.value.elts)
        for part in asked:
            inner = part.elts if isinstance(part, ast.Tuple | ast.List | ast.Set) else [part]
            yield from (
                c for c in inner if isinstance(c, ast.Constant) and isinstance(c.value, str) and c.value in names
            )


def number_faults(tree: Iterable[Module]) -> list[str]:
    """Module-level numbers without a reason or a source: a comment on the line or above it, or a docstring below."""
    return [fault for module in tree for fault in _unexplained(module)]


def _unexplained(module: Module) -> Iterator[str]:
    comments = {
        token.start[0]
        for token in tokenize.generate_tokens(io.StringIO(module.text).readline)
        if token.type == tokenize.COMMENT
    }
    body, explained, counted = module.tree.body, False, False
    for before, node, following in zip([None, *body[:-1]], body, [*body[1:], None], strict=True):
        if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None or not _numbers(node.value):
            explained = counted = False
            continue
        counted = _counts_on(before, node)
        if counted:
            continue
        documented = isinstance(following, ast.Expr) and isinstance(following.value, ast.Constant)
        last = node.end_lineno or node.lineno
        # one reason holds for a group of constants that stand together
        above = node.lineno - 1 in comments
        explained = documented or above or any(k in comments for k in range(node.lineno, last + 1)) or explained
        if not explained:
            yield f"{module.file}:{node.lineno}: {ast.unparse(node)[:80]}: no reason stands beside it"
        explained = explained and _adjacent(node, following)


def _numbers(value: ast.expr) -> bool:
    """Whether an expression holds a number that needs a reason: one of its own, in a call, an array or a table.

    Needs none: what a range counts, the number of a case in a table's key, a field that a record's constructor is given by name
    (the record says what it is), and what stands in another function (a lambda).
    """
    if isinstance(value, ast.Constant):
        number = isinstance(value.value, int | float) and not isinstance(value.value, bool)
        return number and value.value not in PLAIN
    if isinstance(value, ast.Call):
        name = value.func.id if isinstance(value.func, ast.Name) else ""
        return name != "range" and any(_numbers(part) for part in [value.func, *value.args])
    if isinstance(value, ast.Dict):
        return any(_numbers(v) for v in value.values)
    if isinstance(value, ast.Lambda | ast.Subscript):
        return False
    return any(_numbers(part) for part in ast.iter_child_nodes(value) if isinstance(part, ast.expr))


def _counts_on(before: ast.stmt | None, node: ast.Assign | ast.AnnAssign) -> bool:
    """Whether numbers only tell cases apart: (0, 1, 2, ...), or one more than the line before has."""
    values = [n.value for n in ast.walk(node) if isinstance(n, ast.Constant)]
    if isinstance(node.value, ast.Tuple):
        return values == list(range(len(values)))
    last = [n.value for n in ast.walk(before) if isinstance(n, ast.Constant)] if isinstance(before, ast.Assign) else []
    return isinstance(node.value, ast.Constant) and last == [values[0] - 1] and isinstance(values[0], int)


def _adjacent(node: ast.stmt, following: ast.stmt | None) -> bool:
    return following is not None and following.lineno == (node.end_lineno or node.lineno) + 1
