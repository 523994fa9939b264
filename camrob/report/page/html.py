"""The skeleton of a report: escaping, data blocks, and one page that loads nothing and may load nothing."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import math
from collections.abc import Mapping, Sequence
from importlib.resources import files
from typing import Any

from plotly.offline import get_plotlyjs

from camrob.text import printable

__all__ = ["data_block", "escape", "number", "page", "plot_text"]

_JSON_ESCAPES = {"<": "\\u003c", ">": "\\u003e", "&": "\\u0026"}


def escape(value: object) -> str:
    """Text for HTML, between tags or in a quoted attribute; characters that don't print, and those that turn the
    direction of writing, become spaces.
    """
    return html.escape(printable(value), quote=True)


def plot_text(value: object) -> str:
    """Text for a chart. Plotly reads a little HTML and %{...} in its labels: neither survives."""
    return html.escape(printable(value).replace("%{", "% {"), quote=False)


def number(value: object, decimals: int = 1, unit: str = "") -> str:
    """A number with its unit as it is read, as HTML; an en dash where there is none. Very small ones get a power."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return "–"
    text = f"{value:,.{decimals}f}".replace("-", "−")
    if value != 0.0 and abs(value) < 0.5 * 10.0**-decimals:
        mantissa, power = f"{value:.1e}".split("e")
        text = f"{mantissa} × 10<sup>{int(power)}</sup>".replace("-", "−")
    space = "" if unit == "°" else " "
    return f"{text}{space}{escape(unit)}" if unit else text


def _finite(value: Any) -> Any:
    """The same data with null for every number that JSON can't hold."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return value


def data_block(name: str, data: Any) -> str:
    """A <script> element of the id `name` that holds data and is never run; nothing in `data` can end it."""
    text = json.dumps(_finite(data), ensure_ascii=True, allow_nan=False, separators=(",", ":"), sort_keys=True)
    for character, replacement in _JSON_ESCAPES.items():
        text = text.replace(character, replacement)
    return f'<script type="application/json" id="{escape(name)}">{text}</script>'


def _asset(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def _policy(scripts: Sequence[str]) -> str:
    """Content security policy: the page's own scripts by their hash, nothing from anywhere."""
    hashes = " ".join(f"'sha256-{base64.b64encode(hashlib.sha256(s.encode()).digest()).decode()}'" for s in scripts)
    return (
        f"default-src 'none'; script-src {hashes}; style-src 'unsafe-inline'; img-src data: blob:; "
        "connect-src 'none'; form-action 'none'; base-uri 'none'"
    )


def page(title: str, body: str, data: Mapping[str, Any]) -> str:
    """A whole HTML page. `body` is HTML; `data` is what page.js reads, block by block, under each key as an id."""
    scripts = [get_plotlyjs(), _asset("page.js")]
    for script in scripts:
        if "</script" in script.lower() or "\r" in script:
            raise ValueError("a script of the page can't be embedded: it holds a closing tag or a carriage return")
    blocks = "\n".join(data_block(name, value) for name, value in data.items())
    running = "\n".join(f"<script>{script}</script>" for script in scripts)
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{_policy(scripts)}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n'
        f"<title>{escape(title)}</title>\n<style>\n{_asset('page.css')}</style>\n</head>\n"
        f"<body>\n{body}\n{blocks}\n{running}\n</body>\n</html>\n"
    )
