"""One solution of a job written into a staging folder, read back and judged, and what was ordered."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from camrob.checks.collision_report import CollisionReport
from camrob.checks.margins import MarginReport
from camrob.errors import CollisionError, ProgramError, VerificationError
from camrob.findings import Finding, Severity
from camrob.jobs.files.cell_for import language_of
from camrob.jobs.files.inputs import JobInputs, program_comment
from camrob.jobs.files.mounting import mounted_loads
from camrob.jobs.release.beside import SLOWER_BY_PLAN, SLOWER_BY_TOLERANCE
from camrob.jobs.release.opinion import hold_to_witness
from camrob.jobs.release.release import ReadBack, check_release, named_region, path_margins, read_back
from camrob.jobs.solving.feed_outcome import FeedOutcome, feed_outcome
from camrob.jobs.solving.feed_within import off_at_speed, tolerance_findings
from camrob.jobs.solving.resolved_job import Residual, ResolvedJob
from camrob.jobs.solving.short_motions import MotionEnds, block_findings
from camrob.jobs.solving.sought import Sought
from camrob.jobs.solving.watch import Watch
from camrob.program.arcs import without_arcs
from camrob.program.assemble import assemble_program
from camrob.program.decimate import decimated
from camrob.program.language import Language
from camrob.program.motion_ends import motion_ends
from camrob.program.process import Process
from camrob.program.program import Program
from camrob.redundancy.solution import Solution
from camrob.witness.judge import Verdict, judge

__all__ = ["Asked", "Made", "Order", "fit"]


@dataclass(frozen=True, slots=True)
class Asked:
    """What `post` was called with. known: what the error of the part may be expected by."""

    clfile: Path
    cell: Path
    setup: Path | None
    name: str | None
    method: str
    feed: str
    max_lines: int | None
    dialect: str | None
    units: str | None
    device: str
    seconds: float | None
    prove: float | None
    report: bool
    known: Sought
    for_accuracy: bool


@dataclass(frozen=True, slots=True)
class Order:
    """One program of what was asked for, by its title.

    sought: what plans for accuracy go by, held: what the feed is held to a tolerance by; else None. begin: the CL line of the
    operation from which on, 0: all of it.
    """

    asked: Asked
    title: str
    process: Process
    sought: Sought | None
    held: Sought | None
    begin: int = 0


@dataclass(frozen=True, slots=True)
class Made:
    """A program in the staging folder, fit for release."""

    inputs: JobInputs
    solution: Solution
    residual: Residual
    program: Program
    feed: FeedOutcome
    files: list[str]
    back: ReadBack
    collisions: CollisionReport
    margins: MarginReport
    findings: list[Finding]
    verdict: Verdict


def fit(order: Order, resolved: ResolvedJob, folder: Path, watch: Watch) -> Made:
    """`_made`, with a region's arcs written as lines where one of them is not fit: along an arc the external axes run straight to
    its end, and the arm makes up for what the solution had them do on the way.
    """
    said: list[Finding] = []
    while True:
        try:
            made = _made(order, resolved, folder, watch)
        except (CollisionError, VerificationError) as error:
            arms_own = bool(error.axis) or isinstance(error, CollisionError)  # and no fault of what was written
            toolpath = without_arcs(resolved.inputs.toolpath, error.line) if arms_own else None
            if toolpath is None:
                raise
            why = error.what.removeprefix("the program was not released: ").partition("; ")[0]
            text = f"the arcs of region {error.region} are written as lines: with arcs, {why}"
            said.append(Finding("arcs-as-lines", text, Severity.INFO, error.line))
            resolved = replace(resolved, inputs=replace(resolved.inputs, toolpath=toolpath))
            continue
        made.findings.extend(said)
        return made


def _made(order: Order, resolved: ResolvedJob, folder: Path, watch: Watch) -> Made:
    """Write a solution into the staging folder, read back, check; raises what stands against the release."""
    inputs, solution = resolved.inputs, resolved.solution
    language = language_of(inputs.cell)
    motions: MotionEnds = partial(motion_ends, inputs.toolpath, process=order.process)
    with watch.stage("feed"):
        keep = decimated(inputs.path, solution, inputs.setup.decimate)
        feed = feed_outcome(
            inputs,
            np.asarray(solution.q),
            optimal=order.asked.feed == "optimal",
            keep=keep,
            motions=motions,
            off=off_at_speed(order.held, inputs),
            progress=watch.share,
        )
        held = [] if order.held is None else tolerance_findings(feed.held, inputs.path)
        lost = feed.losses(inputs.cell, inputs.path)
        short = block_findings(inputs, solution, feed.blocks, lost, feed.times().program, motions)
        targets, postures, keep = feed.targets(inputs.path, solution, keep)
        program = assemble_program(
            order.title,
            inputs.cell,
            inputs.toolpath,
            targets,
            postures,
            process=order.process,
            cells=tuple(m.cell for m in inputs.mounted),
            loads=mounted_loads(inputs.mounted),
            rapid_speed=inputs.rapid_speed,
            keep=keep,
            speed=feed.speed,
            comment=program_comment(inputs, solution.method),
            language=language,
        )
    for old in folder.iterdir():
        old.unlink()
    with watch.stage("write"):
        files, written = _write(language, program, inputs, folder, order.asked.max_lines)
    main = folder / f"{order.title}{language.suffixes[0]}"
    with watch.stage("witness"):  # first, for it takes the most memory, and the program as it is read back stays
        verdict = _witnessed(order, inputs, feed, main)
    with watch.stage("verify"):
        back = read_back(main, program, inputs, solution, watch.share)
        if isinstance(verdict, ProgramError):  # unreadable to the witness alone
            raise verdict
        try:
            second = hold_to_witness(verdict, folder)
        except VerificationError as error:
            raise named_region(error, inputs) from None
    with watch.stage("collisions"):
        margins = path_margins(inputs, solution)
        collisions, findings = check_release(back, inputs, solution, margins, order.process, written, watch.share)
    said = [*second, *held, *short, *findings]
    return Made(inputs, solution, resolved.residual, program, feed, files, back, collisions, margins, said, verdict)


def _witnessed(order: Order, inputs: JobInputs, feed: FeedOutcome, main: Path) -> Verdict | ProgramError:
    """What the witness says of the written program `main`, or why it can't read it: reading back says that first."""
    try:
        return judge(
            main,
            order.asked.cell,
            clfile=order.asked.clfile,
            setup=inputs.setup.path,
            dialect=order.asked.dialect,
            units=order.asked.units,
            usual_rapid=True,
            slower_allowed=SLOWER_BY_PLAN
            if order.asked.feed == "optimal"
            else SLOWER_BY_TOLERANCE
            if feed.held
            else "",
            begin=order.begin,
            clamping=inputs.setup.clamping or None,
        )
    except ProgramError as unread:
        return unread


def _write(
    language: Language, program: Program, inputs: JobInputs, folder: Path, max_lines: int | None
) -> tuple[list[str], list[Finding]]:
    """The program's files, by name, and what a person should know of them."""
    names: list[str] = []
    findings: list[Finding] = []
    for file, data in language.write(program, inputs.cell.controller, max_lines=max_lines, findings=findings):
        (folder / file).write_bytes(data)
        names.append(file)
    return names, findings
