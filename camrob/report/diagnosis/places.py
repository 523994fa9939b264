"""Where the gap lies, in numbers: worst stretches, stages, directions, axes and regimes with intervals, standards."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence

from camrob.gap.diagnosis import PathError
from camrob.report.diagnosis.numbers import mm, share
from camrob.report.diagnosis.sentences import between, standards_text
from camrob.report.page.html import escape
from camrob.report.page.parts import place_link, section, table
from camrob.summaries.diagnosis_places import Places
from camrob.summaries.diagnosis_summary import DiagnosisSummary

__all__ = ["place_sections"]

Values = dict[str, tuple[float | None, tuple[float, float] | None]]

_FRAME = ("x", "y", "z")
_WORST = 6  # as many as one looks at; the JSON has all
_DIRECTIONS = {
    "x": "x of the measured frame",
    "y": "y of the measured frame",
    "z": "z of the measured frame",
    "along": "along the path",
    "across": "across the path",
    "tool_x": "x of the tool",
    "tool_y": "y of the tool",
    "tool_axis": "z of the tool",
    "work_x": "x of the work",
    "work_y": "y of the work",
    "work_z": "z of the work",
}


def place_sections(summary: DiagnosisSummary, paths: Sequence[PathError], players: Mapping[str, str]) -> list[str]:
    """The sections, those that have nothing to say left out. players: as of `diagnosis_report`."""
    return [s for s in (_worst(summary, paths, players), _numbers(summary), _standards(summary)) if s]


def _worst(summary: DiagnosisSummary, paths: Sequence[PathError], players: Mapping[str, str]) -> str:
    lined = {p.log for p in paths if p.line.any()}
    worst = sorted(summary.where.segments, key=lambda s: -s.rms_mm)[:_WORST]
    rows = [
        [
            escape(s.log),
            _place(s.log, s.from_line, s.to_line, lined, players),
            *(escape(mm(v)) for v in (s.rms_mm, s.contour_mm, s.tangential_mm)),
        ]
        for s in worst
    ]
    single = [
        [
            escape(s.log),
            _place(s.log, s.from_line, s.from_line, lined, players),
            *(escape(mm(v)) for v in (s.rms_mm, s.contour_mm, s.tangential_mm)),
        ]
        for s in summary.where.lines[:_WORST]
    ]
    head = ("rms", "across the path", "along it")
    stretches = table(("log", "stretch", *head), rows, left=2)
    lines = table(("log", "line by line", *head), single, left=2) if single else ""
    unlined = any(s.log not in lined for s in worst)
    note = '<p class="caption">Rows are counted as in the file of the log, its head being row 1.</p>' if unlined else ""
    return section("Worst stretches", stretches, _changes(summary, lined), lines, note)


def _place(log: str, first: int, last: int, lined: Collection[str], players: Mapping[str, str]) -> str:
    """Lines of a log's track in words, which lead to where the player stands there, where there is one (HTML)."""
    count = f"line {first}" if first == last else f"lines {first} to {last}"
    if log not in lined:
        return f"rows {first} to {last}"
    player = players.get(log, "")
    words = f"program {count}"
    return place_link(first, words=words, page=player, of="program-line") if player else words


def _counted(log: str, lined: Collection[str]) -> str:
    """What a line of a log's track is counted in."""
    return "program line" if log in lined else "row"


def _changes(summary: DiagnosisSummary, lined: Collection[str]) -> str:
    """Where the mean gap changes at once."""
    changes = sorted(summary.where.change_points, key=lambda c: -c.step_mm)
    if not changes:
        return ""
    several = len({c.log for c in changes}) > 1
    words = [
        f"{mm(c.step_mm)} after {c.t_s:.1f} s ({_counted(c.log, lined)} {c.line}{' of ' + c.log if several else ''})"
        for c in changes[:_WORST]
    ]
    more = f", and {len(changes) - _WORST} times more by less" if len(changes) > _WORST else ""
    return f"<p>The mean gap changes at once by {escape('; '.join(words))}{more}.</p>"


def _numbers(summary: DiagnosisSummary) -> str:
    """Stages, directions, axes and regimes, each with its 90 % interval."""
    where = summary.where
    regimes = {**where.regimes, **where.further_regimes}
    stages: Values = {between(k, summary): (v, where.stage_intervals[k]) for k, v in where.stages.items()}
    directions: Values = _directions(where)
    groups: tuple[tuple[str, Values, Callable[[float], str]], ...] = (
        ("Stage", stages, mm),
        ("Direction", directions, mm),
        ("Axis", {k: (v, where.axis_intervals[k]) for k, v in where.axes.items()}, share),
        ("Regime", {k: (v, where.regime_intervals[k]) for k, v in regimes.items()}, share),
    )
    cells = ""
    for title, values, words in groups:
        rows = [
            [
                escape(name),
                escape("not logged" if v is None or i is None else _spread(words(v), words(i[0]), words(i[1]))),
            ]
            for name, (v, i) in values.items()
            if v is None or i is None or max(abs(v), *map(abs, i)) > 0.0
        ]
        cells += f"<div>{table((title.lower(), 'how much (90 % interval)'), rows)}</div>"
    return section("Where, in numbers", f'<div class="pair wide">{cells}</div>')


def _directions(where: Places) -> Values:
    """Directions with their intervals; those of the work on one line with the measured frame's where they are the same."""
    found = {k: (v, where.direction_intervals[k]) for k, v in where.directions.items()}
    same = all(f"work_{k}" in found and found[f"work_{k}"] == found.get(k) for k in _FRAME)
    if not same:
        return {_DIRECTIONS[k]: v for k, v in found.items()}
    named = {
        k: _DIRECTIONS[k] + (" and of the work" if k in _FRAME else "") for k in found if not k.startswith("work_")
    }
    return {name: found[k] for k, name in named.items()}


def _spread(value: str, low: str, high: str) -> str:
    return value if value == low == high else f"{value} ({low} to {high})"


def _standards(summary: DiagnosisSummary) -> str:
    lines = "".join(f"<li>{escape(standards_text(one))}</li>" for one in summary.standards)
    if not lines:
        return ""
    note = (
        '<p class="caption">Before, and without the effects found. AT, RT: accuracy and repeatability of a path (ISO 9283); '
        "G, G b: circular deviation, of one sense and of both; H: circular hysteresis (ISO 230-4).</p>"
    )
    return section("By the standards", f"<ul>{lines}</ul>", note)
