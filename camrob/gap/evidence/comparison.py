"""The comparison as a whole: rounds of laying out, searching, refining what is not linear, and looking at what is left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.effect import Column, Effect, State, Unit
from camrob.gap.evidence.design import Design, Panel, Remembered, build_units, make_panel, pool
from camrob.gap.evidence.discrepancy import PARTS, SmoothBasis, smooth_basis
from camrob.gap.evidence.evidence import Evidence, Fitted
from camrob.gap.evidence.field_size import fit_sizes, no_sizes, over_sizes, row_noise
from camrob.gap.evidence.leads import look
from camrob.gap.evidence.model import Model, doubt_of, effect_rms, members_of
from camrob.gap.evidence.search import Explored, explore, posterior, worth_counting
from camrob.gap.evidence.temperature import cooled, lowered, temperatures
from camrob.gap.evidence.unknown import UNKNOWN
from camrob.gap.observation.noise import Noise, find_outliers, noise_left, noise_of
from camrob.gap.observation.scene import Scene

__all__ = ["compare", "excess_beside", "panels_for", "too_small", "unit_name"]

Array = NDArray[np.float64]

_ROUNDS = 7  # at the most: a round that changes nothing is the last
_BLOCKS = 10  # a log
_SIZINGS = 3  # times that the discrepancy's size and the temperature, which depend on each other, are found in turn
_SAME_HEAT = 1.2  # times it, another temperature is as good as it
_LESS, _SMALLER = 0.3, 3  # of the discrepancy's size, and how often, at which sets are explored too
_LEAST_GAP = 0.012  # of the gap: what is less isn't worth a word
# of the discrepancy: what moves the TCP by less can't be told from a field that is described a little wrong
_BESIDE = 0.2
_SHOWS = 12.0  # squares, in those of a row as it is left, that a trial has to take beyond one of nothing but zeros


def panels_for(
    scenes: Sequence[Scene],
    noises: Sequence[Noise],
    kept: Sequence[NDArray[np.bool_]],
    units: Sequence[Unit],
    effects: Sequence[Effect],
    states: Mapping[str, State],
    basis: SmoothBasis | None = None,
    remembered: Remembered | None = None,
) -> tuple[Panel, ...]:
    """Columns and weights of all logs."""
    blocks = max(2, _BLOCKS if len(scenes) < 3 else _BLOCKS // 2)
    return tuple(
        make_panel(s, k, units, effects, states, noises[k], kept[k], blocks, k * blocks, basis, remembered)
        for k, s in enumerate(scenes)
    )


def compare(scenes: Sequence[Scene], library: Sequence[Effect], start: frozenset[str] = frozenset()) -> Model:
    """Compare all sets of effects on some logs, a smooth discrepancy of any size beside each. start: a set to begin from beside
    the empty one, by the names of its units.

    Round by round: the discrepancy is sized beside the best set so far, which at first leaves it all of the gap; sets are
    searched with it integrated out; what is not linear is refined, and what is left suggests further shapes.
    """
    effects = (*library, UNKNOWN)
    states: dict[str, State] = {e.name: {**e.start, **e.begin(scenes)} for e in effects}
    noises = tuple(noise_of(s) for s in scenes)
    kept = [~find_outliers(s, n) for s, n in zip(scenes, noises, strict=True)]
    if any(s.poses and not n.stated for s, n in zip(scenes, noises, strict=True)):
        noises = _with_shown_noise(scenes, noises, kept, effects, states)
    model: Model | None = None
    found: Explored | None = None
    starts: tuple[frozenset[str], ...] = (start,) if start else ()
    softened: tuple[Array, ...] | None = None
    basis, sizes, remembered = smooth_basis(scenes), no_sizes(), Remembered()
    for round_ in range(_ROUNDS):
        remembered.turn()
        units = build_units(scenes, effects, states)
        panels = panels_for(scenes, noises, kept, units, effects, states, basis, remembered)
        if softened is not None:
            panels = _soften(panels, softened)
        named = {unit_name(u): i for i, u in enumerate(units)}
        again = tuple(frozenset(named[n] for n in names if n in named) for names in starts)
        # what turns with direction, or drifts, is first offered to effects that do
        panels, evidence = _weighed(panels, units, basis, noises, sizes, again, PARTS if round_ else PARTS[:1])
        found = _explored(evidence, again)
        evidence, best = found.evidence, found.best
        design, sizes = evidence.design, _sizes_of(evidence)
        left = [p.y_tcp - p.twists(best.mean) for p in panels]
        excess = excess_beside(panels, evidence, best, left)
        model = Model(
            tuple(effects),
            dict(states),
            tuple(scenes),
            noises,
            panels,
            design,
            evidence,
            {},
            {},
            best,
            excess,
            int(sum((~k).sum() for k in kept)),
            basis,
        )
        names = frozenset(unit_name(units[i]) for i in best.members)
        changed = _refine(model, states)
        settled = not changed and names in starts  # what is offered now was offered, and not taken
        starts = (names,)
        if round_ == 0:
            # a shape in the gap itself, before effects of the library are enlisted to mimic it
            look(model, states, [p.y_tcp for p in panels], raw=True)
        changed |= look(model, states, left)
        softened = _errors(model)
        if round_ > 1 and (settled or not changed):
            break
    if model is None or found is None:
        raise ValueError("at least one round is needed")
    scores = over_sizes(model.evidence, found.scores, row_noise(noises))
    return replace(
        model, scores=scores, sets=posterior(scores, worth_counting(scores, found.counting), too_small(model))
    )


def _weighed(
    panels: tuple[Panel, ...],
    units: Sequence[Unit],
    basis: SmoothBasis,
    noises: Sequence[Noise],
    sizes: Array,
    starts: Sequence[frozenset[int]],
    parts: Sequence[str],
) -> tuple[tuple[Panel, ...], Evidence]:
    """The panels, and the evidence with the discrepancy's sizes and a temperature that suit the best of some sets. parts: of the
    discrepancy that may be there.
    """
    noise = float(np.sqrt(np.mean([n.rms**2 for n in noises])))
    pooled = pool(panels, units, basis)
    design = pooled.design()
    heat, weighed = 1.0, panels
    for _ in range(_SIZINGS):
        evidence = Evidence(design, noise, heat, sizes=sizes)
        sizes = fit_sizes(evidence, _best_of(evidence, starts), sizes, row_noise(noises), parts)
        evidence = Evidence(design, noise, heat, sizes=sizes)
        before = _best_of(evidence, starts)
        weights = (
            np.zeros((len(basis.part), 6)) if evidence.field is None else evidence.field.fitted(before.mean, sizes)
        )
        found, *others = temperatures(panels, before.mean, weights)
        if max(others) > found:
            # what turns and servo errors show beyond white noise must not outweigh the positions
            factors = lowered(found, *others)
            weighed, design = cooled(panels, *factors), pooled.design(*factors)
        settled, heat = found < _SAME_HEAT * heat, found
        if settled:
            break
    return weighed, Evidence(design, noise, heat, sizes=sizes)


def _explored(evidence: Evidence, starts: tuple[frozenset[int], ...]) -> Explored:
    """Sets explored with the discrepancy at its size, and as long as a better one turns up so, with less of it: what takes the
    discrepancy's place is worth more than it saves while the discrepancy stays as large.
    """
    found = explore(evidence, starts)
    shapes = frozenset(i for i, u in enumerate(evidence.design.units) if u.effect == UNKNOWN.name)
    for _ in range(_SMALLER if _sizes_of(evidence).any() else 0):
        less = replace(found.evidence, sizes=_LESS * _sizes_of(found.evidence))
        other = explore(less, (*starts, found.best.members, *([shapes] if shapes else [])))
        if other.best.score <= found.best.score:
            break
        found = other
    return found


def _sizes_of(evidence: Evidence) -> Array:
    return no_sizes() if evidence.sizes is None else evidence.sizes


def excess_beside(panels: Sequence[Panel], evidence: Evidence, best: Fitted, left: Sequence[Array]) -> float:
    """m: rms at the TCP of what hangs together beyond the best set, which leaves `left` (N, 6) a log, and the discrepancy."""
    sizes = _sizes_of(evidence)
    weights = None if evidence.field is None else evidence.field.fitted(best.mean, sizes)
    parts = []
    for p, rest in zip(panels, left, strict=True):
        smooth = 0.0 if weights is None or p.smooth is None else p.smooth @ weights
        parts.append(_structured(p, rest - smooth, evidence.design, best))
    return float(np.sqrt(np.mean(parts)))


def _with_shown_noise(
    scenes: Sequence[Scene],
    noises: Sequence[Noise],
    kept: Sequence[NDArray[np.bool_]],
    effects: Sequence[Effect],
    states: Mapping[str, State],
) -> tuple[Noise, ...]:
    """The noises, with those of single poses where it is not stated found from what no effect explains."""
    panels = panels_for(scenes, noises, kept, build_units(scenes, effects, states), effects, states)
    return tuple(
        n if n.stated or not s.poses else noise_left(p.tcp, p.y_tcp, p.w_tcp > 0.0, n.servo, s.log.path, s.share)
        for s, n, p in zip(scenes, noises, panels, strict=True)
    )


def too_small(model: Model) -> frozenset[str]:
    """Effects of the best set that move the TCP by too little to be named beside the gap, or beside what others leave."""
    least = max(0.5 * _LEAST_GAP * model.gap, _BESIDE * model.discrepancy)
    sizes = {n: effect_rms(model, model.panels, n) for n in model.evidence.effects_of(model.best.members)}
    stages = {n: _stages_of(model, n) for n in sizes}
    # what another effect of the same stage is not described better than, it may have left
    blurred = {
        n: max((model.accuracy[m] * s for m, s in sizes.items() if m != n and stages[m] & stages[n]), default=0.0)
        for n in sizes
    }
    return frozenset(n for n, s in sizes.items() if s < max(least, blurred[n]))


def _stages_of(model: Model, name: str) -> set[str]:
    """Where an effect of the best set shows in these logs: at the drives, behind the encoders, or at both."""
    c = np.flatnonzero(np.isin(model.design.owner, list(members_of(model, name))))
    found = set()
    for p in model.panels:
        found |= {"drives"} if p.servo is not None and np.isin(c, p.servo_columns).any() else set()
        found |= {"link"} if p.tcp[:, :, c].any() else set()
    return found


def unit_name(unit: Unit) -> str:
    """By which a unit is known from round to round."""
    return f"{unit.effect}/{unit.axis}/{unit.key}"


def _best_of(evidence: Evidence, starts: Sequence[frozenset[int]]) -> Fitted:
    sets = {evidence.always, *(s | evidence.always for s in starts)}
    return max((evidence.fit(s) for s in sets), key=lambda f: f.score)


def _structured(panel: Panel, residual: Array, design: Design, best: Fitted) -> float:
    """m2: mean square at the TCP of what hangs together from sample to sample; 0 for white noise."""
    found = np.flatnonzero(np.isin(design.owner, list(best.members)))
    good = (panel.w_tcp[:, 0] > 0.0) & ~panel.unknown_rows(found)
    r = np.where(good[:, None], residual[:, :3], 0.0)
    if panel.scene.poses:
        noise = panel.scene.share * float(np.sum(1.0 / np.max(panel.w_tcp[:, :3], axis=0) ** 2))
        return max(0.0, float(np.sum(r**2) / max(good.sum(), 1)) - noise)
    parts = [np.sum(r[k:] * r[:-k], axis=1).mean() for k in (1, 2, 3) if len(r) > 3 * k]
    return max(0.0, float(np.mean(parts))) if parts else 0.0


def _refine(model: Model, states: dict[str, State]) -> bool:
    """Move the states of nonlinear effects to where the fit says; True where any moved much."""
    fitted: dict[str, dict[str, float]] = {}
    for parameter, owner, value in zip(model.design.parameters, model.design.owner, model.best.mean, strict=True):
        if int(owner) in model.best.members:
            fitted.setdefault(model.units[owner].effect, {})[parameter.name] = float(value)
    moved = False
    for effect in model.effects:
        if effect.name in fitted:
            old = dict(states[effect.name])
            states[effect.name] = effect.refine(old, fitted[effect.name])
            new = _tried(model, effect, states)
            moved |= any(abs(v - old.get(k, 0.0)) > 0.01 * abs(v) for k, v in new.items())
            states[effect.name] = new
    return moved


def _tried(model: Model, effect: Effect, states: Mapping[str, State]) -> State:
    """The effect's state with the trial that leaves least unexplained, all other effects as they are fitted. What a trial adds to
    one of nothing but zeros has to show clearly: steps of a drive's cycle don't in rows every tenth of a second.
    """
    best, least = dict(states[effect.name]), np.inf
    members = sorted(members_of(model, effect.name))
    owned = np.isin(model.design.owner, members)
    rest = np.where(owned, 0.0, model.best.mean)
    left = [_left_beside(p, rest) for p in model.panels] if effect.trials else []
    for trial in effect.trials:
        state = {**states[effect.name], **trial}
        total = 0.0
        for p, y in zip(model.panels, left, strict=True):
            columns = [c for i in members for c in effect.columns(p.scene, model.units[i], state)]
            A, b = _rows_of(p, columns), y
            scale = np.linalg.norm(A, axis=1) + 1e-30
            Z = A / scale[:, None]
            right = Z @ b
            total += float(b @ b - right @ np.linalg.solve(Z @ Z.T + 1e-9 * np.eye(len(Z)), right))
        if total < least:
            rows = sum(int(np.count_nonzero(y)) for y in left)
            best, least = state, total - (0.0 if any(trial.values()) else _SHOWS * max(1.0, total / max(rows, 1)))
    return best


def _left_beside(p: Panel, values: Array) -> Array:
    """(M,) weighed equations of a log without what values (K,) explain, in the order of `_rows_of`."""
    parts = [(p.y_tcp - p.twists(values)) * p.w_tcp]
    if p.servo is not None and p.y_servo is not None and p.w_servo is not None:
        parts.append((p.y_servo - p.errors(values)) * p.w_servo)
    return np.concatenate([x.T.ravel() for x in parts])


def _rows_of(p: Panel, columns: Sequence[Column]) -> Array:
    """(C, M): each column's weighed part of a log's equations."""
    drives = 0 if p.w_servo is None else p.w_servo.shape[1]
    out = np.zeros((len(columns), 6 + drives, len(p.scene)))
    for own, c in zip(out, columns, strict=True):
        if c.tcp is not None:
            own[:6] = (c.tcp * p.w_tcp).T
        if p.w_servo is not None:
            for axis, signal in c.servo.items():
                k = p.scene.index(axis)
                own[6 + k] = signal * p.w_servo[:, k]
    return out.reshape(len(columns), -1)


def _errors(model: Model) -> tuple[Array, ...]:
    """(N, 6 + k) a panel: how far the descriptions of the effects found may be wrong themselves, squared."""
    share = np.array([model.accuracy.get(model.units[o].effect, 0.0) for o in model.design.owner])
    out = []
    for p in model.panels:
        variance = np.zeros((len(p.scene), 6 + (0 if p.servo is None else p.servo.shape[1])))
        for i in model.best.members:
            c = np.flatnonzero(model.design.owner == i)
            if share[c[0]] <= 0.0:
                continue
            own, values = p.doubted(c, share[c[0]]), model.values(frozenset([i]), model.best)
            variance[:, :6] += doubt_of(p.twists(values), own, poses=p.scene.poses)
            if p.servo is not None and values[p.servo_columns].any():
                variance[:, 6:] += doubt_of(p.errors(values), own, poses=p.scene.poses)
        out.append(variance)
    return tuple(out)


def _soften(panels: Sequence[Panel], errors: Sequence[Array]) -> tuple[Panel, ...]:
    """The panels with weights that allow for the effects' own inaccuracy."""
    out = []
    for p, variance in zip(panels, errors, strict=True):
        w_tcp = p.w_tcp / np.sqrt(1.0 + p.w_tcp**2 * variance[:, :6])
        w_servo = p.w_servo
        if w_servo is not None:
            w_servo = w_servo / np.sqrt(1.0 + w_servo**2 * variance[:, 6:])
        out.append(replace(p, w_tcp=w_tcp, w_servo=w_servo))
    return tuple(out)
