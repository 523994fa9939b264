"""The verbs that a batch knows. A job's keys are the parameters of its verb's own function, as its types say them."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import Any, get_type_hints

__all__ = ["VERBS", "Kind", "Verb", "Writes", "job_function", "read_verb"]


class Kind(StrEnum):
    """What the value of a key is, in the words of an error."""

    FILE = "a path"
    FILES = "a list of paths"
    TEXT = "a text"
    TEXTS = "a list of texts"
    INTEGER = "a whole number"
    NUMBER = "a number"
    FLAG = "true or false"


class Writes(StrEnum):
    """What `out` names."""

    NOTHING = "nothing"
    FOLDER = "a folder"
    FILE = "a file"


_KINDS: tuple[tuple[Any, Kind], ...] = (
    (Path, Kind.FILE),
    (Path | None, Kind.FILE),
    (Sequence[Path], Kind.FILES),
    (tuple[Path, ...], Kind.FILES),
    (str, Kind.TEXT),
    (str | None, Kind.TEXT),
    (Sequence[str], Kind.TEXTS),
    (tuple[str, ...], Kind.TEXTS),
    (int, Kind.INTEGER),
    (int | None, Kind.INTEGER),
    (float, Kind.NUMBER),
    (float | None, Kind.NUMBER),
    (bool, Kind.FLAG),
)

# verb: the key of the file that a job is about, what it writes, and the values that a key may have
VERBS: Mapping[str, tuple[str, Writes, Mapping[str, tuple[str, ...]]]] = MappingProxyType(
    {
        "post": (
            "clfile",
            Writes.FOLDER,
            {
                "units": ("mm", "inch"),
                "method": ("vjm", "planned"),
                "feed": ("program", "optimal"),
                "device": ("cpu", "cuda"),
            },
        ),
        "verify": ("program", Writes.NOTHING, {}),
        "simulate": ("program", Writes.FILE, {}),
        "compensate": ("program", Writes.FOLDER, {}),
        "calibrate": ("measured", Writes.FILE, {}),
        "diagnose": ("log", Writes.FOLDER, {}),
    }
)


@dataclass(frozen=True, slots=True)
class Verb:
    """A verb: the key `about` which a job is, what `out` names, its keys, those that must be given, and choices."""

    name: str
    about: str
    writes: Writes
    keys: Mapping[str, Kind]
    required: tuple[str, ...]
    choices: Mapping[str, tuple[str, ...]]


def job_function(name: str) -> Callable[..., Any]:
    """The function behind a verb of `VERBS`."""
    return getattr(import_module(f"camrob.jobs.{name}"), name)  # type: ignore[no-any-return]


@cache
def read_verb(name: str) -> Verb:
    """The verb of a name in `VERBS`, with the keys that its function takes today; `progress` is the batch's own."""
    about, writes, choices = VERBS[name]
    function = job_function(name)
    hints = get_type_hints(function)
    keys = {key: kind for key, hint in hints.items() for known, kind in _KINDS if hint == known and key != "return"}
    parameters = inspect.signature(function).parameters
    required = tuple(key for key in keys if parameters[key].default is inspect.Parameter.empty)
    return Verb(name, about, writes, MappingProxyType(keys), required, choices)
