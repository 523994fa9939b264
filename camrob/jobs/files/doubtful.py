"""Numbers of a cell and of a set-up that are of another unit by the look of them, or that can't both be true: warnings."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from camrob.cell.cell import Cell
from camrob.cell.joint import Joint, Role
from camrob.cell.setup import Setup, ToolSetup
from camrob.findings import Finding
from camrob.toolpath.toolpath import Toolpath
from camrob.units import deg_to_rad, m_s_to_mm_min, m_to_mm, mm_to_m

__all__ = ["doubtful_cell", "doubtful_setup"]

_RADIANS = deg_to_rad(4.0 * np.pi)  # two turns in radians, read as degrees: no axis of an arm has so little way
_SLOW = deg_to_rad(10.0)  # a second: the slowest axes of the heaviest arms make five times as much
_METRES = mm_to_m(20.0)  # of way, and a second: no track is as short, or as slow
_LEAST_CLEARANCE = mm_to_m(1.0)  # that somebody lifts a tool by
_LEAST_REACH = mm_to_m(3.0)  # from the plate to a tip: what is nearer, and no zero, is in metres
_REVERSED = -0.5  # cosine between a tool's z and the way from its tip to the plate: an angle head's is hardly below 0
_WIDE = 2.0  # m: in mm such a path were 80 wide, as most are


def doubtful_cell(cell: Cell, setup: Setup) -> tuple[Finding, ...]:
    """Limits in radians or metres, and more on the flange than the arm carries."""
    return (*(f for joint in cell.joints for f in _limits(joint)), *_load(cell, setup))


def _limits(joint: Joint) -> Iterator[Finding]:
    """The range and the speed of a real axis."""
    if joint.role is Role.ROLL or (joint.role is Role.WORKPIECE and not joint.prismatic):
        return  # a table may turn as slowly, and as little, as it likes
    unit, other = joint.unit_word, "metres" if joint.prismatic else "radians"
    least_way, least_speed = (_METRES, _METRES) if joint.prismatic else (_RADIANS, _SLOW)
    hint = f"looks like {other}: cell.toml gives {unit}"
    if joint.upper - joint.lower < least_way:
        lower, upper = joint.to_edge(joint.lower), joint.to_edge(joint.upper)
        text = f"the range of {joint.name}, {lower:.4g} to {upper:.4g}, {hint}"
        yield Finding("limit-unit", text, axis=joint.name, value=upper - lower, unit=unit)
    if joint.speed < least_speed:
        speed = joint.to_edge(joint.speed)
        yield Finding("limit-unit", f"the speed of {joint.name}, {speed:.4g}, {hint} a second", axis=joint.name)


def _load(cell: Cell, setup: Setup) -> Iterator[Finding]:
    """The heaviest single thing behind the arm's last axis: the flange that weighs there, too, is the arm's own."""
    last = cell.joints[cell.arm_slice.stop - 1].name
    hung = [(f"{m.name!r} of cell.toml", m.mass) for m in cell.masses if m.after == last]
    hung += [
        (f"tool {t.name!r} of setup.toml" if t.name else "the tool of setup.toml", t.mass or 0.0) for t in setup.tools
    ]
    what, mass = max(hung, key=lambda pair: pair[1], default=("", 0.0))
    if cell.payload and mass > cell.payload:
        text = f"{what} weighs {mass:.4g} kg, and payload_kg of cell.toml is {cell.payload:.4g}: correct the one that is wrong"
        yield Finding("overload", text, value=mass, limit=cell.payload, unit="kg")


def doubtful_setup(setup: Setup, toolpath: Toolpath, *, told: bool = False) -> Iterator[Finding]:
    """A path that is in mm and read as inches, a tool's frame in metres or the wrong way round, a clearance in metres, and rapids
    slower than every cut. told: a stock says how large the path is.
    """
    if not told:
        yield from _inches(toolpath)
    for tool in setup.tools:
        yield from _tool_frame(tool)
    if setup.clearance is not None and 0.0 < setup.clearance < _LEAST_CLEARANCE:
        clearance = float(m_to_mm(setup.clearance))
        text = f"clearance_mm = {clearance:.4g} of the set-up looks like metres: it is in mm"
        yield Finding("clearance-in-metres", text, value=clearance, unit="mm")
    feeds = [np.asarray(r.feed)[r.cutting] for r in toolpath.regions if len(r)]
    least = min((float(f.min()) for f in feeds if len(f)), default=0.0)
    if setup.rapid_feed is not None and setup.rapid_feed < least:
        rapid, slowest = m_s_to_mm_min(setup.rapid_feed), m_s_to_mm_min(least)
        text = (
            f"rapid_feed_mm_min = {rapid:.4g} of the set-up is slower than every cut of the file ({slowest:.4g} mm/min at"
            " the least): it is in mm a minute"
        )
        yield Finding("slow-rapids", text, value=rapid, unit="mm/min")


def _inches(toolpath: Toolpath) -> Iterator[Finding]:
    """A path wider than parts are that somebody draws in inches."""
    points = [np.asarray(r.position) for r in toolpath.regions if len(r)]
    width = float(np.ptp(np.concatenate(points), axis=0).max()) if points else 0.0
    if toolpath.units == "inch" and width >= _WIDE:
        text = f"read as inches the path is {m_to_mm(width):.0f} mm wide, so it may be in mm (--units mm)"
        yield Finding("path-in-inches", text, value=float(m_to_mm(width)), unit="mm")


def _tool_frame(tool: ToolSetup) -> Iterator[Finding]:
    """A `flange_to_tool` whose tip lies in the plate, or whose z leads on from the tip instead of back."""
    tip, z = np.asarray(tool.flange_T_tool)[:3, 3], np.asarray(tool.flange_T_tool)[:3, 2]
    reach = float(np.linalg.norm(tip))
    name = f"tool {tool.name!r}" if tool.name else "the tool"
    if 0.0 < reach < _LEAST_REACH:
        given = ", ".join(f"{v:.4g}" for v in m_to_mm(tip).tolist())
        text = (
            f"flange_to_tool = [{given}, ...] of {name} looks like metres: X, Y, Z are in mm from the plate to the tip"
        )
        yield Finding("tool-frame-in-metres", text, value=float(m_to_mm(reach)), unit="mm")
    elif reach > 0.0 and float(-tip @ z) < _REVERSED * reach:
        text = (
            f"the z of {name} (flange_to_tool) points on from the tip, away from the plate, and has to point back to the holder "
            "as i, j, k of the CL data do: turn it round, by 180 degrees about its X"
        )
        yield Finding("tool-reversed", text)
