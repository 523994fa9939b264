"""The page of a judgement: the verdict, what stands against the program with a picture of each place, what was not judged."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.frozen import locked
from camrob.report.page.html import escape, number, page
from camrob.report.page.line_charts import Curve, LineChart, chart_data, chart_section
from camrob.report.page.parts import card_row, page_body, section, table, verdict_bar
from camrob.report.verify.grouped import grouped
from camrob.report.words import shown_blocks
from camrob.summaries.remarks import JudgedRemark
from camrob.summaries.verify_summary import VerifySummary
from camrob.units import rad_to_deg

__all__ = ["PICTURES", "VerifiedMotions", "verify_report"]

Array = NDArray[np.float64]

PICTURES = 4
"""Places of findings that are drawn: the first ones."""
_ROWS = 200  # of a table
_HEADINGS = ("", "what", "program line", "CL line", "off by", "allowed")
_WIDE = "grid-template-columns: repeat(auto-fit, minmax(min(440px, 100%), 1fr))"
_LINE, _MOTION = "program line", "motion of the program"
_WORDS = {True: "good", False: "bad", None: "not judged"}


@dataclass(frozen=True, slots=True)
class VerifiedMotions:
    """The replay along the program: line (N,) of each motion; margin (N,) rad, the least of the arm's axes to a limit within it,
    below 0 beyond; inv_kf (N,), inf where none is known. threshold: of the cell on 1/k_F, None where it has none.
    """

    line: NDArray[np.int64]
    margin: Array
    inv_kf: Array
    threshold: float | None

    def __post_init__(self) -> None:
        count = len(self.line)
        object.__setattr__(self, "line", locked(self.line, shape=(count,), dtype=np.int64, name="line"))
        for name in ("margin", "inv_kf"):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(count,), name=name))


def verify_report(summary: VerifySummary, motions: VerifiedMotions | None, pictures: Mapping[int, bytes]) -> str:
    """The page as text. motions: None where the program could not be replayed; pictures: PNGs of places by their line."""
    charts = [] if motions is None else _charts(motions)
    body = page_body(
        f"Verification of {escape(summary.program)}",
        f"on the cell <b>{escape(summary.cell)}</b>{_against(summary)}",
        _verdict(summary),
        _findings("Against it", grouped(summary.errors), "error"),
        _pictures([*summary.errors, *summary.warnings], pictures),
        _not_judged(summary),
        _findings("To read", summary.warnings, "warning"),
        _cards(summary),
        *(chart_section(c) for c in charts),
    )
    data = {"names": {}, "charts": [{**c, "ruler": "motion"} for c in chart_data(charts)]}
    return page(f"Verification of {summary.program}", body, data)


def _against(summary: VerifySummary) -> str:
    made = summary.corrected
    said = "" if made is None else f", corrected by {escape(made.calibration)}, its original"
    return said if summary.against is None else f"{said}, against <b>{escape(summary.against.file)}</b>"


def _verdict(summary: VerifySummary) -> str:
    level, word, text = {
        True: ("good", "Nothing was found against it.", "All areas were judged."),
        False: ("bad", "Don’t run it.", _first(grouped(summary.errors))),
        None: ("warn", "Judged in part.", "Nothing was found against it, but not all of it could be judged."),
    }[summary.ok]
    return verdict_bar(level, word, text)


def _first(errors: Sequence[JudgedRemark]) -> str:
    """What stands against a program, as a sentence (HTML): the first thing, and how many more there are."""
    if not errors:
        return ""
    more = f"; {len(errors) - 1} more thing{'s' if len(errors) > 2 else ''} against it below" if len(errors) > 1 else ""
    line = errors[0].line
    at = f"Program line {line}: " if line and f"line {line} of" not in errors[0].text else ""
    return f"{at}{escape(errors[0].text)}{more}."


def _findings(title: str, remarks: Sequence[JudgedRemark], kind: str) -> str:
    rows = [
        [
            f'<span class="tag {kind}">{escape(r.code)}</span>',
            f"{escape(r.text)}{f' ({r.count} times)' if r.count > 1 else ''}",
            f"{r.line}{f' of <code>{escape(r.file)}</code>' if r.file else ''}" if r.line else "–",
            str(r.cl_line) if r.cl_line else "–",
            number(r.value, 4, r.unit),
            number(r.limit, 4, r.unit),
        ]
        for r in remarks
        if r.code != "not-judged"
    ]
    if not rows:
        return ""
    more = f'<p class="caption">and {len(rows) - _ROWS} more (verify.json has all)</p>' if len(rows) > _ROWS else ""
    return section(title, table(_HEADINGS, rows[:_ROWS], left=2), more)


def _pictures(remarks: Sequence[JudgedRemark], pictures: Mapping[int, bytes]) -> str:
    """The cell at the places of findings."""
    shown = []
    for line, png in pictures.items():
        text = next((r.text for r in remarks if r.line == line and not r.file), "")
        source = base64.b64encode(png).decode()
        shown.append(
            f'<div class="card"><div class="what">program line {line}</div><img style="width:100%" '
            f'alt="The cell at the program’s line {line}: {escape(text)}" src="data:image/png;base64,{source}">'
            f'<div class="note">{escape(text)}</div></div>'
        )
    if not shown:
        return ""
    note = '<p class="caption">The cell at the end of the motion; the red ball is the tool’s tip, grey its way.</p>'
    return section("Where", f'<div class="cards" style="{_WIDE}">{"".join(shown)}</div>', note)


def _not_judged(summary: VerifySummary) -> str:
    if not summary.not_judged:
        return ""
    items = "".join(f"<li>{escape(text)}</li>" for text in summary.not_judged[:_ROWS])
    return section("Not judged", f"<ul>{items}</ul>")


def _cards(summary: VerifySummary) -> str:
    judged, replay, against = summary.judged, summary.replay, summary.against
    areas = {
        "path": judged.path,
        "frames": judged.frames,
        "process": judged.process,
        "limits": judged.limits,
        "collisions": judged.collisions,
    }
    cards = [
        (
            name.capitalize(),
            f'<span class="low">{_WORDS[good]}</span>' if good is False else _WORDS[good],
            _why(good, summary),
        )
        for name, good in areas.items()
    ]
    if against is not None:
        met = f"{against.met:,} of {against.points:,} points met"
        cards.append(
            ("Farthest off a CL point", number(against.position_error_mm_max, 4, "mm") if against.met else "–", met)
        )
    if replay is not None:
        cards.append(
            (
                "How far from singular",
                number(replay.conditioning.inv_kf_min, 3),
                "lowest 1/k_F, moves through air included: 0 is singular",
            )
        )
        cards.append(("Motions", f"{summary.motions or 0:,}", f"in {', '.join(summary.files)}"))
        if replay.blocks is not None and replay.blocks.short:
            cards.append(("Motions that are too short", f"{replay.blocks.short:,}", shown_blocks(replay.blocks)))
    return card_row(cards)


def _why(good: bool | None, summary: VerifySummary) -> str:
    """Why an area was not judged, where something else is at fault."""
    return "for what stands against the program" if good is None and summary.errors and not summary.not_judged else ""


def _charts(motions: VerifiedMotions) -> list[LineChart]:
    """Along the program: how near limits and singular postures lie."""
    line = np.asarray(motions.line)
    in_turn = bool(np.all(np.diff(line) >= 0))  # no loop, and no part in a file of its own
    count, along = (line.astype(float), _LINE) if in_turn else (np.arange(1.0, len(line) + 1.0), _MOTION)
    known = np.where(np.isfinite(motions.inv_kf), motions.inv_kf, np.nan)
    margin = np.asarray(rad_to_deg(motions.margin))
    limits = (Curve("least margin", count, margin), Curve("the limit", count, np.zeros(len(count)), "dash", 3))
    conditioning = [Curve("lowest 1/k_F", count, known)]
    if motions.threshold is not None:
        conditioning.append(Curve("threshold", count, np.full(len(count), motions.threshold), "dash", 3))
    near = "Least distance of any axis of the arm to its limit within each motion; below 0: beyond."
    if count.size and not np.isfinite(margin[-1]):
        near += " The curves end where the program can’t be followed any further."
    singular = "Least 1/k_F within each motion: 0 is singular. Where an axis motion leads, none is reckoned."
    return [
        LineChart("margins", "How near the arm’s limits are", near, along, "least margin [degrees]", limits),
        LineChart("conditioning", "How far from singular", singular, along, "lowest 1/k_F [–]", tuple(conditioning)),
    ]
