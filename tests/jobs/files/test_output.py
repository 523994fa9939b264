"""Output folders: whole or not at all, whatever happens in the middle."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from camrob.errors import InputError
from camrob.jobs.files import output
from camrob.jobs.files.output import check_file_name, demand_own_name, staged_output

ROOT = Path(__file__).resolve().parents[2]
SUFFIXES = (".src", ".dat", ".json")


def write(folder: Path, text: str, names: tuple[str, ...] = ("a.src", "a.dat", "a.json")) -> None:
    for name in names:
        (folder / name).write_text(text)


def contents(folder: Path) -> dict[str, str]:
    return {f.name: f.read_text() for f in folder.iterdir()}


def test_files_appear_together_at_the_end(tmp_path: Path) -> None:
    out = tmp_path / "deep" / "out"
    with staged_output(out, name="a") as folder:
        write(folder, "new")
        assert [f for f in out.iterdir() if not f.name.startswith(".")] == []
    assert contents(out) == {"a.src": "new", "a.dat": "new", "a.json": "new"}


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, SystemExit])
def test_nothing_is_left_when_the_block_fails(tmp_path: Path, error: type[BaseException]) -> None:
    out = tmp_path / "deep" / "out"
    with pytest.raises(error), staged_output(out) as folder:
        write(folder, "half")
        raise error
    assert list(tmp_path.iterdir()) == []


def test_the_older_program_stays_when_the_block_fails(tmp_path: Path) -> None:
    write(tmp_path, "old")
    with pytest.raises(ValueError), staged_output(tmp_path, name="a") as folder:
        write(folder, "half")
        raise ValueError
    assert contents(tmp_path) == {"a.src": "old", "a.dat": "old", "a.json": "old"}


@pytest.mark.parametrize("fail_at", range(6))
def test_the_older_program_comes_back_when_moving_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fail_at: int
) -> None:
    """Three files are moved away and three moved in; whichever of the six breaks, the old state returns."""
    write(tmp_path, "old")
    real, calls = os.rename, 0

    def breaking(source: Path, target: Path) -> None:
        nonlocal calls
        calls += 1
        if calls == fail_at + 1:
            raise OSError(28, "No space left on device", str(target))
        real(source, target)

    monkeypatch.setattr(output.os, "rename", breaking)
    with pytest.raises(InputError, match="No space left"), staged_output(tmp_path, name="a") as folder:
        write(folder, "new")
    assert contents(tmp_path) == {"a.src": "old", "a.dat": "old", "a.json": "old"}


def test_the_main_program_leaves_first_and_comes_last(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names = ("a.src", "a_001.src", "a.dat")
    write(tmp_path, "old", names)
    seen: list[set[str]] = []
    real = os.rename

    def watched(source: Path, target: Path) -> None:
        real(source, target)
        state = {f: (tmp_path / f).read_text() for f in names if (tmp_path / f).exists()}
        if "a.src" in state:
            seen.append(set(state.values()))
            assert len(state) == 3, "the main program is there without its parts"

    monkeypatch.setattr(output.os, "rename", watched)
    with staged_output(tmp_path, name="a") as folder:
        write(folder, "new", names)
    assert seen == [{"new"}]


def test_parts_that_are_no_longer_made_go(tmp_path: Path) -> None:
    with staged_output(tmp_path, name="a") as folder:
        write(folder, "long", ("a.src", "a_001.src", "a_002.src"))
        (folder / "a.json").write_text(json.dumps({"files": ["a.src", "a_001.src", "a_002.src", "a.json"]}))
    with staged_output(tmp_path, name="a") as folder:
        write(folder, "short", ("a.src", "a.json"))
    assert contents(tmp_path) == {"a.src": "short", "a.json": "short"}


@pytest.mark.parametrize("part", ["b_001.src", "B_001.SRC"])
def test_a_part_of_another_program_is_not_replaced(tmp_path: Path, part: str) -> None:
    """Else the other program calls this one's motions in its middle: `b` is long, and was cut into b_001 and so on."""
    with staged_output(tmp_path, name="b") as folder:
        write(folder, "long", ("b.src", part))
        (folder / "b.json").write_text(json.dumps({"files": ["b.src", part]}))
    with (
        pytest.raises(InputError, match=f"{part} there is a file of program b"),
        staged_output(tmp_path, name="b_001") as folder,
    ):
        write(folder, "other", ("b_001.src", "b_001.dat", "b_001.json"))
    assert {name: text for name, text in contents(tmp_path).items() if name != "b.json"} == {
        "b.src": "long",
        part: "long",
    }


def test_one_name_of_two_cl_files_is_asked_for(tmp_path: Path) -> None:
    (tmp_path / "bracket_left_side_roughi.json").write_text(
        json.dumps({"manifest": {"cl_file": {"bracket_left_side_roughing_10.nc": "0"}}})
    )
    demand_own_name(tmp_path, "bracket_left_side_roughi", Path("bracket_left_side_roughing_10.apt"))  # output once more
    with pytest.raises(InputError, match="comes to the same name"):
        demand_own_name(tmp_path, "bracket_left_side_roughi", Path("bracket_left_side_roughing_20.nc"))


def test_data_of_nobody_s_are_not_taken_for_a_part_s(tmp_path: Path) -> None:
    (tmp_path / "B_001.dat").write_text("of long ago")
    with (
        pytest.raises(InputError, match=r"B_001\.dat there would be taken"),
        staged_output(tmp_path, name="b") as folder,
    ):
        write(folder, "new", ("b.src", "b.dat", "b_001.src"))
    assert contents(tmp_path) == {"B_001.dat": "of long ago"}


def test_a_hostile_list_removes_nothing_else(tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (tmp_path / "a_001.src").write_text("mine")
    for name in ("ab.src", "notes.txt", "a.txt", "b_001.src", "ax_001.src", "a_001.py"):
        (out / name).write_text("mine")
    listed = ["../a_001.src", "ab.src", "notes.txt", "a.txt", "b_001.src", "ax_001.src", "a_001.py", ".", "", 7, None]
    (out / "a.json").write_text(json.dumps({"files": listed}))
    with staged_output(out, name="a") as folder:
        write(folder, "new")
    assert (tmp_path / "a_001.src").read_text() == "mine"
    assert [f for f in contents(out).values()].count("mine") == 6


@pytest.mark.parametrize("text", ["", "[]", '{"files": 3}', '{"files": "a_001.src"}', "\xff", "[" * 100_000])
def test_an_older_json_that_is_not_ours_is_no_obstacle(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.json").write_text(text, encoding="latin-1")
    with staged_output(tmp_path, name="a") as folder:
        write(folder, "new")
    assert set(contents(tmp_path).values()) == {"new"}


def test_a_file_in_the_folders_place(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("mine")
    with pytest.raises(InputError, match="is a file"), staged_output(tmp_path / "out"):
        pytest.fail("the block ran")
    with pytest.raises(InputError, match="can't be made"), staged_output(tmp_path / "out" / "below"):
        pytest.fail("the block ran")
    assert (tmp_path / "out").read_text() == "mine"


def test_a_read_only_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Root may write anywhere, so the refusal is made here."""

    def refused(*args: object, **kwargs: object) -> str:
        raise PermissionError(13, "Permission denied", str(tmp_path))

    monkeypatch.setattr(output.tempfile, "mkdtemp", refused)
    out = tmp_path / "new"
    with pytest.raises(InputError, match=r"Permission denied.*check"), staged_output(out):
        pytest.fail("the block ran")
    assert not out.exists()


def test_a_folder_that_vanishes_while_it_is_written(tmp_path: Path) -> None:
    import shutil

    out = tmp_path / "out"
    with pytest.raises(InputError, match="vanished"), staged_output(out) as folder:
        shutil.rmtree(out)
        write(folder, "late")
    assert not out.exists()
    with pytest.raises(InputError, match="vanished"), staged_output(out) as folder:
        write(folder, "early")
        shutil.rmtree(out)


def test_an_error_about_another_file_stays_itself(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError), staged_output(tmp_path / "out"):
        (tmp_path / "missing").read_text()


def test_somebody_elses_file_in_a_new_folder_stays(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with pytest.raises(ValueError), staged_output(out):
        (out / "mine.txt").write_text("mine")
        raise ValueError
    assert contents(out) == {"mine.txt": "mine"}


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_killed_in_the_middle(tmp_path: Path, how: signal.Signals) -> None:
    out = tmp_path / "out"
    program = (
        "import pathlib, sys, time\n"
        "from camrob.cli.console import terminable\n"
        "from camrob.jobs.files.output import staged_output\n"
        "with terminable(), staged_output(pathlib.Path(sys.argv[1])) as folder:\n"
        "    (folder / 'a.src').write_text('half')\n"
        "    print('ready', flush=True)\n"
        "    time.sleep(30)\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(
        [sys.executable, "-c", program, str(out)],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        env=environment,
    ) as process:
        assert process.stdout is not None and process.stdout.readline() == "ready\n"
        process.send_signal(how)
        assert process.wait() != 0  # left alone, it would end well after half a minute
    assert not out.exists()


@pytest.mark.parametrize(
    "name",
    [
        "",
        ".",
        "..",
        "a/b",
        "a\\b",
        "/a",
        ".hidden",
        "-rf",
        "a\n",
        "a\0",
        "con",
        "NUL.src",
        "a.",
        "a ",
        "a:b",
        "a" * 300,
        "a\x1b[",
    ],
)
def test_names_that_are_no_file_names(name: str) -> None:
    with pytest.raises(InputError) as error:
        check_file_name(name)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("name", ["a", "impeller_2", "Blatt-7.src", "a.path.npz", "console"])
def test_names_that_are_good(name: str) -> None:
    assert check_file_name(name) == name
