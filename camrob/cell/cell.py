"""A cell: what the machine is. Never changes during a job; `with_tool` gives another one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from camrob.cell.controller_settings import ControllerSettings
from camrob.cell.joint import Joint, Role
from camrob.cell.load import PointMass
from camrob.cell.redundancy_settings import ResolveSettings
from camrob.cell.shape import Shape
from camrob.errors import CellError
from camrob.frozen import digest, leaves, locked
from camrob.se3 import frame_from_mm_deg

__all__ = ["POSTED_ARM", "Cell"]

Array = NDArray[np.float64]

POSTED_ARM = 6  # axes of an arm that programs are made for


@dataclass(frozen=True, slots=True)
class Cell:
    """Joints from the workpiece frame `base` to the tool, and all that the jobs need to know beside them.

    base_T_first: (4, 4) before the first joint. foot_T_root: `root` (z up, at the robot's foot) seen from the frame that
    the last joint before the arm ends in. wrist_T_flange: the mounting plate seen from the frame that the arm's last
    joint ends in (its Denavit-Hartenberg row included). flange_T_tool: `$TOOL`. condition_length: the characteristic
    length, m. controller_section, resolve_section: None where cell.toml has no such section, which only some jobs need;
    `controller` and `resolve` give them. `provenance` maps dotted keys of cell.toml to where their numbers come from.
    """

    name: str
    title: str
    folder: Path
    joints: tuple[Joint, ...]
    base_T_first: Array
    foot_T_root: Array
    wrist_T_flange: Array
    flange_T_tool: Array
    condition_length: float
    base_follows_table: bool
    controller_section: ControllerSettings | None
    resolve_section: ResolveSettings | None
    shapes: tuple[Shape, ...] = ()
    masses: tuple[PointMass, ...] = ()
    payload: float = 0.0
    provenance: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("base_T_first", "foot_T_root", "wrist_T_flange", "flange_T_tool"):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(4, 4), name=name))
        object.__setattr__(self, "provenance", MappingProxyType(dict(self.provenance)))

    def with_tool(self, flange_T_tool: Array) -> Cell:
        """The same cell with another tool."""
        return replace(self, flange_T_tool=flange_T_tool)

    @property
    def controller(self) -> ControllerSettings:
        """Settings of the controller. Raises CellError where cell.toml has no [controller]."""
        if self.controller_section is None:
            raise self._lacks("controller", "this job")
        return self.controller_section

    @property
    def resolve(self) -> ResolveSettings:
        """How redundancy is resolved. Raises CellError where cell.toml has no [resolve]."""
        if self.resolve_section is None:
            raise self._lacks("resolve", "this job")
        return self.resolve_section

    @property
    def controller_T_base(self) -> Array:
        """(4, 4) `base` (where it doesn't follow the table, `world`) in the controller's world, or in its plate that turns."""
        said = None if self.controller_section is None else self.controller_section.base_frame
        return np.eye(4) if said is None else frame_from_mm_deg(said)

    def checked_for(self, verb: str, *, controller: bool = False, resolve: bool = False) -> Cell:
        """The cell itself, where it has the sections that a verb needs. Raises CellError naming section and verb."""
        if controller and self.controller_section is None:
            raise self._lacks("controller", verb)
        if resolve and self.resolve_section is None:
            raise self._lacks("resolve", verb)
        return self

    def _lacks(self, section: str, verb: str) -> CellError:
        file, arm = self.folder / "cell.toml", self.indices(Role.ARM)
        if len(arm) != POSTED_ARM or any(self.joints[i].prismatic for i in arm):
            what = f"{verb} is for arms of {POSTED_ARM} axes that turn, and this one has {len(arm)} axes"
            what += " of which some slide" if any(self.joints[i].prismatic for i in arm) else ""
            return CellError(what, hint="such a cell is measured: calibrated and diagnosed, not programmed", path=file)
        hint = "add it; the README.md of cells/kr15_track_table explains its keys"
        return CellError(f"has no [{section}], which {verb} needs", hint=hint, path=file)

    def __len__(self) -> int:
        return len(self.joints)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the joints in the chain's order."""
        return tuple(j.name for j in self.joints)

    def indices(self, role: Role) -> tuple[int, ...]:
        """Where in the chain the joints of a role stand."""
        return tuple(i for i, j in enumerate(self.joints) if j.role is role)

    @property
    def arm_slice(self) -> slice:
        """The arm's joints within the chain."""
        arm = self.indices(Role.ARM)
        return slice(arm[0], arm[-1] + 1)

    @property
    def turning_names(self) -> tuple[str, ...]:
        """The arm's axes that turn, in their order."""
        return tuple(j.name for j in self.joints if j.role is Role.ARM and not j.prismatic)

    @property
    def axis_names(self) -> tuple[str, ...]:
        """Names of the real axes in the order in which programs print them: the arm's, A1..A6, then E1, E2, ..."""
        return tuple(j.name for j in self.joints if j.role is Role.ARM) + self.external_names

    @property
    def external_names(self) -> tuple[str, ...]:
        """Names of the external axes in the order in which programs print them."""
        return tuple(sorted(j.name for j in self.joints if j.role in (Role.WORKPIECE, Role.CARRIAGE)))

    def index(self, name: str) -> int:
        """Where in the chain the joint `name` stands. Raises KeyError for an unknown name."""
        try:
            return self.names.index(name)
        except ValueError:
            raise KeyError(f"cell {self.name} has no joint {name!r}") from None

    @property
    def q_home(self) -> Array:
        """HOME posture (n,)."""
        return np.array([j.home for j in self.joints])

    @property
    def q_reference(self) -> Array:
        """Reference posture (n,)."""
        return np.array([j.reference for j in self.joints])

    @property
    def q_lower(self) -> Array:
        """Lower limits of q (n,), -inf where endless."""
        return np.array([j.q_lower for j in self.joints])

    @property
    def q_upper(self) -> Array:
        """Upper limits of q (n,), inf where endless."""
        return np.array([j.q_upper for j in self.joints])

    @property
    def endless(self) -> NDArray[np.bool_]:
        """(n,) True where a joint turns without end (the virtual roll too)."""
        return np.array([j.endless for j in self.joints])

    def limits_of(self, quantity: str) -> Array:
        """(n,) of `speed`, `acceleration` or `jerk`, SI, inf where there is none."""
        return np.array([float(getattr(j, quantity)) for j in self.joints])

    def to_axis_values(self, q: Array) -> Array:
        """Axis values as programs print them, degrees and mm, in the order of `axis_names`, of postures q (..., n)."""
        out = np.empty((*q.shape[:-1], len(self.axis_names)))
        for k, name in enumerate(self.axis_names):
            i = self.index(name)
            joint = self.joints[i]
            value = joint.axis_value(q[..., i])
            out[..., k] = joint.to_edge(value)
        return out

    def to_q(self, axis_values: Array, *, roll: float = 0.0) -> Array:
        """Postures q (..., n) of axis values (..., axes), degrees and mm, in the order of `axis_names`."""
        values = np.asarray(axis_values, float)
        q = np.full((*values.shape[:-1], len(self.joints)), roll)
        for k, name in enumerate(self.axis_names):
            i = self.index(name)
            joint = self.joints[i]
            value = values[..., k]
            q[..., i] = joint.q_value(joint.from_edge(value))
        return q

    @property
    def digest(self) -> str:
        """What the cell says: every number and setting of cell.toml, not where it lies, its title or its numbers' provenance.

        Engines and meshes count by their files' names.
        """
        content = replace(self, title="", folder=Path(), provenance={})
        return digest(*leaves(content))
