"""The report on the tracker loop: the paper's figures beside ours, what does better, and what the assumptions do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camrob.cell.cell import Cell
from camrob.loop.analysis import Margins
from camrob.loop.gain import GAIN_MARGIN, PEAK
from camrob.report.loop.charts import tracker_charts
from camrob.report.loop.sentences import Comparison, reduction, tracker_comparisons
from camrob.report.page.html import escape, number, page
from camrob.report.page.line_charts import chart_section
from camrob.report.page.parts import TABLE, TABLE_END, page_body, verdict_bar
from camrob.studies.loop_study import TrackerStudy, Variant
from camrob.units import m_to_mm, m_to_um, rad_to_deg, s_to_ms

__all__ = ["tracker_report"]

_TAGS = {"tuned": "warning", "result": "info", "checked": "info"}


def tracker_report(cell: Cell, study: TrackerStudy) -> str:
    """The page as text."""
    charts = tracker_charts(study)
    law = study.case.law
    body = page_body(
        "The tracker loop: dynamic accuracy under a laser tracker",
        f"{escape(cell.title)}; law, feed, cycle and tests as published: K = {law.gain:g} every {s_to_ms(law.cycle_s):g} ms. A "
        "simulation: the paper gives no error sizes of the robot's parts, so these are assumed, and tuned where a row says so.",
        _verdict(study),
        _comparisons(tracker_comparisons(study)),
        _axes(study),
        *(chart_section(chart, int(data["layout"]["height"])) for chart, data in charts[:6]),
        _better(study),
        *(chart_section(chart, int(data["layout"]["height"])) for chart, data in charts[6:]),
        _lags(cell, study),
        _latencies(study),
        _needs(study),
        _sensitivity(study),
        _assumed(study),
    )
    return page("The tracker loop", body, {"names": {}, "charts": [data for _chart, data in charts]})


def _verdict(study: TrackerStudy) -> str:
    """What the published law is worth, and what does better."""
    none, law, best = (
        study.variant("none").of_circle,
        study.variant("published").of_circle,
        study.variants[-1].of_circle,
    )
    return verdict_bar(
        "info",
        f"{number(100.0 * reduction(none.path.mean, law.path.mean), 0, '%')} off the circle's error.",
        f"The published law takes the mean deviation from the circle from {_um(none.path.mean)} to {_um(law.path.mean)} "
        f"micrometres (the paper: 66 %), all that does better takes it to {_um(best.path.mean, 1)}. Simulated, with assumed "
        "errors of the robot.",
    )


def _um(value: float, decimals: int = 0) -> str:
    """Metres as micrometres, HTML."""
    return number(float(m_to_um(value)), decimals)


def _comparisons(rows: Sequence[Comparison]) -> str:
    text = "".join(
        f'<tr><td class="text">{escape(r.what)}</td><td class="text">{escape(r.published)}</td>'
        f'<td class="text">{escape(r.found)}</td><td><span class="tag {_TAGS[r.kind]}">{escape(r.kind)}</span></td></tr>'
        for r in rows
    )
    return (
        f"<section><h2>Published, and ours</h2>{TABLE}<thead><tr><th></th><th>published</th><th>ours, in simulation</th><th></th>"
        f"</tr></thead><tbody>{text}</tbody>{TABLE_END}<p class='caption'>Tuned: the simulated robot's errors were sized so that "
        "this figure comes out, which shows consistency and proves nothing. Result: what the simulation gave with these "
        "errors. Checked: an equation.</p></section>"
    )


def _axes(study: TrackerStudy) -> str:
    """Every axis before and after, of both tests."""
    none, published = study.variant("none").of_circle, study.variant("published").of_circle
    rows = ""
    for test, before, after in (("square", study.before, study.of_switched), ("circle", none, published)):
        for k, name in enumerate(("x, mm", "y, mm", "z, mm", "A, deg", "B, deg", "C, deg")):
            change = m_to_mm if k < 3 else rad_to_deg
            b, a, seen = before.axes[k], after.axes[k], after.seen_axes[k]
            cells = "".join(
                f"<td class='n'>{number(float(change(v)), 3 if k < 3 else 4)}</td>"
                for v in (b.mean, b.rms, b.most, a.mean, a.rms, a.most, seen.mean)
            )
            rows += f"<tr><td>{test}, {name}</td>{cells}<td class='n'>{number(100.0 * reduction(b.rms, a.rms), 0, '%')}</td></tr>"
    heads = "".join(
        f"<th class='n'>{when} {what}</th>" for when in ("before,", "after,") for what in ("mean", "rms", "most")
    )
    return (
        f"<section><h2>Every axis, without and with the published law</h2>{TABLE}<thead><tr><th></th>{heads}"
        f"<th class='n'>after, mean as seen</th><th class='n'>less, rms</th></tr></thead><tbody>{rows}</tbody>{TABLE_END}"
        "<p class='caption'>Absolute values under way, in truth unless said. The square from 3 s after the correction is "
        "switched on, corners included; the circle from its start.</p></section>"
    )


def _better(study: TrackerStudy) -> str:
    base = study.variant("published")

    def cells(v: Variant) -> str:
        values = (
            (v.of_square.tool.rms, base.of_square.tool.rms),
            (float(v.of_square.corners.max()), float(base.of_square.corners.max())),
            (float(v.of_square.peaks.max(initial=0.0)), float(base.of_square.peaks.max(initial=0.0))),
            (v.of_circle.tool.rms, base.of_circle.tool.rms),
            (v.of_circle.path.mean, base.of_circle.path.mean),
            (float(v.of_circle.peaks.max(initial=0.0)), float(base.of_circle.peaks.max(initial=0.0))),
        )
        return "".join(f'<td class="n">{_um(new)}{_shrunk(old, new)}</td>' for new, old in values)

    rows = "".join(f'<tr><td class="text">{escape(v.name)}</td>{cells(v)}</tr>' for v in study.variants)
    return (
        f"<section><h2>What does better</h2>{TABLE}<thead><tr><th>micrometres</th><th class='n'>square, tool, rms</th>"
        "<th class='n'>at corners, most</th><th class='n'>at reversals, most</th><th class='n'>circle, tool, rms</th>"
        "<th class='n'>off the circle, mean</th><th class='n'>at reversals, most</th></tr></thead>"
        f"<tbody>{rows}</tbody>{TABLE_END}<p class='caption'>In truth, without the tracker's noise, corrected from the start; in "
        "brackets the change against the published law. Tool: distance from the set-point, the way it lags along the path "
        "included. At reversals: the greatest change across the path about a place where joints turn round, corners left "
        f"aside. The gain is the one with the least expected error that keeps |S| at most {PEAK:g} and room to grow "
        f"{GAIN_MARGIN:g} times. Lines that begin with 'and' include those above them. Going ahead needs lags and lost motion, "
        "which were found from the runs without correction (below), and the set-points a few cycles early. "
        "What is left after it is mostly the tracker's noise; learning takes a little more, above all from the peaks. The "
        "simulated robot repeats itself and is of the form that is fitted: a real one, warm or loaded, gains less by going "
        "ahead.</p></section>"
    )


def _shrunk(old: float, new: float) -> str:
    if old <= 0.0 or new == old:
        return ""
    change = -100.0 * reduction(old, new)
    return f" ({'+' if change > 0.0 else '−'}{abs(change):.0f} %)"


def _lags(cell: Cell, study: TrackerStudy) -> str:
    lags, robot = study.lags, study.case.robot
    late = (robot.delay + study.case.latency + 0.5) * study.case.law.cycle_s
    rows = ""
    for i, name in enumerate(cell.names):
        if not lags.moved[i]:
            rows += f"<tr><td>{escape(name)}</td><td class='text' colspan='4'>does not move on these paths</td></tr>"
            continue
        rows += (
            f"<tr><td>{escape(name)}</td><td class='n'>{number(s_to_ms(float(lags.late[i])), 1, 'ms')}</td>"
            f"<td class='n'>{number(s_to_ms(float(robot.lag[i]) + late), 1, 'ms')}</td>"
            f"<td class='n'>{number(float(rad_to_deg(float(lags.lost[i]))), 4, '°')}</td>"
            f"<td class='n'>{number(float(rad_to_deg(float(robot.lost[i]))), 4, '°')}</td></tr>"
        )
    return (
        f"<section><h2>Lags and lost motion, found from the runs without correction</h2>{TABLE}<thead><tr><th></th>"
        "<th class='n'>late, found</th><th class='n'>late, simulated</th><th class='n'>half of lost motion, found</th>"
        f"<th class='n'>simulated</th></tr></thead><tbody>{rows}</tbody>{TABLE_END}<p class='caption'>The errors that the "
        "tracker saw, taken to the joints; fitted are a first-order lag, the state of friction along the path, and the joints' "
        "positions, which stand for the link errors.</p></section>"
    )


def _margins(m: Margins | None) -> str:
    if m is None:
        return "<td class='n low' colspan='4'>unstable</td>"
    return (
        f"<td class='n'>{number(m.gain, 1)}</td><td class='n'>{number(float(rad_to_deg(m.phase)), 0, '°')}</td>"
        f"<td class='n'>{number(m.delay, 0)}</td><td class='n'>{number(m.peak, 2)}</td>"
    )


def _latencies(study: TrackerStudy) -> str:
    law, chosen, sigma = study.case.law, study.choice.chosen, study.case.noise.position
    rows = "".join(
        f"<tr><td class='n'>{x.cycles} ({s_to_ms(x.cycles * law.cycle_s):g} ms)</td><td class='n'>{number(x.limit, 3)}</td>"
        f"{_margins(x.published)}{_margins(x.chosen)}</tr>"
        for x in study.latencies
    )
    here = next(x for x in study.latencies if x.cycles == study.case.latency)
    noise = [float(np.sqrt(m.noise)) * sigma if m is not None else float("nan") for m in (here.published, here.chosen)]
    head = "".join(
        f"<th class='n'>K = {k:g}: gain margin</th><th class='n'>phase</th><th class='n'>cycles of latency</th>"
        "<th class='n'>peak |S|</th>"
        for k in (law.gain, chosen)
    )
    return (
        f"<section><h2>Stability against latency</h2>{TABLE}<thead><tr><th class='n'>measurement late by</th>"
        f"<th class='n'>limit of K</th>{head}</tr></thead><tbody>{rows}</tbody>{TABLE_END}"
        "<p class='caption'>The margins of the worst joint. "
        "From the roots of the closed loop's polynomial with the lags found. "
        f"Of the tracker's noise of {_um(sigma)} micrometres, {_um(noise[0], 1)} and {_um(noise[1], 1)} reach the tool.</p>"
        "</section>"
    )


def _needs(study: TrackerStudy) -> str:
    """The best gain by latency and noise."""
    noises = sorted({need.noise for need in study.needs})
    cycles = sorted({need.latency for need in study.needs})
    found = {(need.latency, need.noise): need for need in study.needs}

    def cell_of(latency: int, noise: float) -> str:
        need = found[latency, noise]
        if need.gain is None or need.rms is None:
            return "<td class='n low'>none</td>"
        return f"<td class='n'>{number(need.gain, 4)} ({_um(need.rms)})</td>"

    rows = "".join(
        f"<tr><td class='n'>{c} ({s_to_ms(c * study.case.law.cycle_s):g} ms)</td>{''.join(cell_of(c, n) for n in noises)}</tr>"
        for c in cycles
    )
    heads = "".join(f"<th class='n'>noise {_um(n)} µm</th>" for n in noises)
    return (
        f"<section><h2>The best gain against latency and noise</h2>{TABLE}<thead><tr><th class='n'>measurement late by</th>"
        f"{heads}</tr></thead><tbody>{rows}</tbody>{TABLE_END}<p class='caption'>In brackets the rms error to expect on "
        "the circle, micrometres, with the set-point of the measured instant. Little noise: the bounds on peak and margin "
        "decide, and latency lowers them. Much noise, as of cheaper instruments: it decides.</p></section>"
    )


def _sensitivity(study: TrackerStudy) -> str:
    rows = "".join(
        f"<tr><td class='text'>{escape(s.name)}</td><td class='n'>{number(float(m_to_mm(s.before.tool.most)), 2)}</td>"
        f"<td class='n'>{_um(s.before.path.mean)}</td><td class='n'>{_um(s.after.path.mean)}</td>"
        f"<td class='n'>{number(100.0 * reduction(s.before.path.mean, s.after.path.mean), 0, '%')}</td>"
        f"<td class='n'>{number(100.0 * reduction(s.before.seen_path.mean, s.after.seen_path.mean), 0, '%')}</td>"
        f"<td class='n'>{_um(float(s.after.peaks.max(initial=0.0)))}</td><td class='n'>{_um(s.after.tool.rms)}</td>"
        f"<td class='n'>{number(100.0 * reduction(s.before.tool.rms, s.after.tool.rms), 0, '%')}</td></tr>"
        for s in study.sensitivity
    )
    return (
        f"<section><h2>What the assumptions do</h2>{TABLE}<thead><tr><th>circle, published law</th><th class='n'>tool before, "
        "most, mm</th><th class='n'>off circle, mean, before</th><th class='n'>after</th><th class='n'>less</th>"
        "<th class='n'>less, as seen</th><th class='n'>reversals, after</th><th class='n'>tool, rms, after</th>"
        "<th class='n'>less</th></tr>"
        f"</thead><tbody>{rows}</tbody>{TABLE_END}"
        "<p class='caption'>One assumption changed at a time; micrometres unless said. What is left after is mostly "
        "the lag whose direction turns, v² lag T / (K R), and hardly depends on the rest; how much is there before decides the "
        "percentage.</p></section>"
    )


def _assumed(study: TrackerStudy) -> str:
    kinds: dict[str, list[str]] = {}
    for key, source in study.case.provenance.items():
        kinds.setdefault(source, []).append(key)
    rows = "".join(
        f"<tr><td>{escape(kind)}</td><td class='text'>{escape(', '.join(sorted(keys)))}</td></tr>"
        for kind, keys in sorted(kinds.items(), reverse=True)
    )
    return (
        f"<section><h2>Where the numbers of tracker.toml come from</h2>{TABLE}<thead><tr><th>provenance</th><th>keys</th></tr>"
        f"</thead><tbody>{rows}</tbody>{TABLE_END}<p class='caption'>All of robot was assumed and sized by hand until the errors "
        "without correction came out as published and reversals showed; no number was set for the sake of the reductions, though "
        "they were in view. The gain, the feed and the tests are the paper's.</p></section>"
    )
