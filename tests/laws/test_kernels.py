"""What is compiled, and how often: each kernel for one kind of arguments, its parts once, and nobody waits without a word."""

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

import pytest

from camrob.cli.app import VERBS
from camrob.cli.console import COMPILING, perform
from camrob.compiled import kernel, part
from camrob.compiling import report_compile, reporting_compiles
from camrob.warm import ahead as warm
from camrob.warm.signatures import Known, known_kernels, numba_type, spelled

ROOT = Path(__file__).resolve().parents[2]
POST_KERNELS = 22  # that posting the sample asks for at most: 19, and room for three

COUNT_LOADED = """
import json, sys
from pathlib import Path
from numba.core.dispatcher import Dispatcher
import camrob
from camrob.warm.signatures import spelled
camrob.post(Path("toolpaths/engraving/engraving.cls"), cell=Path("cells/kr15_track_table"), out=Path(sys.argv[1]))
found = {}
for name, module in list(sys.modules.items()):
    for attribute, value in list(vars(module).items()) if name.startswith("camrob.") else ():
        if isinstance(value, Dispatcher) and value.py_func.__module__ == name:
            found[f"{name}:{attribute}"] = [list(map(spelled, arguments)) for arguments in value.overloads]
print(json.dumps(found))
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


def test_a_post_asks_for_each_kernel_in_one_way_and_all_are_compiled_ahead(tmp_path: Path) -> None:
    asked = {name: ways for name, ways in _run(COUNT_LOADED, str(tmp_path / "out")).items() if ways}
    assert 10 < len(asked) <= POST_KERNELS
    assert {name: len(ways) for name, ways in asked.items()} == dict.fromkeys(asked, 1)
    known = {k.kernel: list(k.arguments) for k in known_kernels()}
    assert {name: ways[0] for name, ways in asked.items()} == {name: known.get(name) for name in asked}


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
    assert len({k.kernel for k in kernels}) == len(kernels) > 30
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
    """Only in a cache of camrob's own, which is one for each state of the sources, and for the same kernels."""
    tried = []
    monkeypatch.setattr(
        warm, "ProcessPoolExecutor", lambda *_args, **_more: tried.append(1) or SimpleNamespace(shutdown=int)
    )
    monkeypatch.setattr(warm, "as_completed", lambda _running: ())
    monkeypatch.setattr(warm, "known_kernels", tuple)
    for folder, again in (("kernels-1", False), ("elsewhere", True)):
        (tmp_path / folder).mkdir()
        monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / folder))
        tried.clear()
        assert warm.main() == 0 and tried == [1]
        assert warm.main() == 0 and (tried == [1, 1]) is again
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kernels-1"))
    monkeypatch.setattr(warm, "version", lambda _name: "another")
    assert warm.main() == 0 and tried == [1, 1, 1]
    assert capsys.readouterr().err.count("camrob: the kernels are ready\n") == 1


@pytest.mark.slow
def test_warming_says_how_far_it_is(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    small = [k for k in known_kernels() if k.seconds < 2.0][:2]
    monkeypatch.setattr(warm, "known_kernels", lambda: small)
    assert warm.main() == 0
    lines = capsys.readouterr().err.splitlines()
    assert lines[0].startswith("camrob: compiling kernels, once on this machine: 2 on ")
    assert lines[-2].startswith("camrob: kernel 2 of 2") and lines[-1].startswith("camrob: 2 kernels are ready (")
    assert not warm.compile_kernel(Known(small[0].kernel, 1.0, small[0].arguments))


def test_what_is_left_is_reported_by_the_work_that_is_done() -> None:
    assert warm.left(25.0, 100.0, 10.0) == ", about 30 s left"
    assert warm.left(0.0, 100.0, 10.0) == ""
