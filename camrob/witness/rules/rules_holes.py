"""What a cycle says beside its path: holes go to their bottom, and the way from one to the next is the one that it names."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.witness.happenings import Objection, Run, Story, Way
from camrob.witness.rules.rules_geometry import AXIS, POSITION, Track
from camrob.witness.rules.rules_path import Match
from camrob.witness.units import m_to_mm, mm_to_m

__all__ = ["hole_objections"]

_ABOVE = mm_to_m(0.1)  # above what is drilled a rapid has to end: chips lie there, and a robot overshoots
_FASTER = 6e-7  # m/s: half the last decimal of a speed that is printed, and a little


def hole_objections(match: Match, file: Track, story: Story, prog: Track, run: Run) -> list[Objection]:
    """What stands against the holes of a program."""
    return [
        *_rounded(match, file, story, prog, run),
        *_between_pecks(match, file, story, prog, run),
        *_retracted(match, file, story, prog, run),
    ]


def _rounded(match: Match, file: Track, story: Story, prog: Track, run: Run) -> list[Objection]:
    """Holes at whose bottom the program rounds the corner, and so doesn't reach it: the first, and how many; and likewise where
    between two pecks it comes out of the hole at a feed of the file's own, which is no rapid to be rounded into.
    """
    holes = story.way[match.pairs[:, 1]] == Way.HOLE
    j, i = match.pairs[holes & ~match.cuts].T
    out = np.array([row for row, pecks in story.pecks.items() if pecks.out and pecks.fed], dtype=np.int64)
    ends, starts = prog.tip[np.searchsorted(prog.rows, j)], file.start[np.searchsorted(file.rows, i)]
    drawn = np.isin(i, out) & (np.linalg.norm(ends - starts, axis=1) <= POSITION)
    top = np.unique(j[drawn & ~run.exact[j]])
    if len(top):
        return [_said("hole-rounded", "out of a hole between two pecks, and there it is rounded off", run, int(top[0]))]
    j, i = match.pairs[holes & match.cuts].T
    deepest = np.zeros(len(story), dtype=np.int64)
    np.maximum.at(deepest, i, j)
    rows = np.unique(deepest[i])
    rows = rows[~run.exact[rows]]
    if not len(rows):
        return []
    many = "" if len(rows) == 1 else f", nor are {len(rows) - 1} more"
    return [
        _said("hole-rounded", f"the hole's bottom is not reached exactly{many}: it is rounded off", run, int(rows[0]))
    ]


def _between_pecks(match: Match, file: Track, story: Story, prog: Track, run: Run) -> list[Objection]:
    """The first rapid that ends on what is drilled already, and, as a warning, the first turn between two pecks that is rounded
    off, so that the tool does not come out as high as the file says.
    """
    holes = story.way[match.pairs[:, 1]] == Way.HOLE
    (j, i), cuts = match.pairs[holes].T, match.cuts[holes]
    if not len(j):
        return []
    order = np.lexsort((j, i))
    j, i, cuts = j[order], i[order], cuts[order]
    row = np.searchsorted(file.rows, i)
    off = file.start[row] - prog.tip[np.searchsorted(prog.rows, j)]
    low = np.einsum("ij,ij->i", off, file.axis[row])  # m below where the hole's motion starts
    first = np.append(True, np.diff(i) != 0)
    came = np.where(first, 0.0, np.append(0.0, low[:-1]))
    # a hole's count times this keeps what was reached in it from the others'
    reach = 2.0 * float(np.abs(low).max()) + 1.0
    far = np.cumsum(first) * reach
    deepest = np.maximum.accumulate(np.maximum(low, 0.0) + far) - far
    drilled = np.where(first, 0.0, np.append(0.0, deepest[:-1]))
    down, found = low > came + POSITION, list[Objection]()
    fast = run.speed[j] > story.feed[i] + _FASTER
    onto = np.flatnonzero(~cuts & down & fast & (low > drilled - _ABOVE))
    if len(onto):
        least = m_to_mm(_ABOVE)
        text = f"comes down the hole in rapid to less than {least:g} mm above what is drilled already"
        found.append(_said("hole-onto-bottom", text, run, int(j[onto[0]])))
    turns = ~cuts & (low < came - POSITION) & np.append(down[1:] & ~first[1:], False)
    turns = np.flatnonzero(turns & ~run.exact[j])
    if len(turns):
        text = (
            "out of the hole between two pecks, and there it is rounded off: it turns before it is out as far as that"
        )
        found.append(_said("peck-top-rounded", text, run, int(j[turns[0]]), severity="warning"))
    return found


def _retracted(match: Match, file: Track, story: Story, prog: Track, run: Run) -> list[Objection]:
    """The first way from a hole that isn't the one that the file says, with nothing that would need another.

    A cycle's retract height is part of what was asked for: what stands beside the holes is known to who wrote it. A way of
    its own is one on which the arm changes its posture, point to point or beneath a tool that stands still, or on which the
    file turns the tool: what that sweeps is the arm's.
    """
    way, joined, operation = story.way[file.rows], story.joined[file.rows], story.operation[file.rows]
    turned = np.linalg.norm(file.axis - file.axis_start, axis=1) > AXIS
    for i, to in match.skipped:
        if not _behind_a_hole(i, way, joined) or to > len(way):
            continue
        passed = slice(i, to)
        if not joined[passed].all() or (operation[passed] != operation[i - 1]).any() or turned[passed].any():
            continue
        rows = match.air[(match.at[match.air] <= i) & (match.at[match.air + 1] >= i)]
        still = len(rows) and np.ptp(rows) + 1 > len(rows)
        if len(rows) and not still and not run.ptp[rows].any():
            line = story.path.line[file.rows[i]]
            text = f"leaves the way from a hole that line {line} of the file says, for no change of posture"
            return [_said("retract-elsewhere", text, run, int(rows[0]))]
    return []


def _behind_a_hole(i: int, way: NDArray[np.int8], joined: NDArray[np.bool_]) -> bool:
    """Whether motion i goes on from a hole's retract, in rapid; reamers and taps come out of it at their feed."""
    k = i - 1
    while 0 <= k < len(way) - 1 and way[k] == Way.RAPID and joined[k + 1]:
        k -= 1
    rapids = i - 1 - k
    if k > 0 and way[k] == Way.FEED and way[k - 1] == Way.HOLE and joined[k]:
        k -= 1
    return rapids > 0 <= k and bool(way[k] == Way.HOLE)


def _said(code: str, text: str, run: Run, row: int, severity: str = "error") -> Objection:
    line = int(run.path.line[row])
    return Objection(code, f"line {line} of the program: {text}", line=line, file=int(run.file[row]), severity=severity)
