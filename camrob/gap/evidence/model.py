"""The comparison as a whole: rounds of laying out, searching, refining what is not linear, and looking at what is left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.effect import Effect, State, Unit
from camrob.gap.evidence.design import Design, Panel, build_units, make_panel, pool
from camrob.gap.evidence.evidence import Evidence, Fitted
from camrob.gap.evidence.scan import covered, gear_orders, shapes, uncovered_constants
from camrob.gap.evidence.search import explore, posterior
from camrob.gap.evidence.unknown import CONSTANT, UNKNOWN
from camrob.gap.observation.noise import Noise, find_outliers, noise_left, noise_of
from camrob.gap.observation.scene import Scene

__all__ = ["Model", "compare", "doubt_of", "effect_rms", "panels_for", "whole_gap"]

Array = NDArray[np.float64]

_ROUNDS = 7
_MOST_SHAPES = 4
_SAME_ORDER = 2e-3
_OTHER_ORDER = 0.1  # share by which a second order of an axis differs from its first
_RAW_SHARE = 0.3  # of what an axis would have to do for the whole gap: what a single order must show of it
_BLOCKS = 10  # a log
_LAGS = 40  # samples over which what is left may hang together
_STEP = 20.0  # how much less an effect's change from sample to sample is trusted than its value
_LEAST_NOISE, _LEAST_GAP = 0.5, 0.012  # of the noise and of the gap: what is unknown and less isn't worth a word


@dataclass(frozen=True)
class Model:
    """What the comparison ended with. scores: of all sets of units met; sets: probabilities of sets of effects (unknown shapes
    under "unknown"); best: posterior of the best set; excess: rms in m of what is left at the TCP beyond white noise.
    """

    effects: tuple[Effect, ...]
    states: Mapping[str, State]
    scenes: tuple[Scene, ...]
    noises: tuple[Noise, ...]
    panels: tuple[Panel, ...]
    design: Design
    evidence: Evidence
    scores: Mapping[frozenset[int], float]
    sets: Mapping[frozenset[str], float]
    best: Fitted
    excess: float
    outliers: int

    @property
    def units(self) -> tuple[Unit, ...]:
        """All units of the design."""
        return self.design.units

    @property
    def noise(self) -> float:
        """3-D rms of the noise, m."""
        return float(np.sqrt(np.mean([n.rms**2 for n in self.noises])))

    @property
    def accuracy(self) -> dict[str, float]:
        """By what share of itself the description of each effect may be wrong."""
        return {e.name: e.accuracy for e in self.effects}

    @property
    def gap(self) -> float:
        """3-D rms of the whole gap, m."""
        return float(np.sqrt(np.mean([np.mean(np.sum(whole_gap(p) ** 2, axis=1)) for p in self.panels])))

    def values(self, members: frozenset[int], fitted: Fitted) -> Array:
        """(K,) fitted values of some units, 0 elsewhere."""
        return np.where(np.isin(self.design.owner, list(members)), fitted.mean, 0.0)


def panels_for(
    scenes: Sequence[Scene], noises: Sequence[Noise], kept: Sequence[NDArray[np.bool_]], units: Sequence[Unit],
    effects: Sequence[Effect], states: Mapping[str, State],
) -> tuple[Panel, ...]:  # fmt: skip
    """Columns and weights of all logs."""
    blocks = max(2, _BLOCKS if len(scenes) < 3 else _BLOCKS // 2)
    return tuple(
        make_panel(s, k, units, effects, states, noises[k], kept[k], blocks, k * blocks) for k, s in enumerate(scenes)
    )


def compare(scenes: Sequence[Scene], library: Sequence[Effect]) -> Model:
    """Compare all sets of effects on some logs.

    The temperature falls from round to round as more is explained: at first only what explains most of the gap counts,
    so that an effect which is found late (a gear's order, an unknown shape) is not mimicked by a crowd of others.
    """
    effects = (*library, UNKNOWN)
    states: dict[str, State] = {e.name: dict(e.start) for e in effects}
    noises = tuple(noise_of(s) for s in scenes)
    kept = [~find_outliers(s, n) for s, n in zip(scenes, noises, strict=True)]
    if any(s.poses and not n.told for s, n in zip(scenes, noises, strict=True)):
        noises = _told(scenes, noises, kept, effects, states)
    noise = float(np.sqrt(np.mean([n.rms**2 for n in noises])))
    model: Model | None = None
    starts: tuple[frozenset[str], ...] = ()
    softened: tuple[Array, ...] | None = None
    for round_ in range(_ROUNDS):
        units = build_units(scenes, effects, states)
        panels = panels_for(scenes, noises, kept, units, effects, states)
        if softened is not None:
            panels = _soften(panels, softened)
        design = pool(panels, units)
        evidence = Evidence(design, noise)
        named = {_name(u): i for i, u in enumerate(units)}
        again = tuple(frozenset(named[n] for n in names if n in named) for names in starts)
        before = _best_of(evidence, again)
        heat, *others = _temperatures(panels, before.mean)
        if max(others) > heat:
            # what turns and servo errors show beyond white noise must not outweigh the positions
            panels = _cooled(panels, heat, *others)
            design = pool(panels, units)
        evidence = Evidence(design, noise, heat)
        scores, counting, best = explore(evidence, again)
        left = [p.y_tcp - p.tcp @ best.mean for p in panels]
        excess = float(np.sqrt(np.mean([_structured(p, r, design, best) for p, r in zip(panels, left, strict=True)])))
        model = Model(
            tuple(effects), dict(states), tuple(scenes), noises, panels, design, evidence, scores,
            {}, best, excess, int(sum((~k).sum() for k in kept)),
        )  # fmt: skip
        model = replace(model, sets=posterior(scores, counting, _small(model)))
        names = frozenset(_name(units[i]) for i in best.members)
        changed = _refine(model, states)
        settled = not changed and names in starts  # what is offered now was offered, and not taken
        starts = (names,)
        if round_ == 0:
            # a shape in the gap itself, before effects of the library are enlisted to mimic it
            _look(model, states, [p.y_tcp for p in panels], 1.0, raw=True)
        changed |= _look(model, states, left, heat)
        softened = _errors(model)
        if round_ > 1 and (settled or not changed):
            break
    if model is None:
        raise ValueError("at least one round is needed")
    return model


def _told(
    scenes: Sequence[Scene], noises: Sequence[Noise], kept: Sequence[NDArray[np.bool_]], effects: Sequence[Effect],
    states: Mapping[str, State],
) -> tuple[Noise, ...]:  # fmt: skip
    """The noises, with those of single poses that nobody told found from what no effect explains."""
    panels = panels_for(scenes, noises, kept, build_units(scenes, effects, states), effects, states)
    return tuple(
        n if n.told or not s.poses else noise_left(p.tcp, p.y_tcp, p.w_tcp > 0.0, n.servo, s.log.path)
        for s, n, p in zip(scenes, noises, panels, strict=True)
    )


def _small(model: Model) -> frozenset[str]:
    """Effects of the best set that move the TCP by too little to be named beside the gap, or beside what others leave."""
    least = 0.5 * _LEAST_GAP * model.gap
    sizes = {n: effect_rms(model, model.panels, n) for n in model.evidence.effects_of(model.best.members)}
    rungs = {n: _rungs_of(model, n) for n in sizes}
    # what another effect of the same rung is not described better than, it may have left
    blurred = {
        n: max((model.accuracy[m] * s for m, s in sizes.items() if m != n and rungs[m] & rungs[n]), default=0.0)
        for n in sizes
    }
    return frozenset(n for n, s in sizes.items() if s < max(least, blurred[n]))


def _rungs_of(model: Model, name: str) -> set[str]:
    """Where an effect of the best set shows in these logs: at the drives, behind the encoders, or at both."""
    c = np.flatnonzero(np.isin(model.design.owner, [i for i in model.best.members if model.units[i].effect == name]))
    found = set()
    for p in model.panels:
        found |= {"drives"} if p.servo is not None and np.isin(c, p.servo_columns).any() else set()
        found |= {"link"} if p.tcp[:, :, c].any() else set()
    return found


def effect_rms(model: Model, panels: Sequence[Panel], name: str) -> float:
    """How far an effect of the best set moves the TCP, m (rms)."""
    members = frozenset(i for i in model.best.members if model.units[i].effect == name)
    values = model.values(members, model.best)
    return float(np.sqrt(np.mean(np.concatenate([np.sum(p.moves(values) ** 2, axis=1) for p in panels]))))


def whole_gap(panel: Panel) -> Array:
    """(N, 3) m: measured less nominal at the set-points."""
    total = panel.y_tcp[:, :3]
    return total if panel.y_servo is None else total + panel.carried(panel.y_servo)


def _name(unit: Unit) -> str:
    return f"{unit.effect}/{unit.axis}/{unit.key}"


def _best_of(evidence: Evidence, starts: Sequence[frozenset[int]]) -> Fitted:
    sets = {evidence.always, *(s | evidence.always for s in starts)}
    return max((evidence.fit(s) for s in sets), key=lambda f: f.score)


def _temperatures(panels: Sequence[Panel], mean: Array) -> tuple[float, float, float]:
    """How much more the residual speaks than white noise would, in positions, turns and servo errors: its size, times the
    length over which it hangs together.
    """
    worst = [1.0, 1.0, 1.0]
    for p in panels:
        r = (p.y_tcp - p.tcp @ mean) * p.w_tcp
        parts = [(r[:, :3], p.w_tcp[:, :3]), (r[:, 3:], p.w_tcp[:, 3:])]
        if p.servo is not None and p.y_servo is not None and p.w_servo is not None:
            parts.append(((p.y_servo - p.servo @ mean[p.servo_columns]) * p.w_servo, p.w_servo))
        for k, (part, w) in enumerate(parts):
            energy, rows = float(np.sum(part**2)), float(np.count_nonzero(w))
            lagged = 0.0 if p.scene.poses else sum(float(np.sum(part[n:] * part[:-n])) for n in range(1, _LAGS))
            worst[k] = max(worst[k], (energy + 2.0 * max(lagged, 0.0)) / max(rows, 1.0))
    return worst[0], worst[1], worst[2]


def _cooled(panels: Sequence[Panel], heat: float, turned: float, servo: float) -> tuple[Panel, ...]:
    """The panels with weights of turns and servo errors lowered to the positions' temperature."""
    scale = np.sqrt(heat / np.maximum([turned, servo], heat))
    w = np.array([1.0, 1.0, 1.0, *[scale[0]] * 3])
    return tuple(
        replace(p, w_tcp=p.w_tcp * w, w_servo=None if p.w_servo is None else p.w_servo * scale[1]) for p in panels
    )


def _structured(panel: Panel, residual: Array, design: Design, best: Fitted) -> float:
    """m2: mean square at the TCP of what hangs together from sample to sample; 0 for white noise."""
    found = np.flatnonzero(np.isin(design.owner, list(best.members)))
    good = (panel.w_tcp[:, 0] > 0.0) & ~panel.unknown_rows(found)
    r = np.where(good[:, None], residual[:, :3], 0.0)
    if panel.scene.poses:
        noise = float(np.sum(1.0 / np.max(panel.w_tcp[:, :3], axis=0) ** 2))
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
    """The effect's state with the trial that leaves least unexplained, all other effects as they are fitted."""
    best, least = dict(states[effect.name]), np.inf
    members = [i for i in model.best.members if model.units[i].effect == effect.name]
    for trial in effect.trials:
        state = {**states[effect.name], **trial}
        total = 0.0
        for p in model.panels:
            columns = [c for i in members for c in effect.columns(p.scene, model.units[i], state)]
            owned = np.flatnonzero(np.isin(model.design.owner, members))
            rest = np.where(np.isin(np.arange(len(model.design.owner)), owned), 0.0, model.best.mean)
            X = np.stack([c.tcp if c.tcp is not None else np.zeros((len(p.scene), 6)) for c in columns], axis=2)
            y, w = p.y_tcp - p.tcp @ rest, p.w_tcp
            rows, right = [(X * w[..., None]).reshape(-1, X.shape[2])], [(y * w).ravel()]
            if p.servo is not None and p.y_servo is not None and p.w_servo is not None:
                S = np.zeros((len(p.scene), p.servo.shape[1], len(columns)))
                for k, c in enumerate(columns):
                    for axis, signal in c.servo.items():
                        S[:, p.scene.index(axis), k] = signal
                rows.append((S * p.w_servo[..., None]).reshape(-1, len(columns)))
                right.append(((p.y_servo - p.servo @ rest[p.servo_columns]) * p.w_servo).ravel())
            A, b = np.concatenate(rows), np.concatenate(right)
            scale = np.linalg.norm(A, axis=0) + 1e-30
            Z = A / scale
            right = Z.T @ b
            total += float(b @ b - right @ np.linalg.solve(Z.T @ Z + 1e-9 * np.eye(Z.shape[1]), right))
        if total < least:
            best, least = state, total
    return best


def _look(model: Model, states: dict[str, State], left: Sequence[Array], heat: float, *, raw: bool = False) -> bool:
    """Offer what the residual's shape suggests (raw: the whole gap's, before anything explains it); True where something was."""
    offered = False
    if "gear_ripple" in states:
        offered = _look_for_orders(model, states, left, heat, raw=raw)
    servo = [
        None if p.servo is None or p.y_servo is None else p.y_servo - p.servo @ model.best.mean[p.servo_columns]
        for p in model.panels
    ]
    inside = {u.key for i, u in enumerate(model.units) if u.effect == "unknown" and i in model.best.members}
    tried = {u.key for u in model.units if u.effect == "unknown"}
    kept = {
        k: v
        for k, v in states["unknown"].items()
        if k.rpartition("|")[0] in inside or k.rpartition("|")[0] not in tried
    }
    room = 2 if raw else _MOST_SHAPES - len(kept) // 2
    inexact = [
        model.accuracy[n] * effect_rms(model, model.panels, n)
        for n in model.evidence.effects_of(model.best.members)
        if n != UNKNOWN.name
    ]
    least = max(_LEAST_NOISE * model.noise, _LEAST_GAP * model.gap, 0.0 if raw else 2.0 * max(inexact, default=0.0))
    found = shapes(model.panels, left, servo, heat, least)[: 2 * _MOST_SHAPES]
    for shape in [s for s in found if not covered(s, model.panels, model.design)][: max(room, 0)]:
        key = f"{shape.target}|{shape.quantity}"
        if f"{key}|lower" not in states["unknown"]:
            offered = True
        kept[f"{key}|lower"], kept[f"{key}|upper"] = shape.lower, shape.upper
    for place in uncovered_constants(model.panels, model.design) if raw else ():
        kept[f"{place}|{CONSTANT}|lower"] = kept[f"{place}|{CONSTANT}|upper"] = 0.0
        offered = True
    states["unknown"] = kept
    return offered


def _look_for_orders(model: Model, states: dict[str, State], left: Sequence[Array], heat: float, *, raw: bool) -> bool:
    """Offer the gears' orders that the residual shows, what is unknown and ripples themselves put back, then further ones of
    the same axes; True where any is new.
    """
    own = {i: u for i, u in enumerate(model.units) if u.effect == "gear_ripple"}
    inside = {u.key for i, u in own.items() if i in model.best.members}
    tried = {u.key for u in own.values()}
    orders = {k: v for k, v in states["gear_ripple"].items() if k in inside or k not in tried}
    smooth = frozenset([*own, *(i for i, u in enumerate(model.units) if u.effect == UNKNOWN.name)])
    back = [
        r if raw else r + p.tcp @ model.values(smooth & model.best.members, model.best)
        for r, p in zip(left, model.panels, strict=True)
    ]
    found = gear_orders(model.panels, back, heat, _RAW_SHARE if raw else 0.0)
    if not raw:
        for key, order in gear_orders(model.panels, left, heat).items():
            if key in inside and abs(found.get(key, order) - order) > _OTHER_ORDER * order:
                found[f"{key}_2"] = order
    offered = False
    for key, order in found.items():
        if key not in orders or abs(orders[key] - order) > _SAME_ORDER * order:
            orders[key] = order
            offered = True
    states["gear_ripple"] = orders
    return offered


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
            own = p.doubted(c, share[c[0]])
            variance[:, :6] += doubt_of(p.tcp[:, :, c] @ model.best.mean[c], own)
            if p.servo is not None:
                served = np.isin(p.servo_columns, c)
                variance[:, 6:] += doubt_of(p.servo[:, :, served] @ model.best.mean[p.servo_columns[served]], own)
        out.append(variance)
    return tuple(out)


def doubt_of(part: Array, share: Array) -> Array:
    """Variance of an effect's part (N, d): a share (N, 1) of itself, and more where it changes between two samples."""
    step = np.zeros_like(part)
    change = np.abs(np.diff(part, axis=0))
    step[1:] = change
    step[:-1] = np.maximum(step[:-1], change)
    return np.asarray((share * part) ** 2 + (_STEP * share * step) ** 2)


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
