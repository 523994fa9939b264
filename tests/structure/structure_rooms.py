"""How rooms are kept: how many files one holds, and that a file's name says which file is meant."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from pathlib import PurePath

from structure_tree import Module, imports

__all__ = ["REGISTRIES", "crowded_faults", "name_faults"]

FILES = 20  # in a folder: as many as one reads through at a glance
# folders of plug-ins, one file each
REGISTRIES = {
    "camrob/gap/effects": "the effects",
    "camrob/toolpath/apt/dialects": "the dialects of CL text",
    "camrob/toolpath/gcode/controls": "the controls of G code",
}
# rooms beside each other that are built alike, by the beginning of their names: their files may be called alike
PARALLEL = (
    ("camrob.toolpath.apt.", "camrob.toolpath.gcode."),
    ("camrob.report.",),
    ("camrob.languages.",),
)
# what every registry is called
ROLES = {"__init__", "__main__", "registry"}


def crowded_faults(tree: Iterable[Module]) -> list[str]:
    """Folders with more files than a room may have."""
    count: dict[str, int] = defaultdict(int)
    for module in tree:
        count[str(PurePath(module.file).parent)] += 1
    return [
        f"{folder}: {files} files"
        for folder, files in sorted(count.items())
        if files > FILES and folder not in REGISTRIES
    ]


def name_faults(tree: Iterable[Module]) -> list[str]:
    """Modules of one name: outside of parallel rooms, and but for a job and what it calls; the witness is a house of its own."""
    tree = tuple(tree)
    named: dict[tuple[bool, str], list[Module]] = defaultdict(list)
    for module in tree:
        stem = module.name.rpartition(".")[2]
        if not module.is_package and stem not in ROLES:
            named[module.name.startswith("camrob.witness."), stem].append(module)
    faults = []
    for (_, stem), modules in sorted(named.items()):
        if len(modules) < 2 or _parallel(modules) or _job_and_its_room(modules):
            continue
        faults.append(f"{stem}: {', '.join(m.file for m in modules)}")
    return faults


def _parallel(modules: list[Module]) -> bool:
    """Whether all stand in rooms that are built alike."""
    return any(all(m.name.startswith(rooms) for m in modules) for rooms in PARALLEL)


def _job_and_its_room(modules: list[Module]) -> bool:
    """Whether these are a job, and a module of a room that it imports from."""
    jobs = [m for m in modules if m.name.startswith("camrob.jobs.")]
    if len(modules) != 2 or len(jobs) != 1:
        return False
    (other,) = (m for m in modules if m not in jobs)
    room = other.name.rpartition(".")[0]
    return any(found.target == room or found.target.startswith(f"{room}.") for found in imports(jobs[0]))
