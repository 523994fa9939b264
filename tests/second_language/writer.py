"""Writes programs line by line."""

from __future__ import annotations

import unicodedata

import numpy as np

from camrob.errors import JobError
from camrob.findings import Finding
from camrob.program.motion import Motion
from camrob.program.program import ProgramEventKind

SIX = ("advance", "ptp", "acc", "blend", "turn", "turnacc")


def plain(text):
    """One line of printable 7-bit characters, not too long."""
    spelled = unicodedata.normalize("NFKD", text)
    return " ".join("".join(c if c.isascii() and c.isprintable() else " " for c in spelled).split())[:200]


def numbers(values, decimals=5):
    return " ".join(f"{v + 0.0:.{decimals}f}" for v in np.round(values, decimals))


def check(program, controller):
    kind = np.asarray(program.kind)
    path = kind >= Motion.LIN
    for name, values in (("pose", program.pose), ("axes", program.axes), ("external", program.external)):
        if not np.isfinite(values).all() or not np.array_equal(np.round(values, 5), values):
            raise ValueError(f"{name} is not rounded")
    speed = np.round(np.asarray(program.speed)[path], 7)
    if not np.all(speed > 0.0):
        raise ValueError("a speed is no speed")
    via, end = kind == Motion.CIRC_VIA, kind == Motion.CIRC_END
    if len(kind) and (via[-1] or end[0] or not np.array_equal(via[:-1], end[1:])):
        raise ValueError("an arc lacks its middle or its end")
    if len(program.external_names) > 6:
        raise JobError("Lines takes six external axes at most")
    for event in program.events:
        if not 0 <= event.motion <= len(kind) or (event.motion < len(kind) and end[event.motion]):
            raise ValueError("an event stands within an arc")
        if event.kind is ProgramEventKind.TOOL and int(event.value) not in range(len(program.tools)):
            raise ValueError("a tool that the program does not hold")
        if event.kind is ProgramEventKind.LOAD and int(event.value) not in range(len(program.loads)):
            raise ValueError("a load that the program does not hold")
        if event.kind is ProgramEventKind.DWELL and not 0.0 <= event.value < 1e9:
            raise ValueError("a dwell is no time")
        if event.kind is ProgramEventKind.HOOK:
            controller.hook_lines(event.text, event.value)


def write(program, name, controller, max_lines, findings):
    """NAME.lines, and NAME001.lines and so on where the program is split at safe retracts."""
    check(program, controller)
    budget = controller.max_lines if max_lines is None else max_lines
    n = len(program)
    values = (
        controller.advance,
        controller.ptp_velocity_percent,
        controller.acc_cp,
        controller.apo_cdis_mm,
        controller.vel_ori_deg_s,
        controller.acc_ori_deg_s2,
    )
    head = [f"program {name}", *(f"# {plain(text)}" for text in program.comment)]
    head += [f"set {key} {value:.6f}" for key, value in zip(SIX, values, strict=True)]
    head += [f"base follows {numbers(program.base)}", f"tool {numbers(program.tool)}", *controller.hook_lines("header")]
    tail = [*controller.hook_lines("footer"), "end"]
    if n <= budget:
        yield f"{name}.lines", encoded([*head, *body(program, controller, 0, n, True), *tail])
        return
    ends = cuts(program, budget, findings)
    calls = [f"part {name}{k + 1:03d}" for k in range(len(ends))]
    yield f"{name}.lines", encoded([*head, *calls, *tail])
    for k, (start, end) in enumerate(zip([0, *ends[:-1]], ends, strict=True)):
        lines = body(program, controller, start, end, end == n)
        yield f"{name}{k + 1:03d}.lines", encoded([f"program {name}{k + 1:03d}", *lines, "end"])


def cuts(program, budget, findings):
    n, start, ends = len(program), 0, []
    whole = np.asarray(program.kind) != Motion.CIRC_VIA
    while start < n:
        last = min(n, start + budget)
        good = [k for k in range(start + 1, last + 1) if k == n or program.safe[k - 1]]
        fair = [k for k in range(start + 1, last + 1) if whole[k - 1]]
        if not fair:
            raise JobError("the program can't be split", line=int(program.line[start]))
        if not good and findings is not None:
            text = "a file of the program ends in the middle of a cut"
            findings.append(Finding("split-in-cut", text, line=int(program.line[fair[-1] - 1])))
        start = (good or fair)[-1]
        ends.append(start)
    return ends


def body(program, controller, start, end, last):
    events = {}
    for event in program.events:
        events.setdefault(event.motion, []).append(event)
    speed = None
    for row in range(start, end + 1):
        if row == end and not last:
            return
        for event in events.get(row, ()):
            yield from event_lines(program, event, controller)
        if row == end:
            return
        kind = Motion(int(program.kind[row]))
        external = numbers(program.external[row])
        if kind >= Motion.LIN and round(float(program.speed[row]), 7) != speed:
            speed = round(float(program.speed[row]), 7)
            yield f"speed {speed:.7f}"
        blend = " ~" if program.approximate[row] else ""
        if kind is Motion.PTP_AXES:
            yield f"axes {numbers(program.axes[row])} | {external}"
        elif kind is Motion.PTP_POSE:
            yield f"pose {numbers(program.pose[row])} | {program.status[row]} {program.turn[row]} | {external}"
        elif kind is Motion.LIN:
            yield f"line {numbers(program.pose[row])} | {external}{blend}"
        elif kind is Motion.CIRC_END:
            via = f"{numbers(program.pose[row - 1])} | {numbers(program.external[row - 1])}"
            yield f"arc {via} | {numbers(program.pose[row])} | {external}{blend}"


def event_lines(program, event, controller):
    if event.kind is ProgramEventKind.HOOK:
        yield from controller.hook_lines(event.text, event.value)
    elif event.kind is ProgramEventKind.DWELL:
        yield f"wait {event.value:.4f}"
    elif event.kind is ProgramEventKind.TOOL:
        yield f"tool {numbers(program.tools[int(event.value)])}"
    elif event.kind is ProgramEventKind.LOAD:
        yield f"load {numbers(program.loads[int(event.value)], 4)}"
    else:
        yield f"# {plain(event.text)}"


def encoded(lines):
    return "".join(line + "\n" for line in lines).encode("ascii")
