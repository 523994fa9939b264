"""Axis by axis what lies between set-point and encoder, and between motor and link, as a table and in words: read off the log."""

from __future__ import annotations

from collections.abc import Iterator

from camrob.report.diagnosis.numbers import measure, mm, share
from camrob.report.page.html import escape
from camrob.report.page.parts import section, table
from camrob.summaries.diagnosis_places import AxisError
from camrob.summaries.diagnosis_summary import DiagnosisSummary, EffectFound

__all__ = ["drive_follows", "drive_text", "drives_section", "drives_texts"]

_DRIVE, _NOTHING = "setpoint_to_encoder", "constant"
_MOST = 3  # axes that are said in words
_BESIDE = 0.2  # of the farthest axis's rms at the tool, from which another is said beside it
_SAME = (
    "In the log both ends of every axis are the same, digit by digit: none is off, or one was copied from the other."
)
_WORTH_MM = 0.001  # rms at the tool of which a line is worth something


def drives_texts(summary: DiagnosisSummary) -> list[str]:
    """In words, a stage each, the axes that are farthest off and beyond their noise; [] where none is."""
    said = []
    for stage, rows in _stages(summary):
        # what follows nothing is an encoder's noise
        off = sorted((r for r in rows if r[1].rms_mm >= _WORTH_MM and _followed(r[1])), key=lambda r: -r[1].rms_mm)
        off = [r for r in off if not r[2] and r[1].rms_mm >= _BESIDE * off[0][1].rms_mm]
        if off:
            said.append(f"{stage}: " + "; ".join(f"{axis} {_size(e)}{_followed(e)}" for axis, e, _ in off[:_MOST]))
    return said


def drives_section(summary: DiagnosisSummary) -> str:
    """The page's table of all axes of which both ends are logged; "" where no log has both."""
    rows = [
        [
            escape(axis),
            stage,
            escape(measure(e.rms, _unit(e))),
            escape(measure(e.worst, _unit(e))),
            escape(mm(e.rms_mm)),
            escape(_followed(e).removeprefix(", follows ") or "nothing")
            + (f" (within the {within})" if within else ""),
        ]
        for stage, errors in _stages(summary)
        for axis, e, within in errors
    ]
    if rows and all(error.worst == 0.0 for _, errors in _stages(summary) for _, error, _ in errors):
        return section("Axis by axis, read off the log", f"<p>{_SAME}</p>")
    head = ("axis", "between", "rms", "worst", "rms at the tool", "follows")
    return section("Axis by axis, read off the log", table(head, rows, left=2)) if rows else ""


def drive_text(summary: DiagnosisSummary, entry: EffectFound) -> str:
    """Beside a claim on one axis's drive, what its log shows of it where that follows the same; "" for nothing."""
    if len(entry.axes) != 1 or entry.stages != (_DRIVE,):
        return ""
    error = _drive(summary, entry.axes[0])
    if error is None or error.pattern.follows not in entry.regimes:
        return ""
    return f"; the log shows {entry.axes[0]} {mm(error.rms_mm)} rms off at the tool{_which(error)}"


def drive_follows(summary: DiagnosisSummary, axis: str) -> str:
    """What the error of an axis's drive follows, after its size; "" for nothing or where none is logged."""
    error = _drive(summary, axis)
    return f"{_which(error)}" if error and error.pattern.follows != _NOTHING else ""


def _which(error: AxisError) -> str:
    return _followed(error).replace(", follows", ", which follows")


def _drive(summary: DiagnosisSummary, axis: str) -> AxisError | None:
    """An axis's error between set-point and encoder."""
    report = summary.axes_report.get(axis)
    d = None if report is None else report.drive
    if d is None:
        return None
    return AxisError(unit=d.unit, rms=d.rms, worst=d.worst, mean=d.mean, rms_mm=d.rms_mm, pattern=d.pattern)


def _stages(summary: DiagnosisSummary) -> Iterator[tuple[str, list[tuple[str, AxisError, str]]]]:
    """Each stage's name, and of each axis its error and what that is within, "" for nothing."""
    reports = summary.axes_report.items()
    drives = [
        (
            axis,
            error,
            r.drive.within,
        )
        for axis, r in reports
        if r.drive is not None and (error := _drive(summary, axis)) is not None
    ]
    if drives:
        yield "set-point to encoder", drives
    gears = [(axis, r.motor_to_link, "") for axis, r in reports if r.motor_to_link is not None]
    if gears:
        yield "motor to link", gears


def _unit(error: AxisError) -> str:
    return "degrees" if error.unit == "deg" else error.unit


def _size(error: AxisError) -> str:
    return f"{measure(error.rms, _unit(error))} rms ({mm(error.rms_mm)} at the tool)"


def _followed(error: AxisError) -> str:
    """What an error follows most, with the share of its energy; "" for nothing."""
    pattern = error.pattern
    if pattern.follows == _NOTHING:
        return ", a constant" if error.mean**2 > 0.5 * error.rms**2 else ""
    every = f" every {measure(pattern.period, _unit(error))}" if pattern.period else ""
    return f", follows {pattern.follows}{every} ({share(pattern.share)})"
