"""What the controller knows at a statement of a program, and what the witness has noted so far."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.witness.frames import frame, inverse, to_values
from camrob.witness.happenings import Event, Gap, Load, Objection
from camrob.witness.krl.columns import LIN, Columns, Motions
from camrob.witness.krl.conduct import Conduct
from camrob.witness.krl.hooks import Hooks, Step, canonical
from camrob.witness.krl.text import POSE, Line
from camrob.witness.krl.values import UnknownError, Value, Variables
from camrob.witness.machine import Machine

__all__ = ["Base", "EndlessError", "Here", "LostError", "State"]

Array = NDArray[np.float64]

# what a run may take besides what is written, which it may take _AGAIN times: an endless loop takes more
_MOST, _MOST_MOTIONS, _AGAIN = 120_000, 60_000, 10
_MOST_STEPS = 2_000  # between two motions: a hook holds some ten
_FEW = 50  # objections of a run without an end
_ENOUGH = 2_000  # motions of a run without an end that are looked at
_ZERO = (0.0,) * 6
_LOAD = ("M", *(f"CM.{part}" for part in "XYZABC"), "J.X", "J.Y", "J.Z")


class LostError(Exception):
    """The run can't be followed any further."""


class EndlessError(LostError):
    """The run takes more than any honest program."""


@dataclass(frozen=True, slots=True)
class Base:
    """A `$BASE`: X..C in mm and degrees, None where the text doesn't say; on the turning table, or fixed in the world."""

    values: tuple[float, ...] | None
    follows: bool
    fault: Objection | None = None  # what is wrong with it, once a pose is read in it
    doubt: str = ""  # what isn't known of it, likewise

    def same(self, other: Base) -> bool:
        """True where nothing is different: of the same fault the first is reported."""
        same = (self.values, self.follows, self.doubt) == (other.values, other.follows, other.doubt)
        same &= self.values is not None
        return same and (self.fault and self.fault.code) == (other.fault and other.fault.code)


@dataclass(slots=True)
class Here:
    """Where the robot has been sent last: a pose in a base with a tool, or axes; nothing where that isn't known."""

    pose: list[float] | None = None
    axes: list[float] | None = None
    base: int = 0
    tool: int = 0


@dataclass(slots=True)
class State:
    """The run so far. Frames, speed and the like are those in force; `external` the external axes, by KRL's number."""

    machine: Machine
    hooks: Hooks
    columns: Columns = field(init=False)
    conduct: Conduct = field(init=False)
    variables: Variables = field(default_factory=Variables)
    files: list[str] = field(default_factory=list)
    file: int = 0
    bases: list[Base] = field(default_factory=lambda: [Base(None, False)])
    tools: list[tuple[float, ...] | None] = field(default_factory=lambda: [None])
    base: int = 0
    tool: int = 0
    speed: float = float("nan")
    constant: bool = False
    unlike_line: str = ""  # why the tool doesn't turn along a LIN or CIRC as on a line; "" where it does
    unlike_arc: str = ""
    rounds: bool = True  # False: $ADVANCE = 0
    quarters: bool = (
        False  # True: a motion's turn packs the quarters of axes 1, 4 and 6, four bits each from -8, not signs
    )
    external: list[float] = field(init=False)
    here: Here = field(default_factory=Here)
    steps: list[Step] = field(default_factory=list)
    after_next: list[Step] = field(default_factory=list)
    stops: list[int] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    gaps: list[Gap] = field(default_factory=list)
    objections: list[Objection] = field(default_factory=list)
    ruled: list[Objection] = field(default_factory=list)  # of how it moves besides: see `conduct`
    unsettled: list[Gap] = field(default_factory=list)
    loads: list[Load] = field(default_factory=list)
    vague: list[tuple[int, int, int]] = field(default_factory=list)  # motion, line, file of roundings of unknown size
    signals: dict[str, str] = field(default_factory=dict)
    interrupts: dict[str, tuple[str, str]] = field(default_factory=dict)
    reset: list[str] = field(default_factory=list)  # frames that BAS(#INITMOV) has put back since they were set
    owed: dict[str, tuple[Line, str]] = field(default_factory=dict)  # frames by a row of a table that isn't at hand
    early: Line | None = None  # a CONTINUE: the next statement doesn't wait for the robot
    quiet: int = 0  # within a routine that a hook stands for
    taken: int = 0  # statements so far
    written: int = 0  # lines of the files read
    line: int = 0  # of the statement at work

    def __post_init__(self) -> None:
        self.columns = Columns(len(self.machine.axis_names))
        self.conduct = Conduct(self.machine.controller)
        self.external = [float(value) for value in self.machine.home[6:]]
        for name in ("$NULLFRAME", "$WORLD"):
            self.variables.common[name] = dict(zip("XYZABC", _ZERO, strict=True))
        self.variables.asked = {
            "$POS_ACT": partial(self._stands, axes=False),
            "$AXIS_ACT": partial(self._stands, axes=True),
        }

    @property
    def count(self) -> int:
        """Motions so far."""
        return self.columns.count

    def add_lines(
        self,
        pose: NDArray[np.float64],
        axes: NDArray[np.float64],
        speed: NDArray[np.float64],
        exact: NDArray[np.bool_],
        lines: NDArray[np.int64],
    ) -> None:
        """Adds K straight motions with the frames in force.

        pose: (K, 6) as written; axes: (K, n), NaN for what isn't said; speed: (K,) m/s; exact: (K,) where the robot comes to the
        point itself; lines: (K,) of the file at work.
        """
        count = len(lines)
        nothing, none = np.full((count, 3), np.nan), np.full(count, -1, dtype=np.int64)
        columns: list[NDArray[Any]] = [
            np.full(count, LIN, dtype=np.int8),
            pose,
            nothing,
            nothing[:, 0],
            axes,
            none,
            none,
            np.full(count, self.base, dtype=np.int32),
            np.full(count, self.tool, dtype=np.int32),
            np.full(count, self.constant),
            speed,
            exact,
            lines,
            np.full(count, self.file, dtype=np.int32),
        ]
        self.columns.add_rows(columns)
        self.here = Here([float(value) for value in pose[-1]], None, self.base, self.tool)
        self.arrived()

    def ended(self, reason: LostError | None) -> Motions:
        """The motions of a run that is over: to its end, or (`reason`) to where it was lost."""
        most = None
        if reason is not None:
            most = self.forget(_ENOUGH) if isinstance(reason, EndlessError) else None
            text = f"{reason}; what follows isn't judged"
            self.gaps.append(Gap(self.count, self.line, self.line, text, self.file))
        self.close_steps()
        motions = self.columns.motions(most)
        stops = np.array([*self.stops, self.count - 1], dtype=np.int64)
        motions.exact[stops[(stops >= 0) & (stops < len(motions))]] = True
        return motions

    def tick(self, line: Line) -> None:
        """Counts a statement; raises LostError where a run has no end."""
        self.taken += 1
        self.line = line.number
        if self.taken > _MOST + _AGAIN * self.written:
            raise EndlessError(f"more than {self.taken - 1} statements: the program may never end")

    def gap(self, line: Line, why: str, last: int | None = None) -> None:
        """Notes what isn't judged; like statements in a row are one gap."""
        text = f"{line.raw[:80]}: {why}"
        number = line.number if last is None else last
        if self.gaps:
            old = self.gaps[-1]
            like = (
                old.file == self.file and old.text.endswith(why) and old.last_line <= line.number <= old.last_line + 3
            )
            if like:
                self.gaps[-1] = replace(old, last_line=max(number, old.last_line))
                return
        self.gaps.append(Gap(self.count, line.number, number, text, self.file))

    def unsure(self, line: int, text: str) -> None:
        """Notes, once, what isn't judged of how the program moves."""
        gap = Gap(self.count, line, line, text, self.file)
        if all((old.text, old.file) != (text, self.file) for old in self.unsettled):
            self.unsettled.append(gap)

    def moves(self, line: int, ptp: bool, rounded: bool) -> None:
        """Holds what is in force at a motion to the cell."""
        for code, text in self.conduct.at_motion(ptp, rounded):
            if code:
                self.ruled.append(Objection(code, text, line=line, file=self.file))
            else:
                self.unsure(line, text)

    def unknown(self, line: Line, why: str) -> None:
        """A statement that isn't understood: a hook of the cell may account for it, else it is a gap."""
        code = canonical(line.code)
        if self.quiet or not self.hooks.concerns(code):
            self.gap(line, why)
        else:
            self.steps.append(Step(line, self.file, "gap", code, why=why))

    def object(self, code: str, text: str, line: Line | int, severity: str = "error") -> None:
        """Notes what stands against the program; the same at the same line only once."""
        number = line if isinstance(line, int) else line.number
        objection = Objection(code, text, line=number, file=self.file, severity=severity)
        if objection not in self.objections[-20:]:
            self.objections.append(objection)

    def step(self, line: Line, act: str, code: str = "", value: float = 0.0) -> None:
        """A statement that may belong to a hook, or be an event itself."""
        code = canonical(code or line.code)
        if len(self.steps) >= _MOST_STEPS:
            raise EndlessError(f"more than {_MOST_STEPS} statements between two motions")
        if not self.quiet and (act != "other" or self.hooks.concerns(code)):
            self.steps.append(Step(line, self.file, act, code, value))

    def needs_splines(self, line: Line) -> None:
        """A motion of the spline kind, which controllers have from KSS 8 on."""
        what, own = "motions of the spline kind (SLIN, SPLINE, ...), which the cell's", self.machine.controller.own
        if own.get("generation") == "KRC2":
            self.object_once("not-on-controller", f"{what} controller, a KRC2, doesn't know", line)
        elif own.get("motions") != "SLIN":
            self.object_once("spline-unasked", f"{what} [controller] doesn't name as its motions", line, "warning")

    def object_once(self, code: str, text: str, line: Line | int, severity: str = "error") -> None:
        """Notes what stands against the program where nothing of its code does yet."""
        if all(old.code != code for old in self.objections):
            self.object(code, text, line, severity)

    def object_longer(self, line: int, characters: int) -> None:
        """Notes a line that is longer than the cell's controller takes."""
        most = self.machine.controller.own.get("max_line_length")
        if isinstance(most, int) and characters > most:
            text = f"a line of {characters} characters, where the cell's controller takes {most} (max_line_length)"
            self.object("line-too-long", text, line)

    def waits(self, line: Line) -> None:
        """The advance run stops: the motion before ends exactly where it was sent."""
        if self.early is not None:
            self.gap(line, "CONTINUE before it lets it happen before the robot has arrived, and when isn't judged")
        elif self.count:
            self.stops.append(self.count - 1)

    def room(self, more: int) -> None:
        """Raises LostError where a run has more motions than any honest program."""
        if self.count + more > _MOST_MOTIONS + _AGAIN * self.written:
            raise EndlessError(f"more than {self.count} motions: the program may never end")

    def forget(self, most: int) -> int:
        """Keeps the first motions of a run without an end, and what happened until then; how many they are."""
        most = min(most, self.count)
        self.steps = []
        self.events = [event for event in self.events if event.before <= most]
        self.gaps = [gap for gap in self.gaps if gap.before <= most]
        self.objections = self.objections[:_FEW]
        self.columns.count = most
        return most

    def close_steps(self) -> None:
        """A motion follows, or the end: what has been said since the last one becomes events."""
        if self.steps:
            events, gaps = self.hooks.events(self.steps, self.count)
            self.events += events
            self.gaps += gaps
            self.steps = []

    def arrived(self) -> None:
        """A motion has been added: what was to be switched at its end is."""
        self.steps, self.after_next = self.after_next, []

    def begin(self) -> None:
        """BAS(#INITMOV): what the controller keeps is at its defaults, which for speeds and frames the text doesn't say."""
        self.conduct.begin()
        self.set_load(self.line, None)
        self.speed, self.constant, self.unlike_line, self.unlike_arc = float("nan"), False, "", ""
        self.rounds = True
        self.reset = [name for name, known in (("$BASE", self.base), ("$TOOL", self.tool)) if known]

    def unknown_row(self, name: str, line: Line, why: str) -> None:
        """`$TOOL` or `$BASE` is a row of the controller's tables that isn't at hand: a gap, once it counts for a motion."""
        self.owed[name] = (line, why)
        if name == "TOOL":
            self.set_tool(None)
        else:
            self.set_base(Base(None, False))

    def settle(self) -> None:
        """A motion follows: what it needs and nobody knows is a gap."""
        for name, (line, why) in self.owed.items():
            if (self.tools[self.tool] if name == "TOOL" else self.bases[self.base].values) is None:
                self.gap(line, why)
        self.owed = {}

    def set_base(self, base: Base) -> None:
        """The `$BASE` in force from here on."""
        self.reset = [name for name in self.reset if name != "$BASE"]
        found = next((k for k, old in enumerate(self.bases) if old.same(base)), None)
        if found is None:
            self.bases.append(base)
        self.base = len(self.bases) - 1 if found is None else found

    def set_tool(self, values: tuple[float, ...] | None) -> None:
        """The `$TOOL` in force from here on, None where the text doesn't say."""
        self.reset = [name for name in self.reset if name != "$TOOL"]
        if values not in self.tools:
            self.tools.append(values)
        self.tool = self.tools.index(values)

    def set_load(self, line: int, values: tuple[float, ...] | None) -> None:
        """The load in force from here on; None for the controller's own."""
        if values is not None or self.loads:
            self.loads.append(Load(self.count, values, line, self.file))

    def change_load(self, line: int, part: str, value: Value) -> None:
        """`$LOAD`, or one component such as M or CM.X, set to a value; a component without a known number is NaN."""
        before = self.loads[-1].values if self.loads else None
        known = dict(zip(_LOAD, before or (float("nan"),) * len(_LOAD), strict=True))
        for name in known:
            if not part or name == part or name.startswith(part + "."):
                item: Value | None = value
                for key in name.removeprefix(part).strip(".").split(".") if name != part else ():
                    item = item.get(key) if isinstance(item, dict) else None
                plain = isinstance(item, int | float) and not isinstance(item, bool)
                known[name] = float(item) if plain else float("nan")  # type: ignore[arg-type]
        self.set_load(line, tuple(known.values()))

    def frame_of(self, value: Value) -> tuple[float, ...]:
        """X..C of an aggregate that gives all six; raises UnknownError."""
        if not isinstance(value, dict):
            raise UnknownError("it is not a frame")
        missing = [name for name in "XYZABC" if not isinstance(value.get(name), int | float)]
        if missing:
            raise UnknownError(f"it leaves {', '.join(missing)} open")
        return tuple(float(value[name]) for name in "XYZABC")  # type: ignore[arg-type]

    def base_T_krl(self, index: int) -> Array:
        """The cell's `base` to a `$BASE` with the external axes where they are; raises UnknownError."""
        base = self.bases[index]
        if base.values is None:
            raise UnknownError("$BASE isn't known")
        fixed = self.machine.base_T_controller @ frame(np.array(base.values))
        axes = np.array([[0.0] * 6 + self.external])
        return fixed if base.follows else np.asarray(self.machine.base_T_world(axes)[0] @ fixed)

    def flange_T_tip(self, index: int) -> Array:
        """`$TOOL`; raises UnknownError."""
        values = self.tools[index]
        if values is None:
            raise UnknownError("$TOOL isn't known")
        return frame(np.array(values))

    def _stands(self, *, axes: bool) -> Value:
        """$POS_ACT or $AXIS_ACT (axes): where the robot was sent last, and has to have come to; raises UnknownError."""
        if axes and (self.here.axes is None or np.isnan(self.here.axes).any()):
            raise UnknownError("$AXIS_ACT isn't known")
        if self.early is not None:
            raise UnknownError("CONTINUE before it doesn't wait for the robot")
        names = [f"A{k}" for k in range(1, 7)] if axes else list(POSE)
        values = list(self.here.axes or ())[:6] if axes else self.pose_here()
        outer = zip(self.machine.axis_names[6:], self.external, strict=True)
        if self.count:
            self.stops.append(self.count - 1)
        return {
            **dict(zip(names, values, strict=True)),
            **{name: value for name, value in outer if not np.isnan(value)},
        }

    def pose_here(self) -> list[float]:
        """Where the robot was sent last, as X..C in the `$BASE` and with the `$TOOL` in force; raises UnknownError."""
        here = self.here
        if here.pose is not None and here.base == self.base and here.tool == self.tool:
            return list(here.pose)
        if here.pose is not None:
            base_T_tip = self.base_T_krl(here.base) @ frame(np.array(here.pose))
            base_T_flange = base_T_tip @ inverse(self.flange_T_tip(here.tool))
        elif here.axes is not None and not np.isnan(here.axes).any():
            base_T_flange = self.machine.base_T_flange(np.array([here.axes]))[0]
        else:
            raise UnknownError("where the robot stands isn't known")
        krl_T_tip = inverse(self.base_T_krl(self.base)) @ base_T_flange @ self.flange_T_tip(self.tool)
        return [float(value) for value in to_values(krl_T_tip)]
