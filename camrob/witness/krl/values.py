"""KRL expressions and the variables that they name.

A value is a number, a truth, a string, an enumeration's word ("#BASE") or an aggregate (a dict from component to value, its type
under ""). What a program can't know by itself (inputs, the robot's position, undeclared names) raises `UnknownError`.
"""

from __future__ import annotations

import copy
import math
import operator
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from camrob.witness.krl.functions import FUNCTIONS, Inexact, UnknownError, Value, chained, compared, reckoned, rounded
from camrob.witness.krl.scope import Scope

__all__ = ["UnknownError", "Value", "Variables", "split_top"]

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:E[-+]?\d+)?)(?![A-Z_$])"
    r"|'(?P<bits>B[01]+|H[0-9A-F]+)'"
    r'|"(?P<text>[^"]*)"'
    r"|(?P<name>[#$A-Z_][A-Z0-9_$]*)"
    r"|(?P<sign><=|>=|==|<>|[-+*/(){}\[\],.:<>]))"
)
# comparisons bind loosest of all ("Expert Programming", priority of operators): A OR B == C is (A OR B) == C
_BINARY: tuple[dict[str, Callable[..., Value]], ...] = (
    {"==": operator.eq, "<>": operator.ne, "<": operator.lt, ">": operator.gt, "<=": operator.le, ">=": operator.ge},
    {"OR": operator.or_, "B_OR": operator.or_},
    {"EXOR": operator.xor, "B_EXOR": operator.xor},
    {"AND": operator.and_, "B_AND": operator.and_},
    {"+": operator.add, "-": operator.sub},
    {"*": operator.mul, "/": operator.truediv},
    {":": chained},
)
_TRUTHS, _BITS = ("OR", "EXOR", "AND"), ("B_OR", "B_EXOR", "B_AND")
_INDEX = re.compile(r"\[([^\[\]]*)\]")
_PAIR = r"[A-Z][A-Z0-9_]* -?\d+(?:\.\d+)?"
_PLAIN = re.compile(rf"\{{ ?(?:(?P<type>[A-Z][A-Z0-9_]*) ?: ?)?(?P<pairs>{_PAIR}(?: ?, ?{_PAIR})*) ?\}}")
_REALS = frozenset("X Y Z A B C A1 A2 A3 A4 A5 A6 E1 E2 E3 E4 E5 E6".split())  # components that are REAL
_WHOLE_DIGITS = 10  # of a number without a point: KRL's largest INT has ten
_LARGEST = 2**53  # beyond it a double no longer tells whole numbers apart
_DEEP = 40  # brackets in brackets: no honest program nests deeper


def split_top(text: str, mark: str = ",") -> list[str]:
    """Splits at `mark`, but not within brackets or quotes."""
    parts, depth, quoted, start = [], 0, False, 0
    for i, letter in enumerate(text):
        if letter == '"':
            quoted = not quoted
        elif not quoted and letter in "({[":
            depth += 1
        elif not quoted and letter in ")}]":
            depth -= 1
        elif letter == mark and depth == 0 and not quoted:
            parts.append(text[start:i])
            start = i + 1
    return [part.strip() for part in (*parts, text[start:])]


def _no_function(name: str, texts: list[str]) -> Value:
    """No program, no functions."""
    raise UnknownError(f"{name}() is not at hand")


@dataclass(slots=True)
class Variables:
    """What the names stand for: the routine's own, its module's (.dat), those of all."""

    own: Scope = field(default_factory=Scope)
    module: Scope = field(default_factory=Scope)
    common: Scope = field(default_factory=Scope)
    known: set[str] = field(default_factory=set)  # declared without a value
    kept: dict[tuple[int, str], Value | None] = field(
        default_factory=dict
    )  # of data lists: what was there before a change
    asked: dict[str, Callable[[], Value]] = field(default_factory=dict)  # system variables that are worked out
    whole: set[str] = field(default_factory=set)  # components of the program's own structures that are INT
    function: Callable[[str, list[str]], Value] = (
        _no_function  # by name and what it is handed: one that the program brings
    )
    changes: int = 0  # of variables that are not the running routine's own

    def find(self, name: str) -> Value:
        """The value of a name such as X, X[3] or X.Y; raises UnknownError."""
        head, *parts = name.split(".")
        if head in self.asked:
            value = self.asked[head]()
        else:
            place = self._holder(head)
            if place is None or head not in place:
                known = place is not None or head.split("[")[0] in self.known
                raise UnknownError(f"{name} has no value here" if known else f"{name} is not known here")
            value = place[head]
        for part in parts:
            if not isinstance(value, dict) or part not in value:
                raise UnknownError(f"{name} has no value here")
            value = value[part]
            if part in _REALS and isinstance(value, int) and part not in self.whole:
                value = float(value)
        return value

    def _holder(self, head: str) -> Scope | None:
        """The innermost scope that has X or X[3], or has declared X: another scope's X is another variable."""
        bare = head.split("[")[0]
        places = (self.own, self.module, self.common)
        return next((place for place in places if head in place or bare in place.kinds), None)

    def forget(self, name: str) -> None:
        """A variable whose value is no longer known."""
        head = name.split(".")[0]
        holder, bare = self._holder(head), head.split("[")[0]
        place = self.module if holder is None else holder  # an empty scope is one, too
        self.keep(place, head)
        place.pop(head, None)
        place.lost.add(head)
        place.kinds.setdefault(bare, "")
        self.known.add(bare)

    def elements(self, name: str) -> dict[str, Value]:
        """The elements of an array that have values, by their index in its brackets."""
        place = next((p for p in (self.own, self.module, self.common) if name in p.kinds), Scope())
        return {key[len(name) :]: value for key, value in place.items() if key.startswith(name + "[")}

    def declared(self, name: str) -> bool:
        """True where a scope that is in reach declares the name."""
        return any(name in place.kinds for place in (self.own, self.module, self.common))

    def knows(self, name: str) -> bool:
        """True where the name is declared, with a value or without."""
        head = name.split(".")[0]
        bare = head.split("[")[0]
        return bare in self.known or any(
            head in place or bare in place for place in (self.own, self.module, self.common)
        )

    def put(self, name: str, value: Value) -> None:
        """Sets X, X[3] or a component X.Y, where it stands."""
        head, *parts = name.split(".")
        place = self._holder(head)
        place = self.module if place is None else place
        self.keep(place, head)
        if not parts:
            place.put(head, value)
            return
        if head in place.lost:
            raise UnknownError(f"the rest of {head} isn't known")
        node = place.setdefault(head, {})
        for part in parts[:-1]:
            if not isinstance(node, dict):
                raise UnknownError(f"{name} is not an aggregate")
            node = node.setdefault(part, {})
        if not isinstance(node, dict):
            raise UnknownError(f"{name} is not an aggregate")
        if parts[-1] in self.whole and isinstance(value, float):
            whole = rounded(value)
            if whole is None:
                node.pop(parts[-1], None)
                return
            value = whole
        node[parts[-1]] = copy.deepcopy(value) if isinstance(value, dict) else value

    def indexed(self, name: str) -> str:
        """A name with its indices worked out: P[I+1].X as P[3].X; raises UnknownError."""
        return _INDEX.sub(
            lambda found: f"[{','.join(str(self.value(part)) for part in split_top(found[1]) if part)}]", name
        )

    def keep(self, place: Scope, head: str) -> None:
        """Notes what a data list had, which outlives the run, before it is changed for the first time."""
        if place is not self.own:
            self.changes += 1
            self.kept.setdefault((id(place), head), copy.deepcopy(place.get(head)))

    def value(self, text: str) -> Value:
        """The value of an expression; raises UnknownError."""
        plain = _PLAIN.fullmatch(text)
        if plain is not None:  # nearly every point is such a one: numbers alone
            pairs = [pair.split() for pair in plain["pairs"].split(",")]
            points: dict[str, Value] = {name: _number(text) for name, text in pairs}
            if len(points) == len(pairs):
                return {"": plain["type"], **points} if plain["type"] else points
        reader = _Reader(text, self)
        value = reader.binary(0)
        if reader.kind:
            raise UnknownError(f"{text} can't be read")
        return value

    def number(self, text: str) -> float:
        """The finite number that an expression stands for; raises UnknownError."""
        value = self.value(text)
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise UnknownError(f"{text} is not a number")
        return float(value)

    def truth(self, text: str) -> bool:
        """The truth that an expression stands for; raises UnknownError."""
        value = self.value(text)
        if not isinstance(value, bool):
            raise UnknownError(f"{text} is neither TRUE nor FALSE")
        return value


def _number(text: str) -> int | float:
    """A number as it is written: whole where it has neither point nor exponent, and KRL has so large an INT."""
    return int(text) if text.lstrip("-").isdigit() and len(text) <= _WHOLE_DIGITS else float(text)


class _Reader:
    """Recursive descent over one expression."""

    def __init__(self, text: str, variables: Variables) -> None:
        self.text, self.variables, self.depth = text, variables, 0
        self.place = 0  # of the token that is next
        self.tokens = self._tokens()
        self.kind, self.token = next(self.tokens)

    def _tokens(self, at: int = 0) -> Iterator[tuple[str, str]]:
        while at < len(self.text):
            match = _TOKEN.match(self.text, at)
            if match is None:
                if self.text[at:].strip():
                    raise UnknownError(f"{self.text} can't be read")
                break
            at = match.end()
            self.place = match.start(match.lastgroup or 0)
            yield match.lastgroup or "", match[match.lastgroup or 0]
        while True:
            yield "", ""

    def step(self) -> str:
        token = self.token
        self.kind, self.token = next(self.tokens)
        return token

    def expect(self, token: str) -> None:
        if self.kind == "text" or self.step() != token:
            raise UnknownError(f"{self.text} can't be read")

    def binary(self, level: int) -> Value:
        """Operators of this level and tighter ones."""
        if level == len(_BINARY):
            return self.single()
        left = self.binary(level + 1)
        while self.kind in ("sign", "name") and self.token in _BINARY[level]:
            sign = self.step()
            left = self.reckon(sign, _BINARY[level][sign], left, self.binary(level + 1))
        return left

    def reckon(self, sign: str, act: Callable[..., Value], left: Value, right: Value) -> Value:
        kinds = [next(k for k in (bool, int, float, str, dict) if isinstance(side, k)) for side in (left, right)]
        whole = kinds == [int, int]
        numbers = all(kind in (int, float) for kind in kinds)
        wanted = {":": True, **dict.fromkeys(_TRUTHS, kinds == [bool, bool]), **dict.fromkeys(_BITS, whole)}
        try:
            if not wanted.get(sign, numbers or (kinds[0] == kinds[1] and sign in ("==", "<>"))):
                raise TypeError(f"{sign} doesn't take these; comparisons stand in brackets beside AND and OR")
            if sign in _BINARY[0] and numbers:
                return compared(act, left, right)  # type: ignore[arg-type]
            value = int(left / right) if sign == "/" and whole else act(left, right)  # type: ignore[operator]
            if isinstance(value, int) and abs(value) > _LARGEST:
                raise OverflowError("it gets larger than KRL's whole numbers")
            return reckoned(value, left, right)
        except (TypeError, ZeroDivisionError, OverflowError) as failure:
            raise UnknownError(f"{self.text} can't be worked out ({failure})") from failure

    def single(self) -> Value:
        """A sign, NOT, a bracket, an aggregate, a number, a word, a name or a function."""
        self.depth += 1
        if self.depth > _DEEP:
            raise UnknownError("the brackets nest too deep")
        try:
            return self._single()
        finally:
            self.depth -= 1

    def _single(self) -> Value:
        kind, token = self.kind, self.step()
        if kind == "number":
            return _number(token)
        if kind == "bits":
            return int(token[1:], 2 if token[0] == "B" else 16)
        if kind == "text":
            return f'"{token}"'
        if kind == "sign" and token in "+-":
            value = self.single()
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise UnknownError(f"{self.text} can't be worked out")
            return value if token == "+" else Inexact(-value) if isinstance(value, Inexact) else -value
        if kind == "sign" and token == "(":
            value = self.binary(0)
            self.expect(")")
            return value
        if kind == "sign" and token == "{":
            return self.aggregate()
        if kind == "name":
            return self.word(token)
        raise UnknownError(f"{self.text or 'an empty expression'} can't be read")

    def word(self, token: str) -> Value:
        if token in ("TRUE", "FALSE"):
            return token == "TRUE"
        if token.startswith("#"):
            return token
        if token == "NOT":
            value = self.single()
            if not isinstance(value, bool):
                raise UnknownError(f"{self.text} can't be worked out")
            return not value
        if self.kind == "sign" and self.token == "(":
            if token not in FUNCTIONS:
                return self.variables.function(token, self.handed())
            count, act = FUNCTIONS[token]
            arguments = self.arguments()
            try:
                if len(arguments) != count:
                    raise TypeError(f"{token} takes {count}")
                return act(*arguments)
            except (ValueError, TypeError) as failure:
                raise UnknownError(f"{self.text} can't be worked out ({failure})") from failure
        name = token
        while self.kind == "sign" and self.token in "[.":
            if self.step() == ".":
                name += "." + self.step()
            else:
                name += f"[{self.index()}]"
        return self.variables.find(name)

    def arguments(self) -> list[Value]:
        """Values between brackets, which are ahead."""
        self.expect("(")
        values = [self.binary(0)]
        while self.token == "," and self.kind == "sign":
            self.step()
            values.append(self.binary(0))
        self.expect(")")
        return values

    def handed(self) -> list[str]:
        """The texts between brackets, which are ahead: a function of the program's takes variables, not their values."""
        begin, depth, quoted = self.place + 1, 1, False
        for end in range(begin, len(self.text)):
            letter = self.text[end]
            quoted ^= letter == '"'
            depth += 0 if quoted else (letter in "([{") - (letter in ")]}")
            if not depth:
                self.tokens = self._tokens(end + 1)
                self.kind, self.token = next(self.tokens)
                inside = self.text[begin:end]
                return split_top(inside) if inside.strip() else []
        raise UnknownError(f"{self.text} can't be read")

    def index(self) -> str:
        """What stands between square brackets, as text."""
        if self.kind == "sign" and self.token == "]":
            self.step()
            return ""
        values = [self.binary(0)]
        while self.token == ",":
            self.step()
            values.append(self.binary(0))
        self.expect("]")
        return ",".join(str(value) for value in values)

    def aggregate(self) -> dict[str, Value]:
        """{TYPE: X 1,Y 2}; the opening bracket is behind us."""
        out: dict[str, Value] = {}
        while True:
            if self.kind != "name" or self.token in out:
                raise UnknownError(f"{self.text} can't be read")
            name = self.step()
            if self.token == ":" and not out:
                self.step()
                out[""] = name
                continue
            while self.token == "[" and self.kind == "sign":
                self.step()
                name += f"[{self.index()}]"
            out[name] = self.binary(0)
            if self.token != ",":
                break
            self.step()
        self.expect("}")
        return out
