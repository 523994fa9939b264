"""What is compiled, and how often: each kernel once a kind of arguments, its parts once, and nobody waits without a word."""

from __future__ import annotations

import gc
import inspect
import json
import os
import subprocess
import sys
from collections import Counter
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from camrob import machine_code
from camrob.cell.read_cell import read_cell
from camrob.cli.app import VERBS
from camrob.cli.console import COMPILING, perform
from camrob.compiled import kernel, part
from camrob.compiling import report_compile, reporting_compiles
from camrob.frozen import locked
from camrob.kinematics.kernels import chain_arrays
from camrob.machine_code import library_name, source_state
from camrob.warm import ahead as warm
from camrob.warm.signatures import known_kernels, numba_type, spelled

ROOT = Path(__file__).resolve().parents[2]
POST_KERNELS = 28  # that posting the sample calls at most: 25 today, and room for three

COUNT_CALLED = """
import json, sys
from pathlib import Path
import numba
import camrob
from camrob.compiled import Kernel
from camrob.warm.signatures import spelled
asked, run = {}, Kernel.__call__
def noted(kernel, *arguments):
    way = [spelled(numba.typeof(argument)) for argument in arguments]
    ways = asked.setdefault(kernel.name, [])
    if way not in ways:
        ways.append(way)
    return run(kernel, *arguments)
Kernel.__call__ = noted
camrob.post(Path("toolpaths/engraving/engraving.cls"), cell=Path("cells/kr15_track_table"), out=Path(sys.argv[1]))
print(json.dumps(asked))
"""

COUNT_COMPILED = """
import json
from numba.core import event
from camrob.warm.signatures import known_kernels
names = []
class Count(event.Listener):
    def on_start(self, happening):
        function = happening.data["dispatcher"].py_func
        names.append(f"{function.__module__}.{function.__qualname__}")
    def on_end(self, happening):
        pass
event.register("numba:compile", Count())
(known,) = (k for k in known_kernels() if k.kernel.endswith(":solve_arm_many"))
known.dispatcher().compile(known.types())
print(json.dumps(names))
"""


def _run(program: str, *arguments: str, **environment: str) -> object:
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    return json.loads(done.stdout.splitlines()[-1])


def test_a_post_calls_each_kernel_in_one_way_and_all_are_compiled_ahead(tmp_path: Path) -> None:
    asked = _run(COUNT_CALLED, str(tmp_path / "out"))
    assert 10 < len(asked) <= POST_KERNELS
    assert {name: len(ways) for name, ways in asked.items()} == dict.fromkeys(asked, 1)
    known = {(k.kernel, json.dumps(k.arguments)) for k in known_kernels()}
    assert {(name, json.dumps(ways[0])) for name, ways in asked.items()} <= known


@pytest.mark.slow
def test_a_kernels_parts_are_compiled_once_each(tmp_path: Path) -> None:
    """An integer that is written into a call was a type of its own: a part was compiled as often as it was called."""
    counts = Counter(_run(COUNT_COMPILED, NUMBA_CACHE_DIR=str(tmp_path)))
    ours = {name: count for name, count in counts.items() if name.startswith("camrob.")}
    assert len(ours) > 8 and "camrob.kinematics.spherical_wrist._wrist" in ours
    # views of rows and arrays of their own are two layouts: no part of this kernel needs more
    assert max(ours.values()) <= 3, ours


def test_known_kernels_are_kernels_with_arguments_that_are_written_and_read_alike() -> None:
    kernels = known_kernels()
    assert len({(k.kernel, json.dumps(k.arguments)) for k in kernels}) == len(kernels) > 30
    for known in kernels:
        assert hasattr(known.dispatcher(), "py_func"), known.kernel
        assert list(map(spelled, known.types())) == list(known.arguments), known.kernel
        names = inspect.signature(known.dispatcher().py_func).parameters
        assert len(names) == len(known.arguments), known.kernel


def test_a_type_without_a_spelling_is_refused() -> None:
    with pytest.raises(TypeError, match="no spelling for"):
        spelled(object())
    assert numba_type("float64") is numba_type(spelled(numba_type("float64")))


@part
def _double(x: float) -> float:
    return 2.0 * x


@kernel(cache=False)
def _quadruple(x: float) -> float:
    return _double(_double(x))


def test_a_kernel_that_compiles_is_reported_of_once_and_the_collector_rests_meanwhile() -> None:
    calls: list[str] = []
    collects: list[bool] = []
    with reporting_compiles(calls.append), reporting_compiles(lambda kernel: collects.append(gc.isenabled())):
        assert _quadruple(1.5) == 6.0 == _double(3.0)
        assert _quadruple(2.5) == 10.0
    assert calls == ["quadruple"] and collects == [False] and gc.isenabled()
    report_compile("nobody listens")
    assert calls == ["quadruple"]


def _job(progress) -> SimpleNamespace:
    report_compile("first")
    report_compile("second")
    return SimpleNamespace(summary=SimpleNamespace(to_json=dict))


@pytest.mark.parametrize(("quiet", "said"), [(False, f"camrob: {COMPILING}\n"), (True, "")])
def test_a_verb_says_once_that_it_compiles(quiet: bool, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert perform(_job, as_json=not quiet, quiet=quiet, render=str) == 0
    assert capsys.readouterr().err == said


def test_every_verb_runs_where_compiling_is_reported_of() -> None:
    assert [verb.__name__ for verb in VERBS if "perform(" not in inspect.getsource(verb)] == []


def test_what_is_ready_is_not_looked_for_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    """Without a library: only in a cache of camrob's own, one for each state of the sources, and for the same kernels."""
    tried = []
    monkeypatch.setattr(warm, "_all_done", tried.append)
    monkeypatch.setattr(warm, "ready_library", lambda: None)
    monkeypatch.setattr(warm, "home", lambda: None)
    for folder, again in (("kernels-1", False), ("elsewhere", True)):
        (tmp_path / folder).mkdir()
        monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / folder))
        tried.clear()
        assert warm.main() == 0 and len(tried) == 1
        assert warm.main() == 0 and (len(tried) == 2) is again
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kernels-1"))
    monkeypatch.setattr(warm, "version", lambda _name: "another")
    assert warm.main() == 0 and len(tried) == 3
    assert capsys.readouterr().err.count("camrob: the kernels are ready\n") == 1
    monkeypatch.setattr(warm, "ready_library", lambda: tmp_path)
    assert warm.main() == 0 and len(tried) == 3


def test_without_a_compiler_of_the_platform_numbas_cache_will_do(
    monkeypatch: pytest.MonkeyPatch, capsys, tmp_path
) -> None:
    tried: list[str] = []

    def done(tasks: list) -> list:
        tried.append(tasks[-1].function.__name__)
        if tried[-1] == "compile_object":
            raise RuntimeError("Attempted to compile AOT function\nwithout a compiler")
        return []

    monkeypatch.setattr(warm, "_all_done", done)
    monkeypatch.setattr(warm, "ready_library", lambda: None)
    monkeypatch.setattr(warm, "home", lambda: tmp_path)
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    assert warm.main() == 0 and tried == ["compile_object", "compile_kernel"]
    assert "no library of kernels can be made here (Attempted to compile" in capsys.readouterr().err


MADE = """
import json, sys
from pathlib import Path
from camrob import machine_code
machine_code._homes = lambda: (Path(sys.argv[1]),)
from camrob.warm import ahead
small = [k for k in ahead.known_kernels() if k.kernel.endswith((":_dahl", ":_lag"))]
ahead.known_kernels = lambda: small
machine_code.ready_library()
status = ahead.main()
found = [machine_code.entries_of(k.kernel) for k in small]
print(json.dumps([status, all(found), len(list(Path(sys.argv[1]).iterdir()))]))
"""


@pytest.mark.slow
def test_a_library_is_made_and_its_progress_reported(tmp_path: Path) -> None:
    (tmp_path / "kernels-0123456789abcdef-any.other.so").write_bytes(b"")
    (tmp_path / library_name().replace(source_state(), "0123456789abcdef")).write_bytes(b"")
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", MADE, str(tmp_path)],
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    assert json.loads(done.stdout) == [0, True, 2]  # another processor's is left alone, another state's is not
    lines = done.stderr.splitlines()
    assert lines[0].startswith("camrob: compiling kernels, once on this machine: 3 parts on ")
    assert lines[-2].startswith("camrob: part 3 of 3") and lines[-1].startswith("camrob: 2 kernels are ready (")


ALONE = """
import json, sys
from pathlib import Path
import camrob
done = camrob.post(Path("toolpaths/engraving/engraving.cls"), cell=Path("cells/kr15_track_table"), out=Path(sys.argv[1]))
print(json.dumps("numba" in sys.modules))
"""


@pytest.fixture
def library() -> Path:
    """The library of today's sources, as `.ci/install` and `.ci/run` make it."""
    found = machine_code.ready_library()
    if found is None:
        pytest.skip("no kernels compiled ahead for this state of the sources: python -m camrob.warm makes them")
    return found


def test_with_kernels_compiled_ahead_a_post_needs_no_numba(library: Path, tmp_path: Path) -> None:
    assert _run(ALONE, str(tmp_path / "out")) is False


@pytest.mark.slow
def test_kernels_compiled_ahead_write_what_numba_writes(library: Path, tmp_path: Path) -> None:
    ways: dict[str, dict[str, str]] = {"ahead": {}, "numba": {"CAMROB_JIT": "1"}}
    assert [_run(ALONE, str(tmp_path / way), **more) for way, more in ways.items()] == [False, True]
    for name in ("engraving.src", "engraving.dat"):
        assert (tmp_path / "ahead" / name).read_bytes() == (tmp_path / "numba" / name).read_bytes()


def test_all_known_kernels_are_in_the_library(library: Path) -> None:
    wanted = Counter(k.kernel for k in known_kernels())
    assert {kernel: len(machine_code.entries_of(kernel)) for kernel in wanted} == wanted


def test_machine_code_is_only_given_what_it_was_made_for(library: Path) -> None:
    """It checks nothing itself: other arguments go to Numba, which compiles for them or refuses."""
    (entry,) = machine_code.entries_of("camrob.kinematics.kernels:inverse_kf_many")
    cell = read_cell(ROOT / "cells/kr15_track_table")
    chain, q = chain_arrays(cell), np.zeros((3, len(cell)))
    assert entry.takes((chain, q)) and entry.call(chain, q).shape == (3,)
    frozen = locked(q.copy(), name="q")
    for other in (
        q[::2, ::-1],
        q.T,
        q.astype(np.float32),
        q.astype(int),
        q[0],
        frozen,
        q.view(np.matrix),
        q.tolist(),
        None,
    ):
        assert not entry.takes((chain, other))
    assert not entry.takes((chain,)) and not entry.takes((chain, q, 1.0)) and not entry.takes((tuple(chain), q))
    for place, other in ((0, q), (4, 3.0), (6, 1), (7, 1)):  # an array with an axis less, and scalars of other kinds
        assert not entry.takes((chain._replace(**{chain._fields[place]: other[0] if place == 0 else other}), q))


def test_what_is_left_is_reported_by_the_work_that_is_done() -> None:
    assert warm.left(25.0, 100.0, 10.0) == ", about 30 s left"
    assert warm.left(0.0, 100.0, 10.0) == ""
