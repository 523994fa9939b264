"""At which axis a shape of the unknown sits, and what it follows, as one of the regimes."""

from __future__ import annotations

from camrob.cell.joint import Joint, Role
from camrob.gap.effects.common import arm_axes
from camrob.gap.evidence.model import Model
from camrob.gap.evidence.unknown import CONSTANT, FORCE, LAST_MOVE, LOAD, is_moment
from camrob.summaries.diagnosis_summary import Unknown

__all__ = ["regime_followed", "sits_at", "suspects"]

_BY_MOTION = ("speed of", "direction of")  # how a quantity begins that an axis's own drive and gear make


def suspects(model: Model, unknown: Unknown) -> list[str]:
    """Axes whose own motion may show what is unexplained: those that it moves, and those that it follows."""
    named = [a for s in unknown.shapes for a in (sits_at(s.moves, s.follows, model), s.moves, _followed(s.follows))]
    return [a for a in dict.fromkeys([*named, *unknown.where.axes]) if a in model.scenes[0].axes]


def sits_at(moves: str, follows: str, model: Model) -> str:
    """The axis at which a shape behind the encoders sits: the one that it follows where it moves no axis, or another one with its
    speed or its side, or an axis of the arm by the motion of a carriage or a table, of which an arm knows nothing, or one that
    slides by the place of another that does: that one's guide is not straight; or the arm's last one, whose angle moves an axis
    before it by hoses that it winds, or by what is held askew.
    """
    scene, axis = model.scenes[0], _followed(follows)
    joints = {a: scene.cell.joints[scene.cell.index(a)] for a in (moves, axis) if a in scene.axes}
    if moves not in joints:
        return axis
    if axis not in joints:
        return moves
    by_motion = follows.startswith(_BY_MOTION)
    wound = follows == axis and axis in arm_axes(scene.cell)[-1:]
    return axis if _of_others(joints[moves], joints[axis], follows == axis) or by_motion or wound else moves


def _of_others(moves: Joint, axis: Joint, by_place: bool) -> bool:
    """Whether what an axis does by another one is that one's: a carriage or table knows of no arm, and a guide of no other."""
    foreign = moves.role is Role.ARM and axis.role in (Role.CARRIAGE, Role.WORKPIECE)
    return foreign or (by_place and moves.prismatic and axis.prismatic)


def _followed(follows: str) -> str:
    """The axis that a shape follows, itself or in its speed, direction or torque."""
    return follows.rpartition(" ")[2]


def regime_followed(follows: str) -> str:
    """What a shape follows, as one of the regimes; "" for a constant."""
    if is_moment(follows):
        return "time"
    kind, _, axis = follows.rpartition(" ")
    named = {"torque on": "load", "force": "force", LAST_MOVE: "direction"}.get(kind, kind.removesuffix(" of"))
    return named or {CONSTANT: "", LOAD: LOAD, FORCE: FORCE, "time": "time", "temperature": "temperature"}.get(
        axis, "position"
    )
