"""Whether fitted values can be true, how far they stand out of what the fit leaves open, and what the unexplained looks like, in
words.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.gap.evidence.model import Model, members_of, seen_moves, seen_rms
from camrob.gap.evidence.unknown import CONSTANT, LINK, basis, followed, is_broad, is_moment, moment_words, parts_of
from camrob.gap.verdict.alike.companions import only_companions
from camrob.gap.verdict.belief import BELIEF
from camrob.summaries.diagnosis_summary import UnknownShape
from camrob.units import m_to_mm, rad_to_deg

__all__ = [
    "doubted_unless_clear",
    "held_to_values",
    "implausible",
    "squares",
    "unknown_shapes",
    "unknown_text",
    "unusual",
]

_SIGMAS = 4.0  # of the fit, that a value may be beyond its range by chance
_RANK = 1e-9  # of the largest singular value of covariances
_PLACES = {"foot": "the robot's foot", "tool": "the tool"}
_PART = 0.1  # of what several axes do at once: an axis with less has no part in it


def implausible(model: Model) -> dict[str, str]:
    """Effect to the reason, for effects of the best set with values beyond what any such machine can have, or of which nothing
    shows but what comes with them.
    """
    found = only_companions(model)
    deviation = np.sqrt(np.maximum(np.diag(model.best.cov), 0.0))
    for k, (parameter, owner) in enumerate(zip(model.design.parameters, model.design.owner, strict=True)):
        unit = model.units[int(owner)]
        if int(owner) not in model.best.members or unit.effect == "unknown":
            continue
        value, slack = float(model.best.mean[k]), _SIGMAS * float(deviation[k])
        moves = abs(value) * float(model.design.size[k])
        if moves < 0.3 * model.noise:
            continue
        if value + slack < parameter.lower or value - slack > parameter.upper:
            low, high = parameter.at_edge(parameter.lower), parameter.at_edge(parameter.upper)
            found[unit.effect] = (
                f"{parameter.name} is {parameter.at_edge(value):.3g} where {low:.3g} to {high:.3g} is plausible"
            )
    return found


def unusual(model: Model) -> dict[str, str]:
    """Effect to the reason, for effects of the best set with values that such a robot may have and seldom has."""
    found: dict[str, str] = {}
    deviation = np.sqrt(np.maximum(np.diag(model.best.cov), 0.0))
    for k, (parameter, owner) in enumerate(zip(model.design.parameters, model.design.owner, strict=True)):
        size = abs(float(model.best.mean[k]))
        if int(owner) in model.best.members and size - _SIGMAS * float(deviation[k]) > parameter.common:
            value, common = parameter.at_edge(float(model.best.mean[k])), parameter.at_edge(parameter.common)
            found[model.units[int(owner)].effect] = (
                f"{parameter.name} is {value:.3g}, where {common:.3g} is already a lot"
            )
    return found


def held_to_values(model: Model, probability: Mapping[str, float]) -> dict[str, float]:
    """Probabilities of effects, of which none is nearly sure whose values don't stand out: several of its parameters then share
    what one of another cause does, or the discrepancy may as well be it.
    """
    sure = model.evidence.effects_of(model.best.members).intersection(
        n for n, p in probability.items() if p > BELIEF.likely
    )
    return {**probability, **{n: BELIEF.likely for n in sure if squares(model, n) < BELIEF.stands_out}}


def doubted_unless_clear(model: Model, probability: Mapping[str, float]) -> dict[str, float]:
    """Probabilities of effects, of which one is in doubt that is as likely as not and whose values don't stand out: what takes
    less than half of what it moves, of whose values little is known, is a leftover's likeness.
    """
    asked = model.evidence.effects_of(model.best.members).intersection(
        n for n, p in probability.items() if 0.5 <= p <= BELIEF.takes_less
    )
    return {**probability, **{n: BELIEF.unclear for n in asked if squares(model, n) < BELIEF.stands_out}}


def squares(model: Model, name: str) -> float:
    """Of an effect of the best set: the square of its fitted values in standard errors beside the discrepancy, as these hang
    together, a parameter.
    """
    own = np.flatnonzero([model.units[o].effect == name and o in model.best.members for o in model.design.owner])
    spread = np.sqrt(np.maximum(model.best.cov[own, own], 1e-300))
    values = model.best.mean[own] / spread
    solved = np.linalg.lstsq(model.best.cov[np.ix_(own, own)] / np.outer(spread, spread), values, rcond=_RANK)[0]
    return float(values @ solved) / len(own)


def unknown_shapes(model: Model) -> list[UnknownShape]:
    """The unexplained, shape by shape: its stage, what moves, what that follows and how far it swings, in `unit`; those first
    that move the TCP most. What is as broad as an effect is said axis by axis.
    """
    shapes: list[UnknownShape] = []
    for i in sorted(members_of(model, "unknown"), key=lambda i: (-_energy(model, i), i)):
        shapes += _of_broad(model, i) if is_broad(model.units[i].key) else [_of_one(model, i)]
    return shapes


def _of_one(model: Model, i: int) -> UnknownShape:
    """What one place does."""
    unit = model.units[i]
    target, _, quantity = unit.key.partition("|")
    state = model.states["unknown"]
    columns = np.flatnonzero(model.design.owner == i)
    lower, upper = (state[f"{unit.key}|{end}"] for end in ("lower", "upper"))
    if quantity == CONSTANT:
        swing = float(np.linalg.norm(model.best.mean[columns[:3]]))
    else:
        bases = [basis(followed(p.scene, quantity, lower), lower, upper, quantity) for p in model.panels]
        swing = float(np.ptp(np.concatenate([X @ model.best.mean[columns[1:]] for X in bases])))
    linear = unit.parameters[0].unit == "mm"
    return UnknownShape(
        stage="setpoint_to_encoder" if target.startswith("drive") else "encoder_to_tcp",
        moves=_PLACES.get(target, target.removeprefix("drive ").removeprefix(LINK)),
        follows=moment_words(quantity, lower) if is_moment(quantity) else quantity,
        swing=m_to_mm(swing) if linear else rad_to_deg(swing),
        unit="mm" if linear else "degrees",
    )


def _of_broad(model: Model, i: int) -> list[UnknownShape]:
    """What several axes do at once, each that has a part in it, by how far that moves the TCP at the most."""
    columns, key = np.flatnonzero(model.design.owner == i), model.units[i].key
    parts = np.array(parts_of(key, model.panels[0].scene))
    moved = {
        part: np.concatenate(seen_moves(model, model.panels, _only(model, columns[parts == part])))
        for part in dict.fromkeys(parts.tolist())
    }
    energy = {part: float(np.sum(m**2)) for part, m in moved.items()}
    largest = sorted((p for p in energy if energy[p] > _PART * sum(energy.values())), key=lambda p: -energy[p])
    return [
        UnknownShape(
            stage="encoder_to_tcp",
            moves=_PLACES.get(part, part),
            follows=key.partition("|")[2],
            swing=m_to_mm(float(np.linalg.norm(moved[part], axis=1).max())),
            unit="mm",
        )
        for part in largest
    ]


def _only(model: Model, columns: NDArray[np.int64]) -> NDArray[np.float64]:
    """(K,) fitted values of some columns, 0 elsewhere."""
    values = np.zeros(len(model.best.mean))
    values[columns] = model.best.mean[columns]
    return values


def _energy(model: Model, unit: int) -> float:
    """m2, summed over all samples, by which a unit of the best set moves the TCP."""
    values = model.values(frozenset([unit]), model.best)
    return sum(float(np.sum(p.moves(values) ** 2)) for p in model.panels)


def unknown_text(model: Model, shapes: Sequence[UnknownShape]) -> str:
    """The shapes of the unexplained in words, with their size at the TCP; "" where there are none."""
    if not shapes:
        return ""
    between = {"setpoint_to_encoder": "between set-point and encoder", "encoder_to_tcp": "between encoder and TCP"}
    parts = [f"{between[s.stage]}, {_moved(s)}" for s in shapes]
    rms = m_to_mm(seen_rms(model, model.panels, "unknown"))
    return "; ".join(parts) + f" ({rms:.3f} mm rms at the TCP)"


def _moved(shape: UnknownShape) -> str:
    size = f"{shape.swing:.3g} {shape.unit}"
    if is_moment(shape.follows):
        return f"{shape.moves} is off by {size} {shape.follows}"
    if shape.follows != CONSTANT:
        return f"{shape.moves} moves by {size} as a smooth function of {shape.follows}"
    return f"{shape.moves} is off by a constant {size}"
