"""What may be done to a node of a syntax tree: each operator changes the tree in place and says what it did."""

from __future__ import annotations

import ast
import copy
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any

Change = Callable[[], None]
Found = tuple[str, ast.AST, Change]

_ARITHMETIC: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.FloorDiv: ast.Div, ast.Mod: ast.Mult,
    ast.Pow: ast.Mult, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd, ast.LShift: ast.RShift, ast.RShift: ast.LShift,
    ast.BitXor: ast.BitOr,
}  # fmt: skip
_EDGE: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
_OTHER_SIDE: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.Gt,
    ast.LtE: ast.GtE,
    ast.Gt: ast.Lt,
    ast.GtE: ast.LtE,
}
_PAIRS = (
    "sin cos", "min max", "minimum maximum", "argmin argmax", "any all", "floor ceil", "lower upper", "first last",
    "start end", "start stop", "before after", "left right", "append insert", "mm_to_m m_to_mm", "deg_to_rad rad_to_deg",
    "position axis", "position_axis position", "q_lower q_upper", "zeros ones", "cumsum cumprod", "leave come", "lines codes",
    "CUT RAPID", "RAPID LINK", "LIN PTP_AXES", "CIRC_VIA CIRC_END", "PTP_AXES PTP_POSE", "SPINDLE_ON SPINDLE_OFF",
    "COOLANT_ON COOLANT_OFF", "DWELL STOP", "pose axes", "status turn", "ERROR WARNING", "INFO ERROR", "flatnonzero nonzero",
    "arcsin arccos", "cos tan", "round trunc", "argsort sort", "tip axis", "feed speed", "line point", "prepend append",
)  # fmt: skip
_NAMES: dict[str, str] = {}
for _pair in _PAIRS:
    _one, _two = _pair.split()
    _NAMES.setdefault(_one, _two)
    _NAMES.setdefault(_two, _one)


def mutations(node: ast.AST, parent: ast.AST, bound: set[str]) -> Iterator[Found]:
    """All that can be done to a node; `bound`: names that have a value before it. The parent is where it hangs."""
    if isinstance(node, ast.BinOp):
        yield from _binary(node, parent)
    elif isinstance(node, ast.UnaryOp):
        yield from _unary(node, parent)
    elif isinstance(node, ast.Compare):
        yield from _compare(node)
    elif isinstance(node, ast.BoolOp):
        yield from _logic(node, parent)
    elif isinstance(node, ast.Constant):
        yield from _constant(node)
    elif isinstance(node, ast.Call):
        yield from _call(node)
    elif isinstance(node, ast.Subscript):
        yield from _subscript(node)
    elif isinstance(node, ast.IfExp):
        yield "arms", node, _swap(node, "body", "orelse")
    elif isinstance(node, ast.AugAssign):
        yield from _augmented(node, parent)
    elif isinstance(node, (ast.Attribute, ast.Name)):
        yield from _name(node)
    elif isinstance(node, (ast.Tuple, ast.List)) and isinstance(getattr(node, "ctx", None), ast.Load):
        yield from _sequence(node)
    if isinstance(node, (ast.If, ast.IfExp, ast.comprehension, ast.While)):
        yield from _condition(node)
    if isinstance(node, ast.stmt):
        yield from _statement(node, parent, bound)


def _set(node: ast.AST, field: str, value: object) -> Change:
    return lambda: setattr(node, field, value)


def _item(items: list[Any], k: int, value: Any) -> Change:
    return lambda: items.__setitem__(k, value)


def _without(items: list[Any], item: Any) -> Change:
    return lambda: items.remove(item)


def _swap(node: ast.AST, one: str, two: str) -> Change:
    def change() -> None:
        a, b = getattr(node, one), getattr(node, two)
        setattr(node, one, b)
        setattr(node, two, a)

    return change


def _put(parent: ast.AST, old: ast.AST, new: ast.AST) -> Change:
    """Another node in the place of one."""

    def change() -> None:
        for field, value in ast.iter_fields(parent):
            if value is old:
                setattr(parent, field, new)
            elif isinstance(value, list):
                for k, item in enumerate(value):
                    if item is old:
                        value[k] = new

    ast.copy_location(new, old)
    return change


def _binary(node: ast.BinOp, parent: ast.AST) -> Iterator[Found]:
    if isinstance(node.op, ast.Mod) and isinstance(node.left, ast.Constant) and isinstance(node.left.value, str):
        return
    other = _ARITHMETIC.get(type(node.op))
    if other is not None:
        yield "arithmetic", node, _set(node, "op", other())
    if isinstance(node.op, (ast.Sub, ast.Div, ast.MatMult, ast.Mod, ast.FloorDiv, ast.Pow)):
        yield "operands", node, _swap(node, "left", "right")
    yield "drop-right", node, _put(parent, node, node.left)
    yield "drop-left", node, _put(parent, node, node.right)


def _unary(node: ast.UnaryOp, parent: ast.AST) -> Iterator[Found]:
    kind = {ast.USub: "sign", ast.Not: "not", ast.Invert: "not"}.get(type(node.op))
    if kind is not None:
        yield kind, node, _put(parent, node, node.operand)


def _compare(node: ast.Compare) -> Iterator[Found]:
    for k, op in enumerate(node.ops):
        for name, table in (("edge", _EDGE), ("side", _OTHER_SIDE)):
            if type(op) in table:
                yield f"compare-{name}", node, _item(node.ops, k, table[type(op)]())


def _logic(node: ast.BoolOp, parent: ast.AST) -> Iterator[Found]:
    yield "and-or", node, _set(node, "op", ast.Or() if isinstance(node.op, ast.And) else ast.And())
    for k in range(len(node.values)):
        rest = [v for i, v in enumerate(node.values) if i != k]
        new = rest[0] if len(rest) == 1 else ast.BoolOp(node.op, rest)
        yield "drop-term", node, _put(parent, node, new)


def _constant(node: ast.Constant) -> Iterator[Found]:
    v = node.value
    if isinstance(v, bool):
        yield "constant-flip", node, _set(node, "value", not v)
    elif isinstance(v, int):
        yield "constant-plus", node, _set(node, "value", v + 1)
        yield "constant-minus", node, _set(node, "value", v - 1)
    elif isinstance(v, float):
        for name, new in (
            ("zero", 0.0),
            ("double", v * 2.0),
            ("little", v * 1.001 + (1e-3 if v == 0.0 else 0.0)),
            ("sign", -v),
        ):
            if new != v:
                yield f"constant-{name}", node, _set(node, "value", new)
    elif isinstance(v, str) and 0 < len(v) <= 12:
        yield "constant-text", node, _set(node, "value", v[::-1] if v[::-1] != v else v + v)


def _call(node: ast.Call) -> Iterator[Found]:
    for k in range(len(node.args) - 1):
        if not any(isinstance(a, ast.Starred) for a in node.args[k : k + 2]):

            def change(k: int = k) -> None:
                node.args[k], node.args[k + 1] = node.args[k + 1], node.args[k]

            yield "arguments", node, change
    named = [k for k in node.keywords if k.arg is not None]
    for one, two in pairwise(named):
        yield "keywords", node, _exchange(one, two)
    for key in named:
        yield "drop-keyword", node, _without(node.keywords, key)
    if isinstance(node.func, ast.Name) and node.func.id == "range":
        last = node.args[min(1, len(node.args) - 1)]
        for name, op in (("short", ast.Sub()), ("long", ast.Add())):
            new = ast.copy_location(ast.BinOp(last, op, ast.Constant(1)), last)
            yield f"range-{name}", node, _put(node, last, new)


def _exchange(one: ast.keyword, two: ast.keyword) -> Change:
    def change() -> None:
        one.value, two.value = two.value, one.value

    return change


def _subscript(node: ast.Subscript) -> Iterator[Found]:
    if not isinstance(node.slice, ast.Slice):
        if isinstance(node.slice, (ast.Name, ast.BinOp)):
            for name, op in (("plus", ast.Add()), ("minus", ast.Sub())):
                new = ast.BinOp(node.slice, op, ast.Constant(1))
                yield f"index-{name}", node, _put(node, node.slice, new)
        return
    for field in ("lower", "upper"):
        bound = getattr(node.slice, field)
        if bound is None:
            value: ast.expr = ast.Constant(1) if field == "lower" else ast.UnaryOp(ast.USub(), ast.Constant(1))
            yield f"slice-{field}", node, _set(node.slice, field, ast.copy_location(value, node))
        else:
            yield f"slice-{field}", node, _put(node.slice, bound, ast.BinOp(bound, ast.Add(), ast.Constant(1)))
            yield f"slice-{field}-open", node, _set(node.slice, field, None)


def _augmented(node: ast.AugAssign, parent: ast.AST) -> Iterator[Found]:
    other = _ARITHMETIC.get(type(node.op))
    if other is not None:
        yield "arithmetic", node, _set(node, "op", other())
    target = copy.deepcopy(node.target)
    yield "assign", node, _put(parent, node, ast.Assign([target], node.value, lineno=node.lineno))


def _name(node: ast.Attribute | ast.Name) -> Iterator[Found]:
    field = "attr" if isinstance(node, ast.Attribute) else "id"
    other = _NAMES.get(getattr(node, field))
    if other is not None and isinstance(node.ctx, ast.Load):
        yield "name", node, _set(node, field, other)


def _sequence(node: ast.Tuple | ast.List) -> Iterator[Found]:
    for k in range(len(node.elts) - 1):

        def change(k: int = k) -> None:
            node.elts[k], node.elts[k + 1] = node.elts[k + 1], node.elts[k]

        yield "elements", node, change


def _condition(node: ast.If | ast.IfExp | ast.comprehension | ast.While) -> Iterator[Found]:
    if isinstance(node, ast.comprehension):
        for k in range(len(node.ifs)):
            yield "condition-dropped", node.ifs[k], _without(node.ifs, node.ifs[k])
        return
    test = node.test
    if not isinstance(test, (ast.Compare, ast.UnaryOp)):
        yield "condition-not", test, _set(node, "test", ast.copy_location(ast.UnaryOp(ast.Not(), test), test))
    if not isinstance(node, ast.While):
        yield "condition-true", test, _set(node, "test", ast.copy_location(ast.Constant(True), test))
    yield "condition-false", test, _set(node, "test", ast.copy_location(ast.Constant(False), test))


def _statement(node: ast.stmt, parent: ast.AST, bound: set[str]) -> Iterator[Found]:
    nothing = ast.Pass()
    if isinstance(node, (ast.AugAssign, ast.Raise, ast.Continue, ast.Break)):
        yield "drop", node, _put(parent, node, nothing)
    elif isinstance(node, ast.Expr) and not isinstance(node.value, ast.Constant):
        yield "drop", node, _put(parent, node, nothing)
    elif isinstance(node, ast.Assign):
        named = {
            n.id
            for t in node.targets
            if not isinstance(t, (ast.Attribute, ast.Subscript))
            for n in ast.walk(t)
            if isinstance(n, ast.Name)
        }
        if named <= bound:
            yield "drop", node, _put(parent, node, nothing)
    elif isinstance(node, ast.Return) and node.value is not None:
        yield from _returned(node)
    if isinstance(node, (ast.AugAssign,)) or (isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)):
        yield "double", node, _put(parent, node, ast.If(ast.Constant(True), [node, copy.deepcopy(node)], []))


def _returned(node: ast.Return) -> Iterator[Found]:
    if isinstance(node.value, (ast.BinOp, ast.Name, ast.Call)):
        yield "return-sign", node, _set(node, "value", ast.copy_location(ast.UnaryOp(ast.USub(), node.value), node))
