"""Tables in the terminal: plain ones of columns, and labels with what belongs to them."""

from __future__ import annotations

from collections.abc import Collection

from rich.table import Table

__all__ = ["columns", "labelled"]


def columns(*headings: str, left: Collection[str], fold: bool = False) -> Table:
    """A table without lines whose columns stand to the right, those of words to the left. fold: long ones run on in lines."""
    table = Table(box=None, padding=(0, 2, 0, 0), header_style="bold")
    for heading in headings:
        side = "left" if heading in left else "right"
        table.add_column(heading, justify=side, overflow="fold" if fold else "ellipsis")  # type: ignore[arg-type]
    return table


def labelled() -> Table:
    """Rows of a label and a text."""
    grid = Table.grid(padding=(0, 2))
    grid.add_column(style="bold", no_wrap=True)
    grid.add_column()
    return grid
