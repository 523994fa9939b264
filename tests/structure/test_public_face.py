"""The public face of the package: what `import camrob` offers, and what a stranger's `help` says of it."""

from __future__ import annotations

import ast
import importlib
import inspect
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import version
from typing import get_args, get_type_hints

import pytest
from structure_tree import ROOT, modules

import camrob
from camrob import errors
from camrob.cli.app import VERBS
from camrob.summaries.base import Summary

FACE = next(m for m in modules() if m.name == "camrob")
# what a verb's module of camrob.jobs is called after, and what stands beside the command line's verbs
JOBS = sorted({verb.__name__ for verb in VERBS} | {"track_live", "published_case"})


def _promised() -> dict[str, str]:
    """Name to module, by the block that type checkers read."""
    block = next(n for n in FACE.tree.body if isinstance(n, ast.If))
    imported = [n for n in block.body if isinstance(n, ast.ImportFrom)]
    return {alias.name: str(n.module) for n in imported for alias in n.names}


def test_type_checkers_and_the_lazy_table_find_every_name_in_one_place() -> None:
    assert _promised() == {name: camrob._HOME.get(name, "camrob.errors") for name in camrob.__all__}
    assert set(camrob._HOME) <= set(camrob.__all__)


def test_every_error_every_verb_and_its_result_are_offered() -> None:
    assert set(errors.__all__) <= set(camrob.__all__)
    assert len(JOBS) == 16
    for verb in JOBS:
        job = importlib.import_module(f"camrob.jobs.{verb}")
        results = {name for name in job.__all__ if name.endswith("Result")}
        assert len(results) == 1 and {verb, *results} <= set(camrob.__all__), verb
        assert getattr(camrob, verb) is getattr(job, verb)


def test_every_result_has_a_typed_summary_that_is_offered() -> None:
    for verb in JOBS:
        job = importlib.import_module(f"camrob.jobs.{verb}")
        (result,) = (name for name in job.__all__ if name.endswith("Result"))
        summary = get_type_hints(getattr(job, result))["summary"]
        kinds = get_args(summary) or (summary,)
        assert all(issubclass(kind, Summary) and kind is not Summary for kind in kinds), verb
        assert summary in [getattr(camrob, name) for name in camrob.__all__ if name.endswith("Summary")], verb


def _named_in(hint: object) -> Iterator[type]:
    """The classes that a type hint is made of."""
    inside = get_args(hint)
    if not inside:
        yield from [hint] if isinstance(hint, type) else []
    for one in inside:
        for part in one if isinstance(one, list | tuple) else [one]:
            yield from _named_in(part)


def test_what_public_functions_take_and_return_and_what_results_hold_is_public_too() -> None:
    told = [name for name in camrob.__all__ if inspect.isfunction(getattr(camrob, name)) or name.endswith("Result")]
    assert len(told) > 40
    for name in [*told, "Resolved"]:
        for part, hint in get_type_hints(getattr(camrob, name)).items():
            own = {kind.__name__ for kind in _named_in(hint) if kind.__module__.startswith("camrob.")}
            assert own <= set(camrob.__all__), f"{part} of {name}: {sorted(own - set(camrob.__all__))}"


def test_the_verb_s_old_home_works_for_a_version_and_says_so() -> None:
    """The contract's words; what camrob itself imports from there says nothing."""
    ask = "import warnings; warnings.simplefilter('error'); import camrob; camrob.post\n"
    subprocess.run([sys.executable, "-c", ask + "import camrob.cli.app"], cwd=ROOT, check=True)
    with pytest.warns(DeprecationWarning, match="camrob.post"):
        exec("from camrob.jobs.post import post", {"__name__": "strangers"})


def test_no_public_name_is_that_of_a_room() -> None:
    """`import camrob.post` would put a package in the function's place."""
    assert not {m.name.split(".")[1] for m in modules() if "." in m.name} & set(camrob.__all__)


def test_a_name_that_was_asked_for_stays_and_can_be_replaced(monkeypatch) -> None:
    assert camrob.Finding is camrob.Finding and vars(camrob)["Finding"] is camrob.Finding
    monkeypatch.setattr(camrob, "Severity", None)
    assert camrob.Severity is None
    assert set(camrob.__all__) <= {
        name for kind in type(camrob).__mro__ for name in vars(kind)
    }  # completion finds them


def test_the_version_is_the_installed_one() -> None:
    assert camrob.__version__ == version("camrob")


def test_help_is_an_overview_with_a_line_for_each_verb() -> None:
    """In a fresh process: `help` says in full what has been used already."""
    ask = "import camrob, pydoc; print(pydoc.plain(pydoc.render_doc(camrob)))"
    shown = subprocess.run([sys.executable, "-c", ask], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    lines = shown.splitlines()
    assert len(lines) <= 112 and max(map(len, lines[:-3])) <= 90
    for verb in JOBS:
        assert sum(line.split()[:1] == [verb] for line in lines) == 1, verb
    said = inspect.getdoc(camrob) or ""
    assert len(said.splitlines()) <= 60
    results = [f"{name}Result" for name in ("Post", "Verify")]
    for name in sorted(set(camrob.__all__) - set(errors.__all__) - set(JOBS) - set(results)):
        assert name in said or name.endswith(("Result", "Summary")), name


def test_a_name_that_camrob_has_not_is_refused() -> None:
    with pytest.raises(AttributeError, match="solve"):
        getattr(camrob, "solve")  # noqa: B009
