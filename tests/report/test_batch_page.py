"""The page of many jobs: what failed comes first, links lead to reports that are there, hostile names stay text."""

from __future__ import annotations

import json
import re
from html import unescape
from pathlib import Path
from urllib.parse import unquote

from camrob.jobs.batch import batch
from camrob.report.batch.page import batch_report
from camrob.report.words import shown_paths
from camrob.summaries.batch_summary import BatchSummary, JobFigures

ROOT = Path(__file__).resolve().parents[2]
JOBS = f"""
[defaults]
cell = "{ROOT.as_posix()}/cells/kr15_track_table"

[[job]]
clfile = "part one/engraving.cls"
out = "{{folder}}"

[[job]]
clfile = "part one/far.cls"
out = "far"

[[job]]
verb = "verify"
program = "golden/engraving.src"
against = "part one/engraving.cls"
"""


def test_a_page_of_three_jobs_leads_to_their_reports(tmp_path: Path) -> None:
    sample = ROOT / "toolpaths" / "engraving"
    folder = tmp_path / "part one"
    folder.mkdir()
    for name in ("engraving.cls", "setup.toml", "stock.stl"):
        (folder / name).write_bytes((sample / name).read_bytes())
    text = (sample / "engraving.cls").read_text()
    (folder / "far.cls").write_text(re.sub(r"GOTO/-?[\d.]+", "GOTO/90000.0", text))
    (tmp_path / "golden").mkdir()
    for file in (sample / "golden").iterdir():
        (tmp_path / "golden" / file.name).write_bytes(file.read_bytes())
    (tmp_path / "JOBS.toml").write_text(JOBS)
    result = batch(tmp_path / "JOBS.toml", out=tmp_path / "programs", report=tmp_path / "pages", workers=1)
    assert sorted(f.name for f in (tmp_path / "pages").iterdir()) == ["batch.html", "batch.json"]
    assert json.loads((tmp_path / "pages" / "batch.json").read_text())["counts"] == dict(result.summary.counts)
    page = (tmp_path / "pages" / "batch.html").read_text(encoding="utf-8")
    links = [unquote(unescape(link)) for link in re.findall(r'href="([^"]+)"', page)]
    assert len(links) == 1
    assert all((tmp_path / "pages" / link).is_file() and link.endswith("engraving.html") for link in links)
    headings = re.findall(r"<h2>(.*?)</h2>", page)
    assert headings == ["What stands against them", "All jobs"] and 'class="verdict bad"' in page
    why = page[page.index("What stands against them") : page.index("All jobs")]
    failed = next(job for job in result.summary.jobs if job.status)
    assert "far.cls" in why and failed.error is not None and failed.error[:30] in unescape(why)
    assert not re.search(r"https?://", page) and "library" not in page.split("<body>")[1].split("<script")[0]


def test_names_cannot_become_anything_but_text_and_paths(tmp_path: Path) -> None:
    bad = '"><script>alert(1)</script>'
    job = JobFigures(
        index=0,
        verb="post",
        input=bad,
        out=str(tmp_path / "javascript:alert(1)"),
        status=0,
        error=None,
        files=(bad + ".html",),
        attempts=1,
        seconds=1.0,
        summary={"points": 5, "warnings": (), "errors": ({"text": bad},)},
    )
    summary = BatchSummary(ok=True, status=0, counts={"0": 1}, workers=1, scheduler=None, jobs=(job, job), seconds=1.0)
    page = batch_report(summary, tmp_path)
    body = page.split("<body>")[1].split('<script type="application/json"')[0]
    assert "<script" not in body and "&lt;script&gt;alert(1)" in body
    assert all(link.startswith("./") for link in re.findall(r'href="([^"]*)"', body))


def test_the_folder_that_all_jobs_share_is_left_out_of_their_names() -> None:
    assert shown_paths(["/parts/a/one.cls", "/parts/b/two.cls"]) == ["a/one.cls", "b/two.cls"]
    assert shown_paths(["/parts/a/one.cls", "/parts/a/one.cls"]) == ["one.cls", "one.cls"]
    assert shown_paths(["/parts/a/one.cls"]) == ["/parts/a/one.cls"]
    assert shown_paths(["a/one.cls", "/a/two.cls"]) == ["a/one.cls", "/a/two.cls"]
