"""How a plan was chosen, for the terminal."""

from __future__ import annotations

from collections.abc import Iterator

from rich.console import RenderableType
from rich.text import Text

from camrob.report.post.plan_section import bound_text, gap_text, travel_unit
from camrob.report.terminal.tables import columns
from camrob.summaries.post_summary import AccuracyFigures, PlanFigures

__all__ = ["accuracy_text", "plan_lines"]

_MOST_CUTS = 8  # as many as a screen has room for; the JSON has all


def accuracy_text(accuracy: AccuracyFigures) -> str:
    """What was gained for the part, in a sentence."""
    before, after = accuracy.conditioning, accuracy.accuracy
    turns = ", ".join(f"{a} turns round {after.turns[a]} times in cuts, not {n}" for a, n in before.turns.items())
    kept = "" if accuracy.taken else "; the plan by conditioning is kept, as the other is no better"
    return (
        f"expected error of the part: {after.rms_mm:.3f} mm rms, {after.p95_mm:.3f} mm on 95 %, by conditioning alone "
        f"{before.rms_mm:.3f} and {before.p95_mm:.3f} mm{'; ' if turns else ''}{turns}{kept}"
    )


def plan_lines(plan: PlanFigures | None) -> Iterator[RenderableType]:
    """The curve from still to flowing with what was taken, the objective's terms, and re-postures; nothing without a plan."""
    if plan is None:
        return
    yield Text("")
    yield Text(f"Plan: {plan.chosen}, {plan.rule}", style="bold")
    keys = list(plan.curve[0].travel) if plan.curve else []
    travels = (f"{axis} {unit}" for axis, unit in map(travel_unit, keys))
    table = columns("", "plan", "1/k_F mean", "lowest", "% of bound", *travels, left=("", "plan"))
    for point in plan.curve:
        taken = point.name == plan.chosen
        moved = [f"{point.travel.get(key, 0.0):,.0f}" for key in keys]
        figures = [f"{point.inv_kf_mean:.3f}", f"{point.inv_kf_min:.3f}", f"{100.0 * point.share_of_bound:.2f}"]
        table.add_row("->" if taken else "", Text(point.name), *figures, *moved, style="bold" if taken else "")
    table.add_row("", "bound", f"{plan.bound_mean:.3f}", f"{plan.bound_min:.3f}", "100.00", style="green")
    yield table
    yield Text(gap_text(plan))
    if plan.proved is not None:
        yield Text(bound_text(plan.proved))
    shares = (f"{name.replace('_', ' ')} {100.0 * value:.1f} %" for name, value in plan.shares.items())
    yield Text(f"price by terms: {', '.join(shares)}")
    if plan.accuracy is not None:
        yield Text(accuracy_text(plan.accuracy))
    for cut in plan.cuts[:_MOST_CUTS]:
        where = "retract put in" if cut.inserted else "in a void motion"
        yield Text(f"re-posture at line {cut.line or '-'} ({where}, by {cut.by}): {cut.reason}")
    if len(plan.cuts) > _MOST_CUTS:
        yield Text(f"... and {len(plan.cuts) - _MOST_CUTS} more re-postures, in the report and NAME.json")
