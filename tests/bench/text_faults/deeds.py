"""What a program text makes the machine do, for the plain part of KRL: an interpreter of the bench's own.

It follows calls, IF with TRUE or FALSE, FOR with numbers, GOTO and RETURN; anything else that might act is `OpaqueError`.
Millimetres, degrees, m/s.
"""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from text_faults.tree import Node, Tree, parse

_LONGEST = 5000
_AGGREGATE = re.compile(r"\{([^{}]*)\}")
_FRAMES = ("$BASE", "$TOOL")
_HARMLESS = re.compile(r"\$(ADVANCE|ACC\.\w+|VEL\.ORI[12]|ORI_TYPE|CIRC_TYPE|APO\.\w+|ACT_EX_AX)")


class OpaqueError(Exception):
    """A statement whose meaning this interpreter doesn't know."""


@dataclass(frozen=True)
class Deed:
    """A motion (`ptp`, `lin`, `circ`), or a `wait` or `halt`, with everything in force.

    target, via: fields of the whole pose, those left out filled in; axis values for a PTP to axes. state: outputs.
    """

    kind: str
    target: Mapping[str, float] = field(default_factory=dict)
    via: Mapping[str, float] = field(default_factory=dict)
    speed: float = 0.0
    rounded: str = ""
    seconds: float = 0.0
    state: tuple[tuple[str, str], ...] = ()
    settings: tuple[tuple[str, str], ...] = ()


def deeds(tree: Tree) -> tuple[list[Deed], tuple[tuple[str, str], ...]]:
    """All deeds in order, and the outputs that remain. Raises OpaqueError."""
    machine = _Machine(tree)
    machine.call(tree.main.removesuffix(".src"))
    return machine.out, machine.outputs()


class _Machine:
    def __init__(self, tree: Tree) -> None:
        self.routines = _routines(tree)
        self.tree = tree
        self.out: list[Deed] = []
        self.set: dict[str, str] = {}
        self.pose: dict[str, float] = {}
        self.speed = 0.0
        self.steps = 0

    def outputs(self) -> tuple[tuple[str, str], ...]:
        """Those that are on; the speed asked of the spindle only while it turns."""
        turns = self.set.get("$OUT[1]") == "TRUE"
        on = {k: v for k, v in self.set.items() if k.startswith("$OUT[") and v != "FALSE"}
        analog = {k: v for k, v in self.set.items() if k.startswith("$ANOUT[") and (turns or k != "$ANOUT[1]")}
        return tuple(sorted({**on, **analog}.items()))

    def settings(self) -> tuple[tuple[str, str], ...]:
        return tuple(sorted((k, v) for k, v in self.set.items() if not k.startswith(("$OUT[", "$ANOUT["))))

    def call(self, name: str) -> None:
        """Run a routine. Raises OpaqueError."""
        if name.upper() not in self.routines:
            raise OpaqueError(f"{name} is not there")
        body = self.routines[name.upper()]
        labels = {
            n.text.strip()[:-1].upper(): k for k, n in enumerate(body) if re.fullmatch(r"\s*[A-Za-z]\w*:", n.text)
        }
        k, loops = 0, []  # type: int, list[list[int]]
        while k < len(body):
            self.steps += 1
            if self.steps > _LONGEST:
                raise OpaqueError("without end")
            text = body[k].text.strip()
            if found := re.fullmatch(r"IF (TRUE|FALSE) THEN", text):
                k = k + 1 if found[1] == "TRUE" else _closing(body, k) + 1
            elif found := re.fullmatch(r"FOR \w+ = (\d+) TO (\d+)", text):
                loops.append([k, int(found[2]) - int(found[1])])
                k += 1
            elif text == "ENDFOR" and loops:
                loops[-1][1] -= 1
                k = loops[-1][0] + 1 if loops[-1][1] >= 0 else k + 1
                if k > loops[-1][0] + 1:
                    loops.pop()
            elif (found := re.fullmatch(r"GOTO (\w+)", text)) and found[1].upper() in labels:
                k = labels[found[1].upper()]
            elif text == "RETURN":
                return
            else:
                if text != "ENDIF" and not re.fullmatch(r"[A-Za-z]\w*:|DECL INT \w+|INT \w+", text):
                    self.do(body[k])
                k += 1

    def do(self, node: Node) -> None:
        """One plain statement. Raises OpaqueError."""
        if node.kind in ("comment", "fold", "endfold", "blank", "ext", "header", "def"):
            return
        if node.moves:
            self.move(node)
        elif node.kind == "call":
            self.call(node.name)
        elif node.kind in ("wait", "halt"):
            seconds = _number(node.value) if node.kind == "wait" else 0.0
            self.out.append(Deed(node.kind, seconds=seconds, state=self.outputs()))
        elif node.kind == "bas" and re.fullmatch(r"BAS\s*\(\s*#(INITMOV|VEL_PTP)\s*,\s*\d+\s*\)", node.text.strip()):
            self.set["BAS"] = node.text.replace(" ", "")
        elif node.kind == "set":
            self.assign(node.name.upper(), node.value)
        else:
            raise OpaqueError(node.text)

    def assign(self, name: str, value: str) -> None:
        """One assignment to a variable of the system. Raises OpaqueError."""
        if name == "$VEL.CP":
            self.speed = _number(value)
        elif re.fullmatch(r"\$OUT\[\d+\]", name) and value.upper() in ("TRUE", "FALSE"):
            self.set[name] = value.upper()
        elif re.fullmatch(r"\$ANOUT\[\d+\]", name):
            self.set[name] = f"{_number(value):.5f}"
        elif name in _FRAMES:
            self.set[name] = _frame(value)
        elif _HARMLESS.fullmatch(name):
            self.set[name] = value if value.startswith("#") else f"{_number(value):.5f}"
        else:
            raise OpaqueError(f"{name} = {value}")

    def move(self, node: Node) -> None:
        """One motion. Raises OpaqueError for a pose of which not all is known."""
        tail = node.tail.partition(";")[0].strip()
        if tail not in ("", "C_DIS"):
            raise OpaqueError(node.text)
        if not all(math.isfinite(v) for p in node.points for v in p.values.values()):
            raise OpaqueError("no number")
        if len(node.points) != (2 if node.kind == "circ" else 1):
            raise OpaqueError(node.text)
        filled = [{**self.pose, **p.values} for p in node.points]
        target = dict(node.points[-1].values) if node.axes else filled[-1]
        if not node.axes and not all(k in target for k in ("X", "Y", "Z", "A", "B", "C", "E1", "E2")):
            raise OpaqueError("a pose of which not all is known")
        via = filled[0] if node.kind == "circ" else {}
        speed = 0.0 if node.kind == "ptp" else self.speed
        self.out.append(Deed(node.kind, target, via, speed, tail, 0.0, self.outputs(), self.settings()))
        kept = {k: v for k, v in target.items() if k.startswith("E")} if node.axes else dict(target)
        self.pose = {k: v for k, v in kept.items() if k not in ("S", "T")}


def _routines(tree: Tree) -> dict[str, list[Node]]:
    """Name to body; local ones of the main file win. Raises OpaqueError for a file that is not made of routines."""
    found: dict[str, list[Node]] = {}
    files = [f for f in tree.files if f.endswith(".src") and f != tree.main]
    for file in (*files, tree.main):
        body: list[Node] | None = None
        for node in tree.files[file]:
            if node.kind == "def":
                body = found[node.name.upper()] = []
            elif node.kind == "end":
                body = None
            elif body is not None:
                body.append(node)
            elif node.kind not in ("header", "blank", "comment"):
                raise OpaqueError(f"{node.text} outside of a routine")
    return found


def _closing(body: list[Node], k: int) -> int:
    depth = 0
    for index in range(k, len(body)):
        text = body[index].text.strip()
        depth += text.startswith("IF ")
        depth -= text == "ENDIF"
        if not depth:
            return index
    raise OpaqueError("IF without ENDIF")


def _number(text: str) -> float:
    """A number, or numbers with + - * /. Raises OpaqueError."""
    if not re.fullmatch(r"[-+*/(). 0-9eE]+", text):
        raise OpaqueError(text)
    return float(_value(ast.parse(text.strip(), mode="eval").body))


def _value(node: ast.expr) -> float:
    if isinstance(node, ast.Constant):
        return float(node.value)  # type: ignore[arg-type]
    if isinstance(node, ast.UnaryOp):
        return -_value(node.operand)
    if isinstance(node, ast.BinOp):
        a, b = _value(node.left), _value(node.right)
        return {ast.Add: a + b, ast.Sub: a - b, ast.Mult: a * b, ast.Div: a / (b or 1.0)}[type(node.op)]
    raise OpaqueError(ast.dump(node))


def _frame(value: str) -> str:
    """A frame's value in one spelling. Raises OpaqueError."""
    found = _AGGREGATE.findall(value)
    if len(found) != 1:
        raise OpaqueError(value)
    point = parse("LIN {" + found[0].removeprefix("FRAME:") + "}")
    if point.kind != "lin":
        raise OpaqueError(value)
    numbers = point.points[0].values
    text = ",".join(f"{k} {numbers.get(k, 0.0):.4f}" for k in "XYZABC")
    return re.sub(r"\s", "", _AGGREGATE.sub("", value)).upper() + text
