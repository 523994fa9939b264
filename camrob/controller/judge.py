"""The gate: may a program be released? Everything is judged from its text, as read back and replayed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.cell.joint import Role
from camrob.controller.against import Coverage
from camrob.controller.jumps import axis_jumps
from camrob.controller.replay import Replay
from camrob.findings import Finding, Severity, first_error
from camrob.kinematics.second_library import pinocchio_poses
from camrob.program.motion import Motion
from camrob.program.program_text import ProgramText
from camrob.text import short
from camrob.units import deg_to_rad, m_to_mm, mm_to_m

__all__ = ["Judgement", "judge"]

Array = NDArray[np.float64]

LIMIT_TOLERANCE = 1e-6  # rad, m: what rounding to 4 decimals of a degree can push an axis beyond its limit
CLOSE_TURN = deg_to_rad(2.0)  # to a limit while the tool is led: rounded corners and calibrated targets take some of it
CLOSE_SLIDE = mm_to_m(5.0)
SINGULAR_INV_KF = 0.01  # 1/k_F below which a posture counts as singular: errors come through a hundredfold
SINGULAR_BEND = 0.005  # |sin| of the wrist's bend below which axes 4 and 6 are one to the controller (0.3 degrees)
POSE_TOLERANCE = 1e-8  # m and rad between the program's poses and another library's forward kinematics of the postures
SPEED_TOLERANCE = 1e-3  # share by which a cutting speed may pass the feed; printing it rounds by less
SECOND_OPINIONS = 4000  # poses that go through the other library


@dataclass(frozen=True, slots=True)
class Judgement:
    """What stands against a program, and the figures beside it.

    second_library_error: m, the largest distance of the poses of the postures found, by Pinocchio, from the text.
    singular: motions that pass a singular posture. margin: per axis the least distance to a limit, degrees or mm.
    """

    findings: tuple[Finding, ...]
    second_library_error: float
    second_library_poses: int
    singular: int
    margin: dict[str, float | None]

    @property
    def good(self) -> bool:
        """True where nothing stands against the program."""
        return first_error(self.findings) is None


def judge(
    program: ProgramText, replay: Replay, coverage: Coverage | None = None, feed: Array | None = None
) -> Judgement:
    """Judge a replayed program; with `coverage`, against its CL points, with `feed` (N,), m/s (NaN in air), their speeds too."""
    findings = [*replay.findings, *(coverage.findings if coverage is not None else ())]
    findings += _limits(program, replay)
    findings += _close_to_limits(program, replay)
    findings += axis_jumps(program, replay, coverage, feed)
    singular = np.flatnonzero((replay.inv_kf < SINGULAR_INV_KF) | (replay.bend < SINGULAR_BEND))
    if len(singular):
        row = int(singular[0])
        text = "the arm passes a singular posture (its wrist is straight, or it is stretched)"
        value, limit = float(replay.inv_kf[row]), SINGULAR_INV_KF
        findings.append(_error(program, row, "singular", text, len(singular), value, limit=limit, unit="1/k_F"))
    error, count, row = _second_opinion(program, replay)
    if error > POSE_TOLERANCE:
        text = "another library's kinematics does not agree with the replay"
        value, limit = m_to_mm(error), m_to_mm(POSE_TOLERANCE)
        findings.append(_error(program, row, "second-library", text, 1, value, limit=limit, unit="mm"))
    if coverage is not None and feed is not None:
        findings += _speeds(program, coverage, feed)
        findings += _cuts_by_ptp(program, coverage, feed)
        findings += _table_turns(program, replay, coverage, feed)
    return Judgement(tuple(findings), error, count, len(singular), _margins(replay))


def _error(
    program: ProgramText,
    row: int,
    code: str,
    text: str,
    count: int,
    value: float | None = None,
    *,
    limit: float | None = None,
    unit: str = "",
) -> Finding:
    """What is wrong at the motion of a row, and at `count` in all."""
    line = int(program.line[row])
    return Finding(code, text, Severity.ERROR, line=line, point=row, value=value, limit=limit, unit=unit, count=count)


def _limits(program: ProgramText, replay: Replay) -> list[Finding]:
    """One finding an axis that passes its limit."""
    findings = []
    margin = np.asarray(replay.margin)
    for i, joint in enumerate(replay.cell.joints):
        beyond = np.flatnonzero(margin[:, i] < -LIMIT_TOLERANCE)
        if len(beyond):
            row = int(beyond[np.argmin(margin[beyond, i])])
            first = int(beyond[0])
            over = -joint.to_edge(float(margin[row, i]))
            text = f"{joint.name} passes its limit by up to {over:.4f} {joint.unit_word}"
            found = _error(program, first, "axis-limit", text, len(beyond), over, limit=0.0, unit=joint.unit_word)
            findings.append(replace(found, axis=joint.name))
    return findings


def _close_to_limits(program: ProgramText, replay: Replay) -> list[Finding]:
    """A warning an axis that comes close to its limit, and keeps it, on lines and arcs: where the controller rounds corners."""
    findings = []
    led = np.flatnonzero(np.asarray(program.kind) >= Motion.LIN)
    margin = np.asarray(replay.margin)[led]
    for i, joint in enumerate(replay.cell.joints):
        close = CLOSE_SLIDE if joint.prismatic else CLOSE_TURN
        near = np.flatnonzero(margin[:, i] < close)
        narrow = joint.upper - joint.lower < 4.0 * close  # such as an axis that is held
        if joint.endless or narrow or not len(near) or margin[near, i].min() < -LIMIT_TOLERANCE:
            continue
        worst = int(near[np.argmin(margin[near, i])])
        left = joint.to_edge(max(0.0, float(margin[worst, i])))
        text = (
            f"{joint.name} comes within {short(left)} {joint.unit_word} of its limit: with corners rounded or targets corrected "
            "the controller may stop there; place the part elsewhere (camrob place) or post with --method planned"
        )
        row, limit = int(led[worst]), joint.to_edge(close)
        found = _error(program, row, "axis-margin", text, len(near), left, limit=limit, unit=joint.unit_word)
        findings.append(replace(found, axis=joint.name, severity=Severity.WARNING))
    return findings


def _second_opinion(program: ProgramText, replay: Replay) -> tuple[float, int, int]:
    """Largest distance between text and Pinocchio's poses, over an even choice of rows: (m, rows, worst row)."""
    rows = np.flatnonzero((program.kind != Motion.PTP_AXES) & (program.kind != Motion.CIRC_VIA))
    if any(f.code in ("out-of-reach", "jump", "ptp-unreachable") for f in replay.findings):
        rows = rows[rows < min(f.point for f in replay.findings if f.point >= 0)]
    if len(rows) == 0:
        return 0.0, 0, 0
    rows = rows[np.unique(np.linspace(0, len(rows) - 1, SECOND_OPINIONS).astype(int))]
    poses = np.empty((len(rows), 4, 4))
    for k, cell in enumerate(replay.cells):
        here = np.asarray(replay.mounted)[rows] == k
        if here.any():
            poses[here] = pinocchio_poses(cell, np.asarray(replay.q)[rows[here]])
    targets = np.asarray(replay.base_T_tool)[rows]
    error = np.maximum(
        np.linalg.norm(poses[:, :3, 3] - targets[:, :3, 3], axis=1),
        np.abs(poses[:, :3, :3] - targets[:, :3, :3]).max(axis=(1, 2)),
    )
    worst = int(np.argmax(error))
    return float(error[worst]), len(rows), int(rows[worst])


def _speeds(program: ProgramText, coverage: Coverage, feed: Array) -> list[Finding]:
    """Cutting motions faster than the feed, or without a speed."""
    cut = np.flatnonzero(np.isfinite(feed) & (coverage.motion >= 0))
    speed = np.asarray(program.speed)[coverage.motion[cut]]
    linear = np.asarray(program.kind)[coverage.motion[cut]] >= Motion.LIN
    bad = np.flatnonzero(linear & ~((speed > 0.0) & (speed <= feed[cut] * (1.0 + SPEED_TOLERANCE) + 1e-6)))
    if not len(bad):
        return []
    row = int(coverage.motion[cut[bad[0]]])
    value = float(speed[bad[0]])
    text = "a motion is faster than the programmed feed, or has no speed"
    limit = float(feed[cut[bad[0]]])
    return [
        _error(program, row, "speed", text, len(bad), value if np.isfinite(value) else None, limit=limit, unit="m/s")
    ]


def _table_turns(program: ProgramText, replay: Replay, coverage: Coverage, feed: Array) -> list[Finding]:
    """Cutting motions in which the table turns although the controller's base doesn't follow it."""
    cell = replay.cell
    table = list(cell.indices(Role.WORKPIECE))
    if cell.base_follows_table or not table:
        return []
    moved = np.zeros(len(program), np.bool_)
    moved[1:] = np.any(np.abs(np.diff(np.asarray(replay.q)[:, table], axis=0)) > LIMIT_TOLERANCE, axis=1)
    rows = np.unique(coverage.motion[np.isfinite(feed) & (coverage.motion >= 0)])
    bad = rows[moved[rows]]
    if not len(bad):
        return []
    text = "the table turns while cutting, and this cell's base does not follow it"
    return [_error(program, int(bad[0]), "table-in-cut", text, len(bad))]


def _cuts_by_ptp(program: ProgramText, coverage: Coverage, feed: Array) -> list[Finding]:
    """An error where a PTP leads from one CL point to the next that is cut: nobody knows its way between. Retracts, from a
    point and back to it, are no way between.
    """
    ptp = np.asarray(program.kind) < Motion.LIN
    before = np.concatenate([[0], np.cumsum(ptp)])  # PTPs among the first k rows
    motion = coverage.motion
    cut = np.flatnonzero(coverage.joined & np.isfinite(feed) & (motion >= 0))
    cut = cut[(cut > 0) & (motion[cut - 1] >= 0)]
    bad = cut[before[motion[cut] + 1] > before[np.asarray(coverage.leaves)[cut - 1] + 1]]
    if not len(bad):
        return []
    text = "a PTP leads through a cut; only LIN and CIRC keep to the line"
    return [_error(program, int(motion[bad[0]]), "ptp-cuts", text, len(bad))]


def _margins(replay: Replay) -> dict[str, float | None]:
    """Least distance to a limit of every real axis, degrees or mm; None where it is endless."""
    least = np.asarray(replay.margin).min(axis=0)
    out: dict[str, float | None] = {}
    for name in replay.cell.axis_names:
        i = replay.cell.index(name)
        joint = replay.cell.joints[i]
        out[name] = None if joint.endless else joint.to_edge(float(least[i]))
    return out
