"""The published loop, as it stands in the paper: the slow reference that the follower's postures are held to.

Algorithm 1 with eq. 11, 12 and 15 to 20 in plain NumPy, a posture at a time. It creeps: with the null-space term inside
the loop and a weight of 0.01 a step shrinks by about 1 % an iteration, so that the answer depends on where the loop is
stopped. It knows no joint limits either. Programs are made by
`camrob.redundancy.following.follower`, which goes straight to where this loop ends.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.cell.redundancy_settings import FuzzyEngine
from camrob.errors import UnreachableError
from camrob.frozen import locked
from camrob.kinematics.frames import base_T_flange, base_T_joint_frames, base_T_tool
from camrob.redundancy.fuzzy.fis import read_fis

Array = NDArray[np.float64]
Weights = Callable[[Array], Array]
"""The diagonal (n,) of a weighting matrix, from a posture q (n,)."""

MOST_ITERATIONS = 5_000  # some twenty times the 230 that the published gains take to 1e-6


@dataclass(frozen=True, slots=True)
class TwinState:
    """Where the loop stands: q (n,), and the posture (n,) recorded as 1/k_F fell below the threshold, None above it."""

    q: Array
    q_threshold: Array | None = None


@dataclass(frozen=True, slots=True)
class TwinPath:
    """Postures q (N, n) with 1/k_F (N,), and the lengths (rad, m) of the loop's steps, one array a point."""

    q: Array
    inv_kf: Array
    steps: tuple[Array, ...]
    state: TwinState

    def __post_init__(self) -> None:
        object.__setattr__(self, "q", locked(self.q, shape=(None, None), name="q"))
        object.__setattr__(self, "inv_kf", locked(self.inv_kf, shape=(len(self.q),), name="inv_kf"))

    @property
    def iterations(self) -> NDArray[np.int64]:
        """(N,) how many iterations each point took."""
        return np.array([len(s) for s in self.steps])


def engine_weights(cell: Cell, engine: FuzzyEngine) -> Weights:
    """The weights that a fuzzy engine gives a posture, evaluated by scikit-fuzzy at every call. Raises CellError."""
    system = read_fis(cell.folder / engine.file)
    places = [cell.axis_names.index(variable.name) for variable in system.inputs]
    names = [variable.name for variable in system.outputs]

    def weights(q: Array) -> Array:
        outputs = system.evaluate(cell.to_axis_values(q)[places])
        diagonal = np.full(len(cell), engine.default_weight)
        for joint, output in engine.weights.items():
            diagonal[cell.index(joint)] = outputs[names.index(output)]
        return diagonal

    return weights


def follow_as_published(
    cell: Cell,
    base_T_target: Array,
    start: TwinState,
    *,
    joint_weights: Weights,
    condition_weights: Weights,
    q_reference: Array,
    epsilon: float = 1e-4,
) -> TwinPath:
    """Follow poses (N, 4, 4) by Algorithm 1 from a state, each until a step is no longer than `epsilon` (rad and m).

    Raises UnreachableError where a point takes more than `MOST_ITERATIONS`.
    """
    state = start
    postures, conditions, lengths = [], [], []
    for k, target in enumerate(base_T_target):
        steps: list[float] = []
        while not steps or steps[-1] > epsilon:
            if len(steps) == MOST_ITERATIONS:
                raise UnreachableError(f"the published loop does not settle at point {k} of the path")
            dq, state = _iteration(cell, target, state, joint_weights, condition_weights, q_reference)
            state = TwinState(state.q + dq, state.q_threshold)  # step 10
            steps.append(float(np.linalg.norm(dq)))
        postures.append(state.q)
        conditions.append(_inverse_kf(cell, state.q))
        lengths.append(np.array(steps))
    return TwinPath(np.array(postures), np.array(conditions), tuple(lengths), state)


def _iteration(
    cell: Cell, target: Array, state: TwinState, joint_weights: Weights, condition_weights: Weights, q_reference: Array
) -> tuple[Array, TwinState]:
    """Steps 3 to 9: the step (n,) of one iteration, and the state with the threshold's posture brought up to date."""
    q = state.q
    T = base_T_tool(cell, q)
    Q, p = T[:3, :3], T[:3, 3]
    twist = np.concatenate([target[:3, 3] - p, Q @ _vect(Q.T @ target[:3, :3])])
    J = _jacobian(cell, q, p)
    inv_kf = _inverse_kf(cell, q)
    recorded = None
    if inv_kf < cell.resolve.threshold:
        recorded = q if state.q_threshold is None else state.q_threshold
    h = -joint_weights(q) * _apart(cell, q, q_reference)  # eq. 20
    if recorded is not None:
        h = h - condition_weights(q) * _apart(cell, q, recorded) / inv_kf  # eq. 18, added by eq. 15
    pseudo_inverse = J.T @ np.linalg.inv(J @ J.T)
    dq = pseudo_inverse @ twist + h - pseudo_inverse @ (J @ h)  # eq. 12
    return dq, TwinState(q, recorded)


def _vect(R: Array) -> Array:
    """The axial vector (3,) of a rotation: sine of the angle times its axis."""
    return 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])


def _apart(cell: Cell, q: Array, reference: Array) -> Array:
    """q - reference (n,), to the nearest turn where a joint is endless."""
    d = q - reference
    return np.asarray(np.where(cell.endless, d - 2.0 * np.pi * np.round(d / (2.0 * np.pi)), d))


def _joint_axes(cell: Cell, q: Array) -> tuple[Array, Array]:
    """Axes (n, 3) and points on them (n, 3) in `base`, from the frames that the joints' rows end in."""
    frames = base_T_joint_frames(cell, q)
    last = cell.indices(Role.ARM)[-1]
    axes = []
    base_T_row = np.asarray(cell.base_T_first)  # frames: row is first
    for i, joint in enumerate(cell.joints):
        base_T_joint = base_T_row @ joint.before  # frames: row ends where the joint begins
        axes.append(base_T_joint[:3, 2:4])
        base_T_row = frames[i] if i != last else frames[i] @ cell.wrist_T_flange @ cell.flange_T_tool
    both = np.array(axes)
    return both[..., 0], both[..., 1]


def _jacobian(cell: Cell, q: Array, point: Array) -> Array:
    """Geometric Jacobian (6, n), rows (v, w), of a point (3,) of the tool."""
    axes, points = _joint_axes(cell, q)
    prismatic = np.array([joint.prismatic for joint in cell.joints])[:, None]
    v = np.where(prismatic, axes, np.cross(axes, point - points))
    w = np.where(prismatic, 0.0, axes)
    return np.concatenate([v, w], axis=1).T


def _inverse_kf(cell: Cell, q: Array) -> float:
    """1/k_F by eq. 16: the bare arm's columns at the mounting plate, lengths divided by the characteristic length."""
    H = _jacobian(cell, q, base_T_flange(cell, q)[:3, 3])[:, cell.arm_slice]
    H[:3] /= cell.condition_length
    HHT = H @ H.T
    return float(6.0 / np.sqrt(np.trace(HHT) * np.trace(np.linalg.inv(HHT))))
