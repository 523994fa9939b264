"""Several tools in one program: each operation is solved, written, read back and checked with the tool that does it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from calibration_sample import calibration
from process_story import KR15, PART, TOOL_FRAMES, TWO_TOOLS, cell_with, posted, story, text_of
from scipy.spatial.transform import Rotation

import camrob.jobs.post as job
import camrob.languages.krl.writer.write_krl as krl_writer
from camrob.cell.read_cell import read_cell
from camrob.controller.replay import replay
from camrob.errors import (
    CamrobError,
    InputError,
    JobError,
    ProgramError,
    SetupError,
    UnreachableError,
    VerificationError,
)
from camrob.jobs.compensate import compensate
from camrob.jobs.files.inputs import read_inputs
from camrob.jobs.place import place
from camrob.jobs.post import PostResult
from camrob.jobs.simulate import simulate
from camrob.jobs.verify import verify
from camrob.kinematics.frames import world_T_base
from camrob.kinematics.second_library import pinocchio_poses
from camrob.languages.read_program import read_program
from camrob.program.motion import Motion
from camrob.redundancy.planning.placement import place_stretches
from camrob.se3 import frame_from_mm_deg

POSE = (r"^spindle_rpm = ", "tool_change_pose = [20, -80, 100, 10, 60, 5, 300, 30]\nspindle_rpm = ")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> PostResult:
    folder = tmp_path_factory.mktemp("several")
    return posted(folder, "part.nc", PART, setup=TWO_TOOLS, cell=cell_with(folder, POSE))


def test_the_program(made: PostResult) -> None:
    """Both `$TOOL`s, each before the motions that are made with it, and each change at the cell's pose for changes."""
    lines = text_of(made).splitlines()
    tools = [line for line in lines if line.startswith("$TOOL")]
    assert [t.partition("Z ")[2].partition(",")[0] for t in tools] == ["415.57793", "355.00000", "415.57793"]
    for k, line in enumerate(lines):
        if line.startswith("HALT ;change to tool") and k > lines.index(tools[0]) + 5:
            assert lines[k - 1].startswith(
                "PTP {E6AXIS: A1 20.0000,A2 -80.0000,A3 100.0000,A4 10.0000,A5 60.0000,A6 5.0000,E1 300"
            )
            assert lines[k + 1].startswith("$TOOL")
    steps = [s for s in story(text_of(made)) if s[0].isalpha()]
    assert steps == [
        "home",
        "home",
        "tool 1",
        "speed 3000",
        "on",
        "off",
        "home",
        "tool 2",
        "mount",
        "speed 4000",
        "on",
        "off",
        "home",
        "tool 1",
        "mount",
        "speed 3500",
        "on",
        "off",
        "home",
        "off",
        "dry",
    ]
    assert [c.tool for c in made.summary.process.tool_changes] == ["ball 6", "mill 10"]
    assert "one-tool-for-several" not in {w.code for w in made.summary.warnings}
    assert made.summary.tracking.position_error_mm_max < 1e-6


def test_another_library_finds_each_tools_tip_at_the_points(made: PostResult) -> None:
    """Pinocchio, from the postures and the set-up's frames alone."""
    cell = read_cell(KR15)
    path, q = made.path, np.array(made.solution.q)
    for k, frame in enumerate((TOOL_FRAMES[0], TOOL_FRAMES[1], TOOL_FRAMES[0])):
        own = path.of_toolpath & (path.stretch == k)
        assert own.sum() >= 4
        poses = pinocchio_poses(cell.with_tool(frame_from_mm_deg(np.array(frame))), q[own])
        np.testing.assert_allclose(poses[:, :3, 3], path.base_T_tip[own, :3, 3], atol=1e-9)
        np.testing.assert_allclose(poses[:, :3, 2], path.base_T_tip[own, :3, 2], atol=1e-9)


def test_tools_of_a_library_are_those_of_their_lengths(tmp_path: Path) -> None:
    """The gauge line 160 mm behind the first tool's tip: a library with 160 and 110 mm makes what two frames make."""
    X, Y, Z, *abc = TOOL_FRAMES[0]
    along = Rotation.from_euler("ZYX", abc, degrees=True).as_matrix()[:, 2]
    line, second = ([float(v) for v in np.array([X, Y, Z]) + out * along] + abc for out in (160.0, 50.0))
    place = "part_in_base = [0, 0, 198, 0, 0, 0]\n"
    tool = "[[tool]]\nnumber = {}\nname = '{}'\nflange_to_tool = {}\ndiameter_mm = {}\nlength_mm = {}\n"
    framed = place + tool.format(1, "mill 10", TOOL_FRAMES[0], 10, 80) + tool.format(2, "ball 6", second, 6, 40)
    rows = (
        "number,name,diameter_mm,length_mm,gauge_length_mm\n1,mill 10,10,80,160\n2,ball 6,6,40,110\n9,other,3,20,70\n"
    )
    listed = place + f'tool_library = "tools.csv"\nflange_to_gauge_line = {line}\n'
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "tools.csv").write_text(rows)
    cell = cell_with(tmp_path, POSE)
    made = posted(tmp_path, "part.nc", PART, setup=listed, cell=cell)
    text = text_of(made)
    files = json.loads((made.out / "part.json").read_text())["manifest"]["setup"]
    assert set(files) == {"setup.toml", "tools.csv"}
    assert "one-tool-for-several" not in {w.code for w in made.summary.warnings}
    (tmp_path / "in" / "tools.csv").write_text(rows + "8,new,3,20,70\n")
    checked = verify(
        made.out / "part.src", cell=cell, setup=tmp_path / "in" / "setup.toml", against=tmp_path / "in" / "part.nc"
    )
    assert checked.ok is False and "manifest-differs" in {f.code for f in checked.findings}
    assert text == text_of(posted(tmp_path, "part.nc", PART, setup=framed, cell=cell))
    shared = "number,diameter_mm\n1,10\n2,6\n"  # no gauge line: all as the cell has its own
    (tmp_path / "in" / "tools.csv").write_text(shared)
    made = posted(tmp_path, "part.nc", PART, setup=place + 'tool_library = "tools.csv"\n', cell=cell)
    assert "one-tool-for-several" in {w.code for w in made.summary.warnings}


def test_verify_takes_each_tool_where_it_is_mounted(made: PostResult, tmp_path: Path) -> None:
    source = made.out.parent / "in" / "part.nc"
    cell = made.out.parent / "cell"
    checked = verify(made.out / "part.src", cell=cell, against=source)
    assert checked.ok and checked.summary.against.met == checked.summary.against.points
    assert checked.summary.replay.second_library_error_mm_max < 1e-6
    text = (made.out / "part.src").read_bytes()
    for name, changed in planted(text.decode()).items():
        (tmp_path / "part.src").write_bytes(changed.encode())
        (tmp_path / "part.dat").write_bytes((made.out / "part.dat").read_bytes())
        try:
            assert not verify(tmp_path / "part.src", cell=cell, against=source).ok, name
        except ProgramError as error:  # a LIN begins where the other tool's tip stands, which nothing says
            assert name == "late" and "more than one $TOOL" in error.what


def planted(text: str) -> dict[str, str]:
    """The same program with something wrong about its tools."""
    lines = text.split("\r\n")
    at = [k for k, line in enumerate(lines) if line.startswith("$TOOL")]
    left_out = [line for k, line in enumerate(lines) if k != at[1]]
    swapped = lines.copy()
    swapped[at[0]], swapped[at[1]] = lines[at[1]], lines[at[0]]
    longer = [line.replace("Z 355.0", "Z 356.0") for line in lines]
    late = lines.copy()
    late.insert(at[1] + 7, late.pop(at[1]))
    return {
        k: "\r\n".join(v) for k, v in {"left out": left_out, "swapped": swapped, "longer": longer, "late": late}.items()
    }


@pytest.mark.parametrize("name", ["left out", "swapped", "longer", "late"])
def test_a_text_with_another_tool_is_not_released(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    written = krl_writer.iter_krl

    def faulty(*arguments, **options):
        for file, data in written(*arguments, **options):
            yield file, planted(data.decode())[name].encode() if file.endswith(".src") else data

    monkeypatch.setattr(krl_writer, "iter_krl", faulty)
    with pytest.raises(VerificationError, match="not released"):
        posted(tmp_path, "part.nc", PART, setup=TWO_TOOLS)
    assert not (tmp_path / "out").exists()


def test_each_tool_is_checked_for_what_it_touches(tmp_path: Path) -> None:
    """A post beside the part that the first tool's spindle clears and that of the shorter one does not."""
    block = "box_mm = [44, -30, 0, 90, 30, 60]\n"
    second = PART.replace("X40", "X40 F300")
    free = posted(tmp_path, "part.nc", second, setup=TWO_TOOLS)
    assert free.summary.collisions.checked and free.summary.collisions.count == 0
    with pytest.raises(CamrobError) as caught:
        posted(tmp_path, "part.nc", second, setup=TWO_TOOLS + "[part]\n" + block)
    assert isinstance(caught.value, JobError) and "touches" in str(caught.value) and 12 <= caught.value.line <= 17
    long = TWO_TOOLS.replace("length_mm = 40", "length_mm = 100").replace(str(TOOL_FRAMES[1]), str(TOOL_FRAMES[0]))
    assert posted(tmp_path, "part.nc", second, setup=long + "[part]\n" + block).summary.collisions.count == 0


def test_planned_stretch_by_stretch(tmp_path: Path) -> None:
    made = posted(tmp_path, "part.nc", PART, setup=TWO_TOOLS, method="planned")
    assert made.summary.plan is not None and made.solution.method == "planned"
    assert made.summary.conditioning.inv_kf_mean <= made.summary.conditioning.inv_kf_bound_mean + 1e-9
    assert text_of(made).count("$TOOL = ") == 3
    assert verify(made.out / "part.src", cell=KR15, against=tmp_path / "in" / "part.nc").ok


def test_two_tools_at_the_same_points(tmp_path: Path) -> None:
    """A hole spotted and drilled: the second tool's points are met by the second tool, not by the first one's motions."""
    hole = "G0 X10 Y10 Z25\nG1 Z{} F200\nG0 Z25\n"
    content = f"%\nG21 G90 G17\nT1 M6\nS3000 M3\n{hole.format(4)}T2 M6\nS4000 M3\n{hole.format(2)}M30\n%\n"
    for name, setup in {"one": "part_in_base = [0, 0, 198, 0, 0, 0]\n", "two": TWO_TOOLS}.items():
        folder = tmp_path / name
        folder.mkdir()
        made = posted(folder, "part.nc", content, setup=setup)
        lines = [s for s in story(text_of(made)) if not s.startswith(("speed", "mount"))]
        assert lines == [
            "home",
            "tool 1",
            "on",
            "10 75",
            "10 25",
            "10 4",
            "10 25",
            "10 75",
            "off",
            "home",
            "tool 2",
            "on",
            "10 75",
            "10 25",
            "10 2",
            "10 25",
            "10 75",
            "off",
            "home",
            "off",
            "dry",
        ]
        assert verify(made.out / "part.src", cell=KR15, against=folder / "in" / "part.nc").ok


def test_an_optimal_feed_with_several_tools(tmp_path: Path) -> None:
    made = posted(tmp_path, "part.nc", PART, setup=TWO_TOOLS, feed="optimal")
    assert made.summary.time_s.optimal > 0.0
    assert verify(made.out / "part.src", cell=KR15, against=tmp_path / "in" / "part.nc").ok


@pytest.mark.slow
def test_an_arm_without_a_spherical_wrist(tmp_path: Path) -> None:
    old = r'(name = "A4"\nrole = "arm"\ntype = "revolute"\ndh = \{ alpha_deg = 90, a_mm = )0,'
    cell = cell_with(tmp_path, (old, r"\g<1>40,"), keep_poses=False)
    made = posted(tmp_path, "part.nc", PART, setup=TWO_TOOLS, cell=cell)
    text = text_of(made)
    assert "PTP {E6POS" not in text and text.count("$TOOL = ") == 3
    assert verify(made.out / "part.src", cell=cell, against=tmp_path / "in" / "part.nc").ok


def test_a_long_program_in_parts(tmp_path: Path) -> None:
    made = posted(tmp_path, "part.nc", PART, setup=TWO_TOOLS, max_lines=9)
    parts = sorted(made.out.glob("*.src"))
    assert len(parts) > 3 and sum(p.read_text().count("$TOOL = ") for p in parts) == 3


def test_the_report_of_a_job_with_several_tools(tmp_path: Path) -> None:
    (tmp_path / "part.nc").write_text(PART)
    (tmp_path / "setup.toml").write_text(TWO_TOOLS)
    made = job.post(tmp_path / "part.nc", cell=KR15, out=tmp_path / "out")
    assert (made.out / "part.html").stat().st_size > 10_000
    summary = json.loads((made.out / "part.json").read_text())
    assert summary["process"]["events_in_program"] == summary["process"]["events_in_file"] + 2  # the spindle off, twice


def test_a_tool_that_the_set_up_lacks(tmp_path: Path) -> None:
    with pytest.raises(SetupError, match="tool 2 is not set up"):
        posted(tmp_path, "part.nc", PART, setup=TWO_TOOLS.replace("number = 2", "number = 3"))


def test_a_place_is_one_at_which_every_tool_works(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The bound of a placement is that of the tools' own, by how much each cuts; and the proposed place can be posted."""
    clfile = tmp_path / "part.nc"
    clfile.write_text(PART)
    (tmp_path / "setup.toml").write_text(TWO_TOOLS)
    monkeypatch.setattr("camrob.jobs.solving.place_trial._TRIALS", 1)
    said = place(clfile, cell=KR15, out=tmp_path / "out", x_mm=150.0, y_mm=0.0).summary
    inputs = read_inputs(clfile, read_cell(KR15), None)
    here, shifts = np.asarray(inputs.setup.base_T_part), np.zeros((0, 3))
    alone = [place_stretches([(cell, path)], here, shifts) for cell, path in inputs.by_stretch()]
    assert said.now.inv_kf_bound_min == pytest.approx(min(float(a.worst[0]) for a in alone))
    means = [float(a.mean[0]) for a in alone]
    assert min(means) + 1e-3 < said.now.inv_kf_bound_mean < max(means) - 1e-3
    assert not said.stays and said.best.standing == "free" and said.best.trial is not None
    there = str(list(said.best.part_in_base))
    made = posted(tmp_path, "part.nc", PART, setup=TWO_TOOLS.replace("[0, 0, 198, 0, 0, 0]", there))
    assert made.summary.conditioning.inv_kf_min > 0.0
    (tmp_path / "far.toml").write_text(TWO_TOOLS.replace("[0, 0, 198,", "[0, 0, 1500,"))
    with pytest.raises(UnreachableError):
        place(clfile, cell=KR15, out=tmp_path / "out", setup=tmp_path / "far.toml", x_mm=0.0, y_mm=0.0)


def test_the_run_on_the_ideal_controller_is_one_log_with_each_tool_at_its_time(
    made: PostResult, tmp_path: Path
) -> None:
    """The tip of every row is where Pinocchio has it for the row's axes, with the tool that the text sets there."""
    folder = cell_with(tmp_path, POSE)
    result = simulate(made.out / "part.src", cell=folder, out=tmp_path / "run.csv", report=tmp_path / "run.html")
    cell, log = read_cell(folder), result.simulation.log
    text = read_program(made.out / "part.src")
    replayed = replay(text, cell)
    t, motion = np.asarray(log.columns["t"]), np.asarray(result.simulation.motion)
    assert np.allclose(np.diff(t), 0.012) and np.all(np.diff(motion) >= 0) and motion[-1] == len(text) - 1
    assert np.array_equal(np.asarray(log.columns["line"]), np.asarray(text.line)[motion])
    q = cell.to_q(np.stack([log.columns[name] for name in cell.axis_names], axis=1))
    tip = np.stack([log.columns[name] for name in "xyz"], axis=1) / 1e3
    used = np.asarray(replayed.mounted)[motion]
    assert set(used.tolist()) == {0, 1}
    for k, held in enumerate(replayed.cells):
        rows = np.flatnonzero(used == k)[::7]
        world = world_T_base(held, q[rows]) @ pinocchio_poses(held, q[rows])
        off = np.linalg.norm(world[:, :3, 3] - tip[rows], axis=1)
        assert off.max() < 1e-6
    blocks = result.summary.blocks
    judged = verify(made.out / "part.src", cell=folder, manifest=False).summary.replay
    assert judged is not None and judged.blocks == blocks


def test_each_tool_is_compensated_with_its_own_lever(made: PostResult, tmp_path: Path) -> None:
    """An arm whose A2 stands 1 mrad on meets each tool's targets, by Pinocchio with that angle; a force is of one tool."""
    folder, program = cell_with(tmp_path, POSE), made.out / "part.src"
    cell, text = read_cell(folder), read_program(program)
    fitted = calibration(tmp_path / "fitted.toml", {"A2.zero": 1e-3, "tool.x": 1e-9})
    result = compensate(program, cell=folder, calibration=fitted, out=tmp_path / "out")
    meant, done = (replay(read_program(p), cell) for p in (program, tmp_path / "out" / "part.src"))
    posed = ~np.isin(text.kind, [Motion.PTP_AXES, Motion.CIRC_VIA])
    q = np.array(done.q)
    q[:, cell.index("A2")] += 1e-3
    for k, held in enumerate(meant.cells):
        rows = np.flatnonzero(posed & (np.asarray(meant.mounted) == k))
        assert len(rows) > 3
        tip = pinocchio_poses(held, q[rows])[:, :3, 3]
        np.testing.assert_allclose(tip, np.asarray(meant.base_T_tool)[rows, :3, 3], atol=3e-6)
    assert result.summary.error_before.max_mm > 0.5 and result.summary.error_after.max_mm < 2e-3
    assert "tool-of-one" in {w.code for w in result.summary.warnings}
    (tmp_path / "FORCE.toml").write_text("[mean]\nalong_n = 50\nacross_n = 0\naxial_n = 0\n")
    with pytest.raises(InputError, match="pushes on one tool, and part"):
        compensate(program, cell=folder, calibration=fitted, force=tmp_path / "FORCE.toml", out=tmp_path / "no")
