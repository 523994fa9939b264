"""What ordinary selection makes of the same cases: `python tests/bench/gap/baselines.py --of DIR --out OUT`.

Of every case that DIR (several may be given) has an answer for, the logs are made again from its seed and given to two baselines,
whose answers go through the same scorer as the diagnosis's; OUT/baselines.md is the table. Both get what is dear to make: the
library's own columns, the noise, rows without outliers, states refined from their own fit (time constants, orders of gears) in
three rounds. What they lack is what the diagnosis adds: priors, sizes that count, a discrepancy, withheld samples.

- stepwise: units are added and dropped one by one while the Bayesian information criterion falls (Schwarz 1978), with the noise
  as it is found; sets that were met weigh exp(- BIC / 2).
- lasso: stability selection (Meinshausen and Buehlmann 2010): the first columns that enter the lasso's path (by least angles,
  Efron et al. 2004) on fifty drawn halves of the blocks; an effect is as probable as it is often among them.

Settings are the best of a few on cases of seeds from 40000 on, by effects found less names that are wrong.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

from gap.benchmark import CELL, make, read_lines
from gap.report import percent
from gap.score import rows_of, score

ROUNDS, DRAWS, MOST_SETS = 3, 50, 40
OUTSIDE = "outside the library"
# penalty: times log(n) a parameter; loud: times the noise from which what is left is said to hold something unknown; first:
# columns of a path that count; often: share of halves from which a unit is kept
SETTINGS = {"penalty": 4.0, "loud": 1.5, "first": 4, "often": 0.6}
RIDGE = 1e-9  # of a column's energy


@dataclass
class Problem:
    """A case laid out: whitened Gram matrices by block, and what an answer is made of. rows: independent numbers."""

    units: Sequence
    owner: np.ndarray
    A: np.ndarray
    b: np.ndarray
    yy: float
    rows: float
    panels: Sequence
    scenes: Sequence
    effects: Sequence
    states: dict
    noise: float

    @property
    def names(self) -> list[str]:
        return [u.effect for u in self.units]

    def columns(self, members) -> np.ndarray:
        return np.flatnonzero(np.isin(self.owner, list(members)))


def laid_out(scenes, effects, states) -> Problem:
    """Columns of all effects in their states, on some logs."""
    from camrob.gap.evidence.comparison import panels_for
    from camrob.gap.evidence.design import build_units, pool
    from camrob.gap.observation.noise import find_outliers, noise_of

    noises = [noise_of(s) for s in scenes]
    kept = [~find_outliers(s, n) for s, n in zip(scenes, noises, strict=True)]
    units = build_units(scenes, effects, states)
    panels = panels_for(scenes, noises, kept, units, effects, states)
    d = pool(panels, units).design()
    scale = 1.0 / np.sqrt(np.maximum(np.einsum("bkk->k", d.A), 1e-30))
    A, b = d.A * np.outer(scale, scale), d.b * scale
    return Problem(
        units, d.owner, A, b, float(d.yy.sum()), float(d.rows.sum()), panels, scenes, effects, states, noises[0].rms
    )


def solved(A: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.linalg.solve(A + RIDGE * np.eye(len(A)), b) if len(A) else np.zeros(0)


def stepwise(p: Problem, settings: Mapping) -> tuple[frozenset[int], dict[frozenset[str], float]]:
    """The best set of units, and weights of the sets of effects that were met."""
    A, b = p.A.sum(axis=0), p.b.sum(axis=0)
    each = [p.columns([i]) for i in range(len(p.units))]
    always = frozenset(i for i, n in enumerate(p.names) if n == "nuisance")
    met: dict[frozenset[int], float] = {}

    def criterion(members: frozenset[int]) -> float:
        if members not in met:
            c = np.concatenate([np.zeros(0, np.int64), *(each[i] for i in sorted(members))])
            left = max(p.yy - float(b[c] @ solved(A[np.ix_(c, c)], b[c])), 1e-9)
            met[members] = p.rows * np.log(left / p.rows) + settings["penalty"] * np.log(p.rows) * len(c)
        return met[members]

    best, value = always, criterion(always)
    while True:
        # adding is judged by what a unit alone takes of what is left, and tried for the few that take most
        c = p.columns(best)
        rest = b - A[:, c] @ solved(A[np.ix_(c, c)], b[c])
        alone = {
            i: float(rest[e] @ solved(A[np.ix_(e, e)], rest[e])) for i, e in enumerate(each) if i not in best and len(e)
        }
        few = sorted(alone, key=lambda i: -alone[i])[:12]
        tried = [best | {i} for i in few] + [best - {i} for i in best - always]
        nearest = min(tried, key=criterion, default=best)
        if criterion(nearest) >= value:
            break
        best, value = nearest, criterion(nearest)
    weights: dict[frozenset[str], float] = {}
    for members, v in met.items():
        named = frozenset(p.units[i].effect for i in members - always)
        weights[named] = weights.get(named, 0.0) + float(np.exp(-0.5 * min(v - value, 200.0)))
    return best, weights


def entering(A: np.ndarray, b: np.ndarray, first: int) -> list[int]:
    """Columns in the order in which they enter the lasso's path, `first` at the most, those that left it again apart."""
    beta, active = np.zeros(len(b)), [int(np.argmax(np.abs(b)))]
    for _ in range(4 * first):
        left = b - A @ beta
        top = float(np.abs(left[active]).max())
        sign = np.sign(left[active])
        way = solved(A[np.ix_(active, active)], sign)
        pull = A[:, active] @ way
        with np.errstate(divide="ignore", invalid="ignore"):
            steps = np.stack([(top - left) / (1.0 - pull), (top + left) / (1.0 + pull)])
        steps[~np.isfinite(steps) | (steps <= 1e-12 * max(top, 1e-300))] = np.inf
        steps[:, active] = np.inf
        enters = int(np.argmin(steps.min(axis=0)))
        step = min(float(steps.min()), top)
        with np.errstate(divide="ignore", invalid="ignore"):
            zero = -beta[active] / way
        zero[~np.isfinite(zero) | (zero <= 1e-15)] = np.inf
        leaves = int(np.argmin(zero))
        beta[active] += min(step, float(zero[leaves])) * way
        if zero[leaves] < step:
            beta[active[leaves]] = 0.0
            active.pop(leaves)
        elif step < top and len(active) < first:
            active.append(enters)
        else:
            break
        if not active:
            break
    return active


def lasso(p: Problem, settings: Mapping) -> tuple[frozenset[int], dict[frozenset[str], float]]:
    """Units that are often among the first, and weights of sets of effects: as often as they were drawn together."""
    rng, blocks = np.random.default_rng(0), np.arange(len(p.b))
    often = np.zeros(len(p.units))
    sets: list[set[int]] = []
    for _ in range(DRAWS):
        half = rng.permutation(blocks)[: max(1, len(blocks) // 2)]
        drawn = {int(p.owner[k]) for k in entering(p.A[half].sum(axis=0), p.b[half].sum(axis=0), settings["first"])}
        often[list(drawn)] += 1.0 / DRAWS
        sets.append(drawn)
    kept = frozenset(np.flatnonzero(often >= settings["often"]).tolist())
    weights: dict[frozenset[str], float] = {}
    for drawn in sets:
        named = frozenset(p.units[i].effect for i in drawn & kept) - {"nuisance"}
        weights[named] = weights.get(named, 0.0) + 1.0
    return kept, weights


METHODS: dict[str, Callable] = {"stepwise BIC": stepwise, "lasso, stability selection": lasso}


def refined(p: Problem, members: frozenset[int]) -> dict:
    """States of effects moved to where the fit of some units says, with orders of gears from what it leaves."""
    from camrob.gap.evidence.scan import gear_orders

    values = fitted(p, members)
    states = dict(p.states)
    left = [q.y_tcp - q.tcp @ values for q in p.panels]
    for effect in p.effects:
        own = {
            k.name: float(v)
            for k, o, v in zip((k for u in p.units for k in u.parameters), p.owner, values, strict=True)
            if int(o) in members and p.units[int(o)].effect == effect.name
        }
        states[effect.name] = effect.refine(states[effect.name], own) if own else states[effect.name]
        if effect.orders and not own:
            states[effect.name] = {**states[effect.name], **gear_orders(p.panels, left, 1.0)}
    return states


def fitted(p: Problem, members: frozenset[int]) -> np.ndarray:
    """(K,) least squares of some units, in the columns' own sizes."""
    from camrob.gap.evidence.design import pool

    A = pool(p.panels, p.units).design().A.sum(axis=0)
    scale = 1.0 / np.sqrt(np.maximum(np.diag(A), 1e-30))
    c = p.columns(members)
    out = np.zeros(len(p.owner))
    out[c] = scale[c] * solved(p.A.sum(axis=0)[np.ix_(c, c)], p.b.sum(axis=0)[c])
    return out


def answered(method: Callable, folder: Path, seed: int, without: Sequence[str], settings: Mapping) -> dict:
    """An answer as the scorer reads it."""
    from camrob.cell.read_cell import read_cell
    from camrob.gap.effects.registry import library
    from camrob.gap.evidence.design import make_panel
    from camrob.gap.evidence.model import whole_gap
    from camrob.gap.nuisances import WITHHELD
    from camrob.gap.observation.noise import find_outliers, noise_of
    from camrob.gap.pose_sets import fitted_scenes, withheld_scene
    from camrob.measurement.read_log import read_log

    cell, (log, other) = read_cell(CELL), [read_log(folder / f"{seed}{end}.csv") for end in ("", "_withheld")]
    begin = time.process_time()
    scenes = fitted_scenes([log], [cell])
    hidden = all(f"{j.name}.x" not in scenes[0].places for j in cell.joints if j.role == "workpiece")
    effects = tuple(e for e in library(without) if not (hidden and e.hidden_in_world))
    states = {e.name: dict(e.start) for e in effects}
    for _ in range(ROUNDS):
        p = laid_out(scenes, effects, states)
        members, weights = method(p, settings)
        states = refined(p, members)
    values, total = fitted(p, members), sum(weights.values())
    kept = withheld_scene(other, cell, scenes)
    noise = noise_of(kept)
    panel = make_panel(kept, WITHHELD, p.units, effects, p.states, noise, ~find_outliers(kept, noise), 10, 0)
    good = panel.w_tcp[:, 0] > 0.0
    gap = whole_gap(panel)[good]
    before, after = (float(np.sqrt(np.mean(np.sum(e**2, axis=1)))) for e in (gap, gap - panel.moves(values)[good]))
    found = {
        n: sum(w for s, w in weights.items() if n in s) / total for n in {u.effect for u in p.units} - {"nuisance"}
    }
    at_tcp = np.concatenate([(q.y_tcp - q.tcp @ values)[q.w_tcp[:, 0] > 0.0, :3] for q in p.panels])
    loud = float(np.sqrt(np.mean(np.sum(at_tcp**2, axis=1)))) > settings["loud"] * p.noise
    claimed = any(v >= 0.5 for v in found.values())
    status = ("partly explained" if loud else "explained") if claimed else "unexplained" if loud else "no gap"
    own = np.concatenate([whole_gap(q)[q.w_tcp[:, 0] > 0.0] for q in p.panels])
    known = np.concatenate([(whole_gap(q) - q.moves(values))[q.w_tcp[:, 0] > 0.0] for q in p.panels])
    removable, likeliest = before - p.noise, sorted(weights.items(), key=lambda x: -x[1])[:MOST_SETS]
    return {
        "status": status,
        "seconds": time.process_time() - begin,
        "rows": len(log),
        "noise_mm": 1e3 * p.noise,
        "effects": [
            {
                "effect": n,
                "probability": v,
                "axes": sorted({p.units[i].axis for i in members if p.units[i].effect == n} - {""}),
            }
            for n, v in sorted(found.items(), key=lambda x: -x[1])
            if v >= 0.02
        ],
        "alternatives": [{"effects": sorted(s), "probability": w / total} for s, w in likeliest],
        "unknown": {"probability": 0.97 if loud else 0.03, "where": {"rung": None, "axes": [], "regimes": []}},
        "together": {
            "shrink": 1.0 - after / before,
            "predicted_shrink": 1.0 - float(np.sqrt(np.sum(known**2) / np.sum(own**2))),
            "removable_removed": (before - after) / removable if removable > 0.2 * p.noise else None,
        },
        "rungs": {"setpoint_to_encoder": 0.0, "encoder_to_tcp": before},
        "regimes": {"position": 1.0},
    }


def run(of: Sequence[Path], out: Path, only: str) -> dict[str, dict]:
    """Answers of every baseline to the cases of some folders, and the figures of all."""
    labels, theirs = {}, {}
    for folder in of:
        labels |= read_lines(folder / "sealed" / "labels.jsonl")
        theirs |= read_lines(folder / "answers.jsonl")
    keys = [k for k in theirs if k in labels and k.startswith(only) and "error" not in theirs[k]["said"]]
    figures = {"camrob": score(rows_of(labels, {k: theirs[k] for k in keys}))}
    for name, method in METHODS.items():
        file = out / f"{name.split(',')[0].replace(' ', '_')}.jsonl"
        done = read_lines(file)
        with file.open("a") as said, tempfile.TemporaryDirectory() as folder:
            for key in [k for k in keys if k not in done]:
                task = labels[key]["task"]
                make(folder, task)
                found = answered(method, Path(folder), task["seed"], tuple(task.get("without", ())), SETTINGS)
                said.write(json.dumps({"key": key, "said": found}, default=float) + "\n")
                said.flush()
        done = read_lines(file)
        figures[name] = score(rows_of(labels, {k: done[k] for k in keys}))
    return figures


def table(figures: Mapping[str, dict]) -> list[str]:
    """A measure a row, a method a column."""
    rows: list[tuple[str, Callable]] = [
        ("false alarms", lambda f: percent(f["false alarms"])),
        (
            "one effect at twice the noise or more: right first",
            lambda f: percent(f["one effect at >= 2x noise"]["right first"]),
        ),
        ("one effect of any size: exact", lambda f: percent(f["one effect, any size"]["exact"])),
        ("two effects: recall", lambda f: percent(f["two effects"]["recall"])),
        ("... precision", lambda f: percent(f["two effects"]["precision"])),
        ("... exact", lambda f: percent(f["two effects"]["exact"])),
        ("three effects: recall", lambda f: percent(f["three effects"]["recall"])),
        ("... precision", lambda f: percent(f["three effects"]["precision"])),
        ("outside the library: flagged", lambda f: percent(f[OUTSIDE]["flagged"])),
        (
            "... a wrong name above 0.8",
            lambda f: percent(f[OUTSIDE]["one name above 0.8 that the path could separate"]),
        ),
        ("false unknowns", lambda f: percent(f["false unknowns"])),
        ("calibration error of effects", lambda f: f"{f['calibration of effects']['error']:.3f}"),
        (
            "predicted shrinkage within 5 points",
            lambda f: percent(f["predicted less reached shrinkage, points"]["within 5"]),
        ),
        ("seconds, median", lambda f: f"{f['seconds']['median']:.1f}"),
    ]
    lines = [f"| measure | {' | '.join(figures)} |", "| --- |" + " --- |" * len(figures)]
    return lines + [f"| {name} | {' | '.join(value(f) for f in figures.values())} |" for name, value in rows]


def main() -> None:
    """Answer, and write the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--of", type=Path, nargs="+", required=True, help="folders of the benchmark, with its answers")
    parser.add_argument("--only", default="", help="how the keys of the cases begin")
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    figures = run(arguments.of, arguments.out, arguments.only)
    cases = figures["camrob"]["cases"]
    head = ["# Baselines on the same cases", "", f"Cases: {', '.join(f'{k} {v}' for k, v in cases.items())}.", ""]
    (arguments.out / "baselines.md").write_text("\n".join([*head, *table(figures)]) + "\n")


if __name__ == "__main__":
    main()
