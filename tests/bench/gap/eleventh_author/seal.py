"""Labels as lines, and the digests that hold them."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

__all__ = ["MODULES", "digest", "generator_digest", "line", "sealed"]

HERE = Path(__file__).parent
MODULES = [
    "robots",
    "fleet",
    "moves",
    "stages",
    "drives",
    "bodies",
    "loads",
    "readings",
    "strangers",
    "plan",
    "shop_poses",
    "shop_more_poses",
    "shop_paths",
    "shop_drives",
    "case",
    "sheets",
    "seal",
]


def digest(text: str) -> str:
    """SHA-256."""
    return hashlib.sha256(text.encode()).hexdigest()


def line(label: dict) -> str:
    """A label as it is sealed."""
    return json.dumps(label, sort_keys=True)


def generator_digest() -> str:
    """Of all that makes a case."""
    return digest("".join((HERE / f"{m}.py").read_text() for m in MODULES))


def sealed() -> dict[str, str]:
    """The digests that were fixed: of the generator, of all labels, of each label."""
    return dict(row.split() for row in (HERE / "sealed.sha256").read_text().splitlines())
