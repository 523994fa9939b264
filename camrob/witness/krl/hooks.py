"""The cell's hooks, found again in what a program says between two motions.

A hook is lines of KRL in cell.toml. Text and hook are compared without blanks, in capitals, with numbers in one spelling, and
without comments; but where two hooks differ by a comment alone, or a value stands only in one, the comment counts.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from camrob.witness.happenings import Event, Gap, Kind
from camrob.witness.krl.text import Line, split_comment
from camrob.witness.krl.values import UnknownError, Variables

__all__ = ["Hooks", "Step", "canonical"]

_NUMBER = re.compile(r"(?<![A-Z0-9_$.#'])(\d+\.?\d*|\.\d+)(E[-+]?\d+)?(?![A-Z_$'])")
_HOLE = re.compile(r"\{(speed|number|seconds|name)\}")
_KINDS = {
    "spindle_on": (Kind.SPINDLE_ON, "CLW"),
    "spindle_on_ccw": (Kind.SPINDLE_ON, "CCLW"),
    "spindle_off": (Kind.SPINDLE_OFF, ""),
    "coolant_on": (Kind.COOLANT_ON, ""),
    "coolant_off": (Kind.COOLANT_OFF, ""),
    "tool_change": (Kind.TOOL, ""),
    "stop": (Kind.STOP, ""),
    "dwell": (Kind.DWELL, ""),
}
_SAME = 1e-6  # share: what eight printed decimals leave
_FRAMING = ("header", "footer")  # hooks that are no event themselves: their outputs count as what they are
_SWITCHES = ("spindle_off", "coolant_off", "coolant_on")


@dataclass(frozen=True, slots=True)
class Step:
    """A statement that may belong to a hook. `act`: output, wait, halt, gap, other; `why`: a gap's.

    value: a wait's seconds, or what an output is set to where that is a known number.
    """

    line: Line
    file: int
    act: str
    code: str
    value: float = 0.0
    why: str = ""


@dataclass(frozen=True, slots=True)
class _HookLine:
    """A statement of a hook, and the comments on it and right above it."""

    code: re.Pattern[str]
    comments: tuple[
        tuple[re.Pattern[str], bool], ...
    ]  # True: it carries a value that the code doesn't, or tells HALTs apart
    number: _Number | None

    def match(self, step: Step) -> dict[str, str] | None:
        """The values of the holes where a statement is this one, in its text or in the number that it comes to."""
        found = self.code.fullmatch(step.code)
        if found is not None:
            return found.groupdict()
        return None if self.number is None else self.number.match(step)


@dataclass(frozen=True, slots=True)
class _Number:
    """A statement that hands over one number, `least + rise * hole`; `hole` is "" where it is a constant."""

    begins: str
    hole: str
    least: float
    rise: float

    def match(self, step: Step) -> dict[str, str] | None:
        """The hole's value that a step comes to; None where it is another statement."""
        if step.act not in ("output", "wait") or not step.code.startswith(self.begins) or not np.isfinite(step.value):
            return None
        if self.begins.startswith("$ANOUT") and abs(step.value) > 1.0:
            return None  # no such output has it
        if not self.hole:
            return {} if abs(step.value - self.least) <= _SAME * max(1.0, abs(self.least)) else None
        value = round((step.value - self.least) / self.rise, 3)
        return {self.hole: f"{value:.12g}"} if value > 0.0 else None


@dataclass(frozen=True, slots=True)
class _Hook:
    name: str
    lines: tuple[_HookLine, ...]


def canonical(code: str, divides: bool | None = None) -> str:
    """A statement's code in the one spelling in which it is compared.

    divides: whether it is part of one that divides, where 9 / 2 is 4 and 9 / 2.0 is not: there numbers keep their kind.
    """
    divides = "/" in code if divides is None else divides

    def number(match: re.Match[str]) -> str:
        real = divides and ("." in match[0] or "E" in match[0].upper())
        text = f"{float(match[0]):.12g}"
        return text + ("." if real and text.isdigit() else "")

    parts = code.split('"')
    for i in range(0, len(parts), 2):
        same = _NUMBER.sub(number, parts[i].upper())
        parts[i] = "".join(same.split())
    return '"'.join(parts)


def _pattern(template: str, comment: bool) -> re.Pattern[str]:
    """The template as a regular expression, its holes as named groups."""
    out, seen = "", set()
    for i, part in enumerate(_HOLE.split(template)):
        if i % 2 == 0:
            pieces = part.split() if comment else [canonical(part, "/" in template)]
            text = r"\s*".join(re.escape(piece) for piece in pieces)
            out += rf"\s*{text}\s*" if comment else text
        elif part in seen:
            out += f"(?P={part})"
        else:
            seen.add(part)
            out += f"(?P<{part}>.+?)" if part == "name" else f"(?P<{part}>[-+]?[0-9.]+(?:E[-+]?[0-9]+)?)"
    return re.compile(out, re.IGNORECASE)


def _number(code: str) -> _Number | None:
    """A hook's statement as a number that depends evenly on its hole; None where it is none such."""
    parts = re.fullmatch(r"\s*(WAIT\s+SEC\b|[^={]+=)(.+)", code, re.IGNORECASE)
    holes = set(_HOLE.findall(code))
    if parts is None or len(holes) > 1:
        return None
    try:
        low, middle, high = (Variables().number(_HOLE.sub(text, parts[2]).upper()) for text in ("1", "2", "3"))
    except UnknownError:
        return None
    rise = middle - low
    if abs(high - middle - rise) > 1e-9 * abs(high) or bool(rise) != bool(holes):
        return None
    return _Number(canonical(parts[1]), next(iter(holes), ""), low - rise, rise)


def _hook(name: str, texts: tuple[str, ...]) -> _Hook:
    lines, remarks = [], list[str]()
    for text in texts:
        code, comment = split_comment(text)
        remarks += [comment] if comment.strip() else []
        if code.strip():
            held, halts = set(_HOLE.findall(code)), canonical(code) == "HALT"
            comments = tuple(
                (_pattern(remark, True), halts or bool(set(_HOLE.findall(remark)) - held)) for remark in remarks
            )
            lines.append(_HookLine(_pattern(code, False), comments, _number(code)))
            remarks = []
    return _Hook(name, tuple(lines))


class Hooks:
    """All hooks of a cell."""

    def __init__(self, texts: Mapping[str, tuple[str, ...]], switch: str = "=") -> None:
        """switch: what (a regular expression) the code of a statement that switches an output holds."""
        hooks = [_hook(name, lines) for name, lines in texts.items()]
        self.hooks = [hook for hook in hooks if hook.lines]
        switches = {name: [canonical(split_comment(text)[0]) for text in texts.get(name, ())] for name in _SWITCHES}
        self.switches = {name: {code for code in codes if re.search(switch, code)} for name, codes in switches.items()}

    def concerns(self, code: str) -> bool:
        """True where some hook has this statement, in canonical spelling."""
        return any(line.code.fullmatch(code) for hook in self.hooks for line in hook.lines)

    def _match(self, hook: _Hook, steps: list[Step], at: int) -> tuple[int, dict[str, str]] | None:
        """Comments that agree, and the values read, where the hook's lines are the steps from `at` on."""
        if at + len(hook.lines) > len(steps):
            return None
        score, values = 0, dict[str, str]()
        for line, step in zip(hook.lines, steps[at:], strict=False):
            matches = [line.match(step)]
            for pattern, needed in line.comments:
                said = (step.line.comment, *step.line.above)
                found = next((match for text in said if (match := pattern.fullmatch(text)) is not None), None)
                if needed and found is None:
                    return None
                score += found is not None
                matches += [] if found is None else [found.groupdict()]
            if matches[0] is None:
                return None
            for values_here in matches:
                for name, value in (values_here or {}).items():
                    if values.setdefault(name, value) != value:
                        return None
        return score, values

    def events(self, steps: list[Step], before: int) -> tuple[list[Event], list[Gap]]:
        """What the statements between two motions stand for; the longest hook first, then the one whose comments agree."""
        events: list[Event] = []
        gaps: list[Gap] = []
        at = 0
        while at < len(steps):
            found = [(hook, match) for hook in self.hooks if (match := self._match(hook, steps, at)) is not None]
            if not found:
                self._alone(steps[at], before, events, gaps)
                at += 1
                continue
            best = max((len(hook.lines), score) for hook, (score, _) in found)
            equal = [(hook, values) for hook, (score, values) in found if (len(hook.lines), score) == best]
            hook, values = next((item for item in equal if item[0].name not in _FRAMING), equal[0])
            names = [other.name for other, _ in equal if other.name not in _FRAMING]
            taken = steps[at : at + len(hook.lines)]
            if len(names) > 1:
                text = f"the cell's hooks {' and '.join(names)} have the same text: which is meant can't be told"
                gaps.append(Gap(before, taken[0].line.number, taken[-1].line.number, text, taken[0].file))
            if hook.name in _KINDS or hook.name.startswith("coolant_on_"):
                kind, text = _KINDS.get(hook.name, (Kind.COOLANT_ON, hook.name.removeprefix("coolant_on_").upper()))
                number = next((values[key] for key in ("speed", "number", "seconds") if key in values), "0")
                value = float(number) if re.fullmatch(r"[-+]?(\d+\.?\d*|\.\d+)(E[-+]?\d+)?", number) else float("nan")
                text = values.get("name", text)
                events.append(Event(before, kind, value, text, taken[0].line.number, taken[0].file))
            else:
                self._framing(hook, taken, before, events)
            at += len(hook.lines)
        return events, gaps

    def _framing(self, hook: _Hook, taken: list[Step], before: int, events: list[Event]) -> None:
        """Header, footer and hooks of other names: where they switch off or on what another hook does, they do the same."""
        done = {step.code: step for step in taken}
        for name in _SWITCHES:
            codes = self.switches[name]
            if codes and codes <= done.keys():
                last = max((done[code] for code in codes), key=lambda step: step.line.number)
                events.append(Event(before, _KINDS[name][0], 0.0, _KINDS[name][1], last.line.number, last.file))
        if hook.name not in _FRAMING:
            text = f"hook {hook.name}"
            events.append(Event(before, Kind.OUTPUT, 0.0, text, taken[0].line.number, taken[0].file))

    @staticmethod
    def _alone(step: Step, before: int, events: list[Event], gaps: list[Gap]) -> None:
        """A statement that belongs to no hook."""
        number, file = step.line.number, step.file
        if step.act == "wait" and step.value != 0.0:
            events.append(Event(before, Kind.DWELL, step.value, "", number, file))
        elif step.act == "halt":
            events.append(Event(before, Kind.STOP, 0.0, "", number, file))
        elif step.act == "output":
            events.append(Event(before, Kind.OUTPUT, 0.0, step.line.raw, number, file))
        elif step.act == "gap":
            gaps.append(Gap(before, number, number, f"{step.line.raw[:80]}: {step.why}", file))
