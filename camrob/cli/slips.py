"""Slips of a command line that its parser takes in silence, or answers by what comes of them."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from typing import Any

__all__ = ["plainly", "slip_of"]

_DASHES = ("\u2012", "\u2013", "\u2014", "\u2015", "\u2212")  # as a text processor makes them of --


# what the parser of values says, and how a person says it
_PLAIN = (
    (
        r"Input should be a valid (?:number|integer), unable to parse string as an? (?:number|integer)",
        "is not a number",
    ),
    (r"Input should be a valid integer.*", "is not a whole number"),
    (r"Input should be greater than or equal to (\S+)", r"give \1 or more"),
    (r"Input should be less than or equal to (\S+)", r"give \1 or less"),
    (r"Value error, ", ""),
)


def plainly(message: str) -> str:
    """A parser's message in one line, in words that a person would use."""
    said = " ".join(message.split()).rstrip(".")
    for theirs, ours in _PLAIN:
        said = re.sub(theirs, ours, said)
    return said


def slip_of(arguments: Sequence[str], command: Any) -> str:
    """What is wrong with the arguments, and what to do, in a line; "" where nothing is. command: click's, of all verbs."""
    verb, words, options = _verb_of(arguments, command)
    if verb and not options:  # no verb: maybe a file in its place
        return _no_verb(arguments, words, verb)
    seen: dict[str, str] = {}
    for name, value in _given(words, options):
        if name.startswith(_DASHES):
            return f"{verb}: {name!r} begins with a text processor's dash; write --{name.lstrip(''.join(_DASHES))}"
        if value == "":
            return f"{verb}: {name or 'an argument'} is empty; give it a value (. is this folder), or leave it out"
        if name in seen and not options[name].multiple:
            return f"{verb}: {name} is given twice, as {seen[name]!r} and {value!r}; give it once"
        if name:
            seen[name] = value or ""
    return ""


def _verb_of(arguments: Sequence[str], command: Any) -> tuple[str, Sequence[str], dict[str, Any]]:
    """The verb's name, the words behind it, and its options by their names; no options where there is no such verb."""
    path, words = "camrob", list(arguments)
    while getattr(command, "commands", None) is not None:
        known = command.commands
        at = next((k for k, word in enumerate(words) if not word.startswith("-")), None)
        if at is None or words[at] not in known:
            return path, words, {}
        command, path, words = known[words[at]], f"{path} {words[at]}", words[at + 1 :]
    return path, words, {name: p for p in command.params for name in p.opts if name.startswith("-")}


def _no_verb(arguments: Sequence[str], words: Sequence[str], path: str) -> str:
    """A file or folder where a verb should stand."""
    first = next((word for word in words if not word.startswith("-")), "")
    if os.sep in first or os.path.exists(first):
        return f"{path}: {first!r} stands where the verb should; write the verb first: {path} VERB {first}"
    return ""


def _given(words: Sequence[str], options: dict[str, Any]) -> Iterator[tuple[str, str | None]]:
    """Options with their values, None for a flag, and arguments under no name, in their order."""
    rest = iter(words)
    for word in rest:
        if word == "--":
            yield from (("", one) for one in rest)
            return
        name, sign, value = word.partition("=")
        if name in options:
            taken = value if sign else None if options[name].is_flag else next(rest, None)
            yield name, taken
        elif word.startswith(_DASHES):
            yield word, None
        else:
            yield "", word
