"""Logs that are mutilated, mistaken or none at all: a clear line or an honest "no", never a confident cause."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from gap_cases import KR15, kr15, simulated
from test_gap_effects import DEG, plant_lag, plant_link, plant_play

from camrob.cli.app import run
from camrob.errors import InputError, LogError
from camrob.gap.diagnose import diagnose
from camrob.gap.observation.scene import make_scene
from camrob.jobs.diagnose import diagnose as diagnose_job
from camrob.measurement.log import MeasurementLog
from camrob.measurement.read_log import read_log
from camrob.measurement.write_log import write_log

SIGMA = 0.02
AXES = tuple(f"{c}A{k}" for c in ("", "c") for k in range(1, 7))
CAUSES = {"play": plant_play, "zero": plant_link(2, lambda w: 0.05 * DEG), "lag": plant_lag}
MUTATIONS = ("time shuffled", "axes negated", "inches", "blocks permuted", "x and y swapped", "encoders shuffled")
# Every mutation once before any of them meets its second cause.
EACH_WITH_ONE = [
    (how, list(CAUSES)[(k + turn) % len(CAUSES)]) for turn in range(len(CAUSES)) for k, how in enumerate(MUTATIONS)
]


def mutilated(log: MeasurementLog, how: str) -> MeasurementLog:
    columns = {n: np.array(v) for n, v in log.columns.items()}
    rng = np.random.default_rng(0)
    if how == "axes negated":
        for n in ("A2", "A3", "cA2", "cA3"):
            columns[n] = -columns[n]
    elif how == "inches":
        for n in "xyz":
            columns[n] = columns[n] / 25.4
    elif how == "x and y swapped":
        columns["x"], columns["y"] = columns["y"], columns["x"]
    else:
        order = rng.permutation(len(log))
        if how == "blocks permuted":
            parts = np.array_split(np.arange(len(log)), 8)
            order = np.concatenate([parts[i] for i in (3, 6, 0, 5, 7, 1, 4, 2)])
        for n in [a for a in AXES if a[0] == "A"] if how == "encoders shuffled" else "xyzabc":
            columns[n] = columns[n][order]
    return MeasurementLog(columns, log.info, log.path)


@pytest.mark.slow(after=len(MUTATIONS))
@pytest.mark.parametrize(("how", "cause"), EACH_WITH_ONE)
def test_a_mutilated_log_never_ends_in_a_confident_cause(how: str, cause: str) -> None:
    log = mutilated(simulated(CAUSES[cause], sigma_mm=SIGMA), how)
    try:
        found = diagnose([log], kr15())
    except LogError as error:
        assert "\n" not in str(error)
        assert ";" in str(error)  # what is wrong; what to do
        return
    assert all(e["probability"] <= 0.8 for e in found.summary.to_json()["effects"])
    assert found.summary.to_json()["status"] != "explained"


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("size", [1, 120])
def test_a_gap_that_is_moved_to_other_places_of_the_path_is_blamed_on_nothing(size: int) -> None:
    """The measured errors as they are, stretches of so many samples exchanged: no cause has this shape any more."""
    log = simulated(plant_play, sigma_mm=SIGMA)
    scene = make_scene(log, kr15())
    parts = np.array_split(np.arange(len(log)), len(log) // size)
    order = np.concatenate([parts[k] for k in np.random.default_rng(1).permutation(len(parts))])
    place = (scene.nominal[:, :3, 3] + scene.tcp_gap[order, :3]) * 1e3
    columns = {n: v for n, v in log.columns.items() if n not in "abc"} | {n: place[:, k] for k, n in enumerate("xyz")}
    found = diagnose([MeasurementLog(columns, log.info, log.path)], kr15())
    assert all(e["probability"] <= 0.8 for e in found.summary.to_json()["effects"]), found.summary.to_json()["effects"]
    assert found.summary.to_json()["status"] != "explained"


@cache
def text() -> str:
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        log = simulated(sigma_mm=SIGMA)
        write_log(MeasurementLog(log.columns, log.info), Path(folder) / "run.csv")
        return (Path(folder) / "run.csv").read_text()


def rows() -> tuple[list[str], list[list[str]]]:
    head, *body = [line.split(",") for line in text().splitlines()]
    return head, body


def without(*names: str) -> str:
    head, body = rows()
    kept = [k for k, n in enumerate(head) if n not in names]
    return "\n".join(",".join(r[k] for k in kept) for r in (head, *body)) + "\n"


def scaled(factor: float, *names: str) -> str:
    head, body = rows()
    for r in body:
        for n in names:
            r[head.index(n)] = repr(float(r[head.index(n)]) * factor)
    return "\n".join(",".join(r) for r in (head, *body)) + "\n"


def changed(row: int, name: str, value: str) -> str:
    head, body = rows()
    body[row][head.index(name)] = value
    return "\n".join(",".join(r) for r in (head, *body)) + "\n"


BAD = {
    "nothing": (lambda: "", "is empty"),
    "a header alone": (lambda: text().splitlines()[0] + "\n", "holds no samples"),
    "eight rows": (lambda: "\n".join(text().splitlines()[:9]) + "\n", "holds 8 whole samples"),
    "no time": (lambda: without("t"), "has no column t"),
    "no position": (lambda: without("x", "y", "z", "cE1", "cE2", *AXES[6:]), "no measured position"),
    "no A3": (lambda: without("A3", "cA3"), "no column A3"),
    "no track": (lambda: without("E1", "cE1"), "lacks the axis E1"),
    "time goes back": (lambda: changed(200, "t", "0.5"), ":202: t is 0.5 after"),
    "not a number": (lambda: changed(100, "x", "nan"), ":102: x is 'nan'"),
    "a word": (lambda: changed(100, "A2", "hello"), ":102: A2 is 'hello'"),
    "metres": (lambda: scaled(1e-3, "x", "y", "z"), "metres"),
    "radians": (lambda: scaled(DEG, *AXES), "TCP lies|radians"),
    "radians of the tool": (lambda: scaled(DEG, "a", "b", "c"), "its a, b, c are in radians"),
    "the track in metres": (lambda: scaled(1e-3, "E1", "cE1"), "TCP lies"),
    "milliseconds": (lambda: scaled(1e6, "t"), "is t in milliseconds"),
    "nothing moves": (
        lambda: (
            "\n".join(
                [text().splitlines()[0], *(f"{k}," + text().splitlines()[1].partition(",")[2] for k in range(40))]
            )
            + "\n"
        ),
        "no axis moves",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_log_ends_in_one_clear_line(tmp_path: Path, name: str) -> None:
    make, words = BAD[name]
    (tmp_path / "run.csv").write_text(make())
    with pytest.raises(LogError, match=words) as refused:
        diagnose_job(cell=KR15, log=[tmp_path / "run.csv"], out=tmp_path / "out")
    assert "\n" not in str(refused.value)
    assert "run.csv" in str(refused.value)
    assert not (tmp_path / "out").exists()


def test_the_command_says_it_in_one_line_with_status_2(tmp_path: Path, capsys) -> None:
    (tmp_path / "run.csv").write_text(changed(200, "t", "0.5"))
    status = run(["diagnose", "--cell", str(KR15), "--log", str(tmp_path / "run.csv"), "--out", str(tmp_path / "out")])
    captured = capsys.readouterr()
    assert status == 2
    assert captured.out == ""
    assert len(captured.err.strip().splitlines()) == 1
    assert "time has to advance" in captured.err


def test_the_same_log_is_not_both_diagnosed_and_withheld(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text(text())
    assert len(read_log(tmp_path / "run.csv")) > 900
    with pytest.raises(LogError, match="both diagnosed and withheld"):
        diagnose_job(cell=KR15, log=[tmp_path / "run.csv"], withheld=[tmp_path / "run.csv"], out=tmp_path / "out")


def test_rows_given_twice_are_refused_under_any_name(tmp_path: Path) -> None:
    for name in ("run.csv", "copy.csv"):
        (tmp_path / name).write_text(text())
    run_, copy = tmp_path / "run.csv", tmp_path / "copy.csv"
    with pytest.raises(LogError, match=r"run\.csv: is given twice; give it once"):
        diagnose_job(cell=KR15, log=[run_, run_], out=tmp_path / "out")
    with pytest.raises(LogError, match=r"copy\.csv: is given twice; it has the rows of run\.csv"):
        diagnose_job(cell=KR15, log=[run_, copy], out=tmp_path / "out")
    with pytest.raises(LogError, match=r"copy\.csv: is both diagnosed and withheld; it has the rows of run\.csv"):
        diagnose_job(cell=KR15, log=[run_], withheld=[copy], out=tmp_path / "out")


def test_a_calibration_s_name_ends_in_toml(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"--calibration 'fit\.csv' is not a calibration's name; end it with \.toml"):
        diagnose_job(cell=KR15, log=[tmp_path / "run.csv"], out=tmp_path / "out", calibration=tmp_path / "fit.csv")
