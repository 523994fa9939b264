"""What the tests of the diagnosis share: logs of a simulated cell, made by the benchmark's generator."""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent / "bench"))

import bench_accuracy  # noqa: F401 (as the next)
import closed_loop  # noqa: F401 (found here by the tests, which have no path to it)
from gap import generator, given_back  # noqa: F401 (given_back: as the others)

from camrob.cell.cell import Cell
from camrob.cell.read_cell import read_cell
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo

KR15 = Path(__file__).resolve().parents[1] / "cells" / "kr15_track_table"
EDGE = np.array([180.0 / np.pi] * 6 + [1e3, 180.0 / np.pi])


@cache
def kr15() -> Cell:
    return read_cell(KR15)


@cache
def motion(seed: int = 5, seconds: float = 40.0):
    """(time, commanded axis values) every 4 ms."""
    return generator.path(np.random.default_rng(seed), seconds)


@cache
def poses(count: int = 120):
    """(time, axis values) of single poses, spread over the work space."""
    rng = np.random.default_rng(3)
    axis = np.deg2rad([0, -90, 90, 0, 90, 0, 0, 0.0]) + np.zeros((count, 8))
    axis[:, :6] += rng.uniform(-1, 1, (count, 6)) * np.deg2rad([30, 20, 25, 60, 40, 90])
    axis[:, 6:] = rng.uniform(-1, 1, (count, 2)) * (0.5, 2.5)
    return np.arange(count, dtype=float), axis


def simulated(
    apply=None, *, sigma_mm: float = 0.0, seed: int = 5, rate: float = 25.0, rng_seed: int = 0, run=None, **facts
) -> MeasurementLog:
    """A log of a cell on which `apply(world)` works, with noise. run: (time, command), a row a sample, instead of `motion`."""
    t, command = motion(seed) if run is None else run
    world = generator.World(t, command)
    if apply is not None:
        apply(world)
    at = np.arange(0.3, t[-1] - 0.3, 1.0 / rate) if run is None else t
    setpoint, encoder, T = generator.show(world, at)
    rng = np.random.default_rng(rng_seed)
    p = T[:, :3, 3] * 1e3 + rng.normal(0, sigma_mm, (len(at), 3))
    turned = 1e-3 * sigma_mm / 0.02
    R = np.stack([generator.turn(w) for w in np.deg2rad(rng.normal(0, turned, (len(at), 3)))]) @ T[:, :3, :3]
    columns = {"t": at, **{n: p[:, k] for k, n in enumerate("xyz")}}
    columns |= {
        "a": np.rad2deg(np.arctan2(R[:, 1, 0], R[:, 0, 0])),
        "b": np.rad2deg(-np.arcsin(R[:, 2, 0])),
        "c": np.rad2deg(np.arctan2(R[:, 2, 1], R[:, 2, 2])),
    }
    columns |= {n: encoder[:, k] * EDGE[k] for k, n in enumerate(generator.AXES)}
    columns |= {f"c{n}": setpoint[:, k] * EDGE[k] for k, n in enumerate(generator.AXES)}
    columns |= {"temp": 21.0 + 10.0 * (1 - np.exp(-at / 30.0))}
    columns |= {f"f{n}": 60.0 + 40.0 * np.sin(0.5 * at + k) for k, n in enumerate("xyz")}
    sigma = max(sigma_mm, 0.005) * 1e-3
    info = LogInfo(sigma_position=sigma, sigma_angle=np.deg2rad(1e-3) * sigma / 2e-5, **facts)
    return MeasurementLog(columns, info, Path("simulated.csv"))
