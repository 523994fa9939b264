"""Cutting force coefficients by material, for a FORCE.toml that names one: none without a source."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["MATERIALS", "MATERIAL_DOUBT", "Material"]


class Material(NamedTuple):
    """Tangential, radial and axial coefficients: by the chip, N/mm2, and by the edge, N/mm; source: where they stand."""

    chip: tuple[float, float, float]
    edge: tuple[float, float, float]
    source: str


_REVIEW = "doi:10.1186/s10033-021-00536-9, table 5"

MATERIALS = {
    "al6082-t6": Material(
        (631.0, 99.0, 273.0), (13.0, 10.0, 2.8), f"{_REVIEW}, its reference 189: cemented carbide, dry"
    ),
    "al7075-t6": Material(
        (767.01, 168.8, 222.0), (27.7, 26.6, 0.7), f"{_REVIEW}, its reference 190: cemented carbide, dry"
    ),
}
"""A coefficient left out there, or a row whose columns can't be right, is not here: a missing one would pass for zero."""

# what that table's tangential coefficients of Al7075 (600, 767, 951 and 1319 N/mm2) differ by: standard deviation by mean
MATERIAL_DOUBT = 0.34
