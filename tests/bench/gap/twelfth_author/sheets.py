"""Logs as shops write them, each with what its LOG.toml has to say."""

from __future__ import annotations

import csv
import io
from datetime import datetime, timedelta

import numpy as np
from scipy.spatial.transform import Rotation

from .fleet import cell_text
from .plan import INSTRUMENTS

NANO_1970 = 1_764_300_000 * 10**9


def columns_of(spec, log):
    """Names of the format with values in its units (dict of (N,))."""
    chain, run = log.run.chain, log.run
    out = {"t": run.t}
    instrument = INSTRUMENTS.get(spec.sees)
    if instrument is not None:
        for k, d in enumerate("xyz"):
            if d in instrument.only:
                out[d] = 1000 * log.tip[:, k, 3]
        if instrument.sigma_deg:
            turns = Rotation.from_matrix(log.tip[:, :3, :3]).as_euler("ZYX", degrees=True)
            out.update({n: turns[:, k] for k, n in enumerate("abc")})
    for i, joint in enumerate(chain.joints):
        out[joint.name] = log.encoders[:, i] / chain.unit[i]
        if log.setpoints is not None:
            out["c" + joint.name] = log.setpoints[:, i] / chain.unit[i]
        if log.motors is not None:
            out["M" + joint.name[1:]] = log.motors[:, i] / chain.unit[i]
        if log.currents is not None and i < 6:
            out[spec.columns + joint.name[1:]] = log.currents[:, i]
    if run.temp is not None:
        out["temp"] = run.temp
    if run.force is not None:
        out.update({n: run.force[:, k] + 2.0 * np.sin(37 * run.t + k) for k, n in enumerate(("fx", "fy", "fz"))})
    return out


def _toml(value):
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{k} = {_toml(v)}" for k, v in value.items()) + " }"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace("\t", "\\t") + '"'
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml(v) for v in value) + "]"
    return f"{value:.10g}"


def settings(spec, log, first):
    """What LOG.toml says beside [table] (dict)."""
    instrument, out = INSTRUMENTS.get(spec.sees), {}
    if instrument is not None:
        out["measured_frame"], out["target"], out["instrument"] = instrument.frame, instrument.target, instrument.name
        seen = [s for s, d in zip(instrument.sigma_mm, "xyz", strict=True) if d in instrument.only]
        out["sigma_mm"] = float(np.sqrt(np.mean(np.square(seen))))
        if instrument.sigma_deg:
            out["sigma_deg"] = instrument.sigma_deg
        if log is not first and instrument.frame == "unknown":
            out["same_frame_as"] = first.run.name + ".csv"
        if log is not first and instrument.target == "unknown":
            out["same_target_as"] = first.run.name + ".csv"
    out["sigma_axis_deg"] = 0.0003 if spec.sees else 0.001
    if any(log.run.chain.sliding):
        out["sigma_axis_mm"] = 0.0005 if spec.sees else 0.002
    if log.run.chain.payload:
        out["payload_kg"] = log.run.chain.payload
    if spec.tolerance_mm:
        out["tolerance_mm"] = spec.tolerance_mm
    if log.run.poses:
        out["poses"] = True
    return out


def _written(names, columns, separator=",", decimal=".", head=True):
    stream = io.StringIO()
    writer = csv.writer(stream, delimiter=separator, lineterminator="\n")
    if head:
        writer.writerow(names)
    for row in zip(*columns, strict=True):
        cells = [v if isinstance(v, str) else str(v) if isinstance(v, int) else f"{v:.6f}" for v in row]
        writer.writerow([c.replace(".", decimal) if decimal != "." and not c.startswith("[") else c for c in cells])
    return stream.getvalue()


def _plain(spec, c, chain):
    return _written(list(c), list(c.values())), None, {}


def _named(c, names):
    return {k: names.get(k, k) for k in c}


def _semicolon(spec, c, chain, decimal=","):
    names = {"t": "Zeit [s]", "x": "X_mess", "y": "Y_mess", "z": "Z_mess", "temp": "Temperatur Arm"}
    names.update(
        {n: f"Achse {n[1:]} Ist" for n in c if n[0] in "A"} | {n: f"Achse {n[2:]} Soll" for n in c if n[:2] == "cA"}
    )
    names = _named(c, names)
    table = {"separator": ";", "decimal": decimal, "columns": {k: v for k, v in names.items()}}
    return _written(list(names.values()), list(c.values()), ";", decimal), table, {}


def _tabs(spec, c, chain):
    names = _named(
        c,
        {"t": "TIME", **{n: "JT" + n[1:] for n in c if n[0] == "A"}, **{n: "JTC" + n[2:] for n in c if n[:2] == "cA"}},
    )
    lines = _written(list(names.values()), list(c.values()), "\t").splitlines()
    lines.insert(len(lines) // 2, "# tape changed")
    return "\n".join(lines) + "\n", {"separator": "\t", "columns": names}, {}


def _fanuc(spec, c, chain):
    c = dict(c)
    for n in ("A", "cA"):
        if n + "3" in c:
            c[n + "3"] = c[n + "3"] - c[n + "2"]
    c["t"] = [int(v) for v in np.round(1000 * c["t"])]
    names = _named(
        c,
        {
            "t": "TICK",
            **{n: "J" + n[1:] for n in c if n[0] == "A"},
            **{n: "J" + n[2:] + "_CMD" for n in c if n[:2] == "cA"},
        },
    )
    return _written(list(names.values()), list(c.values())), {"time": "ms", "add": {"A3": "A2"}, "columns": names}, {}


def _rtde(spec, c, chain):
    c, columns, names = dict(c), {}, {}
    for n in list(c):
        name = {"t": "timestamp"}.get(n, n)
        if n[0] in "AcI" and n[-1].isdigit() and "E" not in n:
            kind = {"A": "actual_q", "c": "target_q", "I": "actual_current"}[n[0]]
            name = f"{kind}_{int(n[-1]) - 1}"
            if n[0] != "I":
                c[n] = np.radians(c[n])
        if n in "xyz" or n in ("E1", "cE1"):
            c[n] = c[n] / 1000
        names[n] = name
        columns[n] = {"column": name, "unit": "m"} if n in ("E1", "cE1") else name
    shown = {k: [f"{v:.8f}" for v in c[k]] for k in c}
    table = {"separator": " ", "angles": "rad", "lengths": "m", "columns": columns}
    return _written(list(names.values()), list(shown.values()), " "), table, {}


def _lists(spec, c, chain):
    n = len(c["t"])
    groups = {
        "position": [k for k in c if k[0] == "A"],
        "desired": [k for k in c if k[:2] == "cA"],
        "effort": [k for k in c if k[0] == "T"],
    }
    groups["point"] = [k for k in "xyz" if k in c]
    names, cells, columns = ["stamp"], [[NANO_1970 + round(1e9 * v) for v in c["t"]]], {"t": "stamp"}
    for name, members in groups.items():
        if not members:
            continue
        scale = np.pi / 180 if name in ("position", "desired") else 1e-3 if name == "point" else 1.0
        names.append(name)
        cells.append(["[" + ", ".join(f"{scale * c[k][r]:.8f}" for k in members) + "]" for r in range(n)])
        columns.update({k: {"column": name, "item": j + 1} for j, k in enumerate(members)})
    return _written(names, cells), {"time": "ns", "angles": "rad", "lengths": "m", "columns": columns}, {}


def _quaternion(spec, c, chain):
    q = Rotation.from_euler("ZYX", np.stack([c[n] for n in "abc"], axis=1), degrees=True).as_quat()
    out = {k: v for k, v in c.items() if k not in "abc"}
    names = _named(
        out, {"t": "seconds", "x": "px", "y": "py", "z": "pz", **{n: "joint_" + n[1:] for n in out if n[0] == "A"}}
    )
    shown = list(out.values()) + [[f"{v:.9f}" for v in q[:, k]] for k in (3, 0, 1, 2)]
    turns = {"as": "wxyz", "columns": ["qw", "qx", "qy", "qz"]}
    return _written([*names.values(), "qw", "qx", "qy", "qz"], shown), {"orientation": turns, "columns": names}, {}


def _beside(spec, c, chain):
    joints = {k: v for k, v in c.items() if k not in "xyz"}
    points = [c[k] for k in "xyz"]
    columns = {k: j + 1 for j, k in enumerate(joints)} | {k: len(joints) + j + 1 for j, k in enumerate("xyz")}
    second = _written([], points, " ", head=False)
    table = {"header": 0, "beside": {"file": "{name}_points.txt", "separator": " ", "header": 0}, "columns": columns}
    return _written([], list(joints.values()), head=False), table, {"{name}_points.txt": second}


def _gauge(spec, c, chain):
    names = {"t": "t", "A1": "Position", "z": "Laser_mm"}
    columns = {**names, "x": {"value": 0}, "y": {"value": 0}}
    return _written(list(names.values()), [c[k] for k in names]), {"columns": columns}, {}


def _inch(spec, c, chain):
    c = dict(c)
    for d in "xyz":
        c[d] = [f"{v / 25.4:.8f}" for v in c[d]]
    c["t"] = [round(1e6 * v) for v in c["t"]]
    names = _named(c, {"t": "usec", **{n: "j" + n[1:] for n in c if n[0] == "A"}})
    return _written(list(names.values()), list(c.values())), {"time": "us", "lengths": "inch", "columns": names}, {}


def _counts(spec, c, chain):
    shown, names, columns = {}, {}, {}
    for k, v in c.items():
        names[k] = columns[k] = k
        shown[k] = v
        if k[0] in "Ac":
            scale = -0.0005 if k[-1] in "25" else 0.0005
            names[k] = ("INC" if k[0] == "A" else "INCSOLL") + k[-1]
            shown[k] = [int(n) for n in np.round((np.asarray(v) - 12.5) / scale)]
            columns[k] = {"column": names[k], "scale": scale, "offset": 12.5}
    return _written(list(names.values()), list(shown.values())), {"columns": columns}, {}


def _iso_clock(spec, c, chain):
    start = datetime(2026, 3, 9, 6, 12, 30)
    c = dict(c)
    c["t"] = [(start + timedelta(seconds=float(v))).isoformat(timespec="microseconds") for v in c["t"]]
    names = _named(
        c,
        {
            "t": "Zeitstempel",
            **{n: "ax" + n[1:] for n in c if n[0] == "A"},
            **{n: "ax" + n[2:] + "_ref" for n in c if n[:2] == "cA"},
        },
    )
    return _written(list(names.values()), list(c.values())), {"columns": names}, {}


FORMS = {
    "plain": _plain,
    "semicolon": _semicolon,
    "tabs": _tabs,
    "fanuc": _fanuc,
    "rtde": _rtde,
    "lists": _lists,
    "quaternion": _quaternion,
    "beside": _beside,
    "gauge": _gauge,
    "inch": _inch,
    "counts": _counts,
    "iso_clock": _iso_clock,
    "celsius": _semicolon,
}


def write(case, folder):
    """A folder with cell/cell.toml and each log with its .toml; gives the logs' names, the withheld ones apart."""
    (folder / "cell").mkdir(parents=True, exist_ok=True)
    told = case.chain
    (folder / "cell" / "cell.toml").write_text(cell_text(told), encoding="utf-8")
    names = ([], [])
    for log in case.logs:
        text, table, more = FORMS[case.spec.form](case.spec, columns_of(case.spec, log), log.run.chain)
        name = log.run.name
        (folder / f"{name}.csv").write_text(text, encoding="utf-8")
        for other, content in more.items():
            (folder / other.format(name=name)).write_text(content, encoding="utf-8")
        lines = [f"{k} = {_toml(v)}" for k, v in settings(case.spec, log, case.logs[0]).items()]
        if table is not None:
            columns = table.pop("columns")
            lines += ["", "[table]"] + [f"{k} = {_toml(v).replace('{name}', name)}" for k, v in table.items()]
            lines += ["", "[table.columns]"] + [f"{k} = {_toml(v)}" for k, v in columns.items()]
        (folder / f"{name}.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
        names[log.withheld].append(f"{name}.csv")
    return names
