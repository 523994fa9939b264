"""What strangers bring to `camrob diagnose`: logs of hand-made arms, most with something amiss, and what a good answer is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from stranger_arms import (
    DEG,
    KR,
    ONE,
    SEVEN,
    UR,
    Faults,
    Machine,
    columns_of,
    driven,
    followed,
    loose,
    pulled,
    rigid,
    scattered,
    text,
    true_poses,
)

INSTRUMENT, TARGET = rigid(0.8, -0.6, 0.4, 1.2, (0.2, 0.1, 1.0)), rigid(0.02, 0.03, 0.05, 0.4, (1, 0, 0))
ALL_UNKNOWN = 'measured_frame = "unknown"\ntarget = "unknown"\n'
SIGMA = 1e-5
PLACE, TURNING = ("x", "y", "z"), [f"A{k}" for k in range(1, 7)]
ZEROS, GIVE = {1: 0.12 * DEG, 2: -0.1 * DEG}, {1: 4e-6, 2: 5e-6}
SMOOTH = {"joint_offset", "geometry", "joint_compliance", "payload"}
COLUMN = Machine(
    UR.cell.replace('name = "bare_ur5"', 'name = "lift"').replace(
        "[arm]",
        '[[joint]]\nname = "E1"\nrole = "carriage"\ntype = "prismatic"\n'
        "dh = { alpha_deg = 0, a_mm = 0, theta_deg = 0, d_mm = 0 }\n\n[arm]",
    ),
    UR.rows,
    UR.sign,
    UR.shift,
    UR.foot,
    UR.tip,
    UR.masses,
    np.r_[UR.home, 0.3],
    np.r_[UR.swing, 0.3],
    track=np.array([0.0, 0.0, 1.0]),
)


@dataclass(frozen=True)
class Brought:
    """logs: (name, CSV, TOML beside it). Either `refused`, words that the one line holds, or an answer: `truth`, the names that
    may be said above 0.8, of which one of each set of `must` is claimed; gross: rows that are to be reported as such.
    """

    machine: Machine
    logs: tuple[tuple[str, str, str], ...]
    refused: str = ""
    truth: frozenset[str] = frozenset()
    must: tuple[frozenset[str], ...] = ()
    gross: int = 0


Columns = dict[str, np.ndarray]


def lengths(machine: Machine, seed: int = 3) -> np.ndarray:
    """Tolerances of an ordinary arm: 0.02 degrees on each twist, 0.2 mm on lengths."""
    return np.random.default_rng(seed).normal(0, 1, (machine.arm, 3)) * (0.02 * DEG, 2e-4, 2e-4)


def poses(
    machine: Machine,
    count: int,
    *,
    faults: Faults | None = None,
    seed: int = 1,
    known: bool = False,
    turned: bool = False,
):
    """(columns, TOML) of single poses: zeros of two axes, gravity, lengths, and a rest of five times the noise."""
    axis = scattered(machine, count, seed)
    what = faults or Faults(zeros=ZEROS, lengths=lengths(machine), give=GIVE, rest=5e-5)
    T = true_poses(machine, axis, what, 5)
    if not known:
        T = INSTRUMENT @ T @ TARGET
    columns = columns_of(machine, np.arange(count) * 12.0, axis, T, sigma=SIGMA, seed=seed, turned=turned)
    return columns, ("" if known else ALL_UNKNOWN) + "poses = true\nsigma_mm = 0.01\nsigma_deg = 0.002\n"


def path(machine: Machine, *, faults: Faults | None = None, seconds: float = 30.0, seed: int = 2, turned: bool = True):
    """(columns, TOML) of a run, 20 rows a second: give of two axes, play of A1, lag, and a rest of five times the noise."""
    what = faults or Faults(give=GIVE, play={0: 0.03 * DEG}, lag=0.03, rest=5e-5)
    t, command = driven(machine, seconds, seed)
    reached = followed(command, what.lag)
    T = true_poses(machine, reached, what, 5)
    rows = np.arange(100, len(t) - 10, 12)
    columns = columns_of(
        machine, t[rows], reached[rows], T[rows], setpoint=command[rows], sigma=SIGMA, seed=seed, turned=turned
    )
    return columns, "sigma_mm = 0.01\nsigma_deg = 0.002\n"


def set_of(machine: Machine, count: int = 40, change: Callable[[Columns], Columns] | None = None, **answer) -> Brought:
    """One set of poses, changed."""
    keys = {k: answer.pop(k) for k in ("faults", "known", "turned", "seed") if k in answer}
    columns, toml = poses(machine, count, **keys)
    answer.setdefault("truth", frozenset(SMOOTH))
    return Brought(machine, (("set.csv", text(change(columns) if change else columns), toml),), **answer)


def run_of(machine: Machine, change: Callable[[Columns], Columns] | None = None, **answer) -> Brought:
    """One run, changed."""
    keys = {k: answer.pop(k) for k in ("faults", "seconds", "turned") if k in answer}
    columns, toml = path(machine, **keys)
    answer.setdefault("truth", frozenset(SMOOTH | {"backlash", "servo_lag", "latency", "setpoint_delay", "hysteresis"}))
    return Brought(machine, (("run.csv", text(change(columns) if change else columns), toml),), **answer)


def spelt(brought: Brought, change: Callable[[str], str], refused: str = "") -> Brought:
    """The same with the text of its first log changed."""
    (name, csv, toml), *more = brought.logs
    return replace(brought, logs=((name, change(csv), toml), *more), refused=refused)


def scaled(names, factor: float) -> Callable[[Columns], Columns]:
    return lambda c: c | {n: c[n] * factor for n in names if n in c}


def put(name: str, rows, value: float) -> Callable[[Columns], Columns]:
    def change(c: Columns) -> Columns:
        out = c[name].copy()
        out[rows] = value
        return c | {name: out}

    return change


def rolled(by: int) -> Callable[[Columns], Columns]:
    """Readings beside the poses next to their own; the end without one is left out."""
    keep = slice(0, -by) if by > 0 else slice(-by, None)
    return lambda c: {n: (np.roll(v, -by) if n in "xyzabc" else v)[keep] for n, v in c.items()}


def gross(share: float) -> Callable[[Columns], Columns]:
    def change(c: Columns) -> Columns:
        rng, n = np.random.default_rng(8), len(c["t"])
        rows = rng.choice(n, max(1, round(share * n)), replace=False)
        out = dict(c)
        for name in "xyz":
            out[name] = c[name].copy()
            out[name][rows] += rng.normal(0, 15.0, len(rows))
        return out

    return change


def without(*names: str) -> Callable[[Columns], Columns]:
    return lambda c: {n: v for n, v in c.items() if n not in names}


def swapped(first: str, second: str) -> Callable[[Columns], Columns]:
    return lambda c: c | {first: c[second], second: c[first]}


def slipped(machine: Machine) -> Brought:
    """The reflector is knocked by half a millimetre after half of the poses."""
    axis = scattered(machine, 40, 1)
    T = true_poses(machine, axis, Faults(zeros=ZEROS, lengths=lengths(machine), rest=5e-5), 5)
    knocked = TARGET.copy()
    knocked[:3, 3] += 4e-4, -3e-4, 2e-4
    T = INSTRUMENT @ np.concatenate([T[:20] @ TARGET, T[20:] @ knocked])
    columns = columns_of(machine, np.arange(40) * 12.0, axis, T, sigma=SIGMA, turned=False)
    return Brought(
        machine,
        (("set.csv", text(columns), ALL_UNKNOWN + "poses = true\nsigma_mm = 0.01\n"),),
        truth=frozenset(SMOOTH | {"measurement_drift"}),
        must=(frozenset({"measurement_drift"}),),
    )


def several(machine: Machine, stated: bool) -> Brought:
    """Three reflectors on each of 15 postures, a log a reflector."""
    axis = scattered(machine, 15, 1)
    T = true_poses(machine, axis, Faults(zeros=ZEROS, lengths=lengths(machine), rest=5e-5), 5)
    logs = []
    for k in range(3):
        target = rigid(0.1 * np.cos(2.1 * k), 0.1 * np.sin(2.1 * k), 0.02 * k, 0.0, (0, 0, 1))
        columns = columns_of(
            machine, np.arange(15) * 12.0, axis, INSTRUMENT @ T @ target, sigma=SIGMA, seed=k, turned=False
        )
        beside = 'same_poses_as = "t0.csv"\nsame_frame_as = "t0.csv"\n' if stated and k else ""
        logs.append((f"t{k}.csv", text(columns), ALL_UNKNOWN + beside + "poses = true\nsigma_mm = 0.01\n"))
    return Brought(machine, tuple(logs), truth=frozenset(SMOOTH))


def early(machine: Machine) -> Brought:
    """Each reading is taken with a thousandth of the way to the posture still to go, and the encoders say so only later."""
    axis = scattered(machine, 60, 1)
    rest = np.zeros_like(axis)
    rest[1:] = 1e-3 * (axis[:-1] - axis[1:])
    T = INSTRUMENT @ true_poses(machine, axis + rest, Faults(rest=5e-5), 5) @ TARGET
    columns = columns_of(machine, np.arange(60) * 12.0, axis, T, sigma=SIGMA, turned=False)
    toml = ALL_UNKNOWN + "poses = true\nsigma_mm = 0.01\n"
    return Brought(
        machine,
        (("set.csv", text(columns), toml),),
        truth=frozenset({"early_reading"}),
        must=(frozenset({"early_reading"}),),
    )


def instrument(machine: Machine, scale: float, drift: float) -> Brought:
    """A scale, and a walk of the instrument in one direction over the time of the set."""
    axis = scattered(machine, 80, 1)
    T = INSTRUMENT @ true_poses(machine, axis, Faults(rest=5e-5), 5) @ TARGET
    T[:, :3, 3] *= 1.0 + scale
    T[:, :3, 3] += np.linspace(0, drift, 80)[:, None] * (0.6, 0.0, 0.8)
    columns = columns_of(machine, np.arange(80) * 12.0, axis, T, sigma=SIGMA, turned=False)
    alike = (
        {"measurement_scale", "geometry", "robot_size"}
        if scale
        else {"measurement_drift", "thermal_drift", "frame_base"}
    )
    toml = ALL_UNKNOWN + "poses = true\nsigma_mm = 0.01\n"
    return Brought(machine, (("set.csv", text(columns), toml),), truth=frozenset(alike), must=(frozenset(alike),))


def drives(
    machine: Machine, *, seconds: float = 30.0, kind: str = "", lag: float = 0.05, motors: bool = False
) -> Brought:
    """No instrument: set-points and encoders, with torques or currents, or motor-side encoders, beside them."""
    t, command = driven(machine, seconds, 2)
    reached, rows, rng = followed(command, lag), np.arange(100, int(seconds / 0.004) - 10, 5), np.random.default_rng(4)
    reached = reached + rng.normal(0, 2e-6, reached.shape)
    columns = columns_of(machine, t[rows], reached[rows], None, setpoint=command[rows])
    if kind:
        speed = np.gradient(reached[:, : machine.arm], t, axis=0)
        torque = pulled(machine, reached[rows]) + 6.0 * np.tanh(speed[rows] / 0.02) + 4.0 * speed[rows]
        torque = torque * (1.0 if kind == "T" else 0.05) + rng.normal(0, 0.05, torque.shape)
        columns |= {f"{kind}{k + 1}": torque[:, k] for k in range(machine.arm)}
    truth = {"servo_lag", "setpoint_delay", "latency"}
    if motors:
        behind = loose(reached[:, 0], 0.05 * DEG)
        columns |= {f"M{k + 1}": columns[f"A{k + 1}"] for k in range(machine.arm)}
        columns["A1"] = behind[rows] / DEG
        truth |= {"backlash", "friction", "hysteresis"}
    names = (frozenset({"servo_lag", "setpoint_delay"}),)
    return Brought(
        machine, (("drives.csv", text(columns), "sigma_axis_deg = 0.0002\n"),), truth=frozenset(truth), must=names
    )


def _lines(change: Callable[[list[str]], list[str]]) -> Callable[[str], str]:
    return lambda csv: "\n".join(change(csv.splitlines())) + "\n"


def _cell(row: int, column: int, value: str) -> Callable[[str], str]:
    def change(lines: list[str]) -> list[str]:
        cells = lines[row].split(",")
        cells[column] = value
        return [*lines[:row], ",".join(cells), *lines[row + 1 :]]

    return _lines(change)


def brought() -> dict[str, Callable[[], Brought]]:
    """All that is brought, by name."""
    made: dict[str, Callable[[], Brought]] = {}
    for who, m in (("ur", UR), ("kr", KR)):
        one: dict[str, Callable[[], Brought]] = {
            "12 poses": lambda m=m: set_of(m, 12),
            "21 poses": lambda m=m: set_of(m, 21),
            "40 poses": lambda m=m: set_of(m, 40),
            "40 poses turned": lambda m=m: set_of(m, 40, turned=True),
            "40 poses world": lambda m=m: set_of(m, 40, known=True, turned=True),
            "perfect poses": lambda m=m: set_of(m, 40, faults=Faults(), truth=frozenset()),
            "only the rest": lambda m=m: set_of(m, 60, faults=Faults(rest=1.5e-4), truth=frozenset()),
            "targets told": lambda m=m: several(m, True),
            "targets untold": lambda m=m: several(m, False),
            "slip": lambda m=m: slipped(m),
            "row after": lambda m=m: set_of(m, 40, rolled(1), refused="one row before"),
            "row before": lambda m=m: set_of(m, 40, rolled(-1), refused="one row after"),
            "row after on a run": lambda m=m: run_of(m, rolled(1)),
            "y z exchanged": lambda m=m: set_of(
                m, 40, swapped("y", "z"), known=True, turned=True, refused="y and z are exchanged"
            ),
            "y z exchanged, frame unknown": lambda m=m: set_of(m, 40, swapped("y", "z"), refused="mirrored|exchanged"),
            "y z exchanged on a run": lambda m=m: run_of(m, swapped("y", "z"), refused="y and z are exchanged"),
            "A2 A3 exchanged": lambda m=m: set_of(m, 40, swapped("A2", "A3"), refused="A2 and A3 are exchanged"),
            "mirrored": lambda m=m: set_of(m, 40, scaled("y", -1.0), refused="mirrored"),
            "mirrored, known": lambda m=m: set_of(m, 40, scaled("z", -1.0), known=True, refused="its z is mirrored"),
            "metres": lambda m=m: set_of(m, 40, scaled(PLACE, 1e-3), refused="metres"),
            "metres on a run": lambda m=m: run_of(m, scaled(PLACE, 1e-3), refused="metres"),
            "inches": lambda m=m: set_of(m, 40, scaled(PLACE, 1 / 25.4), refused="inch"),
            "inches, known": lambda m=m: set_of(m, 40, scaled(PLACE, 1 / 25.4), known=True, refused="inch"),
            "radians": lambda m=m: set_of(m, 40, scaled([*TURNING, "E2"], DEG), refused="radians"),
            "radians on a run": lambda m=m: run_of(
                m, scaled([*TURNING, *(f"c{a}" for a in TURNING)], DEG), refused="radians"
            ),
            "one axis in radians": lambda m=m: set_of(m, 40, scaled(["A4"], DEG), refused="A4"),
            "one axis negated": lambda m=m: set_of(m, 40, scaled(["A4"], -1.0), refused="A4"),
            "1 % gross": lambda m=m: set_of(m, 100, gross(0.01), gross=1),
            "10 % gross": lambda m=m: set_of(m, 100, gross(0.10), gross=10),
            "10 % gross, 30 poses": lambda m=m: set_of(m, 30, gross(0.10), gross=3),
            "10 % gross on a run": lambda m=m: run_of(m, gross(0.10)),
            "constant rows": lambda m=m: set_of(
                m, 40, lambda c: {n: np.r_[v[:20], np.full(20, v[20])] if n != "t" else v for n, v in c.items()}
            ),
            "all rows the same": lambda m=m: set_of(
                m,
                40,
                lambda c: {n: np.full(40, v[0]) if n != "t" else v for n, v in c.items()},
                refused="no axis moves",
            ),
            "reading stuck": lambda m=m: set_of(
                m, 40, lambda c: c | {n: np.full(40, c[n][0]) for n in PLACE}, refused="stay the same to the last digit"
            ),
            "reading stuck half way": lambda m=m: run_of(
                m,
                lambda c: c | {n: np.r_[c[n][:300], np.full(len(c[n]) - 300, c[n][300])] for n in "xyzabc"},
                refused="stay the same to the last digit",
            ),
            "NaN": lambda m=m: spelt(set_of(m, 40), _cell(7, 1, "NaN"), r"set\.csv:8: x is 'NaN'"),
            "empty positions": lambda m=m: set_of(
                m, 40, lambda c: put("x", [3, 9], np.nan)(put("y", [3, 9], np.nan)(put("z", [3, 9], np.nan)(c)))
            ),
            "one empty cell": lambda m=m: set_of(m, 40, put("y", 5, np.nan)),
            "empty encoder": lambda m=m: set_of(m, 40, put("A3", [3, 11], np.nan)),
            "empty column": lambda m=m: set_of(m, 40, put("A3", slice(None), np.nan), refused="A3"),
            "semicolons, commas": lambda m=m: spelt(set_of(m, 40), lambda s: s.replace(",", ";").replace(".", ","), ""),
            "semicolons": lambda m=m: spelt(set_of(m, 40), lambda s: s.replace(",", ";"), ""),
            "decimal commas between commas": lambda m=m: spelt(set_of(m, 40), lambda s: s.replace(".", ","), "cells"),
            "milliseconds": lambda m=m: run_of(m, scaled("t", 1e3), refused="millisecond"),
            "microseconds": lambda m=m: run_of(m, scaled("t", 1e6), refused="second"),
            "duplicated time": lambda m=m: run_of(
                m, lambda c: c | {"t": np.r_[c["t"][:50], c["t"][49:-1]]}, refused="t is .* after"
            ),
            "all times the same": lambda m=m: set_of(m, 40, put("t", slice(None), 0.0), refused="t is 0 after 0"),
            "wrapped A6": lambda m=m: run_of(
                m, lambda c: c | {n: (c[n] - c["cA6"][0] + 180) % 360 - 180 + c["cA6"][0] + 360 for n in ("A6", "cA6")}
            ),
            "wrapped encoder alone": lambda m=m: run_of(
                m, lambda c: c | {"A1": c["A1"] - 360.0 * (c["A1"] < np.median(c["A1"]))}
            ),
            "no cA3": lambda m=m: run_of(m, without("cA3"), refused="no column cA3"),
            "no A3": lambda m=m: run_of(m, without("A3"), refused="no column A3"),
            "no set-points": lambda m=m: run_of(m, lambda c: {n: v for n, v in c.items() if n[0] != "c" or n == "c"}),
            "no encoders": lambda m=m: run_of(m, lambda c: {n: v for n, v in c.items() if n[0] not in "AE"}),
            "a run": lambda m=m: run_of(m),
            "a run of positions": lambda m=m: run_of(m, turned=False),
            "a perfect run": lambda m=m: run_of(m, faults=Faults(), truth=frozenset()),
            "a header in capitals": lambda m=m: spelt(
                set_of(m, 40), lambda s: s.replace("t,x,y,z", "Time,X,Y,Z", 1), ""
            ),
            "units in the header": lambda m=m: spelt(
                set_of(m, 40), lambda s: s.replace("t,x,y,z", "t [s],x [mm],y [mm],z [mm]", 1), ""
            ),
            "drives": lambda m=m: drives(m),
            "drives T": lambda m=m: drives(m, kind="T"),
            "drives I": lambda m=m: drives(m, kind="I"),
            "drives M": lambda m=m: drives(m, motors=True),
            "drives short": lambda m=m: drives(m, seconds=3.0),
            "early": lambda m=m: early(m),
            "scale": lambda m=m: instrument(m, 3e-4, 0.0),
            "drift": lambda m=m: instrument(m, 0.0, 5e-4),
        }
        made |= {f"{who}: {name}": make for name, make in one.items()}
    return made | {
        "bench: one axis": lambda: drives(ONE),
        "bench: one axis, tracked": lambda: run_of(
            ONE, faults=Faults(zeros={0: 1e-3}, play={0: 0.05 * DEG}, lag=0.03, rest=5e-5)
        ),
        "seven: poses": lambda: set_of(SEVEN, 60),
        "seven: run": lambda: run_of(SEVEN),
        "seven: drives": lambda: drives(SEVEN),
        "seven: lacks A7": lambda: run_of(SEVEN, without("A7", "cA7"), refused="A7"),
        "lift: poses": lambda: set_of(COLUMN, 40),
        "lift: run": lambda: run_of(COLUMN),
        "lift: drives": lambda: drives(COLUMN),
        "lift: in metres": lambda: run_of(COLUMN, scaled(["E1", "cE1"], 1e-3), refused="E1"),
    }
