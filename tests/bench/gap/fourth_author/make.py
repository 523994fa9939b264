"""Cases into a folder: `python tests/bench/gap/fourth_author/make.py --first 1 --count 4 --out DIR --labels FILE`."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

__all__ = ["main"]


def main():
    """Writes cases, and the labels apart from them."""
    from gap.fourth_author.case import case

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--count", type=int, default=4)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--labels", type=Path, required=True, help="kept apart from the cases")
    told = parser.parse_args()
    with told.labels.open("a") as file:
        for seed in range(told.first, told.first + told.count):
            file.write(json.dumps(case(seed, told.out / str(seed))) + "\n")
            file.flush()


if __name__ == "__main__":
    main()
