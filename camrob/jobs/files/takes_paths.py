"""Paths that a caller may give as text."""

from __future__ import annotations

import functools
import inspect
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

__all__ = ["takes_paths"]

_P = ParamSpec("_P")
_R = TypeVar("_R")


def takes_paths(verb: Callable[_P, _R]) -> Callable[_P, _R]:
    """A verb whose arguments that are paths, alone or in sequences, may be text: `camrob.post("part.cls", ...)`.

    One path counts as a sequence of one.
    """
    signature = inspect.signature(verb)
    paths = {name: str(p.annotation) for name, p in signature.parameters.items() if "Path" in str(p.annotation)}

    @functools.wraps(verb)
    def with_paths(*args: _P.args, **kwargs: _P.kwargs) -> _R:
        given = signature.bind(*args, **kwargs)
        for name in paths.keys() & given.arguments.keys():
            value = _as_paths(given.arguments[name])
            alone = isinstance(value, Path) and "Sequence" in paths[name]
            given.arguments[name] = [value] if alone else value
        return verb(*given.args, **given.kwargs)

    return with_paths


def _as_paths(value: Any) -> Any:
    if isinstance(value, str | os.PathLike):
        return Path(value)
    return [_as_paths(one) for one in value] if isinstance(value, list | tuple) else value
