"""A full disk is called so, in one line that says what to do; nothing half-written is left."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from camrob.cli import app as cli
from camrob.errors import InputError
from camrob.jobs.exit_status import failure_line, failure_status
from camrob.jobs.files import output
from camrob.jobs.files.output import staged_output

ROOT = Path(__file__).resolve().parents[2]
KR15 = ROOT / "cells" / "kr15_track_table"
PROGRAM = ROOT / "toolpaths" / "engraving" / "golden" / "engraving.src"
FULL = pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT, errno.EFBIG], ids=["disk", "quota", "file"])


def full(number: int, *names: str) -> OSError:
    return OSError(number, os.strerror(number), *names)


@FULL
def test_the_line_of_a_job(number: int) -> None:
    assert failure_line(full(number, "/data/x")) == (
        "/data/x: disk full; free some space where the job writes and where temporary files are kept"
    )
    assert failure_line(full(number)).startswith("disk full; free some space")
    assert failure_status(full(number)) == 2
    assert "disk full" not in failure_line(OSError(errno.EACCES, "Permission denied", "/data/x"))


@FULL
@pytest.mark.parametrize("named", [True, False])
def test_while_files_are_written(tmp_path: Path, number: int, named: bool) -> None:
    """A file object that runs full gives no name; the folder is named all the same."""
    out = tmp_path / "out"
    with pytest.raises(InputError) as caught, staged_output(out) as folder:
        (folder / "a.src").write_text("half")
        raise full(number, *([str(folder / "a.src")] if named else []))
    hint = "free some space there and where temporary files are kept, or choose another --out"
    assert str(caught.value) == f"{out}: can't be written: disk full ({os.strerror(number)}); {hint}"
    assert not out.exists()


@pytest.mark.parametrize("call", ["mkdtemp", "rename", "mkdir"])
def test_while_folders_are_made_and_files_are_moved(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: str) -> None:
    def fail(*given: object, **named: object) -> None:
        raise full(errno.ENOSPC, str(tmp_path))

    owner = {"mkdtemp": output.tempfile, "rename": output.os, "mkdir": output.Path}[call]
    monkeypatch.setattr(owner, call, fail)
    said = r"can't be written: disk full \(No space left on device\); free some space"
    with pytest.raises(InputError, match=said), staged_output(tmp_path / "out") as folder:
        (folder / "a.src").write_text("whole")
    monkeypatch.undo()
    assert list(tmp_path.iterdir()) == []


def test_on_the_command_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def fail(*given: object, **named: object) -> None:
        raise full(errno.ENOSPC)

    monkeypatch.setattr("camrob.jobs.simulate.write_log", fail)
    given = ["simulate", str(PROGRAM), "--cell", str(KR15), "--out", str(tmp_path / "LOG.csv"), "--quiet"]
    assert cli.run(given) == 2
    shown = capfd.readouterr()
    assert shown.err.startswith(f"{tmp_path}: can't be written: disk full (No space left on device); free")
    assert shown.err.count("\n") == 1 and shown.out == ""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow(after=1)
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
@pytest.mark.parametrize("how", ["--json", None])
def test_a_summary_that_can_t_be_printed(tmp_path: Path, how: str | None) -> None:
    given = ["simulate", PROGRAM, "--cell", KR15, "--out", tmp_path / "L.csv", *([how] if how else [])]
    command = [sys.executable, "-m", "camrob.cli", *map(str, given)]
    with Path("/dev/full").open("w") as sink:
        done = subprocess.run(command, stdout=sink, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 2
    expected = "the job is done, but its summary can't be printed (disk full); send standard output elsewhere"
    assert done.stderr == f"camrob: {expected}\n"
    assert (tmp_path / "L.csv").is_file()
