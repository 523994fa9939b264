"""The sixth author's generator: apart from what it judges, right by a second formula, and its labels are what its files hold."""

from __future__ import annotations

import csv
import sys
import tomllib
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from imported_names import imported_names

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "bench"))
FOLDER = ROOT / "tests" / "bench" / "gap" / "sixth_author"

from gap.sixth_author import cells  # noqa: E402
from gap.sixth_author.case import COUNTS, label, made, planned, write  # noqa: E402
from gap.sixth_author.chain import Joint, Machine, by_exponentials  # noqa: E402
from gap.sixth_author.known import MAKERS  # noqa: E402
from gap.sixth_author.world import Run, off_by, rms  # noqa: E402

MACHINES = {m.__name__: m for m in (*cells.DEV, *cells.SEALED)}


def test_it_imports_nothing_of_what_it_judges_and_of_no_other_author() -> None:
    allowed = set(sys.stdlib_module_names) | {"numpy", "scipy"}
    for path in FOLDER.glob("*.py"):
        names = {n for n in imported_names(path) if n.split(".")[0] not in allowed}
        scorer = {"gap", "gap.score"} if path.stem == "figures" else set()
        assert all(n.startswith("gap.sixth_author") or n in scorer for n in names), (path, names)


@pytest.mark.parametrize("make", MACHINES.values(), ids=MACHINES)
def test_a_chain_is_that_of_screws_and_its_load_the_slope_of_its_potential(make) -> None:
    machine = make()
    swing = np.random.default_rng(4).uniform(-1, 1, (4, len(machine.joints))) * machine.swing
    values = (np.array(machine.home) + swing) * machine.unit
    tips = machine.frames(values)[2]
    assert max(np.abs(by_exponentials(machine, v) - t).max() for v, t in zip(values, tips, strict=True)) < 1e-12

    def height(v):
        return sum(9.81 * b.mass * p[:, 2] for b, p in zip(machine.bodies, machine.centres(v), strict=True))

    h = 1e-6 * np.eye(len(machine.joints))
    slope = np.stack([(height(values + e) - height(values - e)) / 2e-6 for e in h], 1)
    assert np.abs(machine.load(values) + slope).max() < 1e-6 * (1 + np.abs(slope).max())


def test_what_is_measured_on_a_table_turns_with_it() -> None:
    for machine in (cells.kr15(), cells.table_arm()):
        values = (np.array(machine.home) + 0.4 * np.array(machine.swing)) * machine.unit
        run = Run("one", machine, 0.1, np.array([values, 0.5 * values]), np.array([0, 1]), tied=True)
        for v, tip in zip(run.c, run.nominal, strict=True):
            assert np.allclose(tip, by_exponentials(machine, v), atol=1e-12)


def test_families_hold_what_their_page_says_and_share_no_machine() -> None:
    for family, count in COUNTS.items():
        plan = planned(family)
        assert Counter(kind for kind, _, _ in plan) == count
        assert sum(k in ("outside", "mixed") for k, _, _ in plan) >= 0.2 * len(plan)
        assert sum(share is not None for _, _, share in plan) >= 0.5 * len(plan)
        assert len({about for _, about, _ in plan if about in MAKERS}) >= 0.95 * len(MAKERS)
    assert not {m.__name__ for m in cells.DEV} & {m.__name__ for m in cells.SEALED}


def _chain(path: Path) -> Machine:
    """The machine as its cell.toml has it, which is all that a diagnosis is told."""
    cell = tomllib.loads(path.read_text(encoding="utf-8"))
    joints = []
    for j in cell.get("joint", []):
        slides, dh = j["type"] == "prismatic", j["dh"]
        off = j["axis"]["offset_mm" if slides else "offset_deg"]
        row = (dh["alpha_deg"], dh["a_mm"], dh["theta_deg"], dh["d_mm"], slides, j["axis"]["sign"], off)
        joints.append(Joint(j["name"], *row, role=j["role"]))
    arm = cell["arm"]
    for k, (row, kind, sign, off) in enumerate(
        zip(arm["dh"], arm["kinds"], arm["signs"], arm["offsets_deg"], strict=True)
    ):
        joints.append(Joint(f"A{k + 1}", *row, kind == "P", sign, off))
    blank = (0.0,) * len(joints)
    tool = tuple(cell["tool"]["flange_to_tool"])
    return Machine(
        "read", "", tuple(joints), blank, blank, tool, (), blank, blank, tuple(cell["kinematics"]["base_to_first"])
    )


@pytest.mark.parametrize(("family", "number"), [("DEV", 38), ("DEV", 4), ("SEALED", 7), ("SEALED", 12)])
def test_files_hold_what_the_label_says_as_read_by_the_other_formula(family, number, tmp_path) -> None:
    case = made(family, number)
    assert case.log["frame"] != "unknown" and case.log["target"] == "tool" and case.log["noise"] == "white"
    told = label(case, look=False)
    quiet = replace(case, named=[], nameless=[], left=[], runs=case.runs[-1:])
    write(quiet, tmp_path / "quiet")
    write(replace(case, runs=case.runs[-1:]), tmp_path / "wrong")
    machine = _chain(tmp_path / "wrong" / "cell" / "cell.toml")
    sizes = {}
    for name in ("quiet", "wrong"):
        with (tmp_path / name / "withheld.csv").open() as file:
            head, *rows = csv.reader(file)
        log = dict(zip(head, np.array(rows[:: max(1, len(rows) // 300)], float).T, strict=True))
        assert np.all(np.diff(log["t"]) > 0)
        axes = np.stack([log.get("c" + n, log.get(n)) for n in machine.names], 1) * machine.unit
        if case.log["frame"] == "world":
            axes = machine.still(axes)
        seen = np.stack([log[k] for k in "xyz"], 1)
        off = seen - np.array([by_exponentials(machine, v)[:3, 3] for v in axes]) * 1e3
        sizes[name] = rms(off)
    assert sizes["quiet"] == pytest.approx(told["noise_mm"], rel=0.2)
    assert sizes["wrong"] == pytest.approx(told["perfect"]["rms_before_mm"], rel=0.1)
    alone = [rms(off_by(case.runs[-1], [c], False)) for c in (*case.named, *case.nameless)]
    assert alone == pytest.approx([e["rms_mm"] for e in (told["effects"] or told["foreign"]).values()], rel=1e-6)
    assert min(alone) > 0.5 * told["noise_mm"]
