"""Variables of a KRL program: system variables, data lists, locals of a routine."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

from camrob.errors import KrlError
from camrob.languages.krl.reader.expressions import Aggregate, Expression, Unknown, Value
from camrob.languages.krl.reader.functions import built_in, frame_product, typed
from camrob.languages.krl.reader.module import read_bytes
from camrob.languages.krl.reader.tokens import Token, shown, statement_of, tokens_of

__all__ = ["Variables", "declare", "is_declaration", "load_data"]

_CONSTANTS: dict[str, Value] = {
    "$NULLFRAME": Aggregate("FRAME", dict.fromkeys("XYZABC", 0.0)),
    "$WORLD": Aggregate("FRAME", dict.fromkeys("XYZABC", 0.0)),
    "PI": 3.14159265358979,  # as a controller has it
}
_REALS = frozenset("X Y Z A B C A1 A2 A3 A4 A5 A6 E1 E2 E3 E4 E5 E6".split())  # components that are REAL
_REAL_SETTINGS = ("$VEL.", "$ACC.", "$APO.CDIS")
_KIND = ":"  # behind a variable's name stands its type: no name of KRL's holds one
_PREFIXES = ("GLOBAL", "CONST", "DECL")
_SKIPPED = frozenset(("EXT", "EXTFCT", "IMPORT", "SIGNAL", "STRUC", "ENUM", "CHANNEL"))


class Variables:
    """Values by name. `scopes`: the locals of the running routine, its data list; `shared`: everything else; `asked`: what is
    looked up where the program asks for it; `own_function`: runs a DEFFCT.
    """

    def __init__(self) -> None:
        self.shared: dict[str, Value] = dict(_CONSTANTS)
        self.asked: dict[str, Callable[[], Value]] = {}
        self.scopes: tuple[dict[str, Value], ...] = ()
        self._whole: set[str] = set()  # components of the program's own structures that are INT
        self.own_function: Callable[[str, list[Value]], Value | None] = lambda _name, _arguments: None

    def lookup(self, path: str) -> Value:
        """The value of a variable, a field or an element; Unknown where the program doesn't give it."""
        if path in self.asked:
            return self.asked[path]()
        root, _, name = path.rpartition(".")
        whole = self.lookup(root) if root else None
        if isinstance(whole, Aggregate) and name in whole.fields:
            return typed("REAL" if name in _REALS else "", whole.fields[name])
        return self._holder(path).get(path, Unknown(path))

    def structure(self, tokens: tuple[Token, ...]) -> None:
        """Takes note of STRUC NAME TYPE A,B, TYPE C: a name behind another one is the first of its type."""
        whole = False
        for before, token in pairwise(tokens[1:-1]):
            if token.kind == "name" and before.kind == "name":
                whole = before.text == "INT"
            if whole and token.kind == "name":
                self._whole.add(token.text)

    def called(self, name: str, arguments: list[Value]) -> Value:
        """The value of a function: of one that the program brings, else of the language's own."""
        own, value = self.own_function(name, arguments), built_in(name, arguments)
        if own is not None and value is not None:
            raise KrlError(
                f"{name} is a function of KRL's, and the program brings one of its own", hint="rename that one"
            )
        value = value if own is None else own
        return Unknown(f"{name}(...)") if value is None else value

    def product(self, left: Value, right: Value) -> Value:
        """left : right, by the geometric operator."""
        return frame_product(left, right)

    def assign(self, path: str, value: Value) -> None:
        """Sets a variable, a field or an element. An index that is not known makes all elements unknown."""
        holder = self._holder(path)
        value = typed(self._kind(path, holder), value)
        root, _, name = path.rpartition(".")
        if "?" in path:
            stem = path[: path.index("[")]
            for key in [k for k in holder if k.startswith(stem + "[")]:
                holder[key] = Unknown(key)
        elif root and isinstance(whole := self.lookup(root), Aggregate):
            self.assign(root, Aggregate(whole.type, {**whole.fields, name: value}))
        else:
            holder[path] = value

    def _kind(self, path: str, holder: dict[str, Value]) -> str:
        """The type with which the variable was declared, as far as it changes a number."""
        if "." in path:
            real = path.startswith(_REAL_SETTINGS)
            return "REAL" if real else "INT" if path.rpartition(".")[2] in self._whole else ""
        return str(holder.get(path.split("[", 1)[0] + _KIND, ""))

    def _holder(self, path: str) -> dict[str, Value]:
        """The scope in which the variable was declared."""
        stem = path.split(".", 1)[0].split("[", 1)[0]
        if not stem.startswith("$"):
            for scope in self.scopes:
                if stem in scope:
                    return scope
        return self.shared


def is_declaration(tokens: tuple[Token, ...]) -> bool:
    """Whether the statement declares a variable: it has a prefix, or begins with two names."""
    if tokens[0].kind != "name" or tokens[0].text in ("INTERRUPT", *_SKIPPED):
        return False
    if tokens[0].text in _PREFIXES:
        rest = [t.text for t in tokens if t.text not in _PREFIXES]
        return rest[0] != "INTERRUPT" and rest[0] not in _SKIPPED
    return tokens[1].kind == "name" and (len(tokens) == 3 or tokens[2].text in ("=", "[", ","))


def declare(tokens: tuple[Token, ...], variables: Variables, scope: dict[str, Value]) -> None:
    """Reads `DECL TYPE NAME[n] = value, ...` into `scope`, with GLOBAL into what all files share.

    Raises KrlError, without a place, for anything else.
    """
    at = 0
    while tokens[at].kind == "name" and tokens[at].text in _PREFIXES:
        scope = variables.shared if tokens[at].text == "GLOBAL" else scope
        at += 1
    expression = Expression(tokens, variables, at)
    kind = expression.path()
    while True:
        name = expression.path()
        stem = name.split("[", 1)[0]
        scope[stem + _KIND] = kind
        scope[stem] = typed(kind, scope.get(stem, Unknown(stem)))  # of a parameter: what it was handed
        if expression.accept("="):
            scope[stem if name.endswith("[]") else name] = typed(kind, expression.value())
        if expression.next.kind == "end":
            return
        expression.expect(",")


def load_data(path: Path, variables: Variables) -> dict[str, Value]:
    """Variables of a .dat file. Raises KrlError for one that is no data list, or is cut off."""
    scope: dict[str, Value] = {}
    opened = closed = False
    for number, raw in enumerate(read_bytes(path).decode("latin-1").split("\n"), start=1):
        text = statement_of(raw)
        if not text or text.startswith("&"):
            continue
        try:
            tokens = tokens_of(text)
            word = tokens[0].text
            if word == "DEFDAT":
                opened = True
            elif word == "ENDDAT":
                closed = True
            elif not opened or closed:
                raise KrlError(f"{shown(text)!r} stands outside of DEFDAT and ENDDAT", hint="is this a KRL .dat file?")
            elif is_declaration(tokens):
                declare(tokens, variables, scope)
            elif word not in _SKIPPED and tokens[0].text not in _PREFIXES:
                _set(tokens, variables, scope)
        except KrlError as error:
            raise error.at(path, number) from None
    if not closed:
        raise KrlError("has no ENDDAT", hint="the file is cut off", path=path)
    return scope


def _set(tokens: tuple[Token, ...], variables: Variables, scope: dict[str, Value]) -> None:
    """`NAME[1] = value` in a data list."""
    expression = Expression(tokens, variables)
    name = expression.path()
    expression.expect("=")
    value = expression.value()
    stem = name.split("[", 1)[0].split(".", 1)[0]
    if name.startswith("$") or (stem in variables.shared and stem not in scope):
        variables.assign(name, value)
    else:
        scope.setdefault(stem, Unknown(name))
        scope[name] = typed(str(scope.get(stem + _KIND, "")), value)
