"""Numbers as a workshop reads them."""

from __future__ import annotations

import pytest

from camrob.report.words import shown_number


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (0.0313, "0.031"),
        (0.0084, "0.0084"),
        (0.00095, "0.00095"),
        (1.0e-9, "1.0e-09"),
        (0.0, "0.0"),
        (0.06, "0.1"),
        (-0.02, "-0.020"),
        (1234.5, "1,234.5"),
    ],
)
def test_small_numbers_are_written_out(value, shown) -> None:
    assert shown_number(value) == shown
