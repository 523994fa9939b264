"""What is used where a file is silent: the set-up's feed and spindle speed, a unit of length that nobody has named."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from camrob.errors import ToolpathError
from camrob.findings import Finding, Severity
from camrob.toolpath.region import Event, EventKind, Move, Region
from camrob.units import INCH_MM, m_s_to_mm_min, m_to_mm, mm_min_to_m_s

__all__ = ["FASTEST", "SLOWEST", "Defaults", "check_feed", "check_unit", "feed_finding", "unit_finding", "with_spindle"]

FASTEST = mm_min_to_m_s(180_000.0)
"""m/s: no controller's `$VEL.CP` goes beyond 3 m/s; a feed above it is a slip."""
SLOWEST = mm_min_to_m_s(0.06)
"""m/s: the least that six decimals of a metre a second can print."""
_TINY = 5.0  # mm: a robot mills no part as small, and in inches it is one of 127 mm or less
_OPEN = 40.0  # mm: such a part may as well be one of a metre, which a robot reaches


@dataclass(frozen=True, slots=True)
class Defaults:
    """The set-up's `feed` (m/s) and `spindle_rpm` (rev/min), None where it states none; `diameters` (m) of its tools by number.

    The number 0 stands for any tool. `wear`: it says that compensated paths are the tool centre's. `numbers`: of its tools by
    their names, in lower case.
    """

    feed: float | None = None
    spindle_rpm: float | None = None
    diameters: Mapping[int, float] = field(default_factory=dict)
    wear: bool = False
    numbers: Mapping[str, int] = field(default_factory=dict)

    def number(self, name: str) -> int | None:
        """The number of the set-up's tool of that name, None where it has none."""
        return self.numbers.get(name.strip().casefold())

    def diameter(self, number: int) -> float:
        """The diameter (m) of the tool of that number, 0.0 where the set-up doesn't say."""
        return self.diameters.get(number) or self.diameters.get(0, 0.0)


def check_feed(speed: float, line: int, stated: int) -> float:
    """The feed `speed` (m/s) of a cut at `line`, stated in line `stated`. Raises ToolpathError where nothing moves so."""
    if SLOWEST <= speed <= FASTEST:
        return speed
    what = f"the feed is {m_s_to_mm_min(speed):g} mm/min" + (f" (line {stated})" if stated != line and stated else "")
    if speed < SLOWEST:
        raise ToolpathError(f"{what}, too slow to be written", hint="give 0.06 mm/min or more", line=line)
    raise ToolpathError(f"{what}, faster than any controller takes", hint="give 180000 mm/min at most", line=line)


def feed_finding(feed: float, line: int) -> Finding:
    """The warning that the set-up's feed (m/s) is used, from the cut at `line` on."""
    text = f"the file states no feed before its first cut: feed_mm_min of the set-up is used, {m_s_to_mm_min(feed):g} mm/min"
    return Finding("feed-from-setup", text, Severity.WARNING, line)


def _width(regions: Sequence[Region]) -> float:
    """How wide, deep or high the path is, the most of the three, m."""
    low = np.min([r.position.min(axis=0) for r in regions], axis=0)
    high = np.max([r.position.max(axis=0) for r in regions], axis=0)
    return float(np.max(high - low))


def check_unit(reason: str, regions: Sequence[Region], line: int, *, metric: bool) -> None:
    """Raises ToolpathError where millimetres are assumed for `reason`, and inches make a part that is as likely, or likelier.

    metric: the control itself begins with millimetres as it is shipped.
    """
    wide = m_to_mm(_width(regions))
    if wide < (_TINY if metric else _OPEN):
        raise ToolpathError(
            f"{reason}, and the path would be {wide:.1f} mm wide in millimetres, {wide * INCH_MM:.1f} mm in inches",
            hint="say which by --units, or by units in setup.toml",
            line=line,
        )


def unit_finding(code: str, reason: str, unit: str, regions: Sequence[Region], line: int) -> Finding:
    """The warning that a unit of length is assumed: why, and how wide the path is with it and with the other one."""
    wide = m_to_mm(_width(regions))
    other, then = ("millimetres", wide / INCH_MM) if unit == "inch" else ("inches", wide * INCH_MM)
    name = "inches" if unit == "inch" else "millimetres"
    text = (
        f"{reason}: {name} are assumed, and the path is {wide:.1f} mm wide; read in {other} it would be {then:.1f} mm"
    )
    return Finding(code, text, Severity.WARNING, line)


def with_spindle(
    regions: Sequence[Region], rpm: float, *, of_file: bool = False
) -> tuple[tuple[Region, ...], tuple[Finding, ...]]:
    """The regions with the spindle on before the first motion, clockwise at `rpm`, where the file starts none for its first cut.

    `of_file`: the speed is the file's own. After a tool change before that cut the spindle is on behind the change.
    Regions of a file that starts its spindle come back as they are.
    """
    start = _start(regions)
    if start is None:
        return tuple(regions), ()
    k, index, point, line = start
    events = list(regions[k].events)
    events.insert(index, Event(point, EventKind.SPINDLE_ON, rpm, "CLW"))
    out = tuple(dataclasses.replace(r, events=tuple(events)) if n == k else r for n, r in enumerate(regions))
    speed = (
        f"its own speed, {rpm:g} rev/min, is used" if of_file else f"spindle_rpm of the set-up is used, {rpm:g} rev/min"
    )
    text = f"the file starts no spindle before its first cut: {speed}, clockwise"
    return out, (Finding("spindle-from-setup", text, Severity.WARNING, line),)


def _start(regions: Sequence[Region]) -> tuple[int, int, int, int] | None:
    """Where the spindle has to be started: region, index among its events, point; and the line of the cut that needs it.

    That is before the first motion, or after the last stop or tool change before the first cut. None where the file
    has started it by then, or cuts nothing.
    """
    place = (0, 0, 0)
    for k, region in enumerate(regions):
        cuts = np.flatnonzero(region.move == Move.CUT)
        first = int(cuts[0]) if len(cuts) else len(region)
        for i, event in enumerate(region.events):
            if event.point > first:
                break
            if event.kind is EventKind.SPINDLE_ON:
                return None
            if event.kind in (EventKind.SPINDLE_OFF, EventKind.TOOL_CHANGE):
                place = (k, i + 1, event.point)
        if len(cuts):
            return *place, int(region.line[first])
    return None
