"""Five machines by Denavit-Hartenberg rows, SI inside: forward kinematics, loads of gravity, their cell.toml."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

G = np.array([0.0, 0.0, -9.81])


def rigid(x, y, z, a, b, c):
    """From mm and degrees, R = Rz(A) Ry(B) Rx(C)."""
    out = np.eye(4)
    out[:3, :3] = Rotation.from_euler("ZYX", [a, b, c], degrees=True).as_matrix()
    out[:3, 3] = np.array([x, y, z]) / 1e3
    return out


def small(twist):
    """Of (..., 6), a shift in m and a rotation vector."""
    flat = np.asarray(twist, float).reshape(-1, 6)
    out = np.tile(np.eye(4), (len(flat), 1, 1))
    out[:, :3, :3] = Rotation.from_rotvec(flat[:, 3:]).as_matrix()
    out[:, :3, 3] = flat[:, :3]
    return out.reshape((*np.shape(twist)[:-1], 4, 4))


@dataclass(frozen=True)
class Machine:
    """`rows`: alpha, a, theta, d in degrees and mm; axis value = sign * q + offset; `home`, `swing` of q in degrees or mm."""

    name: str
    title: str
    names: tuple
    rows: tuple
    kinds: str
    signs: tuple
    offsets: tuple
    home: tuple
    swing: tuple
    base: tuple
    tool: tuple
    masses: tuple  # (after which axis, kg, centre in mm), the load last
    soft: tuple  # rad/Nm or m/N of each axis
    ratios: tuple  # turns of the motor for one of the axis, or for 100 mm
    told: bool = True  # masses stand in cell.toml

    @property
    def n(self):
        return len(self.rows)

    @property
    def units(self):
        """SI of what an axis' value counts."""
        return np.array([np.pi / 180 if k == "R" else 1e-3 for k in self.kinds])

    @property
    def middle(self):
        return np.array(self.home) * self.units

    @property
    def reach(self):
        """By how much a turn of one axis at most moves the tool, at home, m/rad."""
        return float(
            np.linalg.norm(self.jacobian(self.middle)[0, :3] * (np.array(list(self.kinds)) == "R"), axis=0).max()
        )

    def axes(self, q):
        """As a controller prints them."""
        return q / self.units * np.array(self.signs) + np.array(self.offsets)

    def chain(self, q, twist=None):
        """Frames base, after each row, at the tool, of (N, n); `twist` (N, n + 2, 6): on the left, after each row, at the tip."""
        q = np.atleast_2d(q)
        mid = None if twist is None else small(twist)
        here = np.tile(rigid(*self.base), (len(q), 1, 1))
        here = here if mid is None else mid[:, 0] @ here
        out = [here]
        for k, (alpha, a, theta, d) in enumerate(self.rows):
            turn = np.radians(theta) + (q[:, k] if self.kinds[k] == "R" else 0.0 * q[:, k])
            along = d / 1e3 + (q[:, k] if self.kinds[k] == "P" else 0.0)
            ca, sa, ct, st = np.cos(np.radians(alpha)), np.sin(np.radians(alpha)), np.cos(turn), np.sin(turn)
            step = np.zeros((len(q), 4, 4))
            step[:, 0, 0], step[:, 0, 1], step[:, 0, 2], step[:, 0, 3] = ct, -st * ca, st * sa, a / 1e3 * ct
            step[:, 1, 0], step[:, 1, 1], step[:, 1, 2], step[:, 1, 3] = st, ct * ca, -ct * sa, a / 1e3 * st
            step[:, 2, 1], step[:, 2, 2], step[:, 2, 3], step[:, 3, 3] = sa, ca, along, 1.0
            here = here @ step
            here = here if mid is None else here @ mid[:, k + 1]
            out.append(here)
        tip = here @ rigid(*self.tool)
        out.append(tip if mid is None else tip @ mid[:, -1])
        return out

    def tip(self, q, twist=None):
        return self.chain(q, twist)[-1]

    def pull(self, frames, after, point):
        """(N, 3, n): how a point, world, behind axis `after` moves with each axis."""
        out = np.zeros((len(point), 3, self.n))
        for k in range(after):
            z = frames[k][:, :3, 2]
            out[:, :, k] = np.cross(z, point - frames[k][:, :3, 3]) if self.kinds[k] == "R" else z
        return out

    def jacobian(self, q):
        """(N, 6, n) at the tip: shift, rotation."""
        frames = self.chain(q)
        turn = [f[:, :3, 2] * (k == "R") for f, k in zip(frames, self.kinds, strict=False)]
        return np.concatenate([self.pull(frames, self.n, frames[-1][:, :3, 3]), np.stack(turn, 2)], 1)

    def centres(self, frames, masses=None):
        for after, kg, centre in masses or self.masses:
            yield after, kg, (frames[after] @ np.append(np.array(centre) / 1e3, 1.0))[:, :3]

    def load(self, q, masses=None):
        """Force of gravity along each axis, (N, n)."""
        frames = self.chain(q)
        return sum(
            kg * np.einsum("i,nik->nk", G, self.pull(frames, after, p)) for after, kg, p in self.centres(frames, masses)
        )

    def inertia(self, q):
        """What each axis moves, as point masses, (N, n)."""
        frames = self.chain(q)
        return sum(kg * (self.pull(frames, after, p) ** 2).sum(1) for after, kg, p in self.centres(frames))

    def moment(self, q):
        """Of gravity about the foot, (N, 3)."""
        frames = self.chain(q)
        foot = frames[1 if self.kinds[0] == "P" else 0][:, :3, 3]
        return sum(np.cross(p - foot, kg * G) for _, kg, p in self.centres(frames))

    def cell(self):
        """The text of cell.toml."""
        out = [f'schema = 1\nname = "{self.name}"\ntitle = "{self.title}"\n\n[kinematics]\nbase_follows_table = false']
        out.append(f"characteristic_length_mm = 400\nbase_to_first = {list(self.base)}")
        out.append('foot_to_root = [0, 0, 0, 0, 0, 0]\nwrist_to_flange = [0, 0, 0, 0, 0, 0]\nstanding = "assumed"\n')
        home, swing = self.axes(self.middle), np.array(self.swing)
        for k, name in enumerate(self.names):
            alpha, a, theta, d = self.rows[k]
            u, kind = ("deg", "revolute") if self.kinds[k] == "R" else ("mm", "prismatic")
            wide = [float(home[k] - 3 * swing[k]), float(home[k] + 3 * swing[k])]
            speed = 180 if u == "deg" else 1500
            out.append(
                f'[[joint]]\nname = "{name}"\nrole = "{"arm" if name[0] == "A" else "carriage"}"\ntype = "{kind}"'
            )
            out.append(f"dh = {{ alpha_deg = {alpha}, a_mm = {a}, theta_deg = {theta}, d_mm = {d} }}")
            out.append(f"axis = {{ sign = {self.signs[k]}, offset_{u} = {self.offsets[k]} }}")
            out.append(f"home_{u} = {self.home[k]}\nreference_{u} = {self.home[k]}")  # of q, ranges of the axis
            out.append(
                f"limits = {{ range_{u} = {wide}, speed_{u}_s = {speed}, acceleration_{u}_s2 = {4 * speed}, "
                f'jerk_{u}_s3 = {40 * speed} }}\nstanding = "datasheet"\n'
            )
        out.append(f'[tool]\nflange_to_tool = {list(self.tool)}\nstanding = "assumed"\n')
        out.append(f'[load]\npayload_kg = {self.masses[-1][1]}\nstanding = "datasheet"\n')
        for i, (after, kg, centre) in enumerate(self.masses if self.told else ()):
            out.append(f'[[mass]]\nname = "body {i + 1}"\nafter = "{self.names[after - 1]}"\nmass_kg = {kg}')
            out.append(f'center_mm = {list(centre)}\nstanding = "datasheet"\n')
        return "\n".join(out)


ARM = ("A1", "A2", "A3", "A4", "A5", "A6")
DOWN = (0, 0, 180, 0, 180, 0)


def wall_arm():
    """Its first axis is level, so that gravity turns that, too."""
    rows = ((-90, 210, 0, 520), (0, 910, -90, 0), (-90, 145, 0, 0), (90, 0, 0, 980), (-90, 0, 0, 0), (0, 0, 0, 165))
    masses = (
        (1, 210.0, (-110, 60, 0)),
        (2, 95.0, (-480, 0, 90)),
        (3, 88.0, (-30, 0, 110)),
        (4, 28.0, (0, -260, 0)),
        (5, 9.0, (0, 0, 20)),
        (6, 24.0, (35, 10, 95)),
    )
    return Machine("wall_arm", "Arm on a wall, 25 kg", ARM, rows, "RRRRRR", (1, -1, 1, 1, -1, 1), (0, 0, 90, 0, 0, 0),
        (12, 35, 20, 15, 50, 0), (32, 26, 28, 50, 34, 70), (0, 0, 1900, 0, 90, 0), DOWN, masses,
        (9e-7, 8e-7, 1.1e-6, 7e-6, 9e-6, 2e-5), (141, 157, 143, 81, 80, 51))  # fmt: skip


def polar_arm():
    """A spherical arm: turn, tilt, reach out; then three that turn."""
    rows = ((-90, 0, 0, 880), (90, 0, 0, 240), (0, 0, 0, 1250), (-90, 0, 0, 0), (90, 0, 0, 0), (0, 0, 0, 190))
    masses = (
        (1, 160.0, (0, 120, 30)),
        (2, 110.0, (0, -20, 60)),
        (3, 70.0, (0, 0, -480)),
        (4, 14.0, (0, 10, 0)),
        (5, 8.0, (0, 0, 30)),
        (6, 12.0, (20, 0, 80)),
    )
    return Machine("polar_arm", "Spherical arm with a sliding boom", ARM, rows, "RRPRRR",
        (-1, 1, 1, 1, 1, -1), (0, -90, 1250, 0, 0, 0),
        (0, 78, 0, 20, -60, 0), (45, 20, 260, 50, 30, 80), (0, 0, 0, 0, 0, 0), DOWN, masses,
        (1.5e-6, 9e-7, 2e-8, 1.2e-5, 1.2e-5, 2.5e-5), (120, 160, 40, 60, 60, 50))  # fmt: skip


def shoulder_arm():
    """Shoulder and elbow stand beside the column. Masses aren't told."""
    rows = ((-90, 0, 0, 672), (0, 432, 0, 243), (90, -20, 0, -93), (-90, 0, 0, 433), (90, 0, 0, 0), (0, 0, 0, 75))
    masses = (
        (1, 13.0, (0, 80, 10)),
        (2, 17.4, (-364, 6, 20)),
        (3, 4.8, (0, -14, 70)),
        (4, 0.9, (0, 90, 0)),
        (5, 0.4, (0, 0, 10)),
        (6, 2.4, (0, 15, 60)),
    )
    return Machine("shoulder_arm", "Small arm, shoulder beside its column", ARM, rows, "RRRRRR",
        (1, 1, -1, 1, 1, 1), (0, 0, 0, 0, 0, 0),
        (10, -60, 180, 0, 60, 0), (50, 24, 26, 60, 36, 90), (0, 0, 0, 0, 0, 0), DOWN, masses,
        (1.2e-5, 1e-5, 1.8e-5, 7e-5, 8e-5, 1.1e-4), (63, 107, 54, 76, 72, 77), told=False)  # fmt: skip


def climbing_arm():
    """An arm on a rail that climbs by 20 degrees."""
    rows = (
        (-70, 0, 90, 0),
        (-90, 350, 0, 780),
        (0, 1150, -90, 0),
        (-90, 60, 0, 0),
        (90, 0, 0, 1220),
        (-90, 0, 0, 0),
        (0, 0, 0, 220),
    )
    masses = (
        (1, 420.0, (0, 0, -80)),
        (2, 330.0, (-150, 90, 0)),
        (3, 190.0, (-600, 0, 120)),
        (4, 170.0, (-40, 0, 130)),
        (5, 48.0, (0, -350, 0)),
        (6, 18.0, (0, 0, 30)),
        (7, 60.0, (60, -20, 140)),
    )
    return Machine("climbing_arm", "Arm of 60 kg on a rail that climbs", ("E1", *ARM), rows, "PRRRRRR", (1, 1, 1, -1, 1, 1, 1),
        (0, 0, -90, 0, 0, 0, 0), (700, -20, 22, 38, 0, 40, 0), (260, 38, 22, 24, 50, 34, 60), (0, 0, 300, 0, 70, 0),
        (40, 0, 230, 0, 180, 0), masses,
        (6e-9, 4e-7, 3.5e-7, 5e-7, 3e-6, 4e-6, 8e-6), (12, 171, 171, 160, 125, 120, 90))  # fmt: skip


def five_arm():
    """Three level axes one behind the other and a roll: five axes."""
    rows = ((-90, 120, 0, 430), (0, 560, -90, 0), (0, 480, 90, 0), (-90, 60, -90, 0), (0, 0, 0, 170))
    masses = (
        (1, 45.0, (-60, 30, 0)),
        (2, 26.0, (-290, 0, 50)),
        (3, 19.0, (-230, 0, 30)),
        (4, 7.0, (0, 10, 40)),
        (5, 6.0, (15, 0, 70)),
    )
    return Machine("five_arm", "Five axes, three of them level", ARM[:5], rows, "RRRRR", (1, 1, 1, -1, 1), (0, 0, 0, 90, 0),
        (0, 30, 15, 30, 0), (50, 28, 32, 36, 80), (100, 50, 0, 30, 0, 0), DOWN, masses,
        (4e-6, 3.5e-6, 5e-6, 1.8e-5, 5e-5), (101, 121, 101, 89, 50))  # fmt: skip


MACHINES = (wall_arm, polar_arm, shoulder_arm, climbing_arm, five_arm)
