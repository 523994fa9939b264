"""The rule of the path: every motion of the file met in order, every motion of the program accounted for.

A program motion is on the file (along its line or arc, forwards, axis and all), or it leaves the part and comes back:

- out along the tool's axis from where it is, through the clear (`Clear`), in along the axis to where it left; or, where the
  file goes by RAPID, to where that motion ends, or one of those that follow up to the next cut; or, where it says nothing of
  the way (`joined` False), to where that motion ends. A RAPID to another operation on another side of the part says nothing;
- before the first motion from HOME through the clear, after the last cut out along the axis and through the clear;
- point to point only from clear to clear, HOME counting as clear;
- down a hole any number of times, no deeper at once than the file's pecks, never deeper than its bottom, and to it, stopping
  there exactly.

`walk` follows both stories at once. Where their rows correspond one to one, blocks are compared; elsewhere a row at a time.
What it found out of each program motion (`Match`) is what the rules of feed, events and state go by.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.witness.happenings import Objection, Run, Story, Way
from camrob.witness.rules.rules_air import Air, Target
from camrob.witness.rules.rules_along import MOVED, Tolerance, step_along, strokes, unlike_pecks
from camrob.witness.rules.rules_blocks import alike, chords, curve_chords, thinned
from camrob.witness.rules.rules_geometry import AXIS, POSITION, Clear, Motion, Track, distance
from camrob.witness.units import deg_to_rad, m_to_mm, rad_to_deg

__all__ = ["Match", "walk"]

Array = NDArray[np.float64]
_SIDE = deg_to_rad(5.0)  # more is another side of the part
_BETWEEN = (0.25, 0.5, 0.75)  # of a motion whose end is right
_MOST = 20  # objections; then the rest is left uncompared


@dataclass(slots=True)
class Match:
    """Where the program is in the file, and which motions are which.

    at: (M + 1,) how many motions of the placed file (`Track`; a fraction within one) are done before each motion of the run
    (last: at its end); NaN after the comparison was broken off. flying: (M + 1,) out in the air there. skipped: between which
    counts a way through the air takes the place of rapids (one more than there are motions: its end). unjudged: (M + 1,)
    within a gap of the file.
    pairs: (K, 2) run's row, story's row: they run together somewhere. cuts: (K,) False for strokes in a hole that is already
    so deep. entries: (run's row, story's row at whose feed it goes) of ways in to a cut. air: the run's rows off the file.
    met: how many motions of the file were.
    """

    at: Array
    flying: NDArray[np.bool_]
    skipped: list[tuple[int, int]]
    unjudged: NDArray[np.bool_]
    pairs: NDArray[np.int64]
    cuts: NDArray[np.bool_]
    entries: NDArray[np.int64]
    air: NDArray[np.int64]
    met: int
    objections: list[Objection]


class _Walk:
    """Both stories with a finger in each: motion `i` from fraction `u` of the file, `j` from `v` of the program."""

    def __init__(
        self, file: Track, story: Story, prog: Track, run: Run, home: NDArray[np.bool_], clear: Clear, tol: Tolerance
    ) -> None:
        self.file, self.prog, self.tol = file, prog, tol
        way, self.ptp = story.way[file.rows], run.ptp[prog.rows]
        self.rapid, self.hole, self.pecks = way == Way.RAPID, way == Way.HOLE, story.pecks
        self.plain = ~self.ptp & prog.known
        self.air = Air(prog, self.ptp, home[prog.rows], clear, tol)
        self.joined = np.append(story.joined[file.rows] & file.known, False)
        found = {int(np.searchsorted(file.rows, gap.before)) for gap in story.gaps}
        self.gaps = {g for g in found if not self.joined[g]}  # others hide no motion
        self.joined[0] = False
        turn, operation = np.linalg.norm(file.axis - file.axis_start, axis=1), story.operation[file.rows]
        self.joined[:-1] &= ~self.rapid | (turn < _SIDE) | (np.diff(operation, prepend=operation[:1]) == 0)
        self.whole = self.joined & ~np.append(np.isin(file.rows, list(story.pecks)), False)  # compared in blocks
        lines = story.path.line[file.rows]
        self.soft = np.append(lines[1:] == lines[:-1], False)
        self.begins = np.flatnonzero(np.append(True, ~self.soft[:-1])) if len(file) else np.zeros(0, np.int64)
        self.file_line, self.prog_line = lines, run.path.line[prog.rows]
        self.prog_file = run.file[prog.rows]
        # where points lie nearer together than the tolerance, only a point's own text is its match
        step = np.linalg.norm(file.tip - file.start, axis=1)
        self.near = np.where((step > 4.0 * POSITION) | (file.angle > 0.0), POSITION, 2e-6)
        self.i, self.u, self.j, self.v = 0, 0.0, 0, 0.0
        self.at = np.full(len(prog), np.nan)
        self.unjudged, self.flying = np.zeros((2, len(prog) + 1), dtype=bool)
        self.skipped: list[tuple[int, int]] = []
        self.chunks: list[NDArray[np.int64]] = []
        self.pairs: list[tuple[int, int, bool]] = []
        self.entries: list[tuple[int, int]] = []
        self.flown: list[int] = []
        self.met = 0
        self.objections: list[Objection] = []

    def go(self) -> None:
        """All of it, or as far as it can be compared."""
        while self.j < len(self.prog):
            if self._many():
                continue
            if self.u == 0.0 and self.i in self.gaps and self._over_gap():
                continue
            if not (self._drill() or self._along() or self._through_air() or self._object()):
                return
        if self._aims()[1] == len(self.file):  # what is left is rapid
            self.skipped.append((self.i, len(self.file) + 1))
        elif self.i < len(self.file):
            lines = f"lines {self.file_line[self.i]} to {self.file_line[-1]}"
            self._say("motion-lost", f"the program ends before the file does: {lines} of the file are not run")

    # --- rows that correspond one to one ---------------------------------------------------------------------------

    def _many(self) -> bool:
        """Passes as many rows as go by in a block; False where none do."""
        if not self._leads_on(self.i) or not self.plain[self.j] or self.v:
            return False
        way = self.file.motion(self.i)
        if way.angle and not self.prog.motion(self.j).angle:
            return self._chords(way)
        if way.curved and self._curve():
            return True
        return self.u == 0.0 and (self._alike(way) or (self.tol.decimated > 0.0 and not way.angle and self._thinned()))

    def _alike(self, way: Motion) -> bool:
        """Rows that are the same motion in both."""
        file, prog, i, j, size = self.file, self.prog, self.i, self.j, 16
        if distance(way.end, prog.motion(j).end) > self.near[i]:
            return False
        while i < len(file) and j < len(prog):
            n = min(size, len(file) - i, len(prog) - j)
            good = alike(file, i, prog, j, n, self.whole, self.plain, self.near)
            i, j, size = i + good, j + good, size * 4
            if good < n:
                break
        return self._pass(np.arange(self.i, i), np.arange(self.i + 1.0, i + 1))

    def _chords(self, way: Motion) -> bool:
        """Chords of one arc, all but those at its end."""
        reached = chords(way, self.u, self.prog, self.j, min(512, len(self.prog) - self.j), self.plain, self.tol)
        if len(reached) < 2:
            return False
        self._pass(np.full(len(reached), self.i), self.i + reached)
        self.u = float(reached[-1])
        return True

    def _curve(self) -> bool:
        """Chords of the rest of one curve."""
        pieces = self.file.curved[self.i + 1 :] & self.soft[self.i : len(self.file) - 1]
        count = 1 + (len(pieces) if pieces.all() else int(np.argmin(pieces)))
        reached = curve_chords(self.file, self.i, count, self.u, self.prog, self.j, self.plain, self.tol)
        first = self.i
        if self._pass(first + np.minimum(reached.astype(np.int64), count - 1), first + reached):
            self.u = first + float(reached[-1]) - self.i
        return len(reached) > 0

    def _thinned(self) -> bool:
        """Straight motions that leave points of the file out."""
        rest = min(1024, len(self.prog) - self.j)
        ends = thinned(self.file, self.i, self.prog, self.j, rest, self.whole, self.plain, self.tol)
        if len(ends):
            steps = np.diff(ends, prepend=0)
            legs = np.repeat(np.arange(len(ends)), steps)
            self.chunks.append(
                np.stack([self.j + legs, self.i + np.arange(len(legs)), np.ones(len(legs), int)], axis=1)
            )
            self.at[self.j : self.j + len(ends)] = self.i + ends
            self.met += len(legs)
            self.i, self.j = self.i + len(legs), self.j + len(ends)
        return len(ends) > 0

    def _pass(self, rows: NDArray[np.int64], at: Array) -> bool:
        """Motions of the program, each of which runs along one of the file; where they get."""
        n = len(rows)
        if n:
            self.chunks.append(np.stack([self.j + np.arange(n), rows, np.ones(n, int)], axis=1))
            self.at[self.j : self.j + n] = at
            done = int(at[-1]) - self.i
            self.met += done
            self.i, self.j = self.i + done, self.j + n
        return n > 0

    # --- along the file ----------------------------------------------------------------------------------------------

    def _along(self) -> bool:
        """Goes along the file as far as this program motion does; False where it doesn't at all."""
        leg, moved = self.prog.motion(self.j), False
        if not self.plain[self.j]:
            return False
        while self.v < 1.0 and self._leads_on(self.i):
            way = self.file.motion(self.i)
            free = bool(self.rapid[self.i])
            soft, statement = bool(self.soft[self.i]), self.file.statement(self.i, self.begins)
            step = step_along(leg, self.v, way, self.u, self.tol, self._beyond(), soft, free, statement)
            if step is None or (self.hole[self.i] and step[0] < 1.0):
                break
            turned = distance(leg.axis(self.v), leg.axis(step[1])) > 0.1 * AXIS
            if turned or (step[1] - self.v) * leg.length > MOVED:
                self.pairs.append((self.j, self.i, True))
            (self.u, self.v), moved = step, True
            if self.u >= 1.0:
                self._next()
        if self.v >= 1.0:
            self._arrive()
        return moved

    def _leads_on(self, i: int) -> bool:
        """Whether the file says how its motion i begins."""
        return bool(self.joined[i])

    def _beyond(self) -> Motion | None:
        """The file's next motion, where it is one to go on with."""
        k = self.i + 1
        return self.file.motion(k) if self._leads_on(k) and not self.hole[k] else None

    def _next(self) -> None:
        """This motion of the file is done."""
        self.i, self.u, self.met = self.i + 1, 0.0, self.met + 1

    def _arrive(self) -> None:
        """This motion of the program is done."""
        self.at[self.j] = self.i + self.u
        self.j, self.v = self.j + 1, 0.0

    def _drill(self) -> bool:
        """Down the hole that comes next, in as many strokes as it takes; False where there is none, or it isn't drilled."""
        i, j = self.i, self.j
        if not self._leads_on(i) or not self.hole[i] or self.u or self.v:
            return False
        cuts = strokes(self.prog, self.ptp, j, self.file.motion(i), self.tol)
        if cuts is None:
            return False
        self.pairs += [(j + k, i, cut.peck > 0.0) for k, cut in enumerate(cuts)]
        most = self.pecks.get(int(self.file.rows[i]))
        for k, code, text in () if most is None else unlike_pecks(cuts, most):
            self.j = j + k
            self._say(code, f"line {self.prog_line[self.j]} of the program {text}")
        if (
            most is not None and most.fed and self._leads_on(i + 1)
        ):  # out of the hole at the feed of the motion behind it
            self.entries += [(j + k, i + 1) for k, cut in enumerate(cuts) if not cut.peck and cut.low <= POSITION]
        self.at[j : j + len(cuts)] = i + 0.5
        self.j = j + len(cuts) - 1
        self._next()
        self._arrive()
        return True

    def _through_air(self) -> bool:
        """Follows the program out of the part, through the clear, and back to the file; False where it does not go so."""
        i, u, leg = self.i, self.u, self.prog.motion(self.j)
        targets, beyond = self._aims()
        if i < len(self.file) and (i or u):
            # where the file itself has come in rapid, the way back may be as fast
            cut = i - 1 if not u and i and (self.rapid[i] or self.rapid[i - 1]) else i
            feeds = -1 if self.rapid[cut] else cut
            targets.append(Target(leg.point(self.v), leg.axis(self.v), i, u, feeds))
        flight = self.air.flight(self.j, self.v, targets, beyond == len(self.file))
        if flight is None:
            return False
        self.at[self.j : flight.j] = i + u
        self.flying[self.j + 1 : flight.j + 1] = True
        self.flown += range(self.j, min(flight.j + 1, len(self.prog)))
        self.j = flight.j
        to = len(self.file) + 1 if flight.target is None else flight.target.i
        self.skipped.append((i, to))
        self.i = min(to, len(self.file))
        if flight.target is not None:
            self.met += to > i
            self.u, self.v = flight.target.u, flight.w
            self.entries += [(k, flight.target.feeds) for k in flight.entry]
            if self.v >= 1.0:
                self._arrive()
        return True

    def _aims(self) -> tuple[list[Target], int]:
        """Where the file lets a way through the air lead, and the motion of the file that has to follow on it."""
        i, targets = self.i, list[Target]()
        if i < len(self.file) and not self.joined[i] and not self.rapid[i]:
            way = self.file.motion(i)
            return [Target(way.end, way.axis_end, i + 1, 0.0, i)], i
        while i < len(self.file) and self.rapid[i] and (i == self.i or i not in self.gaps):
            way = self.file.motion(i)
            i += 1
            targets.append(Target(way.end, way.axis_end, i, 0.0))
        return targets, i

    # --- what the file's reader left out, and what is wrong --------------------------------------------------------------

    def _over_gap(self) -> bool:
        """Over what the reader of the file left out, to where the program takes up the file again."""
        self.gaps.remove(self.i)
        found = len(self.prog)
        if self.i < len(self.file):
            off = np.linalg.norm(self.prog.tip[self.j :] - self.file.tip[self.i], axis=1)
            turn = np.linalg.norm(self.prog.axis[self.j :] - self.file.axis[self.i], axis=1)
            hits = self.j + np.flatnonzero((off <= self.tol.place) & (turn <= self.tol.axis))[:50]
            if not len(hits):
                return False
            found = next((int(k) for k in hits if self._goes_on(int(k))), int(hits[0])) + 1
        self.unjudged[self.j : found] = True
        self.at[self.j : found] = self.i
        self.j, self.v = found, 0.0
        if self.i < len(self.file):
            self.at[found - 1] = self.i + 1
            self._next()
        else:
            self.unjudged[found] = True
        return True

    def _goes_on(self, j: int) -> bool:
        """Whether the program goes on after its motion j as the file does after its motion i."""
        if j + 1 >= len(self.prog) or not self._leads_on(self.i + 1):
            return True
        way, leg = self.file.motion(self.i + 1), self.prog.motion(j + 1)
        return step_along(leg, 0.0, way, 0.0, self.tol, None) is not None

    def _object(self) -> bool:
        """Says what is wrong here, and goes on where both stories agree again; False where they never do, or no longer."""
        line = f"line {self.prog_line[self.j]} of the program"
        if self.i >= len(self.file):
            self._say("motion-extra", f"{line} moves on where the file has ended, and not through the clear")
            return False
        there = self._agree_again()
        if there is not None and there[0] == self.i:
            self._say("motion-extra", f"{line} moves where the file has no motion, and not through the clear")
        elif there is not None and there[1] == self.j:
            self._say("motion-lost", f"line {self.file_line[self.i]} of the file is left out before {line}")
        else:
            self._say(
                "off-path", f"{line} does not run along line {self.file_line[self.i]} of the file: {self._how_far()}"
            )
        if there is None or len(self.objections) >= _MOST:
            return False
        self.at[self.j : there[1]] = there[0]
        (self.i, self.j), self.u, self.v = there, 0.0, 0.0
        return True

    def _how_far(self) -> str:
        leg, way = self.prog.motion(self.j), self.file.motion(self.i)
        off = m_to_mm(
            way.nearest(leg.end, leg.axis_end, self.u)[1] if self.joined[self.i] else distance(leg.end, way.end)
        )
        turn = rad_to_deg(distance(leg.axis_end, way.axis_end))
        places = ((leg.point(f), leg.axis(f)) for f in _BETWEEN)
        between = m_to_mm(max(way.nearest(p, axis, self.u)[1] for p, axis in places))
        if off <= m_to_mm(self.tol.place) < between:
            return f"it ends there, but is {between:.3f} mm off on its way"
        return f"its end is {off:.3f} mm off, and its axis {turn:.3f} degrees from that at the motion's end"

    def _agree_again(self) -> tuple[int, int] | None:
        """The next (i, j) before which both stories have ended two motions in the same places."""
        i, j = self.i, self.j
        tips = self.file.tip[i : i + 60], self.prog.tip[j : j + 240]
        near = np.linalg.norm(tips[0][:, None] - tips[1][None], axis=2) <= self.tol.place
        pairs = np.argwhere(near[:-1, :-1] & near[1:, 1:])
        pairs = pairs[np.argsort(pairs.sum(axis=1), kind="stable")]
        return (i + int(pairs[0][0]) + 1, j + int(pairs[0][1]) + 1) if len(pairs) else None

    def _say(self, code: str, text: str) -> None:
        i, j = min(self.i, len(self.file) - 1), min(self.j, len(self.prog) - 1)
        self.objections.append(
            Objection(code, text, int(self.file_line[i]), int(self.prog_line[j]), int(self.prog_file[j]))
        )


def walk(
    file: Track, story: Story, prog: Track, run: Run, home: NDArray[np.bool_], clear: Clear, tol: Tolerance
) -> Match:
    """Follows both stories, of one motion or more each, from first to last. home: (M,) whether a motion ends at HOME."""
    walker = _Walk(file, story, prog, run, home, clear, tol)
    walker.go()
    # motions that lead nowhere leave the program where it was
    done = np.searchsorted(prog.rows, np.arange(len(run)), side="right")
    at = np.concatenate([[0.0], walker.at])[np.concatenate([[0], done])]
    next_row = np.searchsorted(prog.rows, np.arange(len(run) + 1))
    odd = np.array(walker.pairs, dtype=np.int64).reshape(-1, 3)
    pairs = np.vstack([odd, *walker.chunks])
    entries = np.array(walker.entries, dtype=np.int64).reshape(-1, 2)
    return Match(
        at=at,
        flying=walker.flying[next_row],
        skipped=walker.skipped,
        unjudged=walker.unjudged[next_row],
        pairs=np.stack([prog.rows[pairs[:, 0]], file.rows[pairs[:, 1]]], axis=1),
        cuts=pairs[:, 2] > 0,
        entries=np.stack([prog.rows[entries[:, 0]], file.rows[entries[:, 1]]], axis=1),
        air=prog.rows[np.array(walker.flown, dtype=np.int64)],
        met=walker.met,
        objections=walker.objections,
    )
