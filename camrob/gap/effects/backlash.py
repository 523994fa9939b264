"""Play between an encoder and its link."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.cell.joint import Role
from camrob.gap.effects.common import found_once, moved, shows
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.observation.noise import plain_gap
from camrob.gap.observation.scene import Scene
from camrob.gap.observation.signals import play, play_at_rest
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["EFFECT"]

Array = NDArray[np.float64]

_WHOLE = 2.0  # of half the play: what the other side makes
_ROWS = 600  # samples of all logs that tell well enough how far apart the two sides are
_START = 0.6  # of the ordinary play, where they don't
_RANK = 1e-7


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    cell = scenes[0].cell
    units = []
    for joint in cell.joints:
        a = joint.name
        if joint.role is Role.ROLL or not moved(scenes, a) or not shows(scenes, a):
            continue
        if joint.prismatic:
            parameter = EffectParameter(f"{a}_mm", "mm", mm_to_m(0.1), -mm_to_m(0.005), mm_to_m(1.0))
        else:
            parameter = EffectParameter(f"{a}_deg", "deg", deg_to_rad(0.03), -deg_to_rad(0.001), deg_to_rad(0.6))
        width = float(np.clip(_apart(scenes).get(a, 0.0), _START * parameter.usual, parameter.upper))
        units.append(Unit("backlash", a, (parameter,), key=f"{width:.6g}"))
    return tuple(units)


def _apart(scenes: Sequence[Scene]) -> dict[str, float]:
    """By axis, how far apart its link stands on the two sides, beside constants of the chain: as wide a play would be, if it were
    one. Where the shape begins: a play that is far wider would look like springs that slip.
    """
    return found_once(scenes, ("apart",), lambda: _sides_apart(scenes))


def _sides_apart(scenes: Sequence[Scene]) -> dict[str, float]:
    step = max(1, sum(map(len, scenes)) // _ROWS)
    axes = [a for a in scenes[0].axes if all(f"{a}.zero" in s.places for s in scenes)]
    X = np.concatenate(
        [
            np.stack(
                [p[::step, :3].ravel() for p in s.places.values()]
                + [s.shift(a, -0.5 * s.sides[:, s.index(a)])[::step, :3].ravel() for a in axes],
                axis=1,
            )
            for s in scenes
        ]
    )
    y = np.concatenate([plain_gap(s)[::step, :3].ravel() for s in scenes])
    scale = np.maximum(np.linalg.norm(X, axis=0), 1e-300)
    values = np.linalg.lstsq(X / scale, y, rcond=_RANK)[0] / scale
    return dict(zip(axes, values[-len(axes) :].tolist() if axes else [], strict=True))


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    width = state.get(unit.parameters[0].name, float(unit.key or _START * unit.parameters[0].usual))
    values = scene.link[:, scene.index(unit.axis)]
    if scene.poses:
        # the side is that of the last move, wherever in time the poses lie
        lag = play_at_rest(values, width)
    else:
        lag = play(values, scene.t, scene.pieces, width)
    runs = (slice(0, len(scene)),) if scene.poses else scene.pieces
    return (Column(tcp=scene.shift(unit.axis, -0.5 * lag), doubt=_doubt(values, runs, width)),)


def _doubt(values: Array, pieces: Sequence[slice], width: float) -> Array | None:
    """(N,) doubt of a play's state: in each run, the side is unknown until the axis has moved by the whole width.

    The side of one run is one unknown, however long it rests: all its samples together weigh like one. A run in which the
    axis never moves so far has no play in it, as far as the description goes.
    """
    out = np.zeros(len(values))
    for run in pieces:
        u = values[run]
        # farthest back so far on either side: the play is taken up where the way from there passes its width
        way = np.maximum(u - np.minimum.accumulate(u), np.maximum.accumulate(u) - u)
        taken = np.flatnonzero(way > width)
        if len(taken):
            out[run.start : run.start + int(taken[0])] = _WHOLE * np.sqrt(max(int(taken[0]), 1))
    return out if out.any() else None


def _refine(state: State, values: Mapping[str, float]) -> dict[str, float]:
    return {**state, **{name: value for name, value in values.items() if value > 0.0}}


EFFECT = Effect(
    name="backlash",
    physics="The link rests until the play is taken up after a reversal: it lags its encoder by half the play.",
    stages=("encoder_to_tcp",),
    regimes=("direction",),
    experiment="run the path backwards: what play causes changes its sign, geometry and load don't",
    remedy=(
        "have the play of these axes taken up (gear, and the belt of a wrist's axis); until then come to what "
        "matters from one side"
    ),
    units=_units,
    columns=_columns,
    refine=_refine,
    accuracy=0.02,
)
