"""`camrob batch`: many jobs on all cores, or on a cluster; one that fails does not stop the rest."""

from __future__ import annotations

import shutil
import tempfile
import time
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from pathlib import Path

from camrob.errors import InputError
from camrob.jobs.batching.dask_workers import run_cluster
from camrob.jobs.batching.jobs_file import BatchJob, read_jobs
from camrob.jobs.batching.local_workers import cores, run_local
from camrob.jobs.batching.parcel import Parcel, Place, pack_parcel
from camrob.jobs.batching.work import Outcome
from camrob.jobs.exit_status import DONE, failure_line, failure_status
from camrob.jobs.files.output import staged_output
from camrob.jobs.files.summary_file import write_summary
from camrob.jobs.files.takes_paths import takes_paths
from camrob.languages import program_suffixes
from camrob.progress import Progress
from camrob.summaries.batch_summary import BatchSummary, JobFigures
from camrob.text import printable

__all__ = ["BatchResult", "batch"]


@dataclass(frozen=True, slots=True)
class BatchResult:
    """The summary; `status` is that of the worst job (3 before 2 before 1 before 0), `ok` where it is 0."""

    summary: BatchSummary
    status: int

    @property
    def ok(self) -> bool:
        """Whether every job is done and what it checks holds."""
        return self.status == DONE


@takes_paths
def batch(
    jobs: Path,
    *,
    out: Path | None = None,
    report: Path | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> BatchResult:
    r"""Do the jobs of a JOBS.toml, each as its own command would, and say what became of each.

    Jobs run in sandboxes, and the files of each appear in its `out` all or none, when it has ended well; an interruption
    leaves those of the finished jobs and nothing else.

    Args:
        jobs: JOBS.toml.
        out: the folder that the jobs' own are in; None: as JOBS.toml says.
        report: the folder that receives batch.html, which leads to the jobs' own reports, and batch.json; None: none.
        workers: processes on this machine; None: one a core.
        scheduler: the address of a Dask cluster that does the jobs instead.
        progress: called with what runs and the share that is done, 0 to 1.

    Returns:
        The summary, a row a job, and the status of the worst job.

    Raises:
        InputError: JOBS.toml, `workers` or the cluster is wrong; whatever is wrong with a job alone is in the summary.

    Example:
        >>> job = 'verb = "verify"\nprogram = "engraving.src"\ncell = "../cells/kr15_track_table"\n'
        >>> _ = Path("out/jobs.toml").write_text(f"[[job]]\n{job}", encoding="utf-8")
        >>> camrob.batch(Path("out/jobs.toml"), workers=1).ok
        True
    """
    start = time.perf_counter()
    if workers is not None and (workers < 1 or scheduler is not None):
        raise InputError(f"--workers {workers} makes no sense here", hint="give 1 or more, and no --scheduler")
    listed = read_jobs(Path(jobs), out)
    crew = workers or cores()
    view = _View(listed, progress)
    rows: dict[int, JobFigures] = {}

    def note(outcome: Outcome, attempts: int) -> None:
        rows[outcome.index] = _row(listed[outcome.index], outcome, attempts)
        view.ended(outcome)

    parcels = []
    for job in listed:
        try:
            parcels.append(pack_parcel(job))
        except (InputError, OSError) as error:
            note(Outcome(job.index, failure_status(error), failure_line(error), None, (), 0.0), 0)
    with tempfile.TemporaryDirectory(prefix="camrob-batch-", ignore_cleanup_errors=True) as folder:
        scratch = Path(folder)
        ordered = sorted(parcels, key=_size, reverse=True)  # the longest first, so that none is left over at the end
        if scheduler is None:
            run = run_local(ordered, workers=crew, scratch=scratch, tell=view.running)
        else:
            run = run_cluster(ordered, address=scheduler, scratch=scratch, tell=view.running)
        with closing(run) as ended:
            for outcome, made, attempts in ended:
                note(_published(listed[outcome.index], outcome, made), attempts)
    in_order = [rows[job.index] for job in listed]
    status = max(row.status for row in in_order)
    summary = BatchSummary(
        ok=status == DONE,
        status=status,
        counts={str(s): sum(row.status == s for row in in_order) for s in range(4)},
        workers=min(crew, len(listed)) if scheduler is None else None,
        scheduler=scheduler,
        jobs=tuple(in_order),
        seconds=round(time.perf_counter() - start, 3),
    )
    if report is not None:
        _write_report(Path(report), summary)
    return BatchResult(summary, status)


def _write_report(folder: Path, summary: BatchSummary) -> None:
    from camrob.report.batch.page import batch_report

    with staged_output(folder, name="batch") as staging:
        write_summary(staging / "batch.json", summary)
        (staging / "batch.html").write_text(batch_report(summary, folder), encoding="utf-8")


def _size(parcel: Parcel) -> int:
    """Bytes of the largest file that a job reads, its cell's aside: how long it takes, roughly."""
    cell = parcel.places.get("cell")
    within = cell.parts if isinstance(cell, Place) else ()
    return max((Path(f).stat().st_size for p, f in parcel.files if p.parts[: len(within)] != within), default=0)


def _published(job: BatchJob, outcome: Outcome, made: Path | None) -> Outcome:
    """Move a job's files to where they belong, all or none; the outcome, or why they could not be moved."""
    if job.out is None or made is None or not outcome.files:
        return outcome
    program = (outcome.summary or {}).get("program")
    main = {f"{program}{suffix}" for suffix in program_suffixes()} & set(outcome.files)
    try:
        with staged_output(job.out, name=program if main else None) as staging:
            for name in outcome.files:
                shutil.move(made / name, staging / name)
    except (InputError, OSError) as error:
        return replace(outcome, status=failure_status(error), error=failure_line(error), summary=None, files=())
    return outcome


def _row(job: BatchJob, outcome: Outcome, attempts: int) -> JobFigures:
    """How the summary tells of a job."""
    return JobFigures(
        index=job.index,
        verb=job.verb.name,
        input=job.label,
        out=None if job.out is None else str(job.out),
        status=outcome.status,
        error=outcome.error,
        files=outcome.files,
        attempts=attempts,
        seconds=outcome.seconds,
        summary=outcome.summary,
    )


@dataclass(slots=True)
class _View:
    """What a progress bar says of all jobs together."""

    jobs: Sequence[BatchJob]
    progress: Progress | None
    shares: dict[int, tuple[str, float]] = field(default_factory=dict)
    done: int = 0
    failed: int = 0

    def running(self, index: int, stage: str, share: float) -> None:
        """A job has come so far in one of its stages."""
        self.shares[index] = stage, share
        self._show()

    def ended(self, outcome: Outcome) -> None:
        """A job has ended."""
        self.shares.pop(outcome.index, None)
        self.done += 1
        self.failed += outcome.status != DONE
        self._show()

    def _show(self) -> None:
        if self.progress is None:
            return
        failed = f", {self.failed} not done" if self.failed else ""
        lines = [f"{self.done} of {len(self.jobs)} jobs done{failed}"]
        for index, (stage, share) in list(self.shares.items()):
            name = printable(Path(self.jobs[index].label).name)
            lines.append(f"  {name[:40]}: {stage} {min(max(share, 0.0), 1.0):.0%}")
        self.progress("\n".join(lines), self.done / len(self.jobs))
