"""Targets added within a program's lines, where the correction would have to change more quickly than between two targets."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.controller.replay import Replay, base_offsets
from camrob.controller.simulate import CYCLE
from camrob.errors import ProgramError
from camrob.jobs.closing.diagnosed_machine import MachineRun
from camrob.jobs.closing.rewrite import write_files
from camrob.kinematics.frames import seen_by_program
from camrob.program.builder import printed_frames
from camrob.program.language import AddedTarget, Language
from camrob.program.motion import Blend, Motion
from camrob.program.program_text import ProgramText
from camrob.se3 import inverse, slerp

__all__ = ["lines_added", "meant_rows", "places_to_add", "with_targets_added"]

Array = NDArray[np.float64]
Places = Mapping[int, Sequence[float]]

_WORTH = 1e-5  # m that a straight correction is off: less than half of what any arm of this kind repeats to
_NEAREST = 2e-4  # m between targets: what a controller rounds off at the least
_TURNS = 12  # of adding one target a line where the correction is worst: more than a correction of play needs


def places_to_add(run: MachineRun, language: Language, folder: Path) -> dict[int, list[float]]:
    """Shares of the program's lines at which a target more would let the correction follow what has to be corrected.

    Of the lines only those that cut, whose target is written in the statement, which run once, are not stopped behind, and before
    which the program does nothing else: a line that is divided is the same line then. A file gets no more than the cell's
    controller takes. folder: of the program's files.
    """
    program, way, twist = run.program, run.way, run.beyond_constants
    spacing = np.maximum(_NEAREST, CYCLE * np.nan_to_num(np.asarray(program.speed)))[way.motion]
    divisible = (_divisible(program, language, folder) & run.machine.cuts(program))[way.motion]
    whole, file = way.share(), np.asarray(program.file)
    room = _room(run, folder)
    places: dict[int, list[float]] = {}
    for _turn in range(_TURNS):
        finer = way.split(places)
        off = np.linalg.norm((twist - finer.between(finer.fit(twist)))[:, :3], axis=1)
        share = finer.share()
        away = np.minimum(share, 1.0 - share) * finer.length()[finer.motion]
        rows = np.flatnonzero((off > _WORTH) & divisible & (away >= spacing))
        # the worst row of each piece of a line
        rows = rows[np.lexsort([off[rows], finer.motion[rows]])]
        rows = rows[np.append(np.diff(finer.motion[rows]) > 0, True)] if len(rows) else rows
        rows = rows[np.argsort(-off[rows])]
        added = False
        for m, s in zip(way.motion[rows].tolist(), whole[rows].tolist(), strict=True):
            if room[int(file[m])] > 0:
                places[m] = sorted([*places.get(m, ()), s])
                room[int(file[m])] -= 1
                added = True
        if not added:
            break
    return places


def _room(run: MachineRun, folder: Path) -> dict[int, int]:
    """How many motions more each of a program's files may hold, by what the cell says of its controller."""
    limits = run.cell.controller_section
    most = (sys.maxsize, sys.maxsize) if limits is None else (limits.max_lines, limits.max_bytes)
    out = {}
    for f, name in enumerate(run.program.files):
        text = (folder / name).read_bytes()
        longest = max(map(len, text.split(b"\n"))) + 1
        motions = most[0] - int(np.sum(np.asarray(run.program.file) == f))
        out[f] = max(min(motions, (most[1] - len(text)) // longest), 0)
    return out


def _divisible(program: ProgramText, language: Language, folder: Path) -> NDArray[np.bool_]:
    """(M,) whether each motion may be divided."""
    lines = {name: (folder / name).read_bytes().decode("latin-1").split("\n") for name in program.files}
    at = list(zip(np.asarray(program.file).tolist(), np.asarray(program.line).tolist(), strict=True))
    runs = Counter(at)
    acts = {action.motion for action in program.actions}
    out = (np.asarray(program.kind) == Motion.LIN) & (np.asarray(program.blend) != Blend.EXACT)
    out[0] = False
    for row in np.flatnonzero(out):
        file, line = at[row]
        written = language.targets(lines[program.files[file]][line - 1]) == 1
        out[row] = written and runs[at[row]] == 1 and int(row) not in acts
    return np.asarray(out)


def with_targets_added(
    source: Path, language: Language, program: ProgramText, planned: Replay, places: Places, folder: Path
) -> Path:
    """Write a program whose lines end at some shares of them (`places_to_add`) too into a folder; its main file there.

    It leads the tool along the same lines: between two targets pose and external axes go evenly.
    """
    poses = seen_by_program(planned.cell, np.asarray(planned.q), np.asarray(planned.base_T_tool))
    axes = [planned.cell.axis_names.index(name) for name in program.external_names]
    external = planned.cell.to_axis_values(np.asarray(planned.q))[:, axes]
    offsets = base_offsets(program, planned.cell)
    added: dict[str, dict[int, list[AddedTarget]]] = {name: {} for name in program.files}
    for m, shares in places.items():
        for s in shares:
            before, here = poses[m - 1], poses[m].copy()
            here[:3, 3] = before[:3, 3] + s * (here[:3, 3] - before[:3, 3])
            here[:3, :3] = slerp(before[:3, :3], here[:3, :3], s)
            values = printed_frames(inverse(offsets[m]) @ here)
            carried = external[m - 1] + s * (external[m] - external[m - 1])
            added[program.files[program.file[m]]].setdefault(int(program.line[m]), []).append(
                AddedTarget(tuple(values.tolist()), dict(zip(program.external_names, carried.tolist(), strict=True)))
            )
    sources = {}
    for name, wanted in added.items():
        text = (source.parent / name).read_bytes().decode("latin-1")
        try:
            sources[name] = language.divide(text, wanted)
        except ProgramError as error:
            raise error.at(source.parent / name) from None
    write_files(folder, source.parent, language, program, sources)
    return folder / source.name


def lines_added(program: ProgramText, places: Places) -> dict[str, tuple[int, ...]]:
    """By file, the lines that hold the added targets once `program` is divided at these places."""
    out: dict[str, list[int]] = {}
    for m in sorted(places, key=lambda m: (int(program.file[m]), int(program.line[m]))):
        lines = out.setdefault(program.files[program.file[m]], [])
        first = int(program.line[m]) + len(lines)
        lines += range(first, first + len(places[m]))
    return {name: tuple(lines) for name, lines in out.items()}


def meant_rows(program: ProgramText, added: Mapping[str, Sequence[int]]) -> NDArray[np.int64]:
    """(M,) which motion of the undivided program each motion of the divided one is part of. added: its lines by file."""
    lines = {(name, line) for name, those in added.items() for line in those}
    at = zip(np.asarray(program.file).tolist(), np.asarray(program.line).tolist(), strict=True)
    kept = np.array([(program.files[file], line) not in lines for file, line in at], np.int64)
    return np.asarray(np.cumsum(kept) - kept)
