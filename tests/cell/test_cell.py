"""The KR15 cell's data, its bodies, and what the reader says to broken cells."""

from __future__ import annotations

import re
import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest
import trimesh

from camrob.cell.joint import Role
from camrob.cell.read_cell import read_cell
from camrob.cell.shape import ShapeKind
from camrob.errors import CellError
from camrob.kinematics import frames
from camrob.toml.read_toml import read_toml
from camrob.toml.table_reader import PROVENANCES
from camrob.units import deg_to_rad, m_to_mm, mm_to_m, rad_to_deg

FOLDER = Path(__file__).resolve().parents[2] / "cells" / "kr15_track_table"
TEXT = (FOLDER / "cell.toml").read_text(encoding="utf-8")
CELL = read_cell(FOLDER)


# --- what the cell says


def test_chain_and_its_names():
    assert CELL.names == ("E2", "E1", "A1", "A2", "A3", "A4", "A5", "A6", "roll")
    assert CELL.axis_names == ("A1", "A2", "A3", "A4", "A5", "A6", "E1", "E2")
    assert CELL.external_names == ("E1", "E2")
    assert CELL.arm_slice == slice(2, 8)
    assert [j.name for j in CELL.joints if j.endless] == ["E2", "roll"]
    assert CELL.base_follows_table
    with pytest.raises(KeyError, match="A7"):
        CELL.index("A7")


def test_home_as_krl_prints_it():
    np.testing.assert_allclose(CELL.to_axis_values(CELL.q_home), [0, -90, 90, 0, 90, 0, 0, 0], atol=1e-12)
    expected = [np.pi, 0.0, np.pi, -np.pi / 2, 0.0, 0.0, np.pi / 2, 0.0, 0.0]
    np.testing.assert_allclose(CELL.q_home, expected, atol=1e-15)
    np.testing.assert_allclose(CELL.q_reference, expected, atol=1e-15)


def test_axis_values_map_to_the_table_of_the_paper():
    """A1 = theta_1 - 180, A2 = theta_2, A3 = theta_3 + 90, A4 = theta_4, A5 = 180 - theta_5, A6 = theta_6, E1, E2."""
    q = np.array([deg_to_rad(211.0), mm_to_m(345.0), *np.radians([170.0, -75.0, 12.0, 33.0, 99.0, -44.0, 17.0])])
    np.testing.assert_allclose(CELL.to_axis_values(q), [-10, -75, 102, 33, 81, -44, 345, 31], atol=1e-10)
    np.testing.assert_allclose(CELL.to_q(CELL.to_axis_values(q), roll=q[-1]), q, atol=1e-14)


@pytest.mark.parametrize(
    ("name", "lower", "upper", "speed", "acceleration"),
    [
        ("A1", -185, 185, 152, 350),
        ("A2", -145, 25, 152, 300),
        ("A3", -120, 160, 152, 350),
        ("A4", -350, 350, 284, 700),
        ("A5", -135, 135, 293, 700),
        ("A6", -350, 350, 604, 1400),
        ("E1", -1500, 1500, 1000, 1500),
        ("E2", -np.inf, np.inf, 60, 120),
    ],
)
def test_limits(name, lower, upper, speed, acceleration):
    joint = CELL.joints[CELL.index(name)]
    to_edge = m_to_mm if joint.prismatic else rad_to_deg
    values = [to_edge(v) for v in (joint.lower, joint.upper, joint.speed, joint.acceleration, joint.jerk)]
    assert values == pytest.approx([lower, upper, speed, acceleration, 10 * acceleration])
    ends = sorted(float(joint.axis_value(np.array(v))) for v in (joint.q_lower, joint.q_upper))
    assert ends == pytest.approx([joint.lower, joint.upper])


def test_every_number_has_a_provenance():
    assert set(CELL.provenance.values()) <= set(PROVENANCES)
    assert CELL.provenance["joint[A3].dh.a_mm"] == "paper"
    assert CELL.provenance["joint[A3].limits.range_deg"] == "assumed"
    assert CELL.provenance["kinematics.characteristic_length_mm"] == "paper"
    assert CELL.provenance["shape[A2 upper arm].size_mm"] == "assumed"

    def leaves(value, key=""):
        if isinstance(value, dict):
            for k, v in value.items():
                if k not in ("standing", "schema"):
                    yield from leaves(v, f"{key}.{k}" if key else k)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            for i, v in enumerate(value):
                yield from leaves(v, f"{key}[{v.get('name', i)}]")
        elif not isinstance(value, str | bool) and not (isinstance(value, list) and isinstance(value[0], str)):
            yield key

    assert set(leaves(tomllib.loads(TEXT))) == set(CELL.provenance)


def test_masses_are_the_specs_in_table_1s_own_frames():
    """Flange and spindle are given in Table 1's A6 row, which ends behind the plate, tilted by 0.3564 rad."""
    row = np.array([[1, 0, 0], [0, np.cos(0.3564), -np.sin(0.3564)], [0, np.sin(0.3564), np.cos(0.3564)]])
    shift = np.array([0.0, 0.0, -443.4 + 140.0])  # from the plate's row (d = -140) to Table 1's (d = -443.4)
    masses = {m.name: m for m in CELL.masses}
    for name, kg, expected in (("A6 flange", 4.0, [0, 127, 341]), ("spindle and tool", 12.0, [0, 0, 130])):
        assert masses[name].mass == kg
        np.testing.assert_allclose(m_to_mm(masses[name].center), row @ expected + shift, atol=1e-3)
    assert [m.mass for m in CELL.masses] == [42, 48, 22, 4, 12]


def test_nothing_can_be_changed_behind_ones_back():
    with pytest.raises(ValueError, match="read-only"):
        CELL.flange_T_tool[0, 3] = 1.0
    with pytest.raises(AttributeError):
        CELL.name = "other"
    with pytest.raises(TypeError):
        CELL.provenance["x"] = "paper"


def test_another_tool_is_another_cell():
    longer = CELL.flange_T_tool.copy()
    longer[2, 3] += 0.1
    other = CELL.with_tool(longer)
    assert other.digest != CELL.digest
    assert CELL.with_tool(CELL.flange_T_tool).digest == CELL.digest
    np.testing.assert_array_equal(other.flange_T_tool, longer)


def test_the_spindles_range_and_the_pose_for_changing_tools(tmp_path):
    assert CELL.controller.spindle_rpm == (1000.0, 24000.0)
    assert CELL.controller.tool_change_pose is None
    pose = "tool_change_pose = [10, -90, 90, 0, 90, 0, -700, 45]"
    text = TEXT.replace("act_ex_ax = 2", "act_ex_ax = 2\n" + pose)
    (tmp_path / "cell.toml").write_text(re.sub(r"(?m)^spindle_rpm.*\n", "", text), encoding="utf-8")
    own = read_cell(tmp_path).controller
    assert own.spindle_rpm is None
    assert own.tool_change_pose == (10, -90, 90, 0, 90, 0, -700, 45)  # A1..A6, E1, E2


# --- bodies


def body(shape):
    if shape.kind is ShapeKind.BOX:
        return trimesh.creation.box(extents=shape.size)
    if shape.kind is ShapeKind.CYLINDER:
        return trimesh.creation.cylinder(radius=shape.size[0], height=shape.size[1])
    assert shape.kind is ShapeKind.CAPSULE
    mesh = trimesh.creation.capsule(radius=shape.size[0], height=shape.size[1])
    mesh.apply_translation([0.0, 0.0, -mesh.bounds[:, 2].mean()])
    return mesh


@pytest.fixture(scope="module")
def touching():
    """A function: axis values -> pairs of groups that touch and may not."""
    manager = trimesh.collision.CollisionManager()
    for shape in CELL.shapes:
        manager.add_object(shape.name, body(shape))
    shapes = {s.name: s for s in CELL.shapes}

    def pairs(axis_values):
        q = CELL.to_q(np.array(axis_values, float))
        world_T_base = frames.world_T_base(CELL, q)
        placed = dict(zip(CELL.names, world_T_base @ frames.base_T_joint_frames(CELL, q), strict=True))
        placed |= {"world": np.eye(4), "base": world_T_base, "root": world_T_base @ frames.base_T_root(CELL, q)}
        placed |= {"flange": world_T_base @ frames.base_T_flange(CELL, q)}
        placed |= {"tool": world_T_base @ frames.base_T_tool(CELL, q)}
        for s in CELL.shapes:
            manager.set_transform(s.name, placed[s.frame] @ s.frame_T_shape)
        found = set()
        for a, b in manager.in_collision_internal(return_names=True)[1]:
            one, two = shapes[a], shapes[b]
            if one.group != two.group and one.group not in two.ignore and two.group not in one.ignore:
                found.add(frozenset((one.group, two.group)))
        return found

    return pairs


@pytest.mark.parametrize("e1", [-1500, 0, 1500])
@pytest.mark.parametrize("e2", [0, 90])
@pytest.mark.parametrize("a6", [-90, 0, 90])
def test_nothing_touches_at_home(touching, e1, e2, a6):
    assert touching([0, -90, 90, 0, 90, a6, e1, e2]) == set()


def test_bodies_find_what_a_person_would_see(touching):
    assert touching([0, -90, 0, 0, 0, 0, 0, 0]) == set()  # straight up
    assert frozenset(("A2", "table")) in touching([0, 25, 90, 0, 90, 0, 0, 0])  # the arm lies on the table
    assert touching([0, 25, 90, 0, 90, 0, 1500, 0]).isdisjoint({frozenset(("A2", "table"))})  # which is not there
    assert frozenset(("A4", "spindle")) in touching([0, -90, 90, 0, 135, 0, 0, 0])  # the hand folded under the forearm
    assert frozenset(("A1", "A3")) in touching([0, -145, 90, 0, 90, 0, 0, 0])  # the elbow's motors in the column


def test_the_tool_body_ends_at_the_tip():
    tool = next(s for s in CELL.shapes if s.group == "tool")
    assert tool.frame_T_shape[2, 3] - tool.size[1] / 2 == pytest.approx(0.0, abs=1e-12)


def test_arm_bodies_follow_the_links():
    """Each link's bodies hold the link's own line, from joint to joint (inside the bounds, in world at HOME)."""
    placed = dict(zip(CELL.names, frames.base_T_joint_frames(CELL, CELL.q_home), strict=True))
    bounds = {}
    for group in ("A2", "A3", "A4"):
        corners = []
        for s in (s for s in CELL.shapes if s.group == group):
            corners.extend(body(s).apply_transform(placed[s.frame] @ s.frame_T_shape).bounds)
        bounds[group] = np.min(corners, axis=0), np.max(corners, axis=0)
    for group, points_mm in (
        ("A2", [(-503, 0, 370), (-503, 0, 1020)]),
        ("A3", [(-503, 0, 1020), (-503, 0, 1175), (-253, 0, 1175)]),
        ("A4", [(97, 0, 1175)]),
    ):
        for point in points_mm:
            assert np.all(bounds[group][0] < mm_to_m(np.array(point, float)))
            assert np.all(bounds[group][1] > mm_to_m(np.array(point, float)))


# --- other cells


def without(text, *names):
    """The cell without some joints and what speaks of them."""
    blocks = re.split(r"(?m)^(?=\[)", text)
    kept = [b for b in blocks if not (b.startswith("[[joint]]") and any(f'name = "{n}"' in b for n in names))]
    text = "".join(kept)
    for name in names:
        text = re.sub(rf'\b{name} = "w_[A-Za-z]+",? ?', "", text)
    return text


def test_a_bare_arm_is_a_cell(tmp_path):
    (tmp_path / "cell.toml").write_text(without(TEXT, "E1", "E2", "roll"), encoding="utf-8")
    cell = read_cell(tmp_path)
    assert cell.names == ("A1", "A2", "A3", "A4", "A5", "A6")
    assert cell.indices(Role.WORKPIECE) == ()
    np.testing.assert_allclose(frames.base_T_root(cell, cell.q_home), cell.foot_T_root)
    # root at the base of a plain arm: the foot's own numbers of Table 1
    root_T_flange = np.linalg.inv(frames.base_T_root(cell, cell.q_home)) @ frames.base_T_flange(cell, cell.q_home)
    np.testing.assert_allclose(m_to_mm(root_T_flange[:3, 3]), [900.0, 0.0, 1340.0], atol=1e-9)
    np.testing.assert_allclose(frames.world_T_base(cell, cell.q_home), np.eye(4))


def test_a_file_and_its_folder_are_the_same_cell():
    assert read_cell(FOLDER / "cell.toml").digest == read_cell(str(FOLDER)).digest == CELL.digest


# --- broken cells

SHAPE = '[[shape]]\nname = "tool"\n'
BROKEN = [
    # (what is in the file, what stands there instead, what the message must hold)
    ("a_mm = 803,", "", "joint[E2].dh.a_mm: is missing; give a number"),
    ("a_mm = 803,", "amm = 803,", "joint[E2].dh.a_mm: is missing; give a number; is amm meant for it?"),
    ("a_mm = 803,", 'a_mm = "803",', "joint[E2].dh.a_mm: is '803'; give a finite number"),
    ("a_mm = 803,", "a_mm = true,", "joint[E2].dh.a_mm: is True"),
    ("a_mm = 803,", "a_mm = nan,", "joint[E2].dh.a_mm: is nan"),
    ("a_mm = 803,", "a_mm = inf,", "joint[E2].dh.a_mm: is inf"),
    ("a_mm = 803,", f"a_mm = 1{'0' * 400},", "joint[E2].dh.a_mm: is 1000"),
    ("a_mm = 803,", f"a_mm = 1{'0' * 5000},", "is not valid TOML"),
    (
        "a_mm = 803,",
        "a_mm = 803, b_mm = 1,",
        "joint[E2].dh.b_mm: is not a key that camrob knows here; use a_mm, alpha_deg",
    ),
    ("range_deg = [-145, 25]", "range_deg = [25, -145]", "joint[A2].limits.range_deg: has its lower end above"),
    ("range_deg = [-145, 25]", "range_deg = [-145]", "joint[A2].limits.range_deg: is [-145]; give a list of 2"),
    ("range_deg = [-145, 25]", "range_deg = [-145, nan]", "joint[A2].limits.range_deg"),
    ("range_deg = [-145, 25]", "range_deg = [-80, 25]", "joint[A2].home_deg: lies outside the axis's range"),
    ("reference_deg = -90", "reference_deg = 90", "joint[A2].reference_deg: lies outside the axis's range"),
    ("speed_deg_s = 284", "speed_deg_s = 0", "joint[A4].limits.speed_deg_s: is 0; give a number from"),
    ("speed_deg_s = 284", "speed_deg_s = -284", "joint[A4].limits.speed_deg_s: is -284"),
    (
        "axis = { sign = -1, offset_deg = 180 }",
        "axis = { sign = 0.5, offset_deg = 180 }",
        "joint[A5].axis.sign: is 0.5",
    ),
    ("axis = { sign = -1, offset_deg = 180 }", "axis = 3", "joint[A5].axis: is 3; give a table"),
    ('name = "A2"', 'name = "A1"', "joint: 'A1' appears twice; give every joint a name of its own"),
    ('name = "A2"', 'name = "A9"', "the arm's joints are not A1, A2"),
    ('name = "E1"\n', 'name = "X1"\n', "joint: 'X1' is not a name of an external axis; use E1 .. E6"),
    ('role = "workpiece"', 'role = "arm"', "roles are out of order"),
    ('role = "carriage"', 'role = "boat"', "role: is 'boat'; use one of workpiece, carriage, arm, roll"),
    ('type = "prismatic"', 'type = "sliding"', "joint[E1].type: is 'sliding'"),
    ('name = "roll"', 'name = "r; HALT"', "is not a name for a joint"),
    ("schema = 1", "schema = 2", "schema: is 2; give a number from 1 to 1"),
    ("schema = 1\n", "", "schema: is missing"),
    ("characteristic_length_mm = 350.57", "characteristic_length_mm = 0", "kinematics.characteristic_length_mm: is 0"),
    ("base_follows_table = true", 'base_follows_table = "yes"', "kinematics.base_follows_table: is 'yes'"),
    ('standing = { flange_to_tool = "paper" }\n', "", "tool.flange_to_tool: has no provenance"),
    ('standing = { flange_to_tool = "paper" }', 'standing = "hearsay"', "tool.standing: 'hearsay' is not a provenance"),
    ('standing = { flange_to_tool = "paper" }', 'standing = { x = "paper" }', "tool.flange_to_tool: has no provenance"),
    ('after = "A2"', 'after = "A7"', "mass[A2 arm].after: is 'A7'; use one of E2, E1, A1"),
    ("mass_kg = 42", "mass_kg = -42", "mass[A2 arm].mass_kg: is -42"),
    ("mass_kg = 42", "mass_kg = 4,2", "write a decimal point for the comma"),
    ("mass_kg = 42", 'mass_kg = 42\nfile = "C:\\Users\\x.stl"', "write paths with /, or between single quotes"),
    ("speed_deg_s = 60", "speed_deg_s = -60", "joint[E2].limits.speed_deg_s: is -60; give a number from 1e-06 up"),
    ("payload_kg = 15", "payload_kg = [15]", "load.payload_kg: is [15]"),
    ("size_mm = [5, 80]", "size_mm = [5, 0]", "shape[tool].size_mm: is not above 0"),
    ("size_mm = [5, 80]", "size_mm = [5, 80, 1]", "shape[tool].size_mm: is [5, 80, 1]; give a list of 2"),
    (SHAPE, '[[shape]]\nname = "spindle"\n', "shape[spindle].name: appears twice"),
    (SHAPE + 'group = "tool"', '[[shape]]\nname = "t"\ngroup = "part"', "shape[t].group: is 'part'"),
    ('ignore = ["A5", "tool"]', 'ignore = ["A5", "toll"]', "'toll' is not a group of this cell; use A1, A2"),
    ('frame = "flange"', 'frame = "flansch"', "is 'flansch'; use one of world, base, root, flange, tool, E2"),
    ('kind = "capsule"', 'kind = "mesh"\nscale = 1\nfile = "../../x.stl"', "is not a file in the cell's folder"),
    ('kind = "capsule"', 'kind = "egg"', "kind: is 'egg'"),
    ('E1 = "w_L", A3', 'E7 = "w_L", A3', "resolve.joint_engine.weights.E7: is not a joint of this cell"),
    ("[1000, 24000]", "[24000, 1000]", "controller.spindle_rpm: is [24000, 1000]; give [least, most]"),
    ("[1000, 24000]", "[-1, 24000]", "controller.spindle_rpm: is [-1, 24000]; give [least, most]"),
    ("[1000, 24000]", "24000", "controller.spindle_rpm: is 24000; give a list of 2"),
    ("act_ex_ax = 2", "act_ex_ax = 2\ntool_change_pose = [0, -90]", "tool_change_pose: is [0, -90]; give a list of 8"),
    (
        "act_ex_ax = 2",
        "act_ex_ax = 2\ntool_change_pose = [0, -90, 90, 0, 90, 0, 1600, 0]",
        "controller.tool_change_pose: E1 1600 lies outside the axis's range",
    ),
    ("threshold = 0.5", "threshold = 5", "resolve.threshold: is 5; give a number from 0 to 1"),
    ("[load]", "[loads]", "load: is missing; give a table"),
    ("[[mass]]\nname", "[mass]\nname", "is not valid TOML"),
    ("[load]", "[load", "is not valid TOML"),
    ('title = "KUKA', 'title = "\\u001b[31mKUKA\\nHALT', "title: is '"),
    ("schema = 1", 'schema = 1\n"a\\nb\\u001b" = 2', "is not a key that camrob knows here"),
]


@pytest.mark.parametrize(("old", "new", "message"), BROKEN, ids=range(len(BROKEN)))
def test_broken_cells_are_refused_by_name(tmp_path, old, new, message):
    assert old in TEXT
    file = tmp_path / "cell.toml"
    file.write_text(TEXT.replace(old, new, 1) if "[[mass]]" not in old else TEXT.replace(old, new), encoding="utf-8")
    with pytest.raises(CellError) as caught:
        read_cell(tmp_path)
    text = str(caught.value)
    assert text.startswith(str(file))
    assert message in text
    assert "; " in text  # what, and what to do
    assert text.isprintable()
    assert len(text) < 400 + len(str(file))


def test_bad_toml_names_its_line(tmp_path):
    (tmp_path / "cell.toml").write_text("schema = 1\nname = \n", encoding="utf-8")
    with pytest.raises(CellError) as caught:
        read_cell(tmp_path)
    assert caught.value.line == 2
    assert f"{tmp_path / 'cell.toml'}:2: is not valid TOML" in str(caught.value)


@pytest.mark.parametrize(
    ("text", "cure"),
    [
        (
            'name = "a"\nname = "b"\n',
            ":2: is not valid TOML: a key is given a second time at column 11; leave one of its lines",
        ),
        ("name = \u201ca\u201d\n", ":1: is not valid TOML: Invalid value at column 8; write straight quotes"),
    ],
)
def test_slips_of_a_text_processor_and_keys_given_again_are_named(tmp_path, text: str, cure: str):
    (tmp_path / "cell.toml").write_text(text, encoding="utf-8")
    with pytest.raises(CellError, match=re.escape(cure)):
        read_cell(tmp_path)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "schema: is missing, for the file is empty; write schema = 1 above all else"),
        (b"part_in_base = [0, 0, 0, 0, 0, 0]\n", "is a job's set-up, not a cell; name it behind --setup"),
        (b"\xff\xfe\x00\x80", "is not UTF-8 text; save it as UTF-8"),
        (bytes(range(256)), "is not UTF-8 text"),
        (b"\x00" * 100, "is not valid TOML"),
        (b"a = " + b"[" * 100_000, "is not valid TOML"),
        (b"joint = 3\nschema = 1\n[kinematics]\n", "joint: is not an array of tables; write [[joint]]"),
        (b"schema = 1\n[kinematics]\n", "the arm's joints are not A1, A2"),
        (TEXT.encode("utf-16"), "is not UTF-8 text"),
    ],
    ids=range(9),
)
def test_files_that_are_no_cells(tmp_path, content, message):
    (tmp_path / "cell.toml").write_bytes(content)
    with pytest.raises(CellError) as caught:
        read_cell(tmp_path)
    assert message in str(caught.value)
    assert str(caught.value).isprintable()


def test_paths_that_are_no_cells(tmp_path):
    """A file of another kind, a folder of something else, and a folder by the name of a file."""
    (tmp_path / "part.cls").write_text("GOTO/1,2,3\n")
    (tmp_path / "odd.toml").mkdir()
    for place, what in (
        (tmp_path / "part.cls", "part.cls: is no cell; give the folder that holds the cell's cell.toml"),
        (tmp_path, "there is no cell.toml in this folder; give the folder"),
        (tmp_path / "odd.toml", "there is no cell.toml in this folder"),
        (tmp_path / "gone", "cell.toml: can't be read (No such file or directory); check the path"),
    ):
        with pytest.raises(CellError, match=re.escape(what)):
            read_cell(place)
    with pytest.raises(CellError, match=r"odd\.toml: is a folder; name the \.toml file in it"):
        read_toml(tmp_path / "odd.toml")


def test_a_byte_order_mark_and_crlf_do_no_harm(tmp_path):
    (tmp_path / "cell.toml").write_bytes(b"\xef\xbb\xbf" + TEXT.replace("\n", "\r\n").encode())
    assert read_cell(tmp_path).digest == CELL.digest


@pytest.mark.parametrize("path", ["nowhere", "x" * 5000, "nul\0byte", "nowhere/cell.toml"])
def test_missing_cells(tmp_path, path):
    with pytest.raises(CellError) as caught:
        read_cell(str(tmp_path / path))
    assert "\n" not in str(caught.value)


KR15_FOLDER = Path(__file__).resolve().parents[2] / "cells" / "kr15_track_table"


def test_limits_may_say_of_each_number_where_it_is_from(tmp_path) -> None:
    """As the cell's page shows it: the ranges of a data sheet beside accelerations that nobody knows."""
    shutil.copytree(KR15_FOLDER, tmp_path / "cell")
    readme = (tmp_path / "cell" / "README.md").read_text(encoding="utf-8")
    shown = re.search(r"`(limits = \{ range_deg = .*standing = .*\})`;", readme)[1]
    file = tmp_path / "cell" / "cell.toml"
    text, count = re.subn(
        r"limits = \{ range_deg = \[-185, 185\][^}]*\}", shown, file.read_text(encoding="utf-8"), count=1
    )
    file.write_text(text, encoding="utf-8")
    before, after = (read_cell(f) for f in (KR15_FOLDER, tmp_path / "cell"))
    assert count == 1
    for axis in ("A1", "A2"):
        i = before.index(axis)
        assert (before.joints[i].lower, before.joints[i].speed) == (after.joints[i].lower, after.joints[i].speed)


def test_seconds_for_the_milliseconds_of_a_block_are_refused(tmp_path):
    (tmp_path / "cell.toml").write_text(re.sub(r"(?m)^block_ms = 12 ", "block_ms = 0.012 ", TEXT), encoding="utf-8")
    with pytest.raises(CellError, match=r"block_ms is 0\.012"):
        read_cell(tmp_path)
