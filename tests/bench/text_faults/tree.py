"""A program's lines as a small syntax tree, of which edits make new programs. Regular expressions; nothing of camrob."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_POINT = re.compile(r"\{\s*(?:(E6POS|E6AXIS|POS|AXIS|FRAME)\s*:)?([^{}]*)\}")
_FIELD = re.compile(rf"\s*([A-Z]\d?)\s+({NUMBER})\s*")
_MOTION = re.compile(r"(PTP|LIN|CIRC)\s+(\{.*\})(.*)")
_KINDS = (
    ("header", re.compile(r"&.*")),
    ("fold", re.compile(r";\s*FOLD\b.*")),
    ("endfold", re.compile(r";\s*ENDFOLD\b.*")),
    ("comment", re.compile(r";.*")),
    ("def", re.compile(r"DEF\s+(?P<name>\w+)\s*\(.*\)")),
    ("end", re.compile(r"END")),
    ("ext", re.compile(r"EXT\s+(?P<name>\w+)\s*\(.*")),
    ("bas", re.compile(r"BAS\s*\(.*\)")),
    ("wait", re.compile(r"WAIT SEC\s+(?P<value>.*)")),
    ("halt", re.compile(r"HALT\b.*")),
    ("set", re.compile(r"(?P<name>\$?[\w.]+(?:\[\d+\])?)\s*=\s*(?P<value>[^;=]*?)\s*(?:;.*)?")),
    ("call", re.compile(r"(?P<name>[A-Za-z]\w*)\s*\(\s*\)")),
)


@dataclass(frozen=True)
class Point:
    """An aggregate `{E6POS: X 1.0,Y 2.0}`: its type (empty where it has none) and its fields as written."""

    kind: str
    fields: tuple[tuple[str, str], ...]

    @property
    def values(self) -> dict[str, float]:
        return {name: float(text) for name, text in self.fields}

    def put(self, name: str, text: str) -> Point:
        """The point with another text in a field, which is there or is added."""
        if name not in dict(self.fields):
            return replace(self, fields=(*self.fields, (name, text)))
        return replace(self, fields=tuple((n, text if n == name else t) for n, t in self.fields))

    def moved(self, **by: float) -> Point:
        """The point with numbers added to fields, in the decimals that stand there."""
        point = self
        for name, step in by.items():
            old = dict(self.fields)[name]
            point = point.put(name, f"{float(old) + step:.{decimals(old)}f}")
        return point

    def without(self, *names: str) -> Point:
        return replace(self, fields=tuple(f for f in self.fields if f[0] not in names))

    def __str__(self) -> str:
        return "{" + (f"{self.kind}: " if self.kind else "") + ",".join(f"{n} {t}" for n, t in self.fields) + "}"


@dataclass(frozen=True)
class Node:
    """A line. kind: `ptp`, `lin`, `circ`, one of _KINDS, `blank` or `other`.

    points, tail: of motions (` C_DIS`). name, value: what is assigned, defined or called.
    """

    kind: str
    text: str
    points: tuple[Point, ...] = ()
    tail: str = ""
    name: str = ""
    value: str = ""

    @property
    def moves(self) -> bool:
        return self.kind in ("ptp", "lin", "circ")

    @property
    def axes(self) -> bool:
        return self.moves and self.points[-1].kind in ("E6AXIS", "AXIS")

    def with_points(self, *points: Point, kind: str = "", tail: str | None = None) -> Node:
        """The motion with other points, another word or another tail."""
        kind = kind or self.kind
        tail = self.tail if tail is None else tail
        return Node(kind, f"{kind.upper()} {','.join(map(str, points))}{tail}", points, tail)


def decimals(text: str) -> int:
    """Digits behind the point of a number."""
    return len(text.partition(".")[2])


def parse(line: str) -> Node:
    """A line as a node."""
    bare = line.strip()
    if not bare:
        return Node("blank", line)
    if motion := _MOTION.fullmatch(bare):
        points = tuple(_point(*found) for found in _POINT.findall(motion[2]))
        if all(points) and ",".join("{" + k + "}" for k in re.findall(r"\{([^{}]*)\}", motion[2])) == motion[2]:
            return Node(motion[1].lower(), line, tuple(p for p in points if p), motion[3])
        return Node("other", line)
    for kind, pattern in _KINDS:
        if found := pattern.fullmatch(bare):
            groups = found.groupdict()
            return Node(kind, line, name=groups.get("name") or "", value=(groups.get("value") or "").strip())
    return Node("other", line)


def _point(kind: str, text: str) -> Point | None:
    fields = [_FIELD.fullmatch(part) for part in text.split(",")]
    if not all(fields):
        return None
    return Point(kind, tuple((f[1], f[2]) for f in fields if f))


@dataclass(frozen=True)
class At:
    """The place of a line: file and index, from 0."""

    file: str
    index: int


@dataclass(frozen=True, eq=False)
class Tree:
    """A program: file name to its lines as nodes; `.dat` too. main: the file that is called. The same only as itself."""

    main: str
    files: Mapping[str, tuple[Node, ...]]

    @classmethod
    def of(cls, main: str, files: Mapping[str, str]) -> Tree:
        return cls(main, {name: tuple(parse(line) for line in text.splitlines()) for name, text in files.items()})

    def texts(self) -> dict[str, str]:
        """File name to text."""
        return {name: "".join(node.text + "\r\n" for node in nodes) for name, nodes in self.files.items()}

    def at(self, place: At) -> Node:
        return self.files[place.file][place.index]

    def order(self) -> list[At]:
        """Every line of the main program in its order of execution, lines of subprograms in the place of their call."""
        out: list[At] = []
        self._follow(self.main, out)
        return out

    def _follow(self, file: str, out: list[At]) -> None:
        for index, node in enumerate(self.files[file]):
            out.append(At(file, index))
            if node.kind == "call" and f"{node.name}.src" in self.files:
                self._follow(f"{node.name}.src", out)

    def edit(self, changes: Mapping[At, Iterable[Node | str]]) -> Tree:
        """The tree with lines replaced by none, one or several."""
        files = {}
        for name, nodes in self.files.items():
            lines: list[Node] = []
            for index, node in enumerate(nodes):
                new = changes.get(At(name, index))
                lines += [node] if new is None else [n if isinstance(n, Node) else parse(n) for n in new]
            files[name] = tuple(lines)
        return Tree(self.main, files)

    def put(self, place: At, *lines: Node | str) -> Tree:
        """The tree with a line replaced."""
        return self.edit({place: lines})

    def before(self, place: At, *lines: Node | str) -> Tree:
        return self.put(place, *lines, self.at(place))

    def after(self, place: At, *lines: Node | str) -> Tree:
        return self.put(place, self.at(place), *lines)

    def lines_of_end(self, file: str) -> At:
        """The last END of a file."""
        return At(file, max(k for k, node in enumerate(self.files[file]) if node.kind == "end"))

    def put_text(self, old: str, new: str) -> Tree:
        """The tree with the first line of a text replaced, wherever it has gone."""
        for name, nodes in self.files.items():
            for k, node in enumerate(nodes):
                if node.text == old:
                    return self.put(At(name, k), new)
        raise ValueError(f"no line {old!r}")

    def in_list(self, *declarations: str) -> Tree:
        """The tree with declarations in the program's .dat."""
        name = self.main.replace(".src", ".dat")
        last = max(k for k, node in enumerate(self.files[name]) if node.text.strip() == "ENDDAT")
        return self.before(At(name, last), *declarations)

    def with_file(self, name: str, text: str | None) -> Tree:
        """The tree with a file added, replaced, or (None) taken away."""
        files = {n: nodes for n, nodes in self.files.items() if n != name}
        if text is not None:
            files[name] = tuple(parse(line) for line in text.splitlines())
        return Tree(self.main, files)


def difference(old: Tree, new: Tree, most: int = 8) -> str:
    """The edit, as lines taken out (-) and put in (+), with line numbers of the old file."""
    lines = []
    before, after = old.texts(), new.texts()
    for name in sorted({*before, *after}):
        a, b = before.get(name, "").splitlines(), after.get(name, "").splitlines()
        if a and not b:
            lines.append(f"{name} taken away")
            continue
        if b and not a:
            lines.append(f"{name} added: {' / '.join(b)}"[:300])
            continue
        for tag, i, j, k, m in difflib.SequenceMatcher(None, a, b, autojunk=False).get_opcodes():
            if tag != "equal":
                lines += [f"{name}:{n + 1} - {a[n]}" for n in range(i, j)]
                lines += [f"{name}:{i + 1} + {b[n]}" for n in range(k, m)]
    if len(lines) > most:
        lines = [*lines[:most], f"... {len(lines) - most} more"]
    return "\n".join(lines) or "nothing in the lines"
