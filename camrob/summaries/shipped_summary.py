"""What `camrob cell` and `camrob samples` say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from camrob.summaries.base import Summary

__all__ = [
    "CellCheckSummary",
    "CellListSummary",
    "CheckedPose",
    "ConditionSummary",
    "ListedCell",
    "ListedSample",
    "NewCellSummary",
    "SamplesSummary",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class ListedCell(Summary):
    """A cell that comes with camrob: its folder, and the sections of cell.toml without which some verbs refuse it."""

    name: str
    title: str
    folder: str
    axes: tuple[str, ...]
    controller: bool
    resolve: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class CellListSummary(Summary):
    """The cells that come with camrob."""

    cells: tuple[ListedCell, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckedPose(Summary):
    """A row of poses.csv: how far forward kinematics of its axis values is from its pose; text: what is wrong, "" if nothing."""

    name: str
    line: int
    position_error_mm: float
    orientation_error_deg: float
    ok: bool
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class CellCheckSummary(Summary):
    """How a cell meets its poses: ok is None where it has none. provenance: how many entries of cell.toml have which.

    The largest errors are None where there is no pose. assumed: the entries that nobody has measured or read, by their keys.
    bare: stretches of the arm that no body covers, a sentence each. home: bodies that touch at HOME, likewise.
    length: what is wrong with the characteristic length, coupled: which axes the controller counts together; "" if nothing.
    """

    cell: str
    ok: bool | None
    position_bound_mm: float
    orientation_bound_deg: float
    position_error_mm_max: float | None
    orientation_error_deg_max: float | None
    poses: tuple[CheckedPose, ...]
    provenance: Mapping[str, int]
    assumed: tuple[str, ...]
    bare: tuple[str, ...] = ()
    home: tuple[str, ...] = ()
    length: str = ""
    coupled: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionSummary(Summary):
    """The arm's best-conditioned posture, axis values in mm and degrees, and the characteristic length that goes with it.

    kf: the condition number there, 1 is ideal. stated_mm: what cell.toml has for the length. home_inv_kf: 1/k_F at HOME.
    """

    cell: str
    characteristic_length_mm: float
    stated_mm: float
    kf: float
    inv_kf: float
    posture: Mapping[str, float]
    home_inv_kf: float


@dataclass(frozen=True, slots=True, kw_only=True)
class NewCellSummary(Summary):
    """A folder that was made for a cell: its files, the cell's axes, and what to do next, a sentence each."""

    name: str
    folder: str
    files: tuple[str, ...]
    axes: tuple[str, ...]
    next: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class ListedSample(Summary):
    """A sample: its folder, its CL file there, and the first line of its README."""

    name: str
    folder: str
    clfile: str
    title: str


@dataclass(frozen=True, slots=True, kw_only=True)
class SamplesSummary(Summary):
    """The samples that come with camrob, or their copies, which `copied` says."""

    samples: tuple[ListedSample, ...]
    copied: bool
