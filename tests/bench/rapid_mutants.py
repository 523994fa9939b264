"""Mutants of RAPID's folder, on a post of two tools with an arc, a dwell and loads: is any other program ever released?

    python tests/bench/rapid_mutants.py --count 400      the first of the order that the seed fixes, some minutes
    python tests/bench/rapid_mutants.py --only KEY       one, with what it does and what comes of it

A mutant is refused, or stops with an error, or leaves every statement as it was; remarks, decimals of 0 and the configurations
of lines and arcs, which mean nothing under ConfL\\Off, may differ. What is right in another way (other names, settings in another
order, a decimal more or the last one of eight) stands in RIGHT.
Exit status 1 where another program is released.

On 2026-11-23, of 658 mutants 373 leave the program as it is, 173 are refused, 91 stop with an error of Python's, 1 does not end,
10 can't be applied, 10 are right in another way, none is released and wrong.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]
RIGHT = {
    "axis_turns._QUARTER:constant-double:1": "configurations of lines",
    "body.Names.__init__:elements:1": "names",
    "body.Names.tool:arms:1": "names",
    "body.Names.tool:condition-false:1": "names",
    "body.Names.tool:constant-plus:1": "names",
    "rapid_numbers.EXTERNAL_DECIMALS:constant-plus:1": "a decimal more",
    "rapid_numbers._UNIT:constant-little:1": "the last decimal of eight",
    "rapid_text._plain:condition-false:3": "names",
    "write_rapid.iter_rapid:condition-false:3": "a program in parts",
    "write_rapid.opening_statements:elements:7": "settings in another order",
}
_LONGEST = 120.0  # s that a mutant may take; one that loops is stopped


def statements(folder: Path) -> list[str]:
    """What a program's modules say, in one spelling: no remarks, no blanks, numbers by value. Nothing of camrob."""
    out = []
    for file in sorted(folder.glob("*.mod")):
        text = re.sub(r"!.*", "", file.read_text("latin-1"))
        text = re.sub(r"(Move[LC] .*)", lambda m: re.sub(r"\[(-?\d,){3}\d\]", "[conf]", m[0]), text)
        text = re.sub(r"(?<![A-Za-z_0-9])-?\d+(\.\d+)?(E[+-]?\d+)?", lambda m: f"{float(m[0]):.9g}", text)
        out += [f"{file.name}: {' '.join(s.split())}" for s in text.split(";")]
    return out


def outcome(package: object, mutant: object, work: Path, wanted: list[str]) -> str:
    """What comes of a mutant, in a process of its own."""
    from mutation.apply import CannotApplyError, apply
    from rapid_job import CELL

    from camrob import post
    from camrob.errors import CamrobError

    try:
        apply(package, mutant)  # type: ignore[arg-type]
    except CannotApplyError:
        return "not applied"
    try:
        made = post(work / "part.nc", cell=CELL, out=work / "out", report=False)
    except CamrobError as error:
        return f"refused: {type(error).__name__}"
    except Exception as error:
        return f"crashed: {type(error).__name__}"
    said = statements(made.out)
    if said == wanted:
        return "the same"
    first = next((pair for pair in zip(wanted, said, strict=False) if pair[0] != pair[1]), ("", "fewer or more"))
    return "released otherwise\n" + "\n".join(text[:200] for text in first)


def forked(package: object, mutant: object, folder: Path, wanted: list[str]) -> str:
    """`outcome` in a child process, whose state dies with it."""
    from rapid_job import write_job

    work = Path(tempfile.mkdtemp(dir=folder))
    write_job(work)
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(read)
        sys.stdout = sys.stderr = open(os.devnull, "w")
        try:
            os.write(write, outcome(package, mutant, work, wanted).encode())
        finally:
            os._exit(0)
    os.close(write)
    begun = time.monotonic()
    while os.waitpid(child, os.WNOHANG)[0] == 0:
        if time.monotonic() - begun > _LONGEST:
            os.kill(child, 9)
            os.waitpid(child, 0)
            break
        time.sleep(0.02)  # s
    with os.fdopen(read, "rb") as pipe:
        return pipe.read().decode() or "stopped"


def drawn(seed: int) -> tuple[object, list[object]]:
    """The package, and the mutants of RAPID's folder in the order that the seed fixes."""
    from mutation import apply, draw

    kept, draw.LEFT_OUT = draw.LEFT_OUT, tuple(x for x in draw.LEFT_OUT if x != "languages.rapid")
    package = apply.load(only=())
    draw.LEFT_OUT = kept
    mutants = []
    for name, source in package.sources.items():
        if name.startswith("camrob.languages.rapid.") or name == "camrob.program.axis_turns":
            source.mutants = draw.draw(name, source.path)
            mutants += source.mutants
    return package, list(draw.ordered(mutants, seed))


def run(count: int, seed: int, only: str = "") -> dict[str, list[str]]:
    """Outcomes of the first mutants, keys by outcome."""
    from rapid_job import CELL, write_job

    from camrob import post

    package, mutants = drawn(seed)
    chosen = [m for m in mutants if only in m.key][:count]  # type: ignore[attr-defined]
    found: dict[str, list[str]] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        first = write_job(folder / "first")
        made = post(first, cell=CELL, out=folder / "first" / "out", report=False)
        wanted = statements(made.out)
        for mutant in chosen:
            said, _, more = forked(package, mutant, folder, wanted).partition("\n")
            found.setdefault(said, []).append(mutant.key)  # type: ignore[attr-defined]
            if said == "released otherwise" or only:
                print(said, mutant.key, mutant.lines, more, sep="\n", flush=True)  # type: ignore[attr-defined]
    return found


def main() -> int:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=400, help="mutants to run")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="those whose key has this in it")
    options = parser.parse_args()
    found = run(options.count, options.seed, options.only)
    for said, number in sorted(Counter({k: len(v) for k, v in found.items()}).items()):
        print(f"{number:5d} {said}")
    return int(bool(set(found.get("released otherwise", ())) - RIGHT.keys()))


if __name__ == "__main__":
    raise SystemExit(main())
