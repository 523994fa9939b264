"""A part of a toolpath: from an operation on, of a program that is entered again there, or what one clamping of the part does."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

from camrob.errors import ToolpathError
from camrob.toolpath.region import Event, EventKind, Region
from camrob.toolpath.toolpath import Toolpath

__all__ = ["beginnings", "in_clamping", "rest_from"]

_SPINDLE = frozenset((EventKind.SPINDLE_ON, EventKind.SPINDLE_OFF))
_COOLANT = frozenset((EventKind.COOLANT_ON, EventKind.COOLANT_OFF))
_TOOL = frozenset((EventKind.TOOL_CHANGE,))
_PASSING = frozenset((EventKind.DWELL, EventKind.STOP))  # what is over when the program is entered again


def beginnings(toolpath: Toolpath) -> list[tuple[int, str]]:
    """CL line and name of each operation behind the first: another operation's name, or another tool.

    Only what begins in rapid, where the file's lines don't come back (a subprogram called again has the lines of its first call).
    """
    worked = [r for r in toolpath.regions if len(r)]
    out: list[tuple[int, str]] = []
    for before, region in pairwise(worked):
        other = (region.operation, region.tool) != (before.operation, before.tool)
        if other and _splits(worked, region.first_line):
            out.append((region.first_line, region.operation or region.name))
    return out


def rest_from(toolpath: Toolpath, line: int) -> Toolpath:
    """The toolpath from the region on that begins in a CL line, with tool, spindle and coolant as they are there.

    Raises ToolpathError where none begins there, or lines behind it come before it.
    """
    worked = [r for r in toolpath.regions if len(r)]
    at = next((k for k, r in enumerate(worked) if k and r.first_line == line), 0)
    if not at or not _splits(worked, line):
        known = ", ".join(f"{number} ({name})" for number, name in beginnings(toolpath)) or "none"
        raise ToolpathError(f"no operation that can be entered begins in line {line}", hint=f"those that do: {known}")
    first = worked[at]
    own = [e for e in first.events if e.point == 0 and e.kind not in _PASSING]
    said = [e for region in worked[:at] for e in region.events]
    carried, over = [], []
    for kinds in (_TOOL, _SPINDLE, _COOLANT):
        mine = [e for e in own if e.kind in kinds]
        last = next((e for e in reversed([*said, *mine]) if e.kind in kinds), None)
        off = last is None or last.kind in (EventKind.SPINDLE_OFF, EventKind.COOLANT_OFF)
        if last is not None and not off and not mine:
            carried.append(replace(last, point=0, retracted=False))
        over += mine if off else mine[:-1]  # nothing is on, yet
    own = [e for e in own if e not in over]
    later = [e for e in first.events if e.point > 0]
    begun = replace(first, events=tuple([*_in_order(carried, own), *later]), detached=False)
    return replace(toolpath, regions=(begun, *worked[at + 1 :]))


def in_clamping(toolpath: Toolpath, spans: Mapping[str, tuple[int, int]], name: str) -> Toolpath:
    """What one clamping does: the regions in its lines, with tool, spindle and coolant as the file has left them before.

    spans: first and last line of each clamping, which don't meet. Raises ToolpathError where a line that moves the tool lies in
    none, a region in two, or the clamping has no motion, or a line comes back in another one.
    """
    worked = [r for r in toolpath.regions if len(r)]
    owners = [_owner(region, spans) for region in worked]
    mine = [k for k, owner in enumerate(owners) if owner == name]
    first, last = spans[name]
    if not mine:
        raise ToolpathError(
            f"nothing moves the tool in lines {first}-{last} of clamping {name}", hint="correct `lines`"
        )
    at, stop = mine[0], mine[-1] + 1
    if len(mine) < stop - at or (stop < len(worked) and not _splits(worked, worked[stop].first_line)):
        raise ToolpathError(
            f"clamping {name} is left and come back to",
            line=worked[at].first_line,
            hint="give it lines that are run in a row",
        )
    cut = rest_from(toolpath, worked[at].first_line) if at else toolpath
    if stop == len(worked):
        return cut
    border = worked[stop]
    regions = list(cut.regions[: next(k for k, region in enumerate(cut.regions) if region is border)])
    ended = regions[-1]
    said = [
        replace(e, point=len(ended), retracted=border.detached)
        for e in border.events
        if e.point == 0 and e.line <= last
    ]
    regions[-1] = replace(ended, events=(*ended.events, *said))
    return replace(cut, regions=tuple(regions))


def _owner(region: Region, spans: Mapping[str, tuple[int, int]]) -> str:
    """The clamping of a region. Raises ToolpathError where one of its lines is in none, or they are in several."""
    known = ", ".join(f"{name} {first}-{last}" for name, (first, last) in spans.items())
    owner, what = "", region.operation or region.name
    for line in sorted({int(number) for number in region.line}):
        own = next((name for name, (first, last) in spans.items() if first <= line <= last), "")
        if not own:
            raise ToolpathError(f"{what} moves the tool and lies in no clamping", line=line, hint=f"there are: {known}")
        if owner and own != owner:
            text = f"{what}, from line {region.first_line} on, lies in clampings {owner} and {own}"
            raise ToolpathError(text, line=line, hint=f"end one where an operation ends; there are: {known}")
        owner = own
    return owner


def _in_order(carried: Sequence[Event], own: Sequence[Event]) -> list[Event]:
    """The tool first: its change stops the spindle, which the file starts again, and coolant for as long as it takes."""
    tools = [e for e in carried if e.kind in _TOOL]
    behind = max((k + 1 for k, e in enumerate(own) if e.kind in _TOOL), default=0)
    kept = [e for e in carried if e.kind in _COOLANT or (e.kind in _SPINDLE and not behind)]
    return [*tools, *own[:behind], *kept, *own[behind:]]


def _splits(worked: Sequence[Region], line: int) -> bool:
    """Whether all that is done before a line's region stands before that line, and all behind it behind."""
    at = next((k for k, r in enumerate(worked) if r.first_line == line), 0)
    before = max((int(r.line.max()) for r in worked[:at]), default=0)
    return bool(at and before < line <= min(int(r.line.min()) for r in worked[at:]))
