"""The planner's objective: what its terms are called is known where they are made, and nowhere that a plan goes to."""

from __future__ import annotations

import pytest
from structure_names import _asked
from structure_tree import modules, parse

from camrob.redundancy.planning.objective import MOTION_TERMS, POSTURE_TERMS

TERMS = {*POSTURE_TERMS, *MOTION_TERMS}
HOME = ("camrob.redundancy.planning.",)
# the rooms that a plan goes through; elsewhere words like "speed" and "travel" are those of other things
ROOMS = ("camrob.redundancy.", "camrob.jobs.", "camrob.report.post.", "camrob.summaries.", "camrob.cli.")


def faults(tree) -> list[str]:
    """Comparisons and look-ups with the name of a term outside its home."""
    return [
        f"{module.at(node)}: {node.value!r} is known by name"
        for module in tree
        if module.name.startswith(ROOMS) and not module.name.startswith(HOME)
        for node in _asked(module, TERMS)
    ]


def test_a_term_is_known_by_name_at_home_alone() -> None:
    assert faults(modules()) == []


@pytest.mark.parametrize("asked", ['terms["travel"]', 'if name == "margins":\n    f()', '_ORDER = {"smoothness": 1}'])
def test_one_who_asks_for_a_term_is_seen(asked: str) -> None:
    assert len(faults([parse("camrob.report.post.planted", asked)])) == 1
    assert faults([parse("camrob.redundancy.planning.planted", asked)]) == []
    assert faults([parse("camrob.gap.planted", asked)]) == []
