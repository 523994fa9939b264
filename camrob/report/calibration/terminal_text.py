"""What `calibrate` and `compensate` show a person in the terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from camrob.report.words import shown_text

__all__ = ["render_calibration", "render_compensation"]

Summary = Mapping[str, Any]

_STAGES = {
    "nominal": "nominal robot",
    "frames": "base and tool fitted alone",
    "calibrated": "calibrated",
}
_DECIMALS = {"mm": 4, "deg": 5}


def _table(*columns: str) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0), show_edge=False)
    for k, column in enumerate(columns):
        table.add_column(column, justify="left" if k == 0 else "right")
    return table


def _value(value: float | None, decimals: int) -> str:
    return "-" if value is None else f"{value:.{decimals}f}"


def _errors(rows: Mapping[str, Summary]) -> Table:
    table = _table("errors", "poses", "mean mm", "95 % mm", "worst mm", "mean deg", "worst deg")
    for name, size in rows.items():
        numbers = [_value(size.get(key), 4) for key in ("mean_mm", "p95_mm", "max_mm", "mean_deg", "max_deg")]
        table.add_row(name, str(size.get("poses", "-")), *numbers)
    return table


def _warnings(summary: Summary) -> list[RenderableType]:
    return [shown_text(f"! {w['text']}" + (f" (line {w['line']})" if w["line"] else "")) for w in summary["warnings"]]


def _published(rows: Sequence[Summary]) -> Table:
    """A paper's figures beside ours."""
    table = _table("", "published", "ours")
    for row in rows:
        table.add_row(row["what"], row["published"], row["ours"])
    return table


def render_calibration(summary: Summary) -> RenderableType:
    """Errors by stage, the parameters with their standard errors, and those that the poses do not tell."""
    rows = {}
    for stage, size in summary["errors"].items():
        name, _, part = stage.partition("/")
        rows[f"{_STAGES.get(name, name)}, {part}"] = size
    parameters = _table("parameter", "value", "+-", "")
    for p in summary["parameters"]:
        decimals = _DECIMALS.get(p["unit"])
        shown = [f"{p[key]:.{decimals}f}" if decimals else f"{p[key]:.3g}" for key in ("value", "std")]
        parameters.add_row(p["name"], *shown, p["unit"] + (" (instrument)" if p["nuisance"] else ""))
    parts: list[RenderableType] = [*_warnings(summary), _errors(rows), Text(), parameters]
    for why, told in (
        ("merged", "part of others in these poses"),
        ("unseen", "without effect in these poses"),
        ("weak", "too weak in these poses"),
    ):
        names = [h["name"] for h in summary["held"] if h["why"] == why]
        if names:
            parts += [Text(), Text(f"{told}: {', '.join(names)}")]
    for log in summary["withheld"]:
        if log["refitted"]:
            told = f"{log['file']}: base and reflector refitted on half of it, judged on {log['poses']} poses"
            parts += [Text(), shown_text(told)]
    if "published" in summary:
        parts += [Text(), _published(summary["published"])]
    wrote = f"wrote {summary['file']} and {summary['report']}"
    parts += [Text(), shown_text(f"{summary['poses']} poses fitted, {summary['outliers']} outliers, {wrote}")]
    if "next" in summary:
        plan = summary["next"]
        if not plan["collisions"]["checked"]:
            parts.append(Text("! the cell has no bodies: the way between these poses isn't checked for collisions"))
        parts.append(
            Text(
                f"{plan['poses']} poses to measure next: expected error on the path "
                f"{plan['expected_before_mm']:.4f} mm, then {plan['expected_after_mm']:.4f} mm"
            )
        )
    return Group(*parts)


def render_compensation(summary: Summary) -> RenderableType:
    """Errors of the calibrated robot with the old and the new program."""
    rows = {
        "calibrated robot, program as it was": summary["error_before"],
        "compensated program": summary["error_after"],
    }
    if summary["error_between"] is not None:
        rows["half-way through its LINs"] = summary["error_between"]
    iterations = summary["iterations"]
    return Group(
        *_warnings(summary),
        _errors({name: {"poses": summary["motions"], **size} for name, size in rows.items()}),
        Text(),
        shown_text(
            f"largest correction {summary['correction']['max_mm']:.3f} mm, at most {iterations['max']} iterations a "
            f"point; wrote {', '.join(summary['files'])}"
        ),
    )
