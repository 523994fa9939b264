"""What a cell says about its controller: how a program for it is printed, and how large a file may be."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from camrob.errors import CellError

__all__ = ["HOOK_PLACEHOLDERS", "ControllerSettings", "check_line"]

HOOK_PLACEHOLDERS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "spindle_on": ("speed",),
        "spindle_on_ccw": ("speed",),
        "spindle_off": (),
        "coolant_on": (),
        "coolant_off": (),
        "tool_change": ("number",),
        "stop": (),
        "header": (),
        "footer": (),
    }
)
"""The hooks that a cell may fill, and the numbers that each may print."""

_PLACEHOLDER = re.compile(r"\{(\s*[A-Za-z_][A-Za-z0-9_]*\s*)\}")


_FASTEST_MS = 0.1  # a tenth of the shortest cycle in which controllers interpolate: less is seconds, written for ms


@dataclass(frozen=True, slots=True)
class ControllerSettings:
    """Settings of the controller, in the units that programs print.

    acc_cp: m/s2. vel_ori_deg_s, acc_ori_deg_s2: both orientation speeds and accelerations. apo_cdis_mm: how far from a corner it
    may be rounded. advance: motions that are prepared ahead. ptp_velocity_percent: of the axes' top speed, for PTP. max_lines,
    max_bytes: motions and bytes of one file. max_line_length: characters.
    block_ms: ms that the controller takes for one motion at the least, however short it is; 0 where nobody says.
    spindle_rpm: the least and the most that the spindle turns at while it is on, None where nobody says.
    tool_change_pose: where tools are changed, axis values in the order A1..A6, E1.. (degrees and mm); None is HOME.
    entries: whether a program comes with one for each operation behind the first, that does the rest of it from there on.
    base_frame: where the cell's `base` lies in the controller's world, or where base follows the table in the plate that turns:
    X, Y, Z, A, B, C, mm and degrees; None where nobody says, and the two are taken to be one.
    hooks: lines of a program for each name of `HOOK_PLACEHOLDERS`; `{speed}` and the like stand for numbers. `spindle_on`
    turns clockwise, `spindle_on_ccw` counter-clockwise.
    language: what programs are written in, "" the usual one; own: what the cell says beside all this, for that language alone,
    which checks it, and what the hooks do, before it writes a line (`camrob.program.language.Language.settings`).

    The templates are printed as they are, so they may come from the cell's own files only. Raises CellError for a value
    that could not be printed, an unknown hook, and a placeholder that the hook has no number for.
    """

    acc_cp: float
    vel_ori_deg_s: float
    acc_ori_deg_s2: float
    apo_cdis_mm: float
    advance: int
    ptp_velocity_percent: float
    max_lines: int
    max_bytes: int
    max_line_length: int
    block_ms: float = 0.0
    spindle_rpm: tuple[float, float] | None = None
    tool_change_pose: tuple[float, ...] | None = None
    entries: bool = False
    base_frame: tuple[float, ...] | None = None
    hooks: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    language: str = ""
    own: Mapping[str, object] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("acc_cp", "vel_ori_deg_s", "acc_ori_deg_s2", "ptp_velocity_percent"):
            _check_number(name, getattr(self, name), above=0.0)
        _check_number("apo_cdis_mm", self.apo_cdis_mm)
        _check_number("block_ms", self.block_ms)
        if 0.0 < self.block_ms < _FASTEST_MS:
            raise CellError(
                f"block_ms is {self.block_ms:g}, which no controller needs for a motion",
                hint="give ms: 12 for the KR C2",
            )
        if self.ptp_velocity_percent > 100.0:
            raise CellError(f"ptp_velocity_percent is {self.ptp_velocity_percent}", hint="100 is the axes' top speed")
        for name, least, most in (
            ("advance", 0, 5),
            ("max_lines", 2, None),
            ("max_bytes", 2000, None),
            ("max_line_length", 80, None),
        ):
            _check_integer(name, getattr(self, name), least, most)
        if self.spindle_rpm is not None:
            for value in self.spindle_rpm:
                _check_number("spindle_rpm", value)
            if len(self.spindle_rpm) != 2 or self.spindle_rpm[0] > self.spindle_rpm[1]:
                raise CellError(f"spindle_rpm is {list(self.spindle_rpm)}", hint="give [least, most]")
        if self.tool_change_pose is not None and not all(math.isfinite(v) for v in self.tool_change_pose):
            raise CellError("tool_change_pose holds a number that is not finite", hint="give degrees and mm")
        if self.base_frame is not None and not all(math.isfinite(v) for v in self.base_frame):
            raise CellError(
                "base_frame holds a number that is not finite", hint="give X, Y, Z, A, B, C in mm and degrees"
            )
        hooks: dict[str, tuple[str, ...]] = {}
        for name, lines in self.hooks.items():
            if name not in HOOK_PLACEHOLDERS:
                raise CellError(f"hook {name!r} is unknown", hint="the hooks are " + ", ".join(HOOK_PLACEHOLDERS))
            if isinstance(lines, str):
                raise CellError(f"hook {name} is a text", hint="write a list of lines")
            hooks[name] = tuple(lines)
            if not any(str(line).strip() for line in hooks[name]):
                raise CellError(f"hook {name} holds no line", hint="write what it does, or leave it out")
            for line in hooks[name]:
                check_line(f"hook {name}", line, HOOK_PLACEHOLDERS[name], self.max_line_length)
        object.__setattr__(self, "hooks", MappingProxyType(hooks))
        object.__setattr__(self, "own", MappingProxyType(dict(self.own)))

    def hook_lines(self, name: str, value: float = 0.0) -> tuple[str, ...]:
        """Lines of hook `name`, its placeholder filled with `value`; empty where the cell gives no template.

        Raises ValueError for an unknown hook and for a value that is no finite number.
        """
        if name not in HOOK_PLACEHOLDERS:
            raise ValueError(f"hook {name!r} is unknown")
        if not math.isfinite(value):
            raise ValueError(f"hook {name} got {value}")
        lines = self.hooks.get(name, ())
        for placeholder in HOOK_PLACEHOLDERS[name]:
            number = f"{value:.3f}".rstrip("0").rstrip(".")
            lines = tuple(line.replace("{" + placeholder + "}", "0" if number == "-0" else number) for line in lines)
        return lines


def _check_number(name: str, value: float, above: float | None = None) -> None:
    """Raises CellError unless `value` is finite, and above `above` (or at least 0)."""
    good = isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    if not good or (value <= above if above is not None else value < 0.0):
        raise CellError(
            f"{name} is {value!r}", hint="write a " + ("positive number" if above is not None else "number from 0")
        )


def _check_integer(name: str, value: int, least: int, most: int | None) -> None:
    """Raises CellError unless `value` is a whole number from `least` to `most`."""
    good = isinstance(value, int) and not isinstance(value, bool)
    if not good or value < least or (most is not None and value > most):
        span = f"from {least}" + (f" to {most}" if most is not None else "")
        raise CellError(f"{name} is {value!r}", hint=f"write a whole number {span}")


def check_line(name: str, line: object, placeholders: tuple[str, ...], longest: int) -> None:
    """Raises CellError unless `line` is one printable 7-bit line with no other placeholders."""
    if not isinstance(line, str) or not line.isascii() or not (line.isprintable() or line == ""):
        raise CellError(
            f"{name} holds a line that is not plain 7-bit text: {line!r}", hint="give one line of the program an entry"
        )
    if len(line) > longest:
        raise CellError(f"{name} holds a line of {len(line)} characters", hint=f"max_line_length is {longest}")
    if line.count("{") != line.count("}"):
        raise CellError(f"{name} holds a brace without its other: {line[:60]!r}", hint="close it, as in {speed}")
    for found in _PLACEHOLDER.findall(line):
        if found not in placeholders:
            known = ", ".join("{" + p + "}" for p in placeholders) or "none"
            raise CellError(f"{name} holds the placeholder {{{found}}}", hint=f"it may hold: {known}")
