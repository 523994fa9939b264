"""When a run passed its program's places, beside the virtual controller: in a line, and as a section of the page."""

from __future__ import annotations

from camrob.report.diagnosis.numbers import measure
from camrob.report.page.html import escape
from camrob.report.page.parts import section, table
from camrob.summaries.diagnosis_places import LostTime, RunDuration, RunSpeed, RunTiming
from camrob.summaries.diagnosis_summary import DiagnosisSummary

__all__ = ["timing_section", "timing_texts"]

_NO_PROGRAM = "no program"
_SAME = 2.0  # per cent within which a run takes the time that the virtual controller does


def timing_texts(summary: DiagnosisSummary) -> list[str]:
    """A line for each log that could be compared."""
    return [_line(one, one.duration) for one in summary.where.timing if one.duration is not None]


def _line(one: RunTiming, duration: RunDuration) -> str:
    speed, more = one.speed, duration.difference_percent
    text = f"{one.log} took {_s(duration.logged_s)}"
    if more is None:
        text += f", the virtual controller {_s(duration.predicted_s)}"
    elif abs(more) < _SAME:
        text += f", as the virtual controller does ({_s(duration.predicted_s)})"
    else:
        than = f"{'more' if more > 0.0 else 'less'} than the virtual controller ({_s(duration.predicted_s)})"
        text += f", {abs(more):.0f} % {than}"
    if speed is not None:
        text += f"; {_held(speed)}"
    pauses = [s for s in one.stops if s.what == "pause"]
    if pauses:
        worst = max(pauses, key=lambda s: s.seconds)
        count = f", the longest of {len(pauses)}" if len(pauses) > 1 else ""
        text += f"; a pause of {_s(worst.seconds)} at line {worst.line}{count}"
    if one.lost:
        most = one.lost[0]
        why = f": {_why(most)}" if _why(most) else ""
        whole = f"{_s(duration.lost_s)} are lost against it on {one.stretches} stretches"
        text += f"; {whole}, most on lines {most.from_line} to {most.to_line} ({_s(most.lost_s)}{why})"
    return text + "."


def _held(speed: RunSpeed) -> str:
    """Whether the programmed speed is run."""
    share, steady = speed.at_programmed_percent, speed.steady_percent
    if speed.matches:
        return f"the programmed speed is held for {share:.0f} % of the time"
    text = f"the programmed speed is not what was run (held for {share:.0f} % of the time"
    return text + (f"; mostly {steady:.0f} % of it)" if steady is not None else ")")


def _why(lost: LostTime) -> str:
    """What holds the tool back on a stretch, as far as log and virtual controller tell."""
    reasons = []
    if lost.paused_s > 0.0:
        reasons.append(f"paused for {_s(lost.paused_s)}")
    steady = lost.steady
    if steady is not None:
        share = "" if steady.percent is None else f", {measure(steady.percent, '%', 2)} of {steady.of}"
        name = "the tool" if steady.what == "tool" else steady.what
        highest = "" if steady.what == "tool" else ", its highest in the log"
        reasons.append(f"{name} runs at {measure(steady.speed, steady.unit, 2)}{highest}{share}")
    if lost.limit:
        reasons.append(f"held back by {lost.limit}, in the virtual controller too")
    return "; ".join(reasons)


def _s(seconds: float) -> str:
    return f"{seconds:.1f} s" if abs(seconds) < 1000.0 else f"{seconds:.0f} s"


def timing_section(summary: DiagnosisSummary) -> str:
    """The section of the page; "" where no log's timing is known."""
    timings = summary.where.timing
    if all(one.duration is None and one.reason == _NO_PROGRAM for one in timings):
        return ""  # what the logs lack says so
    lines = [
        f"{one.log}: not compared, {one.reason}." if one.duration is None else _line(one, one.duration)
        for one in timings
    ]
    words = "".join(f"<li>{escape(line)}</li>" for line in lines)
    rows = [
        [
            escape(one.log),
            f"{lost.from_line} to {lost.to_line}",
            *(escape(_s(v)) for v in (lost.lost_s, lost.logged_s, lost.predicted_s, lost.at_programmed_speed_s)),
            escape(_why(lost)),
        ]
        for one in timings
        for lost in one.lost
    ]
    head = ("log", "program lines", "lost", "logged", "virtual controller", "as programmed", "what holds back")
    stretches = table(head, rows, left=2) if rows else ""
    stops = [
        [escape(one.log), str(s.line), *(escape(_s(v)) for v in (s.t_s, s.seconds, s.programmed_s)), escape(s.what)]
        for one in timings
        for s in one.stops
    ]
    rests = (
        table(("log", "program line", "after", "rests for", "programmed", "so it is"), stops, left=2) if stops else ""
    )
    note = (
        '<p class="caption">Apart from the gap, which is compared by place on the path. Lost: against the programmed '
        "speed throughout. The worst stretches of each log; where no reason is given, nothing holds the virtual controller "
        "back there: look for an override, limits that the cell does not know, or the operator.</p>"
    )
    return section("Timing along the program", f"<ul>{words}</ul>", stretches, rests, note if rows or stops else "")
