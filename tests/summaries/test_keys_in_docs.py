"""What a JSON file of a verb holds stands in docs/reference/files.md, key by key."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from summary_samples import diagnosis_summary, post_summary, verify_summary

FILES = (Path(__file__).resolve().parents[2] / "docs" / "reference" / "files.md").read_text(encoding="utf-8")
MADE: Mapping[str, Any] = {
    "NAME.json": post_summary,
    "diagnosis.json": diagnosis_summary,
    "What verify prints": verify_summary,
}


@pytest.mark.parametrize("section", MADE)
def test_every_key_is_named(section: str) -> None:
    text = re.split(r"(?m)^## ", FILES.split(f"## {section}\n")[1])[0]
    named = set(re.findall(r"[`\"]([A-Za-z_]+)[`\".]", text))
    assert sorted(set(MADE[section]().to_json()) - named) == []
