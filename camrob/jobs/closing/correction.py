"""A program on its way to other targets: with which the calibrated chain, or the machine as diagnosed, meets what was meant."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.calibration import Calibration
from camrob.calibration.compensate import Compensated
from camrob.cell.cell import Cell
from camrob.controller.judge import judge
from camrob.controller.programmed_path import ProgrammedPath, programmed_path
from camrob.controller.replay import Replay, replay
from camrob.errors import InputError, SingularError, UnreachableError
from camrob.findings import Finding, first_error
from camrob.jobs.closing.added_targets import lines_added, meant_rows, places_to_add, with_targets_added
from camrob.jobs.closing.diagnosed_machine import DiagnosedMachine, MachineRun, shifted
from camrob.jobs.closing.off_way import OffWay, off_path_size
from camrob.jobs.closing.rewrite import rewritten
from camrob.jobs.closing.tool_chains import ToolChains
from camrob.jobs.predicting.predicted_figures import likely_of
from camrob.program.language import Language
from camrob.program.motion import Motion
from camrob.program.program_text import ProgramText
from camrob.progress import Progress, Share, stage_of
from camrob.summaries.compensate_summary import OnDiagnosedMachine
from camrob.units import m_s_to_mm_min, m_to_mm

__all__ = ["Correction", "met_on_machine"]

Array = NDArray[np.float64]

_ROUNDS = 2  # corrections on the machine as diagnosed: the second takes what the first has changed
_BETTER = 0.98  # of the mean square off the path: a round that takes less than that off is not worth another program
_SLACK = 1.1  # by so much 95 % of the way may be farther off where the mean square is less
# m rms by which a motion that is farther off than before is told: less than half of what any arm repeats to
_FARTHER = 1e-5
_SEEN = 3e-5  # m that stay for their speed's sake, and are worth a word: as much as a good arm repeats to
_PRINTED = 1e-3  # degrees: rounding of what is printed, and well below what anybody would teach
_OF_ONE = "holds the tool's own frame, as of the one that was measured: it is taken for all of them"
_GUARD = 2e-6  # rad to a limit: what rounding the printed pose may move an axis by


class Correction:
    """A program on its way: read, replayed, judged and compensated. targets: (N, 4, 4) what the calibrated chain is to meet.

    kept: (N,) PTPs to axis values that the cell states, HOME and where tools are changed. They stay: no pose is asked for there,
    they were taught on the machine as it is, and the controller knows HOME ($H_POS, XHOME) by these very values.
    more: whether these hold more than the chain's constants.
    """

    def __init__(
        self,
        source: Path,
        found: Calibration | None,
        language: Language,
        machine: Cell,
        progress: Progress | None,
    ) -> None:
        self.source, self.found, self.language, self.machine = source, found, language, machine
        self.text = text = language.read(source, machine.controller_section)
        self.progress = progress
        self.planned = replay(text, machine, progress=self.tell("replay"))
        self.judged = judge(text, self.planned)
        _followed(self.planned)
        self.chains = ToolChains.of(found, self.planned.cells, self.planned.mounted)
        self.q = _postures(text, self.planned)
        self.targets = np.asarray(self.planned.base_T_tool)
        self.kept = _stated(text, machine)
        self.result, self.left = self._compensated(self.targets)
        if self.planned.others and self.chains.moves_tool:
            self.left.append(Finding("tool-of-one", f"the calibration {_OF_ONE}"))
        self.on_machine: OnDiagnosedMachine | None = None
        self.off_path, self.more = OffWay(np.zeros(0), np.zeros(0), np.zeros(0, np.int64)), False
        self.best: MachineRun | None = None

    @cached_property
    def intended(self) -> ProgrammedPath:
        """The way that the program asks for."""
        return programmed_path(self.text, self.planned)

    def tell(self, stage: str) -> Share:
        """What one stage tells."""
        return stage_of(self.progress, stage)

    def _compensated(self, targets: Array) -> tuple[Compensated, list[Finding]]:
        """Postures that meet targets (N, 4, 4) within the axes' limits, and what was left because of them."""
        try:
            result = self.chains.met(self.q, targets, progress=self.tell("compensate"))
        except SingularError as error:
            row = int(error.value or 0.0)
            what = "the pose can't be compensated: the arm is singular there; lead the path past that posture"
            raise SingularError(what, line=int(self.text.line[row]), of_program=True) from None
        stays = np.where(self.kept[:, None], self.q, np.asarray(result.q))
        return _within_limits(self.planned.cell, self.q, replace(result, q=stays), self.text)

    def rewritten(self, q: Array, folder: Path, head: Sequence[str] = ()) -> tuple[ProgramText, list[Finding]]:
        """The program whose targets postures q (N, n) reach, written into a folder and read back; what was left as it is. head:
        lines of comment at its head.
        """
        return rewritten(self.source, self.language, self.text, self.planned, q, folder, kept=self.kept, head=head)

    def run_on(self, known: DiagnosedMachine, progress: Share | None = None) -> MachineRun:
        """The program as it stands, with this work's corrections, on the machine as diagnosed."""
        with TemporaryDirectory() as scratch:
            program = self.rewritten(np.asarray(self.result.q), Path(scratch))[0]
            return known.run(program, progress=progress)

    def meet_on(self, known: DiagnosedMachine) -> OffWay:
        """Take off the targets what the machine as diagnosed does beyond the calibrated chain, while that brings the tool nearer
        to the path: most of it is taken at once, as errors are smooth beside corrections.

        Returns how far it is off with the chain's constants corrected; what stays is `off_path`.
        """
        intended = self.intended
        report = self.tell("run on the machine as diagnosed")

        def run(turn: int) -> tuple[MachineRun, OffWay]:
            now = self.run_on(known, lambda share: report((turn + share) / (_ROUNDS + 1)))
            return now, now.off_path(intended)

        now, self.off_path = run(0)
        constants, meant, self.best = self.off_path, self.targets, now
        for turn in range(1, _ROUNDS + 1):
            was = self.result, self.left
            targets = shifted(meant, now.beyond_at_ends())
            self.result, self.left = self._compensated(targets)
            now, off = run(turn)
            if not _worth(off, self.off_path):
                self.result, self.left = was
                break
            self.targets, self.off_path, self.more, self.best = targets, off, True, now
        return constants


def _worth(off: OffWay, best: OffWay) -> bool:
    """Whether a run is worth another program than the one with the `best` so far."""
    return off.mean_square() < _BETTER * best.mean_square() and off.within(0.95) <= _SLACK * best.within(0.95)


def met_on_machine(made: Correction, known: DiagnosedMachine, scratch: Path) -> Correction:
    """The work on the machine as diagnosed: with targets added to the program where that brings the tool nearer to its path."""
    if made.planned.others and made.found is None and known.claims_tool():
        made.left.append(Finding("tool-of-one", f"the diagnosis {_OF_ONE}"))
    _demand_cuts(known, made.text)
    as_it_was = known.run(made.text, progress=made.tell("run as it is on the machine as diagnosed"))
    before = as_it_was.off_path(made.intended)
    constants, added = made.meet_on(known), dict[str, tuple[int, ...]]()
    places = places_to_add(as_it_was, made.language, made.source.parent)
    if places:
        scratch.mkdir()
        divided = with_targets_added(made.source, made.language, made.text, made.planned, places, scratch)
        finer = Correction(divided, made.found, made.language, made.machine, made.progress)
        finer.judged = made.judged  # nothing may stand against the new program that did not stand against the one given
        finer.meet_on(known)
        if _worth(finer.off_path, made.off_path):
            added, made = lines_added(made.text, places), finer
    if known.forces and not as_it_was.bends():
        what = "nothing is known to yield under the force, and nothing is taken off for it: diagnosis and calibration hold no"
        made.left.append(Finding("force-bends-nothing", f"{what} compliance, {known.forces[0].path.name} no [tool]"))
    if made.more:
        made.left += _farther(before, made, meant_rows(made.text, added))
    made.left += _too_fast(made)
    made.on_machine = OnDiagnosedMachine(
        diagnosis=known.name,
        causes=as_it_was.further_causes() if made.more else (),
        not_reckoned=as_it_was.path.not_reckoned,
        rest_mm=float(m_to_mm(np.sqrt(3.0 * np.mean(as_it_was.path.rest**2)))),
        targets_added=added,
        fastest_cut_mm_min=round(m_s_to_mm_min(known.fastest), 6) if np.isfinite(known.fastest) else None,
        before=off_path_size(before),
        constants=off_path_size(constants),
        after=off_path_size(made.off_path),
        likely=None if made.best is None else likely_of(made.best.likely_off(made.intended)),
    )
    return made


def _demand_cuts(known: DiagnosedMachine, program: ProgramText) -> None:
    """Raise InputError where nothing of a program is as slow as what is said to cut."""
    led = np.asarray(program.kind) >= Motion.LIN
    if led.any() and not known.cuts(program).any():
        slowest = m_s_to_mm_min(float(np.nanmin(np.asarray(program.speed)[led])))
        what = f"fastest_cut_mm_min = {m_s_to_mm_min(known.fastest):g} is below the feed of all that cuts ({slowest:g} at least)"
        file = known.forces[0].path if known.forces else None
        raise InputError(what, hint="give the fastest feed that cuts", path=file)


def _farther(before: OffWay, made: Correction, meant: NDArray[np.int64]) -> list[Finding]:
    """What comes out farther off the path than it was, as its ends are those of cuts that are corrected (a plunge). meant: (M,)
    the motion of the program as it was that each of the motions is part of.
    """
    count = int(meant[-1]) + 1
    was = before.by_motion(count)
    now = made.off_path._replace(motion=meant[made.off_path.motion]).by_motion(count)
    rows = np.flatnonzero(now > was + _FARTHER)
    if not len(rows):
        return []
    worst = int(rows[np.argmax(now[rows] - was[rows])])
    line = int(made.text.line[np.searchsorted(meant, worst, side="right") - 1])
    lines = f"{len(rows)} lines and arcs come" if len(rows) > 1 else "1 line or arc comes"
    what = (
        f"{lines} out farther off the path than before, the worst at {m_to_mm(now[worst]):.3f} mm rms for "
        f"{m_to_mm(was[worst]):.3f}: their ends are moved for the cuts beside them; look whether they touch the part"
    )
    return [Finding("farther-off", what, line=line, count=len(rows))]


def _too_fast(made: Correction) -> list[Finding]:
    """What drives that follow late leave where the way turns: no targets take it off, a lower feed does."""
    if made.best is None or not len(made.off_path.off):
        return []
    late, off = made.best.left_of_speed(), made.off_path.within(0.95)
    share = late.within(0.95)
    if share < _SEEN or share < 0.5 * off:
        return []
    line = int(made.text.line[late.motion[int(np.argmax(late.off))]])
    what = (
        f"most of what stays (95 % of the way within {m_to_mm(off):.3f} mm) is of drives that follow late, where the way turns "
        "or ends: targets can't follow that. Post with tolerance_mm in the set-up and this diagnosis, which lowers the feed "
        "there, and compensate that program"
    )
    return [Finding("left-by-speed", what, line=line)]


def _stated(text: ProgramText, cell: Cell) -> NDArray[np.bool_]:
    """(N,) PTPs to the arm's axis values of HOME, or of where tools are changed, as they are printed; not where a line begins,
    whose way would be off there.
    """
    section = cell.controller_section
    poses = [cell.to_axis_values(cell.q_home)]
    if section is not None and section.tool_change_pose is not None:
        poses.append(np.array(section.tool_change_pose, float))
    axes = np.asarray(text.axes)
    out = np.zeros(len(text), np.bool_)
    for pose in poses:
        if axes.shape[1] <= len(pose):
            out |= np.abs(axes - pose[: axes.shape[1]]).max(axis=1) < _PRINTED
    kind = np.asarray(text.kind)
    begins = np.append(kind[1:] >= Motion.LIN, False)
    return np.asarray(out & (kind == Motion.PTP_AXES) & ~begins)


def _followed(planned: Replay) -> None:
    """The original can be replayed. Raises UnreachableError."""
    if (stopped := first_error(planned.findings)) is not None:
        what = f"the program can't be followed as it is: {stopped.text}; mend it there first"
        raise UnreachableError(what, line=stopped.line, of_program=True)


def _postures(text: ProgramText, planned: Replay) -> Array:
    """The motions' postures (N, n); at a CIRC's auxiliary point the other axes are half-way, the arm meets the point."""
    q = np.array(planned.q)
    via = np.flatnonzero(np.asarray(text.kind) == Motion.CIRC_VIA)
    if len(via):
        half_way = 0.5 * (q[np.maximum(via - 1, 0)] + q[via + 1])
        targets = np.asarray(planned.base_T_tool)[via]
        q[via] = ToolChains.of(None, planned.cells, planned.mounted).at(via).met(half_way, targets, farthest=np.pi).q
    return q


def _within_limits(cell: Cell, q: Array, result: Compensated, text: ProgramText) -> tuple[Compensated, list[Finding]]:
    """Corrections shrunk, point by point, to what the limits leave of them; so they fade where an axis nears its limit."""
    part = cell.arm_slice
    wanted = (np.asarray(result.q) - q)[:, part]
    room = np.where(wanted > 0.0, cell.q_upper[part] - q[:, part], q[:, part] - cell.q_lower[part])
    room = np.maximum(room - _GUARD, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(np.abs(wanted) > room, room / np.abs(wanted), 1.0)
    least = np.min(share, axis=1)
    short = np.flatnonzero(least < 1.0)
    if not len(short):
        return result, []
    kept = np.array(result.q)
    kept[:, part] = q[:, part] + least[:, None] * wanted
    findings = []
    for axis in np.unique(np.argmin(share[short], axis=1)):
        rows = short[np.argmin(share[short], axis=1) == axis]
        joint = cell.joints[part.start + int(axis)]
        count = f"{len(rows)} points are" if len(rows) > 1 else "1 point is"
        what = f"{count} corrected in part only: {joint.name} is at its limit"
        findings.append(Finding("limit", what, line=int(text.line[rows[0]]), axis=joint.name, count=len(rows)))
    return replace(result, q=kept), findings
