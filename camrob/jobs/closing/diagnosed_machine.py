"""A program run on the machine as it was diagnosed: where the tool truly goes, and what a correction can take of that."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.calibration import Calibration
from camrob.calibration.compensate import pose_difference
from camrob.cell.cell import Cell
from camrob.controller.programmed_path import ProgrammedPath
from camrob.controller.replay import program_cells
from camrob.controller.simulate import simulate
from camrob.gap.fitted_units import FittedUnits
from camrob.gap.observation.program_track import nearest_on_path
from camrob.jobs.closing.off_way import OffWay
from camrob.jobs.closing.run_way import RunWay, arcs_of
from camrob.jobs.closing.tool_chains import ToolChains
from camrob.jobs.predicting.removed_by_run import Removal
from camrob.kinematics.frames import world_T_base
from camrob.measurement.log import MeasurementLog
from camrob.prediction.deflection import CAUSE
from camrob.prediction.force_model import CuttingForce
from camrob.prediction.likely import LikelySizes, likely_distances
from camrob.prediction.speed_errors import SLOWLY, beside_way, causes_of_speed, twist_of
from camrob.prediction.true_path import TruePath, claimed_constants, joined_paths, true_path, unit_name
from camrob.program.motion import AT_SPEED, Motion
from camrob.program.program_text import ProgramText
from camrob.progress import Share
from camrob.runs import runs_of
from camrob.se3 import rotation_exp

__all__ = ["DiagnosedMachine", "MachineRun", "cuts_of", "shifted"]

Array = NDArray[np.float64]

_DRAWN_PLACES = 3_000  # of a run on which it is drawn how far the tool is likely to be off
_FEWEST = 12  # rows that a run can be laid out with
_CYCLE = 0.004  # s, a row of the run: what a lag and a corner change within a motion is seen


@dataclass(frozen=True)
class DiagnosedMachine:
    """A cell and what is wrong with it. constants: of its chain; units: all that a diagnosis claims, None without one; rest: m
    in any one direction that stays unexplained, beside what `units` know of that; name: of the diagnosis; forces: what pushes
    on each of the program's tools while it cuts, none where nothing does; fastest: m/s, lines and arcs that are programmed faster
    are moves in air; removal: what a run cuts, for a force that asks for it.
    """

    cell: Cell
    constants: Calibration | None
    units: FittedUnits | None
    rest: float
    name: str
    forces: tuple[CuttingForce, ...] = ()
    fastest: float = float("inf")
    removal: Removal | None = None

    def cuts(self, program: ProgramText) -> NDArray[np.bool_]:
        """(M,) the motions that cut, as far as a program tells: lines and arcs that are not too fast."""
        return cuts_of(program, self.fastest)

    def run(self, program: ProgramText, *, progress: Share | None = None) -> MachineRun:
        """Run a program. Raises as `simulate`, and InputError where calibration and diagnosis don't belong together."""
        cells, mounted, _ = program_cells(program, self.cell)
        ran = simulate(program, self.cell, cycle=_CYCLE, progress=progress)
        motion = np.asarray(ran.motion)
        chains = ToolChains.of(self.constants, cells, mounted[motion])
        area = None if self.removal is None else self.removal(ran.log, chains.mounted)
        path = self.path(ran.log, cells, chains.mounted, self.cuts(program)[motion], area)
        return MachineRun(self, program, cells, chains, ran.log, motion, path, area)

    def path(
        self,
        log: MeasurementLog,
        cells: Sequence[Cell],
        mounted: NDArray[np.int64],
        cuts: NDArray[np.bool_],
        area: Array | None,
    ) -> TruePath:
        """The machine's path on a run of the virtual controller; the force pushes where it `cuts` (N,), and bends what was found
        to yield: a correction takes off nothing that is only ordinary. mounted: (N,) with which of the tools.
        """
        known: dict[str, Any] = {"rest": self.rest, "assumed": False}
        parts = []
        for rows in runs_of(mounted):
            columns = {name: np.asarray(values)[rows] for name, values in log.columns.items()}
            own = MeasurementLog(columns, log.info)
            tool = int(mounted[rows.start])
            known |= {"area": None if area is None else area[rows], "cuts": cuts[rows]}
            known["force"] = self.forces[tool] if self.forces else None
            parts.append(true_path(own, cells[tool], self.constants, self.units, **known))
        return joined_paths(parts)

    def claims_tool(self) -> bool:
        """Whether the diagnosis claims a tool's own frame, which it knows of one tool."""
        return self.units is not None and any(name.startswith("tool.") for name in claimed_constants(self.units))


@dataclass(frozen=True)
class MachineRun:
    """A run: its set-points a row a cycle, `motion` (N,) the row of the program that each belongs to, and the path.

    cells: with each of the program's tools; chains: the calibrated chain with that of each row; area: (N,) m2 that is cut across
    the way to each row, None where nobody asked.
    """

    machine: DiagnosedMachine
    program: ProgramText
    cells: tuple[Cell, ...]
    chains: ToolChains
    log: MeasurementLog
    motion: NDArray[np.int64]
    path: TruePath
    area: Array | None

    @property
    def cell(self) -> Cell:
        """With the first tool, where any will do."""
        return self.cells[0]

    @cached_property
    def way(self) -> RunWay:
        """How the rows lie along the program's motions."""
        step = np.linalg.norm(np.diff(self.path.ideal[:, :3, 3], axis=0), axis=1)
        kind, step = np.asarray(self.program.kind), np.concatenate([[0.0], step])
        return RunWay(kind, self.motion, step, arcs_of(self.program), self.machine.cuts(self.program))

    @cached_property
    def beyond_constants(self) -> Array:
        """(N, 6) twists in `base` between the tool of the calibrated chain and the true one.

        Of what comes of the speed (a lag), what leaves the tool on its way is left out: it gets there, only later, and a target
        set ahead for it would be overrun where the motion ends.
        """
        calibrated = self.chains.poses(self.cell.to_q(self.log.setpoints(self.cell.axis_names)))
        twist = pose_difference(self.path.true, calibrated)
        twist[:, :3] -= self._of_speed[:, :3] - self._late
        return twist

    @cached_property
    def _late(self) -> Array:
        """(N, 3) m by which what comes of the speed carries the tool off its way."""
        return beside_way(self.path.ideal[:, :3, 3], self._of_speed[:, :3])

    def left_of_speed(self) -> OffWay:
        """What no correction of the motions' ends takes of what the speed carries the tool off its way by, where it cuts."""
        cutting = np.flatnonzero(self.machine.cuts(self.program)[self.motion])
        late = np.pad(self._late, ((0, 0), (0, 3)))
        left = (late - self.way.between(self.way.fit(late)))[cutting, :3]
        return OffWay(np.linalg.norm(left, axis=1), self.way.step[cutting], self.motion[cutting])

    def beyond_at_ends(self) -> Array:
        """(M, 6) twists at the motions' ends which, interpolated along the motions, come nearest to `beyond_constants`.

        Nearest by least squares over the way: between two ends a correction is a straight line, and play that changes its side
        there is met half-way from both.
        """
        return self.way.fit(self.beyond_constants)

    def bends(self) -> bool:
        """Whether the force moves the tool at all: it takes an axis that is known to yield, or a tool that does."""
        return any(c.name == CAUSE and bool(c.twist.any()) for c in self.path.causes)

    def further_causes(self) -> tuple[str, ...]:
        """What more than the calibration's constants moves the tool: constants, too, which only a diagnosis claims."""
        return tuple(name for name in self._further() if name != CAUSE or self.bends())

    def _further(self) -> tuple[str, ...]:
        found = self.machine.units
        if found is None:
            constants = self.machine.constants
            names = set() if constants is None else set(constants.model(self.cell, in_base=True)[0].names)
            return tuple(c.name for c in self.path.causes if c.name not in names)
        constant = {
            unit_name(found, k)
            for k, (unit, effect, state) in enumerate(zip(found.units, found.effects, found.states, strict=True))
            if effect.terms(unit, state) and self.machine.constants is not None
        }
        return tuple(c.name for c in self.path.causes if c.name not in constant)

    def off_path(self, intended: ProgrammedPath) -> OffWay:
        """From the tool's place to the intended path, at the rows of motions that cut."""
        cutting = np.flatnonzero(self.machine.cuts(self.program)[self.motion])
        off = np.linalg.norm(self._beside(intended, cutting), axis=1)
        return OffWay(off, self.way.step[cutting], self.motion[cutting])

    def _beside(self, intended: ProgrammedPath, rows: NDArray[np.int64]) -> Array:
        """(P, 3) m in `base` from the nearest place of the intended path to the tool, at rows (P,) of the run."""
        tip, turn = self.path.true[rows, :3, 3], None
        if intended.in_world:
            frames = world_T_base(self.cell, self.cell.to_q(self.log.setpoints(self.cell.axis_names)[rows]))
            turn = frames[:, :3, :3]
            tip = np.einsum("nij,nj->ni", turn, tip) + frames[:, :3, 3]
        off = tip - nearest_on_path(tip, intended, self.motion[rows])[0]
        return off if turn is None else np.einsum("nji,nj->ni", turn, off)

    def likely_off(self, intended: ProgrammedPath) -> LikelySizes:
        """How far the tool is likely to be off the intended path where it cuts, by all that the diagnosis leaves open."""
        cutting = np.flatnonzero(self.machine.cuts(self.program)[self.motion] & (self.way.step > 0.0))
        way = np.cumsum(self.way.step[cutting])
        if not len(cutting):
            return LikelySizes(np.zeros(3), np.zeros(3))
        # places as far apart along the way as there may be
        count = min(_DRAWN_PLACES, len(cutting))
        rows = np.unique(cutting[np.searchsorted(way, np.linspace(0.0, way[-1], count + 2)[1:-1])])
        ideal = self.path.ideal[:, :3, 3]
        along = (ideal[rows] - ideal[rows - 1]) / self.way.step[rows, None]
        spread = self.path.spread[rows, :3]
        together = self._together(rows)
        apart = np.maximum(self.path.rest[rows] ** 2 - np.sum(together**2, axis=1), 0.0)
        return likely_distances(self._beside(intended, rows), along, spread, together, np.sqrt(apart))

    def _together(self, rows: NDArray[np.int64]) -> Array:
        """(P, L) m, what is unexplained as one smooth field, which goes by the postures of the rows alone."""
        machine, few = self.machine, {name: np.asarray(v)[rows] for name, v in self.log.columns.items()}
        if machine.units is None or machine.units.unexplained is None or len(rows) < _FEWEST:
            return np.zeros((len(rows), 0))
        log = MeasurementLog(few, self.log.info)
        path = true_path(log, self.cell, machine.constants, machine.units, rest=machine.rest, drawn=True)
        return np.zeros((len(rows), 0)) if path.together is None else path.together

    @cached_property
    def _of_speed(self) -> Array:
        """(N, 6) the part of the twist that comes of the speed: run as slowly, less than half of it would be there."""
        columns = {**self.log.columns, "t": SLOWLY * np.asarray(self.log.t)}
        log, cuts = MeasurementLog(columns, self.log.info), self.machine.cuts(self.program)[self.motion]
        slow = self.machine.path(log, self.cells, self.chains.mounted, cuts, self.area)
        return twist_of(self.path, causes_of_speed(self.path, slow))


def cuts_of(program: ProgramText, fastest: float) -> NDArray[np.bool_]:
    """(M,) the motions along lines and arcs that are not programmed faster than `fastest`, m/s."""
    too_fast = np.asarray(program.speed) > AT_SPEED * fastest
    return np.asarray((np.asarray(program.kind) >= Motion.LIN) & ~too_fast)


def shifted(targets: Array, twists: Array) -> Array:
    """Targets (M, 4, 4) moved against twists (M, 6): a machine that errs by these meets what was asked for."""
    out = targets.copy()
    out[:, :3, 3] -= twists[:, :3]
    out[:, :3, :3] = rotation_exp(-twists[:, 3:]) @ targets[:, :3, :3]
    return np.asarray(out)
