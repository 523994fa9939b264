"""Who may import whom: the layering of the design, rings of modules, and what is heavy."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable

from structure_tree import Module, imports

__all__ = [
    "HEAVY",
    "OWED",
    "OWED_ANNOTATIONS",
    "heavy_at_import",
    "import_cycles",
    "layering_faults",
    "owed_layers",
    "shared_by_reader_and_writer",
    "study_faults",
    "typing_cycles",
]

# from the top down; a row imports only from rows below it, and the members of a row don't import each other
ROWS = (
    ("__main__",),
    ("cli", "warm"),
    ("jobs",),
    ("report",),
    ("prediction", "studies"),
    ("gap", "loop"),
    ("controller", "witness"),
    ("languages",),
    ("program",),
    ("cutting",),
    ("checks", "timing", "calibration"),
    ("redundancy",),
    ("bodies",),
    ("kinematics", "dynamics"),
    ("cell", "toolpath", "measurement"),
    ("machine_tool",),
    ("se3", "frame_steps", "triples", "small_matrices", "product_grid", "summaries"),
    ("frozen", "findings", "shipped", "compiler", "toml"),
    ("errors", "compiled"),
    ("units", "text", "progress", "runs", "compiling", "machine_code"),
)
RANK = {room: i for i, row in enumerate(ROWS) for room in row}

# the controller gets the text that the robot gets, and nothing from the solver that made it; it names no language, nor do those
# who look at what came of a program
NEVER = {
    ("controller", "redundancy"),
    ("controller", "timing"),
    ("controller", "languages"),
    ("gap", "languages"),
    ("loop", "languages"),
    ("report", "languages"),
    ("studies", "languages"),
}
# what judges a program shares nothing with what made it
ONLY = {"witness": frozenset({"errors", "text"})}
# what reader and writer of a language may both know: the words that the protocol between them is spoken in
PROTOCOL = {"camrob.program.motion"}
# what still is as it must not stay: (room, room) to what it waits for
OWED: dict[tuple[str, str], str] = {}
# imports for annotations that close a ring and must not stay: (module, module) to what they wait for
OWED_ANNOTATIONS: dict[tuple[str, str], str] = {}

# jobs that are a paper's study; the others' old words ask for one when they are run, and no sooner
STUDY_JOBS = ("camrob.jobs.studies.", "camrob.jobs.published_case", "camrob.jobs.tracker")

HEAVY = frozenset({"torch", "matplotlib", "trimesh", "pinocchio", "skfuzzy", "pytorch_kinematics", "fcl", "coal"})
# rooms whose modules are there for a heavy library's sake, and may import it at their top; the command line and
# `import camrob` never reach them before a job runs (test_importing_camrob_and_its_command_line_is_light)
MAY_BE_HEAVY = {
    "report": frozenset({"matplotlib"}),  # pages and figures
    "bodies": frozenset({"trimesh"}),  # meshes
    "checks": frozenset({"trimesh", "fcl", "coal"}),  # collisions
}
# modules of such rooms that work without the library
LIGHT = {"camrob.report.terminal.summaries"}


def room(module: str) -> str:
    """The room of the house that a module of camrob stands in: "cell", "se3", ...; "" for camrob itself."""
    return module.partition(".")[2].partition(".")[0]


def layering_faults(tree: Iterable[Module]) -> list[str]:
    """Imports that point up or sideways."""
    tree = tuple(tree)
    known = {m.name for m in tree}
    faults = []
    for module in tree:
        here = room(module.name)
        if module.name == "camrob":
            continue  # the public names come from everywhere, when they are asked for
        if here not in RANK:
            faults.append(f"{module.at(module.tree)}: {here} has no place in the layering")
            continue
        for found in imports(module, known):
            if found.target.split(".")[0] != "camrob":
                continue
            there = room(found.target)
            if there == here or (here, there) in OWED:
                continue
            if there not in RANK:
                faults.append(f"{module.at(found.node)}: import from where it lives, not from {found.target}")
            elif RANK[there] <= RANK[here] or (here, there) in NEVER or there not in ONLY.get(here, {there}):
                faults.append(f"{module.at(found.node)}: {here} must not import {there}")
    return faults


def study_faults(tree: Iterable[Module]) -> list[str]:
    """Jobs of the product that import a paper's study while they are imported."""
    tree = tuple(tree)
    known = {m.name for m in tree}
    return [
        f"{module.at(found.node)}: {found.target} is for `camrob study` alone"
        for module in tree
        if room(module.name) == "jobs" and not module.name.startswith(STUDY_JOBS)
        for found in imports(module, known)
        if found.early and found.target.startswith(("camrob.studies.", "camrob.jobs.studies."))
    ]


def owed_layers(tree: Iterable[Module]) -> set[tuple[str, str]]:
    """Which of the imports in OWED there still are."""
    tree = tuple(tree)
    known = {m.name for m in tree}
    pairs = {(room(m.name), room(i.target)) for m in tree for i in imports(m, known) if i.target.startswith("camrob.")}
    return pairs & set(OWED)


def _graph(tree: tuple[Module, ...], *, late: bool = True, typed: bool = True) -> dict[str, set[str]]:
    """Which modules of the tree each one imports; a module's packages come with it only where they are named.

    `late`: also in functions; `typed`: also for annotations alone.
    """
    known = {m.name for m in tree}
    graph = {}
    for module in tree:
        inside = {
            id(node)
            for branch in module.nodes
            if isinstance(branch, ast.If) and "TYPE_CHECKING" in ast.dump(branch.test)
            for statement in branch.body
            for node in ast.walk(statement)
        }
        found = [i for i in imports(module, known) if i.target in known]
        graph[module.name] = {i.target for i in found if i.early or (typed if id(i.node) in inside else late)} - {
            module.name
        }
    return graph


def import_cycles(tree: Iterable[Module]) -> list[str]:
    """Rings of modules that import each other while they are being imported."""
    return _rings(_graph(tuple(tree), late=False, typed=False))


def typing_cycles(tree: Iterable[Module], owed: Iterable[tuple[str, str]] = tuple(OWED_ANNOTATIONS)) -> list[str]:
    """Rings that only imports for annotations close, but those that are owed."""
    graph = _graph(tuple(m for m in tree if m.name != "camrob"), late=False)
    for name, target in owed:
        graph.get(name, set()).discard(target)
    return _rings(graph)


def _rings(graph: dict[str, set[str]]) -> list[str]:
    done: set[str] = set()
    rings: list[str] = []

    def visit(name: str, path: list[str]) -> None:
        if name in path:
            rings.append(" > ".join([*path[path.index(name) :], name]))
        elif name not in done:
            for target in sorted(graph.get(name, ())):
                visit(target, [*path, name])
            done.add(name)

    for name in sorted(graph):
        visit(name, [])
    return rings


def heavy_at_import(tree: Iterable[Module]) -> list[str]:
    """Heavy libraries imported at a module's top."""
    faults = []
    for module in tree:
        allowed = frozenset() if module.name in LIGHT else MAY_BE_HEAVY.get(room(module.name), frozenset())
        for found in imports(module):
            library = found.target.split(".")[0]
            if found.early and library in HEAVY and library not in allowed:
                faults.append(f"{module.at(found.node)}: import {library} in the function that needs it")
    return faults


def shared_by_reader_and_writer(tree: Iterable[Module]) -> list[str]:
    """What both the reader and the writer of a language reach, however far the way, of languages and programs: nothing."""
    graph = _graph(tuple(tree))
    starts = [name for name in graph if re.fullmatch(r"camrob\.languages\.\w+\.(reader|writer)\.\w+", name)]
    faults = []
    for language in sorted({name.split(".")[2] for name in starts} | {"krl"}):
        reached = []
        for side in ("reader", "writer"):
            room = f"camrob.languages.{language}.{side}."
            reached.append({m for name in starts if name.startswith(room) for m in _reached(graph, name)})
            if not reached[-1]:
                faults.append(f"{room} isn't there")
        shared = {
            n for n in reached[0] & reached[1] if n.startswith(("camrob.languages.", "camrob.program."))
        } - PROTOCOL
        faults += [f"{name}: both the reader and the writer use it" for name in sorted(shared)]
    return faults


def _reached(graph: dict[str, set[str]], start: str) -> set[str]:
    """A module and all that it imports, directly or not; empty where it isn't there."""
    todo = [start] if start in graph else []
    reached = set(todo)
    while todo:
        new = graph[todo.pop()] - reached
        reached |= new
        todo += new
    return reached
