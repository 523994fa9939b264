"""The skeleton of a report: escaping, data blocks, and one page that loads nothing and may load nothing."""

from __future__ import annotations

import base64
import gzip
import hashlib
import html
import json
import math
import re
from collections.abc import Mapping, Sequence
from importlib.resources import files
from typing import Any

from camrob.report.page.pack import PackedArray
from camrob.report.words import shown_duration
from camrob.text import printable

__all__ = ["data_block", "duration", "escape", "number", "page", "plot_text", "prose"]

_PACKED_FROM = 4_000  # characters: below, packing saves nothing that is felt
_EFFORT = 6  # of gzip: 9 takes three times as long for 1 % less
_SECTIONS = 4  # from so many on a page has contents
_SECTION = re.compile(r"<section><h2>(.*?)</h2>")
_BELOW_VERDICT = re.compile(r'<section|<div class="cards')
_SYMBOL = re.compile(r"\b([khpW])_(F|cond|jnt)\b")  # those of the method, as plain text has them
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_JSON_ESCAPES = {"<": "\\u003c", ">": "\\u003e", "&": "\\u0026"}


def escape(value: object) -> str:
    """Text for HTML, between tags or in a quoted attribute; characters that don't print, and those that turn the
    direction of writing, become spaces.
    """
    return html.escape(printable(value), quote=True)


def prose(value: object) -> str:
    """Text for HTML as `escape` makes it, with the method's symbols as they are printed: k_F with a subscript."""
    return _SYMBOL.sub(r"\1<sub>\2</sub>", escape(value))


def plot_text(value: object) -> str:
    """Text for a chart. Plotly reads a little HTML and %{...} in its labels: neither survives."""
    return _SYMBOL.sub(r"\1<sub>\2</sub>", html.escape(printable(value).replace("%{", "% {"), quote=False))


def number(value: object, decimals: int = 1, unit: str = "") -> str:
    """A number with its unit as it is read, as text or HTML; an en dash where there is none. Very small ones get a power."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return "–"
    text = f"{value:,.{decimals}f}".replace("-", "−")
    if value != 0.0 and abs(value) < 0.5 * 10.0**-decimals:
        mantissa, power = f"{value:.1e}".split("e")
        text = f"{mantissa} × 10{str(int(power)).translate(_RAISED)}".replace("-", "−")
    space = "" if unit == "°" else " "
    return f"{text}{space}{escape(unit)}" if unit else text


def duration(seconds: object) -> str:
    """A time as a machinist reads it: "4 min 12 s"."""
    return shown_duration(seconds).replace("-", "–")


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
    """A <script> element of the id `name` that holds data and is never run; nothing in `data` can end it.

    Long ones, and those that hold a `PackedArray`, are packed: the JSON, a zero, and the arrays' bytes; gzip, then base64.
    """
    arrays: list[bytes] = []

    def placed(value: Any) -> Any:
        if not isinstance(value, PackedArray):
            raise TypeError(f"{type(value).__name__} is nothing that a page's data can hold")
        at = sum(len(array) for array in arrays)
        arrays.append(value.data)
        return value.place(at)

    text = json.dumps(
        _finite(data), ensure_ascii=True, allow_nan=False, separators=(",", ":"), sort_keys=True, default=placed
    )
    if arrays or len(text) > _PACKED_FROM:
        whole = b"\0".join([text.encode(), b"".join(arrays)])
        return f'<script type="application/gzip" id="{escape(name)}">{_base64(_gzip(whole))}</script>'
    for character, replacement in _JSON_ESCAPES.items():
        text = text.replace(character, replacement)
    return f'<script type="application/json" id="{escape(name)}">{text}</script>'


def _gzip(data: bytes) -> bytes:
    """The same bytes for the same data, at any time."""
    return gzip.compress(data, _EFFORT, mtime=0)


def _base64(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")


def _asset(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def _libraries(data: Mapping[str, Any]) -> dict[str, tuple[str, bytes]]:
    """What the page draws with: the script of each library, and the same packed."""
    wanted = {}
    if data.get("charts"):
        wanted["plotly"] = _vendored("plotly-basic.min.js.gz")
    if data.get("scene"):
        wanted["three"] = _vendored("three.min.js.gz")
    return wanted


def _vendored(name: str) -> tuple[str, bytes]:
    packed = files(__package__).joinpath("vendor", name).read_bytes()
    return gzip.decompress(packed).decode("utf-8"), packed


def _policy(scripts: Sequence[str]) -> str:
    """Content security policy: the page's own scripts by their hash, nothing from anywhere."""
    hashes = " ".join(f"'sha256-{_base64(hashlib.sha256(s.encode()).digest())}'" for s in scripts)
    return (
        f"default-src 'none'; script-src {hashes}; style-src 'unsafe-inline'; img-src data: blob:; "
        "connect-src 'none'; form-action 'none'; base-uri 'none'"
    )


def _with_contents(body: str) -> str:
    """The same page with a line of links to its sections behind the verdict, where it has as many as one scrolls through."""
    titles: list[str] = []

    def anchored(found: re.Match[str]) -> str:
        titles.append(found[1])
        return f'<section id="part-{len(titles)}"><h2>{found[1]}</h2>'

    named = _SECTION.sub(anchored, body)
    begin = _BELOW_VERDICT.search(named)
    if len(titles) < _SECTIONS or begin is None:
        return body
    links = "".join(f'<a href="#part-{k}">{name}</a>' for k, name in enumerate(titles, 1))
    return f'{named[: begin.start()]}<nav aria-label="Contents">{links}</nav>\n{named[begin.start() :]}'


def page(title: str, body: str, data: Mapping[str, Any]) -> str:
    """A whole HTML page. `body` is HTML; `data` is what its scripts read, block by block, under each key as an id: `charts`
    for page.js, `clouds` for cloud.js, `scene` for player.js. Libraries come packed, and only those that are drawn with.
    """
    libraries = _libraries(data)
    player = ("player_path.js", "player_stock.js", "player.js") if data.get("scene") else ()
    cloud = ("cloud.js",) if data.get("clouds") else ()
    own = [_asset(name) for name in ("page.js", *cloud, *player, "start.js")]
    for script in own:
        if "</script" in script.lower() or "\r" in script:
            raise ValueError("a script of the page can't be embedded: it holds a closing tag or a carriage return")
    blocks = "\n".join(data_block(name, value) for name, value in data.items())
    packed = "\n".join(
        f'<script type="application/gzip" class="library" id="library-{name}">{_base64(code)}</script>'
        for name, (_, code) in libraries.items()
    )
    running = "\n".join(f"<script>{script}</script>" for script in own)
    policy = _policy([*(text for text, _ in libraries.values()), *own])
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n'
        f"<title>{escape(title)}</title>\n<style>\n{_asset('page.css')}</style>\n</head>\n"
        f"<body>\n{_with_contents(body)}\n{blocks}\n{packed}\n{running}\n</body>\n</html>\n"
    )
