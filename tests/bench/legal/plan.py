"""A job drawn at random: what the tool does, told once, for a dialect to write down and for a story to hold the program to."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from random import Random
from typing import Any

from mutation.story import Story

Point = tuple[float, float, float]
CLEAR = 40.0  # mm above the part's zero: over everything that is drawn
_SLIVER = 0.01  # of a peck: what is left of less goes with the one before it


@dataclass(frozen=True)
class Step:
    """One thing that the file says. kind: `operation`, `change`, `cw`, `ccw`, `off`, `wet`, `dry`, `dwell`, `halt`, `rapid`,
    `cut`, `arc`, `hole`; the rest as that kind needs it, in mm, degrees, mm/min, seconds.
    """

    kind: str
    at: Point = (0.0, 0.0, 0.0)
    axis: Point | None = None
    feed: float = 0.0
    value: float = 0.0
    center: Point = (0.0, 0.0, 0.0)
    turn: float = 0.0
    more: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Able:
    """What a dialect can say. grid: mm, the last digit that it writes. tilts: the tool may lean. circles: whole ones."""

    grid: float = 0.001
    tilts: bool = True
    circles: bool = True


def draw(rng: Random, able: Able) -> list[Step]:
    """A job of one to three operations, with one tool or several, that the shipped cell can do."""
    return _Draw(rng, able).job()


class _Draw:
    def __init__(self, rng: Random, able: Able) -> None:
        self.rng, self.able = rng, able
        self.steps: list[Step] = []
        self.feed = 0.0
        self.axis: Point = (0.0, 0.0, 1.0)
        self.here: Point = (0.0, 0.0, 0.0)
        self.wet = False

    def job(self) -> list[Step]:
        rng, tool = self.rng, 0
        for k in range(rng.randint(1, 3)):
            changes = not tool or rng.random() < 0.4
            if changes and tool:
                if self.wet:
                    self._coolant(False)
                self._say("off")
            if changes:
                tool = rng.choice([t for t in range(1, 20) if t != tool])
            self._say("operation", value=k, more={"tool": tool})
            if changes:
                self._say("change", value=tool)
                kind = "ccw" if rng.random() < 0.15 else "cw"
                self._say(kind, value=rng.choice((600, 1200, 4500, 9000, 17999)))
            if rng.random() < 0.5 and not self.wet:
                self._coolant(True)
            self._lean(rng.choice((0.15, 0.5, 1.2)))
            self._operation()
            if rng.random() < 0.15:
                self._say("halt")
        if self.wet and rng.random() < 0.8:
            self._coolant(False)
        self._say("off")
        return self.steps

    def _operation(self) -> None:
        rng = self.rng
        self._rapid(self._spot(CLEAR + rng.choice((0, 5, 12))))
        if rng.random() < 0.3 and self.axis == (0.0, 0.0, 1.0):
            return self._holes()
        for _ in range(rng.randint(1, 2)):
            start = self._spot(rng.uniform(-4, 6))
            self._rapid((start[0], start[1], CLEAR))
            if rng.random() < 0.5:
                self._rapid((start[0], start[1], self._on(start[2] + rng.uniform(1, 9))))
            self.feed = rng.choice((90, 240, 400, 650.5, 900))
            self._cut(start)
            for _ in range(rng.randint(1, 6)):
                self._piece()
            if self.wet and rng.random() < 0.2:
                self._coolant(False)
            self._rapid((self.here[0], self.here[1], CLEAR))

    def _piece(self) -> None:
        """On in the cut: a line, a leaning line, an arc, a dwell, another feed, coolant."""
        rng = self.rng
        which = rng.choice(("line", "line", "lean", "arc", "arc", "dwell", "feed", "wet"))
        if which == "dwell":
            if self.steps[-1].kind != "dwell":
                self._say("dwell", value=rng.choice((0.25, 0.5, 1.5)))
        elif which == "feed":
            self.feed = rng.choice((120, 333, 700))
        elif which == "wet":
            self._coolant(not self.wet)
        elif which == "arc" and self.axis == (0.0, 0.0, 1.0):
            self._arc()
        else:
            if which == "lean":
                self._lean(0.12)
            self._cut(tuple(self._on(v + rng.uniform(-15, 15) / (4 if i == 2 else 1)) for i, v in enumerate(self.here)))

    def _arc(self) -> None:
        """A quarter, a half, three quarters of a circle, or all of it, in the plane across the tool."""
        rng, grid = self.rng, self.able.grid
        r = round(rng.uniform(2, 14) / grid) * grid
        way = rng.choice(((r, 0.0), (-r, 0.0), (0.0, r), (0.0, -r)))
        center = (self.here[0] + way[0], self.here[1] + way[1], self.here[2])
        quarters = rng.choice((1, 2, 3, 4) if self.able.circles else (1, 2, 3)) * rng.choice((1, -1))
        x, y = -way[0], -way[1]
        for _ in range(quarters % 4):
            x, y = -y, x
        self.here = (self._on(center[0] + x), self._on(center[1] + y), self.here[2])
        self._say("arc", at=self.here, feed=self.feed, center=center, turn=90.0 * quarters)

    def _holes(self) -> None:
        rng = self.rng
        more = {
            "depth": self._on(rng.uniform(3, 14)),
            "clear": self._on(rng.uniform(1, 4)),
            "back": self._on(rng.uniform(5, 15)),
            "dwell": rng.choice((0.0, 0.0, 0.5)),
            "peck": 0.0,
        }
        if rng.random() < 0.4:
            more["peck"] = self._on(rng.uniform(2, 6))
        if more["peck"]:
            more["dwell"] = 0.0
        feed, level = rng.choice((60, 120, 150)), self._on(rng.uniform(-1, 3))
        for _ in range(rng.randint(1, 3)):
            spot = self._spot(level)
            self._say("hole", at=spot, feed=feed, more=more)
            self.here = (spot[0], spot[1], spot[2] + more["back"])
        self._say("cycle-off")
        self._rapid((self.here[0], self.here[1], CLEAR))

    def _lean(self, most: float = 0.5) -> None:
        """Another axis of the tool, by at most so many radians from upright or, within a cut, from where it is."""
        if not self.able.tilts or self.rng.random() < 0.5:
            return
        tilt, toward = self.rng.uniform(0.02, most), self.rng.uniform(-math.pi, math.pi)
        x, y = math.sin(tilt) * math.cos(toward), math.sin(tilt) * math.sin(toward)
        if most < 0.5:
            x, y = x + self.axis[0], y + self.axis[1]
        over = math.hypot(x, y)
        if over > 1.0:  # beyond the horizontal: as far as a tool may lean
            x, y = 0.99 * x / over, 0.99 * y / over
        self.axis = (round(x, 9), round(y, 9), round(math.sqrt(1.0 - x * x - y * y), 9))

    def _coolant(self, wet: bool) -> None:
        self.wet = wet
        self._say("wet" if wet else "dry")

    def _rapid(self, at: Point) -> None:
        at = (self._on(at[0]), self._on(at[1]), self._on(at[2]))
        if at != self.here or not any(s.kind in ("rapid", "cut", "arc", "hole") for s in self.steps):
            self.here = at
            self._say("rapid", at=at, axis=self.axis)

    def _cut(self, at: Sequence[float]) -> None:
        self.here = (self._on(at[0]), self._on(at[1]), self._on(at[2]))
        self._say("cut", at=self.here, axis=self.axis, feed=self.feed)

    def _spot(self, z: float) -> Point:
        return self._on(self.rng.uniform(-45, 45)), self._on(self.rng.uniform(-45, 45)), self._on(z)

    def _on(self, value: float) -> float:
        """On the dialect's grid."""
        return round(value / self.able.grid) * self.able.grid

    def _say(self, kind: str, **how: Any) -> None:
        self.steps.append(Step(kind, **how))


def told(steps: Sequence[Step], place: tuple[float, ...], plane: bool) -> Story:
    """The story of a job. plane: holes by planes, as G99 does them, with pecks from the clearance on and back up to it only; else
    pecks count from the point, and the way back ends at a height of its own, by which the tool comes, too.
    """
    story, wet = Story(part_in_base=place), False
    here: Point = (0.0, 0.0, CLEAR)
    for step in steps:
        if step.kind in ("operation", "cycle-off"):
            continue
        if step.kind == "hole":
            here = _hole(story, step, here, plane)
        elif step.kind == "rapid":
            story.rapid(*step.at, axis=step.axis)
        elif step.kind == "cut":
            story.cut(step.feed, *step.at, axis=step.axis)
        elif step.kind == "arc":
            story.arc(step.feed, step.center, (0.0, 0.0, 1.0), step.turn)
        else:
            wet = step.kind == "wet" or (wet and step.kind != "dry")
            story.event(step.kind, step.value)
        if step.kind in ("rapid", "cut", "arc"):
            here = step.at
    return story.event("dry") if wet else story  # the end of a file ends it


def _hole(story: Story, step: Step, here: Point, plane: bool) -> Point:
    """Level to over the hole, down to its clearance, to its bottom, back up."""
    (x, y, z), more = step.at, step.more
    clear, goal, peck = z + more["clear"], z - more["depth"], more["peck"]
    back = clear if plane else z + more["back"]
    for height in (here[2], back, clear):
        if (x, y, height) != here:
            story.rapid(x, y, height)
            here = (x, y, height)
    low, done = clear if plane else z, False
    while peck and low - peck > goal + _SLIVER * peck:
        low -= peck
        story.cut(step.feed, x, y, low, open=0.5 if done else 0.0).rapid(x, y, clear).rapid(x, y, low + 0.5)
        done = True
    story.cut(step.feed, x, y, goal, open=0.5 if done else 0.0)
    if more["dwell"]:
        story.event("dwell", more["dwell"])
    story.rapid(x, y, back)
    return x, y, back
