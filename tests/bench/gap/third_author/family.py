"""The third author's family: its parts put together."""

from __future__ import annotations

from gap.second_author.family import Family
from gap.third_author import moves
from gap.third_author.cells import CELLS
from gap.third_author.drives import DRIVES
from gap.third_author.foreign import FOREIGN
from gap.third_author.gears import GEARS
from gap.third_author.instrument import INSTRUMENTS
from gap.third_author.leftovers import drive_leftover, leftover
from gap.third_author.structure import BODIES

KNOWN = [*DRIVES, *GEARS, *BODIES, *INSTRUMENTS]
FAMILY = Family("third", CELLS, KNOWN, FOREIGN, leftover, drive_leftover, moves.paths, moves.postures)
