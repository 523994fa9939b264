"""The next experiment as a program, released only where `camrob verify` passes it and nothing is touched."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.read_cell import read_cell
from camrob.checks.collisions import check_collisions
from camrob.controller.replay import replay
from camrob.controller.trace import posture_trace
from camrob.errors import InputError, JobError, VerificationError
from camrob.gap.experiment.motions import TrialMotion
from camrob.jobs.files.output import check_file_name, staged_output
from camrob.jobs.verify import verify
from camrob.kinematics.frames import base_T_tool, seen_by_program
from camrob.languages import language_of_file, program_suffixes
from camrob.program.builder import build_program
from camrob.program.language import Language, Rounding
from camrob.program.motion import Motion
from camrob.program.program import Program, ProgramEvent, ProgramEventKind
from camrob.summaries.diagnosis_summary import ExperimentWritten
from camrob.units import mm_to_m

__all__ = ["check_experiment_name", "write_experiment"]

Array = NDArray[np.float64]

_MOST = 800  # motions
_APART = mm_to_m(0.5)  # m of the tool, or that many metres a radian: samples closer together are one
_SLOWEST, _FASTEST, _STILL = 0.002, 0.25, 1e-4  # m/s
_STOPS = 40  # of an axis that moves alone, each way
_REST = 1.0  # s at each


def check_experiment_name(file: Path) -> None:
    """Raises InputError for a name that can't be a program's."""
    check_file_name(file.name)
    if file.suffix.lower() not in program_suffixes():
        hint = "end it with " + " or ".join(program_suffixes())
        raise InputError(f"--write-experiment {file.name!r} is not a program's name", hint=hint)
    language = language_of_file(file)
    if language.program_name(file.stem).lower() != file.stem.lower():
        raise InputError(
            f"--write-experiment {file.name!r} can't be a program's name on the controller",
            hint=f"use {language.naming}, a letter first",
        )


def write_experiment(file: Path, motions: Sequence[TrialMotion], cell: Path) -> ExperimentWritten:
    """Write the first motion that can be run as FILE, with what belongs to it, and say which it is, and why others were not.

    Each is written, read back, verified as `camrob verify` does, and followed through the cell's bodies. Raises JobError
    where there is nothing to tell apart, VerificationError where none can be run; nothing is left behind then.
    """
    if not motions:
        raise JobError("no experiment is needed: no other motion would tell more apart; leave the option out")
    passed_over: list[str] = []
    language = language_of_file(file)
    for motion in motions:
        files = dict(
            language.write(_program(motion, file.stem, language.round), motion.scene.cell.controller, max_lines=None)
        )
        why = _refused(files, file.stem, cell, language)
        if not why:
            with staged_output(file.parent) as staging:
                for name, content in files.items():
                    (staging / name).write_bytes(content)
            return ExperimentWritten(
                file=file.name, files=tuple(sorted(files)), motion=motion.key, passed_over=tuple(passed_over)
            )
        passed_over.append(f"{motion.text}: {why}")
    what = f"the experiment can't be run on this cell, so no program was written: {passed_over[0]}"
    raise VerificationError(f"{what}; clear the way, or move by hand what it proposes")


def _refused(files: Mapping[str, bytes], name: str, cell: Path, language: Language) -> str:
    """Why a program can't be run; "" where it can."""
    with tempfile.TemporaryDirectory() as folder:
        for file, content in files.items():
            (Path(folder) / file).write_bytes(content)
        main = f"{name}{language.suffixes[0]}".lower()
        source = next(Path(folder) / f for f in files if f.lower() == main)
        verified = verify(source, cell=cell)
        if not verified.ok:
            first = verified.summary.errors[0]
            return f"line {first.line}: {first.text}"
        text = language.read(source)
    replayed = replay(text, read_cell(cell))
    q, motion = posture_trace(text, replayed)
    report = check_collisions(replayed.cell, q)
    if report.hit.any():
        return f"line {int(text.line[motion[int(np.argmax(report.hit))]])}: bodies of the cell touch"
    return ""


def _program(motion: TrialMotion, name: str, rounding: Rounding) -> Program:
    """The motion between two visits of HOME."""
    cell, scene = motion.scene.cell, motion.scene
    at_rest = scene.poses or bool(motion.axis)
    q = _stops(motion.q) if motion.axis else motion.q if scene.poses else _thinned(cell, motion.q)
    q = (
        np.concatenate([cell.q_home[None], q[:1], q, cell.q_home[None]])
        if not at_rest
        else np.concatenate([cell.q_home[None], q, cell.q_home[None]])
    )
    N = len(q)
    kind = np.full(N, Motion.PTP_AXES if at_rest else Motion.LIN, np.int8)
    kind[[0, -1]] = Motion.PTP_AXES
    if not at_rest:
        kind[1] = Motion.PTP_AXES
    values = cell.to_axis_values(q)
    poses = seen_by_program(cell, q, base_T_tool(cell, q))
    lin = kind == Motion.LIN
    rest = tuple(ProgramEvent(k + 1, ProgramEventKind.DWELL, value=_REST) for k in range(1, N - 1)) if at_rest else ()
    return build_program(
        name,
        cell,
        rounding,
        kind=kind,
        axis_values=values,
        frames=poses,
        speed=_speed(cell, motion),
        approximate=lin & np.append(lin[1:], False),
        safe=~lin,
        events=rest,
        comment=tuple(f"{t}." for t in (f"Experiment: {motion.text}", motion.advice) if t),
    )


def _thinned(cell: Cell, q: Array) -> Array:
    """Postures with at least `_APART` between them, `_MOST` at most."""
    tip = base_T_tool(cell, q)[:, :3, 3]
    step = np.linalg.norm(np.diff(tip, axis=0), axis=1) + 0.1 * np.abs(np.diff(q, axis=0)).max(axis=1)
    way = np.concatenate([[0.0], np.cumsum(step)])
    count = int(min(_MOST, max(2.0, way[-1] / _APART)))
    return np.asarray(q[np.unique(np.searchsorted(way, np.linspace(0.0, way[-1], count)).clip(0, len(q) - 1))])


def _stops(q: Array) -> Array:
    """An axis's places to stop at, there and back."""
    half = len(q) // 2
    there = np.linspace(0, half - 1, _STOPS).astype(int)
    return np.asarray(q[np.concatenate([there, there[::-1]])])


def _speed(cell: Cell, motion: TrialMotion) -> float:
    """m/s: the ordinary speed of the tool over the part in the run, as much slower as the motion asks."""
    tip = base_T_tool(cell, np.asarray(motion.q))[:, :3, 3]
    pace = np.linalg.norm(np.diff(tip, axis=0), axis=1) * (len(motion.q) - 1) / max(motion.seconds, 1e-9)
    moving = pace[pace > _STILL]
    return float(np.clip(np.median(moving) if len(moving) else _SLOWEST, _SLOWEST, _FASTEST))
