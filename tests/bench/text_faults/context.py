"""What a rule draws from: a posted program's tree, walked once in its order of execution."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from text_faults.tree import At, Node, Tree

RAPID = 0.1
"""m/s: what these jobs move at in rapid."""


class NothingToDrawError(Exception):
    """The rule finds no place for itself in this program."""


@dataclass(frozen=True)
class Motion:
    """A motion in its context. index: among all motions, in order. speed: `$VEL.CP`, 0 for PTP.

    last: the pose fields where it begins (empty after axis values). cut: whether it is a CP motion at a cutting feed.
    own: whether camrob added it (the ways in and out above the file's own points).
    """

    at: At
    node: Node
    index: int
    speed: float
    last: Mapping[str, float]
    cut: bool
    own: bool

    @property
    def end(self) -> dict[str, float]:
        return self.node.points[-1].values

    @property
    def length(self) -> float:
        """The chord, mm; 0 where the start is not a pose."""
        if not self.last or self.node.axes:
            return 0.0
        return sum((self.end[k] - self.last[k]) ** 2 for k in "XYZ") ** 0.5


class Draw:
    """One draw of a rule on a program. others: trees of the other jobs. top: Z of the file's highest point in `base`, mm."""

    def __init__(self, name: str, tree: Tree, others: Mapping[str, Tree], rng: random.Random, top: float) -> None:
        self.name = name
        self.tree = tree
        self.others = others
        self.rng = rng
        self.order = tree.order()
        self.motions = _motions(tree, self.order, top)

    def pick(self, things: Sequence[object] | list[object]):  # type: ignore[no-untyped-def]
        """One of some things. Raises NothingToDrawError where there is none."""
        if not things:
            raise NothingToDrawError
        return self.rng.choice(list(things))

    def motion(self, fits: Callable[[Motion], bool]) -> Motion:
        """A motion that fits."""
        return self.pick([m for m in self.motions if fits(m)])

    def cut(self) -> Motion:
        return self.motion(lambda m: m.cut)

    def lin(self, *, cut: bool | None = None) -> Motion:
        """A LIN that the file asks for."""
        return self.motion(lambda m: m.node.kind == "lin" and not m.own and (cut is None or m.cut == cut))

    def lines(self, kind: str, name: str = "", value: str = "") -> list[At]:
        """Places of lines of a kind, in order."""
        out = [a for a in self.order if self.tree.at(a).kind == kind]
        if name:
            out = [a for a in out if self.tree.at(a).name == name]
        return [a for a in out if not value or self.tree.at(a).value == value]

    def line(self, kind: str, name: str = "", value: str = "") -> At:
        return self.pick(self.lines(kind, name, value))

    def place(self, at: At) -> int:
        """How far down the order of execution a line stands."""
        return self.order.index(at)

    def next_motion(self, at: At, step: int = 1) -> Motion:
        """The step-th motion behind a line."""
        after = [m for m in self.motions if self.place(m.at) > self.place(at)]
        if len(after) < step:
            raise NothingToDrawError
        return after[step - 1]

    def last_motion(self, at: At) -> Motion:
        """The motion before a line."""
        before = [m for m in self.motions if self.place(m.at) < self.place(at)]
        if not before:
            raise NothingToDrawError
        return before[-1]

    def run(self) -> list[Motion]:
        """A run of cutting motions in one file, three or more."""
        runs: list[list[Motion]] = [[]]
        for m in self.motions:
            same = runs[-1] and runs[-1][-1].at.file == m.at.file
            if m.cut and (same or not runs[-1]):
                runs[-1].append(m)
            else:
                runs.append([m] if m.cut else [])
        return self.pick([r for r in runs if len(r) >= 3])


def _motions(tree: Tree, order: list[At], top: float) -> list[Motion]:
    out: list[Motion] = []
    speed, last = 0.0, {}
    for at in order:
        node = tree.at(at)
        if node.kind == "set" and node.name == "$VEL.CP":
            speed = float(node.value)
        if node.moves:
            end = node.points[-1].values
            here = 0.0 if node.kind == "ptp" else speed
            own = node.kind == "ptp" or end["Z"] > top + 1.0
            out.append(Motion(at, node, len(out), here, last, 0.0 < here < RAPID, own))
            last = {} if node.axes else end
    return out
