"""Six-axis arms from their Denavit-Hartenberg rows: forward, inverse, KUKA's Status and Turn.

Everything here is written for the witness alone. A row is A = Rz(theta) Tz(d) Tx(a) Rx(alpha); `foot` is the frame in which
the arm's first row begins, `wrist` that in which its last row ends. Angles theta in rad, axis values in degrees:
axis = sign * (theta - theta_offset) + axis_offset.

Closed form for arms with a spherical wrist (a4 = a5 = d5 = 0), a1's axis at right angles to two parallel axes. The wrist's
centre W = (0, 0, d4) in frame 3. Seen in frame 1 its height c along the parallel axes is constant, so that with r its distance
from axis 1: (a1 + x)^2 + c^2 = r^2, two shoulders; |(x, y)|^2 = a2^2 + L^2 + 2 a2 L cos(beta), two elbows, beta = 0 the
stretched arm; and Rz(theta4) Rx(alpha4) Rz(theta5) Rx(alpha5) Rz(theta6) is what remains, two wrists.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from camrob.witness.frames import inverse, joined, rotation, rotation_vector
from camrob.witness.units import deg_to_rad, rad_to_deg

__all__ = ["BRANCHES", "Arm", "Branch", "Pose", "chain", "wrapped"]

Array = NDArray[np.float64]
Pose = tuple[Array, Array]  # rotations (M, 3, 3) and places (M, 3) in metres; M may be 1 where nothing changes
Branch = tuple[int, int, int]  # shoulder, elbow, wrist: 1 or -1 each
Branches = tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]  # likewise, pose by pose
BRANCHES: tuple[Branch, ...] = tuple(product((1, -1), repeat=3))  # type: ignore[arg-type]

_SQUARE = 1e-9  # a cosine below it is a right angle; cells give alpha in degrees
_SEEDS = np.random.default_rng(6).uniform(-np.pi, np.pi, (96, 6))  # postures to start Newton's method from


def wrapped(degrees: Array) -> Array:
    """Angles in degrees brought to -180 <= value < 180."""
    return (degrees + 180.0) % 360.0 - 180.0


def chain(theta: list[Array], d: list[Array], a: Array, alpha: Array, places: bool = True) -> Pose:
    """The product of rows: theta and d row by row, (M,) or (1,) each; a and alpha (rows,). Without `places` turns alone."""
    turn, place = np.eye(3)[None], np.zeros((1, 3))
    for k in range(len(a)):
        about = rotation(2, theta[k])
        if places:
            along = np.stack(np.broadcast_arrays(a[k] * about[:, 0, 0], a[k] * about[:, 1, 0], d[k]), axis=-1)
            place = place + (turn @ along[..., None])[..., 0]
        turn = turn @ (about @ rotation(0, alpha[k : k + 1]))
    return turn, place


@dataclass(frozen=True, slots=True, eq=False)
class Arm:
    """Rows (6,) each: a, d in m, alpha and theta_offset in rad; sign (6,) and axis_offset (6,) degrees of the axis values."""

    a: Array
    alpha: Array
    d: Array
    theta_offset: Array
    sign: Array
    axis_offset: Array
    foot_R_root: Array

    def theta(self, axes: Array) -> Array:
        """Angles (M, 6) rad of the rows for axis values (M, 6) degrees."""
        return deg_to_rad(self.sign * (axes - self.axis_offset)) + self.theta_offset

    def axes(self, theta: Array) -> Array:
        """Axis values (M, 6) degrees for angles (M, 6) rad, none of them wrapped."""
        return self.sign * rad_to_deg(theta - self.theta_offset) + self.axis_offset

    def forward(self, theta: Array, rows: int = 6, places: bool = True) -> Pose:
        """foot_T_wrist, or the pose in which an earlier row ends; without `places` its turn alone."""
        columns = [theta[:, k] for k in range(rows)]
        return chain(columns, [self.d[k : k + 1] for k in range(rows)], self.a[:rows], self.alpha[:rows], places)

    @property
    def spherical(self) -> bool:
        """True where the closed form holds."""
        small = np.abs([self.a[3], self.a[4], self.d[4]]).max() < 1e-9
        square = np.abs(np.cos(self.alpha[[0, 3, 4]])).max() < _SQUARE
        return bool(small and square and abs(np.sin(self.alpha[1])) < _SQUARE and abs(self.a[1] * self.reach) > 1e-9)

    @property
    def elbow_turn(self) -> float:
        """+1 where the third row turns as the second does, -1 where it turns against it."""
        return float(np.sign(np.cos(self.alpha[1])))

    @property
    def reach(self) -> float:
        """L, from axis 3 to the wrist's centre, across the axis."""
        return float(np.hypot(self.a[2], np.sin(self.alpha[2]) * self.d[3]))

    @property
    def lean(self) -> float:
        """beta - theta3: the angle of L in frame 3 before its turn by alpha3."""
        return float(np.arctan2(-np.sin(self.alpha[2]) * self.d[3], self.a[2]))

    @property
    def height(self) -> float:
        """c, the wrist's centre along the second axis."""
        return float(self.d[1] + self.elbow_turn * (self.d[2] + np.cos(self.alpha[2]) * self.d[3]))

    @property
    def wrist_p_centre(self) -> Array:
        """The wrist's centre in the frame in which row 6 ends: row 6 turns about it whatever theta6 is."""
        back = np.array([-self.a[5], 0.0, -self.d[5]])
        return np.asarray(rotation(0, -self.alpha[5:])[0] @ back)

    def branch(self, theta: Array) -> Branch:
        """On which branch one posture (6,) is."""
        x = self.a[1] * np.cos(theta[1]) + self.reach * np.cos(theta[1] + self.elbow_turn * (theta[2] + self.lean))
        shoulder, elbow, wrist = self.a[0] + x, np.sin(theta[2] + self.lean), np.sin(theta[4])
        return (1 if shoulder >= 0 else -1, 1 if elbow >= 0 else -1, 1 if wrist >= 0 else -1)

    def solve(self, foot_T_wrist: Pose, branch: Branch | Branches) -> tuple[Array, NDArray[np.bool_], Array]:
        """Closed form: angles (M, 6) rad on one branch, or on one for each pose, NaN where out of reach.

        Also which poses (M,) can be reached, and how far (M,) the wrist's centre is from axis 1, in m, negative behind it.
        """
        turn, place = foot_T_wrist
        shoulder, elbow, wrist = branch
        foot_p_centre = place + turn @ self.wrist_p_centre
        wx, wy, wz = foot_p_centre.T
        c, s1, s4, s5 = self.height, np.sin(self.alpha[0]), np.sin(self.alpha[3]), np.sin(self.alpha[4])
        square = wx * wx + wy * wy - c * c
        along = shoulder * np.sqrt(np.maximum(square, 0.0))
        x, y = along - self.a[0], (wz - self.d[0]) / s1
        a2, reach = self.a[1], self.reach
        cosine = (x * x + y * y - a2 * a2 - reach * reach) / (2.0 * a2 * reach)
        reached = (square >= 0.0) & (np.abs(cosine) <= 1.0)
        beta = elbow * np.arccos(np.clip(cosine, -1.0, 1.0))
        theta = np.empty((len(turn), 6))
        theta[:, 0] = np.arctan2(wy, wx) - np.arctan2(-c * s1, along)
        theta[:, 1] = np.arctan2(y, x) - np.arctan2(self.elbow_turn * reach * np.sin(beta), a2 + reach * np.cos(beta))
        theta[:, 2] = beta - self.lean
        foot_R_third = self.forward(theta, rows=3, places=False)[0]
        rest = np.swapaxes(foot_R_third, 1, 2) @ turn @ rotation(0, -self.alpha[5:])
        theta[:, 3] = np.arctan2(s5 * wrist * rest[:, 1, 2], s5 * wrist * rest[:, 0, 2])
        theta[:, 4] = np.arctan2(wrist * np.hypot(rest[:, 0, 2], rest[:, 1, 2]), -s4 * s5 * rest[:, 2, 2])
        theta[:, 5] = np.arctan2(-s4 * wrist * rest[:, 2, 1], s4 * wrist * rest[:, 2, 0])
        theta[~reached] = np.nan
        return theta, reached, along

    def newton(self, foot_T_wrist: Pose, start: Array) -> Array | None:
        """Angles (6,) rad of one pose, from `start` (6,) on by Newton's method; None where it doesn't get there."""
        theta = start.copy()
        goal = joined(foot_T_wrist[0][0], foot_T_wrist[1][0])
        for _ in range(60):
            error, slope = self._error(theta, goal), np.empty((6, 6))
            if np.abs(error).max() < 1e-11:
                return theta
            for k in range(6):
                nudge = np.zeros(6)
                nudge[k] = 1e-6
                slope[:, k] = (self._error(theta + nudge, goal) - self._error(theta - nudge, goal)) / 2e-6
            step = np.linalg.lstsq(slope, -error, rcond=1e-12)[0]
            theta = theta + step * min(1.0, 0.5 / max(float(np.abs(step).max()), 1e-12))
        return theta if np.abs(self._error(theta, goal)).max() < 1e-9 else None

    def _error(self, theta: Array, goal: Array) -> Array:
        """What is left to the goal (6,): m, and rad times one metre."""
        turn, place = self.forward(theta[None])
        left = inverse(goal) @ joined(turn, place)[0]
        return np.concatenate([left[:3, 3], rotation_vector(left[None, :3, :3])[0]])

    def all_postures(self, foot_T_wrist: Pose, near: Array) -> list[Array]:
        """Every posture (6,) rad found for one pose: up to eight in closed form, else by Newton from `near` and fixed seeds."""
        if self.spherical:
            every = np.repeat(foot_T_wrist[0], 8, axis=0), np.repeat(foot_T_wrist[1], 8, axis=0)
            shoulder, elbow, wrist = np.array(BRANCHES).T
            postures, reached, _ = self.solve(every, (shoulder, elbow, wrist))
            return list(postures[reached])
        kept: list[Array] = []
        for seed in (near, *_SEEDS):
            theta = self.newton(foot_T_wrist, seed)
            if theta is not None and not any(np.cos(theta - other).min() > np.cos(1e-6) for other in kept):
                kept.append(theta)
        return kept

    def stretched_deg(self) -> float:
        """The value of A3 at which the arm is stretched, -180 to 180 degrees."""
        theta3 = (0.0 if self.a[1] >= 0 else np.pi) - self.lean
        axis = self.sign[2] * rad_to_deg(theta3 - self.theta_offset[2]) + self.axis_offset[2]
        return float(wrapped(np.array([axis]))[0])

    def bends(self, axes: Array) -> tuple[Array, Array, Array]:
        """How far from singular, (M,) each: wrist's bend and elbow's bend in degrees, the wrist's centre from axis 1 in m."""
        theta = self.theta(axes)
        elbow = np.arcsin(np.clip(np.abs(np.sin(theta[:, 2] + self.lean)), 0.0, 1.0))
        wrist = np.arcsin(np.clip(np.abs(np.sin(theta[:, 4])), 0.0, 1.0))
        centre = self.forward(theta, rows=4)[1]
        return rad_to_deg(wrist), rad_to_deg(elbow), np.hypot(centre[:, 0], centre[:, 1])

    def status(self, axes: Array) -> NDArray[np.int64]:
        """KUKA's S (M,), bits 0 to 2, of axis values (M, 6) degrees.

        Bit 0: the wrist's centre lies behind axis 1, seen in the system that turns with A1 and is `$ROBROOT` at A1 = 0. Bit 1:
        A3 at or above its stretched value. Bit 2: A5 below zero. (KUKA System Software 5.x, Expert Programming: Status, Turn.)
        """
        theta = self.theta(axes)
        centre = self.forward(theta, rows=4)[1]
        zero = self.theta(np.zeros((1, 6)))[0, 0]
        ahead = (rotation(2, theta[:, 0] - zero) @ self.foot_R_root[:, :1])[..., 0]
        behind = np.sum(centre[:, :2] * ahead[:, :2], axis=-1) < 0.0
        bent = wrapped(axes[:, 2] - self.stretched_deg()) >= 0.0
        under = wrapped(axes[:, 4]) < 0.0
        return np.asarray(behind.astype(np.int64) + 2 * bent + 4 * under)

    def turn(self, axes: Array) -> NDArray[np.int64]:
        """KUKA's T (M,): bit k set where axis k + 1 is below zero."""
        return np.asarray((axes < 0.0) @ (1 << np.arange(6)), dtype=np.int64)
