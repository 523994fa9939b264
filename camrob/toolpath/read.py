"""The public verb: a CL or G-code file in, a toolpath out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from camrob.errors import InputError, ToolpathError
from camrob.machine_tool import MachineTool
from camrob.progress import Share
from camrob.text import bytes_of
from camrob.toolpath.apt.dialects.registry import DIALECTS
from camrob.toolpath.apt.read_apt import read_cl
from camrob.toolpath.cut_off import refuse_cut_off
from camrob.toolpath.defaults import Defaults
from camrob.toolpath.foreign import refuse_foreign
from camrob.toolpath.recognise import looks_like_gcode
from camrob.toolpath.sampling import ANGLE_TOLERANCE, CHORD_TOLERANCE
from camrob.toolpath.toolpath import Toolpath
from camrob.units import m_to_mm

__all__ = ["read_toolpath"]

_LARGEST_BYTES = 1 << 30  # a gigabyte of text: some twenty million points
FARTHEST = 100.0  # m from the part's origin: beyond it a coordinate is a slip, and a path to it has millions of steps


def read_toolpath(
    path: str | Path,
    *,
    dialect: str | None = None,
    units: str | None = None,
    chord_tolerance: float = CHORD_TOLERANCE,
    angle_tolerance: float = ANGLE_TOLERANCE,
    feed: float | None = None,
    spindle_rpm: float | None = None,
    diameters: Mapping[int, float] | None = None,
    wear: bool = False,
    numbers: Mapping[str, int] | None = None,
    machine_tool: MachineTool | None = None,
    progress: Share | None = None,
) -> Toolpath:
    """Read CL data (NX, Creo, CATIA, CAMWorks, Makino, plain APT) or 5-axis G-code; which one is recognised.

    Args:
        path: the file.
        dialect: forces one: "nx-clsf", "creo-ncl", "catia-apt", "camworks-apt", "camworks-clt", "makino-cldata", "apt", "gcode".
        units: "mm" or "inch", over the file's own.
        chord_tolerance: m within which arcs and curves become points.
        angle_tolerance: rad, the same of the tool's axis.
        feed: m/s where the file states none before its first cut, with a finding.
        spindle_rpm: rev/min where the file starts no spindle before its first cut, with a finding.
        diameters: m by tool number, 0 for any, for surface speeds where the file names no cutter.
        wear: paths with cutter radius compensation are the tool centre's, its offsets hold wear only; else they may be refused.
        numbers: of the set-up's tools by their names in lower case, for G-code that calls tools by names.
        machine_tool: the machine whose own axes a G-code program names.
        progress: called with the share that is read, 0 to 1.

    Returns:
        Regions of frames in the part, in SI, with the process beside them.

    Raises:
        ToolpathError: what can't be read honestly, by file and line.

    Example:
        >>> toolpath = camrob.read_toolpath(Path("toolpaths/engraving/engraving.cls"))
        >>> toolpath.dialect, len(toolpath.regions)
        ('nx-clsf', 2)
    """
    place = Path(path)
    if dialect is not None and dialect not in DIALECTS and not dialect.startswith("gcode"):
        known = ", ".join([*DIALECTS, "gcode"])
        raise ToolpathError(f"there is no dialect {dialect!r}", hint=f"choose one of {known}", path=place)
    data = _bytes(place)
    defaults = Defaults(feed, spindle_rpm, diameters or {}, wear, numbers or {})
    if dialect is None:
        try:
            refuse_foreign(data)
        except ToolpathError as error:
            raise error.at(place) from error
    is_gcode = dialect.startswith("gcode") if dialect is not None else looks_like_gcode(data, place.suffix)
    try:
        if is_gcode:
            from camrob.toolpath.gcode.read_gcode import read_gcode  # brings all controls

            toolpath = read_gcode(
                place,
                data,
                units=units,
                chord_tolerance=chord_tolerance,
                angle_tolerance=angle_tolerance,
                defaults=defaults,
                kinematics=_kinematics(dialect, place),
                machine_tool=machine_tool,
            )
        elif machine_tool is not None:
            hint = "take machine out of setup.toml, or hand over the machine's G-code"
            raise ToolpathError("the set-up names a machine, whose axes CL data doesn't hold", hint=hint)
        else:
            toolpath = read_cl(
                place,
                data,
                dialect=dialect,
                units=units,
                chord_tolerance=chord_tolerance,
                angle_tolerance=angle_tolerance,
                defaults=defaults,
                progress=progress,
            )
        refuse_cut_off(data)
    except InputError as error:
        raise error.at(place) from error
    return _in_the_world(toolpath, place)


def _kinematics(dialect: str | None, path: Path) -> str | None:
    """The machine that a dialect of G-code names, None where it names none. Raises ToolpathError for one that isn't known."""
    from camrob.toolpath.gcode.controls.registry import CONTROLS
    from camrob.toolpath.gcode.read_gcode import KINEMATICS

    dialect = dialect or "gcode"
    name = dialect.removeprefix("gcode").removeprefix("-")
    if name not in ("3axis", *KINEMATICS) and dialect not in {c.dialect for c in CONTROLS.values()}:
        known = ", ".join(f"gcode-{k}" for k in KINEMATICS)
        raise ToolpathError(f"there is no dialect {dialect!r}", hint=f"gcode, {known}", path=path)
    return name if name in KINEMATICS else None


def _in_the_world(toolpath: Toolpath, path: Path) -> Toolpath:
    """The toolpath itself. Raises ToolpathError for a point that lies farther away than any cell reaches."""
    for region in toolpath.regions:
        far = np.flatnonzero(~(np.abs(np.asarray(region.position)).max(axis=1, initial=0.0) <= FARTHEST))
        if len(far):
            away = float(np.abs(np.asarray(region.position)[far[0]]).max())
            raise ToolpathError(
                f"a point lies {m_to_mm(away):.0f} mm away",
                hint="correct the coordinate, or the units",
                path=path,
                line=int(region.line[far[0]]),
            )
    return toolpath


def _bytes(path: Path) -> bytes:
    """The file's bytes. Raises ToolpathError where there are none to be had."""
    try:
        if path.stat().st_size > _LARGEST_BYTES or len(data := bytes_of(path, _LARGEST_BYTES)) > _LARGEST_BYTES:
            raise ToolpathError("the file has more than 1024 MiB", hint="split it", path=path)
        return data.strip(b"\0")  # leader and trailer of a tape, and what DNC fills a block up with
    except OSError as error:
        why = (error.strerror or "it can't be opened").lower()
        raise ToolpathError(f"can't be read: {why}", hint="check the path", path=path) from error
