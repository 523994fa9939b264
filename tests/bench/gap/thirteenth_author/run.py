"""Writes the cases, asks camrob's command line, one at a time, and scores: ``run.py --out DIR [--write | --score]``."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from gap.thirteenth_author.book import BOOK, SEED, made
from gap.thirteenth_author.scores import page
from gap.thirteenth_author.seal import line
from gap.thirteenth_author.tables import write
from gap.twelfth_author.run import asked


def written(out, seed=SEED):
    """All cases and `sealed/labels.jsonl`, those that are not there yet; the labels."""
    file = out / "sealed" / "labels.jsonl"
    if file.is_file():
        return [json.loads(text) for text in file.read_text(encoding="utf-8").splitlines()]
    labels = []
    for key in range(len(BOOK)):
        case, folder = made(key, seed), out / "cases" / f"{key:02d}"
        logs, held = write(case, folder)
        (folder / "logs.json").write_text(json.dumps({"log": logs, "withheld": held}), encoding="utf-8")
        labels.append(case.label)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("".join(line(label) + "\n" for label in labels), encoding="utf-8")
    return labels


def main():
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("--out", type=Path, required=True)
    words.add_argument("--write", action="store_true", help="write the cases and stop")
    words.add_argument("--score", action="store_true", help="score what is answered")
    told = words.parse_args()
    labels = written(told.out)
    if told.write:
        return
    file = told.out / "answers.jsonl"
    rows = [json.loads(text) for text in file.read_text(encoding="utf-8").splitlines()] if file.is_file() else []
    answers = {row["key"]: row["said"] for row in rows}
    if not told.score:
        for key in [k for k in range(len(labels)) if k not in answers]:
            answers[key] = asked(told.out / "cases" / f"{key:02d}")
            with file.open("a", encoding="utf-8") as out:
                out.write(json.dumps({"key": key, "said": answers[key]}) + "\n")
            print(
                key,
                answers[key]["status"],
                f"{answers[key]['seconds']:.1f}",
                f"{answers[key]['clock_s']:.1f}",
                flush=True,
            )
    (told.out / "report.md").write_text(page([x for x in labels if x["key"] in answers], answers), encoding="utf-8")


if __name__ == "__main__":
    main()
