"""Shell completion: the script that a shell takes, and the verbs that it then offers."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

CAMROB = Path(sys.executable).with_name("camrob")


def said(*arguments: str, **variables: str) -> str:
    """What the command prints; it has to end well."""
    done = subprocess.run(
        [str(CAMROB), *arguments],
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    return done.stdout


def test_a_verb_is_completed() -> None:
    script = said(_CAMROB_COMPLETE="source_bash")
    assert "complete -o default -F _camrob_completion camrob" in script
    verbs = said(_CAMROB_COMPLETE="complete_bash", COMP_WORDS="camrob d", COMP_CWORD="1").split()
    assert verbs == ["diagnose"]
    assert "--install-completion" in said("--help")


def test_options_are_completed() -> None:
    options = said(_CAMROB_COMPLETE="complete_bash", COMP_WORDS="camrob post --met", COMP_CWORD="2").split()
    assert options == ["--method"]


def test_cells_and_studies_are_completed_by_name() -> None:
    def completed(words: str) -> list[str]:
        return said(_CAMROB_COMPLETE="complete_bash", COMP_WORDS=words, COMP_CWORD=str(len(words.split()) - 1)).split()

    assert completed("camrob post part.cls --cell kr1") == ["kr15_track_table"]
    assert completed("camrob study tra") == ["tracker"]
    assert completed("camrob cell check ../somebody") == []  # nothing of ours: the shell goes on with its files
