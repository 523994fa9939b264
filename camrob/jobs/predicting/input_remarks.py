"""What is said of the files that a prediction was asked for with: where its figures mean less than they seem to."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from camrob.cell.setup import Setup, ToolSetup
from camrob.findings import Finding, collapse
from camrob.jobs.release.beside import said_to_be_compensated
from camrob.prediction.force_model import CuttingForce, Milling
from camrob.prediction.surface import PredictedSurface
from camrob.summaries.remarks import Remark
from camrob.units import m_to_mm

__all__ = ["remarks_on"]

_SAME = 1e-3  # of a diameter or a speed that is stated twice
_MINUTE = 60.0  # s


def remarks_on(
    program: Path,
    meant: Path | None,
    setup: Setup,
    tools: Sequence[ToolSetup],
    pushes: Sequence[CuttingForce],
    surface: PredictedSurface,
    findings: Sequence[Finding],
) -> tuple[Remark, ...]:
    """All that is said, of the program's own findings last."""
    own = tuple(Remark(line=f.line, code=f.code, text=f.text, count=f.count) for f in collapse(list(findings)))
    asked = (*_moved_on_purpose(program, meant), *_assumed(setup), *_other_tool(setup, tools, pushes))
    return (*asked, *_hardly_met(surface), *own)


def _moved_on_purpose(program: Path, meant: Path | None) -> tuple[Remark, ...]:
    """What a figure held to a compensated program's own targets is not."""
    said = "" if meant is not None else said_to_be_compensated(program)
    if not said:
        return ()
    text = (
        f"{said} says that the program is compensated: held to its own targets, which were moved, the part is off by as much as "
        "was taken off; give the program that it was made from as --meant"
    )
    return (Remark(line=0, code="compensated", text=text, count=1),)


def _other_tool(setup: Setup, tools: Sequence[ToolSetup], pushes: Sequence[CuttingForce]) -> tuple[Remark, ...]:
    """Where a force is that of another cutter or speed than the set-up's."""
    found = (
        [
            f"{push.path.name} has {what}"
            for push, tool in zip(pushes, tools, strict=True)
            if isinstance(push.model, Milling)
            for what in _other_cutter(push.model, tool, setup.spindle_rpm)
        ]
        if pushes
        else []
    )
    return tuple(Remark(line=0, code="force-of-another", text=text, count=1) for text in found)


def _other_cutter(model: Milling, tool: ToolSetup, spindle_rpm: float | None) -> Iterator[str]:
    """In what a force is of another cutter or speed."""
    if tool.diameter and abs(model.diameter - tool.diameter) > _SAME * tool.diameter:
        yield f"a cutter of {m_to_mm(model.diameter):g} mm, and the set-up one of {m_to_mm(tool.diameter):g}"
    turns = model.rate * _MINUTE
    if spindle_rpm and abs(turns - spindle_rpm) > _SAME * spindle_rpm:
        yield f"{turns:g} turns a minute, and the set-up {spindle_rpm:g}"


def _hardly_met(surface: PredictedSurface) -> tuple[Remark, ...]:
    """Where figures are reckoned rather than cut, or speak of a part of the surface."""
    all_of, out = len(surface.point) + surface.not_met, []
    if 2 * surface.reckoned > all_of:
        share = 100.0 * surface.reckoned / all_of
        text = (
            f"on {share:.0f} % of the surface the machine as diagnosed cuts so far off that no ray meets the same wall: "
            "what is said there is reckoned from the causes"
        )
        out.append(Remark(line=0, code="reckoned", text=text, count=1))
    if 2 * surface.not_met > all_of:
        share = 100.0 * surface.not_met / all_of
        text = f"{share:.0f} % of the surface has no counterpart on the program's exact path: the figures are those of the rest"
        out.append(Remark(line=0, code="hardly-met", text=text, count=1))
    return tuple(out)


def _assumed(setup: Setup) -> tuple[Remark, ...]:
    """What stock was made up, if the set-up names none."""
    if setup.stock is not None:
        return ()
    text = "the set-up names no [stock]: a block as large as its part is cut"
    return (Remark(line=0, code="assumed-stock", text=text, count=1),)
