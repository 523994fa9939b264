"""Writes a story down, motion by motion: knows where the tool stands, what turns it, and how fast it goes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from camrob.witness.cl.circles import Wanted, bend, bent
from camrob.witness.happenings import Event, Gap, Kind, Path, Pecks, Stand, Story, Way

__all__ = ["NO_CIRCLE", "UNREAD", "Teller", "unit"]

Array = NDArray[np.float64]

_SAME = 1e-9  # m, and of a unit vector: two places that are one
_CLOSED = 1e-7  # m: ends of an arc that are one (CL files print 0.1 um)
_ROUND = 2e-5  # m: by how much the radius at an arc's end may differ from that at its start
_NO_CIRCLE = 1e-3  # m: by as much it differs where no circle is meant, or another one
UNREAD = "not read by the second opinion: "
"""How the gap begins that reaches to the end of a file."""
NO_CIRCLE = "an arc whose ends lie on no circle about its centre"
_NOWHERE = (math.nan,) * 7  # centre, normal and angle of a straight motion
_NO_CORNER = "a rounded or chamfered corner that isn't between two straight cuts, or doesn't fit them"
_CURVED = (*_NOWHERE[1:], 0.0)  # of a piece of a curve
_COLUMNS = 18  # tip, axis, centre, normal, angle, line, way, feed, joined, operation


def unit(vector: Array) -> Array | None:
    """The direction of a vector that is given as a unit vector; None where it is none (1 % off)."""
    length = float(np.linalg.norm(vector))
    return vector / length if abs(length - 1.0) < 0.01 else None


class Teller:
    """Collects motions, events and gaps in order. Lengths in metres, feeds in m/s; `line` is always the text's.

    feed, rpm: what is used where the file is silent, or None. Public state: `n` motions so far; `here`, `axis`: where the tool
    stands and how, None where that is not known in the part's frame; `rpm`, `sense`, `turning`: the spindle;
    `hidden`: reasons why motions can't be read just now, each with its line.
    """

    def __init__(self, feed: float | None, rpm: float | None) -> None:
        self.n = 0
        self.here: Array | None = None
        self.axis: Array = np.array([0.0, 0.0, 1.0])
        self.rpm, self.sense, self.turning = rpm, "CLW", rpm is not None
        self.default_rpm = rpm
        self.hidden: dict[str, tuple[int, str]] = {}
        self.events: list[Event] = []
        self.gaps: list[Gap] = []
        self.notes: dict[str, None] = {}
        self.pecks: dict[int, Pecks] = {}  # of holes, by motion
        self._default_feed = feed
        self._feed: tuple[float, str] | None = None
        self._linked = False  # the last motion (or FROM, before any) ends where the tool stands
        self._from = 0  # the line of a FROM that alone says where the tool stands, else 0
        self._stands: list[Stand] = []
        self._rows: list[tuple[float, ...]] = []
        self._blocks: list[Array] = []
        self._operation, self._marked = 0, False
        self._tool: tuple[float, str] | None = None
        self._unloaded = 0  # the line in which the tool was put away, else 0
        self.cutting = False  # the last motion was a cut
        self._told_to_stand = False  # it was switched on at no speed: the set-up's is not what the file means
        self._speed_at_cut: float | None = None  # rev/min that the file has named before its first cut
        self._came: Array | None = None  # from where the last motion came
        # with its plane's normal, its line, and how many events there were
        self._corner: tuple[Wanted, Array, int, int] | None = None

    # -- what stands beside the motions

    def note(self, text: str) -> None:
        """A choice that the file left open, once."""
        self.notes.setdefault(text)

    def gap(self, line: int, text: str, *, last: int = 0, lost: bool = True) -> None:
        """Something that is not read; `lost`: where the tool stands behind it isn't known. One gap a stretch."""
        before, end = self.n, max(line, last)
        if self.gaps and self.gaps[-1].text == text and (self.gaps[-1].before == before or not lost):
            gap = self.gaps.pop()
            before, line, end = gap.before, min(line, gap.first_line), max(end, gap.last_line)
        self.gaps.append(Gap(before, line, end, text))
        if lost:
            self.lose()

    def lose(self) -> None:
        """From here on it is not known where the tool stands."""
        self.here, self._linked, self._from = None, False, 0

    def stand(self, tip: Array, axis: Array, line: int = 0) -> None:
        """The tool stands here, without a motion (FROM)."""
        if self.hidden:
            return self.lose()
        self._from = 0 if self.n and self._linked and self._at(tip, axis) else line
        self._linked = self.n == 0 or (self._linked and self._at(tip, axis))
        self.here, self.axis = tip, axis

    def mark(self) -> None:
        """Another operation begins with the next motion."""
        self._marked = self.n > 0

    def event(self, kind: Kind, line: int, value: float = 0.0, text: str = "") -> None:
        """Something happens behind the last motion."""
        self.events.append(Event(self.n, kind, value, text, line))

    def spindle(self, line: int, rpm: float | None = None, sense: str | None = None) -> None:
        """The spindle turns: what isn't given stays as it was."""
        self.rpm, self.sense, self.turning = self.rpm if rpm is None else rpm, sense or self.sense, True
        if self.rpm == 0.0:  # S0 M3: it stands
            self._told_to_stand = True
            return self.spindle_off(line)
        if self.rpm is None or not math.isfinite(self.rpm) or self.rpm < 0.0:
            self.gap(line, "the spindle's speed is not known", lost=False)
            self.rpm = None
        self.event(Kind.SPINDLE_ON, line, math.nan if self.rpm is None else self.rpm, self.sense)

    def spindle_off(self, line: int) -> None:
        """The spindle stops."""
        self.turning = False
        self.event(Kind.SPINDLE_OFF, line)

    def speed_alone(self, line: int, rpm: float) -> None:
        """A speed, and no word that starts the spindle: where the file never does, the set-up's start takes it over."""
        self.rpm = rpm
        started = any(e.kind is Kind.SPINDLE_ON for e in self.events)
        if self.default_rpm is not None and self._speed_at_cut is not None and not started:
            self.spindle(line, rpm, "CLW")

    def coolant(self, line: int, text: str | None) -> None:
        """Coolant on (with its kind, "" where the file doesn't say) or off (None)."""
        self.event(Kind.COOLANT_OFF if text is None else Kind.COOLANT_ON, line, 0.0, text or "")

    def tool(self, line: int, number: float, name: str = "") -> None:
        """A tool is mounted: an event where it is another than before. number 0: it has none; name "": it has none."""
        self._unloaded = 0
        if self._mounted(number, name):
            return
        self._tool = (number, name)
        self.event(Kind.TOOL, line, number, name)
        self.mark()

    def unload(self, line: int) -> None:
        """The tool is put away: nothing that a program has to say, but nothing is cut till the next one."""
        self._tool, self._unloaded = None, line

    def mounted(self, number: float) -> bool:
        """Whether this is the number of the tool that is mounted."""
        return self._tool is not None and self._tool[0] == number and not self._unloaded

    def _mounted(self, number: float, name: str) -> bool:
        """True where this is the tool that is mounted already; what the file adds to its number or name is kept."""
        before = next((e for e in reversed(self.events) if e.kind is Kind.TOOL), None)
        if before is None or self._tool is None:
            return False
        said = [a == b for a, b in zip(self._tool, (number, name), strict=True) if a and b]
        fresh = before.before == self.n  # the same change, said twice
        if not all(said) or not (said or fresh):
            return False
        self._tool = (self._tool[0] or number, self._tool[1] or name)
        if fresh:
            self.events[self.events.index(before)] = Event(self.n, Kind.TOOL, *self._tool, before.line)
        return True

    # -- feed

    def set_feed(self, value: float, per: str) -> None:
        """per: "min" (value in m/s), "rev" (m a revolution). Zero and less is no feed."""
        self._feed = (value, per) if math.isfinite(value) and value > 0.0 else None

    def speed(self, line: int, feed: tuple[float, str] | None = None) -> float:
        """The feed in m/s, `feed` or the modal one; NaN, with a gap, where the file states none."""
        value, per = feed or self._feed or (self._default_feed, "min")
        if value is None or not value > 0.0:
            self.gap(line, "a cut without a feed", lost=False)
            return math.nan
        if per == "min":
            return value
        if self.rpm is None or not self.turning:
            self.gap(line, "a feed per revolution without a spindle speed", lost=False)
            return math.nan
        return value * self.rpm / 60.0

    # -- motions

    def _at(self, tip: Array, axis: Array) -> bool:
        return (
            self.here is not None
            and float(np.abs(tip - self.here).max()) <= _SAME
            and float(np.abs(axis - self.axis).max()) <= _SAME
        )

    def _covered(self, line: int) -> bool:
        """True, and in the list of gaps, where motions can't be read just now."""
        if self.hidden:
            first, text = next(iter(self.hidden.values()))
            self.gap(first, text, last=line)
        return bool(self.hidden)

    def _count(self) -> None:
        self._operation += self._marked
        self._marked = False

    def _begin_where_it_stands(self) -> None:
        """Before a cut: it begins where FROM says that the tool stands, if nothing else does."""
        if self._unloaded:
            self.gap(self._unloaded, "a cut without a tool, which was put away", lost=False)
        self._speed_at_cut = self.rpm if self._speed_at_cut is None else self._speed_at_cut
        if self._from and self.here is not None:
            self._stands.append(Stand(self.n, self.here, self.axis, self._from))

    def _row(self, tip: Array, axis: Array, way: Way, line: int, feed: float, round_: tuple[float, ...]) -> None:
        self._count()
        self._rows.append((*tip, *axis, *round_, line, way, feed, self._linked, self._operation))
        self.n += 1
        self._came = self.here if self._linked else None
        self.here, self.axis, self._linked, self._from = tip, axis, True, 0
        self.cutting = way != Way.RAPID

    def move(self, tip: Array, axis: Array, way: Way, line: int, feed: float | None = None) -> None:
        """Straight to `tip` with the tool along `axis`; a point where the tool stands already is no motion."""
        if self._covered(line) or (self.n and self._linked and self._at(tip, axis)):
            return
        if self._corner is not None:
            self._bend(tip, axis, way)
        if way != Way.RAPID:
            self._begin_where_it_stands()
        if feed is None:
            feed = math.nan if way == Way.RAPID else self.speed(line)
        self._row(tip, axis, way, line, feed, _NOWHERE)

    def corner(self, want: Wanted, normal: Array, line: int) -> None:
        """The last cut and the next one, both straight, meet in this corner; normal: of the plane in the part."""
        self._corner = (want, normal, line, self.n + len(self.events))

    def _unbent(self) -> None:
        """No straight cut follows a corner that waits for one."""
        if self._corner is not None:
            self.gap(self._corner[2], _NO_CORNER)
            self._corner = None

    def _bend(self, tip: Array, axis: Array, way: Way) -> None:
        """The corner that waits, now that the cut behind it goes to `tip`: the cut before it ends earlier."""
        if self._corner is None:
            return
        (want, normal, line, count), self._corner = self._corner, None
        row = self._rows[-1] if self._rows else None
        straight = (
            row is not None and row[14] == Way.FEED and math.isnan(row[12]) and count == self.n + len(self.events)
        )
        if row is None or not straight or way != Way.FEED or self.here is None or self._came is None:
            self.gap(line, _NO_CORNER)
            return
        if float(np.abs(axis - self.axis).max()) > _SAME:
            self.gap(line, _NO_CORNER)
            return
        found = bend(self._came, self.here, tip, normal, want)
        if found is None:
            if not bent(self._came, self.here, tip):
                return
            self.gap(line, _NO_CORNER)
            return
        self._rows[-1] = (*found.first, *row[3:])
        self.here = found.first
        feed = row[15] if want.feed is None else want.feed
        if found.center is None:
            self._row(found.last, axis, Way.FEED, line, feed, _NOWHERE)
        else:
            turn = 2.0 * math.asin(min(1.0, float(np.linalg.norm(found.last - found.first)) / (2.0 * want.radius)))
            self._row(found.last, axis, Way.FEED, line, feed, (*found.center, *found.normal, turn))

    def arc(
        self,
        tip: Array,
        axis: Array,
        center: Array,
        normal: Array,
        way: Way,
        line: int,
        turns: int = 0,
        time: float = 0.0,
    ) -> None:
        """On a circle, right-handed about `normal`, to `tip`; `turns` full ones more. time: s that it takes, 0: by the feed."""
        self._unbent()
        if self._covered(line):
            return
        if self.here is None or not (self._linked or self._from):
            self.gap(line, "an arc whose start is not known")
            self.here, self.axis = tip, axis
            return
        start, end = self.here - center, tip - center
        rise = float((end - start) @ normal)
        start, end = start - (start @ normal) * normal, end - (end @ normal) * normal
        radius = float(np.linalg.norm(start))
        if radius < _CLOSED or abs(radius - float(np.linalg.norm(end))) > _ROUND:
            odd = abs(radius - float(np.linalg.norm(end))) > max(_NO_CIRCLE, 0.01 * radius)
            self.gap(line, NO_CIRCLE if odd else "an arc whose centre doesn't fit its ends")
            self.here, self.axis = tip, axis
            return
        closed = float(np.linalg.norm(end - start)) <= _CLOSED
        angle = 0.0 if closed else math.atan2(float(normal @ np.cross(start, end)), float(start @ end)) % math.tau
        angle = (angle or math.tau) + turns * math.tau
        feed = math.nan if way == Way.RAPID else math.hypot(angle * radius, rise) / time if time else self.speed(line)
        self._begin_where_it_stands()
        self._row(tip, axis, way, line, feed, (*center, *normal, angle))

    def curve(self, tips: Array, axis: Array, line: int) -> None:
        """Cuts on a curve, from where the tool stands through tips (N, 3) so near together that the way between is straight."""
        self._unbent()
        if self._covered(line):
            return
        if not (self._linked or self._from):
            self.gap(line, "a curve whose start is not known")
            return
        self._begin_where_it_stands()
        feed = self.speed(line)
        for tip in tips:
            if not self._at(tip, axis):
                self._row(tip, axis, Way.FEED, line, feed, _CURVED)

    def run(self, tips: Array, axes: Array, first_line: int) -> None:
        """Cuts straight from tip to tip, (N, 3) each, one a line."""
        last = first_line + len(tips) - 1
        if self._covered(first_line):
            self._covered(last)
            return
        self._begin_where_it_stands()
        tip, axis = tips[0] + 1.0, axes[0]  # any other place
        if self.n and self._linked and self.here is not None:
            tip, axis = self.here, self.axis
        moved = np.abs(np.diff(tips, axis=0, prepend=tip[None])).max(axis=1) > _SAME
        moved |= np.abs(np.diff(axes, axis=0, prepend=axis[None])).max(axis=1) > _SAME
        if moved.any():
            block = np.full((int(moved.sum()), _COLUMNS), math.nan)
            self._count()
            block[:, 0:3], block[:, 3:6] = tips[moved], axes[moved]
            block[:, 13], block[:, 14] = np.flatnonzero(moved) + first_line, Way.FEED
            block[:, 15], block[:, 17] = self.speed(first_line), self._operation
            block[:, 16] = True
            block[0, 16] = self._linked
            self._flush()
            self._blocks.append(block)
            self.n += len(block)
        self.here, self.axis, self._linked, self._from = tips[-1], axes[-1], True, 0
        self.cutting = True

    def _flush(self) -> None:
        if self._rows:
            self._blocks.append(np.array(self._rows, float))
            self._rows = []

    # -- the end

    def _start_spindle(self, way: NDArray[np.int8]) -> None:
        """The file's speed, else the set-up's, from the first motion on, where the file cuts before it starts a spindle.

        Where no cut could be read, what wasn't read holds them.
        """
        cuts = np.flatnonzero(way != Way.RAPID)
        first = cuts[0] if len(cuts) else len(way)
        if not (len(cuts) or self.gaps) or any(e.kind is Kind.SPINDLE_ON and e.before <= first for e in self.events):
            return
        if self.default_rpm is None or self._told_to_stand:
            self.note("the file starts no spindle before its first cut")
            return
        place = next((i for i, e in enumerate(self.events) if e.before > 0), len(self.events))
        self.events.insert(place, Event(0, Kind.SPINDLE_ON, self._speed_at_cut or self.default_rpm, "CLW"))

    def story(self, dialect: str, units: str) -> Story | None:
        """Everything that was collected; None where there is no motion, and no gap that says why."""
        self._unbent()
        self._flush()
        if not self._blocks and not any(gap.text.startswith(UNREAD) for gap in self.gaps):
            return None
        table = np.concatenate(self._blocks) if self._blocks else np.zeros((0, _COLUMNS))
        self._blocks = []  # nothing is told behind the end
        way = table[:, 14].astype(np.int8)
        self._start_spindle(way)
        return Story(
            path=Path(
                tip=table[:, 0:3].copy(),
                axis=table[:, 3:6].copy(),
                center=table[:, 6:9].copy(),
                normal=table[:, 9:12].copy(),
                angle=table[:, 12].copy(),
                line=table[:, 13].astype(np.int64),
            ),
            way=way,
            feed=table[:, 15].copy(),
            joined=table[:, 16].astype(np.bool_),
            operation=table[:, 17].astype(np.int32),
            events=tuple(self.events),
            gaps=tuple(self.gaps),
            dialect=dialect,
            units=units,
            notes=tuple(self.notes),
            stands=tuple(self._stands),
            pecks=self.pecks,
        )
