"""Motions of given logs for the gap benchmark: their set-points (encoders where there are none), clock, instrument and columns.

With these, cases are made on somebody's own path: how well would the diagnosis do there? Nothing here comes from camrob.
"""

from __future__ import annotations

import csv
import tomllib
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from gap.generator import AXES, DEG, STEP

MARGIN = 0.5  # s by which a motion goes on straight at both ends, for what is late there
_UNITS = np.array([DEG] * 6 + [1e-3, DEG])
_HOLE = 5.0  # times the ordinary step
_SIGMA_MM, _SIGMA_DEG = 0.02, 1e-3  # where the log's .toml doesn't tell


@dataclass(frozen=True)
class Motion:
    """A log's rows: times (N,), commanded axis values (N, 8) in rad and m, names of its columns, what its .toml tells."""

    at: np.ndarray
    axis: np.ndarray
    columns: tuple[str, ...]
    facts: dict
    extra: dict  # columns that are handed on as they are

    def command(self):
        """(times, axis values) every 4 ms, by splines through rows without a hole between them."""
        t = np.arange(self.at[0] - MARGIN, self.at[-1] + MARGIN, STEP)
        step = np.diff(self.at)
        cuts = [0, *(np.flatnonzero(step > _HOLE * np.median(step)) + 1), len(self.at)]
        fine = np.stack([np.interp(t, self.at, column) for column in self.axis.T], 1)
        for k, (a, b) in enumerate(pairwise(cuts)):
            if b - a < 4:
                continue
            own, spline = self.at[a:b], CubicSpline(self.at[a:b], self.axis[a:b])
            first, last = k == 0, b == len(self.at)
            here = (t >= (t[0] if first else own[0])) & (t <= (t[-1] if last else own[-1]))
            inside = np.clip(t[here], own[0], own[-1])
            fine[here] = spline(inside) + spline(inside, 1) * (t[here] - inside)[:, None]
        return t, fine


def read_motion(path):
    """The motion of LOG.csv, which has every axis of the KR15 cell; ValueError where it lacks one."""
    path = Path(path)
    with path.open(newline="") as file:
        header, *rows = list(csv.reader(file))
    table = np.array([[float(x) if x.strip() else np.nan for x in row] for row in rows if row])
    named = {name.strip(): table[:, k] for k, name in enumerate(header)}
    kind = max(("c", ""), key=lambda k: (all(k + a in named for a in AXES), sum(k + a in named for a in AXES)))
    lacking = [a for a in ("t", *(kind + a for a in AXES)) if a not in named]
    if lacking:
        raise ValueError(
            f"{path.name} lacks the column {lacking[0]}: a motion needs t and every axis, cA1 .. cE2 or A1 .. E2"
        )
    axis = np.stack([named[kind + a] for a in AXES], 1) * _UNITS
    whole = np.isfinite(axis).all(axis=1) & np.isfinite(named["t"])
    toml = path.with_suffix(".toml")
    facts = tomllib.loads(toml.read_text()) if toml.exists() else {}
    if facts.get("poses"):
        raise ValueError(f"{path.name} holds single poses: a motion is a path")
    if whole.sum() < 12:
        raise ValueError(f"{path.name} holds {int(whole.sum())} whole rows: a motion needs at least 12")
    extra = {"line": named["line"][whole]} if "line" in named else {}
    return Motion(named["t"][whole], axis[whole], tuple(named), facts, extra)


def fitted_rig(rig, motion, only=None):
    """A drawn rig, with the instrument and the columns of a motion's log; what an only effect needs is there."""
    has = set(motion.columns)
    warms = only == "thermal_drift" or rig.with_temp  # else the arm keeps its temperature
    return replace(
        rig,
        poses=False,
        in_base=motion.facts.get("measured_frame") == "base",
        told=True,
        outliers=0,
        sigma=float(motion.facts.get("sigma_mm", _SIGMA_MM)) * 1e-3,
        sigma_turned=float(motion.facts.get("sigma_deg", _SIGMA_DEG)) * DEG,
        position_only=not {"a", "b", "c"} <= has,
        lacks="encoders" if not set(AXES) <= has else "" if {f"c{a}" for a in AXES} <= has else "setpoints",
        with_force=only == "cutting_force" or {"fx", "fy", "fz"} <= has,
        with_temp=warms and "temp" in has,
    )


__all__ = ["MARGIN", "Motion", "fitted_rig", "read_motion"]
