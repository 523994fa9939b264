"""Paths may be given as text: a verb gets the same."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from pathlib import Path

import pytest

import camrob
from camrob.cli.app import VERBS
from camrob.jobs.files.takes_paths import takes_paths

VERB_NAMES = sorted({verb.__name__ for verb in VERBS} | {"published_case"})


@takes_paths
def verb(
    first: Path, *, cell: Path | None = None, more: Sequence[Path] = (), name: str = ""
) -> tuple[Path, Path | None, Sequence[Path], str]:
    return first, cell, more, name


def test_text_becomes_paths_and_nothing_else_does() -> None:
    assert verb("a", cell="b", more=["c", Path("d")], name="e") == (Path("a"), Path("b"), [Path("c"), Path("d")], "e")
    assert verb(Path("a")) == (Path("a"), None, (), "")
    assert verb("a", more="c") == (Path("a"), None, [Path("c")], "")


@pytest.mark.parametrize("name", VERB_NAMES)
def test_every_verb_says_the_same_of_what_is_not_there(name: str, tmp_path: Path) -> None:
    verb = getattr(camrob, name)
    said = []
    for kind in (str, Path):
        given = {
            p.name: kind(tmp_path / f"no_{p.name}.toml")
            for p in inspect.signature(verb).parameters.values()
            if "Path" in str(p.annotation) and p.default is inspect.Parameter.empty
        }
        with pytest.raises(camrob.CamrobError) as caught:
            verb(**{n: [v] if n in ("log", "on") else v for n, v in given.items()})
        said.append(str(caught.value))
    assert said[0] == said[1]
