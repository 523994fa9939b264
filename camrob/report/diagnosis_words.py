"""A diagnosis in words: the first sentence, and the terminal's summary."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from camrob.text import printable

__all__ = ["compensable_text", "render_diagnosis", "sentence", "standards_text"]

Summary = Mapping[str, Any]

_RUNG = {
    "program_to_setpoint": "between program and set-point",
    "setpoint_to_encoder": "between set-point and encoder",
    "encoder_to_tcp": "between encoder and TCP",
}


_FOLLOWS = {
    "position": "follows the position",
    "direction": "reverses with the direction of motion",
    "speed": "grows with speed",
    "acceleration": "grows with acceleration",
    "load": "follows the load",
    "time": "drifts with time",
}
_UNITS = {"deg": "degrees", "mm": "mm", "s": "s", "kg": "kg"}
_FIRST = "program_to_setpoint"


def _value(name: str, value: float) -> str:
    """A parameter as people say it: its unit behind, where its name ends in one."""
    unit = _UNITS.get(name.rpartition("_")[2])
    return f", {value:.3g} {unit}" if unit else f" ({name} = {value:.3g})"


def _named(entry: Mapping[str, Any]) -> str:
    axes = ", ".join(entry["axes"][:4])
    values = list(entry["parameters"].items())
    shown = _value(values[0][0], values[0][1]["value"]) if len(values) == 1 else ""
    return f"{entry['effect']}{f' of {axes}' if axes else ''}{shown} ({100.0 * entry['probability']:.0f} % sure)"


def _follows(summary: Summary) -> str:
    """What the gap depends on most, where that is clear."""
    shares = {k: v for k, v in summary["where"]["regimes"].items() if v is not None}
    most = max(shares, key=lambda k: shares[k], default="")
    return f" and {_FOLLOWS[most]}" if most in _FOLLOWS and shares[most] > 0.5 else ""


def _only_first(entry: Mapping[str, Any]) -> bool:
    return list(entry["rungs"]) == [_FIRST]


def sentence(summary: Summary) -> str:
    """What a person has to know, in a few sentences."""
    gap, together = summary["gap"], summary["together"]
    rungs = {k: v for k, v in summary["where"]["rungs"].items() if v is not None}
    claimed = [e for e in summary["effects"] if e["probability"] >= 0.5]
    inside, first = [e for e in claimed if not _only_first(e)], [e for e in claimed if _only_first(e)]
    if summary["status"] == "no gap":
        size, noise = f"{gap['rms_mm']:.3f} mm rms", f"{gap['noise_mm']:.3f} mm"
        return f"There is no gap beyond the instrument's noise: {size} with a noise of {noise}."
    total = sum(v * v for v in rungs.values())
    most = max(rungs, key=lambda k: rungs[k])
    share = 100.0 * rungs[most] ** 2 / max(total, 1e-12)
    known = "what the rungs show" if most == _FIRST else f"the gap ({gap['rms_mm']:.3f} mm rms)"
    text = f"{share:.0f} % of {known} sits {_RUNG[most]}"
    if inside:
        text += f"{_follows(summary)}: " + "; ".join(_named(e) for e in inside)
        text += (
            f". Adding {'it' if len(inside) == 1 else 'them'} takes {together['rms_before_mm']:.3f} mm to "
            f"{together['rms_after_mm']:.3f} mm on samples that took no part ({together['withheld']}); the noise is "
            f"{gap['noise_mm']:.3f} mm."
        )
    elif first:
        text += "."
    else:
        text += ", and nothing in the library explains it."
    for e in first:
        sizes = f"{e['rms_before_mm']:.3f} mm are {e['rms_after_mm']:.3f} mm"
        text += f" Between program and set-point: {_named(e)}; without it {sizes}."
    unknown = summary["unknown"]
    if unknown["probability"] >= 0.5:
        text += f" Something unknown is at work: {unknown['where'] or 'what stays hangs together beyond the noise'}."
    return printable(text)


def compensable_text(summary: Summary) -> str:
    """What `compensate` can make of it; "" where nothing is claimed."""
    told = summary.get("compensable", {})
    if not told or not (told["effects"] or told["left"]):
        return ""
    if not told["effects"]:
        return printable(f"Of this compensate corrects nothing ({', '.join(told['left'])}).")
    left = f"; it leaves {', '.join(told['left'])}" if told["left"] else ""
    sizes = f"{told['rms_before_mm']:.3f} mm to {told['rms_after_mm']:.3f} mm"
    return printable(f"compensate corrects {', '.join(told['effects'])}: {sizes}{left}.")


def standards_text(one: Mapping[str, Any]) -> str:
    """One line on a run that is a line or a circle."""
    parts = []
    for when in ("before", "after"):
        told = one[when]
        if one["shape"] == "line":
            values = [
                f"{name} AT {d['AT_mm']:.3f} mm" + ("" if d["RT_mm"] is None else f", RT {d['RT_mm']:.3f} mm")
                for name, d in told.items()
            ]
        else:
            values = [f"{name} G {told[name]['G_mm']:.3f} mm" for name in ("ccw", "cw") if name in told]
            values += [
                f"{n[:-3].replace('_', ' ')} {told[n]:.3f} mm" for n in ("G_b_mm", "H_mm") if told.get(n) is not None
            ]
        parts.append(f"{when}: {', '.join(values)}")
    size = (
        f"line of {one['length_mm']:.0f} mm"
        if one["shape"] == "line"
        else f"circle of radius {one['radius_mm']:.1f} mm"
    )
    return printable(f"{one['standard']}, {one['log']}, {size}; {'; '.join(parts)}")


def render_diagnosis(summary: Summary) -> RenderableType:
    """The summary of `camrob diagnose` for a terminal."""
    parts: list[RenderableType] = [Text(sentence(summary), style="bold"), Text("")]
    table = Table(box=None, padding=(0, 2, 0, 0), header_style="bold")
    for heading in ("effect", "axes", "sure", "before mm", "after mm", "alone mm"):
        words = heading in ("effect", "axes")
        table.add_column(heading, justify="left" if words else "right", no_wrap=heading != "axes")
    for e in summary["effects"]:
        table.add_row(
            Text(e["effect"]), Text(", ".join(e["axes"])), f"{100.0 * e['probability']:.0f} %", f"{e['rms_before_mm']:.3f}",
            f"{e['rms_after_mm']:.3f}", f"{e['alone']['rms_after_mm']:.3f}",
        )  # fmt: skip
    if summary["effects"]:
        parts += [table, Text("")]
    for e in summary["effects"]:
        if e["probability"] >= 0.5 and e["indistinguishable_from"]:
            parts.append(
                Text(
                    f"On these logs {' or '.join(e['indistinguishable_from'])} would show nearly the same as {e['effect']}."
                )
            )
    rungs = ", ".join(
        f"{_RUNG[k].removeprefix('between ')} {'missing' if v is None else f'{v:.3f} mm'}"
        for k, v in summary["where"]["rungs"].items()
    )
    parts.append(Text(f"By rung: {rungs}"))
    parts += [Text(f"Note: {printable(m)}") for m in summary["where"]["missing"]]
    parts += [Text(standards_text(one)) for one in summary.get("standards", [])]
    if compensable_text(summary):
        parts.append(Text(compensable_text(summary)))
    parts.append(Text(f"Next experiment: {printable(summary['next_experiment'])}"))
    return Group(*parts)
