"""What a job takes for granted because nobody said it: warnings that its user reads before all others."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.bare_links import bare_links
from camrob.bodies.table_plate import table_plate
from camrob.cell.cell import Cell
from camrob.cell.setup import Setup, ToolSetup
from camrob.checks.rapids import rapids_in_stock
from camrob.cutting.dexels import Dexels, of_mesh
from camrob.errors import InputError
from camrob.findings import Finding
from camrob.jobs.files.doubtful import doubtful_cell, doubtful_setup
from camrob.se3 import mm_deg_from_frame
from camrob.toolpath.toolpath import Tool, Toolpath
from camrob.units import m_to_mm, mm_to_m

__all__ = ["assumed_limits", "taken_for_granted"]

# mm; numbers below it are metres at a glance: no part stands farther than 3 m from the table's middle
_METRES = 3.0
_OUTWEIGHS = 10.0  # and the part is this many times larger than the way to it
_SHORTEST = mm_to_m(1.0)  # of a tool: a shorter one is given in metres
_ANOTHER = mm_to_m(0.1)  # by which a worn or reground tool may differ from the one in the file
_SINKS = mm_to_m(1.0)  # into a table: a drawing's rounding, a T-nut's play
_RAYS, _FINEST = 400, mm_to_m(0.25)  # across a stock, and no finer
_IN_STOCK = 0.02  # of the cuts: where fewer are near the stock, it lies elsewhere or is of another size
_WITHIN = 0.9  # likewise: where more are, the stock says how large the path is, and that in mm
_INCH, _METRE = 25.4, 1000.0  # mm
_FILLS, _ROOM = 0.5, 0.1  # of a stock's width: what cuts take of it at the least, and may pass it by

Array = NDArray[np.float64]


def taken_for_granted(
    cell: Cell, setup: Setup, toolpath: Toolpath, stock: Array | None = None, part: Array | None = None
) -> tuple[Finding, ...]:
    """No set-up, a base that nobody states, numbers in another unit by the look of them, another tool than the file's, no bodies
    to collide with, a stock or part that the path doesn't meet, or of another unit, rapids into it, a part beside the table or
    below its top. stock, part: (T, 3, 3) m, triangles in the CL data's frame.
    """
    found = [
        _no_setup(cell, setup),
        _base(cell),
        _in_metres(setup, toolpath),
        *(_short(tool) for tool in setup.tools),
        *(_another(setup, tool) for tool in toolpath.tools),
        _no_bodies(cell),
        None if stock is None else _apart(toolpath, stock, "stock"),
        None if part is None else _apart(toolpath, part, "part"),
        None if stock is None else _too_large(toolpath, stock),
        _beside(cell, setup, toolpath, [mesh for mesh in (stock, part) if mesh is not None]),
        None if stock is None else _rapids(setup, toolpath, stock),
        *(_sunk(cell, setup, what, mesh) for what, mesh in (("stock", stock), ("part", part)) if mesh is not None),
        _no_tool(cell, setup),
    ]
    told = stock is not None and _near(toolpath, stock) > _WITHIN * len(_cuts(toolpath))
    doubted = *doubtful_setup(setup, toolpath, told=told), *doubtful_cell(cell, setup)
    return (*(f for f in found if f is not None), *doubted, *_bare_links(cell))


def _base(cell: Cell) -> Finding | None:
    """A base that stands still, and nobody says where on the controller: it is written as zeros."""
    section = cell.controller_section
    if section is None or cell.base_follows_table or section.base_frame is not None or section.own.get("base_measured"):
        return None
    text = "nobody says where the cell's world lies on the controller, so that the base is written as zeros"
    if section.own.get("numbering") == "tables":
        text += f", also over BASE_DATA[{section.own.get('base_number')}]"
    text += (
        ": where the controller's world is not the cell's, the program runs elsewhere; give base_frame in [controller]"
    )
    return Finding("base-unsaid", text)


def _short(tool: ToolSetup) -> Finding | None:
    """A tool's length in metres by the look of it."""
    if not 0.0 < tool.length < _SHORTEST:
        return None
    length = float(m_to_mm(tool.length))
    text = (
        f"the tool's length_mm = {length:.4g} looks like metres: it is in mm, from the tip to where the holder begins"
    )
    return Finding("tool-in-metres", text, value=length, unit="mm")


def _another(setup: Setup, tool: Tool) -> Finding | None:
    """A tool of the file that is of another size than the one that is set up for it."""
    fit = [t for t in setup.tools if t.number in (None, tool.number)] or setup.tools[: len(setup.tools) == 1]
    if not fit:
        return None
    pairs = [("wide", fit[0].diameter, tool.diameter), ("round at its edge", fit[0].corner, tool.corner_radius)]
    off = [(what, m_to_mm(own), m_to_mm(its)) for what, own, its in pairs if own and its and abs(own - its) > _ANOTHER]
    if not off:
        return None
    own, its = (" and ".join(f"{pair[k]:.4g} mm {pair[0]}" for pair in off) for k in (1, 2))
    name = f"tool {tool.number}" if tool.number else f"tool {tool.name}" if tool.name else "tool"
    text = f"the set-up's tool is {own}, the file's {name} {its}: mount the one that the path was made for, or correct [tool]"
    return Finding("another-tool", text)


def _cuts(toolpath: Toolpath) -> Array:
    """(K, 3) m, the points of all cuts, in the CL data's frame."""
    cuts = [np.asarray(r.position)[r.cutting] for r in toolpath.regions if len(r)]
    return np.concatenate(cuts) if cuts else np.zeros((0, 3))


def _too_large(toolpath: Toolpath, stock: Array) -> Finding | None:
    """A stock that the cuts would fit if it were read in a smaller unit."""
    points = _cuts(toolpath)
    corners = stock.reshape(-1, 3)
    for factor, unit in ((_INCH, "inches"), (_METRE, "metres")):
        low, high = corners.min(axis=0) / factor, corners.max(axis=0) / factor
        room = _ROOM * (high - low).max()
        inside = np.all((points > low - room) & (points < high + room), axis=1)
        if not len(points) or not inside.all() or np.ptp(points, axis=0).max() < _FILLS * (high - low).max():
            continue
        x, y, z = (f"{v:.0f}" for v in m_to_mm(np.ptp(corners, axis=0)).tolist())
        text = (
            f"the stock is {x} by {y} by {z} mm, {factor:g} times what the cuts would fit: its mesh may be in mm and "
            f"read as {unit} (unit of [stock])"
        )
        return Finding("stock-too-large", text, value=factor)
    return None


def _beside(cell: Cell, setup: Setup, toolpath: Toolpath, bodies: list[Array]) -> Finding | None:
    """Part and stock, or else all cuts, wholly beside the plate that they ought to lie on."""
    plate = table_plate(cell)
    points = np.concatenate([mesh.reshape(-1, 3) for mesh in bodies]) if bodies else _cuts(toolpath)
    if plate is None or not len(points):
        return None
    base_T_part = np.asarray(setup.base_T_part)
    corners = np.array(np.meshgrid(*np.stack([points.min(axis=0), points.max(axis=0)]).T)).reshape(3, -1).T
    there = corners @ base_T_part[:3, :3].T + base_T_part[:3, 3]
    middle = there.mean(axis=0, keepdims=True)
    half = 0.5 * float(np.linalg.norm(np.ptp(there[:, :2], axis=0)))  # round the middle, whichever way it lies
    off = plate.beyond(middle) - half
    if off <= 0.0:
        return None
    text = (
        f"the {'part' if bodies else 'path'} lies beside {plate.name}, {m_to_mm(off):.0f} mm at least beyond its edge: "
        "check X and Y of part_in_base, mm in base"
    )
    return Finding("part-off-table", text, value=float(m_to_mm(off)), unit="mm")


def _apart(toolpath: Toolpath, stock: Array, what: str) -> Finding | None:
    """A stock or part that hardly any cut comes near to: of another unit, or placed elsewhere."""
    points, near = _cuts(toolpath), _near(toolpath, stock)
    low, high = stock.reshape(-1, 3).min(axis=0), stock.reshape(-1, 3).max(axis=0)
    if not len(points) or near > _IN_STOCK * len(points):
        return None
    (x, y, z), (path_x, path_y, path_z) = (
        [f"{a:.4g} to {b:.4g}" for a, b in zip(m_to_mm(lo), m_to_mm(up), strict=True)]
        for lo, up in ((low, high), (points.min(axis=0), points.max(axis=0)))
    )
    text = (
        f"{near} of {len(points)} points of the cuts lie near the {what} (X {x}, Y {y}, Z {z} mm; the cuts: X {path_x}, "
        f"Y {path_y}, Z {path_z}): check the unit of its mesh, and that its origin is the CL data's"
    )
    return Finding(f"{what}-apart", text, count=len(points) - near)


def _near(toolpath: Toolpath, stock: Array) -> int:
    """How many points of the cuts lie in the box about a stock, or a tool's width beside it."""
    points = _cuts(toolpath)
    low, high = stock.reshape(-1, 3).min(axis=0), stock.reshape(-1, 3).max(axis=0)
    room = max((t.diameter for t in toolpath.tools), default=0.0)
    return int(np.count_nonzero(np.all((points > low - room) & (points < high + room), axis=1)))


def _rapids(setup: Setup, toolpath: Toolpath, stock: Array) -> Finding | None:
    """Rapids of the file into the stock, a mesh or a box."""
    widths = [t.diameter for t in setup.tools] + [t.diameter for t in toolpath.tools]
    corners = stock.reshape(-1, 3)
    box = np.stack([corners.min(axis=0), corners.max(axis=0)])
    if not np.all(box[1] > box[0]):
        return None
    meshed = setup.stock is not None and setup.stock.mesh is not None
    depth = _InMesh(stock, box) if meshed else None
    found = rapids_in_stock(toolpath.regions, box, max(widths, default=0.0), depth)
    if depth is not None and depth.unbounded:
        text = (
            "the file moves in rapid where the stock may be, and its mesh isn't closed, so that nobody can tell whether there is "
            "material: close the mesh of [stock] in setup.toml, or give a box_mm"
        )
        return Finding("rapids-not-judged", text)
    return found


class _InMesh:
    """How far points lie within a mesh, along the axes; its rays are made when first asked, which few files do."""

    def __init__(self, triangles: Array, box: Array) -> None:
        self.triangles = triangles
        self.pitch = max(float((box[1] - box[0]).max()) / _RAYS, _FINEST)
        self.rays: Dexels | None = None
        self.unbounded = False  # whether points were asked for, and the mesh bounds no body

    def __call__(self, points: Array) -> Array:
        """(N,) m; not above 0 outside, within a ray's pitch of the surface, and where the mesh bounds no body."""
        if not len(points):
            return np.zeros(0)
        try:
            rays = self.rays = self.rays or of_mesh(self.triangles, self.pitch)
        except InputError:
            self.unbounded = True
            return np.zeros(len(points))
        depth = np.full(len(points), np.inf)
        for d in range(3):
            u, v = rays.others(d)
            edge, count, first = rays.stretches(d)[0], rays.count[d], rays.grid(d)[:2]
            i, j = (
                np.clip(np.rint((points[:, c] - at) / self.pitch), 0, n - 1).astype(np.int64)
                for c, at, n in zip((u, v), first, count.shape, strict=True)
            )
            used = np.arange(edge.shape[2] // 2) < count[i, j, None]
            along = points[:, d, None]
            room = np.minimum(along - edge[i, j][:, ::2], edge[i, j][:, 1::2] - along)
            depth = np.minimum(depth, np.where(used, room, -1.0).max(axis=1))
        return np.where(depth > self.pitch, depth, 0.0)


def _sunk(cell: Cell, setup: Setup, what: str, mesh: Array) -> Finding | None:
    """A part or stock, seen from above on the table's plate, that reaches below the plate's top."""
    plate = table_plate(cell)
    base_T_part = np.asarray(setup.base_T_part)
    corners = mesh.reshape(-1, 3) @ base_T_part[:3, :3].T + base_T_part[:3, 3]
    if plate is None or plate.beyond(corners) > 0.0:
        return None
    below = float(m_to_mm(plate.top - corners[:, 2].min()))
    if below < m_to_mm(_SINKS):
        return None
    text = (
        f"the {what} reaches {below:.1f} mm below the top of {plate.name}, on which it lies: correct Z of part_in_base, "
        "or where the mesh has its origin"
    )
    return Finding("part-in-table", text, value=below, unit="mm")


def _no_setup(cell: Cell, setup: Setup) -> Finding | None:
    """What stands in for a set-up that there is none of, or that says nothing of where the part lies."""
    if setup.path is not None:
        if not setup.unplaced:
            return None
        text = f"{setup.path.name} says nothing of where the part lies: its frame is taken for base itself; give part_in_base"
        return Finding("part-unplaced", text)
    text = (
        f"no set-up: the part's frame is taken for base itself, the tool for the cell's own ({_own_tool(cell)}), and there is"
        " neither part nor stock to collide with; write setup.toml beside the CL file, or give --setup"
    )
    return Finding("no-setup", text)


def _no_tool(cell: Cell, setup: Setup) -> Finding | None:
    """What stands in for a tool of which the set-up says nothing."""
    if not setup.toolless:
        return None
    text = (
        f"{setup.path.name if setup.path else 'the set-up'} says nothing of the tool: it is taken for the cell's own "
        f"({_own_tool(cell)}), as thick and long as the cell draws it; give [tool]"
    )
    return Finding("tool-unsaid", text)


def _own_tool(cell: Cell) -> str:
    """The frame of the cell's tool, in words."""
    numbers = mm_deg_from_frame(np.asarray(cell.flange_T_tool))
    return " ".join(f"{n} {v:.3f}" for n, v in zip("XYZABC", np.round(numbers, 3) + 0.0, strict=True))


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


def _bare_links(cell: Cell) -> tuple[Finding, ...]:
    """Links of the arm that are longer than what is drawn of them, as in a cell that was copied."""
    return tuple(
        Finding(
            "bare-link", f"{bare.text}; lengthen it in cell.toml", axis=bare.first, value=m_to_mm(bare.bare), unit="mm"
        )
        for bare in bare_links(cell)
    )


def assumed_limits(cell: Cell) -> tuple[Finding, ...]:
    """One warning that names the limits that are only assumed: whole axes, or which of their limits where others are known."""
    stated: dict[str, dict[str, bool]] = {}  # axis: limit: assumed
    for key, standing in cell.provenance.items():
        match = re.fullmatch(r"joint\[(\w+)\]\.limits\.([a-z]+)\w*", key)
        if match:
            stated.setdefault(match[1], {})[match[2]] = standing == "assumed"
    alike: dict[str, list[str]] = {}
    for name, limits in sorted(stated.items()):
        guessed = [limit for limit, assumed in limits.items() if assumed]
        if guessed:
            alike.setdefault("limits" if all(limits.values()) else " and ".join(guessed), []).append(name)
    if not alike:
        return ()
    said = "; ".join(f"{what} of {', '.join(names)}" for what, names in alike.items())
    text = f"{said} are assumed, not taken from the machine: check them against its data sheets"
    return (Finding("assumed-limits", text),)
