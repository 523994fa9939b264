"""Cases of a family into a folder: `python tests/bench/gap/second_author/make.py dev --first 1 --count 40 --out DIR`."""

from __future__ import annotations

import argparse
import importlib
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("family", choices=["dev", "sealed"])
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--labels", type=Path, help="default: OUT/labels.jsonl")
    told = parser.parse_args()
    family = importlib.import_module(f"gap.second_author.{told.family}").FAMILY
    from gap.second_author.case import case

    told.out.mkdir(parents=True, exist_ok=True)
    with (told.labels or told.out / "labels.jsonl").open("a") as file:
        for seed in range(told.first, told.first + told.count):
            folder = told.out / str(seed)
            folder.mkdir(exist_ok=True)
            file.write(json.dumps(case(family, seed, folder)) + "\n")
            file.flush()


if __name__ == "__main__":
    main()
