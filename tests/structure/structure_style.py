"""House rules over the syntax tree: sizes, words, `__all__`, docstrings, units, and what no file may hold."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from structure_tree import Module, functions, public_definitions

__all__ = [
    "all_faults",
    "code_lines",
    "docstring_faults",
    "drawn_tree",
    "empty_faults",
    "place_faults",
    "size_faults",
    "unit_faults",
    "word_faults",
]

FILE_LINES, FUNCTION_LINES = 400, 60
# longer than the budget, and why: "path" or "path:function" to (lines, reason)
MAY_BE_LONG: dict[str, tuple[int, str]] = {}
COMMAND_LINE = {
    "camrob.cli.app",
    "camrob.cli.real",
    "camrob.cli.console",
    "camrob.cli.options",
    "camrob.__main__",
    "camrob.witness.proof_check.__main__",
    "camrob.warm.__main__",
    "camrob.warm.ahead",
}


def size_faults(tree: Iterable[Module]) -> list[str]:
    """Files and functions beyond their budget."""
    faults = []
    for module in tree:
        name = module.file
        lines = len(module.text.splitlines())
        if lines > MAY_BE_LONG.get(name, (FILE_LINES, ""))[0]:
            faults.append(f"{name}: {lines} lines")
        for function in functions(module):
            length = code_lines(function)
            if length > MAY_BE_LONG.get(f"{name}:{function.name}", (FUNCTION_LINES, ""))[0]:
                faults.append(f"{module.at(function)}: {function.name} has {length} lines")
    return faults


def code_lines(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Lines of a function without its docstring.

    What is hard to follow is code. If words counted, a public verb, which has to say what it takes, raises and returns, and to
    show an example, would be a docstring over a call of a private twin of the same parameters.
    """
    lines = (function.end_lineno or function.lineno) - function.lineno + 1
    first = function.body[0]
    if ast.get_docstring(function, clean=False) is None:
        return lines
    return lines - ((first.end_lineno or first.lineno) - first.lineno + 1)


def word_faults(tree: Iterable[Module]) -> list[str]:
    """What a library doesn't do: print, leave, assert, promise."""
    faults = []
    for module in tree:
        speaks = module.name in COMMAND_LINE
        for node in module.nodes:
            if isinstance(node, ast.Assert):
                faults.append(f"{module.at(node)}: assert")
            elif isinstance(node, ast.Call) and not speaks and ast.unparse(node.func) in _SPEAKING:
                faults.append(f"{module.at(node)}: {ast.unparse(node.func)}")
            elif isinstance(node, ast.Name | ast.Attribute) and ast.unparse(node) in _UNFINISHED:
                faults.append(f"{module.at(node)}: {ast.unparse(node)}")
        for number, line in enumerate(module.text.splitlines(), start=1):
            if re.search(r"\b(TODO|FIXME|XXX|HACK)\b", line):
                faults.append(f"{module.file}:{number}: {line.strip()}")
    return faults


_SPEAKING = {"print", "sys.exit", "exit", "quit", "os._exit", "input", "breakpoint"}
_UNFINISHED = {"NotImplementedError", "SystemExit"}


def empty_faults(tree: Iterable[Module]) -> list[str]:
    """Bodies of `pass` alone, and of `...` alone outside of protocols and overloads."""
    faults = []
    for module in tree:
        protocols = {
            id(inner)
            for node in module.nodes
            if isinstance(node, ast.ClassDef) and any("Protocol" in ast.unparse(base) for base in node.bases)
            for inner in ast.walk(node)
        }
        for node in module.nodes:
            body = getattr(node, "body", None)
            if not isinstance(body, list) or not body:
                continue
            real = [
                s
                for s in body
                if not (
                    isinstance(s, ast.Expr) and isinstance(s.value, ast.Constant) and isinstance(s.value.value, str)
                )
            ]
            if real and all(isinstance(s, ast.Pass) for s in real):
                faults.append(f"{module.at(node)}: a body of pass")
            dots = real and all(
                isinstance(s, ast.Expr) and isinstance(s.value, ast.Constant) and s.value.value is ... for s in real
            )
            overload = any("overload" in ast.unparse(d) for d in getattr(node, "decorator_list", []))
            if dots and id(node) not in protocols and not overload:
                faults.append(f"{module.at(node)}: a body of ...")
    return faults


def docstring_faults(tree: Iterable[Module]) -> list[str]:
    """Public modules, classes, functions and methods that don't say what they are."""
    faults = []
    for module in tree:
        if not ast.get_docstring(module.tree):
            faults.append(f"{module.file}: no docstring")
        for node in public_definitions(module):
            inner = node.body if isinstance(node, ast.ClassDef) else []
            methods = [
                m
                for m in inner
                if isinstance(m, ast.FunctionDef) and not m.name.startswith("_") and not m.decorator_list
            ]
            faults += [
                f"{module.at(n)}: {n.name} has no docstring" for n in (node, *methods) if not ast.get_docstring(n)
            ]
    return faults


def _listed(module: Module) -> list[str] | None:
    """What `__all__` lists, None where it is absent or no plain list."""
    for node in module.tree.body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            try:
                return list(ast.literal_eval(node.value))
            except ValueError:
                return None
    return None


def _top_names(body: Iterable[ast.stmt]) -> Iterator[str]:
    """Names that statements at a module's top bind."""
    for node in body:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield node.name
        elif isinstance(node, ast.Import | ast.ImportFrom):
            yield from (alias.asname or alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            yield from (n.id for target in targets for n in ast.walk(target) if isinstance(n, ast.Name))
        elif isinstance(node, ast.If | ast.Try):
            yield from _top_names([*node.body, *node.orelse])


def all_faults(tree: Iterable[Module]) -> list[str]:
    """Modules whose `__all__` is absent, repeats itself, names what isn't there, or leaves a public definition out."""
    faults = []
    for module in tree:
        public = {node.name for node in public_definitions(module)}
        listed = _listed(module)
        if listed is None:
            if len(module.tree.body) > 1:  # more than a docstring
                faults.append(f"{module.file}: no plain __all__")
            continue
        missing, unknown = public - set(listed), set(listed) - set(_top_names(module.tree.body))
        faults += [f"{module.file}: __all__ leaves out {name}" for name in sorted(missing)]
        faults += [f"{module.file}: __all__ names {name}, which isn't there" for name in sorted(unknown)]
        if len(set(listed)) < len(listed):
            faults.append(f"{module.file}: __all__ repeats itself")
    return faults


# numbers that only a conversion between the trade's units and SI multiplies or divides by
_FACTORS = {1000, 0.001, 60000, 25.4, 0.0254, 3600000}
_MATHS = {"math", "np", "numpy", "torch"}
_CONVERTERS = {"radians", "degrees", "deg2rad", "rad2deg"}
# "path:function" to the reason why a factor there converts nothing
NO_CONVERSION: dict[str, str] = {
    "camrob/redundancy/following/linear_algebra.py:solve_positive": "pivots are compared with the matrix's own scale",
}


def unit_faults(tree: Iterable[Module]) -> list[str]:
    """Conversions of units anywhere but in units.py."""
    faults = []
    for module in tree:
        if module.name in (
            "camrob.units",
            "camrob.witness.units",
            "camrob.witness.proof_check.dh_machine",
        ):  # the judges share no conversion with what they judge
            continue
        excused = {
            id(node)
            for function in functions(module)
            if f"{module.file}:{function.name}" in NO_CONVERSION
            for node in ast.walk(function)
        }
        for node in module.nodes:
            if id(node) not in excused and _converts(node):
                faults.append(f"{module.at(node)}: {ast.unparse(node)}: convert through camrob.units")
    return faults


def _converts(node: ast.AST) -> bool:
    """Whether an expression is a conversion."""
    if isinstance(node, ast.BinOp | ast.AugAssign) and isinstance(node.op, ast.Mult | ast.Div):
        sides = (node.left, node.right) if isinstance(node, ast.BinOp) else (node.value,)
        values = [s.value for s in sides if isinstance(s, ast.Constant) and isinstance(s.value, int | float)]
        if any(value in _FACTORS for value in values):
            return True
        return 180 in values and any(ast.unparse(s).rpartition(".")[2] == "pi" for s in sides)
    if isinstance(node, ast.ImportFrom):
        return node.module in _MATHS and any(alias.name in _CONVERTERS for alias in node.names)
    return isinstance(node, ast.Attribute) and node.attr in _CONVERTERS and ast.unparse(node.value) in _MATHS


def drawn_tree(docstring: str) -> dict[str, str]:
    """Class to base, from a tree drawn with ├──, └── and │ in a docstring."""
    parents: list[str] = []
    found: dict[str, str] = {}
    for line in docstring.splitlines():
        match = re.match(r"^(?: {4})?((?:[│ ]   )*)(?:[├└]── )?([A-Z]\w*Error)\b", line)
        if not match:
            continue
        depth = len(match[1]) // 4 + ("── " in line)
        parents = [*parents[:depth], match[2]]
        found[match[2]] = parents[depth - 1] if depth else ""
    return found


_ROOTS = ("work", "tmp", "opt", "root", "home", "usr/local", "mnt")
_MACHINE_PATH = re.compile(rf"(?<![\w.$}}~/-])/(?:{'|'.join(_ROOTS)})/\w")
_ADDRESS = re.compile(r"\bhttps?://([\w.-]+)", re.IGNORECASE)
_INDEX_OPTION = re.compile(r"--(?:extra-)?index[-]url|--trusted[-]host|--find[-]links")
_MAY_BE_NAMED = {"www.w3.org", "www.apache.org", "doi.org", "creativecommons.org", "localhost", "127.0.0.1"}
_TEXT = {".py", ".md", ".toml", ".fis", ".csv", ".cls", ".ncl", ".apt", ".src", ".dat", ".json", ".sub", ".txt", ""}


def place_faults(files: Iterable[Path]) -> list[str]:
    """Paths of one machine, and addresses of hosts, in text files."""
    faults = []
    for path in files:
        if path.suffix not in _TEXT or path.stat().st_size > 5_000_000:
            continue
        try:
            lines = path.read_text(encoding="utf-8").splitlines()
        except UnicodeDecodeError:
            continue
        for number, line in enumerate(lines, start=1):
            hosts = set(_ADDRESS.findall(line)) - _MAY_BE_NAMED
            if _MACHINE_PATH.search(line) or _INDEX_OPTION.search(line) or hosts:
                faults.append(f"{path}:{number}: {line.strip()[:100]}")
    return faults
