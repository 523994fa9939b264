"""Reading [controller] of a cell.toml."""

from __future__ import annotations

from camrob.cell.controller import ControllerSettings
from camrob.cell.table import TableReader
from camrob.errors import CellError

__all__ = ["read_controller"]


def read_controller(table: TableReader) -> ControllerSettings:
    """The controller's settings. Raises CellError naming file and key."""
    table.text("dialect", choices=("krl",))
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
    try:
        settings = ControllerSettings(
            acc_cp=number["acc_cp_m_s2"],
            vel_ori_deg_s=number["vel_ori_deg_s"],
            acc_ori_deg_s2=number["acc_ori_deg_s2"],
            ori_type=table.text("ori_type"),
            circ_type=table.text("circ_type"),
            apo_cdis_mm=number["apo_cdis_mm"],
            advance=whole["advance"],
            ptp_velocity_percent=number["ptp_velocity_percent"],
            max_lines=whole["max_lines"],
            max_bytes=whole["max_bytes"],
            max_line_length=whole["max_line_length"],
            base_template=table.text("base_template") if "base_template" in table else "",
            act_ex_ax=table.integer("act_ex_ax", lower=0, upper=6) if "act_ex_ax" in table else 0,
            tool_number=table.integer("tool_number", lower=0, upper=64) if "tool_number" in table else None,
            base_number=table.integer("base_number", lower=0, upper=64) if "base_number" in table else None,
            hooks=hooks,
        )
    except CellError as e:
        raise table.fail("", e.what, e.cure) from None
    table.finish()
    return settings
