"""The part, four ways, on sealed cells: `tests/bench/bench_surface.py --out DIR [--cells N] [--first N] [--withhold] [--table]`.

A cell: all joints yield to gravity and to the force of the cut, beside it one to four effects of `gap.draws`, and a smooth
discrepancy of 1 to 10 times the instrument's noise that no library has (`gap.field`); nothing of it comes from camrob. It is
diagnosed on a noisy run of the engraving in air, and one of a drawn part's program (`drawn_parts`), posted with planned
postures by conditioning. It is posted again for accuracy with that diagnosis and a stated force, which is up to 30 % off and says
so, and likewise for what compensation will leave; the first and the last are compensated with all that was found and that force.
The cell runs all four without noise, and what each run sweeps is cut from the same stock: deviation of that surface from the one
that the CL data's straight moves sweep, at all its points, along its normals. --withhold: the same cells again, while the
diagnosis lacks one of the effects that are at work (beside compliance) in its library. What could be removed is what the posted
program leaves beyond what it leaves on a cell with the discrepancy alone. The removal is camrob's (`tests/cutting` holds it to
hulls and formulas); paths, errors, measurement and what is meant are not.
--first: the number of the first cell; 1 to 40 are the sealed ones: what is tuned is tuned on others.
Writes surface.jsonl, which a second run goes on from; --table writes surface_table.md beside this file.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from shutil import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
sys.path.insert(0, str(Path(__file__).resolve().parent))

import closed_loop
from bench_accuracy import in_base, wide
from bench_loop import told
from closed_loop import CELL, EDGE, ROOT
from drawn_parts import KINDS, LENGTH, DrawnPart, draw_part
from gap import generator
from gap.draws import draw
from gap.field import draw_field
from row_file import add_rows, read_rows

from camrob.cell.read_cell import read_cell
from camrob.controller.simulate import simulate
from camrob.cutting.cutter import Cutter
from camrob.cutting.dexels import CutSurface, Dexels, deviation
from camrob.cutting.way import Way
from camrob.errors import JobError
from camrob.jobs.compensate import compensate
from camrob.jobs.diagnose import diagnose
from camrob.jobs.post import post
from camrob.jobs.predict import predict
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.measurement.write_log import write_log

Array = NDArray[np.float64]
Apply = Callable[[generator.World], None]
PROGRAM = ROOT / "toolpaths" / "engraving" / "golden" / "engraving.src"
EFFECTS = (
    "frame_tool",
    "joint_offset",
    "geometry",
    "track",
    "lean",
    "backlash",
    "servo_lag",
    "friction",
    "gear_ripple",
    "wrist_coupling",
)
STATED = np.array([-60.0, 30.0, 20.0])  # N along the feed, across it, along the tool
FORCE_OFF = 0.3  # of itself, by which the force is another at the most
NOISE = closed_loop.SIGMA_MM * np.sqrt(3.0)  # mm, 3-D
PITCH_MM, FARTHEST, STRAIGHT = 0.5, 3e-3, 1e-6  # mm; m; m
WAYS = ("posted", "compensated", "planned", "both")
FAMILY, WITHHELD = "sealed", "withheld"
ALIKE_MM = 5.0  # mm apart, that walls count which look opposite ways
NEAR = 5e-4  # m off the CL data's way within which a run cuts, as it was programmed or as the machine goes


def world_of(program: Path) -> generator.World:
    """A program's run, nothing wrong yet."""
    ran = simulate(read_krl(program), read_cell(CELL), cycle=generator.STEP).log
    return generator.World(np.asarray(ran.t), ran.setpoints(generator.AXES) / EDGE)


def cell_of(number: int, program: Path) -> tuple[list[str], float, Apply, Apply]:
    """The names of a cell's effects, its discrepancy (mm, rms over the run in air and that of `program`), and what makes it: all,
    and the discrepancy alone.
    """
    rng = np.random.default_rng([9_000_000, number])
    world, other = told(world_of(PROGRAM)), world_of(program)
    names = [str(n) for n in rng.choice(EFFECTS, rng.integers(1, 5), replace=False)]
    drawn = [(draw(name, rng, world)[1], rng.uniform(0.5, 1.5)) for name in names]
    c = np.concatenate([rng.uniform(1e-6, 4e-6, 3), rng.uniform(4e-6, 12e-6, 3)])
    factor = rng.uniform(1.0 - FORCE_OFF, 1.0 + FORCE_OFF)
    size = float(NOISE * np.exp(rng.uniform(0.0, np.log(10.0))))
    both = generator.World(world.t, np.concatenate([world.command, other.command]))
    field: Apply = draw_field(number, both, size * 1e-3)

    def whole(w: generator.World) -> None:
        given = dict(w.context) if w.context else {}
        told(w)
        w.context |= given
        w.link[:, :6] += c * w.context["torque"]
        if "force" in w.context:
            J = wide(w, generator.jacobian(w.command[::25])[:, :3])
            w.link[:, :6] += c * np.einsum("nij,ni->nj", J, factor * w.context["force"])
        for apply, s in drawn:
            apply(w, s)
        field(w)

    return ["joint_compliance", *names], size, whole, field


class Bench:
    """A part, and what cells make of programs for it."""

    def __init__(self, part: DrawnPart) -> None:
        self.part = part
        self.cutter = Cutter(1e-3 * part.radius, 1e-3 * part.corner, 1e-3 * LENGTH)
        self.stock = Dexels(1e-3 * part.box[0], 1e-3 * part.box[1], 1e-3 * PITCH_MM)
        tips, fine = 1e-3 * part.tips, np.linspace(0.0, 1.0, 60)[:-1, None]
        pieces = [a * (1.0 - fine) + b * fine for a, b in pairwise(tips)]
        self.near = cKDTree(np.concatenate([*pieces, tips[-1:]]))
        meant, left = self.cut(tips, part.axes)
        self.surface: CutSurface = left.surface(meant.moves)

    def cut(self, tip: Array, axis: Array) -> tuple[Way, Dexels]:
        """What a way of the cutter, (N, 3) m and (N, 3), leaves of the stock."""
        way, left = Way.of(tip.copy(), axis.copy(), self.cutter, tolerance=STRAIGHT), self.stock.copy()
        left.carve(way.moves)
        return way, left

    def off(self, program: Path, apply: Apply) -> Array:
        """(P,) mm by which the part stands beyond what was meant where a cell runs a program, NaN where it isn't met."""
        ran = simulate(read_krl(program), read_cell(CELL), cycle=generator.STEP).log
        t, command = np.asarray(ran.t), ran.setpoints(generator.AXES) / EDGE
        plain = in_base(generator.pose(command), command[:, 7])
        tip, axis = plain[:, :3, 3], plain[:, :3, 2]
        rate = np.gradient(tip, t, axis=0)
        speed = np.linalg.norm(rate, axis=1)
        # a compensated program is off that way by as much as the machine errs, and the machine on it
        unpushed = generator.World(t, command)
        apply(unpushed)
        _, encoder, world_T_tool = generator.show(unpushed, t)
        there = in_base(world_T_tool, encoder[:, 7])[:, :3, 3]
        cuts = (np.minimum(self.near.query(tip)[0], self.near.query(there)[0]) < NEAR) & (speed > 1e-4)
        x = rate - np.sum(rate * axis, axis=1, keepdims=True) * axis
        x /= np.maximum(np.linalg.norm(x, axis=1), 1e-9)[:, None]
        pushed = (STATED[0] * x + STATED[1] * np.cross(axis, x) + STATED[2] * axis) * cuts[:, None]
        back = np.tile(np.eye(3), (len(t), 1, 1))
        c, s = np.cos(command[:, 7]), np.sin(command[:, 7])
        back[:, 0, 0] = back[:, 1, 1] = c
        back[:, 0, 1], back[:, 1, 0] = s, -s
        world = generator.World(t, command)
        world.context = {"force": np.einsum("nij,nj->ni", back, pushed)}
        apply(world)
        _, encoder, world_T_tool = generator.show(world, t)
        true = in_base(world_T_tool, encoder[:, 7])
        way, left = self.cut(true[:, :3, 3], true[:, :3, 2])
        return deviation(self.surface, way.moves, left, farthest=FARTHEST) * 1e3


def size(off: Array) -> list[float]:
    """rms, 95 % and worst, mm, of what is met."""
    some = np.abs(off[np.isfinite(off)])
    return [float(np.sqrt(np.mean(some**2))), float(np.quantile(some, 0.95)), float(some.max())]


def held_by_band(bench: Bench, off: Array, file: Path) -> dict[str, float]:
    """How the deviation (P,) mm of a surface's points lies in the band that was predicted for the nearest points: the share
    within it; how far predictions are off on 95 %; the middle band; by how many bands 95 % of the points would be held; and the
    95 % error that is expected of these points, which are those that are met, and that came out there.
    """
    with np.load(file) as z:
        tree = cKDTree(np.concatenate([z["points"], ALIKE_MM * z["normals"]], axis=1))
        middle, band = z["deviation"], z["band"]
    asked = np.concatenate([bench.surface.point * 1e3, ALIKE_MM * bench.surface.normal], axis=1)
    far, k = tree.query(asked)
    met = (far < PITCH_MM) & np.isfinite(off)
    wrong, own = np.abs(off - middle[k])[met], band[k][met]
    return {
        "within": float(np.mean(wrong <= own)),
        "off_p95_mm": float(np.quantile(wrong, 0.95)),
        "band_mm": float(np.median(own)),
        "needed": float(np.quantile(wrong / own, 0.95)),
        "expected_p95_mm": float(np.quantile(np.abs(middle[k][met]), 0.95)),
        "came_p95_mm": float(np.quantile(np.abs(off[met]), 0.95)),
    }


def one(family: str, number: int, out: Path) -> dict[str, Any]:
    """A cell's row."""
    out.mkdir(parents=True, exist_ok=True)
    drawn = draw_part(KINDS[number % len(KINDS)], number)
    part, bench = drawn.write(out), Bench(drawn)
    post(part, cell=CELL, out=out / "posted", method="planned", report=False)
    names, field_mm, whole, field = cell_of(number, out / "posted" / "part.src")
    (out / "air").mkdir(exist_ok=True)
    for file in PROGRAM.parent.glob(f"{PROGRAM.stem}.[sd][ra][ct]"):
        copy(file, out / "air" / file.name)
    logs = [out / "air" / "run.csv", out / "posted" / "run.csv"]
    for k, (log, program) in enumerate(zip(logs, (PROGRAM, out / "posted" / "part.src"), strict=True)):
        write_log(closed_loop.run_on_cell(program, whole, 2 * number + k), log)
    fitted = out / "fitted.toml"
    without = (names[1],) if family == WITHHELD else ()
    with suppress(JobError):  # no constant was found
        diagnose(cell=CELL, log=logs, without=without, out=out / "diagnosis", calibration=fitted)
    said = json.loads((out / "diagnosis" / "diagnosis.json").read_text())
    force = out / "FORCE.toml"
    axes = zip(("along", "across", "axial"), STATED, strict=True)
    doubt = FORCE_OFF / np.sqrt(3.0)  # the standard deviation of what is drawn evenly
    force.write_text(f"doubt = {doubt:.4f}\n[mean]\n" + "".join(f"{n}_n = {v}\n" for n, v in axes))
    known: dict[str, Any] = {
        "calibration": fitted if fitted.is_file() else None,
        "diagnosis": out / "diagnosis",
        "force": force,
    }
    accurate: dict[str, Any] = {"cell": CELL, "method": "planned", "report": False, "for_accuracy": True, **known}
    made = post(part, out=out / "planned", **accurate)
    post(part, out=out / "left", then_compensated=True, **accurate)
    for source, to in (("posted", "compensated"), ("left", "both")):
        compensate(out / source / "part.src", cell=CELL, out=out / to, **known)
    row: dict[str, Any] = {
        "family": family,
        "draw": number,
        "kind": drawn.kind,
        "effects": names,
        "without": list(without),
        "field_mm": field_mm,
        "claimed": list(dict.fromkeys(e["effect"] for e in said["effects"] if e["probability"] >= 0.5)),
    }
    plan = made.summary.plan
    if plan is not None and plan.accuracy is not None:
        row |= {
            "taken": plan.accuracy.taken,
            "expected": [plan.accuracy.conditioning.rms_mm, plan.accuracy.accuracy.rms_mm],
        }
    came: dict[str, Array] = {}
    for way in WAYS:
        off = came[way] = bench.off(out / way / "part.src", whole)
        row[way] = size(off)
        row.setdefault("not_met", {})[way] = float(np.mean(~np.isfinite(off)))
    for way in ("posted", "planned"):
        row[f"field_{way}"] = size(bench.off(out / way / "part.src", field))
    foreseen = {}
    for way in ("posted", "planned"):
        told_of = predict(
            out / way / "part.src",
            cell=CELL,
            out=out / f"predicted_{way}",
            setup=out / "setup.toml",
            pitch_mm=PITCH_MM,
            **known,
        ).summary
        likely = told_of.likely
        foreseen[way] = [told_of.rms_mm, told_of.p95_mm, told_of.worst_mm]
        row.setdefault("likely", {})[way] = [likely.p95_low_mm, likely.p95_mm, likely.p95_high_mm]
        held = held_by_band(bench, came[way], out / f"predicted_{way}" / "surface.npz")
        row.setdefault("band", {})[way] = held
        row.setdefault("within", {})[way] = held["within"]
    return row | {"predicted": foreseen}


def removed(row: dict[str, Any], way: str) -> float:
    """The share of the 95 % error that could be removed (all but the discrepancy's own) which `way` removes."""
    return (row["posted"][1] - row[way][1]) / max(row["posted"][1] - row["field_posted"][1], 1e-9)


def shares(rows: list[dict[str, Any]]) -> list[str]:
    """What the rows say together."""
    lines = []
    for way in WAYS[1:]:
        gone = np.array([removed(r, way) for r in rows])
        less = np.array([1.0 - r[way][1] / r["posted"][1] for r in rows])
        worse = [r for r in rows if r[way][1] > r["posted"][1]]
        most = max((r[way][1] / r["posted"][1] - 1.0 for r in worse), default=0.0)
        rms = np.median([1.0 - r[way][0] / r["posted"][0] for r in rows])
        lines.append(
            f"- {way}: in the median {100 * np.median(gone):.0f} % of the 95 % error that could be removed is gone "
            f"({100 * np.median(less):.0f} % of all of it, {100 * rms:.0f} % of the rms); worse than posted in {len(worse)}"
            + (f", by {100 * most:.0f} % at the most." if worse else ".")
        )
    taken = [r for r in rows if r.get("taken")]
    gains = [f"{100 * np.median([1.0 - r['planned'][k] / r['posted'][k] for r in taken]):.0f} %" for k in (0, 1)]
    lines.append(
        f"- A plan for accuracy was taken in {len(taken)}: there {' and '.join(gains)} less rms and 95 % in the median."
    )
    for way in ("posted", "planned"):
        came = np.array([r[way][1] for r in rows])
        expected = np.array([r["predicted"][way][1] for r in rows])
        low, likely, high = np.array([r["likely"][way] for r in rows]).T
        near, nearly = (np.count_nonzero(np.abs(x / came - 1.0) <= 0.2) for x in (likely, expected))
        inside = np.count_nonzero((low <= came) & (came <= high))
        both = [(r["band"][way]["expected_p95_mm"], r["band"][way]["came_p95_mm"]) for r in rows]
        met = sum(abs(foretold / there - 1.0) <= 0.2 for foretold, there in both)
        lines.append(
            f"- {way}: the likely 95 % is within 20 % of what came out in {near} of {len(rows)} cells ({nearly} by what is "
            f"expected of each point, {met} on the points that are met); what came out lies in the stated range in {inside}."
        )
    held = [f"{100 * np.mean([r['within'][way] for r in rows]):.0f} %" for way in ("posted", "planned")]
    lines.append(
        f"- In the stated 95 % band: {held[0]} of the points as posted, {held[1]} in the plan for accuracy (means of cells)."
    )
    return lines


def by_kind(rows: list[dict[str, Any]]) -> list[str]:
    """What the band of predictions holds, a row a kind of part and way."""
    lines = [
        "",
        "What the band holds: the mean of the cells' shares of points with the interval of cells drawn again (95 %), and the",
        "fewest; how many bands would hold 95 % of a cell's points, rms of cells; then medians of cells.",
        "",
        "| kind, way | cells | within, mean | fewest | bands needed | band, mm | prediction off on 95 %, mm |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    rng = np.random.default_rng(1)
    for kind in (*KINDS, "all"):
        for way in ("posted", "planned"):
            own = [r["band"][way] for r in rows if "band" in r and kind in (r["kind"], "all")]
            if not own:
                continue
            share = np.array([o["within"] for o in own])
            low, high = np.quantile(np.mean(rng.choice(share, (5000, len(share))), axis=1), [0.025, 0.975])
            needed = np.sqrt(np.mean([o["needed"] ** 2 for o in own]))
            band, wrong = (np.median([o[k] for o in own]) for k in ("band_mm", "off_p95_mm"))
            lines.append(
                f"| {kind}, {way} | {len(own)} | {100 * share.mean():.1f} % ({100 * low:.0f} to {100 * high:.0f}) "
                f"| {100 * share.min():.0f} % | {needed:.2f} | {band:.3f} | {wrong:.3f} |"
            )
    return lines


def table(every: list[dict[str, Any]]) -> str:
    """The figures for people."""
    rows = [r for r in every if r["family"] == FAMILY]
    lines = [
        "# The part, four ways",
        "",
        "`python tests/bench/bench_surface.py --out DIR --cells N`, then `--table`. By how much the part's surface is off along",
        "its normals, mm: rms / 95 % / worst. Field: what nobody can take off, as posted. Predicted: the likely 95 %, as posted",
        "and planned; in band: the share of points within the stated 95 % band, of both.",
        "",
        "| cell | effects beside compliance and force | found | field | "
        f"{' | '.join(WAYS)} | removed by both | predicted | in band |",
        f"| --- | --- | --- | --- |{' --- |' * len(WAYS)} --- | --- | --- |",
    ]
    for r in sorted(rows, key=lambda r: r["draw"]):
        sizes = " | ".join(" / ".join(f"{v:.3f}" for v in r[k]) for k in WAYS)
        found = ", ".join(e for e in r["claimed"] if e != "corner_rounding")
        told_of = ", ".join(f"{r['likely'][w][1]:.3f}" for w in ("posted", "planned"))
        held = ", ".join(f"{100 * r['within'][w]:.0f} %" for w in ("posted", "planned"))
        lines.append(
            f"| {r['draw']}, {r['kind']} | {', '.join(r['effects'][1:])} | {found} | {r['field_posted'][1]:.3f} "
            f"| {sizes} | {100 * removed(r, 'both'):.0f} % | {told_of} | {held} |"
        )
    return "\n".join([*lines, "", f"{len(rows)} cells.", "", *shares(rows), *by_kind(rows), *_withheld(every)]) + "\n"


def _withheld(every: list[dict[str, Any]]) -> list[str]:
    """Cells whose diagnosis lacked an effect, beside the same ones with it; 95 %, mm."""
    with_it = {r["draw"]: r for r in every if r["family"] == FAMILY}
    rows = sorted((r for r in every if r["family"] == WITHHELD and r["draw"] in with_it), key=lambda r: r["draw"])
    if not rows:
        return []
    lines = [
        "",
        "## The same, diagnosed without one of the effects (`--withhold`)",
        "",
        "95 %, mm; behind the comma with the whole library.",
        "",
        f"| cell | withheld | found | {' | '.join(WAYS)} | predicted, as posted | in band, posted | planned |",
        f"| --- | --- | --- |{' --- |' * len(WAYS)} --- | --- | --- |",
    ]
    for r in rows:
        o = with_it[r["draw"]]
        sizes = " | ".join(f"{r[k][1]:.3f}, {o[k][1]:.3f}" for k in WAYS)
        held = " | ".join(f"{100 * r['within'][w]:.0f} %, {100 * o['within'][w]:.0f} %" for w in ("posted", "planned"))
        found = ", ".join(e for e in r["claimed"] if e != "corner_rounding") or "nothing"
        ahead = f"{r['likely']['posted'][1]:.3f}, {o['likely']['posted'][1]:.3f}"
        lines.append(f"| {r['draw']}, {r['kind']} | {', '.join(r['without'])} | {found} | {sizes} | {ahead} | {held} |")
    return [*lines, "", f"{len(rows)} cells.", "", *shares(rows)]


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--cells", type=int, default=40)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--withhold", action="store_true")
    parser.add_argument("--table", action="store_true")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    if options.table:
        (Path(__file__).resolve().parent / "surface_table.md").write_text(
            table(read_rows(options.out / "surface.jsonl"))
        )
        return
    add_rows(
        options.out / "surface.jsonl", [WITHHELD if options.withhold else FAMILY], options.cells, one, options.first
    )


if __name__ == "__main__":
    main()
