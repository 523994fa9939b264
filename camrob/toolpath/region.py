"""A region: one operation, or a run of cutting between retracts, as frames with the source line of every point."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum, StrEnum

import numpy as np
from numpy.typing import NDArray

from camrob.frozen import locked

__all__ = ["Arc", "Event", "EventKind", "Move", "Region", "goes_on"]

_SAME_PLACE = 1e-9  # m, and of a unit axis


class Move(IntEnum):
    """How the tool comes to a point."""

    RAPID = 0  # air, as fast as the cell moves
    CUT = 1  # at the programmed feed
    LINK = 2  # air, put in by camrob between regions


class EventKind(StrEnum):
    """What happens before the tool leaves for a point."""

    SPINDLE_ON = "spindle_on"  # value: rev/min, text: "CLW" or "CCLW"
    SPINDLE_OFF = "spindle_off"
    COOLANT_ON = "coolant_on"  # text: "FLOOD", "MIST", ...
    COOLANT_OFF = "coolant_off"
    TOOL_CHANGE = "tool_change"  # value: tool number, text: tool name
    DWELL = "dwell"  # value: seconds
    STOP = "stop"  # the operator continues
    MESSAGE = "message"  # text for the operator (PPRINT): only ever printed as a comment


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happens just before the move to point `point` (index within the region; n = after the last).

    `retracted`, at a toolpath's last point only: the file has first sent the tool to a place that is not known in the part
    (G28, GOHOME), so it happens after the cell's own retract and not in the part.
    """

    point: int
    kind: EventKind
    value: float = 0.0
    text: str = ""
    line: int = 0
    retracted: bool = False


@dataclass(frozen=True, slots=True)
class Arc:
    """Points `first`..`last` (indices within the region, both on the arc; `first` is its start) lie on one circle.

    `center` (3,) and unit `axis` (3,) are in the part's frame, metres; the motion turns right-handedly about `axis` by
    `angle` > 0 rad (2 pi for a full circle). Only arcs without axial rise and with a constant tool axis are kept.
    """

    first: int
    last: int
    center: NDArray[np.float64]
    axis: NDArray[np.float64]
    radius: float
    angle: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", locked(self.center, shape=(3,), name="center"))
        object.__setattr__(self, "axis", locked(self.axis, shape=(3,), name="axis"))


@dataclass(frozen=True, slots=True)
class Region:
    """Points of one region in the part's frame.

    position: (N, 3) tool tip, metres. axis: (N, 3) unit tool axis, tip to holder. feed: (N,) m/s with which the tool
    comes to the point; for RAPID moves NaN. move: (N,) `Move`. line: (N,) 1-based source line.
    `tool` is the tool's number (0 where the file names none). `detached`: where the tool was before the first point is not
    known in the part (the file sent it to a machine position), so the cell's own retract has to be written before it.
    """

    name: str
    position: NDArray[np.float64]
    axis: NDArray[np.float64]
    feed: NDArray[np.float64]
    move: NDArray[np.int8]
    line: NDArray[np.int64]
    tool: int = 0
    operation: str = ""
    arcs: tuple[Arc, ...] = field(default=())
    events: tuple[Event, ...] = field(default=())
    detached: bool = False

    def __post_init__(self) -> None:
        position = locked(self.position, shape=(None, 3), name="position")
        n = len(position)
        object.__setattr__(self, "position", position)
        object.__setattr__(self, "axis", locked(self.axis, shape=(n, 3), name="axis"))
        object.__setattr__(self, "feed", locked(self.feed, shape=(n,), name="feed"))
        object.__setattr__(self, "move", locked(self.move, shape=(n,), dtype=np.int8, name="move"))
        object.__setattr__(self, "line", locked(self.line, shape=(n,), dtype=np.int64, name="line"))

    def __len__(self) -> int:
        return len(self.position)

    @property
    def cutting(self) -> NDArray[np.bool_]:
        """(N,) True for points that the tool comes to at a feed."""
        return np.asarray(self.move == int(Move.CUT))

    @property
    def first_line(self) -> int:
        """Source line of the first point (0 for an empty region)."""
        return int(self.line[0]) if len(self) else 0

    @property
    def last_line(self) -> int:
        """Source line of the last point (0 for an empty region)."""
        return int(self.line[-1]) if len(self) else 0


def goes_on(before: Region, region: Region) -> bool:
    """Whether a region takes up the cut in which the one before it ends.

    It then begins with the place where the tool stands, as a RAPID, and cuts from there.
    """
    if region.detached or len(region) < 2 or not len(before) or before.move[-1] != Move.CUT:
        return False
    at, axis = region.position[0] - before.position[-1], region.axis[0] - before.axis[-1]
    there = max(float(np.abs(at).max()), float(np.abs(axis).max())) <= _SAME_PLACE
    return bool(there and region.move[0] == Move.RAPID and region.move[1] == Move.CUT)
