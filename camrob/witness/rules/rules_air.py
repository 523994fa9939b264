"""The program's ways through the air: out of the part, through the clear, and in again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.witness.rules.rules_along import Tolerance
from camrob.witness.rules.rules_geometry import Clear, Motion, Track, Vec, along_ray, distance

__all__ = ["Air", "Flight", "Target"]

_ENTRY = 5e-4  # m: the end of a way in, which is made at the cut's own feed


@dataclass(slots=True)
class Target:
    """Where a way through the air may end: the pose, what is reached of the file with it, and the file's row at whose feed it
    comes in (-1: rapid will do).
    """

    point: Vec
    axis: Vec
    i: int
    u: float
    feeds: int = -1


@dataclass(slots=True)
class Flight:
    """A way through the air up to the program's motion j, which reaches `target` at its fraction w (None: the program ends).

    entry: the motions that make the last bit of the way in, where it leads into the part.
    """

    j: int
    target: Target | None
    w: float
    entry: list[int]


@dataclass(slots=True)
class Air:
    """What a way through the air is judged by. ptp, home: (M,) of the program's motions; home: it ends at HOME."""

    prog: Track
    ptp: NDArray[np.bool_]
    home: NDArray[np.bool_]
    clear: Clear
    tol: Tolerance

    def flight(self, j: int, v: float, targets: list[Target], may_end: bool) -> Flight | None:
        """The way that leaves the file in the program's motion j at its fraction v; None where it is none.

        Out along the tool's axis until clear, any motions in the clear, in along a target's axis; or, where it
        `may_end`, to the program's end. A way that only goes out and comes back down to where it left needn't reach the clear.
        """
        leg = self.prog.motion(j)
        out = (leg.point(v), leg.axis(v))
        entering: Target | None = None
        down: list[int] = []
        while j < len(self.prog):
            if not self.prog.known[j]:
                return None
            leg = self.prog.motion(j)
            clear = self._begins_clear(leg, v, j)
            # down the axis from the clear, or once on its way down; and back down the axis that it left by
            open_to = targets if clear else [t for t in targets if t is entering or (t.point, t.axis) == out]
            for target in open_to:
                w = self._arrives(leg, v, j, target, clear)
                if w is not None:
                    shut = target.feeds >= 0 and not self.clear.holds(target.point, target.axis)
                    return Flight(j, target, w, [*down, j] if shut else [])
            if clear and self._stays_clear(leg, v, j):
                entering, down = None, []
            elif self.ptp[j]:
                return None
            elif into := self._descends(leg, v, open_to):
                entering = into
                if distance(leg.end, into.point) < _ENTRY:
                    down.append(j)
            elif clear or entering or not self._on_ray(leg, v, *out) or not self._up(leg, v, out[1]):
                return None
            j, v = j + 1, 0.0
        return Flight(j, None, 0.0, []) if may_end else None

    def _begins_clear(self, leg: Motion, v: float, j: int) -> bool:
        """Whether a motion begins in the clear. The program's first one begins where the operator lets it: at HOME."""
        home = v == 0.0 and (j == 0 or bool(self.home[j - 1]))
        return home or self.clear.holds(leg.point(v), leg.axis(v))

    def _stays_clear(self, leg: Motion, v: float, j: int) -> bool:
        """Whether a motion that begins in the clear goes through it; of point-to-point motions the end says so."""
        if self.ptp[j] or j == 0:
            return bool(self.home[j]) or self.clear.holds(leg.end, leg.axis_end)
        return self.clear.all_along(leg, v)

    def _on_ray(self, leg: Motion, v: float, point: Vec, axis: Vec) -> bool:
        """Whether a straight motion runs along the tool's axis through a point."""
        turn = max(distance(leg.axis(v), axis), distance(leg.axis_end, axis))
        aside = max(along_ray(p, point, axis)[1] for p in (leg.point(v), leg.end))
        return not leg.angle and turn <= self.tol.axis and aside <= self.tol.place

    @staticmethod
    def _up(leg: Motion, v: float, axis: Vec) -> bool:
        return along_ray(leg.end, leg.point(v), axis)[0] >= 0.0

    def _descends(self, leg: Motion, v: float, targets: list[Target]) -> Target | None:
        """The target down whose axis a motion goes, not yet as far as it."""
        for target in targets:
            if self._on_ray(leg, v, target.point, target.axis) and not self._up(leg, v, target.axis):
                if along_ray(leg.end, target.point, target.axis)[0] > 0.0:
                    return target
        return None

    def _arrives(self, leg: Motion, v: float, j: int, target: Target, clear: bool) -> float | None:
        """The fraction of a motion at which it reaches a target, down its axis or through the clear; None where it doesn't."""
        near = (
            distance(leg.end, target.point) <= self.tol.place and distance(leg.axis_end, target.axis) <= self.tol.axis
        )
        if near and clear and self._stays_clear(leg, v, j):
            return 1.0
        if self.ptp[j] or j == 0 or leg.angle:
            return None
        w, off = leg.nearest(target.point, target.axis, v)
        up, aside = along_ray(leg.point(v), target.point, target.axis)
        kept = max(distance(leg.axis(v), target.axis), distance(leg.axis(w), target.axis)) <= self.tol.axis
        if off > self.tol.place or aside > self.tol.place or not kept or up <= self.tol.place or w <= v:
            return None
        return 1.0 if near else w
