"""`camrob regress`: post every sample and hold whole programs and summaries to golden files."""

from __future__ import annotations

import gzip
import json
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from camrob.errors import CamrobError, InputError
from camrob.jobs.files.inputs import CL_SUFFIXES
from camrob.jobs.files.output import staged_output
from camrob.jobs.files.takes_paths import takes_paths
from camrob.jobs.post import post
from camrob.jobs.regressing.compare_program import compare_program
from camrob.jobs.regressing.compare_summary import comparable, compare_summary
from camrob.languages import language_suffixes
from camrob.progress import Progress, silent
from camrob.summaries.regress_summary import RegressSummary, SampleFigures

__all__ = ["RegressResult", "regress"]

GOLDEN = "golden"
"""The folder beside a sample's CL file that holds what its post should make."""

_PLAIN = 65_536  # bytes of a program that stays plain text; a longer one is packed


@dataclass(frozen=True, slots=True)
class RegressResult:
    """`ok` where every sample came out as its golden files say (or, updated, was written)."""

    ok: bool
    summary: RegressSummary


@dataclass(slots=True)
class _Sample:
    """One sample's outcome: `made` maps file names to text, the summary among them."""

    clfile: Path
    made: dict[str, str] = field(default_factory=dict)
    summary: dict[str, Any] = field(default_factory=dict)
    differences: list[str] = field(default_factory=list)
    rounded: int = 0
    seconds: float = 0.0

    @property
    def golden(self) -> Path:
        return self.clfile.parent / GOLDEN


@takes_paths
def regress(
    toolpaths: Path,
    *,
    cell: Path,
    update: bool = False,
    progress: Progress | None = None,
) -> RegressResult:
    """Post every sample (a folder of `toolpaths` with one CL file) and compare it with its golden files.

    Words are compared exactly, numbers of programs to one unit in the last decimal, numbers of summaries to what that unit can
    make of them; seconds are left out.

    Args:
        toolpaths: the folder of the samples.
        cell: the cell's folder.
        update: whether what comes out now becomes golden, if every sample can be posted.
        progress: called with a sample and the share of all that is done, 0 to 1.

    Raises:
        InputError: there are no samples.

    Example:
        >>> camrob.regress(Path("samples"), cell=Path("cells/kr15_track_table")).ok
        True
    """
    samples = _samples(Path(toolpaths))
    for k, sample in enumerate(samples):
        (progress or silent)(sample.clfile.parent.name, k / len(samples))
        _make(sample, cell)
    made = all(sample.made for sample in samples)
    for sample in samples:
        if update and made:
            _write(sample)
        elif not update and sample.made:
            _compare(sample)
    ok = not any(sample.differences for sample in samples)
    summary = RegressSummary(
        ok=ok,
        cell=Path(cell).name,
        updated=bool(update and made),
        samples=tuple(_figures(sample) for sample in samples),
    )
    return RegressResult(ok, summary)


def _samples(toolpaths: Path) -> list[_Sample]:
    """The samples of a folder, by name."""
    if not toolpaths.is_dir():
        raise InputError("is not a folder", hint="give the folder that holds the samples", path=toolpaths)
    files = [f for f in sorted(toolpaths.glob("*/*")) if f.suffix.lower() in CL_SUFFIXES and f.is_file()]
    if not files:
        raise InputError(
            "holds no samples", hint="put every CL file with its setup.toml into a folder of its own", path=toolpaths
        )
    folders = [f.parent for f in files]
    twice = next((f for f in folders if folders.count(f) > 1), None)
    if twice is not None:
        raise InputError("holds several CL files", hint="give each sample a folder of its own", path=twice)
    return [_Sample(f) for f in files]


def _make(sample: _Sample, cell: Path) -> None:
    """Post a sample; why it can't be posted is a difference."""
    start = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        try:
            result = post(sample.clfile, cell=cell, out=Path(folder), report=False)
        except CamrobError as error:
            sample.differences.append(f"{sample.clfile.name} can no longer be posted: {error}")
        else:
            sample.summary = json.loads(json.dumps(comparable(result.summary.to_json())))
            programs = [f for f in result.files if f.endswith(language_suffixes())]
            sample.made = {f: (Path(folder) / f).read_bytes().decode("ascii") for f in programs}
            sample.made[f"{result.summary.program}.json"] = json.dumps(sample.summary, indent=1) + "\n"
    sample.seconds = round(time.perf_counter() - start, 3)


def _write(sample: _Sample) -> None:
    """Make what came out the golden files."""
    with staged_output(sample.golden) as folder:
        for name, text in sample.made.items():
            data = text.encode("ascii")
            if len(data) > _PLAIN:  # without name and time, so that the same program packs into the same bytes
                (folder / f"{name}.gz").write_bytes(gzip.compress(data, 9, mtime=0))
            else:
                (folder / name).write_bytes(data)
        written = {f.name for f in folder.iterdir()}
    for old in sample.golden.iterdir():
        if old.name not in written and old.is_file():
            old.unlink()


def _read(golden: Path) -> dict[str, str]:
    """Golden files by the names of what they hold."""
    out = {}
    for file in sorted(golden.iterdir()) if golden.is_dir() else ():
        try:
            data = gzip.decompress(file.read_bytes()) if file.suffix == ".gz" else file.read_bytes()
            out[file.name.removesuffix(".gz")] = data.decode("ascii")
        except (OSError, EOFError, ValueError):
            raise InputError("can't be read as a golden file", hint="make it again with --update", path=file) from None
    return out


def _compare(sample: _Sample) -> None:
    """Take down how a sample differs from its golden files."""
    golden = _read(sample.golden)
    if not golden:
        sample.differences.append("has no golden files; look at its program, then make them with --update")
        return
    for name in sorted({*golden, *sample.made}):
        if name not in sample.made:
            sample.differences.append(f"{name} is no longer made")
        elif name not in golden:
            sample.differences.append(f"{name} is new")
        elif name.endswith(".json"):
            try:
                before = json.loads(golden[name])
            except ValueError:
                before = None
            if not isinstance(before, dict):
                raise InputError("holds no summary", hint="make it again with --update", path=sample.golden / name)
            sample.differences += [f"{name}: {line}" for line in compare_summary(before, sample.summary)]
        else:
            found = compare_program(name, golden[name], sample.made[name])
            sample.differences += found.text
            sample.rounded += found.rounded


def _figures(sample: _Sample) -> SampleFigures:
    return SampleFigures(
        part=sample.clfile.parent.name,
        ok=not sample.differences,
        points=sample.summary.get("points"),
        differences=tuple(sample.differences),
        rounded=sample.rounded,
        seconds=sample.seconds,
    )
