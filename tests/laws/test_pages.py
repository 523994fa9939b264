"""The pages: every link leads to a file and a heading that are there, and figures are those of the tables behind them."""

from __future__ import annotations

import csv
import json
import re
import shlex
from collections import Counter
from pathlib import Path

import pytest

from camrob.cli import app as cli

ROOT = Path(__file__).resolve().parents[2]
PAGES = [
    *ROOT.glob("*.md"),
    *(
        p
        for room in ("camrob", "cells", "docs", "examples", "tests", "toolpaths")
        for p in ROOT.glob(f"{room}/**/*.md")
    ),
]
_CODE = re.compile(r"^ *```.*?^ *```$|`[^`\n]*`", re.MULTILINE | re.DOTALL)
_LINK = re.compile(r"\[[^\[\]]*\]\(([^()\s#]*)(?:#([^()\s]*))?\)")
_FILE = re.compile(r"`((?:camrob|cells|docs|examples|tests|toolpaths|\.ci)/[\w./-]*\w)/?`")
_HEADING = re.compile(r"^#+ (.*)$", re.MULTILINE)


def anchors(page: Path) -> set[str]:
    """What a page's headings are called in links: as GitHub and the site make them."""
    text = re.sub(r"^ *```.*?^ *```$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in _HEADING.findall(text)}


def dead_links(page: Path) -> list[str]:
    """The links of a page that lead nowhere; those to the web are not followed."""
    dead = []
    for target, heading in _LINK.findall(_CODE.sub("", page.read_text(encoding="utf-8"))):
        if target.startswith(("http:", "https:", "mailto:")):
            continue
        there = page.parent / target if target else page
        if not there.exists() or (heading and heading not in anchors(there)):
            dead.append(f"{target}#{heading}" if heading else target)
    return dead


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_lead_somewhere(page: Path) -> None:
    assert not dead_links(page)


def test_dead_links_are_seen(tmp_path: Path) -> None:
    (tmp_path / "there.md").write_text('# What "this" is\n\n```sh\n# no heading\n```\n')
    page = tmp_path / "page.md"
    page.write_text(
        "## Here\n[a](there.md#what-this-is) [b](#here) `[c](code.md)` [d](gone.md) [e](there.md#no-heading) [f](#there)"
        " [g](mailto:gone)\n"
    )
    assert dead_links(page) == ["gone.md", "there.md#no-heading", "#there"]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_files_that_a_page_names_are_there(page: Path) -> None:
    if page.name in ("CHANGELOG.md", "CONTRIBUTING.md"):  # what was there then; what a recipe is going to add
        return
    named = _FILE.findall(page.read_text(encoding="utf-8"))
    assert not [name for name in named if "NAME" not in name and not (ROOT / name).exists()]


def golden(sample: str) -> dict:
    return json.loads((ROOT / "toolpaths" / sample / "golden" / f"{sample}.json").read_text(encoding="utf-8"))


def test_the_samples_figures_are_those_of_their_golden_files() -> None:
    """Conditioning and travel by the published method, in both tables of the page."""
    page = (ROOT / "docs" / "explanation" / "method.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| \[(\w+)\].*?(?:, ([\d ]+) points)? \| ([\d.]+) \(([\d.]+)\) \|", page, re.MULTILINE)
    assert {row[0] for row in rows} == {"carving", "relief", "engraving", "globe"}
    for sample, points, mean, lowest in rows:
        found = golden(sample)
        assert int(points.replace(" ", "")) == found["verified"]["points"], sample
        inverse = found["conditioning"]
        assert (mean, lowest) == (f"{inverse['inv_kf_mean']:.3f}", f"{inverse['inv_kf_min']:.3f}"), sample
    rows = re.findall(r"^\| (\w+) \| ([\d.]+), ([\d ]+) mm and ([\d ]+) degrees \|", page, re.MULTILINE)
    assert {row[0] for row in rows} == {"carving", "relief", "engraving"}
    for sample, mean, slid, turned in rows:
        found = golden(sample)
        travel = found["external_travel"]
        assert mean == f"{found['conditioning']['inv_kf_mean']:.3f}", sample
        assert [int(v.replace(" ", "")) for v in (slid, turned)] == [round(travel["E1_mm"]), round(travel["E2_deg"])]


def test_the_mutants_figures_are_those_of_the_rows() -> None:
    with (ROOT / "tests" / "bench" / "mutants_table.csv").open(encoding="utf-8", newline="") as rows:
        outcomes = Counter(row["outcome"] for row in csv.DictReader(rows))
    assert set(outcomes) == {"stopped", "valid", "wrong in part"}  # and none of "wrong", as the pages say
    found = [f"{count:,}".replace(",", " ") for count in (outcomes.total(), *outcomes.values())]
    page = (ROOT / "docs" / "reference" / "verified.md").read_text(encoding="utf-8")
    (said,) = re.findall(r"([\d ]+) mutants .*?: ([\d ]+) stopped, ([\d ]+) right .*?, none wrong but (\d+) ", page)
    assert [said[0].strip(), *sorted(said[1:])] == [found[0], *sorted(found[1:])]
    assert f"Of {found[0]} mutants" in (ROOT / "README.md").read_text(encoding="utf-8")


def test_readme_sums_up_the_authors_of_cases() -> None:
    page = (ROOT / "docs" / "explanation" / "gap.md").read_text(encoding="utf-8")
    row = r"^\| \[\w+\].*\| (\d+) % \(\d+ of \d+\) \| (\d+) % \(\d+ of \d+\) \| (\d+) of (\d+) \|$"
    right, wrong, sure_wrong, sure = zip(
        *(map(int, found) for found in re.findall(row, page, re.MULTILINE)), strict=True
    )
    text = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    assert len(right) == 12 and "by twelve authors" in text
    assert f"it claimed {min(right)} to {max(right)} % of the causes" in text
    assert f"{min(wrong)} to {max(wrong)} % of all its claims were wrong" in text
    assert f"{sum(sure_wrong)} of the {sum(sure)} that" in text


def test_readmes_first_command_prints_what_it_shows(tmp_path, capsys, monkeypatch) -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    command = next(line for line in text.splitlines() if line.startswith(".venv/bin/camrob post "))
    shown = text.split("```text\n", 1)[1].split("```", 1)[0]
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.chdir(tmp_path)
    for name in ("cells", "toolpaths"):
        (tmp_path / name).symlink_to(ROOT / name)
    assert cli.run(shlex.split(command)[1:]) == 0
    printed = "\n".join(line.rstrip() for line in capsys.readouterr().out.splitlines())
    missing = [line for line in shown.splitlines() if line not in printed]
    assert not missing, printed
