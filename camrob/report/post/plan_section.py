"""How a plan was chosen, for the report: the trade of conditioning against external travel, and what the plan pays for."""

from __future__ import annotations

from collections.abc import Sequence

from camrob.report.page.html import escape, number, prose
from camrob.report.page.parts import table
from camrob.summaries.post_summary import AccuracyFigures, PlanFigures, PlanOnCurve, PriceBound

__all__ = ["bound_text", "gap_text", "plan_section", "travel_unit"]

# pixels: two charts stand side by side on a page
_WIDTH, _HEIGHT, _LEFT, _BOTTOM, _TOP = 430.0, 250.0, 52.0, 38.0, 14.0
_TICKS = 4  # as many as a small chart carries


def travel_unit(key: str) -> tuple[str, str]:
    """Axis and unit of a key such as E1_mm."""
    axis, _, unit = key.rpartition("_")
    return axis, {"deg": "°"}.get(unit, unit)


def gap_text(plan: PlanFigures) -> str:
    """How far the plan is from its bound, how sure that is, and what there was no time for, in a sentence or two."""
    text = (
        f"mean 1/k_F is {plan.gap_percent:.2f} % below its bound, the best found at each place by itself (searched, not "
        "proved; what travel between places costs is in the gap)"
    )
    if plan.seconds is not None:
        missed = (
            f"{plan.missed} steps of that were left out for want of time" if plan.missed else "nothing was left out"
        )
        text += f"; of {plan.seconds:.3g} s to better the plan: {missed}"
    if plan.mended:
        text += f"; made anew {plan.mended} times where it touched something or could not be followed"
    return text


def bound_text(proved: PriceBound) -> str:
    """How far the plan's price may be above the best that exists, what that leaves out, and who proved it, in a sentence."""
    if proved.within_percent is None:
        return f"no bound of the plan's price is proved: {proved.why}"
    checked = (
        "proved, and proved again from the certificate by the checker"
        if proved.checked
        else "proved, not checked again"
    )
    text = (
        f"by the whole objective the plan ({proved.price_m:.4f} m) is within {proved.within_percent:.2f} % of the best that "
        f"exists (no plan costs less than {proved.bound_m:.4f} m; {checked}; left out of the bound: {', '.join(proved.left_out)})"
    )
    return f"{text}; {proved.why}" if proved.why else text


def plan_section(plan: PlanFigures | None) -> str:
    """The section of a planned program, as HTML; nothing for another method's."""
    if plan is None:
        return ""
    curve = plan.curve
    chosen = next((k for k, p in enumerate(curve) if p.name == plan.chosen), -1)
    keys = list(curve[0].travel) if curve else []
    pictures = "".join(_picture(curve, key, chosen) for key in keys) if len(curve) > 1 else ""
    rule = (
        f"Taken: <b>{escape(plan.chosen)}</b>, by this rule: {escape(plan.rule)}. The bound is the best that any "
        f"posture found reaches at each point, {number(plan.bound_mean, 3)} in the mean and "
        f"{number(plan.bound_min, 3)} at its lowest; the chart of 1/k<sub>F</sub> shows both along the path. "
        f"Over what is cut, {prose(gap_text(plan))}."
        f"{'' if plan.proved is None else f' Proved: {escape(bound_text(plan.proved))}.'}"
    )
    return (
        "<section><h2>The plan: conditioning against external travel</h2>"
        f'<div class="trade" style="display:flex;flex-wrap:wrap;gap:12px">{pictures}</div><p class="caption">{rule} '
        "Still axes hold feed and accuracy better than moving ones: look for how little more conditioning the travel to the "
        f"right of the ringed point buys.</p>{_curve_table(curve, keys, chosen)}{_terms(plan)}{_accuracy(plan.accuracy)}"
        f"{_cuts(plan)}</section>"
    )


def _picture(curve: Sequence[PlanOnCurve], key: str, chosen: int) -> str:
    """Share of the bound over the travel of one axis, as SVG."""
    axis, unit = travel_unit(key)
    xs = [p.travel.get(key, 0.0) for p in curve]
    ys = [100.0 * p.share_of_bound for p in curve]
    high_x = max(*xs, 1e-9)
    low_y, high_y = min(ys), max(ys)
    pad = max(0.12 * (high_y - low_y), 0.05)
    low_y, high_y = low_y - pad, high_y + pad

    def at(x: float, y: float) -> tuple[float, float]:
        return (
            _LEFT + (_WIDTH - _LEFT - 14.0) * x / high_x,
            _HEIGHT - _BOTTOM - (_HEIGHT - _BOTTOM - _TOP) * (y - low_y) / (high_y - low_y),
        )

    out = [
        f'<svg width="{_WIDTH:.0f}" height="{_HEIGHT:.0f}" role="img" aria-label="trade of {escape(axis)}" fill="currentColor" '
        'font-size="11" font-family="sans-serif">'
    ]
    for k in range(_TICKS + 1):
        y, x = low_y + (high_y - low_y) * k / _TICKS, high_x * k / _TICKS
        (left, up), (across, base) = at(0.0, y), at(x, low_y)
        right = at(high_x, y)[0]
        out.append(f'<path d="M{left:.1f} {up:.1f}H{right:.1f}" stroke="currentColor" stroke-opacity="0.15"/>')
        out.append(f'<text x="{left - 6:.1f}" y="{up + 4:.1f}" text-anchor="end">{y:.1f}</text>')
        out.append(f'<text x="{across:.1f}" y="{base + 15:.1f}" text-anchor="middle">{x:,.0f}</text>')
    places = [at(x, y) for x, y in zip(xs, ys, strict=True)]
    line = "L".join(f"{a:.1f} {b:.1f}" for a, b in places)
    out.append(f'<path d="M{line}" fill="none" stroke="#2f7fd1" stroke-width="1.6"/>')
    for k, (x, y) in enumerate(zip(xs, ys, strict=True)):
        a, b = places[k]
        hint = escape(f"{curve[k].name}: {y:.2f} % of the bound, {axis} {x:,.1f} {unit}")
        look = 'r="6" stroke="#d64545" stroke-width="3" fill="#fff"' if k == chosen else 'r="4" fill="#2f7fd1"'
        out.append(f'<circle cx="{a:.1f}" cy="{b:.1f}" {look}><title>{hint}</title></circle>')
    middle = _LEFT + 0.5 * (_WIDTH - _LEFT)
    out.append(
        f'<text x="{middle:.1f}" y="{_HEIGHT - 6:.1f}" text-anchor="middle">{escape(axis)}, {escape(unit)} while cutting</text>'
    )
    out.append(
        f'<text x="12" y="{0.5 * _HEIGHT:.1f}" transform="rotate(-90 12 {0.5 * _HEIGHT:.1f})" text-anchor="middle">'
    )
    return "".join(
        [*out, 'mean 1/k<tspan font-size="9" dy="3">F</tspan><tspan dy="-3">, % of bound</tspan></text></svg>']
    )


def _curve_table(curve: Sequence[PlanOnCurve], keys: Sequence[str], chosen: int) -> str:
    heads = ["plan", "1/k_F mean", "lowest", "% of bound", *(f"{axis} {unit}" for axis, unit in map(travel_unit, keys))]
    looks = any(p.error_mm is not None for p in curve)
    rows = [
        [
            f"{'&#9679; ' if k == chosen else ''}{escape(p.name)}",
            number(p.inv_kf_mean, 3),
            number(p.inv_kf_min, 3),
            number(100.0 * p.share_of_bound, 2),
            *(number(round(p.travel.get(key, 0.0), 1), 1) for key in keys),
            *([number(p.error_mm, 3)] if looks else []),
        ]
        for k, p in enumerate(curve)
    ]
    words = (
        '<p class="caption">&#9679; is taken. Still: table and track stand while it cuts; flowing: their travel costs nothing; '
        "x and a number: it costs so many times what the cell says. Let go: a plan that began still, and moves where that "
        "pays.</p>"
    )
    return table([*heads, *(["expected error, mm rms"] if looks else [])], rows) + words


def _terms(plan: PlanFigures) -> str:
    """Each term of the objective, m, and its share as a bar."""
    rows = []
    for name, value in plan.terms.items():
        share = 100.0 * plan.shares[name]
        bar = f'<div class="share" style="width:{2.0 * share:.1f}px"></div>'
        rows.append([escape(name.replace("_", " ")), number(round(value, 3), 3), number(round(share, 1), 1), bar])
    return table(("term of the objective", "price, m of cutting", "%", ""), rows)


def _accuracy(accuracy: AccuracyFigures | None) -> str:
    """The part's expected error with and without looking at it, and what that holds."""
    if accuracy is None:
        return ""
    axes = list(accuracy.conditioning.turns)
    named = (("by conditioning", accuracy.conditioning), ("for accuracy", accuracy.accuracy))
    rows = [[name, number(e.rms_mm, 3), number(e.p95_mm, 3), *(str(e.turns[a]) for a in axes)] for name, e in named]
    heads = ("plan", "rms mm", "95 % mm", *(f"turns of {a} in cuts" for a in axes))
    counted = escape("; ".join(accuracy.counted))
    left = f" Known, but not included: {escape(', '.join(accuracy.left_out))}." if accuracy.left_out else ""
    kept = "" if accuracy.taken else " The plan by conditioning was kept, as the other is no better."
    return (
        f"<h3>The part's expected error</h3>{table(heads, rows)}"
        f'<p class="caption">Over what is cut. Included: {counted}.{left} At each '
        f"place's best posture of a scan it would be {number(accuracy.best_rms_mm, 3)} mm rms.{kept}</p>"
    )


def _cuts(plan: PlanFigures) -> str:
    """Where the arm is re-postured, and why."""
    rows = [
        [
            str(cut.line or "–"),
            "retract put in" if cut.inserted else "in a void motion",
            escape(cut.by),
            escape(cut.reason),
        ]
        for cut in plan.cuts
    ]
    return table(("re-posture at CL line", "where", "by", "why"), rows, left=4) if rows else ""
