"""Sets of single poses: frames fitted where poses were fitted, and frozen where they are withheld; whole postures withheld."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.gap.evidence.design import NUISANCE, Panel, pool
from camrob.gap.evidence.model import Model
from camrob.gap.evidence.shrink import Trial
from camrob.gap.observation.scene import Scene, make_scene
from camrob.gap.observation.unknown_frames import Frames, left_twists, right_twists
from camrob.measurement.log import MeasurementLog
from camrob.units import deg_to_rad

__all__ = ["fitted_scenes", "frozen_frames", "with_whole_postures", "withheld_scene"]

Array = NDArray[np.float64]

FEWEST = 4  # poses of a withheld log whose frame and target are known
_SAME_POSTURE = deg_to_rad(0.05)  # and m / 1000: axes that differ by less stand where they stood
_RANK = 1e-9


def fitted_scenes(logs: Sequence[MeasurementLog], cells: Sequence[Cell]) -> tuple[Scene, ...]:
    """Logs laid out, each on its cell. One that names another's frame or target (LOG.toml) as its own starts from those, and is
    moved with them when they are fitted: `make_panel` gives it the columns of the other's.

    Raises LogError as `make_scene` does.
    """
    scenes: list[Scene] = []
    for log, cell in zip(logs, cells, strict=True):
        scenes.append(make_scene(log, cell, known=_frames_of(log, scenes)))
    return tuple(scenes)


def _frames_of(log: MeasurementLog, scenes: Sequence[Scene]) -> Frames:
    """Frame and target of the logs that a log names as having its own, open where it names none."""
    left, right = _named(scenes, log.info.same_frame_as), _named(scenes, log.info.same_target_as)
    return Frames(
        left.frames.left if left is not None else np.eye(4),
        right.frames.right if right is not None else np.eye(4),
        fitted_left=left is None,
        fitted_right=right is None,
    )


def withheld_scene(log: MeasurementLog, cell: Cell, scenes: Sequence[Scene]) -> Scene:
    """A withheld log laid out; frame and target are those of the fitted logs that its LOG.toml names, and then 4 poses do.

    Raises LogError as `make_scene` does.
    """
    return make_scene(log, cell, known=_frames_of(log, scenes), least=FEWEST)


def _named(scenes: Sequence[Scene], name: str) -> Scene | None:
    return next((s for s in scenes if name and s.name == name), None)


def frozen_frames(model: Model, trial: Trial) -> Trial:
    """The trial of sets of poses with the frames that nobody told fitted to the poses that are not asked, and frozen.

    What the frames take up of the gap, and of each effect, where they are fitted, is taken from it where it is asked; so
    the gap before and after an effect is what frames of the fitted poses leave there. Paths, whose blocks are long, and
    withheld logs with frames of their own stay as they are.
    """
    panels = list(trial.panels)
    for k, rows, left_out in trial.asked:
        panel, info = panels[k], panels[k].scene.log.info
        if not panel.scene.poses:
            continue
        own = trial.panels[k]
        told = (
            (own, own)
            if left_out is not None
            else (_panel(model, info.same_frame_as), _panel(model, info.same_target_as))
        )
        for side, source in enumerate(told):
            if source is not None:
                fitted = ~rows if left_out is not None else np.ones(len(source.scene), np.bool_)
                panel = _frozen(model, panel, rows, side, _taken(source, fitted))
        panels[k] = panel
    return replace(trial, panels=tuple(panels))


def _panel(model: Model, name: str) -> Panel | None:
    return next((p for p in model.panels if name and p.scene.name == name), None)


def _frozen(model: Model, panel: Panel, rows: NDArray[np.bool_], side: int, taken: Array) -> Panel:
    """A panel whose gap and columns at `rows` are less what the frame of one side (0 left, 1 right), as it takes up each column
    where it was fitted (`_taken`), makes there. Columns of that frame are 0: nothing is left for it to settle.
    """
    twists = (left_twists, right_twists)[side](panel.scene.nominal)[rows]
    moved = np.einsum("nij,jk->nik", twists, taken[6 * side : 6 * side + 6])
    y, tcp = np.array(panel.y_tcp), np.array(panel.tcp)
    y[rows] -= moved[..., -1]
    tcp[rows] -= moved[..., :-1]
    name = ("left", "right")[side]
    frame = [i for i, u in enumerate(model.units) if u.effect == NUISANCE and u.key.startswith(name)]
    tcp[np.ix_(np.flatnonzero(rows), np.arange(6), np.flatnonzero(np.isin(model.design.owner, frame)))] = 0.0
    return replace(panel, tcp=tcp, y_tcp=y)


def _taken(panel: Panel, rows: NDArray[np.bool_]) -> Array:
    """(12, K + 1) twists on the left and right by which frames take up each column, and the gap, at some rows."""
    frames = panel.scene.frames
    X = np.concatenate([left_twists(panel.scene.nominal), right_twists(panel.scene.nominal)], axis=2)[rows]
    free = np.repeat([frames.fitted_left, frames.fitted_right], 6)
    Y = np.concatenate([panel.tcp, panel.y_tcp[..., None]], axis=2)[rows]
    w = panel.w_tcp[rows][..., None]
    A, B = (np.reshape(c, (c.shape[0] * c.shape[1], c.shape[2])) for c in ((X * w)[..., free], Y * w))
    out = np.zeros((12, Y.shape[2]))
    out[free] = np.linalg.lstsq(A, B, rcond=_RANK)[0]
    return out


def with_whole_postures(model: Model) -> Model:
    """The model with blocks that no posture is cut by: rows of one posture, and other targets on it, are withheld together."""
    blocks = [np.array(p.block) for p in model.panels]
    for k, panel in enumerate(model.panels):
        scene = panel.scene
        if not scene.poses:
            continue
        names = [s.name for s in model.scenes[:k]]
        first = names.index(scene.log.info.same_poses_as) if scene.log.info.same_poses_as in names else None
        if first is not None:
            away = np.abs(scene.link[:, None] - model.scenes[first].link[None]).max(axis=2)
            nearest = np.argmin(away, axis=1)
            shared = np.where(away.min(axis=1) < _SAME_POSTURE, blocks[first][nearest], -1)
            known = np.flatnonzero(shared >= 0)
            if len(known):
                blocks[k] = shared[known[np.searchsorted(known, np.arange(len(scene))).clip(max=len(known) - 1)]]
        still = np.abs(np.diff(scene.link, axis=0)).max(axis=1) < _SAME_POSTURE
        for row in np.flatnonzero(still):
            blocks[k][row + 1] = blocks[k][row]
    if all(np.array_equal(b, p.block) for b, p in zip(blocks, model.panels, strict=True)):
        return model
    panels = tuple(replace(p, block=b) for p, b in zip(model.panels, blocks, strict=True))
    design = pool(panels, model.units, model.basis)
    return replace(model, panels=panels, design=design, evidence=replace(model.evidence, design=design))
