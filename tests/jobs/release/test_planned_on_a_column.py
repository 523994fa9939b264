"""A whole part planned for an arm on a column: what stands in the program's text is held to a chain of the test's own.

Denavit-Hartenberg rows of cell.toml multiplied out, CL points by a pattern: nothing of camrob but what was posted.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from test_kept_apart import on_a_column

import camrob

CARVING = Path(__file__).resolve().parents[3] / "toolpaths" / "carving" / "carving.cls"
RISER = 200.0  # mm that setup.toml has the block stand above the table
RAPID = 0.2  # m/s, as setup.toml has it: 12 000 mm/min


class Chain:
    """The tool's frame in the table's, for axis values in the controller's order, mm and degrees."""

    def __init__(self, cell: Path) -> None:
        data = tomllib.loads((cell / "cell.toml").read_text(encoding="utf-8"))
        self.joints = data["joint"]
        fixed = data["kinematics"]["wrist_to_flange"], data["tool"]["flange_to_tool"]
        self.behind = [xyzabc(*values) for values in fixed]
        assert not any(data["kinematics"]["base_to_first"])

    def at(self, values: dict[str, float]) -> np.ndarray:
        """(4, 4); an axis that has no value (the roll) stands at 0."""
        out = np.eye(4)
        for number, joint in enumerate(self.joints):
            row, axis = joint["dh"], joint["axis"]
            q = (values.get(joint["name"], 0.0) - axis.get("offset_deg", axis.get("offset_mm"))) * axis["sign"]
            turn, slide = (q, 0.0) if joint["type"] == "revolute" else (0.0, q)
            out = out @ turned("z", row["theta_deg"] + turn) @ moved(0.0, 0.0, row["d_mm"] + slide)
            out = out @ moved(row["a_mm"], 0.0, 0.0) @ turned("x", row["alpha_deg"])
            if number == len(self.joints) - 2:  # behind A6, before the roll
                out = out @ self.behind[0] @ self.behind[1]
        return out


def turned(axis: str, degrees: float) -> np.ndarray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    first, second = {"z": (0, 1), "y": (2, 0), "x": (1, 2)}[axis]
    out = np.eye(4)
    out[[first, second], [first, second]] = c
    out[first, second], out[second, first] = -s, s
    return out


def moved(*xyz: float) -> np.ndarray:
    out = np.eye(4)
    out[:3, 3] = xyz
    return out


def xyzabc(x: float, y: float, z: float, a: float, b: float, c: float) -> np.ndarray:
    return moved(x, y, z) @ turned("z", a) @ turned("y", b) @ turned("x", c)


def numbers(text: str) -> dict[str, float]:
    return {name: float(value) for name, value in re.findall(r"([A-Z]\d?) (-?[\d.]+)", text)}


def cl_points() -> dict[int, np.ndarray]:
    """By line: where the CL file has the tip, mm, and the tool's axis (6,), in the table's frame."""
    points, place = dict[int, np.ndarray](), np.eye(4)
    for line, text in enumerate(CARVING.read_text().splitlines(), start=1):
        word, _, rest = text.partition("/")
        if word == "MSYS":
            origin, x, y = np.array(rest.split(","), float).reshape(3, 3)
            place, axis = np.eye(4), np.array([0.0, 0.0, 1.0])
            place[:3] = np.stack([x, y, np.cross(x, y), origin + np.array([0.0, 0.0, RISER])], axis=1)
        elif word == "GOTO":
            values = np.array(rest.split(","), float)
            axis = values[3:] if len(values) > 3 else axis
            points[line] = np.concatenate([place[:3, :3] @ values[:3] + place[:3, 3], place[:3, :3] @ axis])
    return points


@pytest.mark.slow
def test_the_carving_on_a_column_is_posted_as_planned_and_still(tmp_path: Path) -> None:
    cell = on_a_column(tmp_path / "column", -200.0)
    made = camrob.post(CARVING, cell=cell, out=tmp_path / "out", method="planned", report=False)
    codes = [f.code for f in made.findings]
    assert made.summary.plan is not None and "plan-collides" not in codes and "plan-fell-back" not in codes
    assert "an independent witness" in made.summary.verified.by and made.summary.verified.points == 7494
    chain = Chain(cell)

    points = cl_points()
    top = max(point[2] for point in points.values() if point[5] == 1.0)
    with np.load(tmp_path / "out" / "carving.path.npz") as kept:
        names = [str(name) for name in kept["axis_names"]]
        met = {int(line): row for line, row in zip(kept["line"], kept["axis_values"], strict=True)}
    assert set(points) <= set(met)
    for line, point in points.items():
        tool = chain.at(dict(zip(names, met[line], strict=True)))
        np.testing.assert_allclose(tool[:3, 3], point[:3], atol=1e-6)
        np.testing.assert_allclose(tool[:3, 2], point[3:], atol=1e-7)

    speed, before, jumps, cuts = 0.0, dict[str, float](), 0, 0
    for text in (tmp_path / "out" / "carving.src").read_text().splitlines():
        if text.startswith("$VEL.CP"):
            speed = float(text.split("=")[1])
        elif text.startswith("PTP {E6AXIS") and "X" in before:
            tip = chain.at(numbers(text))[:3, 3]
            off = np.abs(tip - [before[axis] for axis in "XYZ"]).max()
            if off < 0.01:  # in place, from one posture to another; the last ones go to HOME
                jumps += 1
                assert tip[2] >= top - 0.01
        elif text.startswith(("LIN", "CIRC")):
            here = numbers(text.split("},")[-1])
            if speed < RAPID:
                cuts += 1
                assert (here["E1"], here["E2"]) == (before["E1"], before["E2"])
            before = here
    assert jumps >= 1 and cuts > 6000
