"""Numbers, times and text from files in words, for the terminal."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from pathlib import Path

from rich.text import Text

from camrob.summaries.feed_figures import BlockTime
from camrob.text import printable, short

__all__ = ["JOB_STATUS", "many", "shown_blocks", "shown_duration", "shown_number", "shown_paths", "shown_text"]


JOB_STATUS = {0: "done", 1: "check failed", 2: "input wrong", 3: "not done"}
"""What became of a batch's job, by its exit status."""


def shown_number(value: object, decimals: int = 1) -> str:
    """A number as it is read aloud; '-' where there is none."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return "-"
    if value != 0.0 and abs(value) < 0.5 * 10.0**-decimals:
        return short(value)
    return f"{value:,.{decimals}f}"


def shown_blocks(blocks: BlockTime, what: str = "motions") -> str:
    """How many motions are shorter than the controller takes for one."""
    return (
        f"{shown_number(blocks.short, 0)} of {shown_number(blocks.motions, 0)} {what} would take less than the "
        f"{blocks.block_ms:g} ms that the controller takes for one, the shortest {shown_number(blocks.shortest_ms, 2)} ms: they "
        "are run slower than programmed"
    )


def shown_duration(seconds: object) -> str:
    """A time as a machinist reads it: "4 min 12 s"; '-' where there is none."""
    if isinstance(seconds, bool) or not isinstance(seconds, int | float) or not math.isfinite(seconds):
        return "-"
    minutes, s = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes:02d} min"
    return f"{minutes} min {s:02d} s" if minutes else f"{shown_number(seconds)} s"


def many(count: int, one: str, several: str = "") -> str:
    """A count and what is counted: "1 worker", "2 workers". several: its plural, where that isn't `one` with an s."""
    return f"{count:,} {one if count == 1 else several or one + 's'}"


def shown_paths(paths: Sequence[str]) -> list[str]:
    """Paths without the folder that all of them lie in: long ones break a table's lines."""
    if len(paths) < 2 or not all(Path(path).is_absolute() for path in paths):
        return list(paths)
    folder = os.path.commonpath([str(Path(path).parent) for path in paths])
    return [Path(path).relative_to(folder).as_posix() for path in paths]


def shown_text(value: object, style: str = "") -> Text:
    """Text that is shown as it is, on one line: no markup, no control characters, whatever file it came from."""
    return Text(printable(value), style=style)
