"""The list of rules, to which the rules_*.py add theirs: each draws a place in a program and edits it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from text_faults.context import Draw
from text_faults.tree import Tree

Make = Callable[[Draw], Tree]


@dataclass(frozen=True)
class Rule:
    """make raises NothingToDrawError where the rule has no place in a program. times: draws on each program.

    verdict: what an edit counts as.
    `checked`: a fault where text_faults.change finds path, feed, events or limits changed, else it is left out or listed;
    `wrong`: a fault by what KRL says, which the small interpreter does not follow;
    `open`: run and listed, but not counted: what the machine does is not plainly wrong;
    `legal`: the machine does the same, and the program has to pass.
    """

    name: str
    family: str
    make: Make
    verdict: str
    times: int
    only: tuple[str, ...]


RULES: dict[str, Rule] = {}


def rule(
    family: str, verdict: str = "checked", *, times: int = 1, only: tuple[str, ...] = ()
) -> Callable[[Make], Make]:
    """Put a function on the list. only: the jobs that it is for, all where empty."""

    def add(make: Make) -> Make:
        name = make.__name__.strip("_").replace("_", "-")
        if name in RULES:
            raise ValueError(f"two rules called {name}")
        RULES[name] = Rule(name, family, make, verdict, times, only)
        return make

    return add


def all_rules() -> dict[str, Rule]:
    """Every rule by its name."""
    from text_faults import (  # noqa: F401
        rules_control,
        rules_events,
        rules_feed,
        rules_frames,
        rules_hidden,
        rules_motions,
        rules_numbers,
        rules_respelled,
        rules_restructured,
    )

    return RULES
