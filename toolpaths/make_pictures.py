"""Draws README's pictures of the samples: `python toolpaths/make_pictures.py` rewrites toolpaths/*/*.png.

conditioning.png is the paper's Figure 10 our way: 1/k_F along the path as posted, with all weights alike, and without
revision. overview.png shows the cell at work on the carving.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh

from camrob.cell.read_cell import read_cell
from camrob.jobs.files.inputs import read_inputs
from camrob.redundancy.published.virtual_joint import resolve_vjm
from camrob.redundancy.published.weighting import even_weights
from camrob.report.page.figures import figure_conditioning, figure_overview

HERE = Path(__file__).resolve().parent
CELL = HERE.parent / "cells" / "kr15_track_table"
SAMPLES = ("carving", "relief", "engraving", "globe")


def main() -> None:
    machine = read_cell(CELL)
    for name in SAMPLES:
        job = read_inputs(HERE / name / f"{name}.cls", machine, None)
        solution = resolve_vjm(job.cell, job.path)
        others = {
            "all weights alike": np.asarray(resolve_vjm(job.cell, job.path, weighting=even_weights(job.cell)).inv_kf),
            "without revision": np.asarray(resolve_vjm(job.cell, job.path, revise=False).inv_kf),
        }
        names = {k: region.name for k, region in enumerate(job.toolpath.regions)}
        figure_conditioning(
            job.path,
            solution,
            file=HERE / name / "conditioning.png",
            threshold=job.cell.resolve.threshold,
            names=names,
            comparison=others,
        )
        if name == "carving":
            mesh = trimesh.Trimesh(**trimesh.triangles.to_kwargs(job.part))
            at = int(np.flatnonzero(job.path.region == 0)[2200])
            figure_overview(
                job.cell,
                job.path,
                solution,
                file=HERE / name / "overview.png",
                point=at,
                part_mesh=mesh,
                base_T_part=np.asarray(job.setup.base_T_part),
            )


if __name__ == "__main__":
    main()
