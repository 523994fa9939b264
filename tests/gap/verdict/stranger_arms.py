"""Arms and their runs as a stranger's log shows them, from physics alone: nothing of camrob, and nothing of the gap benchmark.

An arm is a list of Denavit-Hartenberg rows, multiplied out; zeros, lengths, gravity's pull at each joint, play, a servo that
follows late and an instrument are put in where they are on a real one. A rest that no name fits is always there.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

G = 9.81
DEG = np.pi / 180.0
TICK = 0.004  # s: the controller's


@dataclass(frozen=True)
class Machine:
    """rows: alpha (rad), a, d (m), standard convention; row angle = sign * axis value + shift. kinds: R turns, P slides along z.
    foot: world to the first row; tip: the tool's point behind the last row; masses: (row whose end carries it, kg, place there);
    track: the direction in world in which E1, in front of all, carries the arm, None without one; table: a further axis E2
    that the tool does not feel. home, swing: axis values in the middle of its work and how far they go either way.
    """

    cell: str
    rows: tuple[tuple[float, float, float], ...]
    sign: tuple[float, ...]
    shift: tuple[float, ...]
    foot: np.ndarray
    tip: np.ndarray
    masses: tuple[tuple[int, float, tuple[float, float, float]], ...]
    home: np.ndarray
    swing: np.ndarray
    kinds: str = ""
    track: np.ndarray | None = None
    table: bool = False

    @property
    def arm(self) -> int:
        return len(self.rows)

    @property
    def names(self) -> list[str]:
        """Axes, in a log's order."""
        more = (["E1"] if self.track is not None else []) + (["E2"] if self.table else [])
        return [f"A{k + 1}" for k in range(self.arm)] + more

    @property
    def unit(self) -> np.ndarray:
        """From SI to what a controller tells: degrees and mm."""
        turns = [1 / DEG if (self.kinds or "R" * self.arm)[k] == "R" else 1e3 for k in range(self.arm)]
        return np.array(turns + ([1e3] if self.track is not None else []) + ([1 / DEG] if self.table else []))


@dataclass
class Faults:
    """What is wrong. zeros (rad) and give (rad/Nm), play (rad, the whole) by axis of the arm; lengths: (rows, 3) on alpha, a, d;
    lag: s; scale: of the instrument; rest: m, rms of a smooth displacement over posture that nothing explains.
    """

    zeros: dict[int, float] = field(default_factory=dict)
    lengths: np.ndarray | None = None
    give: dict[int, float] = field(default_factory=dict)
    play: dict[int, float] = field(default_factory=dict)
    lag: float = 0.0
    scale: float = 0.0
    rest: float = 0.0


def placed(
    machine: Machine, axis: np.ndarray, lengths: np.ndarray | None = None, upto: int | None = None
) -> np.ndarray:
    """Poses (N, 4, 4) in world of the tip, or of a row's end, at axis values (N, k) in SI."""
    n = len(axis)
    T = np.tile(machine.foot, (n, 1, 1))
    for k, row in enumerate(machine.rows if upto is None else machine.rows[: upto + 1]):
        alpha, a, d = np.asarray(row) + (0.0 if lengths is None else lengths[k])
        value = machine.sign[k] * axis[:, k]
        slides = (machine.kinds or "R" * machine.arm)[k] == "P"
        angle = np.full(n, machine.shift[k]) if slides else value + machine.shift[k]
        c, s, ca, sa = np.cos(angle), np.sin(angle), np.cos(alpha), np.sin(alpha)
        A = np.zeros((n, 4, 4))
        A[:, 0] = np.stack([c, -s * ca, s * sa, a * c], 1)
        A[:, 1] = np.stack([s, c * ca, -c * sa, a * s], 1)
        A[:, 2, 1], A[:, 2, 2], A[:, 2, 3], A[:, 3, 3] = sa, ca, d + (value if slides else 0.0), 1.0
        T = T @ A
    if upto is None:
        T = T @ machine.tip
    if machine.track is not None:
        T[:, :3, 3] += axis[:, machine.arm, None] * machine.track
    return T


def pulled(machine: Machine, axis: np.ndarray) -> np.ndarray:
    """(N, k) Nm that gravity turns each axis with: minus the slope of the potential energy."""

    def energy(values):
        held = [m * G * (placed(machine, values, upto=k) @ np.array([*p, 1.0]))[:, 2] for k, m, p in machine.masses]
        return np.sum(held, axis=0) if held else np.zeros(len(values))

    out = np.zeros((len(axis), machine.arm))
    for k in range(machine.arm):
        more, less = axis.copy(), axis.copy()
        more[:, k] += 1e-4
        less[:, k] -= 1e-4
        out[:, k] = -(energy(more) - energy(less)) / 2e-4
    return out


def loose(driven: np.ndarray, width: float) -> np.ndarray:
    """Where the driven side stands in a mesh with play: pushed by whichever flank touches."""
    link, half, at = np.empty_like(driven), width / 2, driven[0] - width / 2
    for i, value in enumerate(driven):
        at = min(max(at, value - half), value + half)
        link[i] = at
    return link


def true_poses(machine: Machine, reached: np.ndarray, faults: Faults, seed: int) -> np.ndarray:
    """(N, 4, 4) where the tip really is, with the encoders at `reached`."""
    link = reached.copy()
    for k, width in faults.play.items():
        link[:, k] = loose(reached[:, k], width)
    if faults.give:
        torque = pulled(machine, reached)
        for k, c in faults.give.items():
            link[:, k] += c * torque[:, k]
    for k, zero in faults.zeros.items():
        link[:, k] += zero
    T = placed(machine, link, faults.lengths)
    if faults.rest:
        rng = np.random.default_rng(seed)
        arm, moved = reached[:, : machine.arm], np.zeros((len(reached), 3))
        for _ in range(8):
            i, j = rng.integers(0, machine.arm, 2)
            turned = np.sin(rng.uniform(1, 2.5) * arm[:, i] + rng.uniform(0, 6)) * np.cos(
                rng.uniform(0.5, 2) * arm[:, j]
            )
            moved += turned[:, None] * rng.normal(size=3)
        moved -= moved.mean(axis=0)
        T[:, :3, 3] += moved * faults.rest / np.sqrt(np.mean(np.sum(moved**2, axis=1)))
    return T


def scattered(machine: Machine, count: int, seed: int) -> np.ndarray:
    """(count, k) postures at rest over the work."""
    return machine.home + np.random.default_rng(seed).uniform(-1, 1, (count, len(machine.home))) * machine.swing


def driven(machine: Machine, seconds: float, seed: int, *, axes: range | None = None) -> tuple[np.ndarray, np.ndarray]:
    """(t, commanded axis values) every tick: each axis goes to and fro in its own time, some of them alone where asked."""
    rng, t = np.random.default_rng(seed), np.arange(0.0, seconds, TICK)
    command = np.tile(machine.home, (len(t), 1))
    for k in range(len(machine.home)) if axes is None else axes:
        w, p = rng.uniform(0.25, 0.9, 2), rng.uniform(0, 6, 2)
        command[:, k] += machine.swing[k] * (0.35 * np.sin(w[0] * t + p[0]) + 0.2 * np.sin(2.3 * w[1] * t + p[1]))
    return t, command


def followed(command: np.ndarray, lag: float) -> np.ndarray:
    """What a first-order servo makes of its set-points, settled at the start's speed."""
    if lag <= 0.0:
        return command.copy()
    out, share = np.empty_like(command), 1.0 - np.exp(-TICK / lag)
    out[0] = command[0] - lag * (command[1] - command[0]) / TICK
    for i in range(1, len(command)):
        out[i] = out[i - 1] + share * (command[i] - out[i - 1])
    return out


def angles(R: np.ndarray) -> np.ndarray:
    """(N, 3) degrees a, b, c with R = Rz(a) Ry(b) Rx(c)."""
    a, b = np.arctan2(R[:, 1, 0], R[:, 0, 0]), -np.arcsin(np.clip(R[:, 2, 0], -1, 1))
    return np.stack([a, b, np.arctan2(R[:, 2, 1], R[:, 2, 2])], 1) / DEG


def columns_of(
    machine: Machine,
    t: np.ndarray,
    encoder: np.ndarray,
    T: np.ndarray | None,
    *,
    setpoint: np.ndarray | None = None,
    sigma: float = 1e-5,
    seed: int = 0,
    turned: bool = True,
) -> dict[str, np.ndarray]:
    """A log's columns in its units. T: what was measured, None where nobody did; sigma: m an axis."""
    rng, columns = np.random.default_rng([seed, 7]), {"t": t}
    if T is not None:
        p = 1e3 * (T[:, :3, 3] + rng.normal(0, sigma, (len(t), 3)))
        columns |= {n: p[:, k] for k, n in enumerate("xyz")}
        if turned:
            abc = angles(T[:, :3, :3]) + rng.normal(0, 2e-3, (len(t), 3))
            columns |= {n: abc[:, k] for k, n in enumerate("abc")}
    columns |= {n: encoder[:, k] * machine.unit[k] for k, n in enumerate(machine.names)}
    if setpoint is not None:
        columns |= {f"c{n}": setpoint[:, k] * machine.unit[k] for k, n in enumerate(machine.names)}
    return columns


def text(columns: dict[str, np.ndarray]) -> str:
    """A CSV of columns; NaN is an empty cell."""
    rows = np.stack(list(columns.values()), 1)
    lines = [",".join("" if np.isnan(v) else f"{v:.6f}" for v in row) for row in rows]
    return "\n".join([",".join(columns), *lines]) + "\n"


def rigid(x, y, z, turned, about) -> np.ndarray:
    """A frame: m, and an angle about an axis."""
    n = np.asarray(about, float) / np.linalg.norm(about)
    K = np.array([[0, -n[2], n[1]], [n[2], 0, -n[0]], [-n[1], n[0], 0]])
    T = np.eye(4)
    T[:3, :3] = np.eye(3) + np.sin(turned) * K + (1 - np.cos(turned)) * K @ K
    T[:3, 3] = x, y, z
    return T


UR_ROWS = [(90, 0, 162.5), (0, -425, 0), (0, -392.2, 0), (90, 0, 133.3), (-90, 0, 99.7), (0, 0, 99.6)]
UR_CELL = """schema = 1
name = "bare_ur5"
standing = "datasheet"

[arm]
convention = "standard"
dh = [
  [90, 0, 0, 162.5],
  [0, -425, 0, 0],
  [0, -392.2, 0, 0],
  [90, 0, 0, 133.3],
  [-90, 0, 0, 99.7],
  [0, 0, 0, 99.6],
]
"""
UR = Machine(
    UR_CELL,
    tuple((al * DEG, a / 1e3, d / 1e3) for al, a, d in UR_ROWS),
    (1.0,) * 6,
    (0.0,) * 6,
    np.eye(4),
    np.eye(4),
    ((1, 9.0, (0.2, 0, 0.1)), (2, 3.0, (0.2, 0, 0.05)), (5, 4.0, (0, 0, 0.05))),
    np.array([0.3, -1.6, 1.2, -1.0, -1.5, 0.2]),
    np.array([1.3, 0.5, 0.7, 1.0, 0.7, 1.5]),
)
ONE = Machine(
    'schema = 1\nname = "bench"\nstanding = "datasheet"\n\n[arm]\ndh = [[0, 500, 0, 0]]\n',
    ((0.0, 0.5, 0.0),),
    (1.0,),
    (0.0,),
    np.eye(4),
    np.eye(4),
    (),
    np.array([0.2]),
    np.array([1.2]),
)
SEVEN = Machine(
    """schema = 1
name = "seven"
standing = "datasheet"

[arm]
dh = [[-90, 0, 0, 340], [90, 0, 0, 0], [90, 0, 0, 400], [-90, 0, 0, 0], [-90, 0, 0, 400], [90, 0, 0, 0], [0, 0, 0, 126]]
""",
    tuple(
        (al * DEG, 0.0, d / 1e3) for al, d in ((-90, 340), (90, 0), (90, 400), (-90, 0), (-90, 400), (90, 0), (0, 126))
    ),
    (1.0,) * 7,
    (0.0,) * 7,
    np.eye(4),
    np.eye(4),
    (),
    np.array([0.1, 0.5, 0.2, -1.3, 0.3, 0.9, 0.1]),
    np.full(7, 0.7),
)
_FOOT = np.diag([-1.0, 1.0, -1.0, 1.0])
_FOOT[:3, 3] = -0.803, 0.0, -0.305
_TIP = np.eye(4)
_TIP[2, 3] = -0.1197
KR_ROWS = [(np.pi / 2, 0.3, -0.675), (0, 0.65, 0), (np.pi / 2, 0.155, 0), (np.pi / 2, 0, -0.6), (np.pi / 2, 0, 0)]
KR = Machine(
    "",
    (*KR_ROWS, (0.3564, 0.0, -0.4434)),
    (1, 1, 1, 1, -1, 1),
    tuple(np.array([180, 0, -90, 0, 180, 0]) * DEG),
    _FOOT,
    _TIP,
    (
        (1, 42.0, (-0.39, 0, 0)),
        (2, 48.0, (-0.06, 0.04, 0.02)),
        (3, 22.0, (0, 0.18, 0)),
        (5, 4.0, (0, 0.127, 0.341)),
        (5, 12.0, (0, 0, 0.13)),
    ),
    np.array([0, -90, 90, 0, 90, 0, 0, 0]) * DEG,
    np.array([0.5, 0.35, 0.45, 1.0, 0.7, 1.5, 0.5, 2.0]),
    track=np.array([0.0, 1.0, 0.0]),
    table=True,
)
