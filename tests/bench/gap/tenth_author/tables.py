"""Logs as shops and laboratories write them, and the LOG.toml that tells how they are to be read."""

from __future__ import annotations

import datetime
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from .case import ENCODER_DEG, ENCODER_MM, SIGMA_DEG, Case, Log
from .machines import write_cell

__all__ = ["write"]

_TABLES = {  # separator, decimal, header, angles, lengths, time
    "blanks_rad": (" ", ".", 0, "rad", "cm", "s"),
    "semicolons": (";", ",", 1, "deg", "mm", "s"),
    "tabs_m": ("\t", ".", 2, "rad", "m", "ms"),
    "iso": (",", ".", 1, "deg", "inch", "s"),
    "beside": (",", ".", 1, "deg", "mm", "us"),
    "quaternions": ("|", ".", 1, "deg", "m", "s"),
    "counts": (",", ".", 1, "deg", "mm", "s"),
    "gauge": (";", ".", 1, "deg", "mm", "s"),
}
_LENGTH = {"mm": 1.0, "cm": 0.1, "m": 0.001, "inch": 1 / 25.4}
_TIME = {"s": 1.0, "ms": 1e3, "us": 1e6}
_COUNTS = 8192 * 101 / 360.0  # of the motor's encoder a degree of the output


def _columns(case: Case, log: Log) -> dict[str, np.ndarray]:
    """What was logged, by the format's names and units."""
    plan, machine, found = case.plan, case.machine, {}
    unit = np.array([180 / np.pi if j.kind == "R" else 1.0 for j in machine.joints])
    if plan.clock:
        found["t"] = log.run.t - log.run.t[0]
    groups = (("set", "c", log.run.q * unit), ("enc", "", log.q * unit))
    for what, before, values in groups:
        if what in plan.logged:
            found |= {before + name: values[:, k] for k, name in enumerate(machine.names)}
    for k, name in enumerate(machine.names):
        if "motor" in plan.logged and log.motor is not None:
            found["M" + name[1:]] = log.motor[:, k] * unit[k]
        if name[0] == "A" and "torque" in plan.logged:
            found["T" + name[1:]] = log.torque[:, k]
        if name[0] == "A" and "current" in plan.logged:
            found["I" + name[1:]] = log.torque[:, k] / (9.0 + 4 * k)
    if plan.see:
        shown = {"flat": "xy", "along": "x"}.get(plan.see, "xyz")
        found |= {c: log.pose[:, "xyz".index(c), 3] for c in shown}
    if plan.see == "pose":
        angles = Rotation.from_matrix(log.pose[:, :3, :3]).as_euler("ZYX", degrees=True)
        found |= dict(zip("abc", angles.T, strict=True))
    if "temp" in plan.logged:
        found["temp"] = log.run.temp
    return found


def _toml(case: Case, log: Log) -> list[str]:
    plan, run = case.plan, log.run
    lines = []
    if plan.see:
        lines += [
            f'measured_frame = "{plan.frame}"',
            f'target = "{plan.target}"',
            f"sigma_mm = {plan.told or plan.sigma:g}",
        ]
        if plan.see == "pose":
            lines.append(f"sigma_deg = {SIGMA_DEG:g}")
        if plan.frame == "unknown" and log.name != "run_1":
            lines.append('same_frame_as = "run_1.csv"')
        if plan.target == "unknown" and log.name != "run_1":
            lines.append('same_target_as = "run_1.csv"')
    if any(j.kind == "R" for j in case.machine.joints):
        lines.append(f"sigma_axis_deg = {ENCODER_DEG:g}")
    if any(j.kind == "P" for j in case.machine.joints):
        lines.append(f"sigma_axis_mm = {ENCODER_MM:g}")
    if run.told is not None:
        lines.append(f"payload_kg = {run.told:g}")
    if plan.tolerance is not None:
        lines.append(f"tolerance_mm = {plan.tolerance:g}")
    if run.poses:
        lines.append("poses = true")
    return lines


def _name(style: str, column: str) -> str:
    """What the shop calls it."""
    if style == "semicolons":
        return (
            f"{column[1:]}_Soll"
            if column[0] == "c" and len(column) > 1
            else f"{column}_Ist"
            if column[0] in "AE"
            else f"mess_{column}"
        )
    if style == "beside":
        return f"cmd_{column[1:]}" if column[0] == "c" and len(column) > 1 else f"act_{column}"
    return f"{column.lower()}_{style[:3]}"


def _converted(case: Case, style: str, column: str, values: np.ndarray):
    """The cells of a column as text, and what [table.columns] says of them beside the place."""
    _, decimal, _, angles, lengths, time = _TABLES[style]
    axis = column[1:] if column[0] == "c" and len(column) > 1 else column
    if column == "t" and style == "iso":
        begin = datetime.datetime(2026, 11, 9, 6, 2, 11)
        return [(begin + datetime.timedelta(seconds=float(x))).isoformat(timespec="milliseconds") for x in values], {}
    more, digits = {}, 4
    if column == "t":
        values, digits = values * _TIME[time], 5 if time == "s" else 2
    elif column in "xyz":
        values, digits = values * _LENGTH[lengths], 6
        if style == "gauge":
            values, more, digits = values * 1000.0, {"scale": 0.001}, 2
    elif column in ("a", "b", "c") or (
        axis in case.machine.names and case.machine.joints[case.machine.at(axis)].kind == "R"
    ):
        values, digits = (np.radians(values), 7) if angles == "rad" else (values, 5)
        more = {"unit": angles} if axis[0] == "E" else {}
    elif axis in case.machine.names:  # it slides
        to = {"tabs_m": "m", "blanks_rad": "m"}.get(style, "mm")
        values, digits = values * _LENGTH[to], 7 if to == "m" else 4
        more = {"unit": to}
    elif column[0] == "M":
        values, digits, more = values * _COUNTS, 0, {"scale": 1 / _COUNTS}
    return [f"{x:.{digits}f}".replace(".", decimal) for x in values], more


def _written(case: Case, log: Log, folder: Path, columns: dict) -> list[str]:
    """The table's file (two, where points stand beside), and [table]."""
    style = case.plan.table
    separator, decimal, header, angles, lengths, time = _TABLES[style]
    order = list(columns)
    if style in ("semicolons", "tabs_m"):
        order = order[::-1]
    turned = {}
    if style == "quaternions":
        quat = Rotation.from_matrix(log.pose[:, :3, :3]).as_quat()
        turned = {"qw": quat[:, 3], "qx": quat[:, 0], "qy": quat[:, 1], "qz": quat[:, 2]}
        order = [c for c in order if c not in ("a", "b", "c")]
    said = {c: _converted(case, style, c, columns[c]) for c in order}
    cells = {c: said[c][0] for c in order} | {c: [f"{x:.8f}" for x in v] for c, v in turned.items()}
    if style == "semicolons":
        cells = {"Satz": [str(k + 1) for k in range(len(log.run.t))]} | cells
    names = {c: c if c in turned or c == "Satz" else _name(style, c) for c in cells}
    apart = [c for c in cells if (c in "xyz" if case.plan.see else c[0] == "A")] if style == "beside" else []
    main = [c for c in cells if c not in apart]
    text = [separator.join(row) for row in zip(*(cells[c] for c in main), strict=True)]
    if header:
        text = [*["recorder 4.2, shop floor"][: header - 1], separator.join(names[c] for c in main), *text]
    (folder / f"{log.name}.csv").write_text("\n".join(text) + "\n")
    lines = ["[table]", f"separator = {separator!r}".replace("'", '"'), f'decimal = "{decimal}"', f"header = {header}"]
    lines += [f'angles = "{angles}"', f'lengths = "{lengths}"', f'time = "{time}"']
    if apart:
        rows = [" ".join(row) for row in zip(*(cells[c] for c in apart), strict=True)]
        (folder / f"{log.name}_points.txt").write_text("\n".join(rows) + "\n")
        lines.append(f'beside = {{ file = "{log.name}_points.txt", separator = " ", header = 0 }}')
    if style == "counts":
        lines.append(f"step_s = {log.run.t[1] - log.run.t[0]:g}")
    if style == "semicolons" and case.plan.see == "pose":
        lines.append('orientation = { as = "abc", columns = ["mess_a", "mess_b", "mess_c"] }')
        order = [c for c in order if c not in ("a", "b", "c")]
    if turned:
        lines.append('orientation = { as = "wxyz", columns = ["qw", "qx", "qy", "qz"] }')
    lines.append("[table.columns]")
    for c in order:
        if style == "counts" and c == "t":
            continue
        place = str(main.index(c) + 1) if not header else f'"{names[c]}"'
        if c in apart:
            place = str(len(main) + apart.index(c) + 1)
        more = "".join(f', {k} = "{v}"' if isinstance(v, str) else f", {k} = {v:.9g}" for k, v in said[c][1].items())
        lines.append(f"{c} = {{ column = {place}{more} }}" if more else f"{c} = {place}")
    if case.plan.see in ("along", "flat"):
        lines += [f"{c} = {{ value = 0 }}" for c in ("yz" if case.plan.see == "along" else "z")]
    return lines


def _plain(case: Case, log: Log, folder: Path, columns: dict) -> None:
    digits = {c: 6 if c[0] in "AEcabc" else 4 for c in columns}
    rows = [",".join(f"{columns[c][k]:.{digits[c]}f}" for c in columns) for k in range(len(log.run.t))]
    (folder / f"{log.name}.csv").write_text("\n".join([",".join(columns), *rows]) + "\n")


def write(case: Case, folder: Path) -> None:
    """Cell and logs of a case."""
    folder.mkdir(parents=True, exist_ok=True)
    write_cell(case.machine, folder / "cell")
    for log in case.logs:
        columns = _columns(case, log)
        lines = _toml(case, log)
        if case.plan.table == "plain":
            _plain(case, log, folder, columns)
        else:
            lines += ["", *_written(case, log, folder, columns)]
        (folder / f"{log.name}.toml").write_text("\n".join(lines) + "\n")
