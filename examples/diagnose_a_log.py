"""Run a sample on the ideal controller, plant an error in its log, and let the diagnosis find it.

    .venv/bin/python examples/diagnose_a_log.py [OUT]

The error: the instrument's clock is 40 ms off the controller's, so that each measured pose is where the tool was 40 ms before.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from camrob import DiagnosisSummary, MeasurementLog, diagnose, post, simulate
from camrob.measurement.write_log import write_log

ROOT = Path(__file__).resolve().parents[1]
CELL = ROOT / "cells" / "kr15_track_table"
CYCLE = 40.0  # ms between two rows: the pose comes one row late
ROWS = 750  # the first half minute, which is enough
NOISE = 0.02  # mm an axis, standard deviation


def late(log: MeasurementLog) -> MeasurementLog:
    """The log as an instrument gives it that is one row late and has some noise."""
    rng = np.random.default_rng(1)
    columns = {name: values[1 : ROWS + 1] for name, values in log.columns.items()}
    for name in ("x", "y", "z", "a", "b", "c"):
        columns[name] = log.columns[name][:ROWS]
    for name in ("x", "y", "z"):
        columns[name] = columns[name] + rng.normal(0.0, NOISE, ROWS)
    return MeasurementLog(columns, log.info)


def diagnosed(out: Path) -> DiagnosisSummary:
    """Post, simulate, plant, diagnose: the diagnosis's summary. `out` receives all files."""
    post(ROOT / "toolpaths" / "engraving" / "engraving.cls", cell=CELL, out=out, report=False)
    run = simulate(out / "engraving.src", cell=CELL, out=out / "ideal.csv", cycle_ms=CYCLE)
    write_log(late(run.simulation.log), out / "measured.csv")
    return diagnose(cell=CELL, log=[out / "measured.csv"], out=out).summary


def main(out: Path) -> None:
    """Print what the diagnosis says."""
    found = diagnosed(out)
    print(f"gap: {found.gap.rms_mm:.3f} mm rms; with what is named: {found.together.rms_after_mm:.3f} mm")
    for effect in found.effects:
        values = ", ".join(f"{name} {one.value:.5g}" for name, one in effect.parameters.items())
        print(f"{effect.effect}: {values} ({effect.probability:.0%} sure)")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "out" / "diagnose_a_log")
