"""Parts that reports of figures share: tables, cards, places for charts."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from html import unescape
from typing import Any

from camrob.report.page.html import escape

__all__ = ["card_row", "chart_place", "figure", "section", "table", "verdict_bar"]

_TAG = re.compile(r"<[^>]*>")
_LONGEST_NUMBER = 26  # characters as read: a number with its unit and its spread, such as "-1,234.567 ± 0.123 mm/s"


def verdict_bar(level: str, word: str, text: str) -> str:
    """What a page comes to, first of all: a word and a sentence (HTML). level: "good", "warn", "info" or "bad"."""
    return f'<div class="verdict {level}"><strong>{word}</strong><span>{text}</span></div>'


def section(title: str, *parts: str) -> str:
    """A section with a title (text) and parts (HTML)."""
    return f"<section><h2>{escape(title)}</h2>{''.join(parts)}</section>"


def table(headings: Sequence[str], rows: Sequence[Sequence[str]], *, left: int = 1, whole: bool = False) -> str:
    """A table of HTML cells; the first `left` columns are words, the others numbers. whole: shown in its full height.

    Words in a number's place, such as why there is none, run on in lines: unbroken they would push the rest off the page.
    """
    sort = ["text" if k < left else "n" for k in range(len(headings))]
    head = "".join(f'<th class="{s if s == "n" else ""}">{escape(h)}</th>' for s, h in zip(sort, headings, strict=True))
    body = "".join(
        "<tr>" + "".join(f'<td class="{_shown_as(s, c)}">{c}</td>' for s, c in zip(sort, row, strict=True)) + "</tr>"
        for row in rows
    )
    frame = "scroll whole" if whole else "scroll"
    return f'<div class="{frame}"><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'


def _shown_as(sort: str, cell: str) -> str:
    return "text" if sort == "n" and len(unescape(_TAG.sub("", cell))) > _LONGEST_NUMBER else sort


def card_row(cards: Sequence[tuple[str, str, str]]) -> str:
    """Cards: what (text), value (HTML), note (text)."""
    items = "".join(
        f'<div class="card"><div class="what">{escape(what)}</div><div class="value">{value}</div>'
        f'<div class="note">{escape(note)}</div></div>'
        for what, value, note in cards
    )
    return f'<div class="cards">{items}</div>'


def figure(chart: Mapping[str, Any]) -> str:
    """A chart's place in the page: its title and caption are text."""
    height = int(chart["layout"]["height"])
    return section(
        str(chart["title"]),
        f'<div class="chart" id="{escape(chart["id"])}" style="height:{height}px"></div>'
        f'<p class="caption">{escape(chart["caption"])}</p>',
    )


def chart_place(chart: Mapping[str, Any]) -> str:
    """A chart's place in the page: its title, caption and legend, where it has one, are HTML."""
    height = int(chart["layout"]["height"])
    return (
        f'<section><h2>{chart["title"]}</h2><div class="chart" id="{chart["id"]}" style="height:{height}px"></div>'
        f'{chart.get("legend", "")}<p class="caption">{chart["caption"]}</p></section>'
    )
