"""An effect that is at work in the later state of a machine alone, beside what it has always done."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.effect import Column, Effect, State, Unit, no_terms
from camrob.gap.observation.scene import Scene
from camrob.gap.states.change import Change

__all__ = ["base_name", "can_change", "name_since", "since"]

Array = NDArray[np.float64]

_PROGRAM = "program_to_setpoint"


def name_since(name: str, change: Change) -> str:
    """What the effect is called while sets are compared."""
    return f"{name} {change.said.words}"


def base_name(name: str) -> str:
    """The effect's name in the library."""
    return name.partition(" ")[0]


def can_change(effect: Effect) -> bool:
    """Whether an effect is a constant of the machine that may be another one day: not what goes with the time by itself, nor
    what the program asks for.
    """
    return "time" not in effect.regimes and _PROGRAM not in effect.stages and bool(effect.regimes)


def since(effect: Effect, change: Change, state: State, choices: int) -> Effect:
    """The effect as it is at work since a change, beside whatever it did before. state: the effect's, as found for all logs,
    where the later ones say nothing of it; choices: effects and changes that could have been picked.
    """
    name = name_since(effect.name, change)

    def units(scenes: Sequence[Scene], now: State) -> tuple[Unit, ...]:
        shown = change.shown_in(scenes)
        found = effect.units(shown, now) if shown else ()
        return tuple(Unit(name, u.axis, u.parameters, u.choices * choices, u.key) for u in found)

    def columns(scene: Scene, unit: Unit, now: State) -> tuple[Column, ...]:
        course = change.course(scene)
        if not course.any():
            return tuple(Column() for _ in unit.parameters)
        own = effect.columns(scene, replace(unit, effect=effect.name), now)
        return tuple(_masked(c, course) for c in own)

    def begin(scenes: Sequence[Scene]) -> State:
        return {**state, **effect.begin(change.shown_in(scenes))}

    def wider(scene: Scene, now: State) -> tuple[Column, ...]:
        return tuple(_masked(c, change.course(scene)) for c in effect.wider(scene, now))

    def stand_in(scene: Scene, now: State, values: Mapping[str, float], scale: float) -> Mapping[str, Array]:
        course = change.course(scene)
        return {a: signal * course for a, signal in effect.stand_in(scene, now, values, scale).items()}

    return replace(
        effect,
        name=name,
        units=units,
        columns=columns,
        begin=begin,
        wider=wider,
        stand_in=stand_in,
        terms=effect.terms if change.now else no_terms,
        orders=False,
        zeros=False,
        since=change,
        came=lambda keys: change.said,
    )


def _masked(column: Column, course: Array) -> Column:
    """A column of the later state alone."""
    tcp = None if column.tcp is None else column.tcp * course[:, None]
    servo = {a: signal * course for a, signal in column.servo.items()}
    return Column(tcp, servo, None if column.doubt is None else column.doubt * course)
