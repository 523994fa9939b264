"""What a paper states beside what was found, as a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from camrob.report.page.html import escape, prose
from camrob.report.page.parts import framed, section, verdict_bar

__all__ = ["Statement", "statements_section", "statements_verdict"]

_TAGS = {"holds": "info", "does not hold": "error", "unclear": "warning"}


class Statement(NamedTuple):
    """What the paper states, what was found, and the verdict: holds, does not hold, unclear."""

    published: str
    found: str
    verdict: str


def statements_section(statements: Sequence[Statement]) -> str:
    """The table as HTML."""
    rows = "".join(
        f'<tr><td class="text">{prose(s.published)}</td><td class="text">{prose(s.found)}</td>'
        f'<td><span class="tag {_TAGS[s.verdict]}">{escape(s.verdict)}</span></td></tr>'
        for s in statements
    )
    head = "<thead><tr><th>the paper states</th><th>found here</th><th>it</th></tr></thead>"
    return section("What the paper states, and what was found", framed(f"<table>{head}<tbody>{rows}</tbody></table>"))


def statements_verdict(statements: Sequence[Statement]) -> str:
    """What they come to, as the page's verdict."""
    counts = {verdict: sum(s.verdict == verdict for s in statements) for verdict in _TAGS}
    said = [
        f"{n} {'does' if n == 1 else 'do'} not hold"
        if v == "does not hold"
        else f"{n} {'is' if n == 1 else 'are'} unclear"
        for v, n in counts.items()
        if n and v != "holds"
    ]
    word = f"{counts['holds']} of the paper's {len(statements)} statements {'holds' if counts['holds'] == 1 else 'hold'} here."
    return verdict_bar("info", word, f"{', '.join(said).capitalize()}." if said else "")
