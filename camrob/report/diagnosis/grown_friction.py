"""What friction takes of the drives' torques or currents, in words: whether it has grown, where, and what to do first."""

from __future__ import annotations

from camrob.report.diagnosis.numbers import measure, share, sure
from camrob.report.page.html import escape
from camrob.report.page.parts import section, table
from camrob.summaries.diagnosis_places import AxisFriction
from camrob.summaries.diagnosis_summary import LIKELY, DiagnosisSummary
from camrob.text import printable

__all__ = ["friction_first", "friction_section", "friction_texts", "friction_what", "friction_where"]

_MOST = 3  # axes that are named
_EFFECT = "friction"  # of the library: the same axis's drive falls behind by it


def _grown(summary: DiagnosisSummary) -> dict[str, AxisFriction]:
    """Axes whose friction has likely grown, the surest first."""
    found = {a: r.friction for a, r in summary.axes_report.items() if r.friction is not None}
    likely = {a: f for a, f in found.items() if f.grown >= LIKELY}
    return dict(sorted(likely.items(), key=lambda item: (-item[1].grown, -(item[1].times or 0.0))))


def friction_what(summary: DiagnosisSummary) -> str:
    """That an axis's friction has grown, how sure, and by how much against which log; "" where none has."""
    said = []
    for axis, f in list(_grown(summary).items())[:_MOST]:
        times, at = f"{f.times or 1.0:.2g} times", measure(f.speed, _speed(f))
        if f.against:
            sizes = f"{measure(f.by_log[f.against], f.unit)} and {_size(f)} at {at}"
            said.append(
                f"Friction of {axis} takes {times} the {_kind(f)} in {f.log} that it does in {f.against}, beside what the other "
                f"axes' does ({sure(f.grown)} sure that it has grown; {sizes})"
            )
        else:
            said.append(
                f"Friction of {axis} takes {times} the {_kind(f)} that the other axes' lets expect ({sure(f.grown)} sure that it "
                f"has grown; {_size(f)} at {at})"
            )
    return printable("".join(f" {words}." for words in said))


def friction_where(summary: DiagnosisSummary) -> str:
    """Where grown friction sits; "" for nowhere."""
    axes = list(_grown(summary))[:_MOST]
    return f" Friction: motor, brake or gear of {', '.join(axes)}." if axes else ""


def friction_first(summary: DiagnosisSummary) -> str:
    """What to do about grown friction first; "" for nothing, and where the same is claimed of the drive's path."""
    claimed = {a for e in summary.claimed if e.effect == _EFFECT for a in e.axes}
    axes = [a for a in _grown(summary) if a not in claimed][:_MOST]
    if not axes:
        return ""
    return (
        f"for friction of {', '.join(axes)}: whether the brake drags (by ear, by hand), hoses, seals, oil or grease of the gear; "
        "then log the axis alone, as warm as in the log that it is held to"
    )


def friction_texts(summary: DiagnosisSummary) -> list[str]:
    """What friction takes of each drive, for a line or two; [] where no log tells it."""
    found = {a: r.friction for a, r in summary.axes_report.items() if r.friction is not None}
    if not found:
        return []
    first = next(iter(found.values()))
    sizes = ", ".join(f"{a} {_size(f)} ({share(f.share)})" for a, f in found.items())
    out = [f"friction by the {first.source}, at each axis's usual speed, and its share of the motor's work: {sizes}"]
    if len(first.by_log) < 2:
        out.append("whether any friction has grown, one log can't tell: give an earlier one, too (--log twice)")
    else:
        held = ", ".join(f"{a} {f.times:.2g} ({sure(f.grown)})" for a, f in found.items() if f.times is not None)
        out.append(
            f"friction of one log against another, beside what the other axes do, times and how sure grown: {held}"
        )
    return [printable(text) for text in out]


def friction_section(summary: DiagnosisSummary) -> str:
    """The page's table of friction by axis; "" where no log tells it."""
    found = [(a, r.friction) for a, r in summary.axes_report.items() if r.friction is not None]
    if not found:
        return ""
    rows = [
        [
            escape(axis),
            escape(_size(f)),
            escape(measure(f.speed, _speed(f))),
            share(f.share),
            escape("; ".join(f"{name} {measure(size, f.unit)}" for name, size in f.by_log.items())),
            f"{f.times:.2g}" if f.times is not None and f.against else "",
            sure(f.grown) if f.against else "",
        ]
        for axis, f in found
    ]
    head = ("axis", "friction", "at", "of the motor's work", "by log", "times", "grown")
    more = (
        ""
        if any(f.against for _, f in found)
        else " (one log can't tell whether any has grown: give an earlier one, too)"
    )
    return section(f"Friction, read off the {found[0][1].source}{more}", table(head, rows, left=1))


def _size(f: AxisFriction) -> str:
    return measure(f.size, f.unit)


def _speed(f: AxisFriction) -> str:
    return "mm/s" if f.linear else "degrees/s"


def _kind(f: AxisFriction) -> str:
    return f.source.removesuffix("s")
