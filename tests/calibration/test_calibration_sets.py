"""Several logs in one calibration: a common robot, an instrument of its own for each; and the report of it all."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from calibration_sample import CELL, ROOT, SHARED, axis_values, calibrate_cell, drawn, log_of, measure
from page_data import block_of

from camrob.calibration.calibrate import fit_cell
from camrob.calibration.calibration_file import calibration_figures, read_calibration
from camrob.calibration.error_model import ErrorModel
from camrob.calibration.fit import fit_parameters
from camrob.calibration.measurements import Measurements, measurements_of
from camrob.calibration.parameters import ParameterSet
from camrob.calibration.pose_by_pose import explained_by_axis
from camrob.calibration.sets import prepare_sets
from camrob.calibration.terms import parameter_of, standard_names
from camrob.cli.app import run
from camrob.errors import JobError
from camrob.measurement.log_info import LogInfo, MeasuredFrame, Target
from camrob.measurement.read_log import read_log
from camrob.measurement.write_log import write_log
from camrob.report.calibration.page import calibration_report
from camrob.se3 import frame_from_xyzabc
from camrob.summaries.calibration_summary import CalibrationSummary
from camrob.summaries.remarks import Remark

KR15 = ROOT / "cells" / "kr15_track_table"
TRUE = drawn(CELL)
PLACES = ([2.0, -3.0, 0.4, 2.5, 0.3, -1.0], [-1.0, 4.0, 0.2, -0.7, 0.2, 0.4])
REFLECTORS = ([0.05, 0.1, -0.08, 1.0, 0.5, 2.0], [0.02, -0.1, 0.06, 0.4, -0.5, 1.0])


def elsewhere(k: int, count: int, true: dict[str, float] = TRUE, **of) -> Measurements:
    """Poses that a tracker saw from its k-th place, with another reflector each time."""
    left, right = frame_from_xyzabc(PLACES[k]), frame_from_xyzabc(REFLECTORS[k])
    data = measure(CELL, true, axis_values(CELL, count, seed=10 + k), seed=20 + k, left=left, right=right, **of)
    return replace(data, frame_known=False, target_known=False, name=f"set{k}.csv")


def test_two_stands_of_the_tracker_share_the_robot() -> None:
    """Forty poses from either place tell less than both together; the instruments stay apart."""
    both = fit_cell(CELL, [elsewhere(0, 60), elsewhere(1, 60)], withheld=measure(CELL, TRUE, axis_values(CELL, 100)))
    found = both.calibration
    assert found.errors["calibrated/fitted"].mean < 4.5e-5
    assert "nominal/fitted" not in found.errors
    assert set(found.nuisance) >= {"base.x", "tool.x"} and not any("@" in n for n in found.parameters)
    assert [log for log, _ in found.logs] == ["set0.csv", "set1.csv"] and found.rows == 120
    alone = calibrate_cell(CELL, elsewhere(0, 60), share=0.0)
    common = [n for n in found.parameters if n in alone.parameters and n not in found.nuisance]
    assert len(common) > 15
    alone, again = (
        fit_cell(CELL, sets, names=common, share=0.0).calibration
        for sets in ([elsewhere(0, 60)], [elsewhere(0, 60), elsewhere(1, 60)])
    )
    assert np.mean([again.parameters[n].std / alone.parameters[n].std for n in common]) < 0.85


def test_a_known_and_an_unknown_instrument_together() -> None:
    """What the known one says of base and tool stays the cell's; the other one's are nobody's."""
    true = TRUE | {"base.x": 2e-3, "tool.y": -5e-4}
    known = measure(CELL, true, axis_values(CELL, 80))
    found = calibrate_cell(CELL, [known, elsewhere(1, 80, true)], share=0.0)
    assert found.nuisance == ()
    assert found.parameters["tool.y"].value == pytest.approx(-5e-4, abs=6e-4)
    assert calibrate_cell(CELL, known, share=0.0).parameters["base.x"].value == pytest.approx(
        found.parameters["base.x"].value, abs=2e-4
    )


def test_derivatives_of_sets_stand_in_their_own_columns() -> None:
    sets = [elsewhere(0, 20), measure(CELL, TRUE, axis_values(CELL, 20)), elsewhere(1, 20)]
    names = ("A2.zero", "tool.x", "base.x", "A3.rx")
    prepared = prepare_sets(CELL, sets, names)
    everything = prepared[0].names
    assert everything == ("tool.x@1", "base.x@1", "tool.x", "base.x", "tool.x@3", "base.x@3", "A2.zero", "A3.rx")
    assert prepared[0].nuisance == ("tool.x@1", "base.x@1", "tool.x@3", "base.x@3")
    at = np.linspace(1e-4, 8e-4, len(everything))
    for part in prepared:
        J = part.model.poses_and_jacobian(at, part.data.q)[1]
        for k in range(len(everything)):
            step = np.zeros(len(everything))
            step[k] = 1e-6
            up, down = (part.model.poses(at + s * step, part.data.q)[:, :3, 3] for s in (1, -1))
            assert np.allclose(J[:, :3, k], (up - down) / 2e-6, atol=1e-6)
        fewer = part.with_names(("A3.rx", "base.x@3"))
        assert np.array_equal(
            fewer.model.poses_and_jacobian(np.zeros(2), part.data.q)[1][:, :, 0],
            part.model.poses_and_jacobian(np.zeros(8), part.data.q)[1][:, :, 7],
        )


def test_a_withheld_log_of_another_stand_judges_the_robot_alone() -> None:
    study = fit_cell(CELL, elsewhere(0, 150), withheld=elsewhere(1, 80))
    judged = [p for p in study.evidence.poses if p.withheld]
    assert [(p.log, len(p.rows), p.refitted) for p in judged] == [("set1.csv", 40, True)]
    errors = study.calibration.errors
    assert errors["frames/withheld"].mean > 5e-4 and errors["calibrated/withheld"].mean < 6e-5
    assert not any("carry over" in w for w in study.calibration.warnings)
    wrong = elsewhere(1, 80, {n: -v for n, v in TRUE.items()})  # another robot: its judge is not content
    other = calibrate_cell(CELL, elsewhere(0, 150), withheld=wrong)
    assert other.errors["calibrated/withheld"].mean > 5e-4
    assert any(
        w.startswith("the poses of set1.csv come out worse than with base and tool alone") for w in other.warnings
    )


def test_one_log_that_is_no_robot_s_is_named() -> None:
    odd = replace(elsewhere(1, 60), q=-np.asarray(elsewhere(1, 60).q), name="odd.csv")
    with pytest.raises(JobError, match=r"odd\.csv can't be this cell's"):
        calibrate_cell(CELL, [elsewhere(0, 60), odd])


def test_what_an_axis_explains() -> None:
    rng = np.random.default_rng(1)
    axes = rng.uniform(-1, 1, (4000, 3))
    axes[:, 2] = 0.5  # stands still
    noise = rng.normal(size=(4000, 3))
    assert np.all(explained_by_axis(noise, axes) < 0.01)
    wave = noise + 2.0 * np.outer(np.sin(3 * axes[:, 1]), [1.0, 0.0, 0.0])
    share = explained_by_axis(wave, axes)
    truth = 4.0 * np.var(np.sin(3 * axes[:, 1])) / np.sum(np.var(wave, axis=0))
    assert share[1] == pytest.approx(truth, abs=0.03) and share[0] < 0.01 and share[2] == 0.0


# --- the command and its report -------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("sets")
    info = LogInfo(MeasuredFrame.UNKNOWN, Target.UNKNOWN, sigma_position=2e-5, sigma_angle=1e-5, poses=True)
    for k, name in enumerate(("a.csv", "b.csv")):
        write_log(log_of(CELL, elsewhere(k, 70), info), folder / name)
    write_log(log_of(CELL, elsewhere(1, 60), info), folder / "other.csv")
    command = ["calibrate", str(folder / "a.csv"), str(folder / "b.csv"), "--withheld", str(folder / "other.csv")]
    assert run([*command, "--cell", str(KR15), "--out", str(folder / "o" / "C.toml"), "--next", "4", "--quiet"]) == 0
    return folder / "o"


def test_the_command_takes_several_logs(made) -> None:
    folder = made
    assert sorted(f.name for f in folder.iterdir()) == ["C.html", "C.toml", "C_poses.dat", "C_poses.src"]
    found = read_calibration(folder / "C.toml", CELL)
    assert [name for name, _ in found.logs] == ["a.csv", "b.csv"] and found.rows == 140
    assert found.errors["calibrated/withheld"].rows == 30


def test_the_page_holds_what_was_found_and_loads_nothing(made) -> None:
    page = (made / "C.html").read_text()
    expected = (
        "Errors before and after",
        "What the poses can tell apart",
        "Correlations",
        "What stays unexplained",
        "A3.zero",
    )
    for text in (*expected, "Poses to measure next", "base and reflector were fitted to half of it", "t be told from"):
        assert text in page
    ids = set(re.findall(r'class="chart" id="([\w-]+)"', page))
    charts = block_of(page, "charts")
    assert {c["id"] for c in charts} == ids and len(ids) == 8
    assert len({c["ruler"] for c in charts}) == 8  # none is zoomed by another
    assert "://" not in re.sub(r"<script>.*?</script>", "", page, flags=re.DOTALL)


def test_names_of_files_stay_text() -> None:
    hostile = '</script><img src=x onerror="alert(1)">%{x}'
    study = fit_cell(CELL, replace(measure(CELL, TRUE, axis_values(CELL, 60)), name=hostile))
    warned = (Remark(line=0, code="x", text=hostile),)
    figures = replace(calibration_figures(study.calibration), warnings=warned, cell=hostile)
    summary = CalibrationSummary(figures=figures, file=hostile, report="r.html", withheld=())
    page = calibration_report(summary, study.evidence, CELL.axis_names, published=[(hostile,) * 3], source=hostile)
    assert "<img" not in re.sub(r"<script>.*?</script>", "", page, flags=re.DOTALL)


UR10 = SHARED / "real" / "ur10_tmac"


@pytest.mark.slow
@pytest.mark.skipif(not UR10.is_dir(), reason="../shared is not here: real/ur10_tmac")
def test_the_robot_of_one_real_series_predicts_the_other(tmp_path: Path, capsys) -> None:
    """From the command line: trained on D, judged on half of A, whose instrument is refitted on the other half."""
    cell = str(ROOT / "tests" / "data" / "ur10")
    command = ["calibrate", str(UR10 / "D.csv"), "--withheld", str(UR10 / "A.csv"), "--cell", cell, "--harmonics", "2"]
    assert run([*command, "--out", str(tmp_path / "D.toml"), "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["withheld"] == [{"file": "A.csv", "poses": 5956, "refitted": True}]
    errors = summary["errors"]
    assert errors["frames/withheld"]["mean_mm"] > 0.70 and errors["calibrated/withheld"]["mean_mm"] < 0.42
    assert any("something else is at work" in w["text"] for w in summary["warnings"])
    assert "remain unexplained" in (tmp_path / "D.html").read_text()


SAMPLES = SHARED / "gap_samples" / "cases" / "e_tool_and_compliance"


@pytest.mark.skipif(not SAMPLES.is_dir(), reason="../shared is not here: gap_samples")
def test_the_labelled_compliance_differs_from_run_to_run() -> None:
    """Why A2 and A3 come out 1.5 % below their label in one run: that is what the run says, throughout.

    With everything else held at its label, each tenth of the run asks for the same share of A2's and A3's compliance
    within its standard error, 1.5 % less than the label, and leaves nothing but the noise. The other run of the same
    case asks for a little more than the label. No model of one robot can have both.
    """
    labels = json.loads((SHARED / "gap_samples" / "labels.json").read_text())["e_tool_and_compliance"]["effects"]
    tool = dict(zip((f"tool.{k}" for k in ("x", "y", "z", "rx", "ry", "rz")), labels["frame_tool"]["v"], strict=True))
    values = {n: v / 1e3 if n[5] != "r" else v for n, v in tool.items()}
    values |= {f"A{k}.compliance": labels["joint_compliance"]["compl"][k - 1] for k in (2, 3, 5)}
    model = ErrorModel.of(CELL, tuple(values))
    held = ParameterSet.of(parameter_of(CELL, n) for n in values).with_values(np.array(list(values.values())))
    fixed = held.fixed([n for n in values if n not in ("A2.compliance", "A3.compliance")])

    def share(data: Measurements) -> tuple[float, float]:
        """Of A2's and A3's turn at mean load, by the label, and the noise left in deviations."""
        fit = fit_parameters([(model, data)], fixed)
        found = [fit.parameters[f"A{k}.compliance"].value / values[f"A{k}.compliance"] for k in (2, 3)]
        return float(np.mean(found)), fit.scatter_position / 2e-5

    dome, circle = (measurements_of(read_log(SAMPLES / f"{name}.csv"), CELL) for name in ("dome0", "circle1"))
    tenths = [share(dome.select(slice(a, a + 507))) for a in range(0, 5070, 507)]
    assert np.allclose([s for s, _ in tenths], 0.985, atol=0.003)
    assert all(noise < 1.06 for _, noise in tenths)
    other, noise = share(circle)
    assert 1.001 < other < 1.009 and noise < 1.06


def test_standard_names_are_the_paper_s() -> None:
    own = [n for n in standard_names(CELL, track=False) if not n.startswith(("base", "tool"))]
    assert len([n for n in own if n.endswith("compliance")]) == 5 and len(own) == 35
