"""The judge of a released program: held to its job's story, to the arm and the cell as published, and to nothing of camrob."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mutation import arm
from mutation.bodies import Bodies
from mutation.events import Process, Token, differ, tokens
from mutation.krl import Statement, UnreadableError, read
from mutation.near import off_pose
from mutation.replay import Machine, Move, Replay
from mutation.shops import plain
from mutation.story import Span, Story
from mutation.whereabouts import TIP_MM, Whereabouts

Array = NDArray[np.float64]

FEED_STEP = 0.05  # mm/min: half of the last digit of $VEL.CP, and some
PRINTED_MM = 0.0009  # the least step that is printed, and some
RUSH = 1.2  # times an axis's speed: a cut that asks for more is run more slowly than the file says


UNSTATED_RAPID = 30_000.0  # mm/min: where the set-up states none, what a robot of this size does in air


@dataclass(frozen=True)
class Rules:
    """What a job's program is held to.

    rapid: mm/min in air, at most. slower: a feed below the file's may come out, said in the JSON.
    """

    story: Story
    machine: Machine
    bodies: Bodies
    rapid: float = UNSTATED_RAPID
    slower: bool = False
    decimate: float = 0.0


@dataclass
class Verdict:
    """faults: (class, text), none for a program that does what the file says. The rest describes it for comparisons."""

    faults: list[tuple[str, str]] = field(default_factory=list)
    cut: list[tuple[float, ...]] = field(default_factory=list)
    air: list[tuple[float, ...]] = field(default_factory=list)
    posture: list[tuple[float, ...]] = field(default_factory=list)
    turns: list[tuple[int, int]] = field(default_factory=list)
    printed: list[tuple[float, ...]] = field(default_factory=list)
    rounded: list[bool] = field(default_factory=list)
    speeds: list[float] = field(default_factory=list)
    rush: float = 0.0
    name: str = ""
    air_speeds: list[float] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)


def _in_order(lines: Sequence[str]) -> list[str]:
    """The opening's lines; settings in a row act alike in any order, so long as no two of them are of the same variable."""
    out: list[str] = []
    row: list[str] = []
    for line in [*lines, ""]:
        if line.startswith("$"):
            row.append(line)
            continue
        out += sorted(row) if len({text.partition("=")[0] for text in row}) == len(row) else row
        row = []
        out.append(line)
    return out


def judge(files: Mapping[str, bytes], name: str, rules: Rules, *, known: Verdict | None = None) -> Verdict:
    """Everything that is wrong with a program, by class. known: of a program that was right: its postures touch nothing."""
    verdict = Verdict()
    data = [file.removesuffix(".dat") for file in files if file.endswith(".dat")]
    if f"{name}.src" not in files and len(data) == 1:
        name = verdict.name = data[0]  # called otherwise: that is no harm
    try:
        _Judge(rules, verdict).run(read(plain(files, rules.machine.shop), name), known)
    except UnreadableError as error:
        verdict.faults.append(("text", str(error)))
    return verdict


class _Judge(Whereabouts):
    """One program, followed along its story."""

    def __init__(self, rules: Rules, verdict: Verdict) -> None:
        super().__init__(rules.story, rules.decimate)
        self.rules, self.verdict = rules, verdict
        self.replay = Replay(rules.machine, rules.story.tools, rules.story.tool)
        self.gaps: dict[int, list[Token]] = {}
        self.do = dict(rules.story.do)
        self.moves: list[Move] = []
        self.cutting: list[bool] = []
        self.state = Process()
        self.last: Statement | None = None

    def fault(self, kind: str, text: str) -> None:
        self.verdict.faults.append((kind, text))

    def run(self, statements: list[Statement], known: Verdict | None) -> None:
        """The whole program. Raises UnreadableError."""
        opening = next((k for k, s in enumerate(statements) if s.moves), len(statements))
        self._opening([s for s in statements[:opening] if s.kind != "comment"])
        self.verdict.texts = [s.text for s in statements if s.kind == "comment"]
        between: list[Statement] = []
        for s in statements[opening:]:
            if s.moves:
                self._events(between)
                between = []
                self._move(s)
            elif s.kind == "frame":
                self._events(between)
                between = []
                self.replay.frame_set(s)
            elif s.kind == "other":
                between.append(s)
        self._events(between)
        self._ending()
        self.verdict.faults += self.replay.faults
        self.verdict.turns = self.replay.turn_values
        same = known is not None and (known.posture, known.cut) == (self.verdict.posture, self.verdict.cut)
        if not same and not self.verdict.faults:
            self.verdict.faults += self.rules.bodies.touching(self.moves, self.cutting, self.story)

    # -- what happens between motions ---------------------------------------------------------------------------

    def _opening(self, statements: list[Statement]) -> None:
        lines = [s.text for s in statements if s.kind != "frame"]
        if _in_order(lines) != _in_order(self.rules.machine.lines):
            odd = sorted(set(lines) ^ set(self.rules.machine.lines))
            self.fault("setting", f"the opening has {odd or 'another order'}")
        frames = [s for s in statements if s.kind == "frame"]
        if [s.text[:5] for s in frames] != ["$BASE", "$TOOL"]:
            self.fault("$BASE", "the opening sets other frames than $BASE and $TOOL")
        for s in frames:
            self.replay.frame_set(s)
        if self.replay.tool != self.story.tool:
            self.fault("$TOOL", "the opening sets another tool's $TOOL")

    def _events(self, statements: list[Statement]) -> None:
        found = tokens(statements)
        if not found:
            return
        whole = self.u == round(self.u)
        for token in found:
            if token[0] == "change" and not self._in_the_clear():
                self.fault("event", f"a tool change in the part, point {self.u:g}")
            if token[0] in ("cw", "ccw") and self.linking and not self._in_the_clear():
                self.fault("event", f"the spindle starts off the path and not in the clear, point {self.u:g}")
        if not whole:
            self.fault("event", f"events {found} in the middle of a motion of the file's, {self.u:.3f}")
        self.gaps.setdefault(int(np.ceil(self.u)) + 1, []).extend(found)

    def _in_the_clear(self) -> bool:
        if self.replay.axes is None:
            return False
        here = self.moves[-1].base_T_tip[-1:]
        home = np.abs(self.replay.axes[:6] - arm.HOME[:6]).max() < 1e-3
        return bool(home or self._clear(here)[0])

    def _ending(self) -> None:
        n = len(self.story)
        self._left_in_the_air()
        if self.u != n - 1:
            self.fault("tip", f"the program ends at point {self.u:.2f} of {n - 1}")
        axes = self.replay.axes
        home = arm.HOME
        if axes is None or not self.moves[-1].ptp or np.abs(axes[:7] - home[:7]).max() > 1e-3 or axes[7] % 360.0 > 1e-3:
            self.fault("ending", "the program does not end at HOME")
        first = self.moves[0].axes[-1]
        if self.moves[0].at.kind != "ptp-axes" or np.abs(first - home).max() > 1e-3:
            self.fault("ending", "the program does not begin at HOME")
        if self.gaps.get(0, [])[:1] == [("change", 0.0)]:
            del self.gaps[0][0]  # a halt for the tool that the file begins with, and has no number for
        last = self.gaps.get(n, [])
        if last[-2:] != [("end-off", 0.0), ("end-dry", 0.0)]:
            self.fault("event", f"the program ends with {last}, not with spindle and coolant off")
        self.gaps[n] = self._by_footer(n, last[:-2])
        for gap in range(n + 1):
            said = differ(self.do.get(gap, []), self.gaps.pop(gap, []), self.state)
            if said:
                self.fault("event", f"before point {gap}: {said}")
                return
        if any(self.gaps.values()):
            self.fault("event", f"events in no place: {self.gaps}")

    def _left_in_the_air(self) -> None:
        """Rapids behind the file's last cut may be left out; what happens between them happens at the end."""
        n, k = len(self.story), int(np.floor(self.u))
        if self.u != k or any(span.feed is not None for span in self.story.spans[k + 1 :]):
            return
        self._together(range(k + 1, n + 1), n)
        self.u = float(n - 1)

    def _together(self, gaps: range, at: int) -> None:
        """Between rapids that were left out there is one place for all that happens."""
        for events in (self.do, self.gaps):
            events[at] = [token for gap in gaps for token in events.pop(gap, [])]

    def _by_footer(self, gap: int, found: list[Token]) -> list[Token]:
        """The last events, with what the program's last lines do of the file's; which of spindle and coolant goes off first there
        is all one.
        """
        wanted = self.do.get(gap, [])
        same = next(
            (k for k, (a, b) in enumerate(zip(wanted, found, strict=False)) if a != b), min(len(wanted), len(found))
        )
        begun, wanted, found = wanted[:same], wanted[same:], found[same:]
        left = [token for token in wanted if token not in found]
        if {kind for kind, _ in [*left, *found]} <= {"off", "dry"}:
            return begun + (wanted if {*found, *left} == set(wanted) else [*found, *left])
        return begun + found

    # -- motions ------------------------------------------------------------------------------------------------

    def _move(self, s: Statement) -> None:
        move = self.replay.move(s)
        previous, self.last = self.last, s
        kind_before = self.cutting[-1] if self.cutting else None
        self.moves.append(move)
        goal = None if move.ptp and not move.still and not self._from_air() else self._located(move)
        if goal is not None and move.ptp and not move.still:
            goal = self._landed(move, goal)
        if goal is None:
            cuts = self._link(move)
        else:
            cuts = self._along(move, goal)
        self.cutting.append(cuts)
        if previous is not None and previous.rounded and kind_before is not None and kind_before != cuts:
            self.fault("rounding", f"C_DIS between a cut and the air at {previous.place}")
        self._describe(move, cuts)

    def _from_air(self) -> bool:
        return self.u == -1.0 or self.linking

    def _along(self, move: Move, goal: float) -> bool:
        """The motion runs along the story to `goal`: its speed is the file's. True where it cuts."""
        before, self.u = self.u, goal
        came = self.linking
        self.linking = False
        at, spans = max(int(np.ceil(goal)), 0), self.story.spans
        wanted = spans[at].tool
        next_tool = (
            came and goal == before and spans[at].feed is None and move.tool == spans[min(at + 1, len(spans) - 1)].tool
        )
        if wanted and move.tool != wanted and not next_tool:  # which may come to where the last one was left in the air
            self.fault("$TOOL", f"that of tool {move.tool} for tool {wanted} at {move.at.place}")
        if move.ptp and not came:
            self._in_air(move)
            return False
        if came and goal > np.floor(before) + 1:
            self._together(range(int(np.floor(before)) + 1, int(goal) + 1), int(goal))
        feed = self.story.spans[int(goal)].feed
        if came and goal > np.floor(before) + 1 and feed is not None:
            self._feed(move, feed)
            return True
        if goal == before or came:
            if came:
                self._in_air(move)
                self._clear_link(move, goal)
            elif self._ends_a_row(move) or (self._in_cut(before) and self._moves(move)):
                # by less than the way along a curve can be told, or than a point is wide
                self._feed(move, self.story.spans[int(np.ceil(before))].feed or 0.0)
                return True
            elif self._in_cut(before):
                self.fault("feed", f"the tool stands in the cut at {move.at.place}")
            return False
        spans = self.story.spans[int(np.floor(before)) + 1 : int(np.ceil(goal)) + 1]
        kinds = {
            s.feed is None for s in spans if float(np.linalg.norm(s.place(1.0) - s.place(0.0))) > 1e-9 or s.turning
        }
        if len(kinds) > 1 and move.at.speed is not None and self._overlap(spans, goal, move):
            return False
        if kinds == {True}:
            self._in_air(move)
            return False
        self._feed(move, min(s.feed for s in spans if s.feed is not None))
        return True

    def _overlap(self, spans: Sequence[Span], goal: float, move: Move) -> bool:
        """A rapid back into a hole may go as far as it has been cut; at the cut's feed the way there may be gone, too."""
        last = spans[-1]
        inside = (1.0 - (np.ceil(goal) - goal)) * float(np.linalg.norm(last.place(1.0) - last.place(0.0)))
        again = all(s.feed is None for s in spans[:-1]) and last.feed is not None and 0.0 < inside <= last.open + TIP_MM
        speed = (move.at.speed or 0.0) * 60_000.0
        slow = speed <= min(s.feed for s in spans if s.feed is not None) + FEED_STEP
        if again and not slow:
            self._in_air(move)
            return True
        return False

    def _ends_a_row(self, move: Move) -> bool:
        """The last of ever so short steps of a cut, within the tolerance about the point that the one before came to."""
        length = float(np.linalg.norm(move.base_T_tip[-1, :3, 3] - move.base_T_tip[0, :3, 3]))
        return bool(self.cutting) and self.cutting[-1] and 0.0 < length <= TIP_MM

    @staticmethod
    def _moves(move: Move) -> bool:
        return float(np.linalg.norm(move.base_T_tip[-1, :3, 3] - move.base_T_tip[0, :3, 3])) >= PRINTED_MM

    def _in_cut(self, at: float) -> bool:
        """The tool is in the cut, coming and going."""
        k = int(np.ceil(at))
        if k != at:
            return self.story.spans[k].feed is not None
        ahead = self.story.spans[k + 1].feed if k + 1 < len(self.story) else None
        return k >= 0 and self.story.spans[k].feed is not None and ahead is not None

    def _feed(self, move: Move, feed: float) -> None:
        speed = None if move.at.speed is None else move.at.speed * 60_000.0
        if speed is None or move.ptp:
            self.fault("feed", f"a cut without a feed at {move.at.place}")
        elif speed > feed + FEED_STEP:
            self.fault("feed", f"{speed:.2f} for {feed:g} mm/min at {move.at.place}")
        elif speed < feed - FEED_STEP and not self.rules.slower:
            self.fault("feed", f"{speed:.2f} for {feed:g} mm/min, no reason said, at {move.at.place}")
        self.verdict.speeds.append(speed or 0.0)
        length = float(np.linalg.norm(np.diff(move.base_T_tip[:, :3, 3], axis=0), axis=1).sum())
        if length > 0.5 and speed:
            used = np.abs(np.diff(move.axes, axis=0)).max(axis=0) / (length / (len(move.axes) - 1) / speed * 60.0)
            self.verdict.rush = max(self.verdict.rush, float((used / arm.SPEED).max()))

    def _in_air(self, move: Move) -> None:
        speed = None if move.at.speed is None else move.at.speed * 60_000.0
        if move.ptp:
            self._clear_link(move, self.u)
        elif speed is None or speed > self.rules.rapid + FEED_STEP:
            self.fault("rapid", f"{speed} mm/min in air at {move.at.place}")
        self.verdict.air_speeds.append(speed or 0.0)

    def _link(self, move: Move) -> bool:
        """A motion of camrob's own: in the clear, or along the tool's axis off the file's points."""
        if self._past_a_rapid(move):
            self.u = float(np.ceil(self.u))
        k = int(np.floor(self.u))
        free = self.u == k and (k < 0 or k + 1 >= len(self.story) or self.story.spans[k + 1].feed is None)
        if not free:
            end = move.base_T_tip[-1]
            off = min((off_pose(end, self.story, j) for j in range(max(k, 0), min(k + 4, len(self.story)))), default=0)
            self.fault("tip" if off > TIP_MM else "axis", f"off the file's path by {off:.3f} mm at {move.at.place}")
            self.linking = True
            self.u = float(min(k + 1, len(self.story) - 1))
            return False
        self.linking = True
        if not move.ptp:
            self._in_air(move)
        self._clear_link(move, self.u)
        return False

    def _clear_link(self, move: Move, at: float) -> None:
        """A rapid through what the file has not cleared is a fault; the file's own, from point to point, is none."""
        k = int(np.floor(self.u))
        if 0 <= k < len(self.story) - 1 and self.story.spans[k + 1].feed is None and not move.ptp:
            ends = zip((0, -1), (k, k + 1), strict=True)
            if all(off_pose(move.base_T_tip[end], self.story, point) <= TIP_MM for end, point in ends):
                return
        ok = self._clear(move.base_T_tip)
        for point in (k - 1, k, k + 1):
            if 0 <= point < len(self.story):
                ok |= self._above(move.base_T_tip, point)
        if not ok.all():
            self.fault("rapid", f"through what was not cleared, on the way to {move.at.place} ({at:g})")

    def _describe(self, move: Move, cuts: bool) -> None:
        end = move.base_T_tip[-1]
        row = (*end[:3, 3].round(3), *end[:3, 2].round(5))
        (self.verdict.cut if cuts else self.verdict.air).append(row)
        self.verdict.posture.append(tuple(move.axes[-1].round(3)))
        self.verdict.rounded.append(move.at.rounded)
        self.verdict.printed.append(tuple(v for k, v in move.at.target.items() if k not in "ST"))
