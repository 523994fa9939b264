"""The rotary table's bearing: its axis wobbles and runs out as it turns, and leans to the side that it came from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.cell.joint import Role
from camrob.gap.effects.common import moved, shows
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.observation.scene import Scene
from camrob.gap.observation.signals import play, play_at_rest
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["EFFECT"]

# of an ordinary rotary table: 0.09 mm at a radius of 1 m, and its run-out
_TILT, _RUN = deg_to_rad(0.005), mm_to_m(0.05)
_MOST = 20.0  # times the ordinary size
_ORDERS = (1, 2)  # times a turn: a bent axis; a bearing out of round
_RANGE = deg_to_rad(60.0)  # that the table turns by at the least: less is an offset and a slope
_WIDTHS = tuple(deg_to_rad(w) for w in (0.01, 0.1, 0.5, 2.0))  # of travel that a bearing takes to lean over


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    """Wobble (tilts) and run-out (shifts) in harmonics of its angle; hysteresis as a tilt that follows the direction."""
    units = []
    for joint in scenes[0].cell.joints:
        a = joint.name
        # measured from the world, a table does not show
        if joint.role is not Role.WORKPIECE or joint.prismatic or not moved(scenes, a) or not shows(scenes, a):
            continue
        if max(float(np.ptp(s.link[:, s.index(a)])) for s in scenes) > _RANGE:
            for kind, parts, unit, usual in (
                ("wobble", ("rx", "ry"), "deg", _TILT),
                ("runout", ("x", "y"), "mm", _RUN),
            ):
                for order in _ORDERS:
                    names = [f"{a}_{p}_{wave}{order}_{unit}" for p in parts for wave in ("cos", "sin")]
                    parameters = tuple(
                        EffectParameter(n, unit, usual / order, -_MOST * usual, _MOST * usual) for n in names
                    )
                    units.append(Unit("turntable", a, parameters, key=f"{kind} {order}"))
        leans = tuple(
            EffectParameter(f"{a}_{p}_direction_deg", "deg", _TILT, -_MOST * _TILT, _MOST * _TILT) for p in ("rx", "ry")
        )
        units.append(Unit("turntable", a, leans, key="hysteresis"))
    return tuple(units)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    kind, _, order = unit.key.partition(" ")
    angle = scene.link[:, scene.index(unit.axis)]
    if kind == "hysteresis":
        width = state.get("width", _WIDTHS[0])
        side = play_at_rest(angle, width) if scene.poses else play(angle, scene.t, scene.pieces, width)
        return tuple(Column(tcp=_seen(scene, part) * side[:, None]) for part in ("rx", "ry"))
    parts = ("rx", "ry") if kind == "wobble" else ("x", "y")
    waves = np.cos(int(order) * angle), np.sin(int(order) * angle)
    return tuple(Column(tcp=_seen(scene, part) * w[:, None]) for part in parts for w in waves)


def _seen(scene: Scene, part: str) -> NDArray[np.float64]:
    """(N, 6) twist of what is measured from the table, where the table moves by a unit along, or about, an axis of the world."""
    along = -scene.measured_R_world[:, :, "xy".index(part[-1])]
    out = np.zeros((len(scene), 6))
    if part[0] == "r":
        # about the table's own middle, which is the measured frame's origin
        out[:, :3], out[:, 3:] = np.cross(along, scene.nominal[:, :3, 3]), along
    else:
        out[:, :3] = along
    return out


EFFECT = Effect(
    name="turntable",
    physics="The table's axis tilts and shifts as it turns, once or twice a turn, and tilts with the direction it came from.",
    stages=("encoder_to_tcp",),
    regimes=("position", "direction"),
    experiment="touch one point of the table at twelve angles, first forwards, then backwards, the arm measuring",
    remedy=(
        "check the table's bearing with a dial gauge at twelve angles, forwards and backwards; what comes back "
        "every turn can be corrected, play can't"
    ),
    units=_units,
    columns=_columns,
    trials=tuple({"width": w} for w in _WIDTHS),
    accuracy=0.02,
)
