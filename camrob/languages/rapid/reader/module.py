"""The modules of a RAPID program: their data and procedures, and the list (.pgf) of those that belong together."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

from camrob.errors import ProgramError
from camrob.languages.rapid.reader.tokens import Row, Statement, shown, statements_of
from camrob.text import bytes_of

__all__ = ["Module", "Node", "Routine", "load_module", "modules_beside"]

Node = Statement | Row
_LISTED = re.compile(r"<Module>\s*([^<>]+?)\s*</Module>", re.IGNORECASE)
_LONGEST_LIST = 1_000_000  # characters of a .pgf, a thousand times what one lists
_LEAVES = ("ERROR", "UNDO", "BACKWARD")  # what follows is run when something fails, or backwards
_REFERRING = ("VAR", "INOUT", "PERS")
_ENDS = {"PROC": "ENDPROC", "FUNC": "ENDFUNC", "TRAP": "ENDTRAP", "RECORD": "ENDRECORD"}


@dataclass(slots=True)
class Routine:
    """A procedure: type and name of what it is handed by value, None where it takes something otherwise; its statements.

    referred: it takes some of that by reference (VAR, INOUT, PERS); local: only its module may call it.
    """

    name: str
    line: int
    parameters: list[tuple[str, str]] | None
    referred: bool = False
    local: bool = False
    nodes: list[Node] = field(default_factory=list)


@dataclass(slots=True)
class Module:
    """A file: what it declares, its procedures and its functions by upper-case name, in their order."""

    path: Path
    name: str
    count: int
    declarations: list[Statement] = field(default_factory=list)
    routines: dict[str, Routine] = field(default_factory=dict)
    functions: dict[str, Routine] = field(default_factory=dict)


def load_module(path: Path) -> Module:
    """A .mod file. Raises ProgramError, with file and line, for what is no module."""
    try:
        text = path.read_bytes().decode("latin-1")  # RAPID's own encoding, ISO 8859-1
    except OSError as failure:
        raise ProgramError(
            f"can't be read ({failure.strerror or failure})", hint="check the path and who may read it", path=path
        ) from None
    text = text.replace("\r\n", "\n")
    if "\r" in text or "\0" in text:  # one system ends a line, and with it a remark, where another does not
        raise ProgramError("holds a CR without its LF, or a 0", hint="write CR, LF behind each line", path=path)
    lines = text.split("\n")
    while lines and lines[0].strip().startswith(
        "%%%"
    ):  # the header of older controllers, up to its second row of signs
        end = next((k for k, line in enumerate(lines[1:], 1) if line.strip().endswith("%%%")), 0)
        lines[: end + 1] = [""] * (end + 1)
    module = Module(path, "", len(lines))
    try:
        _take(module, lines)
    except ProgramError as error:
        raise error.at(path) from None
    if not module.name:
        raise ProgramError("holds no MODULE", hint="give a RAPID module", path=path)
    return module


def _take(module: Module, lines: list[str]) -> None:
    """Goes through a module's statements."""
    open_: Routine | None = None
    closing, over, ended = "", False, False
    for node in statements_of(lines):
        words = [t.text for t in node.tokens[:3]] if isinstance(node, Statement) else []
        word = words[0] if words else ""
        if closing:
            if word == closing:
                open_, closing, over = None, "", False
            elif word in _LEAVES and open_ is not None:
                over = True
            elif open_ is not None and not over:
                open_.nodes.append(node)
            continue
        kind = next((k for k in _ENDS if k in words[:2]), "")
        if isinstance(node, Row) or (ended and word):
            raise ProgramError("stands outside of any procedure", hint="is the file damaged?", line=node.line)
        if kind:
            closing = _ENDS[kind]
            open_ = _routine(node, kind) if kind in ("PROC", "FUNC") else None
            if open_ is not None:
                (module.routines if kind == "PROC" else module.functions)[open_.name] = open_
        elif word in ("MODULE", "SYSMODULE") and not module.name:
            module.name = words[1] if len(words) > 1 else ""
        elif word == "ENDMODULE":
            ended = True
        elif node.tokens[0].text != "(":
            module.declarations.append(node)
    if closing or (module.name and not ended):
        raise ProgramError(f"has no {closing or 'ENDMODULE'}", hint="the file is damaged", line=module.count)


def _routine(head: Statement, word: str) -> Routine:
    """A procedure or a function, which has a type before its name, from its head."""
    texts = [t.text for t in head.tokens]
    at = texts.index(word) + (1 if word == "PROC" else 2)
    if len(texts) < at + 3 or head.tokens[at].kind != "name":
        raise ProgramError(f"{shown(' '.join(texts[:4]))} is no routine", hint="write PROC name()", line=head.line)
    given = texts[at + 2 : -1]
    plain = [
        text for k, text in enumerate(given) if text not in _REFERRING or (given[k - 1 : k] not in ([], [","]) and k)
    ]
    return Routine(texts[at], head.line, _parameters(plain), referred=plain != given, local=texts[0] == "LOCAL")


def _parameters(texts: list[str]) -> list[tuple[str, str]] | None:
    """`TYPE NAME, TYPE NAME`: type and name of each; None of others (optional ones, arrays)."""
    out = []
    for k in range(0, len(texts), 3):
        some = texts[k : k + 3]
        if len(some) < 2 or (len(some) == 3) != (k + 3 < len(texts)) or some[2:] not in ([], [","]):
            return None
        if some[0] in _REFERRING or not all(text.isidentifier() for text in some[:2]):
            return None
        out.append((some[0], some[1]))
    return out


def modules_beside(main: Path) -> list[Path]:
    """The other modules of a program: those that NAME.pgf beside NAME.mod lists. Raises ProgramError for one that is missing."""
    listing = next((f for f in main.parent.iterdir() if f.name.lower() == f"{main.stem.lower()}.pgf"), None)
    if listing is None or not listing.is_file():
        return []
    files = {f.name.lower(): f for f in main.parent.iterdir() if f.is_file()}
    out = []
    for name in _LISTED.findall(bytes_of(listing, _LONGEST_LIST).decode("latin-1")):
        file = files.get(name.lower())
        if name.lower() == main.name.lower() or name.lower().endswith(".sys"):
            continue
        if file is None:
            raise ProgramError(
                f"lists {shown(name)}, which is not beside it", hint="keep a program's files together", path=listing
            )
        out.append(file)
    return out
