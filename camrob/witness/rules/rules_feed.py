"""The rule of the feed: a cut as fast as the file says and no other way, rapid no faster than the set-up allows, no rounding
from the one into the other, and no axis asked for more than it can.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from camrob.witness.happenings import Objection, Run, Story, Way
from camrob.witness.rules.rules_along import MOVED
from camrob.witness.rules.rules_path import Match
from camrob.witness.units import m_s_to_mm_min

__all__ = ["axis_speed_objections", "feed_objections"]

Array = NDArray[np.float64]
Rows = NDArray[np.int64]
_FASTEST = 3.0  # m/s: the most that KUKA's $VEL.CP takes
_AXES, _IN_AIR = 1.05, 4.0  # times an axis's own speed: in a cut, and where the controller may brake
_SHORT = 1e-5  # m: of less the rounding of axis values says nothing
_PRINTED = 6e-7  # m/s: half the last of six decimals, and a little


def feed_objections(match: Match, story: Story, run: Run, rapid: float | None, slower_allowed: str) -> list[Objection]:
    """The rule of the feed over matched stories. rapid: m/s, None where the set-up names none; slower_allowed: the reason why
    cuts may be slower than the file says, "" where there is none.
    """
    return list(_all(match, story, run, rapid, slower_allowed))


def _all(match: Match, story: Story, run: Run, rapid: float | None, slower_allowed: str) -> Iterator[Objection]:
    moves = np.flatnonzero(~run.ptp & np.isnan(run.speed))
    if len(moves):
        yield _said("no-speed", "no speed is set before this motion", moves, None, story, run)
    beyond = np.flatnonzero(run.speed > _FASTEST + _PRINTED)
    if len(beyond):
        limit = np.full(len(beyond), _FASTEST)
        text = "faster than any controller runs a line"
        yield _said("speed-limit", text, beyond, None, story, run, run.speed[beyond], limit)
    j, i = match.pairs[:, 0], match.pairs[:, 1]
    cut = _cuts(match, story)
    feed, speed = _meant(match, story), run.speed[j]
    silent = np.flatnonzero(cut & np.isnan(feed))
    step = story.path.tip[i[silent]] - story.path.tip[np.maximum(i[silent] - 1, 0)]
    silent = silent[(np.linalg.norm(step, axis=1) > MOVED) | (i[silent] == 0)]  # a turn on the spot has no speed
    if len(silent):
        yield _said("no-feed", "the file states no feed for this cut", j[silent], i[silent], story, run)
    fast = np.flatnonzero(cut & (speed > feed + _PRINTED))
    if len(fast):
        yield _said("feed-higher", "faster than the file's feed", j[fast], i[fast], story, run, speed[fast], feed[fast])
    slow = np.flatnonzero(cut & (speed < feed - _PRINTED))
    if len(slow) and not slower_allowed:
        text = "slower than the file's feed, for no reason that is given"
        yield _said("feed-lower", text, j[slow], i[slow], story, run, speed[slow], feed[slow])
    cutting = np.zeros(len(run), dtype=bool)
    cutting[j[cut]] = True
    border = (cutting[:-1] != cutting[1:]) & ~run.exact[:-1] & np.isfinite(match.at[1:-1])
    entry = np.zeros(len(run), dtype=bool)
    entry[match.entries[:, 0]] = True
    border &= ~(entry[:-1] & cutting[1:])  # into the part at the cut's feed, and on: that is no corner of the cut's
    border &= ~(match.unjudged[:-2] | match.unjudged[1:-1])  # what is cut in a gap of the file is not known
    round_off = np.flatnonzero(border)
    if len(round_off):
        text = "its end is rounded off, and there a cut begins or ends"
        yield _said("rounded-cut", text, round_off, None, story, run)
    k, row = match.entries[:, 0], match.entries[:, 1]
    into = np.flatnonzero(run.speed[k] > story.feed[row] + _PRINTED)
    if len(into):
        text = "goes back into the part faster than the file's feed"
        yield _said("entry-faster", text, k[into], row[into], story, run, run.speed[k[into]], story.feed[row[into]])
    strokes = j[(story.way[i] == Way.HOLE) & ~match.cuts]  # out of a hole at a feed of the file's own
    back = np.flatnonzero(np.isin(k, strokes) & (run.speed[k] < story.feed[row] - _PRINTED))
    if len(back) and not slower_allowed:
        text = "comes out of the hole slower than the file's feed, for no reason that is given"
        yield _said("feed-lower", text, k[back], row[back], story, run, run.speed[k[back]], story.feed[row[back]])
    if rapid is not None:
        rows = np.concatenate([j[~cut], match.air])
        # out of a hole at a feed of the file's own: `entry-faster` and `feed-lower` hold it to that
        own = np.isin(k, strokes) & np.isfinite(story.feed[row])
        rows = rows[(run.speed[rows] > rapid + _PRINTED) & ~np.isin(rows, k[own])]
        if len(rows):
            limit = np.full(len(rows), rapid)
            text = "faster than the set-up's rapid feed, or the usual one where it names none"
            yield _said("rapid-higher", text, rows, None, story, run, run.speed[rows], limit)


def _meant(match: Match, story: Story) -> Array:
    """The file's feed for each matched pair, m/s: of a hole's first peck, where that has another, till the tool is drawn back."""
    j, i = match.pairs[:, 0], match.pairs[:, 1]
    feed = story.feed[i].copy()
    for row, pecks in story.pecks.items():
        if pecks.entry is None:
            continue
        mine = np.flatnonzero(i == row)
        mine = mine[np.argsort(j[mine], kind="stable")]
        feed[mine[: np.append(np.flatnonzero(~match.cuts[mine]), len(mine))[0]]] = pecks.entry
    return feed


def _cuts(match: Match, story: Story) -> NDArray[np.bool_]:
    """Which matched pairs are cuts."""
    way = story.way[match.pairs[:, 1]]
    return np.asarray((way == Way.FEED) | ((way == Way.HOLE) & match.cuts))


def axis_speed_objections(
    match: Match, story: Story, run: Run, most: Array, sliding: frozenset[str]
) -> Iterator[Objection]:
    """An axis that would have to run faster than it can for the tip to keep its speed: in a cut the feed is not held, and a
    table that turns many times too fast for its way is none that was meant. most: (n,) degrees a second, mm of the
    axes that slide.
    """
    step = np.linalg.norm(np.diff(run.path.tip, axis=0, prepend=np.nan), axis=1)
    radius = np.linalg.norm(run.path.tip - run.path.center, axis=1)
    length = np.where(np.isnan(run.path.angle), step, radius * np.nan_to_num(run.path.angle))
    with np.errstate(invalid="ignore", divide="ignore"):
        pace = run.speed / length
    still = run.ptp | ~(length > _SHORT)
    allowed = np.full(len(run), _IN_AIR)
    allowed[match.pairs[_cuts(match, story), 0]] = _AXES
    for k, name in enumerate(run.axis_names):  # one at a time, for a long program's memory
        turned = np.abs(np.diff(run.axes[:, k], prepend=np.nan))
        with np.errstate(invalid="ignore", divide="ignore"):
            share = turned / most[k] * pace
        share[still] = 0.0
        share = np.nan_to_num(share, posinf=0.0)
        rows = np.flatnonzero(share > allowed)
        if len(rows):
            worst = int(rows[np.argmax(share[rows])])
            line, needed = int(run.path.line[worst]), float(share[worst] * most[k])
            unit = "mm" if name in sliding else "degrees"
            text = (
                f"line {line} of the program: {name} would have to run at {needed:.4g} {unit} a second, "
                f"and runs at {most[k]:.4g} at the most"
            )
            yield Objection(
                "axis-speed",
                text,
                line=line,
                file=int(run.file[worst]),
                axis=name,
                value=needed,
                limit=float(most[k]),
                unit=f"{unit}/s",
            )


def _said(
    code: str,
    text: str,
    rows: Rows,
    file: Rows | None,
    story: Story,
    run: Run,
    speed: Array | None = None,
    limit: Array | None = None,
) -> Objection:
    """One objection for all motions of a kind: the worst of them, and how many they are."""
    worst = 0 if speed is None or limit is None else int(np.argmax(np.abs(np.log(np.maximum(speed, 1e-12) / limit))))
    many = "" if len(rows) == 1 else f"; the worst of {len(rows)} motions, the first is line {run.path.line[rows[0]]}"
    asked = ""
    if speed is not None and limit is not None:
        asked = f": {m_s_to_mm_min(float(speed[worst])):.1f} mm/min, where {m_s_to_mm_min(float(limit[worst])):.1f} are meant"
    return Objection(
        code,
        f"line {run.path.line[rows[worst]]} of the program: {text}{asked}{many}",
        cl_line=0 if file is None else int(story.path.line[file[worst]]),
        line=int(run.path.line[rows[worst]]),
        file=int(run.file[rows[worst]]),
        value=None if speed is None else m_s_to_mm_min(float(speed[worst])),
        limit=None if limit is None else m_s_to_mm_min(float(limit[worst])),
        unit="" if speed is None else "mm/min",
    )
