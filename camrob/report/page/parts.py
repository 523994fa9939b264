"""Parts that reports of figures share: tables, cards, places for charts."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from html import unescape
from typing import Any

from camrob.report.page.html import escape, prose

__all__ = [
    "TABLE",
    "TABLE_END",
    "card_row",
    "chart_box",
    "chart_place",
    "chooser",
    "figure",
    "framed",
    "page_body",
    "place_link",
    "section",
    "table",
    "verdict_bar",
    "verdict_lines",
]

TABLE, TABLE_END = '<div class="scroll whole"><table>', "</table></div>"
"""A table's begin and end, for those that are written cell by cell: it scrolls where it is wider than the page."""

_COMPLETE = "This page is complete in itself: it loads nothing and sends nothing."
_TAG = re.compile(r"<[^>]*>")
_LONGEST_NUMBER = 26  # characters as read: a number with its unit and its spread, such as "-1,234.567 ± 0.123 mm/s"
_LONGEST_RANGE = 44  # of a cell that begins as a number, such as "0.368 mm (0.319 mm to 0.425 mm)"
_WHOLE = 40  # rows: so many are shown at once, where more are scrolled through
_BEGINS_AS_NUMBER = re.compile(r"(under |over )?[-−+±]?\d")


def page_body(title: str, made: str, *parts: str, note: str = "") -> str:
    """The body of a page: its title, what that is of or made from, its parts from top to bottom (all HTML, "" for a part that has
    nothing to show), and below them a note and who made it.
    """
    below = f'<p class="made">{made}</p>' if made else ""
    said = f"{note} {_COMPLETE}" if note else _COMPLETE
    head, foot = f"<header><h1>{title}</h1>{below}</header>", f"<footer>Made by camrob. {said}</footer>"
    return "\n".join(["<main>", head, *parts, f"{foot}</main>"])


def place_link(line: object, *, words: object = None, page: str = "", of: str = "cl-line") -> str:
    """A line (of the CL file, or of="program-line") as a link to where the player stands there (HTML): on this page, or on the
    one at the address `page`. words: what is shown; the line itself where that is left out.
    """
    shown = escape(line if words is None else words)
    return f'<a href="{escape(page)}#{of}={escape(line)}">{shown}</a>'


def verdict_bar(level: str, word: str, text: str) -> str:
    """What a page comes to, first of all: a word and a sentence (HTML). level: "good", "warn", "info" or "bad"."""
    return f'<div class="verdict {level}"><strong>{word}</strong><span>{text}</span></div>'


def verdict_lines(level: str, word: str, lines: Sequence[tuple[str, str]]) -> str:
    """What a page comes to, first of all: a word, and lines that have a heading each (HTML). level: as of `verdict_bar`."""
    rows = "".join(f"<div><dt>{name}</dt><dd>{text}</dd></div>" for name, text in lines)
    return f'<div class="verdict lines {level}"><strong>{word}</strong><dl>{rows}</dl></div>'


def section(title: str, *parts: str) -> str:
    """A section with a title (text) and parts (HTML)."""
    return f"<section><h2>{escape(title)}</h2>{''.join(parts)}</section>"


def framed(table: str, *, whole: bool = True) -> str:
    """A table (HTML) in a frame that scrolls where it is wider than the page, or higher than a screen unless `whole`."""
    return f'<div class="scroll{" whole" if whole else ""}">{table}</div>'


def table(headings: Sequence[str], rows: Sequence[Sequence[str]], *, left: int = 1) -> str:
    """A table of HTML cells; the first `left` columns are words, the others numbers. Many rows are scrolled through.

    Words in a number's place, such as why there is none, run on in lines: unbroken they would push the rest off the page.
    """
    columns = [[_shown_as(row[k]) for row in rows] for k in range(len(headings))]
    sort = ["text" if k < left or ("text" in cells and "n" not in cells) else "n" for k, cells in enumerate(columns)]
    head = "".join(f'<th class="{s if s == "n" else ""}">{prose(h)}</th>' for s, h in zip(sort, headings, strict=True))
    body = "".join(
        "<tr>" + "".join(f'<td class="{_class_of(s, c)}">{c}</td>' for s, c in zip(sort, row, strict=True)) + "</tr>"
        for row in rows
    )
    return framed(f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>", whole=len(rows) <= _WHOLE)


def chooser(
    title: str, lists: Mapping[str, Sequence[str]], choices: Mapping[tuple[str, ...], str], note: str = ""
) -> str:
    """A section of which one part is shown at a time. lists: of each list its name and its words; choices: the part (HTML) of
    a word of each list; note: HTML.
    """
    picked = "".join(
        f"<label>{escape(name)} <select>"
        + "".join(f"<option>{escape(word)}</option>" for word in words)
        + "</select></label>"
        for name, words in lists.items()
    )
    parts = "".join(
        f'<div class="choice" data-choice="{escape(" ".join(words))}">{html}</div>' for words, html in choices.items()
    )
    return section(title, f'<div class="choose">{picked}</div>', parts, note)


def _shown_as(cell: str) -> str:
    """Whether a cell is words, which run on in lines, or a number, which does not; "" for an empty one."""
    read = _plain(cell)
    longest = _LONGEST_RANGE if _BEGINS_AS_NUMBER.match(read) else _LONGEST_NUMBER
    return ("text" if len(read) > longest else "n") if read else ""


def _class_of(sort: str, cell: str) -> str:
    return _shown_as(cell) or sort if sort == "n" else sort


def _plain(html: str) -> str:
    return unescape(_TAG.sub("", html))


def card_row(cards: Sequence[tuple[str, str, str]]) -> str:
    """Cards: what (text), value (HTML), note (text)."""
    items = "".join(
        f'<div class="card"><div class="what">{prose(what)}</div><div class="value">{value}</div>'
        f'<div class="note">{prose(note)}</div></div>'
        for what, value, note in cards
    )
    return f'<div class="cards">{items}</div>'


def chart_box(name: str, title: str, height: int) -> str:
    """Where page.js draws the chart of this id; title (HTML): what it is called to those who don't see it."""
    called = escape(f"chart: {_plain(title)}")
    return (
        f'<div class="chart" id="{escape(name)}" role="figure" aria-label="{called}" style="height:{height}px"></div>'
    )


def figure(chart: Mapping[str, Any]) -> str:
    """A chart's place in the page: its title and caption are text."""
    title = str(chart["title"])
    box = chart_box(chart["id"], escape(title), int(chart["layout"]["height"]))
    return section(title, box, f'<p class="caption">{prose(chart["caption"])}</p>')


def chart_place(chart: Mapping[str, Any]) -> str:
    """A chart's place in the page: its title, caption and legend, where it has one, are HTML."""
    return (
        f"<section><h2>{chart['title']}</h2>{chart_box(chart['id'], chart['title'], int(chart['layout']['height']))}"
        f'{chart.get("legend", "")}<p class="caption">{chart["caption"]}</p></section>'
    )
