"""Write a family's cases and sealed labels, diagnose each by a process of its own, and score."""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[4]
sys.path.insert(0, str(ROOT / "tests" / "bench"))

from gap.sixth_author import case as cases  # noqa: E402

LIMIT_S = 900


def write_cases(family: str, out: Path, only: list[int] | None = None) -> None:
    """Cases to out/cases, labels to out/sealed/labels.jsonl with their digest beside."""
    labels = []
    for number in only if only is not None else range(sum(cases.COUNTS[family].values())):
        case = cases.made(family, number)
        cases.write(case, out / "cases" / case.key)
        task = {"seed": cases.FIRST[family] + number, "key": case.key, "family": family}
        labels.append(json.dumps({"key": case.key, "task": task, "label": cases.label(case)}))
    sealed = out / "sealed" / "labels.jsonl"
    sealed.parent.mkdir(parents=True, exist_ok=True)
    sealed.write_text("\n".join(labels) + "\n", encoding="utf-8")
    digest = hashlib.sha256(sealed.read_bytes()).hexdigest()
    (out / "labels.sha256").write_text(f"{digest}  sealed/labels.jsonl\n", encoding="utf-8")
    print(f"{len(labels)} cases in {out / 'cases'}, SHA-256 of the labels {digest}", flush=True)


def answer(folder: Path, out: Path) -> dict:
    """`camrob diagnose` on a case, from the worktree that this file lies in."""
    logs = sorted(folder.glob("run*.csv"))
    command = [sys.executable, "-m", "camrob", "diagnose", "--cell", str(folder / "cell"), "--quiet", "--out", str(out)]
    for log in logs:
        command += ["--log", str(log)]
    command += ["--withheld", str(folder / "withheld.csv")]
    threads = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}
    begun = time.perf_counter()
    try:
        done = subprocess.run(
            command,
            cwd=ROOT,
            env={**os.environ, **threads},
            capture_output=True,
            text=True,
            timeout=LIMIT_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return {"key": folder.name, "said": {"error": f"no answer in {LIMIT_S} s"}}
    seconds = time.perf_counter() - begun
    made = out / "diagnosis.json"
    if done.returncode or not made.is_file():
        return {"key": folder.name, "said": {"error": f"status {done.returncode}: {done.stderr.strip()[-400:]}"}}
    from gap.sixth_author.figures import said_of

    rows = sum(len(p.read_text(encoding="utf-8").splitlines()) - 1 for p in logs)
    return {"key": folder.name, "said": said_of(json.loads(made.read_text(encoding="utf-8")), rows, seconds)}


def answer_all(out: Path) -> None:
    """Answers to out/answers.jsonl; those that are there stay."""
    file = out / "answers.jsonl"
    have = {json.loads(x)["key"] for x in file.read_text(encoding="utf-8").splitlines()} if file.is_file() else set()
    for folder in sorted(p for p in (out / "cases").iterdir() if p.is_dir() and p.name not in have):
        got = answer(folder, out / "answers" / folder.name)
        with file.open("a", encoding="utf-8") as to:
            to.write(json.dumps(got) + "\n")
        print(folder.name, got["said"].get("error", "answered"), flush=True)


def score_all(out: Path, title: str) -> None:
    """out/report.md and out/figures.json; the labels are opened here and nowhere else."""
    from gap.sixth_author.figures import report, rows_of

    sealed = out / "sealed" / "labels.jsonl"
    labels = {x["key"]: x for x in map(json.loads, sealed.read_text(encoding="utf-8").splitlines())}
    lines = (out / "answers.jsonl").read_text(encoding="utf-8").splitlines()
    text, figures = report(
        rows_of(labels, {x["key"]: x for x in map(json.loads, lines)}),
        title,
        hashlib.sha256(sealed.read_bytes()).hexdigest(),
    )
    (out / "report.md").write_text(text, encoding="utf-8")
    (out / "figures.json").write_text(json.dumps(figures, indent=1), encoding="utf-8")
    print(out / "report.md")


def main() -> None:
    """All three, or one of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--family", choices=sorted(cases.COUNTS), required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--step", choices=["all", "write", "answer", "score"], default="all")
    parser.add_argument("--only", type=int, nargs="*", help="numbers of cases, from 0")
    args = parser.parse_args()
    out = args.out.resolve()
    if args.step in ("all", "write") and not (out / "sealed" / "labels.jsonl").is_file():
        write_cases(args.family, out, args.only)
    if args.step in ("all", "answer"):
        answer_all(out)
    if args.step in ("all", "score"):
        score_all(out, f"A sixth author's cases: {args.family}")


if __name__ == "__main__":
    main()
