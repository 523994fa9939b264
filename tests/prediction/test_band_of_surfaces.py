"""What the band of a predicted surface holds where grooves cross and run out: walls that rays take for one another."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from camrob.cutting.cutter import Cutter
from camrob.cutting.dexels import Dexels, met_by_rays
from camrob.prediction.surface import CuttersOfRun, predict_surface, way_of
from camrob.prediction.true_path import Cause, TruePath

MM = 1e-3


def raster(shift: float) -> np.ndarray:
    """(N, 4, 4) poses along a raster of a ball that lies aslant in a block, all of them `shift` m off across it."""
    turn = np.deg2rad(25.0)
    along, across = np.array([np.cos(turn), np.sin(turn), 0.0]), np.array([-np.sin(turn), np.cos(turn), 0.0])
    ends = [k * 4 * MM * across + s * 18 * MM * along for k in range(-2, 3) for s in ((1, -1) if k % 2 else (-1, 1))]
    share = np.linspace(0.0, 1.0, 40)[:-1, None]
    tips = np.concatenate([a * (1 - share) + b * share for a, b in pairwise(ends)])
    poses = np.tile(np.eye(4), (len(tips), 1, 1))
    poses[:, :3, 3] = tips + shift * across
    poses[:, 2, 3] += 5 * MM + 3 * MM * np.cos(200.0 * tips[:, 0])
    return poses


def test_a_machine_that_errs_as_foretold_lies_within_its_band_wherever_it_is_met() -> None:
    """Off across the passes by a third of their distance, it cuts some walls by other passes than was meant; who measures these
    finds them where a ray finds them, and not where their own wall would have gone.
    """
    ideal, true = raster(0.0), raster(1.3 * MM)
    twist = np.zeros((len(ideal), 6))
    twist[:, :3] = (true - ideal)[:, :3, 3]
    t, line = 0.05 * np.arange(len(ideal)), np.ones(len(ideal), np.int64)
    sure = np.full((len(ideal), 6, 1), 2e-6)
    path = TruePath(t, line, ideal, true, (Cause("aside", twist),), sure, np.full(len(ideal), 2e-6), ())
    stock = Dexels(np.array([-12, -12, 0]) * MM, np.array([12, 12, 9]) * MM, 0.4 * MM)
    cutter = Cutter(3 * MM, 3 * MM, 40 * MM)
    found = predict_surface(stock, CuttersOfRun((cutter,), (0.0,)), np.eye(4), path, ideal)
    left, meant = stock.copy(), stock.copy()
    way, as_meant = way_of(true, (cutter,)), way_of(ideal, (cutter,))
    left.carve(way.moves)
    meant.carve(as_meant.moves)
    surface = meant.surface(as_meant.moves)
    assert len(surface.point) == len(found.point)
    off = met_by_rays(surface, way.moves, left, farthest=3 * MM).deviation
    met = np.isfinite(off)
    wrong = np.abs(off - found.deviation)[met]
    assert np.mean(wrong > 0.1 * MM) > 0.03  # walls of other passes
    assert np.mean(wrong <= found.band[met] + 1e-6) > 0.99
    assert np.median(found.band) < 0.02 * MM
