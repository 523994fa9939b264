"""What a robot language has to be able to do: the seam between programs and the text that a controller runs.

Reader and writer of a language share nothing but this protocol and the data types of `camrob.program`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camrob.cell.controller_settings import ControllerSettings
from camrob.findings import Finding
from camrob.program.motion import Blend, Turning
from camrob.program.program import Program
from camrob.program.program_text import ProgramAction, ProgramText

__all__ = ["AddedTarget", "Language", "MeantActions", "NewTarget", "Rounding"]


@dataclass(frozen=True, slots=True)
class MeantActions:
    """What the text of a program has to do beside moving, as the language's reader tells it.

    opening: statements before all else, in any order. rest: in their order. No frames and no speeds, which motions are held to.
    blend: how targets are rounded off, those that are.
    """

    opening: tuple[str, ...]
    rest: tuple[ProgramAction, ...]
    blend: Blend = Blend.DISTANCE


@dataclass(frozen=True, slots=True)
class NewTarget:
    """A target's new numbers: X, Y, Z, A, B, C in mm and degrees, or with `by_axes` A1..A6 in degrees.

    turn: the axes' new turns, as the language's `turning` counts them, None where those that the target states stay.
    """

    values: tuple[float, ...]
    by_axes: bool
    turn: int | None = None


@dataclass(frozen=True, slots=True)
class AddedTarget:
    """A target within a line: X, Y, Z, A, B, C in mm and degrees, and the external axes by name in mm or degrees."""

    values: tuple[float, ...]
    external: Mapping[str, float]


class Rounding(Protocol):
    """What the decimals that a language prints leave of numbers. The results are what the text says, exactly."""

    def axes(self, axes: ArrayLike) -> NDArray[np.float64]:
        """A1..A6 (..., 6), degrees."""

    def external(self, external: ArrayLike) -> NDArray[np.float64]:
        """E1.. (..., E), mm and degrees."""

    def frame(self, xyzabc: ArrayLike) -> NDArray[np.float64]:
        """X, Y, Z, A, B, C (..., 6), mm and degrees, of a tool or a base."""

    def load(self, load: ArrayLike) -> NDArray[np.float64]:
        """Mass in kg and its centre X, Y, Z in mm (..., 4)."""

    def pose(self, pose: ArrayLike, external: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Targets (N, 6), mm and degrees, in their order along a path, and their external axes (N, E)."""

    def speed(self, speed: ArrayLike) -> NDArray[np.float64]:
        """Speeds along a path, m/s."""


class Language(Protocol):
    """A robot language.

    name: in cell.toml and in the registry. title: in messages. suffixes: of its files, the program's own first.
    round: the decimals that it prints.
    """

    @property
    def name(self) -> str:
        """The name in cell.toml and in the registry."""

    @property
    def title(self) -> str:
        """The name for people."""

    @property
    def suffixes(self) -> tuple[str, ...]:
        """Suffixes of its files, lower case: the program's first, then those of what belongs to it."""

    @property
    def round(self) -> Rounding:
        """What its decimals leave of numbers."""

    @property
    def turning(self) -> Turning:
        """How it counts the turns of the axes in a PTP to a pose."""

    @property
    def stops(self) -> bool:
        """Whether outputs and waits stop the robot at the target before them, also at one that is rounded off."""

    @property
    def naming(self) -> str:
        """What a program's name may hold, for people."""

    def program_name(self, text: str) -> str:
        """A program's name made of `text`, the text itself where it is one."""

    def settings(
        self, controller: ControllerSettings, *, follows_table: bool, home: Sequence[float] | None = None
    ) -> None:
        """Raise CellError where what a cell says of its controller is nothing that this language can print.

        follows_table: whether poses are read in a base that an axis of the workpiece turns. home: the cell's HOME, axis values
        in degrees and mm, where it is known.
        """

    def check(self, program: Program, controller: ControllerSettings) -> None:
        """Raise JobError for a program that can't be said in this language, ValueError for one that is no program."""

    def write(
        self,
        program: Program,
        controller: ControllerSettings,
        *,
        max_lines: int | None,
        findings: list[Finding] | None = None,
    ) -> Iterator[tuple[str, bytes]]:
        """The files of a program one after another, name and content.

        max_lines: motions of one file, None for the cell's. `findings` receives what a person should know. Raises as `check`.
        """

    def upload(self, name: str, files: Sequence[str], controller: ControllerSettings) -> Sequence[tuple[str, str]]:
        """Files of a program with their places on the controller, in the order of copying; none where no list is asked for."""

    def read(self, path: Path, controller: ControllerSettings | None = None) -> ProgramText:
        """A program from its main file and what belongs to it. Raises ProgramError, naming file and line.

        controller: where it is known, for what a program only names and the cell states.
        """

    def meant(self, program: Program, controller: ControllerSettings) -> MeantActions:
        """What the text of a program has to do beside moving."""

    def patch(self, text: str, targets: Mapping[int, Sequence[NewTarget]]) -> str:
        """The text with the targets of some lines (from 1) replaced, all else byte for byte. Raises ProgramError."""

    def divide(self, text: str, targets: Mapping[int, Sequence[AddedTarget]]) -> str:
        """The text with motions put before those of some lines (from 1), each a copy of it with other numbers, all else byte for
        byte. An external axis that the line does not name stands still. Raises ProgramError.
        """

    def headed(self, text: str, comments: Sequence[str]) -> str:
        """The text with lines of comment behind the line that names the program, all else byte for byte."""

    def targets(self, statement: str) -> int:
        """How many targets are written in a line, 0 for a named one or no motion."""
