"""Several tools in one program, on a machine as it was diagnosed: each tool's way is foretold, and corrected."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from gap_cases import generator
from process_story import GCODE, KR15, PLACED_Z, TWO_TOOLS, posted

from camrob.cell.read_cell import read_cell
from camrob.cell.read_setup import read_setup
from camrob.controller.replay import replay
from camrob.controller.simulate import simulate
from camrob.errors import InputError
from camrob.gap.effects.effect import EffectParameter, Unit
from camrob.gap.effects.registry import library
from camrob.gap.fitted_units import FittedUnits
from camrob.jobs.compensate import compensate
from camrob.jobs.post import PostResult
from camrob.jobs.predict import predict
from camrob.jobs.predicting.program_tools import by_tool, mounted_in
from camrob.jobs.predicting.removal import stock_of
from camrob.jobs.predicting.removed_by_run import removed
from camrob.kinematics.frames import base_T_tool
from camrob.kinematics.second_library import pinocchio_poses
from camrob.languages.read_program import read_program
from camrob.prediction.true_path import TruePath, joined_paths
from camrob.program.motion import Motion

FEED = 5e-3  # m/s of all that cuts
WAYS = (  # mm, along which GCODE has each tool cut
    [[0, 0, 45], [0, 0, 2], [20, 0, 2]],
    [[26, 0, 5], [26, 0, 2], [40, 0, 2]],
)
CUT = TWO_TOOLS.replace("diameter_mm", "corner_radius_mm = 0\ndiameter_mm", 1).replace(
    "diameter_mm = 6", "corner_radius_mm = 3\ndiameter_mm = 6"
)
FORCE_ON = """[[tool]]
number = {}
across_um_n = {}
[tool.mean]
along_n = 0
across_n = {}
axial_n = 0
"""
STOCK = "[stock]\nbox_mm = [-60, -30, -5, 60, 40, 6]\n"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> PostResult:
    return posted(tmp_path_factory.mktemp("several"), "part.nc", GCODE, setup=TWO_TOOLS)


def off_ways(program: Path, play: np.ndarray, pushed: Sequence[float] = (0.0, 0.0)) -> list[float]:
    """For each tool, mm rms by which its tip is off what the CL file asks for, in rows that cut: play (3,), rad, of
    A1 to A3 by the generator, poses by Pinocchio; pushed: mm to the left, by each tool, where it cuts along +X.
    """
    cell, text = read_cell(KR15), read_program(program)
    ran, replayed = simulate(text, cell, cycle=0.004), replay(text, cell)
    q = cell.to_q(ran.log.setpoints(cell.axis_names))
    for k, width in enumerate(play):
        at = cell.index(f"A{k + 1}")
        q[:, at] += generator.play(q[:, at], width)
    motion, out = np.asarray(ran.motion), []
    cuts = (np.asarray(text.kind)[motion] == Motion.LIN) & (np.asarray(text.speed)[motion] < 1.01 * FEED)
    for k, (held, way) in enumerate(zip(replayed.cells, WAYS, strict=True)):
        rows = np.flatnonzero(cuts & (np.asarray(replayed.mounted)[motion] == k))
        tip = 1e3 * pinocchio_poses(held, q[rows])[:, :3, 3] - [0.0, 0.0, PLACED_Z]
        tip[:, 1] += np.where(np.gradient(tip[:, 0]) > 1e-4, pushed[k], 0.0)
        nearest = np.full(len(rows), np.inf)
        for a, b in pairwise(way):
            a, along = np.array(a, float), np.subtract(b, a).astype(float)
            share = np.clip((tip - a) @ along / (along @ along), 0.0, 1.0)
            nearest = np.minimum(nearest, np.linalg.norm(tip - a - share[:, None] * along, axis=1))
        assert len(rows) > 500
        out.append(float(np.sqrt(np.mean(nearest**2))))
    return out


def test_play_is_taken_off_the_way_of_each_tool(
    made: PostResult, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Play in three axes: what it does to the tips of both tools on a machine of other code is gone but for a tenth; and so
    predict says.
    """
    program, width = made.out / "part.src", np.deg2rad([0.03, 0.02, 0.03])
    units = tuple(
        Unit("backlash", a, (EffectParameter(f"{a}_deg", "deg", w, -np.inf, np.inf),), key=f"{w:.6g}")
        for a, w in zip(("A1", "A2", "A3"), width, strict=True)
    )
    effect = next(e for e in library() if e.name == "backlash")
    found = FittedUnits(units, (effect,) * 3, ({}, {}, {}), width, np.zeros((3, 3)), None)
    # what a diagnosis would say: a log of several tools is not diagnosed
    monkeypatch.setattr("camrob.jobs.compensate.diagnosed", lambda *_: (found, 0.0))
    monkeypatch.setattr("camrob.jobs.predict.diagnosed", lambda *_: (found, 0.0))
    said = compensate(program, cell=KR15, diagnosis=tmp_path, out=tmp_path / "out").summary.machine
    assert said is not None and said.causes == ("backlash of A1", "backlash of A2", "backlash of A3")
    was, now = off_ways(program, width), off_ways(tmp_path / "out" / "part.src", width)
    assert min(was) > 0.1 and max(now) < 0.02
    assert min(was) < said.before.rms_mm < max(was) and said.after.rms_mm == pytest.approx(max(now), rel=0.3)
    (tmp_path / "setup.toml").write_text(CUT + STOCK)
    known = {"setup": tmp_path / "setup.toml", "diagnosis": tmp_path, "pitch_mm": 0.5}
    part = predict(program, cell=KR15, out=tmp_path / "part", **known).summary
    left = predict(tmp_path / "out" / "part.src", cell=KR15, out=tmp_path / "left", meant=program, **known).summary
    assert left.rms_mm < 0.5 * part.rms_mm


def test_the_force_on_each_tool_is_taken_off_its_own_way(made: PostResult, tmp_path: Path) -> None:
    """One is pushed aside by 0.1 mm to its left, the other by 0.08 to its right; what pushes on one alone is refused of both."""
    program, setup, still = made.out / "part.src", tmp_path / "setup.toml", np.zeros(3)
    setup.write_text(TWO_TOOLS)

    def corrected(name: str, *pushes: tuple[int, float, float]) -> list[float]:
        (tmp_path / f"{name}.toml").write_text("".join(FORCE_ON.format(*push) for push in pushes))
        known = {"force": tmp_path / f"{name}.toml", "setup": setup}
        compensate(program, cell=KR15, out=tmp_path / name, **known)
        return off_ways(tmp_path / name / "part.src", still, (0.1, -0.08))

    was = off_ways(program, still, (0.1, -0.08))
    assert max(corrected("right", (1, 1.0, 100), (2, 2.0, -40))) < 0.15 * min(was)
    assert min(corrected("wrong", (2, 1.0, 100), (1, 2.0, -40))) > min(was)
    with pytest.raises(InputError, match=r"speaks of tool 1, and part\.src cuts with tool 2"):
        corrected("lacking", (1, 1.0, 100))
    (tmp_path / "FORCE.toml").write_text(
        FORCE_ON.format(1, 1.0, 100).replace("[[tool]]\nnumber = 1", "[tool]").replace("[tool.mean]", "[mean]")
    )
    with pytest.raises(InputError, match=r"pushes on one tool, and part\.src sets 2"):
        compensate(program, cell=KR15, out=tmp_path / "one", force=tmp_path / "FORCE.toml")


def test_what_each_tool_takes_away_is_its_own_groove(made: PostResult) -> None:
    """40 mm2 by a flat cutter of 10 mm, 4 mm deep; 6 + 9 pi / 2 mm2 by a ball of 6 mm."""
    cell, text = read_cell(KR15), read_program(made.out / "part.src")
    (made.out / "cut.toml").write_text(CUT + STOCK)
    held = read_setup(made.out / "cut.toml", cell)
    tools = mounted_in(text, cell, held)[0]
    ran = simulate(text, cell, cycle=0.012)
    number = tools.mounted[np.asarray(ran.motion)]
    base_T_part = np.asarray(held.base_T_part)
    area = 1e6 * removed(ran.log, number, tools, stock_of(held, 5e-4), base_T_part)
    x = 1e3 * np.concatenate(
        [
            base_T_tool(tools.cells[k], cell.to_q(log.setpoints(cell.axis_names)))[:, 0, 3]
            for k, _rows, log in by_tool(ran.log, number)
        ]
    )
    for k, (low, high), expected in ((0, (9.0, 19.0), 40.0), (1, (34.0, 39.0), 6.0 + 4.5 * np.pi)):
        rows = (number == k) & (x > low) & (x < high) & (area > 0.0)
        assert np.median(area[rows]) == pytest.approx(expected, rel=0.05)


def test_what_is_in_doubt_with_one_tool_alone_stands_beside_the_rest() -> None:
    """A play whose side is not known at first is one thing more in doubt, and none where its axis never moves."""
    pose = np.tile(np.eye(4), (2, 1, 1))
    spread, t, line = np.arange(24.0).reshape(2, 6, 2), np.arange(2.0), np.zeros(2, np.int64)
    path = TruePath(t, line, pose, pose, (), spread, np.zeros(2), (), together=np.ones((2, 3)))
    other = replace(path, spread=spread[:, :, :1], together=np.ones((2, 1)))
    for paths in ([path, other], [other, path]):
        joined = joined_paths(paths)
        assert joined.spread.shape == (4, 6, 2) and joined.together.shape == (4, 3)
        sizes = np.concatenate([np.sum(p.spread**2, axis=2) for p in paths])
        np.testing.assert_allclose(np.sum(joined.spread**2, axis=2), sizes)
