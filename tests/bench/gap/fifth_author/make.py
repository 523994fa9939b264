"""Cases into a folder: `make.py dev --first 9001 --count 50 --out DIR --labels FILE`; labels are kept apart from the cases."""

from __future__ import annotations

import argparse
import importlib
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

__all__ = ["main"]


def main():
    """Writes cases of a family, and the labels."""
    from gap.fifth_author.case import case

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("family", choices=["dev", "sealed"])
    parser.add_argument("--first", type=int)
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--labels", type=Path, required=True)
    told = parser.parse_args()
    kind = importlib.import_module(f"gap.fifth_author.{told.family}").KIND
    first = kind.first if told.first is None else told.first
    told.labels.parent.mkdir(parents=True, exist_ok=True)
    with told.labels.open("w") as file:
        for seed in range(first, first + told.count):
            file.write(json.dumps(case(kind, seed, told.out / str(seed))) + "\n")
            file.flush()


if __name__ == "__main__":
    main()
