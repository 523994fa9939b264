"""Labels as lines, and the digests that hold them."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

__all__ = ["MODULES", "digest", "generator_digest", "line", "sealed"]

HERE = Path(__file__).parent
MODULES = [
    "chain",
    "machines",
    "motions",
    "truth",
    "drive_causes",
    "body_causes",
    "reading_causes",
    "table_causes",
    "plan",
    "plan_poses",
    "plan_paths",
    "case",
    "tables",
    "seal",
]


def digest(text: str) -> str:
    """SHA-256."""
    return hashlib.sha256(text.encode()).hexdigest()


def line(label: dict) -> str:
    """A label as it is sealed."""
    return json.dumps(label, sort_keys=True)


def generator_digest() -> str:
    """Of all that makes a case, and of the cells that it reads."""
    cells = [HERE.parents[3] / "cells" / name / "cell.toml" for name in ("kr15_track_table", "irb6700_table")]
    return digest("".join(p.read_text() for p in [*(HERE / f"{m}.py" for m in MODULES), *cells]))


def sealed() -> dict[str, str]:
    """The digests that were fixed: of the generator, of all labels, of each label."""
    return dict(row.split() for row in (HERE / "sealed.sha256").read_text().splitlines())
