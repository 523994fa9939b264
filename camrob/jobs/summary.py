"""NAME.json: the summary of a post, as the contract fixes it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.check.collision_report import CollisionReport
from camrob.check.margins import MarginReport
from camrob.controller.against import Coverage
from camrob.controller.judge import Judgement
from camrob.issues import Finding, Severity
from camrob.jobs.inputs import JobInputs
from camrob.post.program import Program
from camrob.resolve.solution import Solution
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["post_summary"]

Array = NDArray[np.float64]


def post_summary(
    inputs: JobInputs,
    solution: Solution,
    program: Program,
    coverage: Coverage,
    judgement: Judgement,
    collisions: CollisionReport,
    margins: MarginReport,
    findings: Sequence[Finding],
    *,
    residual: tuple[Array, Array],
    times: Mapping[str, float | None],
    seconds: Mapping[str, float],
    files: Sequence[str],
) -> dict[str, Any]:
    """The JSON object of the contract (spec: camrob post)."""
    toolpath, path = inputs.toolpath, inputs.path
    own = path.of_toolpath
    inv_kf = np.asarray(solution.inv_kf)[own]
    clearance = collisions.clearance_min
    return {
        "program": program.name,
        "cell": inputs.cell.name,
        "method": solution.method,
        "source": {
            "file": toolpath.source,
            "sha256": toolpath.sha256,
            "dialect": toolpath.dialect,
            "units": toolpath.units,
        },
        "points": int(own.sum()),
        "regions": _regions(inputs, solution),
        "tracking": {
            "position_error_mm_max": m_to_mm(float(residual[0].max(initial=0.0))),
            "axis_error_deg_max": rad_to_deg(float(residual[1].max(initial=0.0))),
        },
        "conditioning": {
            "inv_kf_min": float(inv_kf.min()),
            "inv_kf_mean": float(inv_kf.mean()),
            "inv_kf_bound_mean": None,
        },
        "limits": {
            "margin_min": judgement.margin,
            "violations": sum(f.code == "axis-limit" for f in judgement.findings),
        },
        "singular": judgement.singular,
        "collisions": {
            "checked": collisions.checked,
            "count": collisions.count,
            "clearance_min_mm": None if clearance is None else m_to_mm(clearance),
            "clearance_pair": list(collisions.clearance_pair),
            "sampled": collisions.sampled,
            "skipped": list(collisions.skipped),
        },
        "external_travel": {key: round(value, 4) for key, value in margins.external_travel.items()},
        "time_s": dict(times),
        "verified": {
            "by": "the independent KRL reader and replay, and pytorch-kinematics",
            "position_error_mm_max": m_to_mm(float(coverage.position_error.max(initial=0.0))),
            "axis_error_deg_max": rad_to_deg(float(coverage.axis_error.max(initial=0.0))),
            "second_library_error_mm_max": m_to_mm(judgement.second_library_error),
            "second_library_poses": judgement.second_library_poses,
            "points": int(np.sum(coverage.motion >= 0)),
        },
        "warnings": [_warning(f) for f in findings if f.severity is not Severity.INFO],
        "notes": [_warning(f) for f in findings if f.severity is Severity.INFO],
        "files": list(files),
        "seconds": dict(seconds),
    }


def _regions(inputs: JobInputs, solution: Solution) -> list[dict[str, Any]]:
    path = inputs.path
    revisions = {r.region: r for r in solution.revisions}
    rows = []
    for index, region in enumerate(r for r in inputs.toolpath.regions if len(r)):
        inside = path.region == index
        revision = revisions.get(index)
        first = float(np.asarray(solution.inv_kf)[np.flatnonzero(inside)[0]])
        rows.append(
            {
                "index": index,
                "name": region.name,
                "first_line": region.first_line,
                "last_line": region.last_line,
                "points": len(region),
                "revised": bool(revision is not None and revision.kept),
                "inv_kf_before": first if revision is None else revision.inv_kf_before,
                "inv_kf_after": first if revision is None else revision.inv_kf_after,
                "inv_kf_min": float(np.asarray(solution.inv_kf)[inside].min()),
                "inv_kf_mean": float(np.asarray(solution.inv_kf)[inside].mean()),
            }
        )
    return rows


def _warning(finding: Finding) -> dict[str, Any]:
    out: dict[str, Any] = {"line": finding.line, "code": finding.code, "text": finding.text, "count": finding.count}
    if finding.axis:
        out["axis"] = finding.axis
    return out
