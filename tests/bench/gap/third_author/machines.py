"""A chain's folder where axes beneath the arm turn, where the table carries the part, or where an axis of the arm slides."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from gap.second_author.chain import Robot, turned


@dataclass
class Machine(Robot):
    """A robot and how its folder is written.

    table_row: (a, d) in mm of the turning table's own row, where there is one: the arm's foot seen from the table's top.
    level: the sum of the arm's axes by these weights stays what it is at home (a hand that rods hold level).
    sensors: torques are measured at the links, on every path.
    """

    table_row: tuple[float, float] | None = None
    level: tuple[float, ...] = ()
    sensors: bool = False

    def write(self, folder: Path):
        """cell.toml and poses.csv."""
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "cell.toml").write_text(self._toml())
        self._poses(folder / "poses.csv")

    def _poses(self, path):
        rng, spread = np.random.default_rng(33), np.where(self.slides, 90.0, 22.0)
        units = ["mm" if s else "deg" for s in self.slides]
        head = ["name", *(f"{n}_{u}" for n, u in zip(self.names, units, strict=True))]
        head += ([f"{self.table}_deg"] if self.table else []) + ["x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg"]
        with path.open("w", newline="") as file:
            out = csv.writer(file)
            out.writerow([*head, "source", "note"])
            for k in range(5):
                values = np.array(self.home) + (k > 0) * spread * rng.uniform(-1, 1, len(spread))
                table = [37.0 * k] if self.table else []
                tool = turned(2, np.radians(table[0])) @ self.pose(values * self.unit)[0] if table else None
                tool = self.pose(values * self.unit)[0] if tool is None else tool
                angles = Rotation.from_matrix(tool[:3, :3]).as_euler("ZYX", degrees=True)
                numbers = [f"{x:.6f}" for x in (*values, *table, *(tool[:3, 3] * 1e3), *angles)]
                out.writerow([f"truth_{k}", *numbers, "hand", "the third author's chain"])

    def _toml(self):
        lines = ["schema = 1", f'name = "{self.name}"', f'title = "{self.title}"', 'standing = "datasheet"', ""]
        before = [r for r in self.rows if r.name.startswith("E")]
        if before or self.table_row:
            first = np.eye(4) if self.table_row else self.base
            numbers = [*(first[:3, 3] * 1e3), *Rotation.from_matrix(first[:3, :3]).as_euler("ZYX", degrees=True)]
            lines += ["[kinematics]", f"base_follows_table = {str(bool(self.table)).lower()}"]
            lines += [
                "characteristic_length_mm = 400",
                "base_to_first = [" + ", ".join(f"{x:.6f}" for x in numbers) + "]",
            ]
            lines += [f"{k} = [0, 0, 0, 0, 0, 0]" for k in ("foot_to_root", "wrist_to_flange")]
            lines += ['standing = "datasheet"', ""]
        if self.table_row:
            lines += _joint(self.table, "workpiece", "revolute", (0, self.table_row[0], 0, self.table_row[1]), 1, 0)
        for r in before:
            kind = "prismatic" if r.kind == "P" else "revolute"
            lines += _joint(r.name, "carriage", kind, (r.alpha, r.a, r.theta, r.d), r.sign, r.offset)
        arm = [self.rows[i] for i in self.arm]
        lines += ["[arm]", f'convention = "{"modified" if self.modified else "standard"}"', "dh = ["]
        lines += [f"  [{r.alpha}, {r.a}, {r.theta}, {r.d}]," for r in arm]
        lines += ["]", f'kinds = "{"".join(r.kind for r in arm)}"', f"signs = {[r.sign for r in arm]}"]
        lines += [f"offsets_deg = {[float(r.offset) for r in arm]}", ""]
        lines += ["[tool]", f"flange_to_tool = {[float(x) for x in self.tool]}", 'standing = "measured"', ""]
        if self.known:
            lines += ["[load]", f"payload_kg = {self.payload}", 'standing = "datasheet"', ""]
            for k, b in enumerate(self.bodies):
                lines += ["[[mass]]", f'name = "part {k}"', f'after = "{b.after}"', f"mass_kg = {b.mass}"]
                lines += [f"center_mm = {[float(x) for x in b.centre]}", 'standing = "datasheet"', ""]
        return "\n".join(lines) + "\n"


def _joint(name, role, kind, row, sign, offset):
    unit = "mm" if kind == "prismatic" else "deg"
    alpha, a, theta, d = row
    return [
        "[[joint]]", f'name = "{name}"', f'role = "{role}"', f'type = "{kind}"',
        f"dh = {{ alpha_deg = {alpha}, a_mm = {a}, theta_deg = {theta}, d_mm = {d} }}",
        f"axis = {{ sign = {sign}, offset_{unit} = {offset} }}", 'standing = "datasheet"', "",
    ]  # fmt: skip
