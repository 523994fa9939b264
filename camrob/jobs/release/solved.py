"""Does the program, as its text tells it, run in the postures that were solved?"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.controller.against import Coverage
from camrob.controller.replay import Replay
from camrob.findings import Finding, Severity
from camrob.program.motion import Motion
from camrob.program.program_text import ProgramText
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.solution import Solution
from camrob.units import deg_to_rad, m_to_mm, mm_to_m

__all__ = ["POINT_ENDS_MM", "POSTURE_DEG", "POSTURE_MM", "hold_to_solution"]

Array = NDArray[np.float64]

# a motion ends at a CL point where it ends this near to it: twice what rounding can make of a point
POINT_ENDS_MM = 0.002
POSTURE_DEG = 0.05  # what rounding of a pose can move an axis by, near a straight wrist too
POSTURE_MM = 1e-3  # a printed E1 has four decimals
_CHUNK = 16_384  # points that are looked at at once: bounds the memory


def hold_to_solution(
    text: ProgramText, replay: Replay, coverage: Coverage, path: ToolPathInBase, solution: Solution
) -> list[Finding]:
    """Errors where a motion that ends at a CL point ends in another posture than the solver's, or is said twice.

    The text is held to the solver's own result, past whatever put the program together. Turns of an endless axis count.
    """
    cell = replay.cell
    own = np.flatnonzero(path.of_toolpath)
    row = np.asarray(coverage.motion)
    met = row >= 0
    own, row = own[met], row[met]
    apart = np.linalg.norm(np.asarray(replay.base_T_tool)[row, :3, 3] - np.asarray(path.base_T_tip)[own, :3, 3], axis=1)
    ends = m_to_mm(apart) <= POINT_ENDS_MM
    own, row = own[ends], row[ends]
    real = [j for j, joint in enumerate(cell.joints) if joint.role is not Role.ROLL]
    tolerance = np.array([_tolerance(cell, j) for j in real])

    def off(point: NDArray[np.int64], motion: NDArray[np.int64], q: Array) -> Array:
        """How far the joints of motions (M,) are from postures q of the points (M,) in tolerances, (M, K)."""
        return np.asarray(np.abs(np.asarray(replay.q)[motion][:, real] - q[point][:, real]) / tolerance)

    fits = np.zeros(len(own), np.bool_)  # what is no number is no posture either
    for start in range(0, len(own), _CHUNK):
        part = slice(start, start + _CHUNK)
        fits[part] = off(own[part], row[part], np.asarray(solution.q)).max(axis=1, initial=0.0) <= 1.0
    for revision in solution.revisions:
        if revision.kept:  # the point is reached in one posture and left in another: either counts
            at = np.flatnonzero(own == revision.point)
            fits[at] |= off(np.zeros_like(at), row[at], np.asarray(revision.q)).max(axis=1, initial=0.0) <= 1.0
    findings = []
    if not fits.all():
        k = int(np.argmin(fits))
        worst = int(np.argmax(off(own[k : k + 1], row[k : k + 1], np.asarray(solution.q))))
        joint = cell.joints[real[worst]]
        apart_by = float(np.abs(replay.q[row[k], real[worst]] - solution.q[own[k], real[worst]]))
        what = f"{joint.name} is not where it was solved to be, by {joint.to_edge(apart_by):.4f} {joint.unit_word}"
        findings.append(Finding("not-as-solved", what, Severity.ERROR, line=int(text.line[row[k]]), axis=joint.name))
    return findings + _said_twice(text)


def _tolerance(cell: Cell, joint: int) -> float:
    return mm_to_m(POSTURE_MM) if cell.joints[joint].prismatic else deg_to_rad(POSTURE_DEG)


def _said_twice(text: ProgramText) -> list[Finding]:
    """An error where two LINs in a row lead to the same target: approximation would stop there, and the tool dwell."""
    lin = np.asarray(text.kind) == Motion.LIN
    same = [np.all(target[1:] == target[:-1], axis=1) for target in (np.asarray(text.pose), np.asarray(text.external))]
    again = np.flatnonzero(lin[1:] & lin[:-1] & same[0] & same[1]) + 1
    if not len(again):
        return []
    return [
        Finding(
            "said-twice",
            "a motion leads to where the one before it ended",
            Severity.ERROR,
            line=int(text.line[again[0]]),
            point=int(again[0]),
            count=len(again),
        )
    ]
