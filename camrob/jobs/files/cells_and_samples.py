"""`camrob cell` and `camrob samples`: what comes with camrob, and folders for cells of one's own."""

from __future__ import annotations

import json
import os
import re
import shutil
from dataclasses import dataclass
from pathlib import Path

from camrob.cell.cell import Cell
from camrob.cell.read_cell import read_cell
from camrob.errors import CellError, InputError
from camrob.jobs.files.output import check_file_name, staged_output
from camrob.jobs.files.programmed import straightened_by, tables_for_programs
from camrob.shipped import shipped_cells, shipped_samples
from camrob.summaries.shipped_summary import (
    CellListSummary,
    ListedCell,
    ListedSample,
    NewCellSummary,
    SamplesSummary,
)
from camrob.units import m_to_mm

__all__ = ["CellListResult", "NewCellResult", "SamplesResult", "cell_from_urdf", "list_cells", "new_cell", "samples"]

_NAMED = re.compile(r'^name\s*=\s*("[^"\n]*"|\'[^\'\n]*\')', re.MULTILINE)  # the first is the cell's own
_TITLED = re.compile(r"^title\s*=.*$", re.MULTILINE)
_STANDING = re.compile(r'(?<=standing)(\s*=\s*)("\w+"|\{[^{}]*\})')
_KNOWN = re.compile(r'"(?:datasheet|paper|measured)"')
_REFERENCE = "## poses.csv"  # from this heading on, the README of the cell below tells files and keys of every cell
_TOLD_BY = "kr15_track_table"
_TELLING = 1e-6  # m between a URDF's plate and that of its rows, from which on it is said
_KEPT = (
    ".cls",
    ".stl",
    ".toml",
    ".md",
)  # of a sample: not its pictures and golden files, which only the repository has


@dataclass(frozen=True, slots=True)
class CellListResult:
    """The cells that come with camrob."""

    summary: CellListSummary


@dataclass(frozen=True, slots=True)
class NewCellResult:
    """A cell's new folder, and the cell as it is read from there."""

    summary: NewCellSummary
    cell: Cell


def list_cells() -> CellListResult:
    """The cells that come with camrob, each read and held against its poses. Raises CellError for one that can't be read."""
    return CellListResult(CellListSummary(cells=tuple(_listed(folder) for folder in shipped_cells().values())))


def _listed(folder: Path) -> ListedCell:
    cell = read_cell(folder)
    return ListedCell(
        name=cell.name,
        title=cell.title,
        folder=str(folder),
        axes=cell.axis_names,
        controller=cell.controller_section is not None,
        resolve=cell.resolve_section is not None,
    )


def new_cell(name: str, *, source: Path, out: Path = Path()) -> NewCellResult:
    """Copy a cell's folder to `out`/`name`, which bears that name from then on. All of it appears, or nothing.

    What the source's numbers rest on holds for the source: in the copy each is `assumed` until its owner says otherwise.

    Args:
        name: the new cell's name, and its folder's.
        source: the folder of the cell that is most like it.
        out: where the folder is made.

    Raises:
        InputError: a name that can't be a folder's, a folder that is there already.
        CellError: a source that is no cell.
    """
    folder = _free(Path(out), name)
    source = Path(source)
    read_cell(source)
    with staged_output(folder) as staging:
        for file in sorted(source.iterdir()):
            if file.is_file() and not file.name.startswith("."):
                shutil.copyfile(file, staging / file.name)
        settings = staging / "cell.toml"
        text = settings.read_text(encoding="utf-8-sig")
        text = _NAMED.sub(lambda _: f"name = {json.dumps(name)}", text, count=1)
        text = _TITLED.sub(lambda _: f"title = {json.dumps(f'{name}, made from {source.name}')}", text, count=1)
        text = _STANDING.sub(lambda m: m[1] + _KNOWN.sub('"assumed"', m[2]), text)
        settings.write_text(text, encoding="utf-8")
        (staging / "README.md").write_text(_readme(name, source), encoding="utf-8")
        read_cell(staging)
    return _made(
        folder,
        (
            f"write the machine's own numbers into cell.toml, each with its provenance: all are {source.name}'s, and assumed",
            "README.md says key by key what they mean",
            "replace the rows of poses.csv when the chain changes: every command holds the cell against them",
            "take characteristic_length_mm from camrob cell condition then: 1/k_F is measured by it",
        ),
    )


def _readme(name: str, source: Path) -> str:
    """What the copy's owner has to replace, and the reference of files and keys, which no source but one has in full."""
    reference = (shipped_cells()[_TOLD_BY] / "README.md").read_text(encoding="utf-8").partition(_REFERENCE)[2]
    reference = re.sub(r"\[([^\]]*)\]\(\.\./[^)]*\)", r"\1", reference)  # pages that don't lie beside a copy
    return f"""# {name}: made from {source.name}

Every number in `cell.toml` is {source.name}'s until it is replaced, and its provenance `assumed` until it is known for this
machine. A program that rests on an assumed limit says so; `camrob cell check` counts what is left.

{_REFERENCE}{reference}"""


def cell_from_urdf(
    urdf: Path, *, name: str | None = None, tip: str | None = None, post: bool = False, out: Path = Path()
) -> NewCellResult:
    """A cell's folder out of a URDF: chain, limits, speeds and masses up to the link `tip`. All of it appears, or nothing.

    Such a cell is enough for `calibrate` and `diagnose`; what `post` needs beside it (controller, redundancy, tool) no URDF says.

    Args:
        urdf: the file; it is copied into the folder.
        name: the cell's name, and its folder's. Default: after the file.
        tip: the link that the chain ends at. Default: the only end there is.
        post: add what programs need, at values that are assumed and said to be.
        out: where the folder is made.

    Raises:
        InputError: no such file, a name that can't be a folder's, a folder that is there already.
        CellError: a URDF that can't be read, or whose chain is no arm of one to seven axes.
    """
    urdf = Path(urdf)
    if not os.path.isfile(urdf):
        raise InputError("is not a file", hint="give a URDF", path=urdf)
    name = re.sub(r"\W+", "_", urdf.stem).strip("_") if name is None else name
    folder = _free(Path(out), name)
    lines = [
        f"# Made from {json.dumps(urdf.name)}. Chain, limits and masses are that file's; what else a cell may hold is said in",
        "# cells/kr15_track_table/README.md, which comes with camrob.",
        "schema = 1",
        f"name = {json.dumps(name)}",
        'standing = "datasheet"',
        "",
        "[arm]",
        'urdf = "robot.urdf"',
        *([] if tip is None else [f"tip = {json.dumps(tip)}"]),
    ]
    with staged_output(folder) as staging:
        shutil.copyfile(urdf, staging / "robot.urdf")
        (staging / "cell.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
        try:
            cell = read_cell(staging)
        except CellError as error:  # of a file that nobody has written
            said = error.what.removeprefix("arm.urdf: ")
            raise CellError(re.sub(r"^arm\.tip: ", "--tip ", said), hint=error.hint, path=urdf) from None
        if post:
            head = "\n".join(lines[:4]) + f"\ntitle = {json.dumps(f'{name}, made from {urdf.name}')}\n"
            (staging / "cell.toml").write_text(head + tables_for_programs(cell, urdf), encoding="utf-8")
            off = straightened_by(cell, read_cell(staging))
    counted = "check that its zeros and senses are those that the controller counts in (signs, offsets_deg of [arm])"
    made_up = "its masses are all alike, each in its link's origin: made up, and left out; give the maker's by [[mass]]"
    left_out = (made_up,) if b"<mass" in urdf.read_bytes() and not cell.masses else ()
    if post:
        return _made(
            folder,
            (
                counted,
                *left_out,
                "HOME, accelerations, tool, load, controller and outputs are assumed: write the machine's own into cell.toml",
                "no bodies are drawn ([[shape]]), so that no collision is seen yet",
                *_straightened(off),
            ),
        )
    return _made(
        folder,
        (
            f"calibrate and diagnose take it as it is; {counted}",
            *left_out,
            "post needs more: --post adds it, at assumed values",
        ),
    )


def _straightened(off: float) -> tuple[str, ...]:
    if off < _TELLING:
        return ()
    what = "axes that the file's rounding has askew by less than 0.001 degrees were made square or parallel"
    return (f"{what}: the plate lies up to {m_to_mm(off):.4f} mm beside the file's",)


def _free(out: Path, name: str) -> Path:
    """The folder to make. Raises InputError where it is there, or can't be."""
    folder = out / check_file_name(name)
    if os.path.lexists(folder):
        raise InputError("is there already", hint="choose another name", path=folder)
    return folder


def _made(folder: Path, then: tuple[str, ...]) -> NewCellResult:
    cell = read_cell(folder)
    summary = NewCellSummary(
        name=cell.name,
        folder=str(folder),
        files=tuple(sorted(file.name for file in folder.iterdir())),
        axes=cell.axis_names,
        next=then,
    )
    return NewCellResult(summary, cell)


@dataclass(frozen=True, slots=True)
class SamplesResult:
    """The samples."""

    summary: SamplesSummary


def samples(*, out: Path | None = None) -> SamplesResult:
    """List the samples, or copy them to `out`, a folder each.

    Args:
        out: the folder that receives copies; None: the samples are only listed, where they are.

    Raises:
        InputError: a folder of a sample's name is in `out` already, or can't be made.
    """
    found = shipped_samples()
    if out is not None:
        taken = [Path(out) / name for name in found if os.path.lexists(Path(out) / name)]
        if taken:
            raise InputError("is there already", hint="name another folder with --out", path=taken[0])
        found = {name: _copy_sample(folder, Path(out) / name) for name, folder in found.items()}
    listed = tuple(_listed_sample(name, folder) for name, folder in found.items())
    return SamplesResult(SamplesSummary(samples=listed, copied=out is not None))


def _copy_sample(folder: Path, target: Path) -> Path:
    with staged_output(target) as staging:
        for file in sorted(folder.iterdir()):
            if file.is_file() and file.suffix in _KEPT:
                shutil.copyfile(file, staging / file.name)
    return target


def _listed_sample(name: str, folder: Path) -> ListedSample:
    first = (folder / "README.md").read_text(encoding="utf-8").partition("\n")[0]
    title = first.lstrip("# ").removeprefix(f"{name}: ")
    return ListedSample(name=name, folder=str(folder), clfile=f"{name}.cls", title=title)
