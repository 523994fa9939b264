"""The diagnosis: where the gap lies, which effects cause it, and how far it shrinks without them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.errors import CellError, LogError, ProgramError, UnreachableError
from camrob.gap.conformance import effect_faults
from camrob.gap.diagnosis import Diagnosis, PathError
from camrob.gap.effects.at_their_stage import at_their_stage
from camrob.gap.effects.effect import Effect
from camrob.gap.effects.registry import library
from camrob.gap.evidence.comparison import compare
from camrob.gap.evidence.model import Model, whole_gap
from camrob.gap.evidence.shrink import trial_of
from camrob.gap.locate.axes_report import axes_report
from camrob.gap.locate.by_stage import STAGES, StageGaps, lacking, stage_gaps
from camrob.gap.locate.corners import judge_corners, with_corners
from camrob.gap.locate.drive_friction import with_friction
from camrob.gap.locate.load_from_drives import load_from_drives
from camrob.gap.locate.local_place import with_local_poses
from camrob.gap.locate.localise import (
    FURTHER,
    Segment,
    Share,
    axes_of,
    directions_of,
    lines_of,
    regimes_of,
    rms_of,
    segments_of,
)
from camrob.gap.locate.passing_times import timing_of
from camrob.gap.locate.path_standards import path_standards
from camrob.gap.long_logs import left_out_of, shortened
from camrob.gap.next_run import NextRun, next_run
from camrob.gap.observation.as_recorded import as_recorded
from camrob.gap.observation.believable import check_believable
from camrob.gap.observation.clocks import Alignment, align
from camrob.gap.observation.program_track import ProgramTrack, track_of
from camrob.gap.observation.scene import Scene
from camrob.gap.path_errors import fitted_errors, withheld_errors
from camrob.gap.pose_sets import fitted_scenes, frozen_frames, relaid_scenes, with_whole_postures, withheld_scene
from camrob.gap.rival_account import judge_accounts
from camrob.gap.states.changed_machine import shown_in, with_change
from camrob.gap.states.told import told
from camrob.gap.stood_elsewhere import moved_between, own_frame, stood_elsewhere
from camrob.gap.tool_stretches import tool_stretches
from camrob.gap.verdict.instrument_suspect import also_said, instrument_suspect
from camrob.gap.verdict.verdict import Verdict
from camrob.gap.verdict.within import tolerance_of
from camrob.kinematics.frames import base_T_tool, world_T_base
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import MeasuredFrame
from camrob.program.program_text import ProgramText
from camrob.progress import Progress, silent
from camrob.summaries.diagnosis_places import ChangePoint, Places, RunTiming, Standard, Stretch
from camrob.summaries.diagnosis_summary import DiagnosisSummary, GapFigures
from camrob.text import one_line
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["diagnose"]

Array = NDArray[np.float64]
_Function = TypeVar("_Function", bound=Callable[..., Any])

_BLOCKS = 10  # a log
_ARM = 6  # axes of the arms whose motions are planned
_SHOWN = 60  # characters of a program's name


def _one_thread(function: _Function) -> _Function:
    """Matrices here have some hundred rows: BLAS's threads gain nothing, and where other work wants the cores they wait for one
    another (84 s of processor on two busy cores, 18 s with one thread).
    """
    return cast(_Function, threadpool_limits.wrap(limits=1, user_api="blas")(function))


@_one_thread
def diagnose(
    logs: Sequence[MeasurementLog],
    cell: Cell,
    *,
    withheld: Sequence[MeasurementLog] = (),
    programs: Sequence[ProgramText | None] = (),
    withheld_programs: Sequence[ProgramText | None] = (),
    without: Sequence[str] = (),
    extra: Sequence[Effect] = (),
    progress: Progress | None = None,
) -> Diagnosis:
    """Diagnose the gap of some logs of one cell.

    withheld: logs that take no part in choosing or fitting. programs, withheld_programs: one a log, None where there is
    none; a tool that a program sets is the one whose tip was measured, and of several each on its own stretch. without: names of
    effects to leave out of the library; extra: effects that the cell brings (see `cell_effects`). Raises LogError for logs that
    can't be diagnosed, InputError for an unknown effect, CellError for an effect of the cell that breaks its promises on these
    logs.
    """
    if not logs:
        raise LogError("no log was given", hint="give at least one --log")
    tell = progress or silent
    tell("reading the gap", 0.05)
    logs, tooled, laid = _of_one_tool(logs, programs, cell)
    withheld, kept, _ = _of_one_tool(withheld, withheld_programs, cell)
    clock, held = as_recorded(logs, tooled), as_recorded(withheld, kept)
    taken, apart = shortened(clock.logs), shortened(held.logs)
    scenes = fitted_scenes(taken, tooled)
    kept_out = [withheld_scene(log, own, scenes) for log, own in zip(apart, kept, strict=True)]
    effects = _taking_part(scenes, kept_out, library(without, extra), extra)
    tracks, by_stage, timings = _laid_beside(scenes, laid)
    alignment = align([s for s in scenes if s.tracked]).later(clock.delays)
    tell("comparing effects", 0.2)
    in_world = all(f"{a}.x" not in s.places for s in scenes for a in _tables(cell))
    hidden = [e for e in effects if in_world and e.hidden_in_world]
    compared = [e for e in effects if e not in hidden]
    first = model = compare(scenes, compared)
    if (own := _own_frames(model, taken, tooled, compared)) is not None:
        first, model, scenes = own, own, own.scenes
        kept_out = [withheld_scene(own_frame(log), c, scenes) for log, c in zip(apart, kept, strict=True)]
    model, compared = with_change(model, compared)
    if relaid := relaid_scenes(model):
        scenes, model = relaid, compare(relaid, compared)
    model, effects = with_whole_postures(model), (*compared, *hidden)
    tell("withholding", 0.7)
    trial = frozen_frames(model, trial_of(model, kept_out if shown_in(kept_out, effects) else ()))
    verdict, trial = judge_accounts(model, trial, kept_out, effects, in_world=in_world)
    model = verdict.model
    tell("locating", 0.85)
    corners = judge_corners(tracks, model.noise, known=_rounding_known(effects), tolerance=tolerance_of(scenes))
    planned = next_run(model, verdict, effects)
    # the gap is what frames that fit best leave, whatever explains it
    shown = first if relaid else model
    places = _places(shown, by_stage, timings, left_out_of([*clock.logs, *held.logs], [*taken, *apart]))
    late = {s.name: d for s, d in zip((*scenes, *kept_out), (*clock.delays, *held.delays), strict=True) if d}
    said = _said(
        cell.name, without, scenes, _gap(shown), places, alignment, verdict, planned, late, moved=own is not None
    )
    said = replace(said, axes_report=with_friction(said.axes_report, [*scenes, *kept_out]))
    summary = also_said(told(with_local_poses(with_corners(said, corners), scenes)), (*clock.said, *held.said))
    tell("done", 1.0)
    return Diagnosis(
        summary,
        claimed=tuple(e.effect for e in summary.claimed),
        paths=withheld_errors(trial, verdict.shrunk),
        motions=planned.motions,
        calibration=verdict.handed.calibration,
    )


def _rounding_known(effects: Sequence[Effect]) -> bool:
    """Whether any effect works between program and set-point."""
    return any("program_to_setpoint" in e.stages for e in effects)


def _own_frames(
    model: Model, logs: Sequence[MeasurementLog], cells: Sequence[Cell], compared: Sequence[Effect]
) -> Model | None:
    """The comparison with a frame a log, where the instrument was set up anew between logs that say one; else None."""
    if not moved_between(model):
        return None
    own = compare(fitted_scenes([own_frame(log) for log in logs], cells), compared)
    return own if stood_elsewhere(model, own) else None


def _said(
    cell: str,
    without: Sequence[str],
    scenes: Sequence[Scene],
    gap: GapFigures,
    places: Places,
    alignment: Alignment,
    verdict: Verdict,
    planned: NextRun,
    late: Mapping[str, float],
    *,
    moved: bool,
) -> DiagnosisSummary:
    """All that is said of some logs, but for what lies between program and set-point."""
    return DiagnosisSummary(
        cell=cell,
        without=tuple(without),
        gap=gap,
        where=places,
        latency_s=alignment.summary,
        status=verdict.status,
        within={name: s.within for name, s in verdict.stages.items()},
        within_values={name: s.summary for name, s in verdict.stages.items()},
        effects=verdict.effects,
        together=verdict.together,
        alternatives=verdict.alternatives,
        unknown=replace(verdict.unknown, isolated_by=planned.for_unknown),
        aliases=verdict.aliases,
        residual=verdict.residual,
        next_experiment=planned.text,
        next_experiment_for=planned.about,
        logs=tuple(s.name for s in verdict.model.scenes),
        axes_report=axes_report(scenes),
        added_load=load_from_drives(scenes),
        instrument=instrument_suspect(verdict.model, verdict.effects, late, verdict.shrunk.rms_after, moved=moved),
        compensable=verdict.handed.said,
        experiment=planned.figures,
        standards=tuple(_standards(verdict.model, fitted_errors(verdict.model, verdict.members))),
    )


def _laid_beside(
    scenes: Sequence[Scene], programs: Sequence[ProgramText | None]
) -> tuple[list[ProgramTrack], list[StageGaps], list[RunTiming]]:
    """Logs laid beside their programs, where both are there, and every log's gap by stage and timing."""
    tracks, by_stage, timings = [], [], []
    for scene, program in zip(scenes, programs, strict=True):
        track, why = None, _without_program(scene)
        if program is not None and scene.setpoint is not None and not scene.poses:
            try:
                track = track_of(scene, program)
                tracks.append(track)
            except (UnreachableError, ProgramError) as error:
                why = f"the program can't be followed on this cell ({error})"
        elif program is not None:
            why = "single poses" if scene.poses else "no set-points to hold the program against"
        by_stage.append(stage_gaps(scene, track, why=why))
        timings.append(timing_of(scene, track, why))
    return tracks, by_stage, timings


def _without_program(scene: Scene) -> str:
    """Why a log has no program: it names none, or one that isn't read of itself."""
    named = one_line(scene.log.info.program, _SHOWN)
    if not named:
        return "no program"
    return f"no program, for {named}, which its .toml names, is no file beside the log: give it with --program"


def _started(effects: Sequence[Effect], lost: Mapping[str, float]) -> tuple[Effect, ...]:
    """The library, with the zeros of axes that are off by degrees where they were found."""
    zeros = {f"{axis}_deg": value for axis, value in lost.items()}
    return tuple(replace(e, start=zeros) if zeros and e.zeros else e for e in effects)


def _taking_part(
    scenes: Sequence[Scene], kept_out: Sequence[Scene], effects: Sequence[Effect], extra: Sequence[Effect]
) -> tuple[Effect, ...]:
    """The effects that are compared on some logs. Raises what `diagnose` does, of logs and of a cell's own effects."""
    check_believable(kept_out)
    of_cell = [e for e in effects if e in extra]
    shown = (*at_their_stage([e for e in effects if e not in of_cell], scenes), *of_cell)
    taken = _started(_seen_by([*scenes, *kept_out], shown), check_believable(scenes))
    for effect in extra:
        faults = effect_faults(effect, [*scenes, *kept_out])
        if faults:
            raise CellError(f"its effect {effect.name} {faults[0]}", hint="correct or remove its file")
    return taken


def _seen_by(scenes: Sequence[Scene], effects: Sequence[Effect]) -> tuple[Effect, ...]:
    """Effects that can show in some logs: without a tracker those of the drives alone. Raises LogError for logs of both kinds."""
    if all(s.tracked for s in scenes):
        return tuple(effects)
    for scene in scenes:
        if scene.tracked:
            hint = "diagnose logs with measured positions, and those without, apart"
            raise scene.log.error("has measured positions, another log has none", hint=hint, at=None)
    return tuple(e for e in effects if "setpoint_to_encoder" in e.stages)


def _tables(cell: Cell) -> list[str]:
    return [j.name for j in cell.joints if j.role is Role.WORKPIECE]


def _of_one_tool(
    logs: Sequence[MeasurementLog], programs: Sequence[ProgramText | None], cell: Cell
) -> tuple[list[MeasurementLog], list[Cell], list[ProgramText | None]]:
    """Logs of one tool each, the cells with these, and the programs; see `tool_stretches`. Where each log says when it was
    recorded they stand in that order, as what becomes another does so with time. Of logs that have none behind the last program
    none is known.
    """
    given = list(zip(logs, [*programs, *[None] * len(logs)], strict=False))
    if all(log.info.recorded for log in logs):
        given.sort(key=lambda pair: str(pair[0].info.recorded))
    parts = tool_stretches([log for log, _ in given], [program for _, program in given], cell)
    return [p.log for p in parts], [p.cell for p in parts], [p.program for p in parts]


def _rms(vectors: Sequence[Array]) -> float:
    return float(np.sqrt(np.mean(np.sum(np.concatenate(list(vectors)) ** 2, axis=1))))


def _gap(model: Model) -> GapFigures:
    """The size of the gap over all good samples."""
    good = [p.w_tcp[:, 0] > 0.0 for p in model.panels]
    gaps = [whole_gap(p)[g] for p, g in zip(model.panels, good, strict=True)]
    turned = [s.tcp_gap[s.seen[:, 3:].all(axis=1), 3:] for s in model.scenes]
    sizes = np.linalg.norm(np.concatenate(gaps), axis=1)
    return GapFigures(
        samples=int(sum(g.sum() for g in good)),
        rms_mm=m_to_mm(_rms(gaps)),
        p95_mm=m_to_mm(float(np.quantile(sizes, 0.95))),
        max_mm=m_to_mm(float(sizes.max())),
        rms_deg=rad_to_deg(_rms(turned)) if sum(len(t) for t in turned) else None,
        noise_mm=m_to_mm(model.noise),
        outliers=model.outliers,
    )


def _places(
    model: Model, by_stage: Sequence[StageGaps], timings: Sequence[RunTiming], left_out: Sequence[str]
) -> Places:
    """Where the gap lies: along the path, by stage, direction, axis, and by what it follows. left_out: said of rows."""
    mm, segments = m_to_mm, segments_of(model.panels)
    regimes, further = regimes_of(model.panels, model.noise), regimes_of(model.panels, model.noise, FURTHER)
    directions, axes = directions_of(model.panels), axes_of(model.panels)
    stages = _of_stages(by_stage, [p.w_tcp[:, 0] > 0.0 for p in model.panels])
    absent = sorted({m for one in by_stage for m in one.missing})
    return Places(
        stages={n: None if v is None else mm(v.value) for n, v in stages.items()},
        stage_intervals={n: None if v is None else (mm(v.low), mm(v.high)) for n, v in stages.items()},
        missing=(*absent, *sorted({m for s in model.scenes for m in lacking(s)}), *left_out),
        segments=tuple(_stretch(s) for s in segments),
        change_points=tuple(
            ChangePoint(log=s.log, t_s=s.from_s, line=s.from_line, step_mm=mm(s.step)) for s in segments if s.step > 0.0
        ),
        lines=tuple(_stretch(s) for s in lines_of(model.panels)),
        directions={k: mm(v.value) for k, v in directions.items()},
        direction_intervals={k: (mm(v.low), mm(v.high)) for k, v in directions.items()},
        axes={k: v.value for k, v in axes.items()},
        axis_intervals={k: (v.low, v.high) for k, v in axes.items()},
        regimes={k: v.share for k, v in regimes.items()},
        regime_intervals={k: v.interval for k, v in (regimes | further).items()},
        further_regimes={k: v.share for k, v in further.items()},
        timing=tuple(timings),
    )


def _stretch(s: Segment) -> Stretch:
    """A stretch in mm."""
    return Stretch(
        log=s.log,
        from_line=s.from_line,
        to_line=s.to_line,
        from_s=s.from_s,
        to_s=s.to_s,
        samples=s.samples,
        rms_mm=m_to_mm(s.rms),
        contour_mm=m_to_mm(s.contour),
        tangential_mm=m_to_mm(s.tangential),
    )


def _of_stages(by_stage: Sequence[StageGaps], good: Sequence[NDArray[np.bool_]]) -> dict[str, Share | None]:
    """rms in m of every stage over all logs' good samples, with its interval; None where any log lacks it."""
    out: dict[str, Share | None] = {}
    for name in STAGES:
        parts = [getattr(one, name) for one in by_stage]
        blocks = [k * _BLOCKS + (np.arange(len(g)) * _BLOCKS) // len(g) for k, g in enumerate(good)]
        absent = any(p is None for p in parts)
        out[name] = None if absent else rms_of(*([x[g] for x, g in zip(y, good, strict=True)] for y in (parts, blocks)))
    return out


def _standards(model: Model, paths: Sequence[PathError]) -> list[Standard]:
    """ISO 9283 and ISO 230-4 of the logs that are a line or a circle over the part."""
    out = []
    for p, path in zip(model.panels, paths, strict=True):
        if p.scene.poses:
            continue
        good = np.flatnonzero(p.w_tcp[:, 0] > 0.0)
        cell = p.scene.cell
        commanded = (
            p.scene.log.setpoints(p.scene.axes) if p.scene.setpoint is not None else p.scene.log.axes(p.scene.axes)
        )
        q = cell.to_q(commanded[good])
        part = base_T_tool(cell, q)[:, :3, 3]
        turn = np.asarray(p.scene.frames.left[:3, :3])
        if p.scene.log.info.measured_frame is not MeasuredFrame.BASE:
            turn = turn @ world_T_base(cell, q)[:, :3, :3]
        before, after = (
            np.einsum("...ji,...j->...i", turn, e) for e in (np.asarray(path.before), np.asarray(path.after))
        )
        found = path_standards(path.log, part, before, after)
        if found is not None:
            out.append(found)
    return out
