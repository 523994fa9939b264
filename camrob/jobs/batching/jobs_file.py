"""JOBS.toml: what a batch shall do, checked key by key before anything starts."""

from __future__ import annotations

import glob
import os
from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path, PurePosixPath
from typing import Any

from camrob.errors import InputError
from camrob.jobs.batching.verbs import VERBS, Kind, Verb, Writes, read_verb
from camrob.jobs.files.cell_for import language_for
from camrob.jobs.files.inputs import program_name
from camrob.jobs.files.output import check_file_name
from camrob.program.language import Language
from camrob.shipped import cell_beside
from camrob.toml.read_toml import read_toml
from camrob.toml.table_reader import TableReader

__all__ = ["BatchJob", "read_jobs"]

_GLOB = set("*?[")


@dataclass(frozen=True, slots=True)
class BatchJob:
    """One job: its place in the batch (from 0), what it is about as the file names it, its verb, and the arguments.

    `arguments` hold absolute paths; `shown` says how to name them to the user. `out` is the folder that receives the
    files (None where the verb writes none), `product` the stem of the files' names.
    """

    index: int
    label: str
    verb: Verb
    arguments: Mapping[str, Any]
    shown: Mapping[Path, str]
    out: Path | None
    product: str


def read_jobs(path: Path, out: Path | None = None) -> tuple[BatchJob, ...]:
    """The jobs of a file, globs spread out, in the order of the file and of the names.

    Inputs are relative to the file; outputs are relative to `out` (without it, to the file) and stay below it.
    Raises InputError naming file, key and hint.
    """
    path = Path(path)
    if path.is_file() and path.suffix.lower() != ".toml":
        hint = "give a JOBS.toml with a [[job]] for each; one CL file alone is for camrob post"
        raise InputError("is no list of jobs", hint=hint, path=path)
    table = TableReader(read_toml(path, InputError), path, error=InputError)
    defaults = table.table("defaults") if "defaults" in table else TableReader({}, path, "defaults", error=InputError)
    entries = table.tables("job")
    if not entries:
        raise InputError("holds no jobs", hint="write a [[job]] with a clfile for each", path=path)
    table.finish()
    verbs = [_verb(entry, defaults) for entry in entries]
    _known(defaults, {key for verb in verbs for key in verb.keys} | {"verb"}, "any of these jobs")
    shared = {verb.name: _values(defaults, verb) for verb in verbs}
    jobs: list[BatchJob] = []
    languages: dict[Path, Language] = {}
    for entry, verb in zip(entries, verbs, strict=True):
        _known(entry, {*verb.keys, "verb"}, f"verb {verb.name!r}")
        values = shared[verb.name] | _values(entry, verb)
        for key in (verb.about, *verb.required):
            if key not in values and key != "out":
                raise entry.fail(key, "is missing", f"give {verb.keys[key]}")
        for spread in _spread(entry, verb, values):
            jobs.append(_job(entry, verb, spread, out, len(jobs), languages))
    _apart(path, jobs)
    return tuple(jobs)


def _verb(entry: TableReader, defaults: TableReader) -> Verb:
    """The verb of an entry: its own, the defaults', or post."""
    for table in (entry, defaults):
        if "verb" in table:
            return read_verb(table.text("verb", choices=tuple(VERBS)))
    return read_verb("post")


def _known(table: TableReader, keys: set[str], who: str) -> None:
    """Raise for a key that nobody takes."""
    unknown = sorted(set(table.keys()) - keys)
    if unknown:
        near = get_close_matches(unknown[0], sorted(keys), 1)
        hint = f"is it {near[0]}?" if near else f"use {', '.join(sorted(keys))}"
        raise table.fail(unknown[0][:60], f"is not a key of {who}", hint)


def _values(table: TableReader, verb: Verb) -> dict[str, Any]:
    """The values that a table gives for keys of a verb, checked for their kind."""
    found: dict[str, Any] = {}
    for key, kind in verb.keys.items():
        if key not in table:
            continue
        if kind is Kind.INTEGER:
            found[key] = table.integer(key, lower=-(2**31), upper=2**31)
        elif kind is Kind.NUMBER:
            found[key] = table.number(key)
        elif kind is Kind.FLAG:
            found[key] = table.flag(key)
        elif kind in (Kind.TEXTS, Kind.FILES):
            found[key] = table.texts(key)
        else:
            found[key] = table.text(key, choices=verb.choices.get(key, ()))
        if kind in (Kind.FILE, Kind.FILES) and not all(found[key] if kind is Kind.FILES else (found[key],)):
            raise table.fail(key, "is empty", f"give {kind}")
    return found


def _matching(table: TableReader, key: str, text: str) -> list[str]:
    """A path, or those that a pattern stands for, by name. Raises InputError where it stands for none."""
    base = table.path.parent
    if not _GLOB & set(text) or os.path.exists(base / text):
        return [text]
    found = sorted(f for f in glob.glob(text, root_dir=base, recursive=True) if os.path.isfile(base / f))
    if not found:
        raise table.fail(key, f"{text[:60]!r} matches no file", "correct the pattern")
    return found


def _spread(entry: TableReader, verb: Verb, values: dict[str, Any]) -> list[dict[str, Any]]:
    """An entry's values, once for each file that it is about; lists of paths are spread within."""
    spread = dict(values)
    for key, kind in verb.keys.items():
        if kind is Kind.FILES and key in values:
            spread[key] = tuple(f for text in values[key] for f in _matching(entry, key, text))
    if verb.keys[verb.about] is Kind.FILES:
        return [spread]
    files = _matching(entry, verb.about, spread[verb.about])
    if len(files) > 1 and "name" in spread:
        raise entry.fail("name", f"would be the name of {len(files)} programs", "leave it out, or list the files")
    return [spread | {verb.about: file} for file in files]


def _job(
    entry: TableReader,
    verb: Verb,
    values: Mapping[str, Any],
    out: Path | None,
    index: int,
    languages: dict[Path, Language],
) -> BatchJob:
    """One job, its paths made absolute. languages: of the cells that were looked at, by path."""
    base = entry.path.parent
    arguments: dict[str, Any] = {}
    shown: dict[Path, str] = {}

    def absolute(text: str) -> Path:
        path = cell_beside(base, text) if text == values.get("cell") else base / text
        whole = path.parent.resolve() / path.name if path.name not in ("", "..") else path.resolve()
        shown[whole] = str(path)
        return whole

    for key, value in values.items():
        kind = verb.keys[key]
        if key == "out":
            continue
        arguments[key] = (
            absolute(value) if kind is Kind.FILE else tuple(map(absolute, value)) if kind is Kind.FILES else value
        )
    about = values[verb.about]
    first = Path(about if isinstance(about, str) else about[0])
    folder, product = None, ""
    if verb.writes is not Writes.NOTHING:
        target = _target(entry, verb, values.get("out"), first, arguments[verb.about], out)
        arguments["out"] = target
        folder = target.parent if verb.writes is Writes.FILE else target
        product = _product(entry, verb, arguments, target, languages)
    return BatchJob(index, first.as_posix(), verb, arguments, shown, folder, product)


def _target(entry: TableReader, verb: Verb, text: str | None, first: Path, about: Any, out: Path | None) -> Path:
    """Where a job writes; never outside of the batch's folder."""
    if text is None and (out is None or verb.writes is Writes.FILE):
        more = "" if verb.writes is Writes.FILE else ", or --out"
        raise entry.fail("out", "is missing", f"give {verb.writes}{more}")
    root = (entry.path.parent if out is None else Path(out)).resolve()
    if text is None:
        return root
    source = about if isinstance(about, Path) else about[0]
    text = text.replace("{stem}", first.stem).replace("{folder}", source.parent.name)
    target = PurePosixPath(text)
    if target.is_absolute() or ".." in target.parts or "\\" in text:
        raise entry.fail("out", f"{text[:60]!r} leads out of the batch's folder", "give a path below it")
    try:
        for part in target.parts:
            check_file_name(part)
    except InputError as error:
        raise entry.fail("out", error.what, error.hint) from None
    if not (root / target).resolve().is_relative_to(root):
        raise entry.fail("out", f"{text[:60]!r} leads out of the batch's folder by a link", "give another")
    return (root / target).resolve() if verb.writes is Writes.FOLDER else (root / target.parent).resolve() / target.name


def _product(
    entry: TableReader, verb: Verb, arguments: Mapping[str, Any], target: Path, languages: dict[Path, Language]
) -> str:
    """The stem of the files that a job writes."""
    if verb.writes is Writes.FILE:
        return target.stem
    about = arguments[verb.about]
    if not isinstance(about, Path):
        return verb.name
    if "name" not in verb.keys:
        return about.stem
    try:
        cell = arguments["cell"]
        if cell not in languages:
            languages[cell] = language_for(cell)
        return program_name(about, arguments.get("name"), languages[cell])
    except InputError as error:
        raise entry.fail("name", error.what, error.hint) from None


def _apart(path: Path, jobs: list[BatchJob]) -> None:
    """Raise where two jobs would write the same files."""
    taken: dict[tuple[Path, str], BatchJob] = {}
    for job in jobs:
        if job.out is None:
            continue
        other = taken.setdefault((job.out, job.product.casefold()), job)
        if other is not job:
            raise InputError(
                f"{other.verb.name} of {other.label} and {job.verb.name} of {job.label} would both write {job.product}",
                hint='give them an out of their own (such as out = "{folder}"), or names',
                path=path,
            )
