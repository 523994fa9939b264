"""The examples in the docstrings of the public functions: run, in a folder with the shipped cells and the engraving sample."""

from __future__ import annotations

import doctest
import inspect
import shutil
from pathlib import Path

import pytest
from structure_tree import ROOT

import camrob

# in the order in which one needs what another has made
VERBS = (
    "post",
    "verify",
    "simulate",
    "diagnose",
    "calibrate",
    "compensate",
    "close_loop",
    "predict",
    "feed",
    "batch",
    "place",
    "regress",
    "tune_engines",
    "tracker",
    "track_live",
    "published_case",
    "resolve",
    "fit",
    "correct",
    "explain",
    "run",
    "placements",
    "read_cell",
    "read_setup",
    "read_toolpath",
    "read_program",
    "read_log",
    "shipped_cell",
    "replay",
    "base_T_tool",
)


def _examples(verb: str) -> doctest.DocTest:
    function = getattr(camrob, verb)
    known = {"camrob": camrob, "Path": Path}
    return doctest.DocTestParser().get_doctest(function.__doc__ or "", known, f"camrob.{verb}", None, None)


@pytest.fixture(scope="module")
def workshop(tmp_path_factory) -> Path:
    """A folder with cells, the engraving, and that alone among the samples."""
    folder = tmp_path_factory.mktemp("workshop")
    for name in ("cells", "toolpaths"):
        (folder / name).symlink_to(ROOT / name, target_is_directory=True)
    shutil.copytree(ROOT / "toolpaths" / "engraving", folder / "samples" / "engraving")
    return folder


def test_every_public_function_has_an_example_and_says_what_it_takes() -> None:
    assert {name for name in camrob.__all__ if inspect.isfunction(getattr(camrob, name))} == set(VERBS)
    for verb in VERBS:
        text = getattr(camrob, verb).__doc__
        assert _examples(verb).examples, verb
        for heading in ("Args:", "Raises:", "Example:"):
            assert heading in text, f"{verb} has no {heading}"


@pytest.mark.slow
def test_the_examples_do_what_they_say(workshop: Path, monkeypatch) -> None:
    """One post is enough for all of them."""
    monkeypatch.chdir(workshop)
    output: list[str] = []
    for verb in VERBS:
        runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
        if runner.run(_examples(verb), out=output.append).failed:
            pytest.fail("".join(output), pytrace=False)
        assert runner.summarize(verbose=False).attempted > 0
