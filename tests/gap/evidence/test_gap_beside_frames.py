"""Where shapes of the unknown are looked for in poses whose frames nobody reported: arm and poses made by hand."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from stranger_arms import KR
from stranger_kinds import still
from test_gap_strangers import cell_of

from camrob.cell.read_cell import read_cell
from camrob.gap.effects.registry import library
from camrob.gap.evidence.beside_frames import beside_frames
from camrob.gap.evidence.comparison import compare, panels_for
from camrob.gap.evidence.scan import shapes
from camrob.gap.observation.scene import make_scene
from camrob.measurement.read_log import read_log

ZEROS = [e for e in library() if e.name == "joint_offset"]


def test_a_wrong_ratio_is_among_the_two_that_are_tried_beside_frames_alone(tmp_path: Path) -> None:
    """A3 turns by a thousandth more than it says; what the frames were laid out on is fitted to that."""
    case = still(KR, 60, axes=lambda q: q * (1.0 + 1e-3 * (np.arange(q.shape[1]) == 2)))
    (tmp_path / "set.csv").write_text(case.logs[0][1])
    (tmp_path / "set.toml").write_text(case.logs[0][2])
    scene = make_scene(read_log(tmp_path / "set.csv"), read_cell(cell_of(KR, tmp_path)))
    model = compare([scene], ZEROS)
    # as they were before anything was found
    kept = [np.ones(len(scene), np.bool_)]
    first = panels_for([scene], model.noises, kept, model.units, model.effects, model.states, model.basis)
    model = replace(model, panels=first)
    found = shapes(model.panels, [p.y_tcp for p in model.panels], [None], 1.0, 1e-5, 8)
    as_laid_out, beside = ([(s.target, s.quantity) for s in all_[:2]] for all_ in (found, beside_frames(model, found)))
    assert ("A3", "A3") in beside
    assert ("A3", "A3") not in as_laid_out
