"""A lift within the arm (its first axis slides) whose screw counts wrong, by a chain of numpy's own."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from camrob.jobs.calibrate import calibrate
from camrob.jobs.diagnose import diagnose

SCALE, ZERO = -5e-4, 0.001  # of the lift; of A3, rad
LINKS = (500.0, 400.0, 60.0)


def cell_text() -> str:
    rows = [("A1", "prismatic", 0.0), *((f"A{k + 2}", "revolute", a) for k, a in enumerate(LINKS))]
    joints = [
        f'[[joint]]\nname = "{n}"\nrole = "arm"\ntype = "{kind}"\ndh = {{ alpha_deg = 0, a_mm = {a}, theta_deg = 0, d_mm = 0 }}\n'
        for n, kind, a in rows
    ]
    return 'schema = 1\nname = "lift"\nstanding = "measured"\n' + "".join(joints)


def test_the_scale_of_an_arms_own_slide_is_found_beside_a_zero(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    lift, turns = rng.uniform(0.0, 800.0, 60), rng.uniform(-1.5, 1.5, (60, 3))
    angles = np.cumsum(turns + np.array([0.0, ZERO, 0.0]), axis=1)
    place = np.stack([np.cos(angles) @ LINKS, np.sin(angles) @ LINKS, lift * (1.0 + SCALE)], axis=1)
    place += rng.normal(0.0, 0.01, place.shape)
    (tmp_path / "cell").mkdir()
    (tmp_path / "cell" / "cell.toml").write_text(cell_text())
    table = np.column_stack([place, lift, np.degrees(turns)])
    np.savetxt(tmp_path / "log.csv", table, "%.6f", ",", header="x,y,z,A1,A2,A3,A4", comments="")
    (tmp_path / "log.toml").write_text("poses = true\nsigma_mm = 0.01\n")
    diagnose(cell=tmp_path / "cell", log=[tmp_path / "log.csv"], out=tmp_path / "out")
    found = {e["effect"]: e for e in json.loads((tmp_path / "out" / "diagnosis.json").read_text())["effects"]}
    assert found["track"]["probability"] > 0.9 and found["joint_offset"]["axes"] == ["A3"]
    assert found["track"]["parameters"]["A1_scale"]["value"] == pytest.approx(SCALE, rel=0.05)
    fitted = calibrate(tmp_path / "log.csv", cell=tmp_path / "cell", out=tmp_path / "c.toml").calibration.parameters
    assert {p.name: p.value for p in fitted.items_}["A1.scale"] == pytest.approx(SCALE, rel=0.05)
