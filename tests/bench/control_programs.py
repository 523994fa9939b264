"""Programs of controls drawn at random, read twice, and held to the path that was reckoned while they were drawn.

    python tests/bench/control_programs.py --count 200                     so many of each control, a few a second
    python tests/bench/control_programs.py --show siemens/17               one of them: its text and what came of it
    python tests/bench/control_programs.py --count 50 --controls fanuc

A program is legal by its control's manual and small (`drawn/`): straight cuts, arcs, increments, variables, loops, subprograms,
frames, planes, tool centre point, corners, drilling. camrob's reading has to be the reckoned path, and so has the witness's;
a refusal counts against camrob, a gap of the witness's is counted. Exit status 1 where a reading is wrong, or camrob refuses.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from random import Random

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

CHORD = 1e-6  # m: finer than the readings are held to each other


def main() -> int:
    """The command line."""
    from drawn import CONTROLS

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--seed", type=int, default=0, help="the first program's")
    parser.add_argument("--controls", nargs="*", choices=sorted(CONTROLS))
    parser.add_argument("--show", help="control/seed")
    parser.add_argument("--most", type=int, default=10, help="failures printed with their text")
    options = parser.parse_args()
    cases = [(c, options.seed + k) for k in range(options.count) for c in options.controls or CONTROLS]
    if options.show:
        name, seed = options.show.split("/")
        cases = [(name, int(seed))]
    came: Counter[str] = Counter()
    started, failed = time.time(), 0
    with tempfile.TemporaryDirectory(prefix="control_programs") as folder:
        for name, seed in cases:
            kind, text, found = outcome(name, seed, Path(folder))
            came[f"{name}: {kind}"] += 1
            if options.show:
                print(text)
            if found:
                print(f"{kind} {name}/{seed}: " + " | ".join(found)[:600], flush=True)
            if kind in ("WRONG", "REFUSED") and not options.show:
                failed += 1
                if failed <= options.most:
                    print("    " + text.replace("\n", "\n    "))
    for kind, count in sorted(came.items()):
        print(f"{count:6d} {kind}")
    print(f"{time.time() - started:.0f} s", file=sys.stderr)
    return 1 if any("WRONG" in kind or "REFUSED" in kind for kind in came) else 0


def outcome(name: str, seed: int, folder: Path) -> tuple[str, str, list[str]]:
    """What becomes of one program: a word, its text, and what stands against it."""
    from drawn import CONTROLS
    from two_readings import differences

    from camrob.errors import ToolpathError
    from camrob.toolpath.read import read_toolpath
    from camrob.witness.cl import read_story

    writer = CONTROLS[name](Random(f"{name}/{seed}"))
    text, wanted = writer.draw(), writer.told.story()
    file = folder / f"drawn{writer.suffix}"
    file.write_text(text)
    dialect = f"gcode-{writer.reading['kinematics']}" if writer.reading else None
    try:
        path = read_toolpath(file, dialect=dialect, chord_tolerance=CHORD)
    except ToolpathError as error:
        return "REFUSED", text, [str(error)]
    if found := differences(path, wanted):
        return "WRONG", text, ["camrob, against what was reckoned:", *found]
    story = read_story(file, dialect=dialect)
    if not story.complete:
        return "read; the witness in part", text, [f"line {g.first_line}: {g.text}" for g in story.gaps[:1]]
    if found := differences(path, story):
        return "WRONG", text, ["the witness, against camrob:", *found]
    return "read alike", text, []


if __name__ == "__main__":
    sys.exit(main())
