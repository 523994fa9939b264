"""The gap by stage: program to set-point, set-point to encoder, encoder to measured TCP; the vectors add up to the whole."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.error_model import ErrorModel
from camrob.gap.observation.program_track import ProgramTrack
from camrob.gap.observation.scene import Scene
from camrob.measurement.log_info import MeasuredFrame
from camrob.units import deg_to_rad

__all__ = ["STAGES", "StageGaps", "lacking", "stage_gaps"]

Array = NDArray[np.float64]

_WHOLE_ARM = 5  # axes that turn: of fewer, small swings are ordinary
_A_TURN, _SOME_OF_IT = deg_to_rad(2.0 * np.pi), deg_to_rad(0.5)  # as they read, were the numbers radians

STAGES = ("program_to_setpoint", "setpoint_to_encoder", "encoder_to_tcp")


@dataclass(frozen=True)
class StageGaps:
    """Vectors (N, 3) at the TCP, m, in the measured frame; None where the log lacks a stage.

    Where set-points are absent, the first two stages are one, given as None for program to set-point and None for the second; the
    whole is the sum of what is there. whole: measured less the program's place (less the nominal pose, without a program).
    """

    program_to_setpoint: Array | None
    setpoint_to_encoder: Array | None
    encoder_to_tcp: Array | None
    whole: Array
    missing: tuple[str, ...]

    def rms(self) -> dict[str, float | None]:
        """m of every stage, None where it is missing."""
        parts = {name: getattr(self, name) for name in STAGES}
        return {n: None if v is None else float(np.sqrt(np.mean(np.sum(v**2, axis=1)))) for n, v in parts.items()}


def stage_gaps(scene: Scene, track: ProgramTrack | None, *, why: str = "no program") -> StageGaps:
    """The gap of one log by stage. track: its program, laid beside it; why: what is said where there is none."""
    missing: list[str] = []
    at_link = scene.nominal[:, :3, 3]
    second: Array | None = None
    commanded = at_link
    if scene.encoder is not None and scene.setpoint is not None:
        commanded = _nominal(scene)
        second = at_link - commanded
    elif scene.setpoint is None:
        goals = scene.encoder is not None and scene.log.has(*(f"c{a}" for a in scene.axes)) and not scene.poses
        what = "no set-points, but goals that jump" if goals else "no set-points"
        missing.append(f"{what}: what the drives do can't be told from what the arm does before the encoders")
    else:
        missing.append(
            "no encoders: drives and arm can't be told apart, so lag looks like latency and friction like play"
        )
    third = scene.tcp_gap[:, :3] if scene.tracked else np.zeros_like(at_link)
    if not scene.tracked:
        missing.append("no measured pose: what the arm does behind its encoders can't be seen")
    first: Array | None = None
    if track is None:
        missing.append(f"{why}: corner rounding and errors of the post can't be seen")
    else:
        first = track.offset(track.path(0.0))
    whole = third + (0.0 if second is None else second) + (0.0 if first is None else first)
    return StageGaps(first, second, third if scene.tracked else None, whole, tuple(missing))


def lacking(scene: Scene) -> tuple[str, ...]:
    """What else a log and its cell lack besides stages, and what that costs."""
    sentences = []
    if scene.poses:
        sentences.append("single poses: what depends on speed can't be seen, and direction is that of the last move")
    if scene.tracked and not scene.seen[:, 3:].any():
        sentences.append("no orientation: the tool's angles and A6 can't be told apart")
    if scene.sight is not None:
        seen = f"{3.0 * scene.share:.2g} of three coordinates"
        sentences.append(f"{seen}: what moves the tool across what was measured can't be seen, and counts in no size")
    if scene.temperature is None:
        how = "can't be judged" if scene.poses else "is judged by the time since the log began"
        sentences.append(f"no temperature: warming up {how}")
    if scene.force is None:
        sentences.append("no forces: what cutting forces bend can't be seen")
    if not scene.cell.masses:
        sentences.append(
            "no masses in the cell: what gives way under gravity can't be told apart: compliance, a leaning foot, another load"
        )
    if not scene.tracked and _may_be_radians(scene):
        sentences.append(
            "no pose to check units by: no axis leaves 6.3 degrees; were these radians (angles in [table] of the .toml), all "
            "sizes would be 57 times as large"
        )
    return tuple(sentences)


def _may_be_radians(scene: Scene) -> bool:
    """Whether a whole arm stays within what a turn is in radians, and moves a good deal of it."""
    turning = [k for k, a in enumerate(scene.axes) if not scene.cell.joints[scene.cell.index(a)].prismatic]
    values = scene.link[:, turning]
    if len(turning) < _WHOLE_ARM:
        return False
    return float(np.abs(values).max()) <= _A_TURN and float(np.ptp(values, axis=0).max()) > _SOME_OF_IT


def _nominal(scene: Scene) -> Array:
    """(N, 3) nominal TCP at the set-points, in the measured frame."""
    cell = scene.cell
    in_base = scene.log.info.measured_frame is MeasuredFrame.BASE
    model = ErrorModel.of(cell, [], in_base=in_base, left=scene.frames.left, right=scene.frames.right)
    q = cell.to_q(scene.log.setpoints(scene.axes))
    return model.poses(np.zeros(0), q)[:, :3, 3]
