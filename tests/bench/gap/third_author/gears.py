"""Gears: flanks that load and friction choose, Bouc and Wen's loop, cycloid drives, a bevel hand, readings on the way in."""

from __future__ import annotations

import numpy as np

from gap.second_author.family import Description, axis_delta
from gap.second_author.run import BODY, DRIVE, Cause
from gap.third_author.tools import small_step, turning, way


def backlash(setting, rng, s):
    """Play in which weight and friction choose the flank; the flanks give, as Hertz has it, before the tooth is at rest."""
    picked = setting.arm(rng, 2, setting.moving())
    whole = {i: 1.3 * s * small_step(setting.robot, i) * rng.uniform(0.6, 1.5) for i in picked}
    rubs, soft, reverse = rng.uniform(1.2, 4.0), rng.uniform(0.05, 0.4), rng.uniform(0.3, 1.5)

    def link(run):
        out = {}
        for i, width in whole.items():
            pull = run.load[:, i] / (np.abs(run.load[:, i]).max() + 1.0)
            push = pull - rubs * way(run, i, reverse * small_step(setting.robot, i))
            out[i] = 0.5 * width * np.sign(push) * (np.abs(push) / (np.abs(push) + soft)) ** (2.0 / 3.0)
        return axis_delta(run, out)

    params = {setting.key(i): setting.told(i, w) for i, w in whole.items()}
    return Cause("backlash", BODY, [setting.names[i] for i in picked], params, ["direction"], link=link)


def bouc_wen(x, reach, beta, power, most=0.05):
    """Bouc and Wen's state of a path x (N,), which tends to 1 within some `reach`; long steps are taken in parts."""
    z, out = 0.0, [0.0]
    gamma = 1.0 - beta
    for move in (np.diff(x) / reach).tolist():
        parts = max(1, int(abs(move) / most) + 1)
        if parts > 400:  # far behind saturation
            move, parts = (20.0 if move > 0 else -20.0), 400
        step = move / parts
        for _ in range(parts):
            z += step - abs(z) ** power * (beta * abs(step) * (1.0 if z > 0 else -1.0) + gamma * step)
        out.append(z)
    return np.array(out)


def hysteresis(setting, rng, s):
    """Bouc and Wen: a link wound up behind its encoder, by a loop that is rounder or sharper, and not the same both ways."""
    picked = setting.arm(rng, 2, setting.moving())
    wound = {i: s * small_step(setting.robot, i) * rng.uniform(0.6, 1.4) for i in picked}
    beta, power, reach = rng.uniform(0.55, 0.95), rng.uniform(1.0, 3.0), np.exp(rng.uniform(np.log(8), np.log(300)))

    def link(run):
        return axis_delta(
            run,
            {
                i: -w * bouc_wen(run.c[:, i], reach * small_step(setting.robot, i), beta, power)
                for i, w in wound.items()
            },
        )

    params = {setting.key(i): setting.told(i, w) for i, w in wound.items()}
    return Cause("hysteresis", BODY, [setting.names[i] for i in picked], params, ["direction"], link=link)


def gear_ripple(setting, rng, s):
    """A cycloid drive behind a planet stage: once a turn of the crank as its discs aren't alike, twice as they are two, and
    once a turn of the sun; the more torque, the more of it.
    """
    (i,) = setting.arm(rng, 1, turning(setting))
    crank = float(rng.integers(29, 60))
    sun = crank * rng.uniform(2.2, 3.6)
    size, twice, fast = 0.7 * s * small_step(setting.robot, i), rng.uniform(0.1, 0.5), rng.uniform(0.05, 0.25)
    under, phase = rng.uniform(0, 0.5), rng.uniform(0, 2 * np.pi, 3)

    def link(run):
        q, load = run.c[:, i], np.abs(run.load[:, i])
        strong = 1.0 - under + under * load / (load.max() + 1e-9) if load.max() > 0.3 else 1.0
        wave = (
            np.sin(crank * q + phase[0]) + twice * np.sin(2 * crank * q + phase[1]) + fast * np.sin(sun * q + phase[2])
        )
        return axis_delta(run, {i: size * strong * wave})

    params = {setting.key(i): setting.told(i, size), "orders_a_turn": crank}
    return Cause("gear_ripple", BODY, [setting.names[i]], params, ["position"], link=link)


def wrist_coupling(setting, rng, s):
    """A hand with bevel wheels: A5 carries A6 by a ratio that is not the told one, A4 both; a wheel runs out of true."""
    four, five, six = setting.robot.arm[3:6]
    a, b, c = s * 3e-4 * rng.normal(size=3)
    out, phase = s * 6e-5, rng.uniform(0, 2 * np.pi)

    def link(run):
        q4, q5 = run.c[:, four], run.c[:, five]
        return axis_delta(run, {five: a * q4, six: b * q4 + c * q5 + out * np.sin(q5 - q4 + phase)})

    axes = [setting.names[five], setting.names[six]]
    return Cause("wrist_coupling", BODY, axes, {"A4_A5": a, "A4_A6": b, "A5_A6": c}, ["position"], link=link)


def early_reading(setting, rng, s):
    """Readings a fixed while behind each command: long moves are still coming in, as a loop of two equal poles does."""
    picked = setting.arm(rng, 3)
    w, wait, size = rng.uniform(4, 9), rng.uniform(0.5, 1.2), 12 * s * small_step(setting.robot, 0)
    top = np.array([r.speed for r in setting.robot.rows]) * setting.robot.unit * rng.uniform(0.5, 1.0)
    drives = rng.random() < 0.5 and setting.log["encoders"]

    def behind(run):
        lasts = (np.abs(run.came) / top).max(axis=1)
        left = np.maximum(0.35 * wait, 1.6 * wait - lasts)
        slow = (1 + w * left) * np.exp(-w * left)
        return axis_delta(
            run, {i: -size * slow * run.came[:, i] / (np.abs(run.came[:, i]).max() + 1e-9) for i in picked}
        )

    hook = {"drive": behind} if drives else {"link": behind}
    names = [setting.names[i] for i in picked]
    return Cause("early_reading", DRIVE if drives else BODY, names, {"band": w}, ["direction"], **hook)


T = frozenset({"tracker"})
GEARS = [
    Description("backlash", backlash, T, 20),
    Description("hysteresis", hysteresis, T, 20),
    Description("gear_ripple", gear_ripple, T, 20),
    Description("wrist_coupling", wrist_coupling, T | {"wrist"}, 15),
    Description("early_reading", early_reading, T | {"poses", "setpoints"}, 20),
]
