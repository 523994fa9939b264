"""A simulated run as the report draws it: a path with postures, times, and the program's lines."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from camrob.cell.cell import Cell
from camrob.checks.nearest import nearest_bodies
from camrob.controller.motion_settings import motion_settings
from camrob.controller.simulate import Simulation
from camrob.jobs.files.said_lines import said_lines
from camrob.kinematics.frames import world_T_base
from camrob.kinematics.kernels import chain_arrays, inverse_kf_many
from camrob.measurement.log import ORIENTATION, POSITION
from camrob.program.motion import Motion
from camrob.program.program_text import ProgramText
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.solution import Solution
from camrob.report.page.timeline import Run
from camrob.report.simulate.page import simulate_report
from camrob.se3 import abc_to_rotation, inverse
from camrob.summaries.simulate_summary import SimulateSummary
from camrob.toolpath.region import Move
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["run_report"]

MOST_ROWS = 60_000  # of the log that the page is made from, spread evenly: what a browser still plays easily

LOOKED = 600  # of these rows, at which the nearest bodies are looked for
_UNLINED = ("a move by axes", "along a line or an arc")


def run_report(folder: Path, text: ProgramText, cell: Cell, simulation: Simulation, summary: SimulateSummary) -> str:
    """The page of a run of a program whose files lie in `folder`."""
    log = simulation.log
    rows = np.unique(np.linspace(0, len(log) - 1, min(len(log), MOST_ROWS)).astype(int))
    values = {name: np.asarray(column)[rows] for name, column in log.columns.items()}
    at = values["t"]
    q = cell.to_q(np.stack([values[name] for name in cell.axis_names], axis=1))
    world_T_tip = np.tile(np.eye(4), (len(rows), 1, 1))
    world_T_tip[:, :3, 3] = mm_to_m(np.stack([values[name] for name in POSITION], axis=1))
    world_T_tip[:, :3, :3] = abc_to_rotation(deg_to_rad(np.stack([values[name] for name in ORIENTATION], axis=1)))
    base_T_tip = inverse(world_T_base(cell, q)) @ world_T_tip
    motion = np.asarray(simulation.motion)[rows]
    led = np.asarray(text.kind)[motion] >= Motion.LIN
    led[0] = False
    feed = np.where(led, motion_settings(text, cell).speed[motion], np.nan)
    step = np.linalg.norm(np.diff(base_T_tip[:, :3, 3], axis=0), axis=1)
    reached = np.append(0.0, step / np.maximum(np.diff(at), 1e-9))
    path = ToolPathInBase(
        base_T_tip,
        np.where(led, int(Move.CUT), int(Move.RAPID)).astype(np.int8),
        feed,
        np.zeros(len(rows), np.int64),  # the program's own lines are said beside the player
        np.zeros(len(rows), np.int32),
        np.arange(len(rows)),
        np.zeros(len(rows), np.bool_),
    )
    postures = Solution("simulated", q, inverse_kf_many(chain_arrays(cell), q), cell.digest, path.digest)
    looked = np.unique(np.linspace(0, len(rows) - 1, LOOKED).astype(np.int64))
    run = Run(at, said_lines(folder, text, motion), _UNLINED, nearest_bodies(cell, q[looked]), looked)
    return simulate_report(summary, cell, path, postures, run, reached)
