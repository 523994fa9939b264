"""Heidenhain's feeds: F, FU, F AUTO and FMAX of motions, that of TOOL CALL, and those of cycles."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.controls.heidenhain_cycles import RAPID
from camrob.toolpath.gcode.controls.heidenhain_words import ToolCall
from camrob.toolpath.gcode.lexer import Block

__all__ = ["Feeds"]


class Feeds:
    """The feed in force, in the program's unit a minute; `value` gives what a number or Q parameter is worth.

    rapid: FMAX of the last motion. speed: rev/min of the last TOOL CALL that named one.
    """

    def __init__(self, value: Callable[[str], float]) -> None:
        self._value = value
        self.rapid = False
        self.speed: float | None = None
        self._feed: float | None = None
        self._tool_feed: float | None = None  # of TOOL CALL
        self._per_turn = False  # the one in force comes of FU, and so changes with the speed
        self._unnamed = False  # a cycle, or another speed, has left none behind that is certain

    def of_motion(self, words: dict[str, str], moves: bool = True) -> dict[str, float]:
        """F of a motion, if it names one; takes note of whether it is a rapid. Raises ToolpathError for one that isn't known,
        where the block moves.
        """
        self.rapid = "FMAX" in words
        if "FZ" in words:
            raise ToolpathError(
                "FZ, a feed per tooth: how many teeth the tool has stands in the machine's table",
                hint="post the feed in mm/min",
            )
        if words.get("FU"):
            return self._set(self._turning() * self._value(words["FU"]), per_turn=True)
        if "F AUTO" in words:
            return self._set(self._automatic())
        if words.get("F"):
            return self._set(self._value(words["F"]))
        if self._unnamed and moves and not self.rapid:
            raise ToolpathError(
                "a cut without a feed behind a cycle, or behind another speed", hint="name F in the block"
            )
        return {}

    def _set(self, feed: float, *, per_turn: bool = False) -> dict[str, float]:
        self._feed, self._unnamed, self._per_turn = feed, False, per_turn
        return {"F": feed}

    def _automatic(self) -> float:
        if self._tool_feed is None:
            raise ToolpathError("F AUTO: TOOL CALL has named no feed", hint="name the feed in the block")
        return self._tool_feed

    def _turning(self) -> float:
        if not self.speed:
            raise ToolpathError("FU, a feed per turn: TOOL CALL has named no speed", hint="name S in TOOL CALL")
        return self.speed

    def of_call(self, call: ToolCall) -> dict[str, float]:
        """F and S of a TOOL CALL, those that it names."""
        if call.speed is not None and call.speed != self.speed and self._per_turn:
            self._unnamed, self._feed = True, None
        if call.feed is not None or call.changes:
            self._tool_feed = call.feed
        if call.feed is not None:  # the modal one, too, till a block names another
            self._feed, self._unnamed, self._per_turn = call.feed, False, False
        self.speed = call.speed or self.speed
        return {letter: value for letter, value in (("F", call.feed), ("S", call.speed)) if value is not None}

    def of_cycle(self, text: str) -> float:
        """What a parameter of a cycle is worth: a number, a Q parameter, FAUTO or FMAX."""
        word = text.replace(" ", "")
        return self._automatic() if word == "FAUTO" else RAPID if word == "FMAX" else self._value(text)

    def behind_cycle(self, line: int) -> Iterator[Block]:
        """The feed from before a cycle, whose own ends with it."""
        self._unnamed = self._feed is None
        if self._feed is not None:
            yield Block(line, {"F": self._feed})
