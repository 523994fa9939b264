"""`camrob predict`: the part as it would come out, before it is cut."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.meshes import body_triangles
from camrob.calibration.calibration_file import read_calibration
from camrob.cell.cell import Cell
from camrob.cell.setup import Setup
from camrob.controller.simulate import simulate as run
from camrob.cutting.dexels import Dexels
from camrob.cutting.holder import holder_takes
from camrob.errors import InputError, SetupError
from camrob.jobs.files.cell_for import cell_for
from camrob.jobs.files.diagnosed import diagnosed
from camrob.jobs.files.output import staged_output
from camrob.jobs.files.summary_file import write_summary
from camrob.jobs.files.takes_paths import takes_paths
from camrob.jobs.predicting.input_remarks import remarks_on
from camrob.jobs.predicting.predicted_figures import (
    causes_of,
    force_of,
    holder_of,
    likely_of,
    part_of,
    places_of,
    regions_of,
    size_of,
)
from camrob.jobs.predicting.program_tools import ProgramTools, by_tool, mounted_in
from camrob.jobs.predicting.removal import setup_for, stock_of
from camrob.jobs.predicting.removed_by_run import removed
from camrob.jobs.release.beside import player_beside
from camrob.kinematics.frames import base_T_tool
from camrob.languages import language_of_file
from camrob.measurement.log import MeasurementLog
from camrob.prediction.against_part import against_part
from camrob.prediction.deflection import CAUSE
from camrob.prediction.force_model import CuttingForce
from camrob.prediction.read_force import read_forces
from camrob.prediction.surface import CuttersOfRun, PredictedSurface, predict_surface
from camrob.prediction.true_path import TruePath, joined_paths, true_path
from camrob.program.motion import Blend
from camrob.program.program_text import ProgramText
from camrob.progress import Progress, stage_of
from camrob.report.predict.page import predict_report
from camrob.summaries.predict_summary import HeldToPart, HolderMeets, PredictSeconds, PredictSummary
from camrob.units import m_to_mm, mm_to_m, ms_to_s

__all__ = ["PredictResult", "predict"]

Array = NDArray[np.float64]

_PERCENTILES = (1, 5, 25, 50, 75, 95, 99)  # of the deviations, with their signs
_REACH = 5e-3  # m off the cut surface, along a ray, in which the part's wall is looked for: more is another wall


@dataclass(frozen=True, slots=True)
class PredictResult:
    """The summary, the surface with its points in `part` (SI), and the tool's path behind it."""

    summary: PredictSummary
    surface: PredictedSurface
    path: TruePath


@takes_paths
def predict(
    program: Path,
    *,
    cell: Path,
    out: Path,
    calibration: Path | None = None,
    diagnosis: Path | None = None,
    setup: Path | None = None,
    force: Path | None = None,
    meant: Path | None = None,
    pitch_mm: float = 0.2,
    cycle_ms: float = 4.0,
    progress: Progress | None = None,
) -> PredictResult:
    """Cut the stock on the machine as diagnosed: predict.json, surface.npz and predict.html appear in `out`.

    Args:
        program: the program's main file; of several tools each is known by its frame, as the set-up has it.
        cell: the cell's folder.
        out: the folder to write into.
        calibration: the constants of its chain, by `calibrate` or `diagnose --calibration`; None: a diagnosis found none.
        diagnosis: the folder of the diagnosis that wrote the calibration: play, lag and all else that was found, and its doubt.
        setup: the set-up with the stock and the cutter; None: setup.toml beside the program.
        force: FORCE.toml, what pushes on the tool while it cuts; None: nothing does.
        meant: the program that says what the part is to be, where the targets of `program` were moved (`compensate`); None: it
            says so itself.
        pitch_mm: mm between the rays on which material is kept.
        cycle_ms: ms from row to row of the simulated run.
        progress: called with a stage and the share of it that is done, 0 to 1.

    Returns:
        The summary, the surface and the path (SI).

    Raises:
        ProgramError, CellError, LogError, SetupError, StaleInputError, InputError: input that is wrong.
        UnreachableError: a program that can't be run.

    Example:
        >>> cell, fitted = Path("cells/kr15_track_table"), Path("out/calibration.toml")
        >>> program, setup = Path("out/engraving.src"), Path("toolpaths/engraving/setup.toml")
        >>> result = camrob.predict(program, cell=cell, calibration=fitted, setup=setup, out=Path("out/part"), pitch_mm=1.0)
        >>> result.summary.p95_mm < 5.0
        True
    """
    with staged_output(out) as folder:
        asked = _Asked(Path(program), cell, calibration, diagnosis, setup, force, meant, pitch_mm, ms_to_s(cycle_ms))
        made = _predicted(asked, progress)
        _write(folder, made.summary, made.surface, made.path, player_beside(asked.program, out))
    return made


@dataclass(frozen=True, slots=True)
class _Asked:
    """What was asked for; cycle: s."""

    program: Path
    cell: Path
    calibration: Path | None
    diagnosis: Path | None
    setup: Path | None
    force: Path | None
    meant: Path | None
    pitch_mm: float
    cycle: float


def _predicted(asked: _Asked, progress: Progress | None) -> PredictResult:
    """The prediction, nothing of it written yet."""
    start = time.perf_counter()
    program, diagnosis = asked.program, asked.diagnosis
    language = language_of_file(program)
    machine = cell_for("simulate", asked.cell)
    text = language.read(program, machine.controller_section)
    found = None if asked.calibration is None else read_calibration(asked.calibration, machine)
    held = setup_for(program, asked.setup, machine)
    tools, findings = mounted_in(text, machine, held)
    stock = stock_of(held, mm_to_m(asked.pitch_mm))
    units, rest = diagnosed(diagnosis, found, asked.cell, machine)
    pushes = _forces(asked, tools)
    ran = run(text, machine, cycle=asked.cycle, progress=stage_of(progress, "simulate"))
    said = [*text.findings, *ran.findings, *findings]
    meant = text if asked.meant is None else language.read(asked.meant, machine.controller_section)
    programmed, tool_programmed = _programmed(meant, asked, machine, tools, held)
    simulated = time.perf_counter()
    base_T_part, number = np.asarray(held.base_T_part), tools.mounted[ran.motion]
    area = removed(ran.log, number, tools, stock, base_T_part) if any(f.asks_removal for f in pushes) else None
    stretches = _stretches(ran.log, number, tools, pushes, area)
    path = joined_paths([true_path(*a, found, units, rest=rest, drawn=True, **more) for a, more in stretches])
    reckoned = time.perf_counter()
    cutters = CuttersOfRun(tools.cutters, tuple(0.5 * t.runout for t in tools.tools), number, tool_programmed)
    surface = predict_surface(stock, cutters, base_T_part, path, programmed, progress=stage_of(progress, "cut"))
    _demand_cut(surface, program, asked.meant)
    part, holder = _held_to_part(held, surface, path), _held_clear(tools, stock, surface, path, progress)
    done = time.perf_counter()
    summary = PredictSummary(
        program=program.stem,
        meant="" if asked.meant is None else Path(asked.meant).name,
        cell=machine.name,
        calibration="" if asked.calibration is None else Path(asked.calibration).name,
        diagnosis="" if diagnosis is None else Path(diagnosis).name,
        pitch_mm=asked.pitch_mm,
        **size_of(surface.deviation).to_json(),
        band_mm=m_to_mm(float(np.median(surface.band))),
        band_p95_mm=m_to_mm(float(np.quantile(surface.band, 0.95))),
        likely=likely_of(surface.likely),
        percentiles_mm={str(p): m_to_mm(float(np.quantile(surface.deviation, p / 100.0))) for p in _PERCENTILES},
        causes=causes_of(surface, path, corrected=asked.meant is not None),
        rest_mm=m_to_mm(float(np.sqrt(np.mean(path.rest**2)))),
        places=places_of(surface, path, corrected=asked.meant is not None),
        regions=regions_of(surface, path, text, ran.motion),
        reckoned=surface.reckoned,
        not_met=surface.not_met,
        not_reckoned=path.not_reckoned,
        not_judged=_not_judged(tools, pushes),
        force=force_of(pushes, tools.tools, path) if pushes else None,
        part=part,
        holder=holder,
        warnings=remarks_on(program, asked.meant, held, tools.tools, pushes, surface, said),
        files=("predict.json", "surface.npz", "predict.html"),
        seconds=PredictSeconds(
            simulate=round(simulated - start, 3),
            path=round(reckoned - simulated, 3),
            cut=round(done - reckoned, 3),
            whole=round(time.perf_counter() - start, 3),
        ),
    )
    return PredictResult(summary, surface, path)


def _forces(asked: _Asked, tools: ProgramTools) -> tuple[CuttingForce, ...]:
    """What pushes on each of the program's tools; none where nothing does."""
    if asked.force is None:
        return ()
    return read_forces(asked.force).on([tool.number for tool in tools.tools], asked.program.name)


def _stretches(
    run_log: MeasurementLog,
    number: NDArray[np.int64],
    tools: ProgramTools,
    pushes: Sequence[CuttingForce],
    area: Array | None,
) -> Iterator[tuple[tuple[MeasurementLog, Cell], dict[str, Any]]]:
    """A run between two changes of tools: its rows and the cell with the tool, what pushes on that, and what it cuts."""
    for k, rows, log in by_tool(run_log, number):
        yield (
            (log, tools.cells[k]),
            {"force": pushes[k] if pushes else None, "area": None if area is None else area[rows]},
        )


def _not_judged(tools: ProgramTools, pushes: Sequence[CuttingForce]) -> tuple[str, ...]:
    """What else a real cut has."""
    what = ["wear of the tool", "chatter"]
    given = {
        CAUSE: bool(pushes),
        "run-out of the tool": all(t.runout for t in tools.tools),
        "the holder": all(t.holder for t in tools.tools),
    }
    return (*(name for name, there in given.items() if not there), *what)


def _programmed(
    text: ProgramText, asked: _Asked, machine: Cell, of_run: ProgramTools, setup: Setup
) -> tuple[Array, NDArray[np.int64]]:
    """(M, 4, 4) tool in `base` on the path that a program asks for, without any rounding; (M,) numbers of the tools, which are
    those `of_run`. Raises InputError where they are others.
    """
    exact = replace(text, blend=np.full(len(text), Blend.EXACT, np.int8))
    tools = mounted_in(text, machine, setup)[0]
    if [id(t) for t in tools.tools] != [id(t) for t in of_run.tools]:
        hint = "give the program that it was made from"
        raise InputError(f"mounts other tools than {asked.program.name}", hint=hint, path=asked.meant)
    ran = run(exact, machine, cycle=asked.cycle)
    number = tools.mounted[ran.motion]
    poses = [
        base_T_tool(tools.cells[k], tools.cells[k].to_q(log.axes(machine.axis_names)))
        for k, _rows, log in by_tool(ran.log, number)
    ]
    return np.concatenate(poses), number


def _held_to_part(setup: Setup, surface: PredictedSurface, path: TruePath) -> HeldToPart | None:
    """What the machine cuts, held to the set-up's mesh of the part, if it has one."""
    if setup.part is None or setup.part.mesh is None:
        return None
    try:
        held = against_part(surface.left, surface.real, body_triangles(setup.part), farthest=_REACH)
    except InputError as error:
        raise error.at(setup.part.mesh) from None
    if len(held.point) == 0:
        hint = "check its unit, and that it lies in the CL data's frame"
        raise SetupError(
            f"[part] {setup.part.mesh.name} lies {m_to_mm(_REACH):g} mm and more off all that is cut",
            hint=hint,
            path=setup.path,
        )
    return part_of(held, setup.part.mesh.name, path)


def _held_clear(
    tools: ProgramTools, stock: Dexels, surface: PredictedSurface, path: TruePath, progress: Progress | None
) -> tuple[HolderMeets, ...] | None:
    """Where the set-up's holders meet the stock, if it has any."""
    holders = [t.holder for t in tools.tools]
    if not any(holders):
        return None
    taken = holder_takes(stock, surface.real.moves, holders, stage_of(progress, "holder"))
    return holder_of(taken, surface.real.kept, path)


def _write(folder: Path, summary: PredictSummary, surface: PredictedSurface, path: TruePath, player: str) -> None:
    write_summary(folder / "predict.json", summary)
    arrays = {
        "points": m_to_mm(surface.point),
        "normals": surface.normal,
        "deviation": m_to_mm(surface.deviation),
        "band": m_to_mm(surface.band),
        "rounding": m_to_mm(surface.rounding),
        "causes": m_to_mm(surface.shares),
        "line": path.line[surface.row + 1],
        "cause_names": np.array([c.name for c in path.causes], dtype=np.str_),
    }
    np.savez_compressed(folder / "surface.npz", **arrays)  # type: ignore[arg-type]
    (folder / "predict.html").write_text(predict_report(summary, surface, player), encoding="utf-8")


def _demand_cut(surface: PredictedSurface, program: Path, meant: Path | None) -> None:
    if surface.reckoned == len(surface.point) and surface.reckoned + surface.not_met:
        asks = "the program asks for" if meant is None else f"{Path(meant).name} asks for"
        hint = "check that calibration and diagnosis are this machine's, and what is given as --force and --meant"
        raise InputError(f"nowhere does the machine as diagnosed cut near what {asks}", hint=hint, path=program)
    if len(surface.point) == 0:
        hint = "give the set-up that the program was posted with (--setup); check the stock's place and unit there"
        raise InputError("the program cuts nothing of the stock", hint=hint, path=program)
