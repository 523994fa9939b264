"""Planned programs through the whole job: a path that needs a retract, the knee's rule, and what report and terminal show."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from camrob import PostResult, post
from camrob.jobs.verify import verify
from camrob.redundancy.plan_report import PlanPoint
from camrob.redundancy.planning.choice import Knee
from camrob.report.post.plan_section import plan_section
from camrob.report.terminal.summaries import render_post
from camrob.summaries.post_summary import PlanFigures, PlanOnCurve

ROOT = Path(__file__).resolve().parents[3]
FOLDER = ROOT / "cells" / "kr15_track_table"
RADIUS, TURNS, COUNT, FEED = 60.0, 1.4, 100, 1500.0


def helix_file(folder: Path) -> Path:
    """A band around a post, the tool level and pointing at its axis all along: 1.4 turns in one cut."""
    lines = [
        "TOOL PATH/HELIX,TOOL,BALL_6",
        "TLDATA/MILL,6.0,3.0,75.0,0.0,0.0",
        "MSYS/0.0,0.0,0.0,1.0,0.0,0.0,0.0,1.0,0.0",
    ]
    angle = np.linspace(0.0, 2.0 * np.pi * TURNS, COUNT)

    def goto(a: float, r: float, z: float) -> str:
        c, s = np.cos(a), np.sin(a)
        return f"GOTO/{r * c:.4f},{r * s:.4f},{z:.4f},{c:.7f},{s:.7f},0.0"

    lines += ["RAPID", goto(angle[0], RADIUS + 60.0, 300.0), f"FEDRAT/MMPM,{FEED}"]
    lines += [goto(a, RADIUS, 300.0 + 20.0 * k / (COUNT - 1)) for k, a in enumerate(angle)]
    lines += ["RAPID", goto(angle[-1], RADIUS + 60.0, 320.0), "END-OF-PATH"]
    file = folder / "helix.cls"
    file.write_text("\n".join(lines) + "\n")
    (folder / "setup.toml").write_text("part_in_base = [0, 0, 0, 0, 0, 0]\nspindle_rpm = 10000\n")
    return file


@pytest.fixture(scope="module")
def helix(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, PostResult]:
    """The band on a cell whose table turns 130 degrees to either side and no further."""
    folder = tmp_path_factory.mktemp("helix")
    cell = folder / "cell"
    shutil.copytree(FOLDER, cell)
    text = (cell / "cell.toml").read_text()
    limited = text.replace("limits = { endless = true,", "limits = { range_deg = [-130, 130],", 1)
    assert limited != text
    (cell / "cell.toml").write_text(limited)
    clfile = helix_file(folder)
    return clfile, cell, post(clfile, cell=cell, out=folder / "out", method="planned")


@pytest.mark.slow
def test_a_path_that_needs_a_retract_is_cut_and_released(helix: tuple[Path, Path, PostResult]) -> None:
    clfile, cell, made = helix
    plan = made.summary.plan
    assert made.summary.method == "planned" and plan.retracts >= 1
    inserted = [cut for cut in plan.cuts if cut.inserted]
    assert len(inserted) == plan.retracts and all(cut.reason and 5 < cut.line < 107 for cut in inserted)
    warnings = [w for w in made.summary.warnings if w.code == "retract-inserted"]
    assert sum(w.count for w in warnings) == plan.retracts
    assert all(cut.reason in " ".join(w.text for w in warnings) for cut in inserted)
    checked = verify(made.out / "helix.src", cell=cell, against=clfile)
    assert checked.ok and checked.summary.against.met == COUNT + 2
    assert made.summary.limits.margin_min["E2"] > 5.0 and made.summary.collisions.count == 0


@pytest.mark.slow
def test_a_retract_goes_out_along_the_tool_and_back_in_at_the_feed(helix: tuple[Path, Path, PostResult]) -> None:
    _clfile, _cell, made = helix
    path = made.path
    own = np.flatnonzero((path.source < 0) & (path.region >= 0) & path.safe)
    tips, axes = path.base_T_tip[:, :3, 3], path.base_T_tip[:, :3, 2]
    for k in own:
        up = (tips[k] - tips[k - 1]) @ axes[k]
        np.testing.assert_allclose(tips[k], tips[k - 1] + up * axes[k - 1], atol=1e-12)
        assert tips[k] @ axes[k] >= (tips @ axes[k])[path.cutting].max() + 0.05 - 1e-9
        np.testing.assert_array_equal(tips[k + 1], tips[k - 1])
        assert path.entering[k + 1] and path.feed[k + 1] == pytest.approx(FEED / 60e3)
    text = (made.out / "helix.src").read_text().splitlines()
    ptp = [k for k, t in enumerate(text) if t.startswith("PTP")]
    inside = [k for k in ptp[2:-1]]  # between the entry and HOME
    after = [t for t in text[inside[-1] :] if t.startswith(("$VEL.CP", "LIN"))]
    assert after[0] == "$VEL.CP = 0.025000" and after[1].startswith("LIN")


@pytest.mark.slow
def test_report_and_terminal_show_the_curve(helix: tuple[Path, Path, PostResult]) -> None:
    _clfile, _cell, made = helix
    page = (made.out / "helix.html").read_text()
    plan = json.loads((made.out / "helix.json").read_text())["plan"]
    assert page.count('class="trade"') == 1 and page.count("retract put in") == plan["retracts"]
    console = Console(width=160, file=StringIO())
    console.print(render_post(made.summary))
    text = console.file.getvalue()
    assert "->" in text and "price by terms: conditioning" in text and "retract put in" in text
    assert all(p["name"] in text for p in plan["curve"])


def test_hostile_names_in_a_plan_are_text_and_the_ring_is_on_what_was_taken() -> None:
    travel = {"E1_mm": 0.0, "E2_deg": 1.0}
    point = PlanOnCurve(name="<b>x", inv_kf_mean=0.6, inv_kf_min=0.5, share_of_bound=0.95, travel_si={}, travel=travel)
    other = replace(point, name="flowing", share_of_bound=0.99, travel={"E1_mm": 900.0, "E2_deg": 200.0})
    plan = PlanFigures(
        mode="knee",
        chosen="<b>x",
        rule="<i>",
        bound_mean=0.65,
        bound_min=0.6,
        terms={"conditioning": 1.0},
        shares={"conditioning": 1.0},
        repostures=0,
        retracts=0,
        cuts=(),
        curve=(point, other),
        gap_percent=3.0,
        seconds=None,
        missed=0,
        mended=0,
    )
    html = plan_section(plan)
    assert "<b>x" not in html and "<i>" not in html and html.count("<svg") == 2 and html.count("<circle") == 4
    assert html.count('stroke="#d64545"') == 2 and "100.0" in html
    assert plan_section(None) == ""


def point(name: str, share: float, e2: float, e1: float) -> PlanPoint:
    return PlanPoint(name, 0.6, 0.5, share, {"E2": e2, "E1": e1})


def test_the_knee_takes_what_its_rule_says() -> None:
    points = [point("still", 0.94, 0, 0), point("a", 0.953, 9, 2), point("b", 0.963, 12, 1), point("c", 0.98, 50, 3)]

    def taken(share: float, **budget: float) -> str:
        return points[Knee(np.array([0.04, 0.02, 0.0]), share, budget).take(points).curve_index].name

    assert taken(0.96) == "b" and taken(0.9) == "still" and taken(0.99) == "c"
    assert taken(0.96, E2=13.0, E1=5.0) == "b"
    assert taken(0.96, E2=10.0, E1=5.0) == "a"  # the budget does not buy 96 %: the best within it
    assert taken(0.96, E2=10.0, E1=1.0) == "still"
    points = points[2:]  # nothing within the budget
    assert taken(0.96, E2=1.0) == "b" and taken(0.97, E2=1.0) == "c"


def test_where_nothing_outside_of_the_arm_moves_no_budget_of_it_is_spoken_of() -> None:
    points = [PlanPoint("still", 0.6, 0.5, 0.85, {}), PlanPoint("x0.7", 0.6, 0.5, 0.86, {})]
    choice = Knee(np.array([0.0]), 0.96, {}).take(points)
    assert choice.curve_index == 1 and "no external axis" in choice.rule and "budget" not in choice.rule
