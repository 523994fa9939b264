"""`camrob post`: a CL file in, a verified program out."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.read_setup import read_clampings
from camrob.errors import InputError, JobError
from camrob.findings import Finding, Severity
from camrob.jobs import OldHome
from camrob.jobs.files.cell_for import cell_for, language_of
from camrob.jobs.files.inputs import program_name, read_inputs, setup_of
from camrob.jobs.files.output import demand_apart, demand_own_name, staged_output
from camrob.jobs.files.solved_path import save_solution
from camrob.jobs.files.summary_file import write_summary
from camrob.jobs.files.takes_paths import takes_paths
from camrob.jobs.release.attempt import Asked, Made, Order
from camrob.jobs.release.beside import manifest_of
from camrob.jobs.release.first_free import first_free
from camrob.jobs.release.price_bound import bound_finding, price_bound
from camrob.jobs.release.release import cause_first
from camrob.jobs.release.second_side import asking_for_clampings
from camrob.jobs.release.summary import post_summary
from camrob.jobs.release.upload import write_upload
from camrob.jobs.solving.device import check_device
from camrob.jobs.solving.resolved_job import check_method
from camrob.jobs.solving.sought import Sought, check_sought
from camrob.jobs.solving.watch import Watch
from camrob.program.language import Language
from camrob.program.process import plan_process
from camrob.program.program import Program
from camrob.progress import Progress
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.solution import Solution
from camrob.summaries.post_summary import ClampingFigures, PostSummary
from camrob.toolpath.rest import beginnings

__all__ = ["FEEDS", "PostResult", "post"]

Array = NDArray[np.float64]

FEEDS = ("program", "optimal")
_NAME = 24  # characters of a program's name that every controller takes


@dataclass(frozen=True, slots=True)
class PostResult:
    """What a post made: `files` in `out`, the JSON summary, all findings, and the data behind them.

    others: the further programs of a part that is worked from several sides.
    """

    summary: PostSummary
    findings: tuple[Finding, ...]
    out: Path
    files: tuple[str, ...]
    path: ToolPathInBase
    solution: Solution
    program: Program
    others: tuple[PostResult, ...] = ()


@takes_paths
def post(
    clfile: Path,
    *,
    cell: Path,
    out: Path,
    setup: Path | None = None,
    name: str | None = None,
    method: str = "vjm",
    feed: str = "program",
    max_lines: int | None = None,
    dialect: str | None = None,
    units: str | None = None,
    device: str = "cpu",
    for_accuracy: bool = False,
    then_compensated: bool = False,
    calibration: Path | None = None,
    diagnosis: Path | None = None,
    force: Path | None = None,
    seconds: float | None = None,
    prove: float | None = None,
    report: bool = True,
    progress: Progress | None = None,
) -> PostResult:
    """Post a CL file for a cell: the program, .json, .path.npz and .html appear in `out`, all or none.

    A part that its set-up has worked in several clampings ([[clamping]]) gets a program for each: NAME_CLAMPING, all or none.
    The program is read back from its text and replayed before it is released: every CL point met in order within 0.01 mm and
    0.01 degrees, within limits, away from singular postures and collisions.

    Args:
        clfile: the CL file, or 5-axis G-code.
        cell: the cell's folder.
        out: the folder to write into.
        setup: setup.toml; None: the one beside the CL file, where there is one.
        name: the program's name; None: after the CL file's.
        method: "vjm", the published method, or "planned".
        feed: "program", the CL file's, or "optimal".
        max_lines: lines of a program before it goes on in parts; None: as the cell says.
        dialect: of the CL file; None: it is recognised.
        units: "mm" or "inch", over the file's own.
        device: "cuda" scores the candidates of "planned" on a GPU; the plan is the same to float32's last digits.
        for_accuracy: a plan that makes the part's error small, as `calibration`, `diagnosis` and `force` let it be expected.
        then_compensated: that plan is for what `compensate` will leave.
        calibration: constants of the chain, by `calibrate` or `diagnose --calibration`.
        diagnosis: the folder of the diagnosis that wrote them: play, friction, doubt.
        force: FORCE.toml, what pushes on the tool while it cuts.
        seconds: how long "planned" betters its plan, and at least what it needs; the summary says what there was no time for.
        prove: seconds in which "planned" shows how far it is above the best plan that exists; NAME.proof.npz is the certificate.
        report: whether NAME.html is written.
        progress: called with a stage and the share of it that is done, 0 to 1.

    Returns:
        The summary, all findings, the files' names, and path, solution and program behind them (SI).

    Raises:
        InputError and its kin: input that is wrong.
        JobError and its kin: the job can't be done safely; nothing is left behind then.

    Example:
        >>> part, cell = Path("toolpaths/engraving/engraving.cls"), Path("cells/kr15_track_table")
        >>> result = camrob.post(part, cell=cell, out=Path("out"), report=False)
        >>> result.files, result.summary.points
        (('engraving.src', 'engraving.dat', 'engraving.json', 'engraving.path.npz'), 899)
    """
    clfile, out = Path(clfile), Path(out)
    _check_choices(method, feed, device, seconds, prove)
    asked = Asked(
        clfile=clfile,
        cell=Path(cell),
        setup=setup,
        name=name,
        method=method,
        feed=feed,
        max_lines=max_lines,
        dialect=dialect,
        units=units,
        device=device,
        seconds=seconds,
        prove=prove,
        report=report,
        known=Sought(cell, calibration, diagnosis, force, then_compensated),
        for_accuracy=for_accuracy,
    )
    with ExitStack() as staged:
        made = [
            _posted(asked, clamping, staged, out, Watch(progress))
            for clamping in read_clampings(setup_of(clfile, setup)) or (None,)
        ]
        demand_apart([name for one in made for name in one.files])
    return replace(made[0], others=tuple(made[1:]))


def _posted(asked: Asked, clamping: str | None, staged: ExitStack, out: Path, watch: Watch) -> PostResult:
    """One program, of all the file or of what it does in one clamping; it appears in `out` when `staged` is closed."""
    clfile, known = asked.clfile, asked.known
    with watch.stage("read"):
        machine = cell_for("post", asked.cell)
        plain = program_name(clfile, asked.name, language_of(machine))
        title = _title(asked, plain, clamping, language_of(machine), out)
        inputs = read_inputs(
            clfile,
            machine,
            asked.setup,
            dialect=asked.dialect,
            units=asked.units,
            clamping=clamping,
            progress=watch.share,
        )
        process = plan_process(inputs.toolpath.regions, inputs.cell)
        slowed = inputs.setup.tolerance is not None
        planned = asked.method == "planned"
        sought = check_sought(known, machine, asked=asked.for_accuracy, planned=planned, tolerance=slowed)
    folder = staged.enter_context(staged_output(out, name=title))
    order = Order(asked, title, process, sought, known if slowed else None)
    try:
        made = first_free(order, inputs, folder, watch)
    except JobError as error:
        raise asking_for_clampings(cause_first(error, inputs), inputs) from None
    programs = _with_entries(order, made, machine, folder, watch)
    files = [*programs, f"{title}.json", f"{title}.path.npz", *([f"{title}.html"] if asked.report else [])]
    _save_path(folder / f"{title}.path.npz", made)
    files += write_upload(folder, title, programs, language_of(machine), machine.controller)
    proved, certificate = None, folder / f"{title}.proof.npz"
    if asked.prove is not None:
        with watch.stage("prove"):
            proved = price_bound(made.inputs, made.solution, asked.cell, certificate, asked.prove, watch.share)
        made.findings.append(bound_finding(proved))
        files += [certificate.name] if certificate.exists() else []
    summary = post_summary(
        made.inputs, made.solution, title, made.back, made.collisions, made.margins, made.findings,
        residual=made.residual, feed=made.feed, process=process, files=files, verdict=made.verdict,
        manifest=manifest_of(folder, programs, asked.cell, clfile, inputs.setup.path, known.files()), proved=proved,
    )  # fmt: skip
    if asked.report:
        with watch.stage("report"):
            _report(folder / f"{title}.html", summary, made)
    sides = tuple(
        ClampingFigures(
            name=side.name,
            program=_clamping_name(plain, side.name, language_of(machine)),
            first_line=side.first,
            last_line=side.last,
        )
        for side in inputs.setup.clampings
    )
    summary = replace(summary, seconds=watch.seconds, clampings=sides)
    write_summary(folder / f"{title}.json", summary, indent=1)
    return PostResult(summary, tuple(made.findings), out, tuple(files), made.inputs.path, made.solution, made.program)


def _title(asked: Asked, plain: str, clamping: str | None, language: Language, out: Path) -> str:
    """The program's name, which in `out` is no other CL file's unless it was asked for. Raises InputError."""
    title = plain if clamping is None else _clamping_name(plain, clamping, language)
    if asked.name is None:
        demand_own_name(out, title, asked.clfile)
    return title


def _with_entries(order: Order, made: Made, machine: Cell, folder: Path, watch: Watch) -> list[str]:
    """The program's files and, where the cell asks for it, those of one for each operation behind the first, which does the
    rest of the job from there on: solved, written, read back and judged by itself, in a folder of its own till it is fit.
    """
    files = list(made.files)
    if not machine.controller.entries:
        return files
    for number, (line, operation) in enumerate(beginnings(made.inputs.toolpath), start=2):
        title = _entry_name(order.title, number, language_of(machine))
        inputs = read_inputs(
            order.asked.clfile,
            machine,
            made.inputs.setup.path,
            dialect=order.asked.dialect,
            units=order.asked.units,
            begin=line,
            clamping=made.inputs.setup.clamping or None,
        )
        process = plan_process(inputs.toolpath.regions, inputs.cell)
        own = folder / title
        own.mkdir()
        rest = first_free(replace(order, title=title, process=process, begin=line), inputs, own, watch)
        demand_apart([*files, *rest.files])
        for name in rest.files:
            (own / name).rename(folder / name)
        own.rmdir()
        text = f"{title} does the rest from operation {operation} on, line {line}"
        made.findings.append(Finding("entry", text, Severity.INFO, line))
        files += rest.files
    return files


def _clamping_name(title: str, clamping: str, language: Language) -> str:
    """The name of a clamping's program, with room for the number of an entry behind it: the clamping's stands whole."""
    ending = f"_{clamping}"
    return language.program_name(title[: _NAME - len(ending) - len("_E9999")] + ending)


def _entry_name(title: str, number: int, language: Language) -> str:
    """The name of an entry: its number stands whole, since one must not take another one's name."""
    ending = f"_E{number:02d}"
    return language.program_name(title[: _NAME - len(ending)] + ending)


def _check_choices(method: str, feed: str, device: str, seconds: float | None, prove: float | None) -> None:
    check_method(method)
    for option, given in (("--seconds", seconds), ("--prove", prove)):
        if given is not None and method != "planned":
            raise InputError(
                f"{option} {given:g} is for planned postures", hint="add --method planned, or leave it out"
            )
    if seconds is not None and not 0.0 <= seconds < np.inf:
        raise InputError(f"--seconds {seconds:g} is no time to plan in", hint="give seconds, 0 or more")
    if prove is not None and not 0.0 < prove < np.inf:
        raise InputError(f"--prove {prove:g} is no time to prove in", hint="give seconds, above 0")
    if feed not in FEEDS:
        raise InputError(f"--feed {feed!r} is unknown", hint=f"use {' or '.join(FEEDS)}")
    check_device(device)


def _save_path(file: Path, made: Made) -> None:
    """Write NAME.path.npz, without the points that a plan put in."""
    path, solution, cell = made.inputs.path, made.solution, made.inputs.cell
    own = path.of_toolpath
    save_solution(
        file,
        cell,
        np.asarray(solution.q)[own],
        line=path.line[own],
        region=path.region[own],
        inv_kf=np.asarray(solution.inv_kf)[own],
        length=path.length[own],
        **made.feed.arrays(cell, own),
    )


def _report(file: Path, summary: PostSummary, made: Made) -> None:
    from camrob.jobs.release.shown import map_shown, other_ways, run_shown, stock_shown
    from camrob.report.post.page import post_report

    inputs, solution, folder = made.inputs, made.solution, file.parent
    page = post_report(
        summary,
        inputs.cell,
        inputs.path,
        solution,
        findings=made.findings,
        run=run_shown(folder, made.back.text, made.back.coverage, inputs, solution, made.feed.at),
        stock=stock_shown(inputs, made.feed.at),
        redundancy=map_shown(inputs, solution),
        part_mesh=inputs.part,
        base_T_part=np.asarray(inputs.setup.base_T_part),
        comparison=other_ways(inputs, solution),
        bound=None if solution.plan is None else np.asarray(solution.plan.bound),
        reached=made.feed.reached(inputs.path),
        torques=(made.feed.sampled, made.feed.torques),
    )
    file.write_text(page, encoding="utf-8")


sys.modules[__name__].__class__ = OldHome
