"""A diagnosis in words: the first sentence, and the terminal's summary."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

__all__ = ["render_diagnosis", "sentence"]

Summary = Mapping[str, Any]

_RUNG = {
    "program_to_setpoint": "between program and set-point",
    "setpoint_to_encoder": "between set-point and encoder",
    "encoder_to_tcp": "between encoder and TCP",
}


def _plain(text: object) -> str:
    return "".join(c if c.isprintable() else " " for c in str(text))


def _named(entry: Mapping[str, Any]) -> str:
    axes = ", ".join(entry["axes"][:4])
    values = list(entry["parameters"].items())
    shown = f" ({values[0][0]} = {values[0][1]['value']:.4g})" if len(values) == 1 else ""
    return f"{entry['effect']}{f' of {axes}' if axes else ''}{shown}, {100.0 * entry['probability']:.0f} % sure"


def sentence(summary: Summary) -> str:
    """What a person has to know, in a few sentences."""
    gap, together = summary["gap"], summary["together"]
    rungs = {k: v for k, v in summary["where"]["rungs"].items() if v is not None}
    total = sum(v * v for v in rungs.values())
    if summary["status"] == "no gap":
        size, noise = f"{gap['rms_mm']:.3f} mm rms", f"{gap['noise_mm']:.3f} mm"
        return f"There is no gap beyond the instrument's noise: {size} with a noise of {noise}."
    most = max(rungs, key=lambda k: rungs[k])
    share = 100.0 * rungs[most] ** 2 / max(total, 1e-12)
    text = f"{share:.0f} % of the gap ({gap['rms_mm']:.3f} mm rms) sits {_RUNG[most]}"
    claimed = [e for e in summary["effects"] if e["probability"] >= 0.5]
    if claimed:
        text += ": " + "; ".join(_named(e) for e in claimed)
        text += (
            f". Adding {'it' if len(claimed) == 1 else 'them'} takes {together['rms_before_mm']:.3f} mm to "
            f"{together['rms_after_mm']:.3f} mm on samples that took no part ({together['withheld']}); the noise is "
            f"{gap['noise_mm']:.3f} mm."
        )
    else:
        text += ", and nothing in the library explains it."
    unknown = summary["unknown"]
    if unknown["probability"] >= 0.5:
        text += f" Something unknown is at work: {unknown['where'] or 'what stays hangs together beyond the noise'}."
    return _plain(text)


def render_diagnosis(summary: Summary) -> RenderableType:
    """The summary of `camrob diagnose` for a terminal."""
    parts: list[RenderableType] = [Text(sentence(summary), style="bold"), Text("")]
    table = Table(box=None, padding=(0, 2, 0, 0), header_style="bold")
    for heading in ("effect", "axes", "sure", "before mm", "after mm", "alone mm", "can't be told from"):
        table.add_column(heading, justify="left" if heading in ("effect", "axes") else "right")
    for e in summary["effects"]:
        table.add_row(
            Text(e["effect"]), Text(", ".join(e["axes"])), f"{100.0 * e['probability']:.0f} %", f"{e['rms_before_mm']:.3f}",
            f"{e['rms_after_mm']:.3f}", f"{e['alone']['rms_after_mm']:.3f}", Text(", ".join(e["indistinguishable_from"])),
        )  # fmt: skip
    if summary["effects"]:
        parts += [table, Text("")]
    rungs = ", ".join(
        f"{_RUNG[k].removeprefix('between ')} {'missing' if v is None else f'{v:.3f} mm'}"
        for k, v in summary["where"]["rungs"].items()
    )
    parts.append(Text(f"By rung: {rungs}"))
    parts += [Text(f"Note: {_plain(m)}") for m in summary["where"]["missing"]]
    parts.append(Text(f"Next experiment: {_plain(summary['next_experiment'])}"))
    return Group(*parts)
