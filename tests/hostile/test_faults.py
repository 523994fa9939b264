"""Killed at every stage, a full disk, two runs at once: nothing half-written under a final name, and a second run does it all."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from calibration_sample import CELL as MACHINE
from calibration_sample import axis_values, drawn, log_of, measure

from camrob import post
from camrob.cli import app as cli
from camrob.jobs.batch import batch
from camrob.jobs.calibrate import calibrate
from camrob.jobs.diagnose import diagnose
from camrob.jobs.files.output import staged_output
from camrob.jobs.simulate import simulate
from camrob.measurement.write_log import write_log

ROOT = Path(__file__).resolve().parents[2]
CELL = ROOT / "cells" / "kr15_track_table"
PART = (
    "TOOL PATH/CUT,TOOL,MILL\nTLDATA/MILL,10,0,50,0,0\nMSYS/0,0,0,1,0,0,0,1,0\nSPINDL/RPM,9000,CLW\nRAPID\nGOTO/0,0,50,0,0,1\n"
    "FEDRAT/MMPM,500\nGOTO/0,0,0\nGOTO/60,0,0\nGOTO/60,40,0\nGOTO/0,40,0\nGOTO/0,1,0\nRAPID\nGOTO/0,0,50\nSPINDL/OFF\nEND-OF-PATH\n"
)


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("inputs")
    (folder / "setup.toml").write_text("part_in_base = [0, 0, 200, 0, 0, 0]\n")
    (folder / "part.cls").write_text(PART)
    (folder / "jobs.toml").write_text(f'[[job]]\nclfile = "part.cls"\ncell = "{CELL.as_posix()}"\nout = "{{stem}}"\n')
    return folder


@pytest.fixture(scope="module")
def run_log(inputs: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of the part on the ideal controller, as a log."""
    folder = tmp_path_factory.mktemp("log")
    made = post(inputs / "part.cls", cell=CELL, out=folder, report=False)
    log = folder / "run.csv"
    simulate(made.out / "part.src", cell=CELL, out=log)
    return log


Job = Callable[[Path, Callable[[str, float], None]], object]


@pytest.fixture(scope="module")
def verbs(inputs: Path, run_log: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Job]:
    measured = tmp_path_factory.mktemp("measured") / "poses.csv"
    write_log(log_of(MACHINE, measure(MACHINE, drawn(MACHINE), axis_values(MACHINE, 60))), measured)
    return {
        "post": lambda out, hook: post(inputs / "part.cls", cell=CELL, out=out, progress=hook),
        "batch": lambda out, hook: batch(inputs / "jobs.toml", out=out, workers=1, progress=hook),
        "diagnose": lambda out, hook: diagnose(cell=CELL, log=[run_log], out=out, progress=hook),
        "calibrate": lambda out, hook: calibrate(measured, cell=CELL, out=out / "c.toml", progress=hook),
        "simulate": lambda out, hook: simulate(
            run_log.parent / "part.src", cell=CELL, out=out / "s.csv", progress=hook
        ),
    }


def in_a_child(work: Callable[[], object]) -> int:
    """How a forked process ends that does some work: its exit status, or minus the signal that ended it."""
    child = os.fork()
    if child == 0:
        status = 3
        try:
            os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
            work()
            status = 0
        finally:
            os._exit(status)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def listed(folder: Path) -> dict[str, bytes]:
    """Files under final names, by path below the folder."""
    if not folder.exists():
        return {}
    files = (f for f in folder.rglob("*") if f.is_file())
    return {
        str(f.relative_to(folder)): f.read_bytes()
        for f in files
        if not any(p.startswith(".") for p in f.relative_to(folder).parts)
    }


def leftovers(folder: Path) -> list[Path]:
    return [f for f in folder.rglob(".*") if f.is_dir()] if folder.exists() else []


def dying_at(count: int) -> Callable[[str, float], None]:
    """A progress hook that is the last thing its process does, at the call with this index."""
    calls = 0

    def hook(stage: str, done: float) -> None:
        nonlocal calls
        if calls == count:
            os.kill(os.getpid(), signal.SIGKILL)
        calls += 1

    return hook


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("verb", ["post", "diagnose", "calibrate", "simulate"])
def test_killed_at_every_stage(verbs: dict[str, Job], tmp_path: Path, verb: str) -> None:
    """kill -9 as each stage begins: no file under a final name, an old file untouched, and the next run does it all."""
    calls: list[str] = []
    verbs[verb](tmp_path / "whole", lambda stage, done: calls.append(stage))
    whole = set(listed(tmp_path / "whole"))
    assert whole and len(calls) >= 2
    out = tmp_path / "out"
    out.mkdir()
    (out / "mine.txt").write_text("mine")
    for count in sorted({*(calls.index(stage) for stage in calls), len(calls) - 1}):
        assert in_a_child(lambda count=count: verbs[verb](out, dying_at(count))) == -signal.SIGKILL
        assert set(listed(out)) == {"mine.txt"}, calls[count]
    verbs[verb](out, lambda stage, done: None)
    assert set(listed(out)) == whole | {"mine.txt"}
    assert (out / "mine.txt").read_text() == "mine"
    assert leftovers(out) == []


@pytest.mark.slow
def test_a_batch_killed_between_two_jobs(inputs: Path, tmp_path: Path) -> None:
    """Each job's files are all there or none of them, and the next run does the whole list."""
    jobs = tmp_path / "jobs.toml"
    entry = '[[job]]\nclfile = "{file}"\ncell = "{cell}"\nname = "{name}"\nout = "{name}"\n'
    jobs.write_text(
        "".join(
            entry.format(file=(inputs / "part.cls").as_posix(), cell=CELL.as_posix(), name=n) for n in ("one", "two")
        )
    )
    out = tmp_path / "out"
    assert in_a_child(lambda: batch(jobs, out=out, workers=1, progress=dying_at(0))) == -signal.SIGKILL
    whole = {f"{s}" for s in ("src", "dat", "json", "path.npz", "html")}
    made = {name: {f.partition(".")[2] for f in listed(out / name)} for name in ("one", "two")}
    assert all(files in (set(), whole) for files in made.values()) and set() in made.values()
    assert batch(jobs, out=out, workers=1).status == 0
    assert {f.partition(".")[2] for f in listed(out / "two")} == whole and leftovers(out) == []


@pytest.mark.parametrize("step", range(8))
def test_killed_while_files_are_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: int) -> None:
    """kill -9 between two renames: the program that runs the others (NAME.src) is there only with all its files."""
    names = ("a.dat", "a.json", "a_001.src", "a.src")
    out = tmp_path / "out"
    out.mkdir()
    for name in names:
        (out / name).write_text("old")
    rename, calls = os.rename, 0

    def dying(source: object, target: object) -> None:
        nonlocal calls
        if calls == step:
            os.kill(os.getpid(), signal.SIGKILL)
        calls += 1
        rename(source, target)  # type: ignore[arg-type]

    def work() -> None:
        monkeypatch.setattr(os, "rename", dying)
        with staged_output(out, name="a") as folder:
            for name in names:
                (folder / name).write_text("new")

    assert in_a_child(work) == -signal.SIGKILL
    there = listed(out)
    if "a.src" in there:
        assert set(there) == set(names) and len(set(there.values())) == 1
    with staged_output(out, name="a") as folder:
        for name in names:
            (folder / name).write_text("newer")
    assert set(listed(out).values()) == {b"newer"} and set(listed(out)) == set(names)


def test_two_runs_into_one_folder(inputs: Path, tmp_path: Path) -> None:
    """Both end well, and the files that stand there are all of one run."""
    out = tmp_path / "out"
    other = tmp_path / "other"
    shutil.copytree(inputs, other)
    (other / "setup.toml").write_text("part_in_base = [50, 0, 200, 0, 0, 0]\n")
    post(inputs / "part.cls", cell=CELL, out=tmp_path / "one", report=False)
    post(other / "part.cls", cell=CELL, out=tmp_path / "two", report=False)
    children = []
    for folder in (inputs, other):
        child = os.fork()
        if child == 0:
            status = 3
            try:
                post(folder / "part.cls", cell=CELL, out=out, report=False)
                status = 0
            finally:
                os._exit(status)
        children.append(child)
    assert [os.waitstatus_to_exitcode(os.waitpid(c, 0)[1]) for c in children] == [0, 0]
    made = listed(out)
    assert set(made) == set(listed(tmp_path / "one")) and leftovers(out) == []
    sources = {"one": listed(tmp_path / "one")["part.src"], "two": listed(tmp_path / "two")["part.src"]}
    which = next(name for name, data in sources.items() if data == made["part.src"])
    assert made["part.path.npz"] == listed(tmp_path / which)["part.path.npz"]


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A disk of 64 kB."""
    place = tmp_path / "disk"
    place.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(place)], capture_output=True, check=False
    )
    if mounted.returncode:
        pytest.skip("no tmpfs can be mounted here (that takes root)")
    yield place
    subprocess.run(["umount", str(place)], check=True)


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("verb", ["post", "diagnose", "simulate", "batch"])
def test_a_full_disk(
    verb: str, inputs: Path, run_log: Path, small_disk: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """One line, no traceback, and the old program stays."""
    out = small_disk / "out"
    out.mkdir()
    (out / "part.src").write_text("old")
    (small_disk / "fill").write_bytes(b"x" * 48_000)
    command = {
        "post": ["post", str(inputs / "part.cls"), "--cell", str(CELL), "--out", str(out)],
        "diagnose": ["diagnose", "--cell", str(CELL), "--log", str(run_log), "--out", str(out)],
        "simulate": ["simulate", str(run_log.parent / "part.src"), "--cell", str(CELL), "--out", str(out / "s.csv")],
        "batch": ["batch", str(inputs / "jobs.toml"), "--out", str(out), "--workers", "1", "--json"],
    }[verb]
    status = cli.run(command)
    shown = capfd.readouterr()
    assert status == 2
    if verb == "batch":
        assert "space" in json.loads(shown.out)["jobs"][0]["error"]
    else:
        assert shown.out == "" and shown.err.count("\n") == 1 and "No space left" in shown.err
    assert "Traceback" not in shown.err
    assert listed(out) == {"part.src": b"old"} and leftovers(out) == []


def test_inputs_that_vanish(inputs: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Gone between the command and the reading of it: one line that names the file."""
    folder = Path(shutil.copytree(inputs, tmp_path / "in"))
    cell = Path(shutil.copytree(CELL, tmp_path / "cell"))
    for gone, command in (
        (
            cell / "weights_jnt.fis",
            ["post", str(folder / "part.cls"), "--cell", str(cell), "--out", str(tmp_path / "o")],
        ),
        (folder / "part.cls", ["post", str(folder / "part.cls"), "--cell", str(CELL), "--out", str(tmp_path / "o")]),
        (tmp_path / "run.csv", ["diagnose", "--cell", str(CELL), "--log", str(tmp_path / "run.csv"), "--out", "o"]),
        (
            tmp_path / "c.toml",
            [
                "compensate",
                str(folder / "p.src"),
                "--cell",
                str(CELL),
                "--calibration",
                str(tmp_path / "c.toml"),
                "--out",
                str(tmp_path / "o"),
            ],
        ),
    ):
        gone.unlink(missing_ok=True)
        assert cli.run(command) == 2
        shown = capfd.readouterr()
        assert shown.out == "" and shown.err.count("\n") == 1 and "Traceback" not in shown.err
        assert not (tmp_path / "o").exists()


@pytest.mark.slow
def test_an_interrupted_terminal(inputs: Path, tmp_path: Path) -> None:
    """Ctrl-C, a hang-up and a request to end, while the command runs: its status says so, and nothing is left."""
    for how, status in ((signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)):
        program = (
            "import sys, os, camrob.jobs.release.attempt as job\n"
            "from camrob.cli import app as cli\n"
            "job.read_back = lambda *a: (print('now', flush=True), __import__('time').sleep(60))\n"
            "sys.exit(cli.run(sys.argv[1:]))\n"
        )
        command = ["post", str(inputs / "part.cls"), "--cell", str(CELL), "--out", str(tmp_path / "out"), "--no-report"]
        with subprocess.Popen(
            [sys.executable, "-c", program, *command],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
        ) as process:
            assert process.stdout is not None and process.stdout.readline() == "now\n"
            process.send_signal(how)
            _, printed = process.communicate()  # left alone, the job would go on after a minute
        assert process.returncode == status, (how, printed)
        assert "Traceback" not in printed
        assert list(tmp_path.iterdir()) == []
