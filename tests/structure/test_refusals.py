"""Every refusal says what to do: an input's in its hint, a job's behind a semicolon; and none speaks of camrob's inside."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable

from structure_tree import Module, modules, parse

from camrob import errors

INPUT = {n for n in errors.__all__ if issubclass(getattr(errors, n), errors.InputError)}
JOB = {n for n in errors.__all__ if issubclass(getattr(errors, n), errors.JobError)}
# whose refusals a job catches and says in its own words, or that repeat a paper's case
INNER = ("camrob.kinematics", "camrob.studies", "camrob.loop", "camrob.witness", "camrob.redundancy.published")
# what passes on the text of a finding, which has its own advice, or that nobody can do anything about
PASSED_ON = {
    "camrob/controller/replay.py": "finding.text",
    "camrob/jobs/batching/dask_workers.py": "'the batch was interrupted'",
    "camrob/jobs/release/first_free.py": "variant to try",
    "camrob/redundancy/tracing/traced.py": "'no rounds were searched'",
}
INSIDE = re.compile(r"\b(?:region -1|index \{|ndarray|NoneType|traceback|kwargs|dtype)\b", re.IGNORECASE)


def _text(node: ast.AST, function: ast.AST) -> str:
    """What a message says as it is written, with the names in it looked up in the function around it."""
    parts = []
    for inner in ast.walk(node):
        if isinstance(inner, ast.Constant) and isinstance(inner.value, str):
            parts.append(inner.value)
        elif isinstance(inner, ast.Name):
            for other in ast.walk(function):
                target = other.targets[0] if isinstance(other, ast.Assign) else getattr(other, "target", None)
                if isinstance(other, ast.Assign | ast.AugAssign) and ast.unparse(target) == inner.id:
                    parts += [
                        c.value
                        for c in ast.walk(other.value)
                        if isinstance(c, ast.Constant) and isinstance(c.value, str)
                    ]
    return " ".join(parts)


def _refusals(module: Module) -> Iterable[tuple[ast.Call, str, ast.AST]]:
    for function in (n for n in module.nodes if isinstance(n, ast.FunctionDef)):
        for node in ast.walk(function):
            if isinstance(node, ast.Call) and (node.args or node.keywords):
                kind = ast.unparse(node.func).rpartition(".")[2]
                if kind in INPUT | JOB:
                    yield node, kind, function


def _without_cure(tree: Iterable[Module]) -> list[str]:
    faults = []
    for module in tree:
        if module.name.startswith(INNER) or module.name == "camrob.errors":
            continue
        for node, kind, function in _refusals(module):
            if module.file in PASSED_ON and PASSED_ON[module.file] in ast.unparse(node):
                continue
            given = {keyword.arg: keyword.value for keyword in node.keywords}
            if kind in INPUT:
                hint = given.get("hint")
                good = hint is not None and ast.unparse(hint) not in ("''", '""')
            else:
                text = _text(node.args[0], function) if node.args else ""
                good = (
                    ";" in text
                    or "advice(" in ast.unparse(node)
                    or "hint" in ast.unparse(node)
                    or "error" in ast.unparse(node)
                )
            if not good:
                faults.append(f"{module.at(node)}: {kind} says no cure: {ast.unparse(node)[:90]}")
    return sorted(set(faults))


def _badly_said(tree: Iterable[Module]) -> list[str]:
    faults = []
    for module in tree:
        for node, kind, _function in _refusals(module):
            for part in [*node.args[:1], *(k.value for k in node.keywords if k.arg == "hint")]:
                pieces = part.values if isinstance(part, ast.JoinedStr) else [part]
                text = "".join(str(c.value) if isinstance(c, ast.Constant) else "{" for c in pieces)
                if not isinstance(part, ast.JoinedStr | ast.Constant):
                    continue
                if text.rstrip().endswith((".", "!")) or "  " in text or "\n" in text or INSIDE.search(text):
                    faults.append(f"{module.at(node)}: {kind}: {text[:90]}")
    return sorted(set(faults))


def test_every_refusal_says_what_to_do() -> None:
    assert sum(1 for m in modules() for _ in _refusals(m)) > 700
    assert _without_cure(modules()) == []


def test_refusals_are_one_line_without_a_full_stop_and_without_camrobs_inside() -> None:
    assert _badly_said(modules()) == []


def test_planted_refusals_are_found() -> None:
    text = (
        "def f(x):\n    if x:\n        raise CellError('is wrong', path=x)\n"
        "    raise JobError('it is too much.')\n    raise JobError('too much; take less')\n"
    )
    tree = (parse("camrob.cell.made_up", text),)
    assert len(_without_cure(tree)) == 2 and len(_badly_said(tree)) == 1
