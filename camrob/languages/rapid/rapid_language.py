"""RAPID behind the protocol of a language; reader and writer are loaded apart, and share nothing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from camrob.cell.controller_settings import ControllerSettings
from camrob.errors import CellError
from camrob.findings import Finding
from camrob.program.language import AddedTarget, Language, MeantActions, NewTarget, Rounding
from camrob.program.motion import Turning
from camrob.program.program import Program
from camrob.program.program_text import ProgramText

__all__ = ["LANGUAGE", "Rapid"]


@dataclass(frozen=True)
class Rapid:
    """The language; see `camrob.program.language.Language`."""

    name: str = "rapid"
    title: str = "RAPID"
    suffixes: tuple[str, ...] = (".mod", ".pgf")
    turning: Turning = Turning.QUARTERS
    stops: bool = False  # only a fine point does
    naming: str = "letters, digits and _, 24 at most"

    @property
    def round(self) -> Rounding:
        """RAPID's decimals."""
        from camrob.languages.rapid import rapid_numbers

        return rapid_numbers

    def program_name(self, text: str) -> str:
        """A letter, then letters, digits and _, 24 at most, no word of RAPID's own."""
        from camrob.languages.rapid.rapid_text import rapid_name

        return rapid_name(text)

    def settings(
        self, controller: ControllerSettings, *, follows_table: bool, home: Sequence[float] | None = None
    ) -> None:
        """Raise CellError for settings that RAPID lacks, a hook that does what camrob does, a work object on nothing."""
        from camrob.languages.rapid.rapid_settings import check_hooks, rapid_settings

        own = rapid_settings(controller)
        check_hooks(controller)
        if follows_table and not own.mechanical_unit:
            hint = 'name the unit that turns the part: mechanical_unit = "STN1"'
            raise CellError("base_follows_table is true, but the work object stands still", hint=hint)
        if own.mechanical_unit and not follows_table:
            hint = "take mechanical_unit away, or set base_follows_table"
            raise CellError("mechanical_unit carries the work object, and base_follows_table is false", hint=hint)

    def check(self, program: Program, controller: ControllerSettings) -> None:
        """Raise ValueError for a program without a meaning in RAPID, JobError for what ABB does not take."""
        from camrob.languages.rapid.writer.write_rapid import check_rapid

        check_rapid(program, controller)

    def write(
        self,
        program: Program,
        controller: ControllerSettings,
        *,
        max_lines: int | None,
        findings: list[Finding] | None = None,
    ) -> Iterator[tuple[str, bytes]]:
        """NAME.mod, where the program is split NAME_001.mod and so on, and NAME.pgf that lists them."""
        from camrob.languages.rapid.writer.write_rapid import iter_rapid

        return iter_rapid(program, controller, max_lines=max_lines, findings=findings)

    def upload(self, name: str, files: Sequence[str], controller: ControllerSettings) -> Sequence[tuple[str, str]]:
        """None: NAME.pgf is the controller's own list of a program's modules."""
        return ()

    def read(self, path: Path, controller: ControllerSettings | None = None) -> ProgramText:
        """A .mod file, and the modules that the .pgf file beside it lists."""
        from camrob.languages.rapid.reader.read_rapid import read_rapid

        return read_rapid(path)

    def meant(self, program: Program, controller: ControllerSettings) -> MeantActions:
        """The statements that a program opens with, those of its hooks and waits, and what motions name first."""
        from camrob.languages.rapid.meant import meant_actions

        return meant_actions(program, controller)

    def patch(self, text: str, targets: Mapping[int, Sequence[NewTarget]]) -> str:
        """Other numbers in the targets of MoveAbsJ, MoveJ, MoveL and MoveC; the configuration stays."""
        from camrob.languages.rapid.patch import patch_module

        return patch_module(text, targets)

    def divide(self, text: str, targets: Mapping[int, Sequence[AddedTarget]]) -> str:
        """Copies of a MoveL before it, with other numbers in its target."""
        from camrob.languages.rapid.patch import divide_module

        return divide_module(text, targets)

    def headed(self, text: str, comments: Sequence[str]) -> str:
        """Lines of comment behind MODULE."""
        from camrob.languages.rapid.patch import headed_module

        return headed_module(text, comments)

    def targets(self, statement: str) -> int:
        """How many literal targets a motion's line has."""
        from camrob.languages.rapid.patch import literal_targets

        return literal_targets(statement)


LANGUAGE: Language = Rapid()
