"""Logs as shops' recorders write them, and LOG.toml that tells each."""

from __future__ import annotations

import datetime
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from .case import ENCODER, SIGMA_DEG, Case, Log

__all__ = ["write"]

LENGTH = {"mm": 1.0, "m": 1e-3, "inch": 1 / 25.4}


def write(case: Case, folder: Path) -> None:
    """A case as a user would hand it over: cell, logs, their descriptions."""
    (folder / "cell").mkdir(parents=True, exist_ok=True)
    for name, text in case.robot.files.items():
        (folder / "cell" / name).write_text(text)
    for log in case.logs:
        _table(case, log, folder)


def _cells(case: Case, log: Log) -> dict[str, np.ndarray]:
    """Columns by the format's names, in degrees, mm, seconds; NaN where nothing was measured."""
    plan, robot = case.plan, case.robot
    unit = np.array([1.0 if j.slides else 180 / np.pi for j in robot.joints])
    out: dict[str, np.ndarray] = {"t": log.seen.t}
    logged = set(plan.logged)
    if "set" in logged:
        out |= {f"c{n}": log.seen.set[:, i] * unit[i] for i, n in enumerate(robot.names)}
    if "enc" in logged:
        out |= {n: log.enc[:, i] * unit[i] for i, n in enumerate(robot.names)}
    if "motor" in logged:
        out |= {f"M{n[1:]}": log.motor[:, i] * unit[i] for i, n in enumerate(robot.names) if n[0] == "A"}
    if logged & {"torque", "current"}:
        for i, n in enumerate(robot.names):
            if n[0] == "A":
                what = f"I{n[1:]}" if "current" in logged else f"T{n[1:]}"
                out[what] = log.torque[:, i] / (9.0 + 7.0 * i if "current" in logged else 1.0)
    if "temp" in logged:
        warm = log.run.warm if log.run.warm is not None else np.full(len(log.run.t), 23.0)
        out["temp"] = np.round(warm[log.seen.rows], 1)
    if "force" in logged:
        out |= {f"f{c}": log.run.push[log.seen.rows, k] for k, c in enumerate("xyz")}
    if plan.see:
        xyz = log.pose[:, :3, 3].copy()
        if plan.see == "probe":
            from .case import touched

            seen = touched(len(xyz))
            for k in range(3):
                xyz[seen != k, k] = np.nan
        out |= {c: xyz[:, k] for k, c in enumerate("xyz")}
    if plan.see == "pose":
        for k, c in enumerate("abc"):
            out[c] = Rotation.from_matrix(log.pose[:, :3, :3]).as_euler("ZYX", degrees=True)[:, k]
    return out


def _facts(case: Case, log: Log) -> str:
    """LOG.toml's part before the table."""
    plan = case.plan
    rows = []
    if plan.see:
        rows += [f'measured_frame = "{plan.frame}"', f'target = "{plan.target}"']
        told = plan.told if plan.told is not None else float(np.sqrt(np.mean(np.square(plan.sigma))))
        rows.append(f"sigma_mm = {round(told, 4)}")
        if plan.see == "pose":
            rows.append(f"sigma_deg = {SIGMA_DEG}")
        if log.name != "run_1" and plan.frame == "unknown":
            rows.append('same_frame_as = "run_1.csv"')
        if log.name != "run_1" and plan.target == "unknown":
            rows.append('same_target_as = "run_1.csv"')
    if any(not j.slides for j in case.robot.joints):
        rows.append(f"sigma_axis_deg = {np.degrees(ENCODER[0]):.4f}")
    if any(j.slides for j in case.robot.joints):
        rows.append(f"sigma_axis_mm = {ENCODER[1]}")
    if log.run.told is not None:
        rows.append(f"payload_kg = {log.run.told}")
    if plan.tolerance:
        rows.append(f"tolerance_mm = {plan.tolerance}")
    if log.run.poses:
        rows.append("poses = true")
    return "\n".join(rows) + "\n"


def _kind(case: Case, name: str) -> str:
    """What a column holds: time, turn, slide, place, tilt, other."""
    if name == "t":
        return "time"
    axis = {"c": name[1:], "M": "A" + name[1:]}.get(name[0], name)
    if name not in "abc" and axis in case.robot.names:
        return "slide" if case.robot.joints[case.robot.index(axis)].slides else "turn"
    return "place" if name in "xyz" else "tilt" if name in "abc" else "other"


# separator, decimal, angles, lengths, time unit, names of: encoder, set-point, place
SHEETS = {
    "plain": (",", ".", "deg", "mm", "s", "{}", "c{}", "{}"),
    "rtde": (" ", ".", "rad", "m", "s", "actual_q_{}", "target_q_{}", "leica_{}"),
    "karel": ("\t", ".", "deg", "mm", "ms", "J_{}", "JCMD_{}", "TRK_{}"),
    "rapid": (";", ",", "deg", "mm", "s", "pos_{}", "ref_{}", "Messpunkt {}"),
    "trace": (";", ".", "deg", "mm", "s", "AxisAct{}", "AxisCmd{}", "Point.{}"),
    "val3": (",", ".", "rad", "mm", "us", "j[{}]", "jcmd[{}]", "probe {}"),
    "beside": ("\t", ".", "deg", "mm", "s", "axis {}", "axis {} cmd", "{}"),
    "counts": ("|", ".", "deg", "mm", "s", "enc_{}", "cmd_{}", "m_{}"),
    "ros": (",", ".", "rad", "m", "ns", "position", "reference", "point"),
    "inch": (",", ".", "deg", "inch", "s", "Joint {}", "Joint {} target", "Meas {}"),
    "balls": (";", ".", "deg", "mm", "s", "q{}", "q{}_set", "{}"),
}  # fmt: skip


def _title(sheet: str, name: str, kind: str) -> str:
    if sheet == "plain":
        return name
    *_, encoder, setpoint, seen = SHEETS[sheet]
    if kind in ("turn", "slide") and name[0] == "c":
        return setpoint.format(name[1:])
    if kind in ("turn", "slide") and name[0] == "M":
        return f"motor_{name[1:]}"
    if kind in ("turn", "slide"):
        return encoder.format(name)
    if kind in ("place", "tilt"):
        return seen.format(name.upper() if sheet in ("inch", "rapid") else name)
    return {"t": "timestamp"}.get(name, f"{name}_signal")


def _number(x: float, digits: int, decimal: str) -> str:
    return "" if np.isnan(x) else f"{x:.{digits}f}".replace(".", decimal)


def _clock(t: np.ndarray, sheet: str, unit: str, decimal: str) -> list[str]:
    if sheet in ("rapid", "inch"):
        start = datetime.datetime(2026, 3, 9, 7, 41, 12)
        return [(start + datetime.timedelta(seconds=float(x))).isoformat(timespec="milliseconds") for x in t]
    if unit == "ns":
        return [str(1773042072000000000 + round(x * 1e9)) for x in t]
    if unit == "us":
        return [str(round(x * 1e6)) for x in t]
    return [_number(x * (1000 if unit == "ms" else 1), 1 if unit == "ms" else 5, decimal) for x in t]


def _table(case: Case, log: Log, folder: Path) -> None:
    sheet = case.plan.sheet
    if sheet == "ros":
        return _lists(case, log, folder)
    cells = _cells(case, log)
    separator, decimal, angles, lengths, time, *_ = SHEETS[sheet]
    head, columns, told, extra = [], [], [], ""
    if sheet == "trace" and not log.run.poses:
        cells.pop("t")
        extra = f"step_s = {float(np.round(log.seen.t[1] - log.seen.t[0], 6))}\n"
    if sheet == "karel" and "A3" in cells:  # counts from the horizontal
        for c in ("", "c"):
            if f"{c}A3" in cells:
                cells[f"{c}A3"] = cells[f"{c}A3"] - cells[f"{c}A2"]
        extra += 'add = { A3 = "A2" }\n'
    for name, x in cells.items():
        kind = _kind(case, name)
        title = _title(sheet, name, kind)
        if name == "A4" and case.robot.tied:
            told.append(f'A4 = "{_title(sheet, "A3", "turn")}"')  # the hand stays upright
            continue
        text, entry = _column(sheet, name, kind, title, x, (angles, lengths, time, decimal))
        head.append(title)
        columns.append(text)
        told.append(f"{name} = {entry}")
    if case.plan.see == "pose" and sheet in ("rapid", "rtde", "val3"):
        extra += _tilts(log, sheet, head, columns, told, decimal)
    toml = _facts(case, log)
    if sheet == "beside":
        extra += _apart(log, folder, head, columns, told)
    if sheet == "balls":
        extra += _two_balls(log, head, columns)
    lines = [separator.join(row) for row in zip(*columns, strict=True)]
    if sheet == "karel":
        lines = [f"% {case.robot.name} {case.plan.title}", separator.join(head), *lines]
    elif sheet == "balls":
        lines = [separator.join(head), *_with_second(lines, columns, head)]
    else:
        lines = [separator.join(head), *lines]
    (folder / f"{log.name}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    if sheet != "plain":
        sep = {"\t": "\\t"}.get(separator, separator)
        header = 2 if sheet == "karel" else 1
        toml += f'\n[table]\nseparator = "{sep}"\ndecimal = "{decimal}"\nheader = {header}\n'
        toml += f'angles = "{angles}"\nlengths = "{lengths}"\ntime = "{time}"\n'
        toml += extra + "[table.columns]\n" + "\n".join(told) + "\n"
    (folder / f"{log.name}.toml").write_text(toml, encoding="utf-8")


def _column(sheet, name, kind, title, x, units):
    """Cells of a column as text, and its entry in `[table.columns]`."""
    angles, lengths, time, decimal = units
    if kind == "time":
        return _clock(x, sheet, time, decimal), f'"{title}"'
    if kind == "turn":
        if sheet == "counts":
            return [
                str(round(v * 2500.0 + 4000)) for v in x
            ], f'{{ column = "{title}", scale = 0.0004, offset = -1.6 }}'
        factor, digits = (np.pi / 180, 7) if angles == "rad" else (1.0, 5)
        entry = f'{{ column = "{title}", unit = "{angles}" }}' if "E" in name else f'"{title}"'
        return [_number(v * factor, digits, decimal) for v in x], entry
    if kind == "slide":
        return [
            _number(v * LENGTH[lengths], 7 if lengths == "m" else 5, decimal) for v in x
        ], f'{{ column = "{title}", unit = "{lengths}" }}'
    if kind == "place":
        return [_number(v * LENGTH[lengths], 7 if lengths != "mm" else 4, decimal) for v in x], f'"{title}"'
    if kind == "tilt":
        factor = np.pi / 180 if angles == "rad" else 1.0
        return [_number(v * factor, 6, decimal) for v in x], f'"{title}"'
    return [_number(v, 3, decimal) for v in x], f'"{title}"'


def _tilts(log, sheet, head, columns, told, decimal) -> str:
    """Orientations in the sheet's own way, in place of a, b, c."""
    for c in "abc":
        k = next(i for i, e in enumerate(told) if e.startswith(f"{c} = "))
        del told[k]
        title = _title(sheet, c, "tilt")
        at = head.index(title)
        del head[at], columns[at]
    R = Rotation.from_matrix(log.pose[:, :3, :3])
    if sheet == "rapid":
        way, names, x = "wxyz", ["q1", "q2", "q3", "q4"], R.as_quat()[:, [3, 0, 1, 2]]
    elif sheet == "rtde":
        way, names, x = "rotvec", ["rx", "ry", "rz"], R.as_rotvec()
    else:
        way, names, x = "xyz", ["rx", "ry", "rz"], R.as_euler("XYZ")
    head += names
    columns += [[_number(v, 7, decimal) for v in x[:, k]] for k in range(len(names))]
    return f'orientation = {{ as = "{way}", columns = {names} }}\n'.replace("'", '"')


def _apart(log, folder, head, columns, told) -> str:
    """The tracker's points in a file of their own, without a header."""
    rows = []
    for c in "xyz":
        k = head.index(c)
        rows.append(columns[k])
        del head[k], columns[k]
        told.remove(f'{c} = "{c}"')
    told += [f"{c} = {len(head) + k + 1}" for k, c in enumerate("xyz")]
    text = "\n".join(" ".join(v or "NaN" for v in row) for row in zip(*rows, strict=True)) + "\n"
    (folder / f"{log.name}_points.txt").write_text(text)
    return f'beside = {{ file = "{log.name}_points.txt", separator = " ", header = 0 }}\n'


def _two_balls(log, head, columns) -> str:
    """A column that says which of two reflectors a row is of."""
    head.insert(0, "nest")
    columns.insert(0, ["B"] * len(log.seen.t))
    return 'rows = { column = "nest", is = "B" }\n'


def _with_second(lines, columns, head) -> list[str]:
    """Rows of another reflector in between, which the table's owner leaves out."""
    out = []
    at = [head.index(c) for c in "xyz"]
    for k, row in enumerate(lines):
        other = [c[k] for c in columns]
        other[0] = "A"
        for i in at:
            other[i] = _number(float(other[i] or "nan") + 81.3, 4, ".")
        out += [";".join(other), row] if k % 3 else [row]
    return out


def _lists(case: Case, log: Log, folder: Path) -> None:
    """A recorder of messages: lists in quoted cells, nanoseconds since 1970."""
    cells = _cells(case, log)
    groups = {
        "position": [n for n in case.robot.names if n in cells],
        "reference": [f"c{n}" for n in case.robot.names if f"c{n}" in cells],
        "effort": [n for n in cells if n[0] in "TI" and n != "t" and n != "temp"],
        "point": [c for c in "xyz" if c in cells],
    }
    lines, told = [",".join(["stamp", *(g for g, names in groups.items() if names)])], ['t = "stamp"']
    stamps = _clock(cells["t"], "ros", "ns", ".")
    scale = {
        n: (np.pi / 180 if _kind(case, n) == "turn" else 1e-3 if _kind(case, n) in ("slide", "place") else 1.0)
        for n in cells
    }
    for k, stamp in enumerate(stamps):
        row = [stamp]
        for names in groups.values():
            if names:
                row.append('"[' + ", ".join(_number(cells[n][k] * scale[n], 8, ".") or "NaN" for n in names) + ']"')
        lines.append(",".join(row))
    for g, names in groups.items():
        for m, n in enumerate(names):
            unit = ', unit = "m"' if _kind(case, n) == "slide" else ""
            told.append(f'{n} = {{ column = "{g}", item = {m + 1}{unit} }}')
    (folder / f"{log.name}.csv").write_text("\n".join(lines) + "\n")
    toml = (
        _facts(case, log)
        + '\n[table]\nseparator = ","\ndecimal = "."\nheader = 1\nangles = "rad"\nlengths = "m"\ntime = "ns"\n'
    )
    (folder / f"{log.name}.toml").write_text(toml + "[table.columns]\n" + "\n".join(told) + "\n")
