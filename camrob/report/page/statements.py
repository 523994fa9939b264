"""What a paper states beside what was found, as a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from camrob.report.page.html import escape

__all__ = ["Statement", "statements_section"]

_TAGS = {"holds": "info", "does not hold": "error", "unclear": "warning"}


class Statement(NamedTuple):
    """What the paper states, what was found, and the verdict: holds, does not hold, unclear."""

    published: str
    found: str
    verdict: str


def statements_section(statements: Sequence[Statement]) -> str:
    """The table as HTML."""
    rows = "".join(
        f'<tr><td class="text">{escape(s.published)}</td><td class="text">{escape(s.found)}</td>'
        f'<td><span class="tag {_TAGS[s.verdict]}">{escape(s.verdict)}</span></td></tr>'
        for s in statements
    )
    return (
        "<section><h2>What the paper states, and what was found</h2><table><thead><tr><th>published</th><th>found</th>"
        f"<th></th></tr></thead><tbody>{rows}</tbody></table></section>"
    )
