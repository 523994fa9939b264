"""Every tolerance that decides about a release, from both sides: a tenth within it passes, a tenth beyond it doesn't.

The contract's own two (0.01 mm and 0.01 degrees from the CL points) are in tests/controller/test_against.py.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import camrob.checks.collisions as collisions
import camrob.checks.margins as margins
import camrob.controller.against as against
import camrob.controller.intended as intended
import camrob.controller.judge as gate
import camrob.controller.jumps as jumps
import camrob.controller.replay as replaying
import camrob.jobs.post as job
import camrob.jobs.release.release as release
import camrob.jobs.release.solved as solved
from camrob.findings import Finding, Severity
from camrob.jobs.files.cell_for import cell_for
from camrob.jobs.files.inputs import JobInputs, read_inputs
from camrob.jobs.release.release import ReadBack, cover_toolpath, hold_to_tool, path_margins, read_back
from camrob.languages import language_named
from camrob.program.motion import Motion
from camrob.redundancy.path import REPEATED
from camrob.units import deg_to_rad, m_to_mm, mm_to_m

ROOT = Path(__file__).resolve().parents[2]
CELL = ROOT / "cells" / "kr15_track_table"
PART = (
    "TOOL PATH/A,TOOL,B\nTLDATA/MILL,10,0,50,0,0\nMSYS/0,0,0,1,0,0,0,1,0\nRAPID\nGOTO/0,0,50,0,0,1\nFEDRAT/MMPM,900\nGOTO/0,0,0\n"
    "GOTO/60,10,0\nGOTO/60,50,2\nGOTO/0,40,1\nRAPID\nGOTO/0,40,50\nEND-OF-PATH\n"
)
PLACE = "part_in_base = [20, -30, 250, 0, 0, 0]\n"


class Posted:
    """A program that passes, with all that was made on the way."""

    def __init__(self, folder: Path) -> None:
        (folder / "part.cls").write_text(PART)
        (folder / "setup.toml").write_text(PLACE)
        self.inputs: JobInputs = read_inputs(folder / "part.cls", cell_for("post", CELL), None)
        made = job.post(folder / "part.cls", cell=CELL, out=folder / "out", report=False)
        self.program, self.solution, self.source = made.program, made.solution, made.out / "part.src"
        self.back: ReadBack = read_back(self.source, self.program, self.inputs, self.solution, lambda share: None)
        self.feed = cover_toolpath(self.back.text, self.back.replayed, self.inputs)[1]
        row = int(np.flatnonzero(np.asarray(self.program.speed) == 0.015)[1])
        assert self.program.kind[row] == Motion.LIN
        self.row = row  # a LIN in the cut

    def judged(self, **changed: np.ndarray) -> list[Finding]:
        """What the gate says of the replay with other arrays."""
        return self.errors(
            gate.judge(self.back.text, replace(self.back.replayed, **changed), self.back.coverage, self.feed).findings
        )

    @staticmethod
    def errors(findings: list[Finding] | tuple[Finding, ...]) -> list[Finding]:
        return [f for f in findings if f.severity is Severity.ERROR]

    def at(self, name: str, value: object, column: object = Ellipsis) -> np.ndarray:
        """An array of the replay with another value at the row."""
        values = np.array(getattr(self.back.replayed, name))
        values[(self.row, column) if column is not Ellipsis else self.row] = value
        return values


@pytest.fixture(scope="module")
def posted(tmp_path_factory: pytest.TempPathFactory) -> Posted:
    return Posted(tmp_path_factory.mktemp("posted"))


Case = Callable[[Posted, float], list[Finding]]
"""What stands against the program where something is `share` of a tolerance away from what it should be."""


def beyond_a_limit(p: Posted, share: float) -> list[Finding]:
    return p.judged(margin=p.at("margin", -share * gate.LIMIT_TOLERANCE, 4))


def badly_conditioned(p: Posted, share: float) -> list[Finding]:
    return p.judged(inv_kf=p.at("inv_kf", gate.SINGULAR_INV_KF / share))


def straight_wrist(p: Posted, share: float) -> list[Finding]:
    return p.judged(bend=p.at("bend", gate.SINGULAR_BEND / share))


def second_library(p: Posted, share: float) -> list[Finding]:
    frames = np.array(p.back.replayed.base_T_tool)
    frames[p.row, 0, 3] += share * gate.POSE_TOLERANCE
    return p.judged(base_T_tool=frames)


def too_fast(p: Posted, share: float) -> list[Finding]:
    speed = np.array(p.back.text.speed)
    speed[p.row] = 0.015 * (1.0 + share * gate.SPEED_TOLERANCE) + 1e-6 * (share > 1.0)
    text = replace(p.back.text, speed=speed)
    return p.errors(gate.judge(text, p.back.replayed, p.back.coverage, p.feed).findings)


def table_leaps(p: Posted, share: float) -> list[Finding]:
    q = np.array(p.back.replayed.q)
    table = p.inputs.cell.index("E2")
    air = int(np.flatnonzero(np.asarray(p.program.kind) == Motion.LIN)[-1])  # no cutting: only the turn itself counts
    q[air:, table] += share * jumps.MOST_TURN - (q[air, table] - q[air - 1, table])
    return p.errors(jumps.axis_jumps(p.back.text, replace(p.back.replayed, q=q)))


def axis_leaps(p: Posted, share: float, *, axis: str, slack: float) -> list[Finding]:
    """While cutting an axis may move by its slack, or by ten times what its top speed allows, whichever is more."""
    q = np.array(p.back.replayed.q)
    k = p.inputs.cell.index(axis)
    poses = np.asarray(p.back.replayed.base_T_tool)
    seconds = np.linalg.norm(poses[p.row, :3, 3] - poses[p.row - 1, :3, 3]) / 0.015
    slow = tuple(replace(j, speed=1e-6) if i == k else j for i, j in enumerate(p.inputs.cell.joints))
    allowed = max(slack, jumps.TIMES_TOP_SPEED * 1e-6 * seconds)
    q[p.row :, k] += share * allowed - abs(q[p.row, k] - q[p.row - 1, k]) * np.sign(q[p.row, k] - q[p.row - 1, k])
    replayed = replace(p.back.replayed, q=q, cell=replace(p.back.replayed.cell, joints=slow))
    return [f for f in jumps.axis_jumps(p.back.text, replayed, p.back.coverage, p.feed) if f.axis == axis]


def times_top_speed(p: Posted, share: float) -> list[Finding]:
    poses = np.asarray(p.back.replayed.base_T_tool)
    seconds = np.linalg.norm(poses[p.row, :3, 3] - poses[p.row - 1, :3, 3]) / 0.015
    top = p.inputs.cell.joints[p.inputs.cell.index("E1")].speed
    q = np.array(p.back.replayed.q)
    k = p.inputs.cell.index("E1")
    q[p.row :, k] += share * jumps.TIMES_TOP_SPEED * top * seconds - (q[p.row, k] - q[p.row - 1, k])
    return jumps.axis_jumps(p.back.text, replace(p.back.replayed, q=q), p.back.coverage, p.feed)


def meant(p):
    return language_named("krl").meant(p.program, p.inputs.cell.controller)


def another_number(p: Posted, share: float) -> list[Finding]:
    values = np.array(p.back.text.pose)
    values[p.row, 1] += share * intended.PRINTED
    text = replace(p.back.text, pose=values)
    return intended.hold_to_intended(text, p.back.replayed, p.program, meant(p))


def another_frame(p: Posted, share: float) -> list[Finding]:
    (frame,) = p.back.text.tools
    moved = replace(frame, xyzabc=np.asarray(frame.xyzabc) + np.array([0, 0, share * intended.FRAME_PRINTED, 0, 0, 0]))
    text = replace(p.back.text, tools=(moved,))
    return intended.hold_to_intended(text, p.back.replayed, p.program, meant(p))


def another_posture(p: Posted, share: float) -> list[Finding]:
    wrist = p.inputs.cell.index("A6")
    q = np.array(p.back.replayed.q)
    axes = np.asarray(p.program.axes)[p.row, 5]
    now = p.inputs.cell.to_axis_values(q[p.row])[5]
    q[p.row, wrist] += p.inputs.cell.joints[wrist].sign * deg_to_rad(axes - now + share * intended.POSTURE)
    return intended.hold_to_intended(
        p.back.text,
        replace(p.back.replayed, q=q),
        p.program,
        meant(p),
    )


def not_solved(p: Posted, share: float, *, axis: str, by: float) -> list[Finding]:
    k = p.inputs.cell.index(axis)
    q = np.array(p.solution.q)
    point = int(np.flatnonzero(np.asarray(p.inputs.path.line) == p.program.line[p.row])[-1])
    q[point, k] = np.asarray(p.back.replayed.q)[p.row, k] + share * by
    return solved.hold_to_solution(
        p.back.text, p.back.replayed, p.back.coverage, p.inputs.path, replace(p.solution, q=q)
    )


def another_tool(p: Posted, share: float) -> list[Finding]:
    frame = np.array(p.inputs.cell.flange_T_tool)
    frame[2, 3] += share * release.TOOL_TOLERANCE
    return hold_to_tool(replace(p.back.replayed, cell=p.back.replayed.cell.with_tool(frame)), p.inputs)


def a_limit_of_the_solution(p: Posted, share: float) -> list[Finding]:
    k = p.inputs.cell.index("A3")
    top = float(p.inputs.cell.joints[k].axis_value(np.asarray(p.solution.q)[:, k]).max())
    joints = list(p.inputs.cell.joints)
    joints[k] = replace(joints[k], upper=top - share * margins._OVER)
    inputs = replace(p.inputs, cell=replace(p.inputs.cell, joints=tuple(joints)))
    return p.errors(path_margins(inputs, p.solution).findings)


def a_singular_solution(p: Posted, share: float) -> list[Finding]:
    inv_kf = np.array(p.solution.inv_kf)
    inv_kf[2] = margins.SINGULAR / share
    return p.errors(path_margins(p.inputs, replace(p.solution, inv_kf=inv_kf)).findings)


def touching(p: Posted, share: float) -> list[Finding]:
    """A block whose top the tip of the tool passes in air, that much below it."""
    import trimesh

    air = np.asarray(p.inputs.path.move) == 0
    q = np.asarray(p.solution.q)[air][-2:]
    tip = np.asarray(p.inputs.path.base_T_tip)[air][-2:, :3, 3]
    top = tip[:, 2].min() + share * collisions.TOUCH
    block = trimesh.creation.box((0.5, 0.5, 0.02))
    block.apply_translation([*tip[0, :2], top - 0.01])
    report = collisions.check_collisions(
        p.inputs.cell,
        q[-1:],
        cutting=[False],
        line=[9],
        region=[0],
        part_mesh=np.asarray(block.triangles),
        tool=p.inputs.tool,
    )
    return p.errors(report.findings)


CASES: dict[str, Case] = {
    "judge.LIMIT_TOLERANCE": beyond_a_limit,
    "judge.SINGULAR_INV_KF": badly_conditioned,
    "judge.SINGULAR_BEND": straight_wrist,
    "judge.POSE_TOLERANCE": second_library,
    "judge.SPEED_TOLERANCE": too_fast,
    "jumps.MOST_TURN": table_leaps,
    "jumps.REVOLUTE_SLACK": lambda p, share: axis_leaps(p, share, axis="A1", slack=jumps.REVOLUTE_SLACK),
    "jumps.PRISMATIC_SLACK": lambda p, share: axis_leaps(p, share, axis="E1", slack=jumps.PRISMATIC_SLACK),
    "jumps.TIMES_TOP_SPEED": times_top_speed,
    "intended.PRINTED": another_number,
    "intended.FRAME_PRINTED": another_frame,
    "intended.POSTURE": another_posture,
    "solved.POSTURE_DEG": lambda p, share: not_solved(p, share, axis="A4", by=deg_to_rad(solved.POSTURE_DEG)),
    "solved.POSTURE_MM": lambda p, share: not_solved(p, share, axis="E1", by=mm_to_m(solved.POSTURE_MM)),
    "release.TOOL_TOLERANCE": another_tool,
    "margins._OVER": a_limit_of_the_solution,
    "margins.SINGULAR": a_singular_solution,
    "collisions.TOUCH": touching,
}


@pytest.mark.parametrize("name", CASES)
def test_both_sides(posted: Posted, name: str) -> None:
    assert CASES[name](posted, 0.9) == []
    assert CASES[name](posted, 1.1) != []


@pytest.mark.parametrize(("share", "stands"), [(0.9, True), (1.1, False)])
def test_the_solvers_promise(posted: Posted, monkeypatch: pytest.MonkeyPatch, share: float, stands: bool) -> None:
    """resolved_job.TRACKING_TOLERANCE: how far the solution may be from the poses before rounding."""
    from camrob.errors import VerificationError
    from camrob.jobs.solving import resolved_job

    def off(self: object, cell: object, path: object) -> tuple[np.ndarray, np.ndarray]:
        n = len(posted.solution)
        return np.full(n, share * resolved_job.TRACKING_TOLERANCE), np.zeros(n)

    monkeypatch.setattr(type(posted.solution), "residual", off)
    if stands:
        resolved_job.resolve_job(posted.inputs, "vjm", "published", lambda done: None)
    else:
        with pytest.raises(VerificationError, match="deviates"):
            resolved_job.resolve_job(posted.inputs, "vjm", "published", lambda done: None)


@pytest.mark.parametrize(("share", "points"), [(0.9, 6), (1.1, 7)])
def test_points_that_print_alike_are_one(tmp_path: Path, share: float, points: int) -> None:
    """path.REPEATED: a point that near to the one before is no motion of its own."""
    (tmp_path / "setup.toml").write_text(PLACE)
    step = m_to_mm(share * REPEATED)
    (tmp_path / "part.cls").write_text(PART.replace("GOTO/60,50,2\n", f"GOTO/60,50,2\nGOTO/60,{50 + step:.7f},2\n"))
    made = job.post(tmp_path / "part.cls", cell=CELL, out=tmp_path / "out", report=False)
    lins = int(np.sum(np.asarray(made.program.kind) == Motion.LIN))
    ways = int(np.sum(np.asarray(made.path.source) < 0))
    assert lins + 1 - ways == points


def test_every_tolerance_is_named_with_its_unit_and_tested() -> None:
    """A number that decides stands by a name, with unit or reason in its comment, and here or in test_against.py."""
    tested = {name.partition(".")[2] for name in CASES} | {
        "POSITION_TOLERANCE",
        "AXIS_TOLERANCE",
        "TRACKING_TOLERANCE",
        "REPEATED",
    }
    steps = {  # how finely things are looked at, or what is counted: they decide nothing by themselves
        "SECOND_OPINIONS",
        "SAMPLE_LENGTH",
        "SAMPLE_ANGLE",
        "SAMPLES",
        "STEP",
        "MAX_SAMPLES",
        "_CHUNK",
        "CLEARLY",
        "COMPARED",
        "_ACCURATE_WAYS",
        "_NEAR_TURN",
        "_NEAR_SLIDE",
        "_NEAR_RADII",
        "POINT_ENDS_MM",
        "_NAME",
    }
    elsewhere = {
        "CLOSE_TURN": "controller/test_judge.py",
        "CLOSE_SLIDE": "controller/test_judge.py",
        "JUMP": "controller/test_replay.py",
        "_JUMP_TURN": "checks/test_margins.py",
        "_JUMP_RATIO": "checks/test_margins.py",
    }
    for module in (against, gate, jumps, intended, replaying, solved, release, margins, collisions, job):
        for name, value in re.findall(
            r"^(_?[A-Z][A-Z_]+) = (?!_)([0-9.]+e?-?\d*|deg_to_rad.*|mm_to_m.*)", inspect.getsource(module), re.M
        ):
            assert name in tested | steps | set(elsewhere), (
                f"{module.__name__}.{name} = {value} is not tested from both sides"
            )
    for name, file in elsewhere.items():
        assert name.strip("_").split("_")[0].lower() in (ROOT / "tests" / file).read_text().lower()
