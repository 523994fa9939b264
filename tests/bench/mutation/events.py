"""Process events in a program's text: runs of statements as the cell's hooks print them, and what state they lead to."""

from __future__ import annotations

import re
from collections.abc import Sequence

from mutation.krl import NUMBER, Statement

Token = tuple[str, float]

_RPM = re.compile(rf"\$ANOUT\[1\] = ({NUMBER}) / 24000\.0")
_WAIT = re.compile(rf"WAIT SEC ({NUMBER})")
_CHANGE = re.compile(r"HALT ;change to tool (\d+)")
STATES = ("cw", "ccw", "off", "wet", "dry")


def tokens(statements: Sequence[Statement]) -> list[Token]:
    """Events of statements that stand between two motions (comments left out); `?` for what is none."""
    lines = [s.text for s in statements if s.kind != "comment"]
    out: list[Token] = []
    k = 0
    while k < len(lines):
        found = _RPM.fullmatch(lines[k])
        if found and lines[k + 1 : k + 4] == ["$OUT[3] = FALSE", "$OUT[1] = TRUE", "WAIT SEC 3.0"]:
            out.append(("cw", float(found[1])))
            k += 4
        elif found and lines[k + 1 : k + 4] == ["$OUT[3] = TRUE", "$OUT[1] = TRUE", "WAIT SEC 3.0"]:
            out.append(("ccw", float(found[1])))
            k += 4
        elif lines[k : k + 2] == ["$OUT[1] = FALSE", "WAIT SEC 2.5"]:
            out.append(("off", 0.0))
            k += 2
        elif lines[k] == "$OUT[1] = FALSE ;end":
            out.append(("end-off", 0.0))
            k += 1
        elif lines[k] in ("$OUT[2] = TRUE", "$OUT[2] = FALSE", "$OUT[2] = FALSE ;end", "HALT"):
            kinds = {
                "$OUT[2] = TRUE": "wet",
                "$OUT[2] = FALSE": "dry",
                "HALT": "halt",
                "$OUT[2] = FALSE ;end": "end-dry",
            }
            out.append((kinds[lines[k]], 0.0))
            k += 1
        elif found := _WAIT.fullmatch(lines[k]):
            out += [("dwell", float(found[1]))] if float(found[1]) else []  # no time is no rest
            k += 1
        elif found := _CHANGE.fullmatch(lines[k]):
            out.append(("change", float(found[1])))
            k += 1
        else:
            out.append((f"? {lines[k]}", 0.0))
            k += 1
    return out


class Process:
    """Spindle, coolant and tool as events leave them."""

    def __init__(self) -> None:
        self.spindle: Token = ("off", 0.0)
        self.coolant = "dry"

    def take(self, token: Token) -> bool:
        """True where the event changes anything."""
        kind = token[0].removeprefix("end-")
        before = self.spindle, self.coolant
        if kind in ("cw", "ccw", "off"):
            self.spindle = (kind, token[1])
        elif kind in ("wet", "dry"):
            self.coolant = kind
        return kind not in STATES or before != (self.spindle, self.coolant)

    @property
    def turning(self) -> bool:
        return self.spindle[0] != "off"


def differ(wanted: Sequence[Token], found: Sequence[Token], state: Process) -> str:
    """What is wrong with the events found in a place, empty where nothing is; `state` is taken to its end.

    A program may leave out an event that changes nothing, switch off once more what is off, and may switch spindle and coolant
    off before a tool change, and the spindle before it turns the other way.
    """
    left = _telling(found, state)
    for k, want in enumerate(wanted):
        if want[0] == "change":
            while left and left[0][0] in ("off", "dry") and _switches(left[0], state):
                state.take(left.pop(0))
            if state.turning:
                return f"a change to tool {want[1]:g} with the spindle on"
        if want[0] in ("cw", "ccw") and state.turning and state.spindle[0] != want[0] and left and left[0][0] == "off":
            state.take(left.pop(0))
        if left and left[0][0] == want[0] and abs(left[0][1] - want[1]) <= 1e-6:
            state.take(left.pop(0))
        elif want[0] in STATES and not _switches(want, state):
            continue
        else:
            return f"event {want} is lost, late or of another value: wanted {list(wanted)}, found {list(found)} ({k})"
    if left:
        return f"events {left} are not the file's: wanted {list(wanted)}"
    return ""


def _telling(found: Sequence[Token], state: Process) -> list[Token]:
    """Without what switches off once more what is off already."""
    probe, out = Process(), list[Token]()
    probe.spindle, probe.coolant = state.spindle, state.coolant
    for token in found:
        if probe.take(token) or token[0] not in ("off", "dry"):
            out.append(token)
    return out


def _switches(token: Token, state: Process) -> bool:
    probe = Process()
    probe.spindle, probe.coolant = state.spindle, state.coolant
    return probe.take(token)
