"""Machine code is that of today's sources only if whatever stands in it belongs to what its state is reckoned from."""

from __future__ import annotations

import ast

from structure_tree import Module, modules, parse

from camrob.machine_code import FURTHER

MARKS = ("kernel", "part", "inlined", "bare")


def _names_in_kernels(module: Module) -> set[str]:
    """What the bodies of a module's kernels and parts name."""
    found = set()
    for function in module.nodes:
        if isinstance(function, ast.FunctionDef):
            marks = {ast.unparse(mark).partition("(")[0] for mark in function.decorator_list}
            if marks & set(MARKS):
                names = {n.id for s in function.body for n in ast.walk(s) if isinstance(n, ast.Name)}
                found |= names - {argument.arg for argument in function.args.args}
    return found


def _outside(tree: tuple[Module, ...]) -> list[str]:
    """Names in kernels that come from files which the state of the sources leaves out."""
    inside = {m.name for m in tree if "camrob.compiled" in m.text or m.file.removeprefix("camrob/") in FURTHER}
    return [
        f"{module.at(node)}: {alias.name} of {node.module}"
        for module in tree
        if module.name in inside
        for node in module.nodes
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("camrob")
        for alias in node.names
        if (alias.asname or alias.name) in _names_in_kernels(module) and node.module not in inside
    ]


def test_whatever_kernels_read_is_in_the_state_of_the_sources() -> None:
    assert sum(bool(_names_in_kernels(m)) for m in modules()) > 30
    assert _outside(modules()) == []


def test_a_constant_from_elsewhere_is_found() -> None:
    text = "from camrob.compiled import kernel\nfrom camrob.units import MM\n@kernel(nogil=True)\ndef f(x):\n    return x * MM\n"
    (fault,) = _outside((parse("camrob.made_up", text), parse("camrob.units", "MM = 1e-3\n")))
    assert fault.endswith("MM of camrob.units")
