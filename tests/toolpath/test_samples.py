"""The sample toolpaths: made by their script, touching and not gouging their meshes, consistent as NX CLSF."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

from camrob.cell.read_cell import read_cell
from camrob.cell.read_setup import read_setup
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import Move

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "toolpaths"))

from make_samples import SAMPLES, files  # noqa: E402
from making.drop_cutter import distance_to_triangles, drop, thin  # noqa: E402

NAMES = list(SAMPLES)
TOLERANCE = 0.05  # mm: what thinning may leave between points, and a margin for rounding


def cl_lines(name: str) -> list[str]:
    return (ROOT / "toolpaths" / name / f"{name}.cls").read_text(encoding="ascii").splitlines()


def triangles_of(name: str) -> np.ndarray:
    mesh = trimesh.load_mesh(ROOT / "toolpaths" / name / "part.stl", process=False)
    return np.asarray(mesh.triangles)


def ball_centres(region, radius: float, step: float = 1.0):
    """The ball's centres (mm) along a region, no further apart than `step`, and the tool's axes there."""
    tip, axis = region.position * 1e3, region.axis
    centres, axes = [], []
    for i in range(1, len(tip)):
        n = max(1, int(np.ceil(np.linalg.norm(tip[i] - tip[i - 1]) / step)))
        t = np.arange(1, n + 1)[:, None] / n
        a = (1 - t) * axis[i - 1] + t * axis[i]
        a /= np.linalg.norm(a, axis=1)[:, None]
        centres.append((1 - t) * tip[i - 1] + t * tip[i] + radius * a)
        axes.append(a)
    return np.concatenate(centres), np.concatenate(axes)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_script_reproduces_the_files(name):
    made = files(name)
    folder = ROOT / "toolpaths" / name
    assert sorted(p.name for p in folder.iterdir() if p.name in made) == sorted(made)
    for file, data in made.items():
        assert (folder / file).read_bytes() == data, f"{file} differs: run python toolpaths/make_samples.py {name}"


@pytest.mark.parametrize("name", NAMES)
def test_sizes_and_counts(name):
    folder = ROOT / "toolpaths" / name
    lines = cl_lines(name)
    readme = (folder / "README.md").read_text(encoding="ascii")
    stated = {m[1].strip("`. "): int(m[2]) for m in re.finditer(r"^\| ([^|]+?) \| (\d+) \|$", readme, re.M)}
    assert stated["points (GOTO)"] == sum(line.startswith("GOTO/") for line in lines)
    assert stated["arcs (CIRCLE)"] == sum(line.startswith("CIRCLE/") for line in lines)
    assert stated["of these rapid"] == lines.count("RAPID")
    assert stated["operations"] == sum(line.startswith("TOOL PATH/") for line in lines) == lines.count("END-OF-PATH")
    in_cycle = "\n".join(lines).partition("CYCLE/DRILL")[2].partition("CYCLE/OFF")[0]
    assert stated["holes (CYCLE)"] == in_cycle.count("GOTO/")
    mesh = next(folder.glob("*.stl"))
    assert stated[f"triangles of `{mesh.name}"] == (mesh.stat().st_size - 84) // 50
    assert mesh.stat().st_size < 500_000
    assert (folder / f"{name}.cls").stat().st_size < 1_000_000
    low, high = {"carving": (3000, 8000), "relief": (5000, 10000), "engraving": (50, 1500), "globe": (450, 550)}[name]
    assert low <= stated["points (GOTO)"] <= high


@pytest.mark.parametrize("name", NAMES)
def test_reads_without_a_finding_and_sets_up(name):
    path = read_toolpath(ROOT / "toolpaths" / name / f"{name}.cls")
    assert path.dialect == "nx-clsf" and path.units == "mm"
    assert path.findings == ()
    lines = cl_lines(name)
    arcs = sum(len(region.arcs) for region in path.regions)
    assert arcs == sum(line.startswith("CIRCLE/") for line in lines)  # every one stays known as an arc
    for region in path.regions:
        assert np.allclose(np.linalg.norm(region.axis, axis=1), 1.0, atol=1e-12)
        cutting = region.move == Move.CUT
        assert np.all(region.feed[cutting] > 0)
    setup = read_setup(ROOT / "toolpaths" / name / "setup.toml", read_cell(ROOT / "cells" / "kr15_track_table"))
    assert setup.base_T_part[2, 3] == pytest.approx(0.0 if name == "globe" else 0.2)
    assert (setup.part or setup.stock) is not None


def test_the_globe_alone_crosses_the_threshold_of_the_condition_term():
    threshold = read_cell(ROOT / "cells" / "kr15_track_table").resolve.threshold
    least = {
        name: json.loads((ROOT / "toolpaths" / name / "golden" / f"{name}.json").read_text())["conditioning"][
            "inv_kf_min"
        ]
        for name in NAMES
    }
    assert [name for name, value in least.items() if value < threshold] == ["globe"]


@pytest.mark.parametrize("name", NAMES)
def test_printed_axes_are_unit_vectors_and_printed_on_change_only(name):
    last = None
    for line in cl_lines(name):
        if line.startswith("TOOL PATH/"):
            last = None
        if line.startswith("GOTO/"):
            fields = line[5:].split(",")
            assert len(fields) in (3, 6)
            if len(fields) == 6:
                assert fields[3:] != last
                assert np.linalg.norm(np.array(fields[3:], dtype=float)) == pytest.approx(1.0, abs=2e-7)
                last = fields[3:]
            assert last is not None  # the first point of an operation prints it


@pytest.mark.parametrize("name", ["carving", "engraving"])
def test_arcs_as_printed(name):
    """Both ends on the radius; left-handed about the printed axis: tangents meet the moves before them where smooth."""
    here, came, checked, smooth = None, None, 0, 0
    pending = None
    for line in cl_lines(name):
        if line.startswith("CIRCLE/"):
            pending = np.array(line[7:].split(","), dtype=float)
            assert len(pending) == 11
        if not line.startswith("GOTO/"):
            continue
        there = np.array(line[5:].split(",")[:3], dtype=float)
        if pending is not None:
            center, axis, radius = pending[:3], pending[3:6], pending[6]
            for end in (here, there):
                assert np.linalg.norm(end - center) == pytest.approx(radius, abs=1e-4)
                assert (end - center) @ axis == pytest.approx(0.0, abs=1e-4)
            tangent = np.cross(-axis, here - center) / radius
            if abs(tangent @ came) > 0.99:
                smooth += 1
                assert tangent @ came > 0.99
            checked += 1
            came = np.cross(-axis, there - center) / radius
            pending = None
        elif here is not None and np.any(there != here):
            came = (there - here) / np.linalg.norm(there - here)
        here = there
    assert checked > 20 and smooth > 3


@pytest.mark.slow(after=1)
@pytest.mark.parametrize(("name", "radius"), [("carving", 5.0), ("relief", 5.0)])
def test_the_ball_touches_and_does_not_gouge(name, radius):
    triangles = triangles_of(name)
    path = read_toolpath(ROOT / "toolpaths" / name / f"{name}.cls")
    for region in path.regions:
        centres, _ = ball_centres(region, radius)  # steps of 1 mm from outside: no way in unseen
        gap = distance_to_triangles(centres, triangles, radius + 1.0)
        assert gap.min() > radius - TOLERANCE
        points = (region.position * 1e3 + radius * region.axis)[region.move == Move.CUT]
        touching = np.abs(distance_to_triangles(points, triangles, radius + 1.0) - radius) < 1e-3
        assert touching.mean() > 0.8


def test_the_relief_s_shank_stays_clear():
    triangles = triangles_of("relief")
    (region,) = read_toolpath(ROOT / "toolpaths" / "relief" / "relief.cls").regions
    centres, axes = ball_centres(region, 5.0, step=5.0)
    for up in (5.0, 10.0, 20.0, 40.0, 70.0):
        assert distance_to_triangles(centres[::2] + up * axes[::2], triangles, 6.0).min() > 5.0


def test_the_relief_is_smooth():
    (region,) = read_toolpath(ROOT / "toolpaths" / "relief" / "relief.cls").regions
    axis, tip = region.axis, region.position * 1e3
    cutting = region.move[1:] == Move.CUT
    turn = np.degrees(np.arccos(np.clip((axis[1:] * axis[:-1]).sum(1), -1, 1)))
    step = np.linalg.norm(np.diff(tip, axis=0), axis=1)
    assert turn.max() < 2.0
    assert step[cutting].max() < 3.5
    centre = (tip + 5.0 * axis)[1:][cutting]
    along = np.diff(centre, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    assert (
        np.degrees(np.arccos(np.minimum((along[1:] * along[:-1]).sum(1)[40:-20], 1.0))).max() < 20.0
    )  # no valley narrower than the ball
    lean = np.degrees(np.arccos(axis[:, 2]))
    assert 30 < lean.max() < 40 and lean.min() < 1
    assert len(np.unique(np.round(axis, 6), axis=0)) > 7000


def test_both_regions_of_the_carving_lie_on_one_block():
    top, front = read_toolpath(ROOT / "toolpaths" / "carving" / "carving.cls").regions
    assert np.array_equal(np.unique(top.axis, axis=0), [[0, 0, 1]])
    assert np.allclose(front.axis, [0, -1, 0], atol=1e-12)
    block = np.array([[-120, -80, 0], [120, 80, 165.0]]) * 1e-3
    for region, out in ((top, 2), (front, 1)):
        p = region.position[region.move == Move.CUT]
        inside = np.all((p > block[0] - 0.011) & (p < block[1] + 0.011), axis=1)
        assert inside.mean() > 0.99
        assert np.ptp(p[:, out]) > 0.05  # a relief, not a plane
    nose = front.position[:, 1].max() - 0.080  # 80 mm behind the tip the spindle begins
    assert nose < block[0, 1]


def test_the_engraving_stays_in_the_plate_and_off_its_holes():
    engrave, holes = read_toolpath(ROOT / "toolpaths" / "engraving" / "engraving.cls").regions
    p = engrave.position * 1e3
    assert p[:, 2].min() == pytest.approx(19.2, abs=1e-9)
    low = p[p[:, 2] < 20.0]
    assert np.all(np.abs(low[:, :2]) < [118.0, 53.0])
    h = holes.position * 1e3
    assert h[:, 2].min() == pytest.approx(14.0, abs=1e-9)
    bottoms = np.unique(np.round(h[h[:, 2] < 14.001, :2], 6), axis=0)
    assert len(bottoms) == 4
    assert min(np.linalg.norm(low[:, :2] - b, axis=1).min() for b in bottoms) > 3.5


def test_drop_on_known_shapes():
    """A plane, a ridge and a point, whose answers are known on paper."""
    plane = np.array([[[-50, -50, 2], [50, -50, 2], [0, 60, 2.0]]])
    assert drop(plane, np.array([[0.0, 0.0]]), 5.0, -9.0)[0] == pytest.approx(7.0)
    assert drop(plane, np.array([[300.0, 0.0]]), 5.0, -9.0)[0] == -9.0
    roof = np.array([[[-50, 0, 10], [50, 0, 10], [0, -30, -20.0]], [[50, 0, 10], [-50, 0, 10], [0, 30, -20.0]]])
    assert drop(roof, np.array([[0.0, 0.0]]), 5.0, -99.0)[0] == pytest.approx(15.0)  # on the ridge
    assert drop(roof, np.array([[0.0, 3.0]]), 5.0, -99.0)[0] == pytest.approx(14.0)  # 3, 4, 5
    down = drop(roof, np.array([[0.0, -10.0]]), 5.0, -99.0)[0]
    assert down == pytest.approx(5.0 * np.sqrt(2.0))  # on the slope of 45 degrees
    assert drop(plane, np.array([[0.0, 64.0]]), 5.0, -9.0)[0] == pytest.approx(5.0)  # off the corner by 4


def test_distance_against_trimesh():
    rng = np.random.default_rng(3)
    mesh = trimesh.creation.icosphere(subdivisions=2, radius=10.0)
    points = rng.normal(size=(200, 3)) * 8.0
    ours = distance_to_triangles(points, np.asarray(mesh.triangles), 40.0)
    theirs = trimesh.proximity.closest_point(mesh, points)[1]
    assert np.allclose(ours, theirs, atol=1e-9)


def test_thin_keeps_within_tolerance():
    t = np.linspace(0, 3, 400)
    line = np.column_stack([t, np.sin(t), np.cos(2 * t)])
    kept = thin(line, 0.01)
    assert 5 < len(kept) < 60 and kept[0] == 0 and kept[-1] == 399
    again = np.column_stack([np.interp(t, t[kept], line[kept, k]) for k in range(3)])
    assert np.linalg.norm(again - line, axis=1).max() < 0.02


def test_unknown_name_is_refused(capsys):
    from make_samples import main

    assert main(["no_such_sample"]) == 2
    assert "no sample is called" in capsys.readouterr().err
