"""`camrob tune-engines`: fit a fuzzy engine's rules to samples, and the best constant weights beside them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from camrob.cell.cell import Cell
from camrob.cell.redundancy_settings import EVEN
from camrob.errors import InputError
from camrob.jobs.files.cell_for import cell_for
from camrob.jobs.files.inputs import CL_SUFFIXES, read_inputs
from camrob.jobs.files.output import staged_output
from camrob.jobs.files.summary_file import write_summary
from camrob.jobs.files.takes_paths import takes_paths
from camrob.jobs.solving.thinned import thinned
from camrob.progress import Progress, part_of, stage_of
from camrob.redundancy.fuzzy.fis import read_fis
from camrob.redundancy.fuzzy.surfaces import table_error
from camrob.redundancy.fuzzy.write_fis import fis_text
from camrob.redundancy.published.weighting import Weighting, engine_weighting
from camrob.redundancy.tuning.fitted_weights import (
    ENGINES,
    FittedConstant,
    FittedEngine,
    Judge,
    fit_constant,
    fit_engine,
)
from camrob.redundancy.tuning.merit import Merit
from camrob.summaries.tune_summary import TunedFigures, TunedWay, TuneSummary
from camrob.units import rad_to_deg

__all__ = ["TuneEnginesResult", "tune_engines"]

Fitted = FittedConstant | FittedEngine

_WAYS = {"constant": "constants, fitted", "engine": "rules, fitted"}
_RULES = "the cell's own rules"
_MOST_BUDGET, _MOST_SEEDS, _MOST_POINTS = 100_000, 100, 100_000  # days of one core: beyond is a slip of the pen


@dataclass(frozen=True, slots=True)
class TuneEnginesResult:
    """What a fit found: the summary, and `files` in `out`."""

    summary: TuneSummary
    out: Path
    files: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class _Judges:
    """What weights are fitted to, and what they are judged on beside."""

    trained: Judge
    withheld: Judge | None

    def way(
        self,
        name: str,
        weightings: Sequence[Weighting],
        *,
        tried: int = 0,
        weights: Mapping[str, float] | None = None,
        file: str = "",
    ) -> TunedWay:
        """Figures of the first weighting where it was fitted and where not, with the prices of all of them."""
        withheld = None if self.withheld is None else _figures(self.withheld, weightings)
        trained = _figures(self.trained, weightings)
        return TunedWay(way=name, tried=tried, trained=trained, withheld=withheld, weights=weights or {}, file=file)


@takes_paths
def tune_engines(
    cell: Path,
    *,
    on: Sequence[Path],
    out: Path,
    withheld: Sequence[Path] = (),
    engine: str = "joint",
    budget: int = 150,
    seeds: int = 3,
    points: int = 400,
    progress: Progress | None = None,
) -> TuneEnginesResult:
    """Fit an engine's memberships and conclusions to samples, and constant weights with the same search and budget beside.

    Objective: metres for each metre cut, by the prices of the cell's `[resolve.planned]`: conditioning, limit margins, external
    travel, and feed lost to the axes' speeds and accelerations (`camrob.redundancy.tuning.merit`). Both fits are judged on
    samples that neither saw. ENGINE_rules.fis, ENGINE_constant.fis and tune.json appear in `out`: Sugeno engines, whose
    conclusions are the weights themselves; put the better one into the cell's folder and name it in `[resolve]`. The cell is
    left as it is.

    Args:
        cell: the cell's folder.
        on: samples to fit to: CL files, folders with one, or folders of such folders.
        out: the folder to write into.
        withheld: samples to judge on.
        engine: "joint" for the weights of h_jnt, "condition" for those of h_cond.
        budget: candidates that each fit may try.
        seeds: fits of either kind, each from a seed of its own; the spread is reported; the best where it was fitted is written.
        points: cutting points that a sample is thinned to.
        progress: called with a stage and the share of it that is done, 0 to 1.

    Raises:
        InputError: no samples, a number that makes no sense, or input that is wrong.

    Example:
        >>> where = Path("cells/kr15_track_table")
        >>> fit = camrob.tune_engines(where, on=[Path("samples")], out=Path("out/tune"), budget=4, seeds=1, points=60)
        >>> fit.files, len(fit.summary.ways)
        (('weights_jnt_rules.fis', 'weights_jnt_constant.fis', 'tune.json'), 3)
    """
    _check(engine, budget, seeds, points)
    machine = cell_for("post", cell)
    trained = _judge(machine, _clfiles(on), points)
    judges = _Judges(trained, _judge(machine, _clfiles(withheld), points) if withheld else None)
    settings = getattr(machine.resolve, ENGINES[engine])
    system = read_fis(machine.folder / settings.file)
    stem = Path(settings.file).stem
    fits: dict[str, Sequence[Fitted]] = {
        name: [
            fit(
                trained,
                budget=budget,
                seed=seed,
                of=engine,
                progress=part_of(stage_of(progress, f"fit {name}"), seed, seeds),
            )
            for seed in range(seeds)
        ]
        for name, fit in (("constant", fit_constant), ("engine", fit_engine))
    }
    own = judges.way(_RULES, [engine_weighting(machine)])
    names = {"engine": f"{stem}_rules.fis", "constant": f"{stem}_constant.fis"}
    ways = (own, *(_way(judges, name, fits[name], names[name]) for name in ("engine", "constant")))
    error, where = table_error(system, even=settings.table == EVEN)
    by = "withheld" if withheld else "trained"
    summary = TuneSummary(
        cell=machine.name,
        engine=settings.file,
        budget=budget,
        seeds=seeds,
        trained_on=tuple(f.name for f in _clfiles(on)),
        withheld=tuple(f.name for f in _clfiles(withheld)),
        ways=ways,
        best=min(ways, key=lambda way: getattr(way, by).price).way,
        judged_by="the samples withheld" if withheld else "the samples fitted to (withhold some to know more)",
        table_error_percent=round(100.0 * error, 2),
        table_error_at={v.name: round(float(x), 2) for v, x in zip(system.inputs, where, strict=True)},
        files=(names["engine"], names["constant"], "tune.json"),
    )
    with staged_output(out) as folder:
        for name in ("engine", "constant"):
            text = fis_text(_best(fits[name]).system, _remarks(summary, name))
            (folder / names[name]).write_text(text, encoding="utf-8")
        write_summary(folder / "tune.json", summary, indent=1)
    return TuneEnginesResult(summary, out, summary.files)


def _check(engine: str, budget: int, seeds: int, points: int) -> None:
    if engine not in ENGINES:
        raise InputError(f"no engine is called {engine!r}", hint=f"use {' or '.join(ENGINES)}")
    for name, value, most in (
        ("budget", budget, _MOST_BUDGET),
        ("seeds", seeds, _MOST_SEEDS),
        ("points", points, _MOST_POINTS),
    ):
        if not 1 <= value <= most:
            raise InputError(f"--{name} {value} makes no sense", hint=f"give a whole number from 1 to {most}")


def _clfiles(samples: Sequence[Path]) -> list[Path]:
    """The CL files that paths name: themselves, those in a folder, those in its folders."""
    found = []
    for sample in map(Path, samples):
        if sample.is_dir():
            inside = [f for f in sorted((*sample.glob("*"), *sample.glob("*/*"))) if f.suffix.lower() in CL_SUFFIXES]
            found += [f for f in inside if f.is_file()]
            if not inside:
                raise InputError("holds no samples", hint="give CL files, or folders that hold them", path=sample)
        else:
            found.append(sample)
    return found


def _judge(machine: Cell, clfiles: Sequence[Path], points: int) -> Judge:
    """The samples' paths, thinned, each with the tools that it is cut with."""
    if not clfiles:
        raise InputError("no samples to fit to", hint="name CL files, or folders that hold them, with --on")
    paths = []
    for clfile in clfiles:
        inputs = read_inputs(clfile, machine, None)
        for k in range(len(inputs.path.stretches)):
            here = inputs.of_stretch(k, None)
            paths.append((here.cell, thinned(here.path, points)))
    return Judge(machine, paths)


def _best(fits: Sequence[Fitted]) -> Fitted:
    """The fit that costs least where it was fitted."""
    return min(fits, key=lambda fit: fit.found.price)


def _way(judges: _Judges, name: str, fits: Sequence[Fitted], file: str) -> TunedWay:
    """A kind of fit: the best one's figures, with the price of every seed."""
    best = _best(fits)
    ordered = [best, *(fit for fit in fits if fit is not best)]
    weights = {}
    if isinstance(best, FittedConstant):
        weights = {output: round(float(w), 5) for output, w in zip(best.outputs, best.weights, strict=True)}
    tried = sum(fit.found.tried for fit in fits)
    return judges.way(_WAYS[name], [fit.weighting for fit in ordered], tried=tried, weights=weights, file=file)


def _figures(judge: Judge, weightings: Sequence[Weighting]) -> TunedFigures:
    """Figures of the first weighting, with the prices of all of them."""
    merits = [judge.merits(weighting) for weighting in weightings]
    met = [m for m in merits[0] if m.followed]

    def mean(values: Sequence[float]) -> float | None:
        return round(float(np.mean(values)), 5) if values else None

    joints = {j.name: j for j in judge.cell.joints}
    travel = {
        f"{name}_{joints[name].unit}": round(float(np.mean([joints[name].to_edge(m.travel[name]) for m in met])), 2)
        for name in judge.cell.external_names
        if met
    }
    return TunedFigures(
        paths=len(merits[0]),
        followed=len(met),
        price=_price(merits[0]),
        price_by_seed=tuple(_price(each) for each in merits),
        inv_kf_mean=mean([m.inv_kf_mean for m in met]),
        inv_kf_min=mean([m.inv_kf_min for m in met]),
        travel=travel,
        feed_held_percent=mean([100.0 * m.held for m in met]),
        margin_min_deg=round(rad_to_deg(min(m.margin for m in met)), 3) if met else None,
    )


def _price(merits: Sequence[Merit]) -> float:
    return round(float(np.mean([m.price for m in merits])), 6)


def _remarks(summary: TuneSummary, name: str) -> list[str]:
    """What the .fis says of itself."""
    way = next(w for w in summary.ways if w.way == _WAYS[name])
    lines = [
        f"{_WAYS[name].capitalize()} by `camrob tune-engines` from {summary.engine} of {summary.cell}:",
        f"{summary.budget} candidates a fit, {summary.seeds} seeds, on {', '.join(summary.trained_on)}.",
        f"Price where fitted {way.trained.price:.4f} m a metre cut, the cell's own rules {summary.ways[0].trained.price:.4f}.",
    ]
    own = summary.ways[0].withheld
    if way.withheld is not None and own is not None:
        lines.append(
            f"Withheld ({', '.join(summary.withheld)}): {way.withheld.price:.4f}, the cell's own {own.price:.4f}."
        )
    return [*lines, "A conclusion of a rule is the weight itself; the rules are the cell's own."]
