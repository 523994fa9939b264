"""`camrob compensate`: a program with which the calibrated robot meets the poses that another one asks for."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.calibrate.calibration import Calibration
from camrob.calibrate.calibration_file import read_calibration
from camrob.calibrate.compensate import Compensated, compensate_postures, pose_difference
from camrob.calibrate.error_model import ErrorModel
from camrob.cell.cell import Cell
from camrob.cell.read_cell import frame_of, read_cell
from camrob.controller.judge import Judgement, judge
from camrob.controller.replay import Replay, replay
from camrob.errors import InputError, KrlError, LimitError, SingularError, UnreachableError, VerificationError
from camrob.feed.derivative_analysis import analyse_derivatives
from camrob.issues import Finding, Severity
from camrob.jobs.files import staged_output
from camrob.kinematics.frames import base_T_tool, world_T_base
from camrob.post.krl_patch import NewTarget, literal_targets, patch_source
from camrob.post.krl_program import KrlFrameKind, KrlMotion, KrlProgram
from camrob.post.krl_reader import read_krl
from camrob.se3 import inverse, pose, slerp, xyzabc_from_frame
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["CompensateResult", "compensate"]

Array = NDArray[np.float64]

_PRINTED = 2e-6  # m and rad: what rounding to 4 and 5 decimals may leave, seen from a far flange
_BETWEEN_MM = 0.02
_SLOWER = 0.9  # of the feed that the axes allow: less than that share of it is said


@dataclass(frozen=True, slots=True)
class CompensateResult:
    """The summary as JSON; error_before, error_after (N, 2): m and rad at the motions' ends."""

    summary: Mapping[str, Any]
    error_before: Array
    error_after: Array


def compensate(
    program: Path,
    *,
    cell: Path,
    calibration: Path,
    out: Path,
    progress: Callable[[str, float], None] | None = None,
) -> CompensateResult:
    """Rewrite the targets of a program, everything else left byte for byte, and check the result by replay.

    Written are NAME.src, the parts and data lists that it needs, and NAME.json. Raises KrlError, LogError, CellError
    and StaleInputError for input; UnreachableError, SingularError and LimitError where a pose can't be met;
    VerificationError where the written program, read back, does not do it.
    """
    start = time.perf_counter()
    program, out = Path(program), Path(out)
    if out.is_dir() and out.resolve() == program.resolve().parent:
        raise InputError("is the program's own folder", cure="choose another --out: the original must stay", path=out)
    machine = read_cell(cell)
    found = read_calibration(calibration, machine)

    def tell(stage: str) -> Callable[[float], None]:
        return lambda done: progress(stage, done) if progress is not None else None

    text = read_krl(program)
    planned = replay(text, machine, progress=tell("replay"))
    judged = judge(text, planned)
    _followed(planned)
    model, values = found.model(planned.cell, in_base=True)
    targets = np.asarray(planned.base_T_tool)
    q = _postures(text, planned)
    result = _compensated(model, values, planned, q, text, tell("compensate"))
    sources, warnings = _patched(program.parent, text, planned, np.asarray(result.q))
    with staged_output(out, name=program.stem) as folder:
        _write(folder, program.parent, text, sources)
        again = read_krl(folder / program.name)
        replayed = replay(again, machine, progress=tell("check"))
        after = _checked(model, values, targets, replayed, again)
        judged_after = judge(again, replayed)
        _no_new_fault(judged, judged_after)
        summary = _summary(text, found, result, planned, replayed, after)
        summary["error_between"] = _between(model, values, text, planned, replayed)
        summary |= {
            "calibration": {"file": Path(calibration).name, "logs": [name for name, _ in found.logs]},
            "limits": {"margin_min": judged_after.margin},
            "warnings": [{"line": f.line, "code": f.code, "text": f.text} for f in (*warnings, *_said(summary))],
            "files": [*sorted(f.name for f in folder.iterdir()), f"{program.stem}.json"],
            "seconds": time.perf_counter() - start,
        }
        (folder / f"{program.stem}.json").write_text(json.dumps(summary, indent=2, allow_nan=False), encoding="utf-8")
    return CompensateResult(summary, np.asarray(result.before), after)


def _followed(planned: Replay) -> None:
    """The original can be replayed. Raises UnreachableError."""
    stopped = [f for f in planned.findings if f.severity is Severity.ERROR]
    if stopped:
        raise UnreachableError(f"the program can't be followed as it is: {stopped[0].text}", line=stopped[0].line)


def _postures(text: KrlProgram, planned: Replay) -> Array:
    """The motions' postures (N, n); at a CIRC's auxiliary point the other axes are half-way, the arm meets the point."""
    q = np.array(planned.q)
    via = np.flatnonzero(np.asarray(text.kind) == KrlMotion.CIRC_VIA)
    if len(via):
        half_way = 0.5 * (q[np.maximum(via - 1, 0)] + q[via + 1])
        nominal = ErrorModel.of(planned.cell, (), in_base=True)
        targets = np.asarray(planned.base_T_tool)[via]
        q[via] = compensate_postures(nominal, np.zeros(0), half_way, targets, farthest=np.pi).q
    return q


def _compensated(
    model: ErrorModel, values: Array, planned: Replay, q: Array, text: KrlProgram, progress: Callable[[float], None]
) -> Compensated:
    """Compensated postures within the axes' limits."""
    cell, targets = planned.cell, np.asarray(planned.base_T_tool)
    try:
        result = compensate_postures(model, values, q, targets, progress=progress)
    except SingularError as error:
        row = int(error.value or 0.0)
        what = "the pose can't be compensated: the arm is singular there"
        raise SingularError(what, line=int(text.line[row])) from None
    beyond = np.maximum(cell.q_lower - result.q, result.q - cell.q_upper)[:, cell.arm_slice]
    if beyond.max(initial=-1.0) > 0.0:
        row, axis = divmod(int(np.argmax(beyond)), beyond.shape[1])
        joint = cell.joints[cell.arm_slice.start + axis]
        value = float(joint.axis_value(result.q[row, cell.arm_slice.start + axis]))
        limit = min(joint.lower, joint.upper, key=lambda bound: abs(value - bound))
        raise LimitError(
            "the compensated program would pass an axis's limit", line=int(text.line[row]), axis=joint.name,
            value=rad_to_deg(value), limit=rad_to_deg(limit), unit="degrees",
        )  # fmt: skip
    return result


def _printed_poses(text: KrlProgram, cell: Cell, q: Array) -> Array:
    """X .. C (N, 6), mm and degrees in `$BASE`, of the nominal robot in postures q (N, n)."""
    offsets = [np.eye(4) if f.kind is KrlFrameKind.UNKNOWN else frame_of(np.asarray(f.xyzabc)) for f in text.bases] or [
        np.eye(4)
    ]
    krl_T_base = inverse(np.stack(offsets)[np.where(text.base >= 0, text.base, 0)])
    if cell.base_follows_table:
        numbers = xyzabc_from_frame(krl_T_base @ base_T_tool(cell, q))
    else:
        krl_T_world = krl_T_base  # frames: world is base
        numbers = xyzabc_from_frame(krl_T_world @ world_T_base(cell, q) @ base_T_tool(cell, q))
    return np.concatenate([m_to_mm(numbers[:, :3]), rad_to_deg(numbers[:, 3:])], axis=1)


def _patched(folder: Path, text: KrlProgram, planned: Replay, q: Array) -> tuple[dict[str, str], list[Finding]]:
    """The files' new texts (latin-1), and what was left as it is."""
    poses = _printed_poses(text, planned.cell, q)
    axes = planned.cell.to_axis_values(q)[:, :6]
    sources = {name: (folder / name).read_bytes().decode("latin-1") for name in text.files}
    lines = {name: source.splitlines() for name, source in sources.items()}
    wanted: dict[str, dict[int, list[NewTarget]]] = {name: {} for name in sources}
    warnings: list[Finding] = []
    row = 0
    while row < len(text):
        count = 2 if text.kind[row] == KrlMotion.CIRC_VIA else 1
        name, line = text.files[text.file[row]], int(text.line[row])
        by_axes = text.kind[row] == KrlMotion.PTP_AXES
        if by_axes and literal_targets(lines[name][line - 1]) == 0:
            warnings.append(Finding("left", "a PTP to a named posture is left as it is", line=line))
        else:
            table = axes if by_axes else poses
            new = [NewTarget(tuple(table[row + k].tolist()), bool(by_axes)) for k in range(count)]
            old = wanted[name].setdefault(line, new)
            if any(np.max(np.abs(np.subtract(a.values, b.values))) > 1e-6 for a, b in zip(old, new, strict=True)):
                what = "the motion runs several times and needs another correction each time"
                raise KrlError(what, cure="write the loop out", path=folder / name, line=line)
        row += count
    for name, source in sources.items():
        try:
            sources[name] = patch_source(source, wanted[name])
        except KrlError as error:
            raise error.at(folder / name) from None
    return sources, warnings


def _write(folder: Path, origin: Path, text: KrlProgram, sources: Mapping[str, str]) -> None:
    """The program's files; data lists go along unchanged."""
    for name, source in sources.items():
        (folder / name).write_bytes(source.encode("latin-1"))
    stems = {Path(name).stem.lower() for name in text.files}
    for file in origin.iterdir():
        if file.suffix.lower() == ".dat" and file.stem.lower() in stems and file.is_file():
            (folder / file.name).write_bytes(file.read_bytes())


def _checked(model: ErrorModel, values: Array, targets: Array, replayed: Replay, again: KrlProgram) -> Array:
    """Errors (N, 2) of the calibrated robot in the written program. Raises VerificationError where it strays."""
    if len(replayed.q) != len(targets) or any(f.severity is Severity.ERROR for f in replayed.findings):
        stopped = next((f for f in replayed.findings if f.severity is Severity.ERROR), None)
        what = stopped.text if stopped else "it holds another number of motions"
        raise VerificationError(
            f"the compensated program can't be followed: {what}", line=stopped.line if stopped else 0
        )
    e = pose_difference(targets, model.poses(values, np.asarray(replayed.q)))
    return np.stack([np.linalg.norm(e[:, :3], axis=1), np.linalg.norm(e[:, 3:], axis=1)], axis=1)


def _no_new_fault(before: Judgement, after: Judgement) -> None:
    """Nothing stands against the new program that did not stand against the old one. Raises VerificationError."""
    known = {(f.code, f.axis) for f in before.findings if f.severity is Severity.ERROR}
    for finding in after.findings:
        if finding.severity is Severity.ERROR and (finding.code, finding.axis) not in known:
            raise VerificationError(f"compensation would bring a new fault: {finding.text}", line=finding.line)


def _sizes(errors: Array) -> dict[str, float]:
    return {
        "mean_mm": m_to_mm(float(np.mean(errors[:, 0]))),
        "max_mm": m_to_mm(float(np.max(errors[:, 0]))),
        "mean_deg": rad_to_deg(float(np.mean(errors[:, 1]))),
        "max_deg": rad_to_deg(float(np.max(errors[:, 1]))),
    }


def _summary(
    text: KrlProgram, found: Calibration, result: Compensated, planned: Replay, replayed: Replay, after: Array
) -> dict[str, Any]:
    """What was done, in the units of the trade."""
    cell = planned.cell
    rows = ~np.isin(np.asarray(text.kind), (KrlMotion.CIRC_VIA,))
    moved = np.linalg.norm(
        (base_T_tool(cell, np.asarray(result.q)) - np.asarray(planned.base_T_tool))[rows, :3, 3], axis=1
    )
    return {
        "program": text.name,
        "cell": cell.name,
        "motions": len(text),
        "iterations": {"mean": float(np.mean(result.iterations)), "max": int(np.max(result.iterations))},
        "error_before": _sizes(np.asarray(result.before)[rows]),
        "error_after": _sizes(after[rows]),
        "correction": {"mean_mm": m_to_mm(float(moved.mean())), "max_mm": m_to_mm(float(moved.max()))},
        "calibrated_withheld_mm": next(
            (m_to_mm(size.mean) for stage, size in found.errors.items() if stage == "calibrated/withheld"), None
        ),
        "derivatives": _derivatives(cell, np.asarray(planned.q), np.asarray(replayed.q)),
    }


def _between(
    model: ErrorModel, values: Array, text: KrlProgram, planned: Replay, replayed: Replay
) -> dict[str, float] | None:
    """Errors half-way through the LINs, where nothing was corrected: long lines bend a little. None without a LIN."""
    rows = np.flatnonzero(np.asarray(text.kind) == KrlMotion.LIN)
    rows = rows[rows > 0]
    if not len(rows):
        return None
    middles = [_middle(np.asarray(run.base_T_tool), rows) for run in (planned, replayed)]
    start = 0.5 * (np.asarray(replayed.q)[rows - 1] + np.asarray(replayed.q)[rows])
    nominal = ErrorModel.of(planned.cell, (), in_base=True)
    try:
        q = np.asarray(compensate_postures(nominal, np.zeros(0), start, middles[1], farthest=np.pi).q)
    except SingularError:
        return None  # the replay has looked at these motions; here only a figure is lost
    e = pose_difference(middles[0], model.poses(values, q))
    sizes = np.stack([np.linalg.norm(e[:, :3], axis=1), np.linalg.norm(e[:, 3:], axis=1)], axis=1)
    return {**_sizes(sizes), "worst_line": int(text.line[rows[int(np.argmax(sizes[:, 0]))]])}


def _middle(poses: Array, rows: NDArray[np.int64]) -> Array:
    """The poses half-way between the motions' ends."""
    a, b = poses[rows - 1], poses[rows]
    return pose(slerp(a[:, :3, :3], b[:, :3, :3], 0.5), 0.5 * (a[:, :3, 3] + b[:, :3, 3]))


def _derivatives(cell: Cell, planned: Array, compensated: Array) -> dict[str, Any]:
    """The least rate in machine space that the axes' limits allow, before and after (the paper's section III).

    Empty for a program of too few postures to differentiate.
    """
    try:
        before, after = (analyse_derivatives(cell, q) for q in (planned, compensated))
    except ValueError:
        return {}
    return {
        name: {"before": float(np.min(b)), "after": float(np.min(a))}
        for name, b, a in (
            ("speed", before.rate_speed, after.rate_speed),
            ("acceleration", before.rate_acceleration, after.rate_acceleration),
            ("jerk", before.rate_jerk, after.rate_jerk),
        )
    }


def _said(summary: Mapping[str, Any]) -> list[Finding]:
    """What a person should know of the result."""
    said = []
    for name, rates in summary["derivatives"].items():
        if rates["after"] < _SLOWER * rates["before"]:
            share = 100.0 * (1.0 - rates["after"] / rates["before"])
            said.append(Finding("slower", f"the arm's {name} limits allow {share:.0f} % less than before somewhere"))
    if summary["error_after"]["max_mm"] > m_to_mm(_PRINTED):
        said.append(Finding("residual", f"{summary['error_after']['max_mm']:.4f} mm remain at the worst point"))
    between = summary["error_between"]
    if between is not None and between["max_mm"] > _BETWEEN_MM:
        what = f"{between['max_mm']:.3f} mm remain half-way through a LIN: divide long lines before compensating"
        said.append(Finding("between", what, line=between["worst_line"]))
    said.append(Finding("not-covered", "backlash, drift and what the calibration left unexplained are not corrected"))
    return said
