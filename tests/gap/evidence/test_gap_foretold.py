"""What is foretold of withheld samples is what stays where the logs were fitted: at the drives too, and without what cancels."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from stranger_arms import DEG, TICK, UR
from stranger_kinds import run
from test_gap_strangers import cell_of

from camrob.cell.read_cell import read_cell
from camrob.gap.effects.registry import library
from camrob.gap.evidence.comparison import compare
from camrob.gap.evidence.predicted import expected, foretold
from camrob.gap.evidence.shrink import shrinkage, trial_of
from camrob.gap.observation.scene import make_scene
from camrob.measurement.read_log import read_log


def shaken(command: np.ndarray) -> np.ndarray:
    """Encoders that are all off their set-points by 0.01 degrees in a way that nothing in the library is."""
    t = TICK * np.arange(len(command))
    return command + 0.01 * DEG * np.sin(2.0 * np.pi * t[:, None] * np.linspace(0.7, 2.3, command.shape[1]))


@pytest.mark.parametrize("off", [True, False])
def test_what_stays_at_the_drives_is_foretold(off: bool, tmp_path: Path) -> None:
    case = run(UR, reach=shaken) if off else run(UR)
    (tmp_path / "run.csv").write_text(case.logs[0][1])
    (tmp_path / "run.toml").write_text(case.logs[0][2])
    scene = make_scene(read_log(tmp_path / "run.csv"), read_cell(cell_of(case.machine, tmp_path)))
    model = compare([scene], [e for e in library() if e.name == "measurement_scale"])
    trial = trial_of(model, [scene])
    _, after = expected(model, trial, frozenset())
    assert after == pytest.approx(shrinkage(model, trial, frozenset()).rms_after, rel=0.1)


@pytest.mark.parametrize("named", [True, False])
def test_what_is_foretold_is_what_blocks_show_that_a_fit_leaves_out(named: bool, tmp_path: Path) -> None:
    """Beside a zero that is off a wave stays that a smooth leftover takes up where it was fitted, and nowhere else."""
    case = run(UR, reach=shaken)
    (tmp_path / "run.csv").write_text(case.logs[0][1])
    (tmp_path / "run.toml").write_text(case.logs[0][2])
    scene = make_scene(read_log(tmp_path / "run.csv"), read_cell(cell_of(case.machine, tmp_path)))
    model = compare([scene], [e for e in library() if e.name in ("measurement_scale", "joint_offset")])
    trial, blocks = trial_of(model, [scene] if named else []), trial_of(model, ())
    keep = frozenset(i for i in model.best.members if model.units[i].effect != "unknown")
    before, after = foretold(model, trial, blocks, keep)
    reached = shrinkage(model, blocks, model.best.members, keep)
    assert after >= reached.rms_after * (1.0 if named else 0.9) - 1e-12
    assert before == pytest.approx(reached.rms_before, rel=0.25)
