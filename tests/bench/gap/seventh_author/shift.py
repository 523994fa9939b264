"""What causes do to a run, stage by stage, at its logged rows; what is then measured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .machines import small


@dataclass
class Shift:
    """`enc`: encoder less set-point, `true`: axis less encoder, (N, n); `twist` (N, n + 2, 6); `off`, `turn` of readings."""

    enc: np.ndarray
    true: np.ndarray
    twist: np.ndarray
    off: np.ndarray
    turn: np.ndarray

    @classmethod
    def none(cls, run):
        rows, n = run.c.shape
        return cls(*(np.zeros(s) for s in ((rows, n), (rows, n), (rows, n + 2, 6), (rows, 3), (rows, 3))))

    def parts(self):
        return (self.enc, self.true, self.twist, self.off, self.turn)

    def __add__(self, other):
        return Shift(*(a + b for a, b in zip(self.parts(), other.parts(), strict=True)))


def total(run, shifts):
    return sum(shifts, Shift.none(run))


def read(run, shift, target=None):
    """Poses as measured, without noise, (N, 4, 4); `target`: where the reflector sits in the tool's frame, m."""
    tip = run.machine.tip(run.c + shift.enc + shift.true, shift.twist)
    out = small(np.concatenate([0 * shift.turn, shift.turn], 1)) @ tip
    at = tip[:, :3, 3] if target is None else tip[:, :3, :3] @ target + tip[:, :3, 3]
    out[:, :3, 3] = at + shift.off
    return out


def rms(off):
    """3-D, of (N, 3)."""
    return float(np.sqrt((np.asarray(off) ** 2).sum(-1).mean()))


def seen(run, shift, frame_known, target):
    """What it does to the tool's place in m, less what an unknown frame and target take up; of drives, at the encoders."""
    if run.kind == "drives":
        return run.machine.tip(run.c + shift.enc)[:, :3, 3] - run.points
    off = (read(run, shift, target) - read(run, Shift.none(run), target))[:, :3, 3]
    columns = [] if target is None else [run.frames[-1][:, :3, k] for k in range(3)]
    if not frame_known:
        eye = np.eye(3)
        columns += [np.tile(e, (len(off), 1)) for e in eye] + [np.cross(e, run.points) for e in eye]
    if not columns:
        return off
    a = np.stack([c.ravel() for c in columns], 1)
    return off - (a @ np.linalg.lstsq(a, off.ravel(), rcond=None)[0]).reshape(-1, 3)
