"""What a routine is handed, and what it hands back."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass

from camrob.witness.krl.scope import Scope
from camrob.witness.krl.values import UnknownError, Value, Variables

__all__ = ["hand_back", "hand_over"]

_PLACE = re.compile(r"[A-Z_$]\w*(?:\[[^\[\]]*\])*(?:\.[A-Z_]\w*(?:\[[^\[\]]*\])*)*")


@dataclass(frozen=True, slots=True)
class _Given:
    """One parameter: the caller's variable, indices worked out, and what it held; an array's elements by their index."""

    name: str
    back: bool
    place: str  # "" where it is no variable
    held: dict[str, Value]  # by what stands behind the name: "" or "[3]"


def hand_over(
    variables: Variables, inputs: Sequence[tuple[str, bool]], texts: Sequence[str]
) -> tuple[Scope, list[_Given]]:
    """A routine's own variables as it begins, and what each parameter stands for."""
    own, given = Scope(), list[_Given]()
    for name, _ in inputs:
        own.kinds[name] = ""  # a caller's variable of the same name is another one
        variables.known.add(name)
    for (name, back), text in zip(inputs, texts, strict=False):
        place, held = "", dict[str, Value]()
        with suppress(UnknownError):
            place = variables.indexed(text.replace(" ", "")) if _PLACE.fullmatch(text.replace(" ", "")) else ""
            held = variables.elements(place[:-2]) if place.endswith("[]") else {"": variables.value(text)}
        for behind, value in held.items():
            own.put(name + behind, value)
        given.append(_Given(name, back, place.removesuffix("[]"), held))
    return own, given


def hand_back(variables: Variables, given: Sequence[_Given], own: Scope, *, counted: bool) -> Iterator[str]:
    """Sets the caller's variables to what the routine has made of its parameters; yields what it can't set. counted: those of the
    caller's own count as changed, too.
    """
    for item in given:
        now = {name[len(item.name) :]: value for name, value in own.items() if name.split("[")[0] == item.name}
        if not item.back or (now == item.held and (item.place or item.held)):
            continue
        if not item.place or item.place.startswith("$"):
            if item.place or not item.held:
                yield item.place or item.name
            continue
        variables.changes += counted
        for behind in {*now, *item.held}:
            if behind in now:
                variables.put(item.place + behind, now[behind])
            else:
                variables.forget(item.place + behind)
