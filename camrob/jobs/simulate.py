"""`camrob simulate`: a program in, the log of the ideal controller out."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass, replace
from pathlib import Path

from camrob.controller.simulate import Approximation, Simulation
from camrob.controller.simulate import simulate as run
from camrob.errors import InputError
from camrob.findings import Finding, Severity, collapse
from camrob.jobs.files.cell_for import cell_for
from camrob.jobs.files.output import check_file_name, staged_output
from camrob.jobs.files.takes_paths import takes_paths
from camrob.jobs.solving.short_motions import block_figures
from camrob.languages import language_of_file
from camrob.measurement.log import MeasurementLog
from camrob.measurement.write_log import write_log
from camrob.progress import Progress, stage_of
from camrob.summaries.remarks import Approximated, Remark
from camrob.summaries.simulate_summary import LimitShares, LostByCause, SimulateSeconds, SimulateSummary
from camrob.units import m_to_mm, ms_to_s

__all__ = ["SimulateResult", "approximated", "simulate"]

_SUFFIXES = (".csv", ".parquet")
_TAKEN = ("cell", "setup")  # their .toml is something else than a log's
_CYCLES_MS = (0.5, 1000.0)
_AT_LIMIT = 0.999  # share of a limit that counts as reaching it


@dataclass(frozen=True, slots=True)
class SimulateResult:
    """The summary, the simulation behind it, and all findings."""

    summary: SimulateSummary
    simulation: Simulation
    findings: tuple[Finding, ...]


@takes_paths
def simulate(
    program: Path,
    *,
    cell: Path,
    out: Path,
    cycle_ms: float = 12.0,
    report: Path | None = None,
    progress: Progress | None = None,
) -> SimulateResult:
    """Run a program on the ideal controller; LOG.csv (or .parquet) and LOG.toml appear together or not at all.

    Args:
        program: the program's main file.
        cell: the cell's folder.
        out: the log to write; its suffix, .csv or .parquet, says how.
        cycle_ms: ms from row to row, 0.5 to 1000.
        report: a page to write, PAGE.html: the run to look at, and what holds it back.
        progress: called with a stage and the share of it that is done, 0 to 1.

    Returns:
        The summary, the simulation behind it (SI), and all findings.

    Raises:
        ProgramError, CellError, InputError: input that is wrong.
        UnreachableError: a program that can't be run.

    Example:
        >>> cell = Path("cells/kr15_track_table")
        >>> result = camrob.simulate(Path("out/engraving.src"), cell=cell, out=Path("out/log.csv"), cycle_ms=1000.0)
        >>> result.summary.rows == len(camrob.read_log(Path("out/log.csv")))
        True
    """
    start = time.perf_counter()
    _check(out, cycle_ms, report)
    language = language_of_file(program)
    machine = cell_for("simulate", cell)
    text = language.read(program, machine.controller_section)
    read = time.perf_counter()
    simulation = run(text, machine, cycle=ms_to_s(cycle_ms), progress=stage_of(progress, "simulate"))
    ready = time.perf_counter()
    with staged_output(out.parent) as folder:
        log = simulation.log
        info = replace(log.info, program=_beside(program, out.parent))
        write_log(MeasurementLog(log.columns, info), folder / out.name)
    done = time.perf_counter()
    findings = tuple(collapse([*text.findings, *simulation.findings]))
    summary = SimulateSummary(
        program=program.stem,
        cell=machine.name,
        files=(out.name, out.with_suffix(".toml").name, *(() if report is None else (report.name,))),
        motions=len(text),
        rows=len(log),
        cycle_ms=cycle_ms,
        duration_s=round(simulation.duration, 6),
        approximation=approximated(simulation.approximation),
        limits=_limits(simulation),
        feed=LostByCause(
            lost_s=round(simulation.feed_lost.seconds, 6),
            by_cause={k: round(v, 6) for k, v in simulation.feed_lost.by_cause.items()},
        ),
        blocks=block_figures(simulation.blocks),
        warnings=tuple(
            Remark(line=f.line, code=f.code, text=f.text, count=f.count)
            for f in findings
            if f.severity is not Severity.INFO
        ),
        seconds=SimulateSeconds(
            read=round(read - start, 3), simulate=round(ready - read, 3), write=round(done - ready, 3)
        ),
    )
    if report is not None:
        from camrob.jobs.solving.run_as_path import run_report

        with staged_output(report.parent) as folder:
            page = run_report(program.parent, text, machine, simulation, summary)
            (folder / report.name).write_text(page, encoding="utf-8")
    return SimulateResult(summary, simulation, findings)


def approximated(found: Approximation) -> Approximated:
    """How a summary tells of roundings."""
    return Approximated(corners=found.corners, deviation_mm_max=m_to_mm(found.deviation), line=found.line or None)


def _limits(simulation: Simulation) -> LimitShares:
    """The shares of its limits that each axis reaches, and the limits that were reached."""
    shares = {"speed": simulation.peak_speed, "acceleration": simulation.peak_acceleration}
    return LimitShares(
        speed_share_max={k: round(v, 4) for k, v in simulation.peak_speed.items()},
        acceleration_share_max={k: round(v, 4) for k, v in simulation.peak_acceleration.items()},
        reached=tuple(f"{axis} {what}" for what, of in shares.items() for axis, v in of.items() if v >= _AT_LIMIT),
    )


def _check(out: Path, cycle_ms: float, report: Path | None) -> None:
    """Raise InputError for a cycle or a file that can't be."""
    if not _CYCLES_MS[0] <= cycle_ms <= _CYCLES_MS[1]:
        raise InputError(
            f"--cycle-ms is {cycle_ms:g}", hint=f"use {_CYCLES_MS[0]:g} to {_CYCLES_MS[1]:g}, such as 12 or 4"
        )
    check_file_name(out.name)
    if out.suffix.lower() not in _SUFFIXES:
        raise InputError(f"--out {out.name!r} is not a log's name", hint="end it with .csv or .parquet", path=None)
    if out.stem.lower() in _TAKEN:
        raise InputError(f"--out {out.name!r} would replace {out.stem}.toml", hint="give the log another name")
    if report is not None:
        check_file_name(report.name)
        if report.suffix.lower() != ".html":
            raise InputError(f"--report {report.name!r} is not a page's name", hint="end it with .html", path=None)


def _beside(program: Path, folder: Path) -> str:
    """The program as seen from the log's folder, or its name alone where there is no way between them."""
    try:
        return Path(os.path.relpath(program.resolve(), folder.resolve())).as_posix()
    except ValueError:  # on another drive
        return program.name
