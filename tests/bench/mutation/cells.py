"""The cells of the bench's jobs: the shipped KR15 with a controller of the bench's own, and what the judge knows of it."""

from __future__ import annotations

import re
import shutil
import tomllib
from pathlib import Path

import numpy as np

from mutation import arm
from mutation.bodies import Bodies, Body, read_bodies
from mutation.replay import Machine
from mutation.shops import LINES, SHOPS

SHIPPED = Path(__file__).resolve().parents[3] / "cells" / "kr15_track_table"

_CONTROLLER = """[controller]
dialect = "krl"
acc_cp_m_s2 = 2.3
vel_ori_deg_s = 190
acc_ori_deg_s2 = 410
ori_type = "#VAR"
circ_type = "#BASE"
apo_cdis_mm = 0.4
advance = 4
ptp_velocity_percent = 11
max_lines = 20000
max_bytes = 4000000
max_line_length = 255
base_template = "EK(MACHINE_DEF[2].ROOT, MACHINE_DEF[2].MECH_TYPE, {base})"
act_ex_ax = 2
spindle_rpm = [100, 24000]
standing = "assumed"

[controller.hooks]
spindle_on = ["$ANOUT[1] = {speed} / 24000.0", "$OUT[3] = FALSE", "$OUT[1] = TRUE", "WAIT SEC 3.0"]
spindle_on_ccw = ["$ANOUT[1] = {speed} / 24000.0", "$OUT[3] = TRUE", "$OUT[1] = TRUE", "WAIT SEC 3.0"]
spindle_off = ["$OUT[1] = FALSE", "WAIT SEC 2.5"]
coolant_on = ["$OUT[2] = TRUE"]
coolant_off = ["$OUT[2] = FALSE"]
tool_change = ["HALT ;change to tool {number}"]
stop = ["HALT"]
footer = ["$OUT[1] = FALSE ;end", "$OUT[2] = FALSE ;end"]

"""
_LINES = (
    "BAS (#INITMOV,0 )",
    "BAS (#VEL_PTP,11 )",
    "$ADVANCE = 4",
    "$ACC.CP = 2.3000",
    "$VEL.ORI1 = 190.000",
    "$VEL.ORI2 = 190.000",
    "$ACC.ORI1 = 410.000",
    "$ACC.ORI2 = 410.000",
    "$ORI_TYPE = #VAR",
    "$CIRC_TYPE = #BASE",
    "$APO.CDIS = 0.400",
    "$ACT_EX_AX = 2",
)
_EK = "EK(MACHINE_DEF[2].ROOT, MACHINE_DEF[2].MECH_TYPE, {frame})"
_STILL = ("no-table", "fixed-arm")


def _text() -> str:
    text = (SHIPPED / "cell.toml").read_text(encoding="utf-8")
    start, end = text.index("[controller]"), text.index("[resolve]")
    head = text[:start].rstrip()
    while head.rsplit("\n", 1)[-1].startswith("#"):
        head = head.rsplit("\n", 1)[0].rstrip()
    return head + "\n\n" + _CONTROLLER + text[end:]


def _swap(text: str, pattern: str, replacement: str) -> str:
    changed, count = re.subn(pattern, replacement, text, flags=re.S)
    if not count:
        raise ValueError(f"{pattern!r} is not in the shipped cell")
    return changed


def _without(text: str, *joints: str) -> str:
    """The cell without some of its joints."""
    for name in joints:
        text = _swap(text, rf'\[\[joint\]\]\nname = "{name}".*?(?=\[\[joint\]\])', "")
        text = re.sub(rf"(weights = \{{.*?)\b{name} = \"\w+\", ", r"\1", text)
    return text


def cell_text(variant: str) -> str:
    """cell.toml of a variant.

    `kr15`; `still` (the base does not turn with the table); `one-way` (no hook for counter-clockwise, coolant or stop);
    `narrow` (E1 in -20 .. 30); `narrow-arm` (A1 and E1 narrow, base fixed); `no-table` (arm on its track, no E2);
    `fixed-arm` (neither); those of SHOPS: the cell in the manner of a shop.
    """
    text = _text()
    if variant == "still":
        text = text.replace("base_follows_table = true", "base_follows_table = false")
        text = _swap(text, r"base_template = [^\n]*\n", "").replace("act_ex_ax = 2\n", "")
    elif variant == "one-way":
        text = _swap(text, r"spindle_on_ccw = [^\n]*\n", "")
        text = _swap(text, r"coolant_on = [^\n]*\ncoolant_off = [^\n]*\n", "")
        text = _swap(text, r"stop = [^\n]*\n", "")
    elif variant == "narrow":
        text = _swap(text, r"range_mm = \[-1500, 1500\]", "range_mm = [-20, 30]")
    elif variant == "narrow-arm":
        text = _swap(text, r"range_mm = \[-1500, 1500\]", "range_mm = [-50, 50]")
        text = _swap(text, r"range_deg = \[-185, 185\]", "range_deg = [-20, 20]")
        text = text.replace("base_follows_table = true", "base_follows_table = false")
        text = _swap(text, r"base_template = [^\n]*\n", "").replace("act_ex_ax = 2\n", "")
    elif variant in _STILL:
        text = _fixed(text, variant)
    elif variant in SHOPS:
        text = text.replace("act_ex_ax = 2\n", "act_ex_ax = 2\n" + SHOPS[variant])
    elif variant != "kr15":
        raise ValueError(variant)
    return text


def _fixed(text: str, variant: str) -> str:
    """Without table, or without table and track: `base` stands where it stands at E2 = 0."""
    world_T_track = arm.row(90.0, 803.0, 180.0, -305.0)
    first = world_T_track if variant == "no-table" else world_T_track @ arm.row(90.0, 0.0, 0.0, 0.0)
    text = _without(text, *(("E2",) if variant == "no-table" else ("E2", "E1")))
    xyz = np.round(first[:3, 3], 6).tolist()
    a = np.degrees(np.arctan2(first[1, 0], first[0, 0]))
    b = np.degrees(np.arctan2(-first[2, 0], np.hypot(first[2, 1], first[2, 2])))
    c = np.degrees(np.arctan2(first[2, 1], first[2, 2]))
    if np.abs(arm.frame((*xyz, a, b, c)) - first).max() > 1e-9:
        raise ValueError("angles")
    text = text.replace("base_to_first = [0, 0, 0, 0, 0, 0]", f"base_to_first = {[float(v) for v in (*xyz, a, b, c)]}")
    text = text.replace("base_follows_table = true", "base_follows_table = false")
    text = _swap(text, r"base_template = [^\n]*\n", "").replace(
        "act_ex_ax = 2\n", "" if variant == "no-table" else "act_ex_ax = 0\n"
    )
    return text


def write_cell(variant: str, folder: Path) -> Path:
    """The folder of a variant."""
    folder.mkdir(parents=True)
    (folder / "cell.toml").write_text(cell_text(variant), encoding="utf-8")
    for name in ("weights_jnt.fis", "weights_cond.fis"):
        shutil.copy(SHIPPED / name, folder / name)
    if variant not in _STILL:
        shutil.copy(SHIPPED / "poses.csv", folder / "poses.csv")
    return folder


def machine(variant: str) -> Machine:
    """What the judge holds a program of a variant to."""
    lower, upper = arm.LOWER.copy(), arm.UPPER.copy()
    if variant == "narrow":
        lower[6], upper[6] = -20.0, 30.0
    if variant in SHOPS:
        return Machine(
            (*_LINES[:2], *LINES[variant][:2], *_LINES[2:11], *LINES[variant][2:], _LINES[11]), _EK, shop=variant
        )
    if variant in ("kr15", "one-way", "narrow"):
        return Machine(_LINES, _EK, lower=lower, upper=upper)
    externals = {"still": ("E1", "E2"), "no-table": ("E1",)}.get(variant, ())
    return Machine(tuple(x for x in _LINES if "ACT_EX" not in x), "{frame}", follows=False, externals=externals)


def bodies(variant: str, tool: tuple[float, float] | None, part: Body | None) -> Bodies:
    """The bodies of a variant with the job's tool (diameter, length) and part."""
    return read_bodies(tomllib.loads(cell_text(variant)), tool, part)


def box(lower: tuple[float, float, float], upper: tuple[float, float, float], part_in_base: tuple[float, ...]) -> Body:
    """The part as a box in `base`, by its corners in the part's frame."""
    low, high = np.array(lower), np.array(upper)
    at = arm.frame(part_in_base) @ arm.shift(*((low + high) / 2.0))
    return Body("part", "part", "base", "box", tuple((high - low).tolist()), at, frozenset())
