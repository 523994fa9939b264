"""Writes the sealed family, has it diagnosed, scores it: python tests/bench/gap/eighth_author/run.py --out DIR."""

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

from gap.eighth_author.asked import chosen, hand_out, scoring  # noqa: E402
from gap.eighth_author.case import SEED, label, made, planned, write  # noqa: E402

STEPS = ("write", "answer", "score")  # and, when they are asked for
ASKED = ("ask", "sheet")


SEALED = Path(__file__).with_name("sealed.sha256")  # of all labels, then of each: a line a case


def digest(lines):
    return hashlib.sha256("".join(lines).encode()).hexdigest()


def labelled(number, case):
    """A line of the labels."""
    return json.dumps({"number": number, "label": label(case)}, sort_keys=True) + "\n"


def other_than_sealed(lines, only):
    """Numbers of cases of the sealed family whose labels aren't those of `SEALED`."""
    told = dict(line.split() for line in SEALED.read_text(encoding="utf-8").splitlines())
    return [n for n, line in zip(only, lines, strict=True) if told[str(n)] != digest([line])]


def write_all(out, seed, only):
    """Cases without a word of what is wrong with them, labels apart; prints nothing of these but their digest."""
    lines = []
    for number in only:
        case = made(seed, number)
        write(case, out / "cases" / f"{number:02d}")
        lines.append(labelled(number, case))
    if seed == SEED and (others := other_than_sealed(lines, only)):
        raise SystemExit(
            f"cases {others}: their labels come out otherwise than they were sealed; take the versions that README.md names"
        )
    sealed = out / "sealed" / "labels.jsonl"
    sealed.parent.mkdir(parents=True, exist_ok=True)
    sealed.write_text("".join(lines), encoding="utf-8")
    (out / "labels.sha256").write_text(digest(lines) + "\n", encoding="utf-8")
    print(f"{len(lines)} cases in {out / 'cases'}, SHA-256 of their labels {digest(lines)}")


def diagnose(folder, to, timeout):
    """{status, error, seconds} of a diagnosis as a process of its own, which sees the case's folder alone."""
    command = [sys.executable, "-m", "camrob", "diagnose", "--cell", str(folder / "cell"), "--out", str(to)]
    for log in sorted(folder.glob("run*.csv")):
        command += ["--log", str(log)]
    command += ["--withheld", str(folder / "withheld.csv")]
    begun = time.perf_counter()
    surroundings = {**os.environ, "PYTHONPATH": str(ROOT)}
    try:
        ran = subprocess.run(command, cwd=ROOT, env=surroundings, capture_output=True, text=True, timeout=timeout)
        said = {"status": ran.returncode, "error": ran.stderr[-2000:] if ran.returncode else ""}
    except subprocess.TimeoutExpired:
        said = {"status": None, "error": f"no answer within {timeout} s"}
    return said | {"seconds": time.perf_counter() - begun}


def answer_all(out, only, timeout):
    """Every case that has no answer yet."""
    for number in only:
        folder, to = out / "cases" / f"{number:02d}", out / "answers" / f"{number:02d}"
        if (to / "answer.json").exists():
            continue
        to.mkdir(parents=True, exist_ok=True)
        said = diagnose(folder, to / "diagnosis", timeout)
        (to / "answer.json").write_text(json.dumps(said), encoding="utf-8")
        print(f"case {number}: exit status {said['status']}, {said['seconds']:.0f} s", flush=True)


def opened(out):
    """{number: label}, once the labels are what was sealed."""
    lines = (out / "sealed" / "labels.jsonl").read_text(encoding="utf-8").splitlines(keepends=True)
    if digest(lines) != (out / "labels.sha256").read_text(encoding="utf-8").strip():
        raise SystemExit(f"{out}: the labels are not those that were sealed; write the cases anew")
    return {r["number"]: r["label"] for r in map(json.loads, lines)}


def score_all(out):
    from gap.eighth_author.figures import report

    labels, answers = opened(out), {}
    for number in labels:
        to = out / "answers" / f"{number:02d}"
        if (to / "answer.json").exists():
            said = json.loads((to / "answer.json").read_text(encoding="utf-8"))
            found = to / "diagnosis" / "diagnosis.json"
            if said["status"] == 0 and found.exists():
                said["diagnosis"] = json.loads(found.read_text(encoding="utf-8"))
            answers[number] = said
    text, figures = report(labels, answers)
    (out / "report.md").write_text(text, encoding="utf-8")
    (out / "figures.json").write_text(json.dumps(figures, indent=1), encoding="utf-8")
    print(out / "report.md")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--step", choices=STEPS + ASKED, help="one part; write, answer and score where it is left out")
    parser.add_argument("--only", type=int, nargs="+", help="these cases")
    parser.add_argument("--seed", type=int, default=SEED, help="another family of the same kind, to try things on")
    parser.add_argument("--timeout", type=float, default=1800, help="seconds for a diagnosis")
    asked = parser.parse_args()
    only = asked.only or range(len(planned(asked.seed)))
    out = asked.out.resolve()
    if asked.step in (None, "write"):
        write_all(out, asked.seed, only)
    if asked.step in (None, "answer"):
        answer_all(out, only, asked.timeout)
    if asked.step in (None, "score"):
        score_all(out)
    if asked.step == "ask":
        hand_out(out, chosen(planned(asked.seed), asked.seed))
    if asked.step == "sheet":
        sheet = out / "sealed" / "sheet.md"
        sheet.write_text(scoring(chosen(planned(asked.seed), asked.seed), opened(out)), encoding="utf-8")
        print(sheet)


if __name__ == "__main__":
    main()
