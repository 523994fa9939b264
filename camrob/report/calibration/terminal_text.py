"""What `calibrate` and `compensate` show a person in the terminal."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from camrob.report.terminal.tables import columns
from camrob.report.words import shown_text
from camrob.summaries.calibration_summary import CalibrationSummary, PublishedFigure
from camrob.summaries.compensate_summary import CompensateSummary, OnDiagnosedMachine
from camrob.summaries.predict_summary import LikelySize
from camrob.summaries.remarks import Remark

__all__ = ["render_calibration", "render_compensation"]

_STAGES = {
    "nominal": "nominal robot",
    "frames": "base and tool fitted alone",
    "calibrated": "calibrated",
}
_DECIMALS = {"mm": 4, "deg": 5}  # 0.1 micrometres, and 0.2 of them at a radius of 1 m


def _value(value: float | None, decimals: int) -> str:
    return "-" if value is None else f"{value:.{decimals}f}"


def _errors(rows: Iterable[tuple[str, int, Sequence[float | None]]]) -> Table:
    """Names, poses, and errors: mean, 95 % and worst in mm, mean and worst in degrees."""
    table = columns("errors", "poses", "mean mm", "95 % mm", "worst mm", "mean deg", "worst deg", left=("errors",))
    for name, poses, values in rows:
        table.add_row(name, str(poses), *(_value(value, 4) for value in values))
    return table


def _warnings(warnings: Sequence[Remark]) -> list[RenderableType]:
    return [shown_text(f"! {w.text}" + (f" (line {w.line})" if w.line else "")) for w in warnings]


def _published(rows: Sequence[PublishedFigure]) -> Table:
    """A paper's figures beside ours."""
    table = columns("", "published", "ours", left=("",))
    for row in rows:
        table.add_row(row.what, row.published, row.ours)
    return table


def render_calibration(summary: CalibrationSummary) -> RenderableType:
    """Errors by stage, the parameters with their standard errors, and those that the poses do not determine."""
    found, rows = summary.figures, []
    for stage, size in found.errors.items():
        name, _, part = stage.partition("/")
        values = (size.mean_mm, size.p95_mm, size.max_mm, size.mean_deg, size.max_deg)
        rows.append((f"{_STAGES.get(name, name)}, {part}", size.poses, values))
    parameters = columns("parameter", "value", "+-", "", left=("parameter",))
    for p in found.parameters:
        decimals = _DECIMALS.get(p.unit)
        shown = [f"{v:.{decimals}f}" if decimals else f"{v:.3g}" for v in (p.value, p.std)]
        notes = ("(instrument)" if p.nuisance else "", "may be 0" if p.may_be_none else "")
        parameters.add_row(p.name, *shown, " ".join((p.unit, *filter(None, notes))))
    parts: list[RenderableType] = [*_warnings(found.warnings), _errors(rows), Text(), parameters]
    for why, title in (
        ("merged", "part of others in these poses"),
        ("unseen", "without effect in these poses"),
        ("weak", "too weak in these poses"),
    ):
        names = [h.name for h in found.held if h.why == why]
        if names:
            parts += [Text(), Text(f"{title}: {', '.join(names)}")]
    for log in summary.withheld:
        if log.refitted:
            text = f"{log.file}: base and reflector refitted on half of it, judged on {log.poses} poses"
            parts += [Text(), shown_text(text)]
    if summary.published is not None:
        parts += [Text(), _published(summary.published)]
    wrote = f"wrote {summary.file} and {summary.report}"
    parts += [Text(), shown_text(f"{found.poses} poses fitted, {found.outliers} outliers, {wrote}")]
    plan = summary.next
    if plan is not None:
        if not plan.collisions.checked:
            parts.append(Text("! the cell has no bodies: the way between these poses isn't checked for collisions"))
        parts.append(
            Text(
                f"{plan.poses} poses to measure next: expected error on the path "
                f"{plan.expected_before_mm:.4f} mm, then {plan.expected_after_mm:.4f} mm"
            )
        )
    return Group(*parts)


def render_compensation(summary: CompensateSummary) -> RenderableType:
    """Errors of the calibrated robot with the old and the new program."""
    sizes = (
        ("calibrated robot, program as it was", summary.error_before),
        ("compensated program", summary.error_after),
        ("half-way through its LINs", summary.error_between),
    )
    rows = [
        (name, summary.motions, (size.mean_mm, None, size.max_mm, size.mean_deg, size.max_deg))
        for name, size in sizes
        if size is not None
    ]
    return Group(
        *_warnings(summary.warnings),
        _errors(rows),
        *_on_machine(summary.machine),
        Text(),
        shown_text(
            f"largest correction {summary.correction.max_mm:.3f} mm, at most {summary.iterations.max} iterations a "
            f"point; wrote {', '.join(summary.files)}"
        ),
    )


def _on_machine(found: OnDiagnosedMachine | None) -> list[RenderableType]:
    """Off the path on the machine as diagnosed, before and after."""
    if found is None:
        return []
    of = "off the path, machine as diagnosed"
    grid = columns(of, "rms mm", "95 % mm", "worst mm", left=(of,))
    for name, size in found.steps():
        grid.add_row(name, *(f"{v:.4f}" for v in (size.rms_mm, size.p95_mm, size.max_mm)))
    more = (
        f"corrected beyond constants: {', '.join(found.causes)}"
        if found.causes
        else "nothing beyond constants was corrected"
    )
    if count := sum(map(len, found.targets_added.values())):
        more += f"; {count:,} targets added within lines"
    said = [] if found.likely is None else [shown_text(_likely(found.likely))]
    return [Text(), grid, *said, shown_text(more)]


def _likely(found: LikelySize) -> str:
    """How far off the tool is with all that the diagnosis leaves open."""
    between = f"{found.p95_low_mm:.3f} to {found.p95_high_mm:.3f}"
    return f"as written, with all that the diagnosis leaves open: 95 % likely within {found.p95_mm:.3f} mm ({between})"
