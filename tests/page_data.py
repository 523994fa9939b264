"""What a page of camrob's holds: its blocks of data, plain or packed."""

from __future__ import annotations

import base64
import gzip
import json
import re
from typing import Any

__all__ = ["block_of", "unpacked"]


def unpacked(text: str) -> str:
    """The text of a packed block or library."""
    return gzip.decompress(base64.b64decode(text)).decode()


def block_of(page: str, name: str) -> Any:
    """The data of the block with this id."""
    kind, text = re.search(rf'<script type="([^"]+)" id="{name}">([^<]*)</script>', page).groups()
    return json.loads(unpacked(text) if kind == "application/gzip" else text)
