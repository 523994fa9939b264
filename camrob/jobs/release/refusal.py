"""What is said of a program that was not released: its text is not kept, so the CL file's lines are named, and what to do."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from camrob.errors import JobError, ProgramError, VerificationError
from camrob.findings import Finding
from camrob.program.language import Language
from camrob.program.program import Program
from camrob.program.program_text import ProgramText
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["advice", "as_hurried", "as_planned", "but_to_plan", "past_limit", "refusal", "refusal_unread"]

_PLAN = " or post with --method planned"
_ELSEWHERE = "place the part elsewhere (camrob place)"
_PLACE = f"{_ELSEWHERE}{_PLAN}"
_ADVICE = {
    "axis-limit": _PLACE,
    "axis-jump": _PLACE,
    "axis-speed": f"lower the feed there, post with --feed optimal, or {_PLACE}",
    "collision": f"{_PLACE}, or raise clearance_mm in setup.toml",
    "collision-in-cut": f"{_PLACE}, or cut there with a longer or slimmer tool",
    "ends-running": "let the cell's footer switch off what its hooks switch on, or end the file with SPINDL/OFF and COOLNT/OFF",
    "hole-onto-bottom": "name a larger clearance in the file's cycle (Q200, DIS1)",
    "jump": _PLACE,
    "out-of-reach": _PLACE,
    "ptp-unreachable": _PLACE,
    "singular": _PLACE,
    "table-in-cut": _PLACE,
}
_FAULT = "that is an error in camrob or in the cell's description: check poses.csv, and report this file"


def advice(code: str) -> str:
    """What to do about a finding that stops the release."""
    return _ADVICE.get(code, _FAULT)


def as_planned(error: JobError) -> JobError:
    """The error for a job that was posted with --method planned: that is no advice any more."""
    return error.but(but_to_plan(error.what))


def as_hurried(error: JobError, seconds: float) -> JobError:
    """The error for a plan whose time was over before it was made fit: what stands against it may be for want of that."""
    what = f"give --seconds more or leave it out, for the {seconds:g} s ended before the plan was made fit"
    if _ELSEWHERE not in error.what:
        return error.but(f"{error.what}; {what}")
    return error.but(error.what.replace(_ELSEWHERE, f"{what}, or else {_ELSEWHERE}"))


def but_to_plan(text: str) -> str:
    """Advice without --method planned: of a job that was."""
    return text.replace(_PLAN, "")


def past_limit(error: VerificationError) -> float:
    """rad or m by which an axis passes its limit between two points, where that stopped the release; else 0."""
    known = {"degrees": deg_to_rad, "mm": mm_to_m}
    if not error.axis or error.value is None or error.limit != 0.0 or error.unit not in known:
        return 0.0
    return float(known[error.unit](error.value))


def refusal(finding: Finding, program: Program, text: ProgramText | None) -> VerificationError:
    """The error for what stands against a program; `text` is what the finding's line is of, None for one of the CL file's."""
    line, region = finding.line, finding.region
    if text is not None:
        line, region = _cl_place(program, _row(finding, text))
    times = f" ({finding.count} times)" if finding.count > 1 else ""
    return VerificationError(
        f"the program was not released: {finding.text}{times}; {advice(finding.code)}",
        line=line,
        region=str(region) if region >= 0 else "",
        axis=finding.axis,
        value=finding.value,
        limit=finding.limit,
        unit=finding.unit,
    )


def refusal_unread(error: ProgramError, source: Path, program: Program, language: Language) -> VerificationError:
    """The error for a program whose text, `source` with the parts beside it, could not be read back."""
    row, statement = 0, ""
    for file in [source, *sorted(p for p in source.parent.glob(f"*{source.suffix}") if p != source)]:
        for number, written in enumerate(file.read_text(encoding="ascii", errors="replace").splitlines(), start=1):
            if error.path is not None and file.name == error.path.name and number == error.line:
                statement = written
                break
            row += language.targets(written)
        if statement:
            break
    line, region = _cl_place(program, row) if statement else (0, -1)
    at = f" at {statement!r}" if statement else ""
    return VerificationError(
        f"the program was not released: it reads back wrong: {error.what}{at}; {_FAULT}",
        line=line,
        region=str(region) if region >= 0 else "",
    )


def _row(finding: Finding, text: ProgramText) -> int:
    """The motion that a finding on a program's text is about; -1 where it is about none."""
    if finding.point >= 0 or finding.line <= 0:
        return finding.point
    later = np.flatnonzero(np.asarray(text.line) >= finding.line)
    return int(later[0]) if len(later) else len(text) - 1


def _cl_place(program: Program, row: int) -> tuple[int, int]:
    """CL line and region of a motion; camrob's own take those of the last one before them that has a line, or of the first."""
    line = np.asarray(program.line)
    named = np.flatnonzero(line > 0)
    if row < 0 or not len(named):
        return 0, -1
    at = int(named[max(int(np.searchsorted(named, row, side="right")) - 1, 0)])
    return int(line[at]), int(program.region[at])
