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

from camrob.calibrate.calibration import Calibration, ErrorSize, Held, robot_digest
from camrob.calibrate.calibration_file import calibration_text, read_calibration
from camrob.calibrate.measurements import measurements_of
from camrob.calibrate.parameters import ParameterSet
from camrob.calibrate.terms import parameter_of
from camrob.cell.cell import Cell
from camrob.cell.read_cell import read_cell
from camrob.cell.read_setup import read_setup
from camrob.errors import CamrobError
from camrob.jobs.batch_file import read_jobs
from camrob.jobs.derivatives import coordinates_of
from camrob.jobs.solution_program import read_solution
from camrob.measure.read_log import read_log
from camrob.post.krl_reader import read_krl
from camrob.resolve.fis import read_fis
from camrob.toolpath.read import read_toolpath

__all__ = ["FINDINGS", "LONGEST_MESSAGE", "MOST_BYTES", "MOST_SECONDS", "READERS", "Flaw", "Reader", "fire", "guarded"]

ROOT = Path(__file__).resolve().parents[1]
CELL = ROOT / "cells" / "kr15_track_table"
FINDINGS = ROOT / "tests" / "data" / "findings"
SEPARATOR = b"\n=====8<=====\n"
"""Between the files of one input, for readers that read several."""

MOST_SECONDS = 2.0
"""s of processor time an input; not of the clock, so that a busy machine finds nothing."""
MOST_BYTES = 1 << 30
LONGEST_MESSAGE = 1500


class Flaw(AssertionError):
    """A reader broke a law."""


class TooSlow(BaseException):
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
def guarded(seconds: float = MOST_SECONDS) -> Iterator[None]:
    """Raise Flaw where the block takes more processor time than that, or a GiB more memory than there was before."""

    def stop(signum: int, frame: FrameType | None) -> None:
        raise TooSlow

    before = signal.signal(signal.SIGPROF, stop)
    highest, start = _highest(), time.process_time()
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    except TooSlow:
        raise Flaw(f"takes more than {seconds:g} s") from None
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
    if (taken := time.process_time() - start) > seconds:
        raise Flaw(f"takes {taken:.1f} s")
    if _highest() - highest > MOST_BYTES:
        raise Flaw(f"takes {(_highest() - highest) >> 20} MiB")


def _highest() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def fire(reader: Reader, data: bytes, folder: Path) -> str:
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
        with guarded(), warnings.catch_warnings():
            warnings.simplefilter("error")
            reader.read(folder / reader.files[0])
    except CamrobError as error:
        message = str(error)
        _check_message(reader, message)
    except (Flaw, KeyboardInterrupt):
        raise
    except BaseException as error:
        raise Flaw(f"{type(error).__name__}: {str(error)[:300]}") from error
    finally:
        after = sorted(os.listdir(folder))
        for name in after:
            if name in reader.files:
                os.unlink(folder / name)
    if after != before:
        raise Flaw(f"left {set(after) ^ set(before)} behind")
    return message


def _check_message(reader: Reader, message: str) -> None:
    if not message or not message.isprintable():
        raise Flaw(f"the message is no printable line: {message[:200]!r}")
    if len(message) > LONGEST_MESSAGE:
        raise Flaw(f"the message has {len(message)} characters: {message[:100]!r}")
    if not any(name in message for name in reader.files):
        raise Flaw(f"the message names no file: {message[:200]!r}")


@cache
def cell() -> Cell:
    """The cell for readers that need one."""
    return read_cell(CELL)


def _toolpath(dialect: str | None) -> Callable[[Path], Any]:
    def read(path: Path) -> None:
        toolpath = read_toolpath(path, dialect=dialect)
        for region in toolpath.regions:
            if not np.all(np.isfinite(region.position)):
                raise Flaw("a position is not finite")
            if np.any(np.abs(np.linalg.norm(region.axis, axis=1) - 1.0) > 1e-9):
                raise Flaw("a tool axis has not length 1")
            if not all(text.isprintable() for text in (region.name, toolpath.source)):
                raise Flaw("a name is not printable")
        for finding in toolpath.findings:
            if not finding.text.isprintable() or len(finding.text) > LONGEST_MESSAGE:
                raise Flaw(f"a finding is no line: {finding.text[:200]!r}")

    return read


def _krl(path: Path) -> None:
    for finding in read_krl(path).findings:
        if not finding.text.isprintable() or len(finding.text) > LONGEST_MESSAGE:
            raise Flaw(f"a finding is no line: {finding.text[:200]!r}")


def _cell(path: Path) -> None:
    read = read_cell(path)
    if not np.all(np.isfinite(read.q_home)):
        raise Flaw("HOME is not finite")


def _fis(path: Path) -> None:
    engine = read_fis(path)
    corners = np.array([[v.lower for v in engine.inputs], [v.upper for v in engine.inputs]])
    if not np.all(np.isfinite(engine.evaluate_grid(corners))):
        raise Flaw("a weight is not finite")


def _setup(path: Path) -> None:
    setup = read_setup(path, cell())
    if not np.all(np.isfinite(setup.base_T_part)):
        raise Flaw("the part's place is not finite")


def _log(path: Path) -> None:
    log = read_log(path)
    if not all(text.isprintable() for text in (log.info.program, log.info.instrument, log.info.note)):
        raise Flaw("a text of the log is no line")
    if not np.all(np.isfinite(measurements_of(log, cell()).q)):
        raise Flaw("a posture is not finite")


def _calibration(path: Path) -> None:
    if not np.all(np.isfinite([p.value for p in read_calibration(path, cell()).parameters.items_])):
        raise Flaw("a parameter is not finite")


def _solution(path: Path) -> None:
    q, _ = read_solution(path, cell())
    if not np.all(np.isfinite(q)):
        raise Flaw("a posture is not finite")
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


def _head(path: Path, lines: int) -> bytes:
    return b"\n".join(path.read_bytes().split(b"\n")[:lines])


def _cl_seeds() -> list[bytes]:
    samples = [_head(p, 45) + b"\nEND-OF-PATH\n" for p in sorted(ROOT.glob("toolpaths/*/*.cls"))]
    texts = _texts("test_cl_*.py", r"GOTO\s*/|FEDRAT|CYCLE|CIRCLE|MSYS|UNITS")
    head = b"TOOL PATH/OP,TOOL,T1\nTLDATA/MILL,10,0,50,0,0\nRAPID\nGOTO/0,0,50,0,0,1\nFEDRAT/MMPM,500\nGOTO/0,0,0\nGOTO/1,0,0\n"
    return samples + texts + [head + text + b"\nGOTO/9,9,9\nEND-OF-PATH\n" for text in texts]


def _gcode_seeds() -> list[bytes]:
    texts = _texts("test_gcode.py", r"[GM]\d+")
    head = b"G21 G90 G17 G94\nM428\nG0 X0 Y0 Z10 A0 C0\nF600\nG1 X1 Y1 Z1\n"
    return [*texts, *(head + text + b"\nM30\n" for text in texts), *_GCODE]


_GCODE = [
    b"%\nO1\nN1 G21 G90 G17 G40 G80 G94 G54\nN2 T1 M6\nN3 S9000 M3\nN4 G43.4 H1\nN5 G0 X0 Y0 Z50 A0 C0\nN6 G1 Z-1 F300\n"
    b"N7 X10 Y5 A10 C30 (CUT)\nN8 G2 X20 Y5 I5 J0\nN9 G3 X20 Y5 R6\nN10 G93 X30 F20\nN11 G94 G0 Z50\nM5\nM30\n%\n",
    b"G20 G90\nT2 M6\nG68.2 X1 Y2 Z3 I10 J20 K30\nG53.1\nG0 X0 Y0 Z1\nG1 Z-.1 F10\nG2 X.5 I.25 Z-.2 P3\nG69\nM30\n",
    b"G21\nG0 X0 Y0 Z5\nG98 G81 X1 Y1 Z-2 R2 F100\nX2\nG83 X3 Z-5 R1 Q1 F50\nG73 X4 Z-5 R1 Q1 F50 K3\nG80\nM2\n",
    b"G21 G18 G91\nG0 X1 Z1\nG2 X2 Z0 I1 K0 F100\nG4 P1\nG52 X10\nG1 X1 F100\nG10 L2 P1 X0\nG28 Z0\nM98 P100\nM30\n",
]


def _krl_seeds() -> list[bytes]:
    golden = ROOT / "tests" / "golden" / "Fluegel_3"
    own = [golden.with_suffix(".src").read_bytes() + SEPARATOR + golden.with_suffix(".dat").read_bytes()]
    engraving = ROOT / "toolpaths" / "engraving" / "golden" / "engraving"
    own.append(
        _head(engraving.with_suffix(".src"), 60) + b"\nEND\n" + SEPARATOR + engraving.with_suffix(".dat").read_bytes()
    )
    texts = _texts("test_krl_reader.py", r"DEF |LIN|PTP|FOR|ENDIF", 10)
    head = b"DEF part ( )\n$VEL.CP = 0.01\n$BASE = {X 1,Y 2,Z 3,A 0,B 0,C 0}\n$TOOL = {X 0,Y 0,Z 100,A 0,B 0,C 0}\n"
    bodies = [head + text + b"\nLIN {X 1,Y 2,Z 3,A 4,B 5,C 6,E1 7,E2 8}\nEND\n" for text in texts if b"DEF" not in text]
    return [*own, *_KRL, *texts, *bodies]


_KRL = [
    b"DEF part ( )\nINT I\nDECL REAL X[3]\nGLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM ( )\nBAS (#INITMOV,0)\n"
    b"$BASE = {X 1,Y 2,Z 3,A 0,B 0,C 0}\n$TOOL = {X 0,Y 0,Z 100,A 0,B 0,C 0}\n$VEL.CP = 0.05\nPTP {A1 0,A2 -90,A3 90,A4 0,A5 10,A6 0}\n"
    b"FOR I = 1 TO 3 STEP 1\n LIN XP1 C_DIS\nENDFOR\nIF I > 2 THEN\n part_1 ( )\nELSE\n HALT\nENDIF\n"
    b"WHILE I < 5\n I = I + 1\nENDWHILE\nREPEAT\n I = I - 1\nUNTIL I == 0\nSWITCH I\nCASE 0\n X[1] = 2.5 * I\nDEFAULT\n X[2] = 1\nENDSWITCH\n"
    b"END\nDEFFCT REAL F (A :IN)\nREAL A\nRETURN A * 2\nENDFCT\n"
    + SEPARATOR
    + b"DEFDAT part PUBLIC\nDECL E6POS XP1={X 1.0,Y 2.0,Z 3.0,A 0.0,B 0.0,C 0.0,S 2,T 10,E1 0.0}\nDECL FDAT F1={TOOL_NO 1,BASE_NO 2}\nENDDAT\n"
    + SEPARATOR
    + b"DEF part_1 ( )\nLIN {X 1}\nCIRC {X 1,Y 2,Z 3},{X 2,Y 3,Z 4},CA 90\nEND\n",
]


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
    return [*own, *_SETUP, *_texts("test_setup.py", r"part_in_base")]


_SETUP = [
    b'part_in_base = [0, 0, 200, 0, 0, 0]\ndialect = "nx-clsf"\nunits = "mm"\nclearance_mm = 20.0\nrapid_feed_mm_min = 9000\nfeed_mm_min = 500\nspindle_rpm = 9000\ndecimate_mm = 0.001\nchord_tolerance_mm = 0.02\n'
    b'[[tool]]\nnumber = 1\nname = "ball"\ndiameter_mm = 8.0\nlength_mm = 60\nflange_to_tool = [0, 0, 200, 0, 0, 0]\n[[tool]]\nnumber = 2\n'
    b"[stock]\nbox_mm = [-10, -10, -10, 10, 10, 10]\n",
    b'part_in_base = [0, 0, 200, 0, 0, 0]\n[tool]\nlength_mm = 60\n[part]\nmesh = "stock.stl"\nunit = "m"\n',
]


def _log_seeds() -> list[bytes]:
    return [*_LOG, *(text + SEPARATOR + _LOG_TOML for text in _texts("test_log.py", r"^t,"))]


_LOG_TOML = (
    b'measured_frame = "base"\ntarget = "tool"\nprogram = "part.src"\ninstrument = "tracker"\nnote = "warm"\nsigma_mm = 0.02\n'
    b"sigma_deg = 0.001\npayload_kg = 12.5\nfeed_mm_min = 1500\nposes = false\n"
)
_LOG = [
    b"t,x,y,z,a,b,c,A1,A2,A3,A4,A5,A6,E1,E2\n"
    + b"".join(b"%.3f,%.3f,2.5,3.5,0,90,1e-3,1,-90,90,%.4f,10,0,100.5,-3\n" % (k * 0.012, k, k * 0.1) for k in range(5))
    + SEPARATOR
    + _LOG_TOML,
    b"t,x,y,z,cA1,cA2,cA3,cA4,cA5,cA6,cE1,cE2,fx,fy,fz\n0,1,2,3,1,2,3,4,5,6,7,8,,,\n0.004,,,,1,2,3,4,5,6,7,8,10,-20.5,3\n"
    + SEPARATOR
    + b"poses = true\n",
]


def _calibration_seeds() -> list[bytes]:
    """One of everything, and one with a single parameter."""
    size = ErrorSize(9, 1e-4, 2e-4, 3e-4, 4e-4, 1e-5, 2e-5)
    chosen = ["A2.zero", "A3.zero", "tool.x"]
    found = ParameterSet.of(parameter_of(cell(), name) for name in chosen)
    full = Calibration(
        cell().name, robot_digest(cell()), found.with_values(np.full(3, 1e-4), np.full(3, 1e-5)), ("tool.x",),
        (Held("A1.zero", "merged", ("base.c",)),), {"nominal/fitted": size, "calibrated/withheld": size},
        (("A2.zero", "A3.zero", 0.5),), 12.0, (1.0, 2.0, 3.0, 4.0, 5.0), 1e-5, 1e-5, (("log.csv", "0" * 64),), 9, 1, 2, True,
        ("a warning",),
    )  # fmt: skip
    return [calibration_text(full).encode()]


def _jobs_seeds() -> list[bytes]:
    return [*_texts("test_batch.py", r"\[\[job\]\]"), *_JOBS]


_JOBS = [
    b'[defaults]\ncell = "cell"\nmethod = "planned"\n[[job]]\nclfile = "part.cls"\nout = "{folder}/{stem}"\n[[job]]\nverb = "verify"\n'
    b'program = "a.src"\nagainst = "part.cls"\n[[job]]\nverb = "simulate"\nprogram = "a.src"\nout = "a.csv"\ncycle_ms = 4\n',
    b'[[job]]\nclfile = "*.cls"\ncell = "c"\nname = "A"\nmax_lines = 1000\nreport = false\nunits = "inch"\n'
    b'[[job]]\nverb = "diagnose"\ncell = "c"\nlog = ["a.csv", "b.csv"]\nout = "d"\n[[job]]\nverb = "calibrate"\nmeasured = ["a.csv"]\ncell = "c"\nout = "c.toml"\n',
]


def _solution_seeds() -> list[bytes]:
    machine, seeds = cell(), []
    q = np.linspace(0.0, 0.1, 9)[:, None] + np.zeros(len(machine))
    for save in (np.savez, np.savez_compressed):
        file = BytesIO()
        save(file, q=q, line=np.arange(9), axes=np.array(machine.names))
        seeds.append(file.getvalue())
    return seeds


def _parquet_seeds() -> list[bytes]:
    from camrob.measure.write_log import write_log

    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "log.csv"
        source.write_bytes(_LOG[0].split(SEPARATOR)[0])
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
