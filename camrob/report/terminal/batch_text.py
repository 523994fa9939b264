"""The summary of `camrob batch` for a terminal: what failed first, then every job in a line."""

from __future__ import annotations

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from camrob.report.words import JOB_STATUS, many, shown_number, shown_paths, shown_text
from camrob.summaries.batch_summary import BatchSummary, JobFigures

__all__ = ["render_batch"]

_STYLES = {0: "green", 1: "yellow", 2: "red", 3: "bold red"}


def render_batch(summary: BatchSummary) -> RenderableType:
    """The jobs as a table, and the reasons of those that were not done below it."""
    table = Table(box=None, padding=(0, 2, 0, 0), header_style="bold")
    for heading in ("job", "verb", "result", "points", "worst 1/k_F", "warnings", "seconds"):
        left = heading in ("job", "verb", "result")
        table.add_column(heading, justify="left" if left else "right", overflow="fold", no_wrap=heading != "job")
    reasons: list[RenderableType] = []
    names = shown_paths([job.input for job in summary.jobs])
    for job, name in zip(summary.jobs, names, strict=True):
        word, style = JOB_STATUS.get(job.status, "?"), _STYLES.get(job.status, "red")
        again = f" ({job.attempts} attempts)" if job.attempts > 1 else ""
        table.add_row(
            shown_text(name),
            shown_text(job.verb),
            Text(word + again, style=style),
            shown_number(job.points, 0),
            shown_number(job.lowest_inv_kf, 3),
            shown_number(job.warned, 0),
            _took(job.seconds),
        )
        for reason in _reasons(job):
            whose = () if job.input in reason else (shown_text(name, "bold"), ": ")
            reasons.append(Text.assemble(*whose, shown_text(reason), overflow="fold"))
    well = summary.counts.get("0", 0)
    where = many(summary.workers, "worker") if summary.workers else f"the cluster at {summary.scheduler}"
    end = f"{well} of {len(summary.jobs)} jobs done in {shown_number(summary.seconds)} s on {where}"
    return Group(table, *([Text(""), *reasons] if reasons else []), Text(""), shown_text(end))


def _took(seconds: float) -> str:
    """Seconds of a job, of which a tenth is the least that anyone asks for."""
    return shown_number(seconds) if seconds >= 0.1 else "< 0.1"


def _reasons(job: JobFigures) -> list[str]:
    """The first that stands against a job, and how many more there are."""
    more = f" (and {len(job.against) - 1} more)" if len(job.against) > 1 else ""
    return [text + more for text in job.against[:1]]
