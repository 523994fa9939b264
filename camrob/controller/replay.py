"""Replay of a program: every motion as the controller interpolates it, through the inverse of the arm alone.

Nothing of the solver takes part: the program's text is all that is known. What the replay finds (out of reach, limits,
singular postures, jumps) is judged by `judge`; the poses of the postures found are held to the text by forward kinematics
of another library (Pinocchio).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.status_turn import StatusTurn
from camrob.controller.replay_kernel import CODES, ReplayArm, ReplayRun, replay_run
from camrob.errors import ProgramError, UnreachableError
from camrob.findings import Finding, Severity, first_error
from camrob.frozen import locked, sealed
from camrob.kinematics.arm import Arm
from camrob.kinematics.frames import base_T_tool, world_T_base
from camrob.kinematics.kernels import chain_arrays
from camrob.program.axis_turns import turn_fits, turn_text
from camrob.program.motion import Motion
from camrob.program.program_text import FrameKind, ProgramText
from camrob.progress import Share
from camrob.se3 import abc_to_rotation, frame_from_mm_deg, inverse, pose
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["Replay", "base_offsets", "base_poses", "constant_transforms", "program_cell", "program_cells", "replay"]

Array = NDArray[np.float64]

_CHUNK = 16_384  # motions that are worked on at once: bounds the memory
SAMPLE_LENGTH = 0.005  # m between samples of a motion
SAMPLE_ANGLE = 0.0175  # rad, of the tool or a table
SAMPLES = 2.0  # a motion at the least: its middle and its end
JUMP = 0.35  # rad that a joint may move between two samples; more is a flip


@dataclass(frozen=True, slots=True)
class Replay:
    """What a program makes the cell do, a row a motion of the program.

    q: (N, n) postures at the motions' ends (roll 0). base_T_tool: (N, 4, 4) programmed poses in `base` (of a PTP by
    axes: where it ends). inv_kf, bend, jump: (N,) least 1/k_F, least |sin| of the wrist's bend and farthest joint step (rad)
    within each motion, inf and 0 for PTP. margin: (N, n) least distance to a limit within each motion, SI, negative
    beyond. samples: postures that were looked at. cell: the cell with the program's tool, the first one where it sets several;
    others: the cell with each further one; mounted: (N,) with which of them, `cell` being 0, each motion is made.
    """

    q: Array
    base_T_tool: Array
    inv_kf: Array
    bend: Array
    jump: Array
    margin: Array
    samples: int
    cell: Cell
    findings: tuple[Finding, ...] = ()
    others: tuple[Cell, ...] = ()
    mounted: NDArray[np.int32] = field(default_factory=lambda: np.zeros(0, np.int32))

    def __post_init__(self) -> None:
        for name in ("q", "base_T_tool", "inv_kf", "bend", "jump", "margin"):
            object.__setattr__(self, name, locked(getattr(self, name), name=name))
        mounted = np.zeros(len(self.q), np.int32) if not len(self.mounted) else self.mounted
        object.__setattr__(self, "mounted", locked(mounted, shape=(len(self.q),), dtype=np.int32, name="mounted"))

    @property
    def cells(self) -> tuple[Cell, ...]:
        """The cell with each of the program's tools, as `mounted` counts them."""
        return (self.cell, *self.others)

    def demand_followed(self) -> None:
        """Raise UnreachableError where the replay could not follow the program."""
        if (finding := first_error(self.findings)) is not None:
            raise UnreachableError(finding.text, line=finding.line, of_program=True)

    def one_tool(self, program: ProgramText) -> Cell:
        """The cell with the program's only tool. Raises ProgramError where it sets several."""
        if self.others:
            raise _several_tools(program)
        return self.cell


def _several_tools(program: ProgramText) -> ProgramError:
    hint = "post the operations of each tool from a CL file of their own, and give those programs one by one"
    return ProgramError("sets more than one tool frame", hint=hint, path=program.files[0])


def program_cell(program: ProgramText, cell: Cell) -> tuple[Cell, list[Finding]]:
    """The cell with the tool that the program sets. Raises ProgramError where it sets several."""
    cells, _mounted, findings = program_cells(program, cell)
    if len(cells) > 1:
        raise _several_tools(program)
    return cells[0], findings


def program_cells(program: ProgramText, cell: Cell) -> tuple[tuple[Cell, ...], NDArray[np.int32], list[Finding]]:
    """The cell with each tool that the program moves with, which of them each motion (N,) is made with, and findings.

    A PTP to axis values moves with whatever is mounted, and counts as made with the first tool where none has been set.
    """
    known = [frame.kind is not FrameKind.UNKNOWN for frame in program.tools]
    posed = set(program.tool[program.kind != Motion.PTP_AXES].tolist())
    used = [int(i) for i in dict.fromkeys(program.tool.tolist()) if known[int(i)] and int(i) in posed]
    findings = []
    if any(not known[int(i)] for i in posed) or not used:
        own = "the cell's own" if not used else "the first that it sets"
        findings.append(Finding("tool-unknown", f"the program does not say its tool's frame; {own} is taken"))
    if not used:
        return (cell,), np.zeros(len(program), np.int32), findings
    frames = [tuple(np.asarray(program.tools[i].xyzabc).tolist()) for i in used]
    different = list(dict.fromkeys(frames))
    index = np.zeros(len(program.tools), np.int32)
    index[used] = [different.index(frame) for frame in frames]
    cells = tuple(cell.with_tool(frame_from_mm_deg(np.array(frame))) for frame in different)
    return cells, np.asarray(index[program.tool]), findings


def base_poses(program: ProgramText, cell: Cell, q_external: Array) -> tuple[Array, list[Finding]]:
    """Poses (N, 4, 4) in `base` of the program's targets (NaN where a target is axes).

    q_external: (N, n) postures of which the external axes matter. Where the cell's base follows the table, poses are read in
    the turning base, the program's base being an offset in it; else that stands in `world`.
    """
    findings = []
    if not program.bases or any(f.kind is FrameKind.UNKNOWN for f in program.bases):
        findings.append(Finding("base-unknown", "the program does not say its base frame; the cell's base is taken"))
    known = _known_bases(program, cell)
    poses = np.empty((len(program), 4, 4))
    for start in range(0, len(program), _CHUNK):
        rows = slice(start, start + _CHUNK)
        program_T_tool = pose(
            abc_to_rotation(deg_to_rad(np.asarray(program.pose[rows, 3:]))), mm_to_m(np.asarray(program.pose[rows, :3]))
        )
        found = known[np.maximum(program.base[rows], 0)] @ program_T_tool
        if not cell.base_follows_table:
            found = inverse(np.asarray(world_T_base(cell, q_external[rows]))) @ found
        poses[rows] = found
    return poses, findings


def base_offsets(program: ProgramText, cell: Cell) -> Array:
    """(N, 4, 4) the program's base at each motion, in the cell's `base`, or `world` where it stands; the own where unsaid."""
    return np.asarray(_known_bases(program, cell)[np.maximum(program.base, 0)])


def _known_bases(program: ProgramText, cell: Cell) -> Array:
    """(K, 4, 4) the program's bases, the cell's own for those that it doesn't say; one at the least."""
    base_T_controller = inverse(cell.controller_T_base)
    frames = [np.eye(4)]
    if program.bases:
        known = [(f.kind is not FrameKind.UNKNOWN, np.asarray(f.xyzabc)) for f in program.bases]
        frames = [base_T_controller @ frame_from_mm_deg(xyzabc) if said else np.eye(4) for said, xyzabc in known]
    return np.stack(frames)


def replay(program: ProgramText, cell: Cell, *, progress: Share | None = None) -> Replay:
    """Replay a program on a cell.

    Stops at the first motion that can't be followed; the finding (code "out-of-reach", "jump" or "ptp-unreachable") says
    where, and the rows behind it repeat the last posture.

    Args:
        program: as its own text says it.
        cell: the machine.
        progress: called with the share that is done, 0 to 1.

    Returns:
        Postures, a row a motion, and findings.

    Raises:
        ProgramError: a program whose axes are not the cell's.

    Example:
        >>> cell = camrob.read_cell(Path("cells/kr15_track_table"))
        >>> done = camrob.replay(camrob.read_program(Path("out/engraving.src")), cell)
        >>> done.findings, done.q.shape[1] == len(cell)
        ((), True)
    """
    _check_axes(program, cell)
    cells, mounted, findings = program_cells(program, cell)
    run = _Run(program, cells[0])
    findings += run.findings
    starts = [*np.flatnonzero(_is_ptp(program)).tolist(), len(program)]
    if starts[0] > 0:
        findings.append(
            Finding("no-entry", "the program begins with LIN; HOME's branch is taken", line=int(program.line[0]))
        )
        run.mount(cells, mounted, 0, starts[0])
        findings += run.continuous(0, starts[0])
    for begin, stop in pairwise(starts):
        if run.failed:
            break
        run.mount(cells, mounted, begin, stop)
        findings += run.point_to_point(begin)
        if not run.failed:
            findings += run.continuous(begin + 1, stop)
        if progress is not None:
            progress(stop / len(program))
    return run.result(tuple(findings), cells, mounted)


def _is_ptp(program: ProgramText) -> NDArray[np.bool_]:
    return np.asarray((program.kind == Motion.PTP_AXES) | (program.kind == Motion.PTP_POSE))


def _check_axes(program: ProgramText, cell: Cell) -> None:
    if len(program) == 0:
        raise ProgramError(
            "holds no motion whose target stands in it",
            hint="give the main program, and its data",
            path=program.files[0],
        )
    strange = [n for n in program.external_names if n not in cell.external_names]
    if strange and np.any(
        np.nan_to_num(np.asarray(program.external)[:, [program.external_names.index(n) for n in strange]])
    ):
        raise ProgramError(
            f"moves {', '.join(strange)}, which cell {cell.name} lacks", hint="give its cell", path=program.files[0]
        )


def constant_transforms(cell: Cell, count: int) -> Array:
    """Constant transforms (count + 1, 4, 4) before, between and behind the chain's first joints."""
    fixed = [np.asarray(cell.base_T_first)]
    for joint in cell.joints[:count]:
        fixed[-1] = fixed[-1] @ joint.before
        fixed.append(np.asarray(joint.after))
    return np.stack(fixed)


class _Run:
    """The state of a replay on its way through a program."""

    def __init__(self, program: ProgramText, cell: Cell) -> None:
        self.program = program
        self._take(cell)
        N, n = len(program), len(cell)
        externals = np.zeros((N, len(cell.external_names)))
        for k, name in enumerate(cell.external_names):
            if name in program.external_names:
                externals[:, k] = np.nan_to_num(np.asarray(program.external)[:, program.external_names.index(name)])
        self.q = cell.to_q(np.concatenate([np.nan_to_num(np.asarray(program.axes)), externals], axis=1))
        self.targets, self.findings = base_poses(program, cell, self.q)
        self.posture = cell.to_q(cell.to_axis_values(cell.q_home))
        self.margin = np.full((N, n), np.inf)
        self.inv_kf, self.bend, self.jump = np.full(N, np.inf), np.full(N, np.inf), np.zeros(N)
        self.samples = 0
        self.failed = False

    def _take(self, cell: Cell) -> None:
        """Go on with the tool of a cell."""
        self.cell = cell
        self.arm = Arm.of(cell)
        self.status_turn = StatusTurn.of(cell) if self.arm.closed is not None else None
        chain = chain_arrays(cell)
        self.kernel = ReplayArm(
            chain, constant_transforms(cell, cell.arm_slice.start), *self.arm.kernel(), cell.q_lower, cell.q_upper
        )

    def mount(self, cells: tuple[Cell, ...], mounted: NDArray[np.int32], begin: int, stop: int) -> None:
        """Take the tool of motions begin .. stop. Raises ProgramError where a LIN or CIRC among them is made with another one.

        Such a motion would begin where the new tool's tip stands, which none of its targets says.
        """
        change = np.flatnonzero(mounted[begin:stop] != mounted[begin])
        if len(change):
            line = int(self.program.line[begin + int(change[0])])
            raise ProgramError(
                "sets more than one tool frame, this one before a LIN or CIRC",
                hint="begin with a PTP behind each change",
                path=self.program.files[0],
                line=line,
            )
        if cells[mounted[begin]] is not self.cell:
            self._take(cells[mounted[begin]])

    def point_to_point(self, row: int) -> list[Finding]:
        """Go to a PTP's target."""
        program, cell, part = self.program, self.cell, self.cell.arm_slice
        if program.kind[row] == Motion.PTP_POSE:
            foot_T_tool = self.arm.foot_T_tool(self.targets[row], self.q[row])
            choices = self._choices(foot_T_tool, row)
            if not choices:
                self._stop(row)
                branch = turn_text(program.turning, int(program.status[row]), int(program.turn[row]))
                status = f" with {branch}" if program.status[row] >= 0 else ""
                reasons = (
                    ", ".join(self.arm.reasons(foot_T_tool, self.posture[part])) or "no branch has this Status and Turn"
                )
                return [self._error("ptp-unreachable", f"the PTP's target can't be reached{status}: {reasons}", row)]
            self.q[row, part] = choices[0]
        else:
            self.targets[row] = base_T_tool(cell, self.q[row])
        self.posture = self.q[row].copy()
        self.margin[row] = np.minimum(self.posture - cell.q_lower, cell.q_upper - self.posture)
        return []

    def _choices(self, foot_T_tool: Array, row: int) -> list[Array]:
        """Arm postures that a PTP's Status and Turn allow, the nearest to the posture before first."""
        part = self.cell.arm_slice
        near = self.posture[part]
        found = self.arm.branches(foot_T_tool, near)
        status, turn = int(self.program.status[row]), int(self.program.turn[row])
        if status >= 0 and self.status_turn is not None:
            turned = []
            for q in found:
                for k in np.ndindex(3, 3):  # the turns of A4 and A6
                    other = q.copy()
                    other[[3, 5]] += 2.0 * np.pi * (np.array(k) - 1)
                    if np.all(other >= self.arm.lower - 1e-9) and np.all(other <= self.arm.upper + 1e-9):
                        turned.append(other)
            whole = np.tile(self.q[row], (max(len(turned), 1), 1))
            if turned:
                whole[:, part] = turned
                axes = self.cell.to_axis_values(whole)[:, :6]
                axes = np.where(np.abs(axes) < 1e-4, np.abs(axes), axes)  # a printed 0 is not negative
                fits = (self.status_turn.status(axes) == status) & turn_fits(self.program.turning, turn, axes)
                found = [q for q, fit in zip(turned, fits, strict=True) if fit]
        return sorted(found, key=lambda q: float(np.max(np.abs(q - near))))

    def continuous(self, start: int, stop: int) -> list[Finding]:
        """Follow the LIN and CIRC motions start .. stop, some at a time."""
        findings: list[Finding] = []
        while start < stop and not self.failed:
            end = min(start + _CHUNK, stop)
            while end < stop and self.program.kind[end - 1] == Motion.CIRC_VIA:
                end += 1
            findings += self._continuous(start, end)
            start = end
        return findings

    def _continuous(self, start: int, stop: int) -> list[Finding]:
        """Follow the motions start .. stop, at least one, the last of them no auxiliary point."""
        cell = self.cell
        before = self.targets[start - 1] if start else np.full((4, 4), np.nan)
        here = base_T_tool(cell, self.posture) if np.isnan(before[0, 0]) else before
        rows = slice(start, stop)
        external = np.ascontiguousarray(self.q[rows, : cell.arm_slice.start])
        upper_margin = np.full((stop - start, len(cell)), np.inf)
        code, stopped, samples = replay_run(
            self.kernel,
            self.posture,
            np.ascontiguousarray(here[:3, :3]),
            np.ascontiguousarray(here[:3, 3]),
            np.ascontiguousarray(self.targets[rows, :3, :3]),
            np.ascontiguousarray(self.targets[rows, :3, 3]),
            external,
            self.program.kind[rows] == Motion.CIRC_VIA,
            np.array([SAMPLE_LENGTH, SAMPLE_ANGLE, SAMPLES]),
            JUMP,
            ReplayRun(
                self.q[rows], self.margin[rows], upper_margin, self.inv_kf[rows], self.bend[rows], self.jump[rows]
            ),
        )
        np.minimum(self.margin[rows], upper_margin, out=self.margin[rows])
        self.samples += samples
        if code == 0:
            self.posture = self.q[stop - 1].copy()
            self.posture[: cell.arm_slice.start] = external[-1]
            return []
        row = start + stopped
        self._stop(row)
        text = {
            "out of reach": "the tool leaves the arm's reach on this motion",
            "jump": "the arm would have to flip on this motion (a joint jumps between neighbouring poses)",
        }[CODES[code]]
        return [self._error(CODES[code].replace(" ", "-"), text, row)]

    def _stop(self, row: int) -> None:
        self.failed = True
        self.q[row:, self.cell.arm_slice] = self.posture[self.cell.arm_slice]

    def _error(self, code: str, text: str, row: int) -> Finding:
        return Finding(code, text, Severity.ERROR, line=int(self.program.line[row]), point=row)

    def result(self, findings: tuple[Finding, ...], cells: tuple[Cell, ...], mounted: NDArray[np.int32]) -> Replay:
        """What was found, as it lies in memory: the run ends with it."""
        return Replay(
            sealed(self.q),
            sealed(self.targets),
            sealed(self.inv_kf),
            sealed(self.bend),
            sealed(self.jump),
            sealed(self.margin),
            self.samples,
            cells[0],
            findings,
            cells[1:],
            mounted,
        )
