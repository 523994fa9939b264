"""Write the eleventh author's cases, have camrob answer them, score the answers.

python tests/bench/gap/eleventh_author/run.py --out DIR [--write] [--answer] [--score] [--seed N] [--only 3 7]

Without a step all three are done. Labels go to DIR/sealed and are held to `sealed.sha256`; logs to DIR/cases, answers to
DIR/answers (a case that has one is not asked again), figures to DIR/figures.json and DIR/report.md. `--seal` prints the digests.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import resource
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from gap.eleventh_author.case import PLAN, SEED, label, made
from gap.eleventh_author.scores import report, scores
from gap.eleventh_author.seal import HERE, digest, generator_digest, line, sealed
from gap.eleventh_author.sheets import write

__all__ = ["answer", "main", "score", "write_all"]

ROOT = Path(__file__).resolve().parents[4]
LIMIT = 900.0  # s a diagnosis may take


def write_all(out: Path, seed: int, numbers) -> None:
    """Cases, and their labels apart from them."""
    (out / "sealed").mkdir(parents=True, exist_ok=True)
    (out / "sealed" / "seed").write_text(str(seed))
    with (out / "sealed" / "labels.jsonl").open("w") as file:
        for number in numbers:
            case = made(seed, number)
            write(case, out / "cases" / f"{number:02d}")
            file.write(line(label(case)) + "\n")


def _labels(out: Path) -> dict[int, dict]:
    """The labels; refuses others than those that were sealed."""
    rows = (out / "sealed" / "labels.jsonl").read_text().splitlines()
    labels = {told["number"]: told for told in map(json.loads, rows)}
    if (out / "sealed" / "seed").read_text() == str(SEED):
        fixed = sealed()
        other = [n for n, row in zip(labels, rows, strict=True) if digest(row) != fixed[str(n)]]
        if generator_digest() != fixed["generator"] or other:
            raise SystemExit(f"{out}: generator or labels {other} are not those that were sealed")
    return labels


def answer(out: Path, number: int) -> None:
    """camrob's diagnosis of a case, as a user would ask for it."""
    folder, to = out / "cases" / f"{number:02d}", out / "answers" / f"{number:02d}"
    if (to / "answer.json").exists():
        return
    to.mkdir(parents=True, exist_ok=True)
    logs = [x for p in sorted(folder.glob("run_?.csv")) for x in ("--log", str(p))]
    if (folder / "withheld.csv").exists():
        logs += ["--withheld", str(folder / "withheld.csv")]
    ask = [sys.executable, "-m", "camrob", "diagnose", "--cell", str(folder / "cell"), *logs, "--out", str(to)]
    begun, spent = time.monotonic(), _spent()
    told, error, status = "", "", None
    env = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    try:
        done = subprocess.run(ask, cwd=ROOT, env=env, capture_output=True, text=True, timeout=LIMIT, check=False)
        told, error, status = done.stdout, done.stderr[-3000:], done.returncode
    except subprocess.TimeoutExpired:
        error = f"more than {LIMIT} s"
    seconds, spent = round(time.monotonic() - begun, 1), round(_spent() - spent, 1)
    found = to / "diagnosis.json"
    said = json.loads(found.read_text()) if found.exists() else {}
    (to / "terminal.txt").write_text(told + error)
    (to / "answer.json").write_text(
        json.dumps({"diagnosis": said, "seconds": spent, "wall": seconds, "status": status, "error": error})
    )
    print(
        f"answered {number} in {seconds} s, {spent} of a core, status {status} {error[:200]}",
        file=sys.stderr,
        flush=True,
    )


def _spent() -> float:
    """Seconds of a core that children have taken."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def score(out: Path) -> None:
    """Figures of what is answered so far."""
    labels = _labels(out)
    answers = {
        n: json.loads(p.read_text()) for n in labels if (p := out / "answers" / f"{n:02d}" / "answer.json").exists()
    }
    judged = HERE / "steps.csv"
    steps = {int(r["case"]): r["first step"] for r in csv.DictReader(judged.open())} if judged.exists() else None
    found = scores(labels, answers, steps)
    (out / "figures.json").write_text(json.dumps(found, indent=1) + "\n")
    (out / "report.md").write_text(report(found, labels, answers))


def main(arguments=None) -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    for step in ("write", "answer", "score", "seal"):
        parser.add_argument(f"--{step}", action="store_true")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--only", type=int, nargs="*", default=None)
    args = parser.parse_args(arguments)
    numbers = range(len(PLAN)) if args.only is None else args.only
    if args.seal:
        rows = [line(label(made(args.seed, n))) for n in numbers]
        print(f"generator {generator_digest()}\nall {digest(''.join(r + chr(10) for r in rows))}")
        print("\n".join(f"{n} {digest(r)}" for n, r in zip(numbers, rows, strict=True)))
        return
    every = not (args.write or args.answer or args.score)
    if args.write or (every and not (args.out / "sealed" / "labels.jsonl").exists()):
        write_all(args.out, args.seed, numbers)
    if args.answer or every:
        labels = _labels(args.out)
        for number in [n for n in numbers if n in labels]:
            answer(args.out, number)
    if args.score or every:
        score(args.out)
        print((args.out / "report.md").read_text())


if __name__ == "__main__":
    main()
