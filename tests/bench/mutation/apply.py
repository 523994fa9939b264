"""Puts a mutant into a warm process: new code in old function objects, so that every holder of the function has it.

Compiled kernels are replaced by their own Python text, with all kernels that call them, up to the first caller in Python.
"""

from __future__ import annotations

import ast
import functools
import gc
import importlib
import os
import sys
import types
from collections.abc import Container, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mutation.draw import Mutant, draw, in_scope

PACKAGE = "camrob"
# Kernels that mean something else uncompiled (they count in bytes, whose sums wrap round there): compiled anew.
COMPILED = ("goto_kernel", "krl_scan", "csv_numbers")


class CannotApplyError(Exception):
    """The change has no place to go: the function does not exist at run time, or its closure would be another."""


@dataclass
class Source:
    """A module of the package: its tree, and its mutants, which hang in the tree."""

    name: str
    path: Path
    mutants: list[Mutant]


@dataclass
class Package:
    """The package as it was imported: functions by file and qualified name, kernels and who calls them."""

    sources: dict[str, Source] = field(default_factory=dict)
    functions: dict[tuple[str, str], list[types.FunctionType]] = field(default_factory=dict)
    kernels: dict[str, Any] = field(default_factory=dict)  # "module:name" -> Kernel or part
    callers: dict[str, set[str]] = field(default_factory=dict)  # of a kernel: the kernels that call it
    caches: list[Any] = field(default_factory=list)
    names: dict[tuple[str, str], set[str]] = field(default_factory=dict)  # that a function's code mentions
    callers_in_python: dict[frozenset[str], set[tuple[str, str]]] = field(default_factory=dict)
    remembered: set[tuple[str, str]] = field(default_factory=set)  # functions that run beneath a cache


def modules() -> Iterator[types.ModuleType]:
    """The package's modules that are loaded."""
    for name, module in sorted(sys.modules.items()):
        if (name == PACKAGE or name.startswith(PACKAGE + ".")) and getattr(module, "__file__", None):
            yield module


def load(only: Container[str] | None = None) -> Package:
    """The package with every module of the scope imported. only: last names of the modules whose mutants are drawn."""
    root = Path(str(importlib.import_module(PACKAGE).__file__)).parent
    for path in sorted(root.rglob("*.py")):
        name = ".".join((PACKAGE, *path.relative_to(root).with_suffix("").parts))
        if in_scope(name) and not name.endswith("__init__"):
            importlib.import_module(name)
    kept = importlib.import_module(f"{PACKAGE}.redundancy.fuzzy.kept")
    kept.cache_folder = lambda: Path(os.devnull)  # what was kept there was made by the code without its mutant
    package = Package()
    for module in modules():
        if in_scope(module.__name__) and not str(module.__file__).endswith("__init__.py"):
            path = Path(str(module.__file__))
            drawn = only is None or module.__name__.rsplit(".", 1)[-1] in only
            found = draw(module.__name__, path) if drawn else []
            package.sources[module.__name__] = Source(module.__name__, path, found)
    for thing in gc.get_objects():
        if isinstance(thing, types.FunctionType) and f"/{PACKAGE}/" in thing.__code__.co_filename:
            place = (thing.__code__.co_filename, thing.__code__.co_qualname)
            package.functions.setdefault(place, []).append(thing)
            package.names.setdefault(place, set()).update(_names(thing.__code__))
        elif isinstance(thing, functools._lru_cache_wrapper) and str(thing.__module__).startswith(PACKAGE):
            package.caches.append(thing)
    _kernels(package)
    return package


def _kernels(package: Package) -> None:
    for module in modules():
        for thing in vars(module).values():
            python = getattr(thing, "py_func", thing if hasattr(thing, "part_of_kernels") else None)
            if python is not None and python.__module__ == module.__name__:
                package.kernels[f"{module.__name__}:{python.__qualname__}"] = thing
    names = {id(thing): name for name, thing in package.kernels.items()}
    for name, thing in package.kernels.items():
        python = _python(thing)
        for used in python.__code__.co_names:
            called = names.get(id(python.__globals__.get(used)))
            if called is not None:
                package.callers.setdefault(called, set()).add(name)


def chain(package: Package, kernel: str) -> frozenset[str]:
    """A kernel with all that call it, directly or not."""
    found, left = set(), [kernel]
    while left:
        name = left.pop()
        if name not in found:
            found.add(name)
            left += package.callers.get(name, ())
    return frozenset(found)


def touched_kernels(package: Package, mutant: Mutant) -> frozenset[str]:
    """The kernels that have to run uncompiled for a mutant to show."""
    if mutant.kind != "constant":
        kernel = f"{mutant.module}:{mutant.name}"
        return chain(package, kernel) if kernel in package.kernels else frozenset()
    old = getattr(sys.modules[mutant.module], mutant.name, None)
    found: frozenset[str] = frozenset()
    for name, thing in package.kernels.items():
        python = _python(thing)
        if mutant.name in python.__code__.co_names and python.__globals__.get(mutant.name) is old:
            found |= chain(package, name)
    return found


def readers(package: Package, mutant: Mutant) -> set[tuple[str, str]]:
    """(file, qualified name) of the functions that read a module's constant."""
    old = getattr(sys.modules[mutant.module], mutant.name, None)
    return {
        place
        for place, held in package.functions.items()
        if mutant.name in package.names[place] and any(f.__globals__.get(mutant.name) is old for f in held)
    }


def _names(code: types.CodeType) -> set[str]:
    found = set(code.co_names)
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            found |= _names(constant)
    return found


def interpret(package: Package, names: frozenset[str], compiled: bool = False) -> None:
    """Replace kernels by their Python text wherever a module holds them; `compiled`: by a new compilation of it."""
    new: dict[int, Any] = {}
    for name in names:
        old = package.kernels[name]
        new[id(old)] = _compiled(old) if compiled else _python(old)
    for module in modules():
        for key, value in list(vars(module).items()):
            if id(value) in new:
                setattr(module, key, new[id(value)])
            elif isinstance(value, dict):
                for k, v in list(value.items()):
                    if id(v) in new:
                        value[k] = new[id(v)]


def _python(kernel: Any) -> Any:
    """The Python function of a kernel or a part of one, which is itself."""
    return getattr(kernel, "py_func", kernel)


def _compiled(kernel: Any) -> Any:
    import numba

    from camrob.compiled import part

    importlib.import_module("camrob.compiler")  # Numba has to know the parts that a kernel calls
    if hasattr(kernel, "part_of_kernels"):  # another function: what Numba knows of this one, it keeps
        f = kernel
        return part(types.FunctionType(f.__code__, f.__globals__, f.__name__, f.__defaults__, f.__closure__))
    options = {k: v for k, v in kernel.options.items() if k in ("nogil", "fastmath", "error_model", "boundscheck")}
    return numba.njit(**options)(kernel.py_func)


def forget_caches(package: Package) -> None:
    """Empty what functions of the package remember."""
    for cache in package.caches:
        cache.cache_clear()


def apply(package: Package, mutant: Mutant) -> str:
    """Put a mutant into this process, and tell what it does. Raises CannotApplyError."""
    source = package.sources[mutant.module]
    tree = _tree_of(source)
    kernels = touched_kernels(package, mutant)
    what = mutant.what()
    ast.fix_missing_locations(tree)
    try:
        code = compile(tree, str(source.path), "exec", dont_inherit=True)
    except (SyntaxError, ValueError, TypeError) as error:
        raise CannotApplyError(str(error)) from None
    if mutant.kind == "code":
        _new_code(package, source, mutant, code)
    elif mutant.kind == "default":
        _new_default(package, source, mutant)
    else:
        _new_constant(package, mutant)
    if kernels:
        interpret(package, kernels, compiled=mutant.module.rsplit(".", 1)[-1] in COMPILED)
    if beneath_cache(package, mutant, kernels):
        forget_caches(package)
    return what


def beneath_cache(package: Package, mutant: Mutant, kernels: frozenset[str]) -> bool:
    """Whether something that the package remembers may depend on what a mutant changes."""
    if kernels:
        return bool(python_callers(package, kernels) & package.remembered)
    if mutant.kind == "constant":
        return bool(readers(package, mutant) & package.remembered)
    return (str(package.sources[mutant.module].path), mutant.name) in package.remembered


def python_callers(package: Package, kernels: frozenset[str]) -> set[tuple[str, str]]:
    """Functions in Python that call one of the kernels."""
    if kernels not in package.callers_in_python:
        wanted = {id(package.kernels[name]) for name in kernels}
        of_kernels = {id(_python(thing)) for thing in package.kernels.values()}
        package.callers_in_python[kernels] = {
            place
            for place, held in package.functions.items()
            for f in held
            if id(f) not in of_kernels and any(id(f.__globals__.get(n)) in wanted for n in package.names[place])
        }
    return package.callers_in_python[kernels]


def _tree_of(source: Source) -> ast.Module:
    return source.mutants[0].tree


def _codes(code: types.CodeType) -> Iterator[types.CodeType]:
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield constant
            yield from _codes(constant)


def _new_code(package: Package, source: Source, mutant: Mutant, module_code: types.CodeType) -> None:
    held = package.functions.get((str(source.path), mutant.name), [])
    new = {c.co_firstlineno: c for c in _codes(module_code) if c.co_qualname == mutant.name}
    done = 0
    for function in held:
        code = new.get(function.__code__.co_firstlineno)
        if code is None or function.__code__ == code:
            continue
        try:
            function.__code__ = code
        except ValueError as error:
            raise CannotApplyError(str(error)) from None
        done += 1
    if not done:
        raise CannotApplyError("the function is not held by anything, or its code stays the same")


def _new_default(package: Package, source: Source, mutant: Mutant) -> None:
    """Evaluate the defaults of a function anew."""
    held = package.functions.get((str(source.path), mutant.name), [])
    for function in held:
        arguments = _arguments(_tree_of(source), mutant.name, function.__code__.co_firstlineno)
        scope = function.__globals__
        try:
            function.__defaults__ = tuple(_value(d, scope) for d in arguments.defaults) or None
            names = [a.arg for a in arguments.kwonlyargs]
            pairs = zip(names, arguments.kw_defaults, strict=True)
            function.__kwdefaults__ = {n: _value(d, scope) for n, d in pairs if d is not None} or None
        except Exception as error:
            raise CannotApplyError(str(error)) from None
    if not held:
        raise CannotApplyError("the function is not held by anything")


def _arguments(tree: ast.Module, name: str, first_line: int) -> ast.arguments:
    body: list[ast.stmt] = tree.body
    found: ast.AST | None = None
    for part in name.split("."):
        fit = [n for n in body if getattr(n, "name", None) == part]
        at_line = [
            n for n in fit if first_line in range(n.lineno - len(getattr(n, "decorator_list", ())) - 3, n.lineno + 1)
        ]
        found = (at_line or fit or [None])[0]  # type: ignore[list-item]
        body = getattr(found, "body", [])
    if not isinstance(found, ast.FunctionDef):
        raise CannotApplyError(f"{name} is not in the tree")
    return found.args


def _value(node: ast.expr, scope: dict[str, Any]) -> Any:
    return eval(compile(ast.Expression(node), "<mutant>", "eval"), scope)


def _new_constant(package: Package, mutant: Mutant) -> None:
    """Evaluate a module's constant anew, and put it where the old one is held."""
    module = sys.modules[mutant.module]
    old = getattr(module, mutant.name, None)
    statement = mutant.statement
    if old is None or not isinstance(statement, (ast.Assign, ast.AnnAssign)) or statement.value is None:
        raise CannotApplyError("no value")
    try:
        new = _value(statement.value, vars(module))
    except Exception as error:
        raise CannotApplyError(str(error)) from None
    if isinstance(old, (type, types.FunctionType)) or type(new) is not type(old):
        raise CannotApplyError("a type or an alias")
    for other in modules():
        for key, value in list(vars(other).items()):
            if value is old and key == mutant.name:
                setattr(other, key, new)
    for function in (f for held in package.functions.values() for f in held):
        defaults = function.__kwdefaults__ or {}
        for key, value in defaults.items():
            if value is old and not isinstance(old, (int, bool, str)):
                defaults[key] = new
        if function.__defaults__ and not isinstance(old, (int, bool, str)):
            function.__defaults__ = tuple(new if v is old else v for v in function.__defaults__)
