"""Placement of a part: symmetry about the table's axis, the best of the map, and refusals."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh

from camrob.bodies.table_plate import table_plate
from camrob.cell.joint import Role
from camrob.cell.read_cell import read_cell
from camrob.errors import CellError, CollisionError, InputError, UnreachableError
from camrob.jobs.place import _border, place
from camrob.jobs.solving import place_trial
from camrob.kinematics.frames import base_T_tool
from camrob.kinematics.kernels import chain_arrays, inverse_kf_many
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planned import resolve_planned
from camrob.redundancy.planning.freedoms import plan_space
from camrob.redundancy.planning.placement import place_stretches
from camrob.report.place.place_map import place_map
from camrob.se3 import pose
from camrob.summaries.place_summary import Placement, PlaceSummary
from camrob.toolpath.region import Move

ROOT = Path(__file__).resolve().parents[3]
FOLDER = ROOT / "cells" / "kr15_track_table"
CELL = read_cell(FOLDER)


def two_points(x: float, z: float) -> ToolPathInBase:
    frames = pose(np.repeat(np.eye(3)[None], 2, axis=0), np.array([[x, 0.0, z], [x + 1e-4, 0.0, z]]))
    return ToolPathInBase(
        frames,
        np.full(2, int(Move.CUT), np.int8),
        np.full(2, 0.02),
        np.arange(2) + 1,
        np.zeros(2, np.int32),
        np.arange(2),
        np.zeros(2, np.bool_),
    )


def test_bounds_of_placements_are_the_known_ones():
    """A point on the axis, moved to known places: 0.623 on the axis, 0.657 100 mm off it on either side, 0.640 higher."""
    shifts = np.array([[0.1, 0.0, 0.0], [-0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.2], [0.0, 0.0, 3.0]])
    found = place_stretches([(CELL, two_points(0.0, 0.2))], np.eye(4), shifts)
    np.testing.assert_allclose(found.mean, [0.623, 0.657, 0.657, 0.657, 0.640, 0.0], atol=6e-4)
    assert found.best in (1, 2, 3) and found.here == 0
    np.testing.assert_allclose(found.base_T_part[1:, :3, 3], shifts)


def test_out_of_reach_is_said():
    with pytest.raises(UnreachableError, match="no placement"):
        place_stretches([(CELL, two_points(0.0, 4.0))], np.eye(4), np.zeros((1, 3)))


@pytest.mark.slow
def test_place_writes_a_map_and_its_numbers(tmp_path):
    clfile = ROOT / "toolpaths" / "engraving" / "engraving.cls"
    summary = place(clfile, cell=FOLDER, out=tmp_path, x_mm=150.0, y_mm=0.0, z_mm=100.0).summary
    assert summary.to_json() == json.loads((tmp_path / "engraving.place.json").read_text())
    assert summary.best.inv_kf_bound_mean > summary.now.inv_kf_bound_mean
    assert summary.placements == 9 * 5
    picture = (tmp_path / "engraving.place.svg").read_text()
    assert picture.count("</title></rect>") == summary.placements and picture.count("<circle") == 1
    with pytest.raises(InputError):
        place(clfile, cell=FOLDER, out=tmp_path, x_mm=-1.0)


PLATE = [[-60, -60, -30], [60, 60, -1]]
HUNG = "hangs over the table's edge"


def job(folder: Path, *boxes: list, at: tuple = (0, 0, 200)) -> Path:
    """A CL file that cuts a small square about the part's origin, and a set-up whose stock is made of boxes (corners, mm)."""
    square = [(-10, 0), (10, 0), (10, 10), (-10, 10)]
    clfile = folder / "dot.cls"
    clfile.write_text("UNITS/MM\nFEDRAT/MMPM,900\n" + "".join(f"GOTO/{x},{y},0,0,0,1\n" for x, y in square) + "FINI\n")
    setup = f"part_in_base = [{at[0]}, {at[1]}, {at[2]}, 0, 0, 0]\n"
    if boxes:
        trimesh.util.concatenate([trimesh.creation.box(bounds=b) for b in boxes]).export(folder / "stock.stl")
        setup += '[stock]\nmesh = "stock.stl"\n'
    (folder / "setup.toml").write_text(setup)
    return clfile


def proposed(folder: Path, *boxes: list, x: float = 100.0, **where) -> PlaceSummary:
    clfile = job(folder, *boxes, **where)
    return place(clfile, cell=FOLDER, out=folder / "out", x_mm=x, y_mm=0.0).summary


def value(placement: Placement) -> float:
    return placement.trial.inv_kf_mean + placement.trial.inv_kf_min


def test_a_part_stays_where_no_trial_is_better(monkeypatch, tmp_path):
    """The bound may promise what the published method does not reach: the trial decides, and says so."""
    import camrob.jobs.solving.place_trial as trial

    def by_distance(inputs, path, base_T_part):
        """As the real one, but 1/k_F falls with the distance from where the part is."""
        solution, report = real(inputs, path, base_T_part)
        off = np.linalg.norm(base_T_part[:3, 3] - np.asarray(inputs.setup.base_T_part)[:3, 3])
        return replace(solution, inv_kf=np.full(len(solution), 0.6 - off)), report

    real = trial.try_placement
    monkeypatch.setattr(trial, "try_placement", by_distance)
    found = proposed(tmp_path, PLATE)
    assert found.stays and found.best == found.now and len(found.others) == 4
    assert found.now.inv_kf_bound_mean < max(o.inv_kf_bound_mean for o in found.others)
    page = (tmp_path / "out" / "dot.place.html").read_text()
    assert "Leave it where it is." in page and page.count("<svg") == 1


def test_a_planted_optimum_is_proposed(tmp_path):
    """Nothing in the way: far off the axis, where the bound is known to be highest, and better there by trial than as it is."""
    found = proposed(tmp_path, PLATE)
    assert abs(found.best.part_in_base[0]) == 100.0 and not found.stays and found.tried == 5 and found.refused == {}
    assert value(found.best) == max(map(value, (found.now, found.best, *found.others))) > value(found.now)
    assert found.best.inv_kf_bound_mean == pytest.approx(0.66, abs=0.01)  # 0.657 at 100 mm off the axis
    assert found.best.standing == "free" and found.best.trial.clearance_min_mm > 0.0


def test_the_tables_plate_is_found_and_its_edge_measured():
    plate = table_plate(CELL)
    assert plate is not None and plate.name == "table disc" and plate.top == pytest.approx(0.0, abs=1e-12)
    assert plate.beyond(np.array([[0.3, 0.4, 7.0], [0.0, 0.0, 0.0]])) == pytest.approx(0.2)
    assert plate.beyond(np.array([[0.0, -0.1, 0.0]])) == pytest.approx(-0.2)


def test_a_part_that_would_hang_over_the_edge_is_not_proposed(tmp_path):
    """Half 220 by 50 mm on a disc of 300: its corners stay on it up to sqrt(300^2 - 50^2) - 220 = 75.8 mm off the axis."""
    found = proposed(tmp_path, [[-220, -50, -30], [220, 50, -1]])
    assert abs(found.best.part_in_base[0]) == 75.0
    assert found.refused[HUNG] == 2


def test_without_bodies_the_cuts_have_to_lie_on_the_table(tmp_path):
    """Cuts reach to hypot(x + 10, 10) mm: 286.6 is on the disc's 300, 311.6 is not."""
    found = proposed(tmp_path, at=(200, 0, 200))
    assert found.refused[HUNG] == 1  # the one 300 mm off
    assert found.best.part_in_base[0] <= 275.0


def test_nothing_on_the_table_is_said_with_the_tally(tmp_path):
    with pytest.raises(UnreachableError, match=r"no placement .*9 hangs over the table's edge"):
        proposed(tmp_path, [[-320, -50, -30], [320, 50, -1]])
    with pytest.raises(UnreachableError, match="9 sinks into the table"):
        proposed(tmp_path, [[-60, -60, -230], [60, 60, -1]])
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_wall_at_the_best_place_moves_the_proposal(tmp_path):
    """The wall stands on the stock's +x side: where the part is best the spindle would come from there, elsewhere not."""
    free = proposed(tmp_path, PLATE)
    walled = proposed(tmp_path, PLATE, [[70, -60, -30], [90, 60, 250]])
    assert walled.best.part_in_base != free.best.part_in_base
    assert walled.tried > 1 and any("touches stock" in reason for reason in walled.refused)
    with pytest.raises(CollisionError, match="9 spindle bracket touches stock"):
        proposed(tmp_path, PLATE, [[-60, -90, -30], [60, -70, 250]])


def test_refused_placements_are_hatched_and_counted_with_texts_inert():
    xyz = np.array([[0.0, 0.0, 0.0], [25.0, 0.0, 0.0], [50.0, 0.0, 0.0]])
    picture = place_map("x", xyz, np.array([1.2, 1.3, 0.0]), 0, 0, ["", "<b> touches part", "a pose is out of reach"])
    assert picture.count('class="refused"') == 1 and "<b>" not in picture
    assert "1 refused: &lt;b&gt; touches part" in picture and picture.count('fill="#ddd"') == 1


@pytest.mark.parametrize("name", ["kr500_afp", "rx160_tracker"])
def test_a_cell_without_spare_freedom_is_bounded_by_its_branches_and_not_planned(name):
    """No external axis and no roll: the bound is that of the branches at the pose, at least HOME's own."""
    settings = read_cell(ROOT / "cells" / "kr15_track_table").resolve_section  # the cell has none of its own
    cell = replace(read_cell(ROOT / "cells" / name), resolve_section=settings)
    assert not len(plan_space(cell).free)
    q = cell.q_home + 0.1
    tool = base_T_tool(cell, q)
    path = replace(two_points(0.0, 0.0), base_T_tip=np.repeat(tool[None], 2, axis=0))
    found = place_stretches([(cell, path)], np.eye(4), np.array([[0.0, 0.0, 50.0]]))
    assert found.mean[0] >= float(inverse_kf_many(chain_arrays(cell), q[None])[0]) - 1e-6 and found.mean[1] == 0.0
    with pytest.raises(
        CellError, match=r"put the engine's .fis file"
    ):  # the published method is what is left, and it lacks these
        resolve_planned(cell, path)


def test_a_plate_in_world_is_one_where_nothing_turns_it() -> None:
    """It was none, and parts were proposed beside it; on a cell with a table `world` is not where the part stands."""
    plate = next(s for s in CELL.shapes if table_plate(replace(CELL, shapes=(s,))) is not None)
    in_world = (replace(plate, frame="world"),)
    assert table_plate(replace(CELL, shapes=in_world)) is None
    still = tuple(j for j in CELL.joints if j.role is not Role.WORKPIECE)
    fixed = replace(CELL, joints=still, shapes=in_world, masses=())
    found = table_plate(fixed)
    assert found is not None and found.top == pytest.approx(table_plate(CELL).top)


def test_a_trial_is_refused_for_an_axis_that_would_race() -> None:
    """As the witness refuses it in `post`: E1 has 100 mm to go while the tip cuts 1 mm."""
    path = two_points(0.0, 0.2)
    frames = np.array(path.base_T_tip)
    frames[1, 0, 3] = frames[0, 0, 3] + 1e-3
    path = replace(path, base_T_tip=frames)
    q = np.tile(CELL.q_home, (2, 1))
    inputs = SimpleNamespace(cell=CELL, rapid_speed=0.02)
    e1 = CELL.index("E1")
    top = float(CELL.limits_of("speed")[e1])
    for share, said in ((1.04, ""), (1.06, "E1 would have to run faster than it can")):
        q[1, e1] = q[0, e1] + share * top * 1e-3 / 0.02
        assert place_trial._too_fast(inputs, path, q) == said
    assert place_trial._too_fast(inputs, replace(path, move=np.full(2, int(Move.RAPID), np.int8)), q) == ""


def test_a_proposal_at_the_border_of_the_search_is_said_to_be_one() -> None:
    inner = np.array([[0, 0, 0], [-0.1, 0, 0], [0.1, 0, 0], [0, 0, 0.1]], float)
    found = SimpleNamespace(base_T_part=pose(np.repeat(np.eye(3)[None], 4, axis=0), inner))
    assert [_border(found, k) for k in range(4)] == [(), ("X",), ("X",), ("Z",)]
