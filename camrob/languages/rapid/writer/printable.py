"""What a program has to keep to be printed as RAPID."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.errors import JobError
from camrob.languages.rapid import rapid_numbers
from camrob.program.motion import Motion
from camrob.program.program import Program, ProgramEvent, ProgramEventKind
from camrob.units import rad_to_deg

__all__ = ["check_program"]

_LARGEST = 1e6  # mm or degrees: single precision, in which RAPID keeps numbers, has no tenths beyond
_SAME = 1e-9  # degrees: what the way from a quaternion to A, B, C and back leaves
_NEAREST = 0.1  # mm between the points of a MoveC (ABB's technical reference manual, MoveC: limitations)
_FLATTEST = 1.0  # degrees between its two points as its start sees them, likewise
_WIDEST = 240.0  # degrees that it turns at most, likewise
_BRANCHES = 8  # cfx: three bits


def check_program(program: Program, events: Mapping[int, Sequence[ProgramEvent]]) -> None:
    """Raises ValueError for a program without a meaning in RAPID, JobError for a circle that ABB does not take."""
    names = program.external_names
    if len(set(names)) != len(names) or not all(re.fullmatch("E[1-6]", name) for name in names):
        raise ValueError(f"external axes are named {names}, RAPID knows eax_a to eax_f: E1 to E6")
    _check_kinds(program)
    _check_numbers(program)
    _check_events(program, events)
    _check_circles(program)


def _check_kinds(program: Program) -> None:
    kind, count = program.kind, len(program)
    if not np.isin(kind, list(Motion)).all():
        raise ValueError("a motion is of no known kind")
    via, end = kind == Motion.CIRC_VIA, kind == Motion.CIRC_END
    if (count and (via[-1] or end[0])) or not np.array_equal(via[:-1], end[1:]):
        raise ValueError("a circle lacks its auxiliary point or its end")
    if np.any(program.approximate & ((kind < Motion.LIN) | via)):
        raise ValueError("only a line and the end of a circle can be rounded off")
    if np.any(program.safe & via):
        raise ValueError("an auxiliary point can't be a safe retract")
    posed = kind == Motion.PTP_POSE
    status = program.status[posed]
    if np.any((status < 0) | (status >= _BRANCHES) | (program.turn[posed] < 0)):
        raise ValueError("a PTP to a pose needs its branch and turns")


def _check_numbers(program: Program) -> None:
    """Everything finite, and with the decimals that are printed."""
    pose, external = rapid_numbers.pose(program.pose, program.external)
    pairs = (
        ("pose", program.pose, pose),
        ("external", program.external, external),
        ("axes", program.axes, rapid_numbers.axes(program.axes)),
        ("external", program.external, rapid_numbers.external(program.external)),
        ("tool", program.tool, rapid_numbers.frame(program.tool)),
        ("base", program.base, rapid_numbers.frame(program.base)),
        ("tools", program.tools, rapid_numbers.frame(program.tools)),
    )
    for name, values, rounded in pairs:
        if not np.all(np.abs(values) < _LARGEST):
            raise ValueError(f"{name} holds a value that is not finite or too large")
        if not np.all(np.abs(values - rounded) <= _SAME):
            raise ValueError(f"{name} holds a value with more decimals than are printed")
    speed = program.speed[program.kind >= Motion.LIN]
    if not np.all((speed > 0.0) & (speed < _LARGEST)) or not np.all(rapid_numbers.speed(speed) == speed):
        raise ValueError("a speed is none, or has more decimals than are printed")


def _check_events(program: Program, events: Mapping[int, Sequence[ProgramEvent]]) -> None:
    count, end = len(program), program.kind == Motion.CIRC_END
    for at, some in events.items():
        if not 0 <= at <= count or (at < count and end[at]):
            raise ValueError(f"an event stands at {at}, which is not a place between the {count} motions")
        acts = any(e.kind in (ProgramEventKind.HOOK, ProgramEventKind.DWELL) for e in some)
        if acts and at and program.approximate[at - 1]:
            raise ValueError(
                f"something happens behind motion {at - 1}, which is rounded off: RAPID does not wait for the robot"
            )
        for event in some:
            if event.kind is ProgramEventKind.TOOL and int(event.value) not in range(len(program.tools)):
                raise ValueError(f"before motion {at} a tool is mounted that the program does not hold")
            if event.kind is ProgramEventKind.LOAD:
                known = int(event.value) in range(len(program.loads))
                if not known or not _is_load(program.loads[int(event.value)]):
                    raise ValueError(
                        f"before motion {at} a load is set that the program does not hold, or that is none"
                    )
            if event.kind is ProgramEventKind.DWELL and not 0.0 <= event.value < _LARGEST:
                raise ValueError(f"the dwell before motion {at} is not a time")


def _check_circles(program: Program) -> None:
    """Raises JobError for a circle that is too small, too flat or too long for MoveC."""
    end = np.flatnonzero(program.kind == Motion.CIRC_END)
    end = end[(end >= 2) & (program.kind[np.maximum(end - 2, 0)] != Motion.PTP_AXES)]
    start, via, last = (program.pose[end - k, :3] for k in (2, 1, 0))
    out, home, rest = via - start, last - start, last - via
    with np.errstate(invalid="ignore", divide="ignore"):
        near = np.min([np.linalg.norm(v, axis=1) for v in (out, home, rest)], axis=0, initial=np.inf)
        seen = rad_to_deg(np.arccos(np.clip(_cosine(out, home), -1.0, 1.0)))
        turned = 360.0 - 2.0 * rad_to_deg(
            np.arccos(np.clip(_cosine(out, -rest), -1.0, 1.0))
        )  # the angle at via, inscribed
    for wrong, what in (
        (near < _NEAREST, f"has points nearer than {_NEAREST} mm"),
        (seen < _FLATTEST, f"is flatter than {_FLATTEST:g} degree as its start sees it"),
        (turned > _WIDEST, f"turns more than {_WIDEST:g} degrees"),
    ):
        if wrong.any():
            line = int(program.line[end[int(np.argmax(wrong))]])
            raise JobError(
                f"a circle {what}, which MoveC does not take; write it as lines in the CAM system", line=line
            )


def _cosine(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of the angle between the rows of two arrays."""
    return np.asarray(np.sum(a * b, axis=1) / (np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1)))


def _is_load(load: NDArray[np.float64]) -> bool:
    """Whether a load (7,) is one: finite, and a mass above zero."""
    return bool(np.all(np.abs(load) < _LARGEST) and load[0] > 0.0)
