"""The command line's contract: status, one-line errors, JSON alone on standard output, nothing heavy at the start."""

from __future__ import annotations

import importlib.machinery
import inspect
import json
import os
import select
import signal
import subprocess
import sys
import types
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import pytest
import typer
from summary_samples import post_summary, region, verify_summary

from camrob import errors
from camrob.cli import app as cli
from camrob.cli.console import Terminated, error_line, exit_status
from camrob.cli.slips import slip_of
from camrob.summaries.base import Summary
from camrob.summaries.regress_summary import RegressSummary
from camrob.summaries.verify_summary import VerifySummary

ROOT = Path(__file__).resolve().parents[2]
ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "tests")])}

SUMMARY = post_summary(
    regions=[
        region(0, "ROUGH [red]\x1b[2J", revised=True, inv_kf_before=0.41, inv_kf_after=0.66),
        region(1, "FINISH", points=12045),
    ]
)


NO_SAMPLES = RegressSummary(ok=True, cell="c", updated=False, samples=())


@dataclass
class Result:
    summary: Summary = SUMMARY
    ok: bool = True
    findings: tuple[object, ...] = ()


Plant = Callable[[str, object], list[dict[str, object]]]


@pytest.fixture(autouse=True)
def beside_a_cell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Commands are given in a folder that has the folder of a cell."""
    (tmp_path / "c").mkdir()
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def plant(monkeypatch: pytest.MonkeyPatch) -> Plant:
    """Put a job in the place of a verb's own: it returns what is given, or raises it, and notes what it was given."""

    def planting(verb: str, outcome: object) -> list[dict[str, object]]:
        calls: list[dict[str, object]] = []

        def job(first: Path, **options: object) -> object:
            calls.append({"first": first, **options})
            if isinstance(outcome, BaseException):
                raise outcome
            return outcome

        name = f"camrob.jobs.{verb}"
        module = types.ModuleType(name)
        module.__spec__ = importlib.machinery.ModuleSpec(name, None)
        setattr(module, verb, job)
        monkeypatch.setitem(sys.modules, name, module)
        return calls

    return planting


POST = ["post", "a.cls", "--cell", "c", "--out", "o"]


def test_post_hands_everything_over(plant: Plant, capsys: pytest.CaptureFixture[str]) -> None:
    calls = plant("post", Result())
    assert cli.run(POST) == 0
    assert calls[0].pop("progress")
    assert calls[0] == {
        "first": Path("a.cls"),
        "cell": Path("c"),
        "out": Path("o"),
        "setup": None,
        "name": None,
        "method": "vjm",
        "feed": "program",
        "max_lines": None,
        "dialect": None,
        "units": None,
        "device": "cpu",
        "for_accuracy": False,
        "then_compensated": False,
        "calibration": None,
        "diagnosis": None,
        "force": None,
        "seconds": None,
        "prove": None,
        "report": True,
    }
    more = "--setup s.toml --name n --method planned --feed optimal --max-lines 5000 --dialect nx-clsf --units inch --device cuda"
    more += " --for-accuracy --calibration f.toml --diagnosis d --force F.toml --seconds 20 --prove 30"
    assert cli.run([*POST, *more.split(), "--no-report", "--quiet"]) == 0
    assert calls[1].pop("progress")
    assert calls[1] == {
        "first": Path("a.cls"),
        "cell": Path("c"),
        "out": Path("o"),
        "setup": Path("s.toml"),
        "name": "n",
        "method": "planned",
        "feed": "optimal",
        "max_lines": 5000,
        "dialect": "nx-clsf",
        "units": "inch",
        "device": "cuda",
        "for_accuracy": True,
        "then_compensated": False,
        "calibration": Path("f.toml"),
        "diagnosis": Path("d"),
        "force": Path("F.toml"),
        "seconds": 20.0,
        "prove": 30.0,
        "report": False,
    }


def test_the_summary_for_a_person(plant: Plant, capsys: pytest.CaptureFixture[str]) -> None:
    plant("post", Result())
    assert cli.run(POST) == 0
    shown = capsys.readouterr()
    assert shown.err == "" and "\x1b" not in shown.out
    lines = [line.rstrip() for line in shown.out.splitlines()]
    assert lines[0] == "1 warning to read first" and "line 33" in lines[1]
    text = " ".join(shown.out.split())
    for expected in (
        "12,345 in 2 regions",
        "5 min 10 s as programmed; 3 min 42 s at the fastest safe feed",
        "1/k_F lowest 0.450, mean 0.610",
        "A2 3.0 deg, A5 12.3 deg, A6 55.0 deg, E1 400.0 mm",
        "none; least clearance 12.0 mm",
        "E1 812.0 mm, E2 95.0 deg",
        "12345 points read back and replayed; at most 0.0001 mm off",
        "ROUGH [red]",
        "0.410 to 0.660 by revision",
    ):
        assert expected in text, expected


def test_a_poor_summary_says_so(plant: Plant, capsys: pytest.CaptureFixture[str]) -> None:
    summary = post_summary(
        warnings=[],
        singular=2,
        time_s={"program": 4000.0, "optimal": None},
        collisions={"checked": False, "count": 0, "clearance_min_mm": None},
        limits={"margin_min": {}, "violations": 3},
        witness={"complete": False, "not_judged": ["macros"]},
    )
    plant("post", Result(summary))
    assert cli.run(POST) == 0
    text = " ".join(capsys.readouterr().out.split())
    for expected in (
        "No warnings.",
        "2 singular points",
        "Verified in part",
        "1 h 06 min as programmed",
        "not checked",
        "least margin to a limit: -; 3 points past a limit",
    ):
        assert expected in text, expected


def test_json_is_alone_on_standard_output(plant: Plant, capsys: pytest.CaptureFixture[str]) -> None:
    plant("post", Result())
    assert cli.run([*POST, "--json"]) == 0
    shown = capsys.readouterr()
    assert json.loads(shown.out) == SUMMARY.to_json()
    assert shown.err == ""


def test_json_never_holds_what_json_has_not(plant: Plant, capsys: pytest.CaptureFixture[str]) -> None:
    plant("post", Result(post_summary(points=float("nan"))))
    assert cli.run([*POST, "--json"]) == 3
    shown = capsys.readouterr()
    assert shown.out == "" and shown.err.count("\n") == 1 and "report it" in shown.err


def test_quiet_is_quiet(plant: Plant, capsys: pytest.CaptureFixture[str]) -> None:
    plant("post", Result())
    assert cli.run([*POST, "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("verb", "arguments", "summary", "expected"),
    [
        ("verify", ["p.src"], verify_summary(), ("p: ", "against it", "limits not judged")),
        (
            "regress",
            ["toolpaths"],
            RegressSummary(ok=True, cell="c", updated=False, samples=()),
            ("all 0 samples come out as before",),
        ),
    ],
)
@pytest.mark.parametrize("ok", [True, False])
def test_a_failed_check_is_status_1(
    plant: Plant,
    capsys: pytest.CaptureFixture[str],
    verb: str,
    arguments: list[str],
    summary: VerifySummary | RegressSummary,
    expected: tuple[str, ...],
    ok: bool,
) -> None:
    calls = plant(verb, Result(replace(summary, ok=ok), ok))
    assert cli.run([verb, *arguments, "--cell", "c"]) == (0 if ok else 1)
    shown = capsys.readouterr()
    assert shown.err == "" and all(text in shown.out for text in expected)
    assert calls[0]["first"] == Path(arguments[0]) and calls[0]["cell"] == Path("c")
    assert cli.run([verb, *arguments, "--cell", "c", "--json"]) == (0 if ok else 1)
    assert json.loads(capsys.readouterr().out)["ok"] is ok


@pytest.mark.parametrize(
    ("ok", "allow", "status"), [(None, [], 1), (None, ["--allow-unjudged"], 0), (False, ["--allow-unjudged"], 1)]
)
def test_what_could_not_be_judged_is_status_1_unless_it_may_be(
    plant: Plant, capsys: pytest.CaptureFixture[str], ok: bool | None, allow: list[str], status: int
) -> None:
    plant("verify", Result(verify_summary(ok=ok, not_judged=["p.src, line 7: FOO()"]), ok))
    assert cli.run(["verify", "p.src", "--cell", "c", *allow]) == status
    shown = " ".join(capsys.readouterr().out.split())
    assert "line 7: FOO()" in shown and ("not all of it could be judged" in shown) == (ok is None)


STATUSES = [
    (errors.InputError("is wrong", hint="mend it", path="a.cls", line=7), 2, "a.cls:7: is wrong; mend it"),
    (errors.CellError("key is missing", path="cell.toml"), 2, "cell.toml: key is missing"),
    (errors.ToolpathError("no units", hint="say --units"), 2, "camrob: no units; say --units"),
    (errors.StaleInputError("the calibration is another cell's"), 2, "camrob: the calibration is another cell's"),
    (
        errors.LimitError("A5 would pass its limit", line=33, axis="A5"),
        3,
        "camrob: A5 would pass its limit; CL line 33; axis A5",
    ),
    (errors.UnreachableError("out of reach"), 3, "camrob: out of reach"),
    (errors.VerificationError("the program strays"), 3, "camrob: the program strays"),
    (errors.CamrobError("anything else"), 3, "camrob: anything else"),
    (FileNotFoundError(2, "No such file or directory", "x.cls"), 2, "camrob: x.cls: No such file or directory; check"),
    (MemoryError(), 3, "camrob: there is not enough memory"),
    (RuntimeError("two\nlines\x1b[2J"), 3, "camrob: internal error (RuntimeError: two lines [2J); please report it"),
    (KeyboardInterrupt(), 130, "camrob: interrupted"),
    (Terminated(), 143, "camrob: interrupted"),
]


@pytest.mark.parametrize(
    ("error", "status", "line"), STATUSES, ids=lambda x: type(x).__name__ if isinstance(x, BaseException) else ""
)
def test_every_error_is_one_line_and_its_status(
    plant: Plant,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    error: BaseException,
    status: int,
    line: str,
) -> None:
    monkeypatch.delenv("CAMROB_DEBUG", raising=False)
    assert exit_status(error) == status
    plant("post", error)
    assert cli.run([*POST, "--json"]) == status
    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err.startswith(line) and shown.err.count("\n") == 1 and "Traceback" not in shown.err


def test_the_whole_error_tree_has_a_status() -> None:
    for name in errors.__all__:
        cls = getattr(errors, name)
        wanted = 2 if issubclass(cls, errors.InputError | errors.StaleInputError) else 3
        assert exit_status(cls("x")) == wanted, name


def test_debugging_shows_the_traceback(
    plant: Plant, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CAMROB_DEBUG", "1")
    plant("post", RuntimeError("x"))
    assert cli.run(POST) == 3
    shown = capsys.readouterr().err
    assert "Traceback" in shown and shown.splitlines()[-1].startswith("camrob: internal error")


def test_an_error_line_is_one_line_whatever_it_says() -> None:
    assert error_line(OSError("odd")).startswith("internal error (OSError: odd)")
    assert "\n" not in error_line(errors.JobError("a\r\nb"))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "Missing command"),
        (["cell"], "camrob cell: Missing command; see 'camrob cell --help'"),
        (["carve"], "No such command 'carve'"),
        (["post"], "Missing argument 'CLFILE'"),
        (["post", "a.cls", "--out", "o"], "Missing option '--cell'"),
        ([*POST, "--method", "magic"], "'magic' is not one of 'vjm', 'planned'"),
        ([*POST, "--max-lines", "0"], "--max-lines"),
        ([*POST, "--max-lines", "x"], "--max-lines"),
        ([*POST, "--colour"], "No such option"),
        ([*POST, "more"], "more"),
        (["--colour"], "No such option"),
    ],
)
def test_a_wrong_command_line_is_status_2_and_one_line(
    plant: Plant, capsys: pytest.CaptureFixture[str], arguments: list[str], message: str
) -> None:
    calls = plant("post", Result())
    assert cli.run(arguments) == 2
    shown = capsys.readouterr()
    assert calls == [] and shown.out == ""
    assert message in shown.err and shown.err.count("\n") == 1 and "--help" in shown.err


def test_verbs_are_there_when_their_jobs_are(plant: Plant, capsys: pytest.CaptureFixture[str]) -> None:
    for verb in cli.VERBS:
        plant(verb.__name__, Result())
    assert cli.run(["--help"]) == 0
    shown = capsys.readouterr().out
    for verb in cli.VERBS:
        assert verb.__name__.replace("_", "-") in shown
    for box in "│╭─":
        assert box not in shown


@pytest.mark.parametrize("verb", ["post", "verify", "regress"])
def test_jobs_take_what_the_verbs_give(plant: Plant, verb: str) -> None:
    real = getattr(importlib.import_module(f"camrob.jobs.{verb}"), verb)
    calls = plant(verb, Result())
    arguments = {"post": POST, "verify": ["verify", "p", "--cell", "c"], "regress": ["regress", "t", "--cell", "c"]}[
        verb
    ]
    cli.run([*arguments, "--quiet"])
    inspect.signature(real).bind(calls[0].pop("first"), **calls[0])


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    import importlib.metadata

    try:
        importlib.metadata.version("camrob")
    except importlib.metadata.PackageNotFoundError:
        pytest.skip("camrob is not installed here, so that it has no version")
    assert cli.run(["--version"]) == 0
    assert capsys.readouterr().out.startswith("camrob 0.")


def test_progress_shows_only_on_a_terminal(plant: Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    import pty

    def job(first: Path, *, progress: Callable[[str, float], None], **options: object) -> Result:
        progress("resolving [bold]", 0.5)
        return Result()

    plant("post", Result())
    monkeypatch.setattr(sys.modules["camrob.jobs.post"], "post", job)
    ours, theirs = pty.openpty()
    with open(theirs, "w", closefd=True) as terminal:
        monkeypatch.setattr(sys, "stderr", terminal)
        monkeypatch.setenv("TERM", "xterm")
        assert cli.run([*POST, "--json"]) == 0
        terminal.flush()
        shown = b""
        while select.select([ours], [], [], 0.5)[0]:
            shown += os.read(ours, 65536)
    os.close(ours)
    assert b"resolving [bold]" in shown


def test_help_loads_nothing_heavy() -> None:
    program = (
        "import sys\n"
        "from camrob.cli import app as cli\n"
        "assert cli.run(['--help']) == 0\n"
        "assert not {'numpy', 'scipy', 'numba', 'torch', 'rich', 'trimesh'} & set(sys.modules), 'heavy'\n"
    )
    subprocess.run([sys.executable, "-c", program], env=ENVIRONMENT, check=True, capture_output=True)


JOB_IN_A_PROCESS = """
import importlib.machinery, sys, time, types
from summary_samples import post_summary
from camrob.cli import app as cli
from camrob.jobs.files.output import staged_output

class Result:
    summary = post_summary(program="x" * 200000)

def post(clfile, *, out, **options):
    with staged_output(out) as folder:
        (folder / "a.src").write_text("half")
        if clfile.name == "slow.cls":
            print("ready", file=sys.stderr, flush=True)
            time.sleep(30)
    return Result()

module = types.ModuleType("camrob.jobs.post")
module.__spec__ = importlib.machinery.ModuleSpec("camrob.jobs.post", None)
module.post = post
sys.modules["camrob.jobs.post"] = module
sys.argv[0] = "camrob"
cli.main()
"""


@pytest.mark.parametrize(("how", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupted_command_leaves_nothing(tmp_path: Path, how: signal.Signals, status: int) -> None:
    out = tmp_path / "out"
    command = [sys.executable, "-c", JOB_IN_A_PROCESS, "post", "slow.cls", "--cell", "c", "--out", str(out)]
    with subprocess.Popen(
        command, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stderr is not None and process.stderr.readline() == "ready\n"
        process.send_signal(how)
        printed, error = process.communicate()  # left alone, the job would end well after half a minute
    assert process.returncode == status
    assert printed == "" and error == "camrob: interrupted; no unfinished file was left\n"
    assert not out.exists()


def test_a_reader_that_goes_away_is_no_error(tmp_path: Path) -> None:
    command = [sys.executable, "-c", JOB_IN_A_PROCESS, "post", "a.cls", "--cell", "c", "--out", str(tmp_path), "--json"]
    with subprocess.Popen(command, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stderr is not None
        process.stdout.close()
        error = process.stderr.read()
        assert process.wait(10) == 0
    assert error == b""


def test_text_that_the_terminal_cannot_show_is_no_error(tmp_path: Path) -> None:
    program = JOB_IN_A_PROCESS.replace('"x" * 200000', '"\\u2014\\ud800"')
    command = [sys.executable, "-c", program, "post", "a.cls", "--cell", "c", "--out", str(tmp_path)]
    environment = {**ENVIRONMENT, "PYTHONIOENCODING": "ascii"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and done.stderr == "" and "\\u2014" in done.stdout


@pytest.mark.parametrize(("before", "after"), [(None, "1"), ("4", "4")])
def test_a_verb_keeps_blas_to_one_thread_where_the_user_says_nothing(before, after, monkeypatch):
    from camrob.cli import app

    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        monkeypatch.setenv(name, before or "")
        if before is None:
            monkeypatch.delenv(name)
    monkeypatch.setattr(app, "run", lambda: 0)
    with pytest.raises(SystemExit):
        app.main()
    assert {os.environ[n] for n in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")} == {after}


def test_the_package_is_a_command_too() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "camrob", "--version"], env=ENVIRONMENT, capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("camrob ")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([*POST[:-1], ""], "camrob post: --out is empty; give it a value (. is this folder), or leave it out"),
        ([*POST, "--setup="], "camrob post: --setup is empty"),
        (["post", "", *POST[2:]], "camrob post: an argument is empty"),
        ([*POST, "--name", "a", "--name", "b"], "camrob post: --name is given twice, as 'a' and 'b'; give it once"),
        ([*POST, "\u2014name", "a"], "camrob post: '\u2014name' begins with a text processor's dash; write --name"),
        (["parts/a.cls", *POST], "camrob: 'parts/a.cls' stands where the verb should; write the verb first"),
        (["cell", "cells/mine", "check"], "camrob cell: 'cells/mine' stands where the verb should"),
    ],
)
def test_a_slip_that_the_parser_takes_in_silence_is_answered(
    plant: Plant, capsys: pytest.CaptureFixture[str], arguments: list[str], message: str
) -> None:
    calls = plant("post", Result())
    assert cli.run(arguments) == 2
    shown = capsys.readouterr()
    assert calls == [] and shown.out == "" and shown.err.startswith(message) and shown.err.count("\n") == 1


def test_what_may_be_given_again_is_no_slip() -> None:
    command = typer.main.get_command(cli.build_app())
    assert not slip_of(["diagnose", "--cell", "c", "--log", "a.csv", "--log", "b.csv", "--out", "o"], command)
    assert not slip_of(["post", "--out", "o", "--", "--out", "--out"], command)


@pytest.mark.skipif(os.name != "posix", reason="closes file descriptors")
@pytest.mark.parametrize("stream", [0, 1, 2])
def test_a_closed_stream_is_no_fault(stream: int) -> None:
    command = [sys.executable, "-m", "camrob", "verify", "none.src", "--cell", "kr15_track_table"]
    done = subprocess.run(
        command, env=ENVIRONMENT, stderr=subprocess.PIPE, preexec_fn=lambda: os.close(stream), text=True, check=False
    )
    assert done.returncode == 2 and "internal error" not in done.stderr
