"""Collision check: distances against fcl and brute force, planted faults, and what must never raise an alarm."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import fcl
import numpy as np
import pytest
import trimesh

from camrob.bodies.advance import Riders, chain_links, pair_distances
from camrob.bodies.bodies import base_T_bodies, cell_bodies, follows, job_body
from camrob.bodies.convex import BOX, CYLINDER, piece_distance, scratch
from camrob.bodies.meshes import body_triangles, read_triangles, wraps
from camrob.bodies.tree import join_pieces, mesh_pieces, new_search, solid_pieces, tree_distance
from camrob.cell.read_cell import read_cell
from camrob.cell.setup import Body as JobBody
from camrob.cell.setup import ToolSetup
from camrob.cell.shape import Shape, ShapeKind
from camrob.checks.air import air_runs
from camrob.checks.collisions import check_collisions
from camrob.errors import SetupError
from camrob.findings import Severity
from camrob.kinematics.frames import base_T_flange, base_T_root, base_T_tool, world_T_base
from camrob.se3 import inverse, pose, rotation_exp
from camrob.witness.job import read_job

ROOT = Path(__file__).resolve().parents[2]
CELL = read_cell(ROOT / "cells" / "kr15_track_table")


def interpolate_void(q0: np.ndarray, q1: np.ndarray, step: float) -> np.ndarray:
    """Postures (K, n) on the straight way in the joints, both ends included, no joint moving by more than `step` between two."""
    pieces = max(1, int(np.ceil(np.abs(q1 - q0).max() / step - 1e-9)))
    return np.linspace(q0, q1, pieces + 1)


def run(cell, q, *, cutting=None, line=None, region=None, **more):
    q = np.atleast_2d(q)
    m = len(q)
    return check_collisions(
        cell,
        q,
        cutting=np.zeros(m, bool) if cutting is None else cutting,
        line=np.arange(1, m + 1) if line is None else line,
        region=np.zeros(m, int) if region is None else region,
        **more,
    )


def at(x=0.0, y=0.0, z=0.0):
    T = np.eye(4)
    T[:3, 3] = x, y, z
    return T


def obstacle(base_T_shape, size=(0.05, 0.05, 0.05), frame="base", name="post"):
    return Shape(name, "obstacle", frame, ShapeKind.BOX, np.array(size), base_T_shape)


def with_shapes(*shapes):
    return replace(CELL, shapes=(*CELL.shapes, *shapes))


def moved(name, value, q=None):
    out = np.array(CELL.q_home if q is None else q)
    out[CELL.index(name)] += value
    return out


def random_pose(rng, spread=1.0):
    return pose(rotation_exp(rng.normal(size=3) * 2.0), rng.uniform(-spread, spread, 3))


# --- distances ------------------------------------------------------------------------------------------------------

SOLIDS = {
    "box": (solid_pieces(BOX, [0.2, 0.1, 0.05]), lambda: fcl.Box(0.4, 0.2, 0.1)),
    "cylinder": (solid_pieces(CYLINDER, [0.1, 0.1, 0.25]), lambda: fcl.Cylinder(0.1, 0.5)),
    "capsule": (solid_pieces(BOX, [0, 0, 0.2], 0.08), lambda: fcl.Capsule(0.08, 0.4)),
    "sphere": (solid_pieces(BOX, [0, 0, 0], 0.15), lambda: fcl.Sphere(0.15)),
}


def our_distance(a, b, b_T_a):
    table, roots = join_pieces([a, b])
    R, p = np.ascontiguousarray(b_T_a[:3, :3]), b_T_a[:3, 3].copy()
    return tree_distance(table, roots[0], roots[1], R, p, 1e-3, new_search())


def fcl_distance(shape_a, T_a, shape_b, T_b):
    one, two = (fcl.CollisionObject(s, fcl.Transform(T[:3, :3], T[:3, 3])) for s, T in ((shape_a, T_a), (shape_b, T_b)))
    if fcl.collide(one, two, fcl.CollisionRequest(), fcl.CollisionResult()):
        return 0.0
    return fcl.distance(one, two, fcl.DistanceRequest(), fcl.DistanceResult())


def _project_box(x):
    return np.clip(x, [-0.2, -0.1, -0.05], [0.2, 0.1, 0.05])


def _project_cylinder(x):
    across = np.linalg.norm(x[:, :2], axis=1, keepdims=True)
    xy = x[:, :2] * np.minimum(1.0, 0.1 / np.maximum(across, 1e-12))
    return np.concatenate([xy, np.clip(x[:, 2:], -0.25, 0.25)], axis=1)


def _project_swept(x, half, radius):
    core = np.stack([0 * x[:, 0], 0 * x[:, 0], np.clip(x[:, 2], -half, half)], axis=1)
    off = x - core
    return core + off * np.minimum(1.0, radius / np.maximum(np.linalg.norm(off, axis=1, keepdims=True), 1e-12))


PROJECTIONS = {
    "box": _project_box,
    "cylinder": _project_cylinder,
    "capsule": lambda x: _project_swept(x, 0.2, 0.08),
    "sphere": lambda x: _project_swept(x, 0.0, 0.15),
}


def alternating_distance(a, b, b_T_a):
    """Distances (k,) of two convex bodies by projecting to and fro (Cheney, Goldstein 1959): plain, never low."""
    R, p = b_T_a[:, :3, :3], b_T_a[:, :3, 3]
    x = np.zeros((len(b_T_a), 3))
    for _ in range(4000):
        y = PROJECTIONS[a](np.einsum("kji,kj->ki", R, x - p))
        y = np.einsum("kij,kj->ki", R, y) + p
        x = PROJECTIONS[b](y)
    return np.linalg.norm(x - y, axis=1)


@pytest.mark.parametrize("a", SOLIDS)
@pytest.mark.parametrize("b", SOLIDS)
def test_distances_of_primitives_against_projections_and_touching_against_fcl(a, b):
    """fcl's own distances of round bodies stray by millimetres (0.7.0), so that it is asked for yes or no alone."""
    rng = np.random.default_rng(7)
    poses = np.stack([random_pose(rng, 0.5) for _ in range(60)])
    truth = alternating_distance(a, b, poses)
    ours = np.array([our_distance(SOLIDS[a][0], SOLIDS[b][0], T) for T in poses])
    touch = np.array([fcl_distance(SOLIDS[a][1](), T, SOLIDS[b][1](), np.eye(4)) <= 0.0 for T in poses])
    assert 0 < touch.sum() < 60
    assert np.all(ours <= truth + 1e-6)  # certified: never above the truth
    assert np.all(ours[~touch] >= truth[~touch] * (1 - 1.1e-3) - 1e-4)
    assert np.array_equal(ours <= 0.0, touch)


def segment_distance(p, u, q, v, count=400):
    """Distance of two segments p + s u, q + t v by alternating projections from many starts (plain and slow)."""
    s = np.linspace(-1, 1, count)
    for _ in range(200):
        t = np.clip((p + s[:, None] * u - q) @ v / (v @ v), -1, 1)
        s = np.clip((q + t[:, None] * v - p) @ u / (u @ u), -1, 1)
    return np.linalg.norm(p + s[:, None] * u - q - t[:, None] * v, axis=1).min()


def test_capsules_by_formula_and_spheres_exactly():
    rng = np.random.default_rng(3)
    for _ in range(50):
        T = random_pose(rng, 0.8)
        core = segment_distance(T[:3, 3], T[:3, 2] * 0.2, np.zeros(3), np.array([0, 0, 0.3]))
        ours = our_distance(solid_pieces(BOX, [0, 0, 0.2], 0.05), solid_pieces(BOX, [0, 0, 0.3], 0.04), T)
        assert ours == pytest.approx(max(0.0, core - 0.09), abs=1e-5 + 1.1e-3 * core)
        ball = our_distance(solid_pieces(BOX, [0, 0, 0], 0.05), solid_pieces(BOX, [0, 0, 0], 0.04), T)
        assert ball == pytest.approx(max(0.0, np.linalg.norm(T[:3, 3]) - 0.09), abs=1e-8)


def test_meshes_agree_with_fcl_and_with_the_plain_twin():
    rng = np.random.default_rng(5)
    mesh = trimesh.creation.icosphere(subdivisions=2, radius=0.2)
    mesh.vertices[:, 2] *= 0.3
    other = trimesh.creation.torus(0.2, 0.05, major_sections=16, minor_sections=8)
    model, model_other = fcl.BVHModel(), fcl.BVHModel()
    for m, source in ((model, mesh), (model_other, other)):
        m.beginModel(len(source.vertices), len(source.faces))
        m.addSubModel(source.vertices, source.faces)
        m.endModel()
    ours, ours_other = mesh_pieces(np.array(mesh.triangles)), mesh_pieces(np.array(other.triangles))
    capsule = solid_pieces(BOX, [0, 0, 0.2], 0.08)
    seen = 0
    for _ in range(40):
        T = random_pose(rng, 0.6)
        theirs = fcl_distance(model_other, T, model, np.eye(4))
        seen += theirs > 0.0
        d = our_distance(ours_other, ours, T)
        assert theirs * (1 - 3e-3) - 1e-6 <= d <= theirs + 1e-6
        # twin: capsule against the mesh triangle by triangle
        table, roots = join_pieces([capsule, ours])
        leaves = roots[1] + np.flatnonzero(ours.corner >= 0)
        R, p = np.ascontiguousarray(T[:3, :3]), T[:3, 3].copy()
        plain = min(piece_distance(table, 0, int(n), R, p, np.inf, 1e-3, scratch()) for n in leaves)
        assert our_distance(capsule, ours, T) == pytest.approx(plain, rel=3e-3, abs=1e-8)
    assert seen > 5


def test_tree_of_a_mesh_holds_every_triangle_once_within_its_boxes():
    triangles = np.random.default_rng(1).normal(size=(57, 3, 3))
    tree = mesh_pieces(triangles)
    assert sorted(tree.corner[tree.corner >= 0]) == list(range(57)) and len(tree.kind) == 2 * 57 - 1

    def below(node):
        if tree.left[node] < 0:
            return [triangles[tree.corner[node]]]
        return below(tree.left[node]) + below(tree.right[node])

    for node in range(len(tree.kind)):
        corners = np.concatenate(below(node))
        assert np.all(np.abs(corners - tree.center[node]) <= tree.half[node] + 1e-12)
        assert np.all(np.linalg.norm(corners - tree.center[node], axis=1) <= tree.reach[node] + 1e-12)


# --- frames ---------------------------------------------------------------------------------------------------------


def test_bodies_ride_on_the_frames_that_the_kinematics_give():
    rng = np.random.default_rng(2)
    q = CELL.q_home + rng.uniform(-0.5, 0.5, (5, len(CELL)))
    q[:, CELL.index("roll")] = 0.0
    truths = {
        "world": inverse(world_T_base(CELL, q)),
        "root": base_T_root(CELL, q),
        "flange": base_T_flange(CELL, q),
        "tool": base_T_tool(CELL, q),
        "base": np.broadcast_to(np.eye(4), (5, 4, 4)),
    }
    for frame, truth in truths.items():
        bodies = cell_bodies(replace(CELL, shapes=(obstacle(np.eye(4), frame=frame),)))
        assert np.allclose(base_T_bodies(CELL, bodies, q)[0], truth, atol=1e-12), frame
    with pytest.raises(KeyError):
        follows(CELL, "nowhere")


@pytest.mark.slow
def test_pair_distances_against_poses_in_plain_numpy():
    rng = np.random.default_rng(4)
    q = CELL.q_home + rng.uniform(-0.4, 0.4, (20, len(CELL)))
    bodies = cell_bodies(CELL)
    pieces, roots = join_pieces([b.pieces for b in bodies])
    riders = Riders(np.array([b.link for b in bodies]), np.stack([b.link_T_body for b in bodies]), roots, pieces)
    poses = base_T_bodies(CELL, bodies, q)
    names = [b.name for b in bodies]
    for far, near in (
        ("spindle", "table disc"),
        ("spindle", "A4 tube"),
        ("A2 upper arm", "floor"),
        ("tool", "robot foot"),
    ):
        a, b = names.index(far), names.index(near)
        ours = pair_distances(chain_links(CELL), riders, a, b, q)
        plain = [
            our_distance(bodies[a].pieces, bodies[b].pieces, inverse(poses[b, k]) @ poses[a, k]) for k in range(20)
        ]
        assert np.allclose(ours, plain, rtol=3e-3, atol=1e-7)


# --- the cell -------------------------------------------------------------------------------------------------------


def test_home_raises_no_alarm():
    report = run(CELL, CELL.q_home)
    assert report.checked and report.count == 0 and not report.findings
    assert report.clearance_min is not None and report.clearance_min > 0.01
    assert report.points == 1 and report.largest_step == 0.0 and "covers every motion" in report.sampled
    assert any("A1 and A2" in s for s in report.skipped)


def test_a_motion_about_home_raises_no_alarm():
    q = interpolate_void(moved("A1", -0.5), moved("A1", 0.5), 0.02)
    assert run(CELL, q).count == 0


def test_box_in_the_forearms_way_is_found_with_its_line():
    bodies = cell_bodies(CELL)
    k = [b.name for b in bodies].index("A3 tube")
    q = interpolate_void(moved("A1", -0.4), moved("A1", 0.4), 0.01)
    planted = 30
    base_T_tube = base_T_bodies(CELL, bodies, q[planted])[k]
    report = run(with_shapes(obstacle(base_T_tube, frame="base")), q)
    assert report.hit[planted] and 0 < report.count < len(q)
    first = int(np.argmax(report.hit))
    pair = next(p for p in report.pairs if set(p.pair) == {"A3 tube", "post"})
    assert pair.first >= first and pair.count > 0 and pair.clearance == 0.0
    finding = next(f for f in report.findings if f.text.startswith("A3"))
    assert finding.severity is Severity.ERROR and finding.code == "collision"
    assert finding.line <= planted + 1 and finding.line >= first + 1 and "post" in finding.text
    assert report.clearance_min == 0.0


def test_tool_into_table_while_cutting():
    q = CELL.q_home
    tip = base_T_tool(CELL, q)[:3, 3]
    down = np.linspace(0.0, 1.1, 40)[:, None]
    path = np.repeat(q[None], 40, 0)
    path[:, CELL.index("A2")] += down[:, 0]
    tips = base_T_tool(CELL, path)[:, :3, 3]
    assert tip[2] > 0.5 and tips[-1, 2] < -0.01
    report = run(CELL, path, cutting=np.ones(40, bool))
    assert any({"tool", "table"} <= set(p.groups) and p.count for p in report.pairs)
    found = next(f for f in report.findings if f.text.startswith("tool touches table"))
    assert tips[found.point + 1, 2] < 0.01 and found.code == "collision-in-cut"
    in_air = run(CELL, path, cutting=np.zeros(40, bool))
    assert next(f for f in in_air.findings if f.text.startswith("tool touches table")).code == "collision"


def test_a_thin_wall_between_two_postures_is_found():
    q = np.stack([moved("A1", -0.3), moved("A1", 0.3)])
    tip = base_T_tool(CELL, CELL.q_home)[:3, 3]
    wall = obstacle(at(*tip), (0.002, 0.002, 0.002))
    alone = run(with_shapes(wall), q[:1]), run(with_shapes(wall), q[1:])
    assert all(r.count == 0 for r in alone)
    report = run(with_shapes(wall), q)
    assert report.count == 1 and report.hit.tolist() == [False, True]
    assert report.findings[0].point == 1
    # a finer step proves more, a coarser one says so
    assert run(CELL, q, step=1e-4).largest_step <= 1e-4


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_near_misses_are_no_collisions_and_clearance_is_right(side):
    """A ball beside a tool that only turns about its own axis: the clearance is known."""
    q = interpolate_void(CELL.q_home, moved("E1", 0.2), 0.01)
    tips = base_T_tool(CELL, q)[:, :3, 3]
    T = at(*tips[10])
    shape = Shape("ball", "obstacle", "base", ShapeKind.SPHERE, np.array([0.01]), T)
    tool = Shape("tool", "tool", "tool", ShapeKind.SPHERE, np.array([0.005]), np.eye(4))
    lonely = replace(CELL, shapes=(tool, replace(shape, frame_T_shape=at(*(tips[10] + [side * 0.018, 0, 0])))))
    report = run(lonely, q)
    assert report.count == 0
    assert report.clearance_min == pytest.approx(0.003, abs=0.0011) and report.clearance_min >= 0.003 - 1e-6
    assert abs(report.clearance_at - 10) <= 1


def test_brute_force_finds_nothing_that_the_check_missed():
    """Random motions through a forest of posts: dense sampling of every motion agrees, to the step that is stated."""
    rng = np.random.default_rng(11)
    posts = [
        obstacle(at(*rng.uniform([-0.5, -0.6, 0.2], [0.5, 0.6, 1.2])), (0.04, 0.04, 0.04), name=f"post {k}")
        for k in range(12)
    ]
    cell = with_shapes(*posts)
    q = CELL.q_home + rng.uniform(-0.35, 0.35, (12, len(CELL)))
    torus = np.array(trimesh.creation.torus(0.15, 0.03, major_sections=24, minor_sections=12).triangles)
    report = run(cell, q, cutting=np.ones(12, bool), part_mesh=torus, base_T_part=at(0.1, 0.0, 0.75))
    bodies = (*cell_bodies(cell), job_body("part", torus, at(0.1, 0.0, 0.75)))
    pieces, roots = join_pieces([b.pieces for b in bodies])
    riders = Riders(np.array([b.link for b in bodies]), np.stack([b.link_T_body for b in bodies]), roots, pieces)
    names = [b.name for b in bodies]
    dense = np.concatenate([interpolate_void(q[k], q[k + 1], 0.002) for k in range(len(q) - 1)])
    touched = 0
    for pair in report.pairs:
        far, near = (names.index(n) for n in pair.pair)
        true = pair_distances(chain_links(cell), riders, far, near, dense)
        touched += pair.count > 0
        if pair.count == 0:
            assert true.min() > 0.0
            assert true.min() - 1e-4 <= pair.clearance <= true.min() * 1.12 + 1.2e-3  # found to a millimetre or a tenth
        else:
            assert true.min() <= 0.002 and pair.clearance == 0.0
    assert 0 < touched < len(report.pairs) / 2
    assert any("part" in p.pair and p.count for p in report.pairs)
    assert any("part" in p.pair and not p.count for p in report.pairs)


def test_more_obstacles_never_lower_the_count_and_twice_is_the_same():
    rng = np.random.default_rng(9)
    q = CELL.q_home + rng.uniform(-0.4, 0.4, (15, len(CELL)))
    shapes, counts, hits = [], [], np.zeros(15, bool)
    for k in range(6):
        report = run(with_shapes(*shapes), q)
        assert np.all(report.hit >= hits)
        counts.append(report.count)
        hits = report.hit
        shapes.append(obstacle(at(*rng.uniform([-0.4, -0.5, 0.3], [0.4, 0.5, 1.0])), (0.1, 0.1, 0.1), name=f"post {k}"))
    assert counts == sorted(counts) and counts[-1] > counts[0]
    again = run(with_shapes(*shapes[:-1]), q)
    assert again.pairs == report.pairs and again.findings == report.findings


# --- the part -------------------------------------------------------------------------------------------------------


def block(base_T_tip, top=0.0, size=0.06):
    """A block whose top lies `top` above the tip, in `base`."""
    x, y, z = base_T_tip[:3, 3]
    body = JobBody(None, 1.0, np.array([x - size, y - size, z - 0.05]), np.array([x + size, y + size, z + top]))
    return body_triangles(body)


def test_tool_may_touch_the_part_while_it_cuts_and_nothing_else_may():
    q = interpolate_void(moved("E1", -0.02), moved("E1", 0.02), 0.002)
    tip = base_T_tool(CELL, CELL.q_home)
    part = block(tip, 0.004)
    cutting = np.ones(len(q), bool)
    report = run(CELL, q, cutting=cutting, part_mesh=part, base_T_part=np.eye(4))
    assert report.count == 0
    in_air = run(CELL, q, part_mesh=part, base_T_part=np.eye(4))
    assert in_air.count == len(q) - 1  # no motion leads to the first point
    assert "tool touches part on a move through air" == in_air.findings[0].text
    # the same block as stock: the tool cuts it, wherever it goes
    assert run(CELL, q, stock_mesh=part, base_T_part=np.eye(4)).count == 0
    # a tall part reaches the spindle, cut or not
    tall = run(CELL, q, cutting=cutting, part_mesh=block(tip, 0.3), base_T_part=np.eye(4))
    assert tall.count == len(q) and any(f.text.startswith("spindle") for f in tall.findings)
    assert all(f.severity is Severity.ERROR for f in tall.findings)


def test_part_is_posed_by_base_T_part():
    tip = base_T_tool(CELL, CELL.q_home)
    part = block(at(), 0.01)
    there = at(*tip[:3, 3])
    assert run(CELL, CELL.q_home, part_mesh=part, base_T_part=there).count == 1
    assert run(CELL, CELL.q_home, part_mesh=part, base_T_part=at(0.5, 0.5, 0)).count == 0


def tool_axis_path(heights):
    """Postures that lift the tool along `world` z by the heights (m), by Newton steps from HOME."""
    q = np.repeat(CELL.q_home[None], len(heights), 0)
    free = [CELL.index(n) for n in ("A1", "A2", "A3", "A4", "A5", "A6")]
    start = base_T_tool(CELL, CELL.q_home)
    for k, h in enumerate(heights):
        goal = start.copy()
        goal[2, 3] += h
        posture = q[k - 1].copy() if k else q[0].copy()
        for _ in range(20):
            T = base_T_tool(CELL, posture)
            J = np.empty((12, 6))
            for c, i in enumerate(free):
                d = posture.copy()
                d[i] += 1e-6
                J[:, c] = ((base_T_tool(CELL, d) - T)[:3].ravel()) / 1e-6
            posture[free] += np.linalg.lstsq(J, (goal - T)[:3].ravel(), rcond=None)[0]
        q[k] = posture
    return q


def test_air_moves_begin_and_end_at_the_part_but_do_not_pass_through_it():
    """A cut at the surface, a retract, a plunge: no alarm; a plunge of 5 mm into the part: an alarm at its line."""
    heights = [0.0, 0.0, 0.05, 0.1, 0.05, 0.0, 0.0]
    cutting = np.array([False, True, False, False, False, False, True])
    q = tool_axis_path(heights)
    part = block(base_T_tool(CELL, q[0]))  # the tool leans by 20 degrees: a flat one would dip 1.7 mm into it
    clean = run(CELL, q[1:], cutting=cutting[1:], part_mesh=part, base_T_part=np.eye(4))
    assert clean.count == 0
    deep = tool_axis_path([0.0, 0.05, 0.1, 0.05, -0.012, 0.0])
    bad = run(CELL, deep, cutting=cutting[1:], part_mesh=part, base_T_part=np.eye(4))
    assert bad.count >= 1 and bad.findings[0].point in (4, 5) and "air" in bad.findings[0].text


def test_rapid_that_starts_wholly_inside_the_part():
    tip = base_T_tool(CELL, CELL.q_home)
    x, y, z = tip[:3, 3]
    around = body_triangles(JobBody(None, 1.0, np.array([x, y, z]) - 2.0, np.array([x, y, z]) + 2.0))
    report = run(CELL, CELL.q_home, part_mesh=around, base_T_part=np.eye(4))
    assert report.count == 1
    assert any("tool" in p.groups and p.count for p in report.pairs)
    assert wraps(around, np.array([x, y, z])) and not wraps(around, np.array([x, y, z + 2.5]))


def test_tool_of_the_setup_replaces_the_cells_own():
    tip = base_T_tool(CELL, CELL.q_home)
    ball = Shape("ball", "obstacle", "base", ShapeKind.SPHERE, np.array([0.004]), tip @ at(0.012, 0, 0.02))
    cell = with_shapes(ball)
    assert run(cell, CELL.q_home).count == 0
    thick = ToolSetup(1, "face mill", CELL.flange_T_tool, diameter=0.02, length=0.05)
    report = run(cell, CELL.q_home, tool=thick)
    assert report.count == 1 and report.findings[0].text.startswith("face mill")


# --- air runs -------------------------------------------------------------------------------------------------------


def test_air_runs_are_split_near_cuts():
    tip = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [12, 0, 0], [13, 0, 0.0]])
    q = np.concatenate([tip, tip], axis=1)
    cutting = np.array([False, True, False, False, True])
    runs = air_runs(q, tip, cutting, 0.25)
    assert np.all(~(runs.free & runs.near))
    assert runs.q.shape == (7, 6) and runs.point.tolist() == [0, 1, 2, 2, 3, 3, 4]
    assert runs.near.tolist() == [False, False, True, False, False, True, False]
    assert runs.free.tolist() == [False, False, False, True, True, False, False]
    assert runs.q[2, 0] == pytest.approx(1.25) and runs.q[4, 0] == pytest.approx(12 - 0.25)
    whole = air_runs(q, tip, cutting, 100.0)
    assert len(whole.q) == 5 and not whole.free.any() and whole.near.tolist() == [False, False, True, True, False]
    none = air_runs(q, tip, np.zeros(5, bool), 0.25)
    assert none.free.tolist() == [False, True, True, True, True] and not none.near.any()


# --- edges ----------------------------------------------------------------------------------------------------------


def test_a_cell_without_bodies_and_an_empty_path_are_said_to_be_unchecked():
    bare = run(replace(CELL, shapes=()), CELL.q_home)
    assert not bare.checked and bare.clearance_min is None and "no collisions were checked" in bare.sampled
    empty = run(CELL, np.zeros((0, len(CELL))))
    assert not empty.checked and empty.count == 0


def test_arrays_that_do_not_fit_are_refused():
    with pytest.raises(ValueError):
        run(CELL, np.full((2, len(CELL)), np.nan))
    with pytest.raises(ValueError):
        run(CELL, CELL.q_home[:4])
    with pytest.raises(ValueError):
        run(CELL, CELL.q_home, line=[1, 2])


def test_a_budget_is_kept_and_what_it_costs_is_said():
    q = interpolate_void(moved("A1", -0.01), moved("A1", 0.01), 2e-6)
    cell = with_shapes(obstacle(at(*base_T_tool(CELL, CELL.q_home)[:3, 3])))
    fine, coarse = run(cell, q), run(cell, q, max_samples=1)
    assert fine.count == len(q) and max(p.samples for p in fine.pairs) == len(q)
    assert 0 < coarse.count < fine.count and max(p.samples for p in coarse.pairs) < 0.5 * len(q)
    assert coarse.largest_step > fine.largest_step
    seen = []
    run(CELL, q[:3], progress=seen.append)
    assert len(seen) > 1 and np.allclose(seen, np.arange(1, len(seen) + 1) / len(seen))


def test_stops_at_one_posture_count_like_any_other():
    q = np.repeat(CELL.q_home[None], 4, 0)
    tip = base_T_tool(CELL, CELL.q_home)[:3, 3]
    report = run(with_shapes(obstacle(at(*tip))), q)
    assert report.count == 4


def test_meshes_that_cannot_be_read_are_refused(tmp_path):
    bad = tmp_path / "part.stl"
    bad.write_bytes(b"solid nothing\nfacet gone")
    with pytest.raises(SetupError):
        read_triangles(bad, 0.001)
    with pytest.raises(SetupError):
        read_triangles(tmp_path / "missing.stl", 0.001)
    other = tmp_path / "part.step"
    other.write_text("ISO-10303-21;")
    with pytest.raises(SetupError, match="STL"):
        read_triangles(other, 0.001)
    good = tmp_path / "good.stl"
    trimesh.creation.box((10, 20, 30)).export(good)
    assert np.allclose(np.ptp(read_triangles(good, 0.001).reshape(-1, 3), axis=0), [0.01, 0.02, 0.03])


def test_a_binary_stl_is_read_as_a_library_reads_it(tmp_path):
    """By the program's reader and by the witness's, each its own; what isn't one to the byte is left to the library."""
    ball = trimesh.creation.icosphere(2, 7.5)
    plain = ball.export(file_type="stl")
    kinds = {
        "binary.stl": plain,
        "named.stl": b"solid ball".ljust(80) + plain[80:],
        "text.stl": ball.export(file_type="stl_ascii"),
    }
    for name, content in kinds.items():
        file = tmp_path / name
        file.write_bytes(content if isinstance(content, bytes) else content.encode())
        assert np.allclose(read_triangles(file, 0.001), 1e-3 * ball.triangles, rtol=1e-6, atol=1e-9)
        setup = tmp_path / "setup.toml"
        setup.write_text(f'part_in_base = [0, 0, 0, 0, 0, 0]\n[part]\nmesh = "{name}"\n')
        corners = read_job(setup).corners("part")
        assert np.allclose(
            np.unique(corners.round(7), axis=0), np.unique(1e-3 * ball.vertices.round(4), axis=0), atol=2e-7
        )
    short = tmp_path / "short.stl"
    short.write_bytes(plain[:-30])
    with pytest.raises(SetupError, match=r"short\.stl"):
        read_triangles(short, 0.001)
