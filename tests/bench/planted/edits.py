"""Edits to program text, as somebody at an editor makes them: lines are found by how they begin."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

__all__ = [
    "Edit",
    "Files",
    "Planted",
    "after",
    "before",
    "drop",
    "file",
    "move",
    "repeat",
    "replace",
    "sub",
    "text",
    "wrap",
]

Files = dict[str, str]
"""File name -> text, of one program."""

Edit = Callable[[Files], None]


@dataclass(frozen=True, slots=True)
class Planted:
    """An edit to a job's program. why: what it does to the machine (a fault), or why it changes nothing (a legal edit)."""

    job: str
    name: str
    why: str
    edits: tuple[Edit, ...]


def _find(lines: list[str], start: str, nth: int) -> int:
    hits = [i for i, line in enumerate(lines) if line.startswith(start)]
    if not hits or nth >= len(hits) or nth < -len(hits):
        raise LookupError(f"no line {nth} that begins with {start!r}")
    return hits[nth]


def _edit_lines(name: str, change: Callable[[list[str]], None]) -> Edit:
    def edit(files: Files) -> None:
        key = name or next(iter(files))
        lines = files[key].split("\n")
        change(lines)
        changed = "\n".join(lines)
        if changed == files[key]:
            raise LookupError(f"the edit changes nothing in {key}")
        files[key] = changed

    return edit


def before(start: str, new: str, nth: int = 0, name: str = "") -> Edit:
    """New lines before the nth line that begins with `start`."""

    def change(lines: list[str]) -> None:
        lines[(i := _find(lines, start, nth)) : i] = new.split("\n")

    return _edit_lines(name, change)


def after(start: str, new: str, nth: int = 0, name: str = "") -> Edit:
    """New lines behind the nth line that begins with `start`."""

    def change(lines: list[str]) -> None:
        i = _find(lines, start, nth) + 1
        lines[i:i] = new.split("\n")

    return _edit_lines(name, change)


def replace(start: str, new: str, nth: int = 0, name: str = "") -> Edit:
    """The nth line that begins with `start` by others."""

    def change(lines: list[str]) -> None:
        i = _find(lines, start, nth)
        lines[i : i + 1] = new.split("\n")

    return _edit_lines(name, change)


def sub(start: str, old: str, new: str, nth: int = 0, name: str = "") -> Edit:
    """`old` by `new` within the nth line that begins with `start`; `old` empty: `new` is put at the line's end."""

    def change(lines: list[str]) -> None:
        i = _find(lines, start, nth)
        if old not in lines[i]:
            raise LookupError(f"no {old!r} in {lines[i]!r}")
        lines[i] = lines[i].replace(old, new) if old else lines[i] + new

    return _edit_lines(name, change)


def drop(start: str, nth: int = 0, name: str = "") -> Edit:
    """Without the nth line that begins with `start`."""
    return _edit_lines(name, lambda lines: lines.__delitem__(_find(lines, start, nth)))


def move(
    start: str, to: str, nth: int = 0, to_nth: int = 0, name: str = "", *, count: int = 1, ahead: bool = False
) -> Edit:
    """`count` lines from the one that begins with `start`, behind the one that begins with `to` (or ahead of it)."""

    def change(lines: list[str]) -> None:
        i = _find(lines, start, nth)
        taken = lines[i : i + count]
        del lines[i : i + count]
        at = _find(lines, to, to_nth) + (0 if ahead else 1)
        lines[at:at] = taken

    return _edit_lines(name, change)


def wrap(first: str, last: str, head: str, tail: str, nth: int = 0, last_nth: int = 0, name: str = "") -> Edit:
    """`head` before the line that begins with `first`, `tail` behind the one that begins with `last`."""

    def change(lines: list[str]) -> None:
        i, j = _find(lines, first, nth), _find(lines, last, last_nth)
        lines[i : j + 1] = [*head.split("\n"), *lines[i : j + 1], *tail.split("\n")]

    return _edit_lines(name, change)


def repeat(first: str, last: str, nth: int = 0, last_nth: int = 0, name: str = "") -> Edit:
    """The lines from the one to the other once more."""

    def change(lines: list[str]) -> None:
        i, j = _find(lines, first, nth), _find(lines, last, last_nth)
        lines[j + 1 : j + 1] = lines[i : j + 1]

    return _edit_lines(name, change)


def text(change: Callable[[str], str], name: str = "") -> Edit:
    """A whole file's text through a function."""

    def edit(files: Files) -> None:
        key = name or next(iter(files))
        changed = change(files[key])
        if changed == files[key]:
            raise LookupError(f"the edit changes nothing in {key}")
        files[key] = changed

    return edit


def file(name: str, content: str | None) -> Edit:
    """A file added or overwritten; None: taken away."""

    def edit(files: Files) -> None:
        if content is None:
            del files[name]
        else:
            files[name] = content

    return edit
