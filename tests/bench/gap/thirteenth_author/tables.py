"""Records as shops keep them, with the LOG.toml that says how to read each."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import datetime, timedelta

import numpy as np
from scipy.spatial.transform import Rotation

from .orders import INSTRUMENTS
from .park import cell_text

LENGTH = {"mm": 1.0, "m": 1e-3, "cm": 0.1, "inch": 1 / 25.4}
CLOCK = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}


@dataclass(frozen=True)
class Form:
    """How a table is written; `names` by the first letters of a column's name, `{}` its number."""

    names: dict = field(default_factory=dict)
    separator: str = ","
    decimal: str = "."
    angles: str = "deg"
    lengths: str = "mm"
    clock: str = "s"
    epoch: int = 0  # ns since 1970
    preamble: tuple = ()
    gaps: bool = False  # the beam is cut now and then
    add: bool = False  # A3 counts from the level
    lists: bool = False
    beside: bool = False
    stamps: bool = False  # dates as ISO 8601 writes them
    counts: bool = False
    turns: str = ""  # as orientations are written
    workbook: bool = False


FORMS = {
    "plain": Form(),
    "semicolon": Form(
        {
            "t": "Zeit",
            "x": "X_Mess",
            "y": "Y_Mess",
            "z": "Z_Mess",
            "A": "Achse{}_ist",
            "cA": "Achse{}_soll",
            "I": "Strom{}",
        },
        ";",
        ",",
        preamble=("Instandhaltung;Protokoll", "Pruefer;Hm"),
        gaps=True,
    ),
    "fanuc": Form({"t": "TICK", "A": "J{}", "cA": "J{}_CMD"}, clock="ms", add=True),
    "fanuc_free": Form({"t": "time", "A": "ax_{}", "cA": "ax_{}_ref"}, add=True, separator="|"),
    "tabs": Form({"t": "TIME", "A": "JT{}", "cA": "CMD{}", "E": "RAIL{}"}, "\t", gaps=True),
    "lists": Form({}, angles="rad", lengths="m", clock="ns", epoch=1_790_000_000 * 10**9, lists=True),
    "rtde": Form({"t": "timestamp", "A": "actual_q_{}", "cA": "target_q_{}"}, " ", angles="rad", lengths="m"),
    "quoted": Form(
        {"t": "Elapsed (s)", "x": "X, mm", "y": "Y, mm", "z": "Z, mm", "A": "Joint {} actual", "cA": "Joint {} target"},
        gaps=True,
    ),
    "beside": Form(beside=True, separator="\t"),
    "inch": Form({"t": "usec", "A": "axis{}"}, lengths="inch", clock="us"),
    "centimetres": Form({"A": "Ax{}", "E": "Drum{}"}, lengths="cm", separator=";"),
    "celsius": Form({"t": "Zeit", "temp": "Temp_Arm", "A": "A{}_ist"}, ";", ","),
    "iso_clock": Form({"t": "stamp", "A": "a{}"}, stamps=True),
    "counts": Form({"A": "INC{}", "cA": "SET{}"}, counts=True),
    "rotvec": Form({"A": "q{}", "cA": "qd{}"}, angles="rad", lengths="m", turns="rotvec"),
    "workbook": Form({"t": "sec", "A": "A{}_deg"}, ";", workbook=True),
}


def columns_of(order, log):
    """Names of the format and values in its units."""
    m, run, out = log.run.m, log.run, {"t": log.run.t}
    if log.seen is not None:
        out.update({d: 1000 * log.seen[:, k, 3] for k, d in enumerate("xyz")})
        if INSTRUMENTS[order.sees].sigma_deg:
            turns = Rotation.from_matrix(log.seen[:, :3, :3]).as_euler("ZYX", degrees=True)
            out.update({n: turns[:, k] for k, n in enumerate("abc")})
    for i, axis in enumerate(m.axes):
        out[axis.name] = log.encoders[:, i] / m.unit[i]
        if log.setpoints is not None:
            out["c" + axis.name] = log.setpoints[:, i] / m.unit[i]
        if log.motors is not None:
            out["M" + axis.name[1:]] = log.motors[:, i] / m.unit[i]
        if log.effort is not None and i < 6:
            out[order.columns + axis.name[1:]] = log.effort[:, i]
    if run.temp is not None:
        out["temp"] = run.temp
    if run.force is not None:
        out.update({n: run.force[:, k] + 0.8 * np.sin(29 * run.t + k) for k, n in enumerate(("fx", "fy", "fz"))})
    return out


def settings(order, log, logs):
    """What stands in LOG.toml beside the table."""
    instrument, out = INSTRUMENTS.get(order.sees), {}
    first = next(x for x in logs if not (order.before and x.run.name == "before") or x is log)
    if instrument is not None:
        out = {"measured_frame": instrument.frame, "target": instrument.target, "instrument": instrument.name}
        out["sigma_mm"] = float(np.sqrt(np.mean(np.square(instrument.sigma)) * (1 + order.wander**2)))
        if instrument.sigma_deg:
            out["sigma_deg"] = instrument.sigma_deg
        if log is not first and instrument.frame == "unknown":
            out["same_frame_as"] = first.run.name + ".csv"
        if log is not logs[0] and instrument.target == "unknown":
            out["same_target_as"] = logs[0].run.name + ".csv"
    out["sigma_axis_deg"] = 0.0002 if order.sees else 0.0015
    if any(log.run.m.slides):
        out["sigma_axis_mm"] = 0.0004 if order.sees else 0.003
    if log.run.m.load:
        out["payload_kg"] = log.run.m.load
    if order.tolerance_mm:
        out["tolerance_mm"] = order.tolerance_mm
    if log.run.rests:
        out["poses"] = True
    return out


def _named(form, column):
    head = column.rstrip("0123456789")
    return form.names.get(head, head + "{}").format(column[len(head) :])


def _clock(form, t):
    if form.stamps:
        start = datetime(2026, 9, 14, 5, 58, 12)
        return [(start + timedelta(seconds=float(v))).isoformat(timespec="microseconds") for v in t]
    if form.clock == "s":
        return [f"{v:.6f}" for v in t]
    return [str(form.epoch + round(CLOCK[form.clock] * float(v))) for v in t]


def _cells(order, form, columns, m, table):
    """Columns of text by the format's names; what has to be said of them goes into `table`."""
    out, said = {}, {}
    lost = np.random.default_rng(len(columns["t"])).uniform(size=len(columns["t"])) < 0.008
    for name, values in columns.items():
        v, word = np.array(values, float), _named(form, name)
        said[name] = word
        if name == "t":
            if form.counts:
                table["step_s"] = float(np.round(np.median(np.diff(v)), 9))
                said.pop("t")
                continue
            out[word] = _clock(form, v)
            continue
        if form.add and name in ("A3", "cA3"):
            v = v - columns[name[:-1] + "2"]
        if name in "xyz":
            v = v * LENGTH[form.lengths]
        axis = name.lstrip("c").replace("M", "A")
        turning = axis in m.names and not m.slides[m.names.index(axis)]
        if form.angles == "rad" and turning:
            v = np.radians(v)
        if form.counts and turning:
            out[word] = [str(n) for n in np.round((v + 30.0) / 2e-4).astype(int)]
            said[name] = {"column": word, "scale": 2e-4, "offset": -30.0}
            continue
        digits = 9 if form.angles == "rad" or form.lengths != "mm" else 6
        if axis in m.names and axis.startswith("E"):  # a word of its own does not say whether it turns
            said[name] = {"column": word, "unit": "deg" if turning else "mm"}
        cells = [f"{x:.{digits}f}" for x in v]
        if form.gaps and name in "xyz" and not log_rests(order):
            cells = ["" if gone else c for c, gone in zip(cells, lost, strict=True)]
        out[word] = cells
    return out, said


def log_rests(order):
    """Whether an order is measured in poses at rest."""
    return order.moves in ("tracker_poses", "both_sides", "check_days", "nests", "stations", "single_turns", "grid")


def _turned(form, columns, out, said, table):
    """Orientations as rotation vectors."""
    if form.turns and "a" in columns:
        vectors = Rotation.from_euler("ZYX", np.stack([columns[n] for n in "abc"], axis=1), degrees=True).as_rotvec()
        for n in "abc":
            out.pop(said.pop(n))
        out.update({f"r{d}": [f"{x:.9f}" for x in vectors[:, k]] for k, d in enumerate("xyz")})
        table["orientation"] = {"as": "rotvec", "columns": ["rx", "ry", "rz"]}


def _packed(out, said):
    """Cells that hold lists: joints, points, torques."""
    groups = {"position": [n for n in said if n[0] == "A"], "target": [n for n in said if n[:2] == "cA"]}
    groups |= {"effort": [n for n in said if n[0] == "T"], "point": [n for n in said if n in "xyz"]}
    cells, columns = {"stamp": out[said["t"]]}, {"t": "stamp"}
    for name, members in groups.items():
        if members:
            cells[name] = ["[" + ", ".join(row) + "]" for row in zip(*[out[said[n]] for n in members], strict=True)]
            columns |= {n: {"column": name, "item": k + 1} for k, n in enumerate(members)}
    return cells, columns


def _text(form, cells, head=True):
    """Lines of a table; cells with its separator are quoted."""

    def cell(c):
        if form.decimal != "." and c[:1] in "-0123456789" and c.count(".") == 1:
            c = c.replace(".", form.decimal)
        return f'"{c}"' if form.separator != " " and form.separator in c else c

    lines = [form.separator.join(cell(n) for n in cells)] if head else []
    return lines + [form.separator.join(cell(c) for c in row) for row in zip(*cells.values(), strict=True)]


def _toml(value):
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{k} = {_toml(v)}" for k, v in value.items()) + " }"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace("\t", "\\t").replace('"', '\\"') + '"'
    if isinstance(value, list):
        return "[" + ", ".join(_toml(v) for v in value) + "]"
    return f"{value:.10g}"


def _table(order, form, log):
    """Lines of the file, [table] and [table.columns] (dicts), and a second file's lines if there is one."""
    columns, table, second = columns_of(order, log), {}, None
    out, said = _cells(order, form, columns, log.run.m, table)
    _turned(form, columns, out, said, table)
    if form.lists:
        out, said = _packed(out, said)
    if form.separator != ",":
        table["separator"] = form.separator
    if form.decimal != ".":
        table["decimal"] = form.decimal
    if form.preamble:
        table["header"] = len(form.preamble) + 1
    for key, value, usual in (
        ("angles", form.angles, "deg"),
        ("lengths", form.lengths, "mm"),
        ("time", form.clock, "s"),
    ):
        if value != usual:
            table[key] = value
    if form.add:
        table["add"] = {"A3": "A2"}
    if form.beside:
        points = {n: out.pop(said[n]) for n in "xyz"}
        order_of = [*out, *points]
        said = {n: order_of.index(w if w in out else n) + 1 for n, w in said.items()}
        table |= {"header": 0, "beside": {"file": f"{log.run.name}_points.txt", "separator": " ", "header": 0}}
        second = [" ".join(row) for row in zip(*points.values(), strict=True)]
    return [*form.preamble, *_text(form, out, not form.beside)], table, said, second


def write(case, folder):
    """cell/cell.toml, the records and what is said of each; names of the records, the withheld ones apart."""
    (folder / "cell").mkdir(parents=True, exist_ok=True)
    (folder / "cell" / "cell.toml").write_text(
        cell_text(case.logs[0].run.m if not case.order.loads else _told(case)), encoding="utf-8"
    )
    form, names = FORMS[case.order.form], ([], [])
    written = [_table(case.order, form, log) for log in case.logs]
    for log, (lines, table, said, second) in zip(case.logs, written, strict=True):
        name = log.run.name
        if form.workbook:
            sheets = zip(case.logs, written, strict=True)
            rows = [f"{other.run.name};{line}" for other, (theirs, _, _, _) in sheets for line in theirs[1:]]
            lines = ["state;" + lines[0], *rows]
            table = {**table, "rows": {"column": "state", "is": name}}
        (folder / f"{name}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
        if second is not None:
            (folder / f"{name}_points.txt").write_text("\n".join(second) + "\n", encoding="utf-8")
        told = [f"{k} = {_toml(v)}" for k, v in settings(case.order, log, case.logs).items()]
        if case.order.form != "plain":
            told += ["", "[table]", *(f"{k} = {_toml(v)}" for k, v in table.items())]
            told += ["", "[table.columns]", *(f"{k} = {_toml(v)}" for k, v in said.items())]
        (folder / f"{name}.toml").write_text("\n".join(told) + "\n", encoding="utf-8")
        names[log.withheld].append(f"{name}.csv")
    return names


def _told(case):
    """The machine with the least of its loads."""
    return case.logs[0].run.m.carrying(min(case.order.loads))
