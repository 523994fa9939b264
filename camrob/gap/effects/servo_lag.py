"""The drives follow their set-points late."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.scene import Scene
from camrob.gap.signals import first_order

__all__ = ["EFFECT"]

_START = 0.02  # s


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    if any(s.poses or s.setpoint is None for s in scenes):
        return ()
    return (Unit("servo_lag", "", (EffectParameter("tau_s", "s", 0.04, -0.002, 0.5),)),)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    cycle = state.get("cycle_s", 0.0)
    tau = max(state.get("lag_s", _START), 1e-4) + cycle
    known = scene.encoder  # where the drives stand at the start of a run is seen
    late = (first_order(scene.command, scene.t, scene.pieces, tau, cycle, known) - scene.command) / tau
    return (Column(servo={a: late[:, k] for k, a in enumerate(scene.axes)}),)


def _refine(state: State, values: Mapping[str, float]) -> dict[str, float]:
    """A drive that acts once a cycle is behind a ramp by its time constant less a cycle."""
    lag = values.get("tau_s", 0.0) - state.get("cycle_s", 0.0)
    return {**state, "lag_s": lag} if lag > 0.0 else dict(state)


EFFECT = Effect(
    name="servo_lag",
    physics="Every drive is a first-order filter on its set-points, with one time constant; continuous, or once a cycle.",
    rungs=("setpoint_to_encoder",),
    regimes=("speed",),
    experiment="run the path at half speed: what lag causes halves, play and geometry stay",
    units=_units,
    columns=_columns,
    refine=_refine,
    trials=({"cycle_s": 0.0}, {"cycle_s": 0.004}, {"cycle_s": 0.012}),
    accuracy=0.015,
)
