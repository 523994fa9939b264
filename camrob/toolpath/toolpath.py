"""A toolpath: the regions of one CL file, with what its reader had to say."""

from __future__ import annotations

from dataclasses import dataclass, field

from camrob.findings import Finding
from camrob.frozen import digest
from camrob.toolpath.region import Region

__all__ = ["Tool", "Toolpath"]


@dataclass(frozen=True, slots=True)
class Tool:
    """A cutter as the CL file describes it: lengths in metres, 0.0 where the file is silent."""

    number: int
    name: str = ""
    diameter: float = 0.0
    corner_radius: float = 0.0
    length: float = 0.0


@dataclass(frozen=True, slots=True)
class Toolpath:
    """What the part wants: regions in machining order, in the part's frame.

    `source` is the file's name, `sha256` that of its bytes, `dialect` e.g. "nx-clsf", `units` "mm" or "inch" (as read;
    the regions are in metres whatever it was). `chord_tolerance` (m) is what arcs and curves were cut with.
    `findings` holds what could not be honoured, once a kind.
    """

    regions: tuple[Region, ...]
    source: str
    sha256: str
    dialect: str
    units: str = "mm"
    tools: tuple[Tool, ...] = field(default=())
    findings: tuple[Finding, ...] = field(default=())
    chord_tolerance: float = 0.0

    @property
    def points(self) -> int:
        """Number of points of all regions."""
        return sum(len(region) for region in self.regions)

    @property
    def digest(self) -> str:
        """What the points are, whatever file they came from."""
        parts = [(r.position, r.axis, r.feed, r.move) for r in self.regions]
        return digest(*(a for part in parts for a in part))
