"""Writes the cases, asks camrob by its command line, one at a time, and scores: ``run.py --out DIR [--write | --score]``."""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from gap.twelfth_author.case import PLAN, SEED, made
from gap.twelfth_author.scores import page
from gap.twelfth_author.seal import line
from gap.twelfth_author.sheets import write

ROOT = Path(__file__).resolve().parents[4]


def written(out, seed=SEED):
    """All cases and `sealed/labels.jsonl`, those that are not there yet."""
    file = out / "sealed" / "labels.jsonl"
    if file.is_file():
        return [json.loads(text) for text in file.read_text(encoding="utf-8").splitlines()]
    labels = []
    for key in range(len(PLAN)):
        case = made(key, seed)
        fit, held = write(case, out / "cases" / f"{key:02d}")
        (out / "cases" / f"{key:02d}" / "logs.json").write_text(
            json.dumps({"log": fit, "withheld": held}), encoding="utf-8"
        )
        labels.append(case.label)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("".join(line(label) + "\n" for label in labels), encoding="utf-8")
    return labels


def asked(folder):
    """What camrob says of a case (dict), as text in `said.txt` beside it."""
    logs = json.loads((folder / "logs.json").read_text(encoding="utf-8"))
    words = [sys.executable, "-m", "camrob", "diagnose", "--cell", str(folder / "cell"), "--out", str(folder / "out")]
    for option in ("log", "withheld"):
        for name in logs[option]:
            words += [f"--{option}", str(folder / name)]
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.time()
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    (folder / "said.txt").write_text(done.stdout + done.stderr, encoding="utf-8")
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    if not (folder / "out" / "diagnosis.json").is_file():
        return {
            "status": "refused",
            "why": done.stderr.strip(),
            "effects": [],
            "seconds": seconds,
            "clock_s": time.time() - start,
        }
    said = json.loads((folder / "out" / "diagnosis.json").read_text(encoding="utf-8"))
    kept = {k: said.get(k) for k in ("status", "effects", "alternatives", "unknown", "together", "gap", "where")}
    return {**kept, "seconds": seconds, "clock_s": time.time() - start}


def main():
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("--out", type=Path, required=True)
    words.add_argument("--write", action="store_true", help="write the cases and stop")
    words.add_argument("--score", action="store_true", help="score what is answered")
    said = words.parse_args()
    labels = written(said.out)
    if said.write:
        return
    file = said.out / "answers.jsonl"
    rows = [json.loads(text) for text in file.read_text(encoding="utf-8").splitlines()] if file.is_file() else []
    answers = {row["key"]: row["said"] for row in rows}
    if not said.score:
        for key in [k for k in range(len(labels)) if k not in answers]:
            answers[key] = asked(said.out / "cases" / f"{key:02d}")
            with file.open("a", encoding="utf-8") as out:
                out.write(json.dumps({"key": key, "said": answers[key]}) + "\n")
            print(
                key,
                answers[key]["status"],
                f"{answers[key]['seconds']:.1f}",
                f"{answers[key]['clock_s']:.1f}",
                flush=True,
            )
    (said.out / "report.md").write_text(page([x for x in labels if x["key"] in answers], answers), encoding="utf-8")


if __name__ == "__main__":
    main()
