"""The gate: a program is released only if its text, read back and replayed, does what was meant."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.checks.collision_report import CollisionReport, joined_collisions
from camrob.checks.collisions import check_collisions
from camrob.checks.margins import MarginReport, check_margins, joined_margins
from camrob.controller.against import Coverage
from camrob.controller.cover_stretches import cover_stretches
from camrob.controller.intended import hold_to_intended
from camrob.controller.judge import Judgement, judge
from camrob.controller.replay import Replay, replay
from camrob.controller.trace import posture_trace
from camrob.errors import CollisionError, JobError, ProgramError, VerificationError
from camrob.findings import Finding, Severity, collapse, first_error
from camrob.jobs.files.cell_for import language_of
from camrob.jobs.files.inputs import JobInputs
from camrob.jobs.release.refusal import advice, but_to_plan, refusal, refusal_unread
from camrob.jobs.release.solved import hold_to_solution
from camrob.program.motion import Motion
from camrob.program.process import Process
from camrob.program.program import Program
from camrob.program.program_text import ProgramText
from camrob.progress import Share, part_of
from camrob.redundancy.solution import Solution
from camrob.units import m_to_mm

__all__ = [
    "ReadBack",
    "cause_first",
    "check_release",
    "cover_toolpath",
    "hold_to_tool",
    "named_region",
    "path_collisions",
    "path_margins",
    "read_back",
]

Array = NDArray[np.float64]

_CAUSES = (
    "path-in-inches",
    "part-in-metres",
    "part-off-table",
    "tool-in-metres",
    "tool-frame-in-metres",
    "tool-reversed",
    "stock-apart",
    "stock-too-large",
    "part-apart",
    "clearance-in-metres",
    "limit-unit",
    "part-in-table",
)  # of a refusal, often
TOOL_TOLERANCE = 1e-6  # m, and elements of the rotation: a frame is printed to 5 decimals, two hundred times finer


@dataclass(frozen=True, slots=True)
class ReadBack:
    """A program as its text tells it, replayed, held to the CL points, and judged."""

    text: ProgramText
    replayed: Replay
    coverage: Coverage
    judgement: Judgement


def cover_toolpath(text: ProgramText, replayed: Replay, inputs: JobInputs) -> tuple[Coverage, Array]:
    """How a program covers the job's CL points, and their feeds (N,), m/s, NaN in air."""
    path = inputs.path
    own = _rows(path.of_toolpath)
    coverage = cover_stretches(
        np.asarray(path.base_T_tip)[own],
        path.line[own],
        np.asarray(path.region[own], np.int64),
        np.asarray(path.stretch[own], np.int64),
        np.asarray(replayed.base_T_tool),
        np.asarray(text.kind),
        chord_tolerance=inputs.setup.decimate,
    )
    return coverage, np.where(path.cutting[own], path.feed[own], np.nan)


def _rows(mask: NDArray[np.bool_]) -> slice | NDArray[np.bool_]:
    """The same rows, as a slice where nothing lies between them: of a long path's poses that is no copy."""
    here = np.flatnonzero(mask)
    if len(here) and here[-1] - here[0] + 1 == len(here):
        return slice(int(here[0]), int(here[-1]) + 1)
    return mask


def hold_to_tool(replayed: Replay, inputs: JobInputs, coverage: Coverage | None = None) -> list[Finding]:
    """An error where the text's tool is not the set-up's tool: the arm would stand elsewhere, or the tip would.

    coverage: which motion meets each CL point; with it every stretch of the path is held to the tool that is mounted there.
    """
    off = 0.0
    own = np.asarray(inputs.path.stretch)[inputs.path.of_toolpath]
    for k, held in enumerate(inputs.mounted):
        cells = replayed.cells
        if coverage is not None:
            rows = np.asarray(coverage.motion)[own == k]
            cells = tuple(replayed.cells[i] for i in np.unique(np.asarray(replayed.mounted)[rows[rows >= 0]]))
        frames = [np.asarray(cell.flange_T_tool) for cell in cells]
        wanted = np.asarray(inputs.cell.flange_T_tool if k == 0 else held.cell.flange_T_tool)
        off = max([off, *(float(np.abs(frame - wanted).max()) for frame in frames)])
    if off <= TOOL_TOLERANCE:
        return []
    text = f"the program's tool frame is not the set-up's (they differ by {m_to_mm(off):.4f} mm or the like)"
    return [Finding("tool-differs", text, Severity.ERROR)]


def read_back(source: Path, program: Program, inputs: JobInputs, solution: Solution, progress: Share) -> ReadBack:
    """Read a written program back, replay it, and hold it to the CL points, to what was meant, and to what was solved.

    Raises VerificationError for the first thing that stands against it.
    """
    language = language_of(inputs.cell)
    try:
        text = language.read(source, inputs.cell.controller_section)
        replayed = replay(text, inputs.cell, progress=progress)
    except ProgramError as error:
        raise named_region(refusal_unread(error, source, program, language), inputs) from None
    coverage, feed = cover_toolpath(text, replayed, inputs)
    judgement = judge(text, replayed, coverage, feed)
    against = [*judgement.findings, *hold_to_tool(replayed, inputs, coverage)]
    against += hold_to_intended(text, replayed, program, language.meant(program, inputs.cell.controller))
    if first_error(against) is None:
        against += hold_to_solution(text, replayed, coverage, inputs.path, solution)
    if (first := first_error(against)) is not None:
        if first in coverage.findings:  # it has the CL line already
            region = int(inputs.path.region[inputs.path.of_toolpath][first.point])
            raise named_region(refusal(replace(first, region=region), program, None), inputs)
        raise named_region(refusal(first, program, text), inputs)
    return ReadBack(text, replayed, coverage, judgement)


def path_collisions(back: ReadBack, inputs: JobInputs, progress: Share) -> CollisionReport:
    """Collisions along the replayed program, void motions included; each stretch with its own tool. Findings have CL lines; their
    `point` is the program's motion.

    Raises VerificationError where the program doesn't leave the path between two tools, or a posture is left out.
    """
    postures, owner = posture_trace(back.text, back.replayed)
    line = np.zeros(len(back.text), np.int64)
    cutting = np.zeros(len(back.text), bool)
    region = np.full(len(back.text), -1, np.int64)
    own = inputs.path.of_toolpath
    met = back.coverage.motion
    line[met], cutting[met], region[met] = inputs.path.line[own], inputs.path.cutting[own], inputs.path.region[own]
    line[: int(met[0])] = line[int(met[0])]  # the way to the first point
    reports, motions = [], []
    borders = _borders(back, inputs)
    looked_at = np.zeros(len(owner), bool)
    for k, held in enumerate(inputs.mounted):
        here = (owner >= borders[k]) & (owner <= borders[k + 1])
        rows = owner[here]
        motions.append(rows)
        cell = back.replayed.cells[int(back.replayed.mounted[borders[k + 1]])]
        reports.append(
            check_collisions(
                cell,
                postures[here],
                cutting=cutting[rows],
                line=line[rows],
                region=region[rows],
                **inputs.bodies,
                tool=held.tool,
                progress=part_of(progress, k, len(inputs.mounted)),
            )
        )
        looked_at[np.flatnonzero(here)[: reports[-1].points]] = True
    if not looked_at.all():
        what = "the program was not released: collisions were not checked along all of it; report this file"
        raise VerificationError(what, line=int(line[owner[int(np.argmin(looked_at))]]))
    found = reports[0] if len(reports) == 1 else joined_collisions(reports)
    motion = np.concatenate(motions)
    return replace(found, findings=tuple(replace(f, point=int(motion[f.point])) for f in found.findings))


def _borders(back: ReadBack, inputs: JobInputs) -> list[int]:
    """The motions that lead to where tools are changed, with the program's first and last: the ends of its stretches."""
    stretch = np.asarray(inputs.path.stretch)[inputs.path.of_toolpath]
    met = np.asarray(back.coverage.motion)
    borders = [0]
    for k in np.flatnonzero(np.diff(stretch)).tolist():
        between = np.asarray(back.text.kind)[met[k] + 1 : met[k + 1]]
        ways = np.flatnonzero(between == Motion.PTP_AXES)
        if not len(ways):
            what = "the program was not released: it does not leave the path to change tools; report this file"
            raise VerificationError(what, line=int(inputs.path.line[inputs.path.of_toolpath][k + 1]))
        borders.append(int(met[k]) + 1 + int(ways[0]))
    return [*borders, len(back.text) - 1]


def path_margins(inputs: JobInputs, solution: Solution) -> MarginReport:
    """Margins, jumps and external travel of the solution itself."""
    path, q, inv_kf = inputs.path, np.asarray(solution.q), np.asarray(solution.inv_kf)
    stretches = path.stretches
    cells = [inputs.cell] if len(stretches) == 1 else [held.cell for held in inputs.mounted]
    reports = [
        check_margins(
            cell,
            q[here],
            inv_kf=inv_kf[here],
            cutting=path.cutting[here],
            line=path.line[here],
            region=path.region[here],
        )
        for cell, here in zip(cells, stretches, strict=True)
    ]
    return reports[0] if len(reports) == 1 else joined_margins(reports, [s.stop - s.start for s in stretches])


def check_release(
    back: ReadBack,
    inputs: JobInputs,
    solution: Solution,
    margins: MarginReport,
    process: Process,
    written: list[Finding],
    progress: Share,
) -> tuple[CollisionReport, list[Finding]]:
    """Collisions, and all findings of the job. Raises CollisionError or VerificationError where one stops the release."""
    collisions = path_collisions(back, inputs, progress)
    if (first := first_error(collisions.findings)) is not None:
        what = f"{first.text} ({collisions.count} points); {advice(first.code)}"  # no clearance lifts a cut
        raise named_region(CollisionError(what, line=first.line, region=_index(first)), inputs)
    close = _close_to_limits(back, inputs, planned=solution.method != "vjm")
    findings = collapse(
        [
            *process.urgent,
            *inputs.urgent,
            *inputs.toolpath.findings,
            *inputs.findings,
            *process.findings,
            *solution.findings,
            *(f for f in margins.findings if f.code != "axis-margin" or f.axis not in {c.axis for c in close}),
            *(f for f in back.judgement.findings if f.code != "axis-margin"),
            *close,
            *collisions.findings,
            *written,
        ]
    )
    if (stopped := first_error(findings)) is not None:
        error = VerificationError(
            f"{stopped.text}; {advice(stopped.code)}",
            line=stopped.line,
            region=_index(stopped),
            axis=stopped.axis,
            value=stopped.value,
            limit=stopped.limit,
            unit=stopped.unit,
        )
        raise named_region(error, inputs)
    return collisions, findings


def _close_to_limits(back: ReadBack, inputs: JobInputs, *, planned: bool) -> list[Finding]:
    """The gate's warnings of axes close to their limits, by lines of the CL file."""
    own = inputs.path.of_toolpath
    line, region = inputs.path.line[own], inputs.path.region[own]
    met = np.asarray(back.coverage.motion)
    out = []
    for f in back.judgement.findings:
        if f.code == "axis-margin":
            at = int(np.clip(np.searchsorted(met, f.point), 0, len(met) - 1))
            text = but_to_plan(f.text) if planned else f.text
            out.append(replace(f, text=text, line=int(line[at]), region=int(region[at]), point=-1))
    return out


def _index(finding: Finding) -> str:
    """The region of a finding for `named_region`."""
    return str(finding.region) if finding.region >= 0 else ""


def cause_first(error: JobError, inputs: JobInputs) -> JobError:
    """The same error with what its cause may be in front: what the reader has to look at before all symptoms."""
    found = sorted((f for f in inputs.urgent if f.code in _CAUSES), key=lambda f: _CAUSES.index(f.code))
    causes = [f.text for f in found]
    if not causes:
        return error
    what = error.what
    for text in causes:
        what = what.replace(f"; {text}", "")
    return error.but("; ".join([*causes, what]))


def named_region(error: JobError, inputs: JobInputs) -> JobError:
    """The same error with the region's name instead of its index, and what its cause may be."""
    regions = [r for r in inputs.toolpath.regions if len(r)]
    known = error.region.isdigit() and int(error.region) < len(regions)
    causes = [f.text for f in inputs.urgent if f.code in _CAUSES and f.text not in error.what]
    return error.but("; ".join([error.what, *causes]), region=regions[int(error.region)].name if known else None)
