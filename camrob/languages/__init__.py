"""The robot languages that are known: one folder and one line a language. None is loaded before it is asked for."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import cast

from camrob.errors import CellError, InputError
from camrob.program.language import Language

__all__ = [
    "LANGUAGES",
    "Registered",
    "language_named",
    "language_of_file",
    "language_suffixes",
    "program_suffixes",
]


@dataclass(frozen=True, slots=True)
class Registered:
    """Where a language is: the module whose `LANGUAGE` it is, and the suffixes of its files, the program's own first."""

    module: str
    suffixes: tuple[str, ...]


LANGUAGES: dict[str, Registered] = {
    "krl": Registered("camrob.languages.krl", (".src", ".dat")),
    "rapid": Registered("camrob.languages.rapid", (".mod", ".pgf")),
}


def language_named(name: str) -> Language:
    """The language that a cell's controller takes; "": the first of `LANGUAGES`. Raises CellError for one that is not known."""
    name = name or next(iter(LANGUAGES))
    if name not in LANGUAGES:
        raise CellError(f"language is {name[:40]!r}", hint="the languages are " + ", ".join(sorted(LANGUAGES)))
    return cast(Language, import_module(LANGUAGES[name].module).LANGUAGE)


def language_of_file(path: Path) -> Language:
    """The language of a program's file, by its suffix. Raises InputError for a suffix that no language has."""
    suffix = path.suffix.lower()
    found = next((name for name, one in LANGUAGES.items() if suffix == one.suffixes[0]), None)
    if found is None:
        raise InputError(
            "is not a robot program", hint="name a file that ends with " + " or ".join(program_suffixes()), path=path
        )
    return language_named(found)


def program_suffixes() -> tuple[str, ...]:
    """The suffixes of the main files of all languages."""
    return tuple(one.suffixes[0] for one in LANGUAGES.values())


def language_suffixes() -> tuple[str, ...]:
    """The suffixes of all files of all languages."""
    return tuple(suffix for one in LANGUAGES.values() for suffix in one.suffixes)
