"""Further kinds of what strangers bring: other arms, servos, instruments, rows and files, and causes that the library lacks.

Made by hand like `stranger_logs`, with nothing of camrob. What an effect of a case does is written down here from physics.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from stranger_arms import DEG, KR, TICK, UR, Faults, Machine, columns_of, driven, followed, scattered, text, true_poses
from stranger_logs import (
    ALL_UNKNOWN,
    COLUMN,
    INSTRUMENT,
    SIGMA,
    SMOOTH,
    TARGET,
    Brought,
    drives,
    run_of,
    set_of,
    spelt,
    without,
)

SCARA = Machine(
    """schema = 1
name = "scara"
standing = "datasheet"

[arm]
kinds = "RRPR"
dh = [[0, 350, 0, 400], [180, 300, 0, 0], [0, 0, 0, 0], [0, 0, 0, 50]]
""",
    ((0.0, 0.35, 0.4), (np.pi, 0.3, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.05)), (1.0,) * 4, (0.0,) * 4, np.eye(4), np.eye(4), (),
    np.array([0.2, 0.9, 0.1, 0.0]), np.array([1.3, 1.0, 0.08, 2.0]), kinds="RRPR",
)  # fmt: skip
GANTRY = Machine(
    """schema = 1
name = "gantry"
standing = "datasheet"

[arm]
kinds = "PPPRR"
dh = [[-90, 0, 0, 0], [-90, 0, -90, 0], [0, 0, 0, 0], [90, 0, 0, 0], [0, 0, 0, 150]]
""",
    ((-np.pi / 2, 0.0, 0.0), (-np.pi / 2, 0.0, 0.0), (0.0, 0.0, 0.0), (np.pi / 2, 0.0, 0.0), (0.0, 0.0, 0.15)),
    (1.0,) * 5, (0.0, -np.pi / 2, 0.0, 0.0, 0.0), np.eye(4), np.eye(4), (),
    np.array([0.3, 0.4, 0.2, 0.1, 0.5]), np.array([0.25, 0.35, 0.2, 1.5, 1.0]), kinds="PPPRR",
)  # fmt: skip

LAGS = frozenset({"servo_lag", "latency", "setpoint_delay"})
REST = Faults(rest=5e-5)


def second_order(command: np.ndarray, natural: float, damping: float) -> np.ndarray:
    """A drive with inertia behind its set-points, at rest with the arm's first speed: x'' = w2 (u - x) - 2 z w x'."""
    out, h = np.empty_like(command), TICK / 10
    speed = (command[1] - command[0]) / TICK
    x = command[0] - 2 * damping / natural * speed
    for i, u in enumerate(command):
        out[i] = x
        slope = (command[min(i + 1, len(command) - 1)] - u) / TICK
        for k in range(10):
            speed = speed + h * (natural**2 * (u + slope * k * h - x) - 2 * damping * natural * speed)
            x = x + h * speed
    return out


def short_of_voltage(command: np.ndarray, k: int, share: float) -> np.ndarray:
    """Drives at their set-points, but for one that falls behind with the square of its speed."""
    out, speed = command.copy(), np.gradient(command[:, k], TICK)
    out[:, k] -= share * speed * np.abs(speed)
    return out


def run(
    machine: Machine, *, reach: Callable | None = None, bend: Callable | None = None, told: Callable | None = None,
    faults: Faults = REST, encoders: bool = True, truth=frozenset(), must=(), every: int = 12, seconds: float = 30.0,
    seed: int = 2, turned: bool = True, setpoints: bool = True,
) -> Brought:  # fmt: skip
    """A run. reach(command): where the drives are; bend(t, reached, T): the true poses; told(t, p): what the instrument says."""
    t, command = driven(machine, seconds, seed)
    reached = command.copy() if reach is None else reach(command)
    T = true_poses(machine, reached, faults, 5)
    T = T if bend is None else bend(t, reached, T)
    if told is not None:
        T = T.copy()
        T[:, :3, 3] = told(t, T[:, :3, 3])
    rows = np.arange(100, len(t) - 10, every)
    columns = columns_of(
        machine, t[rows], reached[rows], T[rows], setpoint=command[rows], sigma=SIGMA, seed=seed, turned=turned
    )
    if not encoders:
        columns = without(*machine.names)(columns)
    if not setpoints:
        columns = without(*(f"c{n}" for n in machine.names))(columns)
    return Brought(
        machine,
        (("run.csv", text(columns), "sigma_mm = 0.01\nsigma_deg = 0.002\n"),),
        truth=frozenset(truth),
        must=must,
    )


def still(
    machine: Machine, count: int, *, bend: Callable | None = None, axes: Callable | None = None, faults: Faults = REST,
    truth=frozenset(), must=(), seed: int = 1, turned: bool = False, sigma: float = SIGMA, spell: str = "{:.6f}",
) -> Brought:  # fmt: skip
    """Single poses. axes(axis): where the links are; bend(t, axis, T): the true poses."""
    axis, t = scattered(machine, count, seed), np.arange(count) * 12.0
    T = true_poses(machine, axis if axes is None else axes(axis), faults, 5)
    T = INSTRUMENT @ (T if bend is None else bend(t, axis, T)) @ TARGET
    columns = columns_of(machine, t, axis, T, sigma=sigma, turned=turned)
    csv = text(columns) if spell == "{:.6f}" else rounded(columns, spell)
    toml = ALL_UNKNOWN + "poses = true\nsigma_mm = 0.01\nsigma_deg = 0.002\n"
    return Brought(machine, (("set.csv", csv, toml),), truth=frozenset(truth), must=must)


def rounded(columns: dict[str, np.ndarray], spell: str) -> str:
    """A CSV of few decimals, but for the time."""
    rows = np.stack(list(columns.values()), 1)
    lines = [",".join([f"{row[0]:.3f}", *(spell.format(v) for v in row[1:])]) for row in rows]
    return "\n".join([",".join(columns), *lines]) + "\n"


def placed_by(shift: Callable) -> Callable:
    """Poses with the tip moved by shift(t, axis, T), (N, 3) m in world."""

    def bend(t, axis, T):
        out = T.copy()
        out[:, :3, 3] += shift(t, axis, T)
        return out

    return bend


def turned_by(machine: Machine, k: int, angle: Callable) -> Callable:
    """Poses with axis k beyond its encoder by angle(t, axis), (N,) rad or m, beside a small rest."""

    def bend(t, axis, T):
        link = axis.copy()
        link[:, k] += angle(t, axis)
        return true_poses(machine, link, REST, 5)

    return bend


def kinds() -> dict[str, Callable[[], Brought]]:
    """All further kinds, by name."""
    up = np.array([0.0, 0.0, 1.0])
    made: dict[str, Callable[[], Brought]] = {}
    for who, m in (("ur", UR), ("kr", KR)):
        one: dict[str, Callable[[], Brought]] = {
            "servo of second order": lambda m=m: run(
                m, reach=lambda u: second_order(u, 40.0, 0.7), truth=LAGS | {"acceleration_error"}
            ),
            "servo of second order, no encoders": lambda m=m: run(
                m, reach=lambda u: second_order(u, 40.0, 0.7), encoders=False, truth=LAGS, must=(LAGS,)
            ),
            "stiff servo, no encoders": lambda m=m: run(
                m, reach=lambda u: second_order(u, 30.0, 0.3), encoders=False, truth=LAGS | {"acceleration_error"}
            ),
            "lag of 60 ms, no encoders": lambda m=m: run(
                m, reach=lambda u: followed(u, 0.06), encoders=False, truth=LAGS, must=(LAGS,)
            ),
            "instrument that smooths": lambda m=m: run(
                m, told=lambda t, p: followed(p, 0.02), truth=LAGS, must=(frozenset({"latency"}),), turned=False
            ),
            "clock 40 ms off": lambda m=m: run(
                m, told=lambda t, p: np.stack([np.interp(t - 0.04, t, x) for x in p.T], 1), truth=LAGS,
                must=(frozenset({"latency"}),), turned=False,
            ),
            "ripple of A1": lambda m=m: run(
                m, bend=turned_by(m, 0, lambda t, q: 0.02 * DEG * np.sin(60 * q[:, 0])),
                truth={"gear_ripple"}, must=(frozenset({"gear_ripple"}),),
            ),
            "no rows for 3 s": lambda m=m: cut(run_of(m), 200, 262),
            "one decimal": lambda m=m: still(m, 60, spell="{:.1f}"),
            "two decimals": lambda m=m: still(m, 60, faults=Faults(zeros={1: 0.12 * DEG}, rest=5e-5), spell="{:.2f}",
                truth=SMOOTH),
            "link of 5 mm more": lambda m=m: still(
                m, 60, faults=Faults(lengths=np.eye(m.arm, 3, -1) * 5e-3, rest=5e-5), truth=SMOOTH | {"robot_size"},
                must=(frozenset({"geometry"}),),
            ),
            "A4 mastered 2 degrees off": lambda m=m: still(
                m, 60, faults=Faults(zeros={3: 2 * DEG}, rest=5e-5), truth=SMOOTH,
                must=(frozenset({"joint_offset", "geometry"}),),
            ),
            "ratio of A3 wrong": lambda m=m: still(m, 60, axes=lambda q: q * (1.0 + 1e-3 * (np.arange(q.shape[1]) == 2)),
                truth=frozenset()),
            "A3 slips in the midst": lambda m=m: still(
                m, 60, bend=turned_by(m, 2, lambda t, q: 0.08 * DEG * (t > t[len(t) // 2]))
            ),
            "A3 slips on a run": lambda m=m: run(m, bend=turned_by(m, 2, lambda t, q: 0.05 * DEG * (t > 14.0))),
            "the beam bends": lambda m=m: still(
                m, 60, bend=placed_by(lambda t, q, T: 2e-4 * up * np.linalg.norm(T[:, :3, 3], axis=1)[:, None] ** 2)
            ),
            "tool loose in its cone": lambda m=m: still(
                m, 60, bend=placed_by(lambda t, q, T: 2e-4 * np.tanh(T[:, 2, 0] / 0.1)[:, None] * T[:, :3, 0])
            ),
            "a spring pulls at A2": lambda m=m: still(
                m, 60, bend=turned_by(m, 1, lambda t, q: 6e-4 * np.maximum(q[:, 1] - m.home[1], 0.0) ** 2 / 0.2)
            ),
            "warms up": lambda m=m: still(
                m, 80, bend=placed_by(lambda t, q, T: 3e-4 * (1 - np.exp(-t / 300.0))[:, None] * T[:, :3, 3]),
                truth={"thermal_drift", "measurement_drift", "measurement_scale", "robot_size", "frame_base"},
            ),
            "A3 slips late on a run": lambda m=m: run(m, bend=turned_by(m, 2, lambda t, q: 0.04 * DEG * (t > 17.0))),
            "A1's drive is short of voltage": lambda m=m: run(m, reach=lambda u: short_of_voltage(u, 0, 4e-3)),
            "the hall sways": lambda m=m: run(
                m, bend=placed_by(lambda t, q, T: 2e-4 * np.sin(2 * np.pi * t / 1.7)[:, None] * (0.6, 0.8, 0.0))
            ),
            "readings jump by 2 mm": lambda m=m: run(
                m, told=lambda t, p: p + 2e-3 * ((t > 9) & (t < 11))[:, None] * (0.0, 1.0, 0.0), turned=False
            ),
        }  # fmt: skip
        made |= {f"{who}: {name}": make for name, make in one.items()}
    foot = 2e-3 / 0.65
    return made | {
        "kr: rack of E1": lambda: run(
            KR, bend=placed_by(lambda t, q, T: 1.5e-4 * np.sin(2 * np.pi * q[:, 6] / 0.05)[:, None] * (0, 1.0, 0))
        ),
        "kr: rail sags": lambda: run(
            KR, bend=placed_by(lambda t, q, T: 3e-4 * (np.cos(np.pi * q[:, 6] / 0.4) - 1)[:, None] * up),
            truth={"track", "lean"},
        ),
        "lift: column leans with height": lambda: run(
            COLUMN, bend=placed_by(lambda t, q, T: foot * (q[:, 6] ** 2)[:, None] * (1.0, 0, 0)), truth={"track", "lean"},
        ),
        "lift: servo of second order, no encoders": lambda: run(
            COLUMN, reach=lambda u: second_order(u, 40.0, 0.7), encoders=False, truth=LAGS, must=(LAGS,)
        ),
        "lift: drives I": lambda: drives(COLUMN, kind="I"),
        "scara: poses": lambda: still(SCARA, 60, faults=Faults(zeros={1: 0.1 * DEG}, rest=2e-5), truth=SMOOTH, turned=True),
        "scara: run": lambda: run(SCARA, reach=lambda u: followed(u, 0.03), truth=LAGS, must=(LAGS,)),
        "scara: no encoders": lambda: run(SCARA, reach=lambda u: followed(u, 0.03), encoders=False, truth=LAGS, must=(LAGS,)),
        "scara: drives": lambda: drives(SCARA),
        "gantry: poses": lambda: still(GANTRY, 60, faults=Faults(zeros={3: 0.1 * DEG}, rest=2e-5), truth=SMOOTH, turned=True),
        "gantry: run": lambda: run(GANTRY, reach=lambda u: followed(u, 0.03), truth=LAGS, must=(LAGS,)),
        "gantry: play": lambda: run(
            GANTRY, faults=Faults(play={0: 1e-4}, rest=1e-5), truth={"backlash", "hysteresis", "friction"},
            must=(frozenset({"backlash", "hysteresis"}),),
        ),
        "gantry: drives": lambda: drives(GANTRY),
    }  # fmt: skip


def cut(brought: Brought, first: int, last: int) -> Brought:
    """A log without some of its rows."""
    return spelt(brought, lambda csv: "\n".join((lines := csv.splitlines())[:first] + lines[last:]) + "\n")


def files() -> dict[str, Callable[[], Brought]]:
    """Files as other people's programs write them: read rightly, or refused in one line."""

    def head(change):
        return lambda s: "\n".join([change(s.split("\n", 1)[0]), s.split("\n", 1)[1]])

    plain = lambda: set_of(UR, 40)  # noqa: E731
    return {
        "file: BOM": lambda: spelt(plain(), lambda s: "\ufeff" + s),
        "file: CRLF": lambda: spelt(plain(), lambda s: s.replace("\n", "\r\n")),
        "file: blank lines": lambda: spelt(plain(), lambda s: s.replace("\n", "\n\n"), "set.csv:2: there is an empty line"),
        "file: comment first": lambda: spelt(plain(), lambda s: "# exported by TrackPro 3\n" + s),
        "file: two header rows": lambda: spelt(
            plain(), head(lambda h: h + "\n" + ",".join(["mm"] * len(h.split(",")))), "set.csv:2"
        ),
        "file: tabs": lambda: spelt(plain(), lambda s: s.replace(",", "\t")),
        "file: quoted": lambda: spelt(plain(), head(lambda h: ",".join(f'"{n}"' for n in h.split(",")))),
        "file: spaces": lambda: spelt(plain(), lambda s: s.replace(",", ", ")),
        "file: trailing comma": lambda: spelt(plain(), lambda s: s.replace("\n", ",\n"), "set.csv"),
        "file: column twice": lambda: spelt(plain(), head(lambda h: h.replace("A2", "A1")), "A1"),
        "file: more columns": lambda: spelt(
            plain(),
            lambda s: "\n".join(x + (",operator" if k == 0 else ",Ann" if x else "") for k, x in enumerate(s.split("\n"))),
            "set.csv:1: .*operator.*leave it out",
        ),
        "file: joint names": lambda: spelt(plain(), head(lambda h: h.replace("A", "J"))),
        "file: lower case": lambda: spelt(plain(), head(lambda h: h.replace("A", "a"))),
        "file: clock times": lambda: spelt(
            plain(), lambda s: "\n".join(
                [s.split("\n")[0], *(f"12:00:{k:02d}.5,{x.split(',', 1)[1]}" for k, x in enumerate(s.split("\n")[1:]) if x)]
            ) + "\n",
        ),
        "file: header alone": lambda: spelt(plain(), lambda s: s.split("\n", 1)[0] + "\n", "set.csv"),
        "file: empty": lambda: spelt(plain(), lambda s: "", "set.csv"),
        "file: no header": lambda: spelt(plain(), lambda s: s.split("\n", 1)[1], "set.csv"),
        "file: five rows": lambda: spelt(plain(), lambda s: "\n".join(s.split("\n")[:6]) + "\n", "set.csv"),
        "file: a word": lambda: spelt(plain(), lambda s: s.replace("\n24.0", "\nlost beam", 1), "set.csv:4"),
        "file: infinite": lambda: spelt(
            plain(), lambda s: "\n".join(
                x if k != 5 else ",".join(["inf" if c == 2 else v for c, v in enumerate(x.split(","))])
                for k, x in enumerate(s.split("\n"))
            ), "set.csv:6",
        ),
        "file: a huge number": lambda: spelt(
            plain(), lambda s: "\n".join(
                x if k != 5 else ",".join(["1e30" if c == 2 else v for c, v in enumerate(x.split(","))])
                for k, x in enumerate(s.split("\n"))
            ), "set.csv",
        ),
        "file: short row": lambda: spelt(
            plain(), lambda s: "\n".join(x if k != 7 else x.rsplit(",", 1)[0] for k, x in enumerate(s.split("\n"))), "set.csv:8"
        ),
        "file: rows backwards": lambda: spelt(
            run_of(UR), lambda s: "\n".join([s.split("\n")[0], *reversed(s.strip().split("\n")[1:])]) + "\n", "run.csv"
        ),
        "file: thousands": lambda: spelt(plain(), lambda s: s.replace("132.000", "1.32.000"), "set.csv:"),
    }  # fmt: skip
