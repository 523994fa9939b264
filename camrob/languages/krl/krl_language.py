"""KRL behind the protocol of a language; reader and writer are loaded apart, and share nothing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from camrob.cell.controller_settings import ControllerSettings
from camrob.findings import Finding
from camrob.program.language import AddedTarget, Language, MeantActions, NewTarget, Rounding
from camrob.program.motion import Turning
from camrob.program.program import Program
from camrob.program.program_text import ProgramText

__all__ = ["LANGUAGE", "Krl"]


@dataclass(frozen=True)
class Krl:
    """The language; see `camrob.program.language.Language`."""

    name: str = "krl"
    title: str = "KRL"
    suffixes: tuple[str, ...] = (".src", ".dat")
    turning: Turning = Turning.SIGNS
    stops: bool = True  # what is no motion stops the advance run
    naming: str = "letters, digits and _, 24 at most"

    @property
    def round(self) -> Rounding:
        """KRL's decimals."""
        from camrob.languages.krl import rounding

        return rounding

    def program_name(self, text: str) -> str:
        """A letter, then letters, digits and _, 24 at most, no keyword."""
        from camrob.languages.krl.krl_text import krl_name

        return krl_name(text)

    def settings(
        self, controller: ControllerSettings, *, follows_table: bool, home: Sequence[float] | None = None
    ) -> None:
        """Raise CellError for settings that KRL lacks, a hook that does what camrob does, a base on another mechanism."""
        from camrob.languages.krl.krl_settings import krl_settings

        own = krl_settings(controller)
        own.check_base(follows_table=follows_table)
        if home is not None and own.customs.home_point is not None:
            own.customs.home_point.check(home)

    def check(self, program: Program, controller: ControllerSettings) -> None:
        """Raise ValueError for a program without a meaning in KRL, JobError for a line that gets too long."""
        from camrob.languages.krl.writer.body import KrlBody

        KrlBody(program, controller)

    def write(
        self,
        program: Program,
        controller: ControllerSettings,
        *,
        max_lines: int | None,
        findings: list[Finding] | None = None,
    ) -> Iterator[tuple[str, bytes]]:
        """NAME.src, NAME.dat, and where the program is split NAME_001.src and so on."""
        from camrob.languages.krl.writer.write_krl import iter_krl

        return iter_krl(program, controller, max_lines=max_lines, findings=findings)

    def upload(self, name: str, files: Sequence[str], controller: ControllerSettings) -> Sequence[tuple[str, str]]:
        """All into one folder of the program's name: what is called first, the program itself last, its data before it."""
        from camrob.languages.krl.krl_settings import krl_settings

        folder = krl_settings(controller).upload_folder
        last = [f"{name}{suffix}" for suffix in reversed(self.suffixes)]
        order = [*(file for file in files if file not in last), *(file for file in last if file in files)]
        return [(file, f"{folder}/{name}/{file}") for file in order] if folder else []

    def read(self, path: Path, controller: ControllerSettings | None = None) -> ProgramText:
        """A .src file with its .dat and the parts that it calls; HOME by its name where the cell states it."""
        from camrob.languages.krl.reader.known import controller_values
        from camrob.languages.krl.reader.read_krl import read_krl

        return read_krl(path, controller_values(controller))

    def meant(self, program: Program, controller: ControllerSettings) -> MeantActions:
        """The statements that a program opens with, and those of its hooks and waits."""
        from camrob.languages.krl.meant import meant_actions

        return meant_actions(program, controller)

    def patch(self, text: str, targets: Mapping[int, Sequence[NewTarget]]) -> str:
        """Other numbers in {...} of PTP, LIN and CIRC."""
        from camrob.languages.krl.patch import patch_source

        return patch_source(text, targets)

    def divide(self, text: str, targets: Mapping[int, Sequence[AddedTarget]]) -> str:
        """Copies of a LIN before it, with other numbers in {...}."""
        from camrob.languages.krl.patch import divide_source

        return divide_source(text, targets)

    def headed(self, text: str, comments: Sequence[str]) -> str:
        """Lines of comment behind DEF."""
        from camrob.languages.krl.patch import headed_source

        return headed_source(text, comments)

    def targets(self, statement: str) -> int:
        """How many {...} a motion has."""
        from camrob.languages.krl.patch import literal_targets

        return literal_targets(statement)


LANGUAGE: Language = Krl()
