"""Paths with postures for the tests of feed and timing, made from postures so that the two fit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from camrob.cell.read_cell import read_cell
from camrob.kinematics.frames import base_T_tool
from camrob.redundancy.path import ToolPathInBase

_KR15 = read_cell(Path(__file__).resolve().parents[1] / "cells" / "kr15_track_table")
CELL = replace(
    _KR15, controller_section=replace(_KR15.controller, block_ms=0.0)
)  # points as near together as a test likes


def track_path(y: np.ndarray, *, feed: float, cutting: np.ndarray | None = None) -> tuple[ToolPathInBase, np.ndarray]:
    """The arm stands still at HOME and the track carries it to y (N,), m."""
    q = np.tile(CELL.q_home, (len(y), 1))
    q[:, CELL.index("E1")] = y
    return path_of(q, feed=feed, cutting=cutting)


def path_of(q: np.ndarray, *, feed: float, cutting: np.ndarray | None = None) -> tuple[ToolPathInBase, np.ndarray]:
    """The path that postures q (N, n) of the KR15 cell run through."""
    n = len(q)
    cut = np.ones(n, bool) if cutting is None else cutting
    frames = base_T_tool(CELL, q)
    return ToolPathInBase(
        frames,
        cut.astype(np.int8),
        np.where(cut, feed, np.nan),
        np.arange(n) + 10,
        np.zeros(n, np.int32),
        np.arange(n),
        ~cut,
    ), q


def wave(count: int = 400, *, turns: float = 1.0) -> np.ndarray:
    """Postures (count, n) of a smooth winding path that uses all axes."""
    t = np.linspace(0.0, turns, count)
    q = np.tile(CELL.q_home, (count, 1))
    for i in range(8):
        q[:, i] += 0.05 * np.sin(2.0 * np.pi * (t * (1 + 0.3 * i) + 0.1 * i))
    return q
