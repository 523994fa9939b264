"""Puts a fault that somebody thought of into a child of the bench's warm process, and tells what becomes of it."""

from __future__ import annotations

import ast
import sys
import tempfile
import tomllib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mutation.apply import CannotApplyError, Package, _codes, _value, chain, forget_caches, interpret, modules
from mutation.classify import Result, classify
from mutation.run import Warm, _forked, _post_all

__all__ = ["Fault", "faults", "posted", "posted_as_rapid", "put"]

_LIST = Path(__file__).with_name("by_hand.toml")


@dataclass(frozen=True)
class Fault:
    """`old` stands once in `file` (within camrob) and becomes `new`. jobs: of the bench, on which it has to show."""

    name: str
    group: str
    file: str
    old: str
    new: str
    jobs: tuple[str, ...]

    @property
    def rapid(self) -> bool:
        """Whether it is one of the writer of RAPID."""
        return self.group == "RAPID"


def faults() -> list[Fault]:
    """All of the list."""
    rows = tomllib.loads(_LIST.read_text(encoding="utf-8"))["fault"]
    return [Fault(**{**row, "jobs": tuple(row["jobs"])}) for row in rows]


def put(package: Package, fault: Fault) -> None:
    """Put a fault into this process. Raises CannotApplyError where it no longer fits, or changes nothing that is held."""
    module = "camrob." + fault.file.removesuffix(".py").replace("/", ".")
    path = Path(str(sys.modules[module].__file__))
    text = path.read_text(encoding="utf-8")
    if text.count(fault.old) != 1:
        raise CannotApplyError(f"{fault.file} holds {fault.old!r} {text.count(fault.old)} times")
    changed = text.replace(fault.old, fault.new)
    done = _functions(package, path, text, changed) + _constants(module, text, changed)
    kernels = frozenset[str]()
    for name in done:
        kernel = f"{module}:{name}"
        kernels |= chain(package, kernel) if kernel in package.kernels else frozenset()
    if kernels:
        interpret(package, kernels)
    forget_caches(package)
    if not done:
        raise CannotApplyError(f"{fault.name} changes no function and no constant")


def _functions(package: Package, path: Path, text: str, changed: str) -> list[str]:
    """New code in the functions of a file whose code is another; their names."""

    def codes(source: str) -> dict[str, Any]:
        return {c.co_qualname: c for c in _codes(compile(source, str(path), "exec", dont_inherit=True))}

    before, after, done = codes(text), codes(changed), list[str]()
    for name, code in after.items():
        if name not in before or _same(before[name], code):
            continue
        for function in package.functions.get((str(path), name), []):
            function.__code__ = code
            done.append(name)
    return done


def _same(one: Any, other: Any) -> bool:
    """Whether two codes do the same, wherever they stand."""
    if not hasattr(one, "co_code"):
        return type(one) is type(other) and one == other
    constants = zip(one.co_consts, other.co_consts, strict=False)
    return (
        hasattr(other, "co_code")
        and (one.co_code, one.co_names) == (other.co_code, other.co_names)
        and len(one.co_consts) == len(other.co_consts)
        and all(_same(a, b) for a, b in constants)
    )


def _constants(module: str, text: str, changed: str) -> list[str]:
    """New values of a module's constants wherever they are held by name; their names."""

    def assigned(source: str) -> dict[str, ast.expr]:
        found = dict[str, ast.expr]()
        for node in ast.parse(source).body:
            target = node.targets[0] if isinstance(node, ast.Assign) else getattr(node, "target", None)
            value = getattr(node, "value", None)
            if isinstance(node, (ast.Assign, ast.AnnAssign)) and isinstance(target, ast.Name) and value is not None:
                found[target.id] = value
        return found

    before, done = assigned(text), list[str]()
    for name, value in assigned(changed).items():
        if name in before and ast.dump(before[name]) == ast.dump(value):
            continue
        old, new = getattr(sys.modules[module], name), _value(value, vars(sys.modules[module]))
        if isinstance(old, dict):
            old.clear()
            old.update(new)
        for other in modules():
            if getattr(other, name, None) is old:
                setattr(other, name, new)
        done.append(name)
    return done


def posted(warm: Warm, fault: Fault, names: Sequence[str]) -> tuple[str, str]:
    """What comes of a fault on the jobs, `stopped` (or kept from what must be refused), `valid`, `same` (it shows on none),
    `wrong` or `misfit`, and a text of it.
    """
    result = Result(fault.name, fault.file, "", "", 0)
    jobs = [n for n in names if n in warm.baselines]

    def work(send: Callable[[Any], None]) -> None:
        try:
            put(warm.package, fault)
        except CannotApplyError as error:
            send(("cannot", str(error)))
            return
        _post_all(warm, jobs, send, warm.baselines)

    for message in _forked(work, len(jobs)):
        if message[0] == "cannot":
            return "misfit", message[1]
        if message[0] == "lost":
            result.note("hang", "", message[1])
            continue
        _, name, outcome = message
        if classify(result, warm.bench.jobs[name], warm.baselines[name], outcome):
            break
    result.settle()
    counts = ", ".join(f"{n} {what}" for what, n in result.counts.items()) + f" ({result.shown})" * bool(result.shown)
    if result.outcome.startswith("wrong"):
        return result.outcome, f"{result.job}: {result.fault}: {result.text}"
    if result.outcome == "valid":
        return "valid", f"{counts}; {', '.join(sorted(result.kinds))}; {'; '.join(sorted(result.errors))}"
    stopped = result.outcome in ("refused", "crashed", "hang", "kept")
    return "stopped" if stopped else result.outcome, f"{counts}; {'; '.join(sorted(result.errors))}"


def posted_as_rapid(package: Package, fault: Fault, folder: Path) -> tuple[str, str]:
    """The same of the job in RAPID, of which every statement has to stay as it was."""
    from rapid_job import CELL, write_job
    from rapid_mutants import statements

    from camrob import post
    from camrob.errors import CamrobError

    def made(work: Path) -> list[str]:
        write_job(work)
        return statements(post(work / "part.nc", cell=CELL, out=work / "out", report=False).out)

    wanted = made(Path(tempfile.mkdtemp(dir=folder)))
    where = Path(tempfile.mkdtemp(dir=folder))

    def work(send: Callable[[Any], None]) -> None:
        try:
            put(package, fault)
            said = made(where)
        except CannotApplyError as error:
            send(("misfit", str(error)))
        except CamrobError as error:
            send(("stopped", f"{type(error).__name__}: {error}"))
        except Exception as error:
            send(("stopped", f"crashed: {type(error).__name__}: {error}"))
        else:
            first = next((" | ".join(pair) for pair in zip(wanted, said, strict=False) if pair[0] != pair[1]), "")
            send(("same", "") if said == wanted else ("wrong", first or "fewer or more"))

    for message in _forked(work, 1):
        return str(message[0]), str(message[1])
    return "stopped", "the process ended"
