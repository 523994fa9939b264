"""One log laid out for the diagnosis: what was commanded, reported and measured, and how every small error would show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.error_model import ErrorModel
from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.gap.observation.goals import goal_axes
from camrob.gap.observation.gravity_loads import gravity_moments, gravity_on_axes
from camrob.gap.observation.signals import derivative, pieces_of, play, play_at_rest
from camrob.gap.observation.turns import without_turns
from camrob.gap.observation.unknown_frames import Frames, fit_frames
from camrob.measurement.log import FORCE, MeasurementLog
from camrob.measurement.log_info import MeasuredFrame, Target
from camrob.measurement.sight import Sight, sighted
from camrob.se3 import rotation_log
from camrob.units import deg_to_rad, m_to_mm, mm_to_m, rad_to_deg

__all__ = ["Scene", "axis_values", "make_scene"]

Array = NDArray[np.float64]

_GEARED = 0.05  # a motor's readings that go farther than the axis by more are counted in other units
_STILL_AXIS = 1e-3  # rad or m: an axis that moves by less tells no ratio

PLACES = ("x", "y", "z", "rx", "ry", "rz")
LEAST = 12  # samples that a log has at the least
_FRAME_POSES = 4  # of a set, for each frame that is not known: twice as many readings as a frame has numbers
_SIDE = deg_to_rad(0.02)  # way after which an axis counts as having turned round
ROOM_TEMPERATURE = 21.0  # degrees C at which a cell is taken to have its nominal lengths, where a log starts warmer


@dataclass(frozen=True)
class Scene:
    """N samples of one log. Axis values are SI in the controller's sign, a column an axis; twists (v, w) at the TCP, m and rad,
    in the measured frame.

    setpoint, encoder: (N, k) or None where the log lacks them; `link` is what the arm's side of the drives is reckoned
    from: encoders, else set-points. tcp_gap: (N, 6) measured less nominal at `link`; servo_gap: (N, k) encoders less
    set-points, None where one is missing. seen: (N, 6) True where measured. places: twists of a unit of every constant
    error; moments: (M, N, 2) gravity's moment of each of the cell's masses about x and y of `root` at the robot's foot, Nm;
    pieces: runs of samples without a hole in time; sigma: (6,) the instrument's noise, NaN where unknown; sight: what alone was
    measured of places, None for all: gap and twists hold no more.
    """

    name: str
    cell: Cell
    log: MeasurementLog
    t: Array
    axes: tuple[str, ...]
    setpoint: Array | None
    encoder: Array | None
    nominal: Array
    measured: Array
    tcp_gap: Array
    servo_gap: Array | None
    seen: NDArray[np.bool_]
    places: dict[str, Array]
    torque: Array
    moments: Array
    pieces: tuple[slice, ...]
    frames: Frames
    sigma: Array
    sight: Sight | None = None

    def __len__(self) -> int:
        return len(self.t)

    @property
    def link(self) -> Array:
        """(N, k) axis values that the arm's side of the drives is reckoned from."""
        chosen = self.encoder if self.encoder is not None else self.setpoint
        return np.asarray(chosen)

    @property
    def command(self) -> Array:
        """(N, k) set-points, encoders where they are absent."""
        chosen = self.setpoint if self.setpoint is not None else self.encoder
        return np.asarray(chosen)

    @property
    def poses(self) -> bool:
        """True where rows are single poses at rest."""
        return self.log.info.poses

    @property
    def tracked(self) -> bool:
        """True where an instrument measured poses; else `measured` is where the encoders put the tool."""
        return self.log.sees_place

    @property
    def share(self) -> float:
        """Coordinates of a place that a row tells, of three."""
        return 1.0 if self.sight is None else self.sight.share

    @property
    def zero_open(self) -> bool:
        """Whether a log's distances are all too long or too short by what is to be fitted."""
        return self.log.info.distance_zero_unknown and self.sight is not None and self.sight.center is not None

    @property
    def longer(self) -> Array:
        """(N, 6): how distances that are all longer by a unit move what was measured."""
        away = np.zeros((len(self), 3)) if self.sight is None else self.sight.away
        return np.concatenate([away, np.zeros_like(away)], axis=1)

    @property
    def sees(self) -> tuple[bool, bool, bool]:
        """Whether some row tells anything along x, y, z of the measured frame."""
        if self.sight is None:
            return True, True, True
        x, y, z = np.any(self.sight.onto != 0.0, axis=(0, 2))
        return bool(x), bool(y), bool(z)

    def told(self, twists: Array) -> Array:
        """Twists (N, 6, ..) or shifts (N, 3, ..) with what was measured of shifts alone; themselves where that is all."""
        return twists if self.sight is None else self.sight.of(twists)

    def motor(self, axis: str) -> Array | None:
        """(N,) the motor-side encoder of an axis, SI of the axis; None where not logged. One that counts in turns of the motor or
        in increments is brought to the axis by the ratio and the zero that fit best.
        """
        readings = self.log.beside("M", [axis])
        if readings is None:
            return None
        linear = self.cell.joints[self.cell.index(axis)].prismatic
        counted = np.asarray(mm_to_m(readings[:, 0]) if linear else deg_to_rad(readings[:, 0]))
        link = self.link[:, self.index(axis)]
        moved = link - link.mean()
        ratio = float(moved @ (counted - counted.mean())) / max(float(moved @ moved), 1e-300)
        if abs(ratio - 1.0) < _GEARED or np.ptp(link) < _STILL_AXIS or ratio == 0.0:
            return counted
        return np.asarray(link.mean() + (counted - counted.mean()) / ratio)

    def index(self, axis: str) -> int:
        """The column of an axis."""
        return self.axes.index(axis)

    def place(self, term: str) -> Array:
        """(N, 6) twist of a unit of a constant error, such as `base.x` or `A3.rx`."""
        return self.places[term]

    def shift(self, axis: str, signal: Array) -> Array:
        """(N, 6) twist where an axis stands `signal` (N,) beyond what is reported."""
        return self.places[f"{axis}.zero"] * signal[:, None]

    def postures(self, values: Array) -> Array:
        """(N, n) postures of axis values (N, k), SI."""
        return self.cell.to_q(axis_values(self.cell, self.axes, values))

    def beyond(self, values: Array) -> Array:
        """(N, 6) twist from where the TCP nominally is to where it would be with axis values (N, k): exact, however far."""
        in_base = self.log.info.measured_frame is MeasuredFrame.BASE
        plain = ErrorModel.of(self.cell, [], in_base=in_base, left=self.frames.left, right=self.frames.right)
        there = plain.poses(np.zeros(0), self.postures(values))
        turned = rotation_log(there[:, :3, :3] @ self.nominal[:, :3, :3].swapaxes(1, 2))
        return self.told(np.concatenate([there[:, :3, 3] - self.nominal[:, :3, 3], turned], axis=1))

    @cached_property
    def reckoned(self) -> dict[tuple[object, ...], Mapping[str, Array]]:
        """What effects have reckoned of it and may need again, as they call it."""
        return {}

    @cached_property
    def found(self) -> dict[tuple[object, ...], Any]:
        """What effects have found in it, and in logs beside it, as they call it: looked for once."""
        return {}

    @cached_property
    def speed(self) -> Array:
        """(N, k) by time, of the axes on the arm's side of the drives."""
        return self.velocity(self.link)

    @cached_property
    def acceleration(self) -> Array:
        """(N, k) by time squared, of the axes on the arm's side of the drives."""
        return self.velocity(self.link, 2)

    @cached_property
    def sides(self) -> Array:
        """(N, k) -1 to 1: the side from which each axis comes, by the way of a small play; of single poses, by their order."""
        if self.poses:
            found = [play_at_rest(u, _SIDE) for u in self.link.T]
        else:
            found = [play(u, self.t, self.pieces, _SIDE) for u in self.link.T]
        return np.stack(found, axis=1)

    def velocity(self, values: Array, order: int = 1) -> Array:
        """Time derivative of (N, k), or a higher one, run by run."""
        return derivative(values, self.t, self.pieces, order)

    @property
    def temperature(self) -> Array | None:
        """(N,) degrees C, None where not measured."""
        return _filled(self.log, "temp") if self.log.has("temp") else None

    @cached_property
    def measured_R_world(self) -> Array:
        """(N, 3, 3) `world`'s axes in the measured frame, which may turn with the table, or be the instrument's own."""
        turned = np.tile(np.eye(3), (len(self), 1, 1))
        if self.log.info.measured_frame is MeasuredFrame.BASE:
            turned = self._world_R_base().swapaxes(1, 2)
        return np.asarray(self.frames.left[:3, :3] @ turned)

    @property
    def measured_R_base(self) -> Array:
        """(N, 3, 3) `base`'s axes, those of the work, in the measured frame."""
        turned = np.tile(np.eye(3), (len(self), 1, 1))
        if self.log.info.measured_frame is not MeasuredFrame.BASE:
            turned = self._world_R_base()
        return np.asarray(self.frames.left[:3, :3] @ turned)

    def _world_R_base(self) -> Array:
        from camrob.kinematics.frames import world_T_base

        values = self.log.axes(self.axes) if self.encoder is not None else self.log.setpoints(self.axes)
        return np.asarray(world_T_base(self.cell, self.cell.to_q(values))[:, :3, :3])

    @property
    def force(self) -> Array | None:
        """(N, 3) N in `world`, None where not measured."""
        if not self.log.has(*FORCE):
            return None
        return np.stack([_filled(self.log, n) for n in FORCE], axis=1)


def _filled(log: MeasurementLog, name: str) -> Array:
    """A column with empty cells filled between their neighbours."""
    values = np.array(log.columns[name])
    known = ~np.isnan(values)
    return np.interp(log.t, log.t[known], values[known]) if known.any() else np.zeros(len(values))


def make_scene(
    log: MeasurementLog,
    cell: Cell,
    *,
    known: Frames | None = None,
    least: int = LEAST,
    laid: Frames | None = None,
    fitted: bool = False,
) -> Scene:
    """Lay a log out on a cell. Rows without axis values, or without a measured position, are left aside.

    known: frames that another log has given, where their `fitted_left` and `fitted_right` are False; a log whose frames are all
    known, by another log or by what LOG.toml says of them, may have as few as `least` rows. fitted: it takes part in the fit; a
    set of poses then needs those for its own frames alone, as every value is held to its ordinary size beside them. laid: frames
    to lay the log out with, instead of those that fit it best as the cell nominally is.

    Where no position was measured, the encoders' own takes its place: then the gap is that of the drives alone. Set-points of a
    run that are goals, and jump, are passed over. Raises LogError for a log without measured positions that lacks set-points
    or encoders, without the cell's axes, or with too few samples.
    """
    axes = cell.axis_names
    given = {kind: [f"{kind}{a}" for a in axes if log.has(f"{kind}{a}")] for kind in ("", "c")}
    usable = {kind: len(names) == len(axes) for kind, names in given.items()}
    if not any(usable.values()):
        lacking = next(a for a in axes if (not log.has(a) and not log.has(f"c{a}")) or given[""])
        missing = [a for a in axes if not log.has(a)]
        what = f"lacks the axis {missing[0] if missing else lacking} of cell {cell.name}"
        raise log.error(what, hint="give every axis of the cell, by encoder or by set-point", at=None)
    if not log.sees_place and (not all(usable.values()) or log.info.poses):
        hint = "give x, y, z of the instrument, those that it measures, or distances d, or a run's set-points beside its encoders"
        raise log.error("has no measured position", hint=hint, at=None)
    kinds = [kind for kind in ("", "c") if usable[kind]]
    whole = np.ones(len(log), bool)
    for kind in kinds:
        whole &= log.complete([f"{kind}{a}" for a in axes])
    whole &= log.complete(log.place_names)
    frames = known if known is not None else Frames(np.eye(4), np.eye(4), fitted_left=True, fitted_right=True)
    free = (
        log.info.measured_frame is MeasuredFrame.UNKNOWN and frames.fitted_left,
        log.info.target is Target.UNKNOWN and frames.fitted_right,
    )
    fewest = _FRAME_POSES * max(1, sum(free)) if fitted and log.info.poses else LEAST if any(free) else least
    if whole.sum() < fewest:
        what = f"holds {int(whole.sum())} whole samples{_emptiest(log)}"
        shared = (
            "; fewer do where its .toml names the log that has its frame (same_frame_as) or target (same_target_as)"
        )
        hint = f"give at least {fewest}{shared if any(free) else ''}"
        raise log.error(what, hint=hint, at=int(np.argmin(whole)))
    kept = log.select(np.flatnonzero(whole))
    if all(usable.values()) and not log.info.poses and (jumping := goal_axes(kept, axes)):
        if not log.sees_place:
            what = f"holds goals that jump in c{', c'.join(jumping)}, no set-points: how well a drive follows can't be seen"
            raise log.error(what, hint="log the set-points that the drives get in every cycle", at=None)
        usable["c"] = False
    return _lay_out(kept, cell, axes, usable, frames, laid)


def _emptiest(log: MeasurementLog) -> str:
    """Which of a log's columns lacks most rows, in words; "" where none lacks any."""
    empty = {n: int(np.count_nonzero(np.isnan(v))) for n, v in log.columns.items()}
    name = max(empty, key=lambda n: empty[n])
    return f", as {name} is empty in {empty[name]} of {len(log)} rows" if empty[name] else ""


def axis_values(cell: Cell, axes: Sequence[str], values: Array) -> Array:
    """SI axis values (N, k) as the controller tells them, degrees and mm."""
    prismatic = np.array([cell.joints[cell.index(a)].prismatic for a in axes])
    return np.where(prismatic, m_to_mm(values), rad_to_deg(values))


def _lay_out(
    log: MeasurementLog, cell: Cell, axes: tuple[str, ...], usable: dict[str, bool], known: Frames, laid: Frames | None
) -> Scene:
    in_base = log.info.measured_frame is MeasuredFrame.BASE
    prismatic = np.array([cell.joints[cell.index(a)].prismatic for a in axes])

    def si(values: Array) -> Array:
        return np.where(prismatic, mm_to_m(values), deg_to_rad(values))

    encoder = si(log.axes(axes)) if usable[""] else None
    setpoint = si(log.setpoints(axes)) if usable["c"] else None
    encoder, setpoint = without_turns(encoder, setpoint, ~prismatic, poses=log.info.poses)
    edge = log.axes(axes) if usable[""] else log.setpoints(axes)
    q = cell.to_q(edge)
    plain = ErrorModel.of(cell, [], in_base=in_base)
    meant = plain.poses(np.zeros(0), q)
    measured, seen, sight = _measured(log, meant, meant if laid is None else laid.left @ meant @ laid.right)
    names = _place_names(cell, in_base)
    unknown = log.info.measured_frame is MeasuredFrame.UNKNOWN, log.info.target is Target.UNKNOWN
    left, right = (log.sees_place and side for side in unknown)
    frames = laid or fit_frames(meant, measured, seen, left=left, right=right, known=known, sight=sight)
    model = ErrorModel.of(cell, names, in_base=in_base, left=frames.left, right=frames.right)
    ones = {"one": np.ones(len(log))}
    nominal, J = model.poses_and_jacobian(np.zeros(len(names)), q, ones)
    gap = np.zeros((len(log), 6))
    if log.sees_place:
        gap[:, :3] = sight.beyond(nominal[:, :3, 3]) if sight else measured[:, :3, 3] - nominal[:, :3, 3]
    gap[:, 3:] = np.where(seen[:, 3:], rotation_log(measured[:, :3, :3] @ nominal[:, :3, :3].swapaxes(1, 2)), 0.0)
    J = J if sight is None else sight.of(J)
    places = {name.removesuffix(".by.one"): np.ascontiguousarray(J[:, :, k]) for k, name in enumerate(names)}
    sigma = np.array([log.info.sigma_position] * 3 + [log.info.sigma_angle] * 3)
    torque = gravity_on_axes(model, cell, q, axes)
    return Scene(
        name=log.name,
        cell=cell,
        log=log,
        t=log.t,
        axes=axes,
        setpoint=setpoint,
        encoder=encoder,
        nominal=nominal,
        measured=measured,
        tcp_gap=gap,
        servo_gap=encoder - setpoint if encoder is not None and setpoint is not None else None,
        seen=seen,
        places=places,
        torque=torque,
        moments=gravity_moments(cell, q),
        pieces=pieces_of(log.t),
        frames=frames,
        sigma=sigma,
        sight=sight,
    )


def _measured(log: MeasurementLog, meant: Array, laid_out: Array) -> tuple[Array, NDArray[np.bool_], Sight | None]:
    """Measured poses (N, 4, 4), what of them was (N, 6), and what alone of places. meant: where the cell puts the tool (N, 4, 4),
    which is what stands in place of what was not measured; laid_out: as the measured frame sees it.
    """
    sight = sighted(log, laid_out[:, :3, 3]) if log.sees_part else None
    measured = np.tile(np.eye(4), (len(log), 1, 1))
    measured[:, :3, 3] = sight.places if sight else log.position if log.sees_place else meant[:, :3, 3]
    seen = np.ones((len(log), 6), bool)
    if log.sees_place and log.has_orientation:
        turned = log.complete(("a", "b", "c"))
        measured[turned, :3, :3] = log.select(np.flatnonzero(turned)).rotation
        seen[~turned, 3:] = False
    else:
        seen[:, 3:] = False
    return measured, seen, sight


def _place_names(cell: Cell, in_base: bool) -> list[str]:
    """All constant errors of the cell's chain, as the error model names them."""
    names = [f"{owner}.{part}" for owner in ("base", "tool") for part in PLACES]
    names += [f"root.{part}.by.one" for part in PLACES]
    for joint in cell.joints:
        if joint.role is Role.ROLL or (joint.role is Role.WORKPIECE and not in_base):
            continue
        if joint.role is Role.ARM:
            parts: tuple[str, ...] = ("x", "y", "z", "rx", "ry")
        else:
            parts = ("rx", "ry") if joint.prismatic else ("x", "y", "rx", "ry")
        names += [f"{joint.name}.{part}" for part in (*parts, "zero")]
    return names
