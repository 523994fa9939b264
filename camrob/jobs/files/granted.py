"""What a job takes for granted because nobody said it: warnings that its user reads before all others."""

from __future__ import annotations

import re

import numpy as np

from camrob.cell.cell import Cell
from camrob.cell.setup import Setup
from camrob.checks.rapids import rapids_in_stock
from camrob.findings import Finding
from camrob.se3 import xyzabc_from_frame
from camrob.toolpath.toolpath import Toolpath
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["assumed_limits", "taken_for_granted"]

# mm; numbers below it are metres at a glance: no part stands farther than 3 m from the table's middle
_METRES = 3.0
_OUTWEIGHS = 10.0  # and the part is this many times larger than the way to it


def taken_for_granted(cell: Cell, setup: Setup, toolpath: Toolpath) -> tuple[Finding, ...]:
    """No set-up, a part placed in metres by the look of it, no bodies to collide with, rapids into the stock."""
    found = [_no_setup(cell, setup), _in_metres(setup, toolpath), _no_bodies(cell), _rapids(setup, toolpath)]
    return tuple(f for f in found if f is not None)


def _rapids(setup: Setup, toolpath: Toolpath) -> Finding | None:
    """Rapids of the file into a stock that the set-up gives as a box."""
    if setup.stock is None or setup.stock.mesh is not None:
        return None
    widths = [t.diameter for t in setup.tools] + [t.diameter for t in toolpath.tools]
    box = np.stack([np.asarray(setup.stock.lower), np.asarray(setup.stock.upper)])
    return rapids_in_stock(toolpath.regions, box, max(widths, default=0.0))


def _no_setup(cell: Cell, setup: Setup) -> Finding | None:
    """What stands in for a set-up that there is none of."""
    if setup.path is not None:
        return None
    frame = xyzabc_from_frame(np.asarray(cell.flange_T_tool))
    numbers = [*m_to_mm(frame[:3]), *rad_to_deg(frame[3:])]
    tool = " ".join(f"{n} {v:.3f}" for n, v in zip("XYZABC", np.round(numbers, 3) + 0.0, strict=True))
    text = (
        f"no set-up: the part's frame is taken for base itself, the tool for the cell's own ({tool}), and there is"
        " neither part nor stock to collide with; write setup.toml beside the CL file, or give --setup"
    )
    return Finding("no-setup", text)


def _in_metres(setup: Setup, toolpath: Toolpath) -> Finding | None:
    """Numbers of `part_in_base` that are not all whole, all tiny beside the part, and make sense as metres."""
    place = m_to_mm(np.asarray(setup.base_T_part)[:3, 3])
    far = float(np.abs(place).max())
    points = [r.position for r in toolpath.regions if len(r)]
    size = float(m_to_mm(np.ptp(np.concatenate(points), axis=0).max())) if points else 0.0
    whole = np.allclose(place, np.round(place), rtol=0.0, atol=1e-9)
    if not 0.0 < far < _METRES or whole or size < _OUTWEIGHS * far:
        return None
    given = ", ".join(f"{v:.4g}" for v in place)
    text = f"part_in_base = [{given}, ...] looks like metres (the path is {size:.0f} mm wide): X, Y, Z are in mm"
    return Finding("part-in-metres", text, value=far, unit="mm")


def _no_bodies(cell: Cell) -> Finding | None:
    """A cell that nothing can collide with."""
    if cell.shapes:
        return None
    text = "the cell describes no bodies: collisions are not checked; add [[shape]]s to its cell.toml"
    return Finding("no-bodies", text)


def assumed_limits(cell: Cell) -> tuple[Finding, ...]:
    """One warning that names the limits that are only assumed."""
    assumed = [re.fullmatch(r"joint\[(\w+)\]\.limits\..*", key) for key, s in cell.provenance.items() if s == "assumed"]
    names = sorted({match[1] for match in assumed if match})
    if not names:
        return ()
    text = f"limits of {', '.join(names)} are assumed, not taken from the machine: check them against its data sheets"
    return (Finding("assumed-limits", text),)
