"""Drilling cycles: what a CYCLE statement asks for, and the moves that it stands for at each hole."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError
from camrob.findings import Severity
from camrob.toolpath.apt.lexer import Statement
from camrob.toolpath.region import EventKind, Move
from camrob.units import INCH_MM, mm_to_m

__all__ = [
    "CYCLE_KINDS",
    "FEED_WORDS",
    "Cycle",
    "Machine",
    "anchored",
    "behind_or_next",
    "changed",
    "check_words",
    "cycle_fields",
    "expand_cycle",
    "feed_of",
    "keyed_cycle",
    "peck_depths",
]

FEED_WORDS = frozenset({"MMPM", "IPM", "PERMIN", "MMPR", "IPR", "PERREV"})

CYCLE_KINDS = {
    "DRILL": "drill",
    "CSINK": "drill",
    "SPOT": "drill",
    "FACE": "drill",
    "DEEP": "peck",
    "DEEP2": "peck",
    "BRKCHP": "chip",
    "DEEP1": "chip",
    "TAP": "tap",
    "REAM": "bore",
    "BORE": "bore",
    "DRAG": "drag",
}

_PLACES = "RAPTO CLEAR FEDTO DEPTH RTRCTO RETURN DWELL STEP INCR STEP1 STEP2 STEP3 1STPECK STPECK SUBPECK"
_VALUED = frozenset(_PLACES.split()) | FEED_WORDS | {"TPI"}
_MOST_PECKS = 10_000  # of one hole: more is a peck in the wrong unit
_SLIVER = 0.01  # of a peck: what is left of less joins the one before it
_GAP_MM = 0.5  # how far above the depth reached the rapid approach of the next peck ends, and how far a chip is broken


@dataclass(frozen=True, slots=True)
class Cycle:
    """What is done at each hole, in the file's unit of length, measured along the tool axis from the GOTO's point.

    `depth` is positive into the part; `clearance` and `retract` are positive outwards (`retract` None: as `clearance`);
    `first_peck` and `peck` are 0 where there are none; `feed` is (value, unit word) or None for the modal feed. `height`:
    to which the tool goes back, in the frame of the file's points, instead of `retract`. `began` (3,) m in the part's frame: a
    point whose height that is, as where the tool stood when the cycle began (RTRCTO,AUTO), or None.
    """

    kind: str
    depth: float
    clearance: float = 0.0
    retract: float | None = None
    first_peck: float = 0.0
    peck: float = 0.0
    feed: tuple[float, str] | None = None
    dwell_s: float = 0.0
    line: int = 0
    height: float | None = None
    began: NDArray[np.float64] | None = None


def cycle_fields(args: Iterable[float | str]) -> tuple[str, dict[str, float], list[float]]:
    """The cycle's name, the values that follow minor words, and the numbers that follow none of them.

    A word with several numbers after it keeps the first; the others are positional. Words without a number get none.
    """
    name, word = "", ""
    fields: dict[str, float] = {}
    loose: list[float] = []
    for arg in args:
        if isinstance(arg, str):
            name = name or arg
            word = arg if arg != name else ""
        elif word and word not in fields:
            fields[word] = arg
            word = ""
        else:
            loose.append(arg)
    return name, fields, loose


def behind_or_next(fields: Mapping[str, float], loose: list[float], *words: str) -> float | None:
    """The value behind the first of `words` that is there, else the next loose number, which is taken; None for neither."""
    named = [fields[word] for word in words if word in fields]
    return named[0] if named else loose.pop(0) if loose else None


def check_words(s: Statement) -> None:
    """Refuse a cycle whose minor words ask for more than its name: tapping peck by peck, boring backwards or by hand, a dwell
    whose time isn't said.
    """
    if re.search(r"\bDWELL\s*(?:,\s*(?!REV\b)[A-Z]|$)", s.text, re.I):
        raise ToolpathError(f"cycle {s.text.strip()[:60]}: DWELL names no time", hint="give it in seconds", line=s.line)
    words = {token for word in s.words for token in word.split()}
    if words & {"BACK", "MANUAL", "NODRAG", "ORIENT"} or (
        "TAP" in words and words & {"DEEP", "BRKCHP", "STEP", "PECKING"}
    ):
        raise ToolpathError(
            f"cycle {s.text.strip()[:60]} is not known",
            hint="output its moves as GOTO from the CAM system",
            line=s.line,
        )


_SAME = {"CLEAR": "RAPTO", "RETURN": "RTRCTO"} | dict.fromkeys((*FEED_WORDS, "TPI"), "MMPM")


def changed(before: Statement | None, s: Statement, *, by_values: bool) -> Statement:
    """The cycle that CYCLE/ON asks for: that `before` it, with the values that it names in the place of those (NX).

    Raises ToolpathError where there is none, and for values in a dialect that doesn't give them there (not `by_values`).
    """
    if before is None:
        raise ToolpathError("CYCLE/ON without a cycle before it", hint="output the cycle with its values", line=s.line)
    if len(s.args) > 1 and not (by_values and isinstance(s.args[1], str)):
        raise ToolpathError("CYCLE/ON with values", hint="output the cycle again with all its values", line=s.line)
    groups = _groups(before.text) | {
        _SAME.get(word, word): text for word, text in _groups(s.text).items() if word != "ON"
    }
    return Statement(s.word, ",".join(groups.values()), s.line)


def _groups(text: str) -> dict[str, str]:
    """A cycle's words, each with what stands behind it; CLEAR as RAPTO and the like."""
    out: dict[str, str] = {}
    for found in re.finditer(r"([A-Z]\w*)((?:\s*,\s*(?:AUTO\b|NONE\b|REV\b|[-+.\d][^,]*))*)", text.upper()):
        out[_SAME.get(found[1], found[1])] = found[0]
    return out


def feed_of(fields: dict[str, float]) -> tuple[float, str] | None:
    """The feed among a cycle's fields, None where it names none; TPI, threads an inch, is one of a tap's."""
    if fields.get("TPI"):
        return INCH_MM / fields["TPI"], "MMPR"
    return next(((value, word) for word, value in fields.items() if word in FEED_WORDS), None)


def peck_depths(depth: float, first: float, step: float) -> NDArray[np.float64]:
    """Depths that are reached one after the other: `first`, then every `step`, at last `depth`, which is no sliver away.

    Raises ToolpathError when the pecks are too small to mean anything.
    """
    first = first or step
    if not first > 0.0 or first >= depth:
        return np.array([depth])
    if not step > 0.0 or (depth - first) / step > _MOST_PECKS:
        raise ToolpathError(f"pecks of {step:g} for a hole of {depth:g}", hint="correct the cycle's peck in the CAM")
    n = int(np.ceil((depth - first) / step - _SLIVER))
    return np.append(first + step * np.arange(n), depth)


class Machine(Protocol):
    """What a cycle's moves are written into: where the tool is (m), what its spindle does, and the file's unit of length in m."""

    position: NDArray[np.float64] | None
    position_axis: NDArray[np.float64]
    cycle: Cycle | None
    spindle: str
    turning: bool

    @property
    def scale(self) -> float:
        """Metres in the file's unit of length."""

    @property
    def rpm(self) -> float:
        """Programmed spindle speed, 0.0 where the file has stated none."""

    def cycle_feed(self, cycle: Cycle, line: int) -> float:
        """Feed (m/s) of a cycle: its own, or the modal one."""

    def to_part(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (..., 3) as the file has them, in the part's frame and in metres."""

    def find(self, code: str, text: str, line: int, severity: Severity = Severity.WARNING) -> None:
        """Note a finding."""

    def move(
        self, position: NDArray[np.float64], axis: NDArray[np.float64], move: Move, line: int, feed: float = ...
    ) -> None:
        """A motion to `position` (3,), m, with the tool along `axis`."""

    def event(self, kind: EventKind, value: float = ..., text: str = ..., line: int = ...) -> None:
        """An event at the place that was reached."""


def anchored(cycle: Cycle, s: Statement, machine: Machine) -> Cycle:
    """The cycle with `began`, where it goes back to a height: of the points' frame, or where the tool is (RTRCTO,AUTO)."""
    if cycle.height is not None:
        return replace(cycle, began=machine.to_part(np.array([0.0, 0.0, cycle.height])))
    if not re.search(r"\bRTRCTO\s*,\s*AUTO\b", s.text, re.IGNORECASE):
        return cycle
    if machine.position is None:
        hint = "output the tool's place before the cycle, or RTRCTO with a distance"
        raise ToolpathError("RTRCTO,AUTO where nobody knows the tool's place", hint=hint, line=s.line)
    return replace(cycle, began=machine.position)


def expand_cycle(machine: Machine, hole: NDArray[np.float64], axis: NDArray[np.float64], line: int) -> None:
    """The moves of the machine's open cycle at one hole: `hole` (3,) m and unit `axis` (3,) in the part's frame.

    To the hole's axis in rapid at the height where the tool is (at least the retract height), down to the clearance,
    at the feed to the depth (peck by peck), and out to the retract height.
    """
    cycle = machine.cycle
    if cycle is None:
        raise ValueError("no cycle is open")
    unit = machine.scale
    depth, clear = cycle.depth * unit, cycle.clearance * unit
    out = max(clear, clear if cycle.retract is None else cycle.retract * unit)
    if cycle.began is not None:
        out = max(clear, float((cycle.began - hole) @ axis))
    if out < 0.0:
        hint = "output RTRCTO above the hole's point, or the moves as GOTO"
        raise ToolpathError("a cycle goes across in rapid below its holes' points", hint=hint, line=cycle.line)
    feed = machine.cycle_feed(cycle, line)
    _approach(machine, hole, axis, out, line)
    _rapid(machine, hole + axis * clear, axis, line)
    if cycle.kind == "tap":
        _tap(machine, hole, axis, cycle, feed, line)
    elif cycle.kind in ("peck", "chip"):
        _pecks(machine, hole, axis, cycle, feed, line)
    else:
        machine.move(hole - axis * depth, axis, Move.CUT, line, feed)
        _dwell(machine, cycle, line)
        if cycle.kind == "bore":
            machine.move(hole + axis * clear, axis, Move.CUT, line, feed)
    dragged = cycle.kind == "drag" and machine.turning
    if dragged:
        machine.event(EventKind.SPINDLE_OFF, 0.0, "", line)
    _rapid(machine, hole + axis * out, axis, line)
    if dragged:
        machine.event(EventKind.SPINDLE_ON, machine.rpm, machine.spindle or "CLW", line)


def _approach(machine: Machine, hole: NDArray[np.float64], axis: NDArray[np.float64], out: float, line: int) -> None:
    """In rapid to the hole's axis: first up to the retract height where the tool stands lower, then across."""
    here = machine.position
    if here is None or float(machine.position_axis @ axis) < 0.999:
        _rapid(machine, hole + axis * out, axis, line)
        return
    height = float((here - hole) @ axis)
    if height < out - 1e-9:
        _rapid(machine, here + axis * (out - height), axis, line)
        height = out
    _rapid(machine, hole + axis * height, axis, line)
    if height > out + 1e-9:
        _rapid(machine, hole + axis * out, axis, line)


def _rapid(machine: Machine, point: NDArray[np.float64], axis: NDArray[np.float64], line: int) -> None:
    """In rapid to the point, unless the tool stands there already."""
    here = machine.position
    if here is None or np.max(np.abs(here - point)) > 1e-12 or np.max(np.abs(machine.position_axis - axis)) > 1e-12:
        machine.move(point, axis, Move.RAPID, line)


def _dwell(machine: Machine, cycle: Cycle, line: int) -> None:
    if cycle.dwell_s > 0.0:
        machine.event(EventKind.DWELL, cycle.dwell_s, "", line)


def _pecks(
    machine: Machine, hole: NDArray[np.float64], axis: NDArray[np.float64], cycle: Cycle, feed: float, line: int
) -> None:
    """Peck by peck: out to the clearance after each (deep), or back a little (chip breaking)."""
    unit, gap = machine.scale, mm_to_m(_GAP_MM)
    clear = hole + axis * (cycle.clearance * unit)
    depths = peck_depths(cycle.depth, cycle.first_peck, cycle.peck) * unit
    for n, depth in enumerate(depths):
        machine.move(hole - axis * depth, axis, Move.CUT, line, feed)
        if n + 1 == len(depths):  # the dwell is the bottom's
            _dwell(machine, cycle, line)
            return
        above = hole - axis * (depth - gap)
        if cycle.kind == "peck":
            machine.move(clear, axis, Move.RAPID, line)
        machine.move(above, axis, Move.RAPID, line)


def _tap(
    machine: Machine, hole: NDArray[np.float64], axis: NDArray[np.float64], cycle: Cycle, feed: float, line: int
) -> None:
    """In at the feed, the spindle reversed, out at the feed, the spindle forward again; its sense is that of SPINDL."""
    if not machine.turning:
        raise ToolpathError("tapping while the spindle stands", hint="put SPINDL before the cycle", line=line)
    machine.find(
        "tap-cycle",
        "tapping is written as feed in, spindle reversed, feed out: the robot's feed is not coupled to its spindle, "
        "so a floating tap holder is needed",
        line,
    )
    machine.move(hole - axis * (cycle.depth * machine.scale), axis, Move.CUT, line, feed)
    _dwell(machine, cycle, line)
    back = "CLW" if machine.spindle == "CCLW" else "CCLW"
    machine.event(EventKind.SPINDLE_ON, machine.rpm, back, line)
    machine.move(hole + axis * (cycle.clearance * machine.scale), axis, Move.CUT, line, feed)
    machine.event(EventKind.SPINDLE_ON, machine.rpm, machine.spindle or "CLW", line)


def _all_known(name: str, fields: dict[str, float], loose: Sequence[float], line: int) -> None:
    """Refuse a number that may mean motion, and whose meaning is not known: of another dialect, or of a cycle of its own."""
    strange = [f"{word},{value:g}" for word, value in fields.items() if word not in _VALUED] + [f"{v:g}" for v in loose]
    if strange:
        hint = "output the cycle's moves as GOTO from the CAM system, or force the dialect that it is of"
        raise ToolpathError(f"cycle {name}: what {strange[0]} means is not known in this dialect", hint=hint, line=line)


def _named_pecks(fields: dict[str, float]) -> tuple[float, float]:
    """The first peck and the others, in the file's unit, 0 where it names none; of several steps the shortest."""
    first = abs(fields.get("1STPECK", fields.get("STPECK", 0.0)))
    peck = abs(fields.get("SUBPECK", fields.get("STEP", fields.get("INCR", 0.0))))
    steps = [abs(fields[word]) for word in ("STEP1", "STEP2", "STEP3") if fields.get(word)]
    return first, peck or min(steps, default=first)


def keyed_cycle(
    name: str, fields: dict[str, float], depth: float | None, line: int, loose: Sequence[float] = ()
) -> Cycle:
    """A cycle whose values stand behind words (RAPTO or CLEAR, RTRCTO or RETURN, STEP, DWELL, ...).

    A file that names a peck wants pecks, whatever the drilling cycle is called. `loose`: numbers to which the dialect gives no
    meaning. Raises ToolpathError for a cycle of another kind than drilling, tapping and boring, one without a depth (None), one
    with a number whose meaning is not known, or boring peck by peck.
    """
    kind = CYCLE_KINDS.get(name)
    if kind is not None:
        _all_known(name, fields, loose, line)
        if depth is None:
            hint = "output it again with its depth, or its moves as GOTO"
            raise ToolpathError(f"cycle {name} names no depth that this dialect knows", hint=hint, line=line)
    if "TPI" in fields and kind != "tap":
        raise ToolpathError(f"cycle {name} with TPI, a thread's pitch", hint="output its feed", line=line)
    first, peck = _named_pecks(fields)
    if kind == "drill" and (first or peck):
        kind = "peck"
    elif kind in ("bore", "drag") and (first or peck):
        what = f"cycle {name} peck by peck is not known"
        raise ToolpathError(what, hint="output its moves as GOTO from the CAM system", line=line)
    if kind is None:
        raise ToolpathError(
            f"cycle {name or '(no name)'} is not known", hint="output its moves as GOTO from the CAM system", line=line
        )
    if depth is None or not depth >= 0.0:
        raise ToolpathError(f"cycle {name} has a depth of {depth:g}, out of the part", hint="correct it", line=line)
    retract = fields.get("RTRCTO", fields.get("RETURN"))
    return Cycle(
        kind=kind,
        depth=depth,
        clearance=fields.get("RAPTO", fields.get("CLEAR", 0.0)),
        retract=retract,
        first_peck=first,
        peck=peck,
        feed=feed_of(fields),
        dwell_s=fields.get("DWELL", 0.0),
        line=line,
    )
