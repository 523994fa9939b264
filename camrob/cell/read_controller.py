"""Reading [controller] of a cell.toml."""

from __future__ import annotations

from camrob.cell.controller_settings import ControllerSettings
from camrob.cell.joint import Joint, Role
from camrob.errors import CellError
from camrob.toml.table_reader import TableReader

__all__ = ["read_controller"]


def read_controller(table: TableReader, joints: tuple[Joint, ...]) -> ControllerSettings:
    """The controller's settings; `joints` are the cell's. What its language alone knows is left to that. Raises CellError naming
    file and key.
    """
    language = _language(table)
    hooks: dict[str, tuple[str, ...]] = {}
    if "hooks" in table:
        part = table.table("hooks")
        hooks = {key: part.texts(key) for key in part.keys()}
    number = {
        key: table.number(key)
        for key in ("acc_cp_m_s2", "vel_ori_deg_s", "acc_ori_deg_s2", "apo_cdis_mm", "ptp_velocity_percent")
    }
    whole = {
        key: table.integer(key, lower=0, upper=10**9)
        for key in ("advance", "max_lines", "max_bytes", "max_line_length")
    }
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
            block_ms=table.number("block_ms") if "block_ms" in table else 0.0,
            spindle_rpm=spindle_rpm,
            tool_change_pose=tool_change_pose,
            entries=table.flag("entries") if "entries" in table else False,
            base_frame=base_frame,
            hooks=hooks,
            language=language,
            own=table.rest(),
        )
    except CellError as e:
        raise table.fail("", e.what, e.hint) from None
    table.finish()
    return settings


def _language(table: TableReader) -> str:
    """What programs are written in; `dialect` is the older word for it."""
    word = "language" if "language" in table else "dialect"
    return table.text(word) if word in table else ""


def _pair(table: TableReader, key: str) -> tuple[float, float] | None:
    """Two numbers that may be left out."""
    if key not in table:
        return None
    least, most = table.vector(key, 2)
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
