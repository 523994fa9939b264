"""Who names no language writes none of its words to people either: a cell may be programmed in another one."""

from __future__ import annotations

import ast
import re

import pytest
from structure_tree import modules, parse

ROOMS = ("controller", "checks", "gap", "jobs", "prediction", "program", "redundancy", "report", "summaries", "timing")
# who may name one: the languages, the witness, help and errors that list what is known, and what tells foreign files apart
NAMED_IN = ("languages", "witness", "cli", "errors", "toolpath.foreign")
NAMES = re.compile(r"\bKRL\b")  # RAPID is a word of CL files too
WORDS = re.compile(r"\$(VEL|APO|ACC|TOOL|BASE|LOAD)\b|\bC_(DIS|VEL|ORI)\b|\bKRL\b|\bMove[LCJ]\b|\bE6POS\b")


def faults(tree) -> list[str]:
    """Texts, docstrings apart, that hold a word of a robot language."""
    found = []
    for module in tree:
        if module.name.split(".")[1:2] and module.name.split(".")[1] in ROOMS:
            own = {id(n.value) for n in module.nodes if isinstance(n, ast.Expr)}
            found += [
                f"{module.at(node)}: {node.value[:60]!r}"
                for node in module.nodes
                if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in own
                if WORDS.search(node.value)
            ]
    return found


def names(tree) -> list[str]:
    """Lines, docstrings and comments among them, that name a robot language."""
    return [
        f"{module.file}:{number}: {line.strip()[:80]}"
        for module in tree
        if not module.name.partition(".")[2].startswith(NAMED_IN)
        for number, line in enumerate(module.text.splitlines(), start=1)
        if NAMES.search(line)
    ]


def test_nobody_but_a_language_says_its_words_or_its_name() -> None:
    assert faults(modules()) == []
    assert names(modules()) == []


def test_a_name_of_a_language_is_seen_wherever_it_stands() -> None:
    assert len(names([parse("camrob.cell.planted", "x = 1  # as KRL has it")])) == 1
    assert names([parse("camrob.languages.krl.planted", '"""KRL."""')]) == []


@pytest.mark.parametrize("text", ['x = "set $VEL.CP to 0.2"', 'f"{a} C_DIS"', 'y = "a KRL program"'])
def test_a_word_of_a_language_is_seen(text: str) -> None:
    assert len(faults([parse("camrob.report.post.planted", text)])) == 1
    assert faults([parse("camrob.languages.krl.planted", text)]) == []
    assert faults([parse("camrob.report.post.planted", f'"""{text.split(chr(34))[1]}"""')]) == []
