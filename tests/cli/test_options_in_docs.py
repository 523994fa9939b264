"""Every option of every verb stands in the row of docs/reference/commands.md that is its own, and no row names any other."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer

from camrob.cli.app import build_app

COMMANDS = (Path(__file__).resolve().parents[2] / "docs" / "reference" / "commands.md").read_text(encoding="utf-8")
EVERYWHERE = {"--json", "--quiet", "--help"}


def _verbs(command: Any, path: str = "camrob") -> Iterator[tuple[str, set[str]]]:
    below = getattr(command, "commands", None)
    if below is None:
        yield path, {o for p in command.params for o in (*p.opts, *p.secondary_opts) if o.startswith("--")} - EVERYWHERE
    for name, one in (below or {}).items():
        yield from _verbs(one, f"{path} {name}")


def test_rows_name_the_options_there_are() -> None:
    rows = [line for line in COMMANDS.splitlines() if line.startswith("| `camrob ")]
    verbs = dict(_verbs(typer.main.get_command(build_app())))
    missing = []
    for verb, options in verbs.items():
        row = next((r for r in rows if re.search(rf"`{verb}(?![\w-])", r)), "")
        missing += [f"{verb} {o}" for o in sorted(options) if not re.search(rf"{o}(?![\w-])", row)]
    assert missing == []
    known = set().union(*verbs.values()) | EVERYWHERE
    assert sorted({o for r in rows for o in re.findall(r"(?<![\w-])--[a-z][a-z-]*", r)} - known) == []
