"""What moved between two texts of one program, and by how much."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

__all__ = ["ProgramDifference", "compare_program"]

_NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?(?![\w.])")
_NAMED = re.compile(r"(?<![\w$])([XYZABC]|[AE]\d|\$[\w.]+(?:\[\d+\])?)\s*=?\s*$")
_TURNING = ("A", "B", "C")  # -180 and 180 degrees are one
_SHOWN = 3


@dataclass(slots=True)
class ProgramDifference:
    """How a program's text differs: `text` in words, empty where nothing does; `rounded` numbers differ in the last decimal only.

    `moved`: name of a coordinate or variable to (largest change, line of the new text).
    """

    text: list[str] = field(default_factory=list)
    rounded: int = 0
    moved: dict[str, tuple[float, int]] = field(default_factory=dict)


def compare_program(name: str, before: str, after: str) -> ProgramDifference:
    """Compare two texts: words exactly, numbers to one unit in their last decimal; angles A, B, C whatever their turn."""
    found = ProgramDifference()
    if before == after:
        return found
    old, new = before.split("\r\n"), after.split("\r\n")
    if "\n" in before.replace("\r\n", "") or "\n" in after.replace("\r\n", ""):
        found.text.append(f"{name}: its lines don't all end with CR LF")
        old, new = before.splitlines(), after.splitlines()
    changed: list[tuple[int, str, str]] = []
    added: list[tuple[int, str]] = []
    removed: list[tuple[int, str]] = []
    for i, j, was, now in _aligned(old, new):
        if was is None:
            added.append((j + 1, now or ""))
        elif now is None:
            removed.append((i + 1, was))
        elif not _alike(was, now, j + 1, found):
            changed.append((j + 1, was, now))
    if changed or added or removed:
        _tell(name, changed, added, removed, len(new), found)
    return found


def _aligned(old: Sequence[str], new: Sequence[str]) -> Iterator[tuple[int, int, str | None, str | None]]:
    """(index before, index after, line before, line after) of the lines that differ; None where a line has no counterpart."""
    if len(old) == len(new):
        yield from ((k, k, a, b) for k, (a, b) in enumerate(zip(old, new, strict=True)) if a != b)
        return
    for tag, i0, i1, j0, j1 in difflib.SequenceMatcher(None, old, new).get_opcodes():
        if tag == "equal":
            continue
        pairs = min(i1 - i0, j1 - j0)
        yield from ((i0 + k, j0 + k, old[i0 + k], new[j0 + k]) for k in range(pairs))
        yield from ((k, j0 + pairs, old[k], None) for k in range(i0 + pairs, i1))
        yield from ((i0 + pairs, k, None, new[k]) for k in range(j0 + pairs, j1))


def _words(line: str) -> str:
    return _NUMBER.sub("#", line)


def _alike(was: str, now: str, line: int, found: ProgramDifference) -> bool:
    """Whether two lines differ by no more than rounding; `found` takes down what moved."""
    if _words(was) != _words(now):
        return False
    alike = True
    for a, b in zip(_NUMBER.finditer(was), _NUMBER.finditer(now), strict=True):
        if a[0] == b[0]:
            continue
        named = _NAMED.search(was[: a.start()])
        name = named[1] if named else "number"
        apart = abs(float(b[0]) - float(a[0]))
        if name in _TURNING:
            apart = min(apart % 360.0, -apart % 360.0)
        decimals = len(a[0].partition(".")[2])
        if len(b[0].partition(".")[2]) == decimals and apart <= 1.001 * 10.0**-decimals and decimals > 0:
            found.rounded += 1
            continue
        alike = False
        if apart > found.moved.get(name, (0.0, 0))[0]:
            found.moved[name] = (apart, line)
    return alike


def _tell(
    name: str,
    changed: list[tuple[int, str, str]],
    added: list[tuple[int, str]],
    removed: list[tuple[int, str]],
    lines: int,
    found: ProgramDifference,
) -> None:
    """Put the difference into words."""
    counts = [
        f"{n} {what}" for n, what in ((len(changed), "changed"), (len(added), "added"), (len(removed), "removed")) if n
    ]
    found.text.append(f"{name}: of {lines} lines {', '.join(counts)}")
    if found.moved:
        order = sorted(found.moved.items(), key=lambda item: -item[1][0])
        largest = ", ".join(f"{what} by {_amount(what, far)} (line {line})" for what, (far, line) in order)
        found.text.append(f"{name}: moved most: {largest}")
    for line, was, now in changed[:_SHOWN]:
        found.text += [f"{name}:{line} was {was.strip()}", f"{name}:{line}  is {now.strip()}"]
    found.text += [f"{name}:{line} is new: {now.strip()}" for line, now in added[:_SHOWN]]
    found.text += [f"{name}:{line} is gone (its line before): {was.strip()}" for line, was in removed[:_SHOWN]]


def _amount(name: str, far: float) -> str:
    """A change with its unit, where the name tells it."""
    unit = " mm" if name in ("X", "Y", "Z") else " degrees" if re.fullmatch(r"[ABC]|A\d", name) else ""
    return f"{far:.4f}".rstrip("0").rstrip(".") + unit
