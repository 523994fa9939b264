"""Write the ninth author's cases, have camrob answer them, score the answers.

python tests/bench/gap/ninth_author/run.py --out DIR [--write] [--answer] [--score] [--seed N] [--only 3 7]

Without a step all three are done. Labels go to DIR/sealed and are held to `sealed.sha256` before cases of the sealed seed
are answered and before anything is scored; logs to DIR/cases, answers to DIR/answers (a case that has one is not asked
again), figures to DIR/figures.json and DIR/report.md.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from gap.ninth_author.case import SEED, made, write
from gap.ninth_author.label import digest, generator_digest, label, line
from gap.ninth_author.plan import PLAN
from gap.ninth_author.scores import report, scores

__all__ = ["SEALED", "answer", "main", "score", "sealed", "write_all"]

ROOT = Path(__file__).resolve().parents[4]
SEALED = Path(__file__).with_name("sealed.sha256")
LIMIT = 900.0  # s a diagnosis may take


def _folder(out: Path, number: int) -> Path:
    return out / "cases" / f"{number:02d}"


def write_all(out: Path, seed: int, numbers) -> None:
    """Cases, and their labels apart from them."""
    (out / "sealed").mkdir(parents=True, exist_ok=True)
    (out / "sealed" / "seed").write_text(str(seed))
    with (out / "sealed" / "labels.jsonl").open("w") as file:
        for number in numbers:
            case = made(seed, number)
            write(case, _folder(out, number))
            file.write(line(label(case)) + "\n")
            file.flush()
            print(f"written {number}", file=sys.stderr)
    told = out / "sealed" / "labels.jsonl"
    (out / "sealed" / "digest").write_text(digest(told.read_text()))


def sealed() -> dict:
    """The digests that were fixed: of the generator, of all labels, of each label."""
    return dict(row.split() for row in SEALED.read_text().splitlines())


def _labels(out: Path) -> dict:
    """The labels; refuses others than those that were sealed."""
    file = out / "sealed" / "labels.jsonl"
    text, fixed = file.read_text(), sealed()
    if digest(text) != (out / "sealed" / "digest").read_text():
        raise SystemExit(f"{file}: the labels were changed after they were written")
    rows = text.splitlines()
    labels = {told["number"]: told for told in map(json.loads, rows)}
    if (out / "sealed" / "seed").read_text() == str(SEED):
        other = [n for n, row in zip(labels, rows, strict=True) if digest(row) != fixed[str(n)]]
        if generator_digest() != fixed["generator"] or other:
            raise SystemExit(f"{file}: generator or labels {other} are not those that were sealed")
    return labels


def answer(out: Path, number: int) -> None:
    """camrob's diagnosis of a case, as a user would ask for it."""
    folder, to = _folder(out, number), out / "answers" / f"{number:02d}"
    if (to / "answer.json").exists():
        return
    to.mkdir(parents=True, exist_ok=True)
    logs = [x for name in sorted(p.name for p in folder.glob("run_*.csv")) for x in ("--log", str(folder / name))]
    ask = [sys.executable, "-m", "camrob", "diagnose", "--cell", str(folder / "cell"), *logs, "--withheld"]
    ask += [str(folder / "withheld.csv"), "--out", str(to), "--quiet"]
    begun, error = time.monotonic(), ""
    env = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    try:
        done = subprocess.run(ask, cwd=ROOT, env=env, capture_output=True, text=True, timeout=LIMIT, check=False)
        error = done.stderr[-2000:]
    except subprocess.TimeoutExpired:
        error = f"more than {LIMIT} s"
    seconds = round(time.monotonic() - begun, 1)
    found = to / "diagnosis.json"
    said = json.loads(found.read_text()) if found.exists() else {}
    (to / "answer.json").write_text(json.dumps({"diagnosis": said, "seconds": seconds, "error": error}))
    print(f"answered {number} in {seconds} s {error[:200]}", file=sys.stderr)


def score(out: Path) -> dict:
    """Figures of what is answered so far."""
    labels = _labels(out)
    answers = {
        n: json.loads(p.read_text()) for n in labels if (p := out / "answers" / f"{n:02d}" / "answer.json").exists()
    }
    found = scores(labels, answers)
    (out / "figures.json").write_text(json.dumps(found, indent=1) + "\n")
    (out / "report.md").write_text(report(found, labels, answers))
    return found


def main(arguments=None) -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    for step in ("write", "answer", "score"):
        parser.add_argument(f"--{step}", action="store_true")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--only", type=int, nargs="*", default=None)
    args = parser.parse_args(arguments)
    numbers = range(len(PLAN)) if args.only is None else args.only
    every = not (args.write or args.answer or args.score)
    if args.write or (every and not (args.out / "sealed" / "digest").exists()):
        write_all(args.out, args.seed, numbers)
    if args.answer or every:
        asked = _labels(args.out)
        for number in numbers:
            if number in asked:
                answer(args.out, number)
    if args.score or every:
        score(args.out)
        print((args.out / "report.md").read_text())


if __name__ == "__main__":
    main()
