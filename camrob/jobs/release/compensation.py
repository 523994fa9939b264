"""The figures of a compensation: errors before and after, corrections, limits, derivatives, and what was left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.calibration import ErrorSize
from camrob.calibration.compensate import Compensated, difference_sizes, pose_difference
from camrob.cell.cell import Cell
from camrob.controller.replay import Replay
from camrob.errors import SingularError
from camrob.findings import Finding
from camrob.jobs.closing.tool_chains import ToolChains, tool_poses
from camrob.program.motion import Motion
from camrob.program.program_text import ProgramText
from camrob.se3 import pose, slerp
from camrob.summaries.compensate_summary import (
    AxisCorrection,
    CalibrationUsed,
    CompensateSummary,
    Corrections,
    ErrorBetween,
    Iterations,
    MarginsBeforeAfter,
    NewViolation,
    OnDiagnosedMachine,
    PoseErrorSize,
    RateBeforeAfter,
    Violations,
)
from camrob.summaries.remarks import Remark
from camrob.timing.derivative_analysis import DerivativeAnalysis, analyse_derivatives, machine_length
from camrob.units import m_to_mm, rad_to_deg

__all__ = [
    "analyses_before_after",
    "compensation_summary",
    "error_between",
    "rates_and_violations",
]

Array = NDArray[np.float64]

_PRINTED = 2e-6  # m and rad: what rounding to 4 and 5 decimals may leave, seen from a far flange
_BETWEEN_MM = 0.02
_WORTH_MM = 5e-4  # less is printed as 0.000
_SLOWER = 0.9  # of the feed that the axes allow: less than that share of it is said
# a bound counts as newly passed from here on, or where it was passed before already, by so many times as much: linear
# interpolation makes peaks of rounding, whose heights say little
_NEW, _WORSE = 1.02, 1.25


def compensation_summary(
    text: ProgramText,
    withheld: ErrorSize | None,
    result: Compensated,
    correction: Array,
    planned: Replay,
    after: Array,
    *,
    kept: NDArray[np.bool_],
    source: str,
    calibration: CalibrationUsed | None,
    limits: MarginsBeforeAfter,
    between: ErrorBetween | None,
    rates: tuple[Mapping[str, RateBeforeAfter], Violations | None],
    findings: Sequence[Finding],
    machine: OnDiagnosedMachine | None,
) -> CompensateSummary:
    """What was done, in the units of the trade, but for the files and seconds.

    kept: (N,) motions whose targets stayed, which no error counts of. withheld: the calibration's error on withheld poses.
    correction (N, n): by how much the joints were moved, SI. source: the program's name. findings: what is said before what these
    figures say by themselves. machine: with a diagnosis only.
    """
    cell = planned.cell
    rows = np.asarray(text.kind) != Motion.CIRC_VIA
    rows = rows & ~kept if np.any(rows & ~kept) else rows
    moved = np.linalg.norm(
        (tool_poses(planned, np.asarray(result.q)) - np.asarray(planned.base_T_tool))[rows, :3, 3], axis=1
    )
    error_after = PoseErrorSize(**_sizes(after[rows]))
    said = [*findings, *_findings(error_after, between, *rates), *_not_covered(machine)]
    return CompensateSummary(
        program=text.name,
        cell=cell.name,
        motions=len(text),
        iterations=Iterations(mean=float(np.mean(result.iterations)), max=int(np.max(result.iterations))),
        error_before=PoseErrorSize(**_sizes(np.asarray(result.before)[rows])),
        error_after=error_after,
        correction=Corrections(
            mean_mm=m_to_mm(float(moved.mean())),
            max_mm=m_to_mm(float(moved.max())),
            axes=_axes(cell, correction[rows], np.asarray(text.line)[rows]),
        ),
        calibrated_withheld_mm=None if withheld is None else m_to_mm(withheld.mean),
        calibration=calibration,
        error_between=between,
        derivatives=rates[0],
        violations=rates[1],
        limits=limits,
        warnings=tuple(Remark(line=f.line, code=f.code, text=f.text) for f in said),
        source=source,
        files=(),
        seconds=0.0,
        machine=machine,
    )


def _sizes(errors: Array) -> dict[str, float]:
    """The fields of an error's size."""
    return {
        "mean_mm": m_to_mm(float(np.mean(errors[:, 0]))),
        "max_mm": m_to_mm(float(np.max(errors[:, 0]))),
        "mean_deg": rad_to_deg(float(np.mean(errors[:, 1]))),
        "max_deg": rad_to_deg(float(np.max(errors[:, 1]))),
    }


def _axes(cell: Cell, correction: Array, line: NDArray[np.int64]) -> dict[str, AxisCorrection]:
    """By how much each axis was moved; external ones stay as planned."""
    out: dict[str, AxisCorrection] = {}
    for name in cell.axis_names:
        size = np.abs(correction[:, cell.index(name)])
        joint = cell.joints[cell.index(name)]
        scaled = joint.to_edge(size)
        at = int(np.argmax(scaled))
        mean, most, worst = float(scaled.mean()), float(scaled[at]), int(line[at])
        out[name] = (
            AxisCorrection(mean_mm=mean, max_mm=most, line=worst)
            if joint.prismatic
            else AxisCorrection(mean_deg=mean, max_deg=most, line=worst)
        )
    return out


def error_between(chains: ToolChains, text: ProgramText, planned: Replay, replayed: Replay) -> ErrorBetween | None:
    """Errors half-way through the LINs, where nothing was corrected: long lines bend a little. None without a LIN."""
    rows = np.flatnonzero(np.asarray(text.kind) == Motion.LIN)
    rows = rows[rows > 0]
    if not len(rows):
        return None
    middles = [_middle(np.asarray(run.base_T_tool), rows) for run in (planned, replayed)]
    start = 0.5 * (np.asarray(replayed.q)[rows - 1] + np.asarray(replayed.q)[rows])
    try:
        q = np.asarray(
            ToolChains.of(None, planned.cells, planned.mounted).at(rows).met(start, middles[1], farthest=np.pi).q
        )
    except SingularError:
        return None  # the replay has looked at these motions; here only a figure is lost
    sizes = difference_sizes(pose_difference(middles[0], chains.at(rows).poses(q)))
    return ErrorBetween(**_sizes(sizes), worst_line=int(text.line[rows[int(np.argmax(sizes[:, 0]))]]))


def _middle(poses: Array, rows: NDArray[np.int64]) -> Array:
    """The poses half-way between the motions' ends."""
    a, b = poses[rows - 1], poses[rows]
    return pose(slerp(a[:, :3, :3], b[:, :3, :3], 0.5), 0.5 * (a[:, :3, 3] + b[:, :3, 3]))


def analyses_before_after(
    cell: Cell, text: ProgramText, planned: Array, compensated: Array
) -> tuple[DerivativeAnalysis, DerivativeAnalysis] | None:
    """The paper's section III before and after. None for a program of too few postures to differentiate."""
    line = np.asarray(text.line)
    try:
        return analyse_derivatives(cell, planned, line=line), analyse_derivatives(cell, compensated, line=line)
    except ValueError:
        return None


def rates_and_violations(
    analyses: tuple[DerivativeAnalysis, DerivativeAnalysis] | None, text: ProgramText, planned: Replay
) -> tuple[Mapping[str, RateBeforeAfter], Violations | None]:
    """The least rates in machine space that the axes' limits allow, before and after; and, at the program's own mean
    rate, which bounds are passed before and after. Empty and None where there is nothing to analyse or no speed.
    """
    if analyses is None:
        return {}, None
    before, after = analyses
    least = {
        name: RateBeforeAfter(before=float(np.min(b)), after=float(np.min(a)))
        for name, b, a in (
            ("speed", before.rate_speed, after.rate_speed),
            ("acceleration", before.rate_acceleration, after.rate_acceleration),
            ("jerk", before.rate_jerk, after.rate_jerk),
        )
    }
    rate = _own_rate(text, planned)
    if rate is None:
        return least, None
    worst = [_worst(a, rate) for a in analyses]
    new = tuple(
        NewViolation(axis=axis, quantity=quantity, line=line, times=use)
        for (axis, quantity), (use, line) in worst[1].items()
        if use > max(_NEW, _WORSE * worst[0].get((axis, quantity), (0.0, 0))[0])
    )
    counts = [len(a.violations(rate)) for a in analyses]
    return least, Violations(rate_rad_s=rate, before=counts[0], after=counts[1], new=new)


def _own_rate(text: ProgramText, planned: Replay) -> float | None:
    """ds/dt, rad/s, that the program's speeds make on the average; None where none is written."""
    step = np.linalg.norm(np.diff(np.asarray(planned.base_T_tool)[:, :3, 3], axis=0), axis=1)
    turned = np.diff(machine_length(planned.cell, np.asarray(planned.q)))
    speed = np.asarray(text.speed)[1:]
    timed = (np.asarray(text.kind)[1:] >= Motion.LIN) & (speed > 0.0)
    seconds = float(np.sum(step[timed] / speed[timed]))
    length = float(np.sum(turned[timed]))
    return length / seconds if seconds > 0.0 and length > 0.0 else None


def _worst(analysis: DerivativeAnalysis, rate: float) -> dict[tuple[str, str], tuple[float, int]]:
    """How far each axis uses each bound at a rate: times the bound, and the line."""
    out: dict[tuple[str, str], tuple[float, int]] = {}
    for v in analysis.violations(rate):
        key = (v.axis, v.quantity)
        if v.worst > out.get(key, (0.0, 0))[0]:
            out[key] = (float(v.worst), int(v.line))
    return out


def _findings(
    after: PoseErrorSize,
    between: ErrorBetween | None,
    derivatives: Mapping[str, RateBeforeAfter],
    violations: Violations | None,
) -> list[Finding]:
    """What a person should know of the result."""
    said = []
    for name, rates in derivatives.items():
        if rates.after < _SLOWER * rates.before:
            share = 100.0 * (1.0 - rates.after / rates.before)
            said.append(Finding("slower", f"the arm's {name} limits allow {share:.0f} % less than before somewhere"))
    for new in () if violations is None else violations.new:
        what = f"{new.axis} would pass its {new.quantity} limit at the program's speed, {new.times:.2f} times"
        said.append(Finding("new-violation", what, line=new.line, axis=new.axis))
    if after.max_mm > m_to_mm(_PRINTED):
        said.append(Finding("residual", f"{after.max_mm:.4f} mm remain at the worst point"))
    if between is not None and between.max_mm > _BETWEEN_MM:
        what = f"{between.max_mm:.3f} mm remain half-way through a LIN: divide long lines before compensating"
        said.append(Finding("between", what, line=between.worst_line))
    return said


def _not_covered(machine: OnDiagnosedMachine | None) -> list[Finding]:
    """What the program leaves as it is."""
    if machine is None:
        return [Finding("not-covered", "backlash, drift and what the calibration left unexplained are not corrected")]
    left = list(machine.not_reckoned)
    if machine.rest_mm > _WORTH_MM:
        left.append(f"what the diagnosis left unexplained ({machine.rest_mm:.3f} mm)")
    if not machine.causes:
        left.append("what is not a constant of the chain (on the machine as diagnosed that would not have helped)")
    return [Finding("not-covered", f"not corrected: {', '.join(left)}")] if left else []
