"""Labels as lines of text, and the digests that hold generator and labels since before the first answer."""

from __future__ import annotations

import hashlib
import json
import sys
from pathlib import Path

HERE = Path(__file__).parent
MODULES = (
    "arms",
    "park",
    "work",
    "wear",
    "odd",
    "orders",
    "orders_poses",
    "orders_runs",
    "orders_odd",
    "likeness",
    "book",
    "tables",
)


def digest(text):
    return hashlib.sha256(text.encode()).hexdigest()


def line(label):
    return json.dumps(label, sort_keys=True)


def generator_digest():
    return digest("\n".join((HERE / f"{m}.py").read_text(encoding="utf-8") for m in MODULES))


def sealed():
    """Name to digest: `generator`, `all`, and each case's number."""
    return dict(row.split() for row in (HERE / "sealed.sha256").read_text(encoding="utf-8").splitlines())


if __name__ == "__main__":  # seal.py LABELS.jsonl, once
    lines = Path(sys.argv[1]).read_text(encoding="utf-8").splitlines()
    rows = [("generator", generator_digest()), ("all", digest("\n".join(lines)))]
    rows += [(str(k), digest(text)) for k, text in enumerate(lines)]
    (HERE / "sealed.sha256").write_text("".join(f"{a} {b}\n" for a, b in rows), encoding="utf-8")
