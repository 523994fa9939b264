"""`camrob post`: a CL file in, a verified program out."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.check.collision_report import CollisionReport
from camrob.check.collisions import check_collisions
from camrob.check.margins import MarginReport, check_margins
from camrob.controller.against import Coverage, cover
from camrob.controller.intended import hold_to_intended
from camrob.controller.judge import Judgement, judge
from camrob.controller.replay import Replay, replay
from camrob.controller.trace import posture_trace
from camrob.errors import CollisionError, InputError, JobError, KrlError, VerificationError
from camrob.feed.timing import program_time
from camrob.issues import Finding, Severity, collapse
from camrob.jobs.files import staged_output
from camrob.jobs.inputs import JobInputs, program_name, read_inputs
from camrob.jobs.summary import post_summary
from camrob.post.assemble import assemble_program
from camrob.post.decimate import decimated
from camrob.post.krl_program import KrlProgram
from camrob.post.krl_reader import read_krl
from camrob.post.krl_writer import iter_krl
from camrob.post.program import Program
from camrob.resolve.path import ToolPathInBase
from camrob.resolve.solution import Solution
from camrob.resolve.tracker import track
from camrob.resolve.vjm import resolve_vjm
from camrob.units import m_to_mm

__all__ = ["PostResult", "post"]

Array = NDArray[np.float64]
Progress = Callable[[str, float], None]

COMPARED = 20_000  # points up to which the report shows the path resolved in other ways beside
TRACKING_TOLERANCE = 1e-9  # m and rad: the solver's promise before rounding, 1e-6 mm and 1e-6 rad


@dataclass(frozen=True, slots=True)
class PostResult:
    """What a post made: `files` in `out`, the JSON summary, all findings, and the data behind them."""

    summary: Mapping[str, Any]
    findings: tuple[Finding, ...]
    out: Path
    files: tuple[str, ...]
    path: ToolPathInBase
    solution: Solution
    program: Program


def post(
    clfile: Path,
    *,
    cell: Path,
    out: Path,
    setup: Path | None = None,
    name: str | None = None,
    method: str = "vjm",
    feed: str = "program",
    max_lines: int | None = None,
    dialect: str | None = None,
    units: str | None = None,
    report: bool = True,
    progress: Progress | None = None,
) -> PostResult:
    """Post a CL file for a cell: NAME.src, .dat, .json, .path.npz and .html appear in `out`, all or none.

    The program is read back from its text and replayed before it is released: every CL point met in order within
    0.01 mm and 0.01 degrees, within limits, away from singular postures and collisions. Raises InputError and its kin
    for wrong input and JobError and its kin where the job can't be done safely; nothing is left behind then.
    """
    clfile, out = Path(clfile), Path(out)
    watch = _Watch(progress)
    title = program_name(clfile, name)
    _check_choices(method, feed)
    with watch.stage("read"):
        inputs = read_inputs(clfile, cell, setup, dialect=dialect, units=units, progress=watch.share)
    with watch.stage("resolve"):
        solution = _resolve(inputs, method, watch.share)
        position, axis = solution.residual(inputs.cell, inputs.path)
        if max(position.max(initial=0.0), axis.max(initial=0.0)) > TRACKING_TOLERANCE:
            raise VerificationError(
                f"the solver strays by {m_to_mm(float(position.max())):.2e} mm; please report this file"
            )
    with watch.stage("feed"):
        keep = decimated(inputs.path, solution, inputs.setup.decimate)
        speed, times = _speeds(inputs, solution, feed)
        program = assemble_program(
            title, inputs.cell, inputs.toolpath, inputs.path, solution,
            rapid_speed=inputs.rapid_speed, keep=keep, speed=speed, comment=_comment(inputs, method),
        )  # fmt: skip
    with staged_output(out, name=title) as folder:
        with watch.stage("write"):
            files, split = _write(program, inputs, folder, max_lines)
        with watch.stage("verify"):
            text, replayed, coverage, judgement = _verify(folder / f"{title}.src", program, inputs, watch.share)
        with watch.stage("collisions"):
            collisions = _collisions(text, replayed, coverage, inputs, watch.share)
        margins = _margins(inputs, solution)
        findings = _gate(inputs, solution, judgement, collisions, margins, split)
        files += [f"{title}.json", f"{title}.path.npz", *([f"{title}.html"] if report else [])]
        _save_path(folder / f"{title}.path.npz", inputs, solution)
        summary = post_summary(
            inputs, solution, program, coverage, judgement, collisions, margins, findings,
            residual=(position, axis), times=times, seconds=watch.seconds, files=files,
        )  # fmt: skip
        if report:
            with watch.stage("report"):
                _report(folder / f"{title}.html", summary, inputs, solution, findings, method)
        summary["seconds"] = dict(watch.seconds)
        (folder / f"{title}.json").write_text(json.dumps(summary, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    return PostResult(summary, tuple(findings), out, tuple(files), inputs.path, solution, program)


class _Watch:
    """Names the stage that runs to whoever shows progress, and keeps how long each took."""

    def __init__(self, progress: Progress | None) -> None:
        self._progress = progress
        self._name = ""
        self._note = " (compiling, this once)" if kernels_missing() else ""
        self.seconds: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Any:
        """Time one stage."""
        self._name = name + self._note
        self.share(0.0)
        start = time.perf_counter()
        yield
        self.seconds[name] = round(time.perf_counter() - start, 3)

    def share(self, done: float) -> None:
        """How much of the stage is done, 0 to 1."""
        if self._progress is not None:
            self._progress(self._name, done)


def _check_choices(method: str, feed: str) -> None:
    if method not in METHODS:
        raise InputError(f"--method {method!r} is unknown", cure=f"use {' or '.join(METHODS)}")
    if feed not in FEEDS:
        raise InputError(f"--feed {feed!r} is unknown", cure=f"use {' or '.join(FEEDS)}")


def _resolve(inputs: JobInputs, method: str, progress: Callable[[float], None]) -> Solution:
    try:
        return METHODS[method](inputs.cell, inputs.path, progress=progress)
    except JobError as e:
        raise _named(e, inputs) from None


def _named(error: JobError, inputs: JobInputs) -> JobError:
    """The same error with the region's name instead of its index."""
    regions = [r for r in inputs.toolpath.regions if len(r)]
    if not error.region.isdigit() or int(error.region) >= len(regions):
        return error
    return type(error)(
        error.what, line=error.line, region=regions[int(error.region)].name, axis=error.axis, value=error.value,
        limit=error.limit, unit=error.unit, reasons=error.reasons,
    )  # fmt: skip


METHODS: dict[str, Callable[..., Solution]] = {"vjm": resolve_vjm}
FEEDS = ("program",)


def _speeds(inputs: JobInputs, solution: Solution, feed: str) -> tuple[Array | None, dict[str, float | None]]:
    """Speeds (N,) that replace the programmed feed, or None, and the program's times as it stands and at its best."""
    path = inputs.path
    programmed = np.where(path.cutting, path.feed, inputs.rapid_speed)
    timing = program_time(inputs.cell, path, np.asarray(solution.q), speed=programmed)
    return None, {"program": float(timing.total), "optimal": None}


def _comment(inputs: JobInputs, method: str) -> tuple[str, ...]:
    toolpath = inputs.toolpath
    return (
        f"made by camrob from {toolpath.source} ({toolpath.dialect})",
        f"sha256 {toolpath.sha256}",
        f"cell {inputs.cell.name}, method {method}, {toolpath.points} points",
    )


def _write(program: Program, inputs: JobInputs, folder: Path, max_lines: int | None) -> tuple[list[str], list[Finding]]:
    names: list[str] = []
    findings: list[Finding] = []
    for file, data in iter_krl(program, inputs.cell.controller, max_lines=max_lines, findings=findings):
        (folder / file).write_bytes(data)
        names.append(file)
    return names, findings


def _verify(
    source: Path, program: Program, inputs: JobInputs, progress: Callable[[float], None]
) -> tuple[KrlProgram, Replay, Coverage, Judgement]:
    """Read the program's own text back, replay it, and hold it to the CL points and to what was meant."""
    try:
        text = read_krl(source)
        replayed = replay(text, inputs.cell, progress=progress)
    except KrlError as error:
        raise VerificationError(f"the program was not released: it reads back wrong: {error.what}") from None
    path = inputs.path
    own = path.of_toolpath
    coverage = cover(
        np.asarray(path.base_T_tip)[own], path.line[own], np.asarray(path.region[own], np.int64),
        np.asarray(replayed.base_T_tool), np.asarray(text.kind), chord_tolerance=inputs.setup.decimate,
    )  # fmt: skip
    speed = np.where(path.cutting[own], path.feed[own], np.nan)
    judgement = judge(text, replayed, coverage, speed)
    stands_against = [*judgement.findings, *hold_to_intended(text, replayed, program)]
    first = next((f for f in stands_against if f.severity is Severity.ERROR), None)
    if first is not None:
        raise VerificationError(
            f"the program was not released: {first.text}" + (f" ({first.count} times)" if first.count > 1 else ""),
            line=first.line, axis=first.axis, value=first.value, limit=first.limit, unit=first.unit,
        )  # fmt: skip
    return text, replayed, coverage, judgement


def _collisions(
    text: KrlProgram, replayed: Replay, coverage: Coverage, inputs: JobInputs, progress: Callable[[float], None]
) -> CollisionReport:
    """Collisions along the replayed program, void motions included."""
    postures, rows = posture_trace(text, replayed)
    line = np.zeros(len(text), np.int64)
    cutting = np.zeros(len(text), bool)
    region = np.full(len(text), -1, np.int64)
    own = inputs.path.of_toolpath
    met = coverage.motion
    line[met], cutting[met], region[met] = inputs.path.line[own], inputs.path.cutting[own], inputs.path.region[own]
    return check_collisions(
        replayed.cell, postures, cutting=cutting[rows], line=line[rows], region=region[rows],
        part_mesh=inputs.part, stock_mesh=inputs.stock, base_T_part=np.asarray(inputs.setup.base_T_part),
        tool=inputs.tool, progress=lambda done, of: progress(done / of),
    )  # fmt: skip


def _margins(inputs: JobInputs, solution: Solution) -> MarginReport:
    path = inputs.path
    return check_margins(
        inputs.cell,
        np.asarray(solution.q),
        inv_kf=solution.inv_kf,
        cutting=path.cutting,
        line=path.line,
        region=path.region,
    )


def _gate(
    inputs: JobInputs, solution: Solution, judgement: Judgement, collisions: CollisionReport, margins: MarginReport,
    split: list[Finding],
) -> list[Finding]:  # fmt: skip
    """All findings, or the error that stops the release."""
    if collisions.count:
        first = next(f for f in collisions.findings if f.severity is Severity.ERROR)
        error = CollisionError(f"{first.text} ({collisions.count} points)", line=first.line, region=str(first.region))
        raise _named(error, inputs)
    findings = collapse(
        [
            *inputs.toolpath.findings,
            *inputs.findings,
            *solution.findings,
            *margins.findings,
            *judgement.findings,
            *collisions.findings,
            *split,
        ]
    )
    stopped = next((f for f in findings if f.severity is Severity.ERROR), None)
    if stopped is not None:
        raise VerificationError(stopped.text, line=stopped.line)
    return findings


def _save_path(file: Path, inputs: JobInputs, solution: Solution) -> None:
    own = inputs.path.of_toolpath
    q = np.asarray(solution.q)[own]
    np.savez(
        file,
        q=q,
        axes=np.array(inputs.cell.names),
        axis_values=inputs.cell.to_axis_values(q),
        axis_names=np.array(inputs.cell.axis_names),
        line=inputs.path.line[own],
        region=inputs.path.region[own],
        inv_kf=np.asarray(solution.inv_kf)[own],
        s=m_to_mm(inputs.path.length[own]),
    )


def _report(
    file: Path, summary: Mapping[str, Any], inputs: JobInputs, solution: Solution, findings: list[Finding], method: str
) -> None:
    import trimesh

    from camrob.report.post_report import post_report

    comparison = _comparison(inputs) if method == "vjm" and len(inputs.path) <= COMPARED else {}
    body = inputs.part if inputs.part is not None else inputs.stock
    mesh = None if body is None else trimesh.Trimesh(**trimesh.triangles.to_kwargs(body))
    page = post_report(
        summary, inputs.cell, inputs.path, solution, findings=findings, part_mesh=mesh,
        base_T_part=np.asarray(inputs.setup.base_T_part), comparison=comparison,
    )  # fmt: skip
    file.write_text(page, encoding="utf-8")


def _comparison(inputs: JobInputs) -> dict[str, Array]:
    """1/k_F of the same path without fuzzy weights, and without revision; a way that fails is left out."""
    others = {}
    for name, fuzzy, revise in (("all weights alike", False, True), ("without revision", True, False)):
        with suppress(JobError):
            others[name] = np.asarray(resolve_vjm(inputs.cell, inputs.path, fuzzy=fuzzy, revise=revise).inv_kf)
    return others


def kernels_missing() -> bool:
    """True where the solver's kernels have yet to be compiled on this machine, which takes a minute, once."""
    cache = track._cache.cache_path  # Numba has no public way to ask
    return not any(Path(cache).glob("tracker.track-*.nbi"))
