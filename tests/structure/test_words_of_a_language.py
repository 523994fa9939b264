"""Who names no language writes none of its words to people either: a cell may be programmed in another one."""

from __future__ import annotations

import ast
import re

import pytest
from structure_tree import modules, parse

ROOMS = ("controller", "checks", "gap", "jobs", "prediction", "program", "redundancy", "report", "summaries", "timing")
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


def test_nobody_but_a_language_says_its_words() -> None:
    assert faults(modules()) == []


@pytest.mark.parametrize("text", ['x = "set $VEL.CP to 0.2"', 'f"{a} C_DIS"', 'y = "a KRL program"'])
def test_a_word_of_a_language_is_seen(text: str) -> None:
    assert len(faults([parse("camrob.report.post.planted", text)])) == 1
    assert faults([parse("camrob.languages.krl.planted", text)]) == []
    assert faults([parse("camrob.report.post.planted", f'"""{text.split(chr(34))[1]}"""')]) == []
