"""A program with other targets, and everything else of its text byte for byte."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.controller.replay import Replay, base_offsets
from camrob.errors import ProgramError
from camrob.findings import Finding
from camrob.jobs.closing.tool_chains import tool_poses
from camrob.kinematics.frames import seen_by_program
from camrob.program.axis_turns import turn_fits, turn_of
from camrob.program.builder import printed_frames
from camrob.program.language import Language, NewTarget
from camrob.program.motion import Motion
from camrob.program.program_text import ProgramText
from camrob.se3 import inverse

__all__ = ["rewritten", "write_files"]

Array = NDArray[np.float64]


def _printed_poses(text: ProgramText, planned: Replay, q: Array) -> Array:
    """X .. C (N, 6), mm and degrees in the program's base, of the nominal robot in postures q (N, n)."""
    cell = planned.cell
    return printed_frames(inverse(base_offsets(text, cell)) @ seen_by_program(cell, q, tool_poses(planned, q)))


def rewritten(
    source: Path,
    language: Language,
    text: ProgramText,
    planned: Replay,
    q: Array,
    folder: Path,
    *,
    kept: NDArray[np.bool_],
    head: Sequence[str] = (),
) -> tuple[ProgramText, list[Finding]]:
    """Write a program with the targets that postures q (N, n) reach into a folder, all else byte for byte, and read it back.

    source: the main file, `text` what it holds and `planned` its replay. kept: (N,) motions whose targets stay as they are. head:
    lines of comment at the main file's head. Returns the program and what was left as it is. Raises
    ProgramError where a motion that runs several times would need different targets.
    """
    sources, left = _patched(source.parent, language, text, planned, q, kept)
    sources[source.name] = language.headed(sources[source.name], head)
    write_files(folder, source.parent, language, text, sources)
    return language.read(folder / source.name, planned.cell.controller_section), left


def _patched(
    folder: Path, language: Language, text: ProgramText, planned: Replay, q: Array, kept: NDArray[np.bool_]
) -> tuple[dict[str, str], list[Finding]]:
    """The files' new texts (latin-1), and what was left as it is."""
    poses = _printed_poses(text, planned, q)
    axes = planned.cell.to_axis_values(q)[:, :6]
    sources = {name: (folder / name).read_bytes().decode("latin-1") for name in text.files}
    lines = {name: source.split("\n") for name, source in sources.items()}
    wanted: dict[str, dict[int, list[NewTarget]]] = {name: {} for name in sources}
    warnings: list[Finding] = []
    table_of = {True: axes.tolist(), False: poses.tolist()}
    row = 0
    while row < len(text):
        count = 2 if text.kind[row] == Motion.CIRC_VIA else 1
        name, line = text.files[text.file[row]], int(text.line[row])
        by_axes = text.kind[row] == Motion.PTP_AXES
        if kept[row]:
            row += count
            continue
        if by_axes and language.targets(lines[name][line - 1]) == 0:
            warnings.append(Finding("left", "a PTP to a named posture is left as it is", line=line))
        else:
            table = table_of[bool(by_axes)]
            new = [
                NewTarget(tuple(table[row + k]), bool(by_axes), _new_turn(text, axes, row + k)) for k in range(count)
            ]
            old = wanted[name].setdefault(line, new)
            if _apart(old, new):
                what = "the motion runs several times and needs a different correction each time"
                raise ProgramError(what, hint="unroll the loop", path=folder / name, line=line)
        row += count
    for name, source in sources.items():
        try:
            sources[name] = language.patch(source, wanted[name])
        except ProgramError as error:
            raise error.at(folder / name) from None
    return sources, warnings


def _new_turn(text: ProgramText, axes: Array, row: int) -> int | None:
    """Turns of a corrected posture that are not those that its target states: an axis near 0 has changed its sign or quarter."""
    stated, at = int(text.turn[row]), axes[row : row + 1]
    return None if turn_fits(text.turning, stated, at)[0] else int(turn_of(text.turning, at)[0])


def _apart(old: list[NewTarget], new: list[NewTarget]) -> bool:
    """Whether two passes of one line ask for different targets."""
    both = zip(old, new, strict=True)
    return any(a.turn != b.turn or float(np.max(np.abs(np.subtract(a.values, b.values)))) > 1e-6 for a, b in both)


def write_files(folder: Path, origin: Path, language: Language, text: ProgramText, sources: Mapping[str, str]) -> None:
    """The program's files; data lists go along unchanged."""
    for name, source in sources.items():
        (folder / name).write_bytes(source.encode("latin-1"))
    stems = {Path(name).stem.lower() for name in text.files}
    for file in origin.iterdir():
        if file.suffix.lower() in language.suffixes[1:] and file.stem.lower() in stems and file.is_file():
            (folder / file.name).write_bytes(file.read_bytes())
