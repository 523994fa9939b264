"""Frame names that a machine can check: in `a_T_b @ b_T_c` the inner names cancel.

`a_T_b` is the pose of b in a, `a_R_b` its rotation, `a_p_b` its position, `a_J_b` the Jacobian of b in a. Followed are
products, assignments, keyword and positional arguments, returned values, inverses, transposes, blocks and calls of
functions that bear such a name. What has no such name is not judged.

Frames of a walk along a chain (`link_T_next`, `parent_T_joint`) stand for any frame. Where code knows that two frames
are one, it says so on the line: `# frames: foot is first`.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable
from typing import NamedTuple

from structure_tree import Module, functions

__all__ = ["frame_faults"]

_NAME = re.compile(r"_*([a-z][a-z0-9]*(?:_[a-z0-9]+)*)_([TRpJ])_([a-z][a-z0-9]*(?:_[a-z0-9]+)*?)(?:_\d+|_many|_all)?_?")
_ANY = {"link", "next", "parent", "child", "joint", "joint_frames", "frame", "shape", "body", "a", "b"}
_SAID = re.compile(r"# frames: (\w+) is (\w+)")
_INVERSE = {"inverse", "inv", "inverse_pose", "inverse_many"}
_SAME = {"asarray", "array", "ascontiguousarray", "locked", "copy", "astype", "broadcast_to", "atleast_3d", "float64"}


class Frames(NamedTuple):
    """What a name or an expression says it is."""

    kind: str
    a: str
    b: str

    def __str__(self) -> str:
        return f"{self.a}_{self.kind}_{self.b}"


def parse_name(name: str) -> Frames | None:
    """The frames in a name, None where it holds none."""
    found = _NAME.fullmatch(name)
    return Frames(found[2], found[1], found[3]) if found else None


def _called(call: ast.Call) -> str:
    """The last part of a called function's name."""
    return call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")


def _ends(index: ast.expr) -> tuple[str, ...]:
    """The last two entries of an index as text."""
    entries = index.elts if isinstance(index, ast.Tuple) else [index]
    return tuple(ast.unparse(e) for e in entries[-2:])


class _Checker:
    """One module's faults."""

    def __init__(self, module: Module, parameters: dict[str, list[str]]) -> None:
        self.module, self.parameters, self.faults = module, parameters, list[str]()
        said = [(number, _SAID.search(line)) for number, line in enumerate(module.text.splitlines(), start=1)]
        self.said = {number: {found[1], found[2]} for number, found in said if found}

    def fault(self, node: ast.AST, text: str) -> None:
        self.faults.append(f"{self.module.at(node)}: {text}")

    def one(self, node: ast.AST, a: str, b: str) -> bool:
        """Whether two names are of one frame."""
        lines = range(getattr(node, "lineno", 0), (getattr(node, "end_lineno", 0) or 0) + 1)
        return a == b or a in _ANY or b in _ANY or any({a, b} == self.said.get(line) for line in lines)

    def frames(self, node: ast.expr) -> Frames | None:
        """What an expression is by the names in it."""
        if isinstance(node, ast.Name):
            return parse_name(node.id)
        if isinstance(node, ast.Attribute):
            if node.attr in ("T", "mT"):
                inner = self.frames(node.value)
                return Frames("R", inner.b, inner.a) if inner and inner.kind == "R" else None
            return parse_name(node.attr)
        if isinstance(node, ast.Subscript):
            return self._block(node)
        if isinstance(node, ast.Call):
            return self._call(node)
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
            return self._product(node)
        return None

    def _block(self, node: ast.Subscript) -> Frames | None:
        """A rotation or position out of a pose, or one of many."""
        inner, ends = self.frames(node.value), _ends(node.slice)
        if inner is None:
            return None
        if inner.kind == "T" and ends == (":3", ":3"):
            return inner._replace(kind="R")
        if inner.kind == "T" and ends in ((":3", "3"), (":3", "3:")):
            return inner._replace(kind="p")
        batch = ("...", ":3") if inner.kind == "p" else ()
        plain = len(ends) == 1 and not isinstance(node.slice, ast.Constant | ast.UnaryOp)
        if inner.kind in "TR" and (plain or ends[-1] == "None" or ends == ("...",)):
            return inner
        return inner if ends == batch else None

    def _call(self, node: ast.Call) -> Frames | None:
        """Inverses, copies and functions that bear the frames of what they return."""
        name = _called(node)
        first = self.frames(node.args[0]) if node.args else None
        if name in _INVERSE and first and first.kind in "TR":
            return Frames(first.kind, first.b, first.a)
        if name == "swapaxes" and first and first.kind == "R":
            return Frames("R", first.b, first.a)
        if name == "matmul" and len(node.args) == 2:
            return self._multiplied(node, *node.args)
        if name in _SAME:
            return first if first else self.frames(node.func.value) if isinstance(node.func, ast.Attribute) else None
        return parse_name(name)

    def _product(self, node: ast.BinOp) -> Frames | None:
        return self._multiplied(node, node.left, node.right)

    def _multiplied(self, node: ast.AST, left_node: ast.expr, right_node: ast.expr) -> Frames | None:
        left, right = self.frames(left_node), self.frames(right_node)
        if left is None or right is None or left.kind not in "TR":
            return None
        if not self.one(node, left.b, right.a):
            return None  # reported where the product itself is visited
        return Frames(left.kind, left.a, right.b) if left.kind == right.kind else None

    def check_product(self, node: ast.AST, left_node: ast.expr, right_node: ast.expr) -> None:
        """The inner names of a product are one."""
        left, right = self.frames(left_node), self.frames(right_node)
        if left and right and left.kind in "TR" and not self.one(node, left.b, right.a):
            self.fault(node, f"{left} @ {right}: {left.b} meets {right.a}")

    def check_same(self, node: ast.AST, wanted: Frames | None, value: ast.expr, what: str) -> None:
        """A value is what the name that it gets says."""
        got = self.frames(value)
        if not wanted or not got:
            return
        if wanted.kind != got.kind or not (self.one(node, wanted.a, got.a) and self.one(node, wanted.b, got.b)):
            self.fault(node, f"{what} {wanted} gets {got}")

    def check_assignment(self, node: ast.AST, target: ast.expr, value: ast.expr) -> None:
        """Targets against values, one by one where there are several."""
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple) and len(target.elts) == len(value.elts):
            for one, its in zip(target.elts, value.elts, strict=True):
                self.check_assignment(node, one, its)
        elif isinstance(target, ast.Name | ast.Attribute | ast.Subscript):
            self.check_same(node, self.frames(target), value, "name")

    def check_arguments(self, node: ast.Call) -> None:
        """Keyword arguments by their names, positional ones by the parameters of the one function of that name."""
        for keyword in node.keywords:
            if keyword.arg:
                self.check_same(node, parse_name(keyword.arg), keyword.value, "argument")
        for parameter, value in zip(self.parameters.get(_called(node), []), node.args, strict=False):
            if isinstance(value, ast.Starred):
                break
            self.check_same(node, parse_name(parameter), value, "argument")

    def check_returns(self, function: ast.FunctionDef | ast.AsyncFunctionDef) -> None:
        """A function that bears frames returns them."""
        wanted = parse_name(function.name)
        if wanted is None:
            return
        for node in _own_statements(function):
            if isinstance(node, ast.Return) and node.value is not None:
                self.check_same(node, wanted, node.value, "function")

    def run(self) -> list[str]:
        for node in self.module.nodes:
            if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
                self.check_product(node, node.left, node.right)
            elif isinstance(node, ast.Call):
                if _called(node) == "matmul" and len(node.args) == 2:
                    self.check_product(node, *node.args)
                self.check_arguments(node)
            elif isinstance(node, ast.Assign):
                for target in node.targets:
                    self.check_assignment(node, target, node.value)
            elif isinstance(node, ast.AnnAssign) and node.value is not None:
                self.check_assignment(node, node.target, node.value)
        for function in functions(self.module):
            self.check_returns(function)
        return self.faults


def _own_statements(function: ast.AST) -> list[ast.AST]:
    """All nodes of a function but those of functions within it."""
    found: list[ast.AST] = []
    for child in ast.iter_child_nodes(function):
        if not isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            found += [child, *_own_statements(child)]
    return found


def _parameters(tree: Iterable[Module]) -> dict[str, list[str]]:
    """Positional parameters of every function or method whose name occurs once, `self` left out."""
    found: dict[str, list[list[str]]] = {}
    for module in tree:
        for function in functions(module):
            names = [a.arg for a in (*function.args.posonlyargs, *function.args.args)]
            found.setdefault(function.name, []).append(names[1:] if names[:1] in (["self"], ["cls"]) else names)
    return {name: lists[0] for name, lists in found.items() if len(lists) == 1}


def frame_faults(tree: Iterable[Module]) -> list[str]:
    """Every place where the names of frames contradict each other."""
    tree = tuple(tree)
    parameters = _parameters(tree)
    return [fault for module in tree for fault in _Checker(module, parameters).run()]
