"""The page of many jobs: what went wrong first, then every job with its figures and the way to its own report."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path
from urllib.parse import quote

from camrob.report.page.html import duration, escape, number, page
from camrob.report.page.parts import card_row, page_body, section, table, verdict_bar
from camrob.report.words import JOB_STATUS, many, shown_paths
from camrob.summaries.batch_summary import BatchSummary, JobFigures

__all__ = ["batch_report"]

_TAGS = {0: "info", 1: "warning", 2: "error", 3: "error"}
_REASONS = 3  # of a job, the others stand in its own report


def batch_report(summary: BatchSummary, folder: Path) -> str:
    """The page as text, for a file in `folder`, from which its links to the jobs' reports lead."""
    names = dict(zip([j.index for j in summary.jobs], shown_paths([j.input for j in summary.jobs]), strict=True))
    rows = [_row(job, names[job.index], folder) for job in summary.jobs]
    heads = ("job", "points", "lowest 1/k_F", "least to a limit, deg or mm", "time", "warnings", "took")
    body = page_body(
        many(len(summary.jobs), "job"),
        "",
        _verdict(summary),
        _failures(summary, names),
        card_row(_cards(summary, names)),
        section("All jobs", table(heads, rows, left=1)),
        note="Each job is judged by itself, as its own command would; reports open from the folders that the jobs wrote them to.",
    )
    return page("camrob batch", body, {"names": {}})


def _verdict(summary: BatchSummary) -> str:
    well = summary.counts.get("0", 0)
    bad = len(summary.jobs) - well
    if not bad:
        return verdict_bar("good", "All done.", "Every check of every job holds.")
    text = f"{well:,} of {len(summary.jobs):,} are done; what stands against the others is named below."
    return verdict_bar("bad", f"{bad:,} not done.", text)


def _failures(summary: BatchSummary, names: Mapping[int, str]) -> str:
    rows = [
        [f"{_tag(job)}<br>{_breakable(names[job.index])}", "<br>".join(escape(r) for r in reasons)]
        for job in summary.jobs
        if (reasons := _reasons(job))
    ]
    return section("What stands against them", table(("job", "why"), rows, left=2)) if rows else ""


def _reasons(job: JobFigures) -> list[str]:
    left = len(job.against) - _REASONS
    return [*job.against[:_REASONS], *([f"and {left:,} more"] if left > 0 else [])]


def _cards(summary: BatchSummary, names: Mapping[int, str]) -> list[tuple[str, str, str]]:
    done = [job for job in summary.jobs if job.status == 0]
    points, seconds = sum(job.points or 0 for job in done), sum(job.program_s or 0.0 for job in done)
    lowest = [(kf, names[job.index]) for job in summary.jobs if (kf := job.lowest_inv_kf) is not None]
    where = many(summary.workers, "worker") if summary.workers else f"the cluster at {summary.scheduler}"
    cards = [
        (
            "Done",
            f"{summary.counts.get('0', 0):,} of {len(summary.jobs):,}",
            f"in {duration(summary.seconds)} on {where}",
        )
    ]
    if points:
        cards.append(("Points", f"{points:,}", f"{duration(seconds)} of motion" if seconds else ""))
    if lowest:
        kf, job = min(lowest)
        cards.append(("Nearest to singular", number(kf, 3), f"lowest 1/k_F, in {job}"))
    return cards


def _tag(job: JobFigures) -> str:
    return f'<span class="tag {_TAGS.get(job.status, "error")}">{JOB_STATUS.get(job.status, "?")}</span>'


def _breakable(path: str) -> str:
    """A path in HTML that a narrow column breaks behind its separators, not amid a word."""
    return re.sub(r"([/\\_-])", r"\1<wbr>", escape(path))


def _row(job: JobFigures, name: str, folder: Path) -> list[str]:
    least = job.least_margin
    again = f" {job.attempts} attempts" if job.attempts > 1 else ""
    return [
        f"{_tag(job)}{again} {escape(job.verb)} {_link(job, folder)}<br>{_breakable(name)}",
        number(job.points, 0),
        number(job.lowest_inv_kf, 3),
        "–" if least is None else f"{escape(least[1])} {number(least[0], 1)}",
        duration(job.program_s),
        number(job.warned, 0),
        number(job.seconds, 1, "s") if job.seconds >= 0.1 else "&lt; 0.1 s",
    ]


def _link(job: JobFigures, folder: Path) -> str:
    """The way from the page to a job's own report: relative, so that the folders can be moved together."""
    pages = [name for name in job.files if name.endswith(".html")]
    if job.out is None or not pages:
        return ""
    there = os.path.relpath(Path(job.out) / pages[0], folder)
    return f'<a href="./{quote(Path(there).as_posix())}">{escape(pages[0])}</a>'
