"""What instruments and recorders do, what no cause explains (leftovers), and the noise."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from gap.ninth_author.drive_causes import first_order
from gap.ninth_author.paths import DT, Run
from gap.ninth_author.shift import Shift, nominal

__all__ = [
    "adm_cyclic",
    "block_ends",
    "encoder_filter",
    "latency",
    "leftover",
    "measurement_drift",
    "measurement_scale",
    "scatter",
]


def latency(run: Run, key, s) -> Shift:
    """The instrument's stamp is s seconds after what it saw."""
    return Shift(delay=s)


def measurement_scale(run: Run, key, s) -> Shift:
    """Its distances are too long by s."""
    return Shift(scale=s)


def measurement_drift(run: Run, key, s) -> Shift:
    """Its stand, set up before each log, moves off and turns as it warms in the hall, fast at first."""
    settle, to, turn = key
    t = run.t[run.pick] - run.t[0]
    g = (s * np.log1p(t / settle))[:, None]
    return Shift(seen=g * np.array(to), about=g * np.array(turn))


def adm_cyclic(run: Run, key, s) -> Shift:
    """Foreign: an absolute distance meter whose error is a wave over the distance."""
    place, wave, phase = key
    away = nominal(run, "world")[:, :3, 3] - np.array(place)
    far = np.linalg.norm(away, axis=1, keepdims=True)
    return Shift(seen=s * np.sin(2 * np.pi * far / wave + phase) * away / far)


def encoder_filter(run: Run, key, s) -> Shift:
    """Foreign: the recorder smooths the encoders over s seconds; the machine itself is where it should be."""
    s = s * key[0]
    return Shift(read=first_order(first_order(run.q, 0.6 * s), 0.4 * s) - run.q)


def block_ends(run: Run, key, s) -> Shift:
    """Foreign: as set-points the ends of the blocks are logged, not what the interpolator asks for."""
    return Shift(told=run.blocks)


def _waves(rng, z, count, out):
    """A smooth random field (N, out) over z (N, k): cosines in random directions, longer ones more often."""
    w = rng.normal(size=(z.shape[1], count)) / rng.uniform(1.1, 2.6, count)
    return np.cos(z @ w + rng.uniform(0, 2 * np.pi, count)) @ rng.normal(size=(count, out)) / np.sqrt(count)


def leftover(run: Run, seed, s) -> Shift:
    """What stays on any machine: castings that twist a little by posture and load, at foot and elbow, in part by direction."""
    rng, arm = np.random.default_rng(seed), run.arm
    way = np.tanh(run.moves / 0.02) if run.kind == "poses" else first_order(np.tanh(run.rate() / 0.05), 0.15)
    if run.kind == "drives":
        out, reach = np.zeros_like(run.q), arm.jacobian(arm.middle[None])[0, :3]
        for i in range(arm.n):
            z = np.stack(
                [(run.q[:, i] - arm.middle[i]) / arm.spread[i], 2 * run.rate()[:, i] / arm.speed, way[:, i]], 1
            )
            out[:, i] = s * _waves(rng, z, 40, 1)[:, 0] / np.abs(reach[:, i]).max().clip(0.2)
        return Shift(drive=out)
    z = (run.q - arm.middle)[:, arm.first :] / arm.spread[arm.first :]
    load = run.loads[:, arm.first :]
    z = np.concatenate([1.3 * z, 0.5 * load / (np.abs(load).mean(0) + 1.0), 0.35 * way[:, arm.first :]], 1)
    if arm.first:
        z = np.concatenate([z, 0.8 * run.q[:, 1:2] / arm.spread[1]], 1)
    foot, elbow = _waves(rng, z, 60, 6), _waves(rng, z, 60, 6)
    foot[:, 3:] *= 0.5
    return Shift(twists={"foot": s * foot, min(arm.first + 2, arm.n - 1): s * elbow})


def scatter(rng, run: Run, white, wander, chatter):
    """Noise (N, 3) in m at the rows: white, a slow wander, and chatter in a narrow band that the rows fold."""
    n = len(run.pick)
    out = white * rng.normal(size=(n, 3))
    if run.kind == "poses":
        walk = lfilter([1], [1, -0.7], rng.normal(size=(n + 20, 3)), axis=0)[20:] * np.sqrt(1 - 0.49)
        return out + wander * walk
    m = len(run.t)
    tau = rng.uniform(0.5, 2.5)
    a = np.exp(-DT / tau)
    slow = lfilter([np.sqrt(1 - a * a)], [1, -a], rng.normal(size=(m + 2000, 3)), axis=0)[2000:]
    f, damp = rng.uniform(35, 90), 0.985
    band = lfilter([1], [1, -2 * damp * np.cos(2 * np.pi * f * DT), damp**2], rng.normal(size=(m + 500, 3)), axis=0)[
        500:
    ]
    band *= np.array([1.0, 0.7, 0.4]) / (band.std() * np.sqrt(np.mean([1.0, 0.49, 0.16])))
    engaged = np.linalg.norm(run.force, axis=1, keepdims=True)
    engaged = engaged / engaged.max() if engaged.any() else np.ones((m, 1))
    return out + (wander * slow + chatter * band * (0.2 + engaged))[run.pick]
