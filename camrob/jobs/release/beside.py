"""What NAME.json and NAME.html beside a program say of it: manifest, why it is slower than its file, how fast it cuts, player."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from camrob.findings import Finding
from camrob.jobs.files.solved_path import stem_of
from camrob.jobs.files.summary_file import said_in
from camrob.jobs.release.opinion import finding_of
from camrob.jobs.release.upload import SUFFIX
from camrob.languages import language_suffixes
from camrob.summaries.post_summary import Manifest
from camrob.units import mm_min_to_m_s
from camrob.witness.manifest import check_manifest, check_upload, digests, make_manifest

if TYPE_CHECKING:
    from camrob.prediction.force_model import CuttingForces

__all__ = [
    "SLOWER_BY_PLAN",
    "SLOWER_BY_TOLERANCE",
    "compensated_manifest",
    "fastest_that_cuts",
    "manifest_findings",
    "manifest_of",
    "player_beside",
    "reason_for_slower",
    "said_to_be_compensated",
]

SLOWER_BY_PLAN, SLOWER_BY_TOLERANCE = "--feed optimal", "the set-up's tolerance"
_PLAYER = b'<div id="view"'  # where a page's player stands
_OF_COMPENSATE = ("error_before", "error_after", "calibration")  # keys of what `compensate` says, and no other job


def manifest_of(
    folder: Path, files: Iterable[str], cell: Path, clfile: Path, setup: Path | None, known: Iterable[Path] = ()
) -> Manifest:
    """The manifest of NAME.json, of program files in a folder."""
    program = [folder / name for name in files if name.endswith(language_suffixes())]
    return Manifest(**make_manifest(program, cell, clfile=clfile, setup=setup, known=known))


def compensated_manifest(folder: Path, cell: Path, source: Path, known: Iterable[Path]) -> Manifest:
    """The manifest of the program in a folder, whose targets are those of `source`, moved: CL file and set-up are those of the
    manifest beside that, where it is of the files that are there.
    """
    program = [file for file in folder.iterdir() if file.name.endswith(language_suffixes())]
    made = Manifest(**make_manifest(program, cell, known=known))
    then = _said_beside(source).get("manifest")
    beside = [source.with_name(file.name) for file in program]
    given = digests(sorted(file for file in {source, *beside} if file.is_file()))
    if isinstance(then, Mapping) and then.get("program") == given:
        made = replace(made, cl_file=then.get("cl_file", {}), setup=then.get("setup", {}))
    return replace(made, source=given)


def manifest_findings(program: Path, cell: Path, clfile: Path | None, setup: Path | None) -> list[Finding]:
    """What differs from the manifest in the NAME.json beside a program; nothing where there is none."""
    manifest = _said_beside(program).get("manifest")
    if not isinstance(manifest, Mapping):
        return []
    found = check_manifest(manifest, _named(program, manifest), cell, clfile=clfile, setup=setup)
    listed = program.with_suffix(SUFFIX)
    if listed.exists():
        found += check_upload(_text(listed), program, _named(program, manifest))
    return [finding_of(o, o.text, 0) for o in found]


def reason_for_slower(program: Path) -> str:
    """Why a program is slower than its file says, as its own NAME.json has it; empty where it is not the program posted."""
    feed = _feed_posted(program)
    return SLOWER_BY_PLAN if feed.get("mode") == "optimal" else SLOWER_BY_TOLERANCE if "tolerance" in feed else ""


def fastest_that_cuts(program: Path, forces: CuttingForces | None) -> float:
    """m/s beyond which a program's lines and arcs are moves in air: as FORCE.toml says, else as `post` wrote beside the program;
    infinite where neither does, and where what is beside it is of another program.
    """
    if forces is not None and forces.fastest < float("inf"):
        return forces.fastest
    said = _feed_posted(program).get("fastest_cut_mm_min")
    return float(mm_min_to_m_s(said)) if isinstance(said, int | float) and said > 0.0 else float("inf")


def player_beside(program: Path | None, out: Path) -> str:
    """The address, for a page in the folder `out`, of the page beside a program that plays it; "" where none does."""
    page = None if program is None else program.with_suffix(".html")
    try:
        if page is None or _PLAYER not in page.read_bytes():
            return ""
    except OSError:
        return ""
    return quote(os.path.relpath(page.resolve(), out.resolve()).replace(os.sep, "/"))


def said_to_be_compensated(program: Path) -> str:
    """The name of the file that says so, of a program or a solved path; "" where none does."""
    said = _said_beside(program)
    files = said.get("files")
    ours = all(key in said for key in _OF_COMPENSATE) and isinstance(files, list) and program.name in files
    return f"{stem_of(program)}.json" if ours else ""


def _said_beside(program: Path) -> Mapping[str, Any]:
    """What the NAME.json beside a program or a solved path says; nothing where there is none."""
    return said_in(program.with_name(f"{stem_of(program)}.json"))


def _feed_posted(program: Path) -> Mapping[str, Any]:
    """The feed as `post` wrote it beside a program; nothing where that was another program."""
    said = _said_beside(program)
    manifest, feed = said.get("manifest"), said.get("feed")
    if not isinstance(manifest, Mapping) or not isinstance(feed, Mapping):
        return {}
    return feed if manifest.get("program") == digests(_named(program, manifest)) else {}


def _named(program: Path, manifest: Mapping[str, Any]) -> set[Path]:
    """The program's files that are there: its own, and those that the manifest names."""
    named = manifest.get("program")
    files = [program.with_name(Path(name).name) for name in named] if isinstance(named, Mapping) else []
    return {file for file in {program, *files} if file.is_file()}


def _text(file: Path) -> str:
    """A file's text, empty where it has none that can be read."""
    try:
        return file.read_text(encoding="ascii")
    except (OSError, UnicodeDecodeError):
        return ""
