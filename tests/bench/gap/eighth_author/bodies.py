"""Six machines as Denavit-Hartenberg rows, their loads of gravity, and their cell.toml. SI and rad inside."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

G = 9.81


def placed(turn, at):
    """(..., 4, 4) of a rotation (..., 3, 3) and a place (..., 3)."""
    out = np.zeros((*np.shape(at)[:-1], 4, 4))
    out[..., :3, :3], out[..., :3, 3], out[..., 3, 3] = turn, at, 1.0
    return out


def frame(six):
    """4x4 of [X, Y, Z, A, B, C] in mm and degrees."""
    return placed(Rotation.from_euler("ZYX", six[3:], degrees=True).as_matrix(), np.array(six[:3]) / 1e3)


def small(twist):
    """(N, 4, 4) of (N, 6): a step in m, then a turn in rad."""
    twist = np.atleast_2d(twist)
    return placed(Rotation.from_rotvec(twist[:, 3:]).as_matrix(), twist[:, :3])


def inverse(pose):
    back = np.swapaxes(pose[..., :3, :3], -1, -2)
    return placed(back, -(back @ pose[..., :3, 3, None])[..., 0])


def step(alpha, a, theta, d):
    """(N, 4, 4) of one row: Rz(theta) Tz(d) Tx(a) Rx(alpha)."""
    theta, d = np.broadcast_arrays(theta, d)
    ct, st, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    out = np.zeros((len(theta), 4, 4))
    out[:, 0] = np.stack([ct, -st * ca, st * sa, a * ct], 1)
    out[:, 1] = np.stack([st, ct * ca, -ct * sa, a * st], 1)
    out[:, 2, 1], out[:, 2, 2], out[:, 2, 3], out[:, 3, 3] = sa, ca, d, 1.0
    return out


@dataclass(frozen=True)
class Axis:
    """A row in degrees and mm; value = sign * q + offset; `spread` either side of `middle` is where it works."""

    name: str
    kind: str
    alpha: float
    a: float
    theta: float
    d: float
    middle: float
    spread: float
    sign: int = 1
    offset: float = 0.0
    soft: float = 2e-7  # rad/Nm, or m/N
    ratio: int = 100  # turns of the motor a turn of the axis (a sliding one: 1/10 a mm)
    top: float = 1.0  # rad/s, or m/s


@dataclass(frozen=True)
class Machine:
    key: str
    title: str
    foot: tuple
    axes: tuple
    tool: tuple
    masses: tuple  # (name of the axis behind which it sits, kg, its centre in mm there)
    payload: float
    room: float  # half the side of the work, m
    feed: float  # m/s
    grain: float  # the noise of an instrument's axis on this machine, mm

    @property
    def n(self):
        return len(self.axes)

    @cached_property
    def table(self):
        return self.axes[0].name == "E2"

    @cached_property
    def first(self):
        """The first row behind a table's."""
        return int(self.table)

    @cached_property
    def names(self):
        return [a.name for a in self.axes]

    @cached_property
    def slides(self):
        return np.array([a.kind == "P" for a in self.axes])

    @cached_property
    def unit(self):
        """Chain's units in those of the axis values: rad a degree, m a mm."""
        return np.where(self.slides, 1e-3, np.pi / 180)

    def each(self, what):
        return np.array([getattr(a, what) for a in self.axes], float)

    @cached_property
    def middle(self):
        return self.each("middle") * self.unit

    @cached_property
    def spread(self):
        return self.each("spread") * self.unit

    def values(self, q):
        """Axis values as printed, degrees and mm."""
        return self.each("sign") * q / self.unit + self.each("offset")

    def _row(self, i, q):
        a = self.axes[i]
        turn, along = np.radians(a.theta), a.d / 1e3
        if a.kind == "P":
            return step(np.radians(a.alpha), a.a / 1e3, turn, along + q)
        return step(np.radians(a.alpha), a.a / 1e3, turn + q, along)

    def _zero(self):
        a = self.axes[0]
        return np.array([-a.offset / a.sign * self.unit[0]])

    def frames(self, q, twists=None):
        """In world: of the foot (behind a table's row: where it stands at 0), then behind each row, (n + 1) of (N, 4,
        4). `twists[k]` acts behind row k."""
        twists = twists or {}
        now = np.repeat(frame(self.foot)[None], len(q), 0)
        out = [now]
        for i in range(self.n):
            if i == 0 and not self.table and 0 in twists:
                now = small(twists[0]) @ now  # of the foot, in world
            fixed = self.table and i == 0
            now = now @ self._row(i, np.repeat(self._zero(), len(q)) if fixed else q[:, i])
            if fixed and 0 in twists:
                now = small(twists[0]) @ now
            if i + 1 in twists:
                now = now @ small(twists[i + 1])
            out.append(now)
        return out

    def tip(self, q, twists=None):
        """(N, 4, 4) of the tool in world; `twists[n + 1]` acts at the tip, in tool axes."""
        end = self.frames(q, twists)[-1] @ frame(self.tool)
        return end @ small(twists[self.n + 1]) if twists and self.n + 1 in twists else end

    def base(self, q):
        """(N, 4, 4) of the base that turns with a table, in world."""
        foot = frame(self.foot)
        if not self.table:
            return np.repeat(np.eye(4)[None], len(q), 0)
        return foot @ self._row(0, self._zero()) @ inverse(foot @ self._row(0, q[:, 0]))

    def jacobian(self, q, at=None):
        """(N, 6, n) of a place `at` (N, 3) carried by the last row; the tip where it is left out. A table moves nothing."""
        chain = self.frames(q)
        at = (chain[-1] @ frame(self.tool))[:, :3, 3] if at is None else at
        return _columns(self, chain, at, self.n)

    def loads(self, q, more=()):
        """(N, n) of what gravity exerts about each axis: Nm, or N."""
        chain = self.frames(q)
        out = np.zeros(q.shape)
        for name, kg, centre in (*self.masses, *more):
            k = self.names.index(name) + 1
            at = (chain[k] @ np.append(np.array(centre) / 1e3, 1.0))[:, :3]
            out -= kg * G * _columns(self, chain, at, k)[:, 2]
        return out

    def moment(self, q, about):
        """(N, 3) of gravity on the floor about a place, Nm in world, and the weight, N."""
        chain = self.frames(q)
        out, weight = np.zeros((len(q), 3)), 0.0
        for name, kg, centre in self.masses:
            at = (chain[self.names.index(name) + 1] @ np.append(np.array(centre) / 1e3, 1.0))[:, :3]
            out += np.cross(at - about, [0, 0, -kg * G])
            weight += kg * G
        return out, weight

    def cell(self):
        """cell.toml."""

        def joint(a, role):
            zero = "offset_mm" if a.kind == "P" else "offset_deg"
            kind = "prismatic" if a.kind == "P" else "revolute"
            return (
                f'\n[[joint]]\nname = "{a.name}"\nrole = "{role}"\ntype = "{kind}"\n'
                f"dh = {{ alpha_deg = {a.alpha}, a_mm = {a.a}, theta_deg = {a.theta}, d_mm = {a.d} }}\n"
                f"axis = {{ sign = {a.sign}, {zero} = {a.offset} }}\n"
            )

        outer = [a for a in self.axes if a.name.startswith("E")]
        arm = [a for a in self.axes if a.name.startswith("A")]
        rows = "\n".join(f"  [{a.alpha}, {a.a}, {a.theta}, {a.d}]," for a in arm)
        text = (
            f'schema = 1\nname = "{self.key}"\ntitle = "{self.title}"\nstanding = "assumed"\n\n[kinematics]\n'
            f"base_follows_table = {str(self.table).lower()}\nbase_to_first = {list(self.foot)}\n"
        )
        text += "".join(joint(a, "workpiece" if a.name == "E2" else "carriage") for a in outer)
        text += f'\n[arm]\nconvention = "standard"\ndh = [\n{rows}\n]\nkinds = "{"".join(a.kind for a in arm)}"\n'
        text += f"signs = {[a.sign for a in arm]}\noffsets_deg = {[a.offset for a in arm]}\n"
        text += f"\n[tool]\nflange_to_tool = {list(self.tool)}\n\n[load]\npayload_kg = {self.payload}\n"
        for i, (name, kg, centre) in enumerate(self.masses):
            text += f'\n[[mass]]\nname = "m{i}"\nafter = "{name}"\nmass_kg = {kg}\ncenter_mm = {list(centre)}\n'
        return text


def _columns(machine, chain, at, count):
    """(N, 6, n) of a place that the first `count` rows carry."""
    out = np.zeros((len(at), 6, machine.n))
    for i in range(machine.first, count):
        z, o = chain[i][:, :3, 2], chain[i][:, :3, 3]
        if machine.slides[i]:
            out[:, :3, i] = z
        else:
            out[:, :3, i], out[:, 3:, i] = np.cross(z, at - o), z
    return out


def portal():
    """Three sliding axes, one across the other, with a ram; three axes of a head whose second lies off the first."""
    return Machine(
        "portal", "A portal with a head of three axes", (-900, -700, 1500, 0, -90, 180),
        (
            Axis("A1", "P", 90, 0, 0, 900, 0, 350, soft=2e-8, ratio=60, top=0.6),
            Axis("A2", "P", -90, 0, 90, 700, 0, 300, soft=2e-8, ratio=60, top=0.6),
            Axis("A3", "P", 0, 0, 0, 500, 150, 200, sign=-1, offset=400, soft=4e-8, ratio=80, top=0.4),
            Axis("A4", "R", -90, 0, 0, 140, 20, 60, ratio=120, top=1.2),
            Axis("A5", "R", 90, 85, 0, 0, 50, 24, sign=-1, soft=6e-7, ratio=120, top=1.2),
            Axis("A6", "R", 0, 0, 0, 190, 0, 70, soft=9e-7, ratio=80, top=1.6),
        ),
        (45, 10, 160, 0, 180, 0),
        (("A1", 320, (250, 0, 0)), ("A2", 110, (0, 60, 40)), ("A3", 60, (0, 0, -250)),
         ("A5", 28, (20, 0, 30)), ("A6", 14, (15, 0, 40))),
        14, 0.17, 0.14, 0.016,
    )  # fmt: skip


def boom():
    """A welding arm that hangs under the boom of a column; the boom climbs on the column."""
    return Machine(
        "boom", "A welding arm under a boom that climbs a column", (0, 0, 1500, 0, 0, 0),
        (
            Axis("E1", "P", 180, 1100, 0, 0, 300, 220, soft=5e-8, ratio=50, top=0.35),
            Axis("A1", "R", -90, 150, 0, 430, 10, 35, sign=-1, soft=1e-6, ratio=121, top=1.4),
            Axis("A2", "R", 0, 614, -90, 0, 15, 25, soft=1e-6, ratio=121, top=1.4),
            Axis("A3", "R", -90, 155, 0, 0, 10, 25, sign=-1, offset=-90, soft=1.4e-6, ratio=101, top=1.6),
            Axis("A4", "R", 90, 0, 0, 640, 15, 50, soft=1.4e-6, ratio=80, top=2.4),
            Axis("A5", "R", -90, 0, 0, 0, -100, 30, sign=-1, soft=1.6e-6, ratio=80, top=2.4),
            Axis("A6", "R", 0, 0, 0, 100, 0, 80, soft=3e-6, ratio=50, top=3.0),
        ),
        (60, 0, 310, 0, 150, 0),
        (("E1", 240, (-500, 0, 40)), ("A2", 26, (-330, 0, 90)),
         ("A3", 21, (-40, 10, 60)), ("A4", 9, (0, -140, 0)), ("A6", 6, (25, 0, 120))),
        6, 0.2, 0.09, 0.022,
    )  # fmt: skip


def ceiling():
    """Seven axes under a ceiling, shoulder, elbow and wrist in line with one another."""
    soft = (1.5e-6, 1.5e-6, 2e-6, 2e-6, 4e-6, 6e-6, 6e-6)
    turn = ((-90, 340), (90, 0), (90, 420), (-90, 0), (-90, 400), (90, 0), (0, 152))
    spans = ((0, 30), (40, 20), (10, 30), (70, 20), (15, 35), (40, 25), (0, 70))
    axes = tuple(
        Axis(f"A{i + 1}", "R", al, 0, 0, d, mid, wide, sign=(1, 1, -1, -1, 1, 1, -1)[i],
             soft=soft[i], ratio=160 if i < 4 else 100, top=1.4)
        for i, ((al, d), (mid, wide)) in enumerate(zip(turn, spans, strict=True))
    )  # fmt: skip
    return Machine(
        "ceiling", "Seven axes under a ceiling", (300, -200, 2300, 30, 0, 180), axes, (35, -20, 120, 0, 180, 0),
        (("A1", 5, (0, 30, 20)), ("A2", 5, (0, 50, 40)), ("A3", 4, (0, 25, -60)),
         ("A4", 4, (0, 60, 30)), ("A5", 3, (0, 20, -80)), ("A6", 2, (0, 0, 20)), ("A7", 9, (20, 0, 60))),
        9, 0.11, 0.08, 0.012,
    )  # fmt: skip


def winder():
    """A fibre-placement arm of the largest class before a mandrel that turns about a level axis."""
    return Machine(
        "winder", "A fibre-placement arm before a level mandrel", (0, 0, 0, 180, 0, 90),
        (
            Axis("E2", "R", -90, 2500, 0, 260, 0, 140, ratio=200, top=0.5),
            Axis("A1", "R", -90, 500, 180, 45, 0, 14, sign=-1, soft=5e-8, ratio=250, top=0.7),
            Axis("A2", "R", 0, 1300, -90, 0, 30, 14, soft=6e-8, ratio=250, top=0.6),
            Axis("A3", "R", -90, 55, 0, 0, -10, 14, offset=90, soft=8e-8, ratio=240, top=0.7),
            Axis("A4", "R", 90, 0, 0, 1275, 20, 40, sign=-1, soft=3e-7, ratio=200, top=1.1),
            Axis("A5", "R", -90, 0, 0, 0, 65, 22, soft=3e-7, ratio=200, top=1.0),
            Axis("A6", "R", 0, 0, 0, 290, 0, 60, sign=-1, soft=6e-7, ratio=160, top=1.4),
        ),
        (110, 0, 560, 0, 180, 0),
        (("A1", 700, (-260, 60, 0)), ("A2", 340, (-700, 0, 120)),
         ("A3", 290, (-30, 0, -80)), ("A4", 95, (0, -420, 0)), ("A5", 45, (0, 0, 50)), ("A6", 205, (70, 0, 260))),
        205, 0.26, 0.2, 0.035,
    )  # fmt: skip


def turret():
    """A column that turns, a lift on it, a boom that slides out level, a wrist of three axes."""
    return Machine(
        "turret", "A turning column with lift, level boom and wrist", (0, 0, 0, 0, 0, 0),
        (
            Axis("A1", "R", 0, 120, 0, 420, -15, 30, sign=-1, soft=2e-7, ratio=140, top=0.9),
            Axis("A2", "P", 90, 0, 90, 300, 250, 220, soft=5e-8, ratio=60, top=0.35),
            Axis("A3", "P", 0, 0, 0, 550, 250, 180, offset=-100, soft=4e-8, ratio=60, top=0.4),
            Axis("A4", "R", -90, 0, 0, 210, 100, 35, soft=8e-7, ratio=100, top=1.5),
            Axis("A5", "R", 90, 0, 0, 0, 65, 30, sign=-1, offset=90, soft=1e-6, ratio=100, top=1.5),
            Axis("A6", "R", 0, 0, 0, 130, 0, 70, soft=2e-6, ratio=80, top=2.0),
        ),
        (50, 15, 140, 0, 180, 0),
        (("A1", 180, (-40, 0, 60)), ("A2", 70, (0, 40, 60)), ("A3", 35, (0, 0, -260)),
         ("A5", 16, (0, 0, 20)), ("A6", 10, (10, 0, 50))),
        10, 0.18, 0.1, 0.02,
    )  # fmt: skip


def dispenser():
    """A SCARA whose quill carries a head that tilts: five axes."""
    return Machine(
        "dispenser", "A SCARA with a head that tilts", (0, 0, 0, 0, 0, 0),
        (
            Axis("A1", "R", 0, 450, 0, 520, 30, 35, soft=6e-7, ratio=80, top=1.8),
            Axis("A2", "R", 180, 400, 0, 60, -75, 35, sign=-1, soft=9e-7, ratio=80, top=2.2),
            Axis("A3", "P", 0, 0, 0, 0, 120, 90, soft=2e-7, ratio=40, top=0.3),
            Axis("A4", "R", 90, 0, 0, 90, 10, 60, soft=2e-6, ratio=50, top=2.6),
            Axis("A5", "R", 0, 0, 90, 60, -38, 20, offset=-90, soft=3e-6, ratio=50, top=2.2),
        ),
        (130, 20, 0, 0, -90, 0),
        (("A1", 18, (-200, 0, 20)), ("A2", 14, (-180, 0, 0)), ("A3", 4, (0, 0, -60)), ("A5", 2.5, (40, 0, 0))),
        2.5, 0.12, 0.1, 0.011,
    )  # fmt: skip


MACHINES = (portal, boom, ceiling, winder, turret, dispenser)
