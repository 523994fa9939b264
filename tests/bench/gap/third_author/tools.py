"""What descriptions share: small steps, twists, exact filters, the play operator, inertias."""

from __future__ import annotations

import numpy as np
from scipy.signal import cont2discrete, lfilter


def small_step(robot, i):
    """What counts as small at an axis: 0.15 mrad, or 0.07 mm of one that slides."""
    return 7e-5 if robot.slides[i] else 1.5e-4


def twists(run, x=0.0, y=0.0, z=0.0, rx=0.0, ry=0.0, rz=0.0):
    """Small frames (N, 6)."""
    return np.stack([np.broadcast_to(part, (len(run.t),)) for part in (x, y, z, rx, ry, rz)], axis=1).astype(float)


def filtered(num, den, dt, x):
    """A transfer function of s on x (N,) held over each step, from rest at 0."""
    b, a, _ = cont2discrete((num, den), dt, method="zoh")
    return lfilter(b.ravel(), a, x, axis=0)


def disturbed(band, damping, gain, dt, force):
    """What a force of 1 does to the position under a speed loop with an integrator (band rad/s, damping) within a
    position loop (gain 1/s), scaled so that a step of 1 moves it by 1 at the most: it gives way, and is brought back.
    """
    den = [1.0, 2 * damping * band, band**2 + 2 * damping * band * gain, gain * band**2]
    most = filtered([1.0, 0.0], den, dt, np.ones(int(4.0 / min(gain, band) / dt) + 10)).max()
    return filtered([1.0 / most, 0.0], den, dt, force)


def played(x, half):
    """The play operator: a body that a pin in a slot of half width `half` carries, in the slot's middle at first."""
    at, out = float(x[0]), []
    for here in x.tolist():
        if here - at > half:
            at = here - half
        elif at - here > half:
            at = here + half
        out.append(at)
    return np.array(out)


def way(run, i, half):
    """The side on which an axis runs, -1 to 1, which changes within a reversal of 2 `half`; at single poses of the last move."""
    x = run.c[:, i]
    if run.rest:
        return np.clip(run.came[:, i] / (2 * half), -1, 1)
    return (x - played(x, half)) / half


def inertia(run, i):
    """What turns or slides with axis i, kg m2 or kg, its motor's half of the mean included (N,)."""
    robot, (axes, ends) = run.robot, run.bones
    index = {r.name: k for k, r in enumerate(robot.rows)}
    total = np.zeros(len(run.t))
    for body in robot.bodies:
        k = index[body.after]
        if k < i:
            continue
        if robot.slides[i]:
            total += body.mass
            continue
        centre = ends[k][:, :3, :3] @ (np.array(body.centre) / 1e3) + ends[k][:, :3, 3]
        arm = np.cross(axes[i][:, :3, 2], centre - axes[i][:, :3, 3])
        total += body.mass * (arm**2).sum(1)
    return total + 0.5 * total.mean() + 1e-4


def held(robot):
    """The load in Nm that an axis holds at home with 3 Nm besides: what its gear is chosen for."""
    return np.abs(robot.moments(np.array(robot.home) * robot.unit)[0]).max(axis=1) + 3.0


def give(robot):
    """rad/Nm of each axis; a gear of twice the load is 2^(4/3) as stiff, and one of 100 Nm gives 4e-6. Slides give nothing."""
    return np.where(robot.slides, 0.0, 4e-6 * (held(robot) / 100.0) ** (-4.0 / 3.0))


def hanging(setting, least=0.3):
    """Turning axes of the arm whose load by weight changes on the way by so many Nm."""
    load = np.ptp(setting.runs[0].load, axis=0)
    return [i for i in setting.robot.arm if not setting.robot.slides[i] and load[i] > least]


def turning(setting):
    """Moving axes that turn."""
    return [i for i in setting.moving() if not setting.robot.slides[i]]
