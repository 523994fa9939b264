"""Readers of programs put against each other: what camrob's reader and the witness both read whole has to be the same.

    python tests/bench/two_program_readers.py --count 20000 [--seed 2] [--language krl]     the long run, some ten minutes
    python tests/bench/two_program_readers.py --quick                                        1 500 mutants, less than a minute

Small programs with what other makers' hold (functions, loops, parameters, structures, WITH, triggers, relative motions; records,
arrays, Offs, procedures) are changed token by token and line by line. A mutant that either of the two refuses, or says that it
can't judge, counts as told. Where neither says anything, the tip, the tool's axis, the external axes and the speed of each motion
have to agree. The two share no code, so that what they agree on is read by the manual twice.
Exit status 1 where they differ; the mutant's changed lines and where they differ are printed.

On 2026-11-27, of 13 000 mutants two were read otherwise (the end of a CIRC, a point known in part) and one was a traceback
(SWITCH without a CASE); all three are mended.
"""

from __future__ import annotations

import argparse
import difflib
import random
import re
import sys
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(HERE), str(ROOT)]  # this checkout's camrob, whichever is installed

from scratch import one_thread, scratch_folder  # noqa: E402

QUICK = 1_500
_SEEDS = HERE / "program_seeds"
_CELLS = {"krl": ROOT / "cells" / "kr15_track_table", "rapid": ROOT / "cells" / "irb6700_table"}
_SUFFIX = {"krl": ".src", "rapid": ".mod"}
_TOKEN = re.compile(
    r'"[^"]*"|[;!][^\n]*|[$#]?[A-Za-z_][A-Za-z0-9_$]*|\d+\.?\d*(?:[eE][-+]?\d+)?|\n|[ \t]+|:=|<=|>=|<>|==|[^\w\s]'
)
_NUMBERS = ("0", "1", "-1", "2", "0.5", "3", "10", "590.0", "1.5", "0.05", "-7")
_PLACE, _AXIS, _SHARE, _OUTER = 2e-6, 1e-6, 1e-9, 1e-6  # m, of a unit vector, of a speed, degrees and mm
_MOST_SHOWN = 20


def mutated(text: str, rng: random.Random, others: Sequence[str]) -> str:
    """The text with one to three changes behind its first empty line."""
    lines = text.split("\n")
    fixed = lines.index("") + 1
    head, body = lines[:fixed], lines[fixed:]
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        if rng.random() < 0.3:
            _by_line(body, rng, others)
        else:
            body = _by_token("\n".join(body), rng, others).split("\n")
    return "\n".join([*head, *body])


def _by_line(body: list[str], rng: random.Random, others: Sequence[str]) -> None:
    at = rng.randrange(len(body))
    kind = rng.randrange(4)
    if kind == 0:
        del body[at]
        body.extend([""] * (not body))
    elif kind == 1:
        body.insert(at, body[rng.randrange(len(body))])
    elif kind == 2:
        other = rng.randrange(len(body))
        body[at], body[other] = body[other], body[at]
    else:
        body.insert(at, rng.choice(rng.choice(others).split("\n")))


def _by_token(text: str, rng: random.Random, others: Sequence[str]) -> str:
    tokens = _TOKEN.findall(text)
    solid = [k for k, token in enumerate(tokens) if token.strip()]
    if not solid:
        return text
    at = rng.choice(solid)
    kind, token = rng.randrange(6), tokens[at]
    if kind == 0:
        tokens[at] = ""
    elif kind == 1:
        tokens.insert(at, token + " ")
    elif kind == 2:
        other = rng.choice(solid)
        tokens[at], tokens[other] = tokens[other], token
    elif token[0].isdigit() or kind == 3:
        tokens[at] = rng.choice(_NUMBERS)
    else:
        pool = _TOKEN.findall(rng.choice(others))
        alike = [t for t in pool if t.strip() and t[0].isalpha() == token[0].isalpha()]
        tokens[at] = rng.choice(alike or pool)
    return "".join(tokens)


class Readings:
    """Both readings of a program of one language."""

    def __init__(self, language: str) -> None:
        from camrob.cell.read_cell import read_cell
        from camrob.languages import language_named
        from camrob.witness.machine import read_machine

        self.cell, self.machine = read_cell(_CELLS[language]), read_machine(_CELLS[language])
        self.language, self.section = language_named(language), self.cell.controller

    def compared(self, main: Path) -> str:
        """ "" where both say the same, `told` where one of them says what it can't do, else where they differ."""
        import numpy as np

        from camrob.controller.replay import replay
        from camrob.errors import CamrobError
        from camrob.findings import Severity
        from camrob.program.motion import Motion
        from camrob.witness.programs import run_program

        try:
            run = run_program(main, self.machine)
            text = self.language.read(main, self.section)
            if not len(text) and not len(run):
                return ""
            replayed = replay(text, self.cell)
        except CamrobError:
            return "told"
        found = (*text.findings, *replayed.findings)
        open_ = [*run.gaps, *(gap for gap in run.unsettled if not gap.of_load)]
        if open_ or any(f.severity is not Severity.INFO for f in found):
            return "told"
        if any(o.severity == "error" for o in (*run.objections, *run.conduct)):
            return "told"
        rows = np.flatnonzero(np.asarray(text.kind) != Motion.CIRC_VIA)
        if len(rows) != len(run):
            return f"{len(rows)} motions, by the witness {len(run)}"
        frames = np.asarray(replayed.base_T_tool)[rows]
        swept = np.isfinite(np.asarray(text.circular_angle_deg)[rows])  # CA: the replay has the point that is named
        outer = {name: run.axes[:, k] for k, name in enumerate(run.axis_names) if name.startswith("E")}
        speed, straight = np.asarray(text.speed)[rows], ~run.ptp
        for what, off, most in (
            ("tip", np.abs(frames[:, :3, 3] - run.path.tip).max(axis=1), _PLACE),
            ("axis", np.abs(frames[:, :3, 2] - run.path.axis).max(axis=1), _AXIS),
            ("speed", np.where(straight, np.abs(speed - run.speed), 0.0), _SHARE),
            *(
                (name, np.abs(np.asarray(text.external)[rows, k] - outer[name]), _OUTER)
                for k, name in enumerate(text.external_names)
                if name in outer
            ),
        ):
            off = np.where(swept & (what in ("tip", "axis")), 0.0, off)
            wrong = np.flatnonzero(~(off <= most) & np.isfinite(off))
            if len(wrong):
                return f"line {run.path.line[wrong[0]]}: {what} differs by {off[wrong[0]]:g}"
        return ""


def main() -> int:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=20_000, help="mutants to read")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--language", choices=sorted(_CELLS), help="one of them only")
    parser.add_argument("--quick", action="store_true", help=f"the first {QUICK} alone")
    options = parser.parse_args()
    one_thread()
    with scratch_folder("readers") as folder:
        return _run(options, folder)


def _run(options: argparse.Namespace, folder: Path) -> int:
    started, counts, wrong = time.time(), Counter[str](), 0
    count = QUICK if options.quick else options.count
    languages = [options.language] if options.language else sorted(_CELLS)
    for language in languages:
        rng, readings = random.Random(options.seed), Readings(language)
        seeds = {
            path.stem: path.read_text("ascii") for path in sorted((_SEEDS / language).glob("*" + _SUFFIX[language]))
        }
        for name, text in seeds.items():
            target = folder / f"{name}{_SUFFIX[language]}"
            target.write_text(text)
            said = readings.compared(target)
            if said:
                print(f"{target.name}, as it is: {said}")
                wrong += 1
        names = list(seeds)
        for _ in range(count // len(languages)):
            name = rng.choice(names)
            text = seeds[name]
            made = mutated(text, rng, list(seeds.values()))
            target = folder / f"{name}{_SUFFIX[language]}"
            target.write_text(made)
            said = readings.compared(target)
            counts[f"{language}: {said if said == 'told' else 'differ' if said else 'the same'}"] += 1
            if said and said != "told":
                wrong += 1
                if wrong <= _MOST_SHOWN:
                    changed = [
                        d
                        for d in difflib.unified_diff(text.split("\n"), made.split("\n"), n=0, lineterm="")
                        if d[0] in "+-"
                    ]
                    print(f"{target.name}: {said}\n  " + "\n  ".join(changed[2:]), flush=True)
    said = ", ".join(f"{what} {n}" for what, n in sorted(counts.items()))
    print(f"{said}; {wrong} wrong, {time.time() - started:.0f} s")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
