"""Sets of single poses: frames fitted where poses were fitted, and frozen where they are withheld; whole postures withheld."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.gap.evidence.design import Panel, pool
from camrob.gap.evidence.model import Model
from camrob.gap.evidence.shrink import Trial
from camrob.gap.nuisances import NUISANCE
from camrob.gap.observation.scene import Scene, make_scene
from camrob.gap.observation.unknown_frames import Frames, left_twists, right_twists
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_units import check_turns
from camrob.se3 import exp
from camrob.units import deg_to_rad

__all__ = ["fitted_scenes", "frozen_frames", "relaid_scenes", "with_whole_postures", "withheld_scene"]

Array = NDArray[np.float64]

FEWEST = 4  # poses of a withheld log whose frame and target are known
_SAME_POSTURE = deg_to_rad(0.05)  # and m / 1000: axes that differ by less stand where they stood
_RANK = 1e-9
_BENT = 0.3  # of the noise: what a frame's turn may be off its straight line


def fitted_scenes(logs: Sequence[MeasurementLog], cells: Sequence[Cell]) -> tuple[Scene, ...]:
    """Logs laid out, each on its cell. One that names another's frame or target (LOG.toml) as its own starts from those, and is
    moved with them when they are fitted: `make_panel` gives it the columns of the other's.

    Raises LogError as `make_scene` does, and for an axis at no angle in degrees.
    """
    scenes: list[Scene] = []
    for log, cell in zip(logs, cells, strict=True):
        check_turns(log, cell.turning_names)
        scenes.append(make_scene(log, cell, known=_frames_of(log, scenes), fitted=True))
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

    Raises LogError as `make_scene` does, and for an axis at no angle in degrees.
    """
    check_turns(log, cell.turning_names)
    return make_scene(log, cell, known=_frames_of(log, scenes), least=FEWEST)


def _named(scenes: Sequence[Scene], name: str) -> Scene | None:
    return next((s for s in scenes if name and s.name == name), None)


def relaid_scenes(model: Model) -> tuple[Scene, ...]:
    """The logs laid out with their frames where the best set puts them, where it moves these by so much that turns no longer add
    up: what a zero of two degrees does to frames that were fitted without it would else go to another name. () for small ones.
    """
    scenes, far = [], False
    for k, scene in enumerate(model.scenes):
        twists = [_twist(model, scene, k, side) for side in (0, 1)]
        L, R = scene.frames.left, scene.frames.right
        frames = Frames(exp(twists[0]) @ L, R @ exp(twists[1]), scene.frames.fitted_left, scene.frames.fitted_right)
        scenes.append((scene, frames))
        there = exp(twists[0]) @ scene.nominal @ exp(twists[1])
        straight = left_twists(scene.nominal) @ twists[0] + right_twists(scene.nominal) @ twists[1]
        bend = scene.told(there[:, :3, 3] - scene.nominal[:, :3, 3] - straight[:, :3])
        far |= float(np.sqrt(np.mean(np.sum(bend**2, axis=1)))) > _BENT * model.noise
    return tuple(make_scene(s.log, s.cell, laid=frames, least=len(s)) for s, frames in scenes) if far else ()


def _twist(model: Model, scene: Scene, number: int, side: int) -> Array:
    """(6,) by which the best set moves a log's frame (side 0) or target (1); 0 where that is known."""
    name = (scene.log.info.same_frame_as, scene.log.info.same_target_as)[side]
    for i, unit in enumerate(model.units):
        owner, _, log = unit.key.partition("|")
        which = owner.removeprefix(("left", "right")[side])
        if unit.effect == NUISANCE and (which == str(number) or (name and which.isdigit() and log == name)):
            return np.asarray(model.best.mean[model.design.owner == i])
    return np.zeros(6)


def frozen_frames(model: Model, trial: Trial) -> Trial:
    """The trial of sets of poses, and of runs of which a part of each place was measured, with the frames that are not known
    fitted to the rows that are not asked, and frozen.

    What the frames take up of the gap, and of each effect, where they are fitted, is taken from it where it is asked; so
    the gap before and after an effect is what frames of the fitted poses leave there. Paths, whose blocks are long, and
    withheld logs with frames of their own stay as they are.
    """
    panels, solved = list(trial.panels), dict[int | None, dict[tuple[int, str], Array]]()
    for k, rows, left_out in trial.asked:
        panel = panels[k]
        if not _frames_kept(panel.scene):
            continue
        if left_out not in solved:
            solved[left_out] = _taken(model.panels, left_out)
        for side, named in enumerate((panel.scene.log.info.same_frame_as, panel.scene.log.info.same_target_as, "")):
            name = _owner(panel.scene, side, model.scenes) if left_out is not None else named
            taken = solved[left_out].get((side, name))
            if left_out is not None or taken is not None:
                panel = _frozen(model, panel, rows, side, np.zeros((1, 1)) if taken is None else taken)
        panels[k] = panel
    return replace(trial, panels=tuple(panels))


def _frames_kept(scene: Scene) -> bool:
    """Whether a log's own frames are fitted to some of its rows and kept for the others: to single poses, or to distances and
    the like, of a stretch of which a frame would take all.
    """
    return scene.poses or scene.sight is not None


def _owner(scene: Scene, side: int, scenes: Sequence[Scene]) -> str:
    """The log whose frame (side 0) or target (1) is a log's own: the one that it names, or itself."""
    name = (scene.log.info.same_frame_as, scene.log.info.same_target_as, "")[side]
    return name if _named(scenes, name) is not None else scene.name


def _frozen(model: Model, panel: Panel, rows: NDArray[np.bool_], side: int, taken: Array) -> Panel:
    """A panel whose gap and columns at `rows` are less what the frame of one side (0 left, 1 right, 2 the zero of distances)
    makes there, as it takes up each column where it was fitted (`_taken`; (6, K + 1), or zeros where it was not). Columns of that
    frame are 0: nothing is left for it to settle.
    """
    twists = _twists(panel.scene, side)[rows]
    moved = np.einsum("nij,jk->nik", twists, np.broadcast_to(taken, (twists.shape[2], panel.tcp.shape[2] + 1)))
    y, tcp = np.array(panel.y_tcp), np.array(panel.tcp)
    y[rows] -= moved[..., -1]
    tcp[rows] -= moved[..., :-1]
    name = ("left", "right", "zero")[side]
    frame = [i for i, u in enumerate(model.units) if u.effect == NUISANCE and u.key.startswith(name)]
    tcp[np.ix_(np.flatnonzero(rows), np.arange(6), np.flatnonzero(np.isin(model.design.owner, frame)))] = 0.0
    return replace(panel, tcp=tcp, y_tcp=y)


def _twists(scene: Scene, side: int) -> Array:
    """(N, 6, k): how a log's frame, its target, or the zero of its distances moves what was measured."""
    return scene.longer[:, :, None] if side == 2 else scene.told((left_twists, right_twists)[side](scene.nominal))


def _taken(panels: Sequence[Panel], left_out: int | None) -> dict[tuple[int, str], Array]:
    """By side (as in `_frozen`) and log, the twists (6, K + 1) by which its frame takes up each column, and the gap, on all
    poses but those of a block: together, as logs may share a frame or a target.
    """
    own = [p for p in panels if _frames_kept(p.scene)]
    scenes = [p.scene for p in own]
    free = [
        (side, s.name)
        for s in scenes
        for side, fitted in enumerate((s.frames.fitted_left, s.frames.fitted_right, s.zero_open))
        if fitted
    ]
    if not free:
        return {}
    A, B = [], []
    for p in own:
        at = p.block != left_out
        w = p.w_tcp[at][..., None]
        X = np.zeros((int(at.sum()), 6, 6 * len(free)))
        for side in range(3):
            key = side, _owner(p.scene, side, scenes)
            if key in free:
                first = 6 * free.index(key)
                twists = _twists(p.scene, side)[at]
                X[:, :, first : first + twists.shape[2]] = twists
        Y = np.concatenate([p.tcp, p.y_tcp[..., None]], axis=2)[at]
        A.append((X * w).reshape(-1, X.shape[2]))
        B.append((Y * w).reshape(-1, Y.shape[2]))
    solved = np.linalg.lstsq(np.concatenate(A), np.concatenate(B), rcond=_RANK)[0]
    return {key: solved[6 * k : 6 * k + (1 if key[0] == 2 else 6)] for k, key in enumerate(free)}


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
    design = pool(panels, model.units, model.basis).design()
    return replace(model, panels=panels, design=design, evidence=replace(model.evidence, design=design))
