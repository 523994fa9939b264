"""Length units and feeds of CL text: six spellings of FEDRAT, per minute and per revolution, down to m/s."""

from __future__ import annotations

from dataclasses import dataclass, field

from camrob.errors import ToolpathError
from camrob.toolpath.apt.lexer import Statement
from camrob.toolpath.defaults import Defaults, check_feed
from camrob.units import INCH_MM, mm_min_to_m_s, mm_to_m

__all__ = ["Feed", "FeedReader", "unit_name"]

_UNIT_NAMES = {
    "MM": "mm",
    "MILLIMETER": "mm",
    "MILLIMETERS": "mm",
    "MILLIMETRES": "mm",
    "METRIC": "mm",
    "CM": "",
    "M": "",
    "IN": "inch",
    "INCH": "inch",
    "INCHES": "inch",
    "FEET": "",
    "FT": "",
}
_PER_MINUTE = {"MMPM": "mm", "IPM": "inch", "PERMIN": "", "UPM": "", "": ""}
_PER_TURN = {"MMPR": "mm", "IPR": "inch", "PERREV": "", "UPR": ""}


def unit_name(word: str, line: int = 0) -> str:
    """What a file or a user calls a unit, as "mm" or "inch". Raises ToolpathError for anything else."""
    name = _UNIT_NAMES.get(word.strip().upper(), "")
    if not name:
        raise ToolpathError(f"unit {word.strip()!r} is not known", hint="use mm or inch", line=line)
    return name


@dataclass(frozen=True, slots=True)
class Feed:
    """A programmed feed as it stands in the file: value, unit word, line."""

    value: float
    word: str
    line: int


@dataclass(slots=True)
class FeedReader:
    """Unit of length, modal feed and spindle speed; `forced` is the caller's unit, which overrides the file's.

    `defaults` are used while the file has stated no feed; `defaulted` is the line of the first cut that took them.
    """

    units: str = "mm"
    forced: str | None = None
    rpm: float = 0.0
    modal: Feed | None = None
    stated: bool = False  # the file names its unit
    defaults: Defaults = field(default_factory=Defaults)
    defaulted: int = 0
    disagreements: dict[str, int] = field(default_factory=dict)  # what was said, and its first line

    @property
    def scale(self) -> float:
        """Metres in the unit of length."""
        return mm_to_m(INCH_MM) if self.units == "inch" else mm_to_m(1.0)

    def set_units(self, word: str, line: int) -> None:
        """The file's own statement of its unit; without effect where the caller has forced one."""
        name = unit_name(word, line)
        self.stated = True
        if self.forced is None:
            self.units = name
        elif self.forced != name:
            self.disagreements.setdefault(
                f"the file says {name}, read as {self.forced} because that was asked for", line
            )

    def fedrat(self, statement: Statement) -> None:
        """Take in a FEDRAT: a number, and its unit or none.

        Raises ToolpathError for anything else: inverse time, other units, a scale, several feeds.
        """
        numbers, words = statement.numbers, statement.words
        known = [w for w in words if w in _PER_MINUTE or w in _PER_TURN]
        if len(numbers) != 1 or len(words) > 1 or known != words:
            raise ToolpathError(
                f"FEDRAT/{statement.text.strip()} is no feed in one of the units that are known",
                hint="output one number, in MMPM, IPM, MMPR or IPR",
                line=statement.line,
            )
        last = "" if self.modal is None else self.modal.word
        per_turn = last in _PER_TURN  # without a unit, a feed counts as the one before it
        if (
            not known
            and self.forced is None
            and ((_PER_TURN if per_turn else _PER_MINUTE).get(last) or self.units) != self.units
        ):
            raise ToolpathError(
                f"FEDRAT/{statement.text.strip()} names no unit: the last feed was in {last}, and lengths are in {self.units}",
                hint="output each feed with its unit",
                line=statement.line,
            )
        self.modal = Feed(numbers[0], known[0] if known else last if per_turn else "", statement.line)

    def speed(self, line: int, feed: Feed | None = None) -> float:
        """m/s of the given feed, or of the modal one, for a cut at `line`.

        Raises ToolpathError when there is none, when it is not positive or nothing moves so slowly or so fast, or per
        revolution without a spindle speed.
        """
        feed = feed or self.modal
        if feed is None:
            if self.defaults.feed is not None:
                self.defaulted = self.defaulted or line
                return self.defaults.feed
            raise ToolpathError(
                "the cut has no feed",
                hint="put a FEDRAT before the first cut, or feed_mm_min into setup.toml",
                line=line,
            )
        if not 0.0 < feed.value < 1e9:
            raise ToolpathError(
                f"the feed is {feed.value:g} (line {feed.line})",
                hint="give a feed above zero before the cut",
                line=line,
            )
        value, unit = feed.value, _PER_MINUTE.get(feed.word, "")
        if feed.word in _PER_TURN:
            if not self.rpm > 0.0:
                raise ToolpathError(
                    f"the feed is per revolution (line {feed.line}) but no spindle speed in rev/min stands before it",
                    hint="put SPINDL/RPM before the cut, or output the feed per minute",
                    line=line,
                )
            value, unit = value * self.rpm, _PER_TURN[feed.word]
        speed = mm_min_to_m_s(value * INCH_MM) if self._in_inches(unit, feed) else mm_min_to_m_s(value)
        return check_feed(speed, line, feed.line)

    def _in_inches(self, unit: str, feed: Feed) -> bool:
        """Whether a feed's length is the inch; a contradiction to the file's unit is noted."""
        if not unit or unit == self.units:
            return self.units == "inch"
        text = f"the feed {feed.word} does not fit lengths in {self.units}"
        if self.forced is not None:
            self.disagreements.setdefault(text + "; it is read as mm per minute, the slower of the two", feed.line)
            return False
        self.disagreements.setdefault(text + "; it is taken at its word", feed.line)
        return unit == "inch"
