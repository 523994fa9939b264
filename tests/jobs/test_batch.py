"""`camrob batch`: JOBS.toml checked, jobs side by side, failures and dead workers survived, the same on a Dask cluster."""

from __future__ import annotations

import importlib.util
import json
import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from camrob import post
from camrob.cli import app as cli
from camrob.errors import InputError
from camrob.jobs.batch import BatchResult, batch
from camrob.jobs.batching.jobs_file import read_jobs
from camrob.jobs.batching.parcel import pack_parcel
from camrob.jobs.batching.verbs import VERBS, Kind, read_verb
from camrob.jobs.batching.work import Outcome

ROOT = Path(__file__).resolve().parents[2]
CELL = ROOT / "cells" / "kr15_track_table"
ENGRAVING = ROOT / "toolpaths" / "engraving"
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}

FAR = "TOOL PATH/FAR,TOOL,T1\nUNITS/MM\nFEDRAT/MMPM,500\nGOTO/90000,0,300,0,0,1\nGOTO/90010,0,300,0,0,1\nEND-OF-PATH\n"


def write_jobs(folder: Path, text: str, *, defaults: str = "report = false") -> Path:
    file = folder / "JOBS.toml"
    file.write_text(f'[defaults]\ncell = "{CELL.as_posix()}"\n{defaults}\n{text}', encoding="utf-8")
    return file


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with the engraving in a folder of its own."""
    (tmp_path / "part").mkdir()
    for name in ("engraving.cls", "setup.toml", "stock.stl"):
        shutil.copy(ENGRAVING / name, tmp_path / "part" / name)
    return tmp_path


@pytest.fixture(scope="module")
def posted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The engraving posted by itself; it also sees to it that the kernels are compiled."""
    out = tmp_path_factory.mktemp("single")
    post(ENGRAVING / "engraving.cls", cell=CELL, out=out, report=False)
    return out


def same_as_single(out: Path, posted: Path) -> None:
    """Every file byte for byte, but for the times in NAME.json."""
    assert {f.name for f in out.iterdir() if f.stem.startswith("engraving")} == {f.name for f in posted.iterdir()}
    for file in posted.iterdir():
        mine, single = (out / file.name).read_bytes(), file.read_bytes()
        if file.suffix == ".json":
            of_mine, of_single = json.loads(mine), json.loads(single)
            assert of_mine.pop("seconds").keys() == of_single.pop("seconds").keys()
            assert of_mine == of_single
        else:
            assert mine == single, file.name


# ---- JOBS.toml


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "holds no jobs"),
        ("[[job]]", "clfile: is missing"),
        ('[[job]]\nclfile = "a.cls"\nclfil = 1', "clfil: is not a key of verb 'post'; is it clfile?"),
        ('[[job]]\nclfile = "a.cls"\nverb = "fly"', "verb: is 'fly'; use one of post, verify"),
        ('[[job]]\nclfile = "*.nothing"', "'*.nothing' matches no file"),
        ('[[job]]\nclfile = ""', "clfile: is empty"),
        ('[[job]]\nclfile = "a\\u0000b"', "clfile: is 'a\\x00b'"),
        ('[[job]]\nclfile = "a.cls"\nout = "../b"', "leads out of the batch's folder"),
        ('[[job]]\nclfile = "a.cls"\nout = "/b"', "leads out of the batch's folder"),
        ('[[job]]\nclfile = "a.cls"\nout = "link"', "leads out of the batch's folder by a link"),
        ('[[job]]\nclfile = "a.cls"\nout = "b:c"', "can't be a file's name"),
        ('[[job]]\nclfile = "a.cls"\nname = "1 ; $x"', "name: --name '1 ; $x' can't be a KRL module"),
        ('[[job]]\nclfile = "a.cls"\nmax_lines = 1.5', "max_lines: is 1.5; give a whole number"),
        ('[[job]]\nclfile = "a.cls"\nunits = "cubit"', "units: is 'cubit'; use one of mm, inch"),
        ('[[job]]\nclfile = "a.cls"\nreport = "no"', "report: is 'no'; give true or false"),
        ('[[job]]\nclfile = "a.cls"\n[[job]]\nclfile = "b/A.apt"', "would both write P_A"),
        ('[[job]]\nclfile = "part/*"\nname = "x"', "name: would be the name of 3 programs"),
        ('[[job]]\nverb = "simulate"\nprogram = "a.src"', "out: is missing; give a file"),
        ('[[job]]\nverb = "diagnose"\nlog = "a.csv"', "log: is 'a.csv'; give a list of texts"),
        ("job = 3", "job: is not an array of tables"),
        ("[[job]\n", "is not valid TOML"),
    ],
)
def test_a_wrong_file_is_reported_at_once(folder: Path, text: str, message: str) -> None:
    (folder / "o").mkdir()
    (folder / "o" / "link").symlink_to(folder / "part")
    jobs = write_jobs(folder, text, defaults="")
    if text.startswith("job"):
        jobs.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        batch(jobs, out=folder / "o")
    assert message in str(caught.value) and str(caught.value).startswith(str(jobs))


def test_defaults_are_checked_and_used_where_they_fit(folder: Path) -> None:
    text = '[[job]]\nclfile = "a.cls"\n[[job]]\nverb = "verify"\nprogram = "p.src"\ncell = "c"'
    first, second = read_jobs(write_jobs(folder, text), folder / "o")
    assert first.verb.name == "post" and first.arguments["report"] is False
    assert second.verb.name == "verify" and "report" not in second.arguments and second.out is None
    assert second.arguments["cell"] == folder / "c" and first.arguments["cell"] == CELL
    with pytest.raises(InputError, match=r"defaults\.report: is 'x'"):
        read_jobs(write_jobs(folder, text, defaults='report = "x"'), folder / "o")
    with pytest.raises(InputError, match=r"defaults\.reprot: is not a key of any of these jobs"):
        read_jobs(write_jobs(folder, text, defaults="reprot = false"), folder / "o")
    with pytest.raises(InputError, match="out: is missing; give a folder, or --out"):
        read_jobs(write_jobs(folder, text))


def test_patterns_stand_for_files_in_order(folder: Path) -> None:
    for name in ("b.cls", "a.cls", "c[1].cls"):
        (folder / name).write_text("x")
    (folder / "d.cls").mkdir()
    text = '[[job]]\nclfile = "[a-z].cls"\n[[job]]\nclfile = "c[1].cls"\n[[job]]\nclfile = "*/*.cls"\nout = "{folder}/{stem}"'
    jobs = read_jobs(write_jobs(folder, text), folder / "o")
    assert [j.label for j in jobs] == ["a.cls", "b.cls", "c[1].cls", "part/engraving.cls"]
    assert jobs[3].out == folder / "o" / "part" / "engraving" and jobs[0].out == folder / "o"
    text = '[[job]]\nverb = "diagnose"\nlog = ["[ab].cls", "c[1].cls"]'
    (job,) = read_jobs(write_jobs(folder, text, defaults=""), folder / "o")
    assert [p.name for p in job.arguments["log"]] == ["a.cls", "b.cls", "c[1].cls"]


def test_every_verb_takes_what_its_function_takes() -> None:
    for name, (about, _, choices) in VERBS.items():
        verb = read_verb(name)
        assert verb.keys[about] in (Kind.FILE, Kind.FILES) and verb.keys["cell"] is Kind.FILE
        assert "progress" not in verb.keys and "return" not in verb.keys and choices.keys() <= verb.keys.keys()
    assert read_verb("post").keys["max_lines"] is Kind.INTEGER and read_verb("post").keys["report"] is Kind.FLAG
    assert read_verb("simulate").keys["cycle_ms"] is Kind.NUMBER and read_verb("simulate").keys["out"] is Kind.FILE


def test_a_parcel_holds_all_that_the_job_reads_and_no_more(folder: Path) -> None:
    (folder / "part" / "other.stl").write_text("x")
    for name, text in {
        "main.src": "DEF main()\nsub1()\nEND",
        "main.dat": "",
        "Sub1.SRC": "DEF sub1()\nSUB2( )\nEND",
        "sub2.src": "",
        "other.src": "",
    }.items():
        (folder / name).write_text(text)
    (folder / "log.csv").write_text("t\n")
    (folder / "log.toml").write_text('program = "sub2.src"')
    text = """[[job]]\nclfile = "part/engraving.cls"
        [[job]]\nverb = "verify"\nprogram = "main.src"
        [[job]]\nverb = "diagnose"\nlog = ["log.csv"]
        [[job]]\nclfile = "missing.cls"\ncell = "nowhere" """
    jobs = read_jobs(write_jobs(folder, text), folder / "o")
    files = [{Path(file).name for _, file in pack_parcel(job).files} for job in jobs]
    cell = {f.name for f in CELL.rglob("*") if f.is_file()}
    assert files[0] - cell == {"engraving.cls", "setup.toml", "stock.stl"} and cell <= files[0]
    assert files[1] - cell == {"main.src", "main.dat", "Sub1.SRC", "sub2.src"}
    assert files[2] - cell == {"log.csv", "log.toml", "sub2.src"}
    assert files[3] == set()


# ---- on this machine

THREE = """
[[job]]
clfile = "part/engraving.cls"
[[job]]
clfile = "far.cls"
[[job]]
clfile = "missing.cls"
out = "deep/{stem}"
"""


def test_a_job_that_fails_does_not_stop_the_rest(
    folder: Path, posted: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "far.cls").write_text(FAR)
    jobs = write_jobs(folder, THREE)
    seen: list[tuple[str, float]] = []
    result = batch(jobs, out=folder / "o", workers=2, progress=lambda what, share: seen.append((what, share)))
    good, far, missing = result.summary.jobs
    assert [j.status for j in result.summary.jobs] == [0, 3, 2] and result.status == 3 and not result.ok
    assert result.summary.counts == {"0": 1, "1": 0, "2": 1, "3": 1}
    assert good.error is None and good.summary["points"] > 100
    assert "out of" in far.error or "reach" in far.error
    assert missing.error.startswith(str(folder / "missing.cls")) and "camrob-batch" not in missing.error
    same_as_single(folder / "o", posted)
    assert {f.name for f in (folder / "o").iterdir()} == {f.name for f in posted.iterdir()}  # nothing of the others
    assert seen[-1] == ("3 of 3 jobs done, 2 not done", 1.0) and any("engraving.cls: resolve" in s for s, _ in seen)
    json.dumps(result.summary.to_json(), allow_nan=False)


def kill_when(stage: str, times: int) -> Callable[[str, float], None]:
    """Progress that kills the only worker when a job has come to a stage."""
    left = [times]
    pids: set[int | None] = set()

    def progress(what: str, share: float) -> None:
        (worker,) = multiprocessing.active_children() or [None]
        if worker is not None and left[0] and stage in what and worker.pid not in pids:
            left[0] -= 1
            pids.add(worker.pid)
            worker.kill()
            worker.join()

    return progress


@pytest.mark.slow
def test_a_dead_workers_job_is_done_again(folder: Path, posted: Path) -> None:
    jobs = write_jobs(folder, '[[job]]\nclfile = "part/engraving.cls"')
    result = batch(jobs, out=folder / "o", workers=1, progress=kill_when("resolve", 1))
    assert result.ok and result.summary.jobs[0].attempts == 2
    same_as_single(folder / "o", posted)


@pytest.mark.slow
def test_a_job_that_kills_its_workers_is_reported_and_the_rest_is_done(folder: Path, posted: Path) -> None:
    (folder / "far.cls").write_text(FAR)
    jobs = write_jobs(folder, '[[job]]\nclfile = "part/engraving.cls"\n[[job]]\nclfile = "far.cls"')
    result = batch(jobs, out=folder / "o", workers=1, progress=kill_when("engraving.cls: re", 2))
    lost, far = result.summary.jobs
    assert (lost.status, lost.attempts, far.attempts) == (3, 2, 1)
    assert "its worker died 2 times (signal 9)" in lost.error and "died" not in far.error
    assert not (folder / "o").exists()


@pytest.mark.slow
def test_an_interruption_leaves_nothing(folder: Path, posted: Path) -> None:
    write_jobs(folder, '[[job]]\nclfile = "part/engraving.cls"')
    (folder / "tmp").mkdir()
    command = [sys.executable, "-m", "camrob.cli", "batch", "JOBS.toml", "--out", "o", "--workers", "1"]
    environment = {**ENVIRONMENT, "TMPDIR": str(folder / "tmp")}
    process = subprocess.Popen(command, cwd=folder, env=environment, start_new_session=True, stderr=subprocess.PIPE)
    until(lambda: any((folder / "tmp").glob("camrob-batch-*/0-0/root")))
    os.killpg(process.pid, signal.SIGINT)  # what a terminal does: the workers get it, too
    printed = process.communicate()[1].decode()
    assert process.returncode == 130 and printed == "camrob: interrupted; no unfinished file was left\n"
    assert not (folder / "o").exists() and not list((folder / "tmp").iterdir())
    until(lambda: not alive(process.pid))


def until(true: Callable[[], bool]) -> None:
    """Wait, however busy the machine is; what takes this long hangs."""
    end = time.monotonic() + 900.0
    while not true():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)


def alive(group: int) -> bool:
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


# ---- the command line


def test_the_command_line(folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "far.cls").write_text(FAR)
    jobs = write_jobs(folder, THREE)

    def done(parcels: Any, **_: Any) -> Iterator[tuple[Outcome, None, int]]:
        for parcel in parcels:
            error = None if parcel.index == 0 else "\x1b[2Jfar.cls: it's wrong [red]"
            status = (1, 2, 2)[parcel.index]
            yield Outcome(parcel.index, status, error, {"errors": [{"text": "jumps"}]}, (), 1.0), None, 1 + parcel.index

    monkeypatch.setattr("camrob.jobs.batch.run_local", done)
    assert cli.run(["batch", str(jobs), "--out", str(folder / "o")]) == 2
    shown = capsys.readouterr()
    text = " ".join(shown.out.split())
    assert shown.err == "" and "\x1b" not in shown.out and "[red]" in text
    for expected in ("check failed", "part/engraving.cls: jumps", "input wrong (2 attempts)", "0 of 3 jobs done in"):
        assert expected in text
    assert cli.run(["batch", str(jobs), "--out", str(folder / "o"), "--json"]) == 2
    assert json.loads(capsys.readouterr().out)["counts"] == {"0": 0, "1": 1, "2": 2, "3": 0}
    assert cli.run(["batch", str(folder / "no.toml")]) == 2
    assert (
        capsys.readouterr().err == f"{folder / 'no.toml'}: can't be read (No such file or directory); check the path\n"
    )
    assert cli.run(["batch", str(jobs), "--out", "o", "--workers", "2", "--scheduler", "tcp://127.0.0.1:1"]) == 2
    assert "no --scheduler" in capsys.readouterr().err


# ---- on a Dask cluster of real processes

needs_dask = pytest.mark.skipif(
    importlib.util.find_spec("distributed") is None,
    reason='dask.distributed is not here: pip install "camrob[cluster]"',
)


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[tuple[str, dict[str, subprocess.Popen[bytes]]]]:
    """A scheduler on loopback and two workers in processes of their own; its address, and the workers by name."""
    file = tmp_path / "scheduler.json"
    running: list[subprocess.Popen[bytes]] = []

    def start(module: str, *arguments: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.{module}", *arguments]
        process = subprocess.Popen(
            command, cwd=tmp_path, env=ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        running.append(process)
        return process

    try:
        here = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file))
        start("dask_scheduler", *here)
        worker = ("--scheduler-file", str(file), "--nthreads", "1", "--no-nanny", "--no-dashboard")
        until(lambda: file.is_file() and file.stat().st_size > 0)
        workers = {
            name: start("dask_worker", *worker, "--name", name, "--local-directory", str(tmp_path / name))
            for name in ("w1", "w2")
        }
        yield json.loads(file.read_text())["address"], workers
    finally:
        for process in reversed(running):
            process.kill()
            process.wait()


class KillAtWork(threading.Thread):
    """Kills the first worker that has begun a job, once that is heard: its sandbox holds the job's file."""

    def __init__(self, folder: Path, file: str, workers: dict[str, subprocess.Popen[bytes]]) -> None:
        super().__init__()
        self.folder, self.file, self.workers = folder, file, workers
        self.heard, self.over, self.killed = threading.Event(), threading.Event(), ""

    def hear(self, what: str) -> None:
        """Progress of the batch."""
        if f"{self.file}: " in what:
            self.heard.set()

    def run(self) -> None:
        self.heard.wait()
        while not self.over.wait(0.01):
            for name, process in self.workers.items():
                if any((self.folder / name).glob(f"dask-scratch-space/worker-*/camrob-*/**/{self.file}")):
                    process.kill()
                    self.killed = name
                    return


@pytest.mark.slow
@needs_dask
def test_the_same_on_a_cluster_that_loses_a_worker(
    folder: Path,
    posted: Path,
    cluster: tuple[str, dict[str, subprocess.Popen[bytes]]],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("camrob.jobs.batching.dask_workers._PATIENCE", 3600.0)  # the machine may be busy
    address, workers = cluster
    (folder / "far.cls").write_text(FAR)
    jobs = write_jobs(folder, THREE)
    killer = KillAtWork(folder, "engraving.cls", workers)
    killer.start()
    seen: list[str] = []

    def progress(what: str, _: float) -> None:
        seen.append(what)
        killer.hear(what)

    try:
        result: BatchResult = batch(jobs, out=folder / "o", scheduler=address, progress=progress)
    finally:
        killer.over.set()
        killer.heard.set()
        killer.join()
    assert killer.killed and workers[killer.killed].wait() == -signal.SIGKILL
    _, far, missing = result.summary.jobs
    assert [j.status for j in result.summary.jobs] == [0, 3, 2], result.summary
    assert max(j.attempts for j in result.summary.jobs) >= 2
    assert "reach" in far.error and "died" not in far.error and "lost" not in far.error
    assert missing.error.startswith(str(folder / "missing.cls"))
    same_as_single(folder / "o", posted)
    assert {f.name for f in (folder / "o").iterdir()} == {f.name for f in posted.iterdir()}
    assert any("engraving.cls: " in what for what in seen)

    def interrupt(what: str, _: float) -> None:
        if "resolve" in what:
            os.kill(os.getpid(), signal.SIGINT)

    sandboxes = "w[12]/dask-scratch-space/worker-*/camrob-*"
    left = set(folder.glob(sandboxes))  # by the worker that was killed, until Dask clears it
    with pytest.raises(KeyboardInterrupt):
        batch(jobs, out=folder / "o2", scheduler=address, progress=interrupt)
    assert not (folder / "o2").exists()
    until(lambda: set(folder.glob(sandboxes)) == left)  # the worker stops, too, and clears up
    assert len(left) == 1


@needs_dask
def test_a_scheduler_that_is_not_there(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("camrob.jobs.batching.dask_workers._PATIENCE", 1.0)
    jobs = write_jobs(folder, '[[job]]\nclfile = "part/engraving.cls"')
    for address in ("tcp://127.0.0.1:9", "nonsense://x", "127.0.0.1:badport"):
        with pytest.raises(InputError, match="does not answer"):
            batch(jobs, out=folder / "o", scheduler=address)
    assert not (folder / "o").exists()
