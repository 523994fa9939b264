"""Who may import whom: the layering of the design, cycles at import time, and what is heavy."""

from __future__ import annotations

from collections.abc import Iterable

from structure_tree import Module, imports

__all__ = ["HEAVY", "heavy_at_import", "import_cycles", "layering_faults", "shared_by_reader_and_writer"]

# from the top down; a row imports only from rows below it, and the members of a row don't import each other
ROWS = (
    ("cli", "cli_real", "console", "options"),
    ("jobs",),
    ("report",),
    ("gap",),
    ("controller",),
    ("post",),
    ("check",),
    ("feed", "calibrate"),
    ("resolve",),
    ("kinematics", "dynamics"),
    ("cell", "toolpath", "measure"),
    ("se3",),
    ("frozen", "issues"),
    ("errors",),
    ("units", "text"),
)
RANK = {room: i for i, row in enumerate(ROWS) for room in row}

# the controller gets the text that the robot gets, and nothing from the solver that made it
NEVER = {("controller", "resolve"), ("controller", "feed")}
# the command line's files are one room
TOGETHER = {
    ("cli", "console"),
    ("cli", "options"),
    ("cli", "cli_real"),
    ("cli_real", "console"),
    ("cli_real", "options"),
}

HEAVY = frozenset(
    {"torch", "matplotlib", "plotly", "trimesh", "pinocchio", "skfuzzy", "pytorch_kinematics", "fcl", "coal"}
)
# rooms whose modules are there for a heavy library's sake, and may import it at their top; the command line and
# `import camrob` never reach them before a job runs (test_importing_camrob_and_its_command_line_is_light)
MAY_BE_HEAVY = {
    "report": frozenset({"plotly", "matplotlib", "trimesh"}),  # pages, figures and the bodies in them
    "check": frozenset({"trimesh", "fcl", "coal"}),  # collisions
}
# modules of such rooms that serve without the library
LIGHT = {"camrob.report.terminal"}


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
            if there == here or (here, there) in TOGETHER:
                continue
            if there not in RANK:
                faults.append(f"{module.at(found.node)}: import from where it lives, not from {found.target}")
            elif RANK[there] <= RANK[here] or (here, there) in NEVER:
                faults.append(f"{module.at(found.node)}: {here} must not import {there}")
    return faults


def _graph(tree: tuple[Module, ...], *, early: bool) -> dict[str, set[str]]:
    """Which modules of the tree each one imports; a module's packages come with it only where they are named."""
    known = {m.name for m in tree}
    return {
        m.name: {i.target for i in imports(m, known) if i.target in known and (i.early or not early)} - {m.name}
        for m in tree
    }


def import_cycles(tree: Iterable[Module]) -> list[str]:
    """Rings of modules that import each other while they are being imported."""
    graph = _graph(tuple(tree), early=True)
    done: set[str] = set()
    rings: list[str] = []

    def visit(name: str, path: list[str]) -> None:
        if name in path:
            rings.append(" > ".join([*path[path.index(name) :], name]))
        elif name not in done:
            for target in sorted(graph[name]):
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
    """Modules of `post` that both the KRL reader and the KRL writer reach, however far the way: there must be none."""
    graph = _graph(tuple(tree), early=False)
    reader, writer = (_reached(graph, f"camrob.post.krl_{which}") for which in ("reader", "writer"))
    shared = sorted(n for n in reader & writer if n.startswith("camrob.post."))
    absent = [f"camrob.post.krl_{w} isn't there" for w, found in (("reader", reader), ("writer", writer)) if not found]
    return absent + [f"{name}: both the reader and the writer use it" for name in shared]


def _reached(graph: dict[str, set[str]], start: str) -> set[str]:
    """A module and all that it imports, directly or not; empty where it isn't there."""
    todo = [start] if start in graph else []
    reached = set(todo)
    while todo:
        new = graph[todo.pop()] - reached
        reached |= new
        todo += new
    return reached
