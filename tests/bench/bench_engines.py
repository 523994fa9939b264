"""Do the fuzzy engines earn their place? Weights fitted on drawn paths, judged on kinds of path that they never saw.

Run: OMP_NUM_THREADS=1 python tests/bench/bench_engines.py [--workers N] [--budget B] [--to FOLDER]

36 paths of six kinds (`path_family`). Three times two kinds are withheld and weights fitted to two paths of each other kind: the
best constant vector with five seeds, the best engine with three, by the same search with the same budget and the same objective
(`camrob.redundancy.tuning`). Beside them stand the cell's own rules, with one change at a time. Writes engines_table.md and
engines_table.csv (every path with every way), by default beside this file.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from time import process_time

import numpy as np

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(ROOT), str(HERE)]

import_module("camrob")  # before Numba, so that the kernels' cache folder is that of these sources

from path_family import KINDS, family  # noqa: E402

from camrob.cell.read_cell import read_cell  # noqa: E402
from camrob.cell.redundancy_settings import TABLES  # noqa: E402
from camrob.jobs.files.inputs import read_inputs  # noqa: E402
from camrob.redundancy.fuzzy.write_fis import fis_text  # noqa: E402
from camrob.redundancy.published.weighting import Weighting, engine_weighting, even_weights  # noqa: E402
from camrob.redundancy.tuning.fitted_weights import Judge, fit_constant, fit_engine  # noqa: E402
from camrob.redundancy.tuning.merit import Merit, followed_merit  # noqa: E402

CELL = ROOT / "cells" / "kr15_track_table"
WITHHELD = (
    ("2.5 D", "near the wrist's singularity"),
    ("tilted", "stretched"),
    ("5-axis", "two-sided"),
)
CONSTANT_SEEDS, ENGINE_SEEDS = range(5), range(3)
TRAINED = 2  # paths of a kind that weights are fitted to
SAMPLES = ("carving", "relief", "engraving")
CONSTANT, ENGINE, RULES = "constant vector, fitted", "engine, fitted", "today's rules"


@lru_cache(maxsize=1)
def scene():
    """The cell, and the family drawn once a process."""
    cell = read_cell(CELL)
    return cell, tuple(family(cell))


def trained_on(fold: int):
    """The paths that a fold's weights are fitted to; fold 3 withholds nothing, for the samples."""
    withheld = WITHHELD[fold] if fold < len(WITHHELD) else ()
    taken = {kind: 0 for kind in KINDS if kind not in withheld}
    out = []
    for member in scene()[1]:
        if taken.get(member.kind, TRAINED) < TRAINED:
            taken[member.kind] += 1
            out.append(member.path)
    return out


def fitted(order: tuple[str, int, int, int]):
    """One fit: way, fold, seed, budget. Returns these, the weighting, what it is in words, its price where it was fitted."""
    way, fold, seed, budget = order
    begun = process_time()
    judge = Judge(scene()[0], [(scene()[0], path) for path in trained_on(fold)])
    fit = (
        fit_constant(judge, budget=budget, seed=seed)
        if way == CONSTANT
        else fit_engine(judge, budget=budget, seed=seed)
    )
    told = ", ".join(f"{n} {w:.3g}" for n, w in zip(fit.outputs, fit.weights, strict=True)) if way == CONSTANT else ""
    if way == ENGINE:
        told = fis_text(
            fit.system, [f"Fitted by tests/bench/bench_engines.py: fold {fold}, seed {seed}, budget {budget}."]
        )
    return order, fit.weighting, told, fit.found.price, fit.found.tried, process_time() - begun


def changed_ways() -> dict[str, tuple[Weighting, dict]]:
    """Today's rules, and one change of them at a time: the weighting, and what else is other."""
    cell = scene()[0]
    own, even = engine_weighting(cell), even_weights(cell)
    corners = {
        name: replace(getattr(cell.resolve, name), table=TABLES[0]) for name in ("joint_engine", "condition_engine")
    }
    met = engine_weighting(replace(cell, resolve_section=replace(cell.resolve, **corners)))
    return {
        RULES: (own, {}),
        "their table with nodes at the corners": (met, {}),
        "first engine off (h_jnt alike 0.01)": (replace(own, joint=even.joint), {}),
        "second engine off (h_cond alike 0.01)": (replace(own, condition=even.condition), {}),
        "h_cond off": (replace(own, threshold=0.0), {}),
        "h_cond by k_F's gradient": (replace(own, gradient=True), {}),
        "no revision": (own, {"revise": False}),
        "all alike 0.01, no revision": (even, {"revise": False}),
        "track held, roll 0": (own, {"hold": ("E1", "roll")}),
    }


def judged(judge: Judge, weighting: Weighting, revise: bool = True, hold: Iterable[str] = ()) -> list[Merit]:
    """The merits of all of a judge's paths."""
    if not hold:
        return judge.merits(weighting, revise=revise)
    locked = np.array([name in hold for name in judge.cell.names])
    out = []
    for follower in judge.followers:
        follower.weigh(weighting)
        follower.settings = follower.settings._replace(locked=locked)
        out.append(followed_merit(follower, revise=False))
    return out


def rows_of(way: str, seed: int, members, merits: list[Merit]) -> list[dict]:
    return [
        {
            "way": way,
            "seed": seed,
            "kind": m.kind,
            "path": m.seed,
            "price": r.price,
            "followed": int(r.followed),
            "inv_kf_mean": r.inv_kf_mean,
            "inv_kf_min": r.inv_kf_min,
            "E1_mm": 1e3 * r.travel["E1"],
            "E2_deg": np.degrees(r.travel["E2"]),
            "held": r.held,
            "margin_deg": np.degrees(r.margin),
        }
        for m, r in zip(members, merits, strict=True)
    ]


def measured(fits) -> list[dict]:
    """Every path with every way: fitted weights on the kinds that were withheld from them, all others on all."""
    cell, members = scene()
    rows = []
    judge = Judge(cell, [(cell, m.path) for m in members])
    for way, (weighting, more) in changed_ways().items():
        rows += rows_of(way, 0, members, judged(judge, weighting, **more))
    for (way, fold, seed, _budget), weighting, *_told in fits:
        if fold < len(WITHHELD):
            held = [m for m in members if m.kind in WITHHELD[fold]]
            rows += rows_of(way, seed, held, judged(Judge(cell, [(cell, m.path) for m in held]), weighting))
    for name in SAMPLES:
        inputs = read_inputs(ROOT / "toolpaths" / name / f"{name}.cls", cell, None)
        judge = Judge(inputs.cell, [(inputs.cell, inputs.path)])
        sample = [argparse.Namespace(kind=f"sample {name}", seed=0)]
        for way, (weighting, more) in changed_ways().items():
            rows += rows_of(way, 0, sample, judged(judge, weighting, **more))
        for (way, fold, seed, _budget), weighting, *_told in fits:
            if fold == len(WITHHELD):
                rows += rows_of(way, seed, sample, judged(judge, weighting))
    return rows


def mean(rows: list[dict], key: str) -> float:
    values = [r[key] for r in rows if r["followed"]]
    return float(np.mean(values)) if values else float("nan")


def figure(rows: list[dict]) -> str:
    """A cell of the table by kind: the price, with the seeds' spread where there are seeds, and what was not followed."""
    seeds = sorted({r["seed"] for r in rows})
    prices = [mean([r for r in rows if r["seed"] == s], "price") for s in seeds]
    lost = sum(1 - r["followed"] for r in rows)
    text = f"{np.mean(prices):.3f}" + (f" ({min(prices):.3f} to {max(prices):.3f})" if len(seeds) > 1 else "")
    return text + (f"; {lost} of {len(rows)} not followed" if lost else "")


def middle(rows: list[dict], way: str) -> dict[tuple[str, int], float]:
    """Kind and path to the price, the median over the seeds; a path that was not followed costs what that is priced at."""
    out: dict[tuple[str, int], list[float]] = {}
    for r in rows:
        if r["way"] == way:
            out.setdefault((r["kind"], int(r["path"])), []).append(float(r["price"]))
    return {key: float(np.median(prices)) for key, prices in out.items()}


def medians(rows: list[dict], ways: list[str]) -> list[str]:
    """The table of medians, which single paths that go wrong don't govern, and on how many paths a way beats today's rules."""
    today = middle(rows, RULES)
    out = [
        "",
        "Medians over paths and seeds, and the paths (median of the seeds) that cost less than with today's rules:",
        "",
        "| way | " + " | ".join(KINDS) + " | all | better than today's rules on |",
        "|---|" + "---|" * (len(KINDS) + 2),
    ]
    for way in ways:
        mine, prices = middle(rows, way), [r for r in rows if r["way"] == way]
        each = [np.median([r["price"] for r in prices if r["kind"] == kind]) for kind in KINDS]
        better = sum(price < today[key] - 1e-4 for key, price in mine.items())
        out.append(
            f"| {way} | "
            + " | ".join(f"{v:.3f}" for v in each)
            + f" | {np.median([r['price'] for r in prices]):.3f} | {better} of {len(mine)} |"
        )
    return out


def paired(rows: list[dict], kind: str) -> tuple[int, int, float]:
    """Paths on which the fitted engine costs less than the fitted constant (medians of seeds), of how many, mean difference."""

    mine = [r for r in rows if r["kind"] == kind]
    constant, engine = middle(mine, CONSTANT), middle(mine, ENGINE)
    differences = [engine[k] - constant[k] for k in constant]
    return sum(d < 0 for d in differences), len(differences), float(np.mean(differences))


def table(rows: list[dict], fits, budget: int) -> str:
    ways = [CONSTANT, ENGINE, *changed_ways()]
    kinds = [*KINDS, *(f"sample {name}" for name in SAMPLES)]
    drawn = [r for r in rows if r["kind"] in KINDS]
    out = [
        "# Fuzzy engines against a constant vector, on kinds of path withheld from the fit",
        "",
        f"`OMP_NUM_THREADS=1 python tests/bench/bench_engines.py --budget {budget}` wrote this file. Price: metres for each "
        "metre cut (conditioning, margins, external travel, feed; less is better), the mean over the paths that were followed; "
        f"in brackets the seeds' spread. Fits: {budget} candidates each, on {TRAINED} paths of each kind that is not withheld.",
        "",
        "| way | " + " | ".join(KINDS) + " | all |",
        "|---|" + "---|" * (len(KINDS) + 1),
    ]
    for way in ways:
        mine = [r for r in drawn if r["way"] == way]
        out.append(
            f"| {way} | "
            + " | ".join(figure([r for r in mine if r["kind"] == k]) for k in KINDS)
            + f" | {figure(mine)} |"
        )
    out += medians(drawn, ways)
    out += [
        "",
        "| way, all drawn paths | 1/k_F mean | lowest, mean of paths | E1 mm | E2 degrees | feed held | least margin, degrees |",
        "|---|---|---|---|---|---|---|",
    ]
    for way in ways:
        mine = [r for r in drawn if r["way"] == way]
        margin = min(r["margin_deg"] for r in mine if r["followed"])
        out.append(
            f"| {way} | {mean(mine, 'inv_kf_mean'):.4f} | {mean(mine, 'inv_kf_min'):.4f} | {mean(mine, 'E1_mm'):.0f} | "
            f"{mean(mine, 'E2_deg'):.1f} | {100 * mean(mine, 'held'):.1f} % | {margin:.1f} |"
        )
    out += ["", "| kind | fitted engine costs less than fitted constant on | mean difference |", "|---|---|---|"]
    for kind in kinds:
        better, count, difference = paired(rows, kind)
        out.append(f"| {kind} | {better} of {count} | {difference:+.4f} |")
    out += [
        "",
        "The samples (weights fitted on two paths of every kind, none of a sample):",
        "",
        "| way | " + " | ".join(f"{n}: price; 1/k_F mean, lowest; E1 mm; held" for n in SAMPLES) + " |",
        "|---|---|---|---|",
    ]
    for way in ways:
        cells = []
        for name in SAMPLES:
            mine = [r for r in rows if r["way"] == way and r["kind"] == f"sample {name}"]
            cells.append(
                f"{figure(mine)}; {mean(mine, 'inv_kf_mean'):.3f}, {mean(mine, 'inv_kf_min'):.3f}; {mean(mine, 'E1_mm'):.0f}; "
                f"{100 * mean(mine, 'held'):.1f} %"
                if any(r["followed"] for r in mine)
                else "not followed"
            )
        out.append(f"| {way} | " + " | ".join(cells) + " |")
    out += [
        "",
        "| fit | withheld | seed | price where fitted | candidates | processor s | weights |",
        "|---|---|---|---|---|---|---|",
    ]
    for (way, fold, seed, _budget), _weighting, told, price, tried, seconds in fits:
        withheld = ", ".join(WITHHELD[fold]) if fold < len(WITHHELD) else "the samples"
        out.append(
            f"| {way} | {withheld} | {seed} | {price:.4f} | {tried} | {seconds:.0f} | {told if way == CONSTANT else ''} |"
        )
    return "\n".join(out) + "\n"


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--budget", type=int, default=120)
    parser.add_argument("--to", type=Path, default=HERE)
    asked = parser.parse_args(argv)
    orders = [(ENGINE, fold, seed, asked.budget) for fold in range(4) for seed in (ENGINE_SEEDS if fold < 3 else [0])]
    orders += [
        (CONSTANT, fold, seed, asked.budget) for fold in range(4) for seed in (CONSTANT_SEEDS if fold < 3 else [0])
    ]
    fits = []
    with ProcessPoolExecutor(asked.workers) as pool:
        for fit in pool.map(fitted, orders):
            fits.append(fit)
            print(
                f"{len(fits)} of {len(orders)}: {fit[0][0]}, fold {fit[0][1]}, seed {fit[0][2]}: {fit[3]:.4f}, {fit[5]:.0f} s",
                flush=True,
            )
    rows = measured(fits)
    asked.to.mkdir(parents=True, exist_ok=True)
    with (asked.to / "engines_table.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows({k: f"{v:.5g}" if isinstance(v, float) else v for k, v in r.items()} for r in rows)
    (asked.to / "engines_table.md").write_text(table(rows, fits, asked.budget), encoding="utf-8")
    last = next(fit for fit in fits if fit[0][0] == ENGINE and fit[0][1] == len(WITHHELD))
    (asked.to / "engines_fitted.fis").write_text(last[2], encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
