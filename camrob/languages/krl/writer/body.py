"""The motions of a program as KRL lines, with what is written between them."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from camrob.cell.controller_settings import ControllerSettings
from camrob.errors import JobError
from camrob.languages.krl.krl_settings import krl_settings
from camrob.languages.krl.krl_text import comment_text, frame_aggregate, load_aggregate
from camrob.languages.krl.rounding import (
    ANGLE_DECIMALS,
    EXTERNAL_DECIMALS,
    FRAME_DECIMALS,
    LENGTH_DECIMALS,
    LOAD_DECIMALS,
    SPEED_DECIMALS,
)
from camrob.languages.krl.rounding import axes as rounded_axes
from camrob.languages.krl.rounding import external as rounded_external
from camrob.languages.krl.writer.lines import LineBlock, format_lines, speed_line
from camrob.languages.krl.writer.opening import tool_lines
from camrob.program.motion import Motion
from camrob.program.printed import fixed_decimals
from camrob.program.program import Program, ProgramEvent, ProgramEventKind

__all__ = ["KrlBody"]

_CHUNK = 32768  # motions written at once: some MB of text
_LARGEST = 1e9  # mm or degrees: more is no coordinate, and no longer fits the number's room


class KrlBody:
    """Prints any stretch of a program's motions. It checks the program once, when it is made.

    Raises ValueError for a program that can't be printed as it is, JobError for a line that gets too long.
    """

    def __init__(self, program: Program, controller: ControllerSettings) -> None:
        self._program = program
        self._controller = controller
        self._own = krl_settings(controller)
        home = self._own.customs.home_point
        axes = home.axes if home else ()
        self._home = np.concatenate((rounded_axes(axes[:6]), rounded_external(axes[6:])))
        kind = program.kind
        self._ptp = (kind == Motion.PTP_AXES) | (kind == Motion.PTP_POSE)
        self._labels = (*"XYZABC", *program.external_names)
        external = (EXTERNAL_DECIMALS,) * len(program.external_names)
        self._decimals = ((LENGTH_DECIMALS,) * 3 + (ANGLE_DECIMALS,) * 3) + external
        self._axis_decimals = (ANGLE_DECIMALS,) * 6 + external
        self._events: dict[int, list[ProgramEvent]] = {}
        for event in program.events:
            self._events.setdefault(event.motion, []).append(event)
        _check(program, self._ptp, self._events)
        self._speed = self._printed_speed()
        self._changed = self._speed_changes()
        self._stops = np.unique([*self._events, *np.flatnonzero(self._ptp)]).astype(np.int64)
        folds = sorted((e for e in program.events if e.kind is ProgramEventKind.REGION), key=lambda e: e.motion)
        self._fold_rows = [e.motion for e in folds]
        self._fold_titles = [e.text for e in folds]

    def hook(self, name: str, value: float = 0.0) -> list[str]:
        """Lines of one of the cell's hooks, held to the line length."""
        lines = list(self._controller.hook_lines(name, value))
        for line in lines:
            self.check_length(line)
        return lines

    def check_length(self, line: str, motion: int | None = None) -> None:
        """Raises JobError for a line that the controller would not take."""
        self._check_count(len(line), 0 if motion is None else int(self._program.line[motion]))

    def sizes(self) -> NDArray[np.int64]:
        """Bytes of each motion with what is written before it (N,); what follows the last motion counts to that."""
        total = len(self._program)
        sizes = np.zeros(total, dtype=np.int64)
        for row, text, ends in self._stretches(0, total, last=True):
            if ends is None:
                if total:
                    sizes[min(row, total - 1)] += len(text)
            else:
                sizes[row : row + len(ends)] += np.diff(ends, prepend=0)
        return sizes

    def text(self, start: int, end: int, *, last: bool) -> bytes:
        """Motions `start` to `end` with the events before each, and those after the last one where `last` is set."""
        return b"".join(text for _, text, _ in self._stretches(start, end, last=last))

    def _stretches(self, start: int, end: int, *, last: bool) -> Iterator[tuple[int, bytes, NDArray[np.int64] | None]]:
        """(first row, text, ends of the rows' lines in it or None for a text that stands before the row)."""
        speak = self._changed[start:end].copy()
        cp = np.flatnonzero(~self._ptp[start:end])
        if len(cp):
            speak[cp[0]] = True
        title = self._open_fold(start)
        if title:
            yield start, self._encoded(self._fold(title + " (continued)")), None
        inside = self._stops[(self._stops >= start) & ((self._stops < end) | (last & (self._stops == end)))]
        row = start
        for stop in (*inside.tolist(), end):
            yield from self._bulk(row, stop, speak[row - start : stop - start])
            row = stop
            for event in self._events.get(stop, ()) if stop < end or last else ():
                lines = self._event_lines(event, bool(title))
                title = event.text if event.kind is ProgramEventKind.REGION else title
                if lines:
                    yield row, b"".join(map(self._encoded, lines)), None
            if stop < end and self._ptp[stop]:
                yield row, self._encoded(self._ptp_line(stop)), None
                row = stop + 1
            elif stop == end:
                break
        if title and self._own.customs.folds:
            yield end, self._encoded(";ENDFOLD"), None

    def _open_fold(self, start: int) -> str:
        """Title of the fold that a stretch from `start` begins in, empty where none is open or a new one begins."""
        before = int(np.searchsorted(self._fold_rows, start, side="left"))
        if before == 0 or start in self._fold_rows[before:]:
            return ""
        return self._fold_titles[before - 1]

    def _bulk(self, start: int, end: int, speak: NDArray[np.bool_]) -> Iterator[tuple[int, bytes, NDArray[np.int64]]]:
        """CP motions, some ten thousand at a time."""
        p = self._program
        row = start
        while row < end:
            stop = min(row + _CHUNK, end)
            if stop < end and p.kind[stop] == Motion.CIRC_END:
                stop -= 1
            values = np.concatenate((p.pose[row:stop], p.external[row:stop]), axis=1)
            block = LineBlock(
                kind=p.kind[row:stop],
                values=_scaled(values, self._decimals, row),
                labels=self._labels,
                decimals=self._decimals,
                speed=self._speed[row:stop],
                speed_decimals=SPEED_DECIMALS,
                speak=speak[row - start : stop - start],
                approximate=p.approximate[row:stop],
                spline=self._own.customs.splines,
                rounding=self._own.customs.blend_word,
            )
            text, ends, longest = format_lines(block)
            self._check_count(longest, int(p.line[row]))
            yield row, text, ends
            row = stop

    def _check_count(self, characters: int, line: int) -> None:
        """Raises JobError for a line of more characters than the controller takes."""
        if characters > self._controller.max_line_length:
            most = self._controller.max_line_length
            what = f"a line of KRL gets {characters} characters, the controller takes {most} (max_line_length)"
            raise JobError(f"{what}; shorten names and comments", line=line)

    def _ptp_line(self, row: int) -> str:
        """The line of a PTP motion."""
        p = self._program
        axes = p.kind[row] == Motion.PTP_AXES
        home = self._own.customs.home_point
        if home is not None and axes and np.array_equal(self._home, (*p.axes[row], *p.external[row])):
            return f"PTP {home.name}"
        values = np.concatenate((p.axes[row] if axes else p.pose[row], p.external[row]))
        decimals = self._axis_decimals if axes else self._decimals
        _scaled(values[None, :], decimals, row)
        labels = (*(f"A{k}" for k in range(1, 7)), *p.external_names) if axes else self._labels
        parts = [f"{label} {fixed_decimals(float(v), d)}" for label, v, d in zip(labels, values, decimals, strict=True)]
        if not axes:
            parts[6:6] = [f"S {p.status[row]}", f"T {p.turn[row]}"]
        line = f"PTP {{{'E6AXIS' if axes else 'E6POS'}: {','.join(parts)}}}"
        self.check_length(line, row)
        return line

    def _event_lines(self, event: ProgramEvent, fold_open: bool) -> list[str]:
        """The lines of one event."""
        if event.kind is ProgramEventKind.HOOK:
            lines = self.hook(event.text, event.value)
            return lines or [f"; {event.text}: the cell has no lines for it"]
        if event.kind is ProgramEventKind.DWELL:
            return [f"WAIT SEC {fixed_decimals(event.value, 3)}"]
        if event.kind is ProgramEventKind.TOOL:
            frame = frame_aggregate(tuple(self._program.tools[int(event.value)]), FRAME_DECIMALS)
            return tool_lines(self._own, frame)
        if event.kind is ProgramEventKind.LOAD:
            return ["$LOAD = " + load_aggregate(tuple(self._program.loads[int(event.value)]), LOAD_DECIMALS)]
        if event.kind is ProgramEventKind.COMMENT:
            return ["; " + comment_text(event.text, self._room(2))]
        closing = [";ENDFOLD"] if fold_open and self._own.customs.folds else []
        return closing + ([self._fold(event.text)] if event.text else [])

    def _fold(self, title: str) -> str:
        """What opens a fold, or only names what follows."""
        opens = ";FOLD " if self._own.customs.folds else "; "
        return opens + comment_text(title, self._room(len(opens)))

    def _room(self, used: int) -> int:
        """Characters that a line has left."""
        return self._controller.max_line_length - used

    @staticmethod
    def _encoded(line: str) -> bytes:
        return line.encode("ascii") + b"\r\n"

    def _printed_speed(self) -> NDArray[np.int64]:
        """Speeds as whole numbers of the last decimal; a CIRC takes that of its end."""
        p = self._program
        speed = np.where(self._ptp, 0.0, p.speed)
        via = np.flatnonzero(p.kind == Motion.CIRC_VIA)
        speed[via] = speed[via + 1]
        if not np.isfinite(speed).all() or np.any(np.abs(speed) > _LARGEST):
            raise ValueError("a speed is not finite")
        printed = np.rint(speed * 10.0**SPEED_DECIMALS).astype(np.int64)
        if np.any(printed[~self._ptp] <= 0):
            row = int(np.flatnonzero(~self._ptp & (printed <= 0))[0])
            least = speed_line(10.0**-SPEED_DECIMALS, SPEED_DECIMALS)
            raise ValueError(
                f"motion {row} has a speed of {p.speed[row]} m/s; the least that can be printed is {least}"
            )
        return printed

    def _speed_changes(self) -> NDArray[np.bool_]:
        """(N,) True at the first CP motion and at each whose speed differs from the CP motion before it."""
        changed = np.zeros(len(self._program), dtype=np.bool_)
        cp = np.flatnonzero(~self._ptp)
        changed[cp] = np.diff(self._speed[cp], prepend=-1) != 0
        return changed


def _scaled(values: NDArray[np.float64], decimals: tuple[int, ...], row: int) -> NDArray[np.int64]:
    """Values (M, K) as whole numbers of their last decimal. Raises ValueError unless they are rounded to it."""
    factor = 10.0 ** np.array(decimals)
    if not np.all(np.abs(values) < _LARGEST):
        raise ValueError(f"motion {row} or one after it holds a value that is not finite or too large")
    whole = np.rint(values * factor)
    wrong = whole / factor != values
    if wrong.any():
        first, column = np.argwhere(wrong)[0]
        raise ValueError(f"motion {row + first}: {values[first, column]!r} has more than {decimals[column]} decimals")
    return np.asarray(whole.astype(np.int64))


def _check(program: Program, ptp: NDArray[np.bool_], events: dict[int, list[ProgramEvent]]) -> None:
    """Raises ValueError for a program that has no meaning in KRL."""
    kind, count = program.kind, len(program)
    names = program.external_names
    if len(set(names)) != len(names) or not all(re.fullmatch("E[1-6]", name) for name in names):
        raise ValueError(f"external axes are named {names}, KRL knows E1 to E6")
    if not np.isin(kind, list(Motion)).all():
        raise ValueError("a motion is of no known kind")
    via, end = kind == Motion.CIRC_VIA, kind == Motion.CIRC_END
    if (count and (via[-1] or end[0])) or not np.array_equal(via[:-1], end[1:]):
        raise ValueError("a CIRC lacks its auxiliary point or its end")
    if np.any(program.approximate & (ptp | via)):
        raise ValueError("only LIN and the end of a CIRC can be approximated")
    if np.any(program.safe & via):
        raise ValueError("an auxiliary point can't be a safe retract")
    posed = kind == Motion.PTP_POSE
    if np.any((program.status[posed] < 0) | (program.turn[posed] < 0)):
        raise ValueError("a PTP to a pose needs its S and T")
    for row, some in events.items():
        if not 0 <= row <= count or (row < count and end[row]):
            raise ValueError(f"an event stands at {row}, which is not a place between the {count} motions")
        if any(e.kind is ProgramEventKind.TOOL and int(e.value) not in range(len(program.tools)) for e in some):
            raise ValueError(f"before motion {row} a tool is mounted that the program does not hold")
        loads = [int(e.value) for e in some if e.kind is ProgramEventKind.LOAD]
        if any(k not in range(len(program.loads)) or not _is_load(program.loads[k]) for k in loads):
            raise ValueError(f"before motion {row} a load is set that the program does not hold, or that is none")
        if any(e.kind is ProgramEventKind.DWELL and not 0.0 <= e.value < _LARGEST for e in some):
            raise ValueError(f"the dwell before motion {row} is not a time")


def _is_load(load: NDArray[np.float64]) -> bool:
    """Whether a load (7,) is one: finite, and a mass above zero."""
    return bool(np.all(np.abs(load) < _LARGEST) and load[0] > 0.0)
