"""`camrob close-loop`: program, run, diagnosis, correction, and again, until the path is kept or nothing helps."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.errors import InputError, JobError, VerificationError
from camrob.jobs.closing.added_targets import meant_rows
from camrob.jobs.closing.diagnosed_machine import DiagnosedMachine, cuts_of
from camrob.jobs.closing.loop_file import LoopJob, read_loop_job
from camrob.jobs.closing.measured_path import OffPath, intended_path, measured_off_path
from camrob.jobs.closing.off_way import off_path_size
from camrob.jobs.closing.rehearsal import rehearse, rehearsed_machine
from camrob.jobs.compensate import compensate
from camrob.jobs.diagnose import diagnose
from camrob.jobs.files.cell_for import cell_for, language_of
from camrob.jobs.files.inputs import program_name
from camrob.jobs.files.output import staged_output
from camrob.jobs.files.summary_file import read_summary, write_summary
from camrob.jobs.files.takes_paths import takes_paths
from camrob.jobs.post import post
from camrob.jobs.release.beside import fastest_that_cuts
from camrob.languages import language_of_file
from camrob.measurement.read_log import read_log
from camrob.prediction.force_model import CuttingForces
from camrob.prediction.read_force import read_forces
from camrob.progress import Progress
from camrob.report.closing.page import ledger_report
from camrob.summaries.closing.close_loop_summary import CloseLoopSummary, LoopTurn
from camrob.summaries.compensate_summary import CompensateSummary
from camrob.summaries.diagnosis_summary import DiagnosisSummary
from camrob.units import m_to_mm

__all__ = ["CloseLoopResult", "close_loop"]

Array = NDArray[np.float64]

_RUN, _EXPERIMENT = "run", "experiment"
_SUFFIXES = (".csv", ".parquet")
_RIVAL = 0.25  # probability of the second set of causes from which on an experiment is worth a run; a part of a cycle leaves 0.22
_WORTH = 0.95  # of the best rms so far: a turn that is not below has not helped


@dataclass(frozen=True, slots=True)
class CloseLoopResult:
    """The ledger."""

    summary: CloseLoopSummary


@takes_paths
def close_loop(job: Path, *, out: Path, progress: Progress | None = None) -> CloseLoopResult:
    """Go on with a loop as far as it gets: to the next log that is awaited, or to its end.

    Turn by turn, in a folder each (`turn_1`, ...): the program is made; its log, `run.csv` beside it, is awaited, or simulated
    where JOB.toml has a `[machine]`; what was measured is held to the path that was meant; all logs so far are diagnosed
    together; where two sets of causes remain, a program that tells them apart is written and its log awaited;
    the next turn's program is the first one (or one planned anew for accuracy) with what was found taken off. The same command
    goes on where it stopped: what is there is not made again. ledger.json and ledger.html tell each turn.

    Args:
        job: JOB.toml.
        out: the folder of the loop.
        progress: called with a stage and the share of it that is done, 0 to 1.

    Returns:
        The ledger.

    Raises:
        InputError and its kin: input that is wrong, or other than what the loop was begun with.
        JobError and its kin: a program can't be made safely.

    Example:
        >>> camrob.close_loop(Path("toolpaths/engraving/loop.toml"), out=Path("out/loop")).summary.outcome
        'awaiting a log'
    """
    start = time.perf_counter()
    asked, out = read_loop_job(job), Path(out)
    force = _force_for_all_turns(asked)
    machine = cell_for("post", asked.cell)
    loop = _Loop(asked, out, machine, force, rehearsed_machine(asked, machine), progress)
    loop.go()
    ledger = replace(loop.ledger(), seconds=round(time.perf_counter() - start, 3))
    with staged_output(out) as folder:
        write_summary(folder / "ledger.json", ledger)
        (folder / "ledger.html").write_text(
            ledger_report(ledger, loop.along(), loop.understood, loop.corrected), encoding="utf-8"
        )
    return CloseLoopResult(ledger)


class _Loop:
    """A loop on its way: its turns so far, and how it stands."""

    def __init__(
        self,
        job: LoopJob,
        out: Path,
        cell: Cell,
        force: CuttingForces | None,
        rehearsed: DiagnosedMachine | None,
        progress: Progress | None,
    ) -> None:
        self.job, self.out, self.cell, self.force = job, out, cell, force
        self.rehearsed, self.progress = rehearsed, progress
        self.title = program_name(job.toolpath, None, language_of(cell))
        self.main = f"{self.title}{language_of(cell).suffixes[0]}"
        self.made_from = job.made_from()
        self.before = _ledger_in(out, self.made_from)
        self.turns: list[LoopTurn] = []
        self.seen: dict[int, OffPath] = {}
        self.understood: dict[int, DiagnosisSummary] = {}
        self.corrected: dict[int, CompensateSummary] = {}
        self.logs: list[Path] = []
        self.intended = out / "turn_1" / self.main
        self.outcome, self.next = "", ""

    def go(self) -> None:
        """Turn after turn, until something is awaited or the loop ends."""
        while not self.outcome:
            turn = self._programmed(len(self.turns) + 1)
            self.turns.append(turn)
            log = self._log(turn.turn, _RUN)
            if log is None:
                self._await(turn.turn, self.main, _RUN)
                return
            self._measured(log)
            if not self.outcome:
                self._understood()

    def ledger(self) -> CloseLoopSummary:
        """The turns, and how the loop stands."""
        seen = [t for t in self.turns if t.measured is not None]
        best = min(seen, key=lambda t: t.measured.rms_mm if t.measured else np.inf).turn if seen else 0
        return CloseLoopSummary(
            toolpath=self.job.toolpath.name,
            cell=self.cell.name,
            tolerance_mm=self.job.tolerance_mm,
            outcome=self.outcome,
            next=self.next,
            best=best,
            turns=tuple(self.turns),
            made_from=self.made_from,
            files=("ledger.json", "ledger.html"),
        )

    def along(self) -> dict[int, tuple[Array, Array]]:
        """Of each turn that was measured, places along the path (K,), m, and how far the tool was off there (K,), m."""
        return {turn: (seen.along, seen.distance.off) for turn, seen in self.seen.items()}

    def _folder(self, turn: int) -> Path:
        return self.out / f"turn_{turn}"

    def _programmed(self, turn: int) -> LoopTurn:
        """A turn with its program, made where it is not there yet."""
        folder = self._folder(turn)
        name = f"turn_{turn}/{self.main}"
        if turn == 1:
            if not (folder / self.main).is_file():
                self._post(folder, accurate=False)
            return LoopTurn(turn=1, program=name, made="posted")
        last = self.turns[-1]
        found = self.out / last.diagnosis
        made = "corrected"
        if self.job.for_accuracy:
            planned = self.out / "planned"
            if not (planned / self.main).is_file():
                self._post(planned, accurate=True, diagnosis=found)
            self.intended, made = planned / self.main, "planned for accuracy, corrected"
        if not (folder / self.main).is_file():
            compensate(
                self.intended,
                cell=self.job.cell,
                calibration=_fitted(found),
                diagnosis=found,
                force=self.job.force,
                setup=self.job.set_up if self.force is not None and self.force.asks_setup else None,
                out=folder,
                progress=self.progress,
            )
        said = self.corrected[turn] = CompensateSummary.from_json(_made_earlier(folder / f"{self.title}.json"))
        predicted = None if said.machine is None else said.machine.after
        return LoopTurn(turn=turn, program=name, made=made, predicted=predicted)

    def _post(self, folder: Path, *, accurate: bool, diagnosis: Path | None = None) -> None:
        job = self.job
        post(
            job.toolpath,
            cell=job.cell,
            out=folder,
            setup=job.setup,
            method="planned" if accurate else job.method,
            for_accuracy=accurate,
            then_compensated=accurate,
            calibration=None if diagnosis is None else _fitted(diagnosis),
            diagnosis=diagnosis,
            force=job.force if accurate else None,
            progress=self.progress,
        )

    def _log(self, turn: int, stem: str) -> Path | None:
        """The log of a turn's run or experiment, simulated where the job says so; None where it is awaited."""
        folder = self._folder(turn)
        found = [folder / f"{stem}{s}" for s in _SUFFIXES if (folder / f"{stem}{s}").is_file()]
        if len(found) > 1:
            raise InputError(f"{found[0].name} lies beside it", hint="leave one of the two there", path=found[1])
        if not found and self.job.rehearsal is not None and self.rehearsed is not None:
            program = folder / (self.main if stem == _RUN else f"{stem}{language_of(self.cell).suffixes[0]}")
            rehearse(self.job.rehearsal, self.rehearsed, program, folder / f"{stem}.csv", turn)
            return folder / f"{stem}.csv"
        return found[0] if found else None

    def _await(self, turn: int, program: str, stem: str) -> None:
        self.outcome = "awaiting a log"
        self.next = (
            f"run turn_{turn}/{program} on the machine, put its log at turn_{turn}/{stem}.csv (and its LOG.toml at "
            f"turn_{turn}/{stem}.toml), and give the same command again"
        )

    def _measured(self, path: Path) -> None:
        """Hold the log of the last turn's run to the path that was meant."""
        turn, log = self.turns[-1], read_log(path)
        self._same_log(turn.turn, log.digest)
        program = language_of_file(self.intended).read(self.out / turn.program, self.cell.controller_section)
        meant = language_of_file(self.intended).read(self.intended, self.cell.controller_section)
        made = self.corrected[turn.turn].machine if turn.turn > 1 else None
        rows = meant_rows(program, {} if made is None else made.targets_added)
        if len(meant) != (rows[-1] + 1 if len(rows) else 0):
            what = f"{turn.program} holds a different number of motions from {self.intended.name}"
            raise VerificationError(f"{what}; begin the loop anew in an empty folder")
        cuts = cuts_of(program, fastest_that_cuts(self.intended, self.force))
        seen = measured_off_path(log, program, self.cell, intended_path(meant, self.cell), rows, cuts)
        self.seen[turn.turn], size = seen, off_path_size(seen.distance)
        noise = log.info.sigma_position
        self.logs.append(path)
        self.turns[-1] = replace(
            turn,
            log=f"turn_{turn.turn}/{path.name}",
            log_digest=log.digest,
            measured=size,
            noise_mm=m_to_mm(float(noise * np.sqrt(3.0))) if np.isfinite(noise) else None,
        )
        earlier = [t.measured.rms_mm for t in self.turns[:-1] if t.measured is not None]
        if size.p95_mm <= self.job.tolerance_mm:
            self.outcome = "within tolerance"
            self.next = f"use turn_{turn.turn}/{self.main}"
        elif earlier and size.rms_mm > _WORTH * min(earlier):
            self.outcome = "nothing more helps"
            best = int(np.argmin([*earlier, size.rms_mm])) + 1
            self.next = f"use turn_{best}/{self.main}: {self._left()}"
        elif turn.turn >= self.job.turns:
            self.outcome = "turns used up"
            self.next = f"raise `turns` in {self.job.path.name} to go on"

    def _left(self) -> str:
        """What stands in the way of more."""
        last = self.turns[-1]
        rest = next((t.rest_mm for t in reversed(self.turns) if t.rest_mm is not None), 0.0)
        parts = [f"{rest:.3f} mm remain unexplained"]
        if last.predicted is not None:
            parts.insert(0, f"these targets can't take {last.predicted.rms_mm:.3f} mm rms of what was found off")
        if last.noise_mm is not None:
            parts.append(f"the instrument's noise is {last.noise_mm:.3f} mm")
        return ", ".join(parts)

    def _same_log(self, turn: int, digest: str) -> None:
        """Raise InputError where a log was replaced after the next program was made with it."""
        then = next((t.log_digest for t in self.before if t.turn == turn), "")
        if then and then != digest and self._folder(turn + 1).exists():
            hint = f"put the log back, or remove turn_{turn + 1} and what follows, and the diagnosis of turn_{turn}"
            raise InputError("is not the log that the next turn was made with", hint=hint, path=self._folder(turn))

    def _understood(self) -> None:
        """Diagnose all logs so far, with an experiment where two sets of causes remain."""
        turn = self.turns[-1]
        folder = self._folder(turn.turn)
        said = self._diagnosis(folder / "diagnosis", experiment=folder / f"{_EXPERIMENT}{Path(self.main).suffix}")
        name = f"turn_{turn.turn}/diagnosis"
        wanted = ""
        if self.job.experiments and _rivals(said) and (folder / f"{_EXPERIMENT}{Path(self.main).suffix}").is_file():
            wanted = f"turn_{turn.turn}/{_EXPERIMENT}{Path(self.main).suffix}"
            log = self._log(turn.turn, _EXPERIMENT)
            if log is None:
                self._await(turn.turn, Path(wanted).name, _EXPERIMENT)
                self.next += (
                    f"; two sets of causes remain ({_remaining_sets(said)}); `experiments = false` goes on without"
                )
            else:
                self.logs.append(log)
                said, name = self._diagnosis(folder / "diagnosis_2"), f"turn_{turn.turn}/diagnosis_2"
        self.understood[turn.turn] = said
        self.turns[-1] = replace(
            turn,
            diagnosis=name,
            found=tuple(f"{e.effect} {' '.join(e.axes)}".strip() for e in said.claimed),
            rest_mm=round(said.unexplained_mm, 6),
            experiment=wanted,
        )
        if not self.outcome and not said.claimed:
            self.outcome = "nothing to correct"
            self.next = f"no cause was found: read {name}/diagnosis.html, it says where to look"

    def _diagnosis(self, folder: Path, experiment: Path | None = None) -> DiagnosisSummary:
        """The diagnosis of all logs so far in a folder, made where it is not there yet."""
        if not (folder / "diagnosis.json").is_file():
            with suppress(
                JobError
            ):  # no experiment is needed, or nothing is a constant: the diagnosis is written all the same
                diagnose(
                    cell=self.job.cell,
                    log=self.logs,
                    out=folder,
                    experiment=experiment if self.job.experiments else None,
                    calibration=folder / "fitted.toml",
                    progress=self.progress,
                )
        return DiagnosisSummary.from_json(_made_earlier(folder / "diagnosis.json"))


def _force_for_all_turns(job: LoopJob) -> CuttingForces | None:
    """The job's force. Raises InputError for one that the second turn could do nothing with, before anybody runs the first."""
    force = None if job.force is None else read_forces(job.force)
    if force is not None and force.asks_removal and not job.set_up.is_file():
        hint = "give depth_mm and width_mm, or a setup with stock and cutter"
        raise InputError("leaves depth or width to the removal", hint=hint, path=job.force)
    return force


def _ledger_in(out: Path, made_from: dict[str, str]) -> Sequence[LoopTurn]:
    """The turns of the ledger that is there. Raises InputError where it was begun from something else."""
    file = out / "ledger.json"
    if not file.is_file():
        return ()
    before = CloseLoopSummary.from_json(_made_earlier(file))
    other = sorted(k for k in {*before.made_from, *made_from} if before.made_from.get(k) != made_from.get(k))
    if other:
        hint = "choose another --out for the new job, or put the file back"
        raise InputError(f"was begun with another {other[0]}", hint=hint, path=file)
    return before.turns


def _made_earlier(file: Path) -> dict[str, object]:
    """The summary in a file of the loop's. Raises InputError where it can't be read."""
    return read_summary(file, hint="remove its folder, and give the command again")


def _fitted(diagnosis: Path) -> Path | None:
    """The constants that a diagnosis handed over, where there are any."""
    file = diagnosis / "fitted.toml"
    return file if file.is_file() else None


def _rivals(said: DiagnosisSummary) -> bool:
    """Whether two sets of causes remain that would be corrected differently."""
    return len(said.alternatives) > 1 and said.alternatives[1].probability > _RIVAL


def _remaining_sets(said: DiagnosisSummary) -> str:
    return " or ".join(", ".join(a.effects) or "nothing" for a in said.alternatives[:2])
