"""Mutants of a module, in an order that a seed fixes: every function gets its first one before any gets its second."""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Callable, Container, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from mutation.operators import mutations

PACKAGES = (
    "toolpath",
    "cell",
    "kinematics",
    "redundancy",
    "bodies",
    "checks",
    "program",
    "languages",
    "timing",
    "controller",
    "jobs",
    "dynamics",
)
SINGLE = ("se3", "units", "frozen", "findings", "errors", "text")
# RAPID has a bench of its own: rapid_mutants.py
LEFT_OUT = ("loop", "witness", "gap", "report", "calibration", "measurement", "studies", "languages.rapid")
# rooms whose files bear names that files of another room bear too: a key names the room as well
PARALLEL = ("apt", "gcode")
# Rooms whose changes often show in a program's bytes come first; what reads, replays and judges a program comes last.
OFTEN = (
    ".program.",
    ".languages.krl.writer.",
    ".languages.krl.krl_text",
    ".languages.krl.rounding",
    ".toolpath.",
    ".redundancy.",
    ".kinematics.",
    ".cell.read_",
    ".cell.joint",
    ".cell.status_turn",
    ".cell.arm_axes",
    ".se3",
    ".units",
)
SELDOM = (
    ".controller.",
    ".checks.",
    ".bodies.",
    ".dynamics.",
    ".timing.",
    ".redundancy.planning.",
    ".redundancy.following.",
    ".languages.krl.reader.",
    ".languages.krl.patch",
    ".kinematics.batched",
    ".kinematics.second",
    ".toolpath.apt.word_checks",
    ".toolpath.apt.policy",
    ".toolpath.region",
)
# Operators whose changes are mostly errors of Python's own, or too small to be seen.
WEAK = frozenset(
    """arguments keywords elements name constant-text constant-little constant-double constant-plus constant-minus
    compare-edge double index-plus index-minus return-sign condition-true condition-not""".split()
)
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


@dataclass
class Mutant:
    """One change. key outlives a move of files: the module's last name, the qualified name, operator and ordinal.

    kind: `code` (of a function), `default` (of a parameter), `constant` (a module's). name: of the function or constant.
    lines: where the changed statement stands.
    """

    key: str
    module: str
    name: str
    operator: str
    kind: str
    lines: tuple[int, int]
    node: ast.AST = field(repr=False)
    apply: Callable[[], None] = field(repr=False)
    statement: ast.AST = field(repr=False)
    tree: ast.Module = field(repr=False)

    def what(self) -> str:
        """The change in one line; applies it."""
        before = _told(self.statement)
        self.apply()
        ast.fix_missing_locations(self.statement)
        after = _told(self.statement)
        return f"{_differing(before, after)}"


def in_scope(module: str) -> bool:
    """Whether a module lies between CL file and program."""
    parts = module.split(".")
    inner = ".".join(parts[1:])
    if any(inner == x or inner.startswith(x + ".") for x in LEFT_OUT):
        return False
    return len(parts) > 1 and (parts[1] in PACKAGES or (len(parts) == 2 and parts[1] in SINGLE))


def draw(module: str, path: Path) -> list[Mutant]:
    """All mutants of a module, in the order of its text; their trees hang together, so apply one a process."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    room, short = module.split(".")[-2:]
    short = f"{room}_{short}" if room in PARALLEL else short
    return list(_Drawing(module, short, tree).run())


def ordered(mutants: Iterable[Mutant], seed: int, kernels: Container[str] = ()) -> list[Mutant]:
    """Round after round over the functions, within a round by the seed; what rarely changes a program gets fewer turns, and so
    do compiled kernels ("module:name"), which take ten times as long.
    """
    rank: dict[tuple[str, bool], int] = {}
    keyed = []
    for m in sorted(mutants, key=lambda m: _hash(seed, m.key)):
        weak = m.operator in WEAK or m.kind != "code"
        place = f"{m.module}:{m.name}"
        turns = rank[place, weak] = rank.get((place, weak), 0) + 1
        if any(part in m.module for part in SELDOM):
            turns *= 6
        elif not any(part in m.module for part in OFTEN):
            turns *= 3
        turns *= (3 if weak else 1) * (6 if place in kernels else 1)
        keyed.append((turns, _hash(seed + 1, m.key), m))
    return [m for _, _, m in sorted(keyed, key=lambda k: k[:2])]


def short(text: str) -> str:
    """A text as it stands in the table."""
    line = " ".join(text.split())
    return line if len(line) <= 150 else line[:147] + "..."


def _hash(seed: int, key: str) -> str:
    return hashlib.sha256(f"{seed}:{key}".encode()).hexdigest()


class _Drawing:
    """Walks one module."""

    def __init__(self, module: str, short: str, tree: ast.Module) -> None:
        self.module, self.short, self.tree = module, short, tree
        self.count: dict[tuple[str, str], int] = {}

    def run(self) -> Iterator[Mutant]:
        for node in self.tree.body:
            if isinstance(node, (ast.Assign, ast.AnnAssign)) and node.value is not None:
                target = node.targets[0] if isinstance(node, ast.Assign) else node.target
                if isinstance(target, ast.Name) and target.id != "__all__":
                    yield from self._walk(node.value, node, node, target.id, "constant", set())
            else:
                yield from self._scope(node, "")

    def _scope(self, node: ast.AST, prefix: str) -> Iterator[Mutant]:
        """Functions of a module or a class."""
        if isinstance(node, ast.ClassDef):
            for child in node.body:
                yield from self._scope(child, f"{prefix}{node.name}.")
        elif isinstance(node, _FUNCTIONS):
            name = prefix + node.name
            arguments = node.args
            for default in [*arguments.defaults, *arguments.kw_defaults]:
                if default is not None:
                    yield from self._walk(default, arguments, node, name, "default", set())
            bound = {a.arg for a in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)}
            for child in node.body:
                yield from self._walk(child, node, child, name, "code", bound)

    def _walk(
        self, node: ast.AST, parent: ast.AST, statement: ast.AST, name: str, kind: str, bound: set[str]
    ) -> Iterator[Mutant]:
        if isinstance(node, ast.stmt):
            statement = node
        if _skipped(node):
            return
        for operator, at, change in mutations(node, parent, bound):
            yield self._mutant(operator, at, change, statement, name, kind)
        for child, holder in _children(node):
            yield from self._walk(child, holder, statement, name, kind, bound)
        if isinstance(node, (ast.Assign, ast.AnnAssign, ast.For)):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            bound |= {n.id for t in targets for n in ast.walk(t) if isinstance(n, ast.Name)}

    def _mutant(
        self, operator: str, at: ast.AST, change: Callable[[], None], statement: ast.AST, name: str, kind: str
    ) -> Mutant:
        ordinal = self.count[name, operator] = self.count.get((name, operator), 0) + 1
        key = f"{self.short}.{name}:{operator}:{ordinal}"
        first = getattr(at, "lineno", getattr(statement, "lineno", 1))
        last = getattr(at, "end_lineno", first)
        if not isinstance(statement, (ast.If, ast.While, ast.For, ast.With, ast.Try, *_FUNCTIONS, ast.ClassDef)):
            first, last = getattr(statement, "lineno", first), getattr(statement, "end_lineno", last)
        elif isinstance(at, ast.stmt) and at is statement:
            last = first
        # a dropped or doubled statement hangs in its parent: describe the parent's own text by the statement
        return Mutant(key, self.module, name, operator, kind, (first, last), at, change, statement, self.tree)


def _skipped(node: ast.AST) -> bool:
    """Annotations, documentation, and what is only said in an error."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _children(node: ast.AST) -> Iterator[tuple[ast.AST, ast.AST]]:
    """Children that matter, each with the node that holds it."""
    if isinstance(node, (ast.Raise, ast.JoinedStr, ast.Import, ast.ImportFrom, ast.Global, ast.Nonlocal)):
        return
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "type_comment", "ctx", "op", "ops"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.arguments):
                continue
            if isinstance(child, ast.AST):
                yield child, node


def _told(statement: ast.AST) -> str:
    """The statement's own text, without the block that it opens."""
    text = ast.unparse(statement)
    return (
        text.split("\n", 1)[0] if isinstance(statement, (ast.If, ast.For, ast.While, ast.With, *_FUNCTIONS)) else text
    )


def _differing(before: str, after: str) -> str:
    """Both texts about the place where they differ, short."""
    if before == after:
        return before[:70]
    k = next((i for i, (a, b) in enumerate(zip(before, after, strict=False)) if a != b), min(len(before), len(after)))
    tail = 0
    while tail < min(len(before), len(after)) - k and before[-1 - tail] == after[-1 - tail]:
        tail += 1
    low = max(0, k - 18)
    cut = [text[low : len(text) - max(0, tail - 14)].replace("\n", " ") for text in (before, after)]
    return " -> ".join(c if len(c) <= 70 else c[:67] + ".." for c in cut)
