"""Instruments: clocks that are put right by steps, cameras whose depth is another scale, distances that jump, nests; tables."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from gap.second_author.chain import small
from gap.second_author.family import Description
from gap.second_author.run import BODY, Cause


def latency(setting, rng, s):
    """The instrument gives the mean of its last readings, on a clock that runs away and is put right every few seconds."""
    delay, every, share = 0.008 * s * rng.choice([-1, 1], p=[0.3, 0.7]), rng.uniform(4, 16), rng.uniform(0, 0.15)

    def late(run):
        return delay * (1 + share * ((run.clock / every) % 1.0 - 0.5))

    return Cause("latency", BODY, [], {"s": delay}, ["speed"], late=late)


def _turned(vector):
    return Rotation.from_rotvec(vector).as_matrix()


def nudged(tool, shift, turn):
    """Frames seen from where they are shifted and turned by a little, row by row: (N, 3) each, m and rad."""
    rows = (len(tool), 3)
    return small(np.concatenate([np.broadcast_to(shift, rows), np.broadcast_to(turn, rows)], axis=1)) @ tool


def measurement_scale(setting, rng, s):
    """A pair of cameras: its scale bar is off, and its base, on which depth hangs, is off by something else."""
    look = rng.normal(size=3) * np.array([1, 1, 0.25])
    look /= np.linalg.norm(look)
    ppm, depth, known = s * 80e-6 * rng.choice([-1, 1]), rng.uniform(0.7, 1.5), rng.uniform(-0.8, 0.8, 3)

    def measured(run, tool):
        tool = tool.copy()
        off = tool[:, :3, 3] - known
        tool[:, :3, 3] += ppm * (off + (depth - 1) * np.outer(off @ look, look))
        return tool

    return Cause("measurement_scale", BODY, [], {"ppm": ppm * 1e6}, ["position"], measured=measured)


def measurement_drift(setting, rng, s):
    """A tracker that loses its beam and takes it up again: the distance is off by another amount each time, and the line of
    sight has turned a little.
    """
    stand, seed = (
        rng.uniform(2.0, 4.0) * _turned([0, 0, rng.uniform(0, 6.28)])[:, 0] + [0, 0, 0.8],
        int(rng.integers(1 << 30)),
    )
    every, turn = rng.uniform(20, 120), s * rng.normal(size=3) * 1.5e-5

    def measured(run, tool):
        own = np.random.default_rng(seed)
        times = np.cumsum(own.exponential(every, 2000))
        jumps, turns = np.cumsum(own.normal(size=2001)) * 8e-5 * s, np.cumsum(own.normal(size=2001))
        k = np.searchsorted(times, run.clock)
        away = tool[:, :3, 3] - stand
        along = away / np.linalg.norm(away, axis=1, keepdims=True)
        by = np.outer(turns[k] - turns[0], turn)  # about the stand
        return nudged(tool, (jumps[k] - jumps[0])[:, None] * along - np.cross(by, stand), by)

    return Cause("measurement_drift", BODY, [], {"mm": 0.08 * s}, ["time"], measured=measured)


def measurement_frame(setting, rng, s):
    """Nests that gave the instrument's frame stand close together: its turns are badly known, and tell far from them."""
    nests = rng.uniform(-1, 1, 3) * np.array([1.5, 1.5, 0.3])
    turn, shift = rng.normal(size=3) * 1.5e-4 * s, rng.normal(size=3) * 5e-5 * s

    def measured(run, tool):
        tool = tool.copy()
        tool[:, :3, 3] = (tool[:, :3, 3] - nests) @ _turned(turn).T + nests + shift
        tool[:, :3, :3] = _turned(turn) @ tool[:, :3, :3]
        return tool

    return Cause("measurement_frame", BODY, [], {"rad": turn.tolist()}, ["position"], measured=measured)


def turntable(setting, rng, s):
    """A face plate clamped off its middle and not square to its spindle, on a worm wheel that is not round."""
    wobble, out, wheel = s * 1.2e-4, s * 8e-5, s * rng.uniform(0, 6e-5)
    phase, teeth = rng.uniform(0, 2 * np.pi, 3), float(rng.choice([72, 90, 120]))

    def on_table(run, tool):
        e = run.table
        lies = wheel * (np.sin(e + phase[2]) + 0.15 * np.sin(teeth * e))
        turn = np.stack([wobble * np.cos(e + phase[0]), -wobble * np.sin(e + phase[0]), lies], 1)
        shift = out * np.stack(
            [np.cos(e + phase[1]) - np.cos(phase[1]), np.sin(phase[1]) - np.sin(e + phase[1]), 0 * e], 1
        )
        return nudged(tool, shift, turn)

    return Cause(
        "turntable", BODY, ["E2"], {"wobble_rad": wobble, "out_mm": out * 1e3}, ["position"], on_table=on_table
    )


def frame_table(setting, rng, s):
    """A table whose middle was found from a short arc: off along the arc's height most; and it was not levelled."""
    facing = rng.uniform(0, 2 * np.pi)
    along = np.array([np.cos(facing), np.sin(facing), 0.0])
    off = s * 2e-4 * (rng.normal() * along + 0.15 * rng.normal(size=3))
    tilt = s * 1.2e-4 * rng.normal(size=3) * np.array([1.0, 1.0, 0.0])

    def on_table(run, tool):
        plate = Rotation.from_rotvec(np.outer(run.table, [0, 0, 1.0]))
        return nudged(tool, plate.apply(off), plate.apply(tilt))  # the same in world, whatever the plate's angle

    params = {"tilt_rad": tilt.tolist(), "off_mm": (off * 1e3).tolist()}
    return Cause("frame_table", BODY, [], params, ["position"], on_table=on_table)


T = frozenset({"tracker"})
INSTRUMENTS = [
    Description("latency", latency, T | {"path", "frame_known"}, 12),
    Description("measurement_scale", measurement_scale, T, 15),
    Description("measurement_drift", measurement_drift, T, 15),
    Description("measurement_frame", measurement_frame, T | {"frame_known"}, 20),
    Description("turntable", turntable, T | {"table"}, 15),
    Description("frame_table", frame_table, T | {"table"}, 15),
]
