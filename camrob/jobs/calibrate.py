"""`camrob calibrate`: a cell's error parameters from measured poses."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from camrob.calibrate.calibrate import calibrate_cell
from camrob.calibrate.calibration import Calibration
from camrob.calibrate.calibration_file import calibration_summary, calibration_text
from camrob.calibrate.measurements import measurements_of
from camrob.calibrate.terms import standard_names
from camrob.cell.read_cell import read_cell
from camrob.controller.replay import replay
from camrob.errors import InputError
from camrob.jobs.files import check_file_name, staged_output
from camrob.jobs.measuring import plan_measuring
from camrob.measure.log_info import MeasuredFrame
from camrob.measure.read_log import read_log
from camrob.post.krl_reader import read_krl

__all__ = ["CalibrateResult", "calibrate"]


@dataclass(frozen=True, slots=True)
class CalibrateResult:
    """The calibration and its summary as JSON."""

    calibration: Calibration
    summary: Mapping[str, Any]


def calibrate(
    measured: Path,
    *,
    cell: Path,
    out: Path,
    withheld: Path | None = None,
    parameters: Sequence[str] = (),
    harmonics: int = 0,
    share: float = 0.2,
    poses: int = 0,
    path: Path | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> CalibrateResult:
    """Calibrate a cell from a log and write CALIBRATION.toml.

    parameters: names to fit, all of them or none; without, the standard ones with `harmonics` orders of gear ripple,
    as far as the poses tell them. withheld: a log whose poses take no part; without, a share of the poses.
    poses: how many to measure next are wanted, as a KRL program NAME_poses.src beside the file, chosen for the accuracy
    on the program `path`, else on the poses measured. Raises CellError, LogError and KrlError (input), SingularError
    and JobError (a fit that can't be had honestly), CollisionError (no poses that can be visited).
    """
    start = time.perf_counter()

    def tell(stage: str, done: float) -> None:
        if progress is not None:
            progress(stage, done)

    if out.suffix.lower() != ".toml":
        raise InputError(f"{out.name!r} is no .toml", cure="name the file CALIBRATION.toml", path=out)
    check_file_name(out.name)
    if not 0.0 <= share < 1.0:
        raise InputError(f"a share of {share:g} can't be withheld", cure="give a number from 0 to below 1")
    machine = read_cell(cell)
    tell("read", 0.1)
    log = read_log(Path(measured))
    data = measurements_of(log, machine)
    other = measurements_of(read_log(Path(withheld)), machine) if withheld is not None else None
    names: Sequence[str] | None = tuple(dict.fromkeys(parameters)) or None
    extra = harmonics if names is None else 0
    standard = standard_names(machine, table=log.info.measured_frame is MeasuredFrame.BASE, harmonics=extra)
    tell("fit", 0.3)
    calibration = calibrate_cell(
        machine, data, names=names, candidates=standard, withheld=other, share=0.0 if other is not None else share
    )
    tell("write", 0.9)
    summary = {**calibration_summary(calibration), "file": out.name}
    files: Mapping[str, bytes] = {}
    if poses > 0:
        way = np.asarray(data.q if path is None else replay(read_krl(Path(path)), machine).q)
        plan = plan_measuring(machine, data, standard, way, poses, f"{_program_stem(out)}_poses")
        files, summary["next"] = plan.files, dict(plan.summary)
    with staged_output(out.parent) as folder:
        (folder / out.name).write_text(calibration_text(calibration), encoding="utf-8")
        for name, content in files.items():
            (folder / name).write_bytes(content)
    summary["seconds"] = time.perf_counter() - start
    return CalibrateResult(calibration, summary)


def _program_stem(out: Path) -> str:
    """A name for a KRL program, after a file's."""
    plain = re.sub(r"\W+", "_", out.stem, flags=re.ASCII).strip("_")
    return plain[:18] if plain[:1].isalpha() else f"P_{plain[:16]}"
