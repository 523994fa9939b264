"""Reading [controller] of a cell.toml."""

from __future__ import annotations

from typing import Any

from camrob.cell.controller_settings import DEFAULT_LANGUAGE, ControllerSettings
from camrob.cell.joint import Joint, Role
from camrob.cell.toml_table import TableReader
from camrob.errors import CellError
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["read_controller"]


def read_controller(table: TableReader, joints: tuple[Joint, ...], *, follows_table: bool) -> ControllerSettings:
    """The controller's settings; `joints` and `base_follows_table` are the cell's. Raises CellError naming file and key."""
    language = _language(table)
    usual = language == DEFAULT_LANGUAGE
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
            hooks=hooks,
            language=language,
            **(_words(table) if usual else {"own": table.rest()}),
        )
        if usual and any(j.role is Role.WORKPIECE for j in joints):
            settings.check_base(follows_table=follows_table)
    except CellError as e:
        raise table.fail("", e.what, e.hint) from None
    table.finish()
    return settings


def _language(table: TableReader) -> str:
    """What programs are written in; `dialect` is the older word for it."""
    word = "language" if "language" in table else "dialect"
    return table.text(word) if word in table else DEFAULT_LANGUAGE


def _words(table: TableReader) -> dict[str, Any]:
    """The settings that are in the usual language's words."""
    return {
        "ori_type": table.text("ori_type"),
        "circ_type": table.text("circ_type"),
        "base_template": table.text("base_template") if "base_template" in table else "",
        "act_ex_ax": table.integer("act_ex_ax", lower=0, upper=6) if "act_ex_ax" in table else 0,
        "tool_number": table.integer("tool_number", lower=0, upper=64) if "tool_number" in table else None,
        "stop_message": table.flag("stop_message") if "stop_message" in table else False,
        "base_number": table.integer("base_number", lower=0, upper=64) if "base_number" in table else None,
    }


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
        si = mm_to_m(float(value)) if joint.prismatic else deg_to_rad(float(value))
        if not joint.lower <= si <= joint.upper:
            raise table.fail(key, f"{joint.name} {value:g} lies outside the axis's range", "correct it or limits")
    return tuple(float(v) for v in values)
