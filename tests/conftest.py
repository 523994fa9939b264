"""Which tests run: all but the slow ones, and with --slow those too.

``@pytest.mark.slow`` leaves a test out of the common run, ``@pytest.mark.slow(after=1)`` the cases of a parametrised test behind
the first: each claim keeps a case in the common run unless another test there makes the same claim faster. A test that the
command line names by itself always runs.
"""

from __future__ import annotations

from collections import Counter

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--slow", action="store_true", help="the slow tests too (whole diagnoses, tutorials, more cases of a law)"
    )


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if config.getoption("--slow") or any("::" in arg for arg in config.args):
        return
    seen: Counter[str] = Counter()
    kept, left = [], []
    for item in items:
        mark = item.get_closest_marker("slow")
        test = item.nodeid.split("[")[0]
        seen[test] += 1
        (left if mark is not None and seen[test] > mark.kwargs.get("after", 0) else kept).append(item)
    if left:
        config.hook.pytest_deselected(items=left)
        items[:] = kept
