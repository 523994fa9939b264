"""The loop from program to measured part and back: what it awaits and keeps, what it reaches on a machine of other code."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from gap_cases import closed_loop, generator
from page_data import block_of

from camrob.cell.read_cell import read_cell
from camrob.cli import app as cli
from camrob.errors import InputError
from camrob.gap.observation.program_track import motions_of_lines
from camrob.jobs.close_loop import close_loop
from camrob.jobs.closing.diagnosed_machine import cuts_of
from camrob.jobs.closing.measured_path import OffPath, intended_path, measured_off_path
from camrob.jobs.closing.off_way import off_path_size
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.measurement.log import MeasurementLog
from camrob.measurement.write_log import write_log
from camrob.program.motion import Motion
from camrob.program.program_text import ProgramText

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def job(tmp_path: Path) -> Path:
    """A job of its own folder: the engraving, cut down to its first letters."""
    for name in ("setup.toml", "stock.stl", "part.stl"):
        if (ROOT / "toolpaths" / "engraving" / name).is_file():
            shutil.copy(ROOT / "toolpaths" / "engraving" / name, tmp_path)
    lines = (ROOT / "toolpaths" / "engraving" / "engraving.cls").read_text().splitlines()
    ends = [k for k, line in enumerate(lines) if line.startswith("END-OF-PATH")]
    (tmp_path / "short.cls").write_text("\n".join(lines[: ends[0] + 1]) + "\n")
    file = tmp_path / "loop.toml"
    file.write_text('toolpath = "short.cls"\ncell = "kr15_track_table"\ntolerance_mm = 0.1\n')
    return file


def test_it_makes_the_program_and_awaits_its_log(job: Path, tmp_path: Path) -> None:
    said = close_loop(job, out=tmp_path / "loop").summary
    assert (said.outcome, said.best) == ("awaiting a log", 0)
    assert "run turn_1/short.src" in said.next and "turn_1/run.csv" in said.next
    program = tmp_path / "loop" / "turn_1" / "short.src"
    made = program.stat().st_mtime_ns
    again = close_loop(job, out=tmp_path / "loop").summary
    assert again.turns == said.turns and program.stat().st_mtime_ns == made
    assert json.loads((tmp_path / "loop" / "ledger.json").read_text())["outcome"] == "awaiting a log"
    page = (tmp_path / "loop" / "ledger.html").read_text()
    assert "Awaiting a log." in page and "its log is awaited" in page and 'href="turn_1/short.html"' in page


def test_another_toolpath_does_not_go_on_with_it(job: Path, tmp_path: Path) -> None:
    close_loop(job, out=tmp_path / "loop")
    text = (tmp_path / "short.cls").read_text()
    (tmp_path / "short.cls").write_text(text.replace("FEDRAT/", "FEDRAT/ ", 1))
    with pytest.raises(InputError, match="was begun with another toolpath"):
        close_loop(job, out=tmp_path / "loop")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("tolerance_mm = 0.0", "tolerance_mm: is 0"),
        ("turns = 0", "turns: is 0"),
        (
            'cell = "kr15_track_tabel"',
            "loop.toml:3: cell: there is no folder 'kr15_track_tabel', and no cell of that name",
        ),
        ('method = "magic"', "method: is 'magic'"),
        ("tolerence = 1", "tolerence: is not a key"),
        ('force = "FORCE.toml"', "FORCE.toml: can't be read"),
        ('force = "loop.toml"', "loop.toml: mean: is missing, and [milling] too: this is no force file"),
        ('[machine]\ncalibration = "fitted.toml"', "fitted.toml: can't be read"),
        ('[machine]\ndiagnosis = "found"', "found: holds no diagnosis.json"),
        ("[machine]\nseed = 1", "nothing says what is wrong with the machine"),
    ],
)
def test_a_job_that_is_wrong_is_refused_by_its_key(job: Path, tmp_path: Path, line: str, message: str, capsys) -> None:
    kept = [old for old in job.read_text().splitlines() if old.split(" =")[0] != line.split(" =")[0]]
    job.write_text("\n".join([*kept, line]) + "\n")
    assert cli.run(["close-loop", str(job), "--out", str(tmp_path / "loop")]) == 2
    shown = capsys.readouterr().err
    assert message in shown and shown.count("\n") == 1
    assert not (tmp_path / "loop").exists()


def true_machine(world) -> None:
    """A zero of A3 that is off, a coupling of the wrist, and play in A1, which no constant corrects."""
    world.link[:, 2] += 0.03 * closed_loop.DEG
    world.link[:, 4] += 1.2e-3 * world.command[:, 3]
    world.link[:, 0] += generator.play(world.command[:, 0], 0.012 * closed_loop.DEG)


class Ran(NamedTuple):
    """The first turn of a loop as the true machine ran it: its program, the file that it lies in, and its log."""

    file: Path
    program: ProgramText
    log: MeasurementLog

    def off_path(self, columns) -> OffPath:
        """How far the tool was off by some columns of a log."""
        cell = read_cell(closed_loop.CELL)
        log, rows = MeasurementLog(columns, self.log.info), np.arange(len(self.program))
        cuts = cuts_of(self.program, np.inf)
        return measured_off_path(log, self.program, cell, intended_path(self.program, cell), rows, cuts)


@pytest.fixture
def ran(job: Path, tmp_path: Path, monkeypatch) -> Ran:
    monkeypatch.setattr(closed_loop, "ROWS", slice(0, None, 10))
    close_loop(job, out=tmp_path / "loop")
    file = tmp_path / "loop" / "turn_1" / "short.src"
    return Ran(file, read_krl(file), closed_loop.run_on_cell(file, true_machine, 1))


def test_a_piece_of_a_run_says_nothing_of_the_rest(ran: Ran) -> None:
    for without in ((), ("line",)):
        columns = {k: v for k, v in ran.log.columns.items() if k not in without}
        whole = ran.off_path(columns)
        assert 1e-5 < np.median(whole.distance.off) < 1e-3
        for kept in (slice(0, len(ran.log) // 3), slice(len(ran.log) // 3, None)):
            with pytest.raises(InputError, match=r"shows the tool on \d+ % of the way"):
                ran.off_path({k: v[kept] for k, v in columns.items()})


def test_a_tool_that_waits_where_it_is_off_counts_no_more_for_it(ran: Ran) -> None:
    log, program = ran.log, ran.program
    usual = off_path_size(ran.off_path(log.columns).distance)
    cut = np.flatnonzero(np.asarray(program.kind)[motions_of_lines(program, log.columns["line"])] >= Motion.LIN)
    off = closed_loop.off_path(log, ran.file)[cut]
    worst = int(cut[np.argmax(off)])
    # half as long again at that place as the whole run takes, with the instrument's noise
    order = np.concatenate([np.arange(worst + 1), np.full(len(log) // 2, worst), np.arange(worst + 1, len(log))])
    held = {k: np.asarray(v)[order].copy() for k, v in log.columns.items()}
    held["t"] = 0.04 * np.arange(len(order))
    noise = np.random.default_rng(5)
    for name in "xyz":
        held[name][worst + 1 : worst + 1 + len(log) // 2] += noise.normal(0.0, closed_loop.SIGMA_MM, len(log) // 2)
    waited = off_path_size(ran.off_path(held).distance)
    assert waited.rms_mm == pytest.approx(usual.rms_mm, rel=0.01)
    assert waited.p95_mm == pytest.approx(usual.p95_mm, rel=0.01)
    by_rows = np.concatenate([off, np.full(len(log) // 2, off.max())])
    assert np.sqrt(np.mean(by_rows**2)) > 1.1 * np.sqrt(np.mean(off**2))


def assert_told_what_is_taken_off(page: str, out: Path, turns: int) -> None:
    """Each turn's page says by how much the next program's targets were moved, as the two programs' own numbers have it, and
    what that was for.
    """
    first = np.asarray(read_krl(out / "turn_1" / "short.src").pose)[:, :3]
    told = [row.split("</td>")[0] for row in page.split("<th>Correction</th><td>")[1:]]
    assert len(told) == turns - 1
    for k, text in enumerate(told, start=2):
        made = json.loads((out / f"turn_{k}" / "short.json").read_text())["machine"]
        program = read_krl(out / f"turn_{k}" / "short.src")
        there_before = ~np.isin(np.asarray(program.line), made["targets_added"].get("short.src", []))
        moved = np.nanmax(np.linalg.norm(np.asarray(program.pose)[there_before, :3] - first, axis=1))
        figure = re.search(r"its targets moved by up to (\d+\.\d+) mm", text)
        # the furthest may be one that was added, between two that are moved hardly less
        assert figure and moved - 2e-3 < float(figure[1]) < 1.05 * moved and moved > 0.1
        names = text.split("takes off ")[1].split(": its targets")[0]
        assert (
            "joint offset of A3, wrist coupling of A5 (constants of the chain)" in names and "backlash of A1" in names
        )
        assert (out / f"turn_{k - 1}" / "diagnosis" / "fitted.toml").is_file()
        assert f"to {made['after']['rms_mm']:.3f} mm rms" in text
        likely = [made["likely"][f"{name}_mm"] for name in ("p95_low", "p95", "p95_high")]
        assert likely == sorted(likely) and likely[1] > 0.8 * made["after"]["p95_mm"]


@pytest.mark.slow
def test_the_loop_ends_nearer_to_the_path_on_a_machine_of_other_code(job: Path, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(closed_loop, "ROWS", slice(0, None, 10))
    out = tmp_path / "loop"

    def run(turn: int) -> None:
        log = closed_loop.run_on_cell(out / f"turn_{turn}" / "short.src", true_machine, turn)
        write_log(log, out / f"turn_{turn}" / "run.csv")

    close_loop(job, out=out)
    run(1)
    said = close_loop(job, out=out).summary
    first, second = said.turns
    assert first.measured is not None and second.predicted is not None
    assert {"backlash A1", "wrist_coupling A5"} <= set(first.found)
    assert said.outcome == "awaiting a log" and "turn_2/short.src" in said.next
    # what was measured is what a judge outside camrob's loop measures
    log = closed_loop.run_on_cell(out / "turn_1" / "short.src", true_machine, 1)
    off = closed_loop.off_path(log, out / "turn_1" / "short.src")
    assert first.measured.p95_mm == pytest.approx(float(np.quantile(off, 0.95)), rel=0.1)

    run(2)
    said = close_loop(job, out=out).summary
    reached = said.turns[1].measured
    assert reached is not None
    assert reached.rms_mm < 0.35 * first.measured.rms_mm
    noise = closed_loop.SIGMA_MM * np.sqrt(2.0)
    assert reached.rms_mm == pytest.approx(np.hypot(second.predicted.rms_mm, noise), rel=0.25)

    page = (out / "ledger.html").read_text()
    (chart,) = [c for c in block_of(page, "charts") if c["id"] == "along"]
    kept = {trace["name"]: trace for trace in chart["traces"]}
    assert set(kept) == {"turn 1", "turn 2", "tolerance"}
    assert np.max(kept["turn 1"]["y"]) == pytest.approx(first.measured.max_mm, abs=1e-3)
    intended = read_krl(out / "turn_1" / "short.src")
    poses = np.asarray(intended.pose)[:, :3]
    whole = float(np.linalg.norm(np.diff(poses[np.isfinite(poses).all(axis=1)], axis=0), axis=1).sum())  # mm
    assert 0.6 * whole < np.max(kept["turn 1"]["x"]) < 1.2 * whole
    assert "reverses with the direction of motion: joint offset of A3" in page and "backlash of A1" in page
    assert_told_what_is_taken_off(page, out, len(said.turns))

    (out / "turn_1" / "run.csv").write_text((out / "turn_1" / "run.csv").read_text().rsplit("\n", 2)[0] + "\n")
    with pytest.raises(InputError, match="is not the log that the next turn was made with"):
        close_loop(job, out=out)
