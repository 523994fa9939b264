"""The bench's jobs: small CL files of its own making, each with the story of what must come out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mutation import cells
from mutation.bodies import Body
from mutation.story import Story
from mutation.truth import UNSTATED_RAPID, Rules

PLACE = "part_in_base = [0, 0, 200, 0, 0, 0]\n"


@dataclass(frozen=True)
class Job:
    """One posting. refuse: nothing may be released, whatever it is. story None: with `refuse` only.

    options: of `post`. before: a job whose program lies in the folder already. beside: files that the
    set-up names, by their names. pending: why today's program is not right.
    """

    name: str
    file: str
    text: str
    story: Story | None = None
    setup: str | None = PLACE
    cell: str = "kr15"
    options: Mapping[str, Any] = field(default_factory=dict)
    refuse: bool = False
    before: str = ""
    rapid: float = UNSTATED_RAPID
    slower: bool = False
    decimate: float = 0.0
    tool: tuple[float, float] | None = None
    part: Body | None = None
    beside: Mapping[str, str] = field(default_factory=dict)

    @property
    def program(self) -> str:
        """The program's name."""
        return self.file.split(".")[0]

    def write(self, folder: Path) -> Path:
        """The CL file with its set-up, in a folder of its own."""
        folder.mkdir(parents=True)
        (folder / self.file).write_text(self.text, encoding="utf-8", newline="")
        if self.setup is not None:
            (folder / "setup.toml").write_text(self.setup, encoding="utf-8")
        for name, text in self.beside.items():
            (folder / name).write_text(text, encoding="utf-8")
        return folder / self.file

    def rules(self) -> Rules | None:
        """What the judge holds the program to; None where nothing can be right."""
        if self.story is None:
            return None
        bodies = cells.bodies(self.cell, self.tool, self.part)
        return Rules(self.story, cells.machine(self.cell), bodies, self.rapid, self.slower, self.decimate)


def all_jobs() -> dict[str, Job]:
    """Every job by its name."""
    from mutation import (
        jobs_apt,
        jobs_controls,
        jobs_found,
        jobs_frames,
        jobs_gcode,
        jobs_newest,
        jobs_ordinary,
        jobs_posted,
        jobs_refuse,
        jobs_shops,
        jobs_ways,
    )

    found = [
        *jobs_apt.jobs(),
        *jobs_gcode.jobs(),
        *jobs_controls.jobs(),
        *jobs_found.jobs(),
        *jobs_frames.jobs(),
        *jobs_newest.jobs(),
        *jobs_ordinary.jobs(),
        *jobs_posted.jobs(),
        *jobs_ways.jobs(),
        *jobs_refuse.jobs(),
        *jobs_shops.jobs(),
    ]
    names = [job.name for job in found]
    if len(set(names)) != len(names):
        raise ValueError("two jobs of one name")
    return {job.name: job for job in found}
