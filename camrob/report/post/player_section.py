"""The player's place in the page: picture, controls, and the posture read out axis by axis."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from camrob.cell.cell import Cell
from camrob.report.page.html import escape
from camrob.report.page.viewer import ROLE_COLORS

__all__ = ["player_section"]

_SPEEDS = (1, 2, 5, 10, 20, 50, 100)  # times the program's own; player.js begins with the slowest that takes a minute
_ROLE_TEXT = {
    "arm": "arm",
    "spindle": "spindle",
    "tool": "tool",
    "carriage": "robot's foot and carriage",
    "table": "table",
    "floor": "floor and what stands on it",
    "part": "part",
    "stock": "stock",
}


def player_section(cell: Cell, scene: Mapping[str, Any], *, with_part: bool) -> str:
    """The frame of the player: picture, controls, and the posture read out axis by axis."""
    rows = []
    for k, name in enumerate(cell.axis_names):
        endless = cell.joints[cell.index(name)].endless
        gauge = '<div class="gauge endless" title="endless"></div>' if endless else '<div class="gauge"><i></i></div>'
        rows.append(f'<div class="axis" id="axis-{k}"><b>{escape(name)}</b>{gauge}<span class="v"></span></div>')
    run, stock = scene["run"], scene["stock"]
    roles = ["arm", "spindle", "tool", "carriage", "table", "floor"]
    roles += [*(["part"] if with_part else []), *(["stock"] if stock else [])]
    legend = "".join(f'<span><i style="background:{ROLE_COLORS[role]}"></i>{_ROLE_TEXT[role]}</span>' for role in roles)
    shown = [("show-path", "path", True)]
    shown += [("show-stock", "stock", True)] if stock else []
    shown += [("show-part", "part", not stock)] if with_part else []
    boxes = "".join(
        f'<label><input type="checkbox" id="{name}"{" checked" if on else ""}> {text}</label>'
        for name, text, on in shown
    )
    speeds = "".join(f'<option value="{v}">{v} ×</option>' for v in _SPEEDS)
    said = '<p class="said"><code id="said">&nbsp;</code></p>' if run["said"] is not None else ""
    cut = ""
    if stock:
        cut = (
            " The stock is shown as it is cut, the freshly cut surface lighter."
            if "sides" in stock
            else f" The stock is shown uncut: {escape(stock['uncut'])}."
        )
    thinned = (
        f" {run['count']:,} of {run['points']:,} points are shown; the others lie within {run['off']:.3f} mm of the lines "
        "between them."
        if run["off"] > 0.0
        else ""
    )
    near, nearest = "", ""
    if run["near"] is not None:
        near = '<div class="near-bodies"><b>Nearest</b> <span id="nearest"></span></div>'
        nearest = (
            " Nearest: the two bodies with the least room between them, at places spread evenly over the program, limbs next to "
            "each other and the tool beside what it cuts left out; they turn red below 100 mm."
        )
    return (
        '<section><h2>The program as it runs</h2><div class="stage"><div>'
        '<div id="view" role="img" aria-label="the cell in 3D, as it stands at the time below"></div>'
        '<div class="bar"><button id="play" type="button">Play</button>'
        '<button id="back" type="button" aria-label="one point back">‹</button>'
        '<input id="time" type="range" min="0" max="10000" value="0" aria-label="time in the program">'
        '<button id="forth" type="button" aria-label="one point on">›</button>'
        f'<span class="clock" id="clock"></span><select id="speed" aria-label="speed">{speeds}</select></div>'
        f'{said}<div class="bar"><button id="see-cell" type="button">Cell</button>'
        f'<button id="see-part" type="button">Part</button>{boxes}</div>'
        f'<div class="legend">{legend}<span><i style="background:#8a93a0"></i>travel through air</span></div></div>'
        f'<div class="readout"><div class="where" id="where"></div>{near}{"".join(rows)}'
        '<p class="caption">Bars span each axis from lower to upper limit; the mark turns red within 3 % of '
        "one.</p></div></div>"
        '<p class="caption">The path is coloured by 1/k<sub>F</sub>: blue and green well conditioned, amber at the '
        "threshold, red below; thick as far as the tool has come. Times are those of the controller's model, at 100 % "
        "override. Click on the path, or in a chart, to go there; the charts show where the robot is. Look for red stretches, "
        "and for the arm coming near the table or the part. The bodies are the cell's collision shapes."
        f"{nearest}{cut}{thinned}</p></section>"
    )
