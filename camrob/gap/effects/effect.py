"""What an effect of the library is: its physics, its parameters, and how a unit of each would show in a log."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from camrob.gap.observation.scene import Scene
from camrob.gap.states.change import Change
from camrob.summaries.fitted.since import Since
from camrob.units import m_to_mm, rad_to_deg

__all__ = [
    "Column",
    "Effect",
    "EffectParameter",
    "State",
    "Unit",
    "all_seen",
    "no_beginning",
    "no_refinement",
    "no_stand_in",
    "no_terms",
    "none_likewise",
    "not_since",
    "not_wider",
]

Array = NDArray[np.float64]
State = Mapping[str, float]
"""Values in which an effect is not linear, by name (a time constant, the width of a play), as last refined."""

_EDGE = {"mm": m_to_mm, "deg": rad_to_deg}


@dataclass(frozen=True, slots=True)
class EffectParameter:
    """One parameter, SI. unit: that of the trade it is reported in. usual: its ordinary size; lower, upper: what a machine can
    have at all; common: the magnitude beyond which a value is unusual, which is said and counts for nothing else; beside: it
    comes with the others of its effect, and alone is no sign of it, as other causes show the same.
    """

    name: str
    unit: str
    usual: float
    lower: float
    upper: float
    common: float = float("inf")
    beside: bool = False

    def at_edge(self, value: float) -> float:
        """The value in the unit of the trade."""
        convert = _EDGE.get(self.unit)
        return value if convert is None else float(convert(value))


@dataclass(frozen=True, slots=True)
class Unit:
    """What is in or out as a whole: an effect, or its share in one axis. choices: how many such could have been picked."""

    effect: str
    axis: str
    parameters: tuple[EffectParameter, ...]
    choices: int = 1
    key: str = ""


@dataclass(frozen=True, slots=True)
class Column:
    """How a unit of one parameter shows: tcp (N, 6) a twist behind the encoders; servo: signals (N,) by axis, encoder beyond
    set-point. doubt: (N,) share of itself by which this may be wrong at each sample, where that is more than the effect's
    `accuracy`; 1 or more where nothing is known; None for nowhere.
    """

    tcp: Array | None = None
    servo: Mapping[str, Array] = field(default_factory=dict)
    doubt: Array | None = None


Units = Callable[[Sequence[Scene], State], tuple[Unit, ...]]
Columns = Callable[[Scene, Unit, State], tuple[Column, ...]]
Terms = Callable[[Unit, State], tuple[str, ...]]
Begin = Callable[[Sequence[Scene]], State]
Refine = Callable[[State, Mapping[str, float]], dict[str, float]]
Seen = Callable[[Sequence[Scene], Unit, State], bool]
Wider = Callable[[Scene, State], tuple[Column, ...]]
StandIn = Callable[[Scene, State, Mapping[str, float], float], Mapping[str, Array]]
Likewise = Callable[[Sequence[Scene]], tuple[str, ...]]
Came = Callable[[Sequence[str]], Since | None]
Accuses = Callable[[Mapping[str, float], Sequence[str], Sequence[str]], str]


def no_beginning(scenes: Sequence[Scene]) -> State:
    """An effect of which logs say nothing before it is fitted."""
    return {}


def no_refinement(state: State, values: Mapping[str, float]) -> dict[str, float]:
    """The state of an effect that is linear in all its parameters."""
    return dict(state)


def all_seen(scenes: Sequence[Scene], unit: Unit, state: State) -> bool:
    """An effect whose pattern is a whole on any log that shows it."""
    return True


def not_wider(scene: Scene, state: State) -> tuple[Column, ...]:
    """An effect that machines have as it is described."""
    return ()


def none_likewise(scenes: Sequence[Scene]) -> tuple[str, ...]:
    """An effect that is told from any other by its pattern alone."""
    return ()


def no_stand_in(scene: Scene, state: State, values: Mapping[str, float], scale: float) -> Mapping[str, Array]:
    """An effect of which no other is the limit."""
    return {}


def not_since(keys: Sequence[str]) -> Since | None:
    """An effect that was always there."""
    return None


def no_terms(unit: Unit, state: State) -> tuple[str, ...]:
    """An effect that no error parameter of the calibrated chain describes: it can't be handed to `compensate`."""
    return ()


@dataclass(frozen=True, slots=True)
class Effect:
    """An effect.

    physics: what happens, in a sentence. stages: where between program and TCP it can show. regimes: what it depends on.
    experiment: the motion that would isolate it. remedy: what a person does about it, "" where nobody has said; odd_axis: what
    about "{axis}", where it does far more of it than its like, or about what has no axis, where it does; "" for the same. units:
    what may be in or out on these logs, none where it can't show. columns: one a parameter. start: the state before anything is
    known, and begin: what the logs themselves say of it; refine: the next state from fitted values, by parameter name; trials:
    changes of the state to choose among by what they leave unexplained. accuracy: by what share of itself the description may
    be wrong. terms: the names of a unit's parameters in the one error model (`calibrate.terms`) that calibrate, compensate and
    diagnose share, in their order; () where it can't be said there. compensable: it has such, for `compensate` to correct it.

    Traits that the engine asks for, instead of names. orders: its state holds orders of gears, which a residual suggests.
    zeros: its state holds axes' zeros, which a log may show to be lost by degrees. twin_in_world: the effect that shows the
    same where the measured frame is `world`. hidden_in_world: it is the other one of such a pair, and not looked for there.
    of_instrument: what it says of the instrument, for a person, from its values by parameter, from what these logs can't
    tell it from, and from its units' keys. of_machine: False where the tool is not elsewhere, only its reading. whole: logs show
    all of a unit's pattern; a part of a period is any smooth function, so that its name is no more than likely. at_reversals:
    its axis jumps where it turns round, by the sum of a unit's values to either side, and stands off by the first one between.
    wider: what machines that have it may do beyond the description (a drive of second order), as columns of which there is a
    share of 0 to 1 at the most; a far smaller name that these show as well is one of a class with it. likewise: names that
    these logs can't tell from it, as their cell or their columns lack what would; it is no more than likely then.
    stand_in: how the drives would stand, as its columns do, by axis, were another effect there instead (`stands_in`, by name), as
    much by `scale` times its fitted values by parameter; NaN where nothing is known. Where that leaves as little, these logs
    can't tell the two apart. since: when it came to work, None for always; came: the same of units by their keys. side: "left" or
    "right" of what was measured, where it is a rigid motion of all of it.
    """

    name: str
    physics: str
    stages: tuple[str, ...]
    regimes: tuple[str, ...]
    experiment: str
    units: Units
    columns: Columns
    start: State = field(default_factory=dict)
    begin: Begin = no_beginning
    refine: Refine = no_refinement
    trials: tuple[State, ...] = ()
    accuracy: float = 0.01
    terms: Terms = no_terms
    orders: bool = False
    zeros: bool = False
    twin_in_world: str = ""
    hidden_in_world: bool = False
    of_instrument: Accuses | None = None
    whole: Seen = all_seen
    of_machine: bool = True
    at_reversals: bool = False
    wider: Wider = not_wider
    remedy: str = ""
    odd_axis: str = ""
    likewise: Likewise = none_likewise
    stand_in: StandIn = no_stand_in
    stands_in: str = ""
    since: Change | None = None
    came: Came = not_since
    side: str = ""

    @property
    def in_gears(self) -> bool:
        """True where it is what a gear does: it follows an axis's direction alone, behind its encoder."""
        return self.stages == ("encoder_to_tcp",) and self.regimes == ("direction",)

    @property
    def compensable(self) -> bool:
        """True where at least a part of it can be handed to `compensate`."""
        return self.terms is not no_terms
