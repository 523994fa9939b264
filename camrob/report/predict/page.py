"""The page of a predicted part: the part coloured by its error, percentiles, causes, the worst places."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.prediction.surface import PredictedSurface
from camrob.report.page.cloud import Cloud
from camrob.report.page.html import escape, number, page
from camrob.report.page.parts import card_row, figure, page_body, place_link, section, table, verdict_bar
from camrob.summaries.predict_summary import HeldToPart, HolderMeets, PredictedForce, PredictSummary
from camrob.units import m_to_mm

__all__ = ["camera_eye", "predict_report"]

Array = NDArray[np.float64]

_POINTS = 60_000  # in the picture: what a browser turns without effort
_SCALE = 0.98  # of the deviations lie within the ends of the colours
_WORST = 5  # places of a kind in a table
_FROM = (0.0, -0.55, 0.75)  # from the front and above
_COLORS = ((0.0, "#2166ac"), (0.25, "#67a9cf"), (0.5, "#d9d9d9"), (0.75, "#ef8a62"), (1.0, "#b2182b"))
_TURN = (
    '<p class="caption">Red: material is left beyond what was programmed; blue: cut too deep. Drag to turn it, or by the arrow '
    "keys; point at a place for its numbers. What lies beyond the scale has "
    "the colour of its end.</p>"
)
_ALIKE = 0.05  # of itself: a range narrower than this is not worth a sentence
_CANCELS = 1.5  # times the whole error: a cause that much larger is not most of it
_SCALE_LEAST_MM = 1e-3  # a micrometre either way, where there is no error to show


def predict_report(summary: PredictSummary, surface: PredictedSurface, player: str = "") -> str:
    """The page as text. player: the address of the page that plays the program, "" for none."""
    picture, spread = _picture(surface), _spread(surface, summary.percentiles_mm)
    known = " and ".join(
        f"the {what} <b>{escape(name)}</b>"
        for what, name in (("calibration", summary.calibration), ("diagnosis in", summary.diagnosis))
        if name
    )
    if summary.meant:
        known += f", held to what <b>{escape(summary.meant)}</b> asks for"
    body = page_body(
        f"The part as {escape(summary.program)} would cut it",
        f"on the cell <b>{escape(summary.cell)}</b>, by {known}",
        _verdict(summary),
        _cards(summary),
        section("The part, coloured by its error", picture.html(), _TURN),
        _part(summary.part),
        _holder(summary.holder),
        _places(summary, player),
        _causes(summary),
        _force(summary.force),
        figure(spread),
        _left_out(summary),
        note="A prediction: what the machine truly does is measured, not computed.",
    )
    charts = [{k: spread[k] for k in ("id", "traces", "layout", "own")}]
    data = {"names": {}, "clouds": [picture.data()], "charts": charts}
    return page(f"The part as {summary.program} would cut it", body, data)


def _verdict(summary: PredictSummary) -> str:
    """What the part would be like, in two sentences."""
    text = f"The worst, by what is expected of each place, is {number(summary.worst_mm, 3, 'mm')}"
    if summary.places:
        worst = summary.places[0]
        how = "material is left" if worst.deviation_mm > 0.0 else "cut too deep"
        text += f", {how} by line {worst.line} of the program; its largest cause is {escape(_words(worst.cause))}"
    likely = summary.likely
    if likely.p95_high_mm - likely.p95_low_mm > _ALIKE * likely.p95_mm:
        low, high = number(likely.p95_low_mm, 3), number(likely.p95_high_mm, 3, "mm")
        text = f"Of 100 machines as this may be, 95 lie between {low} and {high}. {text}"
    return verdict_bar("info", f"95 % of the surface within {number(likely.p95_mm, 3, 'mm')}.", f"{text}.")


def _cards(summary: PredictSummary) -> str:
    first = next(iter(summary.causes), "")
    cards = [
        (
            "Likely error, rms",
            number(summary.likely.rms_mm, 3, "mm"),
            f"expected {number(summary.rms_mm, 3)}, mean {number(summary.mean_mm, 3, 'mm')}; above 0: material is left",
        ),
        (
            "95 % are likely within",
            number(summary.likely.p95_mm, 3, "mm"),
            f"expected {number(summary.p95_mm, 3, 'mm')}; {summary.points:,} points of the surface",
        ),
        ("Worst expected", number(summary.worst_mm, 3, "mm"), _worst_note(summary)),
        ("How sure", f"± {number(summary.band_mm, 3, 'mm')}", "95 % band; narrower at half of the points"),
    ]
    if first:
        size = summary.causes[first]
        cancels = size > _CANCELS * summary.rms_mm  # a correction does, with what it is made for
        head, rest = ("Largest by itself", "; causes take each other off") if cancels else ("Most of it", "")
        cards.append((head, escape(_words(first)), f"{size:.3f} mm rms{rest}"))
    if summary.part is not None:
        deepest = summary.part.gouges[:1]
        where = f"line {deepest[0].line} of the program" if deepest else f"held to {escape(summary.part.mesh)}"
        cards.append(
            ("Deepest gouge in the part", number(-deepest[0].deviation_mm if deepest else 0.0, 3, "mm"), where)
        )
    if summary.holder:
        cards.append(("The holder", "meets the stock", f"first in line {_lines(summary.holder[0])} of the program"))
    return card_row(cards)


def _worst_note(summary: PredictSummary) -> str:
    """Where it is, and why it may be less than what is likely everywhere."""
    where = [f"line {summary.places[0].line} of the program"] if summary.places else []
    if summary.worst_mm < summary.likely.p95_mm:
        where.append("less than what is likely, as what is in doubt is expected to be 0")
    return "; ".join(where)


def _words(cause: str) -> str:
    return cause.replace("_", " ")


def _places(summary: PredictSummary, player: str) -> str:
    rows = [
        [
            escape(_words(p.cause)),
            place_link(p.line, page=player, of="program-line") if player else f"{p.line}",
            number(p.deviation_mm, 3),
            f"± {number(p.band_mm, 3)}",
            number(p.cause_mm, 3),
            number(100.0 * p.share, 0, "%"),
            *(number(v, 1) for v in (p.x_mm, p.y_mm, p.z_mm)),
        ]
        for p in summary.places
    ]
    head = ("largest cause", "program line", "error mm", "95 % mm", "by that cause", "share", "x mm", "y", "z")
    note = (
        "One place stands for all within 3 mm of it and a twentieth of the part. A share is that of the sizes of all causes, "
        "which may cancel each other."
    )
    return section("The ten worst places", table(head, rows), f'<p class="caption">{note}</p>')


def _part(part: HeldToPart | None) -> str:
    """What is cut, held to the part that is wanted."""
    if part is None:
        return ""
    size = part.size
    rows = [
        ["off the part, rms", number(size.rms_mm, 3, "mm")],
        ["95 % are within", number(size.p95_mm, 3, "mm")],
        ["cut out of the part", f"{number(part.gouged_mm3, 0)} mm³"],
        ["material that stands beyond it", f"{number(part.left_mm3, 0)} mm³"],
    ]
    worst = [
        [what, f"{p.line}", number(p.deviation_mm, 3), *(number(v, 1) for v in (p.x_mm, p.y_mm, p.z_mm))]
        for what, places in (("gouge", part.gouges), ("left", part.rests))
        for p in places[:_WORST]
    ]
    notes = [
        "Ridges between passes, corners that the cutter can't reach and what the CAM left on purpose stand here, too."
    ]
    if part.elsewhere:
        notes.append(f"{part.elsewhere:,} points of the cut have no wall of the part near.")
    if part.beyond_stock_mm > 0.0:
        notes.append(f"The part reaches {number(part.beyond_stock_mm, 2, 'mm')} out of the stock.")
    head = ("", "program line", "off the part, mm", "x mm", "y", "z")
    caption = f'<p class="caption">{escape(" ".join(notes))}</p>'
    return section(f"Held to {part.mesh}", table(("", ""), rows), table(head, worst), caption)


def _holder(meets: tuple[HolderMeets, ...] | None) -> str:
    """Where the holder goes through material."""
    if meets is None:
        return ""
    if not meets:
        return section("The holder", '<p class="caption">It stays clear of the stock, as it is at each moment.</p>')
    most = sorted(meets, key=lambda m: -m.taken_mm3)[:_WORST]
    rows = [[_lines(m), number(m.taken_mm3, 1)] for m in most]
    note = f"The holder goes through the stock at {len(meets)} places; those with the most material:"
    return section("The holder", f"<p><strong>{note}</strong></p>", table(("lines", "mm³ in its way"), rows))


def _lines(meets: HolderMeets) -> str:
    first, last = meets.first_line, meets.last_line
    return f"{first}" if first == last else f"{first}–{last}"


def _causes(summary: PredictSummary) -> str:
    rows = [[escape(_words(name)), number(value, 4)] for name, value in summary.causes.items()]
    left = [
        ["all of these: what is expected", number(summary.rms_mm, 4)],
        ["what nothing explains, in any one direction", number(summary.rest_mm, 4)],
        ["with all that is in doubt: what is likely", number(summary.likely.rms_mm, 4)],
    ]
    regions = [
        [escape(r.file), f"{r.first_line}–{r.last_line}", number(r.size.rms_mm, 3), number(r.size.p95_mm, 3)]
        for r in summary.regions
    ]
    parts = [table(("cause", "rms mm along the surface's normal"), rows + left)]
    if len(regions) > 1:
        parts.append(table(("file", "lines", "rms mm", "95 % mm"), regions))
    return section("Causes", *parts)


def _force(force: PredictedForce | None) -> str:
    """What pushes, what yields, and what nobody can tell from this."""
    if force is None:
        return ""
    yields = f"{escape(', '.join(force.yields) or 'no axis')}, as the diagnosis found"
    others = "other axes are taken as stiff"
    if force.granted:
        like = "such axes do beside these" if force.yields else "is ordinary for an arm of its size"
        others = f"{escape(', '.join(force.granted))}, which nobody knows, as {like}, give or take all"
    tool = "tool and holder as stated" if force.tool else "tool and holder are taken as stiff"
    rows = [
        ["force", f"{escape(force.words)} ({escape(force.model)})"],
        [
            "it may be wrong by",
            f"{number(100.0 * force.doubt, 0, '%')} of itself, one standard deviation; the band holds that",
        ],
        ["what yields", f"{yields}; {tool}; {others}"],
        ["deflection of the tool", f"{number(force.deflection_p95_mm, 3, 'mm')} or less on 95 % of the run"],
    ]
    note = (
        "What the force bends is compliance times force: a part that was cut shows only their product. Coefficients that are "
        "twice too high and joints that are taken as twice too stiff make the same surface. What tells them apart is the one "
        "without the other: a run in air with another payload shows the compliance, a logged force the coefficients."
    )
    return section("The cutting force", table(("", ""), rows, left=2), f'<p class="caption">{note}</p>')


def _left_out(summary: PredictSummary) -> str:
    notes = [f"not judged: {escape(', '.join(summary.not_judged))}"]
    if summary.not_reckoned:
        notes.append(
            f"found by the diagnosis, and not predicted from this run: {escape(', '.join(summary.not_reckoned))}"
        )
    if summary.reckoned:
        notes.append(
            f"at {summary.reckoned:,} points the cut stock tells nothing, as another wall lies where theirs would be: their "
            "error is reckoned from the causes alone"
        )
    if summary.not_met:
        notes.append(
            f"{summary.not_met:,} point{'s are' if summary.not_met > 1 else ' is'} left out, as the exact path cuts another wall "
            f"where {'theirs' if summary.not_met > 1 else 'its own'} would be"
        )
    notes += [escape(f"program line {w.line}: {w.text}" if w.line else w.text) for w in summary.warnings]
    return section("What this does not say", "<ul>" + "".join(f"<li>{n}</li>" for n in notes) + "</ul>")


def camera_eye(size: Array) -> tuple[float, float, float]:
    """The direction that the picture of a part of this size (3,) is looked from: from the front, its longer level side across."""
    aside, front, above = _FROM
    return (aside, front, above) if size[0] >= size[1] else (-front, aside, above)


def _picture(surface: PredictedSurface) -> Cloud:
    """The surface's points, coloured by their error."""
    step = max(1, len(surface.point) // _POINTS)
    worst = np.argsort(-np.abs(surface.deviation))[:200]
    some = np.union1d(np.arange(0, len(surface.point), step), worst)
    p, e = m_to_mm(surface.point[some]), m_to_mm(surface.deviation[some])
    end = max(float(np.quantile(np.abs(e), _SCALE)), _SCALE_LEAST_MM)
    title = "the part, coloured by its error"
    return Cloud("part", title, p, e, -end, end, _COLORS, "error", camera_eye(np.ptp(p, axis=0)), height=520)


def _spread(surface: PredictedSurface, percentiles: Mapping[str, float]) -> dict[str, Any]:
    """How many points are off by how much, the middle 98 % with the rest in the end bars."""
    e = m_to_mm(surface.deviation)
    end = max(float(np.quantile(np.abs(e), 0.995)), _SCALE_LEAST_MM)
    below = ", ".join(
        f"{share} % {round(value, 3) + 0.0:.3f} mm".replace("-", "−") for share, value in percentiles.items()
    )
    counts, edges = np.histogram(np.clip(e, -end, end), bins=80, range=(-end, end))
    trace = {
        "type": "bar",
        "x": [float(f"{v:.5g}") for v in 0.5 * (edges[1:] + edges[:-1])],
        "y": [float(f"{v:.4g}") for v in 100.0 * counts / len(e)],
        "hovertemplate": "%{x:.3f} mm: %{y:.2f} %<extra></extra>",
    }
    layout = {
        "height": 300,
        "margin": {"l": 64, "r": 16, "t": 8, "b": 46},
        "shapes": [],
        "bargap": 0,
        "xaxis": {"title": {"text": "error along the normal [mm]"}},
        "yaxis": {"title": {"text": "share of the points [%]"}},
    }
    return {
        "id": "spread",
        "title": "How the errors are spread",
        "caption": f"The bars at the ends hold all that lies beyond. Of the points lie below: {below}.",
        "traces": [trace],
        "layout": layout,
        "own": True,
    }
