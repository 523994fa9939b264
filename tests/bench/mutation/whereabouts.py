"""Where along its job's story a motion of a program leads, and what is clear of what the story cuts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mutation.near import apart, passed
from mutation.replay import Move
from mutation.story import Story

Array = NDArray[np.float64]

TIP_MM, AXIS_DEG = 0.01, 0.01
TURNING_DEG = 0.5  # of the axis in the middle of a motion that turns the tool: interpolations differ there
ROUNDED_MM = 0.002  # what three decimals of X, Y and Z may move a point by
NEAR_MM = 0.03  # of a file's point: a motion that ends there has to meet it
AHEAD = 400  # spans that one motion may stand for


class Whereabouts:
    """A tip on its way along a story: `u` is how far along, k at point k, -1 before the first; `linking`: off it, in air."""

    def __init__(self, story: Story, decimate: float) -> None:
        self.story, self.decimate = story, decimate
        self.u = -1.0
        self.linking = True
        points = story.points()
        self.center = 0.5 * (points.min(axis=0) + points.max(axis=0))
        self.radius = float(np.linalg.norm(points - self.center, axis=1).max())
        self.points = points

    def _landed(self, move: Move, goal: float) -> float | None:
        """A PTP leads to the story's next point only."""
        return goal if goal == np.floor(self.u) + 1 else None

    def _located(self, move: Move) -> float | None:
        """How far along the story the motion's end lies, and its way with it; None where it leads elsewhere."""
        tip, axis = move.base_T_tip[-1, :3, 3], move.base_T_tip[-1, :3, 2]
        k = int(np.floor(self.u))
        n = len(self.story)
        if self.linking:
            for point in (k, k + 1):
                if 0 <= point < n and self._meets(tip, axis, float(point)):
                    return float(point)
            free = k + 1 < n and self.story.spans[k + 1].feed is None
            return self._after_rapids(move, k + 2) if free else None
        if (further := self._a_little_further(move)) is not None:
            return further
        if self._meets(tip, axis, self.u):
            return self.u
        if self.u == k and (deeper := self._without_pecks(move, k)) is not None:
            return deeper
        for span in range(k + 1, min(k + 1 + AHEAD, n)):
            share = self._share(span, tip, max(self.u - (span - 1), 0.0))
            at = span - 1 + share
            if (
                share < 1.0
                and np.linalg.norm(tip - move.base_T_tip[0, :3, 3]) > NEAR_MM  # not one of a row of ever so short steps
                and min(np.linalg.norm(self.story.spans[span].place(e) - tip) for e in (0.0, 1.0)) <= NEAR_MM
            ):
                continue  # at a point of the file's, or nowhere
            if at > self.u and self._meets(tip, axis, at) and self._on_the_way(move, at):
                return at
        return None

    def _a_little_further(self, move: Move) -> float | None:
        """Along a curve by less than the tolerance: such a motion is not one that stands."""
        k, tip = int(np.floor(self.u)), move.base_T_tip[-1, :3, 3]
        if k + 1 >= len(self.story) or not (way := self.story.spans[k + 1]).arc:
            return None
        ends = float(np.linalg.norm(way.place(1.0) - tip)) <= ROUNDED_MM
        share = 1.0 if ends else self._nearest(k + 1, tip, self.u - k)
        step = float(np.linalg.norm(way.place(share) - way.place(self.u - k)))
        if step <= ROUNDED_MM or not self._meets(tip, move.base_T_tip[-1, :3, 2], k + share):
            return None
        return k + share if self._on_the_way(move, k + share) else None

    def _past_a_rapid(self, move: Move) -> bool:
        """Within a rapid of the file's, through its end and on: nobody has to stop in the air."""
        k = int(np.ceil(self.u))
        if self.u == k or k < 0 or self.story.spans[k].feed is not None:
            return False
        off, axis = passed(move.base_T_tip, self.story.point(k))
        return off <= TIP_MM and apart(axis, self.story.spans[k].axis(1.0)) <= AXIS_DEG

    def _without_pecks(self, move: Move, k: int) -> float | None:
        """Down a hole at its feed, without the rapids out of it and back that the story has between two pecks."""
        spans, j = self.story.spans, k + 2
        while j < len(self.story) and spans[j - 1].feed is None and (spans[j].feed is None or spans[j].open > 0.0):
            if spans[j].open > 0.0 and self._meets(move.base_T_tip[-1, :3, 3], move.base_T_tip[-1, :3, 2], float(j)):
                return float(j) if self._above(move.base_T_tip, j).all() else None
            j += 1
        return None

    def _after_rapids(self, move: Move, k: int) -> float | None:
        """Out of the air to a point behind rapids that were left out: another rapid's, or that of a cut straight down on it."""
        tip, axis = move.base_T_tip[-1, :3, 3], move.base_T_tip[-1, :3, 2]
        while k < len(self.story):
            if self._meets(tip, axis, float(k)):
                cut = self.story.spans[k].feed is not None
                return float(k) if not cut or self._above(move.base_T_tip, k).all() else None
            if self.story.spans[k].feed is not None:
                return None
            k += 1
        return None

    def _share(self, span: int, tip: Array, least: float) -> float:
        """The share of a span that lies nearest to a tip, 1 where its end is within the tolerance."""
        way = self.story.spans[span]
        if float(np.linalg.norm(way.place(1.0) - tip)) <= self._tolerance(span):
            return 1.0
        if way.arc:
            return self._nearest(span, tip, least)
        start, end = way.place(0.0), way.place(1.0)
        length = float((end - start) @ (end - start))
        return float(np.clip((tip - start) @ (end - start) / length, 0.0, 1.0)) if length > 0.0 else 0.0

    def _nearest(self, span: int, tip: Array, least: float) -> float:
        """The share of a curve that lies nearest to a tip."""
        way = self.story.spans[span]
        shares = np.linspace(least, 1.0, 91)
        gaps = [float(np.linalg.norm(way.place(float(s)) - tip)) for s in shares]
        best = int(np.argmin(gaps))
        low, high = shares[max(best - 1, 0)], shares[min(best + 1, 90)]
        for _ in range(40):
            a, b = low + (high - low) / 3, high - (high - low) / 3
            if np.linalg.norm(way.place(a) - tip) < np.linalg.norm(way.place(b) - tip):
                high = b
            else:
                low = a
        return float((low + high) / 2)

    def _tolerance(self, span: int) -> float:
        return TIP_MM + self.story.spans[max(span, 0)].slack + self.decimate

    def _meets(self, tip: Array, axis: Array, at: float) -> bool:
        span = int(np.ceil(at))
        if span < 0:
            return False
        way = self.story.spans[span]
        share = 1.0 - (span - at)
        near = float(np.linalg.norm(way.place(share) - tip)) <= self._tolerance(span)
        loose = TURNING_DEG if way.turning and 0.0 < share < 1.0 else AXIS_DEG
        return near and apart(axis, way.axis(share)) <= loose

    def _on_the_way(self, move: Move, goal: float) -> bool:
        """The file's points that the motion passes lie on it, and it lies on the file's path."""
        for k in range(int(np.floor(self.u)) + 1, int(np.ceil(goal))):
            off, axis = passed(move.base_T_tip, self.story.point(k))
            if off > self._tolerance(k) or apart(axis, self.story.axis(k)) > AXIS_DEG:
                return False
        for sample in move.base_T_tip[1:-1]:
            if not self._near_path(sample, goal):
                return False
        return True

    def _near_path(self, pose: Array, goal: float) -> bool:
        for span in range(int(np.floor(self.u)) + 1, int(np.ceil(goal)) + 1):
            way = self.story.spans[span]
            share = self._share(span, pose[:3, 3], 0.0)
            near = float(np.linalg.norm(way.place(share) - pose[:3, 3])) <= self._tolerance(span)
            loose = TURNING_DEG if way.turning else AXIS_DEG
            if near and apart(pose[:3, 2], way.axis(share)) <= loose:
                return True
        return False

    def _clear(self, poses: Array) -> NDArray[np.bool_]:
        """(S,) the tip is above all points along its own axis, or outside of the ball about them."""
        tip, axis = poses[:, :3, 3], poses[:, :3, 2]
        top = (axis @ self.points.T).max(axis=1)
        above = np.sum(tip * axis, axis=1) >= top - TIP_MM
        return np.asarray(above | (np.linalg.norm(tip - self.center, axis=1) >= self.radius - TIP_MM))

    def _above(self, poses: Array, point: int) -> NDArray[np.bool_]:
        """(S,) the tool is drawn back along its axis from a point of the story."""
        p, a = self.story.point(point), self.story.axis(point)
        way = poses[:, :3, 3] - p
        along = way @ a
        aside = np.linalg.norm(way - along[:, None] * a, axis=1)
        turned = np.array([apart(axis, a) for axis in poses[:, :3, 2]])
        return np.asarray((aside <= TIP_MM) & (along >= -TIP_MM) & (turned <= AXIS_DEG))
