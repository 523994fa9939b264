"""The effects that take part: every module of the package that holds an `EFFECT`."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterable
from difflib import get_close_matches
from functools import cache

from camrob.errors import InputError
from camrob.gap import effects as package
from camrob.gap.effects.effect import Effect

__all__ = ["library"]


@cache
def _all() -> tuple[Effect, ...]:
    found = []
    for module in sorted(m.name for m in pkgutil.iter_modules(package.__path__)):
        effect = getattr(importlib.import_module(f"{package.__name__}.{module}"), "EFFECT", None)
        if isinstance(effect, Effect):
            found.append(effect)
    return tuple(found)


def library(without: Iterable[str] = (), extra: Iterable[Effect] = ()) -> tuple[Effect, ...]:
    """All effects, and `extra` ones of a cell, but some. Raises InputError for a name that no effect has."""
    left_out = set(without)
    every = (*_all(), *extra)
    known = {e.name for e in every}
    for name in sorted(left_out - known):
        near = get_close_matches(name, sorted(known), n=1)
        hint = f"is it {near[0]}?" if near else f"use one of {', '.join(sorted(known))}"
        raise InputError(f"--without {name[:40]!r} is not an effect", hint=hint)
    return tuple(e for e in every if e.name not in left_out)
