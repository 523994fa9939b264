"""NAME.json: the summary of a post, as the contract fixes it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camrob.checks.collision_report import CollisionReport
from camrob.checks.margins import MarginReport
from camrob.findings import Finding, Severity
from camrob.jobs.files.inputs import JobInputs
from camrob.jobs.release.opinion import verified_by, witness_figures
from camrob.jobs.release.release import ReadBack
from camrob.jobs.solving.feed_outcome import FeedOutcome
from camrob.languages import language_named
from camrob.program.motion import AT_SPEED, Motion
from camrob.program.process import Process
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.plan_report import PlanAccuracy
from camrob.redundancy.solution import Solution
from camrob.summaries.post_summary import (
    AccuracyFigures,
    CollisionFigures,
    Conditioning,
    ExpectedErrorFigures,
    Manifest,
    PlanFigures,
    PlannedCut,
    PlanOnCurve,
    PostSummary,
    PriceBound,
    ProcessFigures,
    RegionFigures,
    Source,
    ToolChanged,
    Tracking,
    Verified,
)
from camrob.summaries.remarks import AxisLimits, Remark
from camrob.toolpath.region import EventKind
from camrob.units import m_s_to_mm_min, m_to_mm, rad_to_deg
from camrob.witness.judge import Verdict

__all__ = ["post_summary"]

Array = NDArray[np.float64]


def post_summary(
    inputs: JobInputs,
    solution: Solution,
    name: str,
    back: ReadBack,
    collisions: CollisionReport,
    margins: MarginReport,
    findings: Sequence[Finding],
    *,
    residual: tuple[Array, Array],
    feed: FeedOutcome,
    process: Process,
    files: Sequence[str],
    verdict: Verdict,
    manifest: Manifest,
    proved: PriceBound | None = None,
) -> PostSummary:
    """The summary of the contract (spec: camrob post), but for `seconds`."""
    toolpath = inputs.toolpath
    return PostSummary(
        program=name,
        cell=inputs.cell.name,
        method=solution.method,
        source=Source(file=toolpath.source, sha256=toolpath.sha256, dialect=toolpath.dialect, units=toolpath.units),
        points=int(inputs.path.of_toolpath.sum()),
        regions=tuple(_regions(inputs, solution)),
        tracking=Tracking(
            position_error_mm_max=m_to_mm(float(residual[0].max(initial=0.0))),
            axis_error_deg_max=rad_to_deg(float(residual[1].max(initial=0.0))),
        ),
        conditioning=_conditioning(inputs, solution),
        limits=AxisLimits(
            margin_min=back.judgement.margin,
            violations=sum(f.count for f in back.judgement.findings if f.code == "axis-limit"),
        ),
        singular=back.judgement.singular,
        collisions=_collisions(collisions),
        external_travel={key: round(value, 4) for key, value in margins.external_travel.items()},
        time_s=feed.times(),
        feed=replace(feed.figures(inputs.cell, inputs.path), fastest_cut_mm_min=_fastest_cut(inputs, back)),
        torques=feed.torque_figures(inputs.cell, inputs.path),
        process=_process(inputs, process),
        verified=_verified(back, verdict),
        witness=witness_figures(verdict),
        plan=_plan(inputs, solution, proved),
        warnings=tuple(_remark(f) for f in findings if f.severity is not Severity.INFO),
        notes=tuple(_remark(f) for f in findings if f.severity is Severity.INFO),
        files=tuple(files),
        manifest=manifest,
        clamping=inputs.setup.clamping,
    )


def _fastest_cut(inputs: JobInputs, back: ReadBack) -> float | None:
    """mm/min of the fastest line or arc to a point that the file comes to at a feed; None where none is faster."""
    path, text = inputs.path, back.text
    speed = np.where(np.asarray(text.kind) >= Motion.LIN, np.asarray(text.speed), 0.0)
    fastest = float(speed[np.asarray(back.coverage.motion)[path.cutting[path.of_toolpath]]].max(initial=0.0))
    return round(m_s_to_mm_min(fastest), 6) if fastest > 0.0 and bool((speed > AT_SPEED * fastest).any()) else None


def _conditioning(inputs: JobInputs, solution: Solution) -> Conditioning:
    own = inputs.path.of_toolpath
    inv_kf = np.asarray(solution.inv_kf)[own]
    bound = None if solution.plan is None else float(np.asarray(solution.plan.bound)[own].mean())
    return Conditioning(inv_kf_min=float(inv_kf.min()), inv_kf_mean=float(inv_kf.mean()), inv_kf_bound_mean=bound)


def _collisions(collisions: CollisionReport) -> CollisionFigures:
    clearance = collisions.clearance_min
    return CollisionFigures(
        checked=collisions.checked,
        count=collisions.count,
        clearance_min_mm=None if clearance is None else m_to_mm(clearance),
        clearance_pair=collisions.clearance_pair,
        sampled=collisions.sampled,
        skipped=collisions.skipped,
    )


def _verified(back: ReadBack, verdict: Verdict) -> Verified:
    coverage, judgement = back.coverage, back.judgement
    return Verified(
        by=verified_by(verdict, language_named(back.text.language)),
        position_error_mm_max=m_to_mm(float(coverage.position_error.max(initial=0.0))),
        axis_error_deg_max=rad_to_deg(float(coverage.axis_error.max(initial=0.0))),
        second_library_error_mm_max=m_to_mm(judgement.second_library_error),
        second_library_poses=judgement.second_library_poses,
        points=int(np.sum(coverage.motion >= 0)),
    )


def _process(inputs: JobInputs, process: Process) -> ProcessFigures:
    """What happens beside moving: counts of events, line, rev/min and sense of the spindle, changes of tools."""
    mounted = [*inputs.mounted[1:], *(None for change in process.changes[len(inputs.mounted) - 1 :])]
    return ProcessFigures(
        events_in_file=process.in_file,
        events_in_program=process.in_program,
        spindle=tuple((s.line, s.value, s.text) for s in process.steps if s.kind is EventKind.SPINDLE_ON),
        tool_changes=tuple(
            ToolChanged(line=c.line, number=c.number, name=c.name, tool="" if m is None else m.tool.name)
            for c, m in zip(process.changes, mounted, strict=True)
        ),
    )


def _plan(inputs: JobInputs, solution: Solution, proved: PriceBound | None) -> PlanFigures | None:
    """How a planned solution was chosen: the curve of conditioning against external travel, and the objective's terms."""
    plan, path = solution.plan, inputs.path
    if plan is None:
        return None
    return PlanFigures(
        mode=plan.mode,
        chosen=plan.chosen,
        rule=plan.rule,
        bound_mean=plan.bound_mean,
        bound_min=plan.bound_min,
        terms=plan.terms,
        shares=plan.shares,
        repostures=plan.repostures,
        retracts=plan.retracts,
        gap_percent=round(100.0 * plan.gap, 2),
        seconds=plan.seconds,
        missed=plan.missed,
        mended=plan.mended,
        cuts=tuple(
            PlannedCut(
                line=int(path.line[r.point]),
                region=r.region,
                inserted=bool(path.source[r.point] < 0 and path.region[r.point] >= 0),
                by="axes" if r.by_axes else "external axes, pose held",
                reason=r.reason,
            )
            for r in solution.revisions
            if r.kept
        ),
        curve=tuple(
            PlanOnCurve(
                name=point.name,
                inv_kf_mean=point.inv_kf_mean,
                inv_kf_min=point.inv_kf_min,
                share_of_bound=point.share,
                travel_si=point.travel,
                travel=_edge_travel(inputs, point.travel),
                error_mm=m_to_mm(point.error) if np.isfinite(point.error) else None,
            )
            for point in plan.curve
        ),
        accuracy=None if plan.accuracy is None else _accuracy(plan.accuracy),
        proved=proved,
    )


def _accuracy(plan: PlanAccuracy) -> AccuracyFigures:
    """What was gained for the part."""
    both = [
        ExpectedErrorFigures(rms_mm=m_to_mm(e.rms), p95_mm=m_to_mm(e.p95), turns=e.turns)
        for e in (plan.conditioning, plan.accuracy)
    ]
    return AccuracyFigures(
        conditioning=both[0],
        accuracy=both[1],
        taken=plan.taken,
        best_rms_mm=m_to_mm(plan.best),
        counted=plan.counted,
        left_out=plan.left_out,
    )


def _edge_travel(inputs: JobInputs, travel: Mapping[str, float]) -> dict[str, float]:
    """External travel by axis, mm or degrees, with the unit in the key."""
    joints = {j.name: j for j in inputs.cell.joints}
    return {f"{name}_{joints[name].unit}": round(joints[name].to_edge(v), 3) for name, v in travel.items()}


def _regions(inputs: JobInputs, solution: Solution) -> list[RegionFigures]:
    path = inputs.path
    revisions = {r.region: r for r in solution.revisions}
    rows = []
    for index, region in enumerate(r for r in inputs.toolpath.regions if len(r)):
        inside = path.region == index
        revision = revisions.get(index)
        if not inside.any():
            inside[_last_before(path, index)] = True
        first = float(np.asarray(solution.inv_kf)[np.flatnonzero(inside)[0]])
        rows.append(
            RegionFigures(
                index=index,
                name=region.name,
                first_line=region.first_line,
                last_line=region.last_line,
                points=len(region),
                revised=bool(revision is not None and revision.kept),
                inv_kf_before=first if revision is None else revision.inv_kf_before,
                inv_kf_after=first if revision is None else revision.inv_kf_after,
                inv_kf_min=float(np.asarray(solution.inv_kf)[inside].min()),
                inv_kf_mean=float(np.asarray(solution.inv_kf)[inside].mean()),
            )
        )
    return rows


def _last_before(path: ToolPathInBase, index: int) -> int:
    """Where the points of a region lie that all repeat the end of the one before it."""
    return int(np.flatnonzero(path.of_toolpath & (path.region < index))[-1])


def _remark(finding: Finding) -> Remark:
    return Remark(line=finding.line, code=finding.code, text=finding.text, count=finding.count, axis=finding.axis)
