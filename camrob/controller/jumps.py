"""Motions in which an axis would have to leap: far more than its top speed allows while the tool goes its way."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.cell.joint import Role
from camrob.controller.against import Coverage
from camrob.controller.replay import Replay
from camrob.findings import Finding, Severity
from camrob.program.motion import Motion
from camrob.program.program_text import ProgramText
from camrob.se3 import angle_between
from camrob.units import deg_to_rad

__all__ = ["axis_jumps"]

Array = NDArray[np.float64]

TIMES_TOP_SPEED = 10.0  # near singular postures a sound program asks for several times an axis's top speed
REVOLUTE_SLACK = 0.0873  # rad (5 degrees) that an axis may move whatever the motion's time
PRISMATIC_SLACK = 0.03  # m, likewise
_CHUNK = 50_000  # motions whose turns are worked out at a time
MOST_TURN = 3.32  # rad (190 degrees) that an external axis may turn within one motion: the short way is always less


def axis_jumps(
    program: ProgramText, replay: Replay, coverage: Coverage | None = None, feed: Array | None = None
) -> list[Finding]:
    """Leaps of the axes between neighbouring motions' ends, as errors, one an axis.

    A turn of more than half a circle of an external axis within one LIN or CIRC, anywhere; and, where `coverage` and `feed`
    ((N,) m/s, NaN in air) tell which motions cut, an axis that needs many times its top speed to keep the program's speed.
    """
    cell = replay.cell
    cp = np.flatnonzero(np.asarray(program.kind) >= Motion.LIN)
    cp = cp[cp > 0]
    q = np.asarray(replay.q)
    speeds = cell.limits_of("speed")
    prismatic = np.array([joint.prismatic for joint in cell.joints])
    slack = np.where(prismatic, PRISMATIC_SLACK, REVOLUTE_SLACK)
    inside, time = np.empty(0, np.int64), np.empty(0)
    if coverage is not None and feed is not None:
        cutting = np.zeros(len(program), np.bool_)
        cutting[coverage.motion[np.isfinite(feed) & (coverage.motion >= 0)]] = True
        inside = np.flatnonzero(cutting[cp])
        time = _time(program, replay, cp[inside])
    findings = []
    for i, joint in enumerate(cell.joints):
        if joint.role is Role.ROLL:
            continue
        step = np.abs(q[cp, i] - q[cp - 1, i])
        allowed = np.full(len(cp), MOST_TURN if joint.role is Role.WORKPIECE and not prismatic[i] else np.inf)
        allowed[inside] = np.minimum(allowed[inside], np.maximum(slack[i], TIMES_TOP_SPEED * speeds[i] * time))
        leaps = np.flatnonzero(step > allowed)
        if len(leaps):
            worst = leaps[np.argmax(step[leaps])]
            unit = joint.unit_word
            far, limit = joint.to_edge(float(step[worst])), joint.to_edge(float(allowed[worst]))
            text = f"{joint.name} leaps by {far:.1f} {unit} within one motion"
            findings.append(
                Finding(
                    "axis-jump",
                    text,
                    Severity.ERROR,
                    line=int(program.line[cp[leaps[0]]]),
                    point=int(cp[leaps[0]]),
                    axis=joint.name,
                    value=far,
                    limit=limit,
                    unit=unit,
                    count=len(leaps),
                )
            )
    return findings


def _time(program: ProgramText, replay: Replay, rows: NDArray[np.int64]) -> Array:
    """Seconds (K,) that motions take at the program's speed, or that the tool's turn takes at the cell's."""
    poses = np.asarray(replay.base_T_tool)
    length = np.linalg.norm(poses[rows, :3, 3] - poses[rows - 1, :3, 3], axis=1)
    turn = np.empty(len(rows))
    for start in range(0, len(rows), _CHUNK):
        here = rows[start : start + _CHUNK]
        turn[start : start + _CHUNK] = angle_between(poses[here - 1, :3, :3], poses[here, :3, :3])
    turning = float(deg_to_rad(replay.cell.controller.vel_ori_deg_s))
    speed = np.nan_to_num(np.asarray(program.speed)[rows])
    return np.asarray(np.maximum(length / np.maximum(speed, 1e-6), turn / turning))
