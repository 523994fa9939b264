"""Readers under fire: what each is fed, and what must hold whatever the bytes."""

from __future__ import annotations

import ast
import os
import re
import resource
import signal
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from io import BytesIO
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

from camrob.calibration.calibration import Calibration, ErrorSize, Held, robot_digest
from camrob.calibration.calibration_file import calibration_text, read_calibration
from camrob.calibration.measurements import measurements_of
from camrob.calibration.parameters import ParameterSet
from camrob.calibration.terms import parameter_of
from camrob.cell.cell import Cell
from camrob.cell.read_cell import read_cell
from camrob.cell.read_setup import read_setup
from camrob.errors import CamrobError
from camrob.jobs.batching.jobs_file import read_jobs
from camrob.jobs.derivatives import coordinates_of
from camrob.jobs.files.solved_path import read_solution
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.measurement.read_log import read_log
from camrob.redundancy.fuzzy.fis import read_fis
from camrob.toolpath.read import read_toolpath

__all__ = [
    "CELL",
    "FINDINGS",
    "LONGEST_MESSAGE",
    "MOST_BYTES",
    "MOST_SECONDS",
    "READERS",
    "FlawError",
    "Reader",
    "check_message",
    "fire",
    "guarded",
    "peak_memory",
]

ROOT = Path(__file__).resolve().parents[1]
CELL = ROOT / "cells" / "kr15_track_table"
FINDINGS = ROOT / "tests" / "data" / "findings"
SEPARATOR = b"\n=====8<=====\n"
"""Between the files of one input, for readers that read several."""

MOST_SECONDS = 20.0
"""s of processor time an input, after which it hangs; not of the clock, so that a busy machine finds nothing. How quick a
reader is, bench/fuzz.py measures."""
MOST_BYTES = 1 << 30
LONGEST_MESSAGE = 1500


class FlawError(AssertionError):
    """A reader broke a law."""


class TooSlowError(BaseException):
    """Raised into a reader whose time is up; no reader may catch it."""


@dataclass(frozen=True)
class Reader:
    """`files` are the names that the parts of an input get; `read` reads the first of them in a folder and looks at it."""

    name: str
    files: tuple[str, ...]
    read: Callable[[Path], Any]
    seeds: Callable[[], list[bytes]]
    beside: tuple[str, ...] = ()
    """Files of the sample folder `toolpaths/engraving` that lie beside."""


@contextmanager
def guarded(seconds: float = MOST_SECONDS, memory: int = MOST_BYTES) -> Iterator[None]:
    """Raise Flaw where the block takes more processor time than that, or more memory on top of the most so far."""

    def stop(signum: int, frame: FrameType | None) -> None:
        raise TooSlowError

    before = signal.signal(signal.SIGPROF, stop)
    highest, start = peak_memory(), time.process_time()
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    except TooSlowError:
        raise FlawError(f"takes more than {seconds:g} s") from None
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
    if (taken := time.process_time() - start) > seconds:
        raise FlawError(f"takes {taken:.1f} s")
    if peak_memory() - highest > memory:
        raise FlawError(f"takes {(peak_memory() - highest) >> 20} MiB")


def peak_memory() -> int:
    """Most bytes that this process ever held."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def fire(reader: Reader, data: bytes, folder: Path, seconds: float = MOST_SECONDS) -> str:
    """Let a reader read `data` in an empty folder; "" where it did, else the message with which it refused.

    Raises Flaw where it refuses with anything but a CamrobError of one printable line that names the file, warns on
    stderr, hangs, or leaves files behind.
    """
    parts = data.split(SEPARATOR, len(reader.files) - 1)
    for name, part in zip(reader.files, parts, strict=False):
        (folder / name).write_bytes(part)
    for name in reader.beside:
        if not (folder / name).exists():
            (folder / name).write_bytes((ROOT / "toolpaths" / "engraving" / name).read_bytes())
    before = sorted(os.listdir(folder))
    message = ""
    try:
        with guarded(seconds), warnings.catch_warnings():
            warnings.simplefilter("error")
            reader.read(folder / reader.files[0])
    except CamrobError as error:
        message = str(error)
        check_message(message, reader.files)
    except (FlawError, KeyboardInterrupt):
        raise
    except BaseException as error:
        raise FlawError(f"{type(error).__name__}: {str(error)[:300]}") from error
    finally:
        after = sorted(os.listdir(folder))
        for name in after:
            if name in reader.files:
                os.unlink(folder / name)
    if after != before:
        raise FlawError(f"left {set(after) ^ set(before)} behind")
    return message


def check_message(message: str, files: tuple[str, ...]) -> None:
    """Raise FlawError unless a refusal is one printable line of a readable length that names one of `files`, if any."""
    if not message or not message.isprintable():
        raise FlawError(f"the message is no printable line: {message[:200]!r}")
    if len(message) > LONGEST_MESSAGE:
        raise FlawError(f"the message has {len(message)} characters: {message[:100]!r}")
    if files and not any(name in message for name in files):
        raise FlawError(f"the message names no file: {message[:200]!r}")


@cache
def cell() -> Cell:
    """The cell for readers that need one."""
    return read_cell(CELL)


def _toolpath(dialect: str | None) -> Callable[[Path], Any]:
    def read(path: Path) -> None:
        toolpath = read_toolpath(path, dialect=dialect)
        for region in toolpath.regions:
            if not np.all(np.isfinite(region.position)):
                raise FlawError("a position is not finite")
            if np.any(np.abs(np.linalg.norm(region.axis, axis=1) - 1.0) > 1e-9):
                raise FlawError("a tool axis has not length 1")
            if not all(text.isprintable() for text in (region.name, toolpath.source)):
                raise FlawError("a name is not printable")
        for finding in toolpath.findings:
            if not finding.text.isprintable() or len(finding.text) > LONGEST_MESSAGE:
                raise FlawError(f"a finding is no line: {finding.text[:200]!r}")

    return read


def _krl(path: Path) -> None:
    for finding in read_krl(path).findings:
        if not finding.text.isprintable() or len(finding.text) > LONGEST_MESSAGE:
            raise FlawError(f"a finding is no line: {finding.text[:200]!r}")


def _cell(path: Path) -> None:
    read = read_cell(path)
    if not np.all(np.isfinite(read.q_home)):
        raise FlawError("HOME is not finite")


def _fis(path: Path) -> None:
    engine = read_fis(path)
    corners = np.array([[v.lower for v in engine.inputs], [v.upper for v in engine.inputs]])
    if not np.all(np.isfinite(engine.evaluate_grid(corners))):
        raise FlawError("a weight is not finite")


def _setup(path: Path) -> None:
    setup = read_setup(path, cell())
    if not np.all(np.isfinite(setup.base_T_part)):
        raise FlawError("the part's place is not finite")


def _log(path: Path) -> None:
    log = read_log(path)
    if not all(text.isprintable() for text in (log.info.program, log.info.instrument, log.info.note)):
        raise FlawError("a text of the log is no line")
    if not np.all(np.isfinite(measurements_of(log, cell()).q)):
        raise FlawError("a posture is not finite")


def _calibration(path: Path) -> None:
    if not np.all(np.isfinite([p.value for p in read_calibration(path, cell()).parameters.items_])):
        raise FlawError("a parameter is not finite")


def _solution(path: Path) -> None:
    q, _ = read_solution(path, cell())
    if not np.all(np.isfinite(q)):
        raise FlawError("a posture is not finite")
    coordinates_of(path, cell())


def _texts(pattern: str, holds: str, shortest: int = 20) -> list[bytes]:
    """The texts in our own tests that look like such files."""
    found = set()
    for file in sorted((ROOT / "tests").glob(pattern)):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and isinstance(node.value, str | bytes):
                text = node.value.encode("utf-8", "replace") if isinstance(node.value, str) else node.value
                if len(text) >= shortest and b"\n" in text and re.search(holds.encode(), text):
                    found.add(text[:4000])
    return sorted(found)


def _kept(reader: str) -> list[bytes]:
    """Samples made for the purpose, with much of what the format has."""
    return [p.read_bytes() for p in sorted((ROOT / "tests" / "data" / "seeds" / reader).iterdir())]


def _head(path: Path, lines: int) -> bytes:
    return b"\n".join(path.read_bytes().split(b"\n")[:lines])


def _cl_seeds() -> list[bytes]:
    samples = [_head(p, 45) + b"\nEND-OF-PATH\n" for p in sorted(ROOT.glob("toolpaths/*/*.cls"))]
    texts = _texts("toolpath/test_cl_*.py", r"GOTO\s*/|FEDRAT|CYCLE|CIRCLE|MSYS|UNITS")
    head = b"TOOL PATH/OP,TOOL,T1\nTLDATA/MILL,10,0,50,0,0\nRAPID\nGOTO/0,0,50,0,0,1\nFEDRAT/MMPM,500\nGOTO/0,0,0\nGOTO/1,0,0\n"
    return samples + texts + [head + text + b"\nGOTO/9,9,9\nEND-OF-PATH\n" for text in texts]


def _gcode_seeds() -> list[bytes]:
    texts = _texts("toolpath/test_gcode.py", r"[GM]\d+")
    head = b"G21 G90 G17 G94\nM428\nG0 X0 Y0 Z10 A0 C0\nF600\nG1 X1 Y1 Z1\n"
    return [*texts, *(head + text + b"\nM30\n" for text in texts), *_kept("gcode")]


def _krl_seeds() -> list[bytes]:
    golden = ROOT / "tests" / "golden" / "Fluegel_3"
    own = [golden.with_suffix(".src").read_bytes() + SEPARATOR + golden.with_suffix(".dat").read_bytes()]
    engraving = ROOT / "toolpaths" / "engraving" / "golden" / "engraving"
    own.append(
        _head(engraving.with_suffix(".src"), 60) + b"\nEND\n" + SEPARATOR + engraving.with_suffix(".dat").read_bytes()
    )
    texts = _texts("languages/test_krl_reader.py", r"DEF |LIN|PTP|FOR|ENDIF", 10)
    head = b"DEF part ( )\n$VEL.CP = 0.01\n$BASE = {X 1,Y 2,Z 3,A 0,B 0,C 0}\n$TOOL = {X 0,Y 0,Z 100,A 0,B 0,C 0}\n"
    bodies = [head + text + b"\nLIN {X 1,Y 2,Z 3,A 4,B 5,C 6,E1 7,E2 8}\nEND\n" for text in texts if b"DEF" not in text]
    return [*own, *_kept("krl"), *texts, *bodies]


def _cell_seeds() -> list[bytes]:
    return [_bare(folder.read_bytes()) for folder in sorted(ROOT.glob("cells/*/cell.toml"))]


def _bare(text: bytes) -> bytes:
    """A TOML file without comments and without more than two bodies, to be quick."""
    text = re.sub(rb"^\s*#.*\n|\s+#[^\"\n]*$", b"", text, flags=re.M)
    head, *shapes = re.split(rb"^(?=\[\[shape\]\])", text, flags=re.M)
    return head + b"".join(shapes[:2])


def _fis_seeds() -> list[bytes]:
    return [p.read_bytes() for p in sorted(CELL.glob("*.fis"))]


def _setup_seeds() -> list[bytes]:
    own = [p.read_bytes().replace(b"part.stl", b"stock.stl") for p in sorted(ROOT.glob("toolpaths/*/setup.toml"))]
    return [*own, *_kept("setup"), *_texts("cell/test_setup.py", r"part_in_base")]


def _log_seeds() -> list[bytes]:
    return [
        *_kept("log"),
        *(text + SEPARATOR + _kept("log")[0].split(SEPARATOR)[1] for text in _texts("measurement/test_log.py", r"^t,")),
    ]


def _calibration_seeds() -> list[bytes]:
    """One of everything, and one with a single parameter."""
    size = ErrorSize(9, 1e-4, 2e-4, 3e-4, 4e-4, 1e-5, 2e-5)
    chosen = ["A2.zero", "A3.zero", "tool.x"]
    found = ParameterSet.of(parameter_of(cell(), name) for name in chosen)
    full = Calibration(
        cell().name,
        robot_digest(cell()),
        found.with_values(np.full(3, 1e-4), np.full(3, 1e-5)),
        ("tool.x",),
        (Held("A1.zero", "merged", ("base.c",)),),
        {"nominal/fitted": size, "calibrated/withheld": size},
        (("A2.zero", "A3.zero", 0.5),),
        12.0,
        (1.0, 2.0, 3.0, 4.0, 5.0),
        1e-5,
        1e-5,
        (("log.csv", "0" * 64),),
        9,
        1,
        2,
        True,
        ("a warning",),
    )
    return [calibration_text(full).encode()]


def _jobs_seeds() -> list[bytes]:
    return [*_texts("jobs/test_batch.py", r"\[\[job\]\]"), *_kept("jobs")]


def _solution_seeds() -> list[bytes]:
    machine, seeds = cell(), []
    q = np.linspace(0.0, 0.1, 9)[:, None] + np.zeros(len(machine))
    for save in (np.savez, np.savez_compressed):
        file = BytesIO()
        save(file, q=q, line=np.arange(9), axes=np.array(machine.names))
        seeds.append(file.getvalue())
    return seeds


def _parquet_seeds() -> list[bytes]:
    from camrob.measurement.write_log import write_log

    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "log.csv"
        source.write_bytes(_kept("log")[0].split(SEPARATOR)[0])
        write_log(read_log(source), Path(folder) / "log.parquet")
        return [(Path(folder) / "log.parquet").read_bytes()]


READERS = {
    reader.name: reader
    for reader in (
        Reader("cl", ("part.cls",), _toolpath(None), _cl_seeds),
        Reader("gcode", ("part.nc",), _toolpath("gcode"), _gcode_seeds),
        Reader("krl", ("part.src", "part.dat", "part_1.src"), _krl, _krl_seeds),
        Reader("cell", ("cell.toml",), _cell, _cell_seeds),
        Reader("fis", ("weights.fis",), _fis, _fis_seeds),
        Reader("setup", ("setup.toml",), _setup, _setup_seeds, ("stock.stl",)),
        Reader("log", ("log.csv", "log.toml"), _log, _log_seeds),
        Reader("parquet", ("log.parquet",), _log, _parquet_seeds),
        Reader("calibration", ("calibration.toml",), _calibration, _calibration_seeds),
        Reader("jobs", ("JOBS.toml",), read_jobs, _jobs_seeds),
        Reader("npz", ("part.path.npz",), _solution, _solution_seeds),
    )
}
"""All that read files of others."""
