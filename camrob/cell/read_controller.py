"""Reading [controller] of a cell.toml."""

from __future__ import annotations

import re

from camrob.cell.controller_settings import ControllerSettings
from camrob.cell.joint import Joint, Role
from camrob.errors import CellError
from camrob.toml.table_reader import TableReader

__all__ = ["controller_key", "read_controller"]

# what a controller takes; a number beyond is a slip of its unit
_NUMBERS = {
    "acc_cp_m_s2": (1e-3, 100.0),
    "vel_ori_deg_s": (1e-3, 1e4),
    "acc_ori_deg_s2": (1e-3, 1e5),
    "apo_cdis_mm": (0.0, 1e3),
    "ptp_velocity_percent": (1e-3, 100.0),
}
_WHOLE = {"advance": (0, 5), "max_lines": (2, 10**9), "max_bytes": (2000, 10**9), "max_line_length": (80, 10**9)}


def read_controller(table: TableReader, joints: tuple[Joint, ...]) -> ControllerSettings:
    """The controller's settings; `joints` are the cell's. What its language alone knows is left to that. Raises CellError naming
    file and key.
    """
    language = _language(table)
    hooks: dict[str, tuple[str, ...]] = {}
    if "hooks" in table:
        part = table.table("hooks")
        hooks = {key: part.texts(key) for key in part.keys()}
    number = {key: table.number(key, lower=low, upper=high) for key, (low, high) in _NUMBERS.items()}
    whole = {key: table.integer(key, lower=low, upper=high) for key, (low, high) in _WHOLE.items()}
    block_ms = table.number("block_ms", lower=0.0, upper=1e3) if "block_ms" in table else 0.0
    entries = table.flag("entries") if "entries" in table else False
    base_frame = tuple(table.vector("base_frame", 6).tolist()) if "base_frame" in table else None
    spindle_rpm, tool_change_pose = _pair(table, "spindle_rpm"), _pose(table, "tool_change_pose", joints)
    try:
        settings = ControllerSettings(
            acc_cp=number["acc_cp_m_s2"],
            vel_ori_deg_s=number["vel_ori_deg_s"],
            acc_ori_deg_s2=number["acc_ori_deg_s2"],
            apo_cdis_mm=number["apo_cdis_mm"],
            advance=whole["advance"],
            ptp_velocity_percent=number["ptp_velocity_percent"],
            max_lines=whole["max_lines"],
            max_bytes=whole["max_bytes"],
            max_line_length=whole["max_line_length"],
            block_ms=block_ms,
            spindle_rpm=spindle_rpm,
            tool_change_pose=tool_change_pose,
            entries=entries,
            base_frame=base_frame,
            hooks=hooks,
            language=language,
            own=table.rest(),
        )
    except CellError as e:
        raise table.fail("", e.what, e.hint, stands=controller_key(e.what)) from None
    table.finish()
    return settings


def controller_key(what: str) -> tuple[str, ...]:
    """Where in [controller] that stands of which an error says what is wrong: it begins with the key, or with `hook NAME`."""
    said = re.match(r"(hook )?'?(\w+)", what)
    if said is None:
        return ()
    return ("hooks", said[2]) if said[1] else (said[2],)


def _language(table: TableReader) -> str:
    """What programs are written in; `dialect` is the older word for it."""
    word = "language" if "language" in table else "dialect"
    return table.text(word) if word in table else ""


def _pair(table: TableReader, key: str) -> tuple[float, float] | None:
    """Two numbers that may be left out."""
    if key not in table:
        return None
    least, most = table.vector(key, 2)
    if not 0.0 <= least <= most:
        raise table.fail(key, f"is [{least:g}, {most:g}]", "give [least, most]")
    return float(least), float(most)


def _pose(table: TableReader, key: str, joints: tuple[Joint, ...]) -> tuple[float, ...] | None:
    """Axis values in the order of `Cell.axis_names`, degrees and mm, within the axes' ranges; may be left out."""
    if key not in table:
        return None
    axes = sorted((j for j in joints if j.role is not Role.ROLL), key=lambda j: (j.role is not Role.ARM, j.name))
    values = table.vector(key, len(axes))
    for joint, value in zip(axes, values, strict=True):
        si = joint.from_edge(float(value))
        if not joint.lower <= si <= joint.upper:
            raise table.fail(key, f"{joint.name} {value:g} lies outside the axis's range", "correct it or limits")
    return tuple(float(v) for v in values)
