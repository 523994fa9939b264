"""The tutorials of `docs/` do what they say, and the pages agree with what is there.

A block fenced as sh is run by bash, in a folder that looks like the repository's root; of the block fenced as text behind it,
each stretch between two "..." stands in what was printed, line by line.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

import camrob
from camrob.cli.app import VERBS

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
TUTORIALS = DOCS / "tutorials"
NEEDS = {  # pages whose commands have to have been run before
    "post_a_part": (),
    "make_a_cell": (),
    "diagnose_a_log": ("post_a_part",),
    "close_the_gap": ("diagnose_a_log",),
    "write_an_effect": ("post_a_part",),
}
_BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks(page: str) -> list[tuple[str, str]]:
    """Commands of a page, each with the lines it is said to print."""
    found = _BLOCK.findall((TUTORIALS / f"{page}.md").read_text(encoding="utf-8"))
    after = [*found[1:], ("", "")]
    return [
        (text, shown[1] if shown[0] == "text" else "")
        for (kind, text), shown in zip(found, after, strict=True)
        if kind == "sh"
    ]


@pytest.fixture(scope="module")
def said(tmp_path_factory: pytest.TempPathFactory):
    """Runs a page, after those that it needs, once: what each of its commands printed."""
    root = tmp_path_factory.mktemp("root")
    for name in ("cells", "toolpaths", "tests", "examples"):
        (root / name).symlink_to(ROOT / name)
    (root / ".venv").symlink_to(sys.prefix)

    @cache
    def run(page: str) -> tuple[str, ...]:
        for needed in NEEDS[page]:
            run(needed)
        return tuple(printed(command, root) for command, _ in blocks(page))

    return run


def printed(command: str, root: Path) -> str:
    ran = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", command],
        cwd=root,
        env={**os.environ, "COLUMNS": "80", "NO_COLOR": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
    )
    assert ran.returncode == 0, f"{command}\n{ran.stdout}"
    return "\n".join(line.rstrip() for line in ran.stdout.splitlines())


@pytest.mark.slow
@pytest.mark.parametrize("page", NEEDS)
def test_a_tutorial_prints_what_it_shows(page: str, said) -> None:
    assert blocks(page)
    for (command, shown), got in zip(blocks(page), said(page), strict=True):
        for stretch in re.split(r"^\.\.\.\n", shown, flags=re.MULTILINE):
            assert stretch.rstrip("\n") in got, f"{command}\n{got}"


def test_every_tutorial_is_run_here() -> None:
    assert {p.stem for p in TUTORIALS.glob("*.md")} == set(NEEDS)


def test_the_site_has_every_page() -> None:
    nav = set(re.findall(r": ([\w/]+\.md)$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"), re.MULTILINE))
    assert {p.relative_to(DOCS).as_posix() for p in DOCS.rglob("*.md")} <= nav
    assert {f"reference/cells/{p.parent.name}.md" for p in ROOT.glob("cells/*/README.md")} <= nav


@pytest.mark.slow
def test_the_site_builds(tmp_path: Path) -> None:
    """Every page and link, and the docstrings of all public names; a warning is an error."""
    build = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(tmp_path / "site")]
    ran = subprocess.run(
        build, cwd=ROOT, env={**os.environ, "NO_MKDOCS_2_WARNING": "1"}, capture_output=True, text=True
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    python = (tmp_path / "site" / "reference" / "python" / "index.html").read_text(encoding="utf-8")
    assert not [name for name in camrob.__all__ if f'id="camrob.{name}"' not in python]


def test_the_reference_names_every_public_name_and_every_command() -> None:
    python = (DOCS / "reference" / "python.md").read_text(encoding="utf-8")
    named = re.findall(r"^::: camrob\.(\w+)$", python, re.MULTILINE)
    assert sorted(named) == camrob.__all__
    commands = (DOCS / "reference" / "commands.md").read_text(encoding="utf-8")
    verbs = [v.__name__.replace("_", "-") for v in VERBS]
    assert not [verb for verb in [*verbs, "samples", "cell"] if f"`camrob {verb}" not in commands]


def test_the_keys_of_a_summary_are_those_of_a_real_one() -> None:
    """The object shown for NAME.json, held to a sample's: each of its keys is there, with a value of its type."""
    page = (DOCS / "reference" / "files.md").read_text(encoding="utf-8")
    shown = json.loads(next(text for kind, text in _BLOCK.findall(page) if kind == "json"))
    golden = ROOT / "toolpaths" / "engraving" / "golden" / "engraving.json"
    held_to(shown, json.loads(golden.read_text(encoding="utf-8")), "")


def held_to(shown: object, real: object, place: str) -> None:
    if isinstance(shown, dict):
        assert isinstance(real, dict), place
        for key, value in shown.items():
            assert key in real, f"{place}.{key}"
            held_to(value, real[key], f"{place}.{key}")
    elif isinstance(shown, list) and shown:
        assert isinstance(real, list) and real, place
        held_to(shown[0], real[0], f"{place}[0]")
    elif shown is not None and real is not None:
        kinds = (int, float) if isinstance(shown, (int, float)) and not isinstance(shown, bool) else (type(shown),)
        assert isinstance(real, kinds), place
