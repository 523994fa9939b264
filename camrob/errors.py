"""The whole error tree.

CamrobError
├── InputError            the command line or an input is wrong (exit status 2)
│   ├── CellError         cell.toml, poses.csv, .fis
│   ├── SetupError        setup.toml
│   ├── ToolpathError     CL data and G-code
│   ├── ProgramError      a robot's program that can't be read, or be run as it is
│   │   └── KrlError      one in KRL
│   └── LogError          a measurement log or a calibration file
├── JobError              the job can't be done safely (exit status 3)
│   ├── UnreachableError  a pose outside the arm's reach
│   ├── LimitError        an axis would pass its limit
│   ├── SingularError     the path runs through a singular posture
│   ├── CollisionError    something touches something
│   └── VerificationError read-back or replay of the program deviates
└── StaleInputError       results handed together that do not belong together
"""

from __future__ import annotations

from pathlib import Path
from typing import Self

from camrob.text import one_line

__all__ = [
    "CamrobError",
    "CellError",
    "CollisionError",
    "InputError",
    "JobError",
    "KrlError",
    "LimitError",
    "LogError",
    "ProgramError",
    "SetupError",
    "SingularError",
    "StaleInputError",
    "ToolpathError",
    "UnreachableError",
    "VerificationError",
]


# characters of a message's parts: whatever an input file held, a message can be read on a terminal
_WHAT = 700
_HINT = 500
_NAME = 200
_PATH = 4200  # more than a path may have: a place is named whole


class CamrobError(Exception):
    """Root of everything that camrob raises on purpose."""


class InputError(CamrobError):
    """An input is wrong: names the file, the line, what is wrong and what to do.

    Attributes: `path` (or None), `line` (1-based, 0 where a line has no meaning), `what`, `hint`.
    """

    def __init__(self, what: str, *, hint: str = "", path: str | Path | None = None, line: int = 0) -> None:
        self.path = None if path is None else Path(path)
        self.line = line
        self.what = one_line(what, _WHAT)
        self.hint = one_line(hint, _HINT)
        super().__init__(str(self))

    def __str__(self) -> str:
        where = (
            "" if self.path is None else one_line(str(self.path), _PATH) + (f":{self.line}" if self.line else "") + ": "
        )
        return where + self.what + (f"; {self.hint}" if self.hint else "")

    def at(self, path: str | Path, line: int = 0) -> InputError:
        """The same error with its place, where it had none yet."""
        return type(self)(self.what, hint=self.hint, path=self.path or path, line=self.line or line)


class CellError(InputError):
    """A cell's folder is wrong."""


class SetupError(InputError):
    """A set-up file is wrong."""


class ToolpathError(InputError):
    """CL data or G-code that can't be read honestly."""


class ProgramError(InputError):
    """A robot's program that can't be read, or that no controller would run as it is."""


class KrlError(ProgramError):
    """A KRL program that can't be read."""


class LogError(InputError):
    """A measurement log, or a file made from one, is wrong."""


def _plain(value: float) -> str:
    """A figure to three places, without the noughts behind it: 300 rev/min, 0.956 degrees."""
    text = f"{value:.3f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


class JobError(CamrobError):
    """The job can't be done safely.

    Attributes: `what`, `line` (of the CL file, or `of_program` of the robot's program; 0 if none), `region` (name or ""),
    `axis` ("" if none), `value` and `limit` in `unit` (None where they have no meaning), `reasons` (a tally: text to count).
    """

    def __init__(
        self,
        what: str,
        *,
        line: int = 0,
        region: str = "",
        axis: str = "",
        value: float | None = None,
        limit: float | None = None,
        unit: str = "",
        reasons: dict[str, int] | None = None,
        of_program: bool = False,
    ) -> None:
        self.what = one_line(what, _WHAT)
        self.line = line
        self.of_program = of_program
        self.region = one_line(region, _NAME)
        self.axis = axis
        self.value = value
        self.limit = limit
        self.unit = unit
        self.reasons = dict(reasons or {})
        super().__init__(str(self))

    def but(self, what: str, *, region: str | None = None) -> Self:
        """The same error in other words, and with another region where one is given."""
        return type(self)(
            what,
            line=self.line,
            region=self.region if region is None else region,
            axis=self.axis,
            value=self.value,
            limit=self.limit,
            unit=self.unit,
            reasons=self.reasons,
            of_program=self.of_program,
        )

    def __str__(self) -> str:
        parts = [self.what]
        if self.line:
            parts.append(f"{'program' if self.of_program else 'CL'} line {self.line}")
        if self.region:
            parts.append(f"region {self.region}")
        if self.axis:
            parts.append(f"axis {self.axis}")
        if self.value is not None:
            text = f"{_plain(self.value)} {self.unit}".rstrip()
            if self.limit is not None:
                text += f" where the limit is {_plain(self.limit)} {self.unit}".rstrip()
            parts.append(text)
        if self.reasons:
            total = sum(self.reasons.values())
            parts.append(f"{total} candidates: " + ", ".join(f"{n} {why}" for why, n in self.reasons.items()))
        return "; ".join(parts)


class UnreachableError(JobError):
    """A pose that the arm can't reach."""


class LimitError(JobError):
    """An axis would have to pass its limit."""


class SingularError(JobError):
    """The path runs through a posture in which the arm loses a direction."""


class CollisionError(JobError):
    """A body of the cell touches another."""


class VerificationError(JobError):
    """The program, read back and replayed, does not do what was asked."""


class StaleInputError(CamrobError):
    """Results were handed together that were not made from the same inputs."""
